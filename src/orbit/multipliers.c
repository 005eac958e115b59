/* Floquet multipliers, small ones included.
 *
 * The derivative over an orbit is a product of derivatives over short segments, A_m ... A_1. Formed as one
 * matrix it loses every multiplier below rounding times the largest one, and at five modes they reach 1e-40,
 * at ten 1e-1000. So the product is never formed. First, orthogonal iteration Q_k R_k = A_k Q_{k-1} around
 * the orbit turns the bases towards the invariant subspaces, which takes few cycles where moduli are far
 * apart. Then A_m ... A_1 Q_0 = Q_0 T (R_m ... R_1) with T = Q_0^T Q_m block diagonal. A block of size one
 * holds a real multiplier, the product of its factors. Larger ones, with multipliers of similar modulus, are
 * left to the periodic QR iteration (base/periodic.h), which needs no separation. (Dieci & Van Vleck, Appl.
 * Numer. Math. 17 (1995) 275-291; Lust, Int. J. Bifurcation Chaos 11 (2001) 2389-2410.)
 *
 * An orbit with lasting contacts loses two dimensions per contact; as many multipliers are exact zeros.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/multipliers.h"

#include "base/dense.h"
#include "base/memory.h"
#include "base/periodic.h"
#include "orbit/volume.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What joins two subspaces over a cycle: below this they are separate. */
static const double separate = 1e-12;
/* Growth over a segment beside that segment's largest below which a direction is not told from the errors of
 * the tangent vectors, which are 1e-13 of their length. */
static const double weakest_growth = 1e-10;

/* Advance to a time step by step: trace integral, and the largest number of directions lost. */
static saltus_status advance_watching(saltus_flow *flow, saltus_time until, saltus_cocycle *cocycle,
                                      double *state, const gsl_integration_glfixed_table *table,
                                      saltus_message *message) {
    saltus_event event;
    long long steps = saltus_flow_information(flow, 0).steps;
    do {
        saltus_status status =
            saltus_flow_advance(flow, until, SALTUS_WATCH_STEP | SALTUS_WATCH_CONTACT, &event, message);
        if (status != SALTUS_OK)
            return status;
        cocycle->sum_rule += saltus_trace_over_step(flow, 0, table, state, &steps);
        int lost = saltus_lost_directions(flow, 0, &event);
        cocycle->zeros = lost > cocycle->zeros ? lost : cocycle->zeros;
    } while (event.kind != SALTUS_REACHED);
    return SALTUS_OK;
}

/* Of zeros. */
static void identity(double *a, int n) {
    for (int i = 0; i < n; i++)
        a[i * n + i] = 1;
}

/* The derivatives over the segments, from identity columns; the sum rule's right side on the way. `columns`
 * has room for n of them and a state. */
static saltus_status run_segments(saltus_flow *flow, double phase, int periods, const double *state,
                                  saltus_cocycle *cocycle, double *columns, saltus_message *message) {
    int n = cocycle->n;
    gsl_integration_glfixed_table *table = gsl_integration_glfixed_table_alloc(SALTUS_TRACE_POINTS);
    if (!table)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the multipliers");
    identity(columns, n);
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, phase}, state, message);
    for (int m = 0; m < cocycle->count && status == SALTUS_OK; m++) {
        double end = phase + (double)periods * (m + 1) / cocycle->count, whole = floor(end);
        saltus_time until = {(long long)whole, end - whole};
        if (m + 1 == cocycle->count)
            until = (saltus_time){periods, phase};
        saltus_flow_set_tangents(flow, 0, columns);
        status = advance_watching(flow, until, cocycle, columns + n * n, table, message);
        saltus_flow_tangents(flow, 0, cocycle->segments + (size_t)m * (size_t)(n * n));
    }
    gsl_integration_glfixed_table_free(table);
    cocycle->sum_rule += saltus_flow_information(flow, 0).log_volume;
    return status;
}

/* Segments so short that no direction contracts by more than e^-14 over one: then the errors of the tangent
 * vectors cost the smallest multipliers few digits. Where that takes too many segments they may be half as
 * long again; where even these are too many only the leading multipliers are to be had, and a few segments
 * do. */
static int count_segments(const saltus_system *system, int n, int periods) {
    enum { bytes_max = 1 << 24, coarse = 16 };
    double decay = saltus_system_fastest_decay(system) * saltus_system_period(system);
    double fit = floor(bytes_max / (8.0 * n * n));
    double fine = periods * fmax(1, ceil(decay / 14)), enough = periods * fmax(1, ceil(decay / 20));
    return (int)(fine <= fit ? fine : enough <= fit ? fit : coarse * (double)periods);
}

saltus_status saltus_cocycle_run(const saltus_system *system, const saltus_orbit_options *options,
                                 int periods, const double *state, saltus_cocycle *cocycle,
                                 saltus_message *message) {
    int n = saltus_system_dimension(system);
    size_t square = (size_t)n * (size_t)n;
    *cocycle = (saltus_cocycle){.n = n, .count = count_segments(system, n, periods)};
    saltus_flow *flow = NULL;
    saltus_status status = saltus_flow_single(system, n, &options->flow, &flow, message);
    double *columns = calloc(square + (size_t)n, sizeof *columns);
    cocycle->segments = calloc(square * (size_t)cocycle->count, sizeof *cocycle->segments);
    if (status == SALTUS_OK && !(columns && cocycle->segments))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the multipliers");
    if (status == SALTUS_OK)
        status = run_segments(flow, options->phase, periods, state, cocycle, columns, message);
    free(columns);
    saltus_flow_free(flow);
    if (status != SALTUS_OK)
        saltus_cocycle_clear(cocycle);
    return status;
}

void saltus_cocycle_clear(saltus_cocycle *cocycle) {
    free(cocycle->segments);
    *cocycle = (saltus_cocycle){0};
}

/* Work on a cocycle. All but its own matrices are row-major. */
typedef struct iteration {
    saltus_arena arena;
    int n, count;
    const double *segments; /* by columns */
    double *basis;          /* Q_0 ... Q_m, each in turn */
    double *start;          /* Q_0 */
    double *turn;           /* T = Q_0^T Q_m */
    double *triangles;      /* R_1 ... R_m */
    double *balance;        /* powers of two that the coordinates are divided by */
    double *joins;  /* per k the largest entry of T that joins the first k directions with the others; 0 for
                       none, all */
    double *before; /* the same a cycle earlier */
    double *block;  /* a block of T, and that of each R after it */
    double *product, *real, *imaginary, *work;
} iteration;

static void reserve(iteration *it) {
    size_t n = (size_t)it->n, square = n * n, count = (size_t)it->count;
    it->basis = saltus_arena_doubles(&it->arena, square);
    it->start = saltus_arena_doubles(&it->arena, square);
    it->turn = saltus_arena_doubles(&it->arena, square);
    it->triangles = saltus_arena_doubles(&it->arena, square * count);
    it->balance = saltus_arena_doubles(&it->arena, n);
    it->joins = saltus_arena_doubles(&it->arena, n + 1);
    it->before = saltus_arena_doubles(&it->arena, n + 1);
    it->block = saltus_arena_doubles(&it->arena, square * (count + 1));
    it->product = saltus_arena_doubles(&it->arena, square);
    it->real = saltus_arena_doubles(&it->arena, n);
    it->imaginary = saltus_arena_doubles(&it->arena, n);
    it->work = saltus_arena_doubles(&it->arena, 2 * n);
}

static double *triangle_at(const iteration *it, int m) {
    return it->triangles + (size_t)m * (size_t)(it->n * it->n);
}

/* Coordinates in which the segments' rows and columns are of similar size. */
static bool balance(iteration *it) {
    int n = it->n;
    lapack_int low, high;
    memset(it->product, 0, (size_t)(n * n) * sizeof *it->product);
    for (int m = 0; m < it->count; m++)
        for (int i = 0; i < n * n; i++)
            it->product[i] += fabs(it->segments[(size_t)m * (size_t)(n * n) + (size_t)i]);
    if (!saltus_dense_finite(it->product, (size_t)(n * n)))
        return false;
    return LAPACKE_dgebal_work(LAPACK_COL_MAJOR, 'S', n, it->product, n, &low, &high, it->balance) == 0;
}

/* Any basis that is not special to the system: a pseudo-random one, the same every time. */
static void generic_basis(iteration *it) {
    unsigned long state = 1;
    for (int i = 0; i < it->n * it->n; i++) {
        state = (state * 1664525UL + 1013904223UL) & 0xffffffffUL;
        it->product[i] = (double)state / 4294967296.0 - 0.5;
    }
    saltus_dense_qr(it->product, it->n, it->basis, it->work);
}

/* out = A_m q in balanced coordinates. */
static void multiply(const iteration *it, int m, const double *q, double *out) {
    int n = it->n;
    const double *a = it->segments + (size_t)m * (size_t)(n * n);
    memset(out, 0, (size_t)(n * n) * sizeof *out);
    for (int k = 0; k < n; k++)
        for (int i = 0; i < n; i++) {
            double factor = a[k * n + i] * it->balance[k] / it->balance[i];
            for (int j = 0; j < n; j++)
                out[i * n + j] += factor * q[k * n + j];
        }
}

/* One cycle of orthogonal iteration from the last basis. */
static void cycle(iteration *it) {
    int n = it->n;
    memcpy(it->start, it->basis, (size_t)(n * n) * sizeof *it->start);
    for (int m = 0; m < it->count; m++) {
        multiply(it, m, it->basis, triangle_at(it, m));
        saltus_dense_qr(triangle_at(it, m), n, it->basis, it->work);
    }
    memset(it->turn, 0, (size_t)(n * n) * sizeof *it->turn);
    for (int l = 0; l < n; l++)
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++)
                it->turn[i * n + j] += it->start[l * n + i] * it->basis[l * n + j];
    memcpy(it->before, it->joins, (size_t)(n + 1) * sizeof *it->joins);
    for (int k = 1; k < n; k++) {
        it->joins[k] = 0;
        for (int i = k; i < n; i++)
            for (int j = 0; j < k; j++)
                it->joins[k] = fmax(it->joins[k], fabs(it->turn[i * n + j]));
    }
}

/* Whether some subspaces, at the rate of the last cycle, will be separate within so many cycles more. */
static bool promising(const iteration *it, double cycles) {
    for (int k = 1; k < it->n; k++) {
        double now = it->joins[k], rate = now / it->before[k];
        if (now > separate && log(separate / now) >= cycles * log(rate))
            return true;
    }
    return false;
}

/* Cycles until some more would not be worth their while: the periodic QR iteration does the rest. */
static bool iterate(iteration *it) {
    enum { cycles_min = 3, cycles_max = 300, worthwhile = 3 };
    if (!balance(it))
        return false;
    generic_basis(it);
    for (int k = 0; k < cycles_max; k++) {
        cycle(it);
        if (k + 1 >= cycles_min && !promising(it, worthwhile))
            break;
    }
    return true;
}

static bool splits(const iteration *it, int k) {
    return it->joins[k] <= 10 * separate;
}

/* The leading directions that all segments resolve, up to a split. */
static int count_resolved(const iteration *it, int zeros) {
    int n = it->n, resolved = n - zeros;
    for (int m = 0; m < it->count; m++) {
        const double *r = triangle_at(it, m);
        double largest = 0;
        for (int i = 0; i < n; i++)
            largest = fmax(largest, r[i * n + i]);
        for (int i = 0; i < resolved; i++)
            if (!(r[i * n + i] >= weakest_growth * largest))
                resolved = i;
    }
    while (!splits(it, resolved))
        resolved--;
    return resolved;
}

/* Sum of the logarithms of a direction's growth over the segments. */
static double log_growth(const iteration *it, int i) {
    double sum = 0;
    for (int m = 0; m < it->count; m++)
        sum += log(triangle_at(it, m)[i * it->n + i]);
    return sum;
}

/* The block [first, last) of T and of every R, R's divided by their mean growth; returns the logarithm of
 * what was divided by. */
static double fill_block(iteration *it, int first, int last) {
    int n = it->n, size = last - first;
    double scale = 0, *out = it->block;
    for (int m = -1; m < it->count; m++) {
        const double *from = (m < 0 ? it->turn : triangle_at(it, m)) + first * n + first;
        double mean = 0;
        for (int i = 0; i < size && m >= 0; i++)
            mean += log(from[i * n + i]) / size;
        scale += mean;
        double factor = exp(-mean);
        for (int i = 0; i < size; i++)
            for (int j = 0; j < size; j++)
                *out++ = from[i * n + j] * factor;
    }
    return scale;
}

/* A real multiplier that stands alone. */
static saltus_multiplier single_multiplier(const iteration *it, int at) {
    double turn = it->turn[at * it->n + at], logarithm = log_growth(it, at) + log(fabs(turn));
    return (saltus_multiplier){copysign(exp(logarithm), turn), 0, logarithm};
}

/* Those of the block [first, last). */
static bool block_multipliers(iteration *it, int first, int last, saltus_multiplier *out) {
    int size = last - first;
    if (size == 1) {
        *out = single_multiplier(it, first);
        return true;
    }
    double scale = fill_block(it, first, last);
    if (!saltus_periodic_eigenvalues(it->block, it->block + size * size, size, it->count, it->product,
                                     it->real, it->imaginary))
        return false;
    for (int i = 0; i < size; i++) {
        double modulus = hypot(it->real[i], it->imaginary[i]), logarithm = scale + log(modulus);
        double value = exp(logarithm);
        out[i] = (saltus_multiplier){modulus > 0 ? value * (it->real[i] / modulus) : 0,
                                     modulus > 0 ? value * (it->imaginary[i] / modulus) : 0, logarithm};
    }
    return true;
}

static int by_modulus(const void *a, const void *b) {
    const saltus_multiplier *x = a, *y = b;
    if (x->log_modulus != y->log_modulus)
        return x->log_modulus < y->log_modulus ? 1 : -1;
    return x->im < y->im ? 1 : x->im > y->im ? -1 : 0;
}

/* All multipliers, sorted. */
static bool find_multipliers(iteration *it, int zeros, saltus_multiplier *found, double *log_volume) {
    int n = it->n, first = 0, count = count_resolved(it, zeros);
    *log_volume = count < n - zeros ? NAN : 0;
    for (int i = 1; i <= count; i++) {
        *log_volume += log_growth(it, i - 1);
        if (!splits(it, i))
            continue;
        if (!block_multipliers(it, first, i, found + first))
            return false;
        first = i;
    }
    for (int i = count; i < n; i++)
        found[i] = (saltus_multiplier){0, 0, i < n - zeros ? NAN : -INFINITY};
    qsort(found, (size_t)count, sizeof *found, by_modulus);
    return true;
}

saltus_status saltus_cocycle_multipliers(const double *segments, int n, int count, int zeros,
                                         saltus_multiplier *out, double *log_volume,
                                         saltus_message *message) {
    iteration it = {.n = n, .count = count, .segments = segments};
    saltus_status status = SALTUS_OK;
    reserve(&it);
    if (!saltus_arena_open(&it.arena))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the multipliers");
    reserve(&it);
    if (!(iterate(&it) && find_multipliers(&it, zeros, out, log_volume)))
        status = saltus_fail(message, SALTUS_NO_CONVERGENCE, "the multipliers' eigenvalue iteration fails");
    saltus_arena_close(&it.arena);
    return status;
}

/* The monodromy matrix itself, row-major; `product` has room for it. */
static void form_monodromy(const saltus_cocycle *cocycle, double *monodromy, double *product) {
    int n = cocycle->n;
    identity(monodromy, n);
    for (int m = 0; m < cocycle->count; m++) {
        const double *a = cocycle->segments + (size_t)m * (size_t)(n * n);
        memset(product, 0, (size_t)(n * n) * sizeof *product);
        for (int k = 0; k < n; k++)
            for (int i = 0; i < n; i++)
                for (int j = 0; j < n; j++)
                    product[i * n + j] += a[k * n + i] * monodromy[k * n + j];
        memcpy(monodromy, product, (size_t)(n * n) * sizeof *product);
    }
}

saltus_status saltus_orbit_multipliers(const saltus_system *system, const saltus_orbit_options *options,
                                       saltus_orbit *orbit, saltus_message *message) {
    size_t n = (size_t)orbit->dimension;
    saltus_cocycle cocycle;
    saltus_status status =
        saltus_cocycle_run(system, options, orbit->periods, orbit->state, &cocycle, message);
    double *product = calloc(n * n, sizeof *product);
    orbit->monodromy = calloc(n * n, sizeof *orbit->monodromy);
    orbit->multipliers = calloc(n, sizeof *orbit->multipliers);
    if (status == SALTUS_OK && !(product && orbit->monodromy && orbit->multipliers))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the multipliers");
    if (status == SALTUS_OK) {
        orbit->sum_rule = cocycle.sum_rule;
        orbit->sticks = cocycle.zeros > 0;
        form_monodromy(&cocycle, orbit->monodromy, product);
        status = saltus_cocycle_multipliers(cocycle.segments, cocycle.n, cocycle.count, cocycle.zeros,
                                            orbit->multipliers, &orbit->log_volume, message);
    }
    free(product);
    saltus_cocycle_clear(&cocycle);
    return status;
}

int saltus_multipliers_unstable(const saltus_multiplier *multipliers, int count) {
    const double accuracy = 1e-10; /* of a logarithm */
    int unstable = 0;
    for (int i = 0; i < count; i++)
        unstable += multipliers[i].log_modulus >= -accuracy;
    return unstable;
}

bool saltus_multipliers_stable(const saltus_multiplier *multipliers, int count) {
    for (int i = 0; i < count; i++)
        if (isnan(multipliers[i].re))
            return false;
    return saltus_multipliers_unstable(multipliers, count) == 0;
}
