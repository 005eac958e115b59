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
    double *own = calloc((size_t)(start->states + start->unknowns), sizeof *own);
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

/* The sequence once around one orbit and then around another, with the cuts of `at`, whose states are `once`,
 * both times, and the states there; one cut will do where errors grow little, and must where the base is no
 * free flight. False if there are too many marks. */
static bool join(const saltus_solution *at, const double *once, int n, const saltus_sequence *first,
                 const saltus_sequence *second, saltus_sequence *joined, double *states) {
    const double little = 1e2; /* once around; twice around it is the square */
    const int cuts = at->sequence.cuts;
    const bool finer = cuts > 1 || (at->growth > little && !at->sequence.driven && !at->sequence.contacts);
    const int all = finer ? 2 * cuts : 1, every = all > SALTUS_CUTS_MAX ? 2 : 1;
    if (!saltus_sequence_join(first, second, joined))
        return false;
    joined->cuts = 0;
    for (int j = 0; j < all; j += every) {
        joined->cut[joined->cuts] = at->sequence.cut[j % cuts] + (j < cuts ? 0 : at->sequence.periods);
        memcpy(states + joined->cuts++ * n, once + j % cuts * n, (size_t)n * sizeof *states);
    }
    return true;
}

/* Where curves cross, or at a flip; `work` has room for three tangents of the start. */
static saltus_status leave_crossing(saltus_orbits *o, const saltus_solution *at, saltus_branch_start *start,
                                    double *work, saltus_starts *starts, saltus_message *message) {
    const bool pitchfork = start->origin == SALTUS_POINT_PD || o->system->mirror;
    const int m = saltus_sequence_unknowns(&start->sequence, o->n) + 1;
    double *plane = work, *tangent = work + 2 * m, values[2];
    saltus_shooting *shooting = NULL;
    saltus_status status = saltus_orbits_evaluate(o, &start->sequence, at->parameter, start->state,
                                                  start->sequence.cuts, &shooting, message);
    if (status == SALTUS_OK)
        status = saltus_null_plane(saltus_shooting_equations(shooting), plane, values, message);
    saltus_shooting_free(shooting);
    if (status != SALTUS_OK)
        return status;
    /* The new branch leaves along a unit vector in the null plane: at flips and pitchforks its own tangent,
     * along which the parameter is constant; otherwise orthogonal to the old tangent. */
    const double a = pitchfork ? plane[m - 1] : saltus_dot(plane, at->at.tangent, m),
                 c = pitchfork ? plane[2 * m - 1] : saltus_dot(plane + m, at->at.tangent, m);
    for (int j = 0; j < m; j++)
        tangent[j] = c * plane[j] - a * plane[m + j];
    saltus_make_unit(tangent, m);
    start->tangent = tangent;
    start->unknowns = m;
    /* At pitchforks and flips the other half of the branch is the image of this half. */
    saltus_starts_add_ways(starts, start, pitchfork, &o->starved);
    return SALTUS_OK;
}

saltus_status saltus_starts_leave(saltus_orbits *o, const saltus_solution *at, saltus_point_kind kind,
                                  const saltus_sequence *beyond, const saltus_branch_start *like,
                                  saltus_starts *starts, saltus_message *message) {
    const bool grazes = kind == SALTUS_POINT_GR, flips = kind == SALTUS_POINT_PD;
    const saltus_sequence *own = &at->sequence;
    const saltus_sequence *more = grazes && beyond->count > own->count ? beyond : own;
    const saltus_sequence *less = grazes && more == own ? beyond : own;
    const size_t m = (size_t)at->at.unknowns;
    double *once = calloc(9 * m, sizeof *once);
    saltus_branch_start start = *like;
    saltus_status status = SALTUS_OK;
    if (!once)
        return saltus_branch_no_memory(message);
    double *states = once + m, *work = states + 2 * m;
    saltus_solution_states(o, at, once);
    start.origin = kind;
    start.parameter = at->parameter[0];
    start.sequence = *own;
    start.state = grazes || flips ? states : once;
    const bool joins = (grazes || flips) && more->count == less->count + grazes &&
                       join(at, once, o->n, more, less, &start.sequence, states);
    start.states = start.sequence.cuts * o->n;
    if (flips && !joins)
        status = saltus_fail(message, SALTUS_NO_CONVERGENCE, "twice the orbit has more than %d events",
                             SALTUS_MARKS_MAX);
    else if (!grazes)
        status = leave_crossing(o, at, &start, work, starts, message);
    else if (joins)
        saltus_starts_add(starts, &start, &o->starved);
    free(once);
    return status;
}
