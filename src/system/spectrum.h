/* Private: eigenvalues of a system's linear part, and how long a step they allow.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_SPECTRUM_H
#define SALTUS_SYSTEM_SPECTRUM_H

#include "system/system.h"

/* States of up to so many numbers have their eigenvalues computed; of larger ones the modes' own stand for
 * them, made as large as `rate` says that they may be. */
enum { SALTUS_SPECTRUM_MAX = 64 };

/* Reserve the linear part (called for measuring and again for handing out). */
void saltus_spectrum_reserve(saltus_system *system);

/* The eigenvalues of a system's linear part. A built system lacks them: they take longer than all the rest of
 * it and are only wanted where a flow begins to use it. */
typedef struct saltus_eigenvalues {
    int count;
    double real[2 * SALTUS_MODES_MAX], imaginary[2 * SALTUS_MODES_MAX];
} saltus_eigenvalues;
void saltus_system_eigenvalues(const saltus_system *system, saltus_eigenvalues *eigenvalues);

/* The longest step of a Taylor integrator of an order: its polynomial lets no solution of the linear part
 * grow that does not grow by itself. NULL: that does not matter. */
double saltus_system_step_limit(const saltus_system *system, const saltus_eigenvalues *eigenvalues,
                                int order);

/* Whether stability rather than accuracy bounds the steps of an order that resolves oscillations within so
 * many radians of them: the fastest motion that lasts turns by no more within the longest stable step. */
bool saltus_system_outruns(const saltus_system *system, const saltus_eigenvalues *eigenvalues, int order,
                           double angle);

#endif
