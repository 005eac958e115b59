#define _POSIX_C_SOURCE 200809L

#include "rivals.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#ifdef SALTUS_WITH_SUNDIALS
#include <arkode/arkode_arkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#endif

static const double pi = 3.14159265358979323846;
/* Projecting onto the stop from an outgoing speed v costs an error of order v^2 / (a (1 - r)) in the state.
 * SPDX-License-Identifier: GPL-3.0-or-later */
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

struct pipe_field {
    int modes;
    double alpha, kappa, root_beta, u0, sigma, omega, d, r, normal_square;
    double tolerance;    /* of a displacement at the stop */
    bool sticking;       /* which of the two vector fields is in force */
    double contact_time; /* when the present flight left the stop */
    int contact_order;   /* order of the gap's zero at that time; 0 if the flight did not start on the stop */
    long evaluations;
    double *wave_square, *damping, *normal;
    double *gyroscopic, *pulsating; /* one entry per pair of an odd and an even mode, row by row */
    double *curvature, *flow_velocity, *flow_curvature;
    double *rate, *stage, *sum;
    double pool[];
};

/* The pairs' entries are G_ij, antisymmetric, and B_ij / lambda_j^2, symmetric: each product serves both
 * modes. */
static void set_couplings(struct pipe_field *field) {
    int pair = 0;
    for (int i = 1; i <= field->modes; i += 2)
        for (int j = 2; j <= field->modes; j += 2, pair++) {
            const double difference = (double)i * i - (double)j * j;
            field->gyroscopic[pair] = 4.0 * i * j / difference;
            field->pulsating[pair] = -8.0 * i * j / (pi * pi * difference * difference);
        }
}

static void set_modes(struct pipe_field *field, double xi) {
    field->normal_square = 0;
    for (int i = 0; i < field->modes; i++) {
        const double wave = (i + 1) * pi;
        field->wave_square[i] = wave * wave;
        field->damping[i] = field->alpha * wave * wave * wave * wave;
        field->normal[i] = sin(wave * xi);
        field->normal_square += field->normal[i] * field->normal[i];
    }
}

static double *take(double **pool, size_t count) {
    double *taken = *pool;
    *pool += count;
    return taken;
}

static void divide_pool(struct pipe_field *field, size_t modes, size_t pairs) {
    double *pool = field->pool;
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

static struct pipe_field *new_field(const rival_pipe *pipe, double rtol, double atol) {
    const size_t modes = (size_t)pipe->modes, pairs = (modes + 1) / 2 * (modes / 2);
    struct pipe_field *field = malloc(sizeof *field + (12 * modes + 2 * pairs) * sizeof(double));
    if (!field)
        return NULL;
    *field = (struct pipe_field){.modes = pipe->modes,
                                 .alpha = pipe->alpha,
                                 .kappa = pipe->kappa,
                                 .root_beta = sqrt(pipe->beta),
                                 .u0 = pipe->u0,
                                 .sigma = pipe->sigma,
                                 .omega = pipe->omega,
                                 .d = pipe->d,
                                 .r = pipe->r,
                                 .tolerance = atol + rtol * pipe->d};
    divide_pool(field, modes, pairs);
    set_modes(field, pipe->xi);
    set_couplings(field);
    return field;
}

static double dot(int count, const double *left, const double *right) {
    double sum = 0;
    for (int i = 0; i < count; i++)
        sum += left[i] * right[i];
    return sum;
}

static void add_normal(const struct pipe_field *field, double factor, double *vector) {
    for (int i = 0; i < field->modes; i++)
        vector[i] += factor * field->normal[i];
}

/* Returns the factor of lambda_i^2 q_i that all modes share, and scales what the couplings multiply. */
static double common_load(struct pipe_field *field, double tau, const double *q, const double *velocity) {
    double flow = field->u0, flow_rate = 0;
    if (field->sigma != 0) {
        const double phase = field->omega * tau;
        flow += field->u0 * field->sigma * sin(phase);
        flow_rate = field->u0 * field->sigma * field->omega * cos(phase);
    }
    const double coriolis = 2 * field->root_beta * flow, surge = field->root_beta * flow_rate;
    double stretch = 0;
    for (int i = 0; i < field->modes; i++) {
        const double curvature = field->wave_square[i] * q[i];
        stretch += curvature * (0.5 * q[i] + field->alpha * velocity[i]);
        field->curvature[i] = curvature;
        field->flow_velocity[i] = coriolis * velocity[i];
        field->flow_curvature[i] = surge * curvature;
    }
    return field->kappa * stretch - flow * flow - 0.5 * surge;
}

static void free_acceleration(struct pipe_field *field, double tau, const double *q, const double *velocity,
                              double *acceleration) {
    const int modes = field->modes;
    const double load = common_load(field, tau, q, velocity);
    const double *restrict gyroscopic = field->gyroscopic, *restrict pulsating = field->pulsating;
    const double *restrict flow_velocity = field->flow_velocity, *restrict flow_curvature =
                                                                     field->flow_curvature;
    for (int i = 0; i < modes; i++)
        acceleration[i] =
            -field->damping[i] * velocity[i] - field->curvature[i] * (field->wave_square[i] + load);
    for (int i = 0; i < modes; i += 2) {
        const double odd_velocity = flow_velocity[i], odd_curvature = flow_curvature[i];
        double coupling = 0;
        for (int j = 1; j < modes; j += 2) {
            const double g = *gyroscopic++, b = *pulsating++;
            coupling += g * flow_velocity[j] + b * flow_curvature[j];
            acceleration[j] += g * odd_velocity - b * odd_curvature;
        }
        acceleration[i] -= coupling;
    }
    field->evaluations++;
}

static void pipe_rate(struct pipe_field *field, double tau, const double *state, double *rate) {
    double *acceleration = rate + field->modes;
    memcpy(rate, state + field->modes, (size_t)field->modes * sizeof *rate);
    free_acceleration(field, tau, state, state + field->modes, acceleration);
    if (field->sticking)
        add_normal(field, -dot(field->modes, field->normal, acceleration) / field->normal_square,
                   acceleration);
}

static double contact_gap(const struct pipe_field *field, const double *state) {
    return dot(field->modes, field->normal, state) - field->d;
}

static double normal_speed(const struct pipe_field *field, const double *state) {
    return dot(field->modes, field->normal, state + field->modes);
}

/* n.f of the free field; the stop can hold the pipe only while this is positive. */
static double pressing(struct pipe_field *field, double tau, const double *state) {
    free_acceleration(field, tau, state, state + field->modes, field->stage);
    return dot(field->modes, field->normal, field->stage);
}

static void place_on_stop(const struct pipe_field *field, double *state) {
    add_normal(field, -contact_gap(field, state) / field->normal_square, state);
}

static void remove_normal_speed(const struct pipe_field *field, double *state) {
    add_normal(field, -normal_speed(field, state) / field->normal_square, state + field->modes);
}

/* One classical fourth-order step, for spans far below those that the library steps over. */
static void flow_shortly(struct pipe_field *field, double tau, double span, double *state) {
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
static bool span_to_contact(double gap, double speed, double acceleration, double *span) {
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
static void polish_contact(struct pipe_field *field, double *tau, double *state) {
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

static void record(const struct pipe_field *field, rival_result *result, double tau, double speed,
                   rival_event_kind kind) {
    if (result->count < result->capacity)
        result->events[result->count] = (rival_event){tau * field->omega / (2 * pi), speed, kind};
    result->count++;
}

/* Takes up the sticking field if the impacts that would follow end within the tolerance. Their remaining
 * duration goes into the recorded time only: the state that the projection gives at tau is as good there as
 * the chatter's own. */
static bool stick(struct pipe_field *field, double tau, double outgoing, double load, double *state,
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
static double rebound(struct pipe_field *field, double tau, double *state, rival_result *result) {
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

static void release(struct pipe_field *field, double tau, double *state, rival_result *result) {
    record(field, result, tau, 0, RIVAL_RELEASE);
    place_on_stop(field, state);
    remove_normal_speed(field, state);
    field->sticking = false;
    field->contact_time = tau;
    field->contact_order = 3;
}

static bool valid(const rival_pipe *pipe, const double *state0, int periods, double rtol, double atol,
                  const rival_result *result) {
    return pipe && state0 && result && result->state && pipe->modes >= 1 && pipe->beta >= 0 &&
           pipe->omega > 0 && pipe->xi > 0 && pipe->xi < 1 && pipe->d > 0 && pipe->r >= 0 && pipe->r <= 1 &&
           periods >= 0 && rtol >= 0 && atol > 0 && (result->events || result->capacity <= 0);
}

/* Builds the field and decides how the run starts: in free flight, or held by the stop. */
static int begin(const rival_pipe *pipe, const double *state0, int periods, double rtol, double atol,
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
    result->field_evaluations = 0;
    result->cpu_seconds = 0;
    memcpy(result->state, state0, 2 * (size_t)pipe->modes * sizeof *state0);
    if (gap > -field->tolerance)
        stick(field, 0, fabs(speed), pressing(field, 0, state0), result->state, result);
    *made = field;
    return RIVAL_OK;
}

static double processor_time(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double end_of_run(const struct pipe_field *field, int periods) {
    return periods * (2 * pi / field->omega);
}

/* A start for the library's step control; it takes over from the second step on. */
static double first_step(const struct pipe_field *field) {
    const int last = field->modes - 1;
    return 0.5 / hypot(field->damping[last], field->wave_square[last]);
}

static double polynomial(int degree, const double *coefficient, double x) {
    double value = coefficient[degree];
    for (int k = degree; k-- > 0;)
        value = value * x + coefficient[k];
    return value;
}

static double polynomial_slope(int degree, const double *coefficient, double x) {
    double value = degree * coefficient[degree];
    for (int k = degree; k-- > 1;)
        value = value * x + k * coefficient[k];
    return value;
}

/* Zero in [low, high] of a function that is negative at low and positive at high, to 2^-20 of the bracket. */
static double bisect(double (*function)(int, const double *, double), double sign, int degree,
                     const double *coefficient, double low, double high) {
    for (int k = 0; k < 20; k++) {
        const double middle = 0.5 * (low + high);
        if (sign * function(degree, coefficient, middle) < 0)
            low = middle;
        else
            high = middle;
    }
    return 0.5 * (low + high);
}

/* First place in (0, 1] where a gap polynomial may reach zero; 0 if nowhere. A maximum that stays below zero
 * by less than the interpolation may err counts, because a graze inside one step shows at neither of its
 * ends. */
static double suspected_contact(int degree, const double *gap) {
    enum { pieces = 8 };
    double value[pieces + 1], least = gap[0], greatest = gap[0];
    for (int k = 0; k <= pieces; k++) {
        value[k] = polynomial(degree, gap, (double)k / pieces);
        least = value[k] < least ? value[k] : least;
        greatest = value[k] > greatest ? value[k] : greatest;
    }
    const double margin = 0.01 * (greatest - least);
    if (greatest < -(greatest - least))
        return 0;
    for (int k = 1; k <= pieces; k++) {
        const double low = (double)(k - 1) / pieces, high = (double)k / pieces;
        if (value[k] > 0)
            return bisect(polynomial, 1, degree, gap, low, high);
        if (degree < 2 || polynomial_slope(degree, gap, low) <= 0 || polynomial_slope(degree, gap, high) >= 0)
            continue;
        const double top = bisect(polynomial_slope, -1, degree, gap, low, high);
        const double height = polynomial(degree, gap, top);
        if (height > -margin)
            return height > 0 ? bisect(polynomial, 1, degree, gap, low, top) : top;
    }
    return 0;
}

struct gsl_run {
    struct pipe_field *field;
    gsl_odeiv2_system system;
    gsl_odeiv2_step *stepper;
    gsl_odeiv2_control *control;
    gsl_odeiv2_evolve *evolve;
    double *state, *error, *trial, *trial_rate;
    double start, step; /* time and length of the last accepted step */
};

static int gsl_rate(double tau, const double state[], double rate[], void *field) {
    pipe_rate(field, tau, state, rate);
    return GSL_SUCCESS;
}

/* Repeats the last accepted step with another length. */
static int step_again(struct gsl_run *run, double length) {
    const gsl_odeiv2_evolve *evolve = run->evolve;
    memcpy(run->trial, evolve->y0, evolve->dimension * sizeof *run->trial);
    return gsl_odeiv2_step_apply(run->stepper, run->start, length, run->trial, run->error, evolve->dydt_in,
                                 run->trial_rate, &run->system);
}

/* Where in the last step, as a fraction of it, the gap may have reached zero; 0 if nowhere. The zero that a
 * flight starts with is divided out of the quintic that matches the gap and two derivatives at both ends. */
static double suspected_in_step(const struct gsl_run *run) {
    const struct pipe_field *field = run->field;
    const double h = run->step, *start = run->evolve->y0;
    const double acceleration_start = normal_speed(field, run->evolve->dydt_in);
    const double acceleration_end = normal_speed(field, run->evolve->dydt_out);
    double c[6] = {contact_gap(field, start), h * normal_speed(field, start),
                   0.5 * h * h * acceleration_start};
    const int divided = run->start == field->contact_time ? field->contact_order : 0;
    for (int k = 0; k < divided; k++)
        c[k] = 0;
    const double a = contact_gap(field, run->state) - c[0] - c[1] - c[2];
    const double b = h * normal_speed(field, run->state) - c[1] - 2 * c[2];
    const double e = h * h * acceleration_end - 2 * c[2];
    c[3] = 10 * a - 4 * b + 0.5 * e;
    c[4] = -15 * a + 7 * b - e;
    c[5] = 6 * a - 3 * b + 0.5 * e;
    return suspected_contact(5 - divided, c + divided);
}

/* Repeats the last step up to the impact. Returns 1 with the state on the stop, 0 if the pipe passes below
 * it, -1 on failure. The safeguard takes the gap for a dip that rises to the impact and perhaps falls again
 * behind it. */
static int locate_contact(struct gsl_run *run, double guess, double *tau) {
    struct pipe_field *field = run->field;
    double length = guess * run->step, low = 0, high = run->step;
    for (int k = 0; k < 60; k++) {
        if (step_again(run, length) != GSL_SUCCESS)
            return -1;
        double span;
        const double gap = contact_gap(field, run->trial), speed = normal_speed(field, run->trial);
        const double acceleration = normal_speed(field, run->trial_rate);
        const bool real = span_to_contact(gap, speed, acceleration, &span);
        if (fabs(span) <= short_step * run->step) {
            if (!real)
                return 0;
            *tau = run->start + length;
            memcpy(run->state, run->trial, 2 * (size_t)field->modes * sizeof *run->state);
            polish_contact(field, tau, run->state);
            return 1;
        }
        *(gap < 0 && (speed > 0 || acceleration > 0) ? &low : &high) = length;
        length += span;
        if (!(length > low && length < high))
            length = 0.5 * (low + high);
    }
    return -1;
}

/* Moves a sticking state that is within a short step of its release there. `slope` is the force's rate of
 * change. */
static void polish_release(struct pipe_field *field, double *tau, double *state, double slope) {
    double force = pressing(field, *tau, state);
    for (int k = 0; k < 6 && slope < 0; k++) {
        const double span = -force / slope, before = force;
        if (fabs(span) <= 2 * DBL_EPSILON * *tau)
            return;
        flow_shortly(field, *tau, span, state);
        *tau += span;
        force = pressing(field, *tau, state);
        slope = (force - before) / span;
    }
}

/* Repeats the last step up to the release by the Illinois method; false on failure. */
static bool locate_release(struct gsl_run *run, double force_end, double *tau) {
    struct pipe_field *field = run->field;
    double low = 0, high = run->step, force_high = force_end;
    double force_low = pressing(field, run->start, run->evolve->y0);
    bool kept_low = false, kept_high = false;
    for (int k = 0; k < 60; k++) {
        const double length = force_low > 0 ? low + (high - low) * force_low / (force_low - force_high) : 0;
        if (step_again(run, length) != GSL_SUCCESS)
            return false;
        const double force = pressing(field, run->start + length, run->trial);
        const double slope = (force_high - force_low) / (high - low);
        if (length == 0 || fabs(force) <= fabs(slope) * short_step * run->step) {
            *tau = run->start + length;
            memcpy(run->state, run->trial, 2 * (size_t)field->modes * sizeof *run->state);
            polish_release(field, tau, run->state, slope);
            return true;
        }
        if (force > 0) {
            low = length, force_low = force;
            force_high *= kept_high ? 0.5 : 1;
            kept_high = true, kept_low = false;
        } else {
            high = length, force_high = force;
            force_low *= kept_low ? 0.5 : 1;
            kept_low = true, kept_high = false;
        }
    }
    return false;
}

/* Deals with the events of the last step. Returns 1 after an event, 0 without, -1 on failure; `due` is the
 * time to the next impact as far as it can be foreseen. */
static int gsl_events(struct gsl_run *run, double *tau, double *due, rival_result *result) {
    struct pipe_field *field = run->field;
    *due = INFINITY;
    if (field->sticking) {
        const double force = pressing(field, *tau, run->state);
        if (force > 0)
            return 0;
        if (!locate_release(run, force, tau))
            return -1;
        release(field, *tau, run->state, result);
        return 1;
    }
    const double guess = suspected_in_step(run);
    const int found = guess > 0 ? locate_contact(run, guess, tau) : 0;
    if (found == 1)
        *due = rebound(field, *tau, run->state, result);
    return found;
}

static int gsl_integrate(struct gsl_run *run, double end, rival_result *result) {
    double tau = 0, usual = first_step(run->field), due = INFINITY;
    while (tau < end) {
        const bool shortened = flight_allowance * due < usual;
        double step = shortened ? flight_allowance * due : usual;
        run->start = tau;
        if (gsl_odeiv2_evolve_apply(run->evolve, run->control, run->stepper, &run->system, &tau, end, &step,
                                    run->state) != GSL_SUCCESS)
            return RIVAL_FAILED;
        run->step = run->evolve->last_step;
        usual = shortened && step < usual ? usual : step;
        const int event = gsl_events(run, &tau, &due, result);
        if (event < 0)
            return RIVAL_FAILED;
        if (event > 0)
            gsl_odeiv2_evolve_reset(run->evolve);
    }
    return RIVAL_OK;
}

static bool gsl_set_up(struct gsl_run *run, double rtol, double atol, rival_result *result) {
    const size_t dimension = 2 * (size_t)run->field->modes;
    run->system = (gsl_odeiv2_system){gsl_rate, NULL, dimension, run->field};
    run->stepper = gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk8pd, dimension);
    run->control = gsl_odeiv2_control_standard_new(atol, rtol, 1, 0);
    run->evolve = gsl_odeiv2_evolve_alloc(dimension);
    run->error = malloc(3 * dimension * sizeof *run->error);
    if (!run->stepper || !run->control || !run->evolve || !run->error)
        return false;
    run->trial = run->error + dimension;
    run->trial_rate = run->trial + dimension;
    run->state = result->state;
    return true;
}

static void gsl_tear_down(struct gsl_run *run) {
    free(run->error);
    if (run->evolve)
        gsl_odeiv2_evolve_free(run->evolve);
    if (run->control)
        gsl_odeiv2_control_free(run->control);
    if (run->stepper)
        gsl_odeiv2_step_free(run->stepper);
    free(run->field);
}

static int run_gsl_rk8pd(const rival_pipe *pipe, const double *state0, int periods, double rtol, double atol,
                         rival_result *result) {
    struct gsl_run run = {0};
    int status = begin(pipe, state0, periods, rtol, atol, result, &run.field);
    if (status != RIVAL_OK)
        return status;
    gsl_error_handler_t *const handler = gsl_set_error_handler_off();
    if (gsl_set_up(&run, rtol, atol, result)) {
        const double before = processor_time();
        status = gsl_integrate(&run, end_of_run(run.field, periods), result);
        result->cpu_seconds = processor_time() - before;
        result->field_evaluations = run.field->evaluations;
    } else {
        status = RIVAL_NO_MEMORY;
    }
    gsl_tear_down(&run);
    gsl_set_error_handler(handler);
    return status;
}

#ifdef SALTUS_WITH_SUNDIALS

_Static_assert(sizeof(realtype) == sizeof(double), "SUNDIALS has to be built for double precision");

struct sundials_run {
    struct pipe_field *field;
    SUNContext context;
    N_Vector state, start;
    void *memory;
    SUNNonlinearSolver iteration;
    bool repeating; /* a step is being redone, and its event is known already */
};

static double *values(N_Vector vector) {
    return N_VGetArrayPointer(vector);
}

static int sundials_rate(realtype tau, N_Vector state, N_Vector rate, void *run) {
    pipe_rate(((struct sundials_run *)run)->field, tau, values(state), values(rate));
    return 0;
}

/* Both functions rise through zero at an event: the gap (or -n.f while sticking), and -n.q' at the top of a
 * flight, which breaks up steps that hold two zeros of the gap. The gap's zero at the start is divided out.
 */
static int sundials_roots(realtype tau, N_Vector vector, realtype *root, void *data) {
    const struct sundials_run *run = data;
    struct pipe_field *field = run->field;
    const double *state = values(vector);
    const double elapsed = tau - field->contact_time;
    root[0] = root[1] = -1;
    if (run->repeating)
        return 0;
    if (field->sticking) {
        root[0] = -pressing(field, tau, state);
    } else if (field->contact_order > 0 && elapsed <= 0) {
        root[1] = 1;
    } else {
        root[0] = contact_gap(field, state);
        for (int k = 0; k < field->contact_order; k++)
            root[0] /= elapsed;
        root[1] = -normal_speed(field, state);
    }
    return 0;
}

/* Integrates the step that holds an event anew, up to the time of the event: the interpolant has a lower
 * order than the step. */
static bool arkode_redo(struct sundials_run *run, double *tau) {
    struct pipe_field *field = run->field;
    double reached, step;
    if (ARKStepGetCurrentTime(run->memory, &reached) || ARKStepGetLastStep(run->memory, &step))
        return false;
    const double start = reached - step, length = *tau - start;
    if (ARKStepGetDky(run->memory, start, 0, run->start))
        return false;
    double force_start = 0;
    if (field->sticking)
        force_start = pressing(field, start, values(run->start));
    if (length > short_step * step) {
        run->repeating = true;
        double arrived;
        const bool done = !ARKStepReset(run->memory, start, run->start) &&
                          !ARKStepSetInitStep(run->memory, length) &&
                          !ARKStepSetStopTime(run->memory, *tau) &&
                          ARKStepEvolve(run->memory, *tau, run->state, &arrived, ARK_NORMAL) >= 0;
        run->repeating = false;
        if (!done)
            return false;
    }
    if (field->sticking)
        polish_release(field, tau, values(run->state), -force_start / length);
    else
        polish_contact(field, tau, values(run->state));
    return true;
}

static int arkode_integrate(struct sundials_run *run, double end, rival_result *result) {
    struct pipe_field *field = run->field;
    double tau = 0, usual = first_step(field), due = INFINITY;
    bool restart = true;
    while (tau < end) {
        if (restart &&
            (ARKStepReset(run->memory, tau, run->state) ||
             ARKStepSetInitStep(run->memory, fmin(fmin(usual, flight_allowance * due), end - tau)) ||
             ARKStepSetStopTime(run->memory, end)))
            return RIVAL_FAILED;
        int found[2];
        const int status = ARKStepEvolve(run->memory, end, run->state, &tau, ARK_NORMAL);
        if (status < 0 || (status == ARK_ROOT_RETURN && ARKStepGetRootInfo(run->memory, found)))
            return RIVAL_FAILED;
        restart = status == ARK_ROOT_RETURN && found[0];
        if (!restart)
            continue;
        double step;
        if (ARKStepGetLastStep(run->memory, &step) || !arkode_redo(run, &tau))
            return RIVAL_FAILED;
        if (!(due < usual) || step > usual)
            usual = step;
        due = INFINITY;
        if (field->sticking)
            release(field, tau, values(run->state), result);
        else
            due = rebound(field, tau, values(run->state), result);
    }
    return RIVAL_OK;
}

static void swallow_message(int code, const char *module, const char *function, char *message, void *data) {
    (void)code, (void)module, (void)function, (void)message, (void)data;
}

/* The library's own makes one pass per vector, zero coefficients included; on vectors as short as these it
 * takes three times as long as the vector field. */
static int linear_combination(int count, realtype *factor, N_Vector *vectors, N_Vector sum) {
    const sunindextype length = NV_LENGTH_S(sum);
    double *total = NV_DATA_S(sum);
    enum { most = 32 };
    const double *term[most];
    double weight[most];
    int terms = 0;
    if (count > most)
        return -1;
    for (int k = 0; k < count; k++)
        if (factor[k] != 0) {
            term[terms] = NV_DATA_S(vectors[k]);
            weight[terms++] = factor[k];
        }
    for (sunindextype i = 0; i < length; i++) {
        double value = 0;
        for (int k = 0; k < terms; k++)
            value += weight[k] * term[k][i];
        total[i] = value;
    }
    return 0;
}

static bool sundials_set_up(struct sundials_run *run, rival_result *result) {
    const sunindextype dimension = 2 * run->field->modes;
    if (SUNContext_Create(NULL, &run->context))
        return false;
    run->state = N_VMake_Serial(dimension, result->state, run->context);
    run->start = N_VNew_Serial(dimension, run->context);
    if (!run->state || !run->start)
        return false;
    run->state->ops->nvlinearcombination = linear_combination;
    return true;
}

static void sundials_tear_down(struct sundials_run *run) {
    if (run->state)
        N_VDestroy(run->state);
    if (run->start)
        N_VDestroy(run->start);
    if (run->context)
        SUNContext_Free(&run->context);
    free(run->field);
}

static bool arkode_set_up(struct sundials_run *run, double rtol, double atol) {
    int rising[2] = {1, 1};
    run->memory = ARKStepCreate(sundials_rate, NULL, 0, run->state, run->context);
    return run->memory && !ARKStepSetErrHandlerFn(run->memory, swallow_message, NULL) &&
           !ARKStepSetTableNum(run->memory, ARKODE_DIRK_NONE, ARKODE_FEHLBERG_13_7_8) &&
           !ARKStepSetInterpolantType(run->memory, ARK_INTERP_HERMITE) &&
           !ARKStepSetInterpolantDegree(run->memory, 3) && !ARKStepSetUserData(run->memory, run) &&
           !ARKStepSStolerances(run->memory, rtol, atol) && !ARKStepSetMaxNumSteps(run->memory, -1) &&
           !ARKStepRootInit(run->memory, 2, sundials_roots) &&
           !ARKStepSetRootDirection(run->memory, rising) && !ARKStepSetNoInactiveRootWarn(run->memory);
}

static int run_arkode(const rival_pipe *pipe, const double *state0, int periods, double rtol, double atol,
                      rival_result *result) {
    struct sundials_run run = {0};
    int status = begin(pipe, state0, periods, rtol, atol, result, &run.field);
    if (status != RIVAL_OK)
        return status;
    if (sundials_set_up(&run, result) && arkode_set_up(&run, rtol, atol)) {
        const double before = processor_time();
        status = arkode_integrate(&run, end_of_run(run.field, periods), result);
        result->cpu_seconds = processor_time() - before;
        result->field_evaluations = run.field->evaluations;
    } else {
        status = RIVAL_NO_MEMORY;
    }
    if (run.memory)
        ARKStepFree(&run.memory);
    sundials_tear_down(&run);
    return status;
}

/* The interpolant of a multistep method has the method's own order, so that the state at a root needs no
 * redoing. */
static int cvode_integrate(struct sundials_run *run, double end, rival_result *result) {
    struct pipe_field *field = run->field;
    double tau = 0;
    bool restart = true;
    while (tau < end) {
        if (restart && (CVodeReInit(run->memory, tau, run->state) || CVodeSetStopTime(run->memory, end)))
            return RIVAL_FAILED;
        int found[2];
        const int status = CVode(run->memory, end, run->state, &tau, CV_NORMAL);
        if (status < 0 || (status == CV_ROOT_RETURN && CVodeGetRootInfo(run->memory, found)))
            return RIVAL_FAILED;
        restart = status == CV_ROOT_RETURN && found[0];
        if (restart && field->sticking)
            release(field, tau, values(run->state), result);
        else if (restart)
            rebound(field, tau, values(run->state), result);
    }
    return RIVAL_OK;
}

static bool cvode_set_up(struct sundials_run *run, double rtol, double atol) {
    int rising[2] = {1, 1};
    run->memory = CVodeCreate(CV_ADAMS, run->context);
    run->iteration = SUNNonlinSol_FixedPoint(run->state, 0, run->context);
    return run->memory && run->iteration && !CVodeSetErrHandlerFn(run->memory, swallow_message, NULL) &&
           !CVodeInit(run->memory, sundials_rate, 0, run->state) && !CVodeSetUserData(run->memory, run) &&
           !CVodeSStolerances(run->memory, rtol, atol) && !CVodeSetMaxNumSteps(run->memory, -1) &&
           !CVodeSetNonlinearSolver(run->memory, run->iteration) &&
           !CVodeRootInit(run->memory, 2, sundials_roots) && !CVodeSetRootDirection(run->memory, rising) &&
           !CVodeSetNoInactiveRootWarn(run->memory);
}

static int run_cvode(const rival_pipe *pipe, const double *state0, int periods, double rtol, double atol,
                     rival_result *result) {
    struct sundials_run run = {0};
    int status = begin(pipe, state0, periods, rtol, atol, result, &run.field);
    if (status != RIVAL_OK)
        return status;
    if (sundials_set_up(&run, result) && cvode_set_up(&run, rtol, atol)) {
        const double before = processor_time();
        status = cvode_integrate(&run, end_of_run(run.field, periods), result);
        result->cpu_seconds = processor_time() - before;
        result->field_evaluations = run.field->evaluations;
    } else {
        status = RIVAL_NO_MEMORY;
    }
    if (run.memory)
        CVodeFree(&run.memory);
    if (run.iteration)
        SUNNonlinSolFree(run.iteration);
    sundials_tear_down(&run);
    return status;
}

#endif

const rival saltus_rivals[] = {
    {"GSL rk8pd", run_gsl_rk8pd},
#ifdef SALTUS_WITH_SUNDIALS
    {"SUNDIALS ARKODE 8(7)", run_arkode},
    {"SUNDIALS CVODE Adams", run_cvode},
#endif
};
const int saltus_rival_count = sizeof saltus_rivals / sizeof saltus_rivals[0];
