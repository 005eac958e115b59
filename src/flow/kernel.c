/* The kernel template. The build compiles this file once per model, instruction set and width, with
 *   SALTUS_MODEL_KERNEL  the model's header with its vector field,
 *   SALTUS_KERNEL_NAME   the name of the table entry defined here,
 *   SALTUS_WIDE          0: one trajectory, modes in packs; 1: one trajectory per pack element.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/kernel.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "flow/lanes.h"

/* A work's pointers and sizes in local variables: a store through a pack may alias the work itself, which
 * would then be read anew after each. Sizes become constants where the common case is compiled on its own. */
typedef struct frame {
    unsigned terms;
    int packs;      /* per row */
    int block;      /* of these, worked on side by side */
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
#define SERIES(n, k, c) (f.series + ((n) * (1 + f.columns) + (c)) * f.orders + (k))
#define DRIVE(n, k) (f.drive + (n)*f.order_span + (k))
#define DRIVE_PACK(n, k) ((saltus_pack *)(void *)DRIVE(n, k))
#define TABLE(n, k) ((const saltus_pack *)(const void *)(f.table + (n)*f.order_span + (k)))
#define AHEAD(n, c) JET(f.ahead, n, c)
#define SCALAR(n) (f.scalar + (n))
#define ROW(n) (f.rows + (n)*f.packs)
#define VARY_SCALAR(d, n) (f.vary_scalar + (d)*SALTUS_SCALARS_MAX + (n))
#define VARY_ROW(d, n) (f.vary_rows + ((d)*SALTUS_ROWS_MAX + (n)) * f.packs)
#define VARY_DRIVE(d, n, k) (f.vary_drive + ((d)*model_vary_drives + (n)) * f.order_span + (k))

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
    w->left = saltus_arena_doubles(a, LANES);
    w->advance = saltus_arena_doubles(a, LANES);
    w->period = saltus_arena_doubles(a, LANES);
    w->passing = saltus_arena_doubles(a, LANES);
    w->clearance = saltus_arena_doubles(a, contacts * LANES);
    w->margin = saltus_arena_doubles(a, contacts * LANES);
    w->near = saltus_arena_doubles(a, LANES);
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

/* Orders of sin(omega t)'s series, and of its square's, that count beside the tolerance at the largest step.
 */
static int count_orders(const saltus_work *w, int lane, const saltus_system *system) {
    const double rtol = w->tolerance_relative, angle = w->limit[lane] * system->omega;
    const double small = fmax(1e-19, rtol * fmin(1e-3, 1e7 * rtol));
    double term = 1, twice = 1;
    int order = 0;
    while (order < system->coefficients.forcing_orders && fmax(term, 0.25 * twice) > small) {
        term *= angle / ++order;
        twice *= 2 * angle / order;
    }
    return order;
}

/* Orders beyond those that still matter must be zero in the drives. */
static void load_orders(saltus_work *w, int lane, const saltus_system *system) {
    int most = 0;
    w->lane_orders[lane] = count_orders(w, lane, system);
    for (int l = 0; l < LANES; l++)
        most = w->lane_orders[l] > most ? w->lane_orders[l] : most;
    if (most < w->forcing_orders)
        memset(w->drive, 0, w->drive_size * sizeof *w->drive);
    w->forcing_orders = most;
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
    w->limit[lane] = 6.0 / system->rate;
    w->period[lane] = system->period;
    load_orders(w, lane, system);
    w->faces = system->face_count;
    for (int f = 0; f < w->faces; f++) {
        w->face_stop[f] = system->faces[f].stop;
        w->face_side[f] = system->faces[f].side;
        w->clearance[f * LANES + lane] = system->faces[f].d;
    }
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

/* A number whose sum with a small one holds the small one's nearest whole number in its last bits. */
enum { sign_shift = 63, exponent_shift = 52, exponent_bias = 1023 };
static const double rounder = 6755399441055744.0;

/* Eight coefficients by Estrin's scheme: three products deep. */
KERNEL_INLINE lane_t polynomial8(const double *c, lane_t x) {
    const lane_t x2 = x * x, x4 = x2 * x2;
    lane_t pair[4];
    for (int k = 0; k < 4; k++)
        pair[k] = lane_fma(lane_constant(c[2 * k + 1]), x, lane_constant(c[2 * k]));
    return lane_fma(lane_fma(pair[3], x2, pair[2]), x4, lane_fma(pair[1], x2, pair[0]));
}

/* sin and cos of 2 pi phase: reduction to an eighth of a turn is exact, then Taylor polynomials. */
KERNEL_INLINE void turn(lane_t phase, lane_t *sine, lane_t *cosine) {
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
    const lane_t quarters = 4.0 * phase, rounded = quarters + rounder;
    const lane_word quarter = lane_bits(rounded), swap = -(quarter & 1);
    const lane_t angle = (quarters - (rounded - rounder)) * 1.57079632679489661923, square = angle * angle;
    lane_t a = polynomial8(s, square), b = polynomial8(c, square);
    a = lane_fma(a, square * angle, angle);
    b = lane_fma(b, square, lane_constant(1.0));
    const lane_word change = (lane_bits(a) ^ lane_bits(b)) & swap;
    *sine = lane_value(lane_bits(a) ^ change ^ (quarter >> 1 << sign_shift));
    *cosine = lane_value(lane_bits(b) ^ change ^ ((quarter + 1) >> 1 << sign_shift));
}

KERNEL_INLINE void forcing(frame f, const double *phase, int order) {
    lane_t sine, cosine;
    turn(*(const lane_t *)(const void *)phase, &sine, &cosine);
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

/* v_k and q_{k+1} -> v_{k+1}, q_{k+2}. */
KERNEL_INLINE void expand_order(frame f, int k, int c) {
    const double inverse = 1.0 / (k + 1), later = 1.0 / (k + 2);
    saltus_pack next[ROW_PACKS_MAX];
    const int direction = f.directions - 1 - (f.columns - c);
    model_order(f, k, c, inverse, next);
    if (f.directions && direction >= 0)
        model_source(f, k, c, direction, inverse, next);
    if (f.tilts && f.contacts && c == 0)
        keep_forces(f, next);
    if (f.contacts)
        hold_contacts(f, k, c, next);
    if (f.tilts && f.contacts && direction >= 0)
        tilt_contacts(f, k, direction, inverse, next);
    for (int p = 0; p < f.packs; p++) {
        JET(f.v, k + 1, c)[p] = next[p];
        JET(f.q, k + 2, c)[p] = next[p] * later;
    }
}

KERNEL_INLINE void gap_series(frame f, const saltus_work *w, int order) {
    for (int stop = 0; stop < w->stops; stop++) {
        const saltus_pack *normal = (const saltus_pack *)(const void *)w->normal + stop * f.packs;
        lane_t *gap = (lane_t *)(void *)w->gap + stop * f.orders;
        saltus_pack row[ROW_PACKS_MAX];
        for (int p = 0; p < f.packs; p++)
            row[p] = normal[p];
        for (int k = 0; k <= order; k++)
            gap[k] = lane_of(row_dot(row, JET(f.q, k, 0), f.dof, f.packs));
    }
}

KERNEL_INLINE frame make_frame(const saltus_work *w, unsigned terms, int packs, int block, int columns,
                               int directions, int contacts) {
    return (frame){.terms = terms,
                   .packs = packs,
                   .block = block,
                   .columns = columns,
                   .directions = directions,
                   .dof = SALTUS_WIDE ? packs : w->dof,
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

/* The states become the first coefficients. */
KERNEL_INLINE void begin(frame f, const saltus_work *w) {
    const saltus_pack *q = (const saltus_pack *)(const void *)w->xq,
                      *v = (const saltus_pack *)(const void *)w->xv;
    const lane_t *e = (const lane_t *)(const void *)w->xe;
    for (int i = 0; i < (1 + f.columns) * f.packs; i++) {
        f.q[i] = q[i];
        f.v[i] = JET(f.q, 1, 0)[i] = v[i];
    }
    for (int i = 0; i < (1 + f.columns) * f.extra; i++)
        f.e[i] = e[i];
    for (int c = 0; c <= f.columns; c++)
        model_start(f, c);
}

KERNEL_INLINE void expand_frame(frame f, const saltus_work *w, int order) {
    forcing(f, w->phase, order);
    begin(f, w);
    for (int k = 0; k < order; k++)
        for (int c = 0; c <= f.columns; c++)
            expand_order(f, k, c);
    gap_series(f, w, order);
}

/* The scene's terms and shape are settled here, once per step; the common cases have loops of their own. */
KERNEL_INLINE void expand_rows(const saltus_work *w, int order, int packs, unsigned terms) {
    const int block = row_block(packs);
    if (w->columns == 0 && w->contacts == 0)
        expand_frame(make_frame(w, terms, packs, block, 0, 0, 0), w, order);
    else
        expand_frame(make_frame(w, terms, packs, block, w->columns, 0, w->contacts), w, order);
}

KERNEL_INLINE void expand_directions(const saltus_work *w, int order, int packs) {
    const int block = row_block(packs);
    expand_frame(make_frame(w, w->terms, packs, block, w->columns, w->directions, w->contacts), w, order);
}

static void expand_any(const saltus_work *w, int order) {
    const int packs = row_packs(w->dof);
    if (w->directions)
        expand_frame(make_frame(w, w->terms, packs, 1, w->columns, w->directions, w->contacts), w, order);
    else
        expand_frame(make_frame(w, w->terms, packs, row_block(ROW_PACKS_MAX), w->columns, 0, w->contacts), w,
                     order);
}

#define EXPAND_ROWS(n)                                                                                       \
    static void expand_##n(saltus_work *w, int order) {                                                      \
        if (n <= model_rows_common && !w->directions && w->terms == model_common_terms(n))                   \
            expand_rows(w, order, n, model_common_terms(n));                                                 \
        else if (n <= model_rows_plain && !w->directions)                                                    \
            expand_rows(w, order, n, w->terms);                                                              \
        else if (n <= model_rows_plain)                                                                      \
            expand_directions(w, order, n);                                                                  \
        else                                                                                                 \
            expand_any(w, order);                                                                            \
    }
EXPAND_ROWS(1)
EXPAND_ROWS(2)
EXPAND_ROWS(3)
EXPAND_ROWS(4)
EXPAND_ROWS(5)
EXPAND_ROWS(6)
EXPAND_ROWS(7)
EXPAND_ROWS(8)

static void expand(saltus_work *w, int order) {
    const int packs = row_packs(w->dof);
    switch (packs) {
    case 1:
        expand_1(w, order);
        break;
    case 2:
        expand_2(w, order);
        break;
    case 3:
        expand_3(w, order);
        break;
    case 4:
        expand_4(w, order);
        break;
    case 5:
        expand_5(w, order);
        break;
    case 6:
        expand_6(w, order);
        break;
    case 7:
        expand_7(w, order);
        break;
    case 8:
        expand_8(w, order);
        break;
    default:
        expand_any(w, order);
    }
}

/* x^(1/k) to about one percent, from the exponent and a parabola; x > 0. A step size needs no more. */
KERNEL_INLINE lane_t approximate_root(lane_t x, double inverse) {
    const lane_word mantissa = (1ULL << exponent_shift) - 1 + (lane_bits(lane_constant(0))),
                    one = lane_bits(lane_constant(1.0)), two52 = lane_bits(lane_constant(4503599627370496.0));
    const lane_t m = lane_value((lane_bits(x) & mantissa) | one);
    const lane_t exponent =
        lane_value(lane_bits(x) >> exponent_shift | two52) - (4503599627370496.0 + exponent_bias);
    const lane_t parabola = lane_fma(m, lane_constant(-1.0 / 3), lane_constant(2.0)),
                 power = lane_fma(parabola, m, exponent - 5.0 / 3) * inverse;
    const lane_t rounded = power - 0.5 + rounder, fraction = power - (rounded - rounder);
    const lane_t scale = lane_value((lane_bits(rounded) + exponent_bias) << exponent_shift),
                 rest = lane_fma(fraction, lane_constant(0.3435), lane_constant(0.6565));
    return lane_fma(scale * fraction, rest, scale);
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
KERNEL_INLINE lane_t coefficient_step(lane_t norm, lane_t tolerance, int k, lane_t limit) {
    const lane_t step = 0.97 * approximate_root(tolerance / norm, 1.0 / k);
    const lane_t told = lane_if_less(tolerance * 1e-200, norm, step, limit),
                 sure = lane_if_less(lane_constant(1e-280), tolerance, told, limit);
    return lane_if_less(norm, lane_constant(1e300), sure, lane_constant(0));
}

/* The step at which the last two coefficients of the holding forces fall below the tolerance: where contacts
 * hold all there is to move, nothing else tells how far the series reach. */
KERNEL_INLINE lane_t force_step(const saltus_work *w, lane_t limit) {
    const int last = w->order - 2;
    lane_t step = limit;
    for (int m = 0; m < w->contacts; m++) {
        const lane_t *force = (const lane_t *)(const void *)w->force + m * (w->order + 2);
        const lane_t size = lane_size(force[0]) + limit * (lane_size(force[1]) + limit * lane_size(force[2]));
        const lane_t tolerance = w->tolerance_relative * size;
        step = lane_smaller(step, coefficient_step(lane_size(force[last - 1]), tolerance, last - 1, limit));
        step = lane_smaller(step, coefficient_step(lane_size(force[last]), tolerance, last, limit));
    }
    return step;
}

/* Zero where all of a state is finite, otherwise not a number. */
KERNEL_INLINE lane_t finite_sum(const saltus_work *w) {
    const saltus_pack *q = (const saltus_pack *)(const void *)w->q,
                      *v = (const saltus_pack *)(const void *)w->v;
    const int packs = row_packs(w->dof);
    saltus_pack sum = {0};
    for (int p = 0; p < packs; p++)
        sum += (q[p] - q[p]) + (v[p] - v[p]);
    return lane_total(sum);
}

/* The step at which the last two coefficients of every column fall below the tolerance (Jorba & Zou, section
 * 3). A parameter column starts at zero; its size is what its rate makes of it. So is the size of a state at
 * rest in the origin, but a millionth of it, which no other state is affected by. */
static void measure(saltus_work *w) {
    const int last = w->order, steady = w->columns - w->directions;
    const lane_t limit = *(const lane_t *)(const void *)w->limit;
    lane_t step = limit;
    for (int c = 0; c <= w->columns; c++) {
        const lane_t change = limit * column_norm(w, 1, c);
        lane_t size = column_norm(w, 0, c);
        if (c > steady)
            size += change;
        else
            size = lane_if_less(size, 1e-6 * change, 1e-6 * change, size);
        const lane_t tolerance =
            c ? w->tolerance_tangent * size : w->tolerance_absolute + w->tolerance_relative * size;
        step = lane_smaller(step, coefficient_step(column_norm(w, last - 1, c), tolerance, last - 1, limit));
        step = lane_smaller(step, coefficient_step(column_norm(w, last, c), tolerance, last, limit));
    }
    if (w->contacts)
        step = lane_smaller(step, force_step(w, limit));
    *(lane_t *)(void *)w->step = lane_if_less(finite_sum(w), lane_constant(1), step, lane_constant(0));
}

/* A bound on a gap over the step, from its start and all that can lift it, in two chains of Horner's rule.
 * Most faces of most steps need no closer look. */
KERNEL_INLINE lane_t gap_margin(const saltus_work *w, int face, lane_t step) {
    const lane_t *gap = (const lane_t *)(const void *)w->gap + w->face_stop[face] * (w->order + 2);
    const lane_t square = step * step, none = lane_constant(0);
    const double side = w->face_side[face];
    const lane_t start = side * gap[0] - ((const lane_t *)(const void *)w->clearance)[face];
    lane_t odd = none, even = none;
    for (int k = (w->order + 1) / 2 * 2; k > 0; k -= 2) {
        const lane_t lift = side * gap[k], before = side * gap[k - 1];
        even = lane_fma(even, square, k <= w->order ? lane_if_less(none, lift, lift, none) : none);
        odd = lane_fma(odd, square, lane_if_less(none, before, before, none));
    }
    const lane_t size = lane_if_less(start, none, -start, start);
    return lane_fma(odd, step, start) + lane_fma(even, square, 1e-14 * size);
}

/* The step a lane takes: its own, or what is left to the target, or half of that when a sliver would remain.
 */
static void plan(saltus_work *w) {
    const lane_t left = *(const lane_t *)(const void *)w->left, step = *(const lane_t *)(const void *)w->step;
    const lane_t advance = lane_if_less(step, left, lane_smaller(step, 0.5 * left), left);
    lane_t near = lane_constant(-1);
    for (int f = 0; f < w->faces; f++) {
        const lane_t margin = gap_margin(w, f, advance);
        ((lane_t *)(void *)w->margin)[f] = margin;
        near = lane_if_less(margin, lane_constant(0), near, lane_constant(1));
    }
    *(lane_t *)(void *)w->advance = advance;
    *(lane_t *)(void *)w->passing = advance / *(const lane_t *)(const void *)w->period;
    *(lane_t *)(void *)w->near = near;
}

/* Even and odd coefficients in two chains: half the latency of Horner's rule. */
KERNEL_INLINE saltus_pack polynomial(const saltus_pack *newest, long stride, int order, saltus_pack time,
                                     saltus_pack square) {
    saltus_pack high = newest[0], low = newest[-stride];
    for (int k = order - 2; k > 0; k -= 2) {
        newest -= 2 * stride;
        high = saltus_pack_fma(high, square, newest[0]);
        low = saltus_pack_fma(low, square, newest[-stride]);
    }
    if (order % 2)
        return saltus_pack_fma(high, time, low);
    return saltus_pack_fma(low, time, saltus_pack_fma(high, square, newest[-2 * stride]));
}

static void evaluate(saltus_work *w, int order) {
    const lane_t time = *(const lane_t *)(const void *)w->advance;
    const saltus_pack spread = lane_spread(time), square = spread * spread;
    const long stride = (long)(saltus_work_jet(w, 1, 0) / SALTUS_PACK);
    const saltus_pack *q = (const saltus_pack *)(const void *)w->q + order * stride,
                      *v = (const saltus_pack *)(const void *)w->v + order * stride;
    saltus_pack *xq = (saltus_pack *)(void *)w->xq, *xv = (saltus_pack *)(void *)w->xv;
    for (long p = 0; p < stride; p++) {
        xq[p] = polynomial(q + p, stride, order, spread, square);
        xv[p] = polynomial(v + p, stride, order, spread, square);
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
    .plan = plan,
    .evaluate = evaluate,
};
