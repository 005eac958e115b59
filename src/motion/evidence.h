/* Private: what exponents and section points say about a motion without a period.
 *
 * One rule for all who measure. A run is weighed by its exponent: saltus_runs_weigh. That says that the
 * motion is regular, or that it may be a torus or chaos; then its section points are asked, which has the
 * last word: saltus_points_test. A driver decides how long its runs are and which points it has.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_EVIDENCE_H
#define SALTUS_MOTION_EVIDENCE_H

#include "saltus/motion.h"

/* Standard errors by which an exponent must differ from zero. */
#define SALTUS_SIGNIFICANT 3.0
/* -ln 1e-16: after so many e-folding times neighbours have come apart from rounding to the motion's extent.
 */
#define SALTUS_APART 37.0

typedef enum saltus_outcome {
    SALTUS_OUTCOME_OPEN, /* not decided yet */
    SALTUS_OUTCOME_CHAOS,
    SALTUS_OUTCOME_TORUS,
    SALTUS_OUTCOME_REGULAR, /* nothing irregular: a period must show */
    SALTUS_OUTCOME_LEFT,    /* chaos that ends: trajectories have left it, or a stable orbit lies amid it */
    SALTUS_OUTCOME_SHORT    /* as chaos, but it has not been watched for long enough */
} saltus_outcome;

/* The largest exponent, per unit of time, from a run and from parts of it, and how long it was watched. */
typedef struct saltus_runs {
    saltus_estimate all, first, second;
    double latest;      /* mean over its last eighth: that of a motion which has been left is not positive */
    double period;      /* T */
    long long watched;  /* periods, by all trajectories together, */
    int members;        /* and how many these are */
    long long lifetime; /* to be shown before chaos is asserted */
    bool lost;          /* nothing is left of any perturbation */
} saltus_runs;

/* How much is asked of section points. */
typedef enum saltus_point_tests {
    SALTUS_TESTS_TORUS, /* what tells a torus: broadband part, and closed curves where that is small */
    SALTUS_TESTS_ALL    /* these in any case, 0-1 test and dimension */
} saltus_point_tests;

/* What the exponent says. A torus is only suspected: the section points must be asked; so is chaos: there
 * must be no stable orbit amid it (motion/stable_orbit.c). SALTUS_OUTCOME_SHORT: measure on, if there is
 * time. */
saltus_outcome saltus_runs_weigh(const saltus_runs *runs);
/* Whether an exponent, per unit of time, is zero as far as it is known, and it is known so well that neither
 * the weak chaos nor the locking of motions nearby hides in its error. */
bool saltus_exponent_may_be_zero(saltus_estimate exponent, double period);
/* The mean lifetime that is exceeded with 95 % confidence, in periods, where so many trajectories have left
 * within the periods watched until then: an exponential law has no memory, so it does not matter how the
 * periods are shared among trajectories. M L / 3 where none has left. */
double saltus_lifetime_at_least(double watched, int left);
/* Fill the evidence with what `count` section points (dimension numbers each, SALTUS_SERIES_LEAST at least)
 * say, and revise the outcome by it. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT. */
saltus_status saltus_points_test(const saltus_system *system, const double *points, long long count,
                                 saltus_point_tests tests, saltus_evidence *evidence, saltus_outcome *outcome,
                                 saltus_message *message);

#endif
