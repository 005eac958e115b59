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

#endif
