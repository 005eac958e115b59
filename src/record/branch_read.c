/* Reading a branch file of any origin: everything is checked before it is used.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/options.h"
#include "record/fields.h"
#include "record/rows.h"

#include "system/system.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const long long most_rows = 100000000;

/* A file being read. */
typedef struct reader {
    saltus_h5_reader h5;
    saltus_branch_file *made;
    int counts[SALTUS_COUNTS_MAX];
    saltus_system *system;
    long long events; /* their number */
} reader;

/* Read the file's head and build the system of its start. */
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
    saltus_model_parameters(made->spec.model, &r->counts[SALTUS_COUNT_PARAMETERS]);
    r->counts[SALTUS_COUNT_STOPS] = made->spec.stop_count;
    status = saltus_system_new(&made->spec, &r->system, &sentence);
    if (status == SALTUS_NO_MEMORY)
        return saltus_fail(r->h5.message, status, "%s", sentence.text);
    made->dimension = status == SALTUS_OK ? saltus_system_dimension(r->system) : 0;
    r->counts[SALTUS_COUNT_DIMENSION] = made->dimension;
    return status == SALTUS_OK ? status : saltus_h5_refuse(&r->h5, sentence.text);
}

static bool all_finite(const double *values, int count) {
    for (int i = 0; i < count; i++)
        if (!isfinite(values[i]))
            return false;
    return true;
}

/* The options of the run, what it goes on from, and its start. */
static saltus_status read_run(reader *r) {
    saltus_branch_file *made = r->made;
    saltus_branch_options *options = &made->options;
    long long periods = 0;
    double period = 0;
    int count = 0;
    hid_t group = saltus_h5_find_group(r->h5.file, "continuation");
    if (group < 0)
        return saltus_h5_refuse(&r->h5, "the group /continuation is missing");
    *options = saltus_branch_defaults();
    const char *lacking = saltus_h5_get_options(group, &saltus_branch_table, options);
    saltus_h5_close(group);
    if (lacking)
        return saltus_h5_refuse_part(&r->h5, "continuation", lacking);
    saltus_status status = saltus_h5_get_reals(&r->h5, "continuation", "values", 1000000, true,
                                               &options->value_count, &made->values);
    options->values = made->values;
    if (status == SALTUS_OK)
        status = saltus_h5_get_reals(&r->h5, "continuation", "resume", INT_MAX, false, &made->resume_count,
                                     &made->resume);
    if (status != SALTUS_OK)
        return status;
    group = saltus_h5_find_group(r->h5.file, "start");
    const bool found = group >= 0 && saltus_h5_get_integer(group, "periods", &periods);
    if (found && saltus_h5_get_double(group, "period", &period) && period > 0) {
        options->orbit.free_period = true;
        saltus_spec_set_omega(&made->spec, 2 * M_PI / period);
    }
    saltus_h5_close(group);
    if (!found || periods < saltus_system_forced(r->system) || periods > INT_MAX)
        return saltus_h5_refuse_part(&r->h5, "start", "periods");
    made->periods = (int)periods;
    status = saltus_h5_get_reals(&r->h5, "start", "state", made->dimension, true, &count, &made->state);
    return status == SALTUS_OK && count != made->dimension ? saltus_h5_refuse_part(&r->h5, "start", "state")
                                                           : status;
}

static saltus_status read_events(reader *r) {
    void *rows;
    long long count = 0;
    saltus_status status = saltus_h5_get_all(&r->h5, "events", &saltus_event_fields, NULL, most_rows,
                                             sizeof(saltus_event_row), &rows, &count);
    r->made->events = calloc((size_t)count + 1, sizeof *r->made->events);
    if (status == SALTUS_OK && !r->made->events)
        status = saltus_h5_no_memory(&r->h5);
    for (long long e = 0; e < count && status == SALTUS_OK; e++)
        if (!saltus_event_of_row(r->system, (const saltus_event_row *)rows + e, &r->made->events[e]))
            status = saltus_h5_refuse(&r->h5,
                                      "an event is none of an impact, stick or release at one of the stops");
    r->events = count;
    free(rows);
    return status;
}

/* Whether a row is a valid point; grazing must be at an existing face and within the orbit's time. */
static bool is_point(const reader *r, const saltus_point_row *row) {
    const saltus_branch_point *point = &row->point;
    const double time = point->grazing_time;
    const bool on_locus = point->locus >= SALTUS_POINT_LP && point->locus <= SALTUS_POINT_BE;
    const bool fits = r->made->options.locus ? on_locus : point->locus == SALTUS_POINT_REGULAR;
    const bool touches = point->grazing_stop == 0
                             ? point->grazing_side == 0 && isnan(time)
                             : saltus_face_of(r->system, point->grazing_stop, point->grazing_side) >= 0 &&
                                   time >= 0 && (time < point->periods || (!point->periods && time == 0));
    return fits && touches && point->event_count >= 0 && row->event_first >= 0 &&
           row->event_first <= r->events - point->event_count &&
           point->periods >= saltus_system_forced(r->system) &&
           all_finite(point->state, r->made->dimension) &&
           all_finite(point->spec.parameters, r->counts[SALTUS_COUNT_PARAMETERS]) &&
           isfinite(point->value[0]);
}

static saltus_status read_points(reader *r) {
    saltus_branch_file *made = r->made;
    const int n = made->dimension;
    saltus_h5_shape shape = {.rank = 0};
    saltus_status status =
        saltus_h5_find_rows(&r->h5, "points", &saltus_point_fields, r->counts, most_rows, false, &shape);
    if (status == SALTUS_OK && shape.size[0] == 0)
        status = saltus_h5_refuse(&r->h5, "it has no points");
    if (status != SALTUS_OK)
        return status;
    const size_t count = (size_t)shape.size[0], entries = count * (size_t)n;
    saltus_point_row *rows = calloc(count, sizeof *rows);
    made->points = calloc(count, sizeof *made->points);
    made->states = calloc(entries, sizeof *made->states);
    made->multipliers = calloc(entries, sizeof *made->multipliers);
    made->point_count = (int)count;
    const bool memory = rows && made->points && made->states && made->multipliers;
    for (size_t k = 0; k < count && memory; k++)
        rows[k].point = (saltus_branch_point){.spec = made->spec,
                                              .dimension = n,
                                              .state = made->states + k * (size_t)n,
                                              .multipliers = made->multipliers + k * (size_t)n};
    status = memory ? saltus_h5_get_rows(&r->h5, "points", &saltus_point_fields, r->counts, &shape, rows,
                                         sizeof *rows)
                    : saltus_h5_no_memory(&r->h5);
    for (size_t k = 0; k < count && status == SALTUS_OK; k++) {
        saltus_branch_point *point = &made->points[k];
        char what[64];
        snprintf(what, sizeof what, "row %zu of /points is not a point", k + 1);
        if (!is_point(r, &rows[k])) {
            status = saltus_h5_refuse(&r->h5, what);
            break;
        }
        *point = rows[k].point;
        const bool own_period = point->trivial_multiplier != 0;
        point->multiplier_count = n - own_period;
        while (point->periods == 0 && point->multiplier_count > 0 &&
               isnan(point->multipliers[point->multiplier_count - 1].re))
            point->multiplier_count--;
        if (own_period)
            saltus_spec_set_omega(&point->spec, 2 * M_PI / point->period);
        point->events = made->events + rows[k].event_first;
    }
    free(rows);
    return status;
}

saltus_status saltus_branch_file_read(const char *path, saltus_branch_file *file, saltus_message *message) {
    static saltus_status (*const steps[])(reader *) = {read_head, read_run, read_events, read_points};
    *file = (saltus_branch_file){0};
    reader r = {.h5 = {.path = path, .kind = "branch", .message = message}, .made = file};
    saltus_status status = saltus_h5_reader_open(&r.h5);
    for (size_t k = 0; k < sizeof steps / sizeof *steps && status == SALTUS_OK; k++)
        status = steps[k](&r);
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
    saltus_model_release(file->spec.model);
    *file = (saltus_branch_file){0};
}
