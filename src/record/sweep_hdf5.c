/* The HDF5 file of a sweep, made in one pass over the results in the order of the file.
 *
 * Rows are written in tiles of whole points, each of which is one chunk of every dataset and is written once;
 * clouds, one after the other, through a buffer of one chunk for each dataset. So the memory needed does not
 * depend on the number of rows, and the bytes of the file depend on its contents alone. Tiles without any
 * result are left out: HDF5 gives the fill values, those of a pending row, for them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/hdf5_disk.h"
#include "record/sweep_output.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { tile_rows = 16384, chunk_bytes = 131072 };

/* A dataset being written. */
typedef struct series {
    const saltus_sweep_column *column;
    hid_t set, memory;
    size_t bytes;          /* of one entry */
    unsigned char *buffer; /* a tile, or a chunk of a cloud */
} series;

/* A cloud being written: the datasets `first` and `count` of the rows, and those whose entries they select.
 */
typedef struct cloud {
    const saltus_sweep_cloud *kind;
    hid_t group;
    series first, count, values[SALTUS_CLOUD_COLUMNS_MAX];
    int width; /* entries that are states: the dimension; otherwise 0 */
    long long total, written, next, chunk;
    long long filled; /* of the chunk's entries */
} cloud;

typedef struct maker {
    saltus_sweep_stream *stream;
    const saltus_sweep *sweep;
    saltus_h5 w;
    saltus_h5_disk disk;
    saltus_message *message;
    hsize_t size[SALTUS_H5_RANK_MAX], tile[SALTUS_H5_RANK_MAX]; /* of rows: pass, axis 2, axis 1, seed */
    hid_t rows;
    series columns[SALTUS_SWEEP_COLUMNS], distinct;
    cloud clouds[SALTUS_CLOUDS];
    bool memory; /* has not run out */
} maker;

/* The length of the equal parts, none longer than `most`, into which `count` is divided. */
static hsize_t part_of(hsize_t count, hsize_t most) {
    hsize_t parts = most ? (count + most - 1) / most : count;
    return (count + parts - 1) / parts;
}

static void choose_tile(maker *m) {
    const saltus_sweep *sweep = m->sweep;
    hsize_t seeds = (hsize_t)saltus_sweep_choices(sweep)->seeds, places = tile_rows / seeds;
    hsize_t count1 = (hsize_t)saltus_sweep_axis(sweep, 0)->count;
    hsize_t count2 = saltus_sweep_axis_count(sweep) > 1 ? (hsize_t)saltus_sweep_axis(sweep, 1)->count : 1;
    hsize_t across = part_of(count1, places), up = across == count1 ? part_of(count2, places / across) : 1;
    const hsize_t size[] = {(hsize_t)saltus_sweep_pass_count(sweep), count2, count1, seeds};
    const hsize_t tile[] = {1, up, across, seeds};
    memcpy(m->size, size, sizeof m->size);
    memcpy(m->tile, tile, sizeof m->tile);
}

/* Open a dataset of the given shape and its buffer of `room` entries. `fill` is one entry. */
static void open_series(maker *m, series *s, const saltus_sweep_column *column, hid_t group,
                        const saltus_h5_shape *shape, size_t width, size_t room, const void *fill) {
    s->column = column;
    s->bytes = saltus_entry_bytes(column->entry) * width;
    s->memory = saltus_entry_type(&m->w, column->entry, false);
    hid_t stored = saltus_entry_type(&m->w, column->entry, true);
    const saltus_h5_column c = {column->name, column->units, column->description, stored, s->memory, fill};
    if (saltus_h5_note(&m->w, stored >= 0 && s->memory >= 0))
        s->set = saltus_h5_open_dataset(&m->w, group, &c, shape);
    saltus_h5_close(stored);
    s->buffer = malloc(room * s->bytes);
    m->memory = m->memory && s->buffer;
}

static void close_series(maker *m, series *s) {
    if (s->set >= 0)
        saltus_h5_note(&m->w, H5Dclose(s->set) >= 0);
    saltus_h5_close(s->memory);
    free(s->buffer);
}

static void write_series(maker *m, const series *s, const hsize_t *first, const hsize_t *count) {
    saltus_h5_write_part(&m->w, s->set, s->memory, first, count, s->buffer);
}

/* A dataset with one entry for each row, or with rank 3 for each place. */
static void open_rows(maker *m, series *s, const saltus_sweep_column *column, hid_t group, int rank,
                      const void *fill) {
    saltus_h5_shape shape = {.rank = rank};
    size_t room = 1;
    memcpy(shape.size, m->size, sizeof shape.size);
    memcpy(shape.part, m->tile, sizeof shape.part);
    for (int k = 0; k < rank; k++)
        room *= (size_t)m->tile[k];
    open_series(m, s, column, group, &shape, 1, room, fill);
}

static void open_columns(maker *m) {
    const saltus_sweep_row pending = saltus_sweep_row_of(SALTUS_PENDING);
    const int none = 0;
    m->rows =
        saltus_h5_open_group(&m->w, "rows", "one entry for each trajectory: [pass][axis2][axis1][seed]");
    for (int k = 0; k < SALTUS_SWEEP_COLUMNS; k++) {
        const saltus_sweep_column *column = &saltus_sweep_columns[k];
        open_rows(m, &m->columns[k], column, m->rows, 4, (const char *)&pending + column->offset);
    }
    open_rows(m, &m->distinct, &saltus_sweep_distinct, m->rows, 3, &none);
}

static void open_cloud(maker *m, cloud *c) {
    static const double nothing = 0;
    const long long none = 0;
    const saltus_sweep_cloud *kind = c->kind;
    size_t entry = kind->stride ? sizeof(double) : (size_t)c->width * sizeof(double);
    c->chunk = (long long)(entry < chunk_bytes ? chunk_bytes / entry : 1);
    c->chunk = c->chunk < c->total ? c->chunk : c->total;
    c->group = saltus_h5_open_group(&m->w, kind->group, kind->description);
    open_rows(m, &c->first, &saltus_sweep_first, c->group, 4, &none);
    open_rows(m, &c->count, &saltus_sweep_count, c->group, 4, &none);
    saltus_h5_shape shape = {.rank = c->width ? 2 : 1,
                             .size = {(hsize_t)c->total, (hsize_t)c->width},
                             .part = {(hsize_t)c->chunk, (hsize_t)c->width}};
    for (int k = 0; k < kind->count && c->total; k++)
        open_series(m, &c->values[k], &kind->columns[k], c->group, &shape, c->width ? (size_t)c->width : 1,
                    (size_t)c->chunk, &nothing);
    for (int k = 0; k < kind->count && !c->total; k++) {
        const saltus_sweep_column *column = &kind->columns[k];
        hid_t stored = saltus_entry_type(&m->w, column->entry, true);
        const saltus_h5_column empty = {column->name, column->units, column->description,
                                        stored,       stored,        NULL};
        saltus_h5_dataset(&m->w, c->group, &empty, 0, (const int[2]){c->width, 0});
        H5Tclose(stored);
    }
}

/* Mark everything as not open yet, so that it can be closed after any failure. */
static void prepare(maker *m) {
    for (int k = 0; k < SALTUS_SWEEP_COLUMNS; k++)
        m->columns[k].set = m->columns[k].memory = -1;
    m->distinct.set = m->distinct.memory = m->rows = -1;
    for (int c = 0; c < SALTUS_CLOUDS; c++) {
        cloud *one = &m->clouds[c];
        one->kind = &saltus_sweep_clouds[c];
        one->width = one->kind->stride ? 0 : saltus_sweep_dimension(m->sweep);
        one->total = m->stream->journal->total[c];
        one->group = one->first.set = one->first.memory = one->count.set = one->count.memory = -1;
        for (int k = 0; k < one->kind->count; k++)
            one->values[k].set = one->values[k].memory = -1;
    }
}

static bool kept(const maker *m, const cloud *c) {
    return (saltus_sweep_choices(m->sweep)->keep & c->kind->keep) != 0;
}

static void close_all(maker *m) {
    for (int k = 0; k < SALTUS_SWEEP_COLUMNS; k++)
        close_series(m, &m->columns[k]);
    close_series(m, &m->distinct);
    saltus_h5_close(m->rows);
    for (int which = 0; which < SALTUS_CLOUDS; which++) {
        cloud *c = &m->clouds[which];
        close_series(m, &c->first);
        close_series(m, &c->count);
        for (int k = 0; k < c->kind->count; k++)
            close_series(m, &c->values[k]);
        saltus_h5_close(c->group);
    }
}

/* Write what has gathered of a cloud. */
static void flush(maker *m, cloud *c) {
    const hsize_t first[] = {(hsize_t)c->written, 0}, count[] = {(hsize_t)c->filled, (hsize_t)c->width};
    for (int k = 0; k < c->kind->count && c->filled; k++)
        write_series(m, &c->values[k], first, count);
    c->written += c->filled;
    c->filled = 0;
}

static void append(maker *m, cloud *c, const unsigned char *entries, long long count) {
    size_t stride = c->kind->stride ? c->kind->stride : (size_t)c->width * sizeof(double);
    for (long long i = 0; i < count; i++) {
        for (int k = 0; k < c->kind->count; k++) {
            const series *s = &c->values[k];
            memcpy(s->buffer + (size_t)c->filled * s->bytes, entries + s->column->offset, s->bytes);
        }
        entries += stride;
        if (++c->filled == c->chunk)
            flush(m, c);
    }
}

/* The clouds of the place that was read; `row` counts the rows of the tile. */
static void put_cloud(maker *m, int which, size_t row, int seeds) {
    cloud *c = &m->clouds[which];
    const long long *counts;
    const unsigned char *entries = saltus_sweep_stream_cloud(m->stream, which, &counts);
    size_t stride = c->kind->stride ? c->kind->stride : (size_t)c->width * sizeof(double);
    for (int s = 0; s < seeds; s++) {
        long long count = counts ? counts[s] : 0, first = count ? c->next : 0;
        memcpy(c->first.buffer + (row + (size_t)s) * sizeof first, &first, sizeof first);
        memcpy(c->count.buffer + (row + (size_t)s) * sizeof count, &count, sizeof count);
        append(m, c, entries, count);
        c->next += count;
        if (count)
            entries += (size_t)count * stride;
    }
}

static void put_place(maker *m, size_t place) {
    int seeds = (int)m->size[3];
    size_t row = place * (size_t)seeds;
    for (int k = 0; k < SALTUS_SWEEP_COLUMNS; k++) {
        const series *c = &m->columns[k];
        for (int s = 0; s < seeds; s++)
            memcpy(c->buffer + (row + (size_t)s) * c->bytes,
                   (const unsigned char *)&m->stream->rows[s] + c->column->offset, c->bytes);
    }
    memcpy(m->distinct.buffer + place * sizeof m->stream->distinct, &m->stream->distinct,
           sizeof m->stream->distinct);
    for (int c = 0; c < SALTUS_CLOUDS; c++)
        if (kept(m, &m->clouds[c]))
            put_cloud(m, c, row, seeds);
}

static void write_tile(maker *m, const hsize_t *first, const hsize_t *count) {
    for (int k = 0; k < SALTUS_SWEEP_COLUMNS; k++)
        write_series(m, &m->columns[k], first, count);
    write_series(m, &m->distinct, first, count);
    for (int c = 0; c < SALTUS_CLOUDS; c++) {
        const cloud *one = &m->clouds[c];
        if (!kept(m, one))
            continue;
        write_series(m, &one->first, first, count);
        write_series(m, &one->count, first, count);
    }
}

/* The tile that begins at pass, row and column `first`: its places follow each other. */
static saltus_status put_tile(maker *m, const hsize_t *first) {
    hsize_t count[SALTUS_H5_RANK_MAX] = {1, 1, 1, m->size[3]};
    for (int k = 1; k < 3; k++)
        count[k] = first[k] + m->tile[k] <= m->size[k] ? m->tile[k] : m->size[k] - first[k];
    long long place = (long long)((first[0] * m->size[1] + first[1]) * m->size[2] + first[2]);
    long long places = (long long)(count[1] * count[2]), there = 0;
    for (long long k = 0; k < places; k++)
        there += m->stream->journal->offset[place + k] != 0;
    saltus_status status = SALTUS_OK;
    for (long long k = 0; k < places && there && status == SALTUS_OK; k++) {
        status = saltus_sweep_stream_read(m->stream, place + k, m->message);
        if (status == SALTUS_OK)
            put_place(m, (size_t)k);
    }
    if (there && status == SALTUS_OK)
        write_tile(m, first, count);
    return status;
}

static saltus_status put_tiles(maker *m) {
    hsize_t first[SALTUS_H5_RANK_MAX] = {0};
    saltus_status status = SALTUS_OK;
    for (first[0] = 0; first[0] < m->size[0]; first[0]++)
        for (first[1] = 0; first[1] < m->size[1]; first[1] += m->tile[1])
            for (first[2] = 0; first[2] < m->size[2]; first[2] += m->tile[2]) {
                if (status == SALTUS_OK && m->w.sound && !m->disk.reason)
                    status = put_tile(m, first);
            }
    for (int c = 0; c < SALTUS_CLOUDS && status == SALTUS_OK; c++)
        if (kept(m, &m->clouds[c]) && m->clouds[c].total)
            flush(m, &m->clouds[c]);
    return status;
}

saltus_status saltus_sweep_put_hdf5(saltus_sweep_stream *stream, const char *temporary, const char *path,
                                    bool durable, saltus_message *message) {
    maker m = {.stream = stream, .sweep = stream->sweep, .message = message, .memory = true};
    saltus_status status = SALTUS_OK;
    saltus_h5_disk_create(&m.w, &m.disk, temporary);
    choose_tile(&m);
    prepare(&m);
    m.memory = saltus_sweep_put_head(&m.w, stream);
    open_columns(&m);
    for (int c = 0; c < SALTUS_CLOUDS; c++)
        if (kept(&m, &m.clouds[c]))
            open_cloud(&m, &m.clouds[c]);
    if (m.w.sound && m.memory)
        status = put_tiles(&m);
    close_all(&m);
    if (status == SALTUS_OK && m.w.sound && m.memory && stream->basins && stream->complete)
        m.memory = saltus_sweep_put_attractors(&m.w, stream);
    saltus_h5_disk_finish(&m.w, &m.disk, durable);
    if (status == SALTUS_OK && (!m.memory || m.disk.reason == ENOMEM))
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for writing %s", path);
    else if (status == SALTUS_OK && m.disk.reason)
        status = saltus_fail(message, SALTUS_IO, "%s could not be written completely: %s", path,
                             strerror(m.disk.reason));
    else if (status == SALTUS_OK && !m.w.sound)
        status = saltus_fail(message, SALTUS_IO, "the HDF5 library could not make %s", path);
    return status;
}
