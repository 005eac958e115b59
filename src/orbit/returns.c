/* Close returns of a trajectory, and the orbits found from them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/returns.h"

#include "base/memory.h"
#include "orbit/multipliers.h"
#include "orbit/orbit.h"
#include "system/state.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A return that is kept; `taken`: it has been handed out. */
typedef struct kept {
    long long place;
    double distance;
    bool taken;
} kept;

/* Index i stands for shortest + i periods. */
struct saltus_returns {
    saltus_arena arena;
    const saltus_system *system;
    saltus_returns_wanted wanted;
    int n, spans, ring;
    long long count;             /* points of the present trajectory */
    double *points, *grown;      /* ring buffers: last points, and growth up to each */
    double *now, *last, *before; /* distances of the last three points from those p earlier */
    kept *kept;                  /* `most` for each number of periods, and their states */
    double *states;
    int *used; /* number used of these */
};

saltus_status saltus_returns_new(const saltus_system *system, const saltus_returns_wanted *wanted,
                                 saltus_returns **returns, saltus_message *message) {
    saltus_returns *r = calloc(1, sizeof *r);
    *returns = r;
    if (r) {
        *r = (saltus_returns){.system = system,
                              .wanted = *wanted,
                              .n = saltus_system_dimension(system),
                              .spans = wanted->longest - wanted->shortest + 1,
                              .ring = wanted->longest + 2};
        const size_t n = (size_t)r->n, spans = (size_t)r->spans, ring = (size_t)r->ring,
                     slots = spans * (size_t)wanted->most;
        do {
            r->points = saltus_arena_doubles(&r->arena, n * ring);
            r->grown = saltus_arena_doubles(&r->arena, ring);
            r->now = saltus_arena_doubles(&r->arena, spans);
            r->last = saltus_arena_doubles(&r->arena, spans);
            r->before = saltus_arena_doubles(&r->arena, spans);
            r->kept = (kept *)(void *)saltus_arena_doubles(&r->arena, slots * sizeof(kept) / sizeof(double));
            r->states = saltus_arena_doubles(&r->arena, n * slots);
            r->used = (int *)(void *)saltus_arena_doubles(&r->arena, spans);
        } while (saltus_arena_again(&r->arena));
    }
    if (!r || !r->arena.base)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for close returns");
    saltus_returns_break(r);
    return SALTUS_OK;
}

void saltus_returns_free(saltus_returns *returns) {
    if (returns)
        saltus_arena_close(&returns->arena);
    free(returns);
}

void saltus_returns_break(saltus_returns *r) {
    r->count = 0;
    for (int i = 0; i < r->spans; i++)
        r->now[i] = r->last[i] = r->before[i] = INFINITY;
}

static double *point_at(const saltus_returns *r, long long k) {
    return r->points + (size_t)(k % r->ring) * (size_t)r->n;
}

/* Keep a return if it is among the closest. Of two close to each other, and so to the same orbit, the closer
 * one stays. */
static void keep(saltus_returns *r, int i, long long place, const double *state) {
    const int first = i * r->wanted.most, used = first + r->used[i];
    const double distance = r->last[i];
    int slot = -1, farthest = first;
    for (int k = first; k < used; k++) {
        double within = r->wanted.same * fmax(distance, r->kept[k].distance);
        if (saltus_system_distance_within(r->system, r->states + k * r->n, state, within) <= within)
            slot = k;
        if (r->kept[k].distance > r->kept[farthest].distance)
            farthest = k;
    }
    if (slot < 0)
        slot = r->used[i] < r->wanted.most ? first + r->used[i]++ : farthest;
    if (slot < used && r->kept[slot].distance <= distance)
        return;
    r->kept[slot] = (kept){place, distance, false};
    memcpy(r->states + slot * r->n, state, (size_t)r->n * sizeof *state);
}

void saltus_returns_add(saltus_returns *r, const double *point, double growth) {
    const int shortest = r->wanted.shortest;
    double *oldest = r->before;
    long long k = r->count++;
    r->before = r->last;
    r->last = r->now;
    r->now = oldest;
    memcpy(point_at(r, k), point, (size_t)r->n * sizeof *point);
    r->grown[k % r->ring] = (k > 0 ? r->grown[(k - 1) % r->ring] : 0) + growth;
    for (int i = 0; i < r->spans; i++) {
        const long long from = k - shortest - i;
        const bool near = from >= 0 && r->grown[k % r->ring] - r->grown[from % r->ring] <= r->wanted.growth;
        r->now[i] = near ? saltus_system_distance_within(r->system, point_at(r, k), point_at(r, from),
                                                         r->wanted.recurrence)
                         : INFINITY;
    }
    /* Returns to the last but one point that are closer than those before and after, and than any divisor's.
     */
    for (int p = shortest; p <= r->wanted.longest && k > p + 1; p++) {
        const int i = p - shortest;
        const double distance = r->last[i];
        bool candidate = distance < r->wanted.recurrence && distance <= r->before[i] && distance <= r->now[i];
        for (int q = shortest; q <= p / 2 && candidate; q++)
            candidate = p % q != 0 || !(r->last[q - shortest] <= distance);
        if (candidate)
            keep(r, i, k - 1 - p, point_at(r, k - 1 - p));
    }
}

bool saltus_returns_next(saltus_returns *r, int periods, saltus_return *closest) {
    const int i = periods - r->wanted.shortest;
    kept *first = r->kept + i * r->wanted.most, *best = NULL;
    for (kept *k = first; k < first + r->used[i]; k++)
        if (!k->taken && (!best || k->distance < best->distance))
            best = k;
    if (!best)
        return false;
    *closest = (saltus_return){best->place, r->states + (best - r->kept) * r->n, best->distance};
    best->taken = true;
    return true;
}

saltus_status saltus_return_polish(saltus_flow *flow, int periods, const double *guess,
                                   const saltus_orbit_options *options, saltus_orbit *orbit, saltus_lap *lap,
                                   saltus_message *message) {
    const saltus_system *system = saltus_flow_system(flow, 0);
    saltus_status status =
        saltus_orbit_search(system, periods, guess, options, SALTUS_MULTIPLIERS_NONE, orbit, message);
    if (status == SALTUS_OK)
        status = saltus_lap_around(lap, flow, orbit->state, periods, message);
    int least = status == SALTUS_OK ? saltus_lap_least_period(lap, &options->flow) : periods;
    if (least < periods) {
        saltus_orbit longer = *orbit;
        status = saltus_return_polish(flow, least, longer.state, options, orbit, lap, message);
        saltus_orbit_clear(&longer);
        return status;
    }
    if (status == SALTUS_OK)
        status = saltus_orbit_all_multipliers(flow, options, orbit, message);
    if (status != SALTUS_OK)
        saltus_orbit_clear(orbit);
    return status;
}
