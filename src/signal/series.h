/* Private: points made ready for comparison, shared by the tests on stroboscopic series.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SIGNAL_SERIES_H
#define SALTUS_SIGNAL_SERIES_H

#include "base/memory.h"
#include "saltus/series.h"

#include <gsl/gsl_rng.h>

/* Weighted and centred points, in units in which none is farther from the mean than 1/2. */
typedef struct saltus_cloud {
    saltus_arena arena;
    double *x; /* count x dimension */
    long long count;
    int dimension;
    double unit;       /* weighted length of 1; 0: all points coincide */
    double resolution; /* distances up to this are none */
    double spread;     /* root mean square distance of two points */
    long long window;
} saltus_cloud;

/* Errors: those of the calls on points. On success saltus_cloud_close is due. */
saltus_status saltus_cloud_open(const saltus_series_points *points, const saltus_series_options *options,
                                saltus_cloud *cloud, saltus_message *message);
void saltus_cloud_close(saltus_cloud *cloud);

/* SALTUS_BAD_INPUT where an option or the number of values is unsuitable. */
saltus_status saltus_series_check(long long count, const saltus_series_options *options,
                                  saltus_message *message);

/* A generator of GSL's in room of its own: nothing of GSL's allocates, so nothing of it fails. */
typedef struct saltus_series_random {
    gsl_rng rng;
    void *state;
} saltus_series_random;

/* False if there is no memory. */
bool saltus_series_random_open(saltus_series_random *random, unsigned long seed);
void saltus_series_random_close(saltus_series_random *random);

static inline const double *saltus_cloud_point(const saltus_cloud *cloud, long long i) {
    return cloud->x + i * cloud->dimension;
}

static inline double saltus_distance_square(const double *a, const double *b, int n) {
    double square = 0;
    for (int i = 0; i < n; i++)
        square += (a[i] - b[i]) * (a[i] - b[i]);
    return square;
}

#endif
