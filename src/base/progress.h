/* Private: what a long call asks its caller and tells it on the way.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_PROGRESS_H
#define SALTUS_BASE_PROGRESS_H

#include "saltus/status.h"

#include <signal.h>
#include <stdbool.h>

/* Whether the flag of saltus_flow_options.stop is raised; NULL is accepted. */
static inline bool saltus_stop_asked(const volatile sig_atomic_t *stop) {
    return stop && *stop;
}

static inline void saltus_progress_show(saltus_progress progress, double done, double all) {
    if (progress.show)
        progress.show(progress.context, done, all);
}

#endif
