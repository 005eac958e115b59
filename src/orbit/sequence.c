/* Sequences of events: made from the flow's own events, and walked.
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

bool saltus_sequence_in_tail(const saltus_sequence *s, const double *speed, int count, int face,
                             double next_speed) {
    enum { least = 24, most = 3 * SALTUS_MARKS_MAX / 4 };
    const double slow = 1e-5; /* relative to the first of the run */
    int run = 0;
    while (run < count && s->mark[count - 1 - run].kind == SALTUS_IMPACT &&
           s->mark[count - 1 - run].face == face && (run == 0 || speed[count - 1 - run] > speed[count - run]))
        run++;
    return run >= least && s->mark[count - 1].face == face && next_speed < speed[count - 1] &&
           (speed[count - 1] < slow * speed[count - run] || count >= most);
}

static void make_marks(const saltus_lap *lap, saltus_sequence *s) {
    double speed[SALTUS_MARKS_MAX];
    s->count = 0;
    s->driven = false;
    for (int k = 0; k < lap->event_count; k++) {
        const saltus_event *event = &lap->events[k];
        bool prescribed = event->kind != SALTUS_STICK || saltus_system_face(lap->system, event->face).r == 0;
        if (!prescribed) {
            /* A stick that completes chatter belongs to the preceding burst of impacts, which the flow must
             * find itself: from the first impact from which on the speeds fall. */
            int first = s->count;
            while (first > 0 && s->mark[first - 1].kind == SALTUS_IMPACT &&
                   s->mark[first - 1].face == event->face &&
                   (first == s->count || speed[first - 1] > speed[first]))
                first--;
            s->count = first < s->count ? first + 1 : s->count;
            *(s->count ? &s->mark[s->count - 1].driven : &s->driven) = true;
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

/* The beginning, turning points and contacts of an orbit, and the range of each face's gap over them. */
typedef struct orbit_turns {
    int count;
    double time[128], low[SALTUS_FACES_MAX], high[SALTUS_FACES_MAX];
    bool contact[128];
} orbit_turns;

static void note_turn(orbit_turns *turns, const saltus_system *system, bool contact, double time,
                      const double *state) {
    for (int f = 0; f < saltus_system_face_count(system); f++) {
        double gap = saltus_system_gap(system, f, state);
        turns->low[f] = fmin(turns->low[f], gap);
        turns->high[f] = fmax(turns->high[f], gap);
    }
    if (turns->count < (int)(sizeof turns->time / sizeof turns->time[0])) {
        turns->contact[turns->count] = contact;
        turns->time[turns->count++] = time;
    }
}

/* Whether a state is too close to a stop to cut the orbit there: further along the branch it may touch it. */
static bool is_near_stop(const orbit_turns *turns, const saltus_system *system, const double *state) {
    const double share = 0.5;
    for (int f = 0; f < saltus_system_face_count(system); f++)
        if (-saltus_system_gap(system, f, state) < share * (turns->high[f] - turns->low[f]))
            return true;
    return false;
}

/* The middle of the longest stretch between turning points and contacts. */
static double longest_stretch(const orbit_turns *turns, int periods) {
    double best = 0, middle = turns->time[0];
    for (int k = 0; k < turns->count; k++) {
        double next = k + 1 < turns->count ? turns->time[k + 1] : turns->time[0] + periods;
        if (next - turns->time[k] > best) {
            best = next - turns->time[k];
            middle = turns->time[k] + 0.5 * best;
        }
    }
    return middle;
}

bool saltus_orbit_turning(saltus_flow *flow, int periods, double *time, double *state) {
    const double apart = 0.02 * periods, begin = *time;
    const saltus_system *system = saltus_flow_system(flow, 0);
    const size_t size = (size_t)saltus_system_dimension(system) * sizeof *state;
    double best = 0, now[SALTUS_STATE_MAX], found[SALTUS_STATE_MAX];
    orbit_turns turns = {.count = 0};
    for (int f = 0; f < SALTUS_FACES_MAX; f++) {
        turns.low[f] = INFINITY;
        turns.high[f] = -INFINITY;
    }
    /* The start may itself be a turning point. */
    note_turn(&turns, system, false, begin, state);
    /* The first pass collects all, the second chooses among the turning points. */
    for (int pass = 0; pass < 2; pass++) {
        const unsigned watch = SALTUS_WATCH_TURNING | (pass ? 0 : SALTUS_WATCH_CONTACT);
        saltus_event event = {.kind = SALTUS_STEP};
        if (saltus_flow_start(flow, 0, saltus_time_of(begin), state, NULL) != SALTUS_OK)
            return false;
        while (event.kind != SALTUS_REACHED) {
            if (saltus_flow_advance(flow, saltus_time_of(begin + periods), watch, &event, NULL) != SALTUS_OK)
                return false;
            saltus_flow_state(flow, 0, now);
            if (event.kind == SALTUS_REACHED)
                continue;
            double at = saltus_time_periods(event.time), near = INFINITY;
            if (pass == 0) {
                note_turn(&turns, system, event.kind != SALTUS_TURNING, at, now);
                continue;
            }
            for (int k = 0; k < turns.count; k++)
                if (turns.contact[k])
                    near = fmin(near, fabs(remainder(at - turns.time[k], periods)));
            if (near < apart || saltus_flow_contacts(flow, 0) || is_near_stop(&turns, system, now) ||
                !(fabs(event.velocity_before) > best))
                continue;
            best = fabs(event.velocity_before);
            *time = at;
            memcpy(found, now, size);
        }
    }
    if (best > 0)
        memcpy(state, found, size);
    else
        *time = longest_stretch(&turns, periods);
    return best > 0;
}

saltus_status saltus_sequence_make(saltus_flow *flow, int periods, bool free_period, double *state,
                                   saltus_lap *lap, saltus_sequence *s, saltus_message *message) {
    double time = 0;
    *s = (saltus_sequence){.periods = periods, .cuts = 1};
    saltus_status status = saltus_sequence_walk(s, flow, state, lap, NULL, message);
    if (status != SALTUS_OK)
        return status;
    const bool turning = free_period && saltus_orbit_turning(flow, periods, &time, state),
               chosen = turning || (lap->event_count == 0 && !lap->contacts);
    double longest = -1;
    s->base = chosen ? fmod(time, periods) : 0;
    /* Otherwise the middle of the longest free flight in the walk, whose ends join; 0: always in contact. */
    for (int k = 0, held = 0; k < lap->event_count && !chosen; k++) {
        const saltus_event *event = &lap->events[k], *next = &lap->events[(k + 1) % lap->event_count];
        held += (event->kind == SALTUS_STICK) - (event->kind == SALTUS_RELEASE);
        const double from = saltus_time_periods(event->time),
                     to = saltus_time_periods(next->time) + (k + 1 == lap->event_count ? lap->periods : 0);
        if (event->kind != SALTUS_STICK && held <= 0 && to - from > longest) {
            longest = to - from;
            s->base = fmod(from + 0.5 * longest, lap->periods);
        }
    }
    s->cut[0] = s->base;
    if (s->base > 0) {
        if (!turning)
            status = saltus_state_carry(flow, (saltus_time){0, 0}, saltus_time_of(s->base), state, message);
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
