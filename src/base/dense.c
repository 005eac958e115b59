/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/dense.h"

#include <lapacke.h>
#include <math.h>
#include <string.h>

/* A row-major matrix handed to LAPACK is its transpose; the inverse of the transpose, read back row-major, is
 * the inverse itself. Column-major calls of LAPACKE do not allocate. */
bool saltus_dense_inverse(const double *a, int n, double *inverse) {
    double factors[SALTUS_DENSE_INVERSE_MAX * SALTUS_DENSE_INVERSE_MAX];
    lapack_int pivots[SALTUS_DENSE_INVERSE_MAX];
    if (n == 0)
        return true;
    if (n == 1) {
        inverse[0] = 1 / a[0];
        return a[0] != 0;
    }
    double size = 0, low = INFINITY;
    memcpy(factors, a, (size_t)(n * n) * sizeof *a);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            inverse[i * n + j] = i == j;
    for (int i = 0; i < n * n; i++)
        size = fmax(size, fabs(a[i]));
    if (LAPACKE_dgesv(LAPACK_COL_MAJOR, n, n, factors, n, pivots, inverse, n) != 0)
        return false;
    for (int i = 0; i < n; i++)
        low = fmin(low, fabs(factors[i * n + i]));
    return low > 1e-13 * size;
}

bool saltus_dense_solve(double *a, int n, double *b, int *pivots) {
    /* Row-major a is the transpose in LAPACK's eyes: factor that and solve with its transpose. */
    return LAPACKE_dgetrf(LAPACK_COL_MAJOR, n, n, a, n, pivots) == 0 &&
           LAPACKE_dgetrs(LAPACK_COL_MAJOR, 'T', n, 1, a, n, pivots, b, n) == 0;
}

bool saltus_dense_eigenvalues(double *a, int n, double *real, double *imaginary) {
    return LAPACKE_dgeev(LAPACK_COL_MAJOR, 'N', 'N', n, a, n, real, imaginary, NULL, 1, NULL, 1) == 0;
}

bool saltus_dense_qr(double *a, int rows, int columns, double *r, double *tau) {
    if (LAPACKE_dgeqrf(LAPACK_COL_MAJOR, rows, columns, a, rows, tau) != 0)
        return false;
    for (int i = 0; i < columns; i++)
        for (int j = 0; j < columns; j++)
            r[i * columns + j] = j >= i ? a[j * rows + i] : 0;
    if (LAPACKE_dorgqr(LAPACK_COL_MAJOR, rows, columns, columns, a, rows, tau) != 0)
        return false;
    for (int i = 0; i < columns; i++) {
        if (!(r[i * columns + i] < 0))
            continue;
        for (int j = i; j < columns; j++)
            r[i * columns + j] = -r[i * columns + j];
        for (int k = 0; k < rows; k++)
            a[i * rows + k] = -a[i * rows + k];
    }
    return true;
}
