/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "forge.h"

#include "record/hdf5.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What the stream can do to an item. */
typedef enum forge_change {
    change_drop,
    change_type,
    change_rank,
    change_size,
    change_value,
    change_bytes,
    change_unend,
    change_kind,
    changes
} forge_change;

enum { edits_max = 24, written_most = 1 << 16 };

unsigned forge_byte(forge_stream *stream) {
    return stream->at < stream->end ? *stream->at++ : 0;
}

static forge_item *add_item(forge_file *file, forge_kind kind, const char *owner, const char *name) {
    if (file->count == FORGE_ITEMS_MAX)
        return NULL;
    forge_item *item = &file->items[file->count++];
    *item = (forge_item){.kind = kind, .type = -1};
    snprintf(item->owner, sizeof item->owner, "%s", owner);
    snprintf(item->name, sizeof item->name, "%s", name);
    return item;
}

static bool take_shape(forge_item *item, hid_t space) {
    item->rank = H5Sget_simple_extent_ndims(space);
    bool sound = item->rank >= 0 && item->rank <= FORGE_RANK_MAX &&
                 H5Sget_simple_extent_dims(space, item->size, NULL) == item->rank;
    hssize_t entries = H5Sget_simple_extent_npoints(space);
    item->length = sound && entries >= 0 ? (size_t)entries * H5Tget_size(item->type) : 0;
    item->bytes = calloc(item->length + 1, 1);
    H5Sclose(space);
    return sound && item->bytes;
}

/* Where the iteration is. */
typedef struct place {
    forge_file *file;
    char path[64];
} place;

static herr_t take_attribute(hid_t owner, const char *name, const H5A_info_t *info, void *context) {
    place *p = context;
    forge_item *item = add_item(p->file, FORGE_ATTRIBUTE, p->path, name);
    hid_t attribute = H5Aopen(owner, name, H5P_DEFAULT);
    (void)info;
    if (!item || attribute < 0)
        return -1;
    item->type = H5Aget_type(attribute);
    bool sound =
        take_shape(item, H5Aget_space(attribute)) && H5Aread(attribute, item->type, item->bytes) >= 0;
    H5Aclose(attribute);
    return sound ? 0 : -1;
}

static bool take_attributes(hid_t object, place *p) {
    hsize_t at = 0;
    return H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, &at, take_attribute, p) >= 0;
}

static herr_t take_object(hid_t owner, const char *name, const H5L_info_t *info, void *context);

static bool take_group(hid_t group, place *p) {
    hsize_t at = 0;
    return take_attributes(group, p) &&
           H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, &at, take_object, p) >= 0;
}

/* A group with all that is in it, or a dataset; the attributes of datasets are for people. */
static herr_t take_object(hid_t owner, const char *name, const H5L_info_t *info, void *context) {
    place *outer = context, inner = {.file = outer->file};
    hid_t object = H5Oopen(owner, name, H5P_DEFAULT);
    bool group = H5Iget_type(object) == H5I_GROUP, sound = false;
    forge_item *item = add_item(outer->file, group ? FORGE_GROUP : FORGE_DATASET, outer->path, name);
    (void)info;
    snprintf(inner.path, sizeof inner.path, "%.40s%s%.20s", outer->path, outer->path[0] ? "/" : "", name);
    if (object >= 0 && item && group)
        sound = take_group(object, &inner);
    else if (object >= 0 && item) {
        item->type = H5Dget_type(object);
        sound = take_shape(item, H5Dget_space(object)) &&
                (item->length == 0 ||
                 H5Dread(object, item->type, H5S_ALL, H5S_ALL, H5P_DEFAULT, item->bytes) >= 0);
    }
    H5Oclose(object);
    return sound ? 0 : -1;
}

bool forge_read(const char *path, forge_file *file) {
    place root = {.file = file};
    file->count = 0;
    hid_t from = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    bool sound = from >= 0 && take_group(from, &root);
    if (from >= 0)
        H5Fclose(from);
    return sound;
}

/* Numbers that are likely to be wrong, whole ones and others. */
static void put_value(unsigned which, unsigned char *to, size_t room, bool real) {
    static const long long whole[] = {0,         1,         -1,           2,
                                      3,         7,         255,          -2,
                                      4096,      1LL << 31, -(1LL << 31), (1LL << 31) - 1,
                                      1LL << 62, INT64_MAX, INT64_MIN,    1000000000};
    static const double reals[] = {0,   1,   -1,    0.5,  1e-300,          -1e300, 1e300, 1e18,
                                   1e9, 1e6, 2.5e9, 1e15, 1 - DBL_EPSILON, 42,     NAN,   INFINITY};
    const void *from = real ? (const void *)&reals[which % 16] : &whole[which % 16];
    memcpy(to, from, room < 8 ? room : 8);
}

static hid_t text_type(size_t length, H5T_str_t end) {
    hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, length);
    H5Tset_strpad(type, end);
    return type;
}

static hid_t other_enumeration(void) {
    hid_t type = H5Tenum_create(H5T_STD_I32LE);
    const char *const words[] = {"periodic", "regular", "impact", "FALSE", "unheard-of"};
    for (int k = 0; k < 5; k++)
        H5Tenum_insert(type, words[k], &(int){4 - k});
    return type;
}

static hid_t compound_type(void) {
    hid_t type = H5Tcreate(H5T_COMPOUND, 8);
    H5Tinsert(type, "value", 0, H5T_IEEE_F64LE);
    return type;
}

/* Any type that a file may have where another is expected. */
static hid_t type_at(unsigned which) {
    const hid_t plain[] = {H5T_IEEE_F64LE, H5T_IEEE_F32LE, H5T_STD_I32LE,  H5T_STD_I64LE,
                           H5T_STD_I8LE,   H5T_STD_U64LE,  H5T_IEEE_F64BE, H5T_STD_B8LE};
    const hsize_t two = 2;
    switch (which % 16) {
    case 8:
        return text_type(1, H5T_STR_NULLTERM);
    case 9:
        return text_type(300, H5T_STR_NULLPAD);
    case 10:
        return text_type(8, H5T_STR_SPACEPAD);
    case 11:
        return text_type(H5T_VARIABLE, H5T_STR_NULLTERM);
    case 12:
        return other_enumeration();
    case 13:
        return compound_type();
    case 14:
        return H5Tarray_create2(H5T_IEEE_F64LE, 1, &two);
    case 15:
        return H5Tcreate(H5T_OPAQUE, 8);
    default:
        return H5Tcopy(plain[which % 16]);
    }
}

/* Entries times bytes; what is not written is only claimed. */
static double claimed(const forge_item *item) {
    double length = (double)H5Tget_size(item->type);
    for (int k = 0; k < item->rank; k++)
        length *= (double)item->size[k];
    return length;
}

/* As many bytes as the shape wants, those that were there over and over again. */
static bool fit_bytes(forge_item *item) {
    double wanted = claimed(item);
    size_t length = wanted <= written_most ? (size_t)wanted : 0;
    unsigned char *bytes = calloc(length + 1, 1);
    for (size_t k = 0; bytes && k < length && item->length; k++)
        bytes[k] = item->bytes[k % item->length];
    free(item->bytes);
    item->bytes = bytes;
    item->length = length;
    return bytes != NULL;
}

static void change_shape(forge_item *item, forge_change change, forge_stream *stream) {
    static const hsize_t sizes[] = {0,  1,   2,    3,        4,         5,        7,          10,
                                    16, 161, 4096, 1u << 20, 100000000, 1u << 31, 1ull << 40, 1ull << 61};
    if (change == change_rank) {
        int rank = (int)(forge_byte(stream) % (FORGE_RANK_MAX + 1));
        for (int k = item->rank; k < rank; k++)
            item->size[k] = 1;
        item->rank = rank;
    } else if (item->rank)
        item->size[forge_byte(stream) % (unsigned)item->rank] = sizes[forge_byte(stream) % 16];
}

static void change_data(forge_item *item, forge_change change, forge_stream *stream) {
    size_t entry = H5Tget_size(item->type);
    if (item->length < entry || !entry)
        return;
    size_t at = (forge_byte(stream) << 8 | forge_byte(stream)) % (item->length / entry) * entry;
    if (change == change_value)
        put_value(forge_byte(stream), item->bytes + at, entry, H5Tget_class(item->type) == H5T_FLOAT);
    else
        for (size_t k = at, count = forge_byte(stream) % 16 + 1; count && k < item->length; k++, count--)
            item->bytes[k] = (unsigned char)forge_byte(stream);
}

/* One change of one item; false when there is no memory. */
static bool edit(forge_item *item, bool *dropped, forge_stream *stream) {
    forge_change change = (forge_change)(forge_byte(stream) % changes);
    if (change == change_drop)
        *dropped = true;
    else if (change == change_kind) {
        static const forge_kind next[] = {FORGE_DATASET, FORGE_DATASET, FORGE_GROUP};
        item->kind = next[item->kind];
        item->type = item->type < 0 ? H5Tcopy(H5T_IEEE_F64LE) : item->type;
        return fit_bytes(item);
    } else if (item->type < 0)
        return true;
    else if (change == change_type) {
        H5Tclose(item->type);
        item->type = type_at(forge_byte(stream));
        return fit_bytes(item);
    } else if (change == change_rank || change == change_size) {
        change_shape(item, change, stream);
        return fit_bytes(item);
    } else if (change == change_unend)
        memset(item->bytes, 'x', item->length);
    else
        change_data(item, change, stream);
    return true;
}

static bool has_pointers(hid_t type) {
    return H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) > 0;
}

static void write_item(hid_t file, const forge_item *item) {
    hid_t owner =
        item->owner[0] ? H5Gopen2(file, item->owner, H5P_DEFAULT) : H5Gopen2(file, "/", H5P_DEFAULT);
    if (owner < 0)
        return;
    if (item->kind == FORGE_GROUP) {
        hid_t group = H5Gcreate2(owner, item->name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
        if (group >= 0)
            H5Gclose(group);
        H5Gclose(owner);
        return;
    }
    hid_t space = item->rank ? H5Screate_simple(item->rank, item->size, NULL) : H5Screate(H5S_SCALAR);
    bool write = item->length > 0 && !has_pointers(item->type);
    if (space >= 0 && item->kind == FORGE_ATTRIBUTE && claimed(item) <= 32768) {
        hid_t made = H5Acreate2(owner, item->name, item->type, space, H5P_DEFAULT, H5P_DEFAULT);
        if (made >= 0 && write)
            H5Awrite(made, item->type, item->bytes);
        if (made >= 0)
            H5Aclose(made);
    } else if (space >= 0 && item->kind == FORGE_DATASET) {
        hid_t made = H5Dcreate2(owner, item->name, item->type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
        if (made >= 0 && write)
            H5Dwrite(made, item->type, H5S_ALL, H5S_ALL, H5P_DEFAULT, item->bytes);
        if (made >= 0)
            H5Dclose(made);
    }
    if (space >= 0)
        H5Sclose(space);
    H5Gclose(owner);
}

/* Copies of all items, changed. */
static bool change_all(const forge_file *file, forge_stream *stream, forge_file *made, bool *dropped) {
    *made = *file;
    for (int k = 0; k < made->count; k++) {
        forge_item *item = &made->items[k];
        item->type = item->type >= 0 ? H5Tcopy(item->type) : -1;
        item->bytes = calloc(item->length + 1, 1);
        dropped[k] = false;
        if (item->bytes && item->length)
            memcpy(item->bytes, file->items[k].bytes, item->length);
    }
    bool sound = true;
    for (int k = 0; k < edits_max && stream->at < stream->end && sound; k++) {
        unsigned which = forge_byte(stream) % (unsigned)made->count;
        sound = edit(&made->items[which], &dropped[which], stream);
    }
    return sound;
}

static void free_all(forge_file *made) {
    for (int k = 0; k < made->count; k++) {
        free(made->items[k].bytes);
        if (made->items[k].type >= 0)
            H5Tclose(made->items[k].type);
    }
}

bool forge_write(const forge_file *file, forge_stream *stream, const char *path) {
    forge_file made;
    bool dropped[FORGE_ITEMS_MAX];
    saltus_h5 w;
    FILE *to = fopen(path, "wb");
    bool sound = change_all(file, stream, &made, dropped) && to;
    if (to)
        fclose(to);
    saltus_h5_create(&w, path);
    for (int k = 0; k < made.count && sound && w.sound; k++)
        if (!dropped[k])
            write_item(w.file, &made.items[k]);
    saltus_h5_finish(&w, false);
    free_all(&made);
    return sound && w.sound;
}
