/* Help, manual pages and shell completion of the commands, all generated from their option tables.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_MANUAL_H
#define SALTUS_TOOLS_MANUAL_H

#include "cli.h"

/* Parts of a page about a topic: headings, paragraphs, terms (explained by the words after them), files with
 * their lines, and commands (without "saltus"), which work as typed in a folder with those files. */
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
    const manual_part *parts; /* terminated by a part of kind MANUAL_END */
    const char *see;          /* related commands */
} manual_topic;
extern const manual_topic topic_text;
/* All topics, NULL-terminated; the topic of a given name, or NULL. */
extern const manual_topic *const manual_topics[];
const manual_topic *manual_find_topic(const char *name);

/* All commands in the order of listing, NULL-terminated. */
extern const cli_command *const manual_commands[];

/* Print all commands, one per line. */
void manual_list(FILE *file);
/* A command's help: synopsis, what it does, options, examples, see also. */
void manual_help(const cli_command *command, FILE *file);
/* The same as a manual page in roff; NULL: the page of the program. */
void manual_page(const cli_command *command, FILE *file);
/* Help and manual page of a topic; the page is in the section of file formats, saltus-NAME(5). */
void manual_topic_help(const manual_topic *topic, FILE *file);
void manual_topic_page(const manual_topic *topic, FILE *file);
/* Print a bash script that completes commands, options, their words and, with manual_keys, keys of the scene.
 */
void manual_completion(FILE *file);
/* Print, as "key=" lines, what an option of a command that names a parameter (--set, --over, --in, --and)
 * accepts for a scene. Returns an exit code. */
int manual_keys(const char *command, const char *flag, const char *scene, FILE *file);
/* Write all pages (saltus.1, one for each command and topic) and the completion (saltus.bash) into a folder.
 * Returns an exit code. */
int manual_write(const char *folder);

#endif
