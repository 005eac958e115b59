/* Private: where other curves of special points begin: at points of codimension two.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_LOCUS_STARTS_H
#define SALTUS_BRANCH_LOCUS_STARTS_H

#include "branch/archive.h"
#include "branch/corner.h"

/* An orbit that a curve begins at. */
typedef struct saltus_locus_start {
    saltus_point_kind kind; /* of the curve's points */
    saltus_sequence sequence;
    double parameter[2];
    double *state;            /* at the base */
    int mark;                 /* grazing: the impact that has no speed */
    double theta;             /* Neimark-Sacker: of the pair of multipliers */
    bool one_way;             /* beyond the point of codimension two its orbits are not admissible */
    bool leaves;              /* its orbits are not those of half the period, or not their own mirror images,
                                 as the one that it begins at is */
    saltus_point_kind origin; /* the point of codimension two; REGULAR: none */
    int parent, depth;
    bool done; /* a curve has come to it from elsewhere */
} saltus_locus_start;

typedef struct saltus_locus_starts {
    saltus_locus_start *start;
    int count, next;
} saltus_locus_starts;

void saltus_locus_starts_clear(saltus_locus_starts *starts);
/* The curve of kind x->kind has come to a point of codimension two, the orbit `at`, where it joins orbits of
 * half the period, or such that are their own mirror images, if `joins`: a start that waits there for this
 * very curve is done, and it is noted that the curve has been here. *closes is set where that start
 * is the one that was taken last: the curve has come back to its begin. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_locus_starts_pass(const saltus_extended *x, const saltus_solution *at, bool joins,
                                       saltus_locus_starts *starts, bool *closes, saltus_message *message);
/* The other curves that meet the present one at a point of codimension two, the orbit `at`, are added, but
 * for those that have been there; `parent` and `depth` are theirs. At a cusp both folds are one curve, and at
 * a third or a quarter of the circle no curve of these kinds begins. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_locus_starts_meet(saltus_extended *x, const saltus_locus_test *corner,
                                       const saltus_solution *at, int parent, int depth,
                                       saltus_locus_starts *starts, saltus_message *message);

/* The marks of an orbit with the impacts that graze at it, and which of them `touch` is; -1: it cannot be
 * told. An orbit whose only impact has lost its speed, and others, may close after fewer periods than its
 * sequence has. It grazes in each of them then: the curve of grazing is that of the shorter orbit. */
int saltus_locus_starts_grazing(saltus_orbits *orbits, const saltus_solution *at, const saltus_breach *touch,
                                saltus_sequence *with);

/* A kind of points of which there are curves; another one is not sound (archive.h). */
saltus_point_kind saltus_locus_start_kind(saltus_archive *archive, saltus_point_kind kind);
/* Reading replaces the starts that there are. */
void saltus_locus_starts_archive(saltus_archive *archive, saltus_locus_starts *starts);

#endif
