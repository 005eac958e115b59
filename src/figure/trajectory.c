/* A recorded trajectory as a figure: phase portrait with stroboscopic points, and time history.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/page.h"
#include "record/describe.h"
#include "record/rows.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

/* What is drawn: samples in the order of time, of the observed displacement and its rate. */
typedef struct record {
    saltus_h5_head head;
    long long rows;
    double *time, *displacement, *velocity;
} record;

static saltus_status read_record(const char *path, record *made, saltus_message *message) {
    saltus_h5_reader r = {.path = path, .kind = "trajectory", .message = message};
    const char *const names[] = {"time", "displacement", "velocity"};
    double **const columns[] = {&made->time, &made->displacement, &made->velocity};
    *made = (record){.rows = 0};
    saltus_status status = saltus_h5_reader_open(&r);
    if (status == SALTUS_OK)
        status = saltus_h5_get_head(&r, "trajectory", "trajectory", &made->head);
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

/* One block serves both panels; a second one holds the points where a forcing period begins. */
static void put_data(const record *r, FILE *file) {
    fputs("$orbit << EOD\n", file);
    for (long long k = 0; k < r->rows; k++)
        fprintf(file, "%.17g %.9g %.9g\n", r->time[k], r->displacement[k], r->velocity[k]);
    fputs("EOD\n$strobe << EOD\n", file);
    for (long long k = 0; k < r->rows; k++)
        if (r->time[k] == floor(r->time[k]))
            fprintf(file, "%.9g %.9g %.17g\n", r->displacement[k], r->velocity[k], r->time[k]);
    fputs("EOD\n", file);
}

static void put_caption(const record *r, const saltus_system *system, saltus_page *page) {
    saltus_line head = {.length = 0}, title = {.length = 0}, parameters = {.length = 0};
    saltus_line_plain(&head, r->head.scene);
    saltus_line_add(&head, ":  trajectory over %.6g {/:Italic T}", r->time[r->rows - 1] - r->time[0]);
    saltus_line_plain(&title, r->head.title);
    saltus_line_parameters(&parameters, system, (const char *const[2]){NULL, NULL});
    saltus_page_heading(page, &head);
    saltus_page_words(page, &title, "#606060");
    saltus_page_words(page, &parameters, "#202020");
}

static void put_page(const record *r, const saltus_system *system, saltus_page *page) {
    enum { few = 50 }; /* periods whose curve and dots are still told apart, drawn in full strength */
    saltus_range time = {r->time[0], r->time[r->rows - 1]}, x = {INFINITY, -INFINITY}, v = x;
    const double *scale = saltus_system_scale(system);
    char displacement[160], velocity[160], elapsed[64];
    bool stacked = page->width < 1000;
    if (page->free_height)
        page->height = page->width * (stacked ? 1.5 : 0.5);
    for (long long k = 0; k < r->rows; k++) {
        saltus_range_add(&x, r->displacement[k]);
        saltus_range_add(&v, r->velocity[k]);
    }
    saltus_range_pad(&time, 0, 1);
    saltus_range_pad(&x, 0.06, scale[0]);
    saltus_range_pad(&v, 0.06, scale[saltus_system_dof(system)]);
    saltus_observed_name(system, false, displacement, sizeof displacement);
    saltus_observed_name(system, true, velocity, sizeof velocity);
    snprintf(elapsed, sizeof elapsed, "time {/:Italic %s}/{/:Italic T}", saltus_notation_of(system)->time);

    put_caption(r, system, page);
    saltus_page_fit_caption(page);
    saltus_page_begin(page);
    put_data(r, page->file);
    fputs("set multiplot\n", page->file);
    put_caption(r, system, page);
    saltus_page_number(page, "Orbit", time.high - time.low <= few);
    saltus_page_number(page, "Impacts", 0);
    saltus_page_number(page, "Settled", time.high - time.low <= few);
    int columns = stacked ? 1 : 2, rows = stacked ? 2 : 1;
    saltus_page_panel(page, saltus_page_cell(page, 0, 1, columns, rows), 0,
                      "phase portrait, dots where a period of the forcing begins");
    saltus_page_axis(page, 'x', displacement, x);
    saltus_page_axis(page, 'y', velocity, v);
    saltus_page_template(page, "portrait");
    saltus_page_template(page, "close");
    saltus_page_panel(page, saltus_page_cell(page, 1, 1, columns, rows), 1, "time history");
    saltus_page_axis(page, 'x', elapsed, time);
    saltus_page_axis(page, 'y', displacement, x);
    saltus_page_template(page, "trajectory");
    fputs("unset multiplot\n", page->file);
}

saltus_status saltus_plot_trajectory(const char *figure, const char *path, const saltus_figure_options *look,
                                     saltus_message *message) {
    record r = {.rows = 0};
    saltus_page page;
    saltus_system *system = NULL;
    saltus_status status = saltus_figure_check(figure, look, message);
    if (status == SALTUS_OK)
        status = read_record(path, &r, message);
    if (status == SALTUS_OK)
        status = saltus_system_new(&r.head.spec, &system, message);
    if (status == SALTUS_OK)
        status = saltus_page_open(&page, figure, look, message);
    if (status == SALTUS_OK) {
        put_page(&r, system, &page);
        status = saltus_page_close(&page, SALTUS_OK, message);
    }
    saltus_system_free(system);
    free(r.time);
    free(r.displacement);
    free(r.velocity);
    saltus_h5_head_clear(&r.head);
    return status;
}
