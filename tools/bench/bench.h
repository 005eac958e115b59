/* The benchmark of problems: reference orbits as scenes for Saltus and its rivals, the errors and costs of
 * runs, and the tables made of them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_H
#define SALTUS_BENCH_H

#include "clock.h"
#include "must.h"
#include "reference.h"
#include "rivals.h"

/* measure.c: one method at one tolerance on one problem. */

typedef struct problem {
    const char *name, *what;
    reference orbit;
    const double *start;    /* from which a run once around ends in the orbit's first section state */
    const char *integrator; /* that the library chooses */
    int impacts;            /* number of impacts in the reference */
    bool stiff;             /* the library chooses its stiff integrator */
    double leading[2][2];   /* the two largest multipliers, [re, im] */
} problem;

/* Read folder/name.json; false if it is missing or no reference orbit. */
bool problem_open(const char *folder, const char *name, const char *what, problem *p);

/* Saltus' own methods in the form of rivals, `own_method_count` of them. */
enum { own_method_count = 3 };
extern const method own_methods[own_method_count];

/* How multipliers are computed. */
typedef enum derivative { derivative_none, derivative_tangents, derivative_differences } derivative;

typedef struct measure {
    double rtol;
    bool done;
    double event_error; /* in T; NAN: the orbit has no impact */
    double state_error; /* relative, as in reference_error */
    double seconds, evaluations;
    derivative how; /* members below are set only if this is not derivative_none */
    double multiplier_error, derivative_seconds, derivative_evaluations;
} measure;

/* Limits on the time spent on a measurement. */
typedef struct effort {
    int repeats;     /* most runs, whose median counts; at least 3, but only one if a run is long */
    double budget;   /* approximate processor time in seconds for all repeats */
    double patience; /* seconds: longer runs are not repeated, and are made without tangent vectors if these
                        would take five times as long */
} effort;

/* Errors caused by a perturbation of the start: no integrator of that tolerance can be expected to do
 * better. */
typedef struct condition {
    double events, state;
} condition;

double median(double *values, int count);
/* Run from the reference's state once around the orbit, and once more with derivatives as `how` says. */
measure measure_method(const problem *p, const method *m, double rtol, derivative how, const effort *e);
/* The largest errors after changing one component of the start by `amount` of the orbit's size. */
condition measure_condition(const problem *p, double amount);

/* report.c: tables of the measurements. */

enum { problems_max = 8, methods_max = 10, tolerances_max = 13 };

typedef struct results {
    problem problems[problems_max];
    const method *methods[methods_max];
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
/* A number, unless it is NAN, and what follows it. */
void report_number(FILE *file, const char *format, double value, const char *after);

/* modes.c: print the methods' times on pipes with few to many modes at equal error. */
void modes_print(const method *const *methods, int count);

/* cost.c: modes, events, dense output, tangent vectors, classification. */

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
    cost_row rows[64];
} cost_table;

/* Measure everything; `quick` uses short runs. */
void cost_measure(cost_table *costs, bool quick);
void cost_csv(FILE *file, const cost_table *costs);
/* Print the results as tables. */
void cost_print(FILE *file, const cost_table *costs);

#endif
