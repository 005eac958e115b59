/* Orbits of scenes without forcing, whose periods are their own: found from a guess, or from the closest
 * returns of a trajectory to the section.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/motion.h"
#include "orbit/poincare.h"
#include "system/system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

saltus_status saltus_motion_cycle(const saltus_system *system, const double *guess,
                                  const saltus_classify_options *options, saltus_motion *motion,
                                  saltus_message *message) {
    saltus_orbit_options shooting = saltus_motion_shooting(options);
    saltus_orbit orbit = {0};
    saltus_lap lap = {.keeps_events = true};
    saltus_system *clocked = NULL;
    saltus_flow *flow = NULL;
    *motion = (saltus_motion){0};
    saltus_status status = saltus_cycle_polish(system, guess, &shooting, &orbit, &clocked, &lap, message);
    if (status == SALTUS_OK)
        status = saltus_flow_single(clocked, 0, &options->flow, &flow, message);
    if (status == SALTUS_OK && !saltus_motion_open(system, &options->flow, motion))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the orbit");
    if (status == SALTUS_OK)
        status = saltus_motion_take(clocked, flow, &orbit, &lap, options, motion, message);
    saltus_flow_free(flow);
    saltus_system_free(clocked);
    saltus_orbit_clear(&orbit);
    saltus_lap_close(&lap);
    if (status != SALTUS_OK)
        saltus_motion_clear(motion);
    return status;
}

saltus_status saltus_motion_count_returns(const saltus_system *system, const saltus_flow_options *options,
                                          saltus_motion *motion, saltus_system **counted,
                                          saltus_message *message) {
    saltus_lap lap = {.keeps_events = true};
    saltus_flow *flow = NULL;
    saltus_status status =
        saltus_system_clocked(system, 2 * M_PI * motion->periods / motion->period, counted, message);
    if (status == SALTUS_OK)
        status = saltus_flow_single(*counted, 0, options, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_lap_around(&lap, flow, motion->state, motion->periods, message);
    if (status == SALTUS_OK) {
        free(motion->section_states);
        free(motion->events);
        motion->section_states = lap.points;
        motion->events = lap.events;
        motion->event_count = lap.event_count;
        lap = (saltus_lap){0};
    }
    saltus_lap_close(&lap);
    saltus_flow_free(flow);
    if (status != SALTUS_OK) {
        saltus_system_free(*counted);
        *counted = NULL;
    }
    return status;
}

enum { tries = 16 };

/* A maximum to which the trajectory has come back after so many more. */
typedef struct candidate {
    double distance, taken; /* taken: in periods of the system */
    double *state;
} candidate;

/* The last maxima of a trajectory, and the closest returns among them. */
typedef struct returns {
    const saltus_system *system;
    int n, apart, ring;
    long long count;
    double *states, *times;
    candidate best[tries]; /* the closest first */
    int found;
} returns;

static bool open_returns(returns *r, const saltus_system *system, int apart) {
    *r = (returns){.system = system, .n = saltus_system_dimension(system), .apart = apart, .ring = apart + 1};
    r->states = calloc((size_t)(r->ring + tries) * (size_t)r->n, sizeof *r->states);
    r->times = calloc((size_t)r->ring, sizeof *r->times);
    for (int k = 0; k < tries && r->states; k++)
        r->best[k] = (candidate){INFINITY, 0, r->states + (size_t)(r->ring + k) * (size_t)r->n};
    return r->states && r->times;
}

static void keep_return(returns *r, double distance, double taken, const double *state) {
    int place = tries - 1;
    if (!(distance < r->best[place].distance))
        return;
    candidate fresh = {distance, taken, r->best[place].state};
    memcpy(fresh.state, state, (size_t)r->n * sizeof *state);
    for (; place > 0 && r->best[place - 1].distance > distance; place--)
        r->best[place] = r->best[place - 1];
    r->best[place] = fresh;
    r->found += r->found < tries;
}

static void add_return(returns *r, double time, const double *state) {
    long long now = r->count++;
    double *place = r->states + (size_t)(now % r->ring) * (size_t)r->n;
    memcpy(place, state, (size_t)r->n * sizeof *state);
    r->times[now % r->ring] = time;
    if (now < r->apart)
        return;
    long long before = (now - r->apart) % r->ring;
    const double *earlier = r->states + (size_t)before * (size_t)r->n;
    keep_return(r, saltus_system_distance(r->system, place, earlier), time - r->times[before], earlier);
}

static saltus_status watch(returns *r, const double *state, const saltus_classify_options *options,
                           saltus_message *message) {
    const long long enough = 2000 + 100LL * r->apart;
    saltus_flow *flow = NULL;
    saltus_crossings returns = {0};
    saltus_time time;
    saltus_event event = {.kind = SALTUS_STEP};
    double now[SALTUS_STATE_MAX];
    saltus_status status = saltus_flow_single(r->system, 0, &options->flow, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    while (status == SALTUS_OK && event.kind != SALTUS_REACHED && r->count < enough) {
        status = saltus_flow_advance(flow, (saltus_time){options->transient, 0},
                                     saltus_crossings_watch(r->system), &event, message);
        if (status != SALTUS_OK)
            break;
        saltus_flow_state(flow, 0, now);
        saltus_crossings_take(&returns, flow, 0, &event, now);
        while (saltus_crossings_count(&returns, flow, 0, now, &time))
            add_return(r, saltus_time_periods(time), now);
    }
    saltus_flow_free(flow);
    return status;
}

saltus_status saltus_motion_returning(const saltus_system *system, const double *state, int periods,
                                      const saltus_classify_options *options, saltus_motion *motion,
                                      saltus_message *message) {
    returns r;
    saltus_message why = {.text = "the trajectory does not return"};
    *motion = (saltus_motion){0};
    saltus_status status = open_returns(&r, system, periods)
                               ? watch(&r, state, options, message)
                               : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for returns");
    bool found = false;
    for (int k = 0; k < r.found && status == SALTUS_OK && !found; k++) {
        saltus_system *counted = NULL;
        const double omega = saltus_spec_omega(saltus_system_spec(system)) / r.best[k].taken;
        status = saltus_system_clocked(system, omega, &counted, message);
        if (status != SALTUS_OK)
            break;
        saltus_status tried = saltus_motion_cycle(counted, r.best[k].state, options, motion, &why);
        found = tried == SALTUS_OK && motion->periods == periods;
        if (tried == SALTUS_NO_MEMORY || tried == SALTUS_INTERRUPTED)
            status = saltus_fail(message, tried, "%s", why.text);
        if (!found)
            saltus_motion_clear(motion);
        saltus_system_free(counted);
    }
    if (status == SALTUS_OK && !found)
        status = saltus_fail(message, SALTUS_NO_CONVERGENCE,
                             "no orbit of %d returns is found from the %d closest returns of %lld (%.200s)",
                             periods, r.found, r.count, why.text);
    free(r.states);
    free(r.times);
    return status;
}
