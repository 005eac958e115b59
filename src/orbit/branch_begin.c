/* Where branches begin: from an orbit, from a flip, from a branch point; and the moving of an orbit's base.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/branch_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The null vector of the Jacobian just evaluated: the tangent but for its sign. */
static saltus_status find_tangent(saltus_pursuit *pursuit, double *tangent, saltus_message *message) {
    int m = saltus_pursuit_unknowns(pursuit);
    double values[2], *vectors = calloc(2 * (size_t)m, sizeof *vectors);
    if (!vectors)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    saltus_status status = saltus_pursuit_null_plane(pursuit, vectors, values, message);
    memcpy(tangent, vectors, (size_t)m * sizeof *tangent);
    free(vectors);
    return status;
}

/* Take on a sequence and put `here` on it. */
saltus_status saltus_branch_place(saltus_branch *b, const saltus_sequence *sequence, double value,
                                  const double *state, bool polish, saltus_message *message) {
    int iterations = 0;
    saltus_status status = saltus_pursuit_shape(b->pursuit, sequence, message);
    if (status == SALTUS_OK && !saltus_solution_room(&b->here, saltus_pursuit_unknowns(b->pursuit), b->n))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    if (status == SALTUS_OK)
        status = saltus_pursuit_fill(b->pursuit, value, state, b->here.u, message);
    if (status == SALTUS_OK && polish)
        status = saltus_pursuit_correct(b->pursuit, b->here.u, NULL, NULL, true, &iterations, message);
    else if (status == SALTUS_OK)
        status = saltus_pursuit_evaluate(b->pursuit, b->here.u, message);
    if (status == SALTUS_OK)
        status = find_tangent(b->pursuit, b->here.tangent, message);
    b->here.ahead = 0;
    b->here.iterations = iterations;
    return saltus_branch_noted(b, status);
}

static void point_tangent(saltus_solution *s, double sense) {
    for (int j = 0; j < s->unknowns && sense < 0; j++)
        s->tangent[j] = -s->tangent[j];
}

/* Keep the section points of the orbit just walked as those of the branch's first. */
static saltus_status keep_first(saltus_branch *b, double value, saltus_message *message) {
    int n = b->n, periods = b->lap.periods;
    saltus_event event;
    double *grown = realloc(b->first, (size_t)(n * periods) * sizeof *grown);
    if (!grown)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    b->first = grown;
    b->first_count = 1;
    b->first_value = value;
    memcpy(grown, b->lap.points, (size_t)n * sizeof *grown);
    saltus_message ignored;
    saltus_status status = saltus_flow_start(b->flow, 0, (saltus_time){0, 0}, grown, &ignored);
    for (int k = 1; k < periods && status == SALTUS_OK; k++) {
        status = saltus_flow_advance(b->flow, (saltus_time){k, 0}, 0, &event, &ignored);
        saltus_flow_state(b->flow, 0, grown + k * n);
        b->first_count += status == SALTUS_OK;
    }
    return SALTUS_OK;
}

bool saltus_branch_is_first(const saltus_branch *b) {
    return saltus_orbit_passes(b->system, b->first, b->first_count, b->lap.points, 1e-6);
}

saltus_status saltus_branch_begin(saltus_branch *b, const saltus_branch_start *start,
                                  saltus_message *message) {
    b->number = b->start_next - 1;
    b->parent = start->parent;
    b->depth = start->depth;
    b->points = b->made = b->first_count = 0;
    b->arclength = b->shown = 0;
    b->step = b->options.step;
    b->fresh = start->tangent != NULL;
    b->running = true;
    saltus_message why = {""};
    saltus_status status = saltus_branch_place(b, &start->sequence, start->value, start->state,
                                               !start->tangent && !start->grazes, &why);
    if (status == SALTUS_OK && start->grazes) {
        b->running = saltus_branch_go_on(b, b->here.tangent);
        b->last_label[0] = 0;
        return b->running ? saltus_branch_accept(b, message) : SALTUS_OK;
    }
    if (status == SALTUS_OK && start->tangent)
        memcpy(b->here.tangent, start->tangent, (size_t)start->unknowns * sizeof *start->tangent);
    else if (status == SALTUS_OK)
        point_tangent(&b->here, b->here.tangent[b->here.unknowns - 1] * start->heading);
    if (status != SALTUS_OK) {
        b->running = false;
        return status == SALTUS_NO_MEMORY ? saltus_fail(message, status, "%s", why.text) : SALTUS_OK;
    }
    b->reference[0] = b->reference[1] = NAN;
    for (int k = 0; k < SALTUS_TESTS; k++)
        b->here.test[k] = -1;
    if (start->tangent == NULL)
        status = saltus_branch_test(b, &b->here, message);
    bool changed;
    if (status == SALTUS_OK)
        status = saltus_branch_survey(b, &b->here, message);
    if (status == SALTUS_OK)
        status = saltus_branch_emit(b, &b->here, SALTUS_POINT_REGULAR, NAN, NULL, NULL, message);
    for (int k = 0; k < b->options.value_count && status == SALTUS_OK; k++)
        if (b->options.values[k] == start->value)
            status = saltus_branch_emit(b, &b->here, SALTUS_POINT_UZ, 0, NULL, NULL, message);
    if (status == SALTUS_OK)
        status = keep_first(b, start->value, message);
    if (status == SALTUS_OK && !start->tangent)
        status = saltus_branch_reframe(b, NULL, &changed, message);
    b->points = 1;
    saltus_branch_remember(b);
    double bound = start->heading > 0 ? b->options.high[0] : b->options.low[0];
    if (status == SALTUS_OK && start->heading && start->value == bound)
        return saltus_branch_end(b, &b->here, 0, "end of the parameter's range", message);
    return status;
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
    saltus_status status = saltus_pursuit_shape(b->pursuit, &cut, message);
    int m = saltus_pursuit_unknowns(b->pursuit);
    if (status == SALTUS_OK && !saltus_solution_room(&b->trial, m, b->n))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    if (status == SALTUS_OK)
        status = saltus_pursuit_fill(b->pursuit, value, state, b->trial.u, message);
    for (int i = 0; i < b->n && status == SALTUS_OK; i++)
        state[i] = b->trial.u[b->n + i] * saltus_pursuit_scale(b->pursuit)[i];
    return status;
}

/* Leave the tail of a long run of ever slower impacts to the flow (sequence.h). `order` follows. */
static bool trim_runs(const saltus_branch *b, saltus_sequence *s, int *order) {
    double speed[SALTUS_MARKS_MAX];
    int count = s->count, kept = 0;
    for (int k = 0; k < count; k++)
        speed[k] = saltus_pursuit_speed(b->pursuit, order[k]);
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
    bool crowded = saltus_pursuit_growth(b->pursuit) > growth_max && 2 * old->cuts <= SALTUS_CUTS_MAX / 2;
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
    saltus_pursuit_extract(b->pursuit, b->here.u, &old, b->state);
    *changed = better_frame(b, &old, &fresh, order);
    if (!*changed)
        return SALTUS_OK;
    double value = saltus_pursuit_value(b->pursuit, b->here.u);
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
        point_tangent(&b->here, common_sense(&old, tangent, &fresh, b->here.tangent, order, b->n));
    for (int k = 0, was = tracked ? *tracked : -1; k < fresh.count && tracked; k++)
        if (order[k] == was)
            *tracked = k;
    free(tangent);
    return status == SALTUS_OK || status == SALTUS_NO_MEMORY
               ? status
               : saltus_fail(message, SALTUS_NO_CONVERGENCE, "%s", why.text);
}

/* The orbit gone through twice. */
static void double_sequence(const saltus_sequence *s, saltus_sequence *twice) {
    *twice = *s;
    twice->periods = 2 * s->periods;
    twice->count = 2 * s->count;
    for (int k = 0; k < s->count; k++) {
        twice->mark[s->count + k] = s->mark[k];
        twice->mark[s->count + k].time += s->periods;
    }
}

/* The flip's determinant of the orbit at a parameter value, relative to the first one asked for. */
static bool flip_at(saltus_pursuit *half, double value, double *u, double *reference, double *test) {
    int sign, iterations, m = saltus_pursuit_unknowns(half);
    double log_modulus;
    saltus_message ignored;
    u[m - 1] += (value - saltus_pursuit_value(half, u)) / saltus_pursuit_scale(half)[m - 1];
    if (saltus_pursuit_correct(half, u, NULL, NULL, false, &iterations, &ignored) != SALTUS_OK)
        return false;
    saltus_pursuit_flip(half, &sign, &log_modulus);
    if (isnan(*reference))
        *reference = log_modulus;
    *test = sign * exp(log_modulus - *reference);
    return true;
}

/* Secants in the parameter. */
static bool secants_to_flip(saltus_pursuit *half, double *u, double unit, double *value, double *accuracy) {
    enum { secants_max = 12 };
    double reference = NAN, last = *value, now = last + 1e-5 * unit, before, test;
    if (!flip_at(half, last, u, &reference, &before))
        return false;
    for (int k = 0; k < secants_max; k++) {
        if (!flip_at(half, now, u, &reference, &test) || test == before)
            return false;
        double next = now - test * (now - last) / (test - before);
        *accuracy = fabs(next - now);
        last = now;
        before = test;
        now = next;
        if (!(fabs(now - *value) < 1e-3 * unit))
            return false;
        if (*accuracy < 1e-12 * unit) {
            *value = now;
            return true;
        }
    }
    return false;
}

bool saltus_branch_flip_of_half(saltus_branch *b, double *value, double *accuracy) {
    saltus_sequence sequence;
    saltus_pursuit *half = NULL;
    saltus_message ignored;
    saltus_pursuit_extract(b->pursuit, b->trial.u, &sequence, b->state);
    *value = saltus_pursuit_value(b->pursuit, b->trial.u);
    if (sequence.count % 2)
        return false;
    sequence.cuts = 1;
    sequence.periods /= 2;
    sequence.count /= 2;
    double *u = calloc((size_t)(b->n + sequence.count + 1), sizeof *u);
    saltus_status status = u ? saltus_pursuit_new(&b->spec, &b->direction, b->origin, b->unit,
                                                  &b->options.orbit, &half, &ignored)
                             : SALTUS_NO_MEMORY;
    if (status == SALTUS_OK)
        status = saltus_pursuit_shape(half, &sequence, &ignored);
    if (status == SALTUS_OK)
        status = saltus_pursuit_fill(half, *value, b->state, u, &ignored);
    bool found =
        saltus_branch_noted(b, status) == SALTUS_OK && secants_to_flip(half, u, b->unit, value, accuracy);
    saltus_pursuit_free(half);
    free(u);
    return found;
}

saltus_status saltus_branch_switch_grazing(saltus_branch *b, const saltus_sequence *more,
                                           const saltus_sequence *less, double value, double *state,
                                           saltus_message *message) {
    saltus_sequence mixed = *more;
    if (b->depth >= b->options.switches || more->count != less->count + 1 ||
        more->count + less->count > SALTUS_MARKS_MAX)
        return SALTUS_OK;
    mixed.cuts = 1;
    mixed.periods = 2 * more->periods;
    mixed.count = more->count + less->count;
    for (int k = 0; k < less->count; k++) {
        mixed.mark[more->count + k] = less->mark[k];
        mixed.mark[more->count + k].time += more->periods;
    }
    saltus_branch_start start = {.sequence = mixed,
                                 .value = value,
                                 .state = state,
                                 .grazes = true,
                                 .parent = b->number,
                                 .depth = b->depth + 1};
    return saltus_branch_add_start(b, &start, message);
}

/* The old tangent, of a sequence with `cuts` cuts, among the unknowns without them. */
static void join_tangent(const saltus_sequence *s, int cuts, const double *old, int n, double *tangent) {
    memcpy(tangent, old, (size_t)n * sizeof *old);
    memcpy(tangent + n, old + cuts * n, (size_t)(s->count + 1) * sizeof *old);
}

/* In the null plane, the unit vector that leaves the old branch: at flips and pitchforks the one along which
 * the parameter does not change, which is the new branch's tangent; otherwise that across the old tangent. */
static void leaving(const double *plane, const double *old, int m, bool pitchfork, double *out) {
    double a = 0, c = 0, size = 0;
    for (int j = pitchfork ? m - 1 : 0; j < m; j++) {
        a += plane[j] * (pitchfork ? 1 : old[j]);
        c += plane[m + j] * (pitchfork ? 1 : old[j]);
    }
    for (int j = 0; j < m; j++) {
        out[j] = c * plane[j] - a * plane[m + j];
        size = hypot(size, out[j]);
    }
    for (int j = 0; j < m; j++)
        out[j] /= size;
}

/* `cuts` is how many the old branch has where this is not a flip or pitchfork. */
static saltus_status leave(saltus_branch *b, const saltus_sequence *sequence, int cuts, bool pitchfork,
                           saltus_message *message) {
    saltus_pursuit *pursuit = NULL;
    int m = b->n + sequence->count + 1;
    double values[2], *work = calloc(5 * (size_t)m, sizeof *work);
    double *u = work, *plane = work + m, *old = work + 3 * (size_t)m, *tangent = work + 4 * (size_t)m;
    double value = saltus_pursuit_value(b->pursuit, b->trial.u);
    saltus_status status =
        work ? SALTUS_OK : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch");
    if (status == SALTUS_OK)
        status = saltus_pursuit_new(&b->spec, &b->direction, b->origin, b->unit, &b->options.orbit, &pursuit,
                                    message);
    if (status == SALTUS_OK)
        status = saltus_pursuit_shape(pursuit, sequence, message);
    if (status == SALTUS_OK)
        status = saltus_pursuit_fill(pursuit, value, b->state, u, message);
    if (status == SALTUS_OK)
        status = saltus_pursuit_evaluate(pursuit, u, message);
    if (status == SALTUS_OK)
        status = saltus_pursuit_null_plane(pursuit, plane, values, message);
    if (status == SALTUS_OK) {
        if (!pitchfork)
            join_tangent(sequence, cuts, b->trial.tangent, b->n, old);
        leaving(plane, old, m, pitchfork, tangent);
        saltus_branch_start start = {.sequence = *sequence,
                                     .value = value,
                                     .state = b->state,
                                     .tangent = tangent,
                                     .unknowns = m,
                                     .parent = b->number,
                                     .depth = b->depth + 1};
        status = saltus_branch_add_start(b, &start, message);
        for (int j = 0; j < m; j++)
            tangent[j] = -tangent[j];
        if (!pitchfork && status == SALTUS_OK)
            status = saltus_branch_add_start(b, &start, message);
    }
    saltus_pursuit_free(pursuit);
    free(work);
    return status == SALTUS_NO_MEMORY ? status : SALTUS_OK;
}

saltus_status saltus_branch_switch(saltus_branch *b, saltus_point_kind kind, saltus_message *message) {
    saltus_sequence here, twice;
    bool shift, mirror = saltus_system_mirror_symmetric(b->system, &shift);
    saltus_pursuit_extract(b->pursuit, b->trial.u, &here, b->state);
    int cuts = here.cuts;
    here.cuts = 1;
    if (b->depth >= b->options.switches || 2 * here.count > SALTUS_MARKS_MAX)
        return SALTUS_OK;
    if (kind == SALTUS_POINT_BP)
        return leave(b, &here, cuts, mirror, message);
    double_sequence(&here, &twice);
    return leave(b, &twice, cuts, true, message);
}
