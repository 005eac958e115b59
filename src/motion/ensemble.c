/* Several trajectories on one attractor measure its exponents together, in the lanes of a flow. They start
 * from one trajectory at times so far apart that none repeats what another has measured before it has
 * diverged.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/ensemble.h"

#include "motion/motion.h"
#include "orbit/volume.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    align_samples = 50,  /* for random directions to turn into those that grow */
    most_aligned = 1000, /* for neighbouring trajectories to become strangers */
    look_cycles = 64
};
static const double disturbance = 1e-6, strangers = 17; /* e^17 of it is more than the attractor */
/* Members whose scatter is less likely than this do not measure the same thing. */
static const double unlikely = 1e-4;
static const double bounds_apart = 6; /* the errors of regular motions are bounds, more or less */

static void reserve(saltus_ensemble *e) {
    e->initial = saltus_arena_doubles(&e->arena, (size_t)e->n);
    for (int m = 0; m < e->members; m++) {
        saltus_growth_reserve(&e->member[m].growth, &e->arena, e->n, e->columns);
        e->member[m].state = saltus_arena_doubles(&e->arena, (size_t)e->n);
    }
}

static saltus_status open_flows(saltus_ensemble *e, saltus_message *message) {
    const saltus_system *systems[64];
    saltus_flow_options flow = e->options->flow;
    saltus_status status = SALTUS_OK;
    flow.columns = e->columns;
    flow.directions = 0;
    for (int f = 0; f < e->flow_count && status == SALTUS_OK; f++) {
        int lanes = e->members - f * e->width < e->width ? e->members - f * e->width : e->width;
        for (int l = 0; l < lanes; l++)
            systems[l] = e->system;
        status = saltus_flow_new(systems, lanes, &flow, &e->flows[f], message);
    }
    return status;
}

static bool open_memory(saltus_ensemble *e) {
    size_t members = (size_t)e->members;
    e->flows = calloc((size_t)e->flow_count, sizeof(saltus_flow *));
    e->member = calloc(members, sizeof *e->member);
    e->averages = calloc(members * (size_t)(e->columns + 1), sizeof *e->averages);
    e->table = gsl_integration_glfixed_table_alloc(SALTUS_TRACE_POINTS);
    e->rng = gsl_rng_alloc(gsl_rng_mt19937);
    if (!e->flows || !e->member || !e->averages || !e->table || !e->rng)
        return false;
    reserve(e);
    if (!saltus_arena_open(&e->arena))
        return false;
    reserve(e);
    for (int m = 0; m < e->members; m++)
        e->member[m].averages = e->averages + (size_t)m * (size_t)(e->columns + 1);
    return true;
}

saltus_status saltus_ensemble_open(saltus_ensemble *e, const saltus_system *system,
                                   const saltus_lyapunov_options *options, saltus_message *message) {
    *e = (saltus_ensemble){.system = system,
                           .options = options,
                           .n = saltus_system_dimension(system),
                           .members = options->members,
                           .width = options->flow.integrator == SALTUS_RADAU ? 1 : saltus_flow_width(system)};
    e->columns = options->exponents ? options->exponents : e->n;
    e->flow_count = (e->members + e->width - 1) / e->width;
    if (!open_memory(e)) {
        saltus_ensemble_close(e);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the exponents of %d trajectories",
                           options->members);
    }
    gsl_rng_set(e->rng, options->seed);
    saltus_status status = open_flows(e, message);
    for (int m = 0; m < e->members; m++)
        saltus_growth_choose(&e->member[m].growth, system, options->interval, e->table);
    if (status != SALTUS_OK)
        saltus_ensemble_close(e);
    return status;
}

void saltus_ensemble_close(saltus_ensemble *e) {
    for (int f = 0; f < e->flow_count && e->flows; f++)
        saltus_flow_free(e->flows[f]);
    free(e->flows);
    free(e->member);
    free(e->averages);
    if (e->table)
        gsl_integration_glfixed_table_free(e->table);
    if (e->rng)
        gsl_rng_free(e->rng);
    saltus_arena_close(&e->arena);
    *e = (saltus_ensemble){0};
}

/* Follow one trajectory to a cycle and look where it is. */
static saltus_status follow(saltus_ensemble *e, saltus_flow *flow, long long cycle, double *state,
                            saltus_message *message) {
    saltus_event event;
    saltus_status status = SALTUS_OK;
    while (status == SALTUS_OK && saltus_flow_time(flow, 0).cycle < cycle && !e->stopped) {
        if (saltus_flow_time(flow, 0).cycle % look_cycles == 0)
            e->stopped =
                e->options->progress && !e->options->progress(e->options->context, 0, e->options->periods);
        status = saltus_flow_advance(flow, (saltus_time){saltus_flow_time(flow, 0).cycle + 1, 0}, 0, &event,
                                     message);
        saltus_flow_state(flow, 0, state);
        if (status == SALTUS_OK)
            status = saltus_state_bounded(e->system, state, saltus_flow_time(flow, 0).cycle, message);
    }
    saltus_flow_state(flow, 0, state);
    return status;
}

/* The last member, at the end of the transient, becomes the first. */
static saltus_status run_transient(saltus_ensemble *e, saltus_message *message) {
    saltus_flow *flow = NULL;
    e->transient = e->options->transient;
    saltus_status status = saltus_flow_single(e->system, 0, &e->options->flow, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, e->initial, message);
    for (int m = e->members - 1; m >= 0 && status == SALTUS_OK; m--) {
        long long spread = e->transient / 2, place = e->transient - spread * m / e->members;
        status = follow(e, flow, place, e->member[m].state, message);
    }
    /* What was cut off is not told as done. */
    if (status == SALTUS_OK && e->stopped)
        e->transient = saltus_flow_time(flow, 0).cycle;
    saltus_flow_free(flow);
    return status;
}

/* Until the directions are aligned; and, where neighbours separate, until the members have nothing in common
 * with the trajectory that they come from, which each would else retrace. */
static saltus_status align(saltus_ensemble *e, saltus_message *message) {
    double least = 0;
    saltus_status status = SALTUS_OK;
    for (int m = 0; m < e->members; m++)
        e->member[m].grown = 0;
    do {
        least = INFINITY;
        status = saltus_ensemble_run(e, align_samples / e->member[0].growth.whole + 1, message);
        for (int m = 0; m < e->members; m++)
            least = fmin(least, e->member[m].grown += e->member[m].recent);
    } while (status == SALTUS_OK && e->members > 1 && least > 1 && least < strangers &&
             e->member[0].samples < most_aligned);
    return status;
}

saltus_status saltus_ensemble_place(saltus_ensemble *e, const double *state, saltus_message *message) {
    memcpy(e->initial, state, (size_t)e->n * sizeof *state);
    if (e->options->seed)
        saltus_state_disturb(e->system, e->rng, disturbance, 0, e->initial);
    saltus_status status = run_transient(e, message);
    for (int m = 0; m < e->members && status == SALTUS_OK; m++) {
        saltus_flow *flow = e->flows[m / e->width];
        if (m > 0)
            saltus_state_disturb(e->system, e->rng, disturbance, 0, e->member[m].state);
        status = saltus_flow_start(flow, m % e->width, (saltus_time){0, 0}, e->member[m].state, message);
        if (status == SALTUS_OK)
            saltus_growth_begin(&e->member[m].growth, flow, m % e->width, e->rng);
    }
    if (status == SALTUS_OK)
        status = align(e, message);
    saltus_ensemble_forget(e);
    return status;
}

/* A sample is complete. */
static saltus_status take_sample(saltus_ensemble *e, int m, saltus_message *message) {
    saltus_member *self = &e->member[m];
    saltus_flow *flow = e->flows[m / e->width];
    for (int c = 0; c < e->columns; c++)
        saltus_average_add(&self->averages[c], self->growth.sample[c]);
    double volume = saltus_flow_information(flow, m % e->width).log_volume;
    saltus_average_add(&self->averages[e->columns], self->growth.trace + volume - self->volume);
    self->volume = volume;
    self->recent += self->growth.sample[0];
    self->samples++;
    saltus_flow_state(flow, m % e->width, self->state);
    if (m == 0 && e->points && self->samples <= e->room)
        memcpy(e->points + (self->samples - 1) * e->n, self->state, (size_t)e->n * sizeof *self->state);
    return saltus_state_bounded(e->system, self->state, saltus_flow_time(flow, m % e->width).cycle, message);
}

/* All lanes of one flow to their goals. */
static saltus_status run_lanes(saltus_ensemble *e, int f, saltus_message *message) {
    saltus_flow *flow = e->flows[f];
    int first = f * e->width, left = 0;
    for (int m = first; m < e->members && m < first + e->width; m++, left++)
        saltus_growth_aim(&e->member[m].growth, flow, m - first);
    while (left > 0) {
        saltus_event event;
        int lane;
        bool complete;
        saltus_status status = saltus_flow_run(flow, &lane, &event, message);
        saltus_member *self = &e->member[first + lane];
        if (status == SALTUS_OK)
            status = saltus_growth_follow(&self->growth, flow, lane, &event, &complete, message);
        if (status == SALTUS_OK && complete)
            status = take_sample(e, first + lane, message);
        if (status != SALTUS_OK)
            return status;
        if (complete && self->samples >= self->goal)
            left--;
        else
            saltus_growth_aim(&self->growth, flow, lane);
    }
    return SALTUS_OK;
}

saltus_status saltus_ensemble_run(saltus_ensemble *e, long long samples, saltus_message *message) {
    saltus_status status = SALTUS_OK;
    for (int m = 0; m < e->members; m++) {
        e->member[m].goal = e->member[m].samples + samples;
        e->member[m].recent = 0;
    }
    for (int f = 0; f < e->flow_count && status == SALTUS_OK; f++)
        status = run_lanes(e, f, message);
    return status;
}

void saltus_ensemble_forget(saltus_ensemble *e) {
    e->transient += e->member[0].samples * e->member[0].growth.whole;
    for (int m = 0; m < e->members; m++) {
        saltus_member *self = &e->member[m];
        memset(self->averages, 0, (size_t)(e->columns + 1) * sizeof *self->averages);
        self->samples = 0;
        self->begin = saltus_flow_information(e->flows[m / e->width], m % e->width);
        self->volume = self->begin.log_volume;
    }
}

long long saltus_ensemble_samples(const saltus_ensemble *e) {
    return e->member[0].samples;
}

long long saltus_ensemble_periods(const saltus_ensemble *e) {
    return e->member[0].samples * e->member[0].growth.whole * e->members;
}

int saltus_ensemble_lost(const saltus_ensemble *e) {
    int lost = 0;
    for (int m = 0; m < e->members; m++)
        lost = e->member[m].growth.lost > lost ? e->member[m].growth.lost : lost;
    return lost < e->n ? lost : e->n;
}

/* Each step of the flow leaves an error of its tolerance in a vector's length. */
static double flow_error(const saltus_ensemble *e, int m) {
    const saltus_member *self = &e->member[m];
    saltus_flow_info now = saltus_flow_information(e->flows[m / e->width], m % e->width);
    double steps = (double)(now.steps - self->begin.steps) / (double)self->samples;
    return steps * fmax(e->options->flow.rtol, 1e-15);
}

static saltus_estimate per_time(const saltus_ensemble *e, int m, saltus_estimate estimate) {
    double length = e->member[m].growth.whole * saltus_system_period(e->system);
    estimate.standard_error = hypot(estimate.standard_error, flow_error(e, m)) / length;
    estimate.mean /= length;
    return estimate;
}

bool saltus_ensemble_regular(const saltus_ensemble *e) {
    for (int m = 0; m < e->members; m++)
        if (!saltus_average_estimate(&e->member[m].averages[0]).weighted)
            return false;
    return true;
}

/* Directions of the members are random and independent: an error that all of them share in size shows in
 * their scatter. */
static double scatter(const saltus_estimate *each, int count, double mean) {
    double square = 0;
    for (int k = 0; k < count; k++)
        square += (each[k].mean - mean) * (each[k].mean - mean);
    return count > 1 ? sqrt(square / (count - 1) / count) : 0;
}

saltus_estimate saltus_ensemble_exponent(const saltus_ensemble *e, int column, bool weighted) {
    saltus_estimate each[64] = {{0}};
    for (int m = 0; m < e->members; m++) {
        const saltus_average *average = &e->member[m].averages[column];
        each[m] = per_time(e, m, weighted ? saltus_average_weighted(average) : saltus_average_plain(average));
    }
    saltus_estimate joint = saltus_estimates_join(each, e->members);
    if (weighted)
        joint.standard_error = fmax(joint.standard_error, scatter(each, e->members, joint.mean));
    return joint;
}

saltus_estimate saltus_ensemble_member(const saltus_ensemble *e, int member) {
    const saltus_average *average = &e->member[member].averages[0];
    return per_time(e, member,
                    saltus_ensemble_regular(e) ? saltus_average_weighted(average)
                                               : saltus_average_plain(average));
}

saltus_estimate saltus_ensemble_half(const saltus_ensemble *e, int column, int half) {
    saltus_estimate each[64] = {{0}};
    for (int m = 0; m < e->members; m++)
        each[m] =
            per_time(e, m, saltus_average_part(&e->member[m].averages[column], 0.5 * half, 0.5 * half + 0.5));
    return saltus_estimates_join(each, e->members);
}

bool saltus_ensemble_agrees(const saltus_ensemble *e) {
    bool regular = saltus_ensemble_regular(e);
    double mean = saltus_ensemble_exponent(e, 0, false).mean, square = 0, farthest = 0;
    for (int m = 0; m < e->members && e->members > 1; m++) {
        saltus_estimate one = per_time(e, m, saltus_average_plain(&e->member[m].averages[0]));
        double apart = fabs(one.mean - mean) / one.standard_error;
        square += apart * apart;
        farthest = fmax(farthest, apart);
    }
    if (e->members == 1)
        return true;
    return regular ? farthest < bounds_apart : !(gsl_cdf_chisq_Q(square, e->members - 1) < unlikely);
}

double saltus_ensemble_spread(const saltus_ensemble *e) {
    double mean = saltus_ensemble_exponent(e, 0, saltus_ensemble_regular(e)).mean, farthest = 0;
    for (int m = 0; m < e->members; m++)
        farthest = fmax(farthest, fabs(saltus_ensemble_member(e, m).mean - mean));
    return farthest;
}

const double *saltus_ensemble_state(const saltus_ensemble *e, int member) {
    return e->member[member].state;
}
