/* Private: how tangent vectors grow along a trajectory in one lane of a flow.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_GROWTH_H
#define SALTUS_MOTION_GROWTH_H

#include "base/memory.h"
#include "saltus/average.h"
#include "saltus/flow.h"

#include <gsl/gsl_integration.h>
#include <gsl/gsl_rng.h>

/* The sample under way. */
typedef struct saltus_growth_sample {
    long long begin;    /* cycle at which it began */
    int part;           /* orthonormalisations done in it */
    double widest;      /* largest ratio of growths between two of them, as a logarithm */
    double trace;       /* integral of the trace so far */
    double *logarithms; /* of the growths so far */
} saltus_growth_sample;

/* Orthonormal vectors, in the system's scales, that the flow carries from one orthonormalisation to the next.
 * One sample of their growth is taken each `whole` periods, at phase 0. */
typedef struct saltus_growth {
    int n, columns;
    int whole;      /* periods per sample, */
    int parts;      /* and orthonormalisations in it: 1 where `whole` is greater */
    bool fixed;     /* the interval has been prescribed */
    unsigned watch; /* events at which directions may be lost, or the trace is added up */
    const gsl_integration_glfixed_table *table; /* for the trace; NULL: it is not wanted */
    double *vectors, *length, *work;
    saltus_growth_sample open;
    double *sample;  /* logarithms of the growths over the last whole sample */
    double trace;    /* integral of the trace likewise, where all directions are followed */
    int calm;        /* samples with little growth in a row */
    int lost;        /* most directions seen to be lost at once */
    long long steps; /* of the lane, when the trace was last added up */
} saltus_growth;

/* Reserve its arrays (two passes, see base/memory.h). */
void saltus_growth_reserve(saltus_growth *growth, saltus_arena *arena, int n, int columns);
/* Prescribe the interval in periods (0: chosen from the growth), and give it a table for the trace. */
void saltus_growth_choose(saltus_growth *growth, const saltus_system *system, double interval,
                          const gsl_integration_glfixed_table *table);
/* Begin at the lane's section point with random directions. */
void saltus_growth_begin(saltus_growth *growth, saltus_flow *flow, int lane, gsl_rng *rng);
/* Aim the lane at the next orthonormalisation. */
void saltus_growth_aim(const saltus_growth *growth, saltus_flow *flow, int lane);
/* What follows from an event of the lane. *complete says whether a sample is complete. Errors: SALTUS_STALLED
 * when the vectors have grown beyond numbers. */
saltus_status saltus_growth_follow(saltus_growth *growth, saltus_flow *flow, int lane,
                                   const saltus_event *event, bool *complete, saltus_message *message);

/* An exponent per unit of time from the mean growth per sample: a sample lasts `length` and takes so many
 * steps of the flow, each of which leaves an error of its tolerance in a vector's length. */
saltus_estimate saltus_growth_exponent(saltus_estimate growth, double steps, double tolerance, double length);

#endif
