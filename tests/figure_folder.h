/* What tests of figures share: a folder of their own with gnuplot's scripts in it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_FIGURE_FOLDER_H
#define SALTUS_TESTS_FIGURE_FOLDER_H

#include "figure_blocks.h"

enum { path_size = 160 };

static char folder[64];

static inline int open_folder(void **state) {
    (void)state;
    strcpy(folder, "/tmp/saltus-test-XXXXXX");
    assert_non_null(mkdtemp(folder));
    figure_open(folder);
    return 0;
}

static inline int close_folder(void **state) {
    char command[200];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static inline const char *path_in(const char *name, char path[path_size]) {
    snprintf(path, path_size, "%s/%s", folder, name);
    return path;
}

#endif
