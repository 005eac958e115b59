/* Averages along a trajectory with an honest standard error.
 *
 * Successive values of a chaotic motion are correlated, those of a regular one repeat: neither is a random
 * sample. Values are gathered in batches, whose number stays between half the room and the room. The variance
 * of the mean is the spectrum at frequency zero of an autoregression fitted to the batches (Heidelberger &
 * Welch, Commun. ACM 24 (1981) 233-245). Where values only oscillate, so that their sum stays bounded, the
 * error falls like 1/n and not like 1/sqrt(n): half the largest excursion of the partial sums takes over.
 * There a weighted mean does better still (Das, Saiki, Sander & Yorke, Nonlinearity 30 (2017) 4111-4140): it
 * is used where it agrees with itself on parts of the run.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_AVERAGE_H
#define SALTUS_AVERAGE_H

#include "saltus/status.h"

#include <stdbool.h>

SALTUS_API_BEGIN

enum { SALTUS_AVERAGE_BATCHES = 1024 };

/* Values under way. A zeroed one is empty. */
typedef struct saltus_average {
    long long count;        /* values in all */
    long long size;         /* values per batch; 0: empty */
    int batches;            /* complete ones */
    long long open;         /* values in the batch under way, ... */
    double partial;         /* ... and their sum */
    double origin, squares; /* first value; sum of the squared distances from it */
    double sum[SALTUS_AVERAGE_BATCHES];
} saltus_average;

typedef struct saltus_estimate {
    double mean;
    double standard_error; /* INFINITY: too few values to tell (fewer than 16) */
    double independent;    /* number of independent values of this variance that would give this error; 0: too
                              few values, or only a part of the run */
    long long count;       /* values used, in complete batches */
    bool regular;          /* the values' sums stay bounded about their trend */
    bool weighted;         /* the mean is the weighted one */
} saltus_estimate;

void saltus_average_add(saltus_average *average, double value);
/* Over all values. */
saltus_estimate saltus_average_estimate(const saltus_average *average);
/* The same with the plain mean in any case, or with the weighted one (from 128 values on): sums over several
 * averages of the same run are exact sums when all have the same kind of mean. */
saltus_estimate saltus_average_plain(const saltus_average *average);
saltus_estimate saltus_average_weighted(const saltus_average *average);
/* Over a part of the run, 0 <= from < to <= 1, in whole batches. */
saltus_estimate saltus_average_part(const saltus_average *average, double from, double to);
/* Several runs of the same length together: errors of random values are independent, those of regular ones
 * are bounds and do not average out. */
saltus_estimate saltus_estimates_join(const saltus_estimate *estimates, int count);

SALTUS_API_END
#endif
