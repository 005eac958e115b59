/* Spectra: known lines, known noise, aliasing against exact coefficients, motions.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "allocations.h"
#include "check.h"

#include <complex.h>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_fft_halfcomplex.h>
#include <gsl/gsl_integration.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>

static long allocations, failing = -1;

static bool refuse(void) {
    return ++allocations == failing;
}

static const double golden = 0.61803398874989485;

static double *room(long long count) {
    double *samples = calloc((size_t)count, sizeof *samples);
    assert_non_null(samples);
    return samples;
}

static saltus_spectrum orbits_of(const double *samples, long long count, int per_period, int periods) {
    saltus_signal signal = {.samples = samples, .count = count, .per_period = per_period};
    saltus_message message = {.text = ""};
    saltus_spectrum spectrum;
    check_ok(saltus_signal_orbits(&signal, periods, &spectrum, &message), &message);
    return spectrum;
}

static saltus_spectrum welch_of(const double *samples, long long count, int per_period, long long segment) {
    saltus_signal signal = {.samples = samples, .count = count, .per_period = per_period};
    saltus_message message = {.text = ""};
    saltus_spectrum spectrum;
    check_ok(saltus_signal_welch(&signal, segment, 0.95, &spectrum, &message), &message);
    return spectrum;
}

static double broadband_of(const double *samples, long long count) {
    saltus_message message = {.text = ""};
    double fraction = -1;
    check_ok(saltus_series_broadband(samples, count, &fraction, &message), &message);
    return fraction;
}

/* Lines */

/* Lines of a motion of period 5 T, with a mean, from an even and an odd number of samples. */
static void known_lines_are_found(void **unused) {
    (void)unused;
    enum { p = 5, lines = 9, orbits = 3 };
    static const int harmonic[lines] = {1, 2, 3, 5, 7, 10, 23, 40, 61};
    for (int per_period = 63; per_period <= 64; per_period++) {
        long long count = (long long)orbits * p * per_period;
        double *samples = room(count), amplitude[lines], phase[lines];
        for (int l = 0; l < lines; l++) {
            amplitude[l] = pow(10, -0.7 * l) * (1 + golden * l);
            phase[l] = 3 * sin(1.0 + 5 * l);
        }
        for (long long j = 0; j < count; j++) {
            samples[j] = 0.3;
            for (int l = 0; l < lines; l++)
                samples[j] += amplitude[l] *
                              cos(2 * M_PI * (double)(harmonic[l] * j % (p * per_period)) / (p * per_period) +
                                  phase[l]);
        }
        saltus_spectrum s = orbits_of(samples, count, per_period, p);
        assert_int_equal(s.kind, SALTUS_SPECTRUM_LINES);
        assert_int_equal(s.orbits, orbits);
        check_near(s.mean, 0.3, 1e-14);
        check_near(s.parseval, 0, 1e-12);
        assert_true(s.between < 1e-14 && s.broadband < 1e-25);
        double power = 0, share = 0;
        for (int l = 0; l < lines; l++) {
            const saltus_spectral_line *line = &s.lines[harmonic[l] - 1];
            assert_int_equal(line->harmonic, harmonic[l]);
            check_near(line->frequency, harmonic[l] / 5.0, 1e-15);
            check_near(line->amplitude, amplitude[l], 1e-10 * amplitude[l]);
            check_near(line->phase, phase[l], 1e-10);
            check_near(line->decibels, 20 * log10(amplitude[l] / amplitude[0]), 1e-8);
            power += amplitude[l] * amplitude[l] / 2;
            share += line->share;
        }
        check_near(s.variance, power, 1e-13 * power);
        check_near(share, 1, 1e-13);
        saltus_spectrum_clear(&s);
        free(samples);
    }
}

/* An alternating signal appears at half the sampling frequency with its full amplitude. */
static void fastest_line(void **unused) {
    (void)unused;
    enum { count = 256 };
    double samples[count];
    for (int j = 0; j < count; j++)
        samples[j] = j % 2 ? -0.7 : 0.7;
    saltus_spectrum s = orbits_of(samples, count, 16, 4);
    check_near(s.lines[s.line_count - 1].amplitude, 0.7, 1e-15);
    check_near(s.lines[s.line_count - 1].share, 1, 1e-14);
    check_near(s.parseval, 0, 1e-12);
    saltus_spectrum_clear(&s);
    assert_true(broadband_of(samples, count) < 1e-20);
}

/* A signal that does not return after the claimed period shows between the lines. */
static void wrong_period_shows(void **unused) {
    (void)unused;
    enum { count = 512 };
    double samples[count];
    for (int j = 0; j < count; j++)
        samples[j] = cos(2 * M_PI * j / 32.0) + 0.01 * cos(2 * M_PI * j / 64.0);
    saltus_spectrum s = orbits_of(samples, count, 32, 1);
    check_near(s.between, 0.01, 1e-14);
    check_near(s.broadband, 1e-4 / (1 + 1e-4), 1e-14);
    saltus_spectrum_clear(&s);
    for (int j = 0; j < count; j++)
        samples[j] = cos(2 * M_PI * j / 64.0);
    s = orbits_of(samples, count, 32, 1);
    assert_true(s.between > 1e10);
    check_near(s.broadband, 1, 1e-14);
    saltus_spectrum_clear(&s);
}

static void parseval_holds(void **unused) {
    (void)unused;
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    static const int per_period[] = {1, 2, 7, 16, 64, 97};
    for (size_t k = 0; k < sizeof per_period / sizeof per_period[0]; k++) {
        long long periods = 6 * (1 + 400 / per_period[k]), count = periods * per_period[k];
        double *samples = room(count);
        for (long long j = 0; j < count; j++)
            samples[j] = 1e3 + gsl_ran_gaussian(rng, 1) + sin(0.1 * (double)j);
        saltus_spectrum s = orbits_of(samples, count, per_period[k], (int)periods / 2);
        double power = 0, windowed = 0;
        for (long long b = 0; b < s.bins; b++)
            power += s.density[b] * s.resolution;
        check_near(power, s.variance, 1e-12 * s.variance);
        check_near(s.parseval, 0, 1e-12);
        saltus_spectrum_clear(&s);
        s = welch_of(samples, count, per_period[k], periods / 3);
        check_near(s.parseval, 0, 1e-12);
        for (long long b = 0; b < s.bins; b++)
            windowed += s.density[b] * s.resolution;
        check_near(windowed, s.variance, 0.3 * s.variance);
        saltus_spectrum_clear(&s);
        free(samples);
    }
    gsl_rng_free(rng);
}

/* Aliasing */

/* Exact coefficients of amplitude exp(i phase) of impacting signals whose jumps fall between the samples. */
typedef struct impacting {
    double (*value)(double t);
    double complex (*line)(int k);
    double least; /* the least trust with 1024 samples per period */
} impacting;

static const double shift = 0.31830988618;

static double bounce(double t) {
    return fabs(sin(M_PI * (t - shift)));
}
static double complex bounce_line(int k) {
    return -4 / (M_PI * (4.0 * k * k - 1)) * cexp(-2 * M_PI * I * k * shift);
}
/* A parabola between impacts, and its rate, which jumps. */
static double parabola(double t) {
    double s = t - shift - floor(t - shift);
    return s * (1 - s);
}
static double complex parabola_line(int k) {
    return -1 / (M_PI * M_PI * k * k) * cexp(-2 * M_PI * I * k * shift);
}
static double saw(double t) {
    return 1 - 2 * (t - shift - floor(t - shift));
}
static double complex saw_line(int k) {
    return 2 / (M_PI * I * k) * cexp(-2 * M_PI * I * k * shift);
}
/* Only even harmonics of the sawtooth, and a smooth part: lines that vanish by symmetry do not lower the
 * trust. */
static double twice(double t) {
    return saw(2 * t) + cos(2 * M_PI * t);
}
static double complex twice_line(int k) {
    return k == 1 ? 1 : k % 2 ? 0 : 2 / (M_PI * I * (k / 2.0)) * cexp(-2 * M_PI * I * (k / 2.0) * shift);
}

static void trust_is_deserved(void **unused) {
    (void)unused;
    static const impacting cases[] = {
        {bounce, bounce_line, 30}, {parabola, parabola_line, 30}, {saw, saw_line, 2}, {twice, twice_line, 2}};
    enum { per_period = 1024, orbits = 2, count = per_period * orbits };
    double samples[count];
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        for (int j = 0; j < count; j++)
            samples[j] = cases[c].value((double)j / per_period);
        saltus_spectrum s = orbits_of(samples, count, per_period, 1);
        assert_true(s.trustworthy >= cases[c].least && s.trustworthy < per_period / 4.0);
        for (int k = 1; k <= (int)s.trustworthy; k++) {
            const saltus_spectral_line *line = &s.lines[k - 1];
            double complex exact = cases[c].line(k), found = line->amplitude * cexp(I * line->phase);
            double above = fmax(cabs(exact), cabs(cases[c].line(k + 1)));
            check_near(cabs(found - exact), 0, 0.01 * above);
        }
        saltus_spectrum_clear(&s);
    }
}

/* A smooth signal is trusted over the whole range: its lines reach rounding before. */
static void smooth_signals_do_not_alias(void **unused) {
    (void)unused;
    enum { count = 512, per_period = 128 };
    double samples[count];
    for (int j = 0; j < count; j++)
        samples[j] = exp(sin(2 * M_PI * j / per_period));
    saltus_spectrum s = orbits_of(samples, count, per_period, 1);
    check_near(s.trustworthy, per_period / 4.0 - 1, 1);
    /* Modified Bessel functions: exp(sin x) = I_0(1) + 2 sum I_k(1) cos(k (x - pi / 2)). */
    check_near(s.mean, 1.2660658777520083356, 1e-14);
    check_near(s.lines[0].amplitude, 1.1303182079849700544, 1e-14);
    check_near(s.lines[1].amplitude, 0.27149533953407656236, 1e-14);
    check_near(s.lines[0].phase, -M_PI / 2, 1e-14);
    saltus_spectrum_clear(&s);
}

/* Noise */

static void white_noise_is_covered(void **unused) {
    (void)unused;
    enum { runs = 6, per_period = 8, segment = 128, periods = 16 * segment, count = periods * per_period };
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    double *samples = room(count), level = 2 * 0.5 * 0.5 / per_period, mean = 0;
    long long covered = 0, bins = 0;
    for (int run = 0; run < runs; run++) {
        for (int j = 0; j < count; j++)
            samples[j] = gsl_ran_gaussian(rng, 0.5);
        saltus_spectrum s = welch_of(samples, count, per_period, segment);
        assert_int_equal(s.segments, 31);
        check_near(s.degrees, 2 * 31 / (1 + 2 * (1 - 1 / 31.0) / 36), 1e-9);
        assert_int_equal(s.line_count, 0);
        assert_true(s.broadband > 0.999);
        for (long long k = 2; k < s.bins - 2; k++, bins++) {
            covered += s.low * s.density[k] < level && level < s.high * s.density[k];
            mean += s.density[k] / level;
        }
        saltus_spectrum_clear(&s);
    }
    check_near((double)covered / (double)bins, 0.95, 0.01);
    check_near(mean / (double)bins, 1, 0.01);
    free(samples);
    gsl_rng_free(rng);
}

/* One segment has two degrees of freedom. */
static void one_segment(void **unused) {
    (void)unused;
    enum { count = 256 };
    double samples[count];
    for (int j = 0; j < count; j++)
        samples[j] = sin(j * j);
    saltus_spectrum s = welch_of(samples, count, 16, 16);
    assert_int_equal(s.segments, 1);
    check_near(s.degrees, 2, 1e-12);
    check_near(s.low, 1 / -log(0.025), 1e-9);
    check_near(s.high, 1 / -log(0.975), 1e-9);
    saltus_spectrum_clear(&s);
}

/* A sine's power is in the three bins of the window, a quarter of its peak in each neighbour. */
static void sine_has_its_power(void **unused) {
    (void)unused;
    enum { per_period = 32, segment = 16, periods = 256, count = per_period * periods };
    double *samples = room(count);
    for (int j = 0; j < count; j++)
        samples[j] = 0.8 * cos(2 * M_PI * 1.25 * j / per_period + 1);
    saltus_spectrum s = welch_of(samples, count, per_period, segment);
    const double *d = s.density + 20;
    check_near((d[-1] + d[0] + d[1]) * s.resolution, 0.32, 1e-12);
    check_near(d[1] / d[0], 0.25, 1e-12);
    assert_int_equal(s.line_count, 1);
    check_near(s.lines[0].frequency, 1.25, 1e-10);
    check_near(s.lines[0].amplitude, 0.8, 1e-9);
    check_near(s.lines[0].phase, 1, 1e-7);
    assert_true(s.broadband < 1e-9);
    saltus_spectrum_clear(&s);
    free(samples);
}

/* Lines of any frequency */

/* Lines of three incommensurate frequencies, two of them five bins apart, with little noise or none. */
static void incommensurate_lines(void **unused) {
    (void)unused;
    enum { count = 4000, per_period = 4, lines = 5, most = 16 };
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    const double frequency[lines] = {0.1 * M_SQRT2, 1 - golden, 1 - golden + 5.0 * per_period / count, 1.3,
                                     1.99},
                 amplitude[lines] = {1e-3, 1, 0.3, 0.05, 2e-4};
    double *samples = room(count);
    for (int noisy = 0; noisy < 2; noisy++) {
        double sigma = noisy ? 1e-4 : 0, broadband, tolerance = noisy ? 1e-4 : 1e-8;
        saltus_spectral_line found[most];
        saltus_message message = {.text = ""};
        int line_count;
        for (int j = 0; j < count; j++) {
            samples[j] = -2 + gsl_ran_gaussian(rng, sigma);
            for (int l = 0; l < lines; l++)
                samples[j] += amplitude[l] * cos(2 * M_PI * frequency[l] * j / per_period + l - 2);
        }
        saltus_signal signal = {.samples = samples, .count = count, .per_period = per_period};
        check_ok(saltus_signal_lines(&signal, 0, most, found, &line_count, &broadband, &message), &message);
        assert_int_equal(line_count, lines);
        for (int l = 0; l < lines; l++) {
            check_near(found[l].frequency, frequency[l],
                       10 * tolerance * per_period / (count * amplitude[l]));
            check_near(found[l].amplitude, amplitude[l], tolerance);
            check_near(found[l].phase, l - 2, 30 * tolerance / amplitude[l]);
        }
        if (noisy)
            check_near(broadband, sigma * sigma / 0.546, 0.1 * sigma * sigma);
        else
            assert_true(broadband < 1e-9);
    }
    free(samples);
    gsl_rng_free(rng);
}

/* A quasi-periodic section: a function of the angle. */
static double section_of(int kind, double angle) {
    switch (kind) {
    case 0:
        return cos(angle);
    case 1:
        return exp(2 * cos(angle)) + 0.3 * sin(3 * angle);
    case 2:
        return fabs(sin(angle / 2)); /* a corner, as of a curve at a stop */
    default:
        return cos(angle) + 0.4 * cos(M_SQRT2 * angle) * cos(2 * angle); /* two angles */
    }
}

static void quasiperiodic_is_not_broadband(void **unused) {
    (void)unused;
    static const double turns[] = {0.61803398874989485, 0.2527, 0.4975, 0.0131};
    enum { count = 3000 };
    double samples[count];
    for (int kind = 0; kind < 4; kind++)
        for (size_t k = 0; k < sizeof turns / sizeof turns[0]; k++) {
            for (int j = 0; j < count; j++)
                samples[j] = section_of(kind, 2 * M_PI * turns[k] * j);
            assert_true(broadband_of(samples, count) < (kind == 2 ? 1e-5 : 1e-8));
        }
    /* Curves visited in turn. */
    for (int j = 0; j < count; j++)
        samples[j] = j % 3 + 0.2 * cos(2 * M_PI * golden * j / 3);
    assert_true(broadband_of(samples, count) < 1e-8);
}

static void periodic_is_not_broadband(void **unused) {
    (void)unused;
    enum { count = 4000 };
    double samples[count];
    for (int p = 1; p <= 64; p++) {
        for (int j = 0; j < count; j++)
            samples[j] = sin(17.0 * (j % p) * (j % p) + p);
        assert_true(broadband_of(samples, count) < 1e-8);
    }
}

static void logistic(double *samples, int count, double r) {
    double x = 0.3;
    for (int j = -2000; j < count; j++) {
        x = r * x * (1 - x);
        if (j >= 0)
            samples[j] = x;
    }
}

static void chaos_and_noise_are_broadband(void **unused) {
    (void)unused;
    enum { count = 4096 };
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    double samples[count], a = 0.1, b = 0.1;
    for (int j = 0; j < count; j++)
        samples[j] = gsl_ran_gaussian(rng, 1);
    assert_true(broadband_of(samples, count) > 0.99);
    logistic(samples, count, 4);
    assert_true(broadband_of(samples, count) > 0.99);
    logistic(samples, count, 3.97);
    assert_true(broadband_of(samples, count) > 0.99);
    logistic(samples, count, 3.5);
    assert_true(broadband_of(samples, count) < 1e-20);
    /* Two bands visited in turn: a line at half the frequency, and what chaos leaves of the variance. */
    logistic(samples, count, 3.6);
    check_near(broadband_of(samples, count), 0.09, 0.01);
    for (int j = 0; j < count; j++) {
        double next = 1 - 1.4 * a * a + b;
        b = 0.3 * a;
        samples[j] = a = next;
    }
    assert_true(broadband_of(samples, count) > 0.99);
    gsl_rng_free(rng);
}

/* The size of weak noise is found; a narrow peak that is no line is not one. */
static void noise_on_lines(void **unused) {
    (void)unused;
    enum { count = 4096 };
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    double samples[count];
    for (int j = 0; j < count; j++)
        samples[j] = M_SQRT2 * cos(2 * M_PI * golden * j) + gsl_ran_gaussian(rng, 0.01);
    check_near(broadband_of(samples, count), 1e-4, 1e-5);
    for (double memory = 50; memory < 1000; memory *= 4) {
        double complex z = 1, step = cexp(2 * M_PI * I * 0.21 - 1 / memory);
        for (int j = 0; j < count; j++) {
            z = step * z + gsl_ran_gaussian(rng, 1) + I * gsl_ran_gaussian(rng, 1);
            samples[j] = creal(z);
        }
        assert_true(broadband_of(samples, count) > 0.9);
    }
    gsl_rng_free(rng);
}

/* By definition */

static const double uneven = 0.37;

/* Some lines, a continuum and a mean. */
static void fill_mixed(double *samples, long long count, int per_period) {
    for (long long j = 0; j < count; j++) {
        double t = (double)j / per_period;
        samples[j] = 0.7 + cos(2 * M_PI * 0.5 * t) + 0.2 * sin(2 * M_PI * uneven * t) +
                     0.1 * cos(0.013 * (double)(j * j % 4099));
    }
}

/* Segments overlapping by half, Hann window, with the whole signal's mean removed; every bin and its share of
 * the power by sums. */
static void welch_by_definition(void **unused) {
    (void)unused;
    static const struct {
        int per_period, segment;
        long long count;
    } cases[] = {{8, 8, 8 * 40}, {7, 11, 7 * 50 + 3}, {1, 64, 64 * 3}, {16, 4, 64}, {16, 4, 95}, {16, 4, 96}};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        long long count = cases[c].count, length = (long long)cases[c].per_period * cases[c].segment;
        long long hop = length / 2, segments = 0;
        double *samples = room(count), mean = 0, variance = 0, windowed = 0, bins = 0;
        fill_mixed(samples, count, cases[c].per_period);
        for (long long j = 0; j < count; j++)
            mean += samples[j] / (double)count;
        for (long long j = 0; j < count; j++)
            variance += pow(samples[j] - mean, 2) / (double)count;
        saltus_spectrum s = welch_of(samples, count, cases[c].per_period, cases[c].segment);
        double *density = room(s.bins), squares = 0, overlap = 0;
        for (long long j = 0; j < length; j++) {
            double w = pow(sin(M_PI * (double)j / (double)length), 2);
            squares += w * w;
            if (j + hop < length)
                overlap += w * pow(sin(M_PI * (double)(j + hop) / (double)length), 2);
        }
        for (long long first = 0; first + length <= count; first += hop, segments++)
            for (long long k = 0; k < s.bins; k++) {
                double complex sum = 0;
                for (long long j = 0; j < length; j++)
                    sum += pow(sin(M_PI * (double)j / (double)length), 2) * (samples[first + j] - mean) *
                           cexp(-2 * M_PI * I * (double)(j * k % length) / (double)length);
                density[k] +=
                    (k == 0 || 2 * k == length ? 1 : 2) * pow(cabs(sum), 2) / (squares * cases[c].per_period);
            }
        for (long long first = 0; first + length <= count; first += hop)
            for (long long j = 0; j < length; j++)
                windowed +=
                    pow(sin(M_PI * (double)j / (double)length), 4) * pow(samples[first + j] - mean, 2);
        assert_int_equal(s.kind, SALTUS_SPECTRUM_WELCH);
        assert_int_equal(s.segments, segments);
        assert_int_equal(s.segment_periods, cases[c].segment);
        assert_int_equal(s.count, count);
        assert_int_equal(s.per_period, cases[c].per_period);
        assert_int_equal(s.bins, length / 2 + 1);
        check_near(s.resolution, 1.0 / cases[c].segment, 1e-15);
        check_near(s.mean, mean, 1e-13);
        check_near(s.variance, variance, 1e-13);
        for (long long k = 0; k < s.bins; k++) {
            check_near(s.density[k], density[k] / (double)segments, 1e-11 * s.variance);
            bins += s.density[k];
        }
        /* One-sided: the bins together are the windowed power. */
        check_near(bins * (double)segments * squares * cases[c].per_period, windowed * (double)length,
                   1e-11 * windowed * (double)length);
        check_near(s.parseval, 0, 1e-13);
        double correlation = pow(overlap / squares, 2);
        check_near(s.degrees, 2 * (double)segments / (1 + 2 * correlation * (1 - 1 / (double)segments)),
                   1e-9);
        assert_true(s.orbits == 0 && s.periods == 0);
        if (cases[c].per_period % 2 || length % 4)
            assert_true(isnan(s.trustworthy));
        saltus_spectrum_clear(&s);
        free(density);
        free(samples);
    }
}

/* The band excludes as much below as above, for any confidence. */
static void bands_have_their_confidence(void **unused) {
    (void)unused;
    enum { count = 512 };
    static const double confidences[] = {0.1, 0.5, 0.9, 0.999};
    double samples[count];
    fill_mixed(samples, count, 16);
    for (size_t k = 0; k < sizeof confidences / sizeof confidences[0]; k++) {
        saltus_signal signal = {.samples = samples, .count = count, .per_period = 16};
        saltus_message message = {.text = ""};
        saltus_spectrum s;
        double outside = (1 - confidences[k]) / 2;
        check_ok(saltus_signal_welch(&signal, 8, confidences[k], &s, &message), &message);
        assert_true(s.confidence == confidences[k] && s.low < s.high);
        check_near(gsl_cdf_chisq_Q(s.degrees / s.low, s.degrees), outside, 1e-9);
        check_near(gsl_cdf_chisq_P(s.degrees / s.high, s.degrees), outside, 1e-9);
        saltus_spectrum_clear(&s);
    }
}

/* Density and lines of whole orbits by sums, and the power between lines. */
static void orbits_by_definition(void **unused) {
    (void)unused;
    static const struct {
        int per_period, periods, orbits;
    } cases[] = {{16, 1, 1}, {16, 3, 2}, {5, 3, 3}, {12, 2, 5}};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        int orbits = cases[c].orbits, p = cases[c].periods;
        long long count = (long long)cases[c].per_period * p * orbits;
        double *samples = room(count), off = 0, highest = 0, between = 0;
        fill_mixed(samples, count, cases[c].per_period);
        saltus_spectrum s = orbits_of(samples, count, cases[c].per_period, p);
        assert_int_equal(s.bins, count / 2 + 1);
        assert_true(s.orbits == orbits && s.periods == p && s.count == count);
        assert_true(s.confidence == 0 && s.low == 0 && s.high == 0 && s.segments == 0);
        assert_int_equal(s.line_count, (s.bins - 1) / orbits);
        check_near(s.resolution, 1.0 / (p * orbits), 1e-15);
        for (long long k = 0; k < s.bins; k++) {
            double complex sum = 0;
            for (long long j = 0; j < count; j++)
                sum += (samples[j] - s.mean) * cexp(-2 * M_PI * I * (double)(j * k % count) / (double)count) /
                       (double)count;
            double sides = k == 0 || 2 * k == count ? 1 : 2, power = sides * pow(cabs(sum), 2);
            check_near(s.density[k] * s.resolution, power, 1e-13);
            if (k % orbits) {
                off += power;
                between = fmax(between, sides * cabs(sum));
                continue;
            }
            if (k == 0)
                continue;
            const saltus_spectral_line *line = &s.lines[k / orbits - 1];
            assert_int_equal(line->harmonic, k / orbits);
            check_near(line->frequency, (double)(k / orbits) / p, 1e-15);
            check_near(cabs(line->amplitude * cexp(I * line->phase) - sides * sum), 0, 1e-13);
            check_near(line->share, power / s.variance, 1e-12);
            highest = fmax(highest, line->amplitude);
        }
        for (long long k = 0; k < s.line_count; k++)
            check_near(s.lines[k].decibels, 20 * log10(s.lines[k].amplitude / highest), 1e-9);
        check_near(s.broadband, off / s.variance, 1e-12);
        if (orbits == 1)
            assert_true(isnan(s.between));
        else
            check_near(s.between, between / highest, 1e-12);
        if (cases[c].per_period % 2)
            assert_true(isnan(s.trustworthy));
        saltus_spectrum_clear(&s);
        free(samples);
    }
}

/* Every second sample. */
static double *thinned(const double *samples, long long count) {
    double *half = room(count / 2);
    for (long long j = 0; j < count / 2; j++)
        half[j] = samples[2 * j];
    return half;
}

/* Trust reaches as far as lines from half the samples agree, to 1 % of the largest at their frequency or
 * above. */
static void trust_in_lines_by_definition(void **unused) {
    (void)unused;
    enum { per_period = 128, p = 2, orbits = 2, count = per_period * p * orbits };
    double samples[count];
    for (int kind = 0; kind < 5; kind++) {
        for (int j = 0; j < count; j++) {
            double t = (double)(j % (p * per_period)) / per_period;
            samples[j] = kind == 0   ? bounce(t)
                         : kind == 1 ? parabola(t / p)
                         : kind == 2 ? saw(t) + 0.3 * cos(M_PI * t)
                         : kind == 3
                             ? exp(sin(M_PI * t))
                             : cos(M_PI * t) + 1e-3 * cos(2 * M_PI * 50 * t) + 0.09 * sin(2 * M_PI * 20 * t);
        }
        double *half = thinned(samples, count);
        saltus_spectrum s = orbits_of(samples, count, per_period, p),
                        h = orbits_of(half, count / 2, per_period / 2, p);
        double highest = 0, reference = 0;
        long long last = (count / 4 - 1) / orbits, trusted = last;
        for (long long k = 0; k < last; k++)
            highest = fmax(highest, s.lines[k].amplitude);
        for (long long k = last - 1; k >= 0; k--) {
            double apart = cabs(s.lines[k].amplitude * cexp(I * s.lines[k].phase) -
                                h.lines[k].amplitude * cexp(I * h.lines[k].phase));
            reference = fmax(reference, s.lines[k].amplitude);
            if (apart > fmax(0.01 * reference, 1e-11 * highest))
                trusted = k;
        }
        check_near(s.trustworthy, (double)trusted / p, 1e-12);
        assert_true(s.trustworthy <= per_period / 4.0);
        saltus_spectrum_clear(&s);
        saltus_spectrum_clear(&h);
        free(half);
    }
}

/* The same for a density, in bands of an eighth of an octave; its lines and the rest are those of the signal
 * up to there. */
static void trust_in_densities_by_definition(void **unused) {
    (void)unused;
    enum {
        per_period = 64,
        segment = 8,
        count = per_period * segment * 6,
        bins = per_period * segment / 4 + 1
    };
    double *samples = room(count);
    for (int kind = 0; kind < 4; kind++) {
        gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
        double slow = 0;
        for (int j = 0; j < count; j++) {
            double t = (double)j / per_period;
            slow += 0.05 * (gsl_ran_gaussian(rng, 1) - slow);
            samples[j] = kind == 0   ? saw(uneven * t) + 0.1 * slow
                         : kind == 1 ? bounce(1.3 * t) + slow
                         : kind == 2 ? slow
                                     : exp(sin(2 * M_PI * uneven * t));
        }
        gsl_rng_free(rng);
        double *half = thinned(samples, count), reference = 0, peak = 0;
        saltus_spectrum s = welch_of(samples, count, per_period, segment),
                        h = welch_of(half, count / 2, per_period / 2, segment);
        long long trusted = bins - 2;
        for (long long k = 1; k < bins - 1; k++)
            peak = fmax(peak, s.density[k]);
        for (int band = 80; band >= 0; band--) {
            double power = 0, other = 0;
            long long width = 0, below = 0;
            for (long long k = 1; k < bins - 1; k++)
                if ((int)floor(8 * log2((double)k) + 1e-9) == band) {
                    power += s.density[k];
                    other += h.density[k];
                    below = width++ ? below : k - 1;
                }
            reference = fmax(reference, width ? power / (double)width : 0);
            if (fabs(power - other) > (double)width * fmax(0.01 * reference, 1e-22 * peak))
                trusted = below;
        }
        check_near(s.trustworthy, (double)trusted / segment, 1e-12);
        saltus_signal signal = {.samples = samples, .count = count, .per_period = per_period};
        saltus_spectral_line lines[256];
        saltus_message message = {.text = ""};
        double fraction;
        int line_count;
        check_ok(saltus_signal_lines(&signal, s.trustworthy, 256, lines, &line_count, &fraction, &message),
                 &message);
        assert_int_equal(s.line_count, line_count);
        assert_true(s.broadband == fraction);
        for (int k = 0; k < line_count; k++) {
            assert_true(s.lines[k].frequency == lines[k].frequency &&
                        lines[k].frequency <= s.trustworthy + 1.0 / segment);
            assert_true(s.lines[k].amplitude == lines[k].amplitude);
        }
        saltus_spectrum_clear(&s);
        saltus_spectrum_clear(&h);
        free(half);
    }
    free(samples);
}

/* A few lines of a short signal, between bins, are found to the last digits, as is the highest frequency. */
static void short_signals(void **unused) {
    (void)unused;
    static const int counts[] = {64, 100, 131, 256};
    for (size_t c = 0; c < sizeof counts / sizeof counts[0]; c++)
        for (int k = 0; k < 6; k++) {
            enum { most = 4 };
            int count = counts[c], found;
            double samples[256], bin = 8 + 0.37 * k, fraction, power;
            double other = 8 + 0.37 * k + 11.3;
            for (int j = 0; j < count; j++)
                samples[j] = -3 + 0.8 * cos(2 * M_PI * bin * j / count + k - 2.5) +
                             0.05 * cos(2 * M_PI * other * j / count + 1);
            saltus_signal signal = {.samples = samples, .count = count, .per_period = 4};
            saltus_spectral_line lines[most];
            saltus_message message = {.text = ""};
            check_ok(saltus_signal_lines(&signal, 0, most, lines, &found, &fraction, &message), &message);
            assert_int_equal(found, 2);
            check_near(lines[0].frequency, 4 * bin / count, 1e-4 / count);
            check_near(lines[0].amplitude, 0.8, 1e-5);
            check_near(lines[0].phase, k - 2.5, 3e-5);
            check_near(lines[1].frequency, 4 * other / count, 1e-3 / count);
            check_near(lines[1].amplitude, 0.05, 1e-5);
            check_near(lines[1].phase, 1, 3e-4);
            check_near(lines[0].decibels, 0, 1e-12);
            check_near(lines[1].decibels, 20 * log10(lines[1].amplitude / lines[0].amplitude), 1e-9);
            assert_true(fraction < 1e-8);
            double mean = 0, variance = 0;
            for (int j = 0; j < count; j++)
                mean += samples[j] / count;
            for (int j = 0; j < count; j++)
                variance += pow(samples[j] - mean, 2) / count;
            power = 0.5 * lines[0].amplitude * lines[0].amplitude;
            check_near(lines[0].share, power / variance, 1e-9);
        }
}

/* Lines are limited in number, in frequency and in their distance by the length. */
static void lines_within_limits(void **unused) {
    (void)unused;
    enum { count = 1024, per_period = 8, most = 8 };
    double samples[count], fraction;
    saltus_spectral_line lines[most + 1];
    saltus_message message = {.text = ""};
    saltus_signal signal = {.samples = samples, .count = count, .per_period = per_period};
    int found;
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    static const double frequency[] = {0.31, 0.9, 1.53, 2.2, 3.1}, amplitude[] = {0.3, 1, 0.5, 0.7, 0.4};
    for (int j = 0; j < count; j++) {
        samples[j] = gsl_ran_gaussian(rng, 1e-3);
        for (int l = 0; l < 5; l++)
            samples[j] += amplitude[l] * cos(2 * M_PI * frequency[l] * j / per_period + l);
    }
    check_ok(saltus_signal_lines(&signal, 0, most, lines, &found, &fraction, &message), &message);
    assert_int_equal(found, 5);
    check_near(fraction, 1e-6 / 0.995, 0.2e-6);
    for (int upto = 1; upto <= 5; upto++) {
        double power = 0, noise = 1e-6 * (frequency[upto - 1] + 0.15) / (per_period / 2.0);
        for (int l = 0; l < upto; l++)
            power += 0.5 * amplitude[l] * amplitude[l];
        check_ok(saltus_signal_lines(&signal, frequency[upto - 1] + 0.15, most, lines, &found, &fraction,
                                     &message),
                 &message);
        assert_int_equal(found, upto);
        check_near(fraction, noise / power, 0.5 * noise / power);
        for (int l = 0; l < found; l++)
            check_near(lines[l].frequency, frequency[l], 1e-5);
    }
    for (int room_for = 1; room_for < 5; room_for++) {
        lines[room_for].amplitude = -7;
        check_ok(saltus_signal_lines(&signal, 0, room_for, lines, &found, &fraction, &message), &message);
        assert_int_equal(found, room_for);
        assert_true(lines[room_for].amplitude == -7 && fraction > 0.01 && fraction < 1);
        for (int l = 1; l < found; l++)
            assert_true(lines[l].frequency > lines[l - 1].frequency);
    }
    for (int apart = 2; apart <= 8; apart += 2) {
        for (int j = 0; j < count; j++)
            samples[j] = cos(2 * M_PI * 100.0 * j / count) + cos(2 * M_PI * (100.0 + apart) * j / count + 1) +
                         gsl_ran_gaussian(rng, 1e-3);
        check_ok(saltus_signal_lines(&signal, 0, most, lines, &found, &fraction, &message), &message);
        if (apart < 4)
            assert_true(found < 2 && fraction > 0.1);
        else if (apart >= 6) {
            assert_int_equal(found, 2);
            check_near(lines[1].frequency - lines[0].frequency, apart * (double)per_period / count, 1e-5);
            assert_true(fraction < 1e-5);
        }
    }
    gsl_rng_free(rng);
}

/* Sines of amplitude 1 at equally spaced bins of a signal, with various phases. */
static void fill_comb(double *samples, int count, int first, int spacing, int lines, unsigned long seed) {
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_taus2);
    gsl_rng_set(rng, seed);
    memset(samples, 0, (size_t)count * sizeof *samples);
    for (int k = 0; k < lines; k++) {
        double phase = 2 * M_PI * gsl_rng_uniform(rng);
        samples[first + k * spacing] = 0.5 * count * cos(phase);
        samples[count - first - k * spacing] = 0.5 * count * sin(phase);
    }
    gsl_fft_halfcomplex_radix2_inverse(samples, 1, (size_t)count);
    gsl_rng_free(rng);
}

/* 512 lines of a series and 4096 of a density are found; of one more its share of the variance remains. */
static void as_many_lines_as_promised(void **unused) {
    (void)unused;
    enum { few = 1 << 13, many = 1 << 17 };
    double *samples = room(many);
    for (int lines = 511; lines <= 514; lines++) {
        fill_comb(samples, few, 20, 7, lines, (unsigned long)lines);
        double left = lines > 512 ? (lines - 512.0) / lines : 0;
        check_near(broadband_of(samples, few), left, 1e-9);
    }
    for (int lines = 4095; lines <= 4097; lines++) {
        fill_comb(samples, many, 200, 7, lines, (unsigned long)lines);
        saltus_spectrum s = welch_of(samples, many, 32, 1024);
        assert_int_equal(s.line_count, lines < 4096 ? lines : 4096);
        check_near(s.broadband, lines > 4096 ? 1.0 / lines : 0, 1e-9);
        assert_true(s.trustworthy > (200 + 7 * lines) * 32.0 / many); /* all of them are examined */
        saltus_spectrum_clear(&s);
    }
    free(samples);
}

/* Two lines are separated if at least 4 over the signal's length apart, many equal ones from 6 on, anywhere
 * between bins. Closer than 3 they stay in the continuum. */
static void near_lines_are_told_apart(void **unused) {
    (void)unused;
    enum { count = 1024, most = 40 };
    double samples[count], fraction;
    saltus_spectral_line lines[most];
    saltus_signal signal = {.samples = samples, .count = count, .per_period = 1};
    saltus_message message = {.text = ""};
    int found;
    for (int several = 0; several <= 1; several++)
        for (int eighths = 0; eighths < 8; eighths++)
            for (int k = 0; k < 5; k++) {
                double apart = k == 0 ? 2.9 : (several ? 6 : 4) + 0.3 * (k - 1), first = 60 + 0.125 * eighths;
                int made = several ? 30 : 2;
                for (int j = 0; j < count; j++) {
                    samples[j] = 0;
                    for (int l = 0; l < made; l++)
                        samples[j] += cos(2 * M_PI * (first + l * apart) * j / count + l * l);
                }
                check_ok(saltus_signal_lines(&signal, 0, most, lines, &found, &fraction, &message), &message);
                if (k == 0) {
                    assert_true(found < made && fraction > 0.3);
                    continue;
                }
                assert_int_equal(found, made);
                assert_true(fraction < 1e-6);
                for (int l = 0; l < made; l++) {
                    check_near(lines[l].frequency * count, first + l * apart, 1e-3);
                    check_near(lines[l].amplitude, 1, 1e-4);
                }
            }
}

/* The size of rounding: a share of the largest value, or what the signal states. */
static void rounding_is_no_motion(void **unused) {
    (void)unused;
    enum { count = 128 };
    double samples[count], fraction;
    for (int k = 0; k < 4; k++) {
        double mean = k % 2 ? 1e6 : 1e-6, size = 1e-13 * mean, rounding = k / 2 ? 2 * size : 0;
        for (int j = 0; j < count; j++)
            samples[j] = mean + size * (j % 2 ? -1 : 1);
        saltus_signal signal = {.samples = samples, .count = count, .per_period = 16, .rounding = rounding};
        saltus_spectral_line lines[2];
        saltus_spectrum s, w;
        int found;
        assert_int_equal(saltus_signal_orbits(&signal, 1, &s, NULL), SALTUS_OK);
        assert_int_equal(saltus_signal_welch(&signal, 4, 0.95, &w, NULL), SALTUS_OK);
        assert_int_equal(saltus_signal_lines(&signal, 0, 2, lines, &found, &fraction, NULL), SALTUS_OK);
        assert_int_equal(s.kind, k / 2 ? SALTUS_SPECTRUM_CONSTANT : SALTUS_SPECTRUM_LINES);
        assert_int_equal(w.kind, k / 2 ? SALTUS_SPECTRUM_CONSTANT : SALTUS_SPECTRUM_WELCH);
        assert_int_equal(found, k / 2 ? 0 : 1);
        check_near(s.mean, mean, 1e-12 * mean);
        saltus_spectrum_clear(&s);
        saltus_spectrum_clear(&w);
    }
}

/* Rest, and signals that cannot be analysed */

static void rest_has_no_spectrum(void **unused) {
    (void)unused;
    enum { count = 128 };
    double samples[count];
    for (int j = 0; j < count; j++)
        samples[j] = -3 + 1e-15 * (j % 2);
    for (int welch = 0; welch < 2; welch++) {
        saltus_spectrum s = welch ? welch_of(samples, count, 16, 4) : orbits_of(samples, count, 16, 1);
        assert_int_equal(s.kind, SALTUS_SPECTRUM_CONSTANT);
        check_near(s.mean, -3, 1e-14);
        assert_true(s.variance == 0 && s.line_count == 0 && s.bins == 0 && s.broadband == 0);
        saltus_spectrum_clear(&s);
    }
    assert_true(broadband_of(samples, count) == 0);
    for (int j = 0; j < count; j++)
        samples[j] = 1e-13 * sin(j);
    saltus_signal signal = {.samples = samples, .count = count, .per_period = 16, .rounding = 1e-12};
    saltus_spectrum s;
    assert_int_equal(saltus_signal_orbits(&signal, 1, &s, NULL), SALTUS_OK);
    assert_int_equal(s.kind, SALTUS_SPECTRUM_CONSTANT);
    assert_true(s.mean == 0);
}

static void unsuitable_input(void **unused) {
    (void)unused;
    enum { count = 128 };
    double samples[count] = {0}, fraction;
    saltus_spectral_line lines[4];
    saltus_signal signal = {.samples = samples, .count = count, .per_period = 16};
    saltus_spectrum s;
    saltus_message message = {.text = ""};
    int line_count;
    samples[7] = 1;
    assert_int_equal(saltus_signal_orbits(&signal, 3, &s, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "whole orbits"));
    assert_int_equal(saltus_signal_orbits(&signal, 0, &s, &message), SALTUS_BAD_INPUT);
    assert_int_equal(saltus_signal_orbits(&signal, -1, &s, &message), SALTUS_BAD_INPUT);
    assert_int_equal(saltus_signal_welch(&signal, 9, 0.95, &s, &message), SALTUS_BAD_INPUT);
    assert_int_equal(saltus_signal_welch(&signal, 0, 0.95, &s, &message), SALTUS_BAD_INPUT);
    assert_int_equal(saltus_signal_welch(&signal, 2, 0.95, &s, &message), SALTUS_BAD_INPUT);
    assert_int_equal(saltus_signal_welch(&signal, 4, 1, &s, &message), SALTUS_BAD_INPUT);
    assert_int_equal(saltus_signal_welch(&signal, 4, NAN, &s, &message), SALTUS_BAD_INPUT);
    assert_int_equal(saltus_series_broadband(samples, 63, &fraction, &message), SALTUS_BAD_INPUT);
    assert_int_equal(saltus_series_broadband(samples, 0, &fraction, &message), SALTUS_BAD_INPUT);
    assert_int_equal(saltus_signal_lines(&signal, NAN, 4, lines, &line_count, &fraction, &message),
                     SALTUS_BAD_INPUT);
    assert_int_equal(saltus_signal_lines(&signal, 0, 0, lines, &line_count, &fraction, &message),
                     SALTUS_BAD_INPUT);
    signal.count = 63;
    assert_int_equal(saltus_signal_lines(&signal, 0, 4, lines, &line_count, &fraction, &message),
                     SALTUS_BAD_INPUT);
    signal.count = 64;
    check_ok(saltus_signal_lines(&signal, 0, 4, lines, &line_count, &fraction, &message), &message);
    check_ok(saltus_series_broadband(samples, 64, &fraction, &message), &message);
    signal.count = count;
    samples[100] = NAN;
    assert_int_equal(saltus_signal_orbits(&signal, 1, &s, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "sample 100"));
    samples[100] = 1e200;
    assert_int_equal(saltus_signal_welch(&signal, 4, 0.95, &s, &message), SALTUS_BAD_INPUT);
    samples[100] = -INFINITY;
    assert_int_equal(saltus_series_broadband(samples, count, &fraction, &message), SALTUS_BAD_INPUT);
    signal.per_period = 0;
    assert_int_equal(saltus_signal_orbits(&signal, 1, &s, &message), SALTUS_BAD_INPUT);
}

/* Motions */

static saltus_motion classify(const saltus_system *system, long long transient) {
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double state[20];
    options.transient = transient;
    check_ok(saltus_system_default_state(system, state, &message), &message);
    check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
    return motion;
}

static saltus_system *pipe_with_stop(double omega, double d) {
    saltus_spec spec = pipe_spec(5, omega);
    add_stop(&spec, d, 0.9, SALTUS_UPPER);
    return build(&spec);
}

static double complex line_of(const saltus_spectrum *s, int k) {
    return s->lines[k - 1].amplitude * cexp(I * s->lines[k - 1].phase);
}

/* Figure 7(d): lines only at multiples of omega/4; the velocity's lines are those of the displacement times i
 * omega k/4. */
static void figure_7d(void **unused) {
    (void)unused;
    saltus_system *system = pipe_with_stop(42, 0.035);
    saltus_motion motion = classify(system, 20000);
    saltus_spectrum_options options = saltus_spectrum_defaults();
    saltus_message message = {.text = ""};
    saltus_spectra spectra;
    assert_string_equal(motion.label, "4/4");
    check_ok(saltus_motion_spectra(system, &motion, &options, &spectra, &message), &message);
    const saltus_spectrum *x = &spectra.spectra[0], *v = &spectra.spectra[1];
    assert_int_equal(spectra.analysed, 32);
    for (int k = 0; k < 2; k++) {
        assert_int_equal(spectra.spectra[k].kind, SALTUS_SPECTRUM_LINES);
        assert_int_equal(spectra.spectra[k].periods, 4);
        assert_true(spectra.spectra[k].between < 1e-10);
        assert_true(spectra.spectra[k].broadband < (k ? 1e-17 : 1e-20)); /* rounding, and its derivative */
        assert_true(spectra.spectra[k].trustworthy >= 32);
        check_near(spectra.spectra[k].parseval, 0, 1e-12);
    }
    /* All lines exist: none is below 1e-6 of the highest up to 4 omega. */
    for (int k = 0; k < 16; k++) {
        double complex rate = 42 * x->lines[k].frequency * I * line_of(x, k + 1);
        assert_true(x->lines[k].decibels > -120);
        check_near(cabs(rate - line_of(v, k + 1)), 0, 1e-12 * v->lines[0].amplitude);
    }
    saltus_spectra_clear(&spectra);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

/* Lines 1 to `count` of an orbit's observed displacement and velocity by Gauss' rule, between contacts, where
 * the motion is analytic. */
static void integrate_lines(const saltus_system *system, const double *state, int periods, int count,
                            double complex (*lines)[2]) {
    enum { nodes = 16, pieces_a_period = 32, contacts_max = 1000 };
    saltus_flow_options flowing = saltus_flow_defaults();
    gsl_integration_glfixed_table *rule = gsl_integration_glfixed_table_alloc(nodes);
    double ends[contacts_max] = {0};
    int pieces = 0;
    saltus_flow *flow = open_flow(system, &flowing, 0, state);
    while (ends[pieces] < periods) {
        assert_true(pieces + 1 < contacts_max);
        ends[++pieces] = saltus_time_periods(advance(flow, periods, SALTUS_WATCH_CONTACT).time);
    }
    saltus_flow_free(flow);
    flow = open_flow(system, &flowing, 0, state);
    for (int k = 0; k < count; k++)
        lines[k][0] = lines[k][1] = 0;
    for (int piece = 0; piece < pieces; piece++) {
        double from = ends[piece], long_piece = ends[piece + 1] - from;
        int parts = 1 + (int)(long_piece * pieces_a_period);
        for (int part = 0; part < parts; part++) {
            double begin = from + long_piece * part / parts, end = from + long_piece * (part + 1) / parts;
            for (size_t node = 0; node < nodes; node++) {
                double time, weight, now[SALTUS_STATE_MAX];
                gsl_integration_glfixed_point(begin, end, node, &time, &weight, rule);
                advance(flow, time, 0);
                saltus_flow_state(flow, 0, now);
                double value[2] = {saltus_system_observed(system, now),
                                   saltus_system_observed(system, now + saltus_system_dof(system))};
                for (int k = 0; k < count; k++)
                    for (int q = 0; q < 2; q++)
                        lines[k][q] +=
                            2 * weight / periods * value[q] * cexp(-2 * M_PI * I * (k + 1) * time / periods);
            }
        }
    }
    saltus_flow_free(flow);
    gsl_integration_glfixed_table_free(rule);
}

/* Lines of orbits with impacts, complete chatter and lasting contact are those of the integrals, to 1e-11 of
 * the highest, with few samples; a velocity's are those of the displacement's derivative, without a mean. */
static void lines_of_orbits_are_exact(void **unused) {
    (void)unused;
    enum { lines_checked = 32 };
    static const struct {
        double N, omega, d, r;
        saltus_sides sides;
    } scenes[] = {{5, 42, 0.035, 0.9, SALTUS_UPPER},
                  {1, 14, 0.035, 0.8, SALTUS_BOTH},
                  {5, 10, 0.025, 0.9, SALTUS_UPPER},
                  {2, 30, 0.02, 0.6, SALTUS_LOWER}};
    for (size_t c = 0; c < sizeof scenes / sizeof scenes[0]; c++) {
        saltus_spec spec = pipe_spec(scenes[c].N, scenes[c].omega);
        add_stop(&spec, scenes[c].d, scenes[c].r, scenes[c].sides);
        saltus_system *system = build(&spec);
        saltus_motion motion = classify(system, 2000);
        saltus_spectrum_options options = saltus_spectrum_defaults();
        saltus_message message = {.text = ""};
        saltus_spectra spectra;
        double complex lines[lines_checked][2];
        assert_int_equal(motion.verdict, SALTUS_PERIODIC);
        options.per_period = 2048;
        options.anew = true;
        check_ok(saltus_motion_spectra(system, &motion, &options, &spectra, &message), &message);
        integrate_lines(system, motion.state, motion.periods, lines_checked, lines);
        double highest[2] = {0};
        for (int q = 0; q < 2; q++)
            for (int k = 1; k <= spectra.spectra[q].line_count; k++)
                highest[q] = fmax(highest[q], spectra.spectra[q].lines[k - 1].amplitude);
        assert_true(spectra.spectra[1].mean == 0);
        for (int k = 1; k <= lines_checked; k++) {
            double complex found[2] = {line_of(&spectra.spectra[0], k), line_of(&spectra.spectra[1], k)};
            double rate = scenes[c].omega * k / motion.periods;
            for (int q = 0; q < 2; q++)
                check_near(cabs(found[q] - lines[k - 1][q]), 0, 1e-11 * highest[0] * (q ? rate : 1));
            check_near(cabs(found[1] - I * rate * found[0]), 0, 1e-11 * highest[1]);
        }
        saltus_spectra_clear(&spectra);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

/* The density of a velocity with jumps is trusted as far as the displacement's: up to there it agrees with
 * sixteen times as many samples. */
static void densities_of_velocities_are_trusted(void **unused) {
    (void)unused;
    saltus_system *system = pipe_with_stop(10, 0.035);
    saltus_message message = {.text = ""};
    saltus_spectra spectra[2];
    double state[10];
    saltus_spectrum_options options = saltus_spectrum_defaults();
    check_ok(saltus_system_default_state(system, state, &message), &message);
    check_ok(saltus_motion_settle(system, &options.flow, 200, state, &message), &message);
    options.periods = 128;
    for (int fine = 0; fine < 2; fine++) {
        options.per_period = fine ? 1024 : 64;
        check_ok(saltus_spectra_run(system, state, 0, &options, &spectra[fine], &message), &message);
    }
    const saltus_spectrum *x = &spectra[0].spectra[0], *v = &spectra[0].spectra[1],
                          *true_v = &spectra[1].spectra[1];
    assert_true(v->trustworthy >= 0.9 * x->trustworthy && v->trustworthy > 4);
    check_near(v->mean, true_v->mean, 1e-3 * sqrt(v->variance));
    double tolerance = 0, share = 0;
    for (long long k = 1; (double)k * v->resolution <= x->trustworthy; k++) {
        tolerance += 0.01 * true_v->density[k];
        share += fabs(v->density[k] - true_v->density[k]);
    }
    assert_true(share < tolerance);
    for (int fine = 0; fine < 2; fine++)
        saltus_spectra_clear(&spectra[fine]);
    saltus_system_free(system);
}

/* The linear oscillator's response is one line, known in closed form; also of --of q1 and v1. */
static void closed_form_response(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 1, 0.05, 1.5);
    saltus_system *system = build(&spec);
    saltus_motion motion = classify(system, 20000);
    saltus_spectrum_options options = saltus_spectrum_defaults();
    saltus_message message = {.text = ""};
    saltus_spectra spectra;
    check_ok(saltus_quantity_parse(system, "q1", &options.quantities[0], &message), &message);
    check_ok(saltus_quantity_parse(system, "v1", &options.quantities[1], &message), &message);
    check_ok(saltus_motion_spectra(system, &motion, &options, &spectra, &message), &message);
    double complex response = 0.05 / (1 - 2.25 + 0.15 * I);
    for (int k = 0; k < 2; k++) {
        const saltus_spectrum *s = &spectra.spectra[k];
        double complex line = response * (k ? 1.5 * I : 1);
        check_near(s->lines[0].amplitude, cabs(line), 1e-10 * cabs(line));
        check_near(s->lines[0].phase, carg(line), 1e-10);
        check_near(s->mean, 0, 1e-12);
        assert_true(s->lines[1].decibels < -200 && s->between < 1e-10);
    }
    saltus_spectra_clear(&spectra);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

/* Chaos: a continuum beside the response at omega/2, whose phase slips so rarely that it can pass for a line;
 * the number of reports does not change the numbers. */
static void chaos_has_a_continuum(void **unused) {
    (void)unused;
    saltus_system *system = pipe_with_stop(10, 0.035);
    saltus_spectrum_options options = saltus_spectrum_defaults();
    saltus_message message = {.text = ""};
    saltus_spectra spectra, again;
    double state[10];
    check_ok(saltus_system_default_state(system, state, &message), &message);
    check_ok(saltus_motion_settle(system, &options.flow, 200, state, &message), &message);
    options.periods = 2048;
    options.per_period = 32;
    check_ok(saltus_spectra_run(system, state, 0, &options, &spectra, &message), &message);
    check_ok(saltus_spectra_run(system, state, 0, &options, &again, &message), &message);
    for (int k = 0; k < 2; k++) {
        const saltus_spectrum *s = &spectra.spectra[k];
        assert_int_equal(s->kind, SALTUS_SPECTRUM_WELCH);
        assert_int_equal(s->segment_periods, 128);
        assert_int_equal(s->segments, 31);
        assert_true(s->broadband > 0.1);
        check_near(s->parseval, 0, 1e-12);
        assert_memory_equal(s->density, again.spectra[k].density, (size_t)s->bins * sizeof(double));
    }
    saltus_spectra_clear(&spectra);
    saltus_spectra_clear(&again);
    saltus_system_free(system);
}

/* An unstable orbit is left in one long run, and kept if each orbit begins anew. */
static void unstable_orbits_begin_anew(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 42);
    saltus_system *system = build(&spec);
    saltus_orbit_options shooting = saltus_orbit_defaults();
    saltus_spectrum_options options = saltus_spectrum_defaults();
    saltus_message message = {.text = ""};
    saltus_orbit orbit;
    double guess[10] = {1e-9};
    /* The straight pipe, disturbed below the visible rounding, under a load that buckles it. */
    check_ok(saltus_orbit_find(system, 1, guess, &shooting, &orbit, &message), &message);
    assert_true(exp(orbit.multipliers[0].log_modulus) > 1.1);
    orbit.state[0] += 1e-8;
    options.per_period = 64;
    options.periods = 16;
    options.quantity_count = 1;
    double between[2];
    for (int anew = 0; anew < 2; anew++) {
        saltus_spectra spectra;
        options.anew = anew;
        check_ok(saltus_spectra_run(system, orbit.state, 1, &options, &spectra, &message), &message);
        between[anew] = spectra.spectra[0].between;
        saltus_spectra_clear(&spectra);
    }
    assert_true(between[0] > 0.1 && between[1] < 1e-12);
    saltus_orbit_clear(&orbit);
    saltus_system_free(system);
}

/* Held by the stop under a pulsating flow: the stop point rests, mode 2 follows the forcing. */
static void held_pipe(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 42);
    set_parameter(&spec, "sigma", 0.01);
    add_stop(&spec, 0.01, 0.5, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_motion motion = classify(system, 20000);
    saltus_spectrum_options options = saltus_spectrum_defaults();
    saltus_message message = {.text = ""};
    saltus_spectra spectra;
    check_ok(saltus_quantity_parse(system, "q2", &options.quantities[1], &message), &message);
    check_ok(saltus_motion_spectra(system, &motion, &options, &spectra, &message), &message);
    assert_int_equal(spectra.spectra[0].kind, SALTUS_SPECTRUM_CONSTANT);
    check_near(spectra.spectra[0].mean, 0.01, 1e-15);
    assert_int_equal(spectra.spectra[1].kind, SALTUS_SPECTRUM_LINES);
    assert_true(spectra.spectra[1].lines[0].share > 0.99);
    saltus_spectra_clear(&spectra);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

static saltus_system *struck_oscillator(double c, double omega) {
    saltus_spec spec = oscillator_spec(c, 1, 1, omega);
    add_stop(&spec, omega == 1 ? 1 : 0, 0.8, SALTUS_UPPER);
    return build(&spec);
}

/* A motion's spectra agree with samples taken by hand: of whole orbits, with the lines of many samples, and
 * by Welch's method. */
static void samples_are_those_of_the_flow(void **unused) {
    (void)unused;
    enum { per_period = 256, periods = 48 };
    saltus_message message = {.text = ""};
    for (int chaos = 0; chaos < 2; chaos++) {
        saltus_system *system = struck_oscillator(0.1, chaos ? 0.8 : 1);
        saltus_spectrum_options options = saltus_spectrum_defaults();
        saltus_spectra spectra;
        const int taken = chaos ? per_period : 64 * per_period, count = periods * taken;
        double state[2] = {-0.3, 0.1}, *samples[2] = {room(count), room(count)}, *primitive = room(count);
        options.per_period = per_period;
        options.periods = periods;
        options.confidence = 0.8;
        check_ok(saltus_motion_settle(system, &options.flow, 300, state, &message), &message);
        check_ok(saltus_spectra_run(system, state, !chaos, &options, &spectra, &message), &message);
        saltus_flow *flow = open_flow(system, &options.flow, 0, state);
        for (int j = 0; j < count; j++) {
            saltus_event event;
            double now[2];
            saltus_time time = {j / taken, (double)(j % taken) / taken};
            check_ok(saltus_flow_advance(flow, time, 0, &event, &message), &message);
            saltus_flow_state(flow, 0, now);
            samples[0][j] = now[0];
            samples[1][j] = now[1];
            primitive[j] = now[0] / saltus_system_period(system);
        }
        double impacts = (double)saltus_flow_information(flow, 0).impacts;
        assert_true(impacts > 0);
        assert_int_equal(spectra.count, 2);
        assert_int_equal(spectra.periods, !chaos);
        assert_int_equal(spectra.analysed, periods);
        assert_int_equal(spectra.per_period, per_period);
        for (int q = 0; q < 2; q++) {
            const saltus_spectrum *s = &spectra.spectra[q];
            saltus_signal signal = {.samples = samples[q],
                                    .count = count,
                                    .per_period = taken,
                                    .primitive = q ? primitive : NULL};
            saltus_spectrum own;
            assert_true(spectra.quantities[q].coordinate == 0 && spectra.quantities[q].velocity == (q == 1));
            if (chaos)
                check_ok(saltus_signal_welch(&signal, periods / 16, 0.8, &own, &message), &message);
            else
                check_ok(saltus_signal_orbits(&signal, 1, &own, &message), &message);
            assert_true(s->kind == own.kind && s->segments == own.segments &&
                        s->resolution == own.resolution);
            assert_true(s->confidence == own.confidence && s->orbits == own.orbits);
            check_near(s->mean, own.mean, 1e-6);
            /* The mean of samples has an error of second order in their distance at a corner, of first order
             * at a jump, times the change of the square's slope or value there. */
            double squares = 0, largest[2] = {0, 0}, mean = q && !chaos ? 0 : own.mean, apart = 1.0 / taken;
            for (int j = 0; j < count; j++) {
                squares += (samples[q][j] - mean) * (samples[q][j] - mean);
                for (int k = 0; k < 2; k++)
                    largest[k] = fmax(largest[k], fabs(samples[k][j]));
            }
            double each = q ? 0.5 * apart * largest[1] * largest[1]
                            : apart * apart / 3 * largest[0] * largest[1] * saltus_system_period(system);
            check_near(s->variance, squares / count, impacts / periods * each);
            for (long long k = 0; k < s->bins - 1; k++)
                check_near(s->density[k], own.density[k], 1e-6 * own.variance);
            saltus_spectrum_clear(&own);
        }
        free(samples[0]);
        free(samples[1]);
        free(primitive);
        saltus_flow_free(flow);
        saltus_spectra_clear(&spectra);
        saltus_system_free(system);
    }
}

/* Between two elastic stops a mass flies to and fro: its velocity is a square wave of +1 and -1, its
 * displacement a triangle. Pressed on one such stop it bounces for ever, with a sawtooth velocity and
 * parabolic displacement. The variances are those of these functions for any number of samples and any place
 * of the jumps between them; so are the square wave's lines. */
static void variances_are_those_of_the_motion(void **unused) {
    (void)unused;
    enum { per_period = 32, periods = 2 };
    static const double pressed = 1.5;
    for (int bounces = 0; bounces < 2; bounces++)
        for (int place = 0; place < 5; place++) {
            saltus_spec spec = oscillator_spec(0, 0, 0, 2 * M_PI);
            saltus_spectrum_options options = saltus_spectrum_defaults();
            saltus_message message = {.text = ""};
            saltus_spectra spectra;
            /* A bounce takes a period; at the first place impacts and samples coincide. */
            double since = place / 160.0, start[2] = {bounces ? -pressed * since * (1 - since) / 2 : since,
                                                      bounces ? pressed * (since - 0.5) : 1};
            if (bounces)
                set_parameter(&spec, "F0", pressed);
            add_stop(&spec, bounces ? 0 : 0.25, 1, bounces ? SALTUS_UPPER : SALTUS_BOTH);
            saltus_system *system = build(&spec);
            options.quantity_count = 2;
            options.quantities[0] = (saltus_quantity){0, true};
            options.quantities[1] = (saltus_quantity){0, false};
            options.per_period = per_period;
            options.periods = periods;
            options.anew = true;
            check_ok(saltus_spectra_run(system, start, 1, &options, &spectra, &message), &message);
            const saltus_spectrum *v = &spectra.spectra[0], *x = &spectra.spectra[1];
            check_near(v->variance, bounces ? pressed * pressed / 12 : 1, 1e-12);
            check_near(x->variance, bounces ? pressed * pressed / 720 : 1.0 / 48, 1e-13);
            for (int k = 1; k < v->line_count && !bounces; k++)
                check_near(cabs(line_of(v, k)), 4 / (M_PI * k) * fabs(sin(M_PI * k / 2)), 1e-12);
            saltus_spectra_clear(&spectra);
            saltus_system_free(system);
        }
}

/* Lines of a motion without a period have no number, and phases within half a turn. Failures leave nothing
 * behind. */
static void lines_without_a_period_have_no_number(void **unused) {
    (void)unused;
    enum { count = 2048, per_period = 16 };
    double samples[count];
    fill_mixed(samples, count, per_period);
    saltus_spectrum s = welch_of(samples, count, per_period, 16);
    assert_true(s.line_count >= 2);
    for (long long k = 0; k < s.line_count; k++)
        assert_true(s.lines[k].harmonic == 0 && fabs(s.lines[k].phase) <= M_PI && s.lines[k].decibels <= 0 &&
                    s.lines[k].share > 0 && s.lines[k].share <= 1);
    saltus_spectrum_clear(&s);
    assert_true(!s.density && !s.lines && s.bins == 0 && s.line_count == 0);
    saltus_spectrum_clear(&s);
    saltus_signal signal = {.samples = samples, .count = count, .per_period = per_period};
    samples[5] = INFINITY;
    assert_int_equal(saltus_signal_welch(&signal, 16, 0.95, &s, NULL), SALTUS_BAD_INPUT);
    assert_true(!s.density && !s.lines && s.bins == 0 && s.line_count == 0);
    assert_int_equal(saltus_signal_orbits(&signal, 16, &s, NULL), SALTUS_BAD_INPUT);
    assert_true(!s.density && !s.lines && s.bins == 0 && s.line_count == 0);
}

/* Default lengths. */
static void lengths_are_chosen(void **unused) {
    (void)unused;
    static const struct {
        int period;
        long long periods, segment; /* requested */
        long long analysed;
        int orbits;
        long long length; /* of segments */
    } cases[] = {{1, 0, 0, 8, 8, 0},     {3, 0, 0, 24, 8, 0},  {100, 0, 0, 500, 5, 0}, {300, 0, 0, 600, 2, 0},
                 {3, 16, 0, 15, 5, 0},   {3, 6, 0, 6, 2, 0},   {1, 32, 4, 32, 0, 4},   {0, 64, 0, 64, 0, 4},
                 {0, 64, 64, 64, 0, 64}, {0, 20, 0, 20, 0, 1}, {0, 0, 0, 2048, 0, 128}};
    saltus_system *system = struck_oscillator(0.1, 1);
    saltus_message message = {.text = ""};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_spectrum_options options = saltus_spectrum_defaults();
        saltus_spectra spectra;
        double state[2] = {0.2, 0.3};
        options.per_period = 64;
        options.periods = cases[k].periods;
        options.segment = cases[k].segment;
        options.quantity_count = 1;
        check_ok(saltus_spectra_run(system, state, cases[k].period, &options, &spectra, &message), &message);
        const saltus_spectrum *s = &spectra.spectra[0];
        assert_int_equal(spectra.count, 1);
        assert_int_equal(spectra.analysed, cases[k].analysed);
        assert_int_equal(s->count, 64 * cases[k].analysed);
        assert_int_equal(s->orbits, cases[k].orbits);
        assert_int_equal(s->segment_periods, cases[k].length);
        assert_int_equal(s->kind, cases[k].orbits ? SALTUS_SPECTRUM_LINES : SALTUS_SPECTRUM_WELCH);
        saltus_spectra_clear(&spectra);
    }
    saltus_system_free(system);
}

/* The fewest samples that make the spectra trustworthy up to the wanted frequency. */
static void samples_are_chosen(void **unused) {
    (void)unused;
    saltus_system *system = struck_oscillator(0.1, 1);
    saltus_message message = {.text = ""};
    double state[2] = {0.2, 0.3};
    saltus_spectrum_options options = saltus_spectrum_defaults();
    check_ok(saltus_motion_settle(system, &options.flow, 300, state, &message), &message);
    for (int welch = 0; welch < 2; welch++) {
        int before = 0;
        for (int k = 0; k < 3; k++) {
            const double reaches[] = {welch ? 2 : 4, 0, welch ? 40 : 1200};
            double reach = reaches[k] > 0 ? reaches[k] : welch ? 16 : 32;
            saltus_spectra spectra, fewer;
            options.quantity_count = 2;
            options.reach = reaches[k];
            options.per_period = 0;
            options.periods = welch ? 64 : 4;
            check_ok(saltus_spectra_run(system, state, !welch, &options, &spectra, &message), &message);
            assert_true(spectra.per_period >= before && spectra.per_period % 4 == 0);
            before = spectra.per_period;
            options.quantities[0] = (saltus_quantity){0, true};
            options.quantities[1] = (saltus_quantity){0, false};
            check_ok(saltus_spectra_run(system, state, !welch, &options, &fewer, &message), &message);
            assert_int_equal(fewer.per_period, before);
            assert_true(fewer.spectra[0].variance == spectra.spectra[1].variance);
            saltus_spectra_clear(&fewer);
            options.quantities[0] = (saltus_quantity){0, false};
            options.quantities[1] = (saltus_quantity){0, true};
            bool most = spectra.per_period >= (welch ? 2048 : 16384);
            if (!welch)
                for (int q = 0; q < 2; q++)
                    assert_true(most || spectra.spectra[q].trustworthy >= reach);
            if (!welch && spectra.per_period > 2048) {
                double trusted = INFINITY;
                options.per_period = spectra.per_period / 2;
                check_ok(saltus_spectra_run(system, state, 1, &options, &fewer, &message), &message);
                for (int q = 0; q < 2; q++)
                    trusted = fmin(trusted, fewer.spectra[q].trustworthy);
                assert_true(trusted < reach);
                saltus_spectra_clear(&fewer);
            }
            saltus_spectra_clear(&spectra);
        }
        assert_true(before > (welch ? 256 : 2048));
    }
    saltus_system_free(system);
}

/* A classified motion is analysed by its kind: an orbit by its lines, also an unstable one, which begins
 * anew; rest by one period; motion without a period by Welch's method. */
static void kinds_have_their_spectra(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    saltus_spectrum_options options = saltus_spectrum_defaults();
    options.per_period = 32;
    options.periods = 64;
    static const struct {
        double c, force, omega, load;
        saltus_verdict kind;
        saltus_spectrum_kind spectrum;
        int period;
    } cases[] = {{0.1, 1, 1, 0, SALTUS_PERIODIC, SALTUS_SPECTRUM_LINES, 1},
                 {0.1, 0, 1, 0, SALTUS_EQUILIBRIUM, SALTUS_SPECTRUM_CONSTANT, 1},
                 {0.1, 0, 1, 3, SALTUS_HELD, SALTUS_SPECTRUM_CONSTANT, 1},
                 {0.1, 0.5, 1, 3, SALTUS_HELD, SALTUS_SPECTRUM_CONSTANT, 1},
                 {0, 0.1, 0.6180339887498949, 0, SALTUS_IRREGULAR, SALTUS_SPECTRUM_WELCH, 0}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_spec spec = oscillator_spec(cases[k].c, 1, cases[k].force, cases[k].omega);
        saltus_classify_options how = saltus_classify_defaults();
        saltus_motion motion;
        saltus_spectra spectra;
        double state[2] = {0.4, 0};
        set_parameter(&spec, "F0", cases[k].load);
        add_stop(&spec, 1, 0.8, SALTUS_UPPER);
        saltus_system *system = build(&spec);
        how.measure = 0;
        how.transient = cases[k].period ? 20000 : 400;
        check_ok(saltus_classify(system, state, &how, &motion, &message), &message);
        assert_int_equal(motion.verdict, cases[k].kind);
        check_ok(saltus_motion_spectra(system, &motion, &options, &spectra, &message), &message);
        assert_int_equal(spectra.periods, cases[k].period);
        assert_int_equal(spectra.analysed, 64);
        for (int q = 0; q < 2; q++)
            assert_int_equal(spectra.spectra[q].kind, cases[k].spectrum);
        if (cases[k].kind == SALTUS_HELD)
            check_near(spectra.spectra[0].mean, 1, 1e-12);
        saltus_spectra_clear(&spectra);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

/* A quantity at rest has no spectrum, even if rounding moves it; another quantity of the same motion may have
 * one. */
static void resting_systems(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 1, 0, 1);
    add_stop(&spec, 1, 0.8, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_spectrum_options options = saltus_spectrum_defaults();
    saltus_message message = {.text = ""};
    options.per_period = 32;
    options.periods = 8;
    for (int k = 0; k < 4; k++) {
        saltus_spectra spectra;
        double state[2] = {k < 2 ? 1e-9 : 1e-6, 0};
        options.resting = k % 2;
        check_ok(saltus_spectra_run(system, state, 1, &options, &spectra, &message), &message);
        for (int q = 0; q < 2; q++)
            assert_int_equal(spectra.spectra[q].kind,
                             k == 1 ? SALTUS_SPECTRUM_CONSTANT : SALTUS_SPECTRUM_LINES);
        saltus_spectra_clear(&spectra);
    }
    saltus_system_free(system);
}

/* Quantities of two masses: each mass, and the observed combination of the stop's weights. */
static void quantities_of_two_masses(void **unused) {
    (void)unused;
    saltus_scene scene;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_load("two-mass", &scene, &message), &message);
    saltus_system *system = build(&scene.spec);
    saltus_spectrum_options options = saltus_spectrum_defaults();
    double state[4] = {0};
    options.per_period = 64;
    options.periods = 8;
    check_ok(saltus_motion_settle(system, &options.flow, 500, state, &message), &message);
    for (int rate = 0; rate < 2; rate++) {
        saltus_spectra spectra, masses;
        options.quantity_count = 1;
        options.quantities[0] = (saltus_quantity){0, rate};
        check_ok(saltus_spectra_run(system, state, 2, &options, &spectra, &message), &message);
        options.quantity_count = 2;
        options.quantities[0] = (saltus_quantity){1, rate};
        options.quantities[1] = (saltus_quantity){2, rate};
        check_ok(saltus_spectra_run(system, state, 2, &options, &masses, &message), &message);
        const saltus_spectrum *s = spectra.spectra, *m = masses.spectra;
        check_near(s->mean, m[0].mean - m[1].mean, 1e-12);
        for (long long k = 0; k < s->line_count; k++) {
            double complex whole = s->lines[k].amplitude * cexp(I * s->lines[k].phase),
                           first = m[0].lines[k].amplitude * cexp(I * m[0].lines[k].phase),
                           second = m[1].lines[k].amplitude * cexp(I * m[1].lines[k].phase);
            check_near(cabs(whole - (first - second)), 0, 1e-12);
        }
        saltus_spectra_clear(&spectra);
        saltus_spectra_clear(&masses);
    }
    saltus_system_free(system);
}

static void quantities_have_names(void **unused) {
    (void)unused;
    saltus_system *system = pipe_with_stop(42, 0.035);
    saltus_message message = {.text = ""};
    saltus_quantity quantity;
    static const char *const words[] = {
        "", "q", "q0", "q6", "v6", "q1x", "speed", "q-1", "q99999999999999999999"};
    for (size_t k = 0; k < sizeof words / sizeof words[0]; k++)
        assert_int_equal(saltus_quantity_parse(system, words[k], &quantity, &message), SALTUS_BAD_INPUT);
    static const char *const names[] = {"displacement", "velocity", "q5", "v1"};
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) {
        check_ok(saltus_quantity_parse(system, names[k], &quantity, &message), &message);
        assert_string_equal(saltus_quantity_name(system, quantity).text, names[k]);
    }
    saltus_system_free(system);
}

static void defaults_are_those_told(void **unused) {
    (void)unused;
    saltus_spectrum_options o = saltus_spectrum_defaults();
    saltus_flow_options flow = saltus_flow_defaults();
    assert_true(o.flow.rtol == flow.rtol && o.flow.atol == flow.atol && o.flow.integrator == flow.integrator);
    assert_true(o.quantity_count == 2 && o.quantities[0].coordinate == 0 && !o.quantities[0].velocity);
    assert_true(o.quantities[1].coordinate == 0 && o.quantities[1].velocity);
    assert_true(o.per_period == 0 && o.reach == 0 && o.periods == 0 && o.segment == 0);
    assert_true(o.confidence == 0.95 && !o.resting && !o.anew);
}

static void unsuitable_wishes(void **unused) {
    (void)unused;
    saltus_system *system = pipe_with_stop(42, 0.035);
    saltus_spectrum_options good = saltus_spectrum_defaults(), options;
    saltus_message message = {.text = ""};
    saltus_spectra spectra;
    double state[10] = {0.001};
    static const int per_period[] = {12, 18, 65540, -16};
    for (int wish = 0; wish < 13; wish++) {
        options = good;
        if (wish == 0)
            options.per_period = 18;
        else if (wish == 1)
            options.quantity_count = 3;
        else if (wish == 2)
            options.quantities[1].coordinate = 6;
        else if (wish == 3)
            options.periods = 7;
        else if (wish == 4)
            options.periods = 1000000000000;
        else if (wish == 5)
            options.segment = 9, options.periods = 8;
        else if (wish == 6)
            options.confidence = 0;
        else if (wish == 7)
            options.reach = NAN;
        else if (wish < 12)
            options.per_period = per_period[wish - 8];
        else
            options.segment = -1;
        assert_int_equal(saltus_spectra_run(system, state, 4, &options, &spectra, &message),
                         SALTUS_BAD_INPUT);
        assert_true(spectra.count == 0 && message.text[0]);
    }
    /* The least allowed. */
    options = good;
    options.per_period = 16;
    options.periods = 2;
    options.quantity_count = 1;
    check_ok(saltus_spectra_run(system, state, 1, &options, &spectra, &message), &message);
    assert_true(spectra.per_period == 16 && spectra.analysed == 2);
    saltus_spectra_clear(&spectra);
    state[0] = 0.05;
    assert_int_equal(saltus_spectra_run(system, state, 4, &good, &spectra, &message), SALTUS_BAD_INPUT);
    saltus_system_free(system);
}

/* The k-th allocation fails, for all k until none is left to fail. Leaks show under the address sanitizer. */
static saltus_status all_of_it(void) {
    saltus_spec spec = oscillator_spec(0.1, 1, 0.5, 1.5);
    saltus_system *system = NULL;
    saltus_message message = {.text = ""};
    saltus_spectrum_options options = saltus_spectrum_defaults();
    saltus_spectra spectra = {0};
    double state[2] = {0.3, 0};
    add_stop(&spec, 1, 0.8, SALTUS_UPPER);
    options.quantity_count = 1;
    saltus_status status = saltus_system_new(&spec, &system, &message);
    if (status == SALTUS_OK)
        status = saltus_spectra_run(system, state, 1, &options, &spectra, &message);
    saltus_spectra_clear(&spectra);
    options.periods = 16;
    options.per_period = 64;
    if (status == SALTUS_OK)
        status = saltus_spectra_run(system, state, 0, &options, &spectra, &message);
    saltus_spectra_clear(&spectra);
    saltus_system_free(system);
    return status;
}

static void failing_allocations(void **unused) {
    (void)unused;
    int refused = 0;
    for (long k = 1;; k++) {
        allocations = 0;
        failing = k;
        saltus_status status = all_of_it();
        failing = -1;
        if (allocations < k) {
            assert_int_equal(status, SALTUS_OK);
            break;
        }
        assert_int_equal(status, SALTUS_NO_MEMORY);
        refused++;
    }
    assert_true(refused > 20);
}

/* Quantities that a text observes, of the forced oscillator x = A cos(t - phi): a sum of displacements, a
 * square, a power with its mean, a function of time alone. */
static void observed_quantities_have_spectra(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {c: 0.2, k: 3, F: 0.5, omega: 1}\n"
                               "  motion: {x: -c*x' - k*x + F*cos(omega*t)}\n"
                               "  forcing: omega\n"
                               "  observe: {double: 2*x, square: x^2, power: x'*F*cos(omega*t)}\n"
                               "stop: {coordinate: x, d: 1, r: 0.8}\n";
    const double A = 0.5 / hypot(2, 0.2), lag = atan2(0.2, 2);
    const struct {
        const char *word;
        double mean, frequency, amplitude;
    } rows[] = {{"double", 0, 1, 2 * A},
                {"square", A * A / 2, 2, A * A / 2},
                {"power", 0.25 * A * sin(lag), 2, 0.25 * A}};
    saltus_scene scene;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_parse(text, strlen(text), "my.yaml", &scene, &message), &message);
    saltus_system *system = build(&scene.spec);
    const double state[] = {A * cos(lag), A * sin(lag)};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_spectrum_options options = saltus_spectrum_defaults();
        saltus_spectra spectra;
        options.quantity_count = 1;
        check_ok(saltus_quantity_parse(system, rows[k].word, &options.quantities[0], &message), &message);
        assert_string_equal(saltus_quantity_name(system, options.quantities[0]).text, rows[k].word);
        check_ok(saltus_spectra_run(system, state, 1, &options, &spectra, &message), &message);
        const saltus_spectrum *s = &spectra.spectra[0];
        check_near(s->mean, rows[k].mean, 1e-11);
        for (int l = 0; l < s->line_count; l++)
            check_near(s->lines[l].amplitude,
                       s->lines[l].frequency == rows[k].frequency ? rows[k].amplitude : 0, 1e-11);
        saltus_spectra_clear(&spectra);
    }
    saltus_quantity quantity;
    assert_int_equal(saltus_quantity_parse(system, "sum", &quantity, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "one of x, x', double, square, power"));
    saltus_system_free(system);
    saltus_scene_clear(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_lines_are_found),
        cmocka_unit_test(fastest_line),
        cmocka_unit_test(wrong_period_shows),
        cmocka_unit_test(parseval_holds),
        cmocka_unit_test(trust_is_deserved),
        cmocka_unit_test(smooth_signals_do_not_alias),
        cmocka_unit_test(white_noise_is_covered),
        cmocka_unit_test(one_segment),
        cmocka_unit_test(sine_has_its_power),
        cmocka_unit_test(incommensurate_lines),
        cmocka_unit_test(quasiperiodic_is_not_broadband),
        cmocka_unit_test(periodic_is_not_broadband),
        cmocka_unit_test(chaos_and_noise_are_broadband),
        cmocka_unit_test(noise_on_lines),
        cmocka_unit_test(welch_by_definition),
        cmocka_unit_test(bands_have_their_confidence),
        cmocka_unit_test(orbits_by_definition),
        cmocka_unit_test(trust_in_lines_by_definition),
        cmocka_unit_test(trust_in_densities_by_definition),
        cmocka_unit_test(short_signals),
        cmocka_unit_test(lines_within_limits),
        cmocka_unit_test(as_many_lines_as_promised),
        cmocka_unit_test(near_lines_are_told_apart),
        cmocka_unit_test(rounding_is_no_motion),
        cmocka_unit_test(samples_are_those_of_the_flow),
        cmocka_unit_test(variances_are_those_of_the_motion),
        cmocka_unit_test(lines_without_a_period_have_no_number),
        cmocka_unit_test(lengths_are_chosen),
        cmocka_unit_test(samples_are_chosen),
        cmocka_unit_test(kinds_have_their_spectra),
        cmocka_unit_test(resting_systems),
        cmocka_unit_test(quantities_of_two_masses),
        cmocka_unit_test(rest_has_no_spectrum),
        cmocka_unit_test(unsuitable_input),
        cmocka_unit_test(figure_7d),
        cmocka_unit_test(lines_of_orbits_are_exact),
        cmocka_unit_test(densities_of_velocities_are_trusted),
        cmocka_unit_test(closed_form_response),
        cmocka_unit_test(chaos_has_a_continuum),
        cmocka_unit_test(unstable_orbits_begin_anew),
        cmocka_unit_test(held_pipe),
        cmocka_unit_test(quantities_have_names),
        cmocka_unit_test(unsuitable_wishes),
        cmocka_unit_test(defaults_are_those_told),
        cmocka_unit_test(observed_quantities_have_spectra),
        cmocka_unit_test(failing_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
