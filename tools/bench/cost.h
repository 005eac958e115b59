/* Cost of Saltus' features: modes, events, dense output, tangent vectors, classification.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_COST_H
#define SALTUS_BENCH_COST_H

#include <stdbool.h>
#include <stdio.h>

enum { cost_rows_max = 96 };

/* Numbers that do not apply are NAN. */
typedef struct cost_row {
    const char *table;
    char what[96];
    double us;          /* CPU time per forcing period */
    double steps;       /* integrator steps per period */
    double evaluations; /* field evaluations per step; for Taylor series orders expanded */
    double impacts;     /* per period */
    double ratio;       /* time relative to the reference row of the table */
} cost_row;

typedef struct cost_table {
    int count;
    cost_row rows[cost_rows_max];
} cost_table;

/* Measure everything; `quick` uses short runs. */
bool cost_measure(cost_table *costs, bool quick);
void cost_csv(FILE *file, const cost_table *costs);
/* Print the results as tables. */
void cost_print(FILE *file, const cost_table *costs);

#endif
