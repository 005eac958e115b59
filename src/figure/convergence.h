/* Private: convergence of the largest exponent's estimate, as a panel of a figure and as rows of a file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_CONVERGENCE_H
#define SALTUS_FIGURE_CONVERGENCE_H

#include "figure/page.h"

/* The history of an estimate and its final value; owned by the caller. */
typedef struct saltus_course {
    const saltus_lyapunov_progress *history;
    int count;
    double exponent, standard_error;
} saltus_course;

saltus_course saltus_lyapunov_course(const saltus_lyapunov *lyapunov);
/* Write the datablock $convergence: time, exponent, standard error. It must precede the panel in the
 * script. */
void saltus_course_data(const saltus_page *page, const saltus_course *course);
/* Draw the panel in a frame, with its key above the right end; the caller adds a heading. Leaves no gnuplot
 * settings behind for the next panel. */
void saltus_course_panel(const saltus_page *page, const saltus_system *system, const saltus_course *course,
                         saltus_frame frame);

#endif
