/* Private: how tangent vectors grow along a trajectory in one lane of a flow.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_GROWTH_H
#define SALTUS_MOTION_GROWTH_H

#include "base/memory.h"
#include "saltus/average.h"
#include "saltus/flow.h"

#include <gsl/gsl_integration.h>
#include <gsl/gsl_rng.h>

/* The sample being taken. */
typedef struct saltus_growth_sample {
    long long begin;    /* cycle at which it began */
    int part;           /* orthonormalisations done in it */
    double widest;      /* largest spread of the vectors' growths in one part, as a logarithm */
    double trace;       /* integral of the trace so far */
    double *logarithms; /* logarithms of the vectors' growths so far */
} saltus_growth_sample;

/* Tangent vectors, orthonormal in the system's scales, that the flow carries from one orthonormalisation to
 * the next. One sample of their growth is taken every `whole` periods, at phase 0. */
typedef struct saltus_growth {
    int n, columns;
    int whole;      /* periods per sample */
    int parts;      /* orthonormalisations per sample; 1 if `whole` > 1 */
    bool fixed;     /* the interval is prescribed and not adapted */
    unsigned watch; /* events at which directions may be lost or the trace is integrated */
    const gsl_integration_glfixed_table *table; /* for the trace; NULL: not wanted */
    double *vectors, *length, *work;
    saltus_growth_sample open;
    double *sample;  /* logarithms of the growths over the last complete sample */
    double trace;    /* integral of the trace over it, if all directions are followed */
    int calm;        /* number of latest samples in a row with little growth */
    int lost;        /* largest number of directions lost at once so far */
    long long steps; /* the lane's steps when the trace was last integrated */
} saltus_growth;

/* Reserve the arrays (two passes, see base/memory.h). */
void saltus_growth_reserve(saltus_growth *growth, saltus_arena *arena, int n, int columns);
/* Set the interval between orthonormalisations in periods (0: adapted to the growth), and the quadrature
 * table for the trace (NULL: not wanted). */
void saltus_growth_choose(saltus_growth *growth, const saltus_system *system, double interval,
                          const gsl_integration_glfixed_table *table);
/* Begin at the lane's section point with random directions. */
void saltus_growth_begin(saltus_growth *growth, saltus_flow *flow, int lane, gsl_rng *rng);
/* Set the lane's target to the next orthonormalisation. */
void saltus_growth_aim(const saltus_growth *growth, saltus_flow *flow, int lane);
/* Process an event of the lane. *complete: a sample is complete. Errors: SALTUS_STALLED when the vectors
 * overflow. */
saltus_status saltus_growth_follow(saltus_growth *growth, saltus_flow *flow, int lane,
                                   const saltus_event *event, bool *complete, saltus_message *message);

/* An exponent per unit of time from the mean growth per sample. A sample lasts `length` and takes `steps`
 * steps of the flow, each of which contributes an error of `tolerance`. */
saltus_estimate saltus_growth_exponent(saltus_estimate growth, double steps, double tolerance, double length);

#endif
