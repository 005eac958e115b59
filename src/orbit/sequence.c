/* Sequences of events: made from what the flow does, and walked.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/sequence.h"

#include <math.h>
#include <string.h>

static saltus_status follow(saltus_flow *flow, saltus_time until, saltus_lap *lap, saltus_cocycle *cocycle,
                            saltus_message *message) {
    return cocycle ? saltus_cocycle_follow(cocycle, flow, until, lap, message)
                   : saltus_lap_run(lap, flow, until, false, message);
}

saltus_status saltus_sequence_walk(const saltus_sequence *s, saltus_flow *flow, const double *states,
                                   saltus_lap *lap, saltus_cocycle *cocycle, saltus_message *message) {
    const saltus_system *system = saltus_flow_system(flow, 0);
    int n = saltus_system_dimension(system);
    double section = ceil(s->base / s->periods) * s->periods;
    if (!saltus_lap_reserve(lap, 1, n))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory to walk an orbit");
    saltus_lap_begin(lap, system, states);
    lap->periods = s->periods;
    saltus_status status = SALTUS_OK;
    for (int cut = 0; cut < s->cuts && status == SALTUS_OK; cut++) {
        const double *state = states + (size_t)cut * (size_t)n;
        double from = s->cut[cut], to = cut + 1 < s->cuts ? s->cut[cut + 1] : s->base + s->periods;
        if (section == from)
            memcpy(lap->points, state, (size_t)n * sizeof *state);
        status = saltus_flow_start(flow, 0, saltus_time_of(from), state, message);
        if (status == SALTUS_OK && section > from && section <= to) {
            status = follow(flow, (saltus_time){(long long)section, 0}, lap, cocycle, message);
            saltus_flow_state(flow, 0, lap->points);
        }
        if (status == SALTUS_OK)
            status = follow(flow, saltus_time_of(to), lap, cocycle, message);
    }
    saltus_flow_state(flow, 0, lap->end);
    return status;
}

/* The middle of the longest free flight between events of a walk from section phase 0; the walk's own ends
 * join into one flight. In contact all the time: 0. */
static double longest_flight(const saltus_lap *lap) {
    double best = -1, base = 0;
    int held = 0;
    for (int k = 0; k < lap->event_count; k++) {
        const saltus_event *event = &lap->events[k], *next = &lap->events[(k + 1) % lap->event_count];
        held += (event->kind == SALTUS_STICK) - (event->kind == SALTUS_RELEASE);
        double time = saltus_time_periods(event->time), after = saltus_time_periods(next->time);
        if (k + 1 == lap->event_count)
            after += lap->periods;
        bool free_flight = event->kind != SALTUS_STICK && held <= 0;
        if (free_flight && after - time > best) {
            best = after - time;
            base = fmod(time + 0.5 * (after - time), lap->periods);
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

static void make_marks(const saltus_lap *lap, saltus_sequence *s) {
    double speed[SALTUS_MARKS_MAX];
    s->count = 0;
    s->driven = false;
    for (int k = 0; k < lap->event_count; k++) {
        const saltus_event *event = &lap->events[k];
        bool prescribed = event->kind != SALTUS_STICK || saltus_system_face(lap->system, event->face).r == 0;
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

bool saltus_orbit_turning(saltus_flow *flow, int periods, double *time, double *state) {
    enum { most = 64 };
    const double apart = 0.02 * periods;
    const double begin = *time;
    const int n = saltus_system_dimension(saltus_flow_system(flow, 0));
    double best = 0, contact[most], place = begin, found[SALTUS_STATE_MAX];
    int contacts = 0;
    /* First the contacts, then the turning points between them. */
    for (int pass = 0; pass < 2; pass++) {
        saltus_event event = {.kind = SALTUS_STEP};
        if (saltus_flow_start(flow, 0, saltus_time_of(begin), state, NULL) != SALTUS_OK)
            return false;
        while (event.kind != SALTUS_REACHED) {
            unsigned watch = pass ? SALTUS_WATCH_TURNING : SALTUS_WATCH_CONTACT;
            if (saltus_flow_advance(flow, saltus_time_of(begin + periods), watch, &event, NULL) != SALTUS_OK)
                return false;
            double at = saltus_time_periods(event.time), near = INFINITY;
            if (event.kind == SALTUS_REACHED || (pass == 0 && contacts == most))
                continue;
            if (pass == 0) {
                contact[contacts++] = at;
                continue;
            }
            for (int k = 0; k < contacts; k++)
                near = fmin(near, fabs(remainder(at - contact[k], periods)));
            if (near < apart || saltus_flow_contacts(flow, 0) || !(fabs(event.velocity_before) > best))
                continue;
            best = fabs(event.velocity_before);
            place = at;
            saltus_flow_state(flow, 0, found);
        }
    }
    if (best > 0) {
        *time = place;
        memcpy(state, found, (size_t)n * sizeof *state);
    }
    return best > 0;
}

/* From a state at section phase 0 to the sequence's base. */
static saltus_status go_to_base(saltus_flow *flow, const saltus_sequence *s, double *state,
                                saltus_message *message) {
    saltus_event event;
    saltus_status status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    if (status == SALTUS_OK)
        status = saltus_flow_advance(flow, saltus_time_of(s->base), 0, &event, message);
    saltus_flow_state(flow, 0, state);
    return status;
}

saltus_status saltus_sequence_make(saltus_flow *flow, int periods, bool free_period, double *state,
                                   saltus_lap *lap, saltus_sequence *s, saltus_message *message) {
    double time = 0;
    *s = (saltus_sequence){.periods = periods, .cuts = 1};
    saltus_status status = saltus_sequence_walk(s, flow, state, lap, NULL, message);
    if (status != SALTUS_OK)
        return status;
    bool turning = free_period && saltus_orbit_turning(flow, periods, &time, state);
    s->base = s->cut[0] = turning ? fmod(time, periods) : longest_flight(lap);
    if (s->base > 0) {
        if (!turning)
            status = go_to_base(flow, s, state, message);
        else
            status = saltus_flow_start(flow, 0, saltus_time_of(s->base), state, message);
        s->contacts = saltus_flow_contacts(flow, 0);
        if (status == SALTUS_OK)
            status = saltus_sequence_walk(s, flow, state, lap, NULL, message);
    } else {
        s->contacts = lap->event_count ? 0 : lap->contacts;
    }
    if (status == SALTUS_OK)
        make_marks(lap, s);
    if (status == SALTUS_OK && free_period) {
        status = saltus_flow_start(flow, 0, saltus_time_of(s->base), state, message);
        if (status == SALTUS_OK)
            saltus_sequence_anchor(s, flow, turning);
    }
    return status;
}

bool saltus_sequence_follows(const saltus_sequence *s, const saltus_lap *lap) {
    const double close = 1e-6 * s->periods;
    bool driven = s->driven;
    int k = 0;
    for (int e = 0; e < lap->event_count; e++) {
        const saltus_event *event = &lap->events[e];
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
