/* Chaos or not: verdicts of classification on motions without a period, and their reasons.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

/* A built-in scene with settings, up to a NULL. */
static saltus_spec scene_spec(const char *name, const char *const *settings) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_load(name, &scene, &message), &message);
    for (int k = 0; settings[k]; k++)
        check_ok(saltus_scene_set(&scene, settings[k], &message), &message);
    return scene.spec;
}

static saltus_motion judge(const saltus_spec *spec, const saltus_classify_options *options) {
    saltus_system *system = build(spec);
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double start[64];
    check_ok(saltus_system_default_state(system, start, &message), &message);
    check_ok(saltus_classify(system, start, options, &motion, &message), &message);
    saltus_system_free(system);
    return motion;
}

static saltus_motion judge_scene(const char *name, const char *const *settings) {
    saltus_classify_options options = saltus_classify_defaults();
    options.measure = long_version() ? options.measure : 64000;
    saltus_spec spec = scene_spec(name, settings);
    return judge(&spec, &options);
}

static const char *const chaotic_pipe[] = {"omega=10", "d=0.035", NULL};

/* The exponent of an independent computation is 0.756 +- 0.01. */
static void chaos_is_proven(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_motion motion = judge_scene("fig6", chaotic_pipe);
    const saltus_evidence *e = &motion.evidence;
    assert_int_equal(motion.verdict, SALTUS_CHAOTIC);
    assert_string_equal(motion.label, "chaotic");
    assert_false(saltus_verdict_settled(motion.verdict));
    check_near(motion.lyapunov, 0.756, 0.01 + 3 * motion.lyapunov_error);
    assert_true(motion.lyapunov_error > 0 && motion.lyapunov_error < (long_version() ? 0.01 : 0.02));
    for (int half = 0; half < 2; half++)
        check_near(e->half[half], motion.lyapunov, 4 * e->half_errors[half]);
    assert_true(e->periods >= (long_version() ? 32000 : 8000) && e->members == 8 && e->left == 0);
    assert_true(e->zero_one > (long_version() ? 0.95 : 0.8) && e->curves == 0);
    assert_true(e->broadband > (long_version() ? 0.5 : 0.05));
    check_near(e->dimension, 1.2, 0.2);
    check_near(motion.largest, 0.035, 1e-12);
    assert_true(e->history_count >= 4);
    const saltus_lyapunov_progress *last = &e->history[e->history_count - 1];
    check_near(last->exponent, motion.lyapunov, 1e-12);
    check_near(last->time, (double)e->periods * 2 * M_PI / 10, 1e-6);
    saltus_motion_clear(&motion);
}

static void verdicts_repeat_bit_for_bit(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_classify_options options = saltus_classify_defaults();
    saltus_spec spec = scene_spec("fig6", chaotic_pipe);
    options.transient = 700;
    options.measure = 8000;
    options.lifetime = options.measure / 24;
    saltus_motion a = judge(&spec, &options), b = judge(&spec, &options);
    assert_int_equal(a.verdict, SALTUS_CHAOTIC);
    assert_true(a.lyapunov == b.lyapunov && a.lyapunov_error == b.lyapunov_error);
    assert_memory_equal(a.state, b.state, (size_t)a.dimension * sizeof(double));
    assert_string_equal(a.reason, b.reason);
    saltus_motion_clear(&a);
    saltus_motion_clear(&b);
}

/* A torus of two masses, one of which hits a stop, and one of an undamped oscillator without impacts. */
static void tori_are_quasi_periodic(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const settings[] = {"omega=1.7133", "d=-0.1797", "r=0.323", "c=0.07",
                                           "c2=0.07",      "m2=1.57",   "k2=2.51", NULL};
    saltus_spec spec = scene_spec("two-mass", settings);
    saltus_classify_options options = saltus_classify_defaults();
    spec.stops[0].weight[0] = 0;
    spec.stops[0].weight[1] = 1;
    for (int case_number = 0; case_number < 2; case_number++) {
        saltus_motion motion = judge(&spec, &options);
        if (motion.verdict != SALTUS_QUASIPERIODIC)
            fail_msg("case %d: %s: %s", case_number, motion.label, motion.reason);
        assert_string_equal(motion.label, "quasi-periodic");
        check_near(motion.lyapunov, 0, 4 * motion.lyapunov_error + 1e-6);
        assert_true(motion.evidence.curves == 1 && motion.evidence.broadband < 1e-6);
        assert_true(motion.evidence.zero_one < 0.2);
        check_near(motion.evidence.dimension, 1, 0.1 + motion.evidence.dimension_error);
        saltus_motion_clear(&motion);
        spec = oscillator_spec(0, 1, 1, 0.6180339887498949);
        add_stop(&spec, 100, 0.8, SALTUS_UPPER);
    }
}

/* Trajectories on a chaotic transient leave it one by one: not chaos. */
static void transients_are_seen_through(void **unused) {
    (void)unused;
    static const char *const settings[] = {"omega=1.6467", "d=-0.0687", "r=0.871", "c=0.035",
                                           "c2=0.035",     "m2=0.77",   "k2=2.1",  NULL};
    saltus_classify_options options = saltus_classify_defaults();
    saltus_spec spec = scene_spec("two-mass", settings);
    options.transient = 4000;
    saltus_motion motion = judge(&spec, &options);
    if (motion.verdict == SALTUS_TRANSIENT) {
        assert_string_equal(motion.label, "transient");
        assert_true(motion.evidence.left >= 1);
        assert_string_equal(motion.evidence.left_for, "18/4");
    } else
        assert_string_equal(motion.label, "18/4");
    saltus_motion_clear(&motion);
}

/* Chaos that lasts for some 1e4 periods (the pipe: 1e5) and ends on an orbit: the orbit is found amid it, and
 * chaos is not asserted. */
static void stable_orbits_amid_chaos_count(void **unused) {
    (void)unused;
    static const char *const pipe[] = {"omega=43.640162", "d=0.016796", NULL},
                             *const masses[] = {"omega=1.6467", "d=-0.0687", "r=0.871", "c=0.035",
                                                "c2=0.035",     "m2=0.77",   "k2=2.1",  NULL};
    saltus_classify_options options = saltus_classify_defaults();
    saltus_spec spec = long_version() ? scene_spec("fig6", pipe) : scene_spec("two-mass", masses);
    const char *label = long_version() ? "2/1" : "18/4";
    options.transient = long_version() ? 2500 : 1600;
    options.measure = long_version() ? options.measure : 8000;
    options.lifetime = options.measure / 24;
    saltus_motion motion = judge(&spec, &options);
    if (motion.verdict == SALTUS_TRANSIENT) {
        const saltus_evidence *e = &motion.evidence;
        assert_true(e->left > 0 || strcmp(e->stable_orbit, label) == 0);
        assert_string_equal(e->left > 0 ? e->left_for : e->stable_orbit, label);
        assert_non_null(strstr(motion.reason, label));
        assert_true(e->lifetime_at_least > 0);
    } else
        assert_string_equal(motion.label, label);
    saltus_motion_clear(&motion);
}

/* Without time to measure nothing is asserted, and what is lacking is stated. */
static void little_time_leaves_it_open(void **unused) {
    (void)unused;
    saltus_classify_options options = saltus_classify_defaults();
    saltus_spec spec = scene_spec("fig6", chaotic_pipe);
    options.transient = 300;
    options.measure = 0;
    saltus_motion motion = judge(&spec, &options);
    assert_int_equal(motion.verdict, SALTUS_IRREGULAR);
    assert_true(isnan(motion.lyapunov) && motion.evidence.periods == 0);
    assert_non_null(strstr(motion.reason, "after 300 periods"));
    saltus_motion_clear(&motion);
    options.measure = 100;
    motion = judge(&spec, &options);
    assert_int_equal(motion.verdict, SALTUS_IRREGULAR);
    assert_true(strlen(motion.reason) > 20);
    saltus_motion_clear(&motion);
}

static void stop_at_5000(void *context, double periods, double at_most) {
    (void)at_most;
    *(volatile sig_atomic_t *)context |= periods >= 5000;
}

static void the_caller_may_stop_it(void **unused) {
    (void)unused;
    saltus_classify_options options = saltus_classify_defaults();
    saltus_spec spec = scene_spec("fig6", chaotic_pipe);
    volatile sig_atomic_t stop = 0;
    options.progress = (saltus_progress){stop_at_5000, (void *)&stop};
    options.flow.stop = &stop;
    saltus_motion motion = judge(&spec, &options);
    assert_int_equal(motion.verdict, SALTUS_UNDECIDED);
    assert_true(stop && motion.evidence.periods == 0);
    saltus_motion_clear(&motion);
}

/* The exponent of an orbit follows from its multipliers, that of an equilibrium from its eigenvalues; lost
 * directions have none. */
static void orbits_have_exponents(void **unused) {
    (void)unused;
    static const char *const none[] = {NULL};
    saltus_motion motion = judge_scene("fig7d", none);
    check_near(motion.lyapunov, motion.multipliers[0].log_modulus / (4 * 2 * M_PI / 42), 1e-12);
    assert_true(motion.lyapunov < 0 && motion.lyapunov_error == 0 && motion.evidence.periods == 0);
    saltus_motion_clear(&motion);
    saltus_spec spec = pipe_spec(1, 42);
    set_parameter(&spec, "sigma", 0);
    saltus_classify_options options = saltus_classify_defaults();
    motion = judge(&spec, &options);
    assert_string_equal(motion.label, "equilibrium");
    /* The damping of one mode: alpha pi^4 / 2, plus what stretching adds in the buckled state. */
    double q = motion.state[0], l4 = M_PI * M_PI * M_PI * M_PI;
    check_near(motion.lyapunov, -0.5 * 0.005 * l4 * (1 + 5000 * q * q), 1e-9);
    saltus_motion_clear(&motion);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chaos_is_proven),
        cmocka_unit_test(verdicts_repeat_bit_for_bit),
        cmocka_unit_test(tori_are_quasi_periodic),
        cmocka_unit_test(transients_are_seen_through),
        cmocka_unit_test(stable_orbits_amid_chaos_count),
        cmocka_unit_test(little_time_leaves_it_open),
        cmocka_unit_test(the_caller_may_stop_it),
        cmocka_unit_test(orbits_have_exponents),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
