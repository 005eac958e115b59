/* Assorted small scenes with a start, for rules that hold in any of them: both models, stops on one side, on
 * both and none, one coordinate and several, impacts, chatter, sticking and release.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_SCENES_H
#define SALTUS_TESTS_SCENES_H

#include "check.h"

enum { scene_dimension_max = 12, scene_columns_max = scene_dimension_max + SALTUS_DIRECTIONS_MAX };

typedef struct scene {
    saltus_spec spec;
    double phase, state[scene_dimension_max];
} scene;

typedef enum scene_name {
    scene_struck_pipe,
    scene_two_sided_pipe,
    scene_chattering_pipe,
    scene_caught_pipe, /* r = 0 */
    scene_free_pipe,
    scene_steady_pipe,
    scene_two_sided_mass,
    scene_chattering_mass,
    scene_struck_chain, /* two masses, a stop between them and one for the second */
    scene_caught_chain, /* two masses, both come to rest on their stops */
    scene_maxwell_mass,
    scene_free_chain,
    scene_impact_pair,
    scenes
} scene_name;

static inline saltus_stop *scene_stop(scene *s, double d, double r, saltus_sides sides) {
    add_stop(&s->spec, d, r, sides);
    return &s->spec.stops[s->spec.stop_count - 1];
}

static inline scene scene_pipe(double modes, double omega) {
    scene s = {.spec = pipe_spec(modes, omega), .phase = 0.2};
    s.state[0] = 0.006;
    s.state[(int)modes] = 0.12;
    if (modes > 1) {
        s.state[1] = 0.002;
        s.state[(int)modes + 1] = -0.03;
    }
    return s;
}

static inline scene scene_mass(double c, double k, double force, double omega) {
    scene s = {.spec = oscillator_spec(c, k, force, omega), .phase = 0.3, .state = {0.02, 0.3}};
    set_parameter(&s.spec, "m", 1.4);
    return s;
}

static inline scene scene_chain(double c, double k, double force, double omega) {
    scene s = scene_mass(c, k, force, omega);
    set_parameter(&s.spec, "N", 2);
    set_parameter(&s.spec, "m2", 0.7);
    set_parameter(&s.spec, "c2", 0.06);
    set_parameter(&s.spec, "k2", 0.9);
    set_parameter(&s.spec, "F2", 0.4);
    set_parameter(&s.spec, "F02", 0.05);
    s.state[1] = -0.03;
    s.state[2] = 0.2;
    s.state[3] = 0.35;
    return s;
}

static inline scene scene_of_pipe(scene_name name) {
    scene s = scene_pipe(3, 42);
    switch (name) {
    case scene_struck_pipe:
        scene_stop(&s, 0.012, 0.9, SALTUS_UPPER);
        break;
    case scene_two_sided_pipe:
        s = scene_pipe(2, 14);
        scene_stop(&s, 0.015, 0.8, SALTUS_BOTH)->xi = 0.3;
        break;
    case scene_chattering_pipe:
        s = scene_pipe(3, 10);
        scene_stop(&s, 0.018, 0.6, SALTUS_UPPER)->xi = 0.35;
        break;
    case scene_caught_pipe:
        s = scene_pipe(2, 10);
        s.state[0] = -0.008;
        scene_stop(&s, 0.012, 0, SALTUS_LOWER)->xi = 0.6;
        break;
    case scene_steady_pipe:
        set_parameter(&s.spec, "sigma", 0);
        scene_stop(&s, 0.012, 0.7, SALTUS_UPPER)->xi = 0.45;
        break;
    default:
        break;
    }
    return s;
}

static inline scene scene_of(scene_name name) {
    scene s;
    switch (name) {
    case scene_two_sided_mass:
        s = scene_mass(0.12, 1.3, 0.8, 0.9);
        scene_stop(&s, 0.3, 0.8, SALTUS_BOTH);
        return s;
    case scene_chattering_mass:
        s = scene_mass(0.12, 1.3, 0.8, 0.9);
        set_parameter(&s.spec, "F0", 0.4);
        scene_stop(&s, 0.2, 0.6, SALTUS_UPPER)->weight[0] = 2;
        return s;
    case scene_struck_chain:
        s = scene_chain(0.12, 1.3, 0.8, 0.9);
        scene_stop(&s, 0.25, 0.8, SALTUS_UPPER)->weight[1] = -1;
        *scene_stop(&s, 0.6, 0.6, SALTUS_BOTH)->weight = 0;
        s.spec.stops[1].weight[1] = 1.3;
        return s;
    case scene_caught_chain:
        s = scene_chain(0.12, 1.3, 1.2, 0.5);
        set_parameter(&s.spec, "F0", 0.5);
        set_parameter(&s.spec, "F02", -0.1);
        scene_stop(&s, 0.15, 0.3, SALTUS_UPPER)->weight[0] = 2;
        *scene_stop(&s, 0.2, 0, SALTUS_LOWER)->weight = 0;
        s.spec.stops[1].weight[1] = 0.8;
        return s;
    case scene_maxwell_mass:
        s = scene_mass(0.12, 1.3, 0.8, 0.9);
        set_parameter(&s.spec, "kz", 0.7);
        set_parameter(&s.spec, "tz", 1.9);
        s.state[2] = 0.05;
        scene_stop(&s, 0.25, 0.5, SALTUS_LOWER);
        return s;
    case scene_free_chain:
        s = scene_chain(0.12, 1.3, 0.8, 0.9);
        set_parameter(&s.spec, "kz", 0.7);
        set_parameter(&s.spec, "tz", 1.9);
        s.state[4] = 0.05;
        return s;
    case scene_impact_pair:
        s = scene_mass(0, 0, 1.1, 1.7);
        scene_stop(&s, 0.4, 0.7, SALTUS_BOTH);
        return s;
    default:
        return scene_of_pipe(name);
    }
}

/* The displacement that is observed, or its velocity. */
static inline double observed(const saltus_system *system, const double *row) {
    double sum = 0;
    for (int i = 0; i < saltus_system_dof(system); i++)
        sum += saltus_system_observer(system)[i] * row[i];
    return sum;
}

/* n.q, n.q' or n.q'' of a face, positive towards it. */
static inline double towards(const saltus_system *system, int face, const double *row) {
    saltus_face f = saltus_system_face(system, face);
    double sum = 0;
    for (int i = 0; i < saltus_system_dof(system); i++)
        sum += saltus_system_stop_normal(system, f.stop)[i] * row[i];
    return f.side * sum;
}

#endif
