/* Clocks of the benchmarks.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_CLOCK_H
#define SALTUS_BENCH_CLOCK_H

#include <time.h>

static inline double clock_seconds(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static inline double processor_seconds(void) {
    return clock_seconds(CLOCK_PROCESS_CPUTIME_ID);
}

#endif
