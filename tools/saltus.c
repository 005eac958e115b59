/* saltus: the command line. Every subcommand is a thin filter around the library.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cli.h"
#include "interrupt.h"
#include "manual.h"
#include "ranks.h"

#include <fcntl.h>
#include <string.h>
#include <unistd.h>

static const cli_command *find_command(const char *name) {
    int k = 0;
    while (manual_commands[k] && strcmp(manual_commands[k]->name, name) != 0)
        k++;
    if (!manual_commands[k])
        fprintf(stderr, "saltus: %s: unknown command; saltus --help lists them\n", name);
    return manual_commands[k];
}

/* saltus help [COMMAND] [--man]; the build also uses help --pages FOLDER and help --completion, and the
 * completion help --keys COMMAND OPTION SCENE. */
static int help(int count, char **arguments) {
    const char *first = count ? arguments[0] : "", *last = count ? arguments[count - 1] : "";
    bool as_page = strcmp(last, "--man") == 0;
    if (strcmp(first, "--pages") == 0 && count == 2)
        return manual_write(last);
    if (strcmp(first, "--keys") == 0 && count == 4)
        return manual_keys(arguments[1], arguments[2], last, stdout);
    if (count > 1 + as_page)
        return cli_refuse(CLI_BAD_INPUT, "help: %s: unexpected; saltus help COMMAND tells about one",
                          arguments[1]);
    const cli_command *command = NULL;
    const manual_topic *topic = count > as_page ? manual_find_topic(first) : NULL;
    if (strcmp(first, "--completion") == 0)
        manual_completion(stdout);
    else if (topic)
        (as_page ? manual_topic_page : manual_topic_help)(topic, stdout);
    else if (count > as_page && !(command = find_command(first)))
        return CLI_BAD_INPUT;
    else if (as_page)
        manual_page(command, stdout);
    else if (command)
        manual_help(command, stdout);
    else
        manual_list(stdout);
    return cli_finish();
}

int main(int count, char **arguments) {
    /* If a standard stream is closed, the first file opened would take its place. Occupy it with /dev/null
     * opened in the wrong direction, so that using the stream fails and is noticed. */
    static const int modes[] = {
        [STDIN_FILENO] = O_WRONLY, [STDOUT_FILENO] = O_RDONLY, [STDERR_FILENO] = O_RDONLY};
    for (int k = STDIN_FILENO; k <= STDERR_FILENO; k++)
        if (fcntl(k, F_GETFD) < 0 && open("/dev/null", modes[k]) != k)
            _exit(CLI_FAILED);
    if (count < 2) {
        manual_list(stderr);
        return CLI_BAD_INPUT;
    }
    const char *name = arguments[1];
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0 || strcmp(name, "help") == 0)
        return help(count - 2, arguments + 2);
    if (strcmp(name, "--version") == 0 || strcmp(name, "-V") == 0) {
        printf("saltus %s\n", SALTUS_VERSION);
        return cli_finish();
    }
    const cli_command *command = find_command(name);
    if (!command)
        return CLI_BAD_INPUT;
    cli_request request;
    int code = CLI_FAILED;
    interrupt_catch();
    if (!command->together || ranks_join()) {
        code = cli_parse(command, count - 2, (const char *const *)arguments + 2, &request) ? CLI_DONE
                                                                                           : CLI_BAD_INPUT;
        if (code == CLI_DONE && request.help)
            manual_help(command, stdout);
        else if (code == CLI_DONE)
            code = cli_run(command, &request);
        int written = cli_finish();
        code = code ? code : written;
    }
    ranks_leave();
    return code;
}
