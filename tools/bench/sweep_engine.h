/* The sweep's benchmark through the library's own sweeps.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_SWEEP_ENGINE_H
#define SALTUS_BENCH_SWEEP_ENGINE_H

#include "sweep_own.h"

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
