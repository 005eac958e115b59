/* Private: the points of codimension two on a step along a locus.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_LOCUS_CORNERS_H
#define SALTUS_BRANCH_LOCUS_CORNERS_H

#include "branch/locus_point.h"

enum { SALTUS_CROSSINGS_MAX = 32 };
/* Zeros of functions on a step, in order. */
typedef struct saltus_locus_zeros {
    int count;
    struct saltus_locus_zero {
        int corner;
        double place, tolerance; /* ahead of `here`; of the equations */
        bool crosses;            /* another curve of the same equations crosses there */
    } zero[SALTUS_CROSSINGS_MAX];
} saltus_locus_zeros;

/* All corners from `here` to `next`. If the curve ends at another impact's birth or death a multiplier is
 * infinite there, so other functions that may vanish with it are ignored. False: the events of the orbit
 * change, but the place cannot be located. */
bool saltus_locus_find_corners(saltus_extended *extended, const saltus_locus_point *here,
                               const saltus_locus_point *next, saltus_locus_point *scratch,
                               saltus_locus_zeros *found);
/* The point at such a zero, evaluated, with its doubt; false if it cannot be found. */
bool saltus_locus_visit_zero(saltus_extended *extended, const saltus_locus_point *here,
                             const struct saltus_locus_zero *zero, saltus_locus_point *out);

#endif
