/* Restitutions that depend on the closing speed: closed forms, derivatives against differences, the same
 * answer by all means.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#define START "model:\n  parameters: {c: 0.1, F: 1, omega: 1.1, r0: 0.7, s0: 0.5}\n"
static const char oscillator[] =
    START "  motion: {x: \"-c*x' - x + F*cos(omega*t)\"}\n  forcing: omega\n"
          "stop: {coordinate: x, d: 0.3, r: \"r0/(1 + speed/s0)^0.25\", sides: both}\n";
/* Two masses that may hit their stops in the same instant, and each other. */
static const char masses[] =
    START "  motion: {x: \"-c*x' - 2*x + y + F*cos(omega*t)\", y: \"-c*y' - 3*y + x - 0.4*F*cos(omega*t)\"}\n"
          "  mass: {x: 1, y: 0.6}\n  forcing: omega\nstops:\n"
          "  - {coordinate: x, d: 0.2, r: \"r0*exp(-speed/s0)\", sides: both}\n"
          "  - {coordinate: y, d: 0.15, r: 0.6, sides: both}\n"
          "  - {coordinate: x - y, d: 0.25, r: \"r0 - 0.2*tanh(speed/s0)\"}\n";

static saltus_scene scene_of_text(const char *text) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_parse(text, strlen(text), "test", &scene, &message), &message);
    return scene;
}

/* A ball on a floor, r = r0 / (1 + speed): from one rebound at v to the next there are 2 v / g, and the
 * speeds follow v -> r0 v / (1 + v). */
static void a_ball(void **unused) {
    (void)unused;
    static const char text[] = "model: {parameters: {g: 9.8, r0: 0.6}, motion: {x: -g}}\n"
                               "stop: {coordinate: x, d: 0, r: r0/(1 + speed), sides: lower}\n"
                               "initial: {x: 1, x': 0}\n";
    saltus_scene scene = scene_of_text(text);
    saltus_system *system = build(&scene.spec);
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = 1e-14;
    saltus_flow *flow = open_flow(system, &options, 0, (const double[2]){1, 0});
    long double v = sqrtl(2 * 9.8L), time = v / 9.8L;
    const double period = saltus_system_period(system);
    int impacts = 0;
    saltus_event event = advance(flow, 100, SALTUS_WATCH_CONTACT);
    for (; event.kind == SALTUS_IMPACT; event = advance(flow, 100, SALTUS_WATCH_CONTACT)) {
        const long double after = 0.6L * v / (1 + v);
        check_near(saltus_time_periods(event.time) * period, (double)time, 1e-13);
        check_near(-event.velocity_before, (double)v, 1e-12 * (double)v + 1e-14);
        check_near(event.velocity_after, (double)after, 1e-12 * (double)v + 1e-14);
        check_near(saltus_system_restitution(system, 0, (double)v), (double)(0.6L / (1 + v)), 1e-15);
        time += 2 * after / 9.8L;
        v = after;
        impacts++;
    }
    assert_true(impacts > 10);
    assert_int_equal(event.kind, SALTUS_STICK);
    for (; v > 1e-18L; v = 0.6L * v / (1 + v))
        time += 2 * 0.6L * v / (1 + v) / 9.8L;
    check_near(saltus_time_periods(event.time) * period, (double)time, 1e-12);
    saltus_flow_free(flow);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
}

/* Tangent vectors and parameter columns through impacts, against extrapolated differences. */
static void derivatives_are_right(void **unused) {
    (void)unused;
    static const char *const texts[] = {oscillator, masses};
    for (int k = 0; k < 2; k++) {
        saltus_scene scene = scene_of_text(texts[k]);
        saltus_message message = {.text = ""};
        saltus_system *system = build(&scene.spec);
        saltus_column_check checks[SALTUS_COLUMN_CHECKS_MAX];
        double state[SALTUS_STATE_MAX];
        bool of_law = false;
        int count;
        check_ok(saltus_scene_state(&scene, system, state, &message), &message);
        check_ok(saltus_columns_check(system, state, NULL, checks, &count, &message), &message);
        for (int c = 0; c < count; c++) {
            if (!(checks[c].difference < 1e-8))
                fail_msg("%s: %.3g", checks[c].name, checks[c].difference);
            of_law |= strcmp(checks[c].name, "s0") == 0;
        }
        assert_true(of_law);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

/* The determinant of an impact's derivative is r d(r v)/dv: multipliers, exponents and impacts agree. */
static void sums_agree(void **unused) {
    (void)unused;
    static const char *const texts[] = {oscillator, masses};
    for (int k = 0; k < 2; k++) {
        saltus_scene scene = scene_of_text(texts[k]);
        saltus_message message = {.text = ""};
        saltus_classify_options options = saltus_classify_defaults();
        saltus_system *system = build(&scene.spec);
        saltus_motion motion;
        double state[SALTUS_STATE_MAX];
        check_ok(saltus_scene_state(&scene, system, state, &message), &message);
        check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
        if (motion.multiplier_count)
            check_near(motion.log_volume, motion.sum_rule, 1e-9 * (1 + fabs(motion.sum_rule)));
        saltus_lyapunov_options how = saltus_lyapunov_defaults();
        saltus_lyapunov exponents;
        how.exponents = saltus_system_dimension(system);
        how.periods = 2000;
        check_ok(saltus_lyapunov_run(system, state, &how, &exponents, &message), &message);
        check_near(exponents.sum, exponents.sum_rule, 1e-6 * (1 + fabs(exponents.sum)));
        saltus_lyapunov_clear(&exponents);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

/* A restitution without meaning ends the motion with a message: r above 1, or a lasting contact where r tends
 * to 1. */
static void laws_have_limits(void **unused) {
    (void)unused;
    static const struct {
        const char *r, *words;
    } cases[] = {{"0.5 + speed", "the restitution of stop 1 is 4.92"},
                 {"0.5 - speed", "the restitution of stop 1 is -3.92"},
                 {"1/(1 + speed)", "tends to 1 for small closing speeds"}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char text[300];
        snprintf(text, sizeof text,
                 "model: {parameters: {g: 9.8}, motion: {x: \"-g\"}}\n"
                 "stop: {coordinate: x, d: 0, r: \"%s\", sides: lower}\ninitial: {x: 1, x': 0}\n",
                 cases[k].r);
        saltus_scene scene = scene_of_text(text);
        saltus_message message = {.text = ""};
        saltus_system *system = build(&scene.spec);
        saltus_flow_options options = saltus_flow_defaults();
        saltus_flow *flow = open_flow(system, &options, 0, (const double[2]){1, 0});
        saltus_event event = {.kind = SALTUS_IMPACT};
        saltus_status status = SALTUS_OK;
        options.rtol = 1e-6;
        while (status == SALTUS_OK && event.kind == SALTUS_IMPACT)
            status =
                saltus_flow_advance(flow, (saltus_time){1000, 0}, SALTUS_WATCH_CONTACT, &event, &message);
        assert_int_equal(status, SALTUS_STALLED);
        if (!strstr(message.text, cases[k].words))
            fail_msg("\"%s\" does not say \"%s\"", message.text, cases[k].words);
        saltus_flow_free(flow);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ball),
        cmocka_unit_test(derivatives_are_right),
        cmocka_unit_test(sums_agree),
        cmocka_unit_test(laws_have_limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
