/* Private: returns of a motion without forcing to its section, and stable orbits among them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_SECTION_POINTS_H
#define SALTUS_MOTION_SECTION_POINTS_H

#include "saltus/motion.h"

/* The next returns of a trajectory from a state: up to `room` section points (dimension numbers each) and
 * when they came, in the system's periods; fewer where twice as many periods have passed. Errors: those of
 * the flow.
 */
saltus_status saltus_motion_section_points(const saltus_system *system, const saltus_flow_options *flow,
                                           const double *state, long long room, double *points, double *times,
                                           long long *count, saltus_message *message);
/* Look for a stable orbit of up to 16 returns by Newton's method with unknown period from the closest returns
 * among section points, shortest first. It must pass by the points as near as these come back. Where one is
 * *found, it is described by the motion, to be cleared. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_stable_cycle_among(const saltus_system *system, const saltus_flow_options *flow,
                                        const double *points, const double *times, long long count,
                                        saltus_motion *motion, bool *found, saltus_message *message);

#endif
