/* Recording of trajectories: samples at exact phases from the dense output, both sides of every impact.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/trajectory.h"

#include "base/progress.h"
#include "flow/effort.h"
#include "orbit/lap.h"

#include <limits.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* A recording in progress. */
typedef struct recorder {
    saltus_trajectory *record;
    const saltus_system *system;
    const saltus_trajectory_plan *plan;
    saltus_flow *flow;
    long long rows_room, events_room;
    long long next, last; /* numbers of the next and of the last sample */
    long long told;       /* the period last shown as progress */
} recorder;

void saltus_trajectory_clear(saltus_trajectory *record) {
    free(record->time);
    free(record->states);
    free(record->displacement);
    free(record->velocity);
    free(record->events);
    free(record->event_rows);
    free(record->strobe_states);
    *record = (saltus_trajectory){0};
}

/* Resize one array; the old one stays valid if there is no memory. */
static bool grow(void *array, long long count, size_t size) {
    void *old, *grown;
    memcpy(&old, array, sizeof old);
    if ((unsigned long long)count > SIZE_MAX / 2 / size)
        return false;
    grown = realloc(old, (size_t)count * size);
    if (grown)
        memcpy(array, &grown, sizeof grown);
    return grown != NULL;
}

static bool reserve_rows(recorder *self, long long room) {
    saltus_trajectory *r = self->record;
    bool done = grow(&r->time, room, sizeof(double)) &&
                grow(&r->states, room, (size_t)r->dimension * sizeof(double)) &&
                grow(&r->displacement, room, sizeof(double)) && grow(&r->velocity, room, sizeof(double));
    self->rows_room = done ? room : self->rows_room;
    return done;
}

static bool reserve_events(recorder *self, long long room) {
    saltus_trajectory *r = self->record;
    bool done =
        grow(&r->events, room, sizeof *r->events) && grow(&r->event_rows, room, sizeof *r->event_rows);
    self->events_room = done ? room : self->events_room;
    return done;
}

static bool add_row(recorder *self, double time, const double *state) {
    saltus_trajectory *r = self->record;
    if (r->samples == self->rows_room && !reserve_rows(self, 2 * self->rows_room))
        return false;
    long long row = r->samples++;
    r->time[row] = time;
    memcpy(r->states + row * r->dimension, state, (size_t)r->dimension * sizeof *state);
    r->displacement[row] = saltus_system_observed(self->system, state);
    r->velocity[row] = saltus_system_observed(self->system, state + saltus_system_dof(self->system));
    return true;
}

static void add_strobe(recorder *self, const double *state) {
    saltus_trajectory *r = self->record;
    if (self->next % self->plan->per_period == 0 && self->next < self->last)
        memcpy(r->strobe_states + r->strobes++ * r->dimension, state, (size_t)r->dimension * sizeof *state);
}

/* Time of sample k; the phase is a quotient, so that errors do not accumulate. */
static saltus_time sample_time(const recorder *self, long long k) {
    const int per_period = self->plan->per_period;
    return (saltus_time){k / per_period, (double)(k % per_period) / per_period};
}

/* Take the samples within the flow's last step, and at its end unless an event ends it. */
static bool take_samples(recorder *self, bool event) {
    double state[SALTUS_STATE_MAX];
    for (; self->next <= self->last; self->next++) {
        saltus_time time = sample_time(self, self->next);
        int order = saltus_flow_state_at(self->flow, 0, time, state);
        if (order > 0 || (order == 0 && event))
            return true;
        if (order == 0)
            saltus_flow_state(self->flow, 0, state);
        add_strobe(self, state);
        if (!add_row(self, saltus_time_periods(time), state))
            return false;
    }
    return true;
}

/* Record an event, with a row of the state before it and, unless it is a release, one of the state after it.
 * The row before also stands for a sample at the same time. */
static bool take_event(recorder *self, const saltus_event *event) {
    saltus_trajectory *r = self->record;
    saltus_time now = saltus_flow_time(self->flow, 0);
    saltus_face face = saltus_system_face(self->system, event->face);
    double state[SALTUS_STATE_MAX];
    if (r->event_count == self->events_room && !reserve_events(self, 2 * self->events_room))
        return false;
    saltus_flow_state_at(self->flow, 0, now, state);
    if (self->next <= self->last && saltus_time_compare(sample_time(self, self->next), now) == 0) {
        add_strobe(self, state);
        self->next++;
    }
    long long row = r->samples;
    if (!add_row(self, saltus_time_periods(now), state))
        return false;
    r->events[r->event_count] = *event;
    r->event_rows[r->event_count++] = row;
    bool jumps = event->kind != SALTUS_RELEASE,
         observed_stop = saltus_system_stop_observed(self->system, face.stop);
    saltus_flow_state(self->flow, 0, state);
    if (jumps && !add_row(self, saltus_time_periods(now), state))
        return false;
    if (observed_stop) {
        for (long long k = row; k < r->samples; k++)
            r->displacement[k] = face.side * face.d;
        r->velocity[row] = jumps ? event->velocity_before : 0;
        if (event->kind == SALTUS_STICK)
            r->velocity[row + 1] = 0;
    }
    return true;
}

/* Show progress when a new period begins. */
static void tell(recorder *self) {
    const saltus_trajectory_plan *plan = self->plan;
    long long cycle = saltus_flow_time(self->flow, 0).cycle;
    if (cycle != self->told)
        saltus_progress_show(plan->progress, (double)(plan->transient + cycle),
                             (double)(plan->transient + plan->periods));
    self->told = cycle;
}

/* Record samples and events from the flow's state, at phase 0, until a later period begins. */
static saltus_status record_stretch(recorder *self, long long until, saltus_message *message) {
    enum { watch = SALTUS_WATCH_STEP | SALTUS_WATCH_CONTACT };
    saltus_event event = {.kind = SALTUS_STEP};
    const saltus_time end = {until, 0};
    bool room = take_samples(self, false);
    while (room && event.kind != SALTUS_REACHED) {
        saltus_status status = saltus_flow_advance(self->flow, end, watch, &event, message);
        if (status != SALTUS_OK)
            return status;
        tell(self);
        bool contact = 1u << event.kind & SALTUS_WATCH_CONTACT;
        room = take_samples(self, contact) && (!contact || take_event(self, &event));
    }
    return room ? SALTUS_OK : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the record");
}

saltus_status saltus_trajectory_follow(const saltus_system *system, const double *state,
                                       const saltus_flow_options *options, const saltus_trajectory_plan *plan,
                                       saltus_trajectory *record, saltus_message *message) {
    enum { most = 1000000000 };
    const long long transient = plan->transient, periods = plan->periods;
    *record = (saltus_trajectory){0};
    if (transient < 0 || transient > LLONG_MAX / 2)
        return saltus_fail(message, SALTUS_BAD_INPUT, "transient = %lld: must be at least 0 periods",
                           transient);
    if (periods < 1 || periods > most)
        return saltus_fail(message, SALTUS_BAD_INPUT, "periods = %lld: must be from 1 to %d", periods, most);
    if (plan->per_period < 1 || plan->per_period > 1000000)
        return saltus_fail(message, SALTUS_BAD_INPUT, "samples per period = %d: must be from 1 to 1000000",
                           plan->per_period);
    recorder self = {.record = record,
                     .system = system,
                     .plan = plan,
                     .last = periods * plan->per_period,
                     .told = LLONG_MIN};
    saltus_effort effort;
    const saltus_flow_options own = saltus_effort_begin(options, system, &effort);
    saltus_status status = saltus_flow_single(system, 0, &own, &self.flow, message);
    record->dimension = saltus_system_dimension(system);
    if (status == SALTUS_OK &&
        !(reserve_rows(&self, self.last + 1 + 64) && reserve_events(&self, 64) &&
          grow(&record->strobe_states, periods, (size_t)record->dimension * sizeof(double))))
        status =
            saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a record of %lld samples", self.last + 1);
    /* Along an orbit from one section point to the next, otherwise after the transient. */
    for (long long k = 0; plan->orbit && k < periods && status == SALTUS_OK; k++) {
        const double *point = plan->points + (size_t)(k % plan->orbit) * (size_t)record->dimension;
        status = saltus_flow_start(self.flow, 0, (saltus_time){k, 0}, point, message);
        if (status == SALTUS_OK)
            status = record_stretch(&self, k + 1, message);
    }
    const unsigned watch = plan->progress.show ? SALTUS_WATCH_STEP : 0;
    saltus_event event = {.kind = transient ? SALTUS_STEP : SALTUS_REACHED};
    if (status == SALTUS_OK && !plan->orbit)
        status = saltus_flow_start(self.flow, 0, (saltus_time){-transient, 0}, state, message);
    while (status == SALTUS_OK && !plan->orbit && event.kind != SALTUS_REACHED) {
        status = saltus_flow_advance(self.flow, (saltus_time){0, 0}, watch, &event, message);
        if (status == SALTUS_OK)
            tell(&self);
    }
    if (status == SALTUS_OK && !plan->orbit)
        status = record_stretch(&self, periods, message);
    saltus_flow_free(self.flow);
    record->interrupted = status == SALTUS_INTERRUPTED;
    if (status != SALTUS_OK && !record->interrupted)
        saltus_trajectory_clear(record);
    return status;
}

saltus_status saltus_trajectory_record(const saltus_system *system, const double *state,
                                       const saltus_flow_options *options, long long transient,
                                       long long periods, int per_period, saltus_trajectory *record,
                                       saltus_message *message) {
    const saltus_trajectory_plan plan = {
        .transient = transient, .periods = periods, .per_period = per_period};
    return saltus_trajectory_follow(system, state, options, &plan, record, message);
}
