/* Equations made up for the tests of Newton's method and of curves: circles, parabolas, crossings, helices,
 * corners, borders beyond which nothing can be evaluated.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_MADE_EQUATIONS_H
#define SALTUS_TESTS_MADE_EQUATIONS_H

#include "check.h"

#include "orbit/newton.h"

typedef struct made made;

/* Residuals and Jacobian (row-major) at u. */
typedef void made_function(const made *m, const double *u, double *residual, double *jacobian);

enum { made_unknowns_max = 9 };

struct made {
    saltus_equations e;
    saltus_arena arena;
    made_function *function;
    double a, b;                     /* what the function makes of them */
    double mix[64];                  /* count x count, of helices */
    int evaluations, measurements;   /* since the last made_count, with and without the Jacobian */
    double first[made_unknowns_max]; /* where the first of them was */
    int failing;                     /* the number of the evaluation that fails with `failure`; 0: none */
    saltus_status failure;
    double border; /* nothing can be evaluated where u[0] is beyond; STALLED */
};

static inline saltus_status made_evaluate(void *self, const double *u, saltus_message *message) {
    made *m = self;
    if (m->evaluations++ == 0)
        memcpy(m->first, u, (size_t)m->e.unknowns * sizeof *u);
    if (m->evaluations == m->failing)
        return saltus_fail(message, m->failure, "evaluation %d fails", m->failing);
    if (u[0] > m->border)
        return saltus_fail(message, SALTUS_STALLED, "%g is beyond the border", u[0]);
    m->function(m, u, m->e.residual, m->e.jacobian);
    return SALTUS_OK;
}

/* The residuals alone. */
static inline saltus_status made_measure(void *self, const double *u, saltus_message *message) {
    made *m = self;
    double unused[made_unknowns_max * made_unknowns_max];
    m->measurements++;
    if (u[0] > m->border)
        return saltus_fail(message, SALTUS_STALLED, "%g is beyond the border", u[0]);
    m->function(m, u, m->e.residual, unused);
    return SALTUS_OK;
}

/* Begin to count evaluations; let one of them fail. */
static inline void made_count(made *m, int failing, saltus_status failure) {
    m->evaluations = m->measurements = 0;
    m->failing = failing;
    m->failure = failure;
}

static inline void made_open(made *m, int unknowns, made_function *function, double a, double b) {
    *m = (made){.function = function, .a = a, .b = b, .border = INFINITY};
    m->e = (saltus_equations){.self = m, .evaluate = made_evaluate, .tolerance = 1e-10, .iterations = 20};
    saltus_equations_reserve(&m->e, unknowns, &m->arena);
    assert_true(saltus_arena_open(&m->arena));
    saltus_equations_reserve(&m->e, unknowns, &m->arena);
    assert_true(saltus_dense_lu_open(&m->e.lu, unknowns));
}

static inline void made_close(made *m) {
    saltus_dense_lu_close(&m->e.lu);
    saltus_arena_close(&m->arena);
}

/* (x / a)^2 + (y / b)^2 = 1 */
static inline void made_ellipse(const made *m, const double *u, double *residual, double *jacobian) {
    residual[0] = (u[0] / m->a) * (u[0] / m->a) + (u[1] / m->b) * (u[1] / m->b) - 1;
    jacobian[0] = 2 * u[0] / (m->a * m->a);
    jacobian[1] = 2 * u[1] / (m->b * m->b);
}

/* The parameter has a fold: y = a x^2 + b. */
static inline void made_parabola(const made *m, const double *u, double *residual, double *jacobian) {
    residual[0] = u[1] - m->a * u[0] * u[0] - m->b;
    jacobian[0] = -2 * m->a * u[0];
    jacobian[1] = 1;
}

/* Two curves that cross at (a, b), a parabola and a line: (y - b - (x - a)^2) (x - a - 2 (y - b)) = 0. */
static inline void made_crossing(const made *m, const double *u, double *residual, double *jacobian) {
    double x = u[0] - m->a, y = u[1] - m->b, one = y - x * x, two = x - 2 * y;
    residual[0] = one * two;
    jacobian[0] = -2 * x * two + one;
    jacobian[1] = two - 2 * one;
}

/* A corner at (a, b): y - b = |x - a| / 2. */
static inline void made_corner(const made *m, const double *u, double *residual, double *jacobian) {
    residual[0] = u[1] - m->b - 0.5 * fabs(u[0] - m->a);
    jacobian[0] = u[0] < m->a ? 0.5 : -0.5;
    jacobian[1] = 1;
}

/* Helices of rank k = 1, 2, ... around a common axis: cos and sin of k s, and s, in an odd number of
 * unknowns. The speed is the same everywhere. The equations are mixed, so that each knows all unknowns. */
static inline void made_helix_at(int unknowns, double s, double *u, double *tangent) {
    double size = 1;
    for (int k = 1; 2 * k < unknowns; k++)
        size += k * k;
    for (int k = 1; 2 * k < unknowns; k++) {
        u[2 * k - 2] = cos(k * s);
        u[2 * k - 1] = sin(k * s);
        tangent[2 * k - 2] = -k * sin(k * s) / sqrt(size);
        tangent[2 * k - 1] = k * cos(k * s) / sqrt(size);
    }
    u[unknowns - 1] = s;
    tangent[unknowns - 1] = 1 / sqrt(size);
}

static inline void made_helix(const made *m, const double *u, double *residual, double *jacobian) {
    int n = m->e.count, unknowns = m->e.unknowns;
    double plain[made_unknowns_max], rows[made_unknowns_max * made_unknowns_max] = {0}, s = u[unknowns - 1];
    for (int k = 1; 2 * k < unknowns; k++) {
        int i = 2 * k - 2;
        plain[i] = u[i] - cos(k * s);
        plain[i + 1] = u[i + 1] - sin(k * s);
        rows[i * unknowns + i] = rows[(i + 1) * unknowns + i + 1] = 1;
        rows[i * unknowns + n] = k * sin(k * s);
        rows[(i + 1) * unknowns + n] = -k * cos(k * s);
    }
    for (int i = 0; i < n; i++) {
        residual[i] = 0;
        for (int j = 0; j < unknowns; j++)
            jacobian[i * unknowns + j] = 0;
        for (int l = 0; l < n; l++) {
            residual[i] += m->mix[i * n + l] * plain[l];
            for (int j = 0; j < unknowns; j++)
                jacobian[i * unknowns + j] += m->mix[i * n + l] * rows[l * unknowns + j];
        }
    }
}

/* Random numbers in [-1, 1), the same ones in every run. */
static inline double made_random(unsigned long long *seed) {
    *seed = *seed * 6364136223846793005ULL + 1442695040888963407ULL;
    return (double)(*seed >> 11) * 0x1p-52 - 1;
}

static inline void made_open_helix(made *m, int unknowns, unsigned long long *seed) {
    made_open(m, unknowns, made_helix, 0, 0);
    int n = unknowns - 1;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            m->mix[i * n + j] = 0.4 * made_random(seed) + 2 * (i == j);
}

static inline double made_apart(const double *a, const double *b, int count) {
    double sum = 0;
    for (int j = 0; j < count; j++)
        sum = hypot(sum, a[j] - b[j]);
    return sum;
}

#endif
