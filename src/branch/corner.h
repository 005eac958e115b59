/* Private: points of codimension two on a locus, where one more condition holds; in short corners. Lack of
 * memory is noted in the orbits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_CORNER_H
#define SALTUS_BRANCH_CORNER_H

#include "branch/extended.h"

enum { SALTUS_CORNERS_MAX = 7, SALTUS_CLOSE_MAX = 8 };

/* The complex numbers closest to the unit circle. */
typedef struct saltus_close {
    int count;
    double re[SALTUS_CLOSE_MAX], im[SALTUS_CLOSE_MAX];
} saltus_close;

/* A function along a locus whose zero is a point of codimension two. */
typedef struct saltus_locus_test {
    saltus_point_kind kind;
    saltus_scaled value;
    double quiet; /* a value up to exp(quiet) is rounding; 0: it is not known what is */
    bool breach;  /* value is the orbit's worst breach, which must be negative */
    bool ends;    /* the curve ends there */
    bool without; /* on a curve of grazing: function of the orbit without the impact */
    bool joins;   /* on a curve of grazing: the orbit there closes after half the period, or is its own mirror
                     image, unlike those of the curve */
    /* The angle of the pair of multipliers on the unit circle, NAN if there is none: GR-NS, and where a curve
     * of tori ends; and at GR-NS the multipliers, and real products of two of them, closest to the circle. */
    double theta;
    saltus_close single, product;
} saltus_locus_test;

/* The worst breach of an orbit apart from the grazing impact that is followed; NULL: none. If it is a maximum
 * of the gap at an impact of zero speed, the breach of that impact. On curves of other points than grazing,
 * an impact that is born goes before one that dies with it. */
const saltus_breach *saltus_corner_touch(const saltus_extended *extended, const saltus_solution *orbit);
/* The value of the worst such breach, -1 for none. */
double saltus_corner_breach(const saltus_extended *extended, const saltus_solution *orbit);
/* Whether a breach says that a contact which completes chatter shrinks to zero length. */
bool saltus_corner_ends_chatter(const saltus_solution *orbit, const saltus_breach *breach);
/* The sequence of an orbit without the grazing impact that is followed and its mirror image. */
saltus_sequence saltus_corner_without(const saltus_extended *extended, const saltus_solution *orbit);
/* Evaluate all functions at a point, from the last evaluation of the extended equations and the orbit there.
 * Returns their number, which depends only on the kind of locus. */
int saltus_corner_measure(saltus_extended *extended, const saltus_curve_point *point,
                          const saltus_solution *orbit, saltus_locus_test *corners);

bool saltus_corner_is_rounding(const saltus_locus_test *test);
/* Whether, between two points, multipliers or products of them may have crossed the unit circle and come
 * back, or have moved so far that functions of them may; from the GR-NS function at both. */
bool saltus_corner_hides(const saltus_locus_test *a, const saltus_locus_test *b);
/* Whether, between two points of a curve of grazing, more or fewer multipliers have entered the unit circle
 * than the signs of all functions account for: some zeros are missed. */
bool saltus_corner_misses(const saltus_locus_test *a, const saltus_locus_test *b, int count);
/* What the corner is that has been located at an orbit: where a multiplier is 1 on a curve of grazing, a fold
 * (GR-LP) or a branch point (GR-BP); where a contact that chatter led to shrinks to nothing, CH-GR, on other
 * curves CH; where another contact begins or ends, ST. Otherwise it is corner->kind. */
saltus_point_kind saltus_corner_tell(saltus_extended *extended, const saltus_locus_test *corner,
                                     const saltus_solution *orbit);

/* Take the speed of the impact of a mark, which grazes, as zero in the equations that a shooting has last
 * evaluated: what they have is a residual, which would count where other impacts after it lose its effects.
 */
void saltus_corner_still(const saltus_orbits *orbits, saltus_shooting *shooting, int mark);
/* The finite multipliers of the orbit last evaluated by a shooting; returns their number, at most n. At
 * grazing one multiplier is infinite, so the eigenvalues 1 / (mu - shift) of the inverse of the shifted
 * equations are computed. */
int saltus_corner_multipliers(saltus_orbits *orbits, saltus_shooting *shooting, double *re, double *im);

#endif
