/* Private: what exponents and section points say about a motion without a period.
 *
 * Classification and sweeps use the same rule. saltus_runs_weigh judges the exponent: the motion is regular,
 * or it may be a torus or chaos. saltus_points_test then confirms or rejects a suspected torus by its
 * section points. The caller chooses the lengths of the runs and the section points.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_EVIDENCE_H
#define SALTUS_MOTION_EVIDENCE_H

#include "saltus/motion.h"

/* Standard errors by which an exponent must differ from zero. */
#define SALTUS_SIGNIFICANT 3.0
/* -ln 1e-16: number of e-folding times in which neighbours separate from rounding to the motion's extent. */
#define SALTUS_APART 37.0

typedef enum saltus_outcome {
    SALTUS_OUTCOME_OPEN, /* not decided yet */
    SALTUS_OUTCOME_CHAOS,
    SALTUS_OUTCOME_TORUS,
    SALTUS_OUTCOME_REGULAR, /* nothing irregular: a period must appear */
    SALTUS_OUTCOME_LEFT,    /* transient chaos: trajectories have left it, or a stable orbit lies amid it */
    SALTUS_OUTCOME_SHORT    /* like chaos, but not watched for long enough */
} saltus_outcome;

/* The largest exponent, per unit of time, from a run and its two halves, and how long it was watched. */
typedef struct saltus_runs {
    saltus_estimate all, first, second;
    double latest;      /* mean over the last eighth, in any unit: not positive if the motion has been left */
    double period;      /* T */
    long long watched;  /* periods, summed over all trajectories */
    int members;        /* number of trajectories */
    long long lifetime; /* periods: the mean lifetime to be shown before chaos is asserted */
    bool lost;          /* contacts have wiped out all perturbations: the exponent is -infinity */
} saltus_runs;

/* Which tests of the section points are made. */
typedef enum saltus_point_tests {
    SALTUS_TESTS_TORUS, /* enough for a torus: broadband part, and closed curves if that is small */
    SALTUS_TESTS_ALL    /* both in any case, and the 0-1 test and the dimension */
} saltus_point_tests;

/* The outcome by the exponent alone. TORUS is only a suspicion until the section points are tested, and
 * CHAOS until a search finds no stable orbit amid it (motion/stable_orbit.c). SHORT: measure on, if there is
 * time. */
saltus_outcome saltus_runs_weigh(const saltus_runs *runs);
/* Whether an exponent, per unit of time, is zero within its error, and that error is too small to hide weak
 * chaos or locking. */
bool saltus_exponent_may_be_zero(saltus_estimate exponent, double period);
/* Lower bound of the mean lifetime, in periods, with 95 % confidence, if `left` trajectories have left
 * within `watched` periods, each counted until it left. Escape is taken as a memoryless process, so only the
 * total of the periods matters. About watched / 3 if none has left. */
double saltus_lifetime_at_least(double watched, int left);
/* Test `count` section points (dimension numbers each, at least SALTUS_SERIES_LEAST), fill the evidence with
 * the results, and revise a suspected torus in *outcome. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT. */
saltus_status saltus_points_test(const saltus_system *system, const double *points, long long count,
                                 saltus_point_tests tests, saltus_evidence *evidence, saltus_outcome *outcome,
                                 saltus_message *message);

#endif
