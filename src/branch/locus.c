/* Curves of special points in two parameters. Lack of memory on the way is noted in the orbits (solution.h);
 * what is found then counts for nothing, as the step fails at its end.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/locus.h"

#include "branch/born.h"
#include "branch/flat.h"
#include "branch/join.h"
#include "branch/options.h"
#include "branch/point.h"
#include "branch/sequence.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Steps are limited in the plane of the parameters; the tangent's part in it counts as at least this. */
static const double slowest = 0.1;
/* With shorter steps, to the shortest one, curves are followed only where no reason for their end is found:
 * after a run of impacts they turn within the speed of the last of them. */
static const double stride_short = 1e-5, stride_min = 1e-7;
static const char ceases_to_complete[] =
    "chatter ceases to complete: the contact after it shrinks to nothing";
static const char lost[] = "the equations fail at the first point";
static const char is_back[] = "the curve is closed: it has come back";

/* The parameters' part of a vector of unknowns. */
static double *plane_of(const saltus_locus *l, double *u) {
    return u + l->x.orbits.equations->count;
}

/* Whether the orbits of the curve are admissible on only one side of its first point. */
static bool is_one_way(const saltus_locus *l) {
    return l->begun_at && l->way_count == 1;
}

/* Where a way heads from the first point, in the second parameter, or in the first where that one stands
 * still; 0: either. */
static int heading_of(const saltus_locus *l, int way) {
    if (l->begun_at)
        return is_one_way(l) ? 0 : way ? -1 : 1;
    return way || l->trail->options->direction < 0 ? -1 : 1;
}

/* Whether curves of grazing may cross at the first point, that of orbits that are their own mirror images and
 * one of those that branch off: where the orbits of the curve under way are not such, they do. */
static bool begins_crossing(const saltus_locus *l) {
    return l->x.kind == SALTUS_POINT_GR && l->begun_at &&
           (l->x.mirrored || l->begun_at == SALTUS_POINT_GR_BP);
}

/* Set the equations for a kind of points. On curves of branch points, orbits that are their own mirror images
 * are cut in halves. */
static void become(saltus_locus *l, saltus_point_kind kind, bool mirrored) {
    saltus_extended_close(&l->x);
    l->x.kind = kind;
    l->x.mirrored = mirrored;
    l->x.extra = kind == SALTUS_POINT_NS || kind == SALTUS_POINT_BP;
    l->x.copies = kind == SALTUS_POINT_NS ? 2 : 1;
    l->x.orbits.options.segments =
        mirrored && kind == SALTUS_POINT_BP ? 2 : l->trail->options->orbit.segments;
    /* An impact's speed is as accurate as the residuals; the other functions are made of entries of the
     * Jacobian. */
    l->x.equations.tolerance = fmax(kind == SALTUS_POINT_GR ? 0 : 1e-8, l->trail->options->orbit.tolerance);
}

/* At a generalised Hopf point: `here` becomes a small cycle near it that folds, with the way on which cycles
 * grow. The unknown that is farthest from the equilibrium stays as it is. */
static saltus_status find_small(saltus_locus *l, const saltus_branch_start *start, saltus_message *message) {
    static const double apart[] = {0.1, 0.03, 0.3, 0.01};
    saltus_orbits *o = &l->x.orbits;
    int farthest = 0;
    saltus_status status = SALTUS_NO_CONVERGENCE;
    for (int k = 0; k < 4 && status != SALTUS_OK; k++) {
        status = saltus_hopf_aside(o, start->parameter, start->state, start->sequence.anchor, apart[k],
                                   &start->sequence, &l->here.orbit, message);
        if (status == SALTUS_OK)
            status = saltus_locus_take_up(&l->x, &l->here, l->here.orbit.at.u, 0, message);
        for (int i = 0; i < o->n && status == SALTUS_OK; i++)
            if (fabs(l->x.c[i]) > fabs(l->x.c[farthest]))
                farthest = i;
        if (status == SALTUS_OK)
            status = saltus_locus_find_first(&l->x, &l->here, farthest, message);
    }
    const double aside = l->here.orbit.state[farthest] - start->state[farthest];
    if (status == SALTUS_OK && l->here.at.tangent[farthest] * aside < 0)
        saltus_curve_turn(&l->here.at);
    return status;
}

/* `here` becomes the orbit `at`, or part of it, with another sequence. */
static saltus_status change_to(saltus_locus *l, const saltus_sequence *sequence, const saltus_solution *at,
                               saltus_message *message) {
    double *states;
    saltus_status status = saltus_solution_states_at(&l->x.orbits, at, sequence, &states, message);
    if (status == SALTUS_OK)
        status = saltus_solution_restore(&l->x.orbits, sequence, at->parameter, states, false, &l->here.orbit,
                                         message);
    free(states);
    return saltus_orbits_noted(&l->x.orbits, status);
}

/* Cut the orbit at `here`, that of a start, halfway, where no event is near. */
static saltus_status cut_halfway(saltus_locus *l, saltus_message *message) {
    const saltus_sequence old = l->here.orbit.sequence;
    saltus_sequence fresh;
    int order[SALTUS_MARKS_MAX];
    saltus_sequence_turn(&old, saltus_sequence_amid_halves(&old), 1, &fresh, order);
    fresh.cuts = 2;
    fresh.cut[1] = fresh.base + 0.5 * fresh.periods;
    const int mark = l->x.mark;
    for (int k = 0; k < fresh.count; k++)
        l->x.mark = order[k] == mark ? k : l->x.mark;
    return change_to(l, &fresh, &l->here.orbit, message);
}

/* `here` becomes the orbit of a start, as one of its curve. */
static saltus_status find_start(saltus_locus *l, const saltus_branch_start *start, saltus_message *message) {
    const double alike = 1e-6;
    saltus_orbits *o = &l->x.orbits;
    const bool breaks = start->kind == SALTUS_POINT_BP;
    saltus_status status = saltus_solution_restore(o, &start->sequence, start->parameter, start->state, false,
                                                   &l->here.orbit, message);
    const bool may_mirror = breaks || start->kind == SALTUS_POINT_GR || o->system->mirror;
    if (status == SALTUS_OK && !start->leaves && may_mirror &&
        saltus_solution_part_distance(o, &l->here.orbit, 1, NULL) < (breaks ? 1e-3 : alike))
        become(l, start->kind, true);
    int parts;
    if (status == SALTUS_OK && start->kind == SALTUS_POINT_GR && !start->leaves &&
        saltus_locus_apart(&l->x, &l->here.orbit, &parts) < alike && parts > 1) {
        const saltus_mark *own = &start->sequence.mark[l->x.mark];
        const saltus_breach touch = {.face = own->face, .time = own->time};
        saltus_sequence shorter;
        const int mark = saltus_locus_starts_grazing(o, &l->here.orbit, &touch, &shorter);
        if (mark >= 0) {
            l->x.mark = mark;
            saltus_solution_cuts(&l->here.orbit, &shorter);
            status = change_to(l, &shorter, &l->here.orbit, message);
        }
    }
    const bool crossing = start->leaves || (begins_crossing(l) && l->x.mirrored);
    /* There null vectors that keep the orbits their own mirror images are orthogonal to the others. */
    const bool halves = l->x.mirrored && (breaks || (start->kind == SALTUS_POINT_LP && o->system->mirror));
    if (status == SALTUS_OK && (halves || crossing))
        status = cut_halfway(l, message);
    /* Into more and more segments, as long as there are more. */
    for (bool finer = true; status == SALTUS_OK && finer && saltus_locus_grows(&l->x, &l->here.orbit);) {
        const double base = l->here.orbit.sequence.base;
        const int mark = l->x.mark;
        int order[SALTUS_MARKS_MAX];
        finer = saltus_solution_refine(o, &l->here.orbit, &l->trial.orbit, order);
        for (int k = 0; k < l->here.orbit.sequence.count && l->here.orbit.sequence.base != base; k++)
            l->x.mark = order[k] == mark ? k : l->x.mark;
    }
    if (status == SALTUS_OK && !crossing) {
        const double usual = l->x.equations.tolerance;
        const double sharp = saltus_locus_sharpness(&l->x, &l->here, usual);
        status = SALTUS_NO_CONVERGENCE;
        for (double t = sharp; status == SALTUS_NO_CONVERGENCE && t < fmin(1e3 * sharp, 10 * usual);
             t *= 10) {
            l->x.equations.tolerance = fmin(t, usual);
            status = saltus_locus_find_near(&l->x, &l->here, start->theta, message);
        }
        l->x.equations.tolerance = usual;
        if (status == SALTUS_OK && halves && !breaks)
            saltus_locus_keep_mirrored(&l->x, &l->here);
    }
    if (status != SALTUS_OK || !crossing)
        return status;
    status = saltus_locus_take_up(&l->x, &l->here, l->here.orbit.at.u, 0, message);
    return status == SALTUS_OK ? saltus_locus_find_crossing(&l->x, &l->here, start->leaves, message) : status;
}

/* A curve's first point, at a start. */
static saltus_status open_start(saltus_locus *l, const saltus_branch_start *start, saltus_message *message) {
    const double rest = 1e-9, zero[SALTUS_STATE_MAX] = {0};
    const saltus_orbits *o = &l->x.orbits;
    /* Small cycles around a rest that is its own mirror image are theirs, too. */
    const bool small = start->origin == SALTUS_POINT_GH,
               mirrored =
                   small && o->system->mirror && saltus_system_distance(o->system, start->state, zero) < rest;
    become(l, start->kind, mirrored);
    l->x.mark = start->mark;
    l->begun_at = start->origin;
    l->trail->parent = start->parent;
    l->trail->depth = start->depth;
    l->way = 0;
    saltus_status status = small ? find_small(l, start, message) : find_start(l, start, message);
    if (status != SALTUS_OK)
        return status;
    if (!saltus_locus_survey(&l->x, &l->here))
        return saltus_fail(message, SALTUS_NO_CONVERGENCE, lost);
    if (!saltus_curve_copy(&l->here.at, &l->beginning))
        return saltus_branch_no_memory(message);
    l->first = l->here.orbit.sequence;
    l->first_mark = l->x.mark;
    return SALTUS_OK;
}

saltus_status saltus_locus_open(saltus_locus *l, const saltus_spec *spec, const saltus_branch_start *first,
                                saltus_message *message) {
    const saltus_branch_options *options = l->trail->options;
    saltus_orbits *o = &l->x.orbits;
    l->x.equations = (saltus_equations){
        .self = &l->x, .evaluate = saltus_extended_evaluate, .iterations = options->orbit.iterations};
    /* The equations of a slow impact's time are steep: residuals may grow first. */
    l->x.equations.bold = true;
    o->options = options->orbit;
    o->options.flow.stop = NULL;
    saltus_status status = saltus_branch_family(spec, options, 2, &o->family, l->origin, l->border, message);
    o->origin = l->origin[0];
    if (status == SALTUS_OK)
        status = saltus_orbits_open(o, message);
    if (status != SALTUS_OK)
        return status;
    o->options.free_period = !saltus_system_forced(o->system);
    l->way = l->way_count = options->direction || !first ? 1 : 2;
    if (!first)
        return SALTUS_OK;
    l->trail->number = -1;
    status = open_start(l, first, message);
    return l->x.orbits.starved ? saltus_branch_no_memory(message) : status;
}

void saltus_locus_close(saltus_locus *l) {
    saltus_extended_close(&l->x);
    saltus_locus_point_clear(&l->here);
    saltus_locus_point_clear(&l->next);
    saltus_locus_point_clear(&l->trial);
    saltus_orbits_close(&l->x.orbits);
    saltus_curve_clear(&l->beginning);
    *l = (saltus_locus){.trail = l->trail, .starts = l->starts};
}

/* On a curve of grazing it is chance whether the flow meets the impact: `point` gets the multipliers without
 * it, those of the orbit a little beside the curve that does not touch the stop, if that is found. */
static void take_multipliers_without(saltus_locus *l, const saltus_solution *s, saltus_branch_point *point) {
    static const double apart[] = {1e-7, -1e-7, 1e-6, -1e-6};
    saltus_orbits *o = &l->x.orbits;
    const saltus_sequence without = saltus_corner_without(&l->x, s);
    saltus_solution beside = {.value = 0};
    double *states;
    bool found = false;
    const saltus_status status = saltus_solution_states_at(o, s, &without, &states, NULL);
    for (int d = 1; d >= 0 && status == SALTUS_OK && !found; d--) {
        saltus_orbits own = {.family = o->family, .options = o->options};
        own.family.spec = saltus_family_spec(&o->family, s->parameter, s->sequence.omega);
        own.family.parameters = 1;
        own.family.direction[0] = o->family.direction[d];
        own.family.unit[0] = o->family.unit[d];
        const bool opened = saltus_orbits_noted(o, saltus_orbits_open(&own, NULL)) == SALTUS_OK;
        for (size_t k = 0; k < sizeof apart / sizeof apart[0] && opened && !found; k++)
            found = saltus_solution_restore(&own, &without, &apart[k], states, true, &beside, NULL) ==
                        SALTUS_OK &&
                    beside.worst.value < 0 && saltus_solution_survey(&own, &beside, NULL) == SALTUS_OK &&
                    beside.survey.follows;
        o->starved |= own.starved;
        saltus_orbits_close(&own);
    }
    if (found)
        saltus_point_take_multipliers(&beside, point);
    free(states);
    saltus_solution_clear(&beside);
    saltus_orbits_noted(o, status);
}

/* Give out a point of the curve, what.ahead of `here`; nothing if the curve has ended. Of an end,
 * what.accuracy tells whether it was located. */
static void give_as(saltus_locus *l, const saltus_locus_point *p, saltus_notice what) {
    const saltus_solution *s = &p->orbit;
    const saltus_family *family = &l->x.orbits.family;
    const saltus_branch_options *options = l->trail->options;
    const bool located = what.kind != l->x.kind && (what.kind != SALTUS_POINT_EP || what.accuracy > 0);
    const double breach = saltus_corner_breach(&l->x, s);
    const bool grazes = l->x.kind == SALTUS_POINT_GR, grazing = grazes || fabs(breach) < 1e-8;
    saltus_cycle_count count;
    saltus_branch_point point;
    if (!l->trail->following)
        return;
    l->trail->following = saltus_point_make(&l->x.orbits, s, grazing, &point, &count);
    if (!l->trail->following)
        return;
    point.locus = l->x.kind;
    point.value[1] = l->origin[1] + family->unit[1] * s->parameter[1];
    /* A point on a border of the range gets the exact value of the border. */
    for (int k = 0; k < 4; k++) {
        const int d = k / 2, side = k % 2;
        const double value = side ? options->high[d] : options->low[d];
        if (s->parameter[d] != l->border[d][side])
            continue;
        point.spec = saltus_spec_shifted(&point.spec, &family->direction[d], value - point.value[d]);
        point.value[d] = value;
    }
    point.heading = plane_of(l, p->at.tangent)[0] * family->unit[0];
    if (grazing)
        point.admissible = breach < 1e-9;
    if (grazes) {
        const saltus_mark *own = &s->sequence.mark[l->x.mark];
        take_multipliers_without(l, s, &point);
        const saltus_breach touch = {.face = own->face, .time = saltus_point_time(s, &count, own->time)};
        saltus_point_mark_grazing(l->x.orbits.system, &touch, &point);
    }
    what.accuracy = located ? p->doubt * family->unit[0] : NAN;
    saltus_trail_give(l->trail, l->x.orbits.system, &point, NULL, &what, &l->x.orbits.starved);
}

static void give(saltus_locus *l, const saltus_locus_point *p, saltus_point_kind kind, double ahead,
                 const char *reason) {
    give_as(l, p, (saltus_notice){.kind = kind, .ahead = ahead, .reason = reason});
}

/* Whether the last step, from what is now `next` to `here`, has passed the first point in its direction: not
 * its place with more or fewer events. */
static bool is_closed(saltus_locus *l) {
    const double *first = l->beginning.u + saltus_sequence_unknowns(&l->first, l->x.orbits.n);
    const double *to = plane_of(l, l->here.at.u), *from = plane_of(l, l->next.at.u);
    const double step[2] = {to[0] - from[0], to[1] - from[1]};
    const double back[2] = {first[0] - from[0], first[1] - from[1]};
    const double stride = hypot(step[0], step[1]);
    const double along = (back[0] * step[0] + back[1] * step[1]) / stride;
    const double aside = fabs(back[0] * step[1] - back[1] * step[0]) / stride;
    const double same_way = step[0] * l->first_way[0] + step[1] * l->first_way[1];
    l->has_left |= hypot(back[0], back[1]) > 3 * stride;
    const bool same = l->here.orbit.sequence.count == l->first.count;
    return same && l->has_left && !is_one_way(l) && along >= 0 && along <= stride && aside < 0.1 * stride &&
           same_way > 0;
}

/* `next` becomes `here`. */
static void step_on(saltus_locus *l) {
    SALTUS_SWAP(l->here, l->next);
    l->trail->arclength += l->here.at.ahead;
    l->x.folds = false;
    saltus_curve_bend(&l->next.at, &l->here.at);
    for (int k = 0; k < l->here.corner_count; k++)
        l->here.before[k] = l->next.corners[k].value;
    l->here.before_place = -l->here.at.ahead;
}

/* Whether `p` is within the longest step of `here` in the plane. */
static bool is_near(const saltus_locus *l, const saltus_locus_point *p) {
    const double *from = plane_of(l, l->here.at.u), *to = plane_of(l, p->at.u);
    return hypot(to[0] - from[0], to[1] - from[1]) <= 1.2 * l->trail->options->step_max;
}

/* What is unlike in the halves shows, against rounding, where it is this large. */
static const double little = 4e-6;

/* Whether `p`, found so far ahead of `here`, is an orbit of the curve on which leave() goes: another one,
 * near or far, may have attracted it. */
static bool has_left(saltus_locus *l, const saltus_locus_point *p, double leaving, bool stays, double ahead) {
    return saltus_corner_breach(&l->x, &p->orbit) < 0 && is_near(l, p) &&
           !(leaving > 0 && saltus_locus_apart(&l->x, &p->orbit, NULL) < leaving * ahead) &&
           !(stays && saltus_solution_part_distance(&l->x.orbits, &p->orbit, 1, NULL) > 1e-3 * ahead);
}

/* `next`, found so far ahead of `here`, was sought from afar: come back along the curve while that is
 * possible, as points of codimension two in between would not be seen. False: the orbits there are not
 * admissible. */
static bool come_back(saltus_locus *l, double leaving, bool stays, double ahead) {
    const double near = 1e-3;
    const int m = l->here.at.unknowns;
    while (ahead > near) {
        saltus_curve_bend(&l->here.at, &l->next.at);
        const saltus_status status =
            saltus_curve_visit(&l->x.equations, &l->next.at, -0.5 * ahead, &l->trial.at, NULL);
        if (saltus_orbits_noted(&l->x.orbits, status) != SALTUS_OK || !saltus_locus_survey(&l->x, &l->trial))
            break;
        if (saltus_corner_breach(&l->x, &l->trial.orbit) >= 0)
            return false;
        ahead = saltus_dot(l->trial.at.u, l->here.at.tangent, m) -
                saltus_dot(l->here.at.u, l->here.at.tangent, m);
        if (!(ahead > 0) || !has_left(l, &l->trial, leaving, stays, ahead) ||
            (leaving > 0 && saltus_locus_apart(&l->x, &l->trial.orbit, NULL) < little))
            break;
        const saltus_locus_point nearer = l->trial;
        l->trial = l->next;
        l->next = nearer;
        l->next.at.ahead = ahead;
    }
    return true;
}

/* Go a little on from `here`, a point of codimension two, where the signs of functions mean nothing. `turns`:
 * also try the other direction, if orbits are not admissible in this one; `leaves`: another curve of the same
 * kind crosses there. False if no such point was found; `why` then says how the equations failed, if they
 * did. */
static bool leave(saltus_locus *l, bool turns, bool leaves, saltus_message *why) {
    static const double shorter[] = {1, 0.2, 0.04, 0.01}, tolerances[] = {1e-12, 1e-11, 1e-10};
    const bool stays = begins_crossing(l) && l->x.mirrored;
    const bool branches = l->x.kind == SALTUS_POINT_BP && l->x.mirrored;
    const bool crosses = leaves || stays || branches;
    const double usual = l->x.equations.tolerance, farthest = 0.1;
    const bool sharp = crosses || saltus_locus_sharpness(&l->x, &l->here, usual) < usual;
    *why = (saltus_message){.text = ""};
    bool found = false;
    /* A run of impacts leaves little of what makes the halves unlike: the first step must be long enough to
     * show it. */
    const double rate = leaves ? saltus_locus_leaving(&l->x, &l->here) : 1;
    const double leaving = leaves ? fmax(1e-8, fmin(1e-3, 0.5 * rate)) : 0;
    const double longest = crosses ? fmin(fmax(1e-3, little / rate), farthest) : 1e-4;
    const int tries = 4 * (1 + turns), rounds = sharp ? 3 : 1;
    for (int k = 0; k < rounds * tries && !found; k++) {
        const double ahead = longest * shorter[k % tries / (1 + turns)];
        /* Where curves cross, or impacts have no speed, the equations are singular, and a residual moves a
         * point near there by much; but it cannot be less than rounding. */
        l->x.equations.tolerance = sharp ? tolerances[k / tries] : usual;
        if (k > 0 && turns)
            saltus_curve_turn(&l->here.at);
        const saltus_status status =
            saltus_curve_visit(&l->x.equations, &l->here.at, ahead, &l->next.at, why);
        /* Folds of orbits that stay their own mirror images solve the equations of branch points, too, and
         * these those of folds. */
        found = saltus_orbits_noted(&l->x.orbits, status) == SALTUS_OK && !saltus_extended_strays(&l->x) &&
                saltus_locus_survey(&l->x, &l->next) && has_left(l, &l->next, leaving, stays, ahead) &&
                come_back(l, leaving, stays, ahead);
    }
    l->x.equations.tolerance = usual;
    if (found)
        step_on(l);
    return found;
}

/* Beyond `trial`, where a second impact grazes, the curve of the first goes on with the second impact born or
 * dead. `here` becomes an orbit of that sequence a little beyond, where it is admissible. False if there is
 * none; *closes is set if it leads to where the curve began. */
static bool pass_grazing(saltus_locus *l, bool *closes) {
    int order[SALTUS_MARKS_MAX];
    saltus_sequence old = l->trial.orbit.sequence, fresh;
    saltus_message why;
    const saltus_breach *other = saltus_corner_touch(&l->x, &l->trial.orbit);
    if (!other)
        return false;
    saltus_breach touch = *other;
    touch.value = 0;
    saltus_sequence_graze(&old, &touch, 1, &fresh, order);
    if (change_to(l, &fresh, &l->trial.orbit, NULL) != SALTUS_OK ||
        !saltus_locus_install(&l->x, &l->here, &old, l->trial.at.tangent, 0, order))
        return false;
    if (l->trail->options->switches)
        *closes |= saltus_locus_starts_pass(&l->x, &l->here.orbit, false, l->starts);
    return leave(l, true, false, &why);
}

/* Give out the first point and, at a point of codimension two, go a little on; `leaves` as for leave(). */
static saltus_status begin(saltus_locus *l, bool leaves, saltus_message *message) {
    const int heading = heading_of(l, l->way);
    saltus_status status = SALTUS_OK;
    if (l->way > 0) { /* return from where the first direction ended */
        l->x.mark = l->first_mark;
        status = saltus_shooting_shape(l->x.orbits.shooting, &l->first, message);
        const double extra = l->beginning.u[l->x.orbits.equations->unknowns + l->x.extra - 1];
        if (status == SALTUS_OK && !begins_crossing(l)) {
            status = saltus_locus_find_again(&l->x, &l->here, l->beginning.u, extra, message);
        } else if (status == SALTUS_OK) {
            status = saltus_locus_take_up(&l->x, &l->here, l->beginning.u, extra, message);
            if (status == SALTUS_OK && saltus_locus_see_orbit(&l->x, &l->here))
                status = saltus_locus_find_crossing(&l->x, &l->here, !l->x.mirrored, message);
        }
        if (status != SALTUS_OK)
            return status;
        if (!saltus_locus_survey(&l->x, &l->here))
            return saltus_fail(message, SALTUS_NO_CONVERGENCE, lost);
    }
    const double *way = plane_of(l, l->here.at.tangent);
    if ((fabs(way[1]) > 1e-9 * fabs(way[0]) ? way[1] : way[0]) * heading < 0)
        saltus_curve_turn(&l->here.at);
    l->way++;
    saltus_trail_begin(l->trail, l->trail->number + 1, l->trail->parent, l->trail->depth, false);
    l->has_left = false;
    l->grazings = (saltus_grazings){.gap = 0};
    l->trail->step = 0.1 * l->trail->options->step;
    memcpy(l->first_way, plane_of(l, l->here.at.tangent), sizeof l->first_way);
    give(l, &l->here, l->x.kind, 0, NULL);
    const bool resonance = l->begun_at == SALTUS_POINT_R1 || l->begun_at == SALTUS_POINT_R2;
    const bool aside = l->begun_at == SALTUS_POINT_GH || (resonance && l->x.kind == SALTUS_POINT_NS);
    if (!l->begun_at || aside || !l->trail->following)
        return SALTUS_OK;
    saltus_message why;
    char reason[SALTUS_REASON_MAX];
    const bool found = leave(l, is_one_way(l), leaves, &why);
    memcpy(l->first_way, plane_of(l, l->here.at.tangent), sizeof l->first_way);
    if (found)
        return SALTUS_OK;
    snprintf(reason, sizeof reason, "the curve does not go on this way with admissible orbits%s%.80s",
             why.text[0] ? ": " : "", why.text);
    give(l, &l->here, SALTUS_POINT_EP, 0, reason);
    return SALTUS_OK;
}

/* Begin another curve where it meets one that was followed. If that fails, one point says why. */
static saltus_status switch_to(saltus_locus *l, saltus_branch_start *start, saltus_message *message) {
    saltus_message why = {.text = ""};
    char reason[SALTUS_REASON_MAX];
    start->done = true;
    l->way_count = start->one_way ? 1 : 2;
    saltus_status status = open_start(l, start, &why);
    if (status == SALTUS_OK)
        return begin(l, start->leaves, message);
    l->way = l->way_count;
    if (status == SALTUS_NO_MEMORY || !l->here.orbit.at.u)
        return saltus_branch_no_memory(message);
    saltus_trail_begin(l->trail, l->trail->number + 1, l->trail->parent, l->trail->depth, false);
    snprintf(reason, sizeof reason, "no curve of %s points can be begun at this %s: %.90s",
             saltus_point_word(start->kind), saltus_point_word(start->origin), why.text);
    const saltus_locus_point first = {.orbit = l->here.orbit, .at.tangent = l->here.orbit.at.tangent};
    give(l, &first, SALTUS_POINT_EP, 0, reason);
    return SALTUS_OK;
}

/* Why a curve ends at a point of codimension two; second row: where its orbits join shorter ones. */
static const char *const corner_reasons[2][SALTUS_POINT_KINDS] = {
    {[SALTUS_POINT_CH] = ceases_to_complete,
     [SALTUS_POINT_ST] = "a contact begins, ends or splits",
     [SALTUS_POINT_GR_LP] = "a fold meets grazing",
     [SALTUS_POINT_GR_PD] = "a flip meets grazing",
     [SALTUS_POINT_GR_NS] = "a Neimark-Sacker point meets grazing",
     [SALTUS_POINT_GR_GR] = "two impacts graze",
     [SALTUS_POINT_GR_BP] = "a branch point meets grazing",
     [SALTUS_POINT_CH_GR] = "complete chatter begins or ends at grazing",
     [SALTUS_POINT_R1] = "the pair of multipliers meets at 1",
     [SALTUS_POINT_R2] = "the pair of multipliers meets at -1"},
    {[SALTUS_POINT_GR_PD] = "its orbits join those of half the period, whose flip meets grazing",
     [SALTUS_POINT_GR_BP] = "its orbits join their mirror images, whose branch point meets grazing",
     [SALTUS_POINT_GR_GR] = "two impacts graze",
     [SALTUS_POINT_GH] = "its cycles shrink to an equilibrium, whose first Lyapunov coefficient is zero",
     [SALTUS_POINT_CP] = "its orbits join their mirror images, whose branch point changes its criticality",
     [SALTUS_POINT_GPD] = "its orbits join those of half the period, whose flip changes its criticality",
     [SALTUS_POINT_LP_PD] = "its orbits join those of half the period, which fold and flip",
     [SALTUS_POINT_PD_NS] = "its orbits join those of half the period, at a flip and a pair on the circle",
     [SALTUS_POINT_R2] = "its orbits join those of half the period, which have a double multiplier -1",
     [SALTUS_POINT_R4] = "its orbits join those of a quarter of the period, at a pair at a quarter"}};

/* Add a place where two impacts graze; whether these places accumulate. */
static bool accumulate(saltus_grazings *g, const double place[2]) {
    enum { enough = 4 };
    const double gap = hypot(place[0] - g->last[0], place[1] - g->last[1]);
    *g = (saltus_grazings){{place[0], place[1]}, gap, gap < 0.9 * g->gap ? g->closer + 1 : 0};
    return g->closer >= enough;
}

/* Give out `trial`, a point of codimension two. Starts that wait there for this curve are marked as done, and
 * starts of other curves are added. Whether the curve has come back to its begin. */
static bool give_named(saltus_locus *l, const saltus_locus_test *corner, double ahead) {
    const saltus_trail *t = l->trail;
    const saltus_solution *at = &l->trial.orbit;
    give_as(l, &l->trial, (saltus_notice){.kind = corner->kind, .ahead = ahead, .joins = corner->joins});
    if (!t->following || t->options->switches == 0)
        return false;
    const bool closes = saltus_locus_starts_pass(&l->x, at, corner->joins, l->starts);
    if (t->depth < t->options->switches)
        saltus_locus_starts_meet(&l->x, corner, at, t->number, t->depth + 1, l->starts);
    return closes;
}

/* Give out the corner at `trial`; there the curve ends, or goes on. Whether it does with other events. */
static bool give_corner(saltus_locus *l, saltus_locus_test corner, double ahead) {
    const saltus_point_kind kind = corner.kind = saltus_corner_tell(&l->x, &corner, &l->trial.orbit);
    if (l->x.kind == SALTUS_POINT_NS && corner.ends && !corner.breach) {
        saltus_locus_sharpen(&l->x, &l->here, corner.theta, &l->trial, &l->next);
        saltus_halved_double(&l->x, kind, &l->trial);
        /* There the curve of tori turns back: theta goes on beyond 0, pi or, for mirror images, 2 pi and
         * gives the same orbits again. */
        memset(plane_of(l, l->trial.at.tangent), 0, 2 * sizeof(double));
    }
    bool closes = give_named(l, &corner, ahead);
    if (!l->trail->following)
        return false;
    const bool crowded = kind == SALTUS_POINT_GR_GR && accumulate(&l->grazings, plane_of(l, l->trial.at.u));
    const bool moved = kind == SALTUS_POINT_GR_GR && !crowded && pass_grazing(l, &closes);
    const char *ends = crowded ? "grazings follow one another ever more closely, towards complete chatter"
                       : closes && l->begun_at && l->x.kind == SALTUS_POINT_GR ? is_back
                       : corner.ends && !moved                                 ? corner_reasons[0][kind]
                                                                               : NULL;
    if (ends)
        give(l, &l->trial, SALTUS_POINT_EP, ahead, ends);
    else if (moved)
        l->trail->arclength += ahead;
    return moved;
}

/* End the curve at `trial`, where its orbits join shorter ones. */
static void give_join(saltus_locus *l, saltus_point_kind kind) {
    const saltus_locus_test corner = {.kind = kind, .joins = kind != SALTUS_POINT_GH};
    const double ahead = l->trial.at.ahead;
    int parts = 2;
    if (l->x.kind == SALTUS_POINT_GR)
        saltus_locus_apart(&l->x, &l->trial.orbit, &parts);
    give_named(l, &corner, ahead);
    give(l, &l->trial, SALTUS_POINT_EP, ahead,
         parts > 2 ? "its orbits join those of a part of the period, which graze" : corner_reasons[1][kind]);
}

static const char *why_it_ends(const saltus_solution *at) {
    return saltus_locus_ceases_to_complete(at)
               ? ceases_to_complete
               : "the curve ends: its orbit changes its events or the curve has a corner";
}

/* End the curve, which does not go on, at the special point just ahead, or at `here`; there only if this is
 * the `last` word. */
static void give_end(saltus_locus *l, bool last) {
    bool ends = saltus_locus_end_contact(&l->x, &l->here, &l->trial);
    const saltus_point_kind kind =
        ends ? SALTUS_POINT_REGULAR : saltus_locus_join(&l->x, &l->here, &l->trial);
    ends = ends || (!kind && saltus_locus_fade(&l->x, &l->here, &l->trial));
    const char *flat = kind || ends ? NULL : saltus_flat_touch(&l->x, &l->here, &l->trial);
    if (kind)
        give_join(l, kind);
    else if (ends)
        give_corner(l, l->here.corners[0], l->trial.at.ahead);
    else if (flat)
        give_as(l, &l->trial,
                (saltus_notice){.kind = SALTUS_POINT_EP,
                                .ahead = l->trial.at.ahead,
                                .accuracy = l->trial.doubt,
                                .reason = flat});
    else if (last)
        give(l, &l->here, SALTUS_POINT_EP, 0, why_it_ends(&l->here.orbit));
}

/* If the step from `here` passes a place where the orbits become those of half the period, or comes so near
 * that the equations say little, end the curve there; or let it go on with a step that is shorter: true. */
static bool meet_halves(saltus_locus *l) {
    double step;
    if (!saltus_locus_halves_ahead(&l->x, &l->here, &l->next, &step))
        return false;
    const saltus_point_kind kind = saltus_locus_join_halves(&l->x, &l->here, &l->trial);
    /* Beyond that place there are no orbits of twice the period. */
    const bool shorter =
        !kind && step > stride_short &&
        (l->x.kind == SALTUS_POINT_NS || saltus_locus_apart(&l->x, &l->here.orbit, NULL) > saltus_alike);
    if (kind)
        give_join(l, kind);
    else if (shorter)
        l->trail->step = step;
    else if (step != 0)
        give_end(l, true);
    return shorter;
}

static bool onward_at(void *context, double ahead, double *value) {
    saltus_locus *l = context;
    const saltus_status status = saltus_curve_visit(&l->x.equations, &l->here.at, ahead, &l->trial.at, NULL);
    const bool found =
        saltus_orbits_noted(&l->x.orbits, status) == SALTUS_OK && saltus_locus_see_orbit(&l->x, &l->trial);
    *value = l->trial.orbit.onward;
    return found;
}

/* Whether cycles that fold shrink to an equilibrium on the step from `here`, and their curve ends in a
 * generalised Hopf point: beyond, the same cycles come again, half a period later. There the flow's speed is
 * nothing and the equations are singular; but the curve goes through. */
static void meet_rest(saltus_locus *l) {
    enum { passes = 4 };
    const double before = l->here.orbit.onward, after = l->next.orbit.onward, sharp = 1e-7;
    const size_t m = (size_t)l->here.at.unknowns;
    if (l->x.kind != SALTUS_POINT_LP || !(l->here.orbit.sequence.omega > 0) || !(before * after < 0))
        return;
    double *work = l->x.points, *best = l->x.kept, least = sharp;
    double apart = 0.02, middle = l->next.at.ahead * before / (before - after);
    const double usual = l->x.equations.tolerance;
    l->x.equations.tolerance = 1e-11;
    for (int k = 0; k < passes; k++, apart *= 0.5) {
        double place, spread;
        if (!saltus_curve_cross(onward_at, l, &l->here.at, &l->trial.at, middle, apart, work, &place,
                                &spread) ||
            spread >= least)
            continue;
        middle = place;
        least = spread;
        memcpy(best, work, m * sizeof *best);
    }
    l->x.equations.tolerance = usual;
    if (least < sharp) {
        memcpy(l->trial.at.u, best, m * sizeof *best);
        l->trial.at.ahead = middle;
        l->trial.doubt = least;
        if (saltus_locus_survey_orbit(&l->x, &l->trial))
            give_join(l, SALTUS_POINT_GH);
    }
}

/* How many times the usual residual a step from `here` may leave: more than once where steps have become
 * short as Newton's method comes down to rounding, which is as large as the tolerance. */
static double looseness(const saltus_locus *l) {
    const double rounds = 0.1, loose = 30, brief = 1e-4;
    return l->trail->step < brief && l->here.at.residual > rounds * l->x.equations.tolerance ? loose : 1;
}

/* A step onto a sound orbit, halved until there is one, and with the corners on it. *reached as
 * saltus_curve_step has it. The curve may end instead. */
static void take_step(saltus_locus *l, int *reached, saltus_locus_zeros *crossed) {
    const int c = l->x.orbits.equations->count;
    const saltus_curve_bound bounds[2] = {{c, l->border[0][0], l->border[0][1]},
                                          {c + 1, l->border[1][0], l->border[1][1]}};
    const double usual = l->x.equations.tolerance, loose = looseness(l);
    double least = l->trail->step > stride_short ? stride_short : stride_min;
    l->x.equations.tolerance = loose * usual;
    if (saltus_halved_resonates(&l->x, &l->here, &l->trial))
        give_join(l, SALTUS_POINT_GR_GR);
    for (bool located = false; !located && l->trail->following;) {
        bool found = false;
        for (; !found && l->trail->step > least; l->trail->step *= found ? 1 : 0.5) {
            const saltus_status status = saltus_curve_step(&l->x.equations, &l->here.at, &l->trail->step,
                                                           bounds, 2, &l->next.at, reached, NULL);
            found = saltus_orbits_noted(&l->x.orbits, status) == SALTUS_OK &&
                    saltus_locus_survey(&l->x, &l->next) && is_near(l, &l->next) &&
                    !saltus_curve_strays(&l->here.at, &l->next.at) &&
                    l->next.at.residual <= loose * saltus_locus_sharpness(&l->x, &l->next, usual) &&
                    !saltus_extended_strays(&l->x) && saltus_locus_is_sound(&l->x, &l->here, &l->next);
        }
        if (!found) {
            give_end(l, least == stride_min);
            least = stride_min;
            continue;
        }
        saltus_extended_renew(&l->x, l->next.at.u);
        meet_rest(l);
        if (!l->trail->following || meet_halves(l) || !l->trail->following)
            continue;
        l->x.sharp = true;
        located = saltus_locus_find_corners(&l->x, &l->here, &l->next, &l->trial, crossed);
        l->x.sharp = false;
        if (!located)
            l->trail->step = 0.5 * l->next.at.ahead;
    }
}

/* Give out the corner at a zero on the step, if it is one; returns what give_corner() does. */
static bool pass_corner(saltus_locus *l, const struct saltus_locus_zero *zero) {
    const int own = zero->corner;
    const double just_before = 1e-7;
    saltus_solution before = {.value = 0};
    l->x.sharp = true;
    /* At a touch it is chance whether the flow meets the impact: use the survey of an orbit just before. */
    if (l->next.corners[own].breach && l->x.kind != SALTUS_POINT_GR &&
        saltus_locus_visit(&l->x, &l->here, zero->place - just_before, &l->trial) &&
        saltus_locus_survey_orbit(&l->x, &l->trial))
        SALTUS_SWAP(before.survey, l->trial.orbit.survey);
    const bool found = saltus_locus_visit_zero(&l->x, &l->here, zero, &l->trial) &&
                       saltus_locus_survey_orbit(&l->x, &l->trial);
    if (found && l->trial.corners[own].breach && l->x.kind != SALTUS_POINT_GR)
        saltus_locus_sharpen_end(&l->x, &l->here, &l->trial);
    if (before.survey.walked)
        SALTUS_SWAP(before.survey, l->trial.orbit.survey);
    saltus_solution_clear(&before);
    l->x.sharp = false;
    /* Where the orbit closes after half the period, or is its own mirror image, determinants are rounding.
     * Two real multipliers with the product 1 are no pair on the unit circle. And where impacts are slow null
     * vectors may be rounding: then no multiplier is double. */
    const saltus_locus_test corner = l->trial.corners[own];
    const saltus_survey *survey = &l->trial.orbit.survey;
    const bool real = corner.kind == SALTUS_POINT_GR_NS && !corner.breach && !isfinite(corner.theta);
    const bool resonance = corner.kind == SALTUS_POINT_R1 || corner.kind == SALTUS_POINT_R2;
    const bool simple = found && resonance && l->x.kind != SALTUS_POINT_NS && survey->walked &&
                        !saltus_locus_has_pair(&l->x, corner.kind == SALTUS_POINT_R1 ? 0 : M_PI);
    /* So are those of orbits all but equal to shorter ones if they show no slope at their zero. */
    const bool noise = found && l->x.kind == SALTUS_POINT_GR && !corner.breach && isnan(l->trial.doubt) &&
                       saltus_locus_apart(&l->x, &l->trial.orbit, NULL) < saltus_alike;
    const saltus_point_kind joint =
        found && corner.breach ? saltus_locus_join_near(&l->x, &l->trial) : SALTUS_POINT_REGULAR;
    if (joint)
        give_join(l, joint);
    return found && !joint && !real && !simple && !noise &&
           !saltus_locus_joins_at(&l->x, &l->here, &l->trial) && give_corner(l, corner, zero->place);
}

/* One step along the current curve, with the corners on it. */
static void advance(saltus_locus *l) {
    int reached;
    bool moved = false;
    saltus_locus_zeros crossed;
    const double still = 1e-8; /* in the plane of the parameters: only rounding is left */
    take_step(l, &reached, &crossed);
    const double *way = plane_of(l, l->next.at.tangent), *before = plane_of(l, l->here.at.tangent);
    const bool family = hypot(way[0], way[1]) < still && hypot(before[0], before[1]) < still;
    for (int k = 0; l->trail->following && !moved && !family && k < crossed.count; k++)
        moved = pass_corner(l, &crossed.zero[k]);
    if (!l->trail->following || moved)
        return;
    step_on(l);
    const bool closed = is_closed(l);
    way = plane_of(l, l->here.at.tangent);
    l->trail->step =
        saltus_curve_next_step(l->trail->step, l->here.at.iterations,
                               l->trail->options->step_max / fmax(hypot(way[0], way[1]), slowest));
    const bool upper = reached >= 0 && l->here.orbit.parameter[reached] == l->border[reached][1];
    const char *reason = closed         ? is_back
                         : reached >= 0 ? l->trail->ends[reached][upper]
                         : family       ? "the orbits of one value of the parameters form a family"
                                        : NULL;
    give(l, &l->here, reason ? SALTUS_POINT_EP : l->x.kind, 0, reason);
    if (l->trail->following && !saltus_locus_reframe(&l->x, &l->here, &l->next))
        give(l, &l->here, SALTUS_POINT_EP, 0, why_it_ends(&l->here.orbit));
}

saltus_status saltus_locus_step(saltus_locus *l, bool *more, saltus_message *message) {
    saltus_branch_start *next;
    saltus_status status = SALTUS_OK;
    *more = true;
    if (l->trail->following) {
        const double usual = l->x.equations.tolerance;
        l->x.equations.tolerance = saltus_locus_sharpness(&l->x, &l->here, usual);
        advance(l);
        l->x.equations.tolerance = usual;
    } else if (l->way < l->way_count)
        status = begin(l, begins_crossing(l) && !l->x.mirrored, message);
    else if ((*more = (next = saltus_locus_starts_next(l->starts, false))))
        status = switch_to(l, next, message);
    return l->x.orbits.starved ? saltus_branch_no_memory(message) : status;
}

/* The orbit at `here`, and the extended equations' borders and derivative there. */
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
    size_t count = (size_t)x->orbits.equations->count,
           size = x->kind == SALTUS_POINT_GR ? 0 : (size_t)x->copies * count;
    saltus_archive_finite(a, x->b, size);
    saltus_archive_finite(a, x->c, size);
    saltus_archive_finite(a, x->anchor, count + 2);
    x->differs = saltus_archive_flag(a, x->differs);
    if (x->differs)
        saltus_archive_finite(a, x->along, size * (count + 2));
    saltus_archive_point(a, &l->here.at);
    saltus_archive_solution(a, &x->orbits, &l->here.orbit);
    const bool marked = x->kind != SALTUS_POINT_GR || x->mark < l->here.orbit.sequence.count;
    a->sound = a->sound && (!a->reading || (marked && l->here.at.unknowns == x->equations.unknowns));
    return SALTUS_OK;
}

/* The functions whose zeros are corners, as far as the next step compares with them. */
static void archive_corners(saltus_locus *l, saltus_archive *a) {
    l->here.corner_count = (int)saltus_archive_whole(a, l->here.corner_count, 0, SALTUS_CORNERS_MAX);
    for (int k = 0; k < l->here.corner_count; k++) {
        saltus_locus_test *test = &l->here.corners[k];
        test->kind = saltus_archive_kind(a, test->kind, ~0u);
        saltus_archive_scaled(a, &test->value);
        saltus_archive_real(a, &test->quiet);
        test->breach = saltus_archive_flag(a, test->breach);
        test->ends = saltus_archive_flag(a, test->ends);
        test->without = saltus_archive_flag(a, test->without);
        test->joins = saltus_archive_flag(a, test->joins);
        saltus_archive_real(a, &test->theta);
        for (int j = 0; j < 2; j++) {
            saltus_close *close = j ? &test->product : &test->single;
            close->count = (int)saltus_archive_whole(a, close->count, 0, SALTUS_CLOSE_MAX);
            saltus_archive_finite(a, close->re, (size_t)close->count);
            saltus_archive_finite(a, close->im, (size_t)close->count);
        }
        saltus_archive_scaled(a, &l->here.before[k]);
    }
    saltus_archive_finite(a, &l->here.before_place, 1);
    saltus_archive_finite(a, l->grazings.last, 2);
    saltus_archive_finite(a, &l->grazings.gap, 1);
    l->grazings.closer = (int)saltus_archive_whole(a, l->grazings.closer, 0, INT_MAX);
}

saltus_status saltus_locus_archive(saltus_locus *l, saltus_archive *a, saltus_message *message) {
    saltus_archive_orbits(a, &l->x.orbits);
    /* The start of the current curve, and how many directions from there are begun. */
    const saltus_point_kind kind = saltus_archive_kind(a, l->x.kind, saltus_orbit_loci);
    const bool mirrored = saltus_archive_flag(a, l->x.mirrored);
    if (a->reading)
        become(l, kind, mirrored);
    l->begun_at = saltus_archive_kind(a, l->begun_at, ~0u);
    l->way_count = (int)saltus_archive_whole(a, l->way_count, 1, 2);
    l->way = (int)saltus_archive_whole(a, l->way, 1, l->way_count);
    /* Its first point: sequence, unknowns, and the direction in which the curve left. */
    saltus_archive_sequence(a, &l->first);
    l->first_mark = (int)saltus_archive_whole(a, l->first_mark, 0, SALTUS_MARKS_MAX - 1);
    a->sound = a->sound && (kind != SALTUS_POINT_GR || l->first_mark < l->first.count);
    const int unknowns = saltus_sequence_unknowns(&l->first, a->n) + 2 + l->x.extra;
    if (a->reading && a->sound)
        a->starved = !saltus_curve_reserve(&l->beginning, unknowns);
    a->sound = a->sound && !a->starved;
    if (a->sound)
        saltus_archive_finite(a, l->beginning.u, (size_t)unknowns);
    saltus_archive_finite(a, l->first_way, 2);
    l->has_left = saltus_archive_flag(a, l->has_left);
    archive_corners(l, a);
    /* Only the first point matters once the curve has ended. */
    return l->trail->following ? archive_here(l, a, message) : SALTUS_OK;
}
