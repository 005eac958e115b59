/* Private: changes of the sequence of events along a branch: where they are, and how the branch goes on.
 *
 * Where an impact's speed falls to zero the impact is taken out; where a free maximum touches a stop one is
 * put in: the orbit is the same on both sides of the change, and its new tangent follows from the new
 * equations. Of the two ways along it those are admissible on which the event-driven flow follows the new
 * sequence; often it is one, and it may lead back in the parameter (a non-smooth fold). Where chatter
 * completes, or a contact ends or splits, the sequences on the two sides share no unknowns: the orbit beyond
 * is sought by shooting with the flow's own events, a little further on in the parameter.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_CHANGE_H
#define SALTUS_BRANCH_CHANGE_H

#include "branch/solution.h"
#include "saltus/branch.h"

/* A change this near to a border of the range, in the parameter unknown, is at it. */
static const double saltus_at_border = 1e-12;

typedef struct saltus_change {
    saltus_point_kind kind; /* GR, CH or ST; EP: the branch ends; REGULAR: the events stay, but the step leads
                               over a difficulty of the continuation */
    double value;           /* of the parameter, where it is known sharper than `at` tells; otherwise 0 */
    double accuracy;
    const char *reason;           /* what changes, or why the branch ends */
    char after[SALTUS_LABEL_MAX]; /* the label beyond */
    bool turns_back;              /* in the parameter */
    double distance;              /* arclength from the change to where the branch goes on */
    bool at_border; /* `here` is on the border of the range, on which `at` lies but for rounding */
} saltus_change;

/* The branch goes on beyond grazing at `at`: `here` becomes the same orbit with the sequence `beyond`, and
 * `next` a point a little further on that the flow follows. `old`: the tangent at `at` among the new
 * unknowns. False: no orbit of this period goes on with other events. */
bool saltus_change_pass(saltus_orbits *orbits, const saltus_sequence *beyond, const double *parameters,
                        const double *state, const double *old, saltus_solution *here, saltus_solution *next);
/* The change at grazing, `at`: the sequence beyond is found and passed to (kind GR), or kind is EP; without a
 * reason where the impact that is born is too near to another one to be told from it. The sequence on the
 * other side goes to `beyond`. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_change_graze(saltus_orbits *orbits, const saltus_solution *at, saltus_sequence *beyond,
                                  saltus_solution *here, saltus_solution *next, saltus_change *change,
                                  saltus_message *message);
/* What makes the branch leap. */
typedef enum saltus_leap {
    SALTUS_LEAP_EVENTS, /* the flow's events cease to be those that are prescribed */
    SALTUS_LEAP_LOST,   /* the equations have no solution from somewhere on */
    SALTUS_LEAP_RUN     /* grazings follow one another so closely that the next is beyond rounding */
} saltus_leap;

/* The branch ceases to be as it is at `from` before `ahead`: `at` becomes the last orbit at which they are,
 * `here` one beyond, at a parameter in [low, high]. If there is none kind is EP; if there is no such last
 * orbit either, `at` is not set and accuracy is NAN. `scratch` is overwritten. */
saltus_status saltus_change_leap(saltus_orbits *orbits, const saltus_solution *from, double ahead,
                                 saltus_leap leap, const char *why, const double range[2],
                                 saltus_solution *at, saltus_solution *here, saltus_solution *scratch,
                                 saltus_change *change, saltus_message *message);
/* The last places where impacts were born, one after the other. */
enum { saltus_births_length = 4 };
typedef struct saltus_births {
    int count;
    double place[saltus_births_length]; /* parameter unknowns, the last one last */
} saltus_births;

/* Another impact is born at a place; or one dies, and the run ends. */
void saltus_births_note(saltus_births *births, bool born, double place);
/* Whether births follow one another in a geometric sequence: where it ends, and how far that is from the last
 * of them. */
bool saltus_births_accumulate(const saltus_births *births, double *limit, double *rest);
/* Impacts are born one after the other, where they accumulate chatter completes: near the parameter `limit`,
 * but for a part of `rest`, which is as far as the last of them. From `from`, an orbit near there, `at`
 * becomes the orbit at which the contact after complete chatter is nothing, `here` one beyond, at a parameter
 * in [low, high]. `far`: `from` may be some way from there, if the place is the one that is expected.
 * `scratch` is overwritten. False: none that begins there was found. */
bool saltus_change_complete(saltus_orbits *orbits, const saltus_solution *from, double limit, double rest,
                            bool far, const double range[2], saltus_solution *at, saltus_solution *here,
                            saltus_solution *scratch, saltus_change *change);
/* The label changes between `from` and `to` though the prescribed events stay: in the part of the sequence
 * that is left to the flow. `at` becomes the last orbit with the contacts of `from`. False if there is none.
 */
bool saltus_change_within(saltus_orbits *orbits, const saltus_solution *from, const saltus_solution *to,
                          saltus_solution *at, saltus_change *change);
/* The sequence of `here`, at which chatter is complete, anew from what the flow does, as `fresh`. Where the
 * chatter completes is told sharper from this side: goes to *value and *accuracy, if so. `scratch` is
 * overwritten. False if it cannot be had: the shooting is as it was. */
bool saltus_change_retrace(saltus_orbits *orbits, const saltus_solution *here, saltus_solution *fresh,
                           saltus_solution *scratch, double *value, double *accuracy);

#endif
