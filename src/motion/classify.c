/* Classification of what a trajectory settles on (model.md, section 4).
 *
 * The stroboscopic map is iterated in blocks. After each block the least p is sought for which the last
 * points recur after p periods; a candidate is polished by Newton's method on the p-th iterate, and accepted
 * if the orbit found is stable, lies where the trajectory is, has no shorter period, and the trajectory keeps
 * closing in on it. Everything reported is then measured on the polished orbit, not on the transient.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/motion.h"

#include "base/memory.h"
#include "motion/motion.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { first_block = 64 };

/* Distances in the stroboscopic section are relative to the system's scales. */
static const double recurrence = 1e-3; /* a candidate period: worth a Newton iteration */
static const double nearby =
    3e-3; /* the polished orbit must be this close to the trajectory, in recurrences */
static const double same_orbit = 1e-8; /* section points that agree: a shorter period */
static const double at_rest = 1e-9;    /* an equilibrium: no motion over a period beyond this */

/* The last points of the trajectory in a ring. */
typedef struct history {
    saltus_arena arena;
    int n, size;
    long long count;
    double *points, *excursion;
    bool *contact_event; /* an event occurred in the period before the point */
    unsigned *contacts;
} history;

saltus_classify_options saltus_classify_defaults(void) {
    return (saltus_classify_options){.flow = saltus_flow_defaults(), .transient = 20000, .longest = 64};
}

double saltus_section_distance(const saltus_system *system, const double *a, const double *b) {
    const double *scale = saltus_system_scale(system);
    double largest = 0;
    for (int i = 0; i < saltus_system_dimension(system); i++)
        largest = fmax(largest, fabs(a[i] - b[i]) / scale[i]);
    return largest;
}

static double *point_at(const history *h, long long k) {
    return h->points + (size_t)(k % h->size) * (size_t)h->n;
}

static bool open_history(history *h, int n, int size) {
    *h = (history){.n = n, .size = size};
    for (int pass = 0; pass < 2; pass++) {
        h->points = saltus_arena_doubles(&h->arena, (size_t)n * (size_t)size);
        h->excursion = saltus_arena_doubles(&h->arena, (size_t)size);
        if (pass == 0 && !saltus_arena_open(&h->arena))
            return false;
    }
    h->contact_event = calloc((size_t)size, sizeof *h->contact_event);
    h->contacts = calloc((size_t)size, sizeof *h->contacts);
    return h->contact_event && h->contacts;
}

static void close_history(history *h) {
    saltus_arena_close(&h->arena);
    free(h->contact_event);
    free(h->contacts);
}

/* One more period of the trajectory. */
static saltus_status advance_period(const saltus_system *system, saltus_flow *flow, history *h,
                                    saltus_message *message) {
    saltus_flow_info before = saltus_flow_information(flow, 0);
    saltus_time now = saltus_flow_time(flow, 0);
    saltus_event event;
    saltus_status status = saltus_flow_advance(flow, (saltus_time){now.cycle + 1, 0}, 0, &event, message);
    if (status != SALTUS_OK)
        return status;
    saltus_flow_info after = saltus_flow_information(flow, 0);
    int slot = (int)(h->count % h->size);
    saltus_flow_state(flow, 0, point_at(h, h->count));
    for (int i = 0; i < h->n; i++)
        if (!(fabs(point_at(h, h->count)[i]) < 1e8 * saltus_system_scale(system)[i]))
            return saltus_fail(message, SALTUS_STALLED,
                               "the motion grows without bound: state entry %d is %.3g after %lld periods",
                               i + 1, point_at(h, h->count)[i], h->count + 1);
    h->excursion[slot] =
        h->count ? saltus_section_distance(system, point_at(h, h->count), point_at(h, h->count - 1)) : 1;
    h->contact_event[slot] = after.impacts != before.impacts || after.releases != before.releases;
    h->contacts[slot] = saltus_flow_contacts(flow, 0);
    h->count++;
    return SALTUS_OK;
}

/* Largest distance between points p apart over the last `window` points. */
static double recurrence_distance(const saltus_system *system, const history *h, int p, int window) {
    double largest = 0;
    for (int k = 0; k < window; k++)
        largest = fmax(largest, saltus_section_distance(system, point_at(h, h->count - 1 - k),
                                                        point_at(h, h->count - 1 - k - p)));
    return largest;
}

/* The least period whose recurrences stay below a threshold; 0 if none. The smallest distance seen goes to
 * *closest. */
static int candidate_period(const saltus_system *system, const history *h, int longest, double threshold,
                            double *closest) {
    *closest = INFINITY;
    for (int p = 1; p <= longest && 3 * p + 2 < h->size && 3 * p + 2 < h->count; p++) {
        double distance = recurrence_distance(system, h, p, p + 2);
        *closest = fmin(*closest, distance);
        if (distance < threshold)
            return p;
    }
    return 0;
}

/* Whether the system is at rest: forced only trivially, no event and no motion over the last periods. */
static bool is_resting(const saltus_system *system, saltus_flow *flow, const history *h, double *field) {
    if (saltus_system_forced(system) || h->count < 4)
        return false;
    const double *scale = saltus_system_scale(system);
    for (int k = 0; k < 3; k++)
        if (h->contact_event[(h->count - 1 - k) % h->size] ||
            h->excursion[(h->count - 1 - k) % h->size] > at_rest)
            return false;
    /* The field of a fast mode magnifies rounding; what counts is that nothing moved and no displacement
     * drifts. */
    double drift = 0;
    saltus_flow_field(flow, 0, field);
    for (int i = 0; i < saltus_system_dof(system); i++)
        drift = fmax(drift, fabs(field[i]) / scale[i] * saltus_system_period(system));
    return drift < 1e3 * at_rest;
}

/* The least divisor of the orbit's period after which it already closes: a slowly settling trajectory recurs
 * first after a multiple of its least period. */
static int least_period(const saltus_system *system, const saltus_flow_options *options,
                        const saltus_orbit *orbit, saltus_message *message) {
    double point[SALTUS_STATE_MAX];
    saltus_section section = saltus_section_defaults();
    saltus_map *map = NULL;
    int least = orbit->periods;
    saltus_status status = saltus_map_new(system, &section, options, false, &map, message);
    if (status == SALTUS_OK)
        status = saltus_map_reset(map, orbit->state, message);
    for (int p = 1; p <= orbit->periods / 2 && status == SALTUS_OK && least == orbit->periods; p++) {
        status = saltus_map_step(map, point, NULL, message);
        if (status == SALTUS_OK && orbit->periods % p == 0 &&
            saltus_section_distance(system, point, orbit->state) < fmax(same_orbit, 1e4 * options->rtol))
            least = p;
    }
    saltus_map_free(map);
    return least;
}

/* Newton from the trajectory's last point; accepted if the orbit is where the trajectory is, and stable. */
static bool polish(const saltus_system *system, const saltus_classify_options *options, const history *h,
                   int p, double distance, saltus_orbit *orbit, saltus_message *message) {
    saltus_orbit_options shooting = saltus_motion_shooting(options);
    const double *last = point_at(h, h->count - 1);
    if (saltus_orbit_find(system, p, last, &shooting, orbit, message) != SALTUS_OK)
        return false;
    int least = least_period(system, &options->flow, orbit, message);
    if (least < p) {
        saltus_orbit whole = *orbit;
        saltus_status status = saltus_orbit_find(system, least, whole.state, &shooting, orbit, message);
        saltus_orbit_clear(&whole);
        if (status != SALTUS_OK)
            return false;
    }
    double moved = saltus_section_distance(system, orbit->state, last);
    if (saltus_motion_orbit_stable(orbit) && moved <= fmax(nearby, 30 * distance))
        return true;
    saltus_orbit_clear(orbit);
    return false;
}

/* The trajectory must go on closing in on the orbit: its distance falls to a fifth or below `close`, or,
 * where the largest multiplier is near the unit circle, at least half as far as that multiplier predicts. */
static saltus_status confirm(const saltus_system *system, saltus_flow *flow, history *h, double close,
                             const saltus_orbit *orbit, bool *confirmed, saltus_message *message) {
    enum { cycles_max = 60, patient_cycles = 40 };
    double start = saltus_section_distance(system, point_at(h, h->count - 1), orbit->state);
    *confirmed = false;
    for (int c = 0; c < cycles_max && !*confirmed; c++) {
        for (int k = 0; k < orbit->periods; k++) {
            saltus_status status = advance_period(system, flow, h, message);
            if (status != SALTUS_OK)
                return status;
        }
        double now = saltus_section_distance(system, point_at(h, h->count - 1), orbit->state);
        double predicted = exp((c + 1) * orbit->multipliers[0].log_modulus);
        *confirmed = now < close || (c > 2 && now < 0.2 * start) ||
                     (c >= patient_cycles && now <= start * (1 - 0.5 * (1 - predicted)));
        if (now > 10 * start + close)
            break;
    }
    return SALTUS_OK;
}

static saltus_status settle(const saltus_system *system, saltus_flow *flow, history *h,
                            const saltus_classify_options *options, saltus_motion *motion,
                            saltus_orbit *orbit, bool *found, saltus_message *message) {
    double *field = calloc((size_t)h->n, sizeof *field), closest = INFINITY;
    long long block = first_block;
    saltus_status status =
        field ? SALTUS_OK : saltus_fail(message, SALTUS_NO_MEMORY, "no memory to classify");
    bool stopped = false;
    *found = false;
    while (status == SALTUS_OK && !*found && !stopped && h->count < options->transient) {
        long long until = h->count + block < options->transient ? h->count + block : options->transient;
        while (status == SALTUS_OK && h->count < until)
            status = advance_period(system, flow, h, message);
        if (status != SALTUS_OK)
            break;
        stopped = options->progress && !options->progress(options->context, h->count, options->transient);
        if (is_resting(system, flow, h, field)) {
            motion->kind = saltus_flow_contacts(flow, 0) ? SALTUS_HELD : SALTUS_EQUILIBRIUM;
            break;
        }
        int p = saltus_system_forced(system)
                    ? candidate_period(system, h, options->longest, recurrence, &closest)
                    : 0;
        if (p && polish(system, options, h, p, closest, orbit, message)) {
            status = confirm(system, flow, h, fmax(1e-9, 1e4 * options->flow.rtol), orbit, found, message);
            if (status != SALTUS_OK || !*found)
                saltus_orbit_clear(orbit);
        }
        block = block < 1024 ? block + block / 2 : 1024;
    }
    if (status == SALTUS_OK && !*found && motion->kind == SALTUS_UNDECIDED)
        snprintf(motion->reason, sizeof motion->reason,
                 "no stable orbit of period up to %d T after %lld periods%s; closest recurrence %.2g of the "
                 "state's "
                 "scale; a longer --transient or a Lyapunov exponent would decide",
                 options->longest, h->count, stopped ? " (stopped)" : "", closest);
    free(field);
    return status;
}

saltus_status saltus_classify(const saltus_system *system, const double *state,
                              const saltus_classify_options *options, saltus_motion *motion,
                              saltus_message *message) {
    *motion = (saltus_motion){0};
    if (options->transient < 1 || options->longest < 1 || options->longest > 1024)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "transient must be at least 1, the longest period from 1 to 1024");
    saltus_flow_options flow_options = options->flow;
    flow_options.columns = 0;
    saltus_flow *flow = NULL;
    saltus_orbit orbit = {0};
    history h = {0};
    bool found = false;
    saltus_status status = saltus_flow_new(&system, 1, &flow_options, &flow, message);
    if (status == SALTUS_OK && !(saltus_motion_open(system, motion) &&
                                 open_history(&h, motion->dimension, 4 * options->longest + 8)))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory to classify");
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, message);
    if (status == SALTUS_OK)
        status = settle(system, flow, &h, options, motion, &orbit, &found, message);
    motion->transient = h.count;
    if (status == SALTUS_OK)
        status = found ? saltus_motion_take(system, flow, &orbit, options, motion, message)
                       : saltus_motion_rest(system, flow, options, motion, message);
    saltus_orbit_clear(&orbit);
    close_history(&h);
    saltus_flow_free(flow);
    if (status != SALTUS_OK)
        saltus_motion_clear(motion);
    return status;
}
