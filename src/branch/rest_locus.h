/* Private: curves of Hopf points, boundary equilibria and folds of equilibria in the plane of two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_REST_LOCUS_H
#define SALTUS_BRANCH_REST_LOCUS_H

#include "branch/locus_starts.h"
#include "branch/rest.h"
#include "branch/trail.h"

typedef struct saltus_rest_locus {
    saltus_trail *trail;         /* the caller's: receives the points */
    saltus_locus_starts *starts; /* the caller's: receives places at which other curves begin, at generalised
                                    Hopf points of cycles that fold */
    bool switched;               /* the curve under way begins at such a place */
    saltus_rests rests;          /* what makes the equilibria special is renewed from point to point */
    saltus_rest here, next, trial;
    double beginning[2 * SALTUS_REST_UNKNOWNS_MAX]; /* unknowns and tangent of the first point */
    double first_square;
    double border[2][2]; /* of both parameter unknowns: low, high */
    int first_way, way_count,
        way; /* of the tangent's two ways: the first, how many, and how many are begun */
} saltus_rest_locus;

/* A locus through a special equilibrium of a branch in the first parameter; NULL: none, if it is to begin at
 * one of the starts, or if saltus_rest_locus_archive is to read it. `trail` and `starts` must be set. Close
 * in any case. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_rest_locus_open(saltus_rest_locus *locus, const saltus_spec *spec,
                                     const saltus_locus_start *first, saltus_message *message);
/* It can be opened again, with the same trail and starts. */
void saltus_rest_locus_close(saltus_rest_locus *locus);
/* One step, which may give out points; *more is false when all is done. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_rest_locus_step(saltus_rest_locus *locus, bool *more, saltus_message *message);
/* All that later steps depend on, but for trail and starts, written, or read into what was opened. Errors:
 * SALTUS_NO_MEMORY, those of the evaluation. */
saltus_status saltus_rest_locus_archive(saltus_rest_locus *locus, saltus_archive *archive,
                                        saltus_message *message);

#endif
