/* Whether a trajectory of a sweep has settled, and on what.
 *
 * On the way, once it is near its orbit, the trajectory is disturbed by a small random vector. Only a stable
 * orbit draws it back to where it was: not an unstable one, nor one of a continuum. Where iteration cannot
 * tell the period, or the way back is slow, Newton's method and the multipliers decide, from the point that
 * has been reached.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <gsl/gsl_randist.h>
#include <math.h>
#include <string.h>

enum {
    look_periods = 32,        /* between two looks at how the recurrences shrink */
    patience_periods = 200,   /* until Newton's method is asked, ... */
    patience_per_period = 20, /* ... and for each period of what recurs */
    polish_periods = 320,     /* that classification may run */
    polish_impacts = 100      /* an orbit of more of them is left to iteration */
};
static const double approach = 1e-6;    /* distance left to the orbit when it is disturbed, ... */
static const double disturbance = 1e-5; /* ... by this, relative to the system's scales, ... */
static const double home_again = 3e-6;  /* ... and to which it must come back */
static const double same_orbit = 1e-3;  /* an orbit of Newton's method this near is the trajectory's own */
static const double shrinking = 0.98;   /* of recurrences from one look to the next, at most */

static const saltus_judgement goes_on = {SALTUS_PENDING, 0, 0};
static const saltus_judgement failed = {SALTUS_FAILED, 0, 0};

static bool is_last(const saltus_trajectory *t) {
    return saltus_trajectory_cycle(t) >= t->stage_end;
}

void saltus_trajectory_begin_settling(saltus_trajectory *t) {
    t->waited = t->ask_again = 0;
    t->recurring = 0;
    t->patience = patience_periods;
}

/* Along a held face the disturbance must not move. */
static void keep_to_contacts(const saltus_trajectory *t, double *vector) {
    unsigned contacts = saltus_flow_contacts(t->flow, t->lane);
    int dof = saltus_system_dof(t->system);
    for (int f = 0; f < saltus_system_face_count(t->system); f++) {
        const double *normal = saltus_system_stop_normal(t->system, saltus_system_face(t->system, f).stop);
        for (int half = 0; contacts >> f & 1 && half < 2; half++) {
            double along = 0, square = 0, *part = vector + half * dof;
            for (int i = 0; i < dof; i++) {
                along += normal[i] * part[i];
                square += normal[i] * normal[i];
            }
            for (int i = 0; i < dof; i++)
                part[i] -= along / square * normal[i];
        }
    }
}

static bool disturb(saltus_trajectory *t) {
    double moved[SALTUS_STATE_MAX], vector[SALTUS_STATE_MAX];
    const double *scale = saltus_system_scale(t->system);
    saltus_sweep_seed(t->rng, t->sweep->options.seed, saltus_trajectory_point(t), -1 - t->seed);
    for (int i = 0; i < t->sweep->dimension; i++)
        vector[i] = disturbance * gsl_ran_gaussian(t->rng, scale[i]);
    keep_to_contacts(t, vector);
    for (int sign = 1; sign >= -1; sign -= 2) {
        for (int i = 0; i < t->sweep->dimension; i++)
            moved[i] = t->state[i] + sign * vector[i];
        if (saltus_system_check_state(t->system, moved, NULL) == SALTUS_OK)
            break;
    }
    saltus_sweep_admit(t->system, moved);
    memcpy(t->home, t->state, (size_t)t->sweep->dimension * sizeof *t->home);
    t->home_cycle = saltus_trajectory_cycle(t);
    t->disturbed = true;
    return saltus_trajectory_continue(t, moved);
}

/* Whether the points of the last p periods come by where the trajectory was before it was disturbed, at the
 * same time of the orbit. */
static bool is_home(const saltus_trajectory *t, int periods) {
    const saltus_settling *s = &t->settling;
    int back = (int)((saltus_trajectory_cycle(t) - t->home_cycle) % periods);
    const double *point = s->points + (size_t)((s->count - 1 - back) % s->size) * (size_t)s->n;
    return saltus_system_distance(t->system, point, t->home) < home_again;
}

/* Go on from a motion that has been found otherwise. */
static saltus_judgement adopt(saltus_trajectory *t, const saltus_motion *motion) {
    if (!saltus_trajectory_continue(t, motion->state))
        return failed;
    if (motion->verdict == SALTUS_HELD || motion->verdict == SALTUS_EQUILIBRIUM)
        return (saltus_judgement){motion->verdict == SALTUS_HELD ? SALTUS_HELD : SALTUS_EQUILIBRIUM, 0, 0};
    memcpy(t->orbit, motion->section_states,
           (size_t)motion->periods * (size_t)t->sweep->dimension * sizeof *t->orbit);
    return (saltus_judgement){SALTUS_PERIODIC, motion->periods, motion->periods};
}

static saltus_classify_options polishing(const saltus_trajectory *t) {
    saltus_classify_options options = saltus_classify_defaults();
    options.flow.integrator = t->sweep->options.flow.integrator;
    options.transient = polish_periods;
    options.measure = 0;
    options.longest = t->sweep->options.longest;
    return options;
}

/* Let classification look at the present state. */
static saltus_judgement polish(saltus_trajectory *t) {
    saltus_classify_options options = polishing(t);
    saltus_motion motion = {0};
    saltus_status status = saltus_motion_find_period(t->system, t->state, &options, false, &motion, NULL);
    bool found = status == SALTUS_OK && saltus_verdict_settled(motion.verdict);
    saltus_judgement judgement = found ? adopt(t, &motion) : goes_on;
    t->starved |= status == SALTUS_NO_MEMORY;
    saltus_motion_clear(&motion);
    return judgement;
}

/* The period is in doubt: the stable orbit of the shortest part of it is the one. */
static saltus_judgement resolve(saltus_trajectory *t, int periods) {
    saltus_classify_options options = polishing(t);
    saltus_judgement judgement = goes_on;
    for (int part = 1; part <= periods && judgement.verdict == SALTUS_PENDING; part++) {
        saltus_motion motion = {0};
        saltus_status status = SALTUS_NO_CONVERGENCE;
        if (periods % part == 0)
            status = saltus_motion_polish(t->system, part, t->state, same_orbit, &options, &motion);
        if (status == SALTUS_OK)
            judgement = adopt(t, &motion);
        t->starved |= status == SALTUS_NO_MEMORY;
        saltus_motion_clear(&motion);
    }
    return judgement;
}

/* Whether the recurrences of the period that is hoped for have shrunk, each time they were looked at. In a
 * small chaotic attractor something recurs for long, but no better. */
static bool shrinks(saltus_trajectory *t, int candidate) {
    double now = saltus_settling_recurrence(&t->settling, candidate);
    return now < shrinking * t->trend[0] && t->trend[0] < shrinking * t->trend[1];
}

static void follow_trend(saltus_trajectory *t, int candidate) {
    if (candidate != t->recurring) {
        t->waited = 0;
        t->trend[0] = t->trend[1] = 0;
    } else if (++t->waited % look_periods == 0) {
        t->trend[1] = t->trend[0];
        t->trend[0] = saltus_settling_recurrence(&t->settling, candidate);
    }
    t->recurring = candidate;
}

/* Ask Newton's method, when iteration is slow; more seldom each time. An orbit of very many impacts costs it
 * more than all the iteration does; that one is left to iteration. */
static saltus_judgement ask(saltus_trajectory *t, int candidate) {
    if (!is_last(t) && t->waited <= t->patience + patience_per_period * candidate)
        return goes_on;
    if (!shrinks(t, candidate) || saltus_settling_impacts(&t->settling, candidate) > polish_impacts)
        return goes_on;
    t->waited = 0;
    t->patience *= 2;
    return polish(t);
}

/* Ask it when iteration cannot tell the period. */
static saltus_judgement ask_doubtful(saltus_trajectory *t, int period) {
    if (!is_last(t) && saltus_trajectory_cycle(t) < t->ask_again)
        return goes_on;
    if (saltus_settling_impacts(&t->settling, period) > polish_impacts)
        return goes_on;
    t->ask_again = saltus_trajectory_cycle(t) + patience_per_period * period;
    return resolve(t, period);
}

/* A period has been reached to within `approach`, or, after the disturbance, to within what makes it certain:
 * disturb the trajectory, or see whether it has come back. One that has come to another place is disturbed
 * there anew. */
static saltus_judgement prove(saltus_trajectory *t, int period, saltus_verdict verdict) {
    if (t->disturbed && is_home(t, period))
        return (saltus_judgement){verdict, period, period};
    return disturb(t) ? goes_on : failed;
}

static int period_reached(const saltus_trajectory *t, bool *doubt) {
    return saltus_settling_period(&t->settling, t->disturbed ? t->settling.near : approach, doubt);
}

/* A system without forcing can only come to rest. */
static saltus_judgement judge_rest(saltus_trajectory *t) {
    bool doubt, held = saltus_flow_contacts(t->flow, t->lane) != 0;
    saltus_judgement judgement = goes_on;
    if (period_reached(t, &doubt) == 1 && saltus_settling_rests(&t->settling))
        judgement = prove(t, 1, held ? SALTUS_HELD : SALTUS_EQUILIBRIUM);
    judgement.recurs = saltus_settling_candidate(&t->settling);
    return judgement;
}

static void keep_orbit(saltus_trajectory *t, int periods) {
    const saltus_settling *s = &t->settling;
    size_t n = (size_t)s->n;
    for (int k = 0; k < periods; k++)
        memcpy(t->orbit + (size_t)k * n, s->points + (size_t)((s->count - periods + k) % s->size) * n,
               n * sizeof *t->orbit);
}

/* Sticking makes an orbit superstable, and whether a chatter is complete may hang on the tolerance: an orbit
 * that sticks must close with the tightest one too. */
static bool closes_tightly(saltus_trajectory *t, int periods) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = NULL;
    saltus_event event;
    double end[SALTUS_STATE_MAX];
    options.integrator = t->sweep->options.flow.integrator;
    saltus_status status = saltus_flow_single(t->system, 0, &options, &flow, NULL);
    t->starved |= status == SALTUS_NO_MEMORY;
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, t->state, NULL);
    if (status == SALTUS_OK)
        status = saltus_flow_advance(flow, (saltus_time){periods, 0}, 0, &event, NULL);
    if (status == SALTUS_OK)
        saltus_flow_state(flow, 0, end);
    saltus_flow_free(flow);
    return status == SALTUS_OK &&
           saltus_system_distance(t->system, end, t->state) < fmax(home_again, 100 * t->settling.near);
}

/* What has been proven to return is the trajectory's orbit. */
static saltus_judgement conclude(saltus_trajectory *t, int period, saltus_judgement judgement) {
    if (judgement.verdict != SALTUS_PERIODIC)
        return judgement;
    if (saltus_settling_contacts(&t->settling, period) > 0 && !closes_tightly(t, period)) {
        t->disturbed = false;
        return goes_on;
    }
    keep_orbit(t, period);
    return judgement;
}

saltus_judgement saltus_trajectory_judge(saltus_trajectory *t) {
    bool doubt = false;
    if (!saltus_system_forced(t->system))
        return judge_rest(t);
    int candidate = saltus_settling_candidate(&t->settling),
        period = candidate ? period_reached(t, &doubt) : 0;
    saltus_judgement judgement = goes_on;
    if (period)
        judgement = doubt ? ask_doubtful(t, period) : conclude(t, period, prove(t, period, SALTUS_PERIODIC));
    follow_trend(t, candidate);
    if (candidate && judgement.verdict == SALTUS_PENDING)
        judgement = ask(t, candidate);
    judgement.recurs = candidate;
    return judgement;
}
