/* The stiff integrator: collocation at 16 Radau points.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_RADAU_H
#define SALTUS_FLOW_RADAU_H

#include "flow/collocation.h"
#include "flow/kernel.h"

enum { SALTUS_RADAU_DEGREE = SALTUS_RADAU_NODES + 1 }; /* of the displacements' polynomial */

typedef struct saltus_radau saltus_radau;

/* Open a stiff integrator for one system with `columns` tangent vectors, the last `directions` of them
 * parameter columns. All memory is allocated here. */
saltus_status saltus_radau_open(saltus_radau **radau, const saltus_system *system, int columns,
                                int directions, saltus_tolerance tolerance);
/* Take another system of the same shape; its directions must be set again. */
void saltus_radau_retune(saltus_radau *radau, const saltus_system *system);
/* Set the system's derivative along a direction. */
void saltus_radau_vary(saltus_radau *radau, int direction, const saltus_variation *variation);
/* NULL is accepted. */
void saltus_radau_close(saltus_radau *radau);
/* To be called at starts: nothing is known of earlier steps. */
void saltus_radau_reset(saltus_radau *radau);
/* To be called at events: state or contacts have changed, so the next step starts small. */
void saltus_radau_impact(saltus_radau *radau);
/* How long the boundary layers at the state and phase in `work` last that a step of length `step` would not
 * resolve; 0: there are none. The next step will try that length. */
double saltus_radau_layers(saltus_radau *radau, const saltus_work *work, double step, long long *evaluations);
/* Take the held contacts from the flow's work. */
void saltus_radau_publish(saltus_radau *radau, const saltus_work *work);
/* Make one step from the state and phase in `work`. It may reach beyond the target (`left`), where the flow
 * cuts it. Fills the work's jets (monomials in time, up to SALTUS_RADAU_DEGREE), gap and force series, and
 * its step; adds field evaluations to *evaluations. Errors: SALTUS_STALLED when no step converges. */
saltus_status saltus_radau_step(saltus_radau *radau, saltus_work *work, long long *evaluations);

#endif
