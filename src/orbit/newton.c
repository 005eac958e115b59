/* Newton's method, tangents and null vectors of n equations in n + 1 unknowns.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/newton.h"

#include <math.h>
#include <string.h>

enum { halvings_max = 8 };

/* A residual far below that of any orbit. */
static const double rounding = 1e-18;

void saltus_equations_reserve(saltus_equations *e, int unknowns, saltus_arena *arena) {
    size_t m = (size_t)unknowns;
    e->unknowns = unknowns;
    e->count = unknowns - 1;
    e->residual = saltus_arena_doubles(arena, m - 1);
    e->jacobian = saltus_arena_doubles(arena, (m - 1) * m);
    e->matrix = saltus_arena_doubles(arena, m * m);
    e->step = saltus_arena_doubles(arena, m);
    e->trial = saltus_arena_doubles(arena, m);
    e->kept = saltus_arena_doubles(arena, m);
}

saltus_status saltus_equations_evaluate(saltus_equations *e, const double *u, saltus_message *message) {
    e->size = INFINITY;
    saltus_status status = e->evaluate(e->self, u, message);
    if (status != SALTUS_OK)
        return status;
    e->size = 0;
    for (int i = 0; i < e->count; i++)
        e->size = fmax(e->size, fabs(e->residual[i]));
    return status;
}

/* The Jacobian with one row more: a normal, or the parameter held fixed. */
static bool factor_bordered(saltus_equations *e, const double *normal) {
    int m = e->unknowns;
    memcpy(e->matrix, e->jacobian, (size_t)(e->count * m) * sizeof(double));
    double *last = e->matrix + (size_t)e->count * (size_t)m;
    for (int j = 0; j < m; j++)
        last[j] = normal ? normal[j] : j == e->count;
    return saltus_dense_factor(&e->lu, e->matrix);
}

static void report(const saltus_equations *e, int iteration) {
    if (e->history)
        e->history(e->context, iteration, e->size, e->kind);
}

/* Halve the step until the residual falls; undamped, the first trial stands if it can be evaluated at all.
 * Where none is taken u stays. Errors: those that no shorter step could mend. */
static saltus_status take_step(saltus_equations *e, double *u, bool damped, double before, bool *taken,
                               saltus_message *message) {
    double factor = 1;
    *taken = false;
    for (int h = 0; h < (damped ? halvings_max : 1) && !*taken; h++, factor /= 2) {
        for (int j = 0; j < e->unknowns; j++)
            e->trial[j] = fma(factor, e->step[j], u[j]);
        saltus_status tried = saltus_equations_evaluate(e, e->trial, message);
        if (tried == SALTUS_NO_MEMORY || tried == SALTUS_INTERRUPTED)
            return tried;
        *taken = tried == SALTUS_OK && (!damped || e->size < before || before <= e->tolerance);
    }
    memcpy(e->kept, u, (size_t)e->unknowns * sizeof *u);
    if (*taken)
        memcpy(u, e->trial, (size_t)e->unknowns * sizeof *u);
    return SALTUS_OK;
}

/* The point before the last step stands. */
static saltus_status step_back(saltus_equations *e, double *u, saltus_message *message) {
    memcpy(u, e->kept, (size_t)e->unknowns * sizeof *u);
    return saltus_equations_evaluate(e, u, message);
}

static saltus_status judge(const saltus_equations *e, saltus_status status, saltus_message *message) {
    if (status == SALTUS_OK && !(e->size <= e->tolerance))
        return saltus_fail(message, SALTUS_NO_CONVERGENCE, "Newton's iteration stops at a residual of %.3g",
                           e->size);
    return status;
}

/* Newton's step from the point last evaluated. */
static bool find_step(saltus_equations *e, const double *u, const double *normal, const double *anchor) {
    double aside = 0;
    if (!factor_bordered(e, normal))
        return false;
    for (int i = 0; i < e->count; i++)
        e->step[i] = -e->residual[i];
    for (int j = 0; j < e->unknowns && normal; j++)
        aside = fma(normal[j], u[j] - anchor[j], aside);
    e->step[e->count] = -aside;
    saltus_dense_resolve(&e->lu, false, 1, e->step);
    if (!normal) /* solving leaves a rounding, and a parameter of 0 shows it */
        e->step[e->count] = 0;
    return true;
}

/* Quadratic convergence costs one step more and gives all the digits there are: the iteration ends when the
 * residual no longer falls. On a hyperplane, where each evaluation counts, the step that can be trusted to
 * end in rounding is the last, and its end is not evaluated. */
saltus_status saltus_newton(saltus_equations *e, double *u, const double *normal, const double *anchor,
                            bool damped, int *iterations, saltus_message *message) {
    saltus_status status = saltus_equations_evaluate(e, u, message);
    double best = e->size;
    *iterations = 0;
    report(e, 0);
    while (status == SALTUS_OK && *iterations < e->iterations) {
        bool taken;
        if (!find_step(e, u, normal, anchor))
            return saltus_fail(message, SALTUS_SINGULAR,
                               "Newton's matrix is singular: the orbit is not isolated");
        status = take_step(e, u, damped, best, &taken, message);
        if (status != SALTUS_OK)
            return status;
        ++*iterations;
        report(e, *iterations);
        if (!taken || (best <= e->tolerance && e->size >= best)) {
            status = step_back(e, u, message);
            break;
        }
        if (!damped && e->size > 1e3 * fmax(best, e->tolerance))
            break;
        double fall = e->size / best;
        best = e->size;
        if (normal && best <= e->tolerance && best * fall * fall < rounding &&
            find_step(e, u, normal, anchor)) {
            for (int j = 0; j < e->unknowns; j++)
                u[j] += e->step[j];
            break;
        }
        if (best <= 1e-3 * e->tolerance || (best <= e->tolerance && fall > 0.1))
            break;
    }
    return judge(e, status, message);
}

saltus_status saltus_curve_tangent(saltus_equations *e, const double *guide, double *tangent, int *sign,
                                   double *log_determinant, saltus_message *message) {
    double size = 0;
    if (!factor_bordered(e, guide))
        return saltus_fail(message, SALTUS_SINGULAR, "the branch has no tangent here");
    *sign = e->lu.sign;
    *log_determinant = e->lu.log_modulus;
    memset(tangent, 0, (size_t)e->unknowns * sizeof *tangent);
    tangent[e->count] = 1;
    saltus_dense_resolve(&e->lu, false, 1, tangent);
    for (int j = 0; j < e->unknowns; j++)
        size = hypot(size, tangent[j]);
    for (int j = 0; j < e->unknowns; j++)
        tangent[j] /= size;
    return SALTUS_OK;
}

saltus_status saltus_null_plane(saltus_equations *e, double *vectors, double values[2],
                                saltus_message *message) {
    memcpy(e->matrix, e->jacobian, (size_t)(e->count * e->unknowns) * sizeof(double));
    saltus_status status = saltus_dense_null_vectors(e->matrix, e->count, e->unknowns, 2, vectors, values);
    return status == SALTUS_OK
               ? status
               : saltus_fail(message, status, "%s",
                             status == SALTUS_NO_MEMORY ? "no memory for shooting"
                                                        : "no singular values at a branch point");
}
