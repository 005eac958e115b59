/* Equilibria of scenes without forcing, free or held against stops, and their stability.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_EQUILIBRIUM_H
#define SALTUS_EQUILIBRIUM_H

#include "saltus/system.h"

SALTUS_API_BEGIN

typedef struct saltus_equilibrium_options {
    int iterations;   /* most Newton steps for each set of contacts tried; default 50 */
    double tolerance; /* converged when a Newton step, relative to the system's scales, is smaller; default
                         1e-12 */
} saltus_equilibrium_options;

/* The defaults stated beside the options. */
saltus_equilibrium_options saltus_equilibrium_defaults(void);

/* An eigenvalue of the linearised motion: perturbations evolve as exp((re + i im) t). */
typedef struct saltus_eigenvalue {
    double re, im;
} saltus_eigenvalue;

/* An equilibrium, which owns its arrays. */
typedef struct saltus_equilibrium {
    int dimension;
    double *state;                          /* dimension; velocities are exact zeros */
    unsigned contacts;                      /* faces in contact, as bits; 0: free */
    double contact_force[SALTUS_FACES_MAX]; /* as saltus_flow_forces has them */
    double gap[SALTUS_FACES_MAX];           /* negative inside, 0 where a contact holds */
    /* By decreasing real part. Each held contact removes two directions, its displacement and its velocity,
     * which leaves dimension - 2 contacts eigenvalues: those of motion in contact. */
    saltus_eigenvalue *eigenvalues;
    int eigenvalue_count;
    int instability; /* eigenvalues with a positive real part */
    bool stable;     /* all real parts are negative and all contacts push */
    int iterations;  /* Newton steps, summed over all sets of contacts tried */
    double residual; /* last Newton step relative to the system's scales */
} saltus_equilibrium;

/* Find an equilibrium near a guess (length dimension), whose velocities are ignored and which may lie beyond
 * stops. The set of holding contacts is part of the solution: contact forces must push and no stop may be
 * passed; faces that the guess touches are tried first. On success free the arrays with
 * saltus_equilibrium_clear. Errors: SALTUS_BAD_INPUT (the scene is forced, the guess is not finite),
 * SALTUS_SINGULAR (the equilibrium is not isolated), SALTUS_NO_CONVERGENCE, SALTUS_NO_MEMORY. */
saltus_status saltus_equilibrium_find(const saltus_system *system, const double *guess,
                                      const saltus_equilibrium_options *options,
                                      saltus_equilibrium *equilibrium, saltus_message *message);
/* Free the arrays; a zeroed equilibrium is accepted. */
void saltus_equilibrium_clear(saltus_equilibrium *equilibrium);

SALTUS_API_END
#endif
