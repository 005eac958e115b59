/* Verdicts on unforced scenes other than cycles: tori, chaos and its exponents, balls that come to rest,
 * scenes that preserve volume, sections that are not met.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"
#include "sweep_check.h"

/* Two self-excited oscillators, side by side. */
static const char oscillators[] = "model:\n"
                                  "  parameters: {mu: 0.5, w: 1.7, c: 0.05}\n"
                                  "  motion:\n"
                                  "    x: mu*(1 - x^2)*x' - x + c*(y - x)\n"
                                  "    y: mu*(1 - y^2)*y' - w^2*y + c*(x - y)\n"
                                  "initial: {x: 0.5, y: 0.5}\n";
static const char ball[] = "model:\n"
                           "  motion: {x: -1}\n"
                           "stop: {coordinate: x, d: 0, r: 0.8, sides: lower}\n"
                           "initial: {x: 1, x': 0}\n";
static const char spring[] = "model:\n"
                             "  motion: {x: -x - x^3}\n"
                             "stop: {coordinate: x, d: 0, r: 1, sides: lower}\n"
                             "initial: {x: 0.3, x': 0.8}\n";
static const char struck[] = "model:\n"
                             "  parameters: {mu: 1}\n"
                             "  motion: {x: mu*(1 - x^2)*x' - x}\n"
                             "stop: {coordinate: x, d: 1.5, r: 0.7, sides: upper}\n"
                             "initial: {x: 0.5}\n";

static saltus_scene scene_from(const char *text, const char *setting) {
    saltus_message message = {.text = ""};
    saltus_scene scene;
    check_ok(saltus_scene_parse(text, strlen(text), "text", &scene, &message), &message);
    if (setting)
        check_ok(saltus_scene_set(&scene, setting, &message), &message);
    return scene;
}

static saltus_motion classified(const saltus_scene *scene) {
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_system *system = build(&scene->spec);
    saltus_motion motion;
    double state[SALTUS_STATE_MAX];
    check_ok(saltus_scene_state(scene, system, state, &message), &message);
    check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
    saltus_system_free(system);
    return motion;
}

/* Incommensurate frequencies fill a torus; close to a ratio coupling locks them. A sweep agrees. */
static void two_oscillators_fill_a_torus_or_lock(void **unused) {
    (void)unused;
    skip_where_slow();
    static const struct {
        const char *setting, *axis;
        saltus_verdict verdict;
    } cases[] = {{"w=1.7", "w=1.7", SALTUS_QUASIPERIODIC}, {"w=1.001", "w=1.001", SALTUS_PERIODIC}};
    for (int k = 0; k < 2; k++) {
        saltus_scene scene = scene_from(oscillators, cases[k].setting);
        saltus_sweep_options options = saltus_sweep_defaults();
        saltus_motion m = classified(&scene);
        assert_int_equal(m.verdict, cases[k].verdict);
        if (m.verdict == SALTUS_QUASIPERIODIC) {
            assert_true(fabs(m.lyapunov) < 3 * m.lyapunov_error + 1e-5 && m.evidence.curves == 1);
            check_near(m.evidence.dimension, 1, 0.3); /* of the section */
            check_near(m.evidence.zero_one, 0, 0.1);
        }
        options.threads = 1;
        options.keep = SALTUS_KEEP_LYAPUNOV;
        saltus_sweep *sweep = sweep_of(&scene, cases[k].axis, NULL, &options);
        outcome o = open_outcome(sweep);
        run_part(&o, 0, 1);
        assert_int_equal(result_at(&o, 0).rows->verdict, cases[k].verdict);
        close_outcome(&o);
        saltus_sweep_free(sweep);
        saltus_motion_clear(&m);
        saltus_scene_clear(&scene);
    }
}

/* Published: between 1 and 2. One exponent is that of time, zero, and the sum is that of the trace. */
static void exponents_of_flutter(void **unused) {
    (void)unused;
    static const char *const settings[] = {"u=8.1", "u=8.2"};
    for (int k = 0; k < 2; k++) {
        saltus_scene scene = scene_of("flutter", settings[k]);
        saltus_system *system = build(&scene.spec);
        saltus_lyapunov_options options = saltus_lyapunov_defaults();
        saltus_message message = {.text = ""};
        saltus_lyapunov l;
        double state[SALTUS_STATE_MAX];
        options.exponents = 0;
        options.precision = 0.05;
        check_ok(saltus_scene_state(&scene, system, state, &message), &message);
        check_ok(saltus_lyapunov_run(system, state, &options, &l, &message), &message);
        const double error = l.standard_errors[0];
        assert_true(error > 0 && error < 0.1);
        assert_true(l.exponents[0] - 3 * error > 1 && l.exponents[0] + 3 * error < 2);
        check_near(l.exponents[1], 0, 4 * l.standard_errors[1]);
        check_near(l.sum, l.sum_rule, 1e-9 * fabs(l.sum_rule));
        saltus_lyapunov_clear(&l);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

static void a_stop_bounds_van_der_pol(void **unused) {
    (void)unused;
    saltus_scene scene = scene_from(struck, NULL);
    saltus_motion m = classified(&scene);
    assert_string_equal(m.label, "1/1");
    assert_true(m.stable);
    check_near(m.trivial_multiplier, 1, 1e-9);
    check_near(m.log_volume, m.sum_rule, 1e-9);
    check_near(m.largest, 1.5, 1e-12);
    check_near(m.events[0].velocity_after, -0.7 * m.events[0].velocity_before, 1e-12);
    saltus_motion_clear(&m);
    saltus_scene_clear(&scene);
}

/* A ball falls from height 1 onto a table: flights shorten by r, ending after sqrt(2) (1 + r) / (1 - r).
 * Without loss it bounces for ever, with period 2 sqrt(2). */
static void a_ball_comes_to_rest(void **unused) {
    (void)unused;
    static const char *const settings[] = {"r=0", "r=0.5", "r=0.8", "r=0.95"};
    for (int k = 0; k < 4; k++) {
        saltus_scene scene = scene_from(ball, settings[k]);
        saltus_system *system = build(&scene.spec);
        saltus_flow_options options = saltus_flow_defaults();
        double r = scene.spec.stops[0].r, start[2] = {1, 0};
        saltus_flow *flow = open_flow(system, &options, 0, start);
        saltus_event event = advance(flow, 1000, SALTUS_WATCH_STICK);
        assert_int_equal(event.kind, SALTUS_STICK);
        check_near(saltus_time_periods(event.time), sqrt(2) * (1 + r) / (1 - r), 1e-9);
        saltus_motion m = classified(&scene);
        assert_int_equal(m.verdict, SALTUS_HELD);
        check_near(m.contact_force[0], 1, 1e-12);
        saltus_motion_clear(&m);
        saltus_flow_free(flow);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
    saltus_scene scene = scene_from(ball, "r=1");
    saltus_motion m = classified(&scene);
    assert_string_equal(m.label, "1/1");
    check_near(m.period, 2 * sqrt(2), 1e-9);
    assert_non_null(strstr(m.reason, "continua"));
    saltus_motion_clear(&m);
    saltus_scene_clear(&scene);
}

/* The same damped mass at rest in very different units of time, alone and along a branch of equilibria. */
static void a_rest_is_stable_in_any_unit_of_time(void **unused) {
    (void)unused;
    for (int k = 0; k <= 10; k++) {
        char text[200];
        const double rate = pow(10, -k);
        snprintf(text, sizeof text,
                 "model:\n"
                 "  parameters: {w: %.17g, load: 0}\n"
                 "  motion: {x: -w*x' - w^2*(x - load)}\n"
                 "stop: {coordinate: x, d: 5, r: 0.5, sides: upper}\n"
                 "initial: {x: 0}\n",
                 rate);
        saltus_scene scene = scene_from(text, NULL);
        saltus_motion motion = classified(&scene);
        assert_int_equal(motion.verdict, SALTUS_EQUILIBRIUM);
        assert_true(motion.stable);
        assert_int_equal(motion.eigenvalue_count, 2);
        check_near(motion.eigenvalues[0].re / rate, -0.5, 1e-9);
        check_near(motion.lyapunov / rate, -0.5, 1e-9);
        saltus_branch_options options = branch_along("load", 0, 1);
        options.step_max = 0.2;
        options.direction = 1;
        branch_record record = branch_run(&scene.spec, 0, motion.state, &options);
        check_near(record.point[record.count - 1].state[0], 1, 1e-9);
        for (int j = 0; j < record.count; j++) {
            assert_true(record.point[j].stable && record.point[j].unstable == 0);
            check_near(record.point[j].multipliers[0].re / rate, -0.5, 1e-9);
        }
        branch_forget(&record);
        saltus_motion_clear(&motion);
        saltus_scene_clear(&scene);
    }
}

/* Half a period of a hardening spring against an elastic wall at its rest: energy is kept, and the period is
 * twice the time from the wall to the turning point, an integral that a substitution makes smooth. There is
 * an orbit for every energy. */
static void conservative_scenes_are_told(void **unused) {
    (void)unused;
    enum { pieces = 2000 };
    for (int k = 0; k < 3; k++) {
        char setting[32];
        double speed = 0.5 + 0.4 * k, time = 0;
        snprintf(setting, sizeof setting, "x'=%.17g", speed);
        saltus_scene scene = scene_from(spring, setting);
        double energy = 0.5 * speed * speed + 0.5 * 0.09 + 0.25 * 0.0081;
        double top = sqrt(sqrt(1 + 4 * energy) - 1);
        /* x = top sin a: energy - potential(x) = (top^2 - x^2) (2 + top^2 + x^2) / 4. */
        for (int i = 0; i < pieces; i++) {
            double x = top * sin(M_PI / 2 * (i + 0.5) / pieces);
            time += M_PI / 2 / pieces / sqrt((2 + top * top + x * x) / 2);
        }
        saltus_motion m = classified(&scene);
        assert_string_equal(m.label, "1/1");
        check_near(m.period, 2 * time, 1e-8);
        check_near(m.largest, top, 1e-8);
        assert_true(!m.stable);
        check_near(m.multipliers[0].re, 1, 1e-6);
        assert_non_null(strstr(m.reason, "continua"));
        saltus_motion_clear(&m);
        saltus_scene_clear(&scene);
    }
    saltus_scene damped = scene_from(spring, "r=0.99");
    saltus_system *system = build(&damped.spec);
    assert_false(saltus_system_conservative(system));
    saltus_system_free(system);
    saltus_scene_clear(&damped);
}

static void a_section_that_is_not_met_is_told(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_scene scene = scene_of("relief-valve", "q=7.9");
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_set_section(&scene, "impact: 1", &message), &message);
    saltus_motion m = classified(&scene);
    assert_true(!saltus_verdict_settled(m.verdict));
    assert_non_null(strstr(m.reason, "does not return to its section"));
    saltus_motion_clear(&m);
    saltus_scene_clear(&scene);
    /* A ball at rest on an oscillating table: the gap has no maxima any more, the table's position has. */
    static const char ball[] = "model:\n"
                               "  motion: {x: -0.2, y: 0.5*(1 - y^2)*y' - y}\n"
                               "  mass: {x: 0.05, y: 1}\n"
                               "  observe: {gap: x - y, table: y}\n"
                               "stop: {coordinate: x - y, d: 0, r: 0.4, sides: lower}\n"
                               "initial: {x: 1, y: 0.3}\n";
    for (int table = 0; table < 2; table++) {
        check_ok(saltus_scene_parse(ball, strlen(ball), "text", &scene, &message), &message);
        check_ok(saltus_scene_set(&scene, table ? "observe=table" : "observe=gap", &message), &message);
        m = classified(&scene);
        assert_true(table ? m.verdict == SALTUS_HELD : !saltus_verdict_settled(m.verdict));
        assert_true(table || strstr(m.reason, "does not return to its section"));
        saltus_motion_clear(&m);
        saltus_scene_clear(&scene);
    }
}

/* An oscillation against an elastic stop returns to the section at its impacts, which are equally fast but
 * for rounding: they are no chatter. Of its family the orbit found has a closed-form period. */
static void elastic_impacts_are_returns(void **unused) {
    (void)unused;
    static const double speeds[] = {1.2, 2, 3};
    const double k = 4, d = 0.5, w = sqrt(k);
    for (int row = 0; row < 3; row++) {
        saltus_spec spec = oscillator_spec(0, k, 0, 1);
        saltus_classify_options options = saltus_classify_defaults();
        saltus_message message = {.text = ""};
        saltus_motion motion;
        add_stop(&spec, d, 1, SALTUS_UPPER);
        saltus_system *system = build(&spec);
        const double start[2] = {-0.2, speeds[row]};
        options.transient = 100;
        check_ok(saltus_motion_returning(system, start, 1, &options, &motion, &message), &message);
        assert_string_equal(motion.label, "1/1");
        const double amplitude = hypot(motion.state[0], motion.state[1] / w);
        check_near(motion.period, 2 * (M_PI - acos(d / amplitude)) / w, 1e-10);
        check_near(amplitude, hypot(start[0], start[1] / w), 1e-9);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_oscillators_fill_a_torus_or_lock),
        cmocka_unit_test(exponents_of_flutter),
        cmocka_unit_test(a_stop_bounds_van_der_pol),
        cmocka_unit_test(a_ball_comes_to_rest),
        cmocka_unit_test(a_rest_is_stable_in_any_unit_of_time),
        cmocka_unit_test(conservative_scenes_are_told),
        cmocka_unit_test(elastic_impacts_are_returns),
        cmocka_unit_test(a_section_that_is_not_met_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
