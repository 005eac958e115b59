/* Orbits of prescribed sequences: the workspace and the unknowns.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/shooting_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void reserve(saltus_shooting *p) {
    size_t n = (size_t)p->n;
    p->state_scale = saltus_arena_doubles(&p->arena, n);
    p->end = saltus_arena_doubles(&p->arena, n);
    p->shift = saltus_arena_doubles(&p->arena, n);
    p->tangents = saltus_arena_doubles(&p->arena, n * (size_t)p->columns);
    p->gradient = saltus_arena_doubles(&p->arena, (size_t)p->columns);
}

static void reserve_shape(saltus_shooting *p) {
    saltus_arena *arena = &p->shape_arena;
    size_t unknowns = (size_t)p->unknowns, equations = (size_t)p->equations, n = (size_t)p->n;
    p->scale = saltus_arena_doubles(arena, unknowns);
    p->plain = saltus_arena_doubles(arena, unknowns);
    p->residual = saltus_arena_doubles(arena, equations);
    p->jacobian = saltus_arena_doubles(arena, equations * unknowns);
    p->answer = saltus_arena_doubles(arena, n * unknowns);
    p->next = saltus_arena_doubles(arena, n * unknowns);
    p->matrix = saltus_arena_doubles(arena, unknowns * unknowns);
    p->step = saltus_arena_doubles(arena, unknowns);
    p->trial = saltus_arena_doubles(arena, unknowns);
    p->kept = saltus_arena_doubles(arena, unknowns);
}

static saltus_status check_options(const saltus_orbit_options *o, saltus_message *message) {
    if (!(o->phase >= 0 && o->phase < 1))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "section phase = %g: must be at least 0 and less than 1", o->phase);
    if (o->iterations < 0)
        return saltus_fail(message, SALTUS_BAD_INPUT, "iterations = %d: must be at least 0", o->iterations);
    return SALTUS_OK;
}

saltus_status saltus_shooting_new(const saltus_spec *spec, const saltus_direction *direction, double origin,
                                  double unit, const saltus_orbit_options *options,
                                  saltus_shooting **shooting, saltus_message *message) {
    *shooting = NULL;
    saltus_status status = check_options(options, message);
    if (status != SALTUS_OK)
        return status;
    saltus_shooting *p = calloc(1, sizeof *p);
    if (!p)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for shooting");
    p->spec = *spec;
    p->has_direction = direction != NULL;
    if (direction)
        p->direction = *direction;
    p->origin = p->value = origin;
    p->unit = unit;
    p->options = *options;
    status = saltus_system_new(spec, &p->system, message);
    if (status == SALTUS_OK) {
        saltus_flow_options flow = options->flow;
        p->n = saltus_system_dimension(p->system);
        flow.directions = p->has_direction;
        p->columns = flow.columns = p->n + flow.directions;
        const saltus_system *system = p->system;
        status = saltus_flow_new(&system, 1, &flow, &p->flow, message);
    }
    if (status == SALTUS_OK) {
        if (direction)
            saltus_flow_set_directions(p->flow, direction);
        reserve(p);
        if (!saltus_arena_open(&p->arena))
            status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for shooting");
        else
            reserve(p);
    }
    if (status != SALTUS_OK) {
        saltus_shooting_free(p);
        return status;
    }
    const double *scale = saltus_system_scale(p->system);
    double frequency = 2 * 3.14159265358979323846 / saltus_system_period(p->system);
    /* The metric stays that of the first system, however the parameter changes. */
    memcpy(p->state_scale, scale, (size_t)p->n * sizeof *scale);
    p->length = scale[0];
    p->speed = scale[saltus_system_dof(p->system)];
    p->force = p->speed * fmax(frequency, p->speed / p->length);
    *shooting = p;
    return status;
}

saltus_status saltus_shooting_redirect(saltus_shooting *p, const saltus_spec *spec,
                                       const saltus_direction *direction, double origin, double unit,
                                       saltus_message *message) {
    p->spec = *spec;
    p->direction = *direction;
    p->origin = origin;
    p->unit = unit;
    p->value = NAN;
    if (p->scale)
        p->scale[p->equations] = unit;
    saltus_flow_set_directions(p->flow, direction);
    return saltus_shooting_tune(p, origin, message);
}

static void close_shape(saltus_shooting *p) {
    saltus_arena_close(&p->shape_arena);
    p->shape_arena = (saltus_arena){0};
    saltus_dense_lu_close(&p->lu);
    free(p->breaches);
    p->breaches = NULL;
}

void saltus_shooting_free(saltus_shooting *p) {
    if (!p)
        return;
    close_shape(p);
    saltus_arena_close(&p->arena);
    saltus_flow_free(p->flow);
    saltus_system_free(p->system);
    free(p);
}

saltus_status saltus_shooting_shape(saltus_shooting *p, const saltus_sequence *sequence,
                                    saltus_message *message) {
    int marks = sequence->count, cuts = sequence->cuts, faces = saltus_system_face_count(p->system);
    close_shape(p);
    p->residual_size = INFINITY;
    if (sequence->periods < 1)
        return saltus_fail(message, SALTUS_BAD_INPUT, "periods = %d: must be at least 1", sequence->periods);
    p->sequence = *sequence;
    p->equations = cuts * p->n + marks;
    p->unknowns = p->equations + 1;
    p->breach_room = 2 * marks + (marks + cuts + 1) * faces;
    p->breaches = calloc((size_t)p->breach_room + 1, sizeof *p->breaches);
    reserve_shape(p);
    if (!(p->breaches && saltus_dense_lu_open(&p->lu, p->unknowns) && saltus_arena_open(&p->shape_arena)))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a sequence of %d events", marks);
    reserve_shape(p);
    for (int j = 0; j < cuts; j++)
        memcpy(p->scale + j * p->n, p->state_scale, (size_t)p->n * sizeof(double));
    for (int k = 0; k < marks; k++)
        p->scale[cuts * p->n + k] = 1;
    p->scale[p->equations] = p->unit;
    return SALTUS_OK;
}

const saltus_sequence *saltus_shooting_sequence(const saltus_shooting *p) {
    return &p->sequence;
}
int saltus_shooting_unknowns(const saltus_shooting *p) {
    return p->unknowns;
}
const double *saltus_shooting_scale(const saltus_shooting *p) {
    return p->scale;
}
const saltus_system *saltus_shooting_system(const saltus_shooting *p) {
    return p->system;
}
double saltus_shooting_residual(const saltus_shooting *p) {
    return p->residual_size;
}

double saltus_shooting_growth(const saltus_shooting *p) {
    double largest = 0;
    for (int cut = 0; cut < p->sequence.cuts; cut++)
        for (int i = cut * p->n; i < (cut + 1) * p->n; i++)
            for (int j = cut * p->n; j < (cut + 1) * p->n; j++)
                largest = fmax(largest, fabs(p->jacobian[(size_t)i * (size_t)p->unknowns + (size_t)j]));
    return largest;
}

const saltus_breach *saltus_shooting_breaches(const saltus_shooting *p, int *count) {
    *count = p->breach_count;
    return p->breaches;
}
double saltus_shooting_speed(const saltus_shooting *p, int mark) {
    for (int k = 0; k < p->breach_count; k++)
        if (p->breaches[k].kind == SALTUS_BREACH_SPEED && p->breaches[k].mark == mark)
            return -p->breaches[k].value * p->speed;
    return 0;
}
double saltus_shooting_value(const saltus_shooting *p, const double *u) {
    return p->origin + p->unit * u[p->equations];
}

const double *saltus_shooting_states(saltus_shooting *p, const double *u) {
    for (int j = 0; j < p->sequence.cuts * p->n; j++)
        p->plain[j] = u[j] * p->scale[j];
    return p->plain;
}

void saltus_shooting_extract(const saltus_shooting *p, const double *u, saltus_sequence *sequence,
                             double *state) {
    *sequence = p->sequence;
    for (int i = 0; i < p->n; i++)
        state[i] = u[i] * p->scale[i];
    for (int k = 0; k < sequence->count; k++)
        sequence->mark[k].time = u[sequence->cuts * p->n + k];
}

saltus_status saltus_shooting_tune(saltus_shooting *p, double value, saltus_message *message) {
    if (value == p->value)
        return SALTUS_OK;
    saltus_spec spec = saltus_spec_shifted(&p->spec, &p->direction, value - p->origin);
    saltus_system *system = NULL;
    saltus_status status = saltus_system_new(&spec, &system, message);
    if (status == SALTUS_OK)
        status = saltus_flow_retune(p->flow, 0, system, message);
    if (status != SALTUS_OK) {
        saltus_system_free(system);
        return status;
    }
    saltus_system_free(p->system);
    p->system = system;
    p->value = value;
    return SALTUS_OK;
}
