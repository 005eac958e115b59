/* The sweep with Saltus: on a flow whose lanes are refilled as soon as they are free, and with the library's
 * own sweeps.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_measure.h"

#include "clock.h"

#include <math.h>
#include <string.h>

enum { lanes_max = 64 };

/* The present system of a lane and its progress. */
typedef struct lane_task {
    int index;         /* -1: nothing left for this lane */
    long target;       /* index of its next target time */
    long pieces;       /* target times per period if steps are limited */
    long long settled; /* sticks before the recorded periods */
} lane_task;

typedef struct worker {
    saltus_system *const *systems;
    int count, next; /* number of systems; the first one not yet taken by a lane */
    const program *program;
    motion *motions;
    saltus_flow *flow;
    lane_task tasks[lanes_max];
    sweep_cost *cost;
    saltus_message *message;
} worker;

/* The next target time: the end of a stage, of a recorded period, or of a piece of a period. */
static void aim(worker *w, int lane) {
    const program *p = w->program;
    const lane_task *task = &w->tasks[lane];
    const long k = task->target, pieces = task->pieces;
    saltus_time target = {k == 0 ? settling_periods : settling_periods + recorded_periods, 0};
    if (p->step_max > 0)
        target = (saltus_time){(k + 1) / pieces, (double)((k + 1) % pieces) / (double)pieces};
    else if (p->strobe)
        target = (saltus_time){settling_periods + k, 0};
    const bool recorded =
        target.cycle > settling_periods || (target.cycle == settling_periods && target.phase > 0);
    saltus_flow_aim(w->flow, lane, target, recorded ? SALTUS_WATCH_IMPACT : 0);
}

static saltus_status fill(worker *w, int lane) {
    lane_task *task = &w->tasks[lane];
    double state[SALTUS_SCENE_STATE_MAX];
    const int index = w->next++;
    *task = (lane_task){.index = -1};
    if (index >= w->count)
        return SALTUS_OK;
    const saltus_system *system = w->systems[index];
    saltus_status status = saltus_flow_retune(w->flow, lane, system, w->message);
    if (status == SALTUS_OK)
        status = saltus_system_default_state(system, state, w->message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(w->flow, lane, (saltus_time){0, 0}, state, w->message);
    if (status != SALTUS_OK)
        return status;
    task->index = index;
    if (w->program->step_max > 0)
        task->pieces = (long)ceil(saltus_system_period(system) / w->program->step_max);
    motion_clear(&w->motions[index]);
    aim(w, lane);
    return SALTUS_OK;
}

static saltus_status run_lanes(worker *w) {
    int lane;
    saltus_event event;
    saltus_status status = SALTUS_OK;
    int live = 0;
    for (int l = 0; l < w->program->lanes && status == SALTUS_OK; l++) {
        status = fill(w, l);
        live += w->tasks[l].index >= 0;
    }
    while (live > 0 && status == SALTUS_OK) {
        status = saltus_flow_run(w->flow, &lane, &event, w->message);
        if (status != SALTUS_OK)
            return status;
        lane_task *task = &w->tasks[lane];
        motion *m = &w->motions[task->index];
        if (event.kind != SALTUS_REACHED) {
            const double time = (double)(event.time.cycle - settling_periods) + event.time.phase;
            motion_add_impact(m, time, event.velocity_before);
            aim(w, lane);
            continue;
        }
        const saltus_time now = saltus_flow_time(w->flow, lane);
        const saltus_flow_info info = saltus_flow_information(w->flow, lane);
        const bool whole = now.phase == 0 && now.cycle >= settling_periods;
        if (whole && w->program->strobe)
            saltus_flow_state(w->flow, lane, m->strobe[now.cycle - settling_periods]);
        if (whole && now.cycle == settling_periods) {
            saltus_flow_state(w->flow, lane, m->settled);
            task->settled = info.sticks;
        }
        if (now.cycle == settling_periods + recorded_periods) {
            m->sticks = (int)(info.sticks - task->settled);
            w->cost->steps += info.steps;
            w->cost->evaluations += info.field_evaluations;
            status = fill(w, lane);
            live -= task->index < 0;
        } else {
            task->target++;
            aim(w, lane);
        }
    }
    return status;
}

static saltus_flow_options options_of(const program *p) {
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = p->rtol;
    options.atol = 1e-3 * p->rtol;
    options.order = p->order;
    return options;
}

saltus_status own_sweep(saltus_system *const *systems, int count, const program *p, motion *motions,
                        sweep_cost *cost, saltus_message *message) {
    worker w = {.systems = systems,
                .count = count,
                .program = p,
                .motions = motions,
                .cost = cost,
                .message = message};
    const saltus_system *first[lanes_max];
    const saltus_flow_options options = options_of(p);
    *cost = (sweep_cost){0};
    for (int l = 0; l < p->lanes && l < lanes_max; l++)
        first[l] = systems[0];
    const double cpu = processor_seconds(), wall = clock_seconds(CLOCK_MONOTONIC);
    saltus_status status = saltus_flow_new(first, p->lanes, &options, &w.flow, message);
    if (status == SALTUS_OK)
        status = run_lanes(&w);
    saltus_flow_free(w.flow);
    cost->seconds = processor_seconds() - cpu;
    cost->wall = clock_seconds(CLOCK_MONOTONIC) - wall;
    return status;
}

saltus_status own_period(const saltus_system *system, const program *p, const double *state, double *end,
                         int *impacts, saltus_message *message) {
    const saltus_flow_options options = options_of(p);
    const double period = saltus_system_period(system);
    const long pieces = p->step_max > 0 ? (long)ceil(period / p->step_max) : 1;
    saltus_flow *flow = NULL;
    saltus_event event;
    saltus_status status = saltus_flow_single(system, 0, &options, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    for (long k = 1; k <= pieces && status == SALTUS_OK; k++)
        status = saltus_flow_advance(flow, (saltus_time){k / pieces, (double)(k % pieces) / (double)pieces},
                                     0, &event, message);
    if (status == SALTUS_OK) {
        saltus_flow_state(flow, 0, end);
        *impacts = (int)saltus_flow_information(flow, 0).impacts;
    }
    saltus_flow_free(flow);
    return status;
}

/* The library's own sweeps. */

saltus_axis engine_axis(void) {
    return (saltus_axis){.key = "omega", .spacing = SALTUS_LINEAR, .count = 1000, .low = 0.5, .high = 55};
}

static saltus_status take(void *context, const saltus_sweep_result *result, saltus_message *message) {
    const saltus_sweep_row *row = result->rows;
    motion *m = (motion *)context + result->place;
    (void)message;
    motion_clear(m);
    m->failed = saltus_verdict_nothing((saltus_verdict)row->verdict);
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

saltus_status engine_sweep(const program *p, motion *motions, sweep_cost *cost, saltus_message *message) {
    saltus_scene scene;
    saltus_sweep *sweep = NULL;
    const saltus_axis axis = engine_axis();
    saltus_sweep_options options = saltus_sweep_defaults();
    options.flow.rtol = p->rtol;
    options.flow.atol = 1e-3 * p->rtol;
    options.keep = p->keep;
    options.adaptive = p->adaptive;
    options.transient = p->adaptive ? settling_periods + recorded_periods : settling_periods;
    options.record = recorded_periods;
    options.lanes = p->lanes;
    options.threads = p->threads;
    *cost = (sweep_cost){0};
    saltus_status status = saltus_scene_load("fig6", &scene, message);
    if (p->unstopped)
        scene.spec.stop_count = 0;
    if (status == SALTUS_OK)
        status = saltus_sweep_new(&scene, &axis, 1, &options, &sweep, message);
    if (status == SALTUS_OK) {
        const saltus_sweep_feed feed = {.context = motions, .take = take};
        const double cpu = processor_seconds(), wall = clock_seconds(CLOCK_MONOTONIC);
        status = saltus_sweep_run(sweep, &feed, message);
        cost->seconds = processor_seconds() - cpu;
        cost->wall = clock_seconds(CLOCK_MONOTONIC) - wall;
    }
    saltus_sweep_free(sweep);
    return status;
}
