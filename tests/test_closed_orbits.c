/* The closed forms of closed_orbits.h against printed values of the literature, against each other, and
 * against orbits that the library finds by integration.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "closed_orbits.h"

static void check_found(const closed_orbit *orbit, long double omega, long double speed) {
    check_near((double)orbit->oscillator.omega, (double)omega, 1e-12);
    check_near((double)orbit->impact[0].speed, (double)speed, 1e-11);
}

/* COCO's hybrid demo: x'' + 0.1 x' + x = A cos t, x < 1, restitution 0.8. */
static void one_period_orbits(void **unused) {
    (void)unused;
    static const double rows[4][5] = {{1, 0.0759521649, 1.6957329376, -0.58429531, 0.00560035},
                                      {0.5, 0.1771123597, 0.8370160232, -0.58116589, 0.06065134},
                                      {0.2, 0.4992440673, 0.2986128521, -0.57002369, 0.12847322},
                                      {0.1001, 1.4957882153, 0.0127569343, -0.18187521, 0.55529613}};
    closed_oscillator o = {.c = 0.1L, .k = 1, .omega = 1, .d = 1, .r = 0.8L, .periods = 1};
    closed_orbit orbit;
    for (int k = 0; k < 4; k++) {
        o.F = rows[k][0];
        assert_true(closed_orbit_at(&o, 1, &orbit));
        assert_true(orbit.admissible);
        check_near((double)orbit.impact[0].time, rows[k][1], 1e-10);
        check_near((double)orbit.impact[0].speed, rows[k][2], 1e-10);
        check_near((double)orbit.multiplier[0][0], rows[k][3], 1e-8);
        check_near((double)orbit.multiplier[0][1], rows[k][4], 1e-8);
        assert_true(closed_orbit_at(&o, -1, &orbit));
        assert_false(orbit.admissible);
    }
    assert_false(closed_fold(&o, "F", 0.1001L, 1, &orbit));
    assert_true(closed_flip(&o, "F", 0.1001L, 1, &orbit)); /* of the other branch, not a motion */
    assert_true(orbit.impact[0].speed < 0 && !orbit.admissible);
    assert_true(closed_grazing(&o, "F", 0.05L, 0.2L, &orbit));
    check_near((double)orbit.oscillator.F, 0.1, 1e-18);
    /* From A = 0.1001 down the branch turns at a fold just below the grazing, and grazes on its way back. */
    assert_true(closed_fold(&o, "F", 0.099L, 0.1L, &orbit));
    assert_true(orbit.admissible);
    check_near((double)orbit.oscillator.F, 0.099970753628, 1e-12);
}

/* Near grazing (arXiv 2510.16218): x'' + 0.04 x' + x = F cos(omega t) - 1, x < 0, restitution 0.9. */
static void two_period_orbits(void **unused) {
    (void)unused;
    static const long double rows[4][5] = {
        {0.81L, 0.0653039433369L, 0.3475333974123L, 0.096602133165L, -0.435490392782L},
        {0.799L, 0.1240873448523L, 0.3628362019809L, 0.071753858269L, 0.431785672133L},
        {0.80089L, 0.0066749810816L, 0.3600268471098L, 0.109200274868L, -0.432427180987L},
        {0.799741L, 0.0146915666928L, 0.3618288199778L, 0.106143380780L, 0.432037432133L}};
    closed_oscillator o = {.c = 0.04L, .k = 1, .F0 = -1, .r = 0.9L, .periods = 2};
    closed_orbit orbit;
    for (int k = 0; k < 4; k++) {
        long double low = rows[k][2] - 1e-4L, high = rows[k][2] + 1e-4L;
        o.omega = rows[k][0];
        assert_true(k % 2 ? closed_fold(&o, "F", low, high, &orbit)
                          : closed_flip(&o, "F", low, high, &orbit));
        assert_true(orbit.admissible);
        check_near((double)(orbit.oscillator.F - rows[k][2]), 0, 6e-14);
        check_near((double)(orbit.impact[0].speed - rows[k][1]), 0, 6e-14);
        check_near((double)(orbit.impact[0].time - rows[k][3]), 0, 6e-13);
        check_near((double)orbit.multiplier[0][0], k % 2 ? 1 : -1, 1e-14);
        check_near((double)(orbit.multiplier[1][0] - rows[k][4]), 0, 6e-13);
    }
    o.omega = 0.81L;
    assert_true(closed_grazing(&o, "F", 0.3L, 0.4L, &orbit));
    check_near((double)(orbit.oscillator.F - 0.345422885750L), 0, 6e-13);
    /* Resonant grazing: two forcing periods are five half cycles of the free motion. */
    long double e[4];
    o.omega = 0.799839984L;
    closed_fundamental(&o, 2 * closed_period(&o), e);
    check_near((double)e[1], 0, 2e-8);
}

/* x'' + x = cos(2.8 t), x < 0, r = 0.8 (Budd & Dux): impacts in sequence, and the fold of orbits with one
 * impact in a period. */
static void undamped_orbits(void **unused) {
    (void)unused;
    static const long double rows[5][2] = {{3.503043263961484L, 0.639009271086486L},
                                           {6.667885527840286L, 0.281622310216315L},
                                           {7.150593667690408L, 0.175649495838635L},
                                           {10.117290676709667L, 0.477868786744267L},
                                           {12.561241179822434L, 0.133967799633770L}};
    closed_oscillator o = {.k = 1, .F = 1, .omega = 2.8L, .r = 0.8L, .periods = 1};
    closed_impact impact = {0.5L, 0.5L, 1};
    for (int k = 0; k < 5; k++) {
        long double x[2];
        closed_after(&o, &impact, x);
        impact = closed_next_impact(&o, impact.time, x);
        check_near((double)(impact.time - rows[k][0]), 0, 2e-15);
        check_near((double)(impact.speed - rows[k][1]), 0, 2e-15);
    }
    closed_orbit orbit;
    for (int n = 1; n <= 3; n++) {
        long double s = closed_undamped_fold(n, o.omega, o.r);
        o.periods = n;
        assert_true(closed_fold(&o, "d", 0.9L * s, 1.1L * s, &orbit));
        check_near((double)(orbit.oscillator.d - s), 0, 1e-16);
        o.d = 0.7L * s;
        for (int branch = -1; branch <= 1; branch += 2) {
            assert_true(closed_orbit_at(&o, branch, &orbit));
            check_near((double)(orbit.impact[0].speed - closed_undamped_speed(n, o.omega, o.r, o.d, branch)),
                       0, 1e-15);
        }
    }
}

/* Ball on a vibrating table. */
static void table_orbits(void **unused) {
    (void)unused;
    static const long double rows[3][2] = {
        {0, 0}, {1.047197551197L, 1.526823700519L}, {2.094395102393L, 2.370877210267L}};
    closed_table orbit;
    for (int k = 1; k <= 2; k++) {
        long double fold = closed_table_fold(k, 0.5L), flip = closed_table_flip(k, 0.5L);
        check_near((double)(fold - rows[k][0]), 0, 6e-13);
        check_near((double)(flip - rows[k][1]), 0, 6e-13);
        assert_false(closed_table_orbit(k, 0.5L, 0.999L * fold, 1, &orbit));
        assert_true(closed_table_orbit(k, 0.5L, fold * (1 + 1e-18L), 1, &orbit));
        check_near((double)orbit.multiplier[0][0], 1, 1e-8);
        assert_true(closed_table_orbit(k, 0.5L, flip, 1, &orbit));
        check_near((double)orbit.multiplier[0][0], -1, 1e-15);
        check_near((double)orbit.multiplier[1][0], -0.25, 1e-15);
    }
}

typedef bool closed_finder(const closed_oscillator *o, const char *key, long double lo, long double hi,
                           closed_orbit *orbit);

/* A special point found in omega is found again in every other parameter. */
static void check_every_parameter(const closed_orbit *point, closed_finder *finder) {
    const char *keys[] = {"d", "F", "F0", "r", "c", "k"};
    for (int i = 0; i < 6; i++) {
        closed_oscillator o = point->oscillator;
        closed_orbit orbit;
        long double value = *closed_value(&o, keys[i]), width = 1e-4L * fmaxl(fabsl(value), 0.1L);
        if ((strcmp(keys[i], "F0") == 0 && o.mirrored) || (finder == closed_grazing && keys[i][0] == 'r'))
            continue;
        assert_true(finder(&o, keys[i], value - width, value + 1.5L * width, &orbit));
        check_near((double)(*closed_value(&orbit.oscillator, keys[i]) - value), 0, 1e-15);
        check_near((double)(orbit.impact[0].speed - point->impact[0].speed), 0, 1e-15);
    }
}

/* The special points on the examples' branches, each between two values that separate it from the others. */
static void points_of_examples(void **unused) {
    (void)unused;
    static const struct {
        closed_example example;
        closed_finder *finder;
        long double lo, hi, omega, speed;
    } rows[] = {
        {closed_one_period, closed_grazing, 0.7L, 0.75L, 0.710687369094L, 0},
        {closed_one_period, closed_flip, 0.9L, 1, 0.960556862139L, 0.755736341628L},
        {closed_one_period, closed_fold, 1.4L, 1.7L, 1.571571311000L, 2.193493258542L},
        {closed_one_period, closed_grazing, 1.2L, 1.3L, 1.218574356948L, 0},
        {closed_one_period_loaded, closed_grazing, 0.9L, 1, 0.940905064593L, 0},
        {closed_one_period_loaded, closed_flip, 1.1L, 1.2L, 1.122037621506L, 0.602735876904L},
        {closed_one_period_loaded, closed_fold, 1.6L, 1.7L, 1.664138578555L, 1.279232488803L},
        {closed_one_period_loaded, closed_grazing, 1.4L, 1.5L, 1.440381081319L, 0},
        {closed_two_periods, closed_grazing, 0.795L, 0.8L, 0.797206365892L, 0},
        {closed_two_periods, closed_fold, 0.795L, 0.8L, 0.796929774760L, 0.112502496204L},
        {closed_two_periods, closed_flip, 0.92L, 0.95L, 0.935395437233L, 0.903402325166L},
        {closed_two_periods, closed_flip, 0.95L, 0.97L, 0.958724095036L, 0.989706700809L},
        {closed_two_periods_light, closed_grazing, 0.798L, 0.8L, 0.799005444785L, 0},
        {closed_two_periods_light, closed_fold, 0.798L, 0.8L, 0.798856675617L, 0.145100997935L},
        {closed_two_periods_light, closed_flip, 0.9L, 0.95L, 0.906615986518L, 0.809863505637L},
        {closed_two_periods_light, closed_flip, 0.98L, 0.995L, 0.990128743761L, 1.134864237549L},
        {closed_mirrored, closed_pitchfork, 3.4L, 3.6L, 3.498582192006L, 4.087539274502L},
        {closed_mirrored_bubble, closed_pitchfork, 1.08L, 1.12L, 1.101347196575L, 1.333056048730L},
        {closed_mirrored_bubble, closed_pitchfork, 1.16L, 1.19L, 1.177285960227L, 1.344044941682L},
        {closed_mirrored_bubble, closed_fold, 3.7L, 3.8L, 3.754824903392L, 2.613874052652L},
        {closed_mirrored_bubble, closed_grazing, 1.5L, 1.6L, 1.565139634729L, 0},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        closed_oscillator o = closed_example_of(rows[i].example);
        closed_orbit orbit;
        assert_true(rows[i].finder(&o, "omega", rows[i].lo, rows[i].hi, &orbit));
        check_found(&orbit, rows[i].omega, rows[i].speed);
        check_every_parameter(&orbit, rows[i].finder);
        if (rows[i].finder == closed_grazing)
            continue;
        assert_true(orbit.admissible);
        check_near((double)orbit.multiplier[0][0], rows[i].finder == closed_flip ? -1 : 1, 1e-14);
        assert_true(fabsl(orbit.multiplier[1][0]) < 1);
    }
}

/* An orbit that touches a stop between its impacts is admissible on one side only. */
static void touches_of_examples(void **unused) {
    (void)unused;
    static const long double rows[2][2] = {{0.990614188883L, 1.118523792746L},
                                           {0.996110492512L, 1.162122615060L}};
    for (int i = 0; i < 2; i++) {
        closed_oscillator o = closed_example_of(i ? closed_two_periods_light : closed_two_periods);
        closed_orbit orbit;
        assert_true(closed_touch(&o, "omega", 0.98L, 1, 1, &orbit));
        check_found(&orbit, rows[i][0], rows[i][1]);
        check_near((double)orbit.margin, 0, 1e-16);
        for (int side = -1; side <= 1; side += 2) {
            closed_oscillator beside = orbit.oscillator;
            closed_orbit other;
            beside.omega += side * 1e-6L;
            assert_true(closed_orbit_at(&beside, 1, &other));
            assert_int_equal(other.admissible, side < 0);
        }
    }
}

/* Below the pitchfork in omega a stable pair replaces the mirrored orbit, until it flips. */
static void pair_of_examples(void **unused) {
    (void)unused;
    closed_oscillator o = closed_example_of(closed_mirrored);
    closed_orbit pitchfork, mirrored, one, other;
    assert_true(closed_pitchfork(&o, "omega", 3.4L, 3.6L, &pitchfork));
    /* Near the pitchfork the pair loses accuracy: digits are lost as 1 / skew^2. */
    for (int k = 1; k <= 3; k++) {
        o.omega = pitchfork.oscillator.omega - powl(0.1L, 2 * k);
        assert_true(closed_orbit_at(&o, 1, &mirrored));
        assert_true(closed_pair_at(&pitchfork, "omega", 1, o.omega, &one));
        assert_true(closed_pair_at(&pitchfork, "omega", -1, o.omega, &other));
        assert_true(mirrored.admissible && mirrored.multiplier[0][0] > 1);
        assert_true(one.admissible && fabsl(one.multiplier[0][0]) < 1);
        check_near((double)(one.oscillator.omega - o.omega), 0, 1e-14);
        check_near((double)(one.multiplier[0][0] - other.multiplier[0][0]), 0, 1e-12);
        /* The mirror image of one is the other half a period later. */
        check_near((double)(one.impact[0].speed - other.impact[1].speed), 0, 1e-12);
        check_near((double)(one.impact[0].time - other.impact[1].time + closed_period(&o) / 2), 0, 1e-12);
        /* The critical multiplier leaves 1 twice as fast, and to the other side. */
        check_near((double)((1 - one.multiplier[0][0]) / (mirrored.multiplier[0][0] - 1)), 2,
                   2.0 * pow(0.1, k));
        o.omega = pitchfork.oscillator.omega + powl(0.1L, 2 * k);
        assert_true(closed_orbit_at(&o, 1, &mirrored));
        assert_true(fabsl(mirrored.multiplier[0][0]) < 1);
    }
    assert_true(closed_pair_flip(&pitchfork, "omega", 1, &one));
    check_found(&one, 2.724376708095L, 4.895314167639L);
    check_near((double)one.multiplier[0][0], -1, 1e-14);
    assert_true(one.admissible);
    assert_true(closed_pair_touch(&pitchfork, "omega", 1, &one));
    check_found(&one, 2.623693867310L, 5.067989257259L);
    check_near((double)one.margin, 0, 1e-16);
}

/* The library's orbit from a nearby guess: the same state, multipliers and determinant. */
static void check_with_library(const closed_orbit *closed) {
    const closed_oscillator *o = &closed->oscillator;
    saltus_spec spec = closed_spec(o);
    saltus_system *system = build(&spec);
    saltus_orbit_options options = saltus_orbit_defaults();
    saltus_message message = {.text = ""};
    saltus_orbit orbit;
    double guess[2] = {(double)closed->state[0] + 1e-7, (double)closed->state[1] - 1e-7};
    assert_true(closed->admissible);
    check_ok(saltus_orbit_find(system, o->periods, guess, &options, &orbit, &message), &message);
    for (int i = 0; i < 2; i++) {
        check_near(orbit.state[i], (double)closed->state[i], 1e-11);
        check_near(orbit.multipliers[i].re, (double)closed->multiplier[i][0], 1e-10);
        check_near(fabs(orbit.multipliers[i].im), (double)fabsl(closed->multiplier[i][1]), 1e-10);
    }
    for (int i = 0; i < 4; i++)
        check_near(orbit.monodromy[i], (double)closed->monodromy[i],
                   1e-10 * fmax(1, fabs(orbit.monodromy[i])));
    long double det = powl(o->r, 2 * closed->impacts) * expl(-o->c * o->periods * closed_period(o));
    check_near((double)(closed->monodromy[0] * closed->monodromy[3] -
                        closed->monodromy[1] * closed->monodromy[2] - det),
               0, 1e-16);
    saltus_orbit_clear(&orbit);
    saltus_system_free(system);
}

static void library_agrees(void **unused) {
    (void)unused;
    static const struct {
        closed_example example;
        long double omega;
        int branch;
    } rows[] = {{closed_one_period, 0.85L, 1},        {closed_one_period, 1.1L, 1},
                {closed_one_period, 1.5L, 1},         {closed_one_period, 1.5L, -1},
                {closed_one_period_loaded, 1, 1},     {closed_one_period_loaded, 1.6L, -1},
                {closed_two_periods, 0.797L, -1},     {closed_two_periods, 0.82L, 1},
                {closed_two_periods, 0.94L, 1},       {closed_two_periods, 0.98L, 1},
                {closed_two_periods_light, 0.85L, 1}, {closed_mirrored, 3.6L, 1},
                {closed_mirrored, 2.9L, 1},           {closed_mirrored_bubble, 1.14L, 1},
                {closed_mirrored_bubble, 2.5L, 1},    {closed_mirrored_bubble, 3, -1}};
    closed_orbit orbit, pitchfork;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        closed_oscillator o = closed_example_of(rows[i].example);
        o.omega = rows[i].omega;
        assert_true(closed_orbit_at(&o, rows[i].branch, &orbit));
        check_with_library(&orbit);
    }
    closed_oscillator o = {.c = 0.1L, .k = 1, .F = 0.09999L, .omega = 1, .d = 1, .r = 0.8L, .periods = 1};
    assert_true(closed_orbit_at(&o, 1, &orbit));
    check_with_library(&orbit);
    o = closed_example_of(closed_mirrored);
    assert_true(closed_pitchfork(&o, "omega", 3.4L, 3.6L, &pitchfork));
    for (int k = 0; k < 6; k++) {
        assert_true(closed_pair_at(&pitchfork, "omega", k % 2 ? 1 : -1, 2.65L + 0.15L * k, &orbit));
        check_with_library(&orbit);
    }
}

/* The ball on the table: the library's orbit has the closed one's state and multipliers. */
static void library_agrees_on_table(void **unused) {
    (void)unused;
    for (int k = 1; k <= 2; k++) {
        closed_table closed;
        saltus_spec spec = oscillator_spec(0, 0, k + 0.35, 1);
        set_parameter(&spec, "F0", -1);
        add_stop(&spec, 0, 0.5, SALTUS_LOWER);
        saltus_system *system = build(&spec);
        saltus_orbit_options options = saltus_orbit_defaults();
        saltus_message message = {.text = ""};
        saltus_orbit orbit;
        assert_true(closed_table_orbit(k, 0.5L, k + 0.35L, 1, &closed));
        double guess[2] = {(double)closed.state[0], (double)closed.state[1]};
        check_ok(saltus_orbit_find(system, k, guess, &options, &orbit, &message), &message);
        for (int i = 0; i < 2; i++) {
            check_near(orbit.state[i], guess[i], 1e-11);
            check_near(orbit.multipliers[i].re, (double)closed.multiplier[i][0], 1e-10);
            check_near(fabs(orbit.multipliers[i].im), (double)fabsl(closed.multiplier[i][1]), 1e-10);
        }
        saltus_orbit_clear(&orbit);
        saltus_system_free(system);
    }
}

/* Two balls joined by a spring and a damper hit the table at once: the relative motion loses volume all the
 * time, and each impact takes the factor r^2; the sum rule counts no time twice. */
static void two_balls_at_once(void **unused) {
    (void)unused;
    const double r = 0.5, c2 = 0.1, force = 1.2 * (double)closed_table_fold(1, 0.5L);
    closed_table closed;
    assert_true(closed_table_orbit(1, (long double)r, (long double)force, 1, &closed));
    saltus_spec spec = oscillator_spec(0, 0, force, 1);
    set_parameter(&spec, "N", 2);
    set_parameter(&spec, "k2", 0.3);
    set_parameter(&spec, "c2", c2);
    set_parameter(&spec, "F2", force);
    set_parameter(&spec, "F0", -1);
    set_parameter(&spec, "F02", -1);
    for (int mass = 0; mass < 2; mass++) {
        add_stop(&spec, 0, r, SALTUS_LOWER);
        spec.stops[mass].weight[0] = mass == 0;
        spec.stops[mass].weight[1] = mass == 1;
    }
    saltus_system *system = build(&spec);
    saltus_message message = {.text = ""};
    saltus_orbit orbit;
    saltus_orbit_options options = saltus_orbit_defaults();
    double y = (double)closed.state[0], v = (double)closed.state[1], state[4] = {y, y, v, v};
    double rule = 4 * log(r) - 2 * c2 * saltus_system_period(system);
    check_ok(saltus_orbit_find(system, 1, state, &options, &orbit, &message), &message);
    for (int i = 0; i < 4; i++)
        check_near(orbit.state[i], state[i], 1e-10);
    check_near(orbit.sum_rule, rule, 1e-10);
    saltus_orbit_clear(&orbit);
    saltus_lyapunov_options how = saltus_lyapunov_defaults();
    saltus_lyapunov exponents;
    how.exponents = 0;
    how.members = 1;
    how.transient = 10;
    how.periods = 200;
    check_ok(saltus_lyapunov_run(system, state, &how, &exponents, &message), &message);
    check_near(exponents.sum_rule, rule / exponents.period, 1e-7);
    saltus_lyapunov_clear(&exponents);
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_period_orbits),       cmocka_unit_test(two_period_orbits),
        cmocka_unit_test(undamped_orbits),         cmocka_unit_test(table_orbits),
        cmocka_unit_test(points_of_examples),      cmocka_unit_test(touches_of_examples),
        cmocka_unit_test(pair_of_examples),        cmocka_unit_test(library_agrees),
        cmocka_unit_test(library_agrees_on_table), cmocka_unit_test(two_balls_at_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
