/* Where a branch of cycles ends.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/ending.h"

#include "saltus/equilibrium.h"

#include <math.h>
#include <string.h>

/* How fast the flow is at a state of its own system, in the state's scales. */
static double speed_at(saltus_flow *flow, const double *scale, int n) {
    double field[SALTUS_STATE_MAX], speed = 0;
    saltus_flow_field(flow, 0, field);
    for (int i = 0; i < n; i++)
        speed = hypot(speed, field[i] / scale[i]);
    return speed;
}

/* Once around a cycle: its slowest point to `slowest`, or, where `rest` is given, how near to that it comes.
 */
static saltus_status go_around(saltus_orbits *o, const saltus_solution *s, const double *rest,
                               double *slowest, double *least, saltus_message *message) {
    enum { parts = 8 };
    const double *scale = saltus_system_scale(o->system);
    saltus_event event = {.kind = SALTUS_STEP};
    double state[SALTUS_STATE_MAX];
    *least = INFINITY;
    saltus_status status = saltus_flow_start(o->flow, 0, (saltus_time){0, 0}, s->state, message);
    while (status == SALTUS_OK && event.kind != SALTUS_REACHED) {
        status = saltus_flow_advance(o->flow, (saltus_time){1, 0}, SALTUS_WATCH_STEP, &event, message);
        const double length = status == SALTUS_OK ? saltus_flow_step_length(o->flow, 0) : 0;
        for (int k = 0; k < parts && rest && status == SALTUS_OK; k++) {
            saltus_flow_dense(o->flow, 0, length * k / parts, state);
            *least = fmin(*least, saltus_system_distance(o->system, state, rest));
        }
        const double speed = rest || status != SALTUS_OK ? INFINITY : speed_at(o->flow, scale, o->n);
        if (speed < *least) {
            *least = speed;
            saltus_flow_state(o->flow, 0, slowest);
        }
    }
    return status;
}

saltus_status saltus_cycle_passes(saltus_orbits *o, const saltus_solution *s, saltus_passed *passed,
                                  saltus_message *message) {
    saltus_equilibrium_options how = saltus_equilibrium_defaults();
    saltus_equilibrium rest = {0};
    saltus_message why = {.text = ""};
    double slowest[SALTUS_STATE_MAX] = {0}, speed;
    *passed = (saltus_passed){.found = false};
    saltus_status status = saltus_orbits_tune(o, s->parameter, s->sequence.omega / s->sequence.periods, &why);
    if (status == SALTUS_OK)
        status = go_around(o, s, NULL, slowest, &speed, &why);
    if (status == SALTUS_OK)
        status = saltus_equilibrium_find(o->system, slowest, &how, &rest, &why);
    if (status == SALTUS_OK)
        status = go_around(o, s, rest.state, slowest, &passed->distance, &why);
    if (status == SALTUS_OK) {
        passed->found = true;
        passed->contacts = rest.contacts;
        passed->unstable = rest.instability;
        for (int k = 0; k < rest.eigenvalue_count; k++)
            passed->stable += rest.eigenvalues[k].re < 0;
    }
    saltus_equilibrium_clear(&rest);
    return status == SALTUS_NO_MEMORY ? saltus_fail(message, status, "%s", why.text) : SALTUS_OK;
}
