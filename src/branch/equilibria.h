/* Private: branches of equilibria of scenes without forcing, free and held against stops: folds, branch
 * points, Hopf points, and where an equilibrium meets a stop or leaves it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_EQUILIBRIA_H
#define SALTUS_BRANCH_EQUILIBRIA_H

#include "branch/rest_locus.h"

typedef struct saltus_equilibria saltus_equilibria;

/* Branches through the equilibrium near a state (length dimension; NULL: none, for reading back what
 * saltus_equilibria_archive has written), whose points go to the trail. With a locus the first point of its
 * kind is sought. Where branches of cycles leave they are added to `cycles`, numbered from `begun` on, which
 * counts the branches of equilibria as they begin. Both are the caller's. Errors: SALTUS_BAD_INPUT,
 * SALTUS_SINGULAR, SALTUS_NO_CONVERGENCE, SALTUS_NO_MEMORY. */
saltus_status saltus_equilibria_new(const saltus_spec *spec, const double *state, saltus_trail *trail,
                                    saltus_starts *cycles, saltus_equilibria **equilibria,
                                    saltus_message *message);
/* NULL is accepted. */
void saltus_equilibria_free(saltus_equilibria *equilibria);
/* One step, which may give out points; *more is false when all is done. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_equilibria_step(saltus_equilibria *equilibria, bool *more, saltus_message *message);
/* Where the locus that is asked for begins, until the next step; NULL: it was not found yet. */
const saltus_rest_start *saltus_equilibria_found(const saltus_equilibria *equilibria);
/* All that later steps depend on, but for the trail, written, or read into what saltus_equilibria_new has
 * made. Errors: SALTUS_NO_MEMORY, those of the evaluation. */
saltus_status saltus_equilibria_archive(saltus_equilibria *equilibria, saltus_archive *archive,
                                        saltus_message *message);

#endif
