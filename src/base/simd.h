/* Packs: short vectors of doubles, one definition per instruction set. A pack holds either consecutive modes of one
 * trajectory or one mode of several trajectories; the arithmetic is the same, so the bits are too.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_SIMD_H
#define SALTUS_BASE_SIMD_H

#if defined(__AVX512F__)
#include <immintrin.h>
#define SALTUS_PACK 8
#elif defined(__AVX2__) && defined(__FMA__)
#include <immintrin.h>
#define SALTUS_PACK 4
#elif defined(__aarch64__)
#include <arm_neon.h>
#define SALTUS_PACK 2
#else
#define SALTUS_PACK 2
#endif

typedef double saltus_pack __attribute__((vector_size(8 * SALTUS_PACK), may_alias));

/* a * b + c: one rounding where the instruction set has it. */
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

/* c - a * b, rounded as saltus_pack_fma. */
static inline saltus_pack saltus_pack_fnma(saltus_pack a, saltus_pack b, saltus_pack c) {
    return saltus_pack_fma(-a, b, c);
}

/* The scalar twin: the same rounding as one element of saltus_pack_fma. */
static inline double saltus_scalar_fma(double a, double b, double c) {
#if defined(__FMA__) || defined(__aarch64__)
    return __builtin_fma(a, b, c);
#else
    return a * b + c;
#endif
}

static inline saltus_pack saltus_pack_splat(double a) {
    return a - (saltus_pack){0};
}

#endif
