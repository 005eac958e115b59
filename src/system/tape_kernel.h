/* The vector field of a system from text: interprets its tape, order by order.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_TAPE_KERNEL_H
#define SALTUS_SYSTEM_TAPE_KERNEL_H

#include "system/tape.h"

#define MODEL_NAME "tape"

/* When compiled for one tape (flow/fixed.h), the tape's numbers are constants of the program. */
#ifdef SALTUS_FIXED_TAPE
SALTUS_FIXED_TAPE
#define TAPE_OF(loaded) (&fixed_tape)
/* Rows of one element are accessed as scalars: all their operands are spread (flow/fixed.c). */
#define SPREAD(operand) ((operand).spread)
/* Weights that are always zero. */
#define ABSENT(weight) (SALTUS_WIDE && fixed_absent[weight])
/* Elements that are needed only at their own order: all orders share one place. */
#define PASSING(operand) (fixed_passing[(operand)->place[1]])
#else
#define TAPE_OF(loaded) ((loaded)->tape)
#define SPREAD(operand) false
#define ABSENT(weight) false
#define PASSING(operand) false
#endif

enum { model_rows_common = 0, model_rows_varied = 0, model_rows_plain = 2 };
#define model_common_terms(rows) 0u

enum {
    model_series_count = 0,
    model_drives = 0,
    model_tables = 0,
    model_vary_drives = 0,
    model_rows_ahead = 0,
    model_columns_apart = false,
    model_abreast = 1
};

/* The forcing is on the tape, and parameter columns are tangent vectors for which the weights vary, too. */
#define model_load(w, lane, system) ((void)0)
#define model_forcing(f, order, sine, cosine) ((void)(order))
#define model_vary_forcing(f, d, order, sine, cosine) ((void)0)
#define model_source(f, k, c, d, inverse, next) ((void)0)

/* The parameter direction of a column; negative for the trajectory and ordinary tangent vectors. */
KERNEL_INLINE int direction_of(frame f, int c) {
    return f.directions - 1 - (f.columns - c);
}

/* Row elements per pack. */
enum { ELEMENTS = SALTUS_WIDE ? 1 : SALTUS_PACK, SHARES_MAX = SALTUS_PACK_REGISTERS >= 32 ? 5 : 2 };
typedef double loose_pack __attribute__((vector_size(8 * SALTUS_PACK), may_alias, aligned(8)));

/* The interpreter of a tape: coefficients of all elements, [order][column][element], and the weights. */
typedef struct player {
    const saltus_tape *tape;
    saltus_operation_function *value;
    lane_t *base, *passing;
    const lane_t *weights, *rates; /* `rates`: the weights' derivatives, for parameter columns */
    long column, order;            /* strides */
    int columns, directions;
} player;

KERNEL_INLINE player make_player(frame f) {
    const saltus_tape *tape = TAPE_OF(&f.loaded);
    const long elements = tape->elements[SALTUS_WIDE];
    return (player){.tape = tape,
                    .value = f.loaded.value,
                    .base = NUMBERS(f.model.series),
                    .passing = f.passing,
                    .weights = NUMBERS(f.loaded.weights),
                    .rates = NUMBERS(f.vary.weights),
                    .column = elements,
                    .order = elements * (1 + f.columns),
                    .columns = f.columns,
                    .directions = f.directions};
}

/* An operand's coefficient k in a column. The order is added first: if the places are constants, the compiler
 * then sees that one row reads what the previous one has just written. */
KERNEL_INLINE lane_t *series_of(const player *m, const saltus_tape_operand *x, int c, int k) {
    lane_t *start = PASSING(x) ? m->passing : m->base + k * m->order;
    return start + (x->place[SALTUS_WIDE] + c * m->column);
}

/* What varies in a column, as bits: the state, or everything along a parameter direction. */
KERNEL_INLINE unsigned changes_of(const player *m, int c) {
    return c > m->columns - m->directions ? ~0u : (unsigned)SALTUS_OF_STATES;
}

KERNEL_INLINE saltus_pack load_pack(const lane_t *x, bool spread, int p) {
    if (spread)
        return lane_spread(*x);
    return (saltus_pack) * (const loose_pack *)(const void *)(x + p * ELEMENTS);
}

/* Zeroes the padding beyond a row's last element. */
KERNEL_INLINE void store_pack(lane_t *x, bool spread, int p, int count, saltus_pack value) {
    if (spread) {
        *x = lane_of(value);
        return;
    }
#if !SALTUS_WIDE
    static const unsigned long long all[2 * SALTUS_PACK_MAX] = {~0ULL, ~0ULL, ~0ULL, ~0ULL,
                                                                ~0ULL, ~0ULL, ~0ULL, ~0ULL};
    typedef unsigned long long loose_word
        __attribute__((vector_size(8 * SALTUS_PACK), may_alias, aligned(8)));
    const int left = count - p * ELEMENTS;
    const saltus_pack_word mask =
        (saltus_pack_word) *
        (const loose_word *)(const void *)(all + (left < ELEMENTS ? SALTUS_PACK_MAX - left
                                                                  : SALTUS_PACK_MAX - ELEMENTS));
    value = (saltus_pack)((saltus_pack_word)value & mask);
#else
    (void)count;
#endif
    *(loose_pack *)(void *)(x + p * ELEMENTS) = (loose_pack)value;
}

/* Add sums of a_i b_{k-i} over i = first .. last for some packs, in two chains. If the sum includes both
 * ends, it adds them last: they are the newest. */
KERNEL_INLINE void convolve(const lane_t *a, bool spread_a, const lane_t *b, bool spread_b, long order, int k,
                            int first, int last, int p, const int count, saltus_pack *sum) {
    a += spread_a ? 0 : p * ELEMENTS;
    b += spread_b ? 0 : p * ELEMENTS;
    saltus_pack other[SHARES_MAX];
    const bool newest = first == 0 && last == k && k > 0;
    const lane_t *x = a + (first + newest) * order, *y = b + (k - first - newest) * order;
    int left = last - first + 1 - 2 * newest;
    for (int j = 0; j < count; j++)
        other[j] = (saltus_pack){0};
    for (; left > 1; left -= 2, x += 2 * order, y -= 2 * order)
        for (int j = 0; j < count; j++) {
            sum[j] = saltus_pack_fma(load_pack(x, spread_a, j), load_pack(y, spread_b, j), sum[j]);
            other[j] = saltus_pack_fma(load_pack(x + order, spread_a, j), load_pack(y - order, spread_b, j),
                                       other[j]);
        }
    for (int j = 0; j < count; j++) {
        if (left > 0)
            sum[j] = saltus_pack_fma(load_pack(x, spread_a, j), load_pack(y, spread_b, j), sum[j]);
        sum[j] += other[j];
        if (newest) {
            sum[j] =
                saltus_pack_fma(load_pack(a + k * order, spread_a, j), load_pack(b, spread_b, j), sum[j]);
            sum[j] =
                saltus_pack_fma(load_pack(a, spread_a, j), load_pack(b + k * order, spread_b, j), sum[j]);
        }
    }
}

/* The inner terms a_i b_{k-i}, 0 < i < k, of a product's coefficient k and of coefficient k + 1, whose inner
 * terms are already known: one pass over the older coefficients serves both. Here and below conditions stand
 * outside loops over packs: a loop with two possible ends is unrolled too late, its arrays stay in memory. */
KERNEL_INLINE void convolve_two(const lane_t *a, bool spread, const lane_t *b, bool spread_b, long order,
                                int k, const int count, saltus_pack *now, saltus_pack *next) {
    const lane_t *x = a + order, *y = b + k * order;
    saltus_pack later[SHARES_MAX];
    for (int j = 0; j < count; j++)
        later[j] = load_pack(y, spread_b, j);
    for (int i = 1; i < k; i++, x += order) {
        y -= order;
        for (int j = 0; j < count; j++) {
            const saltus_pack one = load_pack(x, spread, j);
            next[j] = saltus_pack_fma(one, later[j], next[j]);
            later[j] = load_pack(y, spread_b, j);
            now[j] = saltus_pack_fma(one, later[j], now[j]);
        }
    }
    if (k > 0)
        for (int j = 0; j < count; j++)
            next[j] = saltus_pack_fma(load_pack(x, spread, j), later[j], next[j]);
}

/* The same for half of a square: a_i a_{n-i}, 0 < i < n / 2, plus half of the middle term. */
KERNEL_INLINE void square_two(const lane_t *a, bool spread, long order, int n, const int count,
                              saltus_pack *now, saltus_pack *next) {
    const lane_t *x = a + order, *y = a + n * order;
    saltus_pack later[SHARES_MAX];
    for (int j = 0; j < count; j++)
        later[j] = load_pack(y, spread, j);
    for (int i = 1; i <= (n - 1) / 2; i++, x += order) {
        y -= order;
        for (int j = 0; j < count; j++) {
            const saltus_pack one = load_pack(x, spread, j);
            next[j] = saltus_pack_fma(one, later[j], next[j]);
            later[j] = load_pack(y, spread, j);
            now[j] = saltus_pack_fma(one, later[j], now[j]);
        }
    }
    if (n > 0)
        for (int j = 0; j < count; j++) {
            const saltus_pack middle = load_pack(x, spread, j);
            if (n % 2 == 0) {
                next[j] = saltus_pack_fma(middle, later[j], next[j]);
                now[j] = saltus_pack_fma(0.5 * middle, middle, now[j]);
            } else
                next[j] = saltus_pack_fma(0.5 * middle, middle, next[j]);
        }
}

/* A factor of a product: a column of an operand. */
typedef struct factor {
    const saltus_tape_operand *of;
    int column;
    bool spread;
} factor;

KERNEL_INLINE const lane_t *factor_at(const player *m, factor a, int k, int p) {
    return series_of(m, a.of, a.column, k) + (a.spread ? 0 : p * ELEMENTS);
}

/* Add the two newest terms of a product's coefficient k, last the one with `late`'s newest, and store it. */
KERNEL_INLINE void finish_product(const player *m, const saltus_tape_row *s, int c, factor early, factor late,
                                  int k, int p, const int count, saltus_pack *now) {
    lane_t *out = series_of(m, &s->out, c, k);
    const lane_t *early_first = factor_at(m, early, 0, p), *late_first = factor_at(m, late, 0, p),
                 *early_last = factor_at(m, early, k, p), *late_last = factor_at(m, late, k, p);
    for (int j = 0; j < count; j++) {
        if (k > 0)
            now[j] = saltus_pack_fma(load_pack(early_last, early.spread, j),
                                     load_pack(late_first, late.spread, j), now[j]);
        store_pack(out, SPREAD(s->out), p + j, s->count,
                   saltus_pack_fma(load_pack(early_first, early.spread, j),
                                   load_pack(late_last, late.spread, j), now[j]));
    }
}

/* Coefficient k of a product, into a column of a row. An even order also stores the inner terms of the next
 * order in the place of that coefficient. */
KERNEL_INLINE void product_packs(const player *m, const saltus_tape_row *s, int c, factor a, factor b, int k,
                                 int p, const int count) {
    saltus_pack now[SHARES_MAX] = {{0}}, next[SHARES_MAX] = {{0}};
    if (k % 2)
        for (int j = 0; j < count; j++)
            now[j] = load_pack(series_of(m, &s->out, c, k), SPREAD(s->out), p + j);
    else {
        convolve_two(factor_at(m, a, 0, p), a.spread, factor_at(m, b, 0, p), b.spread, m->order, k, count,
                     now, next);
        for (int j = 0; j < count; j++)
            store_pack(series_of(m, &s->out, c, k + 1), SPREAD(s->out), p + j, s->count, next[j]);
    }
    if (s->turned)
        finish_product(m, s, c, b, a, k, p, count, now);
    else
        finish_product(m, s, c, a, b, k, p, count, now);
}

/* Run a statement for all packs of a row, `share` of them at a time. */
#define FOR_SHARES(row, statement)                                                                           \
    do {                                                                                                     \
        const int packs = (int)((unsigned)((row)->count + ELEMENTS - 1) / ELEMENTS);                         \
        int p = 0;                                                                                           \
        for (; p + SHARES_MAX <= packs; p += SHARES_MAX) {                                                   \
            const int share = SHARES_MAX;                                                                    \
            statement;                                                                                       \
        }                                                                                                    \
        for (; p + 2 <= packs; p += 2) {                                                                     \
            const int share = 2;                                                                             \
            statement;                                                                                       \
        }                                                                                                    \
        if (p < packs) {                                                                                     \
            const int share = 1;                                                                             \
            statement;                                                                                       \
        }                                                                                                    \
    } while (0)

KERNEL_INLINE void multiply_packs(const player *m, const saltus_tape_row *s, bool spread, int k, int p,
                                  const int share) {
    product_packs(m, s, 0, (factor){&s->a, 0, spread}, (factor){&s->b, 0, SPREAD(s->b)}, k, p, share);
}

/* A square's coefficient k, or with `rate` half of (k + 1) times its coefficient k + 1. */
KERNEL_INLINE void square_packs(const player *m, const saltus_tape_row *s, bool rate, int k, int p,
                                const int share) {
    saltus_pack now[SHARES_MAX] = {{0}}, next[SHARES_MAX] = {{0}};
    lane_t *out = series_of(m, &s->out, 0, k);
    const lane_t *a = series_of(m, &s->a, 0, 0) + p * ELEMENTS;
    const int n = k + rate;
    if (k % 2)
        for (int j = 0; j < share; j++)
            now[j] = load_pack(out, SPREAD(s->out), p + j);
    else {
        square_two(a, SPREAD(s->a), m->order, n, share, now, next);
        for (int j = 0; j < share; j++)
            store_pack(series_of(m, &s->out, 0, k + 1), SPREAD(s->out), p + j, s->count, next[j]);
    }
    const double factor = rate ? n : 2.0;
    for (int j = 0; j < share; j++) {
        const saltus_pack ends = load_pack(a, SPREAD(s->a), j) * (n ? factor : 1.0);
        store_pack(out, SPREAD(s->out), p + j, s->count,
                   saltus_pack_fma(ends, load_pack(series_of(m, &s->a, 0, n), SPREAD(s->a), p + j),
                                   now[j] * factor));
    }
}

/* Number of weights per term. */
KERNEL_INLINE int weight_span(const saltus_tape_row *s) {
    return SALTUS_WIDE ? s->count : (s->count + SALTUS_PACK_MAX - 1) & -SALTUS_PACK_MAX;
}

/* sum = onto + weights * elements. */
KERNEL_INLINE void add_term(const lane_t *weights, int place, const lane_t *x, bool spread, const int count,
                            const saltus_pack *onto, saltus_pack *sum) {
    for (int j = 0; j < count; j++) {
        sum[j] = onto[j];
        if (!ABSENT(place + j))
            sum[j] = saltus_pack_fma(load_pack(weights + place, false, j), load_pack(x, spread, j), sum[j]);
    }
}

/* Add sums of weights times elements, of a column or the trajectory, in two chains that meet before the last
 * term. The terms are in groups (weights alone, spread elements, pieces of rows), in each the newest last.
 * Terms that depend on nothing in `changes` have no series and are skipped. `begun`: the sums hold
 * something. */
KERNEL_INLINE void combine_packs(const player *m, const saltus_tape_row *s, const lane_t *weights, int c,
                                 int k, bool constant, unsigned changes, int p, const int count, bool begun,
                                 saltus_pack *sum) {
    const saltus_tape_row_term *term = m->tape->row_terms + s->first;
    const int span = weight_span(s), last = s->terms - 1;
    int weight = s->weight[SALTUS_WIDE] + p * ELEMENTS;
    saltus_pack other[SHARES_MAX] = {{0}};
    int t = 0, chains = begun;
    for (; t < s->numbers; t++, weight += span) {
        chains = 1;
        if (constant)
            for (int j = 0; j < count; j++)
                sum[j] += load_pack(weights + weight, false, j);
    }
    for (; t < last; t++, weight += span) {
        const lane_t *x = series_of(m, &term[t], c, k);
        saltus_pack next[SHARES_MAX];
        if (changes != ~0u && !(term[t].depends & changes))
            continue;
        if (t < s->spread_terms)
            add_term(weights, weight, x, true, count, other, next);
        else
            add_term(weights, weight, x + p * ELEMENTS, SPREAD(s->out), count, other, next);
        for (int j = 0; j < count; j++) {
            other[j] = sum[j];
            sum[j] = next[j];
        }
        chains++;
    }
    if (chains > 1)
        for (int j = 0; j < count; j++)
            sum[j] += other[j];
    /* If terms with zero weights are left out, no zero may have kept its sign. */
    if (s->sparse)
        for (int j = 0; j < count; j++)
            sum[j] += (saltus_pack){0};
    if (t > last || (changes != ~0u && !(term[t].depends & changes)))
        return;
    const lane_t *x = series_of(m, &term[t], c, k);
    if (t < s->spread_terms)
        add_term(weights, weight, x, true, count, sum, sum);
    else
        add_term(weights, weight, x + p * ELEMENTS, SPREAD(s->out), count, sum, sum);
}

/* A combination whose elements are summed up, in a fixed tree. */
KERNEL_INLINE lane_t total_packs(const player *m, const saltus_tape_row *s, const lane_t *weights, int c,
                                 int k, bool constant, unsigned changes) {
    saltus_pack all[ROW_PACKS_MAX];
    const int packs = (int)((unsigned)(s->count + ELEMENTS - 1) / ELEMENTS);
    for (int p = 0; p < packs; p++) {
        all[p] = (saltus_pack){0};
        combine_packs(m, s, weights, c, k, constant, changes, p, 1, false, &all[p]);
    }
    return row_total(all, s->count, packs);
}

KERNEL_INLINE void play_combination(const player *m, const saltus_tape_row *s, int k, int p,
                                    const int share) {
    saltus_pack sum[SHARES_MAX] = {{0}};
    lane_t *out = series_of(m, &s->out, 0, k);
    combine_packs(m, s, m->weights, 0, k, k == 0, ~0u, p, share, false, sum);
    for (int j = 0; j < share; j++)
        store_pack(out, SPREAD(s->out), p + j, s->count, sum[j]);
}

/* Sum of i a_i b_{k-i}, i = 1 .. last, for one element. */
KERNEL_INLINE lane_t convolve_rate(const lane_t *a, const lane_t *b, long order, int k, int last) {
    lane_t sum[2] = {lane_constant(0), lane_constant(0)};
    for (int i = 1; i <= last; i++)
        sum[i % 2] = lane_fma(a[i * order] * (double)i, b[(k - i) * order], sum[i % 2]);
    return sum[0] + sum[1];
}

KERNEL_INLINE void turn(lane_t phase, lane_t *sine, lane_t *cosine);

static lane_t function_value(saltus_operation_function *value, saltus_operation operation, lane_t a,
                             lane_t b) {
    double *first = (double *)&a;
    const double *second = (const double *)&b;
    for (int l = 0; l < LANES; l++)
        first[l] = value(operation, (const double[4]){first[l], second[l], 0, 0});
    return a;
}

KERNEL_INLINE void play_function(const player *m, const saltus_tape_row *s, int k) {
    const lane_t *a = series_of(m, &s->a, 0, 0), *b = series_of(m, &s->b, 0, 0);
    lane_t *out = series_of(m, &s->out, 0, k);
    if (k == 0) {
        *out = function_value(m->value, s->function, *a, s->paired ? *series_of(m, &s->a2, 0, 0) : *a);
        return;
    }
    lane_t sum = convolve_rate(a, b, m->order, k, s->linear ? 1 : k);
    if (s->paired)
        sum += convolve_rate(series_of(m, &s->a2, 0, 0), series_of(m, &s->b2, 0, 0), m->order, k, k);
    *out = sum * (s->sign / k);
}

/* Sine and cosine of a_0 + a_1 t, coefficients first .. last - 1. */
KERNEL_INLINE void play_SINE(const player *m, const saltus_tape_row *s, int first, int last) {
    const lane_t *a = series_of(m, &s->a, 0, 0);
    lane_t *sine = series_of(m, &s->out, 0, 0), *cosine = series_of(m, &s->b, 0, 0);
    if (first == 0)
        turn(*a * 0.15915494309189533577, sine, cosine);
    const int start = first > 0 ? first : 1;
    const lane_t rate = a[m->order];
    lane_t one = sine[(start - 1) * m->order], other = cosine[(start - 1) * m->order];
    for (int k = start; k < last; k++) {
        const lane_t part = rate * (1.0 / k), before = one;
        sine[k * m->order] = one = part * other;
        cosine[k * m->order] = other = -part * before;
    }
}

KERNEL_INLINE void play_divide(const player *m, const saltus_tape_row *s, int k) {
    const lane_t *a = series_of(m, &s->a, 0, k), *b = series_of(m, &s->b, 0, 0);
    lane_t *out = series_of(m, &s->out, 0, 0);
    for (int p = 0; p * ELEMENTS < s->count; p++) {
        saltus_pack sum[1] = {{0}};
        if (k > 0)
            convolve(out, SPREAD(s->out), b, s->b.spread, m->order, k, 0, k - 1, p, 1, sum);
        store_pack(series_of(m, &s->out, 0, k), SPREAD(s->out), p, s->count,
                   (load_pack(a, s->a.spread, p) - sum[0]) / load_pack(b, s->b.spread, p));
    }
}

KERNEL_INLINE void play_integral(const player *m, const saltus_tape_row *s, int k) {
    const lane_t *before = series_of(m, &s->b, 0, k - 1);
    lane_t *out = series_of(m, &s->out, 0, k);
    for (int p = 0; p * ELEMENTS < s->count; p++) {
        const saltus_pack start = load_pack(series_of(m, &s->a, 0, 0), SPREAD(s->a), p);
        store_pack(out, SPREAD(s->out), p, s->count,
                   k ? load_pack(before, SPREAD(s->b), p) * (2.0 / k) : start * start);
    }
}

KERNEL_INLINE void play_choice(const player *m, const saltus_tape_row *s, int k) {
    *series_of(m, &s->out, 0, k) = lane_if_less(lane_constant(0), m->weights[s->weight[SALTUS_WIDE]],
                                                *series_of(m, &s->a, 0, k), *series_of(m, &s->b, 0, k));
}

KERNEL_INLINE void play_gathering(const player *m, const saltus_tape_row *s, int k) {
    for (int e = 0; e < s->count; e++)
        series_of(m, &s->out, 0, k)[e] = *series_of(m, &m->tape->row_terms[s->first + e], 0, k);
}

/* Coefficients first .. last - 1 of a row, for the trajectory: one function per kind of row. */
#define PLAY_KIND(kind, statement)                                                                           \
    KERNEL_INLINE void play_##kind(const player *m, const saltus_tape_row *s, int first, int last) {         \
        for (int k = first; k < last; k++)                                                                   \
            statement;                                                                                       \
    }
PLAY_KIND(RATE, FOR_SHARES(s, square_packs(m, s, true, k, p, share)))
PLAY_KIND(SQUARE, FOR_SHARES(s, square_packs(m, s, false, k, p, share)))
PLAY_KIND(INTEGRAL, play_integral(m, s, k))
PLAY_KIND(DIVIDE, play_divide(m, s, k))
PLAY_KIND(CHOOSE, play_choice(m, s, k))
PLAY_KIND(FUNCTION, play_function(m, s, k))
PLAY_KIND(TOTAL, *series_of(m, &s->out, 0, k) = total_packs(m, s, m->weights, 0, k, k == 0, ~0u))
PLAY_KIND(GATHER, play_gathering(m, s, k))
PLAY_KIND(LINEAR, FOR_SHARES(s, play_combination(m, s, k, p, share)))
PLAY_KIND(SCALED, FOR_SHARES(s, multiply_packs(m, s, true, k, p, share)))
PLAY_KIND(PRODUCT, FOR_SHARES(s, multiply_packs(m, s, false, k, p, share)))

KERNEL_INLINE void play_COMBINE(const player *m, const saltus_tape_row *s, int first, int last) {
    play_LINEAR(m, s, first, s->linear && last > 2 ? 2 : last);
}

KERNEL_INLINE void play_MULTIPLY(const player *m, const saltus_tape_row *s, int first, int last) {
    if (s->a.spread)
        play_SCALED(m, s, first, last);
    else
        play_PRODUCT(m, s, first, last);
}

KERNEL_INLINE void vary_combination(const player *m, const saltus_tape_row *s, int k, int c, int p,
                                    const int share) {
    const int direction = c - 1 - (m->columns - m->directions);
    saltus_pack sum[SHARES_MAX] = {{0}};
    combine_packs(m, s, m->weights, c, k, false, changes_of(m, c), p, share, false, sum);
    if (direction >= 0)
        combine_packs(m, s, m->rates + (long)direction * m->tape->weights[SALTUS_WIDE], 0, k, k == 0, ~0u, p,
                      share, true, sum);
    for (int j = 0; j < share; j++)
        store_pack(series_of(m, &s->out, c, k), SPREAD(s->out), p + j, s->count, sum[j]);
}

KERNEL_INLINE void vary_total(const player *m, const saltus_tape_row *s, int k, int c) {
    const int direction = c - 1 - (m->columns - m->directions);
    lane_t sum = total_packs(m, s, m->weights, c, k, false, changes_of(m, c));
    if (direction >= 0)
        sum +=
            total_packs(m, s, m->rates + (long)direction * m->tape->weights[SALTUS_WIDE], 0, k, k == 0, ~0u);
    *series_of(m, &s->out, c, k) = sum;
}

/* da b + db a. */
KERNEL_INLINE void vary_product(const player *m, const saltus_tape_row *s, bool spread, int k, int c, int p,
                                const int share) {
    const unsigned changes = changes_of(m, c);
    const factor a = {&s->a, 0, spread}, own_a = {&s->a, c, spread}, b = {&s->b, 0, SPREAD(s->b)},
                 own_b = {&s->b, c, SPREAD(s->b)};
    saltus_pack sum[SHARES_MAX] = {{0}};
    if (!(s->b.depends & changes))
        product_packs(m, s, c, own_a, b, k, p, share);
    else if (!(s->a.depends & changes))
        product_packs(m, s, c, a, own_b, k, p, share);
    else {
        convolve(factor_at(m, own_a, 0, 0), spread, factor_at(m, b, 0, 0), b.spread, m->order, k, 0, k, p,
                 share, sum);
        convolve(factor_at(m, a, 0, 0), spread, factor_at(m, own_b, 0, 0), b.spread, m->order, k, 0, k, p,
                 share, sum);
        for (int j = 0; j < share; j++)
            store_pack(series_of(m, &s->out, c, k), SPREAD(s->out), p + j, s->count, sum[j]);
    }
}

/* a da times 2, or with `rate` times k + 1, as in square_packs. */
KERNEL_INLINE void vary_square(const player *m, const saltus_tape_row *s, bool rate, int k, int c, int p,
                               const int share) {
    saltus_pack now[SHARES_MAX] = {{0}}, next[SHARES_MAX] = {{0}};
    lane_t *out = series_of(m, &s->out, c, k);
    const lane_t *a = series_of(m, &s->a, 0, 0) + p * ELEMENTS,
                 *own = series_of(m, &s->a, c, 0) + p * ELEMENTS;
    const int n = k + rate;
    if (k % 2)
        for (int j = 0; j < share; j++)
            now[j] = load_pack(out, SPREAD(s->out), p + j);
    else {
        convolve_two(a, SPREAD(s->a), own, SPREAD(s->a), m->order, n, share, now, next);
        for (int j = 0; j < share; j++)
            store_pack(series_of(m, &s->out, c, k + 1), SPREAD(s->out), p + j, s->count, next[j]);
    }
    const double factor = rate ? n : 2.0;
    for (int j = 0; j < share; j++) {
        now[j] *= factor;
        if (n > 0)
            now[j] = saltus_pack_fma(load_pack(series_of(m, &s->a, 0, n), SPREAD(s->a), p + j),
                                     load_pack(own, SPREAD(s->a), j) * factor, now[j]);
        store_pack(out, SPREAD(s->out), p + j, s->count,
                   saltus_pack_fma(load_pack(a, SPREAD(s->a), j) * factor,
                                   load_pack(series_of(m, &s->a, c, n), SPREAD(s->a), p + j), now[j]));
    }
}

KERNEL_INLINE void vary_divide(const player *m, const saltus_tape_row *s, int k, int c) {
    const unsigned changes = changes_of(m, c);
    const lane_t *b = series_of(m, &s->b, 0, 0);
    lane_t *out = series_of(m, &s->out, c, 0);
    for (int p = 0; p * ELEMENTS < s->count; p++) {
        saltus_pack sum = {0}, part[1] = {{0}};
        if (s->a.depends & changes)
            sum = load_pack(series_of(m, &s->a, c, k), s->a.spread, p);
        if (s->b.depends & changes)
            convolve(series_of(m, &s->out, 0, 0), SPREAD(s->out), series_of(m, &s->b, c, 0), s->b.spread,
                     m->order, k, 0, k, p, 1, part);
        if (k > 0)
            convolve(out, SPREAD(s->out), b, s->b.spread, m->order, k, 0, k - 1, p, 1, part);
        store_pack(series_of(m, &s->out, c, k), SPREAD(s->out), p, s->count,
                   (sum - part[0]) / load_pack(b, s->b.spread, p));
    }
}

/* Sum of a_i b_{k-i}, for one element. */
KERNEL_INLINE lane_t convolve_one(const lane_t *a, const lane_t *b, long order, int k) {
    lane_t sum[2] = {lane_constant(0), lane_constant(0)};
    for (int i = 0; i <= k; i++)
        sum[i % 2] = lane_fma(a[i * order], b[(k - i) * order], sum[i % 2]);
    return sum[0] + sum[1];
}

KERNEL_INLINE void vary_function(const player *m, const saltus_tape_row *s, int k, int c) {
    const unsigned changes = changes_of(m, c);
    lane_t sum = lane_constant(0);
    if (s->a.depends & changes)
        sum = convolve_one(series_of(m, &s->a, c, 0), series_of(m, &s->b, 0, 0), m->order, k);
    if (s->paired && (s->a2.depends & changes))
        sum += convolve_one(series_of(m, &s->a2, c, 0), series_of(m, &s->b2, 0, 0), m->order, k);
    *series_of(m, &s->out, c, k) = sum * s->sign;
}

KERNEL_INLINE void vary_integral(const player *m, const saltus_tape_row *s, int k, int c) {
    const lane_t *a = series_of(m, &s->a, 0, 0), *own = series_of(m, &s->a, c, 0),
                 *before = series_of(m, &s->b, c, k - 1);
    for (int p = 0; p * ELEMENTS < s->count; p++)
        store_pack(series_of(m, &s->out, c, k), SPREAD(s->out), p, s->count,
                   k ? load_pack(before, SPREAD(s->b), p) * (2.0 / k)
                     : 2.0 * load_pack(a, SPREAD(s->a), p) * load_pack(own, SPREAD(s->a), p));
}

KERNEL_INLINE void vary_choice(const player *m, const saltus_tape_row *s, int k, int c) {
    const unsigned changes = changes_of(m, c);
    const lane_t none = lane_constant(0);
    *series_of(m, &s->out, c, k) = lane_if_less(none, m->weights[s->weight[SALTUS_WIDE]],
                                                s->a.depends & changes ? *series_of(m, &s->a, c, k) : none,
                                                s->b.depends & changes ? *series_of(m, &s->b, c, k) : none);
}

KERNEL_INLINE void vary_sine(const player *m, const saltus_tape_row *s, int k, int c) {
    const lane_t *a = series_of(m, &s->a, c, 0);
    *series_of(m, &s->out, c, k) = convolve_one(a, series_of(m, &s->b, 0, 0), m->order, k);
    *series_of(m, &s->b, c, k) = -convolve_one(a, series_of(m, &s->out, 0, 0), m->order, k);
}

KERNEL_INLINE void vary_gathering(const player *m, const saltus_tape_row *s, int k, int c) {
    for (int e = 0; e < s->count; e++) {
        const saltus_tape_operand *from = &m->tape->row_terms[s->first + e];
        series_of(m, &s->out, c, k)[e] =
            from->depends & changes_of(m, c) ? *series_of(m, from, c, k) : lane_constant(0);
    }
}

/* Coefficient k of a row in the tangent columns from `first` on. Operands that do not depend on what varies
 * in a column have no series there. */
#define VARY_KIND(kind, statement)                                                                           \
    KERNEL_INLINE void vary_##kind(const player *m, const saltus_tape_row *s, int k, int first) {            \
        for (int c = first; c <= m->columns; c++)                                                            \
            statement;                                                                                       \
    }
VARY_KIND(COMBINE, FOR_SHARES(s, vary_combination(m, s, k, c, p, share)))
VARY_KIND(RATE, FOR_SHARES(s, vary_square(m, s, true, k, c, p, share)))
VARY_KIND(SQUARE, FOR_SHARES(s, vary_square(m, s, false, k, c, p, share)))
VARY_KIND(INTEGRAL, vary_integral(m, s, k, c))
VARY_KIND(DIVIDE, vary_divide(m, s, k, c))
VARY_KIND(CHOOSE, vary_choice(m, s, k, c))
VARY_KIND(FUNCTION, vary_function(m, s, k, c))
VARY_KIND(SINE, vary_sine(m, s, k, c))
VARY_KIND(TOTAL, vary_total(m, s, k, c))
VARY_KIND(GATHER, vary_gathering(m, s, k, c))
VARY_KIND(SCALED, FOR_SHARES(s, vary_product(m, s, true, k, c, p, share)))
VARY_KIND(PRODUCT, FOR_SHARES(s, vary_product(m, s, false, k, c, p, share)))

KERNEL_INLINE void vary_MULTIPLY(const player *m, const saltus_tape_row *s, int k, int first) {
    if (s->a.spread)
        vary_SCALED(m, s, k, first);
    else
        vary_PRODUCT(m, s, k, first);
}

#ifdef SALTUS_FIXED_TAPE
#define PLAY_FIXED(kind, row) play_##kind(m, &fixed_rows[row], from, to);
#define VARY_FIXED(kind, row) vary_##kind(m, &fixed_rows[row], k, first);
KERNEL_INLINE void play_steady_rows(const player *m, int from, int to) {
    (void)m, (void)from, (void)to;
    SALTUS_FIXED_STEADY(PLAY_FIXED)
}
KERNEL_INLINE void play_state_rows(const player *m, int from, int to){
    SALTUS_FIXED_ROWS(PLAY_FIXED)} KERNEL_INLINE void vary_rows(const player *m, int k) {
    int first = m->columns - m->directions + 1;
    if (m->directions) {
        SALTUS_FIXED_STEADY(VARY_FIXED)
    }
    first = 1;
    SALTUS_FIXED_ROWS(VARY_FIXED)
}
#else
#define KIND(kind)                                                                                           \
    case SALTUS_TAPE_##kind:                                                                                 \
        ONE_KIND(kind);                                                                                      \
        break;
/* Rows row .. last - 1, each for the orders from `from` to `to` - 1. The player is passed by value: a store
 * through a pack might alias what a pointer points to. */
static __attribute__((noinline)) void play_rows(const player by_value, int row, int last, int from, int to) {
    const player m = by_value;
    for (const saltus_tape_row *s = m.tape->rows + row; s < m.tape->rows + last; s++)
#define ONE_KIND(kind) play_##kind(&m, s, from, to)
        switch (s->code) { SALTUS_TAPE_CODES(KIND) }
#undef ONE_KIND
}

KERNEL_INLINE void play_steady_rows(const player *m, int from, int to) {
    play_rows(*m, 0, m->tape->steady_rows, from, to);
}

KERNEL_INLINE void play_state_rows(const player *m, int from, int to) {
    play_rows(*m, m->tape->steady_rows, m->tape->row_count, from, to);
}

/* Rows that depend on no state vary only along parameter directions. */
static __attribute__((noinline)) void vary_all_rows(const player by_value, int k) {
    const player m = by_value;
    const saltus_tape_row *steady = m.tape->rows + m.tape->steady_rows;
    for (const saltus_tape_row *s = m.directions ? m.tape->rows : steady;
         s < m.tape->rows + m.tape->row_count; s++) {
        const int first = s < steady ? m.columns - m.directions + 1 : 1;
#define ONE_KIND(kind) vary_##kind(&m, s, k, first)
        switch (s->code) { SALTUS_TAPE_CODES(KIND) }
#undef ONE_KIND
    }
}

KERNEL_INLINE void vary_rows(const player *m, int k) {
    vary_all_rows(*m, k);
}
#endif

/* Rows that depend on time alone, for all orders. */
static void play_steady(const player *m, int order) {
    if (!m->tape->steady_by_order)
        play_steady_rows(m, 0, order);
    for (int k = 0; m->tape->steady_by_order && k < order; k++)
        play_steady_rows(m, k, k + 1);
}

/* Set a series that is linear in time: coefficients beyond order 1 are never written. */
KERNEL_INLINE void set_linear(const player *m, const saltus_tape_operand *x, int c, lane_t first,
                              lane_t second) {
    *series_of(m, x, c, 0) = first;
    *series_of(m, x, c, 1) = second;
}

KERNEL_INLINE void place_row(lane_t *to, const saltus_pack *row, int packs) {
    for (int p = 0; p < packs; p++)
        *(loose_pack *)(void *)(to + p * ELEMENTS) = (loose_pack)row[p];
}

/* Store coefficient k of the velocities and k + 1 of the displacements as soon as they are known. */
KERNEL_INLINE void model_place(frame f, int k, int c, const saltus_pack *velocity,
                               const saltus_pack *displacement) {
    const player m = make_player(f);
    place_row(series_of(&m, &m.tape->state[1], c, k), velocity, f.packs);
    place_row(series_of(&m, &m.tape->state[0], c, k + 1), displacement, f.packs);
}

/* Store coefficient k of an extra state. */
KERNEL_INLINE void place_extra(frame f, const player *m, int k, int c, int i, lane_t value) {
    EXTRA(k, c)[i] = series_of(m, &m->tape->state[2], c, k)[i] = value;
}

/* Set the states, and time and phase, which are linear. Along omega, with the phase fixed `elapsed` before
 * this step, the phase moves by elapsed / (2 pi), and time is the phase times T = 2 pi / omega. */
KERNEL_INLINE void model_start(frame f, int c) {
    const player m = make_player(f);
    const int direction = direction_of(f, c);
    const lane_t omega = *SCALAR(0), full = lane_constant(6.28318530717958647693), none = lane_constant(0);
    const lane_t period = full / omega, time = *f.phase * period;
    place_row(series_of(&m, &m.tape->state[0], c, 0), JET(f.q, 0, c), f.packs);
    model_place(f, 0, c, JET(f.v, 0, c), JET(f.v, 0, c));
    for (int i = 0; i < f.extra; i++)
        place_extra(f, &m, 0, c, i, EXTRA(0, c)[i]);
    if (c > 0 && direction < 0)
        return;
    lane_t start = time, rate = omega + none, turned = *f.phase;
    if (c > 0) {
        rate = *VARY_SCALAR(direction, 0);
        start = rate * (*f.elapsed - time) / omega;
        turned = rate * *f.elapsed / full;
    }
    if (m.tape->time.place[0] >= 0)
        set_linear(&m, &m.tape->time, c, start, lane_constant(c == 0));
    if (m.tape->phase.place[0] >= 0)
        set_linear(&m, &m.tape->phase, c, turned, rate / full);
    if (c == 0)
        play_steady(&m, (int)f.orders - 2);
}

/* Coefficient k + 1 of q' and of the extra states, for the trajectory (c = 0) or a tangent vector. The states
 * of all columns are known up to order k by the trajectory's turn, which computes all columns' rows. */
KERNEL_INLINE void model_order(frame f, int k, int c, const int abreast, double inverse, saltus_pack *next) {
    (void)abreast;
    const player m = make_player(f);
    const saltus_tape *tape = m.tape;
    const unsigned changes = changes_of(&m, c);
    if (c == 0) {
        play_state_rows(&m, k, k + 1);
        if (f.columns)
            vary_rows(&m, k);
    }
    for (int p = 0; p < f.packs; p++)
        next[p] = (saltus_pack){0};
    if (tape->output_row && (c == 0 || (tape->outputs[0].depends & changes)))
        for (int p = 0; p < f.packs; p++)
            next[p] =
                load_pack(series_of(&m, &tape->outputs[0], c, k), SPREAD(tape->outputs[0]), p) * inverse;
    for (int i = tape->output_row ? f.dof : 0; i < f.dof + f.extra; i++) {
        const saltus_tape_operand *out = &tape->outputs[i];
        lane_t value = lane_constant(0);
        if (c == 0 || (out->depends & changes))
            value = *series_of(&m, out, c, k) * inverse;
        if (i < f.dof)
            set_row_element(next, i, value);
        else
            place_extra(f, &m, k + 1, c, i - f.dof, value);
    }
}

#endif
