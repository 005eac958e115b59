/* Private: several trajectories (members) on one attractor, and the growth of tangent vectors along each.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_ENSEMBLE_H
#define SALTUS_MOTION_ENSEMBLE_H

#include "motion/growth.h"
#include "saltus/lyapunov.h"
#include "signal/random.h"

enum { SALTUS_MEMBERS_MAX = 64, SALTUS_HISTORY_ROOM = 512 };

typedef struct saltus_member {
    saltus_flow *flow; /* one of the ensemble's flows, in which it runs in `lane` */
    int lane;
    saltus_growth growth;
    saltus_average *averages; /* growth per sample of each vector; the last one, of the volume */
    saltus_flow_info begin;   /* the flow's counters when the measurement began */
    double volume;            /* the flow's log_volume (the impacts' share) at the last sample */
    long long samples;        /* since the measurement began */
    double recent;            /* logarithm of the first vector's growth over the last run */
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
        *stop;     /* checked once a period during the transient, beside the flows' own; NULL: never */
    bool stopped;  /* `stop` has ended the transient early */
    bool measures; /* the tangent vectors are aligned */
    double asked;  /* when `stop` was first seen while there was no result; 0: never */
    /* The first `room` section points of each member, member after member, and the logarithm of the first
     * vector's growth since the previous point. */
    long long room;
    double *points, *growths;
} saltus_ensemble;

/* Make the flows, and room for `room` section points of each member. Options and system must outlive the
 * ensemble. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_ensemble_open(saltus_ensemble *ensemble, const saltus_system *system,
                                   const saltus_lyapunov_options *options, long long room,
                                   saltus_message *message);
/* A zeroed one is accepted. */
void saltus_ensemble_close(saltus_ensemble *ensemble);
/* Run the transient from a state, place the members along its last half, and align their tangent vectors.
 * Errors: those of the flow. */
saltus_status saltus_ensemble_place(saltus_ensemble *ensemble, const double *state, saltus_message *message);
/* Where the members come to after so many samples from here, with no tangent vector, at less than half the
 * cost; the members themselves stay. `states` has room for all of them, one after the other, `points` for the
 * first member's section points on the way, one a sample. Errors: those of the flow, SALTUS_STALLED. */
saltus_status saltus_ensemble_ahead(const saltus_ensemble *ensemble, long long samples, double *states,
                                    double *points, saltus_message *message);
/* Place the members at states as told by saltus_ensemble_ahead of another ensemble of this system, and align
 * their tangent vectors. Errors: those of the flow. */
saltus_status saltus_ensemble_begin(saltus_ensemble *ensemble, const double *states, saltus_message *message);
/* Measure `samples` more samples of each member. Errors: those of the flow, SALTUS_STALLED;
 * SALTUS_INTERRUPTED a while after `stop` if they are the first. */
saltus_status saltus_ensemble_run(saltus_ensemble *ensemble, long long samples, saltus_message *message);
/* Discard all measurements; the time spent counts as transient. */
void saltus_ensemble_forget(saltus_ensemble *ensemble);
/* Periods measured, summed over all members. */
long long saltus_ensemble_periods(const saltus_ensemble *ensemble);
/* Largest number of directions that contacts have wiped out in any member. */
int saltus_ensemble_lost(const saltus_ensemble *ensemble);
/* Whether the largest exponents of all members converge with weighted means. These are then used for all
 * exponents: sums of exponents are exact only if all have the same kind of mean. */
bool saltus_ensemble_regular(const saltus_ensemble *ensemble);
/* An exponent per unit of time, by weighted or plain means: of one member, or of all. Column `columns` is
 * the growth rate of volumes by trace and restitution, if all exponents are measured. */
saltus_estimate saltus_ensemble_member(const saltus_ensemble *ensemble, int member, int column,
                                       bool weighted);
saltus_estimate saltus_ensemble_exponent(const saltus_ensemble *ensemble, int column, bool weighted);
/* The largest exponent, by weighted means if saltus_ensemble_regular. */
saltus_estimate saltus_ensemble_largest(const saltus_ensemble *ensemble);
/* Add the estimate `now` to a history with room for SALTUS_HISTORY_ROOM entries, if its error is finite. A
 * full history is thinned to every second entry. */
void saltus_ensemble_record(const saltus_ensemble *ensemble, saltus_estimate now,
                            saltus_lyapunov_progress *history, int *count);
/* The largest exponent over a part of the run, 0 <= from < to <= 1. */
saltus_estimate saltus_ensemble_part(const saltus_ensemble *ensemble, double from, double to);
/* Whether the members' largest exponents scatter no more than their standard errors allow, or all lie within
 * `tolerance` of the joint one. */
bool saltus_ensemble_agrees(const saltus_ensemble *ensemble, double tolerance);

#endif
