/* Private: random numbers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SIGNAL_RANDOM_H
#define SALTUS_SIGNAL_RANDOM_H

#include <gsl/gsl_rng.h>

/* GSL's mt19937 with its state beside it, because GSL's own allocation aborts the program if there is no
 * memory. */
typedef struct saltus_random {
    gsl_rng rng;
    unsigned long state[640]; /* mt19937 needs 625 */
} saltus_random;

static inline gsl_rng *saltus_random_rng(saltus_random *random) {
    random->rng = (gsl_rng){.type = gsl_rng_mt19937, .state = random->state};
    return &random->rng;
}

/* Seed the generator, which must be done first. */
static inline gsl_rng *saltus_random_seed(saltus_random *random, unsigned long seed) {
    gsl_rng_set(saltus_random_rng(random), seed);
    return &random->rng;
}

#endif
