/* Files hold the library's data, field by field and number by number, the same in every format; sizes up to a
 * limit are accepted, larger ones refused or cut.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "folder.h"
#include "json.h"

#include <hdf5.h>
#include <unistd.h>

#include "record/hdf5.h"

/* A folder and the trajectory of two masses that hit each other. */
typedef struct fixture {
    char folder[64];
    saltus_scene scene;
    saltus_system *system;
    saltus_flow_options options;
    saltus_trajectory record;
} fixture;

static const char *path_in(const fixture *f, const char *name, char path[128]) {
    snprintf(path, 128, "%s/%s", f->folder, name);
    return path;
}

static int open_fixture(void **state) {
    saltus_message message = {.text = ""};
    fixture *f = calloc(1, sizeof *f);
    const double start[4] = {0.1, 0, 0.3, -0.2};
    strcpy(f->folder, "/tmp/saltus-test-XXXXXX");
    /* Equal results give equal files at any time. */
    setenv("SOURCE_DATE_EPOCH", "0", 1);
    assert_non_null(mkdtemp(f->folder));
    check_ok(saltus_scene_load("two-mass", &f->scene, &message), &message);
    f->system = build(&f->scene.spec);
    f->options = saltus_flow_defaults();
    f->options.rtol = 1e-9;
    f->options.atol = 3e-11;
    check_ok(saltus_trajectory_record(f->system, start, &f->options, 0, 6, 24, &f->record, &message),
             &message);
    assert_true(f->record.event_count > 2);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    *state = f;
    return 0;
}

static int close_fixture(void **state) {
    fixture *f = *state;
    folder_files(f->folder, true);
    rmdir(f->folder);
    saltus_trajectory_clear(&f->record);
    saltus_system_free(f->system);
    free(f);
    return 0;
}

static int run(const fixture *f, const char *arguments) {
    char line[800];
    snprintf(line, sizeof line, "cd %s && %s %s >out 2>err", f->folder, SALTUS_COMMAND, arguments);
    return system(line);
}

/* Count datasets, and those without one of the filters. */
typedef struct census {
    int sets, bare;
} census;

static herr_t look_at_filters(hid_t group, const char *name, const H5O_info_t *info, void *context) {
    census *c = context;
    if (info->type != H5O_TYPE_DATASET)
        return 0;
    hid_t set = H5Dopen2(group, name, H5P_DEFAULT), list = H5Dget_create_plist(set);
    bool sums = false, shuffled = false, short_ = false;
    for (int k = 0; k < H5Pget_nfilters(list); k++) {
        unsigned flags, words[16];
        size_t count = 16;
        H5Z_filter_t filter = H5Pget_filter2(list, (unsigned)k, &flags, &count, words, 0, NULL, NULL);
        sums |= filter == H5Z_FILTER_FLETCHER32;
        shuffled |= filter == H5Z_FILTER_SHUFFLE;
        short_ |= filter == H5Z_FILTER_DEFLATE;
    }
    /* An empty dataset has no checksum. */
    hid_t space = H5Dget_space(set);
    bool empty = H5Sget_simple_extent_npoints(space) == 0;
    H5Sclose(space);
    c->sets++;
    c->bare += H5Aexists(set, "units") <= 0 || H5Aexists(set, "description") <= 0;
    if (!empty)
        c->bare += !sums || !shuffled || !short_ || H5Pget_layout(list) != H5D_CHUNKED;
    H5Pclose(list);
    H5Dclose(set);
    return 0;
}

/* Every dataset of every kind of file is stored in chunks, shuffled, deflated and with a checksum. */
static void every_dataset_has_a_checksum(void **state) {
    static const char *const lines[] = {
        "simulate impact-oscillator --periods 2 -o x.h5",
        "continue impact-oscillator --in omega=0.99:1.01 --points 2 --at 1.005 -o x.h5",
        ("sweep impact-oscillator --over omega=0.9:1.1:3 --over F=0.4:0.5:2 --what "
         "turning,impacts,stroboscopic,lyapunov --quiet -o x.h5"),
        "basins impact-oscillator --over q1=0:0.2:2 --over v1=0:0.2:2 --quiet -o x.h5"};
    const fixture *f = *state;
    char path[128];
    for (int k = 0; k < 4; k++) {
        census c = {0, 0};
        assert_int_equal(run(f, lines[k]), 0);
        hid_t file = H5Fopen(path_in(f, "x.h5", path), H5F_ACC_RDONLY, H5P_DEFAULT);
        assert_true(file >= 0);
        assert_true(H5Ovisit(file, H5_INDEX_NAME, H5_ITER_NATIVE, look_at_filters, &c) >= 0);
        H5Fclose(file);
        assert_true(c.sets > 5);
        if (c.bare)
            fail_msg("%s: %d of %d datasets lack a filter", lines[k], c.bare, c.sets);
        remove(path);
    }
}

/* Replace a dataset by one of an extent for which nothing is stored, and seal the file again. */
static void forge_extent(const char *path, const char *name, hsize_t rows) {
    hsize_t size[4], chunk[4] = {1, 1, 1, 1};
    char seal[SALTUS_H5_SEAL + 1];
    FILE *stream = fopen(path, "rb+");
    assert_non_null(stream);
    fseek(stream, 0, SEEK_END);
    assert_int_equal(ftruncate(fileno(stream), ftell(stream) - SALTUS_H5_SEAL), 0);
    fclose(stream);
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT), set = H5Dopen2(file, name, H5P_DEFAULT);
    hid_t space = H5Dget_space(set), type = H5Dget_type(set);
    int rank = H5Sget_simple_extent_dims(space, size, NULL);
    H5Sclose(space);
    H5Dclose(set);
    H5Ldelete(file, name, H5P_DEFAULT);
    size[0] = rows;
    hid_t list = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(list, rank, chunk);
    space = H5Screate_simple(rank, size, NULL);
    set = H5Dcreate2(file, name, type, space, H5P_DEFAULT, list, H5P_DEFAULT);
    assert_true(set >= 0);
    H5Dclose(set);
    H5Sclose(space);
    H5Pclose(list);
    H5Tclose(type);
    H5Fclose(file);
    stream = fopen(path, "rb+");
    fseek(stream, 0, SEEK_END);
    assert_true(saltus_h5_seal(fileno(stream), ftell(stream), seal));
    fwrite(seal, 1, SALTUS_H5_SEAL, stream);
    fclose(stream);
}

/* A file that claims far more rows than it has bytes is refused before memory is requested. */
static void an_extent_without_storage_is_refused(void **state) {
    const fixture *f = *state;
    char path[128];
    saltus_message message;
    static const char *const points[] = {"points/state", "points/kind", "events/time"};
    static const char *const clouds[] = {"turning/displacement", "impacts/speed"};
    for (int k = 0; k < 3; k++) {
        saltus_branch_file file;
        assert_int_equal(run(f, "continue impact-oscillator --in omega=0.99:1.01 --points 2 --force -o x.h5"),
                         0);
        forge_extent(path_in(f, "x.h5", path), points[k], k ? 100000000 : 5000);
        message.text[0] = '\0';
        assert_int_equal(saltus_branch_file_read(path, &file, &message), SALTUS_BAD_INPUT);
        assert_non_null(strstr(message.text, path));
    }
    for (int k = 0; k < 2; k++) {
        saltus_sweep_file file;
        assert_int_equal(run(f, "sweep impact-oscillator --over omega=0.9:1.1:3 --quiet --force -o x.h5"), 0);
        forge_extent(path_in(f, "x.h5", path), clouds[k], k ? 100000000 : 50000);
        message.text[0] = '\0';
        assert_int_equal(saltus_sweep_file_read(path, &file, &message), SALTUS_BAD_INPUT);
        assert_non_null(strstr(message.text, path));
    }
    remove(path);
}

/* A number as JSON has it: null where it is not finite. */
static void check_member(const json *object, const char *path, double value) {
    const json *found = json_at(object, path);
    if (isfinite(value) ? found->kind != JSON_NUMBER || found->number != value : found->kind != JSON_NULL)
        fail_msg("%s is %.17g, not %.17g", path, found->number, value);
}

static void check_pair(const json *object, const char *path, const double *pair) {
    char inner[64];
    assert_int_equal(json_count(json_at(object, path)), 2);
    for (int k = 0; k < 2; k++) {
        snprintf(inner, sizeof inner, "%s.%d", path, k);
        check_member(object, inner, pair[k]);
    }
}

static json *motion_json(const fixture *f, const saltus_scene *scene, const saltus_system *system,
                         const saltus_motion *motion) {
    char path[128];
    size_t length;
    FILE *file = fopen(path_in(f, "motion.json", path), "wb");
    assert_non_null(file);
    saltus_write_motion_json(file, scene, system, motion);
    fclose(file);
    char *text = read_all(path, &length);
    json *object = json_read(text);
    free(text);
    remove(path);
    return object;
}

static void check_spec(const json *object, const saltus_spec *spec) {
    int count;
    char path[64];
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    assert_string_equal(json_text_at(object, "parameters.model"), saltus_model_name(spec->model));
    for (int k = 0; k < count; k++) {
        snprintf(path, sizeof path, "parameters.%s", p[k].name);
        check_member(object, path, spec->parameters[k]);
    }
    assert_int_equal(json_count(json_at(object, "parameters.stops")), spec->stop_count);
    for (int s = 0; s < spec->stop_count; s++) {
        static const char *const sides[] = {"", "upper", "lower", "both"};
        const char *const keys[] = {"d", "r"};
        const double values[] = {spec->stops[s].d, spec->stops[s].r};
        for (int k = 0; k < 2; k++) {
            snprintf(path, sizeof path, "parameters.stops.%d.%s", s, keys[k]);
            check_member(object, path, values[k]);
        }
        snprintf(path, sizeof path, "parameters.stops.%d.sides", s);
        assert_string_equal(json_text_at(object, path), sides[spec->stops[s].sides]);
        snprintf(path, sizeof path, "parameters.stops.%d.weight", s);
        check_pair(object, path, spec->stops[s].weight);
    }
}

/* The evidence of a chaotic verdict; with made-up numbers that all differ, so that none can stand for
 * another. */
static void a_chaotic_motion_reads_back_field_by_field(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_scene scene = {.name = "chaos"};
    saltus_motion motion;
    saltus_classify_options how = saltus_classify_defaults();
    const double start[2] = {-0.5, 0};
    scene.spec = oscillator_spec(0.05, 1, 1, 2.8);
    add_stop(&scene.spec, 0, 0.8, SALTUS_UPPER);
    saltus_system *system = build(&scene.spec);
    how.transient = 100;
    how.measure = 8000;
    how.lifetime = how.measure / 24;
    check_ok(saltus_classify(system, start, &how, &motion, &message), &message);
    assert_int_equal(motion.verdict, SALTUS_CHAOTIC);
    for (int made_up = 0; made_up < 2; made_up++) {
        saltus_evidence *e = &motion.evidence;
        if (made_up) {
            double *const reals[] = {&e->half[0],
                                     &e->half[1],
                                     &e->half_errors[0],
                                     &e->half_errors[1],
                                     &e->zero_one,
                                     &e->zero_one_quartiles[0],
                                     &e->zero_one_quartiles[1],
                                     &e->dimension,
                                     &e->dimension_error,
                                     &e->broadband,
                                     &e->impacts_per_period,
                                     &e->laminar,
                                     &motion.lyapunov,
                                     &motion.lyapunov_error,
                                     &motion.largest,
                                     &motion.smallest,
                                     &motion.rms,
                                     &motion.residual};
            for (size_t k = 0; k < sizeof reals / sizeof reals[0]; k++)
                *reals[k] = 0.1 + 1.0 / (double)(k + 3);
            e->periods = 4001;
            e->members = 7;
            e->curves = 3;
            e->laminar_period = 5;
            e->longest_phase = 6000000000;
            e->left = 2;
            motion.transient = 7000000000;
            strcpy(e->left_for, "3/2");
            strcpy(e->stable_orbit, "1/4");
            strcpy(motion.reason, "a \"quoted\" \\ reason\twith a tab");
        }
        json *o = motion_json(f, &scene, system, &motion);
        assert_string_equal(json_text_at(o, "version"), SALTUS_VERSION);
        assert_string_equal(json_text_at(o, "scene"), "chaos");
        assert_string_equal(json_text_at(o, "label"), motion.label);
        assert_string_equal(json_text_at(o, "kind"), "chaotic");
        assert_int_equal(json_at(o, "impacts")->kind, JSON_NULL);
        check_member(o, "periods", motion.periods);
        check_member(o, "sticking_intervals", motion.sticking_intervals);
        assert_int_equal(json_at(o, "impacts_per_response")->kind, JSON_NULL);
        assert_int_equal(json_count(json_at(o, "state")), motion.dimension);
        check_pair(o, "state", motion.state);
        assert_int_equal(json_count(json_at(o, "events")), motion.event_count);
        assert_int_equal(json_count(json_at(o, "multipliers")), motion.multiplier_count);
        assert_int_equal(json_at(o, "stable")->kind, motion.stable ? JSON_TRUE : JSON_FALSE);
        assert_string_equal(json_text_at(o, "mirror"), "none");
        check_member(o, "residual", motion.residual);
        assert_int_equal(json_at(o, "sum_rule")->kind, JSON_NULL);
        check_member(o, "lyapunov", motion.lyapunov);
        check_member(o, "lyapunov_standard_error", motion.lyapunov_error);
        check_member(o, "evidence.periods", (double)e->periods);
        check_member(o, "evidence.members", e->members);
        check_pair(o, "evidence.halves", e->half);
        check_pair(o, "evidence.half_errors", e->half_errors);
        check_member(o, "evidence.zero_one_test", e->zero_one);
        check_pair(o, "evidence.zero_one_quartiles", e->zero_one_quartiles);
        check_member(o, "evidence.correlation_dimension", e->dimension);
        check_member(o, "evidence.correlation_dimension_error", e->dimension_error);
        check_member(o, "evidence.broadband", e->broadband);
        check_member(o, "evidence.closed_curves", e->curves);
        check_member(o, "evidence.impacts_per_period", e->impacts_per_period);
        check_member(o, "evidence.laminar", e->laminar);
        check_member(o, "evidence.laminar_period", e->laminar_period);
        check_member(o, "evidence.longest_phase", (double)e->longest_phase);
        check_member(o, "evidence.left", e->left);
        assert_string_equal(json_text_at(o, "evidence.left_for"), e->left_for);
        assert_string_equal(json_text_at(o, "evidence.stable_orbit"), e->stable_orbit);
        assert_int_equal(json_at(o, "contact_force")->kind, JSON_NULL);
        check_member(o, "largest_displacement", motion.largest);
        check_member(o, "smallest_displacement", motion.smallest);
        check_member(o, "rms_displacement", motion.rms);
        check_member(o, "transient", (double)motion.transient);
        assert_string_equal(json_text_at(o, "reason"), motion.reason);
        check_spec(o, &scene.spec);
        json_free(o);
    }
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

static double *reals_of(hid_t file, const char *name, long long count) {
    double *values = calloc((size_t)count + 1, sizeof *values);
    hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
    assert_true(set >= 0);
    hid_t space = H5Dget_space(set);
    assert_int_equal(H5Sget_simple_extent_npoints(space), count);
    assert_true(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    H5Sclose(space);
    H5Dclose(set);
    return values;
}

/* The same trajectory as CSV and as HDF5 equals the record, number by number, and both name each row's
 * event. */
static void a_trajectory_is_the_same_in_every_format(void **state) {
    const fixture *f = *state;
    const saltus_trajectory *r = &f->record;
    saltus_message message = {.text = ""};
    char path[128];
    size_t length;
    int n = r->dimension;
    check_ok(saltus_write_trajectory(path_in(f, "run.csv", path), &f->scene, f->system, &f->options, r, NULL,
                                     &message),
             &message);
    char *text = read_all(path, &length), *rest = text;
    check_ok(saltus_write_trajectory(path_in(f, "run.h5", path), &f->scene, f->system, &f->options, r, NULL,
                                     &message),
             &message);
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    assert_true(file >= 0);
    double *time = reals_of(file, "trajectory/time", r->samples);
    double *states = reals_of(file, "trajectory/states", r->samples * n);
    double *displacement = reals_of(file, "trajectory/displacement", r->samples);
    double *velocity = reals_of(file, "trajectory/velocity", r->samples);
    double *before = reals_of(file, "events/velocity_before", r->event_count);
    double *after = reals_of(file, "events/velocity_after", r->event_count);
    double *when = reals_of(file, "events/time", r->event_count);
    double *stop = reals_of(file, "events/stop", r->event_count),
           *side = reals_of(file, "events/side", r->event_count);
    double *rows = reals_of(file, "events/row", r->event_count);
    H5Fclose(file);
    long long row = -1, event = 0;
    for (char *line = strtok_r(rest, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
        if (line[0] == '#')
            continue;
        if (row < 0) {
            assert_string_equal(line, "time_over_T,displacement,velocity,q1,q2,v1,v2,stop,side,event");
            row = 0;
            continue;
        }
        const double record[] = {r->time[row], r->displacement[row], r->velocity[row]};
        const double stored[] = {time[row], displacement[row], velocity[row]};
        char *at = line;
        for (int k = 0; k < 3 + n; k++, at += *at == ',') {
            double value = strtod(at, &at);
            assert_true(value == (k < 3 ? record[k] : r->states[row * n + k - 3]));
            assert_true(value == (k < 3 ? stored[k] : states[row * n + k - 3]));
        }
        if (event < r->event_count && r->event_rows[event] == row) {
            const saltus_event *e = &r->events[event];
            char wanted[64];
            snprintf(wanted, sizeof wanted, "1,upper,%s",
                     e->kind == SALTUS_IMPACT  ? "impact"
                     : e->kind == SALTUS_STICK ? "stick"
                                               : "release");
            assert_string_equal(at, wanted);
            assert_true(stop[event] == 1 && side[event] == 1 && rows[event] == (double)row);
            assert_true(before[event] == e->velocity_before);
            assert_true(after[event] == (e->kind == SALTUS_STICK ? 0 : e->velocity_after));
            assert_true(when[event] == saltus_time_periods(e->time) && when[event] == r->time[row]);
            /* Two masses of the same weight: the relative velocity turns round by r. */
            if (e->kind == SALTUS_IMPACT)
                check_near(e->velocity_after, -f->scene.spec.stops[0].r * e->velocity_before, 1e-12);
            event++;
        } else
            assert_string_equal(at, ",,");
        row++;
    }
    assert_int_equal(row, r->samples);
    assert_int_equal(event, r->event_count);
    free(text);
    double *const all[] = {time, states, displacement, velocity, before, after, when, stop, side, rows};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; k++)
        free(all[k]);
    folder_files(f->folder, true);
}

static void fill(char *text, size_t length) {
    memset(text, 'x', length);
    text[length] = '\0';
}

/* A record that ended early says so in every format. */
static void an_interrupted_record_says_so(void **state) {
    static const char *const names[] = {"cut.csv", "cut.h5"};
    const fixture *f = *state;
    saltus_trajectory record = f->record;
    saltus_message message = {.text = ""};
    char path[128];
    for (int k = 0; k < 4; k++) {
        record.interrupted = k < 2;
        check_ok(saltus_write_trajectory(path_in(f, names[k % 2], path), &f->scene, f->system, &f->options,
                                         &record, NULL, &message),
                 &message);
        assert_int_equal(saltus_file_identify(path).complete, k >= 2);
    }
}

/* A title of 159 bytes is kept, one of 160 refused; a file's name is cut to a scene name's length. */
static void names_and_titles_have_their_limits(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_scene scene;
    char title[256], text[512], name[256], path[400];
    enum { title_room = sizeof scene.title, name_room = sizeof scene.name };
    for (size_t length = title_room - 2; length <= title_room + 1; length++) {
        fill(title, length);
        snprintf(text, sizeof text, "title: %s\nmodel: oscillator\nomega: 1\n", title);
        saltus_status status = saltus_scene_parse(text, strlen(text), "here", &scene, &message);
        assert_int_equal(status, length < title_room ? SALTUS_OK : SALTUS_BAD_INPUT);
        if (status == SALTUS_OK)
            assert_string_equal(scene.title, title);
        else
            assert_non_null(strstr(message.text, "title"));
    }
    for (size_t length = name_room - 2; length <= name_room + 1; length++) {
        fill(name, length);
        snprintf(path, sizeof path, "%s/%s.yaml", f->folder, name);
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        fputs("model: oscillator\nomega: 1\n", file);
        fclose(file);
        check_ok(saltus_scene_load(path, &scene, &message), &message);
        assert_int_equal(strlen(scene.name), length < name_room ? length : name_room - 1);
        assert_memory_equal(scene.name, name, strlen(scene.name));
        remove(path);
    }
    /* A name is cut between two characters, never within one. */
    static const char *const letters[] = {"\xc3\xa9", "\xe2\x82\xac", "\xf0\x9f\x8e\xb5"};
    for (size_t l = 0; l < 3; l++)
        for (size_t first = name_room - 6; first < name_room + 1; first++)
            for (int tail = 0; tail < 2; tail++) {
                size_t step = strlen(letters[l]);
                fill(name, first);
                strcat(strcat(name, letters[l]), tail ? "x" : "");
                snprintf(path, sizeof path, "there/%s.yaml", name);
                check_ok(saltus_scene_parse("model: pipe", 11, path, &scene, &message), &message);
                size_t whole = strlen(name), most = name_room - 1,
                       kept = whole <= most          ? whole
                              : first + step <= most ? most
                              : first < most         ? first
                                                     : most;
                assert_int_equal(strlen(scene.name), kept);
                assert_memory_equal(scene.name, name, kept);
            }
}

/* The longest name, title, label and reason, and those one letter shorter, are read back unchanged from every
 * kind of file. */
static void the_longest_words_come_back_whole(void **state) {
    const fixture *f = *state;
    for (size_t less = 0; less < 2; less++) {
        saltus_message message = {.text = ""};
        saltus_scene scene = f->scene;
        char path[128], line[256];
        size_t length;
        fill(scene.name, sizeof scene.name - 1 - less);
        fill(scene.title, sizeof scene.title - 1 - less);
        scene.name[0] = scene.title[0] = 'b';
        scene.name[sizeof scene.name - 2 - less] = scene.title[sizeof scene.title - 2 - less] = 'e';
        /* A branch of one point. */
        double start[4] = {0.1, 0.2, 0.3, 0.4};
        saltus_multiplier multipliers[4] = {{.re = 0.5, .log_modulus = -0.5}};
        saltus_branch_point point = {.kind = SALTUS_POINT_EP,
                                     .parent = -1,
                                     .value = {1, NAN},
                                     .spec = scene.spec,
                                     .periods = 1,
                                     .dimension = 4,
                                     .state = start,
                                     .multipliers = multipliers,
                                     .grazing_time = NAN,
                                     .contact_force = NAN};
        fill(point.label, sizeof point.label - 1 - less);
        fill(point.label_after, sizeof point.label_after - 1 - less);
        fill(point.reason, sizeof point.reason - 1 - less);
        saltus_branch_options how = saltus_branch_defaults();
        saltus_branch_output *branch = NULL;
        saltus_branch_file read;
        strcpy(how.key[0], "omega");
        how.high[0] = 2;
        path_in(f, "b.h5", path);
        check_ok(saltus_branch_output_open(path, &scene, 1, start, &how, NULL, &branch, &message), &message);
        check_ok(saltus_branch_output_add(branch, &point, &message), &message);
        check_ok(saltus_branch_output_close(branch, true, &message), &message);
        check_ok(saltus_branch_file_read(path, &read, &message), &message);
        assert_string_equal(read.scene, scene.name);
        assert_string_equal(read.title, scene.title);
        assert_string_equal(read.points[0].label, point.label);
        assert_string_equal(read.points[0].label_after, point.label_after);
        assert_string_equal(read.points[0].reason, point.reason);
        saltus_branch_file_clear(&read);
        /* A start taken from it keeps the label. */
        saltus_start from;
        snprintf(line, sizeof line, "%s:EP1", path);
        check_ok(saltus_start_read(line, NULL, &from, &message), &message);
        assert_string_equal(from.label, point.label);
        /* A sweep that has not begun. */
        saltus_axis axis = {.key = "omega", .count = 1, .low = 1, .high = 1};
        saltus_sweep_options options = saltus_sweep_defaults();
        saltus_sweep *sweep = NULL;
        saltus_sweep_output *output = NULL;
        saltus_sweep_file file;
        check_ok(saltus_sweep_new(&scene, &axis, 1, &options, &sweep, &message), &message);
        path_in(f, "s.h5", path);
        check_ok(saltus_sweep_output_open(path, sweep, false, false, NULL, &output, &message), &message);
        check_ok(saltus_sweep_output_close(output, &message), &message);
        saltus_sweep_free(sweep);
        check_ok(saltus_sweep_file_read(path, &file, &message), &message);
        assert_string_equal(file.scene, scene.name);
        assert_string_equal(file.title, scene.title);
        check_ok(saltus_write_sweep_csv(path_in(f, "s.csv", path), &file, SALTUS_TABLE_ROWS, &message),
                 &message);
        saltus_sweep_file_clear(&file);
        for (int k = 0; k < 2; k++) {
            char *text = read_all(path, &length);
            snprintf(line, sizeof line, "\n# scene: %s\n", scene.name);
            assert_non_null(strstr(text, line));
            snprintf(line, sizeof line, "\n# title: %s\n", scene.title);
            assert_non_null(strstr(text, line));
            free(text);
            path_in(f, "r.csv", path);
            check_ok(
                saltus_write_trajectory(path, &scene, f->system, &f->options, &f->record, NULL, &message),
                &message);
        }
        folder_files(f->folder, true);
    }
}

/* The title of a changed scene lists the settings, or says that they are too many. */
static void titles_list_the_settings(void **state) {
    const fixture *f = *state;
    enum { most = sizeof f->scene.title - 1 };
    for (int length = most - 2; length <= most + 3; length++) {
        char title[400] = "changed: c=0.2500000000000000000000000000000000000000000000000 F=0.5",
             command[600], path[128];
        size_t size;
        while ((int)strlen(title) < length)
            strcat(title, "0");
        if (length == most + 3)
            strcat(title, " d=1.5 r=0.5");
        snprintf(command, sizeof command,
                 "simulate impact-oscillator --periods 1 --samples 4 --set %s -o t.csv", title + 9);
        assert_int_equal(run(f, command), 0);
        char *text = read_all(path_in(f, "t.csv", path), &size), *at = strstr(text, "\n# title: ");
        assert_non_null(at);
        at += 10;
        at[strcspn(at, "\n")] = '\0';
        if (strlen(title) > most)
            strcpy(title + most - 3, "...");
        assert_string_equal(at, title);
        free(text);
    }
}

/* A message names file, line, key and value: for every parameter of every model and every key of a stop. */
static void each_key_of_a_scene_file_is_named_when_it_is_wrong(void **state) {
    static const char *const models[] = {"pipe", "oscillator"};
    static const char *const stop[] = {"d: fast",     "r: 2",    "r: -0.5",
                                       "sides: left", "xi: 1.5", "weight: [x, 1]"};
    static const char *const values[] = {"fast", "2", "-0.5", "left", "1.5", "x"};
    (void)state;
    saltus_message message;
    saltus_scene scene;
    char text[256], wanted[64];
    for (int m = 0; m < 2; m++) {
        int count;
        const saltus_parameter *p = saltus_model_parameters(saltus_model_find(models[m]), &count);
        for (int k = 0; k < count; k++) {
            snprintf(text, sizeof text, "title: t\nmodel: %s\n\n%s: fast\n", models[m], p[k].name);
            assert_int_equal(saltus_scene_parse(text, strlen(text), "some.yaml", &scene, &message),
                             SALTUS_BAD_INPUT);
            snprintf(wanted, sizeof wanted, "some.yaml:4: %s = \"fast\"", p[k].name);
            if (!strstr(message.text, wanted))
                fail_msg("'%s' instead of '%s'", message.text, wanted);
        }
        for (int k = 0; k < 6; k++) {
            bool foreign = (m == 0 && k == 5) || (m == 1 && k == 4);
            snprintf(text, sizeof text, "model: %s\nomega: 1\nstop:\n  %s\n%s", models[m], stop[k],
                     k ? "  d: 1\n" : "");
            assert_int_equal(saltus_scene_parse(text, strlen(text), "some.yaml", &scene, &message),
                             SALTUS_BAD_INPUT);
            snprintf(wanted, sizeof wanted, "%.*s", (int)strcspn(stop[k], ":"), stop[k]);
            if (!strstr(message.text, "some.yaml:4: ") || !strstr(message.text, wanted) ||
                (!foreign && !strstr(message.text, values[k])))
                fail_msg("%s, %s: %s", models[m], stop[k], message.text);
        }
    }
}

/* Keys of 31 letters are accepted, those of 32 refused with the full text; so are folders of 1023 and 1024
 * letters. */
static void words_of_the_command_line_have_their_limits(void **state) {
    static const struct {
        const char *begin, *end, *first, *named;
        int most, code;
    } words[] = {
        {"plot x.h5 -o x.svg --range ", "=0:1", "x.h5", "=0:1: must have the form key=low:high", 31, 2},
        {"plot x.h5 -o x.svg --label ", "=0,d=1,n", "x.h5", "=0,d=1,n: must have the form", 31, 2},
        {"plot x.h5 -o x.svg --label d=1,", "=0,n", "x.h5", "=0,n: must have the form", 31, 2},
        {"continue impact-oscillator -o x.h5 --in ", "=0:1", ": neither a parameter of the model oscillator",
         "=0:1: must have the form key=low:high", 31, 2},
        {"sweep impact-oscillator -o x.h5 --over ", "=0:1:3", ": neither a parameter",
         "=0:1:3: no key stands before", 31, 2},
        {"paper -o ", "", "File name too long", "the name is too long", 1023, 2},
    };
    const fixture *f = *state;
    for (size_t k = 0; k < sizeof words / sizeof words[0]; k++)
        for (int length = words[k].most; length <= words[k].most + 1; length++) {
            char word[1100], command[1400], path[128];
            size_t size;
            fill(word, (size_t)length);
            snprintf(command, sizeof command, "cd %s && %s %s%s%s >out 2>err", f->folder, SALTUS_COMMAND,
                     words[k].begin, word, words[k].end);
            assert_int_equal(WEXITSTATUS(system(command)), words[k].code);
            char *text = read_all(path_in(f, "err", path), &size);
            bool beyond = length > words[k].most;
            if (!strstr(text, beyond ? words[k].named : words[k].first) || !strstr(text, beyond ? word : ""))
                fail_msg("%d letters in %s: %s", length, words[k].begin, text);
            free(text);
        }
}

/* The head and last row of the exponent's CSV agree with JSON. */
static void exponents_are_the_same_in_csv_and_json(void **state) {
    const fixture *f = *state;
    char path[128], line[64];
    size_t length;
    assert_int_equal(run(f, "lyapunov impact-oscillator --transient 20 --periods 1800 --json -o x.csv"), 0);
    char *text = read_all(path_in(f, "out", path), &length),
         *csv = read_all(path_in(f, "x.csv", path), &length);
    json *o = json_read(text);
    double exponent = json_number_at(o, "exponents.0"), error = json_number_at(o, "standard_errors.0");
    double time = json_number_at(o, "time");
    const char *result = strstr(csv, "# result: exponent = ");
    assert_non_null(result);
    char *end = NULL;
    assert_true(strtod(result + 21, &end) == exponent && strtod(strstr(end, "= ") + 2, NULL) == error);
    csv[length - 1] = '\0';
    const char *last = strrchr(csv, '\n') + 1;
    assert_true(strtod(last, &end) == time && strtod(end + 1, &end) == exponent &&
                strtod(end + 1, NULL) == error);
    snprintf(line, sizeof line, "# measured: %.0f periods, trajectories: %.0f", json_number_at(o, "periods"),
             json_number_at(o, "members"));
    assert_non_null(strstr(csv, line));
    check_near(time, json_number_at(o, "periods") * json_number_at(o, "period"), 1e-12 * time);
    assert_true(json_number_at(o, "largest") == exponent);
    json_free(o);
    free(text);
    free(csv);
}

/* Lists of the command line: 255 and 256 values of a repeatable option are accepted, 257 refused. */
static void lists_of_the_command_line_have_their_limits(void **state) {
    static const struct {
        const char *begin, *each, *end;
        int most;
        const char *first, *named; /* one of them alone; a part of the refusal */
    } lists[] = {
        {"plot x.h5 -o x.svg ", "--range o%d=0.9:1.1 ", "--show nothing", 256, "--show nothing", "--range"},
        {"plot x.h5 -o x.svg ", "--label omega=1,d=1,%d ", "--show nothing", 256, "--show nothing",
         "--label"},
        {"plot ", "x%d.h5 ", "-o x.svg --show nothing", 256, "--show nothing", "256 files"},
        {"check impact-oscillator ", "--set w%d=0.6 ", "--set F=x", 255, "--set w1=0.6: \"w1\": unknown key",
         "--set F=x: only 256"},
        {"check --set ", "w%d=0.6 ", "F=x impact-oscillator", 255, "--set w1=0.6: \"w1\": unknown key",
         "--set F=x: only 256"},
        {"plot x.h5 -o x.svg ", "--over y%d.h5 ", "--view nothing", 256, "--view nothing", "--over"},
        {"sweep impact-oscillator -o y.h5 ", "--over d%d=1,2 ", "--over d=x", 1, "--over d=x: the values",
         "--over d=x: only two axes"},
        {"spectrum two-mass ", "--of v%d ", "--of nothing", 1, "--of nothing", "--of nothing: only 2"},
        {"continue impact-oscillator -o x.h5 --in omega=0.9:1.1 --direction both --at ", "1,", "1,2", 254,
         "outside", "only 256"}};
    const fixture *f = *state;
    for (size_t k = 0; k < sizeof lists / sizeof lists[0]; k++)
        for (int count = lists[k].most - 1; count <= lists[k].most + 1; count++) {
            static char line[16000];
            char command[16400], path[128];
            size_t used = (size_t)snprintf(line, sizeof line, "%s", lists[k].begin), length;
            for (int i = 0; i < count; i++)
                used += (size_t)snprintf(line + used, sizeof line - used, lists[k].each, i + 1);
            snprintf(line + used, sizeof line - used, "%s", lists[k].end);
            snprintf(command, sizeof command, "cd %s && %s %s >out 2>err", f->folder, SALTUS_COMMAND, line);
            assert_int_equal(WEXITSTATUS(system(command)), 2);
            char *text = read_all(path_in(f, "err", path), &length);
            if (!strstr(text, count <= lists[k].most ? lists[k].first : lists[k].named))
                fail_msg("%d of %s: %s", count, lists[k].each, text);
            free(text);
        }
}

/* Freed memory is overwritten at once (by glibc, on request): a use after free would crash, or write
 * something else. */
static void memory_given_back_is_not_looked_into(void **state) {
    static const struct {
        const char *arguments, *file;
    } commands[] = {
        {"sweep impact-oscillator --over d=1,1.5 --over r=0.5,0.75 --what impacts --quiet", "a.h5"},
        {"sweep impact-oscillator --over d=1,1.5 --quiet", "a.csv"},
        {"basins impact-oscillator --over q1=0,0.5 --over v1=0,1 --quiet", "a.h5"},
        {"simulate impact-oscillator --periods 2", "a.h5"},
        {"continue impact-oscillator --in omega=0.99:1.01 --points 4 --rtol 1e-10 --quiet", "a.h5"},
        {"lyapunov impact-oscillator --transient 20 --periods 1600 --quiet", "a.csv"},
        {"export a.h5", "a.csv"},
    };
    const fixture *f = *state;
    for (size_t k = 0; k < sizeof commands / sizeof commands[0]; k++) {
        char command[500], path[128], *bytes[2];
        size_t length[2];
        if (strncmp(commands[k].arguments, "export", 6) == 0)
            assert_int_equal(run(f, "sweep impact-oscillator --over d=1,1.5 --quiet -o a.h5"), 0);
        for (int wiped = 0; wiped < 2; wiped++) {
            snprintf(command, sizeof command, "cd %s && %s %s %s -o %s >out 2>err", f->folder,
                     wiped ? "MALLOC_PERTURB_=165 GLIBC_TUNABLES=glibc.malloc.tcache_count=0" : "",
                     SALTUS_COMMAND, commands[k].arguments, commands[k].file);
            assert_int_equal(system(command), 0);
            bytes[wiped] = read_all(path_in(f, commands[k].file, path), &length[wiped]);
        }
        assert_int_equal(length[0], length[1]);
        assert_memory_equal(bytes[0], bytes[1], length[0]);
        free(bytes[0]);
        free(bytes[1]);
        folder_files(f->folder, true);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_dataset_has_a_checksum),
        cmocka_unit_test(an_extent_without_storage_is_refused),
        cmocka_unit_test(a_chaotic_motion_reads_back_field_by_field),
        cmocka_unit_test(a_trajectory_is_the_same_in_every_format),
        cmocka_unit_test(an_interrupted_record_says_so),
        cmocka_unit_test(names_and_titles_have_their_limits),
        cmocka_unit_test(the_longest_words_come_back_whole),
        cmocka_unit_test(titles_list_the_settings),
        cmocka_unit_test(each_key_of_a_scene_file_is_named_when_it_is_wrong),
        cmocka_unit_test(exponents_are_the_same_in_csv_and_json),
        cmocka_unit_test(lists_of_the_command_line_have_their_limits),
        cmocka_unit_test(words_of_the_command_line_have_their_limits),
        cmocka_unit_test(memory_given_back_is_not_looked_into),
    };
    return cmocka_run_group_tests(tests, open_fixture, close_fixture);
}
