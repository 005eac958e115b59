/* saltus paper: the figures of the paper from scratch, by the commands of data/paper/figures.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include "interrupt.h"
#include "paper.h"
#include "ranks.h"

#include <ctype.h>
#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const cli_option figure = CLI_TEXT_OPTION("--figure", figure, "n", "this figure only, 2 to 8");
static const cli_option folder =
    CLI_TEXT_OPTION("-o", output, "folder", "where figures and data go (default paper)");
static const cli_option format =
    CLI_TEXT_OPTION("--format", format, "ending", "png, pdf or svg (default png)");
static const cli_option quick = CLI_FLAG_OPTION("--quick", quick, "fewer values and shorter runs, to try it");
static const cli_option resume =
    CLI_FLAG_OPTION("--resume", resume, "go on where an earlier run was interrupted");

static const cli_option *const options[] = {&figure, &folder, &format, &quick, &resume, &cli_force, NULL};

/* Commands that the list may use. */
static const cli_command *const known[] = {&cmd_sweep, &cmd_basins, &cmd_plot, &cmd_diagnose, &cmd_simulate};

enum { line_size = 1024, words_max = 64 };

/* A line of the list, cut into words as a shell does, with double quotes. */
typedef struct command_line {
    char text[line_size];
    char *words[words_max];
    int count;
} command_line;

/* What {...} stands for: the first of two alternatives or the second, or the figures' ending. */
static size_t put_choice(const cli_request *request, const char *from, size_t length, char *to) {
    const char *bar = memchr(from, '|', length);
    if (!bar) {
        from = request->format ? request->format : "png";
        length = strlen(from);
    } else if (request->quick) {
        length -= (size_t)(bar + 1 - from);
        from = bar + 1;
    } else
        length = (size_t)(bar - from);
    memcpy(to, from, length);
    return length;
}

/* A choice is never longer than its braces, but for the ending: three letters for eight. */
static void fill_in(const cli_request *request, const char *line, size_t length, char text[line_size]) {
    size_t used = 0;
    for (size_t k = 0; k < length && used + 1 < line_size; k++) {
        const char *end = line[k] == '{' ? memchr(line + k, '}', length - k) : NULL;
        if (end) {
            used += put_choice(request, line + k + 1, (size_t)(end - line) - k - 1, text + used);
            k = (size_t)(end - line);
        } else
            text[used++] = line[k];
    }
    text[used] = '\0';
}

static void cut(command_line *c) {
    char *from = c->text, *to = c->text;
    c->count = 0;
    while (*from && c->count < words_max) {
        while (*from == ' ')
            from++;
        if (!*from)
            break;
        c->words[c->count++] = to;
        for (bool quoted = false; *from && (quoted || *from != ' '); from++)
            if (*from == '"')
                quoted = !quoted;
            else
                *to++ = *from;
        from += *from == ' ';
        *to++ = '\0';
    }
}

static const cli_command *find_command(const char *name) {
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++)
        if (strcmp(known[k]->name, name) == 0)
            return known[k];
    return NULL;
}

static int run_line(const cli_request *request, command_line *c) {
    const cli_command *command = c->count ? find_command(c->words[0]) : NULL;
    cli_request inner;
    if (!command)
        return cli_refuse(CLI_FAILED, "paper: %.100s: no command of the list of figures", c->text);
    if (!command->together && (ranks_here() > 0 || interrupt_asked()))
        return CLI_DONE;
    if (!cli_parse(command, c->count - 1, c->words + 1, &inner))
        return CLI_FAILED;
    inner.quiet = request->quiet;
    /* One that has not been begun begins. */
    inner.resume = request->resume && command->together;
    inner.force = request->force || (request->resume && !inner.resume);
    return cli_run(command, &inner);
}

/* The number of the figure that a line begins, or 0. */
static int figure_of(const char *line, size_t length) {
    static const char word[] = "figure ";
    int number = 0;
    if (length > sizeof word && strncmp(line, word, sizeof word - 1) == 0 && isdigit(line[sizeof word - 1]))
        number = line[sizeof word - 1] - '0';
    return number;
}

/* Several processes end together, by the next sweep: there they hear of each other's signals. */
static bool goes_on(void) {
    return !interrupt_asked() || ranks_count() > 1;
}

static int run_figures(const cli_request *request) {
    command_line c;
    int current = 0, wanted = request->figure ? request->figure[0] - '0' : 0, code = CLI_DONE;
    for (const char *line = paper_figures; *line && code == CLI_DONE && goes_on();) {
        size_t length = strcspn(line, "\n");
        int begins = figure_of(line, length);
        current = begins ? begins : current;
        bool asked = current && (!wanted || wanted == current);
        if (asked && begins)
            printf("%.*s\n", (int)length, line);
        else if (asked && length && line[0] != '#') {
            fill_in(request, line, length, c.text);
            cut(&c);
            code = run_line(request, &c);
            fflush(stdout);
        }
        line += length + (line[length] == '\n');
    }
    if (code == CLI_DONE && interrupt_asked())
        return interrupt_report("--resume goes on");
    return code;
}

/* Make the folder, and those that it is in, and go there. */
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
    const char *number = request->figure;
    int chosen = 0;
    if (request->input_count)
        return cli_refuse(CLI_BAD_INPUT, "%s: unexpected; paper takes options only", request->inputs[0]);
    if (number && (number[0] < '2' || number[0] > '8' || number[1]))
        return cli_refuse(CLI_BAD_INPUT, "--figure %s: must be from 2 to 8", number);
    if (!cli_choose(&format, request->format, formats, &chosen))
        return CLI_BAD_INPUT;
    if (!enter(request->output ? request->output : "paper"))
        return CLI_FAILED;
    return run_figures(request);
}

static const cli_example examples[] = {
    {"paper --figure 3 -o figures", "one figure, with its data, into a folder"},
    {"paper --figure 3 --format svg -o figures", "the same as SVG"},
    {NULL, NULL}};

const cli_command cmd_paper = {
    .name = "paper",
    .summary = "the figures of Wang et al. 2020 from scratch",
    .usage = "[--figure n] [-o folder] [--format png|pdf|svg] [--quick]",
    .help = "Draw Figures 2 to 8 of Wang et al. 2020, doi 10.6052/0459-1879-20-137, from scratch. The data "
            "go beside the figures, as files that saltus plot and saltus export read.",
    .together = true,
    .options = options,
    .examples = examples,
    .see = "sweep diagnose plot",
    .run = run,
};
