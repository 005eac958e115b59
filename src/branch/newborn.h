/* Private: cycles on which motions settle near an equilibrium that has met a stop.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_NEWBORN_H
#define SALTUS_BRANCH_NEWBORN_H

#include "branch/rest.h"
#include "branch/special.h"

/* Add to `starts` stable cycles that begin at `at`, an equilibrium that touches a face, unless they are there
 * already; with any events in a period and whatever other faces hold; in the form of saltus_boundary_leave.
 * The equations are shaped for the contacts of `at`; `scratch` is overwritten. A fixed set of motions is
 * tried: to find no cycle does not prove that there is none. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_newborn_find(saltus_rests *rests, const saltus_rest *at, int face,
                                  const saltus_orbit_options *options, const saltus_branch_start *like,
                                  saltus_rest *scratch, saltus_starts *starts, saltus_message *message);

#endif
