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

/* Room for the eigenvalues of any system. */
typedef struct saltus_eigenvalues {
    double real[2 * SALTUS_MODES_MAX], imaginary[2 * SALTUS_MODES_MAX];
} saltus_eigenvalues;
/* A system with its eigenvalues, which a built one lacks: they take longer than all the rest of it and are
 * only wanted where a flow begins to use it. The copy is good as long as the system and the room. */
saltus_system saltus_spectrum_of(const saltus_system *system, saltus_eigenvalues *room);

/* The functions below take a system with its eigenvalues. */

/* The longest step of a Taylor integrator of an order: its polynomial lets no solution of the linear part
 * grow that does not grow by itself. */
double saltus_system_step_limit(const saltus_system *system, int order);

/* Whether stability rather than accuracy bounds the steps of an order that resolves oscillations within so
 * many radians of them: the fastest motion that lasts turns by no more within the longest stable step. */
bool saltus_system_outruns(const saltus_system *system, int order, double angle);

#endif
