/* Scenes of Saltus as the rivals take them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_RIVAL_SCENE_H
#define SALTUS_BENCH_RIVAL_SCENE_H

#include "rivals.h"

#include "saltus/saltus.h"

#include <string.h>

/* `oscillator` holds what is an oscillator's own; it may be NULL if the model is a pipe. */
static inline rival_scene rival_scene_of(const saltus_spec *spec, rival_oscillator *oscillator) {
    const saltus_stop *stop = &spec->stops[0];
    rival_scene scene = {.modes = (int)saltus_spec_get(spec, "N"),
                         .omega = saltus_spec_get(spec, "omega"),
                         .sides = RIVAL_FREE};
    if (spec->stop_count > 0) {
        scene.xi = stop->xi;
        scene.d = stop->d;
        scene.r = stop->r;
        scene.sides = stop->sides == SALTUS_BOTH    ? RIVAL_BOTH
                      : stop->sides == SALTUS_LOWER ? RIVAL_LOWER
                                                    : RIVAL_UPPER;
    }
    if (strcmp(saltus_model_name(spec->model), "oscillator") == 0) {
        *oscillator = (rival_oscillator){.m = {saltus_spec_get(spec, "m"), saltus_spec_get(spec, "m2")},
                                         .c = {saltus_spec_get(spec, "c"), saltus_spec_get(spec, "c2")},
                                         .k = {saltus_spec_get(spec, "k"), saltus_spec_get(spec, "k2")},
                                         .force = {saltus_spec_get(spec, "F"), saltus_spec_get(spec, "F2")},
                                         .load = {saltus_spec_get(spec, "F0"), saltus_spec_get(spec, "F02")},
                                         .weight = {stop->weight[0], stop->weight[1]}};
        scene.oscillator = oscillator;
        return scene;
    }
    scene.alpha = saltus_spec_get(spec, "alpha");
    scene.beta = saltus_spec_get(spec, "beta");
    scene.kappa = saltus_spec_get(spec, "kappa");
    scene.u0 = saltus_spec_get(spec, "u0");
    scene.sigma = saltus_spec_get(spec, "sigma");
    return scene;
}

#endif
