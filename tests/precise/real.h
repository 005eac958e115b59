/* The number of the precise orbits: 113 bits, about 34 digits (libquadmath), or with PRECISE_LONG_DOUBLE the
 * 64 bits of an x86 long double, for a first look at large systems.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PRECISE_REAL_H
#define PRECISE_REAL_H

#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef PRECISE_LONG_DOUBLE
typedef long double real;
typedef _Complex long double complex_real;
#define PRECISE(function) function##l
enum { real_bits = 64, real_columns = 8 };
static inline real real_tolerance(void) {
    return powl(10, -16);
}
static inline real real_read(const char *text) {
    return strtold(text, NULL);
}
static inline void real_print(char *text, size_t size, int digits, real x) {
    snprintf(text, size, "%.*Le", digits, x);
}
#else
#include <quadmath.h>
typedef __float128 real;
typedef __complex128 complex_real;
#define PRECISE(function) function##q
enum { real_bits = 113, real_columns = 12 };
static inline real real_tolerance(void) {
    return powq(10, -30);
}
static inline real real_read(const char *text) {
    return strtoflt128(text, NULL);
}
static inline void real_print(char *text, size_t size, int digits, real x) {
    quadmath_snprintf(text, size, "%.*Qe", digits, x);
}
#endif

static inline real real_max(real a, real b) {
    return a > b ? a : b;
}
static inline real real_min(real a, real b) {
    return a < b ? a : b;
}
static inline real real_abs(real x) {
    return PRECISE(fabs)(x);
}
static inline real real_sqrt(real x) {
    return PRECISE(sqrt)(x);
}
static inline real real_sin(real x) {
    return PRECISE(sin)(x);
}
static inline real real_cos(real x) {
    return PRECISE(cos)(x);
}
static inline real real_pow(real x, real y) {
    return PRECISE(pow)(x, y);
}
static inline real real_hypot(real x, real y) {
    return PRECISE(hypot)(x, y);
}
static inline real real_pi(void) {
    return PRECISE(acos)(-1);
}
static inline real real_modulus(complex_real z) {
    return PRECISE(cabs)(z);
}
static inline real real_part(complex_real z) {
    return PRECISE(creal)(z);
}
static inline real imaginary_part(complex_real z) {
    return PRECISE(cimag)(z);
}
static inline complex_real complex_conjugate(complex_real z) {
    return PRECISE(conj)(z);
}
static inline complex_real complex_root(complex_real z) {
    return PRECISE(csqrt)(z);
}

#endif
