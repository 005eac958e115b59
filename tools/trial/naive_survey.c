/* Surveys by the naive method, from the same starts, for comparison: NOT FOR USE.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "naive/naive_class.h"
#include "survey.h"

#include <math.h>

/* Regular transients decay in time, at the damping rate of the first mode; chaotic ones in periods. */
enum { settling_periods = 50 };
static const double settling_time = 40;
static const double displacement_unit = 0.03; /* unit for distances between section points */

/* False if the naive method cannot describe the scene at that value. */
static bool run_value(trial_survey *survey, int k, const double *states) {
    trial_cell *cells = survey->cells + (size_t)k * trial_starts;
    saltus_scene scene;
    naive_pipe pipe;
    naive_class classes[naive_lanes];
    char assignment[64];
    snprintf(assignment, sizeof assignment, "%s=%.17g", survey->figure->key, cells->value);
    if (trial_scene(survey->figure, &scene, NULL) != SALTUS_OK ||
        saltus_scene_set(&scene, assignment, NULL) != SALTUS_OK || !naive_pipe_from(&scene.spec, &pipe))
        return false;
    int warm = (int)fmax(settling_periods, ceil(settling_time * pipe.omega / (2 * acos(-1))));
    naive_classify(&pipe, survey->h, false, states, warm, displacement_unit, classes);
    for (int l = 0; l < trial_starts; l++, cells++) {
        const naive_class *class = &classes[l];
        cells->kind = !class->finite        ? TRIAL_FAILED
                      : class->held         ? TRIAL_HELD
                      : class->periods == 0 ? TRIAL_IRREGULAR
                      : class->impacts < 0  ? TRIAL_CHATTER
                      : class->impacts      ? TRIAL_IMPACTS
                                            : TRIAL_FREE;
        cells->impacts = class->impacts;
        cells->periods = class->periods;
        cells->lyapunov = NAN;
        cells->rate = class->rate;
        cells->speed = class->speed;
        cells->contact = class->contact;
        cells->depth = class->deepest;
        for (int w = 0; w <= naive_watched; w++)
            cells->reach = fmax(cells->reach, fabs(class->points[w][0]));
    }
    return true;
}

_Static_assert((int)naive_lanes == (int)trial_starts, "a pack of lanes is a value's starts");

saltus_status trial_survey_naive(trial_survey *survey, saltus_message *message) {
    saltus_scene scene;
    double states[trial_starts * naive_size_max];
    int failed = 0;
    saltus_status status = trial_scene(survey->figure, &scene, message);
    if (status == SALTUS_OK && saltus_spec_get(&scene.spec, "N") > naive_modes_max)
        status = saltus_fail(message, SALTUS_BAD_INPUT, "too many modes for the naive method");
    if (status == SALTUS_OK)
        status = trial_draw_starts(&scene, survey->figure->admissible, 1, states, message);
    if (status != SALTUS_OK)
        return status;
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic) reduction(+ : failed)
#endif
    for (int k = 0; k < survey->values; k++)
        failed += !run_value(survey, k, states);
    return failed ? saltus_fail(message, SALTUS_BAD_INPUT, "the naive method cannot describe this scene")
                  : SALTUS_OK;
}
