/* Returns of unforced scenes to their section: a complete chatter with all its impacts counts as one, of any
 * size, on either side, wherever counting begins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"
#include "sweep_check.h"

#include "orbit/poincare.h"
#include "system/system.h"

/* A mass on a spring with negative damping, pushed by F against a stop that it leaves again as the state w
 * lags behind it. With n = 0 and the stop at 0 all lengths scale with F. `side` mirrors it. */
static saltus_scene bursting(const char *side, const char *observe, const char *settings) {
    saltus_message message = {.text = ""};
    saltus_scene scene;
    char text[512], each[128];
    const bool upper = strcmp(side, "upper") == 0;
    snprintf(text, sizeof text,
             "model:\n"
             "  parameters: {F: 1, z: 0.424, c: 1.945, b: 0.151, g: 0.174, n: 0}\n"
             "  states: {w: x - b*w + g*x'}\n"
             "  motion: {x: 2*z*x' - x %s F - c*w - n*x^2*x'}\n"
             "  observe: {seen: %s}\n"
             "stop: {coordinate: x, d: 0, r: 0.666, sides: %s}\n"
             "initial: {x: %s0.3*F, w: 0.1*F}\n",
             upper ? "-" : "+", observe, side, upper ? "-" : "");
    check_ok(saltus_scene_parse(text, strlen(text), "text", &scene, &message), &message);
    snprintf(each, sizeof each, "%s", settings);
    for (char *rest = each, *word; (word = strtok_r(rest, " ", &rest));)
        check_ok(saltus_scene_set(&scene, word, &message), &message);
    return scene;
}

/* With a hardening spring it settles on one chatter, or on several impacts. */
static const char several[] = "F=0.8208 z=0.294 c=1.3112 b=0.2013 g=-0.0451 n=0.1 r=";

static saltus_motion settled(const saltus_scene *scene, double rtol, saltus_system **system) {
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double state[SALTUS_STATE_MAX];
    options.flow.rtol = rtol;
    options.flow.atol = 1e-3 * rtol;
    *system = build(&scene->spec);
    check_ok(saltus_scene_state(scene, *system, state, &message), &message);
    check_ok(saltus_classify(*system, state, &options, &motion, &message), &message);
    assert_int_equal(motion.verdict, SALTUS_PERIODIC);
    return motion;
}

/* Size, side, observer, section and tolerance make no difference, and a sweep counts the same. */
static void chatter_is_one_return(void **unused) {
    (void)unused;
    static const struct {
        const char *side, *observe, *settings, *section;
        double rtol;
    } views[] = {{"upper", "x", "F=1", "maxima", 1e-13},
                 {"upper", "x", "F=1e-3", "maxima", 1e-13},
                 {"upper", "x", "F=50", "maxima", 1e-9},
                 {"lower", "x", "F=1", "maxima", 1e-13},
                 {"lower", "x", "F=1e-3", "maxima", 1e-10},
                 {"upper", "-2*x", "F=1", "maxima", 1e-13},
                 {"upper", "x", "F=1", "impact: 1, side: upper", 1e-13},
                 {"lower", "x", "F=1", "impact: 1", 1e-13}};
    double period = 0;
    for (size_t k = 0; k < sizeof views / sizeof views[0]; k++) {
        saltus_message message = {.text = ""};
        saltus_scene scene = bursting(views[k].side, views[k].observe, views[k].settings);
        saltus_system *system;
        check_ok(saltus_scene_set_section(&scene, views[k].section, &message), &message);
        saltus_motion m = settled(&scene, views[k].rtol, &system);
        assert_string_equal(m.label, "chatter/1");
        assert_true(m.sticking_intervals == 1 && m.event_count > 20);
        period = k ? period : m.period;
        check_near(m.period, period, 1e3 * views[k].rtol * period);
        saltus_sweep_options options = saltus_sweep_defaults();
        options.threads = 1;
        options.keep = 15;
        single s = run_single(&scene, "z", 0.424, &options);
        assert_string_equal(s.label, "chatter/1");
        check_near(s.result.rows->period, period, 1e-7 * period);
        assert_int_equal(s.result.strobe_counts[0], 1);
        assert_true(saltus_system_distance(system, s.result.strobes, m.state) < 1e-6);
        close_single(&s);
        saltus_motion_clear(&m);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

/* The orbit has the same returns from any start on it, also amid its impacts; they all count if chatter does
 * not complete. */
static void returns_do_not_depend_on_the_begin(void **unused) {
    enum { begins = 24 };
    (void)unused;
    static const char *const settings[] = {"0.05", "0.19", "0.2", "0.35"};
    int chatters = 0;
    for (int k = 0; k < 4; k++)
        for (int side = 0; side < 2; side++) {
            saltus_message message = {.text = ""};
            char text[128];
            snprintf(text, sizeof text, "%s%s", several, settings[k]);
            saltus_scene scene = bursting(side ? "lower" : "upper", "x", text);
            saltus_system *system, *clocked;
            saltus_motion m = settled(&scene, 1e-13, &system);
            chatters += m.impacts < 0;
            assert_int_equal(m.periods, m.impacts < 0 ? 1 : m.impacts);
            check_ok(saltus_system_clocked(system, 2 * M_PI / m.period, &clocked, &message), &message);
            saltus_flow_options options = saltus_flow_defaults();
            saltus_flow *flow;
            check_ok(saltus_flow_single(clocked, 0, &options, &flow, &message), &message);
            for (int begin = 0; begin < begins; begin++) {
                saltus_lap lap = {.keeps_events = true};
                saltus_event event;
                double state[SALTUS_STATE_MAX];
                check_ok(saltus_flow_start(flow, 0, (saltus_time){0, 0}, m.state, &message), &message);
                if (begin)
                    check_ok(saltus_flow_advance(flow, saltus_time_of((double)begin / begins), 0, &event,
                                                 &message),
                             &message);
                saltus_flow_state(flow, 0, state);
                check_ok(saltus_lap_cycle(&lap, flow, state, NULL, &message), &message);
                assert_int_equal(lap.periods, m.periods);
                assert_int_equal(saltus_lap_impacts(&lap), m.impacts);
                for (int p = 0; p < m.periods; p++)
                    assert_true(saltus_system_distance(system, lap.points + p * m.dimension,
                                                       m.section_states + p * m.dimension) < 1e-6);
                saltus_lap_close(&lap);
            }
            saltus_flow_free(flow);
            saltus_system_free(clocked);
            saltus_motion_clear(&m);
            saltus_system_free(system);
            saltus_scene_clear(&scene);
        }
    assert_int_equal(chatters, 4);
}

/* Backwards in time van der Pol's cycle is so unstable (1e13-fold once around) that the flow from one state
 * on it leaves it. Gone around in pieces, from states of the stable one, it returns once, to the same
 * maximum. */
static void an_unstable_cycle_is_gone_around_in_pieces(void **unused) {
    enum { pieces = 7 };
    (void)unused;
    static const char *const models[] = {"model: {motion: {x: 3*(1 - x^2)*x' - x}}\ninitial: {x: 0.5}\n",
                                         "model: {motion: {x: -3*(1 - x^2)*x' - x}}\ninitial: {x: 0.5}\n"};
    saltus_message message = {.text = ""};
    saltus_flow_options options = saltus_flow_defaults();
    saltus_scene scenes[2];
    saltus_system *systems[2], *clocked[2];
    saltus_flow *flows[2];
    for (int k = 0; k < 2; k++)
        check_ok(saltus_scene_parse(models[k], strlen(models[k]), "text", &scenes[k], &message), &message);
    saltus_motion m = settled(&scenes[0], 1e-13, &systems[0]);
    systems[1] = build(&scenes[1].spec);
    for (int k = 0; k < 2; k++) {
        check_ok(saltus_system_clocked(systems[k], 2 * M_PI / m.period, &clocked[k], &message), &message);
        check_ok(saltus_flow_single(clocked[k], 0, &options, &flows[k], &message), &message);
    }
    double state[pieces][2], time[pieces];
    saltus_event event;
    for (int k = 0; k < pieces; k++) {
        time[k] = (k + 0.5) / pieces;
        check_ok(saltus_flow_start(flows[0], 0, (saltus_time){0, 0}, m.state, &message), &message);
        check_ok(saltus_flow_advance(flows[0], saltus_time_of(1 - time[k]), 0, &event, &message), &message);
        saltus_flow_state(flows[0], 0, state[k]);
        state[k][1] = -state[k][1];
    }
    saltus_lap lap = {.keeps_events = true};
    const double begin = time[0];
    for (int k = 0; k < pieces; k++)
        time[k] -= begin;
    check_ok(saltus_lap_cycle(&lap, flows[1], state[0], &(saltus_pieces){pieces - 1, time + 1, state[1]},
                              &message),
             &message);
    assert_int_equal(lap.returns, 1);
    check_near(lap.points[0], m.state[0], 1e-9);
    check_near(lap.points[1], 0, 1e-9);
    saltus_lap_close(&lap);
    saltus_motion_clear(&m);
    for (int k = 0; k < 2; k++) {
        saltus_flow_free(flows[k]);
        saltus_system_free(clocked[k]);
        saltus_system_free(systems[k]);
        saltus_scene_clear(&scenes[k]);
    }
}

static branch_record branch_in_r(const char *r, double low, double high) {
    saltus_system *system;
    char text[128];
    snprintf(text, sizeof text, "%s%s", several, r);
    saltus_scene scene = bursting("upper", "x", text);
    saltus_motion m = settled(&scene, 1e-13, &system);
    saltus_branch_options options = branch_along("r", low, high);
    saltus_spec_set_omega(&scene.spec, 2 * M_PI / m.period);
    options.direction = 1;
    options.orbit.free_period = true;
    branch_record record = branch_run(&scene.spec, m.periods, m.state, &options);
    saltus_motion_clear(&m);
    saltus_system_free(system);
    saltus_scene_clear(&scene);
    return record;
}

/* Where chatter stops completing each of its impacts becomes a return; the branch reports it and goes on. An
 * impact that dies leaves a maximum at first. */
static void chatter_that_ceases_to_complete_is_many_returns(void **unused) {
    (void)unused;
    branch_record record = branch_in_r("0.15", 0.01, 0.196);
    int changes = 0, told = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        int impacts, returns, impacts_after, returns_after;
        assert_true(p->impacts < 0 ? p->periods == 1 && !changes : p->periods >= p->impacts);
        told += strstr(p->reason, ", were 1 until") != NULL;
        if (p->kind == SALTUS_POINT_CH) {
            changes++;
            assert_string_equal(p->label, "chatter/1");
            assert_int_equal(sscanf(p->label_after, "%d/%d", &impacts, &returns), 2);
            assert_true(impacts > 3 && impacts == returns);
        }
        if (p->kind == SALTUS_POINT_GR) {
            assert_int_equal(sscanf(p->label, "%d/%d", &impacts, &returns), 2);
            assert_int_equal(sscanf(p->label_after, "%d/%d", &impacts_after, &returns_after), 2);
            assert_true(impacts_after == impacts - 1 && returns_after == returns && returns >= impacts);
        }
    }
    assert_true(changes == 1 && told == 1);
    branch_forget(&record);
}

/* Towards a homoclinic orbit of a saddle-focus folds accumulate, at almost the same states: they are not
 * taken for one fold to which the branch has returned. */
static void folds_near_a_homoclinic_orbit_are_many(void **unused) {
    (void)unused;
    static const char *const begins[] = {"0.12", "0.18"};
    skip_where_slow();
    for (int b = 0; b < 2; b++) {
        branch_record record = branch_in_r(begins[b], 0.01, 0.98);
        const saltus_branch_point *last = &record.point[record.count - 1];
        int folds = 0;
        for (int k = 0; k < record.count; k++)
            folds += record.point[k].kind == SALTUS_POINT_LP;
        assert_int_equal(last->kind, SALTUS_POINT_EP);
        assert_non_null(strstr(last->reason, "homoclinic"));
        assert_true(folds > 8 && last->period > 6 * record.point[0].period);
        branch_forget(&record);
    }
}

/* Rounding grows between prescribed impacts. Branches also begin after many in a row; here only the size
 * depends on F. */
static void branches_begin_at_many_impacts_in_a_row(void **unused) {
    (void)unused;
    static const char *const settings[] = {"F=1.2 z=0.489 c=1.016 b=0.188 g=0.134 r=0.588",
                                           "F=1.2 z=0.46 c=1.016 b=0.188 g=0.134 r=0.588", "F=1.2"};
    int longest = 0;
    for (int k = 0; k < 3; k++) {
        saltus_scene scene = bursting("lower", "x", settings[k]);
        saltus_system *system;
        saltus_motion m = settled(&scene, 1e-13, &system);
        saltus_branch_options options = branch_along("F", 1, 1.3);
        saltus_spec_set_omega(&scene.spec, 2 * M_PI / m.period);
        options.direction = 1;
        options.points = 30;
        options.orbit.free_period = true;
        branch_record record = branch_run(&scene.spec, m.periods, m.state, &options);
        assert_true(record.count >= 3);
        for (int j = 0; j < record.count; j++) {
            assert_string_equal(record.point[j].label, "chatter/1");
            check_near(record.point[j].period, m.period, 1e-8 * m.period);
        }
        int rising = 0;
        for (int j = 1; j < m.event_count; j++)
            rising += fabs(m.events[j].velocity_before) > fabs(m.events[j - 1].velocity_before);
        longest = rising > longest ? rising : longest;
        branch_forget(&record);
        saltus_motion_clear(&m);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
    assert_true(longest > 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chatter_is_one_return),
        cmocka_unit_test(returns_do_not_depend_on_the_begin),
        cmocka_unit_test(an_unstable_cycle_is_gone_around_in_pieces),
        cmocka_unit_test(chatter_that_ceases_to_complete_is_many_returns),
        cmocka_unit_test(folds_near_a_homoclinic_orbit_are_many),
        cmocka_unit_test(branches_begin_at_many_impacts_in_a_row),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
