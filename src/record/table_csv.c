/* Tables of branches and trajectories as CSV: a group of an HDF5 file, written by its table of fields.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "record/fields.h"
#include "record/output.h"
#include "record/rows.h"

#include <stdlib.h>
#include <string.h>

static const struct {
    const char *kind, *name, *group;
    const saltus_field_table *fields;
} tables[] = {{"branch", "points", "points", &saltus_point_fields},
              {"branch", "events", "events", &saltus_event_fields},
              {"trajectory", "samples", "trajectory", &saltus_sample_fields},
              {"trajectory", "events", "events", &saltus_trajectory_event_fields},
              {"trajectory", "strobe", "strobe", &saltus_strobe_fields}};
enum { table_count = sizeof tables / sizeof tables[0] };

/* Rows in memory, row by row. */
typedef struct rows {
    saltus_field fields[SALTUS_FIELDS_MAX];
    saltus_field_table kind;
    int counts[SALTUS_COUNTS_MAX];
    size_t stride;
    long long count;
    unsigned char *records;
    saltus_system *system; /* the system of the rows */
} rows;

static saltus_status read_rows(const saltus_h5_reader *r, int which, const saltus_spec *spec, rows *to) {
    const size_t align = sizeof(double);
    const saltus_field_table *kind = tables[which].fields;
    saltus_status status = saltus_system_new(spec, &to->system, r->message);
    if (status != SALTUS_OK)
        return status;
    to->counts[SALTUS_COUNT_DIMENSION] = saltus_system_dimension(to->system);
    to->counts[SALTUS_COUNT_STOPS] = spec->stop_count;
    saltus_model_parameters(spec->model, &to->counts[SALTUS_COUNT_PARAMETERS]);
    /* The same fields, but located in a contiguous row. */
    for (int k = 0; k < kind->count; k++) {
        int length[2];
        saltus_field *f = &to->fields[k];
        *f = kind->fields[k];
        f->offset = to->stride;
        f->indirect = false;
        f->inner = f->stride = 0;
        to->stride +=
            (saltus_field_shape(f, to->counts, length) * saltus_field_bytes(f) + align - 1) / align * align;
    }
    to->kind = (saltus_field_table){to->fields, kind->count};
    void *records;
    status = saltus_h5_get_all(r, tables[which].group, &to->kind, to->counts, 1000000000, to->stride,
                               &records, &to->count);
    to->records = records;
    return status;
}

/* The column name of an entry: the member's name, with the numbers of row and column if it has several;
 * entries of parameters and states use the model's names. */
static void put_name(FILE *file, const saltus_field *f, const int *counts, int i,
                     const saltus_system *system) {
    const saltus_spec *spec = saltus_system_spec(system);
    int length[2], parameters;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &parameters);
    saltus_field_shape(f, counts, length);
    if (f->length == -1 - SALTUS_COUNT_PARAMETERS)
        fputs(p[i].name, file);
    else if (strncmp(f->name, "state", 5) == 0 && f->length == -1 - SALTUS_COUNT_DIMENSION &&
             saltus_model_text(spec->model))
        fputs(saltus_system_state_name(system, i).text, file);
    else if (length[1])
        fprintf(file, "%s%d_%d", f->name, i / length[1] + 1, i % length[1] + 1);
    else if (length[0] && f->type != SALTUS_TEXT)
        fprintf(file, "%s%d", f->name, i + 1);
    else
        fputs(f->name, file);
}

/* A line of names (`record` NULL) or of values. */
static void put_line(FILE *file, const rows *t, const unsigned char *record) {
    char text[SALTUS_FIELD_TEXT_MAX];
    const char *comma = "";
    for (int k = 0; k < t->kind.count; k++) {
        saltus_field entry = t->fields[k];
        int length[2], entries = (int)saltus_field_shape(&entry, t->counts, length);
        if (entry.type == SALTUS_TEXT)
            entries = 1;
        else
            entry.length = entry.width = 0;
        for (int i = 0; i < entries; i++, entry.offset += saltus_field_bytes(&entry), comma = ",") {
            fputs(comma, file);
            if (!record)
                put_name(file, &t->fields[k], t->counts, i, t->system);
            else if (entry.type == SALTUS_TEXT) {
                fputc('"', file);
                for (const char *c = (const char *)record + entry.offset; *c; c++)
                    fputs(*c == '"' ? "\"\"" : (const char[2]){*c, '\0'}, file);
                fputc('"', file);
            } else
                fputs(saltus_field_text(&entry, record, text), file);
        }
    }
    fputc('\n', file);
}

saltus_status saltus_write_csv(const char *to, const char *path, const char *name, saltus_message *message) {
    saltus_h5_reader r = {.path = path, .kind = "branch", .message = message};
    saltus_h5_head head = {.complete = false};
    rows t = {.count = 0};
    saltus_output output;
    int which = 0;
    saltus_status status = saltus_h5_reader_open(&r);
    if (status == SALTUS_OK)
        status = saltus_h5_get_head(&r, "trajectory", "branch or trajectory", &head);
    while (status == SALTUS_OK && which < table_count &&
           (strcmp(tables[which].kind, head.kind) != 0 || (name && strcmp(tables[which].name, name) != 0)))
        which++;
    if (status == SALTUS_OK && which == table_count)
        status = saltus_fail(message, SALTUS_BAD_INPUT,
                             "%s: holds a %s, which has no table %s; a branch has points and events, a "
                             "trajectory samples, events and strobe",
                             path, head.kind, name ? name : "");
    if (status == SALTUS_OK)
        status = read_rows(&r, which, &head.spec, &t);
    if (status == SALTUS_OK)
        status = saltus_output_open(&output, to, message);
    if (status == SALTUS_OK) {
        fprintf(output.file, "# Saltus " SALTUS_VERSION " %s, %s\n# scene: %s\n", head.kind,
                tables[which].name, head.scene);
        put_line(output.file, &t, NULL);
        for (long long k = 0; k < t.count && !ferror(output.file); k++)
            put_line(output.file, &t, t.records + (size_t)k * t.stride);
        status = saltus_output_close(&output, SALTUS_OK, message);
    }
    free(t.records);
    saltus_system_free(t.system);
    saltus_h5_head_clear(&head);
    saltus_h5_reader_close(&r);
    return status;
}
