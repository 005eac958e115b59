/* The rows of the stress suite: scenes at the ends of what is allowed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_STRESS_ROWS_H
#define SALTUS_TESTS_STRESS_ROWS_H

#include "stress_compare.h"

/* What applies to a row beside the invariants under watch, which apply to all. */
enum {
    stress_sum = 1,         /* sum rule of the exponents */
    stress_mirror = 2,      /* the mirrored scene moves like the mirror image */
    stress_independent = 4, /* of tolerance, order and integrator */
    stress_longer = 8,      /* in the long version only */
    stress_all = stress_sum | stress_mirror | stress_independent
};

typedef struct stress_row {
    const char *name;
    void (*make)(stress_case *c, double x); /* the scene and its start; x is the row's number */
    double x;
    unsigned applies;
} stress_row;

static inline void stress_start(stress_case *c, double periods) {
    saltus_message message = {.text = ""};
    saltus_system *system = build(&c->spec);
    check_ok(saltus_system_default_state(system, c->state, &message), &message);
    saltus_system_free(system);
    c->periods = periods;
    c->compared = fmin(periods, 3);
}

static inline void stress_pipe(stress_case *c, double modes, double omega, double d, double r,
                               saltus_sides sides) {
    c->spec = pipe_spec(modes, omega);
    add_stop(&c->spec, d, r, sides);
}

static inline void row_restitution(stress_case *c, double r) {
    stress_pipe(c, 5, 20, 0.025, r, SALTUS_UPPER);
    stress_start(c, 30);
}

static inline void row_two_sided(stress_case *c, double r) {
    stress_pipe(c, 4, 20, 0.025, r, SALTUS_BOTH);
    stress_start(c, 30);
}

static inline void row_clearance(stress_case *c, double d) {
    stress_pipe(c, 5, 20, d, 0.8, SALTUS_UPPER);
    stress_start(c, 20);
}

static inline void row_preload_lower(stress_case *c, double d) {
    stress_pipe(c, 4, 30, d, 0.5, SALTUS_LOWER);
    stress_start(c, 20);
}

/* The largest displacement of a motion over some periods. */
static inline double stress_summit(const stress_case *c, double periods) {
    saltus_system *system = build(&c->spec);
    saltus_flow *flow = open_flow(system, &c->options, c->phase, c->state);
    saltus_event event = {.kind = SALTUS_STEP};
    double summit = -INFINITY;
    while (event.kind != SALTUS_REACHED) {
        event = advance(flow, c->phase + periods, SALTUS_WATCH_TURNING);
        if (event.kind == SALTUS_TURNING)
            summit = fmax(summit, event.displacement);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
    return summit;
}

/* A stop that a free motion touches with all but a part x of its way: the square-root singularity. */
static inline void row_grazing(stress_case *c, double x) {
    stress_pipe(c, 5, 42, 1, 0.9, SALTUS_UPPER);
    stress_start(c, 20);
    saltus_system *system = build(&c->spec);
    saltus_message message = {.text = ""};
    check_ok(saltus_motion_settle(system, &c->options, 400, c->state, &message), &message);
    saltus_system_free(system);
    c->spec.stops[0].d = stress_summit(c, 20) * (1 - x);
}

/* The same where the free motion is known: x = A cos(omega t - lag) for ever. */
static inline void row_grazing_oscillator(stress_case *c, double x) {
    const double k = 1, damping = 0.1, force = 0.2, omega = 0.8;
    double stiff = k - omega * omega, drag = damping * omega, amplitude = force / hypot(stiff, drag);
    c->spec = oscillator_spec(damping, k, force, omega);
    add_stop(&c->spec, amplitude * (1 - x), 0.8, SALTUS_UPPER);
    c->phase = fmod(atan2(drag, stiff) / (2 * M_PI) + 0.5, 1);
    c->state[0] = -amplitude;
    c->state[1] = 0;
    c->periods = 20;
    c->compared = 0.4;
}

static inline void row_modes(stress_case *c, double modes) {
    stress_pipe(c, modes, 20, 0.025, 0.8, SALTUS_UPPER);
    stress_start(c, modes < 10 ? 20 : 4);
}

static inline void row_modes_two_sided(stress_case *c, double modes) {
    stress_pipe(c, modes, 38, 0.02, 0.95, SALTUS_BOTH);
    stress_start(c, 4);
}

static inline void row_undamped(stress_case *c, double r) {
    stress_pipe(c, 5, 20, 0.02, r, SALTUS_BOTH);
    set_parameter(&c->spec, "alpha", 0);
    stress_start(c, 5);
    c->compared = 0.25;
}

static inline void row_stretching(stress_case *c, double kappa) {
    stress_pipe(c, 4, 20, kappa > 0 ? 1.5 / sqrt(kappa) : 0.004, 0.8, SALTUS_BOTH);
    set_parameter(&c->spec, "kappa", kappa);
    if (kappa == 0)
        set_parameter(&c->spec, "u0", 2.8);
    stress_start(c, 20);
    for (int i = 0; i < 8; i++)
        c->state[i] *= kappa > 5000 ? sqrt(5000 / kappa) : 1;
    c->compared = 0.5;
}

static inline void row_steady_flow(stress_case *c, double u0) {
    stress_pipe(c, 4, 10, 0.01, 0.9, SALTUS_UPPER);
    set_parameter(&c->spec, "sigma", 0);
    set_parameter(&c->spec, "u0", u0);
    stress_start(c, 20);
    c->state[4] = 1;
}

static inline void row_frequency(stress_case *c, double omega) {
    stress_pipe(c, 4, omega, 0.025, 0.8, SALTUS_UPPER);
    stress_start(c, omega < 0.1 ? 0.02 : omega < 2 ? 1 : 40);
    c->phase = 0.125;
    c->state[4] = 0.3;
    c->compared = fmin(c->compared, omega / 4);
}

static inline void row_support(stress_case *c, double xi) {
    stress_pipe(c, 5, 20, 0.02 * sin(M_PI * xi), 0.8, SALTUS_BOTH);
    c->spec.stops[0].xi = xi;
    stress_start(c, 10);
    for (int i = 0; i < 10; i++)
        c->state[i] *= i == 0 ? 0.5 : 0.1;
    c->compared = 0.25;
}

static inline void row_mass_ratio(stress_case *c, double beta) {
    stress_pipe(c, 5, 20, 0.02, 0.8, SALTUS_UPPER);
    set_parameter(&c->spec, "beta", beta);
    stress_start(c, 20);
}

static inline void row_fast_flow(stress_case *c, double u0) {
    stress_pipe(c, 6, 30, 0.05, 0.8, SALTUS_BOTH);
    set_parameter(&c->spec, "u0", u0);
    stress_start(c, 10);
    c->compared = 0.25;
}

/* Symmetric shapes reach symmetric stops in the same instant: without the fluid's mass the modes of odd and
 * even number do not couple. */
static inline void row_same_instant(stress_case *c, double r) {
    stress_pipe(c, 5, 30, 0.015, r, SALTUS_UPPER);
    add_stop(&c->spec, 0.015, r, SALTUS_UPPER);
    set_parameter(&c->spec, "beta", 0);
    c->spec.stops[0].xi = 0.25;
    c->spec.stops[1].xi = 0.75;
    stress_start(c, 20);
    c->state[1] = c->state[3] = c->state[6] = c->state[8] = 0;
    c->state[2] = 1e-4;
    c->state[5] = 0.4;
}

/* Three stops, different restitutions, one of them two-sided. */
static inline void row_three_stops(stress_case *c, double r) {
    stress_pipe(c, 6, 10, 0.015, r, SALTUS_UPPER);
    add_stop(&c->spec, 0.012, 0.5 * r, SALTUS_BOTH);
    add_stop(&c->spec, 0.012, 0, SALTUS_UPPER);
    c->spec.stops[1].xi = 0.3;
    c->spec.stops[2].xi = 0.7;
    stress_start(c, 10);
}

static inline void row_tolerance(stress_case *c, double digits) {
    stress_pipe(c, 5, 20, 0.025, 0.9, SALTUS_UPPER);
    c->options.rtol = pow(10, -digits);
    c->options.atol = 1e-3 * c->options.rtol;
    stress_start(c, 20);
}

static inline void row_tolerance_stiff(stress_case *c, double digits) {
    stress_pipe(c, 16, 20, 0.025, 0.9, SALTUS_BOTH);
    c->options.rtol = pow(10, -digits);
    c->options.atol = 1e-3 * c->options.rtol;
    stress_start(c, 3);
}

/* A ball pressed on the floor by its weight: complete chatter of ln(v / v_end) / ln(1 / r) impacts. */
static inline void row_ball(stress_case *c, double r) {
    c->spec = oscillator_spec(0, 0, 0, 1);
    set_parameter(&c->spec, "F0", -1);
    add_stop(&c->spec, 0, r, SALTUS_LOWER);
    c->state[0] = 0.5;
    c->periods = 2.0 / (1 - r);
    c->compared = 1;
}

/* A pipe with a lasting load on its stop chatters to rest. */
static inline void row_pressed_pipe(stress_case *c, double r) {
    stress_pipe(c, 3, 10, 0.01, r, SALTUS_UPPER);
    set_parameter(&c->spec, "sigma", 0);
    stress_start(c, r < 0.995 ? 40 : 200);
    c->compared = 0.5;
}

static inline void row_impact_pair(stress_case *c, double r) {
    c->spec = oscillator_spec(0, 0, 1, 1);
    add_stop(&c->spec, 0.7, r, SALTUS_BOTH);
    c->state[1] = 0.3;
    c->periods = 60;
    c->compared = 1.5;
}

static inline void row_two_masses(stress_case *c, double r) {
    c->spec = oscillator_spec(0.05, 1, 0.6, 0.9);
    set_parameter(&c->spec, "N", 2);
    set_parameter(&c->spec, "m2", 0.3);
    set_parameter(&c->spec, "k2", 2);
    set_parameter(&c->spec, "c2", 0.02);
    set_parameter(&c->spec, "kz", 0.5);
    set_parameter(&c->spec, "tz", 2);
    add_stop(&c->spec, 0.3, r, SALTUS_UPPER);
    add_stop(&c->spec, 0.2, 0.9 * r, SALTUS_BOTH);
    c->spec.stops[1].weight[0] = -1;
    c->spec.stops[1].weight[1] = 1;
    c->state[0] = 0.1;
    c->state[2] = 0.4;
    c->periods = 60;
}

static const stress_row stress_rows[] = {
    {"r = 0", row_restitution, 0, stress_mirror | stress_independent},
    {"r = 1e-9", row_restitution, 1e-9, stress_all},
    {"r = 0.5", row_restitution, 0.5, stress_all},
    {"r = 0.9", row_restitution, 0.9, stress_all},
    {"r = 0.999", row_restitution, 0.999, stress_all},
    {"r = 1", row_restitution, 1, stress_all},
    {"two-sided, r = 0", row_two_sided, 0, stress_mirror | stress_independent},
    {"two-sided, r = 0.7", row_two_sided, 0.7, stress_all},
    {"two-sided, r = 1", row_two_sided, 1, stress_all},
    {"d = 0", row_clearance, 0, stress_all},
    {"d = 1e-6", row_clearance, 1e-6, stress_all},
    {"d = -1e-6", row_clearance, -1e-6, stress_all},
    {"d = -0.01", row_clearance, -0.01, stress_all},
    {"d = -0.05", row_clearance, -0.05, stress_all},
    {"lower stop, d = -0.02", row_preload_lower, -0.02, stress_all},
    {"grazing, 0 left", row_grazing, 0, stress_mirror},
    {"grazing, 1e-14 left", row_grazing, 1e-14, stress_mirror},
    {"grazing, 1e-12 left", row_grazing, 1e-12, stress_mirror},
    {"grazing, 1e-8 left", row_grazing, 1e-8, stress_mirror},
    {"grazing, 1e-4 left", row_grazing, 1e-4, stress_sum | stress_mirror},
    {"grazing, just missed", row_grazing, -1e-15, stress_mirror},
    {"grazing oscillator, 0 left", row_grazing_oscillator, 0, stress_mirror},
    {"grazing oscillator, 1e-15 left", row_grazing_oscillator, 1e-15, stress_mirror},
    {"grazing oscillator, 1e-9 left", row_grazing_oscillator, 1e-9, stress_mirror},
    {"grazing oscillator, 1e-3 left", row_grazing_oscillator, 1e-3, stress_all},
    {"N = 1", row_modes, 1, stress_all},
    {"N = 2", row_modes, 2, stress_all},
    {"N = 3", row_modes, 3, stress_all},
    {"N = 8", row_modes, 8, stress_all},
    {"N = 12", row_modes, 12, stress_mirror | stress_independent},
    {"N = 20", row_modes, 20, stress_mirror},
    {"N = 32", row_modes, 32, stress_mirror},
    {"N = 64", row_modes, 64, stress_mirror | stress_longer},
    {"N = 7, two-sided", row_modes_two_sided, 7, stress_all},
    {"N = 32, two-sided", row_modes_two_sided, 32, stress_mirror},
    {"alpha = 0, r = 1", row_undamped, 1, stress_all},
    {"alpha = 0, r = 0.6", row_undamped, 0.6, stress_all},
    {"kappa = 0", row_stretching, 0, stress_all},
    {"kappa = 1", row_stretching, 1, stress_all},
    {"kappa = 1e7", row_stretching, 1e7, stress_all},
    {"sigma = 0, u0 = 0", row_steady_flow, 0, stress_all},
    {"sigma = 0, u0 = 4.5", row_steady_flow, 4.5, stress_all},
    {"omega = 0.01", row_frequency, 0.01, stress_all},
    {"omega = 0.1", row_frequency, 0.1, stress_all},
    {"omega = 1", row_frequency, 1, stress_all},
    {"omega = 100", row_frequency, 100, stress_all},
    {"omega = 500", row_frequency, 500, stress_all},
    {"stop at xi = 1e-5", row_support, 1e-5, stress_all},
    {"stop at xi = 1e-3", row_support, 1e-3, stress_all},
    {"stop at xi = 0.999", row_support, 0.999, stress_all},
    {"beta = 0", row_mass_ratio, 0, stress_all},
    {"beta = 0.999999", row_mass_ratio, 0.999999, stress_all},
    {"u0 = 8", row_fast_flow, 8, stress_all},
    {"u0 = 14", row_fast_flow, 14, stress_all},
    {"two stops in one instant, r = 0", row_same_instant, 0, stress_mirror},
    {"two stops in one instant, r = 0.5", row_same_instant, 0.5, stress_mirror | stress_independent},
    {"two stops in one instant, r = 1", row_same_instant, 1, stress_mirror | stress_independent},
    {"three stops, r = 0.6", row_three_stops, 0.6, stress_mirror},
    {"three stops, r = 1", row_three_stops, 1, stress_mirror},
    {"rtol = 1e-3", row_tolerance, 3, stress_mirror},
    {"rtol = 1e-4", row_tolerance, 4, stress_mirror},
    {"rtol = 1e-6", row_tolerance, 6, stress_mirror},
    {"rtol = 1e-8", row_tolerance, 8, stress_sum | stress_mirror},
    {"rtol = 1e-10", row_tolerance, 10, stress_sum | stress_mirror},
    {"rtol = 1e-12", row_tolerance, 12, stress_sum | stress_mirror},
    {"rtol = 1e-14", row_tolerance, 14, stress_sum | stress_mirror},
    {"rtol = 1e-15", row_tolerance, 15, stress_sum | stress_mirror},
    {"N = 16, rtol = 1e-3", row_tolerance_stiff, 3, stress_mirror},
    {"N = 16, rtol = 1e-6", row_tolerance_stiff, 6, stress_mirror},
    {"N = 16, rtol = 1e-10", row_tolerance_stiff, 10, stress_mirror},
    {"N = 16, rtol = 1e-14", row_tolerance_stiff, 14, stress_mirror},
    {"ball, r = 0", row_ball, 0, stress_mirror},
    {"ball, r = 0.9", row_ball, 0.9, stress_all},
    {"ball, r = 0.999", row_ball, 0.999, stress_all},
    {"pressed pipe, r = 0.9", row_pressed_pipe, 0.9, stress_all},
    {"pressed pipe, r = 0.999", row_pressed_pipe, 0.999, stress_all},
    {"impact pair, r = 0.2", row_impact_pair, 0.2, stress_all},
    {"impact pair, r = 1", row_impact_pair, 1, stress_all},
    {"two masses, r = 0.7", row_two_masses, 0.7, stress_all},
    {"two masses, r = 1", row_two_masses, 1, stress_all},
};

#endif
