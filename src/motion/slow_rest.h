/* Private: rests that are approached too slowly to wait for.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_SLOW_REST_H
#define SALTUS_MOTION_SLOW_REST_H

#include "saltus/equilibrium.h"

/* Where a trajectory was when last looked at; zeroed at its begin. */
typedef struct saltus_rest_look {
    double distance; /* from the stable rest beside it, relative to the system's scales; 0: there was none */
    double time;
} saltus_rest_look;

/* Whether a trajectory without forcing, at a state and a time in units of time, is beside a stable rest free
 * of contacts, `place` (dimension numbers), and has come nearer since the last look, at least half as far as
 * the slowest eigenvalue predicts. Errors: SALTUS_NO_MEMORY. */
saltus_status saltus_rest_is_approached(const saltus_system *system, const double *state, double time,
                                        saltus_rest_look *last, double *place, bool *approached,
                                        saltus_message *message);

#endif
