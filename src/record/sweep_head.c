/* The parts of a sweep's file that say what was run, and the attractors of basins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "record/sweep_output.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* False, as below, when there is no memory. */
static bool put_axis(saltus_h5 *w, hid_t group, const saltus_axis *axis, int k) {
    char name[32], description[64];
    double *values = malloc((size_t)axis->count * sizeof *values);
    for (int i = 0; i < axis->count && values; i++)
        values[i] = saltus_axis_value(axis, i);
    snprintf(name, sizeof name, "axis%d", k + 1);
    snprintf(description, sizeof description, "values of %s", axis->key);
    if (values)
        saltus_h5_reals(w, group, name, description, values, axis->count);
    free(values);
    return values != NULL;
}

static void put_options(saltus_h5 *w, const saltus_sweep *sweep) {
    const saltus_sweep_options *o = saltus_sweep_choices(sweep);
    const saltus_scene *scene = saltus_sweep_scene(sweep);
    char words[SALTUS_WORDS_MAX], name[32];
    hid_t group = saltus_h5_open_group(w, "sweep", "options of the run");
    saltus_h5_text(w, group, "keep", saltus_words_join(saltus_keep_words, o->keep, words));
    saltus_h5_text(w, group, "passes", saltus_words_join(saltus_pass_words, o->passes, words));
    saltus_h5_integer(w, group, "seeds", o->seeds);
    saltus_h5_integer(w, group, "seed", (long long)o->seed);
    saltus_h5_integer(w, group, "adaptive", o->adaptive);
    saltus_h5_integer(w, group, "transient", o->transient);
    saltus_h5_integer(w, group, "record", o->record);
    saltus_h5_integer(w, group, "measure", o->measure);
    saltus_h5_integer(w, group, "longest", o->longest);
    saltus_h5_double(w, group, "rtol", o->flow.rtol);
    saltus_h5_double(w, group, "atol", o->flow.atol);
    saltus_h5_text(w, group, "integrator", saltus_integrator_word(o->flow.integrator));
    saltus_h5_integer(w, group, "order", o->flow.order);
    saltus_h5_integer(w, group, "dimension", saltus_sweep_dimension(sweep));
    saltus_h5_integer(w, group, "axes", saltus_sweep_axis_count(sweep));
    for (int k = 0; k < saltus_sweep_axis_count(sweep); k++) {
        snprintf(name, sizeof name, "key%d", k + 1);
        saltus_h5_text(w, group, name, saltus_sweep_axis(sweep, k)->key);
        snprintf(name, sizeof name, "spacing%d", k + 1);
        saltus_h5_text(w, group, name, saltus_spacing_words[saltus_sweep_axis(sweep, k)->spacing]);
    }
    saltus_h5_reals(w, group, "initial", "the scene's initial state; empty: the system's default",
                    scene->initial, scene->initial_count);
    saltus_h5_close(group);
}

bool saltus_sweep_put_head(saltus_h5 *w, const saltus_sweep_stream *stream) {
    const saltus_scene *scene = saltus_sweep_scene(stream->sweep);
    bool memory = true;
    if (!w->sound)
        return true;
    saltus_h5_text(w, w->file, "kind", stream->basins ? "basins" : "sweep");
    saltus_h5_text(w, w->file, "version", SALTUS_VERSION);
    saltus_h5_text(w, w->file, "scene", scene->name);
    saltus_h5_text(w, w->file, "title", scene->title);
    saltus_h5_text(w, w->file, "model", saltus_model_name(scene->spec.model));
    saltus_h5_integer(w, w->file, "complete", stream->complete);
    saltus_h5_parameters(w, &scene->spec);
    put_options(w, stream->sweep);
    hid_t group = saltus_h5_open_group(w, "axes", "what was varied");
    for (int k = 0; k < saltus_sweep_axis_count(stream->sweep) && w->sound; k++)
        memory = put_axis(w, group, saltus_sweep_axis(stream->sweep, k), k) && memory;
    saltus_h5_close(group);
    return memory;
}

/* The points of an attractor at phase 0: those of its orbit, or the one where it rests. */
static long long points_of(const saltus_motion *motion) {
    return motion->periods > 0 ? motion->periods : 1;
}

static bool put_labels(saltus_h5 *w, const saltus_basins *basins, hid_t group, int count) {
    enum { room = sizeof((saltus_motion *)0)->label };
    char *labels = calloc((size_t)count + 1, room);
    hid_t type = H5Tcopy(H5T_C_S1);
    saltus_h5_note(w, type >= 0 && H5Tset_size(type, room) >= 0 && H5Tset_cset(type, H5T_CSET_UTF8) >= 0);
    for (int k = 0; k < count && labels; k++)
        snprintf(labels + (size_t)k * room, room, "%s", saltus_basins_motion(basins, k)->label);
    const saltus_h5_column column = {"label", "1", "name of the motion, n/p", type, type, labels};
    if (labels)
        saltus_h5_dataset(w, group, &column, count, (const int[2]){0, 0});
    saltus_h5_close(type);
    free(labels);
    return labels != NULL;
}

/* One column of /attractors after the other. */
static bool put_attractor_columns(saltus_h5 *w, const saltus_basins *basins, hid_t group, int count) {
    enum { words = SALTUS_ATTRACTOR_COLUMNS - 1 };
    long long *table = calloc((size_t)count * words + 1, sizeof *table), first = 0;
    double *largest = calloc((size_t)count + 1, sizeof *largest);
    for (int k = 0; k < count && table && largest; k++) {
        const saltus_motion *motion = saltus_basins_motion(basins, k);
        const long long value[words] = {motion->impacts, motion->periods, motion->stable, first,
                                        points_of(motion)};
        for (int i = 0; i < words; i++)
            table[i * count + k] = value[i];
        first += points_of(motion);
        largest[k] =
            motion->multiplier_count > 0 ? hypot(motion->multipliers[0].re, motion->multipliers[0].im) : NAN;
    }
    for (int i = 0; i < SALTUS_ATTRACTOR_COLUMNS && table && largest; i++) {
        const saltus_sweep_column *c = &saltus_attractor_columns[i];
        hid_t stored = saltus_entry_type(w, c->entry, true);
        hid_t memory = saltus_entry_type(w, c->entry, false);
        const void *data = i < words ? (const void *)(table + i * count) : largest;
        const saltus_h5_column column = {c->name, c->units, c->description, stored, memory, data};
        saltus_h5_dataset(w, group, &column, count, (const int[2]){0, 0});
        H5Tclose(stored);
        H5Tclose(memory);
    }
    bool memory = table && largest;
    free(table);
    free(largest);
    return memory;
}

bool saltus_sweep_put_attractors(saltus_h5 *w, const saltus_sweep_stream *stream) {
    const saltus_basins *basins = stream->basins;
    int count = saltus_basins_count(basins), n = saltus_sweep_dimension(stream->sweep);
    long long points = 0;
    hid_t group = saltus_h5_open_group(w, "attractors", "attractors of the plane, as first met");
    bool memory = put_labels(w, basins, group, count) && put_attractor_columns(w, basins, group, count);
    for (int k = 0; k < count; k++)
        points += points_of(saltus_basins_motion(basins, k));
    double *states = calloc((size_t)(points * n) + 1, sizeof *states), *to = states;
    for (int k = 0; k < count && states; k++) {
        const saltus_motion *motion = saltus_basins_motion(basins, k);
        size_t length = (size_t)(points_of(motion) * n);
        memcpy(to, motion->periods > 0 ? motion->section_states : motion->state, length * sizeof *to);
        to += length;
    }
    const saltus_h5_column column = {
        "state",           "1",   "q, q', further states of the orbits' points at phase 0", H5T_IEEE_F64LE,
        H5T_NATIVE_DOUBLE, states};
    if (states)
        saltus_h5_dataset(w, group, &column, points, (const int[2]){n, 0});
    free(states);
    saltus_h5_close(group);
    return memory && states;
}
