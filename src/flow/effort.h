/* Private: how many steps a question may take before it is given up.
 *
 * Searches follow as many periods as it takes to know. Scenes that are not extreme take 5 to 200 steps in a
 * period, whatever is asked. What goes beyond SALTUS_EFFORT_USUAL a period is added up over all flows of the
 * question, each step once for every column that it carries; what falls below is taken off again. Of a
 * branch each point may take SALTUS_EFFORT_AT_POINT, so that long ones of slow cycles do not add up.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_EFFORT_H
#define SALTUS_FLOW_EFFORT_H

#include "saltus/flow.h"

enum {
    SALTUS_EFFORT_USUAL = 500,
    SALTUS_EFFORT_USUAL_STIFF = 333, /* steps of the stiff integrator */
    SALTUS_EFFORT_MOST = 5000000,
    SALTUS_EFFORT_AT_POINT = SALTUS_EFFORT_MOST / 10,
    SALTUS_EFFORT_IN_PERIOD = SALTUS_EFFORT_MOST / 64 /* no more periods are followed before a first look */
};

typedef struct saltus_effort {
    double period; /* that steps are counted by, in units of time; 0: that of each flow's own system */
    double spent;
} saltus_effort;

/* The options for a question about a system: with a new effort in `own` where they have none. */
saltus_flow_options saltus_effort_begin(const saltus_flow_options *options, const saltus_system *system,
                                        saltus_effort *own);
/* Errors: SALTUS_STALLED where it is used up, in whatever flow that was. */
saltus_status saltus_effort_check(const saltus_effort *effort, const saltus_system *system,
                                  saltus_message *message);

/* What may be the cause of very many steps: the parameter that is farthest from its default, or a pre-load,
 * with its value.
 */
enum { SALTUS_CAUSE_MAX = 120 };
const char *saltus_effort_cause(const saltus_system *system, char cause[SALTUS_CAUSE_MAX]);

/* What a point of a branch may take is taken off, before the next one is sought. */
static inline void saltus_effort_next_point(saltus_effort *effort) {
    const double spent = effort->spent - SALTUS_EFFORT_AT_POINT;
    effort->spent = spent > 0 ? spent : 0;
}

/* The time that steps are counted by in a flow of a system with this period. */
static inline double saltus_effort_period(const saltus_effort *effort, double own) {
    return effort->period > 0 ? effort->period : own;
}

/* A step of so many periods, with so many tangent vectors; one of the stiff integrator costs three. */
static inline void saltus_effort_add(saltus_effort *effort, double periods, int columns, bool stiff) {
    const double cost = stiff ? 3 : 1, usual = stiff ? SALTUS_EFFORT_USUAL_STIFF : SALTUS_EFFORT_USUAL;
    const double spent = effort->spent + (1 + columns) * cost * (1 - usual * periods);
    effort->spent = spent > 0 ? spent : 0;
}

#endif
