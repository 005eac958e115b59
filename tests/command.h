/* Commands run by the shell in a folder of their own, and what they say.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_COMMAND_H
#define SALTUS_TESTS_COMMAND_H

#include "folder.h"

#include <sys/wait.h>
#include <unistd.h>

typedef struct fixture {
    char folder[64], path[320];
} fixture;

static inline int open_fixture(void **state) {
    fixture *f = calloc(1, sizeof *f);
    strcpy(f->folder, "/tmp/saltus-test-XXXXXX");
    assert_non_null(mkdtemp(f->folder));
    /* Equal results give equal files, whenever they are made. */
    setenv("SOURCE_DATE_EPOCH", "951782400", 1);
    *state = f;
    return 0;
}

static inline int close_fixture(void **state) {
    fixture *f = *state;
    folder_files(f->folder, true);
    rmdir(f->folder);
    free(f);
    return 0;
}

static inline const char *path_in(fixture *f, const char *name) {
    snprintf(f->path, sizeof f->path, "%s/%s", f->folder, name);
    return f->path;
}

/* The exit status of a command line of the shell; what it says goes to `out` and `err`. */
static inline int run(const fixture *f, const char *line) {
    char text[1200];
    snprintf(text, sizeof text, "cd %s && exec %s %s >out 2>err", f->folder, SALTUS_COMMAND, line);
    int outcome = system(text);
    return WIFEXITED(outcome) ? WEXITSTATUS(outcome) : 128;
}

static inline char *said(fixture *f, const char *where) {
    size_t length;
    return read_all(path_in(f, where), &length);
}

/* What a command that succeeds without a word on stderr says. */
static inline char *told(fixture *f, const char *line) {
    int status = run(f, line);
    char *errors = said(f, "err");
    if (status != 0 || errors[0])
        fail_msg("%s: exit status %d: %s", line, status, errors);
    free(errors);
    return said(f, "out");
}

#endif
