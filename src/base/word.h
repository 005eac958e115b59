/* Private: guesses at misspelt words, and numbered keys.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_WORD_H
#define SALTUS_BASE_WORD_H

#include <stdbool.h>

/* The one of `count` words closest to `word`, or NULL if none is close enough to be a misspelling of it. */
const char *saltus_nearest_word(const char *word, const char *const *words, int count);

/* Whether `key` is `name`, possibly with a number from 1 to 999 appended, which goes to *number (0: none). */
bool saltus_key_numbered(const char *key, const char *name, int *number);

#endif
