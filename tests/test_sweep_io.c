/* Files of sweeps: the journal, the HDF5 file made from it, tables, resuming, refusals. Most results are made
 * up: none of them may be lost or changed, whatever happens.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"
#include "folder.h"
#include "foreign_text.h"

#include <hdf5.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { path_size = 160, seeds = 3, entries_most = 4, dimension = 2 };

typedef struct fixture {
    char folder[64];
    saltus_scene scene;
    saltus_sweep *sweep; /* 7 x 5 points, two passes, three seeds, everything kept */
    long long places;
} fixture;

static saltus_sweep_options full_options(void) {
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep =
        SALTUS_KEEP_TURNING | SALTUS_KEEP_IMPACTS | SALTUS_KEEP_STROBOSCOPIC | SALTUS_KEEP_LYAPUNOV;
    options.passes = 1u << SALTUS_PASS_RESET | 1u << SALTUS_PASS_DOWN;
    options.seeds = seeds;
    options.seed = 12345678901234567890u;
    options.transient = 321;
    return options;
}

static const double clearances[] = {0.5, 0.25, 1.75, 1, 2};

static void full_axes(saltus_axis axes[2]) {
    axes[0] =
        (saltus_axis){.key = "omega", .spacing = SALTUS_LOGARITHMIC, .count = 7, .low = 0.5, .high = 2.0 / 3};
    axes[1] = (saltus_axis){
        .key = "d", .spacing = SALTUS_LIST, .count = 5, .low = 0.5, .high = 2, .list = clearances};
}

static saltus_sweep *make_sweep(const saltus_scene *scene, const saltus_axis *axes, int count,
                                const saltus_sweep_options *options) {
    saltus_message message = {.text = ""};
    saltus_sweep *sweep = NULL;
    check_ok(saltus_sweep_new(scene, axes, count, options, &sweep, &message), &message);
    return sweep;
}

static int open_fixture(void **state) {
    fixture *f = calloc(1, sizeof *f);
    saltus_sweep_options options = full_options();
    saltus_axis axes[2];
    strcpy(f->folder, "/tmp/saltus-test-XXXXXX");
    assert_non_null(mkdtemp(f->folder));
    f->scene.spec = oscillator_spec(0.1, 1, 1, 0.6);
    add_stop(&f->scene.spec, 1, 0.75, SALTUS_UPPER);
    strcpy(f->scene.name, "made-up");
    strcpy(f->scene.title, "it's x = 1, \"100%\"");
    f->scene.initial_count = dimension;
    f->scene.initial[0] = 0.1;
    full_axes(axes);
    f->sweep = make_sweep(&f->scene, axes, 2, &options);
    f->places = saltus_sweep_pass_count(f->sweep) * saltus_sweep_points(f->sweep);
    *state = f;
    return 0;
}

static int close_fixture(void **state) {
    fixture *f = *state;
    folder_files(f->folder, true);
    rmdir(f->folder);
    saltus_sweep_free(f->sweep);
    free(f);
    return 0;
}

static const char *path_in(const fixture *f, const char *name, char path[path_size]) {
    snprintf(path, path_size, "%s/%s", f->folder, name);
    return path;
}

static void write_all(const char *path, const void *bytes, size_t length) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, length, file), length);
    fclose(file);
}

static void check_same_bytes(const char *path, const unsigned char *expected, size_t length) {
    size_t here;
    unsigned char *bytes = read_all(path, &here);
    assert_int_equal(here, length);
    assert_memory_equal(bytes, expected, length);
    free(bytes);
}

/* Numbers that depend only on their arguments. */
static unsigned long long mix(unsigned long long a, unsigned long long b) {
    unsigned long long x = a * 0x9e3779b97f4a7c15u + b + 0x632be59bd9b4e019u;
    x = (x ^ x >> 31) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 29) * 0x94d049bb133111ebu;
    return x ^ x >> 32;
}

static double real(unsigned long long a, unsigned long long b) {
    return (double)(mix(a, b) >> 11) / 9007199254740992.0 - 0.5;
}

/* A made-up result of up to `seeds` seeds. */
typedef struct made_up {
    saltus_sweep_row row[seeds];
    double state[seeds * dimension];
    long long count[3][seeds];
    double turning[seeds * entries_most], strobe[seeds * entries_most * dimension];
    saltus_sweep_impact impact[seeds * entries_most];
    saltus_sweep_result result;
} made_up;

static void make_row(saltus_sweep_row *row, unsigned long long key) {
    *row = (saltus_sweep_row){.verdict = 1 + (int)(mix(key, 0) % (SALTUS_VERDICTS - 1)),
                              .settled = (long long)(mix(key, 1) % 2000),
                              .settled_impacts = (long long)(mix(key, 2) % 100000),
                              .recorded = (long long)(mix(key, 3) % 100),
                              .largest = mix(key, 4) % 5 ? real(key, 5) : NAN,
                              .smallest = mix(key, 4) % 5 ? real(key, 6) : -NAN,
                              .rms = mix(key, 4) % 5 ? real(key, 19) : NAN,
                              .impact_rate = real(key, 7),
                              .largest_speed = real(key, 8) * 1e-300,
                              .contact_fraction = real(key, 9),
                              .lyapunov = mix(key, 15) % 7 ? real(key, 10) : -INFINITY,
                              .lyapunov_error = mix(key, 15) % 7 ? real(key, 16) : 0,
                              .lifetime_at_least = mix(key, 17) % 5 ? real(key, 18) : NAN,
                              .period = mix(key, 19) % 3 ? real(key, 20) : NAN};
    row->attractor = row->verdict == SALTUS_FAILED ? -1 : (int)(mix(key, 11) % seeds);
    if (row->verdict == SALTUS_PERIODIC) {
        row->impacts = (int)(mix(key, 12) % 12) - 1;
        row->periods = 1 + (int)(mix(key, 13) % 20);
        row->sticking = (int)(mix(key, 14) % 3);
    }
}

static void make_result(const saltus_sweep *sweep, long long place, made_up *m) {
    const saltus_sweep_options *o = saltus_sweep_choices(sweep);
    long long total[3] = {0};
    for (int s = 0; s < o->seeds; s++) {
        unsigned long long key = (unsigned long long)place * 16 + (unsigned)s;
        make_row(&m->row[s], key);
        if (o->seeds == 1 && m->row[s].attractor > 0)
            m->row[s].attractor = 0;
        for (int i = 0; i < dimension; i++)
            m->state[s * dimension + i] = real(key, 20 + (unsigned)i);
        for (int c = 0; c < 3; c++) {
            m->count[c][s] = o->keep >> c & 1 ? (long long)(mix(key, 30 + (unsigned)c) % entries_most) : 0;
            total[c] += m->count[c][s];
        }
    }
    unsigned long long key = (unsigned long long)place;
    for (unsigned k = 0; k < total[0]; k++)
        m->turning[k] = real(key, 100 + k);
    for (unsigned k = 0; k < total[1]; k++)
        m->impact[k] = (saltus_sweep_impact){real(key, 200 + k), real(key, 300 + k), (int)(k % 2)};
    for (unsigned k = 0; k < total[2] * dimension; k++)
        m->strobe[k] = real(key, 400 + k);
    m->result = (saltus_sweep_result){.place = place,
                                      .rows = m->row,
                                      .states = m->state,
                                      .turning_counts = m->count[0],
                                      .impact_counts = m->count[1],
                                      .strobe_counts = m->count[2],
                                      .turning = m->turning,
                                      .impacts = m->impact,
                                      .strobes = m->strobe};
}

static saltus_sweep_output *open_output(const char *path, const saltus_sweep *sweep, bool resume) {
    saltus_message message = {.text = ""};
    saltus_sweep_output *output = NULL;
    check_ok(saltus_sweep_output_open(path, sweep, false, resume, NULL, &output, &message), &message);
    return output;
}

static void close_output(saltus_sweep_output *output) {
    saltus_message message = {.text = ""};
    check_ok(saltus_sweep_output_close(output, &message), &message);
}

static void take(saltus_sweep_output *output, const saltus_sweep *sweep, long long place) {
    saltus_message message = {.text = ""};
    made_up m;
    make_result(sweep, place, &m);
    check_ok(saltus_sweep_output_take(output, &m.result, &message), &message);
    assert_true(saltus_sweep_output_has(output, place));
}

static long long places_of(const saltus_sweep *sweep) {
    return saltus_sweep_pass_count(sweep) * saltus_sweep_points(sweep);
}

/* Store `count` missing places, in random order. */
static void take_some(saltus_sweep_output *output, const saltus_sweep *sweep, long long count,
                      unsigned order) {
    long long places = places_of(sweep), *list = malloc((size_t)places * sizeof *list);
    for (long long k = 0; k < places; k++)
        list[k] = k;
    for (long long k = places - 1; k > 0; k--) {
        long long other = (long long)(mix(order, (unsigned long long)k) % (unsigned long long)(k + 1));
        long long kept = list[k];
        list[k] = list[other];
        list[other] = kept;
    }
    for (long long k = 0; k < places && count > 0; k++)
        if (!saltus_sweep_output_has(output, list[k])) {
            take(output, sweep, list[k]);
            count--;
        }
    free(list);
}

/* A finished file, and its bytes. */
static unsigned char *finished_bytes(const fixture *f, const saltus_sweep *sweep, const char *name,
                                     size_t *length) {
    char path[path_size];
    saltus_sweep_output *output = open_output(path_in(f, name, path), sweep, false);
    for (long long place = 0; place < places_of(sweep); place++)
        take(output, sweep, place);
    close_output(output);
    return read_all(path, length);
}

static void check_rows(const saltus_sweep_file *file, const saltus_sweep *sweep) {
    made_up m;
    const double nan = NAN;
    for (long long row = 0; row < file->row_count; row++) {
        int s = (int)(row % file->options.seeds);
        make_result(sweep, row / file->options.seeds, &m);
        saltus_sweep_row expected = m.row[s], *there = &file->rows[row];
        assert_true(there->verdict == expected.verdict && there->impacts == expected.impacts &&
                    there->periods == expected.periods && there->sticking == expected.sticking &&
                    there->attractor == expected.attractor && there->settled == expected.settled &&
                    there->settled_impacts == expected.settled_impacts &&
                    there->recorded == expected.recorded);
        assert_true(
            there->impact_rate == expected.impact_rate && there->largest_speed == expected.largest_speed &&
            there->contact_fraction == expected.contact_fraction && there->lyapunov == expected.lyapunov &&
            there->lyapunov_error == expected.lyapunov_error &&
            (there->lifetime_at_least == expected.lifetime_at_least ||
             (isnan(there->lifetime_at_least) && isnan(expected.lifetime_at_least))));
        assert_true(there->period == expected.period || (isnan(there->period) && isnan(expected.period)));
        if (isnan(expected.largest)) {
            assert_memory_equal(&there->largest, &nan, sizeof nan);
            assert_memory_equal(&there->smallest, &nan, sizeof nan);
        } else
            assert_true(there->largest == expected.largest && there->smallest == expected.smallest &&
                        there->rms == expected.rms);
    }
}

static void check_clouds(const saltus_sweep_file *file, const saltus_sweep *sweep) {
    made_up m;
    for (long long place = 0; place < file->row_count / seeds; place++) {
        long long at[3] = {0};
        make_result(sweep, place, &m);
        for (int s = 0; s < seeds; s++) {
            long long row = place * seeds + s;
            assert_int_equal(file->turning_count[row], m.count[0][s]);
            assert_int_equal(file->impact_count[row], m.count[1][s]);
            assert_int_equal(file->strobe_count[row], m.count[2][s]);
            assert_memory_equal(file->turning + file->turning_first[row], m.turning + at[0],
                                (size_t)m.count[0][s] * sizeof *m.turning);
            assert_memory_equal(file->strobes + file->strobe_first[row] * dimension,
                                m.strobe + at[2] * dimension,
                                (size_t)m.count[2][s] * dimension * sizeof *m.strobe);
            for (long long k = 0; k < m.count[1][s]; k++) {
                const saltus_sweep_impact *a = &file->impacts[file->impact_first[row] + k];
                const saltus_sweep_impact *b = &m.impact[at[1] + k];
                assert_true(a->phase == b->phase && a->speed == b->speed && a->face == b->face);
            }
            for (int c = 0; c < 3; c++)
                at[c] += m.count[c][s];
        }
    }
}

static void results_read_back(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_sweep_file file;
    saltus_axis axes[2];
    char path[path_size];
    size_t length;
    free(finished_bytes(f, f->sweep, "s.h5", &length));
    assert_int_equal(folder_files(f->folder, false), 1);
    check_ok(saltus_sweep_file_read(path_in(f, "s.h5", path), &file, &message), &message);
    assert_string_equal(file.version, SALTUS_VERSION);
    assert_string_equal(file.scene, f->scene.name);
    assert_string_equal(file.title, f->scene.title);
    assert_true(file.complete && !file.basins && file.dimension == dimension);
    assert_memory_equal(&file.spec.parameters, &f->scene.spec.parameters, sizeof file.spec.parameters);
    assert_true(file.spec.stop_count == 1 && file.spec.stops[0].r == 0.75);
    saltus_sweep_options expected = *saltus_sweep_choices(f->sweep), *there = &file.options;
    assert_true(there->keep == expected.keep && there->passes == expected.passes &&
                there->seeds == expected.seeds && there->seed == expected.seed &&
                there->adaptive == expected.adaptive && there->transient == expected.transient &&
                there->record == expected.record && there->measure == expected.measure &&
                there->longest == expected.longest && there->flow.rtol == expected.flow.rtol &&
                there->flow.atol == expected.flow.atol && there->flow.order == expected.flow.order &&
                there->flow.integrator == expected.flow.integrator);
    assert_true(file.pass_count == 2 && file.passes[0] == SALTUS_PASS_RESET &&
                file.passes[1] == SALTUS_PASS_DOWN && file.axis_count == 2 && file.points == 35 &&
                file.row_count == 210);
    full_axes(axes);
    for (int a = 0; a < 2; a++) {
        assert_string_equal(file.axes[a].key, axes[a].key);
        assert_true(file.axes[a].spacing == axes[a].spacing && file.axes[a].count == axes[a].count);
        for (int k = 0; k < axes[a].count; k++)
            assert_true(file.axes[a].list[k] == saltus_axis_value(&axes[a], k));
    }
    check_rows(&file, f->sweep);
    check_clouds(&file, f->sweep);
    saltus_sweep_file_clear(&file);
    folder_files(f->folder, true);
}

/* The label of a row's motion, from its numbers: n/p, chatter/p or the verdict. */
static const char *label_of(const saltus_sweep_row *row, char label[32]) {
    if (row->verdict != SALTUS_PERIODIC)
        snprintf(label, 32, "%s", saltus_verdict_word((saltus_verdict)row->verdict));
    else if (row->impacts < 0)
        snprintf(label, 32, "chatter/%d", row->periods);
    else
        snprintf(label, 32, "%d/%d", row->impacts, row->periods);
    return label;
}

/* Labels are text, one for each row. */
static void check_labels(const fixture *f, hid_t file) {
    static char labels[2][35][seeds][32];
    made_up m;
    hid_t set = H5Dopen2(file, "rows/label", H5P_DEFAULT), type = H5Dget_type(set);
    assert_int_equal(H5Tget_class(type), H5T_STRING);
    assert_int_equal(H5Tget_size(type), sizeof labels[0][0][0]);
    assert_true(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, labels) >= 0);
    for (int place = 0; place < f->places; place++) {
        make_result(f->sweep, place, &m);
        for (int s = 0; s < seeds; s++) {
            char label[32];
            assert_string_equal(labels[place / 35][place % 35][s], label_of(&m.row[s], label));
        }
    }
    H5Tclose(type);
    H5Dclose(set);
}

/* Datasets have plain names and shapes, as another program reads them. */
static void layout_is_plain(void **state) {
    const fixture *f = *state;
    char path[path_size], word[32] = "";
    static int distinct[2][5][7];
    size_t length;
    made_up m;
    free(finished_bytes(f, f->sweep, "s.h5", &length));
    hid_t file = H5Fopen(path_in(f, "s.h5", path), H5F_ACC_RDONLY, H5P_DEFAULT);
    hid_t set = H5Dopen2(file, "rows/verdict", H5P_DEFAULT), space = H5Dget_space(set);
    hid_t type = H5Dget_type(set);
    hsize_t size[4];
    int periodic = SALTUS_PERIODIC;
    assert_int_equal(H5Sget_simple_extent_dims(space, size, NULL), 4);
    assert_true(size[0] == 2 && size[1] == 5 && size[2] == 7 && size[3] == seeds);
    assert_true(H5Tenum_nameof(type, &periodic, word, sizeof word) >= 0);
    assert_string_equal(word, "periodic");
    H5Tclose(type);
    H5Sclose(space);
    H5Dclose(set);
    set = H5Dopen2(file, "rows/attractors", H5P_DEFAULT);
    assert_true(H5Dread(set, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, distinct) >= 0);
    make_result(f->sweep, 35 + 2 * 7 + 3, &m);
    int most = 0;
    for (int s = 0; s < seeds; s++)
        most = m.row[s].attractor + 1 > most ? m.row[s].attractor + 1 : most;
    assert_int_equal(distinct[1][2][3], most);
    H5Dclose(set);
    check_labels(f, file);
    assert_true(H5Aexists_by_name(file, "turning/displacement", "units", H5P_DEFAULT) > 0);
    assert_true(H5Aexists_by_name(file, "rows/lyapunov", "description", H5P_DEFAULT) > 0);
    H5Fclose(file);
    folder_files(f->folder, true);
}

static void order_does_not_matter(void **state) {
    const fixture *f = *state;
    char path[path_size];
    size_t length;
    unsigned char *expected = finished_bytes(f, f->sweep, "a.h5", &length);
    for (unsigned order = 1; order <= 6; order++) {
        saltus_sweep_output *output = open_output(path_in(f, "b.h5", path), f->sweep, false);
        take_some(output, f->sweep, f->places, order);
        for (long long place = 0; order == 6 && place < f->places; place++)
            take(output, f->sweep, place);
        close_output(output);
        check_same_bytes(path, expected, length);
    }
    free(expected);
    folder_files(f->folder, true);
}

static void results_that_do_not_fit_are_refused(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    char path[path_size];
    made_up m;
    saltus_sweep_output *output = open_output(path_in(f, "a.h5", path), f->sweep, false);
    for (int wrong = 0; wrong < 4; wrong++) {
        make_result(f->sweep, 3, &m);
        m.result.place = wrong == 0 ? -1 : wrong == 1 ? f->places : 3;
        m.row[1].verdict = wrong == 2 ? SALTUS_VERDICTS : m.row[1].verdict;
        m.row[2].periods = wrong == 3 ? 1000 : m.row[2].periods;
        assert_int_equal(saltus_sweep_output_take(output, &m.result, &message), SALTUS_BAD_INPUT);
    }
    assert_false(saltus_sweep_output_has(output, -1) || saltus_sweep_output_has(output, f->places) ||
                 saltus_sweep_output_has(output, 3));
    take(output, f->sweep, 3);
    close_output(output);
    folder_files(f->folder, true);
}

/* Order and interruptions also do not matter for a grid of several tiles and clouds of several chunks. */
static void large_grids_are_written_in_parts(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_axis axes[2] = {{.key = "omega", .count = 151, .low = 0.5, .high = 1},
                           {.key = "d", .count = 127, .low = 0.5, .high = 1}};
    saltus_sweep_file file;
    char path[path_size];
    size_t length;
    options.keep = SALTUS_KEEP_TURNING;
    for (int shape = 0; shape < 2; shape++) {
        axes[0].count = shape ? 17011 : 151;
        saltus_sweep *sweep = make_sweep(&f->scene, axes, 2 - shape, &options);
        unsigned char *expected = finished_bytes(f, sweep, "a.h5", &length);
        saltus_sweep_output *output = open_output(path_in(f, "b.h5", path), sweep, false);
        take_some(output, sweep, places_of(sweep) / 2, 1);
        close_output(output);
        output = open_output(path, sweep, true);
        take_some(output, sweep, places_of(sweep), 2);
        close_output(output);
        check_same_bytes(path, expected, length);
        check_ok(saltus_sweep_file_read(path, &file, &message), &message);
        check_rows(&file, sweep);
        long long sum = 0;
        for (long long row = 0; row < file.row_count; row++) {
            assert_true(!file.turning_count[row] || file.turning_first[row] == sum);
            sum += file.turning_count[row];
        }
        assert_true(sum > 16384);
        saltus_sweep_file_clear(&file);
        saltus_sweep_free(sweep);
        free(expected);
    }
    folder_files(f->folder, true);
}

static void interrupted_runs_lose_nothing(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_sweep_file file;
    char path[path_size];
    size_t length;
    unsigned char *expected = finished_bytes(f, f->sweep, "a.h5", &length);
    path_in(f, "b.h5", path);
    for (unsigned run = 0; run < 12; run++) {
        saltus_sweep_output *output = open_output(path, f->sweep, run > 0);
        take_some(output, f->sweep, 6, run);
        close_output(output);
        bool all = 6 * (run + 1) >= f->places;
        check_ok(saltus_sweep_file_read(path, &file, &message), &message);
        long long there = 0;
        for (long long row = 0; row < file.row_count; row++)
            there += file.rows[row].verdict != SALTUS_PENDING;
        assert_int_equal(there, seeds * (all ? f->places : 6 * (run + 1)));
        assert_int_equal(file.complete, all);
        saltus_sweep_file_clear(&file);
        assert_int_equal(folder_files(f->folder, false), all ? 2 : 3);
    }
    check_same_bytes(path, expected, length);
    free(expected);
    folder_files(f->folder, true);
}

/* A run is killed in the middle, and then the next one, repeatedly. */
static void killed_runs_lose_nothing(void **state) {
    const fixture *f = *state;
    char path[path_size];
    size_t length;
    unsigned char *expected = finished_bytes(f, f->sweep, "a.h5", &length);
    path_in(f, "b.h5", path);
    for (unsigned run = 0; run < 3; run++) {
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            saltus_message message = {.text = ""};
            saltus_sweep_output *output;
            if (saltus_sweep_output_open(path, f->sweep, false, run > 0, NULL, &output, &message) ==
                SALTUS_OK)
                take_some(output, f->sweep, 20, run);
            kill(getpid(), SIGKILL);
        }
        assert_int_equal(waitpid(child, NULL, 0), child);
    }
    saltus_sweep_output *output = open_output(path, f->sweep, true);
    long long there = 0;
    for (long long place = 0; place < f->places; place++)
        there += saltus_sweep_output_has(output, place);
    assert_int_equal(there, 60);
    take_some(output, f->sweep, f->places, 9);
    close_output(output);
    check_same_bytes(path, expected, length);
    free(expected);
    folder_files(f->folder, true);
}

/* A journal of 30 results, none of them in a file yet. */
static unsigned char *journal_bytes(const fixture *f, char path[path_size], char journal[path_size],
                                    size_t *length) {
    path_in(f, "b.h5", path);
    path_in(f, "b.h5.journal", journal);
    saltus_sweep_output *output = open_output(path, f->sweep, false);
    take_some(output, f->sweep, 30, 3);
    close_output(output);
    return read_all(journal, length);
}

static void torn_journals_are_cut_back(void **state) {
    const fixture *f = *state;
    char path[path_size], journal[path_size];
    size_t length, whole;
    unsigned char *expected = finished_bytes(f, f->sweep, "a.h5", &length);
    unsigned char *bytes = journal_bytes(f, path, journal, &whole);
    for (unsigned k = 0; k < 24; k++) {
        size_t cut = k == 0 ? 0 : (size_t)(mix(77, k) % whole);
        write_all(journal, bytes, cut);
        saltus_message message = {.text = ""};
        saltus_sweep_output *output = NULL;
        saltus_status status = saltus_sweep_output_open(path, f->sweep, false, true, NULL, &output, &message);
        if (status != SALTUS_OK) {
            /* The head is incomplete: the file counts as an unfinished one without a journal. */
            assert_int_equal(status, SALTUS_BAD_INPUT);
            assert_non_null(strstr(message.text, "is not finished"));
            remove(path);
            output = open_output(path, f->sweep, true);
        }
        take_some(output, f->sweep, f->places, k);
        close_output(output);
        check_same_bytes(path, expected, length);
        assert_int_equal(access(journal, F_OK), -1);
        free(journal_bytes(f, path, journal, &whole));
    }
    free(expected);
    free(bytes);
    folder_files(f->folder, true);
}

/* No content of a journal makes a run crash, or gets into the file. */
static void damaged_journals_do_no_harm(void **state) {
    const fixture *f = *state;
    char path[path_size], journal[path_size];
    size_t length, whole, taken = 0;
    unsigned char *expected = finished_bytes(f, f->sweep, "a.h5", &length);
    unsigned char *bytes = journal_bytes(f, path, journal, &whole);
    for (unsigned k = 0; k < 60; k++) {
        size_t place = k < 40 ? k : (size_t)(mix(5, k) % whole);
        unsigned char kept = bytes[place];
        bytes[place] ^= (unsigned char)(1u << mix(6, k) % 8);
        write_all(journal, bytes, whole);
        saltus_message message = {.text = ""};
        saltus_sweep_output *output = NULL;
        if (saltus_sweep_output_open(path, f->sweep, false, true, NULL, &output, &message) != SALTUS_OK) {
            assert_non_null(strstr(message.text, "b.h5.journal: "));
            check_same_bytes(journal, bytes, whole);
        } else {
            take_some(output, f->sweep, f->places, k);
            close_output(output);
            check_same_bytes(path, expected, length);
            taken++;
        }
        bytes[place] = kept;
    }
    assert_true(taken > 10);
    free(expected);
    free(bytes);
    folder_files(f->folder, true);
}

/* A length that exceeds the file by one byte or by as much as can be written, or ends in missing padding: in
 * the head it is damage, in a record the end of the valid part. */
static void lengths_beyond_the_file_are_seen(void **state) {
    enum { length_at = 16, head_bytes = 32 };
    const fixture *f = *state;
    char path[path_size], journal[path_size];
    size_t length, whole;
    unsigned char *expected = finished_bytes(f, f->sweep, "a.h5", &length);
    unsigned char *bytes = journal_bytes(f, path, journal, &whole), *copy = malloc(whole);
    unsigned long long text, left;
    assert_non_null(copy);
    memcpy(&text, bytes + length_at, sizeof text);
    for (size_t torn = 0; torn < 6; torn += 5) {
        size_t record = head_bytes + (size_t)(text + 7) / 8 * 8;
        for (int k = -9; k < 10; k++) {
            saltus_message message = {.text = ""};
            saltus_sweep_output *output = NULL;
            memcpy(copy, bytes, whole);
            left = whole - torn - head_bytes;
            left = k < 0 ? 0ULL + (unsigned long long)k : left - 3 + (unsigned long long)k;
            memcpy(copy + length_at, &left, sizeof left);
            write_all(journal, copy, whole - torn);
            assert_int_equal(saltus_sweep_output_open(path, f->sweep, false, true, NULL, &output, &message),
                             SALTUS_BAD_INPUT);
            if (!strstr(message.text, "b.h5.journal: is damaged at its begin"))
                fail_msg("%d: %s", k, message.text);
            check_same_bytes(journal, copy, whole - torn);
        }
        for (int k = -9; k < 10; k += 2) {
            memcpy(copy, bytes, whole);
            left = whole - torn - record - 16;
            left = k < 0 ? 0ULL + (unsigned long long)k : left - 3 + (unsigned long long)k;
            left = k == 9 ? 0 : left;
            memcpy(copy + record, &left, sizeof left);
            write_all(journal, copy, whole - torn);
            saltus_sweep_output *output = open_output(path, f->sweep, true);
            for (long long place = 0; place < f->places; place++)
                assert_false(saltus_sweep_output_has(output, place));
            if (k == 9) {
                take_some(output, f->sweep, f->places, 1);
                close_output(output);
                check_same_bytes(path, expected, length);
                free(journal_bytes(f, path, journal, &whole));
            } else
                close_output(output);
        }
    }
    free(copy);
    free(expected);
    free(bytes);
    folder_files(f->folder, true);
}

/* Opening fails with a message that contains all these words. */
static void check_refused(const char *path, const saltus_sweep *sweep, bool basins, bool resume,
                          saltus_status expected, const char *const words[3]) {
    saltus_message message = {.text = ""};
    saltus_sweep_output *output = NULL;
    saltus_status status = saltus_sweep_output_open(path, sweep, basins, resume, NULL, &output, &message);
    if (status != expected || output)
        fail_msg("%s: status %d, %s", path, (int)status, message.text);
    for (int k = 0; k < 3 && words[k]; k++)
        if (!strstr(message.text, words[k]))
            fail_msg("\"%s\" does not say \"%s\"", message.text, words[k]);
}

enum { changes = 15 };

/* The sweep with one change on which its results depend, and the resulting message. */
static saltus_sweep *changed_sweep(const fixture *f, int change, const char *words[3]) {
    static const char *const said[changes][3] = {
        {"k is 1 there and 2 now"},
        {"stop 1 is ", "r = 0.75", "r = 0.5"},
        {"initial entry 2 is 0 there and 3"},
        {"d values is 5 there and 4"},
        {"d value 2 is 0.25 there and 0.3125"},
        {"omega spacing is logarithmic"},
        {"passes is reset,down there and up now"},
        {"seeds is 3 there and 2"},
        {"seed is 1234567890"},
        {"keep (--what) is turning,impacts,stroboscopic,lyapunov there and turning"},
        {"adaptive is yes there and no"},
        {"transient (--at-most) is 321 there and 322"},
        {"rtol is "},
        {"omega value 1 is 0.5 there and 0.5625"},
        {"measure is 32000 there and 32001"}};
    static const double other[] = {0.5, 0.3125, 1.75, 1, 2};
    saltus_scene scene = f->scene;
    saltus_sweep_options options = full_options();
    saltus_axis axes[2];
    full_axes(axes);
    if (change == 0)
        set_parameter(&scene.spec, "k", 2);
    scene.spec.stops[0].r = change == 1 ? 0.5 : 0.75;
    scene.initial[1] = change == 2 ? 3 : 0;
    axes[1].count -= change == 3;
    axes[1].list = change == 4 ? other : axes[1].list;
    axes[0].spacing = change == 5 ? SALTUS_LINEAR : axes[0].spacing;
    options.passes = change == 6 ? 1u << SALTUS_PASS_UP : options.passes;
    options.seeds -= change == 7;
    options.seed -= change == 8;
    options.keep = change == 9 ? SALTUS_KEEP_TURNING : options.keep;
    options.adaptive = change != 10;
    options.transient += change == 11;
    options.flow.rtol *= change == 12 ? 2 : 1;
    axes[0].low = change == 13 ? 0.5625 : 0.5;
    options.measure += change == 14;
    memcpy(words, said[change], sizeof said[change]);
    return make_sweep(&scene, axes, 2, &options);
}

static void another_sweep_is_refused(void **state) {
    const fixture *f = *state;
    char path[path_size], journal[path_size], done[path_size];
    size_t whole, length;
    unsigned char *file = finished_bytes(f, f->sweep, "done.h5", &length);
    unsigned char *bytes = journal_bytes(f, path, journal, &whole);
    path_in(f, "done.h5", done);
    for (int change = 0; change < changes; change++) {
        const char *words[3];
        saltus_sweep *other = changed_sweep(f, change, words);
        check_refused(path, other, false, true, SALTUS_BAD_INPUT, words);
        check_refused(done, other, false, true, SALTUS_BAD_INPUT, words);
        saltus_sweep_free(other);
        check_same_bytes(journal, bytes, whole);
        check_same_bytes(done, file, length);
    }
    assert_int_equal(folder_files(f->folder, true), 3);
    free(file);
    free(bytes);
}

/* Results do not depend on the numbers of lanes and threads, nor on the scene's name. */
static void finished_files_count_as_done(void **state) {
    const fixture *f = *state;
    saltus_scene scene = f->scene;
    saltus_sweep_options options = full_options();
    saltus_axis axes[2];
    char path[path_size];
    size_t length;
    unsigned char *bytes = finished_bytes(f, f->sweep, "a.h5", &length);
    full_axes(axes);
    options.lanes = 2;
    options.threads = 1;
    strcpy(scene.name, "other");
    saltus_sweep *sweep = make_sweep(&scene, axes, 2, &options);
    saltus_sweep_output *output = open_output(path_in(f, "a.h5", path), sweep, true);
    for (long long place = 0; place < f->places; place++)
        assert_true(saltus_sweep_output_has(output, place));
    close_output(output);
    check_same_bytes(path, bytes, length);
    assert_int_equal(folder_files(f->folder, true), 1);
    saltus_sweep_free(sweep);
    free(bytes);
}

static void resuming_needs_the_journal(void **state) {
    const fixture *f = *state;
    char path[path_size], journal[path_size];
    size_t whole;
    free(journal_bytes(f, path, journal, &whole));
    remove(journal);
    check_refused(path, f->sweep, false, true, SALTUS_BAD_INPUT,
                  (const char *const[3]){path, "is not finished", "b.h5.journal"});
    write_all(path, "no file of ours", 15);
    check_refused(path, f->sweep, false, true, SALTUS_BAD_INPUT,
                  (const char *const[3]){path, "no HDF5 file"});
    write_all(journal, "something else", 14);
    check_refused(path, f->sweep, false, true, SALTUS_BAD_INPUT,
                  (const char *const[3]){journal, "is not a journal"});
    assert_int_equal(folder_files(f->folder, true), 2);
    /* Without a file everything is still to be done. */
    saltus_sweep_output *output = open_output(path, f->sweep, true);
    assert_false(saltus_sweep_output_has(output, 0));
    close_output(output);
    folder_files(f->folder, true);
}

static void a_journal_is_for_one_run(void **state) {
    const fixture *f = *state;
    char path[path_size];
    saltus_sweep_output *output = open_output(path_in(f, "a.h5", path), f->sweep, false);
    take(output, f->sweep, 0);
    for (int resume = 0; resume < 2; resume++)
        check_refused(path, f->sweep, false, resume, SALTUS_IO,
                      (const char *const[3]){"a.h5.journal", "in use by another run"});
    take(output, f->sweep, 1);
    close_output(output);
    /* Without --resume existing files are replaced. */
    output = open_output(path, f->sweep, false);
    assert_false(saltus_sweep_output_has(output, 0));
    close_output(output);
    folder_files(f->folder, true);
}

static void what_cannot_be_written_is_refused_at_once(void **state) {
    const fixture *f = *state;
    char path[path_size], folder[path_size];
    check_refused(path_in(f, "none/a.h5", path), f->sweep, false, false, SALTUS_IO,
                  (const char *const[3]){path, "No such file or directory"});
    check_refused(path_in(f, "a.hdf", path), f->sweep, false, false, SALTUS_BAD_INPUT,
                  (const char *const[3]){path, ".h5 or .csv"});
    check_refused(path_in(f, "a.csv", path), f->sweep, false, false, SALTUS_BAD_INPUT,
                  (const char *const[3]){path, "in .h5 files only"});
    check_refused("/dev/null", f->sweep, false, false, SALTUS_BAD_INPUT, (const char *const[3]){"/dev/null"});
    check_refused(path_in(f, "a.h5", path), f->sweep, true, false, SALTUS_BAD_INPUT,
                  (const char *const[3]){"omega", "initial states"});
    assert_int_equal(mkdir(path_in(f, "b.h5", folder), 0777), 0);
    check_refused(folder, f->sweep, false, false, SALTUS_IO, (const char *const[3]){folder, "is a folder"});
    remove(folder);
    assert_int_equal(mkdir(path_in(f, "a.h5.journal", folder), 0777), 0);
    check_refused(path, f->sweep, false, false, SALTUS_IO, (const char *const[3]){folder, "directory"});
    remove(folder);
    assert_int_equal(mkfifo(path, 0666), 0);
    check_refused(path, f->sweep, false, false, SALTUS_BAD_INPUT, (const char *const[3]){path, "plain file"});
    remove(path);
    if (geteuid() != 0) {
        assert_int_equal(chmod(f->folder, 0555), 0);
        check_refused(path, f->sweep, false, false, SALTUS_IO, (const char *const[3]){path, "denied"});
        chmod(f->folder, 0755);
    }
    assert_int_equal(folder_files(f->folder, false), 0);
}

/* From here on no file may grow beyond a length (0: any), as on a full disk. */
static void limit_files(rlim_t length) {
    struct rlimit limit;
    signal(SIGXFSZ, length ? SIG_IGN : SIG_DFL);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
    limit.rlim_cur = length ? length : limit.rlim_max;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

static void full_disks_lose_nothing_in_the_journal(void **state) {
    const fixture *f = *state;
    char path[path_size], journal[path_size];
    size_t length, whole;
    unsigned char *expected = finished_bytes(f, f->sweep, "a.h5", &length);
    for (unsigned k = 0; k < 8; k++) {
        free(journal_bytes(f, path, journal, &whole));
        saltus_sweep_output *output = open_output(path, f->sweep, true);
        saltus_message message = {.text = ""};
        saltus_status status = SALTUS_OK;
        long long place = 0;
        made_up m;
        limit_files(whole + 1 + 331 * k);
        for (; place < f->places && status == SALTUS_OK; place++) {
            make_result(f->sweep, place, &m);
            status = saltus_sweep_output_take(output, &m.result, &message);
        }
        assert_int_equal(status, SALTUS_IO);
        assert_non_null(strstr(message.text, journal));
        assert_non_null(strstr(message.text, "File too large"));
        assert_non_null(strstr(message.text, "--resume"));
        assert_false(saltus_sweep_output_has(output, place - 1));
        limit_files(0);
        /* With space again the same output goes on, or the next one. */
        if (k % 2)
            take(output, f->sweep, place - 1);
        close_output(output);
        output = open_output(path, f->sweep, true);
        for (long long before = 0; before < place - 1 + k % 2; before++)
            assert_true(saltus_sweep_output_has(output, before));
        take_some(output, f->sweep, f->places, k);
        close_output(output);
        check_same_bytes(path, expected, length);
    }
    free(expected);
    folder_files(f->folder, true);
}

static void full_disks_leave_the_file_as_it_was(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_sweep_file file;
    char path[path_size];
    size_t length;
    unsigned char *expected = finished_bytes(f, f->sweep, "a.h5", &length);
    path_in(f, "b.h5", path);
    for (unsigned k = 0; k < 8; k++) {
        size_t limit = length * (k + 1) / 9;
        saltus_sweep_output *output = open_output(path, f->sweep, false);
        take_some(output, f->sweep, f->places, k);
        limit_files(limit);
        saltus_status status = saltus_sweep_output_close(output, &message);
        limit_files(0);
        assert_int_equal(status, SALTUS_IO);
        assert_non_null(strstr(message.text, path));
        assert_non_null(strstr(message.text, "File too large"));
        assert_int_equal(folder_files(f->folder, false), 3);
        check_ok(saltus_sweep_file_read(path, &file, &message), &message);
        assert_false(file.complete);
        saltus_sweep_file_clear(&file);
        output = open_output(path, f->sweep, true);
        close_output(output);
        check_same_bytes(path, expected, length);
    }
    remove(path);
    limit_files(2000);
    saltus_sweep_output *output = NULL;
    assert_int_equal(saltus_sweep_output_open(path, f->sweep, false, false, NULL, &output, &message),
                     SALTUS_IO);
    limit_files(0);
    assert_int_equal(folder_files(f->folder, true), 1);
    free(expected);
}

static saltus_status read_status(const char *path, saltus_message *message) {
    saltus_sweep_file file;
    saltus_status status = saltus_sweep_file_read(path, &file, message);
    saltus_sweep_file_clear(&file);
    return status;
}

static void damaged_files_are_refused(void **state) {
    const fixture *f = *state;
    saltus_message message;
    char path[path_size];
    size_t length;
    unsigned char *bytes = finished_bytes(f, f->sweep, "a.h5", &length);
    path_in(f, "b.h5", path);
    for (unsigned k = 0; k < 60; k++) {
        size_t place = k < 16 ? k : (size_t)(mix(8, k) % (length - 24));
        unsigned char kept = bytes[place];
        bytes[place] ^= (unsigned char)(1u << mix(9, k) % 8);
        write_all(path, bytes, length);
        assert_int_equal(read_status(path, &message), SALTUS_BAD_INPUT);
        assert_non_null(strstr(message.text, "b.h5: is damaged or cut off"));
        bytes[place] = kept;
    }
    for (unsigned k = 0; k < 40; k++) {
        write_all(path, bytes, k ? (size_t)(mix(10, k) % (length - 24)) : 0);
        assert_int_equal(read_status(path, &message), SALTUS_BAD_INPUT);
        assert_non_null(strstr(message.text, "b.h5: "));
    }
    assert_int_equal(read_status("/nowhere/a.h5", &message), SALTUS_BAD_INPUT);
    folder_files(f->folder, true);
    free(bytes);
}

/* Overwrite the first entry of a dataset; as with any program that changes a file, the seal is lost. */
static void spoil(const char *path, const char *name, hid_t memory, const void *value) {
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT), set = H5Dopen2(file, name, H5P_DEFAULT);
    hid_t space = H5Dget_space(set), one = H5Screate(H5S_SCALAR);
    hsize_t at[4] = {0};
    assert_true(H5Sselect_elements(space, H5S_SELECT_SET, 1, at) >= 0);
    assert_true(H5Dwrite(set, memory, one, space, H5P_DEFAULT, value) >= 0);
    H5Sclose(one);
    H5Sclose(space);
    H5Dclose(set);
    H5Fclose(file);
}

static void spoil_number(const char *path, const char *group, const char *name, long long value) {
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT), owner = H5Gopen2(file, group, H5P_DEFAULT);
    hid_t space = H5Screate(H5S_SCALAR);
    assert_true(H5Adelete(owner, name) >= 0);
    hid_t attribute = H5Acreate2(owner, name, H5T_STD_I64LE, space, H5P_DEFAULT, H5P_DEFAULT);
    assert_true(H5Awrite(attribute, H5T_NATIVE_LLONG, &value) >= 0);
    H5Aclose(attribute);
    H5Sclose(space);
    H5Gclose(owner);
    H5Fclose(file);
}

static void check_unsound(const char *path, const char *what) {
    saltus_message message = {.text = ""};
    assert_int_equal(read_status(path, &message), SALTUS_BAD_INPUT);
    if (!strstr(message.text, "is not a sound sweep file") || !strstr(message.text, what))
        fail_msg("\"%s\" does not say \"%s\"", message.text, what);
}

/* Files that are valid HDF5 but not valid sweeps. */
static void wrong_contents_are_refused(void **state) {
    const fixture *f = *state;
    static const struct {
        const char *name;
        long long value;
    } wrong[] = {
        {"turning/first", -1},      {"turning/count", 1LL << 62}, {"impacts/first", 0x7fffffffffffffffLL},
        {"stroboscopic/count", -1}, {"impacts/face", 99},         {"rows/attractor", 3},
        {"rows/periods", -1},       {"rows/impacts", -2},         {"rows/settled", -1}};
    static const char *const needed[] = {"rows/lyapunov",      "turning/first", "turning/displacement",
                                         "stroboscopic/state", "axes/axis2",    "sweep/initial",
                                         "parameters/omega",   "impacts/phase", "parameters/stop_1",
                                         "rows/lyapunov_error"};
    char path[path_size];
    size_t length;
    unsigned char *bytes = finished_bytes(f, f->sweep, "a.h5", &length);
    path_in(f, "b.h5", path);
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        write_all(path, bytes, length);
        spoil(path, wrong[k].name, H5T_NATIVE_LLONG, &wrong[k].value);
        check_unsound(path, "");
    }
    for (size_t k = 0; k < sizeof needed / sizeof *needed; k++) {
        write_all(path, bytes, length);
        hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
        if (strcmp(needed[k], "parameters/omega") == 0)
            assert_true(H5Adelete_by_name(file, "parameters", "omega", H5P_DEFAULT) >= 0);
        else
            assert_true(H5Ldelete(file, needed[k], H5P_DEFAULT) >= 0);
        H5Fclose(file);
        if (strcmp(needed[k], "parameters/stop_1") == 0)
            continue; /* a sweep without stops is valid too */
        check_unsound(path, strchr(needed[k], '/') + 1);
    }
    const double nan = NAN;
    write_all(path, bytes, length);
    spoil(path, "axes/axis1", H5T_NATIVE_DOUBLE, &nan);
    check_unsound(path, "axes/axis1");
    folder_files(f->folder, true);
    free(bytes);
}

static saltus_status read_text(const char *path, const char *name, char again[600], saltus_message *message) {
    saltus_sweep_file file;
    saltus_status status = saltus_sweep_file_read(path, &file, message);
    if (status == SALTUS_OK)
        strcpy(again, name[0] == 'v' ? file.version : name[0] == 's' ? file.scene : file.title);
    saltus_sweep_file_clear(&file);
    return status;
}

/* A text is read completely or not at all, however another program stored it. Some lists here are correct up
 * to where they would be cut. */
static void long_texts_are_not_cut(void **state) {
    static const struct {
        const char *group, *name, *text;
    } words[] = {{"sweep", "keep", "lyapunov,lyapunov,lyapunov,lyapunov,lyapunov,lyapunov,strobosco,x"},
                 {"sweep", "keep", "turning,turning,turning,turning,turning,impacts,turning,turning,x"},
                 {"sweep", "passes", "reset,down,reset,down,reset,down,reset,down,reset,up,reset,down,x"},
                 {"sweep", "key1", "omegaomegaomegaomegaomegaomegaomega"},
                 {"sweep", "key2", "ddddddddddddddddddddddddddddddddd"},
                 {"sweep", "spacing1", "logarithmically spaced"},
                 {"sweep", "spacing2", "list of numbers of any size"},
                 {"sweep", "integrator", "automaticautomatic"}};
    const fixture *f = *state;
    saltus_sweep_file file;
    char path[path_size], what[64], text[101];
    size_t length;
    unsigned char *bytes = finished_bytes(f, f->sweep, "a.h5", &length);
    path_in(f, "b.h5", path);
    foreign_check(path, bytes, length, "version", sizeof file.version - 1, read_text);
    foreign_check(path, bytes, length, "scene", sizeof file.scene - 1, read_text);
    foreign_check(path, bytes, length, "title", sizeof file.title - 1, read_text);
    for (size_t k = 0; k < sizeof words / sizeof words[0]; k++) {
        write_all(path, bytes, length);
        foreign_text(path, words[k].group, words[k].name, words[k].text, FOREIGN_PADDED);
        snprintf(what, sizeof what, "%s/%s", words[k].group, words[k].name);
        check_unsound(path, strcmp(words[k].name, "integrator") == 0 ? "integrator" : what);
    }
    memset(text, 'x', sizeof text);
    text[100] = '\0';
    write_all(path, bytes, length);
    foreign_text(path, "/", "model", text, FOREIGN_TIGHT);
    check_unsound(path, "its attribute model must be a text");
    folder_files(f->folder, true);
    free(bytes);
}

/* Results of another version are not resumed. */
static void another_version_is_another_sweep(void **state) {
    const fixture *f = *state;
    char path[path_size];
    size_t length;
    unsigned char *bytes = finished_bytes(f, f->sweep, "a.h5", &length);
    write_all(path_in(f, "b.h5", path), bytes, length);
    foreign_text(path, "/", "version", "98.7.6", FOREIGN_TIGHT);
    check_refused(path, f->sweep, false, true, SALTUS_BAD_INPUT,
                  (const char *const[3]){path, "version is 98.7.6 there and"});
    folder_files(f->folder, true);
    free(bytes);
}

static void wrong_options_are_refused(void **state) {
    const fixture *f = *state;
    char path[path_size];
    size_t length;
    unsigned char *bytes = finished_bytes(f, f->sweep, "a.h5", &length);
    path_in(f, "b.h5", path);
    static const char *const numbers[] = {"seeds", "dimension", "axes", "longest", "adaptive", "measure"};
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++)
        for (int which = 0; which < 3; which++) {
            static const long long value[] = {-1, 1LL << 40, 1000000000};
            write_all(path, bytes, length);
            spoil_number(path, "sweep", numbers[k], value[which]);
            if ((k != 3 || which != 2) && (k != 5 || which == 0))
                check_unsound(path, "");
        }
    folder_files(f->folder, true);
    free(bytes);
}

/* Older files and journals are refused, for what they lack or for their version. */
static void files_of_before(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_sweep_file file;
    char path[path_size], journal[path_size];
    size_t length, whole;
    free(finished_bytes(f, f->sweep, "a.h5", &length));
    hid_t old = H5Fopen(path_in(f, "a.h5", path), H5F_ACC_RDWR, H5P_DEFAULT);
    assert_true(H5Adelete_by_name(old, "sweep", "measure", H5P_DEFAULT) >= 0);
    H5Fclose(old);
    assert_int_equal(saltus_sweep_file_read(path, &file, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "sweep/measure"));
    check_refused(path, f->sweep, false, true, SALTUS_BAD_INPUT,
                  (const char *const[3]){path, "sweep/measure"});
    unsigned char *bytes = journal_bytes(f, path, journal, &whole);
    bytes[8] = 1;
    write_all(journal, bytes, whole);
    check_refused(path, f->sweep, false, true, SALTUS_BAD_INPUT,
                  (const char *const[3]){journal, "was written by another version"});
    folder_files(f->folder, true);
    free(bytes);
}

/* A sweep without clouds, as tables have none. */
static saltus_sweep *plain_sweep(const fixture *f) {
    saltus_sweep_options options = full_options();
    saltus_axis axes[2];
    full_axes(axes);
    options.keep = 0;
    return make_sweep(&f->scene, axes, 2, &options);
}

/* The lines of a table without those before its names. */
static char **table_lines(const char *path, int *count) {
    size_t length;
    char *text = read_all(path, &length), **lines = calloc(length + 1, sizeof *lines);
    *count = 0;
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n"))
        if (line[0] != '#')
            lines[(*count)++] = line;
    lines[length] = text;
    char **kept = calloc((size_t)*count + 1, sizeof *kept);
    for (int k = 0; k < *count; k++)
        kept[k] = strdup(lines[k]);
    free(text);
    free(lines);
    return kept;
}

static void free_lines(char **lines, int count) {
    for (int k = 0; k < count; k++)
        free(lines[k]);
    free(lines);
}

static double next_number(char **text) {
    char *end;
    double value = strtod(*text, &end);
    assert_true(end > *text);
    *text = *end == ',' ? end + 1 : end;
    return value;
}

static void check_word(char **text, const char *word) {
    size_t length = strlen(word);
    assert_true(strncmp(*text, word, length) == 0 && (*text)[length] == ',');
    *text += length + 1;
}

static void check_number(char **text, double expected) {
    double value = next_number(text);
    assert_true(value == expected || (isnan(value) && isnan(expected)));
}

static void check_table(const fixture *f, char *const *lines, int count) {
    static const char *const verdicts[] = {"pending",        "periodic",  "equilibrium", "held",
                                           "quasi-periodic", "chaotic",   "long-period", "undecided",
                                           "failed",         "transient", "irregular",   "beyond a stop"};
    made_up m;
    saltus_axis axes[2];
    full_axes(axes);
    assert_int_equal(count, 1 + seeds * f->places);
    assert_string_equal(lines[0], "omega,d,pass,seed,verdict,impacts,periods,sticking,attractor,settled,"
                                  "settled_impacts,recorded,largest,smallest,rms,impact_rate,largest_speed,"
                                  "contact_fraction,lyapunov,lyapunov_error,lifetime_at_least,period,label");
    for (int line = 1; line < count; line++) {
        int row = line - 1, place = row / seeds, s = row % seeds;
        char *text = lines[line];
        make_result(f->sweep, place, &m);
        const saltus_sweep_row *r = &m.row[s];
        check_number(&text, saltus_axis_value(&axes[0], place % 7));
        check_number(&text, saltus_axis_value(&axes[1], place / 7 % 5));
        check_word(&text, place < 35 ? "reset" : "down");
        check_number(&text, s);
        check_word(&text, verdicts[r->verdict]);
        const double whole[] = {r->impacts,
                                r->periods,
                                r->sticking,
                                r->attractor,
                                (double)r->settled,
                                (double)r->settled_impacts,
                                (double)r->recorded,
                                r->largest,
                                r->smallest,
                                r->rms,
                                r->impact_rate,
                                r->largest_speed,
                                r->contact_fraction,
                                r->lyapunov,
                                r->lyapunov_error,
                                r->lifetime_at_least,
                                r->period};
        for (size_t k = 0; k < sizeof whole / sizeof *whole; k++)
            check_number(&text, whole[k]);
        char label[32];
        assert_string_equal(text, label_of(r, label));
    }
}

static void tables_hold_all_rows(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_sweep *sweep = plain_sweep(f);
    saltus_sweep_file file;
    char path[path_size], table[path_size];
    size_t length;
    int count, others;
    unsigned char *bytes = finished_bytes(f, sweep, "a.csv", &length);
    path_in(f, "b.csv", path);
    for (unsigned run = 0; run < 3; run++) {
        saltus_sweep_output *output = open_output(path, sweep, run > 0);
        take_some(output, sweep, run < 2 ? 20 : f->places, run);
        close_output(output);
        assert_int_equal(folder_files(f->folder, false), run < 2 ? 3 : 2);
    }
    check_same_bytes(path, bytes, length);
    assert_null(strstr((const char *)bytes, "-nan"));
    char **lines = table_lines(path, &count);
    check_table(f, lines, count);
    free_lines(lines, count);
    /* The same from a file. */
    free(finished_bytes(f, sweep, "c.h5", &length));
    check_ok(saltus_sweep_file_read(path_in(f, "c.h5", table), &file, &message), &message);
    check_ok(saltus_write_sweep_csv(path, &file, SALTUS_TABLE_ROWS, &message), &message);
    assert_int_equal(saltus_write_sweep_csv(path, &file, SALTUS_TABLE_IMPACTS, &message), SALTUS_BAD_INPUT);
    saltus_sweep_file_clear(&file);
    lines = table_lines(path, &others);
    check_table(f, lines, others);
    free_lines(lines, others);
    free(bytes);
    saltus_sweep_free(sweep);
    folder_files(f->folder, true);
}

static void tables_can_be_resumed(void **state) {
    const fixture *f = *state;
    saltus_sweep *sweep = plain_sweep(f);
    saltus_sweep_options options = *saltus_sweep_choices(sweep);
    saltus_axis axes[2];
    char path[path_size], journal[path_size];
    size_t length;
    unsigned char *bytes = finished_bytes(f, sweep, "a.csv", &length);
    saltus_sweep_output *output = open_output(path_in(f, "a.csv", path), sweep, true);
    assert_true(saltus_sweep_output_has(output, f->places - 1));
    close_output(output);
    check_same_bytes(path, bytes, length);
    full_axes(axes);
    options.record = 7;
    saltus_sweep *other = make_sweep(&f->scene, axes, 2, &options);
    check_refused(path, other, false, true, SALTUS_BAD_INPUT,
                  (const char *const[3]){path, "record is 100 there and 7 now"});
    write_all(path, "a,b\n1,2\n", 8);
    check_refused(path, sweep, false, true, SALTUS_BAD_INPUT,
                  (const char *const[3]){path, "table of a sweep"});
    assert_int_equal(folder_files(f->folder, false), 1);
    output = open_output(path_in(f, "b.csv", path), sweep, false);
    take_some(output, sweep, 5, 1);
    close_output(output);
    remove(path_in(f, "b.csv.journal", journal));
    check_refused(path, sweep, false, true, SALTUS_BAD_INPUT,
                  (const char *const[3]){path, "is not finished"});
    saltus_sweep_free(other);
    saltus_sweep_free(sweep);
    free(bytes);
    folder_files(f->folder, true);
}

/* A request that the file cannot serve, or a write error, leaves the path unchanged. */
static void tables_that_are_lacking_are_refused(void **state) {
    const fixture *f = *state;
    static const struct {
        int table;
        const char *name, *words;
        saltus_status status;
    } cases[] = {{SALTUS_TABLE_ROWS - 1, "t.csv", "table -1: there is none", SALTUS_BAD_INPUT},
                 {SALTUS_TABLE_STROBES + 1, "t.csv", "table 4: there is none", SALTUS_BAD_INPUT},
                 {SALTUS_TABLE_TURNING, "t.csv", "did not keep turning", SALTUS_BAD_INPUT},
                 {SALTUS_TABLE_IMPACTS, "t.csv", "did not keep impacts", SALTUS_BAD_INPUT},
                 {SALTUS_TABLE_STROBES, "t.csv", "did not keep stroboscopic", SALTUS_BAD_INPUT},
                 {SALTUS_TABLE_ROWS, "none/t.csv", "No such file", SALTUS_IO},
                 {SALTUS_TABLE_ROWS, "t.csv", NULL, SALTUS_OK}};
    saltus_axis axes[2];
    saltus_sweep_options options = full_options();
    char path[path_size];
    options.keep = 0;
    full_axes(axes);
    saltus_sweep *sweep = make_sweep(&f->scene, axes, 2, &options);
    saltus_sweep_file file;
    saltus_message message = {.text = ""};
    close_output(open_output(path_in(f, "a.h5", path), sweep, false));
    check_ok(saltus_sweep_file_read(path, &file, &message), &message);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        write_all(path_in(f, "t.csv", path), "as before", 9);
        saltus_status status = saltus_write_sweep_csv(path_in(f, cases[k].name, path), &file,
                                                      (saltus_table)cases[k].table, &message);
        assert_int_equal(status, cases[k].status);
        assert_true(!cases[k].words || strstr(message.text, cases[k].words));
        path_in(f, "t.csv", path);
        if (status != SALTUS_OK)
            check_same_bytes(path, (const unsigned char *)"as before", 9);
    }
    saltus_sweep_file_clear(&file);
    saltus_sweep_free(sweep);
    folder_files(f->folder, true);
}

/* A stored place is not overwritten; empty objects can be closed and cleared. */
static void a_place_is_taken_once(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    char path[path_size], journal[path_size];
    made_up first, second;
    size_t once, twice;
    saltus_sweep_output *output = open_output(path_in(f, "a.h5", path), f->sweep, false);
    make_result(f->sweep, 3, &first);
    make_result(f->sweep, 4, &second);
    second.result.place = 3;
    check_ok(saltus_sweep_output_take(output, &first.result, &message), &message);
    path_in(f, "a.h5.journal", journal);
    free(read_all(journal, &once));
    check_ok(saltus_sweep_output_take(output, &second.result, &message), &message);
    assert_true(saltus_sweep_output_has(output, 3) && !saltus_sweep_output_has(output, 4));
    free(read_all(journal, &twice));
    assert_int_equal(once, twice);
    close_output(output);
    saltus_sweep_file file;
    check_ok(saltus_sweep_file_read(path, &file, &message), &message);
    for (long long row = 0; row < file.row_count; row++)
        if (row / seeds == 3) {
            const saltus_sweep_row *a = &file.rows[row], *b = &first.row[row % seeds];
            assert_true(a->verdict == b->verdict && a->settled == b->settled &&
                        a->contact_fraction == b->contact_fraction);
        } else
            assert_int_equal(file.rows[row].verdict, SALTUS_PENDING);
    assert_false(file.complete);
    saltus_sweep_file_clear(&file);
    saltus_sweep_file_clear(&file);
    check_ok(saltus_sweep_output_close(NULL, &message), &message);
    folder_files(f->folder, true);
}

static void clouds_go_to_tables(void **state) {
    const fixture *f = *state;
    static const char *const names[] = {"omega,d,pass,seed,displacement",
                                        "omega,d,pass,seed,phase,speed,face", "omega,d,pass,seed,q1,v1"};
    saltus_message message = {.text = ""};
    saltus_sweep_file file;
    char path[path_size], table[path_size];
    size_t length;
    free(finished_bytes(f, f->sweep, "a.h5", &length));
    check_ok(saltus_sweep_file_read(path_in(f, "a.h5", path), &file, &message), &message);
    const long long *counts[] = {file.turning_count, file.impact_count, file.strobe_count};
    for (int k = 0; k < 3; k++) {
        int count, line = 1;
        check_ok(saltus_write_sweep_csv(path_in(f, "t.csv", table), &file,
                                        (saltus_table)(SALTUS_TABLE_TURNING + k), &message),
                 &message);
        char **lines = table_lines(table, &count);
        assert_string_equal(lines[0], names[k]);
        for (long long row = 0; row < file.row_count; row++)
            for (long long i = 0; i < counts[k][row]; i++) {
                const saltus_sweep_impact *impact = &file.impacts[file.impact_first[row] + i];
                const double *strobe = &file.strobes[2 * (file.strobe_first[row] + i)];
                char *text = lines[line++];
                check_number(&text, file.axes[0].list[row / seeds % 7]);
                check_number(&text, file.axes[1].list[row / seeds / 7 % 5]);
                check_word(&text, row < 105 ? "reset" : "down");
                check_number(&text, (double)(row % seeds));
                check_number(&text, k == 0   ? file.turning[file.turning_first[row] + i]
                                    : k == 1 ? impact->phase
                                             : strobe[0]);
                if (k)
                    check_number(&text, k == 1 ? impact->speed : strobe[1]);
            }
        assert_int_equal(line, count);
        free_lines(lines, count);
    }
    saltus_sweep_file_clear(&file);
    folder_files(f->folder, true);
}

/* Computed results, for basins: each is stored, or its place is skipped. */
typedef struct feeding {
    const saltus_sweep *sweep;
    saltus_sweep_output *output;
    long long next, most;
} feeding;

static long long next_task(void *context) {
    feeding *feed = context;
    while (feed->next < saltus_sweep_tasks(feed->sweep) &&
           saltus_sweep_output_has(feed->output, saltus_sweep_task_place(feed->sweep, feed->next, 0)))
        feed->next++;
    return feed->most-- > 0 && feed->next < saltus_sweep_tasks(feed->sweep) ? feed->next++ : -1;
}

static saltus_status take_result(void *context, const saltus_sweep_result *result, saltus_message *message) {
    feeding *feed = context;
    return saltus_sweep_output_take(feed->output, result, message);
}

static void run_basins(const saltus_sweep *sweep, const char *path, bool resume, long long most) {
    saltus_message message = {.text = ""};
    feeding feed = {.sweep = sweep, .most = most};
    check_ok(saltus_sweep_output_open(path, sweep, true, resume, NULL, &feed.output, &message), &message);
    const saltus_sweep_feed link = {.context = &feed, .next = next_task, .take = take_result};
    check_ok(saltus_sweep_run(sweep, &link, &message), &message);
    check_ok(saltus_sweep_output_close(feed.output, &message), &message);
}

/* A stop reached only from far starts: the motion without impacts coexists with one with impacts. */
static void basins_tell_attractors_apart(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_axis axes[2] = {{.key = "q1", .count = 4, .low = -1, .high = 0.1},
                           {.key = "v1", .count = 3, .low = -0.5, .high = 0.5}};
    saltus_scene scene = f->scene;
    saltus_sweep_file file;
    char path[path_size];
    size_t length;
    scene.spec = oscillator_spec(0.4, 1, 1, 2);
    add_stop(&scene.spec, 0.25, 0.8, SALTUS_UPPER);
    options.transient = 300;
    saltus_sweep *sweep = make_sweep(&scene, axes, 2, &options);
    run_basins(sweep, path_in(f, "a.h5", path), false, 100);
    unsigned char *bytes = read_all(path, &length);
    check_ok(saltus_sweep_file_read(path, &file, &message), &message);
    assert_true(file.basins && file.complete && file.row_count == 12);
    assert_true(file.attractor_count >= 1);
    for (long long row = 0; row < file.row_count; row++) {
        char label[32];
        const saltus_sweep_row *r = &file.rows[row];
        if (r->attractor < 0)
            continue;
        saltus_sweep_label(r, label);
        assert_string_equal(label, file.attractor_label[r->attractor]);
        assert_int_equal(file.attractor_points[r->attractor], r->periods ? r->periods : 1);
    }
    assert_true(file.rows[0].attractor == 0 && file.attractor_multiplier[0] < 1);
    saltus_sweep_file_clear(&file);
    path_in(f, "b.h5", path);
    run_basins(sweep, path, false, 5);
    check_ok(saltus_sweep_file_read(path, &file, &message), &message);
    assert_true(file.basins && !file.complete && file.attractor_count == 0);
    for (long long row = 0; row < file.row_count; row++)
        assert_int_equal(file.rows[row].attractor, -1);
    saltus_sweep_file_clear(&file);
    run_basins(sweep, path, true, 3);
    run_basins(sweep, path, true, 100);
    check_same_bytes(path, bytes, length);
    check_refused(path, sweep, false, true, SALTUS_BAD_INPUT,
                  (const char *const[3]){path, "kind is basins there and sweep now"});
    saltus_sweep_free(sweep);
    free(bytes);
    folder_files(f->folder, true);
}

int main(void) {
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(results_read_back),
        cmocka_unit_test(layout_is_plain),
        cmocka_unit_test(order_does_not_matter),
        cmocka_unit_test(results_that_do_not_fit_are_refused),
        cmocka_unit_test(large_grids_are_written_in_parts),
        cmocka_unit_test(interrupted_runs_lose_nothing),
        cmocka_unit_test(killed_runs_lose_nothing),
        cmocka_unit_test(torn_journals_are_cut_back),
        cmocka_unit_test(damaged_journals_do_no_harm),
        cmocka_unit_test(lengths_beyond_the_file_are_seen),
        cmocka_unit_test(another_sweep_is_refused),
        cmocka_unit_test(finished_files_count_as_done),
        cmocka_unit_test(resuming_needs_the_journal),
        cmocka_unit_test(a_journal_is_for_one_run),
        cmocka_unit_test(what_cannot_be_written_is_refused_at_once),
        cmocka_unit_test(full_disks_lose_nothing_in_the_journal),
        cmocka_unit_test(full_disks_leave_the_file_as_it_was),
        cmocka_unit_test(damaged_files_are_refused),
        cmocka_unit_test(wrong_contents_are_refused),
        cmocka_unit_test(files_of_before),
        cmocka_unit_test(long_texts_are_not_cut),
        cmocka_unit_test(another_version_is_another_sweep),
        cmocka_unit_test(wrong_options_are_refused),
        cmocka_unit_test(tables_hold_all_rows),
        cmocka_unit_test(tables_can_be_resumed),
        cmocka_unit_test(tables_that_are_lacking_are_refused),
        cmocka_unit_test(a_place_is_taken_once),
        cmocka_unit_test(clouds_go_to_tables),
        cmocka_unit_test(basins_tell_attractors_apart),
    };
    return cmocka_run_group_tests(tests, open_fixture, close_fixture);
}
