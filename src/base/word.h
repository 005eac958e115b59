/* Private: words that were meant.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_WORD_H
#define SALTUS_BASE_WORD_H

#include <stdbool.h>

/* The word nearest to `word` among `count`, or NULL when none is near enough to be meant. */
const char *saltus_nearest_word(const char *word, const char *const *words, int count);

/* Whether `key` is `name`, or `name` with a number from 1 behind it, which goes to *number (0: none). */
bool saltus_key_numbered(const char *key, const char *name, int *number);

#endif
