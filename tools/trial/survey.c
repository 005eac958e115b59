/* Surveys: labels, files, and making a survey unless it is stored.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "survey.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const words[TRIAL_KINDS] = {"free", "impacts", "chatter", "held", "irregular", "failed"};
static const char columns[] =
    "value,start,kind,impacts,periods,chaotic,lyapunov,rate,speed,contact,reach,depth";

const char *trial_kind_word(trial_kind kind) {
    return words[kind];
}

void trial_label(const trial_cell *cell, char label[trial_label_max]) {
    if (cell->kind == TRIAL_CHATTER)
        snprintf(label, trial_label_max, "chatter/%d", cell->periods);
    else if (cell->kind == TRIAL_FREE || cell->kind == TRIAL_IMPACTS)
        snprintf(label, trial_label_max, "%d/%d", cell->impacts, cell->periods);
    else
        snprintf(label, trial_label_max, "%s", words[cell->kind]);
}

static void survey_path(const trial_survey *survey, const trial_request *request, char *path, size_t size) {
    char method[32] = "exact";
    if (survey->h > 0)
        snprintf(method, sizeof method, "naive-%g", survey->h);
    snprintf(path, size, "%s/figure%s-%s%s.csv", request->keep, survey->figure->name, method,
             request->quick ? "-quick" : "");
}

static saltus_status write_survey(const trial_survey *survey, const char *path, saltus_message *message) {
    FILE *file = fopen(path, "w");
    if (!file)
        return saltus_fail(message, SALTUS_IO, "cannot write %s", path);
    fprintf(file, "# saltus %s, %d values\n%s\n", SALTUS_VERSION, survey->values, columns);
    for (int k = 0; k < survey->values * trial_starts; k++) {
        const trial_cell *c = &survey->cells[k];
        fprintf(file, "%.17g,%d,%s,%d,%d,%d,%.8g,%.8g,%.8g,%.8g,%.8g,%.8g\n", c->value, c->start,
                words[c->kind], c->impacts, c->periods, c->chaotic, c->lyapunov, c->rate, c->speed,
                c->contact, c->reach, c->depth);
    }
    bool bad = ferror(file);
    return fclose(file) || bad ? saltus_fail(message, SALTUS_IO, "cannot write %s", path) : SALTUS_OK;
}

static bool read_cell(FILE *file, trial_cell *c) {
    char word[16];
    int chaotic;
    if (fscanf(file, "%lf,%d,%15[a-z],%d,%d,%d,%lf,%lf,%lf,%lf,%lf,%lf\n", &c->value, &c->start, word,
               &c->impacts, &c->periods, &chaotic, &c->lyapunov, &c->rate, &c->speed, &c->contact, &c->reach,
               &c->depth) != 12)
        return false;
    c->chaotic = chaotic;
    int kind = 0;
    while (kind < TRIAL_KINDS && strcmp(word, words[kind]) != 0)
        kind++;
    c->kind = (trial_kind)kind;
    return kind < TRIAL_KINDS;
}

/* Whether the file holds this survey, made by this version. */
static bool read_survey(trial_survey *survey, const char *path) {
    char version[32], names[sizeof columns + 1];
    int values = 0;
    FILE *file = fopen(path, "r");
    if (!file)
        return false;
    bool read = fscanf(file, "# saltus %31[^,], %d values\n", version, &values) == 2 &&
                fgets(names, sizeof names, file) && values == survey->values &&
                strcmp(version, SALTUS_VERSION) == 0 && strncmp(names, columns, sizeof columns - 1) == 0;
    for (int k = 0; k < values * trial_starts && read; k++)
        read = read_cell(file, &survey->cells[k]);
    fclose(file);
    return read;
}

void trial_survey_clear(trial_survey *survey) {
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

saltus_status trial_survey_get(const trial_figure *figure, double h, const trial_request *request,
                               trial_survey *survey, saltus_message *message) {
    char path[512] = "";
    saltus_status status = open_survey(figure, h, request, survey, message);
    if (status != SALTUS_OK)
        return status;
    if (request->keep) {
        survey_path(survey, request, path, sizeof path);
        if (read_survey(survey, path))
            return SALTUS_OK;
        trial_survey_clear(survey);
        status = open_survey(figure, h, request, survey, message);
    }
    if (status == SALTUS_OK)
        status = h > 0 ? trial_survey_naive(survey, message) : trial_survey_exact(survey, message);
    if (status == SALTUS_OK && request->keep)
        status = write_survey(survey, path, message);
    if (status != SALTUS_OK)
        trial_survey_clear(survey);
    return status;
}
