/* Private: returns of a trajectory without forcing to its section, and how they recur.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_VISITS_H
#define SALTUS_MOTION_VISITS_H

#include "motion/settle.h"
#include "orbit/poincare.h"

typedef struct saltus_visits {
    saltus_settling settling; /* of the section points */
    saltus_crossings returns;
    saltus_flow_info done;
    double *times; /* when these came, in the system's periods, as many as points are kept */
} saltus_visits;

/* As saltus_settling_open. False without memory. */
bool saltus_visits_open(saltus_visits *visits, int dimension, int longest);
void saltus_visits_close(saltus_visits *visits);
/* No return has been seen yet. */
void saltus_visits_reset(saltus_visits *visits, const saltus_system *system);
/* An event of a lane, a target reached included, after which it is at `state`; until then so much has been
 * done. */
void saltus_visits_take(saltus_visits *visits, const saltus_flow *flow, int lane, const saltus_event *event,
                        const double *state, saltus_flow_info done);
/* The next return that the event taken last tells of, in the place of `state`, which is as above; false:
 * there is none any more. None is counted where chatter may be under way. */
bool saltus_visits_next(saltus_visits *visits, const saltus_flow *flow, int lane, double *state);
/* When the last return came, in the system's periods. */
double saltus_visits_last(const saltus_visits *visits);
/* Time that the last so many returns have taken, in the system's periods. */
double saltus_visits_taken(const saltus_visits *visits, int returns);
/* A system that counts by the mean time between the last returns, the caller's; NULL where there are few
 * returns. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_visits_count(const saltus_visits *visits, const saltus_system *system,
                                  saltus_system **counted, saltus_message *message);

#endif
