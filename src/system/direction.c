/* Directions in parameter space, and the derivative of a system along a direction.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/dense.h"
#include "system/system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double stop_value(const saltus_stop *stop, int number) {
    return number == SALTUS_STOP_XI ? stop->xi : number == SALTUS_STOP_D ? stop->d : stop->r;
}

saltus_status saltus_spec_differentiable(const saltus_spec *spec, const saltus_direction *direction,
                                         saltus_message *message) {
    for (int k = 0; k < spec->model->parameter_count; k++) {
        const bool varies = direction->parameter[k] != 0 && spec->model->obstacle;
        const char *obstacle = varies ? spec->model->obstacle(spec, k) : NULL;
        if (obstacle)
            return saltus_fail(message, SALTUS_BAD_INPUT, "%s = %g: %s", spec->model->parameters[k].name,
                               spec->parameters[k], obstacle);
    }
    return SALTUS_OK;
}

/* `stop` counts from 1; 0 means all stops. */
static saltus_status stop_direction(const saltus_spec *spec, const char *key, int number, int stop,
                                    saltus_direction *direction, double *value, saltus_message *message) {
    double *const rates[] = {
        [SALTUS_STOP_XI] = direction->xi, [SALTUS_STOP_D] = direction->d, [SALTUS_STOP_R] = direction->r};
    int first = stop ? stop - 1 : 0, last = stop ? stop : spec->stop_count;
    if (number == SALTUS_STOP_XI && !spec->model->tilt)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: a stop of the model %s is placed by %s", key,
                           spec->model->name, spec->model->stop_key);
    if (spec->stop_count == 0 || last > spec->stop_count)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the scene has %s", key,
                           spec->stop_count == 0   ? "no stop"
                           : spec->stop_count == 1 ? "only one stop"
                                                   : "fewer stops");
    for (int s = first; s < last && number != SALTUS_STOP_XI; s++) {
        const char *text = saltus_stop_text(
            spec, s, number == SALTUS_STOP_D ? SALTUS_STOP_CLEARANCE : SALTUS_STOP_RESTITUTION);
        if (text)
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "%s: is %.200s in the scene; the names in it are what can be set", key, text);
    }
    *value = stop_value(&spec->stops[first], number);
    for (int s = first; s < last; s++) {
        double other = stop_value(&spec->stops[s], number);
        if (other != *value)
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "%s: the stops differ (%g, %g); name one of them, such as %s1", key, *value,
                               other, key);
        rates[number][s] = 1;
    }
    return SALTUS_OK;
}

saltus_status saltus_spec_direction(const saltus_spec *spec, const char *key, saltus_direction *direction,
                                    double *value, saltus_message *message) {
    int index = saltus_model_parameter_index(spec->model, key), stop = 0, number = 0, numbers;
    const saltus_parameter *table = saltus_stop_parameters(&numbers);
    double unused;
    value = value ? value : &unused;
    *value = 0;
    *direction = (saltus_direction){.parameter = {0}};
    if (index >= 0) {
        const saltus_parameter *own = &spec->model->parameters[index];
        if (own->integer)
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "%s: a whole number (%s) cannot be varied continuously", own->name,
                               own->meaning);
        direction->parameter[index] = 1;
        *value = spec->parameters[index];
        return saltus_spec_differentiable(spec, direction, message);
    }
    while (number < numbers && !saltus_key_numbered(key, table[number].name, &stop))
        number++;
    if (number < numbers)
        return stop_direction(spec, key, number, stop, direction, value, message);
    return saltus_fail(message, SALTUS_BAD_INPUT, "%s: neither a parameter of the model %s nor d, r or xi",
                       key, spec->model->name);
}

double saltus_spec_get(const saltus_spec *spec, const char *name) {
    int k = saltus_model_parameter_index(spec->model, name);
    double value = NAN;
    saltus_direction direction;
    if (k >= 0)
        return spec->parameters[k];
    return saltus_spec_direction(spec, name, &direction, &value, NULL) == SALTUS_OK ? value : NAN;
}

saltus_direction saltus_spec_omega_direction(const saltus_spec *spec) {
    saltus_direction direction = {.clock = spec->model->forcing < 0};
    if (spec->model->forcing >= 0)
        direction.parameter[spec->model->forcing] = 1;
    return direction;
}

saltus_spec saltus_spec_shifted(const saltus_spec *spec, const saltus_direction *direction, double amount) {
    saltus_spec shifted = *spec;
    if (direction->clock != 0)
        shifted.clock = saltus_spec_omega(spec) + amount * direction->clock;
    for (int k = 0; k < spec->model->parameter_count; k++)
        shifted.parameters[k] += amount * direction->parameter[k];
    for (int s = 0; s < spec->stop_count; s++) {
        shifted.stops[s].d += amount * direction->d[s];
        shifted.stops[s].r += amount * direction->r[s];
        shifted.stops[s].xi += amount * direction->xi[s];
    }
    return shifted;
}

void saltus_variation_reserve(saltus_variation *variation, const saltus_system *system, saltus_arena *arena) {
    size_t n = (size_t)system->dof;
    for (int r = 0; r < system->coefficients.rows; r++)
        variation->coefficients.row[r] = saltus_arena_doubles(arena, n);
    variation->coefficients.slot = saltus_arena_doubles(arena, (size_t)system->coefficients.slots);
    for (int s = 0; s < system->spec.stop_count; s++) {
        variation->normal[s] = saltus_arena_doubles(arena, n);
        variation->impulse[s] = saltus_arena_doubles(arena, n);
    }
    variation->inverse_mass = saltus_arena_doubles(arena, n * n);
    variation->observer = saltus_arena_doubles(arena, n);
}

double saltus_variation_restitution(const saltus_variation *variation, const saltus_system *system, int face,
                                    double speed) {
    const int stop = system->faces[face].stop;
    if (system->by_speed >> face & 1)
        return system->spec.model->rebound_change(system, stop, speed, variation->direction);
    return variation->r[stop];
}

/* The derivative of b = w / (n w) with w = M^-1 n. */
static void vary_impulse(const saltus_variation *variation, const saltus_system *system, int stop) {
    int n = system->dof;
    const double *normal = system->stop_normal[stop], *tilt = variation->normal[stop];
    double *impulse = variation->impulse[stop], compliance = 0, change = 0;
    for (int i = 0; i < n; i++) {
        const double response = saltus_dot(system->inverse_mass + i * n, normal, n);
        impulse[i] = 0;
        for (int j = 0; j < n; j++)
            impulse[i] +=
                variation->inverse_mass[i * n + j] * normal[j] + system->inverse_mass[i * n + j] * tilt[j];
        compliance += normal[i] * response;
        change += tilt[i] * response + normal[i] * impulse[i];
    }
    for (int i = 0; i < n; i++)
        impulse[i] = (impulse[i] - change * system->stop_impulse[stop][i]) / compliance;
}

void saltus_variation_fill(saltus_variation *variation, const saltus_system *system,
                           const saltus_direction *direction) {
    const saltus_spec *spec = &system->spec;
    saltus_coefficients *c = &variation->coefficients;
    size_t row = (size_t)system->dof * sizeof(double);
    variation->direction = direction;
    c->terms = 0;
    c->rows = system->coefficients.rows;
    c->slots = system->coefficients.slots;
    memset(c->slot, 0, (size_t)c->slots * sizeof *c->slot);
    memset(c->scalar, 0, sizeof c->scalar);
    for (int r = 0; r < c->rows; r++)
        memset(c->row[r], 0, row);
    memset(variation->inverse_mass, 0, (size_t)system->dof * row);
    memset(variation->observer, 0, row);
    for (int s = 0; s < spec->stop_count; s++) {
        variation->d[s] = direction->d[s];
        variation->r[s] = direction->r[s];
        variation->offset[s] = 0;
        memset(variation->normal[s], 0, row);
        if (direction->xi[s] != 0 && spec->model->tilt)
            spec->model->tilt(system->dof, &spec->stops[s], variation->normal[s]);
        for (int i = 0; i < system->dof; i++)
            variation->normal[s][i] *= direction->xi[s];
    }
    spec->model->vary(system, direction, variation);
    if (system->observer.stop >= 0)
        memcpy(variation->observer, variation->normal[system->observer.stop], row);
    variation->omega =
        spec->model->forcing < 0 ? direction->clock : direction->parameter[spec->model->forcing];
    variation->tilts = false;
    for (int s = 0; s < spec->stop_count; s++) {
        vary_impulse(variation, system, s);
        for (int i = 0; i < system->dof; i++)
            variation->tilts |= variation->normal[s][i] != 0 || variation->impulse[s][i] != 0;
    }
}
