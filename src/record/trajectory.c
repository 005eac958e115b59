/* Records of trajectories as files: comma-separated values, or HDF5.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "record/hdf5.h"
#include "record/output.h"
#include "saltus/record.h"

#include <stdlib.h>

/* A record with what explains it. */
typedef struct source {
    const saltus_trajectory *record;
    const saltus_scene *scene;
    const saltus_system *system;
    const saltus_flow_options *options;
} source;

static void put_header(const source *s, FILE *file) {
    const saltus_system *system = s->system;
    const saltus_flow_options *o = s->options;
    char a[SALTUS_NUMBER_MAX], b[SALTUS_NUMBER_MAX];
    saltus_put_table_head(file, "trajectory", s->scene, NULL, saltus_system_spec(system));
    fprintf(file, "# options: rtol = %s, atol = %s, integrator = %s (%s), order = %d\n",
            saltus_number(o->rtol, a), saltus_number(o->atol, b), saltus_integrator_word(o->integrator),
            saltus_integrator_used(system, o->integrator), o->order);
    fprintf(file, "# time_over_T: time from the start of the recording in forcing periods T = %s\n",
            saltus_number(saltus_system_period(system), a));
    fputs("# displacement, velocity: observed coordinate and its rate (contact coordinate of the first stop; "
          "without "
          "a stop the pipe's midpoint or mass 1)\n"
          "# q1.., v1..: displacements of the modes or masses and their rates; z1..: further states\n"
          "# stop, side, event: an impact, stick or release, on the row just before it; the row just after "
          "an impact or "
          "a stick follows with the same time\n",
          file);
}

static void put_columns(const saltus_system *system, FILE *file) {
    fputs("time_over_T,displacement,velocity", file);
    for (int i = 1; i <= saltus_system_dof(system); i++)
        fprintf(file, ",q%d", i);
    for (int i = 1; i <= saltus_system_dof(system); i++)
        fprintf(file, ",v%d", i);
    for (int i = 1; i <= saltus_system_extra(system); i++)
        fprintf(file, ",z%d", i);
    fputs(",stop,side,event\n", file);
}

/* Comment lines and one row per sample; failures are left in the file's error flag. */
static void write_csv(const source *s, FILE *file) {
    const saltus_trajectory *r = s->record;
    long long event = 0;
    put_header(s, file);
    put_columns(s->system, file);
    for (long long row = 0; row < r->samples && !ferror(file); row++) {
        const double observed[] = {r->displacement[row], r->velocity[row]};
        saltus_put_number(file, r->time[row]);
        for (int i = 0; i < 2 + r->dimension; i++) {
            fputc(',', file);
            saltus_put_number(file, i < 2 ? observed[i] : r->states[row * r->dimension + i - 2]);
        }
        if (event < r->event_count && r->event_rows[event] == row) {
            saltus_face face = saltus_system_face(s->system, r->events[event].face);
            fprintf(file, ",%d,%s,%s\n", face.stop + 1, saltus_side_word(face.side),
                    saltus_event_word(r->events[event].kind));
            event++;
        } else
            fputs(",,,\n", file);
    }
}

static const int scalar[2] = {0, 0};

/* Parameters and stops as one text, as in the header of a CSV file. NULL when there is no memory. */
static char *parameter_text(const saltus_spec *spec) {
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (!stream)
        return NULL;
    saltus_put_parameters(stream, spec, "");
    if (fclose(stream) == 0)
        return text;
    free(text);
    return NULL;
}

static void put_trajectory(saltus_h5 *w, const source *s) {
    const saltus_trajectory *r = s->record;
    hid_t real = H5T_IEEE_F64LE, native = H5T_NATIVE_DOUBLE;
    const saltus_h5_column time = {"time", "T",    "time from the start of the recording in forcing periods",
                                   real,   native, r->time};
    const saltus_h5_column states = {
        "states", "1",    "displacements q, velocities q', further states, one row per sample",
        real,     native, r->states};
    const saltus_h5_column displacement = {
        "displacement", "1",    "observed displacement (contact coordinate of the first stop)",
        real,           native, r->displacement};
    const saltus_h5_column velocity = {"velocity", "1",    "rate of the observed displacement",
                                       real,       native, r->velocity};
    hid_t group = saltus_h5_open_group(w, "trajectory", "samples, with one on each side of every impact");
    saltus_h5_dataset(w, group, &time, r->samples, scalar);
    saltus_h5_dataset(w, group, &states, r->samples, (const int[2]){r->dimension, 0});
    saltus_h5_dataset(w, group, &displacement, r->samples, scalar);
    saltus_h5_dataset(w, group, &velocity, r->samples, scalar);
    saltus_h5_close(group);
}

/* The events as columns; integers first, three of them, then three of doubles. */
static bool split_events(const source *s, int *integers, double *reals) {
    const saltus_trajectory *r = s->record;
    long long n = r->event_count;
    if (!integers || !reals)
        return false;
    for (long long k = 0; k < n; k++) {
        const saltus_event *event = &r->events[k];
        saltus_face face = saltus_system_face(s->system, event->face);
        integers[k] = (int)event->kind;
        integers[n + k] = face.stop + 1;
        integers[2 * n + k] = face.side;
        reals[k] = saltus_time_periods(event->time);
        reals[n + k] = event->velocity_before;
        reals[2 * n + k] = saltus_event_after(event);
    }
    return true;
}

static hid_t kind_type(saltus_h5 *w) {
    static const int kinds[] = {SALTUS_IMPACT, SALTUS_STICK, SALTUS_RELEASE};
    const char *words[3];
    for (int k = 0; k < 3; k++)
        words[k] = saltus_event_word((saltus_event_kind)kinds[k]);
    return saltus_h5_enumeration(w, H5T_NATIVE_INT, words, kinds, 3);
}

static void put_events(saltus_h5 *w, const source *s, int *integers, double *reals) {
    long long n = s->record->event_count;
    hid_t group =
        saltus_h5_open_group(w, "events", "impacts, begins of contact (stick) and releases, in order");
    hid_t type = kind_type(w), whole = H5T_STD_I32LE, real = H5T_IEEE_F64LE;
    const saltus_h5_column columns[] = {
        {"kind", "1", "impact, stick or release", type, type, integers},
        {"stop", "1", "number of the stop, from 1", whole, H5T_NATIVE_INT, integers + n},
        {"side", "1", "+1 upper, -1 lower", whole, H5T_NATIVE_INT, integers + 2 * n},
        {"time", "T", "time from the start of the recording; a stick: where the impacts accumulate", real,
         H5T_NATIVE_DOUBLE, reals},
        {"velocity_before", "1", "normal velocity n.q' just before", real, H5T_NATIVE_DOUBLE, reals + n},
        {"velocity_after", "1", "normal velocity n.q' just after", real, H5T_NATIVE_DOUBLE, reals + 2 * n},
        {"row", "1", "row of /trajectory just before the event, from 0", H5T_STD_I64LE, H5T_NATIVE_LLONG,
         s->record->event_rows},
    };
    for (size_t k = 0; k < sizeof columns / sizeof columns[0]; k++)
        saltus_h5_dataset(w, group, &columns[k], n, scalar);
    saltus_h5_close(type);
    saltus_h5_close(group);
}

static void put_strobe(saltus_h5 *w, const saltus_trajectory *r) {
    const saltus_h5_column states = {
        "states",
        "1",
        "states at phase 0 of the forcing, one row per recorded period, row k at time k",
        H5T_IEEE_F64LE,
        H5T_NATIVE_DOUBLE,
        r->strobe_states};
    hid_t group = saltus_h5_open_group(w, "strobe", "stroboscopic points");
    saltus_h5_dataset(w, group, &states, r->strobes, (const int[2]){r->dimension, 0});
    saltus_h5_close(group);
}

static void put_attributes(saltus_h5 *w, const source *s, const char *parameters) {
    const saltus_flow_options *o = s->options;
    const saltus_spec *spec = saltus_system_spec(s->system);
    saltus_h5_text(w, w->file, "version", SALTUS_VERSION);
    saltus_h5_text(w, w->file, "kind", "trajectory");
    saltus_h5_text(w, w->file, "scene", s->scene->name);
    saltus_h5_text(w, w->file, "title", s->scene->title);
    saltus_h5_text(w, w->file, "model", saltus_model_name(spec->model));
    saltus_h5_text(w, w->file, "parameters", parameters);
    saltus_h5_double(w, w->file, "period", saltus_system_period(s->system));
    saltus_h5_double(w, w->file, "rtol", o->rtol);
    saltus_h5_double(w, w->file, "atol", o->atol);
    saltus_h5_integer(w, w->file, "order", o->order);
    saltus_h5_text(w, w->file, "integrator", saltus_integrator_used(s->system, o->integrator));
}

static void write_file(const source *s, FILE *file, saltus_h5 *w) {
    long long n = s->record->event_count;
    char *parameters = parameter_text(saltus_system_spec(s->system));
    int *integers = malloc((size_t)(3 * n + 1) * sizeof *integers);
    double *reals = malloc((size_t)(3 * n + 1) * sizeof *reals);
    saltus_h5_create(w);
    if (saltus_h5_note_memory(w, parameters && split_events(s, integers, reals))) {
        put_attributes(w, s, parameters);
        saltus_h5_parameters(w, saltus_system_spec(s->system));
        put_trajectory(w, s);
        put_events(w, s, integers, reals);
        put_strobe(w, s->record);
    }
    saltus_h5_finish(w, file);
    free(parameters);
    free(integers);
    free(reals);
}

/* An HDF5 file, made in memory and then written. Errors: SALTUS_IO, SALTUS_NO_MEMORY. */
static saltus_status write_hdf5(const source *s, FILE *file, saltus_message *message) {
    saltus_h5 w;
    saltus_h5_silence silence;
    if (!saltus_h5_quiet(&silence))
        return saltus_fail(message, SALTUS_IO, "the HDF5 library could not be opened");
    write_file(s, file, &w);
    saltus_h5_restore(&silence);
    return saltus_h5_status(&w, message);
}

saltus_status saltus_write_trajectory(const saltus_trajectory *record, const saltus_scene *scene,
                                      const saltus_system *system, const saltus_flow_options *options,
                                      const char *path, saltus_message *message) {
    bool csv = saltus_path_ends(path, ".csv"), hdf5 = saltus_path_ends(path, ".h5");
    if (!csv && !hdf5)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .csv or .h5", path);
    const source s = {record, scene, system, options};
    saltus_output output;
    saltus_status status = saltus_output_open(&output, path, message);
    if (status != SALTUS_OK)
        return status;
    if (csv)
        write_csv(&s, output.file);
    else
        status = write_hdf5(&s, output.file, message);
    return saltus_output_close(&output, status, message);
}
