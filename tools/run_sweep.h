/* Running a sweep: distributes its tasks over threads and ranks, writes its results into a file, handles
 * progress and interrupts.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_RUN_SWEEP_H
#define SALTUS_TOOLS_RUN_SWEEP_H

#include "cli.h"

/* A sweep to run, and its destination. */
typedef struct sweep_order {
    const saltus_sweep *sweep;   /* NULL if this rank failed to make it */
    volatile sig_atomic_t *stop; /* the sweep's flow.stop, which the run may set */
    const char *path;
    const saltus_origin *origin;
    bool basins, resume, quiet;
    bool to_stdout; /* the file is temporary and will be copied to standard output */
} sweep_order;

/* Number of trajectories with a label. */
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

/* Outcome of a run. Rows are trajectories. */
typedef struct sweep_report {
    long long rows;     /* rows of the whole sweep */
    long long computed; /* rows computed by this run; the others existed before */
    double seconds;
    bool first;        /* this is the first rank, which writes the file and prints */
    int ranks;         /* ranks that shared the work */
    sweep_tally tally; /* of the rows computed by this run; first rank only */
} sweep_report;

/* Run until done or until a signal asks to stop. `status` and `reason` are those of making the sweep on this
 * rank; a failure on any rank is a failure on all. Returns an exit code, after a message unless it is
 * CLI_DONE. Clear the report's tally with sweep_tally_clear in any case. */
int run_sweep(const sweep_order *order, saltus_status status, const saltus_message *reason,
              sweep_report *report);

/* sweep_print.c: common to saltus sweep and saltus basins. */
extern const cli_option sweep_over, sweep_json;

/* Load the scene, run a sweep over the axes of --over and print a summary on the first rank: a table, or one
 * JSON object with the keys version, scene, file, kind, complete, points, passes, seeds, rows, computed,
 * seconds, trajectories_per_second, ranks, classes (label, count, share), and of basins attractors (label,
 * largest_multiplier, count, share). After a resumed run the numbers are those of the whole file. All ranks
 * must call this. Returns the exit code. */
int sweep_command(const cli_request *request, bool basins, const saltus_sweep_options *options);

#endif
