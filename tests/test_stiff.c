/* The stiff integrator against the explicit one: the same trajectory, contacts and tangent vectors included.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

enum { dimension_max = 72 };

/* Run both from the same settled state; largest scaled difference of states. */
static double compare(int modes, double omega, double d, double r, double settle, double periods, int columns,
                      double *tangent_difference) {
    saltus_spec spec = pipe_spec(modes, omega);
    add_stop(&spec, d, r, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_message message = {""};
    double start[dimension_max], state[2][dimension_max], worst = 0;
    static double tangents[2][4 * dimension_max];
    check_ok(saltus_system_default_state(system, start, &message), &message);
    options.integrator = SALTUS_RADAU;
    saltus_flow *flow = open_flow(system, &options, 0, start);
    advance(flow, settle, 0);
    saltus_flow_state(flow, 0, start);
    saltus_flow_free(flow);
    options.columns = columns;
    long long impacts[2];
    for (int k = 0; k < 2; k++) {
        options.integrator = k ? SALTUS_TAYLOR : SALTUS_RADAU;
        flow = open_flow(system, &options, settle - floor(settle), start);
        advance(flow, settle - floor(settle) + periods, 0);
        saltus_flow_state(flow, 0, state[k]);
        saltus_flow_tangents(flow, 0, tangents[k]);
        impacts[k] = saltus_flow_information(flow, 0).impacts;
        saltus_flow_free(flow);
    }
    int n = 2 * modes;
    for (int i = 0; i < n; i++)
        worst =
            fmax(worst, fabs(state[0][i] - state[1][i]) / saltus_system_scale(system)[i < modes ? 0 : modes]);
    *tangent_difference = 0;
    for (int c = 0; c < columns; c++) {
        double size = 0;
        for (int i = 0; i < n; i++)
            size = fmax(size, fabs(tangents[1][c * n + i]));
        for (int i = 0; i < n; i++)
            *tangent_difference =
                fmax(*tangent_difference, fabs(tangents[0][c * n + i] - tangents[1][c * n + i]) / size);
    }
    assert_true(impacts[0] == impacts[1]);
    saltus_system_free(system);
    return worst;
}

static void agrees_at_five_modes(void **unused) {
    (void)unused;
    double tangents;
    check_near(compare(5, 42, 0.035, 0.9, 3, 4, 4, &tangents), 0, 1e-9);
    check_near(tangents, 0, 1e-8);
    check_near(compare(5, 10, 0.025, 0.9, 3, 2, 4, &tangents), 0, 1e-9);
    check_near(tangents, 0, 1e-8);
}

static void agrees_when_stiff(void **unused) {
    (void)unused;
    double tangents;
    check_near(compare(10, 42, 0.035, 0.9, 3, 2, 0, &tangents), 0, 1e-9);
    check_near(compare(10, 10, 0.025, 0.5, 2, 1, 0, &tangents), 0, 1e-9);
    check_near(compare(20, 42, 0.035, 0.9, 3, 1, 0, &tangents), 0, 1e-9);
    check_near(compare(32, 42, 0.035, 0.9, 3, 1, 0, &tangents), 0, 1e-9);
}

/* N = 32: where the explicit integrator would need steps of 1e-5, against itself at another tolerance. */
static void tolerance_at_many_modes(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(32, 42);
    add_stop(&spec, 0.035, 0.9, SALTUS_UPPER);
    saltus_system *system = build(&spec);
    saltus_message message = {""};
    double start[dimension_max], state[2][dimension_max];
    assert_string_equal(saltus_system_integrator(system), "radau");
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_at_five_modes),
        cmocka_unit_test(agrees_when_stiff),
        cmocka_unit_test(tolerance_at_many_modes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
