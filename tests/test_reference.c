/* The flow, shooting and classification against orbits computed in 128-bit arithmetic by other means.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "reference.h"

/* The default initial states of the first four settle on these orbits. */
static const char *const names[] = {"fig7d", "fig7b", "sdof14", "chatter25", "free5", "two-sided", "modes20"};
enum { name_count = 7, by_default_count = 4 };

/* Once around the orbit from each of its section points. */
static void flow_closes(void **unused) {
    (void)unused;
    for (int f = 0; f < name_count; f++) {
        reference r = read_reference(names[f]);
        saltus_system *system = build(&r.spec);
        saltus_flow_options options = saltus_flow_defaults();
        double state[reference_dimension];
        saltus_flow *flow = open_flow(system, &options, 0, r.states[0]);
        for (int p = 0; p < r.periods; p++) {
            advance(flow, p + 1, 0);
            saltus_flow_state(flow, 0, state);
            check_near(reference_distance(&r, state, (p + 1) % r.periods), 0, 1e-14);
        }
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

static void flow_events(void **unused) {
    (void)unused;
    for (int f = 0; f < name_count; f++) {
        reference r = read_reference(names[f]);
        saltus_system *system = build(&r.spec);
        saltus_flow_options options = saltus_flow_defaults();
        saltus_flow *flow = open_flow(system, &options, 0, r.states[0]);
        for (int k = 0; k < r.event_count; k++) {
            saltus_event event = advance(flow, r.periods, SALTUS_WATCH_CONTACT);
            if (r.kind[k] == 's') /* the file lists the first impacts of the chatter only */
                while (event.kind == SALTUS_IMPACT)
                    event = advance(flow, r.periods, SALTUS_WATCH_CONTACT);
            assert_int_equal(event.kind, r.kind[k] == 'i'   ? SALTUS_IMPACT
                                         : r.kind[k] == 's' ? SALTUS_STICK
                                                            : SALTUS_RELEASE);
            check_near(saltus_time_periods(event.time), r.time[k], 1e-12);
            if (r.kind[k] == 'i')
                check_near(event.velocity_before, r.speed[k], 1e-12);
        }
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

/* Newton's method from a disturbed state converges quadratically to the reference, with its monodromy and
 * multipliers. */
static void shooting_converges(void **unused) {
    (void)unused;
    for (int f = 0; f < name_count; f++) {
        reference r = read_reference(names[f]);
        saltus_system *system = build(&r.spec);
        saltus_orbit_options options = saltus_orbit_defaults();
        saltus_message message = {.text = ""};
        saltus_orbit orbit;
        double guess[reference_dimension];
        for (int i = 0; i < r.n; i++)
            guess[i] = r.states[0][i] * (1 + (i % 2 ? -1e-3 : 1e-3));
        check_ok(saltus_orbit_find(system, r.periods, guess, &options, &orbit, &message), &message);
        assert_in_range(orbit.iterations, 1, 8);
        check_near(reference_distance(&r, orbit.state, 0), 0, 1e-14);
        for (int k = 0; k < r.multiplier_count; k++) {
            double modulus = hypot(r.multipliers[k][0], r.multipliers[k][1]);
            check_near(orbit.multipliers[k].re, r.multipliers[k][0], 1e-9 * modulus);
            check_near(fabs(orbit.multipliers[k].im), fabs(r.multipliers[k][1]), 1e-9 * modulus);
        }
        double largest = 0;
        for (int i = 0; i < r.n * r.n; i++)
            largest = fmax(largest, fabs(r.monodromy[i / r.n][i % r.n]));
        for (int i = 0; i < r.n; i++)
            for (int j = 0; j < r.n; j++)
                check_near(orbit.monodromy[i * r.n + j], r.monodromy[i][j], 1e-9 * largest);
        /* With twenty modes some multipliers are below the range of doubles. */
        if (orbit.sum_rule < -1e5)
            assert_true(isnan(orbit.log_volume));
        else if (r.sticking == 0)
            check_near(orbit.log_volume, orbit.sum_rule, 1e-9);
        else
            for (int k = 0; k < 2; k++)
                assert_true(orbit.multipliers[r.n - 1 - k].re == 0 && orbit.multipliers[r.n - 1 - k].im == 0);
        saltus_orbit_clear(&orbit);
        saltus_system_free(system);
    }
}

/* From the default initial state to the same orbit (or, for the mirror pair, its image). */
static void classification_agrees(void **unused) {
    (void)unused;
    for (int f = 0; f < by_default_count; f++) {
        reference r = read_reference(names[f]);
        saltus_system *system = build(&r.spec);
        saltus_classify_options options = saltus_classify_defaults();
        saltus_message message = {.text = ""};
        saltus_motion motion;
        double start[reference_dimension], closest = INFINITY;
        check_ok(saltus_system_default_state(system, start, &message), &message);
        check_ok(saltus_classify(system, start, &options, &motion, &message), &message);
        assert_string_equal(motion.label, r.label);
        assert_int_equal(motion.periods, r.periods);
        assert_int_equal(motion.sticking_intervals, r.sticking);
        assert_true(motion.stable);
        for (int p = 0; p < r.periods; p++)
            for (int sign = 1; sign >= (motion.mirror == SALTUS_MIRROR_PAIR ? -1 : 1); sign -= 2) {
                double image[reference_dimension];
                for (int i = 0; i < r.n; i++)
                    image[i] = sign * motion.state[i];
                closest = fmin(closest, reference_distance(&r, image, p));
            }
        check_near(closest, 0, 1e-14);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

/* The tolerance is effective: the error after one orbit falls with it and stays below a hundred times it. */
static void tolerance_is_kept(void **unused) {
    (void)unused;
    for (int f = 0; f < name_count; f++) {
        reference r = read_reference(names[f]);
        saltus_system *system = build(&r.spec);
        for (int digits = 4; digits <= 13; digits++) {
            saltus_flow_options options = saltus_flow_defaults();
            options.rtol = pow(10, -digits);
            options.atol = 1e-3 * options.rtol;
            double state[reference_dimension];
            saltus_flow *flow = open_flow(system, &options, 0, r.states[0]);
            advance(flow, r.periods, 0);
            saltus_flow_state(flow, 0, state);
            check_near(reference_distance(&r, state, 0), 0, 1e-15 + 3 * options.rtol);
            saltus_flow_free(flow);
        }
        saltus_system_free(system);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flow_closes),        cmocka_unit_test(flow_events),
        cmocka_unit_test(shooting_converges), cmocka_unit_test(classification_agrees),
        cmocka_unit_test(tolerance_is_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
