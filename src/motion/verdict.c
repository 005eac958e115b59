/* Verdicts on motions: their words and labels, and whether two motions are the same attractor.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/motion.h"

#include "orbit/lap.h"

#include <stdio.h>

const saltus_word saltus_verdict_words[] = {{"pending", SALTUS_PENDING},
                                            {"periodic", SALTUS_PERIODIC},
                                            {"equilibrium", SALTUS_EQUILIBRIUM},
                                            {"held", SALTUS_HELD},
                                            {"quasi-periodic", SALTUS_QUASIPERIODIC},
                                            {"chaotic", SALTUS_CHAOTIC},
                                            {"long-period", SALTUS_LONG_PERIOD},
                                            {"undecided", SALTUS_UNDECIDED},
                                            {"failed", SALTUS_FAILED},
                                            {"transient", SALTUS_TRANSIENT},
                                            {"irregular", SALTUS_IRREGULAR},
                                            {"beyond a stop", SALTUS_BEYOND},
                                            {NULL, 0}};

const char *saltus_verdict_word(saltus_verdict verdict) {
    return saltus_word_of(saltus_verdict_words, (int)verdict);
}

bool saltus_verdict_settled(saltus_verdict verdict) {
    return verdict == SALTUS_PERIODIC || verdict == SALTUS_EQUILIBRIUM || verdict == SALTUS_HELD;
}

bool saltus_verdict_nothing(saltus_verdict verdict) {
    return verdict == SALTUS_PENDING || verdict == SALTUS_FAILED || verdict == SALTUS_BEYOND;
}

void saltus_verdict_label(saltus_verdict verdict, long long impacts, int periods,
                          char label[SALTUS_LABEL_MAX]) {
    if (verdict == SALTUS_PERIODIC)
        saltus_orbit_label(impacts, periods, label);
    else
        snprintf(label, SALTUS_LABEL_MAX, "%s", saltus_verdict_word(verdict));
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
