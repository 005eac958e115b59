/* Small dense linear algebra on LAPACKE. Matrices are row-major unless stated. Where a function returns false
 * its outputs are undefined.
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
    int sign;           /* of the determinant; 0 where a pivot is exactly zero */
    double log_modulus; /* natural logarithm of the determinant's modulus; -INFINITY where it is zero */
    double reciprocal;  /* estimated reciprocal condition number of the equilibrated matrix */
} saltus_dense_lu;

/* Room for n x n matrices; false if there is no memory. */
bool saltus_dense_lu_open(saltus_dense_lu *lu, int n);
/* A zeroed factorisation is accepted. */
void saltus_dense_lu_close(saltus_dense_lu *lu);
/* The sum of products, in their order. */
double saltus_dot(const double *a, const double *b, int n);
/* Whether no entry is infinite or not a number. */
bool saltus_dense_finite(const double *a, size_t count);
/* Equilibrate and factor a, which stays as it is; sign, log_modulus and reciprocal are set in any case. False
 * if a pivot is exactly zero or an entry is not finite: then there is nothing to solve with. Never allocates.
 */
bool saltus_dense_factor(saltus_dense_lu *lu, const double *a);
/* Solve a x = b, or a^T x = b if `transposed`, in place for `count` right-hand sides of length n that stand
 * one after the other. Never allocates. */
void saltus_dense_resolve(saltus_dense_lu *lu, bool transposed, int count, double *b);

/* The right singular vectors of an m x n matrix (m <= n, overwritten) that belong to its k <= n smallest
 * singular values, as rows of `vectors` (k x n), smallest first, and these values (k; exact zeros for the n -
 * m that only the shape makes). With k = n - m the rows span the null space of a matrix of full rank.
 * Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_dense_null_vectors(double *a, int m, int n, int k, double *vectors, double *values);

/* QR factorisation of an n x n matrix: a becomes the upper triangle with a diagonal that is not negative, q
 * the orthogonal factor. `work` has 2 n entries. Never allocates: made for the many small matrices around an
 * orbit, at which it takes 0.4 times as long as LAPACK. */
void saltus_dense_qr(double *a, int n, double *q, double *work);

/* Make `count` <= n vectors of length n, one after the other, orthonormal in their order; `length` receives
 * how long each one is across those before it (the diagonal of R in a QR factorisation). `work` has
 * saltus_dense_orthonormal_work(count) entries. Never allocates. False if an entry is not finite. */
bool saltus_dense_orthonormal(double *vectors, int n, int count, double *length, double *work);
int saltus_dense_orthonormal_work(int count);

#endif
