/* One motion in several units of time: with omega and dampers s times, stiffnesses and loads s^2 times as
 * large, the same displacements occur s times as fast, and verdicts must be the same.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

static saltus_spec faster(saltus_spec spec, double s) {
    static const char *const once[] = {"omega", "c", "c2"}, *const twice[] = {"k",  "k2", "F",
                                                                              "F2", "F0", "F02"};
    for (size_t k = 0; k < sizeof once / sizeof once[0]; k++)
        set_parameter(&spec, once[k], s * saltus_spec_get(&spec, once[k]));
    for (size_t k = 0; k < sizeof twice / sizeof twice[0]; k++)
        set_parameter(&spec, twice[k], s * s * saltus_spec_get(&spec, twice[k]));
    return spec;
}

static const double units[] = {1, 3e4, 1e-5};
enum { unit_count = sizeof units / sizeof units[0] };

static saltus_motion classify(const saltus_spec *spec, double s, const saltus_classify_options *options) {
    saltus_spec fast = faster(*spec, s);
    saltus_system *system = build(&fast);
    saltus_message message = {.text = ""};
    saltus_motion motion;
    double state[4];
    check_ok(saltus_system_default_state(system, state, &message), &message);
    check_ok(saltus_classify(system, state, options, &motion, &message), &message);
    saltus_system_free(system);
    return motion;
}

static saltus_spec impacting(double c, double force, double omega, double load, double d, double r) {
    saltus_spec spec = oscillator_spec(c, 1, force, omega);
    set_parameter(&spec, "F0", load);
    add_stop(&spec, d, r, SALTUS_UPPER);
    return spec;
}

static void periodic_motions(void **unused) {
    (void)unused;
    const saltus_spec specs[] = {impacting(0.1, 1, 1, 0, 1, 0.8), impacting(0.04, 0.3478, 0.81, -1, 0, 0.9),
                                 impacting(0.1, 0.05, 1.3, 0, 1, 0.8), impacting(0, 0, 1, 3, 1, 0.5)};
    static const char *const labels[] = {"1/1", "1/2", "0/1", "held"};
    saltus_classify_options options = saltus_classify_defaults();
    for (int k = 0; k < 4; k++) {
        saltus_motion first = classify(&specs[k], 1, &options);
        assert_string_equal(first.label, labels[k]);
        for (int u = 1; u < unit_count; u++) {
            double s = units[u];
            saltus_motion m = classify(&specs[k], s, &options);
            assert_string_equal(m.label, first.label);
            assert_int_equal(m.stable, first.stable);
            assert_int_equal(m.multiplier_count, first.multiplier_count);
            for (int i = 0; i < m.multiplier_count; i++)
                if (isfinite(first.multipliers[i].log_modulus))
                    check_near(m.multipliers[i].log_modulus, first.multipliers[i].log_modulus, 1e-8);
            if (isfinite(first.lyapunov))
                check_near(m.lyapunov / s, first.lyapunov, 1e-8);
            else
                assert_true(m.lyapunov == first.lyapunov);
            check_near(m.state[0], first.state[0], 1e-8);
            check_near(m.state[1] / s, first.state[1], 1e-8);
            check_near(m.largest, first.largest, 1e-8);
            check_near(m.smallest, first.smallest, 1e-8);
            assert_int_equal(m.event_count, first.event_count);
            for (int e = 0; e < m.event_count; e++) {
                check_near(saltus_time_periods(m.events[e].time), saltus_time_periods(first.events[e].time),
                           1e-7);
                check_near(m.events[e].velocity_before / s, first.events[e].velocity_before, 1e-8);
            }
            saltus_motion_clear(&m);
        }
        saltus_motion_clear(&first);
    }
}

/* A torus with impacts, whose largest exponent is only an error, and one without. */
static void quasi_periodic_motions(void **unused) {
    (void)unused;
    skip_where_slow(); /* sanitizers are slow; test_verdict has tori for them */
    static const char *const settings[] = {"omega=1.7133", "d=-0.1797", "r=0.323", "c=0.07",
                                           "c2=0.07",      "m2=1.57",   "k2=2.51"};
    saltus_scene scene;
    saltus_message message = {.text = ""};
    saltus_classify_options options = saltus_classify_defaults();
    options.transient = 2000;
    options.measure = 8000;
    options.lifetime = options.measure / 24;
    check_ok(saltus_scene_load("two-mass", &scene, &message), &message);
    for (size_t k = 0; k < sizeof settings / sizeof settings[0]; k++)
        check_ok(saltus_scene_set(&scene, settings[k], &message), &message);
    scene.spec.stops[0].weight[0] = 0;
    scene.spec.stops[0].weight[1] = 1;
    const saltus_spec specs[] = {scene.spec, impacting(0, 1, 0.6180339887498949, 0, 100, 0.8)};
    for (int k = 0; k < 2; k++)
        for (int u = 0; u < unit_count; u++) {
            saltus_motion m = classify(&specs[k], units[u], &options);
            double period = 2 * M_PI / (units[u] * saltus_spec_get(&specs[k], "omega"));
            const saltus_evidence *e = &m.evidence;
            if (m.verdict != SALTUS_QUASIPERIODIC)
                fail_msg("torus %d, %g times as fast: %s: %s", k, units[u], m.label, m.reason);
            assert_int_equal(e->curves, 1);
            check_near(e->dimension, 1, 0.1);
            check_near(e->impacts_per_period, k ? 0 : 1, 0.01);
            check_near(m.lyapunov * period, 0, 2e-3);
            check_near(e->history[e->history_count - 1].time, (double)e->periods * period,
                       1e-12 * (double)e->periods * period);
            saltus_motion_clear(&m);
        }
}

/* Chaos, in units in which its exponent is that of a torus. */
static void chaotic_motions(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_spec spec = impacting(0.1, 1, 0.8, 0, 0, 0.8);
    saltus_classify_options options = saltus_classify_defaults();
    double exponent = 0, error = 0, impacts = 0;
    options.transient = 2000;
    options.measure = 64000;
    for (int u = 0; u < unit_count; u++) {
        double s = units[u];
        saltus_motion m = classify(&spec, s, &options);
        if (m.verdict != SALTUS_CHAOTIC)
            fail_msg("%g times as fast: %s: %s", s, m.label, m.reason);
        if (u == 0) {
            exponent = m.lyapunov;
            error = m.lyapunov_error;
            impacts = m.evidence.impacts_per_period;
        }
        check_near(m.lyapunov / s, exponent, 4.5 * hypot(error, m.lyapunov_error / s));
        check_near(m.lyapunov_error / s, error, 0.5 * error);
        check_near(m.evidence.impacts_per_period, impacts, 0.01 * impacts);
        saltus_motion_clear(&m);
    }
}

/* Chaos near the fold of an orbit of period 6, near which it stays for long: laminar phases are counted in
 * periods, and what is much longer than the separation of neighbours is so in any unit. Amid it is a stable
 * orbit; if that is found, chaos is not asserted. */
static void intermittent_motions(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_spec spec = impacting(0, 1, 3.04, 0, 0, 0.8);
    saltus_classify_options options = saltus_classify_defaults();
    options.transient = 2000;
    options.measure = 64000;
    for (int u = 0; u < unit_count; u++) {
        saltus_motion m = classify(&spec, units[u], &options);
        if (m.verdict == SALTUS_CHAOTIC) {
            assert_true(m.evidence.laminar_period > 0 && m.evidence.laminar_period % 6 == 0);
            assert_true(m.evidence.laminar >= 0.05 && m.evidence.longest_phase > 0);
        } else if (m.verdict != SALTUS_TRANSIENT || !(m.evidence.stable_orbit[0] || m.evidence.left))
            fail_msg("%g times as fast: %s: %s", units[u], m.label, m.reason);
        saltus_motion_clear(&m);
    }
}

/* A free motion that decays too slowly to wait for is on its way to something regular; for one that takes
 * twenty times as long nothing is asserted: the loss per period counts. */
static void slow_decays(void **unused) {
    (void)unused;
    saltus_classify_options options = saltus_classify_defaults();
    options.transient = 2000;
    options.measure = 8000;
    options.lifetime = options.measure / 24;
    for (int slower = 0; slower < 2; slower++)
        for (int u = 0; u < unit_count; u++) {
            saltus_spec spec = impacting(slower ? 5e-7 : 1e-5, 1, 0.6180339887498949, 0, 100, 0.8);
            saltus_motion m = classify(&spec, units[u], &options);
            if (m.verdict != (slower ? SALTUS_UNDECIDED : SALTUS_LONG_PERIOD))
                fail_msg("%d, %g times as fast: %s: %s", slower, units[u], m.label, m.reason);
            if (!slower)
                assert_string_equal(m.label, "long-period");
            check_near(m.lyapunov / units[u], slower ? -2.5e-7 : -5e-6,
                       3 * m.lyapunov_error / units[u] + 1e-12);
            saltus_motion_clear(&m);
        }
}

/* Exponents and their errors are rates; the time needed is in periods. */
static void measured_exponents(void **unused) {
    (void)unused;
    const saltus_spec specs[] = {impacting(0.1, 1, 1, 0, 1, 0.8), impacting(0, 1, 0.3183, 0, 100, 0.8),
                                 impacting(0.1, 1, 0.8, 0, 0, 0.8)};
    for (int k = 0; k < 3; k++) {
        saltus_lyapunov first = {0};
        for (int u = 0; u < unit_count; u++) {
            double s = units[u], start[2] = {-0.3, 0.1 * s};
            saltus_spec fast = faster(specs[k], s);
            saltus_system *system = build(&fast);
            saltus_lyapunov_options options = saltus_lyapunov_defaults();
            saltus_message message = {.text = ""};
            saltus_lyapunov l;
            options.exponents = 0;
            options.transient = 200;
            options.precision = 0.03;
            check_ok(saltus_lyapunov_run(system, start, &options, &l, &message), &message);
            assert_true(l.precise && l.agree);
            check_near(l.period * s, 2 * M_PI / saltus_spec_get(&specs[k], "omega"), 1e-12);
            check_near(l.time, (double)l.periods * l.period, 1e-12 * l.time);
            check_near(l.sum_rule, l.sum, 1e-6 * s);
            if (u == 0) {
                first = l;
                saltus_system_free(system);
                continue;
            }
            bool chaos = k == 2;
            if (!chaos)
                assert_int_equal(l.periods, first.periods);
            for (int i = 0; i < 2; i++) {
                double error = hypot(first.standard_errors[i], l.standard_errors[i] / s);
                check_near(l.exponents[i] / s, first.exponents[i], chaos ? 4.5 * error : 1e-9 + error);
                if (!chaos)
                    check_near(l.standard_errors[i] / s, first.standard_errors[i],
                               0.5 * first.standard_errors[i] + 1e-9);
            }
            check_near(l.kaplan_yorke, first.kaplan_yorke, chaos ? 0.05 : 1e-9);
            check_near(l.impacts_per_period, first.impacts_per_period, chaos ? 0.05 : 1e-9);
            saltus_lyapunov_clear(&l);
            saltus_system_free(system);
        }
        saltus_lyapunov_clear(&first);
    }
}

/* Frequencies of spectra are in units of the forcing's: lines and densities of displacements are the same. */
static void spectra(void **unused) {
    (void)unused;
    saltus_spec spec = impacting(0.1, 1, 1, 0, 1, 0.8);
    for (int welch = 0; welch < 2; welch++) {
        saltus_spectra first = {0};
        for (int u = 0; u < unit_count; u++) {
            double s = units[u], start[2] = {0.3, 0.4 * s};
            saltus_spec fast = faster(spec, s);
            saltus_system *system = build(&fast);
            saltus_spectrum_options options = saltus_spectrum_defaults();
            saltus_message message = {.text = ""};
            saltus_spectra found;
            options.per_period = 32;
            options.periods = 32;
            check_ok(saltus_motion_settle(system, &options.flow, 400, start, &message), &message);
            check_ok(saltus_spectra_run(system, start, !welch, &options, &found, &message), &message);
            assert_int_equal(found.per_period, 32);
            for (int q = 0; q < 2; q++) {
                const saltus_spectrum *a = &first.spectra[q], *b = &found.spectra[q];
                double unit = q ? s : 1;
                for (long long k = 0; u > 0 && k < b->bins; k++)
                    check_near(b->density[k] / (unit * unit), a->density[k], 1e-9 * a->variance);
                if (u > 0) {
                    assert_true(a->kind == b->kind && a->bins == b->bins && a->line_count == b->line_count);
                    check_near(b->variance / (unit * unit), a->variance, 1e-9 * a->variance);
                    check_near(b->trustworthy, a->trustworthy, 1e-9);
                }
            }
            if (u == 0)
                first = found;
            else
                saltus_spectra_clear(&found);
            saltus_system_free(system);
        }
        saltus_spectra_clear(&first);
    }
}

/* An unforced system comes to rest in the same way for any omega. */
static void rest_has_no_period(void **unused) {
    (void)unused;
    saltus_classify_options options = saltus_classify_defaults();
    double exponent[2];
    for (int k = 0; k < 2; k++) {
        saltus_spec spec = impacting(0.1, 0, k ? 7.3 : 0.9, 0, 1, 0.8);
        saltus_motion m = classify(&spec, 1, &options);
        assert_string_equal(m.label, "equilibrium");
        exponent[k] = m.lyapunov;
        saltus_motion_clear(&m);
    }
    check_near(exponent[0], -0.05, 1e-9);
    check_near(exponent[1], -0.05, 1e-9);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(periodic_motions), cmocka_unit_test(quasi_periodic_motions),
        cmocka_unit_test(chaotic_motions),  cmocka_unit_test(intermittent_motions),
        cmocka_unit_test(slow_decays),      cmocka_unit_test(measured_exponents),
        cmocka_unit_test(spectra),          cmocka_unit_test(rest_has_no_period),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
