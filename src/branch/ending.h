/* Private: where a branch of cycles ends: at an equilibrium that they shrink to, at an orbit that leaves a
 * saddle and comes back to it, in a family; and where their impacts fade all at once.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_ENDING_H
#define SALTUS_BRANCH_ENDING_H

#include "branch/special.h"
#include "saltus/equilibrium.h"

/* Whether cycles end where the parameter stands still while the period changes: *ends, and `reason`
 * (SALTUS_REASON_MAX) tells why. They do at a homoclinic orbit, near to a saddle. At the explosion of a
 * canard, too, the parameter stands still, but the period stays finite: there they end only where the branch
 * is `lost`. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_cycle_tell_saddle(saltus_orbits *orbits, const saltus_solution *cycle, bool lost,
                                       bool *ends, char *reason, saltus_message *message);
/* Whether cycles end where two equilibria are born on them, a saddle-node on an invariant circle: their
 * period then goes as one over the square root of the distance from there, so on the step from `here` to
 * `next`, and *ends where little of that distance is left; within `range`. `key`: the parameter. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status saltus_cycle_tell_birth(saltus_orbits *orbits, const saltus_solution *here,
                                      const saltus_solution *next, const double range[2], const char *key,
                                      bool *ends, char *reason, saltus_message *message);
/* That cycles shrink to an equilibrium: what is left of their distance, and their period. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status saltus_cycle_tell_shrinking(saltus_orbits *orbits, const saltus_solution *cycle, char *reason,
                                          saltus_message *message);

/* The Hopf point of the equilibrium that a small cycle lies around, by its own equation: the parameter at
 * which two eigenvalues +-i omega are imaginary. */
typedef struct saltus_shrunk {
    bool found;
    double parameter, omega, accuracy; /* the last of the parameter unknown */
    double state[SALTUS_STATE_MAX];
    saltus_eigenvalue rates[SALTUS_STATE_MAX]; /* by decreasing real part */
    int rate_count;
} saltus_shrunk;

/* The end of cycles at a Hopf point ahead. */
typedef struct saltus_hopf_ahead {
    bool found, is_one; /* there is a place that looks like it; its orbit does, too */
    saltus_special special;
    saltus_shrunk shrunk; /* in the very same place */
} saltus_hopf_ahead;

/* Where the cycles of a step seem to shrink to nothing, that orbit as `at`, and the Hopf point in which they
 * end. *misses: the step is too long to see that, or has led off the cycles. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_cycle_seek_hopf(saltus_orbits *orbits, const saltus_solution *here,
                                     const saltus_solution *next, saltus_solution *at,
                                     saltus_solution *scratch, saltus_hopf_ahead *hopf, bool *misses,
                                     saltus_message *message);
/* Whether the special point `at` of a step from `here`, if it is a fold, can be told from a Hopf point in
 * which the cycles end soon after: there the parameter stands still, and rounding turns it. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status saltus_cycle_folds(saltus_orbits *orbits, const saltus_solution *here,
                                 const saltus_special *fold, const saltus_solution *at, bool *folds,
                                 saltus_message *message);
/* `out`, of the shooting's sequence, becomes that Hopf point as an orbit, surveyed, with the tangent that it
 * has; its multipliers are those of cycles as they shrink to it. Errors: SALTUS_NO_MEMORY, those of the flow.
 */
saltus_status saltus_cycle_shrink(saltus_orbits *orbits, const saltus_shrunk *hopf, saltus_solution *out,
                                  saltus_message *message);

/* Whether orbits of one value of the parameter may form a family, as far as their multipliers tell: one of
 * them is 1, beside that along the flow. */
bool saltus_cycle_of_family(const saltus_solution *orbit);
/* Whether all impacts of a cycle of a planar flow lose their speed at once on the step ahead. Such a cycle
 * forgets when they are, so that where they have no speed its equations are singular twice, and lead
 * anywhere. */
bool saltus_cycle_fades(const saltus_orbits *orbits, const saltus_solution *here,
                        const saltus_solution *next);
/* Where that is, the cycle without impacts tells: it touches its stops there, as `at`. `bare` becomes such a
 * cycle a little further on, whose tangent leads back. */
saltus_zero saltus_cycle_touches(saltus_orbits *orbits, const saltus_solution *here, const double range[2],
                                 saltus_solution *at, saltus_solution *bare, saltus_solution *scratch);

#endif
