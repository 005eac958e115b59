/* Plain Newton steps towards a fixed point.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/fixed_point.h"

#include "base/dense.h"

#include <math.h>
#include <string.h>

saltus_status saltus_fixed_point_open(saltus_fixed_point *f, const saltus_system *system, int periods,
                                      const saltus_flow_options *options, saltus_message *message) {
    saltus_section section = saltus_section_defaults();
    section.iterate = periods;
    *f = (saltus_fixed_point){.n = saltus_system_dimension(system), .scale = saltus_system_scale(system)};
    const size_t n = (size_t)f->n;
    do {
        f->derivative = saltus_arena_doubles(&f->arena, n * n);
        f->matrix = saltus_arena_doubles(&f->arena, n * n);
    } while (saltus_arena_again(&f->arena));
    if (!f->arena.base)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a fixed point");
    return saltus_map_new(system, &section, options, true, &f->map, message);
}

void saltus_fixed_point_close(saltus_fixed_point *f) {
    saltus_map_free(f->map);
    saltus_arena_close(&f->arena);
    *f = (saltus_fixed_point){0};
}

double saltus_fixed_point_residual(saltus_fixed_point *f) {
    int n = f->n;
    double largest = 0;
    if (saltus_map_reset(f->map, f->state, NULL) != SALTUS_OK ||
        saltus_map_step(f->map, f->image, NULL, NULL) != SALTUS_OK)
        return INFINITY;
    saltus_map_derivative(f->map, f->derivative);
    for (int i = 0; i < n; i++) {
        double gap = fabs(f->image[i] - f->state[i]) / f->scale[i];
        largest = gap <= largest ? largest : gap;
        for (int j = 0; j < n; j++)
            f->derivative[i * n + j] *= f->scale[j] / f->scale[i];
    }
    return isfinite(largest) ? largest : INFINITY;
}

double saltus_fixed_point_step(saltus_fixed_point *f) {
    int n = f->n;
    int pivots[SALTUS_STATE_MAX];
    double step[SALTUS_STATE_MAX], length = 0;
    for (int i = 0; i < n; i++) {
        step[i] = (f->image[i] - f->state[i]) / f->scale[i];
        for (int j = 0; j < n; j++)
            f->matrix[i * n + j] = (i == j) - f->derivative[i * n + j];
    }
    if (!saltus_dense_solve(f->matrix, n, step, pivots) || !saltus_dense_finite(step, (size_t)n))
        return INFINITY;
    for (int i = 0; i < n; i++) {
        length = fmax(length, fabs(step[i]));
        f->state[i] += f->scale[i] * step[i];
    }
    return length;
}

bool saltus_fixed_point_find(saltus_fixed_point *f, const double *from, int steps, double reach) {
    const double converged = 1e-6, hopeless = 10;
    double before = INFINITY;
    memcpy(f->state, from, (size_t)f->n * sizeof *from);
    for (int k = 0; k < steps; k++) {
        double away = 0, residual = saltus_fixed_point_residual(f);
        if (residual < converged)
            return true;
        if (!(residual < hopeless * before) || saltus_fixed_point_step(f) == INFINITY)
            return false;
        for (int i = 0; i < f->n; i++)
            away = fmax(away, fabs(f->state[i] - from[i]) / f->scale[i]);
        if (!(away < reach))
            return false;
        before = residual;
    }
    return false;
}

double saltus_fixed_point_multiplier(saltus_fixed_point *f) {
    const double discernible = 1e-4; /* relative to the largest entry of the derivative */
    size_t entries = (size_t)f->n * (size_t)f->n;
    double size = 0, largest = 0, real[SALTUS_STATE_MAX], imaginary[SALTUS_STATE_MAX];
    for (size_t k = 0; k < entries; k++)
        size = fmax(size, fabs(f->derivative[k]));
    memcpy(f->matrix, f->derivative, entries * sizeof *f->matrix);
    if (!saltus_dense_eigenvalues(f->matrix, f->n, real, imaginary))
        return NAN;
    for (int i = 0; i < f->n; i++)
        largest = fmax(largest, hypot(real[i], imaginary[i]));
    return largest > discernible * fmax(size, discernible) ? log(largest) : NAN;
}
