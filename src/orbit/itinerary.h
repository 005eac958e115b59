/* Private: what the event-driven flow does over one orbit, and the sequence of events made from it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_ITINERARY_H
#define SALTUS_ORBIT_ITINERARY_H

#include "orbit/pursuit.h"

typedef struct saltus_itinerary {
    int dimension, periods;
    double *state;        /* at phase 0, at the first whole number of orbits from the start on */
    double *end;          /* at the end of the walk */
    saltus_event *events; /* impacts, sticks, releases in order; times as the flow's */
    int count, room;
    long long impacts; /* -1 with complete chatter */
    int sticking_intervals;
    unsigned contacts; /* lasting contacts at the end */
    char label[32];    /* "4/4", "chatter/2", "held" */
} saltus_itinerary;

saltus_status saltus_itinerary_open(saltus_itinerary *itinerary, int dimension, saltus_message *message);
void saltus_itinerary_close(saltus_itinerary *itinerary);
/* Walk `periods` periods with a flow from a time (in periods) and state. */
saltus_status saltus_itinerary_walk(saltus_itinerary *itinerary, saltus_flow *flow, double start,
                                    const double *state, int periods, saltus_message *message);
/* Walk once around an orbit that is known at the cuts of its sequence: `states` has one state for each. The
 * flow starts anew at each cut, so that strong growth does not lead it astray. */
saltus_status saltus_itinerary_walk_cuts(saltus_itinerary *itinerary, saltus_flow *flow,
                                         const saltus_sequence *sequence, const double *states,
                                         saltus_message *message);
/* The sequence of a motion near an orbit of `periods` periods through `state` at section phase 0: base in the
 * middle of the longest free flight, marks from the walk from there. `state` becomes the one at the base. */
saltus_status saltus_itinerary_sequence(saltus_itinerary *itinerary, saltus_flow *flow, int periods,
                                        double *state, saltus_sequence *sequence, saltus_message *message);
/* Whether one more impact belongs to the tail of a long run of ever slower impacts on one face, chatter that
 * nearly completes, where impacts come and go with the slightest change: it is left to the flow. `speed`
 * belongs to the first `count` marks. */
bool saltus_sequence_in_tail(const saltus_sequence *sequence, const double *speed, int count, int face,
                             double next_speed);
/* Whether the walk met the sequence's marks, in order and at their times; between a driven mark and the next
 * anything may happen. */
bool saltus_itinerary_follows(const saltus_itinerary *itinerary, const saltus_sequence *sequence);

#endif
