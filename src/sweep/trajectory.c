/* One trajectory of a sweep, from its start to its row.
 *
 * Adaptive: it settles until its period is certain and is then recorded once around the orbit, or, where no
 * period is certain in the time given, for a number of periods. Fixed: it runs and is recorded for given
 * numbers of periods; then it settles, if anything recurs, and goes once around its orbit to be counted.
 *
 * On the way, once it is near its orbit, the trajectory is disturbed by a small random vector. Only a stable
 * orbit draws it back to where it was: not an unstable one, nor one of a continuum. Where iteration cannot
 * tell the period, or the way back is slow, Newton's method and the multipliers decide, from the point that
 * has been reached.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <gsl/gsl_randist.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { blind_periods = 64, look_periods = 32 };
enum {
    settling_after_record = 400,
    patience_periods = 200,
    patience_per_period = 20,
    polish_periods = 320,
    polish_impacts = 100
};

static const double approach = 1e-6;    /* distance left to the orbit when it is disturbed, ... */
static const double disturbance = 1e-5; /* ... by this, relative to the system's scales, ... */
static const double home_again = 3e-6;  /* ... and to which it must come back */
static const double same_orbit = 1e-3;  /* an orbit of Newton's method this near is the trajectory's own */
static const double shrinking = 0.98;   /* of recurrences from one look to the next, at most */
static const double unbounded = 1e8;

bool saltus_trajectory_open(saltus_trajectory *t, const saltus_sweep *sweep) {
    size_t n = (size_t)sweep->dimension;
    *t = (saltus_trajectory){.sweep = sweep};
    t->state = calloc(n, sizeof *t->state);
    t->home = calloc(n, sizeof *t->home);
    t->orbit = calloc(n * (size_t)sweep->options.longest, sizeof *t->orbit);
    t->tangent = calloc(n, sizeof *t->tangent);
    t->rng = gsl_rng_alloc(gsl_rng_mt19937);
    return saltus_settling_open(&t->settling, sweep->dimension, &sweep->options) && t->state && t->home &&
           t->orbit && t->tangent && t->rng;
}

void saltus_trajectory_close(saltus_trajectory *t) {
    saltus_settling_close(&t->settling);
    saltus_watch_close(&t->watch);
    saltus_watch_close(&t->round);
    saltus_system_free(t->system);
    free(t->state);
    free(t->home);
    free(t->orbit);
    free(t->tangent);
    if (t->rng)
        gsl_rng_free(t->rng);
    *t = (saltus_trajectory){0};
}

static long long point_of(const saltus_trajectory *t) {
    return saltus_sweep_task_place(t->sweep, t->job->task, t->place) % t->sweep->points;
}

static long long cycle_of(const saltus_trajectory *t) {
    return saltus_flow_time(t->flow, t->lane).cycle;
}

static bool measures_growth(const saltus_trajectory *t) {
    return t->sweep->options.keep & SALTUS_KEEP_LYAPUNOV;
}

/* Impacts, and other contact events, since the trajectory began. */
static saltus_flow_info information(const saltus_trajectory *t) {
    saltus_flow_info info = saltus_flow_information(t->flow, t->lane);
    info.impacts += t->before.impacts;
    info.sticks += t->before.sticks;
    info.releases += t->before.releases;
    return info;
}

/* To the next section point; in a transient that nobody looks at by many of them. */
static void aim(saltus_trajectory *t) {
    bool blind = t->stage == SALTUS_STAGE_TRANSIENT && !measures_growth(t);
    long long left = t->stage_end - cycle_of(t);
    saltus_time until = {cycle_of(t) + (!blind ? 1 : left < blind_periods ? left : blind_periods), 0};
    saltus_flow_aim(t->flow, t->lane, until, t->active ? saltus_watch_mask() : 0);
}

/* Go on from another state at the same time; the tangent vector stays. */
static bool continue_from(saltus_trajectory *t, const double *state) {
    saltus_time now = saltus_flow_time(t->flow, t->lane);
    t->before = information(t);
    if (saltus_flow_start(t->flow, t->lane, now, state, NULL) != SALTUS_OK)
        return false;
    if (measures_growth(t))
        saltus_flow_set_tangents(t->flow, t->lane, t->tangent);
    saltus_flow_state(t->flow, t->lane, t->state);
    return true;
}

static void see_section(saltus_trajectory *t) {
    saltus_flow_info info = information(t);
    saltus_settling_add(&t->settling, t->state, info.impacts, info.sticks + info.releases);
}

/* Keep the tangent vector at length one; a stage that measures adds up the logarithms. */
static void follow_growth(saltus_trajectory *t) {
    const double *scale = saltus_system_scale(t->system);
    double square = 0;
    saltus_flow_tangents(t->flow, t->lane, t->tangent);
    for (int i = 0; i < t->sweep->dimension; i++)
        square += (t->tangent[i] / scale[i]) * (t->tangent[i] / scale[i]);
    if (t->active == &t->watch)
        t->growth += 0.5 * log(square);
    for (int i = 0; i < t->sweep->dimension && square > 0; i++)
        t->tangent[i] /= sqrt(square);
    saltus_flow_set_tangents(t->flow, t->lane, t->tangent);
}

static void begin_watch(saltus_trajectory *t, saltus_watch *watch, long long periods) {
    bool touching = saltus_flow_contacts(t->flow, t->lane) != 0;
    t->active = watch;
    t->growth = 0;
    t->stage_end = cycle_of(t) + periods;
    saltus_watch_begin(watch, t->system, watch == &t->watch ? t->sweep->options.keep : 0,
                       saltus_flow_time(t->flow, t->lane), t->state, touching);
}

static void begin_recording(saltus_trajectory *t) {
    t->stage = SALTUS_STAGE_RECORDING;
    begin_watch(t, &t->watch, t->sweep->options.record);
}

static void begin_settling(saltus_trajectory *t) {
    const saltus_sweep_options *o = &t->sweep->options;
    t->stage = SALTUS_STAGE_SETTLING;
    t->active = NULL;
    t->waited = t->ask_again = 0;
    t->hoped = 0;
    t->patience = patience_periods;
    t->stage_end = o->adaptive ? o->transient : cycle_of(t) + settling_after_record;
}

static void forget_clouds(saltus_trajectory *t) {
    t->watch.turning.count = t->watch.strobes.count = t->watch.impacts.count = 0;
    t->watch.sound = true;
}

static void open_row(saltus_trajectory *t) {
    forget_clouds(t);
    t->row = (saltus_sweep_row){.verdict = SALTUS_ROW_FAILED,
                                .largest = NAN,
                                .smallest = NAN,
                                .impact_rate = NAN,
                                .largest_speed = NAN,
                                .contact_fraction = NAN,
                                .lyapunov = NAN};
}

void saltus_trajectory_refuse(saltus_trajectory *t) {
    open_row(t);
    for (int i = 0; i < t->sweep->dimension; i++)
        t->state[i] = NAN;
}

void saltus_trajectory_fail(saltus_trajectory *t) {
    long long settled = cycle_of(t);
    if (t->row.recorded == 0)
        saltus_trajectory_refuse(t);
    t->row.verdict = SALTUS_ROW_FAILED;
    t->row.settled = settled;
    t->row.periods = 0;
}

/* The state to begin a place with: carried on where there is one. */
static saltus_status find_start(saltus_trajectory *t, bool carried) {
    if (!carried)
        return saltus_sweep_initial(t->sweep, point_of(t), t->seed, t->system, t->rng, t->state, NULL);
    saltus_sweep_admit(t->system, t->state);
    return SALTUS_OK;
}

bool saltus_trajectory_start(saltus_trajectory *t, saltus_flow *flow, int lane) {
    const saltus_sweep_options *o = &t->sweep->options;
    bool carried = t->place > 0 && t->row.verdict != SALTUS_ROW_FAILED;
    t->flow = flow;
    t->lane = lane;
    t->active = NULL;
    t->disturbed = false;
    t->before = (saltus_flow_info){0};
    open_row(t);
    saltus_settling_reset(&t->settling, t->system);
    saltus_status status = find_start(t, carried);
    if (status != SALTUS_OK) {
        saltus_trajectory_refuse(t);
        t->starved = status == SALTUS_NO_MEMORY;
        return false;
    }
    if (saltus_flow_start(flow, lane, (saltus_time){0, 0}, t->state, NULL) != SALTUS_OK)
        return false;
    if (measures_growth(t))
        follow_growth(t);
    if (o->adaptive)
        begin_settling(t);
    else if (o->transient > 0) {
        t->stage = SALTUS_STAGE_TRANSIENT;
        t->stage_end = o->transient;
    } else
        begin_recording(t);
    see_section(t);
    aim(t);
    return true;
}

static void measure(saltus_trajectory *t) {
    saltus_time now = saltus_flow_time(t->flow, t->lane);
    saltus_watch_measure(&t->watch, now, &t->row);
    if (measures_growth(t))
        t->row.lyapunov = t->growth / ((double)t->row.recorded * saltus_system_period(t->system));
}

/* A verdict has been reached, or none will be. */
static void settle(saltus_trajectory *t, saltus_verdict_kind verdict, int periods) {
    t->row.verdict = verdict;
    t->row.periods = periods;
    t->row.settled = cycle_of(t);
    t->row.settled_impacts = information(t).impacts;
}

/* Once around the orbit; exponents need more. Returns false: the place is not over. */
static bool go_around(saltus_trajectory *t, int periods) {
    const saltus_sweep_options *o = &t->sweep->options;
    long long rounds = o->adaptive && measures_growth(t) ? (o->record + periods - 1) / periods : 1;
    settle(t, SALTUS_ROW_PERIODIC, periods);
    t->stage = SALTUS_STAGE_ORBIT;
    begin_watch(t, o->adaptive ? &t->watch : &t->round, rounds * periods);
    return false;
}

/* The verdict is not a period: recorded now, or over where it has been recorded. */
static bool end_settling(saltus_trajectory *t, saltus_verdict_kind verdict) {
    settle(t, verdict, 0);
    if (!t->sweep->options.adaptive)
        return true;
    begin_recording(t);
    return false;
}

static bool accept(saltus_trajectory *t, int periods) {
    const saltus_settling *s = &t->settling;
    size_t n = (size_t)s->n;
    for (int k = 0; k < periods; k++)
        memcpy(t->orbit + (size_t)k * n, s->points + (size_t)((s->count - periods + k) % s->size) * n,
               n * sizeof *t->orbit);
    return go_around(t, periods);
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
    saltus_sweep_seed(t->rng, t->sweep->options.seed, point_of(t), -1 - t->seed);
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
    t->home_cycle = cycle_of(t);
    t->disturbed = true;
    return continue_from(t, moved);
}

/* Whether the points of the last p periods come by where the trajectory was before it was disturbed, at the
 * same time of the orbit. */
static bool is_home(const saltus_trajectory *t, int periods) {
    const saltus_settling *s = &t->settling;
    int back = (int)((cycle_of(t) - t->home_cycle) % periods);
    const double *point = s->points + (size_t)((s->count - 1 - back) % s->size) * (size_t)s->n;
    return saltus_section_distance(t->system, point, t->home) < home_again;
}

/* Go on from a motion that has been found otherwise. */
static bool adopt(saltus_trajectory *t, const saltus_motion *motion) {
    if (!continue_from(t, motion->state)) {
        saltus_trajectory_fail(t);
        return true;
    }
    if (motion->kind != SALTUS_PERIODIC)
        return end_settling(t, motion->kind == SALTUS_HELD ? SALTUS_ROW_HELD : SALTUS_ROW_EQUILIBRIUM);
    memcpy(t->orbit, motion->section_states,
           (size_t)motion->periods * (size_t)t->sweep->dimension * sizeof *t->orbit);
    return go_around(t, motion->periods);
}

static saltus_classify_options polishing(const saltus_trajectory *t) {
    saltus_classify_options options = saltus_classify_defaults();
    options.flow.integrator = t->sweep->options.flow.integrator;
    options.transient = polish_periods;
    options.longest = t->sweep->options.longest;
    return options;
}

/* Let classification look at the present state. True when it has found something, `over` being what follows.
 */
static bool polish(saltus_trajectory *t, bool *over) {
    saltus_classify_options options = polishing(t);
    saltus_motion motion = {0};
    saltus_status status = saltus_classify(t->system, t->state, &options, &motion, NULL);
    bool found = status == SALTUS_OK && motion.kind != SALTUS_UNDECIDED;
    t->starved |= status == SALTUS_NO_MEMORY;
    if (found)
        *over = adopt(t, &motion);
    saltus_motion_clear(&motion);
    return found;
}

/* The stable orbit of a period at the present state, described; false where there is none. */
static bool stable_orbit(saltus_trajectory *t, int periods, saltus_motion *motion) {
    saltus_classify_options options = polishing(t);
    saltus_orbit_options shooting = saltus_motion_shooting(&options);
    saltus_orbit orbit = {0};
    saltus_status status = saltus_orbit_find(t->system, periods, t->state, &shooting, &orbit, NULL);
    bool own = status == SALTUS_OK && saltus_motion_orbit_stable(&orbit) &&
               saltus_section_distance(t->system, orbit.state, t->state) < same_orbit;
    if (own)
        status = saltus_motion_describe(t->system, &orbit, &options, motion, NULL);
    saltus_orbit_clear(&orbit);
    t->starved |= status == SALTUS_NO_MEMORY;
    return own && status == SALTUS_OK;
}

/* The period is in doubt: the stable orbit of the shortest part of it is the one. */
static bool resolve(saltus_trajectory *t, int periods, bool *over) {
    bool found = false;
    for (int part = 1; part <= periods && !found; part++) {
        saltus_motion motion = {0};
        found = periods % part == 0 && stable_orbit(t, part, &motion);
        if (found)
            *over = adopt(t, &motion);
        saltus_motion_clear(&motion);
    }
    return found;
}

/* Nothing recurs any more after a recording, or the time is over. */
static bool hopeless(const saltus_trajectory *t, int candidate) {
    const saltus_sweep_options *o = &t->sweep->options;
    if (cycle_of(t) >= t->stage_end)
        return true;
    return !o->adaptive && !candidate && t->settling.count > 2 * o->longest + 6;
}

/* Whether the recurrences of the period that is hoped for have shrunk, each time they were looked at. In a
 * small chaotic attractor something recurs for long, but no better. */
static bool shrinks(saltus_trajectory *t, int candidate) {
    double now = saltus_settling_recurrence(&t->settling, candidate);
    return now < shrinking * t->trend[0] && t->trend[0] < shrinking * t->trend[1];
}

static void follow_trend(saltus_trajectory *t, int candidate) {
    if (candidate != t->hoped) {
        t->waited = 0;
        t->trend[0] = t->trend[1] = 0;
    } else if (++t->waited % look_periods == 0) {
        t->trend[1] = t->trend[0];
        t->trend[0] = saltus_settling_recurrence(&t->settling, candidate);
    }
    t->hoped = candidate;
}

/* Ask Newton's method, when iteration is slow; more seldom each time. An orbit of very many impacts costs it
 * more than all the iteration does; that one is left to iteration. */
static bool ask(saltus_trajectory *t, int candidate, bool *over) {
    bool last = cycle_of(t) >= t->stage_end;
    if (!last && t->waited <= t->patience + patience_per_period * candidate)
        return false;
    if (!shrinks(t, candidate) || saltus_settling_impacts(&t->settling, candidate) > polish_impacts)
        return false;
    t->waited = 0;
    t->patience *= 2;
    return polish(t, over);
}

/* Ask it when iteration cannot tell the period. */
static bool ask_doubtful(saltus_trajectory *t, int period, bool *over) {
    if (cycle_of(t) < t->stage_end && cycle_of(t) < t->ask_again)
        return false;
    if (saltus_settling_impacts(&t->settling, period) > polish_impacts)
        return false;
    t->ask_again = cycle_of(t) + patience_per_period * period;
    return resolve(t, period, over);
}

/* A period has been reached to within `approach`, or, after the disturbance, to within what makes it certain:
 * disturb the trajectory, or see whether it has come back. One that has come to another place is disturbed
 * there anew. True when it is certain; the flow may fail. */
static bool proves(saltus_trajectory *t, int period, bool *failed) {
    if (t->disturbed && is_home(t, period))
        return true;
    *failed = !disturb(t);
    return false;
}

static int period_reached(const saltus_trajectory *t, bool *doubt) {
    return saltus_settling_period(&t->settling, t->disturbed ? t->settling.near : approach, doubt);
}

/* A system without forcing can only come to rest. */
static bool judge_rest(saltus_trajectory *t) {
    bool doubt, failed = false;
    if (period_reached(t, &doubt) == 1 && saltus_settling_rests(&t->settling) && proves(t, 1, &failed))
        return end_settling(t, saltus_flow_contacts(t->flow, t->lane) ? SALTUS_ROW_HELD
                                                                      : SALTUS_ROW_EQUILIBRIUM);
    if (failed)
        saltus_trajectory_fail(t);
    return failed || (cycle_of(t) >= t->stage_end && end_settling(t, SALTUS_ROW_UNDECIDED));
}

/* The next section point of a trajectory that settles; true when the place is over. */
static bool judge(saltus_trajectory *t) {
    bool over = false, doubt = false, failed = false;
    if (!saltus_system_forced(t->system))
        return judge_rest(t);
    int candidate = saltus_settling_candidate(&t->settling),
        period = candidate ? period_reached(t, &doubt) : 0;
    if (period && !doubt && proves(t, period, &failed))
        return accept(t, period);
    if (failed) {
        saltus_trajectory_fail(t);
        return true;
    }
    if (period && doubt && ask_doubtful(t, period, &over))
        return over;
    follow_trend(t, candidate);
    if (candidate && ask(t, candidate, &over))
        return over;
    return hopeless(t, candidate) ? end_settling(t, SALTUS_ROW_UNDECIDED) : false;
}

/* Counts of one orbit, when it has been gone around once. */
static void count_orbit(saltus_trajectory *t) {
    const saltus_tally *tally = &t->active->tally;
    t->row.impacts = tally->chatter ? -1 : (int)tally->impacts;
    t->row.sticking = tally->sticks;
    if (tally->events == 0 && saltus_flow_contacts(t->flow, t->lane)) {
        t->row.verdict = SALTUS_ROW_HELD;
        t->row.periods = 0;
    }
}

static bool recorded(saltus_trajectory *t) {
    measure(t);
    if (t->sweep->options.adaptive)
        return true;
    begin_settling(t);
    return judge(t);
}

/* A section point has been reached. */
static bool at_section(saltus_trajectory *t) {
    bool ends = cycle_of(t) >= t->stage_end;
    saltus_flow_state(t->flow, t->lane, t->state);
    for (int i = 0; i < t->sweep->dimension; i++)
        if (!(fabs(t->state[i]) < unbounded * saltus_system_scale(t->system)[i])) {
            saltus_trajectory_fail(t);
            return true;
        }
    if (measures_growth(t))
        follow_growth(t);
    if (t->stage != SALTUS_STAGE_ORBIT && t->stage != SALTUS_STAGE_TRANSIENT)
        see_section(t);
    if (t->active && !ends)
        saltus_watch_section(t->active, t->state);
    switch (t->stage) {
    case SALTUS_STAGE_TRANSIENT:
        if (ends)
            begin_recording(t);
        return false;
    case SALTUS_STAGE_SETTLING:
        return judge(t);
    case SALTUS_STAGE_RECORDING:
        return ends && recorded(t);
    default:
        if (cycle_of(t) == t->row.settled + t->row.periods)
            count_orbit(t);
        if (ends && t->active == &t->watch)
            measure(t);
        return ends;
    }
}

static void see_event(saltus_trajectory *t, const saltus_event *event) {
    if (event->kind != SALTUS_TURNING)
        saltus_flow_state(t->flow, t->lane, t->state);
    saltus_watch_event(t->active, event, t->state, saltus_flow_contacts(t->flow, t->lane) != 0);
}

bool saltus_trajectory_follow(saltus_trajectory *t, const saltus_event *event) {
    bool over = false;
    if (event->kind == SALTUS_REACHED)
        over = at_section(t);
    else
        see_event(t, event);
    if (!over)
        aim(t);
    return over;
}
