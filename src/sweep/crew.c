/* One thread's trajectories side by side in the lanes of a flow, and of a second one for those whose exponent
 * is measured, with a tangent vector.
 *
 * A lane whose trajectory has finished its task, or goes on in the other flow, takes the next one at once.
 * The second flow runs when its lanes are full or nothing else is left to run, so that no lane of either is
 * idle as long as there is work; one that has been measured and has more of its line before it waits for a
 * lane of the first. A system that lacks a term which the others have (an amplitude of zero at the edge of a
 * grid) cannot run beside them: its trajectory runs in a flow of one lane, with the same bits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "system/system.h"

#include <stdlib.h>
#include <string.h>

enum { lanes_max = 16 };

/* A flow and who is in its lanes. */
typedef struct team {
    saltus_flow *flow;
    int lanes, live;
    saltus_trajectory *at[lanes_max]; /* NULL: the lane rests */
} team;

typedef struct crew {
    const saltus_sweep *sweep;
    saltus_gate *gate;
    saltus_job *job; /* the task whose seeds are being handed out */
    team plain, tangent;
    saltus_flow *single[2]; /* of one lane, without and with a tangent vector; made when they are needed */
    int size, waiting;
    saltus_trajectory *queue[2 * lanes_max]; /* that wait for a lane without a tangent vector */
    saltus_trajectory trajectory[2 * lanes_max];
} crew;

static int lane_count(const saltus_sweep *sweep) {
    int width = saltus_flow_width(sweep->system), asked = sweep->options.lanes;
    if (sweep->options.flow.integrator == SALTUS_RADAU)
        return 1;
    return asked > 0 && asked < width ? asked : width;
}

static bool open_flow(const crew *c, int lanes, int columns, saltus_flow **flow) {
    const saltus_system *systems[lanes_max];
    saltus_flow_options options = c->sweep->options.flow;
    saltus_message message = {""};
    options.columns = columns;
    for (int l = 0; l < lanes; l++)
        systems[l] = c->sweep->system;
    saltus_status status = saltus_flow_new(systems, lanes, &options, flow, &message);
    if (status != SALTUS_OK)
        saltus_gate_fail(c->gate, status, message.text);
    return status == SALTUS_OK;
}

static bool open_crew(crew *c) {
    bool measures = c->sweep->options.keep & SALTUS_KEEP_LYAPUNOV;
    c->plain.lanes = lane_count(c->sweep);
    c->tangent.lanes = measures ? c->plain.lanes : 0;
    c->size = c->plain.lanes + c->tangent.lanes;
    if (!open_flow(c, c->plain.lanes, 0, &c->plain.flow) ||
        (measures && !open_flow(c, c->tangent.lanes, 1, &c->tangent.flow)))
        return false;
    for (int k = 0; k < c->size; k++)
        if (!saltus_trajectory_open(&c->trajectory[k], c->sweep)) {
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
    saltus_flow_free(c->plain.flow);
    saltus_flow_free(c->tangent.flow);
    saltus_flow_free(c->single[0]);
    saltus_flow_free(c->single[1]);
    for (int k = 0; k < c->size; k++) {
        saltus_job *job = c->trajectory[k].job;
        for (int i = 0; i < c->size && job; i++)
            if (c->trajectory[i].job == job)
                c->trajectory[i].job = NULL;
        if (job == c->job)
            c->job = NULL;
        saltus_job_free(job);
        saltus_trajectory_close(&c->trajectory[k]);
    }
    saltus_job_free(c->job);
}

static void enter(team *side, int lane, saltus_trajectory *t) {
    side->at[lane] = t;
    side->live++;
}

/* A lane that rests knows no system that may be freed. */
static void leave(const crew *c, team *side, int lane) {
    side->at[lane] = NULL;
    side->live--;
    saltus_flow_retune(side->flow, lane, c->sweep->system, NULL);
}

static int free_lane(const team *side) {
    int lane = 0;
    while (lane < side->lanes && side->at[lane])
        lane++;
    return lane;
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

/* One that waits with a part of its line before it, or an idle one with a new seed; NULL when there is
 * nothing more to do. There is an idle one for each lane of the first flow that is free. */
static saltus_trajectory *next_trajectory(crew *c) {
    if (c->waiting > 0) {
        saltus_trajectory *first = c->queue[0];
        memmove(c->queue, c->queue + 1, (size_t)--c->waiting * sizeof(saltus_trajectory *));
        return first;
    }
    int k = 0;
    while (k < c->size && c->trajectory[k].job)
        k++;
    return k < c->size && take_seed(c, &c->trajectory[k]) ? &c->trajectory[k] : NULL;
}

/* The flow of one lane, made when it is first needed; NULL after a failure. */
static saltus_flow *single_flow(crew *c, int columns) {
    bool sound = c->single[columns] || open_flow(c, 1, columns, &c->single[columns]);
    return sound ? c->single[columns] : NULL;
}

/* Give the trajectory the system of its place; the old one is freed once no flow knows it. */
static saltus_status change_system(crew *c, saltus_trajectory *t, int lane, saltus_flow **flow, int *at) {
    saltus_system *system = NULL, *old = t->system;
    saltus_message message;
    saltus_status status = saltus_sweep_system(c->sweep, saltus_trajectory_point(t), &system, &message);
    if (status != SALTUS_OK)
        return status;
    bool fits = c->plain.lanes == 1 || system->coefficients.terms == c->sweep->system->coefficients.terms;
    *flow = fits ? c->plain.flow : single_flow(c, 0);
    *at = fits ? lane : 0;
    if (!*flow) {
        saltus_system_free(system);
        return SALTUS_NO_MEMORY;
    }
    if (!fits)
        saltus_flow_retune(c->plain.flow, lane, c->sweep->system, &message);
    status = saltus_flow_retune(*flow, *at, system, &message);
    t->system = status == SALTUS_OK ? system : old;
    saltus_system_free(status == SALTUS_OK ? old : system);
    return status;
}

/* The next event of a flow, and what its trajectory makes of it. */
static saltus_course advance(saltus_flow *flow, saltus_trajectory *const *at, int *lane) {
    saltus_event event;
    saltus_message message;
    if (saltus_flow_run(flow, lane, &event, &message) == SALTUS_OK)
        return saltus_trajectory_follow(at[*lane], &event);
    saltus_trajectory_fail(at[*lane]);
    return SALTUS_COURSE_OVER;
}

/* Begin to measure in a lane; false when that cannot be. */
static bool measure_in(saltus_trajectory *t, saltus_flow *flow, int lane) {
    return saltus_flow_retune(flow, lane, t->system, NULL) == SALTUS_OK &&
           saltus_trajectory_measure(t, flow, lane);
}

/* Run a trajectory's place to its end in flows of one lane. */
static void run_single(crew *c, saltus_trajectory *t) {
    saltus_course course = SALTUS_COURSE_ON;
    while (course != SALTUS_COURSE_OVER) {
        int lane = 0;
        if (course == SALTUS_COURSE_ON)
            course = advance(t->flow, &t, &lane);
        else {
            saltus_flow *flow = single_flow(c, 1);
            course = flow && measure_in(t, flow, 0) ? SALTUS_COURSE_ON : SALTUS_COURSE_OVER;
        }
    }
    for (int k = 0; k < 2; k++)
        if (c->single[k])
            saltus_flow_retune(c->single[k], 0, c->sweep->system, NULL);
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

/* Start a trajectory's places, one after the other, until one is under way in the lane; false when its line
 * is done. */
static bool go_on(crew *c, saltus_trajectory *t, int lane) {
    while (saltus_gate_open(c->gate) && t->place < t->job->length) {
        saltus_flow *flow = c->plain.flow;
        int at = lane;
        saltus_status status = change_system(c, t, lane, &flow, &at);
        bool under_way = status == SALTUS_OK && saltus_trajectory_start(t, flow, at);
        t->starved |= status == SALTUS_NO_MEMORY;
        if (status != SALTUS_OK)
            saltus_trajectory_refuse(t);
        if (under_way && flow == c->plain.flow)
            return true;
        if (under_way)
            run_single(c, t);
        finish_place(c, t);
    }
    if (t->place == t->job->length)
        leave_job(c, t);
    return false;
}

/* Give a lane of the first flow something to do. */
static void occupy(crew *c, int lane) {
    saltus_trajectory *t = NULL;
    bool under_way = false;
    while (!under_way && saltus_gate_open(c->gate) && (t = next_trajectory(c)))
        under_way = go_on(c, t, lane);
    if (under_way)
        enter(&c->plain, lane, t);
    else
        saltus_flow_retune(c->plain.flow, lane, c->sweep->system, NULL);
}

/* An event of the first flow. */
static void run_plain(crew *c) {
    team *here = &c->plain, *there = &c->tangent;
    int lane = 0;
    saltus_course course = advance(here->flow, here->at, &lane);
    saltus_trajectory *t = here->at[lane];
    if (course == SALTUS_COURSE_MEASURE) {
        int other = free_lane(there);
        if (measure_in(t, there->flow, other)) {
            enter(there, other, t);
            leave(c, here, lane);
            occupy(c, lane);
            return;
        }
        saltus_flow_retune(there->flow, other, c->sweep->system, NULL);
    }
    if (course == SALTUS_COURSE_ON)
        return;
    finish_place(c, t);
    if (!go_on(c, t, lane)) {
        leave(c, here, lane);
        occupy(c, lane);
    }
}

/* An event of the second flow. */
static void run_tangent(crew *c) {
    team *here = &c->tangent;
    int lane = 0;
    saltus_course course = advance(here->flow, here->at, &lane);
    saltus_trajectory *t = here->at[lane];
    if (course == SALTUS_COURSE_MEASURE && saltus_trajectory_measure(t, here->flow, lane))
        return;
    if (course == SALTUS_COURSE_ON)
        return;
    finish_place(c, t);
    leave(c, here, lane);
    if (t->place < t->job->length)
        c->queue[c->waiting++] = t;
    else
        leave_job(c, t);
    if (c->plain.live < c->plain.lanes)
        occupy(c, free_lane(&c->plain));
}

/* Whether one that is measured goes on along its line afterwards. */
static bool line_waits(const crew *c) {
    bool waits = false;
    for (int l = 0; l < c->tangent.lanes; l++) {
        const saltus_trajectory *t = c->tangent.at[l];
        waits |= t && t->place + 1 < t->job->length;
    }
    return waits;
}

/* The second flow's turn: it is full, or nothing else is to be done, or not enough for all lanes while lines
 * wait for it. */
static bool is_tangents_turn(const crew *c) {
    const team *plain = &c->plain, *tangent = &c->tangent;
    return tangent->live > 0 && (plain->live == 0 || tangent->live == tangent->lanes ||
                                 (plain->live < plain->lanes && line_waits(c)));
}

void saltus_crew_run(const saltus_sweep *sweep, saltus_gate *gate) {
    crew *c = calloc(1, sizeof *c);
    if (!c) {
        saltus_gate_fail(gate, SALTUS_NO_MEMORY, "no memory for the trajectories of a sweep");
        return;
    }
    c->sweep = sweep;
    c->gate = gate;
    bool sound = open_crew(c);
    for (int l = 0; l < c->plain.lanes && sound; l++)
        occupy(c, l);
    while (sound && c->plain.live + c->tangent.live > 0 && saltus_gate_open(gate)) {
        if (is_tangents_turn(c))
            run_tangent(c);
        else
            run_plain(c);
    }
    close_crew(c);
    free(c);
}
