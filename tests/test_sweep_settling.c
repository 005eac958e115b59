/* When a trajectory of a sweep counts as settled: its distance from the orbit is as small as promised, for
 * approaches from one side, alternating or in a spiral; and not much later.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "closed_orbits.h"
#include "motion/settle.h"
#include "saltus/sweep.h"
#include "sweep_check.h"

/* The largest distance of a settled trajectory from its orbit (sweep.h). */
static double promised(const saltus_sweep_options *options) {
    return fmax(1e-10, 10 * options->flow.rtol);
}

static saltus_sweep_options settling_options(double rtol) {
    saltus_sweep_options options = saltus_sweep_defaults();
    options.keep = SALTUS_KEEP_STROBOSCOPIC;
    options.flow.rtol = rtol;
    options.flow.atol = 1e-4 * rtol;
    options.threads = 1;
    return options;
}

static saltus_scene scene_with(const saltus_spec *spec) {
    saltus_scene scene = scene_of("impact-oscillator", "");
    scene.spec = *spec;
    return scene;
}

/* An oscillator that rotates by `angle` and decays by `modulus` in each period: the multipliers are modulus
 * exp(+-i angle). At angle 0 or pi both are the same real number. */
static closed_oscillator turning_by(double modulus, double angle) {
    closed_oscillator o = {.F = 0.5L, .omega = 0.9L, .d = 1e5, .r = 0.8L, .periods = 1};
    long double period = closed_period(&o), natural = (angle > 0 ? angle : 2 * CLOSED_PI) / period;
    o.c = -2 * logl(modulus) / period;
    o.k = natural * natural + o.c * o.c / 4;
    return o;
}

/* Free motion, whose orbit is the steady solution: the distance when the orbit counts as reached, over the
 * promised one. */
static double distance_left(double modulus, double angle, double rtol) {
    closed_oscillator o = turning_by(modulus, angle);
    saltus_spec spec = closed_spec(&o);
    saltus_scene scene = scene_with(&spec);
    saltus_sweep_options options = settling_options(rtol);
    single s = run_single(&scene, "omega", (double)o.omega, &options);
    saltus_system *system = system_at(s.sweep, 0);
    long double steady[2];
    double left = 0;
    closed_steady(&o, 0, steady);
    for (int i = 0; i < 2; i++)
        left = fmax(left, fabs((double)steady[i] - s.result.strobes[i]) / saltus_system_scale(system)[i]);
    assert_string_equal(s.label, "0/1");
    saltus_system_free(system);
    close_single(&s);
    return left / promised(&options);
}

/* For real multipliers the distance is known exactly, so no time is lost. */
static void an_orbit_is_reached_when_it_is_near(void **unused) {
    (void)unused;
    static const double moduli[] = {0.9, 0.8, 0.6, 0.3}, tolerances[] = {1e-10, 3e-11, 1e-12};
    for (int k = 0; k < 4; k++)
        for (int half = 0; half < 2; half++)
            for (int j = 0; j < 3; j++) {
                double left = distance_left(moduli[k], half * M_PI, tolerances[j]);
                if (!(left <= 1.01 && left > 0.9 * moduli[k]))
                    fail_msg("multiplier %g, tolerance %g: %g of what is promised",
                             half ? -moduli[k] : moduli[k], tolerances[j], left);
            }
}

static void a_spiral_is_not_left_early(void **unused) {
    (void)unused;
    static const double moduli[] = {0.9, 0.8, 0.5, 0.96};
    const double step = long_version() ? 0.01 : 0.21;
    for (int k = 0; k < 4; k++)
        for (double angle = 0.1; angle < 3.1; angle += step) {
            double left = distance_left(moduli[k], angle, 1e-10);
            if (!(left <= 1.01))
                fail_msg("multipliers %g at +-%g: %g of what is promised", moduli[k], angle, left);
        }
}

/* Orbits with impacts, of one period and of two: close to the orbit of Newton's method. */
static void orbits_with_impacts_are_near_too(void **unused) {
    (void)unused;
    static const struct {
        closed_example example;
        double omega;
    } cases[] = {{closed_one_period, 1.0},        {closed_one_period, 1.3},   {closed_one_period, 1.5},
                 {closed_one_period_loaded, 1.2}, {closed_two_periods, 0.85}, {closed_two_periods, 0.97},
                 {closed_two_periods_light, 0.9}, {closed_mirrored, 3.6}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        closed_oscillator o = closed_example_of(cases[k].example);
        saltus_message message = {.text = ""};
        o.omega = cases[k].omega;
        saltus_spec spec = closed_spec(&o);
        saltus_scene scene = scene_with(&spec);
        saltus_sweep_options options = settling_options(1e-10);
        saltus_orbit_options shooting = saltus_orbit_defaults();
        saltus_orbit orbit = {0};
        single s = run_single(&scene, "omega", cases[k].omega, &options);
        assert_int_equal(s.result.rows->verdict, SALTUS_PERIODIC);
        saltus_system *system = system_at(s.sweep, 0);
        check_ok(
            saltus_orbit_find(system, s.result.rows->periods, s.result.strobes, &shooting, &orbit, &message),
            &message);
        for (int i = 0; i < 2; i++)
            check_near((orbit.state[i] - s.result.strobes[i]) / saltus_system_scale(system)[i], 0,
                       1.5 * promised(&options));
        assert_true(orbit.multipliers[0].log_modulus < 0);
        saltus_orbit_clear(&orbit);
        saltus_system_free(system);
        close_single(&s);
    }
}

/* A damped free motion decays at the rate c / 2, for any period. */
static void a_free_motions_exponent_is_its_decay(void **unused) {
    (void)unused;
    for (double angle = 0; angle < 3.2; angle += 1.05) {
        closed_oscillator o = turning_by(0.8, angle);
        saltus_spec spec = closed_spec(&o);
        saltus_scene scene = scene_with(&spec);
        saltus_sweep_options options = settling_options(1e-10);
        options.keep = SALTUS_KEEP_LYAPUNOV;
        single s = run_single(&scene, "omega", (double)o.omega, &options);
        check_near(s.result.rows->lyapunov, (double)(-o.c / 2), 1e-9);
        assert_true(s.result.rows->lyapunov_error == 0);
        close_single(&s);
    }
}

/* Points that converge to one, with given impacts and contacts in every other period; returns the period on
 * which they settle. */
static int period_of_points(const saltus_system *system, long long impacts, long long contacts, bool *doubt) {
    saltus_settling settling;
    long long impacts_so_far = 0, contacts_so_far = 0;
    assert_true(saltus_settling_open(&settling, 2, saltus_sweep_defaults().longest));
    saltus_settling_reset(&settling, system, 0);
    for (int k = 0; k < 200; k++) {
        double away = 1e-3 * pow(0.5, k);
        impacts_so_far += k % 2 ? impacts : 2;
        contacts_so_far += k % 2 ? contacts : 1;
        saltus_settling_add(&settling, (double[]){0.3 + away, 0.1 - away}, impacts_so_far, contacts_so_far);
    }
    int period = saltus_settling_period(&settling, 1e-9, doubt);
    for (int p = 1; p <= 2; p++) {
        assert_int_equal(saltus_settling_impacts(&settling, 2 * p), p * (2 + impacts));
        assert_int_equal(saltus_settling_contacts(&settling, 2 * p), p * (1 + contacts));
    }
    saltus_settling_close(&settling);
    return period;
}

/* A motion that differs from period to period has not period one, however closely points recur. */
static void counts_must_recur_as_points_do(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    saltus_system *system = build(&spec);
    bool doubt;
    assert_int_equal(period_of_points(system, 2, 1, &doubt), 1);
    assert_false(doubt);
    assert_int_not_equal(period_of_points(system, 2, 3, &doubt), 1);
    assert_int_not_equal(period_of_points(system, 3, 1, &doubt), 1);
    saltus_system_free(system);
}

/* A made-up series of points with two entries, in the system's scales, with an impact in each period. */
typedef struct series {
    saltus_settling settling;
    const double *scale;
    long long impacts, contacts;
} series;

static series open_series(const saltus_system *system) {
    series s = {.scale = saltus_system_scale(system)};
    assert_true(saltus_settling_open(&s.settling, 2, saltus_sweep_defaults().longest));
    saltus_settling_reset(&s.settling, system, 0);
    return s;
}

static void add(series *s, double x, double y) {
    const double point[2] = {x * s->scale[0], y * s->scale[1]};
    saltus_settling_add(&s->settling, point, s->impacts, s->contacts);
}

/* If a part of the period recurs but does not close, the period is in doubt; if it has nearly closed, it is
 * waited for. Both are examined only now and then. */
static void a_part_that_does_not_close_leaves_doubt(void **unused) {
    (void)unused;
    static const struct {
        double apart;
        int period;
        bool doubt;
    } rows[] = {{2e-3, 2, false}, {1.1e-3, 2, false}, {0.9e-3, 2, true}, {1e-6, 2, true},
                {21e-9, 2, true}, {19e-9, 0, false},  {3e-9, 0, false},  {0.5e-13, 1, false}};
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    saltus_system *system = build(&spec);
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        series s = open_series(system);
        for (int count = 1; count <= 128; count++) {
            bool doubt = !rows[k].doubt, looked = rows[k].apart > 1e-3 || count % 8 == 0;
            s.impacts++;
            add(&s, 0, count % 2 ? rows[k].apart : 0);
            if (count < 100)
                continue;
            int period = saltus_settling_period(&s.settling, 1e-9, &doubt);
            assert_int_equal(period, looked || rows[k].period == 1 ? rows[k].period : 0);
            assert_int_equal(doubt, looked && rows[k].doubt);
            assert_int_equal(saltus_settling_candidate(&s.settling), rows[k].apart > 1e-3 ? 2 : 1);
            check_near(saltus_settling_recurrence(&s.settling, 1), rows[k].apart, 1e-12 * rows[k].apart);
            assert_true(saltus_settling_recurrence(&s.settling, 2) == 0);
        }
        saltus_settling_close(&s.settling);
    }
    saltus_system_free(system);
}

/* An orbit that iteration would not reach in the given time is found from the shrinking recurrences: its
 * multiplier is known, and so is the time needed. */
static void slow_orbits_are_found_in_time(void **unused) {
    (void)unused;
    for (int k = 0; k < 3; k++) {
        closed_oscillator o = turning_by(0.995, (double)CLOSED_PI * k / 2);
        saltus_spec spec = closed_spec(&o);
        saltus_scene scene = scene_with(&spec);
        saltus_sweep_options options = settling_options(1e-10);
        assert_true(options.transient < log(promised(&options)) / log(0.995));
        single s = run_single(&scene, "omega", (double)o.omega, &options);
        saltus_system *system = system_at(s.sweep, 0);
        long double steady[2];
        closed_steady(&o, 0, steady);
        assert_string_equal(s.label, "0/1");
        assert_true(s.result.rows->settled < options.transient);
        for (int i = 0; i < 2; i++)
            check_near(s.result.strobes[i], (double)steady[i],
                       promised(&options) * saltus_system_scale(system)[i]);
        saltus_system_free(system);
        close_single(&s);
    }
}

static int gcd(int a, int b) {
    return b ? gcd(b, a % b) : a;
}

/* Points that nearly recur after a time that does not divide the period, as when they drift up and down in
 * steps of that time: this is no part of the period, which is examined each time and is not in doubt. */
static void what_divides_no_period_is_no_part(void **unused) {
    (void)unused;
    static const int periods[] = {7, 8, 10, 11, 13};
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    saltus_system *system = build(&spec);
    for (int k = 0; k < 5; k++)
        for (int step = 3; step <= periods[k] / 2; step++) {
            double place[13];
            if (gcd(periods[k], step) > 1)
                continue;
            for (int turn = 0; turn < periods[k]; turn++)
                place[turn * step % periods[k]] = 0.8e-3 * (2 * turn < periods[k] ? turn : periods[k] - turn);
            series s = open_series(system);
            for (int count = 1; count <= 8 * periods[k]; count++) {
                bool doubt;
                s.impacts++;
                add(&s, place[count % periods[k]], 0.1);
                if (count < 5 * periods[k])
                    continue;
                assert_true(saltus_settling_recurrence(&s.settling, step) < 1e-3);
                assert_int_equal(saltus_settling_period(&s.settling, 1e-9, &doubt), periods[k]);
                assert_false(doubt);
            }
            saltus_settling_close(&s.settling);
        }
    saltus_system_free(system);
}

/* Four periods and two points are examined before a period counts as reached; a period and two points must
 * recur before one is expected; points before the last reset do not count. */
static void a_period_is_seen_often_enough(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    saltus_system *system = build(&spec);
    series s = open_series(system);
    for (int period = 1; period <= 20; period++) {
        saltus_settling_reset(&s.settling, system, 0);
        for (int count = 1; count <= 4 * period + 4; count++) {
            bool doubt;
            s.impacts += count % period == 0;
            add(&s, 0.1 * (count % period), -0.2);
            assert_int_equal(saltus_settling_candidate(&s.settling), count >= 2 * period + 2 ? period : 0);
            assert_int_equal(saltus_settling_period(&s.settling, 1e-9, &doubt),
                             count >= 4 * period + 2 ? period : 0);
            assert_false(doubt);
        }
    }
    saltus_settling_close(&s.settling);
    saltus_system_free(system);
}

/* After a jump earlier points no longer count: a period and two more points must recur. */
static void a_jump_begins_anew(void **unused) {
    (void)unused;
    enum { before = 100 };
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    saltus_system *system = build(&spec);
    for (int period = 1; period <= 5; period++) {
        series s = open_series(system);
        for (int count = 0; count < before + 3 * period + 3; count++) {
            bool doubt;
            add(&s, 0.1 * (count % period) + (count < before ? 0 : 0.01), 0.2);
            bool again = count >= before + 2 * period + 1;
            if (count >= before - 1)
                assert_int_equal(saltus_settling_period(&s.settling, 1e-9, &doubt),
                                 count < before || again ? period : 0);
        }
        saltus_settling_close(&s.settling);
    }
    saltus_system_free(system);
}

/* Of the last two cycles the one in which recurrences shrank less predicts the rest: a single good step, or
 * an earlier one, proves nothing. */
static void one_good_step_is_not_trusted(void **unused) {
    (void)unused;
    static const double steps[][2] = {{0.9, 0.1}, {0.1, 0.9}, {0.6, 0.02}, {0.02, 0.6}, {0.5, 0.5}};
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    saltus_system *system = build(&spec);
    for (int period = 1; period <= 3; period++)
        for (int k = 0; k < 5; k++) {
            series s = open_series(system);
            double x = 0, step = 1e-4, slower = fmax(steps[k][0], steps[k][1]), left;
            for (int turn = 0; turn < 8; turn++) {
                step *= turn < 6 ? 0.95 : steps[k][turn - 6];
                x += step;
                for (int phase = 0; phase < period; phase++)
                    add(&s, x + 0.1 * phase, 0);
            }
            bool doubt;
            left = step * slower / (1 - slower);
            assert_int_equal(saltus_settling_period(&s.settling, 1.001 * left, &doubt), period);
            assert_int_equal(saltus_settling_period(&s.settling, 0.999 * left, &doubt), 0);
            saltus_settling_close(&s.settling);
        }
    saltus_system_free(system);
}

/* At rest nothing moves and no event occurs, over three periods. */
static void a_rest_is_still(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    saltus_system *system = build(&spec);
    for (int what = 0; what < 4; what++) {
        series s = open_series(system);
        for (int count = 1; count <= 12; count++) {
            s.impacts += what == 1 && count == 8;
            s.contacts += what == 2 && count == 8;
            add(&s, 0.3, what == 3 && count < 8 ? 1.1e-9 : count < 3 ? 0.9e-9 : 0);
            bool disturbed = what > 0 && count >= 8 && count < 11;
            assert_int_equal(saltus_settling_rests(&s.settling), count > 4 && !disturbed);
        }
        saltus_settling_close(&s.settling);
    }
    saltus_system_free(system);
}

/* For a geometric series the remaining distance is known: a period is reached when the limit is not below it.
 * A factor below a hundredth counts as a hundredth; a series that does not shrink is not reached. */
static void the_distance_left_of_a_series_is_its_rest(void **unused) {
    (void)unused;
    static const double ratios[] = {0.95, 0.5, 0.02, 0.005, -0.005, -0.3, -0.9};
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    saltus_system *system = build(&spec);
    bool doubt;
    for (int period = 1; period <= 3; period += 2)
        for (int k = 0; k < 7; k++) {
            series s = open_series(system);
            double away = 0.9e-3, ratio = ratios[k], least = fmax(fabs(ratio), 0.01) / fabs(ratio);
            int cycles = k == 0 || k == 6 ? 24 : 8;
            for (int turn = 0; turn < cycles + 1; turn++, away *= ratio)
                for (int phase = 0; phase < period; phase++) {
                    s.impacts++;
                    s.contacts += 2;
                    /* Large numbers would hide small ones beside them. */
                    add(&s, away, phase ? 0.1 * phase : 0);
                }
            away /= ratio;
            double left = fabs(away) * least;
            if (left * fabs(1 - ratio) / fabs(ratio) > 1e-13) {
                assert_int_equal(saltus_settling_period(&s.settling, 1.0001 * left, &doubt), period);
                assert_int_equal(saltus_settling_period(&s.settling, 0.9999 * left, &doubt), 0);
            } else
                assert_int_equal(saltus_settling_period(&s.settling, 1e-12, &doubt), period);
            saltus_settling_close(&s.settling);
        }
    for (int sign = -1; sign <= 1; sign += 2) {
        series s = open_series(system);
        double away = 1e-5;
        for (int count = 0; count < 30; count++, away *= 1.001 * sign)
            add(&s, away, 0);
        assert_int_not_equal(saltus_settling_period(&s.settling, 1, &doubt), 1);
        saltus_settling_close(&s.settling);
    }
    saltus_system_free(system);
}

/* Points that converge in a spiral: never reported to be closer than they are. */
static void a_made_up_spiral_is_not_left_early(void **unused) {
    (void)unused;
    saltus_spec spec = oscillator_spec(0.1, 1, 1, 1);
    saltus_system *system = build(&spec);
    for (int period = 1; period <= 2; period++)
        for (double angle = 0.15; angle < 3; angle += 0.19) {
            series s = open_series(system);
            double modulus = 0.85, x = 0, y = 0, size = 0.9e-4;
            for (int turn = 0; turn < 24; turn++, size *= modulus)
                for (int phase = 0; phase < period; phase++) {
                    x = size * cos(turn * angle);
                    y = size * sin(turn * angle);
                    s.impacts += phase == 0;
                    add(&s, x + 0.25 * phase, y);
                }
            double left = fmax(fabs(x), fabs(y));
            bool doubt;
            assert_int_equal(saltus_settling_period(&s.settling, 0.999 * left, &doubt), 0);
            saltus_settling_close(&s.settling);
        }
    saltus_system_free(system);
}

/* An impact in the very section does not double the period of a row, and is not missed. In resonance without
 * damping x = cos t + B sin t + (F/2) t sin t between impacts at the section's time, which are all of speed
 * pi F/(1 + r); both multipliers are -r. */
static void an_impact_in_the_section_doubles_nothing(void **state) {
    (void)state;
    saltus_scene scene = scene_of("impact-oscillator", "c=0 omega=1 F=0.5 d=1");
    static const double restitutions[] = {0.3, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95};
    for (size_t k = 0; k < sizeof restitutions / sizeof restitutions[0]; k++) {
        const double r = restitutions[k], tight = 1e-13;
        saltus_sweep_options options = settling_options(1e-10);
        options.keep |= SALTUS_KEEP_LYAPUNOV;
        single s = run_single(&scene, "r", r, &options);
        const saltus_sweep_row *row = s.result.rows;
        assert_string_equal(s.label, "1/1");
        assert_int_equal(row->periods, 1);
        check_near(row->lyapunov, log(r) / (2 * M_PI), 1e-6); /* a double multiplier: roots of rounding */
        check_near(row->period, 2 * M_PI, tight);
        check_near(row->impact_rate, 1, 0);
        check_near(row->largest_speed, M_PI * 0.5 / (1 + r), 1e-8);
        close_single(&s);
    }
}

/* With fixed times. */
static saltus_sweep_options fixed_options(double rtol, long long transient, long long record) {
    saltus_sweep_options options = settling_options(rtol);
    options.adaptive = false;
    options.transient = transient;
    options.record = record;
    return options;
}

/* Near grazing the disturbance that proves stability may carry a trajectory far from its orbit. In a sweep
 * with fixed times, where a motion that does not recur is not waited for, it still has time to come back. */
static void a_disturbed_trajectory_may_come_back(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("fig6", "");
    const saltus_sweep_options options = fixed_options(5e-8, 300, 100);
    single s = run_single(&scene, "omega", 0.5 + 54.5 * 776 / 999, &options);
    assert_string_equal(s.label, "4/4");
    close_single(&s);
}

/* In a sweep with fixed times an orbit is disturbed before it is recorded: after the record nothing more is
 * waited for. */
static void a_long_transient_proves_the_orbit(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("fig7d", "");
    for (long long transient = 192; transient <= 400; transient += 104) {
        const saltus_sweep_options options = fixed_options(1e-10, transient, 60);
        single s = run_single(&scene, "omega", 42, &options);
        assert_string_equal(s.label, "4/4");
        assert_true((s.result.rows->settled == options.transient + options.record) == (transient > 192));
        close_single(&s);
    }
}

/* Of what a disturbance leads away from, the undisturbed motion is recorded: here one part of a system stays
 * at rest unless it is disturbed, and then grows. */
static void a_disturbance_leaves_no_trace_in_the_record(void **unused) {
    (void)unused;
    static const char text[] = "model:\n"
                               "  parameters: {c: 0.3, F: 0.4, omega: 1.3, g: 0.05}\n"
                               "  motion: {x: \"-c*x' - x + F*cos(omega*t)\", y: \"g*y' - 2*y\"}\n"
                               "  forcing: omega\n"
                               "initial: {x: 0.1, x': 0, y: 0, y': 0}\nobserve: y\n";
    saltus_scene scene;
    saltus_message message = {.text = ""};
    const saltus_sweep_options options = fixed_options(1e-10, 300, 20);
    check_ok(saltus_scene_parse(text, strlen(text), "text", &scene, &message), &message);
    single s = run_single(&scene, "F", 0.4, &options);
    const saltus_sweep_row *row = s.result.rows;
    assert_int_equal(row->verdict, SALTUS_IRREGULAR);
    assert_int_equal(row->recorded, 20);
    assert_true(row->largest == 0 && row->smallest == 0);
    assert_true(s.result.states[1] != 0); /* disturbed after the record */
    close_single(&s);
    saltus_scene_clear(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_long_transient_proves_the_orbit),
        cmocka_unit_test(a_disturbance_leaves_no_trace_in_the_record),
        cmocka_unit_test(an_orbit_is_reached_when_it_is_near),
        cmocka_unit_test(a_spiral_is_not_left_early),
        cmocka_unit_test(slow_orbits_are_found_in_time),
        cmocka_unit_test(orbits_with_impacts_are_near_too),
        cmocka_unit_test(a_free_motions_exponent_is_its_decay),
        cmocka_unit_test(counts_must_recur_as_points_do),
        cmocka_unit_test(a_part_that_does_not_close_leaves_doubt),
        cmocka_unit_test(what_divides_no_period_is_no_part),
        cmocka_unit_test(a_period_is_seen_often_enough),
        cmocka_unit_test(a_jump_begins_anew),
        cmocka_unit_test(one_good_step_is_not_trusted),
        cmocka_unit_test(a_rest_is_still),
        cmocka_unit_test(a_disturbed_trajectory_may_come_back),
        cmocka_unit_test(the_distance_left_of_a_series_is_its_rest),
        cmocka_unit_test(a_made_up_spiral_is_not_left_early),
        cmocka_unit_test(an_impact_in_the_section_doubles_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
