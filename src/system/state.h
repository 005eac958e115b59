/* Private: states of a system: random ones, disturbances, moves back onto stops, checks for unbounded growth.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_STATE_H
#define SALTUS_SYSTEM_STATE_H

#include "saltus/system.h"

#include <gsl/gsl_rng.h>

/* saltus_system_distance, or INFINITY if it exceeds `limit`. */
double saltus_system_distance_within(const saltus_system *system, const double *a, const double *b,
                                     double limit);
/* A random state with the system's scales, beyond no stop. Errors: SALTUS_BAD_INPUT if there is none. */
saltus_status saltus_state_random(const saltus_system *system, gsl_rng *rng, double *state,
                                  saltus_message *message);
/* Move a state that lies beyond stops back onto them, along each stop's normal. */
void saltus_state_admit(const saltus_system *system, double *state);
/* Move a state by a random vector of `size` times the scales, tangentially to the faces with bits in
 * `contacts`: one way, or the other if the first leads beyond a stop. If both do, move it back onto stops. */
void saltus_state_disturb(const saltus_system *system, gsl_rng *rng, double size, unsigned contacts,
                          double *state);
/* Fails if a pre-load holds a state, in contact with the faces with bits in `contacts`, beyond 100 times the
 * scales. Errors: SALTUS_STALLED, with the entry. */
saltus_status saltus_state_load(const saltus_system *system, const double *state, unsigned contacts,
                                saltus_message *message);
/* Fails if a state exceeds 1e8 times the scales after the given number of periods; also checks the load,
 * once. Errors: SALTUS_STALLED, with the entry and the period. */
saltus_status saltus_state_bounded(const saltus_system *system, const double *state, unsigned contacts,
                                   long long periods, saltus_message *message);

#endif
