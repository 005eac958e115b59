/* Private: cycles that motions settle on where an equilibrium has met a stop.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_NEWBORN_H
#define SALTUS_BRANCH_NEWBORN_H

#include "branch/rest.h"
#include "branch/special.h"

/* The stable cycles that begin at `at`, an equilibrium that touches a face, with any events in a period and
 * whatever other faces hold: added to `starts` where they are not there, as saltus_boundary_leave adds its
 * own. The equations become those of the contacts of `at`; `scratch` is overwritten. Which motions are tried
 * is fixed: that none is found does not tell that there is none. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_newborn_find(saltus_rests *rests, const saltus_rest *at, int face,
                                  const saltus_orbit_options *options, const saltus_branch_start *like,
                                  saltus_rest *scratch, saltus_starts *starts, saltus_message *message);

#endif
