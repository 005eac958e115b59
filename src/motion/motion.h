/* Private: shared by classification, description and the search for attractors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_PRIVATE_H
#define SALTUS_MOTION_PRIVATE_H

#include "saltus/motion.h"

#include <gsl/gsl_rng.h>

enum { SALTUS_STATE_MAX = 160 };

/* Largest difference of two states, each component relative to the system's scale. */
double saltus_section_distance(const saltus_system *system, const double *a, const double *b);

/* Whether the caller has asked to stop. */
bool saltus_motion_stopped(const saltus_flow_options *options);
/* Whether all multipliers are inside the unit circle. */
bool saltus_motion_orbit_stable(const saltus_orbit *orbit);
/* Options of Newton's method that suit those of a classification. */
saltus_orbit_options saltus_motion_shooting(const saltus_classify_options *options);

/* A state drawn from the system's scales, beyond no stop. Errors: SALTUS_BAD_INPUT where none could be found.
 */
saltus_status saltus_motion_random_state(const saltus_system *system, gsl_rng *rng, double *state,
                                         saltus_message *message);

/* Move a state by a random vector, `size` of the system's scales, unless that leads beyond a stop. */
void saltus_motion_disturb(const saltus_system *system, gsl_rng *rng, double size, double *state);

/* Whether a motion stays within 1e8 of its scales. Errors: SALTUS_STALLED, with the entry and the period. */
saltus_status saltus_motion_bounded(const saltus_system *system, const double *state, long long periods,
                                    saltus_message *message);

/* The contact events of one orbit, counted (model.md, section 4). */
typedef struct saltus_tally {
    long long impacts, events;
    long long by_face[SALTUS_FACES_MAX];
    int sticks, releases;
    bool rebounds; /* a stop that throws back holds for a while */
    bool chatter;  /* infinitely many impacts ended in a sticking interval */
} saltus_tally;

/* Count an impact, a stick or a release; other events do not count. */
void saltus_tally_event(saltus_tally *tally, const saltus_system *system, const saltus_event *event);
/* Whether an event reverses the normal velocity: an impact, or a stick with which a chatter ends. */
bool saltus_event_strikes(const saltus_event *event);

/* Judge a motion that has not settled: fills kind, reason, exponent and evidence, and moves motion->state on
 * along the attractor. kind stays SALTUS_UNDECIDED where more time may bring a period: *regular tells that it
 * should, as nothing irregular goes on, or as other trajectories have come to one; *stopped that the caller
 * has ended the search. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_motion_judge(const saltus_system *system, const saltus_classify_options *options,
                                  saltus_motion *motion, bool *regular, bool *stopped,
                                  saltus_message *message);
/* Nothing has been measured: numbers are NAN. */
void saltus_motion_forget_evidence(saltus_motion *motion);
/* Name a motion without a period, and measure its extremes from its state on. Errors: those of the flow. */
saltus_status saltus_motion_survey(const saltus_system *system, saltus_flow *flow, saltus_motion *motion,
                                   saltus_message *message);
/* Settle and find a period, as saltus_classify does, without judging a motion that has none. */
saltus_status saltus_motion_find_period(const saltus_system *system, const double *state,
                                        const saltus_classify_options *options, saltus_motion *motion,
                                        saltus_message *message);

/* An undecided motion with room for a state; false if there is no memory. */
bool saltus_motion_open(const saltus_system *system, const saltus_flow_options *flow, saltus_motion *motion);
/* Fill an open motion with what is said of a periodic orbit. */
saltus_status saltus_motion_take(const saltus_system *system, saltus_flow *flow, const saltus_orbit *orbit,
                                 const saltus_classify_options *options, saltus_motion *motion,
                                 saltus_message *message);
/* Fill an open motion, whose kind is known, from the flow's present state. */
saltus_status saltus_motion_rest(const saltus_system *system, saltus_flow *flow,
                                 const saltus_classify_options *options, saltus_motion *motion,
                                 saltus_message *message);

#endif
