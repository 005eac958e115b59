/* The benchmark's problems: reference orbits as scenes for Saltus and its rivals, and the errors of a run.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_PROBLEM_H
#define SALTUS_BENCH_PROBLEM_H

#include "reference.h"
#include "rivals.h"

enum { happened_max = 4096 };

typedef struct problem {
    const char *name, *what;
    reference orbit;
    const double *start; /* from which a run once around ends in the orbit's first section state */
    saltus_system *system;
    int impacts;          /* number of impacts in the reference */
    bool stiff;           /* the library chooses its stiff integrator */
    double leading[2][2]; /* the two largest multipliers, [re, im] */
} problem;

/* Read folder/name.json; false if it is missing or no reference orbit. */
bool problem_open(const char *folder, const char *name, const char *what, problem *p);
/* A pipe of so many modes at omega = 42, nearly settled: its problem is the next forcing period, without
 * events or multipliers. False after a message. */
bool problem_pipe(int modes, bool stop, problem *p);
void problem_close(problem *p);

/* The contact events of a run in order. */
typedef struct happened {
    int count;
    rival_event events[happened_max];
} happened;

/* Largest error of the times of impacts and releases in T, among those the reference lists. A missing or
 * additional event counts as an error of one period, except that a method may end a chatter after fewer
 * impacts than listed, and that events after the listed ones of a chatter are ignored. Sticks are ignored
 * too: the accumulation point of the impacts is extrapolated, not located. NAN if there are no events. */
double problem_event_error(const problem *p, const happened *events);
/* Largest distance of the two leading multipliers from the nearest eigenvalues of a monodromy matrix, given
 * by columns; NAN if the eigenvalues cannot be computed. */
double problem_multiplier_error(const problem *p, const double *columns);

#endif
