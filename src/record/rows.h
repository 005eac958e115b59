/* Private: tables of rows in HDF5 files. A table is a group with one dataset per field; it is written at once
 * or part by part, and read back.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_ROWS_H
#define SALTUS_RECORD_ROWS_H

#include "record/hdf5.h"

enum { SALTUS_FIELDS_MAX = 40, SALTUS_COUNTS_MAX = 4, SALTUS_H5_RANK_MAX = 4 };

/* Rows of one kind, stored column by column. */
typedef struct saltus_rows {
    const saltus_field_table *kind;
    int counts[SALTUS_COUNTS_MAX]; /* the counts that the fields' lengths refer to */
    long long count, room;
    const void *column[SALTUS_FIELDS_MAX];
} saltus_rows;

/* Append a row; false if out of memory. */
bool saltus_rows_add(saltus_rows *rows, const void *record);
void saltus_rows_clear(saltus_rows *rows);

/* Dimensions of a grid of rows, and of the chunks in which it is stored and written. */
typedef struct saltus_h5_shape {
    int rank;
    hsize_t size[SALTUS_H5_RANK_MAX], part[SALTUS_H5_RANK_MAX];
} saltus_h5_shape;

/* Creation properties of a dataset, to be closed. `fill` (of the type `memory`) is the value of parts that
 * are not written; NULL: zeros. Empty datasets are stored without chunks. */
hid_t saltus_h5_storage(saltus_h5 *w, const saltus_h5_shape *shape, hid_t memory, const void *fill);

/* Write all rows as datasets of a group, in chunks with checksums, shuffled and deflated, with the attributes
 * `units` and `description`. Fields without entries get no dataset. */
void saltus_h5_rows(saltus_h5 *w, hid_t group, const saltus_rows *rows);
/* A dataset of real numbers without a unit. */
void saltus_h5_reals(saltus_h5 *w, hid_t group, const char *name, const char *description,
                     const double *values, int count);

/* Datasets that are written part by part, each part once. */
typedef struct saltus_h5_series {
    saltus_rows rows; /* of the next part */
    hid_t set[SALTUS_FIELDS_MAX];
} saltus_h5_series;

/* Create the datasets. series->rows has its kind and counts set and no rows; `fill` is a record with the
 * values of parts that are never written. To be closed even after a failure. */
void saltus_h5_series_open(saltus_h5 *w, hid_t group, const saltus_h5_shape *shape, const void *fill,
                           saltus_h5_series *series);
/* Write the rows as the part that begins at `first` with `count` rows along each dimension, and remove
 * them. */
void saltus_h5_series_write(saltus_h5 *w, saltus_h5_series *series, const saltus_h5_shape *shape,
                            const hsize_t *first, const hsize_t *count);
void saltus_h5_series_close(saltus_h5 *w, saltus_h5_series *series);

/* Get and check the dimensions of the rows in a file before memory is allocated. With shape->rank set the
 * extent must be shape->size; with rank 0 the rows are a list of at most `most`, whose size is returned in
 * shape. All columns must exist with the same extent, and their stored size must be plausible; `sparse`:
 * parts may be missing. Errors: SALTUS_BAD_INPUT. */
saltus_status saltus_h5_find_rows(const saltus_h5_reader *r, const char *group,
                                  const saltus_field_table *kind, const int *counts, long long most,
                                  bool sparse, saltus_h5_shape *shape);
/* Read the rows into records `stride` bytes apart. Checks that texts end with a NUL and choices have a valid
 * value. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_h5_get_rows(const saltus_h5_reader *r, const char *group, const saltus_field_table *kind,
                                 const int *counts, const saltus_h5_shape *shape, void *records,
                                 size_t stride);
/* Find and read all rows of a group, at most `most`; *records is to be freed, also after a failure. */
saltus_status saltus_h5_get_all(const saltus_h5_reader *r, const char *group, const saltus_field_table *kind,
                                const int *counts, long long most, size_t stride, void **records,
                                long long *count);
/* Read a dataset of at most `most` numbers, which must be finite if `finite` says so; *values is to be freed,
 * also after a failure. */
saltus_status saltus_h5_get_reals(const saltus_h5_reader *r, const char *group, const char *name, int most,
                                  bool finite, int *count, double **values);

#endif
