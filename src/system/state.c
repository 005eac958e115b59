/* States of a system: random ones, disturbances, moves back onto stops, checks for unbounded growth.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/state.h"

#include "base/dense.h"
#include "system/cause.h"
#include "system/system.h"

#include <gsl/gsl_randist.h>
#include <math.h>
#include <string.h>

saltus_status saltus_state_random(const saltus_system *system, gsl_rng *rng, double *state,
                                  saltus_message *message) {
    enum { tries_max = 10000 };
    const double *scale = saltus_system_scale(system);
    for (int k = 0; k < tries_max; k++) {
        for (int i = 0; i < saltus_system_dimension(system); i++)
            state[i] = gsl_ran_gaussian(rng, scale[i]);
        if (saltus_system_check_state(system, state, NULL) == SALTUS_OK)
            return SALTUS_OK;
    }
    /* Clearances are far below the scales: take the default state with random velocities. */
    saltus_status status = saltus_system_default_state(system, state, message);
    for (int i = saltus_system_dof(system); i < 2 * saltus_system_dof(system) && status == SALTUS_OK; i++)
        state[i] = gsl_ran_gaussian(rng, scale[i]);
    return status;
}

void saltus_state_admit(const saltus_system *system, double *state) {
    enum { rounds = 8 };
    int dof = saltus_system_dof(system);
    for (int round = 0; round < rounds; round++)
        for (int f = 0; f < saltus_system_face_count(system); f++) {
            saltus_face face = saltus_system_face(system, f);
            const double *normal = saltus_system_stop_normal(system, face.stop);
            double gap = saltus_system_gap(system, f, state), square = saltus_dot(normal, normal, dof);
            for (int i = 0; i < dof && gap > 0; i++)
                state[i] -= face.side * gap / square * normal[i];
        }
}

/* Remove the component of a displacement or velocity along a normal. */
static void project(const double *normal, int dof, double *vector) {
    const double along = saltus_dot(normal, vector, dof), square = saltus_dot(normal, normal, dof);
    for (int i = 0; i < dof; i++)
        vector[i] -= along / square * normal[i];
}

void saltus_state_disturb(const saltus_system *system, gsl_rng *rng, double size, unsigned contacts,
                          double *state) {
    const double *scale = saltus_system_scale(system);
    double vector[SALTUS_STATE_MAX], moved[SALTUS_STATE_MAX];
    int n = saltus_system_dimension(system), dof = saltus_system_dof(system);
    for (int i = 0; i < n; i++)
        vector[i] = gsl_ran_gaussian(rng, size * scale[i]);
    for (int f = 0; f < saltus_system_face_count(system); f++)
        if (contacts >> f & 1) {
            const double *normal = saltus_system_stop_normal(system, saltus_system_face(system, f).stop);
            project(normal, dof, vector);
            project(normal, dof, vector + dof);
        }
    for (int sign = 1; sign >= -1; sign -= 2) {
        for (int i = 0; i < n; i++)
            moved[i] = state[i] + sign * vector[i];
        if (saltus_system_check_state(system, moved, NULL) == SALTUS_OK)
            break;
    }
    saltus_state_admit(system, moved);
    memcpy(state, moved, (size_t)n * sizeof *state);
}

/* If a pre-load, by a stop beyond the place of rest, holds the system far beyond the scale of its motion, it
 * excites such fast modes that their rounding hides whether the motion settles, at the cost of very many
 * steps. */
saltus_status saltus_state_load(const saltus_system *system, const double *state, unsigned contacts,
                                saltus_message *message) {
    static const double far_beyond = 100;
    const double *scale = saltus_system_scale(system);
    bool loaded = false;
    for (int s = 0; s < system->spec.stop_count; s++)
        loaded |= system->spec.stops[s].d < 0;
    for (int i = 0; i < saltus_system_dof(system) && contacts && loaded; i++)
        if (fabs(state[i]) > far_beyond * scale[i])
            return saltus_fail(
                message, SALTUS_STALLED,
                "a stop holds the system at q%d = %.4g, where %.2g is the scale of its motion: "
                "a pre-load of this size is too much",
                i + 1, state[i], scale[i]);
    return SALTUS_OK;
}

saltus_status saltus_state_bounded(const saltus_system *system, const double *state, unsigned contacts,
                                   long long periods, saltus_message *message) {
    enum { at_once = 8 }; /* the load is checked once, after this many periods */
    char cause[SALTUS_CAUSE_MAX];
    const double *scale = saltus_system_scale(system);
    if (periods == at_once && saltus_state_load(system, state, contacts, message) != SALTUS_OK)
        return SALTUS_STALLED;
    for (int i = 0; i < saltus_system_dimension(system); i++)
        if (!(fabs(state[i]) < 1e8 * scale[i]) && isfinite(state[i]) && periods < at_once)
            return saltus_fail(message, SALTUS_STALLED,
                               "the motion leaves its scale at once: state entry %d is %.3g after %lld "
                               "periods, its scale %.2g: %s",
                               i + 1, state[i], periods, scale[i], saltus_system_cause(system, cause));
        else if (!(fabs(state[i]) < 1e8 * scale[i]))
            return saltus_fail(message, SALTUS_STALLED,
                               "the motion grows without bound: state entry %d is %.3g after %lld periods",
                               i + 1, state[i], periods);
    return SALTUS_OK;
}
