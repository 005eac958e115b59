/* A record as an HDF5 file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/describe.h"
#include "io/hdf5.h"
#include "io/record.h"

#include <stdlib.h>

static const int scalar[2] = {0, 0};

/* Parameters and stops as one text, as in the header of a CSV file. NULL when there is no memory. */
static char *parameter_text(const saltus_spec *spec) {
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (!stream)
        return NULL;
    saltus_put_parameters(stream, spec);
    for (int s = 0; s < spec->stop_count; s++) {
        fprintf(stream, "\nstop %d: ", s + 1);
        saltus_put_stop(stream, spec, s);
    }
    if (fclose(stream) == 0)
        return text;
    free(text);
    return NULL;
}

static void put_trajectory(saltus_h5 *w, const saltus_source *source) {
    const saltus_record *r = source->record;
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
    saltus_h5_close_group(group);
}

/* The events as columns; integers first, three of them, then three of doubles. */
static bool split_events(const saltus_source *source, int *integers, double *reals) {
    const saltus_record *r = source->record;
    long long n = r->event_count;
    if (!integers || !reals)
        return false;
    for (long long k = 0; k < n; k++) {
        const saltus_event *event = &r->events[k];
        saltus_face face = saltus_system_face(source->system, event->face);
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

static void put_events(saltus_h5 *w, const saltus_source *source, int *integers, double *reals) {
    long long n = source->record->event_count;
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
         source->record->event_rows},
    };
    for (size_t k = 0; k < sizeof columns / sizeof columns[0]; k++)
        saltus_h5_dataset(w, group, &columns[k], n, scalar);
    if (type >= 0)
        H5Tclose(type);
    saltus_h5_close_group(group);
}

static void put_strobe(saltus_h5 *w, const saltus_record *r) {
    const saltus_h5_column states = {
        "states",
        "1",
        "states at phase 0 of the forcing, one row per recorded period, row k at time k",
        H5T_IEEE_F64LE,
        H5T_NATIVE_DOUBLE,
        r->strobe_states};
    hid_t group = saltus_h5_open_group(w, "strobe", "stroboscopic points");
    saltus_h5_dataset(w, group, &states, r->strobes, (const int[2]){r->dimension, 0});
    saltus_h5_close_group(group);
}

static void put_attributes(saltus_h5 *w, const saltus_source *source, const char *parameters) {
    const saltus_flow_options *o = source->options;
    const saltus_spec *spec = saltus_system_spec(source->system);
    saltus_h5_text(w, w->file, "version", SALTUS_VERSION);
    saltus_h5_text(w, w->file, "kind", "trajectory");
    saltus_h5_text(w, w->file, "scene", source->scene->name);
    saltus_h5_text(w, w->file, "title", source->scene->title);
    saltus_h5_text(w, w->file, "model", saltus_model_name(spec->model));
    saltus_h5_text(w, w->file, "parameters", parameters);
    saltus_h5_double(w, w->file, "period", saltus_system_period(source->system));
    saltus_h5_double(w, w->file, "rtol", o->rtol);
    saltus_h5_double(w, w->file, "atol", o->atol);
    saltus_h5_integer(w, w->file, "order", o->order);
    saltus_h5_text(w, w->file, "integrator", saltus_integrator_used(source->system, o->integrator));
}

static void write_file(const saltus_source *source, FILE *file, saltus_h5 *w) {
    long long n = source->record->event_count;
    char *parameters = parameter_text(saltus_system_spec(source->system));
    int *integers = malloc((size_t)(3 * n + 1) * sizeof *integers);
    double *reals = malloc((size_t)(3 * n + 1) * sizeof *reals);
    saltus_h5_create(w);
    if (saltus_h5_note_memory(w, parameters && split_events(source, integers, reals))) {
        put_attributes(w, source, parameters);
        saltus_h5_parameters(w, saltus_system_spec(source->system));
        put_trajectory(w, source);
        put_events(w, source, integers, reals);
        put_strobe(w, source->record);
    }
    saltus_h5_finish(w, file);
    free(parameters);
    free(integers);
    free(reals);
}

saltus_status saltus_record_hdf5(const saltus_source *source, FILE *file, saltus_message *message) {
    saltus_h5 w;
    saltus_h5_silence silence;
    if (!saltus_h5_quiet(&silence))
        return saltus_fail(message, SALTUS_IO, "the HDF5 library could not be opened");
    write_file(source, file, &w);
    saltus_h5_restore(&silence);
    return saltus_h5_status(&w, message);
}
