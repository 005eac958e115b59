/* Running a sweep on all cores, one worker per thread. Each runs its trajectories side by side in the lanes
 * of a flow, and those whose exponent is measured in the lanes of a second flow with a tangent vector.
 *
 * A lane whose trajectory has finished its task, or has moved to the other flow, takes the next trajectory
 * at once. The second flow runs when its lanes are full or nothing else can run, so that no lane of either
 * idles while there is work. A trajectory that has been measured and has more places to visit waits for a
 * lane of the first flow. A system that lacks a term of the others (an amplitude of zero at the edge of a
 * grid) cannot run beside them: its trajectory runs in a flow of one lane, with bitwise equal results.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "base/progress.h"
#include "flow/kernel.h"
#include "system/system.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#ifdef _OPENMP
#include <omp.h>
#endif

/* Access to the feed of a sweep, one thread at a time. */
typedef struct schedule {
    const saltus_sweep_feed *feed;
    long long handed, tasks; /* handed out in order where the feed does not say otherwise; all of the sweep */
    const volatile sig_atomic_t *stop;
    atomic_int status; /* the first failure */
    saltus_message *message;
    pthread_mutex_t lock;
} schedule;

/* The next task, or -1 if there is none. */
static long long next_task(schedule *s) {
    pthread_mutex_lock(&s->lock);
    long long task = -1;
    if (s->status == SALTUS_OK && s->feed->next)
        task = s->feed->next(s->feed->context);
    else if (s->status == SALTUS_OK && s->handed < s->tasks)
        task = s->handed++;
    pthread_mutex_unlock(&s->lock);
    return task;
}

/* Pass a complete place to the feed. */
static void emit(schedule *s, saltus_job *job, int place, const saltus_system *system) {
    pthread_mutex_lock(&s->lock);
    if (s->status == SALTUS_OK)
        s->status = saltus_job_emit(job, place, system, s->feed, s->message);
    pthread_mutex_unlock(&s->lock);
}

static void finish_task(schedule *s, long long task) {
    pthread_mutex_lock(&s->lock);
    if (s->status == SALTUS_OK && s->feed->done)
        s->feed->done(s->feed->context, task);
    pthread_mutex_unlock(&s->lock);
}

static void end_run(schedule *s, saltus_status status, const char *why) {
    pthread_mutex_lock(&s->lock);
    if (s->status == SALTUS_OK)
        s->status = saltus_fail(s->message, status, "%s", why);
    pthread_mutex_unlock(&s->lock);
}

static bool goes_on(const schedule *s) {
    return !saltus_stop_asked(s->stop) && atomic_load_explicit(&s->status, memory_order_relaxed) == SALTUS_OK;
}

/* A flow and the trajectories in its lanes. */
typedef struct lane_set {
    saltus_flow *flow;
    int lanes, live;
    saltus_sweep_trajectory *at[SALTUS_LANES_MAX]; /* NULL: idle */
} lane_set;

typedef struct worker {
    const saltus_sweep *sweep;
    schedule *schedule;
    long long share; /* of the sweep's trajectories, if each worker takes as many */
    saltus_job *job; /* the task whose seeds are being handed out */
    lane_set plain, tangent;
    saltus_flow *single[2]; /* flows of one lane, without and with a tangent vector; made when needed */
    int size, waiting;
    saltus_sweep_trajectory *queue[2 * SALTUS_LANES_MAX]; /* waiting for a lane without a tangent vector */
    saltus_sweep_trajectory trajectory[2 * SALTUS_LANES_MAX];
} worker;

/* Make a flow for systems with all terms. A failure ends the run. */
static bool open_flow(const worker *w, int lanes, int columns, saltus_flow **flow) {
    const saltus_system *systems[SALTUS_LANES_MAX];
    saltus_flow_options options = w->sweep->options.flow;
    saltus_message message = {.text = ""};
    options.columns = columns;
    options.stop = NULL; /* an interrupted flow would make a failed row */
    for (int l = 0; l < lanes; l++)
        systems[l] = w->sweep->system;
    saltus_status status = saltus_flow_new(systems, lanes, &options, flow, &message);
    if (status == SALTUS_OK)
        saltus_flow_limit_steps(*flow, SALTUS_EFFORT_IN_PERIOD);
    else
        end_run(w->schedule, status, message.text);
    return status == SALTUS_OK;
}

static bool open_worker(worker *w) {
    const saltus_sweep_options *o = &w->sweep->options;
    const bool measures = o->keep & SALTUS_KEEP_LYAPUNOV;
    const int width = saltus_flow_width(w->sweep->system, o->flow.integrator, w->share);
    w->plain.lanes = o->lanes > 0 && o->lanes < width ? o->lanes : width;
    w->tangent.lanes = measures ? w->plain.lanes : 0;
    w->size = w->plain.lanes + w->tangent.lanes;
    if (!open_flow(w, w->plain.lanes, 0, &w->plain.flow) ||
        (measures && !open_flow(w, w->tangent.lanes, 1, &w->tangent.flow)))
        return false;
    for (int k = 0; k < w->size; k++)
        if (!saltus_sweep_trajectory_open(&w->trajectory[k], w->sweep)) {
            end_run(w->schedule, SALTUS_NO_MEMORY, "no memory for the trajectories of a sweep");
            return false;
        }
    return true;
}

/* Drop a reference to a job; the last one frees it. */
static void leave_job(saltus_job **job) {
    if (*job && --(*job)->holders == 0)
        saltus_job_free(*job);
    *job = NULL;
}

static void finish_job(worker *w, saltus_sweep_trajectory *t) {
    if (++t->job->finished == t->job->seeds)
        finish_task(w->schedule, t->job->task);
    leave_job(&t->job);
}

static void close_worker(worker *w) {
    saltus_flow_free(w->plain.flow);
    saltus_flow_free(w->tangent.flow);
    saltus_flow_free(w->single[0]);
    saltus_flow_free(w->single[1]);
    for (int k = 0; k < w->size; k++) {
        leave_job(&w->trajectory[k].job);
        saltus_sweep_trajectory_close(&w->trajectory[k]);
    }
    leave_job(&w->job);
}

/* Let a lane's trajectory go. The lane must be given another system before that trajectory goes on. */
static void leave_lane(lane_set *side, int lane) {
    side->at[lane] = NULL;
    side->live--;
}

/* Idle a lane: it then holds the sweep's own system, which outlives all others. */
static void rest_lane(const worker *w, const lane_set *side, int lane) {
    saltus_flow_retune(side->flow, lane, w->sweep->system, NULL);
}

static int free_lane(const lane_set *side) {
    int lane = 0;
    while (lane < side->lanes && side->at[lane])
        lane++;
    return lane;
}

/* The trajectory that has waited longest with more places to visit; otherwise an idle one with the next seed
 * of the present or the next task; NULL if there is nothing more to do. */
static saltus_sweep_trajectory *next_trajectory(worker *w) {
    if (w->waiting > 0) {
        saltus_sweep_trajectory *first = w->queue[0];
        memmove(w->queue, w->queue + 1, (size_t)--w->waiting * sizeof(saltus_sweep_trajectory *));
        return first;
    }
    saltus_sweep_trajectory *idle = w->trajectory;
    while (idle < w->trajectory + w->size && idle->job)
        idle++;
    if (idle == w->trajectory + w->size)
        return NULL;
    if (!w->job || w->job->assigned == w->job->seeds) {
        leave_job(&w->job);
        long long task = next_task(w->schedule);
        if (task < 0)
            return NULL;
        w->job = saltus_job_open(w->sweep, task);
        if (!w->job) {
            end_run(w->schedule, SALTUS_NO_MEMORY, "no memory for a task of a sweep");
            return NULL;
        }
        w->job->holders = 1;
    }
    idle->job = w->job;
    idle->job->holders++;
    idle->seed = w->job->assigned++;
    idle->place = 0;
    return idle;
}

/* The flow of one lane, made when first needed; NULL after a failure. */
static saltus_flow *single_flow(worker *w, int columns) {
    if (!w->single[columns])
        open_flow(w, 1, columns, &w->single[columns]);
    return w->single[columns];
}

/* Give the trajectory the system of its place, and choose its flow and lane: a flow of one lane if the
 * system lacks terms. The old system is freed once no flow uses it. */
static saltus_status change_system(worker *w, saltus_sweep_trajectory *t, int lane, saltus_flow **flow,
                                   int *at) {
    saltus_system *system = NULL, *old = t->system;
    saltus_message message;
    saltus_status status = saltus_sweep_system(w->sweep, saltus_sweep_trajectory_point(t), &system, &message);
    if (status != SALTUS_OK)
        return status;
    bool fits = w->plain.lanes == 1 || system->coefficients.terms == w->sweep->system->coefficients.terms;
    *flow = fits ? w->plain.flow : single_flow(w, 0);
    *at = fits ? lane : 0;
    if (!*flow) {
        saltus_system_free(system);
        return SALTUS_NO_MEMORY;
    }
    if (!fits)
        saltus_flow_retune(w->plain.flow, lane, w->sweep->system, &message);
    status = saltus_flow_retune(*flow, *at, system, &message);
    t->system = status == SALTUS_OK ? system : old;
    saltus_system_free(status == SALTUS_OK ? old : system);
    return status;
}

/* Run a flow to its next event and let the trajectory of that lane process it. */
static saltus_next advance(saltus_flow *flow, saltus_sweep_trajectory *const *at, int *lane) {
    saltus_event event;
    saltus_message message;
    if (saltus_flow_run(flow, lane, &event, &message) == SALTUS_OK)
        return saltus_sweep_trajectory_follow(at[*lane], &event);
    saltus_sweep_trajectory_fail(at[*lane]);
    return SALTUS_NEXT_DONE;
}

/* Start to measure a trajectory in a lane. False if it cannot continue there. */
static bool measure_in(saltus_sweep_trajectory *t, saltus_flow *flow, int lane) {
    return saltus_flow_retune(flow, lane, t->system, NULL) == SALTUS_OK &&
           saltus_sweep_trajectory_measure(t, flow, lane);
}

/* Run a trajectory in flows of one lane until its place is finished. */
static void run_single(worker *w, saltus_sweep_trajectory *t) {
    saltus_next next = SALTUS_NEXT_GO_ON;
    while (next != SALTUS_NEXT_DONE) {
        int lane = 0;
        if (next == SALTUS_NEXT_GO_ON)
            next = advance(t->flow, &t, &lane);
        else {
            saltus_flow *flow = single_flow(w, 1);
            next = flow && measure_in(t, flow, 0) ? SALTUS_NEXT_GO_ON : SALTUS_NEXT_DONE;
        }
    }
    for (int k = 0; k < 2; k++)
        if (w->single[k])
            saltus_flow_retune(w->single[k], 0, w->sweep->system, NULL);
}

/* Store the trajectory's result at its place, and emit the place if all seeds are there. */
static void finish_place(worker *w, saltus_sweep_trajectory *t) {
    bool sound = true;
    const bool there =
        saltus_job_put(t->job, t->place, t->seed, &t->row, t->state, t->proof.orbit, &t->watch, &sound);
    if (!sound || t->starved) /* the row may not be what it would have been */
        end_run(w->schedule, SALTUS_NO_MEMORY, "no memory for a trajectory of a sweep");
    else if (there)
        emit(w->schedule, t->job, t->place, t->system ? t->system : w->sweep->system);
    t->place++;
}

/* Start a trajectory at its next place, and at further ones if that ends at once, until one runs in the
 * lane. False if there is none left. */
static bool go_on(worker *w, saltus_sweep_trajectory *t, int lane) {
    while (goes_on(w->schedule) && t->place < t->job->length) {
        saltus_flow *flow = w->plain.flow;
        int at = lane;
        saltus_status status = change_system(w, t, lane, &flow, &at);
        bool under_way = status == SALTUS_OK && saltus_sweep_trajectory_start(t, flow, at);
        t->starved |= status == SALTUS_NO_MEMORY;
        if (status != SALTUS_OK)
            saltus_sweep_trajectory_refuse(t, SALTUS_FAILED);
        if (under_way && flow == w->plain.flow)
            return true;
        if (under_way)
            run_single(w, t);
        finish_place(w, t);
    }
    if (t->place == t->job->length)
        finish_job(w, t);
    return false;
}

/* Give an idle lane of the first flow the next trajectory, if there is one; otherwise the lane rests. */
static void fill_lane(worker *w, int lane) {
    saltus_sweep_trajectory *t = NULL;
    bool under_way = false;
    while (!under_way && goes_on(w->schedule) && (t = next_trajectory(w)))
        under_way = go_on(w, t, lane);
    if (under_way) {
        w->plain.at[lane] = t;
        w->plain.live++;
    } else
        rest_lane(w, &w->plain, lane);
}

/* Run the first flow to an event, and refill the lane if it becomes free. */
static void run_plain(worker *w) {
    lane_set *here = &w->plain, *there = &w->tangent;
    int lane = 0;
    saltus_next next = advance(here->flow, here->at, &lane);
    saltus_sweep_trajectory *t = here->at[lane];
    if (next == SALTUS_NEXT_MEASURE) {
        int other = free_lane(there);
        if (measure_in(t, there->flow, other)) {
            there->at[other] = t;
            there->live++;
            leave_lane(here, lane);
            fill_lane(w, lane);
            return;
        }
        rest_lane(w, there, other);
    }
    if (next == SALTUS_NEXT_GO_ON)
        return;
    finish_place(w, t);
    if (!go_on(w, t, lane)) {
        leave_lane(here, lane);
        fill_lane(w, lane);
    }
}

/* Run the second flow to an event; a finished trajectory waits for the first flow or is done. */
static void run_tangent(worker *w) {
    lane_set *here = &w->tangent;
    int lane = 0;
    saltus_next next = advance(here->flow, here->at, &lane);
    saltus_sweep_trajectory *t = here->at[lane];
    if (next == SALTUS_NEXT_MEASURE && saltus_sweep_trajectory_measure(t, here->flow, lane))
        return;
    if (next == SALTUS_NEXT_GO_ON)
        return;
    finish_place(w, t);
    leave_lane(here, lane);
    rest_lane(w, here, lane);
    if (t->place < t->job->length)
        w->queue[w->waiting++] = t;
    else
        finish_job(w, t);
    if (w->plain.live < w->plain.lanes)
        fill_lane(w, free_lane(&w->plain));
}

/* Whether the second flow should run: it is full, or nothing else can run, or the first has idle lanes while
 * a measured trajectory has more places to visit. */
static bool is_tangents_turn(const worker *w) {
    const lane_set *plain = &w->plain, *tangent = &w->tangent;
    bool waits = false;
    for (int l = 0; l < tangent->lanes && plain->live < plain->lanes; l++) {
        const saltus_sweep_trajectory *t = tangent->at[l];
        waits |= t && t->place + 1 < t->job->length;
    }
    return tangent->live > 0 && (waits || plain->live == 0 || tangent->live == tangent->lanes);
}

static void run_worker(const saltus_sweep *sweep, schedule *schedule, int workers) {
    worker *w = calloc(1, sizeof *w);
    if (!w) {
        end_run(schedule, SALTUS_NO_MEMORY, "no memory for the trajectories of a sweep");
        return;
    }
    w->sweep = sweep;
    w->schedule = schedule;
    w->share = (schedule->tasks * sweep->options.seeds + workers - 1) / workers;
    bool sound = open_worker(w);
    for (int l = 0; l < w->plain.lanes && sound; l++)
        fill_lane(w, l);
    while (sound && w->plain.live + w->tangent.live > 0 && goes_on(schedule)) {
        if (is_tangents_turn(w))
            run_tangent(w);
        else
            run_plain(w);
    }
    close_worker(w);
    free(w);
}

saltus_status saltus_sweep_run(const saltus_sweep *sweep, const saltus_sweep_feed *feed,
                               saltus_message *message) {
    saltus_message own;
    schedule s = {.feed = feed,
                  .tasks = saltus_sweep_tasks(sweep),
                  .stop = sweep->options.flow.stop,
                  .message = message ? message : &own};
    pthread_mutex_init(&s.lock, NULL);
    int threads = 1;
#ifdef _OPENMP
    const int wanted = sweep->options.threads > 0 ? sweep->options.threads : omp_get_max_threads();
    /* At most one thread for each task, and not so many that they only compete for the cores. */
    const int crowd = 16 * omp_get_num_procs(), useful = wanted < crowd ? wanted : crowd;
    threads = s.tasks < useful ? (int)(s.tasks > 0 ? s.tasks : 1) : useful;
#pragma omp parallel num_threads(threads)
#endif
    run_worker(sweep, &s, threads);
    pthread_mutex_destroy(&s.lock);
    return (saltus_status)s.status;
}
