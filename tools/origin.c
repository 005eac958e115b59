/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

/* Quote a word for a shell if necessary. */
static void put_word(FILE *file, const char *word) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/@%";
    if (*word && word[strspn(word, plain)] == '\0') {
        fputs(word, file);
        return;
    }
    fputc('\'', file);
    for (; *word; word++)
        if (*word == '\'')
            fputs("'\\''", file);
        else
            fputc(*word, file);
    fputc('\'', file);
}

/* The text of a built-in scene or of a file; NULL if there is none or memory is lacking. Other inputs, such
 * as pipes, have been consumed already. */
static char *scene_text(const char *name, bool *memory) {
    for (int k = 0; k < saltus_scene_builtin_count(); k++)
        if (strcmp(name, saltus_scene_builtin_name(k)) == 0) {
            char *text = strdup(saltus_scene_builtin_text(k));
            *memory = text != NULL;
            return text;
        }
    struct stat info;
    char *text = NULL, *copy = NULL;
    size_t length = 0;
    saltus_message reason = {.text = ""};
    if (strcmp(name, "-") == 0 || stat(name, &info) != 0 || !S_ISREG(info.st_mode))
        return NULL;
    saltus_status status = saltus_read_file(name, &text, &length, &reason);
    if (status == SALTUS_OK) {
        copy = strndup(text, length);
        free(text);
    }
    *memory = status != SALTUS_NO_MEMORY && (copy || status != SALTUS_OK);
    return copy;
}

saltus_status cli_origin_new(const cli_request *request, cli_origin *origin, saltus_message *message) {
    const char *epoch = getenv("SOURCE_DATE_EPOCH");
    char *end = NULL;
    long long seconds = epoch ? strtoll(epoch, &end, 10) : 0;
    time_t now = epoch && end != epoch && *end == '\0' ? (time_t)seconds : time(NULL);
    struct tm parts;
    bool memory = true;
    size_t length = 0;
    if (!gmtime_r(&now, &parts) || !strftime(origin->date, sizeof origin->date, "%Y-%m-%dT%H:%M:%SZ", &parts))
        origin->date[0] = '\0';
    origin->command = NULL;
    FILE *file = open_memstream(&origin->command, &length);
    if (file)
        fprintf(file, "saltus %s", request->command->name);
    for (int k = 0; k < request->word_count && file; k++) {
        fputc(' ', file);
        put_word(file, request->words[k]);
    }
    origin->command = saltus_close_text(file, &origin->command);
    origin->scene = request->scene ? scene_text(request->scene, &memory) : NULL;
    origin->told = (saltus_origin){origin->command, origin->date, origin->scene};
    if (origin->command && memory)
        return SALTUS_OK;
    cli_origin_clear(origin);
    return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the command line");
}

void cli_origin_clear(cli_origin *origin) {
    free(origin->command);
    free(origin->scene);
    *origin = (cli_origin){.command = NULL};
}
