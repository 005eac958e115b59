/* One seed of a sweep in a lane: where it is, what it has done, moving it on.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <math.h>
#include <stdlib.h>

static void reserve_measuring(saltus_measuring *m, int dimension) {
    saltus_growth_reserve(&m->growth, &m->arena, dimension, 1);
}

static bool open_measuring(saltus_measuring *m, int dimension) {
    reserve_measuring(m, dimension);
    if (!saltus_arena_open(&m->arena))
        return false;
    reserve_measuring(m, dimension);
    return true;
}

static void close_measuring(saltus_measuring *m) {
    saltus_arena_close(&m->arena);
    free(m->points);
    *m = (saltus_measuring){0};
}

bool saltus_trajectory_open(saltus_trajectory *t, const saltus_sweep *sweep) {
    size_t n = (size_t)sweep->dimension;
    *t = (saltus_trajectory){.sweep = sweep};
    t->state = calloc(n, sizeof *t->state);
    t->home = calloc(n, sizeof *t->home);
    t->orbit = calloc(n * (size_t)sweep->options.longest, sizeof *t->orbit);
    bool measurable =
        !(sweep->options.keep & SALTUS_KEEP_LYAPUNOV) || open_measuring(&t->measuring, sweep->dimension);
    t->rng = gsl_rng_alloc(gsl_rng_mt19937);
    double near = fmax(1e-10, 10 * sweep->options.flow.rtol);
    return saltus_settling_open(&t->settling, sweep->dimension, sweep->options.longest, near) && t->state &&
           t->home && t->orbit && measurable && t->rng;
}

void saltus_trajectory_close(saltus_trajectory *t) {
    saltus_settling_close(&t->settling);
    saltus_watch_close(&t->watch);
    saltus_watch_close(&t->round);
    saltus_system_free(t->system);
    free(t->state);
    free(t->home);
    free(t->orbit);
    close_measuring(&t->measuring);
    if (t->rng)
        gsl_rng_free(t->rng);
    *t = (saltus_trajectory){0};
}

long long saltus_trajectory_point(const saltus_trajectory *t) {
    return saltus_sweep_task_place(t->sweep, t->job->task, t->place) % t->sweep->points;
}

long long saltus_trajectory_cycle(const saltus_trajectory *t) {
    return saltus_flow_time(t->flow, t->lane).cycle;
}

saltus_flow_info saltus_trajectory_information(const saltus_trajectory *t) {
    saltus_flow_info info = saltus_flow_information(t->flow, t->lane);
    info.steps += t->before.steps;
    info.impacts += t->before.impacts;
    info.sticks += t->before.sticks;
    info.releases += t->before.releases;
    return info;
}

void saltus_trajectory_hand_back(saltus_trajectory *t) {
    if (saltus_flow_columns(t->flow))
        saltus_flow_set_tangents(t->flow, t->lane, t->measuring.growth.vectors);
}

static bool start_at(saltus_trajectory *t, saltus_time time, const double *state) {
    if (saltus_flow_start(t->flow, t->lane, time, state, NULL) != SALTUS_OK)
        return false;
    saltus_trajectory_hand_back(t);
    saltus_flow_state(t->flow, t->lane, t->state);
    return true;
}

bool saltus_trajectory_continue(saltus_trajectory *t, const double *state) {
    t->before = saltus_trajectory_information(t);
    return start_at(t, saltus_flow_time(t->flow, t->lane), state);
}

bool saltus_trajectory_move(saltus_trajectory *t, saltus_flow *flow, int lane) {
    saltus_time now = saltus_flow_time(t->flow, t->lane);
    t->before = saltus_trajectory_information(t);
    t->flow = flow;
    t->lane = lane;
    return start_at(t, now, t->state);
}

void saltus_trajectory_settle(saltus_trajectory *t, saltus_verdict verdict, int periods) {
    t->row.verdict = verdict;
    t->row.periods = periods;
    t->row.settled = saltus_trajectory_cycle(t);
    t->row.settled_impacts = saltus_trajectory_information(t).impacts;
}
