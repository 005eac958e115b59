/* Private to the files shooting*.c: the workspace.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_SHOOTING_PRIVATE_H
#define SALTUS_ORBIT_SHOOTING_PRIVATE_H

#include "base/dense.h"
#include "base/memory.h"
#include "orbit/shooting.h"

struct saltus_shooting {
    saltus_arena arena;       /* of the vectors that depend on the state's dimension alone */
    saltus_arena shape_arena; /* of those that depend on the sequence */
    saltus_spec spec;
    saltus_direction direction;
    bool has_direction;
    double origin, unit;
    saltus_orbit_options options;
    saltus_system *system;
    double value; /* of the parameter that `system` has */
    saltus_flow *flow;
    int n, columns;
    saltus_sequence sequence;
    int unknowns, equations;
    double length, speed, force; /* scales of gaps, normal speeds, normal accelerations */
    /* n-sized */
    double *state_scale, *end, *tangents, *gradient, *shift;
    /* sequence-sized */
    double *scale;                        /* unknowns */
    double *plain;                        /* unknowns unscaled */
    double *residual;                     /* equations */
    double *jacobian;                     /* equations x unknowns */
    double *answer, *next;                /* n x unknowns: how the state at hand answers to the unknowns */
    double *matrix, *step, *trial, *kept; /* for Newton's method */
    saltus_dense_lu lu;
    double residual_size;
    saltus_breach *breaches;
    int breach_count, breach_room;
};

/* Make the system that of a parameter value. */
saltus_status saltus_shooting_tune(saltus_shooting *shooting, double value, saltus_message *message);

#endif
