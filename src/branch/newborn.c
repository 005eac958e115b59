/* Cycles on which motions settle near an equilibrium that has met a stop.
 *
 * A little beyond the contact, everything that is born has the size of the distance d between equilibrium and
 * stop: up to order d, the flow is that of the Jacobian and the impact law linear. So the scene itself is
 * followed from a few states of that size, on both sides. A motion that settles on a cycle is polished by
 * Newton's method. At an eighth of the distance the shrunken cycle must exist too, with the same events,
 * impacts an eighth as fast and nearly the same period. This distinguishes what is born from cycles that were
 * there before, whose size does not change.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/born.h"

#include "orbit/poincare.h"
#include "orbit/sequence.h"
#include "system/state.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { contacts_max = 768, longest = 24 };

typedef struct newborn {
    saltus_rests *rests;
    saltus_orbit_options options;
    const saltus_rest *at;
    int face;              /* face that is touched */
    double parameter;      /* parameter a little beyond */
    saltus_system *system; /* system at `parameter` */
    saltus_flow *flow;
    double size; /* scaled distance of the equilibrium there from `at` */
    /* The last part of a motion: its contact events and the states after them. */
    int count;
    saltus_event event[contacts_max];
    double *state; /* contacts_max x n */
} newborn;

/* A cycle, with `clocked` the system whose period is that of the cycle. */
typedef struct found {
    saltus_orbit orbit;
    saltus_system *clocked;
    saltus_lap lap;
    double speed; /* of its fastest impact */
} found;

static void clear(found *f) {
    saltus_orbit_clear(&f->orbit);
    saltus_system_free(f->clocked);
    saltus_lap_close(&f->lap);
    *f = (found){.speed = 0};
}

static double apart(const newborn *b, const double *p, const double *q) {
    return saltus_system_distance(b->rests->first, p, q);
}

/* A starting state for a trial: displaced from the equilibrium `rest` by about `size`. */
static void begin_aside(const newborn *b, const saltus_rest *rest, int trial, double *state) {
    static const double reach[] = {1, 0.3, 3};
    const int n = b->rests->n, count = rest->rate_count;
    double vector[SALTUS_STATE_MAX], unit[SALTUS_STATE_MAX] = {0};
    for (int k = 0; k < count; k++) {
        double weight = 0;
        unit[k] = 1;
        saltus_rests_lift(b->rests, count, unit, state);
        unit[k] = 0;
        for (int i = 0; i < n; i++)
            weight = fmax(weight, fabs(state[i]) * b->rests->state_scale[i]);
        vector[k] = reach[trial] * b->size * weight * sin(1 + 2.4 * (k + count * trial));
    }
    saltus_rests_lift(b->rests, count, vector, state);
    for (int i = 0; i < n; i++)
        state[i] += rest->state[i];
    saltus_state_admit(b->system, state);
}

/* Follow a motion until it has met many contacts, and record these. Few are recorded if it comes to rest or
 * leaves the neighbourhood. Errors: those of the flow. */
static saltus_status follow(newborn *b, const saltus_rest *rest, double *state) {
    const double far = 1e3, turns = 3000;
    const size_t n = (size_t)b->rests->n;
    saltus_event event = {.kind = SALTUS_STEP};
    double fastest = 0;
    for (int k = 0; k < rest->rate_count; k++)
        fastest = fmax(fastest, hypot(rest->rates[k].re, rest->rates[k].im));
    const saltus_time until = saltus_time_of(turns * 2 * M_PI / fastest / saltus_system_period(b->system));
    saltus_status status = saltus_flow_start(b->flow, 0, (saltus_time){0, 0}, state, NULL);
    b->count = 0;
    while (b->count < contacts_max && status == SALTUS_OK) {
        status = saltus_flow_advance(b->flow, until, SALTUS_WATCH_CONTACT, &event, NULL);
        double *after = b->state + (size_t)b->count * n;
        saltus_flow_state(b->flow, 0, after);
        if (event.kind == SALTUS_REACHED || !(apart(b, after, rest->state) < far * b->size))
            break;
        if (event.face != b->face)
            continue;
        /* If chatter completes, keep only the first of its impacts, whose number is arbitrary. */
        int kept = b->count;
        while (event.kind == SALTUS_STICK && kept > 0 && b->event[kept - 1].kind == SALTUS_IMPACT)
            kept--;
        kept += kept < b->count;
        memmove(b->state + (size_t)kept * n, after, n * sizeof *after);
        b->event[kept] = event;
        b->count = kept + 1;
    }
    return status;
}

/* Whether the last `count` of the chosen events repeat those `period` events before. */
static bool repeats(const newborn *b, const int *chosen, int last, int period, int count) {
    const double near = 1e-4;
    for (int k = last; k > last - count; k--) {
        const int one = chosen[k], other = chosen[k - period];
        if (b->event[one].kind != b->event[other].kind ||
            apart(b, b->state + (size_t)one * (size_t)b->rests->n,
                  b->state + (size_t)other * (size_t)b->rests->n) > near * b->size)
            return false;
    }
    return true;
}

/* The period on which the motion has settled, and as `state` a point in the middle of its longest flight; 0
 * if it has not settled. If chatter completes only the contacts after it count, not its impacts. */
static double settled(newborn *b, double *state) {
    int chosen[contacts_max], count = 0, sticks = 0, period = 1;
    for (int k = b->count / 2; k < b->count; k++)
        sticks += b->event[k].kind == SALTUS_STICK;
    for (int k = b->count / 2; k < b->count; k++)
        if (!sticks || b->event[k].kind != SALTUS_IMPACT)
            chosen[count++] = k;
    while (period <= longest &&
           (count < 3 * period + 1 || !repeats(b, chosen, count - 1, period, 2 * period)))
        period++;
    if (period > longest)
        return 0;
    const int first = chosen[count - 1 - period], last = chosen[count - 1];
    const double unit = saltus_system_period(b->system);
    double flight = 0;
    int begin = first;
    for (int k = first; k < last; k++) {
        const double time = saltus_time_periods(b->event[k + 1].time) - saltus_time_periods(b->event[k].time);
        if (b->event[k].kind != SALTUS_STICK && time > flight) {
            flight = time;
            begin = k;
        }
    }
    const size_t n = (size_t)b->rests->n;
    memcpy(state, b->state + (size_t)begin * n, n * sizeof *state);
    saltus_status status =
        saltus_state_carry(b->flow, (saltus_time){0, 0}, saltus_time_of(0.5 * flight), state, NULL);
    const double time = saltus_time_periods(b->event[last].time) - saltus_time_periods(b->event[first].time);
    return status == SALTUS_OK ? time * unit : 0;
}

/* Find the cycle near this period and state by Newton's method. */
static saltus_status polish(const newborn *b, const saltus_system *system, double period, const double *state,
                            found *f) {
    saltus_system *clocked = NULL;
    *f = (found){.lap = {.keeps_events = true}};
    saltus_status status = saltus_system_clocked(system, 2 * M_PI / period, &clocked, NULL);
    if (status == SALTUS_OK)
        status = saltus_cycle_polish(clocked, state, &b->options, &f->orbit, &f->clocked, &f->lap, NULL);
    saltus_system_free(clocked);
    if (status != SALTUS_OK)
        return status;
    for (int k = 0; k < f->lap.event_count; k++)
        f->speed = fmax(f->speed, fabs(f->lap.events[k].velocity_before));
    return status;
}

/* The system at `parameter`, and `rest`, the equilibrium there. */
static saltus_status tune(saltus_rests *r, const saltus_rest *at, double parameter, saltus_rest *rest,
                          saltus_system **system) {
    saltus_status status = saltus_rest_place(r, at->contacts, at->state, &parameter, true, NULL, rest, NULL);
    const saltus_spec spec = saltus_family_spec(&r->family, &parameter, 0);
    if (status == SALTUS_OK)
        status = saltus_system_new(&spec, system, NULL);
    return status;
}

/* *does: whether the cycle also exists, shrunken, nearer to the stop. `out` becomes the start of its
 * branch, with this tangent. */
static saltus_status shrinks(newborn *b, const found *f, saltus_rest *rest, saltus_branch_start *out,
                             double *tangent, bool *does) {
    const double part = 0.125, slack = 0.1;
    const saltus_rest *at = b->at;
    const int n = b->rests->n;
    saltus_system *system = NULL;
    saltus_flow *flow = NULL;
    saltus_lap lap = {.keeps_events = true};
    double state[SALTUS_STATE_MAX];
    found less = {.speed = 0};
    for (int i = 0; i < n; i++)
        state[i] = at->state[i] + part * (f->orbit.state[i] - at->state[i]);
    const double near = at->parameter[0] + part * (b->parameter - at->parameter[0]);
    const double period = saltus_system_period(f->clocked);
    saltus_status status = tune(b->rests, at, near, rest, &system);
    if (status == SALTUS_OK)
        saltus_state_admit(system, state);
    if (status == SALTUS_OK)
        status = polish(b, system, period, state, &less);
    const double shorter = status == SALTUS_OK ? saltus_system_period(less.clocked) : NAN;
    *does = status == SALTUS_OK && saltus_lap_impacts(&less.lap) == saltus_lap_impacts(&f->lap) &&
            saltus_lap_sticking(&less.lap) == saltus_lap_sticking(&f->lap) &&
            fabs(shorter - period) < slack * period &&
            fabs(less.speed - part * f->speed) < slack * part * f->speed;
    if (*does)
        status = saltus_flow_single(less.clocked, 0, &b->options.flow, &flow, NULL);
    if (*does && status == SALTUS_OK)
        status = saltus_sequence_make(flow, 1, true, less.orbit.state, &lap, &out->sequence, NULL);
    /* Extrapolate the period, which is reported, to d = 0, but not the state. */
    out->sequence.omega = 2 * M_PI / (shorter - part * (period - shorter) / (1 - part));
    for (int i = 0; i < n && *does; i++)
        tangent[i] =
            (less.orbit.state[i] - at->state[i]) / b->rests->state_scale[i] / (near - at->parameter[0]);
    saltus_flow_free(flow);
    saltus_lap_close(&lap);
    saltus_system_free(system);
    clear(&less);
    return status;
}

/* Whether a cycle is known already: on the same side, with the same period. */
static bool is_known(const saltus_starts *starts, const saltus_branch_start *start) {
    const double alike = 1e-3;
    for (int k = 0; k < starts->count; k++) {
        const saltus_branch_start *s = &starts->start[k];
        if (s->heading == start->heading &&
            fabs(s->sequence.omega - start->sequence.omega) < alike * start->sequence.omega)
            return true;
    }
    return false;
}

/* Try one motion on one side, where `rest` is the equilibrium. */
static saltus_status try(newborn *b, int trial, saltus_rest *rest, const saltus_branch_start *like,
                         saltus_starts *starts) {
    double state[SALTUS_STATE_MAX], tangent[SALTUS_STATE_MAX + SALTUS_MARKS_MAX + 2] = {0};
    saltus_branch_start start = *like;
    found f = {.speed = 0};
    bool does = false;
    begin_aside(b, rest, trial, state);
    saltus_status status = follow(b, rest, state);
    const double period = status == SALTUS_OK ? settled(b, state) : 0;
    if (period > 0)
        status = polish(b, b->system, period, state, &f);
    if (period > 0 && status == SALTUS_OK &&
        saltus_multipliers_stable(f.orbit.multipliers, f.orbit.multiplier_count))
        status = shrinks(b, &f, rest, &start, tangent, &does);
    clear(&f);
    start.heading = b->parameter > b->at->parameter[0] ? 1 : -1;
    start.tangent = tangent;
    start.unknowns = saltus_sequence_unknowns(&start.sequence, b->rests->n) + 1;
    if (does && status == SALTUS_OK && !is_known(starts, &start))
        saltus_starts_add(starts, &start, &b->rests->starved);
    return status;
}

void saltus_newborn_find(saltus_rests *r, const saltus_rest *at, int face,
                         const saltus_orbit_options *options, const saltus_branch_start *like,
                         saltus_rest *scratch, saltus_starts *starts) {
    enum { trials = 3 };
    const double distance = 1e-3;
    newborn b = {.rests = r, .options = *options, .at = at, .face = face};
    b.options.flow.stop = NULL;
    b.state = calloc((size_t)contacts_max * (size_t)r->n, sizeof *b.state);
    saltus_rests_noted(r, b.state ? SALTUS_OK : SALTUS_NO_MEMORY);
    for (int side = 0; side < 2 * trials && !r->starved; side++) {
        b.parameter = at->parameter[0] + (side % 2 ? -distance : distance);
        saltus_status status = tune(r, at, b.parameter, scratch, &b.system);
        if (status == SALTUS_OK)
            status = saltus_flow_single(b.system, 0, &b.options.flow, &b.flow, NULL);
        b.size = status == SALTUS_OK ? apart(&b, scratch->state, at->state) : 0;
        if (b.size > 0)
            status = try(&b, side / 2, scratch, like, starts);
        saltus_rests_noted(r, status);
        saltus_flow_free(b.flow);
        saltus_system_free(b.system);
        b.flow = NULL;
        b.system = NULL;
    }
    free(b.state);
}
