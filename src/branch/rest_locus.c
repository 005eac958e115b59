/* Curves of special equilibria in the plane of two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/rest_locus.h"

#include "branch/hopf.h"
#include "branch/options.h"
#include "branch/rest_point.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { tests_max = 2 };

/* A function along the curve whose zero is a point of codimension two. */
typedef struct test {
    saltus_point_kind kind;
    bool ends; /* the curve ends there */
    double value;
} test;

/* A point of the curve, and its tests. */
typedef struct spot {
    saltus_rest rest;
    test tests[tests_max];
} spot;

struct saltus_rest_locus {
    saltus_trail *trail;        /* the caller's */
    saltus_locus_starts starts; /* of curves that meet those followed, and of others that its owner knows */
    bool switched;              /* the curve under way begins at such a place */
    saltus_rests rests;
    saltus_rest_special special; /* what makes the equilibria special, renewed from point to point */
    spot here, next, trial;
    double beginning[2 * SALTUS_REST_UNKNOWNS_MAX]; /* unknowns and tangent of the first point */
    double first_square;
    double border[2][2]; /* of both parameter unknowns: low, high */
    int ways[2], way_count, way;
};

/* The sum over the eigenvalues of the product of all others: zero where two eigenvalues are zero. */
static double product_of_others(const saltus_rest *s) {
    double sum = 0;
    for (int k = 0; k < s->rate_count; k++) {
        double re = 1, im = 0;
        for (int j = 0; j < s->rate_count; j++) {
            const double next = re * s->rates[j].re - im * s->rates[j].im;
            im = j == k ? im : re * s->rates[j].im + im * s->rates[j].re;
            re = j == k ? re : next;
        }
        sum += re;
    }
    return sum;
}

/* The tests at a point at which the equations were just evaluated. Errors: SALTUS_NO_MEMORY. */
static saltus_status measure(saltus_rest_locus *l, spot *s, saltus_message *message) {
    saltus_rests *r = &l->rests;
    const saltus_equations *e = &r->equations;
    saltus_message ignored;
    s->tests[0] = s->tests[1] = (test){.value = NAN};
    if (l->special.kind == SALTUS_POINT_HB) {
        saltus_hopf hopf = {.coefficient = NAN};
        double square;
        saltus_rests_pair(r, s->rest.at.u, l->special.square, &square);
        s->tests[0] = (test){SALTUS_POINT_BT, true, square / (r->rate_scale * r->rate_scale)};
        saltus_status status = square > 0 ? saltus_hopf_find(r, &s->rest, &hopf, &ignored) : SALTUS_OK;
        s->tests[1] = (test){SALTUS_POINT_GH, false, status == SALTUS_OK ? hopf.coefficient : NAN};
        return status == SALTUS_NO_MEMORY ? saltus_branch_no_memory(message) : SALTUS_OK;
    }
    if (l->special.kind == SALTUS_POINT_LP) {
        const double *row = e->jacobian + (ptrdiff_t)(e->count - 1) * e->unknowns;
        s->tests[0] = (test){SALTUS_POINT_CP, false, saltus_dot(row, l->special.right, r->size)};
        s->tests[1] = (test){SALTUS_POINT_BT, false, product_of_others(&s->rest)};
    }
    return SALTUS_OK;
}

/* Renew what identifies the special point in the equations. If the left null vector is reversed, so is the
 * sign of the test for cusps. */
static saltus_status renew(saltus_rest_locus *l, const double *u, saltus_message *message) {
    saltus_rests *r = &l->rests;
    saltus_rest_special *special = &l->special;
    double square, before[SALTUS_REST_UNKNOWNS_MAX];
    if (special->kind == SALTUS_POINT_HB && isfinite(saltus_rests_pair(r, u, special->square, &square)))
        special->square = square;
    if (special->kind != SALTUS_POINT_LP)
        return SALTUS_OK;
    memcpy(before, special->left, sizeof before);
    saltus_status status = saltus_rests_null_vectors(r, u, special->right, special->left, message);
    if (saltus_dot(before, special->left, r->size) < 0)
        l->here.tests[0].value = -l->here.tests[0].value;
    return status;
}

/* `here` becomes the first point, from a guess, with the second parameter as it is or, if it stays so along
 * the curve, with the first. */
static saltus_status open_first(saltus_rest_locus *l, unsigned contacts, const double *state,
                                const double parameters[2], saltus_message *message) {
    saltus_rests *r = &l->rests;
    saltus_curve_point *at = &l->here.rest.at;
    double anchor[SALTUS_REST_UNKNOWNS_MAX];
    saltus_status status = saltus_rests_shape(r, contacts, state, parameters, message);
    const int m = r->equations.unknowns;
    const size_t bytes = (size_t)m * sizeof *at->u;
    if (status == SALTUS_OK && !saltus_curve_reserve(at, m))
        status = saltus_branch_no_memory(message);
    if (status == SALTUS_OK)
        status = saltus_rests_fill(r, parameters, state, at->u, message);
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
    l->first_square = l->special.square;
    return SALTUS_OK;
}

saltus_status saltus_rest_locus_new(const saltus_spec *spec, saltus_trail *trail,
                                    const saltus_rest_start *place, saltus_rest_locus **locus,
                                    saltus_message *message) {
    const saltus_branch_options *options = trail->options;
    saltus_rest_locus *l = calloc(1, sizeof *l);
    *locus = l;
    if (!l)
        return saltus_branch_no_memory(message);
    saltus_rests *r = &l->rests;
    l->trail = trail;
    r->special = &l->special;
    l->special.kind = options->locus;
    l->special.face = place ? place->face : 0;
    l->special.square = place ? place->square : 0;
    saltus_status status = saltus_branch_family(spec, options, 2, &r->family, r->origin, l->border, message);
    l->way_count = options->direction ? 1 : 2;
    l->ways[0] = options->direction < 0 ? -1 : 1;
    l->ways[1] = -1;
    if (status == SALTUS_OK)
        status = saltus_rests_open(r, message);
    if (status == SALTUS_OK && place) {
        trail->number = trail->parent = -1;
        trail->depth = 0;
        status = open_first(l, place->contacts, place->state, (double[]){place->parameter, 0}, message);
    }
    if (status != SALTUS_OK) {
        saltus_rest_locus_free(l);
        *locus = NULL;
    }
    return status;
}

saltus_status saltus_rest_locus_go_on(const saltus_spec *spec, saltus_trail *trail,
                                      saltus_locus_starts *starts, saltus_rest_locus **locus,
                                      saltus_message *message) {
    saltus_status status = saltus_rest_locus_new(spec, trail, NULL, locus, message);
    if (status != SALTUS_OK)
        return status;
    (*locus)->way = (*locus)->way_count;
    (*locus)->starts = *starts;
    *starts = (saltus_locus_starts){.count = 0};
    return SALTUS_OK;
}

void saltus_rest_locus_free(saltus_rest_locus *l) {
    if (!l)
        return;
    saltus_rest_clear(&l->here.rest);
    saltus_rest_clear(&l->next.rest);
    saltus_rest_clear(&l->trial.rest);
    saltus_locus_starts_clear(&l->starts);
    saltus_rests_close(&l->rests);
    free(l);
}

saltus_locus_starts *saltus_rest_locus_starts(saltus_rest_locus *l) {
    return &l->starts;
}

static saltus_status give(saltus_rest_locus *l, const spot *at, saltus_point_kind kind, double ahead,
                          const char *reason, saltus_message *message) {
    const saltus_notice what = {.kind = kind, .ahead = ahead, .accuracy = NAN, .reason = reason};
    const saltus_rest *s = &at->rest;
    const saltus_rests *r = &l->rests;
    saltus_branch_point *point = saltus_trail_place(l->trail, message);
    if (!point)
        return SALTUS_NO_MEMORY;
    saltus_status status = saltus_rest_point(r, s, point, message);
    if (status != SALTUS_OK)
        return status;
    const double rest = s->value[1] - (r->origin[1] + r->family.unit[1] * s->parameter[1]);
    point->spec = saltus_spec_shifted(&point->spec, &r->family.direction[1], rest);
    point->locus = l->special.kind;
    point->stable = false;
    if (point->locus == SALTUS_POINT_HB) {
        const double square = at->tests[0].value;
        point->lyapunov_coefficient = at->tests[1].value;
        point->period = square > 0 ? 2 * M_PI / (sqrt(square) * r->rate_scale) : NAN;
    }
    if (point->locus == SALTUS_POINT_BE)
        saltus_rest_touch(r, l->special.face, point);
    return saltus_trail_give(l->trail, r->system, &what, message);
}

/* Begin the next direction from the first point. */
static saltus_status begin(saltus_rest_locus *l, saltus_message *message) {
    saltus_rests *r = &l->rests;
    saltus_curve_point *at = &l->here.rest.at;
    const size_t bytes = (size_t)at->unknowns * sizeof *at->u;
    saltus_trail_begin(l->trail, l->trail->number + 1, l->trail->parent, l->trail->depth, false);
    memcpy(at->u, l->beginning, bytes);
    memcpy(at->tangent, l->beginning + at->unknowns, bytes);
    at->bent = false;
    at->ahead = 0;
    l->special.square = l->first_square;
    if (l->ways[l->way++] < 0)
        saltus_curve_turn(at);
    saltus_status status = renew(l, at->u, message);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(&r->equations, at->u, message);
    if (status == SALTUS_OK)
        status = saltus_rest_see(r, &l->here.rest, message);
    if (status == SALTUS_OK)
        status = measure(l, &l->here, message);
    /* At the BT point itself their signs mean nothing. */
    for (int k = 0; k < tests_max && l->switched; k++)
        l->here.tests[k].value = NAN;
    at->residual = r->equations.size;
    return status == SALTUS_OK ? give(l, &l->here, l->special.kind, 0, "", message) : status;
}

/* Where two eigenvalues are zero, the curve of folds passes through, and that of Hopf points ends. */
static saltus_status meet(saltus_rest_locus *l, const saltus_rest *at, saltus_message *message) {
    const saltus_trail *trail = l->trail;
    saltus_locus_start start = {.kind = l->special.kind,
                                .sequence = {.periods = 1, .contacts = at->contacts, .cuts = 1},
                                .parameter = {at->parameter[0], at->parameter[1]},
                                .state = at->state,
                                .origin = SALTUS_POINT_BT,
                                .parent = trail->number,
                                .depth = trail->depth + 1,
                                .done = true};
    saltus_status status = trail->options->switches == 0
                               ? SALTUS_OK
                               : saltus_locus_starts_add(&l->starts, l->rests.n, &start, message);
    if (status != SALTUS_OK || trail->depth >= trail->options->switches)
        return status;
    start.kind = start.kind == SALTUS_POINT_HB ? SALTUS_POINT_LP : SALTUS_POINT_HB;
    start.done = false;
    return saltus_locus_starts_add(&l->starts, l->rests.n, &start, message);
}

/* Where the first Lyapunov coefficient is zero the curve of Hopf points goes through, and cycles that fold
 * grow from the equilibrium. */
static saltus_status leave_cycles(saltus_rest_locus *l, const saltus_rest *at, saltus_message *message) {
    saltus_hopf hopf;
    saltus_message ignored;
    if (l->trail->options->switches == 0)
        return SALTUS_OK;
    saltus_status status = saltus_hopf_find(&l->rests, at, &hopf, &ignored);
    if (status != SALTUS_OK)
        return status == SALTUS_NO_MEMORY ? saltus_branch_no_memory(message) : SALTUS_OK;
    saltus_locus_start start = {
        .kind = SALTUS_POINT_HB,
        .sequence = {.periods = 1, .contacts = at->contacts, .cuts = 1, .omega = hopf.omega},
        .parameter = {at->parameter[0], at->parameter[1]},
        .state = at->state,
        .one_way = true,
        .origin = SALTUS_POINT_GH,
        .parent = l->trail->number,
        .depth = l->trail->depth + 1,
        .done = true};
    status = saltus_locus_starts_add(&l->starts, l->rests.n, &start, message);
    if (status != SALTUS_OK || l->trail->depth >= l->trail->options->switches)
        return status;
    start.kind = SALTUS_POINT_LP;
    start.done = false;
    saltus_hopf_direction(&l->rests, &hopf, start.sequence.anchor);
    return saltus_locus_starts_add(&l->starts, l->rests.n, &start, message);
}

/* The way along a curve of Hopf points from where two eigenvalues are zero on which these are a pair. */
static int way_of_pairs(saltus_rest_locus *l) {
    const double apart = 1e-3;
    saltus_rest *aside = &l->trial.rest;
    double square;
    saltus_message ignored;
    saltus_status status = saltus_rest_visit(&l->rests, &l->here.rest, apart, aside, &ignored);
    return status == SALTUS_OK &&
                   isfinite(saltus_rests_pair(&l->rests, aside->at.u, l->special.square, &square)) &&
                   square > 0
               ? 1
               : -1;
}

/* Begin a curve that was met. */
static saltus_status switch_to(saltus_rest_locus *l, saltus_locus_start *start, saltus_message *message) {
    const double little = 1e-6; /* relative to rate_scale; identifies the two eigenvalues at BT */
    const bool through = start->kind != SALTUS_POINT_HB || start->origin != SALTUS_POINT_BT;
    const double omega =
        start->sequence.omega > 0 ? start->sequence.omega : sqrt(little) * l->rests.rate_scale;
    saltus_message why = {.text = ""};
    start->done = l->switched = true;
    l->special.kind = start->kind;
    l->special.face = -1;
    l->special.square = omega * omega;
    l->trail->parent = start->parent;
    l->trail->depth = start->depth;
    saltus_status status = open_first(l, start->sequence.contacts, start->state, start->parameter, &why);
    if (status != SALTUS_OK)
        return saltus_fail(message, status, "no curve of %s points can be begun at a %s: %.200s",
                           saltus_point_word(start->kind), saltus_point_word(start->origin), why.text);
    l->way = 0;
    l->way_count = through ? 2 : 1;
    l->ways[0] = through ? 1 : way_of_pairs(l);
    l->ways[1] = -1;
    return begin(l, message);
}

/* A test whose zero is sought. */
typedef struct sought {
    saltus_rest_locus *locus;
    int test;
} sought;

static bool value_ahead(void *context, double ahead, double *value) {
    const sought *s = context;
    saltus_rest_locus *l = s->locus;
    saltus_message ignored;
    saltus_status status = saltus_rest_visit(&l->rests, &l->here.rest, ahead, &l->trial.rest, &ignored);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(&l->rests.equations, l->trial.rest.at.u, &ignored);
    if (status == SALTUS_OK)
        status = measure(l, &l->trial, &ignored);
    if (saltus_rests_noted(&l->rests, status) != SALTUS_OK)
        return false;
    *value = l->trial.tests[s->test].value;
    return isfinite(*value);
}

/* Give out the points of codimension two between `here` and `next`, in order. */
static saltus_status give_corners(saltus_rest_locus *l, saltus_message *message) {
    double place[tests_max];
    int order[tests_max], count = 0;
    saltus_status status = SALTUS_OK;
    for (int k = 0; k < tests_max; k++) {
        sought s = {l, k};
        double width;
        const double near = l->here.tests[k].value, far = l->next.tests[k].value;
        if (!(near * far < 0) || !saltus_curve_zero(l->rests.solver, value_ahead, &s, near,
                                                    l->next.rest.at.ahead, far, &place[k], &width))
            continue;
        order[count++] = k;
        if (count == 2 && place[order[1]] < place[order[0]]) {
            order[1] = order[0];
            order[0] = k;
        }
    }
    for (int i = 0; i < count && status == SALTUS_OK && l->trail->following; i++) {
        const int k = order[i];
        const test *t = &l->here.tests[k];
        sought s = {l, k};
        double value;
        if (!value_ahead(&s, place[k], &value))
            continue;
        status = give(l, &l->trial, t->kind, place[k], "", message);
        if (status == SALTUS_OK && t->kind == SALTUS_POINT_BT && l->trail->following)
            status = meet(l, &l->trial.rest, message);
        if (status == SALTUS_OK && t->kind == SALTUS_POINT_GH && l->trail->following)
            status = leave_cycles(l, &l->trial.rest, message);
        if (status == SALTUS_OK && t->ends && l->trail->following)
            status = give(l, &l->trial, SALTUS_POINT_EP, place[k],
                          "beyond it two real eigenvalues add up to zero: no Hopf points", message);
    }
    return status;
}

/* Whether the curve has come back to its first point in the step from `here` to `next`. */
static bool is_closed(const saltus_rest_locus *l) {
    const saltus_curve_point *here = &l->here.rest.at, *next = &l->next.rest.at;
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

/* A face that the equilibrium has crossed or whose contact pulls; -1: none. */
static int find_breach(const saltus_rest_locus *l) {
    const double near = 1e-9;
    for (int f = 0; f < l->rests.system->face_count; f++)
        if (l->next.rest.breach[f] > near && !(l->special.kind == SALTUS_POINT_BE && f == l->special.face))
            return f;
    return -1;
}

/* One step along the current curve. */
static saltus_status advance(saltus_rest_locus *l, saltus_message *message) {
    saltus_rests *r = &l->rests;
    saltus_trail *trail = l->trail;
    saltus_rest *next = &l->next.rest;
    const saltus_curve_bound bounds[2] = {{r->size, l->border[0][0], l->border[0][1]},
                                          {r->size + 1, l->border[1][0], l->border[1][1]}};
    saltus_message why = {.text = ""};
    int reached;
    saltus_status status = saltus_curve_step(&r->equations, &l->here.rest.at, &trail->step, bounds, 2,
                                             &next->at, &reached, &why);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(&r->equations, next->at.u, &why);
    if (status == SALTUS_OK)
        status = saltus_rest_see(r, next, &why);
    if (status == SALTUS_OK)
        status = measure(l, &l->next, &why);
    if (status == SALTUS_NO_MEMORY)
        return saltus_branch_no_memory(message);
    if (status != SALTUS_OK)
        return give(l, &l->here, SALTUS_POINT_EP, 0, why.text, message);
    status = give_corners(l, message);
    if (status != SALTUS_OK || !trail->following)
        return status;
    const double ahead = next->at.ahead;
    const int face = find_breach(l);
    if (face >= 0)
        return give(l, &l->here, SALTUS_POINT_EP, 0,
                    r->contacts >> face & 1 ? "a contact force falls to zero"
                                            : "the equilibrium meets a stop",
                    message);
    if (is_closed(l)) {
        l->way = l->way_count; /* the other direction leads around the same curve */
        return give(l, &l->next, SALTUS_POINT_EP, ahead, "the curve is closed: it has come back", message);
    }
    if (reached >= 0) {
        const double low = trail->options->low[reached], high = trail->options->high[reached];
        next->value[reached] = next->parameter[reached] == l->border[reached][1] ? high : low;
        return give(l, &l->next, SALTUS_POINT_EP, ahead, "end of the parameters' range", message);
    }
    trail->step = saltus_curve_next_step(trail->step, next->at.iterations, trail->options->step_max);
    status = give(l, &l->next, l->special.kind, ahead, "", message);
    trail->arclength += ahead;
    const spot swap = l->here;
    l->here = l->next;
    l->next = swap;
    saltus_curve_bend(&l->next.rest.at, &l->here.rest.at);
    return status == SALTUS_OK ? renew(l, l->here.rest.at.u, message) : status;
}

saltus_status saltus_rest_locus_step(saltus_rest_locus *l, bool *more, saltus_message *message) {
    saltus_status status = SALTUS_OK;
    *more = true;
    if (l->trail->following)
        status = advance(l, message);
    else if (l->way < l->way_count)
        status = begin(l, message);
    else if ((*more = saltus_locus_starts_wait(&l->starts, true)))
        status = switch_to(l, &l->starts.start[l->starts.next], message);
    return status == SALTUS_OK && l->rests.starved ? saltus_branch_no_memory(message) : status;
}

static saltus_point_kind archive_kind(saltus_archive *a, saltus_point_kind kind) {
    kind = saltus_archive_kind(a, kind);
    a->sound = a->sound && (kind == SALTUS_POINT_HB || kind == SALTUS_POINT_BE || kind == SALTUS_POINT_LP);
    return kind;
}

saltus_status saltus_rest_locus_archive(saltus_rest_locus *l, saltus_archive *a, saltus_message *message) {
    saltus_locus_starts_archive(a, &l->starts);
    l->switched = saltus_archive_flag(a, l->switched);
    l->special.kind = archive_kind(a, l->special.kind);
    l->special.face = (int)saltus_archive_whole(a, l->special.face, -1, a->faces - 1);
    l->way_count = (int)saltus_archive_whole(a, l->way_count, 1, 2);
    for (int k = 0; k < 2; k++)
        l->ways[k] = (int)saltus_archive_whole(a, l->ways[k], -1, 1);
    l->way = (int)saltus_archive_whole(a, l->way, 0, l->way_count);
    saltus_archive_real(a, &l->special.square);
    saltus_archive_real(a, &l->first_square);
    for (int k = 0; k < tests_max; k++) {
        test *own = &l->here.tests[k];
        own->kind = saltus_archive_kind(a, own->kind);
        own->ends = saltus_archive_flag(a, own->ends);
        saltus_archive_real(a, &own->value);
    }
    saltus_rest *here = &l->here.rest;
    saltus_status status = saltus_archive_rest(a, &l->rests, here, message);
    if (status == SALTUS_OK && a->sound)
        saltus_archive_finite(a, l->beginning, 2 * (size_t)here->at.unknowns);
    return status == SALTUS_OK && a->reading && a->sound ? renew(l, here->at.u, message) : status;
}
