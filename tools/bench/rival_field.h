/* The vector fields of the pipe and of the oscillator, the impact law, the rule that ends a chatter and the
 * variational equations, for all integrators that Saltus is compared with.
 *
 * Plain C that C++ compiles as well, so that every library calls a field that its compiler could inline. The
 * field is specialised for the five modes of the paper and for one mass. A state may be followed by tangent
 * vectors of its own length. model.md defines the symbols.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_RIVAL_FIELD_H
#define SALTUS_BENCH_RIVAL_FIELD_H

#include "clock.h"
#include "rivals.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum { modes_of_paper = 5, faces_max = 2 };

struct scene_field {
    int modes, columns;
    size_t count; /* entries of the state and of the tangent vectors behind it */
    double omega, d, r, length, normal_square, first_step;
    double tolerance; /* of a displacement at the stop */
    int faces;
    double side[faces_max];   /* +1: forbids g > d, -1: forbids g < -d */
    bool sticking;            /* which of the two vector fields is in force */
    int contact_face;         /* the holding face, or the one that the present flight left */
    double contact_time;      /* time when the flight left it */
    int contact_order;        /* order of the gap's zero at that time; 0 if the flight started elsewhere */
    long evaluations;         /* of the field; those with tangent vectors count once */
    double forced_time;       /* time of the next two values */
    double drive, drive_rate; /* flow velocity and its rate; oscillator: cos(omega tau) */
    bool oscillator;
    double stiffness[2][2], damper[2][2], force[2], load[2]; /* oscillator, over the masses */
    double alpha, kappa, root_beta, u0, sigma;
    double *wave_square, *damping;
    double *gyroscopic, *pulsating;     /* an entry for each pair of an odd and an even mode, row by row */
    double *gyroscopic_t, *pulsating_t; /* the same by columns */
    double *work;                       /* six rows of a mode each */
    double *normal, *impulse;           /* n, and M^-1 n: the direction in which the stop pushes */
    const double *start;
    double *vector;             /* the state and its tangent vectors */
    double *rate, *stage, *sum; /* of their length */
    double *before, *after;     /* the field on both sides of an impact */
};

static inline void set_pipe(struct scene_field *field, const saltus_spec *spec) {
    const double xi = spec->stop_count > 0 ? spec->stops[0].xi : 0;
    field->alpha = saltus_spec_get(spec, "alpha");
    field->kappa = saltus_spec_get(spec, "kappa");
    field->root_beta = sqrt(saltus_spec_get(spec, "beta"));
    field->u0 = saltus_spec_get(spec, "u0");
    field->sigma = saltus_spec_get(spec, "sigma");
    for (int i = 0; i < field->modes; i++) {
        const double wave = (i + 1) * pi;
        field->wave_square[i] = wave * wave;
        field->damping[i] = field->alpha * wave * wave * wave * wave;
        field->normal[i] = field->impulse[i] = sin(wave * xi);
    }
    const int last = field->modes - 1;
    field->first_step = 0.5 / hypot(field->damping[last], field->wave_square[last]);
    /* The pairs' entries are G_ij, antisymmetric, and B_ij / lambda_j^2, symmetric: each product serves both
     * modes. */
    const int odd = (field->modes + 1) / 2, even = field->modes / 2;
    for (int k = 0; k < odd; k++)
        for (int l = 0; l < even; l++) {
            const int i = 2 * k + 1, j = 2 * l + 2;
            const double difference = (double)i * i - (double)j * j;
            const double g = 4.0 * i * j / difference;
            const double b = -8.0 * i * j / (pi * pi * difference * difference);
            field->gyroscopic[k * even + l] = field->gyroscopic_t[l * odd + k] = g;
            field->pulsating[k * even + l] = field->pulsating_t[l * odd + k] = b;
        }
}

static inline void set_oscillator(struct scene_field *field, const saltus_spec *spec) {
    const bool two = field->modes == 2;
    const double k1 = saltus_spec_get(spec, "k"), k2 = two ? saltus_spec_get(spec, "k2") : 0;
    const double c1 = saltus_spec_get(spec, "c"), c2 = two ? saltus_spec_get(spec, "c2") : 0;
    const double k[2][2] = {{k1 + k2, -k2}, {-k2, k2}}, c[2][2] = {{c1 + c2, -c2}, {-c2, c2}};
    const double mass[2] = {saltus_spec_get(spec, "m"), saltus_spec_get(spec, "m2")};
    const double force[2] = {saltus_spec_get(spec, "F"), saltus_spec_get(spec, "F2")};
    const double load[2] = {saltus_spec_get(spec, "F0"), saltus_spec_get(spec, "F02")};
    double fastest = field->omega;
    field->oscillator = true;
    for (int i = 0; i < field->modes; i++) {
        for (int j = 0; j < 2; j++) {
            field->stiffness[i][j] = k[i][j] / mass[i];
            field->damper[i][j] = c[i][j] / mass[i];
        }
        field->force[i] = force[i] / mass[i];
        field->load[i] = load[i] / mass[i];
        field->normal[i] = spec->stops[0].weight[i];
        field->impulse[i] = spec->stops[0].weight[i] / mass[i];
        fastest = fmax(fastest, hypot(field->damper[i][i], sqrt(field->stiffness[i][i])));
    }
    field->first_step = 0.5 / fastest;
}

static inline double *take(double **pool, size_t count) {
    double *taken = *pool;
    *pool += count;
    return taken;
}

static inline double dot(int count, const double *left, const double *right) {
    double sum = 0;
    for (int i = 0; i < count; i++)
        sum += left[i] * right[i];
    return sum;
}

static inline struct scene_field *new_field(const saltus_spec *spec, const double *state0, bool tangents,
                                            double tolerance) {
    const saltus_stop *stop = spec->stop_count > 0 ? &spec->stops[0] : NULL;
    const size_t modes = (size_t)saltus_spec_get(spec, "N"), pairs = (modes + 1) / 2 * (modes / 2);
    const size_t columns = tangents ? 2 * modes : 0, count = 2 * modes * (1 + columns);
    struct scene_field *field = (struct scene_field *)calloc(
        1, sizeof *field + (14 * modes + 4 * pairs + 4 * count) * sizeof(double));
    if (!field)
        return NULL;
    field->modes = (int)modes;
    field->columns = (int)columns;
    field->count = count;
    field->omega = saltus_spec_get(spec, "omega");
    field->d = stop ? stop->d : 0;
    field->r = stop ? stop->r : 0;
    field->start = state0;
    /* A length scale of the motion: the clearance, if there is a stop. */
    field->length = fabs(field->d);
    for (int i = 0; i < field->modes && field->d == 0; i++)
        field->length = fmax(field->length, fabs(state0[i]));
    field->tolerance = tolerance + tolerance * field->length;
    double *pool = (double *)(field + 1);
    field->wave_square = take(&pool, modes);
    field->damping = take(&pool, modes);
    field->normal = take(&pool, modes);
    field->impulse = take(&pool, modes);
    field->work = take(&pool, 6 * modes);
    field->gyroscopic = take(&pool, pairs);
    field->pulsating = take(&pool, pairs);
    field->gyroscopic_t = take(&pool, pairs);
    field->pulsating_t = take(&pool, pairs);
    field->before = take(&pool, 2 * modes);
    field->after = take(&pool, 2 * modes);
    field->vector = take(&pool, field->count);
    field->rate = take(&pool, field->count);
    field->stage = take(&pool, field->count);
    field->sum = take(&pool, field->count);
    if (strcmp(saltus_model_name(spec->model), "oscillator") == 0)
        set_oscillator(field, spec);
    else
        set_pipe(field, spec);
    if (stop && stop->sides != SALTUS_LOWER)
        field->side[field->faces++] = 1;
    if (stop && stop->sides != SALTUS_UPPER)
        field->side[field->faces++] = -1;
    field->normal_square = dot(field->modes, field->normal, field->impulse);
    return field;
}

static inline void set_drive(struct scene_field *field, double tau) {
    if (tau == field->forced_time)
        return;
    field->forced_time = tau;
    const double phase = field->omega * tau;
    if (field->oscillator) {
        field->drive = cos(phase);
        return;
    }
    field->drive = field->u0;
    field->drive_rate = 0;
    if (field->sigma != 0) {
        field->drive += field->u0 * field->sigma * sin(phase);
        field->drive_rate = field->u0 * field->sigma * field->omega * cos(phase);
    }
}

/* Returns the factor of lambda_i^2 q_i that all modes share; curvature[i] becomes lambda_i^2 q_i. */
static inline double common_load(const struct scene_field *field, int modes, const double *q,
                                 const double *velocity, double *__restrict__ curvature) {
    const double surge = field->root_beta * field->drive_rate;
    double stretch = 0;
    for (int i = 0; i < modes; i++) {
        curvature[i] = field->wave_square[i] * q[i];
        stretch += curvature[i] * (0.5 * q[i] + field->alpha * velocity[i]);
    }
    return field->kappa * stretch - field->drive * field->drive - 0.5 * surge;
}

/* The field where all modes fit into registers, which a call would empty; `load` comes from common_load. */
__attribute__((always_inline)) static inline void couple_few(const struct scene_field *field, double load,
                                                             const double *velocity, const double *curvature,
                                                             double *__restrict__ acceleration) {
    enum { modes = modes_of_paper };
    const double coriolis = 2 * field->root_beta * field->drive, surge = field->root_beta * field->drive_rate;
    const double *__restrict__ gyroscopic = field->gyroscopic, *__restrict__ pulsating = field->pulsating;
    const double *__restrict__ wave_square = field->wave_square, *__restrict__ damping = field->damping;
    double flow_velocity[modes], flow_curvature[modes];
    for (int i = 0; i < modes; i++) {
        flow_velocity[i] = coriolis * velocity[i];
        flow_curvature[i] = surge * curvature[i];
        acceleration[i] = -damping[i] * velocity[i] - curvature[i] * (wave_square[i] + load);
    }
    int pair = 0;
    for (int i = 0; i < modes; i += 2) {
        double coupling = 0;
        for (int j = 1; j < modes; j += 2, pair++) {
            const double g = gyroscopic[pair], b = pulsating[pair];
            coupling += g * flow_velocity[j] + b * flow_curvature[j];
            acceleration[j] += g * flow_velocity[i] - b * flow_curvature[i];
        }
        acceleration[i] -= coupling;
    }
}

/* rows[l] of a matrix of `count` columns, each times its own factor, added up: the sums run over neighbours
 * in memory. */
static inline void add_rows(int rows, int count, const double *__restrict__ g, const double *__restrict__ b,
                            const double *__restrict__ by_g, const double *__restrict__ by_b, double sign,
                            double *__restrict__ sum) {
    for (int k = 0; k < rows; k++)
        for (int l = 0; l < count; l++)
            sum[l] += by_g[k] * g[k * count + l] + sign * by_b[k] * b[k * count + l];
}

/* The same for any number of modes, with odd and even modes separated. */
static inline void couple_many(const struct scene_field *field, double load, const double *velocity,
                               const double *curvature, double *__restrict__ acceleration) {
    const int modes = field->modes, odd = (modes + 1) / 2, even = modes / 2;
    const double coriolis = 2 * field->root_beta * field->drive, surge = field->root_beta * field->drive_rate;
    double *__restrict__ v = field->work, *__restrict__ c = v + modes, *__restrict__ sum = c + modes;
    for (int k = 0; k < odd; k++) {
        v[k] = coriolis * velocity[2 * k];
        c[k] = surge * curvature[2 * k];
    }
    for (int l = 0; l < even; l++) {
        v[odd + l] = coriolis * velocity[2 * l + 1];
        c[odd + l] = surge * curvature[2 * l + 1];
    }
    memset(sum, 0, (size_t)modes * sizeof *sum);
    add_rows(even, odd, field->gyroscopic_t, field->pulsating_t, v + odd, c + odd, 1, sum);
    add_rows(odd, even, field->gyroscopic, field->pulsating, v, c, -1, sum + odd);
    for (int i = 0; i < modes; i++)
        acceleration[i] = -field->damping[i] * velocity[i] - curvature[i] * (field->wave_square[i] + load);
    for (int k = 0; k < odd; k++)
        acceleration[2 * k] -= sum[k];
    for (int l = 0; l < even; l++)
        acceleration[2 * l + 1] += sum[odd + l];
}

static inline void couple(const struct scene_field *field, double load, const double *velocity,
                          const double *curvature, double *acceleration) {
    if (field->modes == modes_of_paper)
        couple_few(field, load, velocity, curvature, acceleration);
    else
        couple_many(field, load, velocity, curvature, acceleration);
}

/* The linear part of the oscillator, and its forces. */
static inline void pull_masses(const struct scene_field *field, double drive, double loaded, const double *q,
                               const double *velocity, double *acceleration) {
    acceleration[0] = drive * field->force[0] + loaded * field->load[0] - field->stiffness[0][0] * q[0] -
                      field->damper[0][0] * velocity[0];
    if (field->modes == 1)
        return;
    acceleration[0] -= field->stiffness[0][1] * q[1] + field->damper[0][1] * velocity[1];
    acceleration[1] = drive * field->force[1] + loaded * field->load[1] - field->stiffness[1][0] * q[0] -
                      field->stiffness[1][1] * q[1] - field->damper[1][0] * velocity[0] -
                      field->damper[1][1] * velocity[1];
}

static inline void free_acceleration(struct scene_field *field, double tau, const double *q,
                                     const double *velocity, double *acceleration) {
    field->evaluations++;
    set_drive(field, tau);
    if (field->oscillator) {
        pull_masses(field, field->drive, 1, q, velocity, acceleration);
    } else if (field->modes == modes_of_paper) {
        double curvature[modes_of_paper];
        const double load = common_load(field, modes_of_paper, q, velocity, curvature);
        couple_few(field, load, velocity, curvature, acceleration);
    } else {
        double *curvature = field->work + 3 * field->modes;
        const double load = common_load(field, field->modes, q, velocity, curvature);
        couple_many(field, load, velocity, curvature, acceleration);
    }
}

static inline double along_normal(const struct scene_field *field, const double *vector) {
    return field->modes == modes_of_paper ? dot(modes_of_paper, field->normal, vector)
                                          : dot(field->modes, field->normal, vector);
}

static inline void push(const struct scene_field *field, double factor, double *vector) {
    for (int i = 0; i < field->modes; i++)
        vector[i] += factor * field->impulse[i];
}

static inline void hold(const struct scene_field *field, double *acceleration) {
    push(field, -along_normal(field, acceleration) / field->normal_square, acceleration);
}

/* The derivative of the acceleration along one tangent vector; `curvature` and `load` are the state's. */
static inline void pipe_tangent(struct scene_field *field, double load, const double *curvature,
                                const double *state, const double *tangent, double *acceleration) {
    const int modes = field->modes;
    const double *q = state, *velocity = state + modes, *dq = tangent, *dv = tangent + modes;
    double *__restrict__ bent = field->work + 4 * modes;
    double stretch = 0;
    for (int i = 0; i < modes; i++) {
        bent[i] = field->wave_square[i] * dq[i];
        stretch += bent[i] * (q[i] + field->alpha * velocity[i]) + field->alpha * curvature[i] * dv[i];
    }
    couple(field, load, dv, bent, acceleration);
    for (int i = 0; i < modes; i++)
        acceleration[i] -= field->kappa * stretch * curvature[i];
}

/* The Jacobian of the field at `state` times each tangent vector. */
static inline void tangent_rates(struct scene_field *field, double tau, const double *state, int columns,
                                 const double *tangents, double *rates) {
    const int modes = field->modes;
    double *curvature = field->work + 5 * modes, load = 0;
    set_drive(field, tau);
    if (!field->oscillator)
        load = common_load(field, modes, state, state + modes, curvature);
    for (int c = 0; c < columns; c++, tangents += 2 * modes, rates += 2 * modes) {
        memcpy(rates, tangents + modes, (size_t)modes * sizeof *rates);
        if (field->oscillator)
            pull_masses(field, 0, 0, tangents, tangents + modes, rates + modes);
        else
            pipe_tangent(field, load, curvature, state, tangents, rates + modes);
        if (field->sticking)
            hold(field, rates + modes);
    }
}

static inline void state_rate(struct scene_field *field, double tau, const double *state, double *rate) {
    double *acceleration = rate + field->modes;
    if (field->modes == modes_of_paper)
        memcpy(rate, state + modes_of_paper, modes_of_paper * sizeof *rate);
    else
        memcpy(rate, state + field->modes, (size_t)field->modes * sizeof *rate);
    free_acceleration(field, tau, state, state + field->modes, acceleration);
    if (field->sticking)
        hold(field, acceleration);
}

/* The rate of the state and of the tangent vectors behind it. */
static inline void scene_rate(struct scene_field *field, double tau, const double *vector, double *rate) {
    state_rate(field, tau, vector, rate);
    if (field->columns > 0)
        tangent_rates(field, tau, vector, field->columns, vector + 2 * field->modes, rate + 2 * field->modes);
}

#endif
