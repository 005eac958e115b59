/* Private: shared by classification, description and the search for attractors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_PRIVATE_H
#define SALTUS_MOTION_PRIVATE_H

#include "base/progress.h"
#include "motion/evidence.h"
#include "orbit/lap.h"
#include "system/state.h"

/* Options of Newton's method that suit those of a classification. */
saltus_orbit_options saltus_motion_shooting(const saltus_classify_options *options);

/* saltus_classify; *stopped: the caller has ended it. */
saltus_status saltus_motion_classify(const saltus_system *system, const double *state,
                                     const saltus_classify_options *options, saltus_motion *motion,
                                     bool *stopped, saltus_message *message);
/* Judge a motion that has not settled: fills verdict, reason, exponent and evidence, and moves motion->state
 * on along the attractor. The verdict stays SALTUS_UNDECIDED where more time may bring a period; the outcome
 * tells whether it should. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_motion_judge(const saltus_system *system, const saltus_classify_options *options,
                                  saltus_motion *motion, saltus_outcome *outcome, saltus_message *message);
/* Nothing has been measured: numbers are NAN. */
void saltus_motion_forget_evidence(saltus_motion *motion);
/* Label a motion without a period, and measure its extremes from its state on. Errors: those of the flow. */
saltus_status saltus_motion_survey(const saltus_system *system, saltus_flow *flow, saltus_motion *motion,
                                   saltus_message *message);
/* Settle and find a period, as saltus_classify does, without judging a motion that has none; `limited`: no
 * very long orbits of very many impacts. */
saltus_status saltus_motion_find_period(const saltus_system *system, const double *state,
                                        const saltus_classify_options *options, bool limited,
                                        saltus_motion *motion, saltus_message *message);

/* An undecided motion with room for a state; false if there is no memory. */
bool saltus_motion_open(const saltus_system *system, const saltus_flow_options *flow, saltus_motion *motion);
/* Fill an open motion with what is said of a periodic orbit; the lap around it becomes the motion's. */
saltus_status saltus_motion_take(const saltus_system *system, saltus_flow *flow, const saltus_orbit *orbit,
                                 saltus_lap *lap, const saltus_classify_options *options,
                                 saltus_motion *motion, saltus_message *message);
/* The stable orbit that Newton's method finds from a state which closes after about `periods`, described. The
 * method makes so many steps at most, 0: as many as usual. The motion is to be cleared. Errors:
 * SALTUS_NO_CONVERGENCE where there is none within `near`, relative to the system's scales; those of the
 * flow, SALTUS_NO_MEMORY. */
saltus_status saltus_motion_polish(const saltus_system *system, int periods, const double *state, double near,
                                   int steps, const saltus_classify_options *options, saltus_motion *motion);
/* Fill an open motion that has no orbit, whose verdict is known, from the flow's present state. */
saltus_status saltus_motion_rest(const saltus_system *system, saltus_flow *flow,
                                 const saltus_classify_options *options, saltus_motion *motion,
                                 saltus_message *message);

#endif
