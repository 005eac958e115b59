/* Private: branches of periodic orbits, one after the other. Lack of memory along a branch is noted in the
 * orbits; what is found then counts for nothing, as the run ends with the step.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_TRACE_H
#define SALTUS_BRANCH_TRACE_H

#include "branch/change.h"
#include "branch/locus_starts.h"
#include "branch/options.h"
#include "branch/trail.h"

typedef struct saltus_trace {
    /* For the whole run. */
    saltus_trail *trail;   /* the caller's: receives the points */
    saltus_starts *starts; /* the caller's: receives branches that leave, */
    saltus_starts *found;  /* and where the requested locus begins */
    saltus_orbits orbits;
    double range[2]; /* of the parameter unknown */
    /* Along a branch. */
    double first_value;
    saltus_lap first; /* section points of the first orbit of the branch */
    saltus_births births;
    int returns;    /* of the last point to the section (scenes without forcing); -1: not known */
    double counted; /* parameter value of that point */
    /* One step: its start and end, and room for orbits that are tried. */
    saltus_solution *here, *next, *trial, *spare, *other;
    saltus_solution solutions[5];
} saltus_trace;

/* `trail`, `starts` and `found` must be set. Close in any case. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT.
 */
saltus_status saltus_trace_open(saltus_trace *trace, const saltus_spec *spec, saltus_message *message);
void saltus_trace_close(saltus_trace *trace);
/* Find the orbit of least period near the state; both directions from it are added to the starts. Errors:
 * those of saltus_orbit_find. */
saltus_status saltus_trace_begin(saltus_trace *trace, int periods, const double *state,
                                 saltus_message *message);
/* Begin a branch at a start: give out its first point, or a point that says why there is none. Errors: those
 * of the equations, at the first start. */
saltus_status saltus_trace_start(saltus_trace *trace, const saltus_branch_start *start,
                                 saltus_message *message);
/* One step along the branch under way. Errors: those of the flow. */
saltus_status saltus_trace_advance(saltus_trace *trace, saltus_message *message);
/* Everything, except the trail, that later steps along the current branch depend on. */
void saltus_trace_archive(saltus_trace *trace, saltus_archive *archive);

/* For trace_begin.c and trace_step.c. Give out a surveyed solution; */
void saltus_trace_give(saltus_trace *trace, const saltus_solution *solution, saltus_notice what);
/* give it out as the end of the branch; */
void saltus_trace_end(saltus_trace *trace, const saltus_solution *solution, double ahead, const char *reason);
/* make `next` the new `here`, giving it out as a regular point if it is far enough from the last one or there
 * is a reason to. `bends`: both have the same sequence, so that the curve's bend is known. */
void saltus_trace_accept(saltus_trace *trace, bool bends, const char *reason);
/* From an orbit that grazes, `here`, to one a little beyond, `next`: give out the special points in between,
 * and that one. */
void saltus_trace_leave_grazing(saltus_trace *trace);

/* In trace_join.c. Whether a solution is the orbit with these section points. */
bool saltus_trace_same_orbit(saltus_trace *trace, const saltus_solution *solution, const saltus_lap *lap);
/* Whether at grazing an impact has lost its speed just as the orbit touches the stop on the other side half a
 * period later: the branch has come to orbits that are their own mirror images where these graze. */
bool saltus_trace_joins_images(saltus_trace *trace, const saltus_solution *at);
/* The number of equal parts of a grazing orbit which has become one of only such a part of the period, where
 * these graze; 1: it has not. */
int saltus_trace_parts(saltus_trace *trace, const saltus_solution *at);
/* The touch by which a grazing orbit is known. Where it consists of `parts`, or of its half and that one's
 * mirror image (2), it grazes in each, and rounding decides which is worst: then it is the first from the
 * section on. */
const saltus_breach *saltus_trace_touch(const saltus_solution *at, int parts);
/* The branch has ended at the last point: drop the starts there, since they lead back along this branch. */
void saltus_trace_drop_starts(saltus_trace *trace);
/* Add both ways along the branch that the present one joins at a flip or branch point, or at the grazing of
 * orbits of one of `parts` of the period or (1) that are their own mirror images, unless branches are not
 * switched to or the place was visited on that branch. */
void saltus_trace_follow_joined(saltus_trace *trace, const saltus_solution *at, saltus_point_kind kind,
                                double value);
void saltus_trace_follow_grazing(saltus_trace *trace, const saltus_solution *at, int parts);
/* Whether the orbit `beyond` where chatter completes, `at`, is one of only a part of the period, with the
 * label `after`. Both ways along their branch are added as above. */
bool saltus_trace_joins_part(saltus_trace *trace, const saltus_solution *at, const saltus_solution *beyond,
                             double value, char after[SALTUS_LABEL_MAX]);
/* Whether at a special point of the present branch another one joined it earlier, whose starts on this one,
 * if they are left, are dropped. *other: the number of that branch if it has led on along this one, so that
 * this is where the present one has to end; otherwise -1. */
bool saltus_trace_was_joined(saltus_trace *trace, const saltus_solution *solution, saltus_point_kind kind,
                             double value, int *other);

#endif
