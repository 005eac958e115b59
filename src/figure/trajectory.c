/* A recorded trajectory as a figure: the phase portrait and the time history of a sheet, of all that there
 * is.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sheet.h"
#include "record/fields.h"
#include "record/rows.h"

#include <math.h>
#include <stdlib.h>

/* A trajectory's file with its system. */
typedef struct record {
    saltus_h5_reader h5;
    saltus_h5_head head;
    saltus_system *system;
    saltus_trajectory made;
} record;

enum { most_rows = 1000000000 };

/* One column of a table of samples, each of as many numbers as a state has where it is that. */
static saltus_status read_column(record *r, const char *group, const saltus_field *field, double **values,
                                 long long *count) {
    const int counts[SALTUS_COUNTS_MAX] = {[SALTUS_COUNT_DIMENSION] = r->made.dimension};
    const saltus_field_table table = {field, 1};
    const size_t entries = field->length ? (size_t)r->made.dimension : 1;
    void *read = NULL;
    saltus_status status =
        saltus_h5_get_all(&r->h5, group, &table, counts, most_rows, entries * sizeof **values, &read, count);
    *values = read;
    for (size_t k = 0; k < (size_t)*count * entries && status == SALTUS_OK; k++)
        if (!isfinite((*values)[k]))
            status = saltus_h5_refuse_part(&r->h5, group, field->name);
    return status;
}

static saltus_status read_samples(record *r) {
    saltus_trajectory *made = &r->made;
    double **const columns[] = {&made->time, &made->states, &made->displacement, &made->velocity};
    saltus_status status = SALTUS_OK;
    for (int k = 0; k < 4 && status == SALTUS_OK; k++) {
        const saltus_field *field = &saltus_sample_fields.fields[k];
        long long count = 0;
        status = read_column(r, "trajectory", field, columns[k], &count);
        if (status == SALTUS_OK && (count < 1 || (k > 0 && count != made->samples)))
            status = saltus_h5_refuse_part(&r->h5, "trajectory", field->name);
        made->samples = count;
    }
    return status;
}

/* The events, each with two rows of the samples. */
static saltus_status read_events(record *r) {
    void *rows = NULL;
    long long count = 0;
    saltus_status status = saltus_h5_get_all(&r->h5, "events", &saltus_trajectory_event_fields, NULL,
                                             most_rows, sizeof(saltus_event_row), &rows, &count);
    r->made.events = calloc((size_t)count + 1, sizeof *r->made.events);
    r->made.event_rows = calloc((size_t)count + 1, sizeof *r->made.event_rows);
    if (status == SALTUS_OK && !(r->made.events && r->made.event_rows))
        status =
            saltus_fail(r->h5.message, SALTUS_NO_MEMORY, "no memory for the events of %.300s", r->h5.path);
    for (long long k = 0; k < count && status == SALTUS_OK; k++) {
        const saltus_event_row *row = (const saltus_event_row *)rows + k;
        if (!saltus_event_of_row(r->system, row, &r->made.events[k]) ||
            row->row >= r->made.samples - (row->kind != SALTUS_RELEASE) ||
            row->row < (k ? r->made.event_rows[k - 1] : 0))
            status = saltus_h5_refuse_part(&r->h5, "events", "row");
        r->made.event_rows[k] = row->row;
        r->made.event_count++;
    }
    free(rows);
    return status;
}

static saltus_status read_record(record *r) {
    saltus_status status = saltus_h5_reader_open(&r->h5);
    if (status == SALTUS_OK)
        status = saltus_h5_get_head(&r->h5, "trajectory", "trajectory", &r->head);
    if (status == SALTUS_OK)
        status = saltus_system_new(&r->head.spec, &r->system, r->h5.message);
    if (status == SALTUS_OK) {
        r->made.dimension = saltus_system_dimension(r->system);
        status = read_samples(r);
    }
    if (status == SALTUS_OK)
        status = read_events(r);
    if (status == SALTUS_OK)
        status =
            read_column(r, "strobe", saltus_strobe_fields.fields, &r->made.strobe_states, &r->made.strobes);
    saltus_h5_reader_close(&r->h5);
    return status;
}

static void put_caption(const record *r, saltus_page *page) {
    saltus_line head = {.length = 0};
    saltus_line_plain(&head, r->head.scene);
    saltus_line_add(&head, ":  trajectory over %.6g %s", r->made.time[r->made.samples - 1] - r->made.time[0],
                    saltus_system_forced(r->system) ? "{/:Italic T}" : "units of time");
    saltus_page_scene(page, &head, r->head.title, r->system);
}

/* Side by side, or one above the other on a narrow page. */
static void put_page(const record *r, saltus_page *page) {
    saltus_sheet sheet = {.page = page, .system = r->system, .record = &r->made};
    const bool narrow = saltus_page_narrow(page);
    const int columns = narrow ? 1 : 2, rows = narrow ? 2 : 1;
    if (page->free_height)
        page->height = page->width * (narrow ? 1.5 : 0.5);
    saltus_sheet_choose_all(&sheet);
    put_caption(r, page);
    saltus_page_fit_caption(page);
    saltus_page_begin(page);
    saltus_sheet_record_data(&sheet);
    fputs("set multiplot\n", page->file);
    put_caption(r, page);
    saltus_sheet_portrait(&sheet, saltus_page_cell(page, 0, 1, columns, rows), 0);
    saltus_sheet_history(&sheet, saltus_page_cell(page, 1, 1, columns, rows), 1);
    fputs("unset multiplot\n", page->file);
}

saltus_status saltus_plot_trajectory(const char *figure, const char *path, const saltus_figure_options *look,
                                     saltus_message *message) {
    record r = {.h5 = {.path = path, .kind = "trajectory", .message = message}};
    saltus_page page;
    saltus_status status = saltus_figure_check(figure, look, message);
    if (status == SALTUS_OK)
        status = read_record(&r);
    if (status == SALTUS_OK)
        status = saltus_page_open(&page, figure, look, message);
    if (status == SALTUS_OK) {
        put_page(&r, &page);
        status = saltus_page_close(&page, SALTUS_OK, message);
    }
    saltus_system_free(r.system);
    saltus_trajectory_clear(&r.made);
    saltus_h5_head_clear(&r.head);
    return status;
}
