/* Collocation, and collocation mixed with series, against series: the same trajectory, contacts and tangent
 * vectors included.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes.h"

enum { dimension_max = 72, samples_max = 400 };

/* Run all integrators from the same settled state; returns the largest scaled difference from series
 * alone. */
static double compare(int modes, double omega, double d, double r, double settle, double periods, int columns,
                      double *tangent_difference) {
    saltus_spec spec = pipe_spec(modes, omega);
    add_stop(&spec, d, r, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {.text = ""};
    double start[dimension_max], state[3][dimension_max], worst = 0;
    static double tangents[3][4 * dimension_max];
    static const saltus_integrator integrators[] = {SALTUS_RADAU, SALTUS_TAYLOR, SALTUS_MIXED};
    check_ok(saltus_system_default_state(system, start, &message), &message);
    start[0] = 0.01; /* from here all have impacts */
    options.integrator = SALTUS_RADAU;
    saltus_flow *flow = open_flow(system, &options, 0, start);
    advance(flow, settle, 0);
    saltus_flow_state(flow, 0, start);
    saltus_flow_free(flow);
    options.columns = columns;
    long long impacts[3];
    for (int k = 0; k < 3; k++) {
        options.integrator = integrators[k];
        flow = open_flow(system, &options, settle - floor(settle), start);
        advance(flow, settle - floor(settle) + periods, 0);
        saltus_flow_state(flow, 0, state[k]);
        saltus_flow_tangents(flow, 0, tangents[k]);
        impacts[k] = saltus_flow_information(flow, 0).impacts;
        saltus_flow_free(flow);
    }
    int n = 2 * modes;
    *tangent_difference = 0;
    for (int k = 0; k < 3; k += 2) {
        for (int i = 0; i < n; i++)
            worst = fmax(worst, fabs(state[k][i] - state[1][i]) /
                                    saltus_system_scale(system)[i < modes ? 0 : modes]);
        for (int c = 0; c < columns; c++) {
            double size = 0;
            for (int i = 0; i < n; i++)
                size = fmax(size, fabs(tangents[1][c * n + i]));
            for (int i = 0; i < n; i++)
                *tangent_difference =
                    fmax(*tangent_difference, fabs(tangents[k][c * n + i] - tangents[1][c * n + i]) / size);
        }
        assert_true(impacts[k] == impacts[1] && impacts[k] > 0);
    }
    saltus_system_free(system);
    return worst;
}

static void agrees_at_five_modes(void **unused) {
    (void)unused;
    double tangents;
    check_near(compare(5, 42, 0.035, 0.9, 23, 4, 4, &tangents), 0, 1e-9);
    check_near(tangents, 0, 1e-8);
    check_near(compare(5, 10, 0.025, 0.9, 23, 2, 4, &tangents), 0, 1e-9);
    check_near(tangents, 0, 1e-8);
}

static void agrees_when_stiff(void **unused) {
    (void)unused;
    double tangents;
    check_near(compare(10, 42, 0.035, 0.9, 23, 2, 0, &tangents), 0, 1e-9);
    check_near(compare(10, 10, 0.025, 0.5, 22, 1, 0, &tangents), 0, 1e-9);
    check_near(compare(20, 42, 0.035, 0.9, 23, 1, 0, &tangents), 0, 1e-9);
    check_near(compare(32, 42, 0.035, 0.9, 23, 1, 0, &tangents), 0, 1e-9);
}

/* A complete chatter whose last flights are far shorter than any step. */
static void agrees_through_chatter(void **unused) {
    (void)unused;
    double tangents;
    check_near(compare(10, 20, 0.03, 0.5, 23, 2, 4, &tangents), 0, 1e-9);
    check_near(tangents, 0, 1e-8);
    check_near(compare(16, 20, 0.03, 0.5, 23, 2, 4, &tangents), 0, 1e-9);
    check_near(tangents, 0, 1e-8);
}

/* The leading multipliers do not depend on how many are resolved: for orbits of one and of four periods the
 * shorter one has all, and those of the longer one are their fourth powers. */
static void leading_multipliers_need_few_segments(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(16, 42);
    saltus_system *system = build(&spec);
    saltus_message message = {.text = ""};
    saltus_orbit_options options = saltus_orbit_defaults();
    saltus_orbit orbit[2] = {{0}};
    double start[dimension_max];
    check_ok(saltus_system_default_state(system, start, &message), &message);
    for (int k = 0; k < 2; k++) {
        const double *from = k ? orbit[0].state : start;
        check_ok(saltus_orbit_find(system, k ? 8 : 2, from, &options, &orbit[k], &message), &message);
    }
    assert_true(isfinite(orbit[0].log_volume) && isnan(orbit[1].log_volume));
    check_near(orbit[0].log_volume, orbit[0].sum_rule, 1e-11 * fabs(orbit[0].sum_rule));
    for (int k = 0; k < 8; k++)
        check_near(orbit[1].multipliers[k].log_modulus, 4 * orbit[0].multipliers[k].log_modulus, 1e-9);
    for (int k = 0; k < 2; k++)
        saltus_orbit_clear(&orbit[k]);
    saltus_system_free(system);
}

/* N = 32, where the explicit integrator would need steps of 1e-5: against itself at another tolerance. */
static void tolerance_at_many_modes(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(32, 42);
    add_stop(&spec, 0.035, 0.9, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_message message = {.text = ""};
    double start[dimension_max], state[2][dimension_max];
    assert_string_equal(saltus_system_integrator(system), "mixed");
    check_ok(saltus_system_default_state(system, start, &message), &message);
    for (int k = 0; k < 2; k++) {
        saltus_flow_options options = saltus_flow_defaults();
        options.rtol = k ? 1e-13 : 1e-10;
        saltus_flow *flow = open_flow(system, &options, 0, start);
        advance(flow, 3, 0);
        saltus_flow_state(flow, 0, state[k]);
        saltus_flow_free(flow);
    }
    for (int i = 0; i < 64; i++)
        check_near(state[0][i], state[1][i], 1e-8 * saltus_system_scale(system)[i < 32 ? 0 : 32]);
    saltus_system_free(system);
}

/* A pipe without a stop, or another scene without its stops, after some time. */
static saltus_system *free_scene(int kind, double *state) {
    scene s = kind < 2 ? scene_pipe(kind ? 3 : 5, kind ? 20 : 42)
                       : scene_of(kind == 2 ? scene_free_chain : scene_two_sided_mass);
    double start[dimension_max] = {0};
    const int shape = kind < 2 ? (kind ? 3 : 5) : 0;
    memcpy(start, s.state, sizeof s.state);
    s.spec.stop_count = 0;
    if (kind == 0) { /* more modes than scenes have */
        set_parameter(&s.spec, "N", 12);
        memset(start + 2, 0, sizeof start - 2 * sizeof *start);
        start[12] = s.state[shape];
    }
    saltus_system *system = build(&s.spec);
    saltus_flow_options options = saltus_flow_defaults();
    options.integrator = SALTUS_RADAU;
    saltus_flow *flow = open_flow(system, &options, 0.3, start);
    advance(flow, 1.3, 0);
    saltus_flow_state(flow, 0, state);
    saltus_flow_free(flow);
    return system;
}

/* When mixed, long steps are collocation and short ones series: without impacts as few steps as with
 * collocation alone; with impacts far fewer than with series, and fewer evaluations than with collocation. */
static void each_step_is_made_the_cheaper_way(void **unused) {
    (void)unused;
    static const saltus_integrator integrators[] = {SALTUS_TAYLOR, SALTUS_RADAU, SALTUS_MIXED};
    for (int kind = 0; kind < 4; kind++) {
        saltus_flow_info info[3];
        saltus_spec spec = pipe_spec(kind < 2 ? 14 : 20, 42);
        saltus_message message = {.text = ""};
        double start[dimension_max];
        if (kind % 2)
            add_stop(&spec, 0.035, kind == 1 ? 0.9 : 0.7, SALTUS_UPPER);
        saltus_system *system = build(&spec);
        check_ok(saltus_system_default_state(system, start, &message), &message);
        for (int k = 0; k < 3; k++) {
            saltus_flow_options options = saltus_flow_defaults();
            options.rtol = 1e-10;
            options.integrator = integrators[k];
            start[0] = 0.01;
            saltus_flow *flow = open_flow(system, &options, 0, start);
            advance(flow, 24, 0);
            const saltus_flow_info before = saltus_flow_information(flow, 0);
            advance(flow, 28, 0);
            info[k] = saltus_flow_information(flow, 0);
            info[k].steps -= before.steps;
            info[k].field_evaluations -= before.field_evaluations;
            info[k].impacts -= before.impacts;
            saltus_flow_free(flow);
        }
        assert_true(kind % 2 ? info[2].impacts > 10 : info[2].impacts == 0);
        if (kind % 2)
            assert_true(info[2].field_evaluations < info[1].field_evaluations &&
                        info[2].field_evaluations < 0.4 * (double)info[0].field_evaluations);
        else
            assert_true(info[2].steps == info[1].steps &&
                        info[2].field_evaluations <= info[1].field_evaluations);
        assert_true(info[2].steps < 0.2 * (double)info[0].steps);
        saltus_system_free(system);
    }
}

/* Step lengths are the period divided by powers of the fourth root of two. Inside steps too the solution
 * meets the tolerance, and not by far, which would mean steps shorter than needed. Steps grow with the
 * tolerance as expected of sixteen nodes. */
static void steps_follow_the_tolerance(void **unused) {
    (void)unused;
    for (int kind = 0; kind < 4; kind++) {
        double state[dimension_max], exact[dimension_max], inside[dimension_max], mean = 0, count[2] = {0};
        saltus_system *system = free_scene(kind, state);
        const int n = saltus_system_dimension(system);
        const double *scale = saltus_system_scale(system), period = saltus_system_period(system);
        int tolerances = 0;
        for (int digits = 6; digits <= 12; digits += 2) {
            saltus_flow_options options = saltus_flow_defaults();
            double worst = 0;
            options.rtol = 1e-14;
            saltus_flow *fine = open_flow(system, &options, 0.3, state);
            options.integrator = SALTUS_RADAU;
            options.rtol = pow(10, -digits);
            options.atol = 0;
            saltus_flow *flow = open_flow(system, &options, 0.3, state);
            for (int k = 0; k < 16; k++) {
                advance(flow, 1e6, SALTUS_WATCH_STEP);
                const double step = saltus_flow_step_length(flow, 0), place = -4 * log2(step / period),
                             begin = saltus_time_periods(saltus_flow_step_begin(flow, 0));
                check_near(place, round(place), 1e-9);
                for (int j = 1; j <= 4; j++) {
                    const double since = step * (0.27 * j - 0.14);
                    advance(fine, begin + since / period, 0);
                    saltus_flow_state(fine, 0, exact);
                    saltus_flow_dense(flow, 0, since, inside);
                    for (int i = 0; i < n; i++)
                        worst = fmax(worst, fabs(inside[i] - exact[i]) / scale[i]);
                }
            }
            const double passed = saltus_time_periods(saltus_flow_time(flow, 0)) - 0.3;
            if (digits == 6 || digits == 12)
                count[digits == 12] = 1 / passed;
            const saltus_flow_info info = saltus_flow_information(flow, 0);
            if (!(worst <= 30 * options.rtol))
                fail_msg("scene %d: %.3g inside a step at rtol %g", kind, worst, options.rtol);
            /* The guess is right except for the last digits, and the rest falls like (h L)^k / k!. */
            assert_true((double)info.field_evaluations <= 16 * 16 * (kind == 0 ? 10 : kind == 1 ? 15 : 27));
            mean += log10(worst / options.rtol);
            tolerances++;
            saltus_flow_free(fine);
            saltus_flow_free(flow);
        }
        /* The mean, in powers of ten; steps of one mass are limited by the period rather than the
         * tolerance. */
        mean /= tolerances;
        assert_true(mean < 1 && (mean > 0 || kind == 3));
        assert_true(count[1] > 1.4 * count[0] && count[1] < 1.2 * pow(10, 6.0 / 16) * count[0]);
        saltus_system_free(system);
    }
}

/* A step that begins inside the last one is guessed from its polynomial: steps cut short at close targets
 * take fewer sweeps. */
static void the_last_step_guesses_the_next(void **unused) {
    (void)unused;
    for (int kind = 0; kind < 3; kind++) {
        double state[dimension_max], sweeps[4];
        saltus_system *system = free_scene(kind, state);
        for (int part = 0; part < 4; part++) {
            saltus_flow_options options = saltus_flow_defaults();
            options.integrator = SALTUS_RADAU;
            options.rtol = 1e-9;
            saltus_flow *flow = open_flow(system, &options, 0.3, state);
            for (int k = 1; k <= (part ? 40 : 1); k++)
                advance(flow, 0.3 + (part ? k / 16.0 / (1 << 2 * part) : 6), 0);
            const saltus_flow_info info = saltus_flow_information(flow, 0);
            sweeps[part] = (double)info.field_evaluations / 16 / (double)info.steps;
            saltus_flow_free(flow);
        }
        assert_true(sweeps[0] > 4);
        for (int part = 1; part < 4; part++)
            if (!(sweeps[part] <= (part == 1 ? 1.6 : 1.2)))
                fail_msg("scene %d: %.3g sweeps where the last step goes on", kind, sweeps[part]);
        saltus_system_free(system);
    }
}

/* A linear steady system is solved at once: two sweeps per step, the second of which changes nothing, with
 * contacts, tangent vectors and any number of modes. */
static void the_linear_part_takes_one_sweep(void **unused) {
    (void)unused;
    for (int kind = 0; kind < 20; kind++)
        for (int held = 0; held < 3; held++) {
            const int modes = 1 + kind % 10, columns = kind % 3;
            saltus_spec spec = pipe_spec(modes, 12);
            set_parameter(&spec, "sigma", 0);
            set_parameter(&spec, "kappa", 0);
            set_parameter(&spec, "u0", 2);
            if (kind >= 10)
                set_parameter(&spec, "beta", 0.1);
            if (held >= modes)
                continue;
            for (int s = 0; s < held; s++) {
                add_stop(&spec, 0, 0.5, s ? SALTUS_LOWER : SALTUS_UPPER);
                spec.stops[s].xi = 0.37 + 0.2 * s;
            }
            saltus_system *system = build(&spec);
            saltus_flow_options options = saltus_flow_defaults();
            saltus_message message = {.text = ""};
            saltus_flow *flow = NULL;
            double state[dimension_max] = {0}, projected[dimension_max] = {0}, tangents[2 * dimension_max];
            options.integrator = SALTUS_RADAU;
            options.columns = columns;
            for (int i = 0; i < 2 * modes; i++)
                state[i] = i < modes ? 0.01 / (1 + i) : 0.03 * (i % 3 - 1);
            check_ok(saltus_flow_new((const saltus_system *[]){system}, 1, &options, &flow, &message),
                     &message);
            for (int pass = 0; pass < 2; pass++) { /* the first one brings the state onto the stops */
                check_ok(saltus_flow_place(flow, 0, (saltus_time){0, 0}, pass ? projected : state,
                                           (1u << held) - 1, &message),
                         &message);
                saltus_flow_state(flow, 0, projected);
            }
            for (int c = 0; c < columns; c++)
                for (int i = 0; i < 2 * modes; i++)
                    tangents[c * 2 * modes + i] = (1 + 0.5 * c) * projected[i];
            if (columns)
                saltus_flow_set_tangents(flow, 0, tangents);
            check_ok(saltus_flow_coast(flow, 0, (saltus_time){1, 0}, NULL, &message), &message);
            const saltus_flow_info info = saltus_flow_information(flow, 0);
            const long long begin = info.field_evaluations - 2 * 16 * info.steps;
            if (!(begin > 0 &&
                  begin <= 8)) /* the first step evaluates the field once, in all lanes of a pack */
                fail_msg("%d modes, %d held, %d columns: %lld evaluations too many", modes, held, columns,
                         begin);
            saltus_flow_free(flow);
            saltus_system_free(system);
        }
}

/* An isolated relaxation: beside a mass too heavy to move, the Maxwell element's force decays as exp(-t /
 * tz), in the trajectory or only in a tangent vector. Inside steps it meets the tolerance, and each step
 * predicts the next length, so that hardly any attempt fails. */
static void a_decay_alone_sets_the_steps(void **unused) {
    (void)unused;
    const double decay[] = {0.004, 0.05, 0.6}, along[] = {1, 0, 0, 0, 0, 1};
    for (int k = 0; k < 12; k++) {
        const double tz = decay[k % 3], start[] = {1, 0, k / 3 % 2 ? 0 : 1};
        saltus_spec spec = oscillator_spec(0, 0, 0, 1);
        set_parameter(&spec, "m", 1e12);
        set_parameter(&spec, "kz", 1e-9);
        set_parameter(&spec, "tz", tz);
        saltus_system *system = build(&spec);
        saltus_flow_options options = saltus_flow_defaults();
        options.integrator = SALTUS_RADAU;
        options.rtol = k < 6 ? 1e-12 : 1e-14;
        options.columns = 2;
        saltus_flow *flow = open_flow(system, &options, 0, start);
        saltus_flow_set_tangents(flow, 0, along);
        const double period = saltus_system_period(system);
        for (int step = 0; step < 12; step++) {
            double inside[3], tangents[6];
            advance(flow, 1e6, SALTUS_WATCH_STEP);
            const double begin = saltus_time_periods(saltus_flow_step_begin(flow, 0)) * period,
                         end = saltus_time_periods(saltus_flow_time(flow, 0)) * period;
            for (int j = 1; j <= 4; j++) {
                const double since = saltus_flow_step_length(flow, 0) * (0.27 * j - 0.14);
                saltus_flow_dense(flow, 0, since, inside);
                const double time = begin + since, left = exp(-time / tz);
                check_near(inside[0], 1 - 1e-12 * tz * start[2] * (time - tz * (1 - left)),
                           30 * options.rtol);
                check_near(inside[2], start[2] * left, 30 * options.rtol);
            }
            saltus_flow_tangents(flow, 0, tangents);
            check_near(tangents[2], 0, 30 * options.rtol);
            check_near(tangents[5], exp(-end / tz), 30 * options.rtol);
        }
        const saltus_flow_info info = saltus_flow_information(flow, 0);
        const double sweeps = (double)info.field_evaluations / 16 / (double)info.steps;
        if (!(sweeps < 28))
            fail_msg("tz = %g, rtol %g: %.3g sweeps a step", tz, options.rtol, sweeps);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_at_five_modes),
        cmocka_unit_test(agrees_when_stiff),
        cmocka_unit_test(agrees_through_chatter),
        cmocka_unit_test(leading_multipliers_need_few_segments),
        cmocka_unit_test(each_step_is_made_the_cheaper_way),
        cmocka_unit_test(steps_follow_the_tolerance),
        cmocka_unit_test(the_last_step_guesses_the_next),
        cmocka_unit_test(the_linear_part_takes_one_sweep),
        cmocka_unit_test(a_decay_alone_sets_the_steps),
        cmocka_unit_test(tolerance_at_many_modes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
