/* Private: Hopf points of equilibria, and the cycles that are born there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_HOPF_H
#define SALTUS_BRANCH_HOPF_H

#include "branch/rest.h"
#include "branch/solution.h"

/* What an equilibrium with a pair of eigenvalues +-i omega says about the cycles near it. */
typedef struct saltus_hopf {
    double omega;
    /* The first Lyapunov coefficient in Kuznetsov's normalisation (Elements of Applied Bifurcation Theory,
     * 5.34, with an eigenvector of unit length), and its possible error. Negative: the cycles born there are
     * stable, as far as the other eigenvalues allow. NAN if it cannot be computed. */
    double coefficient, error;
    double vector[2][SALTUS_STATE_MAX]; /* real and imaginary part of the eigenvector */
} saltus_hopf;

/* Errors: SALTUS_NO_MEMORY; SALTUS_NO_CONVERGENCE if there is no such pair. */
saltus_status saltus_hopf_find(saltus_rests *rests, const saltus_rest *at, saltus_hopf *hopf);
/* The unit vector, scaled (n), along the cycles born there where their observed displacement turns. */
void saltus_hopf_direction(const saltus_rests *rests, const saltus_hopf *hopf, double *tangent);
/* The state `apart` from an equilibrium along such a vector, and the sequence, of its contacts and frequency,
 * of a cycle whose period is an unknown with its base there. Errors: the flow's, SALTUS_NO_MEMORY. */
saltus_status saltus_hopf_aside(saltus_orbits *orbits, const double *parameters, const double *rest,
                                const double *tangent, double apart, saltus_sequence *sequence, double *state,
                                saltus_message *message);

#endif
