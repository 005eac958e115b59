/* Private: curves of solutions of n equations in n + 1 unknowns, followed by pseudo-arclength (Keller, 1977).
 *
 * A point ahead is predicted along the tangent and corrected in the hyperplane normal to it. This code does
 * not know what the equations mean: it follows orbits, equilibria and loci alike.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_CURVE_H
#define SALTUS_BRANCH_CURVE_H

#include "orbit/newton.h"

#include <gsl/gsl_roots.h>

/* A number as mantissa x e^exponent, so that a determinant neither overflows nor loses its sign. */
typedef struct saltus_scaled {
    double mantissa, exponent;
} saltus_scaled;

/* The number in units of e^exponent, bounded where that would overflow. */
double saltus_scaled_in(saltus_scaled number, double exponent);

/* Set the message for SALTUS_NO_MEMORY and return that. */
saltus_status saltus_branch_no_memory(saltus_message *message);

typedef struct saltus_curve_point {
    int unknowns, room;
    double *u;
    double *tangent; /* of unit length */
    double
        *bend; /* coefficients of the arclength's square and cube from here on, where `bent`; 2 x unknowns */
    bool bent;
    double ahead;   /* arclength from the previous point, along its tangent */
    int iterations; /* Newton steps */
    double residual;
    saltus_scaled crossing; /* determinant of the Jacobian bordered by the tangent of the previous point:
                               changes sign where two curves cross */
} saltus_curve_point;

/* False without memory. */
bool saltus_curve_reserve(saltus_curve_point *point, int unknowns);
void saltus_curve_clear(saltus_curve_point *point);
/* Place and tangent of a point. False without memory. */
bool saltus_curve_copy(const saltus_curve_point *point, saltus_curve_point *copy);
/* The bend at a point, for predictions ahead: the cubic through it and a point before it on the same curve,
 * with both tangents. */
void saltus_curve_bend(const saltus_curve_point *before, saltus_curve_point *point);
/* Reverse the tangent. */
void saltus_curve_turn(saltus_curve_point *point);
/* Reverse it if it leads against `guide`. */
void saltus_curve_align(saltus_curve_point *point, const double *guide);
/* Tangent, residual and crossing of a point at which the equations were just evaluated. `guide`: a direction
 * with which the tangent shall form an acute angle; NULL: either sign will do. Errors: SALTUS_SINGULAR,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_curve_orient(saltus_equations *equations, const double *guide, saltus_curve_point *point,
                                  saltus_message *message);
/* The point at arclength `ahead` from another. Errors: no such point near, SALTUS_NO_MEMORY. */
saltus_status saltus_curve_visit(saltus_equations *equations, const saltus_curve_point *from, double ahead,
                                 saltus_curve_point *to, saltus_message *message);
/* The same if `point` is a point of the curve that was visited from there, for points near that one: the
 * prediction is the cubic through both. */
saltus_status saltus_curve_revisit(saltus_equations *equations, const saltus_curve_point *from, double ahead,
                                   saltus_curve_point *point);
/* Whether a point that was sought some way ahead of another is far aside of the tangent there: on another
 * piece of the curve, or on another curve. */
bool saltus_curve_strays(const saltus_curve_point *from, const saltus_curve_point *to);
/* The point at which unknown k, whose border is near, equals `value`. Errors: as above. */
saltus_status saltus_curve_meet(saltus_equations *equations, const saltus_curve_point *from, int k,
                                double value, saltus_curve_point *to, saltus_message *message);

/* An unknown that must not leave an interval. */
typedef struct saltus_curve_bound {
    int unknown;
    double low, high;
} saltus_curve_bound;

/* The point a step ahead; *step is halved until the curve turns little. If the step crosses a border of a
 * bound it ends exactly there, even if the equations are singular at the border, and *reached is the index of
 * that bound; otherwise -1. Errors: SALTUS_NO_CONVERGENCE at a corner of the curve; those of the evaluation
 * if no step is short enough; SALTUS_NO_MEMORY and SALTUS_INTERRUPTED at once, without shorter steps. */
saltus_status saltus_curve_step(saltus_equations *equations, const saltus_curve_point *from, double *step,
                                const saltus_curve_bound *bounds, int bound_count, saltus_curve_point *to,
                                int *reached, saltus_message *message);
/* The next step's length, from the iterations that Newton's method needed in the last one. */
double saltus_curve_next_step(double step, int iterations, double largest);

/* The value at x = 0 of the polynomial through (x_k, y_k), count <= 8 (Neville). */
double saltus_curve_interpolate(const double *x, const double *y, int count);

/* Whether a function may cross zero between the last two of three places and come back: the parabola through
 * the three values has its minimum (for positive values) there, below a fraction `deep` of the values;
 * *lowest is its place. */
bool saltus_curve_dips(const double place[3], const double value[3], double deep, double *lowest);

/* The unit tangent `leaving` of the other of two curves that cross at u, where the second-order terms of the
 * equations, projected on their left null vector, vanish along two directions in the null plane (Keller,
 * 1977): `along`, the first one's tangent, and that. *singular (may be NULL): the singular value that is zero
 * at a crossing. Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE, those of the evaluation. */
saltus_status saltus_curve_leaving(saltus_equations *equations, const double *u, const double *along,
                                   double *leaving, double *singular, saltus_message *message);

/* Newton's method from a point near one at which two curves cross; afterwards the equations are evaluated
 * there. The crossing is a regular solution of F(u) + s b = 0 and g_1 = g_2 = 0: b is near the left null
 * vector of the Jacobian J, whose null plane has the rows C, and J v + g_k b = 0, C v = e_k define two
 * numbers that are zero exactly where J is singular (Govaerts, Numerical methods for bifurcations of
 * dynamical equilibria, SIAM 2000). *error: the last change of the last unknown, the parameter. Errors:
 * SALTUS_NO_CONVERGENCE, SALTUS_SINGULAR, SALTUS_NO_MEMORY, those of the evaluation. */
saltus_status saltus_curve_settle(saltus_equations *equations, double *u, double *error);

/* A function along a curve whose zero is sought; false where it cannot be computed. */
typedef bool saltus_curve_function(void *context, double ahead, double *value);

/* The zero of a function between two places, given the values there, of different signs; *width: of the last
 * bracket, 0 where the function is exactly zero. `solver`: GSL's Brent method. False if it fails. */
bool saltus_curve_zero(gsl_root_fsolver *solver, saltus_curve_function *function, void *context,
                       const double ends[2], const double values[2], double *place, double *width);
/* The unknowns, to `work` (7 x unknowns), at a zero where the equations themselves are singular, interpolated
 * from points at up to three times `apart` on both sides of `middle`, which the function leaves in `at`.
 * *ahead: distance from `from`; *spread: possible error of the parameter. False if a point cannot be found,
 * or if the signs on both sides are equal. */
bool saltus_curve_cross(saltus_curve_function *function, void *context, const saltus_curve_point *from,
                        const saltus_curve_point *at, double middle, double apart, double *work,
                        double *ahead, double *spread);
/* `at` becomes the point near `ahead` of `from` where curves cross, a zero of the function, and the equations
 * are evaluated there. They are singular, so it is interpolated from points around it, at first a tenth of
 * `reach` apart, and, if `settles`, found by saltus_curve_settle from there. *accuracy: of the parameter.
 * Errors: SALTUS_NO_CONVERGENCE, SALTUS_NO_MEMORY, those of the evaluation. */
saltus_status saltus_curve_crossing(saltus_equations *equations, saltus_curve_function *function,
                                    void *context, const saltus_curve_point *from, double ahead, double reach,
                                    bool settles, saltus_curve_point *at, double *accuracy);

#endif
