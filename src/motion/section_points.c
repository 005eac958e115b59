/* Returns of a motion without forcing to its section, and stable orbits among them.
 *
 * A chaotic transient comes near the orbit that it ends on long before it does. Close returns lead Newton's
 * method there; of those that lead to unstable orbits there are the more the longer their period, so only a
 * few are tried of each.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/motion.h"

#include "orbit/poincare.h"
#include "system/system.h"

#include <math.h>
#include <string.h>

enum { longest = 16, tries = 4 };
static const double beside = 3; /* times the distance of a return */

saltus_status saltus_motion_section_points(const saltus_system *system, const saltus_flow_options *options,
                                           const double *start, long long room, double *points, double *times,
                                           long long *count, saltus_message *message) {
    const int n = saltus_system_dimension(system);
    const saltus_time until = {2 * room, 0};
    saltus_crossings crossings = {0};
    saltus_event event = {.kind = SALTUS_STEP};
    saltus_flow *flow = NULL;
    saltus_time time;
    double state[SALTUS_STATE_MAX];
    *count = 0;
    saltus_status status = saltus_flow_single(system, 0, options, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, start, message);
    while (status == SALTUS_OK && event.kind != SALTUS_REACHED && *count < room) {
        status = saltus_flow_advance(flow, until, saltus_crossings_watch(system), &event, message);
        if (status != SALTUS_OK)
            break;
        saltus_flow_state(flow, 0, state);
        saltus_crossings_take(&crossings, flow, 0, &event, state);
        while (*count < room && saltus_crossings_count(&crossings, flow, 0, state, &time)) {
            memcpy(points + *count * n, state, (size_t)n * sizeof *state);
            times[(*count)++] = saltus_time_periods(time);
        }
    }
    saltus_flow_free(flow);
    return status;
}

/* The next closest return after so many, beyond a distance; -1: there is none. */
static long long closest_return(const saltus_system *system, const double *points, long long count, int apart,
                                double beyond, double *distance) {
    const int n = saltus_system_dimension(system);
    long long place = -1;
    *distance = INFINITY;
    for (long long k = 0; k + apart < count; k++) {
        double d = saltus_system_distance(system, points + k * n, points + (k + apart) * n);
        if (d > beyond && d < *distance) {
            *distance = d;
            place = k;
        }
    }
    return place;
}

saltus_status saltus_stable_cycle_among(const saltus_system *system, const saltus_flow_options *flow,
                                        const double *points, const double *times, long long count,
                                        saltus_motion *motion, bool *found, saltus_message *message) {
    const int n = saltus_system_dimension(system);
    saltus_classify_options options = saltus_classify_defaults();
    options.flow = *flow;
    *found = false;
    *motion = (saltus_motion){0};
    for (int p = 1; p <= longest; p++) {
        double distance = 0;
        for (int k = 0; k < tries; k++) {
            long long at = closest_return(system, points, count, p, distance, &distance);
            if (at < 0)
                break;
            saltus_system *counted = NULL;
            double omega = saltus_spec_omega(saltus_system_spec(system)) / (times[at + p] - times[at]);
            saltus_status status = saltus_system_clocked(system, omega, &counted, message);
            if (status == SALTUS_OK)
                status = saltus_motion_cycle(counted, points + at * n, &options, motion, NULL);
            saltus_system_free(counted);
            if (status == SALTUS_NO_MEMORY)
                return saltus_fail(message, status, "no memory for an orbit");
            *found = status == SALTUS_OK && motion->stable &&
                     saltus_orbit_passes(system, motion->section_states, motion->periods, points + at * n,
                                         beside * distance);
            if (*found)
                return SALTUS_OK;
            saltus_motion_clear(motion);
        }
    }
    return SALTUS_OK;
}
