/* Where other branches begin.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/sequence.h"
#include "branch/special.h"

#include <stdlib.h>
#include <string.h>

void saltus_starts_add(saltus_starts *starts, const saltus_branch_start *start, bool *starved) {
    const size_t room = ((size_t)starts->count + 1) * sizeof *starts->start;
    saltus_branch_start *grown = realloc(starts->start, room);
    *starved |= !grown;
    if (!grown)
        return;
    starts->start = grown;
    grown[starts->count++] = *start;
}

void saltus_starts_add_ways(saltus_starts *starts, saltus_branch_start *start, int direction, bool *starved) {
    for (int way = 1; way >= -1; way -= 2) {
        for (int j = 0; j < start->unknowns && way < 0; j++)
            start->tangent[j] = -start->tangent[j];
        if (start->unknowns == 0)
            start->heading = way;
        if (direction * way >= 0)
            saltus_starts_add(starts, start, starved);
    }
}

saltus_branch_start saltus_starts_take(saltus_starts *starts) {
    saltus_branch_start first = starts->start[0];
    starts->begun++;
    starts->count--;
    memmove(starts->start, starts->start + 1, (size_t)starts->count * sizeof *starts->start);
    return first;
}

int saltus_starts_drop(saltus_starts *starts, int place) {
    int kept = 0, count = starts->count;
    for (int k = 0; k < count; k++)
        if (starts->start[k].place != place)
            starts->start[kept++] = starts->start[k];
    starts->count = kept;
    return count - kept;
}

void saltus_starts_clear(saltus_starts *starts) {
    free(starts->start);
    *starts = (saltus_starts){.count = 0};
}

/* At grazing. */
static void leave_grazing(const saltus_solution *at, const saltus_sequence *beyond,
                          const saltus_branch_start *like, saltus_starts *starts, bool *starved) {
    const saltus_sequence *more = beyond->count > at->sequence.count ? beyond : &at->sequence;
    const saltus_sequence *less = more == beyond ? &at->sequence : beyond;
    saltus_branch_start start = *like;
    start.parameter = at->parameter[0];
    memcpy(start.state, at->state, sizeof start.state);
    start.origin = SALTUS_POINT_GR;
    if (more->count == less->count + 1 && saltus_sequence_join(more, less, &start.sequence))
        saltus_starts_add(starts, &start, starved);
}

saltus_status saltus_starts_leave(saltus_orbits *o, const saltus_solution *at, saltus_point_kind kind,
                                  const saltus_sequence *beyond, const saltus_branch_start *like,
                                  saltus_starts *starts, saltus_message *message) {
    const bool flips = kind == SALTUS_POINT_PD;
    const bool pitchfork = flips || o->system->mirror;
    double plane[2 * SALTUS_START_UNKNOWNS_MAX], values[2], old[SALTUS_START_UNKNOWNS_MAX];
    saltus_shooting *shooting = NULL;
    saltus_branch_start start = *like;
    start.sequence = at->sequence;
    start.sequence.cuts = 1;
    if (kind == SALTUS_POINT_GR) {
        leave_grazing(at, beyond, like, starts, &o->starved);
        return SALTUS_OK;
    }
    if (flips && !saltus_sequence_join(&at->sequence, &at->sequence, &start.sequence))
        return saltus_fail(message, SALTUS_NO_CONVERGENCE, "twice the orbit has more than %d events",
                           SALTUS_MARKS_MAX);
    saltus_status status =
        saltus_orbits_evaluate(o, &start.sequence, at->parameter, at->state, &shooting, message);
    if (status == SALTUS_OK)
        status = saltus_null_plane(saltus_shooting_equations(shooting), plane, values, message);
    saltus_shooting_free(shooting);
    if (status != SALTUS_OK)
        return status;
    if (!pitchfork)
        saltus_sequence_carry(&at->sequence, at->at.tangent, &start.sequence, NULL, o->n, 1, old);
    start.parameter = at->parameter[0];
    memcpy(start.state, at->state, sizeof start.state);
    start.unknowns = saltus_sequence_unknowns(&start.sequence, o->n) + 1;
    start.origin = kind;
    /* The new branch leaves along a unit vector in the null plane: at flips and pitchforks its own tangent,
     * along which the parameter is constant; otherwise orthogonal to the old tangent. */
    const int m = start.unknowns;
    const double a = pitchfork ? plane[m - 1] : saltus_dot(plane, old, m),
                 c = pitchfork ? plane[2 * m - 1] : saltus_dot(plane + m, old, m);
    for (int j = 0; j < m; j++)
        start.tangent[j] = c * plane[j] - a * plane[m + j];
    saltus_make_unit(start.tangent, m);
    /* At pitchforks and flips the other half of the branch is the image of this half. */
    saltus_starts_add_ways(starts, &start, pitchfork, &o->starved);
    return SALTUS_OK;
}
