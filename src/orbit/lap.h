/* Private: once around an orbit.
 *
 * A lap summarises a motion between two times: numbers of contact events, extremes of the observed
 * displacement and, on request, the events themselves and the section points. It is filled event by event,
 * from a flow of one or many lanes. Its answers about an orbit (chatter, label, least period) concern the
 * cyclic sequence of events and do not depend on where the lap begins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_LAP_H
#define SALTUS_ORBIT_LAP_H

#include "saltus/orbit.h"

/* Section points of the same orbit, settled or found by Newton's method, agree within this distance, relative
 * to the system's scales; those of distinct orbits do not. */
#define SALTUS_SAME_POINT 1e-6

typedef struct saltus_lap {
    const saltus_system *system;
    int periods;       /* of the orbit; set by saltus_lap_around */
    int returns;       /* returns of a cycle to its section: its periods, or 0; set by saltus_lap_cycle */
    double first;      /* periods from the given state to the first section point; set by saltus_lap_cycle */
    bool keeps_events; /* fill `events`, ... */
    bool keeps_turnings; /* ... turning points included */
    long long impacts;   /* those located one by one */
    long long impacts_by_face[SALTUS_FACES_MAX];
    long long contact_events; /* impacts, sticks and releases */
    int sticks, releases;
    bool rebounding_contact;  /* a face with r > 0 has a lasting contact */
    double largest, smallest; /* of the observed displacement, at the start and at events */
    double square, watched; /* integral of its square over this time, in units of T; set by saltus_lap_run */
    unsigned contacts;      /* lasting contacts at the end; set by saltus_lap_run */
    saltus_event *events;   /* [event_count], in order; the flow's times */
    int event_count, event_room;
    double *points; /* [periods][dimension]: section points at the start and after each period but the last */
    double *end;    /* state at the end */
    int point_room;
} saltus_lap;

/* Make room for `periods` section points of n numbers and the end state. False if there is no memory. */
bool saltus_lap_reserve(saltus_lap *lap, int periods, int n);
/* Begin a lap at a state, with all counts zero. Keeps the memory of an earlier lap. */
void saltus_lap_begin(saltus_lap *lap, const saltus_system *system, const double *state);
/* Add an event, after which the flow is at `state`. False if there is no memory. */
bool saltus_lap_add(saltus_lap *lap, const saltus_event *event, const double *state);
/* Advance lane 0 of a started flow to a time, adding contact events and, if `turnings`, turning points of the
 * observed displacement. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_lap_run(saltus_lap *lap, saltus_flow *flow, saltus_time until, bool turnings,
                             saltus_message *message);
/* Carry a state from one time to another, by lane 0 of a flow. On errors, those of the flow, it is
 * unchanged. */
saltus_status saltus_state_carry(saltus_flow *flow, saltus_time from, saltus_time until, double *state,
                                 saltus_message *message);
/* Once around an orbit of `periods` periods, or along a trajectory for as long, from a state at section phase
 * 0. The flow has no columns. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_lap_around(saltus_lap *lap, saltus_flow *flow, const double *state, int periods,
                                saltus_message *message);
/* Free the memory; accepts a zeroed lap. */
void saltus_lap_close(saltus_lap *lap);

/* Whether an event is an impact, or a stick, with a nonzero velocity before it. */
bool saltus_event_strikes(const saltus_event *event);
/* The observed displacement at a contact event or a turning point, after which the flow is at `state`. */
double saltus_event_displacement(const saltus_system *system, const saltus_event *event, const double *state);

/* Root mean square of the observed displacement; NAN if turning points were not watched. */
double saltus_lap_rms(const saltus_lap *lap);
/* Impacts per orbit; -1 for infinitely many (complete chatter). */
long long saltus_lap_impacts(const saltus_lap *lap);
/* Sticking intervals per orbit: their beginnings or their ends, whichever are more. A lap may begin within an
 * interval, or so close to one that it sees only the end. */
int saltus_lap_sticking(const saltus_lap *lap);
/* Whether the orbit is in contact at all times. */
bool saltus_lap_held(const saltus_lap *lap);
/* "n/p", "chatter/p" or "held". */
void saltus_lap_label(const saltus_lap *lap, char label[SALTUS_LABEL_MAX]);

/* The least divisor of the lap's periods after which the orbit closes. */
int saltus_lap_least_period(const saltus_lap *lap, const saltus_flow_options *flow);
/* The section point of a state at section phase 0. Rounding decides on which side of impacts in the very
 * section the flow ends: a point lies after them. `after`, which may be `state`, is the state moved past the
 * impacts that it is within `reach` of, relative to the system's scales. Returns their number; `passed`
 * (SALTUS_FACES_MAX, or NULL) receives them, with times from the state on. */
int saltus_section_point(const saltus_system *system, const double *state, double reach, double *after,
                         saltus_event *passed);
/* The reach for points of an orbit that is found with a flow of this tolerance. */
double saltus_section_reach(double rtol);
/* Whether an orbit with these section points passes through a state at section phase 0. */
bool saltus_orbit_passes(const saltus_system *system, const double *points, int periods, const double *state,
                         double distance);
/* Mirror image of the state that a state at section phase 0 reaches after the time `later`; `image` may be
 * `state`. The scene must have the symmetry. Errors: those of the flow. */
saltus_status saltus_mirror_image(saltus_flow *flow, const double *state, saltus_time later, double *image,
                                  saltus_message *message);

#endif
