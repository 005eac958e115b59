/* Collocation at the 16 right Radau points of a step: nodes, matrices, and the solution of the linear part.
 *
 * The stages of the Radau IIA method are v = v0 + h S A and q = q0 + h c v0 + h^2 S^2 A with the integration
 * matrix S (Hairer & Wanner, Solving Ordinary Differential Equations II, section IV.5). S has eight pairs of
 * complex eigenvalues mu. In their basis a linear system q'' = Jv q' + Jq q with constant coefficients falls
 * apart into eight complex systems of the size of q, (1 - h mu Jv - (h mu)^2 Jq) a = r, which are solved side
 * by side in packs, one eigenvalue in each element. A contact that holds adds its force as one more unknown.
 * The eigenvectors are badly conditioned (1e8), but what is solved for is the correction that a residual asks
 * for, so this costs no accuracy.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_COLLOCATION_H
#define SALTUS_FLOW_COLLOCATION_H

#include "base/simd.h"
#include "system/system.h"

#include <stdbool.h>
#include <stddef.h>

enum {
    SALTUS_RADAU_NODES = 16,
    SALTUS_RADAU_PAIRS = SALTUS_RADAU_NODES / 2,
    SALTUS_RADAU_CHUNKS_MAX = SALTUS_RADAU_NODES / SALTUS_PACK_MIN
};

/* A 16 x 16 matrix that acts on rows of 16 numbers from the right: out[j] = sum_i in[i] m[i][j]. */
typedef double saltus_node_matrix[SALTUS_RADAU_NODES][SALTUS_RADAU_NODES];

/* Constants of the method. A complex row of 16 holds eight real parts, then eight imaginary parts. */
typedef struct saltus_collocation {
    saltus_node_matrix
        integral; /* node values -> node values of the integral from the step's start (h = 1) */
    saltus_node_matrix integral2; /* the same for the double integral */
    saltus_node_matrix to_pairs;  /* node values -> complex coordinates in the eigenvectors' basis */
    saltus_node_matrix to_nodes;  /* and back to node values */
    saltus_node_matrix legendre;  /* node values -> coefficients of Legendre's polynomials on [0, 1] */
    saltus_node_matrix monomial;  /* Legendre coefficients -> coefficients of powers */
    double node[SALTUS_RADAU_NODES];
    double pair[SALTUS_RADAU_NODES]; /* eigenvalues mu */
} saltus_collocation;

/* The field's linear part at one place, and its factors for one step length. */
typedef struct saltus_linear_part {
    int order[SALTUS_MODES_MAX]; /* modes in the order of elimination */
    int uncoupled;               /* leading modes in that order without linear coupling among themselves */
    const double *damp, *stiff;  /* [mode][mode] */
    double *lu; /* factors: [mode][mode][16] complex, in the order of elimination, diagonal inverted */
} saltus_linear_part;

/* Held contacts, and the linear part's response to their forces. */
typedef struct saltus_linear_contacts {
    int count;
    double *push, *pull; /* [contact][mode] */
    double *reply;       /* response to a unit contact force: [contact][mode][16] complex */
    double *schur;       /* [contact][contact][16] complex */
} saltus_linear_contacts;

/* The unknowns of one step. */
typedef struct saltus_stages {
    saltus_collocation *method;
    int dof, chunks, lanes;
    size_t row; /* doubles from column to column in the field's arrays */
    double step;
    double *q[SALTUS_RADAU_CHUNKS_MAX],
        *v[SALTUS_RADAU_CHUNKS_MAX];              /* the field's arguments: [column][mode][lane] */
    const double *field[SALTUS_RADAU_CHUNKS_MAX]; /* the field's value: accelerations */
    double *q0, *v0;                              /* at the step's start: [column][mode] */
    double *a;                                    /* accelerations: [column][mode][16] */
    double *hat;    /* residual in the eigenvectors' basis, then its correction: [mode][16] complex */
    double *change; /* largest changes of q and of v: [column][2] */
    saltus_linear_part linear;
    saltus_linear_contacts contact;
} saltus_stages;

/* The inner loops, compiled per instruction set. */
typedef struct saltus_collocation_kernel {
    int pack;
    /* Factors of the linear part for the step's length. */
    void (*factor)(saltus_stages *stages);
    /* Responses to contact forces, from the factors. */
    void (*factor_contacts)(saltus_stages *stages);
    /* Correct the accelerations of one column: solve the linear part for their residual. */
    void (*correct)(saltus_stages *stages, int column);
    /* Accelerations -> the field's arguments, with their largest changes in `change`. */
    void (*integrate)(saltus_stages *stages, int column);
    /* out = in m for rows of 16; not in place. */
    void (*apply)(const double *in, int rows, const double *m, double *out);
} saltus_collocation_kernel;

/* The kernel for packs of a width, which must be one of the field kernels'. */
const saltus_collocation_kernel *saltus_collocation_find(int pack);

/* Fill in the method's numbers; false if an eigenvalue problem fails. */
bool saltus_collocation_build(saltus_collocation *method);

/* Values P_k(2 s - 1), k < count. */
void saltus_legendre_values(double s, int count, double *values);

#endif
