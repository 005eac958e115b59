/* Curves of special equilibria in the plane of two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/born.h"
#include "branch/equilibria.h"
#include "branch/options.h"

#include <complex.h>
#include <math.h>
#include <string.h>

/* Functions along the curves of a kind, whose zeros are points of codimension two. */
static const struct {
    saltus_point_kind kind;
    bool ends; /* the curve ends there */
} tests[SALTUS_POINT_KINDS][SALTUS_REST_TESTS] = {
    [SALTUS_POINT_HB] = {{SALTUS_POINT_BT, true}, {SALTUS_POINT_GH, false}},
    [SALTUS_POINT_LP] = {{SALTUS_POINT_CP, false}, {SALTUS_POINT_BT, false}},
    [SALTUS_POINT_BE] = {{SALTUS_POINT_HB, false}, {SALTUS_POINT_LP, false}},
};

/* The product of all eigenvalues, or of all but one. */
static double product_of(const saltus_rests *r, const saltus_rest *s, int omitted) {
    double complex product = 1;
    for (int j = 0; j < s->rate_count; j++)
        if (j != omitted)
            product *= (s->rates[j].re + I * s->rates[j].im) / r->rate_scale;
    return creal(product);
}

/* The angular frequency of a pair of eigenvalues that is imaginary, but for rounding; 0: none is. */
static double frequency_of_pair(const saltus_rests *r, const saltus_rest *s) {
    const double close = 1e-6;
    double frequency = 0;
    for (int k = 0; k < s->rate_count; k++)
        if (s->rates[k].im > 0 && fabs(s->rates[k].re) < close * r->rate_scale)
            frequency = s->rates[k].im;
    return frequency;
}

/* All that a point's unknowns tell. Errors: SALTUS_NO_MEMORY, those of the evaluation. */
static saltus_status look(saltus_rest_locus *l, saltus_rest *s, saltus_message *message) {
    saltus_rests *r = &l->rests;
    const saltus_equations *e = &r->equations;
    const saltus_rest_special *special = &r->special;
    saltus_hopf hopf;
    double square;
    s->tests[0] = s->tests[1] = NAN;
    saltus_status status = saltus_equations_evaluate(&r->equations, s->at.u, message);
    if (status == SALTUS_OK)
        status = saltus_rest_see(r, s, message);
    if (status == SALTUS_OK && special->kind == SALTUS_POINT_LP) {
        const double *row = e->jacobian + (ptrdiff_t)(e->count - 1) * e->unknowns;
        s->tests[0] = saltus_dot(row, special->right, r->size);
        /* The sum over the eigenvalues of the product of all others: zero where two eigenvalues are zero. */
        s->tests[1] = 0;
        for (int k = 0; k < s->rate_count; k++)
            s->tests[1] += product_of(r, s, k);
    }
    if (status == SALTUS_OK && special->kind == SALTUS_POINT_BE) {
        const int pairs = s->rate_count * (s->rate_count - 1) / 2;
        s->tests[0] = saltus_scaled_in(s->pairs, pairs * log(r->rate_scale));
        s->tests[1] = product_of(r, s, -1);
    }
    if (status == SALTUS_OK && special->kind == SALTUS_POINT_HB) {
        saltus_rests_pair(r, s->at.u, special->square, &square);
        s->tests[0] = square / (r->rate_scale * r->rate_scale);
        if (square > 0 && saltus_hopf_find(r, s, &hopf))
            s->tests[1] = hopf.coefficient;
    }
    return status;
}

/* Renew what identifies the special point in the equations. If the left null vector is reversed, so is the
 * sign of the test for cusps. */
static saltus_status renew(saltus_rest_locus *l, const double *u, saltus_message *message) {
    saltus_rests *r = &l->rests;
    saltus_rest_special *special = &l->rests.special;
    double square, before[SALTUS_REST_UNKNOWNS_MAX];
    if (special->kind == SALTUS_POINT_HB && isfinite(saltus_rests_pair(r, u, special->square, &square)))
        special->square = square;
    if (special->kind != SALTUS_POINT_LP)
        return SALTUS_OK;
    memcpy(before, special->left, sizeof before);
    saltus_status status = saltus_rests_null_vectors(r, u, special->right, special->left, message);
    if (saltus_dot(before, special->left, r->size) < 0)
        l->here.tests[0] = -l->here.tests[0];
    return status;
}

/* `here` becomes the first point of the curve through a start, with the second parameter as it is or, if that
 * stays so along the curve, with the first. */
static saltus_status open_curve(saltus_rest_locus *l, const saltus_branch_start *start,
                                saltus_message *message) {
    const double little = 1e-6; /* relative to rate_scale; identifies the two eigenvalues at BT */
    saltus_rests *r = &l->rests;
    saltus_curve_point *at = &l->here.at;
    double anchor[SALTUS_REST_UNKNOWNS_MAX];
    const double omega =
        start->origin == SALTUS_POINT_BT ? sqrt(little) * r->rate_scale : start->sequence.omega;
    l->rests.special.kind = start->kind;
    l->rests.special.face = start->kind == SALTUS_POINT_BE ? start->mark : -1;
    l->rests.special.square = omega * omega;
    l->trail->parent = start->parent;
    l->trail->depth = start->depth;
    saltus_status status =
        saltus_rests_begin(r, start->sequence.contacts, start->state, start->parameter, at, message);
    const int m = r->equations.unknowns;
    const size_t bytes = (size_t)m * sizeof *at->u;
    if (status == SALTUS_OK)
        status = renew(l, at->u, message);
    if (status != SALTUS_OK)
        return status;
    memcpy(anchor, at->u, bytes);
    status = SALTUS_NO_CONVERGENCE;
    for (int k = m - 1; k >= m - 2 && status != SALTUS_OK && status != SALTUS_NO_MEMORY; k--) {
        double normal[SALTUS_REST_UNKNOWNS_MAX] = {0};
        normal[k] = 1;
        memcpy(at->u, anchor, bytes);
        status = saltus_newton(&r->equations, at->u, normal, anchor, true, &at->iterations, message);
    }
    if (status == SALTUS_OK)
        status = renew(l, at->u, message);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(&r->equations, at->u, message);
    if (status == SALTUS_OK)
        status = saltus_curve_orient(&r->equations, NULL, at, message);
    if (status != SALTUS_OK)
        return status;
    const double across = at->tangent[m - 2], up = at->tangent[m - 1];
    if ((fabs(across) > 1e-6 ? across : up) < 0)
        saltus_curve_turn(at);
    memcpy(l->beginning, at->u, bytes);
    memcpy(l->beginning + m, at->tangent, bytes);
    l->first_square = l->rests.special.square;
    return SALTUS_OK;
}

saltus_status saltus_rest_locus_open(saltus_rest_locus *l, const saltus_spec *spec,
                                     const saltus_branch_start *first, saltus_message *message) {
    const saltus_branch_options *options = l->trail->options;
    saltus_rests *r = &l->rests;
    l->way_count = options->direction ? 1 : 2;
    l->first_way = options->direction < 0 ? -1 : 1;
    l->way = first ? 0 : l->way_count;
    saltus_status status = saltus_branch_family(spec, options, 2, &r->family, r->origin, l->border, message);
    if (status == SALTUS_OK)
        status = saltus_rests_open(r, message);
    if (status != SALTUS_OK || !first)
        return status;
    l->trail->number = -1;
    return open_curve(l, first, message);
}

void saltus_rest_locus_close(saltus_rest_locus *l) {
    saltus_rest_clear(&l->here);
    saltus_rest_clear(&l->next);
    saltus_rest_clear(&l->trial);
    saltus_rests_close(&l->rests);
    *l = (saltus_rest_locus){.trail = l->trail, .starts = l->starts};
}

static void give(saltus_rest_locus *l, const saltus_rest *at, saltus_point_kind kind, double ahead,
                 const char *reason) {
    const saltus_notice what = {.kind = kind, .ahead = ahead, .accuracy = NAN, .reason = reason};
    const double square = at->tests[0];
    if (!saltus_rest_give(&l->rests, at, what, l->trail) || l->rests.special.kind != SALTUS_POINT_HB)
        return;
    saltus_branch_point *point = saltus_trail_last(l->trail);
    point->lyapunov_coefficient = at->tests[1];
    point->period = square > 0 ? 2 * M_PI / (sqrt(square) * l->rests.rate_scale) : NAN;
}

/* Begin the next direction from the first point. */
static saltus_status begin(saltus_rest_locus *l, saltus_message *message) {
    saltus_curve_point *at = &l->here.at;
    const size_t bytes = (size_t)at->unknowns * sizeof *at->u;
    saltus_trail_begin(l->trail, l->trail->number + 1, l->trail->parent, l->trail->depth, false);
    memcpy(at->u, l->beginning, bytes);
    memcpy(at->tangent, l->beginning + at->unknowns, bytes);
    at->bent = false;
    at->ahead = 0;
    l->rests.special.square = l->first_square;
    if (l->way++ > 0 || l->first_way < 0)
        saltus_curve_turn(at);
    saltus_status status = renew(l, at->u, message);
    if (status == SALTUS_OK)
        status = look(l, &l->here, message);
    /* At the BT point itself their signs mean nothing. */
    for (int k = 0; k < SALTUS_REST_TESTS && l->switched; k++)
        l->here.tests[k] = NAN;
    at->residual = l->rests.equations.size;
    if (status == SALTUS_OK)
        give(l, &l->here, l->rests.special.kind, 0, NULL);
    for (int d = 0; d < 2 && status == SALTUS_OK && l->trail->following; d++) {
        const double along = at->tangent[at->unknowns - 2 + d], aside = 1e-6, near = 1e-12;
        if (fabs(along) > aside && fabs(l->here.parameter[d] - l->border[d][along > 0]) < near)
            give(l, &l->here, SALTUS_POINT_EP, 0, l->trail->ends[d][along > 0]);
    }
    return status;
}

/* Where two eigenvalues are zero, the curve of folds passes through, and that of Hopf points ends. Where the
 * first Lyapunov coefficient is zero the latter goes through, and cycles that fold grow from the equilibrium.
 * Where one of both curves meets a face (otherwise -1) it ends, and that of equilibria at the face passes
 * through. */
static void meet(saltus_rest_locus *l, saltus_point_kind kind, const saltus_rest *at, int face) {
    const saltus_trail *trail = l->trail;
    const saltus_point_kind own = l->rests.special.kind;
    const bool grows = kind == SALTUS_POINT_GH;
    saltus_hopf hopf = {.omega = frequency_of_pair(&l->rests, at)};
    if (trail->options->switches == 0 || (grows && !saltus_hopf_find(&l->rests, at, &hopf)))
        return;
    saltus_branch_start start = {
        .kind = own,
        .sequence = {.periods = 1, .contacts = at->contacts, .cuts = 1, .omega = hopf.omega},
        .parameter = {at->parameter[0], at->parameter[1]},
        .state = at->state,
        .states = l->rests.n,
        .mark = face < 0 ? 0 : face,
        .one_way = grows,
        .origin = face < 0 ? kind : SALTUS_POINT_BE,
        .parent = trail->number,
        .depth = trail->depth + 1,
        .done = true};
    saltus_locus_starts_add(l->starts, &start, NAN, &l->rests.starved);
    if (trail->depth >= trail->options->switches)
        return;
    start.kind = face >= 0 ? kind : own == SALTUS_POINT_HB ? SALTUS_POINT_LP : SALTUS_POINT_HB;
    start.done = false;
    if (start.kind == SALTUS_POINT_BE)
        start.sequence.contacts &= ~(1u << face);
    if (grows)
        saltus_hopf_direction(&l->rests, &hopf, start.sequence.anchor);
    saltus_locus_starts_add(l->starts, &start, NAN, &l->rests.starved);
}

/* Begin a curve that was met: of Hopf points from where two eigenvalues are zero on the way on which these
 * are a pair; of Hopf points or folds from a face on the way on which the gap opens. */
static saltus_status switch_to(saltus_rest_locus *l, saltus_branch_start *start, saltus_message *message) {
    const double apart = 1e-3;
    const int face = start->mark;
    saltus_rest *aside = &l->trial;
    saltus_message why = {.text = ""};
    double square;
    start->done = l->switched = true;
    saltus_status status = open_curve(l, start, &why);
    if (status != SALTUS_OK)
        return saltus_fail(message, status, "no curve of %s points can be begun at a %s: %.200s",
                           saltus_point_word(start->kind), saltus_point_word(start->origin), why.text);
    const bool leaves = start->origin == SALTUS_POINT_BE && start->kind != SALTUS_POINT_BE,
               splits = start->origin == SALTUS_POINT_BT && start->kind == SALTUS_POINT_HB,
               sound = (leaves || splits) &&
                       saltus_rest_visit(&l->rests, &l->here, apart, aside, &why) == SALTUS_OK;
    const bool forth =
        leaves ? sound && aside->breach[face] < 0
               : !splits ||
                     (sound &&
                      isfinite(saltus_rests_pair(&l->rests, aside->at.u, l->rests.special.square, &square)) &&
                      square > 0);
    l->way = 0;
    l->way_count = leaves || splits ? 1 : 2;
    l->first_way = forth ? 1 : -1;
    return begin(l, message);
}

/* A test whose zero is sought, or with a face (otherwise -1) how far that is crossed or its contact pulls. */
typedef struct sought {
    saltus_rest_locus *locus;
    int test, face;
} sought;

static bool value_ahead(void *context, double ahead, double *value) {
    const sought *s = context;
    saltus_rest_locus *l = s->locus;
    saltus_rest *at = &l->trial;
    saltus_status status = saltus_curve_visit(&l->rests.equations, &l->here.at, ahead, &at->at, NULL);
    if (status == SALTUS_OK)
        status = look(l, at, NULL);
    if (saltus_rests_noted(&l->rests, status) != SALTUS_OK)
        return false;
    *value = s->face >= 0 ? at->breach[s->face] : at->tests[s->test];
    return isfinite(*value);
}

/* How far ahead of `here`, before `next`, the equilibrium first crosses a face or a contact pulls, and which
 * face that is; INFINITY: nowhere. */
static double find_leaving(saltus_rest_locus *l, int *face) {
    const double near = 1e-9;
    const saltus_rests *r = &l->rests;
    double first = INFINITY;
    for (int f = 0; f < r->system->face_count; f++) {
        sought s = {l, 0, f};
        const double ends[] = {0, l->next.at.ahead}, values[] = {l->here.breach[f], l->next.breach[f]};
        double ahead, width;
        if (f == r->special.face || !(values[1] > near))
            continue;
        if (!(values[0] < 0) ||
            !saltus_curve_zero(l->rests.solver, value_ahead, &s, ends, values, &ahead, &width))
            ahead = 0;
        *face = ahead < first ? f : *face;
        first = fmin(first, ahead);
    }
    return first;
}

/* Give out the points of codimension two between `here` and what is `last` on the step, in order. */
static void give_corners(saltus_rest_locus *l, double last) {
    saltus_special found[SALTUS_REST_TESTS];
    int count = 0;
    double width, value;
    for (int k = 0; k < SALTUS_REST_TESTS; k++) {
        sought s = {l, k, -1};
        saltus_special own = {.kind = tests[l->rests.special.kind][k].kind};
        const double ends[] = {0, l->next.at.ahead}, values[] = {l->here.tests[k], l->next.tests[k]};
        if (values[0] * values[1] < 0 &&
            saltus_curve_zero(l->rests.solver, value_ahead, &s, ends, values, &own.ahead, &width))
            count = saltus_special_insert(own, found, count);
    }
    for (int i = 0; i < count && found[i].ahead < last && l->trail->following; i++) {
        const saltus_point_kind kind = found[i].kind;
        sought s = {l, kind != tests[l->rests.special.kind][0].kind, -1};
        const int touched = l->rests.special.face;
        const bool touches = touched >= 0;
        if (!value_ahead(&s, found[i].ahead, &value) ||
            (touches && kind == SALTUS_POINT_HB && frequency_of_pair(&l->rests, &l->trial) == 0))
            continue;
        give(l, &l->trial, kind, found[i].ahead,
             !touches                  ? NULL
             : kind == SALTUS_POINT_HB ? "a curve of Hopf points meets the stop"
                                       : "a curve of folds meets the stop");
        if (kind != SALTUS_POINT_CP && l->trail->following)
            meet(l, kind, &l->trial, touched);
        if (tests[l->rests.special.kind][s.test].ends && l->trail->following)
            give(l, &l->trial, SALTUS_POINT_EP, found[i].ahead,
                 "beyond it two real eigenvalues add up to zero: no Hopf points");
    }
}

/* Whether the curve has come back to its first point in the step from `here` to `next`. */
static bool is_closed(const saltus_rest_locus *l) {
    const saltus_curve_point *here = &l->here.at, *next = &l->next.at;
    double before = 0, after = 0, apart = 0;
    for (int j = 0; j < here->unknowns; j++) {
        const double first = l->beginning[j], way = l->beginning[here->unknowns + j];
        before += way * (here->u[j] - first);
        after += way * (next->u[j] - first);
        apart = hypot(apart, next->u[j] - first);
    }
    return l->trail->arclength > 5 * l->trail->options->step_max && before * after <= 0 &&
           apart < 2 * next->ahead;
}

/* One step along the current curve. */
static saltus_status advance(saltus_rest_locus *l, saltus_message *message) {
    saltus_rests *r = &l->rests;
    saltus_trail *trail = l->trail;
    saltus_rest *next = &l->next;
    const saltus_curve_bound bounds[2] = {{r->size, l->border[0][0], l->border[0][1]},
                                          {r->size + 1, l->border[1][0], l->border[1][1]}};
    saltus_message why = {.text = ""};
    int reached, face = 0;
    saltus_status status =
        saltus_curve_step(&r->equations, &l->here.at, &trail->step, bounds, 2, &next->at, &reached, &why);
    if (status == SALTUS_OK)
        status = look(l, next, &why);
    const char *ends = saltus_rests_noted(r, status) == SALTUS_OK ? NULL : why.text;
    double leaves = 0, breach;
    if (!ends) {
        leaves = find_leaving(l, &face);
        give_corners(l, leaves);
        if (!trail->following)
            return SALTUS_OK;
        if (isfinite(leaves))
            ends = r->contacts >> face & 1 ? "a contact force falls to zero" : "the equilibrium meets a stop";
    }
    if (ends) {
        sought s = {l, 0, face};
        const bool there = leaves > 0 && value_ahead(&s, leaves, &breach);
        if (there && r->special.face < 0)
            meet(l, SALTUS_POINT_BE, &l->trial, face);
        give(l, there ? &l->trial : &l->here, SALTUS_POINT_EP, there ? leaves : 0, ends);
        return SALTUS_OK;
    }
    if (is_closed(l)) {
        l->way = l->way_count; /* the other direction leads around the same curve */
        ends = "the curve is closed: it has come back";
    } else if (reached >= 0) {
        const bool upper = next->parameter[reached] == l->border[reached][1];
        next->value[reached] = (upper ? trail->options->high : trail->options->low)[reached];
        ends = trail->ends[reached][upper];
    }
    give(l, next, ends ? SALTUS_POINT_EP : r->special.kind, next->at.ahead, ends);
    if (!trail->following)
        return SALTUS_OK;
    trail->step = saltus_curve_next_step(trail->step, next->at.iterations, trail->options->step_max);
    trail->arclength += next->at.ahead;
    SALTUS_SWAP(l->here, l->next);
    saltus_curve_bend(&l->next.at, &l->here.at);
    return renew(l, l->here.at.u, message);
}

saltus_status saltus_rest_locus_step(saltus_rest_locus *l, bool *more, saltus_message *message) {
    saltus_branch_start *next;
    saltus_status status = SALTUS_OK;
    *more = true;
    if (l->trail->following)
        status = advance(l, message);
    else if (l->way < l->way_count)
        status = begin(l, message);
    else if ((*more = (next = saltus_locus_starts_next(l->starts, true))))
        status = switch_to(l, next, message);
    return status == SALTUS_OK && l->rests.starved ? saltus_branch_no_memory(message) : status;
}

saltus_status saltus_rest_locus_archive(saltus_rest_locus *l, saltus_archive *a, saltus_message *message) {
    const unsigned kinds = 1u << SALTUS_POINT_HB | 1u << SALTUS_POINT_BE | 1u << SALTUS_POINT_LP;
    l->switched = saltus_archive_flag(a, l->switched);
    l->rests.special.kind = saltus_archive_kind(a, l->rests.special.kind, kinds);
    l->rests.special.face = (int)saltus_archive_whole(a, l->rests.special.face, -1, a->faces - 1);
    l->way_count = (int)saltus_archive_whole(a, l->way_count, 1, 2);
    l->first_way = (int)saltus_archive_whole(a, l->first_way, -1, 1);
    l->way = (int)saltus_archive_whole(a, l->way, 0, l->way_count);
    saltus_archive_real(a, &l->rests.special.square);
    saltus_archive_real(a, &l->first_square);
    for (int k = 0; k < SALTUS_REST_TESTS; k++)
        saltus_archive_real(a, &l->here.tests[k]);
    saltus_rest *here = &l->here;
    saltus_status status = saltus_archive_rest(a, &l->rests, here, message);
    if (status == SALTUS_OK && a->sound)
        saltus_archive_finite(a, l->beginning, 2 * (size_t)here->at.unknowns);
    return status == SALTUS_OK && a->reading && a->sound ? renew(l, here->at.u, message) : status;
}
