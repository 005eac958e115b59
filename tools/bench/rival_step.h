/* Runs by steps of a one-step method, and the events within a step: finding where the gap may reach zero, and
 * repeating the step up to there. Shared by the integrators that take single steps (C and C++).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_RIVAL_STEP_H
#define SALTUS_BENCH_RIVAL_STEP_H

#include "rival_contact.h"

static inline double polynomial(int degree, const double *coefficient, double x) {
    double value = coefficient[degree];
    for (int k = degree; k-- > 0;)
        value = value * x + coefficient[k];
    return value;
}

static inline double polynomial_slope(int degree, const double *coefficient, double x) {
    double value = degree * coefficient[degree];
    for (int k = degree; k-- > 1;)
        value = value * x + k * coefficient[k];
    return value;
}

/* Zero in [low, high] of a function that is negative at low and positive at high, to 2^-20 of the bracket. */
static inline double bisect(double (*function)(int, const double *, double), double sign, int degree,
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
static inline double suspected_contact(int degree, const double *gap) {
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

/* The last accepted step of a library's stepper, which can be asked for the next one. */
struct rival_step {
    struct scene_field *field;
    double start, length;
    const double *begin, *begin_rate; /* state and rate at the start of the step */
    double *end;                      /* state at its end, replaced by that at an event */
    const double *end_rate;
    double *trial, *trial_rate;
    void *stepper;
    /* Begin at a time, with the state in `end`. */
    void (*restart)(void *stepper, double tau);
    /* Take one step from *tau, at most to `end`, and set all that comes before `trial`; *length is the first
     * one to try and becomes that which comes next. */
    bool (*take)(void *stepper, double *tau, double end, double *length);
    /* Repeat the step with another length into `trial` and `trial_rate`. */
    bool (*again)(void *stepper, double length);
};

/* Whether the quintic stays below zero by more than suspected_contact allows: its Bernstein coefficients
 * enclose it. */
static inline bool surely_below(double gap, double slope, double curve, double gap_end, double slope_end,
                                double curve_end) {
    const double b1 = gap + 0.2 * slope, b2 = b1 + 0.2 * slope + 0.05 * curve;
    const double b4 = gap_end - 0.2 * slope_end, b3 = b4 - 0.2 * slope_end + 0.05 * curve_end;
    const double coefficient[6] = {gap, b1, b2, b3, b4, gap_end};
    double greatest = gap, least = gap;
    for (int k = 1; k < 6; k++) {
        greatest = coefficient[k] > greatest ? coefficient[k] : greatest;
        least = coefficient[k] < least ? coefficient[k] : least;
    }
    return greatest < -0.01 * (greatest - least);
}

/* Where in the last step, as a fraction of it, the gap may have reached zero; 0 if nowhere. The zero that a
 * flight starts with is divided out of the quintic that matches the gap and two derivatives at both ends. */
static inline double suspected_in_step(const struct rival_step *step, int face) {
    const struct scene_field *field = step->field;
    const double h = step->length;
    const double gap = contact_gap(field, face, step->begin), gap_end = contact_gap(field, face, step->end);
    const double slope = h * normal_speed(field, face, step->begin);
    const double slope_end = h * normal_speed(field, face, step->end);
    const double curve = h * h * normal_speed(field, face, step->begin_rate);
    const double curve_end = h * h * normal_speed(field, face, step->end_rate);
    const bool left = step->start == field->contact_time && face == field->contact_face;
    const int divided = left ? field->contact_order : 0;
    if (divided == 0 && surely_below(gap, slope, curve, gap_end, slope_end, curve_end))
        return 0;
    double c[6] = {gap, slope, 0.5 * curve};
    for (int k = 0; k < divided; k++)
        c[k] = 0;
    const double a = gap_end - c[0] - c[1] - c[2];
    const double b = slope_end - c[1] - 2 * c[2];
    const double e = curve_end - 2 * c[2];
    c[3] = 10 * a - 4 * b + 0.5 * e;
    c[4] = -15 * a + 7 * b - e;
    c[5] = 6 * a - 3 * b + 0.5 * e;
    return suspected_contact(5 - divided, c + divided);
}

/* Repeats the last step up to the impact. Returns 1 with the state on the stop, 0 if the structure passes
 * below it, -1 on failure. The safeguard assumes a gap that dips first, rises to the impact and may fall
 * again behind it. */
static inline int locate_contact(struct rival_step *step, int face, double guess, double *tau) {
    struct scene_field *field = step->field;
    double length = guess * step->length, low = 0, high = step->length;
    for (int k = 0; k < 60; k++) {
        if (!step->again(step->stepper, length))
            return -1;
        double span;
        const double gap = contact_gap(field, face, step->trial),
                     speed = normal_speed(field, face, step->trial);
        const double acceleration = normal_speed(field, face, step->trial_rate);
        const bool real = span_to_contact(gap, speed, acceleration, &span);
        if (fabs(span) <= short_step * step->length) {
            if (!real)
                return 0;
            *tau = step->start + length;
            memcpy(step->end, step->trial, field->count * sizeof *step->end);
            polish_contact(field, face, tau, step->end);
            return 1;
        }
        *(gap < 0 && (speed > 0 || acceleration > 0) ? &low : &high) = length;
        length += span;
        if (!(length > low && length < high))
            length = 0.5 * (low + high);
    }
    return -1;
}

/* The first contact in the last step, with the face in *face; as locate_contact. */
static inline int locate_first(struct rival_step *step, int *face, double *tau) {
    double guess[faces_max];
    int found = 0;
    for (int f = 0; f < step->field->faces; f++)
        guess[f] = suspected_in_step(step, f);
    for (int tried = 0; tried < step->field->faces && found == 0; tried++) {
        int first = -1;
        for (int f = 0; f < step->field->faces; f++)
            if (guess[f] > 0 && (first < 0 || guess[f] < guess[first]))
                first = f;
        if (first < 0)
            return 0;
        found = locate_contact(step, first, guess[first], tau);
        guess[first] = 0;
        *face = first;
    }
    return found;
}

/* Moves a sticking state that is within a short step of its release there. `slope` is the force's rate of
 * change. */
static inline void polish_release(struct scene_field *field, double *tau, double *state, double slope) {
    const int face = field->contact_face;
    double force = pressing(field, face, *tau, state);
    for (int k = 0; k < 6 && slope < 0; k++) {
        const double span = -force / slope, before = force;
        if (fabs(span) <= 2 * DBL_EPSILON * *tau)
            return;
        flow_shortly(field, *tau, span, state);
        *tau += span;
        force = pressing(field, face, *tau, state);
        slope = (force - before) / span;
    }
}

/* Repeats the last step up to the release by the Illinois method; false on failure. */
static inline bool locate_release(struct rival_step *step, double force_end, double *tau) {
    struct scene_field *field = step->field;
    const int face = field->contact_face;
    double low = 0, high = step->length, force_high = force_end;
    double force_low = pressing(field, face, step->start, step->begin);
    bool kept_low = false, kept_high = false;
    for (int k = 0; k < 60; k++) {
        const double length = force_low > 0 ? low + (high - low) * force_low / (force_low - force_high) : 0;
        if (!step->again(step->stepper, length))
            return false;
        const double force = pressing(field, face, step->start + length, step->trial);
        const double slope = (force_high - force_low) / (high - low);
        if (length == 0 || fabs(force) <= fabs(slope) * short_step * step->length) {
            *tau = step->start + length;
            memcpy(step->end, step->trial, field->count * sizeof *step->end);
            polish_release(field, tau, step->end, slope);
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

/* Handles the events of the last step. Returns 1 after an event, 0 without, -1 on failure; `due` is the time
 * to the next impact if it can be predicted. */
static inline int step_events(struct rival_step *step, double *tau, double *due, rival_result *result) {
    struct scene_field *field = step->field;
    *due = INFINITY;
    if (field->sticking) {
        const double force = pressing(field, field->contact_face, *tau, step->end);
        if (force > 0)
            return 0;
        if (!locate_release(step, force, tau))
            return -1;
        release(field, *tau, step->end, result);
        return 1;
    }
    int face;
    const int found = locate_first(step, &face, tau);
    if (found == 1)
        *due = rebound(field, face, *tau, step->end, result);
    return found;
}

/* The whole run, from the field's vector and back into it. */
static inline bool take_steps(void *it, double end, rival_result *result) {
    struct rival_step *step = (struct rival_step *)it;
    struct scene_field *field = step->field;
    double tau = 0, usual = field->first_step, due = INFINITY;
    int event = 0;
    memmove(step->end, field->vector, field->count * sizeof *step->end);
    step->restart(step->stepper, tau);
    while (tau < end && event >= 0) {
        const bool shortened = flight_allowance * due < usual;
        double length = shortened ? flight_allowance * due : usual;
        step->start = tau;
        if (!step->take(step->stepper, &tau, end, &length))
            return false;
        result->steps++;
        usual = shortened && length < usual ? usual : length;
        event = step_events(step, &tau, &due, result);
        if (event > 0)
            step->restart(step->stepper, tau);
    }
    memmove(field->vector, step->end, field->count * sizeof *step->end);
    return event >= 0;
}

#endif
