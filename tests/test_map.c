/* The three Poincare maps and their derivatives.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

enum { dimension_max = 12 };

static saltus_map *open_map(const saltus_system *system, saltus_section_kind kind, double phase, int iterate,
                            bool derivative) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_section section = saltus_section_defaults();
    saltus_message message = {""};
    saltus_map *map;
    section.kind = kind;
    section.phase = phase;
    section.iterate = iterate;
    check_ok(saltus_map_new(system, &section, &options, derivative, &map, &message), &message);
    return map;
}

static void image_of(saltus_map *map, const double *point, double *image) {
    saltus_message message = {""};
    check_ok(saltus_map_reset(map, point, &message), &message);
    check_ok(saltus_map_step(map, image, NULL, &message), &message);
}

/* Derivative against central differences, in directions that keep to the section. */
static void compare_derivative(const saltus_system *system, saltus_section_kind kind, double phase,
                               int iterate, const double *point, int first_free) {
    saltus_map *map = open_map(system, kind, phase, iterate, true);
    int m = saltus_map_dimension(map), n = saltus_system_dimension(system);
    double image[dimension_max], derivative[dimension_max * dimension_max], plus[dimension_max],
        minus[dimension_max];
    image_of(map, point, image);
    saltus_map_derivative(map, derivative);
    for (int j = first_free; j < m; j++) {
        double h = 1e-6 * (j < n ? saltus_system_scale(system)[j] : saltus_system_period(system));
        double shifted[dimension_max];
        memcpy(shifted, point, (size_t)m * sizeof *point);
        shifted[j] = point[j] + h;
        image_of(map, shifted, plus);
        shifted[j] = point[j] - h;
        image_of(map, shifted, minus);
        for (int i = 0; i < m; i++) {
            double size = i < n ? saltus_system_scale(system)[i] : saltus_system_period(system);
            check_near(derivative[i * m + j] * h / size, (plus[i] - minus[i]) / 2 / size, 2e-10);
        }
    }
    saltus_map_free(map);
}

static void stroboscopic_derivative(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(3, 42);
    add_stop(&spec, 0.02, 0.8, SALTUS_BOTH);
    saltus_system *system = build(&spec);
    double state[dimension_max] = {0.005, 0.002, 0.0005, 0.3, -0.05, 0.02};
    for (int k = 0; k < 4; k++)
        compare_derivative(system, SALTUS_SECTION_STROBOSCOPIC, 0.23 * k, 1 + k, state, 0);
    saltus_system_free(system);
}

/* Oscillator from an impact: displacement stays on the stop, speed and time are free. */
static void impact_derivative(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 1, 0.8, 1.1);
    add_stop(&spec, 0.3, 0.7, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    double point[3] = {0.3, -0.4, 1.0};
    for (int iterate = 1; iterate <= 3; iterate++)
        compare_derivative(system, SALTUS_SECTION_IMPACT, 0, iterate, point, 1);
    saltus_system_free(system);
}

static void turning_derivative(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(2, 20);
    saltus_system *system = build(&spec);
    double state[dimension_max] = {0.01, 0.003, 0.1, 0.05, 0.02};
    for (int iterate = 1; iterate <= 3; iterate++)
        compare_derivative(system, SALTUS_SECTION_TURNING, 0, iterate, state, 0);
    saltus_system_free(system);
}

/* Turning points alternate, have zero velocity, and impacts appear at the stop. */
static void turning_points(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 42);
    add_stop(&spec, 0.035, 0.9, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_map *map = open_map(system, SALTUS_SECTION_TURNING, 0, 1, false);
    saltus_message message = {""};
    double point[dimension_max] = {0};
    int impacts = 0;
    check_ok(saltus_system_default_state(system, point, &message), &message);
    check_ok(saltus_map_reset(map, point, &message), &message);
    for (int k = 0; k < 500; k++) {
        saltus_event event;
        check_ok(saltus_map_step(map, point, &event, &message), &message);
        double g = saltus_system_gap(system, 0, point) + 0.035, rate = 0;
        for (int i = 0; i < 5; i++)
            rate += saltus_system_observer(system)[i] * point[5 + i];
        assert_true(g <= 0.035 + 1e-15);
        if (event.kind == SALTUS_TURNING)
            check_near(rate, 0, 1e-13);
        else {
            check_near(g, 0.035, 1e-15);
            impacts++;
        }
    }
    assert_true(impacts > 20);
    saltus_map_free(map);
    saltus_system_free(system);
}

/* The section's phase only moves the point along the orbit: the multipliers stay. */
static void any_phase(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 42);
    add_stop(&spec, 0.035, 0.9, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_message message = {""};
    saltus_classify_options classify = saltus_classify_defaults();
    saltus_motion motion;
    double state[dimension_max] = {0};
    check_ok(saltus_system_default_state(system, state, &message), &message);
    check_ok(saltus_classify(system, state, &classify, &motion, &message), &message);
    for (int k = 1; k < 5; k++) {
        saltus_orbit_options options = saltus_orbit_defaults();
        saltus_orbit orbit;
        options.phase = 0.2 * k;
        saltus_flow *flow = open_flow(system, &options.flow, 0, motion.state);
        advance(flow, options.phase, 0);
        saltus_flow_state(flow, 0, state);
        saltus_flow_free(flow);
        check_ok(saltus_orbit_find(system, motion.periods, state, &options, &orbit, &message), &message);
        for (int i = 0; i < 10; i++)
            check_near(orbit.multipliers[i].log_modulus, motion.multipliers[i].log_modulus, 1e-6);
        check_near(orbit.log_volume, orbit.sum_rule, 1e-9);
        saltus_orbit_clear(&orbit);
    }
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

static void refused_sections(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(2, 20);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {""};
    saltus_map *map;
    saltus_section section = saltus_section_defaults();
    section.phase = 1;
    assert_int_equal(saltus_map_new(system, &section, &options, false, &map, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "phase"));
    section = saltus_section_defaults();
    section.iterate = 0;
    assert_int_equal(saltus_map_new(system, &section, &options, false, &map, &message), SALTUS_BAD_INPUT);
    section = saltus_section_defaults();
    section.kind = SALTUS_SECTION_IMPACT;
    section.patience = 5;
    check_ok(saltus_map_new(system, &section, &options, false, &map, &message), &message);
    double point[5] = {0.01, 0, 0, 0, 0};
    check_ok(saltus_map_reset(map, point, &message), &message);
    assert_int_equal(saltus_map_step(map, point, NULL, &message), SALTUS_NO_CONVERGENCE);
    saltus_map_free(map);
    section.patience = 0;
    assert_int_equal(saltus_map_new(system, &section, &options, false, &map, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "patience"));
    saltus_system_free(system);
}

/* Patience of part of a period is patience: an impact that comes within it is met. */
static void short_patience(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 1, 0, 1);
    add_stop(&spec, 0.5, 0.9, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {""};
    saltus_section section = saltus_section_defaults();
    saltus_map *map;
    saltus_event event;
    double point[3] = {0, 1, 0};
    section.kind = SALTUS_SECTION_IMPACT;
    section.patience = 0.5;
    check_ok(saltus_map_new(system, &section, &options, false, &map, &message), &message);
    check_ok(saltus_map_reset(map, point, &message), &message);
    check_ok(saltus_map_step(map, point, &event, &message), &message);
    assert_int_equal(event.kind, SALTUS_IMPACT);
    check_near(point[2], M_PI / 6, 1e-13);
    saltus_map_free(map);
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stroboscopic_derivative),
        cmocka_unit_test(impact_derivative),
        cmocka_unit_test(turning_derivative),
        cmocka_unit_test(turning_points),
        cmocka_unit_test(any_phase),
        cmocka_unit_test(refused_sections),
        cmocka_unit_test(short_patience),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
