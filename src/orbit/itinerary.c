/* Walking an orbit with the event-driven flow; sequences from walks.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/itinerary.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

saltus_status saltus_itinerary_open(saltus_itinerary *it, int dimension, saltus_message *message) {
    *it = (saltus_itinerary){.dimension = dimension};
    it->state = calloc(2 * (size_t)dimension, sizeof *it->state);
    it->end = it->state ? it->state + dimension : NULL;
    return it->state ? SALTUS_OK : saltus_fail(message, SALTUS_NO_MEMORY, "no memory to walk an orbit");
}

void saltus_itinerary_close(saltus_itinerary *it) {
    free(it->state);
    free(it->events);
    *it = (saltus_itinerary){0};
}

static bool append(saltus_itinerary *it, const saltus_event *event) {
    if (it->count == it->room) {
        int room = it->room ? 2 * it->room : 32;
        saltus_event *grown = realloc(it->events, (size_t)room * sizeof *grown);
        if (!grown)
            return false;
        it->events = grown;
        it->room = room;
    }
    it->events[it->count++] = *event;
    return true;
}

static bool is_impact(const saltus_event *event) {
    return event->kind != SALTUS_RELEASE && event->velocity_before != 0;
}

/* n, chatter and sticking intervals of the walk, and its label (model.md, section 4). */
static void tally(saltus_itinerary *it, const saltus_system *system) {
    bool chatter = false;
    it->impacts = it->sticking_intervals = 0;
    for (int k = 0; k < it->count; k++) {
        const saltus_event *event = &it->events[k];
        it->impacts += is_impact(event);
        it->sticking_intervals += event->kind == SALTUS_STICK;
        chatter |=
            event->kind == SALTUS_STICK && saltus_system_face(system, event->face).r > 0 && it->count > 2;
    }
    if (chatter)
        it->impacts = -1;
    if (it->count == 0 && it->contacts)
        snprintf(it->label, sizeof it->label, "held");
    else if (chatter)
        snprintf(it->label, sizeof it->label, "chatter/%d", it->periods);
    else
        snprintf(it->label, sizeof it->label, "%lld/%d", it->impacts, it->periods);
}

static saltus_time as_time(double periods) {
    double whole = floor(periods);
    return (saltus_time){(long long)whole, periods - whole};
}

/* Run to a time, keeping the events on the way. */
static saltus_status run_to(saltus_itinerary *it, saltus_flow *flow, saltus_time until,
                            saltus_message *message) {
    saltus_event event;
    saltus_status status;
    do {
        status = saltus_flow_advance(flow, until, SALTUS_WATCH_CONTACT, &event, message);
        if (status == SALTUS_OK && event.kind != SALTUS_REACHED && !append(it, &event))
            status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory to walk an orbit");
    } while (status == SALTUS_OK && event.kind != SALTUS_REACHED);
    return status;
}

saltus_status saltus_itinerary_walk_cuts(saltus_itinerary *it, saltus_flow *flow, const saltus_sequence *s,
                                         const double *states, saltus_message *message) {
    double section = ceil(s->base / s->periods) * s->periods;
    saltus_status status = SALTUS_OK;
    it->count = 0;
    it->periods = s->periods;
    for (int cut = 0; cut < s->cuts && status == SALTUS_OK; cut++) {
        const double *state = states + (size_t)cut * (size_t)it->dimension;
        double from = s->cut[cut], to = cut + 1 < s->cuts ? s->cut[cut + 1] : s->base + s->periods;
        if (section == from)
            memcpy(it->state, state, (size_t)it->dimension * sizeof *state);
        status = saltus_flow_start(flow, 0, as_time(from), state, message);
        if (status == SALTUS_OK && section > from && section <= to) {
            status = run_to(it, flow, (saltus_time){(long long)section, 0}, message);
            saltus_flow_state(flow, 0, it->state);
        }
        if (status == SALTUS_OK)
            status = run_to(it, flow, as_time(to), message);
    }
    saltus_flow_state(flow, 0, it->end);
    it->contacts = saltus_flow_contacts(flow, 0);
    tally(it, saltus_flow_system(flow, 0));
    return status;
}

saltus_status saltus_itinerary_walk(saltus_itinerary *it, saltus_flow *flow, double start,
                                    const double *state, int periods, saltus_message *message) {
    saltus_sequence whole = {.periods = periods, .base = start, .cuts = 1, .cut = {start}};
    return saltus_itinerary_walk_cuts(it, flow, &whole, state, message);
}

/* The middle of the longest free flight between events of a walk from section phase 0; the walk's own ends
 * join into one flight. In contact all the time: 0. */
static double longest_flight(const saltus_itinerary *it) {
    double best = -1, base = 0;
    int held = 0;
    for (int k = 0; k < it->count; k++) {
        const saltus_event *event = &it->events[k], *next = &it->events[(k + 1) % it->count];
        held += (event->kind == SALTUS_STICK) - (event->kind == SALTUS_RELEASE);
        double time = saltus_time_periods(event->time), after = saltus_time_periods(next->time);
        if (k + 1 == it->count)
            after += it->periods;
        bool free_flight = event->kind != SALTUS_STICK && held <= 0;
        if (free_flight && after - time > best) {
            best = after - time;
            base = fmod(time + 0.5 * (after - time), it->periods);
        }
    }
    return base;
}

/* A stick that ends complete chatter belongs to the burst of impacts before it, which the flow must find
 * itself: from the first impact on from which the speeds fall. */
static void close_burst(saltus_sequence *s, const double *speed, const saltus_event *stick) {
    int first = s->count;
    while (first > 0 && s->mark[first - 1].kind == SALTUS_IMPACT && s->mark[first - 1].face == stick->face &&
           (first == s->count || speed[first - 1] > speed[first]))
        first--;
    if (first == s->count) {
        if (s->count)
            s->mark[s->count - 1].driven = true;
        else
            s->driven = true;
        return;
    }
    s->mark[first].driven = true;
    s->count = first + 1;
}

bool saltus_sequence_in_tail(const saltus_sequence *s, const double *speed, int count, int face,
                             double next_speed) {
    enum { prescribed_at_most = 24 };
    int run = 0;
    while (run < count && s->mark[count - 1 - run].kind == SALTUS_IMPACT &&
           s->mark[count - 1 - run].face == face && (run == 0 || speed[count - 1 - run] > speed[count - run]))
        run++;
    return run >= prescribed_at_most && s->mark[count - 1].face == face && next_speed < speed[count - 1];
}

static void make_marks(const saltus_itinerary *it, const saltus_system *system, saltus_sequence *s) {
    double speed[SALTUS_MARKS_MAX];
    s->count = 0;
    s->driven = false;
    for (int k = 0; k < it->count; k++) {
        const saltus_event *event = &it->events[k];
        bool prescribed = event->kind != SALTUS_STICK || saltus_system_face(system, event->face).r == 0;
        if (!prescribed) {
            close_burst(s, speed, event);
            continue;
        }
        bool tail = event->kind == SALTUS_IMPACT && s->count &&
                    saltus_sequence_in_tail(s, speed, s->count, event->face, fabs(event->velocity_before));
        if (tail || s->count == SALTUS_MARKS_MAX) {
            s->mark[s->count - 1].driven = true;
            if (!tail)
                return;
            continue;
        }
        speed[s->count] = fabs(event->velocity_before);
        s->mark[s->count++] =
            (saltus_mark){event->kind, event->face, saltus_time_periods(event->time), false};
    }
}

saltus_status saltus_itinerary_sequence(saltus_itinerary *it, saltus_flow *flow, int periods, double *state,
                                        saltus_sequence *s, saltus_message *message) {
    saltus_event event;
    *s = (saltus_sequence){.periods = periods, .cuts = 1};
    saltus_status status = saltus_itinerary_walk(it, flow, 0, state, periods, message);
    if (status != SALTUS_OK)
        return status;
    s->base = s->cut[0] = longest_flight(it);
    if (s->base > 0) {
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
        if (status == SALTUS_OK)
            status = saltus_flow_advance(flow, as_time(s->base), 0, &event, message);
        saltus_flow_state(flow, 0, state);
        s->contacts = saltus_flow_contacts(flow, 0);
        if (status == SALTUS_OK)
            status = saltus_itinerary_walk(it, flow, s->base, state, periods, message);
    } else {
        s->contacts = it->count ? 0 : it->contacts;
    }
    if (status == SALTUS_OK)
        make_marks(it, saltus_flow_system(flow, 0), s);
    return status;
}

bool saltus_itinerary_follows(const saltus_itinerary *it, const saltus_sequence *s) {
    const double close = 1e-6 * s->periods;
    bool driven = s->driven;
    int k = 0;
    for (int e = 0; e < it->count; e++) {
        const saltus_event *event = &it->events[e];
        const saltus_mark *mark = k < s->count ? &s->mark[k] : NULL;
        bool release = event->kind == SALTUS_RELEASE;
        if (mark && event->face == mark->face && release == (mark->kind == SALTUS_RELEASE) &&
            fabs(saltus_time_periods(event->time) - mark->time) < close) {
            driven = mark->driven;
            k++;
        } else if (!driven) {
            return false;
        }
    }
    return k == s->count;
}
