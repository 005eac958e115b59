/* Private: the equations of an orbit with one more that makes it special.
 *
 * The equations of the orbit, with two parameters unknown, are extended by g = 0, the condition for the
 * special point. If a matrix A is singular there, g is defined by borders b and c:
 *     [A  b] [v]   [0]
 *     [c' 0] [g] = [1]
 * g is zero exactly where A is singular, and g' = -w' A' v with the solution w of the transposed system
 * (Griewank & Reddien, IMA J. Numer. Anal. 4 (1984) 295-303; Govaerts, Numerical methods for bifurcations of
 * dynamical equilibria, SIAM 2000). For folds and branch points A is the Jacobian without the parameters'
 * columns; for flips that of an orbit which closes on minus its beginning; for Neimark-Sacker points the
 * closing is turned by e^{i theta}, and theta is one more unknown. A' v is a difference of Jacobians along v:
 * its error affects the speed of convergence, not the result. On curves of branch points the equations are
 * singular; one more unknown, zero on the curve, multiplies b, and the orbit must not move along c. At
 * grazing g is the impact's speed, an entry of the Jacobian: the derivative of the gap by the time.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BRANCH_EXTENDED_H
#define SALTUS_BRANCH_EXTENDED_H

#include "branch/solution.h"
#include "saltus/branch.h"

enum { SALTUS_SAMPLES_MOST = 8 };

/* The unknowns are those of the orbit, including both parameters, and `extra` more. */
typedef struct saltus_extended {
    saltus_point_kind kind;
    saltus_orbits orbits; /* of both parameters */
    int mark;             /* grazing: the impact that has no speed */
    bool mirrored; /* the orbits are their own mirror images, though the scene need not be, where they only
                      touch its stops; for branch points they are cut in halves */
    int extra;     /* theta, or what multiplies b */
    int copies;    /* 2 where v and w are complex: real and imaginary parts one after the other */
    bool sharp;    /* derivatives of fourth order */
    saltus_equations equations;
    /* For the present sequence; down to `along` nothing at grazing. */
    saltus_arena arena;
    saltus_dense_lu lu;   /* of the bordered matrix */
    double *matrix;       /* the bordered matrix */
    double *right, *left; /* its solutions: v, g; w for each copy */
    double *b, *c;        /* the borders, copies x count */
    bool folds; /* at the first point of a curve of branch points orbits that stay mirror images fold, too, */
    double *folding[2];    /* with these right and left null vectors */
    double *aside;         /* unknowns of an orbit displaced along v */
    double *along, *fresh; /* A' v, copies x count x unknowns, and room for a new one */
    bool differs;          /* `along` has been computed */
    double *anchor;        /* point from which the orbit must not move along c */
    /* For searches along the curve: unknowns of so many points and a plane, and of 3 that they keep. */
    double *points, *kept;
} saltus_extended;

/* Allocate for the shooting's sequence. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_extended_shape(saltus_extended *extended, saltus_message *message);
/* Free what belongs to a sequence. */
void saltus_extended_close(saltus_extended *extended);
/* The same equations with the same borders, for a flow of another tolerance: what differs is the flow's
 * error. The caller closes it in any case. Errors: SALTUS_NO_MEMORY, those of the flow. */
saltus_status saltus_extended_open_other(const saltus_extended *extended, saltus_extended *other);
/* Free it; lack of memory is noted in the first one's orbits. */
void saltus_extended_close_other(saltus_extended *extended, saltus_extended *other);
/* Choose the borders as null vectors of A at the orbit last evaluated by the shooting. Errors:
 * SALTUS_NO_MEMORY, SALTUS_NO_CONVERGENCE. */
saltus_status saltus_extended_choose(saltus_extended *extended, double theta, saltus_message *message);
/* Renew the borders with the null vectors at the point u last evaluated, so that they stay far from
 * orthogonal to them. */
void saltus_extended_renew(saltus_extended *extended, const double *u);
/* Residuals and Jacobian at u; `self` is the extended system. Errors: those of the orbit's equations,
 * SALTUS_SINGULAR. */
saltus_status saltus_extended_evaluate(void *self, const double *u, saltus_message *message);

/* w' v over the states, at the point last evaluated: zero where the critical multiplier is double; up to
 * *rounding it is nothing else. */
double saltus_extended_double(const saltus_extended *extended, double *rounding);
/* Whether, at the point last evaluated, the null vector of orbits that are their own mirror images is not of
 * the kind that is followed: that of a fold keeps them so, with times of events that change in both halves
 * alike; that of a branch point, for orbits cut in halves, does not, and half an orbit later is itself. */
bool saltus_extended_strays(const saltus_extended *extended);
/* Zero at a cusp of folds, at the point last evaluated: the second derivative along v. */
double saltus_extended_cusp(const saltus_extended *extended);
/* *value is zero where a flip, or a branch point of orbits that are their own mirror images, changes from
 * sub- to supercritical; u: such a point that was just evaluated. The halves of orbits of twice the period
 * are s + d and s - d, with d = a v and the null vector v of A; so are an orbit that branches off and its
 * mirror image. The mean of their equations gives F' s = - a^2 F'' v v / 2; their difference, projected on w,
 * says that the parameter changes by a^2 times *value = w' (F'' s v + F''' v v v / 6), with s for a = 1, up
 * to a factor. Derivatives are differences over four times `apart` to both sides. Errors: SALTUS_NO_MEMORY,
 * SALTUS_SINGULAR, those of the orbit's equations. */
saltus_status saltus_extended_criticality(saltus_extended *extended, const double *u, double apart,
                                          double *value);

#endif
