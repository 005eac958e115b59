/* Steps, impacts, contacts that hold, and sections in the order in which an orbit meets them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "passage.h"

#include <string.h>

enum { trials_most = 400, steps_a_period = 100 };

/* A step under examination: the state alone at tau + h. */
typedef struct trial {
    const step *s;
    const real *x;
    real tau;
    int side;
    real state[model_dimension], rate[model_dimension];
    real gap, speed; /* towards the stop's face */
} trial;

static void look(trial *t, real h) {
    const model *m = t->s->model;
    step_take(t->s, t->tau, h, 1, t->x, t->state);
    t->gap = t->side * model_contact(m, t->state) - m->stop.d;
    t->speed = t->side * model_contact(m, t->state + m->modes);
}

/* The zero in [low, high] of the gap (rising), or of the speed (falling) when `turning`. */
static real zero(trial *t, real low, real high, bool turning) {
    real h = (low + high) / 2, finest = high * real_pow(2, 5 - real_bits);
    for (int k = 0; k < trials_most && high - low > finest; k++) {
        look(t, h);
        real value = turning ? -t->speed : t->gap, slope = t->speed;
        if (turning) {
            model_field(t->s->model, t->tau + h, 1, t->state, t->rate, false);
            slope = -t->side * model_contact(t->s->model, t->rate + t->s->model->modes);
        }
        if (value > 0)
            high = h;
        else
            low = h;
        real next = slope > 0 ? h - value / slope : low;
        if (real_abs(next - h) <= finest)
            return next;
        h = next > low && next < high ? next : (low + high) / 2;
    }
    return h;
}

/* Whether the face `side` is crossed within h; then *at is when. x: state at the step's beginning, end: at h.
 */
static bool crossing(const step *s, int side, real tau, real h, const real *x, const real *end, real *at) {
    const model *m = s->model;
    trial t = {.s = s, .x = x, .tau = tau, .side = side};
    real gap = side * model_contact(m, end) - m->stop.d, top = h;
    real before = side * model_contact(m, x + m->modes), after = side * model_contact(m, end + m->modes);
    if (gap <= 0 && !(before > 0 && after < 0))
        return false;
    if (before > 0 && after < 0) {
        top = zero(&t, 0, h, true);
        look(&t, top);
        if (t.gap <= 0)
            return false;
    }
    *at = zero(&t, 0, top, false);
    return true;
}

/* No step goes over a border of the times that are passed over. */
static real up_to_border(const passage *p, const step *s, real tau, real h) {
    for (int k = 0; k < 4 && p->around > 0; k++) {
        real left = (p->touch[k / 2] + (k % 2 ? p->around : -p->around)) * s->model->period - tau;
        if (left > real_pow(10, -12) && left < h)
            h = left;
    }
    return h;
}

static bool passed_over(const passage *p, const step *s, real tau, real h) {
    real middle = (tau + h / 2) / s->model->period;
    return p->around > 0 &&
           (real_abs(middle - p->touch[0]) < p->around || real_abs(middle - p->touch[1]) < p->around);
}

/* The highest gap of a face between two times, if there is one in between. */
static void look_for_height(passage *p, const step *s, int side, real tau, real h, const real *x,
                            const real *end) {
    const model *m = s->model;
    trial t = {.s = s, .x = x, .tau = tau, .side = side};
    if (!(side * model_contact(m, x + m->modes) > 0 && side * model_contact(m, end + m->modes) < 0))
        return;
    look(&t, zero(&t, 0, h, true));
    p->height = real_max(p->height, t.gap);
}

/* The first contact within h: its side, or 0. */
static int contact(passage *p, const step *s, real tau, real h, const real *x, const real *end, real *at) {
    int side = 0;
    for (int face = 1; face >= -1; face -= 2) {
        real when;
        if (!(face > 0 ? s->model->stop.upper : s->model->stop.lower))
            continue;
        if (passed_over(p, s, tau, h))
            look_for_height(p, s, face, tau, h, x, end);
        else if (crossing(s, face, tau, h, x, end, &when) && (side == 0 || when < *at)) {
            side = face;
            *at = when;
        }
    }
    return side;
}

/* Acceleration into the stop of a state that is not held. */
static real pressing(const model *m, int side, real tau, const real *x) {
    real rate[model_dimension];
    model_field(m, tau, 1, x, rate, false);
    return side * model_contact(m, rate + m->modes);
}

static void hold(step *s, int side) {
    s->held = side;
    s->floor = 1 / (real)1000;
}

/* Apply the impact; *h becomes half the time in which the stop could be met again at the new acceleration. */
static const char *hit(passage *p, step *s, int side, real tau, real *h) {
    const model *m = s->model;
    const real shortest = real_pow(10, -10) * m->period;
    real speed = model_contact(m, p->x + m->modes), press = pressing(m, side, tau, p->x);
    if (p->impact_count == passage_impacts || p->stick_count == passage_sticks)
        return "more impacts or contacts than there is room for";
    if (!(side * speed > 0))
        return "the orbit grazes its stop";
    p->impacts[p->impact_count++] = (impact){side, tau / m->period, speed};
    bool lands = press > 0 && (m->stop.r == 0 || 2 * real_abs(speed) < shortest * press);
    model_impact(m, tau, p->vectors, p->x, lands);
    if (lands) {
        hold(s, side);
        p->sticks[p->stick_count++] = (stick){.side = side, .begin = tau / m->period, .least = HUGE_VAL};
        model_hold(m, side, 1, p->x);
        return NULL;
    }
    press = real_abs(pressing(m, side, tau, p->x));
    real leave = real_abs(model_contact(m, p->x + m->modes));
    if (leave < press * *h)
        *h = leave / press;
    return NULL;
}

/* What presses after a part h of a held step, and with a difference its rate. */
static real pressing_after(const step *s, real tau, real h, const real *x) {
    real state[model_dimension];
    step_take(s, tau, h, 1, x, state);
    return pressing(s->model, s->held, tau + h, state);
}

static real rate_after(const step *s, real tau, real h, const real *x) {
    const real apart = real_pow(10, -12) * s->model->period;
    return (pressing_after(s, tau, h + apart, x) - pressing_after(s, tau, h - apart, x)) / (2 * apart);
}

/* The zero of what presses, or of its rate, between two parts of a step at which they have these values of
 * opposite sign: Illinois' variant of the regula falsi. */
static real held_zero(const step *s, real tau, const real *x,
                      real (*value)(const step *s, real tau, real h, const real *x), real low, real high,
                      real at_low, real at_high) {
    const real finest = high * real_pow(2, 5 - real_bits);
    for (int k = 0, last = 0; k < trials_most && high - low > finest; k++) {
        real h = low + (high - low) * at_low / (at_low - at_high);
        if (!(h > low && h < high))
            break;
        real now = value(s, tau, h, x);
        bool replaces_low = (now > 0) == (at_low > 0);
        if (replaces_low) {
            low = h;
            at_low = now;
            at_high /= last == 1 ? 2 : 1;
        } else {
            high = h;
            at_high = now;
            at_low /= last == -1 ? 2 : 1;
        }
        last = replaces_low ? 1 : -1;
    }
    return real_abs(at_low) < real_abs(at_high) ? low : high;
}

/* Whether a contact that holds lets go within h; then *at is when. */
static bool lets_go(passage *p, const step *s, real tau, real h, const real *x, real *at) {
    real begin = pressing_after(s, tau, 0, x), end = pressing_after(s, tau, h, x), high = h;
    real falls = rate_after(s, tau, 0, x), rises = rate_after(s, tau, h, x);
    if (end > 0 && falls < 0 && rises > 0) {
        high = held_zero(s, tau, x, rate_after, 0, h, falls, rises);
        end = pressing_after(s, tau, high, x);
        real *least = &p->sticks[p->stick_count - 1].least;
        *least = real_min(*least, end);
    }
    if (end > 0)
        return false;
    *at = begin > 0 ? held_zero(s, tau, x, pressing_after, 0, high, begin, end) : 0;
    return true;
}

/* A contact lets go: the state is not to come back to it by rounding. */
static void let_go(passage *p, step *s, real tau, real *h) {
    const model *m = s->model;
    model_hold(m, s->held, 1, p->x);
    p->sticks[p->stick_count - 1].end = tau / m->period;
    s->held = 0;
    p->fresh = true;
    *h = real_min(*h, m->period / 1000);
}

/* From *tau to the section at `end`; *h is the step size proposed. */
static const char *reach(passage *p, step *s, real *tau, real end, real *h) {
    static const long steps_most = 10000000;
    real next[model_dimension * (model_dimension + 1)];
    const size_t size = 2 * (size_t)s->model->modes * p->vectors * sizeof *next;
    for (bool arrived = false; !arrived;) {
        if (++p->steps > steps_most)
            return "too many steps";
        *h = real_min(*h, s->model->period / steps_a_period);
        real taken = up_to_border(p, s, *tau, real_min(*h, end - *tau)),
             error = step_take(s, *tau, taken, p->vectors, p->x, next);
        if (!(error <= 1)) {
            p->refused++;
            *h = step_next(s, taken, error);
            continue;
        }
        real at = taken;
        bool released = s->held && lets_go(p, s, *tau, taken, p->x, &at);
        int side = s->held || p->fresh ? 0 : contact(p, s, *tau, taken, p->x, next, &at);
        p->fresh = false;
        if (side || released)
            step_take(s, *tau, at, p->vectors, p->x, next);
        memcpy(p->x, next, size);
        arrived = !side && !released && taken == end - *tau;
        *tau = arrived ? end : *tau + at;
        if (taken == *h || error > 1 / (real)1000)
            *h = step_next(s, taken, error);
        if (released)
            let_go(p, s, *tau, h);
        const char *trouble = side ? hit(p, s, side, *tau, h) : NULL;
        if (trouble)
            return trouble;
    }
    return NULL;
}

/* A start at a stop, at rest and pressed, is held there. */
static void begin_held(passage *p, step *s) {
    const model *m = s->model;
    const real touching = real_pow(10, -12);
    s->held = 0;
    s->floor = 0;
    for (int side = -1; side <= 1; side += 2) {
        real gap = side * model_contact(m, p->x) - m->stop.d, speed = model_contact(m, p->x + m->modes);
        if ((side > 0 ? m->stop.upper : m->stop.lower) &&
            real_abs(gap) < touching * real_max(m->stop.d, touching) &&
            real_abs(speed) < touching * m->omega * m->stop.d && pressing(m, side, 0, p->x) > 0)
            hold(s, side);
    }
    if (!s->held)
        return;
    p->sticks[p->stick_count++] = (stick){.side = s->held, .least = HUGE_VAL};
    model_hold(m, s->held, p->vectors, p->x);
}

const char *passage_run(passage *p, step *s, int periods, bool tangents, const real *start) {
    const int n = 2 * s->model->modes;
    *p = (passage){.vectors = tangents ? n + 1 : 1,
                   .touch = {p->touch[0], p->touch[1]},
                   .around = p->around,
                   .height = -HUGE_VAL};
    memcpy(p->x, start, n * sizeof *start);
    for (int j = 0; tangents && j < n; j++)
        p->x[n * (1 + j) + j] = 1;
    begin_held(p, s);
    real tau = 0, h = s->model->period / steps_a_period;
    const char *trouble = NULL;
    for (int k = 0; k < periods && !trouble; k++) {
        memcpy(p->section[k], p->x, n * sizeof *start);
        trouble = reach(p, s, &tau, (k + 1) * s->model->period, &h);
    }
    if (s->held)
        p->sticks[p->stick_count - 1].end = periods;
    s->held = 0;
    return trouble;
}
