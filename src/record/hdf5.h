/* Private: the building blocks of HDF5 files, and reading them back.
 *
 * Files are made on disk, because sweeps may exceed the memory, and replace their target when complete
 * (saltus_output), so nobody sees a partial file. HDF5's own file driver does not survive a full disk: it
 * retries failed writes when the file is closed, fails, and leaves the library in a state that ends in a
 * crash. The driver here instead notes a failed write, stops writing and does not tell HDF5, so that HDF5
 * closes normally. Time stamps are off, so equal results give equal files.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_HDF5_H
#define SALTUS_RECORD_HDF5_H

#include "base/field.h"
#include "saltus/record.h"

#include <hdf5.h>
#include <stdio.h>

/* HDF5's own error printing, switched off between saltus_h5_quiet and saltus_h5_restore. */
typedef struct saltus_h5_silence {
    H5E_auto2_t print;
    void *context;
} saltus_h5_silence;

/* False if the library cannot be initialised. */
bool saltus_h5_quiet(saltus_h5_silence *silence);
void saltus_h5_restore(const saltus_h5_silence *silence);

/* A file being made. After the first failure `sound` is false and the functions below do nothing. */
typedef struct saltus_h5 {
    hid_t file;
    bool sound;
    bool starved;   /* the failure was a lack of memory */
    int descriptor; /* -1: not open */
    int reason;     /* errno of the first failed write, otherwise 0 */
    hid_t driver;   /* kept while the file is open; negative: none */
} saltus_h5;

/* Record whether a step succeeded; returns whether all steps so far did. */
bool saltus_h5_note(saltus_h5 *w, bool good);
/* The same for an allocation. */
bool saltus_h5_note_memory(saltus_h5 *w, bool there);
/* hdf5_disk.c: create a file in place of the existing one at `path`. */
void saltus_h5_create(saltus_h5 *w, const char *path);
/* Complete the file, append a checksum (the seal) and close it; `durable` waits until it is on the disk. */
void saltus_h5_finish(saltus_h5 *w, bool durable);
/* Callback that writes the contents of a file; it may fail for reasons of its own. */
typedef saltus_status saltus_h5_put(saltus_h5 *w, void *context, saltus_message *message);
/* Make a file and replace the one at `path` by it. Errors: those of `put`, SALTUS_IO, SALTUS_NO_MEMORY; the
 * old file then remains. */
saltus_status saltus_h5_write(const char *path, bool durable, saltus_h5_put *put, void *context,
                              saltus_message *message);

/* The type of texts of `room` bytes, in a file (`stored`) or in memory. A text of full length has no NUL, so
 * that a cut text can be recognised. To be closed; negative on failure. */
hid_t saltus_h5_text_type(size_t room, bool stored);
void saltus_h5_text(saltus_h5 *w, hid_t owner, const char *name, const char *text);
void saltus_h5_double(saltus_h5 *w, hid_t owner, const char *name, double value);
void saltus_h5_integer(saltus_h5 *w, hid_t owner, const char *name, long long value);
/* The attribute `names` of a dataset: the names of its columns, with commas between them. */
void saltus_h5_names(saltus_h5 *w, hid_t group, const char *set, const char *names);
hid_t saltus_h5_open_group(saltus_h5 *w, const char *name, const char *description);
/* Close a group, dataset, type, ...; does nothing for a negative handle, which stands for a failed open. */
void saltus_h5_close(hid_t object);
/* The head of every file of results: attributes, and the groups /parameters and /parameters/stop_1, ... with
 * one attribute for each value. */
void saltus_h5_put_head(saltus_h5 *w, const char *kind, const char *scene, const char *title,
                        const saltus_spec *spec, bool complete);

/* origin.c: copy an origin (NULL: an empty one). False if out of memory; to be cleared in any case. */
bool saltus_h5_origin_keep(saltus_origin *kept, const saltus_origin *origin);
void saltus_h5_origin_clear(saltus_origin *kept);
void saltus_h5_put_origin(saltus_h5 *w, const saltus_origin *origin);
/* Replace the kept origin by that in the file of an interrupted run at `path`, if it can be read. Errors:
 * SALTUS_NO_MEMORY. */
saltus_status saltus_h5_origin_take_over(saltus_origin *kept, const char *path, saltus_message *message);
/* Write an attribute for each option that affects the results. */
void saltus_h5_options(saltus_h5 *w, hid_t owner, const saltus_option_table *table, const void *record);

enum { SALTUS_H5_SEAL = 24 };
/* The seal of the first `length` bytes of a file: SALTUS_H5_SEAL characters and a NUL. False, with errno, if
 * they cannot be read. */
bool saltus_h5_seal(int descriptor, long long length, char seal[SALTUS_H5_SEAL + 1]);

/* Read attributes; false if one is absent, of another type or, as a text, longer than room - 1 bytes. */
bool saltus_h5_get_integer(hid_t owner, const char *name, long long *value);
bool saltus_h5_get_double(hid_t owner, const char *name, double *value);
bool saltus_h5_get_text(hid_t owner, const char *name, char *text, size_t room);

/* Read the attributes of options. Returns the name of the first missing or inadmissible one; NULL if all are
 * valid. */
const char *saltus_h5_get_options(hid_t owner, const saltus_option_table *table, void *record);
/* Open a group for reading; negative if it does not exist. */
hid_t saltus_h5_find_group(hid_t file, const char *name);
/* Whether a branch file holds a curve of special points in two parameters. In identify.c. */
bool saltus_h5_is_locus(hid_t file);

/* A file of results being read. The caller sets path, kind and message. */
typedef struct saltus_h5_reader {
    const char *path, *kind; /* "branch" or "sweep", also for messages */
    saltus_message *message;
    hid_t file;
    saltus_h5_silence silence;
} saltus_h5_reader;

/* Open the file and silence HDF5's own messages until it is closed. Errors: SALTUS_BAD_INPUT, SALTUS_IO. */
saltus_status saltus_h5_reader_open(saltus_h5_reader *r);
/* Does nothing when opening failed. */
void saltus_h5_reader_close(saltus_h5_reader *r);
/* Fail with a sentence about the file: SALTUS_BAD_INPUT, with the fault or the object that is missing or
 * wrong; SALTUS_NO_MEMORY. */
saltus_status saltus_h5_refuse(const saltus_h5_reader *r, const char *what);
saltus_status saltus_h5_refuse_part(const saltus_h5_reader *r, const char *group, const char *name);
saltus_status saltus_h5_no_memory(const saltus_h5_reader *r);

/* The head of a file. */
typedef struct saltus_h5_head {
    char kind[32], version[16], scene[128], title[160], model[64];
    bool complete;
    saltus_spec spec;
} saltus_h5_head;

/* Release the model of equations, unless `spec` was handed on with it. */
void saltus_h5_head_clear(saltus_h5_head *head);
/* Read the head of a file of the reader's kind or of `other_kind`; `called` names both in the message that
 * refuses other files. On success all parameters and stops are present and finite; to be cleared. Errors:
 * SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_h5_get_head(const saltus_h5_reader *r, const char *other_kind, const char *called,
                                 saltus_h5_head *head);

#endif
