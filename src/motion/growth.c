/* How tangent vectors grow along a trajectory (Benettin, Galgani, Giorgilli & Strelcyn, Meccanica 15 (1980)
 * 9-30).
 *
 * The flow carries the vectors through impacts, chatter, sticking and release. Between two
 * orthonormalisations the fastest growing vector must not swamp the others: the interval is halved if the
 * growths differ too much, and doubled, up to a period, if they stay close together. A lasting contact wipes
 * out two directions for each face for good: the last exponents are then -infinity, and what the
 * factorisation finds there is rounding.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/growth.h"

#include "base/bits.h"
#include "base/dense.h"
#include "orbit/multipliers.h"

#include <float.h>
#include <gsl/gsl_randist.h>
#include <math.h>
#include <string.h>

enum { calm_samples = 8, most_parts = 1 << 20 };
/* Logarithms of growths. A single vector may grow up to the range of floating-point numbers. */
static const double too_wide = 16, narrow = 5, too_long = 300;

void saltus_growth_reserve(saltus_growth *g, saltus_arena *arena, int n, int columns) {
    size_t count = (size_t)columns;
    g->n = n;
    g->columns = columns;
    g->vectors = saltus_arena_doubles(arena, (size_t)n * count);
    g->length = saltus_arena_doubles(arena, count);
    g->work = saltus_arena_doubles(arena, (size_t)saltus_dense_orthonormal_work(columns));
    g->sample = saltus_arena_doubles(arena, count);
    g->open.logarithms = saltus_arena_doubles(arena, count);
}

void saltus_growth_choose(saltus_growth *g, const saltus_system *system, double interval,
                          const gsl_integration_glfixed_table *table) {
    double decay = saltus_system_fastest_decay(system) * saltus_system_period(system);
    g->fixed = interval > 0;
    g->whole = g->parts = 1;
    g->table = g->columns == g->n ? table : NULL;
    if (interval > 1)
        g->whole = (int)interval;
    else if (interval > 0)
        g->parts = (int)(1 / interval + 0.5);
    else /* no vector may underflow before its growth has been measured */
        g->parts = (int)fmin(fmax(1, ceil(decay / (g->columns == g->n ? too_wide : too_long))), most_parts);
    g->watch = g->table ? SALTUS_WATCH_STEP | SALTUS_WATCH_CONTACT : SALTUS_WATCH_STICK;
    for (int f = 0; f < saltus_system_face_count(system); f++)
        if (saltus_system_face(system, f).r == 0)
            g->watch |= SALTUS_WATCH_IMPACT;
}

static void open_sample(saltus_growth *g, long long cycle) {
    g->open = (saltus_growth_sample){.begin = cycle, .logarithms = g->open.logarithms};
    memset(g->open.logarithms, 0, (size_t)g->columns * sizeof *g->open.logarithms);
}

/* Hand the vectors to the flow, in unscaled units. */
static void hand_over(saltus_growth *g, saltus_flow *flow, int lane) {
    const double *scale = saltus_system_scale(saltus_flow_system(flow, lane));
    for (int c = 0; c < g->columns; c++)
        for (int i = 0; i < g->n; i++)
            g->vectors[c * g->n + i] *= scale[i];
    saltus_flow_set_tangents(flow, lane, g->vectors);
}

void saltus_growth_begin(saltus_growth *g, saltus_flow *flow, int lane, gsl_rng *rng) {
    for (int k = 0; k < g->n * g->columns; k++)
        g->vectors[k] = gsl_ran_ugaussian(rng);
    saltus_dense_orthonormal(g->vectors, g->n, g->columns, g->length, g->work);
    hand_over(g, flow, lane);
    g->calm = 0;
    g->steps = saltus_flow_information(flow, lane).steps;
    g->lost = 2 * saltus_count_bits(saltus_flow_contacts(flow, lane));
    open_sample(g, saltus_flow_time(flow, lane).cycle);
}

void saltus_growth_aim(const saltus_growth *g, saltus_flow *flow, int lane) {
    int part = g->open.part + 1;
    saltus_time within = {g->open.begin, (double)part / g->parts}, end = {g->open.begin + g->whole, 0};
    saltus_flow_aim(flow, lane, part < g->parts ? within : end, g->watch);
}

/* Measure the vectors' growth and orthonormalise them. False if they are not finite. */
static bool orthonormalise(saltus_growth *g, saltus_flow *flow, int lane) {
    const double *scale = saltus_system_scale(saltus_flow_system(flow, lane));
    double most = -INFINITY, least = INFINITY;
    saltus_flow_tangents(flow, lane, g->vectors);
    for (int c = 0; c < g->columns; c++)
        for (int i = 0; i < g->n; i++)
            g->vectors[c * g->n + i] /= scale[i];
    if (!saltus_dense_orthonormal(g->vectors, g->n, g->columns, g->length, g->work))
        return false;
    for (int c = 0; c < g->columns; c++) {
        double growth = log(fmax(g->length[c], DBL_MIN));
        g->open.logarithms[c] += growth;
        if (c < g->n - g->lost && g->length[c] > DBL_MIN) {
            most = fmax(most, growth);
            least = fmin(least, growth);
        }
    }
    if (most >= least)
        g->open.widest = fmax(g->open.widest, g->columns > 1 ? most - least : fabs(most));
    /* A single vector that has shrunk to nothing is replaced by an arbitrary one. */
    if (g->columns == 1 && g->length[0] < DBL_MIN)
        for (int i = 0; i < g->n; i++)
            g->vectors[i] = 1 / sqrt(g->n);
    hand_over(g, flow, lane);
    return true;
}

saltus_status saltus_growth_follow(saltus_growth *g, saltus_flow *flow, int lane, const saltus_event *event,
                                   bool *complete, saltus_message *message) {
    *complete = false;
    if (g->table)
        g->open.trace += saltus_trace_over_step(flow, lane, g->table, &g->steps);
    if (event->kind == SALTUS_STICK || event->kind == SALTUS_IMPACT) {
        int lost = saltus_lost_directions(flow, lane, event);
        g->lost = lost > g->lost ? lost : g->lost;
    }
    if (event->kind != SALTUS_REACHED)
        return SALTUS_OK;
    if (!orthonormalise(g, flow, lane))
        return saltus_fail(message, SALTUS_STALLED,
                           "the tangent vectors grow beyond numbers within %g periods; re-orthonormalise at "
                           "shorter intervals",
                           (double)g->whole / g->parts);
    *complete = ++g->open.part == g->parts;
    if (*complete) {
        memcpy(g->sample, g->open.logarithms, (size_t)g->columns * sizeof *g->sample);
        g->trace = g->open.trace;
        /* Shorten the interval if the growths differ too much, lengthen it if they have not for a while. */
        const double widest = g->open.widest;
        g->calm = widest < narrow && !g->fixed ? g->calm + 1 : 0;
        if (!g->fixed && widest > (g->columns > 1 ? 1.5 * too_wide : too_long) && g->parts < most_parts)
            g->parts *= 2;
        else if (g->calm >= calm_samples && g->parts > 1) {
            g->parts = (g->parts + 1) / 2;
            g->calm = 0;
        }
        open_sample(g, saltus_flow_time(flow, lane).cycle);
    }
    return SALTUS_OK;
}

saltus_estimate saltus_growth_exponent(saltus_estimate growth, double steps, double tolerance,
                                       double length) {
    double error = steps * fmax(tolerance, 1e-15);
    growth.standard_error = hypot(growth.standard_error, error) / length;
    growth.mean /= length;
    return growth;
}
