/* Tables of the benchmark's measurements.
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

/* Machine, compiler, date and versions, each line preceded by `mark`. */
void report_machine(FILE *file, const char *mark);
/* One line per measurement. */
void report_csv(FILE *file, const results *r);
/* Times at equal error of all methods, relative to Saltus' best. */
void report_summary(FILE *file, const results *r);
/* The same in microseconds, also for the multipliers, and the cases where Saltus is not the fastest. */
void report_details(FILE *file, const results *r);
/* Errors relative to the tolerance, and to the effect of a perturbation of that size. */
void report_asked(FILE *file, const results *r);
/* Sentences on the worst factors between error and tolerance, and on the smallest error. */
void report_worst(FILE *file, const results *r);
/* modes.c: print the methods' times on pipes with few to many modes at equal error. False after a message. */
bool modes_print(const results *r);

#endif
