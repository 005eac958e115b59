/* Attractors over a plane of initial states, told apart by their orbits.
 *
 * A settled row belongs to the attractor that has a section point at the row's last state. If no known
 * attractor does, Newton's method finds the row's own orbit to full accuracy, and this is compared with the
 * known ones. So neither slow convergence nor neighbouring attractors can cause a mix-up.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <stdlib.h>

static const double near_orbit = 1e-7; /* a settled state, relative to the system's scales */
static const double same_orbit = 1e-8; /* orbits found by Newton's method */

struct saltus_basins {
    const saltus_sweep *sweep;
    saltus_list motions; /* saltus_motion */
};

saltus_status saltus_basins_new(const saltus_sweep *sweep, saltus_basins **basins, saltus_message *message) {
    *basins = NULL;
    for (int k = 0; k < sweep->axis_count; k++) {
        saltus_direction direction;
        if (saltus_spec_direction(&sweep->scene.spec, sweep->axes[k].key, &direction, NULL, NULL) ==
            SALTUS_OK)
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "%s: a plane of initial states is made of entries of the state, such as %s",
                               sweep->axes[k].key, saltus_system_state_name(sweep->system, 0).text);
    }
    if (sweep->options.seeds != 1)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "seeds = %d: each point of a plane of initial states is one initial state",
                           sweep->options.seeds);
    *basins = calloc(1, sizeof **basins);
    if (!*basins)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the basins");
    (*basins)->sweep = sweep;
    return SALTUS_OK;
}

void saltus_basins_free(saltus_basins *basins) {
    if (!basins)
        return;
    for (int k = 0; k < basins->motions.count; k++)
        saltus_motion_clear((saltus_motion *)basins->motions.items + k);
    free(basins->motions.items);
    free(basins);
}

/* Index of the known motion that a trajectory has ended on, or -1. */
static int find(const saltus_basins *basins, saltus_ending ending, double distance) {
    for (int k = 0; k < basins->motions.count; k++) {
        saltus_ending known = saltus_motion_ending(saltus_basins_motion(basins, k));
        if (saltus_same_attractor(basins->sweep->system, &known, &ending, distance))
            return k;
    }
    return -1;
}

saltus_status saltus_basins_sort(saltus_basins *basins, const saltus_sweep_row *row, const double *state,
                                 int *attractor, saltus_message *message) {
    const saltus_ending ending = {(saltus_verdict)row->verdict, row->periods, state, NULL};
    *attractor = -1;
    if (!saltus_verdict_settled(ending.verdict))
        return SALTUS_OK;
    *attractor = find(basins, ending, near_orbit);
    if (*attractor >= 0)
        return SALTUS_OK;
    saltus_classify_options options = saltus_classify_defaults();
    saltus_motion motion = {0};
    options.measure = 0;
    options.flow.integrator = basins->sweep->options.flow.integrator;
    saltus_status status = saltus_classify(basins->sweep->system, state, &options, &motion, message);
    if (status == SALTUS_OK && saltus_verdict_settled(motion.verdict)) {
        *attractor = find(basins, saltus_motion_ending(&motion), same_orbit);
        saltus_motion *new = *attractor < 0 ? saltus_list_add(&basins->motions, sizeof *new) : NULL;
        if (new) {
            *new = motion;
            *attractor = basins->motions.count - 1;
            return SALTUS_OK;
        }
        if (*attractor < 0)
            status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the attractors");
    }
    saltus_motion_clear(&motion);
    return status == SALTUS_NO_MEMORY ? status : SALTUS_OK;
}

int saltus_basins_count(const saltus_basins *basins) {
    return basins->motions.count;
}

const saltus_motion *saltus_basins_motion(const saltus_basins *basins, int attractor) {
    return (const saltus_motion *)basins->motions.items + attractor;
}
