/* One thread's trajectories side by side in the lanes of a flow.
 *
 * A lane whose trajectory has finished its task takes the next seed at once. A system that lacks a term which
 * the others have (an amplitude of zero at the edge of a grid) cannot run beside them: its trajectory runs in
 * a flow of one lane, with the same bits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "system/system.h"

#include <stdlib.h>
#include <string.h>

enum { lanes_max = 16 };

typedef struct crew {
    const saltus_sweep *sweep;
    saltus_gate *gate;
    saltus_job *job;            /* the task whose seeds are being handed out */
    saltus_flow *flow, *single; /* all lanes; one lane, made when it is needed */
    int lanes;
    saltus_trajectory trajectory[lanes_max];
} crew;

static int lane_count(const saltus_sweep *sweep) {
    int width = saltus_flow_width(sweep->system), asked = sweep->options.lanes;
    if (sweep->options.flow.integrator == SALTUS_RADAU)
        return 1;
    return asked > 0 && asked < width ? asked : width;
}

static bool open_flow(const crew *c, int lanes, saltus_flow **flow) {
    const saltus_system *systems[lanes_max];
    saltus_message message = {""};
    for (int l = 0; l < lanes; l++)
        systems[l] = c->sweep->system;
    saltus_status status = saltus_flow_new(systems, lanes, &c->sweep->options.flow, flow, &message);
    if (status != SALTUS_OK)
        saltus_gate_fail(c->gate, status, message.text);
    return status == SALTUS_OK;
}

static bool open_crew(crew *c) {
    c->lanes = lane_count(c->sweep);
    if (!open_flow(c, c->lanes, &c->flow))
        return false;
    for (int l = 0; l < c->lanes; l++)
        if (!saltus_trajectory_open(&c->trajectory[l], c->sweep)) {
            saltus_gate_fail(c->gate, SALTUS_NO_MEMORY, "no memory for the trajectories of a sweep");
            return false;
        }
    return true;
}

static void leave_job(crew *c, saltus_trajectory *t) {
    saltus_job *job = t->job;
    t->job = NULL;
    if (++job->finished < job->seeds)
        return;
    saltus_gate_done(c->gate, job->task);
    if (c->job == job)
        c->job = NULL;
    saltus_job_free(job);
}

static void close_crew(crew *c) {
    saltus_flow_free(c->flow);
    saltus_flow_free(c->single);
    for (int l = 0; l < c->lanes; l++) {
        saltus_job *job = c->trajectory[l].job;
        for (int k = 0; k < c->lanes && job; k++)
            if (c->trajectory[k].job == job)
                c->trajectory[k].job = NULL;
        if (job == c->job)
            c->job = NULL;
        saltus_job_free(job);
        saltus_trajectory_close(&c->trajectory[l]);
    }
    saltus_job_free(c->job);
}

/* The next seed of the task at hand, or of the next task; false when there is none. */
static bool take_seed(crew *c, saltus_trajectory *t) {
    if (!c->job || c->job->assigned == c->job->seeds) {
        long long task = saltus_gate_next(c->gate);
        c->job = NULL;
        if (task < 0)
            return false;
        c->job = saltus_job_open(c->sweep, task);
        if (!c->job) {
            saltus_gate_fail(c->gate, SALTUS_NO_MEMORY, "no memory for a task of a sweep");
            return false;
        }
    }
    t->job = c->job;
    t->seed = c->job->assigned++;
    t->place = 0;
    return true;
}

/* Give the trajectory the system of its place; the old one is freed once no flow knows it. */
static saltus_status change_system(crew *c, saltus_trajectory *t, int lane, saltus_flow **flow, int *at) {
    long long point = saltus_sweep_task_place(c->sweep, t->job->task, t->place) % c->sweep->points;
    saltus_system *system = NULL, *old = t->system;
    saltus_message message;
    saltus_status status = saltus_sweep_system(c->sweep, point, &system, &message);
    if (status != SALTUS_OK)
        return status;
    bool fits = c->lanes == 1 || system->coefficients.terms == c->sweep->system->coefficients.terms;
    if (!fits && !c->single && !open_flow(c, 1, &c->single)) {
        saltus_system_free(system);
        return SALTUS_NO_MEMORY;
    }
    *flow = fits ? c->flow : c->single;
    *at = fits ? lane : 0;
    if (!fits)
        saltus_flow_retune(c->flow, lane, c->sweep->system, &message);
    status = saltus_flow_retune(*flow, *at, system, &message);
    t->system = status == SALTUS_OK ? system : old;
    saltus_system_free(status == SALTUS_OK ? old : system);
    return status;
}

/* Run a trajectory's place to its end in the flow of one lane. */
static void run_single(crew *c, saltus_trajectory *t) {
    bool over = false;
    while (!over) {
        saltus_event event;
        int lane = 0;
        saltus_message message;
        if (saltus_flow_run(c->single, &lane, &event, &message) == SALTUS_OK)
            over = saltus_trajectory_follow(t, &event);
        else {
            saltus_trajectory_fail(t);
            over = true;
        }
    }
    saltus_flow_retune(c->single, 0, c->sweep->system, NULL);
}

/* Store what came out of the trajectory's place and hand it out where all seeds are there. */
static void finish_place(crew *c, saltus_trajectory *t) {
    bool sound = true;
    if (saltus_job_put(t->job, t->place, t->seed, &t->row, t->state, t->orbit, &t->watch, &sound) && sound)
        saltus_gate_emit(c->gate, t->job, t->place, t->system ? t->system : c->sweep->system);
    if (!sound || t->starved)
        saltus_gate_fail(c->gate, SALTUS_NO_MEMORY, "no memory for a trajectory of a sweep");
    t->place++;
}

/* Start places, one after the other, until one is under way in the crew's lanes; false when there is nothing
 * left to do. */
static bool go_on(crew *c, int lane) {
    saltus_trajectory *t = &c->trajectory[lane];
    while (saltus_gate_open(c->gate)) {
        saltus_flow *flow = c->flow;
        int at = lane;
        if (t->job && t->place == t->job->length)
            leave_job(c, t);
        if (!t->job && !take_seed(c, t))
            return false;
        saltus_status status = change_system(c, t, lane, &flow, &at);
        bool under_way = status == SALTUS_OK && saltus_trajectory_start(t, flow, at);
        t->starved |= status == SALTUS_NO_MEMORY;
        if (status != SALTUS_OK)
            saltus_trajectory_refuse(t);
        if (under_way && flow == c->flow)
            return true;
        if (under_way)
            run_single(c, t);
        finish_place(c, t);
    }
    return false;
}

void saltus_crew_run(const saltus_sweep *sweep, saltus_gate *gate) {
    crew *c = calloc(1, sizeof *c);
    int live = 0;
    if (!c) {
        saltus_gate_fail(gate, SALTUS_NO_MEMORY, "no memory for the trajectories of a sweep");
        return;
    }
    c->sweep = sweep;
    c->gate = gate;
    bool sound = open_crew(c);
    for (int l = 0; l < c->lanes && sound; l++)
        live += go_on(c, l);
    while (live > 0 && saltus_gate_open(gate)) {
        saltus_event event;
        saltus_message message;
        int lane = 0;
        bool over = true;
        if (saltus_flow_run(c->flow, &lane, &event, &message) == SALTUS_OK)
            over = saltus_trajectory_follow(&c->trajectory[lane], &event);
        else
            saltus_trajectory_fail(&c->trajectory[lane]);
        if (over) {
            finish_place(c, &c->trajectory[lane]);
            live -= !go_on(c, lane);
        }
    }
    close_crew(c);
    free(c);
}
