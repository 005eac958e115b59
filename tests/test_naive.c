/* The naive method behaves as described: fourth order in free flight, first order through impacts, and
 * therefore wrong about the class of motion at coarse steps. It is tested only so that the trial of the paper
 * uses a method that works as described.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "naive/naive_class.h"
#include "reference.h"

enum { steps_averaged = 32 };

static naive_pipe pipe_of(const saltus_spec *spec) {
    naive_pipe pipe;
    assert_true(naive_pipe_from(spec, &pipe));
    return pipe;
}

/* The period in which fig7b has its three impacts. */
enum { struck = 2 };

/* From the reference orbit's section point through that period: the distance from the exact place. */
static double error_past_impacts(const reference *r, const naive_pipe *pipe, double h) {
    naive_runner runner;
    double end = 2 * acos(-1) / pipe->omega, state[16];
    naive_begin(&runner, pipe, h);
    for (int l = 0; l < naive_lanes; l++)
        naive_put(&runner, l, r->states[struck]);
    naive_run_until(&runner, end);
    naive_states states = naive_states_at(&runner, end);
    for (int i = 0; i < r->n; i++)
        state[i] = states.x[i][0];
    assert_int_equal(runner.tally[0].impacts, 3);
    return reference_distance(r, state, struck + 1);
}

/* The delay of a noticed impact depends on the steps' phase, so errors are averaged over steps from h to 2
 * h. */
static double mean_error(const reference *r, const naive_pipe *pipe, double h) {
    double sum = 0;
    for (int k = 0; k < steps_averaged; k++)
        sum += error_past_impacts(r, pipe, h * (1 + (double)k / steps_averaged));
    return sum / steps_averaged;
}

static void impacts_make_it_first_order(void **unused) {
    (void)unused;
    reference r = read_reference("fig7b");
    naive_pipe pipe = pipe_of(&r.spec);
    double coarse = mean_error(&r, &pipe, 4e-5), fine = mean_error(&r, &pipe, 1e-5);
    check_near(log(coarse / fine) / log(4), 1, 0.15);
}

/* Without a stop, against the library's flow at its tightest. */
static double free_error(const saltus_system *system, const double *start, double h) {
    saltus_flow_options options = saltus_flow_defaults();
    naive_pipe pipe = pipe_of(saltus_system_spec(system));
    naive_runner runner;
    double exact[10], worst = 0;
    saltus_flow *flow = open_flow(system, &options, 0, start);
    advance(flow, 2, 0);
    saltus_flow_state(flow, 0, exact);
    saltus_flow_free(flow);
    naive_begin(&runner, &pipe, h);
    for (int l = 0; l < naive_lanes; l++)
        naive_put(&runner, l, start);
    naive_run_until(&runner, 2 * saltus_system_period(system));
    naive_states states = naive_states_at(&runner, 2 * saltus_system_period(system));
    for (int i = 0; i < 10; i++)
        worst = fmax(worst, fabs(states.x[i][naive_lanes - 1] - exact[i]) * (i < 5 ? 1 : 0.01));
    return worst;
}

static void free_flight_is_fourth_order(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 43);
    saltus_system *system = build(&spec);
    const double start[10] = {0.02, -0.004, 0.001, 0.0005, -0.0002, 0.1, 0.05, -0.02, 0.01, 0.005};
    double coarse = free_error(system, start, 1e-3), fine = free_error(system, start, 2.5e-4);
    check_near(log(coarse / fine) / log(4), 4, 0.2);
    assert_true(fine < 1e-8);
    saltus_system_free(system);
}

/* All lanes start on the reference orbit's first points, to exclude other attractors. */
static void class_of_steps(const reference *r, double h, naive_class classes[naive_lanes]) {
    naive_pipe pipe = pipe_of(&r->spec);
    double states[naive_lanes * 10];
    for (int l = 0; l < naive_lanes; l++)
        memcpy(states + 10 * l, r->states[l % r->periods], 10 * sizeof *states);
    naive_classify(&pipe, h, false, states, 100, r->spec.stops[0].d, classes);
}

static void its_class_depends_on_its_step(void **unused) {
    (void)unused;
    reference r = read_reference("fig7b");
    naive_class classes[naive_lanes];
    class_of_steps(&r, 5e-5, classes);
    assert_int_equal(classes[0].impacts, 3);
    assert_int_equal(classes[0].periods, 5);
    class_of_steps(&r, 2e-3, classes);
    for (int l = 0; l < naive_lanes; l++)
        assert_false(classes[l].impacts == 3 && classes[l].periods == 5);
    class_of_steps(&r, 0.02, classes);
    for (int l = 0; l < naive_lanes; l++)
        assert_false(classes[l].finite);
}

static void it_refuses_what_it_cannot_describe(void **unused) {
    (void)unused;
    naive_pipe pipe;
    saltus_spec many = pipe_spec(naive_modes_max + 1, 43), other = oscillator_spec(0, 1, 1, 1);
    assert_false(naive_pipe_from(&many, &pipe));
    assert_false(naive_pipe_from(&other, &pipe));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(free_flight_is_fourth_order),
        cmocka_unit_test(impacts_make_it_first_order),
        cmocka_unit_test(its_class_depends_on_its_step),
        cmocka_unit_test(it_refuses_what_it_cannot_describe),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
