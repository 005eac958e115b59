/* Private: searching for what a trajectory settles on.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_SEARCH_H
#define SALTUS_MOTION_SEARCH_H

#include "motion/motion.h"
#include "motion/visits.h"

enum { SALTUS_FIRST_BLOCK = 64 }; /* periods before the first look */

/* A search: the trajectory, its section points, and the orbit once one is found. */
typedef struct saltus_search {
    const saltus_system *system;
    const saltus_classify_options *options;
    saltus_flow *flow, *beside; /* the trajectory's flow; a flow for trying orbits meanwhile */
    saltus_settling settling;
    saltus_visits visits; /* without forcing: returns to the section */
    saltus_rest_look beside_rest;
    /* Without forcing: the system whose period is that of the orbit found, and a flow of it. */
    saltus_system *clocked;
    saltus_flow *around;
    saltus_orbit orbit;
    saltus_lap lap; /* around the orbit */
    bool found, stopped;
    long long next_costly; /* number of periods at which a costly orbit may be tried again */
    long long tried;       /* number of returns at the last try of a cycle */
    bool limited;          /* do not try very long orbits of very many impacts */
} saltus_search;

/* Start a search, zeroed but for system, options and `limited`, at a state, with an undecided motion. It is
 * to be closed in any case. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_search_open(saltus_search *search, const double *state, saltus_motion *motion,
                                 saltus_message *message);
void saltus_search_close(saltus_search *search);
/* Continue until the trajectory has come to a rest, noted in motion->verdict, or to an orbit, or until
 * `at_most` periods have passed since the start. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_search_run(saltus_search *search, long long at_most, saltus_motion *motion,
                                saltus_message *message);
/* Without forcing: whether the last returns repeat to rounding, the time between them in units of time. */
bool saltus_search_recurs(saltus_search *search, double *recurrence, double *period);
/* Fill the motion with the orbit or rest found, or give the reason why there is none. */
saltus_status saltus_search_conclude(saltus_search *search, saltus_motion *motion, saltus_message *message);

#endif
