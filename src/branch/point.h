/* Private: points of a branch as they are given out.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_POINT_H
#define SALTUS_BRANCH_POINT_H

#include "base/field.h"
#include "branch/solution.h"
#include "saltus/branch.h"

/* "regular", "LP", ... */
extern const saltus_word saltus_point_words[];

/* A cycle as its section counts it. */
typedef struct saltus_cycle_count {
    int returns; /* to the section; -1: unknown, or no cycle */
    /* Orbits from the sequence's base to the point's state, from which the point's times count. */
    double first;
} saltus_cycle_count;

/* Allocate a point for `dimension` states and this number of events; values that may stay unknown are NAN.
 * False without memory; the point is then cleared. */
bool saltus_point_open(saltus_branch_point *point, int dimension, int events);
/* Fill a point with what a surveyed solution tells. At changes of events it is chance which side the flow
 * sees: there take the `prescribed` events and state. The point owns its arrays (saltus_branch_point_clear).
 * False without memory, which is noted. */
bool saltus_point_make(saltus_orbits *orbits, const saltus_solution *solution, bool prescribed,
                       saltus_branch_point *point, saltus_cycle_count *count);
/* The multipliers, and what follows from them, of a surveyed solution. */
void saltus_point_take_multipliers(const saltus_solution *solution, saltus_branch_point *point);
/* The time at which a point made of a solution has what is at `time` of its sequence. */
double saltus_point_time(const saltus_solution *solution, const saltus_cycle_count *count, double time);
/* Record a breach as the touch at grazing, or of an equilibrium. */
void saltus_point_mark_grazing(const saltus_system *system, const saltus_breach *breach,
                               saltus_branch_point *point);

#endif
