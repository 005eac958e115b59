/* Spectra of sampled signals: lines of whole orbits, Welch's averaged density, and how far they can be
 * trusted.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "signal/spectrum.h"

#include <gsl/gsl_cdf.h>
#include <stdlib.h>
#include <string.h>

enum { welch_lines_max = 4096 };

static const double tolerance = 0.01; /* relative difference up to which two spectra agree */
static const double rounding = 1e-11; /* of the highest line: smaller differences are rounding */

void saltus_spectrum_clear(saltus_spectrum *spectrum) {
    free(spectrum->density);
    free(spectrum->lines);
    *spectrum = (saltus_spectrum){0};
}

/* Set mean and variance; the variance is 0 if the signal is constant. */
static void measure(const saltus_signal *signal, saltus_spectrum *s) {
    *s = (saltus_spectrum){.per_period = signal->per_period,
                           .count = signal->count,
                           .mean = saltus_signal_mean(signal),
                           .between = NAN,
                           .trustworthy = NAN};
    if (saltus_signal_moves(signal, s->mean))
        s->variance = saltus_signal_variance(signal, s->mean);
    else if (fabs(s->mean) <= signal->rounding)
        s->mean = 0;
}

/* Power of the transformed samples: in time, and in the bins of the transform. */
typedef struct parseval_sums {
    saltus_sum in_time, in_bins;
} parseval_sums;

static double parseval_error(const parseval_sums *sums) {
    double total = saltus_sum_of(sums->in_time);
    return total > 0 ? fabs(saltus_sum_of(sums->in_bins) - total) / total : 0;
}

static void transform_and_compare(saltus_transform *t, parseval_sums *sums) {
    for (long long j = 0; j < t->count; j++)
        saltus_sum_add(&sums->in_time, t->input[j] * t->input[j]);
    fftw_execute(t->plan);
    for (long long k = 0; k < t->bins; k++) {
        double re = creal(t->output[k]), im = cimag(t->output[k]);
        saltus_sum_add(&sums->in_bins,
                       saltus_bin_weight(k, t->count) * (re * re + im * im) / (double)t->count);
    }
}

/* Lines of a signal without its mean, in t->output: the transform divided by the number of samples. Corners
 * are removed before: a function of period `length` with the same corner is -slope length / 2 B2(x) - bend
 * length^2 / 6 B3(x), where B2 and B3 are Bernoulli polynomials of x = (t - time) / length in [0, 1); without
 * corners lines fall with the fourth power of their number. Its lines, (slope s^-2 + bend s^-3) / length at
 * s = 2 pi i k / length, turned to the corner's time, are added after. The transform of a primitive is
 * differentiated. Returns the error in Parseval's identity. */
static double transform_whole(saltus_transform *t, const saltus_signal *signal, double mean) {
    enum { stretch = 64 }; /* bins computed from one angle, so that rounding errors do not accumulate */
    const double length = (double)signal->count / signal->per_period;
    parseval_sums sums = {0};
    saltus_signal_steady(signal, mean, 0, t->count, t->input);
    for (long long c = 0; c < signal->corner_count; c++)
        for (long long j = 0; j < t->count; j++) {
            const saltus_corner *corner = &signal->corners[c];
            double x = (double)j / (double)t->count - corner->time / length;
            x -= floor(x);
            t->input[j] += corner->slope * length / 2 * (x * (x - 1) + 1.0 / 6) +
                           corner->bend * length * length / 6 * x * (x - 0.5) * (x - 1);
        }
    transform_and_compare(t, &sums);
    for (long long k = 0; k < t->bins; k++)
        t->output[k] /= (double)t->count;
    for (long long c = 0; c < signal->corner_count; c++) {
        const saltus_corner *corner = &signal->corners[c];
        const double turn = fmod(corner->time, length) / length;
        const double complex factor = cexp(-2 * M_PI * I * turn);
        double complex at = 1;
        for (long long k = 1; k < t->bins; k++) {
            const double angle = 2 * M_PI * (double)k, place = turn * (double)k;
            at = k % stretch == 1 ? cexp(-2 * M_PI * I * (place - floor(place))) : at * factor;
            t->output[k] -=
                at * length / (angle * angle) * (corner->slope - corner->bend * length * I / angle);
        }
    }
    for (long long k = 0; signal->primitive && k < t->bins; k++)
        t->output[k] *= 2 * M_PI * I * (double)k / length;
    return parseval_error(&sums);
}

/* Density, lines and the power between the lines. */
static void read_orbits(const saltus_transform *t, saltus_spectrum *s) {
    saltus_sum off = {0, 0};
    double highest = 0, between = 0;
    for (long long k = 0; k < t->bins; k++) {
        double weight = saltus_bin_weight(k, t->count), modulus = cabs(t->output[k]),
               power = weight * modulus * modulus;
        s->density[k] = power / s->resolution;
        if (k % s->orbits) {
            saltus_sum_add(&off, power);
            between = fmax(between, weight * modulus);
        } else if (k > 0) {
            long long harmonic = k / s->orbits;
            s->lines[s->line_count++] = (saltus_spectral_line){.harmonic = harmonic,
                                                               .frequency = (double)harmonic / s->periods,
                                                               .amplitude = weight * modulus,
                                                               .phase = carg(t->output[k]),
                                                               .share = power / s->variance};
            highest = fmax(highest, weight * modulus);
        }
    }
    s->broadband = saltus_sum_of(off) / s->variance;
    s->between = s->orbits == 1 ? NAN : highest > 0 ? between / highest : INFINITY;
    saltus_lines_rank(s->lines, s->line_count);
}

/* Find the line up to which the spectrum can be trusted. Leaving out every second sample doubles the
 * aliasing, so there is little of it where both spectra agree. A line may be weak by chance or symmetry, and
 * a velocity has little power at low frequencies: differences are relative to the largest line at or
 * above. */
static saltus_status trust_orbits(const saltus_signal *signal, const saltus_transform *all,
                                  saltus_spectrum *s, saltus_message *message) {
    saltus_transform half = {0};
    saltus_status status = saltus_transform_open(&half, signal->count / 2, message);
    double *samples = malloc((size_t)signal->count * sizeof *samples);
    if (status == SALTUS_OK && !samples)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory to look for aliasing");
    if (status == SALTUS_OK) {
        saltus_signal halved = saltus_signal_thinned(signal, 2, samples);
        transform_whole(&half, &halved, s->mean);
        long long lines = half.bins > 2 ? (half.bins - 2) / s->orbits : 0, trusted = lines;
        double highest = 0, reference = 0;
        for (long long n = 1; n <= lines; n++)
            highest = fmax(highest, cabs(all->output[n * s->orbits]));
        /* Downwards, as the reference is a running maximum; the lowest line that disagrees is the limit. */
        for (long long n = lines; n >= 1; n--) {
            double complex line = all->output[n * s->orbits];
            double difference = cabs(line - half.output[n * s->orbits]);
            reference = fmax(reference, cabs(line));
            if (!(difference <= fmax(tolerance * reference, rounding * highest)))
                trusted = n - 1;
        }
        s->trustworthy = (double)(trusted * s->orbits) * s->resolution;
    }
    free(samples);
    saltus_transform_close(&half);
    return status;
}

saltus_status saltus_signal_orbits(const saltus_signal *signal, int periods, saltus_spectrum *s,
                                   saltus_message *message) {
    *s = (saltus_spectrum){0};
    saltus_status status = saltus_signal_check(signal, message);
    if (status != SALTUS_OK)
        return status;
    long long orbit = (long long)periods * signal->per_period;
    if (periods < 1 || signal->count % orbit != 0)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%lld samples are not whole orbits of %d periods with %d samples each",
                           signal->count, periods, signal->per_period);
    measure(signal, s);
    if (s->variance == 0)
        return SALTUS_OK;
    if (signal->primitive) { /* the primitive is periodic: the mean is zero */
        s->mean = 0;
        s->variance = saltus_signal_variance(signal, 0);
    }
    s->kind = SALTUS_SPECTRUM_LINES;
    s->periods = periods;
    s->orbits = (int)(signal->count / orbit);
    s->resolution = 1.0 / ((double)periods * s->orbits);
    saltus_transform t = {0};
    status = saltus_transform_open(&t, signal->count, message);
    s->bins = t.bins;
    s->density = malloc((size_t)t.bins * sizeof *s->density);
    s->lines = malloc((size_t)(t.bins / s->orbits + 1) * sizeof *s->lines);
    if (status == SALTUS_OK && !(s->density && s->lines))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a spectrum of %lld bins", t.bins);
    if (status == SALTUS_OK) {
        s->parseval = transform_whole(&t, signal, s->mean);
        s->mean += creal(t.output[0]); /* the corner functions have zero mean, but not their samples */
        t.output[0] = 0;
        read_orbits(&t, s);
    }
    if (status == SALTUS_OK && signal->per_period % 2 == 0)
        status = trust_orbits(signal, &t, s, message);
    saltus_transform_close(&t);
    if (status != SALTUS_OK)
        saltus_spectrum_clear(s);
    return status;
}

/* Periodic Hann window; its transform has three bins. */
static double hann(long long j, long long length) {
    double sine = sin(M_PI * (double)j / (double)length);
    return sine * sine;
}

/* Averaged density of a signal with the given mean; `parseval` may be NULL. */
static saltus_status average_segments(const saltus_signal *signal, double mean, long long length,
                                      double *density, double *parseval, saltus_message *message) {
    saltus_transform t = {0};
    saltus_status status = saltus_transform_open(&t, length, message);
    double *window = malloc((size_t)length * sizeof *window), squares = 0;
    double *steady = malloc((size_t)length * sizeof *steady);
    double complex *segment = malloc((size_t)(length / 2 + 1) * sizeof *segment);
    if (status == SALTUS_OK && !(window && steady && segment))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a window of %lld samples", length);
    for (long long j = 0; status == SALTUS_OK && j < length; j++) {
        window[j] = hann(j, length);
        squares += window[j] * window[j];
    }
    parseval_sums sums = {0};
    long long hop = length / 2, segments = (signal->count - length) / hop + 1;
    for (long long m = 0; status == SALTUS_OK && m < segments; m++) {
        saltus_signal_steady(signal, mean, m * hop, length, steady);
        for (long long j = 0; j < length; j++)
            t.input[j] = window[j] * steady[j];
        transform_and_compare(&t, &sums);
        memcpy(segment, t.output, (size_t)t.bins * sizeof *segment);
        if (signal->primitive) {
            /* Of a primitive q the transform is that of w q' = (w q)' - w' q, because the window w vanishes
             * at both ends. */
            const double periods = (double)length / signal->per_period;
            for (long long j = 0; j < length; j++)
                t.input[j] = M_PI / periods * sin(2 * M_PI * (double)j / (double)length) * steady[j];
            fftw_execute(t.plan);
            for (long long k = 0; k < t.bins; k++)
                segment[k] = 2 * M_PI * I * (double)k / periods * segment[k] - t.output[k];
        }
        for (long long k = 0; k < t.bins; k++) {
            double re = creal(segment[k]), im = cimag(segment[k]);
            density[k] += saltus_bin_weight(k, length) * (re * re + im * im) /
                          (squares * signal->per_period * (double)segments);
        }
    }
    if (parseval)
        *parseval = parseval_error(&sums);
    free(window);
    free(steady);
    free(segment);
    saltus_transform_close(&t);
    return status;
}

/* Degrees of freedom of the mean of `segments` periodograms that overlap by half. Only windows half a length
 * apart are correlated; windows a whole length apart do not overlap. */
static double degrees_of_freedom(long long length, long long segments) {
    double square = 0, product = 0;
    for (long long j = 0; j < length; j++) {
        double window = hann(j, length);
        square += window * window;
        if (j + length / 2 < length)
            product += window * hann(j + length / 2, length);
    }
    double correlation = product * product / (square * square);
    return 2 * (double)segments / (1 + 2 * correlation * (1 - 1 / (double)segments));
}

/* The band of bin k >= 1. */
static int band_of(long long k) {
    enum { bands_per_octave = 8, bands_max = 26 * bands_per_octave };
    int band = (int)floor(bands_per_octave * log2((double)k) + 1e-9);
    return band < bands_max ? band : bands_max - 1;
}

/* Like trust_orbits, but band by band. */
static saltus_status trust_welch(const saltus_signal *signal, long long length, saltus_spectrum *s,
                                 saltus_message *message) {
    double *samples = malloc((size_t)(signal->count + 2) * sizeof *samples),
           *density = calloc((size_t)(length / 4 + 1), sizeof *density);
    saltus_status status = samples && density
                               ? SALTUS_OK
                               : saltus_fail(message, SALTUS_NO_MEMORY, "no memory to look for aliasing");
    if (status == SALTUS_OK) {
        saltus_signal halved = saltus_signal_thinned(signal, 2, samples);
        status = average_segments(&halved, saltus_signal_mean(&halved), length / 2, density, NULL, message);
    }
    if (status == SALTUS_OK) {
        long long last = length / 4 - 1, trusted = last > 0 ? last : 0;
        double peak = 0, reference = 0;
        for (long long k = 1; k <= last; k++)
            peak = fmax(peak, s->density[k]);
        for (long long k = trusted; k >= 1;) {
            double power = 0, power_half = 0;
            long long top = k;
            for (int band = band_of(k); k >= 1 && band_of(k) == band; k--) {
                power += s->density[k];
                power_half += density[k];
            }
            double bins = (double)(top - k);
            reference = fmax(reference, power / bins);
            if (!(fabs(power_half - power) <= bins * fmax(tolerance * reference, rounding * rounding * peak)))
                trusted = k;
        }
        s->trustworthy = (double)trusted * s->resolution;
    }
    free(density);
    free(samples);
    return status;
}

saltus_status saltus_signal_density(const saltus_signal *signal, long long segment_periods, double confidence,
                                    saltus_spectrum *s, saltus_message *message) {
    *s = (saltus_spectrum){0};
    saltus_status status = saltus_signal_check(signal, message);
    if (status != SALTUS_OK)
        return status;
    if (segment_periods < 1 || segment_periods > signal->count / signal->per_period)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "segments of %lld periods: must be from 1 to the signal's %lld periods",
                           segment_periods, signal->count / signal->per_period);
    if (segment_periods * signal->per_period < 64)
        return saltus_fail(message, SALTUS_BAD_INPUT, "segments of %lld samples: must have 64 at least",
                           segment_periods * signal->per_period);
    if (!(confidence > 0 && confidence < 1))
        return saltus_fail(message, SALTUS_BAD_INPUT, "confidence %g: must be between 0 and 1", confidence);
    measure(signal, s);
    if (s->variance == 0)
        return SALTUS_OK;
    long long length = segment_periods * signal->per_period;
    s->kind = SALTUS_SPECTRUM_WELCH;
    s->segment_periods = segment_periods;
    s->segments = (signal->count - length) / (length / 2) + 1;
    s->bins = length / 2 + 1;
    s->resolution = 1.0 / (double)segment_periods;
    s->degrees = degrees_of_freedom(length, s->segments);
    s->confidence = confidence;
    s->low = s->degrees / gsl_cdf_chisq_Qinv((1 - confidence) / 2, s->degrees);
    s->high = s->degrees / gsl_cdf_chisq_Pinv((1 - confidence) / 2, s->degrees);
    s->density = calloc((size_t)s->bins, sizeof *s->density);
    if (!s->density)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a spectrum of %lld bins", s->bins);
    if (status == SALTUS_OK)
        status = average_segments(signal, s->mean, length, s->density, &s->parseval, message);
    if (status == SALTUS_OK && signal->per_period % 2 == 0 && length % 4 == 0)
        status = trust_welch(signal, length, s, message);
    if (status != SALTUS_OK)
        saltus_spectrum_clear(s);
    return status;
}

saltus_status saltus_signal_welch(const saltus_signal *signal, long long segment_periods, double confidence,
                                  saltus_spectrum *s, saltus_message *message) {
    saltus_status status = saltus_signal_density(signal, segment_periods, confidence, s, message);
    if (status == SALTUS_OK && s->kind == SALTUS_SPECTRUM_WELCH) {
        int count = 0;
        double highest = s->trustworthy > 0 ? s->trustworthy : 0;
        s->lines = malloc(welch_lines_max * sizeof *s->lines);
        status = s->lines ? saltus_signal_lines(signal, highest, welch_lines_max, s->lines, &count,
                                                &s->broadband, message)
                          : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the lines of a spectrum");
        s->line_count = count;
    }
    if (status != SALTUS_OK)
        saltus_spectrum_clear(s);
    return status;
}
