/* Private: finding an orbit with no more of its multipliers than are wanted.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_PRIVATE_H
#define SALTUS_ORBIT_PRIVATE_H

#include "saltus/orbit.h"

/* All multipliers take as long as two or three of Newton's steps. */
typedef enum saltus_multipliers_wanted {
    SALTUS_MULTIPLIERS_NONE,
    SALTUS_MULTIPLIERS_LEADING, /* the leading one alone, if Newton's method clearly tells it; else all */
    SALTUS_MULTIPLIERS_ALL
} saltus_multipliers_wanted;

/* saltus_orbit_find with the wanted multipliers: unless these are all, `multiplier_count` tells how many
 * there are, and the monodromy matrix, the sum rule and what contacts wipe out are unknown. */
saltus_status saltus_orbit_search(const saltus_system *system, int periods, const double *guess,
                                  const saltus_orbit_options *options, saltus_multipliers_wanted wanted,
                                  saltus_orbit *orbit, saltus_message *message);

/* All multipliers of an orbit found at options->phase of the flow's system. They are those of any point of
 * the orbit: of one amid a flight if the given one lies on a stop, where rounding would decide on an impact.
 */
saltus_status saltus_orbit_all_multipliers(saltus_flow *flow, const saltus_orbit_options *options,
                                           saltus_orbit *orbit, saltus_message *message);

#endif
