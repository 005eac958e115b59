/* One program's run of the sweep, its cost, and how far its motions deviate from exact integration.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_SWEEP_MEASURE_H
#define SALTUS_BENCH_SWEEP_MEASURE_H

#include "rivals.h"
#include "sweep_own.h"

enum { omegas_max = 1000, rival_events_max = 1 << 20 };

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

typedef enum program_kind {
    program_flow,   /* Saltus' flow, driven by this benchmark */
    program_engine, /* Saltus' sweeps, with classification */
    program_rival   /* another library's integrator, with atol equal to rtol */
} program_kind;

/* A program of the tables. */
typedef struct program {
    const char *name;
    program_kind kind;
    double tolerance;
    own_request own;       /* options of the flow; for sweeps only the tolerance is used */
    bool stopped;          /* whether the scene has the stop */
    engine_request engine; /* options of the sweeps */
    rival_run run;
} program;

/* A line of a table. */
typedef struct row {
    const program *program;
    sweep_cost cost;
    double share;                        /* fraction of the simulated time that was measured */
    double median, high, worst;          /* quantiles of the event error in T; NAN if there is none */
    int right, elsewhere, wrong, judged; /* number of omegas by their count of impacts; judged = -1: not
                                            judged */
    int labels; /* periodic omegas for which the program itself reports the right n/p */
} row;

/* Build the systems of every part-th omega. Errors: those of the scene and the system. */
saltus_status sweep_build(sweep *s, int part, saltus_message *message);
void sweep_tear_down(sweep *s);
/* Compute the reference motions, and which of them are periodic. */
saltus_status sweep_make_reference(sweep *s, saltus_message *message);
/* Run all programs `repeats` times in turn, so that other load on the machine affects all alike; keep the
 * shortest times and judge the last motions. Other libraries' programs should run once. False, with a message
 * on stderr, if a program of Saltus fails. */
bool sweep_measure(sweep *s, const program *list, int count, int repeats, row *rows);

#endif
