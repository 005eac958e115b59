/* One trajectory of a sweep, from its start to its row.
 *
 * Adaptive: it settles until its period is certain and is then recorded once around the orbit, or, where no
 * period is certain in the time given, for a number of periods. Fixed: it runs and is recorded for given
 * numbers of periods; then it settles, if anything recurs, and goes once around its orbit to be counted.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { blind_periods = 64, settling_after_record = 400 };

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

long long saltus_trajectory_point(const saltus_trajectory *t) {
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

bool saltus_trajectory_continue(saltus_trajectory *t, const double *state) {
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
    saltus_trajectory_hope(t);
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
        return saltus_sweep_initial(t->sweep, saltus_trajectory_point(t), t->seed, t->system, t->rng,
                                    t->state, NULL);
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

/* The next section point of a trajectory that settles; true when the place is over. */
static bool settling_on(saltus_trajectory *t) {
    saltus_judgement judgement = saltus_trajectory_judge(t);
    bool hopeless = cycle_of(t) >= t->stage_end || (!t->sweep->options.adaptive && judgement.recurs == 0 &&
                                                    t->settling.count > 2 * t->sweep->options.longest + 6);
    if (judgement.verdict == SALTUS_ROW_FAILED) {
        saltus_trajectory_fail(t);
        return true;
    }
    if (judgement.verdict == SALTUS_ROW_PERIODIC)
        return go_around(t, judgement.periods);
    if (judgement.verdict != SALTUS_ROW_PENDING)
        return end_settling(t, judgement.verdict);
    return hopeless && end_settling(t, SALTUS_ROW_UNDECIDED);
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
    return settling_on(t);
}

/* A section point has been reached. */
static bool at_section(saltus_trajectory *t) {
    bool ends = cycle_of(t) >= t->stage_end;
    saltus_flow_state(t->flow, t->lane, t->state);
    if (saltus_motion_bounded(t->system, t->state, cycle_of(t), NULL) != SALTUS_OK) {
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
        return settling_on(t);
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
