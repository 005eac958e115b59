/* Searching for what a trajectory settles on: an orbit or a rest.
 *
 * The stroboscopic map is iterated in blocks. After each block the least p is determined for which the last
 * points recur after p periods. Newton's method on the p-th iterate polishes this candidate; the orbit found
 * is accepted if it is stable, lies where the trajectory is, has no shorter period, and the trajectory keeps
 * closing in on it. Everything reported is then measured on the polished orbit, not on the transient.
 * Without forcing a rest may be approached too slowly to wait for: Newton's method finds it, its eigenvalues
 * predict how fast the trajectory approaches, and two looks confirm that.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/search.h"

#include "flow/effort.h"
#include "orbit/returns.h"
#include "system/system.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Distances in the stroboscopic section are relative to the system's scales. */
static const double nearby = 3e-3; /* the polished orbit must be this close to the trajectory */
static const double all_but_reached = 1e-6;
static const double on_orbit = 1e-7;      /* distance from an orbit of a continuum, none of which attracts */
static const double drift_at_rest = 1e-6; /* of a displacement, over a period */
static const double balance_rounding = 1e-12; /* of an acceleration, over stiffness and displacement */
static const double near_rest = 3e-3;         /* distance from a rest that is approached slowly */
static const double recurs_to_rounding = 1e-12, coarsest = 1e-8; /* recurrence; Newton's residual then */

/* Advance the trajectory by a period; without forcing collect its returns on the way. */
static saltus_status advance_period(saltus_search *s, saltus_message *message) {
    double state[SALTUS_STATE_MAX];
    const unsigned watch = saltus_system_forced(s->system) ? 0 : saltus_crossings_watch(s->system);
    saltus_event event = {.kind = SALTUS_STEP};
    saltus_time until = {saltus_flow_time(s->flow, 0).cycle + 1, 0};
    while (event.kind != SALTUS_REACHED) {
        saltus_status status = saltus_flow_advance(s->flow, until, watch, &event, message);
        if (status != SALTUS_OK)
            return status;
        if (!watch)
            continue;
        saltus_flow_state(s->flow, 0, state);
        const saltus_flow_info done = saltus_flow_information(s->flow, 0);
        saltus_crossings_take(&s->visits.returns, s->flow, 0, &event, state);
        while (saltus_visits_next(&s->visits, s->flow, 0, done, state))
            ;
    }
    saltus_flow_state(s->flow, 0, state);
    saltus_flow_info info = saltus_flow_information(s->flow, 0);
    saltus_settling_add(&s->settling, state, info.impacts, info.sticks + info.releases);
    return saltus_state_bounded(s->system, state, saltus_flow_contacts(s->flow, 0), s->settling.count,
                                message);
}

/* Whether an unforced system is at rest: neither events nor motion over the last periods, no drift of a
 * displacement, and, clear of stops, forces that balance without the velocities. Along a slow manifold they
 * do not, however slowly strong damping lets the motion creep. A fast mode magnifies rounding in
 * accelerations. */
static bool is_resting(const saltus_search *s) {
    if (saltus_system_forced(s->system) || !saltus_settling_rests(&s->settling))
        return false;
    const int dof = saltus_system_dof(s->system);
    const double *scale = saltus_system_scale(s->system), period = saltus_system_period(s->system);
    double drift = 0, state[SALTUS_STATE_MAX], field[SALTUS_STATE_MAX];
    saltus_flow_field(s->flow, 0, field);
    for (int i = 0; i < dof; i++)
        drift = fmax(drift, fabs(field[i]) / scale[i] * period);
    if (!(drift < drift_at_rest) || saltus_flow_contacts(s->flow, 0))
        return drift < drift_at_rest;
    saltus_flow_state(s->flow, 0, state);
    memset(state + dof, 0, (size_t)dof * sizeof *state);
    if (saltus_flow_start(s->beside, 0, (saltus_time){0, 0}, state, NULL) != SALTUS_OK)
        return true;
    saltus_flow_field(s->beside, 0, field);
    for (int i = 0; i < dof; i++) {
        const double rounding = balance_rounding * s->system->stiffness[i] * fabs(state[i]);
        if (fabs(field[dof + i]) > fmax(rounding, drift_at_rest * scale[dof + i] / period))
            return false;
    }
    return true;
}

/* How much coarser than usual rounding is in the system's scales, if a motion is far larger than these: with
 * a clearance that is all but zero, or under a load that is far too great. */
static double coarseness(const saltus_search *s) {
    static const double large = 1e4;
    const double *scale = saltus_system_scale(s->system), *last = saltus_settling_point(&s->settling, 0);
    double size = 0;
    for (int i = 0; i < s->settling.n; i++)
        size = fmax(size, fabs(last[i]) / scale[i]);
    return fmax(1, size / large);
}

/* Distance of the trajectory's last section point from the orbit. */
static double distance_from_orbit(const saltus_search *s) {
    double least = INFINITY;
    if (!s->clocked)
        return saltus_system_distance(s->system, saltus_settling_point(&s->settling, 0), s->orbit.state);
    for (int k = 0; k < s->lap.periods; k++)
        least = fmin(least, saltus_system_distance(s->system, saltus_settling_point(&s->visits.settling, 0),
                                                   s->lap.points + (size_t)(k * s->orbit.dimension)));
    return least;
}

saltus_status saltus_search_open(saltus_search *s, const double *state, saltus_motion *motion,
                                 saltus_message *message) {
    const saltus_flow_options *options = &s->options->flow;
    const int n = saltus_system_dimension(s->system), longest = s->options->longest;
    s->lap.keeps_events = true;
    saltus_status status = saltus_flow_single(s->system, 0, options, &s->flow, message);
    if (status == SALTUS_OK)
        status = saltus_flow_single(s->system, 0, options, &s->beside, message);
    if (status == SALTUS_OK &&
        !(saltus_settling_open(&s->settling, n, longest) &&
          (saltus_system_forced(s->system) || saltus_visits_open(&s->visits, n, longest))))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory to classify");
    if (status == SALTUS_OK) {
        saltus_settling_reset(&s->settling, s->system, options->rtol);
        if (!saltus_system_forced(s->system))
            saltus_visits_reset(&s->visits, s->system);
        status = saltus_flow_start(s->flow, 0, (saltus_time){0, 0}, state, message);
    }
    if (status == SALTUS_OK && !saltus_motion_open(s->system, options, motion))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory to classify");
    return status;
}

void saltus_search_close(saltus_search *s) {
    saltus_orbit_clear(&s->orbit);
    saltus_settling_close(&s->settling);
    saltus_visits_close(&s->visits);
    saltus_flow_free(s->around);
    saltus_system_free(s->clocked);
    saltus_flow_free(s->flow);
    saltus_flow_free(s->beside);
    saltus_lap_close(&s->lap);
}

/* The period to try now, or 0: that of an orbit that is all but reached, otherwise the least that roughly
 * recurs. Near a flip the latter would be only half the orbit's. */
static int period_to_try(saltus_settling *settling) {
    bool doubt;
    const int rough = saltus_settling_candidate(settling),
              reached = rough ? saltus_settling_period(settling, all_but_reached, &doubt) : 0;
    return reached ? reached : rough;
}

/* Take or drop the orbit that Newton's method found from the trajectory's last point, which recurred within
 * `recurrence`. The orbit must be stable, near the trajectory, and approached by it: the distance falls to a
 * fifth or below `near`, or, with a multiplier close to the unit circle, by at least half of what that
 * multiplier predicts. An orbit of a continuum only has to be the one that the trajectory is on. */
static saltus_status take_orbit(saltus_search *s, saltus_status polished, double recurrence,
                                saltus_message *message) {
    enum { cycles_max = 60, patient_cycles = 40 };
    const saltus_orbit *orbit = &s->orbit;
    const bool continuum = s->clocked && saltus_system_conservative(s->system);
    saltus_status status = polished == SALTUS_NO_MEMORY ? polished : SALTUS_OK;
    const double start = polished == SALTUS_OK ? distance_from_orbit(s) : INFINITY,
                 near = fmax(1e-9, 1e4 * s->options->flow.rtol) * coarseness(s);
    const bool candidate = polished == SALTUS_OK && !continuum &&
                           saltus_multipliers_stable(orbit->multipliers, orbit->multiplier_count) &&
                           start <= fmax(nearby, 30 * recurrence);
    /* About one period of the orbit, in the trajectory's periods. */
    const int periods = s->clocked
                            ? (int)ceil(saltus_system_period(s->clocked) / saltus_system_period(s->system))
                            : orbit->periods;
    s->found = continuum && start <= on_orbit;
    for (int c = 0; c < cycles_max && candidate && !s->found; c++) {
        for (int k = 0; k < periods && status == SALTUS_OK; k++)
            status = advance_period(s, message);
        if (status != SALTUS_OK)
            break;
        const double now = distance_from_orbit(s),
                     predicted = exp((c + 1) * orbit->multipliers[0].log_modulus);
        s->found = now < near || (c > 2 && now < 0.2 * start) ||
                   (c >= patient_cycles && now <= start * (1 - 0.5 * (1 - predicted)));
        if (now > 10 * start + near)
            break;
    }
    if (s->found)
        return status;
    saltus_flow_free(s->around);
    saltus_system_free(s->clocked);
    saltus_orbit_clear(&s->orbit);
    s->around = NULL;
    s->clocked = NULL;
    return status;
}

bool saltus_search_recurs(saltus_search *s, double *recurrence, double *period) {
    const int p = saltus_settling_candidate(&s->visits.settling);
    if (p == 0)
        return false;
    *recurrence = saltus_settling_recurrence(&s->visits.settling, p);
    *period = saltus_visits_taken(&s->visits, p) * saltus_system_period(s->system);
    return *recurrence < recurs_to_rounding;
}

/* Without forcing: try the number of returns that recurs now, with the time between them as period. Where the
 * flow is so stiff that rounding in it exceeds what Newton's method asks for, points that have recurred to
 * rounding are worth a coarser residual, which the result tells. */
static saltus_status try_cycle(saltus_search *s, saltus_message *message) {
    saltus_orbit_options shooting = saltus_motion_shooting(s->options);
    saltus_system *counted = NULL;
    saltus_settling *returns = &s->visits.settling;
    const int p = returns->count > s->tried ? period_to_try(returns) : 0;
    if (p == 0)
        return SALTUS_OK;
    s->tried = returns->count;
    const double recurrence = saltus_settling_recurrence(returns, p),
                 *last = saltus_settling_point(returns, 0),
                 omega =
                     saltus_spec_omega(saltus_system_spec(s->system)) / saltus_visits_taken(&s->visits, p);
    if (recurrence < recurs_to_rounding)
        shooting.tolerance = fmax(shooting.tolerance, coarsest);
    saltus_status status = saltus_system_clocked(s->system, omega, &counted, message);
    if (status == SALTUS_OK)
        status = saltus_cycle_polish(counted, last, &shooting, &s->orbit, &s->clocked, &s->lap, message);
    if (status == SALTUS_OK)
        status = saltus_flow_single(s->clocked, 0, &s->options->flow, &s->around, message);
    saltus_system_free(counted);
    return take_orbit(s, status, recurrence, message);
}

/* Try the period that recurs now. A long orbit of very many impacts may take minutes: it is tried only if it
 * is all but reached. */
static saltus_status try_period(saltus_search *s, saltus_message *message) {
    enum { most_impacts = 150, few_steps = 4 };
    saltus_orbit_options shooting = saltus_motion_shooting(s->options);
    const int p = period_to_try(&s->settling);
    const double impacts = (double)saltus_flow_information(s->flow, 0).impacts / (double)s->settling.count;
    if (p == 0)
        return SALTUS_OK;
    shooting.tolerance *= coarseness(s);
    const double recurrence = saltus_settling_recurrence(&s->settling, p);
    const bool costly = p * impacts > most_impacts;
    if (costly && (s->limited || recurrence > all_but_reached || s->settling.count < s->next_costly))
        return SALTUS_OK;
    if (costly) {
        s->next_costly = 4 * s->settling.count;
        shooting.iterations = few_steps; /* enough for Newton's method so near to an orbit */
    }
    /* What is all but reached is worth more steps in a period than a search spends: they count only in all.
     */
    saltus_effort *effort = recurrence <= all_but_reached ? s->options->flow.effort : NULL,
                  all = {.spent = effort ? effort->spent : 0, .total = effort ? effort->total : 0};
    if (effort)
        shooting.flow.effort = &all;
    double state[SALTUS_STATE_MAX];
    saltus_flow_state(s->flow, 0, state);
    saltus_status status = saltus_return_polish(s->beside, p, state, &shooting, &s->orbit, &s->lap, message);
    if (effort) {
        effort->spent = all.spent;
        effort->total = all.total;
    }
    return take_orbit(s, status, recurrence, message);
}

saltus_status saltus_search_run(saltus_search *s, long long at_most, saltus_motion *motion,
                                saltus_message *message) {
    const saltus_classify_options *o = s->options;
    long long block = SALTUS_FIRST_BLOCK;
    double place[SALTUS_STATE_MAX];
    saltus_status status = SALTUS_OK;
    while (status == SALTUS_OK && !s->found && !s->stopped && s->settling.count < at_most) {
        long long until = s->settling.count + block < at_most ? s->settling.count + block : at_most;
        while (status == SALTUS_OK && s->settling.count < until)
            status = advance_period(s, message);
        s->stopped = saltus_stop_asked(o->flow.stop);
        if (s->stopped)
            status = SALTUS_OK; /* an interrupted flow is no error here */
        if (status != SALTUS_OK || s->stopped)
            break;
        saltus_progress_show(o->progress, (double)s->settling.count, (double)o->transient);
        if (is_resting(s)) {
            motion->verdict = saltus_flow_contacts(s->flow, 0) ? SALTUS_HELD : SALTUS_EQUILIBRIUM;
            break;
        }
        bool forced = saltus_system_forced(s->system), at_rest = false;
        status = forced ? try_period(s, message) : try_cycle(s, message);
        /* Without forcing the trajectory may approach a stable rest, however slowly. */
        if (status == SALTUS_OK && !s->found && !forced && !saltus_flow_contacts(s->flow, 0) &&
            saltus_settling_recurrence(&s->settling, 1) <= nearby)
            status = saltus_rest_is_approached(s->system, saltus_settling_point(&s->settling, 0),
                                               (double)s->settling.count * saltus_system_period(s->system),
                                               &s->beside_rest, place, &at_rest, message);
        if (at_rest) {
            motion->verdict = SALTUS_EQUILIBRIUM;
            break;
        }
        block = block < 1024 ? block + block / 2 : 1024;
    }
    motion->transient = s->settling.count;
    return status;
}

saltus_status saltus_search_conclude(saltus_search *s, saltus_motion *motion, saltus_message *message) {
    if (s->found)
        return saltus_motion_take(s->clocked ? s->clocked : s->system, s->clocked ? s->around : s->beside,
                                  &s->orbit, &s->lap, motion, message);
    if (motion->verdict == SALTUS_UNDECIDED) {
        char recurrence[64] = "";
        double closest = saltus_settling_closest(&s->settling);
        if (isfinite(closest))
            snprintf(recurrence, sizeof recurrence, "; closest recurrence %.2g of the state's scale",
                     closest);
        snprintf(motion->reason, sizeof motion->reason,
                 "no stable orbit of period up to %d T after %lld periods%s%s; a longer --transient, or the "
                 "exponent (--measure), would decide",
                 s->options->longest, s->settling.count, s->stopped ? " (stopped)" : "", recurrence);
    }
    return saltus_motion_rest(s->system, s->flow, motion, message);
}

saltus_status saltus_motion_find_period(const saltus_system *system, const double *state,
                                        const saltus_classify_options *options, bool limited,
                                        saltus_motion *motion, saltus_message *message) {
    saltus_search s = {.system = system, .options = options, .limited = limited};
    *motion = (saltus_motion){0};
    saltus_status status = saltus_search_open(&s, state, motion, message);
    if (status == SALTUS_OK)
        status = saltus_search_run(&s, options->transient, motion, message);
    if (status == SALTUS_OK)
        status = saltus_search_conclude(&s, motion, message);
    saltus_search_close(&s);
    if (status != SALTUS_OK)
        saltus_motion_clear(motion);
    return status;
}

saltus_status saltus_rest_is_approached(const saltus_system *system, const double *state, double time,
                                        saltus_rest_look *last, double *place, bool *approached,
                                        saltus_message *message) {
    const saltus_equilibrium_options options = saltus_equilibrium_defaults();
    const saltus_rest_look before = *last;
    saltus_equilibrium rest = {0};
    *last = (saltus_rest_look){0, time};
    *approached = false;
    saltus_status status = saltus_equilibrium_find(system, state, &options, &rest, message);
    if (status == SALTUS_OK && rest.stable && !rest.contacts) {
        double distance = saltus_system_distance(system, state, rest.state),
               predicted = exp(rest.eigenvalues[0].re * (time - before.time));
        if (distance < near_rest)
            last->distance = distance;
        *approached = distance < near_rest && distance <= before.distance * (1 - 0.5 * (1 - predicted));
        memcpy(place, rest.state, (size_t)rest.dimension * sizeof *place);
    }
    saltus_equilibrium_clear(&rest);
    return status == SALTUS_NO_MEMORY ? status : SALTUS_OK;
}
