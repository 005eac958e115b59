/* Private: points of a locus, and where a curve ends. Corners between two of them: locus_corners.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_LOCUS_POINT_H
#define SALTUS_BRANCH_LOCUS_POINT_H

#include "branch/corner.h"

typedef struct saltus_locus_point {
    saltus_curve_point at;
    saltus_solution orbit;
    saltus_locus_test corners[SALTUS_CORNERS_MAX];
    int corner_count;
    /* The functions at the point before it on the curve, and its place from here; 0: there is none. */
    saltus_scaled before[SALTUS_CORNERS_MAX];
    double before_place;
} saltus_locus_point;

void saltus_locus_point_clear(saltus_locus_point *point);
/* The orbit at point->at, surveyed. Errors: SALTUS_NO_MEMORY, those of the equations. */
saltus_status saltus_locus_see_orbit(saltus_extended *extended, saltus_locus_point *point,
                                     saltus_message *message);
/* The same at a point that Newton's method has just found, and the functions whose zeros are corners. */
saltus_status saltus_locus_see(saltus_extended *extended, saltus_locus_point *point, saltus_message *message);
/* `here` becomes the point with these unknowns of the sequence that the shooting has, `extra` the one beside
 * the orbit's, before it is known to lie on the locus. Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE, the
 * flow's. */
saltus_status saltus_locus_take_up(saltus_extended *extended, saltus_locus_point *here, const double *u,
                                   double extra, saltus_message *message);
/* Onto the locus at the value of unknown k as it is; the tangent of either sign goes to `here`. */
saltus_status saltus_locus_find_first(saltus_extended *extended, saltus_locus_point *here, int k,
                                      saltus_message *message);
/* `here` becomes its orbit, or one on the locus near it. Two points of a Neimark-Sacker curve have its angle
 * 0 or pi, where the equations are singular: then the first point is a little away from there. */
saltus_status saltus_locus_find_near(saltus_extended *extended, saltus_locus_point *here, double theta,
                                     saltus_message *message);
/* At `here`, an orbit of half the period, or its own mirror image, two curves of grazing cross: that of such
 * orbits and that of those which branch off. The tangent becomes the latter's, from the null plane. */
saltus_status saltus_locus_find_leaving(saltus_extended *extended, saltus_locus_point *here,
                                        saltus_message *message);
/* `here` becomes a point of the same curve with the sequence that its orbit has now and that was made from
 * `old`, at which the tangent was `tangent` and the unknown beside the orbit's `more`; order: where the marks
 * stood. Errors: SALTUS_NO_MEMORY, those of the equations. */
saltus_status saltus_locus_install(saltus_extended *extended, saltus_locus_point *here,
                                   const saltus_sequence *old, const double *tangent, double more,
                                   const int *order, saltus_message *message);
/* The orbit at `here` is cut better, where an event has come near its base or a cut; `scratch` is
 * overwritten. Errors: as above; there is no such point then. */
saltus_status saltus_locus_reframe(saltus_extended *extended, saltus_locus_point *here,
                                   saltus_locus_point *scratch, saltus_message *message);
/* The point at arclength `ahead` from another, seen; false where it cannot be had. */
bool saltus_locus_visit(saltus_extended *extended, const saltus_locus_point *here, double ahead,
                        saltus_locus_point *out);
/* How far an orbit is from one that closes after one of so many equal parts of the period, scaled; INFINITY
 * where that are no whole periods. 1: from being its own mirror image. */
double saltus_locus_distance(saltus_extended *extended, const saltus_solution *orbit, int parts);
/* The least of those distances: from orbits of half the period, from its own mirror image, where the curve's
 * are not, and on curves of grazing from orbits of other parts of the period; `parts` (may be NULL): which.
 */
double saltus_locus_apart(saltus_extended *extended, const saltus_solution *orbit, int *parts);
/* Whether an orbit on a curve of grazing is all but such a one, which the curve's are not: another such curve
 * crosses there. A `breach` is nothing there if it falls with that distance from `here` on; otherwise another
 * impact grazes. */
bool saltus_locus_joins_at(saltus_extended *extended, const saltus_locus_point *here,
                           const saltus_solution *orbit, bool breach);
/* Whether the orbit is one, and the special one that is followed. Beyond another impact's birth or death it
 * is none, but the curve goes on to there. */
bool saltus_locus_is_sound(saltus_extended *extended, const saltus_locus_point *point);

/* Where the pair of multipliers meets, at theta = 0 or pi, the equations are singular; but the curve is even
 * in theta there, so `at` is interpolated in its square from regular points on the way. Where these cannot be
 * had it stays as it was located. */
void saltus_locus_sharpen(saltus_extended *extended, const saltus_locus_point *here, double theta,
                          saltus_locus_point *at, saltus_locus_point *scratch);
/* Where a contact that chatter leads to shrinks to nothing the equations end, and with them the curve, and
 * what is left of the contact falls like a power of the arclength: the place is bracketed. `at` becomes the
 * last orbit at which chatter completes. *found: whether the curve ends so just ahead of `here`. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status saltus_locus_end_contact(saltus_extended *extended, const saltus_locus_point *here,
                                       saltus_locus_point *at, bool *found, saltus_message *message);
/* Whether a contact after complete chatter has all but shrunk to nothing. */
bool saltus_locus_ceases_to_complete(const saltus_solution *orbit);

#endif
