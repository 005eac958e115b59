/* The HDF5 file of a sweep, made in one pass over the results in the order of the file.
 *
 * Rows are written in tiles of whole grid points; a tile is one chunk of every dataset and is written once.
 * Clouds are written one after the other, through a buffer of one chunk for each dataset. So the memory
 * needed does not depend on the number of rows, and the bytes of the file depend on its contents alone. Tiles
 * without any result are not written: HDF5 returns the fill values, a pending row, for them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/rows.h"
#include "record/sweep_output.h"
#include "sweep/options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { tile_rows = 16384, chunk_bytes = 131072 };

/* The options and axes of the run. */
static void put_head(saltus_h5 *w, const saltus_sweep_stream *stream) {
    const saltus_sweep_file head = saltus_sweep_head(stream->sweep, stream->basins, stream->complete);
    char name[32], description[64];
    if (!w->sound)
        return;
    saltus_h5_put_head(w, head.basins ? "basins" : "sweep", head.scene, head.title, &head.spec,
                       head.complete);
    saltus_h5_put_origin(w, stream->origin);
    hid_t group = saltus_h5_open_group(w, "sweep", "options of the run");
    saltus_h5_options(w, group, &saltus_sweep_table, &head.options);
    saltus_h5_integer(w, group, "dimension", head.dimension);
    saltus_h5_integer(w, group, "axes", head.axis_count);
    for (int k = 0; k < head.axis_count; k++) {
        snprintf(name, sizeof name, "key%d", k + 1);
        saltus_h5_text(w, group, name, head.axes[k].key);
        snprintf(name, sizeof name, "spacing%d", k + 1);
        saltus_h5_text(w, group, name, saltus_word_of(saltus_spacing_words, (int)head.axes[k].spacing));
    }
    saltus_h5_reals(w, group, "initial", "the scene's initial state; empty, and NaN: the system's default",
                    head.initial, head.initial_count);
    saltus_h5_close(group);
    group = saltus_h5_open_group(w, "axes", "what was varied");
    for (int k = 0; k < head.axis_count && w->sound; k++) {
        const saltus_axis *axis = &head.axes[k];
        double *values = malloc((size_t)axis->count * sizeof *values);
        for (int i = 0; i < axis->count && values; i++)
            values[i] = saltus_axis_value(axis, i);
        snprintf(name, sizeof name, "axis%d", k + 1);
        snprintf(description, sizeof description, "values of %s", axis->key);
        if (saltus_h5_note_memory(w, values))
            saltus_h5_reals(w, group, name, description, values, axis->count);
        free(values);
    }
    saltus_h5_close(group);
}

static void put_attractors(saltus_h5 *w, const saltus_sweep_stream *stream) {
    const int n = saltus_sweep_dimension(stream->sweep);
    saltus_rows attractors = {.kind = &saltus_attractor_fields},
                points = {.kind = &saltus_attractor_point_fields, .counts = {[SALTUS_COUNT_DIMENSION] = n}};
    for (int k = 0; k < saltus_basins_count(stream->basins); k++) {
        const saltus_motion *motion = saltus_basins_motion(stream->basins, k);
        const double *states = motion->periods > 0 ? motion->section_states : motion->state;
        const saltus_multiplier *largest = motion->multiplier_count > 0 ? motion->multipliers : NULL;
        saltus_attractor_row row = {.impacts = motion->impacts,
                                    .periods = motion->periods,
                                    .stable = motion->stable,
                                    .first = points.count,
                                    .count = motion->periods > 0 ? motion->periods : 1,
                                    .largest_multiplier = largest ? hypot(largest->re, largest->im) : NAN};
        snprintf(row.label, sizeof row.label, "%s", motion->label);
        saltus_h5_note_memory(w, saltus_rows_add(&attractors, &row));
        for (long long i = 0; i < row.count && w->sound; i++)
            saltus_h5_note_memory(w, saltus_rows_add(&points, states + i * n));
    }
    hid_t group = saltus_h5_open_group(w, "attractors", "attractors of the plane, as first met");
    saltus_h5_rows(w, group, &attractors);
    saltus_h5_rows(w, group, &points);
    saltus_h5_close(group);
    saltus_rows_clear(&attractors);
    saltus_rows_clear(&points);
}

/* A cloud being written: the entry range of each row, and the entries of the next chunk. */
typedef struct cloud {
    const saltus_cloud_kind *kind;
    bool kept;
    saltus_h5_series spans, entries;
    saltus_h5_shape shape; /* of the entries */
    long long next;        /* entry of the next row */
    hsize_t written;
} cloud;

typedef struct maker {
    saltus_sweep_stream *stream;
    const saltus_sweep *sweep;
    saltus_h5 *w;
    saltus_message *message;
    saltus_h5_shape grid; /* of rows and their tiles: pass, axis 2, axis 1, seed */
    saltus_h5_series lines, distinct;
    cloud clouds[SALTUS_CLOUDS];
} maker;

/* Divide `count` into equal parts no longer than `most`; returns their length. */
static hsize_t part_of(hsize_t count, hsize_t most) {
    hsize_t parts = most ? (count + most - 1) / most : count;
    return (count + parts - 1) / parts;
}

/* Datasets with an entry for each row or, with rank 3, for each grid point of a pass. */
static void open_rows(maker *m, hid_t group, const saltus_field_table *kind, int rank, const void *fill,
                      saltus_h5_series *series) {
    saltus_h5_shape shape = m->grid;
    shape.rank = rank;
    series->rows.kind = kind;
    saltus_h5_series_open(m->w, group, &shape, fill, series);
}

static size_t entry_bytes(const maker *m, const cloud *c) {
    return c->kind->bytes ? c->kind->bytes : (size_t)saltus_sweep_dimension(m->sweep) * sizeof(double);
}

/* Write the buffered entries of a cloud. */
static void flush(maker *m, cloud *c) {
    const hsize_t count = (hsize_t)c->entries.rows.count;
    if (count)
        saltus_h5_series_write(m->w, &c->entries, &c->shape, &c->written, &count);
    c->written += count;
}

/* Write the tile that begins at pass, row and column `first`; its places are consecutive. */
static saltus_status put_tile(maker *m, const hsize_t *first) {
    const hsize_t *size = m->grid.size, *tile = m->grid.part;
    const int seeds = (int)size[3];
    hsize_t count[SALTUS_H5_RANK_MAX] = {1, 1, 1, size[3]};
    for (int k = 1; k < 3; k++)
        count[k] = first[k] + tile[k] <= size[k] ? tile[k] : size[k] - first[k];
    long long place = (long long)((first[0] * size[1] + first[1]) * size[2] + first[2]);
    long long places = (long long)(count[1] * count[2]), there = 0;
    for (long long k = 0; k < places; k++)
        there += m->stream->journal->offset[place + k] != 0;
    saltus_status status = SALTUS_OK;
    for (long long k = 0; k < places && there && status == SALTUS_OK && m->w->sound; k++) {
        status = saltus_sweep_stream_read(m->stream, place + k, m->message);
        if (status != SALTUS_OK)
            break;
        for (int s = 0; s < seeds; s++)
            saltus_h5_note_memory(m->w, saltus_rows_add(&m->lines.rows, &m->stream->lines[s]));
        saltus_h5_note_memory(m->w, saltus_rows_add(&m->distinct.rows, &m->stream->distinct));
        for (int which = 0; which < SALTUS_CLOUDS; which++) {
            cloud *c = &m->clouds[which];
            const long long *counts = NULL;
            const unsigned char *entries =
                c->kept ? saltus_sweep_stream_cloud(m->stream, which, &counts) : NULL;
            for (int s = 0; s < seeds && c->kept; s++) {
                const long long number = counts ? counts[s] : 0;
                const saltus_span span = {number ? c->next : 0, number};
                saltus_h5_note_memory(m->w, saltus_rows_add(&c->spans.rows, &span));
                for (long long i = 0; i < number && m->w->sound; i++, entries += entry_bytes(m, c)) {
                    saltus_h5_note_memory(m->w, saltus_rows_add(&c->entries.rows, entries));
                    if ((hsize_t)c->entries.rows.count == c->shape.part[0])
                        flush(m, c);
                }
                c->next += number;
            }
        }
    }
    if (!there || status != SALTUS_OK || !m->w->sound)
        return status;
    saltus_h5_shape by_place = m->grid;
    by_place.rank = 3;
    saltus_h5_series_write(m->w, &m->lines, &m->grid, first, count);
    saltus_h5_series_write(m->w, &m->distinct, &by_place, first, count);
    for (int c = 0; c < SALTUS_CLOUDS; c++)
        if (m->clouds[c].kept)
            saltus_h5_series_write(m->w, &m->clouds[c].spans, &m->grid, first, count);
    return status;
}

/* Create the datasets of all rows and clouds, and choose the tiles. */
static void open_all(maker *m) {
    const saltus_sweep *sweep = m->sweep;
    saltus_sweep_line pending = {.row = saltus_sweep_row_of(SALTUS_PENDING)};
    const int none = 0;
    const hsize_t seeds = (hsize_t)saltus_sweep_choices(sweep)->seeds, places = tile_rows / seeds,
                  count1 = (hsize_t)saltus_sweep_axis(sweep, 0)->count,
                  count2 =
                      saltus_sweep_axis_count(sweep) > 1 ? (hsize_t)saltus_sweep_axis(sweep, 1)->count : 1,
                  across = part_of(count1, places),
                  up = across == count1 ? part_of(count2, places / across) : 1;
    m->grid = (saltus_h5_shape){SALTUS_H5_RANK_MAX,
                                {(hsize_t)saltus_sweep_pass_count(sweep), count2, count1, seeds},
                                {1, up, across, seeds}};
    saltus_sweep_label(&pending.row, pending.label);
    hid_t group =
        saltus_h5_open_group(m->w, "rows", "one entry for each trajectory: [pass][axis2][axis1][seed]");
    open_rows(m, group, &saltus_line_fields, 4, &pending, &m->lines);
    open_rows(m, group, &saltus_distinct_fields, 3, &none, &m->distinct);
    saltus_h5_close(group);
    for (int k = 0; k < SALTUS_CLOUDS; k++) {
        static const double nothing[SALTUS_STATE_MAX] = {0};
        const saltus_span none_yet = {0, 0};
        cloud *c = &m->clouds[k];
        c->kind = &saltus_clouds[k];
        c->kept = (saltus_sweep_choices(sweep)->keep & c->kind->keep) != 0;
        if (!c->kept)
            continue;
        const hsize_t total = (hsize_t)m->stream->journal->total[k],
                      room = chunk_bytes / (c->kind->bytes ? sizeof(double) : entry_bytes(m, c));
        c->shape = (saltus_h5_shape){1, {total}, {room < total ? room : total}};
        group = saltus_h5_open_group(m->w, c->kind->group, c->kind->description);
        open_rows(m, group, &saltus_span_fields, 4, &none_yet, &c->spans);
        c->entries.rows = (saltus_rows){.kind = &c->kind->fields,
                                        .counts = {[SALTUS_COUNT_DIMENSION] = saltus_sweep_dimension(sweep)}};
        saltus_h5_series_open(m->w, group, &c->shape, nothing, &c->entries);
        saltus_h5_close(group);
    }
}

saltus_status saltus_sweep_put_hdf5(saltus_h5 *w, void *stream, saltus_message *message) {
    maker m = {.stream = stream, .w = w, .message = message};
    const hsize_t *size = m.grid.size, *tile = m.grid.part;
    hsize_t first[SALTUS_H5_RANK_MAX] = {0};
    saltus_status status = SALTUS_OK;
    m.sweep = m.stream->sweep;
    put_head(w, m.stream);
    open_all(&m);
    for (first[0] = 0; first[0] < size[0]; first[0]++)
        for (first[1] = 0; first[1] < size[1]; first[1] += tile[1])
            for (first[2] = 0; first[2] < size[2]; first[2] += tile[2]) {
                if (status == SALTUS_OK && w->sound && !w->reason)
                    status = put_tile(&m, first);
            }
    for (int c = 0; c < SALTUS_CLOUDS; c++)
        if (m.clouds[c].kept && status == SALTUS_OK && w->sound)
            flush(&m, &m.clouds[c]);
    saltus_h5_series_close(w, &m.lines);
    saltus_h5_series_close(w, &m.distinct);
    for (int c = 0; c < SALTUS_CLOUDS; c++) {
        saltus_h5_series_close(w, &m.clouds[c].spans);
        saltus_h5_series_close(w, &m.clouds[c].entries);
    }
    if (status == SALTUS_OK && w->sound && m.stream->basins && m.stream->complete)
        put_attractors(w, m.stream);
    return status;
}
