/* How the largest exponent's estimate converged: the figure and the file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "io/gnuplot.h"
#include "io/lyapunov_plot.h"
#include "io/lyapunov_words.h"
#include "io/output.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>

static void put_style(FILE *file) {
    fputs("set encoding utf8\n"
          "set border 3 lc rgb '#606060' lw 1\n"
          "set tics out nomirror scale 0.6 tc rgb '#303030'\n"
          "set grid lt 1 lc rgb '#eeeeee' lw 1 back\n"
          "set minussign\n",
          file);
}

/* What it rests on, and what is wrong with it. */
static void add_measurement(saltus_line *line, saltus_line *doubt, const saltus_convergence *c) {
    const saltus_lyapunov *l = c->lyapunov;
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
        saltus_line_add(doubt, "the precision asked for, %.3g %%, was not reached",
                        100 * c->options->precision);
    if (!l->agree)
        saltus_line_add(doubt, "%sthe trajectories do not agree: they do not measure the same motion",
                        doubt->length ? ";  " : "");
}

/* The lower edge of the caption. */
static double put_caption(FILE *file, const saltus_convergence *c) {
    const saltus_lyapunov *l = c->lyapunov;
    saltus_line head = {.length = 0}, title = {.length = 0}, parameters = {.length = 0},
                measurement = {.length = 0}, doubt = {.length = 0};
    double height = 0.932;
    saltus_line_plain(&head, c->scene->name);
    saltus_line_add(&head, ":  largest Lyapunov exponent  ");
    if (isfinite(l->exponents[0]))
        saltus_line_uncertain(&head, saltus_uncertain_text(l->exponents[0], l->standard_errors[0]));
    else
        saltus_line_add(&head, "−∞");
    saltus_line_plain(&title, c->scene->title);
    saltus_line_parameters(&parameters, c->system, (const char *const[2]){NULL, NULL});
    add_measurement(&measurement, &doubt, c);
    fprintf(file, "set label '{/=20:Bold %s}' at screen 0.03,0.967 left front\n", head.text);
    saltus_line_put(file, &title, "#606060", &height);
    saltus_line_put(file, &parameters, "#202020", &height);
    saltus_line_put(file, &measurement, "#202020", &height);
    saltus_line_put(file, &doubt, "#c44e2a", &height);
    saltus_put_version(file);
    return height;
}

static saltus_status draw(const saltus_convergence *c, const char *path, saltus_message *message) {
    FILE *file = saltus_nameless_file();
    if (!file)
        return saltus_fail(message, SALTUS_IO, "no temporary file can be made: %s", strerror(errno));
    fprintf(file, "set terminal %s\n", saltus_gnuplot_terminal(path));
    saltus_course course = saltus_lyapunov_course(c->lyapunov);
    saltus_course_data(file, &course);
    put_style(file);
    double top = put_caption(file, c);
    const double across[2] = {0.09, 0.973}, up[2] = {0.078, top - 0.03};
    saltus_course_panel(file, c->system, &course, across, up);
    saltus_status status = saltus_gnuplot_draw(file, path, message);
    fclose(file);
    return status;
}

saltus_status saltus_convergence_check(const char *path, saltus_message *message) {
    struct stat facts;
    if (!saltus_gnuplot_terminal(path) && !saltus_path_ends(path, ".csv"))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.300s: the ending must be .png, .pdf, .svg or .csv",
                           path);
    if (stat(path, &facts) == 0 && !S_ISREG(facts.st_mode) && !S_ISDIR(facts.st_mode))
        return SALTUS_OK;
    saltus_output output;
    saltus_status status = saltus_output_open(&output, path, message);
    if (status != SALTUS_OK)
        return status;
    /* Only to see whether it can be done: what was begun is thrown away. */
    saltus_output_close(&output, SALTUS_IO, NULL);
    return SALTUS_OK;
}

saltus_status saltus_write_convergence(const saltus_scene *scene, const saltus_system *system,
                                       const saltus_lyapunov_options *options,
                                       const saltus_lyapunov *lyapunov, const char *path,
                                       saltus_message *message) {
    const saltus_convergence convergence = {scene, system, options, lyapunov};
    saltus_output output;
    saltus_status status = saltus_convergence_check(path, message);
    if (status != SALTUS_OK || !saltus_path_ends(path, ".csv"))
        return status == SALTUS_OK ? draw(&convergence, path, message) : status;
    status = saltus_output_open(&output, path, message);
    if (status != SALTUS_OK)
        return status;
    saltus_convergence_csv(&convergence, output.file);
    return saltus_output_close(&output, SALTUS_OK, message);
}
