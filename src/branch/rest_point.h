/* Private: equilibria as points of a branch, and special ones between two of them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_REST_POINT_H
#define SALTUS_BRANCH_REST_POINT_H

#include "branch/rest.h"
#include "branch/solution.h"
#include "branch/trail.h"

/* Give out an equilibrium as a point of a branch or, if the equations are those of special ones, of a locus.
 * A BE, and each point of their locus, tells the face that is touched. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_rest_give(const saltus_rests *rests, const saltus_rest *rest, const saltus_notice *what,
                               saltus_trail *trail, saltus_message *message);
/* With one parameter: the tangent's component in it. */
double saltus_rest_heading(const saltus_rest *rest);
/* "equilibrium" or "held". */
const char *saltus_rest_label(unsigned contacts);

/* A test and its arguments: FOLD, CROSSING, PAIR (product of the sums of all eigenvalue pairs), BREACH or
 * VALUE. */
typedef struct saltus_rest_asked {
    saltus_test test;
    int face; /* BREACH */
    double target;
} saltus_rest_asked;

/* The value at an equilibrium; products in units of that at `from`. */
double saltus_rest_value(saltus_rest_asked asked, const saltus_rest *rest, const saltus_rest *from);
/* Its zero between `from` and `to`, or at one of them; `out` becomes the point there. */
saltus_zero saltus_rest_zero(saltus_rests *rests, saltus_rest_asked asked, const saltus_rest *from,
                             const saltus_rest *to, saltus_rest *out);
/* The point where branches cross near `ahead` of `from`. The equations are singular there, so it is
 * interpolated from points around it, at most a tenth of `reach` apart. */
saltus_zero saltus_rest_crossing(saltus_rests *rests, const saltus_rest *from, double ahead, double reach,
                                 saltus_rest *out);

#endif
