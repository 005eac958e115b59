/* Periodic orbits of impact oscillators in closed form, in long double, for tests.
 *
 *     x'' + c x' + k x = F cos(omega t) + F0,   k > c^2 / 4,   v -> -r v at x = d, or at x = d and x = -d
 *
 * Orbits of n forcing periods T with one impact, and with stops on both sides (F0 = 0, n odd) mirrored ones,
 * x(t + n T / 2) = -x(t), with one impact on each. One flight of length tau = n T or n T / 2 leads from an
 * impact to the next, or to its mirror image: s = 1 or -1. With its fundamental matrix E and the steady
 * solution (P, Q) at the impact the two matching conditions are
 *
 *     (E - s I) (d - P, -Q) = v (r E + s I) (0, 1),   so   P = d - alpha v,   Q = -beta v.
 *
 * P - F0 / k and Q / omega are the legs of the steady amplitude R: with delta = d - F0 / k
 *
 *     (delta - alpha v)^2 + (beta v / omega)^2 = R^2,
 *
 * a quadratic for the speed v before the impact; its two roots are the two branches. The return matrix is
 * H = s E S with the saltation matrix S = (-r, 0; (1 + r) y / v, -r), y = F cos(omega t) + F0 - k d, and
 * y = -omega^2 delta - v ((k - omega^2) alpha + c beta) on the orbit. A multiplier mu = 1 or -1 of H asks for
 * trace H = mu (1 + det H), which is linear in 1 / v; that v put into the quadratic leaves one equation for
 * one parameter, without a choice of branch. The case delta = 0, where multipliers do not depend on v, and
 * resonance without damping, where E = s I, are left out.
 *
 * One stop: H is the monodromy matrix; mu = 1 is a fold, mu = -1 a flip. Mirrored: the monodromy matrix is
 * H^2. mu = 1 keeps the mirror symmetry: a fold of mirrored orbits. mu = -1 changes its sign from flight to
 * flight: a pitchfork, where a pair of orbits that are not mirrored appears; H^2 has the multiplier 1 in both
 * cases. A multiplier -1 of H^2 asks for +-i of H, so for det H = r^2 exp(-c tau) = 1: with losses a mirrored
 * orbit has no flip.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_CLOSED_ORBITS_H
#define SALTUS_TESTS_CLOSED_ORBITS_H

#include "check.h"

#define CLOSED_PI 3.14159265358979323846264338327950288L

typedef struct closed_oscillator {
    long double c, k, F, F0, omega, d, r;
    int periods;   /* n, of the orbits looked for */
    bool mirrored; /* stops at d and -d, and mirrored orbits between them; otherwise one stop at d */
} closed_oscillator;

typedef struct closed_impact {
    long double time;  /* 0 <= time < n T; with one impact 0 <= time < T */
    long double speed; /* towards the stop, before the impact */
    int side;          /* 1: at d, -1: at -d */
} closed_impact;

typedef struct closed_orbit {
    closed_oscillator oscillator;
    int impacts;
    closed_impact impact[2];      /* by increasing time */
    long double state[2];         /* x, x' at time 0 */
    long double monodromy[4];     /* over n T, from time 0; row-major */
    long double multiplier[2][2]; /* {re, im} by decreasing modulus */
    long double margin;           /* least distance of a turning point from a stop it approaches; negative:
                                     the orbit passes through a stop between its impacts */
    bool admissible;              /* all speeds and the margin are positive */
} closed_orbit;

/* The value named as in a scene: omega, d, F, F0, r, c or k. NULL for any other name. */
static inline long double *closed_value(closed_oscillator *o, const char *key) {
    const char *names[] = {"omega", "d", "F", "F0", "r", "c", "k"};
    long double *values[] = {&o->omega, &o->d, &o->F, &o->F0, &o->r, &o->c, &o->k};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (strcmp(names[i], key) == 0)
            return values[i];
    return NULL;
}

static inline long double closed_period(const closed_oscillator *o) {
    return 2 * CLOSED_PI / o->omega;
}

/* product = a b, 2 x 2; it may be one of them. */
static inline void closed_multiply(const long double *a, const long double *b, long double *product) {
    long double p[4] = {a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3], a[2] * b[0] + a[3] * b[2],
                        a[2] * b[1] + a[3] * b[3]};
    memcpy(product, p, sizeof p);
}

/* Fundamental matrix of the unforced oscillator over a time. */
static inline void closed_fundamental(const closed_oscillator *o, long double time, long double *e) {
    long double decay = o->c / 2, frequency = sqrtl(o->k - decay * decay), size = expl(-decay * time);
    long double cosine = size * cosl(frequency * time), sine = size * sinl(frequency * time) / frequency;
    e[0] = cosine + decay * sine;
    e[1] = sine;
    e[2] = -o->k * sine;
    e[3] = cosine - decay * sine;
}

/* Amplitude R of the steady solution F0 / k + R cos(omega t - lag). */
static inline long double closed_amplitude(const closed_oscillator *o, long double *lag) {
    long double stiff = o->k - o->omega * o->omega, loss = o->c * o->omega;
    *lag = atan2l(o->F * loss, o->F * stiff);
    return fabsl(o->F) / hypotl(stiff, loss);
}

static inline void closed_steady(const closed_oscillator *o, long double time, long double *x) {
    long double lag, amplitude = closed_amplitude(o, &lag), angle = o->omega * time - lag;
    x[0] = o->F0 / o->k + amplitude * cosl(angle);
    x[1] = -amplitude * o->omega * sinl(angle);
}

/* The state at a time from that at another; stops are not heeded. */
static inline void closed_flight(const closed_oscillator *o, long double from, const long double *x0,
                                 long double to, long double *x) {
    long double e[4], p0[2], p[2];
    closed_fundamental(o, to - from, e);
    closed_steady(o, from, p0);
    closed_steady(o, to, p);
    long double y = x0[0] - p0[0], w = x0[1] - p0[1];
    x[0] = p[0] + e[0] * y + e[1] * w;
    x[1] = p[1] + e[2] * y + e[3] * w;
}

static inline void closed_field(const closed_oscillator *o, long double time, const long double *x,
                                long double *rate) {
    rate[0] = x[1];
    rate[1] = o->F * cosl(o->omega * time) + o->F0 - o->c * x[1] - o->k * x[0];
}

/* A time step in which the motion can turn about at most once. */
static inline long double closed_resolution(const closed_oscillator *o) {
    return CLOSED_PI / 64 / (o->omega + sqrtl(o->k));
}

/* Where component i of a flight passes `level` between two times of which it lies on either side. */
static inline long double closed_crossing(const closed_oscillator *o, long double from, const long double *x0,
                                          int i, long double level, long double lo, long double hi) {
    long double x[2];
    closed_flight(o, from, x0, lo, x);
    bool below = x[i] < level;
    for (;;) {
        long double middle = (lo + hi) / 2;
        if (middle <= lo || middle >= hi)
            return middle;
        closed_flight(o, from, x0, middle, x);
        if ((x[i] < level) == below)
            lo = middle;
        else
            hi = middle;
    }
}

/* The first time after `from` at which the flight passes x = d upwards, and the speed there. */
static inline closed_impact closed_next_impact(const closed_oscillator *o, long double from,
                                               const long double *x0) {
    long double step = closed_resolution(o), time = from + step, x[2];
    bool below = false;
    for (closed_flight(o, from, x0, time, x); !below || x[0] < o->d; closed_flight(o, from, x0, time, x)) {
        below = x[0] < o->d;
        time += step;
    }
    time = closed_crossing(o, from, x0, 0, o->d, time - step, time);
    closed_flight(o, from, x0, time, x);
    return (closed_impact){time, x[1], 1};
}

static inline void closed_after(const closed_oscillator *o, const closed_impact *impact, long double *x) {
    x[0] = impact->side * o->d;
    x[1] = -o->r * impact->side * impact->speed;
}

/* A turning point of a flight: its distance from the stop that it approaches, 1: at d, -1: at -d. */
typedef struct closed_turn {
    long double margin, time;
    int side;
} closed_turn;

/* The turning point that comes nearest to a stop. */
static inline closed_turn closed_flight_turn(const closed_oscillator *o, const closed_impact *impact,
                                             long double end) {
    closed_turn nearest = {.margin = INFINITY};
    long double start[2], x[2], step = closed_resolution(o), before;
    long double steps = ceill((end - impact->time) / step), time = impact->time;
    closed_after(o, impact, start);
    before = start[1];
    for (long double i = 1; i <= steps; i++) {
        long double last = time;
        time = impact->time + (end - impact->time) * i / steps;
        closed_flight(o, impact->time, start, time, x);
        long double speed = x[1];
        if ((before > 0) != (speed > 0) && (before > 0 || o->mirrored)) {
            closed_turn turn = {.time = closed_crossing(o, impact->time, start, 1, 0, last, time),
                                .side = before > 0 ? 1 : -1};
            closed_flight(o, impact->time, start, turn.time, x);
            turn.margin = o->d - turn.side * x[0];
            if (turn.margin < nearest.margin)
                nearest = turn;
        }
        before = speed;
    }
    return nearest;
}

static inline void closed_saltation(const closed_oscillator *o, const closed_impact *impact, long double *s) {
    long double x = impact->side * o->d, v = impact->side * impact->speed;
    s[0] = s[3] = -o->r;
    s[1] = 0;
    s[2] = (1 + o->r) * (o->F * cosl(o->omega * impact->time) + o->F0 - o->k * x) / v;
}

/* Eigenvalues of a 2 x 2 matrix by decreasing modulus. */
static inline void closed_eigenvalues(const long double *m, long double (*value)[2]) {
    long double half = (m[0] + m[3]) / 2, determinant = m[0] * m[3] - m[1] * m[2];
    long double discriminant = half * half - determinant;
    if (discriminant < 0) {
        value[0][0] = value[1][0] = half;
        value[0][1] = sqrtl(-discriminant);
        value[1][1] = -value[0][1];
        return;
    }
    value[0][0] = half + copysignl(sqrtl(discriminant), half);
    value[1][0] = determinant / value[0][0];
    value[0][1] = value[1][1] = 0;
}

/* Impacts -> all else of the orbit. */
static inline void closed_complete(closed_orbit *orbit) {
    const closed_oscillator *o = &orbit->oscillator;
    closed_impact *impact = orbit->impact;
    long double length = o->periods * closed_period(o), e[4], s[4], x[2], time = 0;
    long double m[4] = {1, 0, 0, 1};
    for (int i = 0; i < orbit->impacts; i++)
        impact[i].time -= length * floorl(impact[i].time / length);
    if (orbit->impacts == 2 && impact[0].time > impact[1].time) {
        closed_impact first = impact[1];
        impact[1] = impact[0];
        impact[0] = first;
    }
    orbit->margin = INFINITY;
    orbit->admissible = true;
    for (int i = 0; i < orbit->impacts; i++) {
        closed_fundamental(o, impact[i].time - time, e);
        closed_saltation(o, &impact[i], s);
        closed_multiply(e, m, m);
        closed_multiply(s, m, m);
        time = impact[i].time;
        long double next = i + 1 < orbit->impacts ? impact[i + 1].time : impact[0].time + length;
        orbit->margin = fminl(orbit->margin, closed_flight_turn(o, &impact[i], next).margin);
        orbit->admissible = orbit->admissible && impact[i].speed > 0;
    }
    orbit->admissible = orbit->admissible && orbit->margin > 0;
    closed_fundamental(o, length - time, e);
    closed_multiply(e, m, orbit->monodromy);
    closed_eigenvalues(orbit->monodromy, orbit->multiplier);
    closed_after(o, &impact[orbit->impacts - 1], x);
    closed_flight(o, time, x, length, orbit->state);
}

/* What one flight makes of an orbit: P = d - alpha u, Q = -beta u with u = v / determinant. */
typedef struct closed_return {
    long double e[4], alpha, beta, determinant, delta, amplitude, lag;
    int sign;
} closed_return;

static inline closed_return closed_return_of(const closed_oscillator *o) {
    closed_return h = {.sign = o->mirrored ? -1 : 1, .delta = o->d - o->F0 / o->k};
    const long double *e = h.e;
    long double tau = o->periods * closed_period(o) / (o->mirrored ? 2 : 1);
    closed_fundamental(o, tau, h.e);
    h.amplitude = closed_amplitude(o, &h.lag);
    /* (E - s I)^-1 (r E + s I) (0, 1) */
    long double a = o->r * e[1], b = o->r * e[3] + h.sign;
    h.alpha = (e[3] - h.sign) * a - e[1] * b;
    h.beta = (e[0] - h.sign) * b - e[2] * a;
    h.determinant = (e[0] - h.sign) * (e[3] - h.sign) - e[1] * e[2];
    return h;
}

/* The orbit whose impact at d has that speed, known to satisfy the quadratic. */
static inline closed_orbit closed_orbit_of(const closed_oscillator *o, long double speed) {
    closed_return h = closed_return_of(o);
    closed_orbit orbit = {.oscillator = *o, .impacts = o->mirrored ? 2 : 1};
    long double u = speed / h.determinant, period = closed_period(o);
    long double time = (atan2l(h.beta * u / o->omega, h.delta - h.alpha * u) + h.lag) / o->omega;
    time -= period * floorl(time / period);
    orbit.impact[0] = (closed_impact){time, speed, 1};
    orbit.impact[1] = (closed_impact){time + o->periods * period / 2, speed, -1};
    closed_complete(&orbit);
    return orbit;
}

/* The orbit on a branch: +1 the larger speed, -1 the smaller. False: there is none. A speed that is not
 * positive is no impact; the orbit then solves the matching conditions only. */
static inline bool closed_orbit_at(const closed_oscillator *o, int branch, closed_orbit *orbit) {
    *orbit = (closed_orbit){.oscillator = *o};
    closed_return h = closed_return_of(o);
    long double leg = h.beta / o->omega, a = h.alpha * h.alpha + leg * leg, b = h.alpha * h.delta;
    long double rest = (h.delta - h.amplitude) * (h.delta + h.amplitude);
    long double discriminant = h.amplitude * h.amplitude * a - h.delta * h.delta * leg * leg;
    if (!(discriminant >= 0))
        return false;
    long double sum = b + copysignl(sqrtl(discriminant), b);
    long double u = (branch > 0) == (b >= 0) ? sum / a : rest / sum;
    *orbit = closed_orbit_of(o, u * h.determinant);
    return true;
}

/* The speed at which H has the multiplier mu = 1 or -1, as the fraction u = top / bottom. */
static inline void closed_critical_speed(const closed_oscillator *o, const closed_return *h, int mu,
                                         long double *top, long double *bottom) {
    const long double *e = h->e;
    long double det = o->r * o->r * (e[0] * e[3] - e[1] * e[2]), square = o->omega * o->omega;
    *top = -e[1] * (1 + o->r) * square * h->delta;
    *bottom = (h->sign * mu * (1 + det) + o->r * (e[0] + e[3])) * h->determinant +
              e[1] * (1 + o->r) * ((o->k - square) * h->alpha + o->c * h->beta);
}

typedef long double closed_function(const closed_oscillator *o, int choice);

/* Zero where an orbit's H has the multiplier mu. */
static inline long double closed_critical(const closed_oscillator *o, int mu) {
    closed_return h = closed_return_of(o);
    long double top, bottom, leg = h.beta / o->omega;
    closed_critical_speed(o, &h, mu, &top, &bottom);
    return powl(h.delta * bottom - h.alpha * top, 2) + powl(leg * top, 2) - powl(h.amplitude * bottom, 2);
}

/* Zero where the free response touches the stop at d. */
static inline long double closed_clearance(const closed_oscillator *o, int unused) {
    (void)unused;
    closed_return h = closed_return_of(o);
    return h.delta - h.amplitude;
}

/* Zero where the orbit on a branch touches a stop between its impacts. */
static inline long double closed_margin(const closed_oscillator *o, int branch) {
    closed_orbit orbit;
    return closed_orbit_at(o, branch, &orbit) ? orbit.margin : NAN;
}

/* Set the parameter `key` to the zero of a function between two values where its signs differ. */
static inline bool closed_solve(closed_oscillator *o, const char *key, long double lo, long double hi,
                                closed_function *function, int choice) {
    long double *value = closed_value(o, key), begin, end, middle;
    *value = lo;
    begin = function(o, choice);
    *value = hi;
    end = function(o, choice);
    if (isnan(begin) || isnan(end) || (begin < 0) == (end < 0))
        return false;
    for (;;) {
        *value = (lo + hi) / 2;
        if (*value <= fminl(lo, hi) || *value >= fmaxl(lo, hi))
            return true;
        middle = function(o, choice);
        if (isnan(middle))
            return false;
        if ((middle < 0) == (begin < 0))
            lo = *value;
        else
            hi = *value;
    }
}

static inline bool closed_multiplier_point(closed_oscillator o, const char *key, long double lo,
                                           long double hi, int mu, closed_orbit *orbit) {
    *orbit = (closed_orbit){.oscillator = o};
    if (!closed_solve(&o, key, lo, hi, closed_critical, mu))
        return false;
    long double top, bottom;
    closed_return h = closed_return_of(&o);
    closed_critical_speed(&o, &h, mu, &top, &bottom);
    *orbit = closed_orbit_of(&o, top / bottom * h.determinant);
    return true;
}

/* The points of the branches of orbits in the parameter `key` between two values; orbit->oscillator holds the
 * value found. False: the two values do not lie on either side of one. */

/* A multiplier 1 of orbits with one stop, or of mirrored orbits among themselves. */
static inline bool closed_fold(const closed_oscillator *o, const char *key, long double lo, long double hi,
                               closed_orbit *orbit) {
    return closed_multiplier_point(*o, key, lo, hi, 1, orbit);
}

/* A multiplier -1 of orbits with one stop. */
static inline bool closed_flip(const closed_oscillator *o, const char *key, long double lo, long double hi,
                               closed_orbit *orbit) {
    *orbit = (closed_orbit){.oscillator = *o};
    return !o->mirrored && closed_multiplier_point(*o, key, lo, hi, -1, orbit);
}

/* A mirrored orbit loses its symmetry. */
static inline bool closed_pitchfork(const closed_oscillator *o, const char *key, long double lo,
                                    long double hi, closed_orbit *orbit) {
    *orbit = (closed_orbit){.oscillator = *o};
    return o->mirrored && closed_multiplier_point(*o, key, lo, hi, -1, orbit);
}

/* v = 0 at the impact: the orbit is the free response, which touches the stop; its monodromy matrix is
 * infinite. */
static inline bool closed_grazing(const closed_oscillator *o, const char *key, long double lo, long double hi,
                                  closed_orbit *orbit) {
    closed_oscillator found = *o;
    *orbit = (closed_orbit){.oscillator = *o};
    if (!closed_solve(&found, key, lo, hi, closed_clearance, 0))
        return false;
    *orbit = closed_orbit_of(&found, 0);
    return true;
}

/* The orbit on a branch touches a stop between its impacts. */
static inline bool closed_touch(const closed_oscillator *o, const char *key, long double lo, long double hi,
                                int branch, closed_orbit *orbit) {
    closed_oscillator found = *o;
    *orbit = (closed_orbit){.oscillator = *o};
    return closed_solve(&found, key, lo, hi, closed_margin, branch) && closed_orbit_at(&found, branch, orbit);
}

/* Orbits between two stops that are not mirrored: unknowns z = (t1, v1, t2, v2), the impact at d and the one
 * at -d that follows it. */

/* The two conditions of the first or second flight and their derivatives, as they stand in rows of `width`
 * numbers. */
static inline void closed_pair_flight(const closed_oscillator *o, const long double *z, int second,
                                      long double *residual, long double *rows, int width) {
    int from = second ? 2 : 0, to = second ? 0 : 2;
    long double end = z[to] + (second ? o->periods * closed_period(o) : 0);
    closed_impact impact = {z[from], z[from + 1], second ? -1 : 1};
    long double start[2], x[2], e[4], rate[2], last[2];
    closed_after(o, &impact, start);
    closed_flight(o, z[from], start, end, x);
    closed_fundamental(o, end - z[from], e);
    closed_field(o, z[from], start, rate);
    closed_field(o, end, x, last);
    residual[0] = x[0] + impact.side * o->d;
    residual[1] = x[1] + impact.side * z[to + 1];
    for (int i = 0; i < 2; i++) {
        rows[i * width + from] = -(e[2 * i] * rate[0] + e[2 * i + 1] * rate[1]);
        rows[i * width + from + 1] = -o->r * impact.side * e[2 * i + 1];
        rows[i * width + to] = last[i];
        rows[i * width + to + 1] = i * impact.side;
    }
}

enum { closed_pair_size = 5 };

/* The four conditions, and as the fifth the skew n / 2 - (t2 - t1) / T. */
static inline void closed_pair_residual(const closed_oscillator *o, const long double *z, long double skew,
                                        long double *residual, long double *rows) {
    int n = closed_pair_size;
    closed_pair_flight(o, z, 0, residual, rows, n);
    closed_pair_flight(o, z, 1, residual + 2, rows + 2 * n, n);
    residual[4] = o->periods / 2.0L - (z[2] - z[0]) / closed_period(o) - skew;
    rows[4 * n] = 1 / closed_period(o);
    rows[4 * n + 2] = -rows[4 * n];
    rows[4 * n + 1] = rows[4 * n + 3] = 0;
}

/* Solve a x = b, n x n, by elimination with row pivots; b becomes x. */
static inline bool closed_linear(long double *a, long double *b, int n) {
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (fabsl(a[i * n + k]) > fabsl(a[pivot * n + k]))
                pivot = i;
        if (!(fabsl(a[pivot * n + k]) > 0))
            return false;
        for (int j = 0; j <= n; j++) {
            long double *one = j < n ? &a[k * n + j] : &b[k], *other = j < n ? &a[pivot * n + j] : &b[pivot];
            long double held = *one;
            *one = *other;
            *other = held;
        }
        for (int i = k + 1; i < n; i++) {
            long double factor = a[i * n + k] / a[k * n + k];
            for (int j = k; j < n; j++)
                a[i * n + j] -= factor * a[k * n + j];
            b[i] -= factor * b[k];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++)
            b[i] -= a[i * n + j] * b[j];
        b[i] /= a[i * n + i];
    }
    return true;
}

/* A Newton step for z and, as fifth unknown, the parameter, whose column is made of differences: that costs
 * Newton nothing but a little speed. The change of z is returned; NAN when there is no step. */
static inline long double closed_pair_step(closed_oscillator *o, const char *key, long double *z,
                                           long double skew) {
    enum { n = closed_pair_size };
    long double rows[n * n], unused[n * n], residual[n], low[n], high[n], change = 0;
    long double *value = closed_value(o, key), centre = *value, step = 1e-6L * (1 + fabsl(centre));
    closed_pair_residual(o, z, skew, residual, rows);
    *value = centre - step;
    closed_pair_residual(o, z, skew, low, unused);
    *value = centre + step;
    closed_pair_residual(o, z, skew, high, unused);
    for (int i = 0; i < n; i++)
        rows[i * n + 4] = (high[i] - low[i]) / (2 * step);
    if (!closed_linear(rows, residual, n))
        return NAN;
    for (int i = 0; i < 4; i++) {
        z[i] -= residual[i];
        change = fmaxl(change, fabsl(residual[i]));
    }
    *value = centre - residual[4];
    return change;
}

/* From an orbit near by to the one of a given skew. */
static inline bool closed_pair_skewed(const closed_orbit *beside, const char *key, long double skew,
                                      closed_orbit *orbit) {
    closed_oscillator o = beside->oscillator;
    int first = beside->impact[0].side > 0 ? 0 : 1;
    const closed_impact *upper = &beside->impact[first], *lower = &beside->impact[1 - first];
    long double z[4] = {upper->time, upper->speed, lower->time, lower->speed}, change = 1, last = 2;
    if (z[2] < z[0])
        z[2] += o.periods * closed_period(&o);
    *orbit = (closed_orbit){.oscillator = o};
    for (int k = 0; k < 60 && (change > 1e-14L || change < last / 2); k++) {
        last = change;
        change = closed_pair_step(&o, key, z, skew);
        if (!(change < 1))
            return false;
    }
    if (change > 1e-14L)
        return false;
    *orbit = (closed_orbit){.oscillator = o, .impacts = 2, .impact = {{z[0], z[1], 1}, {z[2], z[3], -1}}};
    closed_complete(orbit);
    return true;
}

/* What the walk along a pair's branch looks for a zero of. */
typedef long double closed_pair_function(const closed_orbit *orbit, const char *key, long double aim);

static inline long double closed_pair_value(const closed_orbit *orbit, const char *key, long double aim) {
    closed_oscillator o = orbit->oscillator;
    return *closed_value(&o, key) - aim;
}

/* Zero where a multiplier is `aim` = 1 or -1. */
static inline long double closed_pair_critical(const closed_orbit *orbit, const char *key, long double aim) {
    (void)key;
    const long double *m = orbit->monodromy;
    return 1 - aim * (m[0] + m[3]) + m[0] * m[3] - m[1] * m[2];
}

static inline long double closed_pair_margin(const closed_orbit *orbit, const char *key, long double aim) {
    (void)key;
    return orbit->margin - aim;
}

/* Walk from a pitchfork along one orbit of the pair, with skew of the sign of `side` (the other orbit is its
 * mirror image, shifted by n T / 2), to the first zero of a function. False: none before the skew turns back
 * or reaches 1/2. */
static inline bool closed_pair_walk(const closed_orbit *pitchfork, const char *key, int side,
                                    closed_pair_function *function, long double aim, closed_orbit *orbit) {
    long double step = side / 512.0L, lo = 0, hi = step;
    closed_orbit last = *pitchfork;
    if (!closed_pair_skewed(&last, key, hi, orbit))
        return false;
    bool below = function(&last, key, aim) < 0;
    while ((function(orbit, key, aim) < 0) == below) {
        last = *orbit;
        lo = hi;
        hi += step;
        if (fabsl(hi) > 0.5L || !closed_pair_skewed(&last, key, hi, orbit))
            return false;
    }
    for (;;) {
        long double skew = (lo + hi) / 2;
        if (skew <= fminl(lo, hi) || skew >= fmaxl(lo, hi))
            return true;
        if (!closed_pair_skewed(&last, key, skew, orbit))
            return false;
        if ((function(orbit, key, aim) < 0) == below)
            lo = skew;
        else
            hi = skew;
    }
}

/* The orbit of a pair at a value of the parameter beyond the pitchfork. */
static inline bool closed_pair_at(const closed_orbit *pitchfork, const char *key, int side, long double value,
                                  closed_orbit *orbit) {
    return closed_pair_walk(pitchfork, key, side, closed_pair_value, value, orbit);
}

static inline bool closed_pair_flip(const closed_orbit *pitchfork, const char *key, int side,
                                    closed_orbit *orbit) {
    return closed_pair_walk(pitchfork, key, side, closed_pair_critical, -1, orbit);
}

/* An orbit of the pair touches a stop between its impacts. */
static inline bool closed_pair_touch(const closed_orbit *pitchfork, const char *key, int side,
                                     closed_orbit *orbit) {
    return closed_pair_walk(pitchfork, key, side, closed_pair_margin, 0, orbit);
}

/* Ball on a vibrating table, height above it: y'' = -1 + gamma cos t, y > 0, restitution r. Orbits of k
 * periods with one impact: a flight of 2 pi k from phase p with speed u after the impact comes back with the
 * speed 2 pi k - u when u = k pi + gamma sin p. They begin, by a fold, at gamma = k pi (1 - r) / (1 + r). */
typedef struct closed_table {
    long double phase, speed; /* speed before the impact */
    long double state[2];     /* y, y' at time 0 */
    long double multiplier[2][2];
} closed_table;

static inline long double closed_table_fold(int k, long double r) {
    return k * CLOSED_PI * (1 - r) / (1 + r);
}

static inline long double closed_table_flip(int k, long double r) {
    return hypotl(closed_table_fold(k, r), 2 * (1 + r * r) / ((1 + r) * (1 + r)));
}

/* The orbit, on the branch with cos p > 0 (+1, stable at first) or < 0 (-1). */
static inline bool closed_table_orbit(int k, long double r, long double gamma, int branch,
                                      closed_table *orbit) {
    long double sine = -closed_table_fold(k, r) / gamma;
    *orbit = (closed_table){.speed = 0};
    if (fabsl(sine) > 1)
        return false;
    long double cosine = branch * sqrtl((1 - sine) * (1 + sine)), p = atan2l(sine, cosine);
    orbit->phase = p < 0 ? p + 2 * CLOSED_PI : p;
    orbit->speed = 2 * k * CLOSED_PI / (1 + r);
    long double time = 2 * k * CLOSED_PI - orbit->phase, u = r * orbit->speed;
    orbit->state[0] = u * time - time * time / 2 + gamma * (cosine - 1) - gamma * sine * time;
    orbit->state[1] = u - time - gamma * sine;
    long double trace = -2 * r + (1 + r) * (1 + r) * (1 - gamma * cosine);
    long double companion[4] = {trace, -r * r, 1, 0};
    closed_eigenvalues(companion, orbit->multiplier);
    return true;
}

/* Undamped oscillator x'' + x = cos(omega t) with a stop at x = s (Budd & Dux): one impact in n periods. */
typedef struct closed_undamped {
    long double g, cs, q;
} closed_undamped;

static inline closed_undamped closed_undamped_of(int n, long double omega, long double r) {
    long double length = 2 * CLOSED_PI * n / omega;
    return (closed_undamped){1 / (1 - omega * omega), (1 + r) / tanl(length / 2), (1 - r) / omega};
}

/* The position of the stop at which the two orbits meet. */
static inline long double closed_undamped_fold(int n, long double omega, long double r) {
    closed_undamped b = closed_undamped_of(n, omega, r);
    return b.g * hypotl(1, b.cs / b.q);
}

static inline long double closed_undamped_speed(int n, long double omega, long double r, long double s,
                                                int branch) {
    closed_undamped b = closed_undamped_of(n, omega, r);
    long double a = b.cs * b.cs + b.q * b.q;
    long double root = sqrtl(b.g * b.g * b.cs * b.cs - (s - b.g) * (s + b.g) * b.q * b.q);
    return (-2 * b.cs * s + branch * 2 * root) / a;
}

/* Oscillators whose branches in omega have all the points that continuation looks for; the values are those
 * that the functions above give. k = 1 unless said. */
typedef enum closed_example {
    closed_one_period,        /* GR 0.71069 - PD 0.96056 - LP 1.57157 - GR 1.21857 */
    closed_one_period_loaded, /* k = 1.5: GR 0.94091 - PD 1.12204 - LP 1.66414 - GR 1.44038 */
    closed_two_periods,       /* GR 0.79721 - LP 0.79693 - PD 0.93540 - PD 0.95872 - touch 0.99061 */
    closed_two_periods_light, /* GR 0.79901 - LP 0.79886 - PD 0.90662 - PD 0.99013 - touch 0.99611 */
    closed_mirrored,          /* BP 3.49858; the pair: PD 2.72438 - touch 2.62369 */
    closed_mirrored_bubble    /* GR 1.56514 - LP 3.75482 - BP 1.17729 - BP 1.10135, joined by the pair */
} closed_example;

static inline closed_oscillator closed_example_of(closed_example example) {
    static const closed_oscillator table[] = {
        [closed_one_period] = {.c = 0.1L, .k = 1, .F = 0.5L, .d = 1, .r = 0.8L, .periods = 1},
        [closed_one_period_loaded] =
            {.c = 0.2L, .k = 1.5L, .F = 0.6L, .F0 = 0.1L, .d = 1, .r = 0.6L, .periods = 1},
        [closed_two_periods] = {.c = 0.08L, .k = 1, .F = 0.37L, .F0 = -1, .r = 0.9L, .periods = 2},
        [closed_two_periods_light] = {.c = 0.04L, .k = 1, .F = 0.363L, .F0 = -1, .r = 0.9L, .periods = 2},
        [closed_mirrored] = {.c = 0.2L, .k = 1, .F = 9, .d = 1, .r = 0.8L, .periods = 1, .mirrored = true},
        [closed_mirrored_bubble] = {
            .c = 0.02L, .k = 1, .F = 1.45L, .d = 1, .r = 0.7L, .periods = 1, .mirrored = true}};
    closed_oscillator o = table[example];
    o.omega = 1;
    return o;
}

/* The same oscillator as a specification. */
static inline saltus_spec closed_spec(const closed_oscillator *o) {
    saltus_spec spec = oscillator_spec((double)o->c, (double)o->k, (double)o->F, (double)o->omega);
    set_parameter(&spec, "F0", (double)o->F0);
    add_stop(&spec, (double)o->d, (double)o->r, o->mirrored ? SALTUS_BOTH : SALTUS_UPPER);
    return spec;
}

#endif
