/* Private: points of codimension two on a locus: where one condition more holds.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_CORNER_H
#define SALTUS_BRANCH_CORNER_H

#include "branch/extended.h"

enum { SALTUS_CORNERS_MAX = 6 };

/* A function along a locus whose zero is a point of codimension two. */
typedef struct saltus_corner {
    saltus_point_kind kind;
    saltus_scaled value;
    bool ends; /* beyond it there is no such curve */
} saltus_corner;

/* The worst breach of an orbit but for the grazing impact that is followed. */
double saltus_corner_breach(const saltus_extended *extended, const saltus_solution *orbit);
/* All functions at a point, from what the extended equations have seen there, and the orbit there. Returns
 * their number, which depends on the kind of locus alone; -1 without memory. */
int saltus_corner_measure(const saltus_extended *extended, const saltus_curve_point *point,
                          const saltus_solution *orbit, saltus_corner *corners);

#endif
