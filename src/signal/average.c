/* Averages of correlated or oscillating values, with their standard errors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/average.h"

#include <math.h>
#include <string.h>

enum { least_values = 16, most_order = 40, enough_to_weight = 128 };

/* Least error of the weighted mean over that of the plain mean: parts of a run can agree by chance. */
static const double least_gain = 0.05;
/* Random values pass both limits only once in many thousand runs: half the excursion over the standard error,
 * and the disagreement of the parts' weighted means over the error. */
static const double too_calm = 0.2, too_good = 0.1;

void saltus_average_add(saltus_average *a, double value) {
    if (a->size == 0) {
        a->size = 1;
        a->origin = value;
    }
    a->count++;
    a->squares += (value - a->origin) * (value - a->origin);
    a->partial += value;
    if (++a->open < a->size)
        return;
    a->sum[a->batches++] = a->partial;
    a->open = 0;
    a->partial = 0;
    if (a->batches < SALTUS_AVERAGE_BATCHES)
        return;
    for (int k = 0; k < SALTUS_AVERAGE_BATCHES / 2; k++)
        a->sum[k] = a->sum[2 * k] + a->sum[2 * k + 1];
    a->batches = SALTUS_AVERAGE_BATCHES / 2;
    a->size *= 2;
}

/* Variance of the batches' mean: the spectrum at frequency zero of an autoregression fitted to them. */
static double variance_of_mean(const double *sum, int batches, double mean) {
    double covariances[most_order + 1], a[most_order + 1] = {0}, variance, best;
    int orders = (int)(10 * log10(batches));
    orders = orders < most_order ? orders : most_order;
    for (int t = 0; t <= orders; t++) {
        /* The batches' autocovariance at lag t. */
        double product = 0;
        for (int k = 0; k + t < batches; k++)
            product += (sum[k] - mean) * (sum[k + t] - mean);
        covariances[t] = product / batches;
    }
    double left = covariances[0];
    if (!(left > 0))
        return 0;
    best = batches * log(left);
    variance = left / (batches - 1);
    for (int order = 1; order <= orders; order++) {
        /* Levinson's recursion: a[1..order] are the coefficients of the autoregression, `left` the variance
         * of its residual. */
        double before[most_order + 1], reflection = covariances[order];
        for (int j = 1; j < order; j++)
            reflection -= a[j] * covariances[order - j];
        reflection /= left;
        memcpy(before, a, sizeof before);
        a[order] = reflection;
        for (int j = 1; j < order; j++)
            a[j] = before[j] - reflection * before[order - j];
        left *= 1 - reflection * reflection;
        double rest = 1, criterion = batches * log(left) + 2 * order;
        for (int j = 1; j <= order; j++)
            rest -= a[j];
        if (!(left > 0))
            break;
        if (criterion < best) {
            best = criterion;
            variance = left / (batches - order - 1) / (rest * rest);
        }
    }
    return variance;
}

/* Mean with a smooth weight that vanishes at both ends with all its derivatives. For periodic and
 * quasi-periodic values its error falls faster than any power of their number. */
static double weighted_mean(const double *sum, int batches) {
    double total = 0, weights = 0;
    for (int k = 0; k < batches; k++) {
        double t = (k + 0.5) / batches, weight = exp(-1 / (t * (1 - t)));
        total += weight * sum[k];
        weights += weight;
    }
    return total / weights;
}

/* Largest difference between the weighted mean of all batches and those of parts of the run. */
static double disagreement(const double *sum, int batches, double all) {
    static const double parts[][2] = {{0, 0.5},    {0.5, 1},       {0.25, 0.75}, {0, 0.67},
                                      {0.33, 1.0}, {0.125, 0.875}, {0, 0.8},     {0.2, 1}};
    double largest = 0;
    for (size_t k = 0; k < sizeof parts / sizeof parts[0]; k++) {
        int first = (int)(parts[k][0] * batches), last = (int)(parts[k][1] * batches);
        largest = fmax(largest, fabs(weighted_mean(sum + first, last - first) - all));
    }
    return largest;
}

/* Which mean to use; BETTER: the weighted one where it is more accurate. */
typedef enum choice { PLAIN, WEIGHTED, BETTER } choice;

static saltus_estimate estimate(const double *sum, int batches, long long size, choice which) {
    saltus_estimate result = {.standard_error = INFINITY, .count = batches * size};
    if (batches < 1)
        return result;
    double mean = 0;
    for (int k = 0; k < batches; k++)
        mean += sum[k];
    mean /= batches;
    result.mean = mean / (double)size;
    if (batches < least_values)
        return result;
    /* Half the largest excursion of the partial sums, per batch: for oscillating values the error of the mean
     * is at least this large. For random values it is 0.43 +- 0.13 of the standard error. */
    double partial = 0, largest = 0;
    for (int k = 0; k < batches; k++) {
        partial += sum[k] - mean;
        largest = fmax(largest, fabs(partial));
    }
    const double random = sqrt(variance_of_mean(sum, batches, mean)), bounded = 0.5 * largest / batches;
    result.regular = bounded >= random;
    double error = result.regular ? 2 * bounded : fmax(random, bounded);
    if (which != PLAIN && batches >= enough_to_weight) {
        double weighted = weighted_mean(sum, batches),
               apart = fmax(2 * disagreement(sum, batches, weighted), least_gain * bounded);
        bool calm = bounded < too_calm * random && apart < too_good * error;
        result.weighted = which == WEIGHTED || calm || (result.regular && apart < error);
        if (result.weighted) {
            result.mean = weighted / (double)size;
            error = apart;
        }
    }
    result.standard_error = error / (double)size;
    return result;
}

static saltus_estimate whole(const saltus_average *a, choice which) {
    saltus_estimate result = estimate(a->sum, a->batches, a->size, which);
    double count = (double)a->count, mean = result.mean - a->origin,
           variance = a->squares / count - mean * mean, error = result.standard_error;
    if (isfinite(error))
        result.independent = error > 0 && variance > 0 ? variance / (error * error) : count;
    return result;
}

saltus_estimate saltus_average_estimate(const saltus_average *a) {
    return whole(a, BETTER);
}

saltus_estimate saltus_average_plain(const saltus_average *a) {
    return whole(a, PLAIN);
}

saltus_estimate saltus_average_weighted(const saltus_average *a) {
    return whole(a, WEIGHTED);
}

saltus_estimate saltus_average_part(const saltus_average *a, double from, double to) {
    int first = (int)(from * a->batches), last = (int)(to * a->batches);
    return estimate(a->sum + first, last - first, a->size, BETTER);
}

saltus_estimate saltus_estimates_join(const saltus_estimate *estimates, int count) {
    saltus_estimate joint = {.regular = true, .weighted = true};
    double squares = 0, sum = 0;
    for (int k = 0; k < count; k++) {
        sum += estimates[k].standard_error / count;
        joint.regular &= estimates[k].regular;
        joint.weighted &= estimates[k].weighted;
        joint.mean += estimates[k].mean / count;
        squares += estimates[k].standard_error * estimates[k].standard_error;
        joint.independent += estimates[k].independent;
        joint.count += estimates[k].count;
    }
    joint.standard_error = joint.regular || joint.weighted ? sum : sqrt(squares) / count;
    return joint;
}
