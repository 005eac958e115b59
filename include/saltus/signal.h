/* Spectra of signals: lines of whole orbits, Welch's power spectral density, what stands out of the
 * continuum. Nothing here knows of a system.
 *
 * Frequencies are in units of the forcing frequency omega, times in forcing periods T.
 *
 * Transforms are planned by FFTW with FFTW_ESTIMATE, so that the numbers are the same each time, and with its
 * planner behind a lock, so that several threads may call these functions at once.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SIGNAL_H
#define SALTUS_SIGNAL_H

#include "saltus/status.h"

#include <stdbool.h>

SALTUS_API_BEGIN

/* A time at which derivatives of a signal by the time in forcing periods jump. */
typedef struct saltus_corner {
    double time;        /* forcing periods from the first sample */
    double slope, bend; /* what the first and the second derivative gain there */
} saltus_corner;

/* A real signal, sampled evenly: sample j belongs to the time j / per_period, in forcing periods. What is
 * known beside the samples keeps jumps from aliasing; all of it may be left out. */
typedef struct saltus_signal {
    const double *samples; /* the caller's */
    long long count;
    int per_period;  /* samples a forcing period; 1 for a stroboscopic series */
    double rounding; /* a signal this close to its mean does not move; 0: 1e-14 of its largest value */
    /* An integral of the signal over the time in forcing periods, sampled at the same times, the caller's:
     * means, lines and densities are then its own, differentiated. */
    const double *primitive;
    double variance; /* of the signal where that is known better than from samples; 0: it is that of the
                        samples */
    /* Corners of the primitive, where there is one, or of the samples: the caller's. The lines of whole
     * orbits are free of what they alias. */
    const saltus_corner *corners;
    long long corner_count;
} saltus_signal;

typedef enum saltus_spectrum_kind {
    SALTUS_SPECTRUM_CONSTANT, /* the signal does not move: no bins, no lines */
    SALTUS_SPECTRUM_LINES,    /* whole orbits: lines at multiples of 1/p */
    SALTUS_SPECTRUM_WELCH     /* averaged density with a confidence band, and lines that stand out */
} saltus_spectrum_kind;

/* The part amplitude * cos(2 pi frequency t + phase) of a signal, t in forcing periods from its first sample.
 */
typedef struct saltus_spectral_line {
    long long harmonic; /* k of frequency = k / p; 0 in motion without period */
    double frequency;
    double amplitude; /* peak value */
    double phase;     /* -pi to pi */
    double decibels;  /* 20 log10 of the amplitude over that of the highest line */
    double share;     /* of the signal's variance */
} saltus_spectral_line;

/* Arrays are owned by the spectrum. */
typedef struct saltus_spectrum {
    saltus_spectrum_kind kind;
    int per_period;
    long long count; /* samples analysed */
    double mean;
    double variance; /* about the mean: the total power of lines and continuum */
    double parseval; /* |power of all bins - (windowed) power of what was transformed| over the latter */

    long long bins;    /* frequencies 0, resolution, ... up to half the samples' frequency */
    double resolution; /* distance of the bins */
    double *density;   /* one-sided: its integral over the frequency is the variance */
    int orbits;        /* LINES: whole orbits in the signal */
    int periods;       /* LINES: p */
    long long segments, segment_periods; /* WELCH: segments averaged, their length */
    double degrees;    /* WELCH: degrees of freedom of a bin's chi-square distribution (half at both ends) */
    double confidence; /* WELCH: probability with which low * density to high * density covers the true
                          density of a continuum; 0 otherwise */
    double low, high;

    saltus_spectral_line *lines; /* by frequency, without the mean */
    long long line_count;
    double between; /* LINES: largest amplitude between the lines over that of the highest line; NAN with one
                       orbit, which has no bins there */
    double broadband;   /* fraction of the variance that is not in lines; WELCH: of that up to the trustworthy
                           frequency */
    double trustworthy; /* up to this frequency aliasing changes no line (LINES) and no band of an eighth of
                           an octave (WELCH) by more than 1 %; NAN where it was not looked at */
} saltus_spectrum;

/* A zeroed spectrum is accepted. */
void saltus_spectrum_clear(saltus_spectrum *spectrum);

/* The lines of whole orbits: `count` samples are `orbits` times `periods` forcing periods, so every line of
 * the motion falls on a bin and none leaks; of several orbits, orbits - 1 bins lie between two lines. On
 * success to be cleared. Errors: SALTUS_BAD_INPUT (not whole orbits, samples that are not finite),
 * SALTUS_NO_MEMORY.
 *
 * Trustworthy: the lines are computed again from every second sample, which doubles what aliases. Up to the
 * first one that differs by more than 1 % of the largest line at its frequency or above (a line may vanish by
 * symmetry), and by more than 1e-11 of the highest line, they are trusted; at most up to half of half the
 * samples' frequency, which both have. What is left in the lines themselves is less. */
saltus_status saltus_signal_orbits(const saltus_signal *signal, int periods, saltus_spectrum *spectrum,
                                   saltus_message *message);

/* Welch's power spectral density: segments of `segment_periods` forcing periods that overlap by half, Hann
 * window, mean removed. The degrees of freedom count the correlation of overlapping segments (Welch, IEEE
 * Trans. Audio Electroacoustics 15 (1967) 70-73; Percival and Walden, Spectral Analysis for Physical
 * Applications, 1993, section 6.17). Lines and broadband fraction are those of saltus_signal_lines up to the
 * trustworthy frequency, at most 4096 of them. On success to be cleared. Errors: SALTUS_BAD_INPUT,
 * SALTUS_NO_MEMORY.
 *
 * Trustworthy: as above, with the mean density of bands of an eighth of an octave in place of lines. */
saltus_status saltus_signal_welch(const saltus_signal *signal, long long segment_periods, double confidence,
                                  saltus_spectrum *spectrum, saltus_message *message);

/* Sharp lines of any signal, at most `most`, by frequency, and what they leave of its variance.
 *
 * The whole signal is transformed once, with a Blackman-Harris window of four terms. Peaks that noise of the
 * level around them would show anywhere with probability 1e-3 at most are candidates. Each is fitted,
 * frequency included, by the window's own transform; all are refitted as others are found and taken away (the
 * relaxation of Li and Stoica, IEEE Trans. Signal Process. 44 (1996) 281-295). What does not have the width
 * and the shape of a line is not one and stays in the continuum; so do lines that the signal is too short to
 * tell apart, less than 4 over its length from each other (6 in a comb of many equal ones). A peak much
 * narrower than 1 over the length cannot be told from a line.
 *
 * `highest` (0: no limit) bounds the frequencies looked at, for the fraction too; `lines` has room for
 * `most`. The signal has at least 64 samples. A signal that does not move has no line and nothing left.
 * Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_signal_lines(const saltus_signal *signal, double highest, int most,
                                  saltus_spectral_line *lines, int *line_count, double *broadband,
                                  saltus_message *message);

/* Fraction of the variance of a stroboscopic series (one sample a forcing period, 64 at least) that is not in
 * sharp lines, at most 512 of them. Of some thousand samples: below 1e-8 for periodic and smooth
 * quasi-periodic motion, 1e-4 where the section's curve has corners, a few hundredths where the series itself
 * jumps along it (a velocity that is struck at the section's phase: take a displacement); near 1 for noise
 * and most chaos; in between where chaos has lines of its own, as in several bands visited in turn. Errors:
 * those of saltus_signal_lines. */
saltus_status saltus_series_broadband(const double *series, long long count, double *fraction,
                                      saltus_message *message);

SALTUS_API_END
#endif
