/* One method at one tolerance on one problem: errors, evaluations and processor time.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_MEASURE_H
#define SALTUS_BENCH_MEASURE_H

#include "clock.h"
#include "problem.h"

/* A method is one of Saltus' integrators, or a rival. */
typedef struct method {
    const char *name, *key;
    saltus_integrator own; /* of Saltus, if there is no rival */
    const rival *rival;
} method;

/* How multipliers are computed. */
typedef enum derivative { derivative_none, derivative_tangents, derivative_differences } derivative;

typedef struct measure {
    double rtol;
    bool done;
    double event_error; /* in T; NAN: the orbit has no impact */
    double state_error; /* relative, as in reference_error */
    double seconds, evaluations;
    derivative how; /* members below are set only if this is not derivative_none */
    double multiplier_error, derivative_seconds, derivative_evaluations;
} measure;

/* Limits on the time spent on a measurement. */
typedef struct effort {
    int repeats;     /* most runs, whose median counts; at least 3, but only one if a run is long */
    double budget;   /* approximate processor time in seconds for all repeats */
    double patience; /* seconds: longer runs are not repeated, and are made without tangent vectors if these
                        would take five times as long */
} effort;

/* Errors caused by a perturbation of the start: no integrator of that tolerance can be expected to do
 * better. */
typedef struct condition {
    double events, state;
} condition;

double median(double *values, int count);
/* Run from the reference's state once around the orbit, and once more with derivatives as `how` says. */
measure measure_method(const problem *p, const method *m, double rtol, derivative how, const effort *e);
/* The largest errors after changing one component of the start by `amount` of the orbit's size. */
condition measure_condition(const problem *p, double amount);

#endif
