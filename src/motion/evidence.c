/* What exponents and section points say about a motion without a period.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/evidence.h"

#include "base/dense.h"
#include "saltus/series.h"
#include "saltus/spectrum.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

enum { least_watched = 500 }; /* periods, whatever the lifetime */
static const double halves_errors = 2, halves_apart = 4;
static const double zero_exponent = 2e-3; /* per period: a larger exponent is not that of a torus */
static const double slow_exponent = 1e-5; /* per period: slower contraction may still be a torus */
static const double zero_error = 5e-5;    /* per period: how well the exponent of a torus must be known */
static const double confidence = 0.95;
static const double lines_only = 1e-2; /* broadband part of a torus' section points */

/* Weak chaos and locking have exponents of about 1e-4 per period. */
bool saltus_exponent_may_be_zero(saltus_estimate exponent, double period) {
    return fabs(exponent.mean) * period < zero_exponent &&
           fabs(exponent.mean) < SALTUS_SIGNIFICANT * exponent.standard_error + slow_exponent / period &&
           exponent.standard_error * period < zero_error;
}

double saltus_lifetime_at_least(double watched, int left) {
    return 2 * watched / gsl_cdf_chisq_Pinv(confidence, 2.0 * (left + 1));
}

static bool positive(const saltus_estimate *estimate, double errors) {
    return estimate->mean > errors * estimate->standard_error;
}

saltus_outcome saltus_runs_weigh(const saltus_runs *r) {
    bool shrinks =
        r->all.mean < -SALTUS_SIGNIFICANT * r->all.standard_error && -r->all.mean * r->period > slow_exponent;
    if (r->lost || (shrinks && r->first.mean < 0 && r->second.mean < 0))
        return SALTUS_OUTCOME_REGULAR;
    /* Chaos: the exponent is positive over the whole run, both halves and the last eighth, the halves agree,
     * the run shows the required lifetime, and neighbours have come apart - before that, all trajectories
     * may still be near one unstable orbit that they leave slowly. */
    bool grows = positive(&r->all, SALTUS_SIGNIFICANT) && positive(&r->first, halves_errors) &&
                 positive(&r->second, halves_errors) && r->latest > 0;
    bool settled = fabs(r->first.mean - r->second.mean) <
                   halves_apart * hypot(r->first.standard_error, r->second.standard_error);
    bool apart = r->all.mean * r->period * (double)(r->watched / r->members) >= SALTUS_APART;
    bool enough =
        r->watched >= least_watched && saltus_lifetime_at_least((double)r->watched, 0) >= (double)r->lifetime;
    if (grows && settled && apart)
        return enough ? SALTUS_OUTCOME_CHAOS : SALTUS_OUTCOME_SHORT;
    return saltus_exponent_may_be_zero(r->all, r->period) ? SALTUS_OUTCOME_TORUS : SALTUS_OUTCOME_OPEN;
}

saltus_status saltus_points_test(const saltus_system *system, const double *values, long long count,
                                 saltus_point_tests tests, saltus_evidence *evidence, saltus_outcome *outcome,
                                 saltus_message *message) {
    const double *scale = saltus_system_scale(system);
    double weights[SALTUS_STATE_MAX], *series = malloc((size_t)count * sizeof *series);
    bool all = tests == SALTUS_TESTS_ALL;
    saltus_series_options options = saltus_series_defaults();
    saltus_series_chaos chaos = {NAN, NAN, NAN, false};
    saltus_series_curve curve = {0};
    saltus_series_dimension dimension = {0};
    saltus_series_points points = {values, weights, count, saltus_system_dimension(system)};
    if (!series)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the section points");
    for (int i = 0; i < points.dimension; i++)
        weights[i] = 1 / scale[i];
    /* The observed displacement at the section points, or its rate where a contact holds the displacement. */
    const double *observer = saltus_system_observer(system);
    const int dof = saltus_system_dof(system);
    double low = 0, high = 0, size = 0;
    for (int rate = 0; rate < 2 && !(high - low > 1e-6 * size); rate++) {
        low = INFINITY;
        high = -INFINITY;
        size = 0;
        for (long long k = 0; k < count; k++) {
            series[k] = saltus_dot(observer, values + k * points.dimension + rate * dof, dof);
            low = fmin(low, series[k]);
            high = fmax(high, series[k]);
            size = fmax(size, fabs(series[k]));
        }
    }
    saltus_status status = saltus_series_broadband(series, count, &evidence->broadband, message);
    if (status == SALTUS_OK && all)
        status = saltus_series_chaos_test(series, count, &options, &chaos, message);
    if (status == SALTUS_OK && (all || evidence->broadband < lines_only))
        status = saltus_series_closed_curve(&points, &options, &curve, message);
    if (status == SALTUS_OK && all &&
        saltus_series_correlation_dimension(&points, &options, &dimension, NULL) == SALTUS_OK) {
        evidence->dimension = dimension.dimension;
        evidence->dimension_error = dimension.error;
    }
    evidence->zero_one = chaos.k;
    evidence->zero_one_quartiles[0] = chaos.lower;
    evidence->zero_one_quartiles[1] = chaos.upper;
    evidence->curves = curve.closed ? curve.curves : 0;
    free(series);
    /* An orbit that is approached slowly also has a spectrum of lines and points that keep their neighbours,
     * but their dimension is zero. */
    if (status == SALTUS_OK && *outcome == SALTUS_OUTCOME_TORUS &&
        !(evidence->curves > 0 && evidence->broadband < lines_only && !(evidence->dimension < 0.5)))
        *outcome = SALTUS_OUTCOME_OPEN;
    return status;
}
