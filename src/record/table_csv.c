/* Tables of branches and trajectories as CSV: a group of an HDF5 file, written by its table of fields.
 * Parameters, stops and states have their names as columns; comments say what the columns are.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "record/fields.h"
#include "record/output.h"
#include "record/rows.h"
#include "record/trajectory.h"

#include <stdlib.h>
#include <string.h>

/* The tables of each kind of file, its first one first. `number` is a column before the others; NULL: none.
 */
static const struct {
    const char *kind, *name, *group;
    const saltus_field_table *fields;
    const char *number, *meaning;
} tables[] = {
    {"branch", "points", "points", &saltus_point_fields, "row", "number of the point: --from FILE.h5:row"},
    {"branch", "events", "events", &saltus_event_fields, "row",
     "number of the point whose orbit the event is of, in the table of points"},
    {"trajectory", "samples", NULL, NULL, NULL, NULL},
    {"trajectory", "events", "events", &saltus_trajectory_event_fields, NULL, NULL},
    {"trajectory", "strobe", "strobe", &saltus_strobe_fields, "time_over_T",
     "time from the start of the recording in T"}};
enum { table_count = sizeof tables / sizeof tables[0], name_size = 80 };

/* Rows in memory, row by row. */
typedef struct rows {
    saltus_field fields[SALTUS_FIELDS_MAX];
    saltus_field_table kind;
    int counts[SALTUS_COUNTS_MAX];
    size_t stride;
    long long count;
    unsigned char *records;
    long long *numbers;    /* of the rows, in the column before the others; NULL: none */
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
    if (status != SALTUS_OK || !tables[which].number)
        return status;
    to->numbers = calloc((size_t)to->count + 1, sizeof *to->numbers);
    if (!to->numbers)
        return saltus_h5_no_memory(r);
    for (long long k = 0; k < to->count; k++)
        to->numbers[k] = k + (kind == &saltus_point_fields);
    /* Of each event of a branch it is that of its point. */
    static const saltus_field span_fields[] = {
        SALTUS_MEMBER(saltus_span, first, "event_first", "1", "", SALTUS_LONG),
        SALTUS_MEMBER(saltus_span, count, "event_count", "1", "", SALTUS_LONG)};
    static const saltus_field_table spans = SALTUS_TABLE(span_fields);
    long long points = 0;
    void *own_events = NULL;
    if (kind == &saltus_event_fields)
        status = saltus_h5_get_all(r, "points", &spans, NULL, 1000000000, sizeof(saltus_span), &own_events,
                                   &points);
    for (long long k = 0; k < points && status == SALTUS_OK; k++) {
        const saltus_span own = ((const saltus_span *)own_events)[k];
        if (own.count < 0 || own.first < 0 || own.first > to->count - own.count)
            status = saltus_h5_refuse_part(r, "points", "event_first");
        for (long long i = 0; i < own.count && status == SALTUS_OK; i++)
            to->numbers[own.first + i] = k + 1;
    }
    free(own_events);
    return status;
}

/* The column of an entry of a field: a parameter's or state's name, a stop's key of --set, else the field's
 * name with numbers. False if the model has no such entry. */
static bool name_entry(const saltus_field *f, const int *counts, int i, const saltus_system *system,
                       char text[name_size]) {
    static const struct {
        const char *key, *end;
    } of_stop[] = {{"xi", ""}, {"weight", "_1"}, {"weight", "_2"}, {"d", ""}, {"r", ""}};
    enum { per_stop = sizeof of_stop / sizeof of_stop[0], placed = 3 };
    const saltus_spec *spec = saltus_system_spec(system);
    int length[2], parameters;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &parameters);
    saltus_field_shape(f, counts, length);
    const int column = length[1] ? i % length[1] : 0;
    if (f->length == -1 - SALTUS_COUNT_PARAMETERS)
        snprintf(text, name_size, "%s", p[i].name);
    else if (f->length == -1 - SALTUS_COUNT_STOPS) {
        snprintf(text, name_size, "%s%d%s", of_stop[column].key, i / per_stop + 1, of_stop[column].end);
        return column >= placed || strcmp(of_stop[column].key, saltus_model_stop_key(spec->model)) == 0;
    } else if (strncmp(f->name, "state", 5) == 0 && f->length == -1 - SALTUS_COUNT_DIMENSION)
        snprintf(text, name_size, "%s", saltus_system_state_name(system, i).text);
    else if (strcmp(f->name, "multipliers") == 0)
        snprintf(text, name_size, "multiplier%d_%s", i / length[1] + 1, column ? "im" : "re");
    else if (strcmp(f->name, "log_moduli") == 0)
        snprintf(text, name_size, "log_modulus%d", i + 1);
    else if (length[0] && f->type != SALTUS_TEXT)
        snprintf(text, name_size, "%s%d", f->name, i + 1);
    else
        snprintf(text, name_size, "%s", f->name);
    return true;
}

/* The number of a field's columns. */
static int entries_of(const saltus_field *field, const int *counts) {
    int length[2];
    const int entries = (int)saltus_field_shape(field, counts, length);
    return field->type == SALTUS_TEXT ? 1 : entries;
}

/* A line of names (`row` -1) or of values. */
static void put_line(FILE *file, const rows *t, int which, long long row) {
    const unsigned char *record = row < 0 ? NULL : t->records + (size_t)row * t->stride;
    char text[SALTUS_FIELD_TEXT_MAX], name[name_size];
    const char *comma = "";
    if (t->numbers) {
        if (row < 0)
            fputs(tables[which].number, file);
        else
            fprintf(file, "%lld", t->numbers[row]);
        comma = ",";
    }
    for (int k = 0; k < t->kind.count; k++) {
        saltus_field entry = t->fields[k];
        const int entries = entries_of(&entry, t->counts);
        if (entry.type != SALTUS_TEXT)
            entry.length = entry.width = 0;
        for (int i = 0; i < entries; i++, entry.offset += saltus_field_bytes(&entry)) {
            if (!name_entry(&t->fields[k], t->counts, i, t->system, name))
                continue;
            fputs(comma, file);
            comma = ",";
            if (row < 0)
                fputs(name, file);
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

static saltus_status write_table(const char *to, const saltus_h5_reader *r, int which,
                                 const saltus_h5_head *head, const rows *t) {
    saltus_scene scene = {.initial_count = 0};
    saltus_output output;
    char what[64];
    saltus_status status = saltus_output_open(&output, to, r->message);
    if (status != SALTUS_OK)
        return status;
    snprintf(scene.name, sizeof scene.name, "%s", head->scene);
    snprintf(scene.title, sizeof scene.title, "%s", head->title);
    snprintf(what, sizeof what, "%s %s", saltus_h5_is_locus(r->file) ? "locus" : head->kind,
             tables[which].name);
    saltus_put_table_head(output.file, what, &scene, NULL, &head->spec);
    if (!head->complete)
        fputs("# complete: 0\n", output.file);
    /* The parameters that a branch was continued in, with their ranges. */
    hid_t group = saltus_h5_find_group(r->file, "continuation");
    if (group >= 0)
        fputs("# these are the parameters and stops of the start; continued were\n", output.file);
    for (int k = 1; k <= 2 && group >= 0; k++) {
        char names[3][8], key[SALTUS_KEY_MAX], low_text[SALTUS_NUMBER_MAX], high_text[SALTUS_NUMBER_MAX];
        double low = 0, high = 0;
        snprintf(names[0], sizeof names[0], "key%d", k);
        snprintf(names[1], sizeof names[1], "low%d", k);
        snprintf(names[2], sizeof names[2], "high%d", k);
        if (saltus_h5_get_text(group, names[0], key, sizeof key) && key[0] &&
            saltus_h5_get_double(group, names[1], &low) && saltus_h5_get_double(group, names[2], &high))
            fprintf(output.file, "# key%d: %s, from %s to %s\n", k, key, saltus_number(low, low_text),
                    saltus_number(high, high_text));
    }
    saltus_h5_close(group);
    /* A line for each field, with its first and last column and what it is. */
    if (t->numbers)
        fprintf(output.file, "# %s: %s\n", tables[which].number, tables[which].meaning);
    for (int k = 0; k < t->kind.count; k++) {
        const saltus_field *f = &t->fields[k];
        char name[name_size], first[name_size] = "", last[name_size] = "";
        for (int i = 0; i < entries_of(f, t->counts); i++)
            if (name_entry(f, t->counts, i, t->system, name))
                strcpy(first[0] ? last : first, name);
        const char *means = f->length == -1 - SALTUS_COUNT_PARAMETERS ? "parameters of the model"
                            : f->length == -1 - SALTUS_COUNT_STOPS    ? "of stop 1, 2, ..., as in --set"
                                                                      : f->meaning;
        if (first[0])
            fprintf(output.file, "# %s%s%s: %s%s\n", first, last[0] ? " to " : "", last, means,
                    strcmp(f->unit, "T") == 0 ? ", in T" : "");
    }
    for (long long k = -1; k < t->count && !ferror(output.file); k++)
        put_line(output.file, t, which, k);
    return saltus_output_close(&output, SALTUS_OK, r->message);
}

saltus_status saltus_write_csv(const char *to, const char *path, const char *name, saltus_message *message) {
    saltus_h5_reader r = {.path = path, .kind = "branch", .message = message};
    saltus_h5_head head = {.complete = false};
    rows t = {.count = 0};
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
    const bool samples = status == SALTUS_OK && !tables[which].fields;
    if (status == SALTUS_OK && !samples)
        status = read_rows(&r, which, &head.spec, &t);
    if (status == SALTUS_OK && !samples)
        status = write_table(to, &r, which, &head, &t);
    free(t.records);
    free(t.numbers);
    saltus_system_free(t.system);
    saltus_h5_head_clear(&head);
    saltus_h5_reader_close(&r);
    return samples ? saltus_write_samples(to, path, message) : status;
}

void saltus_table_kind(const saltus_file_facts *file, const char *name, char kind[32]) {
    const bool swept = strcmp(file->kind, "sweep") == 0 || strcmp(file->kind, "basins") == 0;
    const char *const whole = swept ? "rows" : "samples"; /* the table that stands for the file */
    const char *known = swept && (!name || strcmp(name, whole) == 0) ? whole : NULL;
    for (int k = 0; k < table_count && !swept && !known; k++)
        if (strcmp(tables[k].kind, file->kind) == 0 && (!name || strcmp(tables[k].name, name) == 0))
            known = tables[k].name;
    for (int k = 0; k < SALTUS_CLOUDS && swept && !known; k++)
        if (strcmp(saltus_clouds[k].group, name) == 0)
            known = name;
    kind[0] = '\0';
    if (known && strcmp(known, whole) == 0)
        snprintf(kind, 32, "%.25s table", file->kind);
    else if (known)
        snprintf(kind, 32, "%.11s %.12s table", file->locus ? "locus" : file->kind, known);
}
