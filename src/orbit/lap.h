/* Private: once around an orbit.
 *
 * A lap is what happens on a motion between two times: its contact events counted, how far the observed
 * displacement goes, and, where they are asked for, the events themselves and the section points. It is
 * filled event by event, from a flow of one lane or of many. What it says of an orbit (chatter, label, least
 * period) belongs to the cyclic sequence of events, wherever the lap begins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_LAP_H
#define SALTUS_ORBIT_LAP_H

#include "saltus/orbit.h"

/* Section points of the same orbit, settled or found by Newton's method, agree to this, relative to the
 * system's scales; those of distinct orbits do not. */
#define SALTUS_SAME_POINT 1e-6

typedef struct saltus_lap {
    const saltus_system *system;
    int periods;         /* of the orbit; set by saltus_lap_around */
    int returns;         /* of a cycle to its section: its periods, or none; set by saltus_lap_cycle */
    bool keeps_events;   /* `events` is filled too, ... */
    bool keeps_turnings; /* ... with the turning points among them */
    long long impacts;   /* located one by one */
    long long impacts_by_face[SALTUS_FACES_MAX];
    long long contact_events; /* impacts, sticks and releases */
    int sticks, releases;
    bool rebounding_contact;  /* a face with r > 0 holds for a while */
    double largest, smallest; /* observed displacement, at the start and at each event */
    double square, watched;   /* its square's integral over this time, in units of T; set by saltus_lap_run */
    unsigned contacts;        /* lasting ones at the end; set by saltus_lap_run */
    saltus_event *events;     /* event_count of them in order; times as the flow's */
    int event_count, event_room;
    double *points; /* section points, at the start and after each period but the last; periods x dimension */
    double *end;    /* state at the end */
    int point_room;
} saltus_lap;

/* Room for so many section points of n numbers, and the end. False without memory. */
bool saltus_lap_reserve(saltus_lap *lap, int periods, int n);
/* Begin a lap at a state, with nothing counted. Memory of an earlier lap is kept. */
void saltus_lap_begin(saltus_lap *lap, const saltus_system *system, const double *state);
/* One more event, after which the flow is at `state`. False without memory. */
bool saltus_lap_add(saltus_lap *lap, const saltus_event *event, const double *state);
/* Run on to a time with lane 0 of a flow that has been started, adding what it meets: contact events, and
 * turning points of the observed displacement if `turnings`. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_lap_run(saltus_lap *lap, saltus_flow *flow, saltus_time until, bool turnings,
                             saltus_message *message);
/* A state at one time becomes the one at another, by lane 0 of a flow. Errors: those of the flow; the state
 * is then as it was. */
saltus_status saltus_state_carry(saltus_flow *flow, saltus_time from, saltus_time until, double *state,
                                 saltus_message *message);
/* Once around an orbit of so many periods, or along a trajectory for as many, from a state at section phase
 * 0. The flow has no columns. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_lap_around(saltus_lap *lap, saltus_flow *flow, const double *state, int periods,
                                saltus_message *message);
/* Free the memory; a zeroed lap is accepted. */
void saltus_lap_close(saltus_lap *lap);

/* Whether an event reverses the normal velocity: an impact, or a stick with which a chatter ends. */
bool saltus_event_strikes(const saltus_event *event);
/* The observed displacement at a contact event or a turning point, after which the flow is at `state`. */
double saltus_event_displacement(const saltus_system *system, const saltus_event *event, const double *state);

/* Root mean square of the observed displacement; NAN where turning points were not watched. */
double saltus_lap_rms(const saltus_lap *lap);
/* Impacts per orbit; -1 where complete chatter makes them infinitely many. */
long long saltus_lap_impacts(const saltus_lap *lap);
/* Sticking intervals per orbit, by their beginnings or their ends, whichever are more: a lap may begin within
 * one, or so near to one that only its end is seen. */
int saltus_lap_sticking(const saltus_lap *lap);
/* Whether the orbit is in contact all the time. */
bool saltus_lap_held(const saltus_lap *lap);
/* "n/p", "chatter/p" or "held". */
void saltus_lap_label(const saltus_lap *lap, char label[SALTUS_LABEL_MAX]);

/* The least divisor of the lap's periods after which its orbit already closes. */
int saltus_lap_least_period(const saltus_lap *lap, const saltus_flow_options *flow);
/* Whether an orbit passes through a state at section phase 0. */
bool saltus_orbit_passes(const saltus_system *system, const double *points, int periods, const double *state,
                         double distance);
/* The mirror image of a state at section phase 0 after `later` of the flow; `image` may be `state`. The scene
 * has that symmetry. Errors: those of the flow. */
saltus_status saltus_mirror_image(saltus_flow *flow, const double *state, saltus_time later, double *image,
                                  saltus_message *message);

#endif
