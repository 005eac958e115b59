/* Running a sweep: its tasks over threads and ranks, its results into a file, progress, interrupts.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_RUN_SWEEP_H
#define SALTUS_TOOLS_RUN_SWEEP_H

#include "saltus/saltus.h"

/* What is to be run, and where it goes. */
typedef struct sweep_order {
    const saltus_sweep *sweep;   /* NULL where this rank could not make one */
    volatile sig_atomic_t *stop; /* the sweep's flow.stop: it is the run's to raise */
    const char *path;
    const saltus_origin *origin;
    bool basins, resume, quiet;
    bool to_stdout; /* the file is copied to standard output and does not last */
} sweep_order;

/* How many trajectories have which name. */
typedef struct sweep_class {
    char label[32];
    long long count;
} sweep_class;

typedef struct sweep_tally {
    sweep_class *classes;
    int count, room;
} sweep_tally;

/* Errors: SALTUS_NO_MEMORY. */
saltus_status sweep_tally_add(sweep_tally *tally, const saltus_sweep_row *row, saltus_message *message);
/* Most frequent first. */
void sweep_tally_sort(sweep_tally *tally);
void sweep_tally_clear(sweep_tally *tally);

/* What a run has done. Rows are trajectories. */
typedef struct sweep_report {
    long long rows;     /* of the whole sweep */
    long long computed; /* by this run; the others were there */
    double seconds;
    bool first;        /* this is the first rank, which has the file and speaks */
    int ranks;         /* that shared the work */
    sweep_tally tally; /* of those computed by this run; on the first rank */
} sweep_report;

/* Run to the end or until a signal asks to stop. `status` and `reason` tell how the making of the sweep went,
 * here: if it failed on one rank, it has on all. Returns an exit code, after a message where that is not
 * CLI_DONE. The report is to be cleared by sweep_tally_clear in any case. */
int run_sweep(const sweep_order *order, saltus_status status, const saltus_message *reason,
              sweep_report *report);

#endif
