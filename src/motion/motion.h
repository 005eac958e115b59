/* Private: what the files of this folder share.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_PRIVATE_H
#define SALTUS_MOTION_PRIVATE_H

#include "base/field.h"
#include "base/progress.h"
#include "motion/evidence.h"
#include "orbit/lap.h"
#include "orbit/orbit.h"
#include "saltus/equilibrium.h"
#include "system/state.h"

/* Options for shooting with the flow options of a classification. */
saltus_orbit_options saltus_motion_shooting(const saltus_classify_options *options);

/* saltus_classify that also tells, in *stopped, whether options->flow.stop ended it early. */
saltus_status saltus_motion_classify(const saltus_system *system, const double *state,
                                     const saltus_classify_options *options, saltus_motion *motion,
                                     bool *stopped, saltus_message *message);
/* Judge a motion that has not settled: fills verdict, reason, exponent and evidence, and moves motion->state
 * on along the attractor. The verdict stays SALTUS_UNDECIDED if a period may still appear; the outcome tells
 * whether it should. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_motion_judge(const saltus_system *system, const saltus_classify_options *options,
                                  saltus_motion *motion, saltus_outcome *outcome, saltus_message *message);
/* Reset the evidence to "nothing measured": numbers become NAN, the history is freed. */
void saltus_motion_forget_evidence(saltus_motion *motion);
/* Label a motion without a period, and measure its extremes along the trajectory from motion->state. Errors:
 * those of the flow. */
saltus_status saltus_motion_survey(const saltus_system *system, saltus_flow *flow, saltus_motion *motion,
                                   saltus_message *message);
/* The first part of saltus_classify: settle and find a period, without judging a motion that has none.
 * `limited`: do not try very long orbits of very many impacts. */
saltus_status saltus_motion_find_period(const saltus_system *system, const double *state,
                                        const saltus_classify_options *options, bool limited,
                                        saltus_motion *motion, saltus_message *message);

/* Make an undecided motion with room for a state. False without memory. */
bool saltus_motion_open(const saltus_system *system, const saltus_flow_options *flow, saltus_motion *motion);
/* Fill an open motion with the description of a periodic orbit and take over the arrays of the lap around
 * it. `flow` is one of `system` without columns. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_motion_take(const saltus_system *system, saltus_flow *flow, const saltus_orbit *orbit,
                                 saltus_lap *lap, saltus_motion *motion, saltus_message *message);
/* Describe the stable orbit that Newton's method finds from a state which closes after about `periods`
 * periods. The verdict stays SALTUS_PENDING if it finds none within `near`, relative to the system's scales.
 * The motion is to be cleared. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_motion_polish(const saltus_system *system, int periods, const double *state, double near,
                                   const saltus_classify_options *options, saltus_motion *motion,
                                   saltus_message *message);
/* Fill an open motion without an orbit, whose verdict is already set, from the flow's present state. */
saltus_status saltus_motion_rest(const saltus_system *system, saltus_flow *flow, saltus_motion *motion,
                                 saltus_message *message);

/* verdict.c: words of verdicts; whether two motions are the same attractor. */
extern const saltus_word saltus_verdict_words[];

/* What a trajectory has ended on. */
typedef struct saltus_ending {
    saltus_verdict verdict;
    int periods;
    const double *state;  /* at section phase 0 */
    const double *points; /* of a periodic motion: its section points, periods x dimension */
} saltus_ending;

/* The ending of a motion, whose arrays it refers to. */
saltus_ending saltus_motion_ending(const saltus_motion *motion);

/* Whether two trajectories of a system have ended on the same attractor: on the same orbit or the same rest,
 * or both with the same verdict if they have not settled. `distance`, relative to the system's scales, is
 * how accurately section points of one orbit are known. Of `b` only verdict, periods and state are used. */
bool saltus_same_attractor(const saltus_system *system, const saltus_ending *a, const saltus_ending *b,
                           double distance);

/* search.c: rests that are approached too slowly to wait for */
/* A trajectory's last look for a rest; zeroed at the start. */
typedef struct saltus_rest_look {
    double distance; /* from the stable rest nearby, relative to the system's scales; 0: there was none */
    double time;
} saltus_rest_look;

/* Whether an unforced trajectory is near a stable rest without contacts, `place` (dimension numbers), and
 * has approached it since the last look by at least half of what the slowest eigenvalue predicts. `time` is
 * the trajectory's, in units of time. Updates *last. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_rest_is_approached(const saltus_system *system, const double *state, double time,
                                        saltus_rest_look *last, double *place, bool *approached,
                                        saltus_message *message);

/* stable_orbit.c: stable orbits among points that look chaotic */
/* Successive section points of one trajectory: one forcing period apart, or without forcing its returns. */
typedef struct saltus_track {
    const double *points;  /* count x dimension */
    const double *numbers; /* per point: logarithm of a tangent vector's growth since the previous point;
                              without forcing the time of the return, in the system's periods */
    long long count;
} saltus_track;

/* Look for a stable orbit of up to 64 periods by Newton's method from the closest returns along the tracks,
 * shortest periods first; without forcing only along the first track. `motion`, to be cleared, describes it;
 * its verdict stays SALTUS_PENDING if there is none. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_stable_orbit_among(const saltus_system *system, const saltus_flow_options *flow,
                                        const saltus_track *tracks, int track_count, saltus_motion *motion,
                                        saltus_message *message);

/* section_points.c: returns of an unforced motion to its section, and stable orbits among them */
/* The returns of a trajectory within `periods` of the system's periods from a state: up to `room` section
 * points (dimension numbers each) and their times, in the system's periods. Errors: those of the flow. */
saltus_status saltus_motion_section_points(const saltus_system *system, const saltus_flow_options *flow,
                                           const double *state, long long periods, long long room,
                                           double *points, double *times, long long *count,
                                           saltus_message *message);
/* saltus_stable_orbit_among for systems without forcing: orbits of up to 16 returns, by Newton's method with
 * unknown period from the closest returns of the track, shortest first. An orbit counts only if it passes
 * the starting point within three times the distance of the return. */
saltus_status saltus_stable_cycle_among(const saltus_system *system, const saltus_flow_options *flow,
                                        const saltus_track *track, saltus_motion *motion,
                                        saltus_message *message);

/* saltus_motion_cycle from a state that closes after about `periods` of the system's periods. */
saltus_status saltus_motion_cycle_after(const saltus_system *system, double periods, const double *guess,
                                        const saltus_classify_options *options, saltus_motion *motion,
                                        saltus_message *message);

/* long_period.c: long periods of motions that lock and of motions that stick */
/* Look for a stable orbit of up to 1024 periods to which the motion at a state, at phase 0, is locked. The
 * verdict of `found` stays SALTUS_PENDING if there is none; `found` is to be cleared. Errors: those of the
 * flow, SALTUS_NO_MEMORY. */
saltus_status saltus_motion_find_locked(const saltus_system *system, const saltus_classify_options *options,
                                        const double *state, saltus_motion *found, saltus_message *message);
/* The same for a motion with lasting contacts that wipe out all differences between neighbours: the period
 * is the time between two such contacts that are the same. Each next one is awaited for ten times
 * options->transient. motion->reason says why a period stays unknown, for instance because it depends on the
 * flow's tolerance. */
saltus_status saltus_motion_find_contact(const saltus_system *system, const saltus_classify_options *options,
                                         saltus_motion *motion, saltus_motion *found,
                                         saltus_message *message);
/* For how many periods to watch a motion that looks chaotic, after measuring it for `measured` periods, for
 * a contact that wipes out all differences; 0 if the scene has too few stops for such a contact. */
long long saltus_contact_watch(const saltus_system *system, long long measured);
/* Whether a motion that looks chaotic meets a contact that wipes out all differences; if it does it is
 * periodic, however rare the contact. Trajectories from `count` states at phase 0 are watched, together for
 * saltus_contact_watch periods. If one meets such a contact, `state` (none of `states`) becomes the section
 * point after the earliest one. Errors: those of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_motion_meets_contact(const saltus_system *system, const saltus_flow_options *options,
                                          const double *const *states, int count, long long measured,
                                          double *state, bool *found, saltus_message *message);

#endif
