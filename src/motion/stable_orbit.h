/* Private: stable orbits among points that look chaotic.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_STABLE_ORBIT_H
#define SALTUS_MOTION_STABLE_ORBIT_H

#include "saltus/motion.h"

/* Section points of one trajectory, one forcing period apart. */
typedef struct saltus_track {
    const double *points;  /* count x dimension */
    const double *growths; /* logarithm of a tangent vector's growth from the point before until each */
    long long count;
} saltus_track;

/* Look for a stable orbit of up to 64 periods by Newton's method, from the best returns along the tracks,
 * shortest periods first. Where one is *found, it is described by the motion, to be cleared. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status saltus_stable_orbit_among(const saltus_system *system, const saltus_flow_options *flow,
                                        const saltus_track *tracks, int track_count, saltus_motion *motion,
                                        bool *found, saltus_message *message);

#endif
