/* Private: what the parts of this room share.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_PRIVATE_H
#define SALTUS_MOTION_PRIVATE_H

#include "base/field.h"
#include "base/progress.h"
#include "motion/evidence.h"
#include "orbit/lap.h"
#include "saltus/equilibrium.h"
#include "system/state.h"

/* motion.c, classify.c, irregular.c, describe.c, search.c */

/* Options of Newton's method that suit those of a classification. */
saltus_orbit_options saltus_motion_shooting(const saltus_classify_options *options);

/* saltus_classify; *stopped: the caller has ended it. */
saltus_status saltus_motion_classify(const saltus_system *system, const double *state,
                                     const saltus_classify_options *options, saltus_motion *motion,
                                     bool *stopped, saltus_message *message);
/* Judge a motion that has not settled: fills verdict, reason, exponent and evidence, and moves motion->state
 * on along the attractor. The verdict stays SALTUS_UNDECIDED where more time may bring a period; the outcome
 * tells whether it should. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_motion_judge(const saltus_system *system, const saltus_classify_options *options,
                                  saltus_motion *motion, saltus_outcome *outcome, saltus_message *message);
/* Nothing has been measured: numbers are NAN. */
void saltus_motion_forget_evidence(saltus_motion *motion);
/* Label a motion without a period, and measure its extremes from its state on. Errors: those of the flow. */
saltus_status saltus_motion_survey(const saltus_system *system, saltus_flow *flow, saltus_motion *motion,
                                   saltus_message *message);
/* Settle and find a period, as saltus_classify does, without judging a motion that has none; `limited`: no
 * very long orbits of very many impacts. */
saltus_status saltus_motion_find_period(const saltus_system *system, const double *state,
                                        const saltus_classify_options *options, bool limited,
                                        saltus_motion *motion, saltus_message *message);

/* An undecided motion with room for a state; false if there is no memory. */
bool saltus_motion_open(const saltus_system *system, const saltus_flow_options *flow, saltus_motion *motion);
/* Fill an open motion with what is said of a periodic orbit; the lap around it becomes the motion's. `flow`,
 * without columns, is that of the lap. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_motion_take(const saltus_system *system, saltus_flow *flow, const saltus_orbit *orbit,
                                 saltus_lap *lap, saltus_motion *motion, saltus_message *message);
/* The stable orbit that Newton's method finds from a state which closes after about `periods`, described; its
 * verdict stays SALTUS_PENDING where there is none within `near`, relative to the system's scales. The motion
 * is to be cleared. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_motion_polish(const saltus_system *system, int periods, const double *state, double near,
                                   const saltus_classify_options *options, saltus_motion *motion,
                                   saltus_message *message);
/* Fill an open motion that has no orbit, whose verdict is known, from the flow's present state. */
saltus_status saltus_motion_rest(const saltus_system *system, saltus_flow *flow, saltus_motion *motion,
                                 saltus_message *message);

/* verdict.c: whether two motions are the same attractor. */
extern const saltus_word saltus_verdict_words[];

/* What a trajectory has ended on. */
typedef struct saltus_ending {
    saltus_verdict verdict;
    int periods;
    const double *state;  /* at section phase 0 */
    const double *points; /* of a periodic motion: its section points, periods x dimension */
} saltus_ending;

saltus_ending saltus_motion_ending(const saltus_motion *motion);

/* Whether two trajectories of a system have ended on the same attractor: on the same orbit, in the same rest,
 * or both on something that is neither and of the same kind. `distance`, relative to the system's scales, is
 * what section points of the same orbit may be apart by the accuracy with which they are known. Of the second
 * one its state is enough. */
bool saltus_same_attractor(const saltus_system *system, const saltus_ending *a, const saltus_ending *b,
                           double distance);

/* search.c: rests that are approached too slowly to wait for. */
/* Where a trajectory was when last looked at; zeroed at its begin. */
typedef struct saltus_rest_look {
    double distance; /* from the stable rest beside it, relative to the system's scales; 0: there was none */
    double time;
} saltus_rest_look;

/* Whether a trajectory without forcing, at a state and a time in units of time, is beside a stable rest free
 * of contacts, `place` (dimension numbers), and has come nearer since the last look, at least half as far as
 * the slowest eigenvalue predicts. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_rest_is_approached(const saltus_system *system, const double *state, double time,
                                        saltus_rest_look *last, double *place, bool *approached,
                                        saltus_message *message);

/* stable_orbit.c: stable orbits among points that look chaotic. */
/* Section points of one trajectory: one forcing period apart, or its returns. */
typedef struct saltus_track {
    const double *points;  /* count x dimension */
    const double *numbers; /* the logarithm of a tangent vector's growth from the point before until each;
                              without forcing when each came, in the system's periods */
    long long count;
} saltus_track;

/* Look for a stable orbit of up to 64 periods by Newton's method, from the best returns along the tracks,
 * shortest periods first; without forcing along the first one. Where one is *found, it is described by the
 * motion, to be cleared. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_stable_orbit_among(const saltus_system *system, const saltus_flow_options *flow,
                                        const saltus_track *tracks, int track_count, saltus_motion *motion,
                                        bool *found, saltus_message *message);

/* section_points.c: returns of a motion without forcing to its section, and stable orbits among them. */
/* The next returns of a trajectory from a state within so many periods: up to `room` section points
 * (dimension numbers each) and when they came, in the system's periods. Errors: those of the flow. */
saltus_status saltus_motion_section_points(const saltus_system *system, const saltus_flow_options *flow,
                                           const double *state, long long periods, long long room,
                                           double *points, double *times, long long *count,
                                           saltus_message *message);
/* saltus_stable_orbit_among without forcing: of up to 16 returns, by Newton's method with unknown period from
 * the closest returns among section points, shortest first. The orbit must pass by the points as near as
 * these come back. */
saltus_status saltus_stable_cycle_among(const saltus_system *system, const saltus_flow_options *flow,
                                        const saltus_track *track, saltus_motion *motion, bool *found,
                                        saltus_message *message);

/* cycle.c */
/* saltus_motion_cycle from a state of a system which closes after about so many of its periods. */
saltus_status saltus_motion_cycle_after(const saltus_system *system, double periods, const double *guess,
                                        const saltus_classify_options *options, saltus_motion *motion,
                                        saltus_message *message);

/* long_period.c: long periods, of motions that lock and of those that stick. */
/* A stable orbit of up to 1024 periods to which the motion at a state, at phase 0, is locked; its verdict
 * stays SALTUS_PENDING where none is found. The motion is to be cleared. Errors: those of the flow,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_motion_find_locked(const saltus_system *system, const saltus_classify_options *options,
                                        const double *state, saltus_motion *found, saltus_message *message);
/* The same of a motion whose contacts wipe out all differences, from one of them to the next one that is the
 * same, which is sought for ten times options->transient. Where the period stays unknown, the motion's reason
 * says why: there is no telling it where a run with another tolerance returns after another time. */
saltus_status saltus_motion_find_contact(const saltus_system *system, const saltus_classify_options *options,
                                         saltus_motion *motion, saltus_motion *found,
                                         saltus_message *message);
/* For how many periods a motion that looks chaotic, and of which so many have been measured, is watched for a
 * contact that wipes out all differences; 0 where no contact can do so. */
long long saltus_contact_watch(const saltus_system *system, long long measured);
/* Whether such a motion meets such a contact: after it everything repeats, however seldom it comes.
 * Trajectories from `count` states, at phase 0, are watched for it, together for saltus_contact_watch; where
 * one meets it, `state` (not one of them) is the section point after it of the first that does. Errors: those
 * of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_motion_meets_contact(const saltus_system *system, const saltus_flow_options *options,
                                          const double *const *states, int count, long long measured,
                                          double *state, bool *found, saltus_message *message);

#endif
