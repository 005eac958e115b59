/* Averages along a trajectory with a reliable standard error.
 *
 * Successive values of a chaotic motion are correlated and those of a regular motion repeat, so neither is a
 * random sample. The values are therefore grouped into batches, at most SALTUS_AVERAGE_BATCHES; when these
 * are full, neighbours are merged. The variance of the mean is the spectrum at frequency zero of an
 * autoregression fitted to the batches (Heidelberger & Welch, Commun. ACM 24 (1981) 233-245). If the values
 * only oscillate, so that their partial sums stay bounded, the error falls like 1/n rather than 1/sqrt(n),
 * and half the largest excursion of the partial sums is used instead. For such values a weighted mean is more
 * accurate still (Das, Saiki, Sander & Yorke, Nonlinearity 30 (2017) 4111-4140); it is used if its values on
 * parts of the run agree.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_AVERAGE_H
#define SALTUS_AVERAGE_H

#include "saltus/status.h"

#include <stdbool.h>

SALTUS_API_BEGIN

enum { SALTUS_AVERAGE_BATCHES = 1024 };

/* Accumulates values; a zeroed one is empty. */
typedef struct saltus_average {
    long long count;        /* values in all */
    long long size;         /* values per batch; 0: empty */
    int batches;            /* complete batches */
    long long open;         /* values in the incomplete batch */
    double partial;         /* sum of the values in the incomplete batch */
    double origin, squares; /* first value; sum of squared distances from it */
    double sum[SALTUS_AVERAGE_BATCHES];
} saltus_average;

typedef struct saltus_estimate {
    double mean;
    double standard_error; /* INFINITY: fewer than 16 values, too few to tell */
    double independent;    /* number of independent values of this variance that would give this error; 0: too
                              few values, or an estimate over a part of the run */
    long long count;       /* values used, in complete batches */
    bool regular;          /* the partial sums stay bounded about their trend */
    bool weighted;         /* the mean is the weighted one */
} saltus_estimate;

/* Add the next value of the series. */
void saltus_average_add(saltus_average *average, double value);
/* Estimate over all values. */
saltus_estimate saltus_average_estimate(const saltus_average *average);
/* The same, always with the plain mean, or with the weighted one (from 128 values on). Means of several
 * quantities of one run add up exactly only if all are of the same kind. */
saltus_estimate saltus_average_plain(const saltus_average *average);
saltus_estimate saltus_average_weighted(const saltus_average *average);
/* Over a part of the run, 0 <= from < to <= 1, in whole batches. */
saltus_estimate saltus_average_part(const saltus_average *average, double from, double to);
/* Combine several runs of the same length. The errors of random values are independent; those of regular
 * values are bounds, which averaging does not reduce. */
saltus_estimate saltus_estimates_join(const saltus_estimate *estimates, int count);

SALTUS_API_END
#endif
