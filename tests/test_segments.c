/* Multiple shooting: the number of segments of an orbit does not change the results. Folds, flips, tori,
 * pitchforks and grazings have the same places and multipliers, and the same branches are switched to.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"

/* The distance of two points' states. Of a pair of mirrored orbits either may be followed. */
static double apart(const saltus_branch_point *a, const saltus_branch_point *b) {
    saltus_system *system = build(&a->spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    double image[4], direct = 0, mirrored = 0;
    bool shift;
    memcpy(image, b->state, (size_t)b->dimension * sizeof *image);
    bool pair = saltus_system_mirror_symmetric(system, &shift) && a->parent >= 0;
    if (pair)
        check_ok(saltus_motion_mirror(system, &options, image, &message), &message);
    for (int k = 0; k < a->dimension; k++) {
        direct = fmax(direct, fabs(a->state[k] - b->state[k]));
        mirrored = fmax(mirrored, fabs(a->state[k] - image[k]));
    }
    saltus_system_free(system);
    return pair ? fmin(direct, mirrored) : direct;
}

/* Compare special points, requested values and ends: place, multipliers and state. Near grazing speeds, and
 * so multipliers, are ill-determined. */
static void check_same_points(const branch_record *one, const branch_record *other) {
    for (int i = 0, j = 0;; i++, j++) {
        while (i < one->count && one->point[i].kind == SALTUS_POINT_REGULAR)
            i++;
        while (j < other->count && other->point[j].kind == SALTUS_POINT_REGULAR)
            j++;
        if (i == one->count || j == other->count) {
            assert_int_equal(i, one->count);
            assert_int_equal(j, other->count);
            return;
        }
        const saltus_branch_point *a = &one->point[i], *b = &other->point[j];
        assert_int_equal(a->kind, b->kind);
        assert_int_equal(a->branch, b->branch);
        assert_int_equal(a->parent, b->parent);
        assert_int_equal(a->periods, b->periods);
        check_near(b->value[0], a->value[0], 1e-9);
        assert_string_equal(b->label, a->label);
        assert_string_equal(b->label_after, a->label_after);
        assert_string_equal(b->reason, a->reason);
        if (a->kind == SALTUS_POINT_GR || strncmp(a->reason, "joins", 5) == 0)
            continue;
        check_near(apart(a, b), 0, a->kind == SALTUS_POINT_UZ ? 1e-10 : 1e-5);
        for (int k = 0; k < a->dimension; k++) {
            check_near(b->multipliers[k].re, a->multipliers[k].re, 1e-5);
            check_near(fabs(b->multipliers[k].im), fabs(a->multipliers[k].im), 1e-5);
        }
    }
}

/* The same run with 1, 3 and 5 segments, and with an automatic number. */
static void check_segments(const saltus_spec *spec, int periods, const double *state,
                           saltus_branch_options options, const char *kinds) {
    static const int segments[] = {1, 3, 5, 0};
    branch_record first = {0};
    char found[128] = "";
    for (int k = 0; k < 4; k++) {
        options.orbit.segments = segments[k];
        branch_record record = branch_run(spec, periods, state, &options);
        if (k == 0) {
            first = record;
            continue;
        }
        check_same_points(&first, &record);
        branch_forget(&record);
    }
    for (int k = 0; k < first.count; k++)
        if (branch_special(&first.point[k]))
            strcat(strcat(found, saltus_point_word(first.point[k].kind)), " ");
    assert_string_equal(found, kinds);
    branch_forget(&first);
}

static void check_example(closed_example example, long double omega, double low, double high, int direction,
                          int switches, const char *kinds) {
    closed_oscillator o = closed_example_of(example);
    closed_orbit orbit;
    saltus_branch_options options = branch_along("omega", low, high);
    const double values[] = {low + 0.31 * (high - low), low + 0.77 * (high - low)};
    o.omega = omega;
    assert_true(closed_orbit_at(&o, 1, &orbit));
    saltus_spec spec = closed_spec(&o);
    double state[2] = {(double)orbit.state[0], (double)orbit.state[1]};
    options.switches = switches;
    options.direction = direction;
    options.values = values;
    options.value_count = 2;
    check_segments(&spec, o.periods, state, options, kinds);
}

static void folds_and_grazing(void **unused) {
    (void)unused;
    check_example(closed_one_period, 1.1L, 1, 1.8, 1, 0, "LP GR ");
    check_example(closed_two_periods, 0.85L, 0.79, 0.9, -1, 0, "LP GR ");
}

/* The branch of doubled period leads from one flip to the other, through two grazings, and is followed
 * once. */
static void flips_and_doubled_orbits(void **unused) {
    (void)unused;
    check_example(closed_two_periods, 0.85L, 0.8, 0.98, 1, 1, "PD PD GR GR PD ");
}

static void pitchforks(void **unused) {
    (void)unused;
    check_example(closed_mirrored, 3.6L, 2.65, 3.8, -1, 1, "BP PD ");
}

/* A mass thrown off a shaken table comes to rest on it again, by one impact without rebound or by complete
 * chatter: no orbit is cut while it rests, and cuts elsewhere change nothing. */
static void orbits_that_rest(void **unused) {
    (void)unused;
    for (int rebounds = 0; rebounds < 2; rebounds++) {
        saltus_spec spec = oscillator_spec(0, 0, rebounds ? 1.1 : 1.3, 1);
        set_parameter(&spec, "F0", -1);
        add_stop(&spec, 0, rebounds ? 0.3 : 0, SALTUS_LOWER);
        saltus_system *system = build(&spec);
        saltus_classify_options how = saltus_classify_defaults();
        saltus_message message = {.text = ""};
        saltus_motion motion;
        double state[2] = {0};
        check_ok(saltus_classify(system, state, &how, &motion, &message), &message);
        assert_string_equal(motion.label, rebounds ? "chatter/1" : "1/1");
        saltus_branch_options options = branch_along("F", rebounds ? 1.02 : 1.01, rebounds ? 1.3 : 3);
        const double values[] = {1.05, 1.2};
        options.values = values;
        options.value_count = 2;
        options.step_max = 0.05;
        check_segments(&spec, 1, motion.state, options, "");
        saltus_motion_clear(&motion);
        saltus_system_free(system);
    }
}

static void tori(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.035, 1, 1.1, 1.63);
    set_parameter(&spec, "N", 2);
    set_parameter(&spec, "k2", 1.7);
    set_parameter(&spec, "c2", 0.07);
    add_stop(&spec, 1, 0.7, SALTUS_UPPER);
    spec.stops[0].weight[0] = 0;
    spec.stops[0].weight[1] = 1;
    saltus_system *system = build(&spec);
    saltus_classify_options how = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double state[4] = {0};
    check_ok(saltus_classify(system, state, &how, &motion, &message), &message);
    assert_string_equal(motion.label, "1/2");
    check_segments(&spec, 2, motion.state, branch_along("omega", 1.51, 1.66), "PD NS NS ");
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(folds_and_grazing), cmocka_unit_test(flips_and_doubled_orbits),
        cmocka_unit_test(pitchforks),        cmocka_unit_test(tori),
        cmocka_unit_test(orbits_that_rest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
