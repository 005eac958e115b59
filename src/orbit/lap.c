/* Once around an orbit: counts, extremes, label, least period, mirror image.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/lap.h"

#include "base/dense.h"
#include "flow/flow.h"
#include "system/system.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool saltus_event_strikes(const saltus_event *event) {
    return (event->kind == SALTUS_IMPACT || event->kind == SALTUS_STICK) && event->velocity_before != 0;
}

void saltus_lap_begin(saltus_lap *lap, const saltus_system *system, const double *state) {
    double displacement = saltus_system_observed(system, state);
    *lap = (saltus_lap){.system = system,
                        .keeps_events = lap->keeps_events,
                        .keeps_turnings = lap->keeps_turnings,
                        .largest = displacement,
                        .smallest = displacement,
                        .events = lap->events,
                        .event_room = lap->event_room,
                        .points = lap->points,
                        .end = lap->end,
                        .point_room = lap->point_room};
}

/* On the observed stop the event's displacement is more accurate than a sum over the modes. */
double saltus_event_displacement(const saltus_system *system, const saltus_event *event,
                                 const double *state) {
    bool own = event->kind == SALTUS_TURNING ||
               saltus_system_stop_observed(system, saltus_system_face(system, event->face).stop);
    return own ? event->displacement : saltus_system_observed(system, state);
}

bool saltus_lap_add(saltus_lap *lap, const saltus_event *event, const double *state) {
    bool contact = 1u << event->kind & SALTUS_WATCH_CONTACT;
    if (!contact && event->kind != SALTUS_TURNING)
        return true;
    double displacement = saltus_event_displacement(lap->system, event, state);
    lap->largest = fmax(lap->largest, displacement);
    lap->smallest = fmin(lap->smallest, displacement);
    if (contact) {
        lap->contact_events++;
        lap->sticks += event->kind == SALTUS_STICK;
        lap->releases += event->kind == SALTUS_RELEASE;
        lap->rebounding_contact |=
            event->kind != SALTUS_IMPACT && saltus_system_face(lap->system, event->face).r > 0;
    }
    if (contact && saltus_event_strikes(event)) {
        lap->impacts++;
        lap->impacts_by_face[event->face]++;
    }
    if (!(contact ? lap->keeps_events : lap->keeps_turnings))
        return true;
    if (lap->event_count == lap->event_room) {
        int room = lap->event_room ? 2 * lap->event_room : 32;
        saltus_event *grown = realloc(lap->events, (size_t)room * sizeof *grown);
        if (!grown)
            return false;
        lap->events = grown;
        lap->event_room = room;
    }
    lap->events[lap->event_count++] = *event;
    return true;
}

saltus_status saltus_lap_run(saltus_lap *lap, saltus_flow *flow, saltus_time until, bool turnings,
                             saltus_message *message) {
    unsigned watch = SALTUS_WATCH_CONTACT | (turnings ? SALTUS_WATCH_TURNING : 0);
    double state[SALTUS_STATE_MAX];
    saltus_event event = {.kind = SALTUS_STEP};
    const double begin = saltus_time_periods(saltus_flow_time(flow, 0)),
                 square = saltus_flow_information(flow, 0).square;
    while (event.kind != SALTUS_REACHED) {
        saltus_status status = saltus_flow_advance(flow, until, watch, &event, message);
        if (status != SALTUS_OK)
            return status;
        saltus_flow_state(flow, 0, state);
        if (!saltus_lap_add(lap, &event, state))
            return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the events of an orbit");
    }
    lap->contacts = saltus_flow_contacts(flow, 0);
    if (turnings) {
        lap->square += saltus_flow_information(flow, 0).square - square;
        lap->watched += saltus_time_periods(until) - begin;
    }
    return SALTUS_OK;
}

bool saltus_lap_reserve(saltus_lap *lap, int periods, int n) {
    if (periods <= lap->point_room)
        return true;
    free(lap->points);
    lap->points = calloc((size_t)(periods + 1) * (size_t)n, sizeof *lap->points);
    lap->point_room = lap->points ? periods : 0;
    lap->end = lap->points ? lap->points + (size_t)periods * (size_t)n : NULL;
    return lap->points;
}

saltus_status saltus_state_carry(saltus_flow *flow, saltus_time from, saltus_time until, double *state,
                                 saltus_message *message) {
    saltus_event event;
    saltus_status status = saltus_flow_start(flow, 0, from, state, message);
    if (status == SALTUS_OK && saltus_time_periods(until) > saltus_time_periods(from))
        status = saltus_flow_advance(flow, until, 0, &event, message);
    if (status == SALTUS_OK)
        saltus_flow_state(flow, 0, state);
    return status;
}

saltus_status saltus_lap_around(saltus_lap *lap, saltus_flow *flow, const double *state, int periods,
                                saltus_message *message) {
    const saltus_system *system = saltus_flow_system(flow, 0);
    const double reach = saltus_system_forced(system) ? saltus_section_reach(flow->options.rtol) : 0;
    const int n = saltus_system_dimension(system);
    saltus_event passed[SALTUS_FACES_MAX];
    if (!saltus_lap_reserve(lap, periods, n))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for an orbit of %d periods", periods);
    saltus_section_point(system, state, reach, lap->points, NULL);
    saltus_lap_begin(lap, system, lap->points);
    lap->periods = periods;
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, lap->points, message);
    for (int k = 1; k <= periods && status == SALTUS_OK; k++) {
        double *point = k < periods ? lap->points + (size_t)(k * n) : lap->end;
        status = saltus_lap_run(lap, flow, (saltus_time){k, 0}, true, message);
        saltus_flow_state(flow, 0, point);
        const int count = saltus_section_point(system, point, reach, point, passed);
        /* Where the orbit closes these are the impacts that its first point lies after. */
        for (int i = 0; i < count && k == periods && status == SALTUS_OK; i++) {
            passed[i].time.cycle += periods;
            if (!saltus_lap_add(lap, &passed[i], point))
                status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the events of an orbit");
        }
    }
    return status;
}

void saltus_lap_close(saltus_lap *lap) {
    free(lap->events);
    free(lap->points);
    *lap = (saltus_lap){0};
}

double saltus_lap_rms(const saltus_lap *lap) {
    return lap->watched > 0 ? sqrt(fmax(lap->square, 0) / lap->watched) : NAN;
}

/* A lasting contact on a face with r > 0 begins with infinitely many impacts if any, although the flow may
 * see only the first: where r is so small that its rebound is within the tolerance. The impacts before the
 * contact may be at the lap's end. */
long long saltus_lap_impacts(const saltus_lap *lap) {
    return lap->rebounding_contact && lap->impacts > 0 ? -1 : lap->impacts;
}

int saltus_lap_sticking(const saltus_lap *lap) {
    return lap->sticks > lap->releases ? lap->sticks : lap->releases;
}

bool saltus_lap_held(const saltus_lap *lap) {
    return lap->contact_events == 0 && lap->contacts;
}

void saltus_lap_label(const saltus_lap *lap, char label[SALTUS_LABEL_MAX]) {
    if (saltus_lap_held(lap))
        snprintf(label, SALTUS_LABEL_MAX, "held");
    else
        saltus_orbit_label(saltus_lap_impacts(lap), lap->periods, label);
}

void saltus_orbit_label(long long impacts, int periods, char label[SALTUS_LABEL_MAX]) {
    if (impacts < 0)
        snprintf(label, SALTUS_LABEL_MAX, "chatter/%d", periods);
    else
        snprintf(label, SALTUS_LABEL_MAX, "%lld/%d", impacts, periods);
}

double saltus_section_reach(double rtol) {
    return fmax(1e-8, 100 * rtol);
}

int saltus_section_point(const saltus_system *system, const double *state, double reach, double *after,
                         saltus_event *passed) {
    const double *scale = saltus_system_scale(system);
    int count = 0;
    if (after != state)
        memcpy(after, state, (size_t)system->dimension * sizeof *after);
    for (int k = 0; k < system->face_count && reach > 0; k++) {
        const saltus_face face = system->faces[k];
        const double *normal = system->stop_normal[face.stop], *impulse = system->stop_impulse[face.stop],
                     gap = saltus_system_gap(system, k, after);
        double length = 0, speed_scale = 0;
        for (int i = 0; i < system->dof; i++)
            length += fabs(normal[i]) * scale[i];
        if (!(fabs(gap) < reach * length))
            continue;
        const double speed = saltus_dot(normal, after + system->dof, system->dof);
        for (int i = 0; i < system->dof; i++)
            speed_scale += fabs(normal[i]) * scale[system->dof + i];
        /* In a contact that holds, or at a touch, the speed is nothing but rounding. */
        if (!(face.side * speed > reach * speed_scale))
            continue;
        const double rebound = -saltus_system_restitution(system, k, fabs(speed)) * speed;
        for (int i = 0; i < system->dof; i++)
            after[system->dof + i] += (rebound - speed) * impulse[i];
        if (passed)
            passed[count] = (saltus_event){
                SALTUS_IMPACT, k,       saltus_time_of(fmax(-gap / fabs(speed), 0) / system->period),
                speed,         rebound, face.side * (gap + face.d)};
        count++;
    }
    return count;
}

int saltus_lap_least_period(const saltus_lap *lap, const saltus_flow_options *flow) {
    /* Accuracy of section points of one orbit that Newton's method finds with this flow. */
    const double accuracy = fmax(1e-8, 1e4 * flow->rtol), *points = lap->points;
    const int n = saltus_system_dimension(lap->system);
    for (int p = 1; p <= lap->periods / 2; p++)
        if (lap->periods % p == 0 &&
            saltus_system_distance(lap->system, points + (size_t)(p * n), points) < accuracy)
            return p;
    return lap->periods;
}

bool saltus_orbit_passes(const saltus_system *system, const double *points, int periods, const double *state,
                         double distance) {
    const int n = saltus_system_dimension(system);
    double after[SALTUS_STATE_MAX];
    saltus_section_point(system, state, distance, after, NULL);
    for (int k = 0; k < periods; k++)
        if (saltus_system_distance(system, points + (size_t)(k * n), state) < distance ||
            saltus_system_distance(system, points + (size_t)(k * n), after) < distance)
            return true;
    return false;
}

saltus_status saltus_mirror_image(saltus_flow *flow, const double *state, saltus_time later, double *image,
                                  saltus_message *message) {
    const int n = saltus_system_dimension(saltus_flow_system(flow, 0));
    if (image != state)
        memcpy(image, state, (size_t)n * sizeof *image);
    saltus_status status = saltus_state_carry(flow, (saltus_time){0, 0}, later, image, message);
    for (int i = 0; i < n && status == SALTUS_OK; i++)
        image[i] = -image[i];
    return status;
}
