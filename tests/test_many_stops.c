/* Ten stops, three masses: the largest number of contacts needs no special case.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/bits.h"
#include "check.h"

static saltus_scene three_masses(const char *stops, bool forced) {
    static const char head[] = "model:\n  parameters: {c: 0.1%s}\n  motion:\n"
                               "    x: -c*x' - x - (x - y) + %s\n    y: -c*y' - (y - x) - (y - z)%s\n"
                               "    z: -c*z' - (z - y) - z%s\n%sstops:\n%s";
    char text[2000];
    saltus_scene scene;
    saltus_message message = {.text = ""};
    if (forced)
        snprintf(text, sizeof text, head, ", F: 1, omega: 0.5", "F*cos(omega*t)", "", "",
                 "  forcing: omega\n", stops);
    else
        snprintf(text, sizeof text, head, ", load: 0", "load", " + load", " + load", "", stops);
    check_ok(saltus_scene_parse(text, strlen(text), "masses", &scene, &message), &message);
    return scene;
}

static const char met[] = "- {coordinate: x + y, d: 1.2, r: 0.7, sides: both}\n";
static const char others[] = "- {coordinate: x, d: 0.8, r: 0.8, sides: both}\n"
                             "- {coordinate: y, d: 0.7, r: 0.8, sides: both}\n"
                             "- {coordinate: z, d: 0.6, r: 0.7, sides: both}\n"
                             "- {coordinate: x - y, d: 0.5, r: 0.7, sides: both}\n"
                             "- {coordinate: y - z, d: 0.5, r: 0.7, sides: both}\n"
                             "- {coordinate: y + z, d: 1.2, r: 0.7, sides: both}\n"
                             "- {coordinate: x - z, d: 0.9, r: 0.7, sides: both}\n"
                             "- {coordinate: x + z, d: 1.1, r: 0.7, sides: both}\n"
                             "- {coordinate: x + y + z, d: 1.4, r: 0.6, sides: both}\n";

static saltus_motion classified(const saltus_scene *scene, saltus_system **system) {
    saltus_message message = {.text = ""};
    saltus_classify_options options = saltus_classify_defaults();
    saltus_motion motion;
    double state[SALTUS_STATE_MAX];
    *system = build(&scene->spec);
    check_ok(saltus_scene_state(scene, *system, state, &message), &message);
    check_ok(saltus_classify(*system, state, &options, &motion, &message), &message);
    return motion;
}

/* A motion that meets only one of ten stops is the motion with that stop alone. */
static void stops_that_are_not_met_change_nothing(void **unused) {
    (void)unused;
    char all[1500];
    saltus_system *ten, *one;
    snprintf(all, sizeof all, "%s%s", others, met);
    saltus_scene many = three_masses(all, true), single = three_masses(met, true);
    saltus_motion a = classified(&many, &ten), b = classified(&single, &one);
    assert_int_equal(saltus_system_face_count(ten), 20);
    assert_int_equal(a.verdict, SALTUS_PERIODIC);
    assert_string_equal(a.label, b.label);
    assert_true(a.impacts > 0 && a.event_count == b.event_count);
    for (int f = 0; f < 20; f++)
        assert_int_equal(a.impacts_by_face[f], f < 18 ? 0 : b.impacts_by_face[f - 18]);
    for (int k = 0; k < a.multiplier_count; k++) {
        check_near(a.multipliers[k].re, b.multipliers[k].re, 1e-9);
        check_near(a.multipliers[k].im, b.multipliers[k].im, 1e-9);
    }
    saltus_motion_clear(&a);
    saltus_motion_clear(&b);
    saltus_system_free(ten);
    saltus_system_free(one);
    saltus_scene_clear(&many);
    saltus_scene_clear(&single);
}

/* A load presses masses against stops: no stop is passed, held contacts push, and forces balance at rest. */
static void a_load_comes_to_rest_among_ten_stops(void **unused) {
    (void)unused;
    static const char *const loads[] = {"load=0.1", "load=2", "load=-3", "load=7"};
    char all[1500];
    snprintf(all, sizeof all, "%s%s", others, met);
    for (int k = 0; k < 4; k++) {
        saltus_scene scene = three_masses(all, false);
        saltus_message message = {.text = ""};
        saltus_equilibrium rest = {0};
        double guess[6] = {0};
        check_ok(saltus_scene_set(&scene, loads[k], &message), &message);
        saltus_system *system = build(&scene.spec);
        saltus_equilibrium_options options = saltus_equilibrium_defaults();
        check_ok(saltus_equilibrium_find(system, guess, &options, &rest, &message), &message);
        const double *q = rest.state, load = saltus_spec_get(&scene.spec, "load");
        double left[3] = {load - 2 * q[0] + q[1], load - 2 * q[1] + q[0] + q[2], load - 2 * q[2] + q[1]};
        int held = 0;
        for (int f = 0; f < saltus_system_face_count(system); f++) {
            const saltus_face face = saltus_system_face(system, f);
            const double force = rest.contact_force[f];
            held += force != 0;
            assert_true(saltus_system_gap(system, f, q) <= 1e-12);
            assert_true(force >= 0);
            for (int i = 0; i < 3; i++)
                left[i] -= force * face.side * saltus_system_stop_normal(system, face.stop)[i];
        }
        assert_true(k ? held > 0 : held == 0);
        for (int i = 0; i < 3; i++)
            check_near(left[i], 0, 1e-10);
        saltus_equilibrium_clear(&rest);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

static void limits_are_told(void **unused) {
    (void)unused;
    char text[4000] = "model: pipe\nstops:\n";
    saltus_scene scene;
    saltus_message message = {.text = ""};
    for (int k = 0; k <= SALTUS_STOPS_MAX; k++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "- {xi: %g, d: 0.03}\n", 0.05 + 0.07 * k);
    assert_int_equal(saltus_scene_parse(text, strlen(text), "file", &scene, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "at most 12 are possible"));
    static const char three[] = "model: oscillator\nN: 3\n";
    assert_int_equal(saltus_scene_parse(three, strlen(three), "file", &scene, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "at most 2"));
    assert_non_null(strstr(message.text, "help text"));
}

/* All subsets are enumerated once, by size, and by value within a size. */
static void subsets_come_by_size(void **unused) {
    (void)unused;
    static const unsigned sets[] = {0x1, 0x80000000, 0x2d, 0x813, 0xff, 0xa0500a11};
    for (size_t k = 0; k < sizeof sets / sizeof sets[0]; k++) {
        unsigned subset = 0, count = 1;
        for (; subset != sets[k]; count++) {
            const unsigned next = saltus_next_subset(sets[k], subset);
            const int size = saltus_count_bits(subset), following = saltus_count_bits(next);
            assert_true((next & ~sets[k]) == 0);
            assert_true(following == size ? next > subset : following == size + 1);
            subset = next;
        }
        assert_int_equal(count, 1u << saltus_count_bits(sets[k]));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stops_that_are_not_met_change_nothing),
        cmocka_unit_test(a_load_comes_to_rest_among_ten_stops),
        cmocka_unit_test(limits_are_told),
        cmocka_unit_test(subsets_come_by_size),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
