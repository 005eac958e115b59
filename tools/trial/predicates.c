/* Conditions on trajectories.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "claims.h"

enum { long_period = 4, response_cycle = 2 };
static const double seldom = 0.1; /* impacts per period */

static bool touches(const trial_cell *cell) {
    return cell->rate > 0 || cell->contact > 0;
}

bool trial_irregular(const trial_cell *cell) {
    return cell->kind == TRIAL_IRREGULAR;
}

bool trial_irregular_impacts(const trial_cell *cell) {
    return cell->kind == TRIAL_IRREGULAR && touches(cell);
}

bool trial_regular(const trial_cell *cell) {
    return cell->kind == TRIAL_FREE || cell->kind == TRIAL_IMPACTS;
}

bool trial_no_contact(const trial_cell *cell) {
    return cell->kind != TRIAL_FAILED && !touches(cell);
}

bool trial_weak_contact(const trial_cell *cell) {
    return cell->kind != TRIAL_FAILED && cell->rate < seldom && !(cell->contact > 0);
}

bool trial_several_impacts(const trial_cell *cell) {
    return cell->kind == TRIAL_CHATTER || (cell->kind == TRIAL_IMPACTS && cell->impacts > 1);
}

bool trial_one_cycle(const trial_cell *cell) {
    return cell->kind == TRIAL_IMPACTS && cell->periods <= response_cycle;
}

bool trial_complex(const trial_cell *cell) {
    bool regular = cell->kind == TRIAL_IMPACTS && cell->periods <= long_period;
    return cell->kind != TRIAL_FAILED && cell->kind != TRIAL_HELD && touches(cell) && !regular;
}

bool trial_sticks(const trial_cell *cell) {
    return cell->contact > 0 && cell->kind != TRIAL_HELD && cell->kind != TRIAL_FAILED;
}

bool trial_held(const trial_cell *cell) {
    return cell->kind == TRIAL_HELD;
}
