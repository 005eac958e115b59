/* Private: the points that a run gives out, in order, each once its kind is known, and the special points
 * that its branches have visited.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_TRAIL_H
#define SALTUS_BRANCH_TRAIL_H

#include "base/memory.h"
#include "branch/archive.h"

#include <math.h>

typedef struct saltus_trail {
    const saltus_branch_options *options;
    char ends[2][2]
             [SALTUS_REASON_MAX]; /* why a branch ends at a border of a parameter's range, 0 the low one */
    int number, parent, depth;    /* of the branch under way */
    int regular;                  /* regular points of it so far */
    int made;                     /* all points of it so far */
    double arclength, shown;      /* present position; that of the last regular point */
    double step;
    bool fresh;          /* no step made since the branch was switched to */
    bool following;      /* the branch has not ended */
    saltus_list visited; /* special points that were given out */
    saltus_list queue;   /* points made but not yet given out, */
    int next;            /* from this one on */
} saltus_trail;

/* What a point says beyond what its solution tells. */
typedef struct saltus_notice {
    saltus_point_kind kind;
    saltus_point_kind origin; /* of a regular point: the kind of the special point that it is, too */
    double ahead, accuracy;
    const char *reason, *addition; /* its two parts; NULL: none */
    const char *after;             /* label beyond; NULL: none */
    const double *value;           /* NULL: the solution's */
    bool change;                   /* a change of events: label and counts are those of the orbit before it */
    bool joins; /* the branch, or curve, begins or ends at orbits of half the period, where a flip has the
                   multiplier 1 */
    const saltus_breach *grazing; /* the touch, which a GR or BE tells; NULL: not known */
} saltus_notice;

/* Free the trail with the points that were not taken. A zeroed one is accepted. */
void saltus_trail_clear(saltus_trail *trail);
/* Discard the points that were not taken yet. */
void saltus_trail_drop(saltus_trail *trail);
/* Begin another branch. */
void saltus_trail_begin(saltus_trail *trail, int number, int parent, int depth, bool fresh);
/* Whether branches that leave the current one are followed too; and what their starts have in common. */
bool saltus_trail_switches(const saltus_trail *trail);
saltus_branch_start saltus_trail_leaving(const saltus_trail *trail);
/* Queue a point, which then belongs to the trail; `points` (may be NULL): the section points of its orbit, of
 * which it tells one. A branch ends with a point of kind EP; it also ends if it comes to a special point that
 * was visited before, and when it has enough points. Without memory *starved is set, here and below, and the
 * branch ends without a point. */
void saltus_trail_give(saltus_trail *trail, const saltus_system *system, saltus_branch_point *fresh,
                       const double *points, const saltus_notice *what, bool *starved);
/* Whether branches of orbits end where they meet a point of this kind that was visited before. */
bool saltus_trail_keeps(saltus_point_kind kind);
/* The place, counted from 1, at which a special point of this kind and period lies on another branch, at an
 * orbit with these section points (`count`, each a state); 0: none. `joined`: only places at which branches
 * join another one on which they were not; *branch (may be NULL) becomes the number of the branch. */
int saltus_trail_find(const saltus_trail *trail, const saltus_system *system, saltus_point_kind kind,
                      double period, double value, const double *points, int count, bool joined, int *branch);
/* The current branch joins another one at such a place, with this section point. Returns the place as above.
 */
int saltus_trail_join(saltus_trail *trail, const saltus_system *system, saltus_point_kind kind, double period,
                      double value, const double *state, bool *starved);
/* Whether orbits may be the same by their periods (0: none). */
static inline bool saltus_trail_same_period(double one, double other) {
    return fabs(one - other) <= 1e-4 * one;
}
/* Whether a point this far ahead is far enough from the last regular one to be given out as one. */
bool saltus_trail_wants(const saltus_trail *trail, double ahead);
/* That point was given out. */
void saltus_trail_shown(saltus_trail *trail, double ahead);
/* The branch goes on this far ahead, beyond a corner, with short steps at first. */
void saltus_trail_jump(saltus_trail *trail, double ahead);
/* The last point in the queue; NULL: it is empty. */
saltus_branch_point *saltus_trail_last(saltus_trail *trail);
/* Remove it. */
void saltus_trail_drop_last(saltus_trail *trail);
/* Take the next point out of the queue; the caller clears it. False: the queue is empty. */
bool saltus_trail_take(saltus_trail *trail, saltus_branch_point *point);
/* The current branch and the special points visited; only when the queue is empty. */
void saltus_trail_archive(saltus_trail *trail, saltus_archive *archive);

#endif
