/* The sweep of Figure 6 as a user of the library runs it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_engine.h"

#include <string.h>
#include <time.h>

typedef struct feed_state {
    const saltus_sweep *sweep;
    long long next;
    motion *motions;
} feed_state;

static double clock_seconds(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

saltus_axis engine_axis(void) {
    return (saltus_axis){.key = "omega", .spacing = SALTUS_LINEAR, .count = 1000, .low = 0.5, .high = 55};
}

static long long next_task(void *context) {
    feed_state *f = context;
    return f->next < saltus_sweep_tasks(f->sweep) ? f->next++ : -1;
}

static saltus_status take(void *context, const saltus_sweep_result *result, saltus_message *message) {
    feed_state *f = context;
    const saltus_sweep_row *row = result->rows;
    motion *m = &f->motions[result->place];
    (void)message;
    motion_clear(m);
    m->failed = row->verdict == SALTUS_FAILED;
    memcpy(m->settled, result->states, sizeof m->settled);
    for (long long k = 0; k < result->impact_counts[0]; k++)
        motion_add_impact(m, result->impacts[k].phase, result->impacts[k].speed);
    if (row->verdict == SALTUS_PERIODIC) {
        m->sticks = row->sticking * recorded_periods / row->periods;
        m->orbit_impacts = row->impacts < 0 ? orbit_chatters : row->impacts;
        m->orbit_periods = row->periods;
    }
    return SALTUS_OK;
}

static saltus_sweep_options options_of(const engine_request *request) {
    saltus_sweep_options options = saltus_sweep_defaults();
    options.flow.rtol = request->rtol;
    options.flow.atol = 1e-3 * request->rtol;
    options.keep = request->keep;
    options.adaptive = request->adaptive;
    options.transient = request->adaptive ? settling_periods + recorded_periods : settling_periods;
    options.record = recorded_periods;
    options.lanes = request->lanes;
    options.threads = request->threads;
    return options;
}

saltus_status engine_sweep(const engine_request *request, motion *motions, sweep_cost *cost,
                           saltus_message *message) {
    saltus_scene scene;
    saltus_sweep *sweep = NULL;
    const saltus_axis axis = engine_axis();
    const saltus_sweep_options options = options_of(request);
    *cost = (sweep_cost){0};
    saltus_status status = saltus_scene_load("fig6", &scene, message);
    if (!request->stopped)
        scene.spec.stop_count = 0;
    if (status == SALTUS_OK)
        status = saltus_sweep_new(&scene, &axis, 1, &options, &sweep, message);
    if (status == SALTUS_OK) {
        feed_state state = {.sweep = sweep, .motions = motions};
        const saltus_sweep_feed feed = {.context = &state, .next = next_task, .take = take};
        const double cpu = clock_seconds(CLOCK_PROCESS_CPUTIME_ID), wall = clock_seconds(CLOCK_MONOTONIC);
        status = saltus_sweep_run(sweep, &feed, message);
        cost->seconds = clock_seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu;
        cost->wall = clock_seconds(CLOCK_MONOTONIC) - wall;
    }
    saltus_sweep_free(sweep);
    return status;
}
