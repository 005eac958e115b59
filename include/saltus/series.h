/* Second opinions on chaos, from stroboscopic points alone: the 0-1 test, the correlation dimension, and
 * whether the points fill closed curves as those of a quasi-periodic motion do.
 *
 * Nothing is known here of a system. A series holds one value, or one point of the state space, per period of
 * the forcing, in order of time, transients left out. Samples taken more often are no stroboscopic series:
 * the 0-1 test then finds slow oscillations where there is chaos. The calls keep nothing: what they read
 * belongs to the caller, what they find is in the result. Equal input gives equal results, bit for bit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SERIES_H
#define SALTUS_SERIES_H

#include "saltus/status.h"

#include <stdbool.h>

SALTUS_API_BEGIN

enum { SALTUS_SERIES_LEAST = 200 /* values or points at least */ };

/* Section points of a trajectory. Distances are Euclidean ones of weighted components. */
typedef struct saltus_series_points {
    const double *values;  /* count x dimension, one point after the other in order of time */
    const double *weights; /* dimension of them, one over the component's scale; NULL: all 1 */
    long long count;
    int dimension;
} saltus_series_points;

typedef struct saltus_series_options {
    unsigned long seed; /* default 1 */
    double resolution;  /* differences up to this, relative to the largest weighted value, are none; default
                           1e-9 */
    int frequencies;    /* of the 0-1 test; default 100 */
    long long window;   /* points no farther apart in time than this are not compared; -1: chosen, three times
                           the lag at which the autocorrelation has fallen to 1/e, at most a tenth of all;
                           default -1 */
    long long pairs;    /* of points compared for the dimension, at most: all where they are no more than
                           these, else drawn at random; default 8 million, all of 4000 points */
} saltus_series_options;

/* As told beside the options. */
saltus_series_options saltus_series_defaults(void);

/* The outcome of the 0-1 test. */
typedef struct saltus_series_chaos {
    double k;            /* median of the growth rates: about 0 for regular motion, 1 for chaos */
    double lower, upper; /* their quartiles; far apart where the answer is not clear */
    bool constant;       /* the series does not vary beyond the resolution; k is 0 then */
} saltus_series_chaos;

/* The 0-1 test for chaos (Gottwald & Melbourne, Proc. R. Soc. Lond. A 460 (2004) 603-611; as in their "On the
 * implementation of the 0-1 test for chaos", SIAM J. Appl. Dyn. Syst. 8 (2009) 129-145, by correlation). The
 * series of length `count` drives a walk in the plane, turned by an angle c each step; the walk's mean square
 * displacement over n steps is bounded for regular motion and grows like n for chaos, and the rate for one c
 * is its correlation with n, up to n = count / 10. The mean is taken off the series first, so that the
 * oscillation that it adds to the displacement is not there. The angles are drawn from (pi/5, 4 pi/5), one
 * from each of equal parts; those that resonate with a line of the spectrum give rates near 1, which is why
 * the median counts. Noise counts as chaos, and so does a drift that the series has not got over. Cost:
 * count^2 / 10 per angle up to 10000 values (beyond, 1000 evenly spread n are used).
 * Errors: SALTUS_BAD_INPUT (fewer than SALTUS_SERIES_LEAST values, values that are not finite, options),
 * SALTUS_NO_MEMORY. */
saltus_status saltus_series_chaos_test(const double *series, long long count,
                                       const saltus_series_options *options, saltus_series_chaos *chaos,
                                       saltus_message *message);

/* A correlation dimension and what it rests on. */
typedef struct saltus_series_dimension {
    double dimension;
    double error;       /* of all kinds together */
    double sampling;    /* standard error that comes of the finite number of points */
    double variation;   /* largest deviation of an octave's slope from that over the whole range */
    double drift;       /* how far a slope over these radii may be from that over ever smaller ones */
    double radius[2];   /* range of weighted distances over which the slope was taken */
    bool decade;        /* that range spans a decade; a shorter one is a hint rather than a dimension */
    long long pairs;    /* compared */
    long long within;   /* of these no farther apart than the larger radius */
    long long distinct; /* about so many distinct points are visited again and again; 0: they do not recur */
    long long window;   /* in time, as used */
    double ceiling;     /* 2 log10(count): dimensions near it or above cannot be told from so few points */
} saltus_series_dimension;

/* The correlation dimension of a set of points (Grassberger & Procaccia, Phys. Rev. Lett. 50 (1983) 346-349;
 * Physica D 9 (1983) 189-208), without the pairs that are close in time (Theiler, Phys. Rev. A 34 (1986)
 * 2427-2432): the slope of log C(r) over log r, where C(r) is the share of pairs closer than r. The range of
 * radii is a decade or more in which the slope is best known and C is at most 1/20; a shorter one where no
 * decade has a slope known to a tenth. Where a decade of smaller radii has a slope of its own, that one
 * counts: noise above the resolution is structure too. The sampling error comes of a jackknife over 16 blocks
 * in time, because pairs that share a point, and points that follow each other, are not independent. Sets
 * whose density is singular, such as that of the logistic map at r = 4, approach a power law slower than any
 * power, C(r) as r log r: their slope comes out a tenth too small. As that cannot be told from the points the
 * error is never smaller. Points that recur within the resolution,
 * once or more on average, have dimension 0 without error. Errors: SALTUS_BAD_INPUT (fewer than
 * SALTUS_SERIES_LEAST points, values or weights that are not finite, options), SALTUS_NO_CONVERGENCE (too few
 * pairs at small distances for any range of radii), SALTUS_NO_MEMORY. */
saltus_status saltus_series_correlation_dimension(const saltus_series_points *points,
                                                  const saltus_series_options *options,
                                                  saltus_series_dimension *dimension,
                                                  saltus_message *message);

/* Whether points fill closed curves, and the measures that say so. */
typedef struct saltus_series_curve {
    bool closed;      /* the verdict: all measures agree */
    double thickness; /* median ratio of width to length of 8 neighbours; small on a curve */
    double thinning; /* by what factor 16 neighbours make it larger: 2 on a smooth curve, about 1 on a surface
                        or a fractal, less than 1 where noise makes the width */
    double kept;     /* share of neighbours that are neighbours still at a later time: 1 on a curve that is
                        mapped one to one onto itself, near 0 for chaos */
    double balance;  /* how evenly neighbours lie on both sides of a point: 0.9 on a curve that is visited
                        evenly, 0.8 on one visited at random, 0.5 on a Cantor set */
    double ends; /* the same for the first and the last points of the series: 0 where these are ends, as in
                    a transient */
    bool recurs; /* the points come again within the resolution: periodic, no curve; the measures that
                    follow thinning are 0 then */
    int curves;  /* where closed, the number of curves that are visited in turn, up to 64 */
} saltus_series_curve;

/* Whether section points are those of a quasi-periodic motion with two frequencies, which fill a closed curve
 * or a few that are visited in turn. Neighbourhoods in state space, points close in time left out, have one
 * dominant direction (local principal components; Broomhead, Jones & King, J. Phys. A 20 (1987) L563-L569),
 * and their width falls faster than their length when they shrink. Most of them decide, so corners are
 * allowed. Neighbours stay neighbours, in rank, for as long as the series lasts: so it is under a one-to-one
 * map of a curve onto itself, and not where neighbours separate. Points have neighbours on both sides, which
 * those of a Cantor set have not, and the first and last of the series have too: an arc with ends, mapped one
 * to one onto itself, has no points that recur but periodic ones, so what is left of it is a drift from one
 * end to the other. No is also the answer where points are too few: fewer than about 50 for a bend, or a
 * rotation number so near a fraction that gaps between the visits are open still. Of many points, a thousand
 * are looked at. Errors: SALTUS_BAD_INPUT (fewer than SALTUS_SERIES_LEAST points, values or weights that are
 * not finite, options), SALTUS_NO_MEMORY. */
saltus_status saltus_series_closed_curve(const saltus_series_points *points,
                                         const saltus_series_options *options, saltus_series_curve *curve,
                                         saltus_message *message);

/* Phases in which points nearly recur: intermittency, a motion that is nearly periodic for a while. */
typedef struct saltus_series_phases {
    double laminar;    /* part of the points that belong to such phases */
    int period;        /* in points; 0: there are no phases */
    long long longest; /* points of the longest phase */
} saltus_series_phases;

/* The period up to `longest` with which most points lie in laminar phases (the shortest of equals). A phase
 * of period p is a run of points that are within 1/50 of the series' extent of those p before them, at least
 * 20 of them and 5 p, together with the p before; the extent is the largest distance from the first point,
 * and distances are here the largest weighted difference of a component. */
saltus_series_phases saltus_series_laminar_phases(const saltus_series_points *points, int longest);

SALTUS_API_END
#endif
