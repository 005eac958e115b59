/* Private: long periods, of motions that lock and of those that stick.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_LONG_PERIOD_H
#define SALTUS_MOTION_LONG_PERIOD_H

#include "saltus/motion.h"

/* A stable orbit of up to 1024 periods to which the motion at a state, at phase 0, is locked; its verdict
 * stays SALTUS_PENDING where none is found. The motion is to be cleared. Errors: those of the flow,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_motion_find_locked(const saltus_system *system, const saltus_classify_options *options,
                                        const double *state, saltus_motion *found, saltus_message *message);
/* The same of a motion whose contacts wipe out all differences: the periods from one to the next one that is
 * the same, 0 where this takes longer than ten times options->transient, -1 where no other one comes within
 * these. *rounding: a run with another tolerance returns after another time, and there is no telling which is
 * right. */
saltus_status saltus_motion_find_contact(const saltus_system *system, const saltus_classify_options *options,
                                         const double *state, saltus_motion *found, long long *periods,
                                         bool *rounding, saltus_message *message);
/* Whether a motion that looks chaotic, and of which so many periods have been watched, meets a contact that
 * wipes out all differences: after it everything repeats, however seldom it comes. Trajectories from `count`
 * states, at phase 0, are watched for it, together twenty times as long; where one meets it, `state` (not one
 * of them) is the section point after it of the first that does. *without is for how many periods they have
 * been watched without one; 0 where no contact can do so: then nothing runs. Errors: those of
 * the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_motion_meets_contact(const saltus_system *system, const saltus_flow_options *options,
                                          const double *const *states, int count, long long watched,
                                          double *state, bool *found, long long *without,
                                          saltus_message *message);

#endif
