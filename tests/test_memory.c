/* Memory: stepping never allocates, and every failing allocation is reported and leaks nothing.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "allocations.h"
#include "check.h"

static long allocations, failing = -1;

static bool refuse(void) {
    return ++allocations == failing;
}

/* Free flight, impacts, chatter, sticking and release, with tangent vectors, both integrators. */
static void stepping_never_allocates(void **unused) {
    (void)unused;
    for (int integrator = SALTUS_TAYLOR; integrator <= SALTUS_MIXED; integrator++) {
        saltus_spec spec = pipe_spec(5, 10);
        add_stop(&spec, 0.025, 0.9, SALTUS_UPPER);
        saltus_system *system = build(&spec);
        saltus_flow_options options = saltus_flow_defaults();
        saltus_message message = {.text = ""};
        double state[10];
        options.columns = 10;
        options.integrator = (saltus_integrator)integrator;
        check_ok(saltus_system_default_state(system, state, &message), &message);
        saltus_flow *flow = open_flow(system, &options, 0, state);
        long before = allocations;
        advance(flow, 8, 0);
        assert_int_equal(allocations, before);
        assert_true(saltus_flow_information(flow, 0).sticks > 0 &&
                    saltus_flow_information(flow, 0).releases > 0);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

static saltus_status classify_once(void) {
    saltus_spec spec = pipe_spec(2, 42);
    saltus_system *system = NULL;
    saltus_message message = {.text = ""};
    saltus_motion motion = {0};
    double state[4] = {0.001, 0, 0, 0};
    add_stop(&spec, 0.03, 0.9, SALTUS_UPPER);
    saltus_status status = saltus_system_new(&spec, &system, &message);
    if (status != SALTUS_OK)
        return status;
    saltus_classify_options options = saltus_classify_defaults();
    options.transient = 200;
    status = saltus_classify(system, state, &options, &motion, &message);
    saltus_motion_clear(&motion);
    saltus_system_free(system);
    return status;
}

/* The k-th allocation fails, for all k until none is left to fail. Leaks show under the address sanitizer. */
static void failing_allocations(void **unused) {
    (void)unused;
    long k = 1;
    int refused = 0;
    for (;; k++) {
        allocations = 0;
        failing = k;
        saltus_status status = classify_once();
        failing = -1;
        if (allocations < k) {
            assert_int_equal(status, SALTUS_OK);
            break;
        }
        assert_true(status == SALTUS_NO_MEMORY || status == SALTUS_OK);
        refused += status == SALTUS_NO_MEMORY;
    }
    assert_true(refused > 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stepping_never_allocates),
        cmocka_unit_test(failing_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
