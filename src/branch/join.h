/* Private: where curves of special orbits join those of shorter ones.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_JOIN_H
#define SALTUS_BRANCH_JOIN_H

#include "branch/locus_point.h"

/* A curve of grazing whose orbits touch again half their period later, but for something that falls to
 * nothing (the speed there, or a gap), joins that of orbits of half the period, where these have a flip; or
 * the same of orbits that are their own mirror images, where these have a branch point. The equations are
 * singular there; but the curve depends smoothly on that rest. *kind: GR-PD or GR-BP where the curve joins
 * another so just ahead of `here`, at `at`, GR-GR where another impact of the shorter orbit grazes too,
 * or where the shorter orbits are those of a third
 * of the period or less, otherwise REGULAR, or what the next function finds. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_locus_join(saltus_extended *extended, saltus_locus_point *here, saltus_locus_point *at,
                                saltus_point_kind *kind, saltus_message *message);
/* Curves of folds and of tori of orbits of twice the period end where these become those of half of it. The
 * equations are singular there, and beyond have nothing but the flips of the shorter orbits; but the curve
 * depends smoothly on how far the halves are apart, which tells near where the equations of the shorter
 * orbits have the place itself (halved.h). *kind: GPD, LP-PD, PD-NS, R2 or R4 where the curve ends so ahead
 * of `here`, at `at`; otherwise REGULAR. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_locus_join_halves(saltus_extended *extended, saltus_locus_point *here,
                                       saltus_locus_point *at, saltus_point_kind *kind,
                                       saltus_message *message);
/* Scaled states this near to one another where orbits join those of half the period tell no curve of folds.
 */
static const double saltus_alike = 5e-4;
/* Whether orbits on a curve of folds or tori become those of half the period between two points: their halves
 * change places, or are all but equal at the second, or ever nearer. *ahead of the first they are not yet. */
bool saltus_locus_halves_ahead(saltus_extended *extended, const saltus_locus_point *here,
                               const saltus_locus_point *next, double *ahead);

#endif
