/* Lyapunov exponents of periodic orbits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "saltus/motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

saltus_status saltus_motion_exponents(const saltus_system *system, const saltus_motion *motion, int count,
                                      saltus_lyapunov *l, saltus_message *message) {
    const double period = saltus_system_period(system), time = motion->periods * period;
    const size_t n = (size_t)motion->dimension;
    *l = (saltus_lyapunov){0};
    if (motion->periods < 1 || count < 1 || count > motion->multiplier_count)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%d exponents of a motion of period %d: there are %d",
                           count, motion->periods, motion->periods ? motion->multiplier_count : 0);
    *l = (saltus_lyapunov){.dimension = motion->dimension,
                           .count = count,
                           .exponents = calloc((size_t)count, sizeof *l->exponents),
                           .standard_errors = calloc((size_t)count, sizeof *l->standard_errors),
                           .state = calloc(n, sizeof *l->state),
                           .member_exponents = calloc(1, sizeof *l->member_exponents),
                           .sum = count == motion->multiplier_count ? motion->log_volume / time : NAN,
                           .sum_rule = motion->sticks ? NAN : motion->sum_rule / time,
                           .kaplan_yorke = NAN,
                           .impacts_per_period =
                               motion->impacts < 0 ? INFINITY : (double)motion->impacts / motion->periods,
                           .sticks_per_period = (double)motion->sticking_intervals / motion->periods,
                           .period = period,
                           .time = time,
                           .periods = motion->periods,
                           .independent = NAN,
                           .agree = true,
                           .precise = true};
    if (!l->exponents || !l->standard_errors || !l->state || !l->member_exponents) {
        saltus_lyapunov_clear(l);
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for %d exponents", count);
    }
    memcpy(l->state, motion->state, n * sizeof *l->state);
    for (int k = 0; k < count; k++)
        l->exponents[k] = motion->multipliers[k].log_modulus / time;
    for (int k = 0; k < motion->multiplier_count; k++)
        l->lost += motion->multipliers[k].log_modulus == -INFINITY;
    l->half[0] = l->half[1] = l->exponents[0];
    return SALTUS_OK;
}
