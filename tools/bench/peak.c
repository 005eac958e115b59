/* Peak rate of one core: chains of fused multiply-adds that do not wait for one another.
 *
 * A processor that starts two of them a cycle and finishes each after four or five needs ten chains; twelve
 * fit into the registers of every instruction set. The widest set that this processor has is taken when the
 * program runs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "peak.h"

#include <math.h>
#include <time.h>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

enum { laps = 25000, rounds = 4, chains = 12, repeats = 25 };

static double cpu_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* What a set of instructions does: `laps` times four rounds of twelve chains; returns a sum that keeps them
 * alive. */
typedef struct instruction_set {
    const char *name;
    int width;
    double (*run)(void);
} instruction_set;

#define TWELVE(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10) X(11)
/* Not from 1, the fixed point, at which a compiler could see that a chain is constant. */
#define BEGIN(k) pack x##k = SPREAD(k + 2.0);
#define STEP(k) x##k = MULTIPLY_ADD(x##k, f, a);
#define STORE(k) part[k] = FIRST(x##k);
#define RUN_CHAINS                                                                                           \
    const pack f = SPREAD(0.999999), a = SPREAD(1e-6);                                                       \
    double part[chains], sum = 0;                                                                            \
    TWELVE(BEGIN)                                                                                            \
    for (int lap = 0; lap < laps; lap++) {                                                                   \
        TWELVE(STEP) TWELVE(STEP) TWELVE(STEP) TWELVE(STEP)                                                  \
    }                                                                                                        \
    TWELVE(STORE)                                                                                            \
    for (int k = 0; k < chains; k++)                                                                         \
        sum += part[k];                                                                                      \
    return sum;

#if defined(__x86_64__)

__attribute__((target("avx512f"))) static double run_512(void) {
    typedef __m512d pack;
#define SPREAD(x) _mm512_set1_pd(x)
#define MULTIPLY_ADD(x, y, z) _mm512_fmadd_pd(x, y, z)
#define FIRST(x) _mm512_cvtsd_f64(x)
    RUN_CHAINS
#undef SPREAD
#undef MULTIPLY_ADD
#undef FIRST
}

__attribute__((target("avx2,fma"))) static double run_256(void) {
    typedef __m256d pack;
#define SPREAD(x) _mm256_set1_pd(x)
#define MULTIPLY_ADD(x, y, z) _mm256_fmadd_pd(x, y, z)
#define FIRST(x) _mm256_cvtsd_f64(x)
    RUN_CHAINS
#undef SPREAD
#undef MULTIPLY_ADD
#undef FIRST
}

static double run_128(void) {
    typedef __m128d pack;
#define SPREAD(x) _mm_set1_pd(x)
#define MULTIPLY_ADD(x, y, z) _mm_add_pd(_mm_mul_pd(x, y), z)
#define FIRST(x) _mm_cvtsd_f64(x)
    RUN_CHAINS
#undef SPREAD
#undef MULTIPLY_ADD
#undef FIRST
}

static instruction_set widest(void) {
    if (__builtin_cpu_supports("avx512f"))
        return (instruction_set){"AVX-512", 8, run_512};
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        return (instruction_set){"AVX2", 4, run_256};
    return (instruction_set){"SSE2", 2, run_128};
}

#else

static double run_scalar(void) {
    typedef double pack;
#define SPREAD(x) (x)
#define MULTIPLY_ADD(x, y, z) fma(x, y, z)
#define FIRST(x) (x)
    RUN_CHAINS
#undef SPREAD
#undef MULTIPLY_ADD
#undef FIRST
}

static instruction_set widest(void) {
    return (instruction_set){"scalar", 1, run_scalar};
}

#endif

double bench_peak(const char **instructions) {
    const instruction_set set = widest();
    double least = INFINITY;
    for (int k = 0; k < repeats; k++) {
        double start = cpu_seconds();
        volatile double kept = set.run();
        (void)kept;
        least = fmin(least, cpu_seconds() - start);
    }
    *instructions = set.name;
    return 2.0 * laps * rounds * chains * set.width / least;
}
