/* Floquet multipliers by orthogonal iteration around the orbit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_MULTIPLIERS_H
#define SALTUS_ORBIT_MULTIPLIERS_H

#include "saltus/orbit.h"

/* Fill orbit->monodromy, multipliers, sticks, log_volume and sum_rule from orbit->state, which must be a
 * periodic point of period orbit->periods. The arrays are allocated. Errors: those of the flow,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_orbit_multipliers(const saltus_system *system, const saltus_orbit_options *options,
                                       saltus_orbit *orbit, saltus_message *message);

#endif
