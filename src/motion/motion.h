/* Private: shared by classification and the search for attractors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_PRIVATE_H
#define SALTUS_MOTION_PRIVATE_H

#include "saltus/system.h"

enum { SALTUS_STATE_MAX = 160 };

/* Largest difference of two states, each component relative to the system's scale. */
double saltus_section_distance(const saltus_system *system, const double *a, const double *b);

#endif
