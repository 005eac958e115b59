/* Private: what the parts of the spectra share.
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

/* How often bin k of a one-sided spectrum of `count` samples stands for itself and its mirror image. */
double saltus_bin_weight(long long k, long long count);

/* Whether a signal can be analysed. */
saltus_status saltus_signal_check(const saltus_signal *signal, saltus_message *message);
double saltus_signal_mean(const saltus_signal *signal);
bool saltus_signal_moves(const saltus_signal *signal, double mean);
/* Every second sample of a signal goes to `half` (count / 2), which becomes a signal of its own. */
saltus_signal saltus_signal_halved(const saltus_signal *signal, double *half);

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

/* Frequencies up to which spectra from all and from every second sample agree: see spectrum.h. `all` and
 * `half` hold the amplitudes (with their phases) of bins 0, 1, ...; `stride` bins lie from line to line. The
 * number of the last bin that agrees is returned. */
long long saltus_trust_lines(const double complex *all, const double complex *half, long long half_bins,
                             long long stride);
/* The same for densities, band by band. */
long long saltus_trust_bands(const double *all, const double *half, long long half_bins);

#endif
