/* Private: curves of folds, flips, Neimark-Sacker, branch and grazing points in the plane of two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_LOCUS_H
#define SALTUS_BRANCH_LOCUS_H

#include "branch/locus_starts.h"
#include "branch/trail.h"

typedef struct saltus_locus saltus_locus;

/* A locus through a special point of a branch in the first parameter. Its points go to the trail, and all
 * places at which other curves begin to `starts`; both are the caller's. When it is done, those of Hopf
 * points may wait there: rest_locus.h follows them. At grazing `beyond` is the sequence on the other side,
 * otherwise NULL. Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_locus_new(const saltus_spec *spec, saltus_trail *trail, saltus_locus_starts *starts,
                               const saltus_solution *at, const saltus_sequence *beyond, saltus_locus **locus,
                               saltus_message *message);
/* The curves of cycles of a scene without forcing that begin at such starts. Errors: SALTUS_NO_MEMORY,
 * SALTUS_BAD_INPUT. */
saltus_status saltus_locus_go_on(const saltus_spec *spec, saltus_trail *trail, saltus_locus_starts *starts,
                                 saltus_locus **locus, saltus_message *message);
/* NULL is accepted. */
void saltus_locus_free(saltus_locus *locus);
/* One step, which may give out points; *more is false when all curves are done. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_locus_step(saltus_locus *locus, bool *more, saltus_message *message);
/* Everything, except trail and starts, on which later steps depend. Reading creates the locus; numbers out of
 * bounds are reported by the archive. Errors: SALTUS_NO_MEMORY, those of saltus_locus_new. */
saltus_status saltus_locus_archive(const saltus_spec *spec, saltus_trail *trail, saltus_locus_starts *starts,
                                   saltus_locus **locus, saltus_archive *archive, saltus_message *message);

#endif
