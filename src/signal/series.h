/* Private: points prepared for comparison, shared by the tests on stroboscopic series.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SIGNAL_SERIES_H
#define SALTUS_SIGNAL_SERIES_H

#include "base/memory.h"
#include "saltus/series.h"
#include "signal/random.h"

/* Weighted and centred points, scaled so that none is farther than 1/2 from the mean. */
typedef struct saltus_series_cloud {
    double *x; /* count x dimension */
    long long count;
    int dimension;
    double unit;       /* weighted distance that is 1 here; 0: all points coincide */
    double resolution; /* distances up to this count as zero */
    long long window;
} saltus_series_cloud;

/* Errors: those of the calls on points. On success the caller frees `x`. */
saltus_status saltus_series_cloud_open(const saltus_series_points *points,
                                       const saltus_series_options *options, saltus_series_cloud *cloud,
                                       saltus_message *message);

/* SALTUS_BAD_INPUT where an option or the number of values is unsuitable. */
saltus_status saltus_series_check(long long count, const saltus_series_options *options,
                                  saltus_message *message);

/* The largest weighted modulus; NAN where a value is not finite, or a weight not finite or negative. */
double saltus_series_largest(const saltus_series_points *points);
/* Weighted points about their mean, divided by `largest`, so that nothing overflows. */
void saltus_series_centre(const saltus_series_points *points, double largest, double *centred);

static inline const double *saltus_series_cloud_point(const saltus_series_cloud *cloud, long long i) {
    return cloud->x + i * cloud->dimension;
}

static inline double saltus_distance_square(const double *a, const double *b, int n) {
    double square = 0;
    for (int i = 0; i < n; i++)
        square += (a[i] - b[i]) * (a[i] - b[i]);
    return square;
}

#endif
