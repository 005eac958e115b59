/* Newton shooting on the p-th iterate of the stroboscopic map.
 *
 * x(pT) - x(0) = 0 is solved with the exact derivative (tangent vectors through all events), unknowns and
 * residuals scaled by the system's typical magnitudes, steps halved while they do not reduce the residual.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/dense.h"
#include "base/memory.h"
#include "orbit/multipliers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { halvings_max = 8 };

saltus_orbit_options saltus_orbit_defaults(void) {
    return (saltus_orbit_options){
        .flow = saltus_flow_defaults(), .phase = 0, .iterations = 20, .tolerance = 1e-12};
}

/* One shooting problem: n unknowns. */
typedef struct shooting {
    saltus_arena arena;
    int n;
    const double *scale;
    saltus_map *map;
    double *x, *image, *trial, *step, *derivative, *matrix;
    int *pivots;
} shooting;

static void reserve(shooting *s) {
    size_t n = (size_t)s->n;
    s->x = saltus_arena_doubles(&s->arena, n);
    s->image = saltus_arena_doubles(&s->arena, n);
    s->trial = saltus_arena_doubles(&s->arena, n);
    s->step = saltus_arena_doubles(&s->arena, n);
    s->derivative = saltus_arena_doubles(&s->arena, n * n);
    s->matrix = saltus_arena_doubles(&s->arena, n * n);
}

/* Largest scaled component of P^p(x) - x; +infinity where the map is not defined. */
static double residual_at(shooting *s, const double *x, saltus_message *message) {
    double largest = 0;
    if (saltus_map_reset(s->map, x, message) != SALTUS_OK ||
        saltus_map_step(s->map, s->image, NULL, message) != SALTUS_OK)
        return INFINITY;
    for (int i = 0; i < s->n; i++)
        largest = fmax(largest, fabs(s->image[i] - x[i]) / s->scale[i]);
    return largest;
}

/* Newton's step for the residual just evaluated. */
static bool newton_step(shooting *s) {
    int n = s->n;
    saltus_map_derivative(s->map, s->derivative);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++)
            s->matrix[i * n + j] = (s->derivative[i * n + j] - (i == j)) * s->scale[j] / s->scale[i];
        s->step[i] = -(s->image[i] - s->x[i]) / s->scale[i];
    }
    if (!saltus_dense_solve(s->matrix, n, s->step, s->pivots))
        return false;
    for (int i = 0; i < n; i++)
        s->step[i] *= s->scale[i];
    return true;
}

/* Iterate until the residual is below the tolerance and no longer falls: quadratic convergence costs one step
 * more and gives all the digits there are. */
static saltus_status iterate(shooting *s, const saltus_orbit_options *options, saltus_orbit *orbit,
                             saltus_message *message) {
    double residual = residual_at(s, s->x, message);
    for (int k = 0; k < options->iterations && isfinite(residual); k++) {
        orbit->iterations = k;
        if (!newton_step(s))
            return saltus_fail(message, SALTUS_SINGULAR,
                               "Newton's matrix is singular: the orbit is not isolated");
        double factor = 1, next = INFINITY;
        for (int h = 0; h < halvings_max; h++, factor /= 2) {
            for (int i = 0; i < s->n; i++)
                s->trial[i] = fma(factor, s->step[i], s->x[i]);
            next = residual_at(s, s->trial, message);
            if (next < residual)
                break;
            if (residual <= options->tolerance)
                break;
        }
        if (!(next < residual))
            break;
        memcpy(s->x, s->trial, (size_t)s->n * sizeof *s->x);
        residual = next;
    }
    orbit->residual = residual;
    if (!(residual <= options->tolerance))
        return saltus_fail(message, SALTUS_NO_CONVERGENCE, "Newton's iteration stops at a residual of %.3g",
                           residual);
    return SALTUS_OK;
}

saltus_status saltus_orbit_find(const saltus_system *system, int periods, const double *guess,
                                const saltus_orbit_options *options, saltus_orbit *orbit,
                                saltus_message *message) {
    *orbit = (saltus_orbit){.dimension = saltus_system_dimension(system), .periods = periods};
    shooting s = {.n = orbit->dimension, .scale = saltus_system_scale(system)};
    size_t n = (size_t)s.n;
    saltus_section section = saltus_section_defaults();
    section.phase = options->phase;
    section.iterate = periods;
    reserve(&s);
    saltus_status status = saltus_map_new(system, &section, &options->flow, true, &s.map, message);
    s.pivots = calloc(n, sizeof *s.pivots);
    orbit->state = calloc(n, sizeof *orbit->state);
    if (status == SALTUS_OK && !(s.pivots && orbit->state && saltus_arena_open(&s.arena)))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for shooting");
    if (status == SALTUS_OK) {
        reserve(&s);
        memcpy(s.x, guess, n * sizeof *guess);
        status = iterate(&s, options, orbit, message);
    }
    if (status == SALTUS_OK) {
        memcpy(orbit->state, s.x, n * sizeof *s.x);
        status = saltus_orbit_multipliers(system, options, orbit, message);
    }
    free(s.pivots);
    saltus_arena_close(&s.arena);
    saltus_map_free(s.map);
    if (status != SALTUS_OK)
        saltus_orbit_clear(orbit);
    return status;
}

void saltus_orbit_clear(saltus_orbit *orbit) {
    free(orbit->state);
    free(orbit->monodromy);
    free(orbit->multipliers);
    *orbit = (saltus_orbit){0};
}
