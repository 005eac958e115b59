/* Hopf points of equilibria, and the cycles that are born there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/born.h"

#include <complex.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Central differences of eighth order over nine places. */
enum { sides = 4 };
static const double first[sides] = {4. / 5, -1. / 5, 4. / 105, -1. / 280},
                    second[sides] = {8. / 5, -1. / 5, 8. / 315, -1. / 560}, middle = -205. / 72;

/* The Jacobian of the motion and its derivatives along real and imaginary part of the eigenvector. */
typedef struct expansion {
    int count;
    double *linear, *along[2], *twice[2], *trial; /* count x count each */
    double *real;                                 /* a complex matrix as a real one of twice the size */
    double part[2][SALTUS_STATE_MAX];             /* the two parts of the eigenvector */
    double size[2]; /* largest entry of each as a state, in the states' scales */
} expansion;

/* First and second derivatives of the Jacobian along both parts; the greatest displacement is `reach`. */
static saltus_status differentiate(saltus_rests *r, const saltus_rest *at, expansion *x, double reach) {
    const int entries = x->count * x->count;
    saltus_status status = SALTUS_OK;
    for (int part = 0; part < 2; part++) {
        const double step = reach / (sides * x->size[part]);
        for (int k = 0; k < entries; k++) {
            x->along[part][k] = 0;
            x->twice[part][k] = middle * x->linear[k] / (step * step);
        }
        for (int k = 0; k < 2 * sides && status == SALTUS_OK; k++) {
            const int place = k / 2, way = k % 2 ? -1 : 1;
            int count;
            status = saltus_rests_linear(r, at->at.u, x->part[part], way * (place + 1) * step, x->trial,
                                         &count, NULL);
            for (int j = 0; j < entries && status == SALTUS_OK; j++) {
                x->along[part][j] += way * first[place] * x->trial[j] / step;
                x->twice[part][j] += second[place] * x->trial[j] / (step * step);
            }
        }
    }
    return status;
}

/* out += factor * matrix * vector */
static void apply(const double *matrix, int count, double complex factor, const double complex *vector,
                  double complex *out) {
    for (int i = 0; i < count; i++)
        for (int j = 0; j < count; j++)
            out[i] += factor * matrix[i * count + j] * vector[j];
}

/* x->real becomes A - shift, or its transpose with the same shift. Returns the room for a vector behind it.
 */
static double *take_real_form(expansion *x, bool transposed, double complex shift) {
    const int c = x->count, m = 2 * c;
    double *a = x->real;
    for (int i = 0; i < c; i++)
        for (int j = 0; j < c; j++) {
            const double entry = x->linear[transposed ? j * c + i : i * c + j];
            a[i * m + j] = a[(c + i) * m + c + j] = entry - (i == j ? creal(shift) : 0);
            a[i * m + c + j] = i == j ? cimag(shift) : 0;
            a[(c + i) * m + j] = i == j ? -cimag(shift) : 0;
        }
    return a + m * m;
}

/* Solve (shift - A) x = right. False where it is singular. */
static bool resolve(expansion *x, double complex shift, double complex *right) {
    const int c = x->count;
    int pivots[2 * SALTUS_STATE_MAX];
    double *b = take_real_form(x, false, shift);
    for (int i = 0; i < c; i++) {
        b[i] = -creal(right[i]);
        b[c + i] = -cimag(right[i]);
    }
    const bool sound = saltus_dense_solve(x->real, 2 * c, b, pivots);
    for (int i = 0; i < c && sound; i++)
        right[i] = b[i] + I * b[c + i];
    return sound;
}

/* The coefficient, from the derivatives in `x` and the eigenvectors `left` and `right`. */
static double coefficient_of(expansion *x, double omega, const double complex *left,
                             const double complex *right) {
    const int c = x->count;
    double complex a[SALTUS_STATE_MAX], b[SALTUS_STATE_MAX],
        even[SALTUS_STATE_MAX] = {0}, twofold[SALTUS_STATE_MAX] = {0}, cubic[SALTUS_STATE_MAX] = {0},
        flat[SALTUS_STATE_MAX], turned[SALTUS_STATE_MAX];
    double complex sum = 0;
    for (int i = 0; i < c; i++) {
        a[i] = x->part[0][i];
        b[i] = x->part[1][i];
    }
    /* B(q, q') and B(q, q), with q = a + ib. */
    apply(x->along[0], c, 1, a, even);
    apply(x->along[1], c, 1, b, even);
    apply(x->along[0], c, 1, a, twofold);
    apply(x->along[1], c, -1, b, twofold);
    apply(x->along[0], c, 2 * I, b, twofold);
    /* C(q, q, q'). */
    apply(x->twice[0], c, 1, right, cubic);
    apply(x->twice[1], c, 1, right, cubic);
    memcpy(flat, even, sizeof flat);
    memcpy(turned, twofold, sizeof turned);
    if (!resolve(x, 0, flat) || !resolve(x, 2 * I * omega, turned))
        return NAN;
    /* -2 B(q, A^-1 even), where `flat` is -A^-1 even, and B(q', (2 i omega - A)^-1 twofold). */
    apply(x->along[0], c, 2, flat, cubic);
    apply(x->along[1], c, 2 * I, flat, cubic);
    apply(x->along[0], c, 1, turned, cubic);
    apply(x->along[1], c, -I, turned, cubic);
    for (int i = 0; i < c; i++)
        sum += conj(left[i]) * cubic[i];
    return creal(sum) / (2 * omega);
}

/* Eigenvectors with q*q = 1 and p*q = 1; q also goes to the expansion's parts and, as states, to `hopf`. */
static saltus_status find_vectors(saltus_rests *r, expansion *x, double complex *left, double complex *right,
                                  saltus_hopf *hopf) {
    const int c = x->count;
    /* The complex null vectors of A - i omega and of A' + i omega. */
    for (int side = 0; side < 2; side++) {
        double value, *b = take_real_form(x, side, side ? -hopf->omega * I : hopf->omega * I);
        saltus_status status = saltus_dense_null_vectors(x->real, 2 * c, 2 * c, 1, b, &value);
        if (status != SALTUS_OK)
            return status;
        for (int i = 0; i < c; i++)
            (side ? left : right)[i] = b[i] + I * b[c + i];
    }
    double complex scale = 0;
    for (int i = 0; i < x->count; i++)
        scale += conj(left[i]) * right[i];
    if (!(cabs(scale) > 0))
        return SALTUS_NO_CONVERGENCE; /* the eigenvalues are double */
    for (int i = 0; i < x->count; i++) {
        left[i] /= conj(scale);
        x->part[0][i] = creal(right[i]);
        x->part[1][i] = cimag(right[i]);
    }
    for (int k = 0; k < 2; k++) {
        saltus_rests_lift(r, x->count, x->part[k], hopf->vector[k]);
        for (int i = 0; i < r->n; i++)
            x->size[k] = fmax(x->size[k], fabs(hopf->vector[k][i]) / r->state_scale[i]);
    }
    return SALTUS_OK;
}

bool saltus_hopf_find(saltus_rests *r, const saltus_rest *at, saltus_hopf *hopf) {
    static const double reach[] = {1, 0.3, 0.1, 0.03, 0.01, 0.003};
    const size_t entries = (size_t)(r->n * r->n);
    expansion x = {.linear = calloc(10 * entries + 2 * (size_t)r->n, sizeof *x.linear)};
    double complex left[SALTUS_STATE_MAX], right[SALTUS_STATE_MAX];
    double least = INFINITY, before = NAN;
    *hopf = (saltus_hopf){.coefficient = NAN, .error = NAN};
    for (int k = 0; k < at->rate_count; k++)
        if (at->rates[k].im > 0 && fabs(at->rates[k].re) < least) {
            least = fabs(at->rates[k].re);
            hopf->omega = at->rates[k].im;
        }
    if (!x.linear) {
        r->starved = true;
        return false;
    }
    x.trial = x.linear + entries;
    for (size_t k = 0; k < 2; k++) {
        x.along[k] = x.trial + (1 + k) * entries;
        x.twice[k] = x.trial + (3 + k) * entries;
    }
    x.real = x.trial + 5 * entries;
    saltus_status status = hopf->omega > 0
                               ? saltus_rests_linear(r, at->at.u, NULL, 0, x.linear, &x.count, NULL)
                               : SALTUS_NO_CONVERGENCE;
    if (status == SALTUS_OK)
        status = find_vectors(r, &x, left, right, hopf);
    hopf->error = status == SALTUS_OK ? INFINITY : NAN;
    /* Try differences over several widths; keep the result at which two successive ones agree best. */
    for (size_t k = 0; k < sizeof reach / sizeof reach[0] && status == SALTUS_OK; k++) {
        const saltus_status made = differentiate(r, at, &x, reach[k]);
        if (made == SALTUS_NO_MEMORY)
            status = made;
        const double now = made == SALTUS_OK ? coefficient_of(&x, hopf->omega, left, right) : NAN;
        if (fabs(now - before) < hopf->error) {
            hopf->error = fabs(now - before);
            hopf->coefficient = now;
        }
        before = now;
    }
    /* Rounding of the linear terms acts like a coefficient, too, at amplitudes of the states' scales. */
    const double size = fmax(x.size[0], x.size[1]);
    hopf->error += 1e-14 * fabs(hopf->coefficient) + DBL_EPSILON * hopf->omega * size * size;
    free(x.linear);
    return saltus_rests_noted(r, status) == SALTUS_OK;
}

void saltus_hopf_direction(const saltus_rests *r, const saltus_hopf *hopf, double *tangent) {
    const double *observer = saltus_system_observer(r->system), *a = hopf->vector[0], *b = hopf->vector[1];
    /* Where the observed displacement of Re(q e^(i phi)) is largest, it turns. */
    const double along[2] = {saltus_dot(observer, a, r->dof), saltus_dot(observer, b, r->dof)};
    const double length = hypot(along[0], along[1]);
    const double cosine = length > 0 ? along[0] / length : 1, sine = length > 0 ? along[1] / length : 0;
    for (int i = 0; i < r->n; i++)
        tangent[i] = (cosine * a[i] + sine * b[i]) / r->state_scale[i];
    saltus_make_unit(tangent, r->n);
}

saltus_status saltus_hopf_aside(saltus_orbits *o, const double *parameters, const double *rest,
                                const double *tangent, double apart, const saltus_sequence *like,
                                saltus_solution *out, saltus_message *message) {
    saltus_sequence sequence = *like;
    double state[SALTUS_STATE_MAX];
    saltus_status status = saltus_shooting_shape(o->shooting, &sequence, message);
    for (int i = 0; i < o->n && status == SALTUS_OK; i++)
        state[i] = rest[i] + apart * tangent[i] * o->shooting->scale[i];
    if (status == SALTUS_OK)
        status = saltus_orbits_tune(o, parameters, sequence.omega, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(o->flow, 0, (saltus_time){0, 0}, state, message);
    if (status != SALTUS_OK)
        return status;
    saltus_sequence_anchor(&sequence, o->flow, true);
    if (!(sequence.speed > 0))
        saltus_sequence_anchor(&sequence, o->flow, false);
    return saltus_solution_place(o, &sequence, parameters, state, false, out, message);
}
