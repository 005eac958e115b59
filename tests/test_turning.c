/* Turning points are the zeros of the observed velocity: each is reported once, none is missed, maxima and
 * minima alternate.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes.h"

enum { samples = 12 };

static double sign_of(double value, double nothing) {
    return value > nothing ? 1 : value < -nothing ? -1 : 0;
}

/* The direction of the observed point inside the last step, which must be one; `way`: what is known of it, 0:
 * nothing. */
static double one_way(const saltus_flow *flow, const saltus_system *system, double way, double nothing) {
    double state[scene_dimension_max], step = saltus_flow_step_length(flow, 0);
    for (int k = 1; k < samples; k++) {
        saltus_flow_dense(flow, 0, step * k / samples, state);
        double now = sign_of(observed(system, state + saltus_system_dof(system)), nothing);
        if (way != 0 && now == -way)
            fail_msg("a turning point was passed over near %.15g periods",
                     saltus_time_periods(saltus_flow_time(flow, 0)));
        way = now != 0 ? now : way;
    }
    return way;
}

typedef struct turning_tally {
    int maxima, minima, contacts;
} turning_tally;

static void check_turning(saltus_flow *flow, const saltus_system *system, const saltus_event *event) {
    const int n = saltus_system_dof(system);
    double state[scene_dimension_max], rate[scene_dimension_max];
    saltus_flow_state(flow, 0, state);
    saltus_flow_field(flow, 0, rate);
    double speed = observed(system, saltus_system_scale(system) + n);
    assert_int_equal(event->face, -1);
    check_near(event->displacement, observed(system, state), 1e-15);
    check_near(event->velocity_before, observed(system, rate + n), 1e-9 * (1 + fabs(event->velocity_before)));
    check_near(observed(system, state + n), 0, 1e-11 * (fabs(speed) + 1));
}

static turning_tally follow(const scene *s, saltus_integrator integrator, double periods) {
    const unsigned watch = SALTUS_WATCH_STEP | SALTUS_WATCH_TURNING | SALTUS_WATCH_CONTACT;
    saltus_system *system = build(&s->spec);
    saltus_flow_options options = saltus_flow_defaults();
    options.integrator = integrator;
    saltus_flow *flow = open_flow(system, &options, s->phase, s->state);
    const int n = saltus_system_dof(system);
    const double nothing = 1e-9 * saltus_system_scale(system)[n];
    turning_tally tally = {0, 0, 0};
    double state[scene_dimension_max], way = sign_of(observed(system, s->state + n), nothing), last = -1;
    long long steps = 0;
    for (;;) {
        saltus_event event = advance(flow, s->phase + periods, watch);
        if (saltus_flow_information(flow, 0).steps != steps)
            way = one_way(flow, system, way, nothing);
        steps = saltus_flow_information(flow, 0).steps;
        if (event.kind == SALTUS_REACHED)
            break;
        saltus_flow_state(flow, 0, state);
        double now = sign_of(observed(system, state + n), nothing);
        if (event.kind == SALTUS_TURNING) {
            double time = saltus_time_periods(event.time);
            check_turning(flow, system, &event);
            assert_true(time > last);
            /* It moved one way, and the acceleration is opposite. */
            assert_true(way == 0 || event.velocity_before * way < 0);
            ++*(event.velocity_before < 0 ? &tally.maxima : &tally.minima);
            way = event.velocity_before < 0 ? -1 : 1;
            last = time;
        } else if (event.kind != SALTUS_STEP) {
            tally.contacts++;
            way = now;
        } else if (now != 0)
            way = now;
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
    return tally;
}

static void turnings_are_distinct_and_alternate(void **unused) {
    (void)unused;
    for (int name = 0; name < scenes; name++)
        for (int integrator = SALTUS_TAYLOR; integrator <= SALTUS_MIXED; integrator++) {
            scene s = scene_of((scene_name)name);
            turning_tally tally = follow(&s, (saltus_integrator)integrator, 12);
            static const char *const others[] = {"q1", "q2", "stop2", "0.3"};
            for (int k = 0; k < 4; k++) {
                saltus_system *system = NULL;
                scene other = s;
                strcpy(other.spec.observe, others[k]);
                if (saltus_system_new(&other.spec, &system, NULL) == SALTUS_OK)
                    follow(&other, (saltus_integrator)integrator, 5);
                saltus_system_free(system);
            }
            assert_true(tally.maxima + tally.minima + tally.contacts > 7 || name == scene_steady_pipe);
            if (s.spec.stop_count == 0)
                assert_true(abs(tally.maxima - tally.minima) <= 1);
        }
}

/* x = a cos t: a turning point every half period, at a and -a in turn. */
static void free_oscillation_turns_twice_a_period(void **unused) {
    (void)unused;
    const double a = 0.7;
    saltus_spec spec = oscillator_spec(0, 1, 0, 1);
    saltus_system *system = build(&spec);
    saltus_flow_options options = saltus_flow_defaults();
    double state[2] = {a, 0};
    saltus_flow *flow = open_flow(system, &options, 0, state);
    for (int k = 1; k <= 20; k++) {
        saltus_event event = advance(flow, 100, SALTUS_WATCH_TURNING);
        assert_int_equal(event.kind, SALTUS_TURNING);
        check_near(saltus_time_periods(event.time), 0.5 * k, 1e-13 * k);
        check_near(event.displacement, k % 2 ? -a : a, 1e-12);
        check_near(event.velocity_before, k % 2 ? a : -a, 1e-12);
        check_near(event.velocity_after, 0, 1e-12);
    }
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Advancing in small parts: no turning point is reported twice or lost. */
static void bits_of_an_advance_tell_the_same_turnings(void **unused) {
    (void)unused;
    for (int name = 0; name < scenes; name++) {
        scene s = scene_of((scene_name)name);
        saltus_system *system = build(&s.spec);
        saltus_flow_options options = saltus_flow_defaults();
        double whole[200];
        int count = 0, seen = 0;
        saltus_event event;
        saltus_flow *flow = open_flow(system, &options, s.phase, s.state);
        while ((event = advance(flow, s.phase + 4, SALTUS_WATCH_TURNING)).kind == SALTUS_TURNING)
            whole[count++] = saltus_time_periods(event.time);
        saltus_flow_free(flow);
        flow = open_flow(system, &options, s.phase, s.state);
        for (int k = 1; k <= 300; k++)
            while (
                (event = advance(flow, k < 300 ? s.phase + 4 * k / 300.0 : s.phase + 4, SALTUS_WATCH_TURNING))
                    .kind == SALTUS_TURNING) {
                assert_true(seen < count);
                check_near(saltus_time_periods(event.time), whole[seen], 1e-8);
                seen++;
            }
        assert_int_equal(seen, count);
        saltus_flow_free(flow);
        saltus_system_free(system);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(turnings_are_distinct_and_alternate),
        cmocka_unit_test(free_oscillation_turns_twice_a_period),
        cmocka_unit_test(bits_of_an_advance_tell_the_same_turnings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
