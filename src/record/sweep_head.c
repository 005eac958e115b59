/* The parts of a sweep's file that say what was run, and the attractors of basins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/rows.h"
#include "record/sweep_output.h"
#include "sweep/options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void put_axis(saltus_h5 *w, hid_t group, const saltus_axis *axis, int k) {
    char name[32], description[64];
    double *values = malloc((size_t)axis->count * sizeof *values);
    for (int i = 0; i < axis->count && values; i++)
        values[i] = saltus_axis_value(axis, i);
    snprintf(name, sizeof name, "axis%d", k + 1);
    snprintf(description, sizeof description, "values of %s", axis->key);
    if (saltus_h5_note_memory(w, values))
        saltus_h5_reals(w, group, name, description, values, axis->count);
    free(values);
}

static void put_options(saltus_h5 *w, const saltus_sweep_file *head) {
    char name[32];
    hid_t group = saltus_h5_open_group(w, "sweep", "options of the run");
    saltus_h5_options(w, group, &saltus_sweep_table, &head->options);
    saltus_h5_integer(w, group, "dimension", head->dimension);
    saltus_h5_integer(w, group, "axes", head->axis_count);
    for (int k = 0; k < head->axis_count; k++) {
        snprintf(name, sizeof name, "key%d", k + 1);
        saltus_h5_text(w, group, name, head->axes[k].key);
        snprintf(name, sizeof name, "spacing%d", k + 1);
        saltus_h5_text(w, group, name, saltus_word_of(saltus_spacing_words, (int)head->axes[k].spacing));
    }
    saltus_h5_reals(w, group, "initial", "the scene's initial state; empty, and NaN: the system's default",
                    head->initial, head->initial_count);
    saltus_h5_close(group);
}

void saltus_sweep_put_head(saltus_h5 *w, const saltus_sweep_stream *stream) {
    const saltus_sweep_file head = saltus_sweep_head(stream->sweep, stream->basins, stream->complete);
    if (!w->sound)
        return;
    saltus_h5_put_head(w, head.basins ? "basins" : "sweep", head.scene, head.title, &head.spec,
                       head.complete);
    saltus_h5_put_origin(w, stream->origin);
    put_options(w, &head);
    hid_t group = saltus_h5_open_group(w, "axes", "what was varied");
    for (int k = 0; k < head.axis_count && w->sound; k++)
        put_axis(w, group, &head.axes[k], k);
    saltus_h5_close(group);
}

void saltus_sweep_put_attractors(saltus_h5 *w, const saltus_sweep_stream *stream) {
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
