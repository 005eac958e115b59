/* Convergence of the largest exponent's estimate: a panel for any figure, a figure of its own, and a table.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sheet.h"

#include "record/describe.h"
#include "record/output.h"

#include <math.h>
#include <sys/stat.h>

void saltus_course_data(const saltus_page *page, const saltus_course *c) {
    fputs("$convergence << EOD\n# time exponent standard-error\n", page->file);
    for (int k = 0; k < c->count; k++)
        fprintf(page->file, "%.9g %.17g %.9g\n", c->history[k].time, c->history[k].exponent,
                c->history[k].standard_error);
    fputs("EOD\n", page->file);
}

/* The range of all estimates and of their error bands; at the beginning, where the bands may be wide, only of
 * the estimates. */
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

void saltus_course_panel(const saltus_page *page, const saltus_system *system, const saltus_course *c,
                         saltus_frame frame) {
    const double alike = 0.003;
    saltus_line result = {.length = 0}, time_name = {.length = 0};
    if (!isfinite(c->exponent) || c->count == 0) {
        saltus_page_frame(page, frame, SALTUS_PANEL_LEAST);
        if (c->exponent == -INFINITY)
            saltus_page_text(page, "Reason", "the largest exponent is −∞: every direction is %s",
                             saltus_lost_words(system));
        else
            saltus_page_text(page, "Reason", "too few values for an estimate");
        saltus_page_draw(page, "nothing");
        return;
    }
    saltus_range time = {c->history[0].time, c->history[c->count - 1].time};
    if (!(time.high > 1.2 * time.low))
        time = (saltus_range){time.low / 2, time.high * 2};
    saltus_range range = vertical_range(c, time);
    /* If all tics would show the same number, draw differences from the final value instead. */
    double origin = range.high - range.low < alike * fabs(c->exponent) ? c->exponent : 0;
    range = (saltus_range){range.low - origin, range.high - origin};
    /* The numbers of small exponents, or differences, are long. */
    double size = origin == 0 ? 0 : fmax(-range.low, range.high);
    for (int k = 0; k < c->count && origin == 0; k++)
        size = fmax(size, fabs(c->history[k].exponent) + c->history[k].standard_error);
    frame.left += size < 1e-3 ? 40 : 0;
    saltus_page_frame(page, frame, SALTUS_PANEL_LEAST);
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
    saltus_line_uncertain(&result, c->exponent, c->standard_error);
    saltus_page_text(page, "Result", "%s", result.text);
    saltus_page_text(page, "Small", ",%.4g", saltus_page_type(page, 11));
    saltus_page_text(page, "KeyPlace", "%s",
                     tight ? "-0.3, graph 1.02 left bottom vertical"
                           : "1, graph 1.02 right bottom horizontal");
    saltus_page_number(page, "Origin", origin);
    saltus_page_number(page, "Final", c->exponent - origin);
    saltus_page_number(page, "Low", range.low);
    saltus_page_number(page, "High", range.high);
    saltus_page_number(page, "Zero", origin == 0 && range.low < 0 && range.high > 0);
    saltus_page_number(page, "Points", c->count);
    saltus_page_draw(page, "convergence");
}

/* The result, how long and with how many trajectories it was measured, and possible doubts. */
static void put_caption(saltus_page *page, const saltus_scene *scene, const saltus_system *system,
                        const saltus_lyapunov *l, double precision) {
    const bool finite = isfinite(l->exponents[0]);
    saltus_line *head = saltus_page_scene(page, scene->title, system),
                *measurement = saltus_page_words(page, "#202020"),
                *doubt = saltus_page_words(page, "#c44e2a");
    saltus_line_plain(head, scene->name);
    saltus_line_add(head, ":  largest Lyapunov exponent  %s", finite ? "" : "−∞");
    if (finite) {
        const double exponent = l->exponents[0], error = l->standard_errors[0];
        saltus_line_uncertain(head, exponent, error);
        saltus_line_uncertain(measurement, exponent * l->period, error * l->period);
        saltus_line_number(measurement, " per period {/:Italic T} = %.6g;  ", l->period);
    }
    saltus_line_add(measurement, "%lld periods measured by %d trajector%s%s after a transient of %lld;  ",
                    l->periods, l->members, l->members == 1 ? "y" : "ies", l->members == 1 ? "" : " together",
                    l->transient);
    if (isfinite(l->impacts_per_period))
        saltus_line_number(measurement, "impacts per period: %.4g", l->impacts_per_period);
    else
        saltus_line_add(measurement, "complete chatter");
    if (l->interrupted)
        saltus_line_add(head, "  (interrupted)");
    if (!l->precise)
        saltus_line_number(doubt, "the precision asked for, %.3g %%, was not reached", 100 * precision);
    if (!l->agree)
        saltus_line_add(saltus_line_next(doubt),
                        "the trajectories do not agree: they do not measure the same motion");
}

saltus_status saltus_convergence_check(const char *path, saltus_message *message) {
    struct stat facts;
    if (saltus_figure_check(path, NULL, NULL) != SALTUS_OK && !saltus_path_ends(path, ".csv"))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.300s: the ending must be .png, .pdf, .svg or .csv",
                           path);
    if (stat(path, &facts) == 0 && !S_ISREG(facts.st_mode) && !S_ISDIR(facts.st_mode))
        return SALTUS_OK;
    return saltus_output_test(path, false, message);
}

saltus_status saltus_write_convergence(const char *path, const saltus_scene *scene,
                                       const saltus_system *system, const saltus_lyapunov_options *options,
                                       const saltus_lyapunov *lyapunov, const saltus_figure_options *look,
                                       saltus_message *message) {
    saltus_output output;
    saltus_page page;
    saltus_status status = saltus_convergence_check(path, message);
    if (status != SALTUS_OK)
        return status;
    const bool finite = isfinite(lyapunov->exponents[0]);
    if (!saltus_path_ends(path, ".csv")) {
        status = saltus_page_open(&page, path, look, message);
        if (status != SALTUS_OK)
            return status;
        const saltus_course course = {lyapunov->history, lyapunov->history_count, lyapunov->exponents[0],
                                      lyapunov->standard_errors[0]};
        put_caption(&page, scene, system, lyapunov, options->precision);
        saltus_page_begin(&page);
        saltus_course_data(&page, &course);
        saltus_page_caption(&page);
        saltus_course_panel(&page, system, &course,
                            saltus_page_rest(&page, saltus_page_narrow(&page) ? 76 : 36));
        return saltus_page_close(&page, SALTUS_OK, message);
    }
    status = saltus_output_open(&output, path, message);
    if (status != SALTUS_OK)
        return status;
    /* The rows of the history, below a header with their origin. */
    char a[SALTUS_NUMBER_MAX], b[SALTUS_NUMBER_MAX], c[SALTUS_NUMBER_MAX];
    FILE *file = output.file;
    saltus_put_table_head(file, "largest Lyapunov exponent", scene, NULL, saltus_system_spec(system));
    fprintf(file, "# options: transient = %lld, periods = %lld, members = %d, seed = %lu", options->transient,
            options->periods, options->members, options->seed);
    fprintf(file, ", precision = %s, interval = %s, ", saltus_number(options->precision, a),
            saltus_number(options->interval, b));
    saltus_put_tolerances(file, system, &options->flow);
    fprintf(file, ", order = %d\n", options->flow.order);
    if (lyapunov->interrupted)
        fputs("# complete: 0\n", file);
    if (finite)
        fprintf(file, "# result: exponent = %s, standard_error = %s\n",
                saltus_number(lyapunov->exponents[0], a),
                isfinite(lyapunov->standard_errors[0]) ? saltus_number(lyapunov->standard_errors[0], b)
                                                       : "unknown");
    else
        fputs("# result: exponent = -infinity: every direction is lost for good\n", file);
    fprintf(file, "# measured: %lld periods, trajectories: %d, transient: %lld periods, T = %s\n",
            lyapunov->periods, lyapunov->members, lyapunov->transient, saltus_number(lyapunov->period, a));
    fputs("# time: measured by all trajectories together\n"
          "# exponent, standard_error: the estimate after that time, per unit of time\n"
          "time,exponent,standard_error\n",
          file);
    for (int k = 0; k < lyapunov->history_count && finite; k++)
        fprintf(file, "%s,%s,%s\n", saltus_number(lyapunov->history[k].time, a),
                saltus_number(lyapunov->history[k].exponent, b),
                saltus_number(lyapunov->history[k].standard_error, c));
    return saltus_output_close(&output, SALTUS_OK, message);
}
