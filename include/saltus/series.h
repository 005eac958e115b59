/* Independent tests for chaos, from stroboscopic points alone: the 0-1 test, the correlation dimension, and
 * whether the points fill closed curves as those of a quasi-periodic motion do.
 *
 * These functions know nothing of a system. A series holds one value or one point of the state space per
 * forcing period, in order of time, without transients. Do not pass samples taken more often: the 0-1 test
 * would see slow oscillations where there is chaos. Input belongs to the caller; results hold no references.
 * Equal input gives equal results, bit for bit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SERIES_H
#define SALTUS_SERIES_H

#include "saltus/status.h"

#include <stdbool.h>

SALTUS_API_BEGIN

enum { SALTUS_SERIES_LEAST = 200 /* fewest values or points accepted */ };

/* Section points of a trajectory. Distances are Euclidean, of weighted components. */
typedef struct saltus_series_points {
    const double *values;  /* count x dimension: points one after the other in order of time */
    const double *weights; /* dimension entries, 1 over the scale of each component; NULL: all 1 */
    long long count;
    int dimension;
} saltus_series_points;

typedef struct saltus_series_options {
    unsigned long seed; /* default 1 */
    double resolution;  /* smaller differences, relative to the largest weighted value, count as zero; default
                           1e-9 */
    int frequencies;    /* of the 0-1 test; default 100 */
    long long window;   /* pairs at most this far apart in time are left out; -1: three times the lag at which
                           the autocorrelation has fallen to 1/e, at most a tenth of the series; default -1 */
    long long pairs; /* most pairs compared for the dimension: all pairs if there are fewer, otherwise drawn
                        at random; default 8 million, all pairs of 4000 points */
} saltus_series_options;

/* The defaults stated beside the options. */
saltus_series_options saltus_series_defaults(void);

/* The outcome of the 0-1 test. */
typedef struct saltus_series_chaos {
    double k;            /* median of the growth rates: about 0 for regular motion, 1 for chaos */
    double lower, upper; /* their quartiles; far apart if the answer is not clear */
    bool constant;       /* the series does not vary beyond the resolution; k is 0 then */
} saltus_series_chaos;

/* The 0-1 test for chaos (Gottwald & Melbourne, Proc. R. Soc. Lond. A 460 (2004) 603-611), with the
 * correlation method of their "On the implementation of the 0-1 test for chaos", SIAM J. Appl. Dyn. Syst. 8
 * (2009) 129-145. The series of length `count` drives a walk in the plane that turns by an angle c in each
 * step. The mean square displacement of the walk over n steps is bounded for regular motion and grows like n
 * for chaos; the growth rate for one c is its correlation with n, up to n = count / 10. Subtracting the mean
 * of the series first removes the oscillation that it adds to the displacement. The angles are drawn from
 * (pi/5, 4 pi/5), one from each of equal parts. Angles that resonate with a spectral line give rates near 1,
 * so the median is used. Noise counts as chaos, and so does a drift that has not died out. Cost: count^2 / 10
 * per angle up to 10000 values; beyond, only 1000 evenly spread n are used. Errors: SALTUS_BAD_INPUT (fewer
 * than SALTUS_SERIES_LEAST values, values not finite, options), SALTUS_NO_MEMORY. */
saltus_status saltus_series_chaos_test(const double *series, long long count,
                                       const saltus_series_options *options, saltus_series_chaos *chaos,
                                       saltus_message *message);

/* A correlation dimension and its errors. */
typedef struct saltus_series_dimension {
    double dimension;
    double error;       /* total error */
    double sampling;    /* standard error due to the finite number of points */
    double variation;   /* largest deviation of the slope over one octave from that over the whole range */
    double drift;       /* how far the slope over these radii may be from its limit at ever smaller ones */
    double radius[2];   /* range of weighted distances used for the slope */
    bool decade;        /* the range spans a decade; a shorter range gives a hint rather than a dimension */
    long long pairs;    /* pairs compared */
    long long within;   /* of these, pairs no farther apart than the larger radius */
    long long distinct; /* estimated number of distinct points visited again and again; 0: the points do not
                           recur */
    long long window;   /* time window used */
    double ceiling;     /* 2 log10(count): so few points cannot resolve dimensions near or above it */
} saltus_series_dimension;

/* The correlation dimension of a set of points (Grassberger & Procaccia, Phys. Rev. Lett. 50 (1983) 346-349;
 * Physica D 9 (1983) 189-208), without pairs close in time (Theiler, Phys. Rev. A 34 (1986) 2427-2432): the
 * slope of log C(r) over log r, where C(r) is the share of pairs closer than r. The range of radii is a
 * decade or more in which the slope is best known and C is at most 1/20; a shorter range if no decade
 * determines the slope to a tenth. If a decade of smaller radii has a different slope, that slope is used:
 * noise above the resolution is structure too. The sampling error comes from a jackknife over 16 blocks in
 * time, because pairs that share a point, and successive points, are not independent. Sets with a singular
 * density, such as that of the logistic map at r = 4, approach a power law more slowly than any power (C(r)
 * as r log r), and their slope is a tenth too small. The points cannot reveal this, so the error is never
 * smaller. Points that on average recur at least once within the resolution have dimension 0 without error.
 * Errors: SALTUS_BAD_INPUT (fewer than SALTUS_SERIES_LEAST points, values or weights not finite, options),
 * SALTUS_NO_CONVERGENCE (too few pairs at small distances for any range of radii), SALTUS_NO_MEMORY. */
saltus_status saltus_series_correlation_dimension(const saltus_series_points *points,
                                                  const saltus_series_options *options,
                                                  saltus_series_dimension *dimension,
                                                  saltus_message *message);

/* Whether points fill closed curves, and the measures behind the answer. */
typedef struct saltus_series_curve {
    bool closed;      /* the verdict: all measures agree */
    double thickness; /* median ratio of width to length of 8 neighbours; small on a curve */
    double thinning;  /* factor by which 16 neighbours increase the thickness: 2 on a smooth curve, about 1 on
                         a surface or a fractal, less than 1 if noise sets the width */
    double kept; /* share of neighbours that are still neighbours at a later time: 1 on a curve mapped one to
                    one onto itself, near 0 for chaos */
    double balance; /* how evenly neighbours lie on both sides of a point: 0.9 on an evenly visited curve, 0.8
                       on one visited at random, 0.5 on a Cantor set */
    double ends;    /* the same for the first and last points of the series: 0 if they are ends, as in a
                       transient */
    bool recurs;    /* the points repeat within the resolution: periodic, not a curve; all measures after
                       `thinning` are 0 then */
    int curves;     /* if closed: number of curves visited in turn, up to 64 */
} saltus_series_curve;

/* Whether section points belong to a quasi-periodic motion with two frequencies, which fills one closed curve
 * or a few visited in turn. Three properties are tested. (1) Neighbourhoods in state space, without points
 * close in time, have one dominant direction (local principal components; Broomhead, Jones & King, J. Phys. A
 * 20 (1987) L563-L569), and their width shrinks faster than their length; since the majority decides, corners
 * are allowed. (2) Neighbours remain neighbours, in rank, throughout the series, as under a one-to-one map of
 * a curve onto itself, and do not separate. (3) Points have neighbours on both sides, unlike those of a
 * Cantor set, and so do the first and last points of the series. This excludes arcs with ends: mapped one to
 * one onto itself, an arc has no recurrent points except periodic ones, so it could only be a drift from one
 * end to the other. The answer is also no if the points are too few: fewer than about 50 per bend, or a
 * rotation number so near a fraction that gaps between the visits are still open. At most about a thousand
 * points are examined. Errors: SALTUS_BAD_INPUT (fewer than SALTUS_SERIES_LEAST points, values or weights not
 * finite, options), SALTUS_NO_MEMORY. */
saltus_status saltus_series_closed_curve(const saltus_series_points *points,
                                         const saltus_series_options *options, saltus_series_curve *curve,
                                         saltus_message *message);

/* Intermittency: laminar phases, in which points nearly recur. */
typedef struct saltus_series_phases {
    double laminar;    /* fraction of the points in such phases */
    int period;        /* in points; 0: no such phases */
    long long longest; /* points of the longest phase */
} saltus_series_phases;

/* The period up to `longest` with the most points in laminar phases (the shortest if several have equally
 * many). A phase of period p is a run of points that lie within 1/50 of the series' extent from the points p
 * earlier: at least 20 of them and 5 p, counted together with the p points before. The extent is the largest
 * distance from the first point; distances here are the largest weighted difference of a component. */
saltus_series_phases saltus_series_laminar_phases(const saltus_series_points *points, int longest);

SALTUS_API_END
#endif
