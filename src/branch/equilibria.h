/* Private: branches of equilibria of scenes without forcing, free and held against stops: folds, branch
 * points, Hopf points, and where an equilibrium meets a stop or leaves it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_EQUILIBRIA_H
#define SALTUS_BRANCH_EQUILIBRIA_H

#include "branch/archive.h"
#include "saltus/branch.h"

typedef struct saltus_equilibria saltus_equilibria;

/* Branches through the equilibrium near a state (length dimension; NULL: none, for reading back what
 * saltus_equilibria_archive has written). With a locus the first point of its kind is sought, then followed.
 * Where branches of cycles leave they are added to `cycles`, the caller's, numbered from `begun` on, which
 * counts the branches of equilibria as they begin. Errors: SALTUS_BAD_INPUT, SALTUS_SINGULAR,
 * SALTUS_NO_CONVERGENCE, SALTUS_NO_MEMORY. */
saltus_status saltus_equilibria_new(const saltus_spec *spec, const saltus_branch_options *options,
                                    const double *state, saltus_starts *cycles,
                                    saltus_equilibria **equilibria, saltus_message *message);
/* The same for the locus of Hopf points alone that a branch of cycles has come to: at a parameter unknown, an
 * equilibrium near a state, with a pair of eigenvalues near +-i omega. */
saltus_status saltus_equilibria_take_up(const saltus_spec *spec, const saltus_branch_options *options,
                                        unsigned contacts, const double *state, double parameter,
                                        double omega, saltus_starts *cycles, saltus_equilibria **equilibria,
                                        saltus_message *message);
/* NULL is accepted. */
void saltus_equilibria_free(saltus_equilibria *equilibria);
/* The next point; *more is false when all is done. Errors: SALTUS_NO_MEMORY; SALTUS_NO_CONVERGENCE where a
 * locus is asked for and no point of its kind is found. */
saltus_status saltus_equilibria_step(saltus_equilibria *equilibria, saltus_branch_point *point, bool *more,
                                     saltus_message *message);
/* Whether all points made have been given out. */
bool saltus_equilibria_rests(const saltus_equilibria *equilibria);
/* All that later steps depend on, written, or read into what saltus_equilibria_new has made. Errors:
 * SALTUS_NO_MEMORY, those of the evaluation. */
saltus_status saltus_equilibria_archive(saltus_equilibria *equilibria, saltus_archive *archive,
                                        saltus_message *message);

#endif
