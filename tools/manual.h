/* What the commands say of themselves: help, manual pages and the completion of the shell, all from their
 * tables of options.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_MANUAL_H
#define SALTUS_TOOLS_MANUAL_H

#include "cli.h"

/* The commands in the order of listing; NULL after them. */
extern const cli_command *const manual_commands[];

/* All commands, one in a line. */
void manual_list(FILE *file);
/* A command's help: synopsis, what it does, options, examples, see also. */
void manual_help(const cli_command *command, FILE *file);
/* The same as a manual page, in the language of man; NULL: the page of the program. */
void manual_page(const cli_command *command, FILE *file);
/* A script by which bash completes commands, options and their words. */
void manual_completion(FILE *file);
/* All pages, saltus.1 and one for each command, and the completion (saltus.bash) into a folder. Returns an
 * exit code. */
int manual_write(const char *folder);

#endif
