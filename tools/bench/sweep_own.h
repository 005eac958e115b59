/* Saltus' side of the sweep's benchmark.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_SWEEP_OWN_H
#define SALTUS_BENCH_SWEEP_OWN_H

#include "sweep_motion.h"

#include "saltus/saltus.h"

typedef struct own_request {
    int lanes;
    double rtol;     /* atol is rtol / 1000 */
    int order;       /* 0: automatic */
    bool strobe;     /* record stroboscopic states */
    double step_max; /* longest step in units of time; 0: no limit */
} own_request;

/* What a sweep cost. */
typedef struct sweep_cost {
    double seconds, wall;
    long long steps, evaluations;
} sweep_cost;

/* Advance one forcing period from `state` (both states have motion_dimension entries) and count the impacts,
 * without lanes and records. */
saltus_status own_period(const saltus_system *system, const own_request *request, const double *state,
                         double *end, int *impacts, saltus_message *message);

/* Run every system from its default state and fill `motions` (length `count`). Errors: those of the flow. */
saltus_status own_sweep(saltus_system *const *systems, int count, const own_request *request, motion *motions,
                        sweep_cost *cost, saltus_message *message);

typedef struct engine_request {
    int lanes, threads;
    double rtol;   /* atol is rtol / 1000 */
    unsigned keep; /* bits SALTUS_KEEP_... */
    bool adaptive; /* record as soon as the period is certain, at the latest after as many periods as
                      otherwise */
    bool stopped;  /* whether the scene has the stop */
} engine_request;

/* The axis of all programs. */
saltus_axis engine_axis(void);

/* Sweep the whole axis and fill `motions` (length of the axis), with phases as times of impacts. Errors:
 * those of the sweep. */
saltus_status engine_sweep(const engine_request *request, motion *motions, sweep_cost *cost,
                           saltus_message *message);

#endif
