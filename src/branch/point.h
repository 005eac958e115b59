/* Private: points of a branch as they are given out.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_POINT_H
#define SALTUS_BRANCH_POINT_H

#include "base/field.h"
#include "branch/solution.h"
#include "saltus/branch.h"

/* "regular", "LP", ... */
extern const saltus_word saltus_point_words[];

/* Allocate a point for `dimension` states and this number of events; values that may stay unknown are NAN.
 * False without memory; the point is then cleared. */
bool saltus_point_open(saltus_branch_point *point, int dimension, int events);
/* Fill a point with what a surveyed solution tells. At changes of events it is chance which side the flow
 * sees: there take the `prescribed` events and state. *returns: the returns of a cycle to its section, -1 if
 * unknown. The point owns its arrays (saltus_branch_point_clear). False without memory, which is noted. */
bool saltus_point_make(saltus_orbits *orbits, const saltus_solution *solution, bool prescribed,
                       saltus_branch_point *point, int *returns);
/* Record a breach as the touch at grazing, or of an equilibrium. */
void saltus_point_mark_grazing(const saltus_system *system, const saltus_breach *breach,
                               saltus_branch_point *point);

#endif
