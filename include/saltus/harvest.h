/* Harvest: the unstable periodic orbits along a trajectory, from its close returns.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_HARVEST_H
#define SALTUS_HARVEST_H

#include "saltus/orbit.h"

SALTUS_API_BEGIN

typedef struct saltus_harvest_options {
    saltus_flow_options flow; /* `columns` is ignored; `stop` ends the search with what there is */
    int longest;              /* longest period sought, in forcing periods; default 8 */
    long long transient;      /* periods left out at the beginning; default 100 */
    long long periods;        /* periods searched for close returns; default 5000 */
    double recurrence;   /* returns closer than this, relative to the system's scales, are candidates; default
                            0.1 */
    int tries;           /* candidates kept for each period, the closest ones; default 40 */
    int most;            /* orbits at most; default 1000 */
    double tolerance;    /* residual relative to the state's scale that an orbit may have; default 1e-11 */
    const double *state; /* initial state at phase 0; default NULL: a random admissible one from `seed` */
    unsigned long seed;  /* default 1 */
    saltus_progress progress; /* share of the work, of 1 */
} saltus_harvest_options;

/* As told beside the options. */
saltus_harvest_options saltus_harvest_defaults(void);

typedef struct saltus_harvest_orbit {
    saltus_orbit orbit;                          /* least period; state at section phase 0 */
    double *section_states;                      /* its stroboscopic points: periods x dimension */
    long long impacts;                           /* n per orbit; -1 when complete chatter makes it infinite */
    long long impacts_by_face[SALTUS_FACES_MAX]; /* with chatter those simulated one by one */
    int sticking_intervals;
    int mirror; /* where the scene has mirror symmetry, the place of its mirror image in the list, its own if
                   it is its own image; -1 without symmetry, or when the image was not found */
} saltus_harvest_orbit;

typedef struct saltus_harvest {
    saltus_harvest_orbit *orbits; /* by period, then by the largest multiplier's modulus, smallest first */
    int count;
    int face_count, dimension;
    long long periods;    /* simulated, the transient included */
    long long candidates; /* close returns polished */
    long long converged;  /* of these; many lead to the same orbits */
} saltus_harvest;

/* Run a trajectory, polish its closest returns by saltus_orbit_find, and list the distinct orbits found,
 * those of mirror images included. Orbits that a stable motion settles on are found too. On success the
 * arrays are owned by the harvest: saltus_harvest_clear; that nothing was found is a success. Errors:
 * SALTUS_BAD_INPUT (options; a scene without forcing, whose orbits have no period to count in), those of the
 * flow. */
saltus_status saltus_harvest_run(const saltus_system *system, const saltus_harvest_options *options,
                                 saltus_harvest *harvest, saltus_message *message);
/* Free the arrays; a zeroed harvest is accepted. */
void saltus_harvest_clear(saltus_harvest *harvest);

SALTUS_API_END
#endif
