/* Private: returns of a motion without forcing to its section, and orbits counted by them.
 *
 * The section is chosen by the scene (saltus_poincare). By default it is a maximum of the observed
 * displacement: a reversal of its velocity from rising to falling, smooth or by an impact. A lasting contact,
 * or complete chatter with all the impacts in a row before it, is one return, of impacts on a stop too:
 * infinitely many are no places to count by. Where the impacts are minima, it is none, and neither are the
 * maxima between them. An expression may pass through zero smoothly, or by the jump of an impact.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_POINCARE_H
#define SALTUS_ORBIT_POINCARE_H

#include "orbit/lap.h"

/* Zeros of an expression that one step can have. */
enum { SALTUS_ZEROS_MAX = 16 };

/* Returns along a motion; zeroed at its begin. */
typedef struct saltus_crossings {
    int face;                      /* of the impacts in a row ... */
    bool struck;                   /* ... that are under way: they reverse the observed velocity, ... */
    bool rises;                    /* ... the last of them to rising, as nothing has since */
    double speed, rebound;         /* of that one, before and after */
    int spare;                     /* returns among them, and between, that are none if chatter completes */
    int lively;                    /* so many of them are no slower than the one before, but for ... */
    unsigned chatters;             /* faces on which chatter has completed, without many such since */
    bool waits;                    /* the last return may be one of such a chatter */
    bool begun;                    /* of an expression: its sign is known, ... */
    bool below;                    /* ... it was negative at the end of the last step */
    int change;                    /* of the number of returns by the last event, still to be told */
    double zero[SALTUS_ZEROS_MAX]; /* times of the returns within the last step, since its begin, still to be
                                      told: `zeros` of them */
    int zeros, told;
    saltus_time time;
} saltus_crossings;

/* Events to be watched for returns. */
unsigned saltus_crossings_watch(const saltus_system *system);
/* Take an event of a lane, a target reached included, after which it is at `state`. */
void saltus_crossings_take(saltus_crossings *returns, const saltus_flow *flow, int lane,
                           const saltus_event *event, const double *state);
/* The next return that the event taken last tells of and that is counted at once: its state replaces that of
 * now, and its time is given. None is amid the impacts in a row on a face on which chatter has completed
 * before. `state` is as above. False: there is none any more. */
bool saltus_crossings_count(saltus_crossings *returns, const saltus_flow *flow, int lane, double *state,
                            saltus_time *time);

/* On from an orbit's state, which may be a return, to the middle between it and the next event or return,
 * where a lap meets each once; it is *later by so many periods. The flow has no columns. Errors: those of the
 * flow.
 */
saltus_status saltus_cycle_leave(saltus_flow *flow, double *state, double *later, saltus_message *message);

/* Once around an orbit of a scene without forcing, for the flow's one period from a state on it: lap->periods
 * is the number of returns, and the section points are the states there, from the highest on (of impacts, the
 * fastest), which the events' times are counted from. Where there is no return it is 1, and the section point
 * is the state given. The flow has no columns. Errors: those of the flow, SALTUS_NO_MEMORY. */
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
