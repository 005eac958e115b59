/* Quiet lanes.
 *
 * Most steps of most lanes meet nothing: no face is near, no contact holds, the target is further away. The
 * kernel takes such lanes on for all lanes at once, and what a lane counts is brought up to date only when a
 * step of it may meet something. Only a lane's own state decides, and time passes by the same arithmetic, so
 * its bits do not depend on its neighbours.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_QUIET_H
#define SALTUS_FLOW_QUIET_H

#include "flow/flow.h"

#include <math.h>

/* Whether the kernel may take a lane on as long as its steps meet nothing. */
static inline bool saltus_quiet_allowed(const saltus_flow *flow, const saltus_lane *self) {
    return !flow->radau && !flow->options.effort && !flow->options.directions && !flow->transients &&
           self->step.calm && self->target.aimed && !(self->target.watch & SALTUS_WATCH_STEP) &&
           !self->turned && self->failure == SALTUS_OK &&
           self->cycle_steps + SALTUS_QUIET_STEPS < flow->period_steps_max && !self->system->guarded;
}

/* Leave a lane to the kernel, if that is allowed, once its next step is prepared. */
static inline void saltus_quiet_begin(saltus_flow *flow, int lane) {
    const saltus_lane *self = &flow->lane[lane];
    saltus_lane_numbers *to = flow->work.lane;
    if (!saltus_quiet_allowed(flow, self) || fmin(to->left[lane], self->flight) <= self->brief) {
        to->quiet[lane] = 1;
        return;
    }
    to->quiet[lane] = -1;
    to->cycles[lane] = (double)(self->target.until.cycle - self->now.cycle);
    to->until[lane] = self->target.until.phase;
    to->flight[lane] = self->flight;
    to->brief[lane] = self->brief;
}

/* A lane's time, and what it has counted, with the steps that the kernel took on. */
static inline saltus_time saltus_quiet_time(const saltus_flow *flow, int lane) {
    const saltus_lane_numbers *numbers = flow->work.lane;
    const saltus_lane *self = &flow->lane[lane];
    if (numbers->taken[lane] == 0)
        return self->now;
    return (saltus_time){self->target.until.cycle - (long long)numbers->cycles[lane], numbers->phase[lane]};
}

static inline saltus_flow_info saltus_quiet_information(const saltus_flow *flow, int lane) {
    const double steps = flow->work.lane->taken[lane];
    saltus_flow_info info = flow->lane[lane].info;
    info.steps += (long long)steps;
    info.field_evaluations += (long long)(steps * flow->work.lane->degree[lane]);
    return info;
}

/* Bring a lane's time and counters up to date. */
static inline void saltus_quiet_end(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    double *taken = &flow->work.lane->taken[lane];
    if (*taken == 0)
        return;
    const saltus_time now = saltus_quiet_time(flow, lane);
    if (now.cycle != self->now.cycle) {
        self->cycle_from = now.phase;
        self->cycle_steps = self->cycle_events = 0;
    } else {
        self->cycle_steps += (int)*taken;
    }
    self->now = now;
    self->info = saltus_quiet_information(flow, lane);
    self->flight = flow->work.lane->flight[lane];
    self->idle_events = 0;
    *taken = 0;
}

/* To be called when a lane is given another start, target or system. */
static inline void saltus_quiet_break(saltus_flow *flow, int lane) {
    flow->quiet &= ~(1u << lane);
}

/* The lanes, as bits, whose planned step meets nothing and is concluded. */
static inline unsigned saltus_quiet_pass(saltus_flow *flow) {
    return flow->kernel->pass(&flow->work, &flow->quiet);
}

#endif
