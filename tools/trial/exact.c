/* Surveys by the event-driven flow: one sweep for each start.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "survey.h"

#include <math.h>
#include <stdlib.h>

enum { periods_at_most = 500, periods_measured = 2000 };

/* `context` is the first value's cell of the sweep's start. */
static saltus_status take(void *context, const saltus_sweep_result *result, saltus_message *message) {
    const saltus_sweep_row *row = result->rows;
    const bool settled = row->verdict == SALTUS_PERIODIC || row->verdict == SALTUS_EQUILIBRIUM;
    trial_cell *cell = (trial_cell *)context + result->place * trial_starts;
    (void)message;
    cell->kind = row->verdict == SALTUS_HELD                            ? TRIAL_HELD
                 : saltus_verdict_nothing((saltus_verdict)row->verdict) ? TRIAL_FAILED
                 : !settled                                             ? TRIAL_IRREGULAR
                 : row->impacts < 0 || row->sticking > 0                ? TRIAL_CHATTER
                 : row->impacts                                         ? TRIAL_IMPACTS
                                                                        : TRIAL_FREE;
    cell->impacts = row->impacts;
    cell->periods = row->periods;
    cell->chaotic = row->verdict == SALTUS_CHAOTIC;
    cell->lyapunov = row->lyapunov;
    cell->rate = row->impact_rate;
    cell->speed = row->largest_speed;
    cell->contact = cell->kind == TRIAL_HELD ? 1 : row->contact_fraction;
    cell->reach = fmax(fabs(row->largest), fabs(row->smallest));
    return SALTUS_OK;
}

saltus_status trial_survey_exact(trial_survey *survey, saltus_message *message) {
    saltus_scene scene;
    double states[trial_starts * SALTUS_SCENE_STATE_MAX];
    double *values = calloc((size_t)survey->values, sizeof *values);
    if (!values)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the values of %s", survey->figure->key);
    for (int k = 0; k < survey->values; k++)
        values[k] = survey->cells[k * trial_starts].value;
    saltus_axis axis = {.spacing = SALTUS_LIST,
                        .count = survey->values,
                        .low = values[0],
                        .high = values[survey->values - 1],
                        .list = values};
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = SALTUS_KEEP_LYAPUNOV;
    options.transient = periods_at_most;
    options.measure = periods_measured;
    snprintf(axis.key, sizeof axis.key, "%s", survey->figure->key);
    saltus_status status = trial_scene(survey->figure, &scene, message);
    int dimension = status == SALTUS_OK ? 2 * (int)saltus_spec_get(&scene.spec, "N") : 0;
    if (status == SALTUS_OK)
        status = trial_draw_starts(&scene, survey->figure->admissible, 1, states, message);
    for (int start = 0; start < trial_starts && status == SALTUS_OK; start++) {
        saltus_sweep *sweep = NULL;
        scene.initial_count = dimension;
        for (int i = 0; i < dimension; i++)
            scene.initial[i] = states[start * dimension + i];
        status = saltus_sweep_new(&scene, &axis, 1, &options, &sweep, message);
        const saltus_sweep_feed feed = {.context = survey->cells + start, .take = take};
        if (status == SALTUS_OK)
            status = saltus_sweep_run(sweep, &feed, message);
        saltus_sweep_free(sweep);
    }
    free(values);
    return status;
}
