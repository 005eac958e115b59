/* Private: equilibria of a family of scenes without forcing, free or held against stops, as solutions of
 * equations that are followed by pseudo-arclength.
 *
 * With contacts C the unknowns are the displacements, the further states and the contact forces, the
 * equations f(x) - push force = 0 and gap of C = 0: regular wherever the equilibrium is isolated. With two
 * parameters one equation more makes the equilibrium special: half the sum of two eigenvalues is zero (Hopf),
 * a face that does not hold is touched (boundary equilibrium), or the Jacobian is singular (fold; by borders,
 * Govaerts, Numerical methods for bifurcations of dynamical equilibria, SIAM 2000). The gradients of the
 * first and the last are differences: their error does not touch what is found, only how fast.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_REST_H
#define SALTUS_BRANCH_REST_H

#include "branch/curve.h"
#include "orbit/shooting.h"
#include "saltus/branch.h"
#include "saltus/equilibrium.h"
#include "system/system.h"

enum { SALTUS_REST_UNKNOWNS_MAX = SALTUS_STATE_MAX + SALTUS_FACES_MAX + 2 };

/* What makes the equilibria of a curve in two parameters special. Who follows the curve renews it from point
 * to point. */
typedef struct saltus_rest_special {
    saltus_point_kind kind; /* HB, BE or LP */
    int face;               /* BE: that is touched */
    double square;          /* HB: product of the two eigenvalues, which tells them from others */
    /* LP: borders of the Jacobian, below and to its right: its null vectors at a point near by. */
    double right[SALTUS_REST_UNKNOWNS_MAX], left[SALTUS_REST_UNKNOWNS_MAX];
} saltus_rest_special;

/* The equations of equilibria. All but the first three members are rest.c's to write, and the scales of the
 * rows, which a run that goes on reads back. */
typedef struct saltus_rests {
    saltus_family family;               /* one or two parameters */
    double origin[2];                   /* their values at the specification */
    const saltus_rest_special *special; /* of two parameters, the caller's; of one: NULL */
    int n, dof, width;                  /* states; displacements; unknowns that are states */
    saltus_system *first; /* at the specification: the metric stays its, however the parameters change */
    const double *state_scale;
    double force_scale, rate_scale;
    /* Of the contacts that the equations have been shaped for. */
    unsigned contacts;
    int size; /* equations of an equilibrium that need not be special: the unknowns from there on are the
                 parameters' */
    saltus_equations equations;
    double *row_scale;     /* width */
    saltus_system *system; /* at the parameters last asked for */
    struct saltus_rest_work *work;
    gsl_root_fsolver *solver; /* Brent's method, for whom it may serve */
    bool starved;             /* memory was lacking, be it for something that was only tried */
} saltus_rests;

/* An equilibrium: a point of the curve. */
typedef struct saltus_rest {
    saltus_curve_point at;
    unsigned contacts;
    double parameter[2], value[2];
    double *state;                                         /* n */
    double force[SALTUS_FACES_MAX], gap[SALTUS_FACES_MAX]; /* as saltus_equilibrium has them */
    double breach[SALTUS_FACES_MAX]; /* scaled: the gap of a free face, minus the force of a held one */
    saltus_eigenvalue *rates;        /* by decreasing real part */
    int rate_count, unstable;
    bool stable;
    double trace;        /* of the vector field's Jacobian, which the rates add up to; NAN in contact */
    saltus_scaled pairs; /* product of the sums of all two of them */
} saltus_rest;

/* With family, origin and special filled in; close in any case. Errors: SALTUS_NO_MEMORY, SALTUS_BAD_INPUT.
 */
saltus_status saltus_rests_open(saltus_rests *rests, saltus_message *message);
void saltus_rests_close(saltus_rests *rests);
/* The equations become those of other contacts; rows are scaled anew by the Jacobian at a state and
 * parameters. Errors: SALTUS_NO_MEMORY, SALTUS_STALLED where these contacts cannot hold together. */
saltus_status saltus_rests_shape(saltus_rests *rests, unsigned contacts, const double *state,
                                 const double *parameters, saltus_message *message);
/* The unknowns of a state, parameters, and forces that follow from them. Errors: those of the evaluation. */
saltus_status saltus_rests_fill(saltus_rests *rests, const double *parameters, const double *state, double *u,
                                saltus_message *message);
/* The Jacobian's null vectors at u, `size` numbers each. Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_rests_null_vectors(saltus_rests *rests, const double *u, double *right, double *left,
                                        saltus_message *message);
/* Which two eigenvalues of the equilibrium at u a Hopf point is made of, from the product that they are near:
 * half their sum, and their product. NAN where there are not two. */
double saltus_rests_pair(saltus_rests *rests, const double *u, double near, double *square);
/* The Jacobian of the motion that keeps the contacts, count x count, at a state aside of u by `by` times a
 * vector of that motion's coordinates (NULL: at u). *count <= n. Errors: no value there. */
saltus_status saltus_rests_linear(saltus_rests *rests, const double *u, const double *aside, double by,
                                  double *matrix, int *count, saltus_message *message);
/* Note whether a status tells that memory was lacking, and return it: where failures of what is only tried
 * are passed over, that one must not be. */
saltus_status saltus_rests_noted(saltus_rests *rests, saltus_status status);
/* A vector of the motion's coordinates as one of states (n). After saltus_rests_linear. */
void saltus_rests_lift(const saltus_rests *rests, int count, const double *vector, double *state);

/* An equilibrium with contacts at one parameter, polished or only evaluated, becomes `out`; `tangent`: where
 * branches cross, that of the one; NULL: its own, of either sign. The equations become those of the contacts.
 * Errors: those of them, SALTUS_NO_MEMORY. */
saltus_status saltus_rest_place(saltus_rests *rests, unsigned contacts, const double *state,
                                const double *parameter, bool polish, const double *tangent, saltus_rest *out,
                                saltus_message *message);
void saltus_rest_clear(saltus_rest *rest);
/* All but the tangent from the unknowns rest->at.u. Errors: SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_rest_see(saltus_rests *rests, saltus_rest *rest, saltus_message *message);
saltus_status saltus_rest_visit(saltus_rests *rests, const saltus_rest *from, double ahead, saltus_rest *out,
                                saltus_message *message);

#endif
