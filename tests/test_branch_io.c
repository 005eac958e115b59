/* Branch files, starts read from files, descriptions of orbits, and bifurcation diagrams. The points are made
 * up: nothing of them may be lost, and nothing else be taken for them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "folder.h"
#include "foreign_text.h"
#include "reference.h"

#include <hdf5.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { point_count = 60, dimension = 10, events_most = 6 };

/* A scene, a branch of made-up points and a folder. */
typedef struct fixture {
    char folder[64];
    saltus_scene scene;
    saltus_system *system;
    reference reference;
    saltus_branch_options options;
    double values[2];
    saltus_branch_point points[point_count];
    double states[point_count][dimension];
    saltus_event events[point_count][events_most];
    saltus_multiplier multipliers[point_count][dimension];
} fixture;

static saltus_point_kind kind_of(int k) {
    static const saltus_point_kind kinds[] = {SALTUS_POINT_LP, SALTUS_POINT_PD, SALTUS_POINT_GR,
                                              SALTUS_POINT_CH, SALTUS_POINT_PD};
    return k == point_count - 1 ? SALTUS_POINT_EP : k % 10 == 9 ? kinds[k / 10] : SALTUS_POINT_REGULAR;
}

static void make_events(fixture *f, int k) {
    saltus_branch_point *p = &f->points[k];
    p->events = f->events[k];
    p->event_count = 2 + k % (events_most - 1);
    for (int e = 0; e < p->event_count; e++)
        f->events[k][e] = (saltus_event){.kind = e % 3 == 2 ? SALTUS_RELEASE
                                                 : e % 3    ? SALTUS_STICK
                                                            : SALTUS_IMPACT,
                                         .face = 0,
                                         .time = {e, 0.1 * e + 0.001 * k},
                                         .velocity_before = 0.2 * (1 + sin(0.1 * k)) / (1 + e),
                                         .velocity_after = -0.1 / (1 + e),
                                         .displacement = 0.035};
}

static void make_point(fixture *f, int k) {
    saltus_branch_point *p = &f->points[k];
    *p = (saltus_branch_point){.kind = kind_of(k),
                               .branch = k / 25,
                               .parent = k < 50 ? -1 : 0,
                               .step = k % 25,
                               .arclength = 0.01 * k,
                               .value = {42 + 0.1 * k, NAN},
                               .heading = 0.7,
                               .spec = f->scene.spec,
                               .periods = 4,
                               .impacts = k % 7 == 6 ? -1 : 4 + k / 20,
                               .sticking_intervals = k % 3,
                               .dimension = dimension,
                               .multiplier_count = dimension,
                               .state = f->states[k],
                               .multipliers = f->multipliers[k],
                               .unstable = k / 30,
                               .stable = k < 30,
                               .admissible = k % 11 != 0,
                               .residual = 1e-14 * k,
                               .iterations = 3,
                               .log_volume = -287.8,
                               .sum_rule = NAN,
                               .accuracy = 1e-12,
                               .grazing_time = NAN,
                               .contact_force = NAN};
    if (p->kind == SALTUS_POINT_GR) {
        p->grazing_time = 3.99;
        p->contact_force = 0.375;
        p->grazing_stop = p->grazing_side = 1;
    }
    set_parameter(&p->spec, "omega", p->value[0]);
    p->spec.stops[0].d = 0.035 + 1e-5 * k;
    snprintf(p->label, sizeof p->label, "%d/4", 4 + k / 20);
    snprintf(p->label_after, sizeof p->label_after, "%s", kind_of(k) == SALTUS_POINT_GR ? "5/4" : "");
    snprintf(p->reason, sizeof p->reason, "%s", kind_of(k) == SALTUS_POINT_EP ? "as \"asked\"" : "");
    for (int i = 0; i < dimension; i++) {
        f->states[k][i] = 1e-3 * cos(k + i);
        f->multipliers[k][i] = (saltus_multiplier){exp(-i), i & 1 ? 0.1 : -0.1, i == 9 ? -INFINITY : -i};
    }
    f->multipliers[k][8].log_modulus = NAN;
    make_events(f, k);
}

static int open_fixture(void **state) {
    fixture *f = calloc(1, sizeof *f);
    strcpy(f->folder, "/tmp/saltus-test-XXXXXX");
    assert_non_null(mkdtemp(f->folder));
    f->reference = read_reference("fig7d");
    f->scene.spec = f->reference.spec;
    strcpy(f->scene.name, "fig7d");
    strcpy(f->scene.title, "it's ^2 {braces} 100%");
    f->system = build(&f->scene.spec);
    f->options = saltus_branch_defaults();
    strcpy(f->options.key[0], "omega");
    f->options.low[0] = 35;
    f->options.high[0] = 56;
    f->values[0] = 40;
    f->values[1] = 41.5;
    f->options.values = f->values;
    f->options.value_count = 2;
    for (int k = 0; k < point_count; k++)
        make_point(f, k);
    *state = f;
    return 0;
}

static int close_fixture(void **state) {
    fixture *f = *state;
    folder_files(f->folder, true);
    rmdir(f->folder);
    saltus_system_free(f->system);
    free(f);
    return 0;
}

static const char *path_in(const fixture *f, const char *name, char path[160]) {
    snprintf(path, 160, "%s/%s", f->folder, name);
    return path;
}

static saltus_branch_output *open_output(const fixture *f, const char *path) {
    saltus_message message = {.text = ""};
    saltus_branch_output *output;
    check_ok(
        saltus_branch_output_open(path, &f->scene, 4, f->states[0], &f->options, NULL, &output, &message),
        &message);
    return output;
}

static void write_branch(const fixture *f, const char *path, int count, bool complete) {
    saltus_message message = {.text = ""};
    saltus_branch_output *output = open_output(f, path);
    for (int k = 0; k < count; k++)
        check_ok(saltus_branch_output_add(output, &f->points[k], &message), &message);
    check_ok(saltus_branch_output_close(output, complete, &message), &message);
}

static void write_all(const char *path, const char *text, size_t length) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, length, file), length);
    fclose(file);
}

#define same(member) assert_memory_equal(&a->member, &b->member, sizeof a->member)

static void check_point(const saltus_branch_point *a, const saltus_branch_point *b) {
    same(kind);
    same(branch);
    same(parent);
    same(step);
    same(arclength);
    same(value);
    same(heading);
    same(periods);
    same(impacts);
    same(sticking_intervals);
    same(dimension);
    same(event_count);
    same(unstable);
    same(stable);
    same(admissible);
    same(residual);
    same(iterations);
    same(log_volume);
    same(sum_rule);
    same(accuracy);
    same(grazing_time);
    same(contact_force);
    same(grazing_stop);
    same(grazing_side);
    same(spec.parameters);
    assert_int_equal(a->spec.stop_count, b->spec.stop_count);
    assert_true(a->spec.stops[0].d == b->spec.stops[0].d && a->spec.stops[0].sides == b->spec.stops[0].sides);
    assert_string_equal(a->label, b->label);
    assert_string_equal(a->label_after, b->label_after);
    assert_string_equal(a->reason, b->reason);
    assert_memory_equal(a->state, b->state, dimension * sizeof *a->state);
    assert_memory_equal(a->multipliers, b->multipliers, dimension * sizeof *a->multipliers);
    for (int e = 0; e < a->event_count; e++) {
        const saltus_event *x = &a->events[e], *y = &b->events[e];
        assert_true(x->kind == y->kind && x->face == y->face && x->time.cycle == y->time.cycle &&
                    x->time.phase == y->time.phase && x->velocity_before == y->velocity_before &&
                    x->velocity_after == y->velocity_after && x->displacement == y->displacement);
    }
}

static void check_options(const saltus_branch_options *a, const saltus_branch_options *b) {
    same(key);
    same(low);
    same(high);
    same(step);
    same(step_max);
    same(points);
    same(direction);
    same(switches);
    same(locus);
    same(orbit.flow.rtol);
    same(orbit.flow.atol);
    same(orbit.flow.integrator);
    same(orbit.flow.order);
    same(orbit.phase);
    same(orbit.iterations);
    same(orbit.tolerance);
    same(orbit.segments);
}

static void points_read_back(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_branch_file file;
    char path[160];
    write_branch(f, path_in(f, "b.h5", path), point_count, true);
    check_ok(saltus_branch_file_read(path, &file, &message), &message);
    assert_string_equal(file.version, SALTUS_VERSION);
    assert_string_equal(file.scene, f->scene.name);
    assert_string_equal(file.title, f->scene.title);
    assert_true(file.complete && file.periods == 4 && file.dimension == dimension);
    assert_memory_equal(&file.spec.parameters, &f->scene.spec.parameters, sizeof file.spec.parameters);
    assert_memory_equal(file.state, f->states[0], sizeof f->states[0]);
    assert_memory_equal(file.options.values, f->values, sizeof f->values);
    assert_int_equal(file.options.value_count, 2);
    check_options(&file.options, &f->options);
    assert_int_equal(file.point_count, point_count);
    for (int k = 0; k < point_count; k++)
        check_point(&file.points[k], &f->points[k]);
    saltus_branch_file_clear(&file);
    assert_int_equal(folder_files(f->folder, true), 1);
}

/* Datasets have plain names and shapes, as another program reads them. */
static void layout_is_plain(void **state) {
    const fixture *f = *state;
    char path[160], names[200] = "";
    double values[point_count][2];
    write_branch(f, path_in(f, "b.h5", path), point_count, true);
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    hid_t set = H5Dopen2(file, "points/value", H5P_DEFAULT), space = H5Dget_space(set);
    hsize_t size[2], most[2];
    assert_int_equal(H5Sget_simple_extent_dims(space, size, most), 2);
    assert_true(size[0] == point_count && size[1] == 2 && most[0] == H5S_UNLIMITED);
    assert_true(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    assert_true(values[7][0] == f->points[7].value[0] && isnan(values[7][1]));
    H5Sclose(space);
    H5Dclose(set);
    hid_t attribute = H5Aopen_by_name(file, "points/parameters", "names", H5P_DEFAULT, H5P_DEFAULT);
    hid_t type = H5Aget_type(attribute);
    assert_true(H5Aread(attribute, type, names) >= 0);
    assert_string_equal(names, "N,alpha,beta,kappa,u0,sigma,omega");
    H5Tclose(type);
    H5Aclose(attribute);
    H5Fclose(file);
    folder_files(f->folder, true);
}

static void equal_branches_give_equal_files(void **state) {
    const fixture *f = *state;
    char a[160], b[160];
    size_t na, nb;
    write_branch(f, path_in(f, "a.h5", a), point_count, true);
    write_branch(f, path_in(f, "b.h5", b), point_count, true);
    char *first = read_all(a, &na), *second = read_all(b, &nb);
    assert_int_equal(na, nb);
    assert_memory_equal(first, second, na);
    free(first);
    free(second);
    folder_files(f->folder, true);
}

/* The file exists from the first point on, and remains readable after a kill. */
static void a_killed_run_leaves_a_readable_file(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_branch_file file;
    char path[160];
    int ready[2];
    assert_int_equal(pipe(ready), 0);
    path_in(f, "b.h5", path);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        saltus_branch_output *output = open_output(f, path);
        for (int k = 0; k < point_count; k++)
            saltus_branch_output_add(output, &f->points[k], &message);
        if (write(ready[1], "x", 1) == 1)
            pause();
        _exit(0);
    }
    char sign;
    assert_int_equal(read(ready[0], &sign, 1), 1);
    kill(child, SIGKILL);
    assert_int_equal(waitpid(child, NULL, 0), child);
    close(ready[0]);
    close(ready[1]);
    check_ok(saltus_branch_file_read(path, &file, &message), &message);
    assert_true(file.point_count >= 1 && !file.complete);
    for (int k = 0; k < file.point_count; k++)
        check_point(&file.points[k], &f->points[k]);
    saltus_branch_file_clear(&file);
    assert_int_equal(folder_files(f->folder, true), 1);
}

/* A failing start or an unwritable path does not damage an existing file. */
static void a_good_file_outlives_failures(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_branch_output *output;
    char path[160];
    size_t before, after;
    write_branch(f, path_in(f, "b.h5", path), point_count, true);
    char *old = read_all(path, &before);
    check_ok(saltus_branch_output_close(open_output(f, path), false, &message), &message);
    char *now = read_all(path, &after);
    assert_int_equal(before, after);
    assert_memory_equal(old, now, before);
    free(old);
    free(now);
    static const struct {
        const char *name, *word;
        saltus_status status;
    } bad[] = {{"b.txt", ".h5", SALTUS_BAD_INPUT},
               {"missing/b.h5", "No such file", SALTUS_IO},
               {"folder.h5", "folder", SALTUS_IO},
               {"full.h5", "plain file", SALTUS_BAD_INPUT}};
    char folder[160], link[160];
    assert_int_equal(mkdir(path_in(f, "folder.h5", folder), 0777), 0);
    assert_int_equal(symlink("/dev/full", path_in(f, "full.h5", link)), 0);
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        path_in(f, bad[k].name, path);
        assert_int_equal(
            saltus_branch_output_open(path, &f->scene, 4, f->states[0], &f->options, NULL, &output, &message),
            bad[k].status);
        assert_null(output);
        assert_non_null(strstr(message.text, bad[k].word));
        assert_non_null(strstr(message.text, bad[k].name));
    }
    rmdir(folder);
    assert_int_equal(folder_files(f->folder, true), 2);
    check_ok(saltus_branch_output_close(NULL, true, &message), &message);
}

static void refuse_file(const char *path, const char *word) {
    saltus_message message = {.text = ""};
    saltus_branch_file file;
    assert_int_equal(saltus_branch_file_read(path, &file, &message), SALTUS_BAD_INPUT);
    if (!strstr(message.text, word))
        fail_msg("\"%s\" does not say \"%s\"", message.text, word);
    assert_non_null(strstr(message.text, path));
    assert_null(file.points);
}

/* Any changed byte and any truncation is noticed. */
static void damage_is_noticed(void **state) {
    const fixture *f = *state;
    char path[160];
    size_t length;
    write_branch(f, path_in(f, "b.h5", path), point_count, true);
    char *whole = read_all(path, &length);
    for (size_t k = 0; k + 24 < length; k += 1 + length / 150) {
        whole[k] ^= (char)(1 << k % 8);
        write_all(path, whole, length);
        refuse_file(path, "damaged");
        whole[k] ^= (char)(1 << k % 8);
    }
    for (size_t kept = 0; kept + 24 < length; kept += length / 7) {
        write_all(path, whole, kept);
        refuse_file(path, kept < 8 ? "no HDF5" : "cut off");
    }
    free(whole);
    folder_files(f->folder, true);
}

static void foreign_files_are_named(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_flow_options options = saltus_flow_defaults();
    saltus_trajectory record;
    char path[160];
    refuse_file(path_in(f, "none.h5", path), "No such file");
    write_all(path, "omega: 42\n", 10);
    refuse_file(path, "no HDF5 file");
    hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    H5Fclose(file);
    refuse_file(path, "not one of Saltus");
    check_ok(
        saltus_trajectory_record(f->system, f->reference.states[0], &options, 0, 2, 20, &record, &message),
        &message);
    check_ok(saltus_write_trajectory(path, &f->scene, f->system, &options, &record, NULL, &message),
             &message);
    refuse_file(path, "trajectory");
    saltus_trajectory_clear(&record);
    folder_files(f->folder, true);
}

/* Change a branch file as another program might: sound HDF5, but wrong content. */
static void change_dataset(const char *path, const char *name, bool drop, int value) {
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
    if (drop) {
        assert_true(H5Ldelete(file, name, H5P_DEFAULT) >= 0);
    } else {
        hid_t set = H5Dopen2(file, name, H5P_DEFAULT), type = H5Dget_type(set);
        int values[events_most * point_count];
        for (int k = 0; k < events_most * point_count; k++)
            values[k] = value;
        assert_true(H5Dwrite(set, H5Tget_class(type) == H5T_ENUM ? type : H5T_NATIVE_INT, H5S_ALL, H5S_ALL,
                             H5P_DEFAULT, values) >= 0);
        H5Tclose(type);
        H5Dclose(set);
    }
    H5Fclose(file);
}

static void unsound_contents_are_named(void **state) {
    const fixture *f = *state;
    static const struct {
        const char *name, *word;
        bool drop;
        int value;
    } changes[] = {{"points/state", "points/state", true, 0},
                   {"points/kind", "points/kind", false, 99},
                   {"points/event_first", "row 1 of /points", false, 1000000},
                   {"points/event_count", "row 1 of /points", false, -1},
                   {"points/grazing_time", "points/grazing_time", true, 0},
                   {"points/grazing_stop", "row 1 of /points", false, 1},
                   {"points/grazing_stop", "row 1 of /points", false, 2},
                   {"points/grazing_side", "row 1 of /points", false, 1},
                   {"points/grazing_side", "row 1 of /points", false, -1},
                   {"points/periods", "row 1 of /points", false, 0},
                   {"events/stop", "an event", false, 7},
                   {"events/kind", "events/kind", false, 0},
                   {"parameters/stop_1", "an event", true, 0},
                   {"points/contact_force", "points/contact_force", true, 0},
                   {"continuation", "continuation", true, 0},
                   {"continuation/resume", "continuation/resume", true, 0},
                   {"start", "start/periods", true, 0},
                   {"events", "events/kind", true, 0},
                   {"parameters", "parameters", true, 0}};
    char path[160];
    path_in(f, "b.h5", path);
    for (size_t k = 0; k < sizeof changes / sizeof changes[0]; k++) {
        write_branch(f, path, point_count, true);
        change_dataset(path, changes[k].name, changes[k].drop, changes[k].value);
        refuse_file(path, changes[k].word);
    }
    folder_files(f->folder, true);
}

/* A touch is at a stop and side of the scene, within the orbit; or there is none. */
static void touches_are_checked(void **state) {
    fixture *f = *state;
    static const struct {
        double time;
        int stop, side;
        bool sound;
    } touches[] = {{NAN, 0, 0, true},    {0, 1, 1, true},        {3.999, 1, 1, true}, {4, 1, 1, false},
                   {-1e-9, 1, 1, false}, {NAN, 1, 1, false},     {0.5, 0, 0, false},  {0.5, 1, 0, false},
                   {0.5, 1, -1, false},  {0.5, 2, 1, false},     {0.5, -1, 1, false}, {NAN, 0, 1, false},
                   {0.5, 1, 2, false},   {INFINITY, 1, 1, false}};
    saltus_branch_point *p = &f->points[0];
    const saltus_branch_point kept = *p;
    char path[160];
    path_in(f, "b.h5", path);
    for (size_t k = 0; k < sizeof touches / sizeof touches[0]; k++) {
        saltus_branch_file file;
        saltus_message message = {.text = ""};
        p->grazing_time = touches[k].time;
        p->grazing_stop = touches[k].stop;
        p->grazing_side = touches[k].side;
        write_branch(f, path, 1, true);
        if (!touches[k].sound) {
            refuse_file(path, "row 1 of /points");
            continue;
        }
        check_ok(saltus_branch_file_read(path, &file, &message), &message);
        check_point(&file.points[0], p);
        saltus_branch_file_clear(&file);
    }
    *p = kept;
    folder_files(f->folder, true);
}

/* Replace one number of one point. */
static void change_number(const char *path, const char *name, int row, double value) {
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT), set = H5Dopen2(file, name, H5P_DEFAULT);
    hid_t space = H5Dget_space(set);
    int entries = (int)H5Sget_simple_extent_npoints(space);
    double *values = calloc((size_t)entries, sizeof *values);
    assert_true(values && entries >= point_count);
    assert_true(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    values[row * (entries / point_count)] = value;
    assert_true(H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    free(values);
    H5Sclose(space);
    H5Dclose(set);
    H5Fclose(file);
}

/* Numbers that a point is computed from must be finite; reported ones need not. */
static void endless_numbers_are_no_points(void **state) {
    static const struct {
        const char *name;
        bool needed;
    } columns[] = {{"points/state", true},
                   {"points/parameters", true},
                   {"points/value", true},
                   {"points/multipliers", false},
                   {"points/sum_rule", false}};
    static const double values[] = {NAN, INFINITY, -INFINITY};
    const fixture *f = *state;
    char path[160], word[40];
    size_t length;
    write_branch(f, path_in(f, "b.h5", path), point_count, true);
    char *bytes = read_all(path, &length);
    for (size_t k = 0; k < sizeof columns / sizeof columns[0]; k++)
        for (int v = 0; v < 3; v++) {
            saltus_branch_file file;
            saltus_message message = {.text = ""};
            int row = v == 1 ? point_count - 1 : 3 * v;
            write_all(path, bytes, length);
            change_number(path, columns[k].name, row, values[v]);
            snprintf(word, sizeof word, "row %d of /points", row + 1);
            if (columns[k].needed) {
                refuse_file(path, word);
                continue;
            }
            check_ok(saltus_branch_file_read(path, &file, &message), &message);
            saltus_branch_file_clear(&file);
        }
    free(bytes);
    folder_files(f->folder, true);
}

static saltus_status read_text(const char *path, const char *name, char again[600], saltus_message *message) {
    saltus_branch_file file;
    saltus_status status = saltus_branch_file_read(path, &file, message);
    if (status == SALTUS_OK)
        strcpy(again, name[0] == 'v' ? file.version : name[0] == 's' ? file.scene : file.title);
    saltus_branch_file_clear(&file);
    return status;
}

/* A text is read completely or not at all, however another program stored it. */
static void long_texts_are_not_cut(void **state) {
    static const struct {
        const char *group, *name, *word;
    } words[] = {{"/continuation", "key1", "continuation/key1"},
                 {"/continuation", "locus", "continuation/locus"},
                 {"/parameters/stop_1", "sides", "parameters/stop_1/d, r, sides"},
                 {"/", "kind", "not one of Saltus"},
                 {"/", "model", "its attribute model must be a text"}};
    static const struct {
        const char *name;
        size_t most;
    } columns[] = {{"points/motion", SALTUS_LABEL_MAX - 1},
                   {"points/motion_after", SALTUS_LABEL_MAX - 1},
                   {"points/reason", SALTUS_REASON_MAX - 1}};
    const fixture *f = *state;
    saltus_branch_file file;
    saltus_message message = {.text = ""};
    char path[160], text[600];
    size_t length;
    write_branch(f, path_in(f, "b.h5", path), point_count, true);
    char *bytes = read_all(path, &length);
    foreign_check(path, bytes, length, "version", sizeof file.version - 1, read_text);
    foreign_check(path, bytes, length, "scene", sizeof file.scene - 1, read_text);
    foreign_check(path, bytes, length, "title", sizeof file.title - 1, read_text);
    memset(text, 'x', sizeof text);
    text[100] = '\0';
    for (size_t k = 0; k < sizeof words / sizeof words[0]; k++) {
        write_all(path, bytes, length);
        foreign_text(path, words[k].group, words[k].name, text, FOREIGN_TIGHT);
        refuse_file(path, words[k].word);
    }
    for (size_t k = 0; k < sizeof columns / sizeof columns[0]; k++)
        for (int more = 0; more < 2; more++) {
            memset(text, 'x', sizeof text);
            text[columns[k].most + (size_t)more] = '\0';
            write_all(path, bytes, length);
            foreign_column(path, columns[k].name, text);
            if (more) {
                refuse_file(path, columns[k].name);
                continue;
            }
            check_ok(saltus_branch_file_read(path, &file, &message), &message);
            const saltus_branch_point *p = &file.points[point_count - 1];
            assert_string_equal(k == 0 ? p->label : k == 1 ? p->label_after : p->reason, text);
            saltus_branch_file_clear(&file);
        }
    free(bytes);
    folder_files(f->folder, true);
}

static void check_start(const char *source, const saltus_spec *spec, int periods, const double *x) {
    saltus_message message = {.text = ""};
    saltus_start start;
    check_ok(saltus_start_read(source, NULL, &start, &message), &message);
    assert_int_equal(start.periods, periods);
    assert_int_equal(start.dimension, dimension);
    assert_memory_equal(start.state, x, dimension * sizeof *x);
    assert_ptr_equal(start.spec.model, spec->model);
    assert_memory_equal(start.spec.parameters, spec->parameters, 7 * sizeof *spec->parameters);
    assert_int_equal(start.spec.stop_count, 1);
    assert_true(start.spec.stops[0].d == spec->stops[0].d && start.spec.stops[0].r == spec->stops[0].r &&
                start.spec.stops[0].xi == spec->stops[0].xi &&
                start.spec.stops[0].sides == spec->stops[0].sides);
}

static void refuse_start(const char *source, const char *word) {
    saltus_message message = {.text = ""};
    saltus_start start;
    assert_int_equal(saltus_start_read(source, NULL, &start, &message), SALTUS_BAD_INPUT);
    if (!strstr(message.text, word))
        fail_msg("\"%s\" does not say \"%s\"", message.text, word);
}

/* A start can be any row of a branch, or the first or a later point of a kind. */
static void starts_come_from_branches(void **state) {
    const fixture *f = *state;
    char path[160], source[200];
    static const struct {
        const char *part;
        int row;
    } parts[] = {{"1", 0}, {"60", 59}, {"LP1", 9}, {"PD", 19}, {"PD2", 49}, {"GR1", 29}, {"EP1", 59}};
    write_branch(f, path_in(f, "b.h5", path), point_count, true);
    for (size_t k = 0; k < sizeof parts / sizeof parts[0]; k++) {
        snprintf(source, sizeof source, "%s:%s", path, parts[k].part);
        check_start(source, &f->points[parts[k].row].spec, 4, f->states[parts[k].row]);
    }
    refuse_start(path, "name one of them");
    static const char *const wrong[] = {"0", "61", "PD3", "NS1", "XX1", "-1", "PD0", "1x", ""};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        snprintf(source, sizeof source, "%s:%s", path, wrong[k]);
        refuse_start(source, wrong[k][0] ? wrong[k] : "name one of them");
    }
    folder_files(f->folder, true);
}

static saltus_motion find_motion(const fixture *f, int p) {
    saltus_message message = {.text = ""};
    saltus_orbit_options shooting = saltus_orbit_defaults();
    saltus_classify_options how = saltus_classify_defaults();
    saltus_orbit orbit;
    saltus_motion motion;
    check_ok(saltus_orbit_find(f->system, p, f->reference.states[0], &shooting, &orbit, &message), &message);
    check_ok(saltus_motion_describe(f->system, &orbit, &how, &motion, &message), &message);
    saltus_orbit_clear(&orbit);
    return motion;
}

static char *motion_json(const fixture *f, const saltus_motion *motion, const char *path) {
    size_t length;
    FILE *file = fopen(path, "wb");
    saltus_write_motion_json(file, &f->scene, f->system, motion);
    fclose(file);
    return read_all(path, &length);
}

static void starts_come_from_json(void **state) {
    const fixture *f = *state;
    char path[160], source[200];
    saltus_motion motion = find_motion(f, 4);
    free(motion_json(f, &motion, path_in(f, "o.json", path)));
    check_start(path, &f->scene.spec, 4, motion.state);
    FILE *file = fopen(path, "wb");
    for (int k = 0; k < point_count; k++)
        saltus_write_point_json(file, &f->scene, f->system, &f->points[k]);
    fclose(file);
    snprintf(source, sizeof source, "%s:20", path);
    check_start(source, &f->points[19].spec, 4, f->states[19]);
    refuse_start(path, "several orbits");
    snprintf(source, sizeof source, "%s:61", path);
    refuse_start(source, "no such line");
    snprintf(source, sizeof source, "%s:PD1", path);
    refuse_start(source, "number");
    saltus_motion_clear(&motion);
    folder_files(f->folder, true);
}

/* Each single change in a sound file has its own message. */
static void unsound_json_is_named(void **state) {
    const fixture *f = *state;
    static const char *const changes[][3] = {
        {"\"version\"", "\"edition\"", "version"},
        {"\"periods\": 4", "\"periods\": 0", "no periodic orbit"},
        {"\"periods\": 4", "\"periods\": 4.5", "periods"},
        {"\"periods\": 4", "\"periods\": \"4\"", "periods"},
        {"\"state\": [", "\"state\": [1, ", "state: has 11 entries"},
        {"\"state\": [", "\"state\": [null], \"x\": [", "state: has 1 entries"},
        {"\"state\": [", "\"state\": 3, \"x\": [", "state: must be a list"},
        {"\"state\": [-", "\"state\": [NaN", "state: entry 1 must be a finite number"},
        {"\"state\": [-", "\"state\": [1e999, -", "state: has 11"},
        {"\"model\": \"pipe\"", "\"model\": \"tube\"", "parameters"},
        {"\"omega\": 42", "\"omega\": -1", "omega = -1"},
        {"\"omega\": 42", "\"omega\": null", "omega"},
        {"\"omega\": 42", "\"frequency\": 42", "omega is missing"},
        {"\"N\": 5", "\"N\": 4", "state: has 10 entries, its parameters make it 8"},
        {"\"stops\"", "\"walls\"", "stops is missing"},
        {"\"parameters\"", "\"numbers\"", "parameters"},
        {"{\"version\"", "[\"version\"", "no orbit"},
        {"\"events\": [", "\"events\": [[",
         ":1: not valid JSON here or below: found }, but the [ of line 1 is not closed"},
    };
    char path[160];
    saltus_motion motion = find_motion(f, 4);
    char *text = motion_json(f, &motion, path_in(f, "o.json", path));
    size_t length = strlen(text);
    for (size_t k = 0; k < sizeof changes / sizeof changes[0]; k++) {
        const char *at = strstr(text, changes[k][0]);
        assert_non_null(at);
        FILE *file = fopen(path, "wb");
        fprintf(file, "%.*s%s%s", (int)(at - text), text, changes[k][1], at + strlen(changes[k][0]));
        fclose(file);
        refuse_start(path, changes[k][2]);
        refuse_start(path, path);
    }
    for (size_t kept = 1; kept < length - 2; kept += length / 97) {
        write_all(path, text, kept);
        refuse_start(path, "cut off");
    }
    write_all(path, "", 0);
    refuse_start(path, "empty");
    write_all(path, "model: pipe\n", 12);
    refuse_start(path, "no orbit");
    refuse_start(f->folder, "folder");
    refuse_start("/nonexistent/o.json", "No such file");
    free(text);
    saltus_motion_clear(&motion);
    folder_files(f->folder, true);
}

static void starts_fit_their_scene(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_start start = {.spec = f->points[5].spec, .periods = 4, .dimension = dimension};
    saltus_scene scene = f->scene, wrong;
    check_ok(saltus_start_apply(&start, "o.json", &scene, &message), &message);
    assert_true(saltus_spec_get(&scene.spec, "omega") == f->points[5].value[0]);
    assert_true(scene.spec.stops[0].d == f->points[5].spec.stops[0].d);
    static const char *const scenes[][2] = {{"impact-oscillator", "model"}, {"fig2", "stop"}};
    for (size_t k = 0; k < sizeof scenes / sizeof scenes[0]; k++) {
        check_ok(saltus_scene_load(scenes[k][0], &wrong, &message), &message);
        saltus_scene before = wrong;
        assert_int_equal(saltus_start_apply(&start, "o.json", &wrong, &message), SALTUS_BAD_INPUT);
        assert_non_null(strstr(message.text, scenes[k][1]));
        assert_memory_equal(&before, &wrong, sizeof wrong);
    }
}

/* An orbit found by shooting is described as classification describes it, with its least period. */
static void orbits_are_described_as_classified(void **state) {
    const fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_classify_options how = saltus_classify_defaults();
    saltus_motion classified, four = find_motion(f, 4), eight = find_motion(f, 8);
    check_ok(saltus_classify(f->system, f->reference.states[0], &how, &classified, &message), &message);
    const saltus_motion *found[] = {&four, &eight};
    for (int k = 0; k < 2; k++) {
        assert_string_equal(found[k]->label, "4/4");
        assert_int_equal(found[k]->periods, 4);
        assert_int_equal(found[k]->event_count, classified.event_count);
        assert_true(found[k]->stable && found[k]->mirror == classified.mirror);
        check_near(found[k]->largest, classified.largest, 1e-12);
        check_near(found[k]->smallest, classified.smallest, 1e-12);
        for (int i = 0; i < 4; i++)
            check_near(found[k]->multipliers[i].re, classified.multipliers[i].re, 1e-9);
    }
    saltus_motion_clear(&classified);
    saltus_motion_clear(&four);
    saltus_motion_clear(&eight);
}

/* The mirror image of a motion of the two-sided scene is a motion; twice mirrored is the same again. */
static void mirror_images_are_motions(void **state) {
    (void)state;
    saltus_message message = {.text = ""};
    saltus_flow_options options = saltus_flow_defaults();
    saltus_spec spec = oscillator_spec(0.1, 1, 0.7, 0.8);
    double x[2] = {0.1, 0.2}, image[2];
    add_stop(&spec, 0.4, 0.8, SALTUS_BOTH);
    saltus_system *system = build(&spec);
    check_ok(saltus_motion_settle(system, &options, 3, x, &message), &message);
    memcpy(image, x, sizeof x);
    check_ok(saltus_motion_mirror(system, &options, image, &message), &message);
    check_ok(saltus_motion_settle(system, &options, 1, x, &message), &message);
    check_ok(saltus_motion_mirror(system, &options, image, &message), &message);
    for (int i = 0; i < 2; i++)
        check_near(image[i], x[i], 1e-10);
    saltus_system_free(system);
    spec.stops[0].sides = SALTUS_UPPER;
    system = build(&spec);
    assert_int_equal(saltus_motion_mirror(system, &options, image, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "mirror"));
    saltus_system_free(system);
}

static void refuse_plot(const fixture *f, const char *const *paths, int count, const saltus_plot_options *how,
                        const char *name, const char *word) {
    saltus_message message = {.text = ""};
    char figure[160];
    assert_int_equal(saltus_plot(path_in(f, name, figure), paths, count, how, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, word));
    assert_int_not_equal(access(figure, F_OK), 0);
}

static bool have_gnuplot(void) {
    return system("gnuplot --version >/dev/null 2>&1") == 0;
}

static void diagrams_are_drawn(void **state) {
    fixture *f = *state;
    static const char *const names[] = {"d.png", "d.pdf", "d.svg"}, *const heads[] = {"\x89PNG", "%PDF",
                                                                                      "<?xml"};
    saltus_message message = {.text = ""};
    char path[160], figure[160], second[160];
    const char *paths[2] = {path, path};
    saltus_plot_options how = saltus_plot_defaults();
    saltus_plot_part part = {"omega", 10, 20};
    size_t length;
    if (!have_gnuplot())
        skip();
    write_branch(f, path_in(f, "b.h5", path), point_count, true);
    for (int k = 0; k < 3; k++) {
        how.show = k ? SALTUS_SHOW_IMPACTS : SALTUS_SHOW_AUTOMATIC;
        check_ok(saltus_plot(path_in(f, names[k], figure), paths, 1 + k % 2, &how, &message), &message);
        char *picture = read_all(figure, &length);
        assert_true(length > 5000);
        assert_memory_equal(picture, heads[k], 4);
        free(picture);
        remove(figure);
    }
    refuse_plot(f, paths, 1, &how, "d.bmp", "ending");
    how.parts = &part;
    how.part_count = 1;
    refuse_plot(f, paths, 1, &how, "d.png", "no point");
    strcpy(part.key, "d");
    refuse_plot(f, paths, 1, &how, "d.png", "shows omega");
    how.part_count = 0;
    strcpy(f->options.key[0], "u0");
    write_branch(f, path_in(f, "c.h5", second), 3, true);
    strcpy(f->options.key[0], "omega");
    paths[1] = second;
    refuse_plot(f, paths, 2, &how, "d.png", "axes");
    refuse_plot(f, paths, 0, &how, "d.png", "no file");
    /* A scene of another shape. */
    const saltus_spec usual = f->scene.spec;
    f->scene.spec.stops[f->scene.spec.stop_count++] = (saltus_stop){0.25, {1, 0}, 0.05, 0.5, SALTUS_LOWER};
    for (int k = 0; k < point_count; k++)
        make_point(f, k);
    write_branch(f, second, 3, true);
    f->scene.spec = usual;
    for (int k = 0; k < point_count; k++)
        make_point(f, k);
    refuse_plot(f, paths, 2, &how, "d.png", "is of another structure than the first file");
    folder_files(f->folder, true);
}

/* A made-up curve of folds in two parameters; `turned`: the same curve with the parameters in the other
 * order. */
static void write_locus(fixture *f, const char *path, bool turned) {
    const saltus_branch_options usual = f->options;
    strcpy(f->options.key[turned], "omega");
    strcpy(f->options.key[!turned], "d");
    f->options.low[turned] = 35;
    f->options.high[turned] = 56;
    f->options.low[!turned] = 0.02;
    f->options.high[!turned] = 0.05;
    f->options.locus = SALTUS_POINT_LP;
    f->options.value_count = 0;
    for (int k = 0; k < point_count; k++) {
        saltus_branch_point *p = &f->points[k];
        p->kind = p->locus = SALTUS_POINT_LP;
        p->value[turned] = 42 + 0.1 * k;
        p->value[!turned] = 0.03 + 1e-5 * k * (50 - k);
        f->multipliers[k][0] = (saltus_multiplier){1, 0, 0};
    }
    write_branch(f, path, point_count, true);
    f->options = usual;
    for (int k = 0; k < point_count; k++)
        make_point(f, k);
}

static char *draw_text(const fixture *f, const char *const *paths, int count,
                       const saltus_plot_options *how) {
    saltus_message message = {.text = ""};
    char figure[160];
    size_t length;
    check_ok(saltus_plot(path_in(f, "d.svg", figure), paths, count, how, &message), &message);
    char *picture = read_all(figure, &length);
    remove(figure);
    return picture;
}

static void curves_share_a_plane(void **state) {
    fixture *f = *state;
    char straight[160], turned[160], branch[160];
    const char *same[2] = {straight, straight}, *mixed[2] = {straight, turned},
               *wrong[2] = {straight, branch};
    saltus_plot_label label = {{"omega", "d"}, {45, 0.032}, "own_name"};
    saltus_plot_options how = saltus_plot_defaults();
    if (!have_gnuplot())
        skip();
    write_locus(f, path_in(f, "s.h5", straight), false);
    write_locus(f, path_in(f, "t.h5", turned), true);
    write_branch(f, path_in(f, "b.h5", branch), point_count, true);
    how.labels = &label;
    how.label_count = 1;
    char *first = draw_text(f, same, 2, &how), *second = draw_text(f, mixed, 2, &how);
    assert_string_equal(first, second);
    assert_non_null(strstr(first, "own_name"));
    assert_non_null(strstr(first, "LP 4/4"));
    free(second);
    label = (saltus_plot_label){{"d", "omega"}, {0.032, 45}, "own_name"};
    second = draw_text(f, mixed, 2, &how);
    assert_string_equal(first, second);
    free(first);
    free(second);
    refuse_plot(f, wrong, 2, &how, "d.png", "axes");
    refuse_plot(f, &wrong[1], 1, &how, "d.png", "own_name");
    label = (saltus_plot_label){{"d", "d"}, {0.032, 0.032}, "own_name"};
    refuse_plot(f, same, 2, &how, "d.png", "own_name");
    folder_files(f->folder, true);
}

/* Every special point has a line, others have none, and the next point tells what lies beyond. */
static void special_points_are_listed(void **state) {
    fixture *f = *state;
    saltus_message message = {.text = ""};
    saltus_branch_file file;
    char path[160], *text = NULL, row[32];
    size_t length;
    write_branch(f, path_in(f, "b.h5", path), point_count, true);
    check_ok(saltus_branch_file_read(path, &file, &message), &message);
    FILE *out = open_memstream(&text, &length);
    saltus_write_branch_text(out, &file);
    fclose(out);
    for (int k = 0; k < point_count; k++) {
        const saltus_branch_point *p = &f->points[k];
        snprintf(row, sizeof row, "\n%7d  %-5s", k + 1, saltus_point_word(p->kind));
        const char *line = strstr(text, row);
        assert_int_equal(line != NULL, p->kind != SALTUS_POINT_REGULAR);
        if (!line || k + 1 == point_count || p[1].branch != p->branch)
            continue;
        const char *word = strstr(line, p[1].stable ? "  stable" : "  unstable");
        assert_true(word && word < line + strcspn(line + 1, "\n") + 1);
    }
    assert_non_null(strstr(text, "branch 2, off branch 0, from omega = 47"));
    assert_null(strstr(text, " \n"));
    free(text);
    saltus_branch_file_clear(&file);
    folder_files(f->folder, true);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_read_back),
        cmocka_unit_test(layout_is_plain),
        cmocka_unit_test(equal_branches_give_equal_files),
        cmocka_unit_test(a_killed_run_leaves_a_readable_file),
        cmocka_unit_test(a_good_file_outlives_failures),
        cmocka_unit_test(damage_is_noticed),
        cmocka_unit_test(foreign_files_are_named),
        cmocka_unit_test(unsound_contents_are_named),
        cmocka_unit_test(touches_are_checked),
        cmocka_unit_test(endless_numbers_are_no_points),
        cmocka_unit_test(long_texts_are_not_cut),
        cmocka_unit_test(starts_come_from_branches),
        cmocka_unit_test(starts_come_from_json),
        cmocka_unit_test(unsound_json_is_named),
        cmocka_unit_test(starts_fit_their_scene),
        cmocka_unit_test(orbits_are_described_as_classified),
        cmocka_unit_test(mirror_images_are_motions),
        cmocka_unit_test(diagrams_are_drawn),
        cmocka_unit_test(curves_share_a_plane),
        cmocka_unit_test(special_points_are_listed),
    };
    return cmocka_run_group_tests(tests, open_fixture, close_fixture);
}
