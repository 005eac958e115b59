/* The extrapolated midpoint rule.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "step.h"

bool step_open(step *s, const model *m, int columns, real tolerance, int vectors) {
    size_t block = 2 * (size_t)m->modes * vectors;
    *s = (step){.model = m, .columns = columns, .tolerance = tolerance, .slackness = 1000};
    s->work = malloc((step_columns + 4) * block * sizeof *s->work);
    return s->work != NULL;
}

void step_close(step *s) {
    free(s->work);
}

/* The midpoint rule in increments of x, so that rounding is relative to what the step changes. */
static void midpoint(const step *s, real tau, real h, int substeps, int vectors, const real *x,
                     real *change) {
    const int size = 2 * s->model->modes * vectors;
    real part = h / substeps;
    real *last = s->work + step_columns * size, *here = change, *place = last + size, *f = place + size;
    model_field(s->model, tau, vectors, x, f, s->held != 0);
    for (int i = 0; i < size; i++) {
        last[i] = 0;
        here[i] = part * f[i];
    }
    for (int k = 1; k < substeps; k++) {
        for (int i = 0; i < size; i++)
            place[i] = x[i] + here[i];
        model_field(s->model, tau + k * part, vectors, place, f, s->held != 0);
        for (int i = 0; i < size; i++) {
            real next = last[i] + 2 * part * f[i];
            last[i] = here[i];
            here[i] = next;
        }
    }
}

static real largest_of(int n, const real *x) {
    real largest = 0;
    for (int i = 0; i < n; i++)
        largest = real_max(largest, real_abs(x[i]));
    return largest;
}

/* Size of a difference relative to the vector: its displacements and its velocities each to their largest.
 * Either may pass zero: they are no smaller here than the other is in a hundredth of a radian of the forcing;
 * and nothing of a tangent vector is smaller than the floor. */
static real relative(const step *s, real floor, const real *x, const real *difference) {
    const int n = s->model->modes;
    const real slow = s->model->omega / 100, fast = s->model->omega * 100;
    real q = largest_of(n, x), v = largest_of(n, x + n);
    real own_q = real_max(real_max(q, v / fast), floor), own_v = real_max(real_max(v, q * slow), floor);
    return own_q > 0 ? real_max(largest_of(n, difference) / own_q, largest_of(n, difference + n) / own_v) : 0;
}

/* Row j of the table from row j - 1, in place; `difference` is that of the last two entries. */
static void neville(const step *s, int row, int size, real *difference) {
    real *table = s->work;
    for (int k = 1; k <= row; k++) {
        real ratio = (real)(row + 1) / (row + 1 - k), weight = 1 / (ratio * ratio - 1);
        real *finer = table + (row - k + 1) * size, *coarser = table + (row - k) * size;
        for (int i = 0; i < size; i++) {
            difference[i] = weight * (finer[i] - coarser[i]);
            coarser[i] = finer[i] + difference[i];
        }
    }
}

real step_take(const step *s, real tau, real h, int vectors, const real *x, real *result) {
    const real nothing = 1 / (real)1000;
    const int n = s->model->modes, size = 2 * n * vectors;
    real *difference = s->work + step_columns * size, error = 1;
    for (int row = 0; row < s->columns && !(error < nothing); row++) {
        midpoint(s, tau, h, 2 * (row + 1), vectors, x, s->work + row * size);
        neville(s, row, size, difference);
        for (int i = 0; i < size; i++)
            result[i] = x[i] + s->work[i];
        error = row == 0 ? 1 : 0;
        for (int k = 0; k < vectors && row > 0; k++) {
            real own =
                relative(s, k == 0 ? 0 : s->floor, result + 2 * n * k, difference + 2 * n * k) / s->tolerance;
            error = real_max(error, k == 0 ? own : own / s->slackness);
        }
    }
    return error;
}

real step_next(const step *s, real h, real error) {
    real factor =
        (real)9 / 10 * real_pow(real_max(error, 1 / (real)1000000000), -1 / (real)(2 * s->columns - 1));
    return h * real_max(1 / (real)5, real_min(factor, 2));
}
