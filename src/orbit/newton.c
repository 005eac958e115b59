/* Newton's method, tangents and null vectors of n equations in n + 1 unknowns.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/newton.h"

#include <math.h>
#include <string.h>

enum { halvings_max = 8 };

/* A residual far below that of any computed orbit. */
static const double rounding = 1e-18;
/* How fast residuals fall per distance to where the Jacobian is known, where nothing tells it: more steeply
 * than on any curve of orbits. */
static const double steepest = 1e4;

void saltus_equations_reserve(saltus_equations *e, int unknowns, saltus_arena *arena) {
    size_t m = (size_t)unknowns;
    e->unknowns = unknowns;
    e->count = unknowns - 1;
    e->residual = saltus_arena_doubles(arena, m - 1);
    e->jacobian = saltus_arena_doubles(arena, (m - 1) * m);
    e->place = saltus_arena_doubles(arena, m);
    e->known = e->begun = false;
    e->matrix = saltus_arena_doubles(arena, m * m);
    e->step = saltus_arena_doubles(arena, m);
    e->trial = saltus_arena_doubles(arena, m);
    e->kept = saltus_arena_doubles(arena, m);
}

/* Evaluate the residuals at u by one of the two functions, and their size. */
static saltus_status find_residual(saltus_equations *e,
                                   saltus_status (*function)(void *, const double *, saltus_message *),
                                   const double *u, saltus_message *message) {
    e->size = INFINITY;
    saltus_status status = function(e->self, u, message);
    if (status != SALTUS_OK)
        return status;
    e->size = 0;
    for (int i = 0; i < e->count; i++)
        e->size = fmax(e->size, fabs(e->residual[i]));
    return status;
}

saltus_status saltus_equations_evaluate(saltus_equations *e, const double *u, saltus_message *message) {
    saltus_status status = find_residual(e, e->evaluate, u, message);
    memcpy(e->place, u, (size_t)e->unknowns * sizeof *u);
    e->known = status == SALTUS_OK;
    return status;
}

/* Factor the Jacobian with one more row: a normal, or the parameter held fixed. */
static bool factor_bordered(saltus_equations *e, const double *normal) {
    int m = e->unknowns;
    memcpy(e->matrix, e->jacobian, (size_t)(e->count * m) * sizeof(double));
    double *last = e->matrix + (size_t)e->count * (size_t)m;
    for (int j = 0; j < m; j++)
        last[j] = normal ? normal[j] : j == e->count;
    return saltus_dense_factor(&e->lu, e->matrix);
}

/* Errors that other ways to the same point cannot avoid either. */
static bool is_final(saltus_status status) {
    return status == SALTUS_NO_MEMORY || status == SALTUS_INTERRUPTED;
}

static void report(const saltus_equations *e, int iteration) {
    if (e->history)
        e->history(e->context, iteration, e->size, e->kind);
}

/* Take a step, halved until the residual falls; undamped, a full step if it can be evaluated. If no step is
 * taken, u is unchanged. Errors: those that a shorter step cannot avoid. */
static saltus_status take_step(saltus_equations *e, double *u, bool damped, double before, bool *taken,
                               saltus_message *message) {
    double factor = 1;
    *taken = false;
    for (int h = 0; h < (damped ? halvings_max : 1) && !*taken; h++, factor /= 2) {
        for (int j = 0; j < e->unknowns; j++)
            e->trial[j] = fma(factor, e->step[j], u[j]);
        saltus_status tried = saltus_equations_evaluate(e, e->trial, message);
        if (is_final(tried))
            return tried;
        *taken = tried == SALTUS_OK && (!damped || e->size < before || before <= e->tolerance);
    }
    for (int j = 0; j < e->unknowns && !*taken; j++)
        e->trial[j] = u[j] + e->step[j];
    if (!*taken && damped && e->bold) {
        saltus_status tried = saltus_equations_evaluate(e, e->trial, message);
        if (is_final(tried))
            return tried;
        /* The residual may have grown if the next step, by the Jacobian before this one, is much shorter (the
         * natural test of Deuflhard, Newton Methods for Nonlinear Problems, 2004). */
        const double much = 0.5;
        const double length = saltus_length(e->step, e->unknowns);
        for (int j = 0; j < e->unknowns && tried == SALTUS_OK; j++)
            e->step[j] = j < e->count ? -e->residual[j] : 0;
        if (tried == SALTUS_OK)
            saltus_dense_resolve(&e->lu, false, 1, e->step);
        *taken = tried == SALTUS_OK && saltus_length(e->step, e->unknowns) < much * length;
    }
    memcpy(e->kept, u, (size_t)e->unknowns * sizeof *u);
    if (*taken)
        memcpy(u, e->trial, (size_t)e->unknowns * sizeof *u);
    return SALTUS_OK;
}

/* Newton's step from the last residual with the last factorisation; `value`: of one more equation. */
static void resolve(saltus_equations *e, double value) {
    for (int i = 0; i < e->count; i++)
        e->step[i] = -e->residual[i];
    e->step[e->count] = -value;
    saltus_dense_resolve(&e->lu, false, 1, e->step);
}

saltus_status saltus_equations_step(saltus_equations *e, const double *gradient, double value) {
    if (!factor_bordered(e, gradient))
        return SALTUS_SINGULAR;
    resolve(e, value);
    return SALTUS_OK;
}

/* Newton's step from the residual at u with the last factorisation. */
static void solve_step(saltus_equations *e, const double *u, const double *normal, const double *anchor) {
    double aside = 0;
    for (int j = 0; j < e->unknowns && normal; j++)
        aside = fma(normal[j], u[j] - anchor[j], aside);
    resolve(e, aside);
    if (!normal) /* remove rounding, which a parameter of 0 would show */
        e->step[e->count] = 0;
}

/* Newton's step from the point last evaluated; false if the matrix is singular. */
static bool find_step(saltus_equations *e, const double *u, const double *normal, const double *anchor) {
    if (!factor_bordered(e, normal))
        return false;
    solve_step(e, u, normal, anchor);
    return true;
}

/* Whether one more step will end in rounding, so that its end need not be evaluated: with quadratic
 * convergence the ratio by which the residual falls is squared with each step. */
static bool last_ends_in_rounding(const saltus_equations *e, double size, double fall) {
    return size <= e->tolerance && size * fall * fall < rounding;
}

static bool is_small(const saltus_equations *e, double size, double fall) {
    return size <= 1e-3 * e->tolerance || (size <= e->tolerance && fall > 0.1);
}

static void take(const saltus_equations *e, double *u) {
    for (int j = 0; j < e->unknowns; j++)
        u[j] += e->step[j];
}

/* Number of steps of Newton's method from a residual that falls by `fall` in the first step. */
static int count_steps(const saltus_equations *e, double size, double fall) {
    int steps = 1;
    for (size *= fall; steps < e->iterations; steps++, size *= fall) {
        if (last_ends_in_rounding(e, size, fall) || is_small(e, size, fall))
            break;
        fall *= fall;
    }
    return steps;
}

/* Result of an approach by residuals alone. */
typedef struct approached {
    bool near;
    int iterations; /* estimated steps of Newton's method instead */
    double fall;    /* ratio of the last two residuals over the distance from where the Jacobian is known */
} approached;

/* Iterate from u with the Jacobian of the last point, which is nearby. If residuals fall too slowly, u is
 * unchanged. The last point is not measured once the ratio of residuals tells how near it is: the evaluation
 * that follows does that. Errors: those that other ways cannot avoid either. */
static saltus_status approach(saltus_equations *e, double *u, const double *normal, const double *anchor,
                              approached *found, saltus_message *message) {
    enum { evaluations_max = 8 };
    const double within = 0.1 * e->tolerance;
    double before = INFINITY, apart = 0, length = 0, ratio = 1;
    *found = (approached){.near = false};
    if (!(e->hasty && e->measure && e->known && normal) || !factor_bordered(e, normal))
        return SALTUS_OK;
    memcpy(e->trial, u, (size_t)e->unknowns * sizeof *u);
    for (int j = 0; j < e->unknowns; j++)
        apart = hypot(apart, u[j] - e->place[j]);
    for (int k = 0; k < evaluations_max && !found->near; k++) {
        const saltus_status tried = find_residual(e, e->measure, e->trial, message);
        if (is_final(tried))
            return tried;
        const double left = evaluations_max - 1 - k;
        ratio = k ? e->size / before : 1;
        found->near = tried == SALTUS_OK && (e->size <= within || (e->size <= e->tolerance && ratio > 0.1));
        if (k < 2)
            found->iterations = count_steps(e, k ? before : e->size, k ? ratio * fmin(1, length / apart) : 0);
        if (found->near || tried != SALTUS_OK || (k > 0 && !(e->size * pow(ratio, left) <= within)))
            break;
        before = e->size;
        solve_step(e, e->trial, normal, anchor);
        take(e, e->trial);
        found->near = k > 0 && before * ratio <= 0.5 * within;
        length = k == 0 ? saltus_length(e->step, e->unknowns) : length;
    }
    found->fall = ratio / apart;
    if (found->near)
        memcpy(u, e->trial, (size_t)e->unknowns * sizeof *u);
    return SALTUS_OK;
}

/* Iterate with the Jacobian just evaluated at u, by residuals alone, if the first step hardly moves u and
 * these fall fast: *iterations says after how many steps. 0: u, residuals and Jacobian are unchanged. Errors:
 * those that other ways cannot avoid either. */
static saltus_status polish(saltus_equations *e, double *u, int *iterations, saltus_message *message) {
    enum { steps_max = 3 };
    static const double close = 1e-6, fast = 0.1;
    const double start = e->size;
    double length = 0;
    *iterations = 0;
    if (!factor_bordered(e, NULL))
        return SALTUS_OK;
    memcpy(e->kept, e->residual, (size_t)e->count * sizeof *e->residual);
    memcpy(e->trial, u, (size_t)e->unknowns * sizeof *u);
    for (int k = 0; k < steps_max && !*iterations; k++) {
        const double before = e->size;
        solve_step(e, e->trial, NULL, NULL);
        for (int j = 0; j < e->unknowns; j++)
            length = fmax(length, fabs(e->step[j]));
        if (!(length < close))
            break;
        take(e, e->trial);
        const saltus_status tried = find_residual(e, e->measure, e->trial, message);
        if (is_final(tried))
            return tried;
        const bool near = tried == SALTUS_OK && is_small(e, e->size, e->size / before);
        if (!near && !(tried == SALTUS_OK && e->size < fast * before))
            break;
        report(e, k + 1);
        *iterations = near ? k + 1 : 0;
    }
    if (*iterations) {
        memcpy(u, e->trial, (size_t)e->unknowns * sizeof *u);
        return SALTUS_OK;
    }
    memcpy(e->residual, e->kept, (size_t)e->count * sizeof *e->residual);
    e->size = start;
    return SALTUS_OK;
}

/* Quadratic convergence gives all available digits for one more step: the iteration ends when the residual
 * stops falling. On a hyperplane, where each evaluation is expensive, a step that will certainly end in
 * rounding is the last, and its end is not evaluated. */
saltus_status saltus_newton(saltus_equations *e, double *u, const double *normal, const double *anchor,
                            bool damped, int *iterations, saltus_message *message) {
    approached found;
    *iterations = 0;
    saltus_status status = approach(e, u, normal, anchor, &found, message);
    if (status == SALTUS_OK && (!e->begun || found.near))
        status = saltus_equations_evaluate(e, u, message);
    e->begun = false;
    double best = e->size;
    report(e, 0);
    if (status == SALTUS_OK && normal && e->size <= e->tolerance && find_step(e, u, normal, anchor)) {
        /* That may be the last step: residuals fall by `fall` over the distance between a point and that of
         * the Jacobian. */
        const double fall = found.near ? found.fall : steepest;
        if (e->size * fall * saltus_length(e->step, e->unknowns) < rounding) {
            *iterations = found.near ? found.iterations : 1;
            take(e, u);
            return status;
        }
    }
    if (status == SALTUS_OK && e->hasty && e->measure && !normal)
        status = polish(e, u, iterations, message);
    if (*iterations)
        return status;
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
            memcpy(u, e->kept, (size_t)e->unknowns * sizeof *u);
            status = saltus_equations_evaluate(e, u, message);
            break;
        }
        if (!damped && e->size > 1e3 * fmax(best, e->tolerance))
            break;
        double fall = e->size / best;
        best = e->size;
        if (normal && last_ends_in_rounding(e, best, fall) && find_step(e, u, normal, anchor)) {
            take(e, u);
            break;
        }
        if (is_small(e, best, fall))
            break;
    }
    return status != SALTUS_OK || e->size <= e->tolerance
               ? status
               : saltus_fail(message, SALTUS_NO_CONVERGENCE, "Newton's iteration stops at a residual of %.3g",
                             e->size);
}

saltus_status saltus_curve_tangent(saltus_equations *e, const double *guide, double *tangent, int *sign,
                                   double *log_determinant, saltus_message *message) {
    if (!factor_bordered(e, guide))
        return saltus_fail(message, SALTUS_SINGULAR, "the branch has no tangent here");
    *sign = e->lu.sign;
    *log_determinant = e->lu.log_modulus;
    memset(tangent, 0, (size_t)e->unknowns * sizeof *tangent);
    tangent[e->count] = 1;
    saltus_dense_resolve(&e->lu, false, 1, tangent);
    saltus_make_unit(tangent, e->unknowns);
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
