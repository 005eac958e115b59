/* Private: random numbers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SIGNAL_RANDOM_H
#define SALTUS_SIGNAL_RANDOM_H

#include "base/memory.h"

#include <gsl/gsl_rng.h>

/* A generator (GSL's mt19937) in an arena, to be seeded once the arena is open. GSL's own allocation aborts
 * the program if there is no memory. */
static inline gsl_rng saltus_random_reserve(saltus_arena *arena) {
    size_t doubles = (gsl_rng_mt19937->size + sizeof(double) - 1) / sizeof(double);
    return (gsl_rng){.type = gsl_rng_mt19937, .state = saltus_arena_doubles(arena, doubles)};
}

#endif
