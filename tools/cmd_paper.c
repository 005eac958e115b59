/* saltus paper: draws the figures of the paper from scratch, with the commands in data/paper/figures.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"
#include "paper.h"
#include "ranks.h"
#include "record/output.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *const numbers[] = {"2", "3", "4", "5", "6", "7", "8", NULL}, *const formats[] = {
                                                                                    "png", "pdf", "svg",
                                                                                    NULL};
static const cli_option figure = CLI_CHOICE("--figure", "n", "this figure only, 2 to 8", numbers);
static const cli_option folder =
    CLI_OPTION("-o", CLI_TEXT, "folder", "where figures and data go (default paper)");
static const cli_option format = CLI_CHOICE("--format", "ending", "png, pdf or svg (default png)", formats);
static const cli_option quick =
    CLI_OPTION("--quick", CLI_FLAG, NULL, "fewer values and shorter runs, to try it");
static const cli_option resume =
    CLI_OPTION("--resume", CLI_FLAG, NULL, "go on where an earlier run was interrupted");

/* Commands allowed in the list. */
static const cli_command *const known[] = {&cmd_sweep, &cmd_basins, &cmd_plot, &cmd_diagnose, &cmd_simulate};

enum { line_size = 1024, words_max = 64, added_max = 5, files_max = 4 };

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
static int cut(char *text, const char *words[words_max]) {
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

/* Run a line of the list, or only check that its files may be written. They go into the folder. */
static int run_line(const cli_request *request, const char *folder, bool checking, char *text) {
    static const char *const endings[] = {".h5", ".png", ".pdf", ".svg"};
    const bool goes_on = cli_given(request, "--resume");
    const char *words[words_max + added_max];
    char files[files_max][2 * line_size];
    int count = cut(text, words), moved = 0;
    const cli_command *command = NULL;
    cli_request inner;
    for (size_t k = 0; k < sizeof known / sizeof known[0] && count; k++)
        if (strcmp(known[k]->name, words[0]) == 0)
            command = known[k];
    if (!command)
        return cli_refuse(CLI_FAILED, "paper: %.100s: no command of the list of figures", text);
    if (!checking && !command->together && (ranks_here() > 0 || interrupt_asked()))
        return CLI_DONE;
    const bool draws = command == &cmd_plot || command == &cmd_diagnose;
    for (int k = 1; k < count; k++)
        for (size_t e = 0; e < sizeof endings / sizeof endings[0]; e++)
            if (moved < files_max && saltus_path_ends(words[k], endings[e])) {
                snprintf(files[moved], sizeof files[moved], "%s/%s", folder, words[k]);
                words[k] = files[moved++];
                break;
            }
    if (cli_given(request, "--quiet"))
        words[count++] = "--quiet";
    /* How figures look. */
    if (draws && cli_given(request, "--size")) {
        words[count++] = "--size";
        words[count++] = cli_text(request, "--size");
    }
    if (draws && cli_given(request, "--no-heading"))
        words[count++] = "--no-heading";
    /* With --resume a sweep without a file simply starts; commands that cannot resume run again. */
    if (goes_on && command->together)
        words[count++] = "--resume";
    else if (goes_on || cli_given(request, "--force"))
        words[count++] = "--force";
    if (!cli_parse(command, count - 1, words + 1, &inner))
        return CLI_FAILED;
    return (checking ? cli_check : cli_run)(command, &inner);
}

/* Create the folder with its parents. */
static bool make_folder(const char *path) {
    char part[line_size];
    struct stat facts;
    const size_t length = strlen(path);
    int reason = length == 0 ? ENOENT : 0;
    if (length >= sizeof part)
        return cli_refuse(false, "paper: -o %s: no folder can be made there: the name is too long", path);
    for (size_t k = 1; k <= length && !reason; k++)
        if (path[k] == '/' || path[k] == '\0') {
            memcpy(part, path, k);
            part[k] = '\0';
            if (mkdir(part, 0777) != 0) {
                reason = errno == EEXIST ? ENOTDIR : errno;
                if (stat(part, &facts) == 0 && S_ISDIR(facts.st_mode))
                    reason = 0;
            }
        }
    if (reason)
        return cli_refuse(false, "paper: -o %s: no folder can be made there: %s", path, strerror(reason));
    if (access(path, W_OK | X_OK) != 0)
        return cli_refuse(false, "paper: -o %s: nothing can be written there: %s", path, strerror(errno));
    return true;
}

/* Go through the list: check the files of all lines, or run the lines. */
static int go_through(const cli_request *request, const char *folder, bool checking) {
    const char *number = cli_text(request, "--figure");
    int current = 0, code = CLI_DONE;
    char text[line_size];
    /* With several ranks continue to the next sweep after a signal: only there do all ranks learn of it, so
     * that they end together. */
    for (const char *line = paper_figures;
         *line && code == CLI_DONE && (checking || !interrupt_asked() || ranks_count() > 1);) {
        const size_t length = strcspn(line, "\n");
        int begins = 0; /* the number of the figure that the line begins */
        sscanf(line, "figure %1d", &begins);
        current = begins ? begins : current;
        const bool asked = current && (!number || number[0] - '0' == current);
        if (asked && begins && !checking)
            printf("%.*s\n", (int)length, line);
        else if (asked && !begins && length && line[0] != '#') {
            fill_in(request, line, length, text);
            code = run_line(request, folder, checking, text);
            fflush(stdout);
        }
        line += length + (line[length] == '\n');
    }
    return code;
}

static int run(const cli_request *request) {
    const char *number = cli_text(request, "--figure"), *folder = request->output ? request->output : "paper";
    int chosen = 0, code = CLI_DONE;
    if (request->input_count)
        return cli_refuse(CLI_BAD_INPUT, "%s: unexpected; paper takes options only", request->inputs[0]);
    if (number && (number[0] < '2' || number[0] > '8' || number[1]))
        return cli_refuse(CLI_BAD_INPUT, "--figure %s: must be from 2 to 8", number);
    if (strcmp(folder, "-") == 0)
        return cli_refuse(CLI_BAD_INPUT, "-o -: paper makes many files; name a folder for them");
    if (!cli_choose(request, "--format", formats, &chosen))
        return CLI_BAD_INPUT;
    saltus_message message = {.text = ""};
    if (saltus_figure_check("figure.png", &request->look, &message) != SALTUS_OK)
        return cli_refuse(CLI_BAD_INPUT, "--size %s: %s", cli_text(request, "--size"), message.text);
    /* What cannot be written is told before anything is computed. */
    if (ranks_here() == 0)
        code = make_folder(folder) ? go_through(request, folder, true) : CLI_BAD_INPUT;
    code = ranks_agree(code);
    if (code == CLI_DONE)
        code = go_through(request, folder, false);
    return code == CLI_DONE && interrupt_asked() ? interrupt_report("--resume goes on") : code;
}

const cli_command cmd_paper = {
    .name = "paper",
    .summary = "the figures of Wang et al. 2020 from scratch",
    .usage = "[--figure n] [-o folder] [--format png|pdf|svg] [--size column] [--quick]",
    .help = "Draw Figures 2 to 8 of Wang et al. 2020, doi 10.6052/0459-1879-20-137, from scratch. The data "
            "go beside the figures, as files that saltus plot and saltus export read.",
    .together = true,
    .options =
        CLI_OPTIONS(&figure, &folder, &format, &cli_size, &cli_no_heading, &quick, &resume, &cli_force),
    .examples = CLI_EXAMPLES({"paper --figure 3 -o figures", "one figure, with its data, into a folder"},
                             {"paper --figure 3 --format svg --size column -o figures",
                              "the same as SVG, one column of a journal wide"}),
    .see = "sweep diagnose plot",
    .run = run,
};
