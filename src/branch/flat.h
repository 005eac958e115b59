/* Private: touches of a stop at which more than the speed is zero.
 *
 * Without damping, orbits without impacts form families where a free vibration comes back after the period.
 * Among them may be one whose gap touches zero with g' = g'' = g''' = 0. Towards its parameters all impacts
 * of other orbits, and contacts between them, shrink to that touch, with the time between them as the root
 * of the distance; their own equations become singular before. Those of the touch determine the place.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_FLAT_H
#define SALTUS_BRANCH_FLAT_H

#include "branch/locus_point.h"

/* Whether all events of the curve of `here` shrink to such touches just ahead; `at` becomes the orbit there,
 * with its doubt. Lack of memory is noted in the orbits. */
bool saltus_flat_touch(saltus_extended *extended, const saltus_locus_point *here, saltus_locus_point *at);

#endif
