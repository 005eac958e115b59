/* Results on disk: JSON, text, CSV, HDF5 and figures, and failures to write them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "folder.h"
#include "reference.h"

#include <hdf5.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

enum { per_period = 48 };

/* A 4/4 motion with its scene and a record of one orbit, in its own folder. */
typedef struct fixture {
    char folder[64];
    saltus_scene scene;
    saltus_system *system;
    saltus_motion motion;
    saltus_trajectory record;
    saltus_flow_options options;
    reference reference;
} fixture;

static int open_fixture(void **state) {
    saltus_message message = {.text = ""};
    fixture *f = calloc(1, sizeof *f);
    strcpy(f->folder, "/tmp/saltus-test-XXXXXX");
    assert_non_null(mkdtemp(f->folder));
    f->reference = read_reference("fig7d");
    f->scene.spec = f->reference.spec;
    strcpy(f->scene.name, "a_b \"quoted\"");
    strcpy(f->scene.title, "it's ^2 {braces} 100%");
    f->system = build(&f->scene.spec);
    f->options = saltus_flow_defaults();
    saltus_classify_options how = saltus_classify_defaults();
    check_ok(saltus_classify(f->system, f->reference.states[0], &how, &f->motion, &message), &message);
    check_ok(saltus_trajectory_record(f->system, f->motion.state, &f->options, 0, f->motion.periods,
                                      per_period, &f->record, &message),
             &message);
    *state = f;
    return 0;
}

static int close_fixture(void **state) {
    fixture *f = *state;
    folder_files(f->folder, true);
    rmdir(f->folder);
    saltus_trajectory_clear(&f->record);
    saltus_motion_clear(&f->motion);
    saltus_system_free(f->system);
    free(f);
    return 0;
}

static const char *path_in(const fixture *f, const char *name, char path[128]) {
    snprintf(path, 128, "%s/%s", f->folder, name);
    return path;
}

static saltus_status write_record(const fixture *f, const char *path, saltus_message *message) {
    return saltus_write_trajectory(path, &f->scene, f->system, &f->options, &f->record, NULL, message);
}

static saltus_status write_sheet(const fixture *f, const char *path, const char *data,
                                 saltus_message *message) {
    const saltus_diagnosis diagnosis = {.motion = &f->motion, .record = &f->record};
    return saltus_write_sheet(path, &f->scene, f->system, &f->options, &diagnosis, NULL, data, message);
}

static char *json_of(const fixture *f) {
    char path[128];
    size_t length;
    FILE *file = fopen(path_in(f, "motion.json", path), "wb");
    assert_non_null(file);
    saltus_write_motion_json(file, &f->scene, f->system, &f->motion);
    fclose(file);
    char *text = read_all(path, &length);
    remove(path);
    return text;
}

static double json_number(const char *json, const char *key) {
    const char *at = find_key(json, key);
    if (!at)
        fail_msg("no key %s", key);
    return strtod(at, NULL);
}

static void json_tells_the_motion(void **state) {
    fixture *f = *state;
    char *json = json_of(f);
    assert_string_equal(strchr(json, '\n'), "\n");
    assert_non_null(strstr(json, "\"scene\": \"a_b \\\"quoted\\\"\""));
    assert_non_null(
        strstr(json, "\"label\": \"4/4\", \"kind\": \"periodic\", \"impacts\": 4, \"periods\": 4"));
    assert_non_null(strstr(json, "\"impacts_by_side\": {\"upper\": 4, \"lower\": 0}"));
    assert_non_null(strstr(json, "\"impacts_by_stop\": [{\"stop\": 1, \"upper\": 4, \"lower\": 0}]"));
    assert_true(json_number(json, "impacts_per_response") == 2);
    assert_true(json_number(json, "omega") == 42);
    assert_true(json_number(json, "d") == 0.035);
    const char *at = find_key(json, "state");
    for (int i = 0; i < f->motion.dimension; i++)
        assert_true(next_number(&at) == f->motion.state[i]);
    at = find_key(json, "events");
    for (int k = 0; k < f->motion.event_count; k++) {
        const char *time = find_key(at, "time_over_T");
        assert_non_null(time);
        assert_true(strtod(time, NULL) == saltus_time_periods(f->motion.events[k].time));
        at = time;
    }
    assert_null(strstr(json, "nan"));
    assert_null(strstr(json, "inf"));
    free(json);
}

/* Chatter has no count of impacts, exact zeros have no logarithm, and the sum rule does not apply. */
static void json_says_null_where_nothing_is_known(void **state) {
    fixture *f = *state;
    long long impacts = f->motion.impacts;
    double log_modulus = f->motion.multipliers[0].log_modulus;
    f->motion.impacts = -1;
    f->motion.sticks = true;
    f->motion.multipliers[0].log_modulus = -INFINITY;
    char *json = json_of(f);
    assert_non_null(strstr(json, "\"impacts\": null"));
    assert_non_null(strstr(json, "\"impacts_per_response\": null"));
    assert_non_null(strstr(json, "\"log_moduli\": [null, "));
    assert_non_null(strstr(json, "\"sum_rule\": null"));
    free(json);
    f->motion.impacts = impacts;
    f->motion.sticks = false;
    f->motion.multipliers[0].log_modulus = log_modulus;
}

static void text_gives_the_verdict_first(void **state) {
    fixture *f = *state;
    char *text = NULL;
    size_t length;
    FILE *stream = open_memstream(&text, &length);
    saltus_write_motion_text(stream, &f->scene, f->system, &f->motion);
    fclose(stream);
    assert_non_null(strstr(text, "\": 4/4, stable\n"));
    int lines = 0;
    for (const char *c = text; *c; c++)
        lines += *c == '\n';
    assert_in_range(lines, 8, 20);
    free(text);
}

/* A flow that stops at each sample's phase gives the same states. */
static void samples_lie_at_exact_phases(void **state) {
    fixture *f = *state;
    const saltus_trajectory *r = &f->record;
    saltus_flow *flow = open_flow(f->system, &f->options, 0, f->motion.state);
    double x[16];
    long long row = 0, strobes = 0;
    assert_int_equal(r->samples, 4 * per_period + 1 + 2 * r->event_count);
    for (long long k = 0; k <= 4 * per_period; k++, row++) {
        double time = (double)(k / per_period) + (double)(k % per_period) / per_period;
        while (r->time[row] != time)
            row++;
        if (k)
            advance(flow, time, 0);
        saltus_flow_state(flow, 0, x);
        for (int i = 0; i < r->dimension; i++)
            check_near(r->states[row * r->dimension + i], x[i], 1e-12);
        if (k % per_period == 0 && k < 4 * per_period) {
            for (int i = 0; i < r->dimension; i++)
                check_near(r->strobe_states[strobes * r->dimension + i], x[i], 1e-12);
            strobes++;
        }
    }
    assert_int_equal(strobes, r->strobes);
    saltus_flow_free(flow);
}

static void impacts_have_two_sides(void **state) {
    fixture *f = *state;
    const saltus_trajectory *r = &f->record;
    assert_int_equal(r->event_count, 4);
    for (long long k = 0; k < r->event_count; k++) {
        long long row = r->event_rows[k];
        assert_true(r->time[row] == r->time[row + 1]);
        assert_true(r->displacement[row] == 0.035 && r->displacement[row + 1] == 0.035);
        assert_true(r->velocity[row] == r->events[k].velocity_before);
        check_near(r->velocity[row + 1], -0.9 * r->velocity[row], 1e-14);
        check_near(r->time[row], f->reference.time[k], 1e-9);
    }
}

/* Samples on both sides of a chatter, a contact and a release; time never runs backwards. */
static void contacts_are_recorded(void **state) {
    (void)state;
    saltus_message message = {.text = ""};
    reference c = read_reference("chatter25");
    saltus_system *system = build(&c.spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_trajectory r;
    int sticks = 0, releases = 0;
    check_ok(saltus_trajectory_record(system, c.states[0], &options, 2, 2, 100, &r, &message), &message);
    for (long long row = 1; row < r.samples; row++)
        assert_true(r.time[row] >= r.time[row - 1]);
    for (long long k = 0; k < r.event_count; k++) {
        sticks += r.events[k].kind == SALTUS_STICK;
        releases += r.events[k].kind == SALTUS_RELEASE;
        if (r.events[k].kind != SALTUS_IMPACT)
            assert_true(r.displacement[r.event_rows[k]] == 0.025);
        if (r.events[k].kind == SALTUS_STICK)
            assert_true(r.velocity[r.event_rows[k] + 1] == 0);
    }
    assert_int_equal(sticks, 1);
    assert_int_equal(releases, 1);
    assert_int_equal(r.strobes, 2);
    saltus_trajectory_clear(&r);
    saltus_system_free(system);
}

/* A request that cannot be recorded is refused by name and leaves the record empty. */
static void records_have_their_limits(void **state) {
    fixture *f = *state;
    static const struct {
        long long transient, periods;
        int samples;
        const char *words;
    } cases[] = {{0, 1, 1, NULL},
                 {1, 2, 3, NULL},
                 {0, 1, 20000, NULL},
                 {-1, 1, 1, "transient = -1: must be at least 0"},
                 {0, 0, 1, "periods = 0: must be from 1 to 1000000000"},
                 {0, 1000000001, 1, "periods = 1000000001: must be from 1 to 1000000000"},
                 {0, 1, 0, "samples per period = 0: must be from 1 to 1000000"},
                 {0, 1, 1000001, "samples per period = 1000001: must be from 1 to 1000000"}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_message message = {.text = ""};
        saltus_trajectory r, none = {0};
        saltus_status status =
            saltus_trajectory_record(f->system, f->motion.state, &f->options, cases[k].transient,
                                     cases[k].periods, cases[k].samples, &r, &message);
        assert_int_equal(status, cases[k].words ? SALTUS_BAD_INPUT : SALTUS_OK);
        if (cases[k].words) {
            assert_non_null(strstr(message.text, cases[k].words));
            assert_memory_equal(&r, &none, sizeof r);
        } else {
            assert_int_equal(r.strobes, cases[k].periods);
            assert_true(r.time[0] == 0 && r.time[r.samples - 1] == (double)cases[k].periods);
        }
        saltus_trajectory_clear(&r);
        assert_memory_equal(&r, &none, sizeof r);
    }
    /* A start beyond the stop is an error of the flow, and also leaves nothing. */
    saltus_message message = {.text = ""};
    saltus_trajectory r, none = {0};
    double beyond[16] = {10};
    assert_true(saltus_trajectory_record(f->system, beyond, &f->options, 0, 1, 4, &r, &message) != SALTUS_OK);
    assert_memory_equal(&r, &none, sizeof r);
}

static volatile sig_atomic_t time_is_up;

static void note_the_alarm(int signal) {
    (void)signal;
    time_is_up = 1;
}

/* An interrupted record is the beginning of the full one. */
static void an_interrupted_record_is_a_begin(void **state) {
    (void)state;
    enum { periods = 400000, samples = 2 };
    saltus_message message = {.text = ""};
    saltus_scene scene;
    saltus_trajectory part, whole;
    check_ok(saltus_scene_load("impact-oscillator", &scene, &message), &message);
    saltus_system *system = build(&scene.spec);
    saltus_flow_options options = saltus_flow_defaults();
    const double start[2] = {0.5, 1};
    const struct itimerval soon = {.it_value = {.tv_usec = 20000}};
    options.rtol = 1e-8;
    options.stop = &time_is_up;
    struct sigaction action = {.sa_handler = note_the_alarm}, old;
    assert_int_equal(sigaction(SIGALRM, &action, &old), 0);
    assert_int_equal(setitimer(ITIMER_REAL, &soon, NULL), 0);
    assert_int_equal(saltus_trajectory_record(system, start, &options, 0, periods, samples, &part, &message),
                     SALTUS_INTERRUPTED);
    sigaction(SIGALRM, &old, NULL);
    time_is_up = 0;
    assert_true(part.samples > 2 && part.strobes > 1 && part.strobes < periods);
    check_ok(saltus_trajectory_record(system, start, &options, 0, part.strobes, samples, &whole, &message),
             &message);
    const size_t n = 2;
    assert_true(part.dimension == 2 && whole.samples >= part.samples && whole.strobes == part.strobes);
    assert_true(part.time[part.samples - 1] >= (double)part.strobes - 1);
    assert_memory_equal(part.time, whole.time, (size_t)part.samples * sizeof *part.time);
    assert_memory_equal(part.states, whole.states, (size_t)part.samples * n * sizeof *part.states);
    assert_memory_equal(part.strobe_states, whole.strobe_states,
                        (size_t)part.strobes * n * sizeof *part.strobe_states);
    assert_true(part.event_count > 0 && part.event_count <= whole.event_count);
    assert_memory_equal(part.event_rows, whole.event_rows,
                        (size_t)part.event_count * sizeof *part.event_rows);
    saltus_trajectory_clear(&part);
    saltus_trajectory_clear(&whole);
    saltus_system_free(system);
}

static void csv_explains_itself(void **state) {
    fixture *f = *state;
    saltus_message message = {.text = ""};
    char path[128];
    size_t length;
    check_ok(write_record(f, path_in(f, "run.csv", path), &message), &message);
    char *text = read_all(path, &length), *rest = text;
    long long header = 0, rows = 0, impacts = 0;
    for (char *line = strtok_r(rest, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
        bool comment = line[0] == '#';
        header += comment;
        rows += !comment;
        impacts += !comment && strstr(line, ",1,upper,impact");
    }
    assert_true(header >= 8);
    assert_int_equal(rows, f->record.samples + 1);
    assert_int_equal(impacts, 4);
    assert_int_equal(folder_files(f->folder, true), 1);
    free(text);
}

static void read_dataset(hid_t file, const char *name, hid_t type, hsize_t count, void *values) {
    hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
    assert_true(set >= 0);
    hid_t space = H5Dget_space(set);
    assert_int_equal(H5Sget_simple_extent_npoints(space), count);
    assert_true(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    assert_true(H5Aexists(set, "units") > 0 && H5Aexists(set, "description") > 0);
    H5Sclose(space);
    H5Dclose(set);
}

static void hdf5_reads_back(void **state) {
    fixture *f = *state;
    const saltus_trajectory *r = &f->record;
    saltus_message message = {.text = ""};
    char path[128];
    double omega = 0, speeds[4], *states = malloc((size_t)(r->samples * r->dimension) * sizeof *states);
    long long rows[4];
    check_ok(write_record(f, path_in(f, "run.h5", path), &message), &message);
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    assert_true(file >= 0);
    read_dataset(file, "trajectory/states", H5T_NATIVE_DOUBLE, (hsize_t)(r->samples * r->dimension), states);
    assert_memory_equal(states, r->states, (size_t)(r->samples * r->dimension) * sizeof *states);
    read_dataset(file, "trajectory/time", H5T_NATIVE_DOUBLE, (hsize_t)r->samples, states);
    assert_memory_equal(states, r->time, (size_t)r->samples * sizeof *states);
    read_dataset(file, "strobe/states", H5T_NATIVE_DOUBLE, (hsize_t)(4 * r->dimension), states);
    assert_memory_equal(states, r->strobe_states, (size_t)(4 * r->dimension) * sizeof *states);
    read_dataset(file, "events/velocity_before", H5T_NATIVE_DOUBLE, 4, speeds);
    read_dataset(file, "events/row", H5T_NATIVE_LLONG, 4, rows);
    for (int k = 0; k < 4; k++)
        assert_true(speeds[k] == r->events[k].velocity_before && rows[k] == r->event_rows[k]);
    hid_t attribute = H5Aopen_by_name(file, "parameters", "omega", H5P_DEFAULT, H5P_DEFAULT);
    assert_true(attribute >= 0 && H5Aread(attribute, H5T_NATIVE_DOUBLE, &omega) >= 0);
    assert_true(omega == 42);
    H5Aclose(attribute);
    H5Fclose(file);
    free(states);
    assert_int_equal(folder_files(f->folder, true), 1);
}

/* Equal records give equal files, and a record without events is a file too. */
static void hdf5_is_reproducible_and_may_be_empty(void **state) {
    fixture *f = *state;
    saltus_message message = {.text = ""};
    char a[128], b[128];
    size_t na, nb;
    check_ok(write_record(f, path_in(f, "a.h5", a), &message), &message);
    check_ok(write_record(f, path_in(f, "b.h5", b), &message), &message);
    char *first = read_all(a, &na), *second = read_all(b, &nb);
    assert_int_equal(na, nb);
    assert_memory_equal(first, second, na);
    free(first);
    free(second);
    long long events = f->record.event_count;
    f->record.event_count = 0;
    check_ok(write_record(f, a, &message), &message);
    f->record.event_count = events;
    folder_files(f->folder, true);
}

/* Every failure has one message, and the folder stays as it was. */
static void unwritable_paths_leave_nothing(void **state) {
    fixture *f = *state;
    static const char *const endings[] = {"csv", "h5", "png"};
    saltus_message message;
    char path[128];
    for (int k = 0; k < 3; k++) {
        char name[64];
        snprintf(name, sizeof name, "missing/x.%s", endings[k]);
        message.text[0] = 0;
        path_in(f, name, path);
        assert_int_equal(k < 2 ? write_record(f, path, &message) : write_sheet(f, path, NULL, &message),
                         SALTUS_IO);
        assert_non_null(strstr(message.text, path));
        assert_non_null(strstr(message.text, "No such file"));
        snprintf(name, sizeof name, "full.%s", endings[k]);
        assert_int_equal(symlink("/dev/full", path_in(f, name, path)), 0);
        assert_int_equal(k < 2 ? write_record(f, path, &message) : write_sheet(f, path, NULL, &message),
                         SALTUS_IO);
        assert_non_null(strstr(message.text, k == 1 ? "is not a plain file" : "No space left"));
        assert_int_equal(folder_files(f->folder, true), 1);
        assert_int_equal(mkdir(path, 0777), 0);
        assert_int_equal(k < 2 ? write_record(f, path, &message) : write_sheet(f, path, NULL, &message),
                         SALTUS_IO);
        assert_non_null(strstr(message.text, "folder"));
        rmdir(path);
    }
}

static void wrong_endings_are_refused(void **state) {
    fixture *f = *state;
    saltus_message message = {.text = ""};
    char path[128], data[128];
    assert_int_equal(write_record(f, path_in(f, "run.txt", path), &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, ".csv or .h5"));
    assert_int_equal(write_record(f, path_in(f, ".csv", path), &message), SALTUS_BAD_INPUT);
    assert_int_equal(write_sheet(f, path_in(f, "a.jpg", path), NULL, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, ".png, .pdf or .svg"));
    assert_int_equal(write_sheet(f, path_in(f, "a.png", path), path_in(f, "a.dat", data), &message),
                     SALTUS_BAD_INPUT);
    assert_int_equal(folder_files(f->folder, true), 0);
}

/* Without gnuplot the sheet fails with one message. */
static void absent_gnuplot_is_named(void **state) {
    fixture *f = *state;
    saltus_message message = {.text = ""};
    char path[128], before[4096];
    snprintf(before, sizeof before, "%s", getenv("PATH"));
    setenv("PATH", f->folder, 1);
    saltus_status status = write_sheet(f, path_in(f, "sheet.png", path), NULL, &message);
    setenv("PATH", before, 1);
    assert_int_equal(status, SALTUS_IO);
    assert_non_null(strstr(message.text, "gnuplot was not found"));
    assert_int_equal(folder_files(f->folder, true), 0);
}

/* A failing gnuplot is quoted; its drawing is not kept. */
static void failing_gnuplot_is_quoted(void **state) {
    fixture *f = *state;
    saltus_message message = {.text = ""};
    char path[128], tool[128], before[4096];
    FILE *file = fopen(path_in(f, "gnuplot", tool), "w");
    fputs("#!/bin/sh\necho half a picture\necho '     line 3: unknown or ambiguous terminal name' >&2\nexit "
          "1\n",
          file);
    fclose(file);
    chmod(tool, 0755);
    snprintf(before, sizeof before, "%s", getenv("PATH"));
    setenv("PATH", f->folder, 1);
    saltus_status status = write_sheet(f, path_in(f, "sheet.png", path), NULL, &message);
    setenv("PATH", before, 1);
    assert_int_equal(status, SALTUS_IO);
    assert_non_null(strstr(message.text, "line 3: unknown or ambiguous terminal name"));
    assert_int_equal(folder_files(f->folder, true), 1);
}

static bool gnuplot_is_there(void) {
    return system("gnuplot --version >/dev/null 2>&1") == 0;
}

/* Pictures begin as files of their kind, and the kept script draws the same figure again. */
static void sheets_are_drawn(void **state) {
    fixture *f = *state;
    static const char *const names[] = {"s.png", "s.pdf", "s.svg"}, *const heads[] = {"\x89PNG", "%PDF",
                                                                                      "<?xml"};
    saltus_message message = {.text = ""};
    char path[128], data[128], command[512];
    size_t length;
    if (!gnuplot_is_there())
        skip();
    for (int k = 0; k < 3; k++) {
        check_ok(write_sheet(f, path_in(f, names[k], path), k ? NULL : path_in(f, "d.h5", data), &message),
                 &message);
        char *picture = read_all(path, &length);
        assert_true(length > 10000);
        assert_memory_equal(picture, heads[k], 4);
        free(picture);
    }
    assert_int_equal(folder_files(f->folder, false), 5);
    remove(path_in(f, "s.png", path));
    snprintf(command, sizeof command,
             "cd %s && gnuplot d.gp 2>messages && test ! -s messages && test -s s.png", f->folder);
    assert_int_equal(system(command), 0);
    folder_files(f->folder, true);
}

/* Draw a diagnosis and return its script, on which gnuplot must print nothing. */
static char *script_of(const fixture *f, const saltus_system *drawn, const saltus_diagnosis *diagnosis) {
    saltus_message message = {.text = ""};
    char path[128], data[128], command[512];
    size_t length;
    saltus_status status = saltus_write_sheet(path_in(f, "s.svg", path), &f->scene, drawn, &f->options,
                                              diagnosis, NULL, path_in(f, "d.h5", data), &message);
    if (gnuplot_is_there()) {
        check_ok(status, &message);
        snprintf(command, sizeof command,
                 "cd %s && rm s.svg && gnuplot d.gp 2>messages && test ! -s messages && test -s s.svg",
                 f->folder);
        assert_int_equal(system(command), 0);
    }
    char *script = read_all(path_in(f, "d.gp", path), &length);
    folder_files(f->folder, true);
    return script;
}

/* The panels have exactly these headings, in order, and datablocks contain only numbers. */
static void check_script(const char *script, const char *const *panels) {
    const char *at = script;
    char mark[64];
    for (int k = 0; k < 7; k++) {
        snprintf(mark, sizeof mark, "{/:Bold (%c)}  %s", 'a' + k, panels[k] ? panels[k] : "");
        const char *found = strstr(at, mark);
        if ((found != NULL) != (panels[k] != NULL))
            fail_msg("panel '%s' is %s", mark, found ? "too much" : "missing");
        if (!found)
            break;
        at = found;
    }
    for (const char *block = script; (block = strstr(block, " << EOD\n")); block++) {
        const char *row = strchr(block, '\n') + 1, *end = strstr(row, "\nEOD\n");
        assert_non_null(end);
        for (row += strcspn(row, "\n"); row < end; row++)
            if (!strchr("0123456789+-.e \n", *row))
                fail_msg("a datablock holds %.40s", row - 20);
    }
}

/* Periodic motion, with its spectrum and without. */
static void sheets_of_orbits_have_their_panels(void **state) {
    fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_spectra spectra = {0};
    saltus_spectrum_options options = saltus_spectrum_defaults();
    options.quantity_count = 1;
    options.per_period = 256;
    options.periods = 2LL * f->motion.periods;
    check_ok(saltus_motion_spectra(f->system, &f->motion, &options, &spectra, &message), &message);
    saltus_diagnosis diagnosis = {.motion = &f->motion, .record = &f->record, .spectra = &spectra};
    char *script = script_of(f, f->system, &diagnosis);
    check_script(script, (const char *const[]){"phase portrait", "one orbit; marks: impacts", "impacts",
                                               "shapes", "displacement", "Floquet", NULL});
    assert_non_null(strstr(script, "squares: multiples of"));
    assert_non_null(strstr(script, "largest exponent ln|"));
    assert_null(strstr(script, "$convergence"));
    free(script);
    diagnosis.spectra = NULL;
    script = script_of(f, f->system, &diagnosis);
    check_script(script,
                 (const char *const[]){"phase portrait", "one orbit", "impacts", "shapes", "Floquet", NULL});
    assert_null(strstr(script, "$low1"));
    free(script);
    saltus_spectra_clear(&spectra);
}

/* The text about a chaotic motion; unknown numbers are left out. */
static void sheets_of_chaos_have_their_panels(void **state) {
    fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_spectra spectra = {0};
    saltus_spectrum_options options = saltus_spectrum_defaults();
    saltus_lyapunov_progress history[] = {
        {10, 0.9, NAN}, {20, 0.8, INFINITY}, {30, 0.77, 0.02}, {40, 0.75, 0.01}};
    saltus_motion chaos = f->motion;
    chaos.verdict = SALTUS_CHAOTIC;
    strcpy(chaos.label, "chaotic");
    chaos.periods = 0;
    chaos.lyapunov = 0.75;
    chaos.lyapunov_error = 0.01;
    chaos.evidence = (saltus_evidence){.periods = 40,
                                       .members = 8,
                                       .half = {0.76, 0.74},
                                       .half_errors = {0.02, 0.02},
                                       .zero_one = 0.99,
                                       .dimension = NAN,
                                       .dimension_error = NAN,
                                       .broadband = 1e-5,
                                       .laminar = 0.25,
                                       .laminar_period = 3,
                                       .longest_phase = 70,
                                       .history = history,
                                       .history_count = 4};
    options.quantity_count = 1;
    options.per_period = 64;
    options.periods = 64;
    check_ok(saltus_spectra_run(f->system, chaos.state, 0, &options, &spectra, &message), &message);
    const saltus_diagnosis diagnosis = {
        .motion = &chaos, .record = &f->record, .section = &f->record, .spectra = &spectra};
    char *script = script_of(f, f->system, &diagnosis);
    check_script(script, (const char *const[]){"phase portrait", "time history; marks: impacts",
                                               "stroboscopic section, 4 points", "impacts of 4",
                                               "displacement", "convergence", NULL});
    assert_non_null(strstr(script, "largest exponent 0.750 ± 0.010 per unit of time"));
    assert_non_null(strstr(script, "0–1 test 0.990"));
    assert_non_null(strstr(script, "broadband fraction 1.0·10^{−5}"));
    assert_non_null(strstr(script, "intermittent: 25 % of the time near a motion of period 3 "));
    assert_null(strstr(script, "dimension"));
    assert_non_null(strstr(script, "$convergence << EOD\n# time exponent standard-error\n30 "));
    free(script);
    saltus_spectra_clear(&spectra);
}

/* Without measurement the page says what is lacking, and the shapes take the place. */
static void sheets_of_the_undecided_say_why(void **state) {
    fixture *f = *state;
    saltus_motion undecided = f->motion;
    undecided.verdict = SALTUS_UNDECIDED;
    strcpy(undecided.label, "undecided");
    strcpy(undecided.reason, "exponent 0.1 +- 0.2; more periods (--measure) would tell");
    undecided.periods = 0;
    undecided.lyapunov = undecided.lyapunov_error = NAN;
    const saltus_diagnosis diagnosis = {.motion = &undecided, .record = &f->record};
    char *script = script_of(f, f->system, &diagnosis);
    check_script(script, (const char *const[]){"phase portrait", "time history", "stroboscopic section",
                                               "impacts", "shapes", NULL});
    assert_non_null(strstr(script, "exponent 0.1 ± 0.2; more periods (--measure) would tell"));
    free(script);
}

/* A mass that has come to rest: there is nothing to analyse. */
static void sheets_of_rest_are_short(void **state) {
    fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_spec spec = oscillator_spec(0.5, 1, 0, 1);
    saltus_system *mass = build(&spec);
    saltus_classify_options how = saltus_classify_defaults();
    saltus_motion motion = {0};
    saltus_trajectory record = {0};
    saltus_spectra spectra = {0};
    saltus_spectrum_options options = saltus_spectrum_defaults();
    const double start[] = {0.1, 0};
    check_ok(saltus_classify(mass, start, &how, &motion, &message), &message);
    assert_int_equal(motion.verdict, SALTUS_EQUILIBRIUM);
    check_ok(saltus_trajectory_record(mass, motion.state, &f->options, 0, 4, per_period, &record, &message),
             &message);
    check_ok(saltus_motion_spectra(mass, &motion, &options, &spectra, &message), &message);
    const saltus_diagnosis diagnosis = {.motion = &motion, .record = &record, .spectra = &spectra};
    char *script = script_of(f, mass, &diagnosis);
    if (motion.multiplier_count > 0)
        check_script(script, (const char *const[]){"phase portrait", "Floquet", "time history", NULL});
    else
        check_script(script, (const char *const[]){"phase portrait", "time history", NULL});
    free(script);
    saltus_spectra_clear(&spectra);
    saltus_trajectory_clear(&record);
    saltus_motion_clear(&motion);
    saltus_system_free(mass);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(json_tells_the_motion),
        cmocka_unit_test(json_says_null_where_nothing_is_known),
        cmocka_unit_test(text_gives_the_verdict_first),
        cmocka_unit_test(samples_lie_at_exact_phases),
        cmocka_unit_test(impacts_have_two_sides),
        cmocka_unit_test(contacts_are_recorded),
        cmocka_unit_test(records_have_their_limits),
        cmocka_unit_test(an_interrupted_record_is_a_begin),
        cmocka_unit_test(csv_explains_itself),
        cmocka_unit_test(hdf5_reads_back),
        cmocka_unit_test(hdf5_is_reproducible_and_may_be_empty),
        cmocka_unit_test(unwritable_paths_leave_nothing),
        cmocka_unit_test(wrong_endings_are_refused),
        cmocka_unit_test(absent_gnuplot_is_named),
        cmocka_unit_test(failing_gnuplot_is_quoted),
        cmocka_unit_test(sheets_are_drawn),
        cmocka_unit_test(sheets_of_orbits_have_their_panels),
        cmocka_unit_test(sheets_of_chaos_have_their_panels),
        cmocka_unit_test(sheets_of_the_undecided_say_why),
        cmocka_unit_test(sheets_of_rest_are_short),
    };
    return cmocka_run_group_tests(tests, open_fixture, close_fixture);
}
