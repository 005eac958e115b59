/* Points of a solution curve, the functions that change sign at special ones, and where they do.
 *
 * A determinant is used with its modulus relative to that at the step's begin, so that it neither overflows
 * nor loses its sign. Zeros are bracketed in arclength along the step's direction and found by Brent's method
 * (GSL), every evaluation being a point of the curve solved to rounding.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/branch_private.h"

#include "orbit/multipliers.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_roots.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { evaluations_max = 60 };

/* At special points a multiplier is on the unit circle up to this. */
static const double on_the_circle = 1e-9;

saltus_status saltus_branch_noted(saltus_branch *b, saltus_status status) {
    b->starved |= status == SALTUS_NO_MEMORY;
    return status;
}

bool saltus_solution_room(saltus_solution *s, int unknowns, int dimension) {
    s->unknowns = unknowns;
    if (!s->multipliers)
        s->multipliers = calloc((size_t)dimension, sizeof *s->multipliers);
    if (unknowns > s->room) {
        double *u = realloc(s->u, (size_t)unknowns * sizeof *u);
        if (u)
            s->u = u;
        double *tangent = realloc(s->tangent, (size_t)unknowns * sizeof *tangent);
        if (tangent)
            s->tangent = tangent;
        if (!u || !tangent)
            return false;
        s->room = unknowns;
    }
    return s->multipliers != NULL;
}

void saltus_solution_clear(saltus_solution *s) {
    free(s->u);
    free(s->tangent);
    free(s->multipliers);
    *s = (saltus_solution){0};
}

void saltus_solution_swap(saltus_solution *a, saltus_solution *c) {
    saltus_solution swap = *a;
    *a = *c;
    *c = swap;
}

void saltus_solution_point(saltus_solution *s, double sense) {
    for (int j = 0; j < s->unknowns && sense < 0; j++)
        s->tangent[j] = -s->tangent[j];
}

static double relative(int sign, double log_modulus, double *reference) {
    if (isnan(*reference))
        *reference = log_modulus;
    double difference = log_modulus - *reference;
    return sign * exp(difference < 600 ? difference : 600);
}

saltus_status saltus_branch_test(saltus_branch *b, saltus_solution *out, saltus_message *message) {
    int sign, count;
    double log_modulus;
    const double *guide = out == &b->here ? out->tangent : b->here.tangent;
    saltus_status status =
        saltus_shooting_tangent(b->shooting, guide, out->tangent, &sign, &log_modulus, message);
    if (status != SALTUS_OK)
        return status;
    out->residual = saltus_shooting_residual(b->shooting);
    out->test[SALTUS_TEST_BRANCH] = relative(sign, log_modulus, &b->reference[0]);
    saltus_shooting_flip(b->shooting, &sign, &log_modulus);
    out->test[SALTUS_TEST_FLIP] = relative(sign, log_modulus, &b->reference[1]);
    out->test[SALTUS_TEST_FOLD] = out->tangent[out->unknowns - 1];
    out->test[SALTUS_TEST_VALUE] = saltus_shooting_value(b->shooting, out->u) - b->target;
    const saltus_breach *breaches = saltus_shooting_breaches(b->shooting, &count);
    out->worst = (saltus_breach){.value = -INFINITY};
    for (int k = 0; k < count; k++)
        if (breaches[k].value > out->worst.value)
            out->worst = breaches[k];
    out->test[SALTUS_TEST_BREACH] = fmax(out->worst.value, -1);
    out->follows = false;
    return status;
}

saltus_status saltus_branch_visit(saltus_branch *b, double ahead, saltus_solution *out,
                                  saltus_message *message) {
    int m = b->here.unknowns;
    if (!saltus_solution_room(out, m, b->n))
        return saltus_branch_noted(b, saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch"));
    for (int j = 0; j < m; j++)
        out->u[j] = fma(ahead, b->here.tangent[j], b->here.u[j]);
    memcpy(out->tangent, out->u, (size_t)m * sizeof *out->u);
    out->ahead = ahead;
    saltus_status status = saltus_shooting_correct(b->shooting, out->u, b->here.tangent, out->tangent, false,
                                                   &out->iterations, message);
    return saltus_branch_noted(b, status == SALTUS_OK ? saltus_branch_test(b, out, message) : status);
}

saltus_status saltus_branch_tune(saltus_branch *b, double value, saltus_message *message) {
    saltus_spec spec = saltus_spec_shifted(&b->spec, &b->direction, value - b->origin);
    saltus_system *system = NULL;
    saltus_status status = saltus_system_new(&spec, &system, message);
    if (status == SALTUS_OK)
        status = saltus_flow_retune(b->flow, 0, system, message);
    if (status != SALTUS_OK) {
        saltus_system_free(system);
        return status;
    }
    saltus_system_free(b->system);
    b->system = system;
    return status;
}

/* The product over all pairs of mu_i mu_j - 1: zero where a complex pair is on the unit circle. */
static double pair_product(const saltus_multiplier *mu, int n) {
    double re = 1, im = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++) {
            double a = mu[i].re * mu[j].re - mu[i].im * mu[j].im - 1;
            double c = mu[i].re * mu[j].im + mu[i].im * mu[j].re;
            double next = re * a - im * c;
            im = re * c + im * a;
            re = next;
        }
    return re;
}

saltus_status saltus_branch_walk(saltus_branch *b, saltus_solution *s, saltus_message *message) {
    saltus_sequence sequence;
    saltus_message ignored;
    s->follows = false;
    saltus_status status = saltus_branch_tune(b, saltus_shooting_value(b->shooting, s->u), message);
    if (status != SALTUS_OK)
        return saltus_branch_noted(b, status);
    saltus_shooting_extract(b->shooting, s->u, &sequence, b->state);
    status = saltus_sequence_walk(&sequence, b->flow, saltus_shooting_states(b->shooting, s->u), &b->lap,
                                  &ignored);
    s->follows = status == SALTUS_OK && saltus_sequence_follows(&sequence, &b->lap);
    saltus_branch_noted(b, status);
    return status == SALTUS_NO_MEMORY ? saltus_fail(message, status, "%s", ignored.text) : SALTUS_OK;
}

saltus_status saltus_branch_survey(saltus_branch *b, saltus_solution *s, saltus_message *message) {
    saltus_message ignored;
    saltus_status status = saltus_branch_walk(b, s, message);
    s->unstable = 0;
    for (int i = 0; i < b->n; i++)
        s->multipliers[i] = (saltus_multiplier){NAN, NAN, NAN};
    s->log_volume = s->sum_rule = s->test[SALTUS_TEST_PAIR] = NAN;
    if (status != SALTUS_OK)
        return status;
    const saltus_sequence *sequence = saltus_shooting_sequence(b->shooting);
    saltus_orbit orbit = {.dimension = b->n, .periods = sequence->periods, .state = b->state};
    saltus_orbit_options options = b->options.orbit;
    options.phase = sequence->base - floor(sequence->base);
    status = saltus_orbit_multipliers(b->system, &options, &orbit, &ignored);
    if (saltus_branch_noted(b, status) == SALTUS_OK) {
        memcpy(s->multipliers, orbit.multipliers, (size_t)b->n * sizeof *s->multipliers);
        s->log_volume = orbit.log_volume;
        s->sum_rule = orbit.sum_rule;
        for (int i = 0; i < b->n; i++)
            s->unstable += s->multipliers[i].log_modulus > on_the_circle;
        s->test[SALTUS_TEST_PAIR] = pair_product(s->multipliers, b->n);
    }
    free(orbit.monodromy);
    free(orbit.multipliers);
    return SALTUS_OK;
}

double saltus_branch_half_distance(saltus_branch *b, const saltus_solution *s, bool mirrored) {
    saltus_sequence sequence;
    saltus_shooting *shooting = NULL;
    saltus_message ignored;
    double largest = INFINITY;
    saltus_shooting_extract(b->shooting, s->u, &sequence, b->state);
    if (sequence.periods % 2 && !mirrored)
        return largest;
    sequence.cuts = 2;
    sequence.cut[1] = sequence.base + 0.5 * sequence.periods;
    double *u = calloc((size_t)(2 * b->n + sequence.count + 1), sizeof *u);
    saltus_status status = u ? saltus_shooting_new(&b->spec, &b->direction, b->origin, b->unit,
                                                   &b->options.orbit, &shooting, &ignored)
                             : SALTUS_NO_MEMORY;
    if (status == SALTUS_OK)
        status = saltus_shooting_shape(shooting, &sequence, &ignored);
    if (status == SALTUS_OK)
        status =
            saltus_shooting_fill(shooting, saltus_shooting_value(b->shooting, s->u), b->state, u, &ignored);
    if (saltus_branch_noted(b, status) == SALTUS_OK) {
        largest = 0;
        for (int i = 0; i < b->n; i++)
            largest = fmax(largest, fabs(u[b->n + i] + (mirrored ? u[i] : -u[i])));
    }
    saltus_shooting_free(shooting);
    free(u);
    return largest;
}

/* One location under way. */
typedef struct probe {
    saltus_branch *b;
    saltus_test test;
    double end, near, far; /* the bracket's other end, values at both */
    bool failed;
} probe;

static double test_at(double ahead, void *context) {
    probe *q = context;
    saltus_message ignored;
    if (ahead == 0 || ahead == q->end)
        return ahead == 0 ? q->near : q->far;
    if (q->failed)
        return 0;
    saltus_status status = saltus_branch_visit(q->b, ahead, &q->b->trial, &ignored);
    /* In the very place the equations may be singular. */
    for (int side = -1; side <= 1 && status != SALTUS_OK; side += 2)
        status = saltus_branch_visit(q->b, ahead + side * 1e-5 * q->end, &q->b->trial, &ignored);
    if (status == SALTUS_OK && q->test == SALTUS_TEST_PAIR)
        status = saltus_branch_survey(q->b, &q->b->trial, &ignored);
    double value = q->b->trial.test[q->test];
    q->failed = status != SALTUS_OK || !isfinite(value);
    return q->failed ? 0 : value;
}

bool saltus_branch_locate(saltus_branch *b, saltus_test test, double ahead, double far, double *accuracy) {
    probe q = {.b = b, .test = test, .end = ahead, .near = b->here.test[test], .far = far};
    gsl_function function = {.function = test_at, .params = &q};
    *accuracy = INFINITY;
    if (!(q.near * far < 0))
        return false;
    gsl_root_fsolver *solver = gsl_root_fsolver_alloc(gsl_root_fsolver_brent);
    b->starved |= !solver;
    if (!solver)
        return false;
    double low = 0, high = ahead, root = ahead;
    bool going = gsl_root_fsolver_set(solver, &function, 0, ahead) == GSL_SUCCESS;
    for (int k = 0; k < evaluations_max && going && !q.failed; k++) {
        going = gsl_root_fsolver_iterate(solver) == GSL_SUCCESS;
        root = gsl_root_fsolver_root(solver);
        low = gsl_root_fsolver_x_lower(solver);
        high = gsl_root_fsolver_x_upper(solver);
        going = going && high - low > 1e-13 * fmax(1, fabs(root)) && b->trial.test[test] != 0;
    }
    gsl_root_fsolver_free(solver);
    saltus_message ignored;
    if (q.failed || saltus_branch_visit(b, root, &b->trial, &ignored) != SALTUS_OK)
        return false;
    double slope = fabs(b->trial.tangent[b->trial.unknowns - 1]) * b->unit,
           width = b->trial.test[test] == 0 ? 0 : high - low;
    *accuracy = slope * width + b->unit * width * width;
    return true;
}

/* The polynomial through (x_k, y_k) at zero (Neville). */
static double neville_at_zero(const double *x, const double *y, int count) {
    double p[8];
    memcpy(p, y, (size_t)count * sizeof *p);
    for (int level = 1; level < count; level++)
        for (int k = 0; k + level < count; k++)
            p[k] = (x[k + level] * p[k] - x[k] * p[k + 1]) / (x[k + level] - x[k]);
    return p[0];
}

enum { crossing_samples = 6 };

/* Points on both sides of an expected crossing: tests and unknowns (crossing_samples x m). */
static bool sample_crossing(saltus_branch *b, double middle, double apart, double *test, double *u) {
    static const double place[crossing_samples] = {-1, 1, -2, 2, -3, 3};
    int m = b->here.unknowns;
    saltus_message ignored;
    for (int k = 0; k < crossing_samples; k++) {
        if (saltus_branch_visit(b, middle + place[k] * apart, &b->trial, &ignored) != SALTUS_OK)
            return false;
        test[k] = b->trial.test[SALTUS_TEST_BRANCH];
        for (int j = 0; j < m; j++)
            u[j * crossing_samples + k] = b->trial.u[j];
        if (k % 2 && !(test[k] * test[k - 1] < 0))
            return false;
    }
    return true;
}

bool saltus_branch_crossing(saltus_branch *b, double ahead, double *accuracy) {
    int m = b->here.unknowns, last = (m - 1) * crossing_samples;
    double test[crossing_samples], *u = calloc((size_t)(m * crossing_samples), sizeof *u);
    saltus_message ignored;
    bool found = u && sample_crossing(b, ahead, 0.1 * b->next.ahead, test, u);
    for (int pass = 0; pass < 2 && found; pass++) {
        double middle = 0;
        for (int j = 0; j < m; j++)
            b->trial.u[j] = neville_at_zero(test, u + j * crossing_samples, crossing_samples);
        for (int j = 0; j < m; j++)
            middle += (b->trial.u[j] - b->here.u[j]) * b->here.tangent[j];
        b->trial.ahead = middle;
        *accuracy = b->unit * fabs(b->trial.u[m - 1] - neville_at_zero(test, u + last, crossing_samples - 2));
        if (pass == 0)
            found = sample_crossing(b, middle, fmin(4e-4, 0.1 * b->next.ahead), test, u);
    }
    found = found && saltus_shooting_evaluate(b->shooting, b->trial.u, &ignored) == SALTUS_OK;
    b->trial.residual = saltus_shooting_residual(b->shooting);
    free(u);
    return found;
}

bool saltus_branch_pair_on_circle(const saltus_branch *b, const saltus_solution *s) {
    for (int i = 0; i < b->n; i++)
        if (fabs(s->multipliers[i].log_modulus) < 1e-6 && s->multipliers[i].im != 0)
            return true;
    return false;
}
