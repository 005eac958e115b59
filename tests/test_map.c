/* The three Poincare maps and their derivatives.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes.h"

enum { dimension_max = 12 };

static saltus_map *open_map(const saltus_system *system, saltus_section_kind kind, double phase, int iterate,
                            bool derivative) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_section section = saltus_section_defaults();
    saltus_message message = {.text = ""};
    saltus_map *map;
    section.kind = kind;
    section.phase = phase;
    section.iterate = iterate;
    check_ok(saltus_map_new(system, &section, &options, derivative, &map, &message), &message);
    return map;
}

static void image_of(saltus_map *map, const double *point, double *image) {
    saltus_message message = {.text = ""};
    check_ok(saltus_map_reset(map, point, &message), &message);
    check_ok(saltus_map_step(map, image, NULL, &message), &message);
}

/* Compare the derivative with central differences along the section. */
static void compare_derivative(const saltus_system *system, saltus_section_kind kind, double phase,
                               int iterate, const double *point, int first_free) {
    saltus_map *map = open_map(system, kind, phase, iterate, true);
    int m = saltus_map_dimension(map), n = saltus_system_dimension(system);
    double image[dimension_max], derivative[dimension_max * dimension_max], plus[dimension_max],
        minus[dimension_max];
    assert_true(m < dimension_max);
    image[m] = 7;
    image_of(map, point, image);
    assert_true(image[m] == 7); /* no more than the point's coordinates are written */
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

/* Oscillator from an impact: displacement is fixed at the stop, speed and time are free. */
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
    saltus_message message = {.text = ""};
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

/* The section's phase moves the point along the orbit, and leaves the multipliers unchanged. */
static void any_phase(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 42);
    add_stop(&spec, 0.035, 0.9, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_message message = {.text = ""};
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
    saltus_message message = {.text = ""};
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

/* Patience of a part of a period suffices for an impact within it. */
static void short_patience(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 1, 0, 1);
    add_stop(&spec, 0.5, 0.9, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
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

/* Defaults and refusals; patience need not be a whole number. */
static void sections_are_checked(void **unused) {
    (void)unused;
    saltus_section d = saltus_section_defaults();
    assert_true(d.kind == SALTUS_SECTION_STROBOSCOPIC && d.phase == 0 && d.iterate == 1 &&
                d.patience == 1000);
    static const struct {
        int kind, iterate;
        double phase, patience;
        bool right;
    } rows[] = {{0, 1, 0, 0.5, true},  {1, 1, 0, 0.5, true},       {2, 7, 0.999, 1e-3, true},
                {-1, 1, 0, 1, false},  {3, 1, 0, 1, false},        {0, 0, 0, 1, false},
                {0, -1, 0, 1, false},  {0, 1, 1, 1, false},        {0, 1, -1e-9, 1, false},
                {0, 1, NAN, 1, false}, {0, 1, 0, 0, false},        {0, 1, 0, -1, false},
                {1, 1, 0, NAN, false}, {1, 1, 0, INFINITY, false}, {1, 1, 0, 1e15, true},
                {1, 1, 0, 2e15, false}};
    scene s = scene_of(scene_two_sided_mass);
    saltus_system *system = build(&s.spec);
    saltus_flow_options options = saltus_flow_defaults();
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_section section = {(saltus_section_kind)rows[k].kind, rows[k].phase, rows[k].iterate,
                                  rows[k].patience};
        saltus_message message = {.text = ""};
        saltus_map *map = (saltus_map *)1;
        saltus_status status = saltus_map_new(system, &section, &options, false, &map, &message);
        assert_int_equal(status, rows[k].right ? SALTUS_OK : SALTUS_BAD_INPUT);
        assert_true((map != NULL) == rows[k].right);
        if (map) {
            assert_int_equal(saltus_map_dimension(map), 2 + (rows[k].kind > 0));
            assert_ptr_equal(saltus_flow_system(saltus_map_flow(map), 0), system);
        }
        saltus_map_free(map);
    }
    saltus_map_free(NULL);
    options.rtol = 1;
    saltus_map *map = NULL;
    saltus_message message = {.text = ""};
    assert_int_equal(saltus_map_new(system, &d, &options, true, &map, &message), SALTUS_BAD_INPUT);
    assert_null(map);
    saltus_system_free(system);
}

/* x = cos t turns after half a period, falls on a stop at -1/2 after a third: found with a little more
 * patience than that, given up with a little less. */
static void patience_is_counted_in_periods(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 1, 0, 1);
    add_stop(&spec, 0.5, 0.5, SALTUS_LOWER);
    saltus_flow_options options = saltus_flow_defaults();
    for (int k = 0; k < 8; k++) {
        const bool impact = k / 2 % 2, enough = k % 2;
        double point[3] = {1, 0, k < 4 ? 0 : 5.5}, after = impact ? 1.0 / 3 : 0.5;
        spec.stop_count = impact;
        saltus_section section = {impact ? SALTUS_SECTION_IMPACT : SALTUS_SECTION_TURNING, 0, 1,
                                  after + (enough ? 0.01 : -0.01)};
        saltus_message message = {.text = ""};
        saltus_event event;
        saltus_system *system = build(&spec);
        saltus_map *map = NULL;
        check_ok(saltus_map_new(system, &section, &options, false, &map, &message), &message);
        check_ok(saltus_map_reset(map, point, &message), &message);
        saltus_status status = saltus_map_step(map, point, &event, &message);
        assert_int_equal(status, enough ? SALTUS_OK : SALTUS_NO_CONVERGENCE);
        if (enough) {
            check_near(point[2], fmod((k < 4 ? 0 : 5.5) + after * 2 * M_PI, 2 * M_PI), 1e-12);
            assert_int_equal(event.kind, impact ? SALTUS_IMPACT : SALTUS_TURNING);
        }
        saltus_map_free(map);
        saltus_system_free(system);
    }
}

/* Several iterates are single steps in a row, and the event is that of the last; the map also advances
 * without places for point and event. A stick is a point of the impact section. */
static void iterates_are_steps_in_a_row(void **unused) {
    (void)unused;
    int sticks = 0;
    for (int name = 0; name < scenes; name++)
        for (int kind = 0; kind < 3; kind++) {
            scene s = scene_of((scene_name)name);
            if ((kind == 1 && s.spec.stop_count == 0) || name == scene_steady_pipe)
                continue;
            saltus_system *system = build(&s.spec);
            saltus_map *one = open_map(system, (saltus_section_kind)kind, 0.4, 1, false),
                       *three = open_map(system, (saltus_section_kind)kind, 0.4, 3, false);
            const int n = saltus_system_dimension(system), m = saltus_map_dimension(one);
            double point[scene_dimension_max], a[scene_dimension_max], b[scene_dimension_max];
            saltus_message message = {.text = ""};
            saltus_event last, event;
            memcpy(point, s.state, sizeof point);
            if (kind > 0)
                point[n] = 0.3 * saltus_system_period(system);
            check_ok(saltus_map_reset(one, point, &message), &message);
            check_ok(saltus_map_reset(three, point, &message), &message);
            for (int k = 0; k < 2; k++) {
                check_ok(saltus_map_step(one, NULL, NULL, &message), &message);
                check_ok(saltus_map_step(one, a, NULL, &message), &message);
                check_ok(saltus_map_step(one, a, &last, &message), &message);
                check_ok(saltus_map_step(three, b, &event, &message), &message);
                assert_memory_equal(a, b, (size_t)m * sizeof *a);
                assert_true(last.kind == event.kind && last.face == event.face &&
                            last.time.phase == event.time.phase);
                saltus_time now = saltus_flow_time(saltus_map_flow(one), 0);
                if (kind == 0)
                    assert_true(event.kind == SALTUS_REACHED && now.phase == 0.4 && now.cycle == 3 * (k + 1));
                else
                    assert_true(a[n] == now.phase * saltus_system_period(system) &&
                                event.kind != SALTUS_REACHED);
                assert_true(kind != 1 || event.kind != SALTUS_TURNING);
                sticks += kind == 1 && event.kind == SALTUS_STICK;
            }
            saltus_map_free(one);
            saltus_map_free(three);
            saltus_system_free(system);
        }
    assert_true(sticks > 0);
}

/* Patience may end exactly with a period. x = cos t started at quarters of a period falls on its stop a third
 * of a period after its maximum, and patience ends with this period or the next. */
static void patience_may_end_with_a_period(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 1, 0, 1);
    add_stop(&spec, 0.5, 0.5, SALTUS_LOWER);
    for (int k = 0; k < 4; k++)
        for (int wait = 0; wait < 2; wait++) {
            /* The impact comes after 1/3 of a period; from the phase 3/4 on patience of 1/4 is not enough. */
            const double phase = 0.25 * k, patience = 1 - phase + wait;
            saltus_section section = {SALTUS_SECTION_IMPACT, 0, 1, patience};
            saltus_flow_options options = saltus_flow_defaults();
            saltus_message message = {.text = ""};
            saltus_event event;
            saltus_system *system = build(&spec);
            saltus_map *map = NULL;
            double point[3] = {1, 0, phase * saltus_system_period(system)};
            check_ok(saltus_map_new(system, &section, &options, false, &map, &message), &message);
            check_ok(saltus_map_reset(map, point, &message), &message);
            saltus_status status = saltus_map_step(map, point, &event, &message);
            assert_int_equal(status, patience > 1.0 / 3 ? SALTUS_OK : SALTUS_NO_CONVERGENCE);
            saltus_time now = saltus_flow_time(saltus_map_flow(map), 0);
            if (status == SALTUS_OK)
                check_near(saltus_time_periods(now), phase + 1.0 / 3, 1e-13);
            else
                assert_true(now.cycle == 1 && now.phase == 0);
            saltus_map_free(map);
            saltus_system_free(system);
        }
}

/* A failing step leaves its inputs unchanged and reports how long it waited; a second call gives the same
 * derivative. */
static void failed_steps_leave_the_point(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 1, 0, 1);
    add_stop(&spec, 0.5, 0.5, SALTUS_LOWER);
    saltus_system *system = build(&spec);
    saltus_section section = {SALTUS_SECTION_IMPACT, 0, 2, 0.375};
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    saltus_map *map = NULL;
    double point[3] = {1, 0, 0.125}, twice[2][9];
    const double kept[3] = {1, 0, 0.125};
    check_ok(saltus_map_new(system, &section, &options, true, &map, &message), &message);
    check_ok(saltus_map_reset(map, point, &message), &message);
    assert_int_equal(saltus_map_step(map, point, NULL, &message), SALTUS_NO_CONVERGENCE);
    assert_memory_equal(point, kept, sizeof point);
    assert_non_null(strstr(message.text, "0.375 periods"));
    point[2] = NAN;
    assert_int_equal(saltus_map_reset(map, point, &message), SALTUS_BAD_INPUT);
    saltus_map_free(map);
    section.patience = 10;
    check_ok(saltus_map_new(system, &section, &options, true, &map, &message), &message);
    for (int run = 0; run < 2; run++) {
        check_ok(saltus_map_reset(map, kept, &message), &message);
        check_ok(saltus_map_step(map, point, NULL, &message), &message);
        saltus_map_derivative(map, twice[0]);
        saltus_map_derivative(map, twice[1]);
        assert_memory_equal(twice[0], twice[1], sizeof twice[0]);
    }
    saltus_map_free(map);
    static const struct {
        saltus_section section;
        const char *text;
    } rows[] = {{{SALTUS_SECTION_STROBOSCOPIC, -0.25, 1, 7}, "phase = -0.25:"},
                {{SALTUS_SECTION_STROBOSCOPIC, 1.5, 1, 7}, "phase = 1.5:"},
                {{SALTUS_SECTION_TURNING, 0.5, -3, 7}, "iterate = -3:"},
                {{SALTUS_SECTION_IMPACT, 0.5, 2, -1.25}, "patience = -1.25:"},
                {{(saltus_section_kind)3, 0.5, 2, 7}, "stroboscopic, impact or turning"}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        assert_int_equal(saltus_map_new(system, &rows[k].section, &options, true, &map, &message),
                         SALTUS_BAD_INPUT);
        assert_null(map);
        assert_non_null(strstr(message.text, rows[k].text));
    }
    saltus_system_free(system);
}

/* The derivative through all events of a few periods, in all scenes: impacts, chatter, sticking, release,
 * several faces; with both integrators. */
static void derivatives_pass_all_events(void **unused) {
    (void)unused;
    for (int name = 0; name < scenes; name++)
        for (int integrator = SALTUS_TAYLOR; integrator <= SALTUS_MIXED; integrator++) {
            scene s = scene_of((scene_name)name);
            saltus_system *system = build(&s.spec);
            saltus_flow_options options = saltus_flow_defaults();
            saltus_message message = {.text = ""};
            const int n = saltus_system_dimension(system);
            double columns[scene_dimension_max * scene_dimension_max], image[2][scene_dimension_max];
            options.integrator = (saltus_integrator)integrator;
            options.columns = n;
            for (int part = 1; part <= 4; part++) {
                const double end = s.phase + 0.4 * part;
                saltus_flow *flow = open_flow(system, &options, s.phase, s.state);
                advance(flow, end, 0);
                saltus_flow_info info = saltus_flow_information(flow, 0);
                saltus_flow_tangents(flow, 0, columns);
                for (int c = 0; c < n; c++) {
                    const double h = 1e-6 * saltus_system_scale(system)[c];
                    bool same = true;
                    for (int side = 0; side < 2; side++) {
                        double moved[scene_dimension_max];
                        memcpy(moved, s.state, sizeof moved);
                        moved[c] += side ? h : -h;
                        check_ok(saltus_flow_start(flow, 0, (saltus_time){0, s.phase}, moved, &message),
                                 &message);
                        advance(flow, end, 0);
                        saltus_flow_info other = saltus_flow_information(flow, 0);
                        same &= other.sticks == info.sticks && other.releases == info.releases;
                        saltus_flow_state(flow, 0, image[side]);
                    }
                    for (int i = 0; i < n && same; i++) {
                        const double size = saltus_system_scale(system)[i],
                                     entry = columns[c * n + i] * h / size;
                        check_near(entry, (image[1][i] - image[0][i]) / 2 / size, 2e-9 + 1e-4 * fabs(entry));
                    }
                }
                saltus_flow_free(flow);
            }
            saltus_system_free(system);
        }
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
        cmocka_unit_test(sections_are_checked),
        cmocka_unit_test(patience_is_counted_in_periods),
        cmocka_unit_test(patience_may_end_with_a_period),
        cmocka_unit_test(failed_steps_leave_the_point),
        cmocka_unit_test(iterates_are_steps_in_a_row),
        cmocka_unit_test(derivatives_pass_all_events),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
