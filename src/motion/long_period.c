/* Long periods of motions that lock, and of motions that stick.
 *
 * A motion near a torus may be locked to an orbit of hundreds of periods, which it approaches too slowly for
 * iteration to show it. The times after which it comes closest to an earlier point, each closer than after
 * all shorter times, are guesses for Newton's method.
 *
 * A contact that wipes out all differences makes the motion superstable: it continues as it did after the
 * last time it met the same contact, however long ago. If neighbours separate without bound between two such
 * contacts, rounding decides the time between them: a run with another tolerance finds another time.
 * SPDX-License-Identifier: GPL-3.0-or-later */

#include "base/simd.h"
#include "motion/motion.h"
#include "orbit/fixed_point.h"
#include "orbit/multipliers.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    longest = 1024, /* period of a locked motion */
    followed = 4 * longest,
    tries = 6,            /* number of closest returns that are tried */
    costly = 3000,        /* orbits of more impacts are not tried */
    few_steps = 8,        /* of Newton's method: enough for so near an orbit; on a torus it never converges */
    contacts_watched = 8, /* contacts that wipe out all differences, at most */
    rare = 20,            /* chaos is watched for such a contact this many times as long as it was measured */
    patience = 10         /* such a contact is awaited this many times as long as a motion may settle */
};
static const double near_return = 0.05; /* relative to the system's scales */
static const double same_contact = 1e-8;

/* The guesses are the closest returns of a trajectory to its last point, each closer than all shorter ones;
 * the closest is tried first. */
saltus_status saltus_motion_find_locked(const saltus_system *system, const saltus_classify_options *options,
                                        const double *state, saltus_motion *found, saltus_message *message) {
    const int n = saltus_system_dimension(system);
    int periods[tries] = {0}; /* of the returns, 0 at the end */
    double *points = malloc((size_t)followed * (size_t)n * sizeof *points), closest = near_return;
    const double *last = points ? points + (size_t)(followed - 1) * (size_t)n : NULL;
    saltus_flow *flow = NULL;
    saltus_event event;
    *found = (saltus_motion){0};
    saltus_status status = points ? saltus_flow_single(system, 0, &options->flow, &flow, message)
                                  : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for section points");
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    for (int k = 0; k < followed && status == SALTUS_OK; k++) {
        status = saltus_flow_advance(flow, (saltus_time){k + 1, 0}, 0, &event, message);
        saltus_flow_state(flow, 0, points + (size_t)k * (size_t)n);
    }
    for (int p = 1; p <= longest && status == SALTUS_OK; p++) {
        double distance = saltus_system_distance(system, last, last - p * n);
        if (!(distance < closest))
            continue;
        closest = distance;
        memmove(periods + 1, periods, (tries - 1) * sizeof *periods);
        periods[0] = p;
    }
    const double impacts =
        status == SALTUS_OK ? (double)saltus_flow_information(flow, 0).impacts / followed : 0;
    for (int k = 0; k < tries && periods[k] && status == SALTUS_OK; k++) {
        if (periods[k] * impacts > costly)
            continue;
        saltus_fixed_point orbit;
        status = saltus_fixed_point_open(&orbit, system, periods[k], &options->flow, message);
        if (status == SALTUS_OK && saltus_fixed_point_find(&orbit, last, few_steps, near_return))
            status =
                saltus_motion_polish(system, periods[k], orbit.state, near_return, options, found, message);
        saltus_fixed_point_close(&orbit);
        if (saltus_verdict_settled(found->verdict)) {
            found->transient = followed;
            break;
        }
    }
    saltus_flow_free(flow);
    free(points);
    return status;
}

/* A contact that wipes out all differences: its time, the state then, and the next section point. */
typedef struct contact {
    saltus_time time;
    double state[SALTUS_STATE_MAX], section[SALTUS_STATE_MAX];
} contact;

/* Periods from one contact that wipes out all differences to a later one that is the same, `begin`; 0: none
 * of the first few is the same as an earlier one, or the next does not come within `patient` periods; -1:
 * not even a first one comes. */
static saltus_status return_to_contact(const saltus_system *system, const saltus_flow_options *options,
                                       const double *state, long long patient, contact *begin,
                                       long long *periods, saltus_message *message) {
    const int n = saltus_system_dimension(system);
    saltus_flow *flow = NULL;
    saltus_event event;
    contact *seen = calloc(contacts_watched, sizeof *seen);
    *periods = 0;
    saltus_status status = seen ? saltus_flow_single(system, 0, options, &flow, message)
                                : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for contacts");
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    for (int k = 0; k < contacts_watched && status == SALTUS_OK && !*periods; k++) {
        const saltus_time until = {saltus_flow_time(flow, 0).cycle + patient, 0};
        do
            status = saltus_flow_advance(flow, until, SALTUS_WATCH_STICK, &event, message);
        while (status == SALTUS_OK && event.kind != SALTUS_REACHED &&
               saltus_lost_directions(flow, 0, &event) < n);
        if (status == SALTUS_OK && event.kind == SALTUS_REACHED && k == 0)
            *periods = -1;
        if (status != SALTUS_OK || event.kind == SALTUS_REACHED)
            break;
        seen[k].time = event.time;
        saltus_flow_state(flow, 0, seen[k].state);
        status = saltus_flow_advance(flow, (saltus_time){event.time.cycle + 1, 0}, 0, &event, message);
        saltus_flow_state(flow, 0, seen[k].section);
        for (int j = k - 1; j >= 0 && !*periods && status == SALTUS_OK; j--)
            if (saltus_system_distance(system, seen[k].state, seen[j].state) < same_contact &&
                fabs(seen[k].time.phase - seen[j].time.phase) < same_contact) {
                *periods = seen[k].time.cycle - seen[j].time.cycle;
                *begin = seen[k];
            }
    }
    saltus_flow_free(flow);
    free(seen);
    return status;
}

saltus_status saltus_motion_find_contact(const saltus_system *system, const saltus_classify_options *options,
                                         saltus_motion *motion, saltus_motion *found,
                                         saltus_message *message) {
    const long long patient = patience * options->transient;
    saltus_flow_options other = options->flow;
    contact begin, again;
    long long periods, with_other = 0;
    *found = (saltus_motion){0};
    other.rtol *= 4;
    saltus_status status =
        return_to_contact(system, &options->flow, motion->state, patient, &begin, &periods, message);
    if (status == SALTUS_OK && periods <= 0)
        snprintf(motion->reason, sizeof motion->reason,
                 "superstable: every difference dies in a lasting contact, but %s within %lld periods (ten "
                 "times --transient)",
                 periods < 0 ? "so seldom that no other one comes"
                             : "the motion does not return to the same one",
                 patient);
    if (status != SALTUS_OK || periods <= 0)
        return status;
    status = return_to_contact(system, &other, begin.section, 2 * periods, &again, &with_other, message);
    if (status == SALTUS_OK && with_other != periods)
        snprintf(motion->reason, sizeof motion->reason,
                 "superstable: every difference dies in a lasting contact, to which this run returns after "
                 "%lld periods; in between neighbours separate so far that another tolerance gives another "
                 "time: rounding decides the period",
                 periods);
    else if (status == SALTUS_OK && periods <= patient)
        status =
            saltus_motion_polish(system, (int)periods, begin.section, near_return, options, found, message);
    return status;
}

/* Aim a lane not far ahead: another lane may meet the contact first. */
static void aim(saltus_flow *flow, int lane, long long last) {
    enum { stretch = 64 };
    const long long next = saltus_flow_time(flow, lane).cycle + stretch;
    saltus_flow_aim(flow, lane, (saltus_time){next < last ? next : last, 0}, SALTUS_WATCH_STICK);
}

long long saltus_contact_watch(const saltus_system *system, long long measured) {
    int stops = 0;
    for (int f = 0; f < saltus_system_face_count(system); f++) {
        int stop = saltus_system_face(system, f).stop;
        stops = stop >= stops ? stop + 1 : stops;
    }
    /* Simultaneous contact with all stops must leave no direction in which neighbours can differ. */
    return 2 * stops >= saltus_system_dimension(system) ? rare * measured : 0;
}

/* All lanes of a flow run while any of them can still be the first to meet such a contact. The result does
 * not depend on the number of lanes. */
saltus_status saltus_motion_meets_contact(const saltus_system *system, const saltus_flow_options *options,
                                          const double *const *states, int count, long long measured,
                                          double *state, bool *found, saltus_message *message) {
    const int width = saltus_flow_width(system, options->integrator, count),
              n = saltus_system_dimension(system);
    const saltus_system *systems[SALTUS_PACK_MAX];
    /* The earliest contact: in which trajectory, and when; `state` is the section point after it. */
    int first = -1;
    long long earliest = saltus_contact_watch(system, measured) / count;
    saltus_status status = SALTUS_OK;
    for (int l = 0; l < width; l++)
        systems[l] = system;
    for (int done = 0; done < count && status == SALTUS_OK && earliest > 0; done += width) {
        int lanes = count - done < width ? count - done : width, left = lanes, lane;
        bool met[SALTUS_PACK_MAX] = {false};
        saltus_event event;
        saltus_flow *flow = NULL;
        status = saltus_flow_new(systems, lanes, options, &flow, message);
        for (int l = 0; l < lanes && status == SALTUS_OK; l++)
            status = saltus_flow_start(flow, l, (saltus_time){0, 0}, states[done + l], message);
        for (int l = 0; l < lanes && status == SALTUS_OK; l++)
            aim(flow, l, earliest);
        while (left > 0 && status == SALTUS_OK) {
            status = saltus_flow_run(flow, &lane, &event, message);
            if (status != SALTUS_OK)
                break;
            const long long cycle = saltus_flow_time(flow, lane).cycle;
            const bool reached = event.kind == SALTUS_REACHED;
            if (!reached && saltus_lost_directions(flow, lane, &event) >= n) {
                met[lane] = true;
                saltus_flow_aim(flow, lane, (saltus_time){event.time.cycle + 1, 0}, 0);
                continue;
            }
            if (reached && met[lane] &&
                (cycle < earliest || (cycle == earliest && (first < 0 || done + lane < first)))) {
                first = done + lane;
                earliest = cycle;
                saltus_flow_state(flow, lane, state);
            }
            if (reached && (met[lane] || cycle >= earliest))
                left--;
            else
                aim(flow, lane, earliest);
        }
        saltus_flow_free(flow);
    }
    *found = first >= 0;
    return status;
}
