/* Impacts, chatter, sticking and release, checked by invariants, without stored numbers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "system/system.h"

#include <float.h>

enum { dimension_max = 20 };

/* In every step: no gap passes its stop by more than rounding, no held contact pulls. */
static void watch_run(const saltus_system *system, saltus_flow *flow, double periods) {
    double state[dimension_max], forces[SALTUS_FACES_MAX];
    for (;;) {
        saltus_event event = advance(flow, periods, SALTUS_WATCH_STEP | SALTUS_WATCH_CONTACT);
        saltus_flow_state(flow, 0, state);
        for (int f = 0; f < saltus_system_face_count(system); f++) {
            double gap = saltus_system_gap(system, f, state);
            assert_true(gap <= 1e-14);
            if (saltus_flow_contacts(flow, 0) >> f & 1)
                check_near(gap, 0, 3e-17);
        }
        saltus_flow_forces(flow, 0, forces);
        for (int f = 0; f < saltus_system_face_count(system); f++)
            assert_true(forces[f] >= -1e-9);
        if (event.kind == SALTUS_REACHED)
            return;
    }
}

static void stops_are_never_passed(void **unused) {
    (void)unused;
    static const double rows[][4] = {
        {10, 0.025, 0.9, SALTUS_UPPER}, {10, 0.02, 0.5, SALTUS_UPPER},  {20, 0.01, 0, SALTUS_UPPER},
        {38, 0.03, 0.9, SALTUS_UPPER},  {42, 0.035, 0.7, SALTUS_BOTH},  {10, 0.02, 0.99, SALTUS_LOWER},
        {14, 0.03, 1, SALTUS_BOTH},     {30, -0.01, 0.8, SALTUS_UPPER}, {12, 0, 0.6, SALTUS_UPPER}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_spec spec = pipe_spec(5, rows[k][0]);
        add_stop(&spec, rows[k][1], rows[k][2], (saltus_sides)rows[k][3]);
        saltus_system *system = build(&spec);
        saltus_flow_options options = saltus_flow_defaults();
        saltus_message message = {.text = ""};
        double state[dimension_max];
        check_ok(saltus_system_default_state(system, state, &message), &message);
        saltus_flow *flow = open_flow(system, &options, 0, state);
        watch_run(system, flow, 150);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

/* Several stops at different places, hit in any order and held together. */
static void several_stops(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(6, 10);
    add_stop(&spec, 0.015, 0.6, SALTUS_UPPER);
    add_stop(&spec, 0.012, 0.4, SALTUS_BOTH);
    add_stop(&spec, 0.012, 0, SALTUS_UPPER);
    spec.stops[1].xi = 0.3;
    spec.stops[2].xi = 0.7;
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    double state[dimension_max];
    unsigned together = 0;
    check_ok(saltus_system_default_state(system, state, &message), &message);
    saltus_flow *flow = open_flow(system, &options, 0, state);
    for (int p = 1; p <= 60; p++) {
        watch_run(system, flow, p);
        unsigned contacts = saltus_flow_contacts(flow, 0);
        together |= (contacts & (contacts - 1)) != 0;
    }
    saltus_flow_info info = saltus_flow_information(flow, 0);
    assert_true(info.impacts > 100 && info.sticks > 10 && info.releases > 5);
    (void)together;
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Two coupled stops: an impact at one changes the rate at which the other closes, and one may recede while
 * the other is hit. No stop is passed, nothing stalls. */
static void coupled_stops(void **unused) {
    (void)unused;
    static const double rows[][5] = {/* N, omega, d, r, sides */
                                     {5, 10, 0.014, 0.9, SALTUS_UPPER}, {4, 10, 0.013, 0.9, SALTUS_UPPER},
                                     {5, 10, 0.012, 0.5, SALTUS_BOTH},  {4, 5, 0.01, 0.5, SALTUS_UPPER},
                                     {6, 10, 0.014, 0.9, SALTUS_UPPER}, {3, 8, 0.012, 0.8, SALTUS_UPPER}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_spec spec = pipe_spec(rows[k][0], rows[k][1]);
        add_stop(&spec, rows[k][2], rows[k][3], (saltus_sides)rows[k][4]);
        add_stop(&spec, rows[k][2], rows[k][3], (saltus_sides)rows[k][4]);
        spec.stops[0].xi = 0.35;
        spec.stops[1].xi = 0.65;
        saltus_system *system = build(&spec);
        saltus_flow_options options = saltus_flow_defaults();
        saltus_message message = {.text = ""};
        double state[dimension_max];
        check_ok(saltus_system_default_state(system, state, &message), &message);
        saltus_flow *flow = open_flow(system, &options, 0, state);
        watch_run(system, flow, 40);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

/* A symmetric pair of stops hit in the same instant by a symmetric shape: both get their impulse at once. */
static void simultaneous_impacts(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(3, 42);
    set_parameter(&spec, "beta", 0);
    add_stop(&spec, 0.01, 0.5, SALTUS_UPPER);
    add_stop(&spec, 0.01, 0.5, SALTUS_UPPER);
    spec.stops[0].xi = 0.25;
    spec.stops[1].xi = 0.75;
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    double state[dimension_max] = {0.005, 0, 0, 0.5, 0, 0.01};
    saltus_flow *flow = open_flow(system, &options, 0, state);
    saltus_event event = advance(flow, 2, SALTUS_WATCH_IMPACT);
    saltus_flow_state(flow, 0, state);
    assert_int_equal(event.kind, SALTUS_IMPACT);
    saltus_event other = advance(flow, 2, SALTUS_WATCH_IMPACT);
    assert_true(other.face == 1 - event.face && other.time.phase == event.time.phase);
    assert_int_equal(saltus_flow_information(flow, 0).impacts, 2);
    for (int s = 0; s < 2; s++) {
        const double *normal = saltus_system_stop_normal(system, s);
        double rate = normal[0] * state[3] + normal[1] * state[4] + normal[2] * state[5];
        check_near(rate, -0.5 * event.velocity_before, 1e-12);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* With r = 1, no damping and no force, the energy is the same after a million impacts. */
static void elastic_impacts_keep_energy(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 1, 0, 1);
    add_stop(&spec, 0.3, 1, SALTUS_BOTH);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = 1e-15;
    double state[2] = {0.1, 1.0}, energy = 0.5 * (0.01 + 1.0);
    saltus_flow *flow = open_flow(system, &options, 0, state);
    advance(flow, 20000, 0);
    saltus_flow_state(flow, 0, state);
    assert_true(saltus_flow_information(flow, 0).impacts > 150000);
    check_near(0.5 * (state[0] * state[0] + state[1] * state[1]), energy, 1e-11 * energy);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Start at rest on the stop: pressed it holds, pulled it leaves, balanced the first derivative that exceeds
 * rounding decides. */
static void starts_on_the_stop(void **unused) {
    (void)unused;
    const double loads[3] = {0.5, -0.5, 0.0};
    for (int k = 0; k < 3; k++) {
        saltus_spec spec = oscillator_spec(0.1, 0, 0, 1);
        set_parameter(&spec, "F0", loads[k]);
        add_stop(&spec, 0.2, 0.8, SALTUS_UPPER);
        saltus_system *system = build(&spec);
        saltus_flow_options options = saltus_flow_defaults();
        double state[2] = {0.2, 0}, forces[SALTUS_FACES_MAX];
        saltus_flow *flow = open_flow(system, &options, 0, state);
        assert_int_equal(saltus_flow_contacts(flow, 0), loads[k] >= 0);
        saltus_flow_forces(flow, 0, forces);
        check_near(forces[0], loads[k] > 0 ? loads[k] : 0, 1e-15);
        advance(flow, 1, 0);
        saltus_flow_state(flow, 0, state);
        assert_true(loads[k] < 0 ? state[0] < 0.19 : state[0] == 0.2);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
    /* F cos(omega t) at its zero: jerk decides. Rising force presses, falling force releases. */
    for (int sign = -1; sign <= 1; sign += 2) {
        saltus_spec spec = oscillator_spec(0, 0, 1, 1);
        add_stop(&spec, 0, 0.8, SALTUS_UPPER);
        saltus_system *system = build(&spec);
        saltus_flow_options options = saltus_flow_defaults();
        double state[2] = {0, 0};
        saltus_flow *flow = open_flow(system, &options, sign > 0 ? 0.75 : 0.25, state);
        assert_int_equal(saltus_flow_contacts(flow, 0), sign > 0);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
    /* Moving into the stop at the start is an impact at the start. */
    saltus_spec spec = oscillator_spec(0, 1, 0, 1);
    add_stop(&spec, 0.5, 0.5, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    double state[2] = {0.5, 1};
    saltus_flow *flow = open_flow(system, &options, 0, state);
    saltus_flow_state(flow, 0, state);
    check_near(state[1], -0.5, 1e-15);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

static void starts_beyond_are_refused(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(1, 42);
    add_stop(&spec, 0.03, 0.9, SALTUS_BOTH);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_flow *flow;
    double beyond[2] = {-0.0301, 0}, nan_state[2] = {0, NAN};
    check_ok(saltus_flow_new((const saltus_system *[]){system}, 1, &options, &flow, &message), &message);
    assert_int_equal(saltus_flow_start(flow, 0, (saltus_time){0, 0}, beyond, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "lower"));
    assert_int_equal(saltus_flow_start(flow, 0, (saltus_time){0, 0}, nan_state, &message), SALTUS_BAD_INPUT);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* The chatter's cut-off follows the tolerance, and the state after it hardly depends on it: the error of the
 * projection is of higher order. Looser tolerances against the tightest, over one chatter of the reference
 * scene. */
static void chatter_cut_off(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 10);
    add_stop(&spec, 0.025, 0.9, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    double start[dimension_max] = {
        0.0199474617427747,  0.0019470120123940,  5.58697682e-05, 3.15424976e-05,  2.062260e-06,
        -0.0509462082284564, -0.0131770628946764, -0.00212267766, -0.000390840844, 0.000364990620};
    double exact[dimension_max], state[dimension_max];
    long long impacts = 0;
    for (int digits = 14; digits >= 6; digits--) {
        saltus_flow_options options = saltus_flow_defaults();
        options.rtol = pow(10, -digits);
        options.atol = 0.01 * options.rtol;
        saltus_flow *flow = open_flow(system, &options, 0, start);
        while (advance(flow, 1, SALTUS_WATCH_RELEASE).kind != SALTUS_RELEASE)
            ;
        advance(flow, 0.4, 0);
        saltus_flow_state(flow, 0, digits == 14 ? exact : state);
        if (digits < 14) {
            for (int i = 0; i < 10; i++)
                check_near(state[i], exact[i],
                           20 * options.rtol * saltus_system_scale(system)[i < 5 ? 0 : 5] + 1e-15);
            assert_true(saltus_flow_information(flow, 0).impacts < impacts);
        }
        impacts = saltus_flow_information(flow, 0).impacts;
        saltus_flow_free(flow);
    }
    saltus_system_free(system);
}

/* However early a ball's chatter is cut off, it is reported to end where the bounces accumulate: at v / g (1
 * + 2 r / (1 - r)), with v the first speed. */
static void chatter_ends_where_it_accumulates(void **unused) {
    (void)unused;
    const double r = 0.6, g = 2, height = 0.4, speed = sqrt(2 * g * height);
    for (int digits = 3; digits <= 12; digits += 3) {
        saltus_spec spec = oscillator_spec(0, 0, 0, 1);
        set_parameter(&spec, "F0", -g);
        add_stop(&spec, 0, r, SALTUS_LOWER);
        saltus_system *system = build(&spec);
        saltus_flow_options options = saltus_flow_defaults();
        options.rtol = pow(10, -digits);
        options.atol = options.rtol;
        double state[2] = {height, 0};
        saltus_flow *flow = open_flow(system, &options, 0, state);
        saltus_event event = advance(flow, 10, SALTUS_WATCH_STICK);
        assert_int_equal(event.kind, SALTUS_STICK);
        check_near(saltus_time_periods(event.time) * 2 * M_PI, speed / g * (1 + 2 * r / (1 - r)), 1e-12);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

/* Mirror images stay mirror images, bit for bit, in a two-sided scene. */
static void mirror_symmetry(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(4, 20);
    add_stop(&spec, 0.025, 0.8, SALTUS_BOTH);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    double a[dimension_max], b[dimension_max];
    check_ok(saltus_system_default_state(system, a, &message), &message);
    for (int i = 0; i < 8; i++)
        b[i] = -a[i];
    saltus_flow *flow_a = open_flow(system, &options, 0, a), *flow_b = open_flow(system, &options, 0, b);
    for (int p = 1; p < 100; p++) {
        advance(flow_a, p, 0);
        advance(flow_b, p, 0);
        saltus_flow_state(flow_a, 0, a);
        saltus_flow_state(flow_b, 0, b);
        for (int i = 0; i < 8; i++)
            assert_true(a[i] == -b[i]);
    }
    assert_true(saltus_flow_information(flow_a, 0).impacts > 50);
    saltus_flow_free(flow_a);
    saltus_flow_free(flow_b);
    saltus_system_free(system);
}

/* Stopping at sections, at events or in the middle of a step changes nothing beyond the tolerance. */
static void chopping_changes_nothing(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 42);
    add_stop(&spec, 0.035, 0.9, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    double start[dimension_max], whole[dimension_max], chopped[dimension_max];
    check_ok(saltus_system_default_state(system, start, &message), &message);
    saltus_flow *flow = open_flow(system, &options, 0, start);
    advance(flow, 6, 0);
    saltus_flow_state(flow, 0, whole);
    check_ok(saltus_flow_start(flow, 0, (saltus_time){0, 0}, start, &message), &message);
    for (int k = 1; k <= 6 * 317; k++)
        advance(flow, k / 317.0, SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING).kind != SALTUS_REACHED ? k--
                                                                                                     : 0;
    advance(flow, 6, 0);
    saltus_flow_state(flow, 0, chopped);
    for (int i = 0; i < 10; i++)
        check_near(chopped[i], whole[i], 1e-12);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* After a million forcing periods the flow is exactly at the section's phase. */
static void no_section_drift(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.3, 1, 0.2, 40);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = 1e-15;
    double state[2] = {0, 0}, before[2], denominator = (1 - 1600.0) * (1 - 1600.0) + 0.09 * 1600;
    saltus_flow *flow = open_flow(system, &options, 0, state);
    for (long long p = 1; p <= 1000000; p++) {
        saltus_event event;
        saltus_message message = {.text = ""};
        check_ok(saltus_flow_advance(flow, (saltus_time){p, 0}, 0, &event, &message), &message);
        if (p == 1000)
            saltus_flow_state(flow, 0, before);
    }
    saltus_flow_state(flow, 0, state);
    assert_true(saltus_flow_time(flow, 0).phase == 0 && saltus_flow_time(flow, 0).cycle == 1000000);
    check_near(state[0], 0.2 * (1 - 1600.0) / denominator, 1e-17);
    check_near(state[1], 0.2 * 0.3 * 1600 / denominator, 1e-16);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Two masses, each before its own stop at 1 and moving towards it with velocity 1, free of forces. */
static saltus_system *two_free_masses(void) {
    saltus_spec spec = oscillator_spec(0, 0, 0, 1);
    set_parameter(&spec, "N", 2);
    add_stop(&spec, 1, 0.5, SALTUS_UPPER);
    add_stop(&spec, 1, 0.5, SALTUS_UPPER);
    spec.stops[1].weight[0] = 0;
    spec.stops[1].weight[1] = 1;
    return build(&spec);
}

/* Whether the two impacts, one a little ahead, are one event; *sign is that of the other gap at the first. */
static bool hit_together(const saltus_system *system, double ahead, int *sign) {
    saltus_flow_options options = saltus_flow_defaults();
    double state[4] = {1 - 0x1p-10, 1 - 0x1p-10 + ahead, 1, 1};
    saltus_flow *flow = open_flow(system, &options, 0, state);
    saltus_event first = advance(flow, 1, SALTUS_WATCH_IMPACT);
    saltus_flow_state(flow, 0, state);
    *sign = saltus_system_gap_sign(system, 1 - first.face, state);
    saltus_event second = advance(flow, 1, SALTUS_WATCH_IMPACT);
    assert_int_equal(second.face, 1 - first.face);
    saltus_flow_free(flow);
    return second.time.phase == first.time.phase;
}

/* All use one test for a gap that is zero to rounding: such a start is accepted, its face is hit at once, and
 * an impact at another face includes it. */
static void a_gap_is_zero_for_all_or_none(void **unused) {
    (void)unused;
    saltus_system *system = two_free_masses();
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_flow *flow = NULL;
    int seen[3] = {0};
    check_ok(saltus_flow_single(system, 0, &options, &flow, &message), &message);
    for (int k = -40; k <= 40; k++) {
        double state[4] = {0, 1 + k * DBL_EPSILON, 1, 1};
        int sign = saltus_system_gap_sign(system, 1, state), met;
        if (abs(k) <= 15 || abs(k) >= 18)
            assert_int_equal(sign, (k > 15) - (k < -15));
        seen[sign + 1]++;
        assert_int_equal(saltus_system_check_state(system, state, &message) == SALTUS_OK, sign <= 0);
        assert_int_equal(saltus_flow_start(flow, 0, (saltus_time){0, 0}, state, &message) == SALTUS_OK,
                         sign <= 0);
        if (sign <= 0) {
            saltus_flow_state(flow, 0, state);
            assert_int_equal(state[3] < 0, sign == 0);
        }
        bool together = hit_together(system, k * DBL_EPSILON, &met);
        assert_int_equal(together, met == 0);
        seen[met + 1]++;
    }
    assert_true(seen[0] > 20 && seen[1] > 40 && seen[2] > 20);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* A contact is released even if its force vanishes so slowly that meanwhile the state stands still to
 * rounding: beside a second stop that holds, for many forces, and with the same motion at another
 * tolerance. */
static void slow_releases_end(void **unused) {
    (void)unused;
    static const char text[] =
        "model:\n"
        "  parameters: {F: 1}\n"
        "  states: {w: x - 0.178*w}\n"
        "  motion: {x: 0.008*x' - x + F - 1.231*w + 0.3*(y - 1), y: 9 - y - 0.2*y' + 0.3*x}\n"
        "stops: [{coordinate: x, d: 0.5, r: 0.42, sides: upper}, {coordinate: y, d: 1, r: 0.6, sides: "
        "upper}]\n"
        "initial: {x: 0.4, y: 1}\n";
    saltus_scene scene;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_parse(text, strlen(text), "two.yaml", &scene, &message), &message);
    for (int k = 0; k < 16; k++) {
        char setting[32];
        double start[SALTUS_SCENE_STATE_MAX], end[2][SALTUS_SCENE_STATE_MAX];
        snprintf(setting, sizeof setting, "F=%.3f", 2 + 0.125 * k);
        check_ok(saltus_scene_set(&scene, setting, &message), &message);
        saltus_system *system = build(&scene.spec);
        check_ok(saltus_system_default_state(system, start, &message), &message);
        for (int loose = 0; loose < 2; loose++) {
            saltus_flow_options options = saltus_flow_defaults();
            saltus_flow *flow;
            saltus_event event;
            options.rtol = loose ? 1e-11 : 1e-13;
            check_ok(saltus_flow_single(system, 0, &options, &flow, &message), &message);
            check_ok(saltus_flow_start(flow, 0, (saltus_time){0, 0}, start, &message), &message);
            check_ok(saltus_flow_advance(flow, (saltus_time){40, 0}, 0, &event, &message), &message);
            assert_true(saltus_flow_information(flow, 0).releases > 0);
            saltus_flow_state(flow, 0, end[loose]);
            saltus_flow_free(flow);
        }
        assert_true(saltus_system_distance(system, end[0], end[1]) < 1e-7);
        saltus_system_free(system);
    }
    saltus_scene_clear(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stops_are_never_passed),
        cmocka_unit_test(several_stops),
        cmocka_unit_test(coupled_stops),
        cmocka_unit_test(simultaneous_impacts),
        cmocka_unit_test(elastic_impacts_keep_energy),
        cmocka_unit_test(starts_on_the_stop),
        cmocka_unit_test(starts_beyond_are_refused),
        cmocka_unit_test(a_gap_is_zero_for_all_or_none),
        cmocka_unit_test(chatter_cut_off),
        cmocka_unit_test(chatter_ends_where_it_accumulates),
        cmocka_unit_test(mirror_symmetry),
        cmocka_unit_test(chopping_changes_nothing),
        cmocka_unit_test(no_section_drift),
        cmocka_unit_test(slow_releases_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
