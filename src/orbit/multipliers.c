/* Floquet multipliers, small ones included.
 *
 * The derivative around an orbit is a product A_m ... A_1 of derivatives over short segments. Multiplied out
 * it loses every multiplier below rounding times the largest one; they reach 1e-40 at five modes and 1e-1000
 * at ten. So the product is never formed. First, orthogonal iteration Q_k R_k = A_k Q_{k-1} around the orbit
 * turns the bases towards the invariant subspaces, which takes few cycles if moduli are far apart. Then A_m
 * ... A_1 Q_0 = Q_0 T (R_m ... R_1) with T = Q_0^T Q_m block diagonal. A block of size one holds a real
 * multiplier, the product of its factors. Larger blocks, whose multipliers have similar moduli, go to the
 * periodic QR iteration (base/periodic.h), which needs no separation. (Dieci & Van Vleck, Appl. Numer. Math.
 * 17 (1995) 275-291; Lust, Int. J. Bifurcation Chaos 11 (2001) 2389-2410.)
 *
 * For an orbit without forcing one multiplier belongs to the direction f of the flow. In bases at the
 * segments' ends whose first vector is along f, every segment is block triangular, (t *; 0 B): the product of
 * the t is 1 up to errors, and the B contain the other multipliers.
 *
 * An impact of speed v has a singular value in proportion to 1 / v, and another one to v. So segments end
 * after slow impacts; and if errors hide only the last direction, the sum rule gives its multiplier.
 *
 * A lasting contact takes two dimensions away, hence two multipliers are exact zeros.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/multipliers.h"

#include "base/bits.h"
#include "base/dense.h"
#include "base/memory.h"
#include "base/periodic.h"
#include "flow/flow.h"

#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Subspaces that a cycle couples by less than this are separate. */
static const double separate = 1e-12;
/* Errors of the tangent vectors, as a fraction of their length, and the fraction of a segment's largest
 * growth below which that of a direction is lost in them. */
static const double tangent_error = 1e-13, weakest_growth = 1e-10;
/* A segment ends after an impact when tangent vectors have grown this much: their errors hide directions that
 * have not. The last direction of all is then found more accurately by the sum rule if its growth is below
 * `weakest_grown` of the largest. */
static const double grown = 30, weakest_grown = 1e-7;
/* Multipliers below this modulus may stay unresolved. */
static const double negligible = 1e-10;

/* Segments per period that suffice for the leading multipliers; most memory for segments. */
enum { coarse = 4, bytes_max = 1 << 22 };

double saltus_trace_over_step(const saltus_flow *flow, int lane, const gsl_integration_glfixed_table *table,
                              long long *steps) {
    const saltus_system *system = saltus_flow_system(flow, lane);
    const double period = saltus_system_period(system), end = saltus_flow_time(flow, lane).phase;
    double sum = 0, length = saltus_flow_step_length(flow, lane);
    long long made = saltus_flow_information(flow, lane).steps;
    bool fresh = made != *steps;
    *steps = made;
    for (size_t k = 0; k < SALTUS_TRACE_POINTS && fresh; k++) {
        double at, weight, state[SALTUS_STATE_MAX];
        gsl_integration_glfixed_point(0, length, k, &at, &weight, table);
        saltus_flow_dense(flow, lane, at, state);
        const double phase = end - (length - at) / period;
        sum += weight * saltus_system_trace(system, state, phase - floor(phase));
    }
    return sum;
}

int saltus_lost_directions(const saltus_flow *flow, int lane, const saltus_event *event) {
    int lost = 2 * saltus_count_bits(saltus_flow_contacts(flow, lane));
    bool dead =
        event->kind == SALTUS_IMPACT && saltus_system_restitution(saltus_flow_system(flow, lane), event->face,
                                                                  fabs(event->velocity_before)) == 0;
    return lost > 0 ? lost : dead;
}

/* Segments per period: so many that no direction contracts by more than e^-18 over one, so that errors of the
 * tangent vectors cost the smallest multipliers few digits. If that exceeds the limits, as many as they
 * allow, if the contraction then stays above e^-20; else enough for the leading multipliers only. */
static double choose_density(const saltus_system *system, int n, int periods, int most) {
    const double decay = saltus_system_fastest_decay(system) * saltus_system_period(system);
    const double room = floor(bytes_max / (8.0 * n * n)),
                 fit = most ? fmin(room, (double)most * periods) : room;
    double fine = periods * fmax(1, ceil(decay / 18)), enough = periods * fmax(1, ceil(decay / 20));
    return (fine <= fit ? fine : enough <= fit ? fit : coarse * (double)periods) / periods;
}

saltus_status saltus_cocycle_open(saltus_cocycle *cocycle, const saltus_system *system, int periods,
                                  bool autonomous, saltus_message *message) {
    int n = cocycle->n = saltus_system_dimension(system);
    cocycle->count = cocycle->zeros = 0;
    cocycle->given = false;
    cocycle->autonomous = autonomous;
    cocycle->periods = periods;
    cocycle->scale = saltus_system_scale(system);
    cocycle->sum_rule = 0;
    cocycle->mirrored = false;
    cocycle->density = fmax(choose_density(system, n, periods, cocycle->most), cocycle->wanted);
    if (!cocycle->table)
        cocycle->table = gsl_integration_glfixed_table_alloc(SALTUS_TRACE_POINTS);
    return cocycle->table ? SALTUS_OK
                          : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the multipliers");
}

/* Whether the segments are so short that the fastest modes of a stiff system are active throughout. */
static bool wants_taylor(const saltus_cocycle *cocycle, const saltus_system *system, int periods,
                         const saltus_flow_options *options) {
    const int n = saltus_system_dimension(system);
    return options->integrator == SALTUS_AUTOMATIC &&
           choose_density(system, n, periods, cocycle->most) > coarse;
}

bool saltus_cocycle_takes(const saltus_cocycle *cocycle, const saltus_system *system, int periods,
                          const saltus_flow_options *options) {
    return saltus_flow_restarts_in_series(system, options->integrator) ||
           !wants_taylor(cocycle, system, periods, options);
}

saltus_status saltus_cocycle_flow(const saltus_cocycle *cocycle, const saltus_system *system, int periods,
                                  const saltus_flow_options *options, saltus_flow **flow,
                                  saltus_message *message) {
    saltus_flow_options own = *options;
    if (wants_taylor(cocycle, system, periods, options))
        own.integrator = SALTUS_TAYLOR;
    saltus_status status = saltus_flow_single(system, saltus_system_dimension(system), &own, flow, message);
    if (status == SALTUS_OK)
        saltus_flow_expect_transients(*flow);
    return status;
}

void saltus_cocycle_close(saltus_cocycle *cocycle) {
    free(cocycle->segments);
    free(cocycle->fields);
    if (cocycle->table)
        gsl_integration_glfixed_table_free(cocycle->table);
    *cocycle = (saltus_cocycle){0};
}

/* Make room for one more matrix. */
static saltus_status reserve_segment(saltus_cocycle *cocycle, saltus_message *message) {
    if (cocycle->count < cocycle->room)
        return SALTUS_OK;
    const size_t room = 2 * (size_t)cocycle->count + 8, n = (size_t)cocycle->n;
    double *segments = realloc(cocycle->segments, room * n * n * sizeof *segments);
    if (segments)
        cocycle->segments = segments;
    double *fields = segments ? realloc(cocycle->fields, room * n * sizeof *fields) : NULL;
    if (!fields)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the multipliers");
    cocycle->fields = fields;
    cocycle->room = (int)room;
    return SALTUS_OK;
}

/* The matrix that is next to be added. */
static double *next_segment(const saltus_cocycle *cocycle) {
    return cocycle->segments + (size_t)cocycle->count * (size_t)(cocycle->n * cocycle->n);
}

saltus_status saltus_cocycle_add(saltus_cocycle *cocycle, const double *matrix, saltus_message *message) {
    saltus_status status = reserve_segment(cocycle, message);
    if (status == SALTUS_OK) {
        memcpy(next_segment(cocycle), matrix, (size_t)(cocycle->n * cocycle->n) * sizeof *matrix);
        cocycle->count++;
    }
    return status;
}

bool saltus_cocycle_ends(const saltus_cocycle *cocycle, const double *matrix) {
    const int n = cocycle->n;
    double largest = 0;
    for (int k = 0; k < n; k++)
        for (int i = 0; i < n; i++)
            largest = fmax(largest, fabs(matrix[k * n + i]) * cocycle->scale[k] / cocycle->scale[i]);
    return largest > grown;
}

static saltus_status begin_segment(saltus_cocycle *cocycle, saltus_flow *flow, saltus_message *message) {
    const int n = cocycle->n;
    saltus_status status = reserve_segment(cocycle, message);
    if (status != SALTUS_OK)
        return status;
    double *identity = next_segment(cocycle);
    for (int k = 0; k < n * n; k++)
        identity[k] = k % (n + 1) == 0;
    saltus_flow_set_tangents(flow, 0, identity);
    if (!cocycle->autonomous)
        return SALTUS_OK;
    /* The direction of the flow at the start, of unit length in the system's scales. */
    double *field = cocycle->fields + (size_t)cocycle->count * (size_t)n;
    saltus_flow_field(flow, 0, field);
    for (int i = 0; i < n; i++)
        field[i] /= cocycle->scale[i];
    const double size = saltus_length(field, n);
    for (int i = 0; i < n; i++)
        field[i] = size > 0 ? field[i] / size : i == 0;
    return SALTUS_OK;
}

/* Note an event: its directions that are exact zeros, whether it turns phase space over, and after an impact
 * over which tangent vectors have grown the segment's end. */
static saltus_status note_event(saltus_cocycle *cocycle, saltus_flow *flow, const saltus_event *event,
                                saltus_message *message) {
    const int lost = saltus_lost_directions(flow, 0, event);
    cocycle->zeros = lost > cocycle->zeros ? lost : cocycle->zeros;
    if (event->kind != SALTUS_IMPACT)
        return SALTUS_OK;
    const double speed = fabs(event->velocity_before);
    cocycle->mirrored ^= saltus_system_rebound(saltus_flow_system(flow, 0), event->face, speed).slope < 0;
    if (cocycle->given)
        return SALTUS_OK;
    saltus_flow_tangents(flow, 0, next_segment(cocycle));
    if (!saltus_cocycle_ends(cocycle, next_segment(cocycle)))
        return SALTUS_OK;
    cocycle->count++;
    return begin_segment(cocycle, flow, message);
}

/* Follow the flow to a time: the derivative of the last segment, its part of the sum rule, the number of
 * exact zeros. */
static saltus_status follow_segment(saltus_cocycle *cocycle, saltus_flow *flow, saltus_time until,
                                    saltus_lap *lap, saltus_message *message) {
    double state[SALTUS_STATE_MAX];
    saltus_flow_info before = saltus_flow_information(flow, 0);
    long long steps = before.steps;
    saltus_status status = cocycle->given ? SALTUS_OK : begin_segment(cocycle, flow, message);
    for (saltus_event event = {.kind = SALTUS_STEP}; event.kind != SALTUS_REACHED && status == SALTUS_OK;) {
        status = saltus_flow_advance(flow, until, SALTUS_WATCH_STEP | SALTUS_WATCH_CONTACT, &event, message);
        if (status != SALTUS_OK)
            return status;
        cocycle->sum_rule += saltus_trace_over_step(flow, 0, cocycle->table, &steps);
        status = note_event(cocycle, flow, &event, message);
        saltus_flow_state(flow, 0, state);
        if (lap && !saltus_lap_add(lap, &event, state))
            return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the events of an orbit");
    }
    cocycle->sum_rule += saltus_flow_information(flow, 0).log_volume - before.log_volume;
    if (!cocycle->given && status == SALTUS_OK) {
        saltus_flow_tangents(flow, 0, next_segment(cocycle));
        cocycle->count++;
    }
    return status;
}

saltus_status saltus_cocycle_follow(saltus_cocycle *cocycle, saltus_flow *flow, saltus_time until,
                                    saltus_lap *lap, saltus_message *message) {
    saltus_time from = saltus_flow_time(flow, 0);
    double length = saltus_time_between(from, until);
    const int more = cocycle->given ? 1 : (int)fmax(1, ceil(length * cocycle->density - 1e-9));
    saltus_status status = SALTUS_OK;
    for (int m = 1; m <= more && status == SALTUS_OK; m++) {
        const double end = saltus_time_periods(from) + length * m / more;
        const saltus_time at = m < more ? saltus_time_of(end) : until;
        status = follow_segment(cocycle, flow, at, lap, message);
    }
    if (lap)
        lap->contacts = saltus_flow_contacts(flow, 0);
    return status;
}

/* Orthogonal iteration on a cocycle. Matrices are row-major except the segments. */
typedef struct iteration {
    saltus_arena arena;
    int n, count;
    const double *segments; /* [count], by columns */
    double *basis;          /* Q_0, Q_1, ..., Q_m in turn */
    double *start;          /* Q_0 */
    double *turn;           /* T = Q_0^T Q_m */
    double *triangles;      /* R_1 ... R_m */
    double *block;          /* a block of T, followed by that of each R */
    double *product;
    double balance[SALTUS_STATE_MAX]; /* powers of two that coordinates are divided by */
    /* [k]: the largest entry of T that couples the first k directions to the others, 0 for k = 0 and k = n;
     * and the same one cycle earlier. */
    double coupling[SALTUS_STATE_MAX + 1], before[SALTUS_STATE_MAX + 1];
    double work[2 * SALTUS_STATE_MAX];
} iteration;

static double *triangle_at(const iteration *it, int m) {
    return it->triangles + (size_t)m * (size_t)(it->n * it->n);
}

/* Find coordinates that balance the segments' rows and columns, and a first basis that is generic:
 * pseudo-random, the same every time. False if an entry is not finite. */
static bool begin(iteration *it) {
    int n = it->n;
    lapack_int low, high;
    unsigned long random = 1;
    memset(it->product, 0, (size_t)(n * n) * sizeof *it->product);
    for (int m = 0; m < it->count; m++)
        for (int i = 0; i < n * n; i++)
            it->product[i] += fabs(it->segments[(size_t)m * (size_t)(n * n) + (size_t)i]);
    if (!saltus_dense_finite(it->product, (size_t)(n * n)) ||
        LAPACKE_dgebal_work(LAPACK_COL_MAJOR, 'S', n, it->product, n, &low, &high, it->balance) != 0)
        return false;
    for (int i = 0; i < n * n; i++) {
        random = (random * 1664525UL + 1013904223UL) & 0xffffffffUL;
        it->product[i] = (double)random / 4294967296.0 - 0.5;
    }
    saltus_dense_qr(it->product, n, it->basis, it->work);
    return true;
}

/* out = a q, where `a` is by columns, in balanced coordinates if `balance` is given, and q and out by rows.
 */
static void multiply(const double *a, int n, const double *balance, const double *q, double *out) {
    memset(out, 0, (size_t)(n * n) * sizeof *out);
    for (int k = 0; k < n; k++)
        for (int i = 0; i < n; i++) {
            double factor = balance ? a[k * n + i] * balance[k] / balance[i] : a[k * n + i];
            for (int j = 0; j < n; j++)
                out[i * n + j] += factor * q[k * n + j];
        }
}

/* One cycle of orthogonal iteration from the last basis. */
static void cycle(iteration *it) {
    int n = it->n;
    memcpy(it->start, it->basis, (size_t)(n * n) * sizeof *it->start);
    for (int m = 0; m < it->count; m++) {
        const double *segment = it->segments + (size_t)m * (size_t)(n * n);
        multiply(segment, n, it->balance, it->basis, triangle_at(it, m));
        saltus_dense_qr(triangle_at(it, m), n, it->basis, it->work);
    }
    multiply(it->start, n, NULL, it->basis, it->turn);
    memcpy(it->before, it->coupling, sizeof it->coupling);
    for (int k = 1; k < n; k++) {
        it->coupling[k] = 0;
        for (int i = k; i < n; i++)
            for (int j = 0; j < k; j++)
                it->coupling[k] = fmax(it->coupling[k], fabs(it->turn[i * n + j]));
    }
}

/* Whether the first k directions are separate from the others. */
static bool splits(const iteration *it, int k) {
    return it->coupling[k] <= 10 * separate;
}

/* The largest growth of a direction over a segment. */
static double largest_growth(const iteration *it, int m) {
    double largest = 0;
    for (int i = 0; i < it->n; i++)
        largest = fmax(largest, triangle_at(it, m)[i * it->n + i]);
    return largest;
}

/* Logarithm of a direction's growth over all segments. */
static double log_growth(const iteration *it, int i) {
    double sum = 0;
    for (int m = 0; m < it->count; m++)
        sum += log(triangle_at(it, m)[i * it->n + i]);
    return sum;
}

/* The multipliers of the block [first, last); a single one is real. Of a larger block T and every R are
 * copied, the latter divided by its mean growth. */
static bool block_multipliers(iteration *it, int first, int last, saltus_multiplier *out) {
    int n = it->n, size = last - first;
    if (size == 1) {
        double turn = it->turn[first * n + first], logarithm = log_growth(it, first) + log(fabs(turn));
        *out = (saltus_multiplier){copysign(exp(logarithm), turn), 0, logarithm};
        return true;
    }
    double scale = 0, *copy = it->block; /* logarithm of the product of the divisors */
    for (int m = -1; m < it->count; m++) {
        const double *from = (m < 0 ? it->turn : triangle_at(it, m)) + first * n + first;
        double mean = 0;
        for (int i = 0; i < size && m >= 0; i++)
            mean += log(from[i * n + i]) / size;
        scale += mean;
        double factor = exp(-mean);
        for (int i = 0; i < size; i++)
            for (int j = 0; j < size; j++)
                *copy++ = from[i * n + j] * factor;
    }
    double *real = it->work, *imaginary = it->work + size;
    if (!saltus_periodic_eigenvalues(it->block, it->block + size * size, size, it->count, it->product, real,
                                     imaginary))
        return false;
    for (int i = 0; i < size; i++) {
        double modulus = hypot(real[i], imaginary[i]), logarithm = scale + log(modulus);
        double value = exp(logarithm), unit = modulus > 0 ? modulus : 1;
        out[i] = (saltus_multiplier){value * (real[i] / unit), value * (imaginary[i] / unit), logarithm};
    }
    return true;
}

static int by_modulus(const void *a, const void *b) {
    const saltus_multiplier *x = a, *y = b;
    if (x->log_modulus != y->log_modulus)
        return x->log_modulus < y->log_modulus ? 1 : -1;
    return x->im < y->im ? 1 : x->im > y->im ? -1 : 0;
}

/* What rounding leaves of the coupling of the first k directions with the others: where a segment's matrix is
 * large beside the smallest growth of the former, carried on over the next segments. */
static double rounded_coupling(const iteration *it, int k) {
    const int n = it->n;
    double coupling = 0;
    for (int m = 0; m < it->count; m++) {
        const double *r = triangle_at(it, m);
        double least = INFINITY, rest = 0;
        for (int i = 0; i < n; i++)
            if (i < k)
                least = fmin(least, r[i * n + i]);
            else
                rest = fmax(rest, r[i * n + i]);
        coupling = (coupling * rest + DBL_EPSILON * saltus_length(r, n * n)) / least;
    }
    return coupling;
}

/* Of how many leading directions all segments keep the digits; they are reduced until no coupling with the
 * others is left but that of rounding. */
static int count_resolved(const iteration *it, int count) {
    const double most = 1e-6;
    const int n = it->n;
    for (int m = 0; m < it->count; m++) {
        const double *r = triangle_at(it, m), largest = largest_growth(it, m);
        for (int i = 0; i < count; i++) {
            const double weakest = i == n - 1 && largest > grown ? weakest_grown : weakest_growth;
            if (!(r[i * n + i] >= weakest * largest))
                count = i;
        }
    }
    while (!splits(it, count) && !(it->coupling[count] <= fmin(10 * rounded_coupling(it, count), most)))
        count--;
    return count;
}

/* A bound on the logarithm of the moduli of all but the first `count` multipliers. */
static double log_bound(const iteration *it, int count) {
    const int n = it->n;
    double sum = 0;
    for (int m = 0; m < it->count; m++) {
        const double *r = triangle_at(it, m);
        double rest = 0;
        for (int i = count; i < n; i++)
            for (int j = i; j < n; j++)
                rest = hypot(rest, r[i * n + j]);
        sum += log(rest + tangent_error * largest_growth(it, m));
    }
    return sum;
}

/* Find all multipliers, by decreasing modulus. */
static bool find_multipliers(iteration *it, int zeros, saltus_multiplier *found, double *log_volume) {
    const int n = it->n, count = count_resolved(it, n - zeros);
    int first = 0;
    *log_volume = count < n - zeros ? NAN : 0;
    for (int i = 1; i <= count; i++) {
        *log_volume += log_growth(it, i - 1);
        if (i < count && !splits(it, i))
            continue;
        if (!block_multipliers(it, first, i, found + first))
            return false;
        first = i;
    }
    const double lost = count < n - zeros && log_bound(it, count) > log(negligible) ? NAN : 0;
    for (int i = count; i < n; i++)
        found[i] =
            i < n - zeros ? (saltus_multiplier){lost, lost, NAN} : (saltus_multiplier){0, 0, -INFINITY};
    qsort(found, (size_t)count, sizeof *found, by_modulus);
    return true;
}

saltus_status saltus_cocycle_multipliers(const double *segments, int n, int count, int zeros,
                                         saltus_multiplier *out, double *log_volume,
                                         saltus_message *message) {
    enum { cycles_min = 3, cycles_max = 300, worthwhile = 3 };
    iteration it = {.n = n, .count = count, .segments = segments};
    const size_t square = (size_t)n * (size_t)n;
    do {
        it.basis = saltus_arena_doubles(&it.arena, square);
        it.start = saltus_arena_doubles(&it.arena, square);
        it.turn = saltus_arena_doubles(&it.arena, square);
        it.triangles = saltus_arena_doubles(&it.arena, square * (size_t)count);
        it.block = saltus_arena_doubles(&it.arena, square * (size_t)(count + 1));
        it.product = saltus_arena_doubles(&it.arena, square);
    } while (saltus_arena_again(&it.arena));
    if (!it.arena.base)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the multipliers");
    bool found = begin(&it), promising = true;
    /* Iterate until a few more cycles, at the rate of the last one, would not separate another subspace;
     * periodic QR does the rest. */
    for (int k = 1; k <= cycles_max && found && promising; k++) {
        cycle(&it);
        promising = k < cycles_min;
        for (int j = 1; j < n && !promising; j++) {
            const double now = it.coupling[j], rate = now / it.before[j];
            promising = now > separate && log(separate / now) >= worthwhile * log(rate);
        }
    }
    found = found && find_multipliers(&it, zeros, out, log_volume);
    saltus_arena_close(&it.arena);
    return found ? SALTUS_OK
                 : saltus_fail(message, SALTUS_NO_CONVERGENCE, "the multipliers' eigenvalue iteration fails");
}

/* Reflect a vector so that e1 and the unit vector f are exchanged up to sign; its entries are `stride`
 * apart. */
static void reflect(const double *f, int n, double *vector, int stride) {
    const double first = f[0] + copysign(1, f[0]);
    double along = first * vector[0];
    for (int i = 1; i < n; i++)
        along += f[i] * vector[i * stride];
    along /= fabs(first); /* half the squared length of the reflecting vector */
    vector[0] -= along * first;
    for (int i = 1; i < n; i++)
        vector[i * stride] -= along * f[i];
}

/* Remove the flow's direction from the segments, which lose one dimension. Returns its multiplier. */
static double deflate(saltus_cocycle *cocycle) {
    const double *scale = cocycle->scale;
    int n = cocycle->n;
    double trivial = 1;
    for (int m = 0; m < cocycle->count; m++) {
        double *a = cocycle->segments + (size_t)m * (size_t)(n * n);
        const double *from = cocycle->fields + (size_t)(m * n),
                     *to = cocycle->fields + (size_t)((m + 1) % cocycle->count * n);
        for (int k = 0; k < n; k++)
            for (int i = 0; i < n; i++)
                a[k * n + i] *= scale[k] / scale[i];
        for (int k = 0; k < n; k++)
            reflect(to, n, a + k * n, 1);
        for (int i = 0; i < n; i++)
            reflect(from, n, a + i, n);
        trivial *= a[0];
        double *out = cocycle->segments + (size_t)m * (size_t)((n - 1) * (n - 1));
        for (int k = 1; k < n; k++)
            for (int i = 1; i < n; i++)
                *out++ = a[k * n + i];
    }
    return trivial;
}

/* A single multiplier that is not resolved follows from the others and the sum rule, with its sign. */
static void complete(const saltus_cocycle *cocycle, saltus_multiplier *out, int count) {
    double rest = cocycle->sum_rule;
    int lost = 0, lone = 0;
    bool negative = cocycle->mirrored;
    for (int k = 0; k < count; k++) {
        const bool known = !isnan(out[k].log_modulus);
        lost += !known;
        lone = known ? lone : k;
        rest -= known ? out[k].log_modulus : 0;
        negative ^= known && out[k].im == 0 && out[k].re < 0;
    }
    if (lost != 1 || !isfinite(rest))
        return;
    out[lone] = (saltus_multiplier){negative ? -exp(rest) : exp(rest), 0, rest};
    qsort(out, (size_t)count, sizeof *out, by_modulus);
}

/* Where the flow contracts so much that errors hide multipliers of an orbit of unknown period: shorter
 * segments are wanted. */
static void mark_hidden(saltus_cocycle *cocycle, saltus_multiplier *out, int count, double *log_volume) {
    const double over_segment = 10; /* contraction that leaves the smallest multiplier its digits */
    const double many = 5000;       /* segments */
    const double hidden = -18; /* logarithm of the growth over a segment, below which its errors hide it */
    /* Only after one lap it is known how much the flow contracts; what an impact without rebound takes, no
     * number of segments spreads. */
    const int n = cocycle->n;
    double wanted = fmin(-cocycle->sum_rule / over_segment, bytes_max / (8.0 * n * n)) / cocycle->periods;
    const bool last = count == 1 && cocycle->zeros == 0 && wanted * cocycle->periods > many;
    if (isfinite(cocycle->sum_rule) && wanted > cocycle->density && !last)
        cocycle->wanted = wanted;
    for (int k = 0; k < count; k++) {
        if (last || (isfinite(out[k].log_modulus) && out[k].log_modulus < hidden * cocycle->count))
            out[k] = (saltus_multiplier){0, 0, NAN};
        if (isnan(out[k].log_modulus))
            *log_volume = NAN;
    }
}

saltus_status saltus_cocycle_solve(saltus_cocycle *cocycle, saltus_multiplier *out, int *count,
                                   double *trivial, double *log_volume, saltus_message *message) {
    *count = cocycle->n - cocycle->autonomous;
    *trivial = cocycle->autonomous ? deflate(cocycle) : 0;
    /* At rest on a stop no direction is left, not even the flow's. */
    const int zeros = cocycle->zeros < *count ? cocycle->zeros : *count;
    saltus_status status = saltus_cocycle_multipliers(cocycle->segments, *count, cocycle->count, zeros, out,
                                                      log_volume, message);
    if (status == SALTUS_OK && cocycle->autonomous)
        mark_hidden(cocycle, out, *count, log_volume);
    if (status == SALTUS_OK && zeros == 0)
        complete(cocycle, out, *count);
    return status;
}

/* Once around the orbit, and once more where the first lap shows that shorter segments are wanted. */
saltus_status saltus_orbit_multipliers(const saltus_system *system, const saltus_orbit_options *options,
                                       saltus_orbit *orbit, saltus_message *message) {
    const int n = orbit->dimension;
    const size_t square = (size_t)n * (size_t)n;
    const double phase = options->free_period ? 0 : options->phase;
    saltus_cocycle cocycle = {.n = n};
    saltus_flow *flow = NULL;
    saltus_status status =
        saltus_cocycle_flow(&cocycle, system, orbit->periods, &options->flow, &flow, message);
    double *product = calloc(square, sizeof *product);
    orbit->monodromy = calloc(square, sizeof *orbit->monodromy);
    orbit->multipliers = calloc((size_t)n, sizeof *orbit->multipliers);
    if (status == SALTUS_OK && !(product && orbit->monodromy && orbit->multipliers))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the multipliers");
    for (int lap = 0; lap < 2 && status == SALTUS_OK && (lap == 0 || cocycle.wanted > cocycle.density);
         lap++) {
        status = saltus_cocycle_open(&cocycle, system, orbit->periods, options->free_period, message);
        if (status == SALTUS_OK)
            status = saltus_flow_start(flow, 0, (saltus_time){0, phase}, orbit->state, message);
        if (status == SALTUS_OK)
            status =
                saltus_cocycle_follow(&cocycle, flow, (saltus_time){orbit->periods, phase}, NULL, message);
        if (status != SALTUS_OK)
            break;
        orbit->sum_rule = cocycle.sum_rule;
        orbit->sticks = cocycle.zeros > 0;
        for (int i = 0; i < n * n; i++)
            orbit->monodromy[i] = i % (n + 1) == 0;
        for (int m = 0; m < cocycle.count; m++) {
            multiply(cocycle.segments + (size_t)m * square, n, NULL, orbit->monodromy, product);
            memcpy(orbit->monodromy, product, square * sizeof *product);
        }
        status = saltus_cocycle_solve(&cocycle, orbit->multipliers, &orbit->multiplier_count, &orbit->trivial,
                                      &orbit->log_volume, message);
    }
    free(product);
    saltus_flow_free(flow);
    saltus_cocycle_close(&cocycle);
    return status;
}

int saltus_multipliers_unstable(const saltus_multiplier *multipliers, int count) {
    const double accuracy = 1e-10; /* accuracy of a logarithm */
    int unstable = 0;
    for (int i = 0; i < count; i++) {
        if (isnan(multipliers[i].re))
            return -1;
        unstable += multipliers[i].log_modulus >= -accuracy;
    }
    return count ? unstable : -1;
}

bool saltus_multipliers_stable(const saltus_multiplier *multipliers, int count) {
    return saltus_multipliers_unstable(multipliers, count) == 0;
}
