/* Private: the forms of spectra.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_IO_SPECTRUM_H
#define SALTUS_IO_SPECTRUM_H

#include "io/caption.h"
#include "saltus/io.h"

#include <stddef.h>

/* Spectra with what explains them. */
typedef struct saltus_spectra_source {
    const saltus_scene *scene;
    const saltus_system *system;
    const saltus_motion *motion;
    const saltus_spectra *spectra;
    const saltus_flow_options *flow;
} saltus_spectra_source;

/* "8 orbits of 4 T, 4096 samples a period", "2048 T, Welch with 31 segments of 128 T, ..." */
void saltus_spectra_method(const saltus_spectra *spectra, char *text, size_t room);
/* gnuplot's script. */
void saltus_spectra_script(const saltus_spectra_source *source, const char *path, FILE *file);
/* The low frequencies of the first spectrum, which moves, as a panel of another figure: its datablock $low1,
 * and the panel between these parts of the page's width and height with a heading behind the letter ('a' +
 * letter). Tics, labels and objects are automatic or gone when it is done. */
void saltus_spectrum_low_data(const saltus_spectra_source *source, FILE *file);
void saltus_spectrum_low_panel(const saltus_spectra_source *source, FILE *file, const double across[2],
                               const double up[2], int letter, const saltus_line *heading);

#endif
