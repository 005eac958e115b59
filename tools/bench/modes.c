/* Pipes with few to many modes, at equal error: one forcing period from a nearly settled state, with and
 * without a stop (omega = 42, d = 0.035). The reference is the mixed integrator at rtol 1e-14. Each method
 * runs at the largest power of ten as tolerance that brings the error of the state below the goal. A method
 * that needs more than a few seconds is dropped from there on.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "report.h"

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

bool modes_print(const results *r) {
    static const char *const keys[] = {"mixed", "taylor", "radau", "gsl", "bdf"};
    static const int modes[] = {5, 8, 10, 12, 16, 20, 32, 64};
    static const double goals[] = {1e-7, 1e-10};
    const method *list[methods_max];
    int count = 0;
    problem *p = malloc(sizeof *p);
    bool done = p;
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        for (int m = 0; m < r->method_count; m++)
            if (strcmp(r->methods[m].key, keys[k]) == 0)
                list[count++] = &r->methods[m];
    for (int table = 0; table < 4 && done; table++) {
        const bool stop = table >= 2;
        bool given_up[methods_max] = {false};
        printf("\n| %s, error below %.0e |", stop ? "with a stop" : "no stop", goals[table % 2]);
        for (int m = 0; m < count; m++)
            printf(" %s |", list[m]->name);
        printf(" chosen | impacts |\n|%s", " --- | --- | --- |");
        for (int m = 0; m < count; m++)
            printf(" --- |");
        for (size_t k = 0; k < sizeof modes / sizeof modes[0] && done; k++) {
            done = problem_pipe(modes[k], stop, p);
            printf("\n| N = %d |", modes[k]);
            for (int m = 0; m < count && done; m++)
                if (given_up[m])
                    printf(" – |");
                else
                    given_up[m] = !print_method(p, list[m], goals[table % 2]);
            printf(" %s | %d |", done ? saltus_system_integrator(p->system) : "", p->impacts);
            problem_close(p);
        }
        printf("\n");
    }
    free(p);
    return done;
}
