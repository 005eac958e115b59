/* How an orbit is cut into unknowns.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/sequence.h"
#include "branch/solution.h"
#include "orbit/sequence.h"

#include <stdlib.h>
#include <string.h>

/* Whether an orbit whose period is an unknown should begin at another *time: at a turning point (*turning,
 * with its `state` (n)) or, if all of these are near stops, elsewhere. */
static bool better_section(saltus_orbits *o, const saltus_solution *s, bool leaves, double *time,
                           double *state, bool *turning) {
    const double least_onward = 0.5;
    const double begin = *time = s->sequence.base;
    *turning = false;
    if (!(s->sequence.omega > 0) || (s->onward > least_onward && !leaves) || !s->survey.follows ||
        saltus_orbits_tune(o, s->parameter, s->sequence.omega, NULL) != SALTUS_OK)
        return false;
    memcpy(state, s->state, (size_t)o->n * sizeof *state);
    *turning = saltus_orbit_turning(o->flow, s->sequence.periods, time, state);
    if (*time >= begin + s->sequence.periods)
        *time = begin;
    return *turning || *time != begin;
}

/* Build a solution again with another sequence, whose base has this `state` if it is a turning point (NULL:
 * it is none). If the period is an unknown, that state is the anchor of a new base. */
static saltus_status place(saltus_orbits *o, const saltus_solution *s, saltus_sequence *fresh,
                           const int *order, const double *state, saltus_solution *out) {
    const saltus_sequence *old = &s->sequence;
    const bool anchored = fresh->omega > 0 && (fresh->base != old->base || state);
    double *states;
    saltus_status status = saltus_solution_states_at(o, s, fresh, &states, NULL);
    if (status == SALTUS_OK && state)
        memcpy(states, state, (size_t)o->n * sizeof *states);
    if (status == SALTUS_OK && anchored)
        status = saltus_orbits_tune(o, s->parameter, fresh->omega, NULL);
    if (status == SALTUS_OK && anchored)
        status = saltus_flow_place(o->flow, 0, saltus_time_of(fresh->base), states, fresh->contacts, NULL);
    if (status == SALTUS_OK && anchored)
        saltus_sequence_anchor(fresh, o->flow, state);
    if (status == SALTUS_OK)
        status = saltus_solution_restore(o, fresh, s->parameter, states, false, out, NULL);
    free(states);
    if (status != SALTUS_OK || o->family.parameters != 1)
        return status;
    double *guide = calloc((size_t)saltus_sequence_unknowns(fresh, o->n) + 1, sizeof *guide);
    if (!guide)
        return SALTUS_NO_MEMORY;
    saltus_sequence_carry(old, s->at.tangent, fresh, order, o->n, 1, guide);
    saltus_curve_align(&out->at, guide);
    free(guide);
    return SALTUS_OK;
}

/* Cut the orbit open again, into as many segments as the options ask for; by default as many as now, or twice
 * as many if it needs `more`. */
static bool reframe(saltus_orbits *o, bool trims, bool leaves, bool more, saltus_solution *s,
                    saltus_solution *scratch, int *order) {
    const int asked = o->options.segments, own = more ? 2 * s->sequence.cuts : s->sequence.cuts;
    const int wanted = asked > 0 ? asked : own, cuts = wanted < SALTUS_CUTS_MAX ? wanted : SALTUS_CUTS_MAX;
    saltus_sequence fresh;
    double speed[SALTUS_MARKS_MAX], state[SALTUS_STATE_MAX], section;
    int unasked[SALTUS_MARKS_MAX];
    bool turning;
    order = order ? order : unasked;
    saltus_solution_speeds(o, s, speed);
    if (better_section(o, s, leaves, &section, state, &turning))
        saltus_sequence_turn(&s->sequence, section, cuts, &fresh, order);
    else if (!saltus_sequence_reframe(&s->sequence, speed, cuts, trims, &fresh, order))
        return false;
    if (saltus_orbits_noted(o, place(o, s, &fresh, order, turning ? state : NULL, scratch)) != SALTUS_OK) {
        saltus_orbits_reshape(o, s);
        return false;
    }
    SALTUS_SWAP(s->survey, scratch->survey);
    SALTUS_SWAP(*s, *scratch);
    return true;
}

bool saltus_solution_reframe(saltus_orbits *o, bool trims, bool leaves, saltus_solution *s,
                             saltus_solution *scratch, int *order) {
    const double growth_max = 1e4; /* over a segment */
    return reframe(o, trims, leaves, s->growth > growth_max, s, scratch, order);
}

bool saltus_solution_refine(saltus_orbits *o, saltus_solution *s, saltus_solution *scratch, int *order) {
    const int cuts = s->sequence.cuts;
    return reframe(o, false, false, true, s, scratch, order) && s->sequence.cuts > cuts;
}

bool saltus_solution_base_beyond(const saltus_orbits *o, const saltus_solution *s) {
    const saltus_system *system = o->shooting->full.system;
    if (s->sequence.contacts || !(s->sequence.omega > 0))
        return false;
    for (int f = 0; f < saltus_system_face_count(system); f++)
        if (saltus_system_gap(system, f, s->state) > 0)
            return true;
    return false;
}
