/* The limits of a sweep file that another program has changed: each number is tried at its last valid value
 * and one beyond. Also journals that end early or are damaged: results before that place are kept.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "folder.h"
#include "made_sweep.h"

#include <hdf5.h>
#include <unistd.h>

enum { seeds = 2, points = 3, turnings = 2, passes = 2 };

static int first_verdict = SALTUS_PERIODIC;

static void fill(made_place *m) {
    for (int s = 0; s < m->seeds; s++) {
        m->row[s] = m->place == 0 && s == 0 && first_verdict != SALTUS_PERIODIC ? made_other(first_verdict)
                                                                                : made_periodic(2, 1);
        m->row[s].settled = 10 * m->place + s;
        m->turning_count[s] = turnings;
        m->impact_count[s] = 1;
        m->impact[s].face = 0;
    }
}

static void make_options(saltus_scene *scene, saltus_axis *axis, saltus_sweep_options *options) {
    *scene = (saltus_scene){.name = "made"};
    scene->spec = oscillator_spec(0.125, 1, 1, 1);
    add_stop(&scene->spec, 1, 0.75, SALTUS_BOTH);
    *axis = (saltus_axis){.key = "omega", .spacing = SALTUS_LINEAR, .count = points, .low = 1, .high = 2};
    *options = saltus_sweep_defaults();
    options->keep = SALTUS_KEEP_TURNING | SALTUS_KEEP_IMPACTS;
    options->passes = 1u << SALTUS_PASS_RESET | 1u << SALTUS_PASS_UP;
    options->seeds = seeds;
}

static void make(const char *path, long long done) {
    saltus_scene scene;
    saltus_axis axis;
    saltus_sweep_options options;
    make_options(&scene, &axis, &options);
    made_write(path, &scene, &axis, 1, &options, fill, done);
}

static void save(const char *path, const unsigned char *bytes, size_t length) {
    FILE *file = fopen(path, "wb");
    assert_int_equal(fwrite(bytes, 1, length, file), length);
    fclose(file);
}

/* Write over the first entry of a dataset. */
static void spoil(const char *path, const char *name, long long value) {
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT), set = H5Dopen2(file, name, H5P_DEFAULT);
    hid_t space = H5Dget_space(set), one = H5Screate(H5S_SCALAR);
    hsize_t at[4] = {0};
    assert_true(H5Sselect_elements(space, H5S_SELECT_SET, 1, at) >= 0);
    assert_true(H5Dwrite(set, H5T_NATIVE_LLONG, one, space, H5P_DEFAULT, &value) >= 0);
    H5Sclose(one);
    H5Sclose(space);
    H5Dclose(set);
    H5Fclose(file);
}

static void numbers_of_rows_have_their_bounds(void **state) {
    static const struct {
        const char *name;
        int verdict;
        long long last, beyond;
    } bound[] = {
        {"rows/impacts", SALTUS_PERIODIC, -1, -2},
        {"rows/impacts", SALTUS_HELD, 0, -1},
        {"rows/periods", SALTUS_PERIODIC, 1, 0},
        {"rows/periods", SALTUS_HELD, 0, -1},
        {"rows/attractor", SALTUS_PERIODIC, -1, -2},
        {"rows/attractor", SALTUS_PERIODIC, seeds - 1, seeds},
        {"rows/sticking", SALTUS_PERIODIC, 0, -1},
        {"rows/settled", SALTUS_PERIODIC, 0, -1},
        {"rows/settled_impacts", SALTUS_HELD, 0, -1},
        {"rows/recorded", SALTUS_HELD, 0, -1},
        {"turning/first", SALTUS_PERIODIC, 0, -1},
        {"turning/count", SALTUS_PERIODIC, 0, -1},
        {"turning/first", SALTUS_PERIODIC, passes * points * seeds * turnings - turnings,
         passes * points * seeds * turnings - turnings + 1},
        {"turning/count", SALTUS_PERIODIC, passes * points * seeds * turnings,
         passes * points * seeds * turnings + 1},
        {"impacts/count", SALTUS_PERIODIC, passes * points * seeds, passes * points * seeds + 1},
        {"impacts/face", SALTUS_PERIODIC, 0, -1},
        {"impacts/face", SALTUS_PERIODIC, SALTUS_FACES_MAX - 1, SALTUS_FACES_MAX},
    };
    (void)state;
    char folder[] = "/tmp/saltus-test-XXXXXX", path[64], name[128];
    unsigned char *whole[2];
    size_t length[2];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/a.h5", folder);
    for (int held = 0; held < 2; held++) {
        first_verdict = held ? SALTUS_HELD : SALTUS_PERIODIC;
        make(path, 1000);
        whole[held] = read_all(path, &length[held]);
    }
    for (size_t k = 0; k < sizeof bound / sizeof bound[0]; k++)
        for (int beyond = 0; beyond < 2; beyond++) {
            saltus_message message = {.text = ""};
            saltus_sweep_file file;
            save(path, whole[bound[k].verdict == SALTUS_HELD], length[bound[k].verdict == SALTUS_HELD]);
            spoil(path, bound[k].name, beyond ? bound[k].beyond : bound[k].last);
            saltus_status status = saltus_sweep_file_read(path, &file, &message);
            if (status != (beyond ? SALTUS_BAD_INPUT : SALTUS_OK))
                fail_msg("%s = %lld: %s", bound[k].name, beyond ? bound[k].beyond : bound[k].last,
                         status ? message.text : "taken");
            if (beyond) {
                snprintf(name, sizeof name, "%s: is not a sound sweep file: ", path);
                assert_int_equal(strncmp(message.text, name, strlen(name)), 0);
            } else
                saltus_sweep_file_clear(&file);
        }
    free(whole[0]);
    free(whole[1]);
    folder_files(folder, true);
    rmdir(folder);
}

/* The places present, as bits. */
static unsigned places_there(const char *path, saltus_status *status, saltus_message *message) {
    saltus_scene scene;
    saltus_axis axis;
    saltus_sweep_options options;
    saltus_sweep *sweep = NULL;
    saltus_sweep_output *output = NULL;
    unsigned there = 0;
    make_options(&scene, &axis, &options);
    check_ok(saltus_sweep_new(&scene, &axis, 1, &options, &sweep, message), message);
    *status = saltus_sweep_output_open(path, sweep, false, true, NULL, &output, message);
    for (int k = 0; k < passes * points && *status == SALTUS_OK; k++)
        there |= (unsigned)saltus_sweep_output_has(output, k) << k;
    if (output)
        check_ok(saltus_sweep_output_close(output, message), message);
    saltus_sweep_free(sweep);
    return there;
}

static void results_before_the_damage_are_kept(void **state) {
    enum { done = 4 };
    (void)state;
    char folder[] = "/tmp/saltus-test-XXXXXX", path[64], journal[80];
    size_t length[done + 1];
    unsigned char *bytes = NULL;
    saltus_message message;
    saltus_status status;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/a.h5", folder);
    snprintf(journal, sizeof journal, "%s.journal", path);
    first_verdict = SALTUS_PERIODIC;
    for (int k = 0; k <= done; k++) {
        free(bytes);
        make(path, k);
        bytes = read_all(journal, &length[k]);
        assert_int_equal(length[k] % 8, 0);
    }
    for (int k = 0; k < done; k++)
        for (size_t at = length[k]; at < length[k + 1]; at += at < length[k] + 16 ? 5 : 97) {
            const unsigned before = (1u << k) - 1;
            bytes[at] ^= 0x10;
            save(journal, bytes, length[done]);
            unsigned there = places_there(path, &status, &message);
            bytes[at] ^= 0x10;
            assert_int_equal(status, SALTUS_OK);
            assert_int_equal(there, before);
            /* Damaged records are cut off, as is an incomplete end. */
            FILE *file = fopen(journal, "rb");
            fseek(file, 0, SEEK_END);
            assert_int_equal(ftell(file), length[k]);
            fclose(file);
            save(journal, bytes, at);
            assert_int_equal(places_there(path, &status, &message), before);
            assert_int_equal(status, SALTUS_OK);
        }
    /* In the head: an incomplete one belongs to no sweep with results, a damaged one is refused. */
    for (size_t at = 0; at < length[0]; at += at < 40 ? 6 : 211) {
        bytes[at] ^= 0x10;
        save(journal, bytes, length[done]);
        places_there(path, &status, &message);
        bytes[at] ^= 0x10;
        const char *words = at < 8    ? "is not a journal of a sweep"
                            : at < 16 ? "was written by another version"
                                      : "is damaged at its begin";
        bool padding = status == SALTUS_OK;
        if (!padding &&
            (status != SALTUS_BAD_INPUT || !strstr(message.text, words) || !strstr(message.text, journal)))
            fail_msg("byte %zu: %s", at, message.text);
        assert_true(!padding || at >= length[0] - 8);
    }
    /* The same result twice counts once, so the sweep is not complete; in any order all are found. */
    size_t one = length[1] - length[0], two = length[2] - length[0];
    unsigned char *twice = malloc(length[done] + two);
    memcpy(twice, bytes, length[done]);
    memcpy(twice + length[done], bytes + length[0], two);
    save(journal, twice, length[done] + two);
    assert_int_equal(places_there(path, &status, &message), (1u << done) - 1);
    saltus_sweep_file file;
    check_ok(saltus_sweep_file_read(path, &file, &message), &message);
    assert_false(file.complete);
    saltus_sweep_file_clear(&file);
    assert_int_equal(access(journal, F_OK), 0);
    memcpy(twice + length[0], bytes + length[1], length[done] - length[1]);
    save(journal, twice, length[done] - one);
    assert_int_equal(places_there(path, &status, &message), (1u << done) - 2);
    free(twice);
    free(bytes);
    folder_files(folder, true);
    rmdir(folder);
}

/* The attractor of a plane of initial states is stored with its orbit's points: for a linear oscillator the
 * steady response. */
static void attractors_are_kept_with_their_points(void **state) {
    (void)state;
    char folder[] = "/tmp/saltus-test-XXXXXX", path[64];
    const double c = 0.5, k = 2, force = 1.5, omega = 1.25, gap = k - omega * omega;
    const double scale = force / (gap * gap + c * c * omega * omega);
    const double orbit[2] = {scale * gap, scale * c * omega * omega};
    saltus_scene scene = {.name = "made", .spec = oscillator_spec(c, k, force, omega)};
    saltus_axis axes[2] = {{.key = "q1", .count = 2, .low = -0.5, .high = 0.5},
                           {.key = "v1", .count = 2, .low = -1, .high = 1}};
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_sweep *sweep = NULL;
    saltus_sweep_output *output = NULL;
    saltus_sweep_file file;
    saltus_message message;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/b.h5", folder);
    check_ok(saltus_sweep_new(&scene, axes, 2, &options, &sweep, &message), &message);
    check_ok(saltus_sweep_output_open(path, sweep, true, false, NULL, &output, &message), &message);
    for (int place = 0; place < 4; place++) {
        saltus_sweep_row row = {.verdict = SALTUS_PERIODIC, .periods = 1, .lyapunov = NAN};
        const long long none = 0;
        const saltus_sweep_result result = {.place = place,
                                            .rows = &row,
                                            .states = (double[]){orbit[0], orbit[1]},
                                            .turning_counts = &none,
                                            .impact_counts = &none,
                                            .strobe_counts = &none};
        check_ok(saltus_sweep_output_take(output, &result, &message), &message);
    }
    check_ok(saltus_sweep_output_close(output, &message), &message);
    check_ok(saltus_sweep_file_read(path, &file, &message), &message);
    assert_true(file.basins && file.complete);
    assert_int_equal(file.attractor_count, 1);
    assert_string_equal(file.attractor_label[0], "0/1");
    assert_true(file.attractor_first[0] == 0 && file.attractor_points[0] == 1);
    check_near(file.attractor_states[0], orbit[0], 1e-9);
    check_near(file.attractor_states[1], orbit[1], 1e-9);
    check_near(file.attractor_multiplier[0], exp(-0.5 * c * 2 * acos(-1) / omega), 1e-8);
    for (int row = 0; row < 4; row++)
        assert_int_equal(file.rows[row].attractor, 0);
    saltus_sweep_file_clear(&file);
    saltus_sweep_free(sweep);
    folder_files(folder, true);
    rmdir(folder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_of_rows_have_their_bounds),
        cmocka_unit_test(results_before_the_damage_are_kept),
        cmocka_unit_test(attractors_are_kept_with_their_points),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
