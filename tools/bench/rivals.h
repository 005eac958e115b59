/* One hybrid trajectory of the pipe against one upper stop, integrated by established libraries.
 *
 * These are the programs that Saltus is compared with. All of them share one hand-written vector field, one
 * impact law and one rule for ending a chatter, so what they differ in is the integrator and the location of
 * events. Every quantity is nondimensional; model.md defines the symbols.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_RIVALS_H
#define SALTUS_BENCH_RIVALS_H

/* What a rival's `run` returns. After a bad argument or a failed allocation nothing was integrated. */
enum rival_status {
    RIVAL_OK = 0,
    RIVAL_BAD_ARGUMENT, /* a parameter is out of range, or the start lies beyond the stop */
    RIVAL_NO_MEMORY,    /* an allocation failed */
    RIVAL_FAILED        /* the library gave up or an event was not located; the result ends there */
};

/* Pipe pinned at both ends, with one stop above it. */
typedef struct {
    int modes;    /* number N of Galerkin modes, at least 1 */
    double alpha; /* Kelvin-Voigt damping */
    double beta;  /* fluid mass over total mass, in [0, 1) */
    double kappa; /* axial-stretching stiffness */
    double u0;    /* mean flow velocity */
    double sigma; /* relative amplitude of the pulsation; 0 makes the flow steady */
    double omega; /* forcing frequency, positive; the period is T = 2 pi / omega also when sigma is 0 */
    double xi;    /* position of the stop, in (0, 1) */
    double d;     /* clearance, positive */
    double r;     /* restitution coefficient, in [0, 1] */
} rival_pipe;

typedef enum { RIVAL_IMPACT = 0, RIVAL_STICK = 1, RIVAL_RELEASE = 2 } rival_event_kind;

typedef struct {
    double time_over_T;     /* time in forcing periods; for a stick, the point where the impacts accumulate */
    double normal_velocity; /* n.q' just before an impact, positive; 0 for a stick and a release */
    rival_event_kind kind;
} rival_event;

/* Filled by a rival. The caller owns both arrays and sets `events`, `capacity` and `state` beforehand. */
typedef struct {
    rival_event *events;    /* room for `capacity` events, in order of time; may be NULL when capacity is 0 */
    int capacity;           /* events beyond it are counted but not stored */
    int count;              /* number of events that happened, possibly more than capacity */
    double *state;          /* 2 N values: q then q' at the end of the run */
    long steps;             /* accepted steps; 0 where they are not counted */
    long field_evaluations; /* evaluations of the vector field, those for events and chatter included */
    double cpu_seconds;     /* processor time of the integration, set-up and release of memory left out */
} rival_result;

/* Integrates from tau = 0 and `state0` (2 N values: q then q', on the free side of the stop or at rest on it)
 * to exactly tau = periods * T. `rtol` (at least 0) and `atol` (positive) are the library's local tolerances
 * on every component of the state: displacements are of the order of d, velocities roughly ten times larger.
 * Thread-safe except where its table entry says otherwise. Returns a `rival_status`. */
typedef int (*rival_run)(const rival_pipe *pipe, const double *state0, int periods, double rtol, double atol,
                         rival_result *result);

typedef struct {
    const char *name; /* library, method and how events are located; static storage */
    rival_run run;
} rival;

/* All rivals built in, `saltus_rival_count` of them; those of SUNDIALS only where SALTUS_WITH_SUNDIALS was
 * defined. The ones of GSL switch GSL's process-wide error handler off while they run. */
extern const rival saltus_rivals[];
extern const int saltus_rival_count;

#endif
