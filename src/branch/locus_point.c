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

bool saltus_locus_see_orbit(saltus_extended *x, saltus_locus_point *p) {
    saltus_orbits *o = &x->orbits;
    saltus_curve_point *at = &p->orbit.at;
    size_t m = (size_t)o->equations->unknowns;
    const bool room = saltus_curve_reserve(at, (int)m);
    o->starved |= !room;
    if (!room)
        return false;
    memcpy(at->u, p->at.u, m * sizeof *at->u);
    memcpy(at->tangent, p->at.tangent, m * sizeof *at->u);
    at->iterations = p->at.iterations;
    const saltus_status status = saltus_equations_evaluate(o->equations, at->u, NULL);
    return saltus_orbits_noted(o, status) == SALTUS_OK &&
           saltus_solution_see(o, &p->orbit, NULL) == SALTUS_OK;
}

bool saltus_locus_survey_orbit(saltus_extended *x, saltus_locus_point *p) {
    return saltus_locus_see_orbit(x, p) && saltus_solution_survey(&x->orbits, &p->orbit, NULL) == SALTUS_OK;
}

static bool measure(saltus_extended *x, saltus_locus_point *p) {
    p->corner_count = saltus_corner_measure(x, &p->at, &p->orbit, p->corners);
    p->before_place = 0;
    return true;
}

bool saltus_locus_see(saltus_extended *x, saltus_locus_point *p) {
    return saltus_locus_see_orbit(x, p) && measure(x, p);
}

bool saltus_locus_survey(saltus_extended *x, saltus_locus_point *p) {
    return saltus_locus_survey_orbit(x, p) && measure(x, p);
}

saltus_status saltus_locus_take_up(saltus_extended *x, saltus_locus_point *here, const double *u,
                                   double extra, saltus_message *message) {
    saltus_equations *orbit = x->orbits.equations;
    size_t bytes = (size_t)orbit->unknowns * sizeof *u;
    saltus_status status = saltus_extended_shape(x, message);
    if (status == SALTUS_OK && !saltus_curve_reserve(&here->at, x->equations.unknowns))
        status = saltus_branch_no_memory(message);
    if (status != SALTUS_OK)
        return saltus_orbits_noted(&x->orbits, status);
    memcpy(here->at.u, u, bytes);
    memcpy(x->anchor, u, bytes);
    if (x->extra)
        here->at.u[orbit->unknowns] = extra;
    status = saltus_equations_evaluate(orbit, here->at.u, message);
    if (status == SALTUS_OK && x->kind != SALTUS_POINT_GR)
        status = saltus_extended_choose(x, extra, message);
    return saltus_orbits_noted(&x->orbits, status);
}

saltus_status saltus_locus_find_first(saltus_extended *x, saltus_locus_point *here, int k,
                                      saltus_message *message) {
    const size_t m = (size_t)x->equations.unknowns;
    double *normal = memset(x->kept, 0, m * sizeof *normal);
    normal[k] = 1;
    const double *anchor = memcpy(normal + m, here->at.u, m * sizeof *normal);
    saltus_status status =
        saltus_newton(&x->equations, here->at.u, normal, anchor, true, &here->at.iterations, message);
    if (status == SALTUS_OK) {
        saltus_extended_renew(x, here->at.u);
        status = saltus_equations_evaluate(&x->equations, here->at.u, message);
    }
    if (status == SALTUS_OK)
        status = saltus_curve_orient(&x->equations, NULL, &here->at, message);
    return saltus_orbits_noted(&x->orbits, status);
}

saltus_status saltus_locus_find_again(saltus_extended *x, saltus_locus_point *here, const double *u,
                                      double extra, saltus_message *message) {
    const int c = x->orbits.equations->count;
    saltus_status status = SALTUS_NO_CONVERGENCE;
    for (int k = 1; k >= 0 && status != SALTUS_OK; k--) {
        status = saltus_locus_take_up(x, here, u, extra, message);
        if (status == SALTUS_OK)
            status = saltus_locus_find_first(x, here, c + k, message);
    }
    return status;
}

saltus_status saltus_locus_find_near(saltus_extended *x, saltus_locus_point *here, double theta,
                                     saltus_message *message) {
    static const double aside[] = {0.05, 0.1, 0.2, 0.4};
    int c = x->orbits.equations->count;
    saltus_status status = SALTUS_NO_CONVERGENCE;
    if (x->kind != SALTUS_POINT_NS || (theta != 0 && theta != M_PI))
        return saltus_locus_find_again(x, here, here->orbit.at.u, theta, message);
    for (int k = 0; k < 4 && status != SALTUS_OK; k++) {
        status = saltus_locus_take_up(x, here, here->orbit.at.u, fabs(theta - aside[k]), message);
        if (status == SALTUS_OK)
            status = saltus_locus_find_first(x, here, c + 2, message);
    }
    return status;
}

/* For an orbit cut halfway: the deviation, in state entry i of the vector u of unknowns, from orbits of half
 * the period or, with `mirrored`, from those that are their own mirror images. */
static double half_apart(const saltus_extended *x, const double *u, int i, bool mirrored) {
    const saltus_sequence *s = &x->orbits.shooting->sequence;
    int half = 1;
    while (half + 1 < s->cuts && s->cut[half] < s->base + 0.499 * s->periods)
        half++;
    return u[half * x->orbits.n + i] + (mirrored ? u[i] : -u[i]);
}

void saltus_locus_keep_mirrored(const saltus_extended *x, saltus_locus_point *here) {
    const saltus_sequence *s = &x->orbits.shooting->sequence;
    const int n = x->orbits.n, half = s->count / 2, ends[2] = {n, half};
    double *part = here->at.tangent;
    for (int k = 0; k < 2 && s->cuts == 2; k++) {
        const double sign = k ? 1 : -1;
        for (int i = 0; i < ends[k]; i++) {
            part[i] = 0.5 * (part[i] + sign * part[ends[k] + i]);
            part[ends[k] + i] = sign * part[i];
        }
        part += 2 * n;
    }
    saltus_make_unit(here->at.tangent, here->at.unknowns);
}

double saltus_locus_leaving(const saltus_extended *x, const saltus_locus_point *here) {
    double apart[2] = {0, 0};
    for (int i = 0; i < x->orbits.n; i++)
        for (int k = 0; k < 2; k++)
            apart[k] = fmax(apart[k], fabs(half_apart(x, here->at.tangent, i, k)));
    return fmin(apart[0], apart[1]);
}

saltus_status saltus_locus_find_crossing(saltus_extended *x, saltus_locus_point *here, bool leaves,
                                         saltus_message *message) {
    const double singular = 1e-6;
    int m = x->equations.unknowns, n = x->orbits.n;
    double values[2], share[2][2] = {{0}}, length = 0, *plane = x->kept;
    bool mirrored = !(saltus_solution_part_distance(&x->orbits, &here->orbit, 2, NULL) < 1e-6);
    saltus_status status = saltus_equations_evaluate(&x->equations, here->at.u, message);
    if (status == SALTUS_OK)
        status = saltus_null_plane(&x->equations, plane, values, message);
    for (int i = 0; i < n && status == SALTUS_OK; i++)
        for (int k = 0; k < 4; k++)
            share[k / 2][k % 2] += half_apart(x, plane + (k / 2) * m, i, mirrored) *
                                   half_apart(x, plane + (k % 2) * m, i, mirrored);
    const double *most = share[share[1][1] > share[0][0]];
    if (status == SALTUS_OK && !leaves && !(values[1] < singular))
        return saltus_locus_find_again(x, here, here->orbit.at.u, 0, message);
    here->at.iterations = 0;
    here->at.bent = false;
    length = hypot(most[0], most[1]);
    for (int j = 0; j < m && status == SALTUS_OK; j++)
        here->at.tangent[j] = (most[0] * plane[m + j] - most[1] * plane[j]) / length;
    if (status == SALTUS_OK && leaves) {
        memcpy(plane, here->at.tangent, (size_t)m * sizeof *plane);
        status =
            saltus_curve_leaving(&x->equations, here->at.u, plane, here->at.tangent, &values[1], message);
    }
    return status;
}

bool saltus_locus_install(saltus_extended *x, saltus_locus_point *here, const saltus_sequence *old,
                          const double *tangent, double more, const int *order) {
    const saltus_sequence *fresh = &here->orbit.sequence;
    const int m = x->orbits.equations->unknowns, n = x->orbits.n, mark = x->mark;
    double *guide = calloc((size_t)(m + x->extra), sizeof *guide);
    x->orbits.starved |= !guide;
    if (!guide)
        return false;
    saltus_sequence_carry(old, tangent, fresh, order, n, 2, guide);
    if (x->extra)
        guide[m] = tangent[saltus_sequence_unknowns(old, n) + 2];
    for (int k = 0; k < fresh->count; k++)
        if (order[k] == mark)
            x->mark = k;
    saltus_status status = saltus_locus_take_up(x, here, here->orbit.at.u, more, NULL);
    x->folds = false;
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(&x->equations, here->at.u, NULL);
    if (status == SALTUS_OK)
        status = saltus_curve_orient(&x->equations, guide, &here->at, NULL);
    free(guide);
    /* The determinants have changed. */
    return saltus_orbits_noted(&x->orbits, status) == SALTUS_OK && saltus_locus_survey(x, here);
}

bool saltus_locus_grows(const saltus_extended *x, const saltus_solution *s) {
    return s->growth > (x->kind == SALTUS_POINT_GR ? 1e4 : 1e2);
}

bool saltus_locus_reframe(saltus_extended *x, saltus_locus_point *here, saltus_locus_point *scratch) {
    const int unknowns = here->at.unknowns;
    int order[SALTUS_MARKS_MAX];
    const saltus_sequence old = here->orbit.sequence;
    if (!saltus_solution_reframe(&x->orbits, x->kind != SALTUS_POINT_GR, false, &here->orbit, &scratch->orbit,
                                 order) &&
        !(saltus_locus_grows(x, &here->orbit) &&
          saltus_solution_refine(&x->orbits, &here->orbit, &scratch->orbit, order)))
        return true;
    return saltus_locus_install(x, here, &old, here->at.tangent, x->extra ? here->at.u[unknowns - 1] : 0,
                                order);
}

/* A function around a place of a curve. */
typedef struct slope {
    double apart;   /* as far off as this, to both sides, it is linear */
    double zero;    /* of the line, ahead of the place */
    double scatter; /* of the points, in the plane */
} slope;

/* The slope of a function around a place, from no closer than slope->apart on; `vanishes`: the place is its
 * zero. False if none shows. */
static bool find_slope(saltus_curve_function *function, void *context, double place, bool vanishes,
                       const saltus_curve_point *at, int c, slope *found) {
    enum { places = 4 };
    static const double beside[places] = {-2, -1, 1, 2};
    const double farthest = 1e-4, share = 0.25;
    bool clear = false;
    for (double apart = found->apart; !clear && apart < farthest; apart *= 4) {
        double value[places] = {0}, scatter[2] = {0, 0}, middle = 0;
        clear = true;
        for (int k = 0; k < places && clear; k++) {
            clear = function(context, place + beside[k] * apart, &value[k]);
            for (int d = 0; d < 2 && clear; d++)
                scatter[d] += (beside[k] * beside[k] > 1 ? 1 : -1) * at->u[c + d];
            middle += vanishes ? 0 : value[k] / places;
        }
        const double rise = 0.25 * (value[places - 1] - value[0]);
        for (int k = 0; k < places; k++)
            clear = clear && fabs(value[k] - middle - beside[k] * rise) < share * fabs(rise);
        *found = (slope){apart, -apart * middle / rise, hypot(scatter[0], scatter[1])};
    }
    return clear;
}

double saltus_locus_doubt(saltus_curve_function *function, void *context, void *other, double place,
                          const saltus_curve_point *at, const saltus_curve_point *there, int c) {
    const double first = 1e-10;
    slope own = {.apart = first};
    if (!find_slope(function, context, place, true, at, c, &own))
        return NAN;
    slope apart = own;
    double value;
    const bool found = other && find_slope(function, other, place, false, there, c, &apart) &&
                       function(other, place + apart.zero, &value) && function(context, place, &value);
    const double flows = found ? hypot(there->u[c] - at->u[c], there->u[c + 1] - at->u[c + 1]) : INFINITY;
    return own.apart * hypot(at->tangent[c], at->tangent[c + 1]) + own.scatter + saltus_cautious * flows;
}

double saltus_locus_apart(saltus_extended *x, const saltus_solution *s, int *parts) {
    /* What forces may have that symmetry, and orbits that only graze, where stops or impacts have not. */
    const bool mirrors = !x->mirrored && (x->kind == SALTUS_POINT_GR || x->orbits.system->mirror);
    int nearest = 2;
    double least = INFINITY;
    for (int k = 1, left = s->sequence.periods; k <= (left > 2 ? left : 2); k++) {
        const bool tried = k == 1 ? mirrors : k == 2 || (x->kind == SALTUS_POINT_GR && left % k == 0);
        const double own = tried ? saltus_solution_part_distance(&x->orbits, s, k, NULL) : INFINITY;
        if (own < least || (k == 2 && own == least)) {
            least = own;
            nearest = k;
        }
        while (k > 1 && left % k == 0)
            left /= k;
    }
    if (parts)
        *parts = nearest;
    return least;
}

/* How unlike the parts of an orbit are where they are most so, amid its events: a run of impacts leaves
 * little of that. */
static double most_unlike(saltus_orbits *o, const saltus_solution *s, int parts) {
    const saltus_sequence *q = &s->sequence;
    const double part = (double)q->periods / (parts == 1 ? 2 : parts);
    double most = saltus_solution_part_distance(o, s, parts, NULL), state[2][SALTUS_STATE_MAX];
    for (int k = 0; k < q->count; k++) {
        const double next = k + 1 < q->count ? q->mark[k + 1].time : q->mark[0].time + q->periods,
                     time = 0.5 * (q->mark[k].time + next);
        for (int j = 0; j < 2; j++) {
            const double since = fmod(time + j * part - q->base, q->periods);
            const saltus_status status = saltus_solution_state_at(o, s, q->base + since, state[j], NULL);
            if (saltus_orbits_noted(o, status) != SALTUS_OK)
                return most;
        }
        for (int i = 0; i < o->n && parts == 1; i++)
            state[1][i] = -state[1][i];
        most = fmax(most, saltus_system_distance(o->system, state[0], state[1]));
    }
    return most;
}

bool saltus_locus_joins_at(saltus_extended *x, const saltus_locus_point *here, const saltus_locus_point *at) {
    int parts;
    if (x->kind != SALTUS_POINT_GR)
        return false;
    const double before = saltus_locus_apart(x, &here->orbit, NULL),
                 apart = saltus_locus_apart(x, &at->orbit, &parts);
    return saltus_orbits_join(&x->orbits, before, apart, at->at.ahead) &&
           saltus_orbits_join(&x->orbits, most_unlike(&x->orbits, &here->orbit, parts),
                              most_unlike(&x->orbits, &at->orbit, parts), at->at.ahead);
}

bool saltus_locus_leads(const saltus_extended *x, const saltus_locus_point *here, double near,
                        saltus_locus_point *at) {
    /* The curve may turn before, and rounding may have led a little beyond. */
    const double straight = 0.5, rounding = 1e-8;
    const double *way = here->at.tangent + here->at.unknowns - 2 - x->extra, *from = here->orbit.parameter,
                 *to = at->orbit.parameter;
    const double length = hypot(to[0] - from[0], to[1] - from[1]);
    at->at.ahead = length;
    return length < near && (length < rounding || (to[0] - from[0]) * way[0] + (to[1] - from[1]) * way[1] >
                                                      straight * length * hypot(way[0], way[1]));
}

bool saltus_locus_has_pair(saltus_extended *x, double theta) {
    const double near = 1e-2;
    double re[SALTUS_STATE_MAX], im[SALTUS_STATE_MAX];
    const int n = saltus_corner_multipliers(&x->orbits, x->orbits.shooting, re, im);
    /* Where the pair meets, an error moves both apart by its root, but their sum and product only by itself.
     */
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++)
            if (hypot(re[i] + re[j] - 2 * cos(theta), im[i] + im[j]) < near &&
                hypot(re[i] * re[j] - im[i] * im[j] - 1, re[i] * im[j] + im[i] * re[j]) < near)
                return true;
    return false;
}

/* Whether nothing is left to the flow. */
static bool is_prescribed(const saltus_sequence *s) {
    bool driven = s->driven;
    for (int k = 0; k < s->count; k++)
        driven = driven || s->mark[k].driven;
    return !driven;
}

/* Whether another impact has no speed either just where the one that is followed grazes: impacts without
 * effect, all at one touch of an orbit that has fewer. */
static bool has_collapsed(const saltus_extended *x, const saltus_solution *s) {
    const double still = 1e-8, near = 1e-4;
    const saltus_mark *own = &s->sequence.mark[x->mark];
    for (int k = 0; k < s->breach_count && x->kind == SALTUS_POINT_GR; k++) {
        const saltus_breach *other = &s->breaches[k];
        if (other->kind == SALTUS_BREACH_SPEED && other->mark != x->mark && other->face == own->face &&
            fabs(other->value) < still && fabs(other->time - own->time) < near)
            return true;
    }
    return false;
}

/* Whether a step has led to another piece of the curve, or another curve, beside it: on one smooth piece the
 * chord's angles with the two tangents add up to that between these, or nearly so. */
static bool leaps(const saltus_locus_point *here, const saltus_locus_point *to) {
    const double share = 1.5, little = 0.05, shortest = 1e-3;
    const int m = to->at.unknowns;
    double distance = 0, from = 0, onto = 0, turn = 0;
    for (int j = 0; j < m; j++)
        distance = hypot(distance, to->at.u[j] - here->at.u[j]);
    for (int j = 0; j < m; j++) {
        const double chord = (to->at.u[j] - here->at.u[j]) / distance;
        from = hypot(from, chord - here->at.tangent[j]);
        onto = hypot(onto, chord - to->at.tangent[j]);
        turn = hypot(turn, to->at.tangent[j] - here->at.tangent[j]);
    }
    return distance > shortest && from + onto > share * turn + little;
}

bool saltus_locus_is_sound(saltus_extended *x, const saltus_locus_point *here, const saltus_locus_point *p) {
    const double apart = 1e-6, nothing = 1e-9;
    const saltus_solution *s = &p->orbit;
    if (x->kind == SALTUS_POINT_BP && !(fabs(p->at.u[s->at.unknowns]) < 1e-8))
        return false;
    if (leaps(here, p) || has_collapsed(x, s))
        return false;
    const double breach = saltus_corner_breach(x, s);
    if (breach > nothing)
        return true;
    if (x->kind == SALTUS_POINT_NS && s->survey.walked && !saltus_locus_has_pair(x, p->at.u[s->at.unknowns]))
        return false;
    if (x->kind != SALTUS_POINT_GR)
        /* What is left to the flow it judges; prescribed impacts may be too slow for it. */
        return s->survey.follows || breach > 0 || is_prescribed(&s->sequence);
    int parts;
    const double distance = breach < -apart ? INFINITY : saltus_locus_apart(x, s, &parts);
    /* Beyond a long run of impacts what makes the halves unlike is always small. */
    return distance >= apart ||
           (distance > nothing && distance > 0.5 * saltus_locus_apart(x, &here->orbit, NULL)) ||
           most_unlike(&x->orbits, s, parts) >= apart;
}

bool saltus_locus_reach(saltus_extended *x, const saltus_curve_point *from, double ahead, double *tolerance,
                        double loosest, saltus_curve_point *to) {
    const double usual = x->equations.tolerance;
    saltus_status status = SALTUS_NO_CONVERGENCE;
    for (double t = *tolerance; status == SALTUS_NO_CONVERGENCE && t < 2 * loosest; t *= 10) {
        x->equations.tolerance = *tolerance = fmin(t, loosest);
        status = saltus_curve_visit(&x->equations, from, ahead, to, NULL);
    }
    x->equations.tolerance = usual;
    return saltus_orbits_noted(&x->orbits, status) == SALTUS_OK;
}

bool saltus_locus_visit(saltus_extended *x, const saltus_locus_point *here, double ahead,
                        saltus_locus_point *out) {
    const saltus_status status = saltus_curve_visit(&x->equations, &here->at, ahead, &out->at, NULL);
    return saltus_orbits_noted(&x->orbits, status) == SALTUS_OK &&
           !saltus_curve_strays(&here->at, &out->at) && saltus_locus_see(x, out);
}

void saltus_locus_sharpen(saltus_extended *x, const saltus_locus_point *here, double theta,
                          saltus_locus_point *at, saltus_locus_point *scratch) {
    enum { samples = 6 };
    const double apart = 0.02;
    int m = here->at.unknowns;
    double square[samples], *u = x->points;
    bool found = true;
    for (int k = 0; k < samples && found; k++) {
        double aside = apart * (k + 1);
        square[k] = aside * aside;
        const saltus_status status = saltus_curve_meet(&x->equations, &here->at, m - 1,
                                                       theta > 1 ? theta - aside : aside, &scratch->at, NULL);
        found = saltus_orbits_noted(&x->orbits, status) == SALTUS_OK;
        for (int j = 0; j < m && found; j++)
            u[j * samples + k] = scratch->at.u[j];
    }
    for (int j = 0; j < m && found; j++)
        at->at.u[j] = j < m - 1 ? saltus_curve_interpolate(square, u + j * samples, samples) : theta;
    at->doubt = found ? 0 : NAN;
    for (int j = m - 3; j < m - 1 && found; j++)
        at->doubt =
            hypot(at->doubt, at->at.u[j] - saltus_curve_interpolate(square, u + j * samples, samples - 1));
    if (found)
        saltus_locus_survey_orbit(x, at);
}

/* Whether an orbit has a contact after complete chatter that is shorter than this. */
static bool has_contact(const saltus_solution *s, double length) {
    for (int k = 0; k < s->breach_count; k++)
        if (s->breaches[k].value > -length && saltus_corner_ends_chatter(s, &s->breaches[k]))
            return true;
    return false;
}

bool saltus_locus_end_contact(saltus_extended *x, const saltus_locus_point *here, saltus_locus_point *at) {
    enum { halvings = 40 };
    const double reach = 1e-3, nothing = 1e-4, sharp = 1e-11, usual = x->equations.tolerance;
    const saltus_locus_test contact = {.kind = SALTUS_POINT_GR_GR, .breach = true};
    saltus_curve_point last = {.unknowns = 0};
    double place = 0, step = reach;
    if (!has_contact(&here->orbit, INFINITY))
        return false;
    bool room = saltus_curve_copy(&here->at, &last);
    /* A residual speed at grazing moves the place by as much. */
    x->equations.tolerance = fmin(usual, sharp);
    for (int k = 0; k < halvings && room;) {
        const saltus_status status = saltus_curve_visit(&x->equations, &last, step, &at->at, NULL);
        const bool sound = saltus_orbits_noted(&x->orbits, status) == SALTUS_OK &&
                           saltus_locus_see_orbit(x, at) && saltus_corner_breach(x, &at->orbit) <= 0;
        room = !sound || saltus_curve_copy(&at->at, &last);
        place += sound ? step : 0;
        /* Predicted from afar, an orbit that exists may not be found. */
        if (!sound || place + step > reach) {
            step *= 0.5;
            k++;
        }
    }
    room = room && saltus_curve_copy(&last, &at->at);
    x->orbits.starved |= !room;
    bool found = room && saltus_locus_survey_orbit(x, at);
    x->equations.tolerance = usual;
    at->doubt = 2 * step;
    at->at.ahead = place;
    saltus_curve_clear(&last);
    found = found && saltus_corner_breach(x, &at->orbit) > -nothing;
    const saltus_point_kind kind = found ? saltus_corner_tell(x, &contact, &at->orbit) : SALTUS_POINT_REGULAR;
    return kind == SALTUS_POINT_CH_GR || kind == SALTUS_POINT_CH;
}

bool saltus_locus_ceases_to_complete(const saltus_solution *s) {
    return has_contact(s, 1e-3);
}
