/* The naive method: NOT FOR USE, see naive.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "naive.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* The Galerkin couplings of modes i and j, counted from one. */
static void couple(naive_pipe *pipe, int i, int j) {
    double difference = (double)i * i - (double)j * j;
    bool odd = (i + j) % 2 == 1;
    pipe->gyroscopic[i - 1][j - 1] = odd ? 4.0 * i * j / difference : 0;
    pipe->gradient[i - 1][j - 1] = odd ? -8.0 * i * j * j * j / (difference * difference) : 0;
    if (i == j)
        pipe->gradient[i - 1][j - 1] = -0.5 * i * i * pi * pi;
}

bool naive_pipe_from(const saltus_spec *spec, naive_pipe *pipe) {
    double modes = saltus_spec_get(spec, "N"), xi = spec->stop_count ? spec->stops[0].xi : 0.5;
    if (strcmp(saltus_model_name(spec->model), "pipe") != 0 || modes > naive_modes_max ||
        spec->stop_count > 1)
        return false;
    *pipe = (naive_pipe){.modes = (int)modes,
                         .alpha = saltus_spec_get(spec, "alpha"),
                         .root_beta = sqrt(saltus_spec_get(spec, "beta")),
                         .kappa = saltus_spec_get(spec, "kappa"),
                         .u0 = saltus_spec_get(spec, "u0"),
                         .sigma = saltus_spec_get(spec, "sigma"),
                         .omega = saltus_spec_get(spec, "omega"),
                         .upper = spec->stop_count && (spec->stops[0].sides & SALTUS_UPPER),
                         .lower = spec->stop_count && (spec->stops[0].sides & SALTUS_LOWER),
                         .d = spec->stops[0].d,
                         .r = spec->stops[0].r};
    for (int i = 1; i <= pipe->modes; i++) {
        pipe->lambda2[i - 1] = i * i * pi * pi;
        pipe->normal[i - 1] = sin(i * pi * xi);
        pipe->normal_square += pipe->normal[i - 1] * pipe->normal[i - 1];
        for (int j = 1; j <= pipe->modes; j++)
            couple(pipe, i, j);
    }
    return true;
}

/* Velocity of the fluid and its rate at a time. */
typedef struct pulsation {
    double u, u_rate;
} pulsation;

static pulsation pulsation_at(const naive_pipe *pipe, double time) {
    return (pulsation){.u = pipe->u0 * (1 + pipe->sigma * sin(pipe->omega * time)),
                       .u_rate = pipe->u0 * pipe->sigma * pipe->omega * cos(pipe->omega * time)};
}

/* The equations of motion: rate = (q', q''), all lanes at once. */
static void field(const naive_pipe *restrict pipe, pulsation flow, const naive_states *restrict states,
                  naive_states *restrict rate) {
    const int n = pipe->modes;
    const double u = flow.u, u_rate = flow.u_rate;
    const double(*q)[naive_lanes] = states->x, (*v)[naive_lanes] = states->x + n;
    double stretch[naive_lanes] = {0};
    for (int i = 0; i < n; i++)
        for (int l = 0; l < naive_lanes; l++)
            stretch[l] += pipe->lambda2[i] * q[i][l] * (0.5 * q[i][l] + pipe->alpha * v[i][l]);
    for (int i = 0; i < n; i++) {
        const double lambda2 = pipe->lambda2[i], damping = pipe->alpha * lambda2 * lambda2;
        const double stiffness = lambda2 * lambda2 - u * u * lambda2;
        double a[naive_lanes];
        for (int l = 0; l < naive_lanes; l++)
            a[l] = -damping * v[i][l] - (stiffness + pipe->kappa * lambda2 * stretch[l]) * q[i][l];
        for (int j = 0; j < n; j++) {
            const double g = 2 * pipe->root_beta * u * pipe->gyroscopic[i][j];
            const double b = pipe->root_beta * u_rate * pipe->gradient[i][j];
            for (int l = 0; l < naive_lanes; l++)
                a[l] -= g * v[j][l] + b * q[j][l];
        }
        memcpy(rate->x[i], v[i], sizeof rate->x[i]);
        memcpy(rate->x[n + i], a, sizeof a);
    }
}

/* from + factor * rate */
static void add(const naive_pipe *restrict pipe, const naive_states *restrict from, double factor,
                const naive_states *restrict rate, naive_states *restrict to) {
    for (int i = 0; i < 2 * pipe->modes; i++)
        for (int l = 0; l < naive_lanes; l++)
            to->x[i][l] = from->x[i][l] + factor * rate->x[i][l];
}

static void runge_kutta(const naive_pipe *restrict pipe, double time, double h,
                        naive_states *restrict states) {
    naive_states k1, k2, k3, k4, stage;
    const pulsation middle = pulsation_at(pipe, time + 0.5 * h);
    field(pipe, pulsation_at(pipe, time), states, &k1);
    add(pipe, states, 0.5 * h, &k1, &stage);
    field(pipe, middle, &stage, &k2);
    add(pipe, states, 0.5 * h, &k2, &stage);
    field(pipe, middle, &stage, &k3);
    add(pipe, states, h, &k3, &stage);
    field(pipe, pulsation_at(pipe, time + h), &stage, &k4);
    for (int i = 0; i < 2 * pipe->modes; i++)
        for (int l = 0; l < naive_lanes; l++)
            states->x[i][l] += h / 6 * (k1.x[i][l] + 2 * k2.x[i][l] + 2 * k3.x[i][l] + k4.x[i][l]);
}

double naive_displacement(const naive_pipe *pipe, const naive_states *states, int lane) {
    double sum = 0;
    for (int i = 0; i < pipe->modes; i++)
        sum += pipe->normal[i] * states->x[i][lane];
    return sum;
}

double naive_velocity(const naive_pipe *pipe, const naive_states *states, int lane) {
    double sum = 0;
    for (int i = 0; i < pipe->modes; i++)
        sum += pipe->normal[i] * states->x[pipe->modes + i][lane];
    return sum;
}

static void note_impact(naive_tally *tally, long long step, double speed, double depth) {
    tally->run = tally->reversals && step == tally->last + 1 ? tally->run + 1 : 1;
    tally->reversals++;
    tally->impacts += tally->run == 1;
    tally->contacts += tally->run == naive_run;
    tally->held_steps += tally->run == naive_run ? naive_run : tally->run > naive_run;
    tally->last = step;
    tally->largest_speed = fmax(tally->largest_speed, speed);
    tally->deepest = fmax(tally->deepest, depth);
}

/* The contact test at a step's end, for one side. */
static void test_contact(naive_runner *runner, int side) {
    const naive_pipe *pipe = &runner->pipe;
    double g[naive_lanes] = {0}, speed[naive_lanes] = {0};
    for (int i = 0; i < pipe->modes; i++)
        for (int l = 0; l < naive_lanes; l++) {
            g[l] += side * pipe->normal[i] * runner->states.x[i][l];
            speed[l] += side * pipe->normal[i] * runner->states.x[pipe->modes + i][l];
        }
    for (int l = 0; l < naive_lanes; l++) {
        if (!(g[l] >= pipe->d && speed[l] > 0))
            continue;
        double change = side * (1 + pipe->r) * speed[l] / pipe->normal_square;
        for (int i = 0; i < pipe->modes; i++)
            runner->states.x[pipe->modes + i][l] -= change * pipe->normal[i];
        note_impact(&runner->tally[l], runner->step, speed[l], g[l] - pipe->d);
    }
}

void naive_begin(naive_runner *runner, const naive_pipe *pipe, double h) {
    *runner = (naive_runner){.pipe = *pipe, .h = h};
}

void naive_put(naive_runner *runner, int lane, const double *state) {
    for (int i = 0; i < 2 * runner->pipe.modes; i++)
        runner->states.x[i][lane] = state[i];
}

void naive_run_until(naive_runner *runner, double time) {
    while ((double)(runner->step + 1) * runner->h <= time) {
        runge_kutta(&runner->pipe, (double)runner->step * runner->h, runner->h, &runner->states);
        runner->step++;
        if (runner->pipe.upper)
            test_contact(runner, 1);
        if (runner->pipe.lower)
            test_contact(runner, -1);
    }
}

naive_states naive_states_at(const naive_runner *runner, double time) {
    naive_states states = runner->states;
    double begin = (double)runner->step * runner->h;
    runge_kutta(&runner->pipe, begin, time - begin, &states);
    return states;
}
