/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "interrupt.h"

#include "cli.h"

#include <stddef.h>
#include <time.h>

static volatile sig_atomic_t asked;
static volatile time_t since;

/* A request may arrive twice, sent to the process and to its group; only a later signal ends the program. */
static void ask(int number) {
    enum { patience = 2 };
    if (!asked)
        since = time(NULL);
    else if (time(NULL) - since >= patience) {
        signal(number, SIG_DFL);
        raise(number);
    }
    asked = number;
}

void interrupt_catch(void) {
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
    /* A file beyond the user's size limit is an ordinary write error. */
    signal(SIGXFSZ, SIG_IGN);
    sigset_t heard;
    sigemptyset(&heard);
    for (size_t k = 0; k < sizeof signals / sizeof signals[0]; k++) {
        struct sigaction now, wanted = {.sa_handler = ask, .sa_flags = SA_RESTART};
        sigemptyset(&wanted.sa_mask);
        if (sigaction(signals[k], NULL, &now) == 0 && now.sa_handler != SIG_IGN)
            sigaction(signals[k], &wanted, NULL);
        sigaddset(&heard, signals[k]);
    }
    sigprocmask(SIG_UNBLOCK, &heard, NULL);
}

const volatile sig_atomic_t *interrupt_flag(void) {
    return &asked;
}

bool interrupt_asked(void) {
    return asked != 0;
}

int interrupt_report(const char *what) {
    return cli_refuse(CLI_FAILED, "interrupted; %s", what);
}
