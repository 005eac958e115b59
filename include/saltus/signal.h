/* Spectra of signals: lines of whole orbits, Welch's power spectral density, lines that stand out from the
 * continuum. Nothing here depends on a system.
 *
 * Frequencies are in units of the forcing frequency omega, times in forcing periods T.
 *
 * FFTW plans with FFTW_ESTIMATE, so that results are reproducible, and its planner is made thread-safe, so
 * that several threads may call these functions at once.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SIGNAL_H
#define SALTUS_SIGNAL_H

#include "saltus/status.h"

#include <stdbool.h>

SALTUS_API_BEGIN

/* A time at which derivatives of a signal with respect to time (in forcing periods) jump. */
typedef struct saltus_corner {
    double time;        /* in forcing periods from the first sample */
    double slope, bend; /* jumps of the first and the second derivative */
} saltus_corner;

/* A real signal, sampled evenly: sample j belongs to the time j / per_period, in forcing periods. The
 * optional members from `primitive` on keep jumps of the signal from aliasing. */
typedef struct saltus_signal {
    const double *samples; /* owned by the caller */
    long long count;
    int per_period;  /* samples per forcing period; 1 for a stroboscopic series */
    double rounding; /* a signal this close to its mean counts as constant; 0: 1e-14 of its largest value */
    /* Optional, owned by the caller: an integral of the signal over time (in forcing periods), sampled at the
     * same times. Means, lines and densities are then computed from it and differentiated. */
    const double *primitive;
    double variance; /* of the signal, if known better than from samples; 0: computed from them */
    /* Optional, owned by the caller: corners of the primitive if there is one, else of the samples. They are
     * removed before the transform of whole orbits, so that they do not alias. */
    const saltus_corner *corners;
    long long corner_count;
} saltus_signal;

typedef enum saltus_spectrum_kind {
    SALTUS_SPECTRUM_CONSTANT, /* the signal is constant: no bins, no lines */
    SALTUS_SPECTRUM_LINES,    /* whole orbits: lines at multiples of 1/p */
    SALTUS_SPECTRUM_WELCH     /* averaged density with a confidence band, and sharp lines */
} saltus_spectrum_kind;

/* The component amplitude * cos(2 pi frequency t + phase), t in forcing periods from the first sample. */
typedef struct saltus_spectral_line {
    long long harmonic; /* k of frequency = k / p; 0 for motion without period */
    double frequency;
    double amplitude; /* peak value */
    double phase;     /* -pi to pi */
    double decibels;  /* 20 log10(amplitude / largest amplitude) */
    double share;     /* fraction of the signal's variance */
} saltus_spectral_line;

/* The spectrum owns its arrays. */
typedef struct saltus_spectrum {
    saltus_spectrum_kind kind;
    int per_period;
    long long count; /* samples analysed */
    double mean;
    double variance; /* about the mean: total power of lines and continuum */
    double parseval; /* relative error in Parseval's identity of the (windowed) transforms */

    long long bins;    /* at frequencies 0, resolution, ... up to half the sampling frequency */
    double resolution; /* spacing of the bins */
    double *density;   /* one-sided: its integral over the frequency is the variance */
    int orbits;        /* LINES: whole orbits in the signal */
    int periods;       /* LINES: p */
    long long segments, segment_periods; /* WELCH: segments averaged, and their length */
    double degrees;    /* WELCH: degrees of freedom of a bin's chi-square distribution (half at both ends) */
    double confidence; /* WELCH: probability that [low * density, high * density] contains the true density of
                          a continuum; 0 otherwise */
    double low, high;

    saltus_spectral_line *lines; /* by frequency, without the mean */
    long long line_count;
    double between;   /* LINES: largest amplitude between the lines over that of the highest line; NAN for one
                         orbit, which has no bins between lines */
    double broadband; /* fraction of the variance outside the lines; WELCH: up to `trustworthy` */
    double trustworthy; /* aliasing changes no line (LINES) or eighth-octave band (WELCH) up to this frequency
                           by more than 1 %; NAN if not determined */
} saltus_spectrum;

/* Accepts a zeroed spectrum. */
void saltus_spectrum_clear(saltus_spectrum *spectrum);

/* The lines of whole orbits. The samples span `orbits` times `periods` forcing periods, so every line of the
 * motion falls on a bin and none leaks; with several orbits, orbits - 1 bins lie between two lines. Clear the
 * spectrum after success. Errors: SALTUS_BAD_INPUT (not whole orbits, samples that are not finite),
 * SALTUS_NO_MEMORY.
 *
 * Trustworthy: the lines are computed again from every second sample, which doubles the aliasing. Lines are
 * trusted up to the first one that differs by more than 1 % of the largest line at its own or a higher
 * frequency (a line may vanish by symmetry) and by more than 1e-11 of the highest line, at most up to a
 * quarter of the sampling frequency, which both spectra contain. Their own error is smaller than this. */
saltus_status saltus_signal_orbits(const saltus_signal *signal, int periods, saltus_spectrum *spectrum,
                                   saltus_message *message);

/* Welch's power spectral density: segments of `segment_periods` forcing periods that overlap by half, Hann
 * window, mean removed. The degrees of freedom account for the correlation of overlapping segments (Welch,
 * IEEE Trans. Audio Electroacoustics 15 (1967) 70-73; Percival and Walden, Spectral Analysis for Physical
 * Applications, 1993, section 6.17). Lines and broadband fraction are those of saltus_signal_lines up to the
 * trustworthy frequency, at most 4096 lines. Clear the spectrum after success. Errors: SALTUS_BAD_INPUT,
 * SALTUS_NO_MEMORY.
 *
 * Trustworthy: as above, with the mean density in bands of an eighth of an octave instead of lines. */
saltus_status saltus_signal_welch(const saltus_signal *signal, long long segment_periods, double confidence,
                                  saltus_spectrum *spectrum, saltus_message *message);

/* Sharp lines of any signal, at most `most`, by frequency, and the fraction of its variance outside them.
 *
 * The whole signal is transformed once, with a Blackman-Harris window of four terms. Candidates are peaks so
 * high above the surrounding level that noise would show one anywhere with a probability of at most 1e-3.
 * Each is fitted, frequency included, by the window's own transform; all are refitted as more are found and
 * removed (the relaxation of Li and Stoica, IEEE Trans. Signal Process. 44 (1996) 281-295). A peak without
 * the width and shape of a line stays in the continuum. So do lines that the signal is too short to separate:
 * closer than 4 over its length (6 in a comb of many equal lines). A peak much narrower than 1 over the
 * length cannot be told from a line.
 *
 * `highest` (0: no limit) bounds the frequencies considered, also for the fraction; `lines` has room for
 * `most`. The signal has at least 64 samples. A constant signal has no lines and the fraction 0. Errors:
 * SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_signal_lines(const saltus_signal *signal, double highest, int most,
                                  saltus_spectral_line *lines, int *line_count, double *broadband,
                                  saltus_message *message);

/* Fraction of the variance of a stroboscopic series (one sample per forcing period, at least 64) outside its
 * sharp lines, at most 512 of them. Typical values for some thousand samples: below 1e-8 for periodic and
 * smooth quasi-periodic motion; 1e-4 if the section's closed curve has corners; a few hundredths if the
 * series itself jumps along the curve (a velocity with impacts at the section's phase: use a displacement);
 * near 1 for noise and most chaos; in between for chaos with lines of its own, as in several bands visited in
 * turn. Errors: those of saltus_signal_lines. */
saltus_status saltus_series_broadband(const double *series, long long count, double *fraction,
                                      saltus_message *message);

SALTUS_API_END
#endif
