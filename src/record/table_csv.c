/* Tables of branches and trajectories as comma-separated values: a group of an HDF5 file, dataset by dataset.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/branch_columns.h"
#include "record/describe.h"
#include "record/hdf5.h"
#include "record/output.h"
#include "saltus/record.h"

#include <stdlib.h>
#include <string.h>

enum { columns_max = 64, name_size = 96 };

/* A dataset read as a whole: one row of `width` values for each row of the table. */
typedef struct column {
    char name[name_size];
    char names[512]; /* of the values, with commas between them; "" where they are numbered */
    H5T_class_t class;
    hid_t memory;         /* the type of a value in memory */
    hsize_t width, parts; /* values of a row; of these, how many belong together in a matrix */
    size_t bytes;         /* of a value */
    unsigned char *data;
} column;

typedef struct table {
    const char *kind, *name, *group;
    column columns[columns_max];
    int count;
    hsize_t rows;
} table;

static const char *const sample_columns[] = {"time", "displacement", "velocity", "states", NULL};
static const char *const event_columns[] = {"kind",           "stop", "side", "time", "velocity_before",
                                            "velocity_after", "row",  NULL};
static const char *const strobe_columns[] = {"states", NULL};

/* Where the tables are. Columns of branches are those of their own list. */
static const struct {
    const char *kind, *name, *group;
    const char *const *columns;
} known[] = {{"branch", "points", "points", NULL},
             {"branch", "events", "events", NULL},
             {"trajectory", "samples", "trajectory", sample_columns},
             {"trajectory", "events", "events", event_columns},
             {"trajectory", "strobe", "strobe", strobe_columns}};

/* The type of a value in memory; negative where it is none that is written here. */
static hid_t memory_type(hid_t file_type, H5T_class_t class) {
    if (class == H5T_FLOAT)
        return H5Tcopy(H5T_NATIVE_DOUBLE);
    if (class == H5T_INTEGER)
        return H5Tcopy(H5T_NATIVE_LLONG);
    if (class == H5T_ENUM && H5Tget_size(file_type) <= sizeof(int))
        return H5Tget_native_type(file_type, H5T_DIR_ASCEND);
    if (class == H5T_STRING && H5Tis_variable_str(file_type) == 0)
        return saltus_h5_text_memory(H5Tget_size(file_type));
    return -1;
}

/* Read a dataset of the group as the next column; nothing where there is none. */
static saltus_status read_column(const saltus_h5_reader *r, table *t, const char *name) {
    char path[name_size];
    hsize_t size[SALTUS_H5_RANK_MAX] = {0}, stored;
    snprintf(path, sizeof path, "%s/%s", t->group, name);
    int rank = saltus_h5_extent(r->file, path, size, &stored);
    if (rank < 0 || t->count == columns_max)
        return SALTUS_OK;
    column *c = &t->columns[t->count];
    *c = (column){.memory = -1, .width = 1, .parts = rank > 2 ? size[2] : 1};
    snprintf(c->name, sizeof c->name, "%s", name);
    for (int k = 1; k < rank; k++)
        c->width *= size[k];
    if (t->count == 0)
        t->rows = size[0];
    hid_t set = H5Dopen2(r->file, path, H5P_DEFAULT), type = set >= 0 ? H5Dget_type(set) : -1;
    c->class = type >= 0 ? H5Tget_class(type) : H5T_NO_CLASS;
    c->memory = type >= 0 ? memory_type(type, c->class) : -1;
    if (set < 0 || H5Aexists(set, "names") <= 0 ||
        !saltus_h5_get_text(set, "names", c->names, sizeof c->names))
        c->names[0] = '\0';
    saltus_h5_close(type);
    saltus_h5_close(set);
    t->count++;
    if (c->memory < 0 || size[0] != t->rows || !saltus_h5_believable(size[0], c->width, stored))
        return saltus_h5_refuse_part(r, t->group, name);
    c->bytes = H5Tget_size(c->memory);
    c->data = malloc((size_t)(t->rows * c->width) * c->bytes + 1);
    if (!c->data)
        return saltus_h5_no_memory(r);
    return saltus_h5_get_array(r->file, path, c->memory, rank, size, c->data)
               ? SALTUS_OK
               : saltus_h5_refuse_part(r, t->group, name);
}

static void put_text(FILE *file, const char *text, size_t room) {
    fputc('"', file);
    for (size_t k = 0; k < room && text[k]; k++)
        fputs(text[k] == '"' ? "\"\"" : (const char[2]){text[k], '\0'}, file);
    fputc('"', file);
}

static void put_value(FILE *file, const column *c, hsize_t index) {
    const unsigned char *place = c->data + (size_t)index * c->bytes;
    double real;
    long long whole;
    char word[64];
    switch (c->class) {
    case H5T_FLOAT:
        memcpy(&real, place, sizeof real);
        saltus_put_number(file, real);
        break;
    case H5T_INTEGER:
        memcpy(&whole, place, sizeof whole);
        fprintf(file, "%lld", whole);
        break;
    case H5T_ENUM:
        if (H5Tenum_nameof(c->memory, place, word, sizeof word) >= 0)
            fputs(word, file);
        break;
    default:
        put_text(file, (const char *)place, c->bytes);
    }
}

/* The i-th of the names; how long it is. */
static int find_name(const column *c, hsize_t i, const char **name) {
    *name = c->names;
    for (; i > 0 && **name; i--)
        *name += strcspn(*name, ",") + ((*name)[strcspn(*name, ",")] == ',');
    return (int)strcspn(*name, ",");
}

/* "name" of one value, "name1", ... of a row whose values have no names of their own, "name1_1", ... of a
 * matrix. */
static void put_names(FILE *file, const table *t) {
    for (int k = 0; k < t->count; k++)
        for (hsize_t i = 0; i < t->columns[k].width; i++) {
            const column *c = &t->columns[k];
            const char *own;
            int length = find_name(c, i, &own);
            fprintf(file, "%s%.*s", k || i ? "," : "", length ? length : name_size, length ? own : c->name);
            if (c->width > 1 && !length)
                fprintf(file, "%llu", (unsigned long long)(i / c->parts + 1));
            if (c->parts > 1)
                fprintf(file, "_%llu", (unsigned long long)(i % c->parts + 1));
        }
    fputc('\n', file);
}

static void put_table(FILE *file, const table *t, const char *scene) {
    fprintf(file, "# Saltus " SALTUS_VERSION " %s, %s\n# scene: %s\n", t->kind, t->name, scene);
    put_names(file, t);
    for (hsize_t row = 0; row < t->rows && !ferror(file); row++) {
        for (int k = 0; k < t->count; k++)
            for (hsize_t i = 0; i < t->columns[k].width; i++) {
                if (k || i)
                    fputc(',', file);
                put_value(file, &t->columns[k], row * t->columns[k].width + i);
            }
        fputc('\n', file);
    }
}

static saltus_status read_table(const saltus_h5_reader *r, int which, table *t) {
    saltus_status status = SALTUS_OK;
    *t = (table){.kind = known[which].kind, .name = known[which].name, .group = known[which].group};
    const bool points = strcmp(t->group, "points") == 0;
    const saltus_branch_column *own = points ? saltus_point_columns : saltus_event_columns;
    const int count = points ? (int)SALTUS_POINT_COLUMNS : (int)SALTUS_EVENT_COLUMNS;
    for (int k = 0; !known[which].columns && k < count && status == SALTUS_OK; k++)
        status = read_column(r, t, own[k].name);
    for (int k = 0; known[which].columns && known[which].columns[k] && status == SALTUS_OK; k++)
        status = read_column(r, t, known[which].columns[k]);
    return status == SALTUS_OK && t->count == 0 ? saltus_h5_refuse_part(r, t->group, "") : status;
}

static void clear_table(table *t) {
    for (int k = 0; k < t->count; k++) {
        free(t->columns[k].data);
        saltus_h5_close(t->columns[k].memory);
    }
}

saltus_status saltus_file_csv(const char *path, const char *name, const char *to, saltus_message *message) {
    saltus_h5_reader r = {.path = path, .kind = "branch", .message = message};
    char kind[32] = "", scene[128] = "";
    int which = -1;
    table t = {.count = 0};
    saltus_status status = saltus_h5_reader_open(&r);
    if (status == SALTUS_OK && (!saltus_h5_get_text(r.file, "kind", kind, sizeof kind) ||
                                !saltus_h5_get_text(r.file, "scene", scene, sizeof scene)))
        status = saltus_fail(message, SALTUS_BAD_INPUT, "%s: is an HDF5 file, but not one of Saltus", path);
    for (int k = 0; k < (int)(sizeof known / sizeof known[0]) && which < 0; k++)
        if (strcmp(known[k].kind, kind) == 0 && (!name || strcmp(known[k].name, name) == 0))
            which = k;
    if (status == SALTUS_OK && which < 0)
        status = saltus_fail(message, SALTUS_BAD_INPUT,
                             "%s: holds a %s, which has no table %s; a branch has points and events, a "
                             "trajectory samples, events and strobe",
                             path, kind, name ? name : "");
    if (status == SALTUS_OK)
        status = read_table(&r, which, &t);
    saltus_output output;
    if (status == SALTUS_OK)
        status = saltus_output_open(&output, to, message);
    if (status == SALTUS_OK) {
        put_table(output.file, &t, scene);
        status = saltus_output_close(&output, status, message);
    }
    clear_table(&t);
    saltus_h5_reader_close(&r);
    return status;
}
