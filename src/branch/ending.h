/* Private: where a branch of cycles ends: at an equilibrium to which they shrink, at a homoclinic orbit, in a
 * family of orbits; and where all their impacts fade at once. Lack of memory is noted in the orbits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_ENDING_H
#define SALTUS_BRANCH_ENDING_H

#include "branch/special.h"
#include "saltus/equilibrium.h"

/* Whether the branch ends at this cycle because the parameter stands still while the period changes; `reason`
 * (SALTUS_REASON_MAX) says why. It does at a homoclinic orbit, where cycles come the closer to a saddle the
 * longer they are, at the rate that its exponents tell; where that orbit is follows from the law of the
 * parameter. At a canard explosion the parameter stands still too, but the period stays finite: there the
 * branch ends only if it is `lost`. `key`: the parameter's name. The shooting has the cycle's sequence;
 * `scratch` is overwritten. */
bool saltus_cycle_tell_saddle(saltus_orbits *orbits, const saltus_solution *cycle, bool lost, const char *key,
                              saltus_solution *scratch, char *reason);
/* Whether the cycles end where two equilibria are born on them (a saddle-node on an invariant circle). The
 * period then goes as one over the square root of the parameter's distance from that place; from its growth
 * between `here` and `next` follows the distance left, which must be small, and lead to an end within
 * `range`. `key`: the parameter's name. */
bool saltus_cycle_tell_birth(saltus_orbits *orbits, const saltus_solution *here, const saltus_solution *next,
                             const double range[2], const char *key, char *reason);
/* The reason of an end where cycles shrink to an equilibrium, with their period and their distance from it.
 */
void saltus_cycle_tell_shrinking(saltus_orbits *orbits, const saltus_solution *cycle, char *reason);

/* The Hopf point of the equilibrium inside a small cycle, from the equilibrium's own equation: the parameter
 * at which two eigenvalues are +-i omega. */
typedef struct saltus_shrunk {
    bool found;
    double parameter, omega, accuracy; /* accuracy: of `parameter`, an unknown */
    double state[SALTUS_STATE_MAX];
    saltus_eigenvalue rates[SALTUS_STATE_MAX]; /* by decreasing real part */
    int rate_count;
} saltus_shrunk;

/* The end of cycles at a Hopf point ahead. */
typedef struct saltus_hopf_ahead {
    bool found, is_one; /* a place looks like it; so does the orbit there */
    saltus_special special;
    saltus_shrunk shrunk; /* the Hopf point at that place */
} saltus_hopf_ahead;

/* If the cycles of a step seem to shrink to an equilibrium: the orbit there as `at`, and the Hopf point that
 * ends them. True if it `misses`: the step is too long to see this, or has left the cycles. */
bool saltus_cycle_seek_hopf(saltus_orbits *orbits, const saltus_solution *here, const saltus_solution *next,
                            saltus_solution *at, saltus_solution *scratch, saltus_hopf_ahead *hopf);
/* Whether the special point `at` of a step from `here` is what it seems. A fold right before the Hopf point
 * at which cycles end may be none: there the parameter stands still, and rounding turns it back. */
bool saltus_cycle_folds(saltus_orbits *orbits, const saltus_solution *here, const saltus_special *fold,
                        const saltus_solution *at);
/* `out`, which has the shooting's sequence, becomes that Hopf point as an orbit, surveyed; it keeps its
 * tangent. Its multipliers are the limits of those of the shrinking cycles. False if the flow fails. */
bool saltus_cycle_shrink(saltus_orbits *orbits, const saltus_shrunk *hopf, saltus_solution *out);

/* Whether the orbits at one value of the parameter may form a family: one multiplier is 1 besides the trivial
 * one along the flow. */
bool saltus_cycle_of_family(const saltus_solution *orbit);
/* Whether all impacts of a cycle of a planar flow lose their speed at once on the step to `next`. The cycle
 * forgets when its impacts happen, so that at zero speed its equations are singular in two directions and
 * lead anywhere. So the place is located on the cycle without impacts, which touches its stops there: `at`.
 * `bare` becomes such a cycle a little further on, with a tangent that leads back. */
saltus_zero saltus_cycle_fades(saltus_orbits *orbits, const saltus_solution *here,
                               const saltus_solution *next, const double range[2], saltus_solution *at,
                               saltus_solution *bare, saltus_solution *scratch);

#endif
