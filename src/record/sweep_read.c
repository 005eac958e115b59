/* Reading a sweep file of any origin: everything is checked before it is used.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/rows.h"
#include "record/sweep_output.h"
#include "sweep/options.h"

#include "system/system.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const long long most_rows = 1000000000;

/* A file being read. */
typedef struct reader {
    saltus_h5_reader h5;
    saltus_sweep_file *made;
    int counts[SALTUS_COUNTS_MAX];
    saltus_h5_shape grid; /* of the rows */
} reader;

static saltus_status read_options(reader *r) {
    saltus_sweep_file *made = r->made;
    char name[32], word[16];
    long long dimension = 0, axes = 0;
    made->options = saltus_sweep_defaults();
    hid_t group = saltus_h5_find_group(r->h5.file, "sweep");
    if (group < 0)
        return saltus_h5_refuse(&r->h5, "the group /sweep is missing");
    const char *lacking = saltus_h5_get_options(group, &saltus_sweep_table, &made->options);
    if (!lacking && made->options.passes == 0)
        lacking = "passes";
    if (!lacking && (!saltus_h5_get_integer(group, "dimension", &dimension) || dimension < 1 ||
                     dimension > SALTUS_SCENE_STATE_MAX))
        lacking = "dimension";
    if (!lacking && (!saltus_h5_get_integer(group, "axes", &axes) || axes < 1 || axes > SALTUS_AXES_MAX))
        lacking = "axes";
    made->dimension = r->counts[SALTUS_COUNT_DIMENSION] = (int)dimension;
    made->axis_count = lacking ? 0 : (int)axes;
    for (int k = 0; k < made->axis_count && !lacking; k++) {
        saltus_axis *axis = &made->axes[k];
        int spacing = 0;
        snprintf(name, sizeof name, "key%d", k + 1);
        bool sound = saltus_h5_get_text(group, name, axis->key, sizeof axis->key);
        if (sound) {
            snprintf(name, sizeof name, "spacing%d", k + 1);
            sound = saltus_h5_get_text(group, name, word, sizeof word) &&
                    saltus_word_value(saltus_spacing_words, word, strlen(word), &spacing);
        }
        axis->spacing = (saltus_spacing)spacing;
        lacking = sound ? NULL : name;
    }
    H5Gclose(group);
    for (int k = 0; k < SALTUS_PASSES; k++)
        if (made->options.passes >> k & 1)
            made->passes[made->pass_count++] = (saltus_pass)k;
    return lacking ? saltus_h5_refuse_part(&r->h5, "sweep", lacking) : SALTUS_OK;
}

static saltus_status read_axes(reader *r) {
    saltus_sweep_file *made = r->made;
    double *initial = NULL;
    saltus_status status = saltus_h5_get_reals(&r->h5, "sweep", "initial", SALTUS_SCENE_STATE_MAX, false,
                                               &made->initial_count, &initial);
    /* NAN marks entries that the scene leaves open. */
    for (int i = 0; status == SALTUS_OK && i < made->initial_count; i++)
        if (isinf(initial[i]))
            status = saltus_h5_refuse_part(&r->h5, "sweep", "initial");
    if (status == SALTUS_OK)
        memcpy(made->initial, initial, (size_t)made->initial_count * sizeof *initial);
    free(initial);
    made->points = 1;
    for (int k = 0; k < made->axis_count && status == SALTUS_OK; k++) {
        saltus_axis *axis = &made->axes[k];
        char name[32];
        double *values = NULL;
        snprintf(name, sizeof name, "axis%d", k + 1);
        status = saltus_h5_get_reals(&r->h5, "axes", name, INT_MAX - 1, true, &axis->count, &values);
        axis->list = values;
        if (status == SALTUS_OK && (axis->count < 1 || axis->count > most_rows / made->points))
            status = saltus_h5_refuse_part(&r->h5, "axes", name);
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
    r->grid = (saltus_h5_shape){.rank = 4,
                                .size = {(hsize_t)made->pass_count,
                                         made->axis_count > 1 ? (hsize_t)made->axes[1].count : 1,
                                         (hsize_t)made->axes[0].count, (hsize_t)made->options.seeds}};
    return SALTUS_OK;
}

static saltus_status read_rows(reader *r) {
    saltus_sweep_file *made = r->made;
    size_t rows = (size_t)made->row_count;
    const int attractors = made->basins ? made->attractor_count : made->options.seeds;
    /* In the file of an unfinished sweep, parts are missing. */
    saltus_status status =
        saltus_h5_find_rows(&r->h5, "rows", &saltus_row_fields, NULL, most_rows, !made->complete, &r->grid);
    if (status != SALTUS_OK)
        return status;
    made->rows = calloc(rows, sizeof *made->rows);
    status = made->rows ? saltus_h5_get_rows(&r->h5, "rows", &saltus_row_fields, NULL, &r->grid, made->rows,
                                             sizeof *made->rows)
                        : saltus_h5_no_memory(&r->h5);
    for (size_t i = 0; i < rows && status == SALTUS_OK; i++) {
        const saltus_sweep_row *row = &made->rows[i];
        const bool periodic = row->verdict == SALTUS_PERIODIC;
        if (row->attractor < -1 || row->attractor >= attractors || row->impacts < (periodic ? -1 : 0) ||
            row->impacts == INT_MAX || row->periods < (periodic ? 1 : 0) ||
            row->periods >= 1 << 20 || /* more than any sweep can find */
            row->sticking < 0 || row->settled < 0 || row->settled_impacts < 0 || row->recorded < 0 ||
            (made->complete && row->verdict == SALTUS_PENDING))
            status = saltus_h5_refuse(&r->h5, "a row is not one of a sweep");
    }
    return status;
}

/* Split spans into first and count. False if one has entries outside the `total`. */
static bool split_spans(const saltus_span *spans, size_t rows, long long total, long long *first,
                        long long *count) {
    for (size_t i = 0; i < rows; i++) {
        first[i] = spans[i].first;
        count[i] = spans[i].count;
        if (first[i] < 0 || count[i] < 0 || first[i] > total || count[i] > total - first[i])
            return false;
    }
    return true;
}

/* The clouds that were kept: their entries, and those of each row. */
static saltus_status read_clouds(reader *r) {
    saltus_sweep_file *made = r->made;
    const size_t rows = (size_t)made->row_count;
    void *entries[SALTUS_CLOUDS] = {NULL, NULL, NULL};
    long long **const first[] = {&made->turning_first, &made->impact_first, &made->strobe_first},
                      **const count[] = {&made->turning_count, &made->impact_count, &made->strobe_count},
                      total[SALTUS_CLOUDS] = {0, 0, 0};
    saltus_status status = SALTUS_OK;
    for (int c = 0; c < SALTUS_CLOUDS && status == SALTUS_OK; c++) {
        const saltus_cloud_kind *cloud = &saltus_clouds[c];
        const size_t stride = cloud->bytes ? cloud->bytes : (size_t)made->dimension * sizeof(double);
        if (!(made->options.keep & cloud->keep))
            continue;
        status = saltus_h5_get_all(&r->h5, cloud->group, &cloud->fields, r->counts, LLONG_MAX / 1024, stride,
                                   &entries[c], &total[c]);
        if (status == SALTUS_OK)
            status = saltus_h5_find_rows(&r->h5, cloud->group, &saltus_span_fields, NULL, most_rows,
                                         !made->complete, &r->grid);
        if (status != SALTUS_OK)
            break;
        saltus_span *spans = calloc(rows, sizeof *spans);
        *first[c] = malloc(rows * sizeof **first[c]);
        *count[c] = malloc(rows * sizeof **count[c]);
        status = spans && *first[c] && *count[c]
                     ? saltus_h5_get_rows(&r->h5, cloud->group, &saltus_span_fields, NULL, &r->grid, spans,
                                          sizeof *spans)
                     : saltus_h5_no_memory(&r->h5);
        if (status == SALTUS_OK && !split_spans(spans, rows, total[c], *first[c], *count[c]))
            status = saltus_h5_refuse_part(&r->h5, cloud->group, "first, count");
        free(spans);
    }
    made->turning = entries[0];
    made->impacts = entries[1];
    made->strobes = entries[2];
    for (long long i = 0; i < total[1] && status == SALTUS_OK; i++)
        if (made->impacts[i].face < 0 || made->impacts[i].face >= SALTUS_FACES_MAX)
            status = saltus_h5_refuse_part(&r->h5, "impacts", "face");
    return status;
}

/* Labels, multipliers and points of the attractors; only complete files have them. */
static saltus_status read_attractors(reader *r) {
    saltus_sweep_file *made = r->made;
    void *rows = NULL, *states = NULL;
    long long count = 0, points = 0;
    if (!made->basins || !made->complete)
        return SALTUS_OK;
    saltus_status status = saltus_h5_get_all(&r->h5, "attractors", &saltus_attractor_fields, r->counts,
                                             INT_MAX / 64, sizeof(saltus_attractor_row), &rows, &count);
    if (status == SALTUS_OK)
        status =
            saltus_h5_get_all(&r->h5, "attractors", &saltus_attractor_point_fields, r->counts,
                              LLONG_MAX / 1024, (size_t)made->dimension * sizeof(double), &states, &points);
    made->attractor_states = states;
    size_t room = (size_t)count + 1;
    made->attractor_label = calloc(room, sizeof *made->attractor_label);
    made->attractor_multiplier = calloc(room, sizeof *made->attractor_multiplier);
    made->attractor_first = calloc(room, sizeof *made->attractor_first);
    made->attractor_points = calloc(room, sizeof *made->attractor_points);
    if (status == SALTUS_OK && (!made->attractor_label || !made->attractor_multiplier ||
                                !made->attractor_first || !made->attractor_points))
        status = saltus_h5_no_memory(&r->h5);
    for (long long k = 0; k < count && status == SALTUS_OK; k++) {
        const saltus_attractor_row *row = (const saltus_attractor_row *)rows + k;
        const saltus_span span = {row->first, row->count};
        memcpy(made->attractor_label[k], row->label, sizeof row->label);
        made->attractor_multiplier[k] = row->largest_multiplier;
        if (!split_spans(&span, 1, points, &made->attractor_first[k], &made->attractor_points[k]))
            status = saltus_h5_refuse_part(&r->h5, "attractors", "first, count");
    }
    made->attractor_count = (int)count;
    free(rows);
    return status;
}

/* Open the file and read the scene, options and axes. */
static saltus_status open_file(reader *r) {
    saltus_sweep_file *made = r->made;
    saltus_h5_head head;
    *made = (saltus_sweep_file){.complete = false};
    saltus_status status = saltus_h5_reader_open(&r->h5);
    if (status == SALTUS_OK)
        status = saltus_h5_get_head(&r->h5, "basins", "sweep", &head);
    if (status != SALTUS_OK)
        return status;
    memcpy(made->version, head.version, sizeof made->version);
    memcpy(made->scene, head.scene, sizeof made->scene);
    memcpy(made->title, head.title, sizeof made->title);
    made->basins = strcmp(head.kind, "basins") == 0;
    made->complete = head.complete;
    made->spec = head.spec;
    status = read_options(r);
    return status == SALTUS_OK ? read_axes(r) : status;
}

saltus_status saltus_sweep_file_read(const char *path, saltus_sweep_file *file, saltus_message *message) {
    static saltus_status (*const steps[])(reader *) = {open_file, read_attractors, read_rows, read_clouds};
    reader r = {.h5 = {.path = path, .kind = "sweep", .message = message}, .made = file};
    saltus_status status = SALTUS_OK;
    for (size_t k = 0; k < sizeof steps / sizeof *steps && status == SALTUS_OK; k++)
        status = steps[k](&r);
    saltus_h5_reader_close(&r.h5);
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
        *identity = saltus_sweep_identity_text(&file);
        *complete = file.complete;
        if (!*identity)
            status = saltus_h5_no_memory(&r.h5);
    }
    saltus_h5_reader_close(&r.h5);
    saltus_sweep_file_clear(&file);
    return status;
}

void saltus_sweep_file_clear(saltus_sweep_file *file) {
    void *const owned[] = {file->rows,
                           file->turning_first,
                           file->turning_count,
                           file->impact_first,
                           file->impact_count,
                           file->strobe_first,
                           file->strobe_count,
                           file->turning,
                           file->strobes,
                           file->impacts,
                           file->attractor_label,
                           file->attractor_multiplier,
                           file->attractor_first,
                           file->attractor_points,
                           file->attractor_states};
    saltus_model_release(file->spec.model);
    for (int k = 0; k < SALTUS_AXES_MAX; k++)
        free((double *)file->axes[k].list);
    for (size_t k = 0; k < sizeof owned / sizeof *owned; k++)
        free(owned[k]);
    *file = (saltus_sweep_file){.complete = false};
}
