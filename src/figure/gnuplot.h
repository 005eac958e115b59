/* Running gnuplot.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_GNUPLOT_H
#define SALTUS_FIGURE_GNUPLOT_H

#include "saltus/status.h"

#include <stdio.h>

/* The terminal that draws files with the ending of `path` (.png, .pdf, .svg), as the operand of `set
 * terminal`; NULL for another ending. */
const char *saltus_gnuplot_terminal(const char *path);

/* An empty script. Errors: SALTUS_IO. */
saltus_status saltus_gnuplot_open(FILE **script, saltus_message *message);
/* The look that all figures share: borders, tics, a grid of the colour given as six hexadecimal digits. */
void saltus_put_style(FILE *script, const char *grid);
/* Place the panel between these parts of the page's width and height. */
void saltus_put_margins(FILE *script, const double across[2], const double up[2]);
/* Run gnuplot on a script (read from its beginning) that draws to standard output, write what it draws to
 * `path`, completely or not at all, and close the script. The user's own start-up files are not read. Errors:
 * SALTUS_IO with gnuplot's complaint. */
saltus_status saltus_gnuplot_draw(FILE *script, const char *path, saltus_message *message);

/* The numbers that an axis goes over. */
typedef struct saltus_range {
    double low, high;
} saltus_range;

/* Widen a range to hold a value, or by a part of its width; an empty range gets a width from `scale`. */
void saltus_range_add(saltus_range *range, double value);
void saltus_range_pad(saltus_range *range, double part, double scale);

#endif
