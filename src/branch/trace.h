/* Private: branches of periodic orbits, one after the other.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_TRACE_H
#define SALTUS_BRANCH_TRACE_H

#include "branch/change.h"
#include "branch/options.h"
#include "branch/trail.h"

typedef struct saltus_trace {
    /* For the whole run. */
    saltus_trail *trail;   /* the caller's: points go there, */
    saltus_starts *starts; /* and there branches that leave */
    saltus_orbits orbits;
    double range[2]; /* of the parameter unknown */
    /* Along a branch. */
    double first_value;
    saltus_lap first; /* section points of the orbit that the branch began with */
    saltus_births births;
    int returns;    /* of the last point, to the section of a scene without forcing; -1: not known, ... */
    double counted; /* ... and its value */
    /* Of one step: where the branch is, where the step leads, and room for orbits that are tried. */
    saltus_solution *here, *next, *trial, *spare, *other;
    saltus_solution solutions[5];
    const saltus_solution *found; /* the point of the locus that is asked for; NULL: there was none, */
    saltus_sequence beyond;       /* and at grazing the sequence on the other side */
} saltus_trace;

/* With trail and starts; close in any case. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT. */
saltus_status saltus_trace_open(saltus_trace *trace, const saltus_spec *spec, saltus_message *message);
void saltus_trace_close(saltus_trace *trace);
/* The given state is made an orbit of least period, and its sequence the start of both ways. Errors: those of
 * saltus_orbit_find. */
saltus_status saltus_trace_begin(saltus_trace *trace, int periods, const double *state,
                                 saltus_message *message);
/* A branch begins at a start: its first point is given out, or why there is none. Errors: SALTUS_NO_MEMORY.
 */
saltus_status saltus_trace_start(saltus_trace *trace, const saltus_branch_start *start,
                                 saltus_message *message);
/* One step along the branch under way. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_trace_advance(saltus_trace *trace, saltus_message *message);
/* All that later steps along the branch under way depend on, but for the trail. */
void saltus_trace_archive(saltus_trace *trace, saltus_archive *archive);

/* For begins and steps: a surveyed solution is given out; */
saltus_status saltus_trace_give(saltus_trace *trace, const saltus_solution *solution, saltus_notice what,
                                saltus_message *message);
/* the branch ends with it; */
saltus_status saltus_trace_end(saltus_trace *trace, const saltus_solution *solution, double ahead,
                               const char *reason, saltus_message *message);
/* `next` becomes `here`, and a regular point where it is far enough from the last, or `must` be one. `bends`:
 * both have the same sequence. */
saltus_status saltus_trace_accept(saltus_trace *trace, bool bends, bool must, const char *reason,
                                  saltus_message *message);

static inline void saltus_trace_swap(saltus_solution **a, saltus_solution **b) {
    saltus_solution *kept = *a;
    *a = *b;
    *b = kept;
}

#endif
