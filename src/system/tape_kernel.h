/* The vector field of a system from text: its tape, order by order.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_TAPE_KERNEL_H
#define SALTUS_SYSTEM_TAPE_KERNEL_H

#include "system/tape.h"

#define MODEL_NAME "tape"

enum { model_rows_common = 0, model_rows_plain = 0 };
KERNEL_INLINE unsigned model_common_terms(int rows) {
    (void)rows;
    return 0;
}

enum {
    model_series_count = 0,
    model_drives = 0,
    model_tables = 0,
    model_vary_drives = 0,
    model_rows_ahead = 0
};

#define SLOT(n) (NUMBERS(f.loaded.slots) + (n))
#define VARY_SLOT(d, n) (NUMBERS(f.vary.slots) + (d)*f.loaded.tape->slot_count + (n))

static void model_load(saltus_work *w, int lane, const saltus_system *system) {
    (void)w;
    (void)lane;
    (void)system;
}

KERNEL_INLINE void model_forcing(frame f, int order, lane_t sine, lane_t cosine) {
    (void)f;
    (void)order;
    (void)sine;
    (void)cosine;
}

KERNEL_INLINE void model_vary_forcing(frame f, int d, int order, lane_t sine, lane_t cosine) {
    (void)d;
    model_forcing(f, order, sine, cosine);
}

/* The direction of a column; negative: an ordinary tangent vector, or the trajectory. */
KERNEL_INLINE int direction_of(frame f, int c) {
    return f.directions - 1 - (f.columns - c);
}

KERNEL_INLINE void set_series(frame f, int place, int c, lane_t first, lane_t second) {
    lane_t *series = SERIES(place, 0, c);
    series[0] = first;
    series[1] = second;
    for (int k = 2; k < f.orders; k++)
        series[k] = lane_constant(0);
}

/* Time and phase, which are linear; along omega at fixed phase of the step's begin, `elapsed` before this:
 * the phase moves by elapsed / (2 pi), and time is the phase times T = 2 pi / omega. */
KERNEL_INLINE void model_start(frame f, int c) {
    const saltus_tape *tape = f.loaded.tape;
    const int direction = direction_of(f, c);
    const lane_t omega = *SCALAR(0), turn = lane_constant(6.28318530717958647693), none = lane_constant(0);
    const lane_t period = turn / omega, time = *f.phase * period;
    if (c > 0 && direction < 0)
        return;
    lane_t start = time, rate = omega + none, turned = *f.phase;
    if (c > 0) {
        rate = *VARY_SCALAR(direction, 0);
        start = rate * (*f.elapsed - time) / omega;
        turned = rate * *f.elapsed / turn;
    }
    if (tape->time >= 0)
        set_series(f, tape->time, c, start, lane_constant(c == 0));
    if (tape->phase >= 0)
        set_series(f, tape->phase, c, turned, rate / turn);
}

/* Sum of a_i b_{k-i} for i = first .. last, in four chains. */
KERNEL_INLINE lane_t convolve(const lane_t *a, const lane_t *b, int k, int first, int last) {
    lane_t sum[4] = {lane_constant(0), lane_constant(0), lane_constant(0), lane_constant(0)};
    int i = first;
    b += k;
    for (; i + 3 <= last; i += 4)
        for (int j = 0; j < 4; j++)
            sum[j] = lane_fma(a[i + j], b[-i - j], sum[j]);
    for (int j = 0; i <= last; i++, j++)
        sum[j] = lane_fma(a[i], b[-i], sum[j]);
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* The same with i a_i in place of a_i. */
KERNEL_INLINE lane_t convolve_rate(const lane_t *a, const lane_t *b, int k, int last) {
    lane_t sum[2] = {lane_constant(0), lane_constant(0)};
    for (int i = 1; i <= last; i++)
        sum[i % 2] = lane_fma(a[i] * (double)i, b[k - i], sum[i % 2]);
    return sum[0] + sum[1];
}

/* Half of the terms of a square, doubled. */
KERNEL_INLINE lane_t convolve_square(const lane_t *a, int k) {
    lane_t sum = convolve(a, a, k, 0, (k - 1) / 2 - (k == 0));
    sum = sum + sum;
    if (k % 2 == 0)
        sum = lane_fma(a[k / 2], a[k / 2], sum);
    return sum;
}

static lane_t function_value(const saltus_tape_step *s, lane_t a, lane_t b) {
    double *first = (double *)&a;
    const double *second = (const double *)&b;
    for (int l = 0; l < LANES; l++)
        first[l] = saltus_operation_value(s->function, (const double[4]){first[l], second[l], 0, 0});
    return a;
}

/* Coefficient k of a step's series, for the trajectory. */
KERNEL_INLINE lane_t step_value(frame f, const saltus_tape_step *s, int k) {
    const saltus_tape_term *term = f.loaded.tape->terms + s->first;
    const lane_t *a = SERIES(s->a, 0, 0), *b = SERIES(s->b, 0, 0), *out = SERIES(s->out, 0, 0);
    lane_t sum = lane_constant(0);
    switch (s->code) {
    case SALTUS_TAPE_COMBINE:
        for (int j = 0; j < s->count; j++)
            if (term[j].from >= 0)
                sum = lane_fma(*SLOT(term[j].slot), *SERIES(term[j].from, k, 0), sum);
            else if (k == 0)
                sum += *SLOT(term[j].slot);
        return sum;
    case SALTUS_TAPE_MULTIPLY:
        return convolve(a, b, k, 0, k);
    case SALTUS_TAPE_SQUARE:
        return convolve_square(a, k);
    case SALTUS_TAPE_DIVIDE:
        return (a[k] - convolve(out, b, k, 0, k - 1)) / b[0];
    case SALTUS_TAPE_CHOOSE:
        return lane_if_less(lane_constant(0), *SLOT(s->first), a[k], b[k]);
    case SALTUS_TAPE_FUNCTION:
        break;
    }
    if (k == 0)
        return function_value(s, a[0], s->a2 < 0 ? a[0] : *SERIES(s->a2, 0, 0));
    sum = convolve_rate(a, b, k, s->linear ? 1 : k);
    if (s->a2 >= 0)
        sum += convolve_rate(SERIES(s->a2, 0, 0), SERIES(s->b2, 0, 0), k, k);
    return sum * (s->sign / k);
}

/* Coefficient k of a step's series along a tangent vector. Registers that do not depend on what the column
 * changes have no series there. */
KERNEL_INLINE lane_t step_tangent(frame f, const saltus_tape_step *s, int k, int c, unsigned changes) {
    const saltus_tape *tape = f.loaded.tape;
    const saltus_tape_term *term = tape->terms + s->first;
    const int direction = direction_of(f, c);
    const lane_t *a = SERIES(s->a, 0, 0), *b = SERIES(s->b, 0, 0), *out = SERIES(s->out, 0, 0);
    const lane_t *da = SERIES(s->a, 0, c), *db = SERIES(s->b, 0, c);
    const bool first = s->code != SALTUS_TAPE_COMBINE && (tape->depends[s->a] & changes);
    const bool second = s->code != SALTUS_TAPE_COMBINE && (tape->depends[s->b] & changes);
    lane_t sum = lane_constant(0);
    switch (s->code) {
    case SALTUS_TAPE_COMBINE:
        for (int j = 0; j < s->count; j++) {
            if (term[j].from >= 0 && (tape->depends[term[j].from] & changes))
                sum = lane_fma(*SLOT(term[j].slot), *SERIES(term[j].from, k, c), sum);
            if (direction >= 0 && term[j].from >= 0)
                sum = lane_fma(*VARY_SLOT(direction, term[j].slot), *SERIES(term[j].from, k, 0), sum);
            else if (direction >= 0 && k == 0)
                sum += *VARY_SLOT(direction, term[j].slot);
        }
        return sum;
    case SALTUS_TAPE_MULTIPLY:
        if (first)
            sum = convolve(da, b, k, 0, k);
        if (second)
            sum += convolve(db, a, k, 0, k);
        return sum;
    case SALTUS_TAPE_SQUARE:
        return 2.0 * convolve(da, a, k, 0, k);
    case SALTUS_TAPE_DIVIDE:
        if (first)
            sum = da[k];
        if (second)
            sum -= convolve(out, db, k, 0, k);
        return (sum - convolve(SERIES(s->out, 0, c), b, k, 0, k - 1)) / b[0];
    case SALTUS_TAPE_CHOOSE:
        return lane_if_less(lane_constant(0), *SLOT(s->first), first ? da[k] : sum, second ? db[k] : sum);
    case SALTUS_TAPE_FUNCTION:
        break;
    }
    if (first)
        sum = convolve(da, b, k, 0, k);
    if (s->a2 >= 0 && (tape->depends[s->a2] & changes))
        sum += convolve(SERIES(s->a2, 0, c), SERIES(s->b2, 0, 0), k, 0, k);
    return sum * s->sign;
}

/* Coefficients k of displacements, velocities and extra states into their registers. */
KERNEL_INLINE void place_states(frame f, int k, int c) {
    const int *place = f.loaded.tape->state_register;
    const saltus_pack *q = JET(f.q, k, c), *v = JET(f.v, k, c);
    const lane_t *e = EXTRA(k, c);
    for (int i = 0; i < f.dof; i++) {
        if (place[i] >= 0)
            *SERIES(place[i], k, c) = row_element(q, i);
        if (place[f.dof + i] >= 0)
            *SERIES(place[f.dof + i], k, c) = row_element(v, i);
    }
    for (int i = 0; i < f.extra; i++)
        if (place[2 * f.dof + i] >= 0)
            *SERIES(place[2 * f.dof + i], k, c) = e[i];
}

/* Parameter columns are tangent vectors that change the slots, too. */
KERNEL_INLINE void model_source(frame f, int k, int c, int d, double inverse, saltus_pack *next) {
    (void)f;
    (void)k;
    (void)c;
    (void)d;
    (void)inverse;
    (void)next;
}

/* Coefficient k + 1 of q' and of the extra states, for the trajectory (c = 0) or a tangent vector. */
KERNEL_INLINE void model_order(frame f, int k, int c, double inverse, saltus_pack *next) {
    const saltus_tape *tape = f.loaded.tape;
    const unsigned changes = direction_of(f, c) >= 0 ? ~0u : (unsigned)SALTUS_OF_STATES;
    place_states(f, k, c);
    for (int j = 0; j < tape->step_count; j++) {
        const saltus_tape_step *s = tape->steps + j;
        if (c == 0)
            *SERIES(s->out, k, 0) = step_value(f, s, k);
        else if (s->depends & changes)
            *SERIES(s->out, k, c) = step_tangent(f, s, k, c, changes);
    }
    for (int p = 0; p < f.packs; p++)
        next[p] = (saltus_pack){0};
    for (int i = 0; i < f.dof + f.extra; i++) {
        const int out = tape->outputs[i];
        const bool moves = c == 0 || (tape->depends[out] & changes);
        lane_t value = lane_constant(0);
        if (moves)
            value = *SERIES(out, k, c) * inverse;
        if (i < f.dof)
            set_row_element(next, i, value);
        else
            EXTRA(k + 1, c)[i - f.dof] = value;
    }
}

#endif
