/* A record as an HDF5 file. The file is made in memory by HDF5's core driver and written as one piece, so a
 * full disk is an ordinary write error; time stamps are off, so equal records give equal files.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/describe.h"
#include "io/record.h"

#include <hdf5.h>
#include <stdlib.h>
#include <string.h>

/* A file under way. After the first failure nothing more is tried. */
typedef struct writer {
    hid_t file;
    bool sound;
} writer;

static bool note(writer *w, bool good) {
    return w->sound = w->sound && good;
}

static void put_attribute(writer *w, hid_t owner, const char *name, hid_t type, hid_t memory,
                          const void *value) {
    hid_t space = H5Screate(H5S_SCALAR);
    hid_t attribute = H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    note(w, attribute >= 0 && H5Awrite(attribute, memory, value) >= 0);
    if (attribute >= 0)
        note(w, H5Aclose(attribute) >= 0);
    if (space >= 0)
        H5Sclose(space);
}

static void put_text(writer *w, hid_t owner, const char *name, const char *text) {
    hid_t type = w->sound ? H5Tcopy(H5T_C_S1) : -1;
    if (!note(w, type >= 0))
        return;
    note(w, H5Tset_size(type, strlen(text) + 1) >= 0 && H5Tset_cset(type, H5T_CSET_UTF8) >= 0);
    if (w->sound)
        put_attribute(w, owner, name, type, type, text);
    H5Tclose(type);
}

static void put_double(writer *w, hid_t owner, const char *name, double value) {
    if (w->sound)
        put_attribute(w, owner, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

static void put_integer(writer *w, hid_t owner, const char *name, long long value) {
    if (w->sound)
        put_attribute(w, owner, name, H5T_STD_I64LE, H5T_NATIVE_LLONG, &value);
}

static hid_t open_group(writer *w, const char *name, const char *description) {
    hid_t group = w->sound ? H5Gcreate2(w->file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT) : -1;
    if (note(w, group >= 0))
        put_text(w, group, "description", description);
    return group;
}

static void close_group(hid_t group) {
    if (group >= 0)
        H5Gclose(group);
}

/* What a dataset is called and means. */
typedef struct column {
    const char *name, *units, *description;
    hid_t type, memory;
    const void *data;
} column;

/* Chunks of about 128 KiB, shuffled and deflated; empty datasets are stored plainly. */
static hid_t layout(writer *w, int rank, hsize_t rows, hsize_t width) {
    enum { chunk_bytes = 131072, level = 6 };
    hid_t list = H5Pcreate(H5P_DATASET_CREATE);
    if (!note(w, list >= 0))
        return list;
    note(w, H5Pset_obj_track_times(list, 0) >= 0);
    if (rows == 0)
        return list;
    hsize_t tall = chunk_bytes / (8 * width), chunk[2] = {tall < 1 ? 1 : tall > rows ? rows : tall, width};
    note(w, H5Pset_chunk(list, rank, chunk) >= 0 && H5Pset_shuffle(list) >= 0);
    if (H5Zfilter_avail(H5Z_FILTER_DEFLATE) > 0)
        note(w, H5Pset_deflate(list, level) >= 0);
    return list;
}

/* A dataset of `rows`, or rows x width when width is not 0. */
static void put_dataset(writer *w, hid_t group, const column *c, long long rows, int width) {
    if (!w->sound)
        return;
    hsize_t size[2] = {(hsize_t)rows, (hsize_t)width};
    int rank = width ? 2 : 1;
    hid_t list = layout(w, rank, size[0], width ? size[1] : 1), space = H5Screate_simple(rank, size, NULL);
    hid_t set = w->sound ? H5Dcreate2(group, c->name, c->type, space, H5P_DEFAULT, list, H5P_DEFAULT) : -1;
    if (note(w, set >= 0)) {
        note(w, rows == 0 || H5Dwrite(set, c->memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, c->data) >= 0);
        put_text(w, set, "units", c->units);
        put_text(w, set, "description", c->description);
        note(w, H5Dclose(set) >= 0);
    }
    if (space >= 0)
        H5Sclose(space);
    if (list >= 0)
        H5Pclose(list);
}

static void put_trajectory(writer *w, const saltus_source *source) {
    const saltus_record *r = source->record;
    hid_t real = H5T_IEEE_F64LE, native = H5T_NATIVE_DOUBLE;
    const column time = {"time", "T",    "time from the start of the recording in forcing periods",
                         real,   native, r->time};
    const column states = {
        "states", "1",    "displacements q, velocities q', further states, one row per sample",
        real,     native, r->states};
    const column displacement = {
        "displacement", "1",    "observed displacement (contact coordinate of the first stop)",
        real,           native, r->displacement};
    const column velocity = {"velocity", "1", "rate of the observed displacement", real, native, r->velocity};
    hid_t group = open_group(w, "trajectory", "samples, with one on each side of every impact");
    put_dataset(w, group, &time, r->samples, 0);
    put_dataset(w, group, &states, r->samples, r->dimension);
    put_dataset(w, group, &displacement, r->samples, 0);
    put_dataset(w, group, &velocity, r->samples, 0);
    close_group(group);
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

static hid_t kind_type(writer *w) {
    static const saltus_event_kind kinds[] = {SALTUS_IMPACT, SALTUS_STICK, SALTUS_RELEASE};
    hid_t type = H5Tenum_create(H5T_NATIVE_INT);
    note(w, type >= 0);
    for (int k = 0; k < 3 && w->sound; k++) {
        int value = (int)kinds[k];
        note(w, H5Tenum_insert(type, saltus_event_word(kinds[k]), &value) >= 0);
    }
    return type;
}

static void put_events(writer *w, const saltus_source *source, int *integers, double *reals) {
    long long n = source->record->event_count;
    hid_t group = open_group(w, "events", "impacts, begins of contact (stick) and releases, in order");
    hid_t type = kind_type(w), whole = H5T_STD_I32LE, real = H5T_IEEE_F64LE;
    const column columns[] = {
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
        put_dataset(w, group, &columns[k], n, 0);
    if (type >= 0)
        H5Tclose(type);
    close_group(group);
}

static void put_strobe(writer *w, const saltus_record *r) {
    const column states = {"states",
                           "1",
                           "states at phase 0 of the forcing, one row per recorded period, row k at time k",
                           H5T_IEEE_F64LE,
                           H5T_NATIVE_DOUBLE,
                           r->strobe_states};
    hid_t group = open_group(w, "strobe", "stroboscopic points");
    put_dataset(w, group, &states, r->strobes, r->dimension);
    close_group(group);
}

static void put_parameters(writer *w, const saltus_spec *spec) {
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    hid_t group = open_group(w, "parameters", "parameters of the model; one group for each stop");
    for (int k = 0; k < count; k++)
        put_double(w, group, p[k].name, spec->parameters[k]);
    close_group(group);
    for (int s = 0; s < spec->stop_count; s++) {
        char name[32];
        snprintf(name, sizeof name, "parameters/stop_%d", s + 1);
        group = open_group(w, name, "a rigid stop");
        if (strcmp(saltus_model_name(spec->model), "pipe") == 0)
            put_double(w, group, "xi", spec->stops[s].xi);
        else {
            put_double(w, group, "weight1", spec->stops[s].weight[0]);
            put_double(w, group, "weight2", spec->stops[s].weight[1]);
        }
        put_double(w, group, "d", spec->stops[s].d);
        put_double(w, group, "r", spec->stops[s].r);
        put_text(w, group, "sides", saltus_sides_word(spec->stops[s].sides));
        close_group(group);
    }
}

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

static void put_attributes(writer *w, const saltus_source *source, const char *parameters) {
    const saltus_flow_options *o = source->options;
    const saltus_spec *spec = saltus_system_spec(source->system);
    put_text(w, w->file, "version", SALTUS_VERSION);
    put_text(w, w->file, "content", "trajectory");
    put_text(w, w->file, "scene", source->scene->name);
    put_text(w, w->file, "title", source->scene->title);
    put_text(w, w->file, "model", saltus_model_name(spec->model));
    put_text(w, w->file, "parameters", parameters);
    put_double(w, w->file, "period", saltus_system_period(source->system));
    put_double(w, w->file, "rtol", o->rtol);
    put_double(w, w->file, "atol", o->atol);
    put_integer(w, w->file, "order", o->order);
    put_text(w, w->file, "integrator",
             o->integrator == SALTUS_AUTOMATIC ? saltus_system_integrator(source->system)
                                               : saltus_integrator_word(o->integrator));
}

/* The finished file's bytes; NULL on failure. */
static void *file_image(writer *w, size_t *length) {
    if (!note(w, H5Fflush(w->file, H5F_SCOPE_GLOBAL) >= 0))
        return NULL;
    ssize_t size = H5Fget_file_image(w->file, NULL, 0);
    void *image = size > 0 ? malloc((size_t)size) : NULL;
    if (note(w, image && H5Fget_file_image(w->file, image, (size_t)size) == size))
        *length = (size_t)size;
    return image;
}

static hid_t open_image(void) {
    enum { increment = 1 << 20 };
    hid_t access = H5Pcreate(H5P_FILE_ACCESS), file = -1;
    if (access >= 0 && H5Pset_fapl_core(access, increment, 0) >= 0)
        file = H5Fcreate("saltus", H5F_ACC_TRUNC, H5P_DEFAULT, access);
    if (access >= 0)
        H5Pclose(access);
    return file;
}

static void write_image(const saltus_source *source, FILE *file, writer *w) {
    long long n = source->record->event_count;
    char *parameters = parameter_text(saltus_system_spec(source->system));
    int *integers = malloc((size_t)(3 * n + 1) * sizeof *integers);
    double *reals = malloc((size_t)(3 * n + 1) * sizeof *reals);
    void *image = NULL;
    size_t length = 0;
    w->file = open_image();
    if (note(w, w->file >= 0 && parameters && split_events(source, integers, reals))) {
        put_attributes(w, source, parameters);
        put_parameters(w, saltus_system_spec(source->system));
        put_trajectory(w, source);
        put_events(w, source, integers, reals);
        put_strobe(w, source->record);
        image = file_image(w, &length);
    }
    if (w->file >= 0)
        note(w, H5Fclose(w->file) >= 0);
    if (w->sound)
        fwrite(image, 1, length, file);
    free(image);
    free(parameters);
    free(integers);
    free(reals);
}

saltus_status saltus_record_hdf5(const saltus_source *source, FILE *file, saltus_message *message) {
    writer w = {.sound = true};
    H5E_auto2_t print;
    void *context;
    if (H5open() < 0 || H5Eget_auto2(H5E_DEFAULT, &print, &context) < 0)
        return saltus_fail(message, SALTUS_IO, "the HDF5 library could not be opened");
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    write_image(source, file, &w);
    H5Eset_auto2(H5E_DEFAULT, print, context);
    return w.sound ? SALTUS_OK : saltus_fail(message, SALTUS_IO, "the HDF5 library could not make the file");
}
