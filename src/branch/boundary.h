/* Private: cycles that are born where an equilibrium meets a stop.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_BOUNDARY_H
#define SALTUS_BRANCH_BOUNDARY_H

#include "branch/rest.h"
#include "branch/special.h"

/* The cycles with one impact that begin at `at`, an equilibrium without contacts that touches a face: added
 * to `starts`, `like` having what is common to them. The equations are those of its contacts; `scratch` is
 * overwritten. None where another face holds, or an impact does not rebound. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_boundary_leave(saltus_rests *rests, const saltus_rest *at, int face,
                                    const saltus_branch_start *like, saltus_rest *scratch,
                                    saltus_starts *starts, saltus_message *message);
/* The cycle on the branch that such a start tells of, at a parameter so far from the start's; not surveyed,
 * with a tangent away from the equilibrium. Errors: SALTUS_NO_MEMORY; others where none is found. */
saltus_status saltus_boundary_cycle(saltus_orbits *orbits, const saltus_branch_start *start, double distance,
                                    saltus_solution *out, saltus_message *message);
/* Whether cycles with impacts, and nothing else in contact, have become small, and smaller from one to the
 * next. */
bool saltus_boundary_is_near(const saltus_solution *here, const saltus_solution *next);
/* Where such cycles shrink to an equilibrium: `zero` from `here`, the parameter's *value there, and the last
 * of them as `at`, whose sequence the shooting has. False where they do not. */
bool saltus_boundary_reach(saltus_orbits *orbits, const saltus_solution *here, const saltus_solution *next,
                           saltus_solution *at, saltus_zero *zero, double *value);

#endif
