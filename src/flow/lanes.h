/* The two layouts of a row behind one set of names. Included by the kernel template only, once per width.
 *
 *   lane_t           one number per lane: a double at width 1, a pack in the wide kernel
 *   lane_spread(s)   the pack that multiplies a pack of a row by each lane's own number
 *   lane_of(s)       the number per lane of a pack that holds it spread
 *   row_sum          sum over the modes in a fixed tree, the same at every width, spread
 *   row_couple       product with a coupling matrix
 *   lane_largest     the largest of a row's modes, from the largest of each pack element
 *   lane_alternate   numbers for consecutive orders, as many as a pack holds
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_LANES_H
#define SALTUS_FLOW_LANES_H

#include "base/simd.h"

/* Everything in the kernel is inlined, so that the layout's constants reach the inner loops. */
#define KERNEL_INLINE static inline __attribute__((always_inline))

enum { MODES_MAX = 64 };

#if SALTUS_WIDE

#define LANES SALTUS_PACK
enum { ROW_PACKS_MAX = MODES_MAX, ORDERS_PER_PACK = 1 };
typedef saltus_pack lane_t;
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
KERNEL_INLINE double lane_get(const lane_t *s, int lane) {
    return (*s)[lane];
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
KERNEL_INLINE size_t coupling_size(int n) {
    return (size_t)n * (size_t)n;
}
KERNEL_INLINE size_t coupling_place(int n, int i, int j) {
    return (size_t)i * (size_t)n + (size_t)j;
}
KERNEL_INLINE lane_t row_element(const saltus_pack *row, int i) {
    return row[i];
}

/* Terms i, i + 8, i + 16, ... first, then pairs four, two and one apart. */
KERNEL_INLINE saltus_pack row_sum(const saltus_pack *row, int n, int packs) {
    (void)packs;
    lane_t t[8];
    for (int i = 0; i < 8; i++)
        t[i] = i < n ? row[i] : lane_constant(0);
    for (int i = 8; i < n; i++)
        t[i % 8] += row[i];
    for (int half = 4; half > 0; half /= 2)
        for (int i = 0; i < half; i++)
            t[i] += t[i + half];
    return t[0];
}

/* out -= coupling in; the coupling is plain, row-major, and joins modes of opposite parity only. */
KERNEL_INLINE void row_couple(saltus_pack *out, const double *coupling, const saltus_pack *in, int n,
                              int packs) {
    (void)packs;
    for (int i = 0; i < n; i++)
        for (int j = 1 - i % 2; j < n; j += 2)
            out[i] = saltus_pack_fnma(saltus_pack_splat(coupling[i * n + j]), in[j], out[i]);
}

#else

#define LANES 1
enum { ROW_PACKS_MAX = MODES_MAX / SALTUS_PACK, ORDERS_PER_PACK = SALTUS_PACK };
typedef double lane_t;
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
KERNEL_INLINE double lane_get(const lane_t *s, int lane) {
    return s[lane];
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

/* Packs begin at even orders. */
KERNEL_INLINE saltus_pack lane_alternate(lane_t even, lane_t odd, int order) {
    (void)order;
    saltus_pack all;
    for (int i = 0; i < SALTUS_PACK; i++)
        all[i] = i % 2 ? odd : even;
    return all;
}

KERNEL_INLINE saltus_pack row_sum(const saltus_pack *row, int n, int packs) {
    (void)n;
    enum { count = 8 / SALTUS_PACK };
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

/* out -= coupling in. Columns 2 j and 2 j + 1 of the coupling share a row of packs, because each mode is
 * coupled to one parity only; the order of each mode's sum is that of the wide kernel. */
KERNEL_INLINE void row_couple(saltus_pack *out, const double *coupling, const saltus_pack *in, int n,
                              int packs) {
    const saltus_pack *column = (const saltus_pack *)(const void *)coupling;
    for (int block = 0; block < packs; block++)
        for (int pair = 0; pair < SALTUS_PACK / 2 && block * SALTUS_PACK + 2 * pair < n;
             pair++, column += packs) {
            const saltus_pack both = saltus_pack_swapped_pair(in[block], pair);
            for (int p = 0; p < packs; p++)
                out[p] = saltus_pack_fnma(column[p], both, out[p]);
        }
}

#endif

/* Sum of a_i b_i over the modes, spread. */
KERNEL_INLINE saltus_pack row_dot(const saltus_pack *a, const saltus_pack *b, int n, int packs) {
    saltus_pack product[ROW_PACKS_MAX];
    for (int p = 0; p < packs; p++)
        product[p] = a[p] * b[p];
    return row_sum(product, n, packs);
}

/* sum of a_m b_{-m} over first <= m < count: `a` runs up and `b` down a jet whose orders lie `stride` packs
 * apart. Two chains halve the latency. */
KERNEL_INLINE saltus_pack jet_product(const saltus_pack *a, const saltus_pack *b, long stride, int first,
                                      int count) {
    saltus_pack even = {0}, odd = {0};
    int m = first;
    for (a += m * stride, b -= m * stride; m + 1 < count; m += 2, a += 2 * stride, b -= 2 * stride) {
        even = saltus_pack_fma(a[0], b[0], even);
        odd = saltus_pack_fma(a[stride], b[-stride], odd);
    }
    if (m < count)
        even = saltus_pack_fma(a[0], b[0], even);
    return even + odd;
}

#endif
