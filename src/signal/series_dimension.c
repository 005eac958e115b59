/* The correlation dimension of a set of points.
 *
 * Distances are counted in bins of the radius whose squared edges are powers of two, or one and a half times
 * these, so that the leading bits of a squared distance give its bin. There is a tally for each pair of 16
 * blocks in time; leaving out all tallies of one block gives a replicate of the jackknife.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "signal/series.h"

#include <gsl/gsl_math.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum {
    blocks = 16,
    octave = 4,              /* edges per octave of radius */
    octaves = 40,            /* of radius, below the largest one */
    bins = octave * octaves, /* of distance */
    edges = bins + 1,        /* radii that bound the bins */
    replicates = blocks + 1,
    least_pairs = 32, /* pairs needed below the smallest radius of a range, ... */
    least_left = 16,  /* ... and without the pairs of any one block */
    few_neighbours = 10
};
static const double decade = 10;
static const double other_slope = 0.25; /* slopes of one fractal do not differ by this much */
/* If points have few neighbours, the nearest ones are near-recurrences, with a gap to all other distances. A
 * slope below this value is then not a dimension. */
static const double least_slope = 0.75;

/* Numbers of pairs by distance, and work space. */
typedef struct tally {
    saltus_arena arena;
    long long *pairs; /* [block][block][bin], first block <= second */
    double *radius;   /* [edge]: logarithm of the radius */
    double *count;    /* [replicate][edge]: pairs below the radius, first with all blocks; later logarithms */
    double neighbours; /* neighbours of a point, on average, per counted pair */
    long long compared, coincident;
    saltus_random random;
} tally;

/* A range of radii and the slope over it. */
typedef struct range {
    int first, last; /* edges */
    double slope;
    double sampling;             /* standard error */
    double deviation, variation; /* of local slopes from the slope: standard and largest */
    double weight;               /* error by which ranges are compared; INFINITY: rejected */
} range;

static long long *tally_of(const tally *t, int a, int b) {
    return t->pairs + ((a < b ? a : b) * blocks + (a < b ? b : a)) * bins;
}

/* Exponent and one bit of the mantissa: two bins per octave of the square. */
enum { dropped_bits = 51, lowest = 2 * (1023 - 2 * octaves) };

static inline int bin_of(double square) {
    uint64_t bits;
    memcpy(&bits, &square, sizeof bits);
    int64_t bin = (int64_t)(bits >> dropped_bits) - lowest;
    return bin < 0 ? 0 : bin >= bins ? bins - 1 : (int)bin;
}

/* Count the pairs of point i with the points from `from` to before `to`. */
static void compare_with(const saltus_series_cloud *cloud, long long i, long long from, long long to,
                         long long *pairs, tally *t) {
    double nearest = cloud->resolution * cloud->resolution;
    const double *point = saltus_series_cloud_point(cloud, i);
    long long coincident = 0;
    for (long long j = from; j < to; j++) {
        double square = saltus_distance_square(point, saltus_series_cloud_point(cloud, j), cloud->dimension);
        pairs[bin_of(square)]++;
        coincident += square <= nearest;
    }
    t->compared += to > from ? to - from : 0;
    t->coincident += coincident;
}

/* Compare `pairs` random pairs, except those that are close in time. */
static void compare_some(const saltus_series_cloud *cloud, long long pairs, tally *t) {
    enum { batch = 1024 };
    gsl_rng *rng = saltus_random_rng(&t->random);
    long long chosen[2 * batch];
    for (long long done = 0; done < pairs; done += batch) {
        int drawn = pairs - done < batch ? (int)(pairs - done) : batch;
        for (int k = 0; k < 2 * drawn; k++)
            chosen[k] = (long long)(gsl_rng_uniform(rng) * (double)cloud->count);
        for (int k = 0; k < 2 * drawn; k += 2) {
            long long i = chosen[k], j = chosen[k + 1];
            if ((i > j ? i - j : j - i) > cloud->window)
                compare_with(cloud, i, j, j + 1,
                             tally_of(t, (int)(i * blocks / cloud->count), (int)(j * blocks / cloud->count)),
                             t);
        }
    }
}

/* Count the pairs below each radius: with all blocks, and without each block in turn. */
static void accumulate(const saltus_series_cloud *cloud, tally *t) {
    for (int a = 0; a < blocks; a++)
        for (int b = a; b < blocks; b++)
            for (int bin = 0; bin < bins; bin++)
                for (int r = 0; r < replicates; r++)
                    if (r != a + 1 && r != b + 1)
                        t->count[r * edges + bin + 1] += (double)tally_of(t, a, b)[bin];
    for (int r = 0; r < replicates; r++)
        for (int e = 1; e < edges; e++)
            t->count[r * edges + e] += t->count[r * edges + e - 1];
    for (int e = 0; e < edges; e++) {
        const uint64_t bits = (uint64_t)(e + lowest) << dropped_bits;
        double square;
        memcpy(&square, &bits, sizeof square);
        t->radius[e] = 0.5 * log(square);
    }
    t->neighbours = (double)cloud->count / (double)t->compared;
}

/* Least-squares slope of log(count) over log(radius). */
static double slope_of(const tally *t, int replicate, int first, int last) {
    const double *count = t->count + replicate * edges;
    double n = last - first + 1, x = 0, y = 0, xx = 0, xy = 0;
    for (int e = first; e <= last; e++) {
        x += t->radius[e] / n;
        y += count[e] / n;
    }
    for (int e = first; e <= last; e++) {
        xx += (t->radius[e] - x) * (t->radius[e] - x);
        xy += (t->radius[e] - x) * (count[e] - y);
    }
    return xy / xx;
}

/* The slope over a range and its errors. The weight is INFINITY unless it is less than `least`. Local slopes
 * of a fractal oscillate and average out over a long range, so the weight divides their deviation by the
 * square root of the range in octaves; the error in the result does not. */
static range fit(const tally *t, int first, int last, double least) {
    range r = {.first = first, .last = last, .slope = slope_of(t, 0, first, last), .weight = INFINITY};
    double length = sqrt((t->radius[last] - t->radius[first]) / M_LN2);
    double slope[blocks], mean = 0, squares = 0;
    /* Local slopes over all octaves in the range, beginning at each edge. */
    int count = last - first - octave + 1;
    for (int k = 0; k < count; k++) {
        double local = slope_of(t, 0, first + k, first + k + octave);
        squares += (local - mean) * (local - mean) * k / (k + 1);
        mean += (local - mean) / (k + 1);
        r.variation = fmax(r.variation, fabs(local - r.slope));
    }
    r.deviation = sqrt(squares / (count - 1));
    if (r.deviation / length >= least)
        return r;
    /* The jackknife. */
    mean = squares = 0;
    for (int b = 0; b < blocks; b++) {
        slope[b] = slope_of(t, b + 1, first, last);
        mean += slope[b] / blocks;
    }
    for (int b = 0; b < blocks; b++)
        squares += (slope[b] - mean) * (slope[b] - mean);
    r.sampling = sqrt(squares * (blocks - 1) / blocks);
    double weight = hypot(r.sampling, r.deviation / length);
    r.weight = weight < least ? weight : INFINITY;
    return r;
}

/* The range between two edges, at least `factor` long, with the best known slope; false if there is none. */
static bool best_range(const tally *t, int low, int high, double factor, range *best) {
    best->weight = INFINITY;
    for (int first = low; first <= high; first++)
        for (int last = first + octave + 1; last <= high; last++) {
            if (t->radius[last] - t->radius[first] < log(factor) - 1e-9)
                continue;
            range r = fit(t, first, last, best->weight);
            if (isfinite(r.weight) &&
                (r.slope >= least_slope || exp(t->count[first]) * t->neighbours >= few_neighbours))
                *best = r;
        }
    return isfinite(best->weight);
}

static double error_of(const range *r) {
    return hypot(r->sampling, r->variation);
}

/* Whether a slope is known well enough to stand for a dimension. */
static bool is_known(const range *r) {
    return hypot(r->sampling, r->deviation) < fmax(0.1, 0.1 * r->slope);
}

/* Choose the range; false if there is none. A decade or more if the slope is known there, otherwise a shorter
 * range. A decade at smaller radii takes precedence if its slope is different. Turns t->count into
 * logarithms. */
static bool choose_range(const saltus_series_cloud *cloud, tally *t, range *best) {
    static const double largest_share = 0.05;
    int low = edges, high = 0;
    /* Edges between which there are enough pairs, but not too many: near the size of the whole set counts do
     * not follow a power law. */
    for (int e = edges - 1; e >= 0; e--) {
        double left = INFINITY;
        for (int r = 1; r < replicates; r++)
            left = fmin(left, t->count[r * edges + e]);
        if (left >= least_left && t->count[e] >= least_pairs &&
            exp(t->radius[e]) > decade * cloud->resolution)
            low = e;
        if (high == 0 && t->count[e] <= largest_share * (double)t->compared)
            high = e;
    }
    for (int k = 0; k < replicates * edges; k++)
        t->count[k] = log(t->count[k]);
    range other;
    bool found = best_range(t, low, high, decade, best);
    for (double factor = 4; factor >= 2 && !(found && is_known(best)); factor /= 2)
        if (best_range(t, low, high, factor, &other) && (!found || is_known(&other))) {
            *best = other;
            found = true;
        }
    for (int below = found ? best->first : 0; best_range(t, low, below, decade, &other); below = other.first)
        if (is_known(&other) &&
            fabs(other.slope - best->slope) > fmax(other_slope, 2 * hypot(error_of(&other), error_of(best))))
            *best = other;
    return found;
}

/* Count the pairs, then fit the slope. */
static saltus_status judge(const saltus_series_cloud *cloud, const saltus_series_options *options, tally *t,
                           saltus_series_dimension *dimension, saltus_message *message) {
    range r;
    saltus_random_seed(&t->random, options->seed);
    const bool all = cloud->count * (cloud->count - 1) / 2 <= options->pairs;
    for (int a = 0; a < blocks && all; a++)
        for (int b = a; b < blocks; b++) {
            long long to = (b + 1) * cloud->count / blocks, start = b * cloud->count / blocks;
            for (long long i = a * cloud->count / blocks; i < (a + 1) * cloud->count / blocks; i++) {
                long long later = i + cloud->window + 1;
                compare_with(cloud, i, later > start ? later : start, to, tally_of(t, a, b), t);
            }
        }
    if (!all)
        compare_some(cloud, options->pairs, t);
    accumulate(cloud, t);
    dimension->distinct = 0;
    dimension->pairs = t->compared;
    if ((double)t->coincident * t->neighbours >= 1) {
        dimension->distinct = llround((double)t->compared / (double)t->coincident);
        dimension->within = t->coincident;
        dimension->radius[1] = cloud->resolution * cloud->unit;
        return SALTUS_OK;
    }
    if (!choose_range(cloud, t, &r))
        return saltus_fail(
            message, SALTUS_NO_CONVERGENCE,
            "no range of radii for the dimension: too few of %lld pairs are at small distances", t->compared);
    dimension->dimension = r.slope;
    /* If C(r) ~ r^D log(size / r), as for a singular density, the slope is less than D by 1 / log(size / r),
     * or by half of that with a constant added to the logarithm. A few decades cannot exclude this. */
    int widest = edges - 1;
    while (t->count[widest - 1] >= t->count[edges - 1])
        widest--;
    dimension->drift = 0.5 / (t->radius[widest] - 0.5 * (t->radius[r.first] + t->radius[r.last]));
    dimension->error = fmax(error_of(&r), dimension->drift);
    dimension->sampling = r.sampling;
    dimension->variation = r.variation;
    dimension->radius[0] = exp(t->radius[r.first]) * cloud->unit;
    dimension->radius[1] = exp(t->radius[r.last]) * cloud->unit;
    dimension->decade = t->radius[r.last] - t->radius[r.first] > log(decade) - 1e-9;
    dimension->within = llround(exp(t->count[r.last]));
    return SALTUS_OK;
}

saltus_status saltus_series_correlation_dimension(const saltus_series_points *points,
                                                  const saltus_series_options *options,
                                                  saltus_series_dimension *dimension,
                                                  saltus_message *message) {
    saltus_series_cloud cloud;
    *dimension = (saltus_series_dimension){.distinct = 1};
    saltus_status status = saltus_series_cloud_open(points, options, &cloud, message);
    if (status != SALTUS_OK)
        return status;
    dimension->window = cloud.window;
    dimension->ceiling = 2 * log10((double)cloud.count);
    if (cloud.unit > 0) {
        tally t = {0};
        do {
            t.pairs = (long long *)(void *)saltus_arena_doubles(&t.arena, (size_t)blocks * blocks * bins);
            t.radius = saltus_arena_doubles(&t.arena, edges);
            t.count = saltus_arena_doubles(&t.arena, (size_t)replicates * edges);
        } while (saltus_arena_again(&t.arena));
        if (t.arena.base)
            status = judge(&cloud, options, &t, dimension, message);
        else
            status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the correlation dimension");
        saltus_arena_close(&t.arena);
    }
    free(cloud.x);
    return status;
}
