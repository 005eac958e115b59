/* Private: close returns of a trajectory, and the orbits that they lead to.
 *
 * A trajectory comes close to the orbits of its attractor: a point that almost recurs after p periods is a
 * guess for Newton's method (Auerbach et al., Phys. Rev. Lett. 58 (1987) 2387-2389). Every section point is
 * compared with those p before it; for each p the closest returns are kept, at most a fixed number, so time
 * and memory grow with the trajectory's length and with the longest p alone. A return counts where its
 * distance is a minimum along the trajectory, and smaller than after any divisor of p, which would be a
 * shorter orbit's. Without forcing a period is a return to the section.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_RETURNS_H
#define SALTUS_ORBIT_RETURNS_H

#include "orbit/lap.h"

typedef struct saltus_returns saltus_returns;

typedef struct saltus_returns_wanted {
    int shortest, longest; /* after so many periods */
    int most;              /* of each, the closest ones */
    double recurrence;     /* nearer than this, relative to the system's scales */
    double same;           /* of two that are as near to each other, in their distances, one is kept */
    double growth;         /* logarithm of a tangent vector's growth on the way, at most; INFINITY: any */
} saltus_returns_wanted;

typedef struct saltus_return {
    long long place;     /* in its trajectory, from 0 */
    const double *state; /* on the section; until the next point is added */
    double distance;     /* from the point p periods later, relative to the system's scales */
} saltus_return;

/* Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_returns_new(const saltus_system *system, const saltus_returns_wanted *wanted,
                                 saltus_returns **returns, saltus_message *message);
/* NULL is accepted. */
void saltus_returns_free(saltus_returns *returns);
/* The trajectory's next section point; `growth`: the logarithm of a tangent vector's since the point before.
 */
void saltus_returns_add(saltus_returns *returns, const double *point, double growth);
/* What is added next is another trajectory's. */
void saltus_returns_break(saltus_returns *returns);
/* The closest return after `periods` that has not been asked for before; false when none is left. */
bool saltus_returns_next(saltus_returns *returns, int periods, saltus_return *closest);

/* The orbit that Newton's method finds from a guess which closes after about `periods` periods, reduced to
 * its least period, and the lap around it. `flow` has no columns. On success the orbit owns its arrays:
 * saltus_orbit_clear; otherwise it is empty. Errors: those of saltus_orbit_find, of the flow,
 * SALTUS_NO_MEMORY. */
saltus_status saltus_return_polish(saltus_flow *flow, int periods, const double *guess,
                                   const saltus_orbit_options *options, saltus_orbit *orbit, saltus_lap *lap,
                                   saltus_message *message);

#endif
