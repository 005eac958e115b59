/* Changes of the sequence of events along a branch.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/change.h"

#include "branch/corner.h"
#include "branch/sequence.h"
#include "orbit/sequence.h"
#include "system/state.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* On an orbit that forgets when its impacts happen, as in a planar flow, two impacts that are born at once
 * can each occur without the other: the equations have a two-dimensional null space. Take as tangent the
 * vector in it along which both speeds grow equally. */
static void leave_alike(saltus_orbits *o, saltus_solution *s) {
    const double still = 1e-9, nothing = 1e-8, apart = 1e-6;
    const size_t m = (size_t)s->at.unknowns;
    int marks[2] = {0}, count = 0;
    double values[2], speeds[2][2] = {{0}}, length = 0, *plane = NULL;
    for (int k = 0; k < s->breach_count; k++)
        if (s->breaches[k].kind == SALTUS_BREACH_SPEED && fabs(s->breaches[k].value) < still && count++ < 2)
            marks[count - 1] = s->breaches[k].mark;
    if (count != 2 ||
        saltus_orbits_noted(o, saltus_equations_evaluate(o->equations, s->at.u, NULL)) != SALTUS_OK)
        return;
    plane = calloc(3 * m, sizeof *plane);
    saltus_status status = plane ? saltus_null_plane(o->equations, plane, values, NULL) : SALTUS_NO_MEMORY;
    bool found = saltus_orbits_noted(o, status) == SALTUS_OK && fabs(values[1]) < nothing;
    double *aside = found ? plane + 2 * m : NULL;
    /* The derivatives of both speeds along both vectors. */
    for (size_t k = 0; k < 2 && found; k++) {
        for (size_t j = 0; j < m; j++)
            aside[j] = s->at.u[j] + apart * plane[k * m + j];
        found = saltus_orbits_noted(o, saltus_equations_evaluate(o->equations, aside, NULL)) == SALTUS_OK;
        const saltus_breaches *breaches = &o->shooting->breaches;
        for (int i = 0; i < 2 * breaches->count && found; i++)
            if (breaches->items[i / 2].kind == SALTUS_BREACH_SPEED &&
                breaches->items[i / 2].mark == marks[i % 2])
                speeds[k][i % 2] = -breaches->items[i / 2].value / apart;
    }
    for (size_t j = 0; j < m && found; j++) {
        aside[j] = (speeds[1][1] - speeds[1][0]) * plane[j] + (speeds[0][0] - speeds[0][1]) * plane[m + j];
        length = hypot(length, aside[j]);
    }
    for (size_t j = 0; j < m && length > 0; j++)
        s->at.tangent[j] = aside[j] / length;
    free(plane);
}

bool saltus_change_pass(saltus_orbits *o, const saltus_sequence *beyond, const double *parameters,
                        const double *states, const double *old, saltus_solution *here,
                        saltus_solution *next) {
    static const double ahead[] = {1e-4, 1e-3, 1e-5, 1e-2};
    if (saltus_solution_restore(o, beyond, parameters, states, false, here, NULL) != SALTUS_OK)
        return false;
    if (old)
        saltus_curve_align(&here->at, old);
    leave_alike(o, here);
    for (size_t k = 0; k < sizeof ahead / sizeof ahead[0]; k++)
        for (int way = 0; way < 2; way++) {
            if (saltus_solution_visit(o, here, ahead[k], next) && next->worst.value < 0 &&
                saltus_solution_survey(o, next, NULL) == SALTUS_OK && next->survey.follows)
                return true;
            saltus_curve_turn(&here->at);
        }
    return false;
}

bool saltus_change_bars(saltus_orbits *o, saltus_solution *here, saltus_solution *next) {
    static const double ahead[] = {1e-5, 1e-4};
    const double even = 0.2;
    bool bars = true;
    for (int way = 0; way < 2; way++) {
        double share[2];
        for (int k = 0; k < 2 && bars; k++) {
            bars = saltus_solution_visit(o, here, ahead[k], next) && next->worst.value > 0;
            share[k] = next->worst.value / ahead[k];
        }
        bars = bars && fabs(share[1] / share[0] - 1) < even;
        saltus_curve_turn(&here->at);
    }
    return bars;
}

bool saltus_change_in_family(saltus_orbits *o, const saltus_solution *at, bool *doubled) {
    const double slow = 1e-5, close = 1e-4;
    bool gone[SALTUS_MARKS_MAX] = {false};
    saltus_sequence less;
    int ones = 0, both = 0;
    double re[SALTUS_STATE_MAX], im[SALTUS_STATE_MAX];
    saltus_shooting *shooting = NULL;
    *doubled = false;
    if (at->sequence.omega > 0)
        return false;
    for (int k = 0; k < at->breach_count; k++)
        if (at->breaches[k].kind == SALTUS_BREACH_SPEED && fabs(at->breaches[k].value) < slow)
            gone[at->breaches[k].mark] = true;
    saltus_sequence_without(&at->sequence, gone, &less, NULL);
    saltus_status status = saltus_orbits_evaluate(o, at, &less, &shooting, NULL);
    const int count = status == SALTUS_OK ? saltus_corner_multipliers(o, shooting, re, im) : 0;
    for (int k = 0; k < count; k++) {
        ones += hypot(re[k] - 1, im[k]) < close;
        both += hypot(re[k] - 1, im[k]) < close || hypot(re[k] + 1, im[k]) < close;
    }
    *doubled = both > 1;
    saltus_orbits_noted(o, status);
    saltus_shooting_free(shooting);
    return ones > 1;
}

/* The sign is that of the parameter's change along a curve at `s`. Where the orbit forgets all perturbations
 * the curve begins or ends there at constant parameter: then it is that on the step from `first` to `last`.
 */
static double way_at(const saltus_solution *s, const saltus_solution *first, const saltus_solution *last) {
    const double still = 1e-7, heading = saltus_solution_heading(s);
    return fabs(heading) > still ? heading : last->parameter[0] - first->parameter[0];
}

void saltus_change_graze(saltus_orbits *o, const saltus_solution *from, const saltus_solution *at,
                         saltus_sequence *beyond, saltus_solution *here, saltus_solution *next,
                         saltus_change *change) {
    const double together = 1e-9;
    const saltus_breach_kind worst = saltus_solution_touch(at)->kind;
    int order[SALTUS_MARKS_MAX];
    saltus_breach *picked = calloc((size_t)at->breach_count + 1, sizeof *picked);
    double *old = calloc((size_t)(at->at.unknowns + at->breach_count) + 1, sizeof *old);
    double *states;
    saltus_sequence other;
    bool passes = false;
    *change = (saltus_change){.kind = SALTUS_POINT_EP};
    *beyond = at->sequence;
    const saltus_status status = saltus_solution_states_at(o, at, &at->sequence, &states, NULL);
    const bool room = picked && old && status == SALTUS_OK;
    o->starved |= !room;
    /* What makes the change is the worst breach and its mirror image: in a run of ever slower impacts the
     * last ones are almost as slow as the one that is born or dies, but only that one does. Where impacts die
     * the births are tried next. */
    for (int attempt = 0; attempt < 2 && room && !passes && (!attempt || change->reason); attempt++) {
        const saltus_breach_kind kind = attempt ? SALTUS_BREACH_GAP : worst;
        saltus_sequence *fresh = attempt ? &other : beyond;
        int count = 0;
        for (int k = 0; k < at->breach_count && (!attempt || worst == SALTUS_BREACH_SPEED); k++)
            if (at->breaches[k].kind == kind && fabs(at->breaches[k].value) < together)
                picked[count++] = at->breaches[k];
        const char *reason = saltus_sequence_graze(&at->sequence, picked, count, fresh, order);
        if (!reason)
            break;
        saltus_sequence_carry(&at->sequence, at->at.tangent, fresh, order, o->n, 1, old);
        passes = saltus_change_pass(o, fresh, at->parameter, states, old, here, next);
        if (passes && attempt)
            *beyond = other;
        if (passes || !attempt)
            change->reason = reason;
    }
    if (passes) {
        change->kind = SALTUS_POINT_GR;
        saltus_solution_label(o, next, change->after);
        change->turns_back = way_at(at, from, at) * way_at(here, at, next) < 0;
        change->distance = next->at.ahead;
    }
    free(picked);
    free(old);
    free(states);
}

/* Whether two orbits agree in complete chatter and in the number of sticking intervals. */
static bool same_contacts(const saltus_survey *a, const saltus_survey *b) {
    return (a->impacts < 0) == (b->impacts < 0) && a->sticking_intervals == b->sticking_intervals;
}

/* `at` becomes the last point before `ahead` which the flow follows, with the contacts of `like` (may be
 * NULL). Returns the width of the bracket, NAN if there is no such point. */
static double bracket(saltus_orbits *o, const saltus_solution *from, double ahead, const saltus_survey *like,
                      saltus_solution *at) {
    enum { halvings = 50 };
    double low = 0, high = ahead;
    for (int k = 0; k < halvings && fabs(high - low) > 1e-12; k++) {
        double middle = 0.5 * (low + high);
        bool sound = saltus_solution_visit(o, from, middle, at) && !(at->worst.value > 0) &&
                     saltus_solution_walk(o, at) && at->survey.follows &&
                     (!like || same_contacts(like, &at->survey));
        *(sound ? &low : &high) = middle;
    }
    if (!saltus_solution_visit(o, from, low, at) || saltus_solution_survey(o, at, NULL) != SALTUS_OK)
        return NAN;
    /* At the edge the survey, which runs with tangent vectors, may see other contacts than the walk. */
    if (low != 0 && like && !same_contacts(like, &at->survey)) {
        at->survey.impacts = like->impacts;
        at->survey.sticking_intervals = like->sticking_intervals;
        memcpy(at->survey.label, like->label, sizeof like->label);
    }
    return fabs(high - low);
}

/* How well the parameter is known at the point `s` that is known to `width` in arclength. Where a bracket
 * shrinks to rounding, orbits are still followed no finer than this. */
static double accuracy_at(const saltus_orbits *o, const saltus_solution *s, double width) {
    const double slope = fabs(saltus_solution_heading(s)) * o->family.unit[0];
    return width * slope + 64 * DBL_EPSILON * fabs(s->value);
}

/* The arclength beyond `at` at which the contact that completes a chatter shrinks to zero length, if it
 * shrinks along the step of length `ahead` from `from` to `at`: by self-similarity its length goes as a
 * power, about 0.6, of the distance. It is known no better than the shortest flights before it. */
static double beyond_contact(const saltus_solution *from, const saltus_solution *at, double ahead) {
    const double power = 1.5;     /* a little less than 1 / 0.6, to overestimate the distance */
    const double shortest = 2e-8; /* periods: in shorter flights the height is only rounding */
    bool shrinks = from->worst.kind == SALTUS_BREACH_HOLD && at->worst.kind == SALTUS_BREACH_HOLD &&
                   at->worst.value < 0 && from->worst.value < at->worst.value;
    return shrinks ? fabs(ahead) * pow(fmin(at->worst.value, -shortest) / from->worst.value, power) : 0;
}

/* The same at a change of this kind, on the step from `from` to `at`. */
static double accuracy_of(const saltus_orbits *o, saltus_point_kind kind, const saltus_solution *from,
                          const saltus_solution *at, double width) {
    const double contact = kind == SALTUS_POINT_CH ? beyond_contact(from, at, at->at.ahead) : 0;
    return accuracy_at(o, at, width + contact);
}

/* The sequence of events that the flow meets on the orbit `s`; `state` (n) becomes the state at its base. */
static bool sequence_met(saltus_orbits *o, const saltus_solution *s, double *state, saltus_sequence *met) {
    saltus_lap lap = {.keeps_events = true};
    memcpy(state, s->survey.lap.points, (size_t)o->n * sizeof *state);
    saltus_status status = saltus_orbits_tune(o, s->parameter, s->sequence.omega, NULL);
    if (status == SALTUS_OK)
        status =
            saltus_sequence_make(o->flow, s->sequence.periods, s->sequence.omega > 0, state, &lap, met, NULL);
    saltus_lap_close(&lap);
    return saltus_orbits_noted(o, status) == SALTUS_OK;
}

/* The sequence with all events left to the flow. */
static saltus_sequence left_to_flow(const saltus_sequence *old) {
    saltus_sequence driven = *old;
    driven.driven = true;
    driven.count = 0;
    driven.cuts = 1;
    driven.cut[0] = old->base;
    return driven;
}

/* Shooting with the flow's own events: if there is an orbit of the period of `old` near `state` (n, at the
 * base of `old`), `out` becomes that orbit with the sequence that the flow meets on it, and `state` its state
 * there. */
static bool shoot_freely(saltus_orbits *o, const saltus_sequence *old, const double *parameters,
                         double *state, saltus_solution *out) {
    const saltus_sequence driven = left_to_flow(old);
    saltus_sequence met;
    double fresh[SALTUS_STATE_MAX];
    if (saltus_orbits_tune(o, parameters, old->omega, NULL) != SALTUS_OK)
        return false;
    /* A guess along the tangent may lie beyond a stop, above all where a contact becomes permanent. */
    saltus_state_admit(o->system, state);
    if (saltus_solution_place(o, &driven, parameters, state, true, out, NULL) != SALTUS_OK ||
        !saltus_solution_walk(o, out) || !out->survey.follows)
        return false;
    memcpy(state, out->state, (size_t)o->n * sizeof *state);
    return sequence_met(o, out, fresh, &met) &&
           saltus_solution_place(o, &met, parameters, fresh, true, out, NULL) == SALTUS_OK &&
           !saltus_solution_rests(out, NULL) && saltus_solution_survey(o, out, NULL) == SALTUS_OK;
}

/* The same at `parameter`, with a guess along the tangent at `from`. *astray: how far the orbit lies from the
 * guess, relative to how far the guess lies from `from`, in state and parameter. */
static bool shoot_ahead(saltus_orbits *o, const saltus_solution *from, double parameter, saltus_solution *out,
                        double *astray) {
    double distance = (parameter - from->parameter[0]) / saltus_solution_heading(from);
    const double *scale = o->shooting->scale;
    double guess[SALTUS_STATE_MAX], state[SALTUS_STATE_MAX];
    for (int i = 0; i < o->n; i++)
        state[i] = guess[i] = (from->at.u[i] + distance * from->at.tangent[i]) * scale[i];
    bool found = shoot_freely(o, &from->sequence, &parameter, state, out);
    *astray = saltus_system_distance(o->system, state, guess) /
              (saltus_system_distance(o->system, guess, from->state) + fabs(parameter - from->parameter[0]));
    return found;
}

/* Whether the orbit is in contact with a stop all the time. */
static bool is_held(const saltus_survey *survey) {
    return survey->walked && saltus_lap_held(&survey->lap);
}

/* The speed of the last impact in the run of ever slower impacts on `face` that is under way at `time` (in
 * periods) of an orbit of `periods` periods; INFINITY if there is no impact on the face. */
static double last_speed(const saltus_survey *survey, int periods, int face, double time) {
    const saltus_event *last = NULL, *event;
    double since, shortest = INFINITY;
    for (int k = 0; k < survey->lap.event_count; k++) {
        event = &survey->lap.events[k];
        since = time - saltus_time_periods(event->time);
        since -= periods * floor(since / periods);
        if (event->kind == SALTUS_IMPACT && event->face == face && since < shortest) {
            shortest = since;
            last = event;
        }
    }
    for (event = last; event && event < survey->lap.events + survey->lap.event_count; event++)
        if (event->kind == SALTUS_IMPACT && event->face == face) {
            if (fabs(event->velocity_before) > fabs(last->velocity_before))
                break;
            last = event;
        }
    return last ? fabs(last->velocity_before) : INFINITY;
}

/* Whether the branch through `here`, where many impacts have just replaced the complete chatter of `at`,
 * leads along its tangent to where the last of them dies, rather than back into chatter. The direction of the
 * parameter does not tell, since such a branch folds again and again. */
static bool leads_away(saltus_orbits *o, const saltus_solution *at, const saltus_solution *here,
                       double distance, saltus_solution *scratch) {
    if (at->worst.kind != SALTUS_BREACH_HOLD)
        return true;
    const double ahead = fmax(0.01 * distance, 1e-6);
    const double time = at->worst.time;
    const int periods = at->sequence.periods, face = at->worst.face;
    double speed = last_speed(&here->survey, periods, face, time);
    for (int way = 1; way >= -1; way -= 2)
        if (saltus_solution_visit(o, here, way * ahead, scratch) && saltus_solution_walk(o, scratch) &&
            scratch->survey.impacts == here->survey.impacts)
            return way * (last_speed(&scratch->survey, periods, face, time) - speed) <= 0;
    return true;
}

/* Whether a contact is about to be interrupted: somewhere within it its force falls to zero. */
static bool lets_go(const saltus_solution *s) {
    const double nothing = 1e-9;
    return s->worst.kind == SALTUS_BREACH_FORCE && s->worst.value > -nothing;
}

/* Follow the branch of `here` back to where it ends, or where contacts in the part of the sequence that is
 * left to the flow change: `end`. Whether that is the change at `at`, to within `apart` in the parameter
 * unknown. In the flight that begins where a contact is interrupted all impacts are slow. */
static bool begins_at(saltus_orbits *o, const saltus_solution *at, const saltus_solution *here,
                      double distance, double apart, saltus_solution *end, double *accuracy) {
    const double touches = -1e-9;
    double slope_here = fabs(saltus_solution_heading(here));
    double back = 2 * distance / fmax(slope_here, 1e-3);
    double width = bracket(o, here, -back, &here->survey, end);
    *accuracy = accuracy_at(o, end, width + beyond_contact(here, end, end->at.ahead));
    bool grazes = end->worst.value > touches && !lets_go(at) &&
                  (end->worst.kind == SALTUS_BREACH_GAP || end->worst.kind == SALTUS_BREACH_SPEED);
    return width < back && end->at.ahead > -0.99 * back && !grazes &&
           fabs(end->parameter[0] - at->parameter[0]) < apart;
}

/* Chatter may complete this far beyond the last grazing of a run, whose impacts have speeds near rounding. */
static const double rest_of_run = 1e-6;

/* Whether an orbit near where chatter completes is easy to follow: no impact is left to the flow, and none is
 * so slow that rounding matters. */
static bool is_easy(const saltus_solution *s) {
    const double slow = 1e-6; /* relative to the fastest */
    double slowest, fastest;
    saltus_solution_speed_range(s, &slowest, &fastest);
    return !saltus_sequence_has_tail(&s->sequence) && slowest > slow * fmax(fastest, 0);
}

/* Whether the branch goes on with an orbit that was found beyond a change. */
typedef enum belonging {
    BELONGS_NOT,  /* it belongs to another branch */
    BELONGS_ELSE, /* only if no better one is found */
    BELONGS
} belonging;

/* Turn the tangent of `here`, an orbit found beyond the change at `at` and `astray` (shoot_ahead), away from
 * the change, and judge whether the branch goes on with it. If the change is located better from beyond,
 * *change is updated. */
static belonging head_on(saltus_orbits *o, const saltus_solution *at, double heading, double astray,
                         saltus_leap leap, saltus_solution *here, saltus_solution *scratch,
                         saltus_change *change) {
    const bool regular = change->kind == SALTUS_POINT_REGULAR;
    const saltus_survey *before = &at->survey, *after = &here->survey;
    double accuracy;
    saltus_solution_head(here, heading);
    /* Flights that shrink to nothing vanish within the flow's tolerances, but a contact force has a sharp
     * zero. */
    if (is_held(after)) {
        if (!begins_at(o, at, here, change->distance, 0.1 * change->distance, scratch, &accuracy))
            return BELONGS_ELSE;
        change->value = scratch->value;
        change->accuracy = accuracy;
        return BELONGS;
    }
    /* Near where chatter completes there are orbits with any number of impacts. */
    if (change->kind == SALTUS_POINT_CH && before->impacts < 0) {
        if (!leads_away(o, at, here, change->distance, scratch))
            saltus_curve_turn(&here->at);
        return after->follows && is_easy(here) ? BELONGS : BELONGS_ELSE;
    }
    if (is_held(before))
        return after->follows ? BELONGS : BELONGS_ELSE;
    /* The completion of chatter is located better from beyond, and so is where a contact splits: between its
     * parts the orbit flies ever shorter. If the curve was lost, and the orbit found does not begin at the
     * change, it belongs to another branch. */
    double close = leap == SALTUS_LEAP_RUN ? rest_of_run : 0.01 * change->distance;
    double apart = after->impacts < 0 ? close : 1e-7;
    bool begins = begins_at(o, at, here, change->distance, apart, scratch, &accuracy);
    if (begins && ((before->impacts >= 0 && after->impacts < 0) || lets_go(scratch))) {
        change->value = scratch->value;
        change->accuracy = accuracy;
    }
    /* Where an impact dies the tangent leads away, and the branch goes on near the change. */
    const double near = 1e-4;
    const bool stays =
        astray < 2 || saltus_system_distance(o->system, after->lap.points, before->lap.points) < near;
    if (after->follows && (begins || (regular && stays)))
        return BELONGS;
    const bool told = regular || (leap == SALTUS_LEAP_EVENTS && before->impacts >= 0);
    return begins || (told && stays) ? BELONGS_ELSE : BELONGS_NOT;
}

/* Whether the contact after complete chatter has shrunk to zero length. */
static bool ceases_to_complete(const saltus_solution *at) {
    const double nothing = 1e-5; /* periods */
    return at->survey.impacts < 0 && at->worst.kind == SALTUS_BREACH_HOLD && at->worst.value > -nothing;
}

/* The change between `at` and `here`: its kind, reason and accuracy. */
static saltus_change compare(const saltus_orbits *o, const saltus_solution *from, const saltus_solution *at,
                             double width, const char *why, const saltus_solution *here) {
    const saltus_survey *before = &at->survey, *after = &here->survey;
    saltus_change change = {.reason = why};
    if (is_held(before) != is_held(after))
        change.reason = is_held(after) ? "a contact becomes permanent" : "a contact lets go";
    bool completes = (before->impacts < 0) != (after->impacts < 0);
    bool ceases = ceases_to_complete(at) && after->sticking_intervals < before->sticking_intervals;
    change.kind = completes || ceases                                       ? SALTUS_POINT_CH
                  : before->sticking_intervals != after->sticking_intervals ? SALTUS_POINT_ST
                  : before->impacts != after->impacts                       ? SALTUS_POINT_GR
                                                                            : SALTUS_POINT_REGULAR;
    change.accuracy = accuracy_of(o, change.kind, from, at, width);
    return change;
}

/* Whether an orbit found at this distance beyond the end of chatter at `at` may be of the same branch. Many
 * others pass there. It moves as the tangent says, since the flight that is left of the contact disturbs the
 * motion by less than the change of the parameter does; or it has moved in proportion to the distance, as the
 * last one nearer to the change did, at this *pace (0: there is none). */
static bool keeps_pace(const saltus_orbits *o, const saltus_solution *at, const saltus_solution *here,
                       double distance, double astray, double *pace) {
    const double near = 1e-2, alike = 3;
    const double moved = saltus_system_distance(o->system, here->survey.lap.points, at->survey.lap.points);
    const double own = moved / distance;
    const bool keeps =
        *pace > 0 ? astray < 1 || (own < alike * *pace && own > *pace / alike) : astray < 1 && moved < near;
    *pace = keeps ? own : *pace;
    return keeps;
}

/* The sequence of `at`, but of the chatter that ends with its worst breach only the first impacts are left.
 * Returns the mark of the last of them, -1 if these are not slow enough for the rest not to matter. */
static int first_impacts(const saltus_solution *at, saltus_sequence *fresh) {
    enum { most = 20 }; /* of many more the flow would have to find the last ones itself */
    const double slow = 1e-6, slow_enough = 1e-3; /* relative to the first */
    const double apart = 1e-9;                    /* periods */
    const int release = at->worst.mark, left = at->sequence.count - release - 1;
    int last = release - 1;
    double first = 0, speed = INFINITY;
    *fresh = at->sequence;
    if (last < 0 || !fresh->mark[last].driven || release + most + left > SALTUS_MARKS_MAX)
        return -1;
    const double begin = fresh->mark[last].time;
    for (int k = 0; k < at->survey.lap.event_count && last < release + most - 1 && speed > slow * first;
         k++) {
        const saltus_event *event = &at->survey.lap.events[k];
        const double time = saltus_time_periods(event->time);
        if (event->kind != SALTUS_IMPACT || event->face != at->worst.face || time > at->worst.time ||
            time < begin - apart)
            continue;
        speed = fabs(event->velocity_before);
        first = fmax(first, speed);
        if (time > begin + apart)
            fresh->mark[++last] = (saltus_mark){SALTUS_IMPACT, event->face, time, false};
    }
    memcpy(&fresh->mark[last + 1], &at->sequence.mark[release + 1], (size_t)left * sizeof *fresh->mark);
    fresh->mark[release - 1].driven = false;
    fresh->count = last + 1 + left;
    fresh->cuts = 1;
    return speed < slow_enough * first ? last : -1;
}

/* Where the contact after complete chatter has shrunk to nothing, at `at`: `here` becomes an orbit of the
 * same branch nearby on which only the first impacts of the chatter happen, with a tangent along which the
 * last of them becomes slower. The more of them there are, the closer it is to `at`. So it is found by
 * Newton's method from `at` itself: first with the last impact at the same time, then along the curve to
 * where no further one follows. */
static bool break_off(saltus_orbits *o, const saltus_solution *at, const double range[2],
                      saltus_solution *here, saltus_solution *scratch) {
    enum { tries = 6 };
    const double near = 1e-2;
    saltus_equations *e = o->equations;
    saltus_sequence fresh;
    int iterations;
    const int last = first_impacts(at, &fresh);
    if (last < 0)
        return false;
    saltus_status status = saltus_shooting_shape(o->shooting, &fresh, NULL);
    double *normal = calloc(2 * (size_t)e->unknowns, sizeof *normal),
           *anchor = normal ? normal + e->unknowns : NULL;
    if (status == SALTUS_OK && !(normal && saltus_curve_reserve(&here->at, e->unknowns)))
        status = SALTUS_NO_MEMORY;
    if (status == SALTUS_OK)
        status = saltus_shooting_fill(o->shooting, at->parameter, at->state, 1, anchor, NULL);
    if (status == SALTUS_OK) {
        normal[fresh.cuts * o->n + last] = 1;
        memcpy(here->at.u, anchor, (size_t)e->unknowns * sizeof *anchor);
        status = saltus_newton(e, here->at.u, normal, anchor, true, &iterations, NULL);
    }
    if (status == SALTUS_OK)
        status = saltus_solution_see(o, here, NULL);
    if (status == SALTUS_OK)
        status = saltus_curve_orient(e, NULL, &here->at, NULL);
    free(normal);
    const double rest = at->worst.time - fresh.mark[last].time;
    bool found = false;
    for (int k = 0; k < 2 * tries && saltus_orbits_noted(o, status) == SALTUS_OK && !found; k++)
        found = saltus_solution_visit(o, here, copysign(ldexp(rest, k / 2 - 3), k % 2 ? -1 : 1), scratch) &&
                scratch->worst.value < 0 && saltus_solution_survey(o, scratch, NULL) == SALTUS_OK &&
                scratch->survey.follows;
    SALTUS_SWAP(*here, *scratch);
    found = found && here->parameter[0] >= range[0] && here->parameter[0] <= range[1] &&
            saltus_system_distance(o->system, here->survey.lap.points, at->survey.lap.points) < near;
    if (!found)
        saltus_orbits_reshape(o, at);
    else if (!leads_away(o, at, here, 0, scratch))
        saltus_curve_turn(&here->at);
    return found;
}

void saltus_change_leap(saltus_orbits *o, const saltus_solution *from, double ahead, saltus_leap leap,
                        const char *why, const double range[2], saltus_solution *at, saltus_solution *here,
                        saltus_solution *scratch, saltus_change *change) {
    static const double reach[] = {1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 3e-3, 1e-2};
    enum { reaches = sizeof reach / sizeof reach[0], wide = 2 };
    double width = bracket(o, from, ahead, from->survey.walked ? &from->survey : NULL, at);
    double heading = saltus_solution_heading(at);
    *change = (saltus_change){.kind = SALTUS_POINT_EP, .reason = why, .accuracy = NAN};
    if (isnan(width))
        return;
    const bool ceases = ceases_to_complete(at);
    if (ceases) {
        change->kind = SALTUS_POINT_CH;
        change->reason = why = "chatter ceases to complete: the contact after it shrinks to nothing";
    }
    change->accuracy = accuracy_of(o, change->kind, from, at, width);
    double astray, pace = 0, border = range[heading > 0];
    change->at_border =
        fabs(at->parameter[0] - border) < saltus_at_border && shoot_ahead(o, at, border, here, &astray);
    /* Where chatter completes, changes lie close together; where grazings accumulate, the parameter turns
     * back again and again. The last attempt repeats the first that gave an orbit to use if no better one is
     * found. */
    bool near = leap == SALTUS_LEAP_RUN || (at->survey.impacts < 0 && !is_held(&at->survey));
    const int period = saltus_solution_least_period(o, at);
    int tries = change->at_border ? 0 : 2 * reaches, other = -1;
    for (int k = near ? 0 : 2 * wide; k < tries + (other >= 0); k++) {
        int own = k < tries ? k : other;
        double distance = reach[own / 2], way = own % 2 ? -heading : heading;
        double parameter = at->parameter[0] + copysign(distance, way);
        if ((own % 2 && leap != SALTUS_LEAP_RUN) || parameter < range[0] || parameter > range[1] ||
            !shoot_ahead(o, at, parameter, here, &astray))
            continue;
        saltus_change found = compare(o, from, at, width, why, here);
        found.distance = distance;
        const bool chatter = found.kind == SALTUS_POINT_CH;
        /* Without a change the branch would go back on itself. Only where orbits forget what came before do
         * they become those of a part of the period. */
        if ((own % 2 && found.kind == SALTUS_POINT_REGULAR) ||
            (ceases && !chatter && distance >= reach[wide]) ||
            saltus_solution_least_period(o, here) < (chatter ? period : at->sequence.periods))
            continue;
        if (chatter && k < tries && at->survey.impacts < 0 && !is_held(&here->survey) &&
            !keeps_pace(o, at, here, distance, astray, &pace))
            continue;
        belonging belongs = head_on(o, at, way, astray, leap, here, scratch, &found);
        if (belongs == BELONGS || k == tries) {
            *change = found;
            saltus_solution_label(o, here, change->after);
            break;
        }
        if (belongs == BELONGS_ELSE && other < 0 && distance >= reach[wide])
            other = own;
    }
    if (ceases && !change->at_border && !change->after[0] && break_off(o, at, range, here, scratch)) {
        *change = compare(o, from, at, width, why, here);
        change->distance = fabs(here->parameter[0] - at->parameter[0]);
        saltus_solution_label(o, here, change->after);
    }
}

/* Follow the branch of `here`, an orbit with complete chatter, back to where the contact after the chatter
 * vanishes: `at`. Where the tangent is not good enough this takes several parts. *ahead: arclength from
 * `here` to `at`. Returns the width of the bracket in arclength, NAN if the place is not found. */
static double find_vanishing(saltus_orbits *o, const saltus_solution *here, double back, saltus_solution *at,
                             saltus_solution *scratch, double *ahead) {
    enum { parts_max = 12 };
    const double nothing = 1e-4, still = 1e-9;
    const saltus_solution *from = here;
    *ahead = 0;
    for (int k = 0; k < parts_max; k++) {
        double width = bracket(o, from, -back, NULL, at);
        bool vanishes = at->worst.kind == SALTUS_BREACH_HOLD && at->worst.value > -nothing;
        if (isnan(width) || (at->at.ahead == 0 && !vanishes))
            return NAN;
        *ahead += at->at.ahead;
        if (at->at.ahead < -0.99 * back)
            back *= 4;
        /* The last part may have ended there only because its tangent was no longer good enough. */
        if (vanishes && fabs(at->at.ahead) < still)
            return same_contacts(&at->survey, &here->survey) ? width : NAN;
        SALTUS_SWAP(*at, *scratch);
        from = scratch;
    }
    return NAN;
}

/* The shorter the contact at `at`, the more impacts matter before the chatter is complete. Take the sequence
 * that the flow meets there and go on to where the contact vanishes, again and again while this makes it
 * shorter. *ahead and the result as above; `way`: the sign of the parameter's change along `here`. */
static double find_vanished(saltus_orbits *o, const saltus_solution *here, double way, double width,
                            saltus_solution *at, saltus_solution *scratch, double *state, double *ahead) {
    enum { rounds = 12 };
    const double beyond = 4, nearer = 0.7;
    for (int k = 0; k < rounds && !isnan(width); k++) {
        double parameter = at->parameter[0], before = at->worst.value;
        double back = fmax(beyond * beyond_contact(here, at, *ahead), 1e-10);
        memcpy(state, at->state, (size_t)o->n * sizeof *state);
        if (!shoot_freely(o, &at->sequence, &parameter, state, scratch) ||
            !same_contacts(&scratch->survey, &here->survey))
            break;
        saltus_solution_head(scratch, way);
        width = bracket(o, scratch, -back, NULL, at);
        if (!same_contacts(&at->survey, &here->survey))
            width = NAN;
        *ahead += at->at.ahead;
        if (at->worst.kind != SALTUS_BREACH_HOLD || !(at->worst.value > nearer * before))
            break;
    }
    /* The branch goes on from `here`. */
    saltus_orbits_reshape(o, here);
    return width;
}

void saltus_births_note(saltus_births *run, bool born, double place) {
    if (run->count == saltus_births_length)
        memmove(run->place, run->place + 1, (size_t)--run->count * sizeof *run->place);
    run->count = born ? run->count + 1 : 0;
    if (born)
        run->place[run->count - 1] = place;
}

/* Whether the births form a geometric sequence: its limit, and how far that is from the last birth. */
static bool accumulate(const saltus_births *run, double *limit, double *rest) {
    const double steady = 0.05, slowest = 0.95, least = 1e-10;
    double ratio[saltus_births_length - 2];
    if (run->count < saltus_births_length)
        return false;
    for (int k = 0; k < saltus_births_length - 2; k++)
        ratio[k] = (run->place[k + 2] - run->place[k + 1]) / (run->place[k + 1] - run->place[k]);
    *rest = (run->place[saltus_births_length - 1] - run->place[saltus_births_length - 2]) * ratio[1] /
            (1 - ratio[1]);
    *limit = run->place[saltus_births_length - 1] + *rest;
    return ratio[1] > 0 && ratio[1] < slowest && fabs(ratio[1] - ratio[0]) < steady * ratio[1] &&
           fabs(*rest) > least;
}

/* `out` becomes the orbit `s` cut open in the flight after its slowest impact. Not where the period is an
 * unknown: the base is then bound to its hyperplane. */
static bool open_after_run(saltus_orbits *o, const saltus_solution *s, saltus_solution *out) {
    const saltus_sequence *old = &s->sequence;
    saltus_sequence fresh;
    int slowest = -1;
    double speed[SALTUS_MARKS_MAX], state[SALTUS_STATE_MAX];
    saltus_solution_speeds(o, s, speed);
    for (int k = 0; k < old->count; k++)
        if (old->mark[k].kind == SALTUS_IMPACT && (slowest < 0 || speed[k] < speed[slowest]))
            slowest = k;
    if (slowest < 0 || old->omega > 0)
        return false;
    const bool last = slowest + 1 == old->count;
    const double next = old->mark[last ? 0 : slowest + 1].time + (last ? old->periods : 0),
                 middle = 0.5 * (old->mark[slowest].time + next),
                 base = middle < old->base + old->periods ? middle : middle - old->periods;
    saltus_sequence_turn(old, base, 1, &fresh, NULL);
    return saltus_solution_state_at(o, s, base, state, NULL) == SALTUS_OK &&
           saltus_solution_place(o, &fresh, s->parameter, state, false, out, NULL) == SALTUS_OK;
}

/* The orbit at the limit of births. Just after the run of impacts that becomes chatter there, `state` is its
 * state at the base of `sequence` and, once the chatter is complete, `slope` the derivative by the parameter.
 */
typedef struct births_end {
    saltus_sequence sequence; /* left to the flow */
    double state[SALTUS_STATE_MAX], slope[SALTUS_STATE_MAX];
} births_end;

/* Extrapolate from the orbit `birth` to the limit, which is `rest` further on. Complete chatter forgets what
 * came before, so that the slope is that of the flow that begins there, on whichever side it is complete from
 * this state. False if there is no such run or side. The solutions are overwritten. */
static bool look_beyond_births(saltus_orbits *o, const saltus_solution *from, double limit, double rest,
                               saltus_solution *birth, saltus_solution *trial, births_end *end) {
    const double close = 1.0 / 16;
    saltus_orbits_reshape(o, from);
    if (!saltus_solution_visit(o, from, -from->at.ahead, birth) || !open_after_run(o, birth, trial))
        return false;
    const double *scale = o->shooting->scale;
    const double distance = (limit - trial->parameter[0]) / saltus_solution_heading(trial);
    end->sequence = left_to_flow(&trial->sequence);
    for (int i = 0; i < o->n; i++)
        end->state[i] = trial->state[i] + distance * trial->at.tangent[i] * scale[i];
    for (int side = 1; side >= -1; side -= 2) {
        const double parameter = limit + side * rest * close;
        if (saltus_solution_place(o, &end->sequence, &parameter, end->state, false, trial, NULL) !=
                SALTUS_OK ||
            !saltus_solution_walk(o, trial) ||
            trial->survey.sticking_intervals <= from->survey.sticking_intervals)
            continue;
        for (int i = 0; i < o->n; i++)
            end->slope[i] = trial->at.tangent[i] * o->shooting->scale[i] / saltus_solution_heading(trial);
        return true;
    }
    return false;
}

bool saltus_change_complete(saltus_orbits *o, const saltus_solution *from, const saltus_births *births,
                            bool far, const double range[2], saltus_solution *at, saltus_solution *here,
                            saltus_solution *scratch, saltus_change *change) {
    static const double reach[] = {1, 1.0 / 16, 1.0 / 256, 4};
    const double sharp = far ? 0.02 : 0.2, near = far ? 0.5 : 1e-2;
    double state[SALTUS_STATE_MAX], limit, rest;
    births_end end;
    bool found = false, there = !accumulate(births, &limit, &rest);
    const bool looks = !there && look_beyond_births(o, from, limit, rest, at, scratch, &end);
    /* The far side first; but where the parameter turns back as impacts are born, the near side may be the
     * right one. */
    for (size_t k = 0; k < 2 * sizeof reach / sizeof reach[0] && !there; k++) {
        double way = copysign(1, k % 2 ? -rest : rest), distance = reach[k / 2] * fabs(rest), ahead;
        double parameter = limit + way * distance;
        for (int i = 0; i < o->n; i++)
            state[i] = looks ? end.state[i] + (parameter - limit) * end.slope[i] : from->state[i];
        if (parameter < range[0] || parameter > range[1] ||
            !shoot_freely(o, looks ? &end.sequence : &from->sequence, &parameter, state, here) ||
            here->survey.sticking_intervals <= from->survey.sticking_intervals)
            continue;
        saltus_solution_head(here, way);
        double slope_here = fmax(fabs(saltus_solution_heading(here)), 1e-3);
        double width = find_vanishing(o, here, 2 * distance / slope_here, at, scratch, &ahead);
        width = find_vanished(o, here, way, width, at, scratch, state, &ahead);
        there = !isnan(width) && fabs(at->parameter[0] - limit) < sharp * fabs(rest);
        found =
            there && saltus_system_distance(o->system, at->survey.lap.points, from->survey.lap.points) < near;
        if (!found)
            continue;
        *change = (saltus_change){.kind = SALTUS_POINT_CH,
                                  .value = at->value,
                                  .accuracy = accuracy_at(o, at, width + beyond_contact(here, at, ahead)),
                                  .reason = "births of impacts accumulate: chatter completes",
                                  .distance = -ahead};
        saltus_solution_label(o, here, change->after);
    }
    if (!found)
        saltus_orbits_reshape(o, from);
    return found;
}

bool saltus_change_within(saltus_orbits *o, const saltus_solution *from, const saltus_solution *to,
                          saltus_solution *at, saltus_change *change) {
    bool chatter = (from->survey.impacts < 0) != (to->survey.impacts < 0);
    double width = bracket(o, from, to->at.ahead, &from->survey, at);
    *change =
        (saltus_change){.kind = chatter ? SALTUS_POINT_CH : SALTUS_POINT_ST,
                        .reason = chatter ? "chatter completes or ceases to" : "a contact begins or ends"};
    saltus_solution_label(o, to, change->after);
    if (isnan(width))
        return false;
    change->accuracy = accuracy_at(o, at, width);
    return true;
}

bool saltus_change_retrace(saltus_orbits *o, const saltus_solution *here, saltus_solution *fresh,
                           saltus_solution *scratch, double *value, double *accuracy) {
    const double back = 1e-3;
    saltus_sequence met;
    double state[SALTUS_STATE_MAX];
    if (!(sequence_met(o, here, state, &met) &&
          saltus_solution_place(o, &met, here->parameter, state, true, fresh, NULL) == SALTUS_OK &&
          saltus_solution_survey(o, fresh, NULL) == SALTUS_OK && fresh->survey.follows)) {
        saltus_orbits_reshape(o, here);
        return false;
    }
    saltus_solution_head(fresh, saltus_solution_heading(here));
    /* On this side chatter ends where the contact after it vanishes, which is sharper than the flow's
     * criterion, with its tolerance, for complete chatter. */
    double width = bracket(o, fresh, -back, NULL, scratch);
    if (scratch->at.ahead > -0.9 * back && fabs(scratch->value - *value) < 1e-4 * o->family.unit[0]) {
        *value = scratch->value;
        *accuracy = accuracy_at(o, scratch, width);
    }
    return true;
}
