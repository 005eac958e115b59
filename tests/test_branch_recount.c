/* Branches of many kinds, recounted: impacts on one stop and on two, chatter, sticking, lasting contacts, two
 * masses, orbits of twice the period. All that branch.h says of a point is computed again by other means.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_recount.h"

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

/* Impacts on both stops, and asymmetric orbits beyond the pitchfork. */
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
    branch_record record = branch_run_settled(&spec, &options, "1/2");
    recount_run(&record, &options, 6);
    int tori = 0;
    for (int k = 0; k < record.count; k++)
        tori += record.point[k].kind == SALTUS_POINT_NS;
    assert_int_equal(tori, 2);
    branch_forget(&record);
    /* Also in other parameters, of the stop, the second mass and the Maxwell element. */
    set_parameter(&spec, "kz", 0.1);
    const char *keys[] = {"k2", "c2", "m", "m2", "d", "r", "kz", "tz"};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) {
        saltus_direction direction;
        saltus_message message = {.text = ""};
        double value;
        check_ok(saltus_spec_direction(&spec, keys[k], &direction, &value, &message), &message);
        options = branch_along(keys[k], 0.97 * value, 1.02 * value);
        options.direction = k % 2 ? 1 : -1;
        options.points = 12;
        record = branch_run_settled(&spec, &options, "1/2");
        recount_run(&record, &options, 4);
        branch_forget(&record);
    }
}

/* The ball stays on the table for the part of each period in which the table's acceleration allows it:
 * without rebound, and by complete chatter. */
static void contacts_that_begin_and_end(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 0, 1.3, 1);
    set_parameter(&spec, "F0", -1);
    add_stop(&spec, 0, 0, SALTUS_LOWER);
    saltus_branch_options options = branch_along("F", 1.01, 3);
    branch_record record = branch_run_settled(&spec, &options, "1/1");
    recount_run(&record, &options, 4);
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        assert_true(p->event_count == 2 && p->stable && p->sticking_intervals == 1);
        for (int i = 0; i < 2; i++)
            assert_true(p->multipliers[i].re == 0 && p->multipliers[i].log_modulus == -INFINITY);
        for (int i = 0; i < 2; i++)
            if (p->events[i].kind == SALTUS_RELEASE) /* F cos t = 1, falling */
                check_near(2 * M_PI * p->events[i].time.phase, 2 * M_PI - acos(1 / p->value[0]), 1e-9);
    }
    branch_forget(&record);
    spec.stops[0].r = 0.5;
    set_parameter(&spec, "F", 1.025);
    options = branch_along("F", 1.01, 1.5);
    record = branch_run_settled(&spec, &options, "chatter/1");
    recount_run(&record, &options, 4);
    branch_forget(&record);
}

static double parameter_of(const saltus_spec *spec, const char *name) {
    return spec->parameters[saltus_model_parameter_index(spec->model, name)];
}

/* The least force between a mass and its stop in the scenes of held_until_the_force_vanishes: the steady
 * force less those of the spring and the forcing. */
static double least_force(const saltus_spec *spec) {
    return parameter_of(spec, "F0") - parameter_of(spec, "k") * spec->stops[0].d -
           fabs(parameter_of(spec, "F"));
}

/* Only points in permanent contact have a least force; it vanishes where the contact is released. Returns how
 * many such points there are. */
static int check_least_forces(const branch_record *record) {
    int held = 0;
    for (int k = 0; k < record->count; k++) {
        const saltus_branch_point *p = &record->point[k];
        bool lasts = strcmp(p->label, "held") == 0;
        if (lasts != !isnan(p->contact_force) && p->label_after[0] == 0)
            fail_msg("row %d is %s, with a least force of %g", k, p->label, p->contact_force);
        if (!isnan(p->contact_force))
            check_near(p->contact_force, p->kind == SALTUS_POINT_CH ? 0 : least_force(&p->spec), 1e-10);
        held += lasts;
    }
    return held;
}

/* A mass pressed to its stop stays there until the force has a zero, then leaves it once a period. Farther on
 * the chatter is no longer complete, and the impacts die one by one. */
static void held_until_the_force_vanishes(void **unused) {
    (void)unused;
    static const struct {
        const char *key;
        double low, high, at;
    } rows[] = {{"F", 0.1, 1.5, 1},   {"d", 0.1, 1.9, 1.5},     {"F0", 1.2, 2.2, 1.5}, {"k", 0.5, 1.8, 1.5},
                {"m", 0.5, 1.9, NAN}, {"omega", 0.5, 1.9, NAN}, {"F", 0, 0.9, NAN}};
    for (int row = 0; row < 7; row++) {
        saltus_spec spec = oscillator_spec(0.1, 1, 0.5, 1);
        set_parameter(&spec, "F0", 2);
        add_stop(&spec, 1, 0.5, SALTUS_UPPER);
        saltus_branch_options options = branch_along(rows[row].key, rows[row].low, rows[row].high);
        options.direction = row == 2 || row == 6 ? -1 : 1;
        branch_record record = branch_run_settled(&spec, &options, "held");
        recount_run(&record, &options, 9);
        assert_true(check_least_forces(&record) > 10);
        int from = 0;
        /* It is never released, up to where the force is constant. */
        if (isnan(rows[row].at)) {
            assert_null(branch_next_special(&record, 0, &from));
            branch_forget(&record);
            continue;
        }
        const saltus_branch_point *point = branch_next_special(&record, 0, &from);
        assert_true(point && point->kind == SALTUS_POINT_CH);
        check_near(point->value[0], rows[row].at, 1e-10);
        assert_string_equal(point->label, "held");
        assert_string_equal(point->label_after, "chatter/1");
        branch_forget(&record);
    }
}

/* The way back: flights shrink to nothing and leave a permanent contact, with which the branch goes on, also
 * where a step ends on a flight so short that its impacts have no speed but rounding. */
static void contacts_that_become_permanent(void **unused) {
    (void)unused;
    static const struct {
        const char *key;
        double from, end, at, r, high, step;
    } rows[] = {{"F", 1.1, 0.1, 1, 0.5, 1.2, 0.02},
                {"d", 1, 0.1, 0.9, 0.5, 1.2, 0.02},
                {"k", 1, 0.3, 0.9, 0.5, 1.2, 0.02},
                {"F", 1.1, 0.1, 1, 0, 1.2, 0.02},
                {"F", 1.1, 0.1, 1, 0.5, 3, 0.01}};
    for (int row = 0; row < 5; row++) {
        saltus_spec spec = oscillator_spec(0.1, 1, 1.1, 1);
        set_parameter(&spec, "F0", 2);
        add_stop(&spec, 1, rows[row].r, SALTUS_UPPER);
        saltus_branch_options options = branch_along(rows[row].key, rows[row].end, rows[row].high);
        options.step_max = rows[row].step;
        options.direction = -1;
        branch_record record = branch_run_settled(&spec, &options, rows[row].r > 0 ? "chatter/1" : "1/1");
        recount_run(&record, &options, 5);
        int from = 0, held = 0;
        const saltus_branch_point *point = branch_next_special(&record, 0, &from);
        assert_true(point && point->kind == (rows[row].r > 0 ? SALTUS_POINT_CH : SALTUS_POINT_ST));
        check_near(point->value[0], rows[row].at, 1e-10);
        assert_string_equal(point->label_after, "held");
        assert_null(branch_next_special(&record, 0, &from));
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            bool lasts = strcmp(p->label, "held") == 0;
            held += lasts;
            if (p->kind == SALTUS_POINT_REGULAR)
                assert_true(p->admissible && lasts == (p->value[0] < rows[row].at));
        }
        assert_true(held > 10);
        check_least_forces(&record);
        check_near(record.point[record.count - 1].value[0], rows[row].end, 0);
        branch_forget(&record);
    }
}

/* The last value of a parameter's domain is reached even if the equations are singular there - without a
 * spring to the support nothing holds the masses in place - and if the range goes on beyond it. */
static void domains_are_reached(void **unused) {
    (void)unused;
    static const struct {
        const char *key, *label;
        double end;
        int masses;
        double beyond;
    } rows[] = {{"k", "0/1", 0, 1, 0},   {"c", "0/1", 0, 1, -0.1}, {"k", "1/1", 0, 2, 0},
                {"c", "1/1", 0, 2, 0},   {"c2", "1/1", 0, 2, 0},   {"k2", "1/1", 0, 2, 0},
                {"r", "1/1", 1, 2, 0.5}, {"r", "1/1", 0, 2, -1},   {"r", "2/1", 1, 0, 0}};
    for (size_t row = 0; row < sizeof rows / sizeof rows[0]; row++) {
        int masses = rows[row].masses;
        saltus_spec spec = oscillator_spec(0.1, 1, masses ? 0.5 : 1, masses == 2 ? 1.6 : 1);
        add_stop(&spec, masses == 2 ? 0.3 : masses ? 20 : 2, 0.8, masses ? SALTUS_UPPER : SALTUS_BOTH);
        if (masses == 2) {
            set_parameter(&spec, "N", 2);
            set_parameter(&spec, "c2", 0.1);
            spec.stops[0].weight[1] = -1;
        } else if (masses == 0) {
            set_parameter(&spec, "c", 0);
            set_parameter(&spec, "k", 0);
        }
        bool up = rows[row].end > 0;
        saltus_branch_options options = branch_along(rows[row].key, up ? 0.7 : 0, up ? 1 : 1.1);
        *(up ? options.high : options.low) += rows[row].beyond;
        options.direction = up ? 1 : -1;
        branch_record record = branch_run_settled(&spec, &options, rows[row].label);
        recount_run(&record, &options, 8);
        const saltus_branch_point *last = &record.point[record.count - 1];
        /* Without a spring between the masses the impact dies in this very place, where orbits without
         * impacts form a family. */
        bool family = strcmp(rows[row].key, "k2") == 0 && strstr(last->reason, "form a family");
        assert_true(family || strstr(last->reason, rows[row].beyond ? "domain: " : "parameter's range"));
        check_near(last->value[0], rows[row].end, family ? 1e-11 : 0);
        saltus_direction direction;
        saltus_message message = {.text = ""};
        double value;
        check_ok(saltus_spec_direction(&last->spec, rows[row].key, &direction, &value, &message), &message);
        check_near(value, rows[row].end, family ? 1e-11 : 1e-15);
        branch_forget(&record);
    }
}

/* A free mass between two walls that leaves the lower wall without speed where the force turns, at omega t =
 * -pi/2: x = t + pi/2 - d - cos t. Its first impact on the upper wall is at `time`, with `speed`. */
static void first_impact(long double d, long double *time, long double *speed) {
    const long double half = acosl(0);
    long double t = half;
    for (int k = 0; k < 60; k++)
        t -= (t + half - 2 * d - cosl(t)) / (1 + sinl(t));
    *time = t;
    *speed = 1 + sinl(t);
}

/* s - sin s without cancellation. */
static long double less_sine(long double s) {
    long double term = s * s * s / 6, sum = 0;
    for (int k = 4; k < 40; k += 2) {
        sum += term;
        term *= -s * s / (k * (k + 1));
    }
    return sum;
}

/* Whether the impacts after the first one end before the force turns away from the wall, at a time `left`
 * after each. A flight that leaves the wall with speed u is back where u s = sin(left) (1 - cos s) -
 * cos(left) (s - sin s), which happens once before the turn or never. */
static bool comes_to_rest(long double t, long double speed, long double r) {
    long double left = acosl(0) - t;
    for (long double u = r * speed; u > 1e-30L;) {
        long double low = 0, high = left, s = left;
        for (int k = 0; k < 100; k++) {
            long double sine = sinl(s / 2), pressed = 2 * sinl(left) * sine * sine;
            bool away = u * s > pressed - cosl(left) * less_sine(s);
            if (k == 0 && away)
                return false;
            *(away ? &low : &high) = s;
            s = 0.5L * (low + high);
        }
        u = r * (sinl(left) * sinl(s) - 2 * cosl(left) * sinl(s / 2) * sinl(s / 2) - u);
        left -= s;
    }
    return true;
}

/* The value of r or d, between `low` and `high`, at which that ends; at `low` they come to rest. */
static double end_of_rest(long double *parameter, long double low, long double high, const long double *d,
                          const long double *r) {
    long double time, speed;
    for (int k = 0; k < 60; k++) {
        *parameter = 0.5L * (low + high);
        first_impact(*d, &time, &speed);
        *(comes_to_rest(time, speed, *r) ? &low : &high) = *parameter;
    }
    return (double)low;
}

/* On walls with little rebound impacts are born within 1e-5 of a period of one another: chatter completes,
 * and the branch goes on to r = 0. Up to there the mass leaves its wall where the force turns, whatever the
 * restitution. */
static void until_nothing_rebounds(void **unused) {
    (void)unused;
    const long double d = 1.5L;
    long double r = 0;
    double exact = end_of_rest(&r, 7e-4L, 9e-4L, &d, &r);
    saltus_spec spec = oscillator_spec(0, 0, 1, 1);
    add_stop(&spec, (double)d, 0.8, SALTUS_BOTH);
    saltus_branch_options options = branch_along("r", 0, 1);
    options.direction = -1;
    branch_record record = branch_run_settled(&spec, &options, "2/1");
    int completes = 0, after = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        if (p->kind == SALTUS_POINT_CH) {
            check_near(p->value[0], exact, p->accuracy);
            assert_true(p->accuracy < 1e-11);
            completes++;
        } else if (completes) {
            assert_string_equal(p->label, p->value[0] > 0 ? "chatter/1" : "2/1");
            check_near(p->state[0], (double)(acosl(0) - d - 1), 1e-9);
            check_near(p->state[1], 1, 1e-9);
            after++;
        }
    }
    const saltus_branch_point *last = &record.point[record.count - 1];
    assert_true(completes == 1 && after > 2);
    assert_true(last->value[0] == 0 && last->spec.stops[0].r == 0);
    assert_string_equal(last->reason, "end of the parameter's range");
    branch_forget(&record);
}

/* As the walls approach each other impacts are born one after the other, until rounding hides the next:
 * chatter completes where the births accumulate, and the branch goes on until the walls meet. */
static void until_the_walls_meet(void **unused) {
    (void)unused;
    skip_where_slow();
    const long double r = 0.8L;
    long double d = 0;
    double exact = end_of_rest(&d, 0.023L, 0.0232L, &d, &r);
    saltus_spec spec = oscillator_spec(0, 0, 1, 1);
    add_stop(&spec, 1.5, 0.8, SALTUS_BOTH);
    saltus_branch_options options = branch_along("d", 0, 2);
    options.direction = -1;
    options.step_max = 0.1;
    branch_record record = branch_run_settled(&spec, &options, "2/1");
    int completes = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        if (p->kind == SALTUS_POINT_CH) {
            check_near(p->value[0], exact, p->accuracy);
            assert_true(p->accuracy < 1e-11);
            completes++;
        }
    }
    assert_int_equal(completes, 1);
    check_near(record.point[record.count - 1].value[0], 0, 1e-12);
    assert_non_null(strstr(record.point[record.count - 1].reason, "domain: d = 0: must be greater than 0"));
    branch_forget(&record);
}

/* The pipe's motion is as large as the room that the stop leaves: without room there is none, but the branch
 * leads there. */
static void until_there_is_no_room(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(2, 20);
    add_stop(&spec, 0.02, 0.9, SALTUS_UPPER);
    saltus_branch_options options = branch_along("d", 0, 0.03);
    options.direction = -1;
    branch_record record = branch_run_settled(&spec, &options, "1/1");
    const saltus_branch_point *last = &record.point[record.count - 1];
    assert_true(last->value[0] == 0 && fabs(last->state[0]) < 1e-8);
    assert_string_equal(last->reason, "end of the parameter's range");
    branch_forget(&record);
}

/* A range may end where the orbits have no derivative by the parameter; the reason says so. */
static void domains_without_a_derivative(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(1, 10);
    set_parameter(&spec, "u0", 2);
    saltus_branch_options options = branch_along("beta", 0, 0.7);
    options.direction = -1;
    branch_record record = branch_run_settled(&spec, &options, "0/1");
    const saltus_branch_point *last = &record.point[record.count - 1];
    check_near(last->value[0], 0, 1e-12);
    assert_non_null(strstr(last->reason, "beta = 0"));
    assert_non_null(strstr(last->reason, "no derivative"));
    branch_forget(&record);
}

/* Two masses, one of which hits two stops: tori and flips come in pairs, within one step, each time an impact
 * dies. */
static void tori_beside_flips(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1736, 1, 1.123, 0.9818);
    set_parameter(&spec, "N", 2);
    set_parameter(&spec, "m2", 1.105);
    set_parameter(&spec, "c2", 0.137);
    set_parameter(&spec, "k2", 1.22);
    add_stop(&spec, 0.89922, 0.881, SALTUS_UPPER);
    add_stop(&spec, 0.48966, 0.48, SALTUS_LOWER);
    for (int k = 0; k < 2; k++) {
        spec.stops[k].weight[0] = 0;
        spec.stops[k].weight[1] = 1;
    }
    saltus_branch_options options = branch_along("k2", 1.1, 1.6);
    options.direction = 1;
    branch_record record = branch_run_settled(&spec, &options, "chatter/1");
    recount_run(&record, &options, 20);
    int tori = 0, flips = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        if (p->kind == SALTUS_POINT_GR && p->impacts < 15 && p->impacts > 3)
            assert_true(tori == 1 && flips >= 1);
        tori = p->kind == SALTUS_POINT_GR ? 0 : tori + (p->kind == SALTUS_POINT_NS);
        flips = p->kind == SALTUS_POINT_GR ? 0 : flips + (p->kind == SALTUS_POINT_PD);
    }
    branch_forget(&record);
}

/* A ball on a table: where complete chatter ends as the restitution grows, the branch goes on to ever fewer
 * impacts, one by one, and not back. */
static void a_branch_leaves_chatter(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 0, 1.2, 1);
    set_parameter(&spec, "F0", -1);
    add_stop(&spec, 0, 0.6, SALTUS_LOWER);
    saltus_branch_options options = branch_along("r", 0.5, 1);
    options.direction = 1;
    branch_record record = branch_run_settled(&spec, &options, "chatter/1");
    long long fewest = 1000;
    int ends = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        ends += p->kind == SALTUS_POINT_CH;
        assert_null(strstr(p->reason, "come back to this CH"));
        if (p->kind == SALTUS_POINT_REGULAR && p->impacts > 0)
            fewest = p->impacts < fewest ? p->impacts : fewest;
        if (p->kind == SALTUS_POINT_GR)
            assert_true(llabs(p->impacts - atoll(p->label_after)) == 1);
    }
    assert_int_equal(ends, 1);
    assert_true(fewest < 12);
    check_near(record.point[record.count - 1].value[0], 1, 0);
    assert_string_equal(record.point[record.count - 1].reason, "end of the parameter's range");
    branch_forget(&record);
}

/* Ever closer grazings are not taken for the same one. */
static void grazings_close_together(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_spec spec = pipe_spec(1, 29.374);
    set_parameter(&spec, "alpha", 0.00809);
    set_parameter(&spec, "u0", 4.742);
    set_parameter(&spec, "sigma", 0.302);
    add_stop(&spec, 0.01591, 0.423, SALTUS_UPPER);
    saltus_branch_options options = branch_along("u0", 3.79, 5.69);
    options.direction = -1;
    branch_record record = branch_run_settled(&spec, &options, "chatter/7");
    int born = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        born += p->kind == SALTUS_POINT_GR && strcmp(p->reason, "an impact dies") != 0;
        if (strstr(p->reason, "has come back to this"))
            recount_closure(&record, k);
    }
    assert_true(born >= 3);
    branch_forget(&record);
}

/* The branch of asymmetric orbits ends at the pitchfork of the symmetric ones. */
static void pitchforks_from_both_branches(void **unused) {
    (void)unused;
    static const struct {
        closed_example example;
        long double omega;
        double low, high;
    } rows[] = {{closed_mirrored_bubble, 1.2L, 1, 4}, {closed_mirrored, 3.6L, 2.3, 4}};
    int joins = 0;
    for (int row = 0; row < 2; row++) {
        saltus_branch_options options = branch_along("omega", rows[row].low, rows[row].high);
        options.switches = 1;
        branch_record record = run_example(rows[row].example, rows[row].omega, &options);
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            closed_oscillator o = closed_example_of(rows[row].example);
            closed_orbit orbit;
            if (p->kind != SALTUS_POINT_BP)
                continue;
            o.omega = rows[row].omega;
            assert_true(closed_pitchfork(&o, "omega", p->value[0] - 1e-4L, p->value[0] + 1.1e-4L, &orbit));
            check_near(p->value[0], (double)orbit.oscillator.omega, 1e-10);
            joins += p->parent >= 0;
        }
        branch_forget(&record);
    }
    assert_true(joins >= 1);
}

/* Chatter stops being complete at the same place where, on the way back, growing numbers of impacts complete
 * it. */
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
        branch_record record = branch_run_settled(&spec, &options, up ? "chatter/1" : "3/1");
        int found = 0;
        bool chatter = up;
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *p = &record.point[k];
            bool one = strcmp(p->label, "chatter/1") == 0;
            if (p->kind == SALTUS_POINT_CH) {
                assert_true(one == chatter && (strcmp(p->label_after, "chatter/1") == 0) != chatter);
                assert_true(p->accuracy < 1e-10);
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
    check_near(value[0], value[1], 1e-11);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_stop_and_doubled_orbits),
        cmocka_unit_test(two_stops_of_one_mass),
        cmocka_unit_test(two_masses_and_tori),
        cmocka_unit_test(contacts_that_begin_and_end),
        cmocka_unit_test(held_until_the_force_vanishes),
        cmocka_unit_test(chatter_ends_where_it_begins),
        cmocka_unit_test(contacts_that_become_permanent),
        cmocka_unit_test(domains_are_reached),
        cmocka_unit_test(until_nothing_rebounds),
        cmocka_unit_test(until_the_walls_meet),
        cmocka_unit_test(until_there_is_no_room),
        cmocka_unit_test(domains_without_a_derivative),
        cmocka_unit_test(tori_beside_flips),
        cmocka_unit_test(grazings_close_together),
        cmocka_unit_test(a_branch_leaves_chatter),
        cmocka_unit_test(pitchforks_from_both_branches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
