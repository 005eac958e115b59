/* Once along an orbit: the flow over whole forcing periods from tau = 0, with its impacts.
 *
 * Every step is searched for contact: the state at its end lies beyond the stop, or the contact coordinate
 * turns back inside the step, beyond the stop. The time comes from Newton's method, safeguarded by bisection,
 * in which every trial is an extrapolated step from the step's beginning. The first step after an impact ends
 * before the stop can be met again. Chatter is not followed to its end: it is refused.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PRECISE_PASSAGE_H
#define PRECISE_PASSAGE_H

#include "step.h"

enum { passage_impacts = 256, passage_periods = 64 };

typedef struct impact {
    int side;         /* +1 upper, -1 lower */
    real time, speed; /* in periods; n.q' before */
} impact;

typedef struct passage {
    int vectors; /* of x: the state and 0 or n tangent vectors */
    real x[model_dimension * (model_dimension + 1)];
    real section[passage_periods][model_dimension]; /* at tau = 0, T, 2 T, ... */
    impact impacts[passage_impacts];
    int impact_count;
    /* Touches that are passed over, of an orbit and, where it is its own mirror image, half of it later:
     * contacts within `around` of them, in periods; the highest gap there. */
    real touch[2], around, height;
    long steps, refused;
} passage;

/* Follow `start` for that many periods. With `tangents` the matrix of the variational equations, saltation
 * included, is left in the tangent vectors: vector 1 + j is its column j. On failure: a phrase that says why.
 */
const char *passage_run(passage *p, step *s, int periods, bool tangents, const real *start);

#endif
