/* A sweep's row and a classification of its end state are one verdict, on random points of pipes and
 * oscillators. SALTUS_LONG_TESTS: ten times as many points, another seed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_check.h"

#include <gsl/gsl_rng.h>

static double between(gsl_rng *rng, double low, double high) {
    return low + (high - low) * gsl_rng_uniform(rng);
}

/* Scenes with one parameter left to the sweep: forced, on one side or on both, from inelastic to nearly
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
    bool thorough = getenv("SALTUS_LONG_TESTS") != NULL;
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_and_motions_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
