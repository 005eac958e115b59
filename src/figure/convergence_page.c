/* How the estimate of the largest exponent converged, as a figure and as a table.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/convergence.h"
#include "record/describe.h"
#include "record/lyapunov_words.h"
#include "record/output.h"

#include <math.h>
#include <sys/stat.h>

static void put_options(FILE *file, const saltus_system *system, const saltus_lyapunov_options *o) {
    char a[SALTUS_NUMBER_MAX], b[SALTUS_NUMBER_MAX];
    fprintf(file, "# options: transient = %lld, periods = %lld, members = %d, seed = %lu", o->transient,
            o->periods, o->members, o->seed);
    fprintf(file, ", precision = %s, interval = %s", saltus_number(o->precision, a),
            saltus_number(o->interval, b));
    fprintf(file, ", rtol = %s, atol = %s, integrator = %s (%s), order = %d\n",
            saltus_number(o->flow.rtol, a), saltus_number(o->flow.atol, b),
            saltus_integrator_word(o->flow.integrator), saltus_integrator_used(system, o->flow.integrator),
            o->flow.order);
}

static void put_result(FILE *file, const saltus_lyapunov *l) {
    char a[SALTUS_NUMBER_MAX], b[SALTUS_NUMBER_MAX];
    bool known = isfinite(l->standard_errors[0]);
    if (isfinite(l->exponents[0]))
        fprintf(file, "# result: exponent = %s, standard_error = %s\n", saltus_number(l->exponents[0], a),
                known ? saltus_number(l->standard_errors[0], b) : "unknown");
    else
        fputs("# result: exponent = -infinity: every direction is lost for good\n", file);
    fprintf(file, "# measured: %lld periods, trajectories: %d, transient: %lld periods, T = %s\n", l->periods,
            l->members, l->transient, saltus_number(l->period, a));
    fputs("# time: measured by all trajectories together\n"
          "# exponent, standard_error: the estimate after that time, per unit of time\n"
          "time,exponent,standard_error\n",
          file);
}

/* The rows of the history below a header that says what they belong to. */
static void put_table(FILE *file, const saltus_scene *scene, const saltus_system *system,
                      const saltus_lyapunov_options *options, const saltus_lyapunov *l) {
    saltus_put_table_head(file, "largest Lyapunov exponent", scene, NULL, saltus_system_spec(system));
    put_options(file, system, options);
    put_result(file, l);
    for (int k = 0; k < l->history_count && isfinite(l->exponents[0]); k++) {
        char a[SALTUS_NUMBER_MAX], b[SALTUS_NUMBER_MAX], c[SALTUS_NUMBER_MAX];
        fprintf(file, "%s,%s,%s\n", saltus_number(l->history[k].time, a),
                saltus_number(l->history[k].exponent, b), saltus_number(l->history[k].standard_error, c));
    }
}

/* How long and by how many trajectories the exponent was measured, and what casts doubt on it. */
static void add_measurement(saltus_line *line, saltus_line *doubt, const saltus_lyapunov *l,
                            double precision) {
    if (isfinite(l->exponents[0])) {
        saltus_uncertain number =
            saltus_uncertain_text(l->exponents[0] * l->period, l->standard_errors[0] * l->period);
        saltus_line_uncertain(line, number);
        saltus_line_add(line, " per period {/:Italic T} = %.6g;  ", l->period);
    }
    saltus_line_add(line,
                    "%lld periods measured by %d trajector%s%s after a transient of %lld;  impacts per "
                    "period: %.4g",
                    l->periods, l->members, l->members == 1 ? "y" : "ies", l->members == 1 ? "" : " together",
                    l->transient, l->impacts_per_period);
    if (!l->precise)
        saltus_line_add(doubt, "the precision asked for, %.3g %%, was not reached", 100 * precision);
    if (!l->agree)
        saltus_line_add(doubt, "%sthe trajectories do not agree: they do not measure the same motion",
                        doubt->length ? ";  " : "");
}

static void put_caption(saltus_page *page, const saltus_scene *scene, const saltus_system *system,
                        const saltus_lyapunov *l, double precision) {
    saltus_line head = {.length = 0}, measurement = {.length = 0}, doubt = {.length = 0};
    saltus_line_plain(&head, scene->name);
    saltus_line_add(&head, ":  largest Lyapunov exponent  ");
    if (isfinite(l->exponents[0]))
        saltus_line_uncertain(&head, saltus_uncertain_text(l->exponents[0], l->standard_errors[0]));
    else
        saltus_line_add(&head, "−∞");
    add_measurement(&measurement, &doubt, l, precision);
    saltus_page_scene(page, &head, scene->title, system);
    saltus_page_words(page, &measurement, "#202020");
    saltus_page_words(page, &doubt, "#c44e2a");
}

static void put_figure(saltus_page *page, const saltus_scene *scene, const saltus_system *system,
                       const saltus_lyapunov *l, double precision) {
    saltus_course course = saltus_lyapunov_course(l);
    put_caption(page, scene, system, l, precision);
    saltus_page_fit_caption(page);
    saltus_page_begin(page);
    saltus_course_data(page, &course);
    put_caption(page, scene, system, l, precision);
    saltus_course_panel(page, system, &course, saltus_page_rest(page, saltus_page_narrow(page) ? 76 : 36));
}

saltus_status saltus_convergence_check(const char *path, saltus_message *message) {
    struct stat facts;
    if (saltus_figure_check(path, NULL, NULL) != SALTUS_OK && !saltus_path_ends(path, ".csv"))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.300s: the ending must be .png, .pdf, .svg or .csv",
                           path);
    if (stat(path, &facts) == 0 && !S_ISREG(facts.st_mode) && !S_ISDIR(facts.st_mode))
        return SALTUS_OK;
    return saltus_output_test(path, message);
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
    if (!saltus_path_ends(path, ".csv")) {
        status = saltus_page_open(&page, path, look, message);
        if (status != SALTUS_OK)
            return status;
        put_figure(&page, scene, system, lyapunov, options->precision);
        return saltus_page_close(&page, SALTUS_OK, message);
    }
    status = saltus_output_open(&output, path, message);
    if (status != SALTUS_OK)
        return status;
    put_table(output.file, scene, system, options, lyapunov);
    return saltus_output_close(&output, SALTUS_OK, message);
}
