/* Making HDF5 files, and reading them back with suspicion.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/hdf5.h"

#include "record/describe.h"
#include "record/output.h"

#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

bool saltus_h5_note(saltus_h5 *w, bool good) {
    return w->sound = w->sound && good;
}

bool saltus_h5_note_memory(saltus_h5 *w, bool there) {
    w->starved |= !there;
    return saltus_h5_note(w, there);
}

saltus_status saltus_h5_status(const saltus_h5 *w, saltus_message *message) {
    if (w->sound)
        return SALTUS_OK;
    return w->starved ? saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the file")
                      : saltus_fail(message, SALTUS_IO, "the HDF5 library could not make the file");
}

static void put_attribute(saltus_h5 *w, hid_t owner, const char *name, hid_t type, hid_t memory,
                          const void *value) {
    hid_t space = H5Screate(H5S_SCALAR);
    hid_t attribute = H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    saltus_h5_note(w, attribute >= 0 && H5Awrite(attribute, memory, value) >= 0);
    if (attribute >= 0)
        saltus_h5_note(w, H5Aclose(attribute) >= 0);
    saltus_h5_close(space);
}

void saltus_h5_text(saltus_h5 *w, hid_t owner, const char *name, const char *text) {
    hid_t type = w->sound ? H5Tcopy(H5T_C_S1) : -1;
    if (!saltus_h5_note(w, type >= 0))
        return;
    saltus_h5_note(w, H5Tset_size(type, strlen(text) + 1) >= 0 && H5Tset_cset(type, H5T_CSET_UTF8) >= 0);
    if (w->sound)
        put_attribute(w, owner, name, type, type, text);
    H5Tclose(type);
}

void saltus_h5_double(saltus_h5 *w, hid_t owner, const char *name, double value) {
    if (w->sound)
        put_attribute(w, owner, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void saltus_h5_integer(saltus_h5 *w, hid_t owner, const char *name, long long value) {
    if (w->sound)
        put_attribute(w, owner, name, H5T_STD_I64LE, H5T_NATIVE_LLONG, &value);
}

hid_t saltus_h5_open_group(saltus_h5 *w, const char *name, const char *description) {
    hid_t group = w->sound ? H5Gcreate2(w->file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT) : -1;
    if (saltus_h5_note(w, group >= 0))
        saltus_h5_text(w, group, "description", description);
    return group;
}

void saltus_h5_close(hid_t object) {
    if (object >= 0)
        H5Idec_ref(object);
}

static void put_filters(saltus_h5 *w, hid_t list) {
    enum { level = 6 };
    saltus_h5_note(w, H5Pset_shuffle(list) >= 0);
    if (H5Zfilter_avail(H5Z_FILTER_DEFLATE) > 0)
        saltus_h5_note(w, H5Pset_deflate(list, level) >= 0);
    saltus_h5_note(w, H5Pset_fletcher32(list) >= 0);
}

/* Chunks of about 128 KiB; empty datasets are stored plainly. */
static hid_t layout(saltus_h5 *w, int rank, const hsize_t size[3], size_t entry) {
    enum { chunk_bytes = 131072 };
    hid_t list = H5Pcreate(H5P_DATASET_CREATE);
    if (!saltus_h5_note(w, list >= 0))
        return list;
    saltus_h5_note(w, H5Pset_obj_track_times(list, 0) >= 0);
    if (size[0] == 0)
        return list;
    hsize_t chunk[3] = {size[0], size[1], size[2]}, tall = chunk_bytes / entry;
    for (int k = 1; k < rank; k++)
        tall /= size[k];
    chunk[0] = tall < 1 ? 1 : tall > size[0] ? size[0] : tall;
    saltus_h5_note(w, H5Pset_chunk(list, rank, chunk) >= 0);
    put_filters(w, list);
    return list;
}

void saltus_h5_dataset(saltus_h5 *w, hid_t group, const saltus_h5_column *c, long long rows,
                       const int width[2]) {
    if (!w->sound)
        return;
    hsize_t size[3] = {(hsize_t)rows, (hsize_t)width[0], (hsize_t)width[1]};
    hsize_t most[3] = {rows ? H5S_UNLIMITED : 0, size[1], size[2]};
    int rank = 1 + (width[0] > 0) + (width[1] > 0);
    hid_t list = layout(w, rank, size, H5Tget_size(c->type)), space = H5Screate_simple(rank, size, most);
    hid_t set = w->sound ? H5Dcreate2(group, c->name, c->type, space, H5P_DEFAULT, list, H5P_DEFAULT) : -1;
    if (saltus_h5_note(w, set >= 0)) {
        saltus_h5_note(w, rows == 0 || H5Dwrite(set, c->memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, c->data) >= 0);
        saltus_h5_text(w, set, "units", c->units);
        saltus_h5_text(w, set, "description", c->description);
        saltus_h5_note(w, H5Dclose(set) >= 0);
    }
    saltus_h5_close(space);
    saltus_h5_close(list);
}

/* Storage of a dataset that is written in parts: one chunk for each part. */
static hid_t part_layout(saltus_h5 *w, const saltus_h5_column *c, const saltus_h5_shape *shape) {
    hid_t list = H5Pcreate(H5P_DATASET_CREATE);
    if (!saltus_h5_note(w, list >= 0))
        return list;
    saltus_h5_note(w, H5Pset_obj_track_times(list, 0) >= 0 &&
                          H5Pset_chunk(list, shape->rank, shape->part) >= 0 &&
                          H5Pset_fill_value(list, c->memory, c->data) >= 0);
    put_filters(w, list);
    return list;
}

hid_t saltus_h5_open_dataset(saltus_h5 *w, hid_t group, const saltus_h5_column *c,
                             const saltus_h5_shape *shape) {
    if (!w->sound)
        return -1;
    hid_t list = part_layout(w, c, shape), space = H5Screate_simple(shape->rank, shape->size, NULL);
    /* Each part is written once and whole, so HDF5 need not keep any chunk in memory. */
    hid_t access = H5Pcreate(H5P_DATASET_ACCESS), set = -1;
    if (saltus_h5_note(w, space >= 0 && access >= 0 && H5Pset_chunk_cache(access, 1, 0, 1) >= 0))
        set = H5Dcreate2(group, c->name, c->type, space, H5P_DEFAULT, list, access);
    if (saltus_h5_note(w, set >= 0)) {
        saltus_h5_text(w, set, "units", c->units);
        saltus_h5_text(w, set, "description", c->description);
    }
    saltus_h5_close(access);
    saltus_h5_close(space);
    saltus_h5_close(list);
    return set;
}

void saltus_h5_write_part(saltus_h5 *w, hid_t set, hid_t memory, const hsize_t *first, const hsize_t *count,
                          const void *data) {
    hid_t place = w->sound ? H5Dget_space(set) : -1;
    if (!saltus_h5_note(w, place >= 0))
        return;
    hid_t here = H5Screate_simple(H5Sget_simple_extent_ndims(place), count, NULL);
    saltus_h5_note(w, here >= 0 &&
                          H5Sselect_hyperslab(place, H5S_SELECT_SET, first, NULL, count, NULL) >= 0 &&
                          H5Dwrite(set, memory, here, place, H5P_DEFAULT, data) >= 0);
    saltus_h5_close(here);
    H5Sclose(place);
}

hid_t saltus_h5_enumeration(saltus_h5 *w, hid_t base, const char *const *words, const int *values,
                            int count) {
    hid_t type = H5Tenum_create(base);
    saltus_h5_note(w, type >= 0);
    for (int k = 0; k < count && w->sound; k++) {
        int value = values ? values[k] : k;
        signed char narrow = (signed char)value;
        saltus_h5_note(
            w, H5Tenum_insert(type, words[k], H5Tget_size(base) == 1 ? (const void *)&narrow : &value) >= 0);
    }
    return type;
}

void saltus_h5_reals(saltus_h5 *w, hid_t group, const char *name, const char *description,
                     const double *values, int count) {
    const saltus_h5_column column = {name, "1", description, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values};
    saltus_h5_dataset(w, group, &column, count, (const int[2]){0, 0});
}

/* What the k-th of `count` numbers that place a stop is called: the key, with a number where there are
 * several. */
static const char *place_name(const saltus_model *model, int k, int count, char name[32]) {
    if (count > 1)
        snprintf(name, 32, "%s%d", saltus_model_stop_key(model), k + 1);
    else
        snprintf(name, 32, "%s", saltus_model_stop_key(model));
    return name;
}

void saltus_h5_parameters(saltus_h5 *w, const saltus_spec *spec) {
    int count;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    hid_t group = saltus_h5_open_group(w, "parameters", "parameters of the model; one group for each stop");
    for (int k = 0; k < count; k++)
        saltus_h5_double(w, group, p[k].name, spec->parameters[k]);
    saltus_h5_close(group);
    for (int s = 0; s < spec->stop_count; s++) {
        char name[32];
        snprintf(name, sizeof name, "parameters/stop_%d", s + 1);
        group = saltus_h5_open_group(w, name, "a rigid stop");
        int numbers;
        const double *place = saltus_stop_place(spec->model, &spec->stops[s], &numbers);
        for (int k = 0; k < numbers; k++)
            saltus_h5_double(w, group, place_name(spec->model, k, numbers, name), place[k]);
        saltus_h5_double(w, group, "d", spec->stops[s].d);
        saltus_h5_double(w, group, "r", spec->stops[s].r);
        saltus_h5_text(w, group, "sides", saltus_sides_word(spec->stops[s].sides));
        saltus_h5_close(group);
    }
}

static const uint64_t digest_begin = 0xcbf29ce484222325u;

/* The checksum FNV-1a, continued over more bytes from `hash`, that of the bytes before them. */
static uint64_t digest(uint64_t hash, const unsigned char *bytes, size_t length) {
    for (size_t k = 0; k < length; k++)
        hash = (hash ^ bytes[k]) * 0x100000001b3u;
    return hash;
}

/* The seal stands after the end of the file that HDF5 knows: another program that changes the file cuts it
 * off. */
static void write_seal(uint64_t hash, char seal[SALTUS_H5_SEAL + 1]) {
    snprintf(seal, SALTUS_H5_SEAL + 1, "saltus:%016llx\n", (unsigned long long)hash);
}

bool saltus_h5_seal(int descriptor, long long length, char seal[SALTUS_H5_SEAL + 1]) {
    enum { block = 1 << 16 };
    unsigned char bytes[block];
    uint64_t hash = digest_begin;
    for (long long done = 0; done < length;) {
        size_t wanted = length - done < block ? (size_t)(length - done) : block;
        if (saltus_read_at(descriptor, bytes, wanted, done) < wanted)
            return false;
        hash = digest(hash, bytes, wanted);
        done += (long long)wanted;
    }
    write_seal(hash, seal);
    return true;
}

void saltus_h5_finish(saltus_h5 *w, FILE *file) {
    ssize_t size = -1;
    if (saltus_h5_note(w, w->sound && H5Fflush(w->file, H5F_SCOPE_GLOBAL) >= 0))
        size = H5Fget_file_image(w->file, NULL, 0);
    unsigned char *image = size > 0 ? malloc((size_t)size) : NULL;
    saltus_h5_note_memory(w, image || size <= 0);
    if (saltus_h5_note(w, image && H5Fget_file_image(w->file, image, (size_t)size) == size)) {
        char seal[SALTUS_H5_SEAL + 1];
        write_seal(digest(digest_begin, image, (size_t)size), seal);
        fwrite(image, 1, (size_t)size, file);
        fwrite(seal, 1, SALTUS_H5_SEAL, file);
    }
    free(image);
    if (w->file >= 0)
        saltus_h5_note(w, H5Fclose(w->file) >= 0);
    w->file = -1;
}

void saltus_h5_create(saltus_h5 *w) {
    enum { increment = 1 << 20 };
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    *w = (saltus_h5){.file = -1, .sound = true};
    if (access >= 0 && H5Pset_fapl_core(access, increment, 0) >= 0)
        w->file = H5Fcreate("saltus", H5F_ACC_TRUNC, H5P_DEFAULT, access);
    saltus_h5_note(w, w->file >= 0);
    saltus_h5_close(access);
}

bool saltus_h5_quiet(saltus_h5_silence *silence) {
    if (H5open() < 0 || H5Eget_auto2(H5E_DEFAULT, &silence->print, &silence->context) < 0)
        return false;
    return H5Eset_auto2(H5E_DEFAULT, NULL, NULL) >= 0;
}

void saltus_h5_restore(const saltus_h5_silence *silence) {
    H5Eset_auto2(H5E_DEFAULT, silence->print, silence->context);
}

/* Whether a file's seal, if it has one, is that of its bytes. HDF5 itself is not made to read damaged files.
 */
static bool undamaged(FILE *file) {
    struct stat facts;
    char seal[SALTUS_H5_SEAL + 1], there[SALTUS_H5_SEAL];
    int descriptor = fileno(file);
    long long length = fstat(descriptor, &facts) == 0 && S_ISREG(facts.st_mode) ? facts.st_size : 0;
    if (length <= SALTUS_H5_SEAL)
        return true;
    length -= SALTUS_H5_SEAL;
    if (pread(descriptor, there, sizeof there, (off_t)length) != SALTUS_H5_SEAL)
        return false;
    return memcmp(there, "saltus:", 7) != 0 ||
           (saltus_h5_seal(descriptor, length, seal) && memcmp(there, seal, sizeof there) == 0);
}

/* Open a file for reading; negative after a sentence in the message. */
static hid_t read_file(const char *path, saltus_message *message) {
    FILE *plain = fopen(path, "rb");
    int reason = errno;
    if (!plain) {
        saltus_fail(message, SALTUS_BAD_INPUT, "%s: cannot be opened (%s)", path, strerror(reason));
        return -1;
    }
    bool sound = undamaged(plain);
    fclose(plain);
    bool known = sound && H5Fis_hdf5(path) > 0;
    hid_t file = known ? H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT) : -1;
    if (file < 0)
        saltus_fail(message, SALTUS_BAD_INPUT, "%s: %s", path,
                    sound && !known ? "is no HDF5 file" : "is damaged or cut off");
    return file;
}

/* Read an attribute of one entry; `memory` is closed by the caller. */
static bool get_attribute(hid_t owner, const char *name, H5T_class_t class, hid_t memory, void *value) {
    hid_t attribute = H5Aexists(owner, name) > 0 ? H5Aopen(owner, name, H5P_DEFAULT) : -1;
    if (attribute < 0)
        return false;
    hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
    bool fits = type >= 0 && space >= 0 && H5Tget_class(type) == class &&
                H5Sget_simple_extent_npoints(space) == 1 &&
                (class != H5T_STRING || H5Tis_variable_str(type) == 0);
    fits = fits && H5Aread(attribute, memory, value) >= 0;
    saltus_h5_close(type);
    saltus_h5_close(space);
    H5Aclose(attribute);
    return fits;
}

bool saltus_h5_get_double(hid_t owner, const char *name, double *value) {
    return get_attribute(owner, name, H5T_FLOAT, H5T_NATIVE_DOUBLE, value);
}

bool saltus_h5_get_integer(hid_t owner, const char *name, long long *value) {
    return get_attribute(owner, name, H5T_INTEGER, H5T_NATIVE_LLONG, value);
}

hid_t saltus_h5_text_memory(size_t room) {
    hid_t type = H5Tcopy(H5T_C_S1);
    if (type >= 0 && H5Tset_size(type, room) >= 0 && H5Tset_cset(type, H5T_CSET_UTF8) >= 0 &&
        H5Tset_strpad(type, H5T_STR_NULLPAD) >= 0)
        return type;
    saltus_h5_close(type);
    return -1;
}

bool saltus_h5_get_text(hid_t owner, const char *name, char *text, size_t room) {
    hid_t type = saltus_h5_text_memory(room);
    bool fits = type >= 0 && get_attribute(owner, name, H5T_STRING, type, text);
    saltus_h5_close(type);
    if (!fits || text[room - 1])
        text[0] = '\0';
    return fits && !text[room - 1];
}

/* Open a dataset and its extent; the rank, or -1. */
static int open_extent(hid_t file, const char *name, hid_t *set, hsize_t size[SALTUS_H5_RANK_MAX]) {
    *set = H5Lexists(file, name, H5P_DEFAULT) > 0 ? H5Dopen2(file, name, H5P_DEFAULT) : -1;
    hid_t space = *set >= 0 ? H5Dget_space(*set) : -1;
    int rank = space >= 0 ? H5Sget_simple_extent_ndims(space) : -1;
    if (rank < 1 || rank > SALTUS_H5_RANK_MAX || H5Sget_simple_extent_dims(space, size, NULL) != rank)
        rank = -1;
    saltus_h5_close(space);
    return rank;
}

int saltus_h5_extent(hid_t file, const char *name, hsize_t size[SALTUS_H5_RANK_MAX], hsize_t *stored) {
    hid_t set;
    int rank = open_extent(file, name, &set, size);
    *stored = rank < 0 ? 0 : H5Dget_storage_size(set);
    saltus_h5_close(set);
    return rank;
}

long long saltus_h5_rows(hid_t file, const char *name) {
    hsize_t size[SALTUS_H5_RANK_MAX] = {0}, stored;
    return saltus_h5_extent(file, name, size, &stored) < 0 ? -1 : (long long)size[0];
}

bool saltus_h5_believable(hsize_t entries, hsize_t width, hsize_t stored) {
    const hsize_t most_entries = (hsize_t)1 << 40, per_row = width ? width : 1;
    return entries <= most_entries / per_row && entries * per_row / 1024 <= stored;
}

bool saltus_h5_get_array(hid_t file, const char *name, hid_t memory, int rank, const hsize_t *size,
                         void *data) {
    hid_t set;
    hsize_t there[SALTUS_H5_RANK_MAX] = {0}, entries = 1;
    bool fits = open_extent(file, name, &set, there) == rank;
    for (int k = 0; k < rank && fits; k++) {
        fits = there[k] == size[k];
        entries = size[k] ? entries : 0;
    }
    hid_t type = fits ? H5Dget_type(set) : -1;
    fits = type >= 0 && H5Tget_class(type) == H5Tget_class(memory) &&
           (H5Tget_class(memory) != H5T_STRING || H5Tis_variable_str(type) == 0);
    fits = fits && (entries == 0 || H5Dread(set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0);
    saltus_h5_close(type);
    saltus_h5_close(set);
    return fits;
}

bool saltus_h5_get_dataset(hid_t file, const char *name, hid_t memory, long long rows, const int width[2],
                           void *data) {
    const hsize_t size[3] = {(hsize_t)rows, (hsize_t)width[0], (hsize_t)width[1]};
    return saltus_h5_get_array(file, name, memory, 1 + (width[0] > 0) + (width[1] > 0), size, data);
}

hid_t saltus_h5_find_group(hid_t file, const char *name) {
    return H5Lexists(file, name, H5P_DEFAULT) > 0 ? H5Gopen2(file, name, H5P_DEFAULT) : -1;
}

static bool get_stop(hid_t file, const char *name, const saltus_model *model, saltus_stop *stop) {
    char sides[16] = "", number[32];
    int k = SALTUS_UPPER, numbers;
    hid_t group = H5Gopen2(file, name, H5P_DEFAULT);
    if (group < 0)
        return false;
    *stop = saltus_stop_defaults();
    double *place = (double *)saltus_stop_place(model, stop, &numbers);
    bool whole = true;
    for (int i = 0; i < numbers && whole; i++)
        whole = saltus_h5_get_double(group, place_name(model, i, numbers, number), &place[i]);
    whole = whole && saltus_h5_get_double(group, "d", &stop->d) &&
            saltus_h5_get_double(group, "r", &stop->r) &&
            saltus_h5_get_text(group, "sides", sides, sizeof sides);
    H5Gclose(group);
    while (k <= SALTUS_BOTH && strcmp(sides, saltus_sides_word((saltus_sides)k)) != 0)
        k++;
    stop->sides = (saltus_sides)k;
    return whole && k <= SALTUS_BOTH && isfinite(stop->xi) && isfinite(stop->weight[0]) &&
           isfinite(stop->weight[1]) && isfinite(stop->d) && isfinite(stop->r);
}

saltus_status saltus_h5_reader_open(saltus_h5_reader *r) {
    r->file = -1;
    if (!saltus_h5_quiet(&r->silence))
        return saltus_fail(r->message, SALTUS_IO, "the HDF5 library could not be opened");
    r->file = read_file(r->path, r->message);
    if (r->file >= 0)
        return SALTUS_OK;
    saltus_h5_restore(&r->silence);
    return SALTUS_BAD_INPUT;
}

void saltus_h5_reader_close(saltus_h5_reader *r) {
    if (r->file < 0)
        return;
    H5Fclose(r->file);
    saltus_h5_restore(&r->silence);
}

saltus_status saltus_h5_refuse(const saltus_h5_reader *r, const char *what) {
    return saltus_fail(r->message, SALTUS_BAD_INPUT, "%s: is not a sound %s file: %s", r->path, r->kind,
                       what);
}

saltus_status saltus_h5_refuse_part(const saltus_h5_reader *r, const char *group, const char *name) {
    return saltus_fail(r->message, SALTUS_BAD_INPUT,
                       "%s: is not a sound %s file: %s/%s is missing or not as it should be", r->path,
                       r->kind, group, name);
}

saltus_status saltus_h5_no_memory(const saltus_h5_reader *r) {
    return saltus_fail(r->message, SALTUS_NO_MEMORY, "no memory for reading %s", r->path);
}

static saltus_status get_parameters(const saltus_h5_reader *r, const saltus_model *model, saltus_spec *spec) {
    int count;
    const saltus_parameter *p = saltus_model_parameters(model, &count);
    const char *lacking = NULL;
    *spec = saltus_spec_defaults(model);
    hid_t group = saltus_h5_find_group(r->file, "parameters");
    if (group < 0)
        return saltus_h5_refuse(r, "the group /parameters is missing");
    for (int k = 0; k < count && !lacking; k++)
        if (!saltus_h5_get_double(group, p[k].name, &spec->parameters[k]) || !isfinite(spec->parameters[k]))
            lacking = p[k].name;
    H5Gclose(group);
    if (lacking)
        return saltus_h5_refuse_part(r, "parameters", lacking);
    for (; spec->stop_count < SALTUS_STOPS_MAX; spec->stop_count++) {
        char name[32];
        snprintf(name, sizeof name, "parameters/stop_%d", spec->stop_count + 1);
        if (H5Lexists(r->file, name, H5P_DEFAULT) <= 0)
            break;
        if (!get_stop(r->file, name, model, &spec->stops[spec->stop_count]))
            return saltus_h5_refuse_part(r, name, "d, r, sides");
    }
    return SALTUS_OK;
}

saltus_status saltus_h5_get_head(const saltus_h5_reader *r, const char *other_kind, const char *called,
                                 saltus_h5_head *head) {
    const struct {
        const char *name;
        char *text;
        size_t room;
    } texts[] = {{"version", head->version, sizeof head->version},
                 {"scene", head->scene, sizeof head->scene},
                 {"title", head->title, sizeof head->title},
                 {"model", head->model, sizeof head->model}};
    long long complete = 0;
    if (!saltus_h5_get_text(r->file, "kind", head->kind, sizeof head->kind))
        return saltus_fail(r->message, SALTUS_BAD_INPUT, "%s: is an HDF5 file, but not one of Saltus",
                           r->path);
    if (strcmp(head->kind, r->kind) != 0 && strcmp(head->kind, other_kind) != 0)
        return saltus_fail(r->message, SALTUS_BAD_INPUT, "%s: holds a %s, not a %s", r->path, head->kind,
                           called);
    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++)
        if (!saltus_h5_get_text(r->file, texts[k].name, texts[k].text, texts[k].room))
            return saltus_fail(r->message, SALTUS_BAD_INPUT,
                               "%s: is not a sound %s file: its attribute %s must be a text of fixed length "
                               "with at most %d bytes",
                               r->path, r->kind, texts[k].name, (int)texts[k].room - 1);
    if (!saltus_h5_get_integer(r->file, "complete", &complete))
        return saltus_h5_refuse(r, "its attribute complete must be a whole number");
    head->complete = complete != 0;
    if (!saltus_model_find(head->model))
        return saltus_fail(r->message, SALTUS_BAD_INPUT, "%s: the model %.40s is not known", r->path,
                           head->model);
    return get_parameters(r, saltus_model_find(head->model), &head->spec);
}
