/* Close returns of a trajectory, and the orbits that they lead to.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/returns.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The last points in a ring, the best returns of each period. Index p - 1 stands for period p. */
struct saltus_returns {
    saltus_arena arena;
    const saltus_system *system;
    int n, longest, most, ring;
    double recurrence;
    long long count;
    double *points;              /* the ring */
    double *now, *last, *before; /* distances from the points p earlier, at the last three points */
    double *distance, *state;    /* of the returns kept: `most` per period */
    int *used;                   /* of these */
};

static void reserve(saltus_returns *r) {
    size_t n = (size_t)r->n, longest = (size_t)r->longest, most = (size_t)r->most;
    r->points = saltus_arena_doubles(&r->arena, n * (size_t)r->ring);
    r->now = saltus_arena_doubles(&r->arena, longest);
    r->last = saltus_arena_doubles(&r->arena, longest);
    r->before = saltus_arena_doubles(&r->arena, longest);
    r->distance = saltus_arena_doubles(&r->arena, longest * most);
    r->state = saltus_arena_doubles(&r->arena, longest * most * n);
    r->used = (int *)(void *)saltus_arena_doubles(&r->arena, longest);
}

saltus_status saltus_returns_new(const saltus_system *system, int longest, int most, double recurrence,
                                 saltus_returns **returns, saltus_message *message) {
    saltus_returns *r = calloc(1, sizeof *r);
    *returns = r;
    if (r) {
        *r = (saltus_returns){.system = system,
                              .n = saltus_system_dimension(system),
                              .longest = longest,
                              .most = most,
                              .ring = longest + 2,
                              .recurrence = recurrence};
        reserve(r);
    }
    if (!r || !saltus_arena_open(&r->arena))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for close returns");
    reserve(r);
    for (int p = 0; p < longest; p++)
        r->now[p] = r->last[p] = r->before[p] = INFINITY;
    return SALTUS_OK;
}

void saltus_returns_free(saltus_returns *returns) {
    if (returns)
        saltus_arena_close(&returns->arena);
    free(returns);
}

static double *point_at(const saltus_returns *r, long long k) {
    return r->points + (size_t)(k % r->ring) * (size_t)r->n;
}

static double *state_at(const saltus_returns *r, int p, int slot) {
    return r->state + (size_t)((p - 1) * r->most + slot) * (size_t)r->n;
}

static double *distance_at(const saltus_returns *r, int p, int slot) {
    return r->distance + (p - 1) * r->most + slot;
}

/* Keep a return if it is among the closest. Of two that are nearer to each other than they recur, and so near
 * the same orbit, the closer one stays. */
static void keep(saltus_returns *r, int p, double distance, const double *state) {
    int place = -1, farthest = 0, used = r->used[p - 1];
    for (int slot = 0; slot < used; slot++) {
        double between = saltus_system_distance(r->system, state_at(r, p, slot), state);
        if (between <= fmax(distance, *distance_at(r, p, slot)))
            place = slot;
        if (*distance_at(r, p, slot) > *distance_at(r, p, farthest))
            farthest = slot;
    }
    if (place < 0)
        place = used < r->most ? r->used[p - 1]++ : farthest;
    if (place < used && *distance_at(r, p, place) <= distance)
        return;
    *distance_at(r, p, place) = distance;
    memcpy(state_at(r, p, place), state, (size_t)r->n * sizeof *state);
}

/* Whether the return to the last point but one after p periods is a candidate. */
static bool is_candidate(const saltus_returns *r, int p) {
    double distance = r->last[p - 1];
    if (!(distance < r->recurrence && distance <= r->before[p - 1] && distance <= r->now[p - 1]))
        return false;
    for (int q = 1; q <= p / 2; q++)
        if (p % q == 0 && r->last[q - 1] <= distance)
            return false;
    return true;
}

void saltus_returns_add(saltus_returns *r, const double *point) {
    double *oldest = r->before;
    long long k = r->count++;
    r->before = r->last;
    r->last = r->now;
    r->now = oldest;
    memcpy(point_at(r, k), point, (size_t)r->n * sizeof *point);
    for (int p = 1; p <= r->longest; p++)
        r->now[p - 1] =
            k >= p ? saltus_system_distance(r->system, point_at(r, k), point_at(r, k - p)) : INFINITY;
    for (int p = 1; p <= r->longest && k > p + 1; p++)
        if (is_candidate(r, p))
            keep(r, p, r->last[p - 1], point_at(r, k - 1 - p));
}

bool saltus_returns_next(saltus_returns *r, int periods, saltus_return *closest) {
    int best = -1;
    for (int slot = 0; slot < r->used[periods - 1]; slot++)
        if (*distance_at(r, periods, slot) < (best < 0 ? INFINITY : *distance_at(r, periods, best)))
            best = slot;
    if (best < 0)
        return false;
    *closest = (saltus_return){state_at(r, periods, best), *distance_at(r, periods, best)};
    *distance_at(r, periods, best) = INFINITY;
    return true;
}

saltus_status saltus_return_polish(saltus_flow *flow, int periods, const double *guess,
                                   const saltus_orbit_options *options, saltus_orbit *orbit, saltus_lap *lap,
                                   saltus_message *message) {
    saltus_status status =
        saltus_orbit_find(saltus_flow_system(flow, 0), periods, guess, options, orbit, message);
    if (status == SALTUS_OK)
        status = saltus_lap_around(lap, flow, orbit->state, periods, message);
    int least = status == SALTUS_OK ? saltus_lap_least_period(lap, &options->flow) : periods;
    if (least < periods) {
        saltus_orbit longer = *orbit;
        status = saltus_return_polish(flow, least, longer.state, options, orbit, lap, message);
        saltus_orbit_clear(&longer);
    } else if (status != SALTUS_OK)
        saltus_orbit_clear(orbit);
    return status;
}
