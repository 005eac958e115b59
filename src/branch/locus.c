/* Curves of special points in two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/locus.h"

#include "branch/locus_starts.h"
#include "branch/point.h"
#include "branch/sequence.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Steps are measured in the plane of the parameters, unless the states change so much faster. */
static const double slowest = 0.1;
static const char is_back[] = "the curve is closed: it has come back";

struct saltus_locus {
    saltus_branch_options options;
    saltus_extended x;
    double origin;       /* of the second parameter */
    double border[2][2]; /* of both parameter unknowns: low, high */
    saltus_locus_starts starts;
    saltus_point_kind begun_at; /* of the start that is under way: the point of codimension two, */
    int parent, depth;          /* and these */
    bool one_way;
    int ways[2], way_count,
        way;               /* headings from its first point, and which of them is under way; 0: either */
    double *beginning;     /* unknowns of the first point */
    saltus_sequence first; /* its sequence */
    int first_mark;
    saltus_curve_point here, next, trial;
    saltus_solution orbit, scratch, located; /* of `here`, of `next`, of `trial` */
    /* Of `here`, of `next`, of `trial`. */
    saltus_corner corners[SALTUS_CORNERS_MAX], corners_ahead[SALTUS_CORNERS_MAX],
        corners_there[SALTUS_CORNERS_MAX];
    int corner_count;
    int number, made; /* of the way */
    double arclength, step, first_plane[2], first_way[2];
    bool has_left;    /* it has been further from its first point than a few steps */
    double second[2]; /* the last place where two impacts grazed, */
    double gap;       /* how far from the one before, */
    int closer;       /* and how often it has been closer than before */
    bool lost;        /* the orbit could not be cut better */
    bool ended;       /* this curve */
    saltus_branch_point points[3 * SALTUS_CORNERS_MAX]; /* made but not yet given out */
    int made_count, given;
};

static saltus_status no_memory(saltus_message *message) {
    return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a locus");
}

/* The orbit at a point of the locus, surveyed. */
static saltus_status see_orbit(saltus_locus *l, const saltus_curve_point *point, saltus_solution *out,
                               saltus_message *message) {
    saltus_orbits *o = &l->x.orbits;
    size_t m = (size_t)o->equations->unknowns;
    if (!saltus_curve_reserve(&out->at, (int)m))
        return no_memory(message);
    memcpy(out->at.u, point->u, m * sizeof *point->u);
    memcpy(out->at.tangent, point->tangent, m * sizeof *point->u);
    out->at.iterations = point->iterations;
    saltus_status status = saltus_equations_evaluate(o->equations, out->at.u, message);
    if (status == SALTUS_OK)
        status = saltus_solution_see(o, out, message);
    if (status == SALTUS_OK)
        status = saltus_solution_survey(o, out, message);
    return status;
}

/* The orbit at a point that Newton's method has just found, and the functions whose zeros are corners. */
static saltus_status see_all(saltus_locus *l, const saltus_curve_point *point, saltus_solution *out,
                             saltus_corner *corners, saltus_message *message) {
    saltus_status status = see_orbit(l, point, out, message);
    if (status != SALTUS_OK)
        return status;
    int count = saltus_corner_measure(&l->x, point, out, corners);
    l->corner_count = count;
    return count < 0 ? no_memory(message) : SALTUS_OK;
}

/* Whether an orbit on a curve of grazing is one of half the period, or its own mirror image, as those of the
 * curve are not, by so much: another such curve crosses there. `halves` (may be NULL): which of the two. */
static bool joins(saltus_locus *l, const saltus_solution *s, double near, bool *halves) {
    bool shift, half = saltus_solution_half_distance(&l->x.orbits, s, false) < near;
    if (halves)
        *halves = half;
    return half || (!l->x.mirrored && saltus_system_mirror_symmetric(l->x.orbits.system, &shift) &&
                    saltus_solution_half_distance(&l->x.orbits, s, true) < near);
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

/* Whether the orbit is one, and the special one that is followed. Beyond another impact's birth or death it
 * is none, but the curve goes on to there. */
static bool is_sound(saltus_locus *l, const saltus_curve_point *point, const saltus_solution *s) {
    if (l->x.kind == SALTUS_POINT_BP && !(fabs(point->u[s->at.unknowns]) < 1e-8))
        return false;
    const double apart = 1e-6;
    double breach = saltus_corner_breach(&l->x, s);
    if (breach > 1e-9)
        return true;
    if (l->x.kind == SALTUS_POINT_NS && s->survey.walked &&
        !has_pair(&s->survey, l->x.orbits.n, point->u[s->at.unknowns]))
        return false;
    if (l->x.kind == SALTUS_POINT_GR)
        return breach < -apart || !joins(l, s, apart, NULL);
    /* The flow tells a breach as small as that of the last impacts of a long run. */
    return s->survey.follows || breach > 0;
}

/* `here` becomes the point with these unknowns of the sequence that the shooting has, `extra` the one beside
 * the orbit's, before it is known to lie on the locus. Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE, the
 * flow's. */
static saltus_status take_up(saltus_locus *l, const double *u, double extra, saltus_message *message) {
    saltus_equations *orbit = l->x.orbits.equations;
    size_t bytes = (size_t)orbit->unknowns * sizeof *u;
    saltus_status status = saltus_extended_shape(&l->x, message);
    if (status == SALTUS_OK && !saltus_curve_reserve(&l->here, l->x.equations.unknowns))
        status = no_memory(message);
    if (status != SALTUS_OK)
        return status;
    memcpy(l->here.u, u, bytes);
    memcpy(l->x.anchor, u, bytes);
    if (l->x.extra)
        l->here.u[orbit->unknowns] = extra;
    status = saltus_equations_evaluate(orbit, l->here.u, message);
    return status == SALTUS_OK && l->x.kind != SALTUS_POINT_GR ? saltus_extended_choose(&l->x, extra, message)
                                                               : status;
}

/* Onto the locus at the value of unknown k as it is; the tangent of either sign goes to `here`. */
static saltus_status find_first(saltus_locus *l, int k, saltus_message *message) {
    int m = l->x.equations.unknowns;
    double *normal = calloc((size_t)m, sizeof *normal), *anchor = calloc((size_t)m, sizeof *anchor);
    saltus_status status = normal && anchor ? SALTUS_OK : no_memory(message);
    if (status == SALTUS_OK) {
        normal[k] = 1;
        memcpy(anchor, l->here.u, (size_t)m * sizeof *anchor);
        status =
            saltus_newton(&l->x.equations, l->here.u, normal, anchor, true, &l->here.iterations, message);
    }
    if (status == SALTUS_OK)
        saltus_extended_renew(&l->x, l->here.u);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(&l->x.equations, l->here.u, message);
    if (status == SALTUS_OK)
        status = saltus_curve_orient(&l->x.equations, NULL, &l->here, message);
    free(normal);
    free(anchor);
    return status;
}

/* The angle of the pair on the unit circle. */
static double angle_on_circle(const saltus_survey *survey) {
    double best = INFINITY, angle = 0;
    for (int i = 0; i < survey->multiplier_count; i++)
        if (survey->multipliers[i].im > 0 && fabs(survey->multipliers[i].log_modulus) < best) {
            best = fabs(survey->multipliers[i].log_modulus);
            angle = atan2(survey->multipliers[i].im, survey->multipliers[i].re);
        }
    return angle;
}

/* The equations become those of a kind of points. Orbits that are their own mirror images are cut in halves
 * where others branch off. */
static void become(saltus_locus *l, saltus_point_kind kind, bool mirrored) {
    saltus_extended_close(&l->x);
    l->x.kind = kind;
    l->x.mirrored = mirrored;
    l->x.extra = kind == SALTUS_POINT_NS || kind == SALTUS_POINT_BP;
    l->x.copies = kind == SALTUS_POINT_NS ? 2 : 1;
    l->x.orbits.options.segments = mirrored && kind == SALTUS_POINT_BP ? 2 : l->options.orbit.segments;
}

/* `here` becomes the orbit `at`, or one on the locus near it. Two points of a Neimark-Sacker curve have its
 * angle 0 or pi, where the equations are singular: then the first point is a little away from there. */
static saltus_status find_near(saltus_locus *l, double theta, saltus_message *message) {
    static const double aside[] = {0.05, 0.1, 0.2, 0.4};
    int c = l->x.orbits.equations->count;
    bool meets = l->x.kind == SALTUS_POINT_NS && (theta == 0 || theta == M_PI);
    saltus_status status = SALTUS_NO_CONVERGENCE;
    for (int k = 0; k < (meets ? 4 : 1) && status != SALTUS_OK && status != SALTUS_NO_MEMORY; k++) {
        double angle = meets ? fabs(theta - aside[k]) : theta;
        status = take_up(l, l->orbit.at.u, angle, message);
        if (status == SALTUS_OK)
            status = find_first(l, meets ? c + 2 : c + 1, message);
    }
    return status;
}

/* Halfway around an orbit, cut there: how the state that is unknown i differs from what it is on orbits of
 * half the period, or on ones that are their own mirror images. */
static double half_apart(const saltus_locus *l, const double *u, int i, bool mirrored) {
    return u[l->x.orbits.n + i] + (mirrored ? u[i] : -u[i]);
}

/* At `here`, an orbit of half the period, or its own mirror image, two curves of grazing cross: that of such
 * orbits and that of those which branch off. The tangent becomes the latter's, from the null plane. */
static saltus_status find_leaving(saltus_locus *l, saltus_message *message) {
    int m = l->x.equations.unknowns, n = l->x.orbits.n;
    double values[2], share[2][2] = {{0}}, length = 0, *plane = calloc(2 * (size_t)m, sizeof *plane);
    bool mirrored = !(saltus_solution_half_distance(&l->x.orbits, &l->orbit, false) < 1e-6);
    saltus_status status = plane ? SALTUS_OK : no_memory(message);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(&l->x.equations, l->here.u, message);
    if (status == SALTUS_OK)
        status = saltus_null_plane(&l->x.equations, plane, values, message);
    for (int i = 0; i < n && status == SALTUS_OK; i++)
        for (int k = 0; k < 4; k++)
            share[k / 2][k % 2] += half_apart(l, plane + (k / 2) * m, i, mirrored) *
                                   half_apart(l, plane + (k % 2) * m, i, mirrored);
    const double *own = share[share[1][1] > share[0][0]];
    l->here.iterations = 0;
    for (int j = 0; j < m && status == SALTUS_OK; j++) {
        l->here.tangent[j] = own[0] * plane[j] + own[1] * plane[m + j];
        length = hypot(length, l->here.tangent[j]);
    }
    for (int j = 0; j < m && status == SALTUS_OK; j++)
        l->here.tangent[j] /= length;
    free(plane);
    return status;
}

/* A curve's first point, at a start. */
static saltus_status open_start(saltus_locus *l, const saltus_locus_start *start, saltus_message *message) {
    saltus_orbits *o = &l->x.orbits;
    saltus_sequence sequence = start->sequence;
    bool shift, breaks = start->kind == SALTUS_POINT_BP;
    become(l, start->kind, false);
    l->x.mark = start->mark;
    l->begun_at = start->origin;
    l->parent = start->parent;
    l->depth = start->depth;
    l->one_way = start->one_way;
    l->way = 0;
    saltus_status status =
        saltus_solution_place(o, &sequence, start->parameter, start->state, false, &l->orbit, message);
    if (status == SALTUS_OK && !start->leaves && saltus_system_mirror_symmetric(o->system, &shift) &&
        saltus_solution_half_distance(o, &l->orbit, true) < (breaks ? 1e-3 : 1e-7))
        become(l, start->kind, true);
    if (status == SALTUS_OK && ((l->x.mirrored && breaks) || start->leaves)) {
        sequence.cuts = 2;
        sequence.cut[1] = sequence.base + 0.5 * sequence.periods;
        status =
            saltus_solution_place(o, &sequence, start->parameter, start->state, false, &l->orbit, message);
    }
    if (status == SALTUS_OK && start->leaves)
        status = take_up(l, l->orbit.at.u, 0, message);
    if (status == SALTUS_OK)
        status = start->leaves ? find_leaving(l, message) : find_near(l, start->theta, message);
    if (status != SALTUS_OK)
        return status;
    l->first = l->orbit.sequence;
    l->first_mark = l->x.mark;
    free(l->beginning);
    l->beginning = calloc((size_t)l->x.equations.unknowns, sizeof *l->beginning);
    if (!l->beginning)
        return no_memory(message);
    memcpy(l->beginning, l->here.u, (size_t)l->x.equations.unknowns * sizeof *l->beginning);
    return see_all(l, &l->here, &l->orbit, l->corners, message);
}

/* The first curve's, from a point that a branch has found. */
static saltus_status open_first(saltus_locus *l, const saltus_solution *at, const saltus_sequence *beyond,
                                saltus_message *message) {
    const saltus_sequence *sequence = &at->sequence;
    if (beyond && beyond->count > sequence->count)
        sequence = beyond;
    const saltus_sequence *less = sequence == beyond ? &at->sequence : beyond;
    saltus_locus_start start = {.kind = l->options.locus,
                                .sequence = *sequence,
                                .parameter = {at->parameter[0], 0},
                                .state = at->state,
                                .parent = -1};
    while (beyond && start.mark < less->count &&
           sequence->mark[start.mark].time == less->mark[start.mark].time)
        start.mark++;
    if (start.kind == SALTUS_POINT_NS)
        start.theta = angle_on_circle(&at->survey);
    l->way_count = l->options.direction ? 1 : 2;
    l->ways[0] = l->options.direction < 0 ? -1 : 1;
    l->ways[1] = -1;
    return open_start(l, &start, message);
}

/* A locus with orbits of both parameters, on none yet. */
static saltus_status open_locus(const saltus_spec *spec, const saltus_branch_options *options,
                                saltus_locus **locus, saltus_message *message) {
    const double tolerance =
        1e-8; /* g is made of the Jacobian's entries, which are less sharp than residuals */
    saltus_locus *l = calloc(1, sizeof *l);
    *locus = l;
    if (!l)
        return no_memory(message);
    saltus_orbits *o = &l->x.orbits;
    l->options = *options;
    l->number = -1;
    l->ended = true;
    l->x.equations = (saltus_equations){.self = &l->x,
                                        .evaluate = saltus_extended_evaluate,
                                        .tolerance = fmax(tolerance, options->orbit.tolerance),
                                        .iterations = options->orbit.iterations};
    o->options = options->orbit;
    o->options.flow.stop = NULL;
    o->family = (saltus_family){.spec = *spec, .parameters = 2};
    saltus_status status = SALTUS_OK;
    for (int d = 0; d < 2 && status == SALTUS_OK; d++) {
        o->family.unit[d] = options->high[d] - options->low[d];
        status = saltus_spec_direction(spec, options->key[d], &o->family.direction[d],
                                       d ? &l->origin : &o->origin, message);
        for (int side = 0; side < 2; side++)
            l->border[d][side] = saltus_orbits_border(d ? l->origin : o->origin, o->family.unit[d],
                                                      side ? options->high[d] : options->low[d], side);
    }
    return status == SALTUS_OK ? saltus_orbits_open(o, message) : status;
}

saltus_status saltus_locus_new(const saltus_spec *spec, const saltus_branch_options *options,
                               const saltus_solution *at, const saltus_sequence *beyond, saltus_locus **locus,
                               saltus_message *message) {
    saltus_status status = open_locus(spec, options, locus, message);
    return status == SALTUS_OK ? open_first(*locus, at, beyond, message) : status;
}

void saltus_locus_free(saltus_locus *l) {
    if (!l)
        return;
    saltus_locus_starts_clear(&l->starts);
    saltus_extended_close(&l->x);
    saltus_curve_clear(&l->here);
    saltus_curve_clear(&l->next);
    saltus_curve_clear(&l->trial);
    saltus_solution_clear(&l->orbit);
    saltus_solution_clear(&l->scratch);
    saltus_solution_clear(&l->located);
    for (int k = l->given; k < l->made_count; k++)
        saltus_branch_point_clear(&l->points[k]);
    saltus_orbits_close(&l->x.orbits);
    free(l->beginning);
    free(l);
}

/* A point on a border of the range has the border's value, which the rounding of the unknown may miss. */
static void meet_borders(const saltus_locus *l, const saltus_solution *s, saltus_branch_point *point) {
    const saltus_family *family = &l->x.orbits.family;
    for (int d = 0; d < 2; d++)
        for (int side = 0; side < 2; side++) {
            double value = side ? l->options.high[d] : l->options.low[d];
            if (s->parameter[d] != l->border[d][side])
                continue;
            point->spec = saltus_spec_shifted(&point->spec, &family->direction[d], value - point->value[d]);
            point->value[d] = value;
        }
}

/* A point of the curve, `ahead` of `here`. */
static saltus_status give(saltus_locus *l, const saltus_solution *s, const saltus_curve_point *at,
                          saltus_point_kind kind, double ahead, const char *reason, saltus_message *message) {
    const saltus_family *family = &l->x.orbits.family;
    bool grazing = l->x.kind == SALTUS_POINT_GR || fabs(saltus_corner_breach(&l->x, s)) < 1e-8;
    saltus_branch_point *point = &l->points[l->made_count];
    saltus_status status = saltus_point_make(&l->x.orbits, s, grazing, point, message);
    if (status != SALTUS_OK)
        return status;
    l->ended = kind == SALTUS_POINT_EP || l->made + 1 >= l->options.points;
    if (l->ended && kind != SALTUS_POINT_EP)
        reason = "as many points as asked for";
    point->kind = l->ended ? SALTUS_POINT_EP : kind;
    point->locus = l->x.kind;
    point->branch = l->number;
    point->parent = l->parent;
    point->step = l->made++;
    point->arclength = l->arclength + ahead;
    point->accuracy = NAN;
    point->value[1] = l->origin + family->unit[1] * s->parameter[1];
    meet_borders(l, s, point);
    point->heading = at->tangent[l->x.orbits.equations->count] * family->unit[0];
    /* Whether it grazes the flow sees by chance, but not whether chatter completes. */
    if (grazing && s->survey.walked && s->survey.impacts < 0) {
        point->impacts = s->survey.impacts;
        memcpy(point->label, s->survey.label, sizeof point->label);
    }
    if (grazing)
        point->admissible = saltus_corner_breach(&l->x, s) < 1e-9;
    if (l->x.kind == SALTUS_POINT_GR) {
        const saltus_mark *own = &s->sequence.mark[l->x.mark];
        const saltus_breach touch = {.face = own->face, .time = own->time};
        saltus_point_mark_grazing(&l->x.orbits, &touch, point);
    }
    snprintf(point->reason, sizeof point->reason, "%s", reason ? reason : "");
    l->made_count++;
    return status;
}

/* Whether the last step, to `here` from what is now `next`, has led over the first point, the same way. */
static bool is_closed(saltus_locus *l) {
    int c = l->x.orbits.equations->count;
    const double *plane = l->here.u + c, *before = l->next.u + c;
    double step[2], back[2];
    for (int k = 0; k < 2; k++) {
        step[k] = plane[k] - before[k];
        back[k] = l->first_plane[k] - before[k];
    }
    double stride = hypot(step[0], step[1]);
    double along = (back[0] * step[0] + back[1] * step[1]) / stride;
    double aside = fabs(back[0] * step[1] - back[1] * step[0]) / stride;
    double same_way = step[0] * l->first_way[0] + step[1] * l->first_way[1];
    l->has_left |= hypot(back[0], back[1]) > 3 * stride;
    return l->has_left && along >= 0 && along <= stride && aside < 0.1 * stride && same_way > 0;
}

/* `here` becomes the same orbit as `orbit` has it, with a sequence that was made from `old`, at which the
 * tangent was `tangent`; order: where the marks stood. */
static saltus_status install(saltus_locus *l, const saltus_sequence *old, const double *tangent, double extra,
                             const int *order, saltus_message *message) {
    const saltus_sequence *fresh = &l->orbit.sequence;
    int m = l->x.orbits.equations->unknowns, old_unknowns = saltus_sequence_unknowns(old, l->x.orbits.n) + 2;
    double *guide = calloc((size_t)(m + l->x.extra), sizeof *guide);
    saltus_status status = guide ? SALTUS_OK : no_memory(message);
    if (status == SALTUS_OK) {
        saltus_sequence_carry(old, tangent, fresh, order, l->x.orbits.n, 2, guide);
        if (l->x.extra)
            guide[m] = tangent[old_unknowns];
        for (int k = 0, mark = l->x.mark; k < fresh->count; k++)
            if (order[k] == mark)
                l->x.mark = k;
        status = take_up(l, l->orbit.at.u, extra, message);
    }
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(&l->x.equations, l->here.u, message);
    if (status == SALTUS_OK)
        status = saltus_curve_orient(&l->x.equations, guide, &l->here, message);
    free(guide);
    /* The determinants are others now. */
    return status == SALTUS_OK ? see_all(l, &l->here, &l->orbit, l->corners, message) : status;
}

/* Cut the orbit better, where an event has come near its base or a cut. */
static saltus_status reframe(saltus_locus *l, saltus_message *message) {
    int order[SALTUS_MARKS_MAX];
    saltus_sequence old = l->orbit.sequence;
    if (!saltus_solution_reframe(&l->x.orbits, l->x.kind != SALTUS_POINT_GR, false, &l->orbit, &l->scratch,
                                 order))
        return SALTUS_OK;
    double *tangent = calloc((size_t)l->here.unknowns, sizeof *tangent);
    if (!tangent)
        return no_memory(message);
    memcpy(tangent, l->here.tangent, (size_t)l->here.unknowns * sizeof *tangent);
    saltus_status status =
        install(l, &old, tangent, l->x.extra ? l->here.u[l->here.unknowns - 1] : 0, order, message);
    free(tangent);
    return status;
}

/* `next` becomes `here`. */
static void step_on(saltus_locus *l) {
    saltus_curve_point point = l->here;
    saltus_solution orbit = l->orbit;
    l->here = l->next;
    l->next = point;
    l->orbit = l->scratch;
    l->scratch = orbit;
    l->arclength += l->here.ahead;
    saltus_curve_bend(&l->next, &l->here);
}

/* From `here`, a point of codimension two, a little on, as in the very place the signs of functions mean
 * nothing; `turns`: the other way if the orbit is not admissible this way; `leaves`: another curve of the
 * same kind crosses there. *found: whether it is; otherwise `why` says what the equations fail by, if they
 * do. Errors: SALTUS_NO_MEMORY. */
static saltus_status leave(saltus_locus *l, bool turns, bool leaves, bool *found, saltus_message *why,
                           saltus_message *message) {
    double ahead = leaves ? 1e-3 : 1e-4, usual = l->x.equations.tolerance;
    *why = (saltus_message){.text = ""};
    /* Where curves cross the equations are singular, and a residual moves a point near there by much. */
    l->x.equations.tolerance = leaves ? 1e-12 : usual;
    saltus_status status = SALTUS_OK;
    *found = false;
    for (int way = 0; way < 1 + turns && !*found && status != SALTUS_NO_MEMORY; way++) {
        if (way > 0)
            saltus_curve_turn(&l->here);
        status = saltus_curve_visit(&l->x.equations, &l->here, ahead, &l->next, why);
        if (status == SALTUS_OK)
            status = see_all(l, &l->next, &l->scratch, l->corners_ahead, why);
        *found = status == SALTUS_OK && saltus_corner_breach(&l->x, &l->scratch) < 0;
    }
    l->x.equations.tolerance = usual;
    if (*found) {
        memcpy(l->corners, l->corners_ahead, sizeof l->corners);
        step_on(l);
    }
    return status == SALTUS_NO_MEMORY ? no_memory(message) : SALTUS_OK;
}

/* Beyond a second grazing, `located`, the curve of the first goes on with the second impact born or dead:
 * `here` becomes an orbit a little beyond with that sequence, where it is admissible; in the very place,
 * where the second impact has no speed, the signs of the functions mean nothing. *passed: whether there is
 * such a way; *closes is set where it leads to where the curve began. Errors: SALTUS_NO_MEMORY. */
static saltus_status pass_grazing(saltus_locus *l, bool *passed, bool *closes, saltus_message *message) {
    int order[SALTUS_MARKS_MAX];
    saltus_sequence old = l->located.sequence, fresh;
    saltus_message why = {.text = ""};
    const saltus_breach *other = saltus_corner_touch(&l->x, &l->located);
    *passed = false;
    if (!other)
        return SALTUS_OK;
    saltus_breach touch = *other;
    touch.value = 0;
    saltus_sequence_graze(&old, &touch, 1, &fresh, order);
    saltus_status status = saltus_solution_place(&l->x.orbits, &fresh, l->located.parameter, l->located.state,
                                                 false, &l->orbit, &why);
    if (status == SALTUS_OK)
        status = install(l, &old, l->trial.tangent, 0, order, &why);
    if (status == SALTUS_OK && l->options.switches)
        status = saltus_locus_starts_pass(&l->x, &l->orbit, false, &l->starts, closes, &why);
    if (status == SALTUS_OK)
        status = leave(l, true, false, passed, &why, message);
    return status == SALTUS_NO_MEMORY ? no_memory(message) : SALTUS_OK;
}

/* The first point, and from a point of codimension two a little on; `leaves` as there. */
static saltus_status begin(saltus_locus *l, bool leaves, saltus_message *message) {
    int c = l->x.orbits.equations->count, heading = l->ways[l->way];
    saltus_status status = SALTUS_OK;
    bool found = true;
    if (l->way > 0) { /* back from where the first way ended */
        l->x.mark = l->first_mark;
        status = saltus_shooting_shape(l->x.orbits.shooting, &l->first, message);
        if (status == SALTUS_OK)
            status = take_up(l, l->beginning, l->beginning[l->x.orbits.equations->unknowns + l->x.extra - 1],
                             message);
        c = l->x.orbits.equations->count;
        if (status == SALTUS_OK)
            status = find_first(l, c + 1, message);
        if (status == SALTUS_OK)
            status = see_all(l, &l->here, &l->orbit, l->corners, message);
    }
    if (status != SALTUS_OK)
        return status;
    if (l->here.tangent[c + 1] * heading < 0)
        saltus_curve_turn(&l->here);
    l->way++;
    l->number++;
    l->made = 0;
    l->arclength = 0;
    l->has_left = l->lost = false;
    l->gap = l->closer = 0;
    l->step = 0.1 * l->options.step;
    memcpy(l->first_plane, l->here.u + c, sizeof l->first_plane);
    memcpy(l->first_way, l->here.tangent + c, sizeof l->first_way);
    status = give(l, &l->orbit, &l->here, l->x.kind, 0, NULL, message);
    bool resonance = l->begun_at == SALTUS_POINT_R1 || l->begun_at == SALTUS_POINT_R2;
    if (status != SALTUS_OK || !l->begun_at || (resonance && l->x.kind == SALTUS_POINT_NS) || l->ended)
        return status;
    saltus_message why;
    char reason[SALTUS_REASON_MAX];
    status = leave(l, l->one_way, leaves, &found, &why, message);
    memcpy(l->first_way, l->here.tangent + l->x.orbits.equations->count, sizeof l->first_way);
    if (status != SALTUS_OK || found)
        return status;
    snprintf(reason, sizeof reason, "the curve does not go on this way with admissible orbits%s%.80s",
             why.text[0] ? ": " : "", why.text);
    return give(l, &l->orbit, &l->here, SALTUS_POINT_EP, 0, reason, message);
}

/* Another curve, from where it meets one that was followed. Where none can be begun one point says why. */
static saltus_status switch_to(saltus_locus *l, saltus_locus_start *start, saltus_message *message) {
    saltus_message why = {.text = ""};
    char reason[SALTUS_REASON_MAX];
    start->done = true;
    l->way_count = start->one_way ? 1 : 2;
    l->ways[0] = start->one_way ? 0 : 1;
    l->ways[1] = -1;
    saltus_status status = open_start(l, start, &why);
    if (status == SALTUS_OK)
        return begin(l, start->leaves, message);
    l->way = l->way_count;
    if (status == SALTUS_NO_MEMORY || !l->orbit.at.u)
        return no_memory(message);
    l->number++;
    l->made = 0;
    l->arclength = 0;
    snprintf(reason, sizeof reason, "no curve of %s points can be begun at this %s: %.90s",
             saltus_point_word(start->kind), saltus_point_word(start->origin), why.text);
    saltus_curve_point at = {.tangent = l->orbit.at.tangent};
    return give(l, &l->orbit, &at, SALTUS_POINT_EP, 0, reason, message);
}

/* A step onto a sound orbit, halved until there is one; false if there is none. */
static saltus_status take_step(saltus_locus *l, int *reached, bool *found, saltus_message *message) {
    const double stride_min = 1e-5;
    int c = l->x.orbits.equations->count;
    const saltus_curve_bound bounds[2] = {{c, l->border[0][0], l->border[0][1]},
                                          {c + 1, l->border[1][0], l->border[1][1]}};
    saltus_message why = {.text = ""};
    for (*found = false; !*found && l->step > stride_min; l->step *= *found ? 1 : 0.5) {
        saltus_status status =
            saltus_curve_step(&l->x.equations, &l->here, &l->step, bounds, 2, &l->next, reached, &why);
        if (status == SALTUS_OK)
            status = see_all(l, &l->next, &l->scratch, l->corners_ahead, &why);
        if (status == SALTUS_NO_MEMORY)
            return no_memory(message);
        double stride = hypot(l->next.u[c] - l->here.u[c], l->next.u[c + 1] - l->here.u[c + 1]);
        *found =
            status == SALTUS_OK && stride <= 1.2 * l->options.step_max && is_sound(l, &l->next, &l->scratch);
    }
    if (*found)
        saltus_extended_renew(&l->x, l->next.u);
    return SALTUS_OK;
}

/* One corner under way. */
typedef struct location {
    saltus_locus *l;
    int corner;
} location;

static bool corner_at(void *context, double ahead, double *value) {
    location *self = context;
    saltus_locus *l = self->l;
    saltus_message ignored;
    if (saltus_curve_visit(&l->x.equations, &l->here, ahead, &l->trial, &ignored) != SALTUS_OK ||
        see_all(l, &l->trial, &l->located, l->corners_there, &ignored) != SALTUS_OK)
        return false;
    *value = saltus_scaled_in(l->corners_there[self->corner].value, l->corners[self->corner].value.exponent);
    return true;
}

/* Corners on a step, in their order. */
typedef struct crossings {
    int count;
    int corner[SALTUS_CORNERS_MAX];
    double place[SALTUS_CORNERS_MAX]; /* ahead of `here` */
} crossings;

/* All corners on the way from `here` to `next`. Where the curve ends at another impact's birth or death a
 * multiplier is infinite, and other functions may vanish with it: they tell nothing. False: the orbit changes
 * its events, but where cannot be located. */
static bool find_corners(saltus_locus *l, crossings *found) {
    const double together = 1e-6, jump = 1e-8;
    double ends = INFINITY;
    found->count = 0;
    for (int k = 0; k < l->corner_count; k++) {
        double near = saltus_scaled_in(l->corners[k].value, l->corners[k].value.exponent);
        double far = saltus_scaled_in(l->corners_ahead[k].value, l->corners[k].value.exponent);
        double place = 0, width, value;
        double quiet = l->corners[k].quiet;
        bool heard = quiet == 0 ||
                     !(l->corners[k].value.exponent < quiet && l->corners_ahead[k].value.exponent < quiet);
        location self = {l, k};
        bool located =
            near * far < 0 && heard &&
            saltus_curve_zero(l->x.orbits.solver, corner_at, &self, near, l->next.ahead, far, &place, &width);
        /* The first function is the breach, which may begin with a jump, where a maximum of the gap appears.
         */
        if (k == 0 && (located || far > 1e-9) &&
            !(located && corner_at(&self, place, &value) && fabs(value) < jump &&
              !(l->x.kind == SALTUS_POINT_GR && joins(l, &l->located, 1e-4, NULL))))
            return false;
        if (!located || place >= ends - together)
            continue;
        if (k == 0)
            ends = place;
        int at = found->count++;
        for (; at > 0 && found->place[at - 1] > place; at--) {
            found->place[at] = found->place[at - 1];
            found->corner[at] = found->corner[at - 1];
        }
        found->place[at] = place;
        found->corner[at] = k;
    }
    return true;
}

/* Where the pair of multipliers meets, at theta = 0 or pi, the equations are singular; but the curve is even
 * in theta there, so `trial` is interpolated in its square from regular points on the way. Where these cannot
 * be had it stays as it was located. */
static void sharpen_resonance(saltus_locus *l, double theta) {
    enum { samples = 6 };
    const double apart = 0.02;
    int m = l->here.unknowns;
    double square[samples], *u = calloc((size_t)(m * samples), sizeof *u);
    saltus_message ignored;
    bool found = u;
    if (!u)
        l->x.orbits.starved = true;
    for (int k = 0; k < samples && found; k++) {
        double aside = apart * (k + 1), at = theta > 1 ? theta - aside : aside;
        square[k] = aside * aside;
        found = saltus_curve_meet(&l->x.equations, &l->here, m - 1, at, &l->next, &ignored) == SALTUS_OK;
        for (int j = 0; j < m && found; j++)
            u[j * samples + k] = l->next.u[j];
    }
    for (int j = 0; j < m && found; j++)
        l->trial.u[j] = j < m - 1 ? saltus_curve_interpolate(square, u + j * samples, samples) : theta;
    free(u);
    if (found)
        see_orbit(l, &l->trial, &l->located, &ignored);
}

/* Where a contact that chatter leads to shrinks to nothing the equations end, and with them the curve, and
 * what is left of the contact falls like a power of the arclength: the place is bracketed. `trial` and
 * `located` become the last orbit at which chatter completes. *found: whether the curve ends so just ahead of
 * `here`. Errors: SALTUS_NO_MEMORY. */
static saltus_status end_contact(saltus_locus *l, bool *found, saltus_message *message) {
    enum { halvings = 40 };
    const double reach = 1e-3, nothing = 1e-4, sharp = 1e-11;
    double low = 0, high = reach, usual = l->x.equations.tolerance;
    saltus_message ignored;
    saltus_corner contact = {.kind = SALTUS_POINT_GR_GR, .breach = true};
    saltus_status status = SALTUS_OK;
    *found = false;
    /* A little speed at grazing moves the place by as much. */
    l->x.equations.tolerance = sharp;
    for (int k = 0; k <= halvings; k++) {
        double middle = k < halvings ? 0.5 * (low + high) : low;
        status = saltus_curve_visit(&l->x.equations, &l->here, middle, &l->trial, &ignored);
        if (status == SALTUS_OK)
            status = see_orbit(l, &l->trial, &l->located, &ignored);
        if (status == SALTUS_NO_MEMORY)
            return no_memory(message);
        *found = status == SALTUS_OK && saltus_corner_breach(&l->x, &l->located) <= 0;
        *(*found ? &low : &high) = middle;
    }
    l->x.equations.tolerance = usual;
    if (*found && saltus_corner_breach(&l->x, &l->located) > -nothing)
        status = saltus_corner_tell(&l->x, &contact, &l->located, &contact.kind, message);
    *found = contact.kind == SALTUS_POINT_CH_GR;
    return status == SALTUS_NO_MEMORY ? status : SALTUS_OK;
}

/* Whether an orbit that grazes, and grazes again half its period later, does so at another time too. */
static bool touches_elsewhere(const saltus_locus *l, const saltus_solution *s) {
    const double together = 1e-7, near = 1e-4;
    const saltus_mark *own = &s->sequence.mark[l->x.mark];
    for (int k = 0; k < s->breach_count; k++)
        if (s->breaches[k].kind <= SALTUS_BREACH_GAP && fabs(s->breaches[k].value) < together &&
            fabs(remainder(s->breaches[k].time - own->time, 0.5 * s->sequence.periods)) > near)
            return true;
    return false;
}

/* `trial` and `located` become the place where what is left of a breach is nothing, extrapolated from places
 * on the curve of `here` so far apart before it, where the equations are regular. Errors: SALTUS_NO_MEMORY,
 * those of the equations. */
static saltus_status extrapolate(saltus_locus *l, double apart, saltus_message *message) {
    enum { samples = 6 };
    const double tolerance = 1e-13, usual = l->x.equations.tolerance;
    int m = l->here.unknowns;
    double rest[samples], *u = calloc((size_t)(m * samples), sizeof *u);
    saltus_status status = u ? SALTUS_OK : no_memory(message);
    /* A residual moves the place by itself over the rest, and the bend much more. */
    l->x.equations.tolerance = tolerance;
    l->here.bent = false;
    for (int k = 0; k < samples && status == SALTUS_OK; k++) {
        status = saltus_curve_visit(&l->x.equations, &l->here, -(k + 1) * apart, &l->trial, message);
        if (status == SALTUS_OK)
            status = see_orbit(l, &l->trial, &l->located, message);
        rest[k] = status == SALTUS_OK ? saltus_corner_breach(&l->x, &l->located) : NAN;
        for (int j = 0; j < m && status == SALTUS_OK; j++)
            u[j * samples + k] = l->trial.u[j];
    }
    l->x.equations.tolerance = usual;
    l->trial.ahead = 0;
    for (int j = 0; j < m && status == SALTUS_OK; j++) {
        l->trial.u[j] = saltus_curve_interpolate(rest, u + j * samples, samples);
        l->trial.ahead += (l->trial.u[j] - l->here.u[j]) * l->here.tangent[j];
    }
    free(u);
    return status == SALTUS_OK ? see_orbit(l, &l->trial, &l->located, message) : status;
}

/* A curve of grazing whose orbits touch again half their period later, but for something that falls to
 * nothing (the speed there, or a gap), joins that of orbits of half the period, where these have a flip; or
 * the same of orbits that are their own mirror images, where these have a branch point. The equations are
 * singular there; but the curve depends smoothly on that rest. *kind: GR-PD or GR-BP where the curve joins
 * another so just ahead of `here`, GR-GR where another impact of the shorter orbit grazes too, otherwise
 * REGULAR. Errors: SALTUS_NO_MEMORY. */
static saltus_status join_at_grazing(saltus_locus *l, saltus_point_kind *kind, saltus_message *message) {
    static const double apart[] = {3e-3, 1e-3, 3e-4, 1e-4, 3e-5};
    const double little = 1e-4, near = 1e-3, sharp = 1e-10;
    bool halves;
    saltus_message ignored;
    *kind = SALTUS_POINT_REGULAR;
    if (l->x.kind != SALTUS_POINT_GR || !(saltus_corner_breach(&l->x, &l->orbit) > -little) ||
        !joins(l, &l->orbit, near, &halves))
        return SALTUS_OK;
    for (size_t k = 0; k < sizeof apart / sizeof apart[0] && !*kind; k++) {
        saltus_status status = extrapolate(l, apart[k], &ignored);
        if (status == SALTUS_NO_MEMORY)
            return no_memory(message);
        if (status == SALTUS_OK && fabs(l->trial.ahead) < apart[k] &&
            fabs(saltus_corner_breach(&l->x, &l->located)) < sharp &&
            saltus_solution_half_distance(&l->x.orbits, &l->located, !halves) < sharp)
            *kind = touches_elsewhere(l, &l->located) ? SALTUS_POINT_GR_GR
                    : halves                          ? SALTUS_POINT_GR_PD
                                                      : SALTUS_POINT_GR_BP;
    }
    return SALTUS_OK;
}

static const char *const corner_reasons[] = {
    [SALTUS_POINT_GR_LP] = "a fold meets grazing",
    [SALTUS_POINT_GR_PD] = "a flip meets grazing",
    [SALTUS_POINT_GR_NS] = "a Neimark-Sacker point meets grazing",
    [SALTUS_POINT_GR_GR] = "two impacts graze",
    [SALTUS_POINT_GR_BP] = "a branch point meets grazing",
    [SALTUS_POINT_CH_GR] = "complete chatter begins or ends at grazing",
    [SALTUS_POINT_R1] = "the pair of multipliers meets at 1",
    [SALTUS_POINT_R2] = "the pair of multipliers meets at -1",
};

/* Whether the places where two impacts graze, the last of them `trial`, come ever closer to one another. */
static bool accumulates(saltus_locus *l) {
    enum { enough = 4 };
    const double *place = l->trial.u + l->x.orbits.equations->count;
    double gap = hypot(place[0] - l->second[0], place[1] - l->second[1]);
    l->closer = gap < 0.9 * l->gap ? l->closer + 1 : 0;
    l->gap = gap;
    memcpy(l->second, place, sizeof l->second);
    return l->closer >= enough;
}

/* `trial` and `located` are a corner, at which the curve may end, or go on with other events: *moved. */
static saltus_status give_corner(saltus_locus *l, saltus_corner corner, double ahead, bool *moved,
                                 saltus_message *message) {
    bool ends = corner.ends, resonance = l->x.kind == SALTUS_POINT_NS && ends && !corner.breach;
    bool closes = false;
    *moved = false;
    saltus_status status = saltus_corner_tell(&l->x, &corner, &l->located, &corner.kind, message);
    if (status != SALTUS_OK)
        return status;
    saltus_point_kind kind = corner.kind;
    if (kind == SALTUS_POINT_EP)
        return give(l, &l->located, &l->trial, kind, ahead, "a contact begins, ends or splits", message);
    if (resonance) {
        sharpen_resonance(l, kind == SALTUS_POINT_R2 ? M_PI : 0);
        /* There the curve of tori turns back: theta goes on beyond 0 or pi, and gives the same orbits again.
         */
        for (int d = 0; d < 2; d++)
            l->trial.tangent[l->x.orbits.equations->count + d] = 0;
    }
    status = give(l, &l->located, &l->trial, kind, ahead, NULL, message);
    if (status != SALTUS_OK || l->ended)
        return status;
    if (l->options.switches)
        status = saltus_locus_starts_pass(&l->x, &l->located, false, &l->starts, &closes, message);
    if (status == SALTUS_OK && l->depth < l->options.switches)
        status = saltus_locus_starts_meet(&l->x, &corner, &l->located, l->number, l->depth + 1, &l->starts,
                                          message);
    if (status != SALTUS_OK)
        return status;
    if (kind == SALTUS_POINT_GR_GR && accumulates(l))
        return give(l, &l->located, &l->trial, SALTUS_POINT_EP, ahead,
                    "grazings follow one another ever more closely, towards complete chatter", message);
    if (kind == SALTUS_POINT_GR_GR)
        status = pass_grazing(l, moved, &closes, message);
    if (status == SALTUS_OK && closes && l->begun_at && l->x.kind == SALTUS_POINT_GR)
        return give(l, &l->located, &l->trial, SALTUS_POINT_EP, ahead, is_back, message);
    if (*moved)
        l->arclength += ahead;
    if (status == SALTUS_OK && ends && !*moved)
        status = give(l, &l->located, &l->trial, SALTUS_POINT_EP, ahead, corner_reasons[kind], message);
    return status;
}

/* Whether a contact after complete chatter has all but shrunk to nothing. */
static bool ceases_to_complete(const saltus_solution *s) {
    const double little = 1e-3;
    for (int k = 0; k < s->breach_count; k++)
        if (s->breaches[k].value > -little && saltus_corner_ends_chatter(s, &s->breaches[k]))
            return true;
    return false;
}

/* The curve ends where it is, as it does not go on. */
static saltus_status give_end(saltus_locus *l, saltus_message *message) {
    bool contact = false, closes = false;
    saltus_corner corner = {.kind = SALTUS_POINT_CH_GR};
    saltus_status status = l->lost ? SALTUS_OK : end_contact(l, &contact, message);
    if (status == SALTUS_OK && !l->lost && !contact) {
        status = join_at_grazing(l, &corner.kind, message);
        corner.joins = corner.kind;
    }
    if (status != SALTUS_OK)
        return status;
    if (!contact && !corner.joins)
        return give(l, &l->orbit, &l->here, SALTUS_POINT_EP, 0,
                    ceases_to_complete(&l->orbit)
                        ? "chatter ceases to complete: the contact after it shrinks to nothing"
                        : "the curve ends: its orbit changes its events or the curve has a corner",
                    message);
    const char *reason = corner.kind == SALTUS_POINT_GR_PD
                             ? "its orbits join those of half the period, whose flip meets grazing"
                         : corner.kind == SALTUS_POINT_GR_BP
                             ? "its orbits join their mirror images, whose branch point meets grazing"
                             : corner_reasons[corner.kind];
    status = give(l, &l->located, &l->trial, corner.kind, l->trial.ahead, NULL, message);
    if (status == SALTUS_OK && corner.joins && !l->ended && l->options.switches)
        status = saltus_locus_starts_pass(&l->x, &l->located, true, &l->starts, &closes, message);
    if (status == SALTUS_OK && corner.joins && !l->ended && l->depth < l->options.switches)
        status = saltus_locus_starts_meet(&l->x, &corner, &l->located, l->number, l->depth + 1, &l->starts,
                                          message);
    return status != SALTUS_OK || l->ended
               ? status
               : give(l, &l->located, &l->trial, SALTUS_POINT_EP, l->trial.ahead, reason, message);
}

/* One step along the curve under way, with the corners on it. */
static saltus_status advance(saltus_locus *l, saltus_message *message) {
    const double just_before = 1e-7;
    int reached;
    bool found, moved = false;
    crossings crossed;
    saltus_status status;
    if (l->lost)
        return give_end(l, message);
    for (;;) {
        status = take_step(l, &reached, &found, message);
        if (status != SALTUS_OK)
            return status;
        if (!found)
            return give_end(l, message);
        l->x.sharp = true;
        bool located = find_corners(l, &crossed);
        l->x.sharp = false;
        if (located)
            break;
        l->step = 0.5 * l->next.ahead;
    }
    for (int k = 0; k < crossed.count; k++) {
        location self = {l, crossed.corner[k]};
        double value;
        l->x.sharp = true;
        /* At a touch the flow meets the impact or not by chance: the survey is that of an orbit just before.
         */
        saltus_solution before = {.value = 0};
        if (l->corners_ahead[self.corner].breach && l->x.kind != SALTUS_POINT_GR &&
            corner_at(&self, crossed.place[k] - just_before, &value))
            saltus_survey_swap(&before, &l->located);
        found = corner_at(&self, crossed.place[k], &value);
        if (before.survey.walked)
            saltus_survey_swap(&before, &l->located);
        saltus_solution_clear(&before);
        l->x.sharp = false;
        /* Where the orbit becomes one of half the period, or its own mirror image, determinants are rounding;
         * where a pair of multipliers becomes real, the next one takes its place with a jump. */
        saltus_corner corner = l->corners_there[self.corner];
        bool jumps =
            corner.kind == SALTUS_POINT_GR_NS && !corner.breach && !(fabs(corner.value.mantissa) < 1e-6);
        if (!found || jumps || (l->x.kind == SALTUS_POINT_GR && joins(l, &l->located, 1e-4, NULL)))
            continue;
        status = give_corner(l, corner, crossed.place[k], &moved, message);
        if (status != SALTUS_OK || l->ended || moved)
            return status;
    }
    step_on(l);
    memcpy(l->corners, l->corners_ahead, sizeof l->corners);
    bool closed = is_closed(l);
    const double *way = l->here.tangent + l->x.orbits.equations->count;
    l->step = saltus_curve_next_step(l->step, l->here.iterations,
                                     l->options.step_max / fmax(hypot(way[0], way[1]), slowest));
    status = give(l, &l->orbit, &l->here, closed || reached >= 0 ? SALTUS_POINT_EP : l->x.kind, 0,
                  closed         ? is_back
                  : reached >= 0 ? "end of the parameters' range"
                                 : NULL,
                  message);
    if (status != SALTUS_OK || l->ended)
        return status;
    status = reframe(l, message);
    l->lost = status != SALTUS_OK && status != SALTUS_NO_MEMORY;
    return l->lost ? SALTUS_OK : status;
}

/* The other way from the first point, or the next curve. *more is false when all is done. */
static saltus_status begin_next(saltus_locus *l, bool *more, saltus_message *message) {
    saltus_locus_starts *starts = &l->starts;
    if (l->way < l->way_count)
        return begin(l, false, message);
    while (starts->next < starts->count && starts->start[starts->next].done)
        starts->next++;
    *more = starts->next < starts->count;
    if (!*more)
        return SALTUS_OK;
    /* The list may grow while the curve is followed. */
    return switch_to(l, &starts->start[starts->next++], message);
}

saltus_status saltus_locus_step(saltus_locus *l, saltus_branch_point *point, bool *more,
                                saltus_message *message) {
    saltus_status status = SALTUS_OK;
    *more = true;
    if (l->given == l->made_count) {
        l->given = l->made_count = 0;
        status = l->ended ? begin_next(l, more, message) : advance(l, message);
        if (status == SALTUS_OK && l->x.orbits.starved)
            status = no_memory(message);
    }
    if (status == SALTUS_OK && *more)
        *point = l->points[l->given++];
    return status;
}

bool saltus_locus_rests(const saltus_locus *l) {
    return l->given == l->made_count && l->number >= 0 && !l->lost;
}

/* The start of the curve under way, and the ways that lead from there. */
static void archive_start(saltus_locus *l, saltus_archive *a) {
    saltus_point_kind kind = saltus_locus_start_kind(a, l->x.kind);
    bool mirrored = saltus_archive_flag(a, l->x.mirrored);
    if (a->reading)
        become(l, kind, mirrored);
    l->begun_at = (saltus_point_kind)saltus_archive_whole(a, l->begun_at, 0, SALTUS_POINT_KINDS - 1);
    l->parent = (int)saltus_archive_whole(a, l->parent, -1, INT_MAX);
    l->depth = (int)saltus_archive_whole(a, l->depth, 0, INT_MAX);
    l->one_way = saltus_archive_flag(a, l->one_way);
    l->way_count = (int)saltus_archive_whole(a, l->way_count, 1, 2);
    l->way = (int)saltus_archive_whole(a, l->way, 1, l->way_count);
    for (int k = 0; k < l->way_count; k++)
        l->ways[k] = (int)saltus_archive_whole(a, l->ways[k], -1, 1);
}

/* The sequence of the first point, and its unknowns. */
static void archive_first(saltus_locus *l, saltus_archive *a) {
    saltus_archive_sequence(a, &l->first);
    l->first_mark = (int)saltus_archive_whole(a, l->first_mark, 0, SALTUS_MARKS_MAX - 1);
    a->sound = a->sound && (l->x.kind != SALTUS_POINT_GR || l->first_mark < l->first.count);
    saltus_archive_array(a, &l->beginning,
                         (size_t)(saltus_sequence_unknowns(&l->first, a->n) + 2 + l->x.extra));
    saltus_archive_finite(a, l->first_plane, 2);
    saltus_archive_finite(a, l->first_way, 2);
}

/* The orbit at `here`, and the equations' own vectors and derivative there. */
static saltus_status archive_here(saltus_locus *l, saltus_archive *a, saltus_message *message) {
    saltus_extended *x = &l->x;
    x->mark = (int)saltus_archive_whole(a, x->mark, 0, SALTUS_MARKS_MAX - 1);
    saltus_archive_shape(a, x->orbits.shooting);
    if (a->reading && a->sound) {
        saltus_status status = saltus_extended_shape(x, message);
        if (status != SALTUS_OK)
            return status;
    }
    if (!a->sound)
        return SALTUS_OK;
    size_t count = (size_t)x->orbits.equations->count, size = (size_t)x->copies * count;
    saltus_archive_finite(a, x->b, size);
    saltus_archive_finite(a, x->c, size);
    saltus_archive_finite(a, x->anchor, count + 2);
    x->differs = saltus_archive_flag(a, x->differs);
    if (x->differs)
        saltus_archive_finite(a, x->along, size * (count + 2));
    saltus_archive_point(a, &l->here);
    saltus_archive_solution(a, &l->orbit);
    bool marked = x->kind != SALTUS_POINT_GR || x->mark < l->orbit.sequence.count;
    a->sound = a->sound && (!a->reading || (marked && l->here.unknowns == x->equations.unknowns &&
                                            saltus_solution_fits(&x->orbits, &l->orbit)));
    return SALTUS_OK;
}

/* The functions whose zeros are corners, as far as the next step compares them. */
static void archive_corners(saltus_locus *l, saltus_archive *a) {
    l->corner_count = (int)saltus_archive_whole(a, l->corner_count, 0, SALTUS_CORNERS_MAX);
    for (int k = 0; k < l->corner_count; k++) {
        saltus_archive_real(a, &l->corners[k].value.mantissa);
        saltus_archive_real(a, &l->corners[k].value.exponent);
        saltus_archive_real(a, &l->corners[k].quiet);
    }
    saltus_archive_finite(a, l->second, 2);
    saltus_archive_finite(a, &l->gap, 1);
    l->closer = (int)saltus_archive_whole(a, l->closer, 0, INT_MAX);
}

saltus_status saltus_locus_archive(const saltus_spec *spec, const saltus_branch_options *options,
                                   saltus_locus **locus, saltus_archive *a, saltus_message *message) {
    saltus_status status = a->reading ? open_locus(spec, options, locus, message) : SALTUS_OK;
    if (status != SALTUS_OK)
        return status;
    saltus_locus *l = *locus;
    saltus_locus_starts_archive(a, &l->starts);
    saltus_archive_orbits(a, &l->x.orbits);
    archive_start(l, a);
    archive_first(l, a);
    l->number = (int)saltus_archive_whole(a, l->number, 0, INT_MAX);
    l->made = (int)saltus_archive_whole(a, l->made, 0, INT_MAX);
    saltus_archive_finite(a, &l->arclength, 1);
    saltus_archive_finite(a, &l->step, 1);
    a->sound = a->sound && (!a->reading || l->step > 0);
    l->has_left = saltus_archive_flag(a, l->has_left);
    l->ended = saltus_archive_flag(a, l->ended);
    archive_corners(l, a);
    /* Only the first point matters once the curve has ended. */
    return l->ended ? SALTUS_OK : archive_here(l, a, message);
}
