/* Private: branches of equilibria of scenes without forcing, free or held against stops, with folds, branch
 * points, Hopf points, and the points where an equilibrium meets or leaves a stop; and the curves of such
 * points in two parameters.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_EQUILIBRIA_H
#define SALTUS_BRANCH_EQUILIBRIA_H

#include "branch/locus_starts.h"
#include "branch/rest.h"
#include "branch/trail.h"

typedef struct saltus_equilibria {
    saltus_trail *trail;   /* the caller's: receives the points */
    saltus_starts *cycles; /* the caller's: receives branches of cycles that leave */
    saltus_starts starts;  /* of branches of equilibria; of their sequences only the contacts count */
    saltus_rests rests;
    double range[2]; /* of the parameter unknown */
    saltus_rest *here, *next, *trial, *spare;
    saltus_rest solutions[4];
    saltus_starts *found; /* the caller's: receives where the requested locus begins */
} saltus_equilibria;

/* Branches through the equilibrium near a state (length dimension; NULL: none, if saltus_equilibria_archive
 * is to read them). `trail`, `found` and `cycles`, whose `begun` counts the branches of equilibria as they
 * begin, must be set. Close in any case. Errors: SALTUS_BAD_INPUT, SALTUS_SINGULAR, SALTUS_NO_CONVERGENCE,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_equilibria_open(saltus_equilibria *equilibria, const saltus_spec *spec,
                                     const double *state, saltus_message *message);
void saltus_equilibria_close(saltus_equilibria *equilibria);
/* Begin a branch at a start: give out its first point. From here on lack of memory is noted in the equations.
 * Errors: those of the equations. */
saltus_status saltus_equilibria_start(saltus_equilibria *equilibria, const saltus_branch_start *start,
                                      saltus_message *message);
/* One step along the branch under way. If a locus is requested the branch ends where that begins. */
void saltus_equilibria_advance(saltus_equilibria *equilibria);
/* Everything, except the trail, on which later steps depend: written, or read into what was opened. Errors:
 * SALTUS_NO_MEMORY, those of the evaluation. */
saltus_status saltus_equilibria_archive(saltus_equilibria *equilibria, saltus_archive *archive,
                                        saltus_message *message);

/* Give out an equilibrium as a point of a branch or, if the equations are those of special ones, of a locus.
 * A BE, and each point of their locus, tells the face that is touched. False, and it is not followed on,
 * without memory, which is noted. */
bool saltus_rest_give(saltus_rests *rests, const saltus_rest *rest, saltus_notice what, saltus_trail *trail);

/* In rest_locus.c: curves of Hopf points, boundary equilibria and folds of equilibria in the plane of two
 * parameters. */
typedef struct saltus_rest_locus {
    saltus_trail *trail;   /* the caller's: receives the points */
    saltus_starts *starts; /* the caller's: receives places at which other curves begin, at generalised
                                    Hopf points of cycles that fold */
    bool switched;         /* the curve under way begins at such a place */
    saltus_rests rests;    /* what makes the equilibria special is renewed from point to point */
    saltus_rest here, next, trial;
    double beginning[2 * SALTUS_REST_UNKNOWNS_MAX]; /* unknowns and tangent of the first point */
    double first_square;
    double border[2][2]; /* of both parameter unknowns: low, high */
    int first_way;       /* 1 or -1 along the tangent there; the second is against it */
    int way_count, way;  /* ways from there, and those begun so far */
} saltus_rest_locus;

/* A locus through a special equilibrium of a branch in the first parameter; NULL: none, if it is to begin at
 * one of the starts, or if saltus_rest_locus_archive is to read it. `trail` and `starts` must be set. Close
 * in any case. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_rest_locus_open(saltus_rest_locus *locus, const saltus_spec *spec,
                                     const saltus_branch_start *first, saltus_message *message);
/* It can be opened again, with the same trail and starts. */
void saltus_rest_locus_close(saltus_rest_locus *locus);
/* One step, which may give out points; *more is false when all is done. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_rest_locus_step(saltus_rest_locus *locus, bool *more, saltus_message *message);
/* All that later steps depend on, but for trail and starts, written, or read into what was opened. Errors:
 * SALTUS_NO_MEMORY, those of the evaluation. */
saltus_status saltus_rest_locus_archive(saltus_rest_locus *locus, saltus_archive *archive,
                                        saltus_message *message);

#endif
