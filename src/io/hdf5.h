/* Private: the pieces that HDF5 files are made of, and reading them back.
 *
 * Files are made in memory by HDF5's core driver and then written as one piece, so a full disk is an ordinary
 * write error and no half-made file is ever seen. Time stamps are off, so equal results give equal files.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_IO_HDF5_H
#define SALTUS_IO_HDF5_H

#include "saltus/system.h"

#include <hdf5.h>
#include <stdio.h>

/* HDF5's own way of printing errors, silenced between quiet and restore. */
typedef struct saltus_h5_silence {
    H5E_auto2_t print;
    void *context;
} saltus_h5_silence;

/* False when the library cannot be opened at all. */
bool saltus_h5_quiet(saltus_h5_silence *silence);
void saltus_h5_restore(const saltus_h5_silence *silence);

/* A file under way. After the first failure nothing more is tried. */
typedef struct saltus_h5 {
    hid_t file;
    bool sound;
} saltus_h5;

bool saltus_h5_note(saltus_h5 *w, bool good);
/* A new file in memory. */
void saltus_h5_create(saltus_h5 *w);
/* Write the finished file, followed by a seal by which damage is noticed, and let go of it. Failures to write
 * are left in the stream's error flag. */
void saltus_h5_finish(saltus_h5 *w, FILE *file);

void saltus_h5_text(saltus_h5 *w, hid_t owner, const char *name, const char *text);
void saltus_h5_double(saltus_h5 *w, hid_t owner, const char *name, double value);
void saltus_h5_integer(saltus_h5 *w, hid_t owner, const char *name, long long value);
hid_t saltus_h5_open_group(saltus_h5 *w, const char *name, const char *description);
void saltus_h5_close_group(hid_t group);
/* The groups /parameters and /parameters/stop_1, ... with an attribute for each value. */
void saltus_h5_parameters(saltus_h5 *w, const saltus_spec *spec);

/* What a dataset is called and means. */
typedef struct saltus_h5_column {
    const char *name, *units, *description;
    hid_t type, memory;
    const void *data;
} saltus_h5_column;

/* A dataset of `rows` entries, each of them a number, a row of width[0] or a matrix of width[0] x width[1];
 * unused widths are 0. Extensible, in chunks, shuffled, deflated and with checksums. */
void saltus_h5_dataset(saltus_h5 *w, hid_t group, const saltus_h5_column *c, long long rows,
                       const int width[2]);
/* An enumeration of `count` words with the values 0, 1, ... or the given ones; to be closed. */
hid_t saltus_h5_enumeration(saltus_h5 *w, hid_t base, const char *const *words, const int *values, int count);

/* Open a file for reading; negative after a sentence in the message. */
hid_t saltus_h5_read_file(const char *path, saltus_message *message);
/* Attributes; false when one is absent or of another type. */
bool saltus_h5_get_double(hid_t owner, const char *name, double *value);
bool saltus_h5_get_integer(hid_t owner, const char *name, long long *value);
bool saltus_h5_get_text(hid_t owner, const char *name, char *text, size_t room);
/* Number of entries of a dataset; -1 when there is none of that name. */
long long saltus_h5_rows(hid_t file, const char *name);
/* Read a dataset of known size, as written by saltus_h5_dataset; false when it differs. */
bool saltus_h5_get_dataset(hid_t file, const char *name, hid_t memory, long long rows, const int width[2],
                           void *data);

#endif
