/* Change of phase-space volume by the flow: the other side of the sum rule (model.md, section 1).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_VOLUME_H
#define SALTUS_ORBIT_VOLUME_H

#include "saltus/flow.h"

#include <gsl/gsl_integration.h>

enum { SALTUS_TRACE_POINTS = 6 };

/* Integral of the Jacobian's trace over a lane's last step, by Gauss quadrature on its dense output with a
 * table of SALTUS_TRACE_POINTS points. *steps is the lane's number of steps at the previous call, initially
 * the present one. The integral is 0 if no step was made since, as between simultaneous impacts or if an
 * event falls on the target. */
double saltus_trace_over_step(const saltus_flow *flow, int lane, const gsl_integration_glfixed_table *table,
                              long long *steps);
/* Number of directions that an event maps to zero: two per lasting contact; one for an impact without
 * rebound. */
int saltus_lost_directions(const saltus_flow *flow, int lane, const saltus_event *event);

#endif
