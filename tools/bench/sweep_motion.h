/* Records of motions for the sweep benchmark, and their comparison.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_SWEEP_MOTION_H
#define SALTUS_BENCH_SWEEP_MOTION_H

#include <stdbool.h>

enum { settling_periods = 300, recorded_periods = 100, motion_dimension = 10 };

typedef struct impact {
    double time; /* in forcing periods after settling */
    double speed;
} impact;

/* Replaces n if an orbit has infinitely many impacts. */
enum { orbit_chatters = -1 };

/* The recorded periods of one motion. */
typedef struct motion {
    impact *impacts;
    int count, room, sticks;
    double settled[motion_dimension];   /* the state at the beginning of the recorded periods */
    double (*strobe)[motion_dimension]; /* states at the end of each recorded period, and at the beginning of
                                           the first; NULL if not requested */
    int orbit_impacts, orbit_periods;   /* n/p if the program reports it, otherwise 0/0 */
    bool failed;                        /* the integrator gave up, or no memory was left */
} motion;

/* Discard the records but keep the memory. */
void motion_clear(motion *m);
void motion_free(motion *m);
void motion_add_impact(motion *m, double time, double speed);

/* Least period, in forcing periods, with which the recorded stroboscopic states repeat to within `tolerance`
 * of the scale; 0 if there is none up to half of the record. */
int motion_period(const motion *m, const double *scale, double tolerance);

/* Whether `m` has the impacts of the periodic `reference`, counted over as many of its periods as were
 * recorded. `error` receives the largest difference between the impact times in the last period, in forcing
 * periods, after the best shift by whole periods (NAN if the counts differ). With sticking there are too many
 * impacts: sticks are counted instead, and there is no error. */
bool motion_agrees(const motion *reference, int period, const motion *m, double *error);
/* The same if `m` has only the phases of impacts: all impacts of the recorded periods are counted, and those
 * of the last orbit are compared after the best cyclic shift. */
bool motion_agrees_in_phase(const motion *reference, int period, const motion *m, double *error);
/* Number of impacts per period of a periodic motion; orbit_chatters if it sticks. */
int motion_orbit_impacts(const motion *m, int period);

#endif
