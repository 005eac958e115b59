/* What exponents and section points say about a motion without a period.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/evidence.h"

#include "motion/motion.h"
#include "saltus/series.h"
#include "saltus/spectrum.h"

#include <math.h>
#include <stdlib.h>

static const double halves_errors = 2, halves_apart = 4;
static const double zero_exponent = 2e-3; /* per period: what may be a torus */
static const double slow_exponent = 1e-5; /* per period: what shrinks no faster may be a torus */
static const double lines_only = 1e-2;    /* broadband part of a torus' section points */

/* The observed displacement at the section points, or its rate where a contact holds it there. */
static void observe(const saltus_system *system, const double *points, long long count, double *series) {
    const double *observer = saltus_system_observer(system);
    int n = saltus_system_dimension(system), dof = saltus_system_dof(system);
    for (int rate = 0; rate < 2; rate++) {
        double low = INFINITY, high = -INFINITY, size = 0;
        for (long long k = 0; k < count; k++) {
            series[k] = 0;
            for (int i = 0; i < dof; i++)
                series[k] += observer[i] * points[k * n + rate * dof + i];
            low = fmin(low, series[k]);
            high = fmax(high, series[k]);
            size = fmax(size, fabs(series[k]));
        }
        if (high - low > 1e-6 * size)
            return;
    }
}

saltus_status saltus_evidence_of_points(const saltus_system *system, const double *values, long long count,
                                        saltus_evidence *evidence, saltus_message *message) {
    const double *scale = saltus_system_scale(system);
    double weights[SALTUS_STATE_MAX], *series = calloc((size_t)count, sizeof *series);
    saltus_series_options options = saltus_series_defaults();
    saltus_series_chaos chaos = {0};
    saltus_series_curve curve = {0};
    saltus_series_dimension dimension = {0};
    saltus_series_points points = {values, weights, count, saltus_system_dimension(system)};
    if (!series)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the section points");
    for (int i = 0; i < points.dimension; i++)
        weights[i] = 1 / scale[i];
    observe(system, values, count, series);
    saltus_status status = saltus_series_chaos_test(series, points.count, &options, &chaos, message);
    if (status == SALTUS_OK)
        status = saltus_series_broadband(series, points.count, &evidence->broadband, message);
    if (status == SALTUS_OK)
        status = saltus_series_closed_curve(&points, &options, &curve, message);
    if (status == SALTUS_OK &&
        saltus_series_correlation_dimension(&points, &options, &dimension, NULL) == SALTUS_OK) {
        evidence->dimension = dimension.dimension;
        evidence->dimension_error = dimension.error;
    }
    evidence->zero_one = chaos.k;
    evidence->zero_one_quartiles[0] = chaos.lower;
    evidence->zero_one_quartiles[1] = chaos.upper;
    evidence->curves = curve.closed ? curve.curves : 0;
    free(series);
    return status;
}

static bool positive(const saltus_estimate *estimate, double errors) {
    return estimate->mean > errors * estimate->standard_error;
}

static bool negative(const saltus_estimate *estimate, double errors) {
    return estimate->mean < -errors * estimate->standard_error;
}

saltus_outcome saltus_runs_weigh(const saltus_runs *r) {
    bool settled = fabs(r->first.mean - r->second.mean) <
                   halves_apart * hypot(r->first.standard_error, r->second.standard_error);
    bool shrinks = negative(&r->all, SALTUS_SIGNIFICANT) && -r->all.mean * r->period > slow_exponent;
    if (r->lost || (shrinks && r->first.mean < 0 && r->second.mean < 0))
        return SALTUS_OUTCOME_REGULAR;
    if (fabs(r->all.mean) * r->period < zero_exponent)
        return SALTUS_OUTCOME_TORUS;
    return r->enough && settled && positive(&r->all, SALTUS_SIGNIFICANT) &&
                   positive(&r->first, halves_errors) && positive(&r->second, halves_errors)
               ? SALTUS_OUTCOME_CHAOS
               : SALTUS_OUTCOME_GOES_ON;
}

saltus_outcome saltus_runs_conclude(const saltus_runs *r, saltus_outcome outcome,
                                    const saltus_evidence *evidence) {
    if (outcome != SALTUS_OUTCOME_TORUS && outcome != SALTUS_OUTCOME_CHAOS)
        return outcome;
    /* An orbit that is approached slowly has lines and neighbours that stay, too, but no extent. */
    if (evidence->curves > 0 && evidence->broadband < lines_only && !(evidence->dimension < 0.5))
        return SALTUS_OUTCOME_TORUS;
    bool chaos = outcome == SALTUS_OUTCOME_CHAOS ||
                 (r->enough && positive(&r->all, SALTUS_SIGNIFICANT) && positive(&r->first, halves_errors) &&
                  positive(&r->second, halves_errors));
    return chaos ? SALTUS_OUTCOME_CHAOS : SALTUS_OUTCOME_GOES_ON;
}
