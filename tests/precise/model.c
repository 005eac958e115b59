/* The equations of the pipe and of the oscillator, and the impact law with its saltation matrix.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "model.h"

static void prepare_pipe(model *m) {
    const real pi = real_pi(), root = real_sqrt(m->beta);
    for (int i = 1; i <= m->modes; i++) {
        real lambda = i * pi;
        m->lambda2[i - 1] = lambda * lambda;
        m->bending[i - 1] = lambda * lambda * lambda * lambda;
        m->damping[i - 1] = m->alpha * m->bending[i - 1];
        m->stop.normal[i - 1] = real_sin(lambda * m->stop.xi);
        for (int j = 1; j <= m->modes; j++) {
            real odd = (i + j) % 2, difference = i == j ? 1 : i * i - j * j;
            real G = odd * 4 * i * j / difference;
            real B = -odd * 8 * i * j * j * j / (difference * difference);
            m->flow_velocity[i - 1][j - 1] = 2 * root * G;
            m->flow_change[i - 1][j - 1] = root * (i == j ? -lambda * lambda / 2 : B);
        }
    }
}

void model_prepare(model *m) {
    m->period = 2 * real_pi() / m->omega;
    if (m->pipe)
        prepare_pipe(m);
    else
        m->stop.normal[0] = 1;
    m->stop.square = 0;
    for (int i = 0; i < m->modes; i++)
        m->stop.square += m->stop.normal[i] * m->stop.normal[i];
}

/* What is linear in (q, q') at the flow velocity u and its rate du: the acceleration `a` receives it. */
static void pipe_linear(const model *m, real u, real du, const real *x, real *a) {
    const int n = m->modes;
    const real *q = x, *v = x + n;
    for (int i = 0; i < n; i++) {
        real gyro = 0, pulse = m->flow_change[i][i] * q[i];
        for (int j = (i + 1) % 2; j < n; j += 2) {
            gyro += m->flow_velocity[i][j] * v[j];
            pulse += m->flow_change[i][j] * q[j];
        }
        a[i] =
            -(m->damping[i] * v[i] + (m->bending[i] - u * u * m->lambda2[i]) * q[i] + u * gyro + du * pulse);
    }
}

/* S + 2 alpha S1, or with the state's `q` and `v` and a tangent vector (dq, dv) its derivative. */
static real tension(const model *m, const real *q, const real *v) {
    real sum = 0;
    for (int i = 0; i < m->modes; i++)
        sum += m->lambda2[i] * q[i] * (q[i] / 2 + m->alpha * v[i]);
    return sum;
}

static real tension_change(const model *m, const real *q, const real *v, const real *dq, const real *dv) {
    real sum = 0;
    for (int i = 0; i < m->modes; i++)
        sum += m->lambda2[i] * (q[i] * dq[i] + m->alpha * (dq[i] * v[i] + q[i] * dv[i]));
    return sum;
}

static void pipe_field(const model *m, real tau, int vectors, const real *x, real *f) {
    const int n = m->modes;
    real sine = real_sin(m->omega * tau), cosine = real_cos(m->omega * tau);
    real u = m->u0 * (1 + m->sigma * sine), du = m->u0 * m->sigma * m->omega * cosine;
    real stretch = tension(m, x, x + n);
    for (int k = 0; k < vectors; k++) {
        const real *q = x + 2 * n * k, *v = q + n;
        real *dq = f + 2 * n * k, *a = dq + n;
        real change = k == 0 ? 0 : tension_change(m, x, x + n, q, v);
        pipe_linear(m, u, du, q, a);
        for (int i = 0; i < n; i++) {
            dq[i] = v[i];
            a[i] -= m->kappa * m->lambda2[i] * (q[i] * stretch + x[i] * change);
        }
    }
}

static void oscillator_field(const model *m, real tau, int vectors, const real *x, real *f) {
    for (int k = 0; k < vectors; k++) {
        real force = k == 0 ? m->F * real_cos(m->omega * tau) + m->F0 : 0;
        f[2 * k] = x[2 * k + 1];
        f[2 * k + 1] = (force - m->c * x[2 * k + 1] - m->k * x[2 * k]) / m->m;
    }
}

real model_contact(const model *m, const real *v) {
    real sum = 0;
    for (int i = 0; i < m->modes; i++)
        sum += m->stop.normal[i] * v[i];
    return sum;
}

/* v <- v - (1 + r) (n.v) n / (n.n) */
static void reverse(const model *m, real r, real *v) {
    real part = (1 + r) * model_contact(m, v) / m->stop.square;
    for (int i = 0; i < m->modes; i++)
        v[i] -= part * m->stop.normal[i];
}

void model_field(const model *m, real tau, int vectors, const real *x, real *f, bool held) {
    if (m->pipe)
        pipe_field(m, tau, vectors, x, f);
    else
        oscillator_field(m, tau, vectors, x, f);
    for (int k = 0; k < vectors && held; k++)
        reverse(m, 0, f + 2 * m->modes * k + m->modes);
}

/* A tangent vector y becomes P y + (f+ - P f-) (n.y) / (n.v-): the disturbed orbit impacts earlier by
 * (n.y) / (n.v-). The time of the section is the same for both. */
void model_impact(const model *m, real tau, int vectors, real *x, bool lands) {
    const int n = m->modes;
    const real r = lands ? 0 : m->stop.r;
    real before[model_dimension], after[model_dimension], speed = model_contact(m, x + n);
    model_field(m, tau, 1, x, before, false);
    reverse(m, r, x + n);
    model_field(m, tau, 1, x, after, lands);
    reverse(m, r, before + n);
    for (int k = 1; k < vectors; k++) {
        real *y = x + 2 * n * k, ahead = model_contact(m, y) / speed;
        reverse(m, r, y + n);
        for (int i = 0; i < 2 * n; i++)
            y[i] += ahead * (after[i] - before[i]);
    }
}

void model_hold(const model *m, int side, int vectors, real *x) {
    for (int k = 0; k < vectors; k++) {
        real *q = x + 2 * m->modes * k;
        for (int i = 0; i < m->modes && k == 0; i++)
            q[i] -= side * m->stop.d * m->stop.normal[i] / m->stop.square;
        reverse(m, 0, q);
        reverse(m, 0, q + m->modes);
        for (int i = 0; i < m->modes && k == 0; i++)
            q[i] += side * m->stop.d * m->stop.normal[i] / m->stop.square;
    }
}
