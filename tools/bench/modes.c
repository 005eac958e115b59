/* Pipes with few to many modes, at equal error: one forcing period from a nearly settled state, with and
 * without a stop (omega = 42, d = 0.035). The reference is the mixed integrator at rtol 1e-14. Each method
 * runs at the largest power of ten as tolerance that brings the error of the state below the goal. A method
 * that needs more than a few seconds is dropped from there on.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "bench.h"

/* A pipe of so many modes, nearly settled: its problem is the next forcing period, without events or
 * multipliers. */
static void problem_pipe(int modes, bool stop, problem *p) {
    enum { settling = 24 };
    saltus_message message = {.text = ""};
    saltus_flow_options options = saltus_flow_defaults();
    saltus_spec *spec = &p->orbit.spec;
    saltus_system *system = NULL;
    saltus_flow *flow = NULL;
    saltus_event event;
    double *start = p->orbit.states[1];
    *p = (problem){.name = "pipe", .start = start};
    p->orbit.n = 2 * modes;
    p->orbit.periods = 1;
    *spec = saltus_spec_defaults(saltus_model_find("pipe"));
    spec->stop_count = stop;
    spec->stops[0] = saltus_stop_defaults();
    spec->stops[0].d = 0.035;
    spec->stops[0].sides = SALTUS_UPPER;
    must(saltus_spec_set(spec, "N", modes, &message), &message);
    must(saltus_spec_set(spec, "omega", 42, &message), &message);
    must(saltus_system_new(spec, &system, &message), &message);
    must(saltus_system_default_state(system, start, &message), &message);
    p->integrator = saltus_system_integrator(system);
    start[0] = 0.01;
    options.integrator = SALTUS_MIXED;
    options.rtol = 1e-12;
    options.atol = 1e-15;
    must(saltus_motion_settle(system, &options, settling, start, &message), &message);
    options.rtol = 1e-14;
    options.atol = 1e-17;
    must(saltus_flow_single(system, 0, &options, &flow, &message), &message);
    must(saltus_flow_start(flow, 0, (saltus_time){0, 0}, start, &message), &message);
    must(saltus_flow_advance(flow, (saltus_time){1, 0}, 0, &event, &message), &message);
    saltus_flow_state(flow, 0, p->orbit.states[0]);
    p->impacts = (int)saltus_flow_information(flow, 0).impacts;
    saltus_flow_free(flow);
    saltus_system_free(system);
}

/* Find the largest tolerance that reaches the goal, and print its time; false if the method is too slow. */
static bool print_method(const problem *p, const method *m, double goal) {
    static const effort once = {.patience = 0}, thorough = {5, 0.1, 4};
    measure found = {.state_error = INFINITY};
    bool quick = true;
    for (int digits = 5; digits <= 13 && quick && !(found.state_error <= goal); digits++) {
        found = measure_method(p, m, pow(10, -digits), derivative_none, &once);
        quick = found.seconds < thorough.patience;
        if (!found.done)
            found.state_error = INFINITY;
    }
    if (found.state_error <= goal) {
        found = measure_method(p, m, found.rtol, derivative_none, &thorough);
        printf(" %.4g (%.0e) |", 1e6 * found.seconds, found.state_error);
    } else
        printf(" – |");
    fflush(stdout);
    return quick;
}

void modes_print(const method *const *methods, int method_count) {
    static const char *const keys[] = {"mixed", "taylor", "radau", "gsl", "bdf"};
    static const int modes[] = {5, 8, 10, 12, 16, 20, 32, 64};
    static const double goals[] = {1e-7, 1e-10};
    static problem p;
    const method *list[methods_max];
    int count = 0;
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        for (int m = 0; m < method_count; m++)
            if (strcmp(methods[m]->key, keys[k]) == 0)
                list[count++] = methods[m];
    for (int table = 0; table < 4; table++) {
        const bool stop = table >= 2;
        bool given_up[methods_max] = {false};
        printf("\n| %s, error below %.0e |", stop ? "with a stop" : "no stop", goals[table % 2]);
        for (int m = 0; m < count; m++)
            printf(" %s |", list[m]->name);
        printf(" chosen | impacts |\n|%s", " --- | --- | --- |");
        for (int m = 0; m < count; m++)
            printf(" --- |");
        for (size_t k = 0; k < sizeof modes / sizeof modes[0]; k++) {
            problem_pipe(modes[k], stop, &p);
            printf("\n| N = %d |", modes[k]);
            for (int m = 0; m < count; m++)
                if (given_up[m])
                    printf(" – |");
                else
                    given_up[m] = !print_method(&p, list[m], goals[table % 2]);
            printf(" %s | %d |", p.integrator, p.impacts);
        }
        printf("\n");
    }
}
