/* Branches of periodic orbits: all special points of the closed forms and no others, branch switching, the
 * pipe's branches with each point checked by other means, and how a run works.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"
#include "reference.h"

#include <stdlib.h>

/* An oscillator with an orbit to start from, and the range of a parameter. */
typedef struct closed_case {
    closed_example example;
    long double omega;
    int sheet;
    const char *key;
    double lo, hi;
} closed_case;

/* Orbits with one impact in one or two periods. */
static const closed_case one_stop[] = {
    {closed_one_period, 1.1L, 1, "omega", 0.6, 1.8},
    {closed_one_period, 1.1L, 1, "F", 0.1, 2},
    {closed_one_period, 1.1L, 1, "k", 0.5, 2.2},
    {closed_one_period, 1.1L, 1, "c", 0.01, 0.6},
    {closed_one_period, 0.98L, 1, "r", 0.2, 0.99},
    {closed_one_period, 0.98L, 1, "c", 0.01, 0.6},
    {closed_one_period, 0.98L, 1, "F", 0.1, 2},
    {closed_one_period, 1.5L, 1, "d", 0.3, 3},
    {closed_one_period, 1.5L, -1, "d", 0.3, 3},
    {closed_one_period, 1.5L, 1, "r", 0.2, 0.99},
    {closed_one_period, 1.5L, 1, "c", 0.01, 0.6},
    {closed_one_period, 1.5L, 1, "k", 0.5, 2.2},
    {closed_one_period_loaded, 1.2L, 1, "omega", 0.8, 1.9},
    {closed_one_period_loaded, 1.2L, 1, "d", 0.3, 3},
    {closed_one_period_loaded, 1.2L, 1, "F", 0.1, 2},
    {closed_one_period_loaded, 1.2L, 1, "c", 0.01, 0.6},
    {closed_one_period_loaded, 1.2L, 1, "k", 0.5, 2.2},
    {closed_one_period_loaded, 1.12L, 1, "r", 0.2, 0.99},
    {closed_two_periods, 0.85L, 1, "omega", 0.78, 1.1},
    {closed_two_periods, 0.85L, 1, "d", -0.5, 0.6},
    {closed_two_periods, 0.85L, 1, "F", 0.1, 2},
    {closed_two_periods, 0.85L, 1, "F0", -1.5, -0.7},
    {closed_two_periods, 0.85L, 1, "c", 0.01, 0.6},
    {closed_two_periods, 0.85L, 1, "k", 0.5, 2.2},
    {closed_two_periods, 0.93L, 1, "r", 0.2, 0.99},
    {closed_two_periods_light, 0.85L, 1, "omega", 0.78, 1.1},
    {closed_two_periods_light, 0.85L, 1, "d", -0.5, 0.6},
    {closed_two_periods_light, 0.85L, 1, "k", 0.5, 2.2},
};

/* Mirrored orbits between two stops. */
static const closed_case two_stops[] = {
    {closed_mirrored, 3.6L, 1, "omega", 2.3, 4},
    {closed_mirrored, 3.6L, 1, "d", 0.3, 3},
    {closed_mirrored, 3.6L, 1, "F", 1, 11},
    {closed_mirrored, 3.52L, 1, "r", 0.2, 0.99},
    {closed_mirrored, 3.52L, 1, "c", 0.01, 0.6},
    {closed_mirrored, 3.52L, 1, "k", 0.5, 2.2},
    {closed_mirrored_bubble, 1.2L, 1, "omega", 1, 4},
    {closed_mirrored_bubble, 1.2L, 1, "d", 0.3, 3},
    {closed_mirrored_bubble, 1.2L, 1, "r", 0.2, 0.99},
    {closed_mirrored_bubble, 1.2L, 1, "k", 0.5, 2.2},
    {closed_mirrored_bubble, 2.5L, -1, "F", 0.5, 12},
};

static closed_oscillator oscillator_of(const closed_case *c) {
    closed_oscillator o = closed_example_of(c->example);
    o.omega = c->omega;
    return o;
}

/* A branch from a closed orbit. */
static branch_record run_closed(const closed_oscillator *o, int sheet, const saltus_branch_options *options) {
    closed_orbit orbit;
    assert_true(closed_orbit_at(o, sheet, &orbit) && orbit.admissible);
    saltus_spec spec = closed_spec(o);
    double state[2] = {(double)orbit.state[0], (double)orbit.state[1]};
    return branch_run(&spec, o->periods, state, options);
}

/* Shift an orbit with one impact to begin a period later. */
static void begin_later(closed_orbit *orbit) {
    const closed_oscillator *o = &orbit->oscillator;
    long double state[2];
    closed_after(o, &orbit->impact[0], state);
    closed_flight(o, orbit->impact[0].time, state, closed_period(o), orbit->state);
}

static double apart(const closed_orbit *orbit, const saltus_branch_point *point) {
    return hypot(point->state[0] - (double)orbit->state[0], point->state[1] - (double)orbit->state[1]);
}

/* Of the closed orbits at the point's parameter, begun at any period, the one with the nearest state. */
static closed_orbit nearest_orbit(closed_oscillator o, const char *key, const saltus_branch_point *point) {
    closed_orbit orbit, nearest = {.impacts = 0};
    double distance = INFINITY;
    *closed_value(&o, key) = point->value[0];
    for (int sheet = -1; sheet <= 1; sheet += 2) {
        bool there = closed_orbit_at(&o, sheet, &orbit);
        for (int period = 0; period < o.periods && there; period++) {
            if (period)
                begin_later(&orbit);
            if (apart(&orbit, point) < distance)
                nearest = orbit;
            distance = fmin(distance, apart(&orbit, point));
        }
    }
    return nearest;
}

static void check_closed_multiplier(const saltus_multiplier *mu, const long double *exact, double tolerance) {
    double size = (double)hypotl(exact[0], exact[1]);
    check_near(mu->re, (double)exact[0], tolerance * (1 + size * size));
    check_near(fabs(mu->im), (double)fabsl(exact[1]), tolerance * (1 + size * size));
}

/* State, multipliers, label and admissibility of a regular point. */
static void check_regular(const closed_oscillator *o, const char *key, const saltus_branch_point *point) {
    closed_orbit orbit = nearest_orbit(*o, key, point);
    for (int i = 0; i < 2; i++) {
        check_near(point->state[i], (double)orbit.state[i], 1e-9);
        check_closed_multiplier(&point->multipliers[i], orbit.multiplier[i], 1e-6);
    }
    assert_true(orbit.admissible);
    assert_true(point->admissible);
    assert_int_equal(point->impacts, orbit.impacts);
    assert_int_equal(point->periods, o->periods);
    long double modulus = hypotl(orbit.multiplier[0][0], orbit.multiplier[0][1]);
    if (fabsl(modulus - 1) > 1e-6L)
        assert_int_equal(point->stable, modulus < 1);
}

/* Time in periods to the nearest of the times t + k T. */
static double phase_apart(const closed_oscillator *o, long double t, double periods) {
    return (double)remainderl(t / closed_period(o) - periods, 1);
}

/* Whether the touch reported at a grazing is that of the closed orbit: at an impact without speed, or at a
 * turning point between impacts. The orbit may begin with any of its periods. */
static bool touches_as(const closed_special *expected, const saltus_branch_point *point) {
    const closed_orbit *orbit = &expected->orbit;
    const closed_oscillator *o = &orbit->oscillator;
    for (int i = 0; i < orbit->impacts; i++) {
        long double end = i + 1 < orbit->impacts ? orbit->impact[i + 1].time
                                                 : orbit->impact[0].time + o->periods * closed_period(o);
        closed_turn turn = {.time = orbit->impact[i].time, .side = orbit->impact[i].side};
        if (expected->touch)
            turn = closed_flight_turn(o, &orbit->impact[i], end);
        if (point->grazing_side == turn.side && fabs(phase_apart(o, turn.time, point->grazing_time)) < 1e-8)
            return true;
    }
    return false;
}

/* At the touch the displacement has a maximum at the stop: followed from the point's state through the
 * earlier impacts. */
static void check_touch(const closed_oscillator *o, const saltus_branch_point *point) {
    long double x[2] = {point->state[0], point->state[1]}, rate[2], time = 0,
                end = point->grazing_time * closed_period(o);
    assert_int_equal(point->grazing_stop, 1);
    assert_true(point->grazing_time >= 0 && point->grazing_time < point->periods);
    for (int k = 0; k < point->event_count; k++) {
        long double next = saltus_time_periods(point->events[k].time) * closed_period(o);
        if (next > end - 1e-7L)
            break;
        closed_flight(o, time, x, next, x);
        x[1] *= -o->r;
        time = next;
    }
    closed_flight(o, time, x, end, x);
    closed_field(o, end, x, rate);
    check_near((double)(x[0] - point->grazing_side * o->d), 0, 1e-9);
    check_near((double)(x[1] / rate[1]), 0, 1e-8);
    assert_true(rate[1] * point->grazing_side < 0);
}

/* Value, multipliers and label of a special point up to and including the first grazing. */
static void check_special(const closed_oscillator *o, const saltus_branch_point *point,
                          const closed_special *expected) {
    char label[SALTUS_LABEL_MAX];
    if (!point || point->kind != expected->kind)
        fail_msg("%s at %.12g instead of %s at %.12Lg", point ? saltus_point_word(point->kind) : "nothing",
                 point ? point->value[0] : NAN, saltus_point_word(expected->kind), expected->value);
    check_near(point->value[0], (double)expected->value, 1e-9);
    snprintf(label, sizeof label, "%d/%d", o->mirrored ? 2 : 1, o->periods);
    assert_string_equal(point->label, label);
    assert_int_equal(isnan(point->grazing_time), point->kind != SALTUS_POINT_GR);
    if (point->kind == SALTUS_POINT_GR) {
        if (!touches_as(expected, point))
            fail_msg("the touch at %.12g T is not that of the closed orbit", point->grazing_time);
        check_touch(&expected->orbit.oscillator, point);
        return;
    }
    assert_true(point->grazing_stop == 0 && point->grazing_side == 0);
    check_near(point->multipliers[0].re, point->kind == SALTUS_POINT_PD ? -1 : 1, 1e-7);
    check_near(point->multipliers[0].im, 0, 1e-7);
    check_closed_multiplier(&point->multipliers[1], expected->orbit.multiplier[1], 1e-7);
}

/* An orbit with p = 1 that loses its last impact becomes the free response, up to the range's end. */
static void check_free_response(const closed_oscillator *start, const char *key,
                                const saltus_branch_point *point) {
    closed_oscillator o = *start;
    long double state[2];
    *closed_value(&o, key) = point->value[0];
    closed_steady(&o, 0, state);
    double modulus = (double)(-o.c * closed_period(&o) / 2);
    assert_string_equal(point->label, "0/1");
    assert_true(point->admissible && point->stable);
    for (int i = 0; i < 2; i++) {
        check_near(point->state[i], (double)state[i], 1e-9);
        check_near(point->multipliers[i].log_modulus, modulus, 1e-8);
    }
}

/* What lies beyond a grazing. */
static void check_beyond(const closed_oscillator *o, const char *key, const branch_record *record, int from,
                         const closed_special *grazing) {
    const saltus_branch_point *point = &record->point[from - 1];
    if (grazing->touch) {
        assert_string_equal(point->label_after, o->mirrored ? "4/1" : "2/2");
    } else if (o->periods == 1) {
        assert_string_equal(point->label_after, "0/1");
        for (int k = from; k < record->count && record->point[k].branch == point->branch; k += 8)
            check_free_response(o, key, &record->point[k]);
    } else {
        assert_true(from < record->count);
        assert_int_equal(record->point[from].kind, SALTUS_POINT_EP);
        assert_non_null(strstr(record->point[from].reason, "half the period"));
    }
}

/* Along one way of a branch, exactly the special points of the closed form are found, in order. */
static void check_way(const closed_oscillator *o, int sheet, const char *key, const branch_record *record,
                      int branch, const double *range) {
    closed_special expected[closed_specials_max];
    closed_oscillator start = *o;
    closed_place place = {*closed_value(&start, key), sheet, branch == 0 ? 1 : -1};
    int count = closed_walk(&start, key, range[0], range[1], &place, expected), found = 0, k = 0;
    for (; k < record->count; k++) {
        const saltus_branch_point *point = &record->point[k];
        if (point->branch != branch || point->kind == SALTUS_POINT_EP)
            continue;
        if (point->kind == SALTUS_POINT_REGULAR && k % 4 == 0)
            check_regular(o, key, point);
        if (!branch_special(point))
            continue;
        if (found == count)
            fail_msg("%s at %.12g is no special point", saltus_point_word(point->kind), point->value[0]);
        check_special(o, point, &expected[found++]);
        if (point->kind == SALTUS_POINT_GR) {
            check_beyond(o, key, record, k + 1, &expected[found - 1]);
            break;
        }
    }
    if (found < count)
        check_special(o, NULL, &expected[found]);
}

static void check_both_ways(const closed_oscillator *o, int sheet, const saltus_branch_options *options,
                            const branch_record *record) {
    const double range[2] = {options->low[0], options->high[0]};
    for (int branch = 0; branch < 2; branch++)
        check_way(o, sheet, options->key[0], record, branch, range);
}

static void check_closed(const closed_oscillator *o, int sheet, const char *key, double lo, double hi) {
    saltus_branch_options options = branch_along(key, lo, hi);
    branch_record record = run_closed(o, sheet, &options);
    check_both_ways(o, sheet, &options, &record);
    branch_forget(&record);
}

static void points_of_one_stop(void **unused) {
    (void)unused;
    for (size_t i = 0; i < sizeof one_stop / sizeof one_stop[0]; i += long_version() ? 1 : 2) {
        closed_oscillator o = oscillator_of(&one_stop[i]);
        check_closed(&o, one_stop[i].sheet, one_stop[i].key, one_stop[i].lo, one_stop[i].hi);
    }
}

/* Also all points where mirrored orbits lose their symmetry. */
static void points_of_two_stops(void **unused) {
    (void)unused;
    for (size_t i = 0; i < sizeof two_stops / sizeof two_stops[0]; i++) {
        closed_oscillator o = oscillator_of(&two_stops[i]);
        check_closed(&o, two_stops[i].sheet, two_stops[i].key, two_stops[i].lo, two_stops[i].hi);
    }
}

/* Special points lie where the literature has them, and branches pass through all of them. */
static void literature_points(void **unused) {
    (void)unused;
    static const struct {
        long double omega, start;
        saltus_point_kind kind;
        double value;
    } rows[] = {{0.81L, 0.36L, SALTUS_POINT_PD, 0.3475333974123},
                {0.799L, 0.37L, SALTUS_POINT_LP, 0.3628362019809},
                {0.80089L, 0.365L, SALTUS_POINT_PD, 0.3600268471098},
                {0.799741L, 0.3625L, SALTUS_POINT_LP, 0.3618288199778}};
    for (int k = 0; k < 4; k++) {
        closed_oscillator o = {.c = 0.04L,
                               .k = 1,
                               .F = rows[k].start,
                               .F0 = -1,
                               .omega = rows[k].omega,
                               .r = 0.9L,
                               .periods = 2};
        saltus_branch_options options = branch_along("F", 0.33, 0.45);
        branch_record record = run_closed(&o, 1, &options);
        check_both_ways(&o, 1, &options, &record);
        int from = 0;
        const saltus_branch_point *point = branch_next_special(&record, 1, &from);
        assert_non_null(point);
        assert_int_equal(point->kind, rows[k].kind);
        check_near(point->value[0], rows[k].value, 1e-9);
        branch_forget(&record);
    }
}

/* The mirror image of an oscillator, plus a stop that is never reached before its own: touches are on the
 * other side of the second stop, at the same times. */
static void touches_of_the_image(void **unused) {
    (void)unused;
    closed_oscillator o = closed_example_of(closed_two_periods);
    closed_orbit orbit;
    int touches = 0;
    o.omega = 0.85L;
    assert_true(closed_orbit_at(&o, 1, &orbit) && orbit.admissible);
    saltus_branch_options options = branch_along("omega", 0.78, 1.1);
    branch_record record = run_closed(&o, 1, &options);
    saltus_spec image = oscillator_spec((double)o.c, (double)o.k, -(double)o.F, (double)o.omega);
    set_parameter(&image, "F0", -(double)o.F0);
    add_stop(&image, 50, 0.3, SALTUS_BOTH);
    add_stop(&image, (double)o.d, (double)o.r, SALTUS_LOWER);
    double state[2] = {-(double)orbit.state[0], -(double)orbit.state[1]};
    branch_record mirrored = branch_run(&image, o.periods, state, &options);
    for (int branch = 0, i = 0, j = 0; branch < 2; branch++, i = j = 0) {
        const saltus_branch_point *a = branch_next_special(&record, branch, &i),
                                  *b = branch_next_special(&mirrored, branch, &j);
        for (; a && b;
             a = branch_next_special(&record, branch, &i), b = branch_next_special(&mirrored, branch, &j)) {
            assert_int_equal(a->kind, b->kind);
            if (a->kind != SALTUS_POINT_GR)
                continue;
            assert_true(a->grazing_stop == 1 && a->grazing_side == 1);
            assert_true(b->grazing_stop == 2 && b->grazing_side == -1);
            check_near(remainder(a->grazing_time - b->grazing_time, a->periods), 0, 1e-8);
            touches++;
        }
        assert_true(!a && !b);
    }
    assert_true(touches >= 2);
    branch_forget(&record);
    branch_forget(&mirrored);
}

/* COCO's hybrid demo: from A = 0.5 down there is a fold just below the grazing, and the free response beyond.
 */
static void demo_of_grazing(void **unused) {
    (void)unused;
    closed_oscillator o = {.c = 0.1L, .k = 1, .F = 0.5L, .omega = 1, .d = 1, .r = 0.8L, .periods = 1};
    check_closed(&o, 1, "F", 0.05, 1);
    saltus_branch_options options = branch_along("F", 0.05, 1);
    options.direction = -1;
    branch_record record = run_closed(&o, 1, &options);
    const saltus_point_kind kinds[] = {SALTUS_POINT_LP, SALTUS_POINT_GR};
    const double values[] = {0.099970753628, 0.1};
    for (int k = 0, from = 0; k < 2; k++) {
        const saltus_branch_point *point = branch_next_special(&record, 0, &from);
        assert_true(point && point->kind == kinds[k]);
        check_near(point->value[0], values[k], 1e-12);
    }
    for (int k = 0; k < record.count; k++)
        assert_true(record.point[k].admissible || branch_special(&record.point[k]));
    branch_forget(&record);
}

/* Budd & Dux: the fold in the stop's place. */
static void undamped_fold(void **unused) {
    (void)unused;
    for (int n = 1; n <= 2; n++) {
        closed_oscillator o = {.k = 1, .F = 1, .omega = 2.8L, .r = 0.8L, .periods = n};
        double fold = (double)fabsl(closed_undamped_fold(n, o.omega, o.r)) * (n == 1 ? -1 : 1);
        o.d = 0.6L * fold;
        double ends[2] = {1.1 * fold, 0.4 * fold};
        saltus_branch_options options = branch_along("d", fmin(ends[0], ends[1]), fmax(ends[0], ends[1]));
        check_closed(&o, 1, "d", options.low[0], options.high[0]);
        options.direction = n == 1 ? -1 : 1;
        branch_record record = run_closed(&o, 1, &options);
        int from = 0;
        const saltus_branch_point *point = branch_next_special(&record, 0, &from);
        assert_true(point && point->kind == SALTUS_POINT_LP);
        check_near(point->value[0], fold, 1e-9);
        branch_forget(&record);
    }
}

/* Without damping multipliers of motion without impacts stay on the unit circle and never cross it. */
static void undamped_motion_has_no_tori(void **unused) {
    (void)unused;
    const double omega = 1.6, state[2] = {1 / (1 - omega * omega), 0};
    saltus_spec spec = oscillator_spec(0, 1, 1, omega);
    add_stop(&spec, 5, 0.8, SALTUS_BOTH);
    for (int k = 0; k < 2; k++) {
        saltus_branch_options options = branch_along("omega", 1.2, 2.3);
        options.step = options.step_max = k ? 0.005 : 0.02;
        branch_record record = branch_run(&spec, 1, state, &options);
        assert_true(record.count > 50);
        for (int j = 0; j < record.count; j++)
            assert_true(record.point[j].kind != SALTUS_POINT_NS);
        branch_forget(&record);
    }
}

/* The ball on the table: orbits of k periods begin at a fold and flip as the table's acceleration grows. */
static void vibrating_table(void **unused) {
    (void)unused;
    for (int k = 1; k <= 2; k++) {
        double fold = (double)closed_table_fold(k, 0.5L), flip = (double)closed_table_flip(k, 0.5L);
        closed_table closed;
        assert_true(closed_table_orbit(k, 0.5L, 0.7L * fold + 0.3L * flip, 1, &closed));
        saltus_spec spec = oscillator_spec(0, 0, 0.7 * fold + 0.3 * flip, 1);
        set_parameter(&spec, "F0", -1);
        add_stop(&spec, 0, 0.5, SALTUS_LOWER);
        double state[2] = {(double)closed.state[0], (double)closed.state[1]};
        saltus_branch_options options = branch_along("F", 0.9 * fold, 1.05 * flip);
        branch_record record = branch_run(&spec, k, state, &options);
        int from = 0, back = 0;
        const saltus_branch_point *up = branch_next_special(&record, 0, &from);
        const saltus_branch_point *down = branch_next_special(&record, 1, &back);
        assert_true(up && up->kind == SALTUS_POINT_PD);
        check_near(up->value[0], flip, 1e-9);
        check_near(up->multipliers[0].re, -1, 1e-7);
        check_near(up->multipliers[1].re, -0.25, 1e-7);
        assert_null(branch_next_special(&record, 0, &from));
        assert_true(down && down->kind == SALTUS_POINT_LP);
        check_near(down->value[0], fold, 1e-9);
        check_near(down->multipliers[0].re, 1, 1e-7);
        for (int i = 0; i < record.count; i++)
            assert_true(record.point[i].admissible || branch_special(&record.point[i]));
        branch_forget(&record);
    }
}

static int first_of_branch(const branch_record *record, int branch) {
    int k = 0;
    while (k < record->count && record->point[k].branch != branch)
        k++;
    return k;
}

static const saltus_branch_point *last_of_branch(const branch_record *record, int branch) {
    const saltus_branch_point *last = NULL;
    for (int k = 0; k < record->count; k++)
        if (record->point[k].branch == branch)
            last = &record->point[k];
    return last;
}

/* The end point of a branch, and its reason. */
static void check_ends(const branch_record *record, int branch, const char *why, double value,
                       double tolerance) {
    const saltus_branch_point *last = last_of_branch(record, branch);
    if (!last || last->kind != SALTUS_POINT_EP || !strstr(last->reason, why)) {
        fail_msg("branch %d ends: \"%s\", not \"%s\"", branch, last ? last->reason : "it is not there", why);
        return;
    }
    check_near(last->value[0], value, tolerance);
}

/* The branch that leaves at a value of the parameter; -1: none. */
static int branch_from(const branch_record *record, double value) {
    for (int k = 0; k < record->count; k++) {
        const saltus_branch_point *point = &record->point[k];
        if (point->parent >= 0 && point->step == 0 && fabs(point->value[0] - value) < 1e-9)
            return point->branch;
    }
    return -1;
}

/* No special point is passed twice: a branch does not run back over itself. */
static void check_no_return(const branch_record *record, int branch) {
    for (int i = first_of_branch(record, branch); i < record->count; i++)
        for (int j = i + 1; j < record->count; j++) {
            const saltus_branch_point *a = &record->point[i], *b = &record->point[j];
            double far = fabs(a->value[0] - b->value[0]);
            if (a->branch != branch || b->branch != branch || !branch_special(a) || a->kind != b->kind ||
                far > 1e-9)
                continue;
            for (int n = 0; n < a->dimension; n++)
                far = fmax(far, fabs(a->state[n] - b->state[n]));
            if (far < 1e-6)
                fail_msg("branch %d passes %s at %.12g again", branch, saltus_point_word(a->kind),
                         a->value[0]);
        }
}

/* A branch of twice the period leads from one flip to another point, where it joins orbits of a `share` of
 * the period. */
static void check_doubled(const branch_record *record, const saltus_branch_point *flip, double end,
                          const char *share) {
    int number = branch_from(record, flip->value[0]);
    if (number < 0)
        fail_msg("no branch leaves at the flip at %.12g", flip->value[0]);
    const saltus_branch_point *first = &record->point[first_of_branch(record, number)];
    assert_int_equal(first->parent, flip->branch);
    assert_int_equal(first->periods, 2 * flip->periods);
    assert_int_equal(first->impacts, 2 * flip->impacts);
    for (int i = 0; i < first->dimension; i++)
        check_near(first->state[i], flip->state[i], 1e-6);
    check_no_return(record, number);
    check_ends(record, number, share, end, 1e-9);
}

static void check_flips_joined(closed_example example) {
    closed_oscillator o = closed_example_of(example);
    saltus_branch_options options = branch_along("omega", 0.78, 1.1);
    const saltus_branch_point *flip[2];
    o.omega = 0.85L;
    options.switches = 1;
    branch_record record = run_closed(&o, 1, &options);
    for (int k = 0, from = 0; k < 2; k++) {
        flip[k] = branch_next_special(&record, 0, &from);
        assert_true(flip[k] && flip[k]->kind == SALTUS_POINT_PD);
    }
    check_doubled(&record, flip[0], flip[1]->value[0], "half the period");
    if (branch_from(&record, flip[1]->value[0]) >= 0)
        check_doubled(&record, flip[1], flip[0]->value[0], "half the period");
    branch_forget(&record);
}

/* The branch of twice the period leads from one flip to the next. */
static void flips_are_joined(void **unused) {
    (void)unused;
    check_flips_joined(closed_two_periods);
}

static void flips_are_joined_with_light_damping(void **unused) {
    (void)unused;
    check_flips_joined(closed_two_periods_light);
}

/* Orbits beyond a touch, with two impacts in two periods, end at a flip of the orbits with one impact in one
 * period, which they join. */
static void touched_orbits_join(void **unused) {
    (void)unused;
    for (int light = 0; light < 2; light++) {
        closed_oscillator o = closed_example_of(light ? closed_two_periods_light : closed_two_periods),
                          half = o;
        closed_orbit flip;
        half.periods = 1;
        assert_true(closed_flip(&half, "omega", 0.98L, 0.9985L, &flip) && flip.admissible);
        saltus_branch_options options = branch_along("omega", 0.78, 1.1);
        options.direction = 1;
        o.omega = 0.85L;
        branch_record record = run_closed(&o, 1, &options);
        check_no_return(&record, 0);
        check_ends(&record, 0, "half the period", (double)flip.oscillator.omega, 1e-9);
        branch_forget(&record);
    }
}

/* Section C of the literature: from the flip near grazing the orbits of twice the period lead to that
 * grazing. */
static void flip_near_grazing(void **unused) {
    (void)unused;
    closed_oscillator o = {.c = 0.04L, .k = 1, .F = 0.36L, .F0 = -1, .omega = 0.81L, .r = 0.9L, .periods = 2};
    saltus_branch_options options = branch_along("F", 0.33, 0.45);
    int from = 0;
    options.switches = 1;
    branch_record record = run_closed(&o, 1, &options);
    const saltus_branch_point *flip = branch_next_special(&record, 1, &from);
    assert_true(flip && flip->kind == SALTUS_POINT_PD);
    check_doubled(&record, flip, 0.345422885750, "a quarter of the period");
    branch_forget(&record);
}

/* How far a point's state is from the nearer one of the pair of asymmetric orbits. */
static double apart_from_pair(const closed_orbit *pitchfork, const saltus_branch_point *point) {
    double nearest = INFINITY;
    for (int side = -1; side <= 1; side += 2) {
        closed_orbit orbit;
        if (closed_pair_at(pitchfork, "omega", side, point->value[0], &orbit))
            nearest = fmin(nearest, apart(&orbit, point));
    }
    return nearest;
}

/* Where the mirror symmetry breaks, a branch of asymmetric orbits leaves; these flip, and gain an impact. */
static void pair_of_orbits(void **unused) {
    (void)unused;
    closed_oscillator o = closed_example_of(closed_mirrored);
    closed_orbit pitchfork, flip, touch;
    assert_true(closed_pitchfork(&o, "omega", 3.4L, 3.6L, &pitchfork));
    assert_true(closed_pair_flip(&pitchfork, "omega", 1, &flip));
    assert_true(closed_pair_touch(&pitchfork, "omega", 1, &touch));
    saltus_branch_options options = branch_along("omega", 2.3, 4);
    options.switches = 1;
    o.omega = 3.6L;
    branch_record record = run_closed(&o, 1, &options);
    int number = 2, k = first_of_branch(&record, number), compared = 0;
    assert_true(k < record.count);
    assert_int_equal(record.point[k].parent, 1);
    for (int i = k + 6; i < record.count && record.point[i].kind != SALTUS_POINT_GR; i++) {
        if (i % 9)
            continue;
        check_near(apart_from_pair(&pitchfork, &record.point[i]), 0, 1e-9);
        assert_true(record.point[i].admissible);
        compared++;
    }
    assert_true(compared > 3);
    const saltus_branch_point *point = branch_next_special(&record, number, &k);
    assert_true(point && point->kind == SALTUS_POINT_PD);
    check_near(point->value[0], (double)flip.oscillator.omega, 1e-9);
    point = branch_next_special(&record, number, &k);
    assert_true(point && point->kind == SALTUS_POINT_GR);
    check_near(point->value[0], (double)touch.oscillator.omega, 1e-9);
    assert_string_equal(point->label, "2/1");
    assert_string_equal(point->label_after, "3/1");
    branch_forget(&record);
}

/* The pipe has no closed form, so every point is checked by other means. */

static branch_record run_reference(const char *name, int section, const saltus_branch_options *options) {
    reference r = read_reference(name);
    return branch_run(&r.spec, r.periods, r.states[section], options);
}

static double scaled_distance(const saltus_system *system, const double *a, const double *b) {
    const double *scale = saltus_system_scale(system);
    double largest = 0;
    for (int i = 0; i < saltus_system_dimension(system); i++)
        largest = fmax(largest, fabs(a[i] - b[i]) / scale[i]);
    return largest;
}

/* A disturbed state that is beyond no stop. */
static void disturb(const saltus_system *system, const double *state, double *disturbed) {
    const double size = 1e-7;
    int n = saltus_system_dimension(system);
    for (int sign = 1; sign >= -1; sign -= 2) {
        for (int i = 0; i < n; i++)
            disturbed[i] = state[i] * (1 + sign * size * (i % 2 ? -0.7 : 1));
        if (saltus_system_check_state(system, disturbed, NULL) == SALTUS_OK)
            return;
    }
}

/* How many periods a disturbed trajectory has to settle. */
static long long patience(void) {
    return long_version() ? 20000 : 400;
}

/* What a trajectory from near a state settles on (its label), and how far that is from the state. */
static double settle(const saltus_system *system, const double *state, long long transient, char *label) {
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double start[SALTUS_SCENE_STATE_MAX], nearest = INFINITY;
    disturb(system, state, start);
    options.transient = transient;
    /* A motion without a period is near no orbit; its exponent, which takes minutes, is not needed. */
    options.measure = 0;
    check_ok(saltus_classify(system, start, &options, &motion, &message), &message);
    snprintf(label, SALTUS_LABEL_MAX, "%s", motion.label);
    for (int k = 0; k < motion.periods; k++)
        nearest = fmin(nearest, scaled_distance(system, motion.section_states + k * motion.dimension, state));
    saltus_motion_clear(&motion);
    return nearest;
}

/* A disturbed trajectory settles on the stable orbit, with the same label. */
static void check_settles(const saltus_branch_point *point) {
    char label[SALTUS_LABEL_MAX];
    saltus_system *system = build(&point->spec);
    double distance = settle(system, point->state, patience(), label);
    if (!(distance < 1e-8) || strcmp(label, point->label) != 0)
        fail_msg("%s at %.12g settles on %s, %.3g away", point->label, point->value[0], label, distance);
    saltus_system_free(system);
}

/* The same for the orbit found at a parameter a little aside. Returns whether there is a stable one nearby;
 * its label is one of the point's two. */
static bool settles_beside(const saltus_branch_point *point, const char *key, double aside) {
    saltus_direction direction;
    saltus_message message = {.text = ""};
    saltus_orbit orbit;
    char label[SALTUS_LABEL_MAX];
    check_ok(saltus_spec_direction(&point->spec, key, &direction, NULL, &message), &message);
    saltus_spec spec = saltus_spec_shifted(&point->spec, &direction, aside);
    saltus_system *system = build(&spec);
    saltus_orbit_options options = saltus_orbit_defaults();
    bool stable =
        saltus_orbit_find(system, point->periods, point->state, &options, &orbit, &message) == SALTUS_OK;
    if (stable)
        stable =
            scaled_distance(system, orbit.state, point->state) < 0.2 && orbit.multipliers[0].log_modulus < 0;
    if (stable) {
        double distance = settle(system, orbit.state, patience(), label);
        bool known = strcmp(label, point->label) == 0 || strcmp(label, point->label_after) == 0;
        if (!(distance < 1e-7) || !known)
            fail_msg("beside %s at %.12g: settles on %s, %.3g away", saltus_point_word(point->kind),
                     point->value[0], label, distance);
    }
    saltus_orbit_clear(&orbit);
    saltus_system_free(system);
    return stable;
}

/* Beyond a fold, where the branch is not, a trajectory goes elsewhere; that may be nearby, to an orbit with
 * other impacts on another part of the branch. */
static void check_leaves(const saltus_branch_point *point, const char *key, double aside) {
    saltus_direction direction;
    saltus_message message = {.text = ""};
    char label[SALTUS_LABEL_MAX];
    check_ok(saltus_spec_direction(&point->spec, key, &direction, NULL, &message), &message);
    saltus_spec spec = saltus_spec_shifted(&point->spec, &direction, aside);
    saltus_system *system = build(&spec);
    double distance = settle(system, point->state, 1500, label);
    if (distance < 1e-2 && strcmp(label, point->label) == 0)
        fail_msg("beyond the fold at %.12g an orbit %s is %.3g away", point->value[0], label, distance);
    saltus_system_free(system);
}

/* The flow finds an impact almost without speed or a maximum that almost touches, as sharply as the orbit is
 * known. Rounding of the state appears in a speed as its square root. */
static void check_grazes(const saltus_branch_point *point) {
    saltus_system *system = build(&point->spec);
    saltus_flow_options options = saltus_flow_defaults();
    double speed_scale = saltus_system_scale(system)[saltus_system_dof(system)], slowest = INFINITY,
           nearest = INFINITY, touch[2] = {NAN, NAN};
    saltus_flow *flow = open_flow(system, &options, 0, point->state);
    for (;;) {
        saltus_event event = advance(flow, point->periods, SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING);
        if (event.kind == SALTUS_REACHED)
            break;
        double speed = fabs(event.velocity_before),
               gap = fabs(event.displacement / point->spec.stops[0].d - 1);
        if (event.kind == SALTUS_IMPACT && speed < slowest) {
            slowest = speed;
            touch[0] = saltus_time_periods(event.time);
        }
        if (event.kind == SALTUS_TURNING && event.velocity_before < 0 && gap < nearest) {
            nearest = gap;
            touch[1] = saltus_time_periods(event.time);
        }
    }
    check_near(point->residual, 0, 1e-12);
    if (!(slowest < 3e-7 * speed_scale || nearest < 1e-14 + point->residual))
        fail_msg("GR at %.12g: slowest impact %.3g, nearest maximum %.3g", point->value[0],
                 slowest / speed_scale, nearest);
    double apart[2] = {fabs(remainder(touch[0] - point->grazing_time, point->periods)),
                       fabs(remainder(touch[1] - point->grazing_time, point->periods))};
    if (!(apart[0] < 1e-6 || apart[1] < 1e-6))
        fail_msg("GR at %.12g: the touch is told at %.12g T, the flow has %.12g or %.12g", point->value[0],
                 point->grazing_time, touch[0], touch[1]);
    assert_true(point->grazing_stop == 1);
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* The critical multiplier of a special point, and the stable orbits on its two sides. */
static void check_pipe_special(const branch_record *record, int index, const char *key, double aside) {
    const saltus_branch_point *point = &record->point[index];
    const saltus_multiplier *mu = point->multipliers;
    int critical = 0, outside = 0;
    for (int i = 0; i < point->dimension; i++)
        if (fabs(mu[i].log_modulus) < fabs(mu[critical].log_modulus))
            critical = i;
    for (int i = 0; i < point->dimension; i++)
        outside += mu[i].log_modulus > 1e-6;
    if (point->kind == SALTUS_POINT_GR) {
        check_grazes(point);
    } else {
        check_near(mu[critical].log_modulus, 0, 1e-6);
        if (point->kind == SALTUS_POINT_NS)
            assert_true(fabs(mu[critical].im) > 1e-3);
        else
            check_near(mu[critical].re, point->kind == SALTUS_POINT_PD ? -1 : 1, 1e-6);
    }
    bool below = settles_beside(point, key, -aside), above = settles_beside(point, key, aside);
    if ((point->kind == SALTUS_POINT_PD || point->kind == SALTUS_POINT_NS) && outside == 0)
        assert_true(below != above);
    if (point->kind == SALTUS_POINT_LP) {
        bool top = record->point[index - 1].value[0] < point->value[0];
        assert_false(top ? above : below);
        check_leaves(point, key, top ? aside : -aside);
    }
}

/* Check all special points of a run, and of the regular points each `every`-th if stable. */
static void check_pipe_branch(const branch_record *record, const char *key, double aside, int every) {
    for (int k = 0; k < record->count; k++) {
        const saltus_branch_point *point = &record->point[k];
        if (branch_special(point))
            check_pipe_special(record, k, key, aside);
        if (point->kind != SALTUS_POINT_REGULAR)
            continue;
        assert_true(point->admissible);
        check_near(point->residual, 0, 1e-12);
        if (point->stable && k % every == 0)
            check_settles(point);
    }
}

static void check_kinds(const branch_record *record, int branch, const char *kinds) {
    char found[256] = "";
    const saltus_branch_point *point;
    for (int from = 0; (point = branch_next_special(record, branch, &from));) {
        strcat(found, saltus_point_word(point->kind));
        strcat(found, " ");
    }
    assert_string_equal(found, kinds);
}

static void family_in_omega(void **unused) {
    (void)unused;
    skip_unless_long();
    saltus_branch_options options = branch_along("omega", 35, 56);
    branch_record record = run_reference("fig7d", 0, &options);
    check_kinds(&record, 0, "LP GR LP GR GR GR ");
    check_kinds(&record, 1, "PD GR NS GR LP GR LP GR ");
    check_pipe_branch(&record, "omega", 1e-4, 5);
    branch_forget(&record);
}

static void family_in_d(void **unused) {
    (void)unused;
    skip_unless_long();
    saltus_branch_options options = branch_along("d", 0.03, 0.04);
    branch_record record = run_reference("fig7d", 0, &options);
    check_kinds(&record, 0, "PD GR PD GR PD GR LP GR ");
    check_kinds(&record, 1, "GR NS LP GR LP GR GR GR GR ");
    check_pipe_branch(&record, "d", 2e-7, 5);
    branch_forget(&record);
}

static saltus_motion classified(const saltus_spec *spec) {
    saltus_system *system = build(spec);
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double state[SALTUS_SCENE_STATE_MAX];
    check_ok(saltus_system_default_state(system, state, &message), &message);
    check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
    assert_int_equal(motion.verdict, SALTUS_PERIODIC);
    saltus_system_free(system);
    return motion;
}

/* At d = 0.035 orbits of two periods gain impacts as omega grows, one at each grazing. */
static void window_of_two_periods(void **unused) {
    (void)unused;
    skip_unless_long();
    static const char *const labels[] = {"4/2", "5/2", "6/2", "7/2"};
    reference r = read_reference("fig7d");
    saltus_spec spec = r.spec;
    set_parameter(&spec, "omega", 18);
    saltus_motion motion = classified(&spec);
    assert_string_equal(motion.label, labels[0]);
    saltus_branch_options options = branch_along("omega", 15.3, 24.8);
    branch_record record = branch_run(&spec, motion.periods, motion.state, &options);
    int grazing = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *point = &record.point[k];
        if (point->branch != 0)
            continue;
        assert_string_equal(point->label, labels[grazing]);
        if (point->kind == SALTUS_POINT_GR && grazing < 3)
            assert_string_equal(point->label_after, labels[++grazing]);
    }
    assert_int_equal(grazing, 3);
    check_kinds(&record, 0, "GR NS GR PD GR PD ");
    check_kinds(&record, 1, "LP GR LP GR PD ");
    check_pipe_branch(&record, "omega", 1e-4, 6);
    branch_forget(&record);
    saltus_motion_clear(&motion);
}

/* On the orbit at a clearance: the smallest distance of a free maximum from the stop. */
static double nearest_maximum(const reference *r, double d) {
    saltus_spec spec = r->spec;
    spec.stops[0].d = d;
    saltus_system *system = build(&spec);
    saltus_orbit_options options = saltus_orbit_defaults();
    saltus_message message = {.text = ""};
    saltus_orbit orbit;
    double nearest = INFINITY;
    check_ok(saltus_orbit_find(system, r->periods, r->states[0], &options, &orbit, &message), &message);
    saltus_flow *flow = open_flow(system, &options.flow, 0, orbit.state);
    for (;;) {
        saltus_event event = advance(flow, r->periods, SALTUS_WATCH_TURNING);
        if (event.kind == SALTUS_REACHED)
            break;
        if (event.velocity_before < 0)
            nearest = fmin(nearest, d - event.displacement);
    }
    saltus_flow_free(flow);
    saltus_orbit_clear(&orbit);
    saltus_system_free(system);
    return nearest;
}

/* Where that distance vanishes, by a parabola through three clearances shortly before. */
static double touching_clearance(const reference *r, double near) {
    const double step = 2e-7;
    double h[3];
    for (int k = 0; k < 3; k++)
        h[k] = nearest_maximum(r, near + (k + 1) * step);
    double curve = (h[2] - 2 * h[1] + h[0]) / 2, slope = h[1] - h[0] - 3 * curve, t = 0;
    double constant = h[0] - slope - curve;
    for (int k = 0; k < 20; k++)
        t = -(constant + curve * t * t) / slope;
    return near + t * step;
}

/* From the 3/5 of fig7b down in d: an impact is born at a grazing; 4/5 is unstable at first, and stable from
 * its flip on; 7/10 exists between and is reached from either end. */
static void from_3_5_to_4_5(void **unused) {
    (void)unused;
    skip_unless_long();
    static const struct {
        int branch;
        saltus_point_kind kind;
        double d;
    } rows[] = {{1, SALTUS_POINT_GR, 0.029910423239796},
                {1, SALTUS_POINT_PD, 0.029566414358368},
                {2, SALTUS_POINT_LP, 0.029938143889266},
                {2, SALTUS_POINT_GR, 0.029541402727194}};
    const double values[] = {0.02996, 0.02992, 0.0299, 0.0297, 0.02955};
    saltus_branch_options options = branch_along("d", 0.0293, 0.03);
    options.switches = 1;
    options.values = values;
    options.value_count = sizeof values / sizeof values[0];
    branch_record record = run_reference("fig7b", 0, &options);
    for (int k = 0, from = 0; k < 4; k++) {
        if (k && rows[k].branch != rows[k - 1].branch)
            from = 0;
        const saltus_branch_point *point = branch_next_special(&record, rows[k].branch, &from);
        assert_true(point && point->kind == rows[k].kind);
        check_near(point->value[0], rows[k].d, 1e-9);
    }
    check_ends(&record, 2, "half the period", rows[1].d, 1e-9);
    int stable[3] = {0};
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *point = &record.point[k];
        if (point->kind != SALTUS_POINT_UZ || !point->stable)
            continue;
        check_settles(point);
        stable[0] += strcmp(point->label, "3/5") == 0;
        stable[1] += strcmp(point->label, "4/5") == 0;
        stable[2] += strcmp(point->label, "7/10") == 0;
    }
    assert_true(stable[0] >= 2 && stable[1] >= 1 && stable[2] >= 2);
    branch_forget(&record);
}

/* The birth of an impact there: a free maximum of the pipe reaches the stop, and the orbit is stable until
 * then. */
static void an_impact_of_the_pipe_is_born(void **unused) {
    (void)unused;
    const double values[] = {0.02996};
    saltus_branch_options options = branch_along("d", 0.0299, 0.03);
    options.direction = -1;
    options.points = 12;
    options.step = options.step_max = 0.2;
    options.values = values;
    options.value_count = 1;
    branch_record record = run_reference("fig7b", 0, &options);
    int from = 0, settled = 0;
    const saltus_branch_point *point = branch_next_special(&record, 0, &from);
    assert_true(point && point->kind == SALTUS_POINT_GR);
    assert_string_equal(point->label, "3/5");
    assert_string_equal(point->label_after, "4/5");
    reference r = read_reference("fig7b");
    check_near(point->value[0], touching_clearance(&r, point->value[0]), 1e-9);
    check_pipe_special(&record, from - 1, "d", 2e-7);
    for (int k = 0; k < record.count; k++)
        if (record.point[k].kind == SALTUS_POINT_UZ && record.point[k].stable) {
            check_settles(&record.point[k]);
            settled++;
        }
    assert_true(settled > 0);
    branch_forget(&record);
}

/* A mass pressed to a stop leaves it once a period and returns in complete chatter, until at some clearance
 * it leaves before the chatter is complete. */
static void chatter_ends(void **unused) {
    (void)unused;
    double value[2];
    saltus_spec spec = oscillator_spec(0.1, 1, 0.5, 1);
    set_parameter(&spec, "F0", 2);
    add_stop(&spec, 1.75, 0.5, SALTUS_UPPER);
    saltus_motion motion = classified(&spec);
    assert_string_equal(motion.label, "chatter/1");
    for (int loose = 0; loose < 2; loose++) {
        saltus_branch_options options = branch_along("d", 1.7, 1.81033);
        options.direction = 1;
        options.orbit.flow.rtol = loose ? 1e-12 : 1e-13;
        branch_record record = branch_run(&spec, 1, motion.state, &options);
        int from = 0;
        const saltus_branch_point *point = branch_next_special(&record, 0, &from);
        assert_true(point && point->kind == SALTUS_POINT_CH);
        assert_string_equal(point->label, "chatter/1");
        value[loose] = point->value[0];
        for (int side = -1; side <= 1; side += 2) {
            char label[SALTUS_LABEL_MAX];
            saltus_spec beside = point->spec;
            beside.stops[0].d = point->value[0] + side * 1e-5;
            saltus_system *system = build(&beside);
            settle(system, point->state, 400, label);
            assert_int_equal(strcmp(label, "chatter/1") == 0, side < 0);
            saltus_system_free(system);
        }
        branch_forget(&record);
    }
    check_near(value[0], value[1], 1e-8);
    saltus_motion_clear(&motion);
}

/* The same on the pipe, by continuation, by classification, and with another tolerance. */
static void chatter_of_the_pipe_ends(void **unused) {
    (void)unused;
    skip_unless_long();
    double value[2];
    for (int loose = 0; loose < 2; loose++) {
        saltus_branch_options options = branch_along("omega", 9.99, 10.5899);
        options.direction = 1;
        options.step_max = 0.1;
        if (loose)
            options.orbit.flow.rtol = 1e-12;
        branch_record record = run_reference("chatter25", 0, &options);
        int from = 0;
        const saltus_branch_point *point = branch_next_special(&record, 0, &from);
        assert_true(point && point->kind == SALTUS_POINT_CH);
        assert_string_equal(point->label, "chatter/2");
        assert_true(point->label_after[0] && strcmp(point->label_after, "chatter/2") != 0);
        value[loose] = point->value[0];
        for (int side = -1; side <= 1 && !loose; side += 2) {
            char label[SALTUS_LABEL_MAX];
            saltus_spec spec = point->spec;
            set_parameter(&spec, "omega", point->value[0] + side * 1e-4);
            saltus_system *system = build(&spec);
            settle(system, point->state, patience(), label);
            assert_int_equal(strcmp(label, "chatter/2") == 0, side < 0);
            assert_non_null(strstr(label, "/2"));
            saltus_system_free(system);
        }
        branch_forget(&record);
    }
    check_near(value[0], value[1], 1e-8);
}

/* How a run works. */

static saltus_branch_options example_options(closed_oscillator *o) {
    *o = closed_example_of(closed_one_period);
    o->omega = 1.1L;
    return branch_along("omega", 0.6, 1.8);
}

/* The branch is the same from any section point of its first orbit, and from near it. */
static void any_section_point(void **unused) {
    (void)unused;
    saltus_branch_options options = branch_along("omega", 0.78, 1.1);
    closed_oscillator o = closed_example_of(closed_two_periods);
    closed_orbit orbit;
    o.omega = 0.85L;
    assert_true(closed_orbit_at(&o, 1, &orbit));
    saltus_spec spec = closed_spec(&o);
    branch_record record = run_closed(&o, 1, &options);
    for (int later = 0; later < 2; later++) {
        double state[2] = {(double)orbit.state[0] + 1e-4, (double)orbit.state[1] - 1e-4};
        branch_record other = branch_run(&spec, o.periods, state, &options);
        branch_check_same(&record, &other, 1e-9);
        branch_forget(&other);
        begin_later(&orbit);
    }
    branch_forget(&record);
}

static void any_section_point_of_the_pipe(void **unused) {
    (void)unused;
    skip_unless_long();
    saltus_branch_options options = branch_along("omega", 41, 42.2);
    options.step_max = 0.1;
    branch_record record = run_reference("fig7d", 0, &options);
    for (int section = 1; section < 4; section += 2) {
        reference r = read_reference("fig7d");
        for (int i = 0; i < r.n; i++)
            r.states[section][i] *= 1 + (i % 2 ? 1e-4 : -1e-4);
        branch_record other = branch_run(&r.spec, r.periods, r.states[section], &options);
        branch_check_same(&record, &other, 1e-9);
        branch_forget(&other);
    }
    options.step_max /= 2;
    branch_record other = run_reference("fig7d", 0, &options);
    branch_check_same(&record, &other, 1e-9);
    assert_true(other.count > record.count);
    branch_forget(&other);
    branch_forget(&record);
}

static void any_step(void **unused) {
    (void)unused;
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        const closed_case *c = mirrored ? &two_stops[2] : &one_stop[1];
        closed_oscillator o = oscillator_of(c);
        saltus_branch_options options = branch_along(c->key, c->lo, c->hi);
        branch_record record = run_closed(&o, c->sheet, &options);
        options.step_max /= 2;
        branch_record other = run_closed(&o, c->sheet, &options);
        branch_check_same(&record, &other, 1e-9);
        assert_true(other.count > record.count);
        branch_forget(&other);
        branch_forget(&record);
    }
}

/* Requested values become points wherever the branch passes them, however many. */
static void check_values(int count) {
    closed_oscillator o;
    double values[64];
    int passed[64] = {0};
    saltus_branch_options options = example_options(&o);
    for (int k = 0; k < count; k++)
        values[k] = 1.12 + 0.4 * k / count;
    options.values = values;
    options.value_count = count;
    options.direction = 1;
    branch_record record = run_closed(&o, 1, &options);
    for (int k = 0; k < record.count; k++)
        for (int v = 0; v < count && record.point[k].kind == SALTUS_POINT_UZ; v++)
            if (fabs(record.point[k].value[0] - values[v]) < 1e-12) {
                passed[v]++;
                if (record.point[k].impacts)
                    check_regular(&o, "omega", &record.point[k]);
            }
    /* The branch goes up to the fold, back to the grazing at 1.2186, and on as the free response. */
    for (int v = 0; v < count; v++)
        assert_int_equal(passed[v], values[v] < 1.2186 ? 1 : 3);
    branch_forget(&record);
}

static void values_asked_for(void **unused) {
    (void)unused;
    check_values(12);
}

static void many_values_asked_for(void **unused) {
    (void)unused;
    check_values(40);
}

/* Both ways or one, to the ends of the range. */
static void ends_and_directions(void **unused) {
    (void)unused;
    closed_oscillator o;
    saltus_branch_options options = example_options(&o);
    branch_record both = run_closed(&o, 1, &options);
    for (int branch = 0; branch < 2; branch++) {
        check_ends(&both, branch, "range", branch ? 0.6 : 1.8, 1e-12);
        options.direction = branch ? -1 : 1;
        branch_record one = run_closed(&o, 1, &options);
        assert_null(last_of_branch(&one, 1));
        for (int k = 0, i = 0, j = 0; k < 2; k++) {
            const saltus_branch_point *a = branch_next_special(&one, 0, &i);
            const saltus_branch_point *b = branch_next_special(&both, branch, &j);
            assert_true(a && b && a->kind == b->kind);
            check_near(a->value[0], b->value[0], 1e-9);
        }
        branch_forget(&one);
    }
    branch_forget(&both);
}

/* Each way along a branch is the same to the last bit, whether or not the other is computed. */
static void ways_are_independent(void **unused) {
    (void)unused;
    closed_oscillator o;
    saltus_branch_options options = example_options(&o);
    branch_record both = run_closed(&o, 1, &options);
    for (int branch = 0; branch < 2; branch++) {
        options.direction = branch ? -1 : 1;
        branch_record one = run_closed(&o, 1, &options);
        assert_int_equal(one.count,
                         branch ? both.count - first_of_branch(&both, 1) : first_of_branch(&both, 1));
        for (int k = 0; k < one.count; k++) {
            const saltus_branch_point *same = &both.point[k + (branch ? first_of_branch(&both, 1) : 0)];
            assert_int_equal(one.point[k].kind, same->kind);
            check_near(one.point[k].value[0], same->value[0], 0);
        }
        branch_forget(&one);
    }
    branch_forget(&both);
}

static void as_many_points_as_asked_for(void **unused) {
    (void)unused;
    closed_oscillator o;
    saltus_branch_options options = example_options(&o);
    options.points = 7;
    branch_record few = run_closed(&o, 1, &options);
    for (int branch = 0; branch < 2; branch++) {
        int points = 0;
        for (int k = 0; k < few.count; k++)
            points += few.point[k].branch == branch;
        assert_int_equal(points, 7);
        /* The end point, one step on, is one of them. */
        const saltus_branch_point *last = last_of_branch(&few, branch);
        assert_true(last->arclength > last[-1].arclength);
        check_ends(&few, branch, "as many points as asked for", 1.1, 0.5);
    }
    branch_forget(&few);
}

/* Order and place of all points: arclength grows, steps count, special points lie between regular ones. */
static void order_of_points(void **unused) {
    (void)unused;
    closed_oscillator o;
    saltus_branch_options options = example_options(&o);
    branch_record record = run_closed(&o, 1, &options);
    for (int k = 0; k + 1 < record.count; k++) {
        const saltus_branch_point *a = &record.point[k], *b = &record.point[k + 1];
        if (a->branch != b->branch)
            continue;
        assert_true(b->arclength >= a->arclength);
        assert_true(b->arclength - a->arclength < 1.1 * options.step_max);
        assert_int_equal(b->step, a->step + (a->kind == SALTUS_POINT_REGULAR));
    }
    branch_forget(&record);
}

/* A branch that leaves chatter and meets it again at every step must end. */
static void points_are_limited(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 0, 1.025, 1);
    set_parameter(&spec, "F0", -1);
    add_stop(&spec, 0, 0.5, SALTUS_LOWER);
    saltus_motion motion = classified(&spec);
    assert_string_equal(motion.label, "chatter/1");
    saltus_branch_options options = branch_along("F", 1.01, 1.5);
    options.direction = -1;
    options.points = 20;
    saltus_branch *branch = NULL;
    saltus_message message = {.text = ""};
    check_ok(saltus_branch_new(&spec, motion.periods, motion.state, &options, &branch, &message), &message);
    branch_record record = branch_collect(branch, 4 * options.points);
    saltus_branch_free(branch);
    int regular = 0;
    for (int k = 0; k < record.count; k++)
        regular += record.point[k].kind == SALTUS_POINT_REGULAR;
    assert_in_range(regular, 1, options.points);
    assert_true(record.count < 4 * options.points);
    branch_forget(&record);
    saltus_motion_clear(&motion);
}

static void check_refused(const saltus_branch_options *options, const char *word) {
    closed_oscillator o;
    closed_orbit orbit;
    (void)example_options(&o);
    assert_true(closed_orbit_at(&o, 1, &orbit));
    saltus_spec spec = closed_spec(&o);
    saltus_branch *branch = NULL;
    saltus_message message = {.text = ""};
    double state[2] = {(double)orbit.state[0], (double)orbit.state[1]};
    assert_int_equal(saltus_branch_new(&spec, 1, state, options, &branch, &message), SALTUS_BAD_INPUT);
    assert_null(branch);
    if (!strstr(message.text, word))
        fail_msg("\"%s\" does not speak of \"%s\"", message.text, word);
}

static void bad_input(void **unused) {
    (void)unused;
    static const struct {
        const char *key;
        double low, high;
        const char *word;
    } rows[] = {{"nonsense", 0, 1, "nonsense"},
                {"N", 1, 2, "N"},
                {"", 0, 1, ""},
                {"omega", 1.2, 1.8, "start"},
                {"omega", 0.5, 1, "start"},
                {"omega", 1.8, 0.6, "low to high"},
                {"omega", 1.1, 1.1, "low to high"},
                {"omega", NAN, 1.8, "range"}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        saltus_branch_options options = branch_along(rows[k].key, rows[k].low, rows[k].high);
        check_refused(&options, rows[k].word);
    }
    saltus_branch_options options = branch_along("omega", 0.6, 1.8);
    options.points = 0;
    check_refused(&options, "points");
    options.points = 10;
    options.step = 0;
    check_refused(&options, "step");
    options.step = 0.1;
    check_refused(&options, "step");
    options.step = 0.005;
    options.locus = SALTUS_POINT_EP;
    check_refused(&options, "locus");
    options.locus = SALTUS_POINT_LP;
    check_refused(&options, "");
    snprintf(options.key[1], sizeof options.key[1], "d");
    options.low[1] = 2;
    options.high[1] = 1;
    check_refused(&options, "low to high");
    options.high[1] = 3;
    check_refused(&options, "start");
}

static void check_resumed(closed_example example, double omega, double low, double high, int switches,
                          int every) {
    closed_oscillator o = closed_example_of(example);
    closed_orbit orbit;
    saltus_branch_options options = branch_along("omega", low, high);
    o.omega = omega;
    options.switches = switches;
    saltus_spec spec = closed_spec(&o);
    assert_true(closed_orbit_at(&o, 1, &orbit));
    const double state[2] = {(double)orbit.state[0], (double)orbit.state[1]};
    assert_true(branch_check_resumed(&spec, o.periods, state, &options, every) > 1);
}

static void resumed_anywhere(void **unused) {
    (void)unused;
    int sparse = long_version() ? 1 : 4;
    check_resumed(closed_one_period, 1.1, 0.6, 1.8, 0, 23 * sparse);
    check_resumed(closed_one_period_loaded, 1.2, 0.8, 1.9, 0, 13 * sparse);
    check_resumed(closed_two_periods, 0.85, 0.78, 0.985, 0, 7 * sparse);
    check_resumed(closed_two_periods, 0.85, 0.78, 1.1, 1, 31 * sparse);
    check_resumed(closed_mirrored, 3.6, 2.3, 4, 1, 31 * sparse);
}

/* The same through complete chatter and its end, and on switched branches of the pipe, with requested
 * values. */
static void resumed_through_chatter_and_switches(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_spec spec = oscillator_spec(0.1, 1, 0.5, 1);
    set_parameter(&spec, "F0", 2);
    add_stop(&spec, 1.75, 0.5, SALTUS_UPPER);
    saltus_motion motion = classified(&spec);
    saltus_branch_options options = branch_along("d", 1.7, 1.81033);
    assert_true(branch_check_resumed(&spec, 1, motion.state, &options, 25) > 2);
    saltus_motion_clear(&motion);
    const double values[] = {41.5, 42, 42.5};
    options = branch_along("omega", 41, 43);
    options.values = values;
    options.value_count = 3;
    options.switches = 1;
    reference r = read_reference("fig7d");
    assert_true(branch_check_resumed(&r.spec, r.periods, r.states[0], &options, long_version() ? 5 : 20) > 1);
}

/* The same if the branch ends at a flip of orbits of half the period. */
static void resumed_towards_a_join(void **unused) {
    (void)unused;
    check_resumed(closed_two_periods, 0.85, 0.78, 1.1, 0, long_version() ? 7 : 17);
}

/* Where a branch joins a flip only the flip is reported, no branch point, whatever the steps before. */
static void joins_are_no_branch_points(void **unused) {
    (void)unused;
    for (int k = 0; k < 12; k += long_version() ? 1 : 4) {
        closed_oscillator o = closed_example_of(closed_two_periods);
        saltus_branch_options options = branch_along("omega", 0.78 - 0.003 * k, 1.1);
        options.switches = 1;
        options.step_max = 0.02 - 0.001 * k;
        options.direction = 1;
        o.omega = 0.85L;
        branch_record record = run_closed(&o, 1, &options);
        for (int i = 0; i < record.count; i++)
            if (record.point[i].kind == SALTUS_POINT_BP)
                fail_msg("BP at %.12g on branch %d, from %.12g in steps of %g", record.point[i].value[0],
                         record.point[i].branch, options.low[0], options.step_max);
        branch_forget(&record);
    }
}

/* A run cannot be resumed from another run's numbers, or from none. */
static void resumed_from_another_run(void **unused) {
    (void)unused;
    closed_oscillator o;
    closed_orbit orbit;
    saltus_branch_options options = example_options(&o);
    saltus_spec spec = closed_spec(&o);
    saltus_branch *branch = NULL;
    const saltus_branch_point *point;
    saltus_message message = {.text = ""};
    double *numbers;
    int count, kept;
    assert_true(closed_orbit_at(&o, 1, &orbit));
    double state[2] = {(double)orbit.state[0], (double)orbit.state[1]};
    check_ok(saltus_branch_new(&spec, 1, state, &options, &branch, &message), &message);
    check_ok(saltus_branch_step(branch, &point, &message), &message);
    check_ok(saltus_branch_save(branch, &numbers, &count, &message), &message);
    saltus_branch_free(branch);
    assert_true(count > 0);
    for (int other = 0; other < 6; other++) {
        saltus_branch_options changed = options;
        changed.high[0] += other == 1 ? 0.01 : 0;
        changed.points -= other == 2;
        changed.switches += other == 3;
        changed.direction += other == 4;
        check_ok(saltus_branch_new(&spec, 1, state, &changed, &branch, &message), &message);
        saltus_status status = saltus_branch_resume(branch, other == 5 ? NULL : numbers,
                                                    other == 5 ? 0 : count, &kept, &message);
        assert_int_equal(status, other ? SALTUS_BAD_INPUT : SALTUS_OK);
        assert_int_equal(kept, !other);
        assert_true(!other || strstr(message.text, "another run"));
        saltus_branch_free(branch);
    }
    free(numbers);
}

/* Long version: beside every special point, at each of these values, trajectories settle on the run's own
 * points where these are said to be stable. */
static void stable_points_beside(const char *key, double low, double high, double aside) {
    saltus_branch_options options = branch_along(key, low, high);
    branch_record record = run_reference("fig7d", 0, &options);
    double values[16];
    int count = 0, settled = 0;
    for (int k = 0; k < record.count; k++) {
        if (branch_special(&record.point[k])) {
            values[count++] = record.point[k].value[0] - aside;
            values[count++] = record.point[k].value[0] + aside;
        }
        if (count < 16 && !(count && k + 1 == record.count))
            continue;
        options.values = values;
        options.value_count = count;
        branch_record again = run_reference("fig7d", 0, &options);
        for (int i = 0; i < again.count; i++)
            if (again.point[i].kind == SALTUS_POINT_UZ && again.point[i].stable) {
                check_settles(&again.point[i]);
                settled++;
            }
        branch_forget(&again);
        count = 0;
    }
    assert_true(settled > 10);
    branch_forget(&record);
}

static void longer_version(void **unused) {
    (void)unused;
    skip_unless_long();
    stable_points_beside("omega", 35, 56, 1e-4);
    stable_points_beside("d", 0.03, 0.04, 1e-6);
    check_resumed(closed_one_period, 1.1, 0.6, 1.8, 0, 1);
    check_resumed(closed_two_periods, 0.85, 0.78, 0.985, 0, 1);
}

/* A mass between two walls, down to r = 0. There the orbit with two impacts breaches nothing, but on the way
 * it would pass through the walls: the births of two more impacts are found in place, with their touch, and
 * not skipped. */
static void births_before_the_border(void **unused) {
    (void)unused;
    saltus_scene pair;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_load("impact-pair", &pair, &message), &message);
    saltus_system *system = build(&pair.spec);
    saltus_classify_options how = saltus_classify_defaults();
    saltus_motion motion;
    double start[16];
    check_ok(saltus_system_default_state(system, start, &message), &message);
    check_ok(saltus_classify(system, start, &how, &motion, &message), &message);
    saltus_branch_options options = branch_along("r", 0, 1);
    options.direction = -1;
    branch_record record = branch_run(&pair.spec, 1, motion.state, &options);
    int changes = 0;
    for (int k = 1; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k], *before = p - 1;
        if (p->kind == SALTUS_POINT_GR)
            assert_true(isfinite(p->grazing_time));
        changes += before->impacts != p->impacts;
        /* The number of impacts changes only at grazing, and where chatter begins and ends. */
        assert_true(before->impacts == p->impacts || before->kind == SALTUS_POINT_GR ||
                    before->kind == SALTUS_POINT_CH || p->value[0] == 0);
    }
    assert_true(changes >= 1);
    branch_forget(&record);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

/* Impacts are born one after the other, ever slower and at ever closer parameters; chatter is complete where
 * they accumulate. None of the first births is missed or taken for another, their distances from there form a
 * geometric sequence, and the branch goes on. */
static void births_lead_to_chatter(void **unused) {
    (void)unused;
    static const struct {
        const char *key;
        double value;
    } settings[] = {{"N", 2}, {"alpha", 0.005466}, {"u0", 4.33}, {"sigma", 0.2003}, {"omega", 32}};
    saltus_scene pipe;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_load("pipe", &pipe, &message), &message);
    saltus_spec spec = pipe.spec;
    for (size_t k = 0; k < sizeof settings / sizeof settings[0]; k++)
        set_parameter(&spec, settings[k].key, settings[k].value);
    spec.stops[0].d = 0.01892;
    spec.stops[0].r = 0.4106;
    spec.stops[0].sides = SALTUS_BOTH;
    saltus_system *system = build(&spec);
    saltus_classify_options how = saltus_classify_defaults();
    saltus_motion motion;
    double start[16];
    check_ok(saltus_system_default_state(system, start, &message), &message);
    check_ok(saltus_classify(system, start, &how, &motion, &message), &message);
    assert_string_equal(motion.label, "1/2");
    saltus_branch_options options = branch_along("u0", 3.519, 5.148);
    options.direction = 1;
    options.step_max = 0.03;
    branch_record record = branch_run(&spec, 2, motion.state, &options);
    double born[64];
    int births = 0;
    int completed = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        if (p->kind == SALTUS_POINT_GR) {
            assert_int_equal(p->impacts, births + 1);
            assert_true(births < 64);
            born[births++] = p->value[0];
        }
        if (p->kind == SALTUS_POINT_CH) {
            assert_string_equal(p->label_after, "chatter/2");
            assert_true(births >= 4);
            double before = (p->value[0] - born[births - 2]) / (p->value[0] - born[births - 3]);
            double after = (p->value[0] - born[births - 1]) / (p->value[0] - born[births - 2]);
            assert_true(after > 0 && after < 1);
            check_near(before / after, 1, 0.02);
            completed++;
        }
    }
    assert_int_equal(completed, 1);
    assert_non_null(strstr(record.point[record.count - 1].reason, "range"));
    branch_forget(&record);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

/* A branch of a scene along u0, from the orbit on which its default motion settles. */
static branch_record chattering_pipe(double u0, int direction, const char *label) {
    static const struct {
        const char *key;
        double value;
    } settings[] = {{"alpha", 0.00241}, {"sigma", 0.154}, {"omega", 43.644}};
    saltus_spec spec = pipe_spec(5, 43.644);
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double start[16];
    for (size_t k = 0; k < sizeof settings / sizeof settings[0]; k++)
        set_parameter(&spec, settings[k].key, settings[k].value);
    set_parameter(&spec, "u0", u0);
    add_stop(&spec, 0.01616, 0.597, SALTUS_LOWER);
    spec.stops[0].xi = 0.3589;
    saltus_system *system = build(&spec);
    saltus_classify_options how = saltus_classify_defaults();
    check_ok(saltus_system_default_state(system, start, &message), &message);
    check_ok(saltus_classify(system, start, &how, &motion, &message), &message);
    assert_string_equal(motion.label, label);
    saltus_branch_options options = branch_along("u0", 4.9, 5);
    options.direction = direction;
    branch_record record = branch_run(&spec, motion.periods, motion.state, &options);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    return record;
}

/* The branch of chattering orbits of twice the period ends at the flip of the single ones. */
static void chatter_doubles(void **unused) {
    (void)unused;
    skip_where_slow();
    branch_record doubled = chattering_pipe(4.965, -1, "chatter/2");
    branch_record single = chattering_pipe(4.92, 1, "chatter/1");
    const saltus_branch_point *end = &doubled.point[doubled.count - 1];
    int flips = 0;
    assert_int_equal(end->kind, SALTUS_POINT_EP);
    assert_non_null(strstr(end->reason, "joins the orbits of half the period"));
    for (int k = 0; k < single.count; k++)
        if (single.point[k].kind == SALTUS_POINT_PD) {
            check_near(single.point[k].value[0], end->value[0], end->accuracy);
            flips++;
        }
    assert_int_equal(flips, 1);
    branch_forget(&doubled);
    branch_forget(&single);
}

/* A scene without symmetry has no branch points, and each fold or flip has its multiplier or is known to many
 * digits, even where impacts are born by the dozen and steps skip several. */
static void special_points_have_their_multipliers(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_spec spec = pipe_spec(5, 16.354);
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double start[16];
    set_parameter(&spec, "u0", 4.5643);
    add_stop(&spec, 0.022416, 0.78763, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_classify_options how = saltus_classify_defaults();
    check_ok(saltus_system_default_state(system, start, &message), &message);
    check_ok(saltus_classify(system, start, &how, &motion, &message), &message);
    saltus_branch_options options = branch_along("r", 0.1, 1);
    options.direction = 1;
    options.points = 140;
    branch_record record = branch_run(&spec, motion.periods, motion.state, &options);
    int most = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        const bool flip = p->kind == SALTUS_POINT_PD;
        double nearest = INFINITY;
        assert_int_not_equal(p->kind, SALTUS_POINT_BP);
        most = p->impacts > most ? p->impacts : most;
        for (int i = 0; i < p->multiplier_count; i++)
            nearest = fmin(nearest, hypot(p->multipliers[i].re - (flip ? -1 : 1), p->multipliers[i].im));
        if (flip || p->kind == SALTUS_POINT_LP)
            assert_true(p->accuracy < 1e-7 || nearest < 0.05);
    }
    assert_true(most > 40);
    branch_forget(&record);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_of_one_stop),
        cmocka_unit_test(points_of_two_stops),
        cmocka_unit_test(literature_points),
        cmocka_unit_test(touches_of_the_image),
        cmocka_unit_test(demo_of_grazing),
        cmocka_unit_test(undamped_fold),
        cmocka_unit_test(undamped_motion_has_no_tori),
        cmocka_unit_test(vibrating_table),
        cmocka_unit_test(flips_are_joined),
        cmocka_unit_test(flips_are_joined_with_light_damping),
        cmocka_unit_test(touched_orbits_join),
        cmocka_unit_test(flip_near_grazing),
        cmocka_unit_test(pair_of_orbits),
        cmocka_unit_test(family_in_omega),
        cmocka_unit_test(family_in_d),
        cmocka_unit_test(window_of_two_periods),
        cmocka_unit_test(from_3_5_to_4_5),
        cmocka_unit_test(an_impact_of_the_pipe_is_born),
        cmocka_unit_test(chatter_ends),
        cmocka_unit_test(chatter_of_the_pipe_ends),
        cmocka_unit_test(any_section_point),
        cmocka_unit_test(any_section_point_of_the_pipe),
        cmocka_unit_test(any_step),
        cmocka_unit_test(values_asked_for),
        cmocka_unit_test(many_values_asked_for),
        cmocka_unit_test(ends_and_directions),
        cmocka_unit_test(ways_are_independent),
        cmocka_unit_test(as_many_points_as_asked_for),
        cmocka_unit_test(order_of_points),
        cmocka_unit_test(points_are_limited),
        cmocka_unit_test(bad_input),
        cmocka_unit_test(resumed_anywhere),
        cmocka_unit_test(resumed_through_chatter_and_switches),
        cmocka_unit_test(resumed_towards_a_join),
        cmocka_unit_test(joins_are_no_branch_points),
        cmocka_unit_test(resumed_from_another_run),
        cmocka_unit_test(longer_version),
        cmocka_unit_test(births_before_the_border),
        cmocka_unit_test(births_lead_to_chatter),
        cmocka_unit_test(chatter_doubles),
        cmocka_unit_test(special_points_have_their_multipliers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
