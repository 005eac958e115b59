/* Clouds of points as densities: a 2-D histogram at the resolution of the page.
 *
 * A trajectory is drawn with its own weight, one, which its points share: a periodic one with few points is
 * dark, one that never repeats is a veil, and how long each was recorded does not matter.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/raster.h"

#include <gsl/gsl_sort_float.h>
#include <math.h>
#include <stdlib.h>

bool saltus_tally_open(saltus_tally *tally, int width, int height) {
    size_t size = (size_t)width * (size_t)height;
    *tally = (saltus_tally){width, height, calloc(size, sizeof(float)), calloc(size, sizeof(float))};
    if (tally->cover && tally->weight)
        return true;
    saltus_tally_close(tally);
    return false;
}

void saltus_tally_close(saltus_tally *tally) {
    free(tally->cover);
    free(tally->weight);
    *tally = (saltus_tally){0};
}

/* The part of pixel k that lies between two places. */
static double overlap(int k, double low, double high) {
    return fmax(0, fmin(high, k + 1) - fmax(low, k));
}

void saltus_tally_add(saltus_tally *tally, double left, double right, double y, double thick, double part) {
    double low = y - 0.5 * thick, high = y + 0.5 * thick;
    if (!(right > 0 && left < tally->width && high > 0 && low < tally->height))
        return;
    int x0 = left > 0 ? (int)left : 0, y0 = low > 0 ? (int)low : 0;
    for (int j = y0; j < tally->height && j < high; j++)
        for (int i = x0; i < tally->width && i < right; i++) {
            size_t place = (size_t)j * (size_t)tally->width + (size_t)i;
            double covered = overlap(i, left, right) * overlap(j, low, high);
            tally->cover[place] += (float)covered;
            tally->weight[place] += (float)(part * covered);
        }
}

static double density_at(const saltus_tally *tally, size_t k) {
    return tally->weight[k] / fmin(tally->cover[k], 1);
}

/* Logarithms of the densities between which opacity grows. */
static void find_tones(const saltus_tally *tally, double *low, double *high) {
    enum { sample = 20000 };
    const double least_ratio = 40, rare = 0.02, common = 0.97;
    size_t size = (size_t)tally->width * (size_t)tally->height, filled = 0, count = 0, seen = 0;
    float *densities = malloc(sample * sizeof *densities);
    for (size_t k = 0; k < size; k++)
        filled += tally->cover[k] > 0;
    for (size_t k = 0; k < size && densities && count < sample; k++)
        if (tally->cover[k] > 0 && seen++ % (1 + filled / sample) == 0)
            densities[count++] = (float)density_at(tally, k);
    *low = *high = 0;
    if (count) {
        gsl_sort_float(densities, 1, count);
        *low = log(densities[(size_t)(rare * (double)(count - 1))]);
        *high = log(densities[(size_t)(common * (double)(count - 1))]);
    }
    *low = fmin(*low, *high - log(least_ratio));
    free(densities);
}

void saltus_tally_paint(const saltus_tally *tally, uint32_t colour, saltus_raster *raster) {
    const double faintest = 0.16, levels = 24; /* few levels keep compressed files small */
    double low, high;
    find_tones(tally, &low, &high);
    for (int y = 0; y < tally->height; y++)
        for (int x = 0; x < tally->width; x++) {
            size_t k = (size_t)y * (size_t)tally->width + (size_t)x;
            if (tally->cover[k] <= 0)
                continue;
            double tone = fmin(fmax((log(density_at(tally, k)) - low) / (high - low), 0), 1);
            double opacity = fmin(tally->cover[k], 1) * (faintest + (1 - faintest) * tone);
            saltus_raster_set(raster, x, y, colour, round(opacity * levels) / levels);
        }
}
