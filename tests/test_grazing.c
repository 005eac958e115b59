/* Grazing: a stop just beyond the largest displacement of a free orbit is never hit, one just before it
 * always.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

enum { phases = 1000 };

/* The free orbit of a pipe without stop and its largest displacement, at the tightest tolerance. */
static double free_orbit(const saltus_spec *spec, int *periods, double *state) {
    saltus_system *system = build(spec);
    saltus_classify_options options = saltus_classify_defaults();
    saltus_message message = {.text = ""};
    saltus_motion motion;
    options.flow.rtol = 1e-15;
    options.flow.atol = 1e-18;
    check_ok(saltus_system_default_state(system, state, &message), &message);
    check_ok(saltus_classify(system, state, &options, &motion, &message), &message);
    assert_int_equal(motion.verdict, SALTUS_PERIODIC);
    double largest = motion.largest;
    *periods = motion.periods;
    memcpy(state, motion.state, (size_t)motion.dimension * sizeof *state);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    return largest;
}

/* Count the impacts in one orbit from many starting phases. */
static void count_phases(const saltus_spec *free_spec, double d, int periods, const double *state,
                         double rtol, long long *with, long long *without) {
    saltus_spec spec = *free_spec;
    add_stop(&spec, d, 0.8, SALTUS_UPPER);
    saltus_system *stopped = build(&spec), *free_system = build(free_spec);
    saltus_flow_options fine = saltus_flow_defaults(), options = fine;
    fine.rtol = 1e-15;
    options.rtol = rtol;
    options.atol = 1e-2 * rtol;
    double point[16];
    saltus_flow *carrier = open_flow(free_system, &fine, 0, state), *flow = NULL;
    *with = *without = 0;
    for (int k = 0; k < phases; k++) {
        saltus_message message = {.text = ""};
        double start = (double)periods * k / phases;
        advance(carrier, start, 0);
        saltus_flow_state(carrier, 0, point);
        if (!flow)
            flow = open_flow(stopped, &options, 0, point);
        check_ok(saltus_flow_start(flow, 0, (saltus_time){0, start - floor(start)}, point, &message),
                 &message);
        saltus_time now = saltus_flow_time(flow, 0);
        saltus_event event;
        now.cycle += periods;
        check_ok(saltus_flow_advance(flow, now, SALTUS_WATCH_IMPACT, &event, &message), &message);
        ++*(event.kind == SALTUS_REACHED ? without : with);
    }
    saltus_flow_free(flow);
    saltus_flow_free(carrier);
    saltus_system_free(stopped);
    saltus_system_free(free_system);
}

/* The flow's own error at the maximum: how far the largest displacement moves with the tolerance. */
static double flow_error(const saltus_spec *spec, double largest, int periods, const double *state,
                         double rtol) {
    saltus_system *system = build(spec);
    saltus_flow_options options = saltus_flow_defaults();
    options.rtol = rtol;
    options.atol = 1e-2 * rtol;
    double worst = 0;
    for (int k = 0; k < 20; k++) {
        double start = (double)periods * k / 20, point[16], top = -INFINITY;
        saltus_flow_options fine = saltus_flow_defaults();
        saltus_flow *flow = open_flow(system, &fine, 0, state);
        advance(flow, start, 0);
        saltus_flow_state(flow, 0, point);
        saltus_flow_free(flow);
        flow = open_flow(system, &options, start - floor(start), point);
        for (;;) {
            saltus_event event = advance(flow, start - floor(start) + periods, SALTUS_WATCH_TURNING);
            if (event.kind == SALTUS_REACHED)
                break;
            top = fmax(top, event.displacement);
        }
        worst = fmax(worst, fabs(top - largest));
        saltus_flow_free(flow);
    }
    saltus_system_free(system);
    return worst;
}

static void neither_missed_nor_invented(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 20);
    double state[16];
    int periods;
    long long with, without;
    double largest = free_orbit(&spec, &periods, state);
    for (int digits = 6; digits <= 12; digits += 2) {
        double rtol = pow(10, -digits);
        double offset =
            digits == 12 ? 1e-10 : fmax(1e-10, 10 * flow_error(&spec, largest, periods, state, rtol));
        count_phases(&spec, largest + offset, periods, state, rtol, &with, &without);
        assert_int_equal(with, 0);
        count_phases(&spec, largest - offset, periods, state, rtol, &with, &without);
        assert_int_equal(without, 0);
    }
}

/* The largest displacement is known to 1e-13: two orders of the integrator agree. */
static void largest_displacement_is_known(void **unused) {
    (void)unused;
    saltus_spec spec = pipe_spec(5, 20);
    double state[16];
    int periods;
    double largest = free_orbit(&spec, &periods, state);
    saltus_system *system = build(&spec);
    for (int order = 16; order <= 32; order += 8) {
        saltus_flow_options options = saltus_flow_defaults();
        options.order = order;
        double top = -INFINITY;
        saltus_flow *flow = open_flow(system, &options, 0, state);
        for (;;) {
            saltus_event event = advance(flow, periods, SALTUS_WATCH_TURNING);
            if (event.kind == SALTUS_REACHED)
                break;
            top = fmax(top, event.displacement);
        }
        check_near(top, largest, 1e-14);
        saltus_flow_free(flow);
    }
    saltus_system_free(system);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(largest_displacement_is_known),
        cmocka_unit_test(neither_missed_nor_invented),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
