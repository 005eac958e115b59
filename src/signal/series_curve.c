/* Test whether points fill closed curves that the map takes one to one onto themselves.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "signal/series.h"

#include "base/dense.h"

#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics_double.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    few = 8, /* neighbours in a small neighbourhood, ... */
    many = 16,
    places_max = 1000, /* points whose neighbourhoods are examined */
    still_near = 16,   /* rank up to which a point still counts as a neighbour */
    curves_max = 64
};

/* Results and work space. */
typedef struct survey {
    saltus_arena arena;
    const saltus_series_cloud *cloud;
    int places;
    long long *neighbour; /* [places][many], nearest first */
    double *square;       /* [many]: squared distances of the neighbours */
    double *thin, *thick; /* [places]: ratios of width to length with few and with many neighbours */
    double *offset;       /* [many + 1][dimension]: neighbourhood relative to its mean */
    double *direction, *image;
    long long coincident; /* points within the resolution of a place, summed over places */
} survey;

/* The k-th place. The golden section spreads places over the series without a period of their own. */
static long long place_at(const survey *s, int k) {
    const double golden = 0.6180339887498949;
    if (s->places == s->cloud->count)
        return k;
    return (long long)(fmod(golden * (k + 1), 1) * (double)s->cloud->count);
}

/* The nearest neighbours of point i that are not close to it in time, by insertion. */
static void find_neighbours(survey *s, long long i, long long *neighbour) {
    const saltus_series_cloud *cloud = s->cloud;
    const double *point = saltus_series_cloud_point(cloud, i);
    double none = cloud->resolution * cloud->resolution;
    for (int k = 0; k < many; k++)
        s->square[k] = INFINITY;
    for (long long j = 0; j < cloud->count; j++) {
        if (j >= i - cloud->window && j <= i + cloud->window)
            continue;
        double square = saltus_distance_square(point, saltus_series_cloud_point(cloud, j), cloud->dimension);
        s->coincident += square <= none;
        if (square >= s->square[many - 1])
            continue;
        int k = many - 1;
        for (; k > 0 && s->square[k - 1] > square; k--) {
            s->square[k] = s->square[k - 1];
            neighbour[k] = neighbour[k - 1];
        }
        s->square[k] = square;
        neighbour[k] = j;
    }
}

static void normalise(double *a, int n) {
    double square = saltus_dot(a, a, n);
    for (int d = 0; d < n; d++)
        a[d] = square > 0 ? a[d] / sqrt(square) : d == 0;
}

/* Width over length of the neighbourhood of point i: 0 for points on a line, up to 1 on a surface, more in
 * higher dimensions. Leaves the offsets from the mean (the point's own last) and their direction in `s`. */
static double width_over_length(survey *s, long long i, const long long *neighbour, int count) {
    enum { iterations = 20 };
    int n = s->cloud->dimension;
    double length = 0, width = 0;
    for (int d = 0; d < n; d++) {
        double mean = 0;
        for (int k = 0; k <= count; k++) {
            s->offset[k * n + d] = saltus_series_cloud_point(s->cloud, k < count ? neighbour[k] : i)[d];
            mean += s->offset[k * n + d] / (count + 1);
        }
        for (int k = 0; k <= count; k++)
            s->offset[k * n + d] -= mean;
    }
    /* The dominant direction, by power iteration. If that converges slowly none dominates, and any will do.
     */
    memcpy(s->direction, s->offset + (count - 1) * n, (size_t)n * sizeof *s->direction);
    normalise(s->direction, n);
    for (int round = 0; round < iterations; round++) {
        memset(s->image, 0, (size_t)n * sizeof *s->image);
        for (int k = 0; k <= count; k++) {
            double along = saltus_dot(s->offset + k * n, s->direction, n);
            for (int d = 0; d < n; d++)
                s->image[d] += along * s->offset[k * n + d];
        }
        memcpy(s->direction, s->image, (size_t)n * sizeof *s->direction);
        normalise(s->direction, n);
    }
    for (int k = 0; k <= count; k++) {
        const double *offset = s->offset + k * n;
        double along = saltus_dot(offset, s->direction, n);
        length += along * along;
        for (int d = 0; d < n; d++) {
            double across = offset[d] - along * s->direction[d];
            width += across * across;
        }
    }
    return length > 0 ? sqrt(width / length) : 1;
}

/* How evenly the neighbours of the last point examined lie on its two sides along s->direction: 0 (on one
 * side) to 1. */
static double balance_of(const survey *s) {
    int n = s->cloud->dimension, before = 0;
    double own = saltus_dot(s->offset + many * n, s->direction, n);
    for (int k = 0; k < many; k++)
        before += saltus_dot(s->offset + k * n, s->direction, n) < own;
    return 2.0 / many * (before < many - before ? before : many - before);
}

/* Share of nearest neighbours that still have a low rank some time later. Pairs near the end of the series
 * are left out. */
static double share_kept(const survey *s) {
    const double silver = 0.4142135623730951;
    const saltus_series_cloud *cloud = s->cloud;
    int pairs = 0, kept = 0;
    for (int k = 0; k < s->places; k++) {
        long long i = place_at(s, k), j = s->neighbour[(size_t)k * many];
        long long left = cloud->count - 1 - (i > j ? i : j);
        long long later = 1 + (long long)(fmod(silver * (k + 1), 1) * (double)(left - 1));
        if (left < cloud->count / 10)
            continue;
        pairs++;
        i += later;
        j += later;
        /* How many points are closer to i than j is, without those close in time to i. */
        const double *point = saltus_series_cloud_point(cloud, i);
        double limit = saltus_distance_square(point, saltus_series_cloud_point(cloud, j), cloud->dimension);
        int rank = 0;
        for (long long l = 0; l < cloud->count && rank <= still_near; l++)
            if (l < i - cloud->window || l > i + cloud->window)
                rank += saltus_distance_square(point, saltus_series_cloud_point(cloud, l), cloud->dimension) <
                        limit;
        kept += rank <= still_near;
    }
    return pairs > 0 ? (double)kept / pairs : 0;
}

/* Balance at the first and the last points of the series. If the curve is an arc, these are its ends. */
static double balance_at_ends(survey *s) {
    enum { ends = 4 };
    double sum = 0;
    for (int k = 0; k < 2 * ends; k++) {
        long long i = k < ends ? k : s->cloud->count - 1 - (k - ends), neighbour[many] = {0};
        find_neighbours(s, i, neighbour);
        width_over_length(s, i, neighbour, many);
        sum += balance_of(s) / (2 * ends);
    }
    return sum;
}

/* Number of curves visited in turn: the times of points on the same curve differ by multiples of it. A few
 * neighbours may come from another curve that passes nearby. */
static int count_curves(const survey *s) {
    for (int curves = curves_max; curves > 1; curves--) {
        long long same = 0;
        for (int k = 0; k < s->places; k++)
            for (int m = 0; m < many; m++)
                same += (place_at(s, k) - s->neighbour[(size_t)k * many + (size_t)m]) % curves == 0;
        if ((double)same >= 0.99 * s->places * many)
            return curves;
    }
    return 1;
}

static void judge(survey *s, saltus_series_curve *curve) {
    static const double thin_enough = 0.2, surely_thin = 0.01, grows = 1.5, thick_at_most = 0.35, most = 0.95,
                        balanced = 0.58, no_end = 0.3;
    double balance = 0; /* mean over the places */
    for (int k = 0; k < s->places; k++) {
        long long i = place_at(s, k), *neighbour = s->neighbour + (size_t)k * many;
        find_neighbours(s, i, neighbour);
        s->thin[k] = width_over_length(s, i, neighbour, few);
        s->thick[k] = width_over_length(s, i, neighbour, many);
        balance += balance_of(s) / s->places;
    }
    gsl_sort(s->thin, 1, (size_t)s->places);
    gsl_sort(s->thick, 1, (size_t)s->places);
    double thin = gsl_stats_median_from_sorted_data(s->thin, 1, (size_t)s->places);
    double thick = gsl_stats_median_from_sorted_data(s->thick, 1, (size_t)s->places);
    curve->thickness = thin;
    curve->thinning = thin > 0 ? thick / thin : 2;
    curve->recurs = s->coincident >= s->places;
    if (curve->recurs)
        return;
    curve->kept = share_kept(s);
    curve->ends = balance_at_ends(s);
    curve->balance = balance;
    curve->closed = s->cloud->dimension > 1 && thin <= thin_enough && thick <= thick_at_most &&
                    (curve->thinning >= grows || thin <= surely_thin) && curve->kept >= most &&
                    curve->balance >= balanced && curve->ends >= no_end;
    curve->curves = curve->closed ? count_curves(s) : 0;
}

saltus_status saltus_series_closed_curve(const saltus_series_points *points,
                                         const saltus_series_options *options, saltus_series_curve *curve,
                                         saltus_message *message) {
    saltus_series_cloud cloud;
    *curve = (saltus_series_curve){.recurs = true};
    saltus_status status = saltus_series_cloud_open(points, options, &cloud, message);
    if (status != SALTUS_OK)
        return status;
    if (cloud.unit > 0) {
        survey s = {.cloud = &cloud, .places = (int)(cloud.count < places_max ? cloud.count : places_max)};
        const size_t n = (size_t)cloud.dimension, places = (size_t)s.places;
        do {
            s.neighbour = (long long *)(void *)saltus_arena_doubles(&s.arena, places * many);
            s.square = saltus_arena_doubles(&s.arena, many);
            s.thin = saltus_arena_doubles(&s.arena, places);
            s.thick = saltus_arena_doubles(&s.arena, places);
            s.offset = saltus_arena_doubles(&s.arena, (many + 1) * n);
            s.direction = saltus_arena_doubles(&s.arena, n);
            s.image = saltus_arena_doubles(&s.arena, n);
        } while (saltus_arena_again(&s.arena));
        if (s.arena.base)
            judge(&s, curve);
        else
            status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for neighbourhoods");
        saltus_arena_close(&s.arena);
    }
    free(cloud.x);
    return status;
}
