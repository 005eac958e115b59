/* Private: equilibria as points of a branch.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_REST_POINT_H
#define SALTUS_BRANCH_REST_POINT_H

#include "branch/rest.h"
#include "branch/trail.h"

/* Give out an equilibrium as a point of a branch or, if the equations are those of special ones, of a locus.
 * A BE, and each point of their locus, tells the face that is touched. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_rest_give(const saltus_rests *rests, const saltus_rest *rest, const saltus_notice *what,
                               saltus_trail *trail, saltus_message *message);
/* "equilibrium" or "held". */
const char *saltus_rest_label(unsigned contacts);

#endif
