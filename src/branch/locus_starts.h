/* Private: starts of other curves of special points, at points of codimension two.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_LOCUS_STARTS_H
#define SALTUS_BRANCH_LOCUS_STARTS_H

#include "branch/archive.h"
#include "branch/corner.h"

/* Add the start of a curve at a special point `at` of a branch in the first parameter. `beyond`: at grazing
 * the sequence on the other side. */
void saltus_locus_starts_begin(saltus_orbits *orbits, saltus_point_kind kind, const saltus_solution *at,
                               const saltus_sequence *beyond, saltus_starts *starts);
/* Keep a copy; or, if there is such a start already, note that it is done if this one is. In a scene that is
 * its own mirror image the curves of orbits and of their images, `image` forcing periods later, are one;
 * otherwise it is NAN. *starved is set without memory. */
void saltus_locus_starts_add(saltus_starts *starts, const saltus_branch_start *start, double image,
                             bool *starved);
/* The curve of kind x->kind has come to a point of codimension two, the orbit `at`, where it joins orbits of
 * half the period, or such that are their own mirror images, if `joins`: a start that waits there for this
 * very curve is done, and it is noted that the curve has been here. True where that start is the one that was
 * taken last: the curve has come back to its begin. Lack of memory is noted in the orbits, here and below. */
bool saltus_locus_starts_pass(saltus_extended *x, const saltus_solution *at, bool joins,
                              saltus_starts *starts);
/* Add the other curves that meet the present one at the orbit `at`, a point of codimension two, unless they
 * have been there; `parent` and `depth` are theirs. At a cusp both folds are one curve, and at R3 and R4 no
 * curve of these kinds begins; nor do those of folds, flips and what branches off at an orbit of a family
 * (change.h). */
void saltus_locus_starts_meet(saltus_extended *x, const saltus_locus_test *corner, const saltus_solution *at,
                              int parent, int depth, saltus_starts *starts);

/* The sequence of an orbit `with` all impacts that graze at it; returns the mark of `touch` in it, -1 if not
 * found. An orbit may close after fewer periods than its sequence has, for example if its only impact has
 * lost its speed. Then it grazes in each of these parts, and the curve of grazing is that of the shorter
 * orbit. */
int saltus_locus_starts_grazing(saltus_orbits *orbits, const saltus_solution *at, const saltus_breach *touch,
                                saltus_sequence *with);

/* The first start at which a curve of special orbits, or of equilibria, is still to be begun, which counts as
 * taken; NULL: there is none. */
saltus_branch_start *saltus_locus_starts_next(saltus_starts *starts, bool of_rests);

#endif
