/* Curves of special points in two parameters: on the closed forms' curves, and, of the pipe, each point
 * checked by an independent search.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch_check.h"
#include "reference.h"

/* A curve in the plane of omega and d, from an orbit with d as in the example. */
typedef struct closed_curve {
    closed_example example;
    long double omega;
    saltus_point_kind kind;
    double low[2], high[2];
} closed_curve;

static const closed_curve curves[] = {
    {closed_one_period, 1.1L, SALTUS_POINT_LP, {0.6, 0.5}, {1.8, 2}},
    {closed_one_period, 1.1L, SALTUS_POINT_PD, {0.6, 0.5}, {1.8, 2}},
    {closed_one_period, 1.1L, SALTUS_POINT_GR, {0.6, 0.5}, {1.8, 2}},
    {closed_one_period_loaded, 1.2L, SALTUS_POINT_LP, {0.8, 0.5}, {1.9, 2}},
    {closed_one_period_loaded, 1.2L, SALTUS_POINT_PD, {0.8, 0.5}, {1.9, 2}},
    {closed_one_period_loaded, 1.2L, SALTUS_POINT_GR, {0.8, 0.5}, {1.9, 2}},
    {closed_two_periods, 0.85L, SALTUS_POINT_LP, {0.78, -0.3}, {1.1, 0.3}},
    {closed_two_periods, 0.85L, SALTUS_POINT_PD, {0.78, -0.3}, {1.1, 0.3}},
    {closed_two_periods, 0.85L, SALTUS_POINT_GR, {0.78, -0.3}, {1.1, 0.3}},
    {closed_mirrored_bubble, 2.5L, SALTUS_POINT_LP, {1, 0.5}, {4, 2}},
    {closed_mirrored_bubble, 2.5L, SALTUS_POINT_GR, {1, 0.5}, {4, 2}},
};

static const closed_curve symmetric = {closed_mirrored, 3.6L, SALTUS_POINT_BP, {2.3, 0.7}, {4, 1.4}};

static saltus_branch_options locus_options(saltus_point_kind kind, const double *low, const double *high) {
    saltus_branch_options options = branch_along("omega", low[0], high[0]);
    snprintf(options.key[1], sizeof options.key[1], "d");
    options.low[1] = low[1];
    options.high[1] = high[1];
    options.locus = kind;
    return options;
}

/* The closed form's point beside a point of the plane, sought along one of the parameters; the distance to it
 * along that parameter. INFINITY: none. */
static double along_key(closed_oscillator o, const char *key, saltus_point_kind kind, closed_orbit *orbit) {
    long double value = *closed_value(&o, key);
    for (long double width = 1e-7L; width < 2e-3L; width *= 10) {
        long double lo = value - width, hi = value + 1.1L * width;
        bool there = kind == SALTUS_POINT_LP   ? closed_fold(&o, key, lo, hi, orbit)
                     : kind == SALTUS_POINT_PD ? closed_flip(&o, key, lo, hi, orbit)
                     : kind == SALTUS_POINT_BP ? closed_pitchfork(&o, key, lo, hi, orbit)
                                               : closed_grazing(&o, key, lo, hi, orbit);
        if (there)
            return (double)fabsl(*closed_value(&orbit->oscillator, key) - value);
    }
    return INFINITY;
}

/* The distance to the nearer of the two. Where no impact is without speed, the distance from touching between
 * impacts. */
static double off_curve(const closed_oscillator *start, saltus_point_kind kind, const double *place,
                        closed_orbit *orbit) {
    closed_oscillator o = *start;
    closed_orbit found;
    o.omega = place[0];
    o.d = place[1];
    double in_omega = along_key(o, "omega", kind, orbit), in_d = along_key(o, "d", kind, &found);
    if (in_d < in_omega)
        *orbit = found;
    double off = fmin(in_omega, in_d);
    if (kind == SALTUS_POINT_GR && isinf(off) && closed_orbit_at(&o, 1, orbit))
        off = (double)fabsl(orbit->margin);
    return off;
}

static bool on_border(const closed_curve *c, const double *place) {
    for (int i = 0; i < 2; i++)
        if (fabs(place[i] - c->low[i]) < 1e-12 || fabs(place[i] - c->high[i]) < 1e-12)
            return true;
    return false;
}

/* A point on its curve, with the multiplier that makes it. */
static void check_on_curve(const closed_curve *c, const closed_oscillator *o,
                           const saltus_branch_point *point) {
    closed_orbit orbit = {.impacts = 0};
    double off = off_curve(o, c->kind, point->value, &orbit);
    if (!(off < 1e-9))
        fail_msg("%s at (%.12g, %.12g) is %.3g off its curve", saltus_point_word(c->kind), point->value[0],
                 point->value[1], off);
    if (point->kind == SALTUS_POINT_EP) {
        /* The curve leaves the range, or the impact's speed has vanished: there it meets grazing. */
        assert_true(on_border(c, point->value) || orbit.impact[0].speed < 1e-3L);
        return;
    }
    assert_int_equal(point->kind, c->kind);
    assert_true(point->admissible);
    if (c->kind == SALTUS_POINT_GR || orbit.impact[0].speed < 1e-3L)
        return;
    check_near(point->multipliers[0].re, c->kind == SALTUS_POINT_PD ? -1 : 1, 1e-7);
    check_near(point->multipliers[1].re, (double)orbit.multiplier[1][0], 1e-7);
}

static branch_record run_curve(const closed_curve *c, closed_oscillator *o) {
    closed_orbit orbit;
    saltus_branch_options options = locus_options(c->kind, c->low, c->high);
    *o = closed_example_of(c->example);
    o->omega = c->omega;
    assert_true(closed_orbit_at(o, 1, &orbit) && orbit.admissible);
    saltus_spec spec = closed_spec(o);
    double state[2] = {(double)orbit.state[0], (double)orbit.state[1]};
    return branch_run(&spec, o->periods, state, &options);
}

static void check_curve(const closed_curve *c) {
    closed_oscillator o;
    int ways[2] = {0};
    branch_record record = run_curve(c, &o);
    for (int k = 0; k < record.count; k++) {
        assert_in_range(record.point[k].branch, 0, 1);
        ways[record.point[k].branch]++;
        check_on_curve(c, &o, &record.point[k]);
    }
    for (int way = 0; way < 2; way++)
        assert_in_range(ways[way], 5, 2000);
    branch_forget(&record);
}

/* A point's specification has the point's parameters, and its state is the orbit there, at the ends too. */
static void points_are_where_they_say(void **unused) {
    (void)unused;
    for (size_t c = 0; c < sizeof curves / sizeof curves[0]; c++) {
        closed_oscillator o;
        branch_record record = run_curve(&curves[c], &o);
        for (int k = 0; k < record.count; k++) {
            const saltus_branch_point *point = &record.point[k];
            check_near(saltus_spec_get(&point->spec, "omega"), point->value[0], 1e-12);
            check_near(point->spec.stops[0].d, point->value[1], 1e-12);
            assert_true(point->admissible);
        }
        branch_forget(&record);
    }
}

static void curves_in_closed_form(void **unused) {
    (void)unused;
    for (size_t k = 0; k < sizeof curves / sizeof curves[0]; k++)
        check_curve(&curves[k]);
}

static void curve_of_mirror_breaking(void **unused) {
    (void)unused;
    check_curve(&symmetric);
}

/* One degree of freedom with losses has no complex pair on the unit circle: the search says that it found
 * none. */
static void no_torus(void **unused) {
    (void)unused;
    closed_oscillator o = closed_example_of(closed_one_period);
    closed_orbit orbit;
    const double low[2] = {0.6, 0.5}, high[2] = {1.8, 2};
    saltus_branch_options options = locus_options(SALTUS_POINT_NS, low, high);
    saltus_branch *branch = NULL;
    saltus_message message = {""};
    const saltus_branch_point *point;
    o.omega = 1.1L;
    assert_true(closed_orbit_at(&o, 1, &orbit));
    saltus_spec spec = closed_spec(&o);
    double state[2] = {(double)orbit.state[0], (double)orbit.state[1]};
    check_ok(saltus_branch_new(&spec, 1, state, &options, &branch, &message), &message);
    assert_int_equal(saltus_branch_step(branch, &point, &message), SALTUS_NO_CONVERGENCE);
    assert_null(point);
    assert_non_null(strstr(message.text, "NS"));
    saltus_branch_free(branch);
}

/* The pipe. */

/* The slowest impact, or the nearest free maximum in terms of the speed that it lacks, of an orbit: in units
 * of the system's speeds. */
static double slowest_contact(const saltus_system *system, int periods, const double *state) {
    saltus_flow_options options = saltus_flow_defaults();
    double scale = saltus_system_scale(system)[saltus_system_dof(system)], slowest = INFINITY;
    double d = saltus_system_face(system, 0).d;
    saltus_flow *flow = open_flow(system, &options, 0, state);
    for (;;) {
        saltus_event event = advance(flow, periods, SALTUS_WATCH_CONTACT | SALTUS_WATCH_TURNING);
        if (event.kind == SALTUS_REACHED)
            break;
        if (event.kind == SALTUS_IMPACT)
            slowest = fmin(slowest, fabs(event.velocity_before));
        if (event.kind == SALTUS_TURNING && event.velocity_before < 0)
            slowest = fmin(slowest, sqrt(2 * fabs(event.velocity_before * (event.displacement - d))));
    }
    saltus_flow_free(flow);
    return slowest / scale;
}

/* The multiplier nearest to the unit circle. */
static const saltus_multiplier *critical(const saltus_orbit *orbit) {
    int nearest = 0;
    for (int i = 1; i < orbit->dimension; i++)
        if (fabs(orbit->multipliers[i].log_modulus) < fabs(orbit->multipliers[nearest].log_modulus))
            nearest = i;
    return &orbit->multipliers[nearest];
}

/* The orbit found anew at the point's parameters: the same, and with the multiplier or the grazing that makes
 * the point. Almost at grazing, where curves meet, multipliers are no longer determined. */
static void check_anew(const saltus_branch_point *point, saltus_point_kind kind) {
    saltus_system *system = build(&point->spec);
    double slowest = slowest_contact(system, point->periods, point->state);
    saltus_orbit_options options = saltus_orbit_defaults();
    saltus_message message = {""};
    saltus_orbit orbit;
    if (kind == SALTUS_POINT_GR) {
        assert_true(slowest < 1e-6);
    } else if (slowest > 1e-4) {
        check_ok(saltus_orbit_find(system, point->periods, point->state, &options, &orbit, &message),
                 &message);
        for (int i = 0; i < point->dimension; i++)
            check_near(orbit.state[i] / saltus_system_scale(system)[i],
                       point->state[i] / saltus_system_scale(system)[i], 1e-9);
        const saltus_multiplier *mu = critical(&orbit);
        check_near(mu->log_modulus, 0, 1e-7);
        if (kind == SALTUS_POINT_NS)
            assert_true(fabs(mu->im) > 1e-3);
        else
            check_near(mu->re, kind == SALTUS_POINT_PD ? -1 : 1, 1e-7);
        saltus_orbit_clear(&orbit);
    }
    saltus_system_free(system);
}

static void check_pipe_curve(saltus_point_kind kind, const double *low, const double *high, int least) {
    reference r = read_reference("fig7d");
    saltus_branch_options options = locus_options(kind, low, high);
    options.step_max = 0.04;
    branch_record record = branch_run(&r.spec, r.periods, r.states[0], &options);
    int checked = 0;
    for (int k = 0; k < record.count; k++) {
        const saltus_branch_point *point = &record.point[k];
        if (point->kind == SALTUS_POINT_EP)
            continue;
        assert_int_equal(point->kind, kind);
        assert_true(point->admissible);
        check_anew(point, kind);
        checked++;
    }
    assert_true(checked >= least);
    branch_forget(&record);
    free(r.text);
}

static const double pipe_low[2] = {35, 0.03}, pipe_high[2] = {56, 0.04};

static void pipe_folds(void **unused) {
    (void)unused;
    check_pipe_curve(SALTUS_POINT_LP, pipe_low, pipe_high, 25);
}

static void pipe_flips(void **unused) {
    (void)unused;
    check_pipe_curve(SALTUS_POINT_PD, pipe_low, pipe_high, 15);
}

static void pipe_grazing(void **unused) {
    (void)unused;
    check_pipe_curve(SALTUS_POINT_GR, pipe_low, pipe_high, 20);
}

static void pipe_tori(void **unused) {
    (void)unused;
    const double low[2] = {38.5, 0.0345}, high[2] = {42.2, 0.03545};
    check_pipe_curve(SALTUS_POINT_NS, low, high, 10);
}

/* The curve ends where the pair meets at 1 or -1: beyond it there are two real multipliers whose product is
 * 1, and nothing happens to the orbit. */
static void tori_end_at_resonance(void **unused) {
    (void)unused;
    const double low[2] = {38.5, 0.0345}, high[2] = {42.2, 0.0361};
    check_pipe_curve(SALTUS_POINT_NS, low, high, 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(curves_in_closed_form),
        cmocka_unit_test(points_are_where_they_say),
        cmocka_unit_test(curve_of_mirror_breaking),
        cmocka_unit_test(no_torus),
        cmocka_unit_test(pipe_folds),
        cmocka_unit_test(pipe_flips),
        cmocka_unit_test(pipe_grazing),
        cmocka_unit_test(pipe_tori),
        cmocka_unit_test(tori_end_at_resonance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
