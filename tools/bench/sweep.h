/* The sweep's benchmark: one program's run of the sweep, its cost, and how far its motions deviate from exact
 * integration. What Saltus cannot do ends the program (must.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_SWEEP_H
#define SALTUS_BENCH_SWEEP_H

#include "must.h"
#include "rivals.h"
#include "saltus/saltus.h"

/* sweep_motion.c: records of motions, and their comparison. */
enum { settling_periods = 300, recorded_periods = 100, motion_dimension = 10 };

/* Replaces n if an orbit has infinitely many impacts. */
enum { orbit_chatters = -1 };

/* The recorded periods of one motion. */
typedef struct motion {
    double *impacts; /* their times in forcing periods after settling */
    int count, room, sticks;
    double settled[motion_dimension];   /* the state at the beginning of the recorded periods */
    double (*strobe)[motion_dimension]; /* states at the end of each recorded period, and at the beginning of
                                           the first; NULL if not requested */
    int orbit_impacts, orbit_periods;   /* n/p if the program reports it, otherwise 0/0 */
    bool failed;                        /* the integrator gave up, or no memory was left */
} motion;

/* Discard the records but keep the memory. */
void motion_clear(motion *m);
void motion_free(motion *m);
void motion_add_impact(motion *m, double time);

/* Least period, in forcing periods, with which the recorded stroboscopic states repeat to within `tolerance`
 * of the scale; 0 if there is none up to half of the record. */
int motion_period(const motion *m, const double *scale, double tolerance);

/* Whether `m` has the impacts of the periodic `reference`, counted over as many of its periods as were
 * recorded. `error` receives the largest difference between the impact times in the last period, in forcing
 * periods, after the best shift by whole periods (NAN if the counts differ). With sticking there are too many
 * impacts: sticks are counted instead, and there is no error.
 * `in_phase`: `m` has only the phases of impacts. All impacts of the recorded periods are counted, and those
 * of the last orbit are compared after the best cyclic shift. */
bool motion_agrees(const motion *reference, int period, const motion *m, bool in_phase, double *error);
/* Number of impacts per period of a periodic motion; orbit_chatters if it sticks. */
int motion_orbit_impacts(const motion *m, int period);

typedef enum program_kind {
    program_flow,   /* Saltus' flow, driven by this benchmark */
    program_engine, /* Saltus' sweeps, with classification */
    program_rival   /* another library's integrator */
} program_kind;

/* A program of the tables. Members that are not of its kind are ignored. */
typedef struct program {
    const char *name;
    program_kind kind;
    double rtol;    /* atol is rtol / 1000; of a rival, equal to it */
    bool unstopped; /* the scene has no stop */
    /* Saltus */
    int lanes;       /* 0: all, of sweeps only */
    int order;       /* 0: automatic */
    double step_max; /* of sweeps of the flow: longest step in units of time; 0: no limit */
    bool strobe;     /* of the flow: record stroboscopic states */
    int threads;
    unsigned keep; /* bits SALTUS_KEEP_... */
    bool adaptive; /* record as soon as the period is certain, at the latest after as many periods as
                      otherwise */
    const method *rival;
} program;

/* What a sweep cost. */
typedef struct sweep_cost {
    double seconds, wall; /* scaled to all omegas */
    double share;         /* fraction of the simulated time that was measured */
    long long steps, evaluations;
} sweep_cost;

enum { omegas_max = 1000, rival_events_max = 1 << 20 };

/* The axis of all programs. */
static const saltus_axis sweep_axis = {
    .key = "omega", .spacing = SALTUS_LINEAR, .count = omegas_max, .low = 0.5, .high = 55};

/* Tolerance of the reference motions. */
static const double exact = 1e-13;

/* The omegas of this run, and the reference motions. */
typedef struct sweep {
    int count;
    saltus_system *stopped[omegas_max], *unstopped[omegas_max];
    motion reference[omegas_max], found[omegas_max];
    int period[omegas_max]; /* 0: not periodic, or not the same in both tight runs */
    int periodic;
    int part;            /* rivals take every part-th omega */
    rival_event *events; /* storage for a rival's events */
} sweep;

/* sweep_run.c: the programs. */
/* Advance one forcing period from `state` (both states have motion_dimension entries) with Saltus' flow and
 * count the impacts, without lanes and records. */
saltus_status own_period(const saltus_system *system, const program *p, const double *state, double *end,
                         int *impacts);
/* Run every system from its default state with Saltus' flow and fill `motions` (length `count`). */
sweep_cost own_sweep(saltus_system *const *systems, int count, const program *p, motion *motions);
/* Run any program and fill the motions found. A sweep of Saltus takes the whole axis and has phases as times
 * of impacts. */
sweep_cost program_run(sweep *s, const program *p);

/* A line of a table. */
typedef struct row {
    const program *program;
    sweep_cost cost;
    double median, high, worst;          /* quantiles of the event error in T; NAN if there is none */
    int right, elsewhere, wrong, judged; /* number of omegas by their count of impacts; judged = -1: not
                                            judged */
    int labels; /* periodic omegas for which the program itself reports the right n/p */
} row;

/* sweep_measure.c */
/* Build the systems of every part-th omega. */
void sweep_build(sweep *s, int part);
void sweep_tear_down(sweep *s);
/* Compute the reference motions, and which of them are periodic. */
void sweep_make_reference(sweep *s);
/* Run all programs `repeats` times in turn, so that other load on the machine affects all alike; keep the
 * shortest times and judge the last motions. Other libraries' programs should run once. */
void sweep_measure(sweep *s, const program *list, int count, int repeats, row *rows);

#endif
