/* Stable orbits amid points that look chaotic.
 *
 * In a window of periodic motion chaos is a transient, which may last for hundreds of thousands of periods.
 * The orbit that it ends on is there all the time: Newton's method from close returns finds it long before
 * the trajectory does. Plain steps on the stroboscopic map, given up as soon as they do not converge, make
 * this cheap; what converges is confirmed by saltus_orbit_find.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/amid.h"

#include "base/dense.h"
#include "motion/motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    longest = 12,
    returns = 48,
    fewest = 5,
    steps = 10,
    bisections = 6,
    probes = 64,
    wait_most = 2000,
    remembered = 8
};
static const double converged = 1e-6, hopeless = 10;
/* Near is what lies within so many distances of neighbouring points, or such a part of their extent. */
static const double spacings = 16, part_of_extent = 0.06;

typedef struct amid {
    const saltus_system *system;
    const saltus_flow_options *flow;
    const double *points;
    long long count;
    int n;
    double extent; /* of the points */
    saltus_arena arena;
    double *state, *image, *derivative, *matrix, *real, *imaginary;
    double *beside; /* points of orbits that are of no account: the last `remembered` ones */
    int besides;
    int *pivots;
} amid;

static void reserve(amid *a) {
    size_t n = (size_t)a->n;
    a->state = saltus_arena_doubles(&a->arena, n);
    a->image = saltus_arena_doubles(&a->arena, n);
    a->derivative = saltus_arena_doubles(&a->arena, n * n);
    a->matrix = saltus_arena_doubles(&a->arena, n * n);
    a->real = saltus_arena_doubles(&a->arena, n);
    a->imaginary = saltus_arena_doubles(&a->arena, n);
    a->beside = saltus_arena_doubles(&a->arena, remembered * n);
    a->pivots = (int *)saltus_arena_doubles(&a->arena, n);
}

static double extent_of_points(const amid *a) {
    double extent = 0;
    for (int k = 0; k < probes; k++)
        extent = fmax(
            extent, saltus_section_distance(a->system, a->points + a->count * k / probes * a->n, a->points));
    return extent;
}

/* The points that come back best after p periods, apart from each other in time; how many. Short periods,
 * whose trials cost little, get more of them. */
static int best_returns(const amid *a, int p, long long places[returns]) {
    double distance[returns];
    int found = 0, most = returns / p > fewest ? returns / p : fewest;
    long long last = -p - 1;
    for (long long k = 0; k + p < a->count; k++) {
        double d = saltus_section_distance(a->system, a->points + k * a->n, a->points + (k + p) * a->n);
        int slot = found < most ? found : most - 1;
        if (k - last <= p || (found == most && !(d < distance[slot])))
            continue;
        for (; slot > 0 && d < distance[slot - 1]; slot--) {
            distance[slot] = distance[slot - 1];
            places[slot] = places[slot - 1];
        }
        distance[slot] = d;
        places[slot] = last = k;
        found += found < most;
    }
    return found;
}

/* One step of Newton's method for a fixed point of the map; false if the matrix is singular. */
static bool step(amid *a) {
    int n = a->n;
    for (int i = 0; i < n; i++) {
        a->image[i] -= a->state[i];
        for (int k = 0; k < n; k++)
            a->matrix[i * n + k] = (i == k) - a->derivative[i * n + k];
    }
    if (!saltus_dense_solve(a->matrix, n, a->image, a->pivots))
        return false;
    for (int i = 0; i < n; i++)
        a->state[i] += a->image[i];
    return true;
}

static bool contracts(amid *a) {
    memcpy(a->matrix, a->derivative, (size_t)(a->n * a->n) * sizeof *a->matrix);
    if (!saltus_dense_eigenvalues(a->matrix, a->n, a->real, a->imaginary))
        return false;
    for (int i = 0; i < a->n; i++)
        if (hypot(a->real[i], a->imaginary[i]) >= 1)
            return false;
    return true;
}

static bool is_beside(const amid *a) {
    for (int k = 0; k < a->besides && k < remembered; k++)
        if (saltus_section_distance(a->system, a->state, a->beside + k * a->n) < 10 * converged)
            return true;
    return false;
}

/* Newton's method from a point: does it lead to a stable fixed point of the map? What is not amid the points
 * is not looked for; far out a single period can take as long as a million of the motion's. */
static bool leads_to_stable(amid *a, saltus_map *map, const double *point) {
    double before = INFINITY;
    memcpy(a->state, point, (size_t)a->n * sizeof *point);
    for (int k = 0; k < steps; k++) {
        if (saltus_map_reset(map, a->state, NULL) != SALTUS_OK ||
            saltus_map_step(map, a->image, NULL, NULL) != SALTUS_OK)
            return false;
        double residual = saltus_section_distance(a->system, a->image, a->state);
        saltus_map_derivative(map, a->derivative);
        if (residual < converged)
            return contracts(a) && !is_beside(a);
        if (!(residual < hopeless * before) || !step(a) ||
            !(saltus_section_distance(a->system, a->state, point) < a->extent))
            return false;
        before = residual;
    }
    return false;
}

/* Confirm what has converged, and describe it. */
static bool confirm(const amid *a, int p, saltus_motion *motion) {
    saltus_classify_options options = saltus_classify_defaults();
    options.flow = *a->flow;
    saltus_orbit_options shooting = saltus_motion_shooting(&options);
    saltus_orbit orbit = {0};
    bool stable = saltus_orbit_find(a->system, p, a->state, &shooting, &orbit, NULL) == SALTUS_OK &&
                  saltus_motion_orbit_stable(&orbit) &&
                  saltus_motion_describe(a->system, &orbit, &options, motion, NULL) == SALTUS_OK;
    saltus_orbit_clear(&orbit);
    return stable;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Distance of a point to the nearest of the others, or of all where `self` is -1; which one it is. */
static double nearest(const amid *a, const double *point, long long self, long long *which) {
    double least = INFINITY;
    for (long long k = 0; k < a->count; k++) {
        double d = k == self ? INFINITY : saltus_section_distance(a->system, point, a->points + k * a->n);
        if (d < least) {
            least = d;
            *which = k;
        }
    }
    return least;
}

/* What distance from the points is near. */
static double near_enough(const amid *a) {
    double spacing[probes];
    long long which;
    for (int k = 0; k < probes; k++) {
        long long place = a->count * k / probes;
        spacing[k] = nearest(a, a->points + place * a->n, place, &which);
    }
    qsort(spacing, probes, sizeof spacing[0], compare);
    return fmax(spacings * spacing[probes / 2], part_of_extent * a->extent);
}

/* Whether a state comes to the orbit: to a tenth of its distance, in the time that takes on the orbit's
 * terms. */
static bool captured(amid *a, saltus_flow *flow, const saltus_motion *orbit, const double *from,
                     double distance) {
    double cycles = log(0.05) / fmin(orbit->multipliers[0].log_modulus, -1e-3);
    long long wait = orbit->periods * (20 + (long long)cycles);
    saltus_event event;
    saltus_time until = {wait < wait_most ? wait : wait_most, 0};
    if (saltus_flow_start(flow, 0, (saltus_time){0, 0}, from, NULL) != SALTUS_OK ||
        saltus_flow_advance(flow, until, 0, &event, NULL) != SALTUS_OK)
        return false;
    saltus_flow_state(flow, 0, a->image);
    for (int k = 0; k < orbit->periods; k++)
        if (saltus_section_distance(a->system, a->image, orbit->section_states + (size_t)k * (size_t)a->n) <
            0.1 * distance)
            return true;
    return false;
}

/* How near to the points the orbit's basin reaches, on the way from the orbit to the nearest of them. */
static double distance_of_basin(amid *a, saltus_flow *flow, const saltus_motion *orbit) {
    double least = INFINITY, low = 0, high = 1;
    const double *from = NULL, *to = NULL;
    for (int k = 0; k < orbit->periods; k++) {
        const double *point = orbit->section_states + (size_t)k * (size_t)a->n;
        long long which = 0;
        double d = nearest(a, point, -1, &which);
        if (d < least) {
            least = d;
            from = point;
            to = a->points + which * a->n;
        }
    }
    for (int k = 0; k < bisections; k++) {
        double middle = 0.5 * (low + high);
        for (int i = 0; i < a->n; i++)
            a->state[i] = from[i] + middle * (to[i] - from[i]);
        *(captured(a, flow, orbit, a->state, middle * least) ? &low : &high) = middle;
    }
    return (1 - low) * least;
}

static bool within_basin(amid *a, const saltus_motion *orbit, saltus_status *status,
                         saltus_message *message) {
    saltus_flow *flow = NULL;
    saltus_flow_options plain = *a->flow;
    plain.columns = plain.directions = 0;
    *status = saltus_flow_new(&a->system, 1, &plain, &flow, message);
    bool near = *status == SALTUS_OK && distance_of_basin(a, flow, orbit) < near_enough(a);
    saltus_flow_free(flow);
    return near;
}

static saltus_status try_period(amid *a, int p, saltus_motion *motion, bool *found, saltus_message *message) {
    long long places[returns];
    saltus_section section = saltus_section_defaults();
    saltus_map *map = NULL;
    section.iterate = p;
    saltus_status status = saltus_map_new(a->system, &section, a->flow, true, &map, message);
    int count = status == SALTUS_OK ? best_returns(a, p, places) : 0;
    for (int k = 0; k < count && !*found && status == SALTUS_OK; k++) {
        if (!leads_to_stable(a, map, a->points + places[k] * a->n) || !confirm(a, p, motion))
            continue;
        memcpy(a->beside + a->besides++ % remembered * a->n, a->state, (size_t)a->n * sizeof *a->state);
        *found = within_basin(a, motion, &status, message);
        if (!*found)
            saltus_motion_clear(motion);
    }
    saltus_map_free(map);
    return status;
}

saltus_status saltus_stable_orbit_amid(const saltus_system *system, const saltus_flow_options *flow,
                                       const double *points, long long count, saltus_motion *motion,
                                       bool *found, saltus_message *message) {
    amid a = {.system = system,
              .flow = flow,
              .points = points,
              .count = count,
              .n = saltus_system_dimension(system)};
    saltus_status status = SALTUS_OK;
    *found = false;
    *motion = (saltus_motion){0};
    reserve(&a);
    if (!saltus_arena_open(&a.arena))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory to look for stable orbits");
    reserve(&a);
    a.extent = extent_of_points(&a);
    for (int p = 1; p <= longest && status == SALTUS_OK && !*found; p++)
        status = try_period(&a, p, motion, found, message);
    saltus_arena_close(&a.arena);
    return status;
}
