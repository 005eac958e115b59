/* Stable orbits among motions that look chaotic: one that may be their end rules out asserting chaos, one
 * that merely lies beside them does not. Oscillators x'' + c x' + x = cos(omega t) below a stop at d.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "closed_orbits.h"

#include "flow/effort.h"
#include "motion/motion.h"

typedef struct struck {
    double c, omega, d, r;
    const char *orbit;
} struck;

static saltus_system *build_struck(const struck *s) {
    saltus_spec spec = oscillator_spec(s->c, 1, 1, s->omega);
    add_stop(&spec, s->d, s->r, SALTUS_UPPER);
    return build(&spec);
}

static saltus_motion classify_struck(const saltus_system *system, double x, long long transient,
                                     long long measure) {
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double start[2] = {x, 0.1};
    options.transient = transient;
    options.measure = measure;
    options.lifetime = options.measure / 24;
    check_ok(saltus_classify(system, start, &options, &motion, &message), &message);
    return motion;
}

/* Whether some trajectory settles on a stable orbit with that label. */
static bool is_attractor(const saltus_system *system, const char *label) {
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_attractors found;
    bool seen = false;
    options.transient = 500;
    options.measure = 0;
    check_ok(saltus_attractors_find(system, 12, 5, &options, &found, &message), &message);
    for (int k = 0; k < found.count; k++)
        seen |= found.motions[k].stable && strcmp(found.motions[k].label, label) == 0;
    saltus_attractors_clear(&found);
    return seen;
}

/* One impact in one period, in closed form. */
static bool is_stable_in_closed_form(const struck *s) {
    closed_oscillator o = {.c = s->c, .k = 1, .F = 1, .omega = s->omega, .d = s->d, .r = s->r, .periods = 1};
    closed_orbit orbit;
    return closed_orbit_at(&o, 1, &orbit) && orbit.admissible &&
           hypotl(orbit.multiplier[0][0], orbit.multiplier[0][1]) < 1;
}

/* The largest exponents are positive, over some 1e4 periods and in both halves, and yet chaos is not
 * asserted. */
static void a_stable_orbit_among_chaos_counts(void **unused) {
    (void)unused;
    static const struct struck scenes[] = {{0, 2.432, 0.07, 0.89, "1/1"},
                                           {0, 3.087, 0, 0.84, "2/2"},
                                           {0, 1.692, 0, 0.98, "1/1"},
                                           {0, 3.101, 0, 0.95, "2/2"},
                                           {0, 2.738, 0.04, 0.98, "5/6"}};
    for (int k = 0; k < 5; k++) {
        saltus_system *system = build_struck(&scenes[k]);
        saltus_motion m = classify_struck(system, scenes[k].d - 0.3, 700, 8000);
        const saltus_evidence *e = &m.evidence;
        char told[128];
        assert_int_equal(m.verdict, SALTUS_TRANSIENT);
        assert_string_equal(m.label, "transient");
        assert_string_equal(e->stable_orbit, scenes[k].orbit);
        assert_true(m.lyapunov > 3 * m.lyapunov_error && e->left == 0 && e->left_for[0] == 0);
        for (int half = 0; half < 2; half++)
            assert_true(e->half[half] > 2 * e->half_errors[half]);
        /* The message has the given numbers. */
        snprintf(told, sizeof told, "exponent %.4g +- %.1g per unit of time while it lasts", m.lyapunov,
                 m.lyapunov_error);
        assert_non_null(strstr(m.reason, told));
        assert_non_null(strstr(m.reason, e->stable_orbit));
        check_near(e->lifetime_at_least, (double)e->periods / 3, 0.01 * (double)e->periods);
        assert_true(isnan(e->lifetime));
        if (k == 0)
            assert_true(is_stable_in_closed_form(&scenes[k]));
        else
            assert_true(is_attractor(system, e->stable_orbit));
        saltus_motion_clear(&m);
        saltus_system_free(system);
    }
}

/* The stable orbit exists, within reach of Newton's method, but the motion avoids its basin. */
static void a_stable_orbit_beside_chaos_does_not_count(void **unused) {
    (void)unused;
    static const struct struck scenes[] = {{0, 2.591, 0.01, 0.83, "1/1"},
                                           {0, 3.007, 0, 0.92, "2/2"},
                                           {0, 3.02, 0, 0.9, "2/2"},
                                           {0.044, 2.702, 0, 0.84, "2/2"}};
    for (int k = 0; k < 4; k++) {
        saltus_system *system = build_struck(&scenes[k]);
        saltus_motion m = classify_struck(system, scenes[k].d - 0.3, 700, 8000);
        assert_string_not_equal(m.evidence.stable_orbit, scenes[k].orbit);
        assert_int_equal(m.evidence.left, 0);
        /* Amid the first scene's motion another stable orbit is found. */
        assert_int_equal(m.verdict, k ? SALTUS_CHAOTIC : SALTUS_TRANSIENT);
        assert_true((m.evidence.stable_orbit[0] == 0) == (k > 0));
        if (k == 0)
            assert_true(is_stable_in_closed_form(&scenes[k]));
        assert_true(is_attractor(system, scenes[k].orbit));
        saltus_motion_clear(&m);
        saltus_system_free(system);
    }
}

/* Chaos that ends soon: a trajectory that has left it is reported, with the orbit that all reach. */
static void those_who_leave_name_their_end(void **unused) {
    (void)unused;
    static const struct struck scenes[] = {{0, 2.693, 0, 0.98, "2/2"}, {0, 3.143, 0, 0.95, "2/2"}};
    for (int k = 0; k < 2; k++) {
        saltus_system *system = build_struck(&scenes[k]);
        saltus_motion m = classify_struck(system, -0.3, 700, 8000);
        const saltus_evidence *e = &m.evidence;
        char told[64], mean[64];
        assert_int_equal(m.verdict, SALTUS_TRANSIENT);
        assert_string_equal(m.label, "transient");
        assert_string_equal(e->left_for, scenes[k].orbit);
        assert_true(e->left >= 1 && e->left <= e->members && e->members == 8 && m.lyapunov > 0);
        snprintf(told, sizeof told, "exponent %.4g +- %.1g per unit", m.lyapunov, m.lyapunov_error);
        snprintf(mean, sizeof mean, "after %.2g periods in the mean", e->lifetime);
        assert_non_null(strstr(m.reason, told));
        assert_non_null(strstr(m.reason, mean));
        assert_true(e->lifetime_at_least < e->lifetime && e->lifetime * e->left <= 8000);
        assert_non_null(strstr(m.reason, scenes[k].orbit));
        /* The reported time includes all of it. */
        assert_int_equal(m.transient, 700);
        saltus_motion_clear(&m);
        m = classify_struck(system, -0.3, 40000, 0);
        assert_true(m.stable && m.transient > 700);
        assert_string_equal(m.label, scenes[k].orbit);
        saltus_motion_clear(&m);
        saltus_system_free(system);
    }
}

/* In 16 dimensions without damping close returns lead to hardly any orbit: the search for a stable one is
 * given up, long before the steps (each once for every column, all of them counted) that all returns would
 * take. */
static void a_hopeless_search_is_given_up(void **unused) {
    enum { points = 4000 };
    (void)unused;
    saltus_spec spec = pipe_spec(8, 42);
    saltus_message message = {.text = ""};
    saltus_effort effort = {.period = 1e300};
    saltus_flow_options options = saltus_flow_defaults();
    saltus_motion motion;
    set_parameter(&spec, "alpha", 0);
    add_stop(&spec, 0.035, 0.9, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    const int n = saltus_system_dimension(system);
    double *states = calloc((size_t)((points + 1) * n), sizeof *states),
           *growths = calloc(points, sizeof *growths);
    assert_non_null(states);
    assert_non_null(growths);
    states[0] = 0.01;
    check_ok(saltus_motion_settle(system, &options, 500, states, &message), &message);
    for (int k = 1; k < points; k++) {
        memcpy(states + k * n, states + (k - 1) * n, (size_t)n * sizeof *states);
        check_ok(saltus_motion_settle(system, &options, 1, states + k * n, &message), &message);
    }
    const saltus_track track = {states, growths, points};
    options.effort = &effort;
    check_ok(saltus_stable_orbit_among(system, &options, &track, 1, &motion, &message), &message);
    assert_int_equal(motion.verdict, SALTUS_PENDING);
    assert_true(effort.spent > 0 && effort.spent < 0.3 * SALTUS_EFFORT_MOST);
    free(states);
    free(growths);
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stable_orbit_among_chaos_counts),
        cmocka_unit_test(a_stable_orbit_beside_chaos_does_not_count),
        cmocka_unit_test(those_who_leave_name_their_end),
        cmocka_unit_test(a_hopeless_search_is_given_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
