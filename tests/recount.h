/* What an orbit does in its periods, counted and measured again along the flow, step by step, for tests.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_RECOUNT_H
#define SALTUS_TESTS_RECOUNT_H

#include "check.h"

typedef struct recount {
    long long impacts, by_face[SALTUS_FACES_MAX];
    int sticks, releases;
    bool chatter; /* impacts with rebound ended in a rest */
    double largest, smallest;
    double end[16];
} recount;

static inline double observed(const saltus_system *system, const double *state) {
    double g = 0;
    for (int i = 0; i < saltus_system_dof(system); i++)
        g += saltus_system_observer(system)[i] * state[i];
    return g;
}

/* `periods` periods from a state at phase 0. */
static inline recount recount_from(const saltus_system *system, const double *state, int periods) {
    enum { pieces = 1024 };
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = open_flow(system, &options, 0, state);
    recount r = {.largest = observed(system, state), .smallest = observed(system, state)};
    saltus_event event = {.kind = SALTUS_STEP};
    while (event.kind != SALTUS_REACHED) {
        double sample[16], length;
        event = advance(flow, periods, SALTUS_WATCH_CONTACT | SALTUS_WATCH_STEP);
        if (event.kind == SALTUS_IMPACT || event.kind == SALTUS_STICK) {
            bool hits = event.velocity_before != 0;
            r.impacts += hits;
            r.by_face[event.face] += hits;
            r.sticks += event.kind == SALTUS_STICK;
            r.chatter |= event.kind == SALTUS_STICK && saltus_system_face(system, event.face).r > 0;
        }
        r.releases += event.kind == SALTUS_RELEASE;
        length = saltus_flow_step_length(flow, 0);
        for (int k = 0; k <= pieces; k++) {
            saltus_flow_dense(flow, 0, length * k / pieces, sample);
            r.largest = fmax(r.largest, observed(system, sample));
            r.smallest = fmin(r.smallest, observed(system, sample));
        }
    }
    saltus_flow_state(flow, 0, r.end);
    saltus_flow_free(flow);
    return r;
}

#endif
