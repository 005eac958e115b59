/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "progress.h"

#include "base/progress.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

/* Seconds: between updates of the bar; least and largest between lines; averaging time of the rate. */
static const double bar_pause = 0.25, line_pause = 2, line_patience = 30, memory = 15;

void progress_begin(progress *p, bool quiet, long long total, long long earlier) {
    double now = saltus_seconds();
    *p = (progress){.shown = !quiet,
                    .terminal = isatty(STDERR_FILENO) == 1,
                    .total = total,
                    .looked = now,
                    .told = now,
                    .seen = earlier,
                    .told_done = earlier};
}

int progress_columns(void) {
    struct winsize size;
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 1000;
}

void progress_line(const char *format, ...) {
    char text[512];
    int room = progress_columns() - 1;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    /* Cut between words. */
    if (strlen(text) > (size_t)room)
        for (int k = room; k > 0; k--)
            if (text[k] == ' ') {
                text[k] = '\0';
                break;
            }
    fprintf(stderr, "\r%.*s\033[K", room, text);
    fflush(stderr);
}

void progress_show(progress *p, long long done) {
    enum { cells = 30, beside = 50 };
    const double now = saltus_seconds(), passed = now - p->looked, fade = exp(-passed / memory);
    if (!p->shown || passed < bar_pause)
        return;
    /* Recent points per second: older ones are weighted less and less. */
    p->work = p->work * fade + (double)(done - p->seen);
    p->time = p->time * fade + passed;
    p->seen = done;
    p->looked = now;
    const double rate = p->time > 0 ? p->work / p->time : 0,
                 part = p->total > 0 ? (double)done / (double)p->total : 1;
    const double seconds = rate > 0 ? (double)(p->total - done) / rate : INFINITY;
    char left[48] = "time left unknown", bar[cells + 1] = "";
    if (seconds < 100)
        snprintf(left, sizeof left, "%.0f s left", ceil(seconds));
    else if (seconds < 6000)
        snprintf(left, sizeof left, "%.0f min left", ceil(seconds / 60));
    else if (seconds < 1e6)
        snprintf(left, sizeof left, "%.1f h left", seconds / 3600);
    for (int k = 0; k < cells; k++)
        bar[k] = part * cells >= k + 1 ? '#' : '.';
    /* If the bar does not fit, show only the percentage and the remaining time. */
    if (p->terminal && progress_columns() > cells + beside)
        progress_line("[%s] %5.1f %%  %.4g points/s  %s", bar, 100 * part, rate, left);
    else if (p->terminal)
        progress_line("%.1f %%, %s", 100 * part, left);
    const bool further = 10 * (done - p->told_done) >= p->total;
    if (p->terminal || now - p->told < (further ? line_pause : line_patience))
        return;
    fprintf(stderr, "saltus: %.1f %% (%lld of %lld points), %.4g points/s, %s\n", 100 * part, done, p->total,
            rate, left);
    p->told = now;
    p->told_done = done;
}

void progress_wipe(const progress *p, const char *text) {
    if (!p->shown || !p->terminal)
        return;
    progress_line("%s", text ? text : "");
}
