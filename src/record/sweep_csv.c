/* Sweeps as CSV, from a file read back or straight from the journal.
 *
 * The first lines begin with #: the origin of the table, and everything it depends on as `name = value`. Then
 * come a line with the columns' names and one line per row or cloud entry: the axes' values, the pass, the
 * seed from 0, and the contents. Numbers read back exactly; `nan` stands for values that were not recorded or
 * not requested.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "record/output.h"
#include "record/sweep_output.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* `kind`: of the cloud; NULL: the rows. */
static void put_head(const saltus_sweep_file *head, const saltus_cloud_kind *kind, FILE *file) {
    fprintf(file, "# Saltus %s %s%s%s\n# scene: %s\n", head->version, head->basins ? "basins" : "sweep",
            kind ? " " : "", kind ? kind->group : "", head->scene);
    if (head->title[0])
        fprintf(file, "# title: %s\n", head->title);
    saltus_sweep_identity_put(file, head, "# ");
    fprintf(file, "# complete: %d\n", head->complete);
    fputs("# nan: nothing was recorded, or the quantity was not asked for\n"
          "# failed: the flow could not start, or gave up; beyond a stop: the scene's start lies there\n",
          file);
    for (int k = 0; k < head->axis_count; k++)
        fprintf(file, "%s,", head->axes[k].key);
    fputs("pass,seed", file);
}

/* All values of a record, each preceded by a comma. */
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

/* The axes' values, pass and seed at the beginning of a row's line. */
static void put_place(const saltus_sweep_file *head, long long row, FILE *file) {
    long long place = row / head->options.seeds, point = place % head->points;
    for (int k = 0; k < head->axis_count; k++) {
        const saltus_axis *axis = &head->axes[k];
        saltus_put_number(file, saltus_axis_value(axis, (int)(point % axis->count)));
        fputc(',', file);
        point /= axis->count;
    }
    fprintf(file, "%s,%d", saltus_pass_word(head->passes[place / head->points]),
            (int)(row % head->options.seeds));
}

saltus_status saltus_sweep_put_csv(saltus_sweep_stream *stream, FILE *file, saltus_message *message) {
    const saltus_sweep_file head = saltus_sweep_head(stream->sweep, stream->basins, stream->complete);
    saltus_status status = SALTUS_OK;
    put_head(&head, NULL, file);
    put_names(&saltus_line_fields, file);
    fputc('\n', file);
    for (long long row = 0; row < head.row_count && status == SALTUS_OK && !ferror(file); row++) {
        int seed = (int)(row % head.options.seeds);
        if (seed == 0)
            status = saltus_sweep_stream_read(stream, row / head.options.seeds, message);
        if (status != SALTUS_OK)
            break;
        put_place(&head, row, file);
        put_record(&saltus_line_fields, 0, &stream->lines[seed], file);
    }
    return status;
}

saltus_sweep_entries saltus_sweep_entries_of(const saltus_sweep_file *file, int cloud) {
    const saltus_sweep_entries all[SALTUS_CLOUDS] = {
        {file->turning_first, file->turning_count, file->turning},
        {file->impact_first, file->impact_count, file->impacts},
        {file->strobe_first, file->strobe_count, file->strobes}};
    return all[cloud];
}

saltus_status saltus_write_sweep_csv(const char *path, const saltus_sweep_file *file, saltus_table table,
                                     saltus_message *message) {
    const int cloud = (int)table - SALTUS_TABLE_TURNING;
    const saltus_cloud_kind *kind = cloud < 0 ? NULL : &saltus_clouds[cloud];
    saltus_system *system = NULL;
    saltus_output output;
    if (table < SALTUS_TABLE_ROWS || table > SALTUS_TABLE_STROBES)
        return saltus_fail(message, SALTUS_BAD_INPUT, "table %d: there is none of that number", (int)table);
    const saltus_sweep_entries e =
        kind ? saltus_sweep_entries_of(file, cloud) : (saltus_sweep_entries){.count = NULL};
    if (kind && !e.count) {
        char kept[64] = "rows";
        for (int k = 0; k < SALTUS_CLOUDS; k++)
            if (saltus_sweep_entries_of(file, k).count)
                snprintf(kept + strlen(kept), sizeof kept - strlen(kept), ", %s", saltus_clouds[k].group);
        return saltus_fail(message, SALTUS_BAD_INPUT, "the sweep did not keep %s, only %s", kind->group,
                           kept);
    }
    saltus_status status = saltus_output_open(&output, path, message);
    if (status != SALTUS_OK)
        return status;
    FILE *out = output.file;
    put_head(file, kind, out);
    /* The columns of a state are named like its entries. */
    if (kind && !kind->bytes)
        status = saltus_system_new(&file->spec, &system, message);
    else
        put_names(kind ? &kind->fields : &saltus_line_fields, out);
    for (int i = 0; system && i < saltus_system_dimension(system); i++)
        fprintf(out, ",%s", saltus_system_state_name(system, i).text);
    fputc('\n', out);
    for (long long row = 0; row < file->row_count && status == SALTUS_OK && !ferror(out); row++) {
        saltus_sweep_line line = {.row = file->rows[row]};
        if (!kind) {
            saltus_sweep_label(&line.row, line.label);
            put_place(file, row, out);
            put_record(&saltus_line_fields, 0, &line, out);
        }
        const size_t stride = kind && kind->bytes ? kind->bytes : (size_t)file->dimension * sizeof(double);
        for (long long i = 0; kind && i < e.count[row]; i++) {
            put_place(file, row, out);
            put_record(&kind->fields, file->dimension,
                       (const unsigned char *)e.values + (size_t)(e.first[row] + i) * stride, out);
        }
    }
    saltus_system_free(system);
    return saltus_output_close(&output, status, message);
}

/* The lines `# name = value` at the head of a table are its identity. */
saltus_status saltus_sweep_identity_csv(const char *path, char **identity, bool *complete,
                                        saltus_message *message) {
    size_t length = 0, room = 0;
    char *line = NULL;
    *identity = NULL;
    *complete = false;
    const saltus_file_facts facts = saltus_file_identify(path);
    bool sound = strcmp(facts.kind, "sweep table") == 0 || strcmp(facts.kind, "basins table") == 0;
    FILE *file = fopen(path, "rb");
    if (!file)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: cannot be opened (%s)", path, strerror(errno));
    FILE *text = open_memstream(identity, &length);
    while (text && getline(&line, &room, file) > 0 && line[0] == '#') {
        *complete = *complete || strcmp(line, "# complete: 1\n") == 0;
        if (strncmp(line, "# title: ", 9) != 0 && strncmp(line, "# scene: ", 9) != 0 && strstr(line, " = "))
            fputs(line + 2, text);
    }
    free(line);
    sound = !ferror(file) && sound;
    sound = (!text || fclose(text) == 0) && sound;
    fclose(file);
    if (text && sound)
        return SALTUS_OK;
    free(*identity);
    *identity = NULL;
    return text ? saltus_fail(message, SALTUS_BAD_INPUT, "%s: is not the table of a sweep", path)
                : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for reading %s", path);
}
