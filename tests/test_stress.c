/* Numerical stability under stress: scenes at the limits of what is allowed (stress_rows.h) keep the
 * invariants of stress_watch.h and stress_compare.h; long runs keep energy and phase; starts on a stop go
 * where the forces point. SALTUS_LONG_TESTS=1 adds rows and makes runs longer, SALTUS_SANITIZED=1 makes them
 * shorter.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "stress_rows.h"

/* The factor by which runs are shorter or longer. */
static double extent(void) {
    return getenv("SALTUS_SANITIZED") ? 0.2 : long_version() ? 10 : 1;
}

static void make_case(const stress_row *row, stress_case *c) {
    memset(c, 0, sizeof *c);
    c->options = saltus_flow_defaults();
    row->make(c, row->x);
}

static void check_watched(const stress_row *row, const stress_case *c) {
    stress_watch w;
    check_ok(stress_watch_open(&w, &c->spec, &c->options, c->phase, c->state), &w.message);
    check_ok(stress_watch_run(&w, c->phase + c->periods * extent(), 0), &w.message);
    saltus_flow_info info = saltus_flow_information(w.flow, 0);
    print_message("%-34s %8lld steps %7lld impacts %5lld sticks:", row->name, info.steps, info.impacts,
                  info.sticks);
    for (int k = 0; k < stress_invariants; k++)
        print_message(" %s %.2g", stress_names[k], w.worst[k]);
    print_message("\n");
    for (int k = 0; k < stress_invariants; k++)
        if (!(w.worst[k] <= 1))
            fail_msg("%s: %s is violated by a factor %.3g at %.17g periods", row->name, stress_names[k],
                     w.worst[k], w.when[k]);
    stress_watch_close(&w);
}

static void rows_under_watch(void **unused) {
    (void)unused;
    for (size_t k = 0; k < sizeof stress_rows / sizeof stress_rows[0]; k++) {
        stress_case c;
        if (stress_rows[k].applies & stress_longer && !long_version())
            continue;
        make_case(&stress_rows[k], &c);
        check_watched(&stress_rows[k], &c);
    }
}

static void sum_rule(void **unused) {
    (void)unused;
    long long all = 0, impacts;
    for (size_t k = 0; k < sizeof stress_rows / sizeof stress_rows[0]; k++) {
        stress_case c;
        if (!(stress_rows[k].applies & stress_sum))
            continue;
        make_case(&stress_rows[k], &c);
        double off = stress_sum_rule(&c, (int)(300 * extent()), &impacts);
        all += impacts;
        if (!(off <= 1))
            fail_msg("%s: a step's volume is off by %.3g times what it may", stress_rows[k].name, off);
    }
    assert_true((double)all > 1000 * extent());
}

static void mirror_images(void **unused) {
    (void)unused;
    for (size_t k = 0; k < sizeof stress_rows / sizeof stress_rows[0]; k++) {
        stress_case c;
        if (!(stress_rows[k].applies & stress_mirror) ||
            (stress_rows[k].applies & stress_longer && !long_version()))
            continue;
        make_case(&stress_rows[k], &c);
        c.periods *= extent();
        double off = stress_asymmetry(&c);
        if (!(off == 0))
            fail_msg("%s: the mirror image is off by %.3g", stress_rows[k].name, off);
    }
}

static void independence(void **unused) {
    (void)unused;
    for (size_t k = 0; k < sizeof stress_rows / sizeof stress_rows[0]; k++) {
        stress_case c;
        if (!(stress_rows[k].applies & stress_independent))
            continue;
        make_case(&stress_rows[k], &c);
        double off = stress_dependence(&c);
        if (!(off <= 20))
            fail_msg("%s: other tolerances, orders or integrators differ by %.3g of what they may",
                     stress_rows[k].name, off);
    }
}

/* With r = 1, no damping, no force and two stops, the energy is the same after a hundred thousand impacts, or
 * ten million. */
static void energy_is_kept(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 1, 0, 1);
    add_stop(&spec, 0.3, 1, SALTUS_BOTH);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = 1e-15;
    double state[2] = {0.1, 1.0}, energy = 0.5 * (0.01 + 1.0);
    long long impacts = (long long)((long_version() ? 1e6 : 1e5) * extent());
    saltus_flow *flow = open_flow(system, &options, 0, state);
    for (double p = 0; saltus_flow_information(flow, 0).impacts < impacts;)
        advance(flow, p += 1000, 0);
    saltus_flow_state(flow, 0, state);
    double off = 0.5 * (state[0] * state[0] + state[1] * state[1]) / energy - 1;
    print_message("%lld impacts without loss: energy off by %.3g\n", saltus_flow_information(flow, 0).impacts,
                  off);
    check_near(off, 0, 1e-10);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* A one-sided impact oscillator settles on an orbit with one impact per period, whose speed V and phase
 * follow from its linear flight in closed form: after a hundred thousand periods the section is still at
 * phase 0, and a period still returns the state to itself. */
static void section_does_not_drift(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.2, 1, 1, 2.6);
    add_stop(&spec, 0, 0.8, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    double early[2], late[2], state[2] = {-0.1, 0};
    long long periods = (long long)((long_version() ? 1e6 : 1e5) * extent()), settled = 2000;
    saltus_flow *flow = open_flow(system, &options, 0, state);
    advance(flow, (double)settled, 0);
    saltus_flow_state(flow, 0, early);
    long long impacts = saltus_flow_information(flow, 0).impacts;
    for (long long p = settled + 1; p <= periods; p++) {
        advance(flow, (double)p, 0);
        assert_true(saltus_flow_time(flow, 0).phase == 0 && saltus_flow_time(flow, 0).cycle == p);
    }
    saltus_flow_state(flow, 0, late);
    impacts = saltus_flow_information(flow, 0).impacts - impacts;
    print_message("%lld periods, %lld impacts: section point moved by %.3g, %.3g\n", periods, impacts,
                  late[0] - early[0], late[1] - early[1]);
    assert_true(impacts % (periods - settled) == 0 && impacts > 0);
    check_near(late[0], early[0], 1e-12);
    check_near(late[1], early[1], 1e-12);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* A ball on the floor, restitution close to 1: the bounces end at v / g (1 + 2 r / (1 - r)), with as many as
 * it takes to fall below the tolerance. */
static void long_chatter(void **unused) {
    (void)unused;
    const double r = 0.999, height = 0.5, speed = sqrt(2 * height);
    stress_case c;
    memset(&c, 0, sizeof c);
    c.options = saltus_flow_defaults();
    row_ball(&c, r);
    saltus_system *system = build(&c.spec);
    saltus_flow *flow = open_flow(system, &c.options, 0, c.state);
    saltus_event event = {.kind = SALTUS_STEP};
    while (event.kind != SALTUS_STICK)
        event = advance(flow, 1000, SALTUS_WATCH_STICK);
    double rest = saltus_time_periods(event.time) * saltus_system_period(system);
    assert_true(saltus_flow_information(flow, 0).impacts > 10000);
    check_near(rest, speed + 2 * speed * r / (1 - r), 1e-9 * rest);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* r = 0 under pressure: each impact sticks at once, and releases when the force vanishes. */
static void no_rebound_sticks_at_once(void **unused) {
    (void)unused;
    stress_case c;
    memset(&c, 0, sizeof c);
    c.options = saltus_flow_defaults();
    row_restitution(&c, 0);
    saltus_system *system = build(&c.spec);
    saltus_flow *flow = open_flow(system, &c.options, 0, c.state);
    double state[10], forces[SALTUS_FACES_MAX];
    saltus_event event = {.kind = SALTUS_STEP};
    int sticks = 0;
    while (event.kind != SALTUS_REACHED) {
        event = advance(flow, 20, SALTUS_WATCH_CONTACT);
        saltus_flow_forces(flow, 0, forces);
        saltus_flow_state(flow, 0, state);
        if (event.kind != SALTUS_STICK && event.kind != SALTUS_IMPACT)
            continue;
        assert_true(event.velocity_after == 0);
        check_near(saltus_system_gap(system, 0, state), 0, 1e-17);
        assert_true((event.kind == SALTUS_STICK) == (saltus_flow_contacts(flow, 0) == 1) && forces[0] >= 0);
        sticks += event.kind == SALTUS_STICK;
    }
    assert_true(sticks > 5);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Where a start on the stop with zero speed must go: `derivative` is the order of the gap's first derivative
 * that is not zero (2: acceleration, 3: its rate, 4), `sign` its sign. */
static void start_on_stop(int derivative, int sign) {
    saltus_spec spec = oscillator_spec(0, 0, derivative == 2 ? 0 : 1, 1);
    double phase = 0;
    add_stop(&spec, 0.2, 0.5, SALTUS_UPPER);
    if (derivative == 2)
        set_parameter(&spec, "F0", sign * 1e-3);
    else if (derivative == 3)
        phase = sign > 0 ? 0.75 : 0.25;
    else
        set_parameter(&spec, "F0", sign > 0 ? 1 : -1);
    if (derivative == 4)
        phase = sign > 0 ? 0.5 : 0;
    saltus_flow_options options = saltus_flow_defaults();
    double state[2] = {0.2, 0};
    stress_watch w;
    check_ok(stress_watch_open(&w, &spec, &options, phase, state), &w.message);
    if ((saltus_flow_contacts(w.flow, 0) == 1) != (sign > 0))
        fail_msg("derivative %d of sign %d: contacts %u", derivative, sign, saltus_flow_contacts(w.flow, 0));
    check_ok(stress_watch_run(&w, phase + 2, 0), &w.message);
    for (int k = 0; k < stress_invariants; k++)
        assert_true(w.worst[k] <= 1);
    stress_watch_close(&w);
}

static void starts_on_a_stop(void **unused) {
    (void)unused;
    for (int derivative = 2; derivative <= 4; derivative++)
        for (int sign = -1; sign <= 1; sign += 2)
            start_on_stop(derivative, sign);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_under_watch), cmocka_unit_test(sum_rule),
        cmocka_unit_test(mirror_images),    cmocka_unit_test(independence),
        cmocka_unit_test(energy_is_kept),   cmocka_unit_test(section_does_not_drift),
        cmocka_unit_test(long_chatter),     cmocka_unit_test(no_rebound_sticks_at_once),
        cmocka_unit_test(starts_on_a_stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
