/* Harvest: unstable periodic orbits along a trajectory, found from its close returns.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_HARVEST_H
#define SALTUS_HARVEST_H

#include "saltus/orbit.h"

SALTUS_API_BEGIN

typedef struct saltus_harvest_options {
    saltus_flow_options flow; /* `columns` is ignored; `stop` ends the search with the orbits found so far */
    int longest;              /* longest period sought, in forcing periods; default 8 */
    long long transient;      /* periods skipped at the beginning; default 100 */
    long long periods;        /* periods searched for close returns; default 5000 */
    double recurrence;   /* returns closer than this, relative to the system's scales, are candidates; default
                            0.1 */
    int tries;           /* candidates kept for each period, the closest ones; default 40 */
    int most;            /* most orbits to find; default 1000 */
    double tolerance;    /* largest residual of an orbit, relative to the state's scale; default 1e-11 */
    const double *state; /* initial state at phase 0; default NULL: a random admissible one from `seed` */
    unsigned long seed;  /* default 1 */
    saltus_progress progress; /* fraction of the work, out of 1 */
} saltus_harvest_options;

/* The defaults stated beside the options. */
saltus_harvest_options saltus_harvest_defaults(void);

typedef struct saltus_harvest_orbit {
    saltus_orbit orbit;                          /* least period; state at section phase 0 */
    double *section_states;                      /* its stroboscopic points: periods x dimension */
    long long impacts;                           /* n per orbit; -1 with complete chatter */
    long long impacts_by_face[SALTUS_FACES_MAX]; /* with chatter only those simulated one by one */
    int sticking_intervals;
    int mirror; /* with mirror symmetry: index of its mirror image in the list, its own index if it is
                   symmetric; -1 without symmetry, or if the image was not found */
} saltus_harvest_orbit;

typedef struct saltus_harvest {
    saltus_harvest_orbit *orbits; /* by period, then by increasing modulus of the largest multiplier */
    int count;
    int face_count, dimension;
    long long periods;    /* simulated, the transient included */
    long long candidates; /* close returns that Newton's method started from */
    long long converged;  /* candidates that converged, often to the same orbit */
} saltus_harvest;

/* Run a trajectory, refine its closest returns with saltus_orbit_find, and list the distinct orbits found,
 * with their mirror images. Stable orbits are found too. Finding none is a success. On success free the
 * arrays with saltus_harvest_clear. Errors: SALTUS_BAD_INPUT (bad options, or a scene without forcing, which
 * has no period to count in), those of the flow. */
saltus_status saltus_harvest_run(const saltus_system *system, const saltus_harvest_options *options,
                                 saltus_harvest *harvest, saltus_message *message);
/* Free the arrays; a zeroed harvest is accepted. */
void saltus_harvest_clear(saltus_harvest *harvest);

SALTUS_API_END
#endif
