/* The two layouts of a row behind one set of names. Included by the kernel template only, once per width.
 *
 *   lane_t           one number per lane: a double at width 1, a pack in the wide kernel
 *   lane_spread(s)   the pack that multiplies a pack of a row by each lane's own number
 *   row_element      one mode of a row, as a lane_t
 *   row_sum          sum over the modes in a fixed tree, the same at every width
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_LANES_H
#define SALTUS_FLOW_LANES_H

#include "base/simd.h"

/* Everything in the kernel is inlined, so that the layout's constants reach the inner loops. */
#define KERNEL_INLINE static inline __attribute__((always_inline))

#if SALTUS_WIDE

#define LANES SALTUS_PACK
typedef saltus_pack lane_t;
KERNEL_INLINE saltus_pack lane_spread(lane_t s) { return s; }
KERNEL_INLINE lane_t lane_constant(double s) { return saltus_pack_splat(s); }
KERNEL_INLINE lane_t lane_fma(lane_t a, lane_t b, lane_t c) { return saltus_pack_fma(a, b, c); }
KERNEL_INLINE double lane_get(const lane_t *s, int lane) { return (*s)[lane]; }
KERNEL_INLINE lane_t row_element(const saltus_pack *row, int i) { return row[i]; }
KERNEL_INLINE int row_packs(int n) { return n; }

/* Terms i, i + 8, i + 16, ... first, then pairs four, two and one apart. */
KERNEL_INLINE lane_t row_sum(const saltus_pack *row, int n, int packs) {
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

/* out = coupling in; the coupling is plain, row-major, and joins modes of opposite parity only. */
KERNEL_INLINE void row_couple(saltus_pack *out, const double *coupling, const saltus_pack *in, int n, int packs) {
    (void)packs;
    for (int i = 0; i < n; i++) {
        saltus_pack sum = lane_constant(0);
        for (int j = 1 - i % 2; j < n; j += 2)
            sum = saltus_pack_fma(saltus_pack_splat(coupling[i * n + j]), in[j], sum);
        out[i] = sum;
    }
}

#else

#define LANES 1
typedef double lane_t;
KERNEL_INLINE saltus_pack lane_spread(lane_t s) { return saltus_pack_splat(s); }
KERNEL_INLINE lane_t lane_constant(double s) { return s; }
KERNEL_INLINE lane_t lane_fma(lane_t a, lane_t b, lane_t c) { return saltus_scalar_fma(a, b, c); }
KERNEL_INLINE double lane_get(const lane_t *s, int lane) {
    (void)lane;
    return *s;
}
KERNEL_INLINE lane_t row_element(const saltus_pack *row, int i) { return ((const double *)row)[i]; }
KERNEL_INLINE int row_packs(int n) { return (n + SALTUS_PACK - 1) / SALTUS_PACK; }

KERNEL_INLINE lane_t row_sum(const saltus_pack *row, int n, int packs) {
    (void)n;
#if SALTUS_PACK == 8
    saltus_pack t = row[0];
    for (int p = 1; p < packs; p++)
        t += row[p];
    t += __builtin_shufflevector(t, t, 4, 5, 6, 7, 0, 1, 2, 3);
    t += __builtin_shufflevector(t, t, 2, 3, 0, 1, 6, 7, 4, 5);
    return t[0] + t[1];
#else
    double t[8] = {0};
    for (int p = 0; p < packs; p++)
        for (int l = 0; l < SALTUS_PACK; l++)
            t[(p * SALTUS_PACK) % 8 + l] += row[p][l];
    for (int half = 4; half > 0; half /= 2)
        for (int i = 0; i < half; i++)
            t[i] += t[i + half];
    return t[0];
#endif
}

/* out = coupling in; the coupling is stored by columns, each a row of packs. A mode is coupled to one parity only, so one
 * of the two chains stays zero for it, and the order of its sum is that of the wide kernel. */
KERNEL_INLINE void row_couple(saltus_pack *out, const double *coupling, const saltus_pack *in, int n, int packs) {
    const saltus_pack *column = (const saltus_pack *)(const void *)coupling;
    for (int p = 0; p < packs; p++) {
        saltus_pack even = {0}, odd = {0};
        int j = 0;
        for (; j + 1 < n; j += 2) {
            even = saltus_pack_fma(column[j * packs + p], saltus_pack_splat(row_element(in, j)), even);
            odd = saltus_pack_fma(column[(j + 1) * packs + p], saltus_pack_splat(row_element(in, j + 1)), odd);
        }
        if (j < n)
            even = saltus_pack_fma(column[j * packs + p], saltus_pack_splat(row_element(in, j)), even);
        out[p] = even + odd;
    }
}

#endif

/* sum of a_m b_{-m} over first <= m < count: `a` runs up and `b` down a jet whose orders lie `stride` packs apart. Two
 * chains halve the latency; terms with the newest coefficients are left to the caller, so that no chain waits. */
KERNEL_INLINE saltus_pack jet_product(const saltus_pack *a, const saltus_pack *b, long stride, int first, int count) {
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

/* The same with one number per lane and order in place of `a`. */
KERNEL_INLINE saltus_pack series_product(const lane_t *a, long a_stride, const saltus_pack *b, long b_stride, int first,
                                         int count) {
    saltus_pack even = {0}, odd = {0};
    int m = first;
    for (a += m * a_stride, b -= m * b_stride; m + 1 < count; m += 2, a += 2 * a_stride, b -= 2 * b_stride) {
        even = saltus_pack_fma(lane_spread(a[0]), b[0], even);
        odd = saltus_pack_fma(lane_spread(a[a_stride]), b[-b_stride], odd);
    }
    if (m < count)
        even = saltus_pack_fma(lane_spread(a[0]), b[0], even);
    return even + odd;
}

#endif
