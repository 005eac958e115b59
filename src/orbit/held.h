/* Private: the motion that keeps given contacts, in coordinates of its own.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_HELD_H
#define SALTUS_ORBIT_HELD_H

#include "saltus/equilibrium.h"

/* An orthonormal basis of the displacements and velocities that keep the contacts, and of the extra states:
 * rows of length n, their number to *rows. `basis` and `scratch` have room for n x n numbers. False without
 * memory. */
bool saltus_held_basis(const saltus_system *system, unsigned contacts, double *basis, double *scratch,
                       int *rows);
/* The Jacobian (n columns, as saltus_flow_tangent_field has it with the contacts held) in these coordinates,
 * rows x rows; `scratch` as above. */
void saltus_held_reduce(const double *basis, int rows, int n, const double *jacobian, double *scratch,
                        double *matrix);
/* The eigenvalues of a reduced Jacobian (rows x rows, overwritten), by decreasing real part; `re` and `im`
 * have room for them. Errors: SALTUS_NO_CONVERGENCE. */
saltus_status saltus_held_eigenvalues(double *matrix, int rows, double *re, double *im,
                                      saltus_eigenvalue *eigenvalues, saltus_message *message);

/* How many perturbations grow and how many decay: real parts that rounding hides beside the largest modulus,
 * in whatever unit of time, do neither. A rest is stable where all decay. */
typedef struct saltus_growing {
    int growing, decaying;
} saltus_growing;
saltus_growing saltus_eigenvalues_growing(const saltus_eigenvalue *eigenvalues, int count);

#endif
