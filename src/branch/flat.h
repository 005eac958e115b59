/* Private: touches of a stop at which more than the speed is zero.
 *
 * Without damping, orbits without impacts form families where a free vibration comes back after the period.
 * Among them may be one whose gap touches zero with g' = g'' = g''' = 0. Towards its parameters all impacts
 * of other orbits, and contacts between them, shrink to that touch, with the time between them as the root
 * of the distance; their own equations become singular before. Those of the touch determine the place.
 *
 * A touch may be followed by complete chatter. Let its g'' fall to zero: the chatter shrinks to nothing, and
 * the contact begins where g = g' = g'' = 0. The curve of grazing ends there: beyond, the gap falls without
 * a turning point until the contact begins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_FLAT_H
#define SALTUS_BRANCH_FLAT_H

#include "branch/locus_point.h"

/* Why the curve of `here` ends in such a touch just ahead: all its events shrink to it, or a touch and the
 * chatter after it; `at` becomes the orbit there, with its doubt. NULL: it does not. Lack of memory is noted
 * in the orbits. */
const char *saltus_flat_touch(saltus_extended *extended, const saltus_locus_point *here,
                              saltus_locus_point *at);

#endif
