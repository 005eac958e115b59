/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/dense.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* LAPACK reads a row-major matrix as its transpose; the inverse of that, read back row-major, is the inverse
 * itself. LAPACKE's column-major calls do not allocate. */
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
    /* LAPACK reads the row-major a as its transpose: factor that and solve with its transpose. */
    return LAPACKE_dgetrf(LAPACK_COL_MAJOR, n, n, a, n, pivots) == 0 &&
           LAPACKE_dgetrs(LAPACK_COL_MAJOR, 'T', n, 1, a, n, pivots, b, n) == 0;
}

bool saltus_dense_eigenvalues(double *a, int n, double *real, double *imaginary) {
    return LAPACKE_dgeev(LAPACK_COL_MAJOR, 'N', 'N', n, a, n, real, imaginary, NULL, 1, NULL, 1) == 0;
}

bool saltus_dense_lu_open(saltus_dense_lu *lu, int n) {
    const size_t size = (size_t)n;
    *lu = (saltus_dense_lu){.n = n};
    do {
        lu->factors = saltus_arena_doubles(&lu->arena, size * size);
        lu->row_scale = saltus_arena_doubles(&lu->arena, size);
        lu->column_scale = saltus_arena_doubles(&lu->arena, size);
        lu->work = saltus_arena_doubles(&lu->arena, 4 * size);
        /* An int is no larger than a double. */
        lu->pivots = (int *)(void *)saltus_arena_doubles(&lu->arena, size);
        lu->integers = (int *)(void *)saltus_arena_doubles(&lu->arena, size);
    } while (saltus_arena_again(&lu->arena));
    return lu->arena.base;
}

void saltus_dense_lu_close(saltus_dense_lu *lu) {
    saltus_arena_close(&lu->arena);
    *lu = (saltus_dense_lu){0};
}

double saltus_length(const double *v, int n) {
    double length = 0;
    for (int i = 0; i < n; i++)
        length = hypot(length, v[i]);
    return length;
}

void saltus_make_unit(double *v, int n) {
    const double length = saltus_length(v, n);
    for (int i = 0; i < n; i++)
        v[i] /= length;
}

bool saltus_dense_finite(const double *a, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!isfinite(a[i]))
            return false;
    return true;
}

bool saltus_dense_factor(saltus_dense_lu *lu, const double *a) {
    int n = lu->n;
    lu->sign = 0;
    lu->log_modulus = -INFINITY;
    lu->reciprocal = 0;
    if (!saltus_dense_finite(a, (size_t)(n * n)))
        return false;
    memcpy(lu->factors, a, (size_t)(n * n) * sizeof *a);
    /* Scale rows and columns (of the transpose) by powers of two; this fails if one of them is zero. */
    double rows, columns, largest;
    if (LAPACKE_dgeequb_work(LAPACK_COL_MAJOR, n, n, lu->factors, n, lu->row_scale, lu->column_scale, &rows,
                             &columns, &largest) != 0)
        return false;
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++)
            lu->factors[j * n + i] *= lu->row_scale[i] * lu->column_scale[j];
    double size = LAPACKE_dlange_work(LAPACK_COL_MAJOR, '1', n, n, lu->factors, n, lu->work);
    if (LAPACKE_dgetrf_work(LAPACK_COL_MAJOR, n, n, lu->factors, n, lu->pivots) != 0)
        return false;
    lu->sign = 1;
    lu->log_modulus = 0;
    for (int i = 0; i < n; i++) {
        double pivot = lu->factors[i * n + i];
        lu->sign *= ((pivot < 0) != (lu->pivots[i] != i + 1)) ? -1 : 1;
        lu->log_modulus += log(fabs(pivot)) - log(lu->row_scale[i]) - log(lu->column_scale[i]);
    }
    return LAPACKE_dgecon_work(LAPACK_COL_MAJOR, '1', n, lu->factors, n, size, &lu->reciprocal, lu->work,
                               lu->integers) == 0;
}

void saltus_dense_resolve(saltus_dense_lu *lu, bool transposed, int count, double *b) {
    int n = lu->n;
    const double *before = transposed ? lu->row_scale : lu->column_scale;
    const double *after = transposed ? lu->column_scale : lu->row_scale;
    for (int k = 0; k < count; k++)
        for (int i = 0; i < n; i++)
            b[k * n + i] *= before[i];
    LAPACKE_dgetrs_work(LAPACK_COL_MAJOR, transposed ? 'N' : 'T', n, count, lu->factors, n, lu->pivots, b, n);
    for (int k = 0; k < count; k++)
        for (int i = 0; i < n; i++)
            b[k * n + i] *= after[i];
}

/* LAPACK sees the transpose of a, whose left singular vectors are the right ones of a. */
saltus_status saltus_dense_null_vectors(double *a, int m, int n, int k, double *vectors, double *values) {
    size_t size = (size_t)n;
    double *left = calloc(size * size + 2 * size, sizeof *left), unused = 0;
    if (!left)
        return SALTUS_NO_MEMORY;
    double *singular = left + size * size, *rest = singular + size;
    /* LAPACKE allocates LAPACK's work space here. */
    const lapack_int info =
        LAPACKE_dgesvd(LAPACK_COL_MAJOR, 'A', 'N', n, m, a, n, singular, left, n, &unused, 1, rest);
    for (int i = 0; i < k && info == 0; i++) {
        values[i] = singular[n - 1 - i];
        memcpy(vectors + (size_t)i * size, left + (size_t)(n - 1 - i) * size, size * sizeof *vectors);
    }
    free(left);
    const bool memory = info == LAPACK_WORK_MEMORY_ERROR || info == LAPACK_TRANSPOSE_MEMORY_ERROR;
    return info == 0 ? SALTUS_OK : memory ? SALTUS_NO_MEMORY : SALTUS_NO_CONVERGENCE;
}

/* Apply I - tau w w^T to the rows of a from `column` on, in the columns from `from` on. w = (1, ...); its
 * other entries stand in `column` of v. */
static void reflect(double *a, int n, int from, const double *v, int column, double tau, double *sums) {
    for (int j = from; j < n; j++)
        sums[j] = a[column * n + j];
    for (int i = column + 1; i < n; i++)
        for (int j = from; j < n; j++)
            sums[j] += v[i * n + column] * a[i * n + j];
    for (int j = from; j < n; j++) {
        sums[j] *= tau;
        a[column * n + j] -= sums[j];
    }
    for (int i = column + 1; i < n; i++)
        for (int j = from; j < n; j++)
            a[i * n + j] -= v[i * n + column] * sums[j];
}

/* Householder vector of a column of a, stored below the diagonal; the diagonal entry becomes the column's
 * length. */
static double householder(double *a, int n, int column) {
    double first = a[column * n + column], rest = 0;
    for (int i = column + 1; i < n; i++)
        rest += a[i * n + column] * a[i * n + column];
    if (rest == 0 && first >= 0)
        return 0;
    double length = sqrt(first * first + rest);
    double head = first > 0 ? -rest / (first + length) : first - length;
    for (int i = column + 1; i < n; i++)
        a[i * n + column] /= head;
    a[column * n + column] = length;
    return -head / length;
}

void saltus_dense_qr(double *a, int n, double *q, double *work) {
    double *tau = work, *sums = work + n;
    for (int k = 0; k < n; k++) {
        tau[k] = householder(a, n, k);
        if (tau[k] != 0)
            reflect(a, n, k + 1, a, k, tau[k], sums);
    }
    memset(q, 0, (size_t)(n * n) * sizeof *q);
    for (int k = n - 1; k >= 0; k--) {
        q[k * n + k] = 1;
        if (tau[k] != 0)
            reflect(q, n, k, a, k, tau[k], sums);
    }
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++)
            a[i * n + j] = 0;
}

enum { block_columns = 32 };

int saltus_dense_orthonormal_work(int count) {
    return count + block_columns * count;
}

bool saltus_dense_orthonormal(double *vectors, int n, int count, double *length, double *work) {
    double *tau = work;
    if (count == 1) {
        const double size = sqrt(saltus_dot(vectors, vectors, n));
        for (int i = 0; i < n && size > 0; i++)
            vectors[i] /= size;
        *length = size;
        return isfinite(size);
    }
    if (!saltus_dense_finite(vectors, (size_t)(n * count)))
        return false;
    if (LAPACKE_dgeqrf_work(LAPACK_COL_MAJOR, n, count, vectors, n, tau, work + count,
                            block_columns * count) != 0)
        return false;
    for (int k = 0; k < count; k++)
        length[k] = fabs(vectors[k * n + k]);
    return LAPACKE_dorgqr_work(LAPACK_COL_MAJOR, n, count, count, vectors, n, tau, work + count,
                               block_columns * count) == 0;
}
