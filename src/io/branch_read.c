/* Reading a branch file back, whoever may have written it: everything is checked before it is used.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/branch_columns.h"
#include "io/describe.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const long long most_rows = 100000000;

/* A file being read. */
typedef struct reader {
    hid_t file;
    const char *path;
    saltus_message *message;
    saltus_branch_file *made;
    saltus_branch_shape shape;
    saltus_system *system;
} reader;

static saltus_status refuse(const reader *r, const char *what) {
    return saltus_fail(r->message, SALTUS_BAD_INPUT, "%s: is not a sound branch file: %s", r->path, what);
}

static saltus_status refuse_part(const reader *r, const char *group, const char *name) {
    return saltus_fail(r->message, SALTUS_BAD_INPUT,
                       "%s: is not a sound branch file: %s/%s is missing or not as it should be", r->path,
                       group, name);
}

/* Open a group; the caller closes it. */
static hid_t open_group(const reader *r, const char *name) {
    return H5Lexists(r->file, name, H5P_DEFAULT) > 0 ? H5Gopen2(r->file, name, H5P_DEFAULT) : -1;
}

static saltus_status read_stop(const reader *r, int s, saltus_stop *stop) {
    char name[32], sides[16] = "";
    snprintf(name, sizeof name, "parameters/stop_%d", s + 1);
    hid_t group = open_group(r, name);
    if (group < 0)
        return refuse(r, "a stop's group is missing");
    *stop = saltus_stop_defaults();
    bool placed = strcmp(saltus_model_name(r->made->spec.model), "pipe") == 0
                      ? saltus_h5_get_double(group, "xi", &stop->xi)
                      : saltus_h5_get_double(group, "weight1", &stop->weight[0]) &&
                            saltus_h5_get_double(group, "weight2", &stop->weight[1]);
    bool whole = placed && saltus_h5_get_double(group, "d", &stop->d) &&
                 saltus_h5_get_double(group, "r", &stop->r) &&
                 saltus_h5_get_text(group, "sides", sides, sizeof sides);
    saltus_h5_close_group(group);
    int k = SALTUS_UPPER;
    while (k <= SALTUS_BOTH && strcmp(sides, saltus_sides_word((saltus_sides)k)) != 0)
        k++;
    if (!whole || k > SALTUS_BOTH)
        return refuse_part(r, name, "d, r, sides");
    stop->sides = (saltus_sides)k;
    return SALTUS_OK;
}

/* Parameters and stops of the start, and the system they make. */
static saltus_status read_spec(reader *r, const char *model) {
    saltus_spec *spec = &r->made->spec;
    if (!saltus_model_find(model))
        return saltus_fail(r->message, SALTUS_BAD_INPUT, "%s: the model %.40s is not known", r->path, model);
    *spec = saltus_spec_defaults(saltus_model_find(model));
    const saltus_parameter *p = saltus_model_parameters(spec->model, &r->shape.parameters);
    hid_t group = open_group(r, "parameters");
    saltus_status status = group < 0 ? refuse(r, "the group /parameters is missing") : SALTUS_OK;
    for (int k = 0; k < r->shape.parameters && status == SALTUS_OK; k++)
        if (!saltus_h5_get_double(group, p[k].name, &spec->parameters[k]))
            status = refuse_part(r, "parameters", p[k].name);
    saltus_h5_close_group(group);
    while (status == SALTUS_OK && spec->stop_count < SALTUS_STOPS_MAX) {
        char name[32];
        snprintf(name, sizeof name, "parameters/stop_%d", spec->stop_count + 1);
        if (H5Lexists(r->file, name, H5P_DEFAULT) <= 0)
            break;
        status = read_stop(r, spec->stop_count, &spec->stops[spec->stop_count]);
        spec->stop_count++;
    }
    saltus_message sentence = {""};
    if (status == SALTUS_OK)
        status = saltus_system_new(spec, &r->system, &sentence);
    if (!r->system && sentence.text[0])
        status = status == SALTUS_NO_MEMORY ? saltus_fail(r->message, status, "%s", sentence.text)
                                            : refuse(r, sentence.text);
    r->shape.stops = spec->stop_count;
    return status;
}

static saltus_status read_head(reader *r) {
    saltus_branch_file *made = r->made;
    char kind[32] = "", model[64] = "";
    if (!saltus_h5_get_text(r->file, "kind", kind, sizeof kind))
        return saltus_fail(r->message, SALTUS_BAD_INPUT, "%s: is an HDF5 file, but not one of Saltus",
                           r->path);
    if (strcmp(kind, "branch") != 0)
        return saltus_fail(r->message, SALTUS_BAD_INPUT, "%s: holds a %s, not a branch of orbits", r->path,
                           kind);
    const saltus_h5_head_text texts[] = {{"version", made->version, sizeof made->version},
                                         {"scene", made->scene, sizeof made->scene},
                                         {"title", made->title, sizeof made->title},
                                         {"model", model, sizeof model}};
    saltus_status status =
        saltus_h5_get_head(r->file, r->path, "branch", texts, 4, &made->complete, r->message);
    if (status != SALTUS_OK)
        return status;
    return read_spec(r, model);
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

static saltus_status read_options(reader *r) {
    saltus_branch_options *options = &r->made->options;
    static const int scalar[2] = {0, 0};
    char locus[16] = "";
    int kind = 0;
    hid_t group = open_group(r, "continuation");
    saltus_status status = group < 0 ? refuse(r, "the group /continuation is missing") : SALTUS_OK;
    *options = saltus_branch_defaults();
    for (int k = 0; k < SALTUS_BRANCH_SETTINGS && status == SALTUS_OK; k++)
        if (!read_option(group, &saltus_branch_settings[k], options))
            status = refuse_part(r, "continuation", saltus_branch_settings[k].name);
    bool named = status == SALTUS_OK && saltus_h5_get_text(group, "locus", locus, sizeof locus);
    while (kind < SALTUS_POINT_KINDS && strcmp(locus, saltus_point_word((saltus_point_kind)kind)) != 0)
        kind++;
    if (status == SALTUS_OK && (!named || kind == SALTUS_POINT_KINDS))
        status = refuse_part(r, "continuation", "locus");
    saltus_h5_close_group(group);
    if (status != SALTUS_OK)
        return status;
    options->locus = (saltus_point_kind)kind;
    long long count = saltus_h5_rows(r->file, "continuation/values");
    if (count < 0 || count > 1000000)
        return refuse_part(r, "continuation", "values");
    r->made->values = malloc(((size_t)count + 1) * sizeof *r->made->values);
    if (!r->made->values)
        return saltus_fail(r->message, SALTUS_NO_MEMORY, "no memory for reading %s", r->path);
    options->values = r->made->values;
    options->value_count = (int)count;
    return saltus_h5_get_dataset(r->file, "continuation/values", H5T_NATIVE_DOUBLE, count, scalar,
                                 r->made->values)
               ? SALTUS_OK
               : refuse_part(r, "continuation", "values");
}

static saltus_status read_start(reader *r) {
    static const int scalar[2] = {0, 0};
    saltus_branch_file *made = r->made;
    long long periods = 0;
    int n = made->dimension = r->shape.dimension = saltus_system_dimension(r->system);
    hid_t group = open_group(r, "start");
    bool found = group >= 0 && saltus_h5_get_integer(group, "periods", &periods);
    saltus_h5_close_group(group);
    if (!found || periods < 1 || periods > INT_MAX)
        return refuse_part(r, "start", "periods");
    made->periods = (int)periods;
    made->state = calloc((size_t)n, sizeof *made->state);
    if (!made->state)
        return saltus_fail(r->message, SALTUS_NO_MEMORY, "no memory for reading %s", r->path);
    if (!saltus_h5_get_dataset(r->file, "start/state", H5T_NATIVE_DOUBLE, n, scalar, made->state))
        return refuse_part(r, "start", "state");
    for (int i = 0; i < n; i++)
        if (!isfinite(made->state[i]))
            return refuse(r, "the start's state is not finite");
    return SALTUS_OK;
}

/* Whether memory for so many rows should be asked for. A column of the stops of a scene without any is not
 * there. */
static bool is_believable(const reader *r, const char *name, long long rows, const int width[2]) {
    hsize_t size[SALTUS_H5_RANK_MAX] = {0}, stored,
            per_row = (hsize_t)(width[0] ? width[0] : 1) * (hsize_t)(width[1] ? width[1] : 1);
    bool absent = width[1] && !width[0];
    return absent || (saltus_h5_extent(r->file, name, size, &stored) >= 0 &&
                      saltus_h5_believable((hsize_t)rows, per_row, stored));
}

/* Read one column of all rows; *data is to be freed. */
static saltus_status read_column(const reader *r, const char *group, const saltus_branch_column *column,
                                 long long rows, unsigned char **data) {
    saltus_h5 w = {.file = r->file, .sound = true};
    char name[64];
    int width[2];
    snprintf(name, sizeof name, "%s/%s", group, column->name);
    saltus_column_widths(column, r->shape, width);
    if (!is_believable(r, name, rows, width))
        return refuse_part(r, group, column->name);
    *data = calloc((size_t)rows + 1, saltus_column_bytes(column, r->shape) + 1);
    if (!*data)
        return saltus_fail(r->message, SALTUS_NO_MEMORY, "no memory for reading %s", r->path);
    if (width[1] && !width[0])
        return SALTUS_OK;
    hid_t memory = saltus_column_type(&w, column, false);
    bool found = memory >= 0 && saltus_h5_get_dataset(r->file, name, memory, rows, width, *data);
    if (memory >= 0)
        H5Tclose(memory);
    for (long long k = 0; column->element == SALTUS_ELEMENT_FLAG && k < rows; k++)
        (*data)[k] = (*data)[k] != 0;
    return found ? SALTUS_OK : refuse_part(r, group, column->name);
}

static int face_of(const saltus_system *system, int stop, int side) {
    for (int f = 0; f < saltus_system_face_count(system); f++) {
        saltus_face face = saltus_system_face(system, f);
        if (face.stop == stop - 1 && face.side == side)
            return f;
    }
    return -1;
}

/* An event from its row; false when there can be none like it. */
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
    *count = saltus_h5_rows(r->file, "events/kind");
    if (*count < 0 || *count > most_rows)
        return refuse_part(r, "events", "kind");
    for (int k = 0; k < SALTUS_EVENT_COLUMNS && status == SALTUS_OK; k++)
        status = read_column(r, "events", &saltus_event_columns[k], *count, &data[k]);
    if (status == SALTUS_OK)
        r->made->events = calloc((size_t)*count + 1, sizeof *r->made->events);
    if (status == SALTUS_OK && !r->made->events)
        status = saltus_fail(r->message, SALTUS_NO_MEMORY, "no memory for reading %s", r->path);
    for (long long e = 0; e < *count && status == SALTUS_OK; e++) {
        saltus_event_row row;
        for (int k = 0; k < SALTUS_EVENT_COLUMNS; k++) {
            size_t bytes = saltus_column_bytes(&saltus_event_columns[k], r->shape);
            memcpy(saltus_column_values(&saltus_event_columns[k], &row), data[k] + (size_t)e * bytes, bytes);
        }
        if (!make_event(r->system, &row, &r->made->events[e]))
            status = refuse(r, "an event is none of an impact, stick or release at one of the stops");
    }
    for (int k = 0; k < SALTUS_EVENT_COLUMNS; k++)
        free(data[k]);
    return status;
}

static bool finite_row(const double *values, int count) {
    for (int i = 0; i < count; i++)
        if (!isfinite(values[i]))
            return false;
    return true;
}

/* Whether a touch is at a face there is, at a time of the orbit. */
static bool is_touch(const saltus_system *system, const saltus_branch_point *point) {
    if (point->grazing_stop == 0)
        return point->grazing_side == 0 && isnan(point->grazing_time);
    return face_of(system, point->grazing_stop, point->grazing_side) >= 0 && point->grazing_time >= 0 &&
           point->grazing_time < point->periods;
}

/* Complete a point from the parts of its row that are kept in another form. */
static bool make_point(reader *r, saltus_point_row *row, long long k, long long events) {
    saltus_branch_point *point = &row->point;
    int n = r->shape.dimension;
    bool texts = memchr(point->label, 0, sizeof point->label) &&
                 memchr(point->label_after, 0, sizeof point->label_after) &&
                 memchr(point->reason, 0, sizeof point->reason);
    bool counted =
        point->event_count >= 0 && row->event_first >= 0 && row->event_first + point->event_count <= events;
    if (!texts || !counted || (int)point->kind < 0 || point->kind >= SALTUS_POINT_KINDS ||
        point->periods < 1 || !finite_row(point->state, n) ||
        !finite_row(point->spec.parameters, r->shape.parameters) || !isfinite(point->value[0]) ||
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
            return refuse(r, what);
        }
    }
    return SALTUS_OK;
}

static saltus_status read_points(reader *r, long long events) {
    saltus_branch_file *made = r->made;
    size_t n = (size_t)r->shape.dimension;
    unsigned char *data[SALTUS_POINT_COLUMNS] = {0};
    double *scratch = calloc(3 * n, sizeof *scratch);
    long long rows = saltus_h5_rows(r->file, "points/kind");
    saltus_status status = rows < 1 || rows > most_rows ? refuse(r, "it has no points") : SALTUS_OK;
    for (int k = 0; k < SALTUS_POINT_COLUMNS && status == SALTUS_OK; k++)
        status = read_column(r, "points", &saltus_point_columns[k], rows, &data[k]);
    if (status == SALTUS_OK) {
        made->points = calloc((size_t)rows, sizeof *made->points);
        made->states = calloc((size_t)rows * n, sizeof *made->states);
        made->multipliers = calloc((size_t)rows * n, sizeof *made->multipliers);
        made->point_count = (int)rows;
        if (!scratch || !made->points || !made->states || !made->multipliers)
            status = saltus_fail(r->message, SALTUS_NO_MEMORY, "no memory for reading %s", r->path);
    }
    if (status == SALTUS_OK)
        status = fill_points(r, data, rows, events, scratch);
    for (int k = 0; k < SALTUS_POINT_COLUMNS; k++)
        free(data[k]);
    free(scratch);
    return status;
}

saltus_status saltus_branch_file_read(const char *path, saltus_branch_file *file, saltus_message *message) {
    saltus_h5_silence silence;
    long long events = 0;
    *file = (saltus_branch_file){0};
    reader r = {.path = path, .message = message, .made = file};
    if (!saltus_h5_quiet(&silence))
        return saltus_fail(message, SALTUS_IO, "the HDF5 library could not be opened");
    r.file = saltus_h5_read_file(path, message);
    saltus_status status = r.file < 0 ? SALTUS_BAD_INPUT : read_head(&r);
    if (status == SALTUS_OK)
        status = read_options(&r);
    if (status == SALTUS_OK)
        status = read_start(&r);
    if (status == SALTUS_OK)
        status = read_events(&r, &events);
    if (status == SALTUS_OK)
        status = read_points(&r, events);
    if (r.file >= 0)
        H5Fclose(r.file);
    saltus_h5_restore(&silence);
    saltus_system_free(r.system);
    if (status != SALTUS_OK)
        saltus_branch_file_clear(file);
    return status;
}

void saltus_branch_file_clear(saltus_branch_file *file) {
    free(file->state);
    free(file->values);
    free(file->states);
    free(file->events);
    free(file->multipliers);
    free(file->points);
    *file = (saltus_branch_file){0};
}
