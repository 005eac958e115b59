/* Verdicts on motions: their words and labels, and whether two motions are the same attractor.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/verdict.h"

#include "orbit/lap.h"

#include <stdio.h>

static const char *const words[SALTUS_VERDICTS] = {
    [SALTUS_PENDING] = "pending",
    [SALTUS_PERIODIC] = "periodic",
    [SALTUS_EQUILIBRIUM] = "equilibrium",
    [SALTUS_HELD] = "held",
    [SALTUS_QUASIPERIODIC] = "quasi-periodic",
    [SALTUS_CHAOTIC] = "chaotic",
    [SALTUS_LONG_PERIOD] = "long-period",
    [SALTUS_UNDECIDED] = "undecided",
    [SALTUS_FAILED] = "failed",
    [SALTUS_TRANSIENT] = "transient",
};

const char *saltus_verdict_word(saltus_verdict verdict) {
    return words[verdict];
}

bool saltus_verdict_settled(saltus_verdict verdict) {
    return verdict == SALTUS_PERIODIC || verdict == SALTUS_EQUILIBRIUM || verdict == SALTUS_HELD;
}

void saltus_verdict_label(saltus_verdict verdict, long long impacts, int periods,
                          char label[SALTUS_LABEL_MAX]) {
    if (verdict == SALTUS_PERIODIC)
        saltus_orbit_label(impacts, periods, label);
    else
        snprintf(label, SALTUS_LABEL_MAX, "%s", words[verdict]);
}

saltus_ending saltus_motion_ending(const saltus_motion *motion) {
    return (saltus_ending){motion->verdict, motion->periods, motion->state, motion->section_states};
}

bool saltus_same_attractor(const saltus_system *system, const saltus_ending *a, const saltus_ending *b,
                           double distance) {
    if (a->verdict != b->verdict || (a->verdict == SALTUS_PERIODIC && a->periods != b->periods))
        return false;
    if (!saltus_verdict_settled(a->verdict))
        return true;
    if (a->verdict == SALTUS_PERIODIC)
        return saltus_orbit_passes(system, a->points, a->periods, b->state, distance);
    return saltus_system_distance(system, a->state, b->state) < distance;
}
