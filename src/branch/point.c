/* Points of a branch as they are given out.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/point.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const saltus_word saltus_point_words[] = {{"regular", SALTUS_POINT_REGULAR},
                                          {"LP", SALTUS_POINT_LP},
                                          {"PD", SALTUS_POINT_PD},
                                          {"NS", SALTUS_POINT_NS},
                                          {"BP", SALTUS_POINT_BP},
                                          {"GR", SALTUS_POINT_GR},
                                          {"CH", SALTUS_POINT_CH},
                                          {"ST", SALTUS_POINT_ST},
                                          {"UZ", SALTUS_POINT_UZ},
                                          {"EP", SALTUS_POINT_EP},
                                          {"HB", SALTUS_POINT_HB},
                                          {"BE", SALTUS_POINT_BE},
                                          {"CP", SALTUS_POINT_CP},
                                          {"GR-LP", SALTUS_POINT_GR_LP},
                                          {"GR-PD", SALTUS_POINT_GR_PD},
                                          {"GR-NS", SALTUS_POINT_GR_NS},
                                          {"GR-GR", SALTUS_POINT_GR_GR},
                                          {"GR-BP", SALTUS_POINT_GR_BP},
                                          {"CH-GR", SALTUS_POINT_CH_GR},
                                          {"R1", SALTUS_POINT_R1},
                                          {"R2", SALTUS_POINT_R2},
                                          {"R3", SALTUS_POINT_R3},
                                          {"R4", SALTUS_POINT_R4},
                                          {"BT", SALTUS_POINT_BT},
                                          {"GH", SALTUS_POINT_GH},
                                          {"GPD", SALTUS_POINT_GPD},
                                          {"LP-PD", SALTUS_POINT_LP_PD},
                                          {"PD-NS", SALTUS_POINT_PD_NS},
                                          {NULL, 0}};

const char *saltus_point_word(saltus_point_kind kind) {
    const char *word = kind ? saltus_word_of(saltus_point_words, (int)kind) : NULL;
    return word ? word : "";
}

void saltus_branch_point_clear(saltus_branch_point *point) {
    free(point->state);
    free(point->events);
    free(point->multipliers);
    *point = (saltus_branch_point){0};
}

bool saltus_point_open(saltus_branch_point *point, int dimension, int events) {
    const size_t n = (size_t)dimension;
    *point = (saltus_branch_point){.value = {NAN, NAN},
                                   .period = NAN,
                                   .dimension = dimension,
                                   .lyapunov_coefficient = NAN,
                                   .grazing_time = NAN,
                                   .contact_force = NAN,
                                   .state = calloc(n, sizeof *point->state),
                                   .events = calloc((size_t)events + 1, sizeof *point->events),
                                   .multipliers = calloc(n, sizeof *point->multipliers)};
    if (point->state && point->events && point->multipliers)
        return true;
    saltus_branch_point_clear(point);
    return false;
}

saltus_status saltus_branch_point_copy(const saltus_branch_point *point, saltus_branch_point *copy,
                                       saltus_message *message) {
    const size_t n = (size_t)point->dimension, events = (size_t)point->event_count;
    if (!saltus_point_open(copy, point->dimension, point->event_count))
        return saltus_branch_no_memory(message);
    saltus_branch_point own = *point;
    own.state = memcpy(copy->state, point->state, n * sizeof *own.state);
    own.events = copy->events;
    if (events)
        memcpy(own.events, point->events, events * sizeof *own.events);
    own.multipliers = memcpy(copy->multipliers, point->multipliers, n * sizeof *own.multipliers);
    *copy = own;
    return SALTUS_OK;
}

/* Shift event times into one orbit from section phase 0, and sort the events. */
static void fold_events(saltus_event *events, int count, int periods) {
    for (int k = 0; k < count; k++)
        events[k].time.cycle = ((events[k].time.cycle % periods) + periods) % periods;
    for (int k = 1; k < count; k++)
        for (int j = k;
             j > 0 && saltus_time_periods(events[j].time) < saltus_time_periods(events[j - 1].time); j--)
            SALTUS_SWAP(events[j], events[j - 1]);
}

/* Whether an event of the flow lies in a stretch that the marks leave to the flow. */
static bool is_left_to_flow(const saltus_sequence *s, const saltus_event *event) {
    const double close = 1e-6 * s->periods, time = saltus_time_periods(event->time);
    const bool release = event->kind == SALTUS_RELEASE;
    bool driven = s->driven;
    for (int k = 0; k < s->count && s->mark[k].time < time + close; k++) {
        const saltus_mark *mark = &s->mark[k];
        if (event->face == mark->face && release == (mark->kind == SALTUS_RELEASE) &&
            fabs(time - mark->time) < close)
            return false;
        driven = mark->driven;
    }
    return driven;
}

/* The events that the marks prescribe, including impacts of zero speed, which the flow sees only by chance,
 * and those that the marks leave to the flow. If the flow fails to go around, a contact to which these lead
 * counts as chatter. */
static void prescribed_events(saltus_orbits *o, const saltus_solution *s, saltus_branch_point *point) {
    const saltus_survey *survey = &s->survey;
    double speed[SALTUS_MARKS_MAX];
    bool driven = s->sequence.driven;
    saltus_lap lap = {0};
    /* The flow that has surveyed the orbit may have done so a little aside. */
    saltus_orbits_noted(o, saltus_orbits_tune(o, s->parameter, s->sequence.omega, NULL));
    saltus_lap_begin(&lap, o->system, s->state);
    saltus_solution_speeds(o, s, speed);
    for (int k = 0; k < s->sequence.count; k++) {
        const saltus_mark *mark = &s->sequence.mark[k];
        double whole = floor(mark->time);
        saltus_face face = saltus_system_face(o->system, mark->face);
        saltus_event event = {.kind = mark->kind,
                              .face = mark->face,
                              .time = {(long long)whole, mark->time - whole},
                              .velocity_before = face.side * speed[k],
                              .displacement = face.side * face.d};
        if (mark->kind == SALTUS_IMPACT)
            event.velocity_after =
                -face.side * saltus_system_restitution(o->system, mark->face, speed[k]) * speed[k];
        saltus_lap_add(&lap, &event, s->state);
        lap.impacts += mark->kind != SALTUS_RELEASE && !saltus_event_strikes(&event);
        driven |= mark->driven;
        point->events[point->event_count++] = event;
    }
    for (int k = 0; k < survey->lap.event_count && driven && survey->walked; k++)
        if (is_left_to_flow(&s->sequence, &survey->lap.events[k])) {
            saltus_lap_add(&lap, &survey->lap.events[k], s->state);
            point->events[point->event_count++] = survey->lap.events[k];
        }
    const bool chatter = driven && !survey->walked && lap.rebounding_contact;
    point->impacts = chatter ? -1 : saltus_lap_impacts(&lap);
    point->sticking_intervals = saltus_lap_sticking(&lap);
    saltus_orbit_label(point->impacts, s->sequence.periods, point->label);
}

/* The smallest contact force, as the flow gives it, over an orbit that is in contact all the time: at its
 * base and at minima on the way; NAN for others. Errors: those of the flow. */
static saltus_status find_contact_force(saltus_orbits *o, const saltus_solution *s, double *force) {
    const saltus_sequence *q = &s->sequence;
    double forces[SALTUS_FACES_MAX];
    *force = NAN;
    if (q->contacts == 0 || q->count > 0 || q->driven)
        return SALTUS_OK;
    saltus_status status = saltus_orbits_tune(o, s->parameter, q->omega, NULL);
    if (status == SALTUS_OK)
        status = saltus_flow_place(o->flow, 0, saltus_time_of(q->base), s->state, q->contacts, NULL);
    if (status != SALTUS_OK)
        return status;
    saltus_flow_forces(o->flow, 0, forces);
    for (int f = 0; f < saltus_system_face_count(o->system); f++)
        if (q->contacts >> f & 1)
            *force = fmin(*force, forces[f]);
    for (int k = 0; k < s->breach_count; k++) {
        const saltus_breach *b = &s->breaches[k];
        if (b->kind == SALTUS_BREACH_FORCE)
            *force =
                fmin(*force, -b->value * o->shooting->force / saltus_system_compliance(o->system, b->face));
    }
    return SALTUS_OK;
}

double saltus_point_time(const saltus_solution *s, const saltus_cycle_count *count, double time) {
    const double close = 1e-9; /* to the state, which counts as the state's */
    if (count->returns < 0)
        return time;
    const double since = (time - s->sequence.base) / s->sequence.periods - count->first;
    return fmax(0, since - floor(since + close));
}

/* An orbit whose period is an unknown is reported from its highest maximum on. If the flow does not follow
 * it, its events are reported as prescribed. */
static void from_maximum(saltus_orbits *o, const saltus_solution *s, bool found, saltus_branch_point *point,
                         saltus_cycle_count *count) {
    saltus_lap lap = {.keeps_events = true};
    saltus_spec_set_omega(&point->spec, 2 * M_PI / point->period);
    if (saltus_cycle_around(o, s, &lap)) {
        *count = (saltus_cycle_count){lap.returns, lap.first};
        point->periods = lap.periods;
        memcpy(point->state, lap.points, (size_t)o->n * sizeof *point->state);
        if (found && lap.event_count == point->event_count && lap.event_count)
            memcpy(point->events, lap.events, (size_t)lap.event_count * sizeof *point->events);
        for (int k = 0; k < point->event_count && !found; k++)
            point->events[k].time =
                saltus_time_of(saltus_point_time(s, count, saltus_time_periods(point->events[k].time)));
        fold_events(point->events, point->event_count, point->periods);
        saltus_orbit_label(point->impacts, point->periods, point->label);
    } else {
        point->label[0] = 0; /* the returns are not known */
    }
    saltus_lap_close(&lap);
}

void saltus_point_take_multipliers(const saltus_solution *s, saltus_branch_point *point) {
    const saltus_survey *survey = &s->survey;
    point->multiplier_count = survey->multiplier_count;
    point->trivial_multiplier = s->sequence.omega > 0 ? survey->trivial : 0;
    point->unstable = survey->unstable;
    point->stable = saltus_multipliers_stable(survey->multipliers, survey->multiplier_count);
    point->log_volume = survey->log_volume;
    point->sum_rule = survey->sum_rule;
    memcpy(point->multipliers, survey->multipliers, (size_t)point->dimension * sizeof *point->multipliers);
}

bool saltus_point_make(saltus_orbits *o, const saltus_solution *s, bool prescribed,
                       saltus_branch_point *point, saltus_cycle_count *count) {
    const saltus_survey *survey = &s->survey;
    const int seen = survey->lap.event_count, periods = s->sequence.periods;
    const bool found = survey->follows && !prescribed;
    const double section = ceil(s->sequence.base / periods) * periods;
    /* What the rounded unknown lacks to the solution's value, which is exact on a border of the range. */
    const double rest = s->value - (o->origin + o->family.unit[0] * s->parameter[0]);
    const saltus_spec spec = saltus_family_spec(&o->family, s->parameter, s->sequence.omega);
    const size_t state_bytes = (size_t)o->n * sizeof *point->state;
    *count = (saltus_cycle_count){.returns = -1};
    const bool room = saltus_point_open(point, o->n, found ? seen : seen + s->sequence.count);
    o->starved |= !room;
    if (!room)
        return false;
    point->value[0] = s->value;
    point->heading = saltus_solution_heading(s) * o->family.unit[0];
    point->spec = saltus_spec_shifted(&spec, &o->family.direction[0], rest);
    point->periods = periods;
    point->period = periods * 2 * M_PI / saltus_spec_omega(&spec);
    saltus_point_take_multipliers(s, point);
    point->admissible = survey->follows;
    point->residual = s->at.residual;
    point->iterations = s->at.iterations;
    /* If chatter is left to the flow the prescribed path may not lead to the section: then take the flow's
     * state nearby. */
    if (found || saltus_solution_state_at(o, s, section, point->state, NULL) != SALTUS_OK)
        memcpy(point->state, survey->lap.points, state_bytes);
    saltus_orbits_noted(o, find_contact_force(o, s, &point->contact_force));
    if (!found) {
        prescribed_events(o, s, point);
    } else {
        point->impacts = survey->impacts;
        point->sticking_intervals = survey->sticking_intervals;
        point->event_count = seen;
        memcpy(point->label, survey->label, sizeof point->label);
        if (seen) /* a lap without events has no memory for any */
            memcpy(point->events, survey->lap.events, (size_t)seen * sizeof *point->events);
    }
    fold_events(point->events, point->event_count, periods);
    if (s->sequence.omega > 0)
        from_maximum(o, s, found, point, count);
    return true;
}

void saltus_point_mark_grazing(const saltus_system *system, const saltus_breach *breach,
                               saltus_branch_point *point) {
    saltus_face face = saltus_system_face(system, breach->face);
    double time = point->periods ? fmod(breach->time, point->periods) : 0;
    if (time < 0)
        time += point->periods;
    /* A sum just below zero may round to the whole. */
    point->grazing_time = time < point->periods ? time : 0;
    point->grazing_stop = face.stop + 1;
    point->grazing_side = face.side;
}
