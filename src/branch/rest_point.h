/* Private: equilibria as points of a branch, and special ones between two of them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_REST_POINT_H
#define SALTUS_BRANCH_REST_POINT_H

#include "branch/rest.h"
#include "branch/solution.h"

/* All that an equilibrium tells of a point; it owns its arrays: saltus_branch_point_clear. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status saltus_rest_point(const saltus_rests *rests, const saltus_rest *rest,
                                saltus_branch_point *point, saltus_message *message);
/* The same stop and side as what is touched at grazing. */
void saltus_rest_touch(const saltus_rests *rests, int face, saltus_branch_point *point);
/* The one parameter's share of the tangent. */
double saltus_rest_heading(const saltus_rest *rest);
/* "equilibrium" or "held". */
const char *saltus_rest_label(unsigned contacts);

/* A test, and what it needs: FOLD, CROSSING, PAIR for the product of all pairs' sums, BREACH or VALUE. */
typedef struct saltus_rest_asked {
    saltus_test test;
    int face; /* BREACH */
    double target;
} saltus_rest_asked;

/* The value at an equilibrium, products in units of those at another. */
double saltus_rest_value(saltus_rest_asked asked, const saltus_rest *rest, const saltus_rest *from);
/* Its zero between `from` and `to`, one of which may have it; `out` becomes the point there. */
saltus_zero saltus_rest_zero(saltus_rests *rests, saltus_rest_asked asked, const saltus_rest *from,
                             const saltus_rest *to, saltus_rest *out);
/* The point where branches cross near `ahead` from `from`: its equations are singular, so it is interpolated
 * from points around it, not further than a tenth of `reach`. */
saltus_zero saltus_rest_crossing(saltus_rests *rests, const saltus_rest *from, double ahead, double reach,
                                 saltus_rest *out);

#endif
