/* Private: branches of periodic orbits, one after the other.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_TRACE_H
#define SALTUS_BRANCH_TRACE_H

#include "branch/change.h"
#include "branch/options.h"
#include "branch/trail.h"

typedef struct saltus_trace {
    /* For the whole run. */
    saltus_trail *trail;   /* the caller's: receives the points */
    saltus_starts *starts; /* the caller's: receives branches that leave */
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
    const saltus_solution *found; /* first point of the requested locus; NULL: none yet */
    saltus_sequence beyond;       /* at grazing: the sequence on the other side */
} saltus_trace;

/* `trail` and `starts` must be set. Close in any case. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT. */
saltus_status saltus_trace_open(saltus_trace *trace, const saltus_spec *spec, saltus_message *message);
void saltus_trace_close(saltus_trace *trace);
/* Find the orbit of least period near the state; both directions from it are added to the starts. Errors:
 * those of saltus_orbit_find. */
saltus_status saltus_trace_begin(saltus_trace *trace, int periods, const double *state,
                                 saltus_message *message);
/* Begin a branch at a start: give out its first point, or a point that says why there is none. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status saltus_trace_start(saltus_trace *trace, const saltus_branch_start *start,
                                 saltus_message *message);
/* One step along the branch under way. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_trace_advance(saltus_trace *trace, saltus_message *message);
/* Everything, except the trail, that later steps along the current branch depend on. */
void saltus_trace_archive(saltus_trace *trace, saltus_archive *archive);

/* For trace_begin.c and trace_step.c. Give out a surveyed solution; */
saltus_status saltus_trace_give(saltus_trace *trace, const saltus_solution *solution, saltus_notice what,
                                saltus_message *message);
/* give it out as the end of the branch; */
saltus_status saltus_trace_end(saltus_trace *trace, const saltus_solution *solution, double ahead,
                               const char *reason, saltus_message *message);
/* make `next` the new `here`, giving it out as a regular point if it is far enough from the last one or
 * `must` be. `bends`: both have the same sequence, so that the curve's bend is known. */
saltus_status saltus_trace_accept(saltus_trace *trace, bool bends, bool must, const char *reason,
                                  saltus_message *message);

static inline void saltus_trace_swap(saltus_solution **a, saltus_solution **b) {
    saltus_solution *kept = *a;
    *a = *b;
    *b = kept;
}

#endif
