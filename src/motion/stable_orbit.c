/* Stable orbits among points that look chaotic.
 *
 * In a window of periodic motion chaos is a transient, which may last for hundreds of thousands of periods.
 * The orbit that it ends on is there all the time: Newton's method from close returns finds it long before
 * the trajectory does. Plain steps on the stroboscopic map, given up as soon as they do not converge, make
 * this cheap; what converges is confirmed by saltus_orbit_find.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/stable_orbit.h"

#include "motion/motion.h"
#include "orbit/fixed_point.h"
#include "orbit/returns.h"

#include <gsl/gsl_sort.h>
#include <math.h>
#include <string.h>

enum {
    longest = 12,
    most = 200,      /* returns of period 1 that are tried, fewer of longer periods, ... */
    fewest = 5,      /* ... but so many at least */
    steps = 10,      /* of Newton's method */
    bisections = 6,  /* on the way from an orbit to the points */
    probes = 64,     /* points that stand for all */
    wait_most = 200, /* periods */
    remembered = 8
};
static const double converged = 1e-6, hopeless = 10;
/* An orbit counts if its basin comes this near to the points: within so many distances of neighbouring
 * points, or such a part of their extent. */
static const double spacings = 16, part_of_extent = 0.06;

typedef struct search {
    const saltus_system *system;
    const saltus_flow_options *flow;
    const double *points;
    long long count;
    int n;
    double extent;                                 /* of the points */
    double rejected[remembered][SALTUS_STATE_MAX]; /* points of stable orbits far from these, the last ones */
    int rejections;                                /* how many there were */
} search;

static bool was_rejected(const search *s, const double *state) {
    for (int k = 0; k < s->rejections && k < remembered; k++)
        if (saltus_system_distance(s->system, state, s->rejected[k]) < 10 * converged)
            return true;
    return false;
}

/* Newton's method from a point: does it lead to a stable fixed point of the map? It is given up where it
 * leaves the points: far out a single period can take as long as a million of the motion's. */
static bool leads_to_stable(const search *s, saltus_fixed_point *f, const double *point) {
    double before = INFINITY;
    memcpy(f->state, point, (size_t)s->n * sizeof *point);
    for (int k = 0; k < steps; k++) {
        double residual = saltus_fixed_point_residual(f);
        if (residual < converged)
            return !(saltus_fixed_point_multiplier(f) >= 0) && !was_rejected(s, f->state);
        if (!(residual < hopeless * before) || saltus_fixed_point_step(f) == INFINITY ||
            !(saltus_system_distance(s->system, f->state, point) < s->extent))
            return false;
        before = residual;
    }
    return false;
}

/* Distance of a point to the nearest of the trajectory's points but `self` (-1: of all), and which that is.
 */
static double nearest(const search *s, const double *point, long long self, long long *which) {
    double least = INFINITY;
    for (long long k = 0; k < s->count; k++) {
        double d = k == self ? INFINITY : saltus_system_distance(s->system, point, s->points + k * s->n);
        if (d < least) {
            least = d;
            *which = k;
        }
    }
    return least;
}

/* What distance from the points is near. */
static double near_enough(const search *s) {
    double spacing[probes];
    long long which;
    for (int k = 0; k < probes; k++) {
        long long place = s->count * k / probes;
        spacing[k] = nearest(s, s->points + place * s->n, place, &which);
    }
    gsl_sort(spacing, 1, probes);
    return fmax(spacings * spacing[probes / 2], part_of_extent * s->extent);
}

/* Whether a state comes to the orbit: to a tenth of its distance, in the time which that takes by the orbit's
 * multipliers. */
static bool captured(const search *s, saltus_flow *flow, const saltus_motion *orbit, const double *from,
                     double distance) {
    double cycles = log(0.05) / fmin(orbit->multipliers[0].log_modulus, -1e-3), end[SALTUS_STATE_MAX];
    long long wait = orbit->periods * (20 + (long long)cycles);
    saltus_event event;
    saltus_time until = {wait < wait_most ? wait : wait_most, 0};
    if (saltus_flow_start(flow, 0, (saltus_time){0, 0}, from, NULL) != SALTUS_OK ||
        saltus_flow_advance(flow, until, 0, &event, NULL) != SALTUS_OK)
        return false;
    saltus_flow_state(flow, 0, end);
    return saltus_orbit_passes(s->system, orbit->section_states, orbit->periods, end, 0.1 * distance);
}

/* How near to the points the orbit's basin reaches, on the way from the orbit to the nearest of them. */
static double distance_of_basin(const search *s, saltus_flow *flow, const saltus_motion *orbit) {
    double least = INFINITY, low = 0, high = 1, state[SALTUS_STATE_MAX];
    const double *from = NULL, *to = NULL;
    for (int k = 0; k < orbit->periods; k++) {
        const double *point = orbit->section_states + (size_t)k * (size_t)s->n;
        long long which = 0;
        double d = nearest(s, point, -1, &which);
        if (d < least) {
            least = d;
            from = point;
            to = s->points + which * s->n;
        }
    }
    for (int k = 0; k < bisections; k++) {
        double middle = 0.5 * (low + high);
        for (int i = 0; i < s->n; i++)
            state[i] = from[i] + middle * (to[i] - from[i]);
        *(captured(s, flow, orbit, state, middle * least) ? &low : &high) = middle;
    }
    return (1 - low) * least;
}

/* The closest returns after p periods; short periods, whose trials cost little, get more of them. */
static saltus_status try_period(search *s, saltus_returns *returns, int p, saltus_motion *motion, bool *found,
                                saltus_message *message) {
    int tries = most / p > fewest ? most / p : fewest;
    saltus_classify_options options = saltus_classify_defaults();
    options.flow = *s->flow;
    saltus_fixed_point f;
    saltus_return closest;
    saltus_status status = saltus_fixed_point_open(&f, s->system, p, s->flow, message);
    for (int k = 0; k < tries && !*found && status == SALTUS_OK && saltus_returns_next(returns, p, &closest);
         k++) {
        saltus_flow *flow = NULL;
        if (!leads_to_stable(s, &f, closest.state) ||
            saltus_motion_polish(s->system, p, f.state, INFINITY, &options, motion) != SALTUS_OK)
            continue;
        memcpy(s->rejected[s->rejections++ % remembered], f.state, (size_t)s->n * sizeof *f.state);
        status = saltus_flow_single(s->system, 0, s->flow, &flow, message);
        *found = status == SALTUS_OK && distance_of_basin(s, flow, motion) < near_enough(s);
        saltus_flow_free(flow);
        if (!*found)
            saltus_motion_clear(motion);
    }
    saltus_fixed_point_close(&f);
    return status;
}

saltus_status saltus_stable_orbit_among(const saltus_system *system, const saltus_flow_options *flow,
                                        const double *points, long long count, saltus_motion *motion,
                                        bool *found, saltus_message *message) {
    search s = {.system = system,
                .flow = flow,
                .points = points,
                .count = count,
                .n = saltus_system_dimension(system)};
    saltus_returns *returns = NULL;
    *found = false;
    *motion = (saltus_motion){0};
    for (int k = 0; k < probes; k++)
        s.extent = fmax(s.extent, saltus_system_distance(system, points + count * k / probes * s.n, points));
    saltus_status status = saltus_returns_new(system, longest, most, INFINITY, &returns, message);
    for (long long k = 0; k < count && status == SALTUS_OK; k++)
        saltus_returns_add(returns, points + k * s.n);
    for (int p = 1; p <= longest && status == SALTUS_OK && !*found; p++)
        status = try_period(&s, returns, p, motion, found, message);
    saltus_returns_free(returns);
    return status;
}
