/* The observed displacement: the specification's choice, everything reported about it, and its root mean
 * square.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "command.h"
#include "sweep_check.h"

#include <math.h>

static saltus_scene scene_with(const char *name, const char *choice) {
    saltus_message message = {.text = ""};
    saltus_scene scene;
    char setting[80];
    check_ok(saltus_scene_load(name, &scene, &message), &message);
    snprintf(setting, sizeof setting, "observe=%s", choice);
    check_ok(saltus_scene_set(&scene, setting, &message), &message);
    return scene;
}

static void check_row(const char *name, const char *choice, const double *row, const char *called) {
    saltus_scene scene = scene_with(name, choice);
    saltus_system *system = build(&scene.spec);
    for (int i = 0; i < saltus_system_dof(system); i++)
        check_near(saltus_system_observer(system)[i], row[i], 1e-15);
    if (called)
        assert_string_equal(saltus_system_observed_name(system), called);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
}

static void choices_are_rows(void **unused) {
    (void)unused;
    double middle[5], place[5];
    for (int i = 0; i < 5; i++) {
        middle[i] = sin((i + 1) * M_PI / 2);
        place[i] = sin((i + 1) * M_PI * 0.3);
    }
    check_row("fig7d", "", middle, NULL);
    check_row("fig7d", "stop1", middle, NULL);
    check_row("fig7d", "0.3", place, NULL);
    check_row("fig7d", "3e-1", place, NULL);
    check_row("fig7d", "q2", (const double[5]){0, 1}, "q2");
    check_row("two-mass", "q2", (const double[2]){0, 1}, NULL);
    check_row("impact-damper", "", (const double[2]){1, 0}, "box");
    check_row("impact-damper", "box", (const double[2]){1, 0}, "box");
    check_row("impact-damper", "y", (const double[2]){0, 1}, "y");
    check_row("impact-damper", "q2", (const double[2]){0, 1}, "y");
    check_row("impact-damper", "stop1", (const double[2]){-1, 1}, "y - x");
}

static void wrong_choices_are_refused(void **unused) {
    (void)unused;
    static const char *const wrong[][3] = {
        {"fig7d", "q6", "q1 to q5"},
        {"fig7d", "v1", "q1 to q5"},
        {"fig7d", "stop2", "stops (stop1), places on the line ("},
        {"fig7d", "0", "0 < xi < 1"},
        {"fig7d", "1", "0 < xi < 1"},
        {"fig7d", "nan", "0 < xi < 1"},
        {"two-stops", "0.3", "(q1), stops (stop1 to stop2)"},
        {"two-stops", "stop3", "stops (stop1 to stop2)"},
        {"impact-damper", "x'", "(x, y)"},
        {"fig2", "stop1", "(q1 to q5), places"},
        {"relief-valve", "p", "(x), stops (stop1), quantities of the scene (lift)"},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        saltus_scene scene = scene_with(wrong[k][0], wrong[k][1]);
        saltus_message message = {.text = ""};
        saltus_system *system;
        assert_int_equal(saltus_system_new(&scene.spec, &system, &message), SALTUS_BAD_INPUT);
        assert_null(system);
        assert_string_equal(message.key, "observe");
        assert_non_null(strstr(message.text, wrong[k][1]));
        assert_non_null(strstr(message.text, wrong[k][2]));
        saltus_scene_clear(&scene);
    }
}

/* A quantity that is no linear combination of displacements cannot be shown in diagrams. */
static void sums_of_displacements_alone_are_observed(void **unused) {
    (void)unused;
    static const char text[] = "model:\n  parameters: {c: 0.1}\n  motion: {x: -c*x' - x, y: x - y}\n"
                               "  observe: {energy: \"x^2 + x'^2\", both: x + 2*y, moved: x + 1}\n";
    saltus_scene scene;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_parse(text, strlen(text), "text", &scene, &message), &message);
    saltus_system *system = build(&scene.spec);
    assert_string_equal(saltus_system_observed_name(system), "x");
    saltus_system_free(system);
    check_ok(saltus_scene_set(&scene, "observe=both", &message), &message);
    system = build(&scene.spec);
    assert_true(saltus_system_observer(system)[0] == 1 && saltus_system_observer(system)[1] == 2);
    saltus_system_free(system);
    static const char *const refused[] = {"observe=energy", "observe=moved"};
    for (int k = 0; k < 2; k++) {
        check_ok(saltus_scene_set(&scene, refused[k], &message), &message);
        assert_int_equal(saltus_system_new(&scene.spec, &system, &message), SALTUS_BAD_INPUT);
        assert_non_null(strstr(message.text, "no sum of displacements"));
    }
    saltus_scene_clear(&scene);
}

/* All samples, also at impacts, hold the observed displacement and its rate. */
static void records_are_of_what_is_observed(void **unused) {
    (void)unused;
    static const char *const choices[][2] = {
        {"impact-damper", ""},  {"impact-damper", "y"}, {"impact-damper", "stop1"}, {"fig7d", "0.3"},
        {"two-stops", "stop2"}, {"chain", "x2"},        {"two-mass", "q2"}};
    for (size_t k = 0; k < sizeof choices / sizeof choices[0]; k++) {
        saltus_scene scene = scene_with(choices[k][0], choices[k][1]);
        saltus_system *system = NULL;
        saltus_message message = {.text = ""};
        saltus_trajectory r;
        saltus_flow_options options = saltus_flow_defaults();
        double state[SALTUS_STATE_MAX];
        check_ok(saltus_system_new(&scene.spec, &system, &message), &message);
        check_ok(saltus_scene_state(&scene, system, state, &message), &message);
        check_ok(saltus_trajectory_record(system, state, &options, 20, 8, 40, &r, &message), &message);
        assert_true(r.event_count > 0);
        const double unit = saltus_system_scale(system)[0];
        for (long long row = 0; row < r.samples; row++) {
            const double *x = r.states + row * r.dimension;
            check_near(r.displacement[row], saltus_system_observed(system, x), 1e-10 * unit);
            check_near(r.velocity[row], saltus_system_observed(system, x + saltus_system_dof(system)),
                       1e-7 * saltus_system_scale(system)[saltus_system_dof(system)]);
        }
        saltus_trajectory_clear(&r);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

/* A free mass between two elastic stops: a triangle wave, d / sqrt(3). */
static void a_triangle_wave_has_its_root_mean_square(void **unused) {
    (void)unused;
    const double d = 0.7;
    saltus_sweep_options options = saltus_sweep_defaults();
    saltus_message message = {.text = ""};
    saltus_scene scene;
    static const char text[] = "model: oscillator\nk: 0\nomega: 1\nstop: {d: 0.7, r: 1, sides: both}\n";
    char speed[64];
    check_ok(saltus_scene_parse(text, strlen(text), "text", &scene, &message), &message);
    snprintf(speed, sizeof speed, "v1=%.17g", 4 * d / (2 * M_PI));
    check_ok(saltus_scene_set(&scene, speed, &message), &message);
    check_ok(saltus_scene_set(&scene, "q1=0.1", &message), &message);
    options.adaptive = false;
    options.transient = 3;
    options.record = 5;
    saltus_sweep *sweep = sweep_of(&scene, "m=1,2", NULL, &options);
    outcome o = open_outcome(sweep);
    run_part(&o, 0, 1);
    for (long long place = 0; place < 2; place++)
        check_near(result_at(&o, place).rows->rms, d / sqrt(3), 1e-12);
    close_outcome(&o);
    saltus_sweep_free(sweep);
    saltus_scene_clear(&scene);
}

/* The integral of a square over the smooth stretches of a record, by Simpson's rule. */
static double sampled_rms(const saltus_system *system, const saltus_motion *motion) {
    enum { fine = 2000 };
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_trajectory r;
    double sum = 0;
    check_ok(
        saltus_trajectory_record(system, motion->state, &options, 0, motion->periods, fine, &r, &message),
        &message);
    /* Between two samples the displacement is the cubic with the values and rates of both, of fourth
     * order. */
    for (long long k = 0; k + 1 < r.samples; k++) {
        const double h = r.time[k + 1] - r.time[k], a = r.displacement[k], b = r.displacement[k + 1],
                     rates = (r.velocity[k] - r.velocity[k + 1]) * saltus_system_period(system),
                     middle = 0.5 * (a + b) + h / 8 * rates;
        sum += h / 6 * (a * a + 4 * middle * middle + b * b);
    }
    saltus_trajectory_clear(&r);
    return sqrt(sum / motion->periods);
}

static void root_mean_squares_are_those_of_samples(void **unused) {
    (void)unused;
    static const char *const choices[][3] = {
        {"fig7d", "", ""},      {"fig7d", "0.3", ""}, {"fig7d", "q3", ""},   {"two-stops", "", ""},
        {"two-mass", "q2", ""}, {"chatter", "", ""},  {"fig7d", "", "N=12"}, {"impact-oscillator", "", ""}};
    for (size_t k = 0; k < sizeof choices / sizeof choices[0]; k++) {
        saltus_scene scene = scene_with(choices[k][0], choices[k][1]);
        saltus_message message = {.text = ""};
        saltus_motion motion;
        double state[SALTUS_STATE_MAX];
        if (choices[k][2][0]) {
            scene.initial_count = 0;
            check_ok(saltus_scene_set(&scene, choices[k][2], &message), &message);
        }
        saltus_system *system = build(&scene.spec);
        check_ok(saltus_scene_state(&scene, system, state, &message), &message);
        saltus_classify_options options = saltus_classify_defaults();
        check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
        assert_int_equal(motion.verdict, SALTUS_PERIODIC);
        check_near(motion.rms / sampled_rms(system, &motion), 1, 1e-8);
        assert_true(motion.rms <= fmax(fabs(motion.largest), fabs(motion.smallest)));
        saltus_motion_clear(&motion);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

/* The report names what is observed where the scene says it. */
static void reports_name_what_is_observed(void **state) {
    static const char *const cases[][2] = {{"classify fig7d", NULL},
                                           {"classify fig7d --set observe=q2", " (of q2)\n"},
                                           {"classify fig7d --set observe=0.3", " (at xi = 0.3)\n"},
                                           {"classify fig7d --set observe=stop1", " (at xi = 0.5)\n"},
                                           {"classify duffing", " (of x)\n"}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char *text = told(*state, cases[k][0]), *line = strstr(text, "displacement ");
        assert_non_null(line);
        const char *end = strchr(line, '\n') + 1;
        if (cases[k][1])
            assert_memory_equal(end - strlen(cases[k][1]), cases[k][1], strlen(cases[k][1]));
        else
            assert_null(memchr(line, '(', (size_t)(end - line)));
        free(text);
    }
}

/* Files keep the choice; another choice makes another sweep. */
static void files_keep_the_choice(void **state) {
    fixture *f = *state;
    size_t length;
    assert_int_equal(run(f, "classify fig7d --set observe=0.3 --json >orbit.json; exec true"), 0);
    char *text = read_all(path_in(f, "orbit.json"), &length);
    assert_non_null(strstr(text, "\"observe\": \"0.3\""));
    free(text);
    free(told(f, "simulate fig7d --from orbit.json --periods 1 -o a.csv"));
    free(told(f, "simulate fig7d --set observe=0.3 --from orbit.json --periods 1 -o b.csv"));
    free(told(f, "simulate fig7d --set observe=q1 --from orbit.json --periods 1 -o c.csv"));
    char *a = read_all(path_in(f, "a.csv"), &length), *b = read_all(path_in(f, "b.csv"), &length),
         *c = read_all(path_in(f, "c.csv"), &length);
    assert_string_equal(strstr(a, "# model"), strstr(b, "# model"));
    assert_non_null(strstr(a, "observe = 0.3"));
    assert_non_null(strstr(c, "observe = q1"));
    free(a);
    free(b);
    free(c);
    free(told(f,
              "sweep two-stops --set observe=stop2 --over omega=1.2:1.3:3 --transient 20 --record 2 -o s.h5 "
              "--quiet"));
    text = told(f, "export s.h5 -o s.csv");
    free(text);
    text = read_all(path_in(f, "s.csv"), &length);
    assert_non_null(strstr(text, "observe = stop2"));
    free(text);
    assert_int_equal(run(f,
                         "sweep two-stops --set observe=q1 --over omega=1.2:1.3:3 --transient 20 --record 2 "
                         "-o s.h5 --resume"),
                     2);
    text = said(f, "err");
    assert_non_null(strstr(text, "observe is stop2 there and q1 now"));
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(choices_are_rows),
        cmocka_unit_test(wrong_choices_are_refused),
        cmocka_unit_test(sums_of_displacements_alone_are_observed),
        cmocka_unit_test(records_are_of_what_is_observed),
        cmocka_unit_test(a_triangle_wave_has_its_root_mean_square),
        cmocka_unit_test(root_mean_squares_are_those_of_samples),
        cmocka_unit_test_setup_teardown(reports_name_what_is_observed, open_fixture, close_fixture),
        cmocka_unit_test_setup_teardown(files_keep_the_choice, open_fixture, close_fixture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
