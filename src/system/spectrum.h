/* Private: eigenvalues of a system's linear part, and the longest step that they allow.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_SPECTRUM_H
#define SALTUS_SYSTEM_SPECTRUM_H

#include "system/system.h"

/* Longest state whose eigenvalues are computed; for longer ones those of the uncoupled modes stand in. */
enum { SALTUS_SPECTRUM_MAX = 64 };

/* Reserve the linear part (called once to measure, once to hand out). */
void saltus_spectrum_reserve(saltus_system *system);

/* The eigenvalues of a system's linear part. They are not part of a built system, because they take longer
 * than all the rest of it and only a new flow needs them. */
typedef struct saltus_eigenvalues {
    int count;
    double real[2 * SALTUS_MODES_MAX], imaginary[2 * SALTUS_MODES_MAX];
} saltus_eigenvalues;
void saltus_system_eigenvalues(const saltus_system *system, saltus_eigenvalues *eigenvalues);

/* The longest step of a Taylor integrator of the given order for which its polynomial amplifies no solution
 * of the linear part that does not grow by itself. NULL: ignore stability. */
double saltus_system_step_limit(const saltus_system *system, const saltus_eigenvalues *eigenvalues,
                                int order);

/* Factors of the last two orders of a series that make longer steps stable. */
typedef struct saltus_damping {
    double before, last; /* of the last order but one and of the last one */
    double plain;        /* the longest step without them, */
    double limit;        /* and with them: never shorter */
} saltus_damping;
/* The factors for an order and these eigenvalues. NULL: none, and steps without regard to stability. */
saltus_damping saltus_system_damping(const saltus_system *system, const saltus_eigenvalues *eigenvalues,
                                     int order);

/* Whether stability, not accuracy, bounds the steps of an order that resolves oscillations within `angle`
 * radians: the fastest motion that lasts turns by at most `angle` within the longest stable step. */
bool saltus_system_outruns(const saltus_system *system, const saltus_eigenvalues *eigenvalues, int order,
                           double angle);

#endif
