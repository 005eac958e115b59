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

enum {
    first_block = 64,
    patience = 10, /* a motion without a period is judged after this part of the time it may take to settle */
    longest_period = 1024
};

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
    return (saltus_classify_options){
        .flow = saltus_flow_defaults(), .transient = 20000, .measure = 256000, .longest = 64};
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
    status = saltus_motion_bounded(system, point_at(h, h->count), h->count + 1, message);
    if (status != SALTUS_OK)
        return status;
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

/* A failure of what was only tried, which is none unless memory is lacking. */
static saltus_status tried(saltus_status status) {
    return status == SALTUS_NO_MEMORY ? status : SALTUS_OK;
}

/* The least divisor of the orbit's period after which it already closes: a slowly settling trajectory recurs
 * first after a multiple of its least period. */
static saltus_status least_period(const saltus_system *system, const saltus_flow_options *options,
                                  const saltus_orbit *orbit, int *least, saltus_message *message) {
    double point[SALTUS_STATE_MAX];
    saltus_section section = saltus_section_defaults();
    saltus_map *map = NULL;
    *least = orbit->periods;
    saltus_status status = saltus_map_new(system, &section, options, false, &map, message);
    if (status == SALTUS_OK)
        status = saltus_map_reset(map, orbit->state, message);
    for (int p = 1; p <= orbit->periods / 2 && status == SALTUS_OK && *least == orbit->periods; p++) {
        status = saltus_map_step(map, point, NULL, message);
        if (status == SALTUS_OK && orbit->periods % p == 0 &&
            saltus_section_distance(system, point, orbit->state) < fmax(same_orbit, 1e4 * options->rtol))
            *least = p;
    }
    saltus_map_free(map);
    return tried(status);
}

/* Newton from the trajectory's last point; accepted if the orbit is where the trajectory is, and stable. */
static saltus_status polish(const saltus_system *system, const saltus_classify_options *options,
                            const history *h, int p, double distance, saltus_orbit *orbit, bool *accepted,
                            saltus_message *message) {
    saltus_orbit_options shooting = saltus_motion_shooting(options);
    const double *last = point_at(h, h->count - 1);
    int least = p;
    *accepted = false;
    saltus_status status = saltus_orbit_find(system, p, last, &shooting, orbit, message);
    if (status != SALTUS_OK)
        return tried(status);
    status = least_period(system, &options->flow, orbit, &least, message);
    if (status == SALTUS_OK && least < p) {
        saltus_orbit whole = *orbit;
        status = saltus_orbit_find(system, least, whole.state, &shooting, orbit, message);
        saltus_orbit_clear(&whole);
    }
    *accepted = status == SALTUS_OK && saltus_motion_orbit_stable(orbit) &&
                saltus_section_distance(system, orbit->state, last) <= fmax(nearby, 30 * distance);
    if (!*accepted)
        saltus_orbit_clear(orbit);
    return tried(status);
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

/* A search under way: the trajectory, what it has done, and the orbit once one is found. */
typedef struct search {
    const saltus_system *system;
    const saltus_classify_options *options;
    saltus_flow *flow;
    history h;
    saltus_orbit orbit;
    double *field, closest;
    bool found, stopped;
    bool limited; /* no very long orbits of very many impacts */
} search;

static saltus_status open_search(search *s, const double *state, saltus_message *message) {
    saltus_flow_options flow_options = s->options->flow;
    int n = saltus_system_dimension(s->system);
    flow_options.columns = flow_options.directions = 0;
    s->closest = INFINITY;
    saltus_status status = saltus_flow_new(&s->system, 1, &flow_options, &s->flow, message);
    s->field = calloc((size_t)n, sizeof *s->field);
    if (status == SALTUS_OK && !(s->field && open_history(&s->h, n, 4 * s->options->longest + 8)))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory to classify");
    if (status == SALTUS_OK)
        status = saltus_flow_start(s->flow, 0, (saltus_time){0, 0}, state, message);
    return status;
}

static void close_search(search *s) {
    saltus_orbit_clear(&s->orbit);
    close_history(&s->h);
    saltus_flow_free(s->flow);
    free(s->field);
}

/* Newton's method is not asked about very long orbits of very many impacts: each try would take minutes. */
static bool is_too_long(const search *s, int p) {
    enum { most_impacts = 150 };
    double impacts = (double)saltus_flow_information(s->flow, 0).impacts / (double)s->h.count;
    return s->limited && p * impacts > most_impacts;
}

/* Try the period that recurs at present. */
static saltus_status try_period(search *s, saltus_message *message) {
    const saltus_classify_options *o = s->options;
    int p = saltus_system_forced(s->system)
                ? candidate_period(s->system, &s->h, o->longest, recurrence, &s->closest)
                : 0;
    bool accepted = false;
    saltus_status status = SALTUS_OK;
    if (p && !is_too_long(s, p))
        status = polish(s->system, o, &s->h, p, s->closest, &s->orbit, &accepted, message);
    if (!accepted)
        return status;
    status =
        confirm(s->system, s->flow, &s->h, fmax(1e-9, 1e4 * o->flow.rtol), &s->orbit, &s->found, message);
    if (status != SALTUS_OK || !s->found)
        saltus_orbit_clear(&s->orbit);
    return status;
}

/* Go on until the trajectory has come to a rest, which goes to motion->kind, or to an orbit, or so many
 * periods have passed. */
static saltus_status settle(search *s, long long at_most, saltus_motion *motion, saltus_message *message) {
    const saltus_classify_options *o = s->options;
    long long block = first_block;
    saltus_status status = SALTUS_OK;
    while (status == SALTUS_OK && !s->found && !s->stopped && s->h.count < at_most) {
        long long until = s->h.count + block < at_most ? s->h.count + block : at_most;
        while (status == SALTUS_OK && s->h.count < until)
            status = advance_period(s->system, s->flow, &s->h, message);
        s->stopped = saltus_motion_stopped(&o->flow);
        if (s->stopped)
            status = SALTUS_OK;
        if (status != SALTUS_OK || s->stopped)
            break;
        s->stopped = o->progress && !o->progress(o->context, s->h.count, o->transient);
        if (is_resting(s->system, s->flow, &s->h, s->field)) {
            motion->kind = saltus_flow_contacts(s->flow, 0) ? SALTUS_HELD : SALTUS_EQUILIBRIUM;
            break;
        }
        status = try_period(s, message);
        block = block < 1024 ? block + block / 2 : 1024;
    }
    motion->transient = s->h.count;
    return status;
}

/* What is concluded while flows are being stopped is no evidence: the motion is undecided. */
static saltus_status drop_verdict(search *s, saltus_motion *motion) {
    saltus_motion_forget_evidence(motion);
    motion->kind = SALTUS_UNDECIDED;
    motion->lyapunov = motion->lyapunov_error = NAN;
    s->stopped = true;
    return SALTUS_OK;
}

/* Fill the motion with what has been found, or say that nothing was. */
static saltus_status conclude(search *s, saltus_motion *motion, saltus_message *message) {
    if (s->found)
        return saltus_motion_take(s->system, s->flow, &s->orbit, s->options, motion, message);
    if (motion->kind == SALTUS_UNDECIDED)
        snprintf(motion->reason, sizeof motion->reason,
                 "no stable orbit of period up to %d T after %lld periods%s; closest recurrence %.2g of the "
                 "state's scale; a longer --transient or a Lyapunov exponent would decide",
                 s->options->longest, s->h.count, s->stopped ? " (stopped)" : "", s->closest);
    return saltus_motion_rest(s->system, s->flow, s->options, motion, message);
}

static saltus_status check_options(const saltus_classify_options *options, saltus_message *message) {
    if (options->transient < 1 || options->longest < 1 || options->longest > longest_period ||
        options->measure < 0)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "transient must be at least 1, the longest period from 1 to %d, the periods "
                           "measured at least 0",
                           longest_period);
    return SALTUS_OK;
}

static saltus_status find_period(const saltus_system *system, const double *state,
                                 const saltus_classify_options *options, bool limited, saltus_motion *motion,
                                 saltus_message *message) {
    search s = {.system = system, .options = options, .limited = limited};
    *motion = (saltus_motion){0};
    saltus_status status = open_search(&s, state, message);
    if (status == SALTUS_OK && !saltus_motion_open(system, &options->flow, motion))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory to classify");
    if (status == SALTUS_OK)
        status = settle(&s, options->transient, motion, message);
    if (status == SALTUS_OK)
        status = conclude(&s, motion, message);
    close_search(&s);
    if (status != SALTUS_OK)
        saltus_motion_clear(motion);
    return status;
}

saltus_status saltus_motion_find_period(const saltus_system *system, const double *state,
                                        const saltus_classify_options *options, saltus_motion *motion,
                                        saltus_message *message) {
    return find_period(system, state, options, false, motion, message);
}

/* A motion in which nothing irregular goes on: look for longer periods than were asked for. */
static saltus_status find_long_period(search *s, saltus_motion *motion, saltus_message *message) {
    saltus_classify_options options = *s->options;
    saltus_motion found = {0};
    long long before = motion->transient;
    options.longest = longest_period;
    options.transient = 8 * longest_period;
    options.progress = NULL;
    saltus_status status = find_period(s->system, motion->state, &options, true, &found, message);
    if (status == SALTUS_OK && saltus_motion_settled(&found)) {
        saltus_motion_clear(motion);
        *motion = found;
        motion->transient += before;
    } else
        saltus_motion_clear(&found);
    return status;
}

/* No period so far: judge, and give a motion that should settle the rest of the time. */
static saltus_status judge(search *s, saltus_motion *motion, saltus_message *message) {
    const saltus_classify_options *o = s->options;
    bool regular;
    saltus_flow_state(s->flow, 0, motion->state);
    saltus_status status = saltus_motion_judge(s->system, o, motion, &regular, &s->stopped, message);
    if (status != SALTUS_OK || s->stopped || motion->kind != SALTUS_UNDECIDED)
        return status;
    if (s->h.count < o->transient)
        status = settle(s, o->transient, motion, message);
    if (status != SALTUS_OK || s->found || motion->kind != SALTUS_UNDECIDED)
        return status;
    saltus_flow_state(s->flow, 0, motion->state);
    if (status == SALTUS_OK && regular && motion->evidence.left == 0)
        status = find_long_period(s, motion, message);
    if (status == SALTUS_OK && regular && motion->kind == SALTUS_UNDECIDED)
        motion->kind = SALTUS_UNSETTLED;
    return status;
}

saltus_status saltus_classify(const saltus_system *system, const double *state,
                              const saltus_classify_options *options, saltus_motion *motion,
                              saltus_message *message) {
    search s = {.system = system, .options = options};
    *motion = (saltus_motion){0};
    saltus_status status = check_options(options, message);
    if (status != SALTUS_OK)
        return status;
    long long early = options->measure && options->transient > patience * first_block
                          ? options->transient / patience
                          : options->transient;
    status = open_search(&s, state, message);
    if (status == SALTUS_OK && !saltus_motion_open(system, &options->flow, motion))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory to classify");
    if (status == SALTUS_OK)
        status = settle(&s, early, motion, message);
    bool open = status == SALTUS_OK && !s.found && motion->kind == SALTUS_UNDECIDED && !s.stopped;
    if (open && options->measure)
        status = judge(&s, motion, message);
    if (open && saltus_motion_stopped(&options->flow) && !saltus_motion_settled(motion))
        status = drop_verdict(&s, motion);
    bool judged = motion->evidence.periods > 0 && !s.found && !saltus_motion_settled(motion);
    if (status == SALTUS_OK && judged)
        status = saltus_motion_survey(system, s.flow, motion, message);
    else if (status == SALTUS_OK && !(saltus_motion_settled(motion) && motion->multiplier_count))
        status = conclude(&s, motion, message);
    /* What has no period shows how far it goes without a verdict, too. */
    if (status == SALTUS_OK && motion->kind == SALTUS_UNDECIDED && !judged && !s.stopped)
        status = saltus_motion_survey(system, s.flow, motion, message);
    close_search(&s);
    if (status != SALTUS_OK)
        saltus_motion_clear(motion);
    return status;
}
