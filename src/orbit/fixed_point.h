/* Private: plain steps of Newton's method for a fixed point of the stroboscopic map's iterate, in the
 * system's scales. They are cheap, and given up as soon as they do not converge; what they find is confirmed
 * by saltus_return_polish.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_FIXED_POINT_H
#define SALTUS_ORBIT_FIXED_POINT_H

#include "base/memory.h"
#include "saltus/map.h"

typedef struct saltus_fixed_point {
    saltus_arena arena;
    saltus_map *map;
    const double *scale;
    int n;
    double *state, *image; /* of the map */
    double *derivative;    /* of the map at the state, scaled */
    double *matrix, *work;
    int *pivots;
} saltus_fixed_point;

/* For orbits of so many periods; the caller sets `state`. Errors: those of saltus_map_new. Close in any case.
 */
saltus_status saltus_fixed_point_open(saltus_fixed_point *point, const saltus_system *system, int periods,
                                      const saltus_flow_options *options, saltus_message *message);
void saltus_fixed_point_close(saltus_fixed_point *point);
/* Compute image and derivative; returns the largest difference of image and state, INFINITY where the flow
 * fails. */
double saltus_fixed_point_residual(saltus_fixed_point *point);
/* Newton's step from the state, after its residual; the step's length, INFINITY where there is none. */
double saltus_fixed_point_step(saltus_fixed_point *point);
/* Newton's method from a point, in so many steps at most: whether it comes to a residual of 1e-6. It is given
 * up where the residual grows tenfold, and where the state leaves the point by more than `reach` (in scales):
 * far out a single period can take as long as a million of the motion's. */
bool saltus_fixed_point_find(saltus_fixed_point *point, const double *from, int steps, double reach);
/* Logarithm of the largest multiplier's modulus at the last residual; NAN where the derivative does not tell
 * it from rounding. */
double saltus_fixed_point_multiplier(saltus_fixed_point *point);

#endif
