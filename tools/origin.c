/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "origin.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

/* A word as a shell reads it. */
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

static char *command_line(const cli_request *request) {
    char *text = NULL;
    size_t length = 0;
    FILE *file = open_memstream(&text, &length);
    if (!file)
        return NULL;
    fprintf(file, "saltus %s", request->command->name);
    for (int k = 0; k < request->word_count; k++) {
        fputc(' ', file);
        put_word(file, request->words[k]);
    }
    bool good = !ferror(file);
    if (fclose(file) == 0 && good)
        return text;
    free(text);
    return NULL;
}

/* The text of a built-in scene or of a file; NULL where there is none, or no memory. */
static char *scene_text(const char *name, bool *memory) {
    enum { most = 1 << 20 };
    for (int k = 0; k < saltus_scene_builtin_count(); k++)
        if (strcmp(name, saltus_scene_builtin_name(k)) == 0) {
            char *text = strdup(saltus_scene_builtin_text(k));
            *memory = text != NULL;
            return text;
        }
    FILE *file = strcmp(name, "-") == 0 ? NULL : fopen(name, "r");
    if (!file)
        return NULL;
    char *text = calloc(1, most + 1);
    *memory = text != NULL;
    size_t length = text ? fread(text, 1, most, file) : 0;
    bool whole = text && !ferror(file) && length < most && strlen(text) == length;
    fclose(file);
    if (whole)
        return text;
    free(text);
    return NULL;
}

static void tell_date(char date[32]) {
    const char *epoch = getenv("SOURCE_DATE_EPOCH");
    char *end = NULL;
    long long seconds = epoch ? strtoll(epoch, &end, 10) : 0;
    time_t now = epoch && end != epoch && *end == '\0' ? (time_t)seconds : time(NULL);
    struct tm parts;
    if (!gmtime_r(&now, &parts) || !strftime(date, 32, "%Y-%m-%dT%H:%M:%SZ", &parts))
        date[0] = '\0';
}

saltus_status cli_origin_new(const cli_request *request, cli_origin *origin, saltus_message *message) {
    bool memory = true;
    origin->command = command_line(request);
    origin->scene = request->scene ? scene_text(request->scene, &memory) : NULL;
    tell_date(origin->date);
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
