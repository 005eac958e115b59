/* Private: how the largest exponent's estimate converged, as a panel of a figure and as rows of a file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_CONVERGENCE_H
#define SALTUS_FIGURE_CONVERGENCE_H

#include "figure/page.h"

/* The course of an estimate and where it ended; the caller's. */
typedef struct saltus_course {
    const saltus_lyapunov_progress *history;
    int count;
    double exponent, standard_error;
} saltus_course;

saltus_course saltus_lyapunov_course(const saltus_lyapunov *lyapunov);
/* The datablock $convergence: time, exponent, standard error. It comes before the panel in the script. */
void saltus_course_data(const saltus_page *page, const saltus_course *course);
/* The panel in a frame, with a key above its right end; a heading is the caller's label. Nothing of it stays
 * for the next panel. */
void saltus_course_panel(const saltus_page *page, const saltus_system *system, const saltus_course *course,
                         saltus_frame frame);

#endif
