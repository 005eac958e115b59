/* The sweep by each kind of program: on a flow of Saltus whose lanes are refilled as soon as they are free,
 * by the library's own sweeps, and with the other libraries' integrators.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep.h"

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
    sweep_cost cost;
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

/* Give a lane the next system. */
static void fill(worker *w, int lane) {
    lane_task *task = &w->tasks[lane];
    double state[SALTUS_SCENE_STATE_MAX];
    saltus_message message = {.text = ""};
    const int index = w->next++;
    *task = (lane_task){.index = -1};
    if (index >= w->count)
        return;
    const saltus_system *system = w->systems[index];
    must(saltus_flow_retune(w->flow, lane, system, &message), &message);
    must(saltus_system_default_state(system, state, &message), &message);
    must(saltus_flow_start(w->flow, lane, (saltus_time){0, 0}, state, &message), &message);
    task->index = index;
    if (w->program->step_max > 0)
        task->pieces = (long)ceil(saltus_system_period(system) / w->program->step_max);
    motion_clear(&w->motions[index]);
    aim(w, lane);
}

static void run_lanes(worker *w) {
    int lane, live = 0;
    saltus_event event;
    saltus_message message = {.text = ""};
    for (int l = 0; l < w->program->lanes; l++) {
        fill(w, l);
        live += w->tasks[l].index >= 0;
    }
    while (live > 0) {
        must(saltus_flow_run(w->flow, &lane, &event, &message), &message);
        lane_task *task = &w->tasks[lane];
        motion *m = &w->motions[task->index];
        if (event.kind != SALTUS_REACHED) {
            motion_add_impact(m, (double)(event.time.cycle - settling_periods) + event.time.phase);
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
            w->cost.steps += info.steps;
            w->cost.evaluations += info.field_evaluations;
            fill(w, lane);
            live -= task->index < 0;
        } else {
            task->target++;
            aim(w, lane);
        }
    }
}

static saltus_flow_options options_of(const program *p) {
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = p->rtol;
    options.atol = 1e-3 * p->rtol;
    options.order = p->order;
    return options;
}

sweep_cost own_sweep(saltus_system *const *systems, int count, const program *p, motion *motions) {
    worker w = {.systems = systems, .count = count, .program = p, .motions = motions, .cost = {.share = 1}};
    const saltus_system *first[lanes_max];
    const saltus_flow_options options = options_of(p);
    saltus_message message = {.text = ""};
    for (int l = 0; l < p->lanes && l < lanes_max; l++)
        first[l] = systems[0];
    const double cpu = processor_seconds(), wall = clock_seconds(CLOCK_MONOTONIC);
    must(saltus_flow_new(first, p->lanes, &options, &w.flow, &message), &message);
    run_lanes(&w);
    saltus_flow_free(w.flow);
    w.cost.seconds = processor_seconds() - cpu;
    w.cost.wall = clock_seconds(CLOCK_MONOTONIC) - wall;
    return w.cost;
}

saltus_status own_period(const saltus_system *system, const program *p, const double *state, double *end,
                         int *impacts) {
    const saltus_flow_options options = options_of(p);
    saltus_flow *flow = NULL;
    saltus_event event;
    saltus_status status = saltus_flow_single(system, 0, &options, &flow, NULL);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, NULL);
    if (status == SALTUS_OK)
        status = saltus_flow_advance(flow, (saltus_time){1, 0}, 0, &event, NULL);
    if (status == SALTUS_OK) {
        saltus_flow_state(flow, 0, end);
        *impacts = (int)saltus_flow_information(flow, 0).impacts;
    }
    saltus_flow_free(flow);
    return status;
}

static saltus_status take(void *context, const saltus_sweep_result *result, saltus_message *message) {
    const saltus_sweep_row *row = result->rows;
    motion *m = (motion *)context + result->place;
    (void)message;
    motion_clear(m);
    m->failed = saltus_verdict_nothing((saltus_verdict)row->verdict);
    memcpy(m->settled, result->states, sizeof m->settled);
    for (long long k = 0; k < result->impact_counts[0]; k++)
        motion_add_impact(m, result->impacts[k].phase);
    if (row->verdict == SALTUS_PERIODIC) {
        m->sticks = row->sticking * recorded_periods / row->periods;
        m->orbit_impacts = row->impacts < 0 ? orbit_chatters : row->impacts;
        m->orbit_periods = row->periods;
    }
    return SALTUS_OK;
}

/* The library's own sweeps. */
static sweep_cost engine_sweep(const program *p, motion *motions) {
    const saltus_sweep_feed feed = {.context = motions, .take = take};
    saltus_scene scene;
    saltus_sweep *sweep = NULL;
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_message message = {.text = ""};
    options.flow.rtol = p->rtol;
    options.flow.atol = 1e-3 * p->rtol;
    options.keep = p->keep;
    options.adaptive = p->adaptive;
    options.transient = p->adaptive ? settling_periods + recorded_periods : settling_periods;
    options.record = recorded_periods;
    options.lanes = p->lanes;
    options.threads = p->threads;
    must(saltus_scene_load("fig6", &scene, &message), &message);
    if (p->unstopped)
        scene.spec.stop_count = 0;
    must(saltus_sweep_new(&scene, &sweep_axis, 1, &options, &sweep, &message), &message);
    const double cpu = processor_seconds(), wall = clock_seconds(CLOCK_MONOTONIC);
    must(saltus_sweep_run(sweep, &feed, &message), &message);
    const sweep_cost cost = {
        .seconds = processor_seconds() - cpu, .wall = clock_seconds(CLOCK_MONOTONIC) - wall, .share = 1};
    saltus_sweep_free(sweep);
    return cost;
}

/* The forcing is periodic, so the recorded periods may begin at time 0 again. */
static sweep_cost rival_sweep(sweep *s, const program *p) {
    const int periods[2] = {settling_periods, recorded_periods};
    double start[SALTUS_SCENE_STATE_MAX], end[motion_dimension], simulated = 0, all = 0;
    sweep_cost cost = {.seconds = 0};
    for (int k = 0; k < s->count; k++)
        all += saltus_system_period(s->stopped[k]);
    for (int k = 0; k < s->count; k += s->part) {
        const saltus_spec *spec = saltus_system_spec(s->stopped[k]);
        motion *m = &s->found[k];
        simulated += saltus_system_period(s->stopped[k]);
        motion_clear(m);
        saltus_system_default_state(s->stopped[k], start, NULL);
        memcpy(m->settled, start, sizeof m->settled);
        for (int stage = 0; stage < 2; stage++) {
            rival_result result = {
                .events = s->events, .capacity = stage ? rival_events_max : 0, .state = stage ? end : start};
            memcpy(end, m->settled, sizeof end);
            m->failed |= !p->rival->run(p->rival->which, spec, end, periods[stage], p->rtol, &result);
            for (int e = 0; e < result.count && e < result.capacity; e++) {
                const rival_event *event = &result.events[e];
                if (event->kind == RIVAL_IMPACT)
                    motion_add_impact(m, event->time_over_T);
                m->sticks += event->kind == RIVAL_STICK;
            }
            m->failed |= stage && result.count > result.capacity;
            if (!stage)
                memcpy(m->settled, start, sizeof m->settled);
            cost.seconds += result.cpu_seconds;
            cost.steps += result.steps;
            cost.evaluations += result.field_evaluations;
        }
    }
    cost.share = simulated / all;
    cost.seconds /= cost.share;
    cost.wall = cost.seconds;
    return cost;
}

sweep_cost program_run(sweep *s, const program *p) {
    if (p->kind == program_rival)
        return rival_sweep(s, p);
    if (p->kind == program_engine)
        return engine_sweep(p, s->found);
    return own_sweep(p->unstopped ? s->unstopped : s->stopped, s->count, p, s->found);
}
