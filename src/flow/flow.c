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
 * release two zeros are divided out; the third coefficient, zero up to rounding, counts as part of the gap.
 * While a face stays close, n.q - d loses all digits, so gap and rate are carried from the step's polynomial
 * to the next step.
 * - The earliest event of a step wins; the state is evaluated there, the event is applied, and the flow goes
 * on. Faces reached in the same instant (to rounding) share one impact. Turning points of the observed
 * displacement are events too, unless a function takes them (saltus_flow_aim_observed): then they end no
 * step.
 * - Complete chatter, sticking and release: see contact.c. A held face is not searched for impacts, only its
 * force for the fall through zero.
 * - A start on a stop: approaching faces are hit at once, opening ones leave, resting ones hold if pressed
 * (the first coefficient of the gap's series that stands out of rounding decides). A start beyond a stop is
 * refused.
 * - Not found: nothing by design. If a gap should end a step beyond its stop, or thousands of events pass
 * while time stands still, the call fails with time, gap and speed in the message.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/flow.h"

#include "base/progress.h"
#include "flow/quiet.h"
#include "system/cause.h"

#include <math.h>
#include <string.h>

enum { idle_events_max = 100000, impacts_per_period_max = 1000000 };
/* After this many steps in a period it is clear how many the whole period takes. */
static const double first_steps = 100000;

/* Resolve contacts at the start: of the touched faces, approaching ones are hit, resting ones may hold. */
static saltus_status resolve_start(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    const saltus_system *system = self->system;
    const double *velocity = flow->state + system->dof;
    double size = 0, speed = 0;
    unsigned resting = 0;
    for (int i = 0; i < system->dof; i++) {
        size += fabs(flow->state[i]);
        speed += fabs(velocity[i]);
    }
    for (int f = 0; f < system->face_count; f++) {
        if (saltus_system_gap_sign(system, f, flow->state) < 0)
            continue;
        double rounding =
            1e-15 * (speed + flow->work.lane->omega_unit[lane] * (size + fabs(system->faces[f].d)));
        if (fabs(saltus_face_normal(system, f, velocity)) <= rounding)
            resting |= 1u << f;
        self->face[f] = (saltus_face_state){.touch = 1};
    }
    saltus_contacts_rest(flow, lane, resting);
    saltus_status status = SALTUS_OK;
    for (int f = 0; f < system->face_count && status == SALTUS_OK; f++) {
        saltus_event event;
        if (self->face[f].touch == 1 && !(resting >> f & 1) && saltus_face_normal(system, f, velocity) > 0)
            status = saltus_contacts_impact(flow, lane, f, INFINITY, &event);
    }
    return status;
}

void saltus_flow_restart(saltus_flow *flow, int lane, saltus_time time, const double *state) {
    saltus_lane *self = &flow->lane[lane];
    const int n = flow->dimension, steady = flow->options.columns - flow->options.directions;
    const saltus_time now = saltus_time_after(time, 0);
    *self = (saltus_lane){.system = self->system,
                          .degree = self->degree,
                          .first = self->first,
                          .later = self->later,
                          .brief = self->brief,
                          .flight = INFINITY,
                          .cycle_from = now.phase,
                          .now = now,
                          .target = {.until = now},
                          .step = {.begin = now},
                          .hold = {.push = self->hold.push, .pull = self->hold.pull},
                          .delay = self->delay};
    saltus_quiet_break(flow, lane);
    flow->work.lane->taken[lane] = 0;
    memcpy(flow->state, state, (size_t)n * sizeof *state);
    memset(flow->tangents, 0, (size_t)(n * flow->options.columns) * sizeof *state);
    for (int c = 0; c < steady && c < n; c++)
        flow->tangents[c * n + c] = 1;
    if (flow->lanes == 1)
        saltus_work_clear_states(&flow->work);
    saltus_flow_break(flow, true);
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
    if (status == SALTUS_OK)
        return status;
    const char *why = flow->lane[lane].why.text;
    return saltus_fail(message, status, "%s", *why ? why : "the start on a stop could not be resolved");
}

/* Time left to the target, in periods. */
static double remaining(const saltus_lane *self) {
    return saltus_time_between(self->now, self->target.until);
}

void saltus_flow_aim(saltus_flow *flow, int lane, saltus_time until, unsigned watch) {
    saltus_flow_aim_observed(flow, lane, until, watch, (saltus_turnings){.take = NULL});
}

void saltus_flow_aim_observed(saltus_flow *flow, int lane, saltus_time until, unsigned watch,
                              saltus_turnings turnings) {
    saltus_lane *self = &flow->lane[lane];
    saltus_status status = saltus_time_check(until, &self->why);
    saltus_quiet_end(flow, lane);
    saltus_quiet_break(flow, lane);
    self->target.aimed = true;
    flow->due |= 1u << lane;
    if (status != SALTUS_OK) { /* reported by the next run */
        self->failure = status;
        self->ended = true;
        return;
    }
    self->target.until = saltus_time_after(until, 0);
    if (!self->ended && !self->queued && remaining(self) > 0)
        flow->due &= ~(1u << lane);
    self->target.watch = watch;
    self->target.turnings = turnings;
    self->step.turns = false;
    /* An observed displacement that is no stop's coordinate has a row of the gap series while watched. */
    bool apart = false;
    for (int l = 0; l < flow->lanes; l++)
        apart |= flow->lane[l].target.aimed && flow->lane[l].target.watch & SALTUS_WATCH_TURNING &&
                 flow->lane[l].system->observer.first == flow->lane[l].system->spec.stop_count;
    flow->work.stops = self->system->spec.stop_count + apart;
}

/* Fail a lane that cannot go on: add to *why which part of the equations has no value there, if any. */
static saltus_status fail_here(saltus_flow *flow, int lane, saltus_message *why) {
    const saltus_lane *self = &flow->lane[lane];
    saltus_message what = {.text = ""};
    saltus_lane_gather(flow, lane, 0, flow->state);
    if (why && saltus_system_fault(self->system, flow->state, self->now.phase, &what)) {
        const saltus_message first = *why;
        saltus_fail(why, SALTUS_STALLED, "%s: %s", first.text, what.text);
    }
    return SALTUS_STALLED;
}

/* The same within a run, for a lane that has set its `why`; the lane stays where it is. */
static void give_up(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    self->failure = fail_here(flow, lane, &self->why);
    flow->work.lane->advance[lane] = flow->work.lane->passing[lane] = 0;
}

/* How many steps a period of the lane may take: more if it is longer than the period to which the effort's
 * step counts refer. */
static double steps_most(const saltus_flow *flow, const saltus_lane *self) {
    const saltus_effort *effort = flow->options.effort;
    const double own = self->system->period;
    return flow->period_steps_max * (effort ? fmax(1, own / saltus_effort_period(effort, own)) : 1);
}

/* A lane's state at a time within its step, from the step's series; at the begin from order 0 alone, because
 * higher orders may not be finite. */
static void state_since(const saltus_flow *flow, int lane, double since, double *state) {
    const saltus_work *w = &flow->work;
    saltus_flow_dense(flow, lane, since, state);
    for (int i = 0; i < flow->dof && since == 0; i++) {
        state[i] = w->jet.q[saltus_work_place(w, 0, 0, i, lane)];
        state[flow->dof + i] = w->jet.v[saltus_work_place(w, 0, 0, i, lane)];
    }
    for (int i = 0; i < flow->extra && since == 0; i++)
        state[2 * flow->dof + i] = w->jet.e[saltus_work_extra_place(w, 0, 0, i, lane)];
}

/* Whether the equations have a value at a time since the step's begin. */
static bool defined_since(saltus_flow *flow, int lane, double since) {
    const saltus_lane *self = &flow->lane[lane];
    double size = 0;
    state_since(flow, lane, since, flow->trial);
    for (int i = 0; i < flow->dimension; i++)
        size += fabs(flow->trial[i]);
    return isfinite(size) &&
           saltus_system_defined(self->system, flow->trial, self->now.phase + since / self->system->period);
}

/* The step leaves the domain of the equations: find when, by bisection, and say what has no value there. */
static saltus_status fail_undefined(saltus_flow *flow, int lane, double step) {
    enum { halvings = 60 };
    saltus_lane *self = &flow->lane[lane];
    double inside = 0, outside = defined_since(flow, lane, 0) ? step : 0;
    for (int k = 0; k < halvings && inside < outside; k++) {
        double middle = 0.5 * (inside + outside);
        *(defined_since(flow, lane, middle) ? &inside : &outside) = middle;
    }
    const double ends[] = {outside, inside}, begin = saltus_time_periods(self->now);
    saltus_message what = {.text = "the equations have no value"};
    bool found = false;
    for (int k = 0; k < 2 && !found; k++) {
        state_since(flow, lane, ends[k], flow->trial);
        found = saltus_system_fault(self->system, flow->trial,
                                    self->now.phase + ends[k] / self->system->period, &what);
    }
    return saltus_fail(&self->why, SALTUS_STALLED, "the motion ends at %.15g periods: %s",
                       begin + outside / self->system->period, what.text);
}

static bool watches_turning(const saltus_lane *self) {
    return self->target.aimed && self->target.watch & SALTUS_WATCH_TURNING;
}

/* Those of a set of lanes with watched turning points, as bits, whose observed displacement has the same row
 * of the gap series as that of the first of them. */
static unsigned lanes_of_one_row(const saltus_flow *flow, unsigned lanes) {
    const int row = flow->observer[__builtin_ctz(lanes)];
    unsigned same = 0;
    for (unsigned left = lanes; left; left &= left - 1) {
        const int l = __builtin_ctz(left);
        same |= (unsigned)(flow->observer[l] == row) << l;
    }
    return same;
}

/* Bound the observed velocities of a set of lanes over `advance`. */
static void bound_velocities(saltus_flow *flow, unsigned lanes) {
    for (unsigned left = lanes, same; left; left &= ~same) {
        same = lanes_of_one_row(flow, left);
        flow->kernel->bound_velocity(&flow->work, flow->observer[__builtin_ctz(same)]);
    }
}

/* Find the lanes that may meet a turning point that is an event in the planned step. */
static void expect_turnings(saltus_flow *flow) {
    saltus_lane_numbers *numbers = flow->work.lane;
    bound_velocities(flow, flow->turning);
    for (unsigned left = flow->turning; left; left &= left - 1) {
        const int l = __builtin_ctz(left);
        saltus_lane *self = &flow->lane[l];
        self->step.turns = !(numbers->turning[l] < 0) || self->turned;
        if (self->step.turns)
            numbers->near[l] = 1;
    }
}

/* Once all lanes' steps are made: pass on the turning points that are no events, and add to the mean squares.
 */
static void observe(saltus_flow *flow) {
    const int pieces = flow->collocated ? 4 : 1;
    bound_velocities(flow, flow->observed);
    for (unsigned left = flow->turning | flow->observed; left; left &= left - 1) {
        const int l = __builtin_ctz(left);
        saltus_lane *self = &flow->lane[l];
        if (self->failure != SALTUS_OK)
            continue;
        self->info.square += flow->kernel->integrate_square(&flow->work, flow->observer[l], l, pieces) /
                             flow->work.lane->period[l];
        if (flow->observed >> l & 1 && (!(flow->work.lane->turning[l] < 0) || self->passing))
            saltus_events_turnings(flow, l);
    }
}

/* Whether a lane may take the planned step. If a period or the whole question would take too many steps, or
 * time does not advance, the lane fails where it is. */
static bool leads_on(saltus_flow *flow, int lane, double planned) {
    saltus_lane *self = &flow->lane[lane];
    const saltus_work *w = &flow->work;
    const saltus_effort *effort = flow->options.effort;
    const bool spent = effort && effort->spent > SALTUS_EFFORT_MOST,
               moves = planned > 0 && self->now.phase + w->lane->passing[lane] != self->now.phase;
    /* Most steps end here; `steps_most` is never below `period_steps_max`. */
    if (self->cycle_steps < first_steps && self->cycle_steps < flow->period_steps_max && !spent && moves)
        return true;
    const double gone = self->now.phase - self->cycle_from, most = steps_most(flow, self);
    const bool many = self->cycle_steps >= first_steps || self->cycle_steps >= most;
    char cause[SALTUS_CAUSE_MAX];
    if (spent)
        saltus_effort_check(effort, self->system, &self->why);
    else if (many && self->cycle_steps > most * gone)
        saltus_fail(
            &self->why, SALTUS_STALLED,
            "%s, T = %.6g, would take more than %.0e steps (%d of them, %.3g long, go over %.3g T): %s",
            self->system->spec.model->forcing >= 0 ? "a forcing period" : "a unit of time",
            self->system->period, most, self->cycle_steps, planned, gone,
            saltus_system_cause(self->system, cause));
    else if (moves || !(w->lane->left[lane] > 0))
        return true;
    else if (self->system->guarded && !defined_since(flow, lane, 0))
        fail_undefined(flow, lane, 0);
    else
        saltus_fail(&self->why, SALTUS_STALLED,
                    "the step falls to %.3g at %.15g periods: the motion grows without bound, or %s", planned,
                    saltus_time_periods(self->now), saltus_system_cause(self->system, cause));
    give_up(flow, lane);
    return false;
}

/* Set what a lane's next step begins with. */
static void prepare(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    saltus_lane_numbers *to = flow->work.lane;
    saltus_quiet_end(flow, lane);
    to->phase[lane] = self->now.phase;
    to->left[lane] = self->target.aimed ? remaining(self) * self->system->period : 0;
    self->step.calm = self->hold.faces == 0 && !self->target.coasting;
    for (int f = 0; f < self->system->face_count; f++)
        self->step.calm &= self->face[f].touch == 0 && !self->face[f].shadow;
    const bool damps = self->step.calm && !flow->radau && !flow->options.columns;
    to->reach[lane] = damps ? to->damped[lane] : to->limit[lane];
    const unsigned bit = 1u << lane, watches = watches_turning(self) ? bit : 0;
    flow->turning = (flow->turning & ~bit) | (self->target.turnings.take ? 0 : watches);
    flow->observed = (flow->observed & ~bit) | (self->target.turnings.take ? watches : 0);
    flow->observer[lane] = self->system->observer.first;
    saltus_quiet_begin(flow, lane);
}

/* Jets of all lanes, and where each lane's step ends: at its own length, the target or the first event. Of
 * the lanes in *passed the step is concluded. */
static saltus_status expand_lanes(saltus_flow *flow, unsigned *passed, saltus_message *message) {
    saltus_work *w = &flow->work;
    bool measured = true;
    for (unsigned left = saltus_lanes_but(flow, flow->quiet); left; left &= left - 1)
        prepare(flow, __builtin_ctz(left));
    if (flow->radau) {
        saltus_status status = saltus_flow_mix(flow);
        if (status != SALTUS_OK) {
            char cause[SALTUS_CAUSE_MAX];
            saltus_fail(message, status, "no step of the stiff integrator converges at %.15g periods: %s",
                        saltus_time_periods(flow->lane[0].now),
                        saltus_system_cause(flow->lane[0].system, cause));
            fail_here(flow, 0, message);
            return status;
        }
    } else {
        measured = saltus_flow_expand(flow);
    }
    const unsigned all = saltus_lanes_but(flow, 0);
    const bool together = !measured && !flow->turning;
    if (together) {
        *passed = flow->kernel->proceed(w, all, &flow->quiet);
    } else {
        if (!measured)
            flow->kernel->measure(w);
        flow->kernel->plan(w);
        if (flow->turning)
            expect_turnings(flow);
        *passed = saltus_quiet_pass(flow);
    }
    for (unsigned left = saltus_lanes_but(flow, *passed); left; left &= left - 1) {
        const int l = __builtin_ctz(left);
        saltus_lane *self = &flow->lane[l];
        if (!self->target.aimed)
            continue;
        saltus_quiet_end(flow, l);
        const double planned = w->lane->advance[l];
        if (!leads_on(flow, l, planned))
            continue;
        self->pending.kind = SALTUS_STEP;
        self->step.lands = planned == w->lane->left[l];
        if (self->step.calm && w->lane->near[l] < 0)
            continue;
        const saltus_first_event first = saltus_events_first(flow, l, planned);
        if (first.kind != SALTUS_STEP)
            self->pending = (saltus_event){.kind = first.kind, .face = first.face};
        self->step.lands &= first.time >= planned;
        if (first.time != planned) {
            w->lane->advance[l] = first.time;
            w->lane->passing[l] = first.time / self->system->period;
        }
    }
    if (!together || *passed != all)
        flow->kernel->evaluate(w);
    if (flow->turning | flow->observed)
        observe(flow);
    return SALTUS_OK;
}

static void apply_turning(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    saltus_event *event = &self->pending;
    const double *observer = self->system->observer.row, *field = flow->before + flow->dof;
    for (int i = 0; i < flow->dof; i++)
        event->displacement = fma(observer[i], flow->state[i], event->displacement);
    if (flow->options.columns == 0) {
        event->velocity_before =
            saltus_events_acceleration(flow, lane, self->system->observer.first, observer, self->step.length);
        return;
    }
    /* Delays need the state's accuracy, so use the field there, not the polynomial's second derivative. */
    saltus_field_at(flow, lane, flow->state, self->now.phase, &self->hold, flow->before);
    for (int i = 0; i < flow->dof; i++)
        event->velocity_before = fma(observer[i], field[i], event->velocity_before);
    for (int c = 0; c < flow->options.columns; c++) {
        const double *delta = flow->tangents + c * flow->dimension + flow->dof;
        self->delay[c] = -saltus_column_observer(flow, c, flow->state + flow->dof) / event->velocity_before;
        for (int i = 0; i < flow->dof; i++)
            self->delay[c] -= observer[i] * delta[i] / event->velocity_before;
    }
}

static saltus_status apply_event(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    saltus_event *event = &self->pending;
    saltus_status status = SALTUS_OK;
    event->time = self->now;
    if (event->kind == SALTUS_TURNING) {
        apply_turning(flow, lane);
        return SALTUS_OK;
    }
    const saltus_face f = self->system->faces[event->face];
    if (event->kind == SALTUS_IMPACT) {
        const double *normal = self->system->stop_normal[f.stop];
        const double acceleration =
            f.side * saltus_events_acceleration(flow, lane, f.stop, normal, self->step.length);
        status = saltus_contacts_impact(flow, lane, event->face, acceleration, event);
    } else {
        event->displacement = f.side * f.d;
        if (!saltus_contacts_release(flow, lane, event->face))
            event->kind = SALTUS_STEP;
    }
    saltus_flow_break(flow, false);
    return status;
}

void saltus_flow_keep_contacts(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    saltus_contact_map_settle(self->system, &self->hold, flow->state);
    for (int c = 0; c < flow->options.columns; c++)
        saltus_column_settle(flow, lane, c);
}

/* Advance a lane's time and counters to the end of its step. */
static void pass_time(saltus_flow *flow, int lane, bool contact_event) {
    saltus_lane *self = &flow->lane[lane];
    const double phase = self->now.phase + flow->work.lane->passing[lane];
    const saltus_time begin = self->step.begin = self->now;
    self->step.length = flow->work.lane->advance[lane];
    if (self->step.lands)
        self->now = self->target.until;
    else if (phase < 1)
        self->now.phase = phase;
    else
        self->now = saltus_time_after(self->now, flow->work.lane->passing[lane]);
    self->info.steps++;
    if (flow->options.effort)
        saltus_effort_add(flow->options.effort,
                          self->step.length /
                              saltus_effort_period(flow->options.effort, self->system->period),
                          flow->dof, flow->options.columns, flow->collocated);
    flow->mixture.layers -= self->step.length;
    self->flight = self->flight > self->step.length ? self->flight - self->step.length : INFINITY;
    if (!flow->collocated)
        self->info.field_evaluations += (long long)flow->work.lane->degree[lane];
    if (self->now.cycle != begin.cycle || self->cycle_steps == 0)
        self->cycle_from = self->now.phase;
    self->cycle_steps = self->now.cycle == begin.cycle ? self->cycle_steps + 1 : 0;
    self->turned = self->pending.kind == SALTUS_TURNING;
    self->idle_events = contact_event && self->now.phase == begin.phase ? self->idle_events + 1 : 0;
    self->cycle_events = self->now.cycle == begin.cycle ? self->cycle_events + contact_event : 0;
}

/* Advance a lane's time and what is known of its contacts to the end of its step, and apply the event. */
static saltus_status conclude(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    const double step = flow->work.lane->advance[lane];
    const bool event = self->pending.kind != SALTUS_STEP, quiet = self->step.calm && !event;
    const bool contact_event = self->pending.kind == SALTUS_IMPACT || self->pending.kind == SALTUS_RELEASE;
    double gap = 0;
    if (self->system->guarded && !defined_since(flow, lane, step))
        return fail_undefined(flow, lane, step);
    bool sound =
        quiet || saltus_events_carry(flow, lane, step, contact_event ? self->pending.face : -1, &gap);
    pass_time(flow, lane, contact_event);
    if (flow->options.directions)
        saltus_columns_rephase(flow, lane, step);
    if (quiet)
        return SALTUS_OK;
    bool endless = self->idle_events >= idle_events_max || self->cycle_events >= impacts_per_period_max;
    if (sound && !endless && (self->hold.count || event)) {
        saltus_lane_gather_all(flow, lane);
        saltus_flow_keep_contacts(flow, lane);
        self->why.text[0] = '\0';
        sound = !event || apply_event(flow, lane) == SALTUS_OK;
        if (contact_event)
            self->last_speed = self->pending.velocity_before;
        saltus_lane_scatter_all(flow, lane);
    }
    if (sound && !endless)
        return SALTUS_OK;
    if (!sound && !endless && self->why.text[0])
        return SALTUS_STALLED;
    char cause[SALTUS_CAUSE_MAX];
    return saltus_fail(&self->why, SALTUS_STALLED,
                       "the flow stalls at %.15g periods (%s): gap %.3g, speed %.3g: %s",
                       saltus_time_periods(self->now),
                       endless ? "bounces without end; a restitution that is 1, or tends to 1 for small "
                                 "closing speeds, never comes to rest under pressure"
                               : "a gap is passed or an impact has no solution",
                       gap, self->last_speed, saltus_system_cause(self->system, cause));
}

static saltus_event plain_event(saltus_event_kind kind, saltus_time time) {
    return (saltus_event){.kind = kind, .face = -1, .time = time};
}

/* Whether a lane's run ends here; then `pending` is the event to report. */
static bool finished(saltus_lane *self) {
    const unsigned watch = self->target.watch;
    bool watched = self->pending.kind != SALTUS_STEP && watch >> self->pending.kind & 1;
    if (watched || (self->pending.kind == SALTUS_STICK && watch & SALTUS_WATCH_IMPACT))
        return true;
    self->queued = 0;
    bool reached = remaining(self) <= 0;
    if (reached || watch & SALTUS_WATCH_STEP)
        self->pending = plain_event(reached ? SALTUS_REACHED : SALTUS_STEP, self->now);
    return reached || watch & SALTUS_WATCH_STEP;
}

/* An aimed lane that is at its target or has an event to report; -1: none. */
static int waiting_lane(const saltus_flow *flow) {
    for (int l = 0; l < flow->lanes; l++)
        if (flow->lane[l].target.aimed && (flow->lane[l].ended || remaining(&flow->lane[l]) <= 0))
            return l;
    return -1;
}

/* Report the next impact of the same instant as one already reported; dropped if impacts are not watched. */
static bool next_queued(saltus_flow *flow, int *lane, saltus_event *event) {
    for (int l = 0; l < flow->lanes; l++) {
        saltus_lane *self = &flow->lane[l];
        if (!self->target.aimed || self->ended || self->queued == 0)
            continue;
        if (self->target.watch & SALTUS_WATCH_IMPACT) {
            *event = self->queue[--self->queued];
            *lane = l;
            self->target.aimed = false;
            return true;
        }
        self->queued = 0;
    }
    return false;
}

saltus_status saltus_flow_run(saltus_flow *flow, int *lane, saltus_event *event, saltus_message *message) {
    if (flow->due && next_queued(flow, lane, event))
        return SALTUS_OK;
    int ready = flow->due ? waiting_lane(flow) : -1;
    if (ready < 0)
        flow->due = 0;
    while (ready < 0) {
        unsigned passed = 0;
        *lane = 0;
        if (saltus_stop_asked(flow->options.stop))
            return saltus_fail(message, SALTUS_INTERRUPTED, "interrupted at %.15g periods",
                               saltus_time_periods(saltus_flow_time(flow, 0)));
        saltus_status status = expand_lanes(flow, &passed, message);
        if (status != SALTUS_OK) {
            flow->lane[0].target.aimed = false;
            return status;
        }
        /* A failure is kept until the lane's turn comes, so that the others finish their steps. */
        for (unsigned left = saltus_lanes_but(flow, passed); left; left &= left - 1) {
            const int l = __builtin_ctz(left);
            saltus_lane *self = &flow->lane[l];
            if (!self->target.aimed)
                continue;
            if (self->failure == SALTUS_OK)
                self->failure = conclude(flow, l);
            self->ended = self->failure != SALTUS_OK || finished(self);
            flow->due |= (unsigned)self->ended << l;
        }
        if (flow->due)
            ready = __builtin_ctz(flow->due);
    }
    saltus_lane *self = &flow->lane[ready];
    saltus_status failure = self->failure;
    if (!self->ended)
        self->pending = plain_event(SALTUS_REACHED, self->now);
    self->target.aimed = self->ended = false;
    self->failure = SALTUS_OK;
    flow->due &= ~(1u << ready);
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
