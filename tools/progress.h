/* How far a long computation has come, on stderr: a bar on a terminal, a line now and then elsewhere.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_PROGRESS_H
#define SALTUS_TOOLS_PROGRESS_H

#include <stdbool.h>

typedef struct progress {
    bool shown, terminal;
    long long total, earlier; /* points, and how many of them were there at the begin */
    double begin;             /* seconds; so are the others */
    double looked, told;      /* when the rate was last measured, when something was last written */
    long long seen, told_done;
    double work, time; /* points and seconds of late; their quotient is the rate */
} progress;

/* Put one line in place of the last one, where stderr is a terminal: what comes first counts most, as the
 * line is cut to the terminal's width. An empty one wipes. */
__attribute__((format(printf, 1, 2))) void progress_line(const char *format, ...);

void progress_begin(progress *p, bool quiet, long long total, long long earlier);
/* Tell that `done` points are there, if it is time to. */
void progress_show(progress *p, long long done);
/* Wipe the bar; with a text, put that in its place until the next. */
void progress_wipe(const progress *p, const char *text);

#endif
