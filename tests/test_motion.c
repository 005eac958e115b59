/* Classification beyond the reference orbits: rest, permanent contact, symmetry, seeds, undecided motions.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

enum { dimension_max = 20 };

static saltus_motion classify(const saltus_spec *spec, const double *state, long long transient) {
    saltus_system *system = build(spec);
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double start[dimension_max];
    options.transient = transient;
    if (!state)
        check_ok(saltus_system_default_state(system, start, &message), &message);
    check_ok(saltus_classify(system, state ? state : start, &options, &motion, &message), &message);
    saltus_system_free(system);
    return motion;
}

/* N = 1, steady flow: buckled at q = sqrt(2 (u0^2 - pi^2) / (kappa pi^2)), or held by a nearer stop. */
static void buckled_and_held(void **unused) {
    (void)unused;
    double buckled = sqrt(2 * (4.5 * 4.5 - M_PI * M_PI) / (5000 * M_PI * M_PI));
    saltus_spec spec = pipe_spec(1, 42);
    set_parameter(&spec, "sigma", 0);
    saltus_motion motion = classify(&spec, NULL, 20000);
    assert_string_equal(motion.label, "equilibrium");
    check_near(fabs(motion.state[0]), buckled, 1e-12);
    assert_int_equal(motion.mirror, SALTUS_MIRROR_PAIR);
    saltus_motion_clear(&motion);

    add_stop(&spec, 0.02, 0.9, SALTUS_UPPER);
    motion = classify(&spec, NULL, 20000);
    assert_string_equal(motion.label, "held");
    check_near(motion.state[0], 0.02, 1e-17);
    /* Force per modal mass: -(lambda^4 - u^2 lambda^2) q - kappa lambda^4 q^3 / 2. */
    double l2 = M_PI * M_PI, q = 0.02;
    check_near(motion.contact_force[0], -(l2 * l2 - 20.25 * l2) * q - 0.5 * 5000 * l2 * l2 * q * q * q,
               1e-12);
    saltus_motion_clear(&motion);
}

/* A rest is called stable only if it is: the straight pipe above u0 = pi is a saddle, exactly at rest. In
 * contact at the section with one mode, rounding is no velocity: held, not 1/1. */
static void rests_are_tested(void **unused) {
    (void)unused;
    double zero[2] = {0, 0};
    saltus_spec spec = pipe_spec(1, 42);
    set_parameter(&spec, "sigma", 0);
    saltus_motion motion = classify(&spec, zero, 20000);
    assert_string_equal(motion.label, "equilibrium");
    assert_false(motion.stable);
    saltus_motion_clear(&motion);
    motion = classify(&spec, NULL, 20000);
    assert_true(motion.stable);
    saltus_motion_clear(&motion);
    spec = pipe_spec(1, 10);
    add_stop(&spec, 0.005, 0.9, SALTUS_UPPER);
    spec.stops[0].xi = 0.3;
    motion = classify(&spec, NULL, 20000);
    assert_string_equal(motion.label, "held");
    saltus_motion_clear(&motion);
}

/* A rest and its description are what Newton's method finds from the trajectory; as a fixed point of the map
 * over a period it has the same exponent. */
static void a_rest_is_what_newtons_method_finds(void **unused) {
    (void)unused;
    static const double loads[] = {0.4, -0.2, 0.2 + 1e-7};
    for (int k = 0; k < 6; k++) {
        saltus_spec spec = k < 3 ? oscillator_spec(0.3, 1, 0, 1.1) : pipe_spec(2, 42);
        if (k < 3) {
            set_parameter(&spec, "F0", loads[k]);
            add_stop(&spec, 0.2, 0.5, SALTUS_UPPER);
        } else {
            set_parameter(&spec, "sigma", 0);
            set_parameter(&spec, "u0", 2.5 + 0.7 * (k - 3));
        }
        saltus_system *system = build(&spec);
        saltus_classify_options options = saltus_classify_defaults();
        saltus_orbit_options shooting = saltus_orbit_defaults();
        saltus_message message = {.text = ""};
        saltus_equilibrium_options how = saltus_equilibrium_defaults();
        saltus_equilibrium rest;
        saltus_orbit fixed;
        double state[4];
        check_ok(saltus_system_default_state(system, state, &message), &message);
        saltus_motion motion = classify(&spec, state, 20000);
        assert_true(motion.verdict == SALTUS_HELD || motion.verdict == SALTUS_EQUILIBRIUM);
        saltus_flow *flow = open_flow(system, &options.flow, 0, state);
        for (long long p = 1; p <= motion.transient; p++)
            advance(flow, (double)p, 0);
        saltus_flow_state(flow, 0, state);
        check_ok(saltus_equilibrium_find(system, state, &how, &rest, &message), &message);
        for (int i = 0; i < motion.dimension; i++)
            check_near(motion.state[i], rest.state[i], 1e-15);
        assert_int_equal(motion.iterations, rest.iterations);
        assert_true(motion.iterations >= 1 && motion.residual <= how.tolerance);
        check_near(motion.residual, rest.residual, 1e-15);
        shooting.flow = options.flow;
        check_ok(saltus_orbit_find(system, 1, state, &shooting, &fixed, &message), &message);
        for (int i = 0; i < motion.dimension; i++)
            check_near(motion.state[i], fixed.state[i], 1e-9);
        double exponent = fixed.multipliers[0].log_modulus / saltus_system_period(system);
        assert_true(motion.lyapunov == exponent || fabs(motion.lyapunov - exponent) < 1e-9);
        assert_true(motion.lyapunov_error == 0 && motion.stable);
        saltus_equilibrium_clear(&rest);
        saltus_orbit_clear(&fixed);
        saltus_motion_clear(&motion);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

/* The straight pipe is stable below u0 = pi, for any number of modes. */
static void straight_pipe_rests(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(4, 42);
    set_parameter(&spec, "sigma", 0);
    set_parameter(&spec, "u0", 2.5);
    saltus_motion motion = classify(&spec, NULL, 20000);
    assert_string_equal(motion.label, "equilibrium");
    for (int i = 0; i < 8; i++)
        check_near(motion.state[i], 0, 1e-9);
    saltus_motion_clear(&motion);
}

/* Held permanently under a pulsating flow: the stop point does not move, the other modes follow the
 * forcing. */
static void held_under_pulsation(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 42);
    set_parameter(&spec, "sigma", 0.01);
    add_stop(&spec, 0.01, 0.5, SALTUS_UPPER);
    saltus_motion motion = classify(&spec, NULL, 20000);
    assert_string_equal(motion.label, "held");
    assert_int_equal(motion.periods, 1);
    assert_true(motion.contact_force[0] > 0);
    check_near(motion.largest, 0.01, 1e-15);
    check_near(motion.smallest, 0.01, 1e-15);
    saltus_motion_clear(&motion);
}

/* Free response of the forced oscillator: 0/1, its own mirror image under the half-period shift. */
static void free_response(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 1, 0.05, 1.5);
    add_stop(&spec, 1, 0.8, SALTUS_BOTH);
    saltus_motion motion = classify(&spec, NULL, 20000);
    assert_string_equal(motion.label, "0/1");
    assert_int_equal(motion.mirror, SALTUS_MIRROR_SELF);
    double modulus = exp(-0.05 * 2 * M_PI / 1.5);
    check_near(exp(motion.multipliers[0].log_modulus), modulus, 1e-10);
    check_near(motion.largest, 0.05 / hypot(1 - 2.25, 0.15), 1e-12);
    saltus_motion_clear(&motion);
}

/* The product rule on assorted stable orbits with impacts: (sum of log moduli) = <trace> + 2 ln r per impact.
 */
static void product_rule(void **unused) {
    (void)unused;
    static const double rows[][4] = {{42, 0.035, 0.9, 5}, {43, 0.0295, 0.9, 5}, {16, 0.035, 0.9, 5},
                                     {40, 0.035, 0.8, 3}, {20, 0.038, 0.9, 4},  {45, 0.035, 0.9, 7}};
    int periodic = 0;
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_spec spec = pipe_spec(rows[k][3], rows[k][0]);
        add_stop(&spec, rows[k][1], rows[k][2], SALTUS_UPPER);
        saltus_motion motion = classify(&spec, NULL, 5000);
        if (motion.verdict == SALTUS_PERIODIC && !motion.sticks) {
            periodic++;
            check_near(motion.log_volume, motion.sum_rule, 1e-8);
            double sum = 0;
            for (int i = 0; i < motion.multiplier_count; i++)
                sum += motion.multipliers[i].log_modulus;
            check_near(sum, motion.sum_rule, 1e-4 * fabs(motion.sum_rule));
        }
        saltus_motion_clear(&motion);
    }
    assert_true(periodic >= 4);
}

/* d = 0.03, omega = 43: every random initial state goes to one 3/5 orbit; the same seed finds the same. */
static void seeds_are_reproducible(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 43);
    add_stop(&spec, 0.03, 0.9, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_attractors found, again;
    check_ok(saltus_attractors_find(system, 25, 7, &options, &found, &message), &message);
    assert_int_equal(found.count, 1);
    assert_int_equal(found.shares[0], 25);
    assert_string_equal(found.motions[0].label, "3/5");
    check_ok(saltus_attractors_find(system, 25, 7, &options, &again, &message), &message);
    assert_memory_equal(found.motions[0].state, again.motions[0].state, 10 * sizeof(double));
    saltus_attractors_clear(&found);
    saltus_attractors_clear(&again);
    saltus_system_free(system);
}

/* The mirror pair of the two-sided scene: two attractors, images of each other. */
static void mirror_pairs_are_two(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(1, 14);
    add_stop(&spec, 0.035, 0.8, SALTUS_BOTH);
    saltus_system *system = build(&spec);
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_attractors found;
    check_ok(saltus_attractors_find(system, 30, 1, &options, &found, &message), &message);
    assert_int_equal(found.count, 2);
    for (int k = 0; k < 2; k++) {
        assert_string_equal(found.motions[k].label, "2/2");
        assert_int_equal(found.motions[k].mirror, SALTUS_MIRROR_PAIR);
        assert_int_equal(found.motions[k].impacts_by_face[0], 1);
        assert_int_equal(found.motions[k].impacts_by_face[1], 1);
    }
    saltus_attractors_clear(&found);
    saltus_system_free(system);
}

typedef struct caller {
    double seen;
    volatile sig_atomic_t stop;
} caller;

static void stop_at_once(void *context, double periods, double at_most) {
    caller *c = context;
    assert_true(!c->stop && periods < at_most);
    c->seen = periods;
    c->stop = 1;
}

/* No exponent is allowed to be measured, or the caller stops. */
static void chaos_is_undecided(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 10);
    add_stop(&spec, 0.035, 0.9, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    caller once = {.seen = 0};
    double state[dimension_max];
    options.transient = 3000;
    options.measure = 0;
    check_ok(saltus_system_default_state(system, state, &message), &message);
    check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
    assert_string_equal(motion.label, "irregular");
    assert_non_null(strstr(motion.reason, "3000"));
    assert_int_equal(motion.transient, 3000);
    saltus_motion_clear(&motion);

    options = saltus_classify_defaults();
    options.progress = (saltus_progress){stop_at_once, &once};
    options.flow.stop = &once.stop;
    check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
    assert_true(once.seen > 0 && (double)motion.transient == once.seen);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(buckled_and_held),     cmocka_unit_test(straight_pipe_rests),
        cmocka_unit_test(rests_are_tested),     cmocka_unit_test(a_rest_is_what_newtons_method_finds),
        cmocka_unit_test(held_under_pulsation), cmocka_unit_test(free_response),
        cmocka_unit_test(product_rule),         cmocka_unit_test(seeds_are_reproducible),
        cmocka_unit_test(mirror_pairs_are_two), cmocka_unit_test(chaos_is_undecided),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
