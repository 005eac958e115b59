/* Private: the equations of an orbit with one more that makes it special.
 *
 * To the equations of the orbit, with both parameters unknown, comes g = 0, which makes it special. Where a
 * matrix A is singular there, bordered by vectors b and c,
 *     [A  b] [v]   [0]
 *     [c' 0] [g] = [1]
 * has g = 0 exactly there, and g' = -w' A' v with the solution w of the transposed system (Griewank &
 * Reddien, IMA J. Numer. Anal. 4 (1984) 295-303; Govaerts, Numerical methods for bifurcations of dynamical
 * equilibria, SIAM 2000). A is the Jacobian without parameters for folds and branch points, with an orbit
 * that closes on minus its begin for flips, turned by e^{i theta} for Neimark-Sacker points, where theta is
 * one more unknown. At grazing g is the speed of the impact, which is an entry of the Jacobian: the
 * derivative of the gap by the time. A' v is the difference of Jacobians along v: its error does not touch
 * what is found, only how fast. Where mirror images branch off, the equations are singular along the curve;
 * one more unknown, which is zero there, multiplies b, and the orbit does not move along c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_EXTENDED_H
#define SALTUS_BRANCH_EXTENDED_H

#include "branch/solution.h"
#include "saltus/branch.h"

/* Unknowns are those of the orbit, with both parameters, and `extra` more. */
typedef struct saltus_extended {
    saltus_point_kind kind;
    saltus_orbits orbits; /* of both parameters */
    int mark;             /* grazing: the impact that has no speed */
    bool mirrored; /* the orbits are their own mirror images; for branch points they are cut in halves */
    int extra;     /* theta, or what multiplies b */
    int copies;    /* 2 where v and w are complex: real and imaginary parts one after the other */
    bool sharp;    /* derivatives of fourth order */
    saltus_equations equations;
    /* Of the present sequence. */
    saltus_arena arena;
    saltus_dense_lu lu;    /* of the bordered matrix */
    double *matrix;        /* it */
    double *right, *left;  /* its solutions: v, g; copies of w */
    double *b, *c;         /* borders, copies x count */
    double *aside;         /* an orbit aside */
    double *along, *fresh; /* A' v, copies of count x unknowns, and room for another */
    bool differs;          /* it has been computed */
    double *anchor;        /* where the orbit may not move along c */
} saltus_extended;

/* Room for the sequence that the shooting has. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_extended_shape(saltus_extended *extended, saltus_message *message);
/* Free what belongs to a sequence. */
void saltus_extended_close(saltus_extended *extended);
/* Borders from the null vectors of A at the orbit that the shooting has last evaluated. Errors:
 * SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_extended_choose(saltus_extended *extended, double theta, saltus_message *message);
/* The borders become the null vectors of the point u last evaluated, so that they stay far from orthogonal.
 */
void saltus_extended_renew(saltus_extended *extended, const double *u);
/* Residuals and Jacobian at u; `self` is the extended system. Errors: those of the orbit's equations,
 * SALTUS_SINGULAR. */
saltus_status saltus_extended_evaluate(void *self, const double *u, saltus_message *message);

/* Zero where the critical multiplier is a double one, at the point last evaluated: w' v in the states. */
double saltus_extended_double(const saltus_extended *extended);
/* Zero at a cusp of folds, at the point last evaluated: the second derivative along v. */
double saltus_extended_cusp(const saltus_extended *extended);
/* Zero where a flip changes from sub- to supercritical, at a flip u that has just been evaluated. Orbits of
 * twice the period are s + d and s - d in their halves, d = a v with the null vector v of A. By the mean of
 * their equations F' s = - a^2 F'' v v / 2, and by the difference, projected by w, the parameter answers to
 * a^2 by *value = w' (F'' s v + F''' v v v / 6), s for a = 1: by differences
 * over four times `apart` to both sides. Errors: SALTUS_NO_MEMORY, SALTUS_SINGULAR,
 * those of the orbit's equations. */
saltus_status saltus_extended_criticality(saltus_extended *extended, const double *u, double apart,
                                          double *value, saltus_message *message);

#endif
