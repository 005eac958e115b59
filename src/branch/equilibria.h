/* Private: branches of equilibria of scenes without forcing, free or held against stops, with folds, branch
 * points, Hopf points, and the points where an equilibrium meets or leaves a stop.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_EQUILIBRIA_H
#define SALTUS_BRANCH_EQUILIBRIA_H

#include "branch/locus_starts.h"
#include "branch/rest.h"
#include "branch/trail.h"

typedef struct saltus_equilibria {
    saltus_trail *trail;   /* the caller's: receives the points */
    saltus_starts *cycles; /* the caller's: receives branches of cycles that leave */
    saltus_starts starts;  /* of branches of equilibria; of their sequences only the contacts count */
    saltus_rests rests;
    double range[2]; /* of the parameter unknown */
    saltus_rest *here, *next, *trial, *spare;
    saltus_rest solutions[4];
    saltus_locus_start found; /* where the requested locus begins; REGULAR: not found */
} saltus_equilibria;

/* Branches through the equilibrium near a state (length dimension; NULL: none, if saltus_equilibria_archive
 * is to read them). `trail` and `cycles`, whose `begun` counts the branches of equilibria as they begin, must
 * be set. Close in any case. Errors: SALTUS_BAD_INPUT, SALTUS_SINGULAR, SALTUS_NO_CONVERGENCE,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_equilibria_open(saltus_equilibria *equilibria, const saltus_spec *spec,
                                     const double *state, saltus_message *message);
void saltus_equilibria_close(saltus_equilibria *equilibria);
/* Begin a branch at a start: give out its first point. From here on lack of memory is noted in the equations.
 * Errors: those of the equations. */
saltus_status saltus_equilibria_start(saltus_equilibria *equilibria, const saltus_branch_start *start,
                                      saltus_message *message);
/* One step along the branch under way. If a locus is requested the branch ends where that begins. */
void saltus_equilibria_advance(saltus_equilibria *equilibria);
/* Everything, except the trail, on which later steps depend: written, or read into what was opened. Errors:
 * SALTUS_NO_MEMORY, those of the evaluation. */
saltus_status saltus_equilibria_archive(saltus_equilibria *equilibria, saltus_archive *archive,
                                        saltus_message *message);

/* Give out an equilibrium as a point of a branch or, if the equations are those of special ones, of a locus.
 * A BE, and each point of their locus, tells the face that is touched. False, and it is not followed on,
 * without memory, which is noted. */
bool saltus_rest_give(saltus_rests *rests, const saltus_rest *rest, saltus_notice what, saltus_trail *trail);

#endif
