/* Storage of finished work in a folder.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "keep.h"

#include <string.h>

static void keep_path(const trial_request *request, const char *name, char *path, size_t size) {
    snprintf(path, size, "%s/%s%s.txt", request->keep, name, request->quick ? "-quick" : "");
}

FILE *trial_kept(const trial_request *request, const char *name) {
    char path[512], version[32] = "";
    if (!request->keep)
        return NULL;
    keep_path(request, name, path, sizeof path);
    FILE *file = fopen(path, "r");
    if (!file)
        return NULL;
    if (fscanf(file, "saltus %31[^\n]", version) == 1 && fgetc(file) == '\n' &&
        strcmp(version, SALTUS_VERSION) == 0)
        return file;
    fclose(file);
    return NULL;
}

FILE *trial_keep_begin(void) {
    return tmpfile();
}

static bool copy(FILE *from, FILE *to) {
    for (int c; (c = fgetc(from)) != EOF;)
        fputc(c, to);
    return !ferror(from) && !ferror(to);
}

FILE *trial_keep(const trial_request *request, const char *name, FILE *stream) {
    char path[512];
    bool good = !ferror(stream);
    rewind(stream);
    if (request->keep) {
        keep_path(request, name, path, sizeof path);
        FILE *file = fopen(path, "w");
        good = good && file && fprintf(file, "saltus %s\n", SALTUS_VERSION) > 0 && copy(stream, file);
        good &= file && !fclose(file);
        rewind(stream);
    }
    if (good)
        return stream;
    fclose(stream);
    return NULL;
}
