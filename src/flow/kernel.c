/* The kernel template. The build compiles this file once per model, instruction set and width, with
 *   SALTUS_MODEL_KERNEL  the model's header with its vector field,
 *   SALTUS_KERNEL_NAME   the name of the table entry defined here,
 *   SALTUS_WIDE          0: one trajectory, modes in packs; 1: one trajectory per pack element.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/kernel.h"

#include <stdbool.h>
#include <string.h>

#include "flow/lanes.h"

/* A work's pointers and sizes in local variables: a store through a pack may alias the work itself, which
 * would then be read anew after each. Sizes become constants where the common case is compiled on its own. */
typedef struct frame {
    unsigned terms;
    int packs;      /* per row */
    int columns;    /* tangent vectors */
    int directions; /* the last of these: parameter columns */
    int dof, extra, contacts, forcing;
    long orders, order_span;
    saltus_pack *q, *v, *ahead;
    lane_t *e, *series, *drive, *force;
    const lane_t *scalar, *table;
    const saltus_pack *rows, *push, *pull;
    const double *coupling[SALTUS_COUPLINGS_MAX];
    bool tilts;
    int vary_orders;
    lane_t *vary_drive, *vary_force;
    const lane_t *elapsed, *vary_scalar;
    const saltus_pack *vary_rows, *vary_push, *vary_pull;
} frame;

#define ORDER_STRIDE ((long)(1 + f.columns) * f.packs)
#define JET(a, k, c) ((a) + (long)(k)*ORDER_STRIDE + (long)(c)*f.packs)
#define EXTRA(k, c) (f.e + ((long)(k) * (1 + f.columns) + (c)) * f.extra)
#define SERIES(n, k, c) (f.series + ((n)*f.orders + (k)) * (1 + f.columns) + (c))
#define DRIVE(n, k) (f.drive + (n)*f.order_span + (k))
#define DRIVE_PACK(n, k) ((saltus_pack *)(void *)DRIVE(n, k))
#define TABLE(n, k) ((const saltus_pack *)(const void *)(f.table + (n)*f.order_span + (k)))
#define AHEAD(n, c) JET(f.ahead, n, c)
#define SCALAR(n) (f.scalar + (n))
#define ROW(n) (f.rows + (n)*f.packs)
#define VARY_SCALAR(d, n) (f.vary_scalar + (d)*SALTUS_SCALARS_MAX + (n))
#define VARY_ROW(d, n) (f.vary_rows + ((d)*SALTUS_ROWS_MAX + (n)) * f.packs)
#define VARY_DRIVE(d, n, k) (f.vary_drive + ((d)*model_vary_drives + (n)) * f.order_span + (k))

enum { all_terms = SALTUS_TERM_FORCED | SALTUS_TERM_CUBIC | SALTUS_TERM_COUPLED };

#include SALTUS_MODEL_KERNEL

static void reserve_variations(saltus_work *w) {
    saltus_arena *a = &w->arena;
    size_t row = (size_t)w->row, directions = (size_t)w->directions, contacts = (size_t)w->contacts;
    w->elapsed = saltus_arena_doubles(a, LANES);
    w->vary_scalar = saltus_arena_doubles(a, directions * SALTUS_SCALARS_MAX * LANES);
    w->vary_rows = saltus_arena_doubles(a, directions * SALTUS_ROWS_MAX * row);
    w->vary_drive = saltus_arena_doubles(a, directions * model_vary_drives * (size_t)w->order_span * LANES);
    w->vary_push = saltus_arena_doubles(a, directions * contacts * row);
    w->vary_pull = saltus_arena_doubles(a, directions * contacts * row);
    w->vary_force = saltus_arena_doubles(a, directions * contacts * LANES);
}

static void reserve(saltus_work *w) {
    saltus_arena *a = &w->arena;
    w->lanes = LANES;
    w->row = SALTUS_WIDE ? w->dof * LANES : row_packs(w->dof) * SALTUS_PACK;
    w->extra_row = w->extra * LANES;
    w->stride = LANES;
    w->order_span = (w->order + 2 + SALTUS_PACK - 1) / SALTUS_PACK * SALTUS_PACK;
    size_t span = (size_t)w->order_span, orders = (size_t)w->order + 2, all = (size_t)w->columns + 1,
           row = (size_t)w->row;
    size_t extra = (size_t)w->extra_row, stops = (size_t)w->stops, contacts = (size_t)w->contacts;
    w->q = saltus_arena_doubles(a, orders * all * row);
    w->v = saltus_arena_doubles(a, orders * all * row);
    w->e = saltus_arena_doubles(a, orders * all * extra);
    w->xq = saltus_arena_doubles(a, all * row);
    w->xv = saltus_arena_doubles(a, all * row);
    w->xe = saltus_arena_doubles(a, all * extra);
    w->phase = saltus_arena_doubles(a, LANES);
    w->limit = saltus_arena_doubles(a, LANES);
    w->omega_unit = saltus_arena_doubles(a, LANES);
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
        w->coupling[m] = saltus_arena_doubles(a, coupling_size(w->dof));
    w->table = saltus_arena_doubles(a, model_tables * span * LANES);
    w->ahead = saltus_arena_doubles(a, model_rows_ahead * all * row);
    w->drive_size = model_drives * span * LANES;
    w->drive = saltus_arena_doubles(a, w->drive_size);
    w->series = saltus_arena_doubles(a, model_series * orders * all * LANES);
    reserve_variations(w);
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
            for (int j = 1 - i % 2; j < n; j += 2)
                w->coupling[m][coupling_place(n, i, j)] = c->coupling[m][i * n + j];
    for (int s = 0; s < w->stops; s++)
        load_row(w, w->normal + (size_t)s * (size_t)w->row, lane, system->stop_normal[s]);
    w->terms |= c->terms;
    if (c->forcing_orders > w->forcing_orders)
        w->forcing_orders = c->forcing_orders;
    w->limit[lane] = 6.0 / system->rate;
    w->omega_unit[lane] = system->scale[n] / system->scale[0];
    model_load(w, lane, system);
}

static void vary(saltus_work *w, int lane, int direction, const saltus_variation *variation) {
    const saltus_coefficients *c = &variation->coefficients;
    for (int s = 0; s < SALTUS_SCALARS_MAX; s++)
        w->vary_scalar[(direction * SALTUS_SCALARS_MAX + s) * LANES + lane] = c->scalar[s];
    for (int r = 0; r < c->rows; r++)
        load_row(w, w->vary_rows + (size_t)(direction * SALTUS_ROWS_MAX + r) * (size_t)w->row, lane,
                 c->row[r]);
    w->terms |= c->terms;
    w->tilts |= variation->tilts;
    w->vary_orders = w->forcing_orders + 1;
}

/* sin and cos of 2 pi phase: reduction to an eighth of a turn is exact, then Taylor polynomials. */
KERNEL_INLINE void turn(double phase, double *sine, double *cosine) {
    static const double s[] = {-1.0 / 6,
                               1.0 / 120,
                               -1.0 / 5040,
                               1.0 / 362880,
                               -1.0 / 39916800.0,
                               1.0 / 6227020800.0,
                               -1.0 / 1307674368000.0,
                               1.0 / 355687428096000.0};
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

KERNEL_INLINE void forcing(frame f, const double *phase, int order) {
    lane_t sine, cosine;
    for (int l = 0; l < LANES; l++)
        turn(phase[l], (double *)&sine + l, (double *)&cosine + l);
    model_forcing(f, order, sine, cosine);
    for (int d = 0; d < f.directions; d++)
        model_vary_forcing(f, d, order, sine, cosine);
}

/* Contacts that hold: q'' = f - b (pull . f), the force's series kept for the release. `velocity` is the
 * coefficient k + 1 of q', that is q'' / (k + 1). */
KERNEL_INLINE void hold_contacts(frame f, int k, int c, saltus_pack *velocity) {
    saltus_pack force[SALTUS_FACES_MAX];
    for (int m = 0; m < f.contacts; m++) {
        force[m] = row_dot(f.pull + m * f.packs, velocity, f.dof, f.packs);
        if (c == 0)
            f.force[m * f.orders + k] = lane_of(force[m] * (k + 1.0));
    }
    for (int m = 0; m < f.contacts; m++)
        for (int p = 0; p < f.packs; p++)
            velocity[p] = saltus_pack_fnma(f.push[m * f.packs + p], force[m], velocity[p]);
}

/* The projection that contacts apply changes with their places and the masses: what that does to a parameter
 * column follows from the trajectory's acceleration before the projection, kept when c = 0. */
KERNEL_INLINE void keep_forces(frame f, const saltus_pack *velocity) {
    for (int m = 0; m < f.directions * f.contacts; m++)
        f.vary_force[m] = lane_of(row_dot(f.vary_pull + m * f.packs, velocity, f.dof, f.packs));
}

KERNEL_INLINE void tilt_contacts(frame f, int k, int direction, double inverse, saltus_pack *velocity) {
    for (int m = 0; m < f.contacts; m++) {
        const int place = direction * f.contacts + m;
        const saltus_pack force = lane_spread(f.force[m * f.orders + k]) * inverse,
                          change = lane_spread(f.vary_force[place]);
        for (int p = 0; p < f.packs; p++) {
            saltus_pack sum = saltus_pack_fnma(f.vary_push[place * f.packs + p], force, velocity[p]);
            velocity[p] = saltus_pack_fnma(f.push[m * f.packs + p], change, sum);
        }
    }
}

/* v_k -> q_{k+1}, v_{k+1}. */
KERNEL_INLINE void expand_order(frame f, int k, int c, saltus_pack *velocity) {
    const double inverse = 1.0 / (k + 1);
    saltus_pack next[ROW_PACKS_MAX];
    for (int p = 0; p < f.packs; p++)
        JET(f.q, k + 1, c)[p] = velocity[p] * inverse;
    const int direction = f.directions - 1 - (f.columns - c);
    model_order(f, k, c, inverse, velocity, next);
    if (f.directions && direction >= 0)
        model_source(f, k, c, direction, inverse, next);
    if (f.tilts && f.contacts && c == 0)
        keep_forces(f, next);
    if (f.contacts)
        hold_contacts(f, k, c, next);
    if (f.tilts && f.contacts && direction >= 0)
        tilt_contacts(f, k, direction, inverse, next);
    for (int p = 0; p < f.packs; p++)
        JET(f.v, k + 1, c)[p] = velocity[p] = next[p];
}

KERNEL_INLINE void gap_series(frame f, const saltus_work *w, int order) {
    for (int stop = 0; stop < w->stops; stop++) {
        const saltus_pack *normal = (const saltus_pack *)(const void *)w->normal + stop * f.packs;
        lane_t *gap = (lane_t *)(void *)w->gap + stop * f.orders;
        for (int k = 0; k <= order; k++)
            gap[k] = lane_of(row_dot(normal, JET(f.q, k, 0), f.dof, f.packs));
    }
}

KERNEL_INLINE frame make_frame(const saltus_work *w, unsigned terms, int packs, int columns, int directions,
                               int contacts) {
    return (frame){.terms = terms,
                   .packs = packs,
                   .columns = columns,
                   .directions = directions,
                   .dof = w->dof,
                   .extra = terms & SALTUS_TERM_EXTRA ? w->extra : 0,
                   .contacts = contacts,
                   .forcing = terms & SALTUS_TERM_FORCED ? w->forcing_orders : 0,
                   .orders = w->order + 2,
                   .order_span = w->order_span,
                   .q = (saltus_pack *)(void *)w->q,
                   .v = (saltus_pack *)(void *)w->v,
                   .ahead = (saltus_pack *)(void *)w->ahead,
                   .e = (lane_t *)(void *)w->e,
                   .series = (lane_t *)(void *)w->series,
                   .drive = (lane_t *)(void *)w->drive,
                   .force = (lane_t *)(void *)w->force,
                   .scalar = (const lane_t *)(const void *)w->scalar,
                   .table = (const lane_t *)(const void *)w->table,
                   .rows = (const saltus_pack *)(const void *)w->rows,
                   .push = (const saltus_pack *)(const void *)w->push,
                   .pull = (const saltus_pack *)(const void *)w->pull,
                   .coupling = {w->coupling[0], w->coupling[1]},
                   .tilts = directions > 0 && w->tilts,
                   .vary_orders = w->vary_orders,
                   .vary_drive = (lane_t *)(void *)w->vary_drive,
                   .vary_force = (lane_t *)(void *)w->vary_force,
                   .elapsed = (const lane_t *)(const void *)w->elapsed,
                   .vary_scalar = (const lane_t *)(const void *)w->vary_scalar,
                   .vary_rows = (const saltus_pack *)(const void *)w->vary_rows,
                   .vary_push = (const saltus_pack *)(const void *)w->vary_push,
                   .vary_pull = (const saltus_pack *)(const void *)w->vary_pull};
}

KERNEL_INLINE void expand_frame(frame f, const saltus_work *w, int order) {
    saltus_pack velocity[ROW_PACKS_MAX];
    forcing(f, w->phase, order);
    for (int p = 0; p < f.packs; p++)
        velocity[p] = f.v[p];
    for (int k = 0; k < order; k++)
        for (int c = 0; c <= f.columns; c++) {
            for (int p = 0; p < f.packs && f.columns > 0; p++)
                velocity[p] = JET(f.v, k, c)[p];
            expand_order(f, k, c, velocity);
        }
    gap_series(f, w, order);
}

/* The scene's terms and shape are settled here, once per step; the common cases have loops of their own. */
static void expand_directed(saltus_work *w, int order) {
    int packs = row_packs(w->dof);
    if (w->terms == all_terms && packs == 1)
        expand_frame(make_frame(w, all_terms, 1, w->columns, w->directions, w->contacts), w, order);
    else
        expand_frame(make_frame(w, w->terms, packs, w->columns, w->directions, w->contacts), w, order);
}

static void expand_plain(saltus_work *w, int order) {
    int packs = row_packs(w->dof);
    if (w->terms == all_terms && packs == 1 && w->columns == 0 && w->contacts == 0)
        expand_frame(make_frame(w, all_terms, 1, 0, 0, 0), w, order);
    else if (w->terms == all_terms && packs == 1)
        expand_frame(make_frame(w, all_terms, 1, w->columns, 0, w->contacts), w, order);
    else if (w->terms == all_terms && w->columns == 0)
        expand_frame(make_frame(w, all_terms, packs, 0, 0, w->contacts), w, order);
    else
        expand_frame(make_frame(w, w->terms, packs, w->columns, 0, w->contacts), w, order);
}

static void expand(saltus_work *w, int order) {
    size_t bytes = (size_t)(1 + w->columns) * (size_t)w->row * sizeof(double);
    memcpy(w->q, w->xq, bytes);
    memcpy(w->v, w->xv, bytes);
    memcpy(w->e, w->xe, (size_t)(1 + w->columns) * (size_t)w->extra_row * sizeof(double));
    if (w->directions)
        expand_directed(w, order);
    else
        expand_plain(w, order);
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

/* Norm of a column at one order: max of |q_k|, |v_k| / omega_unit, |e_k|. */
KERNEL_INLINE lane_t column_norm(const saltus_work *w, int k, int c) {
    const saltus_pack *q = (const saltus_pack *)(const void *)(w->q + saltus_work_jet(w, k, c));
    const saltus_pack *v = (const saltus_pack *)(const void *)(w->v + saltus_work_jet(w, k, c));
    const lane_t *e = (const lane_t *)(const void *)(w->e + saltus_work_extra_jet(w, k, c));
    const int packs = row_packs(w->dof);
    saltus_pack displacement = {0}, velocity = {0};
    for (int p = 0; p < packs; p++) {
        displacement = saltus_pack_max_size(displacement, q[p]);
        velocity = saltus_pack_max_size(velocity, v[p]);
    }
    for (int i = 0; i < w->extra; i++)
        displacement = saltus_pack_max_size(displacement, lane_spread(e[i]));
    const lane_t slowness = 1.0 / *(const lane_t *)(const void *)w->omega_unit;
    return lane_largest(saltus_pack_max_size(displacement, velocity * lane_spread(slowness)));
}

/* The step at which the coefficient of order k falls below the tolerance. */
KERNEL_INLINE double coefficient_step(double norm, double tolerance, int k, double limit) {
    bool tells = norm > tolerance * 1e-200 && tolerance > 1e-280;
    return tells ? 0.97 * approximate_root(tolerance / norm, k) : limit;
}

/* The step at which the last two coefficients of every column fall below the tolerance (Jorba & Zou, section
 * 3). A parameter column starts at zero; its size is what its rate makes of it. */
static void measure(saltus_work *w) {
    const int last = w->order, steady = w->columns - w->directions;
    for (int l = 0; l < LANES; l++)
        w->step[l] = w->limit[l];
    for (int c = 0; c <= w->columns; c++) {
        const lane_t size = column_norm(w, 0, c), before = column_norm(w, last - 1, c),
                     end = column_norm(w, last, c), rate = c > steady ? column_norm(w, 1, c) : size;
        for (int l = 0; l < LANES; l++) {
            double start = lane_get(&size, l) + (c > steady ? w->limit[l] * lane_get(&rate, l) : 0);
            double tolerance = c ? w->tolerance_tangent * start
                                 : w->tolerance_absolute + w->tolerance_relative * lane_get(&size, l);
            double step = coefficient_step(lane_get(&before, l), tolerance, last - 1, w->limit[l]);
            double other = coefficient_step(lane_get(&end, l), tolerance, last, w->limit[l]);
            step = other < step ? other : step;
            w->step[l] = step < w->step[l] ? step : w->step[l];
        }
    }
}

/* Even and odd coefficients in two chains: half the latency of Horner's rule. */
KERNEL_INLINE saltus_pack polynomial(const saltus_pack *newest, size_t order_packs, int order,
                                     saltus_pack time) {
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
    for (int c = 0; c <= w->columns; c++)
        for (int p = 0; p < packs; p++) {
            size_t place = (size_t)c * (size_t)packs + (size_t)p;
            const size_t top = (size_t)order * order_packs + place;
            ((saltus_pack *)(void *)w->xq)[place] =
                polynomial((saltus_pack *)(void *)w->q + top, order_packs, order, spread);
            ((saltus_pack *)(void *)w->xv)[place] =
                polynomial((saltus_pack *)(void *)w->v + top, order_packs, order, spread);
        }
    const int extras = (1 + w->columns) * w->extra;
    for (int i = 0; i < extras; i++) {
        lane_t sum = lane_constant(0);
        for (int k = order; k >= 0; k--)
            sum = lane_fma(sum, time, ((const lane_t *)(const void *)w->e)[k * extras + i]);
        ((lane_t *)(void *)w->xe)[i] = sum;
    }
}

extern const saltus_kernel SALTUS_KERNEL_NAME;
const saltus_kernel SALTUS_KERNEL_NAME = {
    .model = MODEL_NAME,
    .lanes = LANES,
    .pack = SALTUS_PACK,
    .reserve = reserve,
    .load = load,
    .vary = vary,
    .expand = expand,
    .measure = measure,
    .evaluate = evaluate,
};
