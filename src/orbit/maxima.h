/* Private: the section of scenes without forcing, the maxima of the observed displacement, and orbits by it.
 *
 * A maximum is a reversal of the observed velocity from rising to falling, smooth or by an impact. A lasting
 * contact, or complete chatter with all the impacts before it, is one maximum: infinitely many reversals are
 * no places to count by.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_MAXIMA_H
#define SALTUS_ORBIT_MAXIMA_H

#include "orbit/lap.h"

/* Events to be watched for maxima. */
#define SALTUS_WATCH_MAXIMA (SALTUS_WATCH_IMPACT | SALTUS_WATCH_STICK | SALTUS_WATCH_TURNING)

/* Maxima along a motion; zeroed at its begin. */
typedef struct saltus_maxima {
    int run;      /* impacts in a row on one face that were maxima */
    int face;     /* of the last of them */
    double speed; /* of it */
    bool falling; /* it was slower than the one before: the run may be chatter */
} saltus_maxima;

/* By how much an event, after which the flow is at `state`, changes the number of maxima: 1 for a maximum,
 * negative where chatter completes, whose impacts but the first are taken back; otherwise 0. */
int saltus_maxima_count(saltus_maxima *maxima, const saltus_system *system, const saltus_event *event,
                        const double *state);

/* Once around an orbit of a scene without forcing, for the flow's one period from a state away from events:
 * lap->periods is the number of maxima, 1 where there is none, and the section points are the states there,
 * from the highest on, which the events' times are counted from. The flow has no columns. Errors: those of
 * the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_lap_cycle(saltus_lap *lap, saltus_flow *flow, const double *state,
                               saltus_message *message);

/* The orbit of unknown period that Newton's method finds from a state that closes after about the system's
 * period, reduced to its least one; the system that counts by the orbit's period (the caller's) and the lap
 * around it. `orbit->state` is away from events. On failure all are empty. Errors: those of
 * saltus_orbit_find, SALTUS_NO_CONVERGENCE where it ends in a rest, those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_cycle_polish(const saltus_system *system, const double *guess,
                                  const saltus_orbit_options *options, saltus_orbit *orbit,
                                  saltus_system **clocked, saltus_lap *lap, saltus_message *message);

#endif
