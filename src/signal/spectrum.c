/* Spectra of sampled signals: lines of whole orbits, Welch's averaged density, and how far they can be
 * trusted.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "signal/spectrum.h"

#include <gsl/gsl_cdf.h>
#include <stdlib.h>

enum { welch_lines_max = 4096 };

static const double tolerance = 0.01; /* difference of two spectra that are trusted */
static const double rounding = 1e-11; /* of the highest line: below it two spectra differ by rounding alone */

void saltus_spectrum_clear(saltus_spectrum *spectrum) {
    free(spectrum->density);
    free(spectrum->lines);
    *spectrum = (saltus_spectrum){0};
}

/* Mean and variance; a variance of 0 says that the signal does not move. */
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

/* Whole orbits */

/* Transform of a signal without its mean, divided by the number of samples; the signal may be in t->input. */
static void transform_whole(saltus_transform *t, const saltus_signal *signal, double mean) {
    for (long long j = 0; j < t->count; j++)
        t->input[j] = signal->samples[j] - mean;
    fftw_execute(t->plan);
    for (long long k = 0; k < t->bins; k++)
        t->output[k] /= (double)t->count;
}

/* Density, lines and what lies between them. */
static void read_orbits(const saltus_transform *t, saltus_spectrum *s) {
    saltus_sum all = {0, 0}, off = {0, 0};
    double highest = 0, between = 0;
    for (long long k = 0; k < t->bins; k++) {
        double weight = saltus_bin_weight(k, t->count), modulus = cabs(t->output[k]),
               power = weight * modulus * modulus;
        s->density[k] = power / s->resolution;
        saltus_sum_add(&all, power);
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
    s->parseval = fabs(all.value + all.rest - s->variance) / s->variance;
    s->broadband = (off.value + off.rest) / s->variance;
    s->between = s->orbits == 1 ? NAN : highest > 0 ? between / highest : INFINITY;
    saltus_lines_rank(s->lines, s->line_count);
}

/* Up to which line the spectrum can be trusted: what aliases doubles when every second sample is left out, so
 * where both spectra agree there is little of it. A line may be weak by chance or symmetry, and at low
 * frequencies a velocity has little power: what aliases is held against the largest line at the same or a
 * higher frequency. */
static saltus_status trust_orbits(const saltus_signal *signal, const saltus_transform *all,
                                  saltus_spectrum *s, saltus_message *message) {
    saltus_transform half = {0};
    saltus_status status = saltus_transform_open(&half, signal->count / 2, message);
    if (status == SALTUS_OK) {
        saltus_signal halved = saltus_signal_thinned(signal, 2, half.input);
        transform_whole(&half, &halved, s->mean);
        long long lines = half.bins > 2 ? (half.bins - 2) / s->orbits : 0, trusted = lines;
        double highest = 0, reference = 0;
        for (long long n = 1; n <= lines; n++)
            highest = fmax(highest, cabs(all->output[n * s->orbits]));
        /* From above, as the reference grows on the way down: the lowest line that disagrees ends the trust.
         */
        for (long long n = lines; n >= 1; n--) {
            double complex line = all->output[n * s->orbits];
            double difference = cabs(line - half.output[n * s->orbits]);
            reference = fmax(reference, cabs(line));
            if (!(difference <= fmax(tolerance * reference, rounding * highest)))
                trusted = n - 1;
        }
        s->trustworthy = (double)(trusted * s->orbits) * s->resolution;
    }
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
        transform_whole(&t, signal, s->mean);
        read_orbits(&t, s);
    }
    if (status == SALTUS_OK && signal->per_period % 2 == 0)
        status = trust_orbits(signal, &t, s, message);
    saltus_transform_close(&t);
    if (status != SALTUS_OK)
        saltus_spectrum_clear(s);
    return status;
}

/* Welch's method */

/* Periodic Hann window; its transform has three bins. */
static double hann(long long j, long long length) {
    double sine = sin(M_PI * (double)j / (double)length);
    return sine * sine;
}

/* Averaged density of a signal with a given mean; `parseval` may be NULL. */
static saltus_status average_segments(const saltus_signal *signal, double mean, long long length,
                                      double *density, double *parseval, saltus_message *message) {
    saltus_transform t = {0};
    saltus_status status = saltus_transform_open(&t, length, message);
    double *window = malloc((size_t)length * sizeof *window), squares = 0;
    if (status == SALTUS_OK && !window)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a window of %lld samples", length);
    for (long long j = 0; status == SALTUS_OK && j < length; j++) {
        window[j] = hann(j, length);
        squares += window[j] * window[j];
    }
    saltus_sum in_time = {0, 0}, in_bins = {0, 0};
    long long hop = length / 2, segments = (signal->count - length) / hop + 1;
    for (long long m = 0; status == SALTUS_OK && m < segments; m++) {
        for (long long j = 0; j < length; j++) {
            t.input[j] = window[j] * (signal->samples[m * hop + j] - mean);
            saltus_sum_add(&in_time, t.input[j] * t.input[j]);
        }
        fftw_execute(t.plan);
        for (long long k = 0; k < t.bins; k++) {
            double re = creal(t.output[k]), im = cimag(t.output[k]),
                   square = saltus_bin_weight(k, length) * (re * re + im * im);
            density[k] += square / (squares * signal->per_period * (double)segments);
            saltus_sum_add(&in_bins, square / (double)length);
        }
    }
    double total = in_time.value + in_time.rest;
    if (parseval)
        *parseval = total > 0 ? fabs(in_bins.value + in_bins.rest - total) / total : 0;
    free(window);
    saltus_transform_close(&t);
    return status;
}

/* Degrees of freedom of the mean of `segments` periodograms that overlap by half: the squared correlation of
 * two windows half a length apart is all there is, because those a length apart have nothing in common. */
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

/* The band of bin k, from 1 on. */
static int band_of(long long k) {
    enum { bands_per_octave = 8, bands_max = 26 * bands_per_octave };
    int band = (int)floor(bands_per_octave * log2((double)k) + 1e-9);
    return band < bands_max ? band : bands_max - 1;
}

/* The same as for lines (trust_orbits), band by band. */
static saltus_status trust_welch(const saltus_signal *signal, long long length, saltus_spectrum *s,
                                 saltus_message *message) {
    double *samples = malloc((size_t)(signal->count / 2 + 1) * sizeof *samples),
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
