/* Private: typical sizes of a model's motion.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_LASTING_H
#define SALTUS_SYSTEM_LASTING_H

#include "system/system.h"

#include <math.h>

/* The smallest clearance but zero; 0: there is none. *between: whether a stop has two sides. */
static inline double saltus_least_clearance(const saltus_system *system, bool *between) {
    double least = 0;
    *between = false;
    for (int s = 0; s < system->spec.stop_count; s++) {
        const saltus_stop *stop = &system->spec.stops[s];
        const double offset = system->offset[s];
        const double d = fabs(stop->sides == SALTUS_LOWER ? stop->d + offset : stop->d - offset);
        *between |= stop->sides == SALTUS_BOTH;
        if (d > 0 && (least == 0 || d < least))
            least = d;
    }
    return least;
}

/* How fast a motion is that lasts, against which the stiffness of a model is measured: the rate at which a
 * degree of freedom of this stiffness and damping (by mass) swings or, if it is overdamped, creeps once its
 * fast part has died. */
static inline double saltus_lasting_rate(double stiffness, double damping) {
    const double swings = sqrt(stiffness);
    return damping > swings ? stiffness / damping : swings;
}

#endif
