/* What the programs of the sweep's benchmark record of a motion, and how two records are compared.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_SWEEP_MOTION_H
#define SALTUS_BENCH_SWEEP_MOTION_H

#include <stdbool.h>

enum { settling_periods = 300, recorded_periods = 100, motion_dimension = 10 };

typedef struct impact {
    double time; /* in forcing periods after settling */
    double speed;
} impact;

/* What stands for n where an orbit has infinitely many impacts. */
enum { orbit_chatters = -1 };

/* The recorded periods of one motion. */
typedef struct motion {
    impact *impacts;
    int count, room, sticks;
    double settled[motion_dimension];   /* the state at the begin of the recorded periods */
    double (*strobe)[motion_dimension]; /* states at the recorded periods' ends, the first one's begin
                                           included; NULL where none was asked for */
    int orbit_impacts, orbit_periods;   /* n/p where the program itself tells it, otherwise 0/0 */
    bool failed;                        /* the integrator gave up, or no memory was left */
} motion;

/* Forgets what was recorded and keeps the memory. */
void motion_clear(motion *m);
void motion_free(motion *m);
void motion_add_impact(motion *m, double time, double speed);

/* Least period, in forcing periods, of the orbit that all recorded stroboscopic states keep to: some period
 * repeats to within `tolerance` of the scale. 0 if none does up to a half of what was recorded. */
int motion_period(const motion *m, const double *scale, double tolerance);

/* Whether `m` has the impacts of the periodic `reference`, counted over as many of its periods as were
 * recorded; `error` receives the largest difference of the impacts' times in the last one, in forcing periods
 * and after the best shift by whole ones (NaN where the counts differ). With sticking, impacts are too many
 * to be counted: the sticks are, and there is no error. */
bool motion_agrees(const motion *reference, int period, const motion *m, double *error);
/* The same where `m` tells of the impacts' times the phases only: all impacts of the recorded periods are
 * counted, and the last ones, as many as an orbit has, are compared after the best cyclic shift. */
bool motion_agrees_in_phase(const motion *reference, int period, const motion *m, double *error);
/* Impacts in a period of a periodic motion; orbit_chatters if it sticks. */
int motion_orbit_impacts(const motion *m, int period);

#endif
