/* Reading a branch file back, whoever may have written it: everything is checked before it is used.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/branch_columns.h"
#include "record/describe.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const long long most_rows = 100000000;

/* A file being read. */
typedef struct reader {
    saltus_h5_reader h5;
    saltus_branch_file *made;
    saltus_branch_shape shape;
    saltus_system *system;
} reader;

/* Where the file is from, and the system of its start. */
static saltus_status read_head(reader *r) {
    saltus_branch_file *made = r->made;
    saltus_h5_head head;
    saltus_message sentence = {.text = ""};
    saltus_status status = saltus_h5_get_head(&r->h5, "branch", "branch of orbits", &head);
    if (status != SALTUS_OK)
        return status;
    memcpy(made->version, head.version, sizeof made->version);
    memcpy(made->scene, head.scene, sizeof made->scene);
    memcpy(made->title, head.title, sizeof made->title);
    made->complete = head.complete;
    made->spec = head.spec;
    saltus_model_parameters(made->spec.model, &r->shape.parameters);
    r->shape.stops = made->spec.stop_count;
    status = saltus_system_new(&made->spec, &r->system, &sentence);
    if (status == SALTUS_NO_MEMORY)
        return saltus_fail(r->h5.message, status, "%s", sentence.text);
    return status == SALTUS_OK ? status : saltus_h5_refuse(&r->h5, sentence.text);
}

static bool read_option(hid_t group, const saltus_branch_setting *s, saltus_branch_options *options) {
    char *place = (char *)options + s->offset;
    long long whole = 0;
    if (s->kind == SALTUS_SETTING_REAL)
        return saltus_h5_get_double(group, s->name, (double *)(void *)place);
    if (s->kind == SALTUS_SETTING_KEY)
        return saltus_h5_get_text(group, s->name, place, SALTUS_KEY_MAX);
    bool found = saltus_h5_get_integer(group, s->name, &whole) && whole >= INT_MIN && whole <= INT_MAX;
    *(int *)(void *)place = (int)whole;
    return found;
}

/* A list of numbers in /continuation, at most so many; *values is to be freed. */
static saltus_status read_reals(const reader *r, const char *name, long long most, double **values,
                                int *count) {
    static const int scalar[2] = {0, 0};
    char path[64];
    snprintf(path, sizeof path, "continuation/%s", name);
    hsize_t size[SALTUS_H5_RANK_MAX] = {0}, stored;
    bool listed = saltus_h5_extent(r->h5.file, path, size, &stored) == 1 && size[0] <= (hsize_t)most &&
                  saltus_h5_believable(size[0], 1, stored);
    if (!listed)
        return saltus_h5_refuse_part(&r->h5, "continuation", name);
    *values = malloc(((size_t)size[0] + 1) * sizeof **values);
    if (!*values)
        return saltus_h5_no_memory(&r->h5);
    *count = (int)size[0];
    return saltus_h5_get_dataset(r->h5.file, path, H5T_NATIVE_DOUBLE, *count, scalar, *values)
               ? SALTUS_OK
               : saltus_h5_refuse_part(&r->h5, "continuation", name);
}

static saltus_status read_options(reader *r) {
    saltus_branch_options *options = &r->made->options;
    char locus[16] = "";
    int kind = 0;
    hid_t group = saltus_h5_find_group(r->h5.file, "continuation");
    saltus_status status =
        group < 0 ? saltus_h5_refuse(&r->h5, "the group /continuation is missing") : SALTUS_OK;
    *options = saltus_branch_defaults();
    for (int k = 0; k < SALTUS_BRANCH_SETTINGS && status == SALTUS_OK; k++)
        if (!read_option(group, &saltus_branch_settings[k], options))
            status = saltus_h5_refuse_part(&r->h5, "continuation", saltus_branch_settings[k].name);
    bool named = status == SALTUS_OK && saltus_h5_get_text(group, "locus", locus, sizeof locus);
    while (kind < SALTUS_POINT_KINDS && strcmp(locus, saltus_point_word((saltus_point_kind)kind)) != 0)
        kind++;
    if (status == SALTUS_OK && (!named || kind == SALTUS_POINT_KINDS))
        status = saltus_h5_refuse_part(&r->h5, "continuation", "locus");
    saltus_h5_close(group);
    if (status != SALTUS_OK)
        return status;
    options->locus = (saltus_point_kind)kind;
    status = read_reals(r, "values", 1000000, &r->made->values, &options->value_count);
    options->values = r->made->values;
    return status == SALTUS_OK ? read_reals(r, "resume", most_rows, &r->made->resume, &r->made->resume_count)
                               : status;
}

static bool all_finite(const double *values, int count) {
    for (int i = 0; i < count; i++)
        if (!isfinite(values[i]))
            return false;
    return true;
}

static saltus_status read_start(reader *r) {
    static const int scalar[2] = {0, 0};
    saltus_branch_file *made = r->made;
    long long periods = 0;
    int n = made->dimension = r->shape.dimension = saltus_system_dimension(r->system);
    hid_t group = saltus_h5_find_group(r->h5.file, "start");
    bool found = group >= 0 && saltus_h5_get_integer(group, "periods", &periods);
    saltus_h5_close(group);
    if (!found || periods < 1 || periods > INT_MAX)
        return saltus_h5_refuse_part(&r->h5, "start", "periods");
    made->periods = (int)periods;
    made->state = calloc((size_t)n, sizeof *made->state);
    if (!made->state)
        return saltus_h5_no_memory(&r->h5);
    if (!saltus_h5_get_dataset(r->h5.file, "start/state", H5T_NATIVE_DOUBLE, n, scalar, made->state))
        return saltus_h5_refuse_part(&r->h5, "start", "state");
    return all_finite(made->state, n) ? SALTUS_OK
                                      : saltus_h5_refuse(&r->h5, "the start's state is not finite");
}

/* Whether a column can have so many rows, before memory for them is asked for. Without stops there is no
 * column of stops. */
static bool is_believable(const reader *r, const char *name, long long rows, const int width[2]) {
    hsize_t size[SALTUS_H5_RANK_MAX] = {0}, stored,
            per_row = (hsize_t)(width[0] ? width[0] : 1) * (hsize_t)(width[1] ? width[1] : 1);
    bool absent = width[1] && !width[0];
    return absent || (saltus_h5_extent(r->h5.file, name, size, &stored) >= 0 &&
                      saltus_h5_believable((hsize_t)rows, per_row, stored));
}

/* Read one column of all rows; *data is to be freed. */
static saltus_status read_column(const reader *r, const char *group, const saltus_branch_column *column,
                                 long long rows, unsigned char **data) {
    saltus_h5 w = {.file = r->h5.file, .sound = true};
    char name[64];
    int width[2];
    snprintf(name, sizeof name, "%s/%s", group, column->name);
    saltus_column_widths(column, r->shape, width);
    if (!is_believable(r, name, rows, width))
        return saltus_h5_refuse_part(&r->h5, group, column->name);
    *data = calloc((size_t)rows + 1, saltus_column_bytes(column, r->shape) + 1);
    if (!*data)
        return saltus_h5_no_memory(&r->h5);
    if (width[1] && !width[0])
        return SALTUS_OK;
    hid_t memory = saltus_column_type(&w, column, false);
    bool found = memory >= 0 && saltus_h5_get_dataset(r->h5.file, name, memory, rows, width, *data);
    saltus_h5_close(memory);
    for (long long k = 0; column->element == SALTUS_ELEMENT_FLAG && k < rows; k++)
        (*data)[k] = (*data)[k] != 0;
    return found ? SALTUS_OK : saltus_h5_refuse_part(&r->h5, group, column->name);
}

static int face_of(const saltus_system *system, int stop, int side) {
    for (int f = 0; f < saltus_system_face_count(system); f++) {
        saltus_face face = saltus_system_face(system, f);
        if (face.stop + 1 == stop && face.side == side)
            return f;
    }
    return -1;
}

/* An event from its row; false when there is no such kind, face or time. */
static bool make_event(const saltus_system *system, const saltus_event_row *row, saltus_event *event) {
    bool kind = row->kind == SALTUS_IMPACT || row->kind == SALTUS_STICK || row->kind == SALTUS_RELEASE;
    int face = face_of(system, row->stop, row->side);
    if (!kind || face < 0 || !(fabs(row->time) < 1e15) || !(row->phase >= 0 && row->phase < 1))
        return false;
    *event = (saltus_event){.kind = row->kind,
                            .face = face,
                            .time = {llround(row->time - row->phase), row->phase},
                            .velocity_before = row->velocity_before,
                            .velocity_after = row->velocity_after,
                            .displacement = row->displacement};
    return true;
}

static saltus_status read_events(reader *r, long long *count) {
    unsigned char *data[SALTUS_EVENT_COLUMNS] = {0};
    saltus_status status = SALTUS_OK;
    *count = saltus_h5_rows(r->h5.file, "events/kind");
    if (*count < 0 || *count > most_rows)
        return saltus_h5_refuse_part(&r->h5, "events", "kind");
    for (int k = 0; k < SALTUS_EVENT_COLUMNS && status == SALTUS_OK; k++)
        status = read_column(r, "events", &saltus_event_columns[k], *count, &data[k]);
    if (status == SALTUS_OK)
        r->made->events = calloc((size_t)*count + 1, sizeof *r->made->events);
    if (status == SALTUS_OK && !r->made->events)
        status = saltus_h5_no_memory(&r->h5);
    for (long long e = 0; e < *count && status == SALTUS_OK; e++) {
        saltus_event_row row;
        for (int k = 0; k < SALTUS_EVENT_COLUMNS; k++) {
            size_t bytes = saltus_column_bytes(&saltus_event_columns[k], r->shape);
            memcpy(saltus_column_values(&saltus_event_columns[k], &row), data[k] + (size_t)e * bytes, bytes);
        }
        if (!make_event(r->system, &row, &r->made->events[e]))
            status = saltus_h5_refuse(&r->h5,
                                      "an event is none of an impact, stick or release at one of the stops");
    }
    for (int k = 0; k < SALTUS_EVENT_COLUMNS; k++)
        free(data[k]);
    return status;
}

/* Whether a touch is at a face there is, at a time of the orbit. */
static bool is_touch(const saltus_system *system, const saltus_branch_point *point) {
    if (point->grazing_stop == 0)
        return point->grazing_side == 0 && isnan(point->grazing_time);
    return face_of(system, point->grazing_stop, point->grazing_side) >= 0 && point->grazing_time >= 0 &&
           point->grazing_time < point->periods;
}

/* Check a row, and make a point of it. */
static bool make_point(reader *r, saltus_point_row *row, long long k, long long events) {
    saltus_branch_point *point = &row->point;
    int n = r->shape.dimension;
    bool texts = memchr(point->label, 0, sizeof point->label) &&
                 memchr(point->label_after, 0, sizeof point->label_after) &&
                 memchr(point->reason, 0, sizeof point->reason);
    bool counted =
        point->event_count >= 0 && row->event_first >= 0 && row->event_first + point->event_count <= events;
    if (!texts || !counted || (int)point->kind < 0 || point->kind >= SALTUS_POINT_KINDS ||
        point->periods < 1 || !all_finite(point->state, n) ||
        !all_finite(point->spec.parameters, r->shape.parameters) || !isfinite(point->value[0]) ||
        !is_touch(r->system, point))
        return false;
    for (int s = 0; s < r->shape.stops; s++)
        saltus_stop_from_values(row->stops[s], &point->spec.stops[s]);
    point->events = r->made->events + row->event_first;
    point->multipliers = r->made->multipliers + k * n;
    for (int i = 0; i < n; i++)
        point->multipliers[i] =
            (saltus_multiplier){row->multipliers[2 * i], row->multipliers[2 * i + 1], row->log_moduli[i]};
    r->made->points[k] = *point;
    return true;
}

static saltus_status fill_points(reader *r, unsigned char *const *data, long long rows, long long events,
                                 double *scratch) {
    int n = r->shape.dimension;
    for (long long k = 0; k < rows; k++) {
        saltus_point_row row = {.point = {.spec = r->made->spec, .dimension = n}};
        row.point.state = r->made->states + k * n;
        row.multipliers = scratch;
        row.log_moduli = scratch + 2 * n;
        for (int c = 0; c < SALTUS_POINT_COLUMNS; c++) {
            const saltus_branch_column *column = &saltus_point_columns[c];
            size_t bytes = saltus_column_bytes(column, r->shape);
            memcpy(saltus_column_values(column, &row), data[c] + (size_t)k * bytes, bytes);
        }
        if (!make_point(r, &row, k, events)) {
            char what[64];
            snprintf(what, sizeof what, "row %lld of /points is not a point", k + 1);
            return saltus_h5_refuse(&r->h5, what);
        }
    }
    return SALTUS_OK;
}

static saltus_status read_points(reader *r, long long events) {
    saltus_branch_file *made = r->made;
    size_t n = (size_t)r->shape.dimension;
    unsigned char *data[SALTUS_POINT_COLUMNS] = {0};
    double *scratch = calloc(3 * n, sizeof *scratch);
    long long rows = saltus_h5_rows(r->h5.file, "points/kind");
    saltus_status status =
        rows < 1 || rows > most_rows ? saltus_h5_refuse(&r->h5, "it has no points") : SALTUS_OK;
    for (int k = 0; k < SALTUS_POINT_COLUMNS && status == SALTUS_OK; k++)
        status = read_column(r, "points", &saltus_point_columns[k], rows, &data[k]);
    if (status == SALTUS_OK) {
        made->points = calloc((size_t)rows, sizeof *made->points);
        made->states = calloc((size_t)rows * n, sizeof *made->states);
        made->multipliers = calloc((size_t)rows * n, sizeof *made->multipliers);
        made->point_count = (int)rows;
        if (!scratch || !made->points || !made->states || !made->multipliers)
            status = saltus_h5_no_memory(&r->h5);
    }
    if (status == SALTUS_OK)
        status = fill_points(r, data, rows, events, scratch);
    for (int k = 0; k < SALTUS_POINT_COLUMNS; k++)
        free(data[k]);
    free(scratch);
    return status;
}

saltus_status saltus_branch_file_read(const char *path, saltus_branch_file *file, saltus_message *message) {
    long long events = 0;
    *file = (saltus_branch_file){0};
    reader r = {.h5 = {.path = path, .kind = "branch", .message = message}, .made = file};
    saltus_status status = saltus_h5_reader_open(&r.h5);
    if (status == SALTUS_OK)
        status = read_head(&r);
    if (status == SALTUS_OK)
        status = read_options(&r);
    if (status == SALTUS_OK)
        status = read_start(&r);
    if (status == SALTUS_OK)
        status = read_events(&r, &events);
    if (status == SALTUS_OK)
        status = read_points(&r, events);
    saltus_h5_reader_close(&r.h5);
    saltus_system_free(r.system);
    if (status != SALTUS_OK)
        saltus_branch_file_clear(file);
    return status;
}

void saltus_branch_file_clear(saltus_branch_file *file) {
    free(file->state);
    free(file->values);
    free(file->resume);
    free(file->states);
    free(file->events);
    free(file->multipliers);
    free(file->points);
    *file = (saltus_branch_file){0};
}
