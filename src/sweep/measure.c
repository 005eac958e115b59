/* What a motion without a period is, by its largest exponent.
 *
 * A tangent vector is carried along in runs that are doubled; after each the exponent is weighed as
 * classification does (motion/evidence.h), but from one trajectory and from fewer periods. Chaos is asserted
 * from an eighth of the periods that may be measured, and where both halves of them tell it. A negative
 * exponent means that a period must show: the trajectory is given at most the time that it had to settle once
 * more.
 * An exponent of zero may belong to a torus: then its section points are collected and asked.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "motion/evidence.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    align = 50,      /* periods in which the vector turns into the direction that grows */
    first_run = 250, /* then doubled */
    least_chaos = 500,
    assertion = 8, /* chaos is asserted from this part of the periods that may be measured, */
    least_points = 1500,
    most_points = 4096,
    patience = 400,        /* for a period that must show, where times are fixed */
    tangent_seed = 1 << 20 /* of random numbers: no seed of a sweep is as large */
};

static const double nothing_left = 40; /* logarithm of a contraction */

static long long steps_of(const saltus_sweep_trajectory *t) {
    return saltus_sweep_trajectory_information(t).steps;
}

static long long at_most(const saltus_sweep_trajectory *t) {
    return t->sweep->options.measure;
}

bool saltus_sweep_trajectory_measure(saltus_sweep_trajectory *t, saltus_flow *flow, int lane) {
    saltus_measuring *m = &t->measuring;
    if (!saltus_sweep_trajectory_move(t, flow, lane))
        return false;
    t->stage = SALTUS_STAGE_MEASURING;
    t->stage_end = saltus_sweep_trajectory_cycle(t) + align + at_most(t);
    t->active = NULL;
    saltus_sweep_trajectory_begin_settling(t);
    saltus_sweep_trajectory_seed(t, tangent_seed + t->seed);
    saltus_growth_choose(&m->growth, t->system, 0, NULL);
    saltus_growth_begin(&m->growth, flow, lane, t->rng);
    saltus_growth_aim(&m->growth, flow, lane);
    memset(&m->average, 0, sizeof m->average);
    m->samples = -align;
    m->run_end = at_most(t) < first_run ? at_most(t) : first_run;
    m->deadline = m->count = m->asked = m->steps = 0;
    m->suspected = false;
    return true;
}

saltus_next saltus_measuring_follow(saltus_sweep_trajectory *t, const saltus_event *event, bool *section) {
    saltus_status status = saltus_growth_follow(&t->measuring.growth, t->flow, t->lane, event, section, NULL);
    return status == SALTUS_OK ? SALTUS_NEXT_GO_ON : SALTUS_NEXT_DONE;
}

static saltus_estimate per_time(const saltus_sweep_trajectory *t, saltus_estimate estimate) {
    const saltus_measuring *m = &t->measuring;
    double steps = (double)(steps_of(t) - m->steps) / (double)m->samples;
    return saltus_growth_exponent(estimate, steps, t->sweep->options.flow.rtol,
                                  saltus_system_period(t->system));
}

static saltus_runs runs_of(const saltus_sweep_trajectory *t) {
    const saltus_measuring *m = &t->measuring;
    return (saltus_runs){.all = per_time(t, saltus_average_estimate(&m->average)),
                         .first = per_time(t, saltus_average_part(&m->average, 0, 0.5)),
                         .second = per_time(t, saltus_average_part(&m->average, 0.5, 1)),
                         .period = saltus_system_period(t->system),
                         .enough = m->samples >= least_chaos && m->samples >= at_most(t) / assertion,
                         .lost = m->growth.lost >= m->growth.n};
}

/* The verdict, and the exponent as it is known now. */
static saltus_next end(saltus_sweep_trajectory *t, saltus_verdict verdict, const saltus_runs *runs) {
    if (!t->measuring.given)
        saltus_sweep_trajectory_settle(t, verdict, 0);
    t->row.lyapunov = runs->lost ? -INFINITY : runs->all.mean;
    t->row.lyapunov_error = runs->lost ? 0 : runs->all.standard_error;
    return SALTUS_NEXT_DONE;
}

/* A torus is suspected: ask its section points, or collect some first. */
static saltus_outcome ask_points(saltus_sweep_trajectory *t, const saltus_runs *runs) {
    saltus_measuring *m = &t->measuring;
    saltus_evidence evidence = {.dimension = NAN}; /* not asked for */
    if (!m->points)
        m->points = malloc((size_t)most_points * (size_t)m->growth.n * sizeof *m->points);
    t->starved |= !m->points;
    m->suspected = m->points != NULL;
    if (!m->suspected || m->count < least_points || m->count < 2 * m->asked)
        return SALTUS_OUTCOME_OPEN;
    m->asked = m->count;
    saltus_outcome outcome = SALTUS_OUTCOME_TORUS;
    saltus_status status = saltus_runs_ask_points(runs, t->system, m->points, m->count, SALTUS_OPINIONS_TORUS,
                                                  &evidence, &outcome, NULL);
    t->starved |= status == SALTUS_NO_MEMORY;
    return status == SALTUS_OK ? outcome : SALTUS_OUTCOME_OPEN;
}

/* The next run: as long as all before it; at the end of what may be measured, until points that have been
 * missed so far are there. */
static bool run_on(saltus_measuring *m, long long most) {
    if (m->samples < most)
        m->run_end = 2 * m->samples < most ? 2 * m->samples : most;
    else if (m->suspected && m->count < least_points)
        m->run_end = m->samples + least_points - m->count;
    else
        return m->deadline > 0;
    return true;
}

/* Periods in which a period must show: together with those measured, so many as contract any distance to
 * nothing, and some more to look at them. */
static long long longest_wait(const saltus_sweep_trajectory *t, const saltus_runs *runs) {
    const saltus_sweep_options *o = &t->sweep->options;
    long long most = o->adaptive ? o->transient : patience;
    double all = nothing_left / fmax(-runs->all.mean * runs->period, DBL_MIN),
           more = fmax(all - (double)t->measuring.samples, 0) + 8.0 * o->longest;
    return more < (double)most ? (long long)more : most;
}

static saltus_next weigh(saltus_sweep_trajectory *t) {
    saltus_measuring *m = &t->measuring;
    saltus_runs runs = runs_of(t);
    saltus_outcome outcome = saltus_runs_weigh(&runs);
    bool forced = saltus_system_forced(t->system), zero = outcome == SALTUS_OUTCOME_TORUS;
    if (m->given && (outcome == SALTUS_OUTCOME_REGULAR || runs.enough))
        return end(t, t->row.verdict, &runs);
    if (zero && !forced && runs.enough)
        return end(t, SALTUS_UNDECIDED, &runs);
    if (zero)
        outcome = forced ? ask_points(t, &runs) : SALTUS_OUTCOME_OPEN;
    if (outcome == SALTUS_OUTCOME_CHAOS)
        return end(t, SALTUS_CHAOTIC, &runs);
    if (outcome == SALTUS_OUTCOME_TORUS)
        return end(t, SALTUS_QUASIPERIODIC, &runs);
    if (outcome != SALTUS_OUTCOME_REGULAR)
        m->deadline = 0;
    else if (!m->deadline)
        m->deadline = t->stage_end = saltus_sweep_trajectory_cycle(t) + longest_wait(t, &runs);
    return run_on(m, at_most(t)) ? SALTUS_NEXT_GO_ON : end(t, SALTUS_UNDECIDED, &runs);
}

saltus_next saltus_measuring_add(saltus_sweep_trajectory *t) {
    saltus_measuring *m = &t->measuring;
    if (m->samples++ < 0) {
        m->steps = steps_of(t);
        return SALTUS_NEXT_GO_ON;
    }
    saltus_average_add(&m->average, m->growth.sample[0]);
    if (m->suspected && m->count < most_points)
        memcpy(m->points + m->count++ * m->growth.n, t->state, (size_t)m->growth.n * sizeof *m->points);
    if (m->deadline && saltus_sweep_trajectory_cycle(t) >= m->deadline) {
        saltus_runs runs = runs_of(t);
        return end(t, SALTUS_LONG_PERIOD, &runs);
    }
    return m->samples == m->run_end ? weigh(t) : SALTUS_NEXT_GO_ON;
}
