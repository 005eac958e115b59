/* Going on with an interrupted continuation from the points that it left.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/branch_private.h"

#include <math.h>
#include <string.h>

/* `here` becomes the orbit of a point, heading as it did. */
static saltus_status restore(saltus_branch *b, const saltus_branch_point *point, saltus_message *message) {
    saltus_sequence sequence;
    memcpy(b->state, point->state, (size_t)b->n * sizeof *b->state);
    saltus_status status = saltus_branch_tune(b, point->value[0], message);
    if (status == SALTUS_OK)
        status = saltus_sequence_make(b->flow, point->periods, b->state, &b->lap, &sequence, message);
    if (status == SALTUS_OK)
        status = saltus_branch_place(b, &sequence, point->value[0], b->state, true, message);
    if (status != SALTUS_OK)
        return status;
    int m = b->here.unknowns;
    bool backward = b->here.tangent[m - 1] * point->heading < 0;
    for (int j = 0; j < m && backward; j++)
        b->here.tangent[j] = -b->here.tangent[j];
    b->number = point->branch;
    b->parent = point->parent;
    b->arclength = b->shown = point->arclength;
    b->points = point->step + 1;
    b->step = b->options.step;
    b->fresh = false;
    b->reference[0] = b->reference[1] = NAN;
    return status;
}

static bool same_run(const saltus_branch *b, const saltus_branch_point *points, int count) {
    enum { periods_max = 100000 };
    for (int k = 0; k < count; k++) {
        const saltus_branch_point *p = &points[k];
        bool sound = p->dimension == b->n && p->spec.model == b->spec.model && p->state &&
                     p->kind >= SALTUS_POINT_REGULAR && p->kind < SALTUS_POINT_KINDS && p->branch >= 0 &&
                     p->branch < b->start_count + count && p->step >= 0 && p->periods >= 1 &&
                     p->periods <= periods_max && isfinite(p->value[0]) && isfinite(p->arclength) &&
                     isfinite(p->heading);
        for (int i = 0; i < b->n && sound; i++)
            sound = isfinite(p->state[i]);
        if (!sound)
            return false;
    }
    return count > 0;
}

saltus_status saltus_branch_resume(saltus_branch *b, const saltus_branch_point *points, int count, int *kept,
                                   saltus_message *message) {
    *kept = 0;
    if (!same_run(b, points, count))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "the points to resume from are unsound or belong to another run");
    if (b->options.locus || b->options.switches)
        return SALTUS_OK;
    int last = count - 1;
    while (last >= 0 && points[last].kind != SALTUS_POINT_REGULAR && points[last].kind != SALTUS_POINT_EP)
        last--;
    saltus_status status = SALTUS_OK;
    *kept = last + 1;
    if (last < 0)
        return status;
    if (points[last].branch >= b->start_count)
        return saltus_fail(message, SALTUS_BAD_INPUT, "the points to resume from belong to another run");
    b->start_next = points[last].branch + 1;
    if (points[last].kind == SALTUS_POINT_EP)
        return status;
    status = restore(b, &points[last], message);
    if (status == SALTUS_OK)
        status = saltus_branch_test(b, &b->here, message);
    if (status == SALTUS_OK)
        status = saltus_branch_survey(b, &b->here, message);
    saltus_branch_remember(b);
    b->running = status == SALTUS_OK;
    return status;
}
