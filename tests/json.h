/* A small JSON reader of the tests' own, so that what the library writes is not read by its own reader.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_JSON_H
#define SALTUS_TESTS_JSON_H

#include "check.h"

#include <ctype.h>

typedef enum json_kind {
    JSON_NULL,
    JSON_FALSE,
    JSON_TRUE,
    JSON_NUMBER,
    JSON_TEXT,
    JSON_LIST,
    JSON_OBJECT
} json_kind;

/* A value; members of an object have keys. */
typedef struct json {
    json_kind kind;
    char *key, *text;
    double number;
    struct json *first, *next;
} json;

static inline void json_free(json *value) {
    while (value) {
        json *next = value->next;
        json_free(value->first);
        free(value->key);
        free(value->text);
        free(value);
        value = next;
    }
}

static inline void json_space(const char **at) {
    while (isspace((unsigned char)**at))
        (*at)++;
}

static inline void json_expect(const char **at, char c) {
    json_space(at);
    if (**at != c)
        fail_msg("JSON: '%c' expected at %.40s", c, *at);
    (*at)++;
}

/* Escapes for characters beyond ASCII are not needed here. */
static inline char *json_string(const char **at) {
    json_expect(at, '"');
    char *text = calloc(strlen(*at) + 1, 1), *to = text;
    for (; **at && **at != '"'; (*at)++) {
        unsigned code = 0;
        if ((unsigned char)**at < 32)
            fail_msg("JSON: a bare control character in a text");
        if (**at != '\\') {
            *to++ = **at;
            continue;
        }
        (*at)++;
        const char *plain = strchr("\"\"\\\\//n\nt\tr\rb\bf\f", **at);
        if (**at == 'u' && sscanf(*at + 1, "%4x", &code) == 1 && code < 128) {
            *to++ = (char)code;
            *at += 4;
        } else if (plain)
            *to++ = plain[1];
        else
            fail_msg("JSON: unknown escape at %.40s", *at);
    }
    json_expect(at, '"');
    return text;
}

static inline json *json_value(const char **at);

/* The members of an object or a list. */
static inline void json_members(const char **at, json *value, char end) {
    json **place = &value->first;
    (*at)++;
    json_space(at);
    if (**at == end) {
        (*at)++;
        return;
    }
    for (bool more = true; more;) {
        json_space(at);
        char *key = end == '}' ? json_string(at) : NULL;
        if (key)
            json_expect(at, ':');
        *place = json_value(at);
        (*place)->key = key;
        place = &(*place)->next;
        json_space(at);
        more = **at == ',';
        if (more)
            (*at)++;
    }
    json_expect(at, end);
}

static inline json *json_value(const char **at) {
    static const char *const words[] = {[JSON_NULL] = "null", [JSON_FALSE] = "false", [JSON_TRUE] = "true"};
    json *value = calloc(1, sizeof *value);
    json_space(at);
    for (int k = JSON_NULL; k <= JSON_TRUE; k++)
        if (strncmp(*at, words[k], strlen(words[k])) == 0) {
            value->kind = (json_kind)k;
            *at += strlen(words[k]);
            return value;
        }
    if (**at == '{' || **at == '[') {
        value->kind = **at == '{' ? JSON_OBJECT : JSON_LIST;
        json_members(at, value, **at == '{' ? '}' : ']');
    } else if (**at == '"') {
        value->kind = JSON_TEXT;
        value->text = json_string(at);
    } else {
        char *end = NULL;
        value->kind = JSON_NUMBER;
        value->number = strtod(*at, &end);
        /* Neither nan nor inf, nor hexadecimal numbers, nor 007, -.5, 1. or 1.e-6. */
        const char *first = *at + (**at == '-'), *point = memchr(*at, '.', (size_t)(end - *at));
        if (end == *at || !isdigit((unsigned char)*first) || !isfinite(value->number) ||
            memchr(*at, 'x', (size_t)(end - *at)) || (*first == '0' && isdigit((unsigned char)first[1])) ||
            (point && !isdigit((unsigned char)point[1])))
            fail_msg("JSON: no value at %.40s", *at);
        *at = end;
    }
    return value;
}

/* One value with nothing but space behind it, to be freed. */
static inline json *json_read(const char *text) {
    json *value = json_value(&text);
    json_space(&text);
    if (*text)
        fail_msg("JSON: more than one value: %.40s", text);
    return value;
}

static inline int json_count(const json *value) {
    int count = 0;
    for (const json *k = value->first; k; k = k->next)
        count++;
    return count;
}

/* The value at a path such as "parameters.stops.0.d"; NULL where there is none. A key that comes twice fails.
 */
static inline const json *json_find(const json *value, const char *path) {
    while (value && *path) {
        size_t length = strcspn(path, ".");
        const json *found = NULL;
        int place = 0;
        for (const json *k = value->first; k; k = k->next, place++) {
            bool same = k->key ? strlen(k->key) == length && strncmp(k->key, path, length) == 0
                               : isdigit((unsigned char)*path) && atoi(path) == place;
            if (same && found)
                fail_msg("JSON: %s comes twice", k->key);
            found = same ? k : found;
        }
        value = found;
        path += length + (path[length] == '.');
    }
    return value;
}

static inline const json *json_at(const json *value, const char *path) {
    const json *found = json_find(value, path);
    if (!found)
        fail_msg("JSON: there is no %s", path);
    return found;
}

static inline double json_number_at(const json *value, const char *path) {
    const json *found = json_at(value, path);
    if (found->kind != JSON_NUMBER)
        fail_msg("JSON: %s is no number", path);
    return found->number;
}

static inline const char *json_text_at(const json *value, const char *path) {
    const json *found = json_at(value, path);
    if (found->kind != JSON_TEXT)
        fail_msg("JSON: %s is no text", path);
    return found->text;
}

#endif
