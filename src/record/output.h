/* Files that are written completely or not at all.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_OUTPUT_H
#define SALTUS_RECORD_OUTPUT_H

#include "saltus/status.h"

#include <stdbool.h>
#include <stdio.h>

/* A file being written: beside its target under a temporary name, renamed when complete. A target that is
 * no regular file (a device, a pipe) is written directly. */
typedef struct saltus_output {
    FILE *file;
    char *path, *temporary; /* temporary is NULL when written directly */
} saltus_output;

/* Errors: SALTUS_IO, SALTUS_NO_MEMORY; nothing is left behind. */
saltus_status saltus_output_open(saltus_output *output, const char *path, saltus_message *message);
/* Complete the file, or with status other than SALTUS_OK remove it and return that status. Errors: SALTUS_IO
 * when something could not be written; nothing is left behind. */
saltus_status saltus_output_close(saltus_output *output, saltus_status status, saltus_message *message);

/* Whether the file could be written; nothing is left behind. Errors as saltus_output_open. */
saltus_status saltus_output_test(const char *path, saltus_message *message);

/* Read `size` bytes at a place of an open file; how many there were. When fewer, errno says why: EIO where
 * the file ends. */
size_t saltus_read_at(int descriptor, void *data, size_t size, long long place);
/* False, with errno, when not everything could be written. */
bool saltus_write_at(int descriptor, const void *data, size_t size, long long place);

/* Whether a path ends in `ending` (such as ".csv") and has something before it. */
bool saltus_path_ends(const char *path, const char *ending);
/* The part of a path after the last '/'. */
const char *saltus_path_name(const char *path);
/* A nameless temporary file in $TMPDIR or /tmp, gone when closed; NULL and errno if there can be none. */
FILE *saltus_nameless_file(void);

#endif
