/* Sweeps of unforced scenes: rows agree with classification for orbits with their own periods, equilibria and
 * chaos.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep_check.h"

#include "orbit/lap.h"

#include <gsl/gsl_rng.h>

static double between(gsl_rng *rng, double low, double high) {
    return low + (high - low) * gsl_rng_uniform(rng);
}

static saltus_scene scene_from(const char *text) {
    saltus_message message = {.text = ""};
    saltus_scene scene;
    check_ok(saltus_scene_parse(text, strlen(text), "text", &scene, &message), &message);
    return scene;
}

static const char struck_van_der_pol[] = "model:\n"
                                         "  parameters: {mu: 1}\n"
                                         "  motion: {x: mu*(1 - x^2)*x' - x}\n"
                                         "stop: {coordinate: x, d: 1.5, r: 0.7, sides: upper}\n"
                                         "initial: {x: 0.5}\n";

/* The measures and the clouds of a row are those of the orbit that classification finds. */
static void check_orbit(const single *s) {
    const saltus_sweep_row *row = s->result.rows;
    saltus_system *system = system_at(s->sweep, 0);
    saltus_motion m = motion_from(system, s->result.states, 20);
    assert_int_equal(m.verdict, SALTUS_PERIODIC);
    assert_string_equal(s->label, m.label);
    check_near(row->period, m.period, 1e-9 * m.period);
    check_near(row->largest, m.largest, 1e-8);
    check_near(row->smallest, m.smallest, 1e-8);
    check_near(row->rms, m.rms, 1e-8);
    check_near(row->lyapunov, m.lyapunov, 1e-6 * (1 + fabs(m.lyapunov)));
    assert_true(row->recorded == m.periods && row->sticking == m.sticking_intervals);
    assert_true(saltus_system_distance(system, s->result.states, m.state) < 1e-8);
    assert_int_equal(s->result.strobe_counts[0], m.periods);
    for (int k = 0; k < m.periods; k++)
        assert_true(saltus_orbit_passes(system, m.section_states, m.periods,
                                        s->result.strobes + k * m.dimension, 1e-8));
    if (m.impacts >= 0)
        assert_int_equal(s->result.impact_counts[0], m.impacts);
    for (int k = 0; k < m.event_count && m.impacts > 0; k++) {
        double nearest = 1;
        for (int e = 0; e < m.event_count; e++) {
            double phase = fmod(m.periods * saltus_time_periods(m.events[e].time), 1),
                   apart = fabs(phase - s->result.impacts[k].phase);
            nearest = fmin(nearest, fmin(apart, 1 - apart));
        }
        check_near(nearest, 0, 1e-8);
    }
    saltus_motion_clear(&m);
    saltus_system_free(system);
}

static void rows_and_motions_agree(void **unused) {
    (void)unused;
    static const struct {
        const char *scene, *key;
        double low, high;
    } ranges[] = {{"relief-valve", "q", 2, 9.5},
                  {"flutter", "u", 5.5, 8},
                  {"van-der-pol", "mu", 0.05, 20},
                  {NULL, "mu", 0.1, 5}};
    const int points = long_version() ? 100 : 12;
    int settled = 0, cycles = 0;
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    saltus_sweep_options options = saltus_sweep_defaults();
    gsl_rng_set(rng, 5);
    options.threads = 1;
    options.keep = 15;
    options.measure = 0;
    options.record = 1;
    for (int k = 0; k < points; k++)
        for (size_t r = 0; r < sizeof ranges / sizeof ranges[0]; r++) {
            saltus_scene scene =
                ranges[r].scene ? scene_of(ranges[r].scene, "") : scene_from(struck_van_der_pol);
            single s =
                run_single(&scene, ranges[r].key, between(rng, ranges[r].low, ranges[r].high), &options);
            settled += check_label(&s.outcome, 0, 0);
            if (s.result.rows->verdict == SALTUS_PERIODIC) {
                check_orbit(&s);
                cycles++;
            }
            close_single(&s);
            saltus_scene_clear(&scene);
        }
    assert_true(settled > 4 * points * 9 / 10 && cycles > 4 * points * 3 / 4 && cycles < settled);
    gsl_rng_free(rng);
}

/* The valve along the flow rate, both ways: at rest beyond the Hopf point, a cycle without impacts up to
 * grazing, chaos beyond, then one impact in each cycle of one or two maxima (independent programs: Hopf
 * 8.4911, grazing 7.5572, no period at 7.55, 7.30, 7.05). */
static void the_valve_is_carried_through_its_diagram(void **unused) {
    (void)unused;
    saltus_scene scene = scene_of("relief-valve", "");
    saltus_sweep_options options = saltus_sweep_defaults();
    options.threads = 1;
    options.passes = 1u << SALTUS_PASS_UP | 1u << SALTUS_PASS_DOWN;
    saltus_sweep *sweep =
        sweep_of(&scene, "q=9,8.6,8.45,8,7.6,7.55,7.3,7.05,6.8,5.05,3.05,2", NULL, &options);
    static const char *const labels[] = {"equilibrium", "equilibrium", "0/1", "0/1", "0/1", "irregular",
                                         "irregular",   "irregular",   "1/2", "1/1", "1/1", "1/1"};
    static const double periods[] = {[8] = 4.9985607773, [9] = 2.1645752428, [10] = 1.7290763308, [11] = 0};
    outcome o = open_outcome(sweep);
    run_part(&o, 0, 1);
    assert_true(o.places == 24);
    for (int k = 0; k < 24; k++) {
        saltus_sweep_result result = result_at(&o, k);
        char label[SALTUS_LABEL_MAX];
        saltus_sweep_label(result.rows, label);
        assert_string_equal(label, labels[k % 12]);
        assert_true(isnan(result.rows->period) == (result.rows->verdict != SALTUS_PERIODIC));
        if (periods[k % 12] > 0)
            check_near(result.rows->period, periods[k % 12], 1.5e-10);
    }
    close_outcome(&o);
    saltus_sweep_free(sweep);
    saltus_scene_clear(&scene);
}

/* Published: the flutter's exponent is between 1 and 2 in chaos. */
static void exponents_tell_chaos(void **unused) {
    (void)unused;
    skip_where_slow();
    saltus_scene scene = scene_of("flutter", "");
    saltus_sweep_options options = saltus_sweep_defaults();
    options.threads = 1;
    options.keep = SALTUS_KEEP_LYAPUNOV;
    options.transient = 200;
    options.lifetime = 1000;
    options.measure = 4000;
    saltus_sweep *sweep = sweep_of(&scene, "u=8.1,8.2", NULL, &options);
    outcome o = open_outcome(sweep);
    run_part(&o, 0, 1);
    for (int k = 0; k < 2; k++) {
        const saltus_sweep_row *row = result_at(&o, k).rows;
        assert_int_equal(row->verdict, SALTUS_CHAOTIC);
        assert_true(row->lyapunov - 3 * row->lyapunov_error > 1 &&
                    row->lyapunov + 3 * row->lyapunov_error < 2);
        assert_true(row->lyapunov_error > 0 && row->lyapunov_error < 0.1);
    }
    close_outcome(&o);
    saltus_sweep_free(sweep);
    saltus_scene_clear(&scene);
}

/* Beyond its pitchfork the flutter has two mirrored cycles, whose basins are equally large in every symmetric
 * plane of initial states. */
static void basins_of_a_pair_are_mirror_images(void **unused) {
    (void)unused;
    saltus_message message = {.text = ""};
    saltus_scene scene = scene_of("flutter", "u=7.7 q2=0");
    saltus_sweep_options options = saltus_sweep_defaults();
    options.threads = 1;
    saltus_sweep *sweep = sweep_of(&scene, "q1=-0.35:0.35:4", "q1'=-3:3:4", &options);
    saltus_basins *basins = NULL;
    int attractor[16];
    outcome o = open_outcome(sweep);
    run_part(&o, 0, 1);
    check_ok(saltus_basins_new(sweep, &basins, &message), &message);
    for (int k = 0; k < 16; k++) {
        saltus_sweep_result result = result_at(&o, k);
        check_ok(saltus_basins_sort(basins, result.rows, result.states, &attractor[k], &message), &message);
    }
    assert_int_equal(saltus_basins_count(basins), 2);
    for (int k = 0; k < 16; k++)
        assert_true(attractor[k] + attractor[15 - k] == 1);
    check_near(saltus_basins_motion(basins, 0)->period, saltus_basins_motion(basins, 1)->period, 1e-10);
    saltus_basins_free(basins);
    close_outcome(&o);
    saltus_sweep_free(sweep);
    saltus_scene_clear(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_and_motions_agree),
        cmocka_unit_test(the_valve_is_carried_through_its_diagram),
        cmocka_unit_test(exponents_tell_chaos),
        cmocka_unit_test(basins_of_a_pair_are_mirror_images),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
