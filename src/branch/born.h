/* Private: cycles that are born at equilibria: at Hopf points, and where an equilibrium meets a stop. Lack of
 * memory is noted in the equations of the equilibria.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_BORN_H
#define SALTUS_BRANCH_BORN_H

#include "branch/rest.h"
#include "branch/special.h"

/* What an equilibrium with a pair of eigenvalues +-i omega says about the cycles near it. */
typedef struct saltus_hopf {
    double omega;
    /* The first Lyapunov coefficient in Kuznetsov's normalisation (Elements of Applied Bifurcation Theory,
     * 5.34, with an eigenvector of unit length), and its possible error. Negative: the cycles born there are
     * stable, as far as the other eigenvalues allow. NAN if it cannot be computed. */
    double coefficient, error;
    double vector[2][SALTUS_STATE_MAX]; /* real and imaginary part of the eigenvector */
} saltus_hopf;

/* In hopf.c. False if there is no such pair. */
bool saltus_hopf_find(saltus_rests *rests, const saltus_rest *at, saltus_hopf *hopf);
/* The unit vector, scaled (n), along the cycles born there where their observed displacement turns. */
void saltus_hopf_direction(const saltus_rests *rests, const saltus_hopf *hopf, double *tangent);
/* `out` becomes what may be near a cycle: with the sequence of an equilibrium's contacts and frequency, its
 * base, `apart` from the equilibrium along such a vector. Errors: the flow's, SALTUS_NO_MEMORY. */
saltus_status saltus_hopf_aside(saltus_orbits *orbits, const double *parameters, const double *rest,
                                const double *tangent, double apart, const saltus_sequence *like,
                                saltus_solution *out, saltus_message *message);

/* In boundary.c. Add to `starts` the cycles with one impact that begin at `at`, an equilibrium without
 * contacts that touches a face; `like` has what the starts have in common. The equations must be shaped for
 * its contacts; `scratch` is overwritten. None is added if another face holds or impacts do not rebound. */
void saltus_boundary_leave(saltus_rests *rests, const saltus_rest *at, int face,
                           const saltus_branch_start *like, saltus_rest *scratch, saltus_starts *starts);
/* The cycle of such a start at this distance in the parameter; not surveyed, with a tangent away from the
 * equilibrium. Errors: SALTUS_NO_MEMORY; others if none is found. */
saltus_status saltus_boundary_cycle(saltus_orbits *orbits, const saltus_branch_start *start, double distance,
                                    saltus_solution *out, saltus_message *message);
/* Where small cycles with impacts, but without lasting contacts, shrink to an equilibrium: `zero`, from
 * `here`, the parameter's *value there, and the last cycle as `at`, whose sequence the shooting has. False if
 * they do not; the shooting then has that of `here`. */
bool saltus_boundary_reach(saltus_orbits *orbits, const saltus_solution *here, const saltus_solution *next,
                           saltus_solution *at, saltus_zero *zero, double *value);

/* In newborn.c. Add to `starts` stable cycles that begin at `at`, an equilibrium that touches a face, unless
 * they are there already; with any events in a period and whatever other faces hold; in the form of
 * saltus_boundary_leave. The equations are shaped for the contacts of `at`; `scratch` is overwritten. A fixed
 * set of motions is tried: to find no cycle does not prove that there is none. */
void saltus_newborn_find(saltus_rests *rests, const saltus_rest *at, int face,
                         const saltus_orbit_options *options, const saltus_branch_start *like,
                         saltus_rest *scratch, saltus_starts *starts);

#endif
