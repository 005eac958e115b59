/* How long chaos was observed, and long periods that look like it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_check.h"

#include "motion/evidence.h"
#include "motion/motion.h"

#include <gsl/gsl_randist.h>

static saltus_motion classify_with(const char *name, const char *settings,
                                   const saltus_classify_options *options) {
    saltus_scene scene = scene_of(name, settings);
    saltus_message message = {.text = ""};
    saltus_system *system = build(&scene.spec);
    saltus_motion motion;
    double start[SALTUS_STATE_MAX];
    check_ok(saltus_system_default_state(system, start, &message), &message);
    check_ok(saltus_classify(system, start, options, &motion, &message), &message);
    saltus_system_free(system);
    return motion;
}

/* The bound on a lifetime is correct: if trajectories leave at random with a known mean time, one bound in
 * twenty lies above that mean, for any time of observation. */
static void bounds_hold_as_often_as_they_say(void **unused) {
    (void)unused;
    enum { trials = 4000, members = 8 };
    static const double watched[] = {0.05, 0.3, 1, 4}; /* mean lifetimes, each trajectory */
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    assert_non_null(rng);
    assert_true(saltus_lifetime_at_least(30000, 0) > 10000 && saltus_lifetime_at_least(29900, 0) < 10000);
    for (size_t k = 0; k < sizeof watched / sizeof watched[0]; k++) {
        int above = 0;
        for (int t = 0; t < trials; t++) {
            double sum = 0;
            int left = 0;
            for (int m = 0; m < members; m++) {
                double life = gsl_ran_exponential(rng, 1);
                left += life < watched[k];
                sum += fmin(life, watched[k]);
            }
            above += saltus_lifetime_at_least(sum, left) > 1;
        }
        /* Four standard deviations of the number. */
        assert_true(above < 0.05 * trials + 4 * sqrt(0.05 * 0.95 * trials));
    }
    gsl_rng_free(rng);
}

/* Chaos is asserted once it was observed for three times the requested lifetime, not before. */
static void chaos_is_asserted_for_its_lifetime(void **unused) {
    (void)unused;
    skip_where_slow();
    for (int k = 0; k < 2; k++) {
        saltus_classify_options options = saltus_classify_defaults();
        options.transient = 500;
        options.measure = 16000;
        options.lifetime = k ? 5000 : 6000;
        saltus_motion motion = classify_with("pipe", "d=0.035 omega=10", &options);
        const saltus_evidence *e = &motion.evidence;
        check_near(e->lifetime_at_least, (double)e->periods / 3, 0.01 * (double)e->periods);
        assert_true(isnan(e->lifetime) && e->left == 0);
        assert_int_equal(motion.verdict, k ? SALTUS_CHAOTIC : SALTUS_IRREGULAR);
        assert_true((e->lifetime_at_least >= (double)options.lifetime) == k);
        if (!k)
            assert_non_null(strstr(motion.reason, "--measure"));
        saltus_motion_clear(&motion);
    }
}

/* Where periods take very many steps, the rest of the lifetime is watched without measuring: the bound counts
 * it, the reason tells of it, the exponent is that of a longer measurement, and the evidence is asked for all
 * the section points. */
static void dear_lifetimes_are_watched(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char settings[] = "alpha=0 N=9 omega=42 d=0.03";
    saltus_classify_options options = saltus_classify_defaults();
    char told[96];
    options.transient = 200;
    saltus_motion motion = classify_with("pipe", settings, &options);
    const saltus_evidence *e = &motion.evidence;
    const long long all = 8 * (3 * options.lifetime / 8 + 1), watched = all - e->periods;
    assert_int_equal(motion.verdict, SALTUS_CHAOTIC);
    assert_int_equal(e->periods, 8000);
    snprintf(told, sizeof told, "nor in %lld more, at whose end they still separate: mean lifetime at least",
             watched);
    assert_non_null(strstr(motion.reason, told));
    check_near(e->lifetime_at_least, saltus_lifetime_at_least((double)all, 0), 1e-9 * (double)all);
    assert_true(e->lifetime_at_least >= (double)options.lifetime && isnan(e->lifetime) && e->left == 0);
    assert_true(e->zero_one > 0.9 && e->dimension > 5); /* a thousand points are too few for a dimension */
    saltus_scene scene = scene_of("pipe", settings);
    saltus_message message = {.text = ""};
    saltus_system *system = build(&scene.spec);
    saltus_lyapunov_options how = saltus_lyapunov_defaults();
    saltus_lyapunov measured;
    how.exponents = 1;
    how.members = 8;
    how.periods = 16000;
    check_ok(saltus_lyapunov_run(system, motion.state, &how, &measured, &message), &message);
    check_near(motion.lyapunov, measured.exponents[0],
               4 * hypot(motion.lyapunov_error, measured.standard_errors[0]));
    saltus_lyapunov_clear(&measured);
    saltus_system_free(system);
    saltus_motion_clear(&motion);
    /* Cheap periods are all measured. */
    options.lifetime = 5000;
    motion = classify_with("pipe", "d=0.035 omega=10", &options);
    assert_null(strstr(motion.reason, "nor in"));
    check_near(motion.evidence.lifetime_at_least,
               saltus_lifetime_at_least((double)motion.evidence.periods, 0), 1e-6);
    saltus_motion_clear(&motion);
}

/* The same rule in a sweep. */
static void rows_are_irregular_until_then(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("pipe", "d=0.035");
    for (int k = 0; k < 2; k++) {
        saltus_sweep_options options = saltus_sweep_defaults();
        options.keep = SALTUS_KEEP_LYAPUNOV;
        options.transient = 300;
        options.measure = 4000;
        options.lifetime = k ? 1000 : 2000;
        single s = run_single(&scene, "omega", 10, &options);
        const saltus_sweep_row *row = s.result.rows;
        assert_string_equal(s.label, k ? "chaotic" : "irregular");
        assert_true(row->lyapunov > 3 * row->lyapunov_error);
        assert_true((row->lifetime_at_least >= (double)options.lifetime) == k);
        close_single(&s);
    }
}

/* Motions near a torus, locked to an orbit of hundreds of periods that attracts slowly: that orbit is
 * found. */
static void locked_motions_have_a_period(void **unused) {
    (void)unused;
    skip_where_slow();
    const saltus_classify_options options = saltus_classify_defaults();
    saltus_motion motion = classify_with("pipe", "d=0.033 omega=52.25", &options);
    saltus_scene scene = scene_of("pipe", "d=0.033 omega=52.25");
    saltus_message message = {.text = ""};
    saltus_system *system = build(&scene.spec);
    double state[SALTUS_STATE_MAX];
    assert_int_equal(motion.verdict, SALTUS_PERIODIC);
    assert_true(motion.periods > 64 && motion.stable);
    memcpy(state, motion.state, (size_t)motion.dimension * sizeof *state);
    check_ok(saltus_motion_settle(system, &options.flow, motion.periods, state, &message), &message);
    assert_true(saltus_system_distance(system, state, motion.state) < 1e-8);
    for (int p = 1; p < motion.periods; p++)
        assert_true(saltus_system_distance(system, motion.state,
                                           motion.section_states + (size_t)p * (size_t)motion.dimension) >
                    1e-6);
    saltus_system_free(system);
    saltus_motion_clear(&motion);
}

/* Contacts that remove all differences make motions superstable. If neighbours separate between them until
 * rounding decides, this is reported, and no period is asserted. */
static void rounding_decides_long_superstable_periods(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const cases[][2] = {{"budd-dux", "omega=4.85 d=.01"},
                                           {"pipe", "N=1 omega=35.164427 d=0.010235 r=0.6187 sides=both"}};
    for (int k = 0; k < 2; k++) {
        const saltus_classify_options options = saltus_classify_defaults();
        saltus_motion motion = classify_with(cases[k][0], cases[k][1], &options);
        assert_int_equal(motion.verdict, SALTUS_LONG_PERIOD);
        assert_true(motion.lyapunov == -INFINITY);
        assert_non_null(strstr(motion.reason, "rounding decides"));
        /* How many impacts of a complete chatter are simulated depends on the tolerance, so no number is
         * reported. */
        const bool chatters = k == 1;
        assert_int_equal(motion.impacts, chatters ? -1 : 0);
        assert_true(!chatters || isnan(motion.evidence.impacts_per_period));
        saltus_motion_clear(&motion);
    }
}

/* Such a contact may come once in 100,000 periods; it is found from any start, as neighbours that separate
 * until then prove nothing. */
static void rare_contacts_count_from_any_start(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_scene scene = scene_of("budd-dux", "omega=4.85 d=.01");
    saltus_message message = {.text = ""};
    saltus_system *system = build(&scene.spec);
    saltus_classify_options options = saltus_classify_defaults();
    saltus_attractors found;
    options.transient = 2000;
    check_ok(saltus_attractors_find(system, 2, 3, &options, &found, &message), &message);
    assert_int_equal(found.count, 1);
    assert_int_equal(found.motions[0].verdict, SALTUS_LONG_PERIOD);
    assert_true(found.motions[0].lyapunov == -INFINITY);
    saltus_attractors_clear(&found);
    saltus_system_free(system);
}

/* The same rule in a sweep: superstable motions are not chaotic in its rows. */
static void rare_contacts_count_in_rows(void **unused) {
    (void)unused;
    skip_where_slow();
    static const struct {
        const char *settings;
        double omega;
    } cases[] = {{"d=.01", 4.85}, {"d=-0.03333333333333334", 5.2949152542372886}};
    for (int k = 0; k < 2; k++) {
        saltus_scene scene = scene_of("budd-dux", cases[k].settings);
        saltus_sweep_options options = saltus_sweep_defaults();
        options.keep = SALTUS_KEEP_LYAPUNOV;
        single s = run_single(&scene, "omega", cases[k].omega, &options);
        assert_string_equal(s.label, "long-period");
        assert_true(s.result.rows->lyapunov == -INFINITY && isnan(s.result.rows->lifetime_at_least));
        close_single(&s);
    }
}

/* Verdicts report the observation: for chaos that a contact could end, the least mean time between contacts;
 * nothing if none is possible; and of a contact that came, that it was the only one. */
static void verdicts_tell_for_how_long_contacts_were_watched_for(void **unused) {
    (void)unused;
    skip_where_slow();
    static const char *const words = "lasting contacts that would end it come less than once in ";
    saltus_classify_options options = saltus_classify_defaults();
    options.lifetime = 1000;
    for (int k = 0; k < 2; k++) {
        saltus_motion motion =
            classify_with(k ? "pipe" : "budd-dux", k ? "d=0.035 omega=10" : "omega=2.8 d=0", &options);
        const char *told = strstr(motion.reason, words);
        assert_int_equal(motion.verdict, SALTUS_CHAOTIC);
        assert_true((told == NULL) == k);
        if (told)
            assert_true(strtod(told + strlen(words), NULL) > 10 * motion.evidence.lifetime_at_least);
        saltus_motion_clear(&motion);
    }
    options = saltus_classify_defaults();
    options.transient = 640;
    saltus_motion motion = classify_with("budd-dux", "omega=4.85 d=.01", &options);
    assert_true(motion.verdict == SALTUS_LONG_PERIOD && motion.lyapunov == -INFINITY);
    assert_non_null(strstr(motion.reason, "no other one comes within 6400 periods"));
    saltus_motion_clear(&motion);
}

/* The reported contact is the first one of any trajectory: the same, to the last bit, in any order of
 * trajectories, and one that single trajectories meet. */
static void first_contact_is_told(void **unused) {
    (void)unused;
    enum { trajectories = 11 };
    saltus_scene scene = scene_of("budd-dux", "omega=6.0424242424242429 d=-0.06 r=0.5");
    saltus_system *system = build(&scene.spec);
    saltus_message message = {.text = ""};
    const saltus_flow_options options = saltus_flow_defaults();
    double start[trajectories][2], after[trajectories][2], told[2], reversed[2];
    const double *ahead[trajectories], *back[trajectories];
    int distinct = 0, among = 0;
    bool found;
    assert_true(saltus_contact_watch(system, 1000) > 1000);
    for (int k = 0; k < trajectories; k++) {
        start[k][0] = -0.07 - 0.05 * k;
        start[k][1] = 0.01 * k;
        ahead[k] = back[trajectories - 1 - k] = start[k];
        check_ok(
            saltus_motion_meets_contact(system, &options, &ahead[k], 1, 1000, after[k], &found, &message),
            &message);
        assert_true(found);
        distinct += memcmp(after[k], after[0], sizeof after[k]) != 0;
    }
    check_ok(saltus_motion_meets_contact(system, &options, ahead, trajectories, 1000 * trajectories, told,
                                         &found, &message),
             &message);
    check_ok(saltus_motion_meets_contact(system, &options, back, trajectories, 1000 * trajectories, reversed,
                                         &found, &message),
             &message);
    for (int k = 0; k < trajectories; k++)
        among += memcmp(after[k], told, sizeof told) == 0;
    assert_true(distinct > 0 && among > 0 && memcmp(told, reversed, sizeof told) == 0);
    saltus_system_free(system);
}

/* In a periodic window with transient chaos of some 40,000 periods, the orbit is found or a trajectory
 * reaches it; it is reported as the end. */
static void long_orbits_amid_chaos_are_found(void **unused) {
    (void)unused;
    skip_where_slow();
    const saltus_classify_options options = saltus_classify_defaults();
    saltus_motion motion = classify_with("pipe", "d=0.03 r=0.8 omega=37.547169811320757", &options);
    const saltus_evidence *e = &motion.evidence;
    assert_true(motion.verdict == SALTUS_TRANSIENT || motion.verdict == SALTUS_PERIODIC);
    assert_string_equal(motion.verdict == SALTUS_PERIODIC ? motion.label
                        : e->left                         ? e->left_for
                                                          : e->stable_orbit,
                        "2/14");
    saltus_motion_clear(&motion);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_hold_as_often_as_they_say),
        cmocka_unit_test(chaos_is_asserted_for_its_lifetime),
        cmocka_unit_test(dear_lifetimes_are_watched),
        cmocka_unit_test(rows_are_irregular_until_then),
        cmocka_unit_test(locked_motions_have_a_period),
        cmocka_unit_test(rounding_decides_long_superstable_periods),
        cmocka_unit_test(rare_contacts_count_from_any_start),
        cmocka_unit_test(rare_contacts_count_in_rows),
        cmocka_unit_test(verdicts_tell_for_how_long_contacts_were_watched_for),
        cmocka_unit_test(first_contact_is_told),
        cmocka_unit_test(long_orbits_amid_chaos_are_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
