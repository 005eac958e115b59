/* Surveys: labels, files, making a survey unless it is stored, and those shared by several claims.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "claims.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const trial_kind_words[TRIAL_KINDS] = {"free", "impacts",   "chatter",
                                                   "held", "irregular", "failed"};
static const char columns[] =
    "value,start,kind,impacts,periods,chaotic,lyapunov,rate,speed,contact,reach,depth";

void trial_label(const trial_cell *cell, char label[trial_label_max]) {
    if (cell->kind == TRIAL_CHATTER)
        snprintf(label, trial_label_max, "chatter/%d", cell->periods);
    else if (cell->kind == TRIAL_FREE || cell->kind == TRIAL_IMPACTS)
        snprintf(label, trial_label_max, "%d/%d", cell->impacts, cell->periods);
    else
        snprintf(label, trial_label_max, "%s", trial_kind_words[cell->kind]);
}

/* Whether the file holds this survey. */
static bool read_survey(trial_survey *survey, FILE *file) {
    char names[sizeof columns + 1], word[16];
    int values = 0, chaotic, kind = 0;
    bool read = fscanf(file, "%d values\n", &values) == 1 && fgets(names, sizeof names, file) &&
                values == survey->values && strncmp(names, columns, sizeof columns - 1) == 0;
    for (int k = 0; k < values * trial_starts && read; k++) {
        trial_cell *c = &survey->cells[k];
        read = fscanf(file, "%lf,%d,%15[a-z],%d,%d,%d,%lf,%lf,%lf,%lf,%lf,%lf\n", &c->value, &c->start, word,
                      &c->impacts, &c->periods, &chaotic, &c->lyapunov, &c->rate, &c->speed, &c->contact,
                      &c->reach, &c->depth) == 12;
        for (kind = 0; read && kind < TRIAL_KINDS && strcmp(word, trial_kind_words[kind]) != 0;)
            kind++;
        read = read && kind < TRIAL_KINDS;
        c->chaotic = read && chaotic;
        c->kind = (trial_kind)kind;
    }
    fclose(file);
    return read;
}

static void clear_survey(trial_survey *survey) {
    free(survey->cells);
    *survey = (trial_survey){0};
}

static saltus_status open_survey(const trial_figure *figure, double h, const trial_request *request,
                                 trial_survey *survey, saltus_message *message) {
    int stride = (request->quick ? figure->quick : 1) * (h > 0 ? figure->sparse : 1);
    *survey = (trial_survey){.figure = figure, .h = h, .values = figure->count / stride};
    survey->cells = calloc((size_t)survey->values * trial_starts, sizeof *survey->cells);
    if (!survey->cells)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a survey");
    for (int k = 0; k < survey->values * trial_starts; k++) {
        survey->cells[k].value = (double)(stride * (k / trial_starts + 1)) / round(1 / figure->step);
        survey->cells[k].start = k % trial_starts;
    }
    return SALTUS_OK;
}

static void keep_path(const trial_request *request, const char *name, char *path, size_t size) {
    snprintf(path, size, "%s/%s%s.txt", request->keep, name, request->quick ? "-quick" : "");
}

FILE *trial_kept(const trial_request *request, const char *name) {
    char path[512], version[32] = "";
    if (!request->keep)
        return NULL;
    keep_path(request, name, path, sizeof path);
    FILE *file = fopen(path, "r");
    if (!file)
        return NULL;
    if (fscanf(file, "saltus %31[^\n]", version) == 1 && fgetc(file) == '\n' &&
        strcmp(version, SALTUS_VERSION) == 0)
        return file;
    fclose(file);
    return NULL;
}

saltus_status trial_keep(const trial_request *request, const char *name, FILE *stream,
                         saltus_message *message) {
    bool good = stream && !ferror(stream);
    if (good)
        rewind(stream);
    if (good && request->keep) {
        char path[512];
        keep_path(request, name, path, sizeof path);
        FILE *file = fopen(path, "w");
        good = file && fprintf(file, "saltus %s\n", SALTUS_VERSION) > 0;
        for (int c; good && (c = fgetc(stream)) != EOF;)
            fputc(c, file);
        good = good && !ferror(stream) && !ferror(file);
        good = !(file && fclose(file)) && good;
        rewind(stream);
    }
    return good ? SALTUS_OK
                : saltus_fail(message, SALTUS_IO, "cannot keep %s in %s", name,
                              request->keep ? request->keep : "a temporary file");
}

/* Read a survey from the folder, or make and store it. h = 0: the event-driven flow. */
static saltus_status get_survey(const trial_figure *figure, double h, const trial_request *request,
                                trial_survey *survey, saltus_message *message) {
    char name[64];
    snprintf(name, sizeof name, h > 0 ? "figure%s-naive-%g" : "figure%s-exact", figure->name, h);
    saltus_status status = open_survey(figure, h, request, survey, message);
    FILE *kept = status == SALTUS_OK ? trial_kept(request, name) : NULL;
    if (kept && read_survey(survey, kept))
        return SALTUS_OK;
    if (kept) {
        clear_survey(survey);
        status = open_survey(figure, h, request, survey, message);
    }
    if (status == SALTUS_OK)
        status = h > 0 ? trial_survey_naive(survey, message) : trial_survey_exact(survey, message);
    if (status == SALTUS_OK && request->keep) {
        FILE *stream = tmpfile();
        if (stream)
            fprintf(stream, "%d values\n%s\n", survey->values, columns);
        for (int k = 0; k < survey->values * trial_starts && stream; k++) {
            const trial_cell *c = &survey->cells[k];
            fprintf(stream, "%.17g,%d,%s,%d,%d,%d,%.8g,%.8g,%.8g,%.8g,%.8g,%.8g\n", c->value, c->start,
                    trial_kind_words[c->kind], c->impacts, c->periods, c->chaotic, c->lyapunov, c->rate,
                    c->speed, c->contact, c->reach, c->depth);
        }
        status = trial_keep(request, name, stream, message);
        if (stream)
            fclose(stream);
    }
    if (status != SALTUS_OK)
        clear_survey(survey);
    return status;
}

const double trial_coarse[trial_coarse_steps] = {0.01, 0.005, 0.001, 0.0002};

saltus_status trial_bench_survey(trial_bench *bench, const char *figure, int step,
                                 const trial_survey **survey, saltus_message *message) {
    const trial_figure *there = trial_figure_find(figure);
    if (!there)
        return saltus_fail(message, SALTUS_BAD_INPUT, "no figure %s", figure);
    const long k = there - trial_figure_list;
    trial_survey *wanted = step < 0 ? &bench->exact[k] : &bench->naive[k][step];
    *survey = wanted;
    return wanted->cells
               ? SALTUS_OK
               : get_survey(there, step < 0 ? 0 : trial_coarse[step], &bench->request, wanted, message);
}

void trial_bench_clear(trial_bench *bench) {
    for (int k = 0; k < trial_figures; k++) {
        clear_survey(&bench->exact[k]);
        for (int s = 0; s < trial_coarse_steps; s++)
            clear_survey(&bench->naive[k][s]);
    }
}
