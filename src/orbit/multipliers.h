/* Floquet multipliers of an orbit, from its derivative in short segments.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_MULTIPLIERS_H
#define SALTUS_ORBIT_MULTIPLIERS_H

#include "orbit/lap.h"

#include <gsl/gsl_integration.h>

/* The derivative along an orbit as the product A_count ... A_1 of derivatives over segments so short that
 * each keeps the digits of its smallest singular value. It is filled piece by piece from a flow with n
 * columns, and is the workspace for that. */
typedef struct saltus_cocycle {
    int n, count, room, periods;
    bool given;          /* the matrices come from elsewhere: following an orbit adds all but these */
    int zeros;           /* multipliers that are zero because directions are lost (lasting contacts, r = 0) */
    double *segments;    /* count matrices n x n, by columns */
    double sum_rule;     /* integral of the trace, and 2 ln r for each impact */
    double density;      /* of segments, per period */
    int most;            /* segments a period that may be spent on the smallest multipliers; 0: any number */
    double wanted;       /* at least as many, as an orbit before has shown; 0: not known */
    double *columns;     /* the identity, and room for a state */
    bool autonomous;     /* the flow's own direction is a multiplier of 1, which is told apart */
    const double *scale; /* the system's */
    double *fields;      /* then: the direction of the flow at each segment's begin, in the system's scales */
    gsl_integration_glfixed_table *table;
} saltus_cocycle;

/* An empty cocycle for orbits of so many periods, `autonomous` for those of a scene without forcing that are
 * no rests; its memory is used again. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_cocycle_open(saltus_cocycle *cocycle, const saltus_system *system, int periods,
                                  bool autonomous, saltus_message *message);
/* A flow that a cocycle over so many periods, of which only `most` need be set, is followed by. In segments
 * so short that the fastest modes of a stiff system are still under way at their ends, steps as short as
 * stability wants are no loss: Taylor's method is 2 to 3 times faster there than Radau's, and slower where
 * segments are long (measured on pipes of 14 to 32 modes). The caller frees the flow. Errors: those of
 * saltus_flow_new. */
saltus_status saltus_cocycle_flow(const saltus_cocycle *cocycle, const saltus_system *system, int periods,
                                  const saltus_flow_options *options, saltus_flow **flow,
                                  saltus_message *message);
/* Whether the flows that orbits are found with follow such a cocycle as well as one of its own. */
bool saltus_cocycle_takes(const saltus_cocycle *cocycle, const saltus_system *system, int periods,
                          const saltus_flow_options *options);
/* One matrix more, by columns. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_cocycle_add(saltus_cocycle *cocycle, const double *matrix, saltus_message *message);
/* A zeroed cocycle is accepted. */
void saltus_cocycle_close(saltus_cocycle *cocycle);
/* Follow lane 0 of a flow to a time; contact events go to the lap (may be NULL). Errors: those of the flow,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_cocycle_follow(saltus_cocycle *cocycle, saltus_flow *flow, saltus_time until,
                                    saltus_lap *lap, saltus_message *message);

/* Multipliers of a cocycle whose matrices the caller has: n of them to `out`, by decreasing modulus. The last
 * `zeros` are exact zeros (log_modulus -INFINITY); those that no segment's digits resolve are NAN.
 * `log_volume` receives the sum of the log moduli of those that are not exact zeros, NAN if some are not
 * resolved. Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_cocycle_multipliers(const double *segments, int n, int count, int zeros,
                                         saltus_multiplier *out, double *log_volume, saltus_message *message);

/* The multipliers of a cocycle that has been followed once around an orbit: *count of them to `out`, the
 * dimension or, of an autonomous orbit, one less; *trivial is then the multiplier along the flow, as
 * computed, otherwise 0. Autonomous, the segments are used up. Errors: as above. */
saltus_status saltus_cocycle_solve(saltus_cocycle *cocycle, saltus_multiplier *out, int *count,
                                   double *trivial, double *log_volume, saltus_message *message);

/* Fill orbit->monodromy, multipliers, sticks, log_volume and sum_rule from orbit->state, which must be a
 * periodic point of period orbit->periods. The arrays are allocated. Errors: those of the flow,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_orbit_multipliers(const saltus_system *system, const saltus_orbit_options *options,
                                       saltus_orbit *orbit, saltus_message *message);

#endif
