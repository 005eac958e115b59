/* Where trajectories start: entries that scene and settings leave open are the system's defaults, everywhere.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_check.h"

/* The first section point that a sweep records is its start. */
static void sweeps_start_from_the_rest_of_the_default(void **unused) {
    (void)unused;
    static const char *const axes[] = {"q1=-0.01,0,0.004", "v1=-0.2,0.1,0.3"};
    saltus_scene scene = scene_of("fig7b", "d=0.02955");
    saltus_system *system = build(&scene.spec);
    saltus_message message = {.text = ""};
    saltus_sweep_options options = saltus_sweep_defaults();
    const int n = saltus_system_dimension(system);
    double start[SALTUS_STATE_MAX];
    bool other = false;
    check_ok(saltus_system_default_state(system, start, &message), &message);
    options.keep = SALTUS_KEEP_STROBOSCOPIC;
    options.adaptive = false;
    options.transient = 0;
    options.record = 1;
    saltus_sweep *sweep = sweep_of(&scene, axes[0], axes[1], &options);
    outcome o = open_outcome(sweep);
    run_part(&o, 0, 1);
    for (long long place = 0; place < o.places; place++) {
        saltus_sweep_result result = result_at(&o, place);
        const double moved[] = {saltus_axis_value(saltus_sweep_axis(sweep, 0), (int)(place % 3)),
                                saltus_axis_value(saltus_sweep_axis(sweep, 1), (int)(place / 3))};
        for (int i = 0; i < n; i++) {
            double expected = i == 0 ? moved[0] : i == n / 2 ? moved[1] : start[i];
            assert_true(result.strobes[i] == expected);
            other |= i != 0 && i != n / 2 && expected != 0;
        }
    }
    assert_true(other);
    close_outcome(&o);
    saltus_sweep_free(sweep);
    saltus_system_free(system);
}

/* The order of settings does not matter, though the default depends on parameters; entries given in the
 * scene's text stay. */
static void settings_leave_the_rest_alone(void **unused) {
    (void)unused;
    static const char *const orders[] = {"q1=0.003 d=0.011 u0=4.2", "d=0.011 q1=0.003 u0=4.2",
                                         "u0=4.2 d=0.011 q1=0.003"};
    saltus_message message = {.text = ""};
    for (int k = 0; k < 3; k++) {
        saltus_scene scene = scene_of("fig7b", orders[k]), plain = scene_of("fig7b", "d=0.011 u0=4.2");
        saltus_system *system = build(&scene.spec);
        double state[SALTUS_STATE_MAX], start[SALTUS_STATE_MAX];
        check_ok(saltus_scene_state(&scene, system, state, &message), &message);
        check_ok(saltus_scene_state(&plain, system, start, &message), &message);
        assert_true(state[0] == 0.003);
        for (int i = 1; i < saltus_system_dimension(system); i++)
            assert_true(state[i] == start[i]);
        check_ok(saltus_system_default_state(system, state, &message), &message);
        assert_memory_equal(state, start, (size_t)saltus_system_dimension(system) * sizeof *state);
        saltus_system_free(system);
    }
    static const char text[] = "model: oscillator\nN: 2\ninitial: {q: [0.1, 0.2], v: [0.3, 0.4]}\n";
    saltus_scene given;
    double state[SALTUS_STATE_MAX];
    check_ok(saltus_scene_parse(text, sizeof text - 1, "given", &given, &message), &message);
    check_ok(saltus_scene_set(&given, "v1=0.5", &message), &message);
    saltus_system *system = build(&given.spec);
    check_ok(saltus_scene_state(&given, system, state, &message), &message);
    assert_true(state[0] == 0.1 && state[1] == 0.2 && state[2] == 0.5 && state[3] == 0.4);
    saltus_system_free(system);
}

/* Impossible states are reported. */
static void impossible_starts_are_refused(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    saltus_scene scene = scene_of("impact-oscillator", "q1=2");
    saltus_system *system = build(&scene.spec);
    double state[SALTUS_STATE_MAX];
    assert_int_equal(saltus_scene_state(&scene, system, state, &message), SALTUS_BAD_INPUT);
    assert_true(strlen(message.text) > 0);
    scene.initial_count = 3;
    assert_int_equal(saltus_scene_state(&scene, system, state, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "3 entries"));
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sweeps_start_from_the_rest_of_the_default),
        cmocka_unit_test(settings_leave_the_rest_alone),
        cmocka_unit_test(impossible_starts_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
