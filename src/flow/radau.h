/* The stiff integrator: collocation at 16 Radau points.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_RADAU_H
#define SALTUS_FLOW_RADAU_H

#include "flow/collocation.h"
#include "flow/kernel.h"

enum { SALTUS_RADAU_DEGREE = SALTUS_RADAU_NODES + 1 }; /* of the displacements' polynomial */

typedef struct saltus_radau saltus_radau;

/* A stiff integrator for one system and a number of tangent columns, the last ones of them parameter columns.
 * All memory is allocated here. */
saltus_status saltus_radau_open(saltus_radau **radau, const saltus_system *system, int columns,
                                int directions, saltus_tolerance tolerance);
/* Take another system of the same shape; directions are forgotten. */
void saltus_radau_retune(saltus_radau *radau, const saltus_system *system);
/* How the system changes along a direction. */
void saltus_radau_vary(saltus_radau *radau, int direction, const saltus_variation *variation);
/* NULL is accepted. */
void saltus_radau_close(saltus_radau *radau);
/* Forget everything: for starts. */
void saltus_radau_reset(saltus_radau *radau);
/* The state or the contacts have changed along the same trajectory: the next step starts small. */
void saltus_radau_impact(saltus_radau *radau);
/* How long the boundary layers at the state and phase in `work` last that a step of a length could not
 * resolve. Behind them the next step will be tried with that length. */
double saltus_radau_layers(saltus_radau *radau, const saltus_work *work, double step, long long *evaluations);
/* Take over the held contacts from the flow's work. */
void saltus_radau_publish(saltus_radau *radau, const saltus_work *work);
/* From the state and phase in `work`, make one step, which may reach beyond the target (what is left), where
 * the flow cuts it. Fills the work's jets (monomials in time, up to SALTUS_RADAU_DEGREE), gap and force
 * series, and its step. Field evaluations are added to *evaluations. Errors: SALTUS_STALLED when no step
 * converges. */
saltus_status saltus_radau_step(saltus_radau *radau, saltus_work *work, long long *evaluations);

#endif
