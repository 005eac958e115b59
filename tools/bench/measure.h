/* One method at one tolerance on one problem: errors, evaluations and processor time.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_MEASURE_H
#define SALTUS_BENCH_MEASURE_H

#include "clock.h"
#include "problem.h"

/* A method is one of Saltus' integrators, or a rival. */
typedef struct method {
    const char *name, *key;
    saltus_integrator own; /* of Saltus where there is no rival */
    const rival *rival;
} method;

/* How multipliers come about. */
typedef enum derivative { derivative_none, derivative_tangents, derivative_differences } derivative;

typedef struct measure {
    double rtol;
    bool done;
    double event_error; /* T; NaN: the orbit has no impact */
    double state_error; /* relative, as in reference_error */
    double seconds, evaluations;
    derivative how; /* the rest only where it says so */
    double multiplier_error, derivative_seconds, derivative_evaluations;
} measure;

/* What is spent on a measurement. */
typedef struct effort {
    int repeats;     /* at most, of which the median counts; at least 3, but one where a run takes long */
    double budget;   /* s of processor time, roughly, for all repeats */
    double patience; /* s: a run that takes longer is not repeated, and carries no tangent vectors if with
                        them it would take five times as long */
} effort;

/* Errors that a perturbation of the start brings about: what no integrator of that tolerance can be blamed
 * for. */
typedef struct condition {
    double events, state;
} condition;

double median(double *values, int count);
/* Runs from the reference's state once around the orbit, and with `how` once more with the derivative. */
measure measure_method(const problem *p, const method *m, double rtol, derivative how, const effort *e);
/* The largest errors after changing one component of the start by `amount` of the orbit's size. */
condition measure_condition(const problem *p, double amount);

#endif
