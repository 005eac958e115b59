/* The benchmark's problems: reference orbits as scenes of Saltus and of its rivals, and the errors of a run.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_PROBLEM_H
#define SALTUS_BENCH_PROBLEM_H

#include "reference.h"
#include "rivals.h"

enum { happened_max = 4096 };

typedef struct problem {
    const char *name, *what;
    reference orbit;
    saltus_system *system;
    rival_scene scene;
    rival_oscillator oscillator;
    int impacts;          /* that the reference lists */
    bool stiff;           /* where the library chooses its stiff integrator */
    double leading[2][2]; /* the two largest multipliers, [re, im] */
} problem;

/* Read folder/name.json; false where it is absent or no reference orbit. */
bool problem_open(const char *folder, const char *name, const char *what, problem *p);
void problem_close(problem *p);

/* The contact events of a run in order: 'i' impact, 's' stick, 'r' release; times in T. */
typedef struct happened {
    int count;
    char kind[happened_max];
    double time[happened_max];
} happened;

/* Largest error of the times of impacts and releases in T, as far as the reference lists them. A missing
 * event, or one too many, is an error of a period, save that a method may end a chatter after fewer impacts
 * than are listed, and that events after the listed ones of a chatter do not count. Sticks do not count
 * either: where the impacts accumulate is not found but extrapolated. NaN where there are no events. */
double problem_event_error(const problem *p, const happened *events);
/* Largest distance of the two leading multipliers from the nearest of those of a monodromy matrix, whose
 * columns lie one after the other; NaN where the eigenvalues cannot be found. */
double problem_multiplier_error(const problem *p, const double *columns);

#endif
