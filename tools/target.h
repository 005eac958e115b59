/* What a command may write to. All commands ask here, before anything is computed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_TARGET_H
#define SALTUS_TOOLS_TARGET_H

#include "cli.h"

/* Standard output as the place of a result (`-o -`). Zeroed, it is none. */
typedef struct target {
    char folder[64], path[96]; /* where the result is made before it is copied to standard output */
    int descriptor;            /* standard output itself, kept while the program's words go to stderr */
} target;

/* Check the files of -o and --data: the ending fits, the folder is there and can be written to, the file is
 * no input of the same command, no file of another kind and no interrupted run. With `-o -` the request's
 * output becomes a temporary file and the program's own words go to stderr until target_close. Returns an
 * exit code, after a message where that is not CLI_DONE. */
int target_open(const cli_command *command, cli_request *request, target *out);
/* Copy the result to standard output, if that is its place. Returns the code, or CLI_FAILED after a message.
 */
int target_close(target *out, int code);

#endif
