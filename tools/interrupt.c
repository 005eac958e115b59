/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "interrupt.h"

#include "cli.h"

#include <stddef.h>
#include <time.h>
#include <unistd.h>

static volatile sig_atomic_t asked;
static struct timespec since; /* of the first request; written and read by the handler alone */
static const char *volatile cleared[INTERRUPT_CLEARED];

/* A request may arrive twice, sent to the process and to its group; only a later signal ends the program. */
static void ask(int number) {
    const double patience = 0.5; /* seconds */
    struct timespec now = since;
    clock_gettime(CLOCK_MONOTONIC, &now);
    if (!asked)
        since = now;
    else if ((double)(now.tv_sec - since.tv_sec) + 1e-9 * (double)(now.tv_nsec - since.tv_nsec) >= patience) {
        for (int k = 0; k < INTERRUPT_CLEARED; k++)
            if (cleared[k] && unlink(cleared[k]) != 0)
                rmdir(cleared[k]);
        signal(number, SIG_DFL);
        raise(number);
    }
    asked = number;
}

void interrupt_clears(const char *const paths[INTERRUPT_CLEARED]) {
    for (int k = 0; k < INTERRUPT_CLEARED; k++)
        cleared[k] = paths ? paths[k] : NULL;
}

void interrupt_catch(void) {
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
    /* A file beyond the user's size limit is an ordinary write error. */
    signal(SIGXFSZ, SIG_IGN);
    sigset_t heard;
    sigemptyset(&heard);
    for (size_t k = 0; k < sizeof signals / sizeof signals[0]; k++) {
        struct sigaction now, wanted = {.sa_handler = ask, .sa_flags = SA_RESTART};
        sigemptyset(&wanted.sa_mask); /* one handler at a time */
        for (size_t other = 0; other < sizeof signals / sizeof signals[0]; other++)
            sigaddset(&wanted.sa_mask, signals[other]);
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
