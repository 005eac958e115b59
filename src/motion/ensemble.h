/* Private: several trajectories on one attractor, and the growth of tangent vectors along each.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_ENSEMBLE_H
#define SALTUS_MOTION_ENSEMBLE_H

#include "motion/growth.h"
#include "saltus/lyapunov.h"

typedef struct saltus_member {
    saltus_growth growth;
    saltus_average *averages; /* one per column: growth per sample; the last one: logarithm of the volume */
    double volume;            /* what impacts have taken of it until the last sample */
    saltus_flow_info begin;   /* of the flow when it began */
    long long samples, goal;  /* samples taken, and to be taken */
    double recent, grown;     /* growth of the first vector since the last run began */
    double *state;
} saltus_member;

typedef struct saltus_ensemble {
    const saltus_system *system;
    const saltus_lyapunov_options *options;
    saltus_arena arena;
    int n, columns, members, width; /* of a flow: `width` lanes */
    saltus_flow **flows;            /* of up to `width` members each */
    int flow_count;
    saltus_member *member;
    saltus_average *averages;
    gsl_integration_glfixed_table *table;
    gsl_rng *rng;
    long long transient; /* periods before the measurement */
    bool stopped;        /* by the caller, in the transient */
    double *initial;
    double *points; /* where the first member's section points go, `room` of them, or NULL; the owner's */
    long long room;
} saltus_ensemble;

/* Make its flows; the options and the system must outlive it. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_ensemble_open(saltus_ensemble *ensemble, const saltus_system *system,
                                   const saltus_lyapunov_options *options, saltus_message *message);
/* A zeroed one is accepted. */
void saltus_ensemble_close(saltus_ensemble *ensemble);
/* Run the transient from a state and place the members along its last half. Errors: those of the flow. */
saltus_status saltus_ensemble_place(saltus_ensemble *ensemble, const double *state, saltus_message *message);
/* Measure so many samples more in each member. Errors: those of the flow, SALTUS_STALLED. */
saltus_status saltus_ensemble_run(saltus_ensemble *ensemble, long long samples, saltus_message *message);
/* What has been measured so far counts as transient. */
void saltus_ensemble_forget(saltus_ensemble *ensemble);
/* Samples measured in each member, and the periods of all of them together. */
long long saltus_ensemble_samples(const saltus_ensemble *ensemble);
long long saltus_ensemble_periods(const saltus_ensemble *ensemble);
/* Most directions lost in any member. */
int saltus_ensemble_lost(const saltus_ensemble *ensemble);
/* Whether weighted means serve the largest exponent of all members, and hence are used for all exponents:
 * sums of exponents are then exact sums. */
bool saltus_ensemble_regular(const saltus_ensemble *ensemble);
/* An exponent per unit of time, by weighted or plain means; column `columns` is the growth of volumes, by
 * trace and restitution, where all exponents are measured. */
saltus_estimate saltus_ensemble_exponent(const saltus_ensemble *ensemble, int column, bool weighted);
/* The same over the first or second half of the run. */
saltus_estimate saltus_ensemble_half(const saltus_ensemble *ensemble, int column, int half);
/* Largest exponent of one member. */
saltus_estimate saltus_ensemble_member(const saltus_ensemble *ensemble, int member);
/* Whether the members' largest exponents scatter no more than their standard errors allow. */
bool saltus_ensemble_agrees(const saltus_ensemble *ensemble);
/* How far a member's largest exponent is from that of all, at most. */
double saltus_ensemble_spread(const saltus_ensemble *ensemble);
/* The state of a member now, at phase 0. */
const double *saltus_ensemble_state(const saltus_ensemble *ensemble, int member);

#endif
