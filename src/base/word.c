/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/word.h"

#include <stdlib.h>
#include <string.h>

/* Levenshtein distance of two words; a large number if one of them is long. */
static int distance_between(const char *a, const char *b) {
    enum { longest = 32, far = 1000 };
    int row[longest + 1] = {0};
    int m = (int)strlen(a), n = (int)strlen(b);
    if (m > longest || n > longest)
        return far;
    for (int j = 0; j <= n; j++)
        row[j] = j;
    for (int i = 1; i <= m; i++) {
        int diagonal = row[0];
        row[0] = i;
        for (int j = 1; j <= n; j++) {
            int best = diagonal + (a[i - 1] != b[j - 1]);
            best = best < row[j] + 1 ? best : row[j] + 1;
            best = best < row[j - 1] + 1 ? best : row[j - 1] + 1;
            diagonal = row[j];
            row[j] = best;
        }
    }
    return row[n];
}

const char *saltus_nearest_word(const char *word, const char *const *words, int count) {
    const char *nearest = NULL;
    size_t length = strlen(word);
    int least = length > 8 ? 3 : 1 + (int)length / 4;
    if (length < 3)
        return NULL;
    for (int k = 0; k < count; k++) {
        int distance = distance_between(word, words[k]);
        if (strlen(words[k]) > 2 && distance < least + (nearest == NULL)) {
            nearest = words[k];
            least = distance;
        }
    }
    return nearest;
}

bool saltus_key_numbered(const char *key, const char *name, int *number) {
    size_t length = strlen(name);
    const char *digits = key + length;
    if (strncmp(key, name, length) != 0 || *digits == '0' || strlen(digits) > 3 ||
        strspn(digits, "0123456789") != strlen(digits))
        return false;
    *number = atoi(digits);
    return true;
}
