/* Branches of many kinds, recounted: impacts on one stop and on two, chatter, sticking, contacts that last,
 * two masses, orbits of twice the period. What branch.h says of each point is found anew by other means.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_recount.h"

/* A run from what a trajectory settles on. */
static branch_record run_settled(const saltus_spec *spec, const saltus_branch_options *options,
                                 const char *label) {
    saltus_system *system = build(spec);
    saltus_classify_options how = saltus_classify_defaults();
    saltus_message message = {""};
    saltus_motion motion;
    double state[SALTUS_SCENE_STATE_MAX];
    check_ok(saltus_system_default_state(system, state, &message), &message);
    check_ok(saltus_classify(system, state, &how, &motion, &message), &message);
    assert_string_equal(motion.label, label);
    int periods = motion.periods > 0 ? motion.periods : 1;
    branch_record record = branch_run(spec, periods, motion.state, options);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    return record;
}

static branch_record run_example(closed_example example, long double omega, saltus_branch_options *options) {
    closed_oscillator o = closed_example_of(example);
    closed_orbit orbit;
    o.omega = omega;
    assert_true(closed_orbit_at(&o, 1, &orbit) && orbit.admissible);
    saltus_spec spec = closed_spec(&o);
    double state[2] = {(double)orbit.state[0], (double)orbit.state[1]};
    return branch_run(&spec, o.periods, state, options);
}

static void one_stop_and_doubled_orbits(void **unused) {
    (void)unused;
    saltus_branch_options options = branch_along("omega", 0.6, 1.8);
    options.switches = 1;
    branch_record record = run_example(closed_one_period, 1.1L, &options);
    recount_run(&record, &options, 5);
    branch_forget(&record);
    options = branch_along("omega", 0.78, 1.1);
    options.switches = 2;
    record = run_example(closed_two_periods, 0.85L, &options);
    recount_run(&record, &options, 5);
    branch_forget(&record);
}

/* Impacts on both stops; beyond the pitchfork orbits that are not mirrored. */
static void two_stops_of_one_mass(void **unused) {
    (void)unused;
    saltus_branch_options options = branch_along("omega", 1, 4);
    options.switches = 1;
    branch_record record = run_example(closed_mirrored_bubble, 1.2L, &options);
    recount_run(&record, &options, 8);
    branch_forget(&record);
    options = branch_along("omega", 2.3, 4);
    options.switches = 1;
    record = run_example(closed_mirrored, 3.6L, &options);
    recount_run(&record, &options, 8);
    branch_forget(&record);
}

/* Orbits of two masses, one of which hits a stop, lose their stability to tori. */
static saltus_spec two_masses(void) {
    saltus_spec spec = oscillator_spec(0.035, 1, 1.1, 1.63);
    set_parameter(&spec, "N", 2);
    set_parameter(&spec, "k2", 1.7);
    set_parameter(&spec, "c2", 0.07);
    add_stop(&spec, 1, 0.7, SALTUS_UPPER);
    spec.stops[0].weight[0] = 0;
    spec.stops[0].weight[1] = 1;
    return spec;
}

static void two_masses_and_tori(void **unused) {
    (void)unused;
    saltus_spec spec = two_masses();
    saltus_branch_options options = branch_along("omega", 1.5, 1.7);
    options.switches = 1;
    branch_record record = run_settled(&spec, &options, "1/2");
    recount_run(&record, &options, 6);
    int tori = 0;
    for (int k = 0; k < record.count; k++)
        tori += record.point[k].kind == SALTUS_POINT_NS;
    assert_int_equal(tori, 2);
    branch_forget(&record);
    /* In other parameters too, those of stop, second mass and Maxwell element among them. */
    set_parameter(&spec, "kz", 0.1);
    const char *keys[] = {"k2", "c2", "m", "m2", "d", "r", "kz", "tz"};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) {
        saltus_direction direction;
        saltus_message message = {""};
        double value;
        check_ok(saltus_spec_direction(&spec, keys[k], &direction, &value, &message), &message);
        options = branch_along(keys[k], 0.97 * value, 1.02 * value);
        options.direction = k % 2 ? 1 : -1;
        options.points = 12;
        record = run_settled(&spec, &options, "1/2");
        recount_run(&record, &options, 4);
        branch_forget(&record);
    }
}

/* The ball on the table stays for part of each period where the table's acceleration lets it: without
 * rebound, and by complete chatter. */
static void contacts_that_begin_and_end(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 0, 1.3, 1);
    set_parameter(&spec, "F0", -1);
    add_stop(&spec, 0, 0, SALTUS_LOWER);
    saltus_branch_options options = branch_along("F", 1.01, 3);
    branch_record record = run_settled(&spec, &options, "1/1");
    recount_run(&record, &options, 4);
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        assert_true(p->event_count == 2 && p->stable && p->sticking_intervals == 1);
        for (int i = 0; i < 2; i++)
            assert_true(p->multipliers[i].re == 0 && p->multipliers[i].log_modulus == -INFINITY);
        for (int i = 0; i < 2; i++)
            if (p->events[i].kind == SALTUS_RELEASE) /* F cos t = 1, in falling */
                check_near(2 * M_PI * p->events[i].time.phase, 2 * M_PI - acos(1 / p->value[0]), 1e-9);
    }
    branch_forget(&record);
    spec.stops[0].r = 0.5;
    set_parameter(&spec, "F", 1.025);
    options = branch_along("F", 1.01, 1.5);
    record = run_settled(&spec, &options, "chatter/1");
    recount_run(&record, &options, 4);
    branch_forget(&record);
}

/* A mass pressed to its stop stays there until the force has a zero, then leaves it once a period; farther on
 * the chatter is complete no longer, and the impacts die one by one. */
static void held_until_the_force_vanishes(void **unused) {
    (void)unused;
    static const struct {
        const char *key;
        double low, high, at;
    } rows[] = {{"F", 0.1, 1.5, 1}, {"d", 0.1, 1.9, 1.5}, {"F0", 1.2, 2.2, 1.5}, {"k", 0.5, 1.8, 1.5}};
    for (int row = 0; row < 4; row++) {
        saltus_spec spec = oscillator_spec(0.1, 1, 0.5, 1);
        set_parameter(&spec, "F0", 2);
        add_stop(&spec, 1, 0.5, SALTUS_UPPER);
        saltus_branch_options options = branch_along(rows[row].key, rows[row].low, rows[row].high);
        options.direction = row == 2 ? -1 : 1;
        branch_record record = run_settled(&spec, &options, "held");
        recount_run(&record, &options, 9);
        int from = 0;
        const saltus_branch_point *point = branch_next_special(&record, 0, &from);
        assert_true(point && point->kind == SALTUS_POINT_CH);
        check_near(point->value[0], rows[row].at, 1e-10);
        assert_string_equal(point->label, "held");
        assert_string_equal(point->label_after, "chatter/1");
        branch_forget(&record);
    }
}

/* Chatter that is complete ceases to be so, and impacts that grow in number complete chatter, in one and the
 * same place. */
static void chatter_ends_where_it_begins(void **unused) {
    (void)unused;
    double value[2];
    for (int up = 0; up < 2; up++) {
        saltus_spec spec = oscillator_spec(0.1, 1, 0.5, 1);
        set_parameter(&spec, "F0", 2);
        add_stop(&spec, up ? 1.67 : 1.8104, 0.7, SALTUS_UPPER);
        saltus_branch_options options = branch_along("d", 1.66, 1.82);
        options.direction = up ? 1 : -1;
        options.points = up ? 30 : 2000;
        branch_record record = run_settled(&spec, &options, up ? "chatter/1" : "3/1");
        int found = 0;
        bool chatter = up;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            bool one = strcmp(p->label, "chatter/1") == 0;
            if (p->kind == SALTUS_POINT_CH) {
                assert_true(one == chatter && (strcmp(p->label_after, "chatter/1") == 0) != chatter);
                assert_true(p->accuracy < 1e-9);
                value[up] = p->value[0];
                chatter = !chatter;
                found++;
            } else if (p->kind == SALTUS_POINT_REGULAR) {
                assert_int_equal(one, chatter);
                assert_int_equal(p->impacts < 0, chatter);
                assert_int_equal(p->sticking_intervals, chatter);
                assert_true(p->admissible);
            }
        }
        assert_int_equal(found, 1);
        branch_forget(&record);
    }
    check_near(value[0], value[1], 1e-9);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_stop_and_doubled_orbits),   cmocka_unit_test(two_stops_of_one_mass),
        cmocka_unit_test(two_masses_and_tori),           cmocka_unit_test(contacts_that_begin_and_end),
        cmocka_unit_test(held_until_the_force_vanishes), cmocka_unit_test(chatter_ends_where_it_begins),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
