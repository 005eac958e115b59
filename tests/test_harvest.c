/* Harvest: every orbit is walked again by other means than those that found it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "orbit/multipliers.h"

enum { dimension_max = 10 };

static saltus_system *scene_system(const char *name, const char *set) {
    saltus_scene scene;
    saltus_message message = {""};
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

/* The implicit integrator, from two section phases, comes back to where it began, and meets as many impacts.
 */
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

/* A displacement along the leading eigenvector, small at the beginning and at the end, grows by the largest
 * multiplier. */
static void grows_as_told(const saltus_system *system, const saltus_harvest_orbit *found) {
    const saltus_orbit *orbit = &found->orbit;
    double small = 1e-6 * exp(-0.5 * orbit->multipliers[0].log_modulus);
    int n = orbit->dimension;
    saltus_orbit_options options = saltus_orbit_defaults();
    saltus_message message = {""};
    saltus_multiplier mu;
    double vector[2 * dimension_max], start[dimension_max], end[dimension_max];
    check_ok(saltus_orbit_eigenvectors(system, &options, orbit, 1, &mu, vector, &message), &message);
    check_near(mu.re, orbit->multipliers[0].re, 1e-9 * hypot(mu.re, mu.im));
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

/* Figure 7(c) is chaotic: twenty unstable orbits and more. */
static void orbits_of_chaos(void **unused) {
    (void)unused;
    saltus_system *system = scene_system("fig7c", NULL);
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {""};
    saltus_harvest harvest;
    int unstable = 0;
    options.periods = 2000;
    options.tries = 20;
    options.recurrence = 0.2;
    check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
    distinct(system, &harvest);
    sorted(&harvest);
    for (int k = 0; k < harvest.count; k++) {
        const saltus_harvest_orbit *found = &harvest.orbits[k];
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
    print_message("%d orbits, %d unstable, from %lld candidates\n", harvest.count, unstable,
                  harvest.candidates);
    assert_true(unstable >= 20);
    saltus_harvest_clear(&harvest);
    saltus_system_free(system);
}

/* Every orbit of a harvest has its mirror image in the list: another one, or itself half an orbit later. */
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

/* Between two stops. Which orbits a chaotic trajectory passes is chance: several scenes, until both kinds
 * have been met. */
static void mirror_images(void **unused) {
    (void)unused;
    static const char *const settings[] = {"d=0.02", "d=0.0202", "d=0.0204", "d=0.0206", "d=0.0208"};
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {""};
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

/* A motion that settles leaves its own orbit, once, with its least period. */
static void settled_motion(void **unused) {
    (void)unused;
    saltus_system *system = scene_system("fig7d", NULL);
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {""};
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

static bool stop_soon(void *context, double done) {
    *(double *)context = done;
    return done < 0.1;
}

static void limits_are_kept(void **unused) {
    (void)unused;
    saltus_system *system = scene_system("fig3", "d=0.02");
    saltus_harvest_options options = saltus_harvest_defaults();
    saltus_message message = {""};
    saltus_harvest harvest;
    double seen = 0;
    options.most = 3;
    check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
    assert_int_equal(harvest.count, 3);
    saltus_harvest_clear(&harvest);
    options.progress = stop_soon;
    options.context = &seen;
    check_ok(saltus_harvest_run(system, &options, &harvest, &message), &message);
    assert_true(seen >= 0.1 && harvest.periods < options.periods);
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
        cmocka_unit_test(mirror_images),
        cmocka_unit_test(settled_motion),
        cmocka_unit_test(limits_are_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
