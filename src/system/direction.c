/* Directions in parameter space, and how a system changes along one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/system.h"

#include <stdlib.h>
#include <string.h>

typedef enum stop_key { key_d, key_r, key_xi } stop_key;

static double stop_value(const saltus_stop *stop, stop_key key) {
    return key == key_d ? stop->d : key == key_r ? stop->r : stop->xi;
}

/* Whether `key` is a key of stops, with the number of one stop behind it (from 1) or without (0). */
static bool read_stop_key(const char *key, stop_key *name, int *number) {
    static const char *const names[] = {[key_d] = "d", [key_r] = "r", [key_xi] = "xi"};
    for (int k = key_d; k <= key_xi; k++) {
        const char *digits = key + strlen(names[k]);
        if (strncmp(key, names[k], strlen(names[k])) != 0 || *digits == '0' || strlen(digits) > 3 ||
            strspn(digits, "0123456789") != strlen(digits))
            continue;
        *name = (stop_key)k;
        *number = atoi(digits);
        return true;
    }
    return false;
}

static saltus_status parameter_direction(const saltus_spec *spec, int index, saltus_direction *direction,
                                         double *value, saltus_message *message) {
    const saltus_parameter *p = &spec->model->parameters[index];
    if (p->integer)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: a whole number (%s) cannot be varied continuously",
                           p->name, p->meaning);
    const char *obstacle = spec->model->obstacle(spec, index);
    if (obstacle)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s = %g: %s", p->name, spec->parameters[index],
                           obstacle);
    direction->parameter[index] = 1;
    *value = spec->parameters[index];
    return SALTUS_OK;
}

static saltus_status stop_direction(const saltus_spec *spec, const char *key, stop_key name, int number,
                                    saltus_direction *direction, double *value, saltus_message *message) {
    double *rate = name == key_d ? direction->d : name == key_r ? direction->r : direction->xi;
    int first = number ? number - 1 : 0, last = number ? number : spec->stop_count;
    if (name == key_xi && !spec->model->tilt)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: a stop of the model %s is placed by %s", key,
                           spec->model->name, spec->model->stop_key);
    if (spec->stop_count == 0 || last > spec->stop_count)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the scene has %s", key,
                           spec->stop_count == 0   ? "no stop"
                           : spec->stop_count == 1 ? "only one stop"
                                                   : "fewer stops");
    *value = stop_value(&spec->stops[first], name);
    for (int s = first; s < last; s++) {
        if (stop_value(&spec->stops[s], name) != *value)
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "%s: the stops differ (%g, %g); name one of them, such as %s1", key, *value,
                               stop_value(&spec->stops[s], name), key);
        rate[s] = 1;
    }
    return SALTUS_OK;
}

saltus_status saltus_spec_direction(const saltus_spec *spec, const char *key, saltus_direction *direction,
                                    double *value, saltus_message *message) {
    int index = saltus_model_parameter_index(spec->model, key), number = 0;
    double present = 0;
    stop_key name;
    saltus_status status;
    *direction = (saltus_direction){.parameter = {0}};
    if (index >= 0)
        status = parameter_direction(spec, index, direction, &present, message);
    else if (read_stop_key(key, &name, &number))
        status = stop_direction(spec, key, name, number, direction, &present, message);
    else
        status =
            saltus_fail(message, SALTUS_BAD_INPUT, "%s: neither a parameter of the model %s nor d, r or xi",
                        key, spec->model->name);
    if (value)
        *value = present;
    return status;
}

saltus_spec saltus_spec_shifted(const saltus_spec *spec, const saltus_direction *direction, double amount) {
    saltus_spec shifted = *spec;
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
    for (int s = 0; s < system->spec.stop_count; s++) {
        variation->normal[s] = saltus_arena_doubles(arena, n);
        variation->impulse[s] = saltus_arena_doubles(arena, n);
    }
    variation->inverse_mass = saltus_arena_doubles(arena, n * n);
}

static void clear(saltus_variation *variation, const saltus_system *system) {
    size_t row = (size_t)system->dof * sizeof(double);
    variation->coefficients.terms = 0;
    variation->coefficients.rows = system->coefficients.rows;
    memset(variation->coefficients.scalar, 0, sizeof variation->coefficients.scalar);
    for (int r = 0; r < system->coefficients.rows; r++)
        memset(variation->coefficients.row[r], 0, row);
    memset(variation->inverse_mass, 0, (size_t)system->dof * row);
}

/* The derivative of b = w / (n w) with w = M^-1 n. */
static void vary_impulse(const saltus_variation *variation, const saltus_system *system, int stop) {
    int n = system->dof;
    const double *normal = system->stop_normal[stop], *tilt = variation->normal[stop];
    double *impulse = variation->impulse[stop], compliance = 0, change = 0;
    for (int i = 0; i < n; i++) {
        double response = 0;
        impulse[i] = 0;
        for (int j = 0; j < n; j++) {
            response += system->inverse_mass[i * n + j] * normal[j];
            impulse[i] +=
                variation->inverse_mass[i * n + j] * normal[j] + system->inverse_mass[i * n + j] * tilt[j];
        }
        compliance += normal[i] * response;
        change += tilt[i] * response + normal[i] * impulse[i];
    }
    for (int i = 0; i < n; i++)
        impulse[i] = (impulse[i] - change * system->stop_impulse[stop][i]) / compliance;
}

void saltus_variation_fill(saltus_variation *variation, const saltus_system *system,
                           const saltus_direction *direction) {
    const saltus_spec *spec = &system->spec;
    clear(variation, system);
    spec->model->vary(system, direction, variation);
    variation->omega = direction->parameter[saltus_model_parameter_index(spec->model, "omega")];
    variation->tilts = false;
    for (int s = 0; s < spec->stop_count; s++) {
        double *tilt = variation->normal[s];
        variation->d[s] = direction->d[s];
        variation->r[s] = direction->r[s];
        memset(tilt, 0, (size_t)system->dof * sizeof *tilt);
        if (direction->xi[s] != 0 && spec->model->tilt)
            spec->model->tilt(system->dof, &spec->stops[s], tilt);
        for (int i = 0; i < system->dof; i++)
            tilt[i] *= direction->xi[s];
        vary_impulse(variation, system, s);
        for (int i = 0; i < system->dof; i++)
            variation->tilts |= tilt[i] != 0 || variation->impulse[s][i] != 0;
    }
}
