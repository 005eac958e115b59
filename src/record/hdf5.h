/* Private: the pieces that HDF5 files are made of, and reading them back.
 *
 * Files are made on disk, as those of sweeps may be larger than the memory, beside their place and under a
 * temporary name: no half-made file is ever seen. HDF5's own driver for files does not survive a full disk:
 * what it could not write it tries to write again when the file is closed, fails, and leaves the library in a
 * state that ends in a crash. Here a failing write is noted, nothing more is written, and HDF5 is not told,
 * so that it can be closed in order. Time stamps are off, so equal results give equal files.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_HDF5_H
#define SALTUS_RECORD_HDF5_H

#include "base/field.h"
#include "saltus/record.h"

#include <hdf5.h>
#include <stdio.h>

/* How HDF5 itself prints errors, which is switched off between saltus_h5_quiet and saltus_h5_restore. */
typedef struct saltus_h5_silence {
    H5E_auto2_t print;
    void *context;
} saltus_h5_silence;

/* False when the library cannot be opened at all. */
bool saltus_h5_quiet(saltus_h5_silence *silence);
void saltus_h5_restore(const saltus_h5_silence *silence);

/* A file being made. After the first failure `sound` is false, and the functions below do nothing more. */
typedef struct saltus_h5 {
    hid_t file;
    bool sound;
    bool starved;   /* it is memory that was lacking */
    int descriptor; /* -1: not open */
    int reason;     /* errno of the first failure to write, otherwise 0 */
    hid_t driver;   /* kept while the file is open; negative: none */
} saltus_h5;

/* Note whether a step was successful; whether all were so far. */
bool saltus_h5_note(saltus_h5 *w, bool good);
/* The same for an allocation. */
bool saltus_h5_note_memory(saltus_h5 *w, bool there);
/* hdf5_disk.c: a new file in place of the contents of the one at `path`, which must exist. */
void saltus_h5_create(saltus_h5 *w, const char *path);
/* Complete the file, add a checksum (the seal) and close it; with `durable` wait until it is on the disk. */
void saltus_h5_finish(saltus_h5 *w, bool durable);
/* What puts the contents into a file; it may fail for reasons of its own. */
typedef saltus_status saltus_h5_put(saltus_h5 *w, void *context, saltus_message *message);
/* Make a file and put it in place of what is at `path`. Errors: those of `put`, SALTUS_IO, SALTUS_NO_MEMORY;
 * what was there stays then. */
saltus_status saltus_h5_write(const char *path, bool durable, saltus_h5_put *put, void *context,
                              saltus_message *message);

/* The type of texts of `room` bytes in a file, or in memory: cut there without a NUL, so that a cut can be
 * seen. To be closed; negative on failure. */
hid_t saltus_h5_text_type(size_t room, bool stored);
void saltus_h5_text(saltus_h5 *w, hid_t owner, const char *name, const char *text);
void saltus_h5_double(saltus_h5 *w, hid_t owner, const char *name, double value);
void saltus_h5_integer(saltus_h5 *w, hid_t owner, const char *name, long long value);
hid_t saltus_h5_open_group(saltus_h5 *w, const char *name, const char *description);
/* Close a group, dataset, type, ...; nothing to do where it is negative, because it could not be opened. */
void saltus_h5_close(hid_t object);
/* What every file of results says of its origin: attributes, and the groups /parameters and
 * /parameters/stop_1, ... with one for each value. */
void saltus_h5_put_head(saltus_h5 *w, const char *kind, const char *scene, const char *title,
                        const saltus_spec *spec, bool complete);

/* origin.c: copy how results came about (NULL: nothing is told); to be cleared, also where memory is lacking:
 * false. */
bool saltus_h5_origin_keep(saltus_origin *kept, const saltus_origin *origin);
void saltus_h5_origin_clear(saltus_origin *kept);
void saltus_h5_put_origin(saltus_h5 *w, const saltus_origin *origin);
/* What the file of an interrupted run at `path` tells takes the place of what was kept; what cannot be read
 * tells nothing. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_h5_origin_take_over(saltus_origin *kept, const char *path, saltus_message *message);
/* An attribute for each option that the results depend on. */
void saltus_h5_options(saltus_h5 *w, hid_t owner, const saltus_option_table *table, const void *record);

enum { SALTUS_H5_SEAL = 24 };
/* The seal of the first `length` bytes of a file: SALTUS_H5_SEAL characters and a NUL. False, with errno,
 * when they cannot be read. */
bool saltus_h5_seal(int descriptor, long long length, char seal[SALTUS_H5_SEAL + 1]);

/* Attributes; false when one is absent, of another type or, as a text, of more than room - 1 bytes. */
bool saltus_h5_get_integer(hid_t owner, const char *name, long long *value);
bool saltus_h5_get_double(hid_t owner, const char *name, double *value);
bool saltus_h5_get_text(hid_t owner, const char *name, char *text, size_t room);

/* Read the attributes of options; the name of the first one that is missing or not admissible, NULL when all
 * are as they should be. */
const char *saltus_h5_get_options(hid_t owner, const saltus_option_table *table, void *record);
/* Open a group for reading; negative when there is none of that name. */
hid_t saltus_h5_find_group(hid_t file, const char *name);

/* A file of results that is being read. The caller sets path, kind and message. */
typedef struct saltus_h5_reader {
    const char *path, *kind; /* "branch" or "sweep", also for messages */
    saltus_message *message;
    hid_t file;
    saltus_h5_silence silence;
} saltus_h5_reader;

/* Open the file, with HDF5's own messages off until it is closed. Errors: SALTUS_BAD_INPUT, SALTUS_IO. */
saltus_status saltus_h5_reader_open(saltus_h5_reader *r);
/* Does nothing when opening failed. */
void saltus_h5_reader_close(saltus_h5_reader *r);
/* Fail with a sentence about the file: SALTUS_BAD_INPUT with what is wrong, or with the object that is
 * missing or wrong; SALTUS_NO_MEMORY. */
saltus_status saltus_h5_refuse(const saltus_h5_reader *r, const char *what);
saltus_status saltus_h5_refuse_part(const saltus_h5_reader *r, const char *group, const char *name);
saltus_status saltus_h5_no_memory(const saltus_h5_reader *r);

/* What is read of it. */
typedef struct saltus_h5_head {
    char kind[32], version[16], scene[128], title[160], model[64];
    bool complete;
    saltus_spec spec;
} saltus_h5_head;

/* Release what it holds: the model of equations; or hand that over with `spec`. */
void saltus_h5_head_clear(saltus_h5_head *head);
/* Read the head of a file of the reader's kind or of `other_kind`; `called` names both in the message that
 * refuses any other. All parameters and stops are there and finite. On success it is to be cleared. Errors:
 * SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_h5_get_head(const saltus_h5_reader *r, const char *other_kind, const char *called,
                                 saltus_h5_head *head);

#endif
