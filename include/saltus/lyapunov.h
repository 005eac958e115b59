/* Lyapunov exponents of the motion a trajectory settles on, with standard errors.
 *
 * Exponents are per unit of time (not per period). They belong to the stroboscopic map: the direction of time
 * itself, in which nothing grows, is left out in a forced system.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_LYAPUNOV_H
#define SALTUS_LYAPUNOV_H

#include "saltus/average.h"
#include "saltus/flow.h"

SALTUS_API_BEGIN

typedef struct saltus_lyapunov_options {
    saltus_flow_options flow; /* columns and directions are set by the method; `stop` ends the measurement
                                 with what there is; rtol is 1e-10 and atol 1e-14 by default */
    int exponents;            /* how many, the largest ones; 0: all; default 1 */
    int members;              /* trajectories that share the work, 1 to 64; default 8 */
    long long transient;      /* periods before the measurement; default 1000 */
    long long periods;        /* measured at most, by all trajectories together; default 1e6 */
    double precision;         /* the measurement ends when the largest exponent's standard error is below
                                 this part of it, or below 1e-6 per period; default 0.01 */
    double interval;          /* periods between orthonormalisations: a whole number, or one divided by one;
                                 0: chosen from the growth; default 0 */
    unsigned long seed;       /* of the tangent vectors; other than 0 the initial state is disturbed too, by
                                 1e-6 of the system's scales; default 0 */
    /* Periods measured, 0 in the transient; the result's `history` and `history_count` are up to date when it
     * is shown. */
    saltus_progress progress;
} saltus_lyapunov_options;

/* As told beside the options. */
saltus_lyapunov_options saltus_lyapunov_defaults(void);

/* The largest exponent as it was known after some time. */
typedef struct saltus_lyapunov_progress {
    double time; /* measured by all trajectories together */
    double exponent, standard_error;
} saltus_lyapunov_progress;

/* Arrays are owned by the result. */
typedef struct saltus_lyapunov {
    int dimension, count;
    double *exponents;       /* count of them, by decreasing size; -INFINITY where directions are lost for
                                good, in a lasting contact or by an impact without rebound */
    double *standard_errors; /* of each; 0 where it is -INFINITY */
    double *state;           /* of the first trajectory at the end, at phase 0 */
    int lost;                /* exponents that are -INFINITY, of all directions */
    double sum;              /* of all exponents; NAN where they are not all there */
    double sum_rule;         /* what the trace of the Jacobian and the restitutions make it over the same time
                                (model.md, section 1); NAN where it does not apply */
    double kaplan_yorke;     /* dimension of the attractor in the stroboscopic section; NAN where too few
                                exponents are there */
    double impacts_per_period, sticks_per_period;
    double period;         /* T */
    double time;           /* measured by all trajectories together */
    long long periods;     /* the same in forcing periods */
    long long transient;   /* periods before it; more than asked for where the exponent was still drifting */
    double half[2];        /* the largest exponent from the first and from the second half, ... */
    double half_errors[2]; /* ... which should agree */
    double independent;    /* number of independent values that the largest exponent rests on */
    int members;
    double *member_exponents; /* largest exponent of each trajectory; */
    bool agree;               /* their scatter fits their standard errors, or is below the precision */
    bool precise;             /* the precision asked for was reached */
    saltus_lyapunov_progress *history;
    int history_count;
} saltus_lyapunov;

/* Settle from an initial state (length dimension, at phase 0), then follow tangent vectors. The trajectories
 * that share the work start at different times of the last half of the transient. On success the result's
 * arrays are owned by it: saltus_lyapunov_clear. Errors: SALTUS_BAD_INPUT, those of the flow, SALTUS_STALLED
 * (the motion or the tangent vectors grow without bound), SALTUS_NO_MEMORY. */
saltus_status saltus_lyapunov_run(const saltus_system *system, const double *state,
                                  const saltus_lyapunov_options *options, saltus_lyapunov *lyapunov,
                                  saltus_message *message);
/* Free the arrays; a zeroed result is accepted. */
void saltus_lyapunov_clear(saltus_lyapunov *lyapunov);

SALTUS_API_END
#endif
