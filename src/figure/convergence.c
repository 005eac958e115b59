/* How the largest exponent's estimate converged: a panel for any figure.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/convergence.h"

#include "figure/caption.h"
#include "figure/gnuplot.h"
#include "record/describe.h"
#include "record/lyapunov_words.h"

#include <math.h>

#define TRACE "#2c5f8a"
#define BAND "#d3dfe9"
#define FINAL "#c44e2a"
#define ZERO "#707070"

/* A course of fewer points than this gets a mark at each: a single point would not be seen as a line. */
enum { few_points = 30, first_tag = 9000 };

saltus_course saltus_lyapunov_course(const saltus_lyapunov *l) {
    return (saltus_course){l->history, l->history_count, l->exponents[0], l->standard_errors[0]};
}

void saltus_course_data(FILE *file, const saltus_course *c) {
    fputs("$convergence << EOD\n# time exponent standard-error\n", file);
    for (int k = 0; k < c->count; k++)
        fprintf(file, "%.9g %.17g %.9g\n", c->history[k].time, c->history[k].exponent,
                c->history[k].standard_error);
    fputs("EOD\n", file);
}

/* Tics at 1, 2 and 5 times powers of ten, at powers of ten alone where there are many. */
static void put_time_tics(FILE *file, saltus_range range) {
    static const double parts[] = {1, 2, 5};
    const char *separator = "";
    if (range.high > 3000 * range.low) {
        fputs("set xtics auto\nset format x '10^{%T}'\n", file);
        return;
    }
    fputs("set xtics (", file);
    for (double decade = pow(10, floor(log10(range.low))); decade <= range.high; decade *= 10)
        for (int k = 0; k < 3; k++)
            if (parts[k] * decade >= range.low && parts[k] * decade <= range.high) {
                fprintf(file, "%s'%.6g' %.9g", separator, parts[k] * decade, parts[k] * decade);
                separator = ", ";
            }
    fputs(")\n", file);
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

/* What is subtracted from the values drawn: the final value where they differ so little that all tics would
 * show the same number, otherwise 0. */
static double choose_origin(FILE *file, const saltus_course *c, saltus_range *range) {
    const double alike = 0.003;
    double origin = range->high - range->low < alike * fabs(c->exponent) ? c->exponent : 0;
    fprintf(file, "set ylabel 'largest Lyapunov exponent%s' offset -0.6,0\n",
            origin == 0 ? "" : " − final value");
    *range = (saltus_range){range->low - origin, range->high - origin};
    fprintf(file, "set yrange [%.9g:%.9g]\n", range->low, range->high);
    return origin;
}

/* Lines across the panel: at zero where it is an exponent in the range, and at the final value. */
static void put_levels(FILE *file, double final, double origin, saltus_range range) {
    if (origin == 0 && range.low < 0 && range.high > 0)
        fprintf(file,
                "set arrow %d from graph 0, first 0 to graph 1, first 0 nohead front lc rgb '" ZERO
                "' lw 1.4\n",
                first_tag);
    fprintf(file,
            "set arrow %d from graph 0, first %.12g to graph 1, first %.12g nohead front lc rgb '" FINAL
            "' dt (12,9) lw 1.6\n",
            first_tag + 1, final - origin, final - origin);
}

/* Where there is no course to draw, say why. */
static void put_reason(FILE *file, const saltus_system *system, const saltus_course *c) {
    bool lost = c->exponent == -INFINITY;
    fputs("set xlabel ''\nset ylabel ''\nset xrange [0:1]\nset yrange [0:1]\nunset xtics\nunset ytics\n",
          file);
    fprintf(file, "set label %d '%s%s' at graph 0.5, graph 0.5 center front tc rgb '#303030'\n", first_tag,
            lost ? "the largest exponent is −∞: every direction is " : "too few values for an estimate",
            lost ? saltus_lost_words(system) : "");
    fprintf(file, "plot NaN notitle\nunset label %d\nset xtics auto\nset ytics auto\n", first_tag);
}

/* The band is cut off at the panel's edges by hand: gnuplot lets filled areas run out of a panel at its left.
 */
static void put_band(FILE *file, double origin, saltus_range range) {
    fprintf(file, "cut(x) = x < %.9g ? %.9g : x > %.9g ? %.9g : x\n", range.low, range.low, range.high,
            range.high);
    fprintf(
        file,
        "plot $convergence using 1:(cut($2 - (%.17g) - $3)):(cut($2 - (%.17g) + $3)) with filledcurves fc "
        "rgb '" BAND "' fs solid noborder title '± standard error', \\\n",
        origin, origin);
}

static void put_curves(FILE *file, const saltus_course *c, double origin, saltus_range range) {
    saltus_line value = {.length = 0};
    saltus_line_uncertain(&value, saltus_uncertain_text(c->exponent, c->standard_error));
    fputs("set key at graph 1, graph 1.02 right bottom horizontal Left reverse samplen 1.8 width -1 font "
          "',11' textcolor rgb '#303030'\n",
          file);
    put_band(file, origin, range);
    fprintf(file,
            "     $convergence using 1:($2 - (%.17g)) with lines lw 2 lc rgb '" TRACE
            "' title 'estimate', \\\n",
            origin);
    if (c->count < few_points)
        fprintf(file,
                "     $convergence using 1:($2 - (%.17g))%s pt 7 ps 0.8 lw 1.4 lc rgb '" TRACE
                "' notitle, \\\n",
                origin, c->count == 1 ? ":3 with yerrorbars" : " with points");
    fprintf(file, "     NaN with lines dt (12,9) lw 1.6 lc rgb '" FINAL "' title 'final value %s'\n",
            value.text);
}

void saltus_course_panel(FILE *file, const saltus_system *system, const saltus_course *c,
                         const double across[2], const double up[2]) {
    saltus_put_margins(file, across, up);
    if (!isfinite(c->exponent) || c->count == 0) {
        put_reason(file, system, c);
        return;
    }
    saltus_range time = {c->history[0].time, c->history[c->count - 1].time};
    if (!(time.high > 1.2 * time.low))
        time = (saltus_range){time.low / 2, time.high * 2};
    saltus_range exponent = vertical_range(c, time);
    fprintf(file,
            "set logscale x\nset xlabel 'time {/:Italic %s} measured, all trajectories together'\n"
            "set xrange [%.9g:%.9g]\n",
            saltus_notation_of(system)->time, time.low, time.high);
    put_time_tics(file, time);
    double origin = choose_origin(file, c, &exponent);
    put_levels(file, c->exponent, origin, exponent);
    put_curves(file, c, origin, exponent);
    fprintf(file, "unset arrow %d\nunset logscale x\nset format x '%% h'\nset xtics auto\nset key off\n",
            first_tag + 1);
    if (origin == 0 && exponent.low < 0 && exponent.high > 0)
        fprintf(file, "unset arrow %d\n", first_tag);
}
