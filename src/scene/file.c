/* Files that contain scenes and their equations.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scene/scene.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static saltus_status fail_to_open(const char *source, int error, saltus_message *message) {
    const saltus_source place = {.origin = source, .message = message};
    if (error == EISDIR)
        return saltus_source_fail(&place, 0, SALTUS_IO, "is a directory, not a scene file");
    if (error != ENOENT && error != ENAMETOOLONG)
        return saltus_source_fail(&place, 0, SALTUS_IO, "cannot be opened (%s)", strerror(error));
    if (strpbrk(source, "/."))
        return saltus_source_fail(&place, 0, SALTUS_IO, "no such file");
    /* Suggest built-in scenes: those that contain the word or are contained in it, and the nearest one; all
     * of them if none is near. */
    saltus_words words = {""};
    const char *names[64] = {NULL};
    int count = 0;
    for (; count < saltus_builtin_count && count < 64; count++)
        names[count] = saltus_builtins[count].name;
    const char *nearest = saltus_nearest_word(source, names, count);
    for (int k = 0; k < count; k++)
        if (names[k] == nearest ||
            (strlen(source) > 2 && (strstr(names[k], source) || strstr(source, names[k]))))
            saltus_words_add(&words, names[k]);
    if (!words.text[0])
        words = saltus_words_of(names, count);
    const saltus_quoted name = saltus_quote(source);
    return saltus_fail(message, SALTUS_BAD_INPUT,
                       "%s: neither a file nor a built-in scene; built-in scenes: %s", name.text, words.text);
}

saltus_status saltus_read_file(const char *path, char **text, size_t *length, saltus_message *message) {
    const saltus_source place = {.origin = path, .message = message};
    struct stat info;
    *text = NULL;
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
        return fail_to_open(path, EISDIR, message);
    FILE *file = fopen(path, "rb");
    if (!file)
        return fail_to_open(path, errno, message);
    /* Reading one byte more than allowed detects files that are too large, even if the size is unknown. */
    *text = malloc(SALTUS_SCENE_BYTES_MAX + 1);
    *length = *text ? fread(*text, 1, SALTUS_SCENE_BYTES_MAX + 1, file) : 0;
    saltus_status status = SALTUS_OK;
    if (!*text)
        status = saltus_source_fail(&place, 0, SALTUS_NO_MEMORY, "no memory for reading the scene");
    else if (ferror(file))
        status = saltus_source_fail(&place, 0, SALTUS_IO, "cannot be read (%s)", strerror(errno));
    else if (*length > SALTUS_SCENE_BYTES_MAX)
        status = saltus_source_fail(&place, 0, SALTUS_BAD_INPUT, "too large for a scene (more than 1 MiB)");
    fclose(file);
    if (status != SALTUS_OK) {
        free(*text);
        *text = NULL;
    }
    return status;
}
