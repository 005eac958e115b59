/* Invariants that need a second run: the sum rule of the exponents, mirror symmetry, and independence of the
 * tolerance, of the order and of the integrator.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_STRESS_COMPARE_H
#define SALTUS_TESTS_STRESS_COMPARE_H

#include "stress_watch.h"

#include <gsl/gsl_linalg.h>

/* One motion under stress: the scene, where it starts, how long it runs and how. */
typedef struct stress_case {
    saltus_spec spec;
    saltus_flow_options options;
    double phase, periods;
    double compared; /* periods over which runs of different tolerances are compared */
    double state[stress_dimension_max];
} stress_case;

/* ln |det| of the tangent vectors. */
static inline double stress_log_volume(const double *tangents, int n) {
    gsl_matrix *matrix = gsl_matrix_alloc((size_t)n, (size_t)n);
    gsl_permutation *order = gsl_permutation_alloc((size_t)n);
    int sign;
    for (int i = 0; i < n * n; i++)
        gsl_matrix_set(matrix, (size_t)(i / n), (size_t)(i % n), tangents[i]);
    gsl_linalg_LU_decomp(matrix, order, &sign);
    double volume = gsl_linalg_LU_lndet(matrix);
    gsl_permutation_free(order);
    gsl_matrix_free(matrix);
    return volume;
}

/* Trace of the Jacobian integrated along the last step. */
static inline double stress_step_trace(const stress_watch *w) {
    double x[stress_dimension_max], since, weight, sum = 0;
    for (size_t k = 0; k < stress_samples; k++) {
        gsl_integration_glfixed_point(0, saltus_flow_step_length(w->flow, 0), k, &since, &weight, w->rule);
        saltus_flow_dense(w->flow, 0, since, x);
        sum += weight * stress_trace(&w->model, x);
        check_near(saltus_system_trace(w->system, x, 0), stress_trace(&w->model, x),
                   1e-13 * fabs(stress_trace(&w->model, x)));
    }
    return sum;
}

/* Volumes of tangent vectors, step by step from the unit cube, against the trace of the Jacobian and the
 * impacts' restitutions: the largest disagreement of ln volume in units of what the tolerance allows and
 * rounding, which a slow impact magnifies by one over its speed. Ends with the first lasting contact, which
 * takes all volume, or after `steps`. The number of impacts passed goes to `impacts`. */
static inline double stress_sum_rule(const stress_case *c, int steps, long long *impacts) {
    stress_watch w;
    stress_case wide = *c;
    saltus_event event = {.kind = SALTUS_STEP};
    double worst = 0, x[stress_dimension_max];
    stress_model_read(&w.model, &c->spec);
    const int n = wide.options.columns = w.model.dimension;
    double *tangents = calloc((size_t)(n * n), sizeof *tangents),
           *unit = calloc((size_t)(n * n), sizeof *unit);
    assert_true(tangents && unit);
    for (int i = 0; i < n; i++)
        unit[i * n + i] = 1;
    check_ok(stress_watch_open(&w, &c->spec, &wide.options, c->phase, c->state), &w.message);
    *impacts = 0;
    for (int k = 0; k < steps && event.kind != SALTUS_REACHED; k++) {
        saltus_flow_set_tangents(w.flow, 0, unit);
        double before = saltus_flow_information(w.flow, 0).log_volume;
        check_ok(stress_watch_step(&w, (saltus_time){(long long)c->periods + 1, 0}, &event), &w.message);
        if (saltus_flow_contacts(w.flow, 0) || !isfinite(saltus_flow_information(w.flow, 0).log_volume))
            break;
        saltus_flow_tangents(w.flow, 0, tangents);
        double rule = stress_step_trace(&w) + saltus_flow_information(w.flow, 0).log_volume - before;
        double steepness = event.kind == SALTUS_IMPACT ? w.speed / fabs(event.velocity_before) : 0;
        double allowed = n * (10 * fmax(c->options.rtol, 1e-13) + 64 * DBL_EPSILON * steepness);
        worst = fmax(worst, fabs(stress_log_volume(tangents, n) - rule) / allowed);
        *impacts = saltus_flow_information(w.flow, 0).impacts;
    }
    saltus_flow_state(w.flow, 0, x);
    stress_watch_close(&w);
    free(tangents);
    free(unit);
    return worst;
}

/* The scene seen in a mirror: stops change sides, loads their sign. */
static inline void stress_mirrored(const stress_case *c, stress_case *image) {
    static const char *const signs[] = {"F", "F0", "F2", "F02"};
    *image = *c;
    for (int s = 0; s < c->spec.stop_count; s++) {
        saltus_sides sides = c->spec.stops[s].sides;
        image->spec.stops[s].sides = sides == SALTUS_BOTH    ? SALTUS_BOTH
                                     : sides == SALTUS_UPPER ? SALTUS_LOWER
                                                             : SALTUS_UPPER;
    }
    for (size_t k = 0; k < sizeof signs / sizeof signs[0]; k++) {
        int p = saltus_model_parameter_index(c->spec.model, signs[k]);
        if (p >= 0)
            image->spec.parameters[p] = -c->spec.parameters[p];
    }
    for (int i = 0; i < stress_dimension_max; i++)
        image->state[i] = -c->state[i];
}

/* Largest sum of the states of a motion and of its mirror image, period by period: zero, bit for bit. */
static inline double stress_asymmetry(const stress_case *c) {
    stress_case image;
    stress_watch w[2];
    double worst = 0, x[2][stress_dimension_max];
    stress_mirrored(c, &image);
    check_ok(stress_watch_open(&w[0], &c->spec, &c->options, c->phase, c->state), &w[0].message);
    check_ok(stress_watch_open(&w[1], &image.spec, &image.options, image.phase, image.state), &w[1].message);
    for (int k = 1; k <= 8; k++) {
        for (int i = 0; i < 2; i++) {
            advance(w[i].flow, c->phase + c->periods * k / 8, 0);
            saltus_flow_state(w[i].flow, 0, x[i]);
        }
        for (int i = 0; i < w[0].model.dimension; i++)
            worst = fmax(worst, fabs(x[0][i] + x[1][i]));
        assert_int_equal(saltus_flow_information(w[0].flow, 0).impacts,
                         saltus_flow_information(w[1].flow, 0).impacts);
    }
    stress_watch_close(&w[0]);
    stress_watch_close(&w[1]);
    return worst;
}

/* The state after the compared periods, velocities of the start changed by `shift` of their scale. */
static inline void stress_reach(const stress_case *c, const saltus_flow_options *options, double shift,
                                double *x) {
    stress_watch w;
    stress_model_read(&w.model, &c->spec);
    saltus_system *system = build(&c->spec);
    memcpy(x, c->state, (size_t)w.model.dimension * sizeof *x);
    for (int i = 0; i < w.model.dof; i++)
        x[w.model.dof + i] += (i % 2 ? -1 : 1) * shift * saltus_system_scale(system)[w.model.dof + i];
    saltus_flow *flow = open_flow(system, options, c->phase, x);
    advance(flow, c->phase + c->compared, 0);
    saltus_flow_state(flow, 0, x);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

static inline double stress_distance(const stress_case *c, const double *a, const double *b) {
    saltus_system *system = build(&c->spec);
    double distance = 0;
    for (int i = 0; i < saltus_system_dimension(system); i++)
        distance = fmax(distance, fabs(a[i] - b[i]) / saltus_system_scale(system)[i]);
    saltus_system_free(system);
    return distance;
}

/* Runs of other tolerances, orders and of the other integrator against a run at the tightest tolerance: the
 * largest difference in units of tolerance times growth, the growth of a small change of the start. */
static inline double stress_dependence(const stress_case *c) {
    static const struct {
        double rtol;
        int order;
        saltus_integrator integrator;
    } ways[] = {{1e-8, 0, SALTUS_AUTOMATIC}, {1e-10, 0, SALTUS_AUTOMATIC}, {1e-12, 0, SALTUS_AUTOMATIC},
                {1e-13, 12, SALTUS_TAYLOR},  {1e-13, 26, SALTUS_TAYLOR},   {1e-13, 40, SALTUS_TAYLOR},
                {1e-12, 0, SALTUS_RADAU},    {1e-9, 0, SALTUS_RADAU}};
    const double shift = 1e-9;
    saltus_flow_options options = saltus_flow_defaults();
    double exact[stress_dimension_max], x[stress_dimension_max], worst = 0;
    options.rtol = 1e-14;
    options.atol = 1e-18;
    stress_reach(c, &options, 0, exact);
    stress_reach(c, &options, shift, x);
    double growth = fmax(1, stress_distance(c, x, exact) / shift);
    for (size_t k = 0; k < sizeof ways / sizeof ways[0]; k++) {
        options.rtol = ways[k].rtol;
        options.order = ways[k].order;
        options.integrator = ways[k].integrator;
        stress_reach(c, &options, 0, x);
        worst = fmax(worst, stress_distance(c, x, exact) / (growth * options.rtol));
    }
    return worst;
}

#endif
