/* Private: where a branch of cycles ends: at an equilibrium that they shrink to, or at an orbit that leaves a
 * saddle and comes back to it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_ENDING_H
#define SALTUS_BRANCH_ENDING_H

#include "branch/solution.h"

/* The equilibrium that a cycle passes most slowly. */
typedef struct saltus_passed {
    bool found;
    double distance;      /* of the cycle, in the system's scales */
    int unstable, stable; /* eigenvalues with a positive and with a negative real part */
    unsigned contacts;    /* faces that it is held against */
} saltus_passed;

/* Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_cycle_passes(saltus_orbits *orbits, const saltus_solution *cycle, saltus_passed *passed,
                                  saltus_message *message);

/* The Hopf point of the equilibrium that a small cycle lies around, by its own equation: the parameter at
 * which two eigenvalues +-i omega are imaginary. */
typedef struct saltus_shrunk {
    bool found;
    double parameter, omega, accuracy; /* the last of the parameter unknown */
    double state[SALTUS_STATE_MAX];
    saltus_multiplier rates[SALTUS_STATE_MAX]; /* eigenvalues by decreasing real part */
    int rate_count;
} saltus_shrunk;

/* Sought from the equilibrium nearest to the cycle's state and the eigenvalues nearest to its frequency.
 * Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_cycle_shrinks(saltus_orbits *orbits, const saltus_solution *cycle, saltus_shrunk *hopf,
                                   saltus_message *message);
/* `out`, of the shooting's sequence, becomes that Hopf point as an orbit, surveyed, with the tangent that it
 * has; its multipliers are those of cycles as they shrink to it. Errors: SALTUS_NO_MEMORY, those of the flow.
 */
saltus_status saltus_cycle_shrink(saltus_orbits *orbits, const saltus_shrunk *hopf, saltus_solution *out,
                                  saltus_message *message);

#endif
