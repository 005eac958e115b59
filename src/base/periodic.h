/* Eigenvalues of matrix products that must not be multiplied out.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_PERIODIC_H
#define SALTUS_BASE_PERIODIC_H

#include <stdbool.h>

/* Eigenvalues of the product h r_count ... r_1 of a matrix h and upper triangular matrices r_1, r_2, ...,
 * stored one after the other. All are n x n, row-major, and overwritten. The products of their diagonal
 * entries must not underflow: take out common factors before, so that diagonals are of order one. `product`
 * is work space of n x n entries. False if the iteration fails or an entry is not finite. Never allocates. */
bool saltus_periodic_eigenvalues(double *h, double *triangles, int n, int count, double *product,
                                 double *real, double *imaginary);

#endif
