/* Private: changes of the sequence of events along a branch: where they happen and how the branch continues.
 *
 * At grazing (the speed of an impact falls to zero, or a free maximum of a gap touches a stop) the impact is
 * removed or inserted: the orbit is the same on both sides, and its new tangent follows from the new
 * equations. Of the two directions along the new curve the branch takes one in which the event-driven flow
 * follows the new sequence; it may lead back in the parameter (a non-smooth fold). Where chatter completes,
 * or a contact ends or splits, the two sequences have no common unknowns: the orbit beyond is found by
 * shooting with the flow's own events, a little further on in the parameter. Where chatter no longer
 * completes, the branch goes on with orbits of only the first of its impacts: the more, the nearer to there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_CHANGE_H
#define SALTUS_BRANCH_CHANGE_H

#include "branch/solution.h"
#include "saltus/branch.h"

/* A change of events this close to a border of the range, in the parameter unknown, lies on the border. */
static const double saltus_at_border = 1e-12;

typedef struct saltus_change {
    saltus_point_kind kind; /* GR, CH or ST; EP: no change of events is known where the branch ends; REGULAR:
                               there is none, but the step jumps over a place where the continuation failed */
    double value;           /* of the parameter, where known more accurately than from `at`; otherwise 0 */
    double accuracy;
    const char *reason;           /* what changes, or why the branch ends */
    char after[SALTUS_LABEL_MAX]; /* the label beyond the change; "": the branch ends */
    bool turns_back;              /* the parameter does */
    double distance;              /* arclength from the change to the next point of the branch */
    bool at_border;               /* `here` is on the border of the range, and so is `at` to rounding */
} saltus_change;

/* Continue the branch beyond grazing at these parameters and states at the cuts: `here` becomes the same
 * orbit with the sequence `beyond`, `next` a point a little further on which the flow follows. `old` (may be
 * NULL): the tangent before grazing, in the new unknowns. False: no orbit of this period continues with other
 * events. */
bool saltus_change_pass(saltus_orbits *orbits, const saltus_sequence *beyond, const double *parameters,
                        const double *states, const double *old, saltus_solution *here,
                        saltus_solution *next);
/* Whether no orbit near `here`, which grazes, on the curve along its tangent is admissible: both ways a
 * breach grows evenly from there. `next` is overwritten. */
bool saltus_change_bars(saltus_orbits *orbits, saltus_solution *here, saltus_solution *next);
/* The change of events at the grazing orbit `at`, at the end of a step `from` another one: *change gets kind
 * GR if the branch continues with the sequence `beyond`, otherwise EP; its reason is NULL if the impact that
 * is born is too close to another one to be distinguished from it. */
void saltus_change_graze(saltus_orbits *orbits, const saltus_solution *from, const saltus_solution *at,
                         saltus_sequence *beyond, saltus_solution *here, saltus_solution *next,
                         saltus_change *change);
/* Whether the orbit at a change without its impacts of zero speed is one of a family of orbits at the same
 * parameters, of which no single one is special: without damping, where the period is that of oscillations
 * between impacts. *doubled: whether it is, or orbits of twice the period are. */
bool saltus_change_in_family(saltus_orbits *orbits, const saltus_solution *at, bool *doubled);
/* Why the branch must leap to other orbits. */
typedef enum saltus_leap {
    SALTUS_LEAP_EVENTS, /* the flow no longer meets the prescribed events */
    SALTUS_LEAP_LOST,   /* from some point on the equations have no solution */
    SALTUS_LEAP_RUN     /* grazings accumulate, and rounding hides the next one */
} saltus_leap;

/* The orbits of the branch through `from` exist, or are followed by the flow, only up to some point before
 * `ahead`: `at` becomes the last of them, `here` an orbit beyond, within `range`, if one was found. If there
 * is no last orbit either, accuracy is NAN and `at` is not set. `scratch` is overwritten. */
void saltus_change_leap(saltus_orbits *orbits, const saltus_solution *from, double ahead, saltus_leap leap,
                        const char *why, const double range[2], saltus_solution *at, saltus_solution *here,
                        saltus_solution *scratch, saltus_change *change);
/* The latest of successive births of impacts. */
enum { saltus_births_length = 4 };
typedef struct saltus_births {
    int count;
    double place[saltus_births_length]; /* parameter unknowns, the latest birth last */
} saltus_births;

/* An impact is born at `place`, or one dies, which clears the list. */
void saltus_births_note(saltus_births *births, bool born, double place);
/* Chatter completes where births of impacts accumulate, in a geometric sequence: at its limit, to within a
 * fraction of the distance of the last birth from there. From `from`, an orbit one step after the last birth,
 * `at` becomes the orbit on which the contact after complete chatter has zero length, `here` one beyond,
 * within `range`.
 * `far`: `from` may be further away, but the place must agree better with the limit. `scratch` is
 * overwritten. False if no orbit with complete chatter that begins there was found; the shooting then has the
 * sequence of `from`.
 */
bool saltus_change_complete(saltus_orbits *orbits, const saltus_solution *from, const saltus_births *births,
                            bool far, const double range[2], saltus_solution *at, saltus_solution *here,
                            saltus_solution *scratch, saltus_change *change);
/* The label changes between `from` and `to` while the prescribed events stay the same: the change is in the
 * part of the sequence that is left to the flow. `at` becomes the last orbit with the contacts of `from`;
 * false if there is none. */
bool saltus_change_within(saltus_orbits *orbits, const saltus_solution *from, const saltus_solution *to,
                          saltus_solution *at, saltus_change *change);
/* Build the sequence of `here`, an orbit with complete chatter, anew from the events that the flow meets:
 * `fresh`. Where chatter completes may be known better from this side; if so it goes to *value and *accuracy.
 * `scratch` is overwritten. False if it fails: the shooting is then as before. */
bool saltus_change_retrace(saltus_orbits *orbits, const saltus_solution *here, saltus_solution *fresh,
                           saltus_solution *scratch, double *value, double *accuracy);

#endif
