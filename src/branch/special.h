/* Private: special points on a step, and the branches that leave there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_SPECIAL_H
#define SALTUS_BRANCH_SPECIAL_H

#include "branch/solution.h"
#include "saltus/branch.h"

/* A special point between two solutions. */
typedef struct saltus_special {
    saltus_point_kind kind; /* REGULAR: the branch may have come back to its first orbit */
    saltus_test test;
    double target; /* for the test VALUE */
    double ahead, accuracy;
    const char *end; /* why the branch ends here; NULL: it does not */
    double value; /* of the parameter; more accurate than the solution's where the equations are singular */
    bool sharp;   /* singular equations: the place was interpolated between points on both sides */
    bool lost;    /* its test changes sign, but no orbit is found there: `ahead` is only near it */
} saltus_special;

/* Whether a test has changed its sign. */
bool saltus_test_crosses(double before, double after);
/* Insert in order of arclength; returns the new count. */
int saltus_special_insert(saltus_special found, saltus_special *specials, int count);
/* Find all places between `from` and `to` where tests change sign, in order of arclength; returns their
 * number. `fresh`: at the beginning of a branch that was switched to; the determinants are then rounding, and
 * only what is `wanted` is searched: targets, with their kinds. `hopf` (may be NULL): found by
 * saltus_special_hopf. `specials` has room for wanted_count + 9; `scratch` is overwritten.
 * *hidden: just before a crossing of curves the orbits of this one were not reached, so that others may be
 * missing. */
int saltus_special_find(saltus_orbits *orbits, const saltus_solution *from, const saltus_solution *to,
                        bool fresh, const saltus_special *hopf, const saltus_special *wanted,
                        int wanted_count, saltus_special *specials, bool *hidden, saltus_solution *scratch);
/* The place where cycles seem to shrink to an equilibrium; false: there is none. */
bool saltus_special_hopf(saltus_orbits *orbits, const saltus_solution *from, const saltus_solution *to,
                         saltus_special *special, saltus_solution *scratch);
/* Judge such a place: `at` becomes the orbit there, surveyed, and kind, value, accuracy and end are set.
 * False if it is no special point after all, or is lost. `reach`: length of the step from `from`. */
bool saltus_special_visit(saltus_orbits *orbits, const saltus_solution *from, double reach,
                          saltus_special *special, saltus_solution *at);

/* The possible error of a special point's parameter, besides the width of its bracket: from rounding, and
 * from the difference to a flow of another tolerance. `at`: has the shooting's sequence and is near the zero
 * of the test. INFINITY if that flow finds no such point. */
double saltus_special_doubt(saltus_orbits *orbits, saltus_test test, const saltus_solution *at);

/* Whether an orbit is one of half the period, as far as rounding tells. */
bool saltus_special_halves(saltus_orbits *orbits, const saltus_solution *solution);
/* Whether a step has led from orbits that do not close (or are not their own mirror images) after half the
 * period to orbits that do: the step was too long to see that the branch meets theirs and turns back
 * there. */
bool saltus_special_strays(saltus_orbits *orbits, const saltus_solution *here, const saltus_solution *next);

/* The kinds of special orbits of which there are curves. */
static const unsigned saltus_orbit_loci = 1u << SALTUS_POINT_LP | 1u << SALTUS_POINT_PD |
                                          1u << SALTUS_POINT_NS | 1u << SALTUS_POINT_BP |
                                          1u << SALTUS_POINT_GR;

/* Where a branch begins, or a curve of special points. Its arrays are the maker's; a list has its own copies.
 */
typedef struct saltus_branch_start {
    saltus_sequence sequence;
    double parameter[2];
    const double *state, *tangent;
    int states;   /* numbers of the states at all cuts, of the equilibrium otherwise; 0: only its place counts
                   */
    int unknowns; /* entries of the tangent; 0: it is the null vector, with the sign of `heading` */
    int heading, parent, depth;
    int place; /* number of the joined place (trail.h) that this and its like lead away from, counted
                  from 1; 0: none */
    saltus_point_kind origin; /* kind of the point where it branches off; REGULAR: none; GR: an impact has
                                 zero speed, and the flow decides the direction */
    /* Of a curve. GH: the state is that of the equilibrium, which the sequence's anchor leads away from. */
    saltus_point_kind kind; /* of its points; HB, or begun at BT: of equilibria (equilibria.h) */
    int mark;               /* grazing: the impact that has no speed; BE: the face that is touched */
    double theta;           /* Neimark-Sacker: of the pair of multipliers */
    bool one_way;           /* beyond the point of codimension two its orbits are not admissible */
    bool leaves;            /* its orbits are not those of half the period, or not their own mirror images, as
                               the one that it begins at is */
    bool done;              /* a curve has come here from elsewhere */
} saltus_branch_start;

/* Starts of branches that are still to be followed, in order; or all those of curves. */
typedef struct saltus_starts {
    saltus_branch_start *start;
    int count;
    int begun; /* starts taken or passed over so far: the number of the next branch; of curves: the number of
                  the start that was taken last, counted from 1 */
} saltus_starts;

/* `between`, among the orbits `own`, opened for it, becomes the orbit between the two halves of `at`, which
 * are all but alike: of half the period or, `mirrored`, of the same one. Its tangent is that of such orbits.
 * Errors: no such orbit, SALTUS_NO_MEMORY. */
saltus_status saltus_special_between(saltus_orbits *orbits, saltus_orbits *own, const saltus_solution *at,
                                     bool mirrored, saltus_solution *between);

/* Append a copy. *starved is set without memory, here and below. */
void saltus_starts_add(saltus_starts *starts, const saltus_branch_start *start, bool *starved);
/* Append the start at this orbit: its sequence, of the same orbit, of part of its period or of several times
 * it, gets the orbit's cuts, and the start the parameters and the states there. */
void saltus_starts_add_at(saltus_orbits *orbits, const saltus_solution *at, const saltus_branch_start *start,
                          saltus_starts *starts);
/* Append both directions along a branch or, if `direction` is not 0, one: with that heading, or with the
 * tangent as it is (1) or reversed (-1). */
void saltus_starts_add_ways(saltus_starts *starts, const saltus_branch_start *start, int direction,
                            bool *starved);
/* Take out the first start, with its arrays, which `saltus_branch_start_clear` frees. */
saltus_branch_start saltus_starts_take(saltus_starts *starts);
void saltus_branch_start_clear(saltus_branch_start *start);
/* Remove start k. */
void saltus_starts_remove(saltus_starts *starts, int k);
/* Remove those that lead away from a joined place; returns their number. */
int saltus_starts_drop(saltus_starts *starts, int place);
void saltus_starts_clear(saltus_starts *starts);

/* Add the branches that leave at `at`, a point of this kind; `like` has what the starts have in common. At a
 * flip or branch point these are those of its equations; at grazing, where `beyond` is the sequence on the
 * other side, that of twice the period whose orbits have the impact in one half only, but none where more
 * than one impact is born or dies. Errors: those of the equations, if the branches cannot be found. */
saltus_status saltus_starts_leave(saltus_orbits *orbits, const saltus_solution *at, saltus_point_kind kind,
                                  const saltus_sequence *beyond, const saltus_branch_start *like,
                                  saltus_starts *starts, saltus_message *message);

/* Whether all multipliers are zero, as after chatter of a single mass: such orbits neither fold nor flip,
 * though the tests are zero to rounding where one of their impacts was just born, and none of twice the
 * period leaves where one grazes. */
bool saltus_special_forgets(const saltus_survey *survey);

#endif
