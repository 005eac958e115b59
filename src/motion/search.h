/* Private: searching for what a trajectory settles on.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_SEARCH_H
#define SALTUS_MOTION_SEARCH_H

#include "motion/motion.h"
#include "motion/visits.h"

enum { SALTUS_FIRST_BLOCK = 64 }; /* periods before the first look */

/* A search under way: the trajectory, its section points, and the orbit once one is found. */
typedef struct saltus_search {
    const saltus_system *system;
    const saltus_classify_options *options;
    saltus_flow *flow, *beside; /* the trajectory's; for what is tried meanwhile */
    saltus_settling settling;
    saltus_visits visits; /* without forcing */
    saltus_rest_look beside_rest;
    /* Without forcing: the system that counts by the period of the orbit found, and a flow of it. */
    saltus_system *clocked;
    saltus_flow *around;
    saltus_orbit orbit;
    saltus_lap lap; /* around the orbit */
    bool found, stopped;
    long long next_costly; /* periods before a costly orbit is tried again */
    bool limited;          /* no very long orbits of very many impacts */
} saltus_search;

/* A zeroed search, given its system and options, begins at a state, with an undecided motion. Close in any
 * case. */
saltus_status saltus_search_open(saltus_search *search, const double *state, saltus_motion *motion,
                                 saltus_message *message);
void saltus_search_close(saltus_search *search);
/* Go on until the trajectory has come to a rest, which goes to motion->verdict, or to an orbit, or so many
 * periods have passed. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_search_run(saltus_search *search, long long at_most, saltus_motion *motion,
                                saltus_message *message);
/* Fill the motion with what has been found, or say that nothing was. */
saltus_status saltus_search_conclude(saltus_search *search, saltus_motion *motion, saltus_message *message);

#endif
