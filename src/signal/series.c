/* Preparation of points for the tests on stroboscopic series: checks, weights, centring, scaling.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "signal/series.h"

#include <math.h>
#include <stdlib.h>

saltus_series_options saltus_series_defaults(void) {
    return (saltus_series_options){
        .seed = 1, .resolution = 1e-9, .frequencies = 100, .window = -1, .pairs = 8000000};
}

saltus_status saltus_series_check(long long count, const saltus_series_options *options,
                                  saltus_message *message) {
    enum { frequencies_max = 100000, pairs_min = 10000 };
    if (count < SALTUS_SERIES_LEAST)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "a series of %lld is too short to be judged: at least %d are needed", count,
                           SALTUS_SERIES_LEAST);
    if (!(options->resolution >= 0 && options->resolution < 1))
        return saltus_fail(message, SALTUS_BAD_INPUT, "resolution %g should be between 0 and 1",
                           options->resolution);
    if (options->frequencies < 1 || options->frequencies > frequencies_max)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%d frequencies: should be between 1 and %d",
                           options->frequencies, frequencies_max);
    if (options->window < -1 || options->window > count / 4)
        return saltus_fail(
            message, SALTUS_BAD_INPUT,
            "window of %lld in time should be -1 (chosen) or up to a quarter of the series' %lld",
            options->window, count);
    if (options->pairs < pairs_min)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%lld pairs should be at least %d", options->pairs,
                           pairs_min);
    return SALTUS_OK;
}

double saltus_series_largest(const saltus_series_points *points) {
    double largest = 0;
    for (int d = 0; d < points->dimension; d++) {
        double weight = points->weights ? points->weights[d] : 1;
        if (!(weight >= 0 && isfinite(weight)))
            return NAN;
        for (long long i = 0; i < points->count; i++) {
            double value = fabs(weight * points->values[i * points->dimension + d]);
            if (!isfinite(value))
                return NAN;
            largest = fmax(largest, value);
        }
    }
    return largest;
}

void saltus_series_centre(const saltus_series_points *points, double largest, double *centred) {
    int n = points->dimension;
    for (int d = 0; d < n; d++) {
        double weight = points->weights ? points->weights[d] : 1, mean = 0;
        for (long long i = 0; i < points->count; i++) {
            centred[i * n + d] = weight * points->values[i * n + d] / largest;
            mean += centred[i * n + d] / (double)points->count;
        }
        for (long long i = 0; i < points->count; i++)
            centred[i * n + d] -= mean;
    }
}

saltus_status saltus_series_cloud_open(const saltus_series_points *points,
                                       const saltus_series_options *options, saltus_series_cloud *cloud,
                                       saltus_message *message) {
    *cloud = (saltus_series_cloud){.count = points->count, .dimension = points->dimension};
    saltus_status status = saltus_series_check(points->count, options, message);
    if (status != SALTUS_OK)
        return status;
    if (points->dimension < 1)
        return saltus_fail(message, SALTUS_BAD_INPUT, "points of dimension %d should have at least 1",
                           points->dimension);
    double largest = saltus_series_largest(points);
    if (!isfinite(largest))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "points and weights should be finite, and weights not negative");
    cloud->x = calloc((size_t)points->count * (size_t)points->dimension, sizeof *cloud->x);
    if (!cloud->x)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for %lld points", points->count);
    if (largest > 0)
        saltus_series_centre(points, largest, cloud->x);
    /* Scale the cloud so that twice the largest distance from the mean is 1. */
    const int n = points->dimension;
    double farthest = 0, squares = 0;
    for (long long i = 0; i < cloud->count; i++) {
        double square = 0;
        for (int d = 0; d < n; d++)
            square += cloud->x[i * n + d] * cloud->x[i * n + d];
        farthest = fmax(farthest, square);
        squares += square / (double)cloud->count;
    }
    const double unit = 2 * sqrt(farthest);
    cloud->window = options->window >= 0 ? options->window : 0;
    if (!(unit > options->resolution)) /* all points coincide */
        return SALTUS_OK;
    for (long long i = 0; i < cloud->count * n; i++)
        cloud->x[i] /= unit;
    cloud->unit = unit * largest;
    cloud->resolution = options->resolution / unit;
    if (options->window >= 0)
        return SALTUS_OK;
    /* Three times the first lag at which the autocorrelation is down to 1/e: at that lag itself points are
     * still neighbours because they are close in time. */
    const double spread = sqrt(2 * squares) / unit, limit = exp(-1.0) * 0.5 * spread * spread;
    long long most = cloud->count / 10, lag = 1;
    for (; 3 * lag < most; lag++) {
        double sum = 0;
        for (long long k = 0; k < (cloud->count - lag) * n; k++)
            sum += cloud->x[k] * cloud->x[k + lag * n];
        if (sum <= limit * (double)(cloud->count - lag))
            break;
    }
    cloud->window = 3 * lag < most ? 3 * lag : most;
    return SALTUS_OK;
}
