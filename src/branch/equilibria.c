/* Branches of equilibria.
 *
 * Pseudo-arclength steps (curve.h) on the equations of an equilibrium with given contacts (rest.h). Between
 * two points tests are compared, and every zero is located and given out in its place. Where the gap of a
 * free face or the force of a contact falls to zero, the branch goes on with that contact made or given up,
 * as the gap or the force demands: onward, or back where the parameter came from.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/equilibria.h"

#include "base/bits.h"
#include "branch/boundary.h"
#include "branch/hopf.h"
#include "branch/options.h"
#include "branch/rest_locus.h"
#include "branch/rest_point.h"
#include "saltus/equilibrium.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char range_ends[] = "end of the parameter's range";
static const char enough_points[] = "as many points as asked for";

/* A special point between two equilibria. */
typedef struct place {
    saltus_point_kind kind;
    saltus_rest_asked asked;
    saltus_zero zero;
} place;

/* A special point that has been given out. */
typedef struct visited {
    saltus_point_kind kind;
    int branch;
    double value, *state;
} visited;

struct saltus_equilibria {
    saltus_branch_options options;
    saltus_rests rests;
    gsl_root_fsolver *solver;
    double range[2];       /* of the parameter unknown */
    saltus_starts starts;  /* of branches of equilibria; their sequences tell of nothing but contacts */
    saltus_starts *cycles; /* the caller's */
    bool following;
    int number, parent, depth, regular, made; /* of the branch under way */
    double arclength, shown, step;
    bool fresh; /* no step made since the branch was switched to */
    saltus_rest solutions[4];
    saltus_rest *here, *next, *trial, *spare;
    visited *visited;
    int visited_count;
    saltus_branch_point *queue; /* points made but not yet given out */
    int queue_count, queue_next, queue_room;
    saltus_rest_locus *locus; /* NULL: none is followed yet */
};

static saltus_status no_memory(saltus_message *message) {
    return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a branch of equilibria");
}

/* A parameter that brings forcing with it leads to no equilibria. */
static saltus_status check_unforced(const saltus_equilibria *e, saltus_message *message) {
    const saltus_branch_options *o = &e->options;
    for (int side = 0; side < 2; side++) {
        const saltus_spec spec = saltus_family_spec(&e->rests.family, &e->range[side], 0);
        saltus_system *system = NULL;
        saltus_message ignored;
        /* Where there is no system the branch ends by itself. */
        const saltus_status status = saltus_system_new(&spec, &system, &ignored);
        const bool forced = status == SALTUS_OK && saltus_system_forced(system);
        saltus_system_free(system);
        if (status == SALTUS_NO_MEMORY)
            return no_memory(message);
        if (forced)
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "%s=%g:%g: with %s = %g the scene is forced, and has no equilibria to follow",
                               o->key[0], o->low[0], o->high[0], o->key[0], side ? o->high[0] : o->low[0]);
    }
    return SALTUS_OK;
}

/* Both ways from the equilibrium near a state. */
static saltus_status open_starts(saltus_equilibria *e, const double *state, saltus_message *message) {
    saltus_equilibrium_options how = saltus_equilibrium_defaults();
    saltus_equilibrium rest = {0};
    saltus_branch_start start = {.parent = -1};
    saltus_status status = saltus_equilibrium_find(e->rests.system, state, &how, &rest, message);
    start.state = rest.state;
    start.sequence = (saltus_sequence){.periods = 1, .cuts = 1, .contacts = rest.contacts};
    for (int heading = 1; heading >= -1 && status == SALTUS_OK; heading -= 2)
        if (e->options.direction * heading >= 0) {
            start.heading = heading;
            status = saltus_starts_add(&e->starts, e->rests.n, &start, message);
        }
    saltus_equilibrium_clear(&rest);
    return status;
}

saltus_status saltus_equilibria_new(const saltus_spec *spec, const saltus_branch_options *options,
                                    const double *state, saltus_starts *cycles,
                                    saltus_equilibria **equilibria, saltus_message *message) {
    saltus_equilibria *e = calloc(1, sizeof *e);
    *equilibria = NULL;
    if (!e)
        return no_memory(message);
    saltus_rests *r = &e->rests;
    e->options = *options;
    e->cycles = cycles;
    e->here = &e->solutions[0];
    e->next = &e->solutions[1];
    e->trial = &e->solutions[2];
    e->spare = &e->solutions[3];
    r->family = (saltus_family){.spec = *spec, .parameters = 1, .unit = {options->high[0] - options->low[0]}};
    e->solver = gsl_root_fsolver_alloc(gsl_root_fsolver_brent);
    saltus_status status = e->solver ? SALTUS_OK : no_memory(message);
    const saltus_point_kind locus = options->locus;
    if (locus && locus != SALTUS_POINT_HB && locus != SALTUS_POINT_BE && locus != SALTUS_POINT_LP)
        status =
            saltus_fail(message, SALTUS_BAD_INPUT,
                        "locus = %s: the start is an equilibrium, whose curves are those of HB, BE and LP",
                        saltus_point_word(locus));
    if (status == SALTUS_OK)
        status =
            saltus_spec_direction(spec, options->key[0], &r->family.direction[0], &r->origin[0], message);
    if (status == SALTUS_OK)
        status = saltus_rests_open(r, message);
    for (int side = 0; side < 2; side++)
        e->range[side] = saltus_orbits_border(r->origin[0], r->family.unit[0],
                                              side ? options->high[0] : options->low[0], side);
    if (status == SALTUS_OK)
        status = check_unforced(e, message);
    if (status == SALTUS_OK && state)
        status = open_starts(e, state, message);
    if (status != SALTUS_OK) {
        saltus_equilibria_free(e);
        return status;
    }
    *equilibria = e;
    return status;
}

saltus_status saltus_equilibria_take_up(const saltus_spec *spec, const saltus_branch_options *options,
                                        unsigned contacts, const double *state, double parameter,
                                        double omega, saltus_starts *cycles, saltus_equilibria **equilibria,
                                        saltus_message *message) {
    saltus_status status = saltus_equilibria_new(spec, options, NULL, cycles, equilibria, message);
    if (status == SALTUS_OK)
        status = saltus_rest_locus_new(spec, options, contacts, state, parameter, -1, omega * omega,
                                       &(*equilibria)->locus, message);
    if (status != SALTUS_OK) {
        saltus_equilibria_free(*equilibria);
        *equilibria = NULL;
    }
    return status;
}

static void drop_queue(saltus_equilibria *e) {
    for (int k = e->queue_next; k < e->queue_count; k++)
        saltus_branch_point_clear(&e->queue[k]);
    e->queue_count = e->queue_next = 0;
}

void saltus_equilibria_free(saltus_equilibria *e) {
    if (!e)
        return;
    drop_queue(e);
    free(e->queue);
    saltus_starts_clear(&e->starts);
    for (int k = 0; k < e->visited_count; k++)
        free(e->visited[k].state);
    free(e->visited);
    for (int k = 0; k < 4; k++)
        saltus_rest_clear(&e->solutions[k]);
    saltus_rest_locus_free(e->locus);
    saltus_rests_close(&e->rests);
    if (e->solver)
        gsl_root_fsolver_free(e->solver);
    free(e);
}

static saltus_branch_point *queue_place(saltus_equilibria *e, saltus_message *message) {
    if (e->queue_count == e->queue_room) {
        int room = e->queue_room ? 2 * e->queue_room : 8;
        saltus_branch_point *grown = realloc(e->queue, (size_t)room * sizeof *grown);
        if (!grown) {
            no_memory(message);
            return NULL;
        }
        e->queue = grown;
        e->queue_room = room;
    }
    return &e->queue[e->queue_count];
}

/* Note a fold or a boundary equilibrium; the branch on which it was given out before, otherwise -1. */
static saltus_status note_visit(saltus_equilibria *e, saltus_point_kind kind, const saltus_rest *s,
                                int *earlier, saltus_message *message) {
    const double close_value = 1e-8 * e->rests.family.unit[0], close_state = 1e-5;
    const size_t n = (size_t)e->rests.n;
    *earlier = -1;
    for (int k = 0; k < e->visited_count; k++)
        if (e->visited[k].kind == kind && fabs(e->visited[k].value - s->value[0]) < close_value &&
            saltus_system_distance(e->rests.system, e->visited[k].state, s->state) < close_state) {
            *earlier = e->visited[k].branch;
            return SALTUS_OK;
        }
    visited *grown = realloc(e->visited, ((size_t)e->visited_count + 1) * sizeof *grown);
    if (grown)
        e->visited = grown;
    double *state = calloc(n, sizeof *state);
    if (!grown || !state) {
        free(state);
        return no_memory(message);
    }
    memcpy(state, s->state, n * sizeof *state);
    grown[e->visited_count++] = (visited){kind, e->number, s->value[0], state};
    return SALTUS_OK;
}

/* What is to be said of a point beside what its equilibrium tells. */
typedef struct notice {
    saltus_point_kind kind;
    double ahead, accuracy;
    const char *reason;      /* NULL: nothing */
    const char *after;       /* label beyond; NULL: none */
    const saltus_hopf *hopf; /* NULL: none */
    int face;                /* BE: that is met or left */
} notice;

/* An equilibrium goes into the queue; with EP the branch ends. */
static saltus_status give(saltus_equilibria *e, const saltus_rest *s, notice what, saltus_message *message) {
    saltus_branch_point *point = queue_place(e, message);
    int earlier = -1;
    if (!point)
        return SALTUS_NO_MEMORY;
    saltus_status status = saltus_rest_point(&e->rests, s, point, message);
    if (status != SALTUS_OK)
        return status;
    if (what.kind == SALTUS_POINT_LP || what.kind == SALTUS_POINT_BP || what.kind == SALTUS_POINT_HB)
        point->stable = false; /* there an eigenvalue is on the imaginary axis but for rounding */
    point->kind = what.kind;
    point->branch = e->number;
    point->parent = e->parent;
    point->step = e->regular;
    point->arclength = e->arclength + what.ahead;
    point->accuracy = what.accuracy + DBL_EPSILON * fabs(point->value[0]);
    snprintf(point->label_after, sizeof point->label_after, "%s", what.after ? what.after : "");
    snprintf(point->reason, sizeof point->reason, "%.150s", what.reason ? what.reason : "");
    if (what.hopf) {
        point->period = 2 * M_PI / what.hopf->omega;
        point->lyapunov_coefficient = what.hopf->coefficient;
    }
    if (what.kind == SALTUS_POINT_LP || what.kind == SALTUS_POINT_BE)
        status = note_visit(e, what.kind, s, &earlier, message);
    if (earlier >= 0) {
        point->kind = SALTUS_POINT_EP;
        snprintf(point->reason, sizeof point->reason,
                 earlier == e->number ? "the branch is closed: it has come back to this %s"
                                      : "this %s is on branch %d",
                 saltus_point_word(what.kind), earlier);
    } else if (what.kind == SALTUS_POINT_BE) {
        saltus_rest_touch(&e->rests, what.face, point);
    }
    if (point->kind != SALTUS_POINT_EP && e->made + 1 >= e->options.points) {
        point->kind = SALTUS_POINT_EP;
        snprintf(point->reason, sizeof point->reason, "%s", enough_points);
    }
    if (point->kind == SALTUS_POINT_EP)
        e->following = false;
    e->queue_count++;
    e->made++;
    return status;
}

static saltus_status end(saltus_equilibria *e, const saltus_rest *s, double ahead, const char *reason,
                         saltus_message *message) {
    return give(e, s, (notice){.kind = SALTUS_POINT_EP, .ahead = ahead, .accuracy = NAN, .reason = reason},
                message);
}

static void swap(saltus_rest **a, saltus_rest **b) {
    saltus_rest *kept = *a;
    *a = *b;
    *b = kept;
}

static bool crosses(double a, double c) {
    return isfinite(a) && isfinite(c) && a != 0 && a * c <= 0;
}

/* A place is put among others in the order of arclength. */
static int insert(place found, place *places, int count) {
    int k = count;
    for (; k > 0 && places[k - 1].zero.ahead > found.zero.ahead; k--)
        places[k] = places[k - 1];
    places[k] = found;
    return count + 1;
}

/* All special points between `here` and `next`, in order. */
static int find_places(saltus_equilibria *e, place *places) {
    static const struct {
        saltus_point_kind kind;
        saltus_rest_test test;
    } tests[] = {{SALTUS_POINT_LP, SALTUS_REST_FOLD},
                 {SALTUS_POINT_BP, SALTUS_REST_CROSSING},
                 {SALTUS_POINT_HB, SALTUS_REST_PAIRS}};
    enum { kinds = sizeof tests / sizeof tests[0] };
    int count = 0;
    for (int k = 0; k < kinds + e->options.value_count; k++) {
        place found = {.kind = k < kinds ? tests[k].kind : SALTUS_POINT_UZ};
        found.asked.test = k < kinds ? tests[k].test : SALTUS_REST_VALUE;
        if (k >= kinds)
            found.asked.target = e->options.values[k - kinds];
        const double near = saltus_rest_value(found.asked, e->here, e->here),
                     far = saltus_rest_value(found.asked, e->next, e->here);
        if ((k < kinds && e->fresh) || !crosses(near, far))
            continue;
        if (found.kind == SALTUS_POINT_BP)
            found.zero = saltus_rest_crossing(&e->rests, e->here, e->next->at.ahead * near / (near - far),
                                              e->next->at.ahead, e->trial);
        else
            found.zero = saltus_rest_zero(&e->rests, e->solver, found.asked, e->here, e->next, e->trial);
        if (found.zero.found)
            count = insert(found, places, count);
    }
    return count;
}

/* The left null vector of the equations at a branch point, where they have just been evaluated. */
static saltus_status find_left(const saltus_equations *q, double *left, saltus_message *message) {
    const int c = q->count;
    double value, *transposed = calloc((size_t)(c * c), sizeof *transposed);
    if (!transposed)
        return no_memory(message);
    for (int i = 0; i < c; i++)
        for (int j = 0; j < c; j++)
            transposed[j * c + i] = q->jacobian[i * q->unknowns + j];
    saltus_status status = saltus_dense_null_vectors(transposed, c, c, 1, left, &value);
    free(transposed);
    return status == SALTUS_OK ? status : saltus_fail(message, status, "no null vector at a branch point");
}

/* What is left of the equations along the left null vector, aside of `at` by parts of two directions. */
static double project(saltus_equilibria *e, const saltus_rest *at, const double *left, const double *across,
                      double by, const double *up, double high) {
    saltus_equations *q = &e->rests.equations;
    double sum = 0, u[SALTUS_STATE_MAX + SALTUS_FACES_MAX + 1];
    saltus_message ignored;
    for (int j = 0; j < q->unknowns; j++)
        u[j] = at->at.u[j] + by * across[j] + high * up[j];
    if (saltus_rests_noted(&e->rests, saltus_equations_evaluate(q, u, &ignored)) != SALTUS_OK)
        return NAN;
    for (int i = 0; i < q->count; i++)
        sum += left[i] * q->residual[i];
    return sum;
}

/* At a branch point two directions in the null plane make the terms of second order vanish: `old`, and the
 * one that becomes `leaving` (Keller 1977). `aside`: across the old one in the plane. */
static saltus_status find_leaving(saltus_equilibria *e, const saltus_rest *at, const double *old,
                                  const double *aside, double *leaving, saltus_message *message) {
    const double apart = 1e-3;
    const int m = at->at.unknowns;
    double left[SALTUS_STATE_MAX + SALTUS_FACES_MAX], mixed = 0, size = 0;
    saltus_status status = find_left(&e->rests.equations, left, message);
    if (status != SALTUS_OK)
        return status;
    for (int k = 0; k < 4; k++)
        mixed += (k == 0 || k == 3 ? 0.25 : -0.25) *
                 project(e, at, left, old, k & 1 ? apart : -apart, aside, k & 2 ? apart : -apart);
    const double square = project(e, at, left, old, 0, aside, apart) +
                          project(e, at, left, old, 0, aside, -apart) -
                          2 * project(e, at, left, old, 0, aside, 0);
    const bool known = fabs(mixed) > 1e-6 * apart * apart;
    for (int j = 0; j < m; j++) {
        leaving[j] = known ? 2 * mixed * aside[j] - square * old[j] : aside[j];
        size = hypot(size, leaving[j]);
    }
    for (int j = 0; j < m; j++)
        leaving[j] /= size;
    return SALTUS_OK;
}

/* The branches that leave at a branch point `at`; one of them where `at` is its own mirror image and they are
 * those of each other. */
static saltus_status leave(saltus_equilibria *e, const saltus_rest *at, saltus_message *message) {
    const int m = at->at.unknowns;
    saltus_branch_start start = {.parent = e->number, .depth = e->depth + 1, .origin = SALTUS_POINT_BP};
    double values[2], share[2] = {0, 0};
    double *plane = calloc(4 * (size_t)m + (size_t)e->rests.n + 1, sizeof *plane);
    double *old = plane + 2 * (ptrdiff_t)m, *aside = old + m;
    const double nothing[SALTUS_STATE_MAX] = {0};
    bool shift, mirrored = saltus_system_mirror_symmetric(e->rests.system, &shift) &&
                           saltus_system_distance(e->rests.system, at->state, nothing) < 1e-7;
    saltus_status status =
        plane ? saltus_equations_evaluate(&e->rests.equations, at->at.u, message) : no_memory(message);
    if (status == SALTUS_OK)
        status = saltus_null_plane(&e->rests.equations, plane, values, message);
    for (int j = 0; j < m && status == SALTUS_OK; j++)
        for (int k = 0; k < 2; k++)
            share[k] += plane[k * m + j] * e->here->at.tangent[j];
    const double length = hypot(share[0], share[1]);
    for (int j = 0; j < m && status == SALTUS_OK; j++) {
        old[j] = (share[0] * plane[j] + share[1] * plane[m + j]) / length;
        aside[j] = (share[1] * plane[j] - share[0] * plane[m + j]) / length;
    }
    start.tangent = aside + m;
    if (status == SALTUS_OK)
        status = find_leaving(e, at, old, aside, start.tangent, message);
    start.sequence = (saltus_sequence){.periods = 1, .cuts = 1, .contacts = at->contacts};
    start.parameter = at->parameter[0];
    start.state = at->state;
    start.unknowns = e->rests.n + 1; /* as many as an orbit's; those beyond m are none */
    for (int way = 0; way < (mirrored ? 1 : 2) && status == SALTUS_OK; way++) {
        status = saltus_starts_add(&e->starts, e->rests.n, &start, message);
        for (int j = 0; j < m; j++)
            start.tangent[j] = -start.tangent[j];
    }
    free(plane);
    return status == SALTUS_NO_CONVERGENCE ? SALTUS_OK : status;
}

/* A locus begins at `at`: the points on the way to it are not wanted. */
static saltus_status open_locus(saltus_equilibria *e, const saltus_rest *at, int face, double omega,
                                saltus_message *message) {
    saltus_message why = {.text = ""};
    /* A face that is only touched is none that holds. */
    const unsigned contacts = face < 0 ? at->contacts : at->contacts & ~(1u << face);
    drop_queue(e);
    saltus_status status = saltus_rest_locus_new(&e->rests.family.spec, &e->options, contacts, at->state,
                                                 at->parameter[0], face, omega * omega, &e->locus, &why);
    return status == SALTUS_OK
               ? status
               : saltus_fail(message, status, "no curve of %s points can be begun at %s = %.12g: %.200s",
                             saltus_point_word(e->options.locus), e->options.key[0], at->value[0], why.text);
}

/* What a Hopf point says of the cycles that are born there. */
static void tell_hopf(const saltus_hopf *hopf, char *text, size_t room) {
    const char *what = !(fabs(hopf->coefficient) > hopf->error) ? "criticality not decided"
                       : hopf->coefficient < 0                  ? "supercritical"
                                                                : "subcritical";
    snprintf(text, room, "%s: omega = %.12g, first Lyapunov coefficient %.9g +- %.0e", what, hopf->omega,
             hopf->coefficient, hopf->error);
}

/* A Hopf point at `at`; two real eigenvalues of opposite signs are none. */
static saltus_status give_hopf(saltus_equilibria *e, const saltus_rest *at, notice what,
                               saltus_message *message) {
    const double on_axis = 1e-6;
    saltus_hopf hopf = {0};
    saltus_message why = {.text = ""};
    char reason[SALTUS_REASON_MAX];
    bool pair = false;
    for (int k = 0; k < at->rate_count; k++)
        pair = pair || (at->rates[k].im > 0 && fabs(at->rates[k].re) < on_axis * at->rates[k].im);
    if (!pair)
        return SALTUS_OK;
    saltus_status status = saltus_hopf_find(&e->rests, at, &hopf, &why);
    if (status == SALTUS_NO_MEMORY)
        return no_memory(message);
    if (status != SALTUS_OK)
        return give(e, at, what, message);
    if (e->options.locus == SALTUS_POINT_HB) {
        status = open_locus(e, at, -1, hopf.omega, message);
        free(hopf.vector);
        return status;
    }
    tell_hopf(&hopf, reason, sizeof reason);
    what.reason = reason;
    what.hopf = &hopf;
    status = give(e, at, what, message);
    const saltus_branch_start like = {.parent = e->number, .depth = e->depth + 1};
    if (status == SALTUS_OK && e->following && e->depth < e->options.switches)
        status = saltus_hopf_leave(&e->rests, at, &hopf, &like, e->cycles, message);
    free(hopf.vector);
    return status;
}

/* All special points of the step from `here` to `next`. */
static saltus_status give_specials(saltus_equilibria *e, saltus_message *message) {
    place places[SALTUS_BRANCH_VALUES_MAX + 3];
    int count = find_places(e, places);
    saltus_status status = SALTUS_OK;
    for (int k = 0; k < count && status == SALTUS_OK && e->following && !e->locus; k++) {
        const place *p = &places[k];
        notice what = {.kind = p->kind, .ahead = p->zero.ahead, .accuracy = p->zero.accuracy};
        saltus_message ignored;
        if (p->kind == SALTUS_POINT_BP) {
            saltus_zero there =
                saltus_rest_crossing(&e->rests, e->here, p->zero.ahead, e->next->at.ahead, e->trial);
            if (!there.found)
                continue;
        } else if (saltus_rest_visit(&e->rests, e->here, p->zero.ahead, e->trial, &ignored) != SALTUS_OK) {
            continue;
        }
        if (p->kind == SALTUS_POINT_UZ)
            e->trial->value[0] = p->asked.target;
        if (p->kind == SALTUS_POINT_HB)
            status = give_hopf(e, e->trial, what, message);
        else if (p->kind == SALTUS_POINT_LP && e->options.locus == SALTUS_POINT_LP)
            status = open_locus(e, e->trial, -1, 0, message);
        else
            status = give(e, e->trial, what, message);
        if (status == SALTUS_OK && p->kind == SALTUS_POINT_BP && e->following &&
            e->depth < e->options.switches)
            status = leave(e, e->trial, message);
    }
    return status;
}

/* The face that is met or left first between `here` and `next`, its equilibrium to `trial`; -1: none. */
static int find_breach(saltus_equilibria *e, saltus_zero *first) {
    int face = -1;
    first->ahead = INFINITY;
    for (int f = 0; f < e->rests.system->face_count; f++) {
        const saltus_rest_asked asked = {.test = SALTUS_REST_BREACH, .face = f};
        if (!(e->next->breach[f] > 0))
            continue;
        saltus_zero zero = saltus_rest_zero(&e->rests, e->solver, asked, e->here, e->next, e->trial);
        if (zero.found && zero.ahead < first->ahead) {
            *first = zero;
            face = f;
        }
    }
    return face;
}

/* `spare` becomes the equilibrium `at` with other contacts, with a tangent along which the face's gap closes
 * no further and its contact force pushes. False where there is none. */
static bool change_contact(saltus_equilibria *e, const saltus_rest *at, int face, saltus_message *message) {
    const double apart = 1e-5;
    saltus_rests *r = &e->rests;
    saltus_rest *s = e->spare;
    saltus_status status =
        saltus_rests_shape(r, at->contacts ^ 1u << face, at->state, at->parameter, message);
    if (status == SALTUS_OK && !saltus_curve_reserve(&s->at, r->equations.unknowns))
        status = no_memory(message);
    if (status == SALTUS_OK)
        status = saltus_rests_fill(r, at->parameter, at->state, s->at.u, message);
    if (status == SALTUS_OK)
        status = saltus_equations_evaluate(&r->equations, s->at.u, message);
    if (status == SALTUS_OK)
        status = saltus_curve_orient(&r->equations, NULL, &s->at, message);
    if (status == SALTUS_OK)
        status = saltus_rest_see(r, s, message);
    s->at.ahead = 0;
    s->at.iterations = 0;
    if (status == SALTUS_OK)
        status = saltus_rest_visit(r, s, apart, e->trial, message);
    if (saltus_rests_noted(r, status) != SALTUS_OK)
        return false;
    if (e->trial->breach[face] > 0)
        saltus_curve_turn(&s->at);
    return true;
}

/* The cycles that begin where `next` touches a face, beyond which the equilibria go on at `spare`. */
static saltus_status find_born(saltus_equilibria *e, int face, bool leaves, saltus_starts *born,
                               saltus_message *message) {
    const saltus_branch_start like = {.parent = e->number, .depth = e->depth + 1};
    const saltus_rest *free_one = leaves ? e->spare : e->next;
    saltus_rests *r = &e->rests;
    saltus_status status =
        saltus_rests_shape(r, free_one->contacts, free_one->state, free_one->parameter, message);
    if (status == SALTUS_OK)
        status = saltus_boundary_leave(r, free_one, face, &like, e->trial, born, message);
    saltus_message ignored;
    if (status == SALTUS_OK && !leaves)
        saltus_rests_noted(
            r, saltus_rests_shape(r, e->spare->contacts, e->spare->state, e->spare->parameter, &ignored));
    return status;
}

/* The equilibrium `at` on the way meets a stop or leaves it: the branch goes on with other contacts. */
static saltus_status meet(saltus_equilibria *e, int face, saltus_zero zero, saltus_message *message) {
    const saltus_face f = e->rests.system->faces[face];
    saltus_message why = {.text = ""};
    char reason[SALTUS_REASON_MAX];
    const double heading = e->next->at.tangent[e->next->at.unknowns - 1];
    const bool leaves = e->next->contacts >> face & 1;
    if (e->options.locus == SALTUS_POINT_BE)
        return open_locus(e, e->next, face, 0, message);
    bool goes_on = change_contact(e, e->next, face, &why);
    const double onward = goes_on ? e->spare->at.tangent[e->spare->at.unknowns - 1] : 0;
    saltus_starts born = {.count = 0};
    saltus_status status = goes_on ? find_born(e, face, leaves, &born, message) : SALTUS_OK;
    int length = snprintf(reason, sizeof reason, "%s stop %d %s%s", leaves ? "leaves" : "meets", f.stop + 1,
                          f.side > 0 ? "upper" : "lower",
                          !goes_on               ? "; beyond it no equilibrium was found"
                          : heading * onward < 0 ? "; the branch turns back (non-smooth fold)"
                                                 : "");
    if (born.count)
        snprintf(reason + length, sizeof reason - (size_t)length,
                 "; %s with one impact of period %.9g begins towards %s %s",
                 born.count > 1 ? "cycles, the first" : "a cycle", 2 * M_PI / born.start[0].sequence.omega,
                 born.start[0].heading > 0 ? "larger" : "smaller", e->options.key[0]);
    if (status == SALTUS_OK)
        status = give(e, e->next,
                      (notice){.kind = SALTUS_POINT_BE,
                               .ahead = zero.ahead,
                               .accuracy = zero.accuracy,
                               .reason = reason,
                               .after = goes_on ? saltus_rest_label(e->spare->contacts) : NULL,
                               .face = face},
                      message);
    for (int k = 0; k < born.count && status == SALTUS_OK && e->following; k++)
        if (e->depth < e->options.switches)
            status = saltus_starts_add(e->cycles, e->rests.n, &born.start[k], message);
    saltus_starts_clear(&born);
    if (status != SALTUS_OK || !e->following)
        return status;
    if (!goes_on)
        return end(e, e->next, zero.ahead, why.text, message);
    e->arclength += zero.ahead;
    e->shown = e->arclength;
    e->step = fmin(e->step, e->options.step);
    swap(&e->here, &e->spare);
    return status;
}

/* Whether more than one Hopf point may lie between `here` and `next`, or one that the test does not show: as
 * many eigenvalues have changed sides. */
static bool hides_pairs(const saltus_equilibria *e) {
    const saltus_rest_asked asked = {.test = SALTUS_REST_PAIRS};
    const int changed = abs(e->next->unstable - e->here->unstable);
    const bool shown =
        crosses(saltus_rest_value(asked, e->here, e->here), saltus_rest_value(asked, e->next, e->here));
    return changed >= 4 || (changed >= 2 && !shown);
}

/* One step along the branch under way. */
static saltus_status advance(saltus_equilibria *e, saltus_message *message) {
    const double finest = 1e-4;
    saltus_rests *r = &e->rests;
    const saltus_curve_bound bound = {r->equations.count, e->range[0], e->range[1]};
    saltus_zero zero = {.accuracy = NAN};
    saltus_message why = {.text = ""};
    int reached;
    saltus_status status =
        saltus_curve_step(&r->equations, &e->here->at, &e->step, &bound, 1, &e->next->at, &reached, &why);
    if (status == SALTUS_OK)
        status = saltus_rest_see(r, e->next, &why);
    if (status == SALTUS_NO_MEMORY)
        return no_memory(message);
    if (status != SALTUS_OK)
        return end(e, e->here, 0, why.text, message);
    if (hides_pairs(e) && e->next->at.ahead > finest) {
        e->step = 0.5 * e->next->at.ahead;
        return SALTUS_OK;
    }
    int face = find_breach(e, &zero);
    if (face >= 0) {
        if (saltus_rest_visit(r, e->here, zero.ahead, e->next, &why) != SALTUS_OK)
            return end(e, e->here, 0, why.text, message);
        reached = -1;
    }
    status = give_specials(e, message);
    if (status != SALTUS_OK || !e->following || e->locus)
        return status;
    e->fresh = false;
    if (face >= 0)
        return meet(e, face, zero, message);
    e->step = saltus_curve_next_step(e->step, e->next->at.iterations, e->options.step_max);
    if (reached >= 0) {
        e->next->value[0] = e->next->parameter[0] == e->range[1] ? e->options.high[0] : e->options.low[0];
        return end(e, e->next, e->next->at.ahead, range_ends, message);
    }
    e->arclength += e->next->at.ahead;
    if (e->arclength - e->shown >= 0.02 * e->options.step_max || e->regular == 0) {
        const double ahead = e->next->at.ahead;
        e->arclength -= ahead;
        status = give(e, e->next, (notice){.ahead = ahead, .accuracy = NAN}, message);
        e->arclength += ahead;
        e->shown = e->arclength;
        e->regular++;
    }
    swap(&e->here, &e->next);
    saltus_curve_bend(&e->next->at, &e->here->at);
    return status;
}

/* The first point of a branch: regular, with what was asked for at its value. */
static saltus_status give_first(saltus_equilibria *e, int heading, saltus_message *message) {
    saltus_status status = give(e, e->here, (notice){.accuracy = NAN}, message);
    e->regular = 1;
    for (int k = 0; k < e->options.value_count && status == SALTUS_OK && e->following; k++)
        if (e->options.values[k] == e->here->value[0])
            status = give(e, e->here, (notice){.kind = SALTUS_POINT_UZ}, message);
    if (status == SALTUS_OK && heading && e->following && e->here->parameter[0] == e->range[heading > 0])
        status = end(e, e->here, 0, range_ends, message);
    return status;
}

static saltus_status begin_at(saltus_equilibria *e, const saltus_branch_start *start,
                              saltus_message *message) {
    saltus_rests *r = &e->rests;
    saltus_curve_point *at = &e->here->at;
    saltus_message why = {.text = ""};
    e->number = e->cycles->begun++;
    e->parent = start->parent;
    e->depth = start->depth;
    e->regular = e->made = 0;
    e->arclength = e->shown = 0;
    e->step = e->options.step;
    e->fresh = start->tangent != NULL;
    e->following = true;
    saltus_status status =
        saltus_rests_shape(r, start->sequence.contacts, start->state, &start->parameter, &why);
    if (status == SALTUS_OK && !saltus_curve_reserve(at, r->equations.unknowns))
        status = no_memory(message);
    if (status == SALTUS_OK)
        status = saltus_rests_fill(r, &start->parameter, start->state, at->u, &why);
    at->iterations = 0;
    if (status == SALTUS_OK && !start->tangent)
        status = saltus_newton(&r->equations, at->u, NULL, NULL, true, &at->iterations, &why);
    else if (status == SALTUS_OK)
        status = saltus_equations_evaluate(&r->equations, at->u, &why);
    if (status == SALTUS_OK && start->tangent) {
        memcpy(at->tangent, start->tangent, (size_t)at->unknowns * sizeof *at->tangent);
        at->crossing.mantissa = NAN; /* zero but for rounding */
        at->residual = r->equations.size;
    } else if (status == SALTUS_OK) {
        status = saltus_curve_orient(&r->equations, NULL, at, &why);
    }
    at->ahead = 0;
    at->bent = false;
    if (status == SALTUS_OK && !start->tangent && at->tangent[at->unknowns - 1] * start->heading < 0)
        saltus_curve_turn(at);
    if (status == SALTUS_OK)
        status = saltus_rest_see(r, e->here, &why);
    if (status == SALTUS_OK)
        return give_first(e, start->tangent ? 0 : start->heading, message);
    e->following = false;
    return saltus_fail(message, status, "no branch of equilibria can be begun: %.300s", why.text);
}

bool saltus_equilibria_rests(const saltus_equilibria *e) {
    return e->queue_next == e->queue_count && (!e->locus || saltus_rest_locus_rests(e->locus));
}

saltus_status saltus_equilibria_step(saltus_equilibria *e, saltus_branch_point *point, bool *more,
                                     saltus_message *message) {
    saltus_status status = SALTUS_OK;
    *more = true;
    while (status == SALTUS_OK && e->queue_next == e->queue_count && !e->locus) {
        e->queue_next = e->queue_count = 0;
        if (e->following) {
            status = advance(e, message);
        } else if (e->starts.count > 0) {
            saltus_branch_start start = saltus_starts_take(&e->starts);
            status = begin_at(e, &start, message);
            saltus_start_clear(&start);
        } else if (e->options.locus) {
            return saltus_fail(message, SALTUS_NO_CONVERGENCE, "no %s point was found along %s = %g to %g",
                               saltus_point_word(e->options.locus), e->options.key[0], e->options.low[0],
                               e->options.high[0]);
        } else {
            *more = false;
            return status;
        }
        if (e->rests.starved)
            return no_memory(message);
        /* While the first point of a locus is sought, the points on the way are not wanted. */
        if (e->options.locus)
            drop_queue(e);
    }
    if (status != SALTUS_OK)
        return status;
    if (e->locus)
        return saltus_rest_locus_step(e->locus, point, more, message);
    *point = e->queue[e->queue_next++];
    return status;
}

static void archive_visited(saltus_equilibria *e, saltus_archive *a) {
    size_t count = saltus_archive_length(a, (size_t)e->visited_count, 4);
    if (a->reading && a->sound) {
        e->visited = calloc(count + 1, sizeof *e->visited);
        a->starved = a->starved || !e->visited;
        e->visited_count = e->visited ? (int)count : 0;
    }
    for (int k = 0; k < e->visited_count; k++) {
        visited *v = &e->visited[k];
        v->kind = (saltus_point_kind)saltus_archive_whole(a, v->kind, 0, SALTUS_POINT_KINDS - 1);
        v->branch = (int)saltus_archive_whole(a, v->branch, 0, INT_MAX);
        saltus_archive_finite(a, &v->value, 1);
        saltus_archive_array(a, &v->state, (size_t)a->n);
    }
}

/* The equations become those of the equilibrium that was read, whose contacts are known. */
static saltus_status restore(saltus_equilibria *e, saltus_archive *a, saltus_message *message) {
    saltus_rests *r = &e->rests;
    const saltus_curve_point *at = &e->here->at;
    const int held = saltus_count_bits(e->here->contacts);
    double state[SALTUS_STATE_MAX] = {0};
    a->sound = a->sound && at->unknowns == r->width + held + 1;
    if (!a->sound)
        return SALTUS_OK;
    for (int i = 0; i < r->width; i++)
        state[i < r->dof ? i : i + r->dof] = at->u[i] * r->state_scale[i < r->dof ? i : i + r->dof];
    saltus_status status = saltus_rests_shape(r, e->here->contacts, state, at->u + r->width + held, message);
    if (status != SALTUS_OK)
        return status;
    saltus_archive_finite(a, r->row_scale, (size_t)r->width);
    for (int i = 0; i < r->width; i++)
        a->sound = a->sound && r->row_scale[i] > 0;
    return a->sound ? saltus_rest_see(r, e->here, message) : SALTUS_OK;
}

saltus_status saltus_equilibria_archive(saltus_equilibria *e, saltus_archive *a, saltus_message *message) {
    saltus_rests *r = &e->rests;
    saltus_status status = SALTUS_OK;
    if (saltus_archive_flag(a, e->locus != NULL)) {
        if (a->reading)
            status =
                saltus_rest_locus_new(&r->family.spec, &e->options, 0, NULL, 0, -1, 0, &e->locus, message);
        return status == SALTUS_OK ? saltus_rest_locus_archive(e->locus, a, message) : status;
    }
    saltus_archive_starts(a, &e->starts);
    archive_visited(e, a);
    e->number = (int)saltus_archive_whole(a, e->number, 0, INT_MAX);
    e->parent = (int)saltus_archive_whole(a, e->parent, -1, INT_MAX);
    e->depth = (int)saltus_archive_whole(a, e->depth, 0, INT_MAX);
    e->regular = (int)saltus_archive_whole(a, e->regular, 0, INT_MAX);
    e->made = (int)saltus_archive_whole(a, e->made, 0, INT_MAX);
    saltus_archive_finite(a, &e->arclength, 1);
    saltus_archive_finite(a, &e->shown, 1);
    saltus_archive_finite(a, &e->step, 1);
    e->fresh = saltus_archive_flag(a, e->fresh);
    e->following = saltus_archive_flag(a, e->following);
    if (!e->following)
        return status;
    e->here->contacts = (unsigned)saltus_archive_whole(a, e->here->contacts, 0, (1LL << a->faces) - 1);
    saltus_archive_point(a, &e->here->at);
    if (a->reading)
        return restore(e, a, message);
    saltus_archive_finite(a, r->row_scale, (size_t)r->width);
    return status;
}
