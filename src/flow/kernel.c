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

#define PACKS(place) ((saltus_pack *)(void *)(place))
#define NUMBERS(place) ((lane_t *)(void *)(place))

/* What expanding a step needs of a work, by value: a store through a pack may alias the work, whose members
 * the compiler would have to reload after every store. In the common cases sizes are constants. */
typedef struct frame {
    unsigned terms;
    int packs;      /* per row */
    int block;      /* packs worked on side by side, ... */
    int rest;       /* ... and at a row's end; they count as constants if its length is one */
    int columns;    /* tangent vectors */
    int directions; /* the last of the columns: parameter columns */
    int dof, extra, forcing;
    bool single; /* only the field itself: nothing is prepared for the next order */
    long orders, order_span;
    saltus_pack *q, *v; /* jets */
    lane_t *e;
    saltus_loaded loaded;
    saltus_model_series model;
    saltus_holding hold;
    saltus_varied vary;
    const lane_t *phase, *elapsed;
    lane_t *passing; /* for tapes: what is needed at its own order only */
} frame;

#define ORDER_STRIDE ((long)(1 + f.columns) * f.packs)
#define JET(a, k, c) ((a) + (long)(k)*ORDER_STRIDE + (long)(c)*f.packs)
#define EXTRA(k, c) (f.e + ((long)(k) * (1 + f.columns) + (c)) * f.extra)
#define SERIES(n, k, c) (NUMBERS(f.model.series) + ((n) * (1 + f.columns) + (c)) * f.orders + (k))
#define DRIVE(n, k) (NUMBERS(f.model.drive) + (n)*f.order_span + (k))
#define DRIVE_PACK(n, k) PACKS(DRIVE(n, k))
#define TABLE(n, k) PACKS(NUMBERS(f.loaded.table) + (n)*f.order_span + (k))
#define AHEAD(n, c) JET(PACKS(f.model.ahead), n, c)
#define SCALAR(n) (NUMBERS(f.loaded.scalar) + (n))
#define ROW(n) (PACKS(f.loaded.rows) + (n)*f.packs)
#define PUSH(m) (PACKS(f.hold.push) + (m)*f.packs)
#define PULL(m) (PACKS(f.hold.pull) + (m)*f.packs)
#define FORCE(m, k) (NUMBERS(f.hold.force) + (m)*f.orders + (k))
#define VARY_SCALAR(d, n) (NUMBERS(f.vary.scalar) + (d)*SALTUS_SCALARS_MAX + (n))
#define VARY_ROW(d, n) (PACKS(f.vary.rows) + ((d)*SALTUS_ROWS_MAX + (n)) * f.packs)
#define VARY_PUSH(m) (PACKS(f.vary.push) + (m)*f.packs)
#define VARY_PULL(m) (PACKS(f.vary.pull) + (m)*f.packs)
#define VARY_FORCE(m) (NUMBERS(f.vary.force) + (m))
#define VARY_DRIVE(d, n, k) (NUMBERS(f.vary.drive) + ((d)*model_vary_drives + (n)) * f.order_span + (k))

#include SALTUS_MODEL_KERNEL

static saltus_state_rows reserve_rows(saltus_arena *arena, const saltus_work *w, size_t count) {
    return (saltus_state_rows){.q = saltus_arena_doubles(arena, count * (size_t)w->row),
                               .v = saltus_arena_doubles(arena, count * (size_t)w->row),
                               .e = saltus_arena_doubles(arena, count * (size_t)w->extra * LANES)};
}

static void reserve(saltus_work *w) {
    saltus_arena *a = &w->arena;
    w->lanes = LANES;
    w->row = SALTUS_WIDE ? w->dof * LANES : row_packs(w->dof) * SALTUS_PACK;
    w->order_span = (w->order + 2 + SALTUS_PACK - 1) / SALTUS_PACK * SALTUS_PACK;
    const size_t orders = (size_t)w->order + 2, span = (size_t)w->order_span * LANES;
    const size_t all = (size_t)w->columns + 1, row = (size_t)w->row, stops = (size_t)w->stops;
    const size_t contacts = (size_t)w->hold.count, directions = (size_t)w->directions;
    const saltus_tape *tape = w->loaded.tape;
    const size_t weights = tape ? (size_t)tape->weights[SALTUS_WIDE] : 0,
                 elements = tape ? (size_t)tape->elements[SALTUS_WIDE] : 0;
    w->lane = (void *)saltus_arena_doubles(a, sizeof *w->lane / sizeof(double));
    w->state = reserve_rows(a, w, all);
    w->jet = reserve_rows(a, w, orders * all);
    w->gap = saltus_arena_doubles(a, stops * orders * LANES);
    w->loaded.normal = saltus_arena_doubles(a, stops * row);
    w->loaded.scalar = saltus_arena_doubles(a, SALTUS_SCALARS_MAX * LANES);
    w->loaded.rows = saltus_arena_doubles(a, SALTUS_ROWS_MAX * row);
    for (int m = 0; m < SALTUS_COUPLINGS_MAX; m++)
        w->loaded.coupling[m] = saltus_arena_doubles(a, coupling_size(w->dof));
    w->loaded.table = saltus_arena_doubles(a, model_tables * span);
    w->model.drive_size = model_drives * span;
    w->model.drive = saltus_arena_doubles(a, w->model.drive_size);
    w->model.ahead = saltus_arena_doubles(a, model_rows_ahead * all * row);
    w->model.series = saltus_arena_doubles(a, (model_series_count + elements) * orders * all * LANES);
    w->loaded.weights = saltus_arena_doubles(a, weights * LANES);
    w->hold.push = saltus_arena_doubles(a, contacts * row);
    w->hold.pull = saltus_arena_doubles(a, contacts * row);
    w->hold.force = saltus_arena_doubles(a, contacts * orders * LANES);
    w->vary.scalar = saltus_arena_doubles(a, directions * SALTUS_SCALARS_MAX * LANES);
    w->vary.rows = saltus_arena_doubles(a, directions * SALTUS_ROWS_MAX * row);
    w->vary.weights = saltus_arena_doubles(a, directions * weights * LANES);
    w->vary.drive = saltus_arena_doubles(a, directions * model_vary_drives * span);
    w->vary.push = saltus_arena_doubles(a, directions * contacts * row);
    w->vary.pull = saltus_arena_doubles(a, directions * contacts * row);
    w->vary.force = saltus_arena_doubles(a, directions * contacts * LANES);
}

/* How many orders of the series of sin(omega t) and its square matter beside the tolerance at the limit. */
static int count_orders(const saltus_work *w, int lane, const saltus_system *system) {
    const double rtol = w->tolerance.relative, angle = w->lane->damped[lane] * system->omega;
    const double small = fmax(1e-19, rtol * fmin(1e-3, 1e7 * rtol));
    double term = 1, twice = 1;
    int order = 0;
    while (order <= w->lane->degree[lane] && fmax(term, 0.25 * twice) > small) {
        term *= angle / ++order;
        twice *= 2 * angle / order;
    }
    return order;
}

/* Copy a system's row of numbers into one lane of a row. */
static void load_row(const saltus_work *w, double *row, int lane, const double *values) {
    for (int i = 0; i < w->dof; i++)
        row[i * LANES + lane] = values[i];
}

/* Copy the numbers of a system from text to where its tape's rows expect them. */
static void load_weights(const saltus_work *w, double *weights, int lane, const double *slots) {
    const saltus_tape *tape = w->loaded.tape;
    for (int k = 0; tape && k < tape->weights[SALTUS_WIDE]; k++) {
        const int slot = tape->weight_slot[SALTUS_WIDE][k];
        weights[k * LANES + lane] = slot < 0 ? 0 : slots[slot];
    }
}

/* Tolerances near rounding do without damped orders, whose longer steps would amplify it. */
static const double damped_from = 1e-11;

static void load(saltus_work *w, int lane, const saltus_system *system, int degree, saltus_damping damping) {
    const saltus_coefficients *c = &system->coefficients;
    saltus_loaded *to = &w->loaded;
    to->tape = system->tape;
    to->value = saltus_operation_value;
    int n = w->dof, most = 0;
    for (int s = 0; s < SALTUS_SCALARS_MAX; s++)
        to->scalar[s * LANES + lane] = c->scalar[s];
    for (int r = 0; r < c->rows; r++)
        load_row(w, to->rows + r * w->row, lane, c->row[r]);
    load_weights(w, to->weights, lane, c->slot);
    for (int m = 0; m < c->couplings; m++)
        for (int i = 0; i < n; i++)
            for (int j = 1 - i % 2; j < n; j += 2)
                to->coupling[m][coupling_place(n, i, j)] = c->coupling[m][i * n + j];
    for (int s = 0; s < w->stops; s++)
        load_row(w, to->normal + s * w->row, lane, system->stop_normal[s]);
    to->terms |= c->terms;
    w->faces.count = system->face_count;
    for (int f = 0; f < w->faces.count; f++) {
        w->faces.face[f] = system->faces[f];
        w->lane->clearance[f][lane] = system->faces[f].d;
    }
    w->lane->degree[lane] = degree;
    saltus_work_settle_degrees(w);
    const bool damps = w->tolerance.relative > damped_from;
    w->lane->limit[lane] = w->lane->reach[lane] = damping.plain;
    w->lane->damped[lane] = damps ? damping.limit : damping.plain;
    w->lane->last[lane] = damping.last;
    w->lane->before[lane] = damping.before;
    w->lane->period[lane] = system->period;
    w->lane->omega_unit[lane] = system->scale[n] / system->scale[0];
    w->forcing.lane[lane] = count_orders(w, lane, system);
    for (int l = 0; l < LANES; l++)
        most = w->forcing.lane[l] > most ? w->forcing.lane[l] : most;
    /* The drives must be zero at orders that no longer matter, because these are not computed any more. */
    if (most < w->forcing.most)
        memset(w->model.drive, 0, w->model.drive_size * sizeof *w->model.drive);
    w->forcing.most = most;
    model_load(w, lane, system);
}

static void vary(saltus_work *w, int lane, int direction, const saltus_variation *variation) {
    const saltus_coefficients *c = &variation->coefficients;
    for (int s = 0; s < SALTUS_SCALARS_MAX; s++)
        w->vary.scalar[(direction * SALTUS_SCALARS_MAX + s) * LANES + lane] = c->scalar[s];
    for (int r = 0; r < c->rows; r++)
        load_row(w, w->vary.rows + (direction * SALTUS_ROWS_MAX + r) * w->row, lane, c->row[r]);
    if (w->loaded.tape)
        load_weights(w, w->vary.weights + direction * w->loaded.tape->weights[SALTUS_WIDE] * LANES, lane,
                     c->slot);
    w->loaded.terms |= c->terms;
    w->vary.tilts |= variation->tilts;
    w->vary.orders = w->forcing.most + 1;
}

enum { sign_shift = 63, exponent_shift = 52, exponent_bias = 1023 }; /* of a double's bits */

/* Adding it to a small number rounds that number to an integer, held in the sum's last bits. */
static const double rounder = 6755399441055744.0;

/* Sum of c_k x^k, k < 8, by Estrin's scheme: three products deep. */
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

/* Held contacts: q'' = f - b (pull . f), with the force's series kept to find the release. `velocity` is the
 * coefficient k + 1 of q', that is q'' / (k + 1). */
KERNEL_INLINE void hold_contacts(frame f, int k, int c, saltus_pack *velocity) {
    saltus_pack force[SALTUS_FACES_MAX];
    for (int m = 0; m < f.hold.count; m++) {
        force[m] = row_dot(PULL(m), velocity, f.dof, f.packs);
        if (c == 0)
            *FORCE(m, k) = lane_of(force[m] * (k + 1.0));
    }
    for (int m = 0; m < f.hold.count; m++)
        for (int p = 0; p < f.packs; p++)
            velocity[p] = saltus_pack_fnma(PUSH(m)[p], force[m], velocity[p]);
}

/* Contact projections may depend on parameters (places of stops, masses). Their effect on a parameter column
 * follows from the trajectory's acceleration before the projection, kept when c = 0. */
KERNEL_INLINE void keep_forces(frame f, const saltus_pack *velocity) {
    for (int m = 0; m < f.directions * f.hold.count; m++)
        *VARY_FORCE(m) = lane_of(row_dot(VARY_PULL(m), velocity, f.dof, f.packs));
}

KERNEL_INLINE void tilt_contacts(frame f, int k, int direction, double inverse, saltus_pack *velocity) {
    for (int m = 0; m < f.hold.count; m++) {
        const int place = direction * f.hold.count + m;
        const saltus_pack force = lane_spread(*FORCE(m, k)) * inverse,
                          change = lane_spread(*VARY_FORCE(place));
        for (int p = 0; p < f.packs; p++) {
            saltus_pack sum = saltus_pack_fnma(VARY_PUSH(place)[p], force, velocity[p]);
            velocity[p] = saltus_pack_fnma(PUSH(m)[p], change, sum);
        }
    }
}

/* Contacts hold in few steps. */
KERNEL_INLINE bool holds(frame f) {
    return __builtin_expect(f.hold.count != 0, 0);
}

/* v_k and q_{k+1} -> v_{k+1}, q_{k+2}, in columns c .. c + abreast - 1. */
KERNEL_INLINE void expand_order(frame f, int k, int c, const int abreast) {
    const double inverse = 1.0 / (k + 1), later = 1.0 / (k + 2);
    saltus_pack next[ROW_PACKS_MAX], displacement[ROW_PACKS_MAX];
    model_order(f, k, c, abreast, inverse, next);
    for (int j = 0; j < abreast; j++) {
        const int direction = f.directions - 1 - (f.columns - (c + j));
        saltus_pack *own = next + j * f.packs;
        if (f.directions && direction >= 0)
            model_source(f, k, c + j, direction, inverse, own);
        if (holds(f)) {
            if (f.vary.tilts && c == 0)
                keep_forces(f, own);
            hold_contacts(f, k, c + j, own);
            if (f.vary.tilts && direction >= 0)
                tilt_contacts(f, k, direction, inverse, own);
        }
    }
    for (int p = 0; p < f.packs * abreast; p++) {
        JET(f.v, k + 1, c)[p] = next[p];
        JET(f.q, k + 2, c)[p] = displacement[p] = next[p] * later;
    }
    for (int j = 0; j < abreast; j++)
        model_place(f, k + 1, c + j, next + j * f.packs, displacement + j * f.packs);
}

/* The gaps' coefficients first .. last, of one trajectory as many at once as a pack holds; the last ones may
 * be formed twice. */
KERNEL_INLINE void gap_series(frame f, const saltus_work *w, int first, int last) {
    for (int stop = 0; stop < w->stops; stop++) {
        const saltus_pack *normal = PACKS(w->loaded.normal) + stop * f.packs;
        lane_t *gap = NUMBERS(w->gap) + stop * f.orders;
        saltus_pack row[ROW_PACKS_MAX];
        for (int p = 0; p < f.packs; p++)
            row[p] = normal[p];
        int k = first;
        for (; LANES == 1 && f.packs == 1 && k <= last && last - first + 1 >= SALTUS_PACK; k += SALTUS_PACK) {
            saltus_pack product[SALTUS_PACK];
            if (k > last + 1 - SALTUS_PACK)
                k = last + 1 - SALTUS_PACK;
            for (int i = 0; i < SALTUS_PACK; i++)
                product[i] = row[0] * *JET(f.q, k + i, 0);
            product[0] = saltus_pack_sums(product);
            memcpy(gap + k, product, sizeof *product);
        }
        for (; k <= last; k++)
            gap[k] = lane_of(row_dot(row, JET(f.q, k, 0), f.dof, f.packs));
    }
}

KERNEL_INLINE frame make_frame(const saltus_work *w, unsigned terms, int packs, int block, int columns,
                               int directions, int contacts) {
    frame f = {.terms = terms,
               .packs = packs,
               .block = block,
               .rest = rest_of(packs, block),
               .columns = columns,
               .directions = directions,
               .dof = SALTUS_WIDE ? packs : w->dof,
               .extra = terms & SALTUS_TERM_EXTRA ? w->extra : 0,
               .forcing = terms & SALTUS_TERM_FORCED ? w->forcing.most : 0,
               .orders = w->order + 2,
               .order_span = w->order_span,
               .q = PACKS(w->jet.q),
               .v = PACKS(w->jet.v),
               .e = NUMBERS(w->jet.e),
               .loaded = w->loaded,
               .model = w->model,
               .hold = w->hold,
               .vary = w->vary,
               .phase = NUMBERS(w->lane->phase),
               .elapsed = NUMBERS(w->lane->elapsed)};
    f.hold.count = contacts;
    f.vary.tilts &= directions > 0;
    return f;
}

/* The forcing's series up to `order`, which the step may come to need, and order 0 of the jets. */
KERNEL_INLINE void begin_jets(frame f, const saltus_work *w, int order) {
    lane_t sine, cosine;
    turn(*NUMBERS(w->lane->phase), &sine, &cosine);
    model_forcing(f, order, sine, cosine);
    for (int d = 0; d < f.directions; d++)
        model_vary_forcing(f, d, order, sine, cosine);
    for (int i = 0; i < (1 + f.columns) * f.packs; i++) {
        f.q[i] = PACKS(w->state.q)[i];
        f.v[i] = JET(f.q, 1, 0)[i] = PACKS(w->state.v)[i];
    }
    for (int i = 0; i < (1 + f.columns) * f.extra; i++)
        f.e[i] = NUMBERS(w->state.e)[i];
    for (int c = 0; c <= f.columns; c++)
        model_start(f, c);
}

/* An order of all columns of a trajectory: in the common cases those of tangent vectors, which share its
 * coefficients, side by side, as many as the model can take or one less. */
KERNEL_INLINE void expand_order_of_all(frame f, int k) {
    int c = 0;
    if (model_abreast > 1) {
        const bool known = __builtin_constant_p(f.packs) && __builtin_constant_p(f.terms);
        const int most = known && f.packs <= model_abreast ? model_abreast / f.packs : 1, fewer = most - 1;
        const int lacking = f.columns % most ? most - f.columns % most : 0,
                  full = f.columns - fewer * lacking;
        if (most > 1)
            expand_order(f, k, c++, 1);
        for (; most > 1 && c + most - 1 <= full; c += most)
            expand_order(f, k, c, most);
        for (; fewer > 1 && c + fewer - 1 <= f.columns; c += fewer)
            expand_order(f, k, c, fewer);
    }
    for (; c <= f.columns; c++)
        expand_order(f, k, c, 1);
}

/* In the wide kernel, columns that depend only on the trajectory are expanded one after the other, so that
 * all coefficients of one fit into the nearest cache. Narrow ones take turns, because each order waits for
 * the one before. The effect of tilting contacts is kept for one order only. */
KERNEL_INLINE void expand_columns(frame f, int from, int to) {
    if (SALTUS_WIDE && model_columns_apart && !(f.vary.tilts && f.hold.count))
        for (int c = 0; c <= f.columns; c++)
            for (int k = from; k < to; k++)
                expand_order(f, k, c, 1);
    else
        for (int k = from; k < to; k++)
            expand_order_of_all(f, k);
}

KERNEL_INLINE void expand_frame(frame f, const saltus_work *w, int from, int to) {
    if (from == 0)
        begin_jets(f, w, to > w->degree_most ? to : w->degree_most);
    expand_columns(f, from, to);
    gap_series(f, w, from ? from + 1 : 0, to);
}

#ifdef SALTUS_FIXED_TAPE

/* Sizes are constants of the one flow for which this is compiled. */
_Static_assert(SALTUS_PACK == SALTUS_FIXED_PACK && sizeof(saltus_work) == SALTUS_FIXED_WORK,
               "compiled otherwise than the library");
__attribute__((visibility("default"))) void SALTUS_KERNEL_NAME(saltus_work *w, int from, int to);
/* No element is accessed through two of these pointers, although `kept` and `passing` are one array. */
static __attribute__((noinline)) void expand_fixed(const saltus_work *w, int from, int to,
                                                   double *restrict kept, lane_t *restrict passing,
                                                   double *restrict q, double *restrict v) {
    const int packs = row_packs(SALTUS_FIXED_DOF);
    frame f = make_frame(w, SALTUS_FIXED_EXTRA ? SALTUS_TERM_EXTRA : 0, packs, row_block(packs),
                         SALTUS_FIXED_COLUMNS, SALTUS_FIXED_DIRECTIONS, w->hold.count);
    f.dof = SALTUS_FIXED_DOF;
    f.extra = SALTUS_FIXED_EXTRA;
    f.orders = SALTUS_FIXED_ORDER + 2;
    f.model.series = kept;
    f.passing = passing;
    f.q = PACKS(q);
    f.v = PACKS(v);
    expand_frame(f, w, from, to);
}

void SALTUS_KERNEL_NAME(saltus_work *w, int from, int to) {
    expand_fixed(w, from, to, w->model.series, NUMBERS(w->model.series), w->jet.q, w->jet.v);
}

#else

/* Terms and shape become constants here, once per step; the common cases have loops of their own. */
KERNEL_INLINE void expand_rows(const saltus_work *w, int from, int to, int packs, unsigned terms) {
    const int block = row_block(packs);
    if (w->columns == 0 && w->hold.count == 0)
        expand_frame(make_frame(w, terms, packs, block, 0, 0, 0), w, from, to);
    else
        expand_frame(make_frame(w, terms, packs, block, w->columns, 0, w->hold.count), w, from, to);
}

KERNEL_INLINE void expand_directions(const saltus_work *w, int from, int to, int packs, int block,
                                     unsigned terms) {
    expand_frame(make_frame(w, terms, packs, block, w->columns, w->directions, w->hold.count), w, from, to);
}

static void expand_any(const saltus_work *w, int from, int to) {
    const int packs = row_packs(w->dof), block = row_block(ROW_PACKS_MAX);
    if (from == 0 && to == 1 && !w->directions) {
        frame f = make_frame(w, w->loaded.terms, packs, block, w->columns, 0, w->hold.count);
        f.single = true;
        expand_frame(f, w, 0, 1);
    } else if (w->directions)
        expand_directions(w, from, to, packs, 1, w->loaded.terms);
    else
        expand_frame(make_frame(w, w->loaded.terms, packs, block, w->columns, 0, w->hold.count), w, from, to);
}

#define FOR_ROWS(statement)                                                                                  \
    statement(1) statement(2) statement(3) statement(4) statement(5) statement(6) statement(7) statement(8)  \
        statement(9) statement(10) statement(11) statement(12) statement(13) statement(14) statement(15)     \
            statement(16)
#define EXPAND_ROWS(n)                                                                                       \
    static void expand_##n(const saltus_work *w, int from, int to) {                                         \
        const bool common = n <= model_rows_common && w->loaded.terms == model_common_terms(n);              \
        if (common && !w->directions)                                                                        \
            expand_rows(w, from, to, n, model_common_terms(n));                                              \
        else if (common && n <= model_rows_varied)                                                           \
            expand_directions(w, from, to, n, row_block(n), model_common_terms(n));                          \
        else if (n <= model_rows_plain && !w->directions)                                                    \
            expand_rows(w, from, to, n, w->loaded.terms);                                                    \
        else if (n <= model_rows_plain)                                                                      \
            expand_directions(w, from, to, n, row_block(n), w->loaded.terms);                                \
        else                                                                                                 \
            expand_any(w, from, to);                                                                         \
    }
FOR_ROWS(EXPAND_ROWS)

#ifdef MODEL_ALONE

/* One trajectory waits for each order's result. In straight code, with all sizes constant and no array
 * accessed through two of these pointers, the newest coefficients stay in registers. */
enum { orders_alone = 20 };
KERNEL_INLINE void expand_straight(const saltus_work *w, int to, int dof, saltus_pack *restrict q,
                                   saltus_pack *restrict v, double *restrict series, double *restrict drive,
                                   double *restrict ahead) {
    frame f = make_frame(w, model_alone_terms(dof), 1, 1, 0, 0, 0);
    f.dof = dof;
    f.forcing = orders_alone;
    f.q = q;
    f.v = v;
    f.model.series = series;
    f.model.drive = drive;
    f.model.ahead = ahead;
    begin_jets(f, w, to > w->degree_most ? to : w->degree_most);
#pragma GCC unroll 20
    for (int k = 0; k < orders_alone; k++) {
        if (k == to)
            break;
        expand_order(f, k, 0, 1);
    }
    gap_series(f, w, 0, to);
}

#define EXPAND_ALONE(n)                                                                                      \
    static __attribute__((noinline)) void expand_alone_##n(                                                  \
        const saltus_work *w, int to, saltus_pack *restrict q, saltus_pack *restrict v,                      \
        double *restrict series, double *restrict drive, double *restrict ahead) {                           \
        expand_straight(w, to, n, q, v, series, drive, ahead);                                               \
    }
MODEL_ALONE(EXPAND_ALONE)

/* Whether this was done by code for a lone trajectory. */
static bool expand_alone(const saltus_work *w, int from, int to) {
    if (w->columns || w->hold.count || from || to > orders_alone || w->degree_most > orders_alone ||
        w->loaded.terms != model_alone_terms(w->dof))
        return false;
#define CASE_ALONE(n)                                                                                        \
    case n:                                                                                                  \
        expand_alone_##n(w, to, PACKS(w->jet.q), PACKS(w->jet.v), w->model.series, w->model.drive,           \
                         w->model.ahead);                                                                    \
        return true;
    switch (w->dof) {
        MODEL_ALONE(CASE_ALONE)
    default:
        return false;
    }
}

#else

static bool expand_alone(const saltus_work *w, int from, int to) {
    (void)w;
    (void)from;
    (void)to;
    return false;
}

#endif

static void expand(saltus_work *w, int from, int to) {
    if (expand_alone(w, from, to))
        return;
#define CASE(n)                                                                                              \
    case n:                                                                                                  \
        expand_##n(w, from, to);                                                                             \
        break;
    switch (row_packs(w->dof)) {
        FOR_ROWS(CASE)
    default:
        expand_any(w, from, to);
    }
}

/* x^inverse, x > 0, to about one percent, from the exponent and a parabola; enough for a step size. */
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

/* What a work is made of, as constants in the plain cases. */
typedef struct shape {
    int packs, columns, extra, contacts, degree_least, degree_most;
} shape;

KERNEL_INLINE shape shape_of(const saltus_work *w) {
    return (shape){.packs = row_packs(w->dof),
                   .columns = w->columns,
                   .extra = w->extra,
                   .contacts = w->hold.count,
                   .degree_least = LANES == 1 ? w->degree_most : w->degree_least,
                   .degree_most = w->degree_most};
}

/* Whether there is nothing but displacements and velocities: one trajectory's, in one pack, or those of wide
 * lanes of one degree. */
KERNEL_INLINE bool is_plain(const saltus_work *w) {
    return (LANES == 1 ? row_packs(w->dof) == 1 : w->degree_least == w->degree_most) && w->columns == 0 &&
           w->extra == 0 && w->hold.count == 0;
}

KERNEL_INLINE shape shape_plain(const saltus_work *w) {
    return (shape){.packs = LANES == 1 ? 1 : row_packs(w->dof),
                   .degree_least = w->degree_most,
                   .degree_most = w->degree_most};
}

/* Norm of a column at one order: max of |q_k|, |v_k| / omega_unit, |e_k|. */
KERNEL_INLINE lane_t column_norm(const saltus_work *w, shape f, int k, int c) {
    const long row = (long)k * (1 + f.columns) + c;
    const saltus_pack *q = PACKS(w->jet.q) + row * f.packs, *v = PACKS(w->jet.v) + row * f.packs;
    const lane_t *e = NUMBERS(w->jet.e) + row * f.extra;
    saltus_pack displacement = {0}, velocity = {0};
    for (int p = 0; p < f.packs; p++) {
        displacement = saltus_pack_max_size(displacement, q[p]);
        velocity = saltus_pack_max_size(velocity, v[p]);
    }
    for (int i = 0; i < f.extra; i++)
        displacement = saltus_pack_max_size(displacement, lane_spread(e[i]));
    const lane_t slowness = 1.0 / *NUMBERS(w->lane->omega_unit);
    return lane_largest(saltus_pack_max_size(displacement, velocity * lane_spread(slowness)));
}

/* The tolerance over a coefficient's norm: `untold` if either is too small to tell, 0 for a norm not
 * finite. */
static const double untold = 1e290;
KERNEL_INLINE lane_t coefficient_room(lane_t norm, lane_t tolerance) {
    const lane_t none = lane_constant(untold), ratio = tolerance / norm;
    const lane_t told = lane_if_less(tolerance * 1e-200, norm, ratio, none),
                 sure = lane_if_less(lane_constant(1e-280), tolerance, told, none);
    return lane_if_less(norm, lane_constant(1e300), sure, lane_constant(0));
}

/* The step at which the coefficient of order k with the least room falls below the tolerance. */
KERNEL_INLINE lane_t coefficient_step(lane_t room, int k, lane_t limit) {
    const lane_t none = lane_constant(0), step = 0.97 * approximate_root(room, 1.0 / k);
    return lane_if_less(none, room, lane_if_less(room, lane_constant(untold), step, limit), none);
}

/* Zero if all displacements of the state and the last velocities and extra states of the series are finite,
 * otherwise not a number. What is no number stays so in all later orders, but a maximum may pass it over. */
KERNEL_INLINE lane_t finite_sum(const saltus_work *w, shape f) {
    const long last = (long)f.degree_least * (1 + f.columns);
    const saltus_pack *q = PACKS(w->jet.q), *v = PACKS(w->jet.v) + last * f.packs;
    const lane_t *e = NUMBERS(w->jet.e) + last * f.extra;
    saltus_pack sum = {0};
    for (int p = 0; p < f.packs; p++)
        sum += (q[p] - q[p]) + (v[p] - v[p]);
    lane_t total = lane_total(sum);
    for (int i = 0; i < f.extra; i++)
        total += e[i] - e[i];
    return total;
}

/* `step` if order k is one of the last two of the lane's series, else the limit. */
KERNEL_INLINE lane_t step_of_last(const saltus_work *w, shape f, lane_t step, int k, lane_t limit) {
    if (f.degree_least == f.degree_most)
        return step;
    const lane_t off = lane_size(*NUMBERS(w->lane->degree) - (k + 0.5));
    return lane_if_less(off, lane_constant(1), step, limit);
}

/* A step with damped orders is the shorter by this, so that what they lack is far below the tolerance. */
static const double sure = 0.85;

/* The step at which the last two coefficients of every column fall below the tolerance (Jorba & Zou, section
 * 3), and with held contacts also those of their forces: if contacts fix everything that could move, only
 * these show how far the series reach. */
KERNEL_INLINE void measure_shape(saltus_work *w, shape f) {
    const int steady = f.columns - w->directions, first = f.degree_least - 1,
              count = f.degree_most - first + 1;
    const lane_t limit = *NUMBERS(w->lane->limit);
    const lane_t reach = *NUMBERS(w->lane->reach), most = lane_if_less(limit, reach, reach / sure, limit);
    const saltus_tolerance allowed = w->tolerance;
    lane_t step = most, least[SALTUS_ORDER_MAX + 1];
    for (int k = 0; k < count; k++)
        least[k] = lane_constant(untold);
    for (int c = 0; c <= f.columns; c++) {
        const lane_t change = limit * column_norm(w, f, 1, c);
        lane_t size = column_norm(w, f, 0, c);
        /* A parameter column starts at zero, so its growth within a step counts as size too. A state at rest
         * in the origin has no size either: a millionth of that growth replaces it, too little to matter for
         * any other state. */
        if (c > steady)
            size += change;
        else
            size = lane_if_less(size, 1e-6 * change, 1e-6 * change, size);
        const lane_t tolerance = c ? allowed.tangent * size : allowed.absolute + allowed.relative * size;
        for (int k = 0; k < count; k++)
            least[k] = lane_smaller(least[k], coefficient_room(column_norm(w, f, first + k, c), tolerance));
    }
    for (int k = 0; k < count; k++)
        step = lane_smaller(step,
                            step_of_last(w, f, coefficient_step(least[k], first + k, most), first + k, most));
    for (int m = 0; m < f.contacts; m++) {
        const lane_t *force = NUMBERS(w->hold.force) + m * (w->order + 2);
        const lane_t size = lane_size(force[0]) + limit * (lane_size(force[1]) + limit * lane_size(force[2]));
        for (int k = f.degree_least - 3; k <= f.degree_most - 2; k++) {
            const lane_t room = coefficient_room(lane_size(force[k]), allowed.relative * size);
            const lane_t own = coefficient_step(room, k, most);
            step = lane_smaller(step, step_of_last(w, f, own, k + 2, most));
        }
    }
    step = lane_if_less(limit, sure * step, sure * step, lane_smaller(step, limit));
    *NUMBERS(w->lane->step) = lane_if_less(finite_sum(w, f), lane_constant(1), step, lane_constant(0));
}

KERNEL_INLINE void measure(saltus_work *w) {
    if (is_plain(w))
        measure_shape(w, shape_plain(w));
    else
        measure_shape(w, shape_of(w));
}

/* The coefficient of order k if the lane's series has one, else `beyond`. */
KERNEL_INLINE lane_t series_term(const saltus_work *w, lane_t coefficient, int k, double beyond) {
    return k <= w->degree_least ? coefficient
                                : lane_if_less(lane_constant(k - 0.5), *NUMBERS(w->lane->degree), coefficient,
                                               lane_constant(beyond));
}

/* A bound on a gap over the step: its start plus all positive terms, in two chains of Horner's rule. Most
 * faces in most steps need no closer look. */
KERNEL_INLINE lane_t gap_margin(const saltus_work *w, int face, lane_t step) {
    const lane_t *gap = NUMBERS(w->gap) + w->faces.face[face].stop * (w->order + 2);
    const lane_t square = step * step, none = lane_constant(0);
    const double side = w->faces.face[face].side;
    const lane_t start = side * gap[0] - *NUMBERS(w->lane->clearance[face]);
    lane_t odd = none, even = none;
    for (int k = (w->degree_most + 1) / 2 * 2; k > 0; k -= 2) {
        const lane_t lift = series_term(w, side * gap[k], k, 0),
                     before = series_term(w, side * gap[k - 1], k - 1, 0);
        even = lane_fma(even, square, lane_if_less(none, lift, lift, none));
        odd = lane_fma(odd, square, lane_if_less(none, before, before, none));
    }
    return lane_fma(odd, step, start) + lane_fma(even, square, 1e-14 * lane_size(start));
}

/* A step of Horner's rule for the positive terms and for the others, turned positive. */
KERNEL_INLINE void split_term(lane_t term, lane_t factor, lane_t *positive, lane_t *others) {
    const lane_t none = lane_constant(0);
    *positive = lane_fma(*positive, factor, lane_if_less(none, term, term, none));
    *others = lane_fma(*others, factor, lane_if_less(none, term, none, -term));
}

/* A bound on how far a row's velocity moves towards zero and beyond, from its start and all terms against it;
 * not negative if the start is near zero compared with the other terms. */
static void bound_velocity(saltus_work *w, int row) {
    const lane_t *series = NUMBERS(w->gap) + row * (w->order + 2);
    const lane_t step = *NUMBERS(w->lane->advance), square = step * step, none = lane_constant(0);
    const lane_t start = lane_size(series[1]),
                 side = lane_if_less(none, series[1], lane_constant(-1), lane_constant(1));
    lane_t even = none, odd = none, even_along = none, odd_along = none;
    for (int k = (w->degree_most + 1) / 2 * 2; k > 2; k -= 2) {
        split_term(series_term(w, side * series[k] * (double)k, k, 0), square, &even, &even_along);
        split_term(series_term(w, side * series[k - 1] * (k - 1.0), k - 1, 0), square, &odd, &odd_along);
    }
    split_term(side * series[2] * 2.0, square, &even, &even_along);
    const lane_t against = lane_fma(odd, step, even), along = lane_fma(odd_along, step, even_along);
    const lane_t margin = lane_fma(against, step, -start);
    *NUMBERS(w->lane->turning) = lane_if_less(1e-12 * along * step, start, margin + 1e-12 * start, none);
}

/* Multiply the last two orders of all series by the factors of those lanes that go beyond their plain limits.
 */
static void damp(saltus_work *w) {
    const lane_t one = lane_constant(1), advance = *NUMBERS(w->lane->advance);
    const lane_t limit = *NUMBERS(w->lane->limit), degree = *NUMBERS(w->lane->degree);
    const lane_t far = lane_if_less(limit, *NUMBERS(w->lane->reach), advance, lane_constant(0));
    const lane_t last = lane_if_less(limit, far, *NUMBERS(w->lane->last), one),
                 before = lane_if_less(limit, far, *NUMBERS(w->lane->before), one);
    const long stride = (1 + w->columns) * (long)row_packs(w->dof);
    const int extras = (1 + w->columns) * w->extra;
    for (int k = w->degree_least - 1; k <= w->degree_most; k++) {
        const lane_t at_last = lane_if_less(degree, lane_constant(k + 0.5), last, before),
                     factor = lane_if_less(lane_size(degree - (k + 0.5)), lane_constant(1), at_last, one);
        for (long p = k * stride; p < (k + 1) * stride; p++) {
            PACKS(w->jet.q)[p] *= lane_spread(factor);
            PACKS(w->jet.v)[p] *= lane_spread(factor);
        }
        for (int i = k * extras; i < (k + 1) * extras; i++)
            NUMBERS(w->jet.e)[i] *= factor;
        for (int s = 0; s < w->stops; s++)
            NUMBERS(w->gap)[s * (w->order + 2) + k] *= factor;
    }
}

/* The step of a lane: its own, or what is left to the target, or half of that if a sliver would remain. */
KERNEL_INLINE void plan(saltus_work *w) {
    const lane_t left = *NUMBERS(w->lane->left), step = *NUMBERS(w->lane->step);
    const lane_t advance = lane_if_less(step, left, lane_smaller(step, 0.5 * left), left);
    lane_t near = lane_constant(-1);
    *NUMBERS(w->lane->advance) = advance;
    if (lanes_less(*NUMBERS(w->lane->limit), lane_smaller(advance, *NUMBERS(w->lane->reach))))
        damp(w);
    for (int f = 0; f < w->faces.count; f++) {
        const lane_t margin = gap_margin(w, f, advance);
        *NUMBERS(w->lane->margin[f]) = margin;
        near = lane_if_less(margin, lane_constant(0), near, lane_constant(1));
    }
    *NUMBERS(w->lane->passing) = advance / *NUMBERS(w->lane->period);
    *NUMBERS(w->lane->near) = near;
}

/* A quiet lane's step meets nothing if it ends before the target and no face comes near. It may begin a new
 * period, but not pass one whole. */
KERNEL_INLINE unsigned pass(saltus_work *w, unsigned *quiet) {
    const lane_t one = lane_constant(1), none = lane_constant(0), phase = *NUMBERS(w->lane->phase);
    const lane_t next = phase + *NUMBERS(w->lane->passing), over = next - one;
    const lane_t left = *NUMBERS(w->lane->left), flight = *NUMBERS(w->lane->flight);
    const lane_t advance = *NUMBERS(w->lane->advance), brief = *NUMBERS(w->lane->brief);
    lane_t passed = lane_if_less(*NUMBERS(w->lane->quiet), none, one, none);
    passed = lane_if_less(*NUMBERS(w->lane->near), none, passed, none);
    passed = lane_if_less(advance, left, passed, none);
    passed = lane_if_less(phase, next, passed, none);
    passed = lane_if_less(over, phase, passed, none);
    const lane_t begun = lane_if_less(none, passed, lane_if_less(next, one, none, one), none),
                 cycles = *NUMBERS(w->lane->cycles) - begun,
                 now = lane_if_less(none, passed, lane_if_less(next, one, next, over), phase);
    const lane_t ahead = (cycles + (*NUMBERS(w->lane->until) - now)) * *NUMBERS(w->lane->period),
                 later = lane_if_less(none, passed, ahead, left),
                 fly = lane_if_less(advance, flight, flight - advance, lane_constant(INFINITY)),
                 taken = *NUMBERS(w->lane->taken) + passed;
    *NUMBERS(w->lane->from) = phase;
    *NUMBERS(w->lane->phase) = now;
    *NUMBERS(w->lane->cycles) = cycles;
    *NUMBERS(w->lane->left) = later;
    *NUMBERS(w->lane->flight) = lane_if_less(none, passed, fly, flight);
    *NUMBERS(w->lane->taken) = taken;
    const lane_t far = lane_if_less(brief, lane_smaller(later, fly), -passed, one);
    const lane_t goes_on = lane_if_less(taken, lane_constant(SALTUS_QUIET_STEPS), far, one);
    *NUMBERS(w->lane->quiet) = goes_on;
    const unsigned lanes = lanes_less(none, passed);
    *quiet = lanes & lanes_less(goes_on, none);
    return lanes;
}

/* A pack of displacements and one of velocities, even and odd coefficients of both in chains of their own,
 * which halves the latency of Horner's rule. */
KERNEL_INLINE void polynomials(const saltus_pack *q, const saltus_pack *v, long stride, int order,
                               saltus_pack time, saltus_pack square, saltus_pack *to_q, saltus_pack *to_v) {
    saltus_pack high = q[0], low = q[-stride], fast = v[0], slow = v[-stride];
    for (int k = order - 2; k > 0; k -= 2) {
        q -= 2 * stride;
        v -= 2 * stride;
        high = saltus_pack_fma(high, square, q[0]);
        low = saltus_pack_fma(low, square, q[-stride]);
        fast = saltus_pack_fma(fast, square, v[0]);
        slow = saltus_pack_fma(slow, square, v[-stride]);
    }
    if (order % 2) {
        *to_q = saltus_pack_fma(high, time, low);
        *to_v = saltus_pack_fma(fast, time, slow);
    } else {
        *to_q = saltus_pack_fma(low, time, saltus_pack_fma(high, square, q[-2 * stride]));
        *to_v = saltus_pack_fma(slow, time, saltus_pack_fma(fast, square, v[-2 * stride]));
    }
}

/* If degrees differ, set coefficients beyond a lane's degree to -0, which changes no bit of a sum. */
static void cut_series(const saltus_work *w, saltus_pack *series, long stride) {
    for (int k = w->degree_least + 1; k <= w->degree_most; k++)
        for (long p = 0; p < stride; p++)
            series[k * stride + p] = lane_spread(series_term(w, lane_of(series[k * stride + p]), k, -0.0));
}

KERNEL_INLINE void evaluate(saltus_work *w) {
    const int order = w->degree_most, extras = (1 + w->columns) * w->extra;
    const lane_t time = *NUMBERS(w->lane->advance);
    const saltus_pack spread = lane_spread(time), square = spread * spread;
    const long stride = (1 + w->columns) * (long)row_packs(w->dof);
    saltus_pack *to_q = PACKS(w->state.q), *to_v = PACKS(w->state.v);
    if (LANES > 1) {
        cut_series(w, PACKS(w->jet.q), stride);
        cut_series(w, PACKS(w->jet.v), stride);
        cut_series(w, PACKS(w->jet.e), extras);
    }
    const saltus_pack *q = PACKS(w->jet.q) + order * stride, *v = PACKS(w->jet.v) + order * stride;
    for (long p = 0; p < stride; p++)
        polynomials(q + p, v + p, stride, order, spread, square, to_q + p, to_v + p);
    for (int i = 0; i < extras; i++) {
        lane_t sum = lane_constant(0);
        for (int k = order; k >= 0; k--)
            sum = lane_fma(sum, time, NUMBERS(w->jet.e)[k * extras + i]);
        NUMBERS(w->state.e)[i] = sum;
    }
}

/* The integral of a lane's series' square over `advance`, by Gauss's rule with eight nodes in each of equal
 * pieces. Powers beyond its degree of 15 are integrated to 4e-10 of themselves, and products of coefficients
 * that belong to them are small within a step. */
static double integrate_square(const saltus_work *w, int row, int lane, int pieces) {
    enum { nodes = SALTUS_PACK_MAX, packs = nodes / SALTUS_PACK };
    static const double node[nodes] = {0.019855071751231856, 0.10166676129318664, 0.2372337950418355,
                                       0.40828267875217511,  0.59171732124782495, 0.7627662049581645,
                                       0.89833323870681336,  0.9801449282487682};
    static const double weight[nodes] = {0.050614268145188129, 0.11119051722668724, 0.15685332293894363,
                                         0.181341891689181,    0.181341891689181,   0.15685332293894363,
                                         0.11119051722668724,  0.050614268145188129};
    const double *series = w->gap + saltus_work_series_place(w, row, 0, lane);
    const int degree = (int)w->lane->degree[lane];
    const double step = w->lane->advance[lane] / pieces;
    double sum = 0;
    for (int piece = 0; piece < pieces; piece++) {
        saltus_pack part[packs];
        for (int p = 0; p < packs; p++) {
            saltus_pack place, share;
            memcpy(&place, node + p * SALTUS_PACK, sizeof place);
            memcpy(&share, weight + p * SALTUS_PACK, sizeof share);
            const saltus_pack time = (place + (double)piece) * step, square = time * time;
            saltus_pack even = saltus_pack_splat(degree % 2 ? 0 : series[degree * LANES]), odd = {0};
            for (int k = (degree - 1) / 2 * 2; k >= 0; k -= 2) {
                even = saltus_pack_fma(even, square, saltus_pack_splat(series[k * LANES]));
                odd = saltus_pack_fma(odd, square, saltus_pack_splat(series[(k + 1) * LANES]));
            }
            const saltus_pack value = saltus_pack_fma(odd, time, even);
            part[p] = value * value * share;
        }
        for (int half = packs / 2; half > 0; half /= 2)
            for (int p = 0; p < half; p++)
                part[p] += part[p + half];
        sum += saltus_pack_sum(part[0])[0];
    }
    return sum * step;
}

static unsigned proceed(saltus_work *w, unsigned lanes, unsigned *quiet) {
    measure(w);
    plan(w);
    const unsigned passed = pass(w, quiet);
    if (passed == lanes)
        evaluate(w);
    return passed;
}

extern const saltus_kernel SALTUS_KERNEL_NAME;
const saltus_kernel SALTUS_KERNEL_NAME = {
    .model = MODEL_NAME,
    .lanes = LANES,
    .flags = SALTUS_KERNEL_FLAGS,
    .reserve = reserve,
    .load = load,
    .vary = vary,
    .expand = expand,
    .measure = measure,
    .plan = plan,
    .pass = pass,
    .proceed = proceed,
    .bound_velocity = bound_velocity,
    .evaluate = evaluate,
    .integrate_square = integrate_square,
};
#endif
