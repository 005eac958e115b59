/* The stages of a trajectory of a sweep, from its start to its row.
 *
 * Adaptive: it settles until its period is certain and is then recorded once around the orbit, or, if no
 * period is certain in the given time, for a number of periods. Fixed: it runs and is recorded for given
 * numbers of periods; then it settles, if anything recurs, and goes once around its orbit to be counted and
 * measured. The disturbance that proves an orbit stable is tried at the end of a long transient, where it
 * costs nothing; a trajectory that does not return in time goes on from where it was, and is disturbed after
 * the record. One that does is not observed while it is recorded, and if in the end it is on no orbit all the
 * same, it is recorded again. If exponents are wanted, that of an orbit is computed last, from its
 * multipliers, and a motion without a period is then measured (measure.c).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <math.h>
#include <string.h>

enum {
    blind_periods = 64,
    proving_periods = 96,  /* an orbit reached in the first of these ... */
    reaching_periods = 32, /* ... is disturbed */
    settling_after_record = 400
};

static bool stage_ends(const saltus_sweep_trajectory *t) {
    return saltus_sweep_trajectory_cycle(t) >= t->stage_end;
}

/* Whether the observed displacement matters in the present stage. That of a proven orbit is measured on the
 * lap after the recording. */
static bool observes(const saltus_sweep_trajectory *t) {
    return t->active && (!t->proof.proven || t->active == &t->round || t->active->keep & SALTUS_KEEP_TURNING);
}

/* Events to watch in the present stage. */
static unsigned watched(const saltus_sweep_trajectory *t) {
    const unsigned turnings = observes(t) ? SALTUS_WATCH_TURNING : 0,
                   section = saltus_system_forced(t->system) ? 0 : saltus_crossings_watch(t->system);
    return t->active ? SALTUS_WATCH_CONTACT | turnings | section : section;
}

/* Without forcing turning points may be section points: there they are events. Where they are not kept, only
 * those count that extend the range of displacements. */
static saltus_turnings take_turnings(const saltus_sweep_trajectory *t) {
    saltus_turnings turnings = {.take = NULL};
    if (!observes(t) || !saltus_system_forced(t->system))
        return turnings;
    turnings.take = saltus_watch_turning;
    turnings.context = t->active;
    if (!(t->active->keep & SALTUS_KEEP_TURNING)) {
        turnings.low = &t->active->lap.smallest;
        turnings.high = &t->active->lap.largest;
    }
    return turnings;
}

/* Aim the lane at the next section point or orthonormalisation; in an unobserved transient many periods
 * ahead; on an unforced orbit at the end of the lap. */
static void aim(saltus_sweep_trajectory *t) {
    if (t->stage == SALTUS_STAGE_MEASURING) {
        saltus_growth_aim(&t->measuring.growth, t->flow, t->lane);
        return;
    }
    long long cycle = saltus_sweep_trajectory_cycle(t), left = t->stage_end - cycle, periods = 1;
    saltus_time until;
    if (t->stage == SALTUS_STAGE_TRANSIENT)
        periods = left < blind_periods ? left : blind_periods;
    if (t->stage == SALTUS_STAGE_ORBIT && !saltus_system_forced(t->system))
        until = (saltus_time){t->stage_end, t->active->begin.phase};
    else
        until = (saltus_time){cycle + periods, 0};
    saltus_flow_aim_observed(t->flow, t->lane, until, watched(t), take_turnings(t));
}

static void see_section(saltus_sweep_trajectory *t, const saltus_flow_info *done) {
    saltus_settling_add(&t->proof.settling, t->state, done->impacts, done->sticks + done->releases);
}

static void begin_watch(saltus_sweep_trajectory *t, saltus_watch *watch, long long periods, bool counts) {
    bool touching = saltus_flow_contacts(t->flow, t->lane) != 0;
    t->active = watch;
    t->stage_end = saltus_sweep_trajectory_cycle(t) + periods;
    saltus_watch_begin(watch, t->system, watch == &t->watch ? t->sweep->options.keep : 0, counts,
                       saltus_flow_time(t->flow, t->lane), t->state, touching,
                       saltus_sweep_trajectory_information(t).square);
}

/* Start to record a motion that is not an orbit. */
static saltus_next begin_recording(saltus_sweep_trajectory *t) {
    const bool rests = t->row.verdict == SALTUS_EQUILIBRIUM || t->row.verdict == SALTUS_HELD;
    bool counts = false;
    if (!saltus_system_forced(t->system) && !rests && !saltus_sweep_trajectory_count_returns(t, &counts)) {
        saltus_sweep_trajectory_fail(t);
        return SALTUS_NEXT_DONE;
    }
    t->stage = SALTUS_STAGE_RECORDING;
    begin_watch(t, &t->watch, t->sweep->options.record, counts);
    return SALTUS_NEXT_GO_ON;
}

static void begin_settling(saltus_sweep_trajectory *t) {
    const saltus_sweep_options *o = &t->sweep->options;
    t->stage = SALTUS_STAGE_SETTLING;
    t->active = NULL;
    saltus_sweep_trajectory_begin_settling(t);
    t->stage_end = o->adaptive ? o->transient : saltus_sweep_trajectory_cycle(t) + settling_after_record;
}

/* An empty row, without clouds. */
static void open_row(saltus_sweep_trajectory *t) {
    t->row = saltus_sweep_row_of(SALTUS_FAILED);
    t->watch.sound = true;
    for (int k = 0; k < SALTUS_CLOUDS; k++)
        t->watch.clouds[k].count = 0;
}

void saltus_sweep_trajectory_refuse(saltus_sweep_trajectory *t, saltus_verdict verdict) {
    open_row(t);
    t->row.verdict = (int)verdict;
    for (int i = 0; i < t->sweep->dimension; i++)
        t->state[i] = NAN;
}

void saltus_sweep_trajectory_fail(saltus_sweep_trajectory *t) {
    if (t->stage == SALTUS_STAGE_MEASURING && t->measuring.given)
        return;
    if (t->row.recorded == 0)
        saltus_sweep_trajectory_refuse(t, SALTUS_FAILED);
    t->row.verdict = SALTUS_FAILED;
    t->row.settled = saltus_sweep_trajectory_cycle(t);
    t->row.periods = 0;
}

/* The initial state at a place: the seed's, or, if `carried`, the present one, back within the stops. */
static saltus_status find_start(saltus_sweep_trajectory *t, bool carried, saltus_message *message) {
    const saltus_sweep *sweep = t->sweep;
    if (carried) {
        saltus_state_admit(t->system, t->state);
        return SALTUS_OK;
    }
    if (t->seed > 0) {
        saltus_sweep_trajectory_seed(t, t->seed);
        return saltus_state_random(t->system, saltus_random_rng(&t->random), t->state, NULL);
    }
    if (!sweep->moves_start)
        return saltus_scene_state(&sweep->scene, t->system, t->state, message);
    saltus_scene scene;
    saltus_status status = saltus_sweep_scene_at(sweep, saltus_sweep_trajectory_point(t), &scene, message);
    return status == SALTUS_OK ? saltus_scene_state(&scene, t->system, t->state, message) : status;
}

bool saltus_sweep_trajectory_start(saltus_sweep_trajectory *t, saltus_flow *flow, int lane) {
    const saltus_sweep_options *o = &t->sweep->options;
    const bool carried = t->place > 0 && !saltus_verdict_nothing((saltus_verdict)t->row.verdict);
    saltus_message why = {.cause = SALTUS_CAUSE_OTHER};
    t->flow = flow;
    t->lane = lane;
    t->active = NULL;
    t->before = (saltus_flow_info){0};
    t->effort = (saltus_effort){.period = saltus_system_period(t->system)};
    t->proof.disturbed = false;
    t->proof.proven = false;
    saltus_settling_reset(&t->proof.settling, t->system, o->flow.rtol);
    if (!saltus_system_forced(t->system))
        saltus_visits_reset(&t->proof.visits, t->system);
    open_row(t);
    saltus_status status = find_start(t, carried, &why);
    if (status != SALTUS_OK) {
        saltus_sweep_trajectory_refuse(t, why.cause == SALTUS_CAUSE_BEYOND ? SALTUS_BEYOND : SALTUS_FAILED);
        t->starved = status == SALTUS_NO_MEMORY;
        return false;
    }
    if (saltus_flow_start(flow, lane, (saltus_time){0, 0}, t->state, NULL) != SALTUS_OK)
        return false;
    if (o->adaptive)
        begin_settling(t);
    else if (o->transient > 0) {
        const bool proves = saltus_system_forced(t->system) && o->transient > 2 * proving_periods;
        t->stage = SALTUS_STAGE_TRANSIENT;
        t->stage_end = o->transient - (proves ? proving_periods : 0);
    } else if (begin_recording(t) != SALTUS_NEXT_GO_ON)
        return false;
    const saltus_flow_info done = saltus_sweep_trajectory_information(t);
    see_section(t, &done);
    aim(t);
    return true;
}

/* The row is filled but for its exponent: compute that, or have it measured. */
static saltus_next end_place(saltus_sweep_trajectory *t) {
    const saltus_sweep_options *o = &t->sweep->options;
    bool settled = saltus_verdict_settled(t->row.verdict);
    if (!(o->keep & SALTUS_KEEP_LYAPUNOV) || (settled && saltus_sweep_trajectory_exponent(t)))
        return SALTUS_NEXT_DONE;
    t->measuring.given = settled;
    return o->measure > 0 ? SALTUS_NEXT_MEASURE : SALTUS_NEXT_DONE;
}

/* Go once around the orbit of a row. With forcing it begins after the impacts in the very section, if there
 * are any, and ends after them. */
static saltus_next begin_lap(saltus_sweep_trajectory *t) {
    const bool forced = saltus_system_forced(t->system);
    double after[SALTUS_STATE_MAX];
    if (forced &&
        saltus_section_point(t->system, t->state, saltus_section_reach(t->sweep->options.flow.rtol), after,
                             NULL) &&
        !saltus_sweep_trajectory_continue(t, after)) {
        saltus_sweep_trajectory_fail(t);
        return SALTUS_NEXT_DONE;
    }
    t->stage = SALTUS_STAGE_ORBIT;
    begin_watch(t, t->sweep->options.adaptive ? &t->watch : &t->round, t->row.periods, !forced);
    return SALTUS_NEXT_GO_ON;
}

/* Act on a verdict: go once around an orbit; record anything else now, or end if it has been recorded and
 * measured. */
static saltus_next act_on(saltus_sweep_trajectory *t, saltus_judgement judgement) {
    const bool adaptive = t->sweep->options.adaptive;
    if (judgement.verdict == SALTUS_FAILED) {
        saltus_sweep_trajectory_fail(t);
        return SALTUS_NEXT_DONE;
    }
    if (judgement.verdict == SALTUS_PERIODIC) {
        saltus_sweep_trajectory_settle(t, SALTUS_PERIODIC, judgement.periods);
        return begin_lap(t);
    }
    saltus_sweep_trajectory_settle(t, judgement.verdict, 0);
    if (!adaptive && !t->proof.proven)
        return end_place(t);
    t->proof.proven = false;
    return begin_recording(t);
}

/* Section points since the start or the last disturbance, which may carry an orbit near grazing far away. */
static long long points_seen(const saltus_sweep_trajectory *t) {
    const saltus_proof *p = &t->proof;
    if (!saltus_system_forced(t->system))
        return p->visits.settling.count;
    return p->disturbed ? saltus_sweep_trajectory_cycle(t) - p->disturbed_at : p->settling.count;
}

/* Judge a settling trajectory at a section point. In a sweep with fixed times a motion that does not recur
 * soon is not waited for. */
static saltus_next settling_on(saltus_sweep_trajectory *t) {
    saltus_judgement judgement = saltus_sweep_trajectory_judge(t);
    bool hopeless = stage_ends(t) || (!t->sweep->options.adaptive && judgement.recurs == 0 &&
                                      points_seen(t) > 2 * t->sweep->options.longest + 6);
    if (judgement.verdict == SALTUS_PENDING && !hopeless)
        return SALTUS_NEXT_GO_ON;
    if (judgement.verdict == SALTUS_PENDING)
        judgement.verdict = SALTUS_IRREGULAR;
    return act_on(t, judgement);
}

/* Fill the row with the measures of what has just been gone through; `recorded` are the clouds' periods. */
static void measure(saltus_sweep_trajectory *t) {
    const long long recorded = t->row.recorded;
    saltus_watch_measure(t->active, saltus_flow_time(t->flow, t->lane), t->state,
                         saltus_sweep_trajectory_information(t).square, &t->row);
    if (t->active == &t->round)
        t->row.recorded = recorded;
}

/* The lap around the orbit is complete. */
static saltus_next orbit_done(saltus_sweep_trajectory *t) {
    saltus_lap *lap = &t->active->lap;
    saltus_event passed[SALTUS_FACES_MAX];
    lap->contacts = saltus_flow_contacts(t->flow, t->lane);
    const int count =
        saltus_system_forced(t->system)
            ? saltus_section_point(t->system, t->state, saltus_section_reach(t->sweep->options.flow.rtol),
                                   t->state, passed)
            : 0;
    for (int k = 0; k < count; k++) {
        passed[k].time.cycle += saltus_sweep_trajectory_cycle(t);
        saltus_watch_event(t->active, &passed[k], t->state, lap->contacts != 0);
    }
    t->row.impacts = (int)saltus_lap_impacts(lap);
    t->row.sticking = saltus_lap_sticking(lap);
    if (saltus_lap_held(lap)) {
        t->row.verdict = SALTUS_HELD;
        t->row.periods = 0;
    }
    measure(t);
    if (t->row.periods > 0)
        t->row.period = t->row.periods * saltus_system_period(t->system);
    if (!saltus_system_forced(t->system)) { /* back onto the section */
        memcpy(t->state, t->proof.orbit, (size_t)t->sweep->dimension * sizeof *t->state);
        if (t->row.periods > 0)
            saltus_watch_orbit(t->active, t->proof.orbit, t->row.periods);
    }
    return end_place(t);
}

/* The transient is over, or so much of it that an orbit may be disturbed. */
static saltus_next transient_done(saltus_sweep_trajectory *t, const saltus_flow_info *done) {
    const bool over = t->stage_end == t->sweep->options.transient;
    saltus_settling_reset(&t->proof.settling, t->system, t->sweep->options.flow.rtol);
    if (over)
        return begin_recording(t);
    t->stage = SALTUS_STAGE_PROVING;
    t->stage_end = t->sweep->options.transient;
    see_section(t, done);
    return SALTUS_NEXT_GO_ON;
}

/* Disturb an orbit that is reached in time; once it is proven stable, or there is no more time, the transient
 * goes on. */
static saltus_next proving(saltus_sweep_trajectory *t, const saltus_flow_info *done) {
    const saltus_judgement judgement = saltus_sweep_trajectory_judge(t);
    const long long left = t->stage_end - saltus_sweep_trajectory_cycle(t);
    const bool pending = judgement.verdict == SALTUS_PENDING, disturbed = t->proof.disturbed;
    if (pending && left > (disturbed ? 0 : proving_periods - reaching_periods))
        return SALTUS_NEXT_GO_ON;
    t->stage = SALTUS_STAGE_TRANSIENT;
    t->proof.proven = judgement.verdict == SALTUS_PERIODIC;
    if (judgement.verdict == SALTUS_FAILED || (pending && disturbed && !saltus_sweep_trajectory_go_back(t))) {
        saltus_sweep_trajectory_fail(t);
        return SALTUS_NEXT_DONE;
    }
    return stage_ends(t) ? transient_done(t, done) : SALTUS_NEXT_GO_ON;
}

static saltus_next recorded(saltus_sweep_trajectory *t) {
    if (t->proof.proven)
        t->row.recorded = t->sweep->options.record;
    else
        measure(t);
    if (t->sweep->options.adaptive)
        return end_place(t);
    begin_settling(t);
    return settling_on(t);
}

/* Whether to give up, as a classification would: unbounded state, excessive pre-load, far too many steps.
 * saltus_state_bounded checks the load only after eight periods, where an unobserved transient does not
 * stop. */
static bool gives_up(const saltus_sweep_trajectory *t, long long steps) {
    const long long cycle = saltus_sweep_trajectory_cycle(t);
    const unsigned contacts = saltus_flow_contacts(t->flow, t->lane);
    return saltus_state_bounded(t->system, t->state, contacts, cycle, NULL) != SALTUS_OK ||
           (t->stage == SALTUS_STAGE_TRANSIENT &&
            saltus_state_load(t->system, t->state, contacts, NULL) != SALTUS_OK) ||
           t->effort.spent > SALTUS_EFFORT_MOST || steps - SALTUS_EFFORT_USUAL * cycle > SALTUS_EFFORT_MOST;
}

/* Process a section point, according to the stage. */
static saltus_next at_section(saltus_sweep_trajectory *t) {
    const bool ends = stage_ends(t);
    const saltus_flow_info done = saltus_sweep_trajectory_information(t);
    saltus_flow_state(t->flow, t->lane, t->state);
    if (gives_up(t, done.steps)) {
        saltus_sweep_trajectory_fail(t);
        return SALTUS_NEXT_DONE;
    }
    if (t->stage != SALTUS_STAGE_ORBIT && t->stage != SALTUS_STAGE_TRANSIENT)
        see_section(t, &done);
    if (t->active && !ends)
        saltus_watch_section(t->active, t->state);
    switch (t->stage) {
    case SALTUS_STAGE_TRANSIENT:
        return ends ? transient_done(t, &done) : SALTUS_NEXT_GO_ON;
    case SALTUS_STAGE_PROVING:
        return proving(t, &done);
    case SALTUS_STAGE_SETTLING:
        return settling_on(t);
    case SALTUS_STAGE_RECORDING:
        return ends ? recorded(t) : SALTUS_NEXT_GO_ON;
    case SALTUS_STAGE_MEASURING: {
        /* It may still settle. */
        saltus_judgement judgement = {.verdict = SALTUS_PENDING};
        if (!t->measuring.given)
            judgement = saltus_sweep_trajectory_judge(t);
        return judgement.verdict == SALTUS_PENDING ? saltus_measuring_add(t) : act_on(t, judgement);
    }
    default:
        return ends ? orbit_done(t) : SALTUS_NEXT_GO_ON;
    }
}

/* Pass an event, a reached target included, to whatever observes it. */
static void pass_event(saltus_sweep_trajectory *t, const saltus_event *event) {
    const bool forced = saltus_system_forced(t->system), reached = event->kind == SALTUS_REACHED;
    if (!forced || !reached)
        saltus_flow_state(t->flow, t->lane, t->state);
    if (!forced && t->stage != SALTUS_STAGE_ORBIT)
        saltus_sweep_trajectory_take(t, event);
    if (!forced && t->active)
        saltus_watch_returns(t->active, t->flow, t->lane, event, t->state);
    if (t->active && !reached && event->kind != SALTUS_STEP)
        saltus_watch_event(t->active, event, t->state, saltus_flow_contacts(t->flow, t->lane) != 0);
}

saltus_next saltus_sweep_trajectory_follow(saltus_sweep_trajectory *t, const saltus_event *event) {
    saltus_next next = SALTUS_NEXT_GO_ON;
    bool section = event->kind == SALTUS_REACHED;
    if (t->stage == SALTUS_STAGE_MEASURING)
        next = saltus_measuring_follow(t, event, &section);
    else
        pass_event(t, event);
    if (t->stage != SALTUS_STAGE_MEASURING && section)
        saltus_sweep_trajectory_restore_tangent(t);
    if (next == SALTUS_NEXT_GO_ON && section)
        next = at_section(t);
    if (next == SALTUS_NEXT_GO_ON)
        aim(t);
    return next;
}
