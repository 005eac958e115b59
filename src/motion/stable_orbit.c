/* Stable orbits among points that look chaotic.
 *
 * In a window of periodic motion chaos is a transient that may last for hundreds of thousands of periods.
 * The orbit that it ends on exists all the time: Newton's method from close returns finds it long before the
 * trajectory does. Mostly it first finds the unstable orbit that was born together with the stable one and
 * bounds its basin, because trajectories come near that one more often. From an unstable orbit, trajectories
 * are therefore followed to both sides along the unstable direction; one of them leads to the stable orbit.
 * Returns over which tangent vectors have grown much belong to other unstable orbits, whose number grows
 * with the period: they are skipped at once. The remaining returns are tried with plain Newton steps on the
 * stroboscopic map, given up as soon as they do not converge; saltus_orbit_find confirms what they find.
 * Short periods come first; where steps and tangent vectors are many, the search ends before the longest.
 * SPDX-License-Identifier: GPL-3.0-or-later */

#include "base/dense.h"
#include "flow/effort.h"
#include "motion/motion.h"
#include "orbit/fixed_point.h"
#include "orbit/returns.h"
#include "system/state.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    longest = 64,
    most = 200,     /* returns of period 1 that are tried; of period p this over p, ... */
    fewest = 5,     /* ... but at least this many */
    kept = 100,     /* returns kept for each period; those to orbits tried before are skipped */
    steps = 8,      /* of Newton's method */
    turns = 12,     /* power iterations for the unstable direction */
    leaving = 40,   /* cycles to get from an unstable orbit to a stable one */
    bisections = 6, /* for the edge of the basin between an orbit and the points */
    probes = 64,    /* points that are enough for the extent of all */
    neighbours = 16,
    wait_most = 200,      /* periods to wait for capture at most, ... */
    wait_cycles = 12,     /* ... or cycles, if these take longer */
    remembered = 1024,    /* latest points of orbits that have been tried */
    least_tries = 200,    /* tries before the search is given up if fewer than one in ... */
    hopeless = 25,        /* ... this many has led to an orbit; with damping one in ten does */
    dear_steps = 1000000, /* steps from which on ... */
    dear_tries = 75,      /* ... so many tries are enough for that */
    most_steps = 20000000 /* of the flow, as efforts count them; pipes of up to six modes take 7 million */
};
static const double same_orbit = 1e-5; /* in scales: orbits this near are the same */
static const double near_return = 0.2; /* of the points' extent: farther returns do not count */
static const double same_return = 0.3; /* of their distance: returns this near lead to the same orbit */
static const double may_shrink = 8;    /* logarithm of a growth: above it no orbit nearby is stable */
static const double step_aside = 1e-3; /* from an unstable orbit, in scales */
/* An orbit counts if its basin comes as near to the points as this many times the distance of the point
 * nearest to it from that point's 16th neighbour. */
static const double spacings = 12;

typedef struct search {
    const saltus_system *system;
    const saltus_flow_options *flow;
    const saltus_track *tracks;
    int track_count, n;
    double extent;      /* extent of the points */
    saltus_flow *plain; /* without columns */
    double *tried;      /* ring buffer of points of orbits that have been tried, and their periods */
    int tried_periods[remembered];
    long long tried_count;
    long long tries, led; /* returns that Newton's method began with, and that led it to an orbit */
} search;

/* Advance a state at phase 0 by whole periods. False if the flow fails. */
static bool advance(const search *s, int periods, double *state) {
    return saltus_state_carry(s->plain, (saltus_time){0, 0}, (saltus_time){periods, 0}, state, NULL) ==
           SALTUS_OK;
}

/* Whether a state lies within `distance` of an orbit that has been tried, whose period divides p. */
static bool was_tried(const search *s, int p, const double *state, double distance) {
    for (long long k = 0; k < s->tried_count && k < remembered; k++)
        if (p % s->tried_periods[k] == 0 &&
            saltus_system_distance_within(s->system, state, s->tried + k * s->n, distance) < distance)
            return true;
    return false;
}

/* Follow a trajectory from beside an unstable orbit, displaced by `step` along a direction. Returns the
 * period of the stable orbit that it comes to, p or 2 p, with a state on that; 0 if it goes elsewhere. */
static int follow_away(const search *s, const saltus_fixed_point *f, int p, const double *direction,
                       double step, double *state) {
    double last[2][SALTUS_STATE_MAX];
    size_t size = (size_t)s->n * sizeof *state;
    for (int i = 0; i < s->n; i++)
        state[i] = f->state[i] + step * direction[i] * f->scale[i];
    saltus_state_admit(s->system, state);
    for (int cycle = 0; cycle < leaving; cycle++) {
        memcpy(last[cycle % 2], state, size);
        if (!advance(s, p, state) ||
            saltus_system_distance_within(s->system, state, f->state, near_return * s->extent) == INFINITY)
            return 0;
    }
    if (saltus_system_distance(s->system, state, f->state) < step_aside)
        return 0;
    for (int back = 1; back <= 2; back++)
        if (saltus_system_distance(s->system, state, last[(leaving - back) % 2]) < step_aside)
            return back * p;
    return 0;
}

/* The nearest of all tracks' points, if nearer than *distance, which is then updated; otherwise NULL. */
static const double *nearest(const search *s, const double *point, double *distance) {
    const double *place = NULL;
    for (int t = 0; t < s->track_count; t++)
        for (long long k = 0; k < s->tracks[t].count; k++) {
            const double *other = s->tracks[t].points + k * s->n;
            double d = saltus_system_distance_within(s->system, point, other, *distance);
            if (d < *distance) {
                *distance = d;
                place = other;
            }
        }
    return place;
}

/* Distance of a point of a track to its 16th neighbour among all tracks' points. */
static double spacing_at(const search *s, const double *point) {
    double nearest_ones[neighbours + 1]; /* the point itself is the first */
    int used = 0;
    for (int t = 0; t < s->track_count; t++)
        for (long long k = 0; k < s->tracks[t].count; k++) {
            double limit = used <= neighbours ? INFINITY : nearest_ones[neighbours],
                   d = saltus_system_distance_within(s->system, point, s->tracks[t].points + k * s->n, limit);
            if (!(d < limit))
                continue;
            int place = used <= neighbours ? used++ : neighbours;
            for (; place > 0 && nearest_ones[place - 1] > d; place--)
                nearest_ones[place] = nearest_ones[place - 1];
            nearest_ones[place] = d;
        }
    return nearest_ones[used - 1];
}

/* Whether the orbit's basin reaches near the points: bisect the line from the orbit to the nearest point. A
 * state at a distance from the orbit is in the basin if it comes to a tenth of it, in the time in which the
 * orbit's largest multiplier shrinks it twentyfold and 20 cycles more, within a limit. */
static bool lies_amid(const search *s, const saltus_motion *orbit) {
    const double cycles = log(0.05) / fmin(orbit->multipliers[0].log_modulus, -1e-3);
    const int patient = wait_cycles * orbit->periods,
              most_periods = patient > wait_most ? patient : wait_most,
              periods = orbit->periods * (20 + (int)cycles);
    double least = INFINITY, low = 0, high = 1, state[SALTUS_STATE_MAX];
    const double *from = NULL, *to = NULL;
    for (int k = 0; k < orbit->periods; k++) {
        const double *point = orbit->section_states + (size_t)k * (size_t)s->n;
        const double *there = nearest(s, point, &least);
        from = there ? point : from;
        to = there ? there : to;
    }
    for (int k = 0; k < bisections; k++) {
        const double middle = 0.5 * (low + high);
        for (int i = 0; i < s->n; i++)
            state[i] = from[i] + middle * (to[i] - from[i]);
        const bool captured = advance(s, periods < most_periods ? periods : most_periods, state) &&
                              saltus_orbit_passes(s->system, orbit->section_states, orbit->periods, state,
                                                  0.1 * middle * least);
        *(captured ? &low : &high) = middle;
    }
    return (1 - low) * least < spacings * spacing_at(s, to);
}

/* Newton's method from a return: find a stable orbit, or an unstable one with a stable one beside it. */
static saltus_status try_return(search *s, saltus_fixed_point *f, int p, const double *from,
                                saltus_motion *motion, saltus_message *message) {
    saltus_classify_options options = saltus_classify_defaults();
    double state[SALTUS_STATE_MAX], direction[SALTUS_STATE_MAX], image[SALTUS_STATE_MAX];
    options.flow = *s->flow;
    const bool led = saltus_fixed_point_find(f, from, steps, s->extent);
    s->tries++;
    s->led += led;
    if (!led || was_tried(s, p, f->state, same_orbit))
        return SALTUS_OK;
    int periods = p;
    memcpy(state, f->state, (size_t)s->n * sizeof *state);
    if (saltus_fixed_point_multiplier(f) >= 0) {
        /* The direction in which the map's derivative grows most, in scales, with largest entry 1. */
        for (int i = 0; i < s->n; i++)
            direction[i] = 1;
        for (int turn = 0; turn < turns; turn++) {
            double length = 0;
            for (int i = 0; i < s->n; i++) {
                image[i] = saltus_dot(f->derivative + i * s->n, direction, s->n);
                length = fmax(length, fabs(image[i]));
            }
            for (int i = 0; i < s->n && length > 0; i++)
                direction[i] = image[i] / length;
        }
        periods = follow_away(s, f, p, direction, step_aside, state);
        if (!periods)
            periods = follow_away(s, f, p, direction, -step_aside, state);
    }
    /* Remember the points of the orbit. */
    double point[SALTUS_STATE_MAX];
    memcpy(point, f->state, (size_t)s->n * sizeof *point);
    for (int k = 0; k < p; k++) {
        const long long place = s->tried_count++ % remembered;
        memcpy(s->tried + place * s->n, point, (size_t)s->n * sizeof *point);
        s->tried_periods[place] = p;
        if (!advance(s, 1, point))
            break;
    }
    if (!periods)
        return SALTUS_OK;
    saltus_status status =
        saltus_motion_polish(s->system, periods, state, INFINITY, &options, motion, message);
    if (saltus_verdict_settled(motion->verdict) && !lies_amid(s, motion))
        saltus_motion_clear(motion);
    return status;
}

saltus_status saltus_stable_orbit_among(const saltus_system *system, const saltus_flow_options *flow,
                                        const saltus_track *tracks, int track_count, saltus_motion *motion,
                                        saltus_message *message) {
    search s = {.system = system,
                .flow = flow,
                .tracks = tracks,
                .track_count = track_count,
                .n = saltus_system_dimension(system)};
    const double before = flow->effort ? flow->effort->total : 0; /* steps of the question so far */
    if (!saltus_system_forced(system))
        return saltus_stable_cycle_among(system, flow, tracks, motion, message);
    saltus_returns *returns = NULL;
    *motion = (saltus_motion){0};
    s.tried = malloc((size_t)remembered * (size_t)s.n * sizeof *s.tried);
    saltus_status status = s.tried ? saltus_flow_single(system, 0, flow, &s.plain, message)
                                   : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for orbits");
    for (int k = 0; k < probes; k++)
        s.extent =
            fmax(s.extent, saltus_system_distance(system, tracks->points + tracks->count * k / probes * s.n,
                                                  tracks->points));
    /* The close returns along all tracks over which tangent vectors have not grown much. */
    const saltus_returns_wanted wanted = {1, longest, kept, near_return * s.extent, same_return, may_shrink};
    if (status == SALTUS_OK)
        status = saltus_returns_new(system, &wanted, &returns, message);
    for (int t = 0; t < track_count && status == SALTUS_OK; t++) {
        saltus_returns_break(returns);
        for (long long k = 0; k < tracks[t].count; k++)
            saltus_returns_add(returns, tracks[t].points + k * s.n, tracks[t].numbers[k]);
    }
    for (int p = 1; p <= longest && status == SALTUS_OK; p++) {
        saltus_fixed_point f = {0};
        saltus_return closest;
        int tries = most / p > fewest ? most / p : fewest;
        while (status == SALTUS_OK && tries > 0 && !saltus_verdict_settled(motion->verdict)) {
            const double taken = flow->effort ? flow->effort->total - before : 0;
            const int enough = taken > dear_steps ? dear_tries : least_tries;
            if (taken > most_steps || (s.tries >= enough && s.led * hopeless < s.tries) ||
                !saltus_returns_next(returns, p, &closest))
                break;
            if (was_tried(&s, p, closest.state, 2 * closest.distance))
                continue;
            if (!f.map)
                status = saltus_fixed_point_open(&f, system, p, flow, message);
            if (status == SALTUS_OK)
                status = try_return(&s, &f, p, closest.state, motion, message);
            tries--;
        }
        saltus_fixed_point_close(&f);
    }
    saltus_returns_free(returns);
    saltus_flow_free(s.plain);
    free(s.tried);
    return status;
}
