/* saltus plot: a file of results as a figure.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include <string.h>

static const cli_option show = {
    "--show",
    CLI_TEXT,
    offsetof(cli_request, show),
    0,
    0,
    0,
    "what",
    "speed (largest of an orbit), impacts (the speed of each), displacement, velocity or period"};

static const cli_option range = {"--range",
                                 CLI_TEXT,
                                 offsetof(cli_request, range),
                                 0,
                                 0,
                                 0,
                                 "key=lo:hi",
                                 "the part of the parameter's range that is drawn"};

static const cli_option *const options[] = {&cli_output, &show, &range, NULL};

static bool read_show(const char *text, saltus_show *wanted) {
    static const char *const words[] = {[SALTUS_SHOW_SPEED] = "speed",
                                        [SALTUS_SHOW_IMPACTS] = "impacts",
                                        [SALTUS_SHOW_DISPLACEMENT] = "displacement",
                                        [SALTUS_SHOW_VELOCITY] = "velocity",
                                        [SALTUS_SHOW_PERIOD] = "period"};
    *wanted = SALTUS_SHOW_AUTOMATIC;
    for (int k = SALTUS_SHOW_SPEED; text && k <= SALTUS_SHOW_PERIOD; k++)
        if (strcmp(text, words[k]) == 0)
            *wanted = (saltus_show)k;
    if (!text || *wanted != SALTUS_SHOW_AUTOMATIC)
        return true;
    fprintf(stderr, "saltus: --show %s: must be speed, impacts, displacement, velocity or period\n", text);
    return false;
}

static int run(const cli_request *request) {
    saltus_message message = {""};
    saltus_plot_options how = saltus_plot_defaults();
    char key[SALTUS_KEY_MAX];
    if (!request->input_count || !request->output) {
        fprintf(stderr, "saltus: plot: needs a file and -o figure.png, figure.pdf or figure.svg\n");
        return CLI_BAD_INPUT;
    }
    if (!read_show(request->show, &how.show) ||
        (request->range && !cli_parse_range("--range", request->range, key, &how.low, &how.high)))
        return CLI_BAD_INPUT;
    saltus_status status =
        saltus_plot(request->inputs, request->input_count, &how, request->output, &message);
    if (status == SALTUS_OK)
        printf("figure: %s\n", request->output);
    return cli_report(status, &message);
}

const cli_command cmd_plot = {
    .name = "plot",
    .usage = "FILE.h5 [FILE2.h5] -o figure.png|pdf|svg [--show what] [--range key=lo:hi]",
    .help =
        "Draw branches of periodic orbits: solid where stable, dashed where not, n/p along them, special "
        "points marked.\n"
        "Curves of special points are drawn over their two parameters. Two files are laid over each other.",
    .inputs = CLI_INPUTS_MAX,
    .options = options,
    .run = run,
};
