/* How the largest exponent's estimate converged: a panel for any figure.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/convergence.h"

#include "record/describe.h"
#include "record/lyapunov_words.h"

#include <math.h>

saltus_course saltus_lyapunov_course(const saltus_lyapunov *l) {
    return (saltus_course){l->history, l->history_count, l->exponents[0], l->standard_errors[0]};
}

void saltus_course_data(const saltus_page *page, const saltus_course *c) {
    fputs("$convergence << EOD\n# time exponent standard-error\n", page->file);
    for (int k = 0; k < c->count; k++)
        fprintf(page->file, "%.9g %.17g %.9g\n", c->history[k].time, c->history[k].exponent,
                c->history[k].standard_error);
    fputs("EOD\n", page->file);
}

/* The range of all estimates, and of their error band except at the beginning, where it may be wide. */
static saltus_range vertical_range(const saltus_course *c, saltus_range time) {
    const double begin = 0.2;
    double from = time.low * pow(time.high / time.low, begin);
    saltus_range range = {c->exponent, c->exponent};
    for (int k = 0; k < c->count; k++) {
        double error = c->history[k].time < from ? 0 : c->history[k].standard_error;
        saltus_range_add(&range, c->history[k].exponent - error);
        saltus_range_add(&range, c->history[k].exponent + error);
    }
    double width = fmax(range.high - range.low, 1e-12 * fabs(c->exponent) + 1e-15);
    return (saltus_range){range.low - 0.08 * width, range.high + 0.08 * width};
}

/* Where there is no course to draw, say why. */
static void put_reason(const saltus_page *page, const saltus_system *system, const saltus_course *c) {
    saltus_line reason = {.length = 0};
    if (c->exponent == -INFINITY)
        saltus_line_add(&reason, "the largest exponent is −∞: every direction is %s",
                        saltus_lost_words(system));
    else
        saltus_line_add(&reason, "too few values for an estimate");
    saltus_page_text(page, "Reason", reason.text);
    saltus_page_template(page, "nothing");
    saltus_page_template(page, "close");
}

void saltus_course_panel(const saltus_page *page, const saltus_system *system, const saltus_course *c,
                         saltus_frame frame) {
    const double alike = 0.003;
    saltus_line result = {.length = 0}, time_name = {.length = 0};
    saltus_page_frame(page, frame);
    if (!isfinite(c->exponent) || c->count == 0) {
        put_reason(page, system, c);
        return;
    }
    saltus_range time = {c->history[0].time, c->history[c->count - 1].time};
    if (!(time.high > 1.2 * time.low))
        time = (saltus_range){time.low / 2, time.high * 2};
    saltus_range range = vertical_range(c, time);
    /* Values that differ so little that all tics would show the same number are drawn less the final one. */
    double origin = range.high - range.low < alike * fabs(c->exponent) ? c->exponent : 0;
    range = (saltus_range){range.low - origin, range.high - origin};
    bool narrow = frame.right - frame.left < 600, tight = frame.right - frame.left < 200;
    saltus_line_add(&time_name, "time {/:Italic %s}%s", saltus_notation_of(system)->time,
                    narrow ? " measured" : " measured, all trajectories together");
    saltus_page_axis(page, "x", frame, true, time_name.text, time);
    saltus_page_axis(page, "y", frame, false,
                     origin == 0 ? (tight ? "largest exponent" : "largest Lyapunov exponent")
                     : tight     ? "exponent − final value"
                                 : "largest Lyapunov exponent − final value",
                     range);
    saltus_line_add(&result, tight ? "" : "final value ");
    saltus_line_uncertain(&result, saltus_uncertain_text(c->exponent, c->standard_error));
    saltus_page_text(page, "Result", result.text);
    saltus_page_text(page, "KeyPlace",
                     tight ? "-0.3, graph 1.02 left bottom vertical"
                           : "1, graph 1.02 right bottom horizontal");
    saltus_page_number(page, "Origin", origin);
    saltus_page_number(page, "Final", c->exponent - origin);
    saltus_page_number(page, "Low", range.low);
    saltus_page_number(page, "High", range.high);
    saltus_page_number(page, "Zero", origin == 0 && range.low < 0 && range.high > 0);
    saltus_page_number(page, "Points", c->count);
    saltus_page_template(page, "convergence");
    saltus_page_template(page, "close");
}
