/* Fuzz target: the readers of branch files, sweep files and basins, and of packed results.
 *
 * The HDF5 library itself is not made to read damaged files; a seal of all bytes keeps those from it. So one
 * part of the inputs damages a sealed file, which must be refused for its seal. The others are forged files
 * (forge.h): sound to the HDF5 library, sealed, with anything in them but what our readers expect.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "feeder.h"
#include "forge.h"
#include "fuzz.h"

#include "record/hdf5.h"

#include <math.h>

enum { sealed_branch, sealed_sweep, sealed_basins, templates };

/* Made once: files to forge from, and a sweep whose results can be unpacked. */
typedef struct bench {
    forge_file files[templates];
    saltus_scene scene;
    saltus_sweep *sweep, *plane;
    saltus_branch_options way; /* of a branch that is gone on with, and what it begins at */
    saltus_motion motion;
    FILE *nowhere;
} bench;

static void check(saltus_status status, const saltus_message *message) {
    fuzz_check(status == SALTUS_OK, message->text);
}

static saltus_branch *open_branch(const bench *b) {
    saltus_message message = {.text = ""};
    saltus_branch *branch = NULL;
    check(saltus_branch_new(&b->scene.spec, b->motion.periods, b->motion.state, &b->way, &branch, &message),
          &message);
    return branch;
}

/* What a branch of the oscillator goes on from after a few points. */
static void save_branch(bench *b, saltus_branch_output *output) {
    saltus_message message = {.text = ""};
    saltus_system *system = NULL;
    saltus_classify_options how = saltus_classify_defaults();
    const saltus_branch_point *point;
    double *numbers, rest[SALTUS_STATE_MAX] = {0};
    int count;
    check(saltus_system_new(&b->scene.spec, &system, &message), &message);
    check(saltus_classify(system, rest, &how, &b->motion, &message), &message);
    saltus_system_free(system);
    b->way = saltus_branch_defaults();
    strcpy(b->way.key[0], "omega");
    b->way.low[0] = 0.5;
    b->way.high[0] = 2;
    b->way.switches = 1;
    saltus_branch *branch = open_branch(b);
    for (int k = 0; k < 30; k++)
        check(saltus_branch_step(branch, &point, &message), &message);
    check(saltus_branch_save(branch, &numbers, &count, &message), &message);
    fuzz_check(count > 0, "a branch cannot be saved");
    saltus_branch_output_resume(output, numbers, count);
    saltus_branch_free(branch);
}

/* Whatever a run is told to go on from, it refuses or takes a step from there. */
static void go_on(const bench *b, const saltus_branch_file *file) {
    saltus_message message = {.text = ""};
    const saltus_branch_point *point;
    int kept;
    saltus_branch *branch = open_branch(b);
    saltus_status status = saltus_branch_resume(branch, file->resume, file->resume_count, &kept, &message);
    fuzz_check_refusal(status, &message);
    if (status == SALTUS_OK)
        saltus_branch_step(branch, &point, &message);
    saltus_branch_free(branch);
}

/* A short branch of the oscillator, with special points and events. */
static void make_branch(bench *b, const char *path) {
    saltus_message message = {.text = ""};
    saltus_branch_output *output = NULL;
    double state[2] = {0.25, -0.5};
    const double values[] = {1.25, 1.5};
    saltus_event events[] = {{.kind = SALTUS_IMPACT, .face = 0, .time = {0, 0.25}, .velocity_before = 0.5},
                             {.kind = SALTUS_STICK, .face = 0, .time = {1, 0.5}},
                             {.kind = SALTUS_RELEASE, .face = 0, .time = {1, 0.75}}};
    saltus_multiplier multipliers[2] = {{0.5, 0.25, -0.5}, {0.5, -0.25, -0.5}};
    saltus_branch_options options = saltus_branch_defaults();
    strcpy(options.key[0], "omega");
    options.low[0] = 1;
    options.high[0] = 2;
    options.values = values;
    options.value_count = 2;
    check(saltus_branch_output_open(path, &b->scene, 2, state, &options, NULL, &output, &message), &message);
    for (int k = 0; k < 4; k++) {
        saltus_branch_point point = {.kind = (saltus_point_kind)(k ? 2 * k + 1 : 0),
                                     .parent = -1,
                                     .step = k,
                                     .value = {1 + 0.25 * k, 0},
                                     .spec = b->scene.spec,
                                     .periods = 2,
                                     .impacts = 1,
                                     .label = "1/2",
                                     .dimension = 2,
                                     .state = state,
                                     .events = events,
                                     .event_count = k % 3 + 1,
                                     .multipliers = multipliers,
                                     .stable = true,
                                     .admissible = true,
                                     .grazing_time = k == 2 ? 1.75 : NAN,
                                     .contact_force = k == 3 ? 0.5 : NAN,
                                     .grazing_stop = k == 2,
                                     .grazing_side = k == 2};
        check(saltus_branch_output_add(output, &point, &message), &message);
    }
    save_branch(b, output);
    check(saltus_branch_output_close(output, false, &message), &message);
}

static void make_sweep(const saltus_sweep *sweep, bool basins, const char *path) {
    saltus_message message = {.text = ""};
    saltus_sweep_output *output;
    check(saltus_sweep_output_open(path, sweep, basins, false, NULL, &output, &message), &message);
    const saltus_sweep_feed feed = {.context = output, .take = take_result};
    check(saltus_sweep_run(sweep, &feed, &message), &message);
    check(saltus_sweep_output_close(output, &message), &message);
}

static void open_sweeps(bench *b) {
    saltus_message message = {.text = ""};
    saltus_sweep_options options = saltus_sweep_defaults();
    const saltus_axis over[] = {{.key = "omega", .count = 2, .low = 1, .high = 1.5},
                                {.key = "d", .count = 2, .low = 0.5, .high = 1}};
    const saltus_axis start[] = {{.key = "q1", .count = 2, .low = 0, .high = 0.25},
                                 {.key = "v1", .count = 1, .low = 0, .high = 0}};
    options.threads = 1;
    options.transient = 50;
    options.record = 1;
    check(saltus_sweep_new(&b->scene, start, 2, &options, &b->plane, &message), &message);
    options.keep = SALTUS_KEEP_TURNING | SALTUS_KEEP_IMPACTS | SALTUS_KEEP_STROBOSCOPIC;
    check(saltus_sweep_new(&b->scene, over, 2, &options, &b->sweep, &message), &message);
}

/* Forged without a change, all of them must be taken. */
static void check_unchanged(const bench *b, const char *path) {
    forge_stream none = {NULL, NULL};
    saltus_message message = {.text = ""};
    for (int k = 0; k < templates; k++) {
        saltus_branch_file branch = {.point_count = 0};
        saltus_sweep_file sweep = {.row_count = 0};
        fuzz_check(forge_write(&b->files[k], &none, path), "a file cannot be forged");
        check(k == sealed_branch ? saltus_branch_file_read(path, &branch, &message)
                                 : saltus_sweep_file_read(path, &sweep, &message),
              &message);
        fuzz_check(branch.point_count > 0 || sweep.row_count > 0, "a forged file is empty");
        saltus_branch_file_clear(&branch);
        saltus_sweep_file_clear(&sweep);
    }
    remove(path);
}

static bench *open_bench(void) {
    bench *b = calloc(1, sizeof *b);
    char path[128];
    saltus_message message = {.text = ""};
    fuzz_check(b != NULL, "no memory");
    b->nowhere = fopen("/dev/null", "w");
    fuzz_check(b->nowhere != NULL, "/dev/null cannot be opened");
    setenv("PATH", "/nonexistent", 1); /* figures are made up to the drawing */
    check(saltus_scene_load("impact-oscillator", &b->scene, &message), &message);
    open_sweeps(b);
    fuzz_path(path);
    make_branch(b, path);
    fuzz_check(forge_read(path, &b->files[sealed_branch]), "a branch file cannot be taken apart");
    make_sweep(b->sweep, false, path);
    fuzz_check(forge_read(path, &b->files[sealed_sweep]), "a sweep file cannot be taken apart");
    make_sweep(b->plane, true, path);
    fuzz_check(forge_read(path, &b->files[sealed_basins]), "a basins file cannot be taken apart");
    check_unchanged(b, path);
    return b;
}

/* Whatever a file says that is taken must be fit for use. Figures take long: few inputs make one. */
static void use_branch(const bench *b, const char *path, bool draw) {
    static const char *const parts[] = {":1", ":4", ":PD1", ":GR", ":9"};
    saltus_message message = {.text = ""};
    saltus_branch_file file;
    saltus_status status = saltus_branch_file_read(path, &file, &message);
    fuzz_check_refusal(status, &message);
    if (status == SALTUS_OK)
        saltus_write_branch_text(b->nowhere, &file);
    if (status == SALTUS_OK && file.resume_count)
        go_on(b, &file);
    saltus_branch_file_clear(&file);
    for (size_t k = 0; status == SALTUS_OK && k < sizeof parts / sizeof parts[0]; k++) {
        char source[160];
        saltus_start start;
        saltus_scene scene = b->scene;
        snprintf(source, sizeof source, "%s%s", path, parts[k]);
        saltus_status read = saltus_start_read(source, NULL, &start, &message);
        fuzz_check_refusal(read, &message);
        if (read == SALTUS_OK)
            fuzz_check_refusal(saltus_start_apply(&start, source, &scene, &message), &message);
    }
    const saltus_plot_options how = saltus_plot_defaults();
    if (status == SALTUS_OK && draw)
        saltus_plot("/nonexistent/figure.svg", &path, 1, &how, &message);
}

static void use_sweep(const char *path, unsigned view, bool draw) {
    saltus_message message = {.text = ""};
    saltus_sweep_file file;
    saltus_status status = saltus_sweep_file_read(path, &file, &message);
    fuzz_check_refusal(status, &message);
    for (int table = SALTUS_TABLE_ROWS; status == SALTUS_OK && table <= SALTUS_TABLE_STROBES; table++)
        fuzz_check_refusal(saltus_write_sweep_csv("/dev/null", &file, (saltus_table)table, &message),
                           &message);
    for (long long k = 0; status == SALTUS_OK && k < file.row_count; k++) {
        char label[32];
        saltus_sweep_label(&file.rows[k], label);
    }
    saltus_sweep_file_clear(&file);
    const saltus_sweep_view how = {.view = (saltus_view)(view % (SALTUS_VIEW_SETTLED + 1))};
    if (status == SALTUS_OK && draw)
        saltus_plot_sweep("/nonexistent/figure.svg", path, &how, &message);
}

/* A sealed file with a few bytes changed, or cut off behind its begin: refused for its seal. Where the seal's
 * own mark is gone there is no seal. */
static void damage(const bench *b, forge_stream *stream) {
    char path[128];
    forge_stream none = {NULL, NULL};
    saltus_message message = {.text = ""};
    saltus_branch_file file;
    fuzz_check(forge_write(&b->files[sealed_branch], &none, fuzz_path(path)), "a file cannot be written");
    FILE *there = fopen(path, "r+b");
    fuzz_check(there && fseek(there, 0, SEEK_END) == 0, "a file cannot be opened");
    long length = ftell(there) - SALTUS_H5_SEAL, changed = 0;
    while (stream->at < stream->end) {
        unsigned a = forge_byte(stream), c = forge_byte(stream), mask = forge_byte(stream);
        long at = (long)(a << 8 | c) % length;
        fseek(there, at, SEEK_SET);
        int byte = fgetc(there);
        fseek(there, at, SEEK_SET);
        fputc(byte ^ (int)mask, there);
        changed += mask != 0;
    }
    fclose(there);
    saltus_status status = saltus_branch_file_read(path, &file, &message);
    saltus_branch_file_clear(&file);
    /* Changes may undo each other. */
    fuzz_check(changed != 1 || (status == SALTUS_BAD_INPUT && strstr(message.text, "is damaged")),
               "a damaged file is not refused for its seal");
    remove(path);
}

/* A result as a block of bytes, of which every number is the fuzzer's. */
static void unpack(const bench *b, const uint8_t *data, size_t size) {
    saltus_sweep_result result;
    double *block = malloc(size + sizeof *block);
    double sum = 0;
    fuzz_check(block != NULL, "no memory");
    memcpy(block, data, size);
    if (saltus_sweep_unpack(b->sweep, block, size, &result)) {
        int seeds = saltus_sweep_choices(b->sweep)->seeds;
        size_t n = (size_t)saltus_sweep_dimension(b->sweep);
        long long turning = 0, impacts = 0, strobes = 0;
        for (int s = 0; s < seeds; s++) {
            char label[32];
            saltus_sweep_label(&result.rows[s], label);
            turning += result.turning_counts[s];
            impacts += result.impact_counts[s];
            strobes += result.strobe_counts[s];
        }
        fuzz_check(turning >= 0 && impacts >= 0 && strobes >= 0, "a count is negative");
        for (long long k = 0; k < turning; k++)
            sum += result.turning[k];
        for (long long k = 0; k < impacts; k++)
            sum += result.impacts[k].speed;
        for (size_t k = 0; k < (size_t)strobes * n; k++)
            sum += result.strobes[k];
    }
    fprintf(b->nowhere, "%g", sum);
    free(block);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static bench *made;
    char path[128];
    saltus_h5_silence silence;
    if (!made)
        made = open_bench();
    if (size < 2)
        return 0;
    forge_stream stream = {data + 2, data + size};
    unsigned mode = data[0] % (templates + 2);
    fuzz_check(saltus_h5_quiet(&silence), "the HDF5 library could not be opened");
    if (mode == templates)
        damage(made, &stream);
    else if (mode == templates + 1)
        unpack(made, stream.at, size - 2);
    else {
        fuzz_check(forge_write(&made->files[mode], &stream, fuzz_path(path)), "a file cannot be forged");
        bool draw = data[1] >= 0xf0;
        mode == sealed_branch ? use_branch(made, path, draw) : use_sweep(path, data[1], draw);
        remove(path);
    }
    saltus_h5_restore(&silence);
    return 0;
}
