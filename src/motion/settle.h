/* Private: has a trajectory settled, and on which period?
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_SETTLE_H
#define SALTUS_MOTION_SETTLE_H

#include "saltus/system.h"

typedef struct saltus_settling {
    int n, longest, size;
    long long count;              /* points seen */
    double *points;               /* the last `size` ones, n each */
    double *weight;               /* 1 / scale */
    long long *impacts, *contact; /* per point: impacts and other contact events until then */
    int *streak;                  /* per period: points in a row that recur */
} saltus_settling;

/* For states of so many numbers, and periods up to the longest looked for. False without memory. */
bool saltus_settling_open(saltus_settling *settling, int dimension, int longest);
void saltus_settling_close(saltus_settling *settling);
void saltus_settling_reset(saltus_settling *settling, const saltus_system *system);
/* One more point at phase 0, with the numbers of impacts and of other contact events so far. */
void saltus_settling_add(saltus_settling *settling, const double *state, long long impacts,
                         long long contact_events);
/* The least period whose orbit has been reached to within a distance, or 0. *doubt: the orbit's period may be
 * a part of that one. */
int saltus_settling_period(const saltus_settling *settling, double limit, bool *doubt);
/* The least period that recurs roughly at present, or 0. */
int saltus_settling_candidate(const saltus_settling *settling);
/* Impacts, and other contact events, in the last periods. */
long long saltus_settling_impacts(const saltus_settling *settling, int period);
long long saltus_settling_contacts(const saltus_settling *settling, int period);
/* Least of the largest distances between points p apart, over the last p + 2, of all p; INFINITY while there
 * are too few points. */
double saltus_settling_closest(const saltus_settling *settling);
/* The point `back` periods before the last one: called most, so inlined. */
static inline const double *saltus_settling_point(const saltus_settling *settling, int back) {
    return settling->points + (size_t)((settling->count - 1 - back) % settling->size) * (size_t)settling->n;
}
/* Largest distance between points a period apart, over the last one. */
double saltus_settling_recurrence(const saltus_settling *settling, int period);
/* Whether nothing has moved over the last periods. */
bool saltus_settling_rests(const saltus_settling *settling);

#endif
