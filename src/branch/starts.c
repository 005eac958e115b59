/* Where other branches begin.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/sequence.h"
#include "branch/special.h"

#include <stdlib.h>
#include <string.h>

/* Append a copy, its tangent as it is or (way = -1) reversed. */
static void add(saltus_starts *starts, const saltus_branch_start *start, int way, bool *starved) {
    const size_t room = ((size_t)starts->count + 1) * sizeof *starts->start;
    saltus_branch_start *grown = realloc(starts->start, room);
    double *own = calloc((size_t)(start->states + start->unknowns) + 1, sizeof *own);
    starts->start = grown ? grown : starts->start;
    *starved |= !grown || !own;
    if (!grown || !own) {
        free(own);
        return;
    }
    for (int j = 0; j < start->states; j++)
        own[j] = start->state[j];
    for (int j = 0; j < start->unknowns; j++)
        own[start->states + j] = way * start->tangent[j];
    saltus_branch_start *copy = &grown[starts->count++];
    *copy = *start;
    copy->state = own;
    copy->tangent = own + start->states;
}

void saltus_starts_add(saltus_starts *starts, const saltus_branch_start *start, bool *starved) {
    add(starts, start, 1, starved);
}

void saltus_starts_add_at(saltus_orbits *o, const saltus_solution *at, const saltus_branch_start *start,
                          saltus_starts *starts) {
    saltus_branch_start own = *start;
    double *states;
    saltus_solution_cuts(at, &own.sequence);
    const saltus_status status = saltus_solution_states_at(o, at, &own.sequence, &states, NULL);
    memcpy(own.parameter, at->parameter, sizeof own.parameter);
    own.state = states;
    own.states = own.sequence.cuts * o->n;
    if (saltus_orbits_noted(o, status) == SALTUS_OK)
        saltus_starts_add(starts, &own, &o->starved);
    free(states);
}

void saltus_starts_add_ways(saltus_starts *starts, const saltus_branch_start *start, int direction,
                            bool *starved) {
    saltus_branch_start one = *start;
    for (int way = 1; way >= -1; way -= 2) {
        if (start->unknowns == 0)
            one.heading = way;
        if (direction * way >= 0)
            add(starts, &one, way, starved);
    }
}

saltus_branch_start saltus_starts_take(saltus_starts *starts) {
    saltus_branch_start first = starts->start[0];
    starts->begun++;
    starts->count--;
    memmove(starts->start, starts->start + 1, (size_t)starts->count * sizeof *starts->start);
    return first;
}

void saltus_branch_start_clear(saltus_branch_start *start) {
    free((void *)start->state);
    *start = (saltus_branch_start){.parent = -1};
}

void saltus_starts_remove(saltus_starts *starts, int k) {
    saltus_branch_start *start = &starts->start[k];
    saltus_branch_start_clear(start);
    starts->count--;
    memmove(start, start + 1, (size_t)(starts->count - k) * sizeof *start);
}

int saltus_starts_drop(saltus_starts *starts, int place) {
    const int count = starts->count;
    for (int k = count - 1; k >= 0; k--)
        if (starts->start[k].place == place)
            saltus_starts_remove(starts, k);
    return count - starts->count;
}

void saltus_starts_clear(saltus_starts *starts) {
    for (int k = 0; k < starts->count; k++)
        saltus_branch_start_clear(&starts->start[k]);
    free(starts->start);
    *starts = (saltus_starts){.count = 0};
}

/* Where curves cross, or at a flip. */
static saltus_status leave_crossing(saltus_orbits *o, const saltus_solution *at, saltus_branch_start *start,
                                    saltus_starts *starts, saltus_message *message) {
    const bool pitchfork = start->origin == SALTUS_POINT_PD || o->system->mirror;
    saltus_solution_cuts(at, &start->sequence);
    const int m = saltus_sequence_unknowns(&start->sequence, o->n) + 1;
    double *plane = calloc(3 * (size_t)m, sizeof *plane), *tangent = plane ? plane + 2 * m : NULL,
           *states = NULL, values[2];
    saltus_shooting *shooting = NULL;
    saltus_status status = plane ? saltus_orbits_evaluate(o, at, &start->sequence, &shooting, message)
                                 : saltus_branch_no_memory(message);
    if (status == SALTUS_OK)
        status = saltus_null_plane(&shooting->equations, plane, values, message);
    if (status == SALTUS_OK)
        status = saltus_solution_states_at(o, at, &start->sequence, &states, message);
    saltus_shooting_free(shooting);
    /* The new branch leaves along a unit vector in the null plane: at flips and pitchforks its own tangent,
     * along which the parameter is constant; otherwise orthogonal to the old tangent. */
    if (status == SALTUS_OK) {
        const double a = pitchfork ? plane[m - 1] : saltus_dot(plane, at->at.tangent, m),
                     c = pitchfork ? plane[2 * m - 1] : saltus_dot(plane + m, at->at.tangent, m);
        for (int j = 0; j < m; j++)
            tangent[j] = c * plane[j] - a * plane[m + j];
        saltus_make_unit(tangent, m);
        start->state = states;
        start->states = start->sequence.cuts * o->n;
        start->tangent = tangent;
        start->unknowns = m;
        /* At pitchforks and flips the other half of the branch is the image of this half. */
        saltus_starts_add_ways(starts, start, pitchfork, &o->starved);
    }
    free(plane);
    free(states);
    return status;
}

saltus_status saltus_starts_leave(saltus_orbits *o, const saltus_solution *at, saltus_point_kind kind,
                                  const saltus_sequence *beyond, const saltus_branch_start *like,
                                  saltus_starts *starts, saltus_message *message) {
    const bool grazes = kind == SALTUS_POINT_GR, flips = kind == SALTUS_POINT_PD;
    const saltus_sequence *own = &at->sequence;
    const saltus_sequence *more = grazes && beyond->count > own->count ? beyond : own;
    const saltus_sequence *less = grazes && more == own ? beyond : own;
    saltus_branch_start start = *like;
    start.origin = kind;
    start.parameter[0] = at->parameter[0];
    start.sequence = *own;
    const bool joins = (grazes || flips) && more->count == less->count + grazes &&
                       saltus_sequence_join(more, less, &start.sequence);
    if (flips && !joins)
        return saltus_fail(message, SALTUS_NO_CONVERGENCE, "twice the orbit has more than %d events",
                           SALTUS_MARKS_MAX);
    if (!grazes)
        return leave_crossing(o, at, &start, starts, message);
    if (joins && !saltus_special_forgets(&at->survey))
        saltus_starts_add_at(o, at, &start, starts);
    return SALTUS_OK;
}
