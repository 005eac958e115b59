/* Benchmarks and trials end where something fails that everything after it needs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_BENCH_MUST_H
#define SALTUS_BENCH_MUST_H

#include "saltus/status.h"

#include <stdio.h>
#include <stdlib.h>

/* The program's name in its messages; each program defines it. */
extern const char program_name[];

/* End the program with the message of a call that did not succeed. */
static inline void must(saltus_status status, const saltus_message *message) {
    if (status == SALTUS_OK)
        return;
    fprintf(stderr, "%s: %s\n", program_name, message->text);
    exit(EXIT_FAILURE);
}

/* Zeroed memory; the program ends if there is none. */
static inline void *must_allocate(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (!memory) {
        fprintf(stderr, "%s: no memory\n", program_name);
        exit(EXIT_FAILURE);
    }
    return memory;
}

#endif
