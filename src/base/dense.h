/* Small dense linear algebra on LAPACKE. Matrices are row-major unless stated.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_DENSE_H
#define SALTUS_BASE_DENSE_H

#include <stdbool.h>

enum { SALTUS_DENSE_INVERSE_MAX = 16 };

/* inverse = a^-1 for n <= SALTUS_DENSE_INVERSE_MAX; false if a is singular to working precision. Never
 * allocates. */
bool saltus_dense_inverse(const double *a, int n, double *inverse);

/* Solve a x = b in place (a and b are overwritten, b by x), with the reciprocal condition number of the row-
 * and column-equilibrated matrix; false if singular. `pivots` has n entries. */
bool saltus_dense_solve(double *a, int n, double *b, int *pivots);

/* Eigenvalues of an n x n matrix (overwritten), unordered; false if the QR iteration fails. */
bool saltus_dense_eigenvalues(double *a, int n, double *real, double *imaginary);

/* QR factorisation with the columns stored one after the other: `a` (rows x columns) becomes Q, the upper
 * triangle goes to `r` (row-major, columns x columns), diagonal made non-negative. `tau` has `columns`
 * entries. */
bool saltus_dense_qr(double *a, int rows, int columns, double *r, double *tau);

#endif
