/* Private: curves of Hopf points, boundary equilibria and folds of equilibria in the plane of two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_REST_LOCUS_H
#define SALTUS_BRANCH_REST_LOCUS_H

#include "branch/archive.h"
#include "branch/rest.h"

typedef struct saltus_rest_locus saltus_rest_locus;

/* Through a special equilibrium of a branch in the first parameter from `spec`: state and parameter unknown;
 * `face` that is touched (BE), `square` of the pair's frequency (HB). `state` NULL: none, for reading back
 * what saltus_rest_locus_archive has written. Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_rest_locus_new(const saltus_spec *spec, const saltus_branch_options *options,
                                    unsigned contacts, const double *state, double parameter, int face,
                                    double square, saltus_rest_locus **locus, saltus_message *message);
/* NULL is accepted. */
void saltus_rest_locus_free(saltus_rest_locus *locus);
/* The next point; *more is false when all is done. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_rest_locus_step(saltus_rest_locus *locus, saltus_branch_point *point, bool *more,
                                     saltus_message *message);
/* Whether all points made have been given out. */
bool saltus_rest_locus_rests(const saltus_rest_locus *locus);
/* All that later steps depend on, written, or read into what saltus_rest_locus_new has made. Errors:
 * SALTUS_NO_MEMORY, those of the evaluation. */
saltus_status saltus_rest_locus_archive(saltus_rest_locus *locus, saltus_archive *archive,
                                        saltus_message *message);

#endif
