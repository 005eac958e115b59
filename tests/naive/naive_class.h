/* What the naive method's trajectories look like on the stroboscopic section: n/p by the same definition as
 * the library's, to a tolerance that fits the method. NOT FOR USE, see naive.h.
 *
 * Steps do not divide the forcing period, so that each impact is noticed up to h too late, by another amount
 * each time: even a periodic motion's points jitter by about J = (1 + r) v h, v being the largest impact
 * speed but at least ten scales in a unit of time, and weakly stable motion amplifies that. Points count as
 * repeated when they agree to 4 J and in any case to a twentieth of the scale, which no figure would show
 * apart, or to a thousandth of it where nothing is hit; beyond a quarter of the scale nothing counts as
 * repeated. Reversals at successive steps count as one impact.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_NAIVE_CLASS_H
#define SALTUS_TESTS_NAIVE_CLASS_H

#include "naive.h"

enum { naive_watched = 60, naive_longest = 20 }; /* periods watched, longest period looked for */

typedef struct naive_class {
    bool finite;       /* false: the numbers grew without bound */
    int periods;       /* p; 0: does not repeat, or not with as many impacts */
    int impacts;       /* n; -1 where many reversals at successive steps stand for a lasting contact */
    bool held;         /* in lasting contact for nine tenths of the steps and more */
    double rate;       /* impacts per period */
    double contact;    /* part of the steps in lasting contact */
    double speed;      /* largest before an impact */
    double deepest;    /* largest penetration, over the whole run */
    double recurrence; /* largest distance of points p periods apart, in units of the scale */
    double points[naive_watched + 1][2]; /* contact coordinate and its velocity at phase 0 */
} naive_class;

/* Run `warm` periods of the pipe's forcing from the given states (naive_lanes of them, one after the other),
 * then watch. `scale` is the displacement that distances are measured in; velocities count a tenth. With
 * `divides` the step is shortened so that a period is a whole number of steps. */
void naive_classify(const naive_pipe *pipe, double h, bool divides, const double *states, int warm,
                    double scale, naive_class classes[naive_lanes]);

#endif
