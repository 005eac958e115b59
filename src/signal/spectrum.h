/* Private: transforms, checks and sums that the analyses of signals share.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SIGNAL_SPECTRUM_H
#define SALTUS_SIGNAL_SPECTRUM_H

#include "base/memory.h"
#include "saltus/signal.h"

/* complex.h first: FFTW then takes its numbers for C's. */
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

/* Errors: SALTUS_NO_MEMORY. Close in any case. */
saltus_status saltus_transform_open(saltus_transform *transform, long long count, saltus_message *message);
/* A zeroed transform is accepted. */
void saltus_transform_close(saltus_transform *transform);

/* 2 where bin k of a one-sided spectrum of `count` samples stands for its negative frequency too, or 1. */
double saltus_bin_weight(long long k, long long count);

/* Whether a signal can be analysed. */
saltus_status saltus_signal_check(const saltus_signal *signal, saltus_message *message);
/* By its primitive where that is known: its rise over the time between the first sample and the last. */
double saltus_signal_mean(const saltus_signal *signal);
bool saltus_signal_moves(const saltus_signal *signal, double mean);
/* Mean square of the distance from the mean: the signal's own where that is known. */
double saltus_signal_variance(const saltus_signal *signal, double mean);
/* Every `thinning`-th sample of a signal: a signal of its own, held by `samples` (count / thinning, twice as
 * much with a primitive). */
saltus_signal saltus_signal_thinned(const saltus_signal *signal, int thinning, double *samples);

/* What is transformed for a signal without its mean: the samples less that, or the primitive less a straight
 * line, from sample `first` on. */
void saltus_signal_steady(const saltus_signal *signal, double mean, long long first, long long count,
                          double *steady);

/* Decibels of lines whose amplitudes are known. */
void saltus_lines_rank(saltus_spectral_line *lines, long long count);

/* Welch's density without lines. */
saltus_status saltus_signal_density(const saltus_signal *signal, long long segment_periods, double confidence,
                                    saltus_spectrum *spectrum, saltus_message *message);

/* A sum that does not lose what is small beside it (Neumaier). */
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
