/* Saltus' side of the sweep's benchmark.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_SWEEP_OWN_H
#define SALTUS_BENCH_SWEEP_OWN_H

#include "sweep_motion.h"

#include "saltus/saltus.h"

typedef struct own_request {
    int lanes;
    double rtol;     /* atol is a thousandth of it */
    int order;       /* 0: automatic */
    bool strobe;     /* record stroboscopic states */
    double step_max; /* longest step in units of time; 0: as the integrator likes */
} own_request;

/* What a sweep cost. */
typedef struct sweep_cost {
    double seconds, wall;
    long long steps, evaluations;
} sweep_cost;

/* Goes one forcing period on from `state` (both states motion_dimension long) and counts the impacts, with
 * lanes and records left aside. */
saltus_status own_period(const saltus_system *system, const own_request *request, const double *state,
                         double *end, int *impacts, saltus_message *message);

/* Runs every system from its default state and fills `motions` (length `count`). Errors are those of the
 * flow. */
saltus_status own_sweep(saltus_system *const *systems, int count, const own_request *request, motion *motions,
                        sweep_cost *cost, saltus_message *message);

typedef struct engine_request {
    int lanes, threads;
    double rtol;   /* atol is a thousandth of it */
    unsigned keep; /* SALTUS_KEEP_ bits */
    bool adaptive; /* record once the period is certain, after at most as many periods as are run otherwise */
    bool stopped;  /* with the stop */
} engine_request;

/* The axis that all programs go along. */
saltus_axis engine_axis(void);

/* Sweeps the whole axis and fills `motions` (length of the axis), whose impacts have phases for times.
 * Errors are those of the sweep. */
saltus_status engine_sweep(const engine_request *request, motion *motions, sweep_cost *cost,
                           saltus_message *message);

#endif
