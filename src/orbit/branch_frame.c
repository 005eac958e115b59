/* How an orbit is cut into unknowns: its sequence of events, the base from which times count, the segments.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/branch_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The null vector of the Jacobian just evaluated: the tangent but for its sign. */
static saltus_status find_tangent(saltus_shooting *shooting, double *tangent, saltus_message *message) {
    int m = saltus_shooting_unknowns(shooting);
    double values[2], *vectors = calloc(2 * (size_t)m, sizeof *vectors);
    if (!vectors)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    saltus_status status = saltus_shooting_null_plane(shooting, vectors, values, message);
    memcpy(tangent, vectors, (size_t)m * sizeof *tangent);
    free(vectors);
    return status;
}

/* Take on a sequence and put `here` on it. */
saltus_status saltus_branch_place(saltus_branch *b, const saltus_sequence *sequence, double value,
                                  const double *state, bool polish, saltus_message *message) {
    int iterations = 0;
    saltus_status status = saltus_shooting_shape(b->shooting, sequence, message);
    if (status == SALTUS_OK && !saltus_solution_room(&b->here, saltus_shooting_unknowns(b->shooting), b->n))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    if (status == SALTUS_OK)
        status = saltus_shooting_fill(b->shooting, value, state, b->here.u, message);
    if (status == SALTUS_OK && polish)
        status = saltus_shooting_correct(b->shooting, b->here.u, NULL, NULL, true, &iterations, message);
    else if (status == SALTUS_OK)
        status = saltus_shooting_evaluate(b->shooting, b->here.u, message);
    if (status == SALTUS_OK)
        status = find_tangent(b->shooting, b->here.tangent, message);
    b->here.ahead = 0;
    b->here.iterations = iterations;
    return saltus_branch_noted(b, status);
}

/* Whether a face holds, or the flow finds its own events, just after each mark. */
static void find_bound(const saltus_sequence *s, bool *bound) {
    unsigned held = s->contacts;
    for (int k = 0; k < s->count; k++) {
        const saltus_mark *mark = &s->mark[k];
        if (mark->kind == SALTUS_RELEASE)
            held &= ~(1u << mark->face);
        else if (mark->kind == SALTUS_STICK || mark->driven)
            held |= 1u << mark->face;
        bound[k] = held != 0;
    }
}

/* Cuts at about equal distances, in free flight and away from marks. */
static void cut_evenly(saltus_sequence *s, int cuts) {
    bool bound[SALTUS_MARKS_MAX];
    find_bound(s, bound);
    s->cuts = 1;
    s->cut[0] = s->base;
    if (s->driven || s->contacts)
        return;
    for (int j = 1; j < cuts; j++) {
        double at = s->base + (double)j * s->periods / cuts;
        int k = s->count - 1;
        while (k >= 0 && s->mark[k].time > at)
            k--;
        double from = k < 0 ? s->base : s->mark[k].time;
        double to = k + 1 < s->count ? s->mark[k + 1].time : s->base + s->periods;
        at = fmin(fmax(at, from + 0.2 * (to - from)), to - 0.2 * (to - from));
        if ((k < 0 || !bound[k]) && at > s->cut[s->cuts - 1] + 0.02)
            s->cut[s->cuts++] = at;
    }
}

/* The middle of the longest free flight between two marks that the flow need not find its events in; the
 * present base if there is none. */
static double better_base(const saltus_sequence *s) {
    double best = 0, base = s->base;
    bool bound[SALTUS_MARKS_MAX];
    find_bound(s, bound);
    for (int k = 0; k < s->count; k++) {
        double next = k + 1 < s->count ? s->mark[k + 1].time : s->mark[0].time + s->periods;
        if (!bound[k] && next - s->mark[k].time > best) {
            best = next - s->mark[k].time;
            base = s->mark[k].time + 0.5 * best;
        }
    }
    return base < s->base + s->periods ? base : base - s->periods;
}

/* The sequence cut open at a later time; order[k] is the place of its k-th mark in the old one. */
static void rotate(const saltus_sequence *old, double base, saltus_sequence *fresh, int *order) {
    int first = 0;
    while (first < old->count && old->mark[first].time < base)
        first++;
    double back = base >= old->periods ? old->periods : 0;
    *fresh = *old;
    fresh->base = fresh->cut[0] = base - back;
    fresh->contacts = 0;
    fresh->driven = false;
    for (int k = 0; k < old->count; k++) {
        order[k] = (first + k) % old->count;
        fresh->mark[k] = old->mark[order[k]];
        fresh->mark[k].time += (first + k >= old->count ? old->periods : 0) - back;
    }
}

/* The sign of a new tangent from what it has in common with the old one: the parameter, the times of the
 * marks and, at the same base, the state. */
static double common_sense(const saltus_sequence *old, const double *before, const saltus_sequence *fresh,
                           const double *after, const int *order, int n) {
    const double *old_times = before + old->cuts * n, *times = after + fresh->cuts * n;
    double sum = old_times[old->count] * times[fresh->count];
    for (int k = 0; k < fresh->count; k++)
        sum += old_times[order[k]] * times[k];
    for (int i = 0; i < n && fresh->base == old->base; i++)
        sum += before[i] * after[i];
    return sum;
}

/* The state at a later base follows through the prescribed events: it is the state at a second cut. */
static saltus_status state_at(saltus_branch *b, const saltus_sequence *old, double base, double value,
                              double *state, saltus_message *message) {
    saltus_sequence cut = *old;
    cut.cuts = 2;
    cut.cut[0] = old->base;
    cut.cut[1] = base;
    saltus_status status = saltus_shooting_shape(b->shooting, &cut, message);
    int m = saltus_shooting_unknowns(b->shooting);
    if (status == SALTUS_OK && !saltus_solution_room(&b->trial, m, b->n))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    if (status == SALTUS_OK)
        status = saltus_shooting_fill(b->shooting, value, state, b->trial.u, message);
    for (int i = 0; i < b->n && status == SALTUS_OK; i++)
        state[i] = b->trial.u[b->n + i] * saltus_shooting_scale(b->shooting)[i];
    return status;
}

/* Leave the tail of a long run of ever slower impacts to the flow (sequence.h). `order` follows. */
static bool trim_runs(const saltus_branch *b, saltus_sequence *s, int *order) {
    double speed[SALTUS_MARKS_MAX];
    int count = s->count, kept = 0;
    for (int k = 0; k < count; k++)
        speed[k] = saltus_shooting_speed(b->shooting, order[k]);
    for (int k = 0; k < count; k++) {
        if (kept > 0 && saltus_sequence_in_tail(s, speed, kept, s->mark[k].face, speed[k]) &&
            s->mark[k].kind == SALTUS_IMPACT && !s->mark[k].driven) {
            s->mark[kept - 1].driven = true;
            continue;
        }
        s->mark[kept] = s->mark[k];
        speed[kept] = speed[k];
        order[kept++] = order[k];
    }
    s->count = kept;
    return kept < count;
}

/* As many segments as are asked for; if that is left open, twice as many where perturbations grow too much
 * over one. */
static int count_cuts(const saltus_branch *b, const saltus_sequence *old) {
    const double growth_max = 1e4;
    int asked = b->options.orbit.segments;
    if (asked > 0)
        return asked < SALTUS_CUTS_MAX ? asked : SALTUS_CUTS_MAX;
    bool crowded = saltus_shooting_growth(b->shooting) > growth_max && 2 * old->cuts <= SALTUS_CUTS_MAX / 2;
    return crowded ? 2 * old->cuts : old->cuts;
}

/* Whether an event comes near a cut, over which it cannot pass. */
static bool cuts_are_tight(const saltus_sequence *s) {
    const double share_min = 0.05;
    for (int j = 1; j < s->cuts; j++) {
        double before = s->cut[j] - s->base, after = s->base + s->periods - s->cut[j];
        for (int k = 0; k < s->count; k++) {
            double since = s->cut[j] - s->mark[k].time;
            if (since >= 0)
                before = fmin(before, since);
            else
                after = fmin(after, -since);
        }
        if (fmin(before, after) < share_min * (before + after))
            return true;
    }
    return false;
}

/* The sequence that `here` should have; false if it is good as it is. */
static bool better_frame(const saltus_branch *b, const saltus_sequence *old, saltus_sequence *fresh,
                         int *order) {
    double base = old->base;
    if (old->count > 0) {
        double before = old->mark[0].time - old->base;
        double after = old->base + old->periods - old->mark[old->count - 1].time;
        if (fmin(before, after) <= 0.08 * (before + after))
            base = fmax(base, better_base(old));
    }
    rotate(old, base, fresh, order);
    if (base == old->base) {
        fresh->contacts = old->contacts;
        fresh->driven = old->driven;
    }
    bool trimmed = b->options.locus != SALTUS_POINT_GR && trim_runs(b, fresh, order);
    cut_evenly(fresh, count_cuts(b, old));
    return trimmed || base != old->base || fresh->cuts > old->cuts || cuts_are_tight(old);
}

saltus_status saltus_branch_reframe(saltus_branch *b, int *tracked, bool *changed, saltus_message *message) {
    saltus_sequence old, fresh;
    int order[SALTUS_MARKS_MAX], m = b->here.unknowns;
    saltus_shooting_extract(b->shooting, b->here.u, &old, b->state);
    *changed = better_frame(b, &old, &fresh, order);
    if (!*changed)
        return SALTUS_OK;
    double value = saltus_shooting_value(b->shooting, b->here.u);
    double *tangent = calloc((size_t)m, sizeof *tangent);
    if (!tangent)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    memcpy(tangent, b->here.tangent, (size_t)m * sizeof *tangent);
    saltus_message why = {""};
    saltus_status status = SALTUS_OK;
    double ahead = fresh.base < old.base ? fresh.base + old.periods : fresh.base;
    if (ahead != old.base)
        status = state_at(b, &old, ahead, value, b->state, &why);
    if (status == SALTUS_OK)
        status = saltus_branch_place(b, &fresh, value, b->state, false, &why);
    if (status == SALTUS_OK)
        saltus_solution_point(&b->here, common_sense(&old, tangent, &fresh, b->here.tangent, order, b->n));
    for (int k = 0, was = tracked ? *tracked : -1; k < fresh.count && tracked; k++)
        if (order[k] == was)
            *tracked = k;
    free(tangent);
    return status == SALTUS_OK || status == SALTUS_NO_MEMORY
               ? status
               : saltus_fail(message, SALTUS_NO_CONVERGENCE, "%s", why.text);
}
