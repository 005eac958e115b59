/* Private: what a run gives out: the points of the branch under way, in their order, each once it is known
 * what it is, and where its branches have been.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_TRAIL_H
#define SALTUS_BRANCH_TRAIL_H

#include "branch/archive.h"

extern const char saltus_range_ends[]; /* a reason for a branch to end */

typedef struct saltus_trail {
    const saltus_branch_options *options;
    int number, parent, depth; /* of the branch under way */
    int regular;               /* its points but for special ones */
    int made;                  /* all of them */
    double arclength, shown;   /* where it is; where the last regular point was */
    double step;
    bool fresh;     /* no step made since the branch was switched to */
    bool following; /* it has not ended */
    struct saltus_visited *visited;
    int visited_count;
    saltus_branch_point *queue; /* made but not yet given out */
    int count, next, room;
} saltus_trail;

/* What is to be said of a point beside what its solution tells. */
typedef struct saltus_notice {
    saltus_point_kind kind;
    double ahead, accuracy;
    const char *reason, *addition; /* two parts; NULL: nothing */
    const char *after;             /* label beyond; NULL: none */
    double value;                  /* 0: the solution's */
    bool change;                   /* of an orbit's events: label and counts are those of the point before */
    const saltus_breach *grazing;  /* an orbit's touch at grazing; NULL: none is known */
} saltus_notice;

void saltus_trail_clear(saltus_trail *trail);
/* Points that were not given out are not wanted. */
void saltus_trail_drop(saltus_trail *trail);
/* Another branch. */
void saltus_trail_begin(saltus_trail *trail, int number, int parent, int depth, bool fresh);
/* Whether branches that leave the one under way are followed, too, and what they have in common. */
bool saltus_trail_switches(const saltus_trail *trail);
saltus_branch_start saltus_trail_leaving(const saltus_trail *trail);
/* Where the next point is made; NULL without memory. */
saltus_branch_point *saltus_trail_place(saltus_trail *trail, saltus_message *message);
/* The point made there, of a system, is to be given out. A branch ends with its point of kind EP; where it
 * has been at a special point before, and where there are enough points, it ends too. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status saltus_trail_give(saltus_trail *trail, const saltus_system *system, const saltus_notice *what,
                                saltus_message *message);
/* Whether a point so far ahead is to be a regular one: it is far enough from the last. */
bool saltus_trail_wants(const saltus_trail *trail, double ahead);
/* It has been given out. */
void saltus_trail_shown(saltus_trail *trail, double ahead);
/* The branch goes on so far ahead, beyond a corner: steps are short again. */
void saltus_trail_jump(saltus_trail *trail, double ahead);
/* The last point made; NULL: all have been given out. */
saltus_branch_point *saltus_trail_last(saltus_trail *trail);
/* It is taken back. */
void saltus_trail_drop_last(saltus_trail *trail);
/* False: all points made have been given out. The point is the caller's, to be cleared. */
bool saltus_trail_take(saltus_trail *trail, saltus_branch_point *point);
/* With all points given out: the branch under way and the special points that there were. */
void saltus_trail_archive(saltus_trail *trail, saltus_archive *archive);

#endif
