/* The ranges of the figures, their scenes, and initial states that do not depend on the parameter varied.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "survey.h"

#include <gsl/gsl_randist.h>
#include <math.h>
#include <string.h>

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
    int k = 0;
    while (k < trial_figures && strcmp(trial_figure_list[k].name, name) != 0)
        k++;
    return k < trial_figures ? &trial_figure_list[k] : NULL;
}

saltus_status trial_scene(const trial_figure *figure, saltus_scene *scene, saltus_message *message) {
    saltus_status status = saltus_scene_load(figure->scene, scene, message);
    if (status == SALTUS_OK && figure->setting)
        status = saltus_scene_set(scene, figure->setting, message);
    return status;
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
