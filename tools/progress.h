/* Progress of a long computation on stderr: a bar on a terminal, occasional lines elsewhere.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_TOOLS_PROGRESS_H
#define SALTUS_TOOLS_PROGRESS_H

#include <stdbool.h>

typedef struct progress {
    bool shown, terminal;
    long long total;     /* points */
    double looked, told; /* times, in seconds, of the last measurement of the rate and of the last output */
    long long seen, told_done;
    double work, time; /* weighted points and seconds; their quotient is the rate */
} progress;

/* On a terminal, replace the last line by this one. The line is cut between words to the terminal's width, so
 * it should begin with what matters most. An empty line erases it. */
__attribute__((format(printf, 1, 2))) void progress_line(const char *format, ...);

/* Width of the terminal on stderr; 1000 if unknown. */
int progress_columns(void);

/* `earlier`: points that are there at the beginning. */
void progress_begin(progress *p, bool quiet, long long total, long long earlier);
/* Report that `done` points are finished, if an update is due. */
void progress_show(progress *p, long long done);
/* Erase the bar; if `text` is given, show it until the next update. */
void progress_wipe(const progress *p, const char *text);

#endif
