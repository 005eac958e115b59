/* One row of a sweep computed again, to go on from its motion.
 *
 * Rows are the same for any number of lanes and threads, so it suffices to run the row's own task: its point
 * with all seeds, or in a pass up or down the line up to it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <string.h>

/* The row that is wanted, and its only task. */
typedef struct search {
    const saltus_sweep *sweep;
    long long task, place; /* the task is -1 once it has been given out */
    int seed;
    saltus_sweep_row *row;
    double *state;
    bool found;
} search;

static long long only_task(void *context) {
    search *s = context;
    const long long task = s->task;
    s->task = -1;
    return task;
}

/* The run ends, as if interrupted, as soon as the row is there. */
static saltus_status take(void *context, const saltus_sweep_result *result, saltus_message *message) {
    search *s = context;
    const int n = s->sweep->dimension;
    (void)message;
    if (result->place != s->place)
        return SALTUS_OK;
    *s->row = result->rows[s->seed];
    memcpy(s->state, result->states + s->seed * n, (size_t)n * sizeof *s->state);
    s->found = true;
    return SALTUS_INTERRUPTED;
}

saltus_status saltus_sweep_row_again(const saltus_sweep *sweep, long long number, saltus_sweep_row *row,
                                     double *state, saltus_message *message) {
    const long long place = number / sweep->options.seeds;
    saltus_sweep alone = *sweep;
    search s = {.sweep = &alone,
                .task = saltus_sweep_task_of(sweep, place),
                .place = place,
                .seed = (int)(number % sweep->options.seeds),
                .row = row,
                .state = state};
    alone.options.threads = alone.options.lanes = 1;
    const saltus_sweep_feed feed = {.context = &s, .next = only_task, .take = take};
    saltus_status status = saltus_sweep_run(&alone, &feed, message);
    if (status == SALTUS_INTERRUPTED && s.found)
        return SALTUS_OK;
    return status == SALTUS_OK ? saltus_fail(message, SALTUS_INTERRUPTED, "interrupted") : status;
}
