/* Averages of correlated series: the stated standard error against the true one, if known.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "saltus/average.h"

/* SplitMix64. */
static uint64_t next_word(uint64_t *state) {
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static double uniform(uint64_t *state) {
    return ((double)(next_word(state) >> 11) + 0.5) * 0x1p-53;
}

static double normal(uint64_t *state) {
    double radius = sqrt(-2 * log(uniform(state)));
    return radius * cos(2 * M_PI * uniform(state));
}

/* Series of values whose mean is known. */
typedef enum series_kind { white, autoregressive, logistic, henon } series_kind;

typedef struct series {
    series_kind kind;
    double a; /* correlation, or parameter of the map */
    uint64_t random;
    double x, y, u, v; /* point and tangent vector */
} series;

static double next_value(series *s) {
    double value = s->x, length, x = s->x;
    switch (s->kind) {
    case white:
        return normal(&s->random);
    case autoregressive:
        s->x = s->a * s->x + sqrt(1 - s->a * s->a) * normal(&s->random);
        return value;
    case logistic:
        s->x = s->a * x * (1 - x);
        return log(fabs(s->a * (1 - 2 * x)));
    case henon:
        s->x = 1 - 1.4 * x * x + s->y;
        s->y = 0.3 * x;
        value = -2.8 * x * s->u + s->v;
        s->v = 0.3 * s->u;
        length = hypot(value, s->v);
        s->u = value / length;
        s->v /= length;
        return log(length);
    }
    return NAN;
}

static series begin_series(series_kind kind, double a, int seed) {
    series s = {.kind = kind, .a = a, .random = 1000u + (uint64_t)seed, .u = 1};
    if (kind == autoregressive)
        s.x = normal(&s.random);
    else
        s.x = kind == henon ? 0.1 * uniform(&s.random) : 0.1 + 0.8 * uniform(&s.random);
    for (int k = 0; k < 500 && kind >= logistic; k++)
        next_value(&s);
    return s;
}

static void add_values(saltus_average *average, series *s, long long count) {
    for (long long k = 0; k < count; k++)
        saltus_average_add(average, next_value(s));
}

typedef struct calibration {
    double within;      /* share of the seeds within one standard error, */
    double within_two;  /* within two, */
    double chi_square;  /* mean square of the deviations in standard errors */
    double mean_square; /* of the stated errors */
    double farthest;    /* deviation in standard errors */
} calibration;

static calibration calibrate(series_kind kind, double a, double truth, long long count, int seeds) {
    calibration c = {0};
    for (int seed = 0; seed < seeds; seed++) {
        saltus_average average = {0};
        series s = begin_series(kind, a, seed);
        add_values(&average, &s, count);
        saltus_estimate estimate = saltus_average_estimate(&average);
        double apart = fabs(estimate.mean - truth) / estimate.standard_error;
        c.within += (apart < 1) / (double)seeds;
        c.within_two += (apart < 2) / (double)seeds;
        c.chi_square += apart * apart / seeds;
        c.mean_square += estimate.standard_error * estimate.standard_error / seeds;
        c.farthest = fmax(c.farthest, apart);
        assert_true(estimate.count <= count &&
                    estimate.count >= count - count / 256); /* whole batches at least */
    }
    return c;
}

/* Variance of the mean of n values with correlations a^t. */
static double known_variance(double a, double n) {
    return ((1 + a) / (1 - a) - 2 * a * (1 - pow(a, n)) / (n * (1 - a) * (1 - a))) / n;
}

/* Two thirds within one standard error, 95 % within two. 200 seeds: 0.68 +- 0.033, chi-square 1 +- 0.1. */
static void check_calibrated(series_kind kind, double a, double truth, long long count) {
    calibration c = calibrate(kind, a, truth, count, 200);
    if (kind == autoregressive)
        check_near(c.mean_square / known_variance(a, (double)count), 1, 0.15);
    if (!(fabs(c.within - 0.68) <= 0.06 && c.within_two > 0.9 && c.chi_square < 1.4 && c.chi_square > 0.7))
        fail_msg("series %d, %g, %lld values: %.3f within one error, %.3f within two, chi-square %.3f", kind,
                 a, count, c.within, c.within_two, c.chi_square);
}

/* Few values of slowly or oddly correlated series: errors may be too large, not too small. */
static void check_cautious(series_kind kind, double a, double truth, long long count) {
    calibration c = calibrate(kind, a, truth, count, 200);
    if (!(c.within >= 0.62 && c.within_two > 0.88 && c.chi_square < 1.5))
        fail_msg("series %d, %g, %lld values: %.3f within one error, %.3f within two, chi-square %.3f", kind,
                 a, count, c.within, c.within_two, c.chi_square);
}

/* Reference means from 4e8 values each (200 runs), +- 3e-5: far below the errors here. */
static void chaotic_maps(void **unused) {
    (void)unused;
    check_calibrated(logistic, 3.9, 0.49600, 1000);
    check_calibrated(logistic, 3.9, 0.49600, 10000);
    check_calibrated(logistic, 3.7, 0.35496, 10000);
    check_calibrated(logistic, 3.58, 0.10541, 10000);
    check_calibrated(logistic, 3.8282, 0.25866, 20000); /* intermittent */
    check_calibrated(henon, 0, 0.41922, 1000);
    check_calibrated(henon, 0, 0.41922, 10000);
    check_cautious(logistic, 3.58, 0.10541, 1000);
    check_cautious(logistic, 3.9, 0.49600, 300);
    check_cautious(henon, 0, 0.41922, 300);
}

/* Conjugate to the tent map, whose slope is 2: deviations are those of the two ends, and the error falls like
 * 1/n. */
static void logistic_map_at_four(void **unused) {
    (void)unused;
    for (long long count = 1000; count <= 100000; count *= 10) {
        calibration c = calibrate(logistic, 4, M_LN2, count, 200);
        assert_true(c.farthest < 4 && c.chi_square < 1);
        check_near(sqrt(c.mean_square) * (double)count, 0, 10);
    }
}

static void correlated_noise(void **unused) {
    (void)unused;
    static const struct {
        double a;
        long long count;
    } rows[] = {{0.99, 20000}, {0.99, 40000}, {0.9, 5000}, {-0.9, 1000}, {-0.9, 20000}, {0.5, 1000}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++)
        check_calibrated(autoregressive, rows[k].a, 0, rows[k].count);
    check_cautious(autoregressive, -0.9, 0, 200);
    check_cautious(autoregressive, -0.9, 0, 2000);
}

static void white_noise(void **unused) {
    (void)unused;
    static const long long counts[] = {32, 50, 100, 200, 500, 1000, 1023, 1024, 1025, 20000};
    for (size_t k = 0; k < sizeof counts / sizeof counts[0]; k++) {
        calibration c = calibrate(white, 0, 0, counts[k], 400);
        check_near(c.within, 0.68, 0.06);
        check_near(c.mean_square * (double)counts[k], 1, 0.15);
        assert_true(c.chi_square < (counts[k] < 100 ? 2 : 1.5)); /* Student's tails */
    }
}

/* Repeating values: the true error is within the stated one for any length of the run, and both fall like
 * 1/n. */
static void periodic_series(void **unused) {
    (void)unused;
    static const int periods[] = {2, 3, 4, 5, 6, 7, 8, 12, 16, 64};
    for (size_t p = 0; p < sizeof periods / sizeof periods[0]; p++) {
        saltus_average average = {0};
        double values[64], mean = 0, largest = 0;
        uint64_t random = 7 + p;
        for (int k = 0; k < periods[p]; k++)
            mean += (values[k] = normal(&random)) / periods[p];
        for (int k = 0; k < periods[p]; k++)
            largest = fmax(largest, fabs(values[k] - mean));
        for (long long n = 1; n <= 20000; n++) {
            saltus_average_add(&average, values[n % periods[p]]);
            if (n % 97 != 0 && (n & (n - 1)) > 1 && n < 19990)
                continue;
            saltus_estimate estimate = saltus_average_estimate(&average);
            if (n < 8 * periods[p] || n < 16)
                continue;
            check_near(estimate.mean, mean, 3 * estimate.standard_error + 1e-14);
            check_near(estimate.standard_error, 0, 4 * largest * periods[p] / (double)n);
        }
    }
}

/* Rotation on a circle: a smooth function, and one with a corner. */
static void quasi_periodic_series(void **unused) {
    (void)unused;
    const double golden = (sqrt(5) - 1) / 2,
                 rotations[] = {golden, M_SQRT2 - 1, golden / 10, 0.5 - golden / 50};
    for (int corner = 0; corner < 2; corner++)
        for (int r = 0; r < 4; r++)
            for (int begin = 0; begin < 10; begin++) {
                saltus_average average = {0};
                for (long long n = 1; n <= 20000; n++) {
                    double turn = fmod(rotations[r] * (double)n + 0.1 * begin, 1) * M_PI;
                    saltus_average_add(&average, corner ? fabs(sin(turn)) - 2 / M_PI
                                                        : cos(2 * turn) + 0.3 * cos(6 * turn + 1));
                    if (n % 1000 != 0 && n != 300)
                        continue;
                    saltus_estimate estimate = saltus_average_estimate(&average);
                    check_near(estimate.mean, 0, 3 * estimate.standard_error + 1e-13);
                    check_near(estimate.standard_error, 0, 100 / (double)n);
                }
            }
}

static void constant_series(void **unused) {
    (void)unused;
    static const double values[] = {0, 0.1, -1e100, 1e-100};
    for (int v = 0; v < 4; v++) {
        saltus_average average = {0};
        for (int n = 1; n <= 5000; n++) {
            saltus_average_add(&average, values[v]);
            if (n < 16 || n % 31 != 0)
                continue;
            saltus_estimate estimate = saltus_average_estimate(&average);
            check_near(estimate.mean, values[v], 1e-13 * fabs(values[v]));
            check_near(estimate.standard_error, 0, 1e-13 * fabs(values[v]));
            assert_int_equal(estimate.count, average.size * average.batches);
        }
    }
}

/* Fewer than 16 values have no error, no values have no mean. */
static void short_series(void **unused) {
    (void)unused;
    saltus_average average = {0};
    saltus_estimate estimate = saltus_average_estimate(&average);
    assert_true(!(estimate.standard_error < INFINITY));
    assert_int_equal(estimate.count, 0);
    for (int n = 1; n < 16; n++) {
        saltus_average_add(&average, n);
        estimate = saltus_average_estimate(&average);
        check_near(estimate.mean, 0.5 * (n + 1), 1e-15 * n);
        assert_true(estimate.standard_error == INFINITY && estimate.independent == 0);
    }
    saltus_average_add(&average, 16);
    assert_true(isfinite(saltus_average_estimate(&average).standard_error));
}

/* One value in 10240 determines the mean: the error shows it. */
static void one_outlier(void **unused) {
    (void)unused;
    enum { count = 10240 };
    for (int at = 0; at < count; at += 1137) {
        saltus_average average = {0};
        uint64_t random = 5;
        for (int n = 0; n < count; n++)
            saltus_average_add(&average, n == at ? 1e6 : normal(&random));
        saltus_estimate estimate = saltus_average_estimate(&average);
        check_near(estimate.mean, 1e6 / count, 0.1);
        assert_true(estimate.standard_error > 0.4e6 / count && estimate.standard_error < 2e6 / count);
    }
}

/* Sums of whole numbers are exact: none is lost or counted twice as batches double. The mean is that of the
 * complete batches, which lack at most one value in 512. */
static void batches_double(void **unused) {
    (void)unused;
    enum { longest = 70000 };
    static const long long around[] = {1023, 1024, 1025, 2047, 2048, 2049, 4096, 16383, 16384, 65535, 65536};
    double *sums = calloc(longest + 1, sizeof *sums);
    saltus_average average = {0};
    uint64_t random = 3;
    assert_non_null(sums);
    for (long long n = 1, next = 0; n <= longest; n++) {
        double value = (double)(next_word(&random) >> 44) - 524288;
        sums[n] = sums[n - 1] + value;
        saltus_average_add(&average, value);
        if (n % 1009 != 0 && (next >= 11 || n != around[next]))
            continue;
        next += next < 11 && n == around[next];
        saltus_estimate estimate = saltus_average_plain(&average);
        assert_int_equal(average.count, n);
        assert_int_equal(average.size * average.batches + average.open, n);
        assert_true(average.batches < SALTUS_AVERAGE_BATCHES && average.open < average.size);
        assert_true(estimate.count <= n && estimate.count >= n - n / 512);
        check_near(estimate.mean * (double)estimate.count, sums[estimate.count], 1e-8 * (double)n);
    }
    free(sums);
}

/* Parts of a run, and several runs together. */
static void parts_and_joins(void **unused) {
    (void)unused;
    saltus_average average = {0};
    series s = begin_series(white, 0, 1);
    double first = 0, second = 0;
    for (int n = 0; n < 8192; n++) {
        double value = next_value(&s) + (n < 4096 ? 0 : 10);
        *(n < 4096 ? &first : &second) += value / 4096;
        saltus_average_add(&average, value);
    }
    saltus_estimate part[2] = {saltus_average_part(&average, 0, 0.5), saltus_average_part(&average, 0.5, 1)};
    assert_int_equal(part[0].count, 4096);
    assert_int_equal(part[1].count, 4096);
    check_near(part[0].mean, first, 1e-13);
    check_near(part[1].mean, second, 1e-13);
    check_near(part[0].standard_error, 1 / 64.0, 0.25 / 64);
    assert_true(saltus_average_estimate(&average).standard_error > 1); /* a step in the middle is not noise */
    saltus_estimate joint = saltus_estimates_join(part, 2);
    check_near(joint.mean, 0.5 * (first + second), 1e-13);
    check_near(joint.standard_error, 0.5 * hypot(part[0].standard_error, part[1].standard_error), 1e-15);
    assert_int_equal(joint.count, 8192);
}

/* The number of independent values: all of white noise, (1 - a) / (1 + a) of them of an autoregression,
 * wherever the values lie; unknown for a part of a run. */
static void independent_values(void **unused) {
    (void)unused;
    static const double correlations[] = {0, 0.5, 0.9};
    enum { count = 20000 };
    for (int k = 0; k < 3; k++)
        for (int far = 0; far <= 1; far++) {
            saltus_average average = {0};
            series s = begin_series(autoregressive, correlations[k], 1);
            double a = correlations[k], sum = 0, squares = 0;
            for (int n = 0; n < count; n++) {
                double value = next_value(&s) * 3;
                sum += value;
                squares += value * value;
                saltus_average_add(&average, value + (far ? 1e4 : 0));
            }
            saltus_estimate estimate = saltus_average_plain(&average);
            double variance = squares / count - sum / count * (sum / count);
            check_near(estimate.independent / count * (1 + a) / (1 - a), 1, 0.25);
            check_near(estimate.independent * estimate.standard_error * estimate.standard_error, variance,
                       2e-2 * variance);
            assert_false(estimate.regular || estimate.weighted);
            assert_true(saltus_average_part(&average, 0, 0.5).independent == 0);
        }
}

/* Plain means can be joined, and so can weighted ones; a mean is weighted from 128 values on. */
static void means_of_one_kind_add_up(void **unused) {
    (void)unused;
    saltus_average one = {0}, other = {0}, both = {0};
    uint64_t random = 11;
    for (int n = 1; n <= 20000; n++) {
        double x = normal(&random), y = cos(2 * M_PI * 0.6180339887 * n + 1);
        saltus_average_add(&one, x);
        saltus_average_add(&other, y);
        saltus_average_add(&both, x + y);
        if (n != 127 && n != 128 && n != 20000)
            continue;
        saltus_estimate plain = saltus_average_plain(&both), weighted = saltus_average_weighted(&both);
        assert_false(plain.weighted);
        assert_int_equal(weighted.weighted, n >= 128);
        check_near(plain.mean, saltus_average_plain(&one).mean + saltus_average_plain(&other).mean, 1e-14);
        check_near(weighted.mean, saltus_average_weighted(&one).mean + saltus_average_weighted(&other).mean,
                   1e-14);
        assert_int_equal(weighted.mean != plain.mean, n >= 128);
    }
    /* Rotation on a circle is regular, and better served by the weighted mean. */
    saltus_estimate best = saltus_average_estimate(&other), plain = saltus_average_plain(&other);
    assert_true(best.regular && best.weighted && plain.regular);
    assert_true(fabs(best.mean) < 1e-3 * fabs(plain.mean) && best.standard_error < plain.standard_error);
    check_near(plain.mean, 0, plain.standard_error);
    assert_false(saltus_average_estimate(&one).weighted || saltus_average_estimate(&one).regular);
}

/* +1 and -1 alternate at random times: sums stay bounded, but over stretches longer than any correlation
 * considered, so their standard error is far too large. */
static void add_alternations(saltus_average *average, double rate, uint64_t random) {
    double sign = 1;
    for (int n = 0; n < 1000; n++) {
        bool now = uniform(&random) < rate;
        saltus_average_add(average, now ? sign : 0);
        sign = now ? -sign : sign;
    }
}

/* The weighted mean is not used if its parts disagree by more than the plain mean's error, for bounded and
 * for unbounded sums. The mean used is as accurate as stated. */
static void the_better_mean_is_taken(void **unused) {
    (void)unused;
    int better = 0, worse = 0;
    for (int kind = 0; kind < 3; kind++)
        for (int seed = 0; seed < 40; seed++) {
            saltus_average average = {0};
            uint64_t random = 77 * (uint64_t)seed + 1;
            if (kind == 0)
                add_alternations(&average, 4e-3 * (1 + seed % 8), random);
            else
                for (int n = 0; n < 1000; n++)
                    saltus_average_add(&average,
                                       kind == 1 ? cos((0.5 + 0.06 * seed) * n + seed) : normal(&random));
            saltus_estimate taken = saltus_average_estimate(&average), plain = saltus_average_plain(&average),
                            weighted = saltus_average_weighted(&average), other = plain;
            if (taken.weighted)
                other = weighted;
            assert_true(taken.mean == other.mean && taken.standard_error == other.standard_error);
            assert_true(taken.regular == plain.regular);
            if (weighted.standard_error >= plain.standard_error)
                assert_false(taken.weighted);
            check_near(taken.mean, 0, 4 * taken.standard_error);
            better += taken.weighted;
            worse += kind == 0 && weighted.standard_error >= plain.standard_error;
        }
    assert_true(better >= 8 && worse >= 20);
}

/* Parts consist of whole batches; with fewer than 16 there is a mean and no error. */
static void parts_are_whole_batches(void **unused) {
    (void)unused;
    static const double cuts[] = {0.01, 0.1, 0.33, 0.5, 0.99};
    saltus_average average = {0};
    uint64_t random = 9;
    for (int n = 1; n <= 3000; n++) {
        saltus_average_add(&average, normal(&random));
        if (n != 40 && n != 1023 && n != 3000)
            continue;
        saltus_estimate all = saltus_average_part(&average, 0, 1), whole = saltus_average_estimate(&average);
        assert_true(all.mean == whole.mean && all.standard_error == whole.standard_error);
        assert_true(all.count == whole.count && all.independent == 0);
        for (int k = 0; k < 5; k++) {
            saltus_estimate parts[2] = {saltus_average_part(&average, 0, cuts[k]),
                                        saltus_average_part(&average, cuts[k], 1)};
            double sum = 0;
            assert_int_equal(parts[0].count + parts[1].count, average.size * average.batches);
            for (int p = 0; p < 2; p++) {
                long long batches = parts[p].count / average.size;
                assert_int_equal(parts[p].count % average.size, 0);
                check_near((double)batches, (p ? 1 - cuts[k] : cuts[k]) * average.batches, 1);
                assert_true(parts[p].independent == 0);
                assert_true((parts[p].standard_error == INFINITY) == (batches < 16));
                sum += parts[p].weighted ? NAN : parts[p].mean * (double)parts[p].count;
            }
            check_near(sum, saltus_average_plain(&average).mean * (double)all.count, 1e-9);
        }
    }
}

/* Joining a single run gives that run. */
static void one_run_is_itself(void **unused) {
    (void)unused;
    for (int regular = 0; regular < 2; regular++) {
        saltus_average average = {0};
        uint64_t random = 4;
        for (int n = 0; n < 500; n++)
            saltus_average_add(&average, regular ? cos(n) : normal(&random));
        saltus_estimate one = saltus_average_estimate(&average), joint = saltus_estimates_join(&one, 1);
        assert_true(joint.mean == one.mean && joint.independent == one.independent);
        check_near(joint.standard_error, one.standard_error, 1e-15 * one.standard_error);
        assert_true(joint.count == one.count && joint.regular == one.regular &&
                    joint.weighted == one.weighted && one.regular == regular);
    }
}

/* Errors of regular runs are bounds: the joint one is their mean; errors of others fall with the number of
 * runs. All else adds up, and a property holds for all only if it holds for each. */
static void runs_join(void **unused) {
    (void)unused;
    for (int mask = 0; mask < 16; mask++) {
        saltus_estimate e[2] = {{.mean = 1, .standard_error = 3, .independent = 5, .count = 7},
                                {.mean = 2, .standard_error = 4, .independent = 6, .count = 8}};
        for (int k = 0; k < 2; k++) {
            e[k].regular = mask >> k & 1;
            e[k].weighted = mask >> (2 + k) & 1;
        }
        saltus_estimate joint = saltus_estimates_join(e, 2);
        bool bounds = (mask & 3) == 3 || (mask & 12) == 12;
        check_near(joint.mean, 1.5, 1e-15);
        check_near(joint.standard_error, bounds ? 3.5 : 2.5, 1e-14);
        assert_true(joint.independent == 11 && joint.count == 15);
        assert_int_equal(joint.regular, (mask & 3) == 3);
        assert_int_equal(joint.weighted, (mask & 12) == 12);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chaotic_maps),
        cmocka_unit_test(logistic_map_at_four),
        cmocka_unit_test(correlated_noise),
        cmocka_unit_test(white_noise),
        cmocka_unit_test(periodic_series),
        cmocka_unit_test(quasi_periodic_series),
        cmocka_unit_test(constant_series),
        cmocka_unit_test(short_series),
        cmocka_unit_test(one_outlier),
        cmocka_unit_test(batches_double),
        cmocka_unit_test(parts_and_joins),
        cmocka_unit_test(parts_are_whole_batches),
        cmocka_unit_test(one_run_is_itself),
        cmocka_unit_test(independent_values),
        cmocka_unit_test(means_of_one_kind_add_up),
        cmocka_unit_test(the_better_mean_is_taken),
        cmocka_unit_test(runs_join),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
