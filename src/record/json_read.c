/* A JSON reader (RFC 8259) that allocates nothing: values are found again by walking over their text.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "record/json_read.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { deepest = 64 };

typedef struct cursor {
    const char *at, *end;
} cursor;

static void skip_blanks(cursor *c) {
    while (c->at < c->end && strchr(" \t\r\n", *c->at) && *c->at)
        c->at++;
}

static bool take(cursor *c, char expected) {
    skip_blanks(c);
    if (c->at >= c->end || *c->at != expected)
        return false;
    c->at++;
    return true;
}

static bool skip_digits(cursor *c) {
    const char *begin = c->at;
    while (c->at < c->end && *c->at >= '0' && *c->at <= '9')
        c->at++;
    return c->at > begin;
}

static bool skip_number(cursor *c) {
    if (c->at < c->end && *c->at == '-')
        c->at++;
    bool zero = c->at < c->end && *c->at == '0';
    if (zero)
        c->at++;
    else if (!skip_digits(c))
        return false;
    if (c->at < c->end && *c->at == '.') {
        c->at++;
        if (!skip_digits(c))
            return false;
    }
    if (c->at < c->end && (*c->at == 'e' || *c->at == 'E')) {
        c->at++;
        if (c->at < c->end && (*c->at == '+' || *c->at == '-'))
            c->at++;
        return skip_digits(c);
    }
    return true;
}

static bool skip_string(cursor *c) {
    if (!take(c, '"'))
        return false;
    while (c->at < c->end && *c->at != '"') {
        if ((unsigned char)*c->at < 0x20)
            return false;
        c->at += *c->at == '\\' && c->at + 1 < c->end ? 2 : 1;
    }
    return take(c, '"');
}

/* Where the text ends within the word, the cursor is left at its end, so that the text is known to be cut
 * off. */
static bool skip_word(cursor *c, const char *word) {
    size_t length = strlen(word), left = (size_t)(c->end - c->at), there = left < length ? left : length;
    if (memcmp(c->at, word, there) != 0)
        return false;
    c->at += there;
    return there == length;
}

static bool skip_value(cursor *c, int depth);

/* Members or elements up to the closing bracket, the opening one passed. */
static bool skip_list(cursor *c, bool object, int depth) {
    char close = object ? '}' : ']';
    if (take(c, close))
        return true;
    do {
        skip_blanks(c);
        if (object && !(skip_string(c) && take(c, ':')))
            return false;
        if (!skip_value(c, depth + 1))
            return false;
    } while (take(c, ','));
    return take(c, close);
}

static bool skip_value(cursor *c, int depth) {
    skip_blanks(c);
    if (c->at >= c->end || depth > deepest)
        return false;
    switch (*c->at) {
    case '{':
    case '[':
        return skip_list(c, *c->at++ == '{', depth);
    case '"':
        return skip_string(c);
    case 't':
        return skip_word(c, "true");
    case 'f':
        return skip_word(c, "false");
    case 'n':
        return skip_word(c, "null");
    default:
        return skip_number(c);
    }
}

bool saltus_json_parse(const char *text, size_t length, saltus_json *value, const char **rest) {
    cursor c = {text, text + length};
    skip_blanks(&c);
    value->at = c.at;
    bool good = skip_value(&c, 0);
    value->end = c.at;
    skip_blanks(&c);
    *rest = c.at;
    return good;
}

bool saltus_json_member_of(saltus_json object, const char *key, saltus_json *value) {
    cursor c = {object.at, object.end};
    size_t length = strlen(key);
    if (!take(&c, '{') || take(&c, '}'))
        return false;
    do {
        skip_blanks(&c);
        const char *name = c.at + 1;
        if (!skip_string(&c))
            return false;
        bool found = (size_t)(c.at - 1 - name) == length && memcmp(name, key, length) == 0;
        take(&c, ':');
        skip_blanks(&c);
        value->at = c.at;
        if (!skip_value(&c, 0))
            return false;
        value->end = c.at;
        if (found)
            return true;
    } while (take(&c, ','));
    return false;
}

/* Walk over an array; the number of elements passed before the k-th one, or all of them. */
static int walk(saltus_json array, int k, saltus_json *value) {
    cursor c = {array.at, array.end};
    int count = 0;
    if (!take(&c, '[') || take(&c, ']'))
        return 0;
    do {
        skip_blanks(&c);
        value->at = c.at;
        if (!skip_value(&c, 0))
            return count;
        value->end = c.at;
        if (count == k)
            return count;
        count++;
    } while (take(&c, ','));
    return count;
}

bool saltus_json_element(saltus_json array, int k, saltus_json *value) {
    saltus_json found = {NULL, NULL};
    if (k < 0 || k >= saltus_json_count(array))
        return false;
    walk(array, k, &found);
    *value = found;
    return true;
}

int saltus_json_count(saltus_json array) {
    saltus_json last = {NULL, NULL};
    return walk(array, -1, &last);
}

bool saltus_json_number(saltus_json value, double *number) {
    char text[64], *end = NULL;
    size_t length = (size_t)(value.end - value.at);
    cursor c = {value.at, value.end};
    if (length == 0 || length >= sizeof text || !skip_number(&c) || c.at != value.end)
        return false;
    memcpy(text, value.at, length);
    text[length] = '\0';
    *number = strtod(text, &end);
    return *end == '\0' && isfinite(*number);
}

bool saltus_json_word(saltus_json value, char *text, size_t room) {
    size_t length = (size_t)(value.end - value.at);
    if (length < 2 || *value.at != '"' || length - 2 >= room || memchr(value.at, '\\', length))
        return false;
    memcpy(text, value.at + 1, length - 2);
    text[length - 2] = '\0';
    return true;
}
