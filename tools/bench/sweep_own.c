/* The sweep on flows whose lanes are refilled as soon as they are free.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_own.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <time.h>

enum { lanes_max = 64, threads_max = 64 };

/* What the threads share. */
typedef struct shared {
    saltus_system *const *systems;
    int count;
    const own_request *request;
    motion *motions;
    atomic_int next; /* the first system that nobody has taken */
} shared;

/* A lane's present system and how far it has come. */
typedef struct lane_task {
    int index;           /* -1: nothing is left for this lane */
    long target;         /* which of its target times comes next */
    long pieces;         /* target times in a period, where steps are limited */
    long long settled;   /* impacts before the recorded periods */
    long long settled_s; /* and sticks */
} lane_task;

typedef struct worker {
    shared *all;
    saltus_flow *flow;
    lane_task tasks[lanes_max];
    sweep_cost cost;
    saltus_status status;
    saltus_message message;
} worker;

static double clock_seconds(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* The target times: the ends of the two stages, or of each recorded period, or of each piece of a period. */
static saltus_time target_time(const own_request *request, const lane_task *task) {
    const long k = task->target;
    if (request->step_max > 0)
        return (saltus_time){(k + 1) / task->pieces, (double)((k + 1) % task->pieces) / (double)task->pieces};
    if (request->strobe)
        return (saltus_time){settling_periods + k, 0};
    return (saltus_time){k == 0 ? settling_periods : settling_periods + recorded_periods, 0};
}

static void aim(worker *w, int lane) {
    const own_request *request = w->all->request;
    const saltus_time target = target_time(request, &w->tasks[lane]);
    const bool recorded =
        target.cycle > settling_periods || (target.cycle == settling_periods && target.phase > 0);
    saltus_flow_aim(w->flow, lane, target, request->impacts && recorded ? SALTUS_WATCH_IMPACT : 0);
}

static saltus_status fill(worker *w, int lane) {
    lane_task *task = &w->tasks[lane];
    double state[SALTUS_SCENE_STATE_MAX];
    const int index = atomic_fetch_add(&w->all->next, 1);
    *task = (lane_task){.index = -1};
    if (index >= w->all->count)
        return SALTUS_OK;
    const saltus_system *system = w->all->systems[index];
    saltus_status status = saltus_flow_retune(w->flow, lane, system, &w->message);
    if (status == SALTUS_OK)
        status = saltus_system_default_state(system, state, &w->message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(w->flow, lane, (saltus_time){0, 0}, state, &w->message);
    if (status != SALTUS_OK)
        return status;
    task->index = index;
    if (w->all->request->step_max > 0)
        task->pieces = (long)ceil(saltus_system_period(system) / w->all->request->step_max);
    motion_clear(&w->all->motions[index]);
    aim(w, lane);
    return SALTUS_OK;
}

static saltus_status finish(worker *w, int lane) {
    const lane_task *task = &w->tasks[lane];
    const saltus_flow_info info = saltus_flow_information(w->flow, lane);
    motion *m = &w->all->motions[task->index];
    m->sticks = (int)(info.sticks - task->settled_s);
    if (!w->all->request->impacts)
        m->count = (int)(info.impacts - task->settled);
    w->cost.steps += info.steps;
    w->cost.evaluations += info.field_evaluations;
    return fill(w, lane);
}

static saltus_status reached(worker *w, int lane) {
    lane_task *task = &w->tasks[lane];
    const saltus_time now = saltus_flow_time(w->flow, lane);
    motion *m = &w->all->motions[task->index];
    const bool whole = now.phase == 0 && now.cycle >= settling_periods;
    if (whole && w->all->request->strobe)
        saltus_flow_state(w->flow, lane, m->strobe[now.cycle - settling_periods]);
    if (whole && now.cycle == settling_periods) {
        saltus_flow_state(w->flow, lane, m->settled);
        const saltus_flow_info info = saltus_flow_information(w->flow, lane);
        task->settled = info.impacts;
        task->settled_s = info.sticks;
    }
    if (now.cycle == settling_periods + recorded_periods)
        return finish(w, lane);
    task->target++;
    aim(w, lane);
    return SALTUS_OK;
}

static saltus_status run_lanes(worker *w) {
    int lane;
    saltus_event event;
    saltus_status status = SALTUS_OK;
    int live = 0;
    for (int l = 0; l < w->all->request->lanes && status == SALTUS_OK; l++) {
        status = fill(w, l);
        live += w->tasks[l].index >= 0;
    }
    while (live > 0 && status == SALTUS_OK) {
        status = saltus_flow_run(w->flow, &lane, &event, &w->message);
        if (status != SALTUS_OK)
            return status;
        if (event.kind == SALTUS_REACHED) {
            status = reached(w, lane);
            live -= w->tasks[lane].index < 0;
        } else {
            const double time = (double)(event.time.cycle - settling_periods) + event.time.phase;
            motion_add_impact(&w->all->motions[w->tasks[lane].index], time, event.velocity_before);
            aim(w, lane);
        }
    }
    return status;
}

static saltus_flow_options options_of(const own_request *request) {
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = request->rtol;
    options.atol = 1e-3 * request->rtol;
    options.order = request->order;
    return options;
}

/* Each thread makes its own flow, whose memory then lies apart from that of the others. */
static saltus_status open_flow(worker *w) {
    const own_request *request = w->all->request;
    const saltus_system *first[lanes_max];
    const saltus_flow_options options = options_of(request);
    for (int l = 0; l < request->lanes && l < lanes_max; l++)
        first[l] = w->all->systems[0];
    return saltus_flow_new(first, request->lanes, &options, &w->flow, &w->message);
}

static void *work(void *context) {
    worker *w = context;
    const double start = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
    w->status = open_flow(w);
    if (w->status == SALTUS_OK)
        w->status = run_lanes(w);
    saltus_flow_free(w->flow);
    w->cost.seconds = clock_seconds(CLOCK_THREAD_CPUTIME_ID) - start;
    return NULL;
}

static void run_threads(worker *workers, int threads) {
    pthread_t thread[threads_max];
    bool running[threads_max] = {false};
    for (int k = 1; k < threads; k++)
        running[k] = pthread_create(&thread[k], NULL, work, &workers[k]) == 0;
    work(&workers[0]);
    for (int k = 1; k < threads; k++)
        if (running[k])
            pthread_join(thread[k], NULL);
}

saltus_status own_sweep(saltus_system *const *systems, int count, const own_request *request, motion *motions,
                        sweep_cost *cost, saltus_message *message) {
    shared all = {.systems = systems, .count = count, .request = request, .motions = motions};
    const int threads = request->threads < threads_max ? request->threads : threads_max;
    worker *workers = calloc((size_t)threads, sizeof *workers);
    saltus_status status = workers ? SALTUS_OK : SALTUS_NO_MEMORY;
    *cost = (sweep_cost){0};
    for (int k = 0; k < threads && workers; k++)
        workers[k].all = &all;
    if (status == SALTUS_OK) {
        const double start = clock_seconds(CLOCK_MONOTONIC);
        run_threads(workers, threads);
        cost->wall = clock_seconds(CLOCK_MONOTONIC) - start;
    }
    for (int k = 0; k < threads && workers; k++) {
        if (status == SALTUS_OK && workers[k].status != SALTUS_OK)
            status = workers[k].status;
        if (status != SALTUS_OK && workers[k].message.text[0])
            *message = workers[k].message;
        cost->seconds += workers[k].cost.seconds;
        cost->steps += workers[k].cost.steps;
        cost->evaluations += workers[k].cost.evaluations;
    }
    free(workers);
    return status;
}

saltus_status own_period(const saltus_system *system, const own_request *request, const double *state,
                         double *end, int *impacts, saltus_message *message) {
    const saltus_flow_options options = options_of(request);
    const double period = saltus_system_period(system);
    const long pieces = request->step_max > 0 ? (long)ceil(period / request->step_max) : 1;
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
