/* The 0-1 test for chaos.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "signal/series.h"

#include <gsl/gsl_math.h>
#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics_double.h>
#include <math.h>

enum { most_steps = 1000 };

/* A series and the walk in the plane that it drives. */
typedef struct walk {
    saltus_arena arena;
    long long count;     /* length of the series */
    long long longest;   /* longest displacement, in steps */
    long long stride;    /* steps between successive displacements used */
    double *value;       /* the series without its mean */
    double *p, *q;       /* the walk: [count] */
    double *steps, *msd; /* displacements used, and their mean squares: [used] */
    double *rate;        /* one per frequency */
    size_t used;
    saltus_random random;
} walk;

/* Mean square displacement over n steps, from the same starting points for all n. Eight sums run side by
 * side, so that the compiler can vectorise. */
static double displacement(const walk *w, long long n) {
    enum { side = 8 };
    long long starts = w->count - w->longest, k = 0;
    double sum[side] = {0}, total = 0;
    for (; k + side <= starts; k += side)
        for (int l = 0; l < side; l++) {
            double dp = w->p[k + l + n] - w->p[k + l], dq = w->q[k + l + n] - w->q[k + l];
            sum[l] += dp * dp + dq * dq;
        }
    for (; k < starts; k++)
        total += gsl_pow_2(w->p[k + n] - w->p[k]) + gsl_pow_2(w->q[k + n] - w->q[k]);
    for (int l = 0; l < side; l++)
        total += sum[l];
    return total / (double)starts;
}

/* Correlation of the mean square displacement with the number of steps. */
static double growth_rate(walk *w, double angle) {
    double p = 0, q = 0;
    for (long long k = 0; k < w->count; k++) {
        p += w->value[k] * cos((double)(k + 1) * angle);
        q += w->value[k] * sin((double)(k + 1) * angle);
        w->p[k] = p;
        w->q[k] = q;
    }
    for (size_t k = 0; k < w->used; k++)
        w->msd[k] = displacement(w, (long long)w->steps[k]);
    double rate = gsl_stats_correlation(w->steps, 1, w->msd, 1, w->used);
    return isfinite(rate) ? rate : 0;
}

saltus_status saltus_series_chaos_test(const double *series, long long count,
                                       const saltus_series_options *options, saltus_series_chaos *chaos,
                                       saltus_message *message) {
    *chaos = (saltus_series_chaos){.constant = true};
    saltus_status status = saltus_series_check(count, options, message);
    if (status != SALTUS_OK)
        return status;
    saltus_series_points values = {.values = series, .count = count, .dimension = 1};
    double low, high, largest = saltus_series_largest(&values);
    if (isnan(largest))
        return saltus_fail(message, SALTUS_BAD_INPUT, "the series should hold finite values only");
    gsl_stats_minmax(&low, &high, series, 1, (size_t)count);
    chaos->constant = !(high / largest - low / largest > options->resolution);
    if (chaos->constant)
        return SALTUS_OK;
    const size_t frequencies = (size_t)options->frequencies;
    walk w = {.count = count, .longest = count / 10};
    w.stride = (w.longest + most_steps - 1) / most_steps;
    w.used = (size_t)(w.longest / w.stride);
    do {
        w.value = saltus_arena_doubles(&w.arena, (size_t)count);
        w.p = saltus_arena_doubles(&w.arena, (size_t)count);
        w.q = saltus_arena_doubles(&w.arena, (size_t)count);
        w.steps = saltus_arena_doubles(&w.arena, w.used);
        w.msd = saltus_arena_doubles(&w.arena, w.used);
        w.rate = saltus_arena_doubles(&w.arena, frequencies);
    } while (saltus_arena_again(&w.arena));
    if (!w.arena.base)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the 0-1 test");
    saltus_series_centre(&values, largest, w.value);
    gsl_rng *rng = saltus_random_seed(&w.random, options->seed);
    for (size_t k = 0; k < w.used; k++)
        w.steps[k] = (double)((long long)(k + 1) * w.stride);
    for (size_t k = 0; k < frequencies; k++) {
        double part = ((double)k + gsl_rng_uniform_pos(rng)) / (double)frequencies;
        w.rate[k] = growth_rate(&w, M_PI / 5 + part * 3 * M_PI / 5);
    }
    gsl_sort(w.rate, 1, frequencies);
    chaos->k = gsl_stats_median_from_sorted_data(w.rate, 1, frequencies);
    chaos->lower = gsl_stats_quantile_from_sorted_data(w.rate, 1, frequencies, 0.25);
    chaos->upper = gsl_stats_quantile_from_sorted_data(w.rate, 1, frequencies, 0.75);
    saltus_arena_close(&w.arena);
    return SALTUS_OK;
}
