/* Files that are written completely or not at all.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_RECORD_OUTPUT_H
#define SALTUS_RECORD_OUTPUT_H

#include "saltus/status.h"

#include <stdbool.h>
#include <stdio.h>

/* A file being written beside its target, which it replaces when complete. Until then it has no name, so that
 * nothing stays of it however the program ends; on file systems without such files it has a temporary one. A
 * target that is not a regular file (a device, a pipe) is written directly. */
typedef struct saltus_output {
    FILE *file;
    char *path, *temporary; /* temporary: by which it can be opened; NULL if written directly */
    bool nameless;          /* it has no name yet */
} saltus_output;

/* Errors: SALTUS_IO, SALTUS_NO_MEMORY; nothing is left behind. */
saltus_status saltus_output_open(saltus_output *output, const char *path, saltus_message *message);
/* Complete the file; with a status other than SALTUS_OK remove it and return that status. Errors: SALTUS_IO
 * if something could not be written; nothing is left behind. */
saltus_status saltus_output_close(saltus_output *output, saltus_status status, saltus_message *message);

/* Test whether the file could be written; nothing is left behind. `plain`: devices and pipes are refused,
 * SALTUS_BAD_INPUT. Errors as saltus_output_open. */
saltus_status saltus_output_test(const char *path, bool plain, saltus_message *message);

/* Read `size` bytes at an offset of an open file and return the number read. If fewer, errno has the reason:
 * EIO at the end of the file. */
size_t saltus_read_at(int descriptor, void *data, size_t size, long long place);
/* False, with errno, if not everything could be written. */
bool saltus_write_at(int descriptor, const void *data, size_t size, long long place);

/* Whether a path ends in `ending` (such as ".csv") and has something before it. */
bool saltus_path_ends(const char *path, const char *ending);
/* The part of a path after the last '/'. */
const char *saltus_path_name(const char *path);
/* A nameless temporary file in $TMPDIR or /tmp, gone when closed; NULL with errno on failure. */
FILE *saltus_nameless_file(void);

#endif
