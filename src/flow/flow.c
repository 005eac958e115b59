/* The event-driven flow.
 *
 * The event contract
 *
 * - A step covers (begin, begin + h]. Its dense output is a polynomial, and each face's gap, each holding
 * contact's force and, where asked for, the observer's velocity are polynomials of it. Events are zeros of
 * these.
 * - An impact is the first rise of a gap through zero: two rises or a rise and a fall within one step count,
 * a maximum that stays below zero or just touches it does not (isolate.h). A root at the step's end belongs
 * to the step.
 * - Just after an impact the gap is zero and opening. That zero is divided out of the polynomial, so the face
 * is watched again from the same instant, without a dead time: the next rise, however soon, is found. After a
 * release two zeros are divided out, and what rounding makes of the third is part of the gap. While a face
 * stays close, gap and rate are carried from the step's polynomial to the next step, because n.q - d loses
 * all digits there.
 * - The earliest event of a step wins; the state is evaluated there, the event is applied, and the flow goes
 * on. Faces reached in the same instant (to rounding) share one impact.
 * - Complete chatter, sticking and release: see contact.c. A held face is not searched for impacts, only its
 * force for the fall through zero.
 * - A start on a stop: approaching faces are hit at once, opening ones leave, resting ones hold if pressed
 * (the first coefficient of the gap's series that stands out of rounding decides). A start beyond a stop is
 * refused.
 * - Not found: nothing by design. If a gap should end a step beyond its stop, or thousands of events pass
 * while time stands still, the call fails with time, gap and speed in the message.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include <math.h>
#include <string.h>

enum { idle_events_max = 100000, impacts_per_period_max = 1000000 };

/* Faces the state touches, sorted by what it does there: hit, leave, rest. Impacts at the start are applied.
 */
static saltus_status resolve_start(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    const saltus_system *system = self->system;
    double size = 0, speed = 0;
    unsigned resting = 0;
    for (int i = 0; i < system->dof; i++) {
        size += fabs(self->state[i]);
        speed += fabs(self->state[system->dof + i]);
    }
    for (int f = 0; f < system->face_count; f++) {
        if (saltus_system_gap_sign(system, f, self->state) < 0)
            continue;
        double velocity = saltus_face_normal(system, f, self->state + system->dof);
        if (fabs(velocity) <=
            1e-15 * (speed + flow->work.omega_unit[lane] * (size + fabs(system->faces[f].d))))
            resting |= 1u << f;
        self->face[f] = (saltus_face_state){.touch = 1};
    }
    saltus_contacts_rest(flow, lane, resting);
    for (int f = 0; f < system->face_count; f++) {
        saltus_event event;
        bool hit = self->face[f].touch == 1 && !(resting >> f & 1) &&
                   saltus_face_normal(system, f, self->state + system->dof) > 0;
        saltus_status status = hit ? saltus_contacts_impact(flow, lane, f, &event) : SALTUS_OK;
        if (status != SALTUS_OK)
            return status;
    }
    return SALTUS_OK;
}

void saltus_flow_restart(saltus_flow *flow, int lane, saltus_time time, const double *state) {
    saltus_lane *self = &flow->lane[lane];
    int steady = flow->options.columns - flow->options.directions;
    self->now = self->begin = self->until = saltus_time_after(time, 0);
    self->aimed = self->ended = self->turned = self->coasting = false;
    self->failure = SALTUS_OK;
    self->step = 0;
    self->contacts = 0;
    self->hold.count = 0;
    self->idle_events = self->cycle_events = self->queued = 0;
    self->last_speed = 0;
    self->info = (saltus_flow_info){0};
    memset(self->face, 0, sizeof self->face);
    memcpy(self->state, state, (size_t)flow->dimension * sizeof *state);
    memset(self->tangents, 0, (size_t)(flow->dimension * flow->options.columns) * sizeof *state);
    for (int c = 0; c < steady && c < flow->dimension; c++)
        self->tangents[c * flow->dimension + c] = 1;
    if (flow->lanes == 1)
        saltus_work_clear_states(&flow->work);
    if (flow->radau)
        saltus_radau_reset(flow->radau);
}

saltus_status saltus_flow_start(saltus_flow *flow, int lane, saltus_time time, const double *state,
                                saltus_message *message) {
    saltus_status status = saltus_time_check(time, message);
    if (status == SALTUS_OK)
        status = saltus_system_check_state(flow->lane[lane].system, state, message);
    if (status != SALTUS_OK)
        return status;
    saltus_flow_restart(flow, lane, time, state);
    status = resolve_start(flow, lane);
    saltus_lane_scatter_all(flow, lane);
    return status == SALTUS_OK ? status
                               : saltus_fail(message, status, "the start on a stop could not be resolved");
}

/* Time left to the target, in periods. */
static double remaining(const saltus_lane *self) {
    return (double)(self->until.cycle - self->now.cycle) + (self->until.phase - self->now.phase);
}

void saltus_flow_aim(saltus_flow *flow, int lane, saltus_time until, unsigned watch) {
    saltus_lane *self = &flow->lane[lane];
    saltus_status status = saltus_time_check(until, &self->why);
    if (status != SALTUS_OK) { /* told by the next run */
        self->failure = status;
        self->aimed = self->ended = true;
        return;
    }
    self->until = saltus_time_after(until, 0);
    self->watch = watch;
    self->aimed = true;
    bool turning = false;
    for (int l = 0; l < flow->lanes; l++)
        turning |= flow->lane[l].aimed && flow->lane[l].watch & SALTUS_WATCH_TURNING;
    if (self->system->spec.stop_count == 0)
        flow->work.stops = turning;
}

static void set_out(saltus_flow *flow) {
    saltus_work *w = &flow->work;
    for (int l = 0; l < flow->lanes; l++) {
        const saltus_lane *self = &flow->lane[l];
        w->phase[l] = self->now.phase;
        w->left[l] = self->aimed ? remaining(self) * self->system->period : 0;
    }
}

/* Jets of all lanes, and where each lane's step ends: at its own length, the target or the first event. */
static saltus_status expand_lanes(saltus_flow *flow, saltus_message *message) {
    saltus_work *w = &flow->work;
    set_out(flow);
    if (flow->integrator == SALTUS_RADAU) {
        saltus_lane *self = &flow->lane[0];
        saltus_status status = saltus_radau_step(flow->radau, w, w->left[0], &self->info.field_evaluations);
        if (status != SALTUS_OK)
            return saltus_fail(message, status, "no step of the stiff integrator converges at %.15g periods",
                               saltus_time_periods(self->now));
    } else {
        flow->kernel->expand(w, w->order);
        flow->kernel->measure(w);
    }
    flow->kernel->plan(w);
    for (int l = 0; l < flow->lanes; l++) {
        saltus_lane *self = &flow->lane[l];
        if (!self->aimed)
            continue;
        const double planned = w->advance[l];
        bool moves = planned > 0 && self->now.phase + w->passing[l] != self->now.phase;
        if (!moves && w->left[l] > 0) {
            self->failure =
                saltus_fail(&self->why, SALTUS_STALLED,
                            "the step falls to %.3g at %.15g periods: the motion grows without bound",
                            planned, saltus_time_periods(self->now));
            w->advance[l] = w->passing[l] = 0;
            continue;
        }
        const double first = saltus_events_first(flow, l, planned);
        bool whole = self->pending.kind == SALTUS_STEP || first >= planned;
        self->lands = planned == w->left[l] && whole;
        if (first != planned) {
            w->advance[l] = first;
            w->passing[l] = first / self->system->period;
        }
    }
    flow->kernel->evaluate(w, w->order);
    return SALTUS_OK;
}

static saltus_status apply_event(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    saltus_event *event = &self->pending;
    saltus_status status = SALTUS_OK;
    event->time = self->now;
    if (event->kind == SALTUS_TURNING) {
        const double *observer = self->system->observer;
        saltus_field_at(flow, lane, self->state, self->now.phase, &self->hold, self->before);
        event->displacement = event->velocity_before = 0;
        for (int i = 0; i < flow->dof; i++) {
            event->displacement = fma(observer[i], self->state[i], event->displacement);
            event->velocity_before = fma(observer[i], self->before[flow->dof + i], event->velocity_before);
        }
        for (int c = 0; c < flow->options.columns; c++) {
            const double *delta = self->tangents + c * flow->dimension + flow->dof;
            self->delay[c] =
                -saltus_column_observer(flow, c, self->state + flow->dof) / event->velocity_before;
            for (int i = 0; i < flow->dof; i++)
                self->delay[c] -= observer[i] * delta[i] / event->velocity_before;
        }
        return SALTUS_OK;
    }
    if (event->kind == SALTUS_IMPACT)
        status = saltus_contacts_impact(flow, lane, event->face, event);
    else {
        saltus_face f = self->system->faces[event->face];
        event->displacement = f.side * f.d;
        if (!saltus_contacts_release(flow, lane, event->face))
            event->kind = SALTUS_STEP;
    }
    if (flow->radau)
        saltus_radau_impact(flow->radau);
    return status;
}

void saltus_flow_keep_contacts(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    saltus_contact_map_settle(self->system, &self->hold, self->state);
    for (int c = 0; c < flow->options.columns; c++)
        saltus_column_settle(flow, lane, c);
}

static saltus_status stalled(const saltus_flow *flow, int lane, bool endless, double gap,
                             saltus_message *message) {
    const saltus_lane *self = &flow->lane[lane];
    return saltus_fail(message, SALTUS_STALLED, "the flow stalls at %.15g periods (%s): gap %.3g, speed %.3g",
                       saltus_time_periods(self->now),
                       endless ? "bounces without end; a restitution of 1 never comes to rest under pressure"
                               : "a gap is passed or an impact has no solution",
                       gap, self->last_speed);
}

/* Move a lane's clock to the end of its step. */
static void pass_time(const saltus_flow *flow, int lane, bool contact_event) {
    saltus_lane *self = &flow->lane[lane];
    const double phase = self->now.phase + flow->work.passing[lane];
    self->begin = self->now;
    self->step = flow->work.advance[lane];
    if (self->lands)
        self->now = self->until;
    else if (phase < 1)
        self->now.phase = phase;
    else
        self->now = saltus_time_after(self->now, flow->work.passing[lane]);
    self->info.steps++;
    if (flow->integrator == SALTUS_TAYLOR)
        self->info.field_evaluations += flow->work.order;
    self->turned = self->pending.kind == SALTUS_TURNING;
    self->idle_events = contact_event && self->now.phase == self->begin.phase ? self->idle_events + 1 : 0;
    self->cycle_events = self->now.cycle == self->begin.cycle ? self->cycle_events + contact_event : 0;
}

/* Move a lane's clock and contact knowledge to the end of its step and apply the event there. */
static saltus_status conclude(saltus_flow *flow, int lane, saltus_message *message) {
    saltus_lane *self = &flow->lane[lane];
    double step = flow->work.advance[lane], gap = 0;
    bool contact_event = self->pending.kind == SALTUS_IMPACT || self->pending.kind == SALTUS_RELEASE;
    bool quiet = self->calm && self->pending.kind == SALTUS_STEP;
    bool sound =
        quiet || saltus_events_carry(flow, lane, step, contact_event ? self->pending.face : -1, &gap);
    pass_time(flow, lane, contact_event);
    if (flow->options.directions)
        saltus_columns_rephase(flow, lane, step);
    if (quiet)
        return SALTUS_OK;
    bool endless = self->idle_events >= idle_events_max || self->cycle_events >= impacts_per_period_max;
    if (!sound || endless)
        return stalled(flow, lane, endless, gap, message);
    if (self->contacts || self->pending.kind != SALTUS_STEP) {
        saltus_lane_gather_all(flow, lane);
        saltus_flow_keep_contacts(flow, lane);
        saltus_status status = self->pending.kind != SALTUS_STEP ? apply_event(flow, lane) : SALTUS_OK;
        if (contact_event)
            self->last_speed = self->pending.velocity_before;
        saltus_lane_scatter_all(flow, lane);
        if (status != SALTUS_OK)
            return stalled(flow, lane, false, gap, message);
    }
    return SALTUS_OK;
}

/* Whether a lane's run ends here, with the event to be reported. */
static bool finished(saltus_lane *self) {
    bool watched = self->pending.kind != SALTUS_STEP && self->watch >> self->pending.kind & 1;
    if (watched || (self->pending.kind == SALTUS_STICK && self->watch & SALTUS_WATCH_IMPACT))
        return true;
    self->queued = 0;
    if (remaining(self) <= 0)
        self->pending = (saltus_event){.kind = SALTUS_REACHED, .face = -1, .time = self->now};
    else if (self->watch & SALTUS_WATCH_STEP)
        self->pending = (saltus_event){.kind = SALTUS_STEP, .face = -1, .time = self->now};
    else
        return false;
    return true;
}

/* A lane that is aimed and has nothing left to do before its target, or whose event waits to be fetched. */
static int waiting_lane(const saltus_flow *flow) {
    for (int l = 0; l < flow->lanes; l++)
        if (flow->lane[l].aimed && (flow->lane[l].ended || remaining(&flow->lane[l]) <= 0))
            return l;
    return -1;
}

/* The next impact that happened in the same instant as one already reported; dropped where impacts are not
 * watched. */
static bool next_queued(saltus_flow *flow, int *lane, saltus_event *event) {
    for (int l = 0; l < flow->lanes; l++) {
        saltus_lane *self = &flow->lane[l];
        if (!self->aimed || self->ended || self->queued == 0)
            continue;
        if (self->watch & SALTUS_WATCH_IMPACT) {
            *event = self->queue[--self->queued];
            *lane = l;
            self->aimed = false;
            return true;
        }
        self->queued = 0;
    }
    return false;
}

/* The end of a lane's step. A failure is kept until the lane's turn comes, so that the others finish theirs.
 */
static void finish_step(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    if (self->failure == SALTUS_OK)
        self->failure = conclude(flow, lane, &self->why);
    self->ended = self->failure != SALTUS_OK || finished(self);
}

static saltus_status interrupted(const saltus_flow *flow, saltus_message *message) {
    return saltus_fail(message, SALTUS_INTERRUPTED, "interrupted at %.15g periods",
                       saltus_time_periods(flow->lane[0].now));
}

saltus_status saltus_flow_run(saltus_flow *flow, int *lane, saltus_event *event, saltus_message *message) {
    if (next_queued(flow, lane, event))
        return SALTUS_OK;
    int ready = waiting_lane(flow);
    while (ready < 0) {
        saltus_status status = flow->options.stop && *flow->options.stop ? interrupted(flow, message)
                                                                         : expand_lanes(flow, message);
        *lane = 0;
        if (status != SALTUS_OK) {
            flow->lane[0].aimed &= status == SALTUS_INTERRUPTED;
            return status;
        }
        for (int l = 0; l < flow->lanes; l++)
            if (flow->lane[l].aimed)
                finish_step(flow, l);
        ready = waiting_lane(flow);
    }
    saltus_lane *self = &flow->lane[ready];
    saltus_status failure = self->failure;
    if (!self->ended)
        self->pending = (saltus_event){.kind = SALTUS_REACHED, .face = -1, .time = self->now};
    self->aimed = self->ended = false;
    self->failure = SALTUS_OK;
    *lane = ready;
    *event = self->pending;
    return failure == SALTUS_OK ? failure : saltus_fail(message, failure, "%s", self->why.text);
}

saltus_status saltus_flow_advance(saltus_flow *flow, saltus_time until, unsigned watch, saltus_event *event,
                                  saltus_message *message) {
    int lane = 0;
    saltus_flow_aim(flow, 0, until, watch);
    return saltus_flow_run(flow, &lane, event, message);
}
