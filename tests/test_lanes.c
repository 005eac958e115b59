/* Trajectories side by side have the same bits as single ones.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <limits.h>
#include <stdlib.h>

enum { trajectories = 64, modes_max = 9, dimension = 2 * modes_max, columns_max = modes_max + 1 };

typedef struct outcome {
    double state[dimension], tangents[columns_max * dimension];
    saltus_flow_info info;
} outcome;

static saltus_system *random_system(gsl_rng *rng, int k, int modes) {
    saltus_spec spec = pipe_spec(modes, 8 + 45 * gsl_rng_uniform(rng));
    add_stop(&spec, k % 4 == 0 ? 0.02 : 0.025 + 0.012 * gsl_rng_uniform(rng),
             0.5 + 0.45 * gsl_rng_uniform(rng), SALTUS_UPPER);
    if (k % 4 == 0)
        set_parameter(&spec, "omega", 9 + 2 * gsl_rng_uniform(rng)); /* chatter and sticking */
    return build(&spec);
}

static void random_state(gsl_rng *rng, const saltus_system *system, double *state) {
    do
        for (int i = 0; i < saltus_system_dimension(system); i++)
            state[i] = gsl_ran_gaussian(rng, saltus_system_scale(system)[i]);
    while (saltus_system_check_state(system, state, NULL) != SALTUS_OK);
}

static saltus_time target(int k) {
    return (saltus_time){30, 0.01 * k};
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
        saltus_message message = {.text = ""};
        saltus_event event;
        check_ok(saltus_flow_advance(flow, target(k), 0, &event, &message), &message);
        finish(flow, 0, &out[k]);
        saltus_flow_free(flow);
    }
}

static void set_going(saltus_flow *flow, int lane, int k, saltus_system *const *systems,
                      double (*states)[dimension]) {
    saltus_message message = {.text = ""};
    check_ok(saltus_flow_retune(flow, lane, systems[k], &message), &message);
    check_ok(saltus_flow_start(flow, lane, (saltus_time){0, 0}, states[k], &message), &message);
    saltus_flow_aim(flow, lane, target(k), 0);
}

/* Run all trajectories in one flow: a lane that has reached its target takes the next one; at the end lanes
 * rest while others go on. */
static void run_side_by_side(saltus_system *const *systems, double (*states)[dimension],
                             const saltus_flow_options *options, outcome *out) {
    const saltus_system *first[16];
    int width = saltus_flow_width(systems[0], SALTUS_AUTOMATIC, LLONG_MAX), own[16], next = 0, lane = 0;
    saltus_message message = {.text = ""};
    saltus_flow *flow;
    assert_true(width <= 16);
    for (int l = 0; l < width; l++)
        first[l] = systems[l];
    check_ok(saltus_flow_new(first, width, options, &flow, &message), &message);
    for (; next < width; next++) {
        set_going(flow, next, next, systems, states);
        own[next] = next;
    }
    for (int done = 0; done < trajectories; done++) {
        saltus_event event;
        check_ok(saltus_flow_run(flow, &lane, &event, &message), &message);
        assert_int_equal(event.kind, SALTUS_REACHED);
        finish(flow, lane, &out[own[lane]]);
        if (next < trajectories) {
            set_going(flow, lane, next, systems, states);
            own[lane] = next++;
        }
    }
    saltus_flow_free(flow);
}

/* Returns the counts of the flow. */
static saltus_flow_info compare(int modes, const saltus_flow_options *options) {
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    saltus_system *systems[trajectories];
    static double states[trajectories][dimension];
    static outcome alone[trajectories], together[trajectories];
    saltus_flow_info sum = {0};
    for (int k = 0; k < trajectories; k++) {
        systems[k] = random_system(rng, k, modes);
        random_state(rng, systems[k], states[k]);
    }
    run_alone(systems, states, options, alone);
    run_side_by_side(systems, states, options, together);
    for (int k = 0; k < trajectories; k++) {
        assert_memory_equal(alone[k].state, together[k].state, sizeof alone[k].state);
        assert_memory_equal(alone[k].tangents, together[k].tangents, sizeof alone[k].tangents);
        assert_true(alone[k].info.steps == together[k].info.steps &&
                    alone[k].info.field_evaluations == together[k].info.field_evaluations &&
                    alone[k].info.impacts == together[k].info.impacts);
        sum.impacts += alone[k].info.impacts;
        sum.sticks += alone[k].info.sticks;
        saltus_system_free(systems[k]);
    }
    gsl_rng_free(rng);
    return sum;
}

static void same_bits(void **unused) {
    (void)unused;
    saltus_flow_options options = saltus_flow_defaults();
    options.columns = 2;
    saltus_flow_info sum = compare(5, &options);
    assert_true(sum.impacts > 5000);
    assert_true(sum.sticks > 20);
}

/* For numbers of modes with and without their own loops, without tangent vectors, with one and with so many
 * that a single trajectory takes several at once, and tolerances at which lanes need different orders of the
 * forcing. */
static void same_bits_at_any_size(void **unused) {
    (void)unused;
    const int modes[] = {1, 2, 3, 4, 5, 6, 7, 8, modes_max};
    /* Sanitizers are slow: three sizes will do, and no square of the largest. */
    const int slow = getenv("SALTUS_SANITIZED") != NULL, stride = slow ? 4 : 1;
    long long impacts = 0;
    for (int k = 0; k < 9; k += stride)
        for (int way = 0; way < (slow && k == 8 ? 2 : 3 - k % 2); way++) {
            const int columns = way < 2 ? way : modes[k] + 1;
            saltus_flow_options options = saltus_flow_defaults();
            options.rtol = columns ? 1e-10 : 1e-7;
            options.atol = 1e-3 * options.rtol;
            options.columns = columns;
            options.integrator = SALTUS_TAYLOR;
            options.order = k % 2 ? 9 : 0;
            impacts += compare(modes[k], &options).impacts;
        }
    assert_true(impacts > 50000 / stride);
}

/* Two flows advanced alternately are the same as one after the other. */
static void interleaved_flows(void **unused) {
    (void)unused;
    saltus_spec spec[2] = {pipe_spec(5, 42), pipe_spec(3, 10)};
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *turns[2], *whole[2];
    saltus_system *systems[2];
    for (int k = 0; k < 2; k++) {
        double state[dimension] = {0};
        saltus_message message = {.text = ""};
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

/* So far away that no step is shortened by it. */
static saltus_time far_target(int k) {
    return (saltus_time){100000, 0.01 * k};
}

/* A trajectory alone, step by step, until it has taken so many. */
static saltus_time after_steps(const saltus_system *system, const saltus_flow_options *options,
                               const double *start, long long steps, double *state) {
    saltus_flow *flow = open_flow(system, options, 0, start);
    saltus_message message = {.text = ""};
    saltus_event event;
    while (saltus_flow_information(flow, 0).steps < steps)
        check_ok(saltus_flow_advance(flow, far_target(0), SALTUS_WATCH_STEP, &event, &message), &message);
    const saltus_time time = saltus_flow_time(flow, 0);
    saltus_flow_state(flow, 0, state);
    saltus_flow_free(flow);
    return time;
}

/* Whenever a lane has an event, the others are on their way, and some of them are given a new target: each
 * tells its time, steps and state as if it were alone. */
static void lanes_under_way(void **unused) {
    (void)unused;
    enum { modes = 3, questions = 40 };
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    saltus_flow_options options = saltus_flow_defaults();
    saltus_system *systems[16];
    const saltus_system *given[16];
    static double states[16][dimension];
    saltus_message message = {.text = ""};
    saltus_flow *flow;
    saltus_event event;
    int lane = 0, between = 0;
    options.rtol = 1e-7;
    options.integrator = SALTUS_TAYLOR;
    for (int l = 0; l < 16; l++) {
        given[l] = systems[l] = random_system(rng, l, modes);
        random_state(rng, systems[l], states[l]);
    }
    const int width = saltus_flow_width(systems[0], SALTUS_TAYLOR, LLONG_MAX);
    check_ok(saltus_flow_new(given, width, &options, &flow, &message), &message);
    for (int l = 0; l < width; l++) {
        check_ok(saltus_flow_start(flow, l, (saltus_time){0, 0}, states[l], &message), &message);
        saltus_flow_aim(flow, l, far_target(l), SALTUS_WATCH_IMPACT);
    }
    for (int k = 0; k < questions; k++) {
        for (int turn = 0; turn < 12; turn++) {
            check_ok(saltus_flow_run(flow, &lane, &event, &message), &message);
            saltus_flow_aim(flow, lane, far_target(k + lane), SALTUS_WATCH_IMPACT);
        }
        for (int l = 0; l < width; l++) {
            double state[dimension], own[dimension];
            const saltus_flow_info info = saltus_flow_information(flow, l);
            const saltus_time now = saltus_flow_time(flow, l),
                              then = after_steps(systems[l], &options, states[l], info.steps, state);
            saltus_flow_state(flow, l, own);
            assert_true(now.cycle == then.cycle && now.phase == then.phase);
            assert_memory_equal(state, own, 2 * modes * sizeof *own);
            between += l != lane && info.steps > 0;
            if (gsl_rng_uniform(rng) < 0.3)
                saltus_flow_aim(flow, l, far_target(k + l + 1), SALTUS_WATCH_IMPACT);
        }
    }
    assert_true(width == 1 || between > (width - 1) * questions / 2);
    saltus_flow_free(flow);
    for (int l = 0; l < 16; l++)
        saltus_system_free(systems[l]);
    gsl_rng_free(rng);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_bits),
        cmocka_unit_test(same_bits_at_any_size),
        cmocka_unit_test(interleaved_flows),
        cmocka_unit_test(lanes_under_way),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
