/* Private: curves of folds, flips, Neimark-Sacker, branch and grazing points in the plane of two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_LOCUS_H
#define SALTUS_BRANCH_LOCUS_H

#include "branch/locus_starts.h"
#include "branch/trail.h"

typedef struct saltus_locus saltus_locus;

/* The start of a curve at a special point `at` of a branch in the first parameter. At grazing `beyond` is the
 * sequence on the other side, otherwise NULL. */
saltus_locus_start saltus_locus_start_at(saltus_point_kind kind, const saltus_solution *at,
                                         const saltus_sequence *beyond);
/* A locus through such a point; NULL: none, if it is to begin at one of `starts`, or if saltus_locus_archive
 * is to read it. Its points go to the trail, and all places at which other curves begin to `starts`; both are
 * the caller's. When it is done, those of Hopf points may wait there: rest_locus.h follows them. Free it in
 * any case. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_locus_new(const saltus_spec *spec, saltus_trail *trail, saltus_locus_starts *starts,
                               const saltus_locus_start *first, saltus_locus **locus,
                               saltus_message *message);
/* NULL is accepted. */
void saltus_locus_free(saltus_locus *locus);
/* One step, which may give out points; *more is false when all curves are done. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_locus_step(saltus_locus *locus, bool *more, saltus_message *message);
/* Everything, except trail and starts, on which later steps depend, written or read. Errors:
 * SALTUS_NO_MEMORY, those of saltus_locus_new. */
saltus_status saltus_locus_archive(saltus_locus *locus, saltus_archive *archive, saltus_message *message);

#endif
