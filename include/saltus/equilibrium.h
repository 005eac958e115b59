/* Equilibria of scenes without forcing, free or held against stops, and their stability.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_EQUILIBRIUM_H
#define SALTUS_EQUILIBRIUM_H

#include "saltus/system.h"

SALTUS_API_BEGIN

typedef struct saltus_equilibrium_options {
    int iterations;   /* Newton steps at most, for each set of contacts tried; default 50 */
    double tolerance; /* last Newton step relative to the system's scales at which it has converged; default
                         1e-12 */
} saltus_equilibrium_options;

/* As told beside the options. */
saltus_equilibrium_options saltus_equilibrium_defaults(void);

/* An eigenvalue of the linearised motion: perturbations go with exp((re + i im) t). */
typedef struct saltus_eigenvalue {
    double re, im;
} saltus_eigenvalue;

/* A rest. Arrays are owned by it. */
typedef struct saltus_equilibrium {
    int dimension;
    double *state;                          /* dimension; velocities are exact zeros */
    unsigned contacts;                      /* faces that hold, as bits; 0: free */
    double contact_force[SALTUS_FACES_MAX]; /* as saltus_flow_forces has them */
    double gap[SALTUS_FACES_MAX];           /* negative inside, 0 where a contact holds */
    /* By decreasing real part. A held contact takes two directions away, its displacement and its velocity:
     * there are dimension - 2 contacts of them, those of the motion that keeps in contact. */
    saltus_eigenvalue *eigenvalues;
    int eigenvalue_count;
    int instability; /* eigenvalues with a positive real part */
    bool stable;     /* all real parts are negative and all contacts push */
    int iterations;  /* Newton steps, over all sets of contacts tried */
    double residual; /* last Newton step relative to the system's scales */
} saltus_equilibrium;

/* Find an equilibrium near a guess (length dimension; its velocities do not matter, and it may lie beyond
 * stops). Which contacts hold comes out: a contact force must push, no stop may be passed; faces that the
 * guess touches are tried first. On success the arrays are owned by the equilibrium:
 * saltus_equilibrium_clear. Errors: SALTUS_BAD_INPUT (the scene is forced, the guess is not finite),
 * SALTUS_SINGULAR (the equilibrium is not isolated: a continuum of rests), SALTUS_NO_CONVERGENCE,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_equilibrium_find(const saltus_system *system, const double *guess,
                                      const saltus_equilibrium_options *options,
                                      saltus_equilibrium *equilibrium, saltus_message *message);
/* Free the arrays; a zeroed equilibrium is accepted. */
void saltus_equilibrium_clear(saltus_equilibrium *equilibrium);

SALTUS_API_END
#endif
