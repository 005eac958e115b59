/* The motion that keeps given contacts, in reduced coordinates.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/held.h"

#include "base/bits.h"
#include "base/dense.h"
#include "system/system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool saltus_held_basis(const saltus_system *system, unsigned contacts, double *basis, double *scratch,
                       int *rows) {
    int n = system->dimension, dof = system->dof, held = saltus_count_bits(contacts), width = dof - held;
    double *normals = scratch, *free_rows = normals + held * dof, *values = free_rows + width * dof;
    memset(basis, 0, (size_t)(n * n) * sizeof *basis);
    for (int f = 0, row = 0; f < system->face_count; f++)
        if (contacts >> f & 1)
            memcpy(normals + dof * row++, system->stop_normal[system->faces[f].stop],
                   (size_t)dof * sizeof *normals);
    if (held > 0 && width > 0 &&
        saltus_dense_null_vectors(normals, held, dof, width, free_rows, values) != SALTUS_OK)
        return false;
    *rows = 2 * width + system->extra;
    for (int i = 0; i < width; i++)
        for (int j = 0; j < dof; j++)
            basis[i * n + j] = basis[(width + i) * n + dof + j] = held ? free_rows[i * dof + j] : i == j;
    for (int i = 0; i < system->extra; i++)
        basis[(2 * width + i) * n + 2 * dof + i] = 1;
    return true;
}

void saltus_held_reduce(const double *basis, int rows, int n, const double *jacobian, double *scratch,
                        double *matrix) {
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < n; j++)
            scratch[i * n + j] = saltus_dot(basis + i * n, jacobian + j * n, n);
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < rows; j++)
            matrix[i * rows + j] = saltus_dot(scratch + i * n, basis + j * n, n);
}

static int by_real_part(const void *a, const void *b) {
    const saltus_eigenvalue *x = a, *y = b;
    if (x->re != y->re)
        return x->re < y->re ? 1 : -1;
    return x->im < y->im ? 1 : x->im > y->im ? -1 : 0;
}

saltus_status saltus_held_eigenvalues(double *matrix, int rows, saltus_eigenvalue *eigenvalues,
                                      saltus_message *message) {
    double re[SALTUS_STATE_MAX], im[SALTUS_STATE_MAX];
    if (rows > 0 && !saltus_dense_eigenvalues(matrix, rows, re, im))
        return saltus_fail(message, SALTUS_NO_CONVERGENCE, "the eigenvalue iteration fails");
    for (int k = 0; k < rows; k++)
        eigenvalues[k] = (saltus_eigenvalue){re[k], im[k]};
    qsort(eigenvalues, (size_t)rows, sizeof *eigenvalues, by_real_part);
    return SALTUS_OK;
}

saltus_growing saltus_eigenvalues_growing(const saltus_eigenvalue *eigenvalues, int count) {
    const double rounding = 1e-12;
    saltus_growing counts = {0, 0};
    double largest = 0;
    for (int k = 0; k < count; k++)
        largest = fmax(largest, hypot(eigenvalues[k].re, eigenvalues[k].im));
    for (int k = 0; k < count; k++) {
        counts.growing += eigenvalues[k].re > rounding * largest;
        counts.decaying += eigenvalues[k].re < -rounding * largest;
    }
    return counts;
}
