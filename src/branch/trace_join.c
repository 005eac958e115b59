/* Where branches of periodic orbits join others: at the flip of orbits of half the period, where orbits that
 * are their own mirror images lose their symmetry, or at the grazing of either. The branch ends there. The
 * one that it joins is followed both ways, unless it has been followed there, or comes to be before its turn.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/sequence.h"
#include "branch/trace.h"
#include "orbit/lap.h"
#include "orbit/sequence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double period_of(const saltus_orbits *o, const saltus_sequence *s, double parameter) {
    const saltus_spec spec = saltus_family_spec(&o->family, &parameter, s->omega);
    return s->periods * 2 * M_PI / saltus_spec_omega(&spec);
}

void saltus_trace_drop_starts(saltus_trace *t) {
    const saltus_branch_point *point = saltus_trail_last(t->trail);
    for (int k = t->starts->count - 1; k >= 0; k--) {
        const saltus_branch_start *start = &t->starts->start[k];
        double value = t->orbits.origin + t->orbits.family.unit[0] * start->parameter[0];
        const double period = period_of(&t->orbits, &start->sequence, start->parameter[0]);
        if (start->place == 0 && start->origin == point->kind &&
            saltus_trail_same_period(period, point->period) &&
            fabs(value - point->value[0]) < 1e-7 * t->orbits.family.unit[0])
            saltus_starts_remove(t->starts, k);
    }
}

bool saltus_trace_joins_images(saltus_trace *t, const saltus_solution *at) {
    const double little = 1e-6, near = 1e-4, mirrored = 1e-7;
    const double half = 0.5 * at->sequence.periods;
    bool joins = false;
    for (int k = 0; k < at->breach_count; k++) {
        const saltus_breach *touch = &at->breaches[k];
        bool dies = false, alone = true;
        for (int j = 0; j < at->breach_count; j++) {
            const saltus_breach *impact = &at->breaches[j];
            const double apart = fabs(impact->time - touch->time);
            if (impact->kind != SALTUS_BREACH_SPEED)
                continue;
            alone = alone && !(impact->face == touch->face && apart < near);
            dies |= impact->face != touch->face && fabs(apart - half) < near && fabs(impact->value) < little;
        }
        joins |= touch->kind == SALTUS_BREACH_GAP && fabs(touch->value) < little && dies && alone;
    }
    const double before = joins ? saltus_solution_part_distance(&t->orbits, t->here, 1, NULL) : 0;
    return before > mirrored &&
           saltus_orbits_join(&t->orbits, before, saltus_solution_part_distance(&t->orbits, at, 1, NULL),
                              at->at.ahead);
}

int saltus_trace_parts(saltus_trace *t, const saltus_solution *at) {
    saltus_orbits *o = &t->orbits;
    int parts = 1;
    for (int factor = 2, left = at->sequence.periods; factor <= left; factor++)
        for (bool joins = true; left % factor == 0; left /= factor) {
            const int finer = parts * factor;
            joins =
                joins && saltus_orbits_join(o, saltus_solution_part_distance(o, t->here, finer, NULL),
                                            saltus_solution_part_distance(o, at, finer, NULL), at->at.ahead);
            parts = joins ? finer : parts;
        }
    return parts;
}

const saltus_breach *saltus_trace_touch(const saltus_solution *at, int parts) {
    const double little = 1e-9, near = 1e-4, periods = at->sequence.periods;
    const saltus_breach *touch = &at->worst;
    for (int k = 0; k < at->breach_count && parts > 1; k++) {
        const saltus_breach *other = &at->breaches[k];
        const bool again = fabs(remainder(other->time - touch->time, periods / parts)) < near;
        if (again && fabs(other->value) < little && fmod(other->time, periods) < fmod(touch->time, periods))
            touch = other;
    }
    return touch;
}

bool saltus_trace_same_orbit(saltus_trace *t, const saltus_solution *s, const saltus_lap *lap) {
    saltus_lap own = {0};
    const bool same =
        saltus_solution_section(&t->orbits, s, s->survey.lap.points, &own) &&
        saltus_orbit_passes(t->orbits.system, lap->points, lap->periods, own.points, SALTUS_SAME_POINT);
    saltus_lap_close(&own);
    return same;
}

bool saltus_trace_was_joined(saltus_trace *t, const saltus_solution *s, saltus_point_kind kind, double value,
                             int *other) {
    saltus_lap lap = {0};
    const int place = saltus_solution_section(&t->orbits, s, s->survey.lap.points, &lap)
                          ? saltus_trail_find(t->trail, t->orbits.system, kind,
                                              period_of(&t->orbits, &s->sequence, s->parameter[0]), value,
                                              lap.points, lap.periods, true, other)
                          : 0;
    saltus_lap_close(&lap);
    /* With one start left that one leads back here, and the other has led on. */
    if (place && saltus_starts_drop(t->starts, place) == 2)
        *other = -1;
    return place > 0;
}

/* Add starts on the branch joined at a place where it has not been followed. `start` has what they have in
 * common; they differ in the tangent's direction or, at grazing, in the sequence, of which there are two. */
static void add_joined(saltus_trace *t, const saltus_solution *orbit, saltus_branch_start *start,
                       const saltus_sequence *sequences, double value) {
    saltus_lap lap = {0};
    saltus_orbits *o = &t->orbits;
    const double period = period_of(o, &start->sequence, start->parameter[0]);
    if (saltus_solution_section(o, orbit, orbit->survey.lap.points, &lap) &&
        !saltus_trail_find(t->trail, o->system, start->origin, period, value, lap.points, lap.periods, false,
                           NULL)) {
        start->place =
            saltus_trail_join(t->trail, o->system, start->origin, period, value, lap.points, &o->starved);
        if (!sequences)
            saltus_starts_add_ways(t->starts, start, 0, &o->starved);
        for (int k = 0; k < 2 && sequences; k++) {
            start->sequence = sequences[k];
            saltus_starts_add(t->starts, start, &o->starved);
        }
    }
    saltus_lap_close(&lap);
}

bool saltus_trace_joins_part(saltus_trace *t, const saltus_solution *at, const saltus_solution *beyond,
                             double value, char after[SALTUS_LABEL_MAX]) {
    saltus_orbits *o = &t->orbits;
    saltus_lap met = {.keeps_events = true};
    saltus_branch_start start = saltus_trail_leaving(t->trail);
    const int periods = beyond->sequence.periods;
    const int part = saltus_solution_least_period(o, beyond);
    double state[SALTUS_STATE_MAX];
    if (part < periods) {
        const long long impacts = beyond->survey.impacts;
        saltus_orbit_label(impacts < 0 ? impacts : impacts * part / periods, part, after);
        start.parameter[0] = beyond->parameter[0];
        start.origin = SALTUS_POINT_CH;
        memcpy(state, beyond->survey.lap.points, (size_t)o->n * sizeof *state);
        start.state = state;
        start.states = o->n;
        if (saltus_trail_switches(t->trail) &&
            saltus_orbits_noted(o, saltus_sequence_make(o->flow, part, false, state, &met, &start.sequence,
                                                        NULL)) == SALTUS_OK)
            add_joined(t, at, &start, NULL, value);
    }
    saltus_lap_close(&met);
    return part < periods;
}

void saltus_trace_follow_joined(saltus_trace *t, const saltus_solution *at, saltus_point_kind kind,
                                double value) {
    saltus_orbits *o = &t->orbits;
    saltus_branch_start start = saltus_trail_leaving(t->trail);
    saltus_orbits own = {.family = o->family, .origin = o->origin, .options = o->options};
    saltus_solution between = {.value = 0};
    if (!saltus_trail_switches(t->trail))
        return;
    saltus_status status = saltus_orbits_open(&own, NULL);
    if (status == SALTUS_OK)
        status = saltus_special_between(o, &own, at, kind == SALTUS_POINT_BP, &between);
    double *states = NULL;
    if (status == SALTUS_OK)
        status = saltus_solution_states_at(o, &between, &between.sequence, &states, NULL);
    if (status == SALTUS_OK && saltus_solution_walk(&own, &between) && between.survey.walked) {
        start.sequence = between.sequence;
        start.parameter[0] = between.parameter[0];
        start.state = states;
        start.states = start.sequence.cuts * o->n;
        start.tangent = between.at.tangent;
        start.unknowns = between.at.unknowns;
        start.origin = kind;
        add_joined(t, &between, &start, NULL, value);
    }
    o->starved |= status == SALTUS_NO_MEMORY || own.starved;
    free(states);
    saltus_solution_clear(&between);
    saltus_orbits_close(&own);
}

void saltus_trace_follow_grazing(saltus_trace *t, const saltus_solution *at, int parts) {
    const double little = 1e-6;
    saltus_orbits *o = &t->orbits;
    saltus_branch_start start = saltus_trail_leaving(t->trail);
    saltus_sequence changed, sequences[2];
    if (!saltus_trail_switches(t->trail))
        return;
    /* Without the impact in any part, and with it in all. */
    for (int k = 0; k < 2; k++) {
        const saltus_breach_kind kind = k ? SALTUS_BREACH_GAP : SALTUS_BREACH_SPEED;
        changed = at->sequence;
        for (int j = at->breach_count - 1; j >= 0; j--) {
            saltus_breach touch = at->breaches[j];
            const saltus_sequence before = changed;
            if (touch.kind != kind || !(fabs(touch.value) < little))
                continue;
            touch.value = 0;
            saltus_sequence_graze(&before, &touch, 1, &changed, NULL);
        }
        sequences[k] = saltus_sequence_part(&changed, parts);
        saltus_solution_cuts(at, &sequences[k]);
    }
    if (sequences[0].count == sequences[1].count)
        return;
    double *states;
    const saltus_status status = saltus_solution_states_at(o, at, &sequences[0], &states, NULL);
    saltus_sequence_even(&sequences[0]);
    saltus_sequence_even(&sequences[1]);
    start.sequence = sequences[0];
    start.parameter[0] = at->parameter[0];
    start.state = states;
    start.states = start.sequence.cuts * o->n;
    start.origin = SALTUS_POINT_GR;
    if (saltus_orbits_noted(o, status) == SALTUS_OK)
        add_joined(t, at, &start, sequences, at->value);
    free(states);
}
