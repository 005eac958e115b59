/* Whether a trajectory of a sweep has settled, and on what.
 *
 * Once a trajectory is near its orbit it is disturbed by a small random vector. Only a stable orbit draws it
 * back to where it was: neither an unstable orbit nor one of a continuum does. If iteration cannot tell the
 * period, or the way back is slow, Newton's method and the multipliers decide, from the point reached, as
 * they always do in classification (motion/search.c); but only after a while, because a question takes as
 * long as thousands of periods in a lane. Using them for every orbit would make a sweep almost three times as
 * long: the disturbed trajectory stays in its lane beside the others, whereas Newton's method stops all of
 * them for a single trajectory with a tangent vector for each entry of the state.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "orbit/orbit.h"
#include "system/system.h"

#include <math.h>
#include <string.h>

enum {
    look_periods = 32,        /* between looks at whether the recurrences shrink */
    patience_periods = 200,   /* before Newton's method is tried, ... */
    patience_per_period = 20, /* ... and more for each period of the orbit that recurs */
    first_patience = 64,      /* without forcing: periods between two tries of Newton's method at first, */
    patience_most = 1024,     /* and at most */
    polish_periods = 320,     /* periods that classification from the point reached may run */
    polish_impacts = 100      /* for orbits with more, Newton's method costs more than the iteration */
};
static const double approach = 1e-6;    /* a trajectory this near to its orbit is disturbed ... */
static const double disturbance = 1e-5; /* ... by this, relative to the system's scales, */
static const double returned = 3e-6;    /* and must come back to within this */
static const double same_orbit = 1e-3;  /* an orbit found this near is the trajectory's own */
static const double on_orbit = 1e-7;    /* the same in a conservative system, where none attracts */
static const double arrived = 3e-3;     /* classification takes an orbit this near */
static const double shrinking = 0.98;   /* recurrences must shrink by this factor from look to look */

static const saltus_judgement goes_on = {SALTUS_PENDING, 0, 0};
static const saltus_judgement failed = {SALTUS_FAILED, 0, 0};

void saltus_sweep_trajectory_begin_settling(saltus_sweep_trajectory *t) {
    t->proof.waited = t->proof.ask_again = 0;
    t->proof.recurring = t->proof.rejected_period = 0;
    t->proof.rest = (saltus_rest_look){0};
    t->proof.patience = saltus_system_forced(t->system) ? patience_periods : first_patience;
}

/* The remaining distance from the orbit at which it counts as reached. */
static double near_enough(const saltus_sweep_trajectory *t) {
    return fmax(1e-10, 10 * t->sweep->options.flow.rtol);
}

/* Options of classifications from the present state, and of their shooting. */
static saltus_classify_options classify_options(saltus_sweep_trajectory *t) {
    saltus_classify_options options = saltus_classify_defaults();
    options.flow.integrator = t->sweep->options.flow.integrator;
    /* Three digits more than the sweep's are enough. */
    options.flow.rtol = fmax(options.flow.rtol, 1e-3 * t->sweep->options.flow.rtol);
    options.flow.effort = &t->effort;
    options.transient = polish_periods;
    options.measure = 0;
    options.longest = t->sweep->options.longest;
    return options;
}

/* Move the trajectory onto an orbit that is its own, which has these section points. */
static saltus_judgement take_orbit(saltus_sweep_trajectory *t, saltus_verdict verdict, int periods,
                                   const double *points) {
    if (verdict == SALTUS_PERIODIC)
        memcpy(t->proof.orbit, points, (size_t)(periods * t->sweep->dimension) * sizeof *points);
    return saltus_sweep_trajectory_continue(t, points) ? (saltus_judgement){verdict, periods, 0} : failed;
}

/* What classification finds from the present state. */
static saltus_judgement ask_classification(saltus_sweep_trajectory *t) {
    const saltus_classify_options options = classify_options(t);
    saltus_judgement judgement = goes_on;
    saltus_motion motion = {0};
    saltus_status status = saltus_motion_find_period(t->system, t->state, &options, false, &motion, NULL);
    t->starved |= status == SALTUS_NO_MEMORY;
    if (status == SALTUS_OK && saltus_verdict_settled(motion.verdict))
        judgement = take_orbit(t, motion.verdict, motion.periods,
                               motion.section_states ? motion.section_states : motion.state);
    saltus_motion_clear(&motion);
    return judgement;
}

/* Where the trajectory is in the cycles of an orbit of this period that it passed at `cycle`. */
static const double *passed_at(const saltus_sweep_trajectory *t, long long cycle, int period) {
    return saltus_settling_point(&t->proof.settling,
                                 (int)((saltus_sweep_trajectory_cycle(t) - cycle) % period));
}

/* Newton's method from the present state: the stable orbit of this period, or a divisor of it, that the
 * trajectory is on. An unstable one is not computed again as long as the trajectory passes it. *distant: the
 * orbit is stable, but approached so slowly that classification would not see the trajectory arrive. */
static saltus_judgement ask_newton(saltus_sweep_trajectory *t, int period, bool *distant) {
    const saltus_classify_options options = classify_options(t);
    const saltus_orbit_options shooting = saltus_motion_shooting(&options);
    saltus_proof *p = &t->proof;
    saltus_judgement judgement = goes_on;
    saltus_orbit orbit = {0};
    saltus_lap lap = {0};
    saltus_flow *flow = NULL;
    *distant = false;
    if (p->rejected_period == period &&
        saltus_system_distance(t->system, passed_at(t, p->rejected_at, period), p->rejected) < same_orbit)
        return goes_on;
    saltus_status status =
        saltus_orbit_search(t->system, period, t->state, &shooting, SALTUS_MULTIPLIERS_LEADING, &orbit, NULL);
    const bool found = status == SALTUS_OK,
               stable = found && saltus_multipliers_stable(orbit.multipliers, orbit.multiplier_count),
               near = found && saltus_orbit_passes(t->system, orbit.state, 1, t->state, same_orbit);
    if (stable && !near)
        *distant = saltus_system_distance(t->system, orbit.state, t->state) *
                       exp(orbit.multipliers[0].log_modulus * polish_periods / period) >
                   arrived;
    if (near && !stable) {
        p->rejected_period = period;
        p->rejected_at = saltus_sweep_trajectory_cycle(t);
        memcpy(p->rejected, orbit.state, (size_t)orbit.dimension * sizeof *orbit.state);
    }
    if (near && stable)
        status = saltus_flow_single(t->system, 0, &options.flow, &flow, NULL);
    if (flow)
        status = saltus_lap_around(&lap, flow, orbit.state, period, NULL);
    if (flow && status == SALTUS_OK)
        judgement = take_orbit(t, saltus_lap_held(&lap) ? SALTUS_HELD : SALTUS_PERIODIC,
                               saltus_lap_least_period(&lap, &options.flow), lap.points);
    t->starved |= status == SALTUS_NO_MEMORY;
    saltus_flow_free(flow);
    saltus_lap_close(&lap);
    saltus_orbit_clear(&orbit);
    return judgement;
}

bool saltus_sweep_trajectory_count_returns(saltus_sweep_trajectory *t, bool *counts) {
    static const double overdue = 4; /* mean times without a return: none is expected any more */
    const double now = saltus_time_periods(saltus_flow_time(t->flow, t->lane));
    saltus_system *counted = NULL;
    saltus_status status = saltus_visits_count(&t->proof.visits, t->system, &counted, NULL);
    double period = counted ? saltus_system_period(counted) : 0;
    saltus_system_free(counted);
    t->starved |= status == SALTUS_NO_MEMORY;
    *counts = period > 0 && (now - saltus_visits_last(&t->proof.visits)) * saltus_system_period(t->system) <
                                overdue * period;
    if (!*counts)
        return status == SALTUS_OK;
    return saltus_sweep_trajectory_count_by(t, period, (saltus_time){saltus_sweep_trajectory_cycle(t), 0},
                                            t->state);
}

/* Move a state on an unforced orbit from its section point to between two events, in the time *later. */
static saltus_status leave_section(const saltus_sweep_trajectory *t, double period, double *state,
                                   double *later) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_system *counted = NULL;
    saltus_flow *flow = NULL;
    options.integrator = t->sweep->options.flow.integrator;
    saltus_status status = saltus_system_clocked(t->system, 2 * M_PI / period, &counted, NULL);
    if (status == SALTUS_OK)
        status = saltus_flow_single(counted, 0, &options, &flow, NULL);
    if (status == SALTUS_OK)
        status = saltus_cycle_leave(flow, state, later, NULL);
    saltus_flow_free(flow);
    saltus_system_free(counted);
    return status;
}

/* Move the trajectory onto an unforced orbit: count time by its returns, and start the lap between two
 * events, so that each is met once. */
static saltus_judgement go_around(saltus_sweep_trajectory *t, const saltus_motion *motion) {
    const double period = motion->period / motion->periods;
    const size_t size = (size_t)t->sweep->dimension * sizeof *motion->state;
    double state[SALTUS_STATE_MAX], later = 0;
    memcpy(state, motion->state, size);
    memcpy(t->proof.orbit, motion->section_states, (size_t)motion->periods * size);
    t->proof.exponent = motion->lyapunov;
    saltus_status status = leave_section(t, period, state, &later);
    t->starved |= status == SALTUS_NO_MEMORY;
    saltus_time begin = saltus_time_of(later);
    begin.cycle += saltus_sweep_trajectory_cycle(t);
    if (status != SALTUS_OK || !saltus_sweep_trajectory_count_by(t, period, begin, state))
        return failed;
    return (saltus_judgement){SALTUS_PERIODIC, motion->periods, 0};
}

/* Newton's method with unknown period from the last return, given that every `recurs`-th return recurs. */
static saltus_judgement ask_for_cycle(saltus_sweep_trajectory *t, int recurs) {
    const saltus_visits *v = &t->proof.visits;
    const double *last = saltus_settling_point(&v->settling, 0);
    saltus_classify_options options = saltus_classify_defaults();
    saltus_judgement judgement = goes_on;
    saltus_motion motion = {0};
    options.flow.integrator = t->sweep->options.flow.integrator;
    saltus_status status =
        saltus_motion_cycle_after(t->system, saltus_visits_taken(v, recurs), last, &options, &motion, NULL);
    t->starved |= status == SALTUS_NO_MEMORY;
    /* In a conservative scene no orbit attracts: only the one that the trajectory is on is its own. */
    const bool kept = saltus_system_conservative(t->system);
    if (status == SALTUS_OK && (kept || motion.stable) && motion.periods <= t->sweep->options.longest &&
        saltus_orbit_passes(t->system, motion.section_states, motion.periods, last,
                            kept ? on_orbit : same_orbit))
        judgement = go_around(t, &motion);
    saltus_motion_clear(&motion);
    return judgement;
}

/* Whether iteration is so slow that it is time for Newton's method: after a wait that doubles each time, and
 * only if the recurrences have shrunk at every look. In a small chaotic attractor something recurs for long,
 * but gets no closer. */
static bool is_slow(saltus_sweep_trajectory *t, int recurs) {
    saltus_proof *p = &t->proof;
    if (recurs != p->recurring) {
        p->waited = 0;
        p->trend[0] = p->trend[1] = 0;
    } else if (++p->waited % look_periods == 0) {
        p->trend[1] = p->trend[0];
        p->trend[0] = saltus_settling_recurrence(&p->settling, recurs);
    }
    p->recurring = recurs;
    if (!recurs || (saltus_sweep_trajectory_cycle(t) < t->stage_end &&
                    p->waited <= p->patience + patience_per_period * recurs))
        return false;
    return saltus_settling_recurrence(&p->settling, recurs) < shrinking * p->trend[0] &&
           p->trend[0] < shrinking * p->trend[1] &&
           saltus_settling_impacts(&p->settling, recurs) <= polish_impacts;
}

/* A period has been reached. To within `approach`: disturb the trajectory. After the disturbance, to within
 * near_enough: check that the last period's points pass where it was, at the same phase of the orbit; if it
 * has come to another place, disturb it again there, but not before the recording. */
static saltus_judgement prove(saltus_sweep_trajectory *t, int period, saltus_verdict verdict) {
    saltus_proof *p = &t->proof;
    if (p->disturbed &&
        saltus_system_distance(t->system, passed_at(t, p->disturbed_at, period), p->undisturbed) < returned)
        return (saltus_judgement){verdict, period, 0};
    if (p->disturbed && t->stage == SALTUS_STAGE_PROVING)
        return goes_on;
    double moved[SALTUS_STATE_MAX];
    size_t size = (size_t)t->sweep->dimension * sizeof *moved;
    memcpy(p->undisturbed, saltus_settling_point(&p->settling, 0), size);
    memcpy(moved, t->state, size);
    p->disturbed_at = saltus_sweep_trajectory_cycle(t);
    p->disturbed = true;
    saltus_sweep_trajectory_seed(t, -1 - t->seed);
    saltus_state_disturb(t->system, saltus_random_rng(&t->random), disturbance,
                         saltus_flow_contacts(t->flow, t->lane), moved);
    return saltus_sweep_trajectory_continue(t, moved) ? goes_on : failed;
}

/* Sticking makes an orbit superstable, and the tolerance may decide whether a chatter is complete: an orbit
 * that sticks must also close with the tightest tolerance. */
static bool closes_tightly(saltus_sweep_trajectory *t, int periods) {
    saltus_flow_options options = saltus_flow_defaults();
    double end[SALTUS_STATE_MAX];
    options.integrator = t->sweep->options.flow.integrator;
    memcpy(end, t->state, (size_t)t->sweep->dimension * sizeof *end);
    saltus_status status = saltus_motion_settle(t->system, &options, periods, end, NULL);
    t->starved |= status == SALTUS_NO_MEMORY;
    return status == SALTUS_OK &&
           saltus_system_distance(t->system, end, t->state) < fmax(returned, 100 * near_enough(t));
}

/* The orbit of a period that has been reached, if it is proven; before the recording nothing else is asked.
 */
static saltus_judgement judge_orbit(saltus_sweep_trajectory *t, int period) {
    saltus_proof *p = &t->proof;
    saltus_judgement judgement = prove(t, period, SALTUS_PERIODIC);
    if (judgement.verdict != SALTUS_PERIODIC || t->stage == SALTUS_STAGE_PROVING)
        return judgement;
    if (saltus_settling_contacts(&p->settling, period) > 0 && !closes_tightly(t, period)) {
        p->disturbed = false;
        return goes_on;
    }
    size_t n = (size_t)t->sweep->dimension;
    for (int k = 0; k < period; k++)
        memcpy(p->orbit + (size_t)k * n, saltus_settling_point(&p->settling, period - 1 - k),
               n * sizeof *p->orbit);
    return judgement;
}

/* If the trajectory approaches a stable rest slowly, move it there. */
static saltus_judgement ask_for_rest(saltus_sweep_trajectory *t) {
    double place[SALTUS_STATE_MAX],
        time = (double)saltus_sweep_trajectory_cycle(t) * saltus_system_period(t->system);
    bool approached;
    saltus_status status =
        saltus_rest_is_approached(t->system, t->state, time, &t->proof.rest, place, &approached, NULL);
    t->starved |= status == SALTUS_NO_MEMORY;
    if (!approached)
        return goes_on;
    return saltus_sweep_trajectory_continue(t, place) ? (saltus_judgement){SALTUS_EQUILIBRIUM, 0, 0} : failed;
}

/* Without forcing: a rest, or returns that recur, for which Newton's method is tried ever less often. */
static saltus_judgement judge_unforced(saltus_sweep_trajectory *t) {
    saltus_proof *p = &t->proof;
    const long long cycle = saltus_sweep_trajectory_cycle(t);
    const int recurs = saltus_settling_candidate(&p->visits.settling);
    const double limit = p->disturbed ? near_enough(t) : approach;
    bool doubt = false;
    saltus_judgement judgement = goes_on;
    if (saltus_settling_rests(&p->settling) && saltus_settling_period(&p->settling, limit, &doubt) == 1)
        judgement = prove(t, 1, saltus_flow_contacts(t->flow, t->lane) ? SALTUS_HELD : SALTUS_EQUILIBRIUM);
    else if (recurs && (cycle >= p->ask_again || cycle >= t->stage_end)) {
        p->ask_again = cycle + p->patience;
        p->patience += p->patience < patience_most ? p->patience / 2 : 0;
        judgement = ask_for_cycle(t, recurs);
        if (judgement.verdict == SALTUS_PENDING && !saltus_flow_contacts(t->flow, t->lane))
            judgement = ask_for_rest(t);
    }
    judgement.recurs = recurs;
    return judgement;
}

saltus_judgement saltus_sweep_trajectory_judge(saltus_sweep_trajectory *t) {
    saltus_proof *p = &t->proof;
    if (!saltus_system_forced(t->system))
        return judge_unforced(t);
    const long long cycle = saltus_sweep_trajectory_cycle(t);
    const bool ends = cycle >= t->stage_end, asks = t->stage != SALTUS_STAGE_PROVING;
    const int recurs = saltus_settling_candidate(&p->settling);
    bool doubt = false, distant;
    int period =
        recurs ? saltus_settling_period(&p->settling, p->disturbed ? near_enough(t) : approach, &doubt) : 0;
    saltus_judgement judgement = goes_on;
    if (period && !doubt)
        judgement = judge_orbit(t, period);
    else if (asks && period && (ends || cycle >= p->ask_again) &&
             saltus_settling_impacts(&p->settling, period) <= polish_impacts) {
        const bool first = p->ask_again == 0 && !ends;
        p->ask_again = cycle + patience_per_period * (first ? recurs : period);
        /* What recurs is asked about first: it costs a fraction of what else there may be. */
        judgement = ask_newton(t, recurs, &distant);
        if (judgement.verdict == SALTUS_PENDING && !first && period != recurs)
            judgement = ask_newton(t, period, &distant);
    }
    if (asks && is_slow(t, recurs) && judgement.verdict == SALTUS_PENDING) {
        p->waited = 0;
        p->patience *= 2;
        judgement = ask_newton(t, recurs, &distant);
        if (judgement.verdict == SALTUS_PENDING && !distant)
            judgement = ask_classification(t);
    }
    judgement.recurs = recurs;
    return judgement;
}
