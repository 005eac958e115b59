/* Private: points of codimension two on a locus: where one condition more holds.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_CORNER_H
#define SALTUS_BRANCH_CORNER_H

#include "branch/extended.h"

enum { SALTUS_CORNERS_MAX = 7, SALTUS_CLOSE_MAX = 8 };

/* Complex numbers next to the unit circle. */
typedef struct saltus_close {
    int count;
    double re[SALTUS_CLOSE_MAX], im[SALTUS_CLOSE_MAX];
} saltus_close;

/* A function along a locus whose zero is a point of codimension two. */
typedef struct saltus_locus_test {
    saltus_point_kind kind;
    saltus_scaled value;
    double quiet; /* a determinant of no more than e to this is rounding; 0: it is none */
    bool breach;  /* the worst of the orbit, which must be negative */
    bool ends;    /* beyond it there is no such curve */
    bool without; /* on a curve of grazing: seen without the impact */
    bool joins; /* on a curve of grazing: the orbit there is one of half the period, or its own mirror image,
                   unlike those of the curve */
    /* GR-NS: the angle of the pair of multipliers on the unit circle, NAN where there is none; and those
     * multipliers, and those real products of two, that are next to the unit circle. */
    double theta;
    saltus_close single, product;
} saltus_locus_test;

/* The worst breach of an orbit but for the grazing impact that is followed, NULL: there is no other; where
 * that is a maximum of the gap at an impact that has lost its speed, the impact. */
const saltus_breach *saltus_corner_touch(const saltus_extended *extended, const saltus_solution *orbit);
/* The value of the worst, -1 for none. */
double saltus_corner_breach(const saltus_extended *extended, const saltus_solution *orbit);
/* Whether a breach is that of a contact, which chatter has led to, that shrinks to nothing. */
bool saltus_corner_ends_chatter(const saltus_solution *orbit, const saltus_breach *breach);
/* The marks of an orbit without the grazing impact that is followed, and its image. */
saltus_sequence saltus_corner_without(const saltus_extended *extended, const saltus_solution *orbit);
/* All functions at a point, from what the extended equations have seen there, and the orbit there. Returns
 * their number, which depends on the kind of locus alone; -1 without memory. */
int saltus_corner_measure(const saltus_extended *extended, const saltus_curve_point *point,
                          const saltus_solution *orbit, saltus_locus_test *corners);

/* Whether multipliers, or products of them, may have crossed the unit circle between two points and come
 * back, or have moved so far that functions of them may: by GR-NS at both. */
bool saltus_corner_hides(const saltus_locus_test *a, const saltus_locus_test *b);
/* Whether between two points of a curve of grazing, by all their functions, more or fewer multipliers have
 * entered the unit circle than the signs of these tell: there are zeros of which they tell nothing. */
bool saltus_corner_misses(const saltus_locus_test *a, const saltus_locus_test *b, int count);
/* What the corner is that has been located at an orbit: where that is its own mirror image, a fold (GR-LP),
 * along whose null vector the orbits keep this symmetry, or a branch point (GR-BP), along whose they lose it;
 * where a contact that chatter led to shrinks to nothing, CH-GR; where another contact begins or ends EP.
 * Otherwise it is corner->kind. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_corner_tell(const saltus_extended *extended, const saltus_locus_test *corner,
                                 const saltus_solution *orbit, saltus_point_kind *kind,
                                 saltus_message *message);

/* The finite multipliers of the orbit that a shooting has last evaluated: how many, at most n; -1 without
 * memory. With an impact that grazes one is infinite: what is sought are those of the inverse of the
 * equations with a shift, 1 / (mu - shift). */
int saltus_corner_multipliers(saltus_shooting *shooting, int n, double *re, double *im);

#endif
