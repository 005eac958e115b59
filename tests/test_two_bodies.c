/* Two uncoupled masses, each with its own stop: the orbits are those of the single masses, known in closed
 * form, and so are multipliers and special points. Two faces act in one event sequence.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_recount.h"

/* Mass 1 on a spring with a stop; mass 2 a ball on a table that vibrates in the same rhythm. */
typedef struct two_bodies {
    closed_oscillator first;
    long double gamma, r;
    closed_orbit one;
    closed_table two;
    saltus_spec spec;
    double state[4];
} two_bodies;

/* The orbits at given parameters; with the period as unit of time the table is the same for all omega. */
static bool solve(two_bodies *b) {
    long double omega = b->first.omega, square = omega * omega;
    if (!closed_orbit_at(&b->first, 1, &b->one) || !closed_table_orbit(1, b->r, b->gamma, 1, &b->two))
        return false;
    b->state[0] = (double)b->one.state[0];
    b->state[1] = (double)(b->two.state[0] / square);
    b->state[2] = (double)b->one.state[1];
    b->state[3] = (double)(b->two.state[1] / omega);
    return true;
}

static two_bodies two_bodies_at(long double omega, long double gamma) {
    two_bodies b = {.first = closed_example_of(closed_one_period), .gamma = gamma, .r = 0.5L};
    b.first.omega = omega;
    b.spec = closed_spec(&b.first);
    set_parameter(&b.spec, "N", 2);
    set_parameter(&b.spec, "k2", 0);
    set_parameter(&b.spec, "F2", (double)gamma);
    set_parameter(&b.spec, "F02", -1);
    add_stop(&b.spec, 0, 0.5, SALTUS_LOWER);
    b.spec.stops[1].weight[0] = 0;
    b.spec.stops[1].weight[1] = 1;
    assert_true(solve(&b) && b.one.admissible);
    return b;
}

/* Each of the closed forms' multipliers is among the point's. */
static void check_union(const two_bodies *b, const saltus_branch_point *p) {
    bool taken[4] = {false};
    for (int k = 0; k < 4; k++) {
        const long double *mu = k < 2 ? b->one.multiplier[k] : b->two.multiplier[k - 2];
        int nearest = -1;
        double apart = INFINITY;
        for (int i = 0; i < 4; i++) {
            double far = hypot(p->multipliers[i].re - (double)mu[0], p->multipliers[i].im - (double)mu[1]);
            if (!taken[i] && far < apart) {
                apart = far;
                nearest = i;
            }
        }
        check_near(apart, 0, 1e-6 * (1 + (double)(mu[0] * mu[0])));
        if (nearest >= 0)
            taken[nearest] = true;
    }
}

static void check_regular(const two_bodies *start, const char *key, const saltus_branch_point *p) {
    two_bodies b = *start;
    if (strcmp(key, "F2") == 0)
        b.gamma = p->value[0];
    else if (strcmp(key, "r2") == 0)
        b.r = p->value[0];
    else
        *closed_value(&b.first, key) = p->value[0];
    assert_true(solve(&b));
    for (int i = 0; i < 4; i++)
        check_near(p->state[i], b.state[i], 1e-9);
    assert_string_equal(p->label, "2/1");
    assert_int_equal(p->event_count, 2);
    assert_true(p->admissible);
    int first = p->events[0].face == 0 ? 0 : 1;
    const saltus_event *one = &p->events[first], *two = &p->events[1 - first];
    double period = 2 * M_PI / (double)b.first.omega;
    assert_int_equal(two->face, 1);
    check_near(saltus_time_periods(one->time) * period, (double)b.one.impact[0].time, 1e-8);
    check_near(one->velocity_before, (double)b.one.impact[0].speed, 1e-9);
    check_near(one->velocity_after, -0.8 * one->velocity_before, 1e-12);
    check_near(saltus_time_periods(two->time) * 2 * M_PI, (double)b.two.phase, 1e-8);
    check_near(two->velocity_before, -(double)(b.two.speed / b.first.omega), 1e-9);
    check_near(two->velocity_after, -(double)b.r * two->velocity_before, 1e-12);
    check_union(&b, p);
}

static branch_record run(const two_bodies *b, const char *key, double low, double high, int switches,
                         saltus_branch_options *options) {
    *options = branch_along(key, low, high);
    options->switches = switches;
    branch_record record = branch_run(&b->spec, 1, b->state, options);
    recount_run(&record, options, 7);
    return record;
}

static void check_kinds_at(const branch_record *record, int branch, const char *kinds, const double *values) {
    char found[64] = "";
    const saltus_branch_point *p;
    for (int from = 0, k = 0; (p = branch_next_special(record, branch, &from)); k++) {
        strcat(strcat(found, saltus_point_word(p->kind)), " ");
        if (strlen(found) <= strlen(kinds))
            check_near(p->value[0], values[k], 1e-9);
    }
    assert_string_equal(found, kinds);
}

/* The ball's fold and flip, independent of the other mass, which beyond the flip traverses its orbit
 * twice. */
static void special_points_of_the_ball(void **unused) {
    (void)unused;
    double fold = (double)closed_table_fold(1, 0.5L), flip = (double)closed_table_flip(1, 0.5L);
    two_bodies b = two_bodies_at(1, 1.3L);
    saltus_branch_options options;
    branch_record record = run(&b, "F2", 1.046, 1.6, 1, &options);
    check_kinds_at(&record, 0, "PD ", &flip);
    check_kinds_at(&record, 1, "LP ", &fold);
    int doubled = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        if (p->branch == 0 && p->kind == SALTUS_POINT_REGULAR)
            check_regular(&b, "F2", p);
        if (p->parent < 0)
            continue;
        assert_int_equal(p->parent, 0);
        assert_string_equal(p->label, "4/2");
        check_near(p->state[0], b.state[0], 1e-9);
        check_near(p->state[2], b.state[2], 1e-9);
        doubled++;
    }
    assert_true(doubled > 3);
    branch_forget(&record);
    /* Along the ball's restitution: gamma is at the fold, pi (1 - r) / (1 + r). */
    double r = (double)((CLOSED_PI - 1.3L) / (CLOSED_PI + 1.3L));
    record = run(&b, "r2", 0.3, 0.52, 0, &options);
    int from = 0;
    const saltus_branch_point *p = branch_next_special(&record, 1, &from);
    assert_true(p && p->kind == SALTUS_POINT_LP);
    check_near(p->value[0], r, 1e-9);
    for (int k = 0; k < record.count && record.point[k].branch == 0; k++)
        if (record.point[k].kind == SALTUS_POINT_REGULAR)
            check_regular(&b, "r2", &record.point[k]);
    branch_forget(&record);
}

/* The other mass's flip and grazing, with the ball beside it; then only the ball has impacts. */
static void special_points_of_the_other(void **unused) {
    (void)unused;
    closed_orbit flip, grazing, fold;
    two_bodies b = two_bodies_at(1.1L, 1.2L);
    saltus_branch_options options;
    assert_true(closed_flip(&b.first, "omega", 0.9L, 1, &flip));
    assert_true(closed_grazing(&b.first, "omega", 0.7L, 0.75L, &grazing));
    assert_true(closed_fold(&b.first, "omega", 1.4L, 1.7L, &fold));
    const double down[] = {(double)flip.oscillator.omega, (double)grazing.oscillator.omega};
    branch_record record = run(&b, "omega", 0.65, 1.6, 0, &options);
    check_kinds_at(&record, 1, "PD GR ", down);
    int from = 0;
    const saltus_branch_point *p = branch_next_special(&record, 0, &from);
    assert_true(p && p->kind == SALTUS_POINT_LP);
    check_near(p->value[0], (double)fold.oscillator.omega, 1e-9);
    bool alone = false;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *point = &record.point[k];
        if (point->branch != 1)
            continue;
        if (point->kind == SALTUS_POINT_GR) {
            assert_string_equal(point->label, "2/1");
            assert_string_equal(point->label_after, "1/1");
            alone = true;
        } else if (point->kind == SALTUS_POINT_REGULAR && !alone) {
            check_regular(&b, "omega", point);
        } else if (alone && point->kind == SALTUS_POINT_REGULAR) {
            assert_string_equal(point->label, "1/1");
            assert_int_equal(point->events[0].face, 1);
        }
    }
    assert_true(alone);
    branch_forget(&record);
}

/* A curve in both masses' parameters: the ball's flip does not move, the other's fold does. */
static void curves_of_either(void **unused) {
    (void)unused;
    double flip = (double)closed_table_flip(1, 0.5L);
    two_bodies b = two_bodies_at(1, 1.5L);
    saltus_branch_options options = branch_along("F2", 1.2, 1.7);
    snprintf(options.key[1], sizeof options.key[1], "omega");
    options.low[1] = 0.97;
    options.high[1] = 1.2;
    options.locus = SALTUS_POINT_PD;
    branch_record record = branch_run(&b.spec, 1, b.state, &options);
    int ends = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *p = &record.point[k];
        check_near(p->value[0], flip, 1e-9);
        ends += p->kind == SALTUS_POINT_EP;
        if (p->kind == SALTUS_POINT_EP)
            check_near(p->value[1], p->branch ? 0.97 : 1.2, 1e-12);
    }
    assert_int_equal(ends, 2);
    branch_forget(&record);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(special_points_of_the_ball),
        cmocka_unit_test(special_points_of_the_other),
        cmocka_unit_test(curves_of_either),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
