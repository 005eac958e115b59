/* Private: curves of folds, flips, Neimark-Sacker, branch and grazing points in the plane of two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_LOCUS_H
#define SALTUS_BRANCH_LOCUS_H

#include "branch/locus_point.h"
#include "branch/locus_starts.h"
#include "branch/trail.h"

/* Successive places on a curve where two impacts graze. */
typedef struct saltus_grazings {
    double last[2], gap; /* the last place, and its distance from the one before */
    int closer;          /* how many times in a row the distance has shrunk */
} saltus_grazings;

typedef struct saltus_locus {
    saltus_trail *trail;   /* the caller's: receives the points */
    saltus_starts *starts; /* the caller's: receives all places at which other curves begin */
    saltus_extended x;
    double origin[2];
    double border[2][2]; /* of both parameter unknowns: low, high */
    /* The current curve. */
    saltus_point_kind begun_at;   /* point of codimension two at which it begins; REGULAR: none */
    int way_count, way;           /* directions from its first point, and those begun so far */
    saltus_sequence first;        /* sequence of its first point */
    saltus_curve_point beginning; /* its first point; of a resumed run only the unknowns */
    int first_mark;
    double first_way[2]; /* direction in the plane in which it left that point */
    bool has_left;       /* it has been more than a few steps away from there */
    saltus_grazings grazings;
    saltus_locus_point here, next, trial;
} saltus_locus;

/* A locus through a start; NULL: none, if it is to begin at one of the starts, or if
 * saltus_locus_archive is to read it. `trail` and `starts` must be set. When it is done, starts of curves of
 * Hopf points may wait: equilibria.h follows them. Close in any case. Errors: SALTUS_NO_MEMORY,
 * SALTUS_BAD_INPUT, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_locus_open(saltus_locus *locus, const saltus_spec *spec,
                                const saltus_branch_start *first, saltus_message *message);
/* It can be opened again, with the same trail and starts. */
void saltus_locus_close(saltus_locus *locus);
/* One step, which may give out points; *more is false when all curves are done. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_locus_step(saltus_locus *locus, bool *more, saltus_message *message);
/* Everything, except trail and starts, on which later steps depend, written or read. Errors:
 * SALTUS_NO_MEMORY, those of saltus_locus_open. */
saltus_status saltus_locus_archive(saltus_locus *locus, saltus_archive *archive, saltus_message *message);

#endif
