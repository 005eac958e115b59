/* Private: words that were meant.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BASE_WORD_H
#define SALTUS_BASE_WORD_H

#include <stddef.h>

/* The word nearest to `word` among `count`, or NULL when none is near enough to be meant. */
const char *saltus_nearest_word(const char *word, const char *const *words, int count);

#endif
