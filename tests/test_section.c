/* Sections of unforced scenes: an orbit is the same for any choice of the section, and its section points lie
 * where the scene says.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"
#include "sweep_check.h"

static const char struck_van_der_pol[] = "model:\n"
                                         "  parameters: {mu: 1}\n"
                                         "  motion: {x: mu*(1 - x^2)*x' - x}\n"
                                         "stop: {coordinate: x, d: 1.5, r: 0.7, sides: both}\n"
                                         "initial: {x: 0.5}\n";

static saltus_scene scene_by(const char *name, const char *settings, const char *section) {
    saltus_message message = {.text = ""};
    saltus_scene scene;
    if (name)
        scene = scene_of(name, settings);
    else
        check_ok(saltus_scene_parse(struck_van_der_pol, strlen(struck_van_der_pol), "text", &scene, &message),
                 &message);
    check_ok(saltus_scene_set_section(&scene, section, &message), &message);
    return scene;
}

static saltus_motion classified(const saltus_scene *scene, saltus_system **system) {
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double state[SALTUS_STATE_MAX];
    *system = build(&scene->spec);
    check_ok(saltus_scene_state(scene, *system, state, &message), &message);
    check_ok(saltus_classify(*system, state, &options, &motion, &message), &message);
    return motion;
}

/* Count, in small steps once around from the orbit's state, the rises of the section's expression through
 * zero, or the impacts on its stop. */
static int counted_returns(const saltus_system *system, const saltus_motion *m) {
    enum { samples = 20000 };
    const saltus_poincare section = saltus_system_poincare(system);
    saltus_spec spec = *saltus_system_spec(system);
    saltus_flow_options options = saltus_flow_defaults();
    int count = 0;
    saltus_spec_set_omega(&spec, 2 * M_PI / m->period);
    saltus_system *clocked = build(&spec);
    saltus_flow *flow = open_flow(clocked, &options, 0, m->state);
    double state[SALTUS_STATE_MAX], before = saltus_system_poincare_value(system, m->state);
    for (int k = 1; k <= samples; k++) {
        saltus_event event;
        /* Begin and end the lap a little later, where there is no return. */
        while ((event = advance(flow, (k + 0.5) / samples, SALTUS_WATCH_IMPACT)).kind != SALTUS_REACHED) {
            saltus_face face = saltus_system_face(system, event.face);
            count += section.kind == SALTUS_POINCARE_IMPACT && k > 0 && face.stop == section.stop &&
                     (section.side == 0 || face.side == section.side);
        }
        saltus_flow_state(flow, 0, state);
        double now = saltus_system_poincare_value(system, state);
        count += section.kind == SALTUS_POINCARE_ZERO && k > 1 && before < 0 && now >= 0;
        before = now;
    }
    saltus_flow_free(flow);
    saltus_system_free(clocked);
    return count;
}

/* Section points lie on the section: the stop is touched, or the expression is zero or, after an impact that
 * carries it beyond, positive. */
static void check_points(const saltus_system *system, const saltus_motion *m) {
    const saltus_poincare section = saltus_system_poincare(system);
    const double unit = saltus_system_scale(system)[0];
    for (int k = 0; k < m->periods; k++) {
        const double *point = m->section_states + k * m->dimension;
        double touched = INFINITY;
        for (int f = 0; f < saltus_system_face_count(system); f++) {
            saltus_face face = saltus_system_face(system, f);
            if (section.kind == SALTUS_POINCARE_ZERO ||
                (face.stop == section.stop && (section.side == 0 || face.side == section.side)))
                touched = fmin(touched, fabs(saltus_system_gap(system, f, point)));
        }
        if (section.kind == SALTUS_POINCARE_IMPACT)
            check_near(touched, 0, 1e-12 * unit);
        if (section.kind == SALTUS_POINCARE_ZERO && touched > 1e-12 * unit)
            check_near(saltus_system_poincare_value(system, point), 0, 1e-9);
        else if (section.kind == SALTUS_POINCARE_ZERO)
            assert_true(saltus_system_poincare_value(system, point) > -1e-9);
    }
    assert_true(saltus_system_distance(system, m->section_states, m->state) == 0);
}

typedef struct choice {
    const char *scene, *settings, *axis, *sections[6];
} choice;

static const choice choices[] = {
    {"relief-valve",
     "q=6.8",
     "q=6.8",
     {"maxima", "impact: 1", "zero: p - 10, direction: down", "zero: x*p - 20", "zero: x', direction: down"}},
    {"relief-valve",
     "q=3.05",
     "q=3.05",
     {"maxima", "{impact: 1, side: lower}", "zero: x - 2", "zero: x' + p/10"}},
    {"relief-valve", "q=8", "q=8", {"maxima", "zero: x - 2", "zero: log(p) - 2, direction: down"}},
    {"flutter",
     "u=7.97",
     "u=7.97",
     {"maxima", "zero: q1", "zero: q2 - q1^2, direction: down", "zero: \"q1'*q2 - 0.01\""}},
    {"van-der-pol", "mu=3", "mu=3", {"maxima", "zero: x", "zero: x - 1, direction: down", "zero: x*x'"}},
    {NULL,
     "",
     "mu=1",
     {"maxima", "impact: 1", "impact: 1, side: upper", "zero: x - 1", "zero: x', direction: down"}}};

static void sections_are_of_one_orbit(void **unused) {
    (void)unused;
    for (size_t c = 0; c < sizeof choices / sizeof choices[0]; c++) {
        saltus_motion first = {0};
        for (int k = 0; k < 6 && choices[c].sections[k]; k++) {
            saltus_scene scene = scene_by(choices[c].scene, choices[c].settings, choices[c].sections[k]);
            saltus_system *system;
            saltus_motion m = classified(&scene, &system);
            assert_int_equal(m.verdict, SALTUS_PERIODIC);
            check_near(m.trivial_multiplier, 1, 1e-9);
            check_points(system, &m);
            if (k == 0)
                first = m;
            else {
                assert_int_equal(m.periods, counted_returns(system, &m));
                assert_int_equal(m.impacts, first.impacts);
                check_near(m.period, first.period, 1e-10);
                assert_int_equal(m.multiplier_count, first.multiplier_count);
                for (int i = 0; i < m.multiplier_count; i++) {
                    check_near(m.multipliers[i].re, first.multipliers[i].re, 1e-10);
                    check_near(m.multipliers[i].im, first.multipliers[i].im, 1e-10);
                }
                check_near(m.largest, first.largest, 1e-9);
                saltus_motion_clear(&m);
            }
            saltus_system_free(system);
            saltus_scene_clear(&scene);
        }
        saltus_motion_clear(&first);
    }
}

/* Rows of sweeps also count by the section. */
static void sweeps_count_by_the_section(void **unused) {
    (void)unused;
    saltus_sweep_options options = saltus_sweep_defaults();
    options.threads = 1;
    options.keep = SALTUS_KEEP_STROBOSCOPIC;
    for (size_t c = 0; c < sizeof choices / sizeof choices[0]; c++)
        for (int k = 0; k < 6 && choices[c].sections[k]; k++) {
            saltus_scene scene = scene_by(choices[c].scene, choices[c].settings, choices[c].sections[k]);
            saltus_system *system;
            saltus_motion m = classified(&scene, &system);
            char label[SALTUS_LABEL_MAX];
            saltus_sweep *sweep = sweep_of(&scene, choices[c].axis, NULL, &options);
            outcome o = open_outcome(sweep);
            run_part(&o, 0, 1);
            saltus_sweep_result result = result_at(&o, 0);
            saltus_sweep_label(result.rows, label);
            assert_string_equal(label, m.label);
            check_near(result.rows->period, m.period, 1e-10);
            assert_int_equal(result.strobe_counts[0], m.periods);
            assert_true(saltus_system_distance(system, result.states, m.state) < 1e-7);
            close_outcome(&o);
            saltus_sweep_free(sweep);
            saltus_motion_clear(&m);
            saltus_system_free(system);
            saltus_scene_clear(&scene);
        }
}

/* The place where a branch loses stability does not depend on the section. */
static void branches_do_not_depend_on_the_section(void **unused) {
    (void)unused;
    static const char *const sections[] = {"maxima", "impact: 1", "zero: p - 10, direction: down"};
    double flip[3];
    for (int k = 0; k < 3; k++) {
        saltus_scene scene = scene_by("relief-valve", "q=6.8", sections[k]);
        saltus_system *system;
        saltus_motion m = classified(&scene, &system);
        saltus_branch_options options = branch_along("q", 6.7, 7);
        saltus_spec_set_omega(&scene.spec, 2 * M_PI / m.period);
        options.orbit.free_period = true;
        branch_record record = branch_run(&scene.spec, m.periods, m.state, &options);
        flip[k] = NAN;
        for (int p = 0; p < record.count; p++) {
            const saltus_branch_point *point = &record.point[p];
            assert_int_equal(point->periods, m.periods);
            if (point->kind == SALTUS_POINT_PD)
                flip[k] = point->value[0];
        }
        check_near(flip[k], 6.91709712539, 2e-11);
        check_near(flip[k], flip[0], 1e-10);
        branch_forget(&record);
        saltus_motion_clear(&m);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

/* The largest lift along a point's orbit. */
static double highest(const saltus_branch_point *point) {
    saltus_system *system = build(&point->spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = open_flow(system, &options, 0, point->state);
    double state[SALTUS_STATE_MAX], most = point->state[0];
    while (advance(flow, 1, SALTUS_WATCH_TURNING).kind != SALTUS_REACHED) {
        saltus_flow_state(flow, 0, state);
        most = fmax(most, state[0]);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
    return most;
}

/* Closer to its birth the valve's cycle is smaller: it stops passing x = 6, the branch goes on, and the first
 * point beyond says so. */
static void a_section_that_is_lost_is_told(void **unused) {
    (void)unused;
    saltus_scene scene = scene_by("relief-valve", "q=7.97", "zero: x - 6");
    saltus_system *system;
    saltus_motion m = classified(&scene, &system);
    saltus_branch_options options = branch_along("q", 7.9, 8.05);
    options.direction = 1;
    saltus_spec_set_omega(&scene.spec, 2 * M_PI / m.period);
    options.orbit.free_period = true;
    branch_record record = branch_run(&scene.spec, m.periods, m.state, &options);
    int told = 0;
    for (int k = 1; k + 1 < record.count; k++) {
        const saltus_branch_point *before = &record.point[k - 1], *here = &record.point[k];
        bool lost = highest(before) >= 6 && highest(here) < 6;
        assert_true(lost == (here->reason[0] != 0));
        if (lost)
            assert_non_null(strstr(here->reason, "returns to the section: 0, were 1 until q = "));
        told += lost;
    }
    assert_int_equal(told, 1);
    check_near(record.point[record.count - 1].value[0], 8.05, 1e-12);
    branch_forget(&record);
    saltus_motion_clear(&m);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
}

static void bad_sections_are_refused(void **unused) {
    (void)unused;
    static const char *const sections[] = {"impact: 2",
                                           "impact: 0",
                                           "impact: 1.5",
                                           "impact: x",
                                           "impact: 1, side: upper",
                                           "impact: 1, side: left",
                                           "impact: 1, direction: up",
                                           "zero: p - q0",
                                           "zero: q - 3",
                                           "zero: x - 1, direction: both",
                                           "zero: x - 1, side: upper",
                                           "zero: x - 1, impact: 1",
                                           "zero: x -",
                                           "zero: [1, 2]",
                                           "zero: min(x, p)",
                                           "direction: up",
                                           "crossing: x",
                                           "minima",
                                           "{zero: x",
                                           "zero:",
                                           ""};
    saltus_scene scene = scene_of("relief-valve", ""), forced = scene_of("impact-oscillator", "");
    const saltus_model *model = scene.spec.model;
    saltus_message message = {.text = ""};
    for (size_t k = 0; k < sizeof sections / sizeof sections[0]; k++) {
        message = (saltus_message){.text = ""};
        if (saltus_scene_set_section(&scene, sections[k], &message) != SALTUS_BAD_INPUT)
            fail_msg("accepted: %s", sections[k]);
        assert_true(strlen(message.text) > 20 && scene.spec.model == model);
    }
    assert_int_equal(saltus_scene_set_section(&forced, "maxima", &message), SALTUS_BAD_INPUT);
    static const char with_forcing[] = "model:\n  parameters: {w: 1}\n  motion: {x: -x - x' + cos(w*t)}\n"
                                       "  forcing: w\n  section: {zero: x}\n";
    saltus_scene text;
    assert_int_equal(saltus_scene_parse(with_forcing, strlen(with_forcing), "here", &text, &message),
                     SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "here:5: section"));
    /* A stop that the section needs is kept. */
    check_ok(saltus_scene_set(&scene, "section={impact: 1}", &message), &message);
    assert_int_equal(saltus_scene_set(&scene, "sides=none", &message), SALTUS_BAD_INPUT);
    assert_int_equal(scene.spec.stop_count, 1);
    check_ok(saltus_scene_set(&scene, "section=maxima", &message), &message);
    check_ok(saltus_scene_set(&scene, "sides=none", &message), &message);
    saltus_scene_clear(&scene);
    saltus_scene_clear(&forced);
}

/* On a circle of radius 1, sin(k x) rises through zero where k x is an even multiple of pi and x grows, or an
 * odd one and x falls: often many times in one step. */
static void all_rises_in_a_step_are_returns(void **unused) {
    (void)unused;
    static const char circle[] = "model:\n  parameters: {k: 30}\n  motion: {x: (1 - x^2 - x'^2)*x' - x}\n"
                                 "  section: {zero: sin(k*x)}\ninitial: {x: 0.3, x': 0.4}\n";
    static const double steepness[] = {1, 10, 30, 60, 100};
    for (size_t j = 0; j < sizeof steepness / sizeof steepness[0]; j++) {
        saltus_message message = {.text = ""};
        saltus_scene scene;
        saltus_system *system;
        char setting[32];
        int rises = 0;
        for (int m = 0; m * M_PI < steepness[j]; m++)
            rises += m == 0 ? 1 : 2;
        check_ok(saltus_scene_parse(circle, strlen(circle), "text", &scene, &message), &message);
        snprintf(setting, sizeof setting, "k=%g", steepness[j]);
        check_ok(saltus_scene_set(&scene, setting, &message), &message);
        saltus_motion motion = classified(&scene, &system);
        assert_int_equal(motion.verdict, SALTUS_PERIODIC);
        assert_int_equal(motion.periods, rises);
        check_near(motion.period, 2 * M_PI, 1e-9);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_rises_in_a_step_are_returns),
        cmocka_unit_test(sections_are_of_one_orbit),
        cmocka_unit_test(sweeps_count_by_the_section),
        cmocka_unit_test(branches_do_not_depend_on_the_section),
        cmocka_unit_test(a_section_that_is_lost_is_told),
        cmocka_unit_test(bad_sections_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
