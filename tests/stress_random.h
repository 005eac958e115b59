/* Random scenes over the whole allowed ranges, corners more often than chance would have them, some just
 * outside. Every draw is a statement of its own: then all compilers make the same scenes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_STRESS_RANDOM_H
#define SALTUS_TESTS_STRESS_RANDOM_H

#include "stress_compare.h"

#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>

static inline bool chance(gsl_rng *rng, double probability) {
    return gsl_rng_uniform(rng) < probability;
}

static inline double between(gsl_rng *rng, double low, double high) {
    return low + (high - low) * gsl_rng_uniform(rng);
}

static inline double log_between(gsl_rng *rng, double low, double high) {
    return low * pow(high / low, gsl_rng_uniform(rng));
}

/* Of either sign, at most `often`, or now and then at most `seldom`. */
static inline double signed_below(gsl_rng *rng, double often, double seldom) {
    double share = between(rng, -1, 1);
    return share * (chance(rng, 0.1) ? seldom : often);
}

/* One of a few corner values, or else a number of [low, high] whose logarithm is evenly distributed. */
static inline double corner_or(gsl_rng *rng, const double *corners, int count, double low, double high) {
    return chance(rng, 0.3) ? corners[gsl_rng_uniform_int(rng, (unsigned long)count)]
                            : log_between(rng, low, high);
}

static inline double random_restitution(gsl_rng *rng) {
    static const double corners[] = {0, 0, 1, 1, 1e-12, 0.999, 1 - 1e-12};
    return chance(rng, 0.5) ? corners[gsl_rng_uniform_int(rng, 7)] : gsl_rng_uniform(rng);
}

static inline double random_place(gsl_rng *rng) {
    static const double corners[] = {0.5, 0.5, 0.25, 0.75, 1.0 / 3, 1e-6, 1e-3, 1 - 1e-6};
    return chance(rng, 0.6) ? corners[gsl_rng_uniform_int(rng, 8)] : gsl_rng_uniform_pos(rng);
}

/* Clearances in units of a length of the scene. */
static inline double random_clearance(gsl_rng *rng, saltus_sides sides, double length) {
    static const double corners[] = {0, 0, 1, 1e-9, 1e6};
    double d = length * corner_or(rng, corners, 5, 1e-4, 10);
    return sides != SALTUS_BOTH && d <= length && chance(rng, 0.3) ? -d : d;
}

static inline void random_stops(gsl_rng *rng, saltus_spec *spec, double length) {
    static const int counts[] = {0, 1, 1, 1, 1, 1, 2, 2, 3, 4};
    bool pipe = strcmp(saltus_model_name(spec->model), "pipe") == 0;
    int count = counts[gsl_rng_uniform_int(rng, 10)];
    for (int s = 0; s < count; s++) {
        saltus_sides sides = (saltus_sides)(1 + gsl_rng_uniform_int(rng, 3));
        double r = random_restitution(rng), d = random_clearance(rng, sides, length);
        add_stop(spec, d, r, sides);
        saltus_stop *stop = &spec->stops[s];
        if (s > 0 && chance(rng, 0.3)) {
            stop->r = spec->stops[0].r;
            stop->d = spec->stops[0].d;
        }
        stop->xi = random_place(rng);
        if (pipe && sin(M_PI * stop->xi) < 0.1)
            stop->d *= sin(M_PI * stop->xi);
        if (!pipe && saltus_spec_get(spec, "N") > 1) {
            stop->weight[0] = (double)gsl_rng_uniform_int(rng, 3) - 1;
            stop->weight[1] = chance(rng, 0.7) ? 1 : gsl_ran_gaussian(rng, 1);
        }
    }
}

static inline double random_modes(gsl_rng *rng) {
    if (chance(rng, 0.9))
        return 1 + (double)gsl_rng_uniform_int(rng, 8);
    return chance(rng, 0.9) ? 9 + (double)gsl_rng_uniform_int(rng, 24) : 64;
}

static inline void random_pipe(gsl_rng *rng, saltus_spec *spec) {
    static const double alphas[] = {0, 0.005, 10}, kappas[] = {0, 5000, 1e7, 1e9};
    static const double betas[] = {0, 0.64, 1 - 1e-6, 1 - DBL_EPSILON}, omegas[] = {0.01, 20, 42, 500, 1e5};
    *spec = saltus_spec_defaults(saltus_model_find("pipe"));
    set_parameter(spec, "N", random_modes(rng));
    set_parameter(spec, "alpha", corner_or(rng, alphas, 3, 1e-6, 0.1));
    set_parameter(spec, "beta", chance(rng, 0.3) ? betas[gsl_rng_uniform_int(rng, 4)] : gsl_rng_uniform(rng));
    set_parameter(spec, "kappa", corner_or(rng, kappas, 4, 1, 1e6));
    set_parameter(spec, "u0", chance(rng, 0.1) ? 0 : signed_below(rng, 8, 100));
    set_parameter(spec, "sigma", chance(rng, 0.2) ? 0 : signed_below(rng, 1, 10));
    set_parameter(spec, "omega", corner_or(rng, omegas, 5, 0.1, 200));
    double kappa = saltus_spec_get(spec, "kappa");
    random_stops(rng, spec, 2 / sqrt(fmax(kappa, 100)));
}

static inline void random_oscillator(gsl_rng *rng, saltus_spec *spec) {
    static const char *const stiff[] = {"k", "c", "k2", "c2", "kz"}, *const loads[] = {"F", "F0", "F2",
                                                                                       "F02"};
    static const double zero[] = {0, 0, 1, 1e6};
    *spec = saltus_spec_defaults(saltus_model_find("oscillator"));
    set_parameter(spec, "N", 1 + (double)gsl_rng_uniform_int(rng, 2));
    set_parameter(spec, "m", log_between(rng, 1e-2, 1e2));
    set_parameter(spec, "m2", log_between(rng, 1e-2, 1e2));
    set_parameter(spec, "tz", log_between(rng, 1e-3, 1e3));
    set_parameter(spec, "omega", log_between(rng, 1e-2, 1e2));
    for (size_t k = 0; k < sizeof stiff / sizeof stiff[0]; k++)
        set_parameter(spec, stiff[k], corner_or(rng, zero, k % 2 ? 3 : 4, 1e-3, 1e3));
    for (size_t k = 0; k < sizeof loads / sizeof loads[0]; k++) {
        double sign = chance(rng, 0.5) ? 1 : -1;
        set_parameter(spec, loads[k], sign * corner_or(rng, zero, 3, 1e-3, 1e3));
    }
    if (chance(rng, 0.6))
        set_parameter(spec, "kz", 0);
    random_stops(rng, spec, log_between(rng, 1e-3, 10));
}

/* A value just outside its range, or none at all. */
static inline void spoil(gsl_rng *rng, saltus_spec *spec) {
    static const double wrong[] = {NAN, INFINITY, -INFINITY, -1e-9, 1e13};
    int count;
    saltus_model_parameters(spec->model, &count);
    double value = wrong[gsl_rng_uniform_int(rng, 5)];
    if (spec->stop_count && chance(rng, 0.5)) {
        saltus_stop *stop = &spec->stops[gsl_rng_uniform_int(rng, (unsigned long)spec->stop_count)];
        *(chance(rng, 0.5) ? &stop->r : &stop->d) = value;
    } else {
        spec->parameters[gsl_rng_uniform_int(rng, (unsigned long)count)] = value;
    }
}

/* The absolute tolerance stays below what the scene is about: its smallest clearance. */
static inline saltus_flow_options random_options(gsl_rng *rng, const saltus_spec *spec) {
    saltus_flow_options options = saltus_flow_defaults();
    double length = 1e-3;
    for (int s = 0; s < spec->stop_count; s++)
        if (fabs(spec->stops[s].d) > 0)
            length = fmin(length, fabs(spec->stops[s].d));
    options.rtol = pow(10, between(rng, -15, -3));
    options.atol = options.rtol * length * log_between(rng, 1e-9, 1e-2);
    if (chance(rng, 0.2))
        options.order = 8 + (int)gsl_rng_uniform_int(rng, 33);
    if (chance(rng, 0.2))
        options.integrator = chance(rng, 0.5) ? SALTUS_TAYLOR : SALTUS_RADAU;
    return options;
}

/* Bring a state onto a stop, at rest there or not; the second round takes what rounding left of the first. */
static inline void put_on_stop(const saltus_system *system, int index, bool rests, double *x) {
    saltus_face face = saltus_system_face(system, index);
    const double *normal = saltus_system_stop_normal(system, face.stop);
    int n = saltus_system_dof(system);
    for (int round = 0; round < 2; round++) {
        double square = 0, gap = -face.side * face.d, rate = 0;
        for (int i = 0; i < n; i++) {
            square += normal[i] * normal[i];
            gap += normal[i] * x[i];
            rate += normal[i] * x[n + i];
        }
        for (int i = 0; i < n; i++) {
            x[i] -= gap * normal[i] / square;
            x[n + i] -= rests ? rate * normal[i] / square : 0;
        }
    }
}

/* A start: random, at rest on a stop, moving along it, or somewhere that may be beyond one. */
static inline void random_state(gsl_rng *rng, const saltus_system *system, double *x) {
    const double *scale = saltus_system_scale(system);
    int n = saltus_system_dof(system), faces = saltus_system_face_count(system);
    saltus_message message;
    if (saltus_system_default_state(system, x, &message) != SALTUS_OK || chance(rng, 0.2))
        for (int i = 0; i < n; i++)
            x[i] = gsl_ran_gaussian(rng, chance(rng, 0.5) ? 0.3 : 1) * scale[i];
    double speed = chance(rng, 0.2) ? 0 : log_between(rng, 1e-3, 3);
    for (int i = 0; i < n; i++)
        x[n + i] = speed * gsl_ran_gaussian(rng, 1) * scale[n + i];
    if (faces == 0 || !chance(rng, 0.3))
        return;
    int face = (int)gsl_rng_uniform_int(rng, (unsigned long)faces);
    bool rests = chance(rng, 0.5);
    saltus_face stop = saltus_system_face(system, face);
    double reach = 0;
    for (int i = 0; i < n; i++)
        reach += fabs(saltus_system_stop_normal(system, stop.stop)[i]) * scale[i];
    if (fabs(stop.d) < 100 * reach)
        put_on_stop(system, face, rests, x);
}

#endif
