/* The other libraries' integrators that take part in the benchmark of the sweep.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_SWEEP_RIVALS_H
#define SALTUS_BENCH_SWEEP_RIVALS_H

#include "rivals.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Boost.Odeint on the pipe with the paper's five modes (RIVAL_BAD_ARGUMENT for others), in the form of
 * `rival_run`. Events are located on the dense output of dopri5, and by steps done again with Fehlberg 7(8),
 * which has none. */
int sweep_odeint_dopri5(const rival_pipe *pipe, const double *state0, int periods, double rtol, double atol,
                        rival_result *result);
int sweep_odeint_fehlberg78(const rival_pipe *pipe, const double *state0, int periods, double rtol,
                            double atol, rival_result *result);

#ifdef __cplusplus
}
#endif
#endif
