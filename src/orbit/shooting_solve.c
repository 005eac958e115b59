/* Newton's method, tangents and null vectors of the equations of a prescribed sequence.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/dense.h"
#include "orbit/shooting_private.h"

#include <errno.h>
#include <math.h>
#include <string.h>

enum { halvings_max = 8 };

/* The Jacobian with one row more: a normal, or the parameter held fixed; with `turned`, the orbit closes on
 * minus its begin. */
static bool factor_bordered(saltus_shooting *p, const double *normal, bool turned) {
    int m = p->unknowns;
    memcpy(p->matrix, p->jacobian, (size_t)(p->equations * m) * sizeof(double));
    double *last = p->matrix + (size_t)p->equations * (size_t)m;
    for (int j = 0; j < m; j++)
        last[j] = normal ? normal[j] : j == p->equations;
    for (int i = 0; turned && i < p->n; i++)
        p->matrix[(size_t)((p->sequence.cuts - 1) * p->n + i) * (size_t)m + (size_t)i] += 2;
    return saltus_dense_factor(&p->lu, p->matrix);
}

static double hyperplane(const saltus_shooting *p, const double *u, const double *normal,
                         const double *anchor) {
    double sum = 0;
    for (int j = 0; j < p->unknowns && normal; j++)
        sum = fma(normal[j], u[j] - anchor[j], sum);
    return sum;
}

static void report(const saltus_shooting *p, int iteration) {
    if (p->options.history)
        p->options.history(p->options.context, iteration, p->residual_size,
                           p->sequence.count ? "event times unknown" : "stroboscopic map");
}

/* Halve the step until the residual falls; undamped, the first trial stands if it can be evaluated at all.
 * *status tells of failures that no shorter step could mend. */
static bool take_step(saltus_shooting *p, double *u, bool damped, double before, saltus_status *status,
                      saltus_message *message) {
    double factor = 1;
    for (int h = 0; h < halvings_max; h++, factor /= 2) {
        for (int j = 0; j < p->unknowns; j++)
            p->trial[j] = fma(factor, p->step[j], u[j]);
        saltus_status tried = saltus_shooting_evaluate(p, p->trial, message);
        bool sound = tried == SALTUS_OK;
        if (tried == SALTUS_NO_MEMORY || tried == SALTUS_INTERRUPTED) {
            *status = tried;
            return false;
        }
        if (sound && (!damped || p->residual_size < before || before <= p->options.tolerance)) {
            memcpy(u, p->trial, (size_t)p->unknowns * sizeof *u);
            return true;
        }
        if (!damped)
            return false;
    }
    return false;
}

/* Quadratic convergence costs one step more and gives all the digits there are: the iteration ends when the
 * residual no longer falls. */
saltus_status saltus_shooting_correct(saltus_shooting *p, double *u, const double *normal,
                                      const double *anchor, bool damped, int *iterations,
                                      saltus_message *message) {
    saltus_status status = saltus_shooting_evaluate(p, u, message);
    double tolerance = p->options.tolerance, best = p->residual_size;
    *iterations = 0;
    report(p, 0);
    while (status == SALTUS_OK) {
        if (*iterations == p->options.iterations)
            break;
        if (!factor_bordered(p, normal, false))
            return saltus_fail(message, SALTUS_SINGULAR,
                               "Newton's matrix is singular: the orbit is not isolated");
        for (int i = 0; i < p->equations; i++)
            p->step[i] = -p->residual[i];
        p->step[p->equations] = -hyperplane(p, u, normal, anchor);
        saltus_dense_resolve(&p->lu, false, 1, p->step);
        memcpy(p->kept, u, (size_t)p->unknowns * sizeof *u);
        bool taken = take_step(p, u, damped, best, &status, message);
        if (status != SALTUS_OK)
            return status;
        ++*iterations;
        report(p, *iterations);
        if (!taken || (best <= tolerance && p->residual_size >= best)) {
            memcpy(u, p->kept, (size_t)p->unknowns * sizeof *u);
            status = saltus_shooting_evaluate(p, u, message);
            break;
        }
        if (!damped && p->residual_size > 1e3 * fmax(best, tolerance))
            break;
        double fall = p->residual_size / best;
        best = p->residual_size;
        if (best <= 1e-3 * tolerance || (best <= tolerance && fall > 0.1))
            break;
    }
    if (status == SALTUS_OK && !(p->residual_size <= tolerance))
        return saltus_fail(message, SALTUS_NO_CONVERGENCE, "Newton's iteration stops at a residual of %.3g",
                           p->residual_size);
    return status;
}

/* What a decomposition lacked: memory, of which errno tells, or convergence. */
static saltus_status dense_failure(const char *what, saltus_message *message) {
    if (errno == ENOMEM)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for shooting");
    return saltus_fail(message, SALTUS_NO_CONVERGENCE, "%s", what);
}

saltus_status saltus_shooting_relax(saltus_shooting *p, double *u, int *iterations, saltus_message *message) {
    /* Relative to the largest singular value: directions that the orbit is free to move in. */
    const double open_direction = 1e-9;
    saltus_status status = saltus_shooting_evaluate(p, u, message);
    report(p, 0);
    for (*iterations = 0; status == SALTUS_OK && *iterations < p->options.iterations;) {
        double before = p->residual_size;
        int rank;
        for (int i = 0; i < p->unknowns; i++)
            p->step[i] = i < p->equations ? -p->residual[i] : 0;
        memcpy(p->matrix, p->jacobian, (size_t)(p->equations * p->unknowns) * sizeof(double));
        errno = 0;
        if (!saltus_dense_least_squares(p->matrix, p->equations, p->unknowns, p->step, open_direction, &rank))
            return dense_failure("no shortest Newton step can be computed", message);
        memcpy(p->kept, u, (size_t)p->unknowns * sizeof *u);
        bool taken = take_step(p, u, true, before, &status, message);
        if (status != SALTUS_OK)
            return status;
        ++*iterations;
        report(p, *iterations);
        if (!taken || p->residual_size >= before) {
            memcpy(u, p->kept, (size_t)p->unknowns * sizeof *u);
            status = saltus_shooting_evaluate(p, u, message);
            break;
        }
    }
    if (status == SALTUS_OK && !(p->residual_size <= p->options.tolerance))
        return saltus_fail(message, SALTUS_NO_CONVERGENCE, "Newton's iteration stops at a residual of %.3g",
                           p->residual_size);
    return status;
}

saltus_status saltus_shooting_tangent(saltus_shooting *p, const double *guide, double *tangent, int *sign,
                                      double *log_determinant, saltus_message *message) {
    int m = p->unknowns;
    double size = 0;
    if (!factor_bordered(p, guide, false))
        return saltus_fail(message, SALTUS_SINGULAR, "the branch has no tangent here");
    *sign = p->lu.sign;
    *log_determinant = p->lu.log_modulus;
    memset(tangent, 0, (size_t)m * sizeof *tangent);
    tangent[p->equations] = 1;
    saltus_dense_resolve(&p->lu, false, 1, tangent);
    for (int j = 0; j < m; j++)
        size = hypot(size, tangent[j]);
    for (int j = 0; j < m; j++)
        tangent[j] /= size;
    return SALTUS_OK;
}

void saltus_shooting_flip(saltus_shooting *p, int *sign, double *log_determinant) {
    factor_bordered(p, NULL, true);
    *sign = p->lu.sign;
    *log_determinant = p->lu.log_modulus;
}

saltus_status saltus_shooting_null_plane(saltus_shooting *p, double *vectors, double values[2],
                                         saltus_message *message) {
    memcpy(p->matrix, p->jacobian, (size_t)(p->equations * p->unknowns) * sizeof(double));
    errno = 0;
    if (!saltus_dense_null_vectors(p->matrix, p->equations, p->unknowns, 2, vectors, values))
        return dense_failure("no singular values at a branch point", message);
    return SALTUS_OK;
}

/* The states at the cuts follow from the one at the base; times come from the sequence. */
saltus_status saltus_shooting_fill(saltus_shooting *p, double value, const double *state, double *u,
                                   saltus_message *message) {
    const saltus_sequence *s = &p->sequence;
    int n = p->n;
    for (int i = 0; i < n; i++)
        u[i] = state[i] / p->scale[i];
    for (int j = n; j < s->cuts * n; j++)
        u[j] = 0;
    for (int k = 0; k < s->count; k++)
        u[s->cuts * n + k] = s->mark[k].time;
    u[p->equations] = (value - p->origin) / p->unit;
    saltus_status status = SALTUS_OK;
    for (int cut = 1; cut < s->cuts && status == SALTUS_OK; cut++) {
        /* The residual of the segment before this cut is the state at its end less the unknown, still zero.
         */
        status = saltus_shooting_evaluate(p, u, message);
        for (int i = 0; i < n && status == SALTUS_OK; i++)
            u[cut * n + i] += p->residual[(cut - 1) * n + i];
    }
    return status;
}
