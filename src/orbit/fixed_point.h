/* Private: plain Newton steps towards a fixed point of an iterate of the stroboscopic map, in the system's
 * scales. They are cheap and given up as soon as they do not converge; saltus_return_polish confirms results.
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
    double state[SALTUS_STATE_MAX], image[SALTUS_STATE_MAX]; /* point and image of the map */
    double *derivative, *matrix; /* derivative of the map at the state, scaled; work space */
} saltus_fixed_point;

/* Open for orbits of `periods` periods; the caller sets `state` and always closes. Errors: those of
 * saltus_map_new. */
saltus_status saltus_fixed_point_open(saltus_fixed_point *point, const saltus_system *system, int periods,
                                      const saltus_flow_options *options, saltus_message *message);
void saltus_fixed_point_close(saltus_fixed_point *point);
/* Compute image and derivative. Returns their largest scaled distance from the state; INFINITY: failure. */
double saltus_fixed_point_residual(saltus_fixed_point *point);
/* Take Newton's step, after the residual at the state. Returns its length, INFINITY if there is no step. */
double saltus_fixed_point_step(saltus_fixed_point *point);
/* Newton's method from a point, with at most `steps` steps: whether it reaches a residual of 1e-6. It gives
 * up if the residual grows tenfold or the state moves farther than `reach` (in scales) from the point: far
 * out a single period can take as long as a million periods of the motion. */
bool saltus_fixed_point_find(saltus_fixed_point *point, const double *from, int steps, double reach);
/* Logarithm of the largest multiplier's modulus at the last residual; NAN if rounding hides it. */
double saltus_fixed_point_multiplier(saltus_fixed_point *point);

#endif
