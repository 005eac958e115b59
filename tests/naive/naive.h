/* The naive method, on trial: NOT FOR USE. Classical fourth-order Runge-Kutta with a fixed step and a contact
 * test at step ends, for a pipe with a stop.
 *
 * It is what the 2020 paper describes, and stands here to show what such a method makes of the same
 * equations. After each step of length h (a fraction of the unit of time, not of T): where the contact
 * coordinate is at or beyond the clearance and its velocity points into the stop, that velocity is reversed
 * by the restitution law. The contact is not located, the displacement stays where it is, and nothing is done
 * about chatter or lasting contact. It has its own vector field, written from the equations and shared with
 * nothing of the library.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_NAIVE_H
#define SALTUS_TESTS_NAIVE_H

#include "saltus/system.h"

enum { naive_modes_max = 8, naive_lanes = 8, naive_size_max = 2 * naive_modes_max };

/* The pipe's coefficients; a stop is at most one. */
typedef struct naive_pipe {
    int modes;
    double alpha, root_beta, kappa, u0, sigma, omega;
    double lambda2[naive_modes_max];
    double gyroscopic[naive_modes_max][naive_modes_max]; /* G_ij */
    double gradient[naive_modes_max][naive_modes_max];   /* B_ij */
    double normal[naive_modes_max], normal_square;       /* of the stop, or of mid-span without one */
    bool upper, lower;
    double d, r;
} naive_pipe;

/* Several trajectories of one pipe side by side, entry by entry: q, then q'. */
typedef struct naive_states {
    double x[naive_size_max][naive_lanes];
} naive_states;

/* What the steps of one trajectory have met so far. */
typedef struct naive_tally {
    long long reversals;  /* each time the contact test reversed a velocity */
    long long impacts;    /* the same, but reversals at successive steps count as one */
    long long contacts;   /* lasting contacts: at least `naive_run` reversals at successive steps */
    long long held_steps; /* steps that belong to lasting contacts */
    long long last;       /* step of the last reversal */
    int run;              /* reversals at successive steps up to it */
    double largest_speed; /* before an impact */
    double deepest;       /* largest penetration, g - d */
} naive_tally;

enum { naive_run = 10 };

typedef struct naive_runner {
    naive_pipe pipe;
    double h;
    long long step; /* steps made; the time is step * h */
    naive_states states;
    naive_tally tally[naive_lanes];
} naive_runner;

/* Take the pipe's coefficients from a specification. False for another model, for more than one stop, and for
 * more modes than there is room for. */
bool naive_pipe_from(const saltus_spec *spec, naive_pipe *pipe);
/* Begin at time zero with the same state in no lane yet. */
void naive_begin(naive_runner *runner, const naive_pipe *pipe, double h);
/* Put a state (q, then q') into a lane. */
void naive_put(naive_runner *runner, int lane, const double *state);
/* Make all steps that end at or before a time. */
void naive_run_until(naive_runner *runner, double time);
/* The states at a time not before the last step's end, by a Runge-Kutta step of their own from there: the
 * trajectories themselves stay on their steps. */
naive_states naive_states_at(const naive_runner *runner, double time);
/* Contact coordinate and its velocity in a lane. */
double naive_displacement(const naive_pipe *pipe, const naive_states *states, int lane);
double naive_velocity(const naive_pipe *pipe, const naive_states *states, int lane);

#endif
