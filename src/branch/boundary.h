/* Private: cycles that are born where an equilibrium meets a stop.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_BOUNDARY_H
#define SALTUS_BRANCH_BOUNDARY_H

#include "branch/rest.h"
#include "branch/special.h"

/* Add to `starts` the cycles with one impact that begin at `at`, an equilibrium without contacts that touches
 * a face; `like` has what the starts have in common. The equations must be shaped for its contacts; `scratch`
 * is overwritten. None is added if another face holds or impacts do not rebound. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_boundary_leave(saltus_rests *rests, const saltus_rest *at, int face,
                                    const saltus_branch_start *like, saltus_rest *scratch,
                                    saltus_starts *starts, saltus_message *message);
/* The cycle of such a start at this distance in the parameter; not surveyed, with a tangent away from the
 * equilibrium. Errors: SALTUS_NO_MEMORY; others if none is found. */
saltus_status saltus_boundary_cycle(saltus_orbits *orbits, const saltus_branch_start *start, double distance,
                                    saltus_solution *out, saltus_message *message);
/* Whether cycles with impacts, but without lasting contacts, are small and shrink from `here` to `next`. */
bool saltus_boundary_is_near(const saltus_solution *here, const saltus_solution *next);
/* Where such cycles shrink to an equilibrium: `zero`, from `here`, the parameter's *value there, and the last
 * cycle as `at`, whose sequence the shooting has. False if they do not. */
bool saltus_boundary_reach(saltus_orbits *orbits, const saltus_solution *here, const saltus_solution *next,
                           saltus_solution *at, saltus_zero *zero, double *value);

#endif
