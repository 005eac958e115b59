/* Private: shared by classification, description and the search for attractors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_PRIVATE_H
#define SALTUS_MOTION_PRIVATE_H

#include "saltus/motion.h"

enum { SALTUS_STATE_MAX = 160 };

/* Largest difference of two states, each component relative to the system's scale. */
double saltus_section_distance(const saltus_system *system, const double *a, const double *b);

/* Whether all multipliers are inside the unit circle. */
bool saltus_motion_orbit_stable(const saltus_orbit *orbit);
/* Options of Newton's method that suit those of a classification. */
saltus_orbit_options saltus_motion_shooting(const saltus_classify_options *options);

/* An undecided motion with room for a state; false if there is no memory. */
bool saltus_motion_open(const saltus_system *system, saltus_motion *motion);
/* Fill an open motion with what is said of a periodic orbit. */
saltus_status saltus_motion_take(const saltus_system *system, saltus_flow *flow, const saltus_orbit *orbit,
                                 const saltus_classify_options *options, saltus_motion *motion,
                                 saltus_message *message);
/* Fill an open motion, whose kind is known, from the flow's present state. */
saltus_status saltus_motion_rest(const saltus_system *system, saltus_flow *flow,
                                 const saltus_classify_options *options, saltus_motion *motion,
                                 saltus_message *message);

#endif
