/* The naive method at d = 0.03, omega = 43, where the only attractor is a stable 3/5 orbit: NOT FOR USE.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "claims.h"
#include "naive/naive_class.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { batches = 3, starts = batches * naive_lanes, warm = 300, warm_of_points = 150, per_decade = 30 };
static const char scene_name[] = "fig7b";
enum { claimed_impacts = 4, claimed_periods = 5, names_shown = 4 };
static const double steps[] = {0.02, 0.01, 0.005, 0.002, 0.0015, 0.001, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5};
static const double coarsest = 0.02, finest = 1e-5, finest_quick = 1e-4;

/* The scene with everything needed to run it. */
typedef struct stage {
    naive_pipe pipe;
    int dimension;
    double *states;      /* starts x dimension */
    saltus_motion orbit; /* the true attractor */
    double period;
} stage;

static saltus_status set_stage(stage *s, saltus_message *message) {
    saltus_classify_options options = saltus_classify_defaults();
    saltus_scene scene;
    saltus_system *system = NULL;
    *s = (stage){0};
    saltus_status status = saltus_scene_load(scene_name, &scene, message);
    if (status == SALTUS_OK && !naive_pipe_from(&scene.spec, &s->pipe))
        status = saltus_fail(message, SALTUS_BAD_INPUT, "the naive method cannot describe %s", scene_name);
    if (status == SALTUS_OK)
        status = saltus_system_new(&scene.spec, &system, message);
    if (status == SALTUS_OK) {
        s->dimension = saltus_system_dimension(system);
        s->period = saltus_system_period(system);
        s->states = calloc((size_t)(starts * s->dimension), sizeof *s->states);
        status = s->states ? SALTUS_OK : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for starts");
    }
    for (int b = 0; b < batches && status == SALTUS_OK; b++)
        status = trial_draw_starts(&scene, scene.spec.stops[0].d, (unsigned long)b + 1,
                                   s->states + b * naive_lanes * s->dimension, message);
    if (status == SALTUS_OK)
        status = saltus_classify(system, s->states, &options, &s->orbit, message);
    saltus_system_free(system);
    return status;
}

static void clear_stage(stage *s) {
    free(s->states);
    saltus_motion_clear(&s->orbit);
}

static double exact_point(const stage *s, int k) {
    double g = 0;
    for (int i = 0; i < s->pipe.modes; i++)
        g += s->pipe.normal[i] * s->orbit.section_states[k * s->dimension + i];
    return g;
}

/* Results over all starts: labels by frequency, and ranges of measures. */
typedef struct outcome {
    char labels[starts][trial_label_max];
    int counts[starts], kinds, right,
        claimed; /* exact: as the exact orbit; claimed: four impacts in five periods or a multiple */
    double least_rate, most_rate, deepest, distance;
} outcome;

static void count(const stage *s, const naive_class *class, outcome *o) {
    char label[trial_label_max];
    int k = 0;
    if (!class->finite)
        snprintf(label, sizeof label, "grows without bound");
    else if (class->periods == 0)
        snprintf(label, sizeof label, "no period");
    else if (class->impacts < 0)
        snprintf(label, sizeof label, "chatter/%d", class->periods);
    else
        snprintf(label, sizeof label, "%d/%d", class->impacts, class->periods);
    while (k < o->kinds && strcmp(o->labels[k], label) != 0)
        k++;
    if (k == o->kinds)
        memcpy(o->labels[o->kinds++], label, sizeof label);
    o->counts[k]++;
    for (; k > 0 && o->counts[k] > o->counts[k - 1]; k--) {
        char moved[trial_label_max];
        int number = o->counts[k];
        memcpy(moved, o->labels[k], sizeof moved);
        memcpy(o->labels[k], o->labels[k - 1], sizeof moved);
        memcpy(o->labels[k - 1], moved, sizeof moved);
        o->counts[k] = o->counts[k - 1];
        o->counts[k - 1] = number;
    }
    o->right += strcmp(label, s->orbit.label) == 0;
    o->claimed += class->periods > 0 && claimed_periods * class->impacts == claimed_impacts * class->periods;
    o->least_rate = fmin(o->least_rate, class->rate);
    o->most_rate = fmax(o->most_rate, class->rate);
    o->deepest = fmax(o->deepest, class->deepest);
    /* From the section points to the nearest ones of the exact orbit. */
    for (int w = 0; w <= naive_watched && class->finite; w++) {
        double nearest = INFINITY;
        for (int p = 0; p < s->orbit.periods; p++)
            nearest = fmin(nearest, fabs(class->points[w][0] - exact_point(s, p)));
        o->distance = fmax(o->distance, nearest);
    }
    if (!class->finite)
        o->distance = INFINITY;
}

static void write_names(FILE *file, const outcome *o, const char *between, int most) {
    for (int k = 0; k < o->kinds && k < most; k++)
        fprintf(file, "%s%s (%d)", k ? between : "", o->labels[k], o->counts[k]);
    if (o->kinds > most)
        fprintf(file, "%s%d others", between, o->kinds - most);
}

/* The table's line and the rows of one step, stored or computed, in this order. */
static saltus_status write_step(FILE *table, FILE *rows, const stage *s, double h,
                                const trial_request *request, saltus_message *message) {
    char kept_name[64];
    snprintf(kept_name, sizeof kept_name, "naive-step-%g", h);
    FILE *lines = trial_kept(request, kept_name), *made = lines ? NULL : tmpfile(), *to = table;
    if (made) {
        naive_class classes[2 * starts];
        outcome plain = {.least_rate = INFINITY}, dividing = plain;
#ifdef _OPENMP
#pragma omp parallel for
#endif
        for (int b = 0; b < 2 * batches; b++)
            naive_classify(&s->pipe, h, b >= batches, s->states + b % batches * naive_lanes * s->dimension,
                           warm, s->pipe.d, classes + b * naive_lanes);
        for (int k = 0; k < 2 * starts; k++)
            count(s, &classes[k], k < starts ? &plain : &dividing);
        fprintf(made, "| %g | %.0f | %d | %d | ", h, s->period / h, plain.right, plain.claimed);
        write_names(made, &plain, ", ", names_shown);
        fprintf(made, " | %.2f to %.2f | %.1e | %.1e | ", plain.least_rate, plain.most_rate,
                plain.deepest / s->pipe.d, plain.distance / s->pipe.d);
        write_names(made, &dividing, ", ", names_shown);
        fprintf(made, " |\n");
        for (int d = 0; d < 2; d++) {
            const outcome *o = d ? &dividing : &plain;
            fprintf(made, "%g,%s,%d,%d,%d,%g,%g,%g,%g,", h, d ? "divides T" : "fraction of 1", (int)starts,
                    o->right, o->claimed, o->least_rate, o->most_rate, o->deepest, o->distance);
            write_names(made, o, " ", starts);
            fprintf(made, "\n");
        }
        lines = made;
    }
    if (!lines || (made && trial_keep(request, kept_name, made, NULL) != SALTUS_OK)) {
        if (lines)
            fclose(lines);
        return saltus_fail(message, SALTUS_IO, "cannot keep the step %g", h);
    }
    for (int c; (c = fgetc(lines)) != EOF;) {
        fputc(c, to);
        to = c == '\n' ? rows : to;
    }
    fclose(lines);
    fflush(table);
    return SALTUS_OK;
}

saltus_status trial_write_steps(FILE *table, FILE *rows, const trial_request *request,
                                saltus_message *message) {
    stage s;
    saltus_status status = set_stage(&s, message);
    if (status == SALTUS_OK) {
        fprintf(table,
                "| step h | steps per T | 3/5 | 4/5 | classes (of %d starts) | impacts per period | "
                "deepest / d | section points off / d | classes, h dividing T |\n| --- | --- | --- | --- "
                "| --- | --- | --- | --- | --- |\n",
                (int)starts);
        fprintf(rows, "h,step,starts,right,claimed,least_rate,most_rate,deepest,distance,classes\n");
    }
    for (int k = 0; k < (int)(sizeof steps / sizeof steps[0]) && status == SALTUS_OK; k++) {
        if (request->quick && steps[k] < finest_quick)
            break;
        status = write_step(table, rows, &s, steps[k], request, message);
    }
    if (status == SALTUS_OK)
        fprintf(table, "| exact | - | all | 0 | %s | %.2f | 0 | 0 | |\n", s.orbit.label,
                (double)s.orbit.impacts / s.orbit.periods);
    clear_stage(&s);
    return status;
}

saltus_status trial_write_step_points(FILE *file, bool quick, saltus_message *message) {
    stage s;
    saltus_status status = set_stage(&s, message);
    int count = (int)ceil(per_decade * log10(coarsest / (quick ? finest_quick : finest)));
    naive_class *classes = calloc((size_t)(count + 1) * naive_lanes, sizeof *classes);
    if (status == SALTUS_OK && !classes)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for section points");
    if (status == SALTUS_OK) {
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic)
#endif
        for (int k = count; k >= 0; k--)
            naive_classify(&s.pipe, coarsest * pow(10, -(double)k / per_decade), false, s.states,
                           warm_of_points, s.pipe.d, classes + (size_t)k * naive_lanes);
        fprintf(file, "# step, displacement at the stop at phase 0, impacts per period\n");
        for (int k = 0; k < (count + 1) * naive_lanes; k++)
            for (int p = 0; p <= naive_watched && classes[k].finite; p++)
                fprintf(file, "%.6g %.6g %.6g\n", coarsest * pow(10, -(double)(k / naive_lanes) / per_decade),
                        classes[k].points[p][0], classes[k].rate);
        fprintf(file, "\n\n# the exact orbit\n");
        for (int k = 0; k < s.orbit.periods; k++)
            fprintf(file, "0 %.6g %.6g\n", exact_point(&s, k), (double)s.orbit.impacts / s.orbit.periods);
    }
    free(classes);
    clear_stage(&s);
    return status;
}
