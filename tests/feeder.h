/* What feeds a sweep in the tests: the tasks in order, the results to a file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_FEEDER_H
#define SALTUS_TESTS_FEEDER_H

#include "saltus/saltus.h"

typedef struct feeder {
    const saltus_sweep *sweep;
    saltus_sweep_output *output;
    long long next;
} feeder;

static inline long long next_task(void *context) {
    feeder *f = context;
    return f->next < saltus_sweep_tasks(f->sweep) ? f->next++ : -1;
}

static inline saltus_status take_result(void *context, const saltus_sweep_result *result,
                                        saltus_message *message) {
    return saltus_sweep_output_take(((feeder *)context)->output, result, message);
}

#endif
