/* What a motion without a period is, by its largest exponent.
 *
 * A tangent vector is carried along in runs that are doubled; after each the exponent is weighed as
 * classification does (motion/evidence.h), but from one trajectory. Where chaos has not been watched for long
 * enough to be asserted the row is irregular. A negative exponent means that a period must show: the
 * trajectory is given at most the time that it had to settle once more. An exponent of zero may belong to a
 * torus: then the section points are asked. Chaos that a contact ends which wipes out all differences is
 * superstable: its exponent is -infinity.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "motion/evidence.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    align = 50,        /* periods in which the vector turns into the direction that grows */
    first_run = 250,   /* then doubled */
    least_given = 500, /* where nothing but the exponent is lacking, and this part of what may be measured */
    part_given = 8,
    least_points = 1500, /* that tell a torus, */
    most_points = 4096,  /* and so many at most */
    least_room = 4096,   /* for section points: between these, and within so many numbers */
    most_room = 32768,
    numbers = 1 << 19,
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

/* Section points that are kept. */
static long long room_of(const saltus_sweep_trajectory *t) {
    long long room = numbers / t->measuring.growth.n;
    room = room < most_room ? room : most_room;
    return room > least_room ? room : least_room;
}

/* Room for section points, the first time that they are wanted. */
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

/* A section point, if there is room for it, and beside it how much the vector has grown since the last one,
 * or without forcing when it came. */
static void keep_point(saltus_sweep_trajectory *t, const double *state, double number) {
    saltus_measuring *m = &t->measuring;
    if (m->given || m->samples < 0 || m->count == room_of(t))
        return;
    memcpy(m->points + m->count * m->growth.n, state, (size_t)m->growth.n * sizeof *m->points);
    m->points[room_of(t) * m->growth.n + m->count++] = number;
}

void saltus_sweep_trajectory_take(saltus_sweep_trajectory *t, const saltus_event *event) {
    double state[SALTUS_STATE_MAX];
    memcpy(state, t->state, (size_t)t->sweep->dimension * sizeof *state);
    saltus_visits_take(&t->proof.visits, t->flow, t->lane, event, t->state,
                       saltus_sweep_trajectory_information(t));
    while (saltus_visits_next(&t->proof.visits, t->flow, t->lane, state))
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

/* The verdict, and the exponent as it is known now. */
static saltus_next end(saltus_sweep_trajectory *t, saltus_verdict verdict, const saltus_runs *runs) {
    if (!t->measuring.given)
        saltus_sweep_trajectory_settle(t, verdict, 0);
    t->row.lyapunov = runs->lost ? -INFINITY : runs->all.mean;
    t->row.lyapunov_error = runs->lost ? 0 : runs->all.standard_error;
    if (!t->measuring.given && t->row.lyapunov > SALTUS_SIGNIFICANT * t->row.lyapunov_error)
        t->row.lifetime_at_least = saltus_lifetime_at_least((double)runs->watched, 0);
    return SALTUS_NEXT_DONE;
}

/* A torus is suspected: ask its section points, where there are more of them than last time. */
static saltus_outcome ask_points(saltus_sweep_trajectory *t) {
    saltus_measuring *m = &t->measuring;
    saltus_evidence evidence = {.dimension = NAN}; /* not asked for */
    saltus_outcome outcome = SALTUS_OUTCOME_TORUS;
    if (m->count < least_points || m->count < 2 * m->asked)
        return SALTUS_OUTCOME_OPEN;
    m->asked = m->count;
    long long count = m->count < most_points ? m->count : most_points;
    /* Without forcing the exponent of every orbit is zero: the dimension tells one of a long period. */
    saltus_point_tests tests = saltus_system_forced(t->system) ? SALTUS_TESTS_TORUS : SALTUS_TESTS_ALL;
    saltus_status status = saltus_points_test(t->system, m->points + (m->count - count) * m->growth.n, count,
                                              tests, &evidence, &outcome, NULL);
    t->starved |= status == SALTUS_NO_MEMORY;
    return status == SALTUS_OK ? outcome : SALTUS_OUTCOME_OPEN;
}

/* Whether a stable orbit lies amid the motion, as far as its section points have been kept. */
static bool has_stable_orbit(saltus_sweep_trajectory *t) {
    saltus_measuring *m = &t->measuring;
    const bool forced = saltus_system_forced(t->system);
    const saltus_track track = {m->points, m->points + room_of(t) * m->growth.n,
                                forced || m->count < most_points ? m->count : most_points};
    saltus_motion orbit = {0};
    bool found = false;
    saltus_status status =
        saltus_stable_orbit_among(t->system, &t->sweep->options.flow, &track, 1, &orbit, &found, NULL);
    t->starved |= status == SALTUS_NO_MEMORY;
    saltus_motion_clear(&orbit);
    return found;
}

/* Whether a contact that is met seldom ends the chaos: the trajectory then goes on from there. */
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

/* The next run: as long as all before it, within what may be measured, and beyond for a period that must
 * show. */
static bool run_on(saltus_measuring *m, long long most) {
    if (m->samples < most)
        m->run_end = 2 * m->samples < most ? 2 * m->samples : most;
    return m->samples < most || m->deadline > 0;
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
