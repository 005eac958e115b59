/* Private: n equations in n + 1 unknowns, whose solutions form curves: Newton's method, tangents, null
 * vectors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_NEWTON_H
#define SALTUS_ORBIT_NEWTON_H

#include "base/dense.h"
#include "saltus/status.h"

typedef struct saltus_equations {
    void *self; /* first argument of `evaluate` and `measure` */
    /* Compute residuals and Jacobian at u, into the members below. */
    saltus_status (*evaluate)(void *self, const double *u, saltus_message *message);
    /* Compute only the residuals; NULL unless that is far cheaper. */
    saltus_status (*measure)(void *self, const double *u, saltus_message *message);
    int count, unknowns; /* unknowns = count + 1 */
    double *residual;    /* [count], of the last evaluation */
    double *jacobian;    /* [count][unknowns], at `place` if `known` */
    double *place;
    bool known;
    bool begun; /* the next iteration starts from the point last evaluated: it need not be again */
    /* Iterate with `measure` and the known Jacobian as long as that converges; without a normal only where a
     * step hardly moves the point. */
    bool hasty;
    bool bold;        /* where no damped step lowers the residual, take a full one that halves the distance */
    double size;      /* largest residual; INFINITY after a failed evaluation */
    double tolerance; /* for the residual */
    int iterations;   /* limit */
    void (*history)(void *context, int iteration, double residual, const char *unknowns); /* may be NULL */
    void *context;
    const char *kind; /* for `history`: the formulation */
    /* Workspace. */
    saltus_dense_lu lu;
    double *matrix, *step, *trial, *kept;
} saltus_equations;

/* Take the vectors of `unknowns` unknowns from an arena, in both of its passes. */
void saltus_equations_reserve(saltus_equations *equations, int unknowns, saltus_arena *arena);
saltus_status saltus_equations_evaluate(saltus_equations *equations, const double *u,
                                        saltus_message *message);
/* Newton's iteration from u: on the hyperplane normal . (u - anchor) = 0 or, if `normal` is NULL, with the
 * last unknown, the parameter, fixed. Afterwards the equations are evaluated at u or, on a hyperplane, as
 * close to it as the tolerance. Errors: SALTUS_NO_CONVERGENCE, SALTUS_SINGULAR, those of the evaluation. */
saltus_status saltus_newton(saltus_equations *equations, double *u, const double *normal,
                            const double *anchor, bool damped, int *iterations, saltus_message *message);
/* Newton's step, to e->step, from the point last evaluated, with one more equation of this value and
 * gradient. Errors: SALTUS_SINGULAR. */
saltus_status saltus_equations_step(saltus_equations *equations, const double *gradient, double value);
/* Unit tangent of the curve at the point last evaluated, with tangent . guide > 0, and sign and log modulus
 * of the determinant of the Jacobian bordered by `guide`. Errors: SALTUS_SINGULAR. */
saltus_status saltus_curve_tangent(saltus_equations *equations, const double *guide, double *tangent,
                                   int *sign, double *log_determinant, saltus_message *message);
/* Two orthonormal null vectors (2 x unknowns) and their singular values, the smallest of the Jacobian at the
 * point last evaluated. Both values are zero at a branch point. */
saltus_status saltus_null_plane(saltus_equations *equations, double *vectors, double values[2],
                                saltus_message *message);

#endif
