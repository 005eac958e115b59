/* Small dense linear algebra on LAPACKE. Matrices are row-major unless stated otherwise. Outputs are
 * undefined where a function returns false.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_DENSE_H
#define SALTUS_BASE_DENSE_H

#include "base/memory.h"
#include "saltus/status.h"

#include <stdbool.h>

enum { SALTUS_DENSE_INVERSE_MAX = 16 };

/* inverse = a^-1 for n <= SALTUS_DENSE_INVERSE_MAX; false if a is singular to working precision. Never
 * allocates. */
bool saltus_dense_inverse(const double *a, int n, double *inverse);

/* Solve a x = b in place (a and b are overwritten, b by x); false if a pivot is exactly zero. `pivots` has n
 * entries. */
bool saltus_dense_solve(double *a, int n, double *b, int *pivots);

/* Eigenvalues of an n x n matrix (overwritten), unordered; false if the QR iteration fails. */
bool saltus_dense_eigenvalues(double *a, int n, double *real, double *imaginary);

/* A factorisation kept for several right-hand sides. */
typedef struct saltus_dense_lu {
    saltus_arena arena;
    int n;
    double *factors;                  /* of the equilibrated matrix */
    double *row_scale, *column_scale; /* powers of two */
    double *work;
    int *pivots, *integers;
    int sign;           /* of the determinant; 0 if there is no factorisation */
    double log_modulus; /* natural logarithm of |determinant|; -INFINITY if there is no factorisation */
    double reciprocal;  /* estimated reciprocal condition number of the equilibrated matrix */
} saltus_dense_lu;

/* Allocate for n x n matrices; false if there is no memory. */
bool saltus_dense_lu_open(saltus_dense_lu *lu, int n);
/* Accepts a zeroed factorisation. */
void saltus_dense_lu_close(saltus_dense_lu *lu);
/* Dot product, summed in the order of the entries. */
static inline double saltus_dot(const double *a, const double *b, int n) {
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}
/* Euclidean length, summed in the order of the entries; and scale a vector to length 1. */
double saltus_length(const double *v, int n);
void saltus_make_unit(double *v, int n);
/* Whether no entry is infinite or not a number. */
bool saltus_dense_finite(const double *a, size_t count);
/* Equilibrate and factor a, which is not changed. sign, log_modulus and reciprocal are always set. False,
 * with nothing to solve with, if a pivot is exactly zero or an entry is not finite. Never allocates. */
bool saltus_dense_factor(saltus_dense_lu *lu, const double *a);
/* Solve a x = b, or a^T x = b if `transposed`, in place for `count` right-hand sides of length n, stored one
 * after the other. Never allocates. */
void saltus_dense_resolve(saltus_dense_lu *lu, bool transposed, int count, double *b);

/* The right singular vectors of an m x n matrix with m <= n (overwritten) for its k <= n smallest singular
 * values, as rows of `vectors` (k x n), smallest first, and these values (k entries; n - m of them are exact
 * zeros due to the shape). With k = n - m the rows span the null space of a matrix of full rank.
 * Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_dense_null_vectors(double *a, int m, int n, int k, double *vectors, double *values);

/* QR factorisation of an n x n matrix: a becomes the upper triangle with a non-negative diagonal, q the
 * orthogonal factor. `work` has 2 n entries. Never allocates. Made for the many small matrices around an
 * orbit, where it takes 0.4 times as long as LAPACK. */
void saltus_dense_qr(double *a, int n, double *q, double *work);

/* Orthonormalise `count` <= n vectors of length n, stored one after the other, in their order. `length`
 * receives the lengths of their parts orthogonal to those before (the diagonal of R of a QR factorisation).
 * `work` has saltus_dense_orthonormal_work(count) entries. Never allocates. False if not all is finite. */
bool saltus_dense_orthonormal(double *vectors, int n, int count, double *length, double *work);
int saltus_dense_orthonormal_work(int count);

#endif
