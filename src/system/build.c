/* Checks of specifications and the construction of systems: the parts common to all models.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/dense.h"
#include "system/spectrum.h"
#include "system/system.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* `fault` says which stop the value belongs to; `owner` is the beginning of the message. */
static saltus_status check_range(const saltus_parameter *p, saltus_fault fault, const char *owner,
                                 double value, saltus_message *message) {
    bool low = p->open_min ? !(value > p->min) : !(value >= p->min);
    bool high = p->open_max ? !(value < p->max) : !(value <= p->max);
    fault.key = p->name;
    if (p->integer && value != floor(value))
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault, "%s%s = %g: must be a whole number (%s)",
                              owner, p->name, value, p->meaning);
    if (low || high)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault, "%s%s = %g: must be %s %g and %s %g (%s)",
                              owner, p->name, value, p->open_min ? "greater than" : "at least", p->min,
                              p->open_max ? "less than" : "at most", p->max, p->meaning);
    return SALTUS_OK;
}

static saltus_status check_stop(const saltus_spec *spec, int s, saltus_message *message) {
    const saltus_stop *stop = &spec->stops[s];
    const double values[] = {
        [SALTUS_STOP_XI] = stop->xi, [SALTUS_STOP_D] = stop->d, [SALTUS_STOP_R] = stop->r};
    const bool by_xi = strcmp(spec->model->stop_key, "xi") == 0,
               weighed = strcmp(spec->model->stop_key, "weight") == 0;
    saltus_fault fault = {.key = "weight", .stop = s + 1};
    int count;
    const saltus_parameter *parameters = saltus_stop_parameters(&count);
    char owner[32] = "";
    if (spec->stop_count > 1)
        snprintf(owner, sizeof owner, "stop %d: ", s + 1);
    for (int k = by_xi ? SALTUS_STOP_XI : SALTUS_STOP_D; k < count; k++) {
        saltus_status status = check_range(&parameters[k], fault, owner, values[k], message);
        if (status != SALTUS_OK)
            return status;
    }
    if (weighed && !(isfinite(stop->weight[0]) && isfinite(stop->weight[1])))
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault, "%sweight: must be finite numbers", owner);
    if (weighed && stop->weight[0] == 0 && stop->weight[1] == 0)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault,
                              "%sweight = [0, 0]: a stop must limit at least one mass", owner);
    fault.key = "sides";
    if (stop->sides < SALTUS_UPPER || stop->sides > SALTUS_BOTH)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, fault, "%ssides: must be upper, lower or both",
                              owner);
    fault.key = "d";
    if (stop->sides == SALTUS_BOTH && !(stop->d > 0))
        return saltus_fail_at(
            message, SALTUS_BAD_INPUT, fault,
            "%sd = %g: must be greater than 0 with sides: both (no room is left between the stops)", owner,
            stop->d);
    return SALTUS_OK;
}

static saltus_status check_spec(const saltus_spec *spec, saltus_message *message) {
    if (!spec->model)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, (saltus_fault){.key = "model"}, "model: missing");
    if (spec->stop_count < 0 || spec->stop_count > SALTUS_STOPS_MAX)
        return saltus_fail_at(message, SALTUS_BAD_INPUT, (saltus_fault){.key = "stops"},
                              "stops: %d given, at most %d are possible", spec->stop_count, SALTUS_STOPS_MAX);
    saltus_status status = SALTUS_OK;
    for (int k = 0; k < spec->model->parameter_count && status == SALTUS_OK; k++)
        status = check_range(&spec->model->parameters[k], (saltus_fault){.stop = 0}, "", spec->parameters[k],
                             message);
    for (int s = 0; s < spec->stop_count && status == SALTUS_OK; s++)
        status = check_stop(spec, s, message);
    return status;
}

static void reserve(saltus_system *system) {
    const saltus_model *model = system->spec.model;
    saltus_arena *arena = &system->arena;
    size_t n = (size_t)system->dof;
    for (int s = 0; s < system->spec.stop_count; s++) {
        system->stop_normal[s] = saltus_arena_doubles(arena, n);
        system->stop_impulse[s] = saltus_arena_doubles(arena, n);
    }
    system->inverse_mass = saltus_arena_doubles(arena, n * n);
    system->observer.row = saltus_arena_doubles(arena, n);
    system->scale = saltus_arena_doubles(arena, (size_t)system->dimension);
    system->damping = saltus_arena_doubles(arena, n);
    system->stiffness = saltus_arena_doubles(arena, n);
    saltus_spectrum_reserve(system);
    saltus_coefficients *c = &system->coefficients;
    c->rows = model->rows;
    c->couplings = model->couplings;
    for (int r = 0; r < c->rows; r++)
        c->row[r] = saltus_arena_doubles(arena, n);
    for (int m = 0; m < c->couplings; m++)
        c->coupling[m] = saltus_arena_doubles(arena, n * n);
    if (model->reserve)
        model->reserve(system);
}

/* Build the faces and each stop's b = M^-1 n / (n M^-1 n), the direction of a unit normal impulse. */
static void build_contacts(saltus_system *system) {
    int n = system->dof;
    for (int s = 0; s < system->spec.stop_count; s++) {
        const saltus_stop *stop = &system->spec.stops[s];
        const double *normal = system->stop_normal[s];
        double *impulse = system->stop_impulse[s];
        for (int i = 0; i < n; i++)
            impulse[i] = saltus_dot(system->inverse_mass + i * n, normal, n);
        const double compliance = saltus_dot(normal, impulse, n);
        for (int i = 0; i < n; i++)
            impulse[i] /= compliance;
        const double size = saltus_dot(normal, normal, n);
        system->stop_reach[s] = fmin(1, sqrt(size));
        system->stop_reply[s] = sqrt(size * saltus_dot(impulse, impulse, n));
        for (int side = 1; side >= -1; side -= 2)
            if (stop->sides & (side > 0 ? SALTUS_UPPER : SALTUS_LOWER)) {
                if (system->spec.model->by_speed && system->spec.model->by_speed(&system->spec, s))
                    system->by_speed |= 1u << system->face_count;
                system->faces[system->face_count++] =
                    (saltus_face){s, side, stop->d - side * system->offset[s], stop->r};
            }
    }
}

/* The factor f with n_a = f n_b, or 0 when the two normals are not parallel. */
static double parallel(const double *a, const double *b, int n) {
    const double aa = saltus_dot(a, a, n), ab = saltus_dot(a, b, n), bb = saltus_dot(b, b, n);
    return ab * ab > (1 - 1e-12) * aa * bb ? ab / bb : 0;
}

/* Faces on the same coordinate must leave room between them, and no two may be equal. */
static saltus_status check_faces(const saltus_system *system, saltus_message *message) {
    const saltus_fault fault = {.key = "stops"};
    for (int f = 0; f < system->face_count; f++)
        for (int g = 0; g < f; g++) {
            saltus_face a = system->faces[f], b = system->faces[g];
            double factor = parallel(system->stop_normal[a.stop], system->stop_normal[b.stop], system->dof);
            if (factor == 0)
                continue;
            if (a.side * b.side * factor > 0 && fabs(a.d - fabs(factor) * b.d) <= 1e-9 * fabs(a.d))
                return saltus_fail_at(
                    message, SALTUS_BAD_INPUT, fault,
                    "stops %d and %d limit the same coordinate on the same side; keep one of them",
                    b.stop + 1, a.stop + 1);
            if (a.side * b.side * factor < 0 && !(a.d / fabs(factor) + b.d > 0))
                return saltus_fail_at(message, SALTUS_BAD_INPUT, fault,
                                      "stops %d and %d: d = %g and d = %g leave no room between them",
                                      b.stop + 1, a.stop + 1, b.d, a.d);
        }
    return SALTUS_OK;
}

static saltus_status build_normals(saltus_system *system, saltus_message *message) {
    for (int s = 0; s < system->spec.stop_count; s++) {
        const saltus_stop *stop = &system->spec.stops[s];
        double size = 0;
        system->spec.model->normal(&system->spec, system->dof, stop, system->stop_normal[s]);
        for (int i = 0; i < system->dof; i++)
            size = fmax(size, fabs(system->stop_normal[s][i]));
        if (system->dof && isnan(system->stop_normal[s][0]))
            return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the system");
        if (size < 1e-6)
            return saltus_fail_at(message, SALTUS_BAD_INPUT, (saltus_fault){.key = "xi", .stop = s + 1},
                                  "stop %d: xi = %g: no mode moves there; a stop needs a place that moves",
                                  s + 1, stop->xi);
    }
    return SALTUS_OK;
}

/* Whether every face has its mirror image among the faces. */
static bool faces_symmetric(const saltus_system *system) {
    bool symmetric = true;
    for (int f = 0; f < system->face_count; f++) {
        bool found = false;
        for (int g = 0; g < system->face_count; g++) {
            saltus_face a = system->faces[f], b = system->faces[g];
            bool same =
                a.r == b.r && (a.stop == b.stop || !((system->by_speed >> f | system->by_speed >> g) & 1));
            found |= a.side == -b.side && a.d == b.d && same &&
                     parallel(system->stop_normal[a.stop], system->stop_normal[b.stop], system->dof) == 1;
        }
        symmetric &= found;
    }
    return symmetric;
}

saltus_status saltus_system_new(const saltus_spec *spec, saltus_system **system, saltus_message *message) {
    *system = NULL;
    int dof = 0, extra = 0;
    saltus_spec full = *spec;
    saltus_status status = check_spec(spec, message);
    if (status == SALTUS_OK)
        status = spec->model->shape(spec, &dof, &extra, message);
    if (status == SALTUS_OK && spec->model->complete) {
        spec->model->complete(&full);
        status = check_spec(&full, message);
    }
    if (status != SALTUS_OK)
        return status;

    saltus_system *made = calloc(1, sizeof *made);
    if (!made)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the system");
    made->spec = full;
    saltus_model_retain(full.model);
    made->dof = dof;
    made->extra = extra;
    made->dimension = 2 * dof + extra;
    made->omega = saltus_spec_omega(spec);
    made->period = spec->model->forcing < 0 && !spec->clock ? 1 : 2 * M_PI / made->omega;
    reserve(made);
    if (!saltus_arena_open(&made->arena)) {
        saltus_system_free(made);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the system");
    }
    reserve(made);
    status = build_normals(made, message);
    if (status == SALTUS_OK) {
        spec->model->build(made);
        build_contacts(made);
        made->mirror = made->mirror && faces_symmetric(made);
        status = check_faces(made, message);
    }
    if (status == SALTUS_OK)
        status = saltus_observer_choose(made, message);
    if (status != SALTUS_OK) {
        saltus_system_free(made);
        made = NULL;
    }
    *system = made;
    return status;
}

saltus_status saltus_system_clocked(const saltus_system *system, double omega, saltus_system **clocked,
                                    saltus_message *message) {
    saltus_spec spec = system->spec;
    saltus_spec_set_omega(&spec, omega);
    return saltus_system_new(&spec, clocked, message);
}

void saltus_system_free(saltus_system *system) {
    if (!system)
        return;
    saltus_model_release(system->spec.model);
    saltus_arena_close(&system->arena);
    free(system);
}
