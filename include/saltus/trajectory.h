/* Recorded trajectories: samples, events and stroboscopic points.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TRAJECTORY_H
#define SALTUS_TRAJECTORY_H

#include "saltus/flow.h"

SALTUS_API_BEGIN

/* A sampled trajectory with its events and stroboscopic points. It owns its arrays. */
typedef struct saltus_trajectory {
    int dimension;
    long long samples;    /* rows of `time` and `states` */
    double *time;         /* in forcing periods from the start of the recording; never decreasing */
    double *states;       /* samples x dimension */
    double *displacement; /* observed displacement and velocity, per sample */
    double *velocity;
    saltus_event *events;  /* impacts, sticks and releases; times as in `time` */
    long long *event_rows; /* the row just before each event; for an impact or a stick the next row is just
                              after it */
    long long event_count;
    long long strobes;     /* stroboscopic points at phase 0, one at the beginning of each recorded period */
    double *strobe_states; /* strobes x dimension */
    bool interrupted;      /* it ended early, because it was asked to stop */
} saltus_trajectory;

/* Run `transient` periods from a state, then record `periods` periods with `per_period` samples each, the end
 * included, and one more on each side of an impact. Errors: those of the flow, SALTUS_BAD_INPUT,
 * SALTUS_NO_MEMORY; the record is then empty. SALTUS_INTERRUPTED: it holds the part recorded so far. */
saltus_status saltus_trajectory_record(const saltus_system *system, const double *state,
                                       const saltus_flow_options *options, long long transient,
                                       long long periods, int per_period, saltus_trajectory *record,
                                       saltus_message *message);
/* What is recorded, for saltus_trajectory_follow. */
typedef struct saltus_trajectory_plan {
    long long transient, periods; /* forcing periods skipped, and recorded */
    int per_period;               /* samples per period */
    /* Points of a periodic orbit at phase 0: `orbit` states one after the other; 0: none. With them the
     * record restarts from the orbit's point in each period, and so stays on an unstable orbit; the state
     * passed is ignored and there is no transient. */
    const double *points;
    int orbit;
    saltus_progress progress; /* called once a period: periods done, the transient included */
} saltus_trajectory_plan;

/* The same with a plan. Errors: as saltus_trajectory_record. */
saltus_status saltus_trajectory_follow(const saltus_system *system, const double *state,
                                       const saltus_flow_options *options, const saltus_trajectory_plan *plan,
                                       saltus_trajectory *record, saltus_message *message);
void saltus_trajectory_clear(saltus_trajectory *record);

SALTUS_API_END
#endif
