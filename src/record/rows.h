/* Private: tables of rows in HDF5 files: a group with one dataset for each field, written at once or part by
 * part, and read back.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_ROWS_H
#define SALTUS_RECORD_ROWS_H

#include "record/hdf5.h"

enum { SALTUS_FIELDS_MAX = 40, SALTUS_COUNTS_MAX = 3, SALTUS_H5_RANK_MAX = 4 };

/* Rows of one kind, kept column by column. */
typedef struct saltus_rows {
    const saltus_field_table *kind;
    int counts[SALTUS_COUNTS_MAX]; /* that the fields' lengths refer to */
    long long count, room;
    const void *column[SALTUS_FIELDS_MAX];
} saltus_rows;

/* Append a row; false when there is no memory. */
bool saltus_rows_add(saltus_rows *rows, const void *record);
void saltus_rows_clear(saltus_rows *rows);

/* The grid that rows are arranged in, and the parts in which it is stored and written. */
typedef struct saltus_h5_shape {
    int rank;
    hsize_t size[SALTUS_H5_RANK_MAX], part[SALTUS_H5_RANK_MAX];
} saltus_h5_shape;

/* How a dataset of a shape is stored, as creation properties to be closed; `fill` (of the type in `memory`)
 * is what parts that are not written hold, NULL: zeros. Empty ones are stored plainly. */
hid_t saltus_h5_storage(saltus_h5 *w, const saltus_h5_shape *shape, hid_t memory, const void *fill);

/* Write all rows as datasets of a group, in chunks with checksums, shuffled and deflated, with the attributes
 * `units` and `description`. A field without entries has no dataset. */
void saltus_h5_rows(saltus_h5 *w, hid_t group, const saltus_rows *rows);
/* A dataset of plain real numbers without a unit. */
void saltus_h5_reals(saltus_h5 *w, hid_t group, const char *name, const char *description,
                     const double *values, int count);

/* Datasets that are written part by part, each part once. */
typedef struct saltus_h5_series {
    saltus_rows rows; /* of the next part */
    hid_t set[SALTUS_FIELDS_MAX];
} saltus_h5_series;

/* Create the datasets. series->rows has its kind and counts, and no rows; `fill` is a record with the values
 * of parts that are never written. To be closed whether it could be opened or not. */
void saltus_h5_series_open(saltus_h5 *w, hid_t group, const saltus_h5_shape *shape, const void *fill,
                           saltus_h5_series *series);
/* Write the rows to the part that begins at `first`, `count` of them along each dimension, and forget them.
 */
void saltus_h5_series_write(saltus_h5 *w, saltus_h5_series *series, const saltus_h5_shape *shape,
                            const hsize_t *first, const hsize_t *count);
void saltus_h5_series_close(saltus_h5 *w, saltus_h5_series *series);

/* Rows in a file, before there is memory for them: how many entries each dimension has. With shape->rank set
 * the extent must be shape->size; with rank 0 they are one after the other, at most `most`, and shape becomes
 * theirs. Every column must be there, of one extent, and no larger than what is stored of it may hold;
 * `sparse`: parts may be missing. Errors: SALTUS_BAD_INPUT. */
saltus_status saltus_h5_find_rows(const saltus_h5_reader *r, const char *group,
                                  const saltus_field_table *kind, const int *counts, long long most,
                                  bool sparse, saltus_h5_shape *shape);
/* Read them into records `stride` bytes apart. Texts have their NUL, choices one of their values. Errors:
 * SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_h5_get_rows(const saltus_h5_reader *r, const char *group, const saltus_field_table *kind,
                                 const int *counts, const saltus_h5_shape *shape, void *records,
                                 size_t stride);
/* Find and read all rows of a group that tells their number itself, at most `most`; *records is to be freed,
 * also after a failure. */
saltus_status saltus_h5_get_all(const saltus_h5_reader *r, const char *group, const saltus_field_table *kind,
                                const int *counts, long long most, size_t stride, void **records,
                                long long *count);
/* Read a dataset of numbers, at most `most`, all finite where `finite` says so; *values is to be freed, also
 * after a failure. */
saltus_status saltus_h5_get_reals(const saltus_h5_reader *r, const char *group, const char *name, int most,
                                  bool finite, int *count, double **values);

#endif
