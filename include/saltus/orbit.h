/* Periodic orbits: Newton shooting on the stroboscopic map, and Floquet multipliers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_H
#define SALTUS_ORBIT_H

#include "saltus/map.h"

SALTUS_API_BEGIN

enum { SALTUS_LABEL_MAX = 32 };

/* A Floquet multiplier. If it is far below rounding, its logarithm still has its size. */
typedef struct saltus_multiplier {
    double re, im;      /* NAN: not known */
    double log_modulus; /* natural logarithm of the modulus; -INFINITY: exactly zero (sticking); NAN: not
                           known, or not resolved, but below 1e-10 (re = im = 0) */
} saltus_multiplier;

/* Whether all multipliers are known and inside the unit circle, by more than the accuracy of their
 * logarithms, 1e-10. Multipliers too small to be resolved count as inside. */
bool saltus_multipliers_stable(const saltus_multiplier *multipliers, int count);
/* The number of multipliers that are not inside; -1 if some, or all (count 0), are not known. */
int saltus_multipliers_unstable(const saltus_multiplier *multipliers, int count);

typedef struct saltus_orbit_options {
    saltus_flow_options flow; /* `columns` and `directions` are ignored */
    double phase;             /* section phase, 0 <= phase < 1; default 0 */
    int iterations;           /* most Newton steps, for each formulation tried; >= 0; default 20 */
    double tolerance; /* residual relative to the state's scale when Newton has converged; default 1e-12 */
    /* For scenes without forcing: the period is unknown, its first guess `periods` times the system's. */
    bool free_period; /* default false */
    int segments;     /* shooting segments; 0: chosen from the growth of the tangent vectors; default 0 */
    /* Called with each Newton step's residual and the formulation in use; may be NULL. */
    void (*history)(void *context, int iteration, double residual, const char *what);
    void *context;
} saltus_orbit_options;

/* The defaults given above. */
saltus_orbit_options saltus_orbit_defaults(void);

typedef struct saltus_orbit {
    int dimension;
    int periods;       /* p */
    double *state;     /* [dimension], at the section */
    double *monodromy; /* dimension x dimension, row-major: derivative over p periods, from a time away from
                          impacts if `state` lies on one */
    saltus_multiplier *multipliers; /* by decreasing modulus */
    int multiplier_count;           /* the dimension; with a free period one less */
    double trivial;  /* free period: the multiplier along the flow, 1 up to errors; otherwise 0 */
    double omega;    /* the orbit lasts `periods` periods 2 pi / omega */
    double residual; /* max |x(pT) - x(0)| / scale after the last iteration */
    int iterations;  /* Newton steps made, over all formulations */
    bool sticks; /* the orbit has lasting contacts: zero multipliers are exact, the sum rule does not apply */
    double log_volume; /* sum of the multipliers' log moduli, from the orthogonalised tangent flow; NAN if it
                          does not resolve some: if it is one, that multiplier is found by the sum rule */
    double sum_rule; /* the same from the trace of the Jacobian and the restitutions (model.md, section 1) */
} saltus_orbit;

/* Find a p-periodic orbit from a guess (length dimension) by damped Newton steps with the exact derivative,
 * and its multipliers. Free the orbit with saltus_orbit_clear. Errors: SALTUS_BAD_INPUT (periods < 1, options
 * out of range), SALTUS_NO_CONVERGENCE, SALTUS_SINGULAR, those of the flow; `orbit` is then empty. */
saltus_status saltus_orbit_find(const saltus_system *system, int periods, const double *guess,
                                const saltus_orbit_options *options, saltus_orbit *orbit,
                                saltus_message *message);
/* "n/p" with impacts and forcing periods of one orbit, or "chatter/p" for impacts = -1 (infinitely many). */
void saltus_orbit_label(long long impacts, int periods, char label[SALTUS_LABEL_MAX]);
/* Free the arrays; a zeroed orbit is accepted. */
void saltus_orbit_clear(saltus_orbit *orbit);

SALTUS_API_END
#endif
