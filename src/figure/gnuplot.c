/* Running gnuplot. Script, picture and error messages pass through nameless temporary files: nothing is left
 * behind, and no pipe can fill up and block.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/page.h"

#include "record/output.h"

#include <errno.h>
#include <spawn.h>
#include <stdbool.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum { exit_absent = 127 };

/* Run gnuplot with these files as its standard streams; *outcome is its wait status. Returns 0 or an
 * errno. */
static int run(FILE *script, FILE *picture, FILE *complaints, int *outcome) {
    char name[] = "gnuplot", plain[] = "--default-settings";
    char *const arguments[] = {name, plain, NULL};
    FILE *const streams[] = {script, picture, complaints};
    posix_spawn_file_actions_t actions;
    pid_t child;
    int failure = posix_spawn_file_actions_init(&actions);
    if (failure)
        return failure;
    for (int k = 0; k < 3 && !failure; k++)
        failure = posix_spawn_file_actions_adddup2(&actions, fileno(streams[k]), k);
    if (!failure)
        failure = posix_spawnp(&child, name, &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failure)
        return failure;
    while (waitpid(child, outcome, 0) < 0)
        if (errno != EINTR)
            return errno;
    /* POSIX allows posix_spawnp to succeed if the program does not exist; the child then exits with 127. */
    return WIFEXITED(*outcome) && WEXITSTATUS(*outcome) == exit_absent ? ENOENT : 0;
}

/* Whether the picture is complete; a full disk at $TMPDIR cuts off its end. */
static bool complete(FILE *picture) {
    char tail[64] = "";
    if (fseek(picture, -(long)(sizeof tail), SEEK_END) != 0 ||
        fread(tail, 1, sizeof tail, picture) != sizeof tail)
        return false;
    for (size_t k = 0; k + 6 <= sizeof tail; k++)
        if (memcmp(tail + k, "</svg>", 6) == 0 || memcmp(tail + k, "%%EOF", 5) == 0 ||
            memcmp(tail + k, "IEND", 4) == 0)
            return true;
    return false;
}

saltus_status saltus_gnuplot_run(FILE *script, FILE **picture, saltus_message *message) {
    FILE *complaints = saltus_nameless_file();
    saltus_status status = SALTUS_IO;
    char text[256] = "";
    int outcome = 0, failure = 0;
    *picture = complaints ? saltus_nameless_file() : NULL;
    if (fflush(script) != 0 || lseek(fileno(script), 0, SEEK_SET) != 0)
        saltus_fail(message, status, "the script for gnuplot could not be written: %s", strerror(errno));
    else if (!*picture)
        saltus_fail(message, status, "no temporary file can be made: %s", strerror(errno));
    else if ((failure = run(script, *picture, complaints, &outcome)) == ENOENT)
        saltus_fail(message, status,
                    "gnuplot was not found; figures need gnuplot 5.4 or newer (package gnuplot-nox)");
    else if (failure)
        saltus_fail(message, status, "gnuplot could not be run: %s", strerror(failure));
    else if (!WIFEXITED(outcome) || WEXITSTATUS(outcome) != 0) {
        /* The line of gnuplot's error messages that names the error ("..., line 7: ..."), otherwise the last
         * line. */
        char line[512];
        bool named = false;
        text[0] = 0;
        rewind(complaints);
        while (!named && fgets(line, sizeof line, complaints)) {
            char *place = strstr(line, "line ");
            char *start = place ? place : line + strspn(line, " \t^\n");
            start[strcspn(start, "\n")] = 0;
            named = place && strchr(place, ':') && !strstr(place, "warning:");
            if (*start && (named || !place))
                snprintf(text, sizeof text, "%s", start);
        }
        saltus_fail(message, status, "gnuplot failed: %s", text[0] ? text : "it gave no reason");
    } else if (!complete(*picture))
        saltus_fail(message, status, "gnuplot left an incomplete picture");
    else
        status = SALTUS_OK;
    if (complaints)
        fclose(complaints);
    if (*picture && status != SALTUS_OK) {
        fclose(*picture);
        *picture = NULL;
    }
    return status;
}
