/* The reference orbits, for tests: what cannot be read fails the test; and places in other JSON texts.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_REFERENCE_H
#define SALTUS_TESTS_REFERENCE_H

#include "check.h"

#include "bench/reference.h"

static inline reference read_reference(const char *name) {
    reference r;
    assert_true(reference_read(SALTUS_DATA "/reference", name, &r));
    return r;
}

/* The place after `"key":`, from `from` on; NULL if there is none. */
static inline const char *find_key(const char *from, const char *key) {
    char quoted[64];
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *at = strstr(from, quoted);
    return at ? at + strlen(quoted) : NULL;
}

/* Read the next number, quoted or not, and advance *at past it. */
static inline double next_number(const char **at) {
    *at += strcspn(*at, "+-0123456789");
    char *end;
    double value = strtod(*at, &end);
    *at = end;
    return value;
}

#endif
