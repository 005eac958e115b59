/* Tables of rows as groups of datasets: writing them in order, and reading them without trusting their
 * contents.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Bytes of one row of a field. */
static size_t row_bytes(const saltus_field *field, const int *counts) {
    int length[2];
    return saltus_field_bytes(field) * saltus_field_shape(field, counts, length);
}

bool saltus_rows_add(saltus_rows *rows, const void *record) {
    enum { first_room = 64 };
    const saltus_field *fields = rows->kind->fields;
    if (rows->count == rows->room) {
        long long room = rows->room ? 2 * rows->room : first_room;
        for (int k = 0; k < rows->kind->count; k++) {
            size_t bytes = row_bytes(&fields[k], rows->counts);
            void *grown = realloc((void *)rows->column[k], (size_t)room * bytes + 1);
            if (!grown)
                return false;
            rows->column[k] = grown;
        }
        rows->room = room;
    }
    for (int k = 0; k < rows->kind->count; k++) {
        size_t bytes = row_bytes(&fields[k], rows->counts);
        saltus_field_pack(&fields[k], rows->counts, record,
                          (unsigned char *)rows->column[k] + (size_t)rows->count * bytes);
    }
    rows->count++;
    return true;
}

void saltus_rows_clear(saltus_rows *rows) {
    for (int k = 0; k < SALTUS_FIELDS_MAX; k++) {
        free((void *)rows->column[k]);
        rows->column[k] = NULL;
    }
    rows->count = rows->room = 0;
}

static hid_t enumeration(const saltus_word *words, hid_t base) {
    hid_t type = H5Tenum_create(base);
    bool sound = type >= 0;
    for (; words->word && sound; words++) {
        signed char narrow = (signed char)words->value;
        sound = H5Tenum_insert(type, words->word,
                               H5Tget_size(base) == 1 ? (const void *)&narrow : &words->value) >= 0;
    }
    if (sound)
        return type;
    saltus_h5_close(type);
    return -1;
}

/* Type of a field's entries in memory or, if `stored`, in the file; to be closed. */
static hid_t entry_type(const saltus_field *field, bool stored) {
    static const saltus_word flags[] = {{"FALSE", 0}, {"TRUE", 1}, {NULL, 0}};
    switch (field->type) {
    case SALTUS_REAL:
        return H5Tcopy(stored ? H5T_IEEE_F64LE : H5T_NATIVE_DOUBLE);
    case SALTUS_INT:
        return H5Tcopy(stored ? H5T_STD_I32LE : H5T_NATIVE_INT);
    case SALTUS_LONG:
        return H5Tcopy(stored ? H5T_STD_I64LE : H5T_NATIVE_LLONG);
    case SALTUS_FLAG:
        return enumeration(flags, H5T_NATIVE_SCHAR);
    case SALTUS_CHOICE:
        return enumeration(field->words, H5T_NATIVE_INT);
    case SALTUS_TEXT:
        return saltus_h5_text_type((size_t)field->length, stored);
    default:
        return -1;
    }
}

/* The shape of a field's dataset: dimensions of the rows, then those of an entry. */
static saltus_h5_shape column_shape(const saltus_field *field, const int *counts,
                                    const saltus_h5_shape *rows) {
    saltus_h5_shape shape = *rows;
    int length[2];
    saltus_field_shape(field, counts, length);
    for (int k = 0; k < 2 && length[k] && shape.rank < SALTUS_H5_RANK_MAX; k++) {
        shape.size[shape.rank] = shape.part[shape.rank] = (hsize_t)length[k];
        shape.rank++;
    }
    return shape;
}

hid_t saltus_h5_storage(saltus_h5 *w, const saltus_h5_shape *shape, hid_t memory, const void *fill) {
    enum { level = 6 };
    hid_t list = H5Pcreate(H5P_DATASET_CREATE);
    bool sound = list >= 0 && H5Pset_obj_track_times(list, 0) >= 0;
    if (sound && shape->size[0]) {
        sound = H5Pset_chunk(list, shape->rank, shape->part) >= 0 && H5Pset_shuffle(list) >= 0;
        if (sound && H5Zfilter_avail(H5Z_FILTER_DEFLATE) > 0)
            sound = H5Pset_deflate(list, level) >= 0;
        sound = sound && H5Pset_fletcher32(list) >= 0;
        sound = sound && (!fill || H5Pset_fill_value(list, memory, fill) >= 0);
    }
    saltus_h5_note(w, sound);
    return list;
}

/* Create the dataset of a field; other programs may append to it if it is `extensible`. Negative on
 * failure. */
static hid_t open_column(saltus_h5 *w, hid_t group, const saltus_field *field, const saltus_h5_shape *shape,
                         bool extensible, const void *fill) {
    hid_t stored = entry_type(field, true), memory = entry_type(field, false), set = -1;
    hid_t list = saltus_h5_storage(w, shape, memory, fill);
    hsize_t most[SALTUS_H5_RANK_MAX];
    memcpy(most, shape->size, sizeof most);
    if (shape->size[0] && extensible)
        most[0] = H5S_UNLIMITED;
    hid_t space = H5Screate_simple(shape->rank, shape->size, most);
    /* Each chunk is written once and completely, so HDF5 need not cache any. */
    hid_t access = H5Pcreate(H5P_DATASET_ACCESS);
    if (saltus_h5_note(w, stored >= 0 && memory >= 0 && space >= 0 && access >= 0 &&
                              H5Pset_chunk_cache(access, 1, 0, 1) >= 0))
        set = H5Dcreate2(group, field->name, stored, space, H5P_DEFAULT, list, access);
    if (saltus_h5_note(w, set >= 0)) {
        saltus_h5_text(w, set, "units", field->unit);
        saltus_h5_text(w, set, "description", field->meaning);
    }
    saltus_h5_close(access);
    saltus_h5_close(space);
    saltus_h5_close(list);
    saltus_h5_close(stored);
    saltus_h5_close(memory);
    return set;
}

/* Write a block that begins at `first` with `count` entries along each dimension; NULL: everything. */
static void write_column(saltus_h5 *w, hid_t set, const saltus_field *field, int rank, const hsize_t *first,
                         const hsize_t *count, const void *data) {
    hid_t memory = entry_type(field, false), place = first ? H5Dget_space(set) : H5S_ALL;
    hid_t here = first ? H5Screate_simple(rank, count, NULL) : H5S_ALL;
    bool chosen = memory >= 0 && place >= 0 && here >= 0 &&
                  (!first || H5Sselect_hyperslab(place, H5S_SELECT_SET, first, NULL, count, NULL) >= 0);
    saltus_h5_note(w, chosen && H5Dwrite(set, memory, here, place, H5P_DEFAULT, data) >= 0);
    if (first) {
        saltus_h5_close(here);
        saltus_h5_close(place);
    }
    saltus_h5_close(memory);
}

void saltus_h5_rows(saltus_h5 *w, hid_t group, const saltus_rows *rows) {
    enum { chunk_bytes = 131072 }; /* approximate */
    for (int k = 0; k < rows->kind->count && w->sound; k++) {
        const saltus_field *field = &rows->kind->fields[k];
        size_t bytes = row_bytes(field, rows->counts);
        if (!bytes)
            continue;
        const hsize_t count = (hsize_t)rows->count, tall = bytes < chunk_bytes ? chunk_bytes / bytes : 1;
        const saltus_h5_shape all = {1, {count}, {tall < count ? tall : count}};
        const saltus_h5_shape shape = column_shape(field, rows->counts, &all);
        hid_t set = open_column(w, group, field, &shape, true, NULL);
        if (w->sound && rows->count)
            write_column(w, set, field, shape.rank, NULL, NULL, rows->column[k]);
        saltus_h5_close(set);
    }
}

void saltus_h5_reals(saltus_h5 *w, hid_t group, const char *name, const char *description,
                     const double *values, int count) {
    const saltus_field field = {.name = name, .unit = "1", .meaning = description, .type = SALTUS_REAL};
    const saltus_field_table kind = {&field, 1};
    const saltus_rows rows = {.kind = &kind, .count = count, .column = {values}};
    saltus_h5_rows(w, group, &rows);
}

void saltus_h5_series_open(saltus_h5 *w, hid_t group, const saltus_h5_shape *shape, const void *fill,
                           saltus_h5_series *series) {
    saltus_rows *rows = &series->rows;
    for (int k = 0; k < rows->kind->count; k++)
        series->set[k] = -1;
    /* Convert the values of `fill` to the fields' storage. */
    if (!saltus_h5_note_memory(w, saltus_rows_add(rows, fill)))
        return;
    for (int k = 0; k < rows->kind->count && w->sound; k++) {
        const saltus_field *field = &rows->kind->fields[k];
        const saltus_h5_shape own = column_shape(field, rows->counts, shape);
        series->set[k] = open_column(w, group, field, &own, false, rows->column[k]);
    }
    rows->count = 0;
}

void saltus_h5_series_write(saltus_h5 *w, saltus_h5_series *series, const saltus_h5_shape *shape,
                            const hsize_t *first, const hsize_t *count) {
    const saltus_rows *rows = &series->rows;
    for (int k = 0; k < rows->kind->count && w->sound; k++) {
        const saltus_field *field = &rows->kind->fields[k];
        const saltus_h5_shape own = column_shape(field, rows->counts, shape);
        hsize_t begin[SALTUS_H5_RANK_MAX] = {0}, extent[SALTUS_H5_RANK_MAX];
        memcpy(extent, own.size, sizeof extent);
        memcpy(begin, first, (size_t)shape->rank * sizeof *first);
        memcpy(extent, count, (size_t)shape->rank * sizeof *count);
        write_column(w, series->set[k], field, own.rank, begin, extent, rows->column[k]);
    }
    series->rows.count = 0;
}

void saltus_h5_series_close(saltus_h5 *w, saltus_h5_series *series) {
    for (int k = 0; series->rows.kind && k < series->rows.kind->count; k++)
        if (series->set[k] >= 0)
            saltus_h5_note(w, H5Dclose(series->set[k]) >= 0);
    saltus_rows_clear(&series->rows);
    series->rows.kind = NULL;
}

/* Open the dataset of a field and get its extent; negative if none can be read. */
static hid_t find_column(const saltus_h5_reader *r, const char *group, const char *name,
                         saltus_h5_shape *shape) {
    char path[96];
    snprintf(path, sizeof path, "%s/%s", group, name);
    hid_t set = H5Lexists(r->file, group, H5P_DEFAULT) > 0 && H5Lexists(r->file, path, H5P_DEFAULT) > 0
                    ? H5Dopen2(r->file, path, H5P_DEFAULT)
                    : -1;
    hid_t space = set >= 0 ? H5Dget_space(set) : -1;
    shape->rank = space >= 0 ? H5Sget_simple_extent_ndims(space) : 0;
    if (shape->rank >= 1 && shape->rank <= SALTUS_H5_RANK_MAX &&
        H5Sget_simple_extent_dims(space, shape->size, NULL) == shape->rank) {
        saltus_h5_close(space);
        return set;
    }
    saltus_h5_close(space);
    saltus_h5_close(set);
    return -1;
}

static bool same_extent(const saltus_h5_shape *a, const saltus_h5_shape *b) {
    return a->rank == b->rank && memcmp(a->size, b->size, (size_t)a->rank * sizeof *a->size) == 0;
}

/* Whether a dataset of this size may occupy only `stored` bytes: deflate shrinks by a factor of at most about
 * a thousand. */
static bool is_believable(const saltus_h5_shape *shape, hsize_t stored) {
    const hsize_t most_entries = (hsize_t)1 << 40;
    hsize_t entries = 1;
    for (int k = 0; k < shape->rank; k++) {
        if (shape->size[k] && entries > most_entries / shape->size[k])
            return false;
        entries *= shape->size[k];
    }
    return entries / 1024 <= stored;
}

saltus_status saltus_h5_find_rows(const saltus_h5_reader *r, const char *group,
                                  const saltus_field_table *kind, const int *counts, long long most,
                                  bool sparse, saltus_h5_shape *shape) {
    for (int k = 0; k < kind->count; k++) {
        saltus_h5_shape there;
        if (!row_bytes(&kind->fields[k], counts))
            continue;
        hid_t set = find_column(r, group, kind->fields[k].name, &there);
        if (!shape->rank && set >= 0 && there.size[0] <= (hsize_t)most)
            *shape = (saltus_h5_shape){1, {there.size[0]}, {0}};
        saltus_h5_shape wanted = column_shape(&kind->fields[k], counts, shape);
        bool fits = set >= 0 && shape->rank && same_extent(&there, &wanted) &&
                    (sparse || is_believable(&there, H5Dget_storage_size(set)));
        saltus_h5_close(set);
        if (!fits)
            return saltus_h5_refuse_part(r, group, kind->fields[k].name);
    }
    return SALTUS_OK;
}

/* Whether `count` values are valid for the field; flags are normalised to 0 or 1. */
static bool is_sound(const saltus_field *field, unsigned char *data, size_t count) {
    size_t bytes = saltus_field_bytes(field);
    for (size_t k = 0; k < count; k++, data += bytes) {
        int choice = 0;
        if (field->type == SALTUS_FLAG)
            *data = *data != 0;
        if (field->type == SALTUS_CHOICE)
            memcpy(&choice, data, sizeof choice);
        if ((field->type == SALTUS_CHOICE && !saltus_word_of(field->words, choice)) ||
            (field->type == SALTUS_TEXT && !memchr(data, 0, bytes)))
            return false;
    }
    return true;
}

saltus_status saltus_h5_get_rows(const saltus_h5_reader *r, const char *group, const saltus_field_table *kind,
                                 const int *counts, const saltus_h5_shape *shape, void *records,
                                 size_t stride) {
    size_t rows = 1, widest = 0;
    for (int k = 0; k < shape->rank; k++)
        rows *= (size_t)shape->size[k];
    for (int k = 0; k < kind->count; k++) {
        size_t bytes = row_bytes(&kind->fields[k], counts);
        widest = bytes > widest ? bytes : widest;
    }
    unsigned char *data = calloc(rows + 1, widest);
    if (!data)
        return saltus_h5_no_memory(r);
    saltus_status status = SALTUS_OK;
    for (int k = 0; k < kind->count && status == SALTUS_OK; k++) {
        const saltus_field *field = &kind->fields[k];
        const saltus_h5_shape wanted = column_shape(field, counts, shape);
        const size_t bytes = row_bytes(field, counts);
        saltus_h5_shape there;
        if (!bytes)
            continue;
        hid_t set = find_column(r, group, field->name, &there), memory = entry_type(field, false);
        hid_t type = set >= 0 && memory >= 0 && same_extent(&there, &wanted) ? H5Dget_type(set) : -1;
        bool fits = type >= 0 && H5Tget_class(type) == H5Tget_class(memory) &&
                    (field->type != SALTUS_TEXT || H5Tis_variable_str(type) == 0);
        fits = fits && (rows == 0 || H5Dread(set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0);
        saltus_h5_close(type);
        saltus_h5_close(memory);
        saltus_h5_close(set);
        if (!fits || !is_sound(field, data, rows * bytes / saltus_field_bytes(field)))
            status = saltus_h5_refuse_part(r, group, field->name);
        for (size_t i = 0; i < rows && status == SALTUS_OK; i++)
            saltus_field_unpack(field, counts, data + i * bytes, (unsigned char *)records + i * stride);
    }
    free(data);
    return status;
}

saltus_status saltus_h5_get_all(const saltus_h5_reader *r, const char *group, const saltus_field_table *kind,
                                const int *counts, long long most, size_t stride, void **records,
                                long long *count) {
    saltus_h5_shape shape = {.rank = 0};
    saltus_status status = saltus_h5_find_rows(r, group, kind, counts, most, false, &shape);
    *records = NULL;
    if (status != SALTUS_OK)
        return status;
    *count = (long long)shape.size[0];
    *records = calloc((size_t)*count + 1, stride);
    return *records ? saltus_h5_get_rows(r, group, kind, counts, &shape, *records, stride)
                    : saltus_h5_no_memory(r);
}

saltus_status saltus_h5_get_reals(const saltus_h5_reader *r, const char *group, const char *name, int most,
                                  bool finite, int *count, double **values) {
    const saltus_field field = {.name = name, .type = SALTUS_REAL};
    const saltus_field_table kind = {&field, 1};
    long long length = 0;
    void *records;
    saltus_status status = saltus_h5_get_all(r, group, &kind, NULL, most, sizeof **values, &records, &length);
    *values = records;
    *count = (int)length;
    for (int i = 0; i < *count && status == SALTUS_OK; i++)
        if (finite && !isfinite((*values)[i]))
            status = saltus_h5_refuse_part(r, group, name);
    return status;
}
