/* Private: transforms, checks and sums that the analyses of signals share.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SIGNAL_SPECTRUM_H
#define SALTUS_SIGNAL_SPECTRUM_H

#include "base/memory.h"
#include "saltus/signal.h"

/* With complex.h included first, FFTW uses C's complex type. */
#include <complex.h>
#include <fftw3.h>
#include <math.h>

enum { SALTUS_SAMPLES_MAX = 1 << 24 };

/* A transform of real samples: `input` (count) -> `output` (bins = count / 2 + 1). */
typedef struct saltus_transform {
    saltus_arena arena;
    long long count, bins;
    double *input;
    double complex *output;
    fftw_plan plan;
} saltus_transform;

/* Errors: SALTUS_NO_MEMORY; the transform must be closed even then. */
saltus_status saltus_transform_open(saltus_transform *transform, long long count, saltus_message *message);
/* Accepts a zeroed transform. */
void saltus_transform_close(saltus_transform *transform);

/* 2 if bin k of a one-sided spectrum of `count` samples also stands for its negative frequency, else 1. */
double saltus_bin_weight(long long k, long long count);

/* SALTUS_BAD_INPUT if a signal cannot be analysed. */
saltus_status saltus_signal_check(const saltus_signal *signal, saltus_message *message);
/* Mean, if possible from the primitive: its rise over the time between the first and the last sample. */
double saltus_signal_mean(const saltus_signal *signal);
bool saltus_signal_moves(const saltus_signal *signal, double mean);
/* Mean squared deviation from the mean, or signal->variance if that is known. */
double saltus_signal_variance(const saltus_signal *signal, double mean);
/* A signal of every `thinning`-th sample, stored in `samples` (count / thinning, twice as many with a
 * primitive). */
saltus_signal saltus_signal_thinned(const saltus_signal *signal, int thinning, double *samples);

/* The values to transform for a signal without its mean, from sample `first` on: the samples minus the mean,
 * or the primitive minus a straight line. */
void saltus_signal_steady(const saltus_signal *signal, double mean, long long first, long long count,
                          double *steady);

/* Set the decibels of lines whose amplitudes are known. */
void saltus_lines_rank(saltus_spectral_line *lines, long long count);

/* Welch's density without lines. */
saltus_status saltus_signal_density(const saltus_signal *signal, long long segment_periods, double confidence,
                                    saltus_spectrum *spectrum, saltus_message *message);

/* Compensated sum (Neumaier). */
typedef struct saltus_sum {
    double value, rest;
} saltus_sum;

static inline void saltus_sum_add(saltus_sum *sum, double term) {
    double total = sum->value + term;
    double large = fabs(sum->value) >= fabs(term) ? sum->value : term,
           small = fabs(sum->value) >= fabs(term) ? term : sum->value;
    sum->rest += (large - total) + small;
    sum->value = total;
}

static inline double saltus_sum_of(saltus_sum sum) {
    return sum.value + sum.rest;
}

#endif
