/* Private: sequences of events, made from laps of the event-driven flow and followed by it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_SEQUENCE_H
#define SALTUS_ORBIT_SEQUENCE_H

#include "orbit/lap.h"
#include "orbit/multipliers.h"
#include "orbit/shooting.h"

/* Walk once around an orbit whose states at the cuts of its sequence are `states`. The flow restarts at each
 * cut, so that strong growth does not lead it astray. The lap, which keeps events, gets one section point, at
 * phase 0 and the first whole number of orbits from the base on. `cocycle` (may be NULL) is open and receives
 * the derivative; the flow then has n columns. */
saltus_status saltus_sequence_walk(const saltus_sequence *sequence, saltus_flow *flow, const double *states,
                                   saltus_lap *lap, saltus_cocycle *cocycle, saltus_message *message);
/* Find the turning point of the observed displacement with the largest acceleration, in free flight and away
 * from contact events and stops, on an orbit of `periods` periods through `state` at *time. Both are moved to
 * it. False if there is none: *time is then the middle of the longest stretch between turning points and
 * contacts, if any; or if the flow fails. */
bool saltus_orbit_turning(saltus_flow *flow, int periods, double *time, double *state);
/* Make the sequence of a motion near an orbit through `state` at section phase 0. Its base, to which `state`
 * moves and from which the marks follow, is the middle of the longest free flight. With `free_period` the
 * period is an unknown, and the base, if possible a turning point, becomes its anchor. */
saltus_status saltus_sequence_make(saltus_flow *flow, int periods, bool free_period, double *state,
                                   saltus_lap *lap, saltus_sequence *sequence, saltus_message *message);
/* Whether another impact belongs to the tail of a long run of ever slower impacts on one face (nearly
 * complete chatter), where impacts appear and vanish with the slightest change: the tail is left to the flow.
 * It begins where impacts hardly matter: at the birth of a faster one the orbit turns with infinite slope.
 * `speed` belongs to the first `count` marks. */
bool saltus_sequence_in_tail(const saltus_sequence *sequence, const double *speed, int count, int face,
                             double next_speed);
/* Whether the lap met the sequence's marks, in order and at their times; driven marks allow any events up to
 * the next. */
bool saltus_sequence_follows(const saltus_sequence *sequence, const saltus_lap *lap);

#endif
