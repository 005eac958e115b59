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
 * release three zeros are divided out. While a face stays close, gap and rate are carried from the step's
 * polynomial to the next step, because n.q - d loses all digits there.
 * - The earliest event of a step wins; the state is evaluated there, the event is applied, and the flow goes
 * on. Faces reached in the same instant (to rounding) share one impact.
 * - Complete chatter, sticking and release: see contact.c. A held face is not searched for impacts, only its
 * force for the fall through zero.
 * - A start on a stop: approaching faces are hit at once, opening ones leave, resting ones hold if pressed
 * (the first coefficient of the gap's series that stands out of rounding decides). A start beyond a stop is
 * refused.
 * - Not found: nothing by design. If a gap should end a step beyond its stop, or thousands of events pass
 * while time stands still, the call fails with time, gap and speed in the message. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#include "flow/flow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { idle_events_max = 100000, impacts_per_period_max = 1000000 };

double saltus_time_periods(saltus_time time) {
    return (double)time.cycle + time.phase;
}

saltus_time saltus_time_after(saltus_time time, double periods) {
    double phase = time.phase + periods, whole = floor(phase);
    return (saltus_time){time.cycle + (long long)whole, phase - whole};
}

saltus_flow_options saltus_flow_defaults(void) {
    return (saltus_flow_options){.rtol = 1e-13, .atol = 1e-16, .integrator = SALTUS_AUTOMATIC};
}

/* Fastest by measurement on impacting pipes: the step grows with the order until stability caps it. */
static int automatic_order(double rtol) {
    int order = 2 * (int)lround(-log10(rtol) - 1);
    return order < 10 ? 10 : order > 32 ? 32 : order;
}

static saltus_status check_options(const saltus_flow_options *o, saltus_message *message) {
    if (!(o->rtol >= 1e-15 && o->rtol <= 1e-3))
        return saltus_fail(message, SALTUS_BAD_INPUT, "rtol = %g: must be at least 1e-15 and at most 1e-3",
                           o->rtol);
    if (!(o->atol >= 0 && o->atol <= 1))
        return saltus_fail(message, SALTUS_BAD_INPUT, "atol = %g: must be at least 0 and at most 1", o->atol);
    if (o->order != 0 && (o->order < 8 || o->order > SALTUS_ORDER_MAX))
        return saltus_fail(message, SALTUS_BAD_INPUT, "order = %d: must be 0 or from 8 to %d", o->order,
                           SALTUS_ORDER_MAX);
    if (o->columns < 0 || o->columns > 256)
        return saltus_fail(message, SALTUS_BAD_INPUT, "columns = %d: must be from 0 to 256", o->columns);
    if (o->integrator < SALTUS_AUTOMATIC || o->integrator > SALTUS_RADAU)
        return saltus_fail(message, SALTUS_BAD_INPUT, "integrator: must be automatic, taylor or radau");
    return SALTUS_OK;
}

static saltus_status check_systems(const saltus_system *const *systems, int lanes, saltus_message *message) {
    for (int l = 1; l < lanes; l++) {
        const saltus_system *a = systems[0], *b = systems[l];
        bool same = a->spec.model == b->spec.model && a->dof == b->dof && a->extra == b->extra &&
                    a->face_count == b->face_count && a->spec.stop_count == b->spec.stop_count;
        for (int f = 0; same && f < a->face_count; f++)
            same = a->faces[f].stop == b->faces[f].stop && a->faces[f].side == b->faces[f].side;
        if (!same || a->coefficients.terms != b->coefficients.terms)
            return saltus_fail(
                message, SALTUS_BAD_INPUT,
                "systems side by side must have the same model, size, terms and kind of stops");
    }
    return SALTUS_OK;
}

static void reserve(saltus_flow *flow) {
    saltus_arena *arena = &flow->arena;
    size_t n = (size_t)flow->dof, dimension = (size_t)flow->dimension, faces = SALTUS_FACES_MAX;
    saltus_contact_map scratch = {.push = saltus_arena_doubles(arena, faces * n),
                                  .pull = saltus_arena_doubles(arena, faces * n)};
    flow->scratch = scratch;
    for (int l = 0; l < flow->lanes; l++) {
        saltus_lane *self = &flow->lane[l];
        self->hold.push = saltus_arena_doubles(arena, faces * n);
        self->hold.pull = saltus_arena_doubles(arena, faces * n);
        self->state = saltus_arena_doubles(arena, dimension);
        self->tangents = saltus_arena_doubles(arena, dimension * (size_t)flow->options.columns);
        self->before = saltus_arena_doubles(arena, dimension);
        self->after = saltus_arena_doubles(arena, dimension);
        self->trial = saltus_arena_doubles(arena, dimension);
        self->delay = saltus_arena_doubles(arena, (size_t)flow->options.columns);
    }
}

/* The first row of the gap series is the observed displacement, in scenes without a stop too. */
static void load_system(saltus_work *work, const saltus_kernel *kernel, int lane,
                        const saltus_system *system) {
    kernel->load(work, lane, system);
    if (system->spec.stop_count == 0)
        for (int i = 0; i < system->dof; i++)
            work->normal[i * work->stride + lane] = system->observer[i];
}

static saltus_status open_works(saltus_flow *flow, const saltus_system *const *systems) {
    enum { probe_order = 8 };
    const saltus_system *first = systems[0];
    saltus_status status =
        saltus_work_open(&flow->work, flow->kernel, first, flow->options.order, flow->options.columns);
    for (int l = 0; l < flow->lanes && status == SALTUS_OK; l++) {
        load_system(&flow->work, flow->kernel, l, systems[l]);
        status = saltus_work_open(&flow->probe[l], flow->narrow, first, probe_order, 0);
        if (status == SALTUS_OK)
            load_system(&flow->probe[l], flow->narrow, 0, systems[l]);
    }
    flow->work.tolerance_relative = flow->options.rtol;
    flow->work.tolerance_absolute = flow->options.atol;
    flow->work.tolerance_tangent = fmax(flow->options.rtol, 1e-13);
    if (status == SALTUS_OK && flow->integrator == SALTUS_RADAU)
        status = saltus_radau_open(&flow->radau, first, flow->options.columns, &flow->work);
    return status;
}

saltus_status saltus_flow_new(const saltus_system *const *systems, int lanes,
                              const saltus_flow_options *options, saltus_flow **flow,
                              saltus_message *message) {
    *flow = NULL;
    saltus_status status = check_options(options, message);
    if (status != SALTUS_OK)
        return status;
    const saltus_system *first = systems[0];
    const saltus_kernel *narrow = saltus_kernel_find(first->spec.model->name, 1);
    const saltus_kernel *wide = lanes == 1 ? narrow : saltus_kernel_find(first->spec.model->name, 0);
    bool stiff =
        options->integrator == SALTUS_RADAU || (options->integrator == SALTUS_AUTOMATIC && first->stiff);
    if (lanes < 1 || lanes > wide->lanes || (stiff && lanes > 1))
        return saltus_fail(message, SALTUS_BAD_INPUT, "lanes = %d: %s", lanes,
                           stiff ? "a stiff system runs one trajectory at a time"
                                 : "more than this processor's vectors hold");
    status = check_systems(systems, lanes, message);
    if (status != SALTUS_OK)
        return status;

    saltus_flow *made = calloc(1, sizeof *made);
    saltus_lane *lane = calloc((size_t)wide->lanes, sizeof *lane);
    saltus_work *probe = calloc((size_t)wide->lanes, sizeof *probe);
    if (!made || !lane || !probe) {
        free(made);
        free(lane);
        free(probe);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the flow");
    }
    *made = (saltus_flow){.options = *options,
                          .kernel = wide,
                          .narrow = narrow,
                          .lanes = wide->lanes,
                          .dimension = first->dimension,
                          .dof = first->dof,
                          .extra = first->extra,
                          .integrator = stiff ? SALTUS_RADAU : SALTUS_TAYLOR,
                          .lane = lane,
                          .probe = probe};
    if (made->options.order == 0 || stiff)
        made->options.order = stiff ? SALTUS_RADAU_DEGREE : automatic_order(options->rtol);
    reserve(made);
    if (!saltus_arena_open(&made->arena)) {
        saltus_flow_free(made);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the flow");
    }
    reserve(made);
    /* Lanes beyond those asked for idle at rest with the first lane's system. */
    const saltus_system *all[16];
    for (int l = 0; l < made->lanes; l++)
        all[l] = made->lane[l].system = systems[l < lanes ? l : 0];
    status = open_works(made, all);
    if (status != SALTUS_OK) {
        saltus_flow_free(made);
        return saltus_fail(message, status, "no memory for the flow");
    }
    *flow = made;
    return SALTUS_OK;
}

void saltus_flow_free(saltus_flow *flow) {
    if (!flow)
        return;
    for (int l = 0; l < flow->lanes; l++)
        saltus_work_close(&flow->probe[l]);
    saltus_work_close(&flow->work);
    saltus_radau_close(flow->radau);
    saltus_arena_close(&flow->arena);
    free(flow->lane);
    free(flow->probe);
    free(flow);
}

int saltus_flow_width(const saltus_system *system) {
    return saltus_kernel_find(system->spec.model->name, 0)->lanes;
}

const saltus_system *saltus_flow_system(const saltus_flow *flow, int lane) {
    return flow->lane[lane].system;
}
int saltus_flow_columns(const saltus_flow *flow) {
    return flow->options.columns;
}
saltus_time saltus_flow_time(const saltus_flow *flow, int lane) {
    return flow->lane[lane].now;
}
unsigned saltus_flow_contacts(const saltus_flow *flow, int lane) {
    return flow->lane[lane].contacts;
}
saltus_flow_info saltus_flow_information(const saltus_flow *flow, int lane) {
    return flow->lane[lane].info;
}
double saltus_flow_step_length(const saltus_flow *flow, int lane) {
    return flow->lane[lane].step;
}
saltus_time saltus_flow_step_begin(const saltus_flow *flow, int lane) {
    return flow->lane[lane].begin;
}

/* One column of the work's start rows to or from a plain vector. */
static void gather(const saltus_flow *flow, int lane, int column, double *vector) {
    const saltus_work *w = &flow->work;
    for (int i = 0; i < flow->dof; i++) {
        vector[i] = w->xq[column * w->row + i * w->stride + lane];
        vector[flow->dof + i] = w->xv[column * w->row + i * w->stride + lane];
    }
    for (int i = 0; i < flow->extra; i++)
        vector[2 * flow->dof + i] = w->xe[column * w->extra_row + i * w->stride + lane];
}

static void scatter(saltus_flow *flow, int lane, int column, const double *vector) {
    saltus_work *w = &flow->work;
    for (int i = 0; i < flow->dof; i++) {
        w->xq[column * w->row + i * w->stride + lane] = vector[i];
        w->xv[column * w->row + i * w->stride + lane] = vector[flow->dof + i];
    }
    for (int i = 0; i < flow->extra; i++)
        w->xe[column * w->extra_row + i * w->stride + lane] = vector[2 * flow->dof + i];
}

static void gather_all(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    gather(flow, lane, 0, self->state);
    for (int c = 0; c < flow->options.columns; c++)
        gather(flow, lane, c + 1, self->tangents + c * flow->dimension);
}

static void scatter_all(saltus_flow *flow, int lane) {
    const saltus_lane *self = &flow->lane[lane];
    scatter(flow, lane, 0, self->state);
    for (int c = 0; c < flow->options.columns; c++)
        scatter(flow, lane, c + 1, self->tangents + c * flow->dimension);
}

void saltus_flow_state(const saltus_flow *flow, int lane, double *state) {
    gather(flow, lane, 0, state);
}

void saltus_flow_tangents(const saltus_flow *flow, int lane, double *tangents) {
    for (int c = 0; c < flow->options.columns; c++)
        gather(flow, lane, c + 1, tangents + c * flow->dimension);
}

void saltus_flow_set_tangents(saltus_flow *flow, int lane, const double *tangents) {
    for (int c = 0; c < flow->options.columns; c++)
        scatter(flow, lane, c + 1, tangents + c * flow->dimension);
}

void saltus_flow_delays(const saltus_flow *flow, int lane, double *delays) {
    for (int c = 0; c < flow->options.columns; c++)
        delays[c] = flow->lane[lane].delay[c];
}

void saltus_flow_field(saltus_flow *flow, int lane, double *derivative) {
    saltus_lane *self = &flow->lane[lane];
    gather(flow, lane, 0, self->state);
    saltus_field_at(flow, lane, self->state, self->now.phase, &self->hold, derivative);
}

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
        if (saltus_system_gap(system, f, self->state) < -4e-16 * (size + fabs(system->faces[f].d)))
            continue;
        double velocity = saltus_face_normal(system, f, self->state + system->dof);
        if (fabs(velocity) <= 1e-15 * speed)
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

saltus_status saltus_flow_start(saltus_flow *flow, int lane, saltus_time time, const double *state,
                                saltus_message *message) {
    saltus_lane *self = &flow->lane[lane];
    saltus_status status = saltus_system_check_state(self->system, state, message);
    if (status != SALTUS_OK)
        return status;
    self->now = self->begin = self->until = saltus_time_after(time, 0);
    self->aimed = self->turned = false;
    self->step = 0;
    self->contacts = 0;
    self->hold.count = 0;
    self->idle_events = self->cycle_events = 0;
    self->last_speed = 0;
    self->info = (saltus_flow_info){0};
    memset(self->face, 0, sizeof self->face);
    memcpy(self->state, state, (size_t)flow->dimension * sizeof *state);
    memset(self->tangents, 0, (size_t)(flow->dimension * flow->options.columns) * sizeof *state);
    for (int c = 0; c < flow->options.columns && c < flow->dimension; c++)
        self->tangents[c * flow->dimension + c] = 1;
    if (flow->radau)
        saltus_radau_reset(flow->radau);
    status = resolve_start(flow, lane);
    scatter_all(flow, lane);
    return status == SALTUS_OK ? status
                               : saltus_fail(message, status, "the start on a stop could not be resolved");
}

/* Time left to the target, in periods. */
static double remaining(const saltus_lane *self) {
    return (double)(self->until.cycle - self->now.cycle) + (self->until.phase - self->now.phase);
}

void saltus_flow_aim(saltus_flow *flow, int lane, saltus_time until, unsigned watch) {
    saltus_lane *self = &flow->lane[lane];
    self->until = saltus_time_after(until, 0);
    self->watch = watch;
    self->aimed = true;
    bool turning = false;
    for (int l = 0; l < flow->lanes; l++)
        turning |= flow->lane[l].aimed && flow->lane[l].watch & SALTUS_WATCH_TURNING;
    if (self->system->spec.stop_count == 0)
        flow->work.stops = turning;
}

/* The step a lane takes: its own, or what is left to the target, or half of that when a sliver would remain.
 */
static double plan_step(saltus_lane *self, double step) {
    double left = remaining(self) * self->system->period;
    self->land = -1;
    if (step >= left) {
        self->land = self->until.phase;
        return left;
    }
    return step > 0.5 * left ? 0.5 * left : step;
}

/* Jets of all lanes, and where each lane's step ends: at its own length, the target or the first event. */
static saltus_status expand_lanes(saltus_flow *flow, saltus_message *message) {
    saltus_work *w = &flow->work;
    for (int l = 0; l < flow->lanes; l++)
        w->phase[l] = flow->lane[l].now.phase;
    if (flow->integrator == SALTUS_RADAU) {
        saltus_lane *self = &flow->lane[0];
        double left = remaining(self) * self->system->period;
        saltus_status status = saltus_radau_step(flow->radau, w, left, &self->info.field_evaluations);
        if (status != SALTUS_OK)
            return saltus_fail(message, status, "no step of the stiff integrator converges at %.15g periods",
                               saltus_time_periods(self->now));
    } else {
        flow->kernel->expand(w, w->order);
        flow->kernel->measure(w);
    }
    for (int l = 0; l < flow->lanes; l++) {
        saltus_lane *self = &flow->lane[l];
        w->advance[l] = 0;
        if (!self->aimed)
            continue;
        double planned = plan_step(self, w->step[l]);
        bool moves = planned > 0 && self->now.phase + planned / self->system->period != self->now.phase;
        if (!moves && remaining(self) > 0)
            return saltus_fail(message, SALTUS_STALLED,
                               "the step falls to %.3g at %.15g periods: the motion grows without bound",
                               planned, saltus_time_periods(self->now));
        w->advance[l] = saltus_events_first(flow, l, planned);
        if (self->pending.kind != SALTUS_STEP && w->advance[l] < planned)
            self->land = -1;
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
            self->delay[c] = 0;
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
        saltus_contacts_release(flow, lane, event->face);
    }
    if (flow->radau)
        saltus_radau_impact(flow->radau);
    return status;
}

/* While a contact holds, rounding must not lift the state off the stop. */
static void keep_contacts(saltus_flow *flow, int lane) {
    saltus_lane *self = &flow->lane[lane];
    int n = flow->dof;
    saltus_contact_map_settle(self->system, &self->hold, self->state);
    for (int c = 0; c < flow->options.columns; c++) {
        saltus_contact_map_apply(&self->hold, n, self->tangents + c * flow->dimension);
        saltus_contact_map_apply(&self->hold, n, self->tangents + c * flow->dimension + n);
    }
}

/* Move a lane's clock and contact knowledge to the end of its step and apply the event there. */
static saltus_status conclude(saltus_flow *flow, int lane, saltus_message *message) {
    saltus_lane *self = &flow->lane[lane];
    double step = flow->work.advance[lane], gap = 0;
    bool contact_event = self->pending.kind == SALTUS_IMPACT || self->pending.kind == SALTUS_RELEASE;
    bool sound = saltus_events_carry(flow, lane, step, contact_event ? self->pending.face : -1, &gap);
    self->begin = self->now;
    self->step = step;
    self->now = self->land >= 0 ? self->until : saltus_time_after(self->now, step / self->system->period);
    self->info.steps++;
    if (flow->integrator == SALTUS_TAYLOR)
        self->info.field_evaluations += flow->work.order;
    self->turned = self->pending.kind == SALTUS_TURNING;
    self->idle_events = contact_event && self->now.phase == self->begin.phase ? self->idle_events + 1 : 0;
    self->cycle_events = self->now.cycle == self->begin.cycle ? self->cycle_events + contact_event : 0;
    bool goes_on = self->idle_events < idle_events_max && self->cycle_events < impacts_per_period_max;
    saltus_status status = sound && goes_on ? SALTUS_OK : SALTUS_STALLED;
    if (status == SALTUS_OK && (self->contacts || self->pending.kind != SALTUS_STEP)) {
        gather_all(flow, lane);
        keep_contacts(flow, lane);
        if (self->pending.kind != SALTUS_STEP)
            status = apply_event(flow, lane);
        if (contact_event)
            self->last_speed = self->pending.velocity_before;
        scatter_all(flow, lane);
    }
    if (status != SALTUS_OK)
        return saltus_fail(message, status, "the flow stalls at %.15g periods (%s): gap %.3g, speed %.3g",
                           saltus_time_periods(self->now),
                           goes_on
                               ? "a gap is passed or an impact has no solution"
                               : "bounces without end; a restitution of 1 never comes to rest under pressure",
                           gap, self->last_speed);
    return SALTUS_OK;
}

/* Whether a lane's run ends here, with the event to be reported. */
static bool finished(saltus_lane *self) {
    bool watched = self->pending.kind != SALTUS_STEP && self->watch >> self->pending.kind & 1;
    if (watched || (self->pending.kind == SALTUS_STICK && self->watch & SALTUS_WATCH_IMPACT))
        return true;
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

saltus_status saltus_flow_run(saltus_flow *flow, int *lane, saltus_event *event, saltus_message *message) {
    int ready = waiting_lane(flow);
    while (ready < 0) {
        saltus_status status = expand_lanes(flow, message);
        *lane = 0;
        for (int l = 0; l < flow->lanes && status == SALTUS_OK; l++)
            if (flow->lane[l].aimed) {
                status = conclude(flow, l, message);
                flow->lane[l].ended = finished(&flow->lane[l]);
                *lane = l;
            }
        if (status != SALTUS_OK) {
            flow->lane[*lane].aimed = false;
            return status;
        }
        ready = waiting_lane(flow);
    }
    saltus_lane *self = &flow->lane[ready];
    if (!self->ended)
        self->pending = (saltus_event){.kind = SALTUS_REACHED, .face = -1, .time = self->now};
    self->aimed = self->ended = false;
    *lane = ready;
    *event = self->pending;
    return SALTUS_OK;
}

saltus_status saltus_flow_advance(saltus_flow *flow, saltus_time until, unsigned watch, saltus_event *event,
                                  saltus_message *message) {
    int lane = 0;
    saltus_flow_aim(flow, 0, until, watch);
    return saltus_flow_run(flow, &lane, event, message);
}

static double series_value(const double *series, size_t stride, int degree, double time) {
    double sum = 0;
    for (int k = degree; k >= 0; k--)
        sum = fma(sum, time, series[(size_t)k * stride]);
    return sum;
}

void saltus_flow_dense(const saltus_flow *flow, int lane, double since, double *state) {
    const saltus_work *w = &flow->work;
    size_t orders = saltus_work_jet(w, 1, 0), extras = saltus_work_extra_jet(w, 1, 0);
    for (int i = 0; i < flow->dof; i++) {
        size_t place = (size_t)(i * w->stride + lane);
        state[i] = series_value(w->q + place, orders, w->order, since);
        state[flow->dof + i] = series_value(w->v + place, orders, w->order, since);
    }
    for (int i = 0; i < flow->extra; i++)
        state[2 * flow->dof + i] = series_value(w->e + i * w->stride + lane, extras, w->order, since);
}
