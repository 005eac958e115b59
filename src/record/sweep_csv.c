/* Sweeps as comma-separated values: from a file read back, or straight from the journal.
 *
 * Lines that begin with # come first: where the table is from, and what it depends on as `name = value`. Then
 * a line with the columns' names, then one line per row or cloud point: the axes' values, the pass, the seed
 * from 0, and what the table holds. Numbers read back as the same ones; `nan` stands where nothing was
 * recorded or the quantity was not asked for.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "record/output.h"
#include "record/sweep_output.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What a table is of. */
typedef struct source {
    const char *scene, *title;
    saltus_sweep_identity identity;
    bool complete;
    FILE *file;
} source;

static void put_head(const source *s) {
    fprintf(s->file, "# Saltus %s sweep\n# scene: %s\n", s->identity.version, s->scene);
    if (s->title[0])
        fprintf(s->file, "# title: %s\n", s->title);
    saltus_sweep_identity_put(s->file, &s->identity, "# ");
    fprintf(s->file, "# complete: %d\n", s->complete);
    fputs("# nan: nothing was recorded, or the quantity was not asked for\n", s->file);
    for (int k = 0; k < s->identity.axis_count; k++)
        fprintf(s->file, "%s,", s->identity.axes[k].key);
    fputs("pass,seed", s->file);
}

/* All values of a record, each behind a comma. */
static void put_record(const saltus_field_table *table, int dimension, const void *record, FILE *file) {
    char text[SALTUS_FIELD_TEXT_MAX];
    for (int k = 0; k < table->count; k++) {
        saltus_field entry = table->fields[k];
        int entries = entry.length < 0 ? dimension : 1;
        for (int i = 0; i < entries; i++, entry.offset += saltus_field_bytes(&entry))
            fprintf(file, ",%s", saltus_field_text(&entry, record, text));
    }
    fputc('\n', file);
}

static void put_names(const saltus_field_table *table, FILE *file) {
    for (int k = 0; k < table->count; k++)
        fprintf(file, ",%s", table->fields[k].name);
}

/* The axes' values, pass and seed of a line. */
static void put_place(const source *s, long long point, saltus_pass pass, int seed) {
    for (int k = 0; k < s->identity.axis_count; k++) {
        const saltus_axis *axis = &s->identity.axes[k];
        saltus_put_number(s->file, saltus_axis_value(axis, (int)(point % axis->count)));
        fputc(',', s->file);
        point /= axis->count;
    }
    fprintf(s->file, "%s,%d", saltus_pass_word(pass), seed);
}

saltus_status saltus_sweep_put_csv(saltus_sweep_stream *stream, FILE *file, saltus_message *message) {
    const saltus_sweep *sweep = stream->sweep;
    const saltus_scene *scene = saltus_sweep_scene(sweep);
    saltus_axis axes[SALTUS_AXES_MAX];
    const source s = {.scene = scene->name,
                      .title = scene->title,
                      .identity = saltus_sweep_identity_of(sweep, stream->basins != NULL, axes),
                      .complete = stream->complete,
                      .file = file};
    long long points = saltus_sweep_points(sweep);
    saltus_status status = SALTUS_OK;
    put_head(&s);
    put_names(&saltus_line_fields, file);
    fputc('\n', file);
    for (long long place = 0; place < stream->journal->places && status == SALTUS_OK; place++) {
        status = saltus_sweep_stream_read(stream, place, message);
        saltus_pass pass = saltus_sweep_pass_at(sweep, (int)(place / points));
        for (int seed = 0; seed < s.identity.options->seeds && status == SALTUS_OK && !ferror(file); seed++) {
            put_place(&s, place % points, pass, seed);
            put_record(&saltus_line_fields, 0, &stream->lines[seed], file);
        }
    }
    return status;
}

/* The names of the columns of a cloud; a state's are those of the coordinates. */
static saltus_status put_cloud_names(const source *s, const saltus_cloud_kind *cloud,
                                     saltus_message *message) {
    saltus_system *system = NULL;
    if (cloud->bytes)
        put_names(&cloud->fields, s->file);
    else {
        saltus_status status = saltus_system_new(s->identity.spec, &system, message);
        if (status != SALTUS_OK)
            return status;
        const int count[] = {saltus_system_dof(system), saltus_system_dof(system),
                             saltus_system_extra(system)};
        for (int part = 0; part < 3; part++)
            for (int i = 1; i <= count[part]; i++)
                fprintf(s->file, ",%c%d", "qvz"[part], i);
        saltus_system_free(system);
    }
    fputc('\n', s->file);
    return SALTUS_OK;
}

/* A cloud's entries in memory, and which are a row's. */
typedef struct entries {
    const long long *first, *count;
    const void *values;
} entries;

static entries entries_of(const saltus_sweep_file *file, int cloud) {
    const entries all[SALTUS_CLOUDS] = {{file->turning_first, file->turning_count, file->turning},
                                        {file->impact_first, file->impact_count, file->impacts},
                                        {file->strobe_first, file->strobe_count, file->strobes}};
    return all[cloud];
}

static void put_points(const source *s, const saltus_sweep_file *file, int cloud, long long row) {
    const saltus_cloud_kind *kind = &saltus_clouds[cloud];
    const entries e = entries_of(file, cloud);
    size_t stride = kind->bytes ? kind->bytes : (size_t)file->dimension * sizeof(double);
    int seeds = file->options.seeds;
    long long place = row / seeds;
    for (long long i = 0; i < e.count[row]; i++) {
        const unsigned char *record = (const unsigned char *)e.values + (size_t)(e.first[row] + i) * stride;
        put_place(s, place % file->points, file->passes[place / file->points], (int)(row % seeds));
        put_record(&kind->fields, file->dimension, record, s->file);
    }
}

static saltus_status put_table(const source *s, const saltus_sweep_file *file, saltus_table table,
                               saltus_message *message) {
    int cloud = (int)table - SALTUS_TABLE_TURNING, seeds = file->options.seeds;
    saltus_status status = SALTUS_OK;
    put_head(s);
    if (table != SALTUS_TABLE_ROWS)
        status = put_cloud_names(s, &saltus_clouds[cloud], message);
    else {
        put_names(&saltus_line_fields, s->file);
        fputc('\n', s->file);
    }
    for (long long row = 0; row < file->row_count && status == SALTUS_OK && !ferror(s->file); row++) {
        if (table == SALTUS_TABLE_ROWS) {
            long long place = row / seeds;
            put_place(s, place % file->points, file->passes[place / file->points], (int)(row % seeds));
            saltus_sweep_line line = {.row = file->rows[row]};
            saltus_sweep_label(&line.row, line.label);
            put_record(&saltus_line_fields, 0, &line, s->file);
        } else
            put_points(s, file, cloud, row);
    }
    return status;
}

saltus_status saltus_sweep_file_csv(const saltus_sweep_file *file, saltus_table table, const char *path,
                                    saltus_message *message) {
    saltus_output output;
    if (table < SALTUS_TABLE_ROWS || table > SALTUS_TABLE_STROBES)
        return saltus_fail(message, SALTUS_BAD_INPUT, "table %d: there is none of that number", (int)table);
    if (table != SALTUS_TABLE_ROWS && !entries_of(file, (int)table - SALTUS_TABLE_TURNING).count)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the sweep did not keep %s points or impacts", path,
                           saltus_clouds[(int)table - SALTUS_TABLE_TURNING].group);
    saltus_status status = saltus_output_open(&output, path, message);
    if (status != SALTUS_OK)
        return status;
    const source s = {.scene = file->scene,
                      .title = file->title,
                      .identity = {.version = file->version,
                                   .basins = file->basins,
                                   .spec = &file->spec,
                                   .initial_count = -1,
                                   .axis_count = file->axis_count,
                                   .axes = file->axes,
                                   .options = &file->options},
                      .complete = file->complete,
                      .file = output.file};
    status = put_table(&s, file, table, message);
    return saltus_output_close(&output, status, message);
}

/* Collect the lines `# name = value` before the table. */
static bool collect(FILE *file, FILE *text, bool *ours, bool *complete) {
    char *line = NULL;
    size_t room = 0;
    *ours = *complete = false;
    while (getline(&line, &room, file) > 0 && line[0] == '#') {
        *ours = *ours || strncmp(line, "# Saltus ", 9) == 0;
        *complete = *complete || strcmp(line, "# complete: 1\n") == 0;
        if (strncmp(line, "# title: ", 9) != 0 && strncmp(line, "# scene: ", 9) != 0 && strstr(line, " = "))
            fputs(line + 2, text);
    }
    free(line);
    return !ferror(file);
}

saltus_status saltus_sweep_identity_csv(const char *path, char **identity, bool *complete,
                                        saltus_message *message) {
    size_t length = 0;
    bool ours = false, sound = false;
    *identity = NULL;
    FILE *file = fopen(path, "rb");
    if (!file)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: cannot be opened (%s)", path, strerror(errno));
    FILE *text = open_memstream(identity, &length);
    if (text) {
        sound = collect(file, text, &ours, complete);
        sound = fclose(text) == 0 && sound;
    }
    fclose(file);
    saltus_status status = SALTUS_OK;
    if (!text)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for reading %s", path);
    else if (!sound || !ours)
        status = saltus_fail(message, SALTUS_BAD_INPUT, "%s: is not the table of a sweep", path);
    if (status != SALTUS_OK) {
        free(*identity);
        *identity = NULL;
    }
    return status;
}
