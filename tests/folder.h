/* What tests that write files share: a folder of their own, files read back.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TESTS_FOLDER_H
#define SALTUS_TESTS_FOLDER_H

#include "check.h"

#include <dirent.h>

/* Number of files in a folder; with `remove_them` they are deleted. */
static inline int folder_files(const char *path, bool remove_them) {
    DIR *folder = opendir(path);
    int count = 0;
    assert_non_null(folder);
    for (struct dirent *entry = readdir(folder); entry; entry = readdir(folder)) {
        char file[700];
        if (entry->d_name[0] == '.')
            continue;
        snprintf(file, sizeof file, "%s/%s", path, entry->d_name);
        if (remove_them)
            remove(file);
        count++;
    }
    closedir(folder);
    return count;
}

/* A whole file with a zero after it, to be freed; its length without that. */
static inline void *read_all(const char *path, size_t *length) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    *length = (size_t)ftell(file);
    rewind(file);
    void *bytes = calloc(*length + 1, 1);
    assert_int_equal(fread(bytes, 1, *length, file), *length);
    fclose(file);
    return bytes;
}

#endif
