/* Private: states of a system, drawn at random, disturbed, brought back onto stops, watched for growing
 * without bound.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_STATE_H
#define SALTUS_SYSTEM_STATE_H

#include "saltus/system.h"

#include <gsl/gsl_rng.h>

/* saltus_system_distance, or INFINITY where it is more than a limit. */
double saltus_system_distance_within(const saltus_system *system, const double *a, const double *b,
                                     double limit);
/* A state drawn from the system's scales, beyond no stop. Errors: SALTUS_BAD_INPUT where there is none. */
saltus_status saltus_state_random(const saltus_system *system, gsl_rng *rng, double *state,
                                  saltus_message *message);
/* Bring a state that lies beyond stops back onto them, each time along the stop's normal. */
void saltus_state_admit(const saltus_system *system, double *state);
/* Move a state by a random vector, `size` of the system's scales, along the faces with bits in `contacts`:
 * one way, or the other way where only that leads beyond no stop. Where both do it is brought back. */
void saltus_state_disturb(const saltus_system *system, gsl_rng *rng, double size, unsigned contacts,
                          double *state);
/* Whether no pre-load holds a state, in contact with faces of bits in `contacts`, at more than 100 of the
 * scales. Errors: SALTUS_STALLED, with the entry. */
saltus_status saltus_state_load(const saltus_system *system, const double *state, unsigned contacts,
                                saltus_message *message);
/* Whether a state after so many periods is within 1e8 of the scales; the load is looked at once. Errors:
 * SALTUS_STALLED, with the entry and the period. */
saltus_status saltus_state_bounded(const saltus_system *system, const double *state, unsigned contacts,
                                   long long periods, saltus_message *message);

#endif
