/* Points of a locus, and the special ones among them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/locus_point.h"

#include "branch/sequence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void saltus_locus_point_clear(saltus_locus_point *p) {
    saltus_curve_clear(&p->at);
    saltus_solution_clear(&p->orbit);
}

saltus_status saltus_locus_see_orbit(saltus_extended *x, saltus_locus_point *p, saltus_message *message) {
    saltus_orbits *o = &x->orbits;
    saltus_curve_point *at = &p->orbit.at;
    size_t m = (size_t)o->equations->unknowns;
    if (!saltus_curve_reserve(at, (int)m))
        return saltus_branch_no_memory(message);
    memcpy(at->u, p->at.u, m * sizeof *at->u);
    memcpy(at->tangent, p->at.tangent, m * sizeof *at->u);
    at->iterations = p->at.iterations;
    saltus_status status = saltus_equations_evaluate(o->equations, at->u, message);
    if (status == SALTUS_OK)
        status = saltus_solution_see(o, &p->orbit, message);
    if (status == SALTUS_OK)
        status = saltus_solution_survey(o, &p->orbit, message);
    return status;
}

saltus_status saltus_locus_see(saltus_extended *x, saltus_locus_point *p, saltus_message *message) {
    saltus_status status = saltus_locus_see_orbit(x, p, message);
    if (status != SALTUS_OK)
        return status;
    p->corner_count = saltus_corner_measure(x, &p->at, &p->orbit, p->corners);
    p->before_place = 0;
    return p->corner_count < 0 ? saltus_branch_no_memory(message) : SALTUS_OK;
}

saltus_status saltus_locus_take_up(saltus_extended *x, saltus_locus_point *here, const double *u,
                                   double extra, saltus_message *message) {
    saltus_equations *orbit = x->orbits.equations;
    size_t bytes = (size_t)orbit->unknowns * sizeof *u;
    saltus_status status = saltus_extended_shape(x, message);
    if (status == SALTUS_OK && !saltus_curve_reserve(&here->at, x->equations.unknowns))
        status = saltus_branch_no_memory(message);
    if (status != SALTUS_OK)
        return status;
    memcpy(here->at.u, u, bytes);
    memcpy(x->anchor, u, bytes);
    if (x->extra)
        here->at.u[orbit->unknowns] = extra;
    status = saltus_equations_evaluate(orbit, here->at.u, message);
    return status == SALTUS_OK && x->kind != SALTUS_POINT_GR ? saltus_extended_choose(x, extra, message)
                                                             : status;
}

saltus_status saltus_locus_find_first(saltus_extended *x, saltus_locus_point *here, int k,
                                      saltus_message *message) {
    int m = x->equations.unknowns;
    double *normal = calloc((size_t)m, sizeof *normal), *anchor = calloc((size_t)m, sizeof *anchor);
    saltus_status status = normal && anchor ? SALTUS_OK : saltus_branch_no_memory(message);
    if (status == SALTUS_OK) {
        normal[k] = 1;
        memcpy(anchor, here->at.u, (size_t)m * sizeof *anchor);
        status =
            saltus_newton(&x->equations, here->at.u, normal, anchor, true, &here->at.iterations, message);
    }
    if (status == SALTUS_OK)
        saltus_extended_renew(x, here->at.u);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(&x->equations, here->at.u, message);
    if (status == SALTUS_OK)
        status = saltus_curve_orient(&x->equations, NULL, &here->at, message);
    free(normal);
    free(anchor);
    return status;
}

saltus_status saltus_locus_find_near(saltus_extended *x, saltus_locus_point *here, double theta,
                                     saltus_message *message) {
    static const double aside[] = {0.05, 0.1, 0.2, 0.4};
    int c = x->orbits.equations->count;
    bool meets = x->kind == SALTUS_POINT_NS && (theta == 0 || theta == M_PI);
    saltus_status status = SALTUS_NO_CONVERGENCE;
    for (int k = 0; k < (meets ? 4 : 1) && status != SALTUS_OK && status != SALTUS_NO_MEMORY; k++) {
        double angle = meets ? fabs(theta - aside[k]) : theta;
        status = saltus_locus_take_up(x, here, here->orbit.at.u, angle, message);
        if (status == SALTUS_OK)
            status = saltus_locus_find_first(x, here, meets ? c + 2 : c + 1, message);
    }
    return status;
}

/* Halfway around an orbit, cut there: how the state that is unknown i differs from what it is on orbits of
 * half the period, or on ones that are their own mirror images. */
static double half_apart(const saltus_extended *x, const double *u, int i, bool mirrored) {
    return u[x->orbits.n + i] + (mirrored ? u[i] : -u[i]);
}

saltus_status saltus_locus_find_leaving(saltus_extended *x, saltus_locus_point *here,
                                        saltus_message *message) {
    int m = x->equations.unknowns, n = x->orbits.n;
    double values[2], share[2][2] = {{0}}, length = 0, *plane = calloc(2 * (size_t)m, sizeof *plane);
    bool mirrored = !(saltus_solution_half_distance(&x->orbits, &here->orbit, false) < 1e-6);
    saltus_status status = plane ? SALTUS_OK : saltus_branch_no_memory(message);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(&x->equations, here->at.u, message);
    if (status == SALTUS_OK)
        status = saltus_null_plane(&x->equations, plane, values, message);
    for (int i = 0; i < n && status == SALTUS_OK; i++)
        for (int k = 0; k < 4; k++)
            share[k / 2][k % 2] += half_apart(x, plane + (k / 2) * m, i, mirrored) *
                                   half_apart(x, plane + (k % 2) * m, i, mirrored);
    const double *own = share[share[1][1] > share[0][0]];
    here->at.iterations = 0;
    for (int j = 0; j < m && status == SALTUS_OK; j++) {
        here->at.tangent[j] = own[0] * plane[j] + own[1] * plane[m + j];
        length = hypot(length, here->at.tangent[j]);
    }
    for (int j = 0; j < m && status == SALTUS_OK; j++)
        here->at.tangent[j] /= length;
    free(plane);
    return status;
}

double saltus_locus_apart(saltus_extended *x, const saltus_solution *s, bool *halves) {
    bool shift;
    const double half = saltus_solution_half_distance(&x->orbits, s, false);
    const bool breaks = !x->mirrored && saltus_system_mirror_symmetric(x->orbits.system, &shift);
    const double image = breaks ? saltus_solution_half_distance(&x->orbits, s, true) : INFINITY;
    if (halves)
        *halves = half <= image;
    return fmin(half, image);
}

bool saltus_locus_joins_at(saltus_extended *x, const saltus_locus_point *here, const saltus_solution *at,
                           bool breach) {
    const double near = 1e-4;
    if (x->kind != SALTUS_POINT_GR)
        return false;
    const double apart = saltus_locus_apart(x, at, NULL);
    return apart < near && !(breach && apart > 0.5 * saltus_locus_apart(x, &here->orbit, NULL));
}

/* Whether two multipliers are e^{i theta} and its conjugate: at folds the equations of tori hold with a
 * single multiplier 1 and theta = 0. */
static bool has_pair(const saltus_survey *survey, int n, double theta) {
    const double near = 1e-2;
    int first = -1;
    for (int way = 1; way >= -1; way -= 2) {
        int best = -1;
        double least = near;
        for (int i = 0; i < n; i++) {
            double apart =
                hypot(survey->multipliers[i].re - cos(theta), survey->multipliers[i].im - way * sin(theta));
            if (i != first && apart < least) {
                least = apart;
                best = i;
            }
        }
        if (best < 0)
            return false;
        first = best;
    }
    return true;
}

bool saltus_locus_is_sound(saltus_extended *x, const saltus_locus_point *p) {
    const double apart = 1e-6;
    const saltus_solution *s = &p->orbit;
    if (x->kind == SALTUS_POINT_BP && !(fabs(p->at.u[s->at.unknowns]) < 1e-8))
        return false;
    double breach = saltus_corner_breach(x, s);
    if (breach > 1e-9)
        return true;
    if (x->kind == SALTUS_POINT_NS && s->survey.walked &&
        !has_pair(&s->survey, x->orbits.n, p->at.u[s->at.unknowns]))
        return false;
    if (x->kind == SALTUS_POINT_GR)
        return breach < -apart || saltus_locus_apart(x, s, NULL) >= apart;
    /* The flow tells a breach as small as that of the last impacts of a long run. */
    return s->survey.follows || breach > 0;
}

bool saltus_locus_visit(saltus_extended *x, const saltus_locus_point *here, double ahead,
                        saltus_locus_point *out) {
    saltus_message ignored;
    return saltus_curve_visit(&x->equations, &here->at, ahead, &out->at, &ignored) == SALTUS_OK &&
           saltus_locus_see(x, out, &ignored) == SALTUS_OK;
}

/* One corner under way. */
typedef struct location {
    saltus_extended *x;
    const saltus_locus_point *here;
    saltus_locus_point *out;
    int corner, asked;
    double clear; /* what a function that is smooth has fallen far below when it has been asked often */
} location;

static bool corner_at(void *context, double ahead, double *value) {
    enum { often = 14 };
    location *l = context;
    if (!saltus_locus_visit(l->x, l->here, ahead, l->out))
        return false;
    *value = saltus_scaled_in(l->out->corners[l->corner].value, l->here->corners[l->corner].value.exponent);
    return ++l->asked < often || !(fabs(*value) > l->clear);
}

/* The functions at a place of a step. */
typedef struct sample {
    double place;
    saltus_locus_test corners[SALTUS_CORNERS_MAX];
} sample;

enum { halvings = 5 };

static sample sample_of(const saltus_locus_point *p, double place) {
    sample own = {.place = place};
    memcpy(own.corners, p->corners, sizeof own.corners);
    return own;
}

/* Whether a function may cross zero between the last two of three places and come back: by the parabola
 * through them it falls towards zero there, and rises again. */
static bool may_dip(const double place[3], const double value[3]) {
    const double deep = 0.8;
    const double first = (value[1] - value[0]) / (place[1] - place[0]),
                 second = (value[2] - value[1]) / (place[2] - place[1]),
                 bend = (second - first) / (place[2] - place[0]), reach = bend * (place[2] - place[1]);
    const double side = value[1] > 0 ? 1 : -1, least = fmin(side * value[1], side * value[2]);
    const bool turns = least > 0 && side * (second - reach) < 0 && side * (second + reach) > 0;
    return turns && side * value[1] - (second - reach) * (second - reach) / (4 * fabs(bend)) < deep * least;
}

/* Whether functions at two places, and before them at `before`, let expect more zeros between than their
 * signs tell. Where one on a curve of grazing has a zero a multiplier may run through infinity there, past 1,
 * -1 and the other ones. */
static bool may_hide(const saltus_extended *x, const saltus_locus_point *here, double before,
                     const saltus_scaled *values, const sample *begin, const sample *end) {
    bool hides = false;
    for (int k = 0; k < here->corner_count && !hides; k++) {
        const saltus_locus_test *near = &begin->corners[k], *far = &end->corners[k];
        const double exponent = here->corners[k].value.exponent, quiet = here->corners[k].quiet;
        const double place[] = {before, begin->place, end->place},
                     value[] = {saltus_scaled_in(values[k], exponent),
                                saltus_scaled_in(near->value, exponent),
                                saltus_scaled_in(far->value, exponent)};
        if (near->breach || (quiet != 0 && near->value.exponent < quiet && far->value.exponent < quiet))
            continue;
        hides = before < begin->place && may_dip(place, value);
        if (x->kind == SALTUS_POINT_GR)
            hides = hides || value[1] * value[2] < 0 || saltus_corner_hides(near, far);
    }
    return hides;
}

/* The functions at the place before a sample. */
static double values_before(const saltus_locus_point *here, const sample *samples, int count,
                            saltus_scaled *values) {
    for (int k = 0; k < here->corner_count; k++)
        values[k] = count > 1 ? samples[count - 2].corners[k].value : here->before[k];
    return count > 1 ? samples[count - 2].place : here->before_place;
}

/* Append the end of an interval to the samples; before it, where functions may have two zeros within, or
 * multipliers have crossed the unit circle and come back, places between. */
static int append_samples(saltus_extended *x, const saltus_locus_point *here, const sample *end, int depth,
                          saltus_locus_point *scratch, sample *samples, int count) {
    const sample *begin = &samples[count - 1];
    const double finest = 4e-3;
    const bool far = depth < halvings && end->place - begin->place > finest;
    saltus_scaled values[SALTUS_CORNERS_MAX];
    const double before = values_before(here, samples, count, values);
    const double middle = 0.5 * (begin->place + end->place);
    if (far && may_hide(x, here, before, values, begin, end) &&
        saltus_locus_visit(x, here, middle, scratch)) {
        const sample between = sample_of(scratch, middle);
        count = append_samples(x, here, &between, depth + 1, scratch, samples, count);
        return append_samples(x, here, end, depth + 1, scratch, samples, count);
    }
    samples[count] = *end;
    return count + 1;
}

/* Put the places that were found among the samples. Where a fold or flip meets grazing a multiplier runs
 * through infinity nearby, and its product with another one through 1: the test for pairs on the unit circle,
 * which changes its sign there as it does at GR-NS, is asked between them. */
static int add_samples(saltus_extended *x, const saltus_locus_point *here, const saltus_locus_zeros *found,
                       saltus_locus_point *scratch, sample *samples, int count) {
    for (int k = 0; k < found->count; k++) {
        if (!saltus_locus_visit(x, here, found->place[k], scratch))
            continue;
        int at = count++;
        for (; at > 0 && samples[at - 1].place > found->place[k]; at--)
            samples[at] = samples[at - 1];
        samples[at] = sample_of(scratch, found->place[k]);
    }
    return count;
}

/* The zero of a function between two places, if there is one. */
static bool find_zero(location *self, const sample *a, const sample *b, double *place) {
    const saltus_extended *x = self->x;
    const int k = self->corner;
    const saltus_scaled near = a->corners[k].value, far = b->corners[k].value;
    const double exponent = self->here->corners[k].value.exponent, quiet = self->here->corners[k].quiet;
    const double ends[] = {a->place, b->place},
                 values[] = {saltus_scaled_in(near, exponent), saltus_scaled_in(far, exponent)};
    double width;
    if (!(values[0] * values[1] < 0))
        return false;
    /* Multipliers that are told badly make their products jump. */
    const bool jumps = a->corners[k].kind == SALTUS_POINT_GR_NS && !a->corners[k].breach;
    self->clear = jumps ? 1e-2 * fmin(fabs(values[0]), fabs(values[1])) : INFINITY;
    self->asked = 0;
    if ((quiet == 0 || !(near.exponent < quiet && far.exponent < quiet)) &&
        saltus_curve_zero_between(x->orbits.solver, corner_at, self, ends, values, place, &width))
        return true;
    /* Where a pair of multipliers meets the equations are singular, and solved near there by chance; the
     * place is had from others (saltus_locus_sharpen). */
    *place = ends[0] + (ends[1] - ends[0]) * values[0] / (values[0] - values[1]);
    return x->kind == SALTUS_POINT_NS && k > 0 && self->here->corners[k].ends;
}

/* Put a corner in its place among those found. False: there are too many. */
static bool insert(saltus_locus_zeros *found, int corner, double place) {
    int at = found->count;
    if (at == SALTUS_CROSSINGS_MAX)
        return false;
    for (; at > 0 && found->place[at - 1] > place; at--) {
        found->place[at] = found->place[at - 1];
        found->corner[at] = found->corner[at - 1];
    }
    found->place[at] = place;
    found->corner[at] = corner;
    found->count++;
    return true;
}

bool saltus_locus_find_corners(saltus_extended *x, const saltus_locus_point *here,
                               const saltus_locus_point *next, saltus_locus_point *scratch,
                               saltus_locus_zeros *found) {
    const double together = 1e-6, jump = 1e-8;
    double ends = INFINITY;
    sample *samples = calloc((1 << halvings) + 1 + SALTUS_CROSSINGS_MAX, sizeof *samples);
    bool sound = samples;
    if (!samples) {
        x->orbits.starved = true;
        return false;
    }
    samples[0] = sample_of(here, 0);
    const sample last = sample_of(next, next->at.ahead);
    int count = append_samples(x, here, &last, 0, scratch, samples, 1);
    bool added = false;
    found->count = 0;
    for (int k = 0; k < here->corner_count; k++) {
        if (here->corners[k].kind == SALTUS_POINT_GR_NS && !here->corners[k].breach && !added) {
            count = add_samples(x, here, found, scratch, samples, count);
            added = true;
        }
        for (int j = 0; j + 1 < count && sound; j++) {
            location self = {.x = x, .here = here, .out = scratch, .corner = k};
            double place = 0, value;
            const bool located = find_zero(&self, &samples[j], &samples[j + 1], &place);
            /* The first function is the breach, which may begin with a jump, where a maximum of the gap
             * appears. */
            if (k == 0 && (located || samples[j + 1].corners[k].value.mantissa > 1e-9))
                sound = located && corner_at(&self, place, &value) && fabs(value) < jump &&
                        !saltus_locus_joins_at(x, here, &scratch->orbit, true);
            if (!located || !sound || place >= ends - together)
                continue;
            if (k == 0)
                ends = place;
            sound = insert(found, k, place);
            if (k == 0)
                break;
        }
    }
    free(samples);
    return sound;
}

void saltus_locus_sharpen(saltus_extended *x, const saltus_locus_point *here, double theta,
                          saltus_locus_point *at, saltus_locus_point *scratch) {
    enum { samples = 6 };
    const double apart = 0.02;
    int m = here->at.unknowns;
    double square[samples], *u = calloc((size_t)(m * samples), sizeof *u);
    saltus_message ignored;
    bool found = u;
    if (!u)
        x->orbits.starved = true;
    for (int k = 0; k < samples && found; k++) {
        double aside = apart * (k + 1);
        square[k] = aside * aside;
        found = saltus_curve_meet(&x->equations, &here->at, m - 1, theta > 1 ? theta - aside : aside,
                                  &scratch->at, &ignored) == SALTUS_OK;
        for (int j = 0; j < m && found; j++)
            u[j * samples + k] = scratch->at.u[j];
    }
    for (int j = 0; j < m && found; j++)
        at->at.u[j] = j < m - 1 ? saltus_curve_interpolate(square, u + j * samples, samples) : theta;
    free(u);
    if (found)
        saltus_locus_see_orbit(x, at, &ignored);
}

saltus_status saltus_locus_end_contact(saltus_extended *x, const saltus_locus_point *here,
                                       saltus_locus_point *at, bool *found, saltus_message *message) {
    enum { halvings = 40 };
    const double reach = 1e-3, nothing = 1e-4, sharp = 1e-11;
    double low = 0, high = reach, usual = x->equations.tolerance;
    saltus_message ignored;
    saltus_locus_test contact = {.kind = SALTUS_POINT_GR_GR, .breach = true};
    saltus_status status = SALTUS_OK;
    *found = false;
    /* A little speed at grazing moves the place by as much. */
    x->equations.tolerance = fmin(usual, sharp);
    for (int k = 0; k <= halvings; k++) {
        double middle = k < halvings ? 0.5 * (low + high) : low;
        status = saltus_curve_visit(&x->equations, &here->at, middle, &at->at, &ignored);
        if (status == SALTUS_OK)
            status = saltus_locus_see_orbit(x, at, &ignored);
        if (status == SALTUS_NO_MEMORY)
            return saltus_branch_no_memory(message);
        *found = status == SALTUS_OK && saltus_corner_breach(x, &at->orbit) <= 0;
        *(*found ? &low : &high) = middle;
    }
    x->equations.tolerance = usual;
    if (*found && saltus_corner_breach(x, &at->orbit) > -nothing)
        status = saltus_corner_tell(x, &contact, &at->orbit, &contact.kind, message);
    *found = contact.kind == SALTUS_POINT_CH_GR;
    return status == SALTUS_NO_MEMORY ? status : SALTUS_OK;
}

bool saltus_locus_ceases_to_complete(const saltus_solution *s) {
    const double little = 1e-3;
    for (int k = 0; k < s->breach_count; k++)
        if (s->breaches[k].value > -little && saltus_corner_ends_chatter(s, &s->breaches[k]))
            return true;
    return false;
}
