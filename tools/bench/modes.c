/* saltus_modes_bench: integrators on pipes with few to many modes, at equal error.
 *
 * One forcing period from a nearly settled state, with and without a stop (omega = 42, d = 0.035). The
 * reference is the mixed integrator at rtol 1e-14; the error is that of the final state, relative to its
 * largest displacement and velocity. Each method runs at the largest power of ten as tolerance that brings
 * the error below the goal. Time is CPU time, the smallest of repeated batches. A method that needs more than
 * a few seconds is dropped from there on.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "clock.h"
#include "rival_scene.h"

#include <math.h>
#include <stdio.h>
enum { state_max = SALTUS_SCENE_STATE_MAX, settling = 24, methods = 5 };

/* A scene with its start and its end. */
typedef struct problem {
    int modes;
    saltus_system *system;
    rival_scene scene;
    double start[state_max], end[state_max];
    long impacts;
} problem;

typedef struct method {
    const char *name, *rival; /* key of a rival, or NULL */
    saltus_integrator own;
    bool given_up; /* it became too slow */
} method;

/* One period at one tolerance. */
typedef struct outcome {
    bool done;
    double error, seconds;
    long impacts;
} outcome;

static bool run_own(const problem *p, saltus_integrator integrator, double rtol, int periods, int batch,
                    const double *start, double *end, outcome *out) {
    saltus_flow_options options = saltus_flow_defaults();
    saltus_flow *flow = NULL;
    saltus_event event;
    options.rtol = rtol;
    options.atol = 1e-3 * rtol;
    options.integrator = integrator;
    bool done = saltus_flow_single(p->system, 0, &options, &flow, NULL) == SALTUS_OK;
    const double before = processor_seconds();
    for (int b = 0; b < batch && done; b++)
        done = saltus_flow_start(flow, 0, (saltus_time){0, 0}, start, NULL) == SALTUS_OK &&
               saltus_flow_advance(flow, (saltus_time){periods, 0}, 0, &event, NULL) == SALTUS_OK;
    out->seconds = (processor_seconds() - before) / batch;
    if (done) {
        saltus_flow_state(flow, 0, end);
        out->impacts = (long)saltus_flow_information(flow, 0).impacts;
    }
    saltus_flow_free(flow);
    return done;
}

static outcome run(const problem *p, const method *m, double rtol, int batch) {
    const int n = p->modes;
    double end[state_max];
    outcome out = {0};
    rival_result result = {.state = end, .repeats = batch};
    for (int k = 0; k < saltus_rival_count && m->rival; k++)
        if (strcmp(saltus_rivals[k].key, m->rival) == 0)
            out.done = saltus_rivals[k].run(&p->scene, p->start, 1, rtol, 1e-3 * rtol, &result) == RIVAL_OK;
    if (m->rival)
        out.seconds = out.done ? result.cpu_seconds : 0;
    else
        out.done = run_own(p, m->own, rtol, 1, batch, p->start, end, &out);
    out.error = out.done ? 0 : INFINITY;
    for (int part = 0; part < 2 && out.done; part++) {
        double size = 0, off = 0;
        for (int i = part * n; i < (part + 1) * n; i++) {
            size = fmax(size, fabs(p->end[i]));
            off = fmax(off, fabs(end[i] - p->end[i]));
        }
        out.error = fmax(out.error, off / size);
    }
    return out;
}

static bool open_problem(problem *p, int modes, bool stop) {
    saltus_message message = {.text = ""};
    saltus_spec spec = saltus_spec_defaults(saltus_model_find("pipe"));
    double begin[state_max];
    outcome out;
    *p = (problem){.modes = modes};
    saltus_status status = saltus_spec_set(&spec, "N", modes, &message);
    if (status == SALTUS_OK)
        status = saltus_spec_set(&spec, "omega", 42, &message);
    spec.stop_count = stop;
    spec.stops[0] = saltus_stop_defaults();
    spec.stops[0].d = 0.035;
    spec.stops[0].sides = SALTUS_UPPER;
    if (status == SALTUS_OK)
        status = saltus_system_new(&spec, &p->system, &message);
    if (status == SALTUS_OK)
        status = saltus_system_default_state(p->system, begin, &message);
    if (status != SALTUS_OK) {
        fprintf(stderr, "saltus_modes_bench: %s\n", message.text);
        return false;
    }
    begin[0] = 0.01;
    p->scene = rival_scene_of(&spec, NULL);
    const bool done = run_own(p, SALTUS_MIXED, 1e-12, settling, 1, begin, p->start, &out) &&
                      run_own(p, SALTUS_MIXED, 1e-14, 1, 1, p->start, p->end, &out);
    p->impacts = out.impacts;
    return done;
}

/* Find the largest tolerance that reaches the goal, and print its time. */
static void print_method(const problem *p, method *m, double goal) {
    static const double patience = 4, batch_seconds = 0.02;
    outcome out = {.error = INFINITY};
    for (int digits = 5; digits <= 13 && !m->given_up && !(out.error <= goal); digits++) {
        out = run(p, m, pow(10, -digits), 1);
        m->given_up |= out.seconds > patience;
        if (!(out.error <= goal))
            continue;
        const int batch = out.seconds < batch_seconds ? (int)(batch_seconds / out.seconds) + 1 : 1;
        for (int k = 0; k < 5; k++)
            out.seconds = fmin(out.seconds, run(p, m, pow(10, -digits), batch).seconds);
    }
    if (out.error <= goal)
        printf(" %.4g (%.0e) |", 1e6 * out.seconds, out.error);
    else
        printf(" – |");
    fflush(stdout);
}

int main(void) {
    static const int modes[] = {5, 8, 10, 12, 16, 20, 32, 64};
    static const double goals[] = {1e-7, 1e-10};
    bool done = true;
    for (int stop = 0; stop < 2; stop++)
        for (int g = 0; g < 2; g++) {
            method list[methods] = {{"mixed", NULL, SALTUS_MIXED, false},
                                    {"Taylor", NULL, SALTUS_TAYLOR, false},
                                    {"Radau", NULL, SALTUS_RADAU, false},
                                    {"GSL rk8pd", "gsl", SALTUS_AUTOMATIC, false},
                                    {"CVODE BDF", "bdf", SALTUS_AUTOMATIC, false}};
            printf("\n| %s, error below %.0e |", stop ? "with a stop" : "no stop", goals[g]);
            for (int m = 0; m < methods; m++)
                printf(" %s |", list[m].name);
            printf(" chosen | impacts |\n|%s\n", " --- | --- | --- | --- | --- | --- | --- | --- |");
            for (size_t k = 0; k < sizeof modes / sizeof modes[0] && done; k++) {
                problem p;
                done = open_problem(&p, modes[k], stop);
                printf("| N = %d |", modes[k]);
                for (int m = 0; m < methods && done; m++)
                    print_method(&p, &list[m], goals[g]);
                printf(" %s | %ld |\n", done ? saltus_system_integrator(p.system) : "", p.impacts);
                saltus_system_free(p.system);
            }
        }
    return !done;
}
