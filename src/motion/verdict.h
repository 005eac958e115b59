/* Private: whether two motions are the same attractor.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_MOTION_VERDICT_H
#define SALTUS_MOTION_VERDICT_H

#include "base/field.h"
#include "saltus/motion.h"

extern const saltus_word saltus_verdict_words[];

/* What a trajectory has ended on. */
typedef struct saltus_ending {
    saltus_verdict verdict;
    int periods;
    const double *state;  /* at section phase 0 */
    const double *points; /* of a periodic motion: its section points, periods x dimension */
} saltus_ending;

saltus_ending saltus_motion_ending(const saltus_motion *motion);

/* Whether two trajectories of a system have ended on the same attractor: on the same orbit, in the same rest,
 * or both on something that is neither and of the same kind. `distance`, relative to the system's scales, is
 * what section points of the same orbit may be apart by the accuracy with which they are known. Of the second
 * one its state is enough. */
bool saltus_same_attractor(const saltus_system *system, const saltus_ending *a, const saltus_ending *b,
                           double distance);

#endif
