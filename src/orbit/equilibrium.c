/* Equilibria: Newton's method on the vector field with given contacts.
 *
 * With contacts C the unknowns are the state x and the contact forces, and the equations f(x) - push force =
 * 0, gap of C = 0: regular wherever the equilibrium is isolated, on a stop too. The Jacobian is the flow's
 * own linear part. Steps are shortened until the next one, by the old Jacobian, would be smaller (the natural
 * monotonicity test; Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 3.3). Which contacts
 * hold is a complementarity problem: from the faces that the guess touches, a force that pulls gives its
 * contact up, a gap that is passed makes one; where that goes in circles or Newton fails all sets are tried,
 * small ones first.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/equilibrium.h"

#include "base/bits.h"
#include "base/dense.h"
#include "base/memory.h"
#include "saltus/flow.h"
#include "system/system.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { sets_max = 1 << SALTUS_FACES_MAX };

/* Beside the sums of terms that they come from, gaps, forces and real parts below this are zero. */
static const double nothing = 1e-13;

/* The search: n states and at most SALTUS_FACES_MAX contact forces. */
typedef struct rest {
    saltus_arena arena;
    const saltus_system *system;
    saltus_flow *flow; /* n tangent columns */
    saltus_dense_lu lu;
    int n, room, iterations;
    unsigned contacts;
    double *state, *trial, *step, *next; /* `step` and `next` carry the forces behind the states */
    double *field, *columns, *matrix, *basis, *product;
    double force[SALTUS_FACES_MAX]; /* by face: n.f */
    double last;                    /* size of the last step */
} rest;

saltus_equilibrium_options saltus_equilibrium_defaults(void) {
    return (saltus_equilibrium_options){.iterations = 50, .tolerance = 1e-12};
}

static void reserve(rest *r) {
    size_t n = (size_t)r->n, room = (size_t)r->room;
    r->state = saltus_arena_doubles(&r->arena, n);
    r->trial = saltus_arena_doubles(&r->arena, n);
    r->field = saltus_arena_doubles(&r->arena, n);
    r->step = saltus_arena_doubles(&r->arena, room);
    r->next = saltus_arena_doubles(&r->arena, room);
    r->columns = saltus_arena_doubles(&r->arena, n * n);
    r->basis = saltus_arena_doubles(&r->arena, n * n);
    r->product = saltus_arena_doubles(&r->arena, n * n);
    r->matrix = saltus_arena_doubles(&r->arena, room * room);
}

/* Field at a state with given contacts, and its Jacobian by columns. */
static saltus_status evaluate(rest *r, const double *state, unsigned contacts, saltus_message *message) {
    saltus_status status = saltus_flow_place(r->flow, 0, (saltus_time){0, 0}, state, contacts, message);
    if (status == SALTUS_OK) {
        saltus_flow_field(r->flow, 0, r->field);
        saltus_flow_tangent_field(r->flow, 0, r->columns);
    }
    return status;
}

/* The equations' values at the state just evaluated, with the forces' part left to the unknowns. */
static void residual(const rest *r, const double *state, double *out) {
    int row = r->n;
    for (int i = 0; i < r->n; i++)
        out[i] = -r->field[i];
    for (int f = 0; f < r->system->face_count; f++)
        if (r->contacts >> f & 1)
            out[row++] = -saltus_system_gap(r->system, f, state);
}

/* The bordered matrix of the state just evaluated: [J, -push; n, 0]. The lu is opened for its size. */
static bool factor(rest *r) {
    int n = r->n, dof = r->system->dof, all = n + saltus_count_bits(r->contacts), row = n;
    memset(r->matrix, 0, (size_t)(all * all) * sizeof *r->matrix);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            r->matrix[i * all + j] = r->columns[j * n + i];
    for (int f = 0; f < r->system->face_count; f++) {
        saltus_face face = r->system->faces[f];
        if (!(r->contacts >> f & 1))
            continue;
        for (int i = 0; i < dof; i++) {
            r->matrix[(dof + i) * all + row] = -face.side * r->system->stop_impulse[face.stop][i];
            r->matrix[row * all + i] = face.side * r->system->stop_normal[face.stop][i];
        }
        row++;
    }
    return saltus_dense_factor(&r->lu, r->matrix) && r->lu.reciprocal > 10 * DBL_EPSILON;
}

/* Largest component of a step beside the system's scales. */
static double size_of(const rest *r, const double *step) {
    const double *scale = saltus_system_scale(r->system);
    double largest = 0;
    for (int i = 0; i < r->n; i++)
        largest = fmax(largest, fabs(step[i]) / scale[i]);
    return isfinite(largest) ? largest : INFINITY;
}

/* The longest part of the step after which the next would be smaller; 0 if there is none. The trial state is
 * where it leads. */
static saltus_status shorten(rest *r, double *factor, saltus_message *message) {
    enum { halvings_max = 12 };
    int dof = r->system->dof;
    *factor = 1;
    for (int k = 0; k < halvings_max; k++, *factor /= 2) {
        for (int i = 0; i < r->n; i++)
            r->trial[i] = i >= dof && i < 2 * dof ? 0 : r->state[i] + *factor * r->step[i];
        saltus_status status = evaluate(r, r->trial, 0, message);
        if (status != SALTUS_OK)
            return status;
        residual(r, r->trial, r->next);
        saltus_dense_resolve(&r->lu, false, 1, r->next);
        if (size_of(r, r->next) <= (1 - *factor / 4) * r->last)
            return SALTUS_OK;
    }
    *factor = 0;
    return SALTUS_OK;
}

static saltus_status iterate(rest *r, const saltus_equilibrium_options *options, saltus_message *message) {
    saltus_status status = evaluate(r, r->state, 0, message);
    for (int k = 0; k < options->iterations && status == SALTUS_OK; k++) {
        double part = 0;
        r->iterations++;
        if (!factor(r))
            return saltus_fail(message, SALTUS_SINGULAR,
                               "Newton's matrix is singular: the equilibrium is not isolated");
        residual(r, r->state, r->step);
        saltus_dense_resolve(&r->lu, false, 1, r->step);
        r->last = size_of(r, r->step);
        status = shorten(r, &part, message);
        if (status != SALTUS_OK)
            return status;
        bool done = r->last <= options->tolerance;
        if (part == 0 && !done)
            break;
        if (part > 0)
            memcpy(r->state, r->trial, (size_t)r->n * sizeof *r->state);
        for (int f = 0, row = r->n; f < r->system->face_count; f++)
            r->force[f] = r->contacts >> f & 1 ? r->step[row++] : 0;
        if (done)
            return SALTUS_OK;
    }
    return status != SALTUS_OK
               ? status
               : saltus_fail(message, SALTUS_NO_CONVERGENCE,
                             "Newton's iteration for the equilibrium stops at a step of %.3g", r->last);
}

static saltus_status solve(rest *r, const double *guess, unsigned contacts,
                           const saltus_equilibrium_options *options, saltus_message *message) {
    int dof = r->system->dof;
    r->contacts = contacts;
    saltus_dense_lu_close(&r->lu);
    if (!saltus_dense_lu_open(&r->lu, r->n + saltus_count_bits(contacts)))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the equilibrium");
    for (int i = 0; i < r->n; i++)
        r->state[i] = i >= dof && i < 2 * dof ? 0 : guess[i];
    return iterate(r, options, message);
}

/* How large the terms are that a contact force is the sum of. */
static double force_terms(const rest *r, int f) {
    int n = r->n, dof = r->system->dof;
    const double *normal = r->system->stop_normal[r->system->faces[f].stop];
    double sum = 0;
    for (int i = 0; i < dof; i++)
        for (int j = 0; j < n; j++)
            sum += fabs(normal[i] * r->columns[j * n + dof + i] * r->state[j]);
    return sum;
}

/* The contacts to try after those just solved with: the same if all push and no stop is passed. */
static unsigned corrected_contacts(const rest *r) {
    int pulling = -1, passed = -1;
    double strongest = INFINITY, farthest = 0;
    for (int f = 0; f < r->system->face_count; f++) {
        double force = r->force[f] - nothing * force_terms(r, f);
        double gap = saltus_system_gap(r->system, f, r->state) -
                     10 * nothing * saltus_system_gap_size(r->system, f, r->state);
        if (r->contacts >> f & 1) {
            if (force <= 0 && force < strongest) {
                strongest = force;
                pulling = f;
            }
        } else if (gap > farthest) {
            farthest = gap;
            passed = f;
        }
    }
    return pulling >= 0  ? r->contacts & ~(1u << pulling)
           : passed >= 0 ? r->contacts | 1u << passed
                         : r->contacts;
}

/* Faces that a guess touches or passes, more or less. */
static unsigned touched_faces(const rest *r, const double *state) {
    unsigned touched = 0;
    for (int f = 0; f < r->system->face_count; f++)
        if (saltus_system_gap(r->system, f, state) > -1e-9 * saltus_system_gap_size(r->system, f, state))
            touched |= 1u << f;
    return touched;
}

/* Solve with a set of contacts; *accepted when it is the right one. */
static saltus_status attempt(rest *r, const double *guess, const saltus_equilibrium_options *options,
                             unsigned *set, bool *accepted, saltus_message *message) {
    saltus_status status = solve(r, guess, *set, options, message);
    unsigned next = status == SALTUS_OK ? corrected_contacts(r) : *set;
    *accepted = status == SALTUS_OK && next == *set;
    *set = next;
    return status;
}

/* The contacts that the solutions lead to, then all others, small sets first. What the first attempt failed
 * of is what is said when none succeeds. */
static saltus_status search(rest *r, const double *guess, const saltus_equilibrium_options *options,
                            saltus_message *message) {
    bool tried[sets_max] = {false}, accepted = false;
    saltus_message other;
    unsigned set = touched_faces(r, guess), sets = 1u << r->system->face_count;
    saltus_status first = SALTUS_OK, status = SALTUS_OK;
    for (int k = 0; !accepted && !tried[set] && status != SALTUS_NO_MEMORY; k++) {
        tried[set] = true;
        status = attempt(r, guess, options, &set, &accepted, k ? &other : message);
        if (k == 0)
            first = status;
    }
    for (int size = 0; size <= r->system->face_count; size++)
        for (unsigned k = 0; k < sets && !accepted && status != SALTUS_NO_MEMORY; k++) {
            set = k;
            if (!tried[k] && saltus_count_bits(k) == size)
                status = attempt(r, guess, options, &set, &accepted, &other);
        }
    if (accepted)
        return SALTUS_OK;
    if (status == SALTUS_NO_MEMORY)
        return saltus_fail(message, status, "no memory for the equilibrium");
    return first == SALTUS_OK
               ? saltus_fail(message, SALTUS_NO_CONVERGENCE,
                             "no set of contacts gives an equilibrium whose contact forces push")
               : first;
}

static int by_real_part(const void *a, const void *b) {
    const saltus_eigenvalue *x = a, *y = b;
    if (x->re != y->re)
        return x->re < y->re ? 1 : -1;
    return x->im < y->im ? 1 : x->im > y->im ? -1 : 0;
}

/* An orthonormal basis of the displacements and velocities that keep the contacts, and the extra states: rows
 * of `basis`, which is zero, their number to *rows. False if there is no memory. */
static bool contact_basis(const rest *r, double *basis, int *rows) {
    int n = r->n, dof = r->system->dof, held = saltus_count_bits(r->contacts), width = dof - held;
    double *normals = r->matrix, *free_rows = normals + held * dof, *values = free_rows + width * dof;
    for (int f = 0, row = 0; f < r->system->face_count; f++)
        if (r->contacts >> f & 1)
            memcpy(normals + dof * row++, r->system->stop_normal[r->system->faces[f].stop],
                   (size_t)dof * sizeof *normals);
    if (held > 0 && width > 0 && !saltus_dense_null_vectors(normals, held, dof, width, free_rows, values))
        return false;
    *rows = 2 * width + r->system->extra;
    for (int i = 0; i < width; i++)
        for (int j = 0; j < dof; j++)
            basis[i * n + j] = basis[(width + i) * n + dof + j] = held ? free_rows[i * dof + j] : i == j;
    for (int i = 0; i < r->system->extra; i++)
        basis[(2 * width + i) * n + 2 * dof + i] = 1;
    return true;
}

/* Eigenvalues of the motion that keeps the contacts, from the Jacobian with them held. */
static saltus_status linearise(rest *r, saltus_equilibrium *out, saltus_message *message) {
    int n = r->n, rows = 0;
    double *real = r->step, *imaginary = r->next;
    saltus_status status = evaluate(r, r->state, r->contacts, message);
    if (status == SALTUS_OK && !contact_basis(r, r->basis, &rows))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the equilibrium");
    memset(r->matrix, 0, (size_t)(n * n) * sizeof *r->matrix);
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < n; j++)
            for (int k = 0; k < n; k++)
                r->product[i * n + j] += r->basis[i * n + k] * r->columns[j * n + k];
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < rows; j++)
            for (int k = 0; k < n; k++)
                r->matrix[i * rows + j] += r->product[i * n + k] * r->basis[j * n + k];
    if (status == SALTUS_OK && rows > 0 && !saltus_dense_eigenvalues(r->matrix, rows, real, imaginary))
        status = saltus_fail(message, SALTUS_NO_CONVERGENCE, "the eigenvalue iteration fails");
    for (int i = 0; i < rows && status == SALTUS_OK; i++)
        out->eigenvalues[i] = (saltus_eigenvalue){real[i], imaginary[i]};
    out->eigenvalue_count = rows;
    return status;
}

static void judge(saltus_equilibrium *out) {
    double largest = 0;
    int negative = 0;
    qsort(out->eigenvalues, (size_t)out->eigenvalue_count, sizeof *out->eigenvalues, by_real_part);
    for (int i = 0; i < out->eigenvalue_count; i++)
        largest = fmax(largest, hypot(out->eigenvalues[i].re, out->eigenvalues[i].im));
    for (int i = 0; i < out->eigenvalue_count; i++) {
        negative += out->eigenvalues[i].re < -10 * nothing * largest;
        out->instability += out->eigenvalues[i].re > 10 * nothing * largest;
    }
    out->stable = negative == out->eigenvalue_count;
}

static saltus_status describe(rest *r, saltus_equilibrium *out, saltus_message *message) {
    int dof = r->system->dof;
    out->contacts = r->contacts;
    out->iterations = r->iterations;
    out->residual = r->last;
    memcpy(out->state, r->state, (size_t)r->n * sizeof *out->state);
    for (int f = 0; f < r->system->face_count; f++) {
        const double *normal = r->system->stop_normal[r->system->faces[f].stop];
        double compliance = 0;
        for (int i = 0; i < dof; i++)
            for (int j = 0; j < dof; j++)
                compliance += normal[i] * r->system->inverse_mass[i * dof + j] * normal[j];
        bool holds = r->contacts >> f & 1;
        out->contact_force[f] = holds ? r->force[f] / compliance : 0;
        out->gap[f] = holds ? 0 : saltus_system_gap(r->system, f, r->state);
    }
    saltus_status status = linearise(r, out, message);
    if (status == SALTUS_OK)
        judge(out);
    return status;
}

static saltus_status open_rest(rest *r, saltus_equilibrium *out, saltus_message *message) {
    saltus_flow_options options = saltus_flow_defaults();
    reserve(r);
    out->state = calloc((size_t)r->n, sizeof *out->state);
    out->eigenvalues = calloc((size_t)r->n, sizeof *out->eigenvalues);
    if (!(out->state && out->eigenvalues && saltus_arena_open(&r->arena)))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the equilibrium");
    reserve(r);
    return saltus_flow_single(r->system, r->n, &options, &r->flow, message);
}

saltus_status saltus_equilibrium_find(const saltus_system *system, const double *guess,
                                      const saltus_equilibrium_options *options,
                                      saltus_equilibrium *equilibrium, saltus_message *message) {
    int n = saltus_system_dimension(system);
    rest r = {.system = system, .n = n, .room = n + SALTUS_FACES_MAX};
    *equilibrium = (saltus_equilibrium){.dimension = n};
    if (saltus_system_forced(system))
        return saltus_fail(message, SALTUS_BAD_INPUT, "the scene is forced: it has no equilibria");
    for (int i = 0; i < n; i++)
        if (!isfinite(guess[i]))
            return saltus_fail(message, SALTUS_BAD_INPUT, "guess: entry %d is not a finite number", i + 1);
    saltus_status status = open_rest(&r, equilibrium, message);
    if (status == SALTUS_OK)
        status = search(&r, guess, options, message);
    if (status == SALTUS_OK)
        status = describe(&r, equilibrium, message);
    saltus_dense_lu_close(&r.lu);
    saltus_flow_free(r.flow);
    saltus_arena_close(&r.arena);
    if (status != SALTUS_OK)
        saltus_equilibrium_clear(equilibrium);
    return status;
}

void saltus_equilibrium_clear(saltus_equilibrium *equilibrium) {
    free(equilibrium->state);
    free(equilibrium->eigenvalues);
    *equilibrium = (saltus_equilibrium){0};
}
