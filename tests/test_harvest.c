/* Harvest: every orbit is followed again by other means than those that found it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "closed_sticking.h"
#include "recount.h"

#include "orbit/multipliers.h"

#include <gsl/gsl_eigen.h>

enum { dimension_max = 10 };

static saltus_system *scene_system(const char *name, const char *set) {
    saltus_scene scene;
    saltus_message message = {.text = ""};
    check_ok(saltus_scene_load(name, &scene, &message), &message);
    if (set)
        check_ok(saltus_scene_set(&scene, set, &message), &message);
    return build(&scene.spec);
}

static double scaled_distance(const saltus_system *system, double sign, const double *a, const double *b) {
    double largest = 0;
    for (int i = 0; i < saltus_system_dimension(system); i++)
        largest = fmax(largest, fabs(sign * a[i] - b[i]) / saltus_system_scale(system)[i]);
    return largest;
}

static const double *section_point(const saltus_harvest_orbit *found, int k) {
    return found->section_states + (k % found->orbit.periods) * found->orbit.dimension;
}

/* The implicit integrator, started at two section phases, returns to its start and meets as many impacts. */
static void walks_again(const saltus_system *system, const saltus_harvest_orbit *found) {
    saltus_flow_options options = saltus_flow_defaults();
    double begin[dimension_max], end[dimension_max], growth = exp(found->orbit.multipliers[0].log_modulus);
    options.integrator = SALTUS_RADAU;
    saltus_flow *flow = open_flow(system, &options, 0, found->orbit.state);
    advance(flow, found->orbit.periods, 0);
    saltus_flow_state(flow, 0, end);
    check_near(scaled_distance(system, 1, end, found->orbit.state), 0, 1e-11 * (1 + growth));
    if (found->impacts >= 0)
        assert_int_equal(saltus_flow_information(flow, 0).impacts, found->impacts);
    saltus_flow_free(flow);
    flow = open_flow(system, &options, 0, found->orbit.state);
    advance(flow, 0.37, 0);
    saltus_flow_state(flow, 0, begin);
    saltus_flow_free(flow);
    flow = open_flow(system, &options, 0.37, begin);
    advance(flow, found->orbit.periods + 0.37, 0);
    saltus_flow_state(flow, 0, end);
    check_near(scaled_distance(system, 1, end, begin), 0, 1e-11 * (1 + growth));
    saltus_flow_free(flow);
}

/* Eigenvalue and eigenvector, in the system's scales, of the monodromy matrix's largest eigenvalue. */
static gsl_complex leading_vector(const saltus_system *system, const saltus_orbit *orbit, double *vector) {
    int n = orbit->dimension;
    const double *scale = saltus_system_scale(system);
    gsl_matrix *matrix = gsl_matrix_alloc((size_t)n, (size_t)n);
    gsl_matrix_complex *vectors = gsl_matrix_complex_alloc((size_t)n, (size_t)n);
    gsl_vector_complex *values = gsl_vector_complex_alloc((size_t)n);
    gsl_eigen_nonsymmv_workspace *work = gsl_eigen_nonsymmv_alloc((size_t)n);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            gsl_matrix_set(matrix, (size_t)i, (size_t)j, orbit->monodromy[i * n + j] * scale[j] / scale[i]);
    assert_int_equal(gsl_eigen_nonsymmv(matrix, values, vectors, work), 0);
    gsl_eigen_nonsymmv_sort(values, vectors, GSL_EIGEN_SORT_ABS_DESC);
    for (int i = 0; i < n; i++)
        vector[i] = scale[i] * GSL_REAL(gsl_matrix_complex_get(vectors, (size_t)i, 0));
    gsl_complex value = gsl_vector_complex_get(values, 0);
    gsl_eigen_nonsymmv_free(work);
    gsl_vector_complex_free(values);
    gsl_matrix_complex_free(vectors);
    gsl_matrix_free(matrix);
    return value;
}

/* A displacement along the leading eigenvector, small at both ends, grows by the largest multiplier. */
static void grows_as_told(const saltus_system *system, const saltus_harvest_orbit *found) {
    const saltus_orbit *orbit = &found->orbit;
    const saltus_multiplier mu = orbit->multipliers[0];
    double small = 1e-6 * exp(-0.5 * mu.log_modulus);
    int n = orbit->dimension;
    saltus_orbit_options options = saltus_orbit_defaults();
    double vector[dimension_max], start[dimension_max], end[dimension_max];
    check_near(GSL_REAL(leading_vector(system, orbit, vector)), mu.re, 1e-9 * hypot(mu.re, mu.im));
    if (mu.im != 0)
        return;
    for (int i = 0; i < n; i++)
        start[i] = orbit->state[i] + small * vector[i];
    saltus_flow *flow = open_flow(system, &options.flow, 0, start);
    advance(flow, orbit->periods, 0);
    saltus_flow_state(flow, 0, end);
    saltus_flow_free(flow);
    for (int i = 0; i < n; i++)
        end[i] = (end[i] - orbit->state[i]) / small / mu.re;
    check_near(scaled_distance(system, 1, end, vector), 0, 0.01);
}

static void distinct(const saltus_system *system, const saltus_harvest *harvest) {
    for (int a = 0; a < harvest->count; a++) {
        const saltus_harvest_orbit *one = &harvest->orbits[a];
        for (int k = 1; k < one->orbit.periods; k++)
            assert_true(scaled_distance(system, 1, section_point(one, k), one->orbit.state) > 1e-6);
        for (int b = 0; b < a; b++)
            for (int k = 0; k < harvest->orbits[b].orbit.periods; k++)
                assert_true(scaled_distance(system, 1, section_point(&harvest->orbits[b], k),
                                            one->orbit.state) > 1e-6);
    }
}

static void sorted(const saltus_harvest *harvest) {
    for (int k = 1; k < harvest->count; k++) {
        const saltus_orbit *a = &harvest->orbits[k - 1].orbit, *b = &harvest->orbits[k].orbit;
        assert_true(a->periods < b->periods ||
                    (a->periods == b->periods &&
                     a->multipliers[0].log_modulus < b->multipliers[0].log_modulus + 1e-6));
    }
}

/* Check all properties of each orbit; returns how many are unstable. */
static int check_orbits(const saltus_system *system, const saltus_harvest *harvest) {
    int unstable = 0;
    for (int k = 0; k < harvest->count; k++) {
        const saltus_harvest_orbit *found = &harvest->orbits[k];
        assert_true(found->orbit.residual < 1e-11);
        assert_int_equal(found->mirror, -1);
        if (found->impacts >= 0)
            assert_int_equal(found->impacts_by_face[0], found->impacts);
        unstable += found->orbit.multipliers[0].log_modulus > 0;
        if (!found->orbit.sticks)
            check_near(found->orbit.log_volume, found->orbit.sum_rule, 1e-9 * fabs(found->orbit.sum_rule));
        walks_again(system, found);
        grows_as_told(system, found);
    }
    return unstable;
}

/* Figure 7(c) is chaotic. */
static void orbits_of_chaos(void **unused) {
    (void)unused;
    saltus_system *system = scene_system("fig7c", NULL);
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {.text = ""};
    saltus_harvest harvest;
    options.periods = 400;
    options.tries = 5;
    options.longest = 4;
    options.recurrence = 0.2;
    check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
    distinct(system, &harvest);
    sorted(&harvest);
    assert_true(check_orbits(system, &harvest) >= 3);
    saltus_harvest_clear(&harvest);
    saltus_system_free(system);
}

/* Chaos of an oscillator with one stop. */
static saltus_system *chaotic_oscillator(void) {
    closed_oscillator o = {.c = 0.04L, .k = 1, .F = 0.363L, .F0 = -1, .omega = 0.9166L, .r = 0.9L};
    saltus_spec spec = closed_spec(&o);
    return build(&spec);
}

/* The counts add up, and each option has its effect. */
static void options_of_a_harvest(void **unused) {
    (void)unused;
    saltus_system *system = chaotic_oscillator();
    saltus_harvest_options all = saltus_harvest_defaults(), options;
    saltus_message message = {.text = ""};
    saltus_harvest harvest, other;
    assert_true(all.longest == 8 && all.transient == 100 && all.periods == 5000 && all.recurrence == 0.1);
    assert_true(all.tries == 40 && all.most == 1000 && all.tolerance == 1e-11 && !all.state && all.seed == 1);
    all.periods = 1500;
    all.tries = 15;
    all.longest = 6;
    check_ok(saltus_harvest_run(system, &all, &harvest, &message), &message);
    distinct(system, &harvest);
    sorted(&harvest);
    assert_true(check_orbits(system, &harvest) >= 6);
    assert_true(harvest.periods == 1600 && harvest.face_count == 1 && harvest.dimension == 2);
    assert_true(harvest.converged >= harvest.count && harvest.candidates >= harvest.converged);
    assert_true(harvest.candidates <= all.tries * all.longest);
    for (int k = 0; k < harvest.count; k++) {
        const saltus_harvest_orbit *found = &harvest.orbits[k];
        recount r = recount_from(system, found->orbit.state, found->orbit.periods);
        assert_true(found->orbit.periods <= 6);
        assert_int_equal(found->impacts, r.impacts);
        assert_int_equal(found->sticking_intervals, 0);
        saltus_flow *flow = open_flow(system, &all.flow, 0, found->orbit.state);
        for (int p = 0; p < found->orbit.periods; p++) {
            double point[2];
            saltus_flow_state(flow, 0, point);
            check_near(scaled_distance(system, 1, point, section_point(found, p)), 0, 1e-9);
            advance(flow, p + 1, 0);
        }
        saltus_flow_free(flow);
    }
    assert_true(harvest.orbits[harvest.count - 1].orbit.periods > 3);
    /* With a smaller largest period: only orbits up to it. */
    options = all;
    options.longest = 3;
    check_ok(saltus_harvest_run(system, &options, &other, &message), &message);
    assert_true(other.count > 0 && other.count < harvest.count);
    for (int k = 0; k < other.count; k++) {
        assert_true(other.orbits[k].orbit.periods <= 3);
        check_near(scaled_distance(system, 1, other.orbits[k].orbit.state, harvest.orbits[k].orbit.state), 0,
                   1e-12);
    }
    saltus_harvest_clear(&other);
    /* Fewer attempts, a closer recurrence, a transient: other candidates. */
    options = all;
    options.tries = 2;
    check_ok(saltus_harvest_run(system, &options, &other, &message), &message);
    assert_true(other.candidates <= 12 && other.candidates > 3);
    saltus_harvest_clear(&other);
    options = all;
    options.recurrence = 1e-9;
    check_ok(saltus_harvest_run(system, &options, &other, &message), &message);
    assert_true(other.candidates == 0 && other.count == 0 && other.converged == 0);
    saltus_harvest_clear(&other);
    options = all;
    options.transient = 0;
    check_ok(saltus_harvest_run(system, &options, &other, &message), &message);
    assert_int_equal(other.periods, 1500);
    saltus_harvest_clear(&other);
    options = all;
    options.tolerance = 1e-30;
    check_ok(saltus_harvest_run(system, &options, &other, &message), &message);
    assert_true(other.candidates > 3 && other.count == 0 && other.converged == 0);
    saltus_harvest_clear(&other);
    saltus_harvest_clear(&harvest);
    saltus_harvest_clear(&harvest);
    saltus_system_free(system);
}

/* The trajectory depends on the seed or, if a state is given, on that alone. */
static void seeds_and_states(void **unused) {
    (void)unused;
    saltus_system *system = chaotic_oscillator();
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {.text = ""};
    saltus_harvest by[4];
    double start[2] = {-0.2, 0.1};
    options.periods = 300;
    options.longest = 4;
    options.transient = 3;
    for (int k = 0; k < 4; k++) {
        options.seed = 1 + (unsigned long)k % 2;
        options.state = k < 2 ? start : NULL;
        check_ok(saltus_harvest_run(system, &options, &by[k], &message), &message);
    }
    assert_true(by[0].candidates == by[1].candidates && by[0].count == by[1].count && by[0].count > 0);
    for (int k = 0; k < by[0].count; k++)
        assert_memory_equal(by[0].orbits[k].orbit.state, by[1].orbits[k].orbit.state, 2 * sizeof(double));
    assert_true(by[2].count != by[3].count || by[2].candidates != by[3].candidates ||
                by[2].orbits[0].orbit.state[0] != by[3].orbits[0].orbit.state[0]);
    for (int k = 0; k < 4; k++)
        saltus_harvest_clear(&by[k]);
    start[0] = 0.1; /* beyond the stop */
    options.state = start;
    assert_int_equal(saltus_harvest_run(system, &options, &by[0], &message), SALTUS_BAD_INPUT);
    assert_true(by[0].count == 0 && !by[0].orbits);
    saltus_system_free(system);
}

/* Orbits that rest on the stop, with and without rebound, against closed-form flights: impacts without
 * rebound are counted, complete chatter is not. */
static void resting_orbits(void **unused) {
    (void)unused;
    static const double table[][3] = {{0.4, -0.6, 0}, {0.8, -0.4, 0},  {2.4, 0, 0},
                                      {2.8, 0.2, 0},  {0.4, 0.2, 0.3}, {0.8, 0.4, 0.3}};
    for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
        closed_oscillator o = closed_sticking_example(table[k][0], table[k][1], table[k][2]);
        closed_sticking closed = closed_sticking_of(&o);
        saltus_spec spec = closed_spec(&o);
        saltus_system *system = build(&spec);
        saltus_harvest_options options = saltus_harvest_defaults();
        saltus_message message = {.text = ""};
        saltus_harvest harvest;
        options.transient = 20;
        options.periods = 60;
        options.longest = 4;
        check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
        assert_int_equal(harvest.count, 1);
        const saltus_harvest_orbit *found = &harvest.orbits[0];
        double closest = INFINITY;
        assert_int_equal(found->orbit.periods, closed.periods);
        for (int p = 0; p < closed.periods; p++)
            closest = fmin(closest, hypot(found->orbit.state[0] - (double)closed.state[p][0],
                                          found->orbit.state[1] - (double)closed.state[p][1]));
        check_near(closest, 0, 1e-12);
        assert_int_equal(found->sticking_intervals, 1);
        assert_true(found->orbit.sticks && found->mirror == -1);
        assert_int_equal(found->impacts, closed.chatter ? -1 : closed.impacts);
        recount r = recount_from(system, found->orbit.state, found->orbit.periods);
        assert_int_equal(found->impacts_by_face[0], r.impacts);
        assert_int_equal(r.chatter, closed.chatter);
        saltus_harvest_clear(&harvest);
        saltus_system_free(system);
    }
}

/* Just beyond their fold two orbits are 1e-5 apart: both are listed, stable one first. */
static void close_orbits_stay_two(void **unused) {
    (void)unused;
    closed_oscillator o = {.c = 0.64L, .k = 1, .F = 1, .omega = 0.5L, .d = 1, .r = 0.3L, .periods = 1};
    closed_orbit fold, at[2];
    long double grazing = 1 / closed_return_of(&o).amplitude;
    assert_true(closed_fold(&o, "F", 0.98L * grazing, (1 - 1e-7L) * grazing, &fold));
    long double by = 1e-6L, apart = 1;
    for (int k = 0; k < 60; k++) {
        o.F = fold.oscillator.F + by;
        assert_true(closed_orbit_at(&o, 1, &at[0]) && closed_orbit_at(&o, -1, &at[1]));
        apart = hypotl(at[0].state[0] - at[1].state[0], at[0].state[1] - at[1].state[1]);
        by *= 1e-10L / (apart * apart);
    }
    check_near((double)apart, 1e-5, 1e-8);
    int unstable = fabsl(at[0].multiplier[0][0]) > 1 ? 0 : 1;
    saltus_spec spec = closed_spec(&o);
    saltus_system *system = build(&spec);
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {.text = ""};
    saltus_harvest harvest;
    double start[2];
    for (int i = 0; i < 2; i++)
        start[i] =
            (double)(at[unstable].state[i] + 1e-8L * (at[1 - unstable].state[i] - at[unstable].state[i]));
    options.state = start;
    options.transient = 0;
    options.longest = 1;
    options.periods = 1500;
    options.tries = 1000;
    check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
    assert_int_equal(harvest.count, 2);
    for (int k = 0; k < 2; k++) {
        const closed_orbit *closed = &at[k ? unstable : 1 - unstable];
        for (int i = 0; i < 2; i++)
            check_near(harvest.orbits[k].orbit.state[i], (double)closed->state[i], 1e-7);
        check_near(harvest.orbits[k].orbit.multipliers[0].re, (double)closed->multiplier[0][0], 1e-3);
    }
    saltus_harvest_clear(&harvest);
    saltus_system_free(system);
}

/* Each listed orbit has its mirror image in the list: another orbit, or itself half an orbit later. */
static void check_mirrors(const saltus_system *system, const saltus_harvest *harvest, int *pairs, int *own) {
    for (int k = 0; k < harvest->count; k++) {
        const saltus_harvest_orbit *found = &harvest->orbits[k];
        assert_in_range(found->mirror, 0, harvest->count - 1);
        const saltus_harvest_orbit *image = &harvest->orbits[found->mirror];
        double closest = INFINITY;
        for (int p = 0; p < image->orbit.periods; p++)
            closest = fmin(closest, scaled_distance(system, -1, section_point(image, p), found->orbit.state));
        check_near(closest, 0, 1e-8);
        assert_int_equal(image->mirror, k);
        assert_int_equal(found->impacts_by_face[0], image->impacts_by_face[1]);
        *pairs += found->mirror != k;
        *own += found->mirror == k;
    }
}

/* Just beyond grazing an orbit enlarges rounding up to a hundred million times. What is found closes as well
 * as that lets it, and one of four periods is not one of two, with an error. */
static void orbits_beside_grazing_have_their_least_period(void **unused) {
    (void)unused;
    const double omega = 0.878, c = 0.02, far = 1e-4;
    saltus_spec spec = oscillator_spec(c, 1, 1.002 * hypot(1 - omega * omega, c * omega), omega);
    add_stop(&spec, 1, 0.8, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_harvest_options options = saltus_harvest_defaults();
    static const double start[] = {0.5, 0};
    int longer = 0;
    for (unsigned seed = 0; seed < 6; seed++) {
        saltus_harvest harvest;
        saltus_message message = {.text = ""};
        options.seed = seed;
        options.state = seed ? NULL : start;
        check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
        for (int k = 0; k < harvest.count; k++) {
            const saltus_harvest_orbit *found = &harvest.orbits[k];
            longer += found->orbit.periods > 3;
            for (int part = 1; part < found->orbit.periods; part++)
                if (found->orbit.periods % part == 0)
                    assert_true(scaled_distance(system, 1, section_point(found, part),
                                                section_point(found, 0)) > far);
            double end[2];
            saltus_flow_options closely = saltus_flow_defaults();
            closely.rtol = 1e-14;
            saltus_flow *flow = open_flow(system, &closely, 0, found->orbit.state);
            advance(flow, found->orbit.periods, 0);
            saltus_flow_state(flow, 0, end);
            check_near(scaled_distance(system, 1, end, found->orbit.state), 0,
                       1e-13 * (1 + exp(found->orbit.multipliers[0].log_modulus)));
            assert_int_equal(saltus_flow_information(flow, 0).impacts, found->impacts);
            saltus_flow_free(flow);
        }
        saltus_harvest_clear(&harvest);
    }
    assert_true(longer > 8);
    saltus_system_free(system);
}

/* Between two stops. A chaotic trajectory passes orbits by chance: several scenes, until both kinds were
 * found. */
static void mirror_images(void **unused) {
    (void)unused;
    static const char *const settings[] = {"d=0.02", "d=0.0202", "d=0.0204", "d=0.0206", "d=0.0208"};
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {.text = ""};
    int pairs = 0, own = 0;
    options.longest = 4;
    options.periods = 2000;
    options.tries = 20;
    for (int k = 0; k < 5 && !(pairs && own); k++) {
        saltus_system *system = scene_system("fig3", settings[k]);
        saltus_harvest harvest, again;
        check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
        distinct(system, &harvest);
        sorted(&harvest);
        assert_true(harvest.count >= 10);
        check_mirrors(system, &harvest, &pairs, &own);
        if (k == 0) {
            check_ok(saltus_harvest_run(system, &options, &again, &message), &message);
            assert_int_equal(harvest.count, again.count);
            for (int o = 0; o < harvest.count; o++)
                assert_memory_equal(harvest.orbits[o].orbit.state, again.orbits[o].orbit.state,
                                    2 * sizeof(double));
            saltus_harvest_clear(&again);
        }
        saltus_harvest_clear(&harvest);
        saltus_system_free(system);
    }
    assert_true(pairs > 0 && own > 0);
}

/* With direct forcing the image comes half a period later: a mirrored orbit is its own image, one of a pair
 * has the other in the list. */
static void images_half_a_period_later(void **unused) {
    (void)unused;
    for (int pair = 0; pair <= 1; pair++) {
        closed_oscillator o = closed_example_of(closed_mirrored);
        closed_orbit pitchfork, at[2];
        o.omega = pair ? 3 : 3.6L;
        assert_true(closed_pitchfork(&o, "omega", 3.4L, 3.6L, &pitchfork));
        if (pair)
            assert_true(closed_pair_at(&pitchfork, "omega", 1, o.omega, &at[0]) &&
                        closed_pair_at(&pitchfork, "omega", -1, o.omega, &at[1]));
        else
            assert_true(closed_orbit_at(&o, 1, &at[0]));
        saltus_spec spec = closed_spec(&o);
        saltus_system *system = build(&spec);
        saltus_harvest_options options = saltus_harvest_defaults();
        saltus_message message = {.text = ""};
        saltus_harvest harvest;
        double start[2] = {(double)at[0].state[0], (double)at[0].state[1] + 0.01};
        options.state = start;
        options.periods = 300;
        check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
        assert_int_equal(harvest.count, 1 + pair);
        assert_int_equal(harvest.face_count, 2);
        int first = harvest.orbits[0].orbit.state[0] > (double)at[0].state[0] - 1e-6 &&
                            harvest.orbits[0].orbit.state[0] < (double)at[0].state[0] + 1e-6
                        ? 0
                        : 1;
        for (int k = 0; k <= pair; k++) {
            const saltus_harvest_orbit *found = &harvest.orbits[k];
            assert_int_equal(found->mirror, pair ? 1 - k : 0);
            assert_true(found->impacts == 2 && found->impacts_by_face[0] == 1 &&
                        found->impacts_by_face[1] == 1);
            for (int i = 0; i < 2; i++)
                check_near(found->orbit.state[i], (double)at[k ^ first].state[i], 1e-9);
        }
        saltus_harvest_clear(&harvest);
        /* With room for one orbit a pair's image is left out and not referred to. */
        options.most = 1;
        check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
        assert_int_equal(harvest.count, 1);
        assert_int_equal(harvest.orbits[0].mirror, pair ? -1 : 0);
        saltus_harvest_clear(&harvest);
        saltus_system_free(system);
    }
}

/* A motion that settles gives its own orbit, once, with its least period. */
static void settled_motion(void **unused) {
    (void)unused;
    saltus_system *system = scene_system("fig7d", NULL);
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {.text = ""};
    saltus_harvest harvest;
    options.transient = 300;
    options.periods = 60;
    check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
    assert_int_equal(harvest.count, 1);
    assert_int_equal(harvest.orbits[0].orbit.periods, 4);
    assert_int_equal(harvest.orbits[0].impacts, 4);
    assert_true(harvest.orbits[0].orbit.multipliers[0].log_modulus < 0);
    saltus_harvest_clear(&harvest);
    saltus_system_free(system);
}

/* A progress callback: shares must grow from 0, through both halves of the work. */
static void share_grows(void *context, double done, double all) {
    double *last = context;
    assert_true(done >= *last && done <= 1 && all == 1);
    assert_true(*last >= 0 || done == 0);
    *last = done;
}

static void progress_is_told(void **unused) {
    (void)unused;
    saltus_system *system = chaotic_oscillator();
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {.text = ""};
    saltus_harvest harvest;
    double last = -1;
    volatile sig_atomic_t stop = 1;
    options.periods = 1000;
    options.longest = 4;
    options.tries = 5;
    options.progress = (saltus_progress){share_grows, &last};
    check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
    assert_true(last > 0.5 && harvest.count > 0);
    saltus_harvest_clear(&harvest);
    options.progress.show = NULL;
    options.flow.stop = &stop;
    check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
    assert_true(harvest.count == 0 && harvest.periods == 0);
    saltus_harvest_clear(&harvest);
    saltus_system_free(system);
}

static void options_out_of_range_are_refused(void **unused) {
    (void)unused;
    saltus_system *system = chaotic_oscillator();
    for (int k = 0; k < 14; k++) {
        saltus_harvest_options o = saltus_harvest_defaults();
        saltus_message message = {.text = ""};
        saltus_harvest harvest;
        bool fine = k >= 10;
        o.periods = 3;
        o.transient = k == 0 ? -1 : 0;
        o.periods = k == 1 ? 0 : k == 10 ? 1 : 3;
        o.longest = k == 2 ? 0 : k == 3 ? 257 : k == 11 ? 256 : 1;
        o.tries = k == 4 ? 0 : k == 5 ? 10001 : k == 12 ? 10000 : 1;
        o.most = k == 6 ? 0 : 1;
        o.recurrence = k == 7 ? 0 : k == 8 ? NAN : 1e-3;
        o.tolerance = k == 9 ? 0 : 1e-11;
        saltus_status status = saltus_harvest_run(system, &o, &harvest, &message);
        assert_int_equal(status, fine ? SALTUS_OK : SALTUS_BAD_INPUT);
        assert_true(fine || (message.text[0] && !harvest.orbits));
        saltus_harvest_clear(&harvest);
    }
    saltus_system_free(system);
}

/* A request to stop is final; the results so far are reported as those of a whole run. */
typedef struct caller {
    double at, seen;
    volatile sig_atomic_t stop;
} caller;

static void ask_to_stop(void *context, double done, double all) {
    caller *c = context;
    assert_true(!c->stop && all == 1);
    c->seen = done;
    c->stop = done >= c->at;
}

static void a_request_to_stop_is_final(void **unused) {
    (void)unused;
    static const double places[] = {0, 0.2, 0.5, 0.6, 0.8};
    saltus_system *system = chaotic_oscillator();
    int before = 0;
    for (int k = 0; k < 5; k++) {
        saltus_harvest_options options = saltus_harvest_defaults();
        saltus_message message = {.text = ""};
        saltus_harvest harvest;
        caller r = {.at = places[k]};
        options.periods = 1000;
        options.longest = 5;
        options.tries = 5;
        options.progress = (saltus_progress){ask_to_stop, &r};
        options.flow.stop = &r.stop;
        check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
        assert_true(r.stop && r.seen >= places[k]);
        if (k < 2)
            assert_true(harvest.periods == (long long)(2 * r.seen * 1100 + 0.5));
        else
            assert_int_equal(harvest.periods, 1100);
        assert_true(k > 2 ? harvest.count > 0 : harvest.count == 0 && harvest.candidates == 0);
        assert_true(harvest.count >= before);
        before = harvest.count;
        distinct(system, &harvest);
        sorted(&harvest);
        for (int o = 0; o < harvest.count; o++)
            assert_true(harvest.orbits[o].orbit.periods <= 5 * places[k] + 1 &&
                        harvest.orbits[o].mirror == -1);
        saltus_harvest_clear(&harvest);
    }
    saltus_system_free(system);
}

/* The caller's columns of the flow are ignored, other options of the flow are used. */
static void columns_of_the_flow_are_ignored(void **unused) {
    (void)unused;
    saltus_system *system = chaotic_oscillator();
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {.text = ""};
    saltus_harvest plain, other;
    options.periods = 300;
    options.longest = 3;
    options.tries = 3;
    check_ok(saltus_harvest_run(system, &options, &plain, &message), &message);
    options.flow.columns = 5;
    check_ok(saltus_harvest_run(system, &options, &other, &message), &message);
    assert_true(plain.count > 0 && other.count == plain.count && other.candidates == plain.candidates);
    for (int k = 0; k < plain.count; k++)
        assert_memory_equal(plain.orbits[k].orbit.state, other.orbits[k].orbit.state, 2 * sizeof(double));
    saltus_harvest_clear(&plain);
    saltus_harvest_clear(&other);
    options.flow.rtol = 0;
    assert_int_equal(saltus_harvest_run(system, &options, &other, &message), SALTUS_BAD_INPUT);
    assert_true(!other.orbits && other.count == 0 && message.text[0]);
    saltus_system_free(system);
}

/* A free mass is pulled away for ever: the harvest reports after how many periods it gave up, at 1e8 of the
 * system's scales. */
static void what_flies_away_is_given_up(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0, 0, 1e-3, 1);
    set_parameter(&spec, "F0", 100);
    saltus_system *system = build(&spec);
    const double *scale = saltus_system_scale(system), start[2] = {0};
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {.text = ""};
    saltus_harvest harvest;
    long long given_up = 0;
    int entry = 0;
    double x, period = saltus_system_period(system);
    options.state = start;
    options.longest = 1;
    options.periods = 100000;
    assert_int_equal(saltus_harvest_run(system, &options, &harvest, &message), SALTUS_STALLED);
    assert_int_equal(sscanf(message.text,
                            "the motion grows without bound: state entry %d is %lf after %lld periods",
                            &entry, &x, &given_up),
                     3);
    assert_true(entry == 1 || entry == 2);
    for (int before = 0; before < 2; before++) {
        double t = period * (double)(given_up - before), far = 50 * t * t / scale[0],
               fast = 100 * t / scale[1];
        assert_int_equal(fmax(far, fast) >= 1e8, !before);
        if (!before)
            assert_true(fabs(x / (50 * t * t) - 1) < 0.01 || fabs(x / (100 * t) - 1) < 0.01);
    }
    assert_null(harvest.orbits);
    saltus_system_free(system);
}

/* Between stops so close that no random position is admissible, the velocities are random. */
static void a_narrow_gap_has_random_starts(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {.text = ""};
    saltus_harvest harvest;
    add_stop(&spec, 5, 0.5, SALTUS_UPPER);
    add_stop(&spec, -5 + 1e-6, 0.5, SALTUS_LOWER);
    saltus_system *system = build(&spec);
    options.transient = 0;
    options.periods = 3;
    options.longest = 1;
    check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
    assert_int_equal(harvest.periods, 3);
    saltus_harvest_clear(&harvest);
    saltus_system_free(system);
}

static void limits_are_kept(void **unused) {
    (void)unused;
    saltus_system *system = scene_system("fig3", "d=0.02");
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {.text = ""};
    saltus_harvest harvest;
    caller soon = {.at = 0.1};
    options.most = 3;
    check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
    assert_int_equal(harvest.count, 3);
    saltus_harvest_clear(&harvest);
    options.progress = (saltus_progress){ask_to_stop, &soon};
    options.flow.stop = &soon.stop;
    check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
    assert_true(soon.seen >= 0.1 && harvest.periods < options.periods);
    saltus_harvest_clear(&harvest);
    options = saltus_harvest_defaults();
    options.longest = 0;
    assert_int_equal(saltus_harvest_run(system, &options, &harvest, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "longest"));
    saltus_system_free(system);
    system = scene_system("fig7c", "sigma=0");
    options = saltus_harvest_defaults();
    assert_int_equal(saltus_harvest_run(system, &options, &harvest, &message), SALTUS_BAD_INPUT);
    assert_non_null(strstr(message.text, "forcing"));
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orbits_of_chaos),
        cmocka_unit_test(options_of_a_harvest),
        cmocka_unit_test(seeds_and_states),
        cmocka_unit_test(resting_orbits),
        cmocka_unit_test(close_orbits_stay_two),
        cmocka_unit_test(orbits_beside_grazing_have_their_least_period),
        cmocka_unit_test(mirror_images),
        cmocka_unit_test(images_half_a_period_later),
        cmocka_unit_test(settled_motion),
        cmocka_unit_test(progress_is_told),
        cmocka_unit_test(a_request_to_stop_is_final),
        cmocka_unit_test(columns_of_the_flow_are_ignored),
        cmocka_unit_test(what_flies_away_is_given_up),
        cmocka_unit_test(a_narrow_gap_has_random_starts),
        cmocka_unit_test(options_out_of_range_are_refused),
        cmocka_unit_test(limits_are_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
