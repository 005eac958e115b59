/* What the commands say of themselves: help, manual pages and the completion of the shell, all from their
 * tables of options.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_MANUAL_H
#define SALTUS_TOOLS_MANUAL_H

#include "cli.h"

/* A page about something else than a command: headings, words, terms that the words behind them explain,
 * files with their lines, and commands ("saltus" goes without saying), which work as typed in a folder that
 * holds those files. */
typedef enum manual_kind {
    MANUAL_END,
    MANUAL_HEAD,
    MANUAL_WORDS,
    MANUAL_TERM,
    MANUAL_FILE,
    MANUAL_LINES,
    MANUAL_COMMAND
} manual_kind;
typedef struct manual_part {
    manual_kind kind;
    const char *text;
} manual_part;
typedef struct manual_topic {
    const char *name, *summary;
    const manual_part *parts; /* up to one of kind MANUAL_END */
    const char *see;          /* commands that go with it */
} manual_topic;
extern const manual_topic topic_text;
/* The topics; NULL after them. The topic of that name, or NULL. */
extern const manual_topic *const manual_topics[];
const manual_topic *manual_find_topic(const char *name);

/* The commands in the order of listing; NULL after them. */
extern const cli_command *const manual_commands[];

/* All commands, one in a line. */
void manual_list(FILE *file);
/* A command's help: synopsis, what it does, options, examples, see also. */
void manual_help(const cli_command *command, FILE *file);
/* The same as a manual page, in the language of man; NULL: the page of the program. */
void manual_page(const cli_command *command, FILE *file);
/* The same of a topic; its page stands among the formats of files, saltus-NAME(5). */
void manual_topic_help(const manual_topic *topic, FILE *file);
void manual_topic_page(const manual_topic *topic, FILE *file);
/* A script by which bash completes commands, options and their words. */
void manual_completion(FILE *file);
/* All pages, saltus.1, one for each command and each topic, and the completion (saltus.bash) into a folder.
 * Returns an exit code. */
int manual_write(const char *folder);

#endif
