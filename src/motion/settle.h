/* Private: has a trajectory settled, and on which period?
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_SETTLE_H
#define SALTUS_MOTION_SETTLE_H

#include "saltus/system.h"

typedef struct saltus_settling {
    const saltus_system *system; /* not used if reach = 0 */
    double reach; /* of section points to the impacts that they lie after (saltus_section_point) */
    int n, longest, size;
    long long count, looked;      /* points seen; those of them that `streak` counts */
    int last;                     /* place of the last one in the ring buffer: (count - 1) % size */
    double *points;               /* ring buffer of the last `size` points, n numbers each */
    double *weight;               /* 1 / scale */
    long long *impacts, *contact; /* per point: counts of impacts and of other contact events so far */
    int *streak; /* per period: number of latest points in a row that recur after it, if fewer than p + 2;
                    otherwise at least that */
} saltus_settling;

/* For states of `dimension` numbers and periods up to `longest`. False without memory. */
bool saltus_settling_open(saltus_settling *settling, int dimension, int longest);
void saltus_settling_close(saltus_settling *settling);
/* Forget all points. The flow's relative tolerance tells how near to an impact one lies after it. */
void saltus_settling_reset(saltus_settling *settling, const saltus_system *system, double rtol);
/* Add the next state at section phase 0, kept as its section point, or without forcing a return, with the
 * counts of impacts and of other contact events so far. */
void saltus_settling_add(saltus_settling *settling, const double *state, long long impacts,
                         long long contact_events);
/* The least period whose orbit has been reached to within `limit`, or 0. *doubt: the orbit's true period may
 * be a divisor of it. */
int saltus_settling_period(saltus_settling *settling, double limit, bool *doubt);
/* The least period after which the last points roughly recur, or 0. */
int saltus_settling_candidate(saltus_settling *settling);
/* Numbers of impacts, and of other contact events, in the last `period` periods. */
long long saltus_settling_impacts(const saltus_settling *settling, int period);
long long saltus_settling_contacts(const saltus_settling *settling, int period);
/* How closely the trajectory recurs at best: for each p the largest distance between points p apart over the
 * last p + 2 points, minimised over p; INFINITY while there are too few points. */
double saltus_settling_closest(const saltus_settling *settling);
/* The place in the ring buffer of the point `back` < size periods before the last one, and that point;
 * inlined because they are called most. */
static inline int saltus_settling_place(const saltus_settling *settling, int back) {
    const int place = settling->last - back;
    return place < 0 ? place + settling->size : place;
}
static inline const double *saltus_settling_point(const saltus_settling *settling, int back) {
    return settling->points + (size_t)saltus_settling_place(settling, back) * (size_t)settling->n;
}
/* Largest distance between points a period apart, over the last period. */
double saltus_settling_recurrence(const saltus_settling *settling, int period);
/* Whether the state has stood still, without events, over the last periods. */
bool saltus_settling_rests(const saltus_settling *settling);

#endif
