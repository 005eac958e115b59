/* Feeds files, and all files of folders, to a fuzz target: the corpus as an ordinary test, without a fuzzer.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "fuzz.h"

#include <dirent.h>
#include <sys/stat.h>

static int feed_file(const char *path) {
    struct stat facts;
    FILE *file = fopen(path, "rb");
    if (!file || fstat(fileno(file), &facts) != 0 || !S_ISREG(facts.st_mode)) {
        fprintf(stderr, "replay: %s cannot be read\n", path);
        exit(1);
    }
    size_t size = (size_t)facts.st_size;
    uint8_t *bytes = malloc(size ? size : 1);
    fuzz_check(bytes && fread(bytes, 1, size, file) == size, path);
    fclose(file);
    LLVMFuzzerTestOneInput(bytes, size);
    free(bytes);
    return 1;
}

static int feed_folder(const char *path, DIR *folder) {
    int count = 0;
    for (struct dirent *entry = readdir(folder); entry; entry = readdir(folder)) {
        char inner[4096];
        if (entry->d_name[0] == '.')
            continue;
        snprintf(inner, sizeof inner, "%s/%s", path, entry->d_name);
        count += feed_file(inner);
    }
    closedir(folder);
    return count;
}

int main(int count, char **arguments) {
    int fed = 0;
    for (int k = 1; k < count; k++) {
        DIR *folder = opendir(arguments[k]);
        fed += folder ? feed_folder(arguments[k], folder) : feed_file(arguments[k]);
    }
    printf("%d inputs\n", fed);
    return fed > 0 ? 0 : 1;
}
