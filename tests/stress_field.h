/* A second writing of the equations of motion (model.md, sections 1 and 2), for tests: nothing here comes
 * from the library but parameters by name. Field, elastic energy and the power of all that is not elastic,
 * contact forces.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_STRESS_FIELD_H
#define SALTUS_TESTS_STRESS_FIELD_H

#include "check.h"

#include <gsl/gsl_math.h>

enum { stress_dof_max = 64, stress_dimension_max = 2 * stress_dof_max + 1 };

typedef struct stress_stop {
    double normal[stress_dof_max]; /* towards the stop: the gap is normal . q - d */
    double d, r;
} stress_stop;

typedef struct stress_model {
    bool pipe;
    int dof, extra, dimension;
    double alpha, beta, kappa, u0, sigma, omega;             /* pipe */
    double k, c, k2, c2, kz, tz, force[2], load[2], mass[2]; /* oscillator */
    double gyroscopic[stress_dof_max][stress_dof_max], gradient[stress_dof_max][stress_dof_max];
    stress_stop face[SALTUS_FACES_MAX]; /* in the library's order of faces */
    int face_count;
} stress_model;

/* sin(i pi xi), measured from the nearer support; a node of the mode that only rounding misses is one. */
static inline double stress_sine(int i, double xi) {
    bool far = xi > 0.5;
    double sine = (double)sinl(i * 3.14159265358979323846264338327950288L * (long double)(far ? 1 - xi : xi));
    if (fabs(sine) < 1e-15)
        return 0;
    return far && i % 2 == 0 ? -sine : sine;
}

static inline void stress_read_stops(stress_model *m, const saltus_spec *spec) {
    for (int s = 0; s < spec->stop_count; s++)
        for (int side = 1; side >= -1; side -= 2) {
            const saltus_stop *stop = &spec->stops[s];
            if (!(stop->sides & (side > 0 ? SALTUS_UPPER : SALTUS_LOWER)))
                continue;
            stress_stop *face = &m->face[m->face_count++];
            *face = (stress_stop){.d = stop->d, .r = stop->r};
            for (int i = 0; i < m->dof; i++)
                face->normal[i] = side * (m->pipe ? stress_sine(i + 1, stop->xi) : stop->weight[i]);
        }
}

static inline void stress_read_pipe(stress_model *m, const saltus_spec *spec) {
    m->alpha = saltus_spec_get(spec, "alpha");
    m->beta = saltus_spec_get(spec, "beta");
    m->kappa = saltus_spec_get(spec, "kappa");
    m->u0 = saltus_spec_get(spec, "u0");
    m->sigma = saltus_spec_get(spec, "sigma");
    for (int i = 1; i <= m->dof; i++)
        for (int j = 1; j <= m->dof; j++) {
            double squares = (double)(i * i - j * j);
            bool odd = (i + j) % 2 == 1;
            m->gyroscopic[i - 1][j - 1] = odd ? 4.0 * i * j / squares : 0;
            m->gradient[i - 1][j - 1] = odd ? -8.0 * i * j * j * j / (squares * squares) : 0;
        }
    for (int i = 1; i <= m->dof; i++)
        m->gradient[i - 1][i - 1] = -0.5 * gsl_pow_2(i * M_PI);
}

static inline void stress_read_oscillator(stress_model *m, const saltus_spec *spec) {
    bool two = m->dof == 2;
    m->k = saltus_spec_get(spec, "k");
    m->c = saltus_spec_get(spec, "c");
    m->kz = saltus_spec_get(spec, "kz");
    m->tz = saltus_spec_get(spec, "tz");
    m->k2 = two ? saltus_spec_get(spec, "k2") : 0;
    m->c2 = two ? saltus_spec_get(spec, "c2") : 0;
    m->force[0] = saltus_spec_get(spec, "F");
    m->force[1] = saltus_spec_get(spec, "F2");
    m->load[0] = saltus_spec_get(spec, "F0");
    m->load[1] = saltus_spec_get(spec, "F02");
    m->mass[0] = saltus_spec_get(spec, "m");
    m->mass[1] = saltus_spec_get(spec, "m2");
    m->extra = m->kz > 0;
}

static inline void stress_model_read(stress_model *m, const saltus_spec *spec) {
    memset(m, 0, sizeof *m);
    m->pipe = strcmp(saltus_model_name(spec->model), "pipe") == 0;
    m->dof = (int)saltus_spec_get(spec, "N");
    m->omega = saltus_spec_get(spec, "omega");
    if (m->pipe)
        stress_read_pipe(m, spec);
    else
        stress_read_oscillator(m, spec);
    m->dimension = 2 * m->dof + m->extra;
    stress_read_stops(m, spec);
}

static inline double stress_mass(const stress_model *m, int i) {
    return m->pipe ? 1 : m->mass[i];
}

static inline double stress_gap(const stress_model *m, int face, const double *x) {
    double g = -m->face[face].d;
    for (int i = 0; i < m->dof; i++)
        g += m->face[face].normal[i] * x[i];
    return g;
}

/* The sizes that a gap is the difference of. */
static inline double stress_gap_size(const stress_model *m, int face, const double *x) {
    double size = fabs(m->face[face].d);
    for (int i = 0; i < m->dof; i++)
        size += fabs(m->face[face].normal[i] * x[i]);
    return size;
}

/* normal . vector, of velocities or accelerations. */
static inline double stress_normal(const stress_model *m, int face, const double *vector) {
    double sum = 0;
    for (int i = 0; i < m->dof; i++)
        sum += m->face[face].normal[i] * vector[i];
    return sum;
}

/* n M^-1 n' of two faces. */
static inline double stress_compliance(const stress_model *m, int a, int b) {
    double sum = 0;
    for (int i = 0; i < m->dof; i++)
        sum += m->face[a].normal[i] * m->face[b].normal[i] / stress_mass(m, i);
    return sum;
}

/* S and S1 of model.md. */
static inline void stress_stretch(const stress_model *m, const double *x, double *s, double *s1) {
    *s = *s1 = 0;
    for (int i = 0; i < m->dof; i++) {
        *s += 0.5 * gsl_pow_2((i + 1) * M_PI * x[i]);
        *s1 += 0.5 * gsl_pow_2((i + 1) * M_PI) * x[i] * x[m->dof + i];
    }
}

/* Accelerations of the pipe without contact; `size` receives the sum of the terms' moduli. */
static inline void stress_pipe_field(const stress_model *m, double phase, const double *x, double *a,
                                     double *size) {
    double root = sqrt(m->beta), u = m->u0 * (1 + m->sigma * sin(2 * M_PI * phase)), s, s1;
    double rate = m->u0 * m->sigma * m->omega * cos(2 * M_PI * phase);
    const double *q = x, *v = x + m->dof;
    stress_stretch(m, x, &s, &s1);
    for (int i = 0; i < m->dof; i++) {
        double lambda2 = gsl_pow_2((i + 1) * M_PI), lambda4 = lambda2 * lambda2;
        double terms[] = {m->alpha * lambda4 * v[i], lambda4 * q[i], -u * u * lambda2 * q[i],
                          m->kappa * lambda2 * q[i] * s, 2 * m->kappa * m->alpha * lambda2 * q[i] * s1};
        a[i] = size[i] = 0;
        for (size_t k = 0; k < sizeof terms / sizeof terms[0]; k++) {
            a[i] -= terms[k];
            size[i] += fabs(terms[k]);
        }
        for (int j = 0; j < m->dof; j++) {
            double flow = 2 * root * u * m->gyroscopic[i][j] * v[j];
            double pulse = root * rate * m->gradient[i][j] * q[j];
            a[i] -= flow + pulse;
            size[i] += fabs(flow) + fabs(pulse);
        }
    }
}

static inline void stress_oscillator_field(const stress_model *m, double phase, const double *x, double *a,
                                           double *size) {
    const double *v = x + m->dof, z = m->extra ? x[2 * m->dof] : 0;
    const double swing = cos(2 * M_PI * phase);
    const bool two = m->dof == 2;
    double spring = two ? m->k2 * (x[0] - x[1]) : 0, damper = two ? m->c2 * (v[0] - v[1]) : 0;
    double push[2] = {m->force[0] * swing + m->load[0], m->force[1] * swing + m->load[1]};
    a[0] = (push[0] - m->k * x[0] - m->c * v[0] - spring - damper - z) / m->mass[0];
    size[0] =
        (fabs(m->force[0]) + fabs(m->load[0]) + fabs(m->k * x[0]) + fabs(m->c * v[0]) + fabs(z)) / m->mass[0];
    if (two) {
        double pair = m->k2 * (fabs(x[0]) + fabs(x[1])) + m->c2 * (fabs(v[0]) + fabs(v[1]));
        size[0] += pair / m->mass[0];
        a[1] = (push[1] + spring + damper) / m->mass[1];
        size[1] = (fabs(m->force[1]) + fabs(m->load[1]) + pair) / m->mass[1];
    }
}

static inline void stress_field(const stress_model *m, double phase, const double *x, double *a,
                                double *size) {
    if (m->pipe)
        stress_pipe_field(m, phase, x, a, size);
    else
        stress_oscillator_field(m, phase, x, a, size);
}

/* Rate of the Maxwell element's force. */
static inline double stress_extra_rate(const stress_model *m, const double *x) {
    return m->kz * x[m->dof] - x[2 * m->dof] / m->tz;
}

/* A bound on the rates of the field at states of a size: how fast an error in it can act. */
static inline double stress_rate(const stress_model *m, double size) {
    if (m->pipe) {
        double lambda = m->dof * M_PI, flow = fabs(m->u0) * (1 + fabs(m->sigma));
        double stretch = sqrt(m->kappa) * lambda * lambda * size;
        return m->alpha * gsl_pow_4(lambda) + lambda * lambda + 4 * flow * lambda + 2 * stretch +
               2 * m->alpha * stretch * stretch;
    }
    double mass = m->dof == 2 ? fmin(m->mass[0], m->mass[1]) : m->mass[0];
    double decay = m->extra ? 1 / m->tz : 0;
    return sqrt((m->k + 2 * m->k2 + m->kz) / mass) + (m->c + 2 * m->c2) / mass + decay;
}

/* Kinetic energy and that of the springs. */
static inline double stress_kinetic(const stress_model *m, const double *velocity) {
    double sum = 0;
    for (int i = 0; i < m->dof; i++)
        sum += 0.5 * stress_mass(m, i) * velocity[i] * velocity[i];
    return sum;
}

static inline double stress_energy(const stress_model *m, const double *x) {
    double sum = stress_kinetic(m, x + m->dof), s, s1;
    if (m->pipe) {
        stress_stretch(m, x, &s, &s1);
        for (int i = 0; i < m->dof; i++)
            sum += 0.5 * gsl_pow_4((i + 1) * M_PI) * x[i] * x[i];
        return sum + 0.5 * m->kappa * s * s;
    }
    sum += 0.5 * m->k * x[0] * x[0];
    if (m->dof == 2)
        sum += 0.5 * m->k2 * gsl_pow_2(x[0] - x[1]);
    return m->extra ? sum + 0.5 * gsl_pow_2(x[2 * m->dof]) / m->kz : sum;
}

/* Power of damping, flow and forcing, and the sum of its parts' moduli. */
static inline double stress_power(const stress_model *m, double phase, const double *x, double *size) {
    const double *q = x, *v = x + m->dof;
    double part[4] = {0}, s, s1, swing = cos(2 * M_PI * phase);
    if (m->pipe) {
        double u = m->u0 * (1 + m->sigma * sin(2 * M_PI * phase)), root = sqrt(m->beta);
        double rate = m->u0 * m->sigma * m->omega * swing;
        stress_stretch(m, x, &s, &s1);
        part[0] = -4 * m->alpha * m->kappa * s1 * s1;
        part[1] = 2 * u * u * s1;
        for (int i = 0; i < m->dof; i++) {
            part[2] -= m->alpha * gsl_pow_4((i + 1) * M_PI) * v[i] * v[i];
            for (int j = 0; j < m->dof; j++)
                part[3] -= root * rate * v[i] * m->gradient[i][j] * q[j];
        }
    } else {
        bool two = m->dof == 2;
        part[0] = -m->c * v[0] * v[0];
        part[1] = two ? -m->c2 * gsl_pow_2(v[0] - v[1]) : 0;
        part[2] =
            (m->force[0] * swing + m->load[0]) * v[0] + (two ? (m->force[1] * swing + m->load[1]) * v[1] : 0);
        part[3] = m->extra ? -gsl_pow_2(x[2 * m->dof]) / (m->kz * m->tz) : 0;
    }
    *size = fabs(part[0]) + fabs(part[1]) + fabs(part[2]) + fabs(part[3]);
    return part[0] + part[1] + part[2] + part[3];
}

/* Trace of the Jacobian of the whole field. */
static inline double stress_trace(const stress_model *m, const double *x) {
    double sum = 0;
    if (m->pipe) {
        for (int i = 0; i < m->dof; i++)
            sum -= m->alpha * gsl_pow_4((i + 1) * M_PI) * (1 + m->kappa * x[i] * x[i]);
        return sum;
    }
    sum = -(m->c + m->c2) / m->mass[0];
    if (m->dof == 2)
        sum -= m->c2 / m->mass[1];
    return m->extra ? sum - 1 / m->tz : sum;
}

/* Solve the symmetric system of the held faces' compliances in place, by elimination: at most eight rows. */
static inline bool stress_solve(double matrix[][SALTUS_FACES_MAX], double *right, int n) {
    for (int k = 0; k < n; k++) {
        if (!(matrix[k][k] > 0))
            return false;
        for (int i = k + 1; i < n; i++) {
            double factor = matrix[i][k] / matrix[k][k];
            for (int j = k; j < n; j++)
                matrix[i][j] -= factor * matrix[k][j];
            right[i] -= factor * right[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++)
            right[k] -= matrix[k][j] * right[j];
        right[k] /= matrix[k][k];
    }
    return true;
}

/* Reactions at a set of faces (one each, zero elsewhere) that undo the vectors' normal parts, towards the
 * stop positive: contact forces of accelerations, impulses of velocities.
 * False where they are not unique. */
static inline bool stress_reactions(const stress_model *m, unsigned faces, const double *vector,
                                    double *reaction) {
    double matrix[SALTUS_FACES_MAX][SALTUS_FACES_MAX], right[SALTUS_FACES_MAX];
    int list[SALTUS_FACES_MAX], n = 0;
    for (int f = 0; f < m->face_count; f++) {
        reaction[f] = 0;
        if (faces >> f & 1)
            list[n++] = f;
    }
    for (int i = 0; i < n; i++) {
        right[i] = stress_normal(m, list[i], vector);
        for (int j = 0; j < n; j++)
            matrix[i][j] = stress_compliance(m, list[i], list[j]);
    }
    if (n > m->dof || !stress_solve(matrix, right, n))
        return false;
    for (int i = 0; i < n; i++)
        reaction[list[i]] = right[i];
    return true;
}

/* vector -= M^-1 sum of reaction n. */
static inline void stress_react(const stress_model *m, const double *reaction, double *vector) {
    for (int f = 0; f < m->face_count; f++)
        for (int i = 0; i < m->dof && reaction[f] != 0; i++)
            vector[i] -= reaction[f] * m->face[f].normal[i] / stress_mass(m, i);
}

#endif
