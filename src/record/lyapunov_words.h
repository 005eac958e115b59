/* Private: exponents as numbers and words.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_LYAPUNOV_WORDS_H
#define SALTUS_RECORD_LYAPUNOV_WORDS_H

#include "saltus/lyapunov.h"

/* A number and its standard error as text, with as many digits as the error justifies. */
typedef struct saltus_uncertain {
    char value[40], error[40];
} saltus_uncertain;

saltus_uncertain saltus_uncertain_text(double value, double error);

/* Fate of nearby trajectories according to the largest exponent. */
typedef enum saltus_sense {
    SALTUS_SENSE_SEPARATE,   /* positive by more than three standard errors */
    SALTUS_SENSE_APPROACH,   /* negative by more than three */
    SALTUS_SENSE_KEEP,       /* zero, and known to be */
    SALTUS_SENSE_UNRESOLVED, /* not distinguishable from zero */
    SALTUS_SENSE_MEET        /* -infinity */
} saltus_sense;

saltus_sense saltus_lyapunov_sense(const saltus_lyapunov *lyapunov);
const char *saltus_sense_word(saltus_sense sense); /* "positive", "negative", "zero", "unresolved", "lost" */
/* How a system can lose directions of the state space: in lasting contact, or also in impacts with r = 0. */
const char *saltus_lost_words(const saltus_system *system);

#endif
