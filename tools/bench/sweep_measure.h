/* One program's run of the sweep, its cost, and how far its motions are those of exact integration.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_SWEEP_MEASURE_H
#define SALTUS_BENCH_SWEEP_MEASURE_H

#include "rivals.h"
#include "sweep_own.h"

enum { omegas_max = 1000, rival_events_max = 1 << 20 };

/* The tolerance of the motions that all programs are compared with. */
static const double exact = 1e-13;

/* The omegas of this run, and the motions that all programs are compared with. */
typedef struct sweep {
    int count;
    saltus_system *stopped[omegas_max], *unstopped[omegas_max];
    motion reference[omegas_max], found[omegas_max];
    int period[omegas_max]; /* 0: not periodic, or not the same in both tight runs */
    int periodic;
    int part;            /* rivals take every part-th omega */
    rival_event *events; /* room for a rival's */
} sweep;

typedef enum program_kind {
    program_flow,   /* Saltus' flow, driven by this benchmark */
    program_engine, /* Saltus' sweeps */
    program_rival   /* another library's integrator; atol is as large as rtol */
} program_kind;

/* A program of the tables. */
typedef struct program {
    const char *name;
    program_kind kind;
    double tolerance;
    own_request own;       /* what the flow is asked for; of the sweeps the tolerance */
    bool stopped;          /* with the stop */
    engine_request engine; /* what the sweeps are asked for */
    rival_run run;
} program;

/* A line of a table. */
typedef struct row {
    const program *program;
    sweep_cost cost;
    double share;                        /* of the simulated time that was measured */
    double median, high, worst;          /* event error in T; NaN where there is none */
    int right, elsewhere, wrong, judged; /* omegas by their count of impacts; judged -1: none was made */
    int labels;                          /* periodic omegas that the program itself gives the right n/p */
} row;

/* The systems of every part-th omega. Errors are those of the scene and the system. */
saltus_status sweep_build(sweep *s, int part, saltus_message *message);
void sweep_tear_down(sweep *s);
/* The motions to compare with, and which of them are periodic. */
saltus_status sweep_make_reference(sweep *s, saltus_message *message);
/* Runs all programs `repeats` times in turn, so that a busy machine is busy for all, keeps their shortest
 * times, and judges the motions found last. Other libraries' programs are to be run once. False, with a
 * message on stderr, where one of Saltus' fails. */
bool sweep_measure(sweep *s, const program *list, int count, int repeats, row *rows);

#endif
