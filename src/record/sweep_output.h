/* Private: how a sweep is written: what tells sweeps apart, the journal, and the files made from it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_SWEEP_OUTPUT_H
#define SALTUS_RECORD_SWEEP_OUTPUT_H

#include "record/fields.h"
#include "record/hdf5.h"

/* sweep_identity.c: what is told of a sweep beside its results; lists of axes are the sweep's. */
saltus_sweep_file saltus_sweep_head(const saltus_sweep *sweep, bool basins, bool complete);
/* Everything that the results depend on, which lanes and threads are not, as lines "name = value", always in
 * the same order, each after `prefix`. */
void saltus_sweep_identity_put(FILE *file, const saltus_sweep_file *head, const char *prefix);
/* The same as a text, to be freed; NULL when there is no memory. */
char *saltus_sweep_identity_text(const saltus_sweep_file *head);
/* SALTUS_BAD_INPUT with a sentence about the first difference when the text in the file at `path` is not that
 * of the run. */
saltus_status saltus_sweep_identity_compare(const char *path, const char *there, const char *here,
                                            saltus_message *message);

/* sweep_journal.c: results as they come. The contract stands at the head of that file. */
typedef struct saltus_journal {
    const saltus_sweep *sweep;
    char *path;
    int file;
    bool made;                      /* by this run */
    long long places, found, end;   /* of all, of those there, and of the file in bytes */
    long long *offset;              /* per place: where its record begins; 0: not there */
    long long total[SALTUS_CLOUDS]; /* entries of the clouds of the places there */
    unsigned char *window;          /* the part of the file that is in memory */
    long long window_begin, window_end;
    size_t window_room;
    long long ahead;       /* bytes read at once */
    unsigned char *record; /* one to be written */
    size_t record_room;
} saltus_journal;

/* Open and lock the journal at `path`. With `resume` the results in it are taken up, and *there tells whether
 * there was any journal; otherwise its contents stand until saltus_journal_begin. Errors: SALTUS_BAD_INPUT
 * (another sweep's, not a journal), SALTUS_IO (in use, cannot be opened), SALTUS_NO_MEMORY; nothing is to be
 * closed then. */
saltus_status saltus_journal_open(saltus_journal *journal, const char *path, const saltus_sweep *sweep,
                                  const char *identity, bool resume, bool *there, saltus_message *message);
/* Begin anew, without any result. Errors: SALTUS_IO, SALTUS_NO_MEMORY. */
saltus_status saltus_journal_begin(saltus_journal *journal, const char *identity, saltus_message *message);
/* Append a result. Errors: SALTUS_IO, SALTUS_NO_MEMORY; what was there before stays. */
saltus_status saltus_journal_add(saltus_journal *journal, const saltus_sweep_result *result,
                                 saltus_message *message);
/* Read the result of a place that is there; it lasts until the next call. Errors: SALTUS_IO,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_journal_get(saltus_journal *journal, long long place, saltus_sweep_result *result,
                                 saltus_message *message);
/* Close the journal; with `discard` it is removed. A zeroed one is accepted. */
void saltus_journal_close(saltus_journal *journal, bool discard);

/* The results in the order of the file. */
typedef struct saltus_sweep_stream {
    const saltus_sweep *sweep;
    saltus_journal *journal;
    saltus_basins *basins; /* NULL: not of basins */
    bool complete;         /* all places are there: basins are told apart */
    const saltus_origin *origin;
    saltus_sweep_line *lines; /* of one place */
    int distinct;             /* attractors met at this place */
    saltus_sweep_result result;
} saltus_sweep_stream;

bool saltus_sweep_stream_open(saltus_sweep_stream *stream);
void saltus_sweep_stream_close(saltus_sweep_stream *stream);
/* stream->lines and stream->distinct become those of a place; in stream->result its clouds, or NULL where it
 * is not there. Places must be asked for in order. Errors: SALTUS_IO, SALTUS_NO_MEMORY, those of
 * saltus_basins_sort. */
saltus_status saltus_sweep_stream_read(saltus_sweep_stream *stream, long long place, saltus_message *message);
/* The counts per seed and the entries of a cloud of the place that was read. */
const void *saltus_sweep_stream_cloud(const saltus_sweep_stream *stream, int cloud, const long long **counts);

/* sweep_hdf5.c: put everything into a file; `stream` is a saltus_sweep_stream. Errors: those of the stream.
 */
saltus_h5_put saltus_sweep_put_hdf5;

/* sweep_csv.c: write all rows. Errors: those of the stream. */
saltus_status saltus_sweep_put_csv(saltus_sweep_stream *stream, FILE *file, saltus_message *message);

/* What tells the sweep in a file apart, as text to be freed, and whether it is complete. Errors:
 * SALTUS_BAD_INPUT (no sweep file), SALTUS_NO_MEMORY. sweep_csv.c, sweep_read.c */
saltus_status saltus_sweep_identity_csv(const char *path, char **identity, bool *complete,
                                        saltus_message *message);
saltus_status saltus_sweep_identity_hdf5(const char *path, char **identity, bool *complete,
                                         saltus_message *message);

#endif
