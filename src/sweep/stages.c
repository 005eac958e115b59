/* What a trajectory of a sweep goes through, from its start to its row.
 *
 * Adaptive: it settles until its period is certain and is then recorded once around the orbit, or, where no
 * period is certain in the time given, for a number of periods. Fixed: it runs and is recorded for given
 * numbers of periods; then it settles, if anything recurs, and goes once around its orbit to be counted.
 * Where exponents are asked for, an orbit's comes last, from its multipliers, and a motion without a period
 * is then measured (measure.c).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <math.h>

enum { blind_periods = 64, settling_after_record = 400 };

static bool measures_growth(const saltus_trajectory *t) {
    return t->sweep->options.keep & SALTUS_KEEP_LYAPUNOV;
}

/* To the next section point, or where the tangent vector is looked at; in a transient that nobody looks at by
 * many periods. */
static void aim(saltus_trajectory *t) {
    bool blind = t->stage == SALTUS_STAGE_TRANSIENT;
    long long left = t->stage_end - saltus_trajectory_cycle(t);
    saltus_time until = {saltus_trajectory_cycle(t) + (!blind                 ? 1
                                                       : left < blind_periods ? left
                                                                              : blind_periods),
                         0};
    if (t->stage == SALTUS_STAGE_MEASURING)
        saltus_growth_aim(&t->measuring.growth, t->flow, t->lane);
    else
        saltus_flow_aim(t->flow, t->lane, until, t->active ? saltus_watch_mask() : 0);
}

static void see_section(saltus_trajectory *t) {
    saltus_flow_info info = saltus_trajectory_information(t);
    saltus_settling_add(&t->settling, t->state, info.impacts, info.sticks + info.releases);
}

static void begin_watch(saltus_trajectory *t, saltus_watch *watch, long long periods) {
    bool touching = saltus_flow_contacts(t->flow, t->lane) != 0;
    t->active = watch;
    t->stage_end = saltus_trajectory_cycle(t) + periods;
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
    saltus_trajectory_begin_settling(t);
    t->stage_end = o->adaptive ? o->transient : saltus_trajectory_cycle(t) + settling_after_record;
}

static void forget_clouds(saltus_trajectory *t) {
    t->watch.turning.count = t->watch.strobes.count = t->watch.impacts.count = 0;
    t->watch.sound = true;
}

static void open_row(saltus_trajectory *t) {
    forget_clouds(t);
    t->row = saltus_sweep_row_of(SALTUS_FAILED);
}

void saltus_trajectory_refuse(saltus_trajectory *t) {
    open_row(t);
    for (int i = 0; i < t->sweep->dimension; i++)
        t->state[i] = NAN;
}

void saltus_trajectory_fail(saltus_trajectory *t) {
    long long settled = saltus_trajectory_cycle(t);
    if (t->stage == SALTUS_STAGE_MEASURING && t->measuring.given)
        return;
    if (t->row.recorded == 0)
        saltus_trajectory_refuse(t);
    t->row.verdict = SALTUS_FAILED;
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
    bool carried = t->place > 0 && t->row.verdict != SALTUS_FAILED;
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

/* The row is filled but for its exponent. */
static saltus_next end_place(saltus_trajectory *t) {
    bool settled = saltus_verdict_settled(t->row.verdict);
    if (!measures_growth(t) || (settled && saltus_trajectory_exponent(t)))
        return SALTUS_NEXT_DONE;
    t->measuring.given = settled;
    return t->sweep->options.measure > 0 ? SALTUS_NEXT_MEASURE : SALTUS_NEXT_DONE;
}

static saltus_next go_around(saltus_trajectory *t, int periods) {
    saltus_trajectory_settle(t, SALTUS_PERIODIC, periods);
    t->stage = SALTUS_STAGE_ORBIT;
    begin_watch(t, t->sweep->options.adaptive ? &t->watch : &t->round, periods);
    return SALTUS_NEXT_GO_ON;
}

/* The verdict is not a period: recorded now, or over where it has been recorded. */
static saltus_next end_settling(saltus_trajectory *t, saltus_verdict verdict) {
    saltus_trajectory_settle(t, verdict, 0);
    if (!t->sweep->options.adaptive)
        return end_place(t);
    begin_recording(t);
    return SALTUS_NEXT_GO_ON;
}

/* What it has settled on. */
static saltus_next act_on(saltus_trajectory *t, saltus_judgement judgement) {
    if (judgement.verdict == SALTUS_PERIODIC)
        return go_around(t, judgement.periods);
    if (judgement.verdict != SALTUS_FAILED)
        return end_settling(t, judgement.verdict);
    saltus_trajectory_fail(t);
    return SALTUS_NEXT_DONE;
}

/* The next section point of a trajectory that settles. */
static saltus_next settling_on(saltus_trajectory *t) {
    saltus_judgement judgement = saltus_trajectory_judge(t);
    bool hopeless =
        saltus_trajectory_cycle(t) >= t->stage_end || (!t->sweep->options.adaptive && judgement.recurs == 0 &&
                                                       t->settling.count > 2 * t->sweep->options.longest + 6);
    if (judgement.verdict != SALTUS_PENDING)
        return act_on(t, judgement);
    return hopeless ? end_settling(t, SALTUS_UNDECIDED) : SALTUS_NEXT_GO_ON;
}

/* The next section point of one that is measured: it may settle yet. */
static saltus_next measuring_on(saltus_trajectory *t) {
    saltus_judgement judgement = {.verdict = SALTUS_PENDING};
    if (!t->measuring.given)
        judgement = saltus_trajectory_judge(t);
    return judgement.verdict == SALTUS_PENDING ? saltus_measuring_add(t) : act_on(t, judgement);
}

/* Counts of one orbit, when it has been gone around. */
static void count_orbit(saltus_trajectory *t) {
    saltus_lap *lap = &t->active->lap;
    lap->contacts = saltus_flow_contacts(t->flow, t->lane);
    t->row.impacts = (int)saltus_lap_impacts(lap);
    t->row.sticking = saltus_lap_sticking(lap);
    if (saltus_lap_held(lap)) {
        t->row.verdict = SALTUS_HELD;
        t->row.periods = 0;
    }
}

static saltus_next orbit_done(saltus_trajectory *t) {
    count_orbit(t);
    if (t->active == &t->watch)
        saltus_watch_measure(&t->watch, saltus_flow_time(t->flow, t->lane), t->state, &t->row);
    return end_place(t);
}

static saltus_next recorded(saltus_trajectory *t) {
    saltus_watch_measure(&t->watch, saltus_flow_time(t->flow, t->lane), t->state, &t->row);
    if (t->sweep->options.adaptive)
        return end_place(t);
    begin_settling(t);
    return settling_on(t);
}

/* A section point has been reached. */
static saltus_next at_section(saltus_trajectory *t) {
    bool ends = saltus_trajectory_cycle(t) >= t->stage_end;
    saltus_flow_state(t->flow, t->lane, t->state);
    if (saltus_state_bounded(t->system, t->state, saltus_trajectory_cycle(t), NULL) != SALTUS_OK) {
        saltus_trajectory_fail(t);
        return SALTUS_NEXT_DONE;
    }
    if (t->stage != SALTUS_STAGE_ORBIT && t->stage != SALTUS_STAGE_TRANSIENT)
        see_section(t);
    if (t->active && !ends)
        saltus_watch_section(t->active, t->state);
    switch (t->stage) {
    case SALTUS_STAGE_TRANSIENT:
        if (ends)
            begin_recording(t);
        return SALTUS_NEXT_GO_ON;
    case SALTUS_STAGE_SETTLING:
        return settling_on(t);
    case SALTUS_STAGE_RECORDING:
        return ends ? recorded(t) : SALTUS_NEXT_GO_ON;
    case SALTUS_STAGE_MEASURING:
        return measuring_on(t);
    default:
        return ends ? orbit_done(t) : SALTUS_NEXT_GO_ON;
    }
}

static void see_event(saltus_trajectory *t, const saltus_event *event) {
    if (event->kind != SALTUS_TURNING)
        saltus_flow_state(t->flow, t->lane, t->state);
    saltus_watch_event(t->active, event, t->state, saltus_flow_contacts(t->flow, t->lane) != 0);
}

saltus_next saltus_trajectory_follow(saltus_trajectory *t, const saltus_event *event) {
    saltus_next next = SALTUS_NEXT_GO_ON;
    bool section = event->kind == SALTUS_REACHED;
    if (t->stage == SALTUS_STAGE_MEASURING)
        next = saltus_measuring_follow(t, event, &section);
    else if (!section)
        see_event(t, event);
    else
        saltus_trajectory_hand_back(t);
    if (next == SALTUS_NEXT_GO_ON && section)
        next = at_section(t);
    if (next == SALTUS_NEXT_GO_ON)
        aim(t);
    return next;
}
