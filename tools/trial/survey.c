/* Surveys: the ranges of the figures, initial states that do not depend on the parameter varied, and the
 * trajectories from them by the event-driven flow, or, for comparison, by the naive method: NOT FOR USE.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "trial.h"

#include "naive/naive_class.h"

#include <gsl/gsl_randist.h>
#include <math.h>
#include <string.h>

enum { periods_at_most = 500, periods_measured = 2000 };
/* Of the naive method; regular transients decay in time, at the damping rate of the first mode, chaotic ones
 * in periods. */
enum { settling_periods = 50 };
static const double settling_time = 40;
static const double displacement_unit = 0.03; /* unit for distances between section points */

const double trial_h[trial_steps] = {0, 0.01, 0.005, 0.001, 0.0002};
const char *const trial_kind_words[TRIAL_KINDS] = {"free", "impacts",   "chatter",
                                                   "held", "irregular", "failed"};

const trial_figure trial_figure_list[trial_figures] = {
    {"2", "fig2", NULL, "omega", 0.1, 550, 5, 10, NAN},
    {"4a", "fig4a", NULL, "d", 0.0002, 230, 5, 10, 0},
    {"4b", "fig4b", NULL, "d", 0.0002, 230, 5, 10, 0},
    {"5", "fig5", NULL, "omega", 0.1, 550, 5, 10, 0.03},
    {"6", "fig6", NULL, "omega", 0.1, 550, 5, 10, 0.035},
    {"8a", "fig8", "r=0.8", "omega", 0.2, 275, 5, 5, 0.035},
    {"8b", "fig8", "r=0.7", "omega", 0.2, 275, 5, 5, 0.035},
    {"8c", "fig8", "r=0.6", "omega", 0.2, 275, 5, 5, 0.035},
};

const trial_figure *trial_figure_find(const char *name) {
    const trial_figure *figure = trial_figure_list;
    while (strcmp(figure->name, name) != 0)
        figure++;
    return figure;
}

void trial_label(const trial_cell *cell, char label[trial_label_max]) {
    if (cell->kind == TRIAL_CHATTER)
        snprintf(label, trial_label_max, "chatter/%d", cell->periods);
    else if (cell->kind == TRIAL_FREE || cell->kind == TRIAL_IMPACTS)
        snprintf(label, trial_label_max, "%d/%d", cell->impacts, cell->periods);
    else
        snprintf(label, trial_label_max, "%s", trial_kind_words[cell->kind]);
}

void trial_tally_add(trial_tally *tally, const char *label) {
    struct trial_count *of = tally->of;
    int k = 0;
    while (k < tally->kinds && strcmp(of[k].label, label) != 0)
        k++;
    if (k == (int)(sizeof tally->of / sizeof *tally->of))
        return;
    if (k == tally->kinds)
        snprintf(of[tally->kinds++].label, sizeof of->label, "%s", label);
    of[k].count++;
    tally->all++;
    for (; k > 0 && of[k].count > of[k - 1].count; k--) {
        const struct trial_count more = of[k];
        of[k] = of[k - 1];
        of[k - 1] = more;
    }
}

/* A random state within the clearance on the side of the stops. */
static void draw(const saltus_system *system, gsl_rng *rng, double clearance, bool both, double *state) {
    const double *scale = saltus_system_scale(system), *observer = saltus_system_observer(system);
    double g;
    do {
        g = 0;
        for (int i = 0; i < saltus_system_dimension(system); i++)
            state[i] = gsl_ran_gaussian(rng, scale[i]);
        for (int i = 0; i < saltus_system_dof(system); i++)
            g += observer[i] * state[i];
    } while (g > clearance || (both && -g > clearance));
}

void trial_draw_starts(const saltus_scene *scene, double clearance, unsigned long seed, double *states) {
    const bool both = scene->spec.stop_count && scene->spec.stops[0].sides == SALTUS_BOTH;
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937); /* ends the program without memory */
    saltus_system *system = NULL;
    saltus_message message = {.text = ""};
    must(saltus_system_new(&scene->spec, &system, &message), &message);
    must(saltus_system_default_state(system, states, &message), &message);
    gsl_rng_set(rng, seed);
    for (int k = 1; k < trial_starts; k++)
        draw(system, rng, isnan(clearance) ? INFINITY : clearance, both,
             states + k * saltus_system_dimension(system));
    /* A default state pressed onto the stop would not be admissible at all clearances. */
    if (clearance <= 0)
        draw(system, rng, clearance, both, states);
    gsl_rng_free(rng);
    saltus_system_free(system);
}

static trial_kind kind_of(bool failed, bool held, bool settled, bool chatter, int impacts) {
    return failed     ? TRIAL_FAILED
           : held     ? TRIAL_HELD
           : !settled ? TRIAL_IRREGULAR
           : chatter  ? TRIAL_CHATTER
           : impacts  ? TRIAL_IMPACTS
                      : TRIAL_FREE;
}

/* `context` is the first value's cell of the sweep's start. */
static saltus_status take(void *context, const saltus_sweep_result *result, saltus_message *message) {
    const saltus_sweep_row *row = result->rows;
    const bool settled = row->verdict == SALTUS_PERIODIC || row->verdict == SALTUS_EQUILIBRIUM;
    trial_cell *cell = (trial_cell *)context + result->place * trial_starts;
    (void)message;
    cell->kind = kind_of(saltus_verdict_nothing((saltus_verdict)row->verdict), row->verdict == SALTUS_HELD,
                         settled, row->impacts < 0 || row->sticking > 0, row->impacts);
    cell->impacts = row->impacts;
    cell->periods = row->periods;
    cell->chaotic = row->verdict == SALTUS_CHAOTIC;
    cell->lyapunov = row->lyapunov;
    cell->rate = row->impact_rate;
    cell->contact = cell->kind == TRIAL_HELD ? 1 : row->contact_fraction;
    cell->reach = fmax(fabs(row->largest), fabs(row->smallest));
    return SALTUS_OK;
}

/* One sweep for each start. */
static void survey_exact(trial_survey *survey, saltus_scene *scene, const double *states) {
    double *values = must_allocate((size_t)survey->values, sizeof *values);
    saltus_message message = {.text = ""};
    saltus_sweep_options options = saltus_sweep_defaults();
    for (int k = 0; k < survey->values; k++)
        values[k] = survey->cells[k * trial_starts].value;
    saltus_axis axis = {.spacing = SALTUS_LIST,
                        .count = survey->values,
                        .low = values[0],
                        .high = values[survey->values - 1],
                        .list = values};
    snprintf(axis.key, sizeof axis.key, "%s", survey->figure->key);
    options.keep = SALTUS_KEEP_LYAPUNOV;
    options.transient = periods_at_most;
    options.measure = periods_measured;
    scene->initial_count = 2 * (int)saltus_spec_get(&scene->spec, "N");
    for (int start = 0; start < trial_starts; start++) {
        const saltus_sweep_feed feed = {.context = survey->cells + start, .take = take};
        saltus_sweep *sweep = NULL;
        memcpy(scene->initial, states + start * scene->initial_count,
               (size_t)scene->initial_count * sizeof *states);
        must(saltus_sweep_new(scene, &axis, 1, &options, &sweep, &message), &message);
        must(saltus_sweep_run(sweep, &feed, &message), &message);
        saltus_sweep_free(sweep);
    }
    free(values);
}

_Static_assert((int)naive_lanes == (int)trial_starts, "a pack of lanes is a value's starts");

/* All starts at one value by the naive method. */
static saltus_status run_naive(trial_cell *cells, const saltus_scene *scene, const char *key, double h,
                               const double *states, saltus_message *message) {
    saltus_scene there = *scene;
    naive_pipe pipe;
    naive_class classes[naive_lanes];
    char assignment[64];
    snprintf(assignment, sizeof assignment, "%s=%.17g", key, cells->value);
    saltus_status status = saltus_scene_set(&there, assignment, message);
    if (status != SALTUS_OK)
        return status;
    if (!naive_pipe_from(&there.spec, &pipe))
        return saltus_fail(message, SALTUS_BAD_INPUT, "the naive method cannot describe %s", scene->name);
    int warm = (int)fmax(settling_periods, ceil(settling_time * pipe.omega / (2 * acos(-1))));
    naive_classify(&pipe, h, false, states, warm, displacement_unit, classes);
    for (int l = 0; l < trial_starts; l++, cells++) {
        const naive_class *class = &classes[l];
        cells->kind =
            kind_of(!class->finite, class->held, class->periods > 0, class->impacts < 0, class->impacts);
        cells->impacts = class->impacts;
        cells->periods = class->periods;
        cells->lyapunov = NAN;
        cells->rate = class->rate;
        cells->contact = class->contact;
        cells->depth = class->deepest;
        for (int w = 0; w <= naive_watched; w++)
            cells->reach = fmax(cells->reach, fabs(class->points[w][0]));
    }
    return SALTUS_OK;
}

const trial_survey *trial_survey_of(trial_bench *bench, const char *name, int step) {
    const trial_figure *figure = trial_figure_find(name);
    trial_survey *survey = &bench->surveys[figure - trial_figure_list][step];
    const int stride = (bench->quick ? figure->quick : 1) * (step > 0 ? figure->sparse : 1);
    double states[trial_starts * SALTUS_SCENE_STATE_MAX];
    saltus_scene scene;
    saltus_message message = {.text = ""};
    if (survey->cells)
        return survey;
    *survey = (trial_survey){.figure = figure, .values = figure->count / stride};
    survey->cells = must_allocate((size_t)survey->values * trial_starts, sizeof *survey->cells);
    for (int k = 0; k < survey->values * trial_starts; k++)
        survey->cells[k].value = (double)(stride * (k / trial_starts + 1)) / round(1 / figure->step);
    must(saltus_scene_load(figure->scene, &scene, &message), &message);
    if (figure->setting)
        must(saltus_scene_set(&scene, figure->setting, &message), &message);
    trial_draw_starts(&scene, figure->admissible, 1, states);
    if (step == 0) {
        survey_exact(survey, &scene, states);
        return survey;
    }
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic)
#endif
    for (int k = 0; k < survey->values; k++) {
        saltus_message reason = {.text = ""};
        must(run_naive(survey->cells + k * trial_starts, &scene, figure->key, trial_h[step], states, &reason),
             &reason);
    }
    return survey;
}

void trial_bench_clear(trial_bench *bench) {
    for (int k = 0; k < trial_figures * trial_steps; k++)
        free(bench->surveys[k / trial_steps][k % trial_steps].cells);
}
