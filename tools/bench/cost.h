/* What Saltus' features cost: modes, lanes, threads, events, dense output, tangent vectors, classification.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_COST_H
#define SALTUS_BENCH_COST_H

#include <stdbool.h>
#include <stdio.h>

enum { cost_rows_max = 96 };

/* Numbers that do not apply are NaN. */
typedef struct cost_row {
    const char *table;
    char what[96];
    double us;          /* CPU time of one forcing period of one trajectory; threads: wall time */
    double steps;       /* of the integrator in a period */
    double evaluations; /* of the field in a step; Taylor series: orders expanded */
    double impacts;     /* in a period */
    double ratio;       /* of the times, to the row that the table compares with */
} cost_row;

typedef struct cost_table {
    int count;
    cost_row rows[cost_rows_max];
} cost_table;

/* Measure everything; `quick` on short runs. */
bool cost_measure(cost_table *costs, bool quick);
void cost_csv(FILE *file, const cost_table *costs);
/* As tables. */
void cost_print(FILE *file, const cost_table *costs);

#endif
