/* Equilibria as solutions of equations.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/rest.h"

#include "base/bits.h"
#include "branch/solution.h"
#include "orbit/held.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

saltus_status saltus_rests_noted(saltus_rests *r, saltus_status status) {
    r->starved |= status == SALTUS_NO_MEMORY;
    return status;
}

static void reserve(saltus_rests *r) {
    size_t n = (size_t)r->n;
    r->state_scale = saltus_arena_doubles(&r->arena, n);
    r->state = saltus_arena_doubles(&r->arena, n);
    r->field = saltus_arena_doubles(&r->arena, n);
    r->jacobian = saltus_arena_doubles(&r->arena, n * (n + 2));
    r->basis = saltus_arena_doubles(&r->arena, n * n);
    r->matrix = saltus_arena_doubles(&r->arena, n * n);
    r->product = saltus_arena_doubles(&r->arena, n * n);
    r->real = saltus_arena_doubles(&r->arena, n);
    r->imaginary = saltus_arena_doubles(&r->arena, n);
    for (int d = 0; d < r->family.parameters; d++)
        saltus_variation_reserve(&r->varied[d], r->system, &r->arena);
}

saltus_status saltus_rests_open(saltus_rests *r, saltus_message *message) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_status status = saltus_system_new(&r->family.spec, &r->system, message);
    if (status != SALTUS_OK)
        return status;
    r->n = r->system->dimension;
    r->dof = r->system->dof;
    r->width = r->n - r->dof;
    options.directions = r->family.parameters;
    options.columns = r->n + options.directions;
    for (int d = 0; d < r->family.parameters && status == SALTUS_OK; d++)
        status = saltus_spec_differentiable(&r->family.spec, &r->family.direction[d], message);
    const saltus_system *first = r->system;
    if (status == SALTUS_OK)
        status = saltus_flow_new(&first, 1, &options, &r->flow, message);
    if (status != SALTUS_OK)
        return status;
    saltus_flow_set_directions(r->flow, r->family.direction);
    reserve(r);
    if (!saltus_arena_open(&r->arena))
        return saltus_branch_no_memory(message);
    reserve(r);
    /* The metric stays that of the first system, however the parameters change. */
    memcpy(r->state_scale, saltus_system_scale(r->system), (size_t)r->n * sizeof(double));
    r->rate_scale = r->dof ? r->state_scale[r->dof] / r->state_scale[0] : 1;
    r->force_scale = r->dof ? r->state_scale[r->dof] * r->rate_scale : 1;
    return SALTUS_OK;
}

static void close_shape(saltus_rests *r) {
    saltus_arena_close(&r->shape_arena);
    r->shape_arena = (saltus_arena){0};
    saltus_dense_lu_close(&r->equations.lu);
    saltus_dense_lu_close(&r->lu);
}

void saltus_rests_close(saltus_rests *r) {
    close_shape(r);
    saltus_arena_close(&r->arena);
    saltus_flow_free(r->flow);
    saltus_system_free(r->system);
    *r = (saltus_rests){.n = 0};
}

/* The system becomes that of parameters. */
static saltus_status tune(saltus_rests *r, const double *parameters, saltus_message *message) {
    bool same = true;
    for (int d = 0; d < r->family.parameters; d++)
        same = same && parameters[d] == r->at[d];
    return same ? SALTUS_OK
                : saltus_family_tune(&r->family, parameters, 0, r->flow, &r->system, r->at, message);
}

/* The unknown of a state's entry: its displacement or its further state; that of a velocity is none. */
static int state_of(const saltus_rests *r, int unknown) {
    return unknown < r->dof ? unknown : unknown + r->dof;
}

/* Field and Jacobian with contacts that hold, at the state of unknowns. */
static saltus_status place(saltus_rests *r, const double *u, unsigned contacts, saltus_message *message) {
    saltus_status status = tune(r, u + r->width + r->held, message);
    memset(r->state, 0, (size_t)r->n * sizeof *r->state);
    for (int i = 0; i < r->width; i++)
        r->state[state_of(r, i)] = u[i] * r->state_scale[state_of(r, i)];
    if (status == SALTUS_OK && r->system->guarded && !saltus_system_defined(r->system, r->state, 0))
        status = saltus_fail(message, SALTUS_NO_CONVERGENCE, "the equations have no value at an equilibrium");
    if (status == SALTUS_OK)
        status = saltus_flow_place(r->flow, 0, (saltus_time){0, 0}, r->state, contacts, message);
    if (status != SALTUS_OK)
        return status;
    saltus_flow_field(r->flow, 0, r->field);
    saltus_flow_tangent_field(r->flow, 0, r->jacobian);
    if (!saltus_dense_finite(r->field, (size_t)r->n) ||
        !saltus_dense_finite(r->jacobian, (size_t)(r->n * (r->n + r->family.parameters))))
        return saltus_fail(message, SALTUS_NO_CONVERGENCE, "the equations have no value at an equilibrium");
    return SALTUS_OK;
}

/* How the gap of a face and the push of its force answer to a parameter. */
static double gap_by_parameter(const saltus_rests *r, int face, int d) {
    const saltus_face f = r->system->faces[face];
    const saltus_variation *v = &r->varied[d];
    double sum = f.side * v->offset[f.stop] - v->d[f.stop];
    for (int i = 0; i < r->dof; i++)
        sum += f.side * v->normal[f.stop][i] * r->state[i];
    return sum * r->family.unit[d];
}

/* The row of a face's gap, in units of the displacements' scale. */
static void fill_gap(const saltus_rests *r, int face, double *residual, double *row) {
    const saltus_face f = r->system->faces[face];
    const double length = r->state_scale[0];
    *residual = saltus_system_gap(r->system, face, r->state) / length;
    for (int i = 0; i < r->dof; i++)
        row[i] = f.side * r->system->stop_normal[f.stop][i] * r->state_scale[i] / length;
    for (int d = 0; d < r->family.parameters; d++)
        row[r->width + r->held + d] = gap_by_parameter(r, face, d) / length;
}

/* The rows of the equilibrium itself at u. */
static saltus_status fill_rows(saltus_rests *r, const double *u, saltus_message *message) {
    saltus_equations *e = &r->equations;
    const int m = e->unknowns, n = r->n, parameters = r->family.parameters;
    saltus_status status = place(r, u, 0, message);
    if (status != SALTUS_OK)
        return status;
    for (int d = 0; d < parameters; d++)
        saltus_variation_fill(&r->varied[d], r->system, &r->family.direction[d]);
    memset(e->jacobian, 0, (size_t)(e->count * m) * sizeof *e->jacobian);
    for (int i = 0; i < r->width; i++) {
        double *row = e->jacobian + i * m;
        const int entry = r->dof + i;
        double sum = r->field[entry];
        for (int j = 0; j < r->width; j++)
            row[j] = r->jacobian[state_of(r, j) * n + entry] * r->state_scale[state_of(r, j)];
        for (int d = 0; d < parameters; d++)
            row[r->width + r->held + d] = r->jacobian[(n + d) * n + entry] * r->family.unit[d];
        for (int k = 0; k < r->held && i < r->dof; k++) {
            const saltus_face f = r->system->faces[r->held_face[k]];
            const double push = f.side * r->system->stop_impulse[f.stop][i] * r->force_scale;
            sum -= push * u[r->width + k];
            row[r->width + k] = -push;
            for (int d = 0; d < parameters; d++)
                row[r->width + r->held + d] -= f.side * r->varied[d].impulse[f.stop][i] * r->force_scale *
                                               u[r->width + k] * r->family.unit[d];
        }
        e->residual[i] = sum / r->row_scale[i];
        for (int j = 0; j < m; j++)
            row[j] /= r->row_scale[i];
    }
    for (int k = 0; k < r->held; k++)
        fill_gap(r, r->held_face[k], &e->residual[r->width + k], e->jacobian + (r->width + k) * m);
    return SALTUS_OK;
}

/* The bordered Jacobian's solution g, zero where the Jacobian is singular, from the rows at hand. */
static double bordered(saltus_rests *r) {
    const int size = r->width + r->held, order = size + 1;
    double *a = r->aside;
    for (int i = 0; i < size; i++) {
        for (int j = 0; j < size; j++)
            a[i * order + j] = r->equations.jacobian[i * r->equations.unknowns + j];
        a[i * order + size] = r->border[0][i];
        a[size * order + i] = r->border[1][i];
    }
    a[size * order + size] = 0;
    if (!saltus_dense_factor(&r->lu, a))
        return NAN;
    memset(a, 0, (size_t)order * sizeof *a);
    a[size] = 1;
    saltus_dense_resolve(&r->lu, false, 1, a);
    return a[size];
}

saltus_status saltus_rests_border(saltus_rests *r, const double *u, saltus_message *message) {
    const int size = r->width + r->held, m = r->equations.unknowns;
    saltus_status status = fill_rows(r, u, message);
    double value;
    for (int side = 0; side < 2 && status == SALTUS_OK; side++) {
        for (int i = 0; i < size; i++)
            for (int j = 0; j < size; j++)
                r->aside[i * size + j] = r->equations.jacobian[side ? i * m + j : j * m + i];
        status = saltus_dense_null_vectors(r->aside, size, size, 1, r->border[side], &value);
        if (status != SALTUS_OK)
            saltus_fail(message, status, "no null vectors at a fold or branch point of equilibria");
    }
    return status;
}

double saltus_rests_pair(saltus_rests *r, const double *u, double near, double *square) {
    int count = 0;
    double best = INFINITY, half = NAN;
    saltus_message ignored;
    *square = NAN;
    if (saltus_rests_noted(r, saltus_rests_linear(r, u, NULL, 0, r->matrix, &count, &ignored)) != SALTUS_OK ||
        !saltus_dense_eigenvalues(r->matrix, count, r->real, r->imaginary))
        return NAN;
    for (int i = 0; i < count; i++)
        for (int j = 0; j < i; j++) {
            const double sum = r->real[i] + r->real[j], im = r->imaginary[i] + r->imaginary[j];
            const double product = r->real[i] * r->real[j] - r->imaginary[i] * r->imaginary[j];
            /* Two of which neither is the other's conjugate are no pair. */
            const bool pair = im == 0 && (r->imaginary[i] != 0 || r->imaginary[j] == 0);
            const double apart = fabs(sum) * sqrt(fabs(near)) + fabs(product - near);
            if (pair && apart < best) {
                best = apart;
                half = 0.5 * sum;
                *square = product;
            }
        }
    return half;
}

/* What makes the equilibrium special, at u. */
static double special(saltus_rests *r, const double *u) {
    double square;
    saltus_message ignored;
    if (r->kind == SALTUS_POINT_HB)
        return saltus_rests_pair(r, u, r->square, &square) / r->rate_scale;
    return saltus_rests_noted(r, fill_rows(r, u, &ignored)) == SALTUS_OK ? bordered(r) : NAN;
}

/* The last row, by central differences where it is no gap; rows before it are filled in afterwards. */
static saltus_status fill_special(saltus_rests *r, const double *u, saltus_message *message) {
    const double apart = 1e-5;
    saltus_equations *e = &r->equations;
    const int last = e->count - 1, m = e->unknowns;
    double *v = r->moved, row[SALTUS_STATE_MAX + SALTUS_FACES_MAX + 2];
    memcpy(v, u, (size_t)m * sizeof *v);
    const double value = special(r, u);
    bool sound = isfinite(value);
    for (int j = 0; j < m && sound; j++) {
        const bool force = j >= r->width && j < r->width + r->held;
        double side[2] = {0, 0};
        for (int k = 0; k < 2 && !force; k++) {
            v[j] = u[j] + (k ? apart : -apart);
            side[k] = special(r, v);
        }
        v[j] = u[j];
        row[j] = (side[1] - side[0]) / (2 * apart);
        sound = isfinite(row[j]);
    }
    if (!sound && r->starved)
        return saltus_branch_no_memory(message);
    if (!sound)
        return saltus_fail(message, SALTUS_NO_CONVERGENCE,
                           "what makes the equilibrium special is not defined");
    saltus_status status = fill_rows(r, u, message);
    e->residual[last] = value;
    memcpy(e->jacobian + last * m, row, (size_t)m * sizeof *row);
    return status;
}

static saltus_status evaluate(void *self, const double *u, saltus_message *message) {
    saltus_rests *r = self;
    saltus_equations *e = &r->equations;
    if (r->kind == SALTUS_POINT_HB || r->kind == SALTUS_POINT_LP)
        return fill_special(r, u, message);
    saltus_status status = fill_rows(r, u, message);
    if (status == SALTUS_OK && r->kind == SALTUS_POINT_BE)
        fill_gap(r, r->face, &e->residual[e->count - 1], e->jacobian + (e->count - 1) * e->unknowns);
    return status;
}

static void reserve_shape(saltus_rests *r, int unknowns) {
    const size_t size = (size_t)(r->width + r->held), order = size + 1;
    saltus_equations_reserve(&r->equations, unknowns, &r->shape_arena);
    r->row_scale = saltus_arena_doubles(&r->shape_arena, (size_t)r->width);
    r->border[0] = saltus_arena_doubles(&r->shape_arena, size);
    r->border[1] = saltus_arena_doubles(&r->shape_arena, size);
    r->aside = saltus_arena_doubles(&r->shape_arena, order * order);
    r->moved = saltus_arena_doubles(&r->shape_arena, (size_t)unknowns);
}

saltus_status saltus_rests_shape(saltus_rests *r, unsigned contacts, const double *state,
                                 const double *parameters, saltus_message *message) {
    close_shape(r);
    r->contacts = contacts;
    r->held = 0;
    for (int f = 0; f < r->system->face_count; f++)
        if (contacts >> f & 1)
            r->held_face[r->held++] = f;
    const int unknowns = r->width + r->held + r->family.parameters;
    r->equations = (saltus_equations){
        .self = r, .evaluate = evaluate, .tolerance = 1e-11, .iterations = 20, .kind = "equilibrium"};
    reserve_shape(r, unknowns);
    if (!saltus_dense_lu_open(&r->equations.lu, unknowns) || !saltus_arena_open(&r->shape_arena) ||
        !saltus_dense_lu_open(&r->lu, r->width + r->held + 1))
        return saltus_branch_no_memory(message);
    reserve_shape(r, unknowns);
    double *u = r->equations.trial;
    for (int i = 0; i < r->width; i++) {
        u[i] = state[state_of(r, i)] / r->state_scale[state_of(r, i)];
        r->row_scale[i] = 1;
    }
    memcpy(u + r->width + r->held, parameters, (size_t)r->family.parameters * sizeof *parameters);
    saltus_status status = fill_rows(r, u, message);
    /* At a fold or a branch point a row may be zero: then the scales of the states tell its size. */
    for (int i = 0; i < r->width && status == SALTUS_OK; i++) {
        double largest = r->state_scale[r->dof + i] * r->rate_scale;
        for (int j = 0; j < unknowns; j++)
            if (j < r->width || j >= r->width + r->held)
                largest = fmax(largest, fabs(r->equations.jacobian[i * unknowns + j]));
        r->row_scale[i] = largest;
    }
    return status;
}

saltus_status saltus_rests_fill(saltus_rests *r, const double *parameters, const double *state, double *u,
                                saltus_message *message) {
    double force[SALTUS_FACES_MAX];
    memset(u, 0, (size_t)r->equations.unknowns * sizeof *u);
    for (int i = 0; i < r->width; i++)
        u[i] = state[state_of(r, i)] / r->state_scale[state_of(r, i)];
    memcpy(u + r->width + r->held, parameters, (size_t)r->family.parameters * sizeof *parameters);
    saltus_status status = place(r, u, r->contacts, message);
    if (status != SALTUS_OK)
        return status;
    saltus_flow_forces(r->flow, 0, force);
    for (int k = 0; k < r->held; k++)
        u[r->width + k] =
            force[r->held_face[k]] * saltus_system_compliance(r->system, r->held_face[k]) / r->force_scale;
    return SALTUS_OK;
}

saltus_status saltus_rests_linear(saltus_rests *r, const double *u, const double *aside, double by,
                                  double *matrix, int *count, saltus_message *message) {
    if (!saltus_held_basis(r->system, r->contacts, r->basis, r->product, count))
        return saltus_branch_no_memory(message);
    saltus_status status =
        aside ? tune(r, u + r->width + r->held, message) : place(r, u, r->contacts, message);
    if (aside) {
        saltus_rests_lift(r, *count, aside, r->state);
        for (int i = 0; i < r->n; i++) {
            const int entry = i < r->dof ? i : i - r->dof;
            const bool moves = i >= r->dof && i < 2 * r->dof;
            r->state[i] = by * r->state[i] + (moves ? 0 : u[entry] * r->state_scale[i]);
        }
        if (status == SALTUS_OK && r->system->guarded && !saltus_system_defined(r->system, r->state, 0))
            status = saltus_fail(message, SALTUS_NO_CONVERGENCE, "the equations have no value there");
        if (status == SALTUS_OK)
            status = saltus_flow_place(r->flow, 0, (saltus_time){0, 0}, r->state, r->contacts, message);
        if (status == SALTUS_OK)
            saltus_flow_tangent_field(r->flow, 0, r->jacobian);
    }
    if (status == SALTUS_OK)
        saltus_held_reduce(r->basis, *count, r->n, r->jacobian, r->product, matrix);
    return status;
}

void saltus_rests_lift(const saltus_rests *r, int count, const double *vector, double *state) {
    for (int i = 0; i < r->n; i++) {
        state[i] = 0;
        for (int k = 0; k < count; k++)
            state[i] += r->basis[k * r->n + i] * vector[k];
    }
}

void saltus_rest_clear(saltus_rest *s) {
    saltus_curve_clear(&s->at);
    free(s->state);
    free(s->rates);
    *s = (saltus_rest){.rate_count = 0};
}

/* The product of the sums of all two eigenvalues: zero where a pair is purely imaginary. */
static saltus_scaled product_of_pairs(const saltus_eigenvalue *rates, int count) {
    double re = 1, im = 0, exponent = 0;
    for (int i = 0; i < count; i++)
        for (int j = 0; j < i; j++) {
            const double a = rates[i].re + rates[j].re, c = rates[i].im + rates[j].im;
            const double next = re * a - im * c;
            im = re * c + im * a;
            re = next;
            const double size = hypot(re, im);
            if (size > 0) {
                exponent += log(size);
                re /= size;
                im /= size;
            }
        }
    return (saltus_scaled){re, exponent};
}

static saltus_status find_rates(saltus_rests *r, saltus_rest *s, saltus_message *message) {
    saltus_status status = saltus_rests_linear(r, s->at.u, NULL, 0, r->matrix, &s->rate_count, message);
    if (status == SALTUS_OK)
        status = saltus_held_eigenvalues(r->matrix, s->rate_count, r->real, r->imaginary, s->rates, message);
    if (status != SALTUS_OK)
        return status;
    const saltus_growing counts = saltus_eigenvalues_growing(s->rates, s->rate_count);
    s->unstable = counts.growing;
    s->stable = counts.decaying == s->rate_count;
    s->pairs = product_of_pairs(s->rates, s->rate_count);
    s->trace = r->contacts ? NAN : 0;
    for (int i = 0; i < r->n; i++)
        s->trace += r->jacobian[i * r->n + i];
    return SALTUS_OK;
}

saltus_status saltus_rest_see(saltus_rests *r, saltus_rest *s, saltus_message *message) {
    const double *u = s->at.u;
    if (!s->state)
        s->state = calloc((size_t)r->n, sizeof *s->state);
    if (!s->rates)
        s->rates = calloc((size_t)r->n, sizeof *s->rates);
    if (!s->state || !s->rates)
        return saltus_branch_no_memory(message);
    s->contacts = r->contacts;
    saltus_status status = find_rates(r, s, message);
    memcpy(s->state, r->state, (size_t)r->n * sizeof *s->state);
    for (int d = 0; d < r->family.parameters; d++) {
        s->parameter[d] = u[r->width + r->held + d];
        s->value[d] = r->origin[d] + r->family.unit[d] * s->parameter[d];
    }
    memset(s->force, 0, sizeof s->force);
    for (int f = 0; f < r->system->face_count; f++) {
        s->gap[f] = r->contacts >> f & 1 ? 0 : saltus_system_gap(r->system, f, s->state);
        s->breach[f] = s->gap[f] / r->state_scale[0];
    }
    for (int k = 0; k < r->held; k++) {
        const int f = r->held_face[k];
        s->breach[f] = -u[r->width + k];
        s->force[f] = u[r->width + k] * r->force_scale / saltus_system_compliance(r->system, f);
    }
    return status;
}

saltus_status saltus_rest_visit(saltus_rests *r, const saltus_rest *from, double ahead, saltus_rest *out,
                                saltus_message *message) {
    saltus_status status = saltus_curve_visit(&r->equations, &from->at, ahead, &out->at, message);
    return saltus_rests_noted(r, status == SALTUS_OK ? saltus_rest_see(r, out, message) : status);
}

saltus_status saltus_rest_place(saltus_rests *r, unsigned contacts, const double *state,
                                const double *parameter, bool polish, const double *tangent, saltus_rest *out,
                                saltus_message *message) {
    saltus_equations *e = &r->equations;
    saltus_curve_point *at = &out->at;
    saltus_status status = saltus_rests_shape(r, contacts, state, parameter, message);
    if (status == SALTUS_OK && !saltus_curve_reserve(at, e->unknowns))
        status = saltus_branch_no_memory(message);
    if (status == SALTUS_OK)
        status = saltus_rests_fill(r, parameter, state, at->u, message);
    at->ahead = 0;
    at->bent = false;
    at->iterations = 0;
    if (status == SALTUS_OK && polish)
        status = saltus_newton(e, at->u, NULL, NULL, true, &at->iterations, message);
    else if (status == SALTUS_OK)
        status = saltus_equations_evaluate(e, at->u, message);
    if (status == SALTUS_OK && tangent) {
        memcpy(at->tangent, tangent, (size_t)at->unknowns * sizeof *tangent);
        at->crossing.mantissa = NAN; /* zero but for rounding */
        at->residual = e->size;
    } else if (status == SALTUS_OK) {
        status = saltus_curve_orient(e, NULL, at, message);
    }
    return status == SALTUS_OK ? saltus_rest_see(r, out, message) : status;
}
