/* Progress on terminals of all widths: the share done is shown even where little else fits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define _GNU_SOURCE /* pseudo-terminals */
#include "command.h"

#include <fcntl.h>
#include <regex.h>
#include <sys/ioctl.h>

/* All that a command writes to stderr on a terminal of a width. */
static char *shown(const fixture *f, const char *line, int columns) {
    char command[1200], *text = calloc(1, 1 << 20);
    size_t length = 0;
    ssize_t part;
    int terminal = posix_openpt(O_RDWR | O_NOCTTY);
    struct winsize size = {.ws_col = (unsigned short)columns, .ws_row = 24};
    assert_non_null(text);
    assert_true(terminal >= 0 && grantpt(terminal) == 0 && unlockpt(terminal) == 0);
    int other = open(ptsname(terminal), O_RDWR | O_NOCTTY);
    assert_int_equal(ioctl(other, TIOCSWINSZ, &size), 0);
    snprintf(command, sizeof command, "cd %s && exec %s %s >out", f->folder, SALTUS_COMMAND, line);
    pid_t child = fork();
    if (child == 0) {
        dup2(other, STDERR_FILENO);
        execl("/bin/sh", "sh", "-c", command, (char *)NULL);
        _exit(127);
    }
    close(other);
    while (length + 1 < 1 << 20 && (part = read(terminal, text + length, (1 << 20) - 1 - length)) > 0)
        length += (size_t)part;
    int outcome;
    waitpid(child, &outcome, 0);
    close(terminal);
    assert_true(WIFEXITED(outcome) && WEXITSTATUS(outcome) == 0);
    return text;
}

/* Each line is shorter than the terminal's width and begins with a count, a share, or the value that a
 * parameter has reached. */
static void share_comes_first(void **state) {
    static const struct {
        const char *line, *form;
    } cases[] = {
        {"classify budd-dux --transient 2000 --measure 16000", "^[0-9]+ % of at most [0-9]+"},
        {"lyapunov budd-dux --periods 10000", "^[0-9]+ % of at most [0-9]+"},
        {"classify impact-pair --seeds 5", "^[0-9]+ of 5 seeds done"},
        {"simulate duffing --periods 3000 -o x.csv --force", "^[0-9]+ of 3000 periods"},
        {"continue impact-oscillator --in omega=0.9:1.1 -o x.h5 --force",
         "^([0-9]+ % of at most|omega = [0-9.]+  branch|omega=[0-9.]+ step [0-9]+) [0-9]"},
        {"orbit duffing --periods 2 --unstable --search 500", "^searching: +[0-9]+ %"},
        {"sweep impact-oscillator --over omega=0.9:1.1:400 -o x.csv --force", "^(\\[.*\\] *)?[0-9.]+ %"},
    };
    fixture *f = *state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++)
        for (int columns = 30; columns <= 300; columns *= 10) {
            char *text = shown(f, cases[k].line, columns), *rest = text;
            int lines = 0;
            regex_t form;
            assert_int_equal(regcomp(&form, cases[k].form, REG_EXTENDED | REG_NOSUB), 0);
            for (char *line = strsep(&rest, "\r"); line; line = strsep(&rest, "\r")) {
                char *end = strstr(line, "\033[K");
                if (end)
                    *end = '\0';
                if (!end || !line[0] || strncmp(line, "settling", 8) == 0 || strstr(line, "writing ..."))
                    continue;
                if (regexec(&form, line, 0, NULL, 0) != 0 || strlen(line) >= (size_t)columns)
                    fail_msg("%s: %d columns: '%s'", cases[k].line, columns, line);
                lines++;
            }
            regfree(&form);
            if (lines == 0 && strncmp(cases[k].line, "sweep", 5) != 0)
                fail_msg("%s: nothing was shown", cases[k].line);
            free(text);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(share_comes_first, open_fixture, close_fixture)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
