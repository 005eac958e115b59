/* Shared by all analyses of signals: checks, mean and variance, transforms, decibels of lines.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "signal/spectrum.h"

saltus_status saltus_transform_open(saltus_transform *t, long long count, saltus_message *message) {
    *t = (saltus_transform){.count = count, .bins = count / 2 + 1};
    do {
        t->input = saltus_arena_doubles(&t->arena, (size_t)count);
        t->output = (double complex *)(void *)saltus_arena_doubles(&t->arena, 2 * (size_t)t->bins);
    } while (saltus_arena_again(&t->arena));
    fftw_make_planner_thread_safe();
    if (t->arena.base)
        t->plan = fftw_plan_dft_r2c_1d((int)count, t->input, t->output, FFTW_ESTIMATE | FFTW_DESTROY_INPUT);
    return t->plan
               ? SALTUS_OK
               : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for a transform of %lld samples", count);
}

void saltus_transform_close(saltus_transform *t) {
    if (t->plan)
        fftw_destroy_plan(t->plan);
    saltus_arena_close(&t->arena);
    *t = (saltus_transform){0};
}

double saltus_bin_weight(long long k, long long count) {
    return k == 0 || 2 * k == count ? 1 : 2;
}

saltus_status saltus_signal_check(const saltus_signal *signal, saltus_message *message) {
    if (signal->count < 1 || signal->count > SALTUS_SAMPLES_MAX)
        return saltus_fail(message, SALTUS_BAD_INPUT, "a signal of %lld samples: must have 1 to %d",
                           signal->count, SALTUS_SAMPLES_MAX);
    if (signal->per_period < 1)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%d samples per period: must be at least 1",
                           signal->per_period);
    for (int primitive = 0; primitive < 2; primitive++) {
        const double *values = primitive ? signal->primitive : signal->samples;
        for (long long j = 0; values && j < signal->count; j++)
            if (!(fabs(values[j]) < 1e100))
                return saltus_fail(message, SALTUS_BAD_INPUT,
                                   "sample %lld of the signal%s is %g: must be finite and below 1e100", j,
                                   primitive ? "'s primitive" : "", values[j]);
    }
    return SALTUS_OK;
}

double saltus_signal_mean(const saltus_signal *signal) {
    if (signal->primitive && signal->count > 1)
        return (signal->primitive[signal->count - 1] - signal->primitive[0]) * signal->per_period /
               (double)(signal->count - 1);
    saltus_sum sum = {0, 0};
    for (long long j = 0; j < signal->count; j++)
        saltus_sum_add(&sum, signal->samples[j]);
    return saltus_sum_of(sum) / (double)signal->count;
}

bool saltus_signal_moves(const saltus_signal *signal, double mean) {
    double largest = 0, away = 0;
    for (long long j = 0; j < signal->count; j++) {
        largest = fmax(largest, fabs(signal->samples[j]));
        away = fmax(away, fabs(signal->samples[j] - mean));
    }
    /* Deviations below 1e-140 have squares that underflow: no power either. */
    return away > fmax(signal->rounding > 0 ? signal->rounding : 1e-14 * largest, 1e-140);
}

double saltus_signal_variance(const saltus_signal *signal, double mean) {
    saltus_sum sum = {0, 0};
    if (signal->variance > 0)
        return signal->variance;
    for (long long j = 0; j < signal->count; j++)
        saltus_sum_add(&sum, (signal->samples[j] - mean) * (signal->samples[j] - mean));
    return saltus_sum_of(sum) / (double)signal->count;
}

saltus_signal saltus_signal_thinned(const saltus_signal *signal, int thinning, double *samples) {
    saltus_signal thinned = *signal;
    thinned.samples = samples;
    thinned.count /= thinning;
    thinned.per_period /= thinning;
    for (long long j = 0; j < thinned.count; j++)
        samples[j] = signal->samples[j * thinning];
    if (signal->primitive) {
        thinned.primitive = samples + thinned.count;
        for (long long j = 0; j < thinned.count; j++)
            samples[thinned.count + j] = signal->primitive[j * thinning];
    }
    return thinned;
}

void saltus_signal_steady(const saltus_signal *signal, double mean, long long first, long long count,
                          double *steady) {
    for (long long j = 0; j < count; j++)
        steady[j] = signal->primitive ? signal->primitive[first + j] - signal->primitive[0] -
                                            mean * (double)(first + j) / signal->per_period
                                      : signal->samples[first + j] - mean;
}

void saltus_lines_rank(saltus_spectral_line *lines, long long count) {
    double highest = 0;
    for (long long k = 0; k < count; k++)
        highest = fmax(highest, lines[k].amplitude);
    for (long long k = 0; k < count; k++)
        lines[k].decibels = highest > 0 ? 20 * log10(lines[k].amplitude / highest) : 0;
}
