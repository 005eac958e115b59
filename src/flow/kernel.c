/* The kernel template. The build compiles this file once per model, instruction set and width, with
 *   SALTUS_MODEL_KERNEL  the model's header with its vector field,
 *   SALTUS_KERNEL_NAME   the name of the table entry defined here,
 *   SALTUS_WIDE          0: one trajectory, modes in packs; 1: one trajectory per pack element.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/kernel.h"

#include <stdbool.h>
#include <string.h>

#include "flow/lanes.h"

/* What the inner loops need to know of the layout; constants where the common case is compiled on its own. */
typedef struct shape {
    int packs;   /* per row */
    int columns; /* tangent vectors */
} shape;

#define SCALAR(n) ((const lane_t *)(const void *)(w->scalar + (size_t)(n)*LANES))
#define TABLE(t, k) ((const lane_t *)(const void *)(w->table + ((size_t)(t) * (size_t)(w->order + 2) + (size_t)(k)) * LANES))
#define ROWS(r) ((const saltus_pack *)(const void *)(w->rows + (size_t)(r) * (size_t)w->row))
#define ORDER_STRIDE(s) ((long)(1 + (s).columns) * (s).packs)
#define SERIES_STRIDE(s) ((long)(1 + (s).columns))
#define JET(a, k, c) ((saltus_pack *)(void *)(a) + ((long)(k) * ORDER_STRIDE(s) + (long)(c) * s.packs))
#define EXTRA(k, c) ((lane_t *)(void *)w->e + ((long)(k) * SERIES_STRIDE(s) + (c)) * w->extra)
#define PRODUCT(r, k, c) (JET(w->product, k, c) + (long)(r) * (w->order + 2) * ORDER_STRIDE(s))
#define SERIES(n, k, c)                                                                                                \
    ((lane_t *)(void *)w->series + ((long)(n) * (w->order + 2) + (long)(k)) * SERIES_STRIDE(s) + (c))

#include SALTUS_MODEL_KERNEL

static void reserve(saltus_work *w) {
    saltus_arena *a = &w->arena;
    w->lanes = LANES;
    w->row = SALTUS_WIDE ? w->dof * LANES : row_packs(w->dof) * SALTUS_PACK;
    w->extra_row = w->extra * LANES;
    w->stride = LANES;
    size_t orders = (size_t)w->order + 2, all = (size_t)w->columns + 1, row = (size_t)w->row;
    size_t extra = (size_t)w->extra_row, stops = (size_t)w->stops, contacts = (size_t)w->contacts;
    w->q = saltus_arena_doubles(a, orders * all * row);
    w->v = saltus_arena_doubles(a, orders * all * row);
    w->e = saltus_arena_doubles(a, orders * all * extra);
    w->xq = saltus_arena_doubles(a, all * row);
    w->xv = saltus_arena_doubles(a, all * row);
    w->xe = saltus_arena_doubles(a, all * extra);
    w->phase = saltus_arena_doubles(a, LANES);
    w->limit = saltus_arena_doubles(a, LANES);
    w->step = saltus_arena_doubles(a, LANES);
    w->advance = saltus_arena_doubles(a, LANES);
    w->normal = saltus_arena_doubles(a, stops * row);
    w->gap = saltus_arena_doubles(a, stops * orders * LANES);
    w->push = saltus_arena_doubles(a, contacts * row);
    w->pull = saltus_arena_doubles(a, contacts * row);
    w->force = saltus_arena_doubles(a, contacts * orders * LANES);
    w->scalar = saltus_arena_doubles(a, SALTUS_SCALARS_MAX * LANES);
    w->rows = saltus_arena_doubles(a, SALTUS_ROWS_MAX * row);
    for (int m = 0; m < SALTUS_COUPLINGS_MAX; m++)
        w->coupling[m] = saltus_arena_doubles(a, (size_t)w->dof * (SALTUS_WIDE ? (size_t)w->dof : row));
    w->table = saltus_arena_doubles(a, model_tables * orders * LANES);
    w->series = saltus_arena_doubles(a, model_series * orders * all * LANES);
    w->product = saltus_arena_doubles(a, model_products * orders * all * row);
    w->scratch = saltus_arena_doubles(a, row);
}

/* A system's row of numbers into one lane of a row. */
static void load_row(const saltus_work *w, double *row, int lane, const double *values) {
    for (int i = 0; i < w->dof; i++)
        row[i * w->stride + lane] = values[i];
}

static void load(saltus_work *w, int lane, const saltus_system *system) {
    const saltus_coefficients *c = &system->coefficients;
    int n = w->dof;
    for (int s = 0; s < SALTUS_SCALARS_MAX; s++)
        w->scalar[s * LANES + lane] = c->scalar[s];
    for (int r = 0; r < c->rows; r++)
        load_row(w, w->rows + (size_t)r * (size_t)w->row, lane, c->row[r]);
    for (int m = 0; m < c->couplings; m++)
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++)
                w->coupling[m][SALTUS_WIDE ? i * n + j : j * w->row + i] = c->coupling[m][i * n + j];
    for (int s = 0; s < w->stops; s++)
        load_row(w, w->normal + (size_t)s * (size_t)w->row, lane, system->stop_normal[s]);
    w->terms |= c->terms;
    if (c->forcing_orders > w->forcing_orders)
        w->forcing_orders = c->forcing_orders;
    w->limit[lane] = 6.0 / system->rate;
    model_load(w, lane, system);
}

/* sin and cos of 2 pi phase: reduction to an eighth of a turn is exact, then Taylor polynomials. */
KERNEL_INLINE void turn(double phase, double *sine, double *cosine) {
    static const double s[] = {-1.0 / 6,          1.0 / 120,           -1.0 / 5040,           1.0 / 362880,
                               -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368000.0, 1.0 / 355687428096000.0};
    static const double c[] = {-0.5,
                               1.0 / 24,
                               -1.0 / 720,
                               1.0 / 40320,
                               -1.0 / 3628800.0,
                               1.0 / 479001600.0,
                               -1.0 / 87178291200.0,
                               1.0 / 20922789888000.0};
    int quarter = (int)(4 * phase + 0.5);
    double angle = (4 * phase - quarter) * 1.57079632679489661923, square = angle * angle;
    double a = s[7], b = c[7];
    for (int k = 6; k >= 0; k--) {
        a = saltus_scalar_fma(a, square, s[k]);
        b = saltus_scalar_fma(b, square, c[k]);
    }
    a = saltus_scalar_fma(a * square, angle, angle);
    b = saltus_scalar_fma(b, square, 1.0);
    int swap = quarter & 1;
    double first = swap ? b : a, second = swap ? a : b;
    *sine = quarter & 2 ? -first : first;
    *cosine = (quarter + 1) & 2 ? -second : second;
}

KERNEL_INLINE void forcing(saltus_work *w, shape s, int order) {
    lane_t sine, cosine;
    for (int l = 0; l < LANES; l++)
        turn(w->phase[l], (double *)&sine + l, (double *)&cosine + l);
    model_forcing(w, s, order, order < w->forcing_orders ? order : w->forcing_orders, sine, cosine);
}

/* Contacts that hold: q'' = f - b (pull . f), the force's series kept for the release. */
KERNEL_INLINE void hold_contacts(saltus_work *w, shape s, int k, int c) {
    saltus_pack *acceleration = JET(w->v, k + 1, c);
    lane_t force[SALTUS_FACES_MAX];
    for (int m = 0; m < w->contacts; m++) {
        const saltus_pack *pull = (const saltus_pack *)(const void *)(w->pull + (size_t)m * (size_t)w->row);
        lane_t sum = lane_constant(0);
        for (int i = 0; i < w->dof; i++)
            sum = lane_fma(row_element(pull, i), row_element(acceleration, i), sum);
        force[m] = sum;
        if (c == 0)
            *(lane_t *)(void *)(w->force + ((size_t)m * (size_t)(w->order + 2) + (size_t)k) * LANES) = sum;
    }
    for (int m = 0; m < w->contacts; m++) {
        const saltus_pack *push = (const saltus_pack *)(const void *)(w->push + (size_t)m * (size_t)w->row);
        for (int p = 0; p < s.packs; p++)
            acceleration[p] = saltus_pack_fnma(push[p], lane_spread(force[m]), acceleration[p]);
    }
}

KERNEL_INLINE void expand_order(saltus_work *w, shape s, unsigned terms, int k, int c) {
    const double inverse = 1.0 / (k + 1);
    const saltus_pack *v = JET(w->v, k, c);
    saltus_pack *q = JET(w->q, k + 1, c), *next = JET(w->v, k + 1, c);
    for (int p = 0; p < s.packs; p++)
        q[p] = v[p] * inverse;
    model_order(w, s, terms, k, c);
    if (w->contacts)
        hold_contacts(w, s, k, c);
    for (int p = 0; p < s.packs; p++)
        next[p] *= inverse;
    for (int i = 0; i < w->extra; i++)
        EXTRA(k + 1, c)[i] *= inverse;
}

KERNEL_INLINE void gap_series(saltus_work *w, shape s, int order) {
    for (int stop = 0; stop < w->stops; stop++) {
        const saltus_pack *normal = (const saltus_pack *)(const void *)(w->normal + (size_t)stop * (size_t)w->row);
        lane_t *gap = (lane_t *)(void *)(w->gap + (size_t)stop * (size_t)(w->order + 2) * LANES);
        for (int k = 0; k <= order; k++) {
            lane_t sum = lane_constant(0);
            for (int i = 0; i < w->dof; i++)
                sum = lane_fma(row_element(normal, i), row_element(JET(w->q, k, 0), i), sum);
            gap[k] = sum;
        }
    }
}

KERNEL_INLINE void expand_shape(saltus_work *w, shape s, unsigned terms, int order) {
    forcing(w, s, order);
    for (int k = 0; k < order; k++)
        for (int c = 0; c <= s.columns; c++)
            expand_order(w, s, terms, k, c);
    gap_series(w, s, order);
}

/* The scene's terms and shape are settled here, once per step; the common cases have loops of their own. */
static void expand(saltus_work *w, int order) {
    enum { all = SALTUS_TERM_FORCED | SALTUS_TERM_CUBIC | SALTUS_TERM_COUPLED };
    size_t bytes = (size_t)(1 + w->columns) * (size_t)w->row * sizeof(double);
    memcpy(w->q, w->xq, bytes);
    memcpy(w->v, w->xv, bytes);
    memcpy(w->e, w->xe, (size_t)(1 + w->columns) * (size_t)w->extra_row * sizeof(double));
    int packs = row_packs(w->dof);
    if (w->terms == all && packs == 1 && w->columns == 0)
        expand_shape(w, (shape){1, 0}, all, order);
    else if (w->terms == all && packs == 1)
        expand_shape(w, (shape){1, w->columns}, all, order);
    else if (w->terms == all && w->columns == 0)
        expand_shape(w, (shape){packs, 0}, all, order);
    else
        expand_shape(w, (shape){packs, w->columns}, w->terms, order);
}

/* Largest modulus in a row, per lane. */
KERNEL_INLINE void row_norm(const saltus_work *w, const double *row, double *norm) {
    for (int i = 0; i < w->dof; i++)
        for (int l = 0; l < LANES; l++) {
            double size = __builtin_fabs(row[i * w->stride + l]);
            norm[l] = size > norm[l] ? size : norm[l];
        }
}

/* x^(1/k) to about one percent, from the exponent and a parabola; x > 0. A step size needs no more. */
KERNEL_INLINE double approximate_root(double x, int k) {
    union {
        double value;
        unsigned long long bits;
    } split = {x};
    int exponent = (int)(split.bits >> 52) - 1023;
    split.bits = (split.bits & 0xfffffffffffffULL) | 0x3ff0000000000000ULL;
    double m = split.value, power = (exponent + (2 - m / 3) * m - 5.0 / 3) / k;
    int whole = (int)power - (power < 0);
    double fraction = power - whole;
    split.bits = (unsigned long long)(whole + 1023) << 52;
    return split.value * (1 + fraction * (0.6565 + 0.3435 * fraction));
}

/* Norms of a column at one order: max |q_k|, |v_k| / omega_unit, |e_k|, per lane. */
KERNEL_INLINE void column_norm(const saltus_work *w, int k, int c, double *norm) {
    double velocity[LANES] = {0};
    row_norm(w, w->q + saltus_work_jet(w, k, c), norm);
    row_norm(w, w->v + saltus_work_jet(w, k, c), velocity);
    for (int l = 0; l < LANES; l++) {
        double scaled = velocity[l] / w->omega_unit;
        norm[l] = scaled > norm[l] ? scaled : norm[l];
        for (int i = 0; i < w->extra; i++) {
            double size = __builtin_fabs(w->e[saltus_work_extra_jet(w, k, c) + (size_t)(i * LANES + l)]);
            norm[l] = size > norm[l] ? size : norm[l];
        }
    }
}

/* The step at which the last two coefficients of every column fall below the tolerance (Jorba & Zou, section 3). */
static void measure(saltus_work *w) {
    for (int l = 0; l < LANES; l++)
        w->step[l] = w->limit[l];
    for (int c = 0; c <= w->columns; c++) {
        double size[LANES] = {0};
        column_norm(w, 0, c, size);
        for (int k = w->order - 1; k <= w->order; k++) {
            double norm[LANES] = {0};
            column_norm(w, k, c, norm);
            for (int l = 0; l < LANES; l++) {
                double tolerance = c ? w->tolerance_tangent * size[l]
                                     : w->tolerance_absolute + w->tolerance_relative * size[l];
                double step = norm[l] > tolerance * 1e-200 && tolerance > 1e-280
                                  ? 0.97 * approximate_root(tolerance / norm[l], k)
                                  : w->limit[l];
                w->step[l] = step < w->step[l] ? step : w->step[l];
            }
        }
    }
}

/* Even and odd coefficients in two chains: half the latency of Horner's rule. */
KERNEL_INLINE saltus_pack polynomial(const saltus_pack *newest, size_t order_packs, int order, saltus_pack time) {
    saltus_pack square = time * time, even = {0}, odd = {0};
    const saltus_pack *coefficient = newest;
    for (int k = order; k >= 0; k--, coefficient -= order_packs)
        if (k % 2)
            odd = saltus_pack_fma(odd, square, *coefficient);
        else
            even = saltus_pack_fma(even, square, *coefficient);
    return saltus_pack_fma(odd, time, even);
}

static void evaluate(saltus_work *w, int order) {
    const lane_t time = *(const lane_t *)(const void *)w->advance;
    const saltus_pack spread = lane_spread(time);
    const size_t order_packs = saltus_work_jet(w, 1, 0) / SALTUS_PACK;
    const int packs = row_packs(w->dof);
    const shape s = {packs, w->columns};
    for (int c = 0; c <= w->columns; c++)
        for (int p = 0; p < packs; p++) {
            size_t place = (size_t)c * (size_t)packs + (size_t)p;
            ((saltus_pack *)(void *)w->xq)[place] = polynomial(&JET(w->q, order, c)[p], order_packs, order, spread);
            ((saltus_pack *)(void *)w->xv)[place] = polynomial(&JET(w->v, order, c)[p], order_packs, order, spread);
        }
    for (int c = 0; c <= w->columns; c++)
        for (int i = 0; i < w->extra; i++) {
            lane_t sum = lane_constant(0);
            for (int k = order; k >= 0; k--)
                sum = lane_fma(sum, time, EXTRA(k, c)[i]);
            ((lane_t *)(void *)w->xe)[c * w->extra + i] = sum;
        }
}

extern const saltus_kernel SALTUS_KERNEL_NAME;
const saltus_kernel SALTUS_KERNEL_NAME = {
    .model = MODEL_NAME,
    .lanes = LANES,
    .pack = SALTUS_PACK,
    .reserve = reserve,
    .load = load,
    .expand = expand,
    .measure = measure,
    .evaluate = evaluate,
};
