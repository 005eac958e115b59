/* Independent tests of chaos: the 0-1 test, the correlation dimension and closed curves, on known sets.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "allocations.h"
#include "check.h"

#include <gsl/gsl_fit.h>
#include <gsl/gsl_math.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics_double.h>

static const double golden = 0.6180339887498949;
static const double feigenbaum = 3.569945671870944901842; /* where the logistic map's doublings accumulate */

static long allocations, failing = -1;

static bool refuse(void) {
    return ++allocations == failing;
}

/* Points to fill, count x dimension, with a random generator for those that need it. */
typedef struct sample {
    double *values;
    long long count;
    int dimension;
    gsl_rng *rng;
} sample;

typedef void filler(sample *s);

static sample make(filler *fill, long long count, int dimension) {
    sample s = {.count = count, .dimension = dimension, .rng = gsl_rng_alloc(gsl_rng_taus2)};
    s.values = malloc((size_t)count * (size_t)dimension * sizeof *s.values);
    assert_true(s.values && s.rng);
    gsl_rng_set(s.rng, 7);
    fill(&s);
    return s;
}

static void drop(sample *s) {
    free(s->values);
    gsl_rng_free(s->rng);
}

static double *point(const sample *s, long long i) {
    return s->values + i * s->dimension;
}

/* Closed curves, turned through by the golden section. */

static void circle(sample *s) {
    for (long long i = 0; i < s->count; i++) {
        point(s, i)[0] = cos(2 * M_PI * golden * (double)i);
        point(s, i)[1] = sin(2 * M_PI * golden * (double)i);
    }
}

static void ellipse(sample *s) {
    for (long long i = 0; i < s->count; i++)
        for (int k = 0; k < s->dimension; k++)
            point(s, i)[k] = 0.1 * (k + 1) * cos(2 * M_PI * golden * (double)i) +
                             0.3 * cos(3.0 * k) * sin(2 * M_PI * golden * (double)i);
}

static void wiggles(sample *s) {
    for (long long i = 0; i < s->count; i++) {
        double a = 2 * M_PI * golden * (double)i;
        point(s, i)[0] = cos(a) + 0.3 * cos(3 * a + 1);
        point(s, i)[1] = sin(a) + 0.2 * sin(5 * a);
        point(s, i)[2] = 0.5 * cos(2 * a) + 0.1 * sin(7 * a);
        point(s, i)[3] = 0.3 * sin(4 * a);
    }
}

static void corner(sample *s) {
    for (long long i = 0; i < s->count; i++) {
        double a = fmod(golden * (double)i, 1), r = 1 + 0.5 * fabs(a - 0.5);
        point(s, i)[0] = r * cos(2 * M_PI * a);
        point(s, i)[1] = r * sin(2 * M_PI * a);
    }
}

static void triangle(sample *s) {
    static const double tip[4][2] = {{0, 0}, {1, 0}, {0.1, 0.2}, {0, 0}};
    for (long long i = 0; i < s->count; i++) {
        double a = 3 * fmod(golden * (double)i, 1), part = a - floor(a);
        for (int k = 0; k < 2; k++)
            point(s, i)[k] = (1 - part) * tip[(int)a][k] + part * tip[(int)a + 1][k];
    }
}

static void curves_in_turn(sample *s, int curves) {
    for (long long i = 0; i < s->count; i++) {
        double a = 2 * M_PI * golden * (double)i, k = (double)(i % curves);
        point(s, i)[0] = (1 - 0.2 * k) * cos(a) + 4 * k;
        point(s, i)[1] = (1 + 0.3 * k) * sin(a) + k * k;
    }
}

static void two_curves(sample *s) {
    curves_in_turn(s, 2);
}

static void three_curves(sample *s) {
    curves_in_turn(s, 3);
}

/* A circle map just before it becomes non-invertible, and the closed curve of the delayed logistic map. */
static void circle_map(sample *s) {
    double x = 0.1;
    for (long long i = 0; i < s->count; i++) {
        x += 0.61 - 0.9 / (2 * M_PI) * sin(2 * M_PI * x);
        point(s, i)[0] = cos(2 * M_PI * x);
        if (s->dimension > 1)
            point(s, i)[1] = sin(2 * M_PI * x);
    }
}

static void delayed_logistic(sample *s) {
    double x = 0.3, y = 0.3;
    for (long long i = -20000; i < s->count; i++) {
        double next = 2.02 * x * (1 - y);
        y = x;
        x = next;
        if (i >= 0) {
            point(s, i)[0] = x;
            point(s, i)[1] = y;
        }
    }
}

/* Sets that are no closed curves. */

static void noisy_circle(sample *s) {
    circle(s);
    for (long long i = 0; i < s->count * s->dimension; i++)
        s->values[i] += gsl_ran_gaussian(s->rng, 0.01);
}

static void cube(sample *s) {
    for (long long i = 0; i < s->count * s->dimension; i++)
        s->values[i] = gsl_rng_uniform(s->rng);
}

static void gaussian(sample *s) {
    for (long long i = 0; i < s->count * s->dimension; i++)
        s->values[i] = gsl_ran_gaussian(s->rng, 1);
}

static void torus(sample *s) {
    for (long long i = 0; i < s->count; i++) {
        double a = 2 * M_PI * M_SQRT2 * (double)i, b = 2 * M_PI * sqrt(3) * (double)i;
        point(s, i)[0] = (1 + 0.4 * cos(b)) * cos(a);
        point(s, i)[1] = (1 + 0.4 * cos(b)) * sin(a);
        point(s, i)[2] = 0.4 * sin(b);
    }
}

static void henon_from(sample *s, double x) {
    double y = 0.1;
    for (long long i = -1000; i < s->count; i++) {
        double next = 1 - 1.4 * x * x + y;
        y = 0.3 * x;
        x = next;
        if (i >= 0) {
            point(s, i)[0] = x;
            if (s->dimension > 1)
                point(s, i)[1] = y;
        }
    }
}

static void henon(sample *s) {
    henon_from(s, 0.12);
}

static void logistic(sample *s, double r, long long transient) {
    double x = 0.3;
    for (long long i = -transient; i < s->count; i++) {
        double before = x;
        x = r * x * (1 - x);
        if (i >= 0) {
            point(s, i)[0] = x;
            if (s->dimension > 1)
                point(s, i)[1] = before;
        }
    }
}

static void logistic_full(sample *s) {
    logistic(s, 4, 10);
}

static void logistic_band(sample *s) {
    logistic(s, 3.6, 1000);
}

static void logistic_accumulation(sample *s) {
    logistic(s, feigenbaum, 30000);
}

static void standard_map(sample *s) {
    double q = 0.5, p = 1;
    for (long long i = 0; i < s->count; i++) {
        p = fmod(p + 6 * sin(q), 2 * M_PI);
        q = fmod(q + p, 2 * M_PI);
        point(s, i)[0] = cos(q);
        if (s->dimension > 1)
            point(s, i)[1] = sin(q);
    }
}

static void periodic(sample *s, int period) {
    for (long long i = 0; i < s->count; i++) {
        double a = 2 * M_PI * (double)(i % period) / period;
        point(s, i)[0] = cos(a) + gsl_ran_gaussian(s->rng, 1e-12);
        point(s, i)[1] = sin(a);
    }
}

static void period_6(sample *s) {
    periodic(s, 6);
}

static void period_64(sample *s) {
    periodic(s, 64);
}

static void fixed_point(sample *s) {
    for (long long i = 0; i < s->count * s->dimension; i++)
        s->values[i] = 3 + gsl_ran_gaussian(s->rng, 1e-12);
}

/* Spirals and lines into a fixed point. */
static void spiral_in(sample *s) {
    for (long long i = 0; i < s->count; i++) {
        point(s, i)[0] = exp(-1e-3 * (double)i) * cos(0.7 * (double)i);
        point(s, i)[1] = exp(-1e-3 * (double)i) * sin(0.7 * (double)i);
    }
}

static void creep_in(sample *s) {
    for (long long i = 0; i < s->count; i++) {
        point(s, i)[0] = exp(-1e-3 * (double)i);
        point(s, i)[1] = exp(-2e-3 * (double)i);
    }
}

static saltus_series_points points_of(const sample *s) {
    return (saltus_series_points){.values = s->values, .count = s->count, .dimension = s->dimension};
}

/* The 0-1 test. */

static saltus_series_chaos judge_series(const double *series, long long count) {
    saltus_series_options options = saltus_series_defaults();
    saltus_series_chaos chaos;
    saltus_message message = {.text = ""};
    check_ok(saltus_series_chaos_test(series, count, &options, &chaos, &message), &message);
    assert_true(chaos.lower <= chaos.k && chaos.k <= chaos.upper);
    return chaos;
}

static void check_growth(filler *fill, double least, double most) {
    sample s = make(fill, 2000, 1);
    saltus_series_chaos chaos = judge_series(s.values, s.count);
    assert_false(chaos.constant);
    if (!(chaos.k > least && chaos.k < most))
        fail_msg("K = %g should be between %g and %g", chaos.k, least, most);
    drop(&s);
}

static void logistic_350(sample *s) {
    logistic(s, 3.5, 2000);
}

static void logistic_355(sample *s) {
    logistic(s, 3.55, 2000);
}

static void logistic_397(sample *s) {
    logistic(s, 3.97, 2000);
}

static void rotation(sample *s) {
    double x = 0.1;
    for (long long i = 0; i < s->count; i++) {
        x += golden - 0.1 * sin(2 * M_PI * x);
        s->values[i] = sin(2 * M_PI * x);
    }
}

/* Incommensurate sines about a mean, two of them in the range of the test's angles. */
static void sines(sample *s) {
    for (long long i = 0; i < s->count; i++)
        s->values[i] = 5 + sin(M_SQRT2 * (double)i) + 0.5 * sin(2 * M_PI * golden * (double)i) +
                       0.3 * cos(sqrt(3) * (double)i);
}

static void bursts(sample *s) {
    for (long long i = 0; i < s->count; i++)
        s->values[i] = i % 6 == 0;
}

static void regular_and_chaotic_series(void **unused) {
    (void)unused;
    check_growth(logistic_350, -0.1, 0.1);
    check_growth(logistic_355, -0.1, 0.1);
    check_growth(logistic_accumulation, -0.1, 0.1);
    check_growth(rotation, -0.1, 0.1);
    check_growth(sines, -0.1, 0.1);
    check_growth(bursts, -0.1, 0.1);
    check_growth(logistic_397, 0.95, 1);
    check_growth(logistic_band, 0.95, 1);
    check_growth(standard_map, 0.95, 1);
    check_growth(henon, 0.95, 1);
    check_growth(gaussian, 0.95, 1);
}

/* Correlation with n of M(n) - V_osc(n), from the definitions. */
static double growth_by_definition(const double *series, long long count, double c) {
    enum { steps_max = 200 };
    double n_of[steps_max], d[steps_max], mean = gsl_stats_mean(series, 1, (size_t)count);
    double *p = calloc((size_t)count, sizeof *p), *q = calloc((size_t)count, sizeof *q);
    long long steps = count / 10, starts = count - steps;
    assert_true(p && q && steps <= steps_max);
    for (long long j = 0; j < count; j++) {
        p[j] = (j ? p[j - 1] : 0) + series[j] * cos((double)(j + 1) * c);
        q[j] = (j ? q[j - 1] : 0) + series[j] * sin((double)(j + 1) * c);
    }
    for (long long n = 1; n <= steps; n++) {
        double sum = 0;
        for (long long j = 0; j < starts; j++)
            sum += gsl_pow_2(p[j + n] - p[j]) + gsl_pow_2(q[j + n] - q[j]);
        n_of[n - 1] = (double)n;
        d[n - 1] = sum / (double)starts - mean * mean * (1 - cos((double)n * c)) / (1 - cos(c));
    }
    free(p);
    free(q);
    return gsl_stats_correlation(n_of, 1, d, 1, (size_t)steps);
}

/* Without the mean there is no oscillatory term to subtract: the medians agree. */
static void agrees_with_the_definition(void **unused) {
    (void)unused;
    enum { count = 2000, angles = 60 };
    filler *fills[] = {sines, logistic_397, logistic_350, henon};
    for (size_t f = 0; f < sizeof fills / sizeof *fills; f++) {
        sample s = make(fills[f], count, 1);
        double rate[angles];
        for (int k = 0; k < angles; k++)
            rate[k] = growth_by_definition(s.values, count, M_PI / 5 * (1 + 3 * (k + 0.37) / angles));
        gsl_sort(rate, 1, angles);
        check_near(judge_series(s.values, count).k, gsl_stats_median_from_sorted_data(rate, 1, angles), 0.02);
        drop(&s);
    }
}

static void scale_and_shift_do_not_matter(void **unused) {
    (void)unused;
    filler *fills[] = {sines, logistic_397};
    for (size_t f = 0; f < sizeof fills / sizeof *fills; f++) {
        sample s = make(fills[f], 1000, 1);
        saltus_series_chaos first = judge_series(s.values, s.count);
        saltus_series_chaos again = judge_series(s.values, s.count);
        assert_true(first.k == again.k && first.lower == again.lower && first.upper == again.upper);
        for (long long i = 0; i < s.count; i++)
            s.values[i] = ldexp(s.values[i], 900);
        again = judge_series(s.values, s.count);
        check_near(again.k, first.k, 1e-9);
        for (long long i = 0; i < s.count; i++)
            s.values[i] = -7e-5 * ldexp(s.values[i], -900) + 2;
        again = judge_series(s.values, s.count);
        check_near(again.k, first.k, 1e-6);
        check_near(again.lower, first.lower, 1e-6);
        drop(&s);
    }
}

static void seeds_give_other_angles(void **unused) {
    (void)unused;
    sample s = make(logistic_397, 1000, 1);
    saltus_series_options options = saltus_series_defaults();
    saltus_series_chaos first, second;
    saltus_message message = {.text = ""};
    check_ok(saltus_series_chaos_test(s.values, s.count, &options, &first, &message), &message);
    options.seed = 2;
    check_ok(saltus_series_chaos_test(s.values, s.count, &options, &second, &message), &message);
    assert_true(first.k != second.k);
    check_near(first.k, second.k, 0.01);
    drop(&s);
}

static void constant_series(void **unused) {
    (void)unused;
    sample s = make(fixed_point, 1000, 1);
    saltus_series_chaos chaos = judge_series(s.values, s.count);
    assert_true(chaos.constant && chaos.k == 0 && chaos.lower == 0 && chaos.upper == 0);
    memset(s.values, 0, (size_t)s.count * sizeof *s.values);
    chaos = judge_series(s.values, s.count);
    assert_true(chaos.constant && chaos.k == 0);
    drop(&s);
}

/* A series so long that the test skips steps. */
static void long_series(void **unused) {
    (void)unused;
    saltus_series_options options = saltus_series_defaults();
    saltus_series_chaos chaos;
    saltus_message message = {.text = ""};
    options.frequencies = 5;
    sample s = make(sines, 15000, 1), c = make(logistic_397, 15000, 1);
    check_ok(saltus_series_chaos_test(s.values, s.count, &options, &chaos, &message), &message);
    check_near(chaos.k, 0, 0.1);
    check_ok(saltus_series_chaos_test(c.values, c.count, &options, &chaos, &message), &message);
    check_near(chaos.k, 1, 0.05);
    drop(&s);
    drop(&c);
}

/* The correlation dimension. */

static saltus_series_dimension measure(const sample *s, const saltus_series_options *options) {
    saltus_series_options defaults = saltus_series_defaults();
    saltus_series_points points = points_of(s);
    saltus_series_dimension dimension;
    saltus_message message = {.text = ""};
    check_ok(
        saltus_series_correlation_dimension(&points, options ? options : &defaults, &dimension, &message),
        &message);
    return dimension;
}

static void known_dimensions(void **unused) {
    (void)unused;
    static const struct {
        filler *fill;
        int dimension;
        double expected, tolerance;
        bool decade;
    } cases[] = {
        {circle, 2, 1, 0.05, true},
        {ellipse, 10, 1, 0.05, true},
        {wiggles, 4, 1, 0.05, true},
        {corner, 2, 1, 0.05, true},
        {two_curves, 2, 1, 0.05, true},
        {circle_map, 2, 1, 0.05, true},
        {cube, 2, 2, 0.1, true},
        {cube, 3, 3, 0.15, true},
        {torus, 3, 2, 0.1, false},
        {henon, 2, 1.22, 0.06, true},
        {logistic_accumulation, 1, 0.4976, 0.03, true},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        sample s = make(cases[k].fill, 4000, cases[k].dimension);
        saltus_series_dimension d = measure(&s, NULL);
        check_near(d.dimension, cases[k].expected, cases[k].tolerance);
        check_near(d.dimension, cases[k].expected, 1.5 * d.error);
        check_near(d.error, fmax(hypot(d.sampling, d.variation), d.drift), 1e-15);
        assert_true(hypot(d.sampling, d.variation) < 0.15 && d.drift < 0.25 && d.sampling > 0 &&
                    d.distinct == 0);
        assert_true(d.decade == cases[k].decade && d.decade == (d.radius[1] > 9.99 * d.radius[0]));
        assert_true(d.within > 0 && d.within < d.pairs && d.pairs <= 4000 * 3999 / 2);
        drop(&s);
    }
}

/* The density's poles make C(r) behave like r log r: the slope is a tenth too small at any radius, which the
 * error covers. */
static void logistic_map_fills_the_interval(void **unused) {
    (void)unused;
    static const long long counts[] = {2000, 4000, 16000};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        sample s = make(logistic_full, counts[k], 1);
        saltus_series_dimension d = measure(&s, NULL);
        check_near(d.dimension, 1, 0.15);
        check_near(d.dimension, 1, 1.5 * d.error);
        assert_true(d.error < 0.3);
        drop(&s);
    }
}

/* Literature: 1.21 to 1.22. More points give a sharper value, within the error of fewer. */
static void henon_attractor(void **unused) {
    (void)unused;
    enum { runs = 5 };
    double squares = 0;
    saltus_series_options options = saltus_series_defaults();
    options.pairs = 10000000;
    sample s = make(henon, 50000, 2);
    saltus_series_dimension d = measure(&s, &options);
    check_near(d.dimension, 1.22, 0.02);
    check_near(d.sampling, 0.005, 0.005);
    s.count = 4000;
    for (int k = 0; k < runs; k++) {
        henon_from(&s, 0.1 + 0.01 * k);
        d = measure(&s, NULL);
        squares += gsl_pow_2((d.dimension - 1.22) / d.error) / runs;
    }
    assert_true(squares < gsl_pow_2(1.5));
    drop(&s);
}

static void points_that_recur(void **unused) {
    (void)unused;
    sample s = make(period_6, 4000, 2);
    saltus_series_dimension d = measure(&s, NULL);
    assert_true(d.dimension == 0 && d.error == 0 && d.distinct == 6);
    drop(&s);
    s = make(period_64, 1000, 2);
    d = measure(&s, NULL);
    assert_true(d.dimension == 0 && d.error == 0);
    check_near((double)d.distinct, 64, 3);
    drop(&s);
    s = make(fixed_point, 1000, 3);
    d = measure(&s, NULL);
    assert_true(d.dimension == 0 && d.error == 0 && d.distinct == 1);
    memset(s.values, 0, 3000 * sizeof *s.values);
    assert_true(measure(&s, NULL).distinct == 1);
    drop(&s);
}

/* From far away the curves are two points; the plateau between must not count. Noise does. */
static void finest_scale_counts(void **unused) {
    (void)unused;
    sample s = make(two_curves, 4000, 2);
    for (long long i = 0; i < s.count; i++)
        point(&s, i)[0] += 1000.0 * (double)(i % 2);
    check_near(measure(&s, NULL).dimension, 1, 0.05);
    drop(&s);
    s = make(noisy_circle, 4000, 2);
    check_near(measure(&s, NULL).dimension, 2, 0.15);
    drop(&s);
}

/* A circle in the plane with ever less noise: as long as a decade of radii below the noise has enough pairs,
 * its dimension two counts, however much more accurate that of the circle is. */
static void noise_below_a_curve_counts(void **unused) {
    (void)unused;
    sample s = make(circle, 4000, 2);
    for (double noise = 4e-3; noise > 9e-4; noise /= 2) {
        circle(&s);
        for (long long i = 0; i < s.count * s.dimension; i++)
            s.values[i] += gsl_ran_gaussian(s.rng, noise);
        saltus_series_dimension d = measure(&s, NULL);
        assert_true(d.decade && d.radius[1] < 5 * noise);
        check_near(d.dimension, 2, 1.5 * d.error);
        assert_true(d.dimension > 1.7 && d.error < 0.3);
    }
    drop(&s);
}

/* Few points in many dimensions have no decade of radii: a shorter range is reported as such, and holds with
 * its error. More points give a longer range; if even the shortest lacks pairs there is no answer. */
static void few_points_have_short_ranges(void **unused) {
    (void)unused;
    int decades = 0, answers = 0;
    for (int dimension = 1; dimension <= 8; dimension += dimension < 4 ? 1 : 2) {
        double length = 0;
        for (int count = 200; count <= 800; count *= 2) {
            sample s = make(gaussian, count, dimension);
            saltus_series_points points = points_of(&s);
            saltus_series_options options = saltus_series_defaults();
            saltus_series_dimension d;
            saltus_status status = saltus_series_correlation_dimension(&points, &options, &d, NULL);
            drop(&s);
            if (status != SALTUS_OK) {
                assert_int_equal(status, SALTUS_NO_CONVERGENCE);
                assert_true(dimension > 3 && length == 0 && d.dimension == 0 && !d.decade);
                continue;
            }
            double longer = d.radius[1] / d.radius[0];
            assert_true(longer >= 2 && longer >= length * (1 - 1e-9));
            assert_int_equal(d.decade, longer > 10 * (1 - 1e-9));
            assert_true(count < 800 || dimension > 4 || longer > 4 * (1 - 1e-9));
            assert_true(20 * d.within <= d.pairs && d.within >= 32);
            check_near(d.dimension, dimension, 0.1 * dimension + d.error);
            length = longer;
            decades += d.decade;
            answers++;
        }
    }
    assert_true(decades >= 3 && answers >= decades + 8);
}

/* Scaled components with inverse weights are the same set, to rounding. */
static void weights_undo_scales(void **unused) {
    (void)unused;
    static const double weights[2] = {0.125, 1 / 3.0};
    sample s = make(henon, 4000, 2);
    saltus_series_options options = saltus_series_defaults();
    saltus_series_dimension d = measure(&s, NULL), again = measure(&s, NULL), scaled;
    saltus_message message = {.text = ""};
    assert_true(d.dimension == again.dimension && d.error == again.error);
    for (long long i = 0; i < s.count; i++) {
        point(&s, i)[0] = 8 * point(&s, i)[0];
        point(&s, i)[1] = 3 * point(&s, i)[1];
    }
    saltus_series_points points = points_of(&s);
    points.weights = weights;
    check_ok(saltus_series_correlation_dimension(&points, &options, &scaled, &message), &message);
    check_near(scaled.dimension, d.dimension, 1e-3);
    check_near(scaled.radius[1], d.radius[1], 1e-9);
    drop(&s);
}

/* Random pairs give what all pairs give, and are chosen by the seed. */
static void drawn_pairs(void **unused) {
    (void)unused;
    sample s = make(henon, 4000, 2);
    saltus_series_options options = saltus_series_defaults();
    saltus_series_dimension all = measure(&s, NULL);
    options.pairs = 4000000;
    saltus_series_dimension some = measure(&s, &options);
    assert_true(some.pairs < 4000000 && some.pairs > 3980000);
    check_near(some.dimension, all.dimension, 0.03);
    options.seed = 2;
    assert_true(measure(&s, &options).dimension != some.dimension);
    drop(&s);
}

/* Ten dimensions are too many for so few points; the result says so. */
static void ceiling_is_told(void **unused) {
    (void)unused;
    sample s = make(gaussian, 4000, 10);
    saltus_series_dimension d = measure(&s, NULL);
    check_near(d.ceiling, 2 * log10(4000), 1e-12);
    assert_true(d.dimension > d.ceiling && !d.decade);
    drop(&s);
    saltus_series_options options = saltus_series_defaults();
    saltus_message message = {.text = ""};
    s = make(gaussian, SALTUS_SERIES_LEAST, 100);
    saltus_series_points points = points_of(&s);
    for (int k = 0; k < 100; k++) /* few points with distinct distances: no radius has enough pairs */
        point(&s, 0)[k] *= 1e6;
    saltus_status status = saltus_series_correlation_dimension(&points, &options, &d, &message);
    assert_true(status == SALTUS_NO_CONVERGENCE || (status == SALTUS_OK && !d.decade));
    drop(&s);
}

/* On a slow rotation points close in time are close in space: the chosen window grows with its period. */
static void window_follows_the_motion(void **unused) {
    (void)unused;
    sample s = make(circle, 4000, 2);
    assert_true(measure(&s, NULL).window < 10);
    for (long long i = 0; i < s.count; i++) {
        point(&s, i)[0] = cos(0.011234 * (double)i);
        point(&s, i)[1] = sin(0.011234 * (double)i);
    }
    saltus_series_dimension d = measure(&s, NULL);
    check_near((double)d.window, 3 * acos(exp(-1)) / 0.011234, 10);
    check_near(d.dimension, 1, 0.05);
    saltus_series_options options = saltus_series_defaults();
    options.window = 17;
    assert_true(measure(&s, &options).window == 17);
    drop(&s);
}

/* Closed curves. */

static saltus_series_curve look_at(const sample *s) {
    saltus_series_options options = saltus_series_defaults();
    saltus_series_points points = points_of(s);
    saltus_series_curve curve;
    saltus_message message = {.text = ""};
    check_ok(saltus_series_closed_curve(&points, &options, &curve, &message), &message);
    return curve;
}

static void check_curve(filler *fill, long long count, int dimension, int curves) {
    sample s = make(fill, count, dimension);
    saltus_series_curve c = look_at(&s);
    if (c.closed != (curves > 0) || c.curves != curves)
        fail_msg("%d curves instead of %d: thickness %g thinning %g kept %g balance %g ends %g", c.curves,
                 curves, c.thickness, c.thinning, c.kept, c.balance, c.ends);
    drop(&s);
}

static void curves_are_seen(void **unused) {
    (void)unused;
    static const long long counts[] = {500, 2000};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        check_curve(circle, counts[k], 2, 1);
        check_curve(ellipse, counts[k], 10, 1);
        check_curve(wiggles, counts[k], 4, 1);
        check_curve(corner, counts[k], 2, 1);
        check_curve(triangle, counts[k], 2, 1);
        check_curve(circle_map, counts[k], 2, 1);
        check_curve(delayed_logistic, counts[k], 2, 1);
        check_curve(two_curves, counts[k], 2, 2);
        check_curve(three_curves, counts[k], 2, 3);
    }
}

static void other_sets_are_none(void **unused) {
    (void)unused;
    static const long long counts[] = {500, 2000};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        check_curve(noisy_circle, counts[k], 2, 0);
        check_curve(cube, counts[k], 2, 0);
        check_curve(cube, counts[k], 3, 0);
        check_curve(gaussian, counts[k], 10, 0);
        check_curve(torus, counts[k], 3, 0);
        check_curve(henon, counts[k], 2, 0);
        check_curve(logistic_full, counts[k], 2, 0);
        check_curve(logistic_band, counts[k], 2, 0);
        check_curve(logistic_accumulation, counts[k], 2, 0);
        check_curve(standard_map, counts[k], 2, 0);
        check_curve(period_6, counts[k], 2, 0);
        check_curve(period_64, counts[k], 2, 0);
        check_curve(fixed_point, counts[k], 2, 0);
        check_curve(spiral_in, counts[k], 2, 0);
        check_curve(creep_in, counts[k], 2, 0);
    }
}

/* Which measure detects which property. */
static void measures_mean_what_they_say(void **unused) {
    (void)unused;
    sample s = make(circle, 4000, 2);
    saltus_series_curve c = look_at(&s);
    check_near(c.thinning, 2, 0.2);
    assert_true(c.thickness < 0.003 && c.kept == 1 && c.balance > 0.9 && c.ends > 0.8 && !c.recurs);
    drop(&s);
    s = make(torus, 4000, 3);
    c = look_at(&s);
    assert_true(c.thickness > 0.5 && c.kept == 1);
    drop(&s);
    s = make(logistic_full, 4000, 2);
    c = look_at(&s);
    assert_true(c.thickness < 0.01 && c.kept < 0.05);
    drop(&s);
    s = make(logistic_accumulation, 4000, 2);
    c = look_at(&s);
    assert_true(c.thickness < 0.01 && c.kept > 0.95 && c.balance < 0.57);
    drop(&s);
    s = make(creep_in, 4000, 2);
    c = look_at(&s);
    assert_true(c.thickness < 0.01 && c.kept > 0.95 && c.ends < 0.1);
    drop(&s);
    s = make(period_64, 500, 2);
    assert_true(look_at(&s).recurs);
    drop(&s);
}

/* The same by definition, on few points, all of which are used. */

static double *values_of(sample *s, double shift, double size) {
    for (long long i = 0; i < s->count * s->dimension; i++)
        s->values[i] = shift + size * s->values[i];
    return s->values;
}

static double distance(const sample *s, long long i, long long j) {
    double square = 0;
    for (int d = 0; d < s->dimension; d++)
        square += gsl_pow_2(point(s, i)[d] - point(s, j)[d]);
    return sqrt(square);
}

/* Quartiles are those of the rates, and few rates suffice. */
static void quartiles_by_definition(void **unused) {
    (void)unused;
    enum { count = 1000, angles = 300 };
    sample s = make(bursts, count, 1);
    for (int j = 0; j < count; j++) /* weak chaos with strong lines: rates are far apart */
        s.values[j] += 0.05 * sin((double)j * j * M_SQRT2);
    double rate[angles];
    for (int k = 0; k < angles; k++)
        rate[k] = growth_by_definition(s.values, count, M_PI / 5 * (1 + 3 * (k + 0.5) / angles));
    gsl_sort(rate, 1, angles);
    saltus_series_chaos chaos = judge_series(s.values, count);
    check_near(chaos.k, gsl_stats_median_from_sorted_data(rate, 1, angles), 0.03);
    check_near(chaos.lower, gsl_stats_quantile_from_sorted_data(rate, 1, angles, 0.25), 0.06);
    check_near(chaos.upper, gsl_stats_quantile_from_sorted_data(rate, 1, angles, 0.75), 0.06);
    assert_true(chaos.upper - chaos.lower > 0.05);
    drop(&s);
}

/* A spectral line in the range of angles makes the rates next to it large and leaves the others unaffected.
 * One angle is drawn from each of as many equal parts: one of them contains the line. */
static void angles_fill_their_range(void **unused) {
    (void)unused;
    enum { count = 400 };
    double series[count];
    saltus_message message = {.text = ""};
    saltus_series_options options = saltus_series_defaults();
    for (int place = 0; place < 4; place++) {
        const double at[] = {0.61, 0.9 * M_PI, 0.1 * M_PI, 2.5}; /* pi/5 = 0.628, 4 pi/5 = 2.513 */
        for (int j = 0; j < count; j++)
            series[j] = cos(at[place] * j + 0.3);
        double largest = 0;
        for (unsigned long seed = 0; seed < 8; seed++) {
            saltus_series_chaos chaos;
            options.seed = seed;
            options.frequencies = 2; /* the larger one of two rates is half their sum and difference */
            check_ok(saltus_series_chaos_test(series, count, &options, &chaos, &message), &message);
            largest = fmax(largest, chaos.k + 2 * (chaos.upper - chaos.k));
        }
        options.frequencies = 200;
        saltus_series_chaos chaos;
        check_ok(saltus_series_chaos_test(series, count, &options, &chaos, &message), &message);
        check_near(chaos.k, 0, 0.1);
        assert_true(largest <= 1 + 1e-12);
    }
}

/* A variation below the resolution, relative to the largest value, is none; slightly more counts in full. */
static void resolution_is_relative(void **unused) {
    (void)unused;
    for (int k = 0; k < 2; k++)
        for (int fine = 0; fine < 2; fine++) {
            double largest = k ? 1e7 : 1e-5;
            saltus_series_options options = saltus_series_defaults();
            saltus_series_chaos chaos;
            saltus_message message = {.text = ""};
            sample s = make(logistic_397, 1000, 1);
            values_of(&s, -largest, 1e-6 * largest);
            options.resolution = fine ? 0.8e-6 : 1.2e-6;
            options.frequencies = 10;
            check_ok(saltus_series_chaos_test(s.values, s.count, &options, &chaos, &message), &message);
            assert_true(chaos.constant == !fine);
            check_near(chaos.k, fine, fine ? 0.05 : 0);
            drop(&s);
            s = make(henon, 1000, 2);
            values_of(&s, -largest, 1e-6 * largest);
            options.resolution = fine ? 1e-9 : 4e-6;
            saltus_series_dimension d = measure(&s, &options);
            assert_true(fine ? d.distinct == 0 && d.dimension > 1 : d.distinct == 1 && d.dimension == 0);
            drop(&s);
        }
}

/* Recurrences are counted up to a distance equal to the resolution. */
static void recurring_pairs_are_counted(void **unused) {
    (void)unused;
    static const double weights[2] = {3, 5};
    sample s = make(period_6, 600, 2);
    saltus_series_options options = saltus_series_defaults();
    saltus_series_points points = points_of(&s);
    saltus_series_dimension d;
    saltus_message message = {.text = ""};
    long long same = 0, pairs = 0;
    points.weights = weights;
    options.window = 4;
    check_ok(saltus_series_correlation_dimension(&points, &options, &d, &message), &message);
    for (long long i = 0; i < s.count; i++)
        for (long long j = i + 5; j < s.count; j++, pairs++)
            same += (j - i) % 6 == 0;
    assert_int_equal(d.pairs, pairs);
    assert_int_equal(d.within, same);
    assert_int_equal(d.distinct, llround((double)pairs / (double)same));
    check_near(d.radius[1], 1e-9 * 5 * sin(M_PI / 3), 1e-13);
    drop(&s);
}

/* The pairs, those within the larger radius, the slope between the radii, and its scatter over octaves and
 * blocks of time. */
static void dimension_by_definition(void **unused) {
    (void)unused;
    enum { count = 1600, window = 3, steps = 60, blocks = 16 };
    static double pairs_within[blocks + 1][steps + 1];
    const double scale = 37;
    sample s = make(henon, count, 2);
    values_of(&s, 5, scale);
    saltus_series_options options = saltus_series_defaults();
    options.window = window;
    saltus_series_dimension d = measure(&s, &options);
    assert_int_equal(d.window, window);
    assert_int_equal(d.pairs, (count - window) * (count - window - 1) / 2);
    double step = log(d.radius[1] / d.radius[0]) / steps, slope[blocks + 1], mean = 0, square = 0;
    long long within = 0;
    memset(pairs_within, 0, sizeof pairs_within);
    for (long long i = 0; i < count; i++)
        for (long long j = i + window + 1; j < count; j++) {
            double r = distance(&s, i, j);
            within += r < d.radius[1];
            if (r >= d.radius[1])
                continue;
            int from = r > d.radius[0] ? (int)ceil(log(r / d.radius[0]) / step) : 0;
            for (int b = 0; b <= blocks; b++)
                if (b == 0 || (i * blocks / count != b - 1 && j * blocks / count != b - 1))
                    pairs_within[b][from < steps ? from : steps]++;
        }
    assert_int_equal(d.within, within);
    assert_true((double)d.within <= 0.05 * (double)d.pairs);
    for (int b = 0; b <= blocks; b++) {
        double x[steps + 1], y[steps + 1], c0, c1, cov00, cov01, cov11, rest;
        for (int k = 0; k <= steps; k++) {
            pairs_within[b][k] += k ? pairs_within[b][k - 1] : 0;
            x[k] = k * step;
            y[k] = log(pairs_within[b][k]);
        }
        gsl_fit_linear(x, 1, y, 1, steps + 1, &c0, &c1, &cov00, &cov01, &cov11, &rest);
        slope[b] = c1;
    }
    for (int b = 1; b <= blocks; b++)
        mean += slope[b] / blocks;
    for (int b = 1; b <= blocks; b++)
        square += gsl_pow_2(slope[b] - mean);
    check_near(d.dimension, slope[0], 0.02);
    check_near(d.sampling, sqrt(square * (blocks - 1) / blocks), 0.2 * d.sampling);
    double variation = 0;
    for (int k = 0; k * step + log(2) <= steps * step + 1e-9; k++) {
        double here = log(pairs_within[0][k + (int)floor(log(2) / step)] / pairs_within[0][k]) /
                      (floor(log(2) / step) * step);
        variation = fmax(variation, fabs(here - slope[0]));
    }
    check_near(d.variation, variation, 0.5 * variation);
    drop(&s);
}

/* Random pairs: at most the allowed number, none close in time, each equally likely. */
static void drawn_pairs_are_counted(void **unused) {
    (void)unused;
    static const long long wished[] = {10000, 10240, 17001, 10000}, windows[] = {60, 60, 60, 0};
    sample s = make(circle, 250, 2);
    for (int k = 0; k < 4; k++) {
        saltus_series_options options = saltus_series_defaults();
        options.pairs = wished[k];
        options.window = windows[k];
        saltus_series_dimension d = measure(&s, &options);
        double others = (double)(250 - windows[k]), far = others * (others - 1) / (250.0 * 250),
               expected = far * (double)wished[k];
        assert_true(d.pairs <= wished[k]);
        check_near((double)d.pairs, expected, 5 * sqrt(expected * (1 - far)));
        /* Of a circle's pairs, asin(r / 2) 2 / pi are within r. */
        check_near((double)d.within / (double)d.pairs, 2 / M_PI * asin(d.radius[1] / 2), 0.02);
    }
    drop(&s);
}

/* All pairs are compared if they are no more than allowed: then the seed has no effect. */
static void all_pairs_or_some(void **unused) {
    (void)unused;
    sample s = make(henon, 200, 2);
    for (int fewer = 0; fewer < 2; fewer++) {
        saltus_series_options options = saltus_series_defaults();
        options.pairs = 200 * 199 / 2 - fewer;
        options.window = 0;
        saltus_series_dimension first = measure(&s, &options);
        options.seed = 2;
        saltus_series_dimension second = measure(&s, &options);
        assert_true((first.dimension == second.dimension) == !fewer);
        assert_true(fewer ? first.pairs < options.pairs : first.pairs == options.pairs);
    }
    drop(&s);
}

/* Components of weight zero have no effect. */
static void weights_of_zero(void **unused) {
    (void)unused;
    static const double weights[3] = {1, 1, 0};
    sample s = make(cube, 1000, 3), flat = make(circle, 1000, 2);
    saltus_series_options options = saltus_series_defaults();
    saltus_series_dimension d, of_circle = measure(&flat, NULL);
    saltus_series_curve curve;
    saltus_message message = {.text = ""};
    for (long long i = 0; i < s.count; i++) {
        point(&s, i)[0] = point(&flat, i)[0];
        point(&s, i)[1] = point(&flat, i)[1];
    }
    saltus_series_points points = points_of(&s);
    points.weights = weights;
    check_ok(saltus_series_correlation_dimension(&points, &options, &d, &message), &message);
    assert_true(d.dimension == of_circle.dimension && d.radius[1] == of_circle.radius[1]);
    check_ok(saltus_series_closed_curve(&points, &options, &curve, &message), &message);
    assert_true(curve.closed && curve.curves == 1);
    drop(&s);
    drop(&flat);
}

/* Three times the first lag at which the autocorrelation falls to 1/e, but at most a tenth. */
static void window_by_definition(void **unused) {
    (void)unused;
    enum { count = 1000 };
    for (int k = 0; k < 5; k++) {
        const double memory[] = {0, 3, 9, 20, 400};
        sample s = make(gaussian, count, 2);
        for (long long i = 1; i < count; i++)
            for (int d = 0; d < 2; d++)
                point(&s, i)[d] += exp(-1 / (memory[k] + 1e-3)) * point(&s, i - 1)[d];
        double mean[2] = {0}, power = 0;
        for (long long i = 0; i < count; i++)
            for (int d = 0; d < 2; d++)
                mean[d] += point(&s, i)[d] / count;
        for (long long i = 0; i < count; i++)
            for (int d = 0; d < 2; d++)
                power += gsl_pow_2(point(&s, i)[d] - mean[d]) / count;
        long long lag = 1;
        for (; lag < count; lag++) {
            double sum = 0;
            for (long long i = 0; i < count - lag; i++)
                for (int d = 0; d < 2; d++)
                    sum += (point(&s, i)[d] - mean[d]) * (point(&s, i + lag)[d] - mean[d]);
            if (sum / (double)(count - lag) <= exp(-1) * power)
                break;
        }
        assert_int_equal(measure(&s, NULL).window, 3 * lag < count / 10 ? 3 * lag : count / 10);
        drop(&s);
    }
}

/* For a neighbourhood of a point of the plane: width over length, and the neighbours on either side, by its
 * principal axes in closed form. */
static double neighbourhood(const sample *s, long long i, int size, long long window, double *balance) {
    double far[64], x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    long long near[64] = {0};
    int found = 0, before = 0;
    for (long long j = 0; j < s->count; j++) {
        double d = distance(s, i, j);
        if (llabs(i - j) <= window || (found == size && d >= far[size - 1]))
            continue;
        int k = found < size ? found++ : size - 1;
        for (; k > 0 && far[k - 1] > d; k--) {
            far[k] = far[k - 1];
            near[k] = near[k - 1];
        }
        far[k] = d;
        near[k] = j;
    }
    near[size] = i;
    for (int k = 0; k <= size; k++) {
        x += point(s, near[k])[0] / (size + 1);
        y += point(s, near[k])[1] / (size + 1);
    }
    for (int k = 0; k <= size; k++) {
        double a = point(s, near[k])[0] - x, b = point(s, near[k])[1] - y;
        xx += a * a;
        xy += a * b;
        yy += b * b;
    }
    double middle = 0.5 * (xx + yy), radius = hypot(0.5 * (xx - yy), xy),
           angle = 0.5 * atan2(2 * xy, xx - yy);
    double own = point(s, i)[0] * cos(angle) + point(s, i)[1] * sin(angle);
    for (int k = 0; k < size; k++)
        before += point(s, near[k])[0] * cos(angle) + point(s, near[k])[1] * sin(angle) < own;
    *balance = fmin(before, size - before) / (0.5 * size);
    return sqrt(fmax(0, middle - radius) / (middle + radius));
}

static void curves_by_definition(void **unused) {
    (void)unused;
    enum { count = 700, window = 2 };
    filler *fills[] = {henon, circle_map, corner, creep_in};
    for (size_t f = 0; f < sizeof fills / sizeof *fills; f++) {
        sample s = make(fills[f], count, 2);
        double thin[count], thick[count], balance = 0, ends = 0, one;
        for (long long i = 0; i < count; i++) {
            thin[i] = neighbourhood(&s, i, 8, window, &one);
            thick[i] = neighbourhood(&s, i, 16, window, &one);
            balance += one / count;
            ends += i < 4 || i >= count - 4 ? one / 8 : 0;
        }
        gsl_sort(thin, 1, count);
        gsl_sort(thick, 1, count);
        double few = gsl_stats_median_from_sorted_data(thin, 1, count),
               many = gsl_stats_median_from_sorted_data(thick, 1, count);
        saltus_series_options options = saltus_series_defaults();
        saltus_series_points points = points_of(&s);
        saltus_series_curve c;
        saltus_message message = {.text = ""};
        options.window = window;
        check_ok(saltus_series_closed_curve(&points, &options, &c, &message), &message);
        check_near(c.thickness, few, 1e-3 * few);
        check_near(c.thinning, many / few, 2e-3 * many / few);
        check_near(c.balance, balance, 0.01);
        check_near(c.ends, ends, 0.02);
        drop(&s);
    }
}

static void five_curves(sample *s) {
    curves_in_turn(s, 5);
}

static void many_curves(sample *s) {
    for (long long i = 0; i < s->count; i++) {
        point(s, i)[0] = cos(2 * M_PI * golden * (double)i) + 4 * (double)(i % 64);
        point(s, i)[1] = sin(2 * M_PI * golden * (double)i);
    }
}

static void curves_are_counted(void **unused) {
    (void)unused;
    check_curve(five_curves, 2000, 2, 5);
    check_curve(many_curves, 6400, 2, 64);
    check_curve(circle_map, 1500, 1, 0); /* a line covered twice is none */
}

/* Neighbours that are drawn at random each time do not remain, on any curve. */
static void shuffled(sample *s) {
    circle(s);
    for (long long i = s->count - 1; i > 0; i--) {
        long long j = (long long)(gsl_rng_uniform(s->rng) * (double)(i + 1));
        for (int d = 0; d < s->dimension; d++) {
            double keep = point(s, i)[d];
            point(s, i)[d] = point(s, j)[d];
            point(s, j)[d] = keep;
        }
    }
}

static void neighbours_that_part(void **unused) {
    (void)unused;
    sample s = make(shuffled, 2000, 2);
    saltus_series_curve c = look_at(&s);
    assert_true(!c.closed && c.thickness < 0.01 && !c.recurs);
    check_near(c.thinning, 2, 0.2);
    /* One of 2000 has a rank up to 16 by chance. */
    check_near(c.kept, 17 / 2000.0, 0.012);
    assert_true(c.balance > 0.7 && c.ends > 0.5);
    drop(&s);
}

/* Requirements of all three tests. */

static void check_refused(const saltus_series_points *points, const saltus_series_options *options) {
    saltus_series_dimension dimension;
    saltus_series_curve curve;
    saltus_message message = {.text = ""};
    assert_int_equal(saltus_series_correlation_dimension(points, options, &dimension, &message),
                     SALTUS_BAD_INPUT);
    assert_true(message.text[0] != 0);
    assert_int_equal(saltus_series_closed_curve(points, options, &curve, NULL), SALTUS_BAD_INPUT);
}

/* Random values between -1 and 1, with runs that repeat the values `period` points before to within
 * `apart`. */
static void repeat_runs(double *values, long long count, int period, double apart, const long long (*runs)[2],
                        int run_count, gsl_rng *rng) {
    for (long long k = 0; k < count; k++) {
        double drawn = gsl_ran_flat(rng, -1, 1);
        values[k] = drawn;
        for (int j = 0; j < run_count; j++)
            if (k >= runs[j][0] && k < runs[j][0] + runs[j][1])
                values[k] = values[k - period] + apart * drawn;
            else if (k == runs[j][0] - 1 || k == runs[j][0] + runs[j][1])
                values[k] = values[k - period] + (values[k - period] > 0 ? -0.7 : 0.7);
    }
    values[0] = -1; /* the extent is 2 */
    values[count / 2 + 1] = 1;
}

/* Runs count together with the period before them; short or inaccurate ones do not. */
static void laminar_phases_are_counted(void **unused) {
    (void)unused;
    enum { count = 4000 };
    static const struct {
        int period;
        long long runs[3][2], laminar, longest;
    } rows[] = {{1, {{100, 30}, {300, 20}, {500, 19}}, 31 + 21, 31},
                {3, {{100, 90}, {300, 20}, {900, 300}}, 93 + 23 + 303, 303},
                {7, {{100, 34}, {300, 35}, {3900, 100}}, 42 + 107, 107},
                {16, {{100, 79}, {300, 80}, {900, 200}}, 96 + 216, 216}};
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_taus2);
    double *values = malloc(2 * count * sizeof *values), *series = malloc(count * sizeof *series);
    for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
        repeat_runs(series, count, rows[r].period, 0.01, rows[r].runs, 3, rng);
        saltus_series_phases phases =
            saltus_series_laminar_phases(&(saltus_series_points){series, NULL, count, 1}, 16);
        assert_int_equal(phases.period, rows[r].period);
        assert_int_equal(phases.longest, rows[r].longest);
        check_near(phases.laminar, (double)rows[r].laminar / count, 1e-12);
        /* The same as the second component, in a unit that its weight cancels, beside one of weight zero. */
        for (long long k = 0; k < count; k++) {
            values[2 * k] = gsl_ran_flat(rng, -1, 1);
            values[2 * k + 1] = 1024 * series[k];
        }
        saltus_series_points weighted = {values, (double[]){0, 1.0 / 1024}, count, 2};
        saltus_series_phases again = saltus_series_laminar_phases(&weighted, 16);
        assert_true(again.laminar == phases.laminar && again.period == phases.period &&
                    again.longest == phases.longest);
        weighted.weights = NULL;
        weighted.dimension = 1;
        assert_int_equal(saltus_series_laminar_phases(&weighted, rows[r].period - 1).period, 0);
        repeat_runs(series, count, rows[r].period, 0.1, rows[r].runs, 3, rng);
        phases = saltus_series_laminar_phases(&(saltus_series_points){series, NULL, count, 1}, 16);
        assert_int_equal(phases.period, 0);
        assert_true(phases.laminar == 0 && phases.longest == 0);
    }
    free(series);
    free(values);
    gsl_rng_free(rng);
}

/* Phases are relative to the extent of the points: another unit or origin changes nothing. */
static void phases_know_no_unit(void **unused) {
    (void)unused;
    static const long long runs[][2] = {{100, 60}, {300, 150}};
    enum { count = 600, period = 3 };
    double values[count], other[count];
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_taus2);
    repeat_runs(values, count, period, 0, runs, 2, rng);
    saltus_series_points points = {.values = values, .count = count, .dimension = 1};
    saltus_series_phases own = saltus_series_laminar_phases(&points, 6);
    assert_true(own.period == period && own.laminar > 0.3);
    for (int power = -60; power <= 60; power += 10)
        for (int k = 0; k < 2; k++) {
            for (int j = 0; j < count; j++)
                other[j] = ldexp(values[j] + 4 * k, power);
            points.values = other;
            saltus_series_phases same = saltus_series_laminar_phases(&points, 6);
            assert_true(same.period == own.period && same.longest == own.longest);
            assert_true(same.laminar == own.laminar);
        }
    gsl_rng_free(rng);
}

static void unsuitable_points(void **unused) {
    (void)unused;
    static const double negative[2] = {1, -1}, infinite[2] = {1, INFINITY};
    sample s = make(henon, 1000, 2);
    saltus_series_points good = points_of(&s), points = good;
    saltus_series_options options = saltus_series_defaults();
    points.count = SALTUS_SERIES_LEAST - 1;
    check_refused(&points, &options);
    points.count = -5;
    check_refused(&points, &options);
    points = good;
    points.dimension = 0;
    check_refused(&points, &options);
    points = good;
    points.weights = negative;
    check_refused(&points, &options);
    points.weights = infinite;
    check_refused(&points, &options);
    s.values[777] = NAN;
    check_refused(&good, &options);
    s.values[777] = -INFINITY;
    check_refused(&good, &options);
    drop(&s);
}

static void unsuitable_options(void **unused) {
    (void)unused;
    sample s = make(henon, 1000, 2);
    saltus_series_points points = points_of(&s);
    saltus_series_options options = saltus_series_defaults();
    options.resolution = NAN;
    check_refused(&points, &options);
    options.resolution = -1e-9;
    check_refused(&points, &options);
    options = saltus_series_defaults();
    options.window = 251;
    check_refused(&points, &options);
    options.window = -2;
    check_refused(&points, &options);
    options = saltus_series_defaults();
    options.pairs = 0;
    check_refused(&points, &options);
    options = saltus_series_defaults();
    options.frequencies = 0;
    check_refused(&points, &options);
    saltus_series_chaos chaos;
    saltus_message message = {.text = ""};
    options.frequencies = 100001;
    assert_int_equal(saltus_series_chaos_test(s.values, s.count, &options, &chaos, &message),
                     SALTUS_BAD_INPUT);
    assert_string_equal(message.text, "100001 frequencies: should be between 1 and 100000");
    drop(&s);
}

/* Phases less than a period apart share points, which count once. */
static void no_point_is_laminar_twice(void **unused) {
    (void)unused;
    enum { count = 4000, period = 12 };
    double *series = malloc(count * sizeof *series);
    for (int k = 0; k < count; k++)
        series[k] = k % 100 == 99 ? 2 : sin(2 * acos(-1.0) * k / period);
    saltus_series_phases phases =
        saltus_series_laminar_phases(&(saltus_series_points){series, NULL, count, 1}, period);
    assert_int_equal(phases.period, period);
    assert_true(phases.laminar > 0.9 && phases.laminar <= 1);
    free(series);
}

/* Of periods with equally many laminar points the shortest is reported; constant values have period 1. */
static void the_shortest_period_is_laminar(void **unused) {
    (void)unused;
    enum { count = 400 };
    double values[count];
    for (int p = 1; p <= 6; p++) {
        for (int k = 0; k < count; k++)
            values[k] = p == 1 ? 0.7 : cos(2 * M_PI * (k % p) / p + 1);
        for (int longest = 1; longest <= 14; longest++) {
            saltus_series_phases phases =
                saltus_series_laminar_phases(&(saltus_series_points){values, NULL, count, 1}, longest);
            assert_int_equal(phases.period, longest < p ? 0 : p);
            assert_true(phases.laminar == (longest < p ? 0 : 1));
            assert_int_equal(phases.longest, longest < p ? 0 : count);
        }
    }
}

/* Equal input gives equal results, bit for bit, also with random pairs and angles. */
static void equal_input_gives_equal_results(void **unused) {
    (void)unused;
    sample s = make(henon, 1000, 2);
    saltus_series_options options = saltus_series_defaults();
    saltus_series_points points = points_of(&s);
    saltus_message message = {.text = ""};
    saltus_series_chaos chaos[2];
    saltus_series_dimension dimension[2];
    saltus_series_curve curve[2];
    options.pairs = 100000;
    options.frequencies = 9;
    options.seed = 77;
    for (int k = 0; k < 2; k++) {
        check_ok(saltus_series_chaos_test(s.values, 1000, &options, &chaos[k], &message), &message);
        check_ok(saltus_series_correlation_dimension(&points, &options, &dimension[k], &message), &message);
        check_ok(saltus_series_closed_curve(&points, &options, &curve[k], &message), &message);
        options.seed += (unsigned long)k;
    }
    assert_true(chaos[0].k == chaos[1].k && chaos[0].lower == chaos[1].lower &&
                chaos[0].upper == chaos[1].upper && chaos[0].k != 0);
    assert_true(dimension[0].dimension == dimension[1].dimension &&
                dimension[0].error == dimension[1].error && dimension[0].pairs == dimension[1].pairs &&
                dimension[0].within == dimension[1].within);
    assert_true(curve[0].thickness == curve[1].thickness && curve[0].kept == curve[1].kept &&
                curve[0].balance == curve[1].balance && curve[0].ends == curve[1].ends);
    drop(&s);
}

static void unsuitable_series(void **unused) {
    (void)unused;
    sample s = make(henon, 1000, 1);
    saltus_series_options options = saltus_series_defaults();
    saltus_series_chaos chaos;
    saltus_message message = {.text = ""};
    assert_int_equal(saltus_series_chaos_test(s.values, SALTUS_SERIES_LEAST - 1, &options, &chaos, &message),
                     SALTUS_BAD_INPUT);
    options.frequencies = 0;
    assert_int_equal(saltus_series_chaos_test(s.values, 1000, &options, &chaos, &message), SALTUS_BAD_INPUT);
    options.frequencies = 100;
    s.values[777] = NAN;
    assert_int_equal(saltus_series_chaos_test(s.values, 1000, &options, &chaos, &message), SALTUS_BAD_INPUT);
    s.values[777] = INFINITY;
    assert_int_equal(saltus_series_chaos_test(s.values, 1000, &options, &chaos, NULL), SALTUS_BAD_INPUT);
    drop(&s);
}

static void defaults_are_those_told(void **unused) {
    (void)unused;
    saltus_series_options o = saltus_series_defaults();
    assert_true(o.seed == 1 && o.resolution == 1e-9 && o.frequencies == 100 && o.window == -1);
    assert_int_equal(o.pairs, 8000000);
}

static saltus_status judge_all(const sample *s) {
    saltus_series_options options = saltus_series_defaults();
    saltus_series_points points = points_of(s);
    saltus_series_chaos chaos;
    saltus_series_dimension dimension;
    saltus_series_curve curve;
    options.frequencies = 3;
    saltus_status status = saltus_series_chaos_test(s->values, s->count, &options, &chaos, NULL);
    if (status == SALTUS_OK)
        status = saltus_series_correlation_dimension(&points, &options, &dimension, NULL);
    if (status == SALTUS_OK)
        status = saltus_series_closed_curve(&points, &options, &curve, NULL);
    return status;
}

/* The k-th allocation fails, for all k until none is left to fail. Leaks show under the address sanitizer. */
static void failing_allocations(void **unused) {
    (void)unused;
    sample s = make(henon, 500, 2);
    int refused = 0;
    for (long k = 1;; k++) {
        allocations = 0;
        failing = k;
        saltus_status status = judge_all(&s);
        failing = -1;
        if (allocations < k) {
            assert_int_equal(status, SALTUS_OK);
            break;
        }
        assert_int_equal(status, SALTUS_NO_MEMORY);
        refused++;
    }
    assert_int_equal(refused, 5); /* two for each set of points, one for each test */
    drop(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(regular_and_chaotic_series),
        cmocka_unit_test(agrees_with_the_definition),
        cmocka_unit_test(scale_and_shift_do_not_matter),
        cmocka_unit_test(seeds_give_other_angles),
        cmocka_unit_test(constant_series),
        cmocka_unit_test(long_series),
        cmocka_unit_test(known_dimensions),
        cmocka_unit_test(logistic_map_fills_the_interval),
        cmocka_unit_test(henon_attractor),
        cmocka_unit_test(points_that_recur),
        cmocka_unit_test(finest_scale_counts),
        cmocka_unit_test(noise_below_a_curve_counts),
        cmocka_unit_test(few_points_have_short_ranges),
        cmocka_unit_test(weights_undo_scales),
        cmocka_unit_test(drawn_pairs),
        cmocka_unit_test(ceiling_is_told),
        cmocka_unit_test(window_follows_the_motion),
        cmocka_unit_test(curves_are_seen),
        cmocka_unit_test(other_sets_are_none),
        cmocka_unit_test(measures_mean_what_they_say),
        cmocka_unit_test(quartiles_by_definition),
        cmocka_unit_test(angles_fill_their_range),
        cmocka_unit_test(resolution_is_relative),
        cmocka_unit_test(recurring_pairs_are_counted),
        cmocka_unit_test(dimension_by_definition),
        cmocka_unit_test(drawn_pairs_are_counted),
        cmocka_unit_test(all_pairs_or_some),
        cmocka_unit_test(weights_of_zero),
        cmocka_unit_test(window_by_definition),
        cmocka_unit_test(curves_by_definition),
        cmocka_unit_test(curves_are_counted),
        cmocka_unit_test(neighbours_that_part),
        cmocka_unit_test(laminar_phases_are_counted),
        cmocka_unit_test(phases_know_no_unit),
        cmocka_unit_test(no_point_is_laminar_twice),
        cmocka_unit_test(the_shortest_period_is_laminar),
        cmocka_unit_test(equal_input_gives_equal_results),
        cmocka_unit_test(unsuitable_points),
        cmocka_unit_test(unsuitable_options),
        cmocka_unit_test(unsuitable_series),
        cmocka_unit_test(defaults_are_those_told),
        cmocka_unit_test(failing_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
