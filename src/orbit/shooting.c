/* Orbits with prescribed sequences: work space and unknowns.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/shooting.h"
#include "orbit/options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* From this many tangent vectors on, they take nearly all the time. */
enum { many = 8 };

/* Create flows and scales for the first system. */
static saltus_status open_parts(saltus_shooting *p, saltus_flow_options flow, saltus_message *message) {
    const saltus_system *system = p->full.system;
    const double *scale = saltus_system_scale(system), frequency = 2 * M_PI / saltus_system_period(system);
    saltus_direction direction[SALTUS_DIRECTIONS_MAX];
    flow.directions = p->family.parameters;
    for (int d = 0; d < p->family.parameters; d++)
        direction[d] = p->family.direction[d];
    if (!saltus_system_forced(system))
        direction[flow.directions++] = saltus_spec_omega_direction(&p->family.spec);
    if (saltus_flow_restarts_in_series(system, flow.integrator))
        flow.integrator = SALTUS_TAYLOR;
    p->n = p->response.n = saltus_system_dimension(system);
    p->response.directions = flow.directions;
    flow.columns = p->n + flow.directions;
    saltus_status status = saltus_flow_new(&system, 1, &flow, &p->full.flow, message);
    if (status == SALTUS_OK)
        status = saltus_flow_single(p->bare.system, 0, &flow, &p->bare.flow, message);
    if (status != SALTUS_OK)
        return status;
    if (flow.directions)
        saltus_flow_set_directions(p->full.flow, direction);
    if (p->n >= many) {
        p->equations.measure = saltus_shooting_residual;
        saltus_flow_expect_transients(p->full.flow);
    }
    memcpy(p->state_scale, scale, (size_t)p->n * sizeof *scale);
    p->length = scale[0];
    p->speed = scale[saltus_system_dof(system)];
    p->force = p->speed * fmax(frequency, p->speed / p->length);
    return status;
}

saltus_status saltus_shooting_new(const saltus_family *family, const saltus_orbit_options *options,
                                  saltus_shooting **shooting, saltus_message *message) {
    *shooting = NULL;
    saltus_status status = saltus_options_check(&saltus_orbit_table, options, message);
    if (status != SALTUS_OK)
        return status;
    saltus_shooting *p = calloc(1, sizeof *p);
    if (!p)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for shooting");
    p->family = *family;
    p->equations = (saltus_equations){.self = p,
                                      .evaluate = saltus_shooting_around,
                                      .tolerance = options->tolerance,
                                      .iterations = options->iterations,
                                      .history = options->history,
                                      .context = options->context};
    status = saltus_system_new(&family->spec, &p->full.system, message);
    if (status == SALTUS_OK)
        status = saltus_system_new(&family->spec, &p->bare.system, message);
    if (status == SALTUS_OK)
        status = open_parts(p, options->flow, message);
    if (status == SALTUS_OK)
        *shooting = p;
    else
        saltus_shooting_free(p);
    return status;
}

static void close_shape(saltus_shooting *p) {
    saltus_arena_close(&p->arena);
    p->arena = (saltus_arena){0};
    saltus_dense_lu_close(&p->equations.lu);
    free(p->breaches.items);
    p->breaches = (saltus_breaches){0};
}

void saltus_shooting_free(saltus_shooting *p) {
    if (!p)
        return;
    close_shape(p);
    saltus_tuned_clear(&p->full);
    saltus_tuned_clear(&p->bare);
    free(p);
}

saltus_status saltus_shooting_shape(saltus_shooting *p, const saltus_sequence *sequence,
                                    saltus_message *message) {
    int marks = sequence->count, cuts = sequence->cuts, faces = saltus_system_face_count(p->full.system);
    close_shape(p);
    p->equations.size = INFINITY;
    p->collection.whole = false;
    p->speed_mark = -1;
    p->steps = 0;
    saltus_flow_limit_steps(p->full.flow, 0);
    saltus_flow_limit_steps(p->bare.flow, 0);
    if (sequence->periods < 1)
        return saltus_fail(message, SALTUS_BAD_INPUT, "periods = %d: must be at least 1", sequence->periods);
    p->sequence = *sequence;
    p->count = saltus_sequence_unknowns(sequence, p->n);
    p->response.plain = cuts * p->n + marks;
    p->response.unknowns = p->count + (p->family.parameters > 1 ? p->family.parameters : 1);
    /* The parameters' columns in their order, then that of omega. */
    for (int d = 0; d < p->response.directions; d++)
        p->response.place[d] = d < p->family.parameters ? p->count + d
                               : sequence->omega > 0    ? p->count - 1
                                                        : -1;
    p->equations.kind = marks ? "event times unknown" : "stroboscopic map";
    p->breaches.room = 2 * marks + 2 * (marks + cuts + 1) * faces;
    p->breaches.items = calloc((size_t)p->breaches.room + 1, sizeof *p->breaches.items);
    const size_t n = (size_t)p->n, square = n * n;
    do {
        saltus_equations_reserve(&p->equations, p->response.unknowns, &p->arena);
        p->scale = saltus_arena_doubles(&p->arena, (size_t)p->count);
        p->plain = saltus_arena_doubles(&p->arena, (size_t)p->response.unknowns);
        p->speed_row = saltus_arena_doubles(&p->arena, (size_t)p->response.unknowns);
        p->response.tangents = saltus_arena_doubles(&p->arena, square + n * (size_t)p->response.directions);
        p->response.answer = saltus_arena_doubles(&p->arena, n * (size_t)p->response.unknowns);
        p->response.next = saltus_arena_doubles(&p->arena, n * (size_t)p->response.unknowns);
        p->collection.since = saltus_arena_doubles(&p->arena, square);
        p->collection.work = saltus_arena_doubles(&p->arena, square);
    } while (saltus_arena_again(&p->arena));
    p->equations.count = p->count;
    if (!(p->arena.base && p->breaches.items && saltus_dense_lu_open(&p->equations.lu, p->response.unknowns)))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a sequence of %d events", marks);
    for (int j = 0; j < p->count; j++)
        p->scale[j] = j < cuts * p->n ? p->state_scale[j % p->n] : 1;
    return SALTUS_OK;
}

int saltus_sequence_unknowns(const saltus_sequence *s, int n) {
    return s->cuts * n + s->count + (s->omega > 0);
}

void saltus_sequence_anchor(saltus_sequence *s, saltus_flow *flow, bool turning) {
    const saltus_system *system = saltus_flow_system(flow, 0);
    const double *scale = saltus_system_scale(system);
    int n = saltus_system_dimension(system);
    const double *observer = saltus_system_observer(system);
    double field[SALTUS_STATE_MAX];
    int dof = saltus_system_dof(system);
    s->omega = saltus_spec_omega(saltus_system_spec(system));
    saltus_flow_state(flow, 0, s->anchor);
    saltus_flow_field(flow, 0, field);
    for (int i = 0; i < n; i++) {
        field[i] /= scale[i];
        s->across[i] = !turning ? field[i] : i >= dof && i < 2 * dof ? observer[i - dof] * scale[i] : 0;
    }
    if (saltus_length(s->across, n) > 0)
        saltus_make_unit(s->across, n);
    s->speed = saltus_dot(s->across, field, n);
    /* Let the flow cross the hyperplane in the direction of `across`. */
    for (int i = 0; i < n && s->speed < 0; i++)
        s->across[i] = -s->across[i];
    s->speed = fabs(s->speed);
}

int saltus_shooting_closing_row(const saltus_shooting *p) {
    return (p->sequence.cuts - 1) * p->n;
}

void saltus_shooting_collect(saltus_shooting *p, saltus_cocycle *cocycle) {
    p->collection.into = cocycle;
}

bool saltus_shooting_collected(const saltus_shooting *p, const double *u) {
    const double near = 1e-8;
    bool same = p->collection.whole && p->equations.known;
    for (int j = 0; j < p->equations.unknowns && same; j++)
        same = fabs(u[j] - p->equations.place[j]) < near;
    return same;
}

const double *saltus_shooting_speed_row(saltus_shooting *p, int mark) {
    p->speed_mark = mark;
    return p->speed_row;
}

double saltus_shooting_growth(const saltus_shooting *p) {
    double largest = 0;
    for (int cut = 0; cut < p->sequence.cuts; cut++)
        for (int i = cut * p->n; i < (cut + 1) * p->n; i++)
            for (int j = cut * p->n; j < (cut + 1) * p->n; j++)
                largest = fmax(largest, fabs(p->equations.jacobian[(size_t)(i * p->equations.unknowns + j)]));
    return largest;
}

/* The states at the cuts follow from the state at the base; times come from the sequence. */
saltus_status saltus_shooting_fill(saltus_shooting *p, const double *parameters, const double *states,
                                   int given, double *u, saltus_message *message) {
    const saltus_sequence *s = &p->sequence;
    int n = p->n;
    for (int j = 0; j < s->cuts * n; j++)
        u[j] = j < given * n ? states[j] / p->scale[j] : 0;
    for (int k = 0; k < s->count; k++)
        u[s->cuts * n + k] = s->mark[k].time;
    if (s->omega > 0)
        u[p->count - 1] = log(saltus_spec_omega(&p->family.spec) / s->omega);
    u[p->count] = 0;
    for (int d = 0; d < p->family.parameters; d++)
        u[p->count + d] = parameters[d];
    saltus_status status = SALTUS_OK;
    for (int cut = given; cut < s->cuts && status == SALTUS_OK; cut++) {
        /* The residual of the segment before this cut is the state at its end minus the unknown, which is
         * still zero. Starting from zero the flow could not find the events of later segments. */
        status = saltus_shooting_along(p, p->equations.measure ? &p->bare : &p->full, cut, u, message);
        for (int i = 0; i < n && status == SALTUS_OK; i++)
            u[cut * n + i] += p->equations.residual[(cut - 1) * n + i];
    }
    return status;
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
    if (sequence->omega > 0)
        sequence->omega = saltus_shooting_omega(p, u);
}

saltus_dense_lu *saltus_shooting_factor(saltus_shooting *p, double added) {
    saltus_equations *e = &p->equations;
    const int m = e->unknowns, row = saltus_shooting_closing_row(p);
    memcpy(e->matrix, e->jacobian, (size_t)(p->count * m) * sizeof(double));
    for (int i = p->count; i < m; i++)
        for (int j = 0; j < m; j++)
            e->matrix[i * m + j] = i == j;
    for (int i = 0; i < p->n; i++)
        e->matrix[(row + i) * m + i] += added;
    saltus_dense_factor(&e->lu, e->matrix);
    return &e->lu;
}
