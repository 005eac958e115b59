/* Private: branches of equilibria of scenes without forcing, free or held against stops, with folds, branch
 * points, Hopf points, and the points where an equilibrium meets or leaves a stop.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_EQUILIBRIA_H
#define SALTUS_BRANCH_EQUILIBRIA_H

#include "branch/rest_locus.h"

typedef struct saltus_equilibria saltus_equilibria;

/* Branches through the equilibrium near a state (length dimension; NULL: none, if saltus_equilibria_archive
 * is to read them); points go to the trail. If a locus is requested, its first point is sought. Branches of
 * cycles that leave are added to `cycles`, whose `begun` counts the branches of equilibria as they begin.
 * Trail and `cycles` are the caller's. Errors: SALTUS_BAD_INPUT, SALTUS_SINGULAR, SALTUS_NO_CONVERGENCE,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_equilibria_new(const saltus_spec *spec, const double *state, saltus_trail *trail,
                                    saltus_starts *cycles, saltus_equilibria **equilibria,
                                    saltus_message *message);
/* NULL is accepted. */
void saltus_equilibria_free(saltus_equilibria *equilibria);
/* One step, which may give out points; *more is false when all is done. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_equilibria_step(saltus_equilibria *equilibria, bool *more, saltus_message *message);
/* Where the requested locus begins, valid until the next step; NULL: not found yet. */
const saltus_rest_start *saltus_equilibria_found(const saltus_equilibria *equilibria);
/* Everything, except the trail, on which later steps depend: written, or read into what saltus_equilibria_new
 * has made. Errors: SALTUS_NO_MEMORY, those of the evaluation. */
saltus_status saltus_equilibria_archive(saltus_equilibria *equilibria, saltus_archive *archive,
                                        saltus_message *message);

#endif
