/* Private: points of a branch as they are given out.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_POINT_H
#define SALTUS_BRANCH_POINT_H

#include "base/field.h"
#include "branch/solution.h"
#include "saltus/branch.h"

/* "regular", "LP", ... */
extern const saltus_word saltus_point_words[];

/* Room for the arrays of a point of so many states and events; what need not be known is NAN. Cleared where
 * memory is lacking. */
saltus_status saltus_point_open(saltus_branch_point *point, int dimension, int events,
                                saltus_message *message);
/* All that a surveyed solution tells of a point. Where events change the flow sees one side or the other by
 * chance: there events and state are those `prescribed`. `*returns`: of a cycle to its section, -1 where they
 * are not known. The point owns its arrays: saltus_branch_point_clear. Errors: SALTUS_NO_MEMORY, those of the
 * flow. */
saltus_status saltus_point_make(saltus_orbits *orbits, const saltus_solution *solution, bool prescribed,
                                saltus_branch_point *point, int *returns, saltus_message *message);
/* The touch at grazing is that of a breach. */
void saltus_point_mark_grazing(const saltus_orbits *orbits, const saltus_breach *breach,
                               saltus_branch_point *point);

#endif
