/* Private: where curves of special orbits join those of shorter ones. Lack of memory is noted in the orbits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_JOIN_H
#define SALTUS_BRANCH_JOIN_H

#include "branch/locus_point.h"

/* A curve of grazing may join that of orbits of half the period at a flip of these: its orbits touch again
 * half a period later, up to a remainder (a speed or a gap) that falls to zero. In the same way it may join a
 * curve of symmetric orbits at a branch point of these. The equations are singular there, but the curve
 * depends smoothly on the remainder or, where several impacts die at once and the remainder is of second
 * order, on their speeds. The place so known is then located along the curve of the shorter orbits
 * (halved.c), where that can be; beyond a long run of impacts it is only known so. GR-PD or GR-BP if the
 * curve joins another one just ahead of `here`, at `at`; GR-GR if another impact of the shorter orbits grazes
 * too, or if their period is a third or less; REGULAR otherwise. On curves of other kinds it is the result of
 * saltus_locus_join_halves. */
saltus_point_kind saltus_locus_join(saltus_extended *extended, saltus_locus_point *here,
                                    saltus_locus_point *at);
/* The same where another impact seems to graze at the orbit `at` on the curve: what is unlike there may fall
 * with a root of the distance and need not be nothing yet. `at` becomes the place that the equations of the
 * shorter orbits have very near, if there is one. */
saltus_point_kind saltus_locus_join_near(saltus_extended *extended, saltus_locus_point *at);
/* Where a curve of special orbits ends as an impact has lost its speed, at `at`, located ahead of `here`,
 * several may have, and the equations be singular: then `at` becomes the place that the curve of the impact's
 * grazing has there, or else that the curve before it leads to, where that is told sharper. All places found
 * here get their doubt. */
void saltus_locus_sharpen_end(saltus_extended *extended, saltus_locus_point *here, saltus_locus_point *at);
/* Where several impacts lose their speed at once, the equations of other curves become singular and lead
 * nowhere; but these curves depend smoothly on the root of that speed. Whether the curve of `here` ends so
 * just ahead, at the orbit `at`. */
bool saltus_locus_fade(saltus_extended *extended, saltus_locus_point *here, saltus_locus_point *at);
/* Curves of folds and of tori of orbits of twice the period end where these become those of half of it. The
 * equations are singular there, and beyond have nothing but the flips of the shorter orbits; but the curve
 * depends smoothly on how far the halves are apart, which tells near where the equations of the shorter
 * orbits have the place itself (halved.c). The same holds of folds of orbits that become their own mirror
 * images, where the branch points of these change their criticality. GPD, LP-PD, PD-NS, R2, R4 or CP where
 * the curve ends so ahead of `here`, at `at`; otherwise REGULAR. */
saltus_point_kind saltus_locus_join_halves(saltus_extended *extended, saltus_locus_point *here,
                                           saltus_locus_point *at);
/* Where the states of the two halves are this close (scaled), the equations no longer determine a curve of
 * folds. */
static const double saltus_alike = 5e-4;
/* Whether orbits on a curve of folds or tori may become such between two points, or soon: their halves change
 * places, or are all but equal at the second, or ever nearer. *ahead of the first they are not yet; 0: nor
 * are they at the second. */
bool saltus_locus_halves_ahead(saltus_extended *extended, const saltus_locus_point *here,
                               const saltus_locus_point *next, double *ahead);
/* The tolerance of the equations for a step from `here`: sharper than the `usual` one near there, where the
 * function that is zero on the curve is of fourth order in how far the halves are apart; and where impacts
 * are slow, as an error changes multipliers in its ratio to the speed. */
double saltus_locus_sharpness(saltus_extended *extended, const saltus_locus_point *here, double usual);

/* In halved.c. The kind of the orbit `at`, known to some digits, at which a curve of folds or tori of orbits
 * of twice the period ends: from the multipliers of its first half or, if the two halves of that are alike
 * too, of a quarter. GPD, LP-PD, PD-NS, R2 or R4: `at` becomes the accurate orbit, traversed as often as
 * before; otherwise REGULAR. `mirrored`: where folds end in orbits that are their own mirror images, CP, and
 * `at` likewise. */
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
/* The same for one part: `at` is an orbit of the curve itself, with an impact that has almost lost its speed,
 * and `kind` the function that the curve of its grazing has (corner.h); on a curve of grazing it is all but
 * its own mirror image, and becomes one, on the curve of these. */
bool saltus_halved_still(saltus_extended *extended, saltus_point_kind kind, double farthest,
                         saltus_locus_point *at);
/* Either, for the orbit `here` of a curve that leads there, no farther away in the plane than `near`. A curve
 * of grazing whose orbits cannot be told from their mirror images (parts = 1) may have passed the place. */
bool saltus_halved_ahead(saltus_extended *extended, saltus_point_kind kind, int parts, double near,
                         const saltus_locus_point *here, saltus_locus_point *at);
/* The orbit `at`, known to some digits, at which the pair of a curve of tori meets, R1 or R2, becomes the
 * double multiplier on the curve of folds or flips of the same orbits, which is regular there. False if it
 * cannot be found so. */
bool saltus_halved_double(saltus_extended *extended, saltus_point_kind kind, saltus_locus_point *at);
/* Whether a curve of grazing, at orbits `here` that are almost those of a third of their period or less,
 * leads to the place where a free vibration about these comes back after the period, or turns round; `at`
 * becomes that. What is unlike in the parts falls off with a power of the distance, and is rounding before
 * the place is reached. */
bool saltus_halved_resonates(saltus_extended *extended, const saltus_locus_point *here,
                             saltus_locus_point *at);

#endif
