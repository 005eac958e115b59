/* Reading a sweep's file back, whoever may have written it: everything is checked before it is used.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/describe.h"
#include "record/sweep_output.h"

#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static const long long most_rows = 1000000000;

/* A file being read. */
typedef struct reader {
    saltus_h5_reader h5;
    saltus_sweep_file *made;
    bool without_error; /* an old file: exponents have no standard errors, and the option `measure` is missing
                         */
    int initial_count;
    double *initial;
    hsize_t size[SALTUS_H5_RANK_MAX]; /* of the rows' datasets */
} reader;

static saltus_status read_head(reader *r) {
    saltus_sweep_file *made = r->made;
    saltus_h5_head head;
    saltus_status status = saltus_h5_get_head(&r->h5, "basins", "sweep", &head);
    if (status != SALTUS_OK)
        return status;
    memcpy(made->version, head.version, sizeof made->version);
    memcpy(made->scene, head.scene, sizeof made->scene);
    memcpy(made->title, head.title, sizeof made->title);
    made->basins = strcmp(head.kind, "basins") == 0;
    made->complete = head.complete;
    made->spec = head.spec;
    return SALTUS_OK;
}

/* A whole number among the options, from `low` to `high`. */
static bool get_whole(hid_t group, const char *name, long long low, long long high, long long *value) {
    return saltus_h5_get_integer(group, name, value) && *value >= low && *value <= high;
}

/* What of the options is missing or not as it should be; NULL when all is there. */
static const char *get_options(reader *r, hid_t group) {
    saltus_sweep_file *made = r->made;
    saltus_sweep_options *o = &made->options;
    char words[SALTUS_WORDS_MAX], integrator[16];
    long long seeds, seed, adaptive, longest, order, dimension, axes;
    int k = SALTUS_AUTOMATIC;
    if (!saltus_h5_get_text(group, "keep", words, sizeof words) ||
        !saltus_words_split(words, saltus_keep_words, &o->keep))
        return "keep";
    if (!saltus_h5_get_text(group, "passes", words, sizeof words) ||
        !saltus_words_split(words, saltus_pass_words, &o->passes) || !o->passes)
        return "passes";
    if (!get_whole(group, "seeds", 1, INT_MAX, &seeds) || !saltus_h5_get_integer(group, "seed", &seed))
        return "seeds";
    if (!get_whole(group, "adaptive", 0, 1, &adaptive) ||
        !get_whole(group, "transient", 0, LLONG_MAX, &o->transient) ||
        !get_whole(group, "record", 0, LLONG_MAX, &o->record) ||
        !get_whole(group, "longest", 1, INT_MAX, &longest))
        return "adaptive, transient, record, longest";
    r->without_error = H5Aexists(group, "measure") == 0;
    o->measure = 0;
    if (!r->without_error && !get_whole(group, "measure", 0, LLONG_MAX, &o->measure))
        return "measure";
    if (!saltus_h5_get_double(group, "rtol", &o->flow.rtol) || !isfinite(o->flow.rtol) ||
        !saltus_h5_get_double(group, "atol", &o->flow.atol) || !isfinite(o->flow.atol) ||
        !get_whole(group, "order", 0, INT_MAX, &order) ||
        !saltus_h5_get_text(group, "integrator", integrator, sizeof integrator))
        return "rtol, atol, order, integrator";
    while (k <= SALTUS_RADAU && strcmp(integrator, saltus_integrator_word((saltus_integrator)k)) != 0)
        k++;
    if (k > SALTUS_RADAU)
        return "integrator";
    if (!get_whole(group, "dimension", 1, SALTUS_SCENE_STATE_MAX, &dimension) ||
        !get_whole(group, "axes", 1, SALTUS_AXES_MAX, &axes))
        return "dimension, axes";
    o->seeds = (int)seeds;
    o->seed = (unsigned long)seed;
    o->adaptive = adaptive != 0;
    o->longest = (int)longest;
    o->flow.order = (int)order;
    o->flow.integrator = (saltus_integrator)k;
    made->dimension = (int)dimension;
    made->axis_count = (int)axes;
    return NULL;
}

static saltus_status read_options(reader *r) {
    saltus_sweep_file *made = r->made;
    made->options = saltus_sweep_defaults();
    hid_t group = saltus_h5_find_group(r->h5.file, "sweep");
    if (group < 0)
        return saltus_h5_refuse(&r->h5, "the group /sweep is missing");
    const char *lacking = get_options(r, group);
    char name[32];
    for (int k = 0; k < made->axis_count && !lacking; k++) {
        char word[16] = "";
        snprintf(name, sizeof name, "key%d", k + 1);
        if (!saltus_h5_get_text(group, name, made->axes[k].key, sizeof made->axes[k].key)) {
            lacking = name;
            break;
        }
        snprintf(name, sizeof name, "spacing%d", k + 1);
        int spacing = 0;
        bool there = saltus_h5_get_text(group, name, word, sizeof word);
        while (saltus_spacing_words[spacing] && strcmp(word, saltus_spacing_words[spacing]) != 0)
            spacing++;
        if (!there || !saltus_spacing_words[spacing])
            lacking = name;
        else
            made->axes[k].spacing = (saltus_spacing)spacing;
    }
    H5Gclose(group);
    for (int k = 0; k < SALTUS_PASSES; k++)
        if (made->options.passes >> k & 1)
            made->passes[made->pass_count++] = (saltus_pass)k;
    return lacking ? saltus_h5_refuse_part(&r->h5, "sweep", lacking) : SALTUS_OK;
}

/* Read a dataset of finite numbers that tells its own length. */
static saltus_status read_reals(reader *r, const char *name, long long most, int *count, double **values) {
    hsize_t size[SALTUS_H5_RANK_MAX] = {0}, stored;
    if (saltus_h5_extent(r->h5.file, name, size, &stored) != 1 || !saltus_h5_believable(size[0], 1, stored) ||
        size[0] > (hsize_t)most)
        return saltus_h5_refuse_part(&r->h5, "", name);
    *count = (int)size[0];
    *values = malloc(((size_t)size[0] + 1) * sizeof **values);
    if (!*values)
        return saltus_h5_no_memory(&r->h5);
    if (!saltus_h5_get_array(r->h5.file, name, H5T_NATIVE_DOUBLE, 1, size, *values))
        return saltus_h5_refuse_part(&r->h5, "", name);
    for (int i = 0; i < *count; i++)
        if (!isfinite((*values)[i]))
            return saltus_h5_refuse_part(&r->h5, "", name);
    return SALTUS_OK;
}

static saltus_status read_axes(reader *r) {
    saltus_sweep_file *made = r->made;
    saltus_status status =
        read_reals(r, "sweep/initial", SALTUS_SCENE_STATE_MAX, &r->initial_count, &r->initial);
    made->points = 1;
    for (int k = 0; k < made->axis_count && status == SALTUS_OK; k++) {
        saltus_axis *axis = &made->axes[k];
        char name[32];
        double *values = NULL;
        snprintf(name, sizeof name, "axes/axis%d", k + 1);
        status = read_reals(r, name, INT_MAX - 1, &axis->count, &values);
        axis->list = values;
        if (status == SALTUS_OK && (axis->count < 1 || axis->count > most_rows / made->points))
            status = saltus_h5_refuse_part(&r->h5, "", name);
        if (status != SALTUS_OK)
            break;
        axis->low = values[0];
        axis->high = values[axis->count - 1];
        made->points *= axis->count;
    }
    if (status != SALTUS_OK)
        return status;
    if (made->points > most_rows / made->pass_count / made->options.seeds)
        return saltus_h5_refuse(&r->h5, "there are more rows than there can be");
    made->row_count = made->pass_count * made->points * made->options.seeds;
    const hsize_t size[] = {(hsize_t)made->pass_count,
                            made->axis_count > 1 ? (hsize_t)made->axes[1].count : 1,
                            (hsize_t)made->axes[0].count, (hsize_t)made->options.seeds};
    memcpy(r->size, size, sizeof size);
    return SALTUS_OK;
}

/* Read a dataset with one entry per row. */
static bool get_rows(const reader *r, const char *group, const saltus_sweep_column *column, void *data) {
    saltus_h5 w = {.file = r->h5.file, .sound = true};
    char name[64];
    snprintf(name, sizeof name, "%s/%s", group, column->name);
    hid_t memory = saltus_entry_type(&w, column->entry, false);
    bool found = memory >= 0 && saltus_h5_get_array(r->h5.file, name, memory, 4, r->size, data);
    saltus_h5_close(memory);
    return found;
}

static bool row_sound(const saltus_sweep_file *made, const saltus_sweep_row *row) {
    int attractors = made->basins ? made->attractor_count : made->options.seeds;
    bool periodic = row->verdict == SALTUS_PERIODIC;
    return row->verdict >= 0 && row->verdict < SALTUS_VERDICTS && row->attractor >= -1 &&
           row->attractor < attractors && row->impacts >= (periodic ? -1 : 0) &&
           row->periods >= (periodic ? 1 : 0) && row->sticking >= 0 && row->settled >= 0 &&
           row->settled_impacts >= 0 && row->recorded >= 0 &&
           !(made->complete && row->verdict == SALTUS_PENDING);
}

static saltus_status read_rows(reader *r) {
    saltus_sweep_file *made = r->made;
    size_t rows = (size_t)made->row_count;
    hsize_t size[SALTUS_H5_RANK_MAX] = {0}, stored;
    if (saltus_h5_extent(r->h5.file, "rows/verdict", size, &stored) != 4 ||
        memcmp(size, r->size, sizeof size) != 0 || (made->complete && !saltus_h5_believable(rows, 1, stored)))
        return saltus_h5_refuse_part(&r->h5, "rows", "verdict");
    unsigned char *data = malloc(rows * sizeof(double));
    made->rows = calloc(rows, sizeof *made->rows);
    saltus_status status = data && made->rows ? SALTUS_OK : saltus_h5_no_memory(&r->h5);
    for (int k = 0; k < SALTUS_SWEEP_COLUMNS && status == SALTUS_OK; k++) {
        const saltus_sweep_column *column = &saltus_sweep_columns[k];
        size_t bytes = saltus_entry_bytes(column->entry);
        if (r->without_error && column->offset == offsetof(saltus_sweep_row, lyapunov_error)) {
            for (size_t i = 0; i < rows; i++)
                made->rows[i].lyapunov_error = NAN;
            continue;
        }
        if (!get_rows(r, "rows", column, data))
            status = saltus_h5_refuse_part(&r->h5, "rows", column->name);
        for (size_t i = 0; i < rows && status == SALTUS_OK; i++)
            memcpy((unsigned char *)&made->rows[i] + column->offset, data + i * bytes, bytes);
    }
    free(data);
    for (size_t i = 0; i < rows && status == SALTUS_OK; i++)
        if (!row_sound(made, &made->rows[i]))
            status = saltus_h5_refuse(&r->h5, "a row is not one of a sweep");
    return status;
}

/* Whether all rows' entries are among those of the cloud. */
static bool counts_sound(const long long *first, const long long *count, size_t rows, long long total) {
    for (size_t i = 0; i < rows; i++)
        if (first[i] < 0 || count[i] < 0 || first[i] > total || count[i] > total - first[i])
            return false;
    return true;
}

/* Read `first` and `count` of a group, and how many entries its first column has. */
static saltus_status read_counts(reader *r, const saltus_sweep_cloud *cloud, int width, long long **first,
                                 long long **count, long long *total) {
    hsize_t size[SALTUS_H5_RANK_MAX] = {0}, stored;
    size_t rows = (size_t)r->made->row_count;
    char name[64];
    snprintf(name, sizeof name, "%s/%s", cloud->group, cloud->columns[0].name);
    if (saltus_h5_extent(r->h5.file, name, size, &stored) != (width ? 2 : 1) ||
        !saltus_h5_believable(size[0], (hsize_t)width, stored))
        return saltus_h5_refuse_part(&r->h5, cloud->group, cloud->columns[0].name);
    *total = (long long)size[0];
    *first = malloc(rows * sizeof **first);
    *count = malloc(rows * sizeof **count);
    if (!*first || !*count)
        return saltus_h5_no_memory(&r->h5);
    if (!get_rows(r, cloud->group, &saltus_sweep_first, *first) ||
        !get_rows(r, cloud->group, &saltus_sweep_count, *count) ||
        !counts_sound(*first, *count, rows, *total))
        return saltus_h5_refuse_part(&r->h5, cloud->group, "first, count");
    return SALTUS_OK;
}

/* Read a column of a cloud into records `stride` bytes apart. */
static saltus_status read_entries(reader *r, const saltus_sweep_cloud *cloud, int column, long long total,
                                  int width, unsigned char *records) {
    const saltus_sweep_column *c = &cloud->columns[column];
    const hsize_t size[2] = {(hsize_t)total, (hsize_t)width};
    saltus_h5 w = {.file = r->h5.file, .sound = true};
    size_t bytes = saltus_entry_bytes(c->entry);
    bool direct = cloud->count == 1;
    unsigned char *data = direct ? records : malloc((size_t)total * bytes + 1);
    char name[64];
    if (!data)
        return saltus_h5_no_memory(&r->h5);
    snprintf(name, sizeof name, "%s/%s", cloud->group, c->name);
    hid_t memory = saltus_entry_type(&w, c->entry, false);
    bool found = memory >= 0 && saltus_h5_get_array(r->h5.file, name, memory, width ? 2 : 1, size, data);
    saltus_h5_close(memory);
    for (long long i = 0; i < total && found && !direct; i++)
        memcpy(records + (size_t)i * cloud->stride + c->offset, data + (size_t)i * bytes, bytes);
    if (!direct)
        free(data);
    return found ? SALTUS_OK : saltus_h5_refuse_part(&r->h5, cloud->group, c->name);
}

static saltus_status read_cloud(reader *r, int which, long long **first, long long **count, void **entries,
                                long long *total) {
    const saltus_sweep_cloud *cloud = &saltus_sweep_clouds[which];
    int width = cloud->stride ? 0 : r->made->dimension;
    size_t stride = cloud->stride ? cloud->stride : (size_t)width * sizeof(double);
    *total = 0;
    if (!(r->made->options.keep & cloud->keep))
        return SALTUS_OK;
    saltus_status status = read_counts(r, cloud, width, first, count, total);
    if (status != SALTUS_OK)
        return status;
    *entries = calloc((size_t)*total + 1, stride);
    if (!*entries)
        return saltus_h5_no_memory(&r->h5);
    for (int k = 0; k < cloud->count && status == SALTUS_OK; k++)
        status = read_entries(r, cloud, k, *total, width, *entries);
    return status;
}

static saltus_status read_clouds(reader *r) {
    saltus_sweep_file *made = r->made;
    void *turning = NULL, *impacts = NULL, *strobes = NULL;
    long long total;
    saltus_status status = read_cloud(r, 0, &made->turning_first, &made->turning_count, &turning, &total);
    made->turning = turning;
    if (status == SALTUS_OK)
        status = read_cloud(r, 1, &made->impact_first, &made->impact_count, &impacts, &total);
    made->impacts = impacts;
    for (long long i = 0; i < total && status == SALTUS_OK; i++)
        if (made->impacts[i].face < 0 || made->impacts[i].face >= SALTUS_FACES_MAX)
            status = saltus_h5_refuse_part(&r->h5, "impacts", "face");
    if (status == SALTUS_OK)
        status = read_cloud(r, 2, &made->strobe_first, &made->strobe_count, &strobes, &total);
    made->strobes = strobes;
    return status;
}

static saltus_status read_labels(reader *r, int count) {
    static const int scalar[2] = {0, 0};
    enum { room = sizeof *((saltus_sweep_file *)0)->attractor_label };
    r->made->attractor_label = calloc((size_t)count + 1, room);
    if (!r->made->attractor_label)
        return saltus_h5_no_memory(&r->h5);
    hid_t type = saltus_h5_text_memory(room);
    bool sound = type >= 0 && saltus_h5_get_dataset(r->h5.file, "attractors/label", type, count, scalar,
                                                    r->made->attractor_label);
    saltus_h5_close(type);
    for (int k = 0; k < count && sound; k++)
        sound = memchr(r->made->attractor_label[k], 0, room) != NULL;
    return sound ? SALTUS_OK : saltus_h5_refuse_part(&r->h5, "attractors", "label");
}

/* Names, multipliers and points of the attractors; only a complete file has them. */
static saltus_status read_attractors(reader *r) {
    static const int scalar[2] = {0, 0};
    saltus_sweep_file *made = r->made;
    hsize_t size[SALTUS_H5_RANK_MAX] = {0}, stored;
    if (!made->basins || !made->complete)
        return SALTUS_OK;
    if (saltus_h5_extent(r->h5.file, "attractors/label", size, &stored) != 1 ||
        !saltus_h5_believable(size[0], 1, stored) || size[0] > INT_MAX / 64)
        return saltus_h5_refuse_part(&r->h5, "attractors", "label");
    int count = (int)size[0];
    saltus_status status = read_labels(r, count);
    if (status != SALTUS_OK)
        return status;
    if (saltus_h5_extent(r->h5.file, "attractors/state", size, &stored) != 2 ||
        size[1] != (hsize_t)made->dimension || !saltus_h5_believable(size[0], size[1], stored))
        return saltus_h5_refuse_part(&r->h5, "attractors", "state");
    long long points = (long long)size[0];
    made->attractor_multiplier = malloc(((size_t)count + 1) * sizeof *made->attractor_multiplier);
    made->attractor_first = malloc(((size_t)count + 1) * sizeof *made->attractor_first);
    made->attractor_points = malloc(((size_t)count + 1) * sizeof *made->attractor_points);
    made->attractor_states = malloc(((size_t)points + 1) * (size_t)size[1] * sizeof *made->attractor_states);
    if (!made->attractor_multiplier || !made->attractor_first || !made->attractor_points ||
        !made->attractor_states)
        return saltus_h5_no_memory(&r->h5);
    if (!saltus_h5_get_dataset(r->h5.file, "attractors/largest_multiplier", H5T_NATIVE_DOUBLE, count, scalar,
                               made->attractor_multiplier) ||
        !saltus_h5_get_dataset(r->h5.file, "attractors/first", H5T_NATIVE_LLONG, count, scalar,
                               made->attractor_first) ||
        !saltus_h5_get_dataset(r->h5.file, "attractors/count", H5T_NATIVE_LLONG, count, scalar,
                               made->attractor_points) ||
        !counts_sound(made->attractor_first, made->attractor_points, (size_t)count, points))
        return saltus_h5_refuse_part(&r->h5, "attractors", "largest_multiplier, first, count");
    made->attractor_count = count;
    return saltus_h5_get_array(r->h5.file, "attractors/state", H5T_NATIVE_DOUBLE, 2, size,
                               made->attractor_states)
               ? SALTUS_OK
               : saltus_h5_refuse_part(&r->h5, "attractors", "state");
}

/* Open the file and read what was run. */
static saltus_status open_file(reader *r) {
    *r->made = (saltus_sweep_file){.complete = false};
    saltus_status status = saltus_h5_reader_open(&r->h5);
    if (status == SALTUS_OK)
        status = read_head(r);
    if (status == SALTUS_OK)
        status = read_options(r);
    return status == SALTUS_OK ? read_axes(r) : status;
}

saltus_status saltus_sweep_file_read(const char *path, saltus_sweep_file *file, saltus_message *message) {
    reader r = {.h5 = {.path = path, .kind = "sweep", .message = message}, .made = file};
    saltus_status status = open_file(&r);
    if (status == SALTUS_OK)
        status = read_attractors(&r);
    if (status == SALTUS_OK)
        status = read_rows(&r);
    if (status == SALTUS_OK)
        status = read_clouds(&r);
    saltus_h5_reader_close(&r.h5);
    free(r.initial);
    if (status != SALTUS_OK)
        saltus_sweep_file_clear(file);
    return status;
}

saltus_status saltus_sweep_identity_hdf5(const char *path, char **identity, bool *complete,
                                         saltus_message *message) {
    saltus_sweep_file file;
    reader r = {.h5 = {.path = path, .kind = "sweep", .message = message}, .made = &file};
    *identity = NULL;
    saltus_status status = open_file(&r);
    if (status == SALTUS_OK) {
        const saltus_sweep_identity there = {.version = file.version,
                                             .basins = file.basins,
                                             .spec = &file.spec,
                                             .initial_count = r.initial_count,
                                             .initial = r.initial,
                                             .axis_count = file.axis_count,
                                             .axes = file.axes,
                                             .options = &file.options};
        *identity = saltus_sweep_identity_text(&there);
        *complete = file.complete;
        if (!*identity)
            status = saltus_h5_no_memory(&r.h5);
    }
    saltus_h5_reader_close(&r.h5);
    free(r.initial);
    saltus_sweep_file_clear(&file);
    return status;
}

void saltus_sweep_file_clear(saltus_sweep_file *file) {
    for (int k = 0; k < SALTUS_AXES_MAX; k++)
        free((double *)file->axes[k].list);
    free(file->rows);
    free(file->turning_first);
    free(file->turning_count);
    free(file->impact_first);
    free(file->impact_count);
    free(file->strobe_first);
    free(file->strobe_count);
    free(file->turning);
    free(file->strobes);
    free(file->impacts);
    free(file->attractor_label);
    free(file->attractor_multiplier);
    free(file->attractor_first);
    free(file->attractor_points);
    free(file->attractor_states);
    *file = (saltus_sweep_file){.complete = false};
}
