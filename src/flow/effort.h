/* Private: how many steps a question may take before it is given up.
 *
 * Searches follow as many periods as they need; ordinary scenes take 5 to 200 steps per period. Steps beyond
 * SALTUS_EFFORT_USUAL per period add up over all flows of a question, times one plus the number of tangent
 * vectors and, in large systems, times their size; periods with fewer steps lower the sum. At
 * SALTUS_EFFORT_MOST the question is given up. Each point of a branch may spend SALTUS_EFFORT_AT_POINT, so
 * that long branches of slow cycles are not.
 *
 * Measurements, which go on for as many periods as they are allowed, count dear periods more than once: as
 * one for every SALTUS_EFFORT_MEASURED steps, counted in the same way, unless they are short.
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
    SALTUS_EFFORT_IN_PERIOD = SALTUS_EFFORT_MOST / 64, /* 64: the most periods before a motion is looked at */
    SALTUS_EFFORT_SMALL = 8, /* degrees of freedom; up to so many a step costs about the same */
    SALTUS_EFFORT_MEASURED = 96
};

typedef struct saltus_effort {
    double period; /* to which step counts refer, in units of time; 0: each flow's own */
    double spent;
    double total; /* all steps, with nothing subtracted */
} saltus_effort;

/* The options for a question about a system; if they have no effort yet, `own` becomes it. */
saltus_flow_options saltus_effort_begin(const saltus_flow_options *options, const saltus_system *system,
                                        saltus_effort *own);
/* Errors: SALTUS_STALLED if the effort is used up, by whichever flow. NULL is accepted. */
saltus_status saltus_effort_check(const saltus_effort *effort, const saltus_system *system,
                                  saltus_message *message);

/* Subtract the allowance of a branch's point, before the next point is sought. */
static inline void saltus_effort_next_point(saltus_effort *effort) {
    const double spent = effort->spent - SALTUS_EFFORT_AT_POINT;
    effort->spent = spent > 0 ? spent : 0;
}

/* The period to which step counts refer, in a flow of a system with period `own`. */
static inline double saltus_effort_period(const saltus_effort *effort, double own) {
    return effort->period > 0 ? effort->period : own;
}

/* Add a step of length `periods` of a system with `dof` degrees of freedom and `columns` tangent vectors; one
 * of the stiff integrator counts SALTUS_STIFF_COST. */
static inline void saltus_effort_add(saltus_effort *effort, double periods, int dof, int columns,
                                     bool stiff) {
    const double size = dof > SALTUS_EFFORT_SMALL ? (double)dof / SALTUS_EFFORT_SMALL : 1,
                 cost = (1 + columns) * size * (stiff ? SALTUS_STIFF_COST : 1),
                 usual = stiff ? SALTUS_EFFORT_USUAL_STIFF : SALTUS_EFFORT_USUAL;
    const double spent = effort->spent + cost * (1 - usual * periods);
    effort->spent = spent > 0 ? spent : 0;
    effort->total += cost;
}

#endif
