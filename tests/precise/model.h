/* The two models in 128 bits: vector field with its variational equations, impact law, contact coordinate.
 *
 * A block of vectors of length n = 2 N lies one after the other: the state (q, q') first, then any number of
 * tangent vectors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PRECISE_MODEL_H
#define PRECISE_MODEL_H

#include "real.h"

#include <stdbool.h>

enum { model_modes = 32, model_dimension = 2 * model_modes };

typedef struct stop {
    bool upper, lower;
    real xi, d, r;
    real normal[model_modes], square; /* n and n.n */
} stop;

typedef struct model {
    bool pipe; /* else the oscillator with one mass */
    int modes;
    real alpha, beta, kappa, u0, sigma; /* pipe */
    real m, c, k, F, F0;                /* oscillator */
    real omega, period;
    stop stop;
    real lambda2[model_modes], damping[model_modes], bending[model_modes];
    real flow_velocity[model_modes][model_modes], flow_change[model_modes][model_modes];
} model;

/* Fill in what follows from the parameters. */
void model_prepare(model *m);
/* f = d/dtau of the state and of the tangent vectors; `held`: the stop takes what accelerates towards or away
 * from it. */
void model_field(const model *m, real tau, int vectors, const real *x, real *f, bool held);
/* n.v for the displacements or the velocities of a state. */
real model_contact(const model *m, const real *v);
/* The impact law and its saltation matrix on a whole block at time tau; `lands`: with no restitution, and the
 * contact holds from then on. */
void model_impact(const model *m, real tau, int vectors, real *x, bool lands);
/* Take the contact coordinate of a block's state to side * d and its rate to zero, those of its tangent
 * vectors to zero. */
void model_hold(const model *m, int side, int vectors, real *x);

#endif
