/* Private: output of spectra.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_SPECTRUM_H
#define SALTUS_RECORD_SPECTRUM_H

#include "saltus/record.h"

#include <stddef.h>

/* Spectra with their scene, system and options. */
typedef struct saltus_spectra_source {
    const saltus_scene *scene;
    const saltus_system *system;
    const saltus_motion *motion;
    const saltus_spectra *spectra;
    const saltus_flow_options *flow;
} saltus_spectra_source;

/* "8 orbits of 4 T, 4096 samples a period", "2048 T, Welch with 31 segments of 128 T, ..." */
void saltus_spectra_method(const saltus_spectra *spectra, char *text, size_t room);
/* Comment lines and one row per line or bin, as CSV; failures are left in the file's error flag. All
 * quantities of a motion have their lines and bins in the same places; constant quantities have none. */
void saltus_put_spectra_table(const saltus_spectra_source *source, FILE *file);

#endif
