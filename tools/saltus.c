/* saltus: the command line. Every subcommand is a thin filter around the library.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"
#include "interrupt.h"
#include "ranks.h"

#include <fcntl.h>
#include <string.h>
#include <unistd.h>

static const cli_command *const commands[] = {
    &cmd_classify, &cmd_diagnose, &cmd_simulate, &cmd_orbit,  &cmd_continue, &cmd_lyapunov, &cmd_spectrum,
    &cmd_sweep,    &cmd_basins,   &cmd_plot,     &cmd_export, &cmd_paper,    &cmd_scenes,   &cmd_check};

enum { command_count = sizeof commands / sizeof commands[0] };

static void print_usage(FILE *file) {
    fprintf(file, "saltus %s: non-smooth dynamics of structures that hit rigid stops\n\n", SALTUS_VERSION);
    for (int k = 0; k < command_count; k++)
        fprintf(file, "  saltus %-9s %s\n", commands[k]->name, commands[k]->usage);
    fprintf(file, "\nSCENE is a YAML file, the name of a built-in scene (saltus scenes), or - for standard input.\n"
                  "saltus COMMAND --help tells more.\n"
                  "Exit status: 0 done, 1 not completed or interrupted (stderr says why), 2 bad input.\n");
}

static int run_command(const cli_command *command, int count, char **arguments) {
    cli_request request;
    if (!cli_parse(command, count, arguments, &request))
        return CLI_BAD_INPUT;
    if (request.help) {
        cli_help(command);
        return cli_finish();
    }
    int code = cli_run(command, &request), written = cli_finish();
    return code ? code : written;
}

/* A standard stream that is closed must not be taken by the first file that is opened. What is put in its
 * place can be neither read nor written as it should be, so that this is noticed. */
static void fill_streams(void) {
    static const int modes[] = {
        [STDIN_FILENO] = O_WRONLY, [STDOUT_FILENO] = O_RDONLY, [STDERR_FILENO] = O_RDONLY};
    for (int k = STDIN_FILENO; k <= STDERR_FILENO; k++)
        if (fcntl(k, F_GETFD) < 0 && open("/dev/null", modes[k]) != k)
            _exit(CLI_FAILED);
}

int main(int count, char **arguments) {
    fill_streams();
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
        if (strcmp(commands[k]->name, name) != 0)
            continue;
        int code = CLI_FAILED;
        interrupt_catch();
        if (!commands[k]->together || ranks_join())
            code = run_command(commands[k], count - 2, arguments + 2);
        ranks_leave();
        return code;
    }
    fprintf(stderr, "saltus: %s: unknown command; saltus --help lists them\n", name);
    return CLI_BAD_INPUT;
}
