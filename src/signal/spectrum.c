/* Spectra of sampled signals: lines of whole orbits, Welch's averaged density.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "signal/spectrum.h"

#include <gsl/gsl_cdf.h>
#include <stdlib.h>

enum { welch_lines_max = 4096 };

void saltus_spectrum_clear(saltus_spectrum *spectrum) {
    free(spectrum->density);
    free(spectrum->lines);
    *spectrum = (saltus_spectrum){0};
}

static void measure(const saltus_signal *signal, saltus_spectrum *s) {
    saltus_sum square = {0, 0};
    *s = (saltus_spectrum){.per_period = signal->per_period,
                           .count = signal->count,
                           .mean = saltus_signal_mean(signal),
                           .between = NAN,
                           .trustworthy = NAN};
    if (!saltus_signal_moves(signal, s->mean)) {
        s->mean = fabs(s->mean) > signal->rounding ? s->mean : 0;
        return;
    }
    for (long long j = 0; j < signal->count; j++) {
        double away = signal->samples[j] - s->mean;
        saltus_sum_add(&square, away * away);
    }
    s->variance = (square.value + square.rest) / (double)signal->count;
}

/* Decibels and shares, when the amplitudes are known. */
static void rank_lines(saltus_spectrum *s) {
    double highest = 0;
    for (long long k = 0; k < s->line_count; k++)
        highest = fmax(highest, s->lines[k].amplitude);
    for (long long k = 0; k < s->line_count; k++) {
        saltus_spectral_line *line = &s->lines[k];
        line->decibels = highest > 0 ? 20 * log10(line->amplitude / highest) : 0;
    }
}

/* Whole orbits */

/* Transform of a signal without its mean, divided by the number of samples. */
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
    rank_lines(s);
}

/* The transform of every second sample decides how far the lines can be trusted. */
static saltus_status trust_orbits(const saltus_signal *signal, const saltus_transform *all,
                                  saltus_spectrum *s, saltus_message *message) {
    saltus_transform half = {0};
    double *samples = malloc((size_t)(signal->count / 2 + 1) * sizeof *samples);
    saltus_status status = samples ? saltus_transform_open(&half, signal->count / 2, message)
                                   : saltus_fail(message, SALTUS_NO_MEMORY, "no memory to look for aliasing");
    if (status == SALTUS_OK) {
        saltus_signal halved = saltus_signal_halved(signal, samples);
        transform_whole(&half, &halved, s->mean);
        long long last = saltus_trust_lines(all->output, half.output, half.bins, s->orbits);
        s->trustworthy = (double)last * s->resolution;
    }
    saltus_transform_close(&half);
    free(samples);
    return status;
}

static saltus_status check_orbits(const saltus_signal *signal, int periods, saltus_message *message) {
    saltus_status status = saltus_signal_check(signal, message);
    if (status != SALTUS_OK)
        return status;
    long long orbit = (long long)periods * signal->per_period;
    if (periods < 1 || signal->count % orbit != 0)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%lld samples are not whole orbits of %d periods with %d samples each",
                           signal->count, periods, signal->per_period);
    return SALTUS_OK;
}

saltus_status saltus_signal_orbits(const saltus_signal *signal, int periods, saltus_spectrum *s,
                                   saltus_message *message) {
    *s = (saltus_spectrum){0};
    saltus_status status = check_orbits(signal, periods, message);
    if (status != SALTUS_OK)
        return status;
    measure(signal, s);
    if (s->variance == 0)
        return SALTUS_OK;
    s->kind = SALTUS_SPECTRUM_LINES;
    s->periods = periods;
    s->orbits = (int)(signal->count / ((long long)periods * signal->per_period));
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

static saltus_status trust_welch(const saltus_signal *signal, long long length, saltus_spectrum *s,
                                 saltus_message *message) {
    double *samples = malloc((size_t)(signal->count / 2 + 1) * sizeof *samples),
           *density = calloc((size_t)(length / 4 + 1), sizeof *density);
    saltus_status status = samples && density
                               ? SALTUS_OK
                               : saltus_fail(message, SALTUS_NO_MEMORY, "no memory to look for aliasing");
    if (status == SALTUS_OK) {
        saltus_signal halved = saltus_signal_halved(signal, samples);
        status = average_segments(&halved, saltus_signal_mean(&halved), length / 2, density, NULL, message);
    }
    if (status == SALTUS_OK) {
        long long last = saltus_trust_bands(s->density, density, length / 4 + 1);
        s->trustworthy = (double)last * s->resolution;
    }
    free(density);
    free(samples);
    return status;
}

static saltus_status find_lines(const saltus_signal *signal, saltus_spectrum *s, saltus_message *message) {
    int count = 0;
    s->lines = malloc(welch_lines_max * sizeof *s->lines);
    if (!s->lines)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the lines of a spectrum");
    double highest = s->trustworthy > 0 ? s->trustworthy : 0;
    saltus_status status =
        saltus_signal_lines(signal, highest, welch_lines_max, s->lines, &count, &s->broadband, message);
    s->line_count = count;
    return status;
}

static saltus_status check_welch(const saltus_signal *signal, long long segment_periods, double confidence,
                                 saltus_message *message) {
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
    return SALTUS_OK;
}

static void set_band(saltus_spectrum *s, long long length, double confidence) {
    double outside = (1 - confidence) / 2;
    s->degrees = degrees_of_freedom(length, s->segments);
    s->confidence = confidence;
    s->low = s->degrees / gsl_cdf_chisq_Qinv(outside, s->degrees);
    s->high = s->degrees / gsl_cdf_chisq_Pinv(outside, s->degrees);
}

saltus_status saltus_signal_density(const saltus_signal *signal, long long segment_periods, double confidence,
                                    saltus_spectrum *s, saltus_message *message) {
    *s = (saltus_spectrum){0};
    saltus_status status = check_welch(signal, segment_periods, confidence, message);
    if (status != SALTUS_OK)
        return status;
    measure(signal, s);
    if (s->variance == 0)
        return SALTUS_OK;
    long long length = segment_periods * signal->per_period;
    s->kind = SALTUS_SPECTRUM_WELCH;
    s->segment_periods = segment_periods;
    s->segments = (signal->count - length) / (length / 2) + 1;
    s->bins = length / 2 + 1;
    s->resolution = 1.0 / (double)segment_periods;
    set_band(s, length, confidence);
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
    if (status == SALTUS_OK && s->kind == SALTUS_SPECTRUM_WELCH)
        status = find_lines(signal, s, message);
    if (status != SALTUS_OK)
        saltus_spectrum_clear(s);
    return status;
}
