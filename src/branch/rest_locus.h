/* Private: curves of Hopf points, boundary equilibria and folds of equilibria in the plane of two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_REST_LOCUS_H
#define SALTUS_BRANCH_REST_LOCUS_H

#include "branch/locus_starts.h"
#include "branch/rest.h"
#include "branch/trail.h"

typedef struct saltus_rest_locus saltus_rest_locus;

/* A special equilibrium of a branch in the first parameter. */
typedef struct saltus_rest_start {
    unsigned contacts;
    const double *state;
    double parameter; /* the parameter unknown */
    int face;         /* BE: the face that is touched; -1: none */
    double square;    /* HB: square of the pair's frequency */
} saltus_rest_start;

/* A locus through such an equilibrium; NULL: none, if saltus_rest_locus_archive is to read it. Points go to
 * the trail, the caller's. Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_rest_locus_new(const saltus_spec *spec, saltus_trail *trail,
                                    const saltus_rest_start *place, saltus_rest_locus **locus,
                                    saltus_message *message);
/* The curves of Hopf points that wait at such starts, which become its own. Errors: SALTUS_NO_MEMORY,
 * SALTUS_BAD_INPUT. */
saltus_status saltus_rest_locus_go_on(const saltus_spec *spec, saltus_trail *trail,
                                      saltus_locus_starts *starts, saltus_rest_locus **locus,
                                      saltus_message *message);
/* NULL is accepted. */
void saltus_rest_locus_free(saltus_rest_locus *locus);
/* One step, which may give out points; *more is false when all is done. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_rest_locus_step(saltus_rest_locus *locus, bool *more, saltus_message *message);
/* Curves of cycles that begin where the curves followed have come to, generalised Hopf points, from which
 * cycles that fold grow, beside the starts that it was given; its own. */
saltus_locus_starts *saltus_rest_locus_starts(saltus_rest_locus *locus);
/* All that later steps depend on, but for the trail, written, or read into what saltus_rest_locus_new has
 * made. Errors: SALTUS_NO_MEMORY, those of the evaluation. */
saltus_status saltus_rest_locus_archive(saltus_rest_locus *locus, saltus_archive *archive,
                                        saltus_message *message);

#endif
