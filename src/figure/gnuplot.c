/* Running gnuplot. Script, picture and error messages pass through temporary files without a name: nothing
 * can be left behind, and no pipe can fill up and block.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/gnuplot.h"

#include "record/output.h"

#include <errno.h>
#include <math.h>
#include <spawn.h>
#include <stdbool.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

const char *saltus_gnuplot_terminal(const char *path) {
    if (saltus_path_ends(path, ".png"))
        return "pngcairo size 1600,1200 enhanced font 'DejaVu Sans,13' background '#ffffff' rounded";
    if (saltus_path_ends(path, ".pdf"))
        return "pdfcairo size 11.69in,8.77in enhanced font 'DejaVu Sans,13' fontscale 0.58 linewidth 0.75 "
               "pointscale 0.75 rounded";
    if (saltus_path_ends(path, ".svg"))
        return "svg size 1600,1200 dynamic enhanced font 'DejaVu Sans,17' background '#ffffff' rounded";
    return NULL;
}

saltus_status saltus_gnuplot_open(FILE **script, saltus_message *message) {
    *script = saltus_nameless_file();
    return *script ? SALTUS_OK
                   : saltus_fail(message, SALTUS_IO, "no temporary file can be made: %s", strerror(errno));
}

void saltus_put_style(FILE *script, const char *grid) {
    fprintf(script,
            "set encoding utf8\n"
            "set border 3 lc rgb '#606060' lw 1\n"
            "set tics out nomirror scale 0.6 tc rgb '#303030'\n"
            "set grid lt 1 lc rgb '#%s' lw 1 back\n"
            "set key off\n"
            "set minussign\n",
            grid);
}

void saltus_put_margins(FILE *script, const double across[2], const double up[2]) {
    fprintf(script,
            "set lmargin at screen %g\nset rmargin at screen %g\nset bmargin at screen %g\n"
            "set tmargin at screen %g\n",
            across[0], across[1], up[0], up[1]);
}

enum { exit_absent = 127 };

/* Run gnuplot with these three as its standard streams; its wait status in *outcome. Returns 0 or an errno.
 */
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
    /* POSIX: where posix_spawnp cannot report that there is no such program, the child exits with 127. */
    return WIFEXITED(*outcome) && WEXITSTATUS(*outcome) == exit_absent ? ENOENT : 0;
}

/* The line of gnuplot's complaints that says what is wrong: "..., line 7: ..." or, failing that, the last
 * one. */
static void pick_complaint(FILE *complaints, char *text, size_t room) {
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
            snprintf(text, room, "%s", start);
    }
}

/* Copy the picture to its place. */
static saltus_status deliver(FILE *picture, const char *path, saltus_message *message) {
    saltus_output output;
    char block[65536];
    size_t length;
    saltus_status status = saltus_output_open(&output, path, message);
    if (status != SALTUS_OK)
        return status;
    rewind(picture);
    while ((length = fread(block, 1, sizeof block, picture)) > 0)
        fwrite(block, 1, length, output.file);
    if (ferror(picture))
        status = saltus_fail(message, SALTUS_IO, "the picture could not be read back: %s", strerror(errno));
    return saltus_output_close(&output, status, message);
}

/* Whether the picture is complete: a full disk under $TMPDIR would cut off its last bytes. */
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

saltus_status saltus_gnuplot_draw(FILE *script, const char *path, saltus_message *message) {
    FILE *picture = saltus_nameless_file(), *complaints = picture ? saltus_nameless_file() : NULL;
    saltus_status status = SALTUS_IO;
    char text[256] = "";
    int outcome = 0, failure = 0;
    if (fflush(script) != 0 || lseek(fileno(script), 0, SEEK_SET) != 0)
        saltus_fail(message, status, "the script for gnuplot could not be written: %s", strerror(errno));
    else if (!complaints)
        saltus_fail(message, status, "no temporary file can be made: %s", strerror(errno));
    else if ((failure = run(script, picture, complaints, &outcome)) == ENOENT)
        saltus_fail(message, status,
                    "gnuplot was not found; figures need gnuplot 5.4 or newer (package gnuplot-nox)");
    else if (failure)
        saltus_fail(message, status, "gnuplot could not be run: %s", strerror(failure));
    else if (!WIFEXITED(outcome) || WEXITSTATUS(outcome) != 0) {
        pick_complaint(complaints, text, sizeof text);
        saltus_fail(message, status, "gnuplot failed: %s", text[0] ? text : "it gave no reason");
    } else if (!complete(picture))
        saltus_fail(message, status, "gnuplot left an incomplete picture");
    else
        status = deliver(picture, path, message);
    if (complaints)
        fclose(complaints);
    if (picture)
        fclose(picture);
    fclose(script);
    return status;
}

void saltus_range_add(saltus_range *range, double value) {
    if (!isfinite(value))
        return;
    range->low = fmin(range->low, value);
    range->high = fmax(range->high, value);
}

void saltus_range_pad(saltus_range *range, double part, double scale) {
    double width = range->high - range->low, middle = 0.5 * (range->low + range->high);
    double size = fmax(scale, fabs(middle));
    if (!(width > 1e-6 * size)) {
        range->low = middle - size;
        range->high = middle + size;
        width = 2 * size;
    }
    range->low -= part * width;
    range->high += part * width;
}
