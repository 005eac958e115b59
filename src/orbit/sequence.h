/* Private: sequences of events, made from laps of the event-driven flow and followed by it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_SEQUENCE_H
#define SALTUS_ORBIT_SEQUENCE_H

#include "orbit/lap.h"
#include "orbit/multipliers.h"
#include "orbit/shooting.h"

/* Walk once around an orbit that is known at the cuts of its sequence: `states` has one state for each. The
 * flow starts anew at each cut, so that strong growth does not lead it astray. The lap, which keeps events,
 * has one section point: at phase 0, at the first whole number of orbits from the base on. With a cocycle,
 * which has been opened, and a flow with n columns, the derivative is kept too; otherwise NULL. */
saltus_status saltus_sequence_walk(const saltus_sequence *sequence, saltus_flow *flow, const double *states,
                                   saltus_lap *lap, saltus_cocycle *cocycle, saltus_message *message);
/* The turning point of the observed displacement with the largest acceleration, in free flight and away from
 * contact events and stops, on an orbit of so many periods through `state` at a time; *time is it, from that
 * time on, and `state` becomes the one there. False where there is none, *time being amid the longest stretch
 * between turning points and contacts, if any, or where the flow fails. */
bool saltus_orbit_turning(saltus_flow *flow, int periods, double *time, double *state);
/* The sequence of a motion near an orbit of `periods` periods through `state` at section phase 0: base in the
 * middle of the longest free flight, or at a turning point where the period is free; marks from there.
 * `state` becomes the one at the base. `free_period`: the orbit's period is its own, an unknown, and the base
 * is its anchor. */
saltus_status saltus_sequence_make(saltus_flow *flow, int periods, bool free_period, double *state,
                                   saltus_lap *lap, saltus_sequence *sequence, saltus_message *message);
/* Whether one more impact belongs to the tail of a long run of ever slower impacts on one face, chatter that
 * nearly completes, where impacts come and go with the slightest change: it is left to the flow. `speed`
 * belongs to the first `count` marks. */
bool saltus_sequence_in_tail(const saltus_sequence *sequence, const double *speed, int count, int face,
                             double next_speed);
/* Whether the lap met the sequence's marks, in order and at their times; between a driven mark and the next
 * anything may happen. */
bool saltus_sequence_follows(const saltus_sequence *sequence, const saltus_lap *lap);

#endif
