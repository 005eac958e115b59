/* Private: returns of a motion without forcing to its section, and orbits counted by them.
 *
 * The scene chooses the section (saltus_poincare). By default it is a maximum of the observed displacement:
 * its velocity reverses from rising to falling, smoothly or by an impact. A lasting contact, or complete
 * chatter with all its impacts, counts as one return, also on a section of impacts: infinitely many impacts
 * cannot be counted. If the impacts are minima it counts as none, and so do the maxima between them. An
 * expression may pass through zero smoothly or by the jump of an impact.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_POINCARE_H
#define SALTUS_ORBIT_POINCARE_H

#include "orbit/lap.h"

/* Most zeros of an expression in one step. */
enum { SALTUS_ZEROS_MAX = 256 };

/* State of the count along a motion; zeroed at its beginning. */
typedef struct saltus_crossings {
    int face;                      /* face of a run of impacts ... */
    bool struck;                   /* ... that is in progress: they reverse the observed velocity, ... */
    bool rises;                    /* ... the last one to rising, with no reversal since */
    double speed, rebound;         /* of the last one, before and after */
    int spare;                     /* returns in and between them that do not count if chatter completes */
    int lively;                    /* number of them that are not slower than the previous one (is_slower) */
    unsigned chatters;             /* faces on which chatter has completed, with few lively impacts since */
    bool waits;                    /* the last return may belong to such a chatter */
    bool begun;                    /* expression: its sign is known, ... */
    bool below;                    /* ... it was negative at the end of the last step */
    int change;                    /* of the number of returns by the last event, not reported yet */
    double zero[SALTUS_ZEROS_MAX]; /* the last step's returns, by the time since its beginning: `zeros` of
                                      them, of which `told` have been reported */
    int zeros, told;
    saltus_time time;
} saltus_crossings;

/* The events to be watched for returns. */
unsigned saltus_crossings_watch(const saltus_system *system);
/* Process an event of a lane, also a reached target, after which the lane is at `state`. */
void saltus_crossings_take(saltus_crossings *returns, const saltus_flow *flow, int lane,
                           const saltus_event *event, const double *state);
/* The next return of the event processed last, with its state (`state` is that after the event) and time.
 * Omits returns in a run of impacts on a face on which chatter has completed before. False: no more. */
bool saltus_crossings_count(saltus_crossings *returns, const saltus_flow *flow, int lane, double *state,
                            saltus_time *time);

/* Move from an orbit's state, which may be a return, to the middle between it and the next event or return,
 * so that a lap meets each once; *later: by how many periods. The flow has no columns. Errors: the flow's. */
saltus_status saltus_cycle_leave(saltus_flow *flow, double *state, double *later, saltus_message *message);

/* States on an orbit from which to go on around it, where errors grow so much that the flow from one state
 * would leave it: `count` of them, at these times in periods from the first state, ascending, below 1. */
typedef struct saltus_pieces {
    int count;
    const double *time, *state;
} saltus_pieces;

/* Once around an orbit of a scene without forcing, for one period of the flow from a state on it, or in
 * `pieces` (may be NULL).
 * lap->periods is the number of returns; the section points are the states there, beginning with the highest
 * (of impacts, the fastest), from which the events' times are counted. Without a return it is 1, and the
 * section point is the given state. The flow has no columns. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_lap_cycle(saltus_lap *lap, saltus_flow *flow, const double *state,
                               const saltus_pieces *pieces, saltus_message *message);

/* Find an orbit of unknown period from a state that closes after about the system's period, and reduce it to
 * its least period. *clocked, to be freed by the caller, is the system that counts time by the orbit's
 * period, `lap` the lap around it; orbit->state is away from events. On failure all are empty. Errors: those
 * of saltus_orbit_find, SALTUS_NO_CONVERGENCE if it ends in a rest, those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_cycle_polish(const saltus_system *system, const double *guess,
                                  const saltus_orbit_options *options, saltus_orbit *orbit,
                                  saltus_system **clocked, saltus_lap *lap, saltus_message *message);

#endif
