/* Eigenvalues of products of matrices that are not to be multiplied out.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_PERIODIC_H
#define SALTUS_BASE_PERIODIC_H

#include <stdbool.h>

/* Eigenvalues of the product h r_count ... r_1 of a matrix h and upper triangles r_1, r_2, ... that stand one
 * after the other; all n x n, row-major, overwritten. Their diagonals should be of order one on the whole
 * (take common factors out before): the product of a diagonal must not underflow. `product` has n x n
 * entries. False if the iteration fails or an entry is not finite. Never allocates. */
bool saltus_periodic_eigenvalues(double *h, double *triangles, int n, int count, double *product,
                                 double *real, double *imaginary);

#endif
