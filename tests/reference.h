/* The reference orbits, for tests: what cannot be read fails the test.
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

#endif
