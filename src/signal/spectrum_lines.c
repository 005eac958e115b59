/* Sharp lines of a signal: found in one windowed transform, fitted by the window's own transform, subtracted.
 *
 * A line c exp(2 pi i f j / n) of a signal of n samples, together with its mirror image, adds c W(k - f) +
 * conj(c) W(k + f) to bin k, where W is the window's transform. W almost vanishes (-92 dB) beyond four bins,
 * so a line affects only a few bins and the remainder without lines is known bin by bin.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "signal/spectrum.h"

#include <gsl/gsl_statistics_double.h>
#include <stdlib.h>
#include <string.h>

enum {
    terms = 4,   /* of the window */
    core = 3,    /* bins on each side that a line is fitted to */
    lobe = 16,   /* bins on each side that a line is subtracted from */
    apart = 4,   /* least distance of two lines in bins */
    block = 128, /* bins per block; the level of the continuum is taken from a block and its two neighbours */
    rounds_max = 40, /* searches for further lines */
    series_lines_max = 512,
    samples_min = 64
};

/* Blackman-Harris: Harris, Proc. IEEE 66 (1978) 51-83. */
static const double window[terms] = {0.35875, 0.48829, 0.14128, 0.01168};

/* This quantile of the surrounding bins gives the continuum's level, whatever lines stand there. */
static const double quantile = 0.1;
/* Probability that noise shows a peak anywhere if its level is known exactly. The quantile of some 200
 * independent bins is known only to a fifth, which makes it 1e-3. */
static const double false_alarm = 1e-6;
static const double round_depth = 1e-3; /* of a round's strongest peak: weaker ones wait for the next round */
static const double negligible = 1e-9;  /* power of a peak over the total power that is not worth a line */
static const double misfit_max = 0.1;   /* power left in the core of a line over the line's own power */

typedef struct peak {
    double place; /* frequency in bins */
    double complex half_amplitude;
} peak;

typedef struct finder {
    saltus_transform transform;
    double complex *left;        /* [bin]: the transform without the lines found */
    long long count, bins, last; /* last: last bin where lines are sought */
    peak *peaks;
    int peak_count, most;
    unsigned char *tried;    /* bins near a line found, even one put back later */
    double *level;           /* level of the continuum, per block */
    double threshold, total; /* least power of a peak over the level; total power */
} finder;

/* Weight of exp(2 pi i m j / n) in the window. */
static double window_share(int m) {
    int size = abs(m);
    return size >= terms ? 0 : (size % 2 ? -1 : 1) * (size ? 0.5 : 1) * window[size];
}

/* W(x) / n: a sum of kernels sin(pi y) / (n sin(pi y / n)) exp(-i pi y (n - 1) / n) around x, which differ
 * only by a cotangent. Zero beyond twice the bins that a line is subtracted from. */
static double complex window_transform(double x, double n) {
    double y = x - n * round(x / n), whole = round(y), real = 0, imaginary = 0;
    if (fabs(y) > 2 * lobe)
        return 0;
    if (fabs(y - whole) < 1e-9)
        return window_share((int)whole);
    for (int m = 1 - terms; m < terms; m++) {
        real += window_share(m) / tan(M_PI * (y - m) / n);
        imaginary += window_share(m);
    }
    return sin(M_PI * y) / n * cexp(-I * M_PI * y) * (real + I * imaginary);
}

static double complex window_slope(double x, double n) {
    const double step = 1e-4;
    return (window_transform(x + step, n) - window_transform(x - step, n)) / (2 * step);
}

/* A line's contribution to bin k. */
static double complex line_in_bin(const peak *p, long long k, double n) {
    return p->half_amplitude * window_transform((double)k - p->place, n) +
           conj(p->half_amplitude) * window_transform((double)k + p->place, n);
}

static void bins_around(const finder *self, double place, int reach, long long *from, long long *to) {
    long long nearest = llround(place);
    *from = nearest > reach ? nearest - reach : 0;
    *to = nearest + reach < self->bins ? nearest + reach : self->bins - 1;
}

/* Subtract a line from what is left, or add it back (sign -1). */
static void take_away(finder *self, const peak *p, double sign) {
    long long from, to;
    bins_around(self, p->place, lobe, &from, &to);
    for (long long k = from; k <= to; k++)
        self->left[k] -= sign * line_in_bin(p, k, (double)self->count);
}

/* One Gauss-Newton step for one line, the others fixed. Unknowns: real and imaginary part of the half
 * amplitude, and the place times the modulus. */
static void refit(finder *self, peak *p) {
    double a[3][3] = {{0}}, b[3] = {0}, x[3], n = (double)self->count, modulus = cabs(p->half_amplitude);
    long long from, to;
    bins_around(self, p->place, core, &from, &to);
    for (long long k = from; k <= to; k++) {
        double below = (double)k - p->place, above = (double)k + p->place;
        double complex direct = window_transform(below, n), image = window_transform(above, n);
        double complex column[3] = {direct + image, I * (direct - image), 0};
        if (modulus > 0)
            column[2] = (conj(p->half_amplitude) * window_slope(above, n) -
                         p->half_amplitude * window_slope(below, n)) /
                        modulus;
        for (int r = 0; r < 3; r++) {
            b[r] += creal(conj(column[r]) * self->left[k]);
            for (int c = 0; c < 3; c++)
                a[r][c] += creal(conj(column[r]) * column[c]);
        }
    }
    /* Solve the normal equations. Where a column is zero (the sine at half the sampling frequency, the
     * frequency of a line without amplitude), so is its unknown. */
    const double scale = fmax(a[0][0], fmax(a[1][1], a[2][2]));
    bool used[3];
    for (int c = 0; c < 3; c++) {
        used[c] = a[c][c] > 1e-8 * scale;
        for (int r = c + 1; used[c] && r < 3; r++) {
            double factor = a[r][c] / a[c][c];
            for (int k = c; k < 3; k++)
                a[r][k] -= factor * a[c][k];
            b[r] -= factor * b[c];
        }
    }
    for (int c = 2; c >= 0; c--) {
        double sum = b[c];
        for (int k = c + 1; k < 3; k++)
            sum -= a[c][k] * x[k];
        x[c] = used[c] ? sum / a[c][c] : 0;
    }
    take_away(self, p, -1);
    p->half_amplitude += x[0] + I * x[1];
    p->place += modulus > 0 ? fmax(-0.3, fmin(0.3, x[2] / modulus)) : 0;
    p->place = fmax(0, fmin((double)self->count / 2, p->place));
    take_away(self, p, 1);
}

static double power(double complex z) {
    return creal(z) * creal(z) + cimag(z) * cimag(z);
}

static bool stands_out(const finder *self, long long k) {
    double here = power(self->left[k]);
    return !self->tried[k] && here > self->threshold * self->level[k / block] &&
           here >= power(self->left[k - 1]) && (k + 1 == self->bins || here >= power(self->left[k + 1]));
}

static void mark_tried(finder *self, long long place) {
    long long from, to;
    bins_around(self, (double)place, apart - 1, &from, &to);
    memset(self->tried + from, 1, (size_t)(to - from + 1));
}

/* Add the peaks of what is left as lines and return their number. Of two close peaks the stronger one is
 * kept. */
static int admit(finder *self) {
    const int before = self->peak_count;
    double strongest = 0, sample[3 * block];
    /* Level of the continuum in each block, from what is left. */
    for (long long first = 0; first <= self->last; first += block) {
        long long from = first > block ? first - block : 0, to = first + 2 * block;
        size_t size = 0;
        for (long long k = from; k < to && k < self->bins; k++)
            sample[size++] = power(self->left[k]);
        self->level[first / block] =
            gsl_stats_select(sample, 1, size, (size_t)(quantile * (double)(size - 1)));
    }
    for (long long k = 1; k <= self->last; k++)
        if (stands_out(self, k))
            strongest = fmax(strongest, power(self->left[k]));
    if (!(strongest > negligible * self->total))
        return 0;
    double above = round_depth * strongest;
    for (long long k = 1; k <= self->last; k++) {
        if (!stands_out(self, k) || power(self->left[k]) < above)
            continue;
        peak *lower = &self->peaks[self->peak_count - 1];
        const long long place = (long long)lower->place;
        const bool near = self->peak_count > before && k - place < apart;
        if (near && power(self->left[k]) > power(self->left[place]))
            lower->place = (double)k;
        else if (!near && self->peak_count < self->most)
            self->peaks[self->peak_count++] = (peak){.place = (double)k};
    }
    for (int c = before; c < self->peak_count; c++)
        mark_tried(self, (long long)self->peaks[c].place);
    return self->peak_count - before;
}

static void relax(finder *self, int sweeps) {
    for (int sweep = 0; sweep < sweeps; sweep++)
        for (int c = 0; c < self->peak_count; c++)
            refit(self, &self->peaks[c]);
}

/* Put back the peaks that do not have the shape of a line and return whether there were any. The first peak,
 * the remainder of the mean, always stays. */
static bool prune(finder *self) {
    int kept = 1;
    for (int c = 1; c < self->peak_count; c++) {
        const peak *p = &self->peaks[c];
        double line = 0, left = 0;
        long long from, to;
        bins_around(self, p->place, core, &from, &to);
        for (long long k = from; k <= to; k++) {
            line += power(line_in_bin(p, k, (double)self->count));
            left += power(self->left[k]);
        }
        if (left <= misfit_max * line)
            self->peaks[kept++] = *p;
        else
            take_away(self, p, -1);
    }
    bool pruned = kept < self->peak_count;
    self->peak_count = kept;
    return pruned;
}

/* Transform the mean-free signal times the window or times the window's derivative, into t->output. */
static void transform_windowed(saltus_transform *t, const saltus_signal *signal, double mean,
                               bool derivative) {
    double rate = 2 * M_PI * signal->per_period / (double)t->count;
    saltus_signal_steady(signal, mean, 0, t->count, t->input);
    for (long long j = 0; j < t->count; j++) {
        double angle = 2 * M_PI * (double)j / (double)t->count, weight = derivative ? 0 : window[0];
        for (int m = 1; m < terms; m++)
            weight +=
                (m % 2 ? -1 : 1) * window[m] * (derivative ? -rate * m * sin(m * angle) : cos(m * angle));
        t->input[j] *= weight / (double)t->count;
    }
    fftw_execute(t->plan);
}

/* Transform the signal, windowed and without its mean. For a primitive q it uses w q' = (w q)' - w' q,
 * because the window w almost vanishes at both ends. What the window leaves of the mean is subtracted as a
 * line of fixed frequency 0. */
static void transform_signal(finder *self, const saltus_signal *signal, double mean) {
    saltus_transform *t = &self->transform;
    transform_windowed(t, signal, mean, false);
    memcpy(self->left, t->output, (size_t)t->bins * sizeof *self->left);
    if (signal->primitive) {
        transform_windowed(t, signal, mean, true);
        for (long long k = 0; k < t->bins; k++)
            self->left[k] = 2 * M_PI * I * (double)k * signal->per_period / (double)t->count * self->left[k] -
                            t->output[k];
    }
    self->peaks[self->peak_count++] = (peak){.place = 0};
    mark_tried(self, 0);
    relax(self, 1);
}

static double power_left(const finder *self) {
    saltus_sum sum = {0, 0};
    for (long long k = 0; k <= self->last; k++)
        saltus_sum_add(&sum, saltus_bin_weight(k, self->count) * power(self->left[k]));
    return saltus_sum_of(sum);
}

static saltus_status open_finder(finder *self, const saltus_signal *signal, double highest, int most,
                                 saltus_message *message) {
    saltus_status status = saltus_transform_open(&self->transform, signal->count, message);
    if (status != SALTUS_OK)
        return status;
    self->count = signal->count;
    self->bins = self->transform.bins;
    self->last = self->bins - 1;
    if (highest > 0 && highest * (double)self->count / signal->per_period < (double)self->last)
        self->last = (long long)(highest * (double)self->count / signal->per_period);
    self->most = most + 1;
    self->threshold = log((double)self->bins / false_alarm) / -log1p(-quantile);
    self->peaks = malloc((size_t)self->most * sizeof *self->peaks);
    self->tried = calloc((size_t)self->bins, 1);
    self->level = malloc((size_t)(self->bins / block + 1) * sizeof *self->level);
    self->left = malloc((size_t)self->bins * sizeof *self->left);
    return self->peaks && self->tried && self->level && self->left
               ? SALTUS_OK
               : saltus_fail(message, SALTUS_NO_MEMORY, "no memory to look for lines");
}

static int by_place(const void *a, const void *b) {
    const peak *p = a, *q = b;
    return (p->place > q->place) - (p->place < q->place);
}

/* The peaks without the mean, in the units of the signal. */
static int report(finder *self, const saltus_signal *signal, double variance, saltus_spectral_line *lines) {
    int count = self->peak_count - 1;
    qsort(self->peaks + 1, (size_t)count, sizeof *self->peaks, by_place);
    for (int c = 0; c < count; c++) {
        const peak *p = &self->peaks[c + 1];
        double amplitude = 2 * cabs(p->half_amplitude);
        bool fastest = fabs(p->place - 0.5 * (double)self->count) < 1e-6;
        lines[c] = (saltus_spectral_line){.frequency = p->place * signal->per_period / (double)self->count,
                                          .amplitude = amplitude,
                                          .phase = carg(p->half_amplitude),
                                          .share = (fastest ? 1 : 0.5) * amplitude * amplitude / variance};
    }
    saltus_lines_rank(lines, count);
    return count;
}

saltus_status saltus_signal_lines(const saltus_signal *signal, double highest, int most,
                                  saltus_spectral_line *lines, int *line_count, double *broadband,
                                  saltus_message *message) {
    enum { fresh = 4, settled = 6, prunings_max = 8 };
    *line_count = 0;
    *broadband = 0;
    saltus_status status = saltus_signal_check(signal, message);
    if (status == SALTUS_OK && signal->count < samples_min)
        status = saltus_fail(message, SALTUS_BAD_INPUT,
                             "a series of %lld samples: must have %d at least to tell lines from noise",
                             signal->count, samples_min);
    if (status == SALTUS_OK && (most < 1 || !(highest >= 0)))
        status = saltus_fail(message, SALTUS_BAD_INPUT,
                             "lines: room for one at least and a highest frequency of 0 or more are needed");
    if (status != SALTUS_OK)
        return status;
    double mean = saltus_signal_mean(signal);
    if (!saltus_signal_moves(signal, mean))
        return SALTUS_OK;
    finder self = {.peaks = NULL};
    status = open_finder(&self, signal, highest, most, message);
    if (status == SALTUS_OK) {
        transform_signal(&self, signal, mean);
        self.total = power_left(&self);
        for (int round = 0; round < rounds_max && self.peak_count < self.most && admit(&self) > 0; round++)
            relax(&self, fresh);
        relax(&self, settled);
        for (int k = 0; k < prunings_max && prune(&self); k++)
            relax(&self, fresh);
        *broadband = self.total > 0 ? fmin(1, power_left(&self) / self.total) : 0;
        *line_count = report(&self, signal, saltus_signal_variance(signal, mean), lines);
    }
    free(self.left);
    free(self.peaks);
    free(self.tried);
    free(self.level);
    saltus_transform_close(&self.transform);
    return status;
}

saltus_status saltus_series_broadband(const double *series, long long count, double *fraction,
                                      saltus_message *message) {
    saltus_signal signal = {.samples = series, .count = count, .per_period = 1};
    saltus_spectral_line lines[series_lines_max];
    int line_count;
    return saltus_signal_lines(&signal, 0, series_lines_max, lines, &line_count, fraction, message);
}
