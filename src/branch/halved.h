/* Private: points of codimension two at which curves of folds or tori of orbits of twice a period end,
 * located by the equations of the shorter orbits.
 *
 * GPD, LP-PD, PD-NS and R2 lie on the curve of flips of the shorter orbits, which is regular there. Each is
 * the zero of a function along it: the flip's criticality, a multiplier minus 1, the squared modulus of a
 * pair minus 1, the product of the null vectors. CP, where the folding orbits become their own mirror images,
 * is the zero of the criticality along the curve of branch points of such orbits. R4 is where the curve of
 * tori of the shorter orbits has the angle pi/2, which is an unknown there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_HALVED_H
#define SALTUS_BRANCH_HALVED_H

#include "branch/locus_point.h"

/* The kind of the orbit `at`, known to some digits, at which a curve of folds or tori of orbits of twice the
 * period ends: from the multipliers of its first half or, if the two halves of that are alike too, of a
 * quarter. GPD, LP-PD, PD-NS, R2 or R4: `at` becomes the accurate orbit, traversed as often as before;
 * otherwise REGULAR. `mirrored`: where folds end in orbits that are their own mirror images, CP, and `at`
 * likewise. Lack of memory is noted in the orbits. */
saltus_point_kind saltus_halved_tell(saltus_extended *extended, bool mirrored, saltus_locus_point *at);
/* The orbit `at`, known to some digits, may be that of so many `parts` (0: to be found) of its period at
 * whose grazing a curve of special orbits ends as impacts have lost their speed, or one of grazing joins that
 * of the shorter orbits. If so `at` becomes the zero of a function along their curve of grazing. Of `kind`
 * GR-LP it is their determinant, where the impact's infinite multiplier is not felt; of GR-PD that for a
 * flip; of GR-GR another impact's breach. For three parts or more a free vibration comes back there, or turns
 * round (R4: nothing else). Where that is not so, but one of the determinants is zero very near, it is that:
 * all impacts of an orbit that has been doubled several times die where the shortest flips. at->doubt as for
 * saltus_locus_doubt. Otherwise, or where that is farther away in the plane, false. */
bool saltus_halved_touch(saltus_extended *extended, saltus_point_kind kind, int parts, double farthest,
                         saltus_locus_point *at);
/* The orbit `at`, known to some digits, at which the pair of a curve of tori meets, R1 or R2, becomes the
 * double multiplier on the curve of folds or flips of the same orbits, which is regular there. False if it
 * cannot be found so. */
bool saltus_halved_double(saltus_extended *extended, saltus_point_kind kind, saltus_locus_point *at);
/* Whether a curve of grazing, at orbits `here` that are almost those of a third of their period or less,
 * leads to the place where a free vibration about these comes back after the period, or turns round; `at`
 * becomes that. What is unlike in the parts falls off with a power of the distance, and is rounding before
 * the place is reached. Lack of memory is noted in the orbits. */
bool saltus_halved_resonates(saltus_extended *extended, const saltus_locus_point *here,
                             saltus_locus_point *at);

#endif
