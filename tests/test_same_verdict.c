/* The same verdict by all means: a sweep's row and a classification of its end state, at random points of
 * pipes and oscillators; a chatter near the section in all places that give labels. SALTUS_LONG_TESTS: ten
 * times as many points, another seed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_check.h"

#include <gsl/gsl_rng.h>

static double between(gsl_rng *rng, double low, double high) {
    return low + (high - low) * gsl_rng_uniform(rng);
}

/* Scenes with one parameter for the sweep: forced, with stops on one side or both, from inelastic to nearly
 * elastic. */
static saltus_scene random_scene(gsl_rng *rng, bool pipe, double *omega) {
    static const char *const sides[] = {"upper", "lower", "both"};
    char settings[200];
    double r = gsl_rng_uniform_int(rng, 6) == 0 ? 0 : between(rng, 0.05, 0.95);
    if (pipe) {
        *omega = between(rng, 5, 60);
        snprintf(settings, sizeof settings, "N=%d d=%g r=%g sides=%s kappa=%g",
                 1 + (int)gsl_rng_uniform_int(rng, 3), between(rng, 0.015, 0.06), r,
                 sides[gsl_rng_uniform_int(rng, 3)], between(rng, 1000, 6000));
        return scene_of("pipe", settings);
    }
    *omega = between(rng, 0.4, 3.5);
    snprintf(settings, sizeof settings, "c=%g k=1 F=1 d=%g r=%g sides=%s", between(rng, 0.01, 0.4),
             between(rng, 0, 1.2), r, sides[gsl_rng_uniform_int(rng, 3)]);
    return scene_of("impact-oscillator", settings);
}

static void rows_and_motions_agree(void **unused) {
    (void)unused;
    const bool thorough = long_version();
    int points = thorough ? 3000 : 300, settled = 0;
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    saltus_sweep_options options = saltus_sweep_defaults();
    gsl_rng_set(rng, thorough ? 2 : 1);
    options.threads = 1;
    options.transient = 600;
    options.record = 1;
    for (int k = 0; k < points; k++) {
        double omega;
        saltus_scene scene = random_scene(rng, k % 3 == 0, &omega);
        single s = run_single(&scene, "omega", omega, &options);
        settled += check_label(&s.outcome, 0, 0);
        close_single(&s);
    }
    assert_true(settled > points / 2);
    gsl_rng_free(rng);
}

/* The label of a branch's first point. */
static void check_branch_label(const saltus_spec *spec, const saltus_motion *motion, const char *label) {
    saltus_branch_options options = saltus_branch_defaults();
    saltus_message message = {.text = ""};
    saltus_branch *branch;
    const saltus_branch_point *point;
    double omega = spec->parameters[saltus_model_parameter_index(spec->model, "omega")];
    strcpy(options.key[0], "omega");
    options.low[0] = omega;
    options.high[0] = omega * 1.001;
    check_ok(saltus_branch_new(spec, motion->periods, motion->state, &options, &branch, &message), &message);
    check_ok(saltus_branch_step(branch, &point, &message), &message);
    assert_non_null(point);
    assert_string_equal(point->label, label);
    assert_int_equal(point->impacts, motion->impacts);
    assert_int_equal(point->sticking_intervals, motion->sticking_intervals);
    saltus_branch_free(branch);
}

/* A chatter is recognised wherever the section lies: a contact that begins just before, at and just after
 * phase 0, in classification, sweep, branch and harvest. */
static void chatter_is_told_alike(void **unused) {
    (void)unused;
    static const double shifts[] = {-1e-3, -1e-5, -1e-6, -1e-7, -1e-8, 0, 1e-8, 1e-7, 1e-6, 1e-5, 1e-3};
    bool before = false, after = false;
    for (size_t k = 0; k < sizeof shifts / sizeof shifts[0]; k++) {
        double omega = 1.0117980957031247 + shifts[k];
        char setting[64];
        snprintf(setting, sizeof setting, "c=0.3 F=1 d=0.2 r=0.01 omega=%.17g", omega);
        saltus_scene scene = scene_of("impact-oscillator", setting);
        saltus_sweep_options options = saltus_sweep_defaults();
        options.threads = 1;
        single s = run_single(&scene, "omega", omega, &options);
        saltus_system *system = build(&scene.spec);
        saltus_motion motion = motion_from(system, s.result.states, 20);
        assert_string_equal(motion.label, "chatter/1");
        assert_string_equal(s.label, motion.label);
        before |= motion.events[0].kind == SALTUS_STICK;
        after |= motion.events[0].kind == SALTUS_RELEASE;
        check_branch_label(&scene.spec, &motion, motion.label);
        saltus_harvest_options search = saltus_harvest_defaults();
        saltus_harvest harvest;
        saltus_message message = {.text = ""};
        search.longest = 1;
        search.periods = 50;
        search.state = motion.state;
        check_ok(saltus_harvest_run(system, &search, &harvest, &message), &message);
        assert_int_equal(harvest.count, 1);
        assert_int_equal(harvest.orbits[0].impacts, -1);
        assert_int_equal(harvest.orbits[0].sticking_intervals, motion.sticking_intervals);
        saltus_harvest_clear(&harvest);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
        close_single(&s);
    }
    assert_true(before && after);
}

/* Just beyond a flip half the period almost recurs: the full period is found, without measuring the
 * exponent. */
static void half_a_period_is_not_taken(void **unused) {
    (void)unused;
    static const struct {
        const char *scene, *settings;
        int period;
    } cases[] = {{"gear-rattle", "omega=0.796209 r=0.312554 d=0.834909", 2},
                 {"fig7d", "r=0.199681 omega=25.67392408", 4},
                 {"duffing", "r=0.442797 omega=1.130294103", 2}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        saltus_scene scene = scene_of(cases[k].scene, cases[k].settings);
        saltus_classify_options options = saltus_classify_defaults();
        saltus_message message = {.text = ""};
        saltus_motion motion;
        saltus_system *system = build(&scene.spec);
        double state[SALTUS_STATE_MAX];
        options.measure = 0;
        check_ok(saltus_scene_state(&scene, system, state, &message), &message);
        check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
        assert_int_equal(motion.verdict, SALTUS_PERIODIC);
        assert_int_equal(motion.periods, cases[k].period);
        /* The flip is near: the whole period's multiplier is near 1. */
        assert_true(motion.multipliers[0].re > 0.5 && motion.multipliers[0].re < 1);
        saltus_motion_clear(&motion);
        saltus_system_free(system);
        saltus_scene_clear(&scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_and_motions_agree),
        cmocka_unit_test(chatter_is_told_alike),
        cmocka_unit_test(half_a_period_is_not_taken),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
