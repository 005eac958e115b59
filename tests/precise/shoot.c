/* Newton's method on the period map.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "shoot.h"

#include <string.h>

enum { iterations_most = 12 };

bool shoot_solve(int n, real *matrix, real *b) {
    real(*a)[n] = (real(*)[n])matrix;
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (real_abs(a[i][k]) > real_abs(a[pivot][k]))
                pivot = i;
        if (a[pivot][k] == 0)
            return false;
        for (int j = k; j < n; j++) {
            real kept = a[k][j];
            a[k][j] = a[pivot][j];
            a[pivot][j] = kept;
        }
        real kept = b[k];
        b[k] = b[pivot];
        b[pivot] = kept;
        for (int i = k + 1; i < n; i++) {
            real factor = a[i][k] / a[k][k];
            for (int j = k; j < n; j++)
                a[i][j] -= factor * a[k][j];
            b[i] -= factor * b[k];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++)
            b[i] -= a[i][j] * b[j];
        b[i] /= a[i][i];
    }
    return true;
}

real shoot_distance(const model *m, const real *difference) {
    real largest = 0;
    for (int i = 0; i < 2 * m->modes; i++)
        largest = real_max(largest, real_abs(difference[i]) * (i < m->modes ? 1 : 1 / m->omega));
    return largest;
}

/* (M - 1) correction = start - end */
static bool correct(const model *m, const real *matrix, real *state, const real *gap) {
    const int n = 2 * m->modes;
    real a[model_dimension * model_dimension], correction[model_dimension];
    for (int i = 0; i < n; i++) {
        correction[i] = -gap[i];
        for (int j = 0; j < n; j++)
            a[i * n + j] = matrix[i * n + j] - (i == j);
    }
    bool solved = shoot_solve(n, a, correction);
    for (int i = 0; i < n; i++)
        state[i] += correction[i];
    return solved;
}

static void take_matrix(int n, const passage *p, real *matrix) {
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            matrix[i * n + j] = p->x[n * (1 + j) + i];
}

const char *shoot(step *s, int periods, real *state, passage *p, real *matrix, bool known, real *residual) {
    const int n = 2 * s->model->modes;
    const real closed = s->tolerance / 100, nearly = 10000 * s->tolerance;
    real last = HUGE_VAL, gap[model_dimension];
    for (int k = 0; k < iterations_most; k++) {
        const char *trouble = passage_run(p, s, periods, !known, state);
        if (trouble)
            return trouble;
        for (int i = 0; i < n; i++)
            gap[i] = p->x[i] - state[i];
        real left = *residual = shoot_distance(s->model, gap);
        if (!known)
            take_matrix(n, p, matrix);
        fprintf(stderr, "residual %.2e, %d impacts, %ld steps, %ld refused\n", (double)left, p->impact_count,
                p->steps, p->refused);
        if (left < closed || (left < nearly && left > last / 100))
            return NULL;
        last = left;
        if (!correct(s->model, matrix, state, gap))
            return "the orbit is not isolated";
    }
    return "Newton's method finds no orbit";
}
