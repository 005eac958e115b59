/* Private: how fast a motion is that lasts, against which the stiffness of a model is measured.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_LASTING_H
#define SALTUS_SYSTEM_LASTING_H

#include <math.h>

/* The rate at which a degree of freedom of this stiffness and damping (by mass) swings or, if it is
 * overdamped, creeps once its fast part has died. */
static inline double saltus_lasting_rate(double stiffness, double damping) {
    const double swings = sqrt(stiffness);
    return damping > swings ? stiffness / damping : swings;
}

#endif
