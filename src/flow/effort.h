/* Private: how many steps a question may take before it is given up.
 *
 * Searches follow as many periods as they need; ordinary scenes take 5 to 200 steps per period. Steps beyond
 * SALTUS_EFFORT_USUAL per period add up over all flows of a question, times one plus the number of tangent
 * vectors; periods with fewer steps lower the sum. At SALTUS_EFFORT_MOST the question is given up. Each point
 * of a branch may spend SALTUS_EFFORT_AT_POINT, so that long branches of slow cycles are not.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_EFFORT_H
#define SALTUS_FLOW_EFFORT_H

#include "saltus/flow.h"

enum {
    SALTUS_EFFORT_USUAL = 500,
    SALTUS_EFFORT_USUAL_STIFF = 333, /* steps of the stiff integrator */
    SALTUS_STIFF_COST = 12, /* of one of these in steps of series (measured on pipes of 10 to 64 modes: from
                               half of that to twice) */
    SALTUS_EFFORT_MOST = 5000000,
    SALTUS_EFFORT_AT_POINT = SALTUS_EFFORT_MOST / 10,
    SALTUS_EFFORT_IN_PERIOD = SALTUS_EFFORT_MOST / 64 /* 64: the most periods before a motion is looked at */
};

typedef struct saltus_effort {
    double period; /* to which step counts refer, in units of time; 0: each flow's own */
    double spent;
} saltus_effort;

/* The options for a question about a system; if they have no effort yet, `own` becomes it. */
saltus_flow_options saltus_effort_begin(const saltus_flow_options *options, const saltus_system *system,
                                        saltus_effort *own);
/* Errors: SALTUS_STALLED if the effort is used up, by whichever flow. NULL is accepted. */
saltus_status saltus_effort_check(const saltus_effort *effort, const saltus_system *system,
                                  saltus_message *message);

/* The likely cause of very many steps, with its value: the parameter farthest from its default, or a
 * pre-load. */
enum { SALTUS_CAUSE_MAX = 120 };
const char *saltus_effort_cause(const saltus_system *system, char cause[SALTUS_CAUSE_MAX]);

/* Subtract the allowance of a branch's point, before the next point is sought. */
static inline void saltus_effort_next_point(saltus_effort *effort) {
    const double spent = effort->spent - SALTUS_EFFORT_AT_POINT;
    effort->spent = spent > 0 ? spent : 0;
}

/* The period to which step counts refer, in a flow of a system with period `own`. */
static inline double saltus_effort_period(const saltus_effort *effort, double own) {
    return effort->period > 0 ? effort->period : own;
}

/* Add a step of length `periods` with `columns` tangent vectors; one of the stiff integrator counts
 * SALTUS_STIFF_COST. */
static inline void saltus_effort_add(saltus_effort *effort, double periods, int columns, bool stiff) {
    const double cost = stiff ? SALTUS_STIFF_COST : 1,
                 usual = stiff ? SALTUS_EFFORT_USUAL_STIFF : SALTUS_EFFORT_USUAL;
    const double spent = effort->spent + (1 + columns) * cost * (1 - usual * periods);
    effort->spent = spent > 0 ? spent : 0;
}

#endif
