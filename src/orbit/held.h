/* Private: the motion that keeps given contacts, in reduced coordinates.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_HELD_H
#define SALTUS_ORBIT_HELD_H

#include "saltus/equilibrium.h"

/* An orthonormal basis of the displacements and velocities that keep the contacts, and of the extra states:
 * *rows rows of length n. `basis` and `scratch` have room for n x n numbers. False if there is no memory. */
bool saltus_held_basis(const saltus_system *system, unsigned contacts, double *basis, double *scratch,
                       int *rows);
/* Project the Jacobian (n columns of saltus_flow_tangent_field, contacts held) onto it: rows x rows. */
void saltus_held_reduce(const double *basis, int rows, int n, const double *jacobian, double *scratch,
                        double *matrix);
/* Eigenvalues of a reduced Jacobian (rows x rows, overwritten), by decreasing real part. Errors:
 * SALTUS_NO_CONVERGENCE. */
saltus_status saltus_held_eigenvalues(double *matrix, int rows, saltus_eigenvalue *eigenvalues,
                                      saltus_message *message);

/* Numbers of growing and decaying perturbations. A real part that is rounding beside the largest modulus
 * counts as neither, whatever the unit of time. A rest is stable if all decay. */
typedef struct saltus_growing {
    int growing, decaying;
} saltus_growing;
saltus_growing saltus_eigenvalues_growing(const saltus_eigenvalue *eigenvalues, int count);

#endif
