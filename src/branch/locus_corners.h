/* Private: the points of codimension two on a step along a locus.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_LOCUS_CORNERS_H
#define SALTUS_BRANCH_LOCUS_CORNERS_H

#include "branch/locus_point.h"

enum { SALTUS_CROSSINGS_MAX = 32 };
/* Zeros of the functions at a locus's points, in their order. */
typedef struct saltus_locus_zeros {
    int count;
    struct saltus_locus_zero {
        int corner;
        double place; /* ahead of `here` */
        bool crosses; /* another curve of the same equations does */
    } zero[SALTUS_CROSSINGS_MAX];
} saltus_locus_zeros;

/* All corners on the way from `here` to `next`. Where the curve ends at another impact's birth or death a
 * multiplier is infinite, and other functions may vanish with it: they tell nothing. False: the orbit changes
 * its events, but where cannot be located. */
bool saltus_locus_find_corners(saltus_extended *extended, const saltus_locus_point *here,
                               const saltus_locus_point *next, saltus_locus_point *scratch,
                               saltus_locus_zeros *found);
/* The point at such a zero, seen; false where it cannot be had. */
bool saltus_locus_visit_zero(saltus_extended *extended, const saltus_locus_point *here,
                             const struct saltus_locus_zero *zero, saltus_locus_point *out);

#endif
