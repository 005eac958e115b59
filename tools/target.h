/* Checks of output files. All commands use them before anything is computed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_TARGET_H
#define SALTUS_TOOLS_TARGET_H

#include "cli.h"

/* Standard output as destination of a result (`-o -`); unused if zeroed. */
typedef struct target {
    char folder[64], path[96]; /* temporary place of the result before it is copied */
    char journal[112];         /* of an interrupted sweep, which nothing can resume */
    int descriptor;            /* the real standard output, kept while the program's messages go to stderr */
    void (*broken_pipe)(int);  /* what a broken pipe did before */
} target;

/* Check the files of -o and --data: the ending is allowed, the folder exists and is writable, and the file is
 * not an input of the command, another kind of file or an interrupted run. With `-o -` the output becomes a
 * temporary file, and the program's messages go to stderr until target_close. Returns an exit code, after a
 * message unless it is CLI_DONE. */
int target_open(const cli_command *command, cli_request *request, target *out);
/* Copy the result to standard output if that is its destination. Returns `code`, or CLI_FAILED after a
 * message. */
int target_close(target *out, int code);

#endif
