/* Shared by the fuzz targets: what must hold of every refusal, and a file for readers of files.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_FUZZ_H
#define SALTUS_TESTS_FUZZ_H

#include "saltus/saltus.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static inline void fuzz_check(bool holds, const char *what) {
    if (holds)
        return;
    fprintf(stderr, "fuzz: %s\n", what);
    abort();
}

/* A refusal is bad input and comes with a sentence. */
static inline void fuzz_check_refusal(saltus_status status, const saltus_message *message) {
    fuzz_check(status == SALTUS_OK || status == SALTUS_BAD_INPUT, saltus_status_name(status));
    fuzz_check(status == SALTUS_OK || message->text[0], "a refusal gives no reason");
    fuzz_check(memchr(message->text, 0, sizeof message->text) != NULL, "a message has no end");
}

/* The bytes as a string, to be freed. */
static inline char *fuzz_text(const uint8_t *data, size_t size) {
    char *text = malloc(size + 1);
    fuzz_check(text != NULL, "no memory");
    memcpy(text, data, size);
    text[size] = '\0';
    return text;
}

/* Where this process keeps its file. */
static inline const char *fuzz_path(char path[128]) {
    const char *folder = getenv("TMPDIR");
    snprintf(path, 128, "%.80s/saltus-fuzz-%ld.h5", folder && *folder ? folder : "/tmp", (long)getpid());
    return path;
}

static inline void fuzz_write(const char *path, const void *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    fuzz_check(file && fwrite(bytes, 1, size, file) == size && fclose(file) == 0,
               "the file cannot be written");
}

#endif
