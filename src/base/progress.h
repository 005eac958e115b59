/* Private: stop requests and progress reports of long calls.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_PROGRESS_H
#define SALTUS_BASE_PROGRESS_H

#include "saltus/status.h"

#include <signal.h>
#include <stdbool.h>
#include <time.h>

/* Whether the flag saltus_flow_options.stop is raised; NULL is accepted. */
static inline bool saltus_stop_asked(const volatile sig_atomic_t *stop) {
    return stop && *stop;
}

/* Seconds of a monotonic clock. */
static inline double saltus_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static inline void saltus_progress_show(saltus_progress progress, double done, double all) {
    if (progress.show)
        progress.show(progress.context, done, all);
}

#endif
