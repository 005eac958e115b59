/* Periodic orbits: Newton shooting on the stroboscopic map, Floquet multipliers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_H
#define SALTUS_ORBIT_H

#include "saltus/map.h"

SALTUS_API_BEGIN

enum { SALTUS_LABEL_MAX = 32 };

/* A Floquet multiplier. Multipliers far below rounding keep their size as a logarithm. */
typedef struct saltus_multiplier {
    double re, im;
    double log_modulus; /* natural logarithm of the modulus; -INFINITY for an exact zero (sticking), NAN for
                           one too small to be resolved (re = im = 0) */
} saltus_multiplier;

/* Whether `count` multipliers are all known and inside the unit circle, by more than the accuracy of their
 * logarithms, 1e-10; one too small to be resolved is inside. */
bool saltus_multipliers_stable(const saltus_multiplier *multipliers, int count);
/* How many of them are not inside. */
int saltus_multipliers_unstable(const saltus_multiplier *multipliers, int count);

typedef struct saltus_orbit_options {
    saltus_flow_options flow; /* `columns` and `directions` are ignored */
    double phase;             /* section phase, 0 <= phase < 1; default 0 */
    int iterations;           /* Newton steps at most, of each formulation that is tried; >= 0; default 20 */
    double tolerance; /* residual relative to the state's scale where Newton has converged; default 1e-12 */
    /* The period is an unknown: for scenes without forcing, whose orbits have periods of their own. It is
     * sought from `periods` times the system's. */
    bool free_period; /* default false */
    int segments;     /* shooting segments; 0: chosen from the growth of the tangent vectors; default 0 */
    /* Called with each Newton step's residual and the formulation in use; may be NULL. */
    void (*history)(void *context, int iteration, double residual, const char *what);
    void *context;
} saltus_orbit_options;

/* As told beside the options. */
saltus_orbit_options saltus_orbit_defaults(void);

typedef struct saltus_orbit {
    int dimension;
    int periods;                    /* p */
    double *state;                  /* at the section; dimension */
    double *monodromy;              /* dimension x dimension, row-major: derivative over p periods */
    saltus_multiplier *multipliers; /* by decreasing modulus */
    int multiplier_count;           /* dimension; with a free period one less */
    double trivial;  /* with a free period the multiplier along the flow, 1 but for errors; otherwise 0 */
    double omega;    /* with which the orbit takes `periods` periods 2 pi / omega */
    double residual; /* max |x(pT) - x(0)| / scale after the last iteration */
    int iterations;  /* Newton steps made, over all formulations */
    bool sticks; /* the orbit has lasting contacts: zero multipliers are exact, the sum rule does not apply */
    double log_volume; /* sum of the multipliers' log moduli, from the orthogonalised tangent flow; NAN when
                          some are too small to be resolved */
    double sum_rule;   /* what the trace of the Jacobian and the restitutions make it (model.md, section 1) */
} saltus_orbit;

/* Polish a guess (length dimension) to a p-periodic orbit, damped Newton with the exact derivative, and
 * compute its multipliers. On success the orbit's arrays are owned by it: saltus_orbit_clear. Errors:
 * SALTUS_BAD_INPUT (periods < 1, options out of range), SALTUS_NO_CONVERGENCE, SALTUS_SINGULAR, those of the
 * flow; `orbit` is then empty. */
saltus_status saltus_orbit_find(const saltus_system *system, int periods, const double *guess,
                                const saltus_orbit_options *options, saltus_orbit *orbit,
                                saltus_message *message);
/* "n/p", the impacts and forcing periods of one orbit; "chatter/p" for impacts = -1, infinitely many. */
void saltus_orbit_label(long long impacts, int periods, char label[SALTUS_LABEL_MAX]);
/* Free the arrays; a zeroed orbit is accepted. */
void saltus_orbit_clear(saltus_orbit *orbit);

SALTUS_API_END
#endif
