/* What the stops do to a rival's trajectory: the impact law, the rule that ends a chatter, release, and the
 * saltation matrices of its tangent vectors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_RIVAL_CONTACT_H
#define SALTUS_BENCH_RIVAL_CONTACT_H

#include "rival_field.h"

/* Projecting onto the stop from an outgoing speed v costs an error of order v^2 / (a (1 - r)) in the state.
 */
static const double chatter_share_of_tolerance = 0.05;
/* Below this height in units of the clearance times DBL_EPSILON, rounding of the gap decides when the next
 * impact of a chatter is. */
static const double least_height = 8;
/* Over this fraction of a step a fourth-order step errs far below the tolerance, and costs less than the
 * library's. */
static const double short_step = 1e-3;
/* A first step a little longer than the foreseen flight reaches the impact; a much longer one would be
 * wasted. */
static const double flight_allowance = 1.05;

static inline double contact_gap(const struct scene_field *field, int face, const double *state) {
    return field->side[face] * along_normal(field, state) - field->d;
}

/* Speed towards the stop. */
static inline double normal_speed(const struct scene_field *field, int face, const double *state) {
    return field->side[face] * along_normal(field, state + field->modes);
}

/* n.f of the free field towards the stop; it can hold the structure only while this is positive. */
static inline double pressing(struct scene_field *field, int face, double tau, const double *state) {
    free_acceleration(field, tau, state, state + field->modes, field->stage);
    return field->side[face] * along_normal(field, field->stage);
}

static inline void place_on_stop(const struct scene_field *field, int face, double *state) {
    push(field, -field->side[face] * contact_gap(field, face, state) / field->normal_square, state);
}

static inline void remove_normal_speed(const struct scene_field *field, double *state) {
    double *velocity = state + field->modes;
    push(field, -along_normal(field, velocity) / field->normal_square, velocity);
}

/* One classical fourth-order step, for spans far below those that the library steps over. */
static inline void flow_shortly(struct scene_field *field, double tau, double span, double *vector) {
    static const double node[4] = {0, 0.5, 0.5, 1}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    double *rate = field->rate, *stage = field->stage, *sum = field->sum;
    memcpy(stage, vector, field->count * sizeof *stage);
    memcpy(sum, vector, field->count * sizeof *sum);
    for (int k = 0; k < 4; k++) {
        scene_rate(field, tau + node[k] * span, stage, rate);
        for (size_t i = 0; i < field->count; i++) {
            sum[i] += weight[k] * span * rate[i];
            if (k < 3)
                stage[i] = vector[i] + node[k + 1] * span * rate[i];
        }
    }
    memcpy(vector, sum, field->count * sizeof *vector);
}

/* Span to the rising zero of a gap with the given derivatives; if there is none, false and the span to its
 * maximum. */
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
static inline void polish_contact(struct scene_field *field, int face, double *tau, double *vector) {
    for (int k = 0; k < 4; k++) {
        const double gap = contact_gap(field, face, vector);
        if (fabs(gap) <= 2 * DBL_EPSILON * field->length)
            return;
        double span;
        const double speed = normal_speed(field, face, vector);
        if (!span_to_contact(gap, speed, pressing(field, face, *tau, vector), &span))
            return;
        flow_shortly(field, *tau, span, vector);
        *tau += span;
    }
}

static inline void record(const struct scene_field *field, rival_result *result, double tau,
                          rival_event_kind kind) {
    if (result->count < result->capacity) {
        rival_event *event = &result->events[result->count];
        event->time_over_T = tau * field->omega / (2 * pi);
        event->kind = kind;
    }
    result->count++;
}

/* Switches to the sticking field if the impacts that would follow end within the tolerance. Their duration is
 * added only to the recorded time: at tau the projected state is as accurate as the chatter's own. */
static inline bool stick(struct scene_field *field, int face, double tau, double outgoing, double load,
                         double *state, rival_result *result) {
    const double settling = load * (1 - field->r);
    const double tolerable = chatter_share_of_tolerance * field->tolerance * settling;
    const double invisible = 2 * load * least_height * DBL_EPSILON * field->length;
    if (settling <= 0 || outgoing * outgoing >= (tolerable > invisible ? tolerable : invisible))
        return false;
    record(field, result, outgoing > 0 ? tau + 2 * outgoing / settling : tau, RIVAL_STICK);
    place_on_stop(field, face, state);
    remove_normal_speed(field, state);
    field->sticking = true;
    field->contact_face = face;
    return true;
}

/* The saltation matrix of an impact with restitution r, by columns: a tangent vector meets the stop a little
 * later or earlier. `before` and `after` hold the field on both sides; the impact law acts on velocities. */
static inline void leap_tangents(struct scene_field *field, double r, double *vector) {
    const int modes = field->modes;
    const double kick = (1 + r) / field->normal_square, speed = along_normal(field, field->before);
    double *before = field->before;
    push(field, -kick * along_normal(field, before + modes), before + modes);
    for (int c = 0; c < field->columns; c++) {
        double *tangent = vector + 2 * modes * (1 + c);
        const double delay = speed != 0 ? -along_normal(field, tangent) / speed : 0;
        push(field, -kick * along_normal(field, tangent + modes), tangent + modes);
        for (int i = 0; i < 2 * modes; i++)
            tangent[i] += (before[i] - field->after[i]) * delay;
    }
}

/* Applies the impact law and returns when the next impact is due if n.q'' stays as it is, INFINITY if never.
 */
static inline double rebound(struct scene_field *field, int face, double tau, double *vector,
                             rival_result *result) {
    const double outgoing = field->r * normal_speed(field, face, vector);
    double due = INFINITY;
    record(field, result, tau, RIVAL_IMPACT);
    place_on_stop(field, face, vector);
    if (field->columns > 0)
        state_rate(field, tau, vector, field->before);
    remove_normal_speed(field, vector);
    const double load = pressing(field, face, tau, vector);
    const bool held = stick(field, face, tau, outgoing, load, vector, result);
    if (!held) {
        push(field, -field->side[face] * outgoing / field->normal_square, vector + field->modes);
        field->contact_face = face;
        field->contact_time = tau;
        field->contact_order = outgoing > 0 ? 1 : 2;
        due = load > 0 ? 2 * outgoing / load : INFINITY;
    }
    if (field->columns > 0) {
        state_rate(field, tau, vector, field->after);
        leap_tangents(field, held ? 0 : field->r, vector);
    }
    return due;
}

static inline void release(struct scene_field *field, double tau, double *state, rival_result *result) {
    record(field, result, tau, RIVAL_RELEASE);
    place_on_stop(field, field->contact_face, state);
    remove_normal_speed(field, state);
    field->sticking = false;
    field->contact_time = tau;
    field->contact_order = 3;
}

/* Returns to the start, in free flight or held by the stop; tangent vectors become the identity matrix. */
static inline void start_over(struct scene_field *field, rival_result *result) {
    const size_t length = 2 * (size_t)field->modes;
    memset(field->vector, 0, field->count * sizeof *field->vector);
    memcpy(field->vector, field->start, length * sizeof *field->start);
    for (int c = 0; c < field->columns; c++)
        field->vector[length * (size_t)(1 + c) + (size_t)c] = 1;
    field->sticking = false;
    field->contact_order = 0;
    field->contact_time = 0;
    field->forced_time = NAN;
    field->evaluations = 0;
    result->count = 0;
    result->steps = 0;
    for (int face = 0; face < field->faces && !field->sticking; face++)
        if (contact_gap(field, face, field->vector) > -field->tolerance)
            stick(field, face, 0, fabs(normal_speed(field, face, field->vector)),
                  pressing(field, face, 0, field->vector), field->vector, result);
}

/* The field of a run, to be freed; NULL without memory, or if the start lies beyond the stop. */
static inline struct scene_field *begin(const saltus_spec *spec, const double *state0, double tolerance,
                                        const rival_result *result) {
    struct scene_field *field = new_field(spec, state0, result->tangents != NULL, tolerance);
    for (int face = 0; field && face < field->faces; face++)
        if (contact_gap(field, face, state0) > field->tolerance) {
            free(field);
            field = NULL;
        }
    return field;
}

/* The run as often as asked for, each time from the start; `integrate` leaves the end in the field's vector.
 * The result receives it and the mean time of a run. */
static inline bool run_repeatedly(struct scene_field *field, int periods, rival_result *result,
                                  bool integrate(void *run, double end, rival_result *result), void *run) {
    const int repeats = result->repeats > 1 ? result->repeats : 1;
    const size_t length = 2 * (size_t)field->modes;
    const double before = processor_seconds();
    bool done = true;
    for (int k = 0; k < repeats && done; k++) {
        start_over(field, result);
        done = integrate(run, periods * (2 * pi / field->omega), result);
    }
    result->cpu_seconds = (processor_seconds() - before) / repeats;
    result->field_evaluations = field->evaluations;
    memcpy(result->state, field->vector, length * sizeof *result->state);
    if (result->tangents)
        memcpy(result->tangents, field->vector + length, length * length * sizeof *result->tangents);
    return done;
}

#endif
