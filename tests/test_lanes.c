/* Trajectories side by side give the bits of trajectories alone.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>

enum { trajectories = 64, modes = 5, dimension = 2 * modes, periods = 30, columns = 2 };

typedef struct outcome {
    double state[dimension], tangents[columns * dimension];
    saltus_flow_info info;
} outcome;

static saltus_system *random_system(gsl_rng *rng, int k) {
    saltus_spec spec = pipe_spec(modes, 8 + 45 * gsl_rng_uniform(rng));
    add_stop(&spec, k % 4 == 0 ? 0.02 : 0.025 + 0.012 * gsl_rng_uniform(rng),
             0.5 + 0.45 * gsl_rng_uniform(rng), SALTUS_UPPER);
    if (k % 4 == 0)
        set_parameter(&spec, "omega", 9 + 2 * gsl_rng_uniform(rng)); /* chatter and sticking */
    return build(&spec);
}

static void random_state(gsl_rng *rng, const saltus_system *system, double *state) {
    do
        for (int i = 0; i < dimension; i++)
            state[i] = gsl_ran_gaussian(rng, saltus_system_scale(system)[i]);
    while (saltus_system_check_state(system, state, NULL) != SALTUS_OK);
}

static saltus_time target(int k) {
    return (saltus_time){periods, 0.01 * k};
}

static void finish(const saltus_flow *flow, int lane, outcome *out) {
    saltus_flow_state(flow, lane, out->state);
    saltus_flow_tangents(flow, lane, out->tangents);
    out->info = saltus_flow_information(flow, lane);
}

static void run_alone(saltus_system *const *systems, double (*states)[dimension],
                      const saltus_flow_options *options, outcome *out) {
    for (int k = 0; k < trajectories; k++) {
        saltus_flow *flow = open_flow(systems[k], options, 0, states[k]);
        saltus_message message = {""};
        saltus_event event;
        check_ok(saltus_flow_advance(flow, target(k), 0, &event, &message), &message);
        finish(flow, 0, &out[k]);
        saltus_flow_free(flow);
    }
}

/* One flow per group of lanes; a group's lanes end at different times, and lanes rest while others go on. */
static void run_side_by_side(saltus_system *const *systems, double (*states)[dimension],
                             const saltus_flow_options *options, outcome *out) {
    int width = saltus_flow_width(systems[0]);
    for (int first = 0; first < trajectories; first += width) {
        int count = trajectories - first < width ? trajectories - first : width, lane = 0;
        const saltus_system *group[16];
        saltus_message message = {""};
        saltus_flow *flow;
        for (int l = 0; l < count; l++)
            group[l] = systems[first + l];
        check_ok(saltus_flow_new(group, count, options, &flow, &message), &message);
        for (int l = 0; l < count; l++) {
            check_ok(saltus_flow_start(flow, l, (saltus_time){0, 0}, states[first + l], &message), &message);
            saltus_flow_aim(flow, l, target(first + l), 0);
        }
        for (int l = 0; l < count; l++) {
            saltus_event event;
            check_ok(saltus_flow_run(flow, &lane, &event, &message), &message);
            assert_int_equal(event.kind, SALTUS_REACHED);
            finish(flow, lane, &out[first + lane]);
        }
        saltus_flow_free(flow);
    }
}

static void same_bits(void **unused) {
    (void)unused;
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    saltus_system *systems[trajectories];
    static double states[trajectories][dimension];
    static outcome alone[trajectories], together[trajectories];
    saltus_flow_options options = saltus_flow_defaults();
    options.columns = columns;
    long long impacts = 0, sticks = 0;
    for (int k = 0; k < trajectories; k++) {
        systems[k] = random_system(rng, k);
        random_state(rng, systems[k], states[k]);
    }
    run_alone(systems, states, &options, alone);
    run_side_by_side(systems, states, &options, together);
    for (int k = 0; k < trajectories; k++) {
        assert_memory_equal(alone[k].state, together[k].state, sizeof alone[k].state);
        assert_memory_equal(alone[k].tangents, together[k].tangents, sizeof alone[k].tangents);
        assert_true(alone[k].info.steps == together[k].info.steps &&
                    alone[k].info.impacts == together[k].info.impacts);
        impacts += alone[k].info.impacts;
        sticks += alone[k].info.sticks;
        saltus_system_free(systems[k]);
    }
    assert_true(impacts > 5000);
    assert_true(sticks > 20);
    gsl_rng_free(rng);
}

/* Two flows advanced in turns are two flows advanced one after the other. */
static void interleaved_flows(void **unused) {
    (void)unused;
    saltus_spec spec[2] = {pipe_spec(5, 42), pipe_spec(3, 10)};
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *turns[2], *whole[2];
    saltus_system *systems[2];
    for (int k = 0; k < 2; k++) {
        double state[dimension] = {0};
        saltus_message message = {""};
        add_stop(&spec[k], 0.03, 0.9, SALTUS_UPPER);
        systems[k] = build(&spec[k]);
        check_ok(saltus_system_default_state(systems[k], state, &message), &message);
        turns[k] = open_flow(systems[k], &options, 0, state);
        whole[k] = open_flow(systems[k], &options, 0, state);
        for (int p = 1; p <= 40; p++)
            advance(whole[k], p, 0);
    }
    for (int p = 1; p <= 40; p++)
        for (int k = 0; k < 2; k++)
            advance(turns[k], p, 0);
    for (int k = 0; k < 2; k++) {
        double a[dimension] = {0}, b[dimension] = {0};
        saltus_flow_state(turns[k], 0, a);
        saltus_flow_state(whole[k], 0, b);
        assert_memory_equal(a, b, sizeof a);
        saltus_flow_free(turns[k]);
        saltus_flow_free(whole[k]);
        saltus_system_free(systems[k]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_bits),
        cmocka_unit_test(interleaved_flows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
