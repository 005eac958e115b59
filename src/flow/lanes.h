/* The two layouts of a row behind one set of names. Included by the kernel template only, once per width.
 *
 *   lane_t           one number per lane: a double at width 1, a pack in the wide kernel
 *   lane_spread(s)   the pack that multiplies a pack of a row by each lane's own number
 *   lane_of(s)       the number per lane of a pack that holds it spread
 *   row_sum          sum over the modes in a fixed tree, the same at every width, spread
 *   row_total        the same for each lane, without adding zeros only
 *   row_couple       product with a coupling matrix, which joins modes of opposite parity only;
 *   row_couple_two   two products with the same matrix; the second may be absent (NULL)
 *   lane_largest     the largest of a row's modes, from the largest of each pack element
 *   lane_total       sum over the elements of a pack that belong to one lane
 *   lane_alternate   one of two numbers for each order in a pack, by the order's parity
 *   lane_word        the bits of a lane_t
 *   lane_if_less     a < b ? yes : no, lane by lane
 *   lanes_less       the lanes in which a < b, as bits
 *   row_block        how many packs of a row are worked on at once, in registers
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_LANES_H
#define SALTUS_FLOW_LANES_H

#include "base/simd.h"
#include "system/system.h"

/* As few blocks as possible, of nearly equal size, and what is left behind them. If the count is not known
 * when compiling, blocks are as large as can be, and the rest is done one by one. */
KERNEL_INLINE int block_of(int count, int most) {
    const int blocks = (count + most - 1) / most;
    return __builtin_constant_p(count) && blocks ? (count + blocks - 1) / blocks : most;
}

KERNEL_INLINE int rest_of(int count, int block) {
    return __builtin_constant_p(count % block) && count % block ? count % block : 1;
}

#if SALTUS_WIDE

#define LANES SALTUS_PACK
enum { ROW_PACKS_MAX = SALTUS_MODES_MAX, ORDERS_PER_PACK = 1, ORDERS_AT_ONCE = 2, COUPLED_ROWS = 5 };
typedef saltus_pack lane_t;
typedef saltus_pack_word lane_word;
KERNEL_INLINE lane_word lane_bits(lane_t a) {
    return (lane_word)a;
}
KERNEL_INLINE lane_t lane_value(lane_word bits) {
    return (lane_t)bits;
}
KERNEL_INLINE lane_t lane_if_less(lane_t a, lane_t b, lane_t yes, lane_t no) {
    return saltus_pack_if_less(a, b, yes, no);
}
KERNEL_INLINE unsigned lanes_less(lane_t a, lane_t b) {
    return saltus_pack_less(a, b);
}
KERNEL_INLINE saltus_pack lane_spread(lane_t s) {
    return s;
}
KERNEL_INLINE lane_t lane_of(saltus_pack spread) {
    return spread;
}
KERNEL_INLINE lane_t lane_constant(double s) {
    return saltus_pack_splat(s);
}
KERNEL_INLINE lane_t lane_largest(saltus_pack a) {
    return a;
}
KERNEL_INLINE lane_t lane_fma(lane_t a, lane_t b, lane_t c) {
    return saltus_pack_fma(a, b, c);
}
KERNEL_INLINE saltus_pack lane_alternate(lane_t even, lane_t odd, int order) {
    return order % 2 ? odd : even;
}
KERNEL_INLINE int row_packs(int n) {
    return n;
}
/* Column by column, rows of one parity only. */
KERNEL_INLINE size_t coupling_size(int n) {
    return (size_t)n * (size_t)((n + 1) / 2);
}
KERNEL_INLINE size_t coupling_place(int n, int i, int j) {
    return (size_t)(j * ((n + 1) / 2) + i / 2);
}
KERNEL_INLINE lane_t row_element(const saltus_pack *row, int i) {
    return row[i];
}
KERNEL_INLINE void set_row_element(saltus_pack *row, int i, lane_t value) {
    row[i] = value;
}

/* With 8 in the widest pack: first terms i, i + 8, i + 16, ..., then pairs four, two and one apart. Zeros
 * that fill a narrow row up are not added, which at most changes the sign of a zero. */
KERNEL_INLINE saltus_pack row_sum(const saltus_pack *row, int n, int packs) {
    (void)packs;
    lane_t t[SALTUS_PACK_MAX];
    for (int i = 0; i < SALTUS_PACK_MAX; i++)
        t[i] = i < n ? row[i] : lane_constant(0);
    for (int i = SALTUS_PACK_MAX; i < n; i++)
        t[i % SALTUS_PACK_MAX] += row[i];
    for (int half = SALTUS_PACK_MAX / 2; half > 0; half /= 2)
        for (int i = 0; i < half && i + half < n; i++)
            t[i] += t[i + half];
    return t[0];
}

KERNEL_INLINE lane_t row_total(const saltus_pack *row, int n, int packs) {
    (void)packs;
    lane_t t[SALTUS_PACK_MAX];
    for (int i = 0; i < SALTUS_PACK_MAX; i++)
        t[i] = i < n ? row[i] : lane_constant(0);
    for (int i = SALTUS_PACK_MAX; i < n; i++)
        t[i % SALTUS_PACK_MAX] += row[i];
    for (int half = SALTUS_PACK_MAX / 2; half > 0; half /= 2)
        for (int i = 0; i < half && half < n; i++)
            t[i] += t[i + half];
    return t[0];
}

/* Rows i, i + 2, ... (`rows` of them), whose sums do not wait for one another. */
KERNEL_INLINE void row_couple_part(saltus_pack *out, saltus_pack *out2, const double *coupling,
                                   const saltus_pack *in, const saltus_pack *in2, int n, int i,
                                   const int rows) {
    saltus_pack sum[COUPLED_ROWS], sum2[COUPLED_ROWS];
    for (int r = 0; r < rows; r++) {
        sum[r] = out[i + 2 * r];
        if (out2)
            sum2[r] = out2[i + 2 * r];
    }
#pragma GCC unroll 8
    for (int j = 1 - i % 2; j < n; j += 2) {
        const double *column = coupling + coupling_place(n, i, j);
        for (int r = 0; r < rows; r++) {
            const saltus_pack number = saltus_pack_splat(column[r]);
            sum[r] = saltus_pack_fma(number, in[j], sum[r]);
            if (out2)
                sum2[r] = saltus_pack_fma(number, in2[j], sum2[r]);
        }
    }
    for (int r = 0; r < rows; r++) {
        out[i + 2 * r] = sum[r];
        if (out2)
            out2[i + 2 * r] = sum2[r];
    }
}

KERNEL_INLINE void row_couple_parity(saltus_pack *out, saltus_pack *out2, const double *coupling,
                                     const saltus_pack *in, const saltus_pack *in2, int n, const int parity) {
    const int count = (n + 1 - parity) / 2, block = block_of(count, COUPLED_ROWS),
              rest = rest_of(count, block);
    int i = parity;
    for (; i + 2 * (block - 1) < n; i += 2 * block)
        row_couple_part(out, out2, coupling, in, in2, n, i, block);
    if (!__builtin_constant_p(count))
        switch (count % COUPLED_ROWS) {
        case 4:
            row_couple_part(out, out2, coupling, in, in2, n, i, 4);
            return;
        case 3:
            row_couple_part(out, out2, coupling, in, in2, n, i, 3);
            return;
        case 2:
            row_couple_part(out, out2, coupling, in, in2, n, i, 2);
            return;
        default:
            break;
        }
    for (; i < n; i += 2 * rest)
        row_couple_part(out, out2, coupling, in, in2, n, i, rest);
}

/* Both for any number of rows: one function, as it is large. */
static __attribute__((noinline, unused)) void row_couple_any(saltus_pack *out, saltus_pack *out2,
                                                             const double *coupling, const saltus_pack *in,
                                                             const saltus_pack *in2, int n) {
    for (int parity = 0; parity < 2; parity++)
        if (out2)
            row_couple_parity(out, out2, coupling, in, in2, n, parity);
        else
            row_couple_parity(out, NULL, coupling, in, NULL, n, parity);
}

KERNEL_INLINE void row_couple_two(saltus_pack *out, saltus_pack *out2, const double *coupling,
                                  const saltus_pack *in, const saltus_pack *in2, int n, int packs) {
    (void)packs;
    if (!__builtin_constant_p(n) || n > 8) {
        row_couple_any(out, out2, coupling, in, in2, n);
        return;
    }
    row_couple_parity(out, out2, coupling, in, in2, n, 0);
    row_couple_parity(out, out2, coupling, in, in2, n, 1);
}

KERNEL_INLINE lane_t lane_total(saltus_pack a) {
    return a;
}

#else

#define LANES 1
enum {
    ROW_PACKS_MAX = SALTUS_MODES_MAX / SALTUS_PACK,
    ORDERS_PER_PACK = SALTUS_PACK,
    ORDERS_AT_ONCE = SALTUS_PACK
};
typedef double lane_t;
typedef unsigned long long lane_word;
typedef union lane_both {
    double value;
    unsigned long long bits;
} lane_both;
KERNEL_INLINE lane_word lane_bits(lane_t a) {
    return (lane_both){.value = a}.bits;
}
KERNEL_INLINE lane_t lane_value(lane_word bits) {
    return (lane_both){.bits = bits}.value;
}
KERNEL_INLINE lane_t lane_if_less(lane_t a, lane_t b, lane_t yes, lane_t no) {
    return a < b ? yes : no;
}
KERNEL_INLINE unsigned lanes_less(lane_t a, lane_t b) {
    return a < b;
}
KERNEL_INLINE saltus_pack lane_spread(lane_t s) {
    return saltus_pack_splat(s);
}
KERNEL_INLINE lane_t lane_of(saltus_pack spread) {
    return spread[0];
}
KERNEL_INLINE lane_t lane_constant(double s) {
    return s;
}
KERNEL_INLINE lane_t lane_largest(saltus_pack a) {
    return saltus_pack_largest(a);
}
KERNEL_INLINE lane_t lane_fma(lane_t a, lane_t b, lane_t c) {
    return saltus_scalar_fma(a, b, c);
}
KERNEL_INLINE int row_packs(int n) {
    return (n + SALTUS_PACK - 1) / SALTUS_PACK;
}
KERNEL_INLINE size_t row_length(int n) {
    return (size_t)(row_packs(n) * SALTUS_PACK);
}
KERNEL_INLINE size_t coupling_size(int n) {
    return (size_t)(n + 1) / 2 * row_length(n);
}
KERNEL_INLINE size_t coupling_place(int n, int i, int j) {
    return (size_t)(j / 2) * row_length(n) + (size_t)i;
}
KERNEL_INLINE lane_t row_element(const saltus_pack *row, int i) {
    return ((const double *)row)[i];
}
KERNEL_INLINE void set_row_element(saltus_pack *row, int i, lane_t value) {
    row[i / SALTUS_PACK][i % SALTUS_PACK] = value;
}

/* Packs begin at even orders. */
KERNEL_INLINE saltus_pack lane_alternate(lane_t even, lane_t odd, int order) {
    (void)order;
    return saltus_pack_alternate(even, odd);
}

KERNEL_INLINE saltus_pack row_sum(const saltus_pack *row, int n, int packs) {
    (void)n;
    enum { count = SALTUS_PACK_MAX / SALTUS_PACK };
    saltus_pack t[count];
    for (int i = 0; i < count; i++)
        t[i] = i < packs ? row[i] : (saltus_pack){0};
    for (int p = count; p < packs; p++)
        t[p % count] += row[p];
    for (int half = count / 2; half > 0; half /= 2)
        for (int i = 0; i < half; i++)
            t[i] += t[i + half];
    return saltus_pack_sum(t[0]);
}

KERNEL_INLINE lane_t row_total(const saltus_pack *row, int n, int packs) {
    if (n > SALTUS_PACK_MAX / 2)
        return lane_of(row_sum(row, n, packs));
    double t[SALTUS_PACK_MAX / 2];
    for (int i = 0; i < SALTUS_PACK_MAX / 2; i++)
        t[i] = i < n ? row[i / SALTUS_PACK][i % SALTUS_PACK] : 0;
    if (n > 2) {
        t[0] += t[2];
        t[1] += t[3];
    }
    return n > 1 ? t[0] + t[1] : t[0];
}

/* Columns 2 j and 2 j + 1 of the coupling share a row of packs, because each mode couples to one parity only.
 * Each mode's sum has the same order as in the wide kernel. */
KERNEL_INLINE void row_couple_two(saltus_pack *out, saltus_pack *out2, const double *coupling,
                                  const saltus_pack *in, const saltus_pack *in2, int n, int packs) {
    const saltus_pack *column = (const saltus_pack *)(const void *)coupling;
    for (int block = 0; block < packs; block++)
        for (int pair = 0; pair < SALTUS_PACK / 2 && block * SALTUS_PACK + 2 * pair < n;
             pair++, column += packs) {
            const saltus_pack both = saltus_pack_swapped_pair(in[block], pair),
                              both2 = out2 ? saltus_pack_swapped_pair(in2[block], pair) : both;
            for (int p = 0; p < packs; p++) {
                out[p] = saltus_pack_fma(column[p], both, out[p]);
                if (out2)
                    out2[p] = saltus_pack_fma(column[p], both2, out2[p]);
            }
        }
}

KERNEL_INLINE lane_t lane_total(saltus_pack a) {
    return saltus_pack_sum(a)[0];
}

#endif

/* out += coupling in. */
KERNEL_INLINE void row_couple(saltus_pack *out, const double *coupling, const saltus_pack *in, int n,
                              int packs) {
    row_couple_two(out, NULL, coupling, in, NULL, n, packs);
}

KERNEL_INLINE lane_t lane_size(lane_t a) {
    return lane_if_less(a, lane_constant(0), -a, a);
}

KERNEL_INLINE lane_t lane_smaller(lane_t a, lane_t b) {
    return lane_if_less(b, a, b, a);
}

/* Four accumulators for each pack of a row, its coefficient and the series' numbers should fit into the
 * registers. */
enum { ROW_BLOCK_MAX = SALTUS_PACK_REGISTERS >= 32 ? 5 : 2 };
KERNEL_INLINE int row_block(int packs) {
    return block_of(packs, ROW_BLOCK_MAX);
}

/* Run a statement for all packs of a row, a block at a time: packs first .. first + count - 1. The count is a
 * constant if the frame's block is. */
#define FOR_ROW_BLOCKS(f, first, count, statement)                                                           \
    do {                                                                                                     \
        int first = 0;                                                                                       \
        for (; first + (f).block <= (f).packs; first += (f).block) {                                         \
            const int count = (f).block;                                                                     \
            statement;                                                                                       \
        }                                                                                                    \
        for (; first < (f).packs; first += (f).rest) {                                                       \
            const int count = (f).rest;                                                                      \
            statement;                                                                                       \
        }                                                                                                    \
    } while (0)

/* Sum of a_i b_i over the modes, spread. */
KERNEL_INLINE saltus_pack row_dot(const saltus_pack *a, const saltus_pack *b, int n, int packs) {
    saltus_pack product[ROW_PACKS_MAX];
    for (int p = 0; p < packs; p++)
        product[p] = a[p] * b[p];
    return row_sum(product, n, packs);
}

#endif
