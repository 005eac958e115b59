/* Private: several trajectories on one attractor, and the growth of tangent vectors along each.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_ENSEMBLE_H
#define SALTUS_MOTION_ENSEMBLE_H

#include "motion/growth.h"
#include "saltus/lyapunov.h"
#include "signal/random.h"

enum { SALTUS_MEMBERS_MAX = 64, SALTUS_HISTORY_ROOM = 512 };

typedef struct saltus_member {
    saltus_flow *flow; /* it runs in this lane of the ensemble's flow */
    int lane;
    saltus_growth growth;
    saltus_average *averages; /* one per column: growth per sample; the last one: logarithm of the volume */
    saltus_flow_info begin;   /* of the flow when the measurement began */
    double volume;            /* logarithm of what impacts have left of it until the last sample */
    long long samples;        /* taken */
    double recent;            /* logarithm of the first vector's growth since the last run began */
    double *state;            /* at the last sample */
} saltus_member;

typedef struct saltus_ensemble {
    const saltus_system *system;
    const saltus_lyapunov_options *options;
    saltus_arena arena;
    int n, columns, members;
    int width, flow_count; /* flows of up to `width` members each */
    saltus_flow *flows[SALTUS_MEMBERS_MAX];
    saltus_member member[SALTUS_MEMBERS_MAX];
    gsl_integration_glfixed_table *table;
    saltus_random random;
    long long transient; /* periods before the measurement */
    const volatile sig_atomic_t
        *stop;    /* looked at in the transient, once a period, beside the flows' own; NULL: not */
    bool stopped; /* by it */
    /* The first `room` section points of each member, one member after the other, and the logarithms of the
     * first vector's growth until each. */
    long long room;
    double *points, *growths;
} saltus_ensemble;

/* Make its flows, and room for so many section points of each member; the options and the system must outlive
 * it. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_ensemble_open(saltus_ensemble *ensemble, const saltus_system *system,
                                   const saltus_lyapunov_options *options, long long room,
                                   saltus_message *message);
/* A zeroed one is accepted. */
void saltus_ensemble_close(saltus_ensemble *ensemble);
/* Run the transient from a state and place the members along its last half. Errors: those of the flow. */
saltus_status saltus_ensemble_place(saltus_ensemble *ensemble, const double *state, saltus_message *message);
/* Measure so many samples more in each member. Errors: those of the flow, SALTUS_STALLED. */
saltus_status saltus_ensemble_run(saltus_ensemble *ensemble, long long samples, saltus_message *message);
/* What has been measured so far counts as transient. */
void saltus_ensemble_forget(saltus_ensemble *ensemble);
/* Periods measured by all members together. */
long long saltus_ensemble_periods(const saltus_ensemble *ensemble);
/* Most directions lost in any member. */
int saltus_ensemble_lost(const saltus_ensemble *ensemble);
/* Whether weighted means serve the largest exponent of all members. They are then used for all exponents:
 * sums of exponents are exact where all have the same kind of mean. */
bool saltus_ensemble_regular(const saltus_ensemble *ensemble);
/* An exponent per unit of time, by weighted or plain means, of one member and of all; column `columns` is the
 * growth of volumes, by trace and restitution, where all exponents are measured. */
saltus_estimate saltus_ensemble_member(const saltus_ensemble *ensemble, int member, int column,
                                       bool weighted);
saltus_estimate saltus_ensemble_exponent(const saltus_ensemble *ensemble, int column, bool weighted);
/* The largest exponent, by the means that serve it. */
saltus_estimate saltus_ensemble_largest(const saltus_ensemble *ensemble);
/* Add it, as it is now, to a history with room for SALTUS_HISTORY_ROOM entries, if it has an error. Where
 * there is no room every second entry goes. */
void saltus_ensemble_record(const saltus_ensemble *ensemble, saltus_estimate now,
                            saltus_lyapunov_progress *history, int *count);
/* The largest exponent over a part of the run, 0 <= from < to <= 1. */
saltus_estimate saltus_ensemble_part(const saltus_ensemble *ensemble, double from, double to);
/* Whether the members' largest exponents scatter no more than their standard errors allow, or are within
 * `tolerance` of that of all. */
bool saltus_ensemble_agrees(const saltus_ensemble *ensemble, double tolerance);

#endif
