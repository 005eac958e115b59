/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "progress.h"

#include "base/progress.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

/* Seconds between two drawings of the bar; between two lines, at least and at most; after which the rate
 * forgets. */
static const double bar_pause = 0.25, line_pause = 2, line_patience = 30, memory = 15;

void progress_begin(progress *p, bool quiet, long long total, long long earlier) {
    double now = saltus_seconds();
    *p = (progress){.shown = !quiet,
                    .terminal = isatty(STDERR_FILENO) == 1,
                    .total = total,
                    .earlier = earlier,
                    .begin = now,
                    .looked = now,
                    .told = now,
                    .seen = earlier,
                    .told_done = earlier};
}

/* Points per second of late: what was long ago counts less and less. */
static double measure(progress *p, long long done, double now) {
    double passed = now - p->looked, fade = exp(-passed / memory);
    p->work = p->work * fade + (double)(done - p->seen);
    p->time = p->time * fade + passed;
    p->seen = done;
    p->looked = now;
    return p->time > 0 ? p->work / p->time : 0;
}

static void describe_left(const progress *p, long long done, double rate, char text[48]) {
    double left = rate > 0 ? (double)(p->total - done) / rate : INFINITY;
    if (left < 100)
        snprintf(text, 48, "%.0f s left", ceil(left));
    else if (left < 6000)
        snprintf(text, 48, "%.0f min left", ceil(left / 60));
    else if (left < 1e6)
        snprintf(text, 48, "%.1f h left", left / 3600);
    else
        snprintf(text, 48, "time left unknown");
}

/* Columns of the terminal that stderr is; many where it does not say. */
static int columns(void) {
    struct winsize size;
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 1000;
}

void progress_line(const char *format, ...) {
    char text[512];
    int room = columns() - 1;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    fprintf(stderr, "\r%.*s\033[K", room, text);
    fflush(stderr);
}

/* Where there is no room for the bar and all the numbers, the numbers that are waited for. */
static void draw_bar(double part, double rate, const char *left) {
    enum { cells = 30, beside = 50 };
    char bar[cells + 1];
    for (int k = 0; k < cells; k++)
        bar[k] = part * cells >= k + 1 ? '#' : '.';
    bar[cells] = '\0';
    if (columns() > cells + beside)
        progress_line("[%s] %5.1f %%  %.4g points/s  %s", bar, 100 * part, rate, left);
    else
        progress_line("%.1f %%, %s", 100 * part, left);
}

void progress_show(progress *p, long long done) {
    double now = saltus_seconds();
    if (!p->shown || now - p->looked < bar_pause)
        return;
    double rate = measure(p, done, now), part = p->total > 0 ? (double)done / (double)p->total : 1;
    char left[48];
    describe_left(p, done, rate, left);
    if (p->terminal) {
        draw_bar(part, rate, left);
        return;
    }
    bool further = 10 * (done - p->told_done) >= p->total;
    if (now - p->told < (further ? line_pause : line_patience))
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
