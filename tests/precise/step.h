/* One step of the flow in 128 bits by extrapolation: Gragg's modified midpoint rule with 2, 4, 6, ...
 * substeps, carried to step size zero by Neville's scheme in the squares of the substeps until that changes
 * nothing. Bulirsch and Stoer,
 * Numerische Mathematik 8 (1966) 1-13; Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I,
 * II.9.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PRECISE_STEP_H
#define PRECISE_STEP_H

#include "model.h"

enum { step_columns = 24 };

typedef struct step {
    const model *model;
    int columns;    /* of the extrapolation; the order is twice as high */
    real tolerance; /* of the state in a step, relative to its largest displacement and velocity */
    real slackness; /* how much more is granted to the tangent vectors */
    int held;       /* the side whose contact holds, or 0 */
    real floor; /* size of a tangent vector below which its error is no longer relative to it: a contact that
                   holds leaves rounding of some */
    real *work;
} step;

/* Room for `vectors` vectors; false without memory. */
bool step_open(step *s, const model *m, int columns, real tolerance, int vectors);
void step_close(step *s);
/* The flow of the block x over h from tau, and its error in units of the tolerance. */
real step_take(const step *s, real tau, real h, int vectors, const real *x, real *result);
/* The step size that the error of a step of size h suggests. */
real step_next(const step *s, real h, real error);

#endif
