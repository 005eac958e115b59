/* Maxima of the observed displacement, and the cycles of scenes without forcing.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/maxima.h"

#include "system/system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The observed velocity before an impact, from that after it and the impulse. */
static double velocity_before(const saltus_system *system, const saltus_event *event, double after) {
    int stop = saltus_system_face(system, event->face).stop;
    double share = saltus_system_observed(system, system->stop_impulse[stop]);
    return after - share * (event->velocity_after - event->velocity_before);
}

static bool is_maximum(const saltus_system *system, const saltus_event *event, const double *state) {
    const double rounding = 1e-12; /* of the velocity before, after an impact without rebound */
    if (event->kind == SALTUS_TURNING)
        return event->velocity_before < 0;
    if (!saltus_event_strikes(event))
        return false;
    double after = saltus_system_observed(system, state + saltus_system_dof(system)),
           before = velocity_before(system, event, after);
    return before > 0 && after <= rounding * before;
}

int saltus_maxima_count(saltus_maxima *m, const saltus_system *system, const saltus_event *event,
                        const double *state) {
    const bool impact = event->kind == SALTUS_IMPACT || event->kind == SALTUS_STICK;
    int change = 0;
    if (is_maximum(system, event, state)) {
        double speed = fabs(event->velocity_before);
        change = 1;
        m->falling = impact && m->run > 0 && m->face == event->face && speed < m->speed;
        m->run = !impact ? 0 : m->run > 0 && m->face == event->face ? m->run + 1 : 1;
        m->face = event->face;
        m->speed = speed;
    }
    if (event->kind == SALTUS_STICK && m->run > 1 && m->face == event->face) {
        change -= m->run - 1;
        m->run = 1;
    }
    return change;
}

/* The maxima of a lap: states, times, displacements. */
typedef struct section {
    saltus_maxima maxima;
    int n, count, room;
    double *rows; /* time, displacement, state */
} section;

static double *row_of(const section *s, int k) {
    return s->rows + (size_t)k * (size_t)(s->n + 2);
}

static bool note(section *s, const saltus_system *system, const saltus_event *event, const double *state) {
    int change = saltus_maxima_count(&s->maxima, system, event, state);
    s->count += change < 0 ? change : 0;
    if (change <= 0)
        return true;
    if (s->count == s->room) {
        int room = s->room ? 2 * s->room : 8;
        double *grown = realloc(s->rows, (size_t)room * (size_t)(s->n + 2) * sizeof *grown);
        if (!grown)
            return false;
        s->rows = grown;
        s->room = room;
    }
    double *row = row_of(s, s->count++);
    row[0] = saltus_time_periods(event->time);
    row[1] = saltus_event_displacement(system, event, state);
    memcpy(row + 2, state, (size_t)s->n * sizeof *state);
    return true;
}

/* Times of a lap are counted from `origin` on. */
static void shift_events(saltus_lap *lap, double origin) {
    int first = 0;
    for (int k = 0; k < lap->event_count; k++) {
        double time = saltus_time_periods(lap->events[k].time) - origin;
        first += time < 0;
        lap->events[k].time = saltus_time_of(time < 0 ? time + 1 : time);
    }
    for (int turn = 0; turn < first; turn++) {
        saltus_event event = lap->events[0];
        memmove(lap->events, lap->events + 1, (size_t)(lap->event_count - 1) * sizeof event);
        lap->events[lap->event_count - 1] = event;
    }
}

/* The section's rows become the lap's points, from the highest on. */
static bool hand_over(saltus_lap *lap, const section *s, const double *state) {
    size_t n = (size_t)s->n;
    int highest = 0;
    lap->periods = s->count > 0 ? s->count : 1;
    if (!saltus_lap_reserve(lap, lap->periods, s->n))
        return false;
    memcpy(lap->points, state, n * sizeof *state);
    for (int k = 1; k < s->count; k++)
        if (row_of(s, k)[1] > row_of(s, highest)[1])
            highest = k;
    for (int k = 0; k < s->count; k++)
        memcpy(lap->points + (size_t)k * n, row_of(s, (highest + k) % s->count) + 2, n * sizeof *state);
    if (s->count > 0)
        shift_events(lap, row_of(s, highest)[0]);
    return true;
}

/* On from an orbit's state, which may be a maximum, to the middle between it and the next event, where a lap
 * meets every event once. */
static saltus_status leave_event(saltus_flow *flow, double *state, saltus_message *message) {
    const double own = 1e-6; /* so soon it is the event that the state is at */
    saltus_event event = {.kind = SALTUS_STEP};
    double next = 0;
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    while (status == SALTUS_OK && next < own) {
        status = saltus_flow_advance(flow, (saltus_time){1, 0}, SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING,
                                     &event, message);
        next = saltus_time_periods(event.time);
    }
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    if (status == SALTUS_OK)
        status = saltus_flow_advance(flow, saltus_time_of(0.5 * next), 0, &event, message);
    saltus_flow_state(flow, 0, state);
    return status;
}

saltus_status saltus_lap_cycle(saltus_lap *lap, saltus_flow *flow, const double *start,
                               saltus_message *message) {
    const saltus_system *system = saltus_flow_system(flow, 0);
    section s = {.n = saltus_system_dimension(system)};
    double state[SALTUS_STATE_MAX];
    saltus_event event = {.kind = SALTUS_STEP};
    bool room = true;
    memcpy(state, start, (size_t)s.n * sizeof *state);
    saltus_status status = leave_event(flow, state, message);
    saltus_lap_begin(lap, system, state);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    while (status == SALTUS_OK && room && event.kind != SALTUS_REACHED) {
        status = saltus_flow_advance(flow, (saltus_time){1, 0}, SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING,
                                     &event, message);
        saltus_flow_state(flow, 0, state);
        if (status == SALTUS_OK && event.kind != SALTUS_REACHED)
            room = saltus_lap_add(lap, &event, state) && note(&s, system, &event, state);
    }
    if (status == SALTUS_OK && room) {
        lap->contacts = saltus_flow_contacts(flow, 0);
        lap->square = saltus_flow_information(flow, 0).square;
        lap->watched = 1;
        room = hand_over(lap, &s, start);
        if (room)
            saltus_flow_state(flow, 0, lap->end);
    }
    free(s.rows);
    return room ? status : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the events of an orbit");
}

static saltus_status clock_by(const saltus_system *system, double omega, saltus_system **clocked,
                              saltus_message *message) {
    saltus_spec spec = *saltus_system_spec(system);
    saltus_spec_set_omega(&spec, omega);
    return saltus_system_new(&spec, clocked, message);
}

/* A rest closes after any time: how far the flow would go in a period at the orbit's speed at its base, in
 * the state's scales. */
static saltus_status base_speed(saltus_flow *flow, const double *state, double *speed,
                                saltus_message *message) {
    const saltus_system *system = saltus_flow_system(flow, 0);
    const double *scale = saltus_system_scale(system);
    double field[SALTUS_STATE_MAX];
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    *speed = 0;
    if (status != SALTUS_OK)
        return status;
    saltus_flow_field(flow, 0, field);
    for (int i = 0; i < saltus_system_dimension(system); i++)
        *speed = fmax(*speed, fabs(field[i]) / scale[i] * saltus_system_period(system));
    return status;
}

saltus_status saltus_cycle_polish(const saltus_system *system, const double *guess,
                                  const saltus_orbit_options *options, saltus_orbit *orbit,
                                  saltus_system **clocked, saltus_lap *lap, saltus_message *message) {
    saltus_orbit_options shooting = *options;
    saltus_flow *flow = NULL;
    const double still = 1e-9;
    double speed;
    int part = 1;
    shooting.free_period = true;
    *clocked = NULL;
    saltus_status status = saltus_orbit_find(system, 1, guess, &shooting, orbit, message);
    if (status == SALTUS_OK)
        status = clock_by(system, orbit->omega, clocked, message);
    if (status == SALTUS_OK)
        status = saltus_flow_single(*clocked, 0, &options->flow, &flow, message);
    if (status == SALTUS_OK)
        status = base_speed(flow, orbit->state, &speed, message);
    if (status == SALTUS_OK && speed < still)
        status = saltus_fail(message, SALTUS_NO_CONVERGENCE, "Newton's iteration ends in a rest");
    if (status == SALTUS_OK)
        status = saltus_lap_cycle(lap, flow, orbit->state, message);
    if (status == SALTUS_OK)
        part = lap->periods / saltus_lap_least_period(lap, &options->flow);
    saltus_flow_free(flow);
    if (status == SALTUS_OK && part == 1)
        return status;
    saltus_orbit longer = *orbit;
    saltus_system *slower = *clocked;
    *orbit = (saltus_orbit){0};
    *clocked = NULL;
    saltus_system *faster = NULL;
    if (status == SALTUS_OK)
        status = clock_by(slower, longer.omega * part, &faster, message);
    if (status == SALTUS_OK)
        status = saltus_cycle_polish(faster, longer.state, options, orbit, clocked, lap, message);
    saltus_system_free(faster);
    saltus_system_free(slower);
    saltus_orbit_clear(&longer);
    return status;
}
