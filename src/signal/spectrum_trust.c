/* How far a spectrum of samples can be trusted: what aliases doubles when every second sample is left out, so
 * where both spectra agree there is little of it.
 *
 * A line or a band may be weak by chance or symmetry, and at low frequencies a velocity has little power.
 * What aliases is therefore held against the largest line, or band, at the same or a higher frequency.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "signal/spectrum.h"

enum { bands_per_octave = 8, bands_max = 26 * bands_per_octave };

static const double tolerance = 0.01;
static const double rounding = 1e-11; /* of the highest line: below it two spectra differ by rounding alone */

/* From above, as the reference grows on the way down: the lowest line that disagrees ends the trust. */
long long saltus_trust_lines(const double complex *all, const double complex *half, long long half_bins,
                             long long stride) {
    long long lines = half_bins > 2 ? (half_bins - 2) / stride : 0, trusted = lines;
    double highest = 0, reference = 0;
    for (long long n = 1; n <= lines; n++)
        highest = fmax(highest, cabs(all[n * stride]));
    for (long long n = lines; n >= 1; n--) {
        double difference = cabs(all[n * stride] - half[n * stride]);
        reference = fmax(reference, cabs(all[n * stride]));
        if (!(difference <= fmax(tolerance * reference, rounding * highest)))
            trusted = n - 1;
    }
    return trusted * stride;
}

/* The band of bin k, from 1 on. */
static int band_of(long long k) {
    int band = (int)floor(bands_per_octave * log2((double)k) + 1e-9);
    return band < bands_max ? band : bands_max - 1;
}

long long saltus_trust_bands(const double *all, const double *half, long long half_bins) {
    long long trusted = half_bins > 2 ? half_bins - 2 : 0;
    double peak = 0, reference = 0;
    for (long long k = 1; k < half_bins - 1; k++)
        peak = fmax(peak, all[k]);
    for (long long k = trusted; k >= 1;) {
        double power = 0, power_half = 0;
        long long last = k;
        for (int band = band_of(k); k >= 1 && band_of(k) == band; k--) {
            power += all[k];
            power_half += half[k];
        }
        double bins = (double)(last - k);
        reference = fmax(reference, power / bins);
        if (!(fabs(power_half - power) <= bins * fmax(tolerance * reference, rounding * rounding * peak)))
            trusted = k;
    }
    return trusted;
}
