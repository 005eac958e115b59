/* Rests that are approached too slowly to wait for: Newton's method finds them, the eigenvalues say how fast
 * the trajectory must come nearer, and two looks show that it does.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/motion.h"

#include <math.h>
#include <string.h>

static const double beside = 3e-3; /* relative to the system's scales */

saltus_status saltus_rest_is_approached(const saltus_system *system, const double *state, double time,
                                        saltus_rest_look *last, double *place, bool *approached,
                                        saltus_message *message) {
    const saltus_equilibrium_options options = saltus_equilibrium_defaults();
    const saltus_rest_look before = *last;
    saltus_equilibrium rest = {0};
    *last = (saltus_rest_look){0, time};
    *approached = false;
    saltus_status status = saltus_equilibrium_find(system, state, &options, &rest, message);
    if (status == SALTUS_OK && rest.stable && !rest.contacts) {
        double distance = saltus_system_distance(system, state, rest.state),
               predicted = exp(rest.eigenvalues[0].re * (time - before.time));
        if (distance < beside)
            last->distance = distance;
        *approached = distance < beside && distance <= before.distance * (1 - 0.5 * (1 - predicted));
        memcpy(place, rest.state, (size_t)rest.dimension * sizeof *place);
    }
    saltus_equilibrium_clear(&rest);
    return status == SALTUS_NO_MEMORY ? status : SALTUS_OK;
}
