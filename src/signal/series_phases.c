/* Laminar phases of a series of points.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/series.h"

#include <math.h>

static double distance(const saltus_series_points *points, long long i, long long j) {
    const double *a = points->values + i * points->dimension, *b = points->values + j * points->dimension;
    double largest = 0;
    for (int d = 0; d < points->dimension; d++)
        largest = fmax(largest, fabs(a[d] - b[d]) * (points->weights ? points->weights[d] : 1));
    return largest;
}

static saltus_series_phases phases_of(const saltus_series_points *points, int period, double near) {
    const int least = 20, least_cycles = 5;
    saltus_series_phases phases = {.period = period};
    long long run = 0, laminar = 0, counted = 0; /* `counted`: points up to the end of the last phase */
    for (long long k = period; k <= points->count; k++) {
        if (k < points->count && distance(points, k, k - period) <= near) {
            run++;
            continue;
        }
        if (run >= least && run >= least_cycles * period) {
            long long begin = k - run - period;
            laminar += k - (begin > counted ? begin : counted);
            counted = k;
            phases.longest = run + period > phases.longest ? run + period : phases.longest;
        }
        run = 0;
    }
    phases.laminar = (double)laminar / (double)points->count;
    return phases;
}

saltus_series_phases saltus_series_laminar_phases(const saltus_series_points *points, int longest) {
    saltus_series_phases best = {0};
    double extent = 0;
    for (long long k = 1; k < points->count; k++)
        extent = fmax(extent, distance(points, k, 0));
    for (int p = 1; p <= longest && p < points->count; p++) {
        saltus_series_phases phases = phases_of(points, p, 0.02 * extent);
        if (phases.laminar > best.laminar)
            best = phases;
    }
    return best;
}
