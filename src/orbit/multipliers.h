/* Floquet multipliers of an orbit, from its derivatives over short segments.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_MULTIPLIERS_H
#define SALTUS_ORBIT_MULTIPLIERS_H

#include "orbit/lap.h"

#include <gsl/gsl_integration.h>

enum { SALTUS_TRACE_POINTS = 6 };

/* Integral of the Jacobian's trace over a lane's last step, by Gauss quadrature on its dense output with a
 * table of SALTUS_TRACE_POINTS points: the other side of the sum rule (model.md, section 1). *steps is the
 * lane's number of steps at the previous call, initially the present one. The integral is 0 if no step was
 * made since, as between simultaneous impacts or if an event falls on the target. */
double saltus_trace_over_step(const saltus_flow *flow, int lane, const gsl_integration_glfixed_table *table,
                              long long *steps);
/* Number of directions that an event maps to zero: two per lasting contact; one for an impact without
 * rebound. */
int saltus_lost_directions(const saltus_flow *flow, int lane, const saltus_event *event);

/* The derivative along an orbit as the product A_count ... A_1 over segments so short that each keeps the
 * digits of its smallest singular value, if possible. It is filled piece by piece from a flow with n columns,
 * with work space. */
typedef struct saltus_cocycle {
    int n, count, room, periods;
    bool given;       /* the matrices come from saltus_cocycle_add: following an orbit adds everything else */
    int zeros;        /* exact zeros: directions lost by lasting contacts or r = 0 */
    double *segments; /* [count] matrices n x n, by columns */
    double sum_rule;  /* integral of the trace, plus 2 ln r per impact */
    bool mirrored;    /* the product of the multipliers is negative */
    double density;   /* segments per period */
    int most;         /* most segments per period for the smallest multipliers; 0: no limit */
    double wanted;    /* least segments per period, from a previous lap; 0: not known */
    bool autonomous;  /* the flow's direction is a multiplier of 1, which is kept apart */
    const double *scale; /* of the system */
    double *fields; /* if autonomous, [count][n]: scaled direction of the flow at the segments' beginnings */
    gsl_integration_glfixed_table *table;
} saltus_cocycle;

/* Empty a cocycle for orbits of `periods` periods, keeping its memory; `autonomous`: of a scene without
 * forcing, no rests. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_cocycle_open(saltus_cocycle *cocycle, const saltus_system *system, int periods,
                                  bool autonomous, saltus_message *message);
/* Create the flow that follows a cocycle over `periods` periods; of the cocycle only `most` need be set. If
 * segments are so short that the fastest modes of a stiff system are active at their ends, steps limited by
 * stability cost nothing: Taylor's method is then 2 to 3 times faster than Radau's, and slower for long
 * segments (measured on pipes of 14 to 32 modes). The caller frees the flow. Errors: those of
 * saltus_flow_new. */
saltus_status saltus_cocycle_flow(const saltus_cocycle *cocycle, const saltus_system *system, int periods,
                                  const saltus_flow_options *options, saltus_flow **flow,
                                  saltus_message *message);
/* Whether a flow used for finding orbits also suits such a cocycle. */
bool saltus_cocycle_takes(const saltus_cocycle *cocycle, const saltus_system *system, int periods,
                          const saltus_flow_options *options);
/* Add a matrix, by columns. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_cocycle_add(saltus_cocycle *cocycle, const double *matrix, saltus_message *message);
/* Whether a segment should end after an impact: errors of tangent vectors that have grown this much hide
 * directions that have not. `matrix`: the segment's so far, by columns. */
bool saltus_cocycle_ends(const saltus_cocycle *cocycle, const double *matrix);
/* Accepts a zeroed cocycle. */
void saltus_cocycle_close(saltus_cocycle *cocycle);
/* Follow lane 0 of a flow to a time; contact events go to `lap` (may be NULL). Errors: SALTUS_NO_MEMORY,
 * those of the flow. */
saltus_status saltus_cocycle_follow(saltus_cocycle *cocycle, saltus_flow *flow, saltus_time until,
                                    saltus_lap *lap, saltus_message *message);

/* The n multipliers of the product of given matrices, by decreasing modulus. The last `zeros` are exact zeros
 * (log_modulus -INFINITY); NAN: the segments do not keep their digits, see saltus_multiplier. `log_volume`
 * receives the sum of the log moduli without exact zeros, NAN if some are not resolved. Errors:
 * SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_cocycle_multipliers(const double *segments, int n, int count, int zeros,
                                         saltus_multiplier *out, double *log_volume, saltus_message *message);

/* The *count multipliers of a cocycle that was followed once around an orbit: the dimension, or one less if
 * autonomous. If the segments resolve all but one, that one is found by the sum rule. *trivial is then the
 * computed multiplier along the flow, otherwise 0. Consumes the segments of an autonomous cocycle. Errors: as
 * above. */
saltus_status saltus_cocycle_solve(saltus_cocycle *cocycle, saltus_multiplier *out, int *count,
                                   double *trivial, double *log_volume, saltus_message *message);

/* Allocate and fill orbit->monodromy and multipliers, and set sticks, log_volume and sum_rule. orbit->state
 * must be a point of period orbit->periods. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_orbit_multipliers(const saltus_system *system, const saltus_orbit_options *options,
                                       saltus_orbit *orbit, saltus_message *message);

#endif
