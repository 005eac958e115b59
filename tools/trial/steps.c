/* The naive method at d = 0.03, omega = 43, where the only attractor is a stable 3/5 orbit: NOT FOR USE.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "trial.h"

#include "naive/naive_class.h"

#include <math.h>
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

static stage set_stage(void) {
    const saltus_classify_options options = saltus_classify_defaults();
    saltus_scene scene;
    saltus_system *system = NULL;
    saltus_message message = {.text = ""};
    stage s;
    must(saltus_scene_load(scene_name, &scene, &message), &message);
    if (!naive_pipe_from(&scene.spec, &s.pipe))
        must(saltus_fail(&message, SALTUS_BAD_INPUT, "the naive method cannot describe %s", scene_name),
             &message);
    must(saltus_system_new(&scene.spec, &system, &message), &message);
    s.dimension = saltus_system_dimension(system);
    s.period = saltus_system_period(system);
    s.states = must_allocate((size_t)(starts * s.dimension), sizeof *s.states);
    for (int b = 0; b < batches; b++)
        trial_draw_starts(&scene, scene.spec.stops[0].d, (unsigned long)b + 1,
                          s.states + b * naive_lanes * s.dimension);
    must(saltus_classify(system, s.states, &options, &s.orbit, &message), &message);
    saltus_system_free(system);
    return s;
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
    trial_tally labels;
    int right, claimed; /* exact: as the exact orbit; claimed: four impacts in five periods or a multiple */
    double least_rate, most_rate, deepest, distance;
} outcome;

static void count(const stage *s, const naive_class *class, outcome *o) {
    char label[trial_label_max];
    if (!class->finite)
        snprintf(label, sizeof label, "grows without bound");
    else if (class->periods == 0)
        snprintf(label, sizeof label, "no period");
    else if (class->impacts < 0)
        snprintf(label, sizeof label, "chatter/%d", class->periods);
    else
        snprintf(label, sizeof label, "%d/%d", class->impacts, class->periods);
    trial_tally_add(&o->labels, label);
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
    for (int k = 0; k < o->labels.kinds && k < most; k++)
        fprintf(file, "%s%s (%d)", k ? between : "", o->labels.of[k].label, o->labels.of[k].count);
    if (o->labels.kinds > most)
        fprintf(file, "%s%d others", between, o->labels.kinds - most);
}

void trial_write_steps(FILE *table, FILE *rows, bool quick) {
    enum { step_count = sizeof steps / sizeof steps[0] };
    static outcome all[step_count][2]; /* fractions of 1, of the period */
    stage s = set_stage();
    int made = 0;
    while (made < step_count && !(quick && steps[made] < finest_quick))
        made++;
    fprintf(table,
            "| step h | steps per T | 3/5 | 4/5 | classes (of %d starts) | impacts per period | "
            "deepest / d | section points off / d | classes, h dividing T |\n| --- | --- | --- | --- "
            "| --- | --- | --- | --- | --- |\n",
            (int)starts);
    for (int k = 0; k < made; k++) {
        outcome *plain = &all[k][0], *dividing = &all[k][1];
        naive_class classes[2 * starts];
        plain->least_rate = dividing->least_rate = INFINITY;
#ifdef _OPENMP
#pragma omp parallel for
#endif
        for (int b = 0; b < 2 * batches; b++)
            naive_classify(&s.pipe, steps[k], b >= batches,
                           s.states + b % batches * naive_lanes * s.dimension, warm, s.pipe.d,
                           classes + b * naive_lanes);
        for (int c = 0; c < 2 * starts; c++)
            count(&s, &classes[c], c < starts ? plain : dividing);
        fprintf(table, "| %g | %.0f | %d | %d | ", steps[k], s.period / steps[k], plain->right,
                plain->claimed);
        write_names(table, plain, ", ", names_shown);
        fprintf(table, " | %.2f to %.2f | %.1e | %.1e | ", plain->least_rate, plain->most_rate,
                plain->deepest / s.pipe.d, plain->distance / s.pipe.d);
        write_names(table, dividing, ", ", names_shown);
        fprintf(table, " |\n");
        fflush(table);
    }
    fprintf(table, "| exact | - | all | 0 | %s | %.2f | 0 | 0 | |\n", s.orbit.label,
            (double)s.orbit.impacts / s.orbit.periods);
    fprintf(rows, "%sh,step,starts,right,claimed,least_rate,most_rate,deepest,distance,classes\n",
            rows == table ? "\n" : "");
    for (int k = 0; k < 2 * made; k++) {
        const outcome *o = &all[k / 2][k % 2];
        fprintf(rows, "%g,%s,%d,%d,%d,%g,%g,%g,%g,", steps[k / 2], k % 2 ? "divides T" : "fraction of 1",
                (int)starts, o->right, o->claimed, o->least_rate, o->most_rate, o->deepest, o->distance);
        write_names(rows, o, " ", starts);
        fprintf(rows, "\n");
    }
    clear_stage(&s);
}

void trial_write_step_points(FILE *file, bool quick) {
    stage s = set_stage();
    const int count = (int)ceil(per_decade * log10(coarsest / (quick ? finest_quick : finest)));
    naive_class *classes = must_allocate((size_t)(count + 1) * naive_lanes, sizeof *classes);
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic)
#endif
    for (int k = count; k >= 0; k--)
        naive_classify(&s.pipe, coarsest * pow(10, -(double)k / per_decade), false, s.states, warm_of_points,
                       s.pipe.d, classes + (size_t)k * naive_lanes);
    fprintf(file, "# step, displacement at the stop at phase 0, impacts per period\n");
    for (int k = 0; k < (count + 1) * naive_lanes; k++)
        for (int p = 0; p <= naive_watched && classes[k].finite; p++)
            fprintf(file, "%.6g %.6g %.6g\n", coarsest * pow(10, -(double)(k / naive_lanes) / per_decade),
                    classes[k].points[p][0], classes[k].rate);
    fprintf(file, "\n\n# the exact orbit\n");
    for (int k = 0; k < s.orbit.periods; k++)
        fprintf(file, "0 %.6g %.6g\n", exact_point(&s, k), (double)s.orbit.impacts / s.orbit.periods);
    free(classes);
    clear_stage(&s);
}
