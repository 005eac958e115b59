/* Exponents of linear systems are the real parts of their eigenvalues, however fast perturbations decay and
 * however far apart their rates, in any unit of time and at any interval.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

static saltus_lyapunov measure(const saltus_system *system, int exponents, double interval, int members) {
    saltus_lyapunov_options options = saltus_lyapunov_defaults();
    saltus_message message = {.text = ""};
    saltus_lyapunov l;
    double rest[4] = {0};
    options.members = members;
    options.exponents = exponents;
    options.interval = interval;
    options.transient = 0;
    options.periods = (long long)(250 * fmax(1, interval)) * members;
    check_ok(saltus_lyapunov_run(system, rest, &options, &l, &message), &message);
    return l;
}

/* A second mass nearly on a wall: the first mass is 1e6 times as heavy. The wall moves with the rate -0.01
 * twice; the second mass decays with both rates of s^2 + c s + 1. */
static saltus_system *mass_on_a_wall(double c, double period) {
    saltus_spec spec = oscillator_spec(0.02e6, 1e6, 0, 2 * M_PI / period);
    set_parameter(&spec, "N", 2);
    set_parameter(&spec, "m", 1e6);
    set_parameter(&spec, "m2", 1);
    set_parameter(&spec, "c2", c);
    set_parameter(&spec, "k2", 1);
    return build(&spec);
}

/* Within one forcing period a perturbation shrinks by e^-300 to e^-1500. */
static void what_fades_beyond_numbers_is_measured(void **unused) {
    (void)unused;
    static const double periods[] = {320, 480, 1600};
    for (int k = 0; k < 3; k++) {
        saltus_spec spec = oscillator_spec(1.9, 1, 0.5, 2 * M_PI / periods[k]);
        saltus_system *system = build(&spec);
        saltus_lyapunov l = measure(system, 1, 0, 1);
        check_near(l.exponents[0], -0.95, 4 * l.standard_errors[0] + 1e-7);
        assert_true(l.standard_errors[0] < 1e-4 && l.precise && l.lost == 0);
        saltus_lyapunov_clear(&l);
        saltus_system_free(system);
    }
}

/* The last requested direction decays e^100 times as fast as the first; none is lost. */
static void rates_far_apart_are_told_apart(void **unused) {
    (void)unused;
    double c = 2.2, root = sqrt(c * c / 4 - 1);
    const double expected[] = {-0.01, -0.01, root - c / 2, -root - c / 2};
    saltus_system *system = mass_on_a_wall(c, 180);
    for (int count = 1; count <= 4; count++) {
        saltus_lyapunov l = measure(system, count, 0, 1);
        for (int i = 0; i < count; i++)
            check_near(l.exponents[i], expected[i], 4 * l.standard_errors[i] + 2e-6);
        assert_true(l.standard_errors[count - 1] < 1e-4 && l.precise);
        saltus_lyapunov_clear(&l);
    }
    saltus_system_free(system);
}

/* Sampling intervals of several periods, one, or parts of one: time is given in periods, growth per unit of
 * time. */
static void intervals_do_not_matter(void **unused) {
    (void)unused;
    static const double intervals[] = {1, 2, 3, 7, 0.5, 0.25};
    double c = 0.6;
    saltus_system *system = mass_on_a_wall(c, 2);
    for (int k = 0; k < 6; k++) {
        int whole = (int)fmax(1, intervals[k]);
        saltus_lyapunov l = measure(system, 0, intervals[k], 3);
        for (int i = 0; i < 4; i++)
            check_near(l.exponents[i], i < 2 ? -0.01 : -c / 2, 4 * l.standard_errors[i] + 2e-6);
        assert_int_equal(l.periods % (3 * whole), 0);
        assert_true(l.periods <= 250 * 3 * whole && l.periods >= 200 * 3 * whole);
        assert_int_equal(l.transient % whole, 0);
        check_near(l.time, (double)l.periods * 2, 1e-9 * l.time);
        check_near(l.sum, -0.02 - c - c / 1e6, 1e-9);
        check_near(l.sum_rule, l.sum, 1e-9);
        saltus_lyapunov_clear(&l);
    }
    saltus_system_free(system);
}

/* With damping that depends on time and state, and impacts, both sides of the sum rule agree, for an orbit
 * and for exponents. */
static void volumes_shrink_as_the_trace_says(void **unused) {
    (void)unused;
    static const char text[] =
        "model:\n"
        "  parameters: {c: 0.1, F: 0.8, omega: 1.1}\n"
        "  motion:\n"
        "    x: \"-x - c*(1 + 0.7*sin(omega*t) + 0.4*cos(3*omega*t) + z^2)*x' + F*cos(omega*t)\"\n"
        "  states: {z: \"x - (0.8 + 0.6*sin(omega*t))*z\"}\n"
        "  forcing: omega\n"
        "stop: {coordinate: x, d: 0.3, r: 0.8}\n";
    saltus_scene scene = {.title = ""};
    saltus_message message = {.text = ""};
    saltus_motion motion;
    check_ok(saltus_scene_parse(text, strlen(text), "text", &scene, &message), &message);
    saltus_system *system = build(&scene.spec);
    const saltus_classify_options options = saltus_classify_defaults();
    double state[3] = {0.1, 0, 0};
    check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
    assert_true(motion.verdict == SALTUS_PERIODIC && motion.impacts > 0);
    check_near(motion.log_volume, motion.sum_rule, 1e-12);
    saltus_lyapunov l = measure(system, 0, 0, 1);
    check_near(l.sum, l.sum_rule, 1e-10);
    saltus_lyapunov_clear(&l);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_fades_beyond_numbers_is_measured),
        cmocka_unit_test(rates_far_apart_are_told_apart),
        cmocka_unit_test(intervals_do_not_matter),
        cmocka_unit_test(volumes_shrink_as_the_trace_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
