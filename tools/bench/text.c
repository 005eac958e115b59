/* saltus_text_bench: cost of equations from text compared with the same equations in a hand-written kernel.
 *
 * The pipe with five modes and the oscillator with two masses, in both descriptions: alone, with a tangent
 * vector for every state, side by side in lanes, with and without a stop; text equations both interpreted and
 * compiled. Time is CPU time, the best of repeated runs, which restart before tangent vectors overflow or
 * underflow. The error is that of the state after a few periods against the hand-written kernel at the
 * tightest tolerance, relative to the typical size of each entry.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/saltus.h"

#include "clock.h"
#include "must.h"

#include "flow/flow.h"

#include <limits.h>
#include <math.h>
#include <string.h>

const char program_name[] = "saltus_text_bench";

enum { repeats = 15, lanes_max = 16, dimension_max = 16, periods_checked = 3, periods_timed = 30 };

typedef struct problem {
    const char *name;
    int starts; /* of one timed run */
    const char *built_in, *text;
} problem;

static const problem problems[] = {
    {"pipe", 10, "model: pipe\nN: 5\nstop: {xi: 0.5, d: 0.035, r: 0.9}\n",
     "model:\n"
     "  parameters: {N: {default: 5, min: 1, max: 16, integer: true}, alpha: 0.005, beta: 0.64, kappa: "
     "5000,\n"
     "    u0: 4.5, sigma: 0.2, omega: 42, place: 0.5}\n"
     "  families: {q: N}\n"
     "  let:\n"
     "    u: u0*(1 + sigma*sin(omega*t))\n"
     "    du: u0*sigma*omega*cos(omega*t)\n"
     "    l[i]: i*pi\n"
     "    S: sum(j, 1, N, l[j]^2*q[j]^2)/2\n"
     "    dS: sum(j, 1, N, l[j]^2*q[j]*q[j]')\n"
     "    pushed[i]: sum(j, 1, N, if(mod(i + j, 2) == 1, 4*i*j/(i^2 - j^2)*q[j]', 0))\n"
     "    bent[i]: sum(j, 1, N, if(mod(i + j, 2) == 1, -8*i*j^3/(i^2 - j^2)^2*q[j], 0)) - l[i]^2/2*q[i]\n"
     "  motion:\n"
     "    q[i]: -alpha*l[i]^4*q[i]' - 2*sqrt(beta)*u*pushed[i] - (l[i]^4 - u^2*l[i]^2)*q[i]\n"
     "      - sqrt(beta)*du*bent[i] - kappa*l[i]^2*q[i]*(S + alpha*dS)\n"
     "  forcing: omega\n"
     "stop: {coordinate: \"sum(i, 1, N, sin(i*pi*place)*q[i])\", d: 0.035, r: 0.9}\n"},
    {"oscillator", 60,
     "model: oscillator\nN: 2\nc: 0.1\nk2: 1\nc2: 0.1\nF: 1\nomega: 1.2\nkz: 0.5\ntz: 1\n"
     "stop: {weight: [1], d: 0.8, r: 0.9}\n",
     "model:\n"
     "  parameters: {c: 0.1, k: 1, k2: 1, c2: 0.1, F: 1, omega: 1.2, kz: 0.5, tz: 1}\n"
     "  motion:\n"
     "    x1: -c*x1' - k*x1 - c2*(x1' - x2') - k2*(x1 - x2) - z + F*cos(omega*t)\n"
     "    x2: -c2*(x2' - x1') - k2*(x2 - x1)\n"
     "  states: {z: kz*x1' - z/tz}\n"
     "  forcing: omega\n"
     "stop: {coordinate: x1, d: 0.8, r: 0.9}\n"},
};

static saltus_system *build(const char *text, const char *name, bool stops) {
    saltus_scene scene = {.title = ""};
    saltus_system *system = NULL;
    saltus_message message = {.text = ""};
    must(saltus_scene_parse(text, strlen(text), name, &scene, &message), &message);
    if (!stops)
        scene.spec.stop_count = 0;
    must(saltus_system_new(&scene.spec, &system, &message), &message);
    saltus_scene_clear(&scene);
    return system;
}

typedef enum { by_hand, interpreted, compiled, way_count } way;

static void follow(saltus_flow *flow, const saltus_system *system, int lanes, long long periods) {
    saltus_message message = {.text = ""};
    const bool pipe = saltus_system_dimension(system) >= 10;
    /* The same start in both descriptions; lanes differ slightly, so that their steps differ. */
    for (int l = 0; l < lanes; l++) {
        double start[dimension_max] = {(pipe ? 0.006 : 0.1) + 1e-4 * l, pipe ? 0.002 : -0.05};
        start[pipe ? 5 : 2] = pipe ? 0.12 : 0.3;
        must(saltus_flow_start(flow, l, (saltus_time){0, 0.2}, start, &message), &message);
        saltus_flow_aim(flow, l, (saltus_time){periods, 0}, 0);
    }
    for (int left = lanes; left > 0; left--) {
        saltus_event event;
        int lane;
        must(saltus_flow_run(flow, &lane, &event, &message), &message);
    }
}

static saltus_flow *open_flow(const saltus_system *system, way how, int lanes, int columns, double rtol) {
    saltus_flow_options options = saltus_flow_defaults();
    const saltus_system *all[lanes_max];
    saltus_message message = {.text = ""};
    saltus_flow *flow = NULL;
    options.rtol = rtol;
    options.integrator = SALTUS_TAYLOR;
    options.columns = columns;
    for (int l = 0; l < lanes; l++)
        all[l] = system;
    must(saltus_flow_new(all, lanes, &options, &flow, &message), &message);
    if (how == interpreted) {
        saltus_fixed_close(&flow->fixed);
        flow->fixed = (saltus_fixed){.compiled = NULL};
    }
    return flow;
}

/* The state of the first lane after the few periods used for the error. */
static void check(saltus_flow *flow, const saltus_system *system, int lanes, double *state) {
    follow(flow, system, lanes, periods_checked);
    saltus_flow_state(flow, 0, state);
    saltus_flow_free(flow);
}

/* A line for each number of lanes and tangent vectors: nanoseconds per period and lane for each description,
 * and errors. The descriptions take turns, so that other load on the machine affects all. Without a compiler,
 * times of compiled equations are omitted. */
static void compare(const problem *p, bool stops) {
    static const struct timespec tenth = {.tv_nsec = 100000000};
    saltus_system *own = build(p->built_in, p->name, stops), *text = build(p->text, p->name, stops);
    const int all = saltus_flow_width(own, SALTUS_AUTOMATIC, LLONG_MAX), n = saltus_system_dimension(own);
    const int lanes[] = {1, 1, all}, columns[] = {0, n, 0};
    const double *scale = saltus_system_scale(own);
    double exact[dimension_max], state[dimension_max], error[way_count], cost[way_count];
    check(open_flow(own, by_hand, 1, 0, 1e-15), own, 1, exact);
    for (int k = 0; k < 3; k++) {
        saltus_flow *flow[way_count];
        bool ready[way_count];
        for (way how = by_hand; how < way_count; how++) {
            flow[how] = open_flow(how ? text : own, how, lanes[k], columns[k], 1e-10);
            for (int wait = 0; how == compiled && wait < 300 && !saltus_fixed_ask(&flow[how]->fixed, text);
                 wait++)
                nanosleep(&tenth, NULL);
            ready[how] = how != compiled || flow[how]->fixed.function != NULL;
            cost[how] = INFINITY;
        }
        for (int repeat = 0; repeat < repeats; repeat++)
            for (way how = by_hand; how < way_count; how++) {
                const double begin = processor_seconds();
                for (int s = 0; s < p->starts && ready[how]; s++)
                    follow(flow[how], how ? text : own, lanes[k], periods_timed);
                cost[how] = ready[how] ? fmin(cost[how], processor_seconds() - begin) : INFINITY;
            }
        for (way how = by_hand; how < way_count; how++) {
            cost[how] *= 1e9 / ((double)periods_timed * p->starts * lanes[k]);
            check(flow[how], how ? text : own, lanes[k], state);
            error[how] = 0;
            for (int i = 0; i < n; i++)
                error[how] = fmax(error[how], fabs(state[i] - exact[i]) / scale[i]);
        }
        printf("| %s%s | %d | %d | %.0f | %.0f | %.0f | %.2f | %.2f | %.1e | %.1e |\n", p->name,
               stops ? ", stop" : "", lanes[k], columns[k], cost[by_hand], cost[interpreted], cost[compiled],
               cost[interpreted] / cost[by_hand], cost[compiled] / cost[by_hand], error[by_hand],
               error[compiled]);
        fflush(stdout);
    }
    saltus_system_free(own);
    saltus_system_free(text);
}

int main(void) {
    printf("| system | lanes | tangent vectors | ns a period and lane, hand-made | text, interpreted | "
           "compiled | ratio, interpreted | compiled | error, hand-made | text |\n"
           "|---|---|---|---|---|---|---|---|---|---|\n");
    for (size_t k = 0; k < sizeof problems / sizeof problems[0]; k++)
        for (int stops = 0; stops < 2; stops++)
            compare(&problems[k], stops);
    return 0;
}
