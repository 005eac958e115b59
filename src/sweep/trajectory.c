/* One seed of a sweep in a lane: its position and counters, and restarting it elsewhere.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "system/system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool saltus_sweep_trajectory_open(saltus_sweep_trajectory *t, const saltus_sweep *sweep) {
    const int n = sweep->dimension, longest = sweep->options.longest;
    *t = (saltus_sweep_trajectory){.sweep = sweep};
    t->state = calloc((size_t)n, sizeof *t->state);
    t->proof.undisturbed = calloc((size_t)n, sizeof *t->proof.undisturbed);
    t->proof.rejected = calloc((size_t)n, sizeof *t->proof.rejected);
    t->proof.orbit = calloc((size_t)(n * longest), sizeof *t->proof.orbit);
    bool sound = saltus_settling_open(&t->proof.settling, n, longest) &&
                 saltus_visits_open(&t->proof.visits, n, longest) && t->state && t->proof.undisturbed &&
                 t->proof.rejected && t->proof.orbit;
    if (!sound || !(sweep->options.keep & SALTUS_KEEP_LYAPUNOV))
        return sound;
    saltus_measuring *m = &t->measuring;
    saltus_growth_reserve(&m->growth, &m->arena, n, 1);
    if (!saltus_arena_open(&m->arena))
        return false;
    saltus_growth_reserve(&m->growth, &m->arena, n, 1);
    return true;
}

void saltus_sweep_trajectory_close(saltus_sweep_trajectory *t) {
    saltus_settling_close(&t->proof.settling);
    saltus_visits_close(&t->proof.visits);
    free(t->proof.undisturbed);
    free(t->proof.rejected);
    free(t->proof.orbit);
    saltus_watch_close(&t->watch);
    saltus_watch_close(&t->round);
    saltus_arena_close(&t->measuring.arena);
    free(t->measuring.points);
    saltus_system_free(t->system);
    free(t->state);
    *t = (saltus_sweep_trajectory){0};
}

long long saltus_sweep_trajectory_point(const saltus_sweep_trajectory *t) {
    return saltus_sweep_task_place(t->sweep, t->job->task, t->place) % t->sweep->points;
}

long long saltus_sweep_trajectory_cycle(const saltus_sweep_trajectory *t) {
    return saltus_flow_time(t->flow, t->lane).cycle;
}

saltus_flow_info saltus_sweep_trajectory_information(const saltus_sweep_trajectory *t) {
    saltus_flow_info info = saltus_flow_information(t->flow, t->lane);
    info.steps += t->before.steps;
    info.impacts += t->before.impacts;
    info.sticks += t->before.sticks;
    info.releases += t->before.releases;
    info.square += t->before.square;
    return info;
}

/* Mix the bits of a number so that each affects the whole result (splitmix64's finaliser). */
static unsigned long long mix(unsigned long long x) {
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
}

void saltus_sweep_trajectory_seed(saltus_sweep_trajectory *t, int which) {
    unsigned long long point = (unsigned long long)saltus_sweep_trajectory_point(t),
                       bits = mix(mix(mix(t->sweep->options.seed) ^ point) ^ (unsigned long long)which);
    saltus_random_seed(&t->random, (unsigned long)(bits & 0xffffffffULL));
}

void saltus_sweep_trajectory_restore_tangent(saltus_sweep_trajectory *t) {
    if (saltus_flow_columns(t->flow))
        saltus_flow_set_tangents(t->flow, t->lane, t->measuring.growth.vectors);
}

static bool start_at(saltus_sweep_trajectory *t, saltus_time time, const double *state) {
    if (saltus_flow_start(t->flow, t->lane, time, state, NULL) != SALTUS_OK)
        return false;
    saltus_sweep_trajectory_restore_tangent(t);
    saltus_flow_state(t->flow, t->lane, t->state);
    return true;
}

bool saltus_sweep_trajectory_continue(saltus_sweep_trajectory *t, const double *state) {
    t->before = saltus_sweep_trajectory_information(t);
    return start_at(t, saltus_flow_time(t->flow, t->lane), state);
}

bool saltus_sweep_trajectory_go_back(saltus_sweep_trajectory *t) {
    t->proof.disturbed = false;
    return start_at(t, (saltus_time){t->proof.disturbed_at, 0}, t->proof.undisturbed);
}

bool saltus_sweep_trajectory_count_by(saltus_sweep_trajectory *t, double period, saltus_time time,
                                      const double *state) {
    saltus_system *counted = NULL, *old = t->system;
    double start[SALTUS_STATE_MAX];
    memcpy(start, state, (size_t)t->sweep->dimension * sizeof *start);
    t->before = saltus_sweep_trajectory_information(t);
    saltus_status status = saltus_system_clocked(old, 2 * M_PI / period, &counted, NULL);
    if (status == SALTUS_OK)
        status = saltus_flow_retune(t->flow, t->lane, counted, NULL);
    t->starved |= status == SALTUS_NO_MEMORY;
    if (status != SALTUS_OK) {
        saltus_system_free(counted);
        return false;
    }
    t->system = counted;
    saltus_system_free(old);
    saltus_visits_reset(&t->proof.visits, counted);
    return start_at(t, time, start);
}

bool saltus_sweep_trajectory_move(saltus_sweep_trajectory *t, saltus_flow *flow, int lane) {
    saltus_time now = saltus_flow_time(t->flow, t->lane);
    t->before = saltus_sweep_trajectory_information(t);
    t->flow = flow;
    t->lane = lane;
    return start_at(t, now, t->state);
}

void saltus_sweep_trajectory_settle(saltus_sweep_trajectory *t, saltus_verdict verdict, int periods) {
    t->row.verdict = verdict;
    t->row.periods = periods;
    t->row.settled = saltus_sweep_trajectory_cycle(t);
    t->row.settled_impacts = saltus_sweep_trajectory_information(t).impacts;
}
