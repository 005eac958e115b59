/* Branches of equilibria.
 *
 * Pseudo-arclength steps (curve.h) on the equations of an equilibrium with given contacts (rest.h). Test
 * functions are compared at both ends of a step; each zero is located and given out. Where the gap of a free
 * face or the force of a contact falls to zero, the branch continues with that contact closed or released, in
 * the direction in which gap and force are admissible; in the parameter this may lead on or back.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/equilibria.h"

#include "branch/born.h"
#include "branch/options.h"
#include "branch/point.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

saltus_status saltus_equilibria_open(saltus_equilibria *e, const saltus_spec *spec, const double *state,
                                     saltus_message *message) {
    const saltus_branch_options *options = e->trail->options;
    const unsigned loci =
        1u << SALTUS_POINT_REGULAR | 1u << SALTUS_POINT_HB | 1u << SALTUS_POINT_BE | 1u << SALTUS_POINT_LP;
    const saltus_equilibrium_options how = saltus_equilibrium_defaults();
    saltus_rests *r = &e->rests;
    e->here = &e->solutions[0];
    e->next = &e->solutions[1];
    e->trial = &e->solutions[2];
    e->spare = &e->solutions[3];
    if (!(loci >> options->locus & 1))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "locus = %s: the start is an equilibrium, whose curves are those of HB, BE and LP",
                           saltus_point_word(options->locus));
    saltus_status status = saltus_branch_family(spec, options, 1, &r->family, r->origin, &e->range, message);
    if (status == SALTUS_OK)
        status = saltus_rests_open(r, message);
    /* At neither end of the range may the scene be forced. */
    for (int side = 0; side < 2 && status == SALTUS_OK; side++) {
        const saltus_spec end = saltus_family_spec(&r->family, &e->range[side], 0);
        saltus_system *system = NULL;
        status = saltus_system_new(&end, &system, message);
        if (status == SALTUS_OK && saltus_system_forced(system))
            status =
                saltus_fail(message, SALTUS_BAD_INPUT,
                            "%s=%g:%g: with %s = %g the scene is forced, and has no equilibria to follow",
                            options->key[0], options->low[0], options->high[0], options->key[0],
                            side ? options->high[0] : options->low[0]);
        saltus_system_free(system);
    }
    if (status != SALTUS_OK || !state)
        return status;
    saltus_equilibrium rest = {0};
    status = saltus_equilibrium_find(r->system, state, &how, &rest, message);
    if (status != SALTUS_OK)
        return status;
    saltus_branch_start start = {.sequence = {.periods = 1, .cuts = 1, .contacts = rest.contacts},
                                 .parent = -1};
    start.state = rest.state;
    start.states = r->n;
    saltus_starts_add_ways(&e->starts, &start, options->direction, &r->starved);
    saltus_equilibrium_clear(&rest);
    return r->starved ? saltus_branch_no_memory(message) : SALTUS_OK;
}

void saltus_equilibria_close(saltus_equilibria *e) {
    saltus_starts_clear(&e->starts);
    for (int k = 0; k < 4; k++)
        saltus_rest_clear(&e->solutions[k]);
    saltus_rests_close(&e->rests);
}

static const char *label_of(unsigned contacts) {
    return contacts ? "held" : "equilibrium";
}

bool saltus_rest_give(saltus_rests *r, const saltus_rest *s, saltus_notice what, saltus_trail *trail) {
    const saltus_rest_special *special = &r->special;
    const bool touches = special->kind == SALTUS_POINT_BE;
    const saltus_breach touch = {.face = special->face};
    saltus_branch_point point;
    const bool room = saltus_point_open(&point, r->n, 0);
    r->starved |= !room;
    if (!room)
        return trail->following = false;
    point.spec = saltus_family_spec(&r->family, s->parameter, 0);
    for (int d = 0; d < r->family.parameters; d++) {
        /* What the rounded unknown lacks to the equilibrium's value, which is exact on a border of the
         * range. */
        const double rest = s->value[d] - (r->origin[d] + r->family.unit[d] * s->parameter[d]);
        point.spec = saltus_spec_shifted(&point.spec, &r->family.direction[d], rest);
        point.value[d] = s->value[d];
    }
    point.heading = s->at.tangent[s->at.unknowns - r->family.parameters] * r->family.unit[0];
    point.locus = special->kind;
    point.unstable = s->unstable;
    point.stable = s->stable && !special->kind;
    point.admissible = true;
    point.residual = s->at.residual;
    point.iterations = s->at.iterations;
    point.sum_rule = s->trace;
    point.multiplier_count = s->rate_count;
    memcpy(point.state, s->state, (size_t)r->n * sizeof *s->state);
    for (int k = 0; k < r->n; k++)
        point.multipliers[k] = k < s->rate_count
                                   ? (saltus_multiplier){s->rates[k].re, s->rates[k].im, s->rates[k].re}
                                   : (saltus_multiplier){NAN, NAN, NAN};
    for (int k = 0; k < s->rate_count; k++)
        point.log_volume += s->rates[k].re;
    for (int f = 0; f < r->system->face_count; f++)
        if (s->contacts >> f & 1)
            point.contact_force = fmin(point.contact_force, s->force[f]);
    snprintf(point.label, sizeof point.label, "%s", label_of(s->contacts));
    if (touches)
        saltus_point_mark_grazing(r->system, &touch, &point);
    saltus_trail_give(trail, r->system, &point, NULL, &what, &r->starved);
    return !r->starved;
}

static bool give(saltus_equilibria *e, const saltus_rest *s, saltus_notice what) {
    return saltus_rest_give(&e->rests, s, what, e->trail);
}

static void end(saltus_equilibria *e, const saltus_rest *s, double ahead, const char *reason) {
    give(e, s, (saltus_notice){.kind = SALTUS_POINT_EP, .ahead = ahead, .accuracy = NAN, .reason = reason});
}

/* The tangent's component in the parameter. */
static double heading_of(const saltus_rest *s) {
    return s->at.tangent[s->at.unknowns - 1];
}

/* A test whose zero is sought on the step from `here` to `next`, and its arguments: FOLD, CROSSING, PAIR
 * (product of the sums of all eigenvalue pairs), BREACH or VALUE. */
typedef struct sought {
    saltus_equilibria *e;
    saltus_test test;
    int face; /* BREACH */
    double target;
} sought;

/* The value at an equilibrium; products in units of that at `here`. */
static double value_at(const sought *a, const saltus_rest *s) {
    const saltus_rest *here = a->e->here;
    switch (a->test) {
    case SALTUS_TEST_FOLD:
        return heading_of(s);
    case SALTUS_TEST_CROSSING:
        return saltus_scaled_in(s->at.crossing, here->at.crossing.exponent);
    case SALTUS_TEST_PAIR:
        return saltus_scaled_in(s->pairs, here->pairs.exponent);
    case SALTUS_TEST_BREACH:
        /* A step begins on the admissible side, where the contact was just made or given up. */
        return s == here ? fmin(s->breach[a->face], -1e-300) : s->breach[a->face];
    default:
        return s->value[0] - a->target;
    }
}

static bool value_ahead(void *context, double ahead, double *value) {
    const sought *a = context;
    saltus_equilibria *e = a->e;
    if (saltus_rest_visit(&e->rests, e->here, ahead, e->trial, NULL) != SALTUS_OK)
        return false;
    *value = value_at(a, e->trial);
    return true;
}

/* The zero on the step, or at one of its ends; `trial` becomes the point there. */
static saltus_zero find_zero(sought *a) {
    const double apart = 1e-7;
    saltus_equilibria *e = a->e;
    saltus_zero zero = {.ahead = e->next->at.ahead, .accuracy = INFINITY};
    double width = 0, value[3], off = apart;
    const double ends[] = {0, e->next->at.ahead}, values[] = {value_at(a, e->here), value_at(a, e->next)};
    if (values[1] != 0 &&
        !saltus_curve_zero(e->rests.solver, value_ahead, a, ends, values, &zero.ahead, &width))
        return zero;
    /* The possible rounding error in arclength, from the scatter of points beside it. */
    if (value_ahead(a, zero.ahead - apart, &value[0]) && value_ahead(a, zero.ahead, &value[1]) &&
        value_ahead(a, zero.ahead + apart, &value[2])) {
        const double slope = fabs(value[2] - value[0]) / (2 * apart);
        const double scatter = fabs(value[1]) + fabs(value[1] - 0.5 * (value[0] + value[2]));
        off = slope > 0 ? fmin(scatter / slope, apart) : apart;
    }
    off += width;
    zero.found = saltus_rest_visit(&e->rests, e->here, zero.ahead, e->trial, NULL) == SALTUS_OK;
    zero.accuracy = e->rests.family.unit[0] * (off * fmax(fabs(heading_of(e->trial)), off) + DBL_EPSILON);
    return zero;
}

/* `trial` becomes the point where branches cross near `ahead` of `here`. */
static saltus_zero find_crossing(saltus_equilibria *e, double ahead) {
    const double rounding = 1e-14;
    saltus_rests *r = &e->rests;
    saltus_rest *at = e->trial;
    sought a = {.e = e, .test = SALTUS_TEST_CROSSING};
    double accuracy;
    saltus_status status = saltus_curve_crossing(&r->equations, value_ahead, &a, &e->here->at, ahead,
                                                 e->next->at.ahead, true, &at->at, &accuracy);
    if (status == SALTUS_OK)
        status = saltus_rest_see(r, at, NULL);
    at->at.residual = r->equations.size;
    return (saltus_zero){.found = saltus_rests_noted(r, status) == SALTUS_OK,
                         .ahead = at->at.ahead,
                         .accuracy = r->family.unit[0] * (accuracy + rounding)};
}

/* What the starts of branches that leave at an equilibrium have in common. */
static saltus_branch_start leaving(const saltus_equilibria *e, const saltus_rest *at,
                                   saltus_point_kind origin) {
    saltus_branch_start start = saltus_trail_leaving(e->trail);
    start.origin = origin;
    start.sequence = (saltus_sequence){.periods = 1, .cuts = 1, .contacts = at->contacts};
    start.parameter[0] = at->parameter[0];
    start.state = at->state;
    start.states = e->rests.n;
    return start;
}

/* Add the branches that leave at a branch point `at`; only one if `at` is symmetric, so that they are mirror
 * images of each other. */
static void leave(saltus_equilibria *e, const saltus_rest *at) {
    saltus_rests *r = &e->rests;
    const double nothing[SALTUS_STATE_MAX] = {0};
    const bool mirrored = r->system->mirror && saltus_system_distance(r->system, at->state, nothing) < 1e-7;
    double tangent[SALTUS_STATE_MAX + 1] = {0};
    saltus_branch_start start = leaving(e, at, SALTUS_POINT_BP);
    start.tangent = tangent;
    start.unknowns = r->n + 1; /* as many as an orbit's; those beyond m are unused */
    const saltus_status status =
        saltus_curve_leaving(&r->equations, at->at.u, e->here->at.tangent, tangent, NULL, NULL);
    if (saltus_rests_noted(r, status) == SALTUS_OK)
        saltus_starts_add_ways(&e->starts, &start, mirrored, &r->starved);
}

/* The requested locus begins at `at`; no more of this branch is needed. A `face` (-1: none) that is only
 * touched does not hold. */
static void find(saltus_equilibria *e, const saltus_rest *at, int face, double omega) {
    const saltus_branch_start start = {
        .kind = e->trail->options->locus,
        .sequence = {.contacts = face < 0 ? at->contacts : at->contacts & ~(1u << face), .omega = omega},
        .parameter = {at->parameter[0]},
        .state = at->state,
        .states = e->rests.n,
        .mark = face,
        .parent = -1};
    saltus_starts_add(e->found, &start, &e->rests.starved);
    e->trail->following = false;
}

/* Whether the real parts of a pair of eigenvalues are this small, relative to the imaginary ones. */
static bool has_imaginary_pair(const saltus_rest *s, double close) {
    for (int k = 0; k < s->rate_count; k++)
        if (fabs(s->rates[k].re) < close * fabs(s->rates[k].im))
            return true;
    return false;
}

/* Give out the Hopf point `at`, with what it says about the cycles born there. Two real eigenvalues of
 * opposite sign are no Hopf point. */
static void give_hopf(saltus_equilibria *e, const saltus_rest *at, saltus_notice what) {
    const double on_axis = 1e-6;
    saltus_hopf hopf;
    char reason[SALTUS_REASON_MAX];
    if (!has_imaginary_pair(at, on_axis))
        return;
    const bool told = saltus_hopf_find(&e->rests, at, &hopf);
    if (told && e->trail->options->locus == SALTUS_POINT_HB) {
        find(e, at, -1, hopf.omega);
        return;
    }
    if (told) {
        const char *criticality = !(fabs(hopf.coefficient) > hopf.error) ? "criticality not decided"
                                  : hopf.coefficient < 0                 ? "supercritical"
                                                                         : "subcritical";
        snprintf(reason, sizeof reason, "%s: omega = %.12g, first Lyapunov coefficient %.9g +- %.0e",
                 criticality, hopf.omega, hopf.coefficient, hopf.error);
        what.reason = reason;
    }
    if (!give(e, at, what) || !told)
        return;
    saltus_branch_point *point = saltus_trail_last(e->trail);
    point->period = 2 * M_PI / hopf.omega;
    point->lyapunov_coefficient = hopf.coefficient;
    if (!saltus_trail_switches(e->trail))
        return;
    saltus_branch_start start = leaving(e, at, SALTUS_POINT_HB);
    double tangent[SALTUS_STATE_MAX + 2] = {0};
    saltus_hopf_direction(&e->rests, &hopf, tangent);
    start.tangent = tangent;
    start.sequence.omega = hopf.omega;
    start.unknowns = e->rests.n + 2;
    saltus_starts_add(e->cycles, &start, &e->rests.starved);
}

/* Find all special points of the step from `here` to `next`, and give them out in order. */
static void give_specials(saltus_equilibria *e) {
    static const struct {
        saltus_point_kind kind;
        saltus_test test;
    } tests[] = {{SALTUS_POINT_LP, SALTUS_TEST_FOLD},
                 {SALTUS_POINT_BP, SALTUS_TEST_CROSSING},
                 {SALTUS_POINT_HB, SALTUS_TEST_PAIR}};
    enum { kinds = sizeof tests / sizeof tests[0] };
    const saltus_branch_options *options = e->trail->options;
    const double reach = e->next->at.ahead;
    saltus_rest *at = e->trial;
    saltus_special places[SALTUS_BRANCH_VALUES_MAX + kinds];
    /* Without damping a pair stays on the axis and crosses it by rounding only. */
    const double rounding = 1e-9;
    const bool undamped = has_imaginary_pair(e->here, rounding) && has_imaginary_pair(e->next, rounding);
    int count = 0;
    for (int k = 0; k < kinds + options->value_count; k++) {
        const bool own = k < kinds;
        saltus_special found = {.kind = own ? tests[k].kind : SALTUS_POINT_UZ,
                                .test = own ? tests[k].test : SALTUS_TEST_VALUE,
                                .target = own ? 0 : options->values[k - kinds]};
        sought a = {e, found.test, -1, found.target};
        const double near = value_at(&a, e->here), far = value_at(&a, e->next);
        if ((own && e->trail->fresh) || !saltus_test_crosses(near, far) ||
            (undamped && found.kind == SALTUS_POINT_HB))
            continue;
        const saltus_zero zero =
            found.kind == SALTUS_POINT_BP ? find_crossing(e, reach * near / (near - far)) : find_zero(&a);
        found.ahead = zero.ahead;
        found.accuracy = zero.accuracy;
        if (zero.found)
            count = saltus_special_insert(found, places, count);
    }
    for (int k = 0; k < count && e->trail->following; k++) {
        const saltus_special *p = &places[k];
        const saltus_notice what = {.kind = p->kind, .ahead = p->ahead, .accuracy = p->accuracy};
        const bool crosses = p->kind == SALTUS_POINT_BP;
        if (crosses ? !find_crossing(e, p->ahead).found
                    : saltus_rest_visit(&e->rests, e->here, p->ahead, at, NULL) != SALTUS_OK)
            continue;
        if (p->kind == SALTUS_POINT_UZ)
            at->value[0] = p->target;
        if (p->kind == SALTUS_POINT_HB)
            give_hopf(e, at, what);
        else if (p->kind == SALTUS_POINT_LP && options->locus == SALTUS_POINT_LP)
            find(e, at, -1, 0);
        else
            give(e, at, what);
        if (crosses && saltus_trail_switches(e->trail))
            leave(e, at);
    }
}

/* The face met or left first between `here` and `next`, with the equilibrium there as `trial`; -1: none. */
static int find_breach(saltus_equilibria *e, saltus_zero *first) {
    int face = -1;
    first->ahead = INFINITY;
    for (int f = 0; f < e->rests.system->face_count; f++) {
        sought a = {.e = e, .test = SALTUS_TEST_BREACH, .face = f};
        if (!(e->next->breach[f] > 0))
            continue;
        const saltus_zero zero = find_zero(&a);
        if (zero.found && zero.ahead < first->ahead) {
            *first = zero;
            face = f;
        }
    }
    return face;
}

/* `spare` becomes the equilibrium `at` with the contact of a face changed, and a tangent along which the gap
 * of the face opens, or its contact force pushes. False if there is none. */
static bool change_contact(saltus_equilibria *e, const saltus_rest *at, int face, saltus_message *message) {
    const double apart = 1e-5;
    saltus_rests *r = &e->rests;
    saltus_rest *s = e->spare;
    saltus_status status =
        saltus_rest_place(r, at->contacts ^ 1u << face, at->state, at->parameter, false, NULL, s, message);
    if (status == SALTUS_OK)
        status = saltus_rest_visit(r, s, apart, e->trial, message);
    if (saltus_rests_noted(r, status) != SALTUS_OK)
        return false;
    if (e->trial->breach[face] > 0)
        saltus_curve_turn(&s->at);
    return true;
}

/* Find the cycles that begin where `next` touches a face; beyond, the equilibria go on at `spare`. */
static void find_born(saltus_equilibria *e, int face, bool leaves, saltus_starts *born) {
    const saltus_rest *free_one = leaves ? e->spare : e->next;
    const saltus_branch_start like = leaving(e, free_one, SALTUS_POINT_BE);
    saltus_rests *r = &e->rests;
    if (saltus_rests_noted(r, saltus_rests_shape(r, free_one->contacts, free_one->state, free_one->parameter,
                                                 NULL)) == SALTUS_OK) {
        saltus_boundary_leave(r, free_one, face, &like, e->trial, born);
        saltus_newborn_find(r, free_one, face, &e->trail->options->orbit, &like, e->trial, born);
    }
    saltus_rests_noted(r,
                       saltus_rests_shape(r, e->spare->contacts, e->spare->state, e->spare->parameter, NULL));
}

/* Describe a cycle that begins at a boundary equilibrium; returns the length of the text. */
static int tell_born(const saltus_branch_start *born, bool first, const char *key, char *text, size_t room) {
    const saltus_sequence *s = &born->sequence;
    int impacts = 0;
    bool chatters = false;
    char meets[32];
    for (int k = 0; k < s->count; k++) {
        impacts += s->mark[k].kind == SALTUS_IMPACT;
        chatters = chatters || s->mark[k].driven;
    }
    snprintf(meets, sizeof meets,
             chatters      ? "chatter"
             : impacts > 1 ? "%d impacts"
             : impacts     ? "one impact"
                           : "a contact",
             impacts);
    const char *side = born->heading > 0 ? "larger" : "smaller";
    return snprintf(text, room, "%s with %s of period %.9g %stowards %s %s", first ? "; a cycle" : ", one",
                    meets, 2 * M_PI / s->omega, first ? "begins " : "", side, key);
}

/* The equilibrium `next` meets or leaves a stop: continue the branch with the changed contacts. */
static void meet(saltus_equilibria *e, int face, saltus_zero zero) {
    saltus_trail *trail = e->trail;
    const saltus_face f = e->rests.system->faces[face];
    const saltus_breach touch = {.face = face};
    saltus_message why = {.text = ""};
    char reason[SALTUS_REASON_MAX];
    const bool leaves = e->next->contacts >> face & 1;
    if (trail->options->locus == SALTUS_POINT_BE) {
        find(e, e->next, face, 0);
        return;
    }
    const bool goes_on = change_contact(e, e->next, face, &why);
    const bool turns = goes_on && heading_of(e->next) * heading_of(e->spare) < 0;
    saltus_starts born = {.count = 0};
    if (goes_on)
        find_born(e, face, leaves, &born);
    int length = snprintf(reason, sizeof reason, "%s stop %d %s%s", leaves ? "leaves" : "meets", f.stop + 1,
                          f.side > 0 ? "upper" : "lower",
                          !goes_on ? "; beyond it no equilibrium was found"
                          : turns  ? "; the branch turns back (non-smooth fold)"
                                   : "");
    for (int k = 0; k < born.count && length < (int)sizeof reason; k++)
        length += tell_born(&born.start[k], k == 0, trail->options->key[0], reason + length,
                            sizeof reason - (size_t)length);
    give(e, e->next,
         (saltus_notice){.kind = SALTUS_POINT_BE,
                         .ahead = zero.ahead,
                         .accuracy = zero.accuracy,
                         .reason = reason,
                         .after = goes_on ? label_of(e->spare->contacts) : NULL,
                         .grazing = &touch});
    for (int k = 0; k < born.count && saltus_trail_switches(e->trail); k++)
        saltus_starts_add(e->cycles, &born.start[k], &e->rests.starved);
    saltus_starts_clear(&born);
    if (!trail->following)
        return;
    if (!goes_on) {
        end(e, e->next, zero.ahead, why.text);
        return;
    }
    saltus_trail_jump(trail, zero.ahead);
    SALTUS_SWAP(e->here, e->spare);
}

void saltus_equilibria_advance(saltus_equilibria *e) {
    const double finest = 1e-4;
    saltus_rests *r = &e->rests;
    saltus_trail *trail = e->trail;
    const saltus_curve_bound bound = {r->size, e->range[0], e->range[1]};
    saltus_zero zero = {.accuracy = NAN};
    saltus_message why = {.text = ""};
    int reached, face = -1;
    saltus_status status =
        saltus_curve_step(&r->equations, &e->here->at, &trail->step, &bound, 1, &e->next->at, &reached, &why);
    if (status == SALTUS_OK)
        status = saltus_rest_see(r, e->next, &why);
    if (status == SALTUS_OK) {
        /* So many eigenvalues may have changed sides that there is more than one Hopf point on the step, or
         * one that the test does not show. */
        const sought pair = {.e = e, .test = SALTUS_TEST_PAIR};
        const int changed = abs(e->next->unstable - e->here->unstable),
                  shown = saltus_test_crosses(value_at(&pair, e->here), value_at(&pair, e->next)) ? 4 : 2;
        if (changed >= shown && e->next->at.ahead > finest) {
            trail->step = 0.5 * e->next->at.ahead;
            return;
        }
        face = find_breach(e, &zero);
        if (face >= 0)
            status = saltus_rest_visit(r, e->here, zero.ahead, e->next, &why);
    }
    if (saltus_rests_noted(r, status) != SALTUS_OK) {
        end(e, e->here, 0, why.text);
        return;
    }
    give_specials(e);
    if (!trail->following)
        return;
    trail->fresh = false;
    if (face >= 0) {
        meet(e, face, zero);
        return;
    }
    const double ahead = e->next->at.ahead;
    trail->step = saltus_curve_next_step(trail->step, e->next->at.iterations, trail->options->step_max);
    if (reached >= 0) {
        const bool upper = e->next->parameter[0] == e->range[1];
        e->next->value[0] = upper ? trail->options->high[0] : trail->options->low[0];
        end(e, e->next, ahead, trail->ends[0][upper]);
        return;
    }
    if (saltus_trail_wants(trail, ahead)) {
        give(e, e->next, (saltus_notice){.ahead = ahead, .accuracy = NAN});
        saltus_trail_shown(trail, ahead);
    }
    trail->arclength += ahead;
    SALTUS_SWAP(e->here, e->next);
    saltus_curve_bend(&e->next->at, &e->here->at);
}

/* The first point is a regular one, and again UZ if it lies at a requested value. */
saltus_status saltus_equilibria_start(saltus_equilibria *e, const saltus_branch_start *start,
                                      saltus_message *message) {
    saltus_trail *trail = e->trail;
    saltus_rest *here = e->here;
    saltus_message why = {.text = ""};
    saltus_trail_begin(trail, e->cycles->begun++, start->parent, start->depth, start->unknowns > 0);
    const bool crosses = start->unknowns > 0;
    saltus_status status =
        saltus_rest_place(&e->rests, start->sequence.contacts, start->state, start->parameter, !crosses,
                          crosses ? start->tangent : NULL, here, &why);
    if (status != SALTUS_OK) {
        trail->following = false;
        return saltus_fail(message, status, "no branch of equilibria can be begun: %.300s", why.text);
    }
    const int heading = crosses ? 0 : start->heading;
    if (heading_of(here) * heading < 0)
        saltus_curve_turn(&here->at);
    give(e, here, (saltus_notice){.accuracy = NAN});
    trail->regular = 1;
    for (int k = 0; k < trail->options->value_count && trail->following; k++)
        if (trail->options->values[k] == here->value[0])
            give(e, here, (saltus_notice){.kind = SALTUS_POINT_UZ});
    if (heading && trail->following && here->parameter[0] == e->range[heading > 0])
        end(e, here, 0, trail->ends[0][heading > 0]);
    return SALTUS_OK;
}

saltus_status saltus_equilibria_archive(saltus_equilibria *e, saltus_archive *a, saltus_message *message) {
    saltus_archive_starts(a, &e->starts);
    return e->trail->following ? saltus_archive_rest(a, &e->rests, e->here, message) : SALTUS_OK;
}
