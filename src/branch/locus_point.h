/* Private: points of a locus, the corners between two of them, and the ends of its curves. Lack of memory is
 * noted in the orbits, whatever else a function says of it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_LOCUS_POINT_H
#define SALTUS_BRANCH_LOCUS_POINT_H

#include "branch/corner.h"

typedef struct saltus_locus_point {
    saltus_curve_point at;
    saltus_solution orbit;
    saltus_locus_test corners[SALTUS_CORNERS_MAX];
    int corner_count;
    double doubt; /* possible error of a located place in the plane, in units of the ranges; NAN: not known */
    /* The functions at the previous point of the curve, and its place relative to this one; 0: none. */
    saltus_scaled before[SALTUS_CORNERS_MAX];
    double before_place;
} saltus_locus_point;

/* Free the arrays. A zeroed one is accepted. */
void saltus_locus_point_clear(saltus_locus_point *point);
/* Evaluate the orbit at point->at. False if the equations fail. */
bool saltus_locus_see_orbit(saltus_extended *extended, saltus_locus_point *point);
/* The same and, for a point that may be given out, go around the orbit with the flow's own events. */
bool saltus_locus_survey_orbit(saltus_extended *extended, saltus_locus_point *point);
/* Both at a point just found by Newton's method, with the functions whose zeros are corners. */
bool saltus_locus_see(saltus_extended *extended, saltus_locus_point *point);
bool saltus_locus_survey(saltus_extended *extended, saltus_locus_point *point);
/* `here` becomes the point with these unknowns of the shooting's sequence, and `extra` as the unknown besides
 * them, before it is known to lie on the locus. Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE, those of the
 * flow. */
saltus_status saltus_locus_take_up(saltus_extended *extended, saltus_locus_point *here, const double *u,
                                   double extra, saltus_message *message);
/* Move `here` onto the locus with unknown k fixed; its tangent has either sign. */
saltus_status saltus_locus_find_first(saltus_extended *extended, saltus_locus_point *here, int k,
                                      saltus_message *message);
/* The same onto a point of the locus with these unknowns, `extra` the one beside the orbit's, and whichever
 * parameter as it is that does not stay so along the curve. */
saltus_status saltus_locus_find_again(saltus_extended *extended, saltus_locus_point *here, const double *u,
                                      double extra, saltus_message *message);
/* `here` becomes its orbit, or one on the locus near it. Two points of a Neimark-Sacker curve have its angle
 * 0 or pi, where the equations are singular: then the first point is a little away from there. */
saltus_status saltus_locus_find_near(saltus_extended *extended, saltus_locus_point *here, double theta,
                                     saltus_message *message);
/* At `here`, an orbit of half the period, or its own mirror image, which is cut after half of it, two curves
 * of grazing cross: that of such orbits and that of those which branch off. The tangent becomes the latter's
 * if it `leaves`, otherwise the former's, from the null plane; where none cross after all, its own. */
saltus_status saltus_locus_find_crossing(saltus_extended *extended, saltus_locus_point *here, bool leaves,
                                         saltus_message *message);
/* Take out of the tangent at `here`, an orbit that is its own mirror image and may be cut halfway, what leads
 * to others: where these branch off at the very same place, the equations determine it only but for that. */
void saltus_locus_keep_mirrored(const saltus_extended *extended, saltus_locus_point *here);
/* How fast, along the tangent at such an orbit, the halves, or the mirror images, become unlike; it may be
 * slow where perturbations grow along the orbit. */
double saltus_locus_leaving(const saltus_extended *extended, const saltus_locus_point *here);
/* `here` becomes a point of the same curve with the sequence that its orbit has now and that was made from
 * `old`, at which the tangent was `tangent` and the unknown beside the orbit's `more`; order: where the marks
 * stood. False if the equations fail. */
bool saltus_locus_install(saltus_extended *extended, saltus_locus_point *here, const saltus_sequence *old,
                          const double *tangent, double more, const int *order);
/* Whether an orbit should be cut into more segments, as perturbations grow too much for Newton's method or,
 * except at grazing, for the differences that are the second derivatives. */
bool saltus_locus_grows(const saltus_extended *extended, const saltus_solution *orbit);
/* Cut the orbit at `here` better if that is so, or an event has come near its base or a cut; `scratch` is
 * overwritten. False: there is no such point. */
bool saltus_locus_reframe(saltus_extended *extended, saltus_locus_point *here, saltus_locus_point *scratch);
/* The point at arclength `ahead` from another on the curve, by the sharpest tolerance of the equations that
 * rounding allows, which is sought from *tolerance to `loosest`; *tolerance becomes that. */
bool saltus_locus_reach(saltus_extended *extended, const saltus_curve_point *from, double ahead,
                        double *tolerance, double loosest, saltus_curve_point *to);
/* The point at arclength `ahead` from another, evaluated; false if it cannot be found. */
bool saltus_locus_visit(saltus_extended *extended, const saltus_locus_point *here, double ahead,
                        saltus_locus_point *out);
/* The possible error, in the plane, of a zero of a function along a curve: as far beside it as values must be
 * taken to show the slope there, plus the scatter of the points, which the function leaves in `at`, c
 * unknowns before the parameters, plus what another flow moves the zero by: the function with the context
 * `other` (NULL: there is none) leaves its points in `there`. NAN where the slope shows only far off,
 * INFINITY where the other flow shows none. */
double saltus_locus_doubt(saltus_curve_function *function, void *context, void *other, double place,
                          const saltus_curve_point *at, const saltus_curve_point *there, int c);
/* The least distance of an orbit from shorter ones (solution.h): for half the period; for the mirror image,
 * unless all orbits of the curve are symmetric; on curves of grazing also for other parts. `parts` (may be
 * NULL): for which. */
double saltus_locus_apart(saltus_extended *extended, const saltus_solution *orbit, int *parts);
/* Whether an orbit ahead of `here` on a curve of grazing is such an orbit, unlike those of the curve: another
 * curve of grazing crosses there. */
bool saltus_locus_joins_at(saltus_extended *extended, const saltus_locus_point *here,
                           const saltus_locus_point *at);
/* Whether the orbit `at` lies in the plane just ahead of `here`, no farther than `near`, which at->at.ahead
 * becomes. */
bool saltus_locus_leads(const saltus_extended *extended, const saltus_locus_point *here, double near,
                        saltus_locus_point *at);
/* Whether the point to which a step from `here` has led is on the same piece of the curve, and a valid orbit,
 * special in the way that is followed. Beyond another impact's birth or death it is not valid, but accepted,
 * since the curve leads to that place. */
bool saltus_locus_is_sound(saltus_extended *extended, const saltus_locus_point *here,
                           const saltus_locus_point *point);
/* Whether two multipliers of the orbit last evaluated are e^{i theta} and its conjugate: at folds the
 * equations of tori hold with theta = 0 and a single multiplier 1. They are those of the prescribed events:
 * the flow may miss an impact that is too slow for it. */
bool saltus_locus_has_pair(saltus_extended *extended, double theta);

/* Where the pair of multipliers meets, at theta = 0 or pi, the equations are singular, but the curve is even
 * in theta. So `at` is interpolated in theta squared from regular points of the curve; if these cannot be
 * found it stays as it was. */
void saltus_locus_sharpen(saltus_extended *extended, const saltus_locus_point *here, double theta,
                          saltus_locus_point *at, saltus_locus_point *scratch);
/* Where a contact that completes chatter shrinks to nothing, the equations and the curve end. Its length goes
 * as a power of the arclength, so the place is approached. `at` becomes the last orbit with complete chatter.
 * False if the curve does not end in this way just ahead of `here`. */
bool saltus_locus_end_contact(saltus_extended *extended, const saltus_locus_point *here,
                              saltus_locus_point *at);
/* Whether a contact after complete chatter has almost shrunk to nothing. */
bool saltus_locus_ceases_to_complete(const saltus_solution *orbit);

/* In locus_corners.c. */
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
