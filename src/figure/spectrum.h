/* Private: figures of spectra.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_SPECTRUM_H
#define SALTUS_FIGURE_SPECTRUM_H

#include "figure/caption.h"
#include "record/spectrum.h"
#include "saltus/figure.h"

/* The low frequencies of the first spectrum, which moves, as a panel of another figure: its datablock $low1,
 * and the panel between these parts of the page's width and height with a heading behind the letter ('a' +
 * letter). Tics, labels and objects are automatic or gone when it is done. */
void saltus_spectrum_low_data(const saltus_spectra_source *source, FILE *file);
void saltus_spectrum_low_panel(const saltus_spectra_source *source, FILE *file, const double across[2],
                               const double up[2], int letter, const saltus_line *heading);

#endif
