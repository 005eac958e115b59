/* Orbits of closed_orbits.h's oscillator that come to rest on one stop, from closed flights, for tests.
 *
 * While the force F cos(omega t) + F0 - k d presses, a mass at rest on the stop stays; it leaves where that
 * force falls through zero, at the same phase of every period. All that went before is forgotten: what
 * happens from one release to the next is the orbit, whatever came to rest. Without rebound (r = 0) every
 * impact under pressure does so; with r > 0 complete chatter does.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_CLOSED_STICKING_H
#define SALTUS_TESTS_CLOSED_STICKING_H

#include "closed_orbits.h"

enum { closed_sticking_periods = 8, closed_sticking_impacts = 64 };

typedef struct closed_sticking {
    int periods, impacts;     /* with chatter: those that were made one by one */
    bool chatter;             /* the rest began by chatter */
    long double impact_speed; /* of the first impact, ... */
    long double impact_time;  /* ... from the start of the period in which the flight begins */
    long double release;      /* time of the release, 0 <= release < T */
    long double state[closed_sticking_periods][2]; /* at 0, T, ... */
    long double largest, smallest;
} closed_sticking;

static inline long double closed_pressure(const closed_oscillator *o, long double time) {
    return o->F * cosl(o->omega * time) + o->F0 - o->k * o->d;
}

/* States at whole periods, and extremes, of a flight. */
static inline void closed_see_flight(const closed_oscillator *o, closed_sticking *s, long double from,
                                     const long double *x0, long double to) {
    enum { pieces = 2048 };
    long double period = closed_period(o), x[2];
    for (int k = (int)ceill(from / period); k < closed_sticking_periods && (long double)k * period < to; k++)
        closed_flight(o, from, x0, (long double)k * period, s->state[k]);
    for (int i = 0; i <= pieces; i++) {
        closed_flight(o, from, x0, from + (to - from) * i / pieces, x);
        s->smallest = fminl(s->smallest, x[0]);
        s->largest = fmaxl(s->largest, x[0]);
    }
}

/* The first impact of a flight after `from`, however short it is; of speed 0 where it is too long. */
static inline closed_impact closed_bounce(const closed_oscillator *o, long double from,
                                          const long double *x0) {
    long double x[2], rate[2];
    closed_field(o, from, x0, rate);
    long double guess = rate[1] > 0 ? -2 * x0[1] / rate[1] : INFINITY, time = from + guess;
    if (!(guess > 0 && guess < 4 * closed_resolution(o))) {
        long double until = from, limit = from + closed_sticking_periods * closed_period(o);
        do
            closed_flight(o, from, x0, until += closed_resolution(o), x);
        while (x[0] < o->d && until < limit);
        return until < limit ? closed_next_impact(o, from, x0) : (closed_impact){limit, 0, 1};
    }
    for (int k = 0; k < 20; k++) {
        closed_flight(o, from, x0, time, x);
        time -= (x[0] - o->d) / x[1];
    }
    return (closed_impact){time, x[1], 1};
}

/* From a release to the next one; `periods` is 0 where that takes too long. */
static inline closed_sticking closed_sticking_of(const closed_oscillator *o) {
    closed_sticking s = {
        .release = acosl((o->k * o->d - o->F0) / o->F) / o->omega, .largest = o->d, .smallest = o->d};
    long double period = closed_period(o), x[2] = {o->d, 0}, time = s.release;
    bool resting = false;
    while (!resting) {
        closed_impact impact = closed_bounce(o, time, x);
        closed_see_flight(o, &s, time, x, impact.time);
        if (s.impacts == 0) {
            s.impact_speed = impact.speed;
            s.impact_time = impact.time;
        }
        time = impact.time;
        if (++s.impacts >= closed_sticking_impacts || time > (closed_sticking_periods - 1) * period)
            return s;
        closed_after(o, &impact, x);
        resting = closed_pressure(o, time) > 0 && o->r * impact.speed < 1e-13L;
    }
    s.chatter = o->r > 0;
    int first = (int)ceill(time / period);
    s.periods = (int)ceill((time - s.release) / period);
    for (int k = first; k <= s.periods && k < closed_sticking_periods; k++) {
        s.state[k][0] = o->d;
        s.state[k][1] = 0;
    }
    /* The orbit at 0 is what it is after its last period. */
    memcpy(s.state[0], s.state[s.periods], sizeof s.state[0]);
    return s;
}

/* An oscillator with such orbits. */
static inline closed_oscillator closed_sticking_example(long double omega, long double F0, long double r) {
    return (closed_oscillator){
        .c = 0.1L, .k = 1, .F = 1, .F0 = F0, .omega = omega, .d = 0.3L, .r = r, .periods = 1};
}

#endif
