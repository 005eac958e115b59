/* saltus paper: draws the figures of the paper from scratch, with the commands in data/paper/figures.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"
#include "paper.h"
#include "ranks.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const cli_option figure = CLI_OPTION("--figure", CLI_TEXT, "n", "this figure only, 2 to 8");
static const cli_option folder =
    CLI_OPTION("-o", CLI_TEXT, "folder", "where figures and data go (default paper)");
static const cli_option format = CLI_OPTION("--format", CLI_TEXT, "ending", "png, pdf or svg (default png)");
static const cli_option quick =
    CLI_OPTION("--quick", CLI_FLAG, NULL, "fewer values and shorter runs, to try it");
static const cli_option resume =
    CLI_OPTION("--resume", CLI_FLAG, NULL, "go on where an earlier run was interrupted");

/* Commands allowed in the list. */
static const cli_command *const known[] = {&cmd_sweep, &cmd_basins, &cmd_plot, &cmd_diagnose, &cmd_simulate};

enum { line_size = 1024, words_max = 64, added_max = 3 };

/* Expand a line: {a|b} becomes a, or with --quick b; {format} becomes the figures' ending. The result is
 * never longer than the line. */
static void fill_in(const cli_request *request, const char *line, size_t length, char text[line_size]) {
    const char *format = cli_text(request, "--format"), *stop = line + length;
    size_t used = 0;
    for (const char *at = line; at < stop && used + 1 < line_size; at++) {
        const char *end = *at == '{' ? memchr(at, '}', (size_t)(stop - at)) : NULL;
        if (!end) {
            text[used++] = *at;
            continue;
        }
        const char *from = at + 1, *to = end, *bar = memchr(from, '|', (size_t)(end - from));
        if (!bar) {
            from = format ? format : "png";
            to = from + strlen(from);
        } else if (cli_given(request, "--quick"))
            from = bar + 1;
        else
            to = bar;
        memcpy(text + used, from, (size_t)(to - from));
        used += (size_t)(to - from);
        at = end;
    }
    text[used] = '\0';
}

/* Split a line into words like a shell, with double quotes; returns their number. */
static int cut(char *text, char *words[words_max]) {
    int count = 0;
    for (char *from = text, *to = text; *from && count < words_max;) {
        while (*from == ' ')
            from++;
        if (!*from)
            break;
        words[count++] = to;
        for (bool quoted = false; *from && (quoted || *from != ' '); from++)
            if (*from == '"')
                quoted = !quoted;
            else
                *to++ = *from;
        from += *from == ' ';
        *to++ = '\0';
    }
    return count;
}

static int run_line(const cli_request *request, char *text) {
    const bool goes_on = cli_given(request, "--resume");
    char *words[words_max + added_max], quietly[] = "--quiet", again[] = "--resume", anew[] = "--force";
    int count = cut(text, words);
    const cli_command *command = NULL;
    cli_request inner;
    for (size_t k = 0; k < sizeof known / sizeof known[0] && count; k++)
        if (strcmp(known[k]->name, words[0]) == 0)
            command = known[k];
    if (!command)
        return cli_refuse(CLI_FAILED, "paper: %.100s: no command of the list of figures", text);
    if (!command->together && (ranks_here() > 0 || interrupt_asked()))
        return CLI_DONE;
    if (cli_given(request, "--quiet"))
        words[count++] = quietly;
    /* With --resume a sweep without a file simply starts; commands that cannot resume run again. */
    if (goes_on && command->together)
        words[count++] = again;
    else if (goes_on || cli_given(request, "--force"))
        words[count++] = anew;
    return cli_parse(command, count - 1, words + 1, &inner) ? cli_run(command, &inner) : CLI_FAILED;
}

/* Create the folder with its parents, and change to it. */
static bool enter(const char *path) {
    char part[line_size];
    size_t length = strlen(path);
    for (size_t k = 1; k <= length && length < sizeof part; k++)
        if (path[k] == '/' || path[k] == '\0') {
            memcpy(part, path, k);
            part[k] = '\0';
            mkdir(part, 0777);
        }
    if (length > 0 && length < sizeof part && chdir(path) == 0)
        return true;
    return cli_refuse(false, "paper: -o %s: no folder can be made there: %s", path,
                      length < sizeof part ? strerror(errno) : "the name is too long");
}

static int run(const cli_request *request) {
    static const char *const formats[] = {"png", "pdf", "svg", NULL};
    const char *number = cli_text(request, "--figure");
    int chosen = 0, current = 0, code = CLI_DONE;
    char text[line_size];
    if (request->input_count)
        return cli_refuse(CLI_BAD_INPUT, "%s: unexpected; paper takes options only", request->inputs[0]);
    if (number && (number[0] < '2' || number[0] > '8' || number[1]))
        return cli_refuse(CLI_BAD_INPUT, "--figure %s: must be from 2 to 8", number);
    if (!cli_choose(request, "--format", formats, &chosen))
        return CLI_BAD_INPUT;
    if (!enter(request->output ? request->output : "paper"))
        return CLI_FAILED;
    /* With several ranks continue to the next sweep after a signal: only there do all ranks learn of it, so
     * that they end together. */
    for (const char *line = paper_figures;
         *line && code == CLI_DONE && (!interrupt_asked() || ranks_count() > 1);) {
        const size_t length = strcspn(line, "\n");
        int begins = 0; /* the number of the figure that the line begins */
        sscanf(line, "figure %1d", &begins);
        current = begins ? begins : current;
        const bool asked = current && (!number || number[0] - '0' == current);
        if (asked && begins)
            printf("%.*s\n", (int)length, line);
        else if (asked && length && line[0] != '#') {
            fill_in(request, line, length, text);
            code = run_line(request, text);
            fflush(stdout);
        }
        line += length + (line[length] == '\n');
    }
    return code == CLI_DONE && interrupt_asked() ? interrupt_report("--resume goes on") : code;
}

const cli_command cmd_paper = {
    .name = "paper",
    .summary = "the figures of Wang et al. 2020 from scratch",
    .usage = "[--figure n] [-o folder] [--format png|pdf|svg] [--quick]",
    .help = "Draw Figures 2 to 8 of Wang et al. 2020, doi 10.6052/0459-1879-20-137, from scratch. The data "
            "go beside the figures, as files that saltus plot and saltus export read.",
    .together = true,
    .options = CLI_OPTIONS(&figure, &folder, &format, &quick, &resume, &cli_force),
    .examples = CLI_EXAMPLES({"paper --figure 3 -o figures", "one figure, with its data, into a folder"},
                             {"paper --figure 3 --format svg -o figures", "the same as SVG"}),
    .see = "sweep diagnose plot",
    .run = run,
};
