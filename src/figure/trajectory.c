/* A recorded trajectory as a figure: phase portrait with stroboscopic points, and time history.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/gnuplot.h"
#include "record/rows.h"
#include "saltus/figure.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What is drawn: samples in the order of time, of the observed displacement and its rate. */
typedef struct record {
    long long rows;
    double *time, *displacement, *velocity;
} record;

static saltus_status read_record(const char *path, record *made, saltus_message *message) {
    saltus_h5_reader r = {.path = path, .kind = "trajectory", .message = message};
    saltus_h5_head head;
    const char *const names[] = {"time", "displacement", "velocity"};
    double **const columns[] = {&made->time, &made->displacement, &made->velocity};
    *made = (record){.rows = 0};
    saltus_status status = saltus_h5_reader_open(&r);
    if (status == SALTUS_OK)
        status = saltus_h5_get_head(&r, "trajectory", "trajectory", &head);
    if (status == SALTUS_OK)
        saltus_h5_head_clear(&head);
    for (int k = 0; k < 3 && status == SALTUS_OK; k++) {
        int count = 0;
        status = saltus_h5_get_reals(&r, "trajectory", names[k], INT_MAX, true, &count, columns[k]);
        if (status == SALTUS_OK && (count < 1 || (k > 0 && count != made->rows)))
            status = saltus_h5_refuse_part(&r, "trajectory", names[k]);
        made->rows = count;
    }
    saltus_h5_reader_close(&r);
    return status;
}

static void put_script(FILE *script, const record *r, const char *figure) {
    static const double left[2] = {0.09, 0.46}, right[2] = {0.56, 0.97}, up[2] = {0.12, 0.88};
    fprintf(script, "set terminal %s\n", saltus_gnuplot_terminal(figure));
    saltus_put_style(script, "e0e0e0");
    fputs("$samples << EOD\n", script);
    for (long long k = 0; k < r->rows; k++)
        fprintf(script, "%.17g %.9g %.9g %d\n", r->time[k], r->displacement[k], r->velocity[k],
                r->time[k] == floor(r->time[k]));
    fputs("EOD\nset multiplot\n", script);
    saltus_put_margins(script, left, up);
    fputs("set xlabel 'displacement'\nset ylabel 'velocity'\n"
          "plot $samples using 2:3 with lines lc rgb '#1f4e79', "
          "$samples using 2:($4 == 1 ? $3 : NaN) with points pt 7 ps 0.8 lc rgb '#c0392b'\n",
          script);
    saltus_put_margins(script, right, up);
    fputs("set xlabel 'time / T'\nset ylabel 'displacement'\n"
          "plot $samples using 1:2 with lines lc rgb '#1f4e79', "
          "$samples using 1:($4 == 1 ? $2 : NaN) with points pt 7 ps 0.8 lc rgb '#c0392b'\n"
          "unset multiplot\n",
          script);
}

saltus_status saltus_plot_trajectory(const char *path, const char *figure, saltus_message *message) {
    record r;
    FILE *script;
    if (!saltus_gnuplot_terminal(figure))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .png, .pdf or .svg", figure);
    saltus_status status = read_record(path, &r, message);
    if (status == SALTUS_OK)
        status = saltus_gnuplot_open(&script, message);
    if (status == SALTUS_OK) {
        put_script(script, &r, figure);
        status = saltus_gnuplot_draw(script, figure, message);
    }
    free(r.time);
    free(r.displacement);
    free(r.velocity);
    return status;
}
