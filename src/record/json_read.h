/* Private: finding values in a JSON text. The text is checked as a whole first; spans then point into it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_JSON_READ_H
#define SALTUS_RECORD_JSON_READ_H

#include <stdbool.h>
#include <stddef.h>

/* One value: the bytes from its first to just behind its last one. */
typedef struct saltus_json {
    const char *at, *end;
} saltus_json;

/* The value that the text begins with, blanks before and behind it passed; false when it is no JSON, with
 * value->end where it stops to be (the text's end when it is cut off). `text` need not end with NUL. */
bool saltus_json_parse(const char *text, size_t length, saltus_json *value, const char **rest);
/* The member of an object; false when there is none, or the value is no object. */
bool saltus_json_member_of(saltus_json object, const char *key, saltus_json *value);
/* The k-th element of an array, from 0; false when there is none. */
bool saltus_json_element(saltus_json array, int k, saltus_json *value);
int saltus_json_count(saltus_json array);
/* A finite number; false for anything else. */
bool saltus_json_number(saltus_json value, double *number);
/* A string without escapes that fits; false for anything else. */
bool saltus_json_word(saltus_json value, char *text, size_t room);

#endif
