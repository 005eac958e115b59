/* The building blocks of HDF5 files, and reading them back without trusting their contents.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/hdf5.h"

#include "record/describe.h"
#include "record/output.h"
#include "scene/scene.h"
#include "system/system.h"

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

static void put_attribute(saltus_h5 *w, hid_t owner, const char *name, hid_t type, hid_t memory,
                          const void *value) {
    hid_t space = H5Screate(H5S_SCALAR);
    hid_t attribute = H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    saltus_h5_note(w, attribute >= 0 && H5Awrite(attribute, memory, value) >= 0);
    if (attribute >= 0)
        saltus_h5_note(w, H5Aclose(attribute) >= 0);
    saltus_h5_close(space);
}

hid_t saltus_h5_text_type(size_t room, bool stored) {
    hid_t type = H5Tcopy(H5T_C_S1);
    if (type >= 0 && H5Tset_size(type, room) >= 0 && H5Tset_cset(type, H5T_CSET_UTF8) >= 0 &&
        (stored || H5Tset_strpad(type, H5T_STR_NULLPAD) >= 0))
        return type;
    saltus_h5_close(type);
    return -1;
}

void saltus_h5_text(saltus_h5 *w, hid_t owner, const char *name, const char *text) {
    hid_t type = w->sound ? saltus_h5_text_type(strlen(text) + 1, true) : -1;
    if (saltus_h5_note(w, type >= 0))
        put_attribute(w, owner, name, type, type, text);
    saltus_h5_close(type);
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

void saltus_h5_names(saltus_h5 *w, hid_t group, const char *set, const char *names) {
    hid_t found = w->sound ? H5Dopen2(group, set, H5P_DEFAULT) : -1;
    if (saltus_h5_note(w, found >= 0))
        saltus_h5_text(w, found, "names", names);
    saltus_h5_close(found);
}

void saltus_h5_close(hid_t object) {
    if (object >= 0)
        H5Idec_ref(object);
}

static void put_field(saltus_h5 *w, hid_t owner, const saltus_field *field, const void *record) {
    char text[SALTUS_FIELD_TEXT_MAX];
    if (field->type == SALTUS_REAL)
        saltus_h5_double(w, owner, field->name, saltus_field_number(field, record));
    else if (field->words || field->type == SALTUS_TEXT)
        saltus_h5_text(w, owner, field->name, saltus_field_text(field, record, text));
    else
        saltus_h5_integer(w, owner, field->name, saltus_field_whole(field, record));
}

/* Read an attribute with one entry; the caller closes `memory`. */
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

/* False if the attribute is absent, of another type, or not a valid value of the field. */
static bool get_field(hid_t owner, const saltus_field *field, void *record) {
    char text[SALTUS_FIELD_TEXT_MAX];
    double real;
    long long whole;
    if (field->type == SALTUS_REAL)
        return saltus_h5_get_double(owner, field->name, &real) &&
               saltus_field_set_number(field, real, record);
    if (field->words || field->type == SALTUS_TEXT)
        return saltus_h5_get_text(owner, field->name, text, sizeof text) &&
               saltus_field_read(field, text, record);
    return saltus_h5_get_integer(owner, field->name, &whole) && saltus_field_set_whole(field, whole, record);
}

void saltus_h5_options(saltus_h5 *w, hid_t owner, const saltus_option_table *table, const void *record) {
    for (int k = 0; k < table->count; k++)
        if (!table->options[k].apart)
            put_field(w, owner, &table->options[k].field, record);
}

const char *saltus_h5_get_options(hid_t owner, const saltus_option_table *table, void *record) {
    for (int k = 0; k < table->count; k++) {
        const saltus_option *o = &table->options[k];
        if (!o->apart && !(get_field(owner, &o->field, record) && saltus_option_admits(o, record)))
            return o->field.name;
    }
    return NULL;
}

#define STOP(member, name, meaning, ...) SALTUS_MEMBER(saltus_stop, member, name, "1", meaning, __VA_ARGS__)
#define WHAT_A_STOP_DOES                                                                                     \
    STOP(d, "d", "clearance", SALTUS_REAL), STOP(r, "r", "coefficient of restitution", SALTUS_REAL),         \
        STOP(sides, "sides", "where it is", SALTUS_CHOICE, .words = saltus_side_words)

/* The fields of a model's stops: where each acts, and its properties. */
static const saltus_field_table *stop_table(const saltus_model *model) {
    static const saltus_field position_fields[] = {STOP(xi, "xi", "position", SALTUS_REAL), WHAT_A_STOP_DOES},
                              weight_fields[] = {STOP(weight[0], "weight1", "of mass 1", SALTUS_REAL),
                                                 STOP(weight[1], "weight2", "of mass 2", SALTUS_REAL),
                                                 WHAT_A_STOP_DOES};
    static const saltus_field_table by_position = SALTUS_TABLE(position_fields),
                                    by_weights = SALTUS_TABLE(weight_fields);
    static const saltus_field text_fields[] = {WHAT_A_STOP_DOES};
    static const saltus_field_table by_text = SALTUS_TABLE(text_fields);
    if (saltus_model_text(model))
        return &by_text;
    return strcmp(saltus_model_stop_key(model), "xi") == 0 ? &by_position : &by_weights;
}

void saltus_h5_put_head(saltus_h5 *w, const char *kind, const char *scene, const char *title,
                        const saltus_spec *spec, bool complete) {
    saltus_h5_text(w, w->file, "kind", kind);
    saltus_h5_text(w, w->file, "version", SALTUS_VERSION);
    saltus_h5_text(w, w->file, "scene", scene);
    saltus_h5_text(w, w->file, "title", title);
    saltus_h5_text(w, w->file, "model", saltus_model_name(spec->model));
    if (saltus_model_text(spec->model))
        saltus_h5_text(w, w->file, "equations", saltus_model_text(spec->model));
    if (spec->observe[0])
        saltus_h5_text(w, w->file, "observe", spec->observe);
    /* The names of the state's entries, separated by blanks. */
    char names[SALTUS_STATE_MAX * sizeof(saltus_state_name)] = "";
    const int dimension = saltus_spec_dimension(spec, NULL);
    size_t used = 0;
    for (int i = 0; i < dimension; i++)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? " " : "",
                                 saltus_spec_state_name(spec, i).text);
    if (saltus_h5_note_memory(w, dimension >= 0))
        saltus_h5_text(w, w->file, "state", names);
    saltus_h5_integer(w, w->file, "complete", complete);
    const saltus_field_table *stop = stop_table(spec->model);
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
        for (int k = 0; k < stop->count; k++)
            put_field(w, group, &stop->fields[k], &spec->stops[s]);
        saltus_h5_close(group);
    }
}

/* FNV-1a checksum. It is stored behind the end of the file as HDF5 sees it, so a program that modifies the
 * file cuts it off. */
bool saltus_h5_seal(int descriptor, long long length, char seal[SALTUS_H5_SEAL + 1]) {
    enum { block = 1 << 16 };
    unsigned char bytes[block];
    uint64_t hash = 0xcbf29ce484222325u;
    for (long long done = 0; done < length;) {
        size_t wanted = length - done < block ? (size_t)(length - done) : block;
        if (saltus_read_at(descriptor, bytes, wanted, done) < wanted)
            return false;
        for (size_t k = 0; k < wanted; k++)
            hash = (hash ^ bytes[k]) * 0x100000001b3u;
        done += (long long)wanted;
    }
    snprintf(seal, SALTUS_H5_SEAL + 1, "saltus:%016llx\n", (unsigned long long)hash);
    return true;
}

bool saltus_h5_quiet(saltus_h5_silence *silence) {
    if (H5open() < 0 || H5Eget_auto2(H5E_DEFAULT, &silence->print, &silence->context) < 0)
        return false;
    return H5Eset_auto2(H5E_DEFAULT, NULL, NULL) >= 0;
}

void saltus_h5_restore(const saltus_h5_silence *silence) {
    H5Eset_auto2(H5E_DEFAULT, silence->print, silence->context);
}

bool saltus_h5_get_integer(hid_t owner, const char *name, long long *value) {
    return get_attribute(owner, name, H5T_INTEGER, H5T_NATIVE_LLONG, value);
}

bool saltus_h5_get_double(hid_t owner, const char *name, double *value) {
    return get_attribute(owner, name, H5T_FLOAT, H5T_NATIVE_DOUBLE, value);
}

bool saltus_h5_get_text(hid_t owner, const char *name, char *text, size_t room) {
    hid_t type = saltus_h5_text_type(room, false);
    bool fits = type >= 0 && get_attribute(owner, name, H5T_STRING, type, text);
    saltus_h5_close(type);
    if (!fits || text[room - 1])
        text[0] = '\0';
    return fits && !text[room - 1];
}

hid_t saltus_h5_find_group(hid_t file, const char *name) {
    return H5Lexists(file, name, H5P_DEFAULT) > 0 ? H5Gopen2(file, name, H5P_DEFAULT) : -1;
}

/* A file whose seal does not match its bytes is damaged and never passed to HDF5; a file without a seal is.
 */
saltus_status saltus_h5_reader_open(saltus_h5_reader *r) {
    struct stat facts = {.st_size = 0};
    char seal[SALTUS_H5_SEAL + 1], there[SALTUS_H5_SEAL];
    r->file = -1;
    if (!saltus_h5_quiet(&r->silence))
        return saltus_fail(r->message, SALTUS_IO, "the HDF5 library could not be opened");
    FILE *plain = fopen(r->path, "rb");
    const char *reason = plain ? NULL : strerror(errno);
    const int descriptor = plain ? fileno(plain) : -1;
    const bool folder = plain && fstat(descriptor, &facts) == 0 && S_ISDIR(facts.st_mode);
    bool sound = plain;
    if (S_ISREG(facts.st_mode) && facts.st_size > SALTUS_H5_SEAL) {
        const long long length = facts.st_size - SALTUS_H5_SEAL;
        sound = pread(descriptor, there, sizeof there, (off_t)length) == SALTUS_H5_SEAL &&
                (memcmp(there, "saltus:", 7) != 0 ||
                 (saltus_h5_seal(descriptor, length, seal) && memcmp(there, seal, sizeof there) == 0));
    }
    if (plain)
        fclose(plain);
    const bool known = sound && H5Fis_hdf5(r->path) > 0;
    r->file = known ? H5Fopen(r->path, H5F_ACC_RDONLY, H5P_DEFAULT) : -1;
    if (r->file >= 0)
        return SALTUS_OK;
    saltus_h5_restore(&r->silence);
    if (reason)
        return saltus_fail(r->message, SALTUS_BAD_INPUT, "%s: cannot be opened (%s)", r->path, reason);
    return saltus_fail(r->message, SALTUS_BAD_INPUT, "%s: %s", r->path,
                       folder            ? "is a folder, not a file"
                       : sound && !known ? "is no HDF5 file"
                                         : "is damaged or cut off");
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
        /* All values are present and finite. */
        const saltus_field_table *table = stop_table(model);
        saltus_stop *stop = &spec->stops[spec->stop_count];
        *stop = saltus_stop_defaults();
        group = H5Gopen2(r->file, name, H5P_DEFAULT);
        bool whole = group >= 0;
        for (int k = 0; k < table->count && whole; k++)
            whole = get_field(group, &table->fields[k], stop) &&
                    isfinite(saltus_field_number(&table->fields[k], stop));
        saltus_h5_close(group);
        if (!whole)
            return saltus_h5_refuse_part(r, name, "d, r, sides");
    }
    if (H5Aexists(r->file, "observe") > 0 &&
        !saltus_h5_get_text(r->file, "observe", spec->observe, sizeof spec->observe))
        return saltus_h5_refuse(r, "its attribute observe must be a name");
    return SALTUS_OK;
}

void saltus_h5_head_clear(saltus_h5_head *head) {
    saltus_model_release(head->spec.model);
    head->spec.model = NULL;
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
    /* The model: a built-in one, or built from the file's equations. */
    const saltus_model *model = saltus_model_find(head->model);
    saltus_message reason = {.text = ""};
    saltus_status status = SALTUS_OK;
    char *text = model ? NULL : malloc(SALTUS_MODEL_TEXT_MAX);
    if (!model && !text)
        return saltus_h5_no_memory(r);
    if (text && saltus_h5_get_text(r->file, "equations", text, SALTUS_MODEL_TEXT_MAX))
        status = saltus_model_of_text(text, &model, &reason);
    else if (text)
        status = saltus_fail(&reason, SALTUS_BAD_INPUT, "the model %.40s is not known", head->model);
    free(text);
    if (status != SALTUS_OK)
        return saltus_fail(r->message, status, "%s: %s", r->path, reason.text);
    status = get_parameters(r, model, &head->spec);
    if (status != SALTUS_OK)
        saltus_model_release(model);
    return status;
}
