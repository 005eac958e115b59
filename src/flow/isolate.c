/* Zeros of a step's polynomial; isolate.h describes the method.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/isolate.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { depth_max = 60 };

/* A piece of the polynomial on [lo, hi]: Bernstein coefficients of p, p' and p''. The derivatives are
 * subdivided on their own, because differences of p's coefficients drown in rounding on short intervals. */
typedef struct piece {
    double lo, hi;
    double p[3][SALTUS_DEGREE_MAX + 1];
} piece;

/* The high half of a double's digits, so that products of halves are exact (Veltkamp). */
static inline double high_half(double a) {
    double shifted = 134217729.0 * a;
    return shifted - (shifted - a);
}

/* Products' errors by Dekker's formula: a call of fma would cost more where the instruction set lacks it. */
double saltus_compensated(const double *c, int degree, double s) {
    double sum = c[degree], error = 0, s_high = high_half(s), s_low = s - s_high;
    for (int k = degree - 1; k >= 0; k--) {
        double high = high_half(sum), low = sum - high, product = sum * s;
        double product_error = ((high * s_high - product) + high * s_low + low * s_high) + low * s_low;
        double next = product + c[k], part = next - product;
        double sum_error = (product - (next - part)) + (c[k] - part);
        sum = next;
        error = error * s + (product_error + sum_error);
    }
    return sum + error;
}

/* The factor of c_k in p, p' or p'', for a `number` k. */
static inline double factor_of(double number, int derivative) {
    return derivative == 0 ? 1 : derivative == 1 ? number : number * (number - 1);
}

/* The terms of p, p' or p'': of order k - derivative at t[k]. */
static inline void terms_of(const double *c, int degree, int derivative, double *t) {
    double number = derivative;
    for (int k = derivative; k <= degree; k++, number += 1)
        t[k] = c[k] * factor_of(number, derivative);
}

/* The sum of terms first .. degree by Horner's rule, even and odd ones in two chains. */
static inline double sum_of_terms(const double *t, int degree, int first, double s) {
    const double square = s * s;
    double even = 0, odd = 0;
    int k = degree;
    for (; k > first; k -= 2) {
        even = even * square + t[k];
        odd = odd * square + t[k - 1];
    }
    return k == first ? (even * s + odd) * s + t[k] : even * s + odd;
}

/* p, p' or p'' at one place. */
static double horner(const double *c, int degree, int derivative, double s) {
    double t[SALTUS_DEGREE_MAX + 1];
    if (derivative == 0)
        return sum_of_terms(c, degree, 0, s);
    terms_of(c, degree, derivative, t);
    return sum_of_terms(t, degree, derivative, s);
}

/* b_j = sum_k C(j,k) / C(n,k) a_k. */
static void to_bernstein(const double *a, int n, double *b) {
    double inverse[SALTUS_DEGREE_MAX + 1];
    for (int k = 1; k <= n; k++)
        inverse[k] = 1.0 / k;
    for (int j = 0; j <= n; j++) {
        double weight = 1;
        b[j] = a[0];
        for (int k = 1; k <= j; k++) {
            weight *= (j - k + 1) * inverse[n - k + 1];
            b[j] += weight * a[k];
        }
    }
}

/* Bernstein coefficients of p's derivative of order d on [0, 1]. */
static void derivative_to_bernstein(const double *c, int degree, int d, double *b) {
    double a[SALTUS_DEGREE_MAX + 1];
    for (int k = d; k <= degree; k++)
        a[k - d] = c[k] * factor_of(k, d);
    to_bernstein(a, degree - d, b);
}

/* de Casteljau at one half; `left` becomes the left half, `right` the right one. */
static void halve(piece *left, piece *right, int degree) {
    double middle = 0.5 * (left->lo + left->hi);
    right->lo = middle;
    right->hi = left->hi;
    left->hi = middle;
    for (int d = 0; d < 3; d++) {
        int n = degree - d;
        double *b = left->p[d];
        for (int j = 0; j <= n; j++) {
            right->p[d][n - j] = b[n];
            for (int k = n; k > j; k--)
                b[k] = 0.5 * (b[k - 1] + b[k]);
        }
    }
}

/* +1 if no coefficient is negative, -1 if none is positive, 0 otherwise. */
static int common_sign(const double *b, int n) {
    double low = 0, high = 0;
    for (int k = 0; k <= n; k++) {
        low = fmin(low, b[k]);
        high = fmax(high, b[k]);
    }
    return low >= 0 ? 1 : high <= 0 ? -1 : 0;
}

/* The zero of the `derivative`-th derivative on [lo, hi], where it changes sign once, from its values there:
 * Newton, kept in the bracket. The last steps of a zero of p itself use the compensated value. */
static double bracketed_zero(const double *c, int degree, int derivative, double lo, double hi, double at_lo,
                             double at_hi) {
    double rising = at_hi >= at_lo ? 1 : -1, s = lo + (hi - lo) * (at_lo / (at_lo - at_hi));
    if (!(s > lo && s < hi))
        s = 0.5 * (lo + hi);
    double own[SALTUS_DEGREE_MAX + 1], slopes[SALTUS_DEGREE_MAX + 1];
    const double *values = derivative > 0 ? own : c;
    bool fine = false;
    if (derivative > 0)
        terms_of(c, degree, derivative, own);
    terms_of(c, degree, derivative + 1, slopes);
    for (int k = 0; k < 100 && hi - lo > DBL_EPSILON * fabs(hi); k++) {
        double value = fine && derivative == 0 ? saltus_compensated(c, degree, s)
                                               : sum_of_terms(values, degree, derivative, s);
        double slope = sum_of_terms(slopes, degree, derivative + 1, s);
        if (rising * value < 0)
            lo = s;
        else
            hi = s;
        double next = s - value / slope;
        bool inside = next >= lo && next <= hi;
        double moved = fabs(next - s);
        s = inside ? next : 0.5 * (lo + hi);
        if (inside && fine && moved <= 4 * DBL_EPSILON * fabs(s))
            break;
        fine = fine || (inside && moved <= 1e-7 * fabs(s));
    }
    return s;
}

/* Whether p is positive just after its zero s: the sign of the first Taylor coefficient there that exceeds
 * rounding. */
static bool positive_after(const double *c, int degree, double s) {
    double shifted[SALTUS_DEGREE_MAX + 1], size = 0;
    memcpy(shifted, c, (size_t)(degree + 1) * sizeof *c);
    for (int k = 0; k <= degree; k++)
        size += fabs(c[k]);
    for (int d = 0; d <= degree; d++) {
        for (int k = degree - 1; k >= d; k--)
            shifted[k] += s * shifted[k + 1];
        if (d > 0 && fabs(shifted[d]) > 1e-14 * (d + 1) * size)
            return shifted[d] > 0;
    }
    return false;
}

/* p(s), evaluated with compensation if `noise` may hide its sign. */
static double signed_value(const double *c, int degree, double noise, double s) {
    double value = s > 0 ? horner(c, degree, 0, s) : c[0];
    return s > 0 && !(fabs(value) > noise) ? saltus_compensated(c, degree, s) : value;
}

/* p does not fall on [lo, hi]: find a zero in (lo, hi] at which it rises. */
static bool rise_between(const double *c, int degree, double noise, double lo, double hi, double *root) {
    double at_lo = signed_value(c, degree, noise, lo), at_hi = signed_value(c, degree, noise, hi);
    if (!(at_lo < 0) || !(at_hi >= 0) || (at_hi == 0 && !positive_after(c, degree, hi)))
        return false;
    *root = at_hi == 0 ? hi : bracketed_zero(c, degree, 0, lo, hi, at_lo, at_hi);
    return *root > 0;
}

/* p is convex on the piece: the rise from a negative start, or after a minimum below zero. */
static bool rise_from_minimum(const double *c, int degree, double noise, double lo, double hi, double *root) {
    double at_lo = horner(c, degree, 1, lo), at_hi = horner(c, degree, 1, hi);
    if (at_lo < 0 && at_hi > 0 && !(signed_value(c, degree, noise, lo) < 0))
        lo = bracketed_zero(c, degree, 1, lo, hi, at_lo, at_hi);
    return rise_between(c, degree, noise, lo, hi, root);
}

/* p is concave on the piece: the sign of its single maximum decides. */
static bool rise_to_maximum(const double *c, int degree, double noise, double lo, double hi, double *root) {
    double at_lo = horner(c, degree, 1, lo), at_hi = horner(c, degree, 1, hi);
    double top = at_hi >= 0 ? hi : at_lo <= 0 ? lo : bracketed_zero(c, degree, 1, lo, hi, at_lo, at_hi);
    if (top < hi && !(signed_value(c, degree, noise, top) > 0))
        return false;
    return rise_between(c, degree, noise, lo, top, root);
}

/* Decide by the signs of p' and p'' on a piece (0: unknown). 1: a rise was found, -1: there is none, 0: the
 * signs do not suffice. */
static int decide(const double *c, int degree, double noise, int slope, int curvature, double lo, double hi,
                  double *root) {
    if (slope < 0)
        return -1;
    if (slope == 0 && curvature == 0)
        return 0;
    bool found = slope > 0       ? rise_between(c, degree, noise, lo, hi, root)
                 : curvature > 0 ? rise_from_minimum(c, degree, noise, lo, hi, root)
                                 : rise_to_maximum(c, degree, noise, lo, hi, root);
    return found ? 1 : -1;
}

/* The sign of p' or p'' on [0, 1] as far as the coefficients' positive and negative parts settle it; 0:
 * unknown. */
static int plain_sign(const double *c, int degree, int derivative) {
    double low = factor_of(derivative, derivative) * c[derivative], high = low, number = derivative + 1;
    for (int k = derivative + 1; k <= degree; k++, number += 1) {
        const double term = factor_of(number, derivative) * c[k];
        low += term < 0 ? term : 0;
        high += term > 0 ? term : 0;
    }
    return low >= 0 ? 1 : high <= 0 ? -1 : 0;
}

/* The same by Bernstein coefficients, which settle nearly all that are not plain. */
static int close_sign(const double *c, int degree, int derivative) {
    double b[SALTUS_DEGREE_MAX + 1];
    derivative_to_bernstein(c, degree, derivative, b);
    return common_sign(b, degree - derivative);
}

/* An upper bound on [0, 1]: the largest Bernstein coefficient of the part of degree 6, plus the positive
 * coefficients of the rest. */
static double upper_bound(const double *c, int degree) {
    static const double weight[7][7] = {{1},
                                        {1, 1.0 / 6},
                                        {1, 1.0 / 3, 1.0 / 15},
                                        {1, 1.0 / 2, 1.0 / 5, 1.0 / 20},
                                        {1, 2.0 / 3, 2.0 / 5, 1.0 / 5, 1.0 / 15},
                                        {1, 5.0 / 6, 2.0 / 3, 1.0 / 2, 1.0 / 3, 1.0 / 6},
                                        {1, 1, 1, 1, 1, 1, 1}};
    double rest = 0, highest = c[0];
    for (int k = 7; k <= degree; k++)
        rest += c[k] > 0 ? c[k] : 0;
    for (int j = 1; j <= 6; j++) {
        double b = 0;
        for (int k = 0; k <= j && k <= degree; k++)
            b += weight[j][k] * c[k];
        highest = b > highest ? b : highest;
    }
    return highest + rest;
}

bool saltus_isolate_rise(const double *c, int degree, double *root) {
    double noise = 0, size = 0;
    for (int k = 0; k <= degree; k++)
        size += fabs(c[k]);
    noise = 4 * (degree + 1) * DBL_EPSILON * size;
    while (degree > 0 && c[degree] == 0)
        degree--;
    /* The sign of p'' is of use only if that of p' is unknown. */
    const bool curved = degree >= 2;
    int slope = curved ? plain_sign(c, degree, 1) : 0;
    if (slope == 0 && upper_bound(c, degree) < -noise)
        return false;
    int curvature = curved && !slope ? plain_sign(c, degree, 2) : 0;
    if (curved && !slope && !curvature) {
        slope = close_sign(c, degree, 1);
        curvature = slope ? 0 : close_sign(c, degree, 2);
    }
    int verdict = decide(c, degree, noise, slope, curvature, 0, 1, root);
    if (verdict != 0)
        return verdict > 0;

    /* Depth first, leftmost piece on top: at most one piece per depth waits. */
    piece stack[depth_max + 2];
    int depth[depth_max + 2], top = 0;
    stack[0].lo = 0;
    stack[0].hi = 1;
    depth[0] = 0;
    for (int d = 0; d < 3; d++)
        derivative_to_bernstein(c, degree, d, stack[0].p[d]);
    while (top >= 0) {
        piece *s = &stack[top];
        double highest = s->p[0][0];
        for (int k = 1; k <= degree; k++)
            highest = fmax(highest, s->p[0][k]);
        slope = degree > 0 ? common_sign(s->p[1], degree - 1) : 1;
        curvature = degree > 1 ? common_sign(s->p[2], degree - 2) : 1;
        if (slope == 0 && depth[top] >= depth_max)
            slope = 1; /* the piece is too short to tell */
        verdict = highest < -noise ? -1 : decide(c, degree, noise, slope, curvature, s->lo, s->hi, root);
        if (verdict > 0)
            return true;
        if (verdict < 0) {
            top--;
            continue;
        }
        stack[top + 1] = *s;
        halve(&stack[top + 1], s, degree);
        depth[top + 1] = ++depth[top];
        top++;
    }
    return false;
}
