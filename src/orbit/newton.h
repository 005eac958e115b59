/* Private: n equations in n + 1 unknowns, whose solutions form curves: Newton's method, tangents, null
 * vectors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_NEWTON_H
#define SALTUS_ORBIT_NEWTON_H

#include "base/dense.h"
#include "saltus/status.h"

typedef struct saltus_equations {
    void *self; /* what `evaluate` is given */
    /* Residuals and Jacobian at u go to the members below. */
    saltus_status (*evaluate)(void *self, const double *u, saltus_message *message);
    /* Residuals alone, where they are far cheaper than with the Jacobian, otherwise NULL. */
    saltus_status (*measure)(void *self, const double *u, saltus_message *message);
    int count, unknowns; /* unknowns = count + 1 */
    double *residual;    /* count, of the last evaluation */
    double *jacobian;    /* count x unknowns, at `place` where it is known */
    double *place;
    bool known;
    bool hasty;       /* Newton's method goes by `measure` as far as that leads, from the Jacobian known */
    double size;      /* the largest residual; INFINITY after an evaluation that failed */
    double tolerance; /* of the residual */
    int iterations;   /* at most */
    void (*history)(void *context, int iteration, double residual, const char *unknowns); /* may be NULL */
    void *context;
    const char *kind; /* for history: what is unknown */
    /* Workspace. */
    saltus_dense_lu lu;
    double *matrix, *step, *trial, *kept;
} saltus_equations;

/* Take the vectors of so many unknowns from an arena, in both of its passes. */
void saltus_equations_reserve(saltus_equations *equations, int unknowns, saltus_arena *arena);
saltus_status saltus_equations_evaluate(saltus_equations *equations, const double *u,
                                        saltus_message *message);
/* Newton's iteration from u. With `normal` (length unknowns): on the hyperplane normal . (u - anchor) = 0;
 * NULL: with the last unknown, the parameter, fixed. Damped if asked for. The equations end evaluated at u,
 * or on a hyperplane as near to it as the tolerance. Errors: SALTUS_NO_CONVERGENCE, SALTUS_SINGULAR, those of
 * the evaluation. */
saltus_status saltus_newton(saltus_equations *equations, double *u, const double *normal,
                            const double *anchor, bool damped, int *iterations, saltus_message *message);
/* Unit tangent of the curve at the point last evaluated, with tangent . guide > 0; the determinant of the
 * Jacobian bordered by `guide` as sign and log modulus. Errors: SALTUS_SINGULAR. */
saltus_status saltus_curve_tangent(saltus_equations *equations, const double *guide, double *tangent,
                                   int *sign, double *log_determinant, saltus_message *message);
/* Two orthonormal vectors (2 x unknowns) that belong to the smallest singular values of the Jacobian at the
 * point last evaluated, and these: at a branch point both are zero. */
saltus_status saltus_null_plane(saltus_equations *equations, double *vectors, double values[2],
                                saltus_message *message);

#endif
