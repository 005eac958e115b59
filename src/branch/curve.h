/* Private: curves of solutions of n equations in n + 1 unknowns, followed by pseudo-arclength (Keller, 1977).
 *
 * A point ahead is predicted along the tangent and corrected on the hyperplane across it. Nothing here knows
 * what the equations mean: orbits and loci of special orbits are followed alike.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_CURVE_H
#define SALTUS_BRANCH_CURVE_H

#include "orbit/newton.h"

#include <gsl/gsl_roots.h>

/* A number as mantissa x e^exponent, so that a determinant neither overflows nor loses its sign. */
typedef struct saltus_scaled {
    double mantissa, exponent;
} saltus_scaled;

/* In units of e^exponent, cut where that would overflow. */
double saltus_scaled_in(saltus_scaled number, double exponent);

/* SALTUS_NO_MEMORY, and its sentence. */
saltus_status saltus_branch_no_memory(saltus_message *message);

typedef struct saltus_curve_point {
    int unknowns, room;
    double *u;
    double *tangent; /* of unit length */
    double
        *bend; /* coefficients of the arclength's square and cube from here on, where `bent`; 2 x unknowns */
    bool bent;
    double ahead;   /* arclength, along the tangent of the point it was reached from */
    int iterations; /* Newton steps */
    double residual;
    saltus_scaled crossing; /* the Jacobian's determinant, bordered by the tangent of the point it was
                               reached from: changes its sign where two curves cross */
} saltus_curve_point;

/* False without memory. */
bool saltus_curve_reserve(saltus_curve_point *point, int unknowns);
void saltus_curve_clear(saltus_curve_point *point);
/* The curve's bend at a point, from one before it on the same curve, for predictions ahead: the cubic through
 * both, with their tangents. */
void saltus_curve_bend(const saltus_curve_point *before, saltus_curve_point *point);
/* Turn the tangent round. */
void saltus_curve_turn(saltus_curve_point *point);
/* The same if it leads against a direction. */
void saltus_curve_align(saltus_curve_point *point, const double *guide);
/* Tangent, residual and crossing of a point that the equations have just been evaluated at. `guide`: a
 * direction that the tangent shall have in common with; NULL: its own, of either sign. Errors:
 * SALTUS_SINGULAR, SALTUS_NO_MEMORY. */
saltus_status saltus_curve_orient(saltus_equations *equations, const double *guide, saltus_curve_point *point,
                                  saltus_message *message);
/* The point at arclength `ahead` from another. Errors: no such point near, SALTUS_NO_MEMORY. */
saltus_status saltus_curve_visit(saltus_equations *equations, const saltus_curve_point *from, double ahead,
                                 saltus_curve_point *to, saltus_message *message);
/* The point at which unknown k, whose border is near, has a value. Errors: as above. */
saltus_status saltus_curve_meet(saltus_equations *equations, const saltus_curve_point *from, int k,
                                double value, saltus_curve_point *to, saltus_message *message);

/* An unknown that must not leave an interval. */
typedef struct saltus_curve_bound {
    int unknown;
    double low, high;
} saltus_curve_bound;

/* The point a step ahead, which is halved until the curve turns little on the way; over a border of one of
 * the bounds it ends on the border, be the equations singular there, and *reached is the number of that
 * bound, otherwise -1. Errors:
 * SALTUS_NO_CONVERGENCE where the curve has a corner, those of the evaluation where no step is short enough;
 * SALTUS_NO_MEMORY and SALTUS_INTERRUPTED at once, without shorter steps. */
saltus_status saltus_curve_step(saltus_equations *equations, const saltus_curve_point *from, double *step,
                                const saltus_curve_bound *bounds, int bound_count, saltus_curve_point *to,
                                int *reached, saltus_message *message);
/* The next step's length, by Newton's effort in the last. */
double saltus_curve_next_step(double step, int iterations, double largest);

/* The value at x = 0 of the polynomial through (x_k, y_k), count <= 8 (Neville). */
double saltus_curve_interpolate(const double *x, const double *y, int count);

/* A function along a curve whose zero is sought; false where it cannot be computed. */
typedef bool saltus_curve_function(void *context, double ahead, double *value);

/* The zero of a function between 0, where it is `near`, and `end`, where it is `far` and has the other sign;
 * *width: of the last bracket, 0 where the function is zero to the last bit. `solver` is GSL's Brent method.
 * False if the zero cannot be had. */
bool saltus_curve_zero(gsl_root_fsolver *solver, saltus_curve_function *function, void *context, double near,
                       double end, double far, double *place, double *width);
/* The same between any two places, with the values there. */
bool saltus_curve_zero_between(gsl_root_fsolver *solver, saltus_curve_function *function, void *context,
                               const double ends[2], const double values[2], double *place, double *width);
/* The unknowns, to `work` (7 x unknowns), at a zero in whose very place the equations are singular: from
 * points at up to three times `apart` on both sides of `middle`, which the function leaves in `at`; how far
 * *ahead of `from` it is, and what the parameter may be off by. False where a point cannot be had, or the
 * signs on both sides are not different though it `straddles` the zero. */
bool saltus_curve_cross(saltus_curve_function *function, void *context, const saltus_curve_point *from,
                        const saltus_curve_point *at, double middle, double apart, bool straddles,
                        double *work, double *ahead, double *spread);

#endif
