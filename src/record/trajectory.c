/* Files of recorded trajectories: CSV, or HDF5, which can be read back.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/trajectory.h"

#include "flow/options.h"
#include "record/describe.h"
#include "record/fields.h"
#include "record/output.h"
#include "record/rows.h"
#include "saltus/record.h"

#include <math.h>
#include <stdlib.h>

enum { most_rows = 1000000000 };

/* A record with its scene, system, options and origin. */
typedef struct source {
    const saltus_trajectory *record;
    const saltus_scene *scene;
    const saltus_system *system;
    const saltus_flow_options *options;
    const saltus_origin *origin; /* NULL: omitted */
} source;

static void put_header(const source *s, FILE *file) {
    const saltus_system *system = s->system;
    char a[SALTUS_NUMBER_MAX];
    saltus_put_table_head(file, "trajectory", s->scene, NULL, saltus_system_spec(system));
    fputs("# options: ", file);
    saltus_put_tolerances(file, system, s->options);
    fprintf(file, ", order = %d\n", s->options->order);
    if (s->record->interrupted)
        fputs("# complete: 0\n", file);
    fprintf(file, "# time_over_T: time from the start of the recording in %s T = %s\n",
            saltus_system_forced(system) ? "forcing periods" : "units of",
            saltus_number(saltus_system_period(system), a));
    if (saltus_system_observed_name(system))
        fprintf(file,
                "# displacement, velocity: %s and its rate\n# then the state and what is observed, by the "
                "names of the scene\n",
                saltus_system_observed_name(system));
    else
        fputs("# displacement, velocity: observed displacement and its rate (where observe does not say it: "
              "contact coordinate of the first stop; without a stop the pipe's midpoint or mass 1)\n"
              "# q1.., v1..: displacements of the modes or masses and their rates; z1..: further states\n",
              file);
    fputs("# stop, side, event: an impact, stick or release, on the row just before it; the row just after "
          "an impact or a stick follows with the same time\n",
          file);
}

/* What the scene observes at a sample. */
static void observe(const source *s, long long row, double *seen) {
    const saltus_trajectory *r = s->record;
    if (saltus_system_observable_count(s->system) > 0)
        saltus_system_observe(s->system, r->states + row * r->dimension, r->time[row] - floor(r->time[row]),
                              seen);
}

/* Comment lines and one row per sample. */
static saltus_status write_table(const char *path, const source *s, saltus_message *message) {
    const saltus_trajectory *r = s->record;
    const int observables = saltus_system_observable_count(s->system);
    saltus_output output;
    long long event = 0;
    saltus_status status = saltus_output_open(&output, path, message);
    if (status != SALTUS_OK)
        return status;
    double *seen = calloc((size_t)observables + 1, sizeof *seen);
    if (!seen) {
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the observed quantities");
        return saltus_output_close(&output, status, message);
    }
    FILE *file = output.file;
    put_header(s, file);
    fputs("time_over_T,displacement,velocity", file);
    for (int i = 0; i < r->dimension; i++)
        fprintf(file, ",%s", saltus_system_state_name(s->system, i).text);
    for (int k = 0; k < observables; k++)
        fprintf(file, ",%s", saltus_system_observable_name(s->system, k));
    fputs(",stop,side,event\n", file);
    for (long long row = 0; row < r->samples && !ferror(file); row++) {
        saltus_put_number(file, r->time[row]);
        saltus_put_numbers(file, (const double[]){r->displacement[row], r->velocity[row]}, 2);
        saltus_put_numbers(file, r->states + row * r->dimension, r->dimension);
        observe(s, row, seen);
        saltus_put_numbers(file, seen, observables);
        if (event < r->event_count && r->event_rows[event] == row) {
            saltus_face face = saltus_system_face(s->system, r->events[event].face);
            fprintf(file, ",%d,%s,%s\n", face.stop + 1, saltus_side_word(face.side),
                    saltus_event_word(r->events[event].kind));
            event++;
        } else
            fputs(",,,\n", file);
    }
    free(seen);
    return saltus_output_close(&output, SALTUS_OK, message);
}

/* A group of rows; `names`, where given, of the columns of its dataset `set`. */
static void put_rows(saltus_h5 *w, const char *name, const char *description, const saltus_rows *rows,
                     const char *set, const char *names) {
    hid_t group = saltus_h5_open_group(w, name, description);
    saltus_h5_rows(w, group, rows);
    if (set)
        saltus_h5_names(w, group, set, names);
    saltus_h5_close(group);
}

static saltus_status put_file(saltus_h5 *w, void *context, saltus_message *message) {
    const source *s = context;
    const saltus_trajectory *r = s->record;
    const int observables = saltus_system_observable_count(s->system);
    char names[SALTUS_PARAMETERS_MAX * SALTUS_KEY_MAX] = "";
    size_t used = 0;
    double *seen = calloc((size_t)(r->samples * observables) + 1, sizeof *seen);
    if (!seen)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the observed quantities");
    for (long long row = 0; row < r->samples; row++)
        observe(s, row, seen + row * observables);
    for (int k = 0; k < observables && used < sizeof names; k++)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", k ? "," : "",
                                 saltus_system_observable_name(s->system, k));
    const saltus_rows samples = {
        .kind = &saltus_sample_fields,
        .counts = {[SALTUS_COUNT_DIMENSION] = r->dimension, [SALTUS_COUNT_OBSERVED] = observables},
        .count = r->samples,
        .column = {r->time, r->states, r->displacement, r->velocity, seen}};
    const saltus_rows strobe = {.kind = &saltus_strobe_fields,
                                .counts = {[SALTUS_COUNT_DIMENSION] = r->dimension},
                                .count = r->strobes,
                                .column = {r->strobe_states}};
    /* Store the integrator actually used, not the automatic choice. */
    saltus_flow_options used_options = *s->options;
    saltus_field_read(&saltus_option_find(&saltus_flow_table, "integrator")->field,
                      saltus_integrator_used(s->system, used_options.integrator), &used_options);
    saltus_h5_put_head(w, "trajectory", s->scene->name, s->scene->title, saltus_system_spec(s->system),
                       !r->interrupted);
    if (s->origin)
        saltus_h5_put_origin(w, s->origin);
    saltus_h5_double(w, w->file, "period", saltus_system_period(s->system));
    saltus_h5_options(w, w->file, &saltus_flow_table, &used_options);
    put_rows(w, "trajectory", "samples, with one on each side of every impact", &samples,
             observables ? "observed" : NULL, names);
    free(seen);
    saltus_rows events = {.kind = &saltus_trajectory_event_fields};
    for (long long k = 0; k < r->event_count && w->sound; k++) {
        saltus_event_row row = saltus_event_row_of(s->system, &r->events[k]);
        row.velocity_after = saltus_event_after(&r->events[k]);
        row.row = r->event_rows[k];
        saltus_h5_note_memory(w, saltus_rows_add(&events, &row));
    }
    put_rows(w, "events", "impacts, begins of contact (stick) and releases, in order", &events, NULL, NULL);
    saltus_rows_clear(&events);
    put_rows(w, "strobe", "stroboscopic points", &strobe, NULL, NULL);
    return SALTUS_OK;
}

saltus_status saltus_write_trajectory(const char *path, const saltus_scene *scene,
                                      const saltus_system *system, const saltus_flow_options *options,
                                      const saltus_trajectory *record, const saltus_origin *origin,
                                      saltus_message *message) {
    bool csv = saltus_path_ends(path, ".csv"), hdf5 = saltus_path_ends(path, ".h5");
    if (!csv && !hdf5)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .csv or .h5", path);
    source s = {record, scene, system, options, origin};
    return hdf5 ? saltus_h5_write(path, false, put_file, &s, message) : write_table(path, &s, message);
}

saltus_status saltus_write_samples(const char *to, const char *path, saltus_message *message) {
    saltus_trajectory_file file;
    saltus_scene scene = {.initial_count = 0};
    saltus_status status = saltus_trajectory_file_read(path, &file, message);
    snprintf(scene.name, sizeof scene.name, "%s", file.head.scene);
    snprintf(scene.title, sizeof scene.title, "%s", file.head.title);
    const source s = {&file.record, &scene, file.system, &file.options, NULL};
    if (status == SALTUS_OK)
        status = write_table(to, &s, message);
    saltus_trajectory_file_clear(&file);
    return status;
}

/* Read one column of a table of samples: one number per sample, or `dimension` numbers for a state. */
static saltus_status read_column(const saltus_h5_reader *r, const char *group, const saltus_field *field,
                                 int dimension, double **values, long long *count) {
    const int counts[SALTUS_COUNTS_MAX] = {[SALTUS_COUNT_DIMENSION] = dimension};
    const saltus_field_table table = {field, 1};
    const size_t entries = field->length ? (size_t)dimension : 1;
    void *read = NULL;
    saltus_status status =
        saltus_h5_get_all(r, group, &table, counts, most_rows, entries * sizeof **values, &read, count);
    *values = read;
    for (size_t k = 0; k < (size_t)*count * entries && status == SALTUS_OK; k++)
        if (!isfinite((*values)[k]))
            status = saltus_h5_refuse_part(r, group, field->name);
    return status;
}

saltus_status saltus_trajectory_file_read(const char *path, saltus_trajectory_file *file,
                                          saltus_message *message) {
    saltus_h5_reader r = {.path = path, .kind = "trajectory", .message = message};
    saltus_trajectory *made = &file->record;
    double **const columns[] = {&made->time, &made->states, &made->displacement, &made->velocity};
    void *rows = NULL;
    long long count = 0;
    *file = (saltus_trajectory_file){.options = saltus_flow_defaults()};
    saltus_status status = saltus_h5_reader_open(&r);
    if (status == SALTUS_OK)
        status = saltus_h5_get_head(&r, "trajectory", "trajectory", &file->head);
    if (status == SALTUS_OK)
        status = saltus_system_new(&file->head.spec, &file->system, message);
    const char *wrong =
        status == SALTUS_OK ? saltus_h5_get_options(r.file, &saltus_flow_table, &file->options) : NULL;
    if (wrong)
        status = saltus_h5_refuse_part(&r, "", wrong);
    made->interrupted = !file->head.complete;
    made->dimension = status == SALTUS_OK ? saltus_system_dimension(file->system) : 0;
    for (int k = 0; k < 4 && status == SALTUS_OK; k++, made->samples = count) {
        const saltus_field *field = &saltus_sample_fields.fields[k];
        status = read_column(&r, "trajectory", field, made->dimension, columns[k], &count);
        if (status == SALTUS_OK && (count < 1 || (k > 0 && count != made->samples)))
            status = saltus_h5_refuse_part(&r, "trajectory", field->name);
    }
    /* The events, each with the sample rows around it. */
    count = 0;
    if (status == SALTUS_OK)
        status = saltus_h5_get_all(&r, "events", &saltus_trajectory_event_fields, NULL, most_rows,
                                   sizeof(saltus_event_row), &rows, &count);
    made->events = calloc((size_t)count + 1, sizeof *made->events);
    made->event_rows = calloc((size_t)count + 1, sizeof *made->event_rows);
    if (status == SALTUS_OK && !(made->events && made->event_rows))
        status = saltus_h5_no_memory(&r);
    for (long long k = 0; k < count && status == SALTUS_OK; k++) {
        const saltus_event_row *row = (const saltus_event_row *)rows + k;
        if (!saltus_event_of_row(file->system, row, &made->events[k]) ||
            row->row >= made->samples - (row->kind != SALTUS_RELEASE) ||
            row->row < (k ? made->event_rows[k - 1] : 0))
            status = saltus_h5_refuse_part(&r, "events", "row");
        made->event_rows[k] = row->row;
        made->event_count++;
    }
    free(rows);
    if (status == SALTUS_OK)
        status = read_column(&r, "strobe", saltus_strobe_fields.fields, made->dimension, &made->strobe_states,
                             &made->strobes);
    saltus_h5_reader_close(&r);
    return status;
}

void saltus_trajectory_file_clear(saltus_trajectory_file *file) {
    saltus_system_free(file->system);
    saltus_trajectory_clear(&file->record);
    saltus_h5_head_clear(&file->head);
}
