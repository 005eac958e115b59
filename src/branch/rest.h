/* Private: equilibria of a family of scenes without forcing, free or held against stops, as solutions of
 * equations that are followed by pseudo-arclength.
 *
 * With contacts C the unknowns are the displacements, the further states and the contact forces; the
 * equations are f(x) - push force = 0 and gap = 0 for each of C. They are regular wherever the equilibrium is
 * isolated. One more equation, and unknown, makes the equilibrium special: half the sum of two
 * eigenvalues is zero (Hopf), a face that does not hold is touched (boundary equilibrium), or the Jacobian is
 * singular (fold; by borders, Govaerts, Numerical methods for bifurcations of dynamical equilibria, SIAM
 * 2000). The gradients of the first and the last are differences: their error affects the speed of
 * convergence, not the result.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_REST_H
#define SALTUS_BRANCH_REST_H

#include "branch/curve.h"
#include "orbit/shooting.h"
#include "saltus/branch.h"
#include "saltus/equilibrium.h"
#include "system/system.h"

enum { SALTUS_REST_UNKNOWNS_MAX = SALTUS_STATE_MAX + SALTUS_FACES_MAX + 2, SALTUS_REST_TESTS = 2 };

/* What makes the equilibria on a curve in two parameters special. The code that follows the curve renews it
 * from point to point. */
typedef struct saltus_rest_special {
    saltus_point_kind kind; /* HB, BE or LP; REGULAR: nothing */
    int face;               /* BE: the face that is touched */
    double square;          /* HB: product of the two eigenvalues, which identifies them */
    /* LP: borders of the Jacobian, below it and to its right: its null vectors at a nearby point. */
    double right[SALTUS_REST_UNKNOWNS_MAX], left[SALTUS_REST_UNKNOWNS_MAX];
} saltus_rest_special;

/* The equations of equilibria. Only rest.c writes the members after the first three; but a resumed run also
 * reads back row_scale. */
typedef struct saltus_rests {
    saltus_family family; /* one or two parameters */
    double origin[2];     /* the parameters' values at the specification */
    saltus_rest_special special;
    int n, dof, width;    /* states; displacements; unknowns that are states */
    saltus_system *first; /* at the specification: its metric is used at all parameters */
    const double *state_scale;
    double force_scale, rate_scale;
    /* For the contacts for which the equations are shaped. */
    unsigned contacts;
    int size; /* number of equations without the special one; the unknowns from this index on are the
                 parameters and, of special ones in one parameter, one without effect */
    saltus_equations equations;
    double *row_scale;     /* width */
    saltus_system *system; /* at the parameters last used */
    struct saltus_rest_work *work;
    gsl_root_fsolver *solver; /* Brent's method, for users of these equations */
    bool starved;             /* memory was lacking, perhaps only for an attempt */
} saltus_rests;

/* An equilibrium: a point of the curve. */
typedef struct saltus_rest {
    saltus_curve_point at;
    unsigned contacts;
    double parameter[2], value[2];
    double state[SALTUS_STATE_MAX];
    double force[SALTUS_FACES_MAX], gap[SALTUS_FACES_MAX]; /* as saltus_equilibrium has them */
    double breach[SALTUS_FACES_MAX]; /* scaled: gap of a free face, or minus the force of a contact */
    saltus_eigenvalue rates[SALTUS_STATE_MAX]; /* by decreasing real part */
    int rate_count, unstable;
    bool stable;
    double trace;        /* of the vector field's Jacobian, the sum of the rates; NAN in contact */
    saltus_scaled pairs; /* product of the sums of all pairs of rates */
    /* On curves in two parameters: the functions whose zeros are points of codimension two; NAN: none. */
    double tests[SALTUS_REST_TESTS];
} saltus_rest;

/* family and origin must be set; close in any case. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT. */
saltus_status saltus_rests_open(saltus_rests *rests, saltus_message *message);
void saltus_rests_close(saltus_rests *rests);
/* Shape the equations for these contacts; rows are scaled by the Jacobian at a state and parameters. Errors:
 * SALTUS_NO_MEMORY, those of the evaluation. */
saltus_status saltus_rests_shape(saltus_rests *rests, unsigned contacts, const double *state,
                                 const double *parameters, saltus_message *message);
/* The unknowns at a state and parameters, with the contact forces that follow. Errors: those of the
 * evaluation, SALTUS_STALLED if the contacts cannot hold together. */
saltus_status saltus_rests_fill(saltus_rests *rests, const double *parameters, const double *state, double *u,
                                saltus_message *message);
/* Both: shape the equations, and `at` gets the unknowns of that equilibrium, which the equations may not yet
 * hold for. Errors: as above. */
saltus_status saltus_rests_begin(saltus_rests *rests, unsigned contacts, const double *state,
                                 const double *parameters, saltus_curve_point *at, saltus_message *message);
/* The Jacobian's null vectors at u, `size` numbers each. Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_rests_null_vectors(saltus_rests *rests, const double *u, double *right, double *left,
                                        saltus_message *message);
/* Half the sum of the two eigenvalues, at the equilibrium at u, whose product is closest to `near` and whose
 * sum is small: those of a Hopf point. *square: their product. NAN if there are no two. */
double saltus_rests_pair(saltus_rests *rests, const double *u, double near, double *square);
/* The Jacobian of the motion that keeps the contacts, count x count, at a state displaced from u by `by`
 * times `aside` in that motion's coordinates (NULL: at u). *count <= n. Errors: the field has no value
 * there. */
saltus_status saltus_rests_linear(saltus_rests *rests, const double *u, const double *aside, double by,
                                  double *matrix, int *count, saltus_message *message);
/* Note if a status says that memory was lacking, and return it: failures of mere attempts are passed over,
 * but not this one. */
saltus_status saltus_rests_noted(saltus_rests *rests, saltus_status status);
/* A vector in the motion's coordinates as a state (n). Call it after saltus_rests_linear. */
void saltus_rests_lift(const saltus_rests *rests, int count, const double *vector, double *state);

/* `out` becomes an equilibrium with these contacts at one parameter, polished or only evaluated. `tangent`:
 * for a branch from a crossing, where the equations are singular; NULL: their own, of either sign. The
 * equations are shaped for the contacts. Errors: those of the equations, SALTUS_NO_MEMORY. */
saltus_status saltus_rest_place(saltus_rests *rests, unsigned contacts, const double *state,
                                const double *parameter, bool polish, const double *tangent, saltus_rest *out,
                                saltus_message *message);
void saltus_rest_clear(saltus_rest *rest);
/* Fill in all but the tangent from the unknowns rest->at.u. Errors: SALTUS_NO_MEMORY,
 * SALTUS_NO_CONVERGENCE. */
saltus_status saltus_rest_see(saltus_rests *rests, saltus_rest *rest, saltus_message *message);
saltus_status saltus_rest_visit(saltus_rests *rests, const saltus_rest *from, double ahead, saltus_rest *out,
                                saltus_message *message);

#endif
