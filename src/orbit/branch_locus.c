/* Curves of folds, flips, Neimark-Sacker, branch and grazing points in the plane of two parameters.
 *
 * Across the curve at its predicted next point goes a line; the orbits with parameters on that line form a
 * branch of one parameter, and the special point is a zero of the same test function on it that finds special
 * points along ordinary branches. So a locus needs no derivative of the test functions, and what is found
 * lies on the curve to rounding. The zero is found by the secant rule along the inner branch's tangent.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/branch_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { secants_max = 14 };

static const double stride_min = 1e-5, turn_min = 0.9, crossing_aside = 3e-3;

saltus_status saltus_locus_open(saltus_branch *b, saltus_message *message) {
    saltus_locus *l = &b->locus;
    const saltus_branch_options *o = &b->options;
    bool known = o->locus == SALTUS_POINT_LP || o->locus == SALTUS_POINT_PD || o->locus == SALTUS_POINT_NS ||
                 o->locus == SALTUS_POINT_BP || o->locus == SALTUS_POINT_GR;
    if (!known)
        return saltus_fail(message, SALTUS_BAD_INPUT, "locus %s: must be LP, PD, NS, BP or GR",
                           saltus_point_word(o->locus));
    l->spec = b->spec;
    l->direction[0] = b->direction;
    l->origin[0] = b->origin;
    l->unit[0] = b->unit;
    l->unit[1] = o->high[1] - o->low[1];
    saltus_status status =
        saltus_spec_direction(&b->spec, o->key[1], &l->direction[1], &l->origin[1], message);
    if (status != SALTUS_OK)
        return status;
    if (memcmp(&l->direction[0], &l->direction[1], sizeof l->direction[0]) == 0)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%s and %s: a curve needs two parameters, not one twice", o->key[0], o->key[1]);
    if (!(l->unit[1] > 0))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s=%g:%g: the range must go from low to high",
                           o->key[1], o->low[1], o->high[1]);
    if (!isfinite(l->unit[1]))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s=%g:%g: the range must be finite", o->key[1],
                           o->low[1], o->high[1]);
    if (!(l->origin[1] >= o->low[1] && l->origin[1] <= o->high[1]))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s=%g:%g: the range must hold the start, %s = %.12g",
                           o->key[1], o->low[1], o->high[1], o->key[1], l->origin[1]);
    return status;
}

void saltus_locus_close(saltus_branch *b) {
    free(b->locus.before);
    free(b->locus.inner);
    b->locus.before = b->locus.inner = NULL;
}

static void add_direction(saltus_direction *sum, const saltus_direction *d, double factor) {
    for (int k = 0; k < SALTUS_PARAMETERS_MAX; k++)
        sum->parameter[k] += factor * d->parameter[k];
    for (int s = 0; s < SALTUS_STOPS_MAX; s++) {
        sum->d[s] += factor * d->d[s];
        sum->r[s] += factor * d->r[s];
        sum->xi[s] += factor * d->xi[s];
    }
}

/* Point the inner branch along `normal` through a point of the plane. */
static saltus_status point_inner(saltus_branch *b, const double *plane, saltus_message *message) {
    saltus_locus *l = &b->locus;
    b->spec = saltus_spec_shifted(&l->spec, &l->direction[0],
                                  plane[0] * l->unit[0] - (l->origin[0] - b->options.low[0]));
    b->spec = saltus_spec_shifted(&b->spec, &l->direction[1],
                                  plane[1] * l->unit[1] - (l->origin[1] - b->options.low[1]));
    memset(&b->direction, 0, sizeof b->direction);
    for (int k = 0; k < 2; k++)
        add_direction(&b->direction, &l->direction[k], l->normal[k] * l->unit[k]);
    b->origin = 0;
    b->unit = 1;
    return saltus_shooting_redirect(b->shooting, &b->spec, &b->direction, 0, 1, message);
}

static saltus_test test_of(saltus_point_kind kind) {
    return kind == SALTUS_POINT_LP   ? SALTUS_TEST_FOLD
           : kind == SALTUS_POINT_PD ? SALTUS_TEST_FLIP
           : kind == SALTUS_POINT_NS ? SALTUS_TEST_PAIR
                                     : SALTUS_TEST_BRANCH;
}

/* The test function of the locus at a solution that the shooting has just evaluated; NaN where there is none.
 */
static double locus_test(saltus_branch *b, saltus_solution *s) {
    saltus_message ignored;
    int count;
    const saltus_breach *breaches = saltus_shooting_breaches(b->shooting, &count);
    if (b->options.locus == SALTUS_POINT_GR) {
        for (int k = 0; k < count; k++)
            if (breaches[k].kind == SALTUS_BREACH_SPEED && breaches[k].mark == b->locus.mark)
                return breaches[k].value;
        return NAN;
    }
    if (b->options.locus == SALTUS_POINT_NS && saltus_branch_survey(b, s, &ignored) != SALTUS_OK)
        return NAN;
    return s->test[test_of(b->options.locus)];
}

/* The worst breach but for the grazing impact itself. */
static double other_breach(const saltus_branch *b, const saltus_solution *s) {
    saltus_sequence sequence;
    int count;
    double worst = -1;
    const saltus_breach *breaches = saltus_shooting_breaches(b->shooting, &count);
    if (b->options.locus != SALTUS_POINT_GR)
        return s->test[SALTUS_TEST_BREACH];
    saltus_shooting_extract(b->shooting, s->u, &sequence, b->state);
    const saltus_mark *own = &sequence.mark[b->locus.mark];
    for (int k = 0; k < count; k++) {
        bool touch = breaches[k].face == own->face && fabs(breaches[k].time - own->time) < 1e-4;
        if (!touch && breaches[k].mark != b->locus.mark)
            worst = fmax(worst, breaches[k].value);
        if (!touch && breaches[k].mark == b->locus.mark && breaches[k].kind != SALTUS_BREACH_SPEED)
            worst = fmax(worst, breaches[k].value);
    }
    return worst;
}

static bool keep_vector(double **place, const double *values, int count) {
    double *grown = realloc(*place, (size_t)count * sizeof *grown);
    if (!grown)
        return false;
    *place = grown;
    memcpy(grown, values, (size_t)count * sizeof *values);
    return true;
}

/* `here` is the point of the locus at locus.plane; give it out. */
static saltus_status give_point(saltus_branch *b, saltus_point_kind kind, const char *reason,
                                saltus_message *message) {
    saltus_locus *l = &b->locus;
    saltus_status status = saltus_branch_emit(b, &b->here, kind, NAN, NULL, reason, message);
    if (status != SALTUS_OK)
        return status;
    saltus_branch_point *point = &b->queue[b->queue_count - 1];
    for (int k = 0; k < 2; k++)
        point->value[k] = fma(l->plane[k], l->unit[k], b->options.low[k]);
    point->heading = l->tangent[0] * l->unit[0];
    if (b->options.locus == SALTUS_POINT_GR)
        point->admissible = other_breach(b, &b->here) < 1e-9;
    b->points++;
    if (kind == SALTUS_POINT_EP)
        b->running = false;
    return status;
}

saltus_status saltus_locus_begin(saltus_branch *b, const saltus_branch_start *start,
                                 saltus_message *message) {
    saltus_locus *l = &b->locus;
    b->number = l->made++;
    b->parent = -1;
    b->points = 0;
    b->arclength = 0;
    b->running = true;
    b->last_label[0] = 0;
    b->step = 0.1 * b->options.step;
    l->mark = start->mark;
    l->plane[0] = (start->value - b->options.low[0]) / l->unit[0];
    l->plane[1] = (l->origin[1] - b->options.low[1]) / l->unit[1];
    memcpy(l->first, l->plane, sizeof l->plane);
    l->tangent[0] = 0;
    l->tangent[1] = start->heading;
    l->normal[0] = 1;
    l->normal[1] = 0;
    l->edge = false;
    saltus_locus_close(b);
    saltus_status status = point_inner(b, l->plane, message);
    if (status == SALTUS_OK)
        status = saltus_branch_place(b, &start->sequence, 0, start->state, false, message);
    if (status != SALTUS_OK)
        return status;
    b->here.iterations = 0;
    b->here.residual = saltus_shooting_residual(b->shooting);
    if (!keep_vector(&l->inner, start->tangent, start->unknowns))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a locus");
    status = saltus_branch_survey(b, &b->here, message);
    return status == SALTUS_OK ? give_point(b, b->options.locus, NULL, message) : status;
}

/* The next point's place and the line through it. A step over the border of the range ends on the border. */
static void predict(saltus_branch *b, double *plane) {
    saltus_locus *l = &b->locus;
    double across[2] = {l->tangent[1], -l->tangent[0]};
    double share = 1;
    int border = -1;
    for (int k = 0; k < 2; k++) {
        plane[k] = l->plane[k] + b->step * l->tangent[k];
        double over = plane[k] < 0 ? plane[k] : plane[k] > 1 ? plane[k] - 1 : 0;
        if (over != 0 && 1 - over / (b->step * l->tangent[k]) < share) {
            share = 1 - over / (b->step * l->tangent[k]);
            border = k;
        }
    }
    l->edge = border >= 0;
    if (l->edge) {
        for (int k = 0; k < 2; k++)
            plane[k] = l->plane[k] + share * b->step * l->tangent[k];
        plane[border] = l->tangent[border] > 0;
        across[border] = 0;
        across[1 - border] = 1;
    }
    double sense = across[0] * l->normal[0] + across[1] * l->normal[1];
    for (int k = 0; k < 2; k++)
        l->normal[k] = sense < 0 ? -across[k] : across[k];
}

/* Secants along the inner branch from `here`; the zero becomes `trial`. */
static bool find_zero(saltus_branch *b) {
    saltus_message ignored;
    double s0 = 0, s1 = 0.01 * b->step, near = locus_test(b, &b->here), far;
    /* Which way the curve goes is not known at first. */
    double reach = b->points < 2 ? 50 : 2;
    int m = b->here.unknowns;
    for (int k = 0; k < secants_max; k++) {
        if (saltus_branch_visit(b, s1, &b->trial, &ignored) != SALTUS_OK)
            return false;
        far = locus_test(b, &b->trial);
        if (!isfinite(far) || !isfinite(near))
            return false;
        double next = far == near ? s1 : s1 - far * (s1 - s0) / (far - near);
        bool arrived = far == 0 || fabs(next - s1) < 1e-12 * fmax(1, fabs(s1));
        if (arrived && k > 0)
            return fabs(b->trial.u[m - 1]) < reach * b->step + 1e-6;
        if (fabs(next) > 10 * reach * b->step + 1e-3)
            return false;
        s0 = s1;
        near = far;
        s1 = next;
    }
    return false;
}

/* The same where branches cross: its equations are singular, so the place is first estimated from two points,
 * then interpolated. */
static bool find_crossing(saltus_branch *b) {
    const double ahead = -2 * crossing_aside;
    double near = b->here.test[SALTUS_TEST_BRANCH], accuracy;
    saltus_message ignored;
    if (saltus_branch_visit(b, ahead, &b->trial, &ignored) != SALTUS_OK)
        return false;
    double far = b->trial.test[SALTUS_TEST_BRANCH], place = ahead - far * ahead / (far - near);
    b->next.ahead = crossing_aside;
    return isfinite(place) && fabs(place) < 20 * b->step + 10 * crossing_aside &&
           saltus_branch_crossing(b, place, &accuracy);
}

/* From the prediction onto the inner branch, then to its special point. */
static bool correct(saltus_branch *b, const double *plane, const double *last, double last_stride) {
    saltus_locus *l = &b->locus;
    saltus_message ignored;
    int m = b->here.unknowns, iterations;
    double factor = l->before ? b->step / last_stride : 0;
    if (saltus_branch_noted(b, point_inner(b, plane, &ignored)) != SALTUS_OK)
        return false;
    for (int j = 0; j + 1 < m; j++)
        b->here.u[j] = last[j] + (l->before ? factor * (last[j] - l->before[j]) : 0);
    b->here.u[m - 1] = 0;
    bool room = saltus_solution_room(&b->next, m, b->n);
    b->starved |= !room;
    if (!room)
        return false;
    /* Where branches cross, begin a little aside, where the equations are regular. */
    for (int j = 0; j < m && b->options.locus == SALTUS_POINT_BP; j++)
        b->here.u[j] += crossing_aside * l->inner[j];
    memcpy(b->next.u, b->here.u, (size_t)m * sizeof *b->here.u);
    memcpy(b->here.tangent, l->inner, (size_t)m * sizeof *l->inner);
    b->reference[0] = b->reference[1] = NAN;
    saltus_status status =
        saltus_shooting_correct(b->shooting, b->here.u, l->inner, b->next.u, false, &iterations, &ignored);
    if (status == SALTUS_OK)
        status = saltus_branch_test(b, &b->here, &ignored);
    return saltus_branch_noted(b, status) == SALTUS_OK &&
           (b->options.locus == SALTUS_POINT_BP ? find_crossing(b) : find_zero(b));
}

/* Whether the point found lies ahead on a smooth curve and is an orbit; its place and the way there. */
static bool is_good(saltus_branch *b, const double *plane, double *place, double *way, double *stride) {
    saltus_locus *l = &b->locus;
    saltus_message ignored;
    double aside = b->trial.u[b->trial.unknowns - 1];
    *stride = 0;
    for (int k = 0; k < 2; k++) {
        place[k] = fma(aside, l->normal[k], plane[k]);
        way[k] = place[k] - l->plane[k];
    }
    *stride = hypot(way[0], way[1]);
    if (!(*stride > 0))
        return false;
    way[0] /= *stride;
    way[1] /= *stride;
    bool first = b->points < 2;
    if (!first && way[0] * l->tangent[0] + way[1] * l->tangent[1] < turn_min)
        return false;
    double breach = other_breach(b, &b->trial);
    if (saltus_branch_survey(b, &b->trial, &ignored) != SALTUS_OK)
        return false;
    if (b->options.locus == SALTUS_POINT_NS && !saltus_branch_pair_on_circle(b, &b->trial))
        return false;
    return b->options.locus == SALTUS_POINT_GR ? breach < 1e-9 : b->trial.follows;
}

/* Whether the curve has come back to its first point, the same way. */
static bool is_closed(saltus_branch *b) {
    saltus_locus *l = &b->locus;
    if (b->points == 1)
        memcpy(l->first_way, l->tangent, sizeof l->tangent);
    double apart = hypot(l->plane[0] - l->first[0], l->plane[1] - l->first[1]);
    double along = l->tangent[0] * l->first_way[0] + l->tangent[1] * l->first_way[1];
    return b->points > 10 && apart < 0.6 * l->stride && along > turn_min;
}

/* When the unknowns have become others the last point but one is of no use. */
static saltus_status reframe(saltus_branch *b, saltus_message *message) {
    saltus_locus *l = &b->locus;
    bool changed;
    saltus_status status = saltus_branch_reframe(b, &l->mark, &changed, message);
    if (status != SALTUS_OK || !changed)
        return status;
    free(l->before);
    l->before = NULL;
    return keep_vector(&l->inner, b->here.tangent, b->here.unknowns)
               ? status
               : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a locus");
}

saltus_status saltus_locus_advance(saltus_branch *b, saltus_message *message) {
    saltus_locus *l = &b->locus;
    int m = b->here.unknowns;
    double plane[2], place[2], way[2], stride = 0, *last = calloc((size_t)m, sizeof *last);
    double old_normal[2] = {l->normal[0], l->normal[1]};
    saltus_status status = last ? SALTUS_OK : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a locus");
    bool good = false;
    if (last)
        memcpy(last, b->here.u, (size_t)m * sizeof *last);
    while (status == SALTUS_OK && !good && b->step > stride_min) {
        memcpy(l->normal, old_normal, sizeof old_normal);
        predict(b, plane);
        good = correct(b, plane, last, l->stride) && is_good(b, plane, place, way, &stride);
        if (!good)
            b->step *= 0.5;
    }
    if (status == SALTUS_OK && !good) {
        memcpy(l->normal, old_normal, sizeof old_normal);
        status = point_inner(b, l->plane, message);
        memcpy(b->here.u, last, (size_t)m * sizeof *last);
        b->here.u[m - 1] = 0;
        if (status == SALTUS_OK)
            status = saltus_shooting_evaluate(b->shooting, b->here.u, message);
        if (status == SALTUS_OK)
            status = saltus_branch_survey(b, &b->here, message);
        free(last);
        return status == SALTUS_OK
                   ? give_point(b, SALTUS_POINT_EP,
                                "the curve ends: its orbit changes its events or the curve has a "
                                "corner",
                                message)
                   : status;
    }
    if (status == SALTUS_OK &&
        !(keep_vector(&l->before, last, m) && keep_vector(&l->inner, b->trial.tangent, m)))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a locus");
    free(last);
    if (status != SALTUS_OK)
        return status;
    saltus_solution_swap(&b->here, &b->trial);
    b->arclength += stride;
    b->here.ahead = 0;
    memcpy(l->plane, place, sizeof place);
    memcpy(l->tangent, way, sizeof way);
    l->stride = stride;
    bool closed = is_closed(b);
    bool ends = l->edge || closed || b->points >= b->options.points;
    status = give_point(b, ends ? SALTUS_POINT_EP : b->options.locus,
                        closed    ? "the curve is closed: it has come back"
                        : l->edge ? "end of the parameters' range"
                        : ends    ? "as many points as asked for"
                                  : NULL,
                        message);
    b->step = fmin(b->step * 1.3, b->options.step_max);
    return status == SALTUS_OK && b->running ? reframe(b, message) : status;
}
