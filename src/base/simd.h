/* Packs: short vectors of doubles, one definition per instruction set. A pack holds either consecutive modes
 * of one trajectory or one mode of several trajectories, with the same arithmetic and hence the same bits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_SIMD_H
#define SALTUS_BASE_SIMD_H

#if defined(__AVX512F__)
#include <immintrin.h>
#define SALTUS_PACK 8
#elif defined(__AVX2__) && defined(__FMA__)
#include <immintrin.h>
#define SALTUS_PACK 4
#else
#if defined(__aarch64__)
#include <arm_neon.h>
#endif
#define SALTUS_PACK 2
#endif

#if defined(__AVX512F__) || defined(__aarch64__)
#define SALTUS_PACK_REGISTERS 32
#else
#define SALTUS_PACK_REGISTERS 16
#endif

/* The widest and the narrowest of all packs. */
enum { SALTUS_PACK_MAX = 8, SALTUS_PACK_MIN = 2 };

/* Everything in a kernel is inlined, so that constants reach the inner loops. */
#define KERNEL_INLINE static inline __attribute__((always_inline))

typedef double saltus_pack __attribute__((vector_size(8 * SALTUS_PACK), may_alias));
typedef unsigned long long saltus_pack_word __attribute__((vector_size(8 * SALTUS_PACK), may_alias));

/* a * b + c, with one rounding if the instruction set has it. */
static inline saltus_pack saltus_pack_fma(saltus_pack a, saltus_pack b, saltus_pack c) {
#if defined(__AVX512F__)
    return (saltus_pack)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)c);
#elif defined(__AVX2__) && defined(__FMA__)
    return (saltus_pack)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c);
#elif defined(__aarch64__)
    return (saltus_pack)vfmaq_f64((float64x2_t)c, (float64x2_t)a, (float64x2_t)b);
#else
    return a * b + c;
#endif
}

/* c - a * b, rounded like saltus_pack_fma. */
static inline saltus_pack saltus_pack_fnma(saltus_pack a, saltus_pack b, saltus_pack c) {
    return saltus_pack_fma(-a, b, c);
}

/* Scalar version, rounded like one element of saltus_pack_fma. */
static inline double saltus_scalar_fma(double a, double b, double c) {
#if defined(__FMA__) || defined(__aarch64__)
    return __builtin_fma(a, b, c);
#else
    return a * b + c;
#endif
}

static inline saltus_pack saltus_pack_splat(double a) {
#if defined(__AVX512F__)
    return (saltus_pack)_mm512_set1_pd(a);
#else
    return a - (saltus_pack){0};
#endif
}

/* even, odd, even, odd, ... */
static inline saltus_pack saltus_pack_alternate(double even, double odd) {
#if defined(__AVX512F__)
    return (saltus_pack)_mm512_mask_blend_pd(0xaa, _mm512_set1_pd(even), _mm512_set1_pd(odd));
#elif defined(__AVX2__) && defined(__FMA__)
    return (saltus_pack)_mm256_blend_pd(_mm256_set1_pd(even), _mm256_set1_pd(odd), 0xa);
#else
    return (saltus_pack){even, odd};
#endif
}

/* A pair of neighbours, swapped and repeated: elements 2 pair + 1, 2 pair, 2 pair + 1, ... */
static inline saltus_pack saltus_pack_swapped_pair(saltus_pack a, int pair) {
#if defined(__AVX512F__)
    static const long long index[4][8] = {{1, 0, 1, 0, 1, 0, 1, 0},
                                          {3, 2, 3, 2, 3, 2, 3, 2},
                                          {5, 4, 5, 4, 5, 4, 5, 4},
                                          {7, 6, 7, 6, 7, 6, 7, 6}};
    return (saltus_pack)_mm512_permutexvar_pd(_mm512_loadu_si512(index[pair]), (__m512d)a);
#elif defined(__AVX2__) && defined(__FMA__)
    __m256d low = _mm256_permute4x64_pd((__m256d)a, 0x11), high = _mm256_permute4x64_pd((__m256d)a, 0xbb);
    return (saltus_pack)(pair ? high : low);
#else
    (void)pair;
    return (saltus_pack){a[1], a[0]};
#endif
}

/* The sum of the elements, in every element. Elements half a pack apart are added first, neighbours last. */
static inline saltus_pack saltus_pack_sum(saltus_pack a) {
#if defined(__AVX512F__)
    saltus_pack half = (saltus_pack)_mm512_shuffle_f64x2((__m512d)a, (__m512d)a, 0x4e);
    saltus_pack pair = (saltus_pack)_mm512_permutex_pd((__m512d)a, 0x4e);
    saltus_pack both = (saltus_pack)_mm512_shuffle_f64x2((__m512d)a, (__m512d)a, 0x1b);
    a = (a + half) + (pair + both);
    a += (saltus_pack)_mm512_permute_pd((__m512d)a, 0x55);
#elif defined(__AVX2__) && defined(__FMA__)
    a += (saltus_pack)_mm256_permute4x64_pd((__m256d)a, 0x4e);
    a += (saltus_pack)_mm256_permute_pd((__m256d)a, 5);
#else
    a += (saltus_pack){a[1], a[0]};
#endif
    return a;
}

/* The sums of the elements of as many packs as a pack has elements, rounded like saltus_pack_sum. */
static inline saltus_pack saltus_pack_sums(const saltus_pack *a) {
#if defined(__AVX512F__)
    __m512d quarter[4], half[2];
    for (int k = 0; k < 4; k++) {
        const __m512d x = (__m512d)a[k / 2 + 4 * (k % 2)], y = (__m512d)a[k / 2 + 4 * (k % 2) + 2];
        quarter[k] = _mm512_shuffle_f64x2(x, y, 0x44) + _mm512_shuffle_f64x2(x, y, 0xee);
    }
    for (int k = 0; k < 2; k++) {
        const __m512d x = quarter[2 * k], y = quarter[2 * k + 1];
        half[k] = _mm512_shuffle_f64x2(x, y, 0x88) + _mm512_shuffle_f64x2(x, y, 0xdd);
    }
    return (saltus_pack)(_mm512_unpacklo_pd(half[0], half[1]) + _mm512_unpackhi_pd(half[0], half[1]));
#else
    saltus_pack sums;
    for (int i = 0; i < SALTUS_PACK; i++)
        sums[i] = saltus_pack_sum(a[i])[0];
    return sums;
#endif
}

/* The larger of a and |b|, element by element; a is not negative. */
static inline saltus_pack saltus_pack_max_size(saltus_pack a, saltus_pack b) {
#if defined(__AVX512F__)
    return (saltus_pack)_mm512_max_pd((__m512d)a, _mm512_abs_pd((__m512d)b));
#elif defined(__AVX2__) && defined(__FMA__)
    return (saltus_pack)_mm256_max_pd((__m256d)a, _mm256_andnot_pd(_mm256_set1_pd(-0.0), (__m256d)b));
#else
    for (int i = 0; i < SALTUS_PACK; i++) {
        double size = __builtin_fabs(b[i]);
        a[i] = size > a[i] ? size : a[i];
    }
    return a;
#endif
}

/* a < b ? yes : no, element by element. */
static inline saltus_pack saltus_pack_if_less(saltus_pack a, saltus_pack b, saltus_pack yes, saltus_pack no) {
#if defined(__AVX512F__)
    __mmask8 less = _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_LT_OQ);
    return (saltus_pack)_mm512_mask_blend_pd(less, (__m512d)no, (__m512d)yes);
#else
    saltus_pack_word less = (saltus_pack_word)(a < b);
    return (saltus_pack)((less & (saltus_pack_word)yes) | (~less & (saltus_pack_word)no));
#endif
}

/* The elements for which a < b, as bits. */
static inline unsigned saltus_pack_less(saltus_pack a, saltus_pack b) {
#if defined(__AVX512F__)
    return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_LT_OQ);
#elif defined(__AVX2__) && defined(__FMA__)
    return (unsigned)_mm256_movemask_pd(_mm256_cmp_pd((__m256d)a, (__m256d)b, _CMP_LT_OQ));
#else
    unsigned less = 0;
    for (int i = 0; i < SALTUS_PACK; i++)
        less |= (unsigned)(a[i] < b[i]) << i;
    return less;
#endif
}

/* The largest element. */
static inline double saltus_pack_largest(saltus_pack a) {
#if defined(__AVX512F__)
    return _mm512_reduce_max_pd((__m512d)a);
#else
    double largest = a[0];
    for (int i = 1; i < SALTUS_PACK; i++)
        largest = a[i] > largest ? a[i] : largest;
    return largest;
#endif
}

#endif
