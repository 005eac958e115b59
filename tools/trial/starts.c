/* Initial states that do not depend on the parameter varied by a figure.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "survey.h"

#include <gsl/gsl_randist.h>
#include <math.h>

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

saltus_status trial_draw_starts(const saltus_scene *scene, double clearance, unsigned long seed,
                                double *states, saltus_message *message) {
    saltus_system *system = NULL;
    saltus_status status = saltus_system_new(&scene->spec, &system, message);
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    bool both = scene->spec.stop_count && scene->spec.stops[0].sides == SALTUS_BOTH;
    if (status == SALTUS_OK && !rng)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for random numbers");
    if (status == SALTUS_OK)
        status = saltus_system_default_state(system, states, message);
    if (status == SALTUS_OK) {
        gsl_rng_set(rng, seed);
        for (int k = 1; k < trial_starts; k++)
            draw(system, rng, isnan(clearance) ? INFINITY : clearance, both,
                 states + (size_t)k * (size_t)saltus_system_dimension(system));
        /* A default state pressed onto the stop would not be admissible at all clearances. */
        if (clearance <= 0)
            draw(system, rng, clearance, both, states);
    }
    if (rng)
        gsl_rng_free(rng);
    saltus_system_free(system);
    return status;
}
