/* The vector field of the pipe, its impact law and the rule that ends a chatter, for all integrators that
 * Saltus is compared with.
 *
 * Plain C that C++ compiles as well, so that every library calls a field that its compiler could inline. The
 * field is specialised for the five modes of the paper. model.md defines the symbols.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_RIVAL_FIELD_H
#define SALTUS_BENCH_RIVAL_FIELD_H

#include "rivals.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const double pi = 3.14159265358979323846;
/* Projecting onto the stop from an outgoing speed v costs an error of order v^2 / (a (1 - r)) in the state.
 */
static const double chatter_share_of_tolerance = 0.05;
/* Below this height in units of d * DBL_EPSILON, rounding of the gap decides when the next impact of a
 * chatter is. */
static const double least_height = 8;
/* Over this fraction of a step a fourth-order step errs far below the tolerance, and costs less than the
 * library's. */
static const double short_step = 1e-3;
/* A first step a little longer than the foreseen flight reaches the impact; a much longer one would be
 * wasted. */
static const double flight_allowance = 1.05;

enum { modes_of_paper = 5 };

struct pipe_field {
    int modes;
    double alpha, kappa, root_beta, u0, sigma, omega, d, r, normal_square;
    double tolerance;    /* of a displacement at the stop */
    bool sticking;       /* which of the two vector fields is in force */
    double contact_time; /* when the present flight left the stop */
    int contact_order;   /* order of the gap's zero at that time; 0 if the flight did not start on the stop */
    long evaluations;
    double forced_time, flow, flow_rate; /* the flow velocity and its rate at the time they were last used */
    double *wave_square, *damping, *normal;
    double *gyroscopic, *pulsating; /* one entry per pair of an odd and an even mode, row by row */
    double *curvature, *flow_velocity, *flow_curvature;
    double *rate, *stage, *sum;
};

/* The pairs' entries are G_ij, antisymmetric, and B_ij / lambda_j^2, symmetric: each product serves both
 * modes. */
static inline void set_couplings(struct pipe_field *field) {
    int pair = 0;
    for (int i = 1; i <= field->modes; i += 2)
        for (int j = 2; j <= field->modes; j += 2, pair++) {
            const double difference = (double)i * i - (double)j * j;
            field->gyroscopic[pair] = 4.0 * i * j / difference;
            field->pulsating[pair] = -8.0 * i * j / (pi * pi * difference * difference);
        }
}

static inline void set_modes(struct pipe_field *field, double xi) {
    field->normal_square = 0;
    for (int i = 0; i < field->modes; i++) {
        const double wave = (i + 1) * pi;
        field->wave_square[i] = wave * wave;
        field->damping[i] = field->alpha * wave * wave * wave * wave;
        field->normal[i] = sin(wave * xi);
        field->normal_square += field->normal[i] * field->normal[i];
    }
}

static inline double *take(double **pool, size_t count) {
    double *taken = *pool;
    *pool += count;
    return taken;
}

static inline void divide_pool(struct pipe_field *field, size_t modes, size_t pairs) {
    double *pool = (double *)(field + 1);
    field->wave_square = take(&pool, modes);
    field->damping = take(&pool, modes);
    field->normal = take(&pool, modes);
    field->curvature = take(&pool, modes);
    field->flow_velocity = take(&pool, modes);
    field->flow_curvature = take(&pool, modes);
    field->gyroscopic = take(&pool, pairs);
    field->pulsating = take(&pool, pairs);
    field->rate = take(&pool, 2 * modes);
    field->stage = take(&pool, 2 * modes);
    field->sum = take(&pool, 2 * modes);
}

static inline struct pipe_field *new_field(const rival_pipe *pipe, double rtol, double atol) {
    const size_t modes = (size_t)pipe->modes, pairs = (modes + 1) / 2 * (modes / 2);
    struct pipe_field *field =
        (struct pipe_field *)calloc(1, sizeof *field + (12 * modes + 2 * pairs) * sizeof(double));
    if (!field)
        return NULL;
    field->modes = pipe->modes;
    field->alpha = pipe->alpha;
    field->kappa = pipe->kappa;
    field->root_beta = sqrt(pipe->beta);
    field->u0 = pipe->u0;
    field->sigma = pipe->sigma;
    field->omega = pipe->omega;
    field->d = pipe->d;
    field->r = pipe->r;
    field->tolerance = atol + rtol * pipe->d;
    field->forced_time = NAN;
    divide_pool(field, modes, pairs);
    set_modes(field, pipe->xi);
    set_couplings(field);
    return field;
}

static inline double dot(int count, const double *left, const double *right) {
    double sum = 0;
    for (int i = 0; i < count; i++)
        sum += left[i] * right[i];
    return sum;
}

static inline double along_normal(const struct pipe_field *field, const double *vector) {
    return field->modes == modes_of_paper ? dot(modes_of_paper, field->normal, vector)
                                          : dot(field->modes, field->normal, vector);
}

static inline void add_normal(const struct pipe_field *field, double factor, double *vector) {
    for (int i = 0; i < field->modes; i++)
        vector[i] += factor * field->normal[i];
}

static inline void set_flow(struct pipe_field *field, double tau) {
    if (tau == field->forced_time)
        return;
    field->forced_time = tau;
    field->flow = field->u0;
    field->flow_rate = 0;
    if (field->sigma != 0) {
        const double phase = field->omega * tau;
        field->flow += field->u0 * field->sigma * sin(phase);
        field->flow_rate = field->u0 * field->sigma * field->omega * cos(phase);
    }
}

/* Returns the factor of lambda_i^2 q_i that all modes share, and scales what the couplings multiply. */
static inline double common_load(const struct pipe_field *field, int modes, const double *q,
                                 const double *velocity, double *__restrict__ curvature,
                                 double *__restrict__ flow_velocity, double *__restrict__ flow_curvature) {
    const double coriolis = 2 * field->root_beta * field->flow, surge = field->root_beta * field->flow_rate;
    const double *__restrict__ wave_square = field->wave_square;
    double stretch = 0;
    for (int i = 0; i < modes; i++) {
        curvature[i] = wave_square[i] * q[i];
        stretch += curvature[i] * (0.5 * q[i] + field->alpha * velocity[i]);
        flow_velocity[i] = coriolis * velocity[i];
        flow_curvature[i] = surge * curvature[i];
    }
    return field->kappa * stretch - field->flow * field->flow - 0.5 * surge;
}

/* The field for a number of modes that may be known when this is compiled; `load` comes from common_load. */
static inline void couple_modes(const struct pipe_field *field, int modes, double load,
                                const double *velocity, const double *__restrict__ curvature,
                                const double *__restrict__ flow_velocity,
                                const double *__restrict__ flow_curvature,
                                double *__restrict__ acceleration) {
    const double *__restrict__ gyroscopic = field->gyroscopic, *__restrict__ pulsating = field->pulsating;
    const double *__restrict__ wave_square = field->wave_square, *__restrict__ damping = field->damping;
    for (int i = 0; i < modes; i++)
        acceleration[i] = -damping[i] * velocity[i] - curvature[i] * (wave_square[i] + load);
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

static inline void free_acceleration(struct pipe_field *field, double tau, const double *q,
                                     const double *velocity, double *acceleration) {
    field->evaluations++;
    set_flow(field, tau);
    if (field->modes == modes_of_paper) {
        double curvature[modes_of_paper], flow_velocity[modes_of_paper], flow_curvature[modes_of_paper];
        const double load =
            common_load(field, modes_of_paper, q, velocity, curvature, flow_velocity, flow_curvature);
        couple_modes(field, modes_of_paper, load, velocity, curvature, flow_velocity, flow_curvature,
                     acceleration);
    } else {
        const double load = common_load(field, field->modes, q, velocity, field->curvature,
                                        field->flow_velocity, field->flow_curvature);
        couple_modes(field, field->modes, load, velocity, field->curvature, field->flow_velocity,
                     field->flow_curvature, acceleration);
    }
}

static inline void pipe_rate(struct pipe_field *field, double tau, const double *state, double *rate) {
    double *acceleration = rate + field->modes;
    if (field->modes == modes_of_paper)
        memcpy(rate, state + modes_of_paper, modes_of_paper * sizeof *rate);
    else
        memcpy(rate, state + field->modes, (size_t)field->modes * sizeof *rate);
    free_acceleration(field, tau, state, state + field->modes, acceleration);
    if (field->sticking)
        add_normal(field, -along_normal(field, acceleration) / field->normal_square, acceleration);
}

static inline double contact_gap(const struct pipe_field *field, const double *state) {
    return along_normal(field, state) - field->d;
}

static inline double normal_speed(const struct pipe_field *field, const double *state) {
    return along_normal(field, state + field->modes);
}

/* n.f of the free field; the stop can hold the pipe only while this is positive. */
static inline double pressing(struct pipe_field *field, double tau, const double *state) {
    free_acceleration(field, tau, state, state + field->modes, field->stage);
    return along_normal(field, field->stage);
}

static inline void place_on_stop(const struct pipe_field *field, double *state) {
    add_normal(field, -contact_gap(field, state) / field->normal_square, state);
}

static inline void remove_normal_speed(const struct pipe_field *field, double *state) {
    add_normal(field, -normal_speed(field, state) / field->normal_square, state + field->modes);
}

/* One classical fourth-order step, for spans far below those that the library steps over. */
static inline void flow_shortly(struct pipe_field *field, double tau, double span, double *state) {
    static const double node[4] = {0, 0.5, 0.5, 1}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    const int count = 2 * field->modes;
    double *rate = field->rate, *stage = field->stage, *sum = field->sum;
    memcpy(stage, state, (size_t)count * sizeof *stage);
    memcpy(sum, state, (size_t)count * sizeof *sum);
    for (int k = 0; k < 4; k++) {
        pipe_rate(field, tau + node[k] * span, stage, rate);
        for (int i = 0; i < count; i++) {
            sum[i] += weight[k] * span * rate[i];
            if (k < 3)
                stage[i] = state[i] + node[k + 1] * span * rate[i];
        }
    }
    memcpy(state, sum, (size_t)count * sizeof *state);
}

/* Span to the rising zero of a gap with the given derivatives; false, and the span to its top, where it has
 * none. */
static inline bool span_to_contact(double gap, double speed, double acceleration, double *span) {
    const double square = speed * speed - 2 * gap * acceleration;
    if (square < 0) {
        *span = -speed / acceleration;
        return false;
    }
    const double divisor = speed + sqrt(square);
    *span = gap == 0 ? 0 : -2 * gap / divisor;
    return divisor != 0;
}

/* Moves a state that is within a short step of its impact onto the stop, to rounding. */
static inline void polish_contact(struct pipe_field *field, double *tau, double *state) {
    for (int k = 0; k < 4; k++) {
        const double gap = contact_gap(field, state);
        if (fabs(gap) <= 2 * DBL_EPSILON * field->d)
            return;
        double span;
        const double speed = normal_speed(field, state);
        if (!span_to_contact(gap, speed, pressing(field, *tau, state), &span))
            return;
        flow_shortly(field, *tau, span, state);
        *tau += span;
    }
}

static inline void record(const struct pipe_field *field, rival_result *result, double tau, double speed,
                          rival_event_kind kind) {
    if (result->count < result->capacity) {
        rival_event *event = &result->events[result->count];
        event->time_over_T = tau * field->omega / (2 * pi);
        event->normal_velocity = speed;
        event->kind = kind;
    }
    result->count++;
}

/* Takes up the sticking field if the impacts that would follow end within the tolerance. Their remaining
 * duration goes into the recorded time only: the state that the projection gives at tau is as good there as
 * the chatter's own. */
static inline bool stick(struct pipe_field *field, double tau, double outgoing, double load, double *state,
                         rival_result *result) {
    const double settling = load * (1 - field->r);
    const double tolerable = chatter_share_of_tolerance * field->tolerance * settling;
    const double invisible = 2 * load * least_height * DBL_EPSILON * field->d;
    if (settling <= 0 || outgoing * outgoing >= (tolerable > invisible ? tolerable : invisible))
        return false;
    record(field, result, outgoing > 0 ? tau + 2 * outgoing / settling : tau, 0, RIVAL_STICK);
    place_on_stop(field, state);
    remove_normal_speed(field, state);
    field->sticking = true;
    return true;
}

/* Applies the impact law and returns when the next impact is due if n.q'' stays as it is, INFINITY if never.
 */
static inline double rebound(struct pipe_field *field, double tau, double *state, rival_result *result) {
    const double incoming = normal_speed(field, state), outgoing = field->r * incoming;
    record(field, result, tau, incoming, RIVAL_IMPACT);
    place_on_stop(field, state);
    remove_normal_speed(field, state);
    const double load = pressing(field, tau, state);
    if (stick(field, tau, outgoing, load, state, result))
        return INFINITY;
    add_normal(field, -outgoing / field->normal_square, state + field->modes);
    field->contact_time = tau;
    field->contact_order = outgoing > 0 ? 1 : 2;
    return load > 0 ? 2 * outgoing / load : INFINITY;
}

static inline void release(struct pipe_field *field, double tau, double *state, rival_result *result) {
    record(field, result, tau, 0, RIVAL_RELEASE);
    place_on_stop(field, state);
    remove_normal_speed(field, state);
    field->sticking = false;
    field->contact_time = tau;
    field->contact_order = 3;
}

static inline bool valid(const rival_pipe *pipe, const double *state0, int periods, double rtol, double atol,
                         const rival_result *result) {
    return pipe && state0 && result && result->state && pipe->modes >= 1 && pipe->beta >= 0 &&
           pipe->omega > 0 && pipe->xi > 0 && pipe->xi < 1 && pipe->d > 0 && pipe->r >= 0 && pipe->r <= 1 &&
           periods >= 0 && rtol >= 0 && atol > 0 && (result->events || result->capacity <= 0);
}

/* Builds the field and decides how the run starts: in free flight, or held by the stop. */
static inline int begin(const rival_pipe *pipe, const double *state0, int periods, double rtol, double atol,
                        rival_result *result, struct pipe_field **made) {
    if (!valid(pipe, state0, periods, rtol, atol, result))
        return RIVAL_BAD_ARGUMENT;
    struct pipe_field *field = new_field(pipe, rtol, atol);
    if (!field)
        return RIVAL_NO_MEMORY;
    const double gap = contact_gap(field, state0), speed = normal_speed(field, state0);
    if (gap > field->tolerance) {
        free(field);
        return RIVAL_BAD_ARGUMENT;
    }
    result->count = 0;
    result->steps = 0;
    result->field_evaluations = 0;
    result->cpu_seconds = 0;
    memcpy(result->state, state0, 2 * (size_t)pipe->modes * sizeof *state0);
    if (gap > -field->tolerance)
        stick(field, 0, fabs(speed), pressing(field, 0, state0), result->state, result);
    *made = field;
    return RIVAL_OK;
}

static inline double processor_time(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static inline double end_of_run(const struct pipe_field *field, int periods) {
    return periods * (2 * pi / field->omega);
}

/* A start for the library's step control; it takes over from the second step on. */
static inline double first_step(const struct pipe_field *field) {
    const int last = field->modes - 1;
    return 0.5 / hypot(field->damping[last], field->wave_square[last]);
}

#endif
