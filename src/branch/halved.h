/* Private: points of codimension two at which folds or tori of orbits of twice a period end, by equations of
 * the shorter orbits.
 *
 * GPD, LP-PD, PD-NS and R2 lie on the shorter orbits' curve of flips, which is regular there, and are the
 * zeros of one function along it: what makes a flip sub- or supercritical, a multiplier less 1, the square of
 * the modulus of a pair less 1, the product of the null vectors. R4 is where the pair of the shorter orbits'
 * curve of tori has the angle pi/2, which is an unknown of that curve.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_HALVED_H
#define SALTUS_BRANCH_HALVED_H

#include "branch/locus_point.h"

/* What the orbit `at` is that folds or tori of orbits of twice the period end at, known to some digits: by
 * the multipliers of its first half, or, where that has halves that are alike too, of a quarter. GPD, LP-PD,
 * PD-NS, R2 or R4: `at` becomes it, gone through as often as before; otherwise REGULAR. Memory that was
 * lacking is noted in the orbits. */
saltus_point_kind saltus_halved_tell(saltus_extended *extended, saltus_locus_point *at);

#endif
