/* Private: writing a sweep: its identity, its journal, and the files made from it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_SWEEP_OUTPUT_H
#define SALTUS_RECORD_SWEEP_OUTPUT_H

#include "record/fields.h"
#include "record/hdf5.h"

/* sweep_identity.c: everything about a sweep except its results; the lists of axes belong to the sweep. */
saltus_sweep_file saltus_sweep_head(const saltus_sweep *sweep, bool basins, bool complete);
/* Everything that affects the results (not lanes and threads), as lines "name = value" in a fixed order, each
 * preceded by `prefix`. */
void saltus_sweep_identity_put(FILE *file, const saltus_sweep_file *head, const char *prefix);
/* The same as a text, to be freed; NULL if out of memory. */
char *saltus_sweep_identity_text(const saltus_sweep_file *head);
/* SALTUS_BAD_INPUT with a sentence about the first difference if the identity `there`, of the file at `path`,
 * is not `here`, that of the run. */
saltus_status saltus_sweep_identity_compare(const char *path, const char *there, const char *here,
                                            saltus_message *message);

/* sweep_journal.c: results in the order in which they come. The contract stands at the head of that file. */
typedef struct saltus_journal {
    const saltus_sweep *sweep;
    char *path;
    int file;
    bool made;                      /* created by this run */
    long long places, found, end;   /* number of places, results present, length of the file in bytes */
    long long *offset;              /* per place: where its record begins; 0: no result */
    long long total[SALTUS_CLOUDS]; /* entries of each cloud over all results */
    unsigned char *read;            /* the bytes last read back */
    size_t read_room;
    unsigned char *record; /* the record being written */
    size_t record_room;
} saltus_journal;

/* Open and lock the journal at `path`. With `resume` its results are read, and *there tells whether a journal
 * exists; otherwise its contents remain until saltus_journal_begin. Errors: SALTUS_BAD_INPUT (another
 * sweep's, not a journal), SALTUS_IO (in use, cannot be opened), SALTUS_NO_MEMORY; nothing is to be closed
 * then. */
saltus_status saltus_journal_open(saltus_journal *journal, const char *path, const saltus_sweep *sweep,
                                  const char *identity, bool resume, bool *there, saltus_message *message);
/* Start a new journal without results. Errors: SALTUS_IO, SALTUS_NO_MEMORY. */
saltus_status saltus_journal_begin(saltus_journal *journal, const char *identity, saltus_message *message);
/* Append a result. Errors: SALTUS_IO, SALTUS_NO_MEMORY; earlier results remain. */
saltus_status saltus_journal_add(saltus_journal *journal, const saltus_sweep_result *result,
                                 saltus_message *message);
/* Close the journal; with `discard` it is removed. A zeroed one is accepted. */
void saltus_journal_close(saltus_journal *journal, bool discard);

/* The results in the order of the file. */
typedef struct saltus_sweep_stream {
    const saltus_sweep *sweep;
    saltus_journal *journal;
    saltus_basins *basins; /* NULL: not a basins file */
    bool complete;         /* all places are present, so the attractors of basins can be assigned */
    const saltus_origin *origin;
    saltus_sweep_line *lines; /* of the current place, one for each seed; the caller's */
    int distinct;             /* number of distinct attractors at this place */
    saltus_sweep_result result;
} saltus_sweep_stream;

/* Read a place: fills stream->lines and stream->distinct; stream->result has the clouds, or is NULL if the
 * place has no result. Places must be read in increasing order. Errors: SALTUS_IO, SALTUS_NO_MEMORY, those of
 * saltus_basins_sort. In sweep_journal.c. */
saltus_status saltus_sweep_stream_read(saltus_sweep_stream *stream, long long place, saltus_message *message);
/* The counts per seed and the entries of a cloud at the place just read. */
const void *saltus_sweep_stream_cloud(const saltus_sweep_stream *stream, int cloud, const long long **counts);

/* sweep_hdf5.c: write everything into a file; the context is a saltus_sweep_stream. Errors: those of the
 * stream. */
saltus_h5_put saltus_sweep_put_hdf5;

/* sweep_csv.c: write all rows. Errors: those of the stream. */
saltus_status saltus_sweep_put_csv(saltus_sweep_stream *stream, FILE *file, saltus_message *message);

/* The identity of the sweep in a file, to be freed, and whether the file is complete. Errors:
 * SALTUS_BAD_INPUT (no sweep file), SALTUS_NO_MEMORY. In sweep_csv.c and sweep_read.c. */
saltus_status saltus_sweep_identity_csv(const char *path, char **identity, bool *complete,
                                        saltus_message *message);
saltus_status saltus_sweep_identity_hdf5(const char *path, char **identity, bool *complete,
                                         saltus_message *message);

#endif
