/* Edits of event sequences.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/sequence.h"

#include "orbit/sequence.h"

#include <math.h>

/* Breaches this close to zero change together, as on orbits that are their own mirror images. */
static const double together = 1e-7;

void saltus_sequence_without(const saltus_sequence *old, const bool gone[SALTUS_MARKS_MAX],
                             saltus_sequence *fresh, int *order) {
    *fresh = *old;
    fresh->count = 0;
    for (int k = 0; k < old->count; k++)
        if (!gone[k]) {
            if (order)
                order[fresh->count] = k;
            fresh->mark[fresh->count++] = old->mark[k];
        }
}

const char *saltus_sequence_graze(const saltus_sequence *old, const saltus_breach *breaches, int count,
                                  saltus_sequence *fresh, int *order) {
    bool dies[SALTUS_MARKS_MAX] = {false};
    int born = 0, unasked[SALTUS_MARKS_MAX];
    order = order ? order : unasked;
    for (int k = 0; k < count; k++)
        if (breaches[k].kind == SALTUS_BREACH_SPEED && fabs(breaches[k].value) < together)
            dies[breaches[k].mark] = true;
    saltus_sequence_without(old, dies, fresh, order);
    const int dead = old->count - fresh->count;
    for (int k = 0; k < count; k++) {
        const saltus_breach *touch = &breaches[k];
        bool is_born = touch->kind == SALTUS_BREACH_GAP && fabs(touch->value) < together;
        /* A maximum at a mark is that mark's own touch. */
        for (int j = 0; j < old->count && is_born; j++)
            is_born = old->mark[j].face != touch->face || !(fabs(old->mark[j].time - touch->time) < 1e-5);
        if (!is_born || fresh->count == SALTUS_MARKS_MAX)
            continue;
        int at = fresh->count++;
        for (; at > 0 && fresh->mark[at - 1].time > touch->time; at--) {
            fresh->mark[at] = fresh->mark[at - 1];
            order[at] = order[at - 1];
        }
        fresh->mark[at] = (saltus_mark){SALTUS_IMPACT, touch->face, touch->time, false};
        order[at] = -1;
        born++;
    }
    return born && dead ? "impacts are born and die"
           : born > 1   ? "impacts are born"
           : born       ? "an impact is born"
           : dead > 1   ? "impacts die"
           : dead       ? "an impact dies"
                        : NULL;
}

bool saltus_sequence_join(const saltus_sequence *first, const saltus_sequence *second,
                          saltus_sequence *fresh) {
    if (first->count + second->count > SALTUS_MARKS_MAX)
        return false;
    *fresh = *first;
    fresh->cuts = 1;
    fresh->periods = first->periods + second->periods;
    for (int k = 0; k < second->count; k++) {
        saltus_mark *mark = &fresh->mark[fresh->count++];
        *mark = second->mark[k];
        mark->time += first->periods;
    }
    return true;
}

double saltus_sequence_repeats(const saltus_sequence *s, int parts, bool mirrored) {
    int part = s->count / parts;
    double largest = 0;
    for (int k = 0; k < s->count; k++) {
        const saltus_mark *mark = &s->mark[k], *later = &s->mark[(k + part) % s->count];
        double since = later->time - mark->time - (double)s->periods / parts;
        if (mark->kind != later->kind || (mark->face != later->face) != mirrored)
            return INFINITY;
        largest = fmax(largest, fabs(remainder(since, s->periods)));
    }
    return part > 0 && part * parts == s->count ? largest : INFINITY;
}

bool saltus_sequence_completes(const saltus_sequence *s, int k) {
    for (int j = k + 1; j < s->count; j++)
        if (s->mark[j].face == s->mark[k].face)
            return s->mark[j].kind == SALTUS_RELEASE;
    return false;
}

bool saltus_sequence_has_tail(const saltus_sequence *s) {
    bool tail = s->driven && !(s->count && s->mark[0].kind == SALTUS_RELEASE);
    for (int k = 0; k < s->count; k++)
        tail = tail || (s->mark[k].driven && !saltus_sequence_completes(s, k));
    return tail;
}

/* The faces that hold just after each mark. */
static void find_held(const saltus_sequence *s, unsigned *held) {
    unsigned now = s->contacts;
    for (int k = 0; k < s->count; k++) {
        const saltus_mark *mark = &s->mark[k];
        if (mark->kind == SALTUS_RELEASE)
            now &= ~(1u << mark->face);
        else if (mark->kind == SALTUS_STICK || (mark->driven && saltus_sequence_completes(s, k)))
            now |= 1u << mark->face;
        held[k] = now;
    }
}

/* The contacts that do not last all the time. */
static unsigned passing(const saltus_sequence *s, unsigned contacts) {
    unsigned met = 0;
    for (int k = 0; k < s->count; k++)
        met |= 1u << s->mark[k].face;
    return contacts & met;
}

/* Whether, just after each mark, a temporary contact holds or events are left to the flow. */
static void find_bound(const saltus_sequence *s, bool *bound) {
    unsigned held[SALTUS_MARKS_MAX];
    find_held(s, held);
    for (int k = 0; k < s->count; k++)
        bound[k] = passing(s, held[k]) || s->mark[k].driven;
}

void saltus_sequence_even(saltus_sequence *s) {
    if (!(s->omega > 0 && s->periods % 2))
        return;
    s->periods *= 2;
    s->omega *= 2;
    s->base *= 2;
    for (int k = 0; k < s->count; k++)
        s->mark[k].time *= 2;
    for (int k = 0; k < s->cuts; k++)
        s->cut[k] *= 2;
}

saltus_sequence saltus_sequence_part(const saltus_sequence *s, int parts) {
    saltus_sequence part = *s;
    part.periods = s->periods / parts;
    part.cuts = 1;
    while (part.count > 0 && part.mark[part.count - 1].time >= part.base + part.periods)
        part.count--;
    return part;
}

/* Cuts at about equal distances, in free flight and away from marks. */
static void cut_evenly(saltus_sequence *s, int cuts) {
    bool bound[SALTUS_MARKS_MAX];
    find_bound(s, bound);
    s->cuts = 1;
    s->cut[0] = s->base;
    if (s->driven || passing(s, s->contacts))
        return;
    for (int j = 1; j < cuts; j++) {
        double at = s->base + (double)j * s->periods / cuts;
        int k = s->count - 1;
        while (k >= 0 && s->mark[k].time > at)
            k--;
        double from = k < 0 ? s->base : s->mark[k].time;
        double to = k + 1 < s->count ? s->mark[k + 1].time : s->base + s->periods;
        if (k >= 0)
            at = fmax(at, from + 0.2 * (to - from));
        if (k + 1 < s->count)
            at = fmin(at, to - 0.2 * (to - from));
        if ((k < 0 || !bound[k]) && at > s->cut[s->cuts - 1] + 0.02)
            s->cut[s->cuts++] = at;
    }
}

double saltus_sequence_amid_flight(const saltus_sequence *s) {
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

double saltus_sequence_amid_halves(const saltus_sequence *s) {
    const double half = 0.5 * s->periods, near = 0.04 * half;
    double best = 0, base = s->base;
    bool bound[SALTUS_MARKS_MAX], tight = false;
    find_bound(s, bound);
    for (int k = 0; k < s->count; k++) {
        double gap = half;
        for (int j = 0; j < s->count; j++) {
            const double later = remainder(s->mark[j].time - s->mark[k].time - 0.5 * half, half) + 0.5 * half;
            gap = later > 0 ? fmin(gap, later) : gap;
        }
        tight = tight || fabs(remainder(s->mark[k].time - s->base, half)) < near;
        if (bound[k])
            return s->base;
        if (gap > best) {
            best = gap;
            base = s->mark[k].time + 0.5 * gap;
        }
    }
    return !tight ? s->base : base < s->base + s->periods ? base : base - s->periods;
}

/* The sequence cut open at a later time, up to one orbit on. */
static void rotate(const saltus_sequence *old, double base, saltus_sequence *fresh, int *order) {
    int first = 0;
    while (first < old->count && old->mark[first].time < base)
        first++;
    double back = base >= old->periods ? old->periods : 0;
    *fresh = *old;
    fresh->base = fresh->cut[0] = base - back;
    for (int k = 0; k < old->count; k++) {
        order[k] = (first + k) % old->count;
        fresh->mark[k] = old->mark[order[k]];
        fresh->mark[k].time += (first + k >= old->count ? old->periods : 0) - back;
    }
    if (base != old->base) {
        unsigned held[SALTUS_MARKS_MAX];
        find_held(old, held);
        fresh->contacts = first > 0 ? held[first - 1] : old->contacts;
        fresh->driven = false;
    }
}

/* Leave the tail of a long run of ever slower impacts to the flow. */
static bool trim_runs(saltus_sequence *s, const double *old_speed, int *order) {
    double speed[SALTUS_MARKS_MAX];
    int count = s->count, kept = 0;
    for (int k = 0; k < count; k++) {
        double own = old_speed[order[k]];
        if (kept > 0 && s->mark[k].kind == SALTUS_IMPACT && !s->mark[k].driven &&
            saltus_sequence_in_tail(s, speed, kept, s->mark[k].face, own)) {
            s->mark[kept - 1].driven = true;
            continue;
        }
        s->mark[kept] = s->mark[k];
        speed[kept] = own;
        order[kept++] = order[k];
    }
    s->count = kept;
    return kept < count;
}

/* Whether an event comes close to a cut, which it cannot pass. */
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

void saltus_sequence_turn(const saltus_sequence *old, double base, int cuts, saltus_sequence *fresh,
                          int *order) {
    int unasked[SALTUS_MARKS_MAX];
    rotate(old, base, fresh, order ? order : unasked);
    cut_evenly(fresh, cuts);
}

bool saltus_sequence_reframe(const saltus_sequence *old, const double *speed, int cuts, bool trims,
                             saltus_sequence *fresh, int *order) {
    double base = old->base;
    if (old->count > 0) {
        double before = old->mark[0].time - old->base;
        double after = old->base + old->periods - old->mark[old->count - 1].time;
        if (fmin(before, after) <= 0.08 * (before + after))
            base = fmax(base, saltus_sequence_amid_flight(old));
    }
    rotate(old, base, fresh, order);
    bool trimmed = trims && trim_runs(fresh, speed, order);
    cut_evenly(fresh, cuts);
    return trimmed || base != old->base || fresh->cuts > old->cuts || cuts_are_tight(old);
}

/* A number that belongs to a mark now, from those that belonged to the marks before; 0 for a new one. */
static double carried(const double *numbers, const int *order, int mark) {
    const int former = order ? order[mark] : mark;
    return former < 0 ? 0 : numbers[former];
}

void saltus_sequence_carry(const saltus_sequence *old, const double *vector, const saltus_sequence *fresh,
                           const int *order, int n, int parameters, double *out) {
    const double *old_times = vector + old->cuts * n;
    double *times = out + fresh->cuts * n;
    bool same_cuts = old->cuts == fresh->cuts;
    for (int j = 0; j < fresh->cuts; j++) {
        same_cuts = same_cuts && (j == 0 || old->cut[j] == fresh->cut[j]);
        bool same = old->base == fresh->base && (j == 0 || same_cuts);
        for (int i = 0; i < n; i++)
            out[j * n + i] = same ? vector[j * n + i] : 0;
    }
    /* If the base of an orbit of unknown period moves, all times may be shifted: subtract the mean. */
    const bool adrift = fresh->omega > 0 && old->base != fresh->base;
    double later = 0;
    for (int k = 0; k < fresh->count && adrift; k++)
        later += carried(old_times, order, k) / fresh->count;
    for (int k = 0; k < fresh->count; k++)
        times[k] = order && order[k] < 0 ? 0 : carried(old_times, order, k) - later;
    int others = parameters + (fresh->omega > 0);
    for (int d = 0; d < others; d++)
        times[fresh->count + d] = old_times[old->count + d];
}
