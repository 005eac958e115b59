/* Private: close returns of a trajectory, and the orbits found from them.
 *
 * A trajectory comes close to the orbits of its attractor: a point that nearly recurs after p periods is a
 * guess for Newton's method (Auerbach et al., Phys. Rev. Lett. 58 (1987) 2387-2389). Every section point is
 * compared with those p before it. For each p a fixed number of closest returns is kept, so time and memory
 * grow only with the trajectory's length and the longest p. A return counts if its distance is a minimum
 * along the trajectory and smaller than after any divisor of p, which would be a shorter orbit. Without
 * forcing a period is a return to the section.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_RETURNS_H
#define SALTUS_ORBIT_RETURNS_H

#include "orbit/lap.h"

typedef struct saltus_returns saltus_returns;

typedef struct saltus_returns_wanted {
    int shortest, longest; /* range of periods */
    int most;              /* closest returns kept for each number of periods */
    double recurrence;     /* largest distance, relative to the system's scales */
    double same;   /* of two returns closer to each other than this times their distance one is kept */
    double growth; /* largest logarithm of a tangent vector's growth on the way; INFINITY: any */
} saltus_returns_wanted;

typedef struct saltus_return {
    long long place;     /* index in its trajectory, from 0 */
    const double *state; /* on the section; valid until the next point is added */
    double distance;     /* from the point p periods later, relative to the system's scales */
} saltus_return;

/* Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_returns_new(const saltus_system *system, const saltus_returns_wanted *wanted,
                                 saltus_returns **returns, saltus_message *message);
/* NULL is accepted. */
void saltus_returns_free(saltus_returns *returns);
/* Add the trajectory's next section point; `growth`: log growth of a tangent vector since the last one. */
void saltus_returns_add(saltus_returns *returns, const double *point, double growth);
/* The next point begins a new trajectory. */
void saltus_returns_break(saltus_returns *returns);
/* The closest return after `periods` not handed out yet; false if there is none. */
bool saltus_returns_next(saltus_returns *returns, int periods, saltus_return *closest);

/* Find an orbit from a guess that closes after about `periods` periods, reduce it to its least period and
 * walk around it. `flow` has no columns. The orbit is to be freed with saltus_orbit_clear; on failure it is
 * empty. Errors: those of saltus_orbit_find, of the flow, SALTUS_NO_MEMORY. */
saltus_status saltus_return_polish(saltus_flow *flow, int periods, const double *guess,
                                   const saltus_orbit_options *options, saltus_orbit *orbit, saltus_lap *lap,
                                   saltus_message *message);

#endif
