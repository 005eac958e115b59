/* Periodic orbits by Newton's method on the period map, and their Floquet multipliers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PRECISE_SHOOT_H
#define PRECISE_SHOOT_H

#include "passage.h"

/* From `state` to the orbit that closes after `periods`: the state is replaced, the passage is the last one
 * and *residual the distance left between its ends. `matrix` (row-major) receives the derivative of the
 * period map; when `known` it is given, never computed, and converges Newton's method as fast as it is
 * accurate. On failure: a phrase that says why. */
const char *shoot(step *s, int periods, real *state, passage *p, real *matrix, bool known, real *residual);

/* Gauss with the largest pivot of each column: a x = b, both destroyed, x in b; a is n x n, row-major. */
bool shoot_solve(int n, real *a, real *b);

/* The largest component of a difference of states; velocities are divided by omega. */
real shoot_distance(const model *m, const real *difference);

/* Eigenvalues of the n x n matrix a (row-major, destroyed) by decreasing modulus; false if there is no end.
 */
bool eigenvalues(int n, complex_real *a, complex_real *values);

#endif
