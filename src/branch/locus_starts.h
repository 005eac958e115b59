/* Private: starts of other curves of special points, at points of codimension two.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_LOCUS_STARTS_H
#define SALTUS_BRANCH_LOCUS_STARTS_H

#include "branch/archive.h"
#include "branch/corner.h"

/* An orbit at which a curve begins. */
typedef struct saltus_locus_start {
    saltus_point_kind kind; /* of the curve's points */
    saltus_sequence sequence;
    double parameter[2];
    double *state; /* at the base */
    int mark;      /* grazing: mark of the impact of zero speed */
    double theta;  /* Neimark-Sacker: angle of the pair of multipliers */
    bool one_way;  /* its orbits are admissible only on one side of the start */
    bool leaves; /* its orbits do not close after half the period, or are not their own mirror images, though
                    the first one does or is */
    saltus_point_kind origin; /* the point of codimension two; REGULAR: none */
    int parent, depth;
    bool done; /* a curve has come here from elsewhere */
} saltus_locus_start;

typedef struct saltus_locus_starts {
    saltus_locus_start *start;
    int count, next;
} saltus_locus_starts;

void saltus_locus_starts_clear(saltus_locus_starts *starts);
/* The curve of kind x->kind has come to the orbit `at`, a point of codimension two; `joins`: there its orbits
 * join those of half the period or symmetric ones. Mark a start that waits there for this very curve as done,
 * and note that the curve has been here. *closes is set if that start is the one taken last: the curve has
 * come back to its beginning. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_locus_starts_pass(const saltus_extended *x, const saltus_solution *at, bool joins,
                                       saltus_locus_starts *starts, bool *closes, saltus_message *message);
/* Add the other curves that meet the present one at the orbit `at`, a point of codimension two, unless they
 * have been there; `parent` and `depth` are theirs. At a cusp both folds are one curve, and at R3 and R4 no
 * curve of these kinds begins. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_locus_starts_meet(saltus_extended *x, const saltus_locus_test *corner,
                                       const saltus_solution *at, int parent, int depth,
                                       saltus_locus_starts *starts, saltus_message *message);

/* The sequence of an orbit `with` all impacts that graze at it; returns the mark of `touch` in it, -1 if not
 * found. An orbit may close after fewer periods than its sequence has, for example if its only impact has
 * lost its speed. Then it grazes in each of these parts, and the curve of grazing is that of the shorter
 * orbit. */
int saltus_locus_starts_grazing(saltus_orbits *orbits, const saltus_solution *at, const saltus_breach *touch,
                                saltus_sequence *with);

/* Archive a kind of which there are curves; any other kind makes the archive unsound (archive.h). */
saltus_point_kind saltus_locus_start_kind(saltus_archive *archive, saltus_point_kind kind);
/* Reading replaces the present starts. */
void saltus_locus_starts_archive(saltus_archive *archive, saltus_locus_starts *starts);

#endif
