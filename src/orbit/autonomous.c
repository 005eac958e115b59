/* Periodic orbits whose period is unknown: scenes without forcing.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/multipliers.h"
#include "orbit/shooting.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Newton's method in the orbit's state and omega together, from `value`; what omega becomes goes to *found.
 */
static saltus_status relax(const saltus_spec *spec, const saltus_direction *omega, double value,
                           const saltus_orbit_options *options, saltus_orbit *orbit, double *found,
                           saltus_message *message) {
    saltus_sequence sequence = {.periods = orbit->periods,
                                .base = options->phase,
                                .driven = true,
                                .cuts = 1,
                                .cut = {options->phase}};
    const saltus_family family = {.spec = *spec, .parameters = 1, .direction = {*omega}, .unit = {value}};
    const double start = 0;
    saltus_shooting *shooting = NULL;
    double *u = calloc((size_t)orbit->dimension + 1, sizeof *u);
    saltus_status status = u ? saltus_shooting_new(&family, options, &shooting, message)
                             : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for shooting");
    if (status == SALTUS_OK)
        status = saltus_shooting_shape(shooting, &sequence, message);
    if (status == SALTUS_OK)
        status = saltus_shooting_fill(shooting, &start, orbit->state, u, message);
    if (status == SALTUS_OK)
        status = saltus_newton_shortest(saltus_shooting_equations(shooting), u, &orbit->iterations, message);
    if (status == SALTUS_OK) {
        saltus_shooting_extract(shooting, u, &sequence, orbit->state);
        *found = fma(value, u[orbit->dimension], value);
        orbit->residual = saltus_shooting_equations(shooting)->size;
    }
    saltus_shooting_free(shooting);
    free(u);
    return status;
}

saltus_status saltus_orbit_find_period(const saltus_spec *spec, int periods, const double *guess,
                                       const saltus_orbit_options *options, saltus_orbit *orbit,
                                       saltus_spec *found, saltus_message *message) {
    saltus_direction omega;
    saltus_system *system = NULL;
    double value = 0, end = 0;
    *orbit = (saltus_orbit){.periods = periods};
    *found = *spec;
    saltus_status status = saltus_system_new(spec, &system, message);
    if (status == SALTUS_OK && saltus_system_forced(system))
        status = saltus_fail(message, SALTUS_BAD_INPUT,
                             "the scene is forced: its orbits have the forcing's period");
    if (status == SALTUS_OK)
        status = saltus_spec_direction(spec, "omega", &omega, &value, message);
    if (status == SALTUS_OK) {
        orbit->dimension = saltus_system_dimension(system);
        orbit->state = calloc((size_t)orbit->dimension, sizeof *orbit->state);
        if (!orbit->state)
            status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for shooting");
    }
    if (status == SALTUS_OK) {
        memcpy(orbit->state, guess, (size_t)orbit->dimension * sizeof *guess);
        status = relax(spec, &omega, value, options, orbit, &end, message);
    }
    saltus_system_free(system);
    system = NULL;
    if (status == SALTUS_OK) {
        *found = saltus_spec_shifted(spec, &omega, end - value);
        status = saltus_system_new(found, &system, message);
    }
    if (status == SALTUS_OK)
        status = saltus_orbit_multipliers(system, options, orbit, message);
    saltus_system_free(system);
    if (status != SALTUS_OK)
        saltus_orbit_clear(orbit);
    return status;
}
