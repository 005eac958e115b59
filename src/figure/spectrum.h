/* Private: figures of spectra.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FIGURE_SPECTRUM_H
#define SALTUS_FIGURE_SPECTRUM_H

#include "figure/page.h"
#include "record/spectrum.h"
#include "saltus/figure.h"

/* The low frequencies of the first spectrum, which must not be constant, as a panel of another figure: its
 * datablock $low1, and the panel in a frame with a heading after the letter 'a' + letter. Leaves no gnuplot
 * settings behind for the next panel. */
void saltus_spectrum_low_data(const saltus_spectra_source *source, const saltus_page *page);
void saltus_spectrum_low_panel(const saltus_spectra_source *source, const saltus_page *page,
                               saltus_frame frame, int letter, const saltus_line *heading);

#endif
