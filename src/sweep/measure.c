/* What a motion without a period is, by its largest exponent.
 *
 * A tangent vector is carried along in runs each as long as all before it. After each run the exponent is
 * judged as in classification (motion/evidence.h), but from one trajectory. Apparent chaos that has not been
 * watched for long enough makes the row irregular. A negative exponent means that a period must appear: the
 * trajectory is given at most as long again as it had to settle. An exponent of zero may belong to a torus:
 * then the section points decide. Chaos that ends at a contact which wipes out all differences is a
 * superstable motion: its exponent is -infinity.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "motion/evidence.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    align = 50,          /* periods for the vector to turn into the direction that grows */
    first_run = 250,     /* periods; each later run doubles the total */
    least_given = 500,   /* if only the exponent is lacking: at least these periods, ... */
    part_given = 8,      /* ... and this part of `measure` */
    least_points = 1500, /* needed to identify a torus, */
    most_points = 4096,  /* and the latest of them that are used */
    least_room = 4096,   /* of section points: `numbers` doubles, but between these bounds */
    most_room = 32768,
    numbers = 1 << 19,
    patience = 400,        /* periods in which one must appear at most, in a sweep with fixed times */
    tangent_seed = 1 << 20 /* seeds of random directions: above all seeds of a sweep */
};

static const double nothing_left = 40; /* logarithm of the contraction after which no distance is left */

static long long steps_of(const saltus_sweep_trajectory *t) {
    return saltus_sweep_trajectory_information(t).steps;
}

static long long at_most(const saltus_sweep_trajectory *t) {
    return t->sweep->options.measure;
}

/* Number of section points that are kept. */
static long long room_of(const saltus_sweep_trajectory *t) {
    long long room = numbers / t->measuring.growth.n;
    room = room < most_room ? room : most_room;
    return room > least_room ? room : least_room;
}

/* Allocate the section points when they are first wanted. */
static bool open_track(saltus_sweep_trajectory *t) {
    saltus_measuring *m = &t->measuring;
    size_t room = (size_t)room_of(t);
    if (m->points || m->given)
        return true;
    m->points = malloc(room * ((size_t)m->growth.n + 1) * sizeof *m->points);
    t->starved |= !m->points;
    return m->points;
}

bool saltus_sweep_trajectory_measure(saltus_sweep_trajectory *t, saltus_flow *flow, int lane) {
    saltus_measuring *m = &t->measuring;
    if (!open_track(t) || !saltus_sweep_trajectory_move(t, flow, lane))
        return false;
    t->stage = SALTUS_STAGE_MEASURING;
    t->stage_end = saltus_sweep_trajectory_cycle(t) + align + at_most(t);
    t->active = NULL;
    saltus_sweep_trajectory_begin_settling(t);
    saltus_sweep_trajectory_seed(t, tangent_seed + t->seed);
    saltus_growth_choose(&m->growth, t->system, 0, NULL);
    if (!saltus_system_forced(t->system))
        m->growth.watch |= saltus_crossings_watch(t->system);
    saltus_growth_begin(&m->growth, flow, lane, saltus_random_rng(&t->random));
    saltus_growth_aim(&m->growth, flow, lane);
    memset(&m->average, 0, sizeof m->average);
    m->samples = -align;
    m->run_end = at_most(t) < first_run ? at_most(t) : first_run;
    m->deadline = m->count = m->asked = m->steps = 0;
    return true;
}

/* Keep a section point, if there is room, with the growth since the previous one or, unforced, its time. */
static void keep_point(saltus_sweep_trajectory *t, const double *state, double number) {
    saltus_measuring *m = &t->measuring;
    if (m->given || m->samples < 0 || m->count == room_of(t))
        return;
    memcpy(m->points + m->count * m->growth.n, state, (size_t)m->growth.n * sizeof *m->points);
    m->points[room_of(t) * m->growth.n + m->count++] = number;
}

void saltus_sweep_trajectory_take(saltus_sweep_trajectory *t, const saltus_event *event) {
    const saltus_flow_info done = saltus_sweep_trajectory_information(t);
    double state[SALTUS_STATE_MAX];
    memcpy(state, t->state, (size_t)t->sweep->dimension * sizeof *state);
    saltus_crossings_take(&t->proof.visits.returns, t->flow, t->lane, event, t->state);
    while (saltus_visits_next(&t->proof.visits, t->flow, t->lane, done, state))
        if (t->stage == SALTUS_STAGE_MEASURING)
            keep_point(t, state, saltus_visits_last(&t->proof.visits));
}

saltus_next saltus_measuring_follow(saltus_sweep_trajectory *t, const saltus_event *event, bool *section) {
    if (!saltus_system_forced(t->system)) {
        saltus_flow_state(t->flow, t->lane, t->state);
        saltus_sweep_trajectory_take(t, event);
    }
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
                         .latest = saltus_average_part(&m->average, 0.875, 1).mean,
                         .watched = m->samples,
                         .members = 1,
                         .lifetime = t->sweep->options.lifetime,
                         .lost = m->growth.lost >= m->growth.n};
}

/* End with a verdict and the present estimate of the exponent. */
static saltus_next end(saltus_sweep_trajectory *t, saltus_verdict verdict, const saltus_runs *runs) {
    if (!t->measuring.given)
        saltus_sweep_trajectory_settle(t, verdict, 0);
    t->row.lyapunov = runs->lost ? -INFINITY : runs->all.mean;
    t->row.lyapunov_error = runs->lost ? 0 : runs->all.standard_error;
    if (!t->measuring.given && t->row.lyapunov > SALTUS_SIGNIFICANT * t->row.lyapunov_error)
        t->row.lifetime_at_least = saltus_lifetime_at_least((double)runs->watched, 0);
    return SALTUS_NEXT_DONE;
}

/* A torus is suspected: test the section points, if there are twice as many as at the last test. */
static saltus_outcome ask_points(saltus_sweep_trajectory *t) {
    saltus_measuring *m = &t->measuring;
    saltus_evidence evidence = {.dimension = NAN}; /* not computed for a forced system */
    saltus_outcome outcome = SALTUS_OUTCOME_TORUS;
    if (m->count < least_points || m->count < 2 * m->asked)
        return SALTUS_OUTCOME_OPEN;
    m->asked = m->count;
    long long count = m->count < most_points ? m->count : most_points;
    /* Without forcing the largest exponent of any stable orbit is zero: the dimension exposes it. */
    saltus_point_tests tests = saltus_system_forced(t->system) ? SALTUS_TESTS_TORUS : SALTUS_TESTS_ALL;
    saltus_status status = saltus_points_test(t->system, m->points + (m->count - count) * m->growth.n, count,
                                              tests, &evidence, &outcome, NULL);
    t->starved |= status == SALTUS_NO_MEMORY;
    return status == SALTUS_OK ? outcome : SALTUS_OUTCOME_OPEN;
}

/* Whether a stable orbit lies amid the section points kept. */
static bool has_stable_orbit(saltus_sweep_trajectory *t) {
    saltus_measuring *m = &t->measuring;
    const bool forced = saltus_system_forced(t->system);
    const saltus_track track = {m->points, m->points + room_of(t) * m->growth.n,
                                forced || m->count < most_points ? m->count : most_points};
    saltus_motion orbit = {0};
    saltus_status status =
        saltus_stable_orbit_among(t->system, &t->sweep->options.flow, &track, 1, &orbit, NULL);
    const bool found = saltus_verdict_settled(orbit.verdict);
    t->starved |= status == SALTUS_NO_MEMORY;
    saltus_motion_clear(&orbit);
    return found;
}

/* Whether a rare contact that wipes out all differences ends the chaos; if so, continue from there. */
static bool meets_contact(saltus_sweep_trajectory *t) {
    saltus_measuring *m = &t->measuring;
    enum { trajectories = 8 };
    const double *states[trajectories];
    double after[SALTUS_STATE_MAX];
    bool found = false;
    if (m->count < trajectories)
        return false;
    for (int k = 0; k < trajectories; k++)
        states[k] = m->points + ((k + 1) * m->count / trajectories - 1) * m->growth.n;
    saltus_status status = saltus_motion_meets_contact(t->system, &t->sweep->options.flow, states,
                                                       trajectories, m->samples, after, &found, NULL);
    t->starved |= status == SALTUS_NO_MEMORY;
    if (status != SALTUS_OK || !found || !saltus_sweep_trajectory_continue(t, after))
        return false;
    m->growth.lost = m->growth.n;
    return true;
}

/* Plan the next run, as long as all before it, within what may be measured; beyond that only while a period
 * must appear. False if there is none. */
static bool run_on(saltus_measuring *m, long long most) {
    if (m->samples < most)
        m->run_end = 2 * m->samples < most ? 2 * m->samples : most;
    return m->samples < most || m->deadline > 0;
}

/* Periods in which a period must appear: as many as, with those measured, contract any distance to nothing,
 * and some more to see it. */
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
    bool long_enough = m->samples >= least_given && m->samples >= at_most(t) / part_given;
    if (m->given && (outcome == SALTUS_OUTCOME_REGULAR || long_enough))
        return end(t, t->row.verdict, &runs);
    if (outcome == SALTUS_OUTCOME_TORUS)
        outcome = ask_points(t);
    if (outcome == SALTUS_OUTCOME_CHAOS) {
        const bool stable = has_stable_orbit(t), chaotic = !stable && !meets_contact(t);
        /* A search that was interrupted has found nothing: there is no verdict, and the row is dropped. */
        if (saltus_stop_asked(t->sweep->options.flow.stop))
            return SALTUS_NEXT_GO_ON;
        if (stable || chaotic)
            return end(t, stable ? SALTUS_TRANSIENT : SALTUS_CHAOTIC, &runs);
        outcome = SALTUS_OUTCOME_REGULAR;
    }
    if (outcome == SALTUS_OUTCOME_TORUS)
        return end(t, SALTUS_QUASIPERIODIC, &runs);
    if (outcome != SALTUS_OUTCOME_REGULAR)
        m->deadline = 0;
    else if (!m->deadline)
        m->deadline = t->stage_end = saltus_sweep_trajectory_cycle(t) + longest_wait(t, &runs);
    if (run_on(m, at_most(t)))
        return SALTUS_NEXT_GO_ON;
    return end(t, outcome == SALTUS_OUTCOME_SHORT ? SALTUS_IRREGULAR : SALTUS_UNDECIDED, &runs);
}

saltus_next saltus_measuring_add(saltus_sweep_trajectory *t) {
    saltus_measuring *m = &t->measuring;
    if (m->samples++ < 0) {
        m->steps = steps_of(t);
        return SALTUS_NEXT_GO_ON;
    }
    saltus_average_add(&m->average, m->growth.sample[0]);
    if (saltus_system_forced(t->system))
        keep_point(t, t->state, m->growth.sample[0]);
    if (m->deadline && saltus_sweep_trajectory_cycle(t) >= m->deadline) {
        saltus_runs runs = runs_of(t);
        return end(t, SALTUS_LONG_PERIOD, &runs);
    }
    return m->samples == m->run_end ? weigh(t) : SALTUS_NEXT_GO_ON;
}
