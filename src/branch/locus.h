/* Private: curves of folds, flips, Neimark-Sacker, branch and grazing points in the plane of two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_LOCUS_H
#define SALTUS_BRANCH_LOCUS_H

#include "branch/archive.h"
#include "saltus/branch.h"

typedef struct saltus_locus saltus_locus;

/* Whether options of a locus can be followed from a specification. Errors: SALTUS_BAD_INPUT. */
saltus_status saltus_locus_check(const saltus_spec *spec, const saltus_branch_options *options,
                                 saltus_message *message);
/* A locus through a special point of a branch in the first parameter from `spec`. At grazing `beyond` is the
 * sequence on the other side, otherwise NULL. Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_locus_new(const saltus_spec *spec, const saltus_branch_options *options,
                               const saltus_solution *at, const saltus_sequence *beyond, saltus_locus **locus,
                               saltus_message *message);
/* NULL is accepted. */
void saltus_locus_free(saltus_locus *locus);
/* The next point; *more is false when all is done. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_locus_step(saltus_locus *locus, saltus_branch_point *point, bool *more,
                                saltus_message *message);
/* Whether all points made have been given out, and there is more to come that saltus_locus_archive tells of.
 */
bool saltus_locus_rests(const saltus_locus *locus);
/* All that later steps depend on. Reading, the locus is made; what is out of bounds is told by the archive.
 * Errors: SALTUS_NO_MEMORY, those of saltus_locus_new. */
saltus_status saltus_locus_archive(const saltus_spec *spec, const saltus_branch_options *options,
                                   saltus_locus **locus, saltus_archive *archive, saltus_message *message);

#endif
