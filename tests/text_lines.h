/* Reading a text for people line by line: how a line begins, words in it, and all of its numbers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_TEXT_LINES_H
#define SALTUS_TESTS_TEXT_LINES_H

#include "check.h"

#include <ctype.h>

/* The text and the line that comes next. */
typedef struct text_lines {
    char *text;
    size_t length;
    const char *at;
    FILE *stream;
} text_lines;

/* Write into `stream`, then read. */
static inline void lines_open(text_lines *lines) {
    *lines = (text_lines){.text = NULL};
    lines->stream = open_memstream(&lines->text, &lines->length);
    assert_non_null(lines->stream);
}

static inline void lines_read(text_lines *lines) {
    fclose(lines->stream);
    lines->at = lines->text;
}

/* The next number of a line, as printed: a half unit of its last place is its tolerance. Digits of names such
 * as F02 are none. */
static inline bool next_number(const char **at, const char *end, double *value, double *half) {
    for (const char *c = *at; c < end; c++) {
        bool begins =
            isdigit((unsigned char)*c) && (c == *at || !(isalnum((unsigned char)c[-1]) || c[-1] == '_'));
        if (!begins)
            continue;
        const char *first = c - 1 > *at && c[-1] == '-' && strchr(" [(", c[-2]) ? c - 1 : c;
        char *stop = NULL;
        *value = strtod(first, &stop);
        const char *point = memchr(first, '.', (size_t)(stop - first));
        const char *power = memchr(first, 'e', (size_t)(stop - first));
        const char *last = power ? power : stop;
        *half = 0.5 * pow(10, (power ? atoi(power + 1) : 0) - (point ? (double)(last - point - 1) : 0));
        *at = stop;
        return true;
    }
    return false;
}

static inline void lines_next(text_lines *lines, const char *head, const char *words, int count, ...) {
    const char *end = lines->at + strcspn(lines->at, "\n"), *at = lines->at;
    char line[700];
    snprintf(line, sizeof line, "%.*s", (int)(end - lines->at), lines->at);
    if (*end != '\n')
        fail_msg("the text ends before '%s':\n%s", head, lines->text);
    if (strncmp(line + strspn(line, " "), head, strlen(head)) != 0)
        fail_msg("'%s' instead of '%s'", line, head);
    if (words && !strstr(line, words))
        fail_msg("'%s' without '%s'", line, words);
    at += strspn(at, " ") + strlen(head);
    va_list arguments;
    va_start(arguments, count);
    for (int k = 0; k < count; k++) {
        double value = 0, half = 0, wanted = va_arg(arguments, double);
        if (!next_number(&at, end, &value, &half))
            fail_msg("'%s' has %d numbers instead of %d", line, k, count);
        if (!(fabs(value - wanted) <= half * (1 + 1e-9) + 1e-15 * fabs(wanted)))
            fail_msg("'%s' has %.10g as number %d instead of %.10g", line, value, k + 1, wanted);
    }
    va_end(arguments);
    double value = 0, half = 0;
    if (count >= 0 && next_number(&at, end, &value, &half))
        fail_msg("'%s' has more than %d numbers", line, count);
    lines->at = end + 1;
}

static inline void lines_end(text_lines *lines) {
    if (*lines->at)
        fail_msg("more than expected: %s", lines->at);
    free(lines->text);
}

#endif
