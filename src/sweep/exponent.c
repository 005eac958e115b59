/* The largest exponent of a trajectory that has settled.
 *
 * Newton's method confirms the orbit at the state that has been reached: where a step of it moves the state
 * next to nothing, the derivative around the orbit that the step needs has the multipliers too. A multiplier
 * that is not told from that derivative's rounding, or a step that is not small, is left to the full method
 * (saltus_orbit_find), which takes five times as long, and much longer where there are many impacts.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include "base/dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    steps_max = 3,
    shooting_impacts = 100 /* an orbit of more of them is measured sooner */
};
static const double own_orbit = 1e-6;   /* the orbit is no farther away, relative to the system's scales */
static const double on_orbit = 1e-9;    /* a step as small as this is not taken */
static const double discernible = 1e-4; /* beside the largest entry of the derivative */

/* One orbit around: the derivative, and how far it is to the orbit by Newton's method. */
typedef struct lap {
    saltus_map *map;
    int n;
    double *state, *end, *derivative, *matrix, *imaginary;
    int *pivots;
} lap;

static bool open_lap(lap *l, const saltus_trajectory *t, int periods) {
    saltus_section section = saltus_section_defaults();
    saltus_flow_options options = saltus_flow_defaults();
    size_t n = (size_t)t->sweep->dimension;
    options.integrator = t->sweep->options.flow.integrator;
    section.iterate = periods;
    *l = (lap){.n = (int)n};
    l->state = calloc(3 * n + 2 * n * n, sizeof *l->state);
    l->pivots = calloc(n, sizeof *l->pivots);
    if (!l->state || !l->pivots)
        return false;
    l->end = l->state + n;
    l->imaginary = l->end + n;
    l->derivative = l->imaginary + n;
    l->matrix = l->derivative + n * n;
    memcpy(l->state, t->state, n * sizeof *l->state);
    return saltus_map_new(t->system, &section, &options, true, &l->map, NULL) == SALTUS_OK;
}

static void close_lap(lap *l) {
    saltus_map_free(l->map);
    free(l->state);
    free(l->pivots);
}

/* A step of Newton's method, taken; all in the system's scales. Returns its length, INFINITY where there is
 * none. */
static double step(lap *l, const double *scale) {
    double length = 0;
    if (saltus_map_reset(l->map, l->state, NULL) != SALTUS_OK ||
        saltus_map_step(l->map, l->end, NULL, NULL) != SALTUS_OK)
        return INFINITY;
    saltus_map_derivative(l->map, l->derivative);
    for (int i = 0; i < l->n; i++) {
        for (int j = 0; j < l->n; j++) {
            l->derivative[i * l->n + j] *= scale[j] / scale[i];
            l->matrix[i * l->n + j] = (i == j) - l->derivative[i * l->n + j];
        }
        l->end[i] = (l->end[i] - l->state[i]) / scale[i];
    }
    if (!saltus_dense_solve(l->matrix, l->n, l->end, l->pivots))
        return INFINITY;
    for (int i = 0; i < l->n; i++) {
        length = isfinite(l->end[i]) ? fmax(length, fabs(l->end[i])) : INFINITY;
        l->state[i] += scale[i] * l->end[i];
    }
    return length;
}

/* Logarithm of the largest multiplier's modulus; NAN where the derivative does not tell it. */
static double largest_multiplier(lap *l) {
    double size = 0, largest = 0;
    for (int k = 0; k < l->n * l->n; k++)
        size = fmax(size, fabs(l->derivative[k]));
    if (!saltus_dense_eigenvalues(l->derivative, l->n, l->end, l->imaginary))
        return NAN;
    for (int i = 0; i < l->n; i++)
        largest = fmax(largest, hypot(l->end[i], l->imaginary[i]));
    return largest > discernible * fmax(size, discernible) ? log(largest) : NAN;
}

static double by_steps(saltus_trajectory *t, int periods) {
    const double *scale = saltus_system_scale(t->system);
    double logarithm = NAN, length = INFINITY, gone = 0;
    lap l;
    bool sound = open_lap(&l, t, periods);
    t->starved |= !sound;
    for (int k = 0; k < steps_max && sound && length > on_orbit && gone < own_orbit; k++) {
        length = step(&l, scale);
        gone += length;
    }
    if (length <= on_orbit && gone < own_orbit)
        logarithm = largest_multiplier(&l);
    close_lap(&l);
    return logarithm;
}

static double by_shooting(saltus_trajectory *t, int periods) {
    saltus_orbit_options shooting = saltus_orbit_defaults();
    saltus_orbit orbit = {0};
    shooting.flow.integrator = t->sweep->options.flow.integrator;
    saltus_status status = saltus_orbit_find(t->system, periods, t->state, &shooting, &orbit, NULL);
    bool own = status == SALTUS_OK && saltus_section_distance(t->system, orbit.state, t->state) < own_orbit;
    double logarithm = own ? orbit.multipliers[0].log_modulus : NAN;
    t->starved |= status == SALTUS_NO_MEMORY;
    saltus_orbit_clear(&orbit);
    return logarithm;
}

bool saltus_trajectory_exponent(saltus_trajectory *t) {
    int periods = t->row.periods > 0 ? t->row.periods : 1;
    double logarithm = by_steps(t, periods);
    if (isnan(logarithm) && saltus_settling_impacts(&t->settling, periods) <= shooting_impacts)
        logarithm = by_shooting(t, periods);
    if (isnan(logarithm))
        return false;
    t->row.lyapunov = logarithm / (periods * saltus_system_period(t->system));
    t->row.lyapunov_error = 0;
    return true;
}
