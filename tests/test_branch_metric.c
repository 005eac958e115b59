/* The metric of branches. Arclength is the distance in parameter and state, in units of the parameter's range
 * and of the system's scale; steps are as long as requested; another unit of length or time changes only
 * lengths and times; a branch that returns is closed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_recount.h"

/* Two masses without stops: the unknowns are state and parameter alone. */
static saltus_spec free_masses(void) {
    saltus_spec spec = oscillator_spec(0.1, 1, 0.5, 1.3);
    set_parameter(&spec, "N", 2);
    set_parameter(&spec, "c2", 0.15);
    set_parameter(&spec, "F2", 0.2);
    return spec;
}

static void arclength_is_distance(void **unused) {
    (void)unused;
    saltus_spec spec = free_masses();
    saltus_system *system = build(&spec);
    const double *scale = saltus_system_scale(system);
    const double start[4] = {0};
    saltus_branch_options options = branch_along("omega", 0.9, 2.2);
    branch_record record = branch_run(&spec, 1, start, &options);
    for (int k = 1; k < record.count; k++) {
        const saltus_branch_point *a = &record.point[k - 1], *b = a + 1;
        if (a->branch != b->branch) {
            assert_true(a->heading < 0 || b->heading < 0);
            continue;
        }
        double square = pow((b->value[0] - a->value[0]) / (2.2 - 0.9), 2);
        for (int i = 0; i < 4; i++)
            square += pow((b->state[i] - a->state[i]) / scale[i], 2);
        double chord = sqrt(square), ahead = b->arclength - a->arclength;
        /* The step is measured along the tangent. */
        assert_true(ahead <= chord * (1 + 1e-9) && ahead >= 0.98 * chord - 1e-9);
        if (a->step == 0 && b->kind == SALTUS_POINT_REGULAR)
            check_near(ahead, options.step, 1e-12);
        assert_true(ahead <= options.step_max * (1 + 1e-12));
    }
    for (int branch = 0, k = 0; branch < 2; branch++) {
        while (record.point[k].branch != branch)
            k++;
        assert_true((branch ? -1 : 1) * record.point[k].heading > 0);
    }
    /* Where Newton's method converges easily the step grows to the largest, which sets the spacing of
     * points. */
    int longest = 0;
    for (int k = 1; k < record.count; k++)
        longest += fabs(record.point[k].arclength - record.point[k - 1].arclength - options.step_max) < 1e-12;
    assert_true(longest > 10);
    branch_forget(&record);
    options.step = 0.001;
    options.step_max = 0.004;
    options.direction = -1;
    options.points = 40;
    record = branch_run(&spec, 1, start, &options);
    assert_int_equal(record.count, 40);
    for (int k = 1; k < 40; k++) {
        double ahead = record.point[k].arclength - record.point[k - 1].arclength;
        check_near(ahead, fmin(0.001 * pow(1.5, k - 1), 0.004), 1e-12);
    }
    branch_forget(&record);
    saltus_system_free(system);
    /* With default steps. */
    options = saltus_branch_defaults();
    assert_true(options.step == 0.005 && options.step_max == 0.02 && options.points == 2000);
    assert_true(options.direction == 0 && options.switches == 0 && options.value_count == 0);
    assert_int_equal(options.locus, SALTUS_POINT_REGULAR);
}

/* The same oscillator in smaller units of length and time, by powers of two. */
static closed_oscillator in_other_units(closed_oscillator o, long double length, long double time) {
    o.d *= length;
    o.F *= length / (time * time);
    o.F0 *= length / (time * time);
    o.k /= time * time;
    o.c /= time;
    o.omega /= time;
    return o;
}

/* The factor of a parameter in these units. */
static double unit_of(const char *key, double length, double time) {
    return strcmp(key, "d") == 0   ? length
           : key[0] == 'F'         ? length / (time * time)
           : strcmp(key, "k") == 0 ? 1 / (time * time)
           : strcmp(key, "r") == 0 ? 1
                                   : 1 / time;
}

static branch_record run_units(closed_example example, long double omega, const char *key, double low,
                               double high, int switches, double length, double time,
                               saltus_branch_options *options) {
    closed_oscillator o = closed_example_of(example);
    closed_orbit orbit;
    o.omega = omega;
    o = in_other_units(o, length, time);
    assert_true(closed_orbit_at(&o, 1, &orbit));
    saltus_spec spec = closed_spec(&o);
    double state[2] = {(double)orbit.state[0], (double)orbit.state[1]}, unit = unit_of(key, length, time);
    *options = branch_along(key, unit * low, unit * high);
    options->orbit.flow.atol = 0;
    options->switches = switches;
    return branch_run(&spec, o.periods, state, options);
}

/* In a unit of length that is a power of two everything agrees to rounding. */
static void check_length(const branch_record *record, const branch_record *other, double length,
                         double unit) {
    assert_int_equal(other->count, record->count);
    for (int k = 0; k < record->count; k++) {
        const saltus_branch_point *a = &record->point[k], *b = &other->point[k];
        assert_int_equal(b->kind, a->kind);
        assert_int_equal(b->branch, a->branch);
        assert_int_equal(b->step, a->step);
        assert_string_equal(b->label, a->label);
        assert_string_equal(b->reason, a->reason);
        check_near(b->value[0] / unit, a->value[0], 1e-13);
        check_near(b->arclength, a->arclength, 1e-11);
        check_near(b->heading / unit, a->heading, 1e-11);
        for (int i = 0; i < 2; i++)
            check_near(b->state[i] / length, a->state[i], 1e-11);
        assert_true(isnan(a->accuracy) == isnan(b->accuracy));
        if (!isnan(a->accuracy))
            check_near(b->accuracy / unit, a->accuracy, 1e-9 * a->accuracy);
    }
}

/* In another unit of time Newton's method may need one more step; special points are the same. */
static void check_time(const branch_record *record, const branch_record *other, double length, double time,
                       double unit) {
    for (int branch = 0; branch < 4; branch++)
        for (int i = 0, j = 0;;) {
            const saltus_branch_point *a = branch_next_special(record, branch, &i);
            const saltus_branch_point *b = branch_next_special(other, branch, &j);
            assert_true(!a == !b);
            if (!a)
                break;
            assert_int_equal(b->kind, a->kind);
            assert_string_equal(b->label, a->label);
            check_near(b->value[0] / unit, a->value[0], 1e-9);
            check_near(b->arclength, a->arclength, 1e-3);
            check_near(b->state[0] / length, a->state[0], 1e-5);
            check_near(b->state[1] / length * time, a->state[1], 1e-5);
        }
}

static void check_units(closed_example example, long double omega, const char *key, double low, double high,
                        int switches) {
    static const double units[][2] = {{1024, 1}, {1.0 / 512, 1}, {64, 0.25}};
    saltus_branch_options options;
    branch_record record = run_units(example, omega, key, low, high, switches, 1, 1, &options);
    for (int u = 0; u < 3; u++) {
        double length = units[u][0], time = units[u][1], unit = unit_of(key, length, time);
        branch_record other = run_units(example, omega, key, low, high, switches, length, time, &options);
        if (time == 1)
            check_length(&record, &other, length, unit);
        else
            check_time(&record, &other, length, time, unit);
        branch_forget(&other);
    }
    branch_forget(&record);
}

/* The stated accuracy also has the parameter's unit. */
static void units_of_length_and_time(void **unused) {
    (void)unused;
    check_units(closed_one_period, 1.1L, "omega", 0.6, 1.8, 0);
    check_units(closed_one_period, 1.1L, "F", 0.2, 2, 0);
    check_units(closed_two_periods, 0.85L, "d", -0.5, 0.6, 0);
    check_units(closed_mirrored, 3.6L, "omega", 2.3, 4, 1);
}

/* Special points differ from the closed form by no more than the stated accuracy and rounding, and the
 * accuracy is small. */
static void accuracy_bounds_the_error(void **unused) {
    (void)unused;
    static const struct {
        closed_example example;
        long double omega;
        const char *key;
        double low, high;
    } rows[] = {{closed_one_period, 1.1L, "omega", 0.6, 1.8},
                {closed_two_periods, 0.85L, "d", -0.5, 0.6},
                {closed_mirrored_bubble, 1.2L, "omega", 1, 4},
                {closed_mirrored, 3.6L, "omega", 2.3, 4}};
    for (int row = 0; row < 4; row++) {
        saltus_branch_options options;
        branch_record record = run_units(rows[row].example, rows[row].omega, rows[row].key, rows[row].low,
                                         rows[row].high, 0, 1, 1, &options);
        double range = rows[row].high - rows[row].low;
        int compared = 0;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            if (!branch_special(p))
                continue;
            closed_oscillator o = closed_example_of(rows[row].example);
            closed_orbit orbit;
            o.omega = rows[row].omega;
            long double lo = p->value[0] - 1e-4L * range, hi = p->value[0] + 1.1e-4L * range;
            bool there = p->kind == SALTUS_POINT_LP   ? closed_fold(&o, rows[row].key, lo, hi, &orbit)
                         : p->kind == SALTUS_POINT_PD ? closed_flip(&o, rows[row].key, lo, hi, &orbit)
                         : p->kind == SALTUS_POINT_BP ? closed_pitchfork(&o, rows[row].key, lo, hi, &orbit)
                                                      : closed_grazing(&o, rows[row].key, lo, hi, &orbit);
            assert_true(p->accuracy >= 0 && p->accuracy < 1e-8 * range);
            if (!there)
                continue;
            double exact = (double)*closed_value(&orbit.oscillator, rows[row].key);
            check_near(p->value[0], exact, p->accuracy + 1e-13 * range);
            compared++;
        }
        assert_true(compared >= (row < 3 ? 2 : 1));
        branch_forget(&record);
    }
}

/* Orbits of two periods between two folds form a closed branch that is connected to no other: in any
 * direction it returns to its first point, and is then not followed the other way. */
static void an_island_is_closed(void **unused) {
    (void)unused;
    closed_oscillator o = {.c = 0.028L,
                           .k = 1,
                           .F = 0.325L,
                           .F0 = -0.545L,
                           .omega = 2.3L,
                           .d = 0.0475L,
                           .r = 0.72L,
                           .periods = 2};
    closed_orbit orbit, fold[2];
    assert_true(closed_orbit_at(&o, 1, &orbit) && orbit.admissible);
    assert_true(closed_fold(&o, "omega", 2, 2.2L, &fold[0]) && closed_fold(&o, "omega", 2.4L, 3, &fold[1]));
    saltus_spec spec = closed_spec(&o);
    double state[2] = {(double)orbit.state[0], (double)orbit.state[1]};
    for (int direction = -1; direction <= 1; direction++) {
        saltus_branch_options options = branch_along("omega", 1.8, 3.2);
        options.direction = direction;
        branch_record record = branch_run(&spec, 2, state, &options);
        const saltus_branch_point *last = &record.point[record.count - 1];
        int folds = 0;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            assert_int_equal(p->branch, 0);
            assert_string_equal(p->label, "1/2");
            if (p->kind == SALTUS_POINT_LP) {
                const closed_orbit *at = &fold[(folds == 0) == (direction >= 0)];
                check_near(p->value[0], (double)at->oscillator.omega, 1e-9);
                folds++;
            }
        }
        assert_int_equal(folds, 2);
        assert_int_equal(last->kind, SALTUS_POINT_EP);
        assert_non_null(strstr(last->reason, "closed"));
        check_near(last->value[0], 2.3, 1e-12);
        check_near(last->state[0], record.point[0].state[0], 1e-8);
        check_near(last->state[1], record.point[0].state[1], 1e-8);
        recount_run(&record, &options, 10);
        branch_forget(&record);
    }
}

/* A start on the range's border has nowhere to go one way; a value requested there is still reported. */
static void start_on_the_border(void **unused) {
    (void)unused;
    saltus_spec spec = free_masses();
    const double start[4] = {0}, values[] = {1.3, 1.31};
    for (int up = 0; up < 2; up++) {
        saltus_branch_options options = branch_along("omega", up ? 1.25 : 1.3, up ? 1.3 : 1.35);
        options.values = values;
        options.value_count = 2;
        branch_record record = branch_run(&spec, 1, start, &options);
        int wanted[2][2] = {{0}}, count[2] = {0}, ends = 0;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            count[p->branch]++;
            ends += p->kind == SALTUS_POINT_EP;
            for (int v = 0; v < 2; v++)
                wanted[p->branch][v] += p->kind == SALTUS_POINT_UZ && fabs(p->value[0] - values[v]) < 1e-12;
            if (p->kind == SALTUS_POINT_EP)
                check_near(p->value[0], p->branch ? options.low[0] : options.high[0], 1e-12);
        }
        assert_int_equal(ends, 2);
        /* The blocked way: the first point, the value there, the end. */
        assert_int_equal(count[up ? 0 : 1], 3);
        assert_true(count[up ? 1 : 0] > 3);
        assert_int_equal(wanted[0][0], 1);
        assert_int_equal(wanted[1][0], 1);
        assert_int_equal(wanted[0][1], !up);
        assert_int_equal(wanted[1][1], 0);
        branch_forget(&record);
    }
}

/* A branch that leaves the range ends on its border to the last bit, in the reported value and in the
 * parameters. */
static void borders_are_met_to_the_last_bit(void **unused) {
    (void)unused;
    enum { ranges = 60 };
    saltus_spec spec = free_masses();
    const double start[4] = {0};
    unsigned long long seed = 11;
    double number[2];
    for (int k = 0; k < ranges; k++) {
        for (int j = 0; j < 2; j++) {
            seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
            number[j] = (double)(seed >> 11) * 0x1p-53;
        }
        double F = saltus_spec_get(&spec, "F");
        /* Near zero, values are more closely spaced than unknowns. */
        saltus_branch_options options = branch_along("F", 1e-3 * F * number[0], F * (1 + number[1]));
        options.step = options.step_max = 0.5;
        branch_record record = branch_run(&spec, 1, start, &options);
        int ends = 0;
        for (int j = 0; j < record.count; j++) {
            const saltus_branch_point *p = &record.point[j];
            double bound = p->branch ? options.low[0] : options.high[0];
            if (p->kind != SALTUS_POINT_EP)
                continue;
            ends++;
            assert_true(p->value[0] == bound);
            assert_true(saltus_spec_get(&p->spec, "F") == bound);
        }
        assert_int_equal(ends, 2);
        branch_forget(&record);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arclength_is_distance),     cmocka_unit_test(units_of_length_and_time),
        cmocka_unit_test(accuracy_bounds_the_error), cmocka_unit_test(an_island_is_closed),
        cmocka_unit_test(start_on_the_border),       cmocka_unit_test(borders_are_met_to_the_last_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
