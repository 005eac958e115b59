/* Equilibria: Newton's method on the vector field with given contacts.
 *
 * With contacts C the unknowns are the state x and the contact forces; the equations are f(x) - push force =
 * 0 and zero gaps of C. They are regular if the equilibrium is isolated, also on a stop. The Jacobian is the
 * flow's own linear part. A step is shortened until the next one, computed with the old Jacobian, would be
 * smaller (natural monotonicity test; Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 3.3).
 * Which contacts hold is a complementarity problem: starting from the faces that the guess touches, a contact
 * whose force pulls is dropped and a face that is passed is added. If that cycles or Newton's method fails,
 * all other sets are tried, small ones first.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/equilibrium.h"

#include "base/bits.h"
#include "base/dense.h"
#include "base/memory.h"
#include "orbit/held.h"
#include "saltus/flow.h"
#include "system/system.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Gaps and forces below this fraction of the terms they are sums of count as zero. */
static const double nothing = 1e-13;

/* Newton's iterate and work space. The unknowns are n states and a force per face, zero for free faces. */
typedef struct newton {
    saltus_arena arena;
    const saltus_system *system;
    saltus_flow *flow; /* n tangent columns */
    saltus_dense_lu lu;
    int n, unknowns, iterations;
    unsigned contacts; /* contacts that hold */
    double state[SALTUS_STATE_MAX], trial[SALTUS_STATE_MAX], field[SALTUS_STATE_MAX];
    /* The last step, and what the next would be: states, then forces (not increments). */
    double step[SALTUS_STATE_MAX + SALTUS_FACES_MAX], next[SALTUS_STATE_MAX + SALTUS_FACES_MAX];
    double size;      /* size of the last step, relative to the system's scales */
    double *jacobian; /* by columns */
    double *matrix, *basis, *product;
} newton;

saltus_equilibrium_options saltus_equilibrium_defaults(void) {
    return (saltus_equilibrium_options){.iterations = 50, .tolerance = 1e-12};
}

/* Evaluate the field and its Jacobian at a state with given contacts. */
static saltus_status evaluate(newton *w, const double *state, unsigned contacts, saltus_message *message) {
    saltus_status status = saltus_flow_place(w->flow, 0, (saltus_time){0, 0}, state, contacts, message);
    if (status == SALTUS_OK) {
        saltus_flow_field(w->flow, 0, w->field);
        saltus_flow_tangent_field(w->flow, 0, w->jacobian);
    }
    return status;
}

/* Factor the matrix [J, -push; n, 0] of the state just evaluated, with an identity row for each free face. */
static bool factor(newton *w) {
    int n = w->n, dof = w->system->dof, all = w->unknowns;
    memset(w->matrix, 0, (size_t)(all * all) * sizeof *w->matrix);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            w->matrix[i * all + j] = w->jacobian[j * n + i];
    for (int f = 0, row = n; row < all; f++, row++) {
        saltus_face face = w->system->faces[f];
        bool holds = w->contacts >> f & 1;
        w->matrix[row * all + row] = !holds;
        for (int i = 0; i < dof && holds; i++) {
            w->matrix[(dof + i) * all + row] = -face.side * w->system->stop_impulse[face.stop][i];
            w->matrix[row * all + i] = face.side * w->system->stop_normal[face.stop][i];
        }
    }
    return saltus_dense_factor(&w->lu, w->matrix) && w->lu.reciprocal > 10 * DBL_EPSILON;
}

/* Newton's step from the state just evaluated, with the last factorisation. Returns the largest change of a
 * state entry relative to the system's scales. */
static double find_step(newton *w, const double *state, double *step) {
    const double *scale = saltus_system_scale(w->system);
    double largest = 0;
    for (int i = 0; i < w->n; i++)
        step[i] = -w->field[i];
    for (int f = 0; f < w->system->face_count; f++)
        step[w->n + f] = w->contacts >> f & 1 ? -saltus_system_gap(w->system, f, state) : 0;
    saltus_dense_resolve(&w->lu, false, 1, step);
    for (int i = 0; i < w->n; i++)
        largest = fmax(largest, fabs(step[i]) / scale[i]);
    return isfinite(largest) ? largest : INFINITY;
}

/* Newton's method from a guess with given contacts. Each step is shortened to the longest part of it after
 * which the next step would be smaller. */
static saltus_status solve(newton *w, const double *guess, unsigned contacts,
                           const saltus_equilibrium_options *options, saltus_message *message) {
    enum { halvings_max = 12 };
    int dof = w->system->dof;
    w->contacts = contacts;
    for (int i = 0; i < w->n; i++)
        w->state[i] = i >= dof && i < 2 * dof ? 0 : guess[i];
    saltus_status status = evaluate(w, w->state, 0, message);
    for (int k = 0; k < options->iterations && status == SALTUS_OK; k++) {
        double part = 1;
        w->iterations++;
        if (!factor(w))
            return saltus_fail(message, SALTUS_SINGULAR,
                               "Newton's matrix is singular: the equilibrium is not isolated");
        w->size = find_step(w, w->state, w->step);
        bool smaller = false;
        for (int h = 0; h < halvings_max && status == SALTUS_OK && !smaller; h++, part /= 2) {
            for (int i = 0; i < w->n; i++)
                w->trial[i] = i >= dof && i < 2 * dof ? 0 : w->state[i] + part * w->step[i];
            status = evaluate(w, w->trial, 0, message);
            smaller = status == SALTUS_OK && find_step(w, w->trial, w->next) <= (1 - part / 4) * w->size;
        }
        if (smaller)
            memcpy(w->state, w->trial, (size_t)w->n * sizeof *w->state);
        if (status == SALTUS_OK && w->size <= options->tolerance)
            return SALTUS_OK;
        if (!smaller)
            break;
    }
    return status != SALTUS_OK
               ? status
               : saltus_fail(message, SALTUS_NO_CONVERGENCE,
                             "Newton's iteration for the equilibrium stops at a step of %.3g", w->size);
}

/* The contacts to try next: the same set if all contacts push and no stop is passed. */
static unsigned corrected_contacts(const newton *w) {
    const saltus_system *system = w->system;
    int n = w->n, dof = system->dof, pulling = -1, passed = -1;
    double strongest = INFINITY, farthest = 0;
    for (int f = 0; f < system->face_count; f++) {
        const double *normal = system->stop_normal[system->faces[f].stop];
        double terms = 0; /* sum of the moduli of a contact force's terms */
        for (int i = 0; i < dof; i++)
            for (int j = 0; j < n; j++)
                terms += fabs(normal[i] * w->jacobian[j * n + dof + i] * w->state[j]);
        double force = w->step[n + f] - nothing * terms;
        double gap = saltus_system_gap(system, f, w->state) -
                     10 * nothing * saltus_system_gap_size(system, f, w->state);
        if (w->contacts >> f & 1) {
            if (force <= 0 && force < strongest) {
                strongest = force;
                pulling = f;
            }
        } else if (gap > farthest) {
            farthest = gap;
            passed = f;
        }
    }
    return pulling >= 0  ? w->contacts & ~(1u << pulling)
           : passed >= 0 ? w->contacts | 1u << passed
                         : w->contacts;
}

static bool is_among(const unsigned *sets, int count, unsigned set) {
    while (count > 0 && sets[count - 1] != set)
        count--;
    return count > 0;
}

/* Contacts can hold together if they are at most as many as displacements, one side of each stop. */
static bool can_hold(const saltus_system *system, unsigned contacts) {
    bool can = saltus_count_bits(contacts) <= system->dof;
    for (int f = 1; f < system->face_count; f++)
        can = can && !(system->faces[f].stop == system->faces[f - 1].stop && (contacts >> (f - 1) & 3) == 3);
    return can;
}

/* Solve with the contacts that the guess and then each solution suggest, as long as these are new, then with
 * all other sets, small ones first. If none succeeds, the message is that of the first attempt. */
static saltus_status search(newton *w, const double *guess, const saltus_equilibrium_options *options,
                            saltus_message *message) {
    enum { followed_most = 64 };
    const unsigned all = (1u << w->system->face_count) - 1;
    unsigned followed[followed_most], set = 0;
    int count = 0;
    saltus_status first = SALTUS_OK;
    /* Faces that the guess touches or passes, within a tolerance. */
    for (int f = 0; f < w->system->face_count; f++)
        if (saltus_system_gap(w->system, f, guess) > -1e-9 * saltus_system_gap_size(w->system, f, guess))
            set |= 1u << f;
    while (count < followed_most && !is_among(followed, count, set)) {
        const saltus_status status = solve(w, guess, set, options, count ? NULL : message);
        const unsigned next = status == SALTUS_OK ? corrected_contacts(w) : set;
        if (status == SALTUS_OK && next == set)
            return SALTUS_OK;
        first = count ? first : status;
        followed[count++] = set;
        set = next;
    }
    for (set = 0; set <= all; set = set == all ? all + 1 : saltus_next_subset(all, set))
        if (can_hold(w->system, set) && !is_among(followed, count, set) &&
            solve(w, guess, set, options, NULL) == SALTUS_OK && corrected_contacts(w) == set)
            return SALTUS_OK;
    return first == SALTUS_OK
               ? saltus_fail(message, SALTUS_NO_CONVERGENCE,
                             "no set of contacts gives an equilibrium whose contact forces push")
               : first;
}

/* Tell what has been found, with stability and eigenvalues of the motion that keeps the contacts, from the
 * Jacobian with them held. */
static saltus_status describe(newton *w, saltus_equilibrium *out, saltus_message *message) {
    const saltus_system *system = w->system;
    int rows = 0;
    out->contacts = w->contacts;
    out->iterations = w->iterations;
    out->residual = w->size;
    memcpy(out->state, w->state, (size_t)w->n * sizeof *out->state);
    for (int f = 0; f < system->face_count; f++) {
        bool holds = w->contacts >> f & 1;
        out->contact_force[f] = holds ? w->step[w->n + f] / saltus_system_compliance(system, f) : 0;
        out->gap[f] = holds ? 0 : saltus_system_gap(system, f, w->state);
    }
    saltus_status status = evaluate(w, w->state, w->contacts, message);
    if (status == SALTUS_OK && !saltus_held_basis(system, w->contacts, w->basis, w->matrix, &rows))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the equilibrium");
    saltus_held_reduce(w->basis, rows, w->n, w->jacobian, w->product, w->matrix);
    if (status == SALTUS_OK)
        status = saltus_held_eigenvalues(w->matrix, rows, out->eigenvalues, message);
    if (status != SALTUS_OK)
        return status;
    const saltus_growing counts = saltus_eigenvalues_growing(out->eigenvalues, rows);
    out->eigenvalue_count = rows;
    out->instability = counts.growing;
    out->stable = counts.decaying == rows;
    return SALTUS_OK;
}

saltus_status saltus_equilibrium_find(const saltus_system *system, const double *guess,
                                      const saltus_equilibrium_options *options,
                                      saltus_equilibrium *equilibrium, saltus_message *message) {
    int n = saltus_system_dimension(system);
    newton w = {.system = system, .n = n, .unknowns = n + system->face_count};
    saltus_flow_options flow_options = saltus_flow_defaults();
    *equilibrium = (saltus_equilibrium){.dimension = n};
    if (saltus_system_forced(system))
        return saltus_fail(message, SALTUS_BAD_INPUT, "the scene is forced: it has no equilibria");
    for (int i = 0; i < n; i++)
        if (!isfinite(guess[i]))
            return saltus_fail(message, SALTUS_BAD_INPUT, "guess: entry %d is not a finite number", i + 1);
    const size_t size = (size_t)n, unknowns = (size_t)w.unknowns;
    do {
        w.jacobian = saltus_arena_doubles(&w.arena, size * size);
        w.basis = saltus_arena_doubles(&w.arena, size * size);
        w.product = saltus_arena_doubles(&w.arena, size * size);
        w.matrix = saltus_arena_doubles(&w.arena, unknowns * unknowns);
    } while (saltus_arena_again(&w.arena));
    bool room = w.arena.base && saltus_dense_lu_open(&w.lu, w.unknowns);
    equilibrium->state = calloc((size_t)n, sizeof *equilibrium->state);
    equilibrium->eigenvalues = calloc((size_t)n, sizeof *equilibrium->eigenvalues);
    saltus_status status = room && equilibrium->state && equilibrium->eigenvalues
                               ? saltus_flow_single(system, n, &flow_options, &w.flow, message)
                               : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the equilibrium");
    if (status == SALTUS_OK)
        status = search(&w, guess, options, message);
    if (status == SALTUS_OK)
        status = describe(&w, equilibrium, message);
    saltus_dense_lu_close(&w.lu);
    saltus_flow_free(w.flow);
    saltus_arena_close(&w.arena);
    if (status != SALTUS_OK)
        saltus_equilibrium_clear(equilibrium);
    return status;
}

void saltus_equilibrium_clear(saltus_equilibrium *equilibrium) {
    free(equilibrium->state);
    free(equilibrium->eigenvalues);
    *equilibrium = (saltus_equilibrium){0};
}
