/* Private: special points on a step, and the branches that leave there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_SPECIAL_H
#define SALTUS_BRANCH_SPECIAL_H

#include "branch/solution.h"
#include "saltus/branch.h"

/* A special point between two solutions. */
typedef struct saltus_special {
    saltus_point_kind kind; /* REGULAR: a value at which the branch may have come back to its begin */
    saltus_test test;
    double target; /* of the parameter, where the test is that */
    double ahead, accuracy;
    const char *end; /* the branch ends here: why; NULL: it does not */
    double value;    /* of the parameter; sharper than the solution's where the equations are singular */
    bool sharp;      /* where they are singular: the place was interpolated between points on both sides */
} saltus_special;

/* Whether a test has changed its sign. */
bool saltus_test_crosses(double before, double after);
/* One more in the order of arclength; returns how many there are. */
int saltus_special_insert(saltus_special found, saltus_special *specials, int count);
/* All places between `from` and `to` where tests change their sign, in order; `scratch` is overwritten. Where
 * `fresh`, at the begin of a branch that was switched to, the determinants are zero to rounding and tell
 * nothing: then only targets are looked out for. `targets`: values of the parameter that are looked out for,
 * `kinds` what they are; `hopf` (NULL: none) is one that saltus_special_hopf has found. `specials` has room
 * for target_count + 7. Returns how many there are. */
int saltus_special_find(saltus_orbits *orbits, const saltus_solution *from, const saltus_solution *to,
                        bool fresh, const saltus_special *hopf, const double *targets,
                        const saltus_point_kind *kinds, int target_count, saltus_special *specials,
                        saltus_solution *scratch);
/* The place at which orbits of a period of their own seem to shrink to an equilibrium; false: there is none.
 */
bool saltus_special_hopf(saltus_orbits *orbits, const saltus_solution *from, const saltus_solution *to,
                         saltus_special *special, saltus_solution *scratch);
/* What is at such a place: `at` becomes the orbit there, surveyed, and kind, value, accuracy and end are set.
 * False: it is no special point after all. `reach`: length of the step from `from`. Errors: SALTUS_NO_MEMORY.
 */
saltus_status saltus_special_visit(saltus_orbits *orbits, const saltus_solution *from, double reach,
                                   saltus_special *special, saltus_solution *at, bool *is_one,
                                   saltus_message *message);

/* How far the parameter of a special point may be off, beside the width of the bracket that it was found in:
 * by rounding, and by what a flow of another tolerance makes of curve and test there. `at`: of the shooting's
 * sequence, near the zero of the test. INFINITY where that flow finds no such point. */
double saltus_special_doubt(saltus_orbits *orbits, saltus_test test, const saltus_solution *at);

/* Whether a step has led to orbits that close, or are their own mirror images, after half of the period, from
 * orbits that do not: the branch meets theirs, and the step was too long to see it turn back there. */
bool saltus_special_strays(saltus_orbits *orbits, const saltus_solution *here, const saltus_solution *next);

/* Where a branch begins. */
typedef struct saltus_branch_start {
    saltus_sequence sequence;
    double parameter;
    double *state;   /* at the base */
    double *tangent; /* NULL: the null vector of the equations, heading where `heading` says */
    int unknowns;
    int heading, parent, depth;
    bool grazes;              /* an impact without speed: the flow decides which way the branch goes */
    saltus_point_kind origin; /* the kind of point it was switched to at; REGULAR: none */
} saltus_branch_start;

/* Those that no branch has begun at yet, in order. */
typedef struct saltus_starts {
    saltus_branch_start *start;
    int count;
    int begun; /* taken out before, or passed over: the number of the next branch */
} saltus_starts;

/* Keep a copy. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_starts_add(saltus_starts *starts, int n, const saltus_branch_start *start,
                                saltus_message *message);
/* The same for both ways along a branch, or, where `direction` is not 0, for one: with that heading, or with
 * the tangent as it is (1) or turned round (-1). */
saltus_status saltus_starts_add_ways(saltus_starts *starts, int n, saltus_branch_start *start, int direction,
                                     saltus_message *message);
/* Take out the first of them; the caller's, to be cleared. */
saltus_branch_start saltus_starts_take(saltus_starts *starts);
void saltus_start_clear(saltus_branch_start *start);
void saltus_starts_clear(saltus_starts *starts);

/* The branches that leave at a flip or branch point `at` are added. `like` has what is common to the starts.
 * Errors: SALTUS_NO_MEMORY, those of the equations, where the branches cannot be had. */
saltus_status saltus_starts_leave(saltus_orbits *orbits, const saltus_solution *at, saltus_point_kind kind,
                                  const saltus_branch_start *like, saltus_starts *starts,
                                  saltus_message *message);
/* The branch of twice the period at grazing, whose orbits have the impact in one half only: `beyond` is the
 * sequence on the other side of `at`. None where more than one impact is born or dies. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status saltus_starts_graze(saltus_orbits *orbits, const saltus_solution *at,
                                  const saltus_sequence *beyond, const saltus_branch_start *like,
                                  saltus_starts *starts, saltus_message *message);

#endif
