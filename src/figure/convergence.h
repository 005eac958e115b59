/* Private: how the largest exponent's estimate converged, as a panel of a figure and as rows of a file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_CONVERGENCE_H
#define SALTUS_FIGURE_CONVERGENCE_H

#include "saltus/figure.h"

/* The course of an estimate and where it ended; the caller's. */
typedef struct saltus_course {
    const saltus_lyapunov_progress *history;
    int count;
    double exponent, standard_error;
} saltus_course;

saltus_course saltus_lyapunov_course(const saltus_lyapunov *lyapunov);
/* The datablock $convergence: time, exponent, standard error. It comes before the panel in the script. */
void saltus_course_data(FILE *file, const saltus_course *course);
/* The panel between these parts of the page's width and height, with axes, a key above its right end and no
 * heading of its own. It sets margins, axis labels and ranges; scale, tics, labels, arrows and the key are as
 * before when it is done (tics automatic, the key off). */
void saltus_course_panel(FILE *file, const saltus_system *system, const saltus_course *course,
                         const double across[2], const double up[2]);

#endif
