/* How the flow changes phase-space volume: the other side of the sum rule (model.md, section 1).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_VOLUME_H
#define SALTUS_ORBIT_VOLUME_H

#include "saltus/flow.h"

#include <gsl/gsl_integration.h>

enum { SALTUS_TRACE_POINTS = 6 };

/* The integral of the Jacobian's trace over a lane's last step, by Gauss quadrature on its dense output with
 * a table of SALTUS_TRACE_POINTS points. `state` is scratch of length dimension. *steps is the lane's number
 * of steps at the last call, at first that now: without a step since, as between impacts in one instant or
 * where an event falls on the target, the integral is 0. */
double saltus_trace_over_step(const saltus_flow *flow, int lane, const gsl_integration_glfixed_table *table,
                              double *state, long long *steps);
/* How many directions of perturbations an event sends to zero: two for each lasting contact; one at an impact
 * without rebound. */
int saltus_lost_directions(const saltus_flow *flow, int lane, const saltus_event *event);

#endif
