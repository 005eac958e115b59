/* What the benchmark has measured, as tables.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_REPORT_H
#define SALTUS_BENCH_REPORT_H

#include "measure.h"

enum { problems_max = 8, methods_max = 10, tolerances_max = 13 };

typedef struct results {
    problem *problems[problems_max];
    method methods[methods_max];
    double tolerances[tolerances_max];
    int problem_count, method_count, tolerance_count;
    measure measures[problems_max][methods_max][tolerances_max];
    condition conditions[problems_max][tolerances_max];
} results;

/* Machine, compiler, date and versions, each line after `mark`. */
void report_machine(FILE *file, const char *mark);
/* One line a measurement. */
void report_csv(FILE *file, const results *r);
/* Time at equal error of all methods over that of the best of ours. */
void report_summary(FILE *file, const results *r);
/* The same in microseconds, for the multipliers too, and where ours is not the fastest. */
void report_details(FILE *file, const results *r);
/* Errors over the tolerance asked for, and over what a perturbation of that size does. */
void report_asked(FILE *file, const results *r);
/* Sentences: the worst factors between error and tolerance, and the smallest error. */
void report_worst(FILE *file, const results *r);

#endif
