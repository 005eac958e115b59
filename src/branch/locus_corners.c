/* The points of codimension two on a step along a locus.
 *
 * Each is a zero of a function whose value is known at both ends of the step. A change of sign shows one
 * zero, but two zeros, or one next to a place where a multiplier passes through infinity, leave the sign
 * unchanged. So the functions are evaluated in between as well: where they bend towards zero, where
 * multipliers have moved so far that they may have crossed the unit circle and come back, and, repeatedly,
 * where the number of multipliers inside the circle does not agree with the known zeros.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/locus_point.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The functions at a place of a step. */
typedef struct sample {
    double place, crossing;
    saltus_locus_test corners[SALTUS_CORNERS_MAX];
} sample;

/* The search on one step. */
typedef struct search {
    saltus_extended *x;
    const saltus_locus_point *here, *next; /* ends of the step */
    saltus_locus_point *out;               /* the point last visited */
    saltus_list samples;
    /* The zero that is being located. */
    int corner, asked;
    double clear;     /* a smooth function is below this after many evaluations */
    double tolerance; /* of the equations */
} search;

static sample sample_of(const saltus_locus_point *p, double place) {
    sample own = {.place = place, .crossing = p->at.crossing.mantissa};
    memcpy(own.corners, p->corners, sizeof own.corners);
    return own;
}

/* The last sample, or one before it. */
static const sample *last_sample(const search *s, int before) {
    return (const sample *)s->samples.items + (s->samples.count - 1 - before);
}

/* False without memory. */
static bool append(search *s, const sample *own) {
    sample *fresh = saltus_list_grow(&s->samples, sizeof *fresh, &s->x->orbits.starved);
    if (fresh)
        *fresh = *own;
    return fresh;
}

/* Whether a function is only rounding at both ends of the step; in between a zero may make it fall below
 * that. */
static bool is_quiet(const search *s, int k) {
    return saltus_corner_is_rounding(&s->here->corners[k]) && saltus_corner_is_rounding(&s->next->corners[k]);
}

/* Whether there may be more zeros between the last sample and `end` than signs tell, also from the values
 * before; `sure`: only if a parabola has them. Where a function on a curve of grazing has a zero, a
 * multiplier may pass through infinity nearby, and on the way 1, -1 and other multipliers. */
static bool may_hide(const search *s, const sample *end, bool sure) {
    const saltus_locus_point *here = s->here;
    const sample *begin = last_sample(s, 0), *last = s->samples.count > 1 ? last_sample(s, 1) : NULL;
    const double place[] = {last ? last->place : here->before_place, begin->place, end->place};
    double lowest;
    bool hides = false;
    for (int k = 0; k < here->corner_count && !hides; k++) {
        const saltus_locus_test *near = &begin->corners[k], *far = &end->corners[k];
        const double exponent = here->corners[k].value.exponent;
        const double value[] = {saltus_scaled_in(last ? last->corners[k].value : here->before[k], exponent),
                                saltus_scaled_in(near->value, exponent),
                                saltus_scaled_in(far->value, exponent)};
        if (near->breach || is_quiet(s, k))
            continue;
        hides = place[0] < place[1] && saltus_curve_dips(place, value, sure ? 0 : 0.8, &lowest);
        if (s->x->kind == SALTUS_POINT_GR && !sure)
            hides = hides || value[1] * value[2] < 0 || saltus_corner_hides(near, far);
    }
    return hides;
}

enum { halvings = 5, halvings_most = 28, samples_most = 400 };

/* Append the end of an interval to the samples, preceded by samples in between if functions may have more
 * zeros there than signs tell, or multipliers prove it. False without memory, or if the step is so long that
 * it may lead across a hairpin. */
static bool append_until(search *s, const sample *end, int depth) {
    const sample *begin = last_sample(s, 0);
    const double finest = 4e-3, near = 1e-5, far = 1e-3;
    const double length = end->place - begin->place, middle = begin->place + 0.5 * length;
    const bool grazes = s->x->kind == SALTUS_POINT_GR;
    const bool doubts = (depth < halvings && length > finest && may_hide(s, end, false)) ||
                        (grazes && length > near && may_hide(s, end, true)) ||
                        (grazes && depth < halvings_most &&
                         saltus_corner_misses(begin->corners, end->corners, s->here->corner_count));
    if (!doubts || s->samples.count >= samples_most)
        return append(s, end);
    if (!saltus_locus_visit(s->x, s->here, middle, s->out))
        return middle > far && saltus_curve_strays(&s->here->at, &s->out->at) ? false : append(s, end);
    const sample between = sample_of(s->out, middle);
    return append_until(s, &between, depth + 1) && append_until(s, end, depth + 1);
}

/* The tolerance of steps would be the error of the place. */
static bool visit_sharply(saltus_extended *x, const saltus_locus_point *here, double ahead, double *tolerance,
                          saltus_locus_point *out) {
    return saltus_locus_reach(x, &here->at, ahead, tolerance, x->equations.tolerance, &out->at) &&
           !saltus_curve_strays(&here->at, &out->at) && saltus_locus_see(x, out);
}

static bool corner_at(void *context, double ahead, double *value) {
    enum { often = 14 };
    search *s = context;
    if (!visit_sharply(s->x, s->here, ahead, &s->tolerance, s->out))
        return false;
    *value = saltus_scaled_in(s->out->corners[s->corner].value, s->here->corners[s->corner].value.exponent);
    return ++s->asked < often || !(fabs(*value) > s->clear);
}

/* At this distance from a crossing the equations are solved well. */
static const double near_crossing = 3e-3;

/* A zero at which another curve of the same equations crosses: nearby the equations are singular and Newton's
 * method may end on either curve. The point is interpolated from both sides, from as close as the curves can
 * be told apart; each place is visited from the nearest one known on its side. */
static bool visit_crossing(saltus_extended *x, const saltus_locus_point *here, int corner, double ahead,
                           saltus_locus_point *out) {
    enum { samples = 6, passes = 4 };
    static const double place[samples] = {-1, 1, -2, 2, -3, 3},
                        apart[passes] = {near_crossing, 1e-3, 2e-4, 1e-4};
    const int m = here->at.unknowns;
    const double exponent = here->corners[corner].value.exponent,
                 start = ahead > 5 * near_crossing ? ahead - 4 * near_crossing : 0;
    double value[samples], from[2] = {start, start}, *u = x->points, *own = x->kept;
    saltus_locus_point side[2] = {{.corner_count = 0}, {.corner_count = 0}};
    bool found = false, good = true;
    for (int k = 0; k < 2 && good; k++) {
        good = saltus_locus_visit(x, here, start, &side[k]);
        if (good && start > 0)
            saltus_curve_bend(&here->at, &side[k].at);
    }
    for (int pass = 0; pass < passes && good; pass++) {
        double next = 0;
        for (int k = 0; k < samples && good; k++) {
            const double at = ahead + place[k] * apart[pass];
            good = saltus_locus_visit(x, &side[k % 2], at - from[k % 2], out);
            value[k] = saltus_scaled_in(out->corners[corner].value, exponent);
            good = good && place[k] * value[k] * place[0] * value[0] > 0;
            for (int j = 0; j < m && good; j++)
                u[j * samples + k] = out->at.u[j];
            if (k < 2 && good) {
                const saltus_locus_point last = side[k];
                if (at - from[k] > 0)
                    saltus_curve_bend(&last.at, &out->at);
                else
                    out->at.bent = false;
                side[k] = *out;
                *out = last;
                from[k] = at;
            }
        }
        for (int j = 0; j < m && good; j++)
            next += (saltus_curve_interpolate(value, u + j * samples, samples) - here->at.u[j]) *
                    here->at.tangent[j];
        good = good && fabs(next - ahead) < apart[pass];
        for (int j = 0; j < m && good; j++)
            own[j] = saltus_curve_interpolate(value, u + j * samples, samples);
        if (good)
            out->doubt = fabs(next - ahead);
        ahead = good ? next : ahead;
        found = found || good;
    }
    if (found) {
        memcpy(out->at.u, own, (size_t)m * sizeof *own);
        out->at.ahead = ahead;
        found = saltus_equations_evaluate(&x->equations, out->at.u, NULL) == SALTUS_OK &&
                saltus_locus_see(x, out);
    }
    saltus_locus_point_clear(&side[0]);
    saltus_locus_point_clear(&side[1]);
    return found;
}

/* The point at a zero, evaluated; only at a crossing with its doubt. */
static bool visit_zero(saltus_extended *x, const saltus_locus_point *here,
                       const struct saltus_locus_zero *zero, saltus_locus_point *out) {
    double tolerance = zero->tolerance;
    return (zero->crosses && visit_crossing(x, here, zero->corner, zero->place, out)) ||
           visit_sharply(x, here, zero->place, &tolerance, out);
}

bool saltus_locus_visit_zero(saltus_extended *x, const saltus_locus_point *here,
                             const struct saltus_locus_zero *zero, saltus_locus_point *out) {
    if (!zero->crosses) {
        saltus_extended other;
        saltus_locus_point there = {.corner_count = 0};
        search s = {.x = x, .here = here, .out = out, .corner = zero->corner, .clear = INFINITY}, t;
        s.tolerance = zero->tolerance;
        t = s;
        t.x = &other;
        t.out = &there;
        const bool opened = saltus_extended_open_other(x, &other) == SALTUS_OK;
        out->doubt = saltus_locus_doubt(corner_at, &s, opened ? &t : NULL, zero->place, &out->at, &there.at,
                                        x->orbits.equations->count);
        saltus_locus_point_clear(&there);
        saltus_extended_close_other(x, &other);
    }
    return visit_zero(x, here, zero, out);
}

/* Add the zeros found so far to the samples. Where a fold or flip meets grazing, a multiplier passes through
 * infinity nearby and its product with another one passes through 1. There the test for pairs changes sign as
 * at GR-NS, so it must be evaluated in between. False without memory. */
static bool add_samples(search *s, const saltus_locus_zeros *found) {
    const sample *old = s->samples.items;
    search fresh = *s;
    fresh.samples = (saltus_list){.count = 0};
    bool room = append(&fresh, &old[0]);
    for (int j = 1, k = 0; j < s->samples.count && room; j++) {
        for (; k < found->count && found->zero[k].place < old[j].place && room; k++)
            if (visit_zero(s->x, s->here, &found->zero[k], s->out)) {
                const sample own = sample_of(s->out, found->zero[k].place);
                room = append_until(&fresh, &own, halvings);
            }
        room = room && append_until(&fresh, &old[j], halvings);
    }
    free(s->samples.items);
    *s = fresh;
    return room;
}

/* The zero of a function between two places, if there is one. */
static bool find_zero(search *s, int k, const sample *a, const sample *b, struct saltus_locus_zero *zero) {
    const saltus_extended *x = s->x;
    const saltus_scaled near = a->corners[k].value, far = b->corners[k].value;
    const double exponent = s->here->corners[k].value.exponent;
    const double ends[] = {a->place, b->place},
                 values[] = {saltus_scaled_in(near, exponent), saltus_scaled_in(far, exponent)};
    const double linear = ends[0] + (ends[1] - ends[0]) * values[0] / (values[0] - values[1]);
    /* A breach that is always zero belongs to another face, which the orbit touches all along the curve. */
    const double nothing = 1e-12, sharpest = 1e-12;
    const bool loud = k == 0 ? fmax(fabs(values[0]), fabs(values[1])) > nothing : !is_quiet(s, k);
    const bool pairs = a->corners[k].kind == SALTUS_POINT_GR_NS && !a->corners[k].breach;
    double width;
    *zero = (struct saltus_locus_zero){.corner = k, .place = linear, .tolerance = x->equations.tolerance};
    if (!(values[0] * values[1] < 0))
        return false;
    /* Inaccurate multipliers make their products jump: then the function stays large near its sign change. */
    s->corner = k;
    s->asked = 0;
    s->tolerance = fmin(sharpest, x->equations.tolerance);
    s->clear = pairs ? 1e-2 * fmin(fabs(values[0]), fabs(values[1])) : INFINITY;
    if (x->kind == SALTUS_POINT_GR && loud && !pairs && k > 0 && a->crossing * b->crossing < 0 &&
        visit_crossing(s->x, s->here, k, linear, s->out)) {
        zero->place = s->out->at.ahead;
        /* If an end is close to the crossing its own values are not better known. */
        zero->crosses = zero->place > ends[0] - near_crossing && zero->place < ends[1] + near_crossing;
    }
    if (zero->crosses)
        return true;
    if (loud && saltus_curve_zero(x->orbits.solver, corner_at, s, ends, values, &zero->place, &width)) {
        zero->tolerance = s->tolerance;
        return true;
    }
    /* Where a pair of multipliers meets, the equations are singular and solved by chance nearby;
     * saltus_locus_sharpen will find the place from other points. */
    zero->place = linear;
    return x->kind == SALTUS_POINT_NS && k > 0 && s->here->corners[k].ends;
}

/* Insert a corner in order. False: there are too many. */
static bool insert(saltus_locus_zeros *found, const struct saltus_locus_zero *zero) {
    int at = found->count;
    if (at == SALTUS_CROSSINGS_MAX)
        return false;
    for (; at > 0 && found->zero[at - 1].place > zero->place; at--)
        found->zero[at] = found->zero[at - 1];
    found->zero[at] = *zero;
    found->count++;
    return true;
}

bool saltus_locus_find_corners(saltus_extended *x, const saltus_locus_point *here,
                               const saltus_locus_point *next, saltus_locus_point *scratch,
                               saltus_locus_zeros *found) {
    const double together = 1e-6, jump = 1e-8, noise = x->kind == SALTUS_POINT_GR ? 1e-9 : 1e-12;
    double ends = INFINITY;
    search s = {.x = x, .here = here, .next = next, .out = scratch};
    const sample first = sample_of(here, 0), last = sample_of(next, next->at.ahead);
    bool sound = append(&s, &first) && append_until(&s, &last, 0), added = false;
    found->count = 0;
    for (int k = 0; k < here->corner_count && sound; k++) {
        if (here->corners[k].kind == SALTUS_POINT_GR_NS && !here->corners[k].breach && !added) {
            sound = add_samples(&s, found);
            added = true;
        }
        const sample *all = s.samples.items, *from = all;
        for (int j = 1; j < s.samples.count && sound; j++) {
            const sample *to = &all[j];
            struct saltus_locus_zero zero;
            double value;
            /* Towards the end of a curve functions may fall to nothing, and their signs are chance. */
            if (x->kind != SALTUS_POINT_GR && j + 1 < s.samples.count &&
                saltus_corner_is_rounding(&to->corners[k]))
                continue;
            const bool located = find_zero(&s, k, from, to, &zero);
            const double end = to->corners[k].value.mantissa;
            from = to;
            /* The first function is the breach, which may begin with a jump where a maximum of the gap
             * appears. */
            if (k == 0 && (located || end > noise))
                sound = located && corner_at(&s, zero.place, &value) && fabs(value) < jump &&
                        !saltus_locus_joins_at(x, here, scratch);
            if (!located || !sound || zero.place >= ends - together)
                continue;
            if (k == 0)
                ends = zero.place;
            sound = insert(found, &zero);
            if (k == 0)
                break;
        }
    }
    free(s.samples.items);
    return sound;
}
