/* Equilibria as solutions of equations.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/rest.h"

#include "orbit/held.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The flow that evaluates the vector field, its last results, and scratch. */
typedef struct saltus_rest_work {
    saltus_arena arena, shape_arena; /* permanent, and for the present contacts */
    saltus_tuned tuned;
    saltus_variation varied[2];
    double state[SALTUS_STATE_MAX], field[SALTUS_STATE_MAX];
    double *jacobian;                 /* n + parameters columns of n */
    double *basis, *matrix, *product; /* n x n each; rows of the basis: coordinates of the motion */
    int held, face[SALTUS_FACES_MAX]; /* faces of the contacts */
    double *aside;                    /* bordered Jacobian */
    saltus_dense_lu lu;               /* its factors */
} work;

saltus_status saltus_rests_noted(saltus_rests *r, saltus_status status) {
    r->starved |= status == SALTUS_NO_MEMORY;
    return status;
}

saltus_status saltus_rests_open(saltus_rests *r, saltus_message *message) {
    saltus_flow_options options = saltus_flow_defaults();
    work *w = r->work = calloc(1, sizeof *w);
    r->solver = gsl_root_fsolver_alloc(gsl_root_fsolver_brent);
    if (!w || !r->solver)
        return saltus_branch_no_memory(message);
    saltus_status status = saltus_system_new(&r->family.spec, &r->first, message);
    if (status != SALTUS_OK)
        return status;
    const saltus_system *first = r->system = r->first;
    r->n = first->dimension;
    r->dof = first->dof;
    r->width = r->n - r->dof;
    r->state_scale = saltus_system_scale(first);
    r->rate_scale = r->dof ? r->state_scale[r->dof] / r->state_scale[0] : 1;
    r->force_scale = r->dof ? r->state_scale[r->dof] * r->rate_scale : 1;
    options.directions = r->family.parameters;
    options.columns = r->n + options.directions;
    for (int d = 0; d < r->family.parameters && status == SALTUS_OK; d++)
        status = saltus_spec_differentiable(&r->family.spec, &r->family.direction[d], message);
    if (status == SALTUS_OK)
        status = saltus_flow_new(&first, 1, &options, &w->tuned.flow, message);
    if (status != SALTUS_OK)
        return status;
    saltus_flow_set_directions(w->tuned.flow, r->family.direction);
    const size_t n = (size_t)r->n, order = (size_t)(r->width + first->face_count + 1);
    do {
        w->jacobian = saltus_arena_doubles(&w->arena, n * (n + 2));
        w->basis = saltus_arena_doubles(&w->arena, n * n);
        w->matrix = saltus_arena_doubles(&w->arena, n * n);
        w->product = saltus_arena_doubles(&w->arena, n * n);
        w->aside = saltus_arena_doubles(&w->arena, order * order);
        r->row_scale = saltus_arena_doubles(&w->arena, (size_t)r->width);
        for (int d = 0; d < r->family.parameters; d++)
            saltus_variation_reserve(&w->varied[d], first, &w->arena);
    } while (saltus_arena_again(&w->arena));
    return w->arena.base ? SALTUS_OK : saltus_branch_no_memory(message);
}

static void close_shape(saltus_rests *r) {
    saltus_arena_close(&r->work->shape_arena);
    r->work->shape_arena = (saltus_arena){0};
    saltus_dense_lu_close(&r->equations.lu);
    saltus_dense_lu_close(&r->work->lu);
}

void saltus_rests_close(saltus_rests *r) {
    if (r->work) {
        close_shape(r);
        saltus_arena_close(&r->work->arena);
        saltus_tuned_clear(&r->work->tuned);
    }
    gsl_root_fsolver_free(r->solver);
    saltus_system_free(r->first);
    free(r->work);
    *r = (saltus_rests){.n = 0};
}

/* Set the system to these parameters; the first one is kept. */
static saltus_status tune(saltus_rests *r, const double *parameters, saltus_message *message) {
    saltus_tuned *tuned = &r->work->tuned;
    const saltus_status status = saltus_family_tune(&r->family, parameters, 0, tuned, message);
    r->system = tuned->system ? tuned->system : r->first;
    return status;
}

/* The entry of the state that is an unknown: displacements and further states are, velocities are not. */
static int state_of(const saltus_rests *r, int unknown) {
    return unknown < r->dof ? unknown : unknown + r->dof;
}

/* The unknowns of a state and parameters; forces stay as they are. */
static void take_state(const saltus_rests *r, const double *parameters, const double *state, double *u) {
    for (int i = 0; i < r->width; i++)
        u[i] = state[state_of(r, i)] / r->state_scale[state_of(r, i)];
    memcpy(u + r->size, parameters, (size_t)r->family.parameters * sizeof *parameters);
}

/* Evaluate field and Jacobian, with these contacts, at the state of the unknowns displaced by `by` times a
 * vector (n; NULL: none). */
static saltus_status place(saltus_rests *r, const double *u, const double *aside, double by,
                           unsigned contacts, saltus_message *message) {
    work *w = r->work;
    saltus_status status = tune(r, u + r->size, message);
    memset(w->state, 0, (size_t)r->n * sizeof *w->state);
    for (int i = 0; i < r->width; i++)
        w->state[state_of(r, i)] = u[i] * r->state_scale[state_of(r, i)];
    for (int i = 0; i < r->n && aside; i++)
        w->state[i] += by * aside[i];
    if (status == SALTUS_OK && r->system->guarded && !saltus_system_defined(r->system, w->state, 0))
        status = saltus_fail(message, SALTUS_NO_CONVERGENCE, "the equations have no value at an equilibrium");
    if (status == SALTUS_OK)
        status = saltus_flow_place(w->tuned.flow, 0, (saltus_time){0, 0}, w->state, contacts, message);
    if (status != SALTUS_OK)
        return status;
    saltus_flow_field(w->tuned.flow, 0, w->field);
    saltus_flow_tangent_field(w->tuned.flow, 0, w->jacobian);
    if (!saltus_dense_finite(w->field, (size_t)r->n) ||
        !saltus_dense_finite(w->jacobian, (size_t)(r->n * (r->n + r->family.parameters))))
        return saltus_fail(message, SALTUS_NO_CONVERGENCE, "the equations have no value at an equilibrium");
    return SALTUS_OK;
}

/* The equation that a face's gap is zero, in units of the displacements' scale. */
static void fill_gap(const saltus_rests *r, int face, double *residual, double *row) {
    const saltus_face f = r->system->faces[face];
    const double length = r->state_scale[0];
    *residual = saltus_system_gap(r->system, face, r->work->state) / length;
    for (int i = 0; i < r->dof; i++)
        row[i] = f.side * r->system->stop_normal[f.stop][i] * r->state_scale[i] / length;
    for (int d = 0; d < r->family.parameters; d++) {
        const saltus_variation *v = &r->work->varied[d];
        double sum = f.side * v->offset[f.stop] - v->d[f.stop];
        for (int i = 0; i < r->dof; i++)
            sum += f.side * v->normal[f.stop][i] * r->work->state[i];
        row[r->size + d] = sum * r->family.unit[d] / length;
    }
}

/* The equations of the equilibrium at u, without the special one. */
static saltus_status fill_rows(saltus_rests *r, const double *u, saltus_message *message) {
    saltus_equations *e = &r->equations;
    work *w = r->work;
    const int m = e->unknowns, n = r->n, parameters = r->family.parameters;
    saltus_status status = place(r, u, NULL, 0, 0, message);
    if (status != SALTUS_OK)
        return status;
    for (int d = 0; d < parameters; d++)
        saltus_variation_fill(&w->varied[d], r->system, &r->family.direction[d]);
    memset(e->jacobian, 0, (size_t)(e->count * m) * sizeof *e->jacobian);
    for (int i = 0; i < r->width; i++) {
        double *row = e->jacobian + i * m;
        const int entry = r->dof + i;
        double sum = w->field[entry];
        for (int j = 0; j < r->width; j++)
            row[j] = w->jacobian[state_of(r, j) * n + entry] * r->state_scale[state_of(r, j)];
        for (int d = 0; d < parameters; d++)
            row[r->size + d] = w->jacobian[(n + d) * n + entry] * r->family.unit[d];
        for (int k = 0; k < w->held && i < r->dof; k++) {
            const saltus_face f = r->system->faces[w->face[k]];
            const double force = u[r->width + k];
            const double push = f.side * r->system->stop_impulse[f.stop][i] * r->force_scale;
            sum -= push * force;
            row[r->width + k] = -push;
            for (int d = 0; d < parameters; d++)
                row[r->size + d] -=
                    f.side * w->varied[d].impulse[f.stop][i] * r->force_scale * force * r->family.unit[d];
        }
        e->residual[i] = sum / r->row_scale[i];
        for (int j = 0; j < m; j++)
            row[j] /= r->row_scale[i];
    }
    for (int k = 0; k < w->held; k++)
        fill_gap(r, w->face[k], &e->residual[r->width + k], e->jacobian + (r->width + k) * m);
    return SALTUS_OK;
}

saltus_status saltus_rests_null_vectors(saltus_rests *r, const double *u, double *right, double *left,
                                        saltus_message *message) {
    const int size = r->size, m = r->equations.unknowns;
    double *a = r->work->aside, value;
    saltus_status status = fill_rows(r, u, message);
    for (int side = 0; side < 2 && status == SALTUS_OK; side++) {
        for (int i = 0; i < size; i++)
            for (int j = 0; j < size; j++)
                a[i * size + j] = r->equations.jacobian[side ? i * m + j : j * m + i];
        status = saltus_dense_null_vectors(a, size, size, 1, side ? right : left, &value);
        if (status != SALTUS_OK)
            saltus_fail(message, status, "no null vectors at a fold or branch point of equilibria");
    }
    return status;
}

double saltus_rests_pair(saltus_rests *r, const double *u, double near, double *square) {
    int count = 0;
    double best = INFINITY, half = NAN, re[SALTUS_STATE_MAX], im[SALTUS_STATE_MAX], *a = r->work->matrix;
    *square = NAN;
    if (saltus_rests_noted(r, saltus_rests_linear(r, u, NULL, 0, a, &count, NULL)) != SALTUS_OK ||
        !saltus_dense_eigenvalues(a, count, re, im))
        return NAN;
    for (int i = 0; i < count; i++)
        for (int j = 0; j < i; j++) {
            const double sum = re[i] + re[j], product = re[i] * re[j] - im[i] * im[j];
            /* Two eigenvalues are a pair only if both are real or they are conjugate. */
            const bool pair = im[i] + im[j] == 0 && (im[i] != 0 || im[j] == 0);
            const double apart = fabs(sum) * sqrt(fabs(near)) + fabs(product - near);
            if (pair && apart < best) {
                best = apart;
                half = 0.5 * sum;
                *square = product;
            }
        }
    return half;
}

/* The value at u that makes the equilibrium special, for HB or LP. For a fold it is the last entry of the
 * bordered Jacobian's solution: zero where the Jacobian is singular. */
static double special(saltus_rests *r, const double *u) {
    const saltus_rest_special *s = &r->special;
    const int size = r->size, order = size + 1;
    double square, *a = r->work->aside;
    if (s->kind == SALTUS_POINT_HB)
        return saltus_rests_pair(r, u, s->square, &square) / r->rate_scale;
    if (saltus_rests_noted(r, fill_rows(r, u, NULL)) != SALTUS_OK)
        return NAN;
    for (int i = 0; i < size; i++) {
        for (int j = 0; j < size; j++)
            a[i * order + j] = r->equations.jacobian[i * r->equations.unknowns + j];
        a[i * order + size] = s->left[i];
        a[size * order + i] = s->right[i];
    }
    a[size * order + size] = 0;
    if (!saltus_dense_factor(&r->work->lu, a))
        return NAN;
    memset(a, 0, (size_t)order * sizeof *a);
    a[size] = 1;
    saltus_dense_resolve(&r->work->lu, false, 1, a);
    return a[size];
}

/* The special equation of HB and LP has its gradient by central differences, which overwrite the other rows.
 * Where a parameter's domain ends in between, the value beyond is extrapolated from three on this side. */
static saltus_status evaluate(void *self, const double *u, saltus_message *message) {
    const double apart = 1e-5;
    saltus_rests *r = self;
    saltus_equations *e = &r->equations;
    const int last = e->count - 1, m = e->unknowns;
    const bool touches = r->special.kind == SALTUS_POINT_BE, differs = r->special.kind && !touches;
    double v[SALTUS_REST_UNKNOWNS_MAX], row[SALTUS_REST_UNKNOWNS_MAX];
    memcpy(v, u, (size_t)m * sizeof *v);
    const double value = differs ? special(r, u) : 0;
    bool sound = isfinite(value);
    for (int j = 0; j < m && sound && differs; j++) {
        const bool force = j >= r->width && j < r->size;
        double side[2] = {0, 0};
        for (int k = 0; k < 2 && !force; k++) {
            v[j] = u[j] + (k ? apart : -apart);
            side[k] = special(r, v);
        }
        for (int k = 0; k < 2 && !force; k++)
            if (!isfinite(side[k])) {
                v[j] = u[j] + (k ? -2 : 2) * apart;
                side[k] = 3 * (value - side[1 - k]) + special(r, v);
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
    if (status == SALTUS_OK && touches)
        fill_gap(r, r->special.face, &e->residual[last], e->jacobian + last * m);
    if (!differs)
        return status;
    e->residual[last] = value;
    memcpy(e->jacobian + last * m, row, (size_t)m * sizeof *row);
    return status;
}

saltus_status saltus_rests_shape(saltus_rests *r, unsigned contacts, const double *state,
                                 const double *parameters, saltus_message *message) {
    work *w = r->work;
    close_shape(r);
    r->contacts = contacts;
    w->held = 0;
    for (int f = 0; f < r->system->face_count; f++)
        if (contacts >> f & 1)
            w->face[w->held++] = f;
    r->size = r->width + w->held;
    const int unknowns = r->size + (r->special.kind ? 2 : 1);
    r->equations = (saltus_equations){
        .self = r, .evaluate = evaluate, .tolerance = 1e-11, .iterations = 20, .kind = "equilibrium"};
    do {
        saltus_equations_reserve(&r->equations, unknowns, &w->shape_arena);
    } while (saltus_arena_again(&w->shape_arena));
    if (!saltus_dense_lu_open(&r->equations.lu, unknowns) || !w->shape_arena.base ||
        !saltus_dense_lu_open(&w->lu, r->size + 1))
        return saltus_branch_no_memory(message);
    take_state(r, parameters, state, r->equations.trial);
    for (int i = 0; i < r->width; i++)
        r->row_scale[i] = 1;
    saltus_status status = fill_rows(r, r->equations.trial, message);
    /* At a fold or branch point a row may be zero: then the scales of the states give its size. */
    for (int i = 0; i < r->width && status == SALTUS_OK; i++) {
        double largest = r->state_scale[r->dof + i] * r->rate_scale;
        for (int j = 0; j < unknowns; j++)
            if (j < r->width || j >= r->size)
                largest = fmax(largest, fabs(r->equations.jacobian[i * unknowns + j]));
        r->row_scale[i] = largest;
    }
    return status;
}

saltus_status saltus_rests_fill(saltus_rests *r, const double *parameters, const double *state, double *u,
                                saltus_message *message) {
    double force[SALTUS_FACES_MAX];
    memset(u, 0, (size_t)r->equations.unknowns * sizeof *u);
    take_state(r, parameters, state, u);
    saltus_status status = place(r, u, NULL, 0, r->contacts, message);
    if (status != SALTUS_OK)
        return status;
    saltus_flow_forces(r->work->tuned.flow, 0, force);
    for (int k = 0; k < r->work->held; k++) {
        const int f = r->work->face[k];
        u[r->width + k] = force[f] * saltus_system_compliance(r->system, f) / r->force_scale;
    }
    return SALTUS_OK;
}

saltus_status saltus_rests_begin(saltus_rests *r, unsigned contacts, const double *state,
                                 const double *parameters, saltus_curve_point *at, saltus_message *message) {
    saltus_status status = saltus_rests_shape(r, contacts, state, parameters, message);
    if (status == SALTUS_OK && !saltus_curve_reserve(at, r->equations.unknowns))
        status = saltus_branch_no_memory(message);
    return status == SALTUS_OK ? saltus_rests_fill(r, parameters, state, at->u, message) : status;
}

saltus_status saltus_rests_linear(saltus_rests *r, const double *u, const double *aside, double by,
                                  double *matrix, int *count, saltus_message *message) {
    work *w = r->work;
    double along[SALTUS_STATE_MAX];
    saltus_status status = tune(r, u + r->size, message);
    if (status != SALTUS_OK)
        return status;
    if (!saltus_held_basis(r->system, r->contacts, w->basis, w->product, count))
        return saltus_branch_no_memory(message);
    if (aside)
        saltus_rests_lift(r, *count, aside, along);
    status = place(r, u, aside ? along : NULL, by, r->contacts, message);
    if (status == SALTUS_OK)
        saltus_held_reduce(w->basis, *count, r->n, w->jacobian, w->product, matrix);
    return status;
}

void saltus_rests_lift(const saltus_rests *r, int count, const double *vector, double *state) {
    for (int i = 0; i < r->n; i++) {
        state[i] = 0;
        for (int k = 0; k < count; k++)
            state[i] += r->work->basis[k * r->n + i] * vector[k];
    }
}

void saltus_rest_clear(saltus_rest *s) {
    saltus_curve_clear(&s->at);
    *s = (saltus_rest){.rate_count = 0};
}

/* The product of the sums of all pairs of eigenvalues: zero where a pair is purely imaginary. */
static saltus_scaled product_of_pairs(const saltus_eigenvalue *rates, int count) {
    double complex product = 1;
    double exponent = 0;
    for (int i = 0; i < count; i++)
        for (int j = 0; j < i; j++) {
            product *= rates[i].re + rates[j].re + I * (rates[i].im + rates[j].im);
            const double size = cabs(product);
            if (size > 0) {
                exponent += log(size);
                product /= size;
            }
        }
    return (saltus_scaled){creal(product), exponent};
}

saltus_status saltus_rest_see(saltus_rests *r, saltus_rest *s, saltus_message *message) {
    work *w = r->work;
    saltus_status status = saltus_rests_linear(r, s->at.u, NULL, 0, w->matrix, &s->rate_count, message);
    if (status == SALTUS_OK)
        status = saltus_held_eigenvalues(w->matrix, s->rate_count, s->rates, message);
    if (status != SALTUS_OK)
        return status;
    const saltus_growing counts = saltus_eigenvalues_growing(s->rates, s->rate_count);
    s->unstable = counts.growing;
    s->stable = counts.decaying == s->rate_count;
    s->pairs = product_of_pairs(s->rates, s->rate_count);
    s->trace = r->contacts ? NAN : 0;
    for (int i = 0; i < r->n; i++)
        s->trace += w->jacobian[i * r->n + i];
    memcpy(s->state, w->state, (size_t)r->n * sizeof *s->state);
    s->contacts = r->contacts;
    for (int d = 0; d < r->family.parameters; d++) {
        s->parameter[d] = s->at.u[r->size + d];
        s->value[d] = r->origin[d] + r->family.unit[d] * s->parameter[d];
    }
    for (int f = 0; f < r->system->face_count; f++) {
        s->force[f] = 0;
        s->gap[f] = r->contacts >> f & 1 ? 0 : saltus_system_gap(r->system, f, s->state);
        s->breach[f] = s->gap[f] / r->state_scale[0];
    }
    for (int k = 0; k < w->held; k++) {
        const int f = w->face[k];
        s->breach[f] = -s->at.u[r->width + k];
        s->force[f] = s->at.u[r->width + k] * r->force_scale / saltus_system_compliance(r->system, f);
    }
    return SALTUS_OK;
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
    saltus_status status = saltus_rests_begin(r, contacts, state, parameter, at, message);
    at->ahead = 0;
    at->bent = false;
    at->iterations = 0;
    if (status == SALTUS_OK && polish)
        status = saltus_newton(e, at->u, NULL, NULL, true, &at->iterations, message);
    else if (status == SALTUS_OK)
        status = saltus_equations_evaluate(e, at->u, message);
    if (status == SALTUS_OK && tangent) {
        memcpy(at->tangent, tangent, (size_t)at->unknowns * sizeof *tangent);
        at->crossing.mantissa = NAN; /* zero to rounding */
        at->residual = e->size;
    } else if (status == SALTUS_OK) {
        status = saltus_curve_orient(e, NULL, at, message);
    }
    return status == SALTUS_OK ? saltus_rest_see(r, out, message) : status;
}
