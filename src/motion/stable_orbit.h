/* Private: stable orbits among points that look chaotic.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_STABLE_ORBIT_H
#define SALTUS_MOTION_STABLE_ORBIT_H

#include "saltus/motion.h"

/* Look for a stable orbit of up to 12 periods by Newton's method, from the best returns among `count` section
 * points of one trajectory (dimension numbers each). Where one is *found, it is described by the motion, to
 * be cleared. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_stable_orbit_among(const saltus_system *system, const saltus_flow_options *flow,
                                        const double *points, long long count, saltus_motion *motion,
                                        bool *found, saltus_message *message);

#endif
