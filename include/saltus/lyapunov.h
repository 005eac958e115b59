/* Lyapunov exponents of the motion a trajectory settles on, with standard errors.
 *
 * Exponents are per unit of time (not per period). In a forced system they belong to the stroboscopic map, so
 * the zero exponent of the direction of time is not among them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_LYAPUNOV_H
#define SALTUS_LYAPUNOV_H

#include "saltus/average.h"
#include "saltus/flow.h"

SALTUS_API_BEGIN

typedef struct saltus_lyapunov_options {
    saltus_flow_options flow; /* columns and directions are set by the method; `stop` ends the measurement
                                 with the result so far; default rtol is 1e-10 and atol 1e-14 */
    int exponents;            /* number of exponents, the largest first; 0: all; default 1 */
    int members;              /* trajectories that share the work, 1 to 64; default 8 */
    long long transient;      /* periods before the measurement; default 1000 */
    long long periods;        /* most periods measured, summed over the trajectories; default 1e6 */
    double precision; /* the measurement ends when the standard error of the largest exponent is below this
                         fraction of it, or below 1e-6 per period; default 0.01 */
    double interval; /* periods between orthonormalisations: a whole number, or 1 over one; 0: chosen from the
                        growth; default 0 */
    unsigned long seed; /* for the tangent vectors; if not 0 the initial state is perturbed too, by 1e-6 of
                           the system's scales; default 0 */
    /* Periods measured, 0 during the transient. When it is called the result's `history` and `history_count`
     * are up to date. */
    saltus_progress progress;
} saltus_lyapunov_options;

/* The defaults stated beside the options. */
saltus_lyapunov_options saltus_lyapunov_defaults(void);

/* The estimate of the largest exponent after some time. */
typedef struct saltus_lyapunov_progress {
    double time; /* measured, summed over the trajectories */
    double exponent, standard_error;
} saltus_lyapunov_progress;

/* The result, which owns its arrays. */
typedef struct saltus_lyapunov {
    int dimension, count;
    double *exponents; /* `count` of them, in decreasing order; -INFINITY where a direction is lost for good,
                          through lasting contact or an impact without rebound */
    double *standard_errors; /* of each exponent; 0 where it is -INFINITY; of saltus_motion_exponents how
                                accurately it is known */
    double *state;           /* of the first trajectory at the end, at phase 0 */
    int lost;                /* number of exponents equal to -INFINITY among all directions */
    double sum;              /* of all exponents; NAN if not all were computed */
    double sum_rule;         /* the sum predicted over the same time from the trace of the Jacobian and the
                                restitutions (model.md, section 1); NAN where this does not apply */
    double kaplan_yorke; /* Kaplan-Yorke dimension of the attractor in the stroboscopic section; NAN if too
                            few exponents were computed */
    double impacts_per_period, sticks_per_period;
    double period;         /* forcing period T */
    double time;           /* measured, summed over the trajectories */
    long long periods;     /* the measured time in forcing periods */
    long long transient;   /* periods before the measurement; more than requested if the exponent was still
                              drifting */
    double half[2];        /* the largest exponent from the first and the second half of the run */
    double half_errors[2]; /* their standard errors; the two should agree */
    double independent;    /* number of independent values behind the largest exponent */
    int members;
    double *member_exponents; /* largest exponent of each trajectory */
    bool agree;               /* the members' scatter fits their standard errors, or is below the precision */
    bool precise;             /* the requested precision was reached */
    bool slow;        /* the run ended as its error hardly falls with time: neighbours separate in bursts */
    bool interrupted; /* the run was stopped before that: the result is of what was measured so far */
    saltus_lyapunov_progress *history;
    int history_count;
} saltus_lyapunov;

/* Settle from an initial state (length dimension, at phase 0), then follow tangent vectors. The trajectories
 * that share the work start at different times of the last half of the transient. On success free the arrays
 * with saltus_lyapunov_clear. Errors: SALTUS_BAD_INPUT, those of the flow, SALTUS_STALLED (the motion or the
 * tangent vectors grow without bound), SALTUS_NO_MEMORY. */
saltus_status saltus_lyapunov_run(const saltus_system *system, const double *state,
                                  const saltus_lyapunov_options *options, saltus_lyapunov *lyapunov,
                                  saltus_message *message);
/* Free the arrays; a zeroed result is accepted. */
void saltus_lyapunov_clear(saltus_lyapunov *lyapunov);

SALTUS_API_END
#endif
