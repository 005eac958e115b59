/* Floquet multipliers, small ones included.
 *
 * The derivative over an orbit is a product of derivatives over short segments, A_m ... A_1. Formed as one
 * matrix it loses every multiplier below rounding times the largest one, and at five modes they reach 1e-100.
 * So the product is never formed for the eigenvalues: orthogonal iteration Q_k R_k = A_k Q_{k-1} around the
 * orbit, cycle after cycle, turns the bases towards the invariant subspaces. When they have settled, one more
 * cycle gives A_m ... A_1 Q = Q' (R_m ... R_1), and Q^T Q' is block diagonal: a block of size one holds a
 * real multiplier, larger ones hold multipliers of (nearly) equal modulus. The block's R factors are
 * multiplied with their scale kept as a logarithm, so nothing underflows. (The idea behind the periodic QR
 * algorithm; Dieci & Van Vleck, Appl. Numer. Math. 17 (1995) 275-291.)
 *
 * An orbit with lasting contacts loses two dimensions per contact; as many multipliers are exact zeros.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/multipliers.h"

#include "base/bits.h"
#include "base/dense.h"
#include "base/memory.h"

#include <gsl/gsl_integration.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { cycles_min = 6, cycles_max = 30, quadrature_points = 12 };

/* Work for one orbit of dimension n in `segments` pieces. */
typedef struct cocycle {
    saltus_arena arena;
    int n, segments, zeros;
    double *segment;   /* segments of n columns of length n */
    double *q, *start; /* bases: n columns of length n */
    double *r;         /* upper triangle of a segment */
    double *product;   /* R_m ... R_1, each row scaled by its own logarithm */
    double *scale;     /* natural logarithms of the rows' scales */
    double *weakest;   /* least growth of each direction over a segment, beside the largest there */
    double *tau, *block, *real, *imaginary, *state;
} cocycle;

static void reserve(cocycle *c) {
    size_t n = (size_t)c->n, square = n * n;
    c->segment = saltus_arena_doubles(&c->arena, square * (size_t)c->segments);
    c->q = saltus_arena_doubles(&c->arena, square);
    c->start = saltus_arena_doubles(&c->arena, square);
    c->r = saltus_arena_doubles(&c->arena, square);
    c->product = saltus_arena_doubles(&c->arena, square);
    c->block = saltus_arena_doubles(&c->arena, square);
    c->scale = saltus_arena_doubles(&c->arena, n);
    c->weakest = saltus_arena_doubles(&c->arena, n);
    c->tau = saltus_arena_doubles(&c->arena, n);
    c->real = saltus_arena_doubles(&c->arena, n);
    c->imaginary = saltus_arena_doubles(&c->arena, n);
    c->state = saltus_arena_doubles(&c->arena, n);
}

static void identity(double *a, int n) {
    memset(a, 0, (size_t)(n * n) * sizeof *a);
    for (int i = 0; i < n; i++)
        a[i * n + i] = 1;
}

/* out = a b for matrices stored by columns. */
static void multiply(const double *a, const double *b, int n, double *out) {
    memset(out, 0, (size_t)(n * n) * sizeof *out);
    for (int j = 0; j < n; j++)
        for (int k = 0; k < n; k++)
            for (int i = 0; i < n; i++)
                out[j * n + i] = fma(a[k * n + i], b[j * n + k], out[j * n + i]);
}

/* The integral of the Jacobian's trace over the flow's last step, by Gauss quadrature on its dense output. */
static double trace_over_step(const saltus_system *system, const saltus_flow *flow, double *state,
                              const gsl_integration_glfixed_table *table) {
    double sum = 0, length = saltus_flow_step_length(flow, 0);
    for (size_t k = 0; k < quadrature_points; k++) {
        double at, weight;
        gsl_integration_glfixed_point(0, length, k, &at, &weight, table);
        saltus_flow_dense(flow, 0, at, state);
        sum += weight * saltus_system_trace(system, state);
    }
    return sum;
}

/* Advance to a time step by step: trace integral, and the largest number of lasting contacts. */
static saltus_status advance_watching(const saltus_system *system, saltus_flow *flow, saltus_time until,
                                      cocycle *c, const gsl_integration_glfixed_table *table, double *trace,
                                      saltus_message *message) {
    saltus_event event;
    do {
        saltus_status status =
            saltus_flow_advance(flow, until, SALTUS_WATCH_STEP | SALTUS_WATCH_CONTACT, &event, message);
        if (status != SALTUS_OK)
            return status;
        if (saltus_flow_step_length(flow, 0) > 0)
            *trace += trace_over_step(system, flow, c->state, table);
        int lost = 2 * saltus_count_bits(saltus_flow_contacts(flow, 0));
        c->zeros = lost > c->zeros ? lost : c->zeros;
    } while (event.kind != SALTUS_REACHED);
    return SALTUS_OK;
}

/* The derivatives over the segments, from identity columns; the sum rule's right side on the way. */
static saltus_status run_segments(const saltus_system *system, saltus_flow *flow, double phase, cocycle *c,
                                  saltus_orbit *orbit, saltus_message *message) {
    gsl_integration_glfixed_table *table = gsl_integration_glfixed_table_alloc(quadrature_points);
    if (!table)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the multipliers");
    double trace = 0;
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, phase}, orbit->state, message);
    for (int m = 0; m < c->segments && status == SALTUS_OK; m++) {
        double periods = phase + (double)orbit->periods * (m + 1) / c->segments, whole = floor(periods);
        saltus_time until = {(long long)whole, periods - whole};
        if (m + 1 == c->segments)
            until = (saltus_time){orbit->periods, phase};
        identity(c->q, c->n);
        saltus_flow_set_tangents(flow, 0, c->q);
        status = advance_watching(system, flow, until, c, table, &trace, message);
        saltus_flow_tangents(flow, 0, c->segment + (size_t)m * (size_t)(c->n * c->n));
    }
    gsl_integration_glfixed_table_free(table);
    orbit->sum_rule = trace + saltus_flow_information(flow, 0).log_volume;
    orbit->sticks = c->zeros > 0;
    return status;
}

/* product = R product with rows kept at unit size and their scales as logarithms. */
static void accumulate(cocycle *c) {
    int n = c->n;
    for (int i = 0; i < n; i++) {
        /* Row i of R times the product: the largest scale among the rows involved is the reference. */
        double reference = -INFINITY, size = 0;
        for (int k = i; k < n; k++)
            if (c->r[i * n + k] != 0)
                reference = fmax(reference, c->scale[k] + log(fabs(c->r[i * n + k])));
        for (int j = 0; j < n; j++)
            c->block[j] = 0;
        for (int k = i; k < n && reference > -INFINITY; k++)
            if (c->r[i * n + k] != 0)
                for (int j = k; j < n; j++)
                    c->block[j] +=
                        copysign(exp(c->scale[k] + log(fabs(c->r[i * n + k])) - reference), c->r[i * n + k]) *
                        c->product[k * n + j];
        for (int j = 0; j < n; j++)
            size = fmax(size, fabs(c->block[j]));
        for (int j = 0; j < n; j++)
            c->product[i * n + j] = size > 0 ? c->block[j] / size : 0;
        c->scale[i] = size > 0 ? reference + log(size) : -INFINITY;
    }
}

/* One cycle of orthogonal iteration from basis c->q (kept in c->start); true unless QR fails. */
static bool cycle(cocycle *c, double *log_volume) {
    int n = c->n;
    memcpy(c->start, c->q, (size_t)(n * n) * sizeof *c->q);
    identity(c->product, n);
    memset(c->scale, 0, (size_t)n * sizeof *c->scale);
    *log_volume = 0;
    for (int i = 0; i < n; i++)
        c->weakest[i] = 1;
    for (int m = 0; m < c->segments; m++) {
        multiply(c->segment + (size_t)m * (size_t)(n * n), c->q, n, c->block);
        memcpy(c->q, c->block, (size_t)(n * n) * sizeof *c->q);
        if (!saltus_dense_qr(c->q, n, n, c->r, c->tau))
            return false;
        double largest = 0;
        for (int i = 0; i < n; i++)
            largest = fmax(largest, c->r[i * n + i]);
        for (int i = 0; i < n; i++) {
            *log_volume += log(c->r[i * n + i]);
            c->weakest[i] = fmin(c->weakest[i], c->r[i * n + i] / largest);
        }
        accumulate(c);
    }
    return true;
}

/* Largest entry of Q^T Q' that joins the first k directions with the rest. */
static double mixing(const cocycle *c, int k) {
    double largest = 0;
    for (int i = k; i < c->n; i++)
        for (int j = 0; j < k; j++) {
            double sum = 0;
            for (int l = 0; l < c->n; l++)
                sum = fma(c->start[i * c->n + l], c->q[j * c->n + l], sum);
            largest = fmax(largest, fabs(sum));
        }
    return largest;
}

/* Multipliers of the diagonal block [first, last). */
static bool block_multipliers(cocycle *c, int first, int last, saltus_multiplier *out) {
    int n = c->n, size = last - first;
    double reference = -INFINITY;
    for (int i = first; i < last; i++)
        reference = fmax(reference, c->scale[i]);
    if (reference == -INFINITY) {
        for (int i = 0; i < size; i++)
            out[i] = (saltus_multiplier){0, 0, -INFINITY};
        return true;
    }
    for (int i = 0; i < size; i++)
        for (int j = 0; j < size; j++) {
            double sum = 0;
            for (int k = 0; k < size; k++) {
                double turn = 0;
                for (int l = 0; l < n; l++)
                    turn = fma(c->start[(first + i) * n + l], c->q[(first + k) * n + l], turn);
                sum += turn * c->product[(first + k) * n + first + j] * exp(c->scale[first + k] - reference);
            }
            c->block[j * size + i] = sum;
        }
    if (!saltus_dense_eigenvalues(c->block, size, c->real, c->imaginary))
        return false;
    for (int i = 0; i < size; i++) {
        double modulus = hypot(c->real[i], c->imaginary[i]), logarithm = reference + log(modulus);
        double value = exp(logarithm);
        out[i] = (saltus_multiplier){modulus > 0 ? value * (c->real[i] / modulus) : 0,
                                     modulus > 0 ? value * (c->imaginary[i] / modulus) : 0, logarithm};
    }
    return true;
}

static int by_modulus(const void *a, const void *b) {
    const saltus_multiplier *x = a, *y = b;
    if (x->log_modulus != y->log_modulus)
        return x->log_modulus < y->log_modulus ? 1 : -1;
    return x->im < y->im ? 1 : x->im > y->im ? -1 : 0;
}

/* Directions whose growth over every segment stands out of rounding beside the largest, and whose multiplier
 * is above the smallest number there is: these are resolved. */
static int count_resolved(cocycle *c) {
    int resolved = c->n - c->zeros;
    for (int i = 0; i < c->n; i++)
        if (c->weakest[i] < 1e-13)
            resolved = i < resolved ? i : resolved;
    return resolved;
}

/* Whether the first `count` directions are separated from each other, alone or in pairs, and from the rest.
 */
static bool separated(const cocycle *c, int count) {
    enum { pair = 2 };
    for (int i = 1, run = 0; i <= count && i < c->n; i++) {
        run = mixing(c, i) > 1e-13 ? run + 1 : 0;
        if (run >= pair)
            return false;
    }
    return true;
}

static bool settle(cocycle *c, saltus_orbit *orbit) {
    int resolved = 0, first = 0;
    identity(c->q, c->n);
    for (int k = 0; k < cycles_max; k++) {
        if (!cycle(c, &orbit->log_volume))
            return false;
        resolved = count_resolved(c);
        if (k >= cycles_min && separated(c, resolved))
            break;
    }
    for (int i = 1; i <= resolved; i++)
        if (i == resolved || mixing(c, i) <= 1e-9) {
            if (!block_multipliers(c, first, i, orbit->multipliers + first))
                return false;
            first = i;
        }
    for (int i = resolved; i < c->n; i++)
        orbit->multipliers[i] = (saltus_multiplier){0, 0, i < c->n - c->zeros ? NAN : -INFINITY};
    if (resolved < c->n - c->zeros)
        orbit->log_volume = NAN;
    qsort(orbit->multipliers, (size_t)resolved, sizeof *orbit->multipliers, by_modulus);
    return true;
}

/* The monodromy matrix itself, row-major. */
static void form_monodromy(cocycle *c, double *monodromy) {
    int n = c->n;
    identity(c->q, n);
    for (int m = 0; m < c->segments; m++) {
        multiply(c->segment + (size_t)m * (size_t)(n * n), c->q, n, c->block);
        memcpy(c->q, c->block, (size_t)(n * n) * sizeof *c->q);
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            monodromy[i * n + j] = c->q[j * n + i];
}

/* Segments so short that no direction contracts by more than e^-20 over one: beyond that the columns become
 * dependent to rounding and the small multipliers are lost. Where that would take too many segments only the
 * leading ones are to be had, and a few segments do for them. */
static int count_segments(const saltus_system *system, const saltus_orbit *orbit) {
    enum { bytes_max = 1 << 24, coarse = 16 };
    double n = orbit->dimension;
    double decay = saltus_system_fastest_decay(system) * saltus_system_period(system) / 20;
    double wanted = orbit->periods * fmax(1, ceil(decay));
    return (int)(wanted * 8 * n * n <= bytes_max ? wanted : coarse * (double)orbit->periods);
}

saltus_status saltus_orbit_multipliers(const saltus_system *system, const saltus_orbit_options *options,
                                       saltus_orbit *orbit, saltus_message *message) {
    cocycle c = {.n = orbit->dimension, .segments = count_segments(system, orbit)};
    size_t n = (size_t)c.n;
    saltus_flow_options flow_options = options->flow;
    flow_options.columns = c.n;
    saltus_flow *flow = NULL;
    saltus_status status = saltus_flow_new(&system, 1, &flow_options, &flow, message);
    reserve(&c);
    orbit->monodromy = calloc(n * n, sizeof *orbit->monodromy);
    orbit->multipliers = calloc(n, sizeof *orbit->multipliers);
    if (status == SALTUS_OK && !(orbit->monodromy && orbit->multipliers && saltus_arena_open(&c.arena)))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the multipliers");
    if (status == SALTUS_OK) {
        reserve(&c);
        status = run_segments(system, flow, options->phase, &c, orbit, message);
    }
    if (status == SALTUS_OK) {
        form_monodromy(&c, orbit->monodromy);
        if (!settle(&c, orbit))
            status =
                saltus_fail(message, SALTUS_NO_CONVERGENCE, "the multipliers' eigenvalue iteration fails");
    }
    saltus_arena_close(&c.arena);
    saltus_flow_free(flow);
    return status;
}
