/* Private: returns of an unforced trajectory to its section, and how they recur.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_VISITS_H
#define SALTUS_MOTION_VISITS_H

#include "motion/settle.h"
#include "orbit/poincare.h"

typedef struct saltus_visits {
    saltus_settling settling; /* how the section points recur */
    saltus_crossings returns; /* takes the events */
    double *times;            /* times of the points kept by `settling`, in the system's periods */
} saltus_visits;

/* As saltus_settling_open. False without memory. */
bool saltus_visits_open(saltus_visits *visits, int dimension, int longest);
void saltus_visits_close(saltus_visits *visits);
/* Start with no return. */
void saltus_visits_reset(saltus_visits *visits, const saltus_system *system);
/* Read the next return that the last event has brought into `state`, which at first holds the lane's state;
 * `done` are the trajectory's counters. False if there is none left. No return is counted while chatter may
 * be in progress. */
bool saltus_visits_next(saltus_visits *visits, const saltus_flow *flow, int lane, saltus_flow_info done,
                        double *state);
/* Time of the last return, in the system's periods. */
double saltus_visits_last(const saltus_visits *visits);
/* Duration of the last `returns` returns, in the system's periods. */
double saltus_visits_taken(const saltus_visits *visits, int returns);
/* A system whose period is the mean time between the last returns, to be freed by the caller; NULL if there
 * are too few returns. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_visits_count(const saltus_visits *visits, const saltus_system *system,
                                  saltus_system **counted, saltus_message *message);

#endif
