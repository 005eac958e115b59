/* Once along an orbit: the flow over whole forcing periods from tau = 0, with its impacts.
 *
 * Every step is searched for contact: the state at its end lies beyond the stop, or the contact coordinate
 * turns back inside the step, beyond the stop. The time comes from Newton's method, safeguarded by bisection,
 * in which every trial is an extrapolated step from the step's beginning. The first step after an impact ends
 * before the stop can be met again.
 *
 * Chatter is followed impact by impact until the next flight would be shorter than 1e-10 periods; then the
 * contact holds. What the flights left out would change goes with the square of that. A contact that holds
 * takes what presses on it, until that is nothing.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PRECISE_PASSAGE_H
#define PRECISE_PASSAGE_H

#include "step.h"

enum { passage_impacts = 4096, passage_sticks = 64, passage_periods = 64 };

typedef struct impact {
    int side;         /* +1 upper, -1 lower */
    real time, speed; /* in periods; n.q' before */
} impact;

/* A contact that holds. */
typedef struct stick {
    int side;
    real begin, end; /* in periods */
    real least;      /* acceleration into the stop where that is least in between, or INFINITY */
} stick;

typedef struct passage {
    int vectors; /* of x: the state and 0 or n tangent vectors */
    real x[model_dimension * (model_dimension + 1)];
    real section[passage_periods][model_dimension]; /* at tau = 0, T, 2 T, ... */
    impact impacts[passage_impacts];
    int impact_count;
    stick sticks[passage_sticks];
    int stick_count;
    /* Touches that are passed over, of an orbit and, where it is its own mirror image, half of it later:
     * contacts within `around` of them, in periods; the highest gap there. */
    real touch[2], around, height;
    bool fresh; /* a contact has just let go */
    long steps, refused;
} passage;

/* Follow `start` for that many periods. With `tangents` the matrix of the variational equations, saltation
 * included, is left in the tangent vectors: vector 1 + j is its column j. On failure: a phrase that says why.
 */
const char *passage_run(passage *p, step *s, int periods, bool tangents, const real *start);

#endif
