/* saltus: the command line. Every subcommand is a thin filter around the library.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"

#include <string.h>

static const cli_command *const commands[] = {&cmd_classify, &cmd_diagnose, &cmd_simulate, &cmd_orbit,
                                              &cmd_continue, &cmd_plot,     &cmd_scenes,   &cmd_check};

enum { command_count = sizeof commands / sizeof commands[0] };

static void print_usage(FILE *file) {
    fprintf(file, "saltus %s: non-smooth dynamics of structures that hit rigid stops\n\n", SALTUS_VERSION);
    for (int k = 0; k < command_count; k++)
        fprintf(file, "  saltus %-9s %s\n", commands[k]->name, commands[k]->usage);
    fprintf(file, "\nSCENE is a YAML file or the name of a built-in scene (saltus scenes).\n"
                  "saltus COMMAND --help tells more.\n");
}

int main(int count, char **arguments) {
    if (count < 2) {
        print_usage(stderr);
        return CLI_BAD_INPUT;
    }
    const char *name = arguments[1];
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0 || strcmp(name, "help") == 0) {
        print_usage(stdout);
        return cli_finish();
    }
    if (strcmp(name, "--version") == 0) {
        printf("saltus %s\n", SALTUS_VERSION);
        return cli_finish();
    }
    for (int k = 0; k < command_count; k++) {
        cli_request request;
        if (strcmp(commands[k]->name, name) != 0)
            continue;
        if (!cli_parse(commands[k], count - 2, arguments + 2, &request))
            return CLI_BAD_INPUT;
        if (request.help) {
            cli_help(commands[k]);
            return cli_finish();
        }
        int code = commands[k]->run(&request), written = cli_finish();
        return code ? code : written;
    }
    fprintf(stderr, "saltus: %s: unknown command; saltus --help lists them\n", name);
    return CLI_BAD_INPUT;
}
