/* Bifurcation diagrams: branches of orbits and curves of special points, drawn by gnuplot from a script that
 * holds its own data.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/branch.h"

#include "figure/caption.h"
#include "figure/gnuplot.h"
#include "record/describe.h"
#include "record/hdf5.h"
#include "record/output.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void name_measure(const saltus_plot_page *page, saltus_line *line) {
    char name[160];
    switch (page->show) {
    case SALTUS_SHOW_DISPLACEMENT:
        saltus_observed_name(page->system, false, name, sizeof name);
        saltus_line_add(line, "%s  at phase 0", name);
        break;
    case SALTUS_SHOW_VELOCITY:
        saltus_observed_name(page->system, true, name, sizeof name);
        saltus_line_add(line, "%s  at phase 0", name);
        break;
    case SALTUS_SHOW_PERIOD:
        saltus_line_add(line, "period in {/:Italic T}");
        break;
    case SALTUS_SHOW_IMPACTS:
        saltus_line_add(line, "speed of every impact  |{/:Bold n·q′}|");
        break;
    default:
        saltus_line_add(line, "largest impact speed  |{/:Bold n·q′}|");
    }
}

static void put_axes(const saltus_plot_page *page) {
    const saltus_branch_options *o = &page->files[0].options;
    const saltus_spec *spec = &page->files[0].spec;
    saltus_line x = {.length = 0}, y = {.length = 0};
    saltus_line_parameter(&x, spec, o->key[0]);
    if (page->locus)
        saltus_line_parameter(&y, spec, o->key[1]);
    else
        name_measure(page, &y);
    fprintf(page->file, "set xlabel '%s'\nset xrange [%.12g:%.12g]\n", x.text, page->x.low, page->x.high);
    fprintf(page->file, "set ylabel '%s' offset -0.6,0\nset yrange [%.9g:%.9g]\n", y.text, page->y.low,
            page->y.high);
}

/* The parameters that all files share, and those of the first where they do not. */
static void add_parameters(const saltus_plot_page *page, saltus_line *line) {
    const saltus_branch_options *o = &page->files[0].options;
    char first[SALTUS_KEY_MAX], second[SALTUS_KEY_MAX];
    saltus_plot_difference(page, 0, first);
    saltus_plot_difference(page, 1, second);
    const char *const varied[2] = {o->key[0], page->locus ? o->key[1] : *first ? first : NULL};
    saltus_line_parameters(line, page->system, varied);
    if (page->locus ? *first : *second)
        saltus_line_add(line, ", where nothing else is said");
}

static void put_caption(const saltus_plot_page *page) {
    const saltus_branch_options *o = &page->files[0].options;
    saltus_line head = {.length = 0}, parameters = {.length = 0};
    double height = 0.932;
    saltus_line_plain(&head, page->files[0].scene);
    saltus_line_add(&head, ":  %s in ", page->locus ? "special points" : "periodic orbits");
    saltus_line_symbol(&head, o->key[0]);
    if (page->locus) {
        saltus_line_add(&head, " and ");
        saltus_line_symbol(&head, o->key[1]);
    }
    add_parameters(page, &parameters);
    fprintf(page->file, "set label '{/=20:Bold %s}' at screen 0.03,0.967 left front\n", head.text);
    saltus_line_put(page->file, &parameters, "#202020", &height);
    saltus_put_version(page->file);
    bool long_names = page->locus || page->count > 1;
    int columns = long_names ? 5 : 8, rows = (saltus_plot_legend_entries(page) + columns - 1) / columns;
    fprintf(page->file,
            "set tmargin at screen %.4f\n"
            "set key at screen 0.03, screen %.4f left top horizontal Left reverse samplen 1.8 width 1 "
            "maxrows %d font ',11' textcolor rgb '#303030'\n",
            height - 0.026 - 0.024 * rows, height + 0.008, rows);
}

static void write_script(const saltus_plot_page *page, const char *path) {
    fprintf(page->file, "set terminal %s\n", saltus_gnuplot_terminal(path));
    saltus_put_style(page->file, "eeeeee");
    fputs("set lmargin at screen 0.09\nset rmargin at screen 0.973\nset bmargin at screen 0.078\n",
          page->file);
    saltus_plot_data(page);
    put_axes(page);
    put_caption(page);
    saltus_plot_labels(page);
    fputs("plot \\\n", page->file);
    saltus_plot_curves(page);
    saltus_plot_marks(page);
    saltus_plot_legend(page);
}

/* Where nothing was asked for: impact speeds where there are impacts, displacements otherwise. */
static saltus_show choose_measure(const saltus_plot_page *page, saltus_show wanted) {
    if (wanted != SALTUS_SHOW_AUTOMATIC)
        return wanted;
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k < page->files[i].point_count; k++)
            if (page->files[i].points[k].event_count > 0)
                return SALTUS_SHOW_SPEED;
    return SALTUS_SHOW_DISPLACEMENT;
}

/* The part of a parameter's range that was asked for; false where none was. */
static bool asked_for(const saltus_plot_page *page, int axis, saltus_range *range) {
    const char *key = page->files[0].options.key[axis];
    for (int k = 0; k < page->options->part_count; k++) {
        const saltus_plot_part *part = &page->options->parts[k];
        if (strcmp(part->key, key) == 0) {
            *range = (saltus_range){part->low, part->high};
            return true;
        }
    }
    return false;
}

/* The range of an axis, from the points that are in the range asked for of the other axis. */
static saltus_range find_range(const saltus_plot_page *page, int axis) {
    saltus_range found = {INFINITY, -INFINITY};
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k < page->files[i].point_count; k++) {
            const saltus_branch_point *point = &page->files[i].points[k];
            if (!saltus_plot_shown(page, point))
                continue;
            saltus_range_add(&found, axis ? saltus_plot_y(page, point) : saltus_plot_x(point));
            bool every_impact = axis && page->show == SALTUS_SHOW_IMPACTS && !page->locus;
            for (int e = 0; e < point->event_count && every_impact; e++)
                saltus_range_add(&found, saltus_impact_speed(&point->events[e]));
        }
    return found;
}

static void find_ranges(saltus_plot_page *page) {
    const saltus_branch_options *o = &page->files[0].options;
    bool speeds = !page->locus && (page->show == SALTUS_SHOW_SPEED || page->show == SALTUS_SHOW_IMPACTS);
    page->x = page->y = (saltus_range){-INFINITY, INFINITY};
    bool part[2] = {asked_for(page, 0, &page->x), page->locus && asked_for(page, 1, &page->y)};
    if (!part[0]) {
        page->x = find_range(page, 0);
        saltus_range_pad(&page->x, 0.03, 1e-3 * (o->high[0] - o->low[0]));
    }
    if (part[1])
        return;
    page->y = find_range(page, 1);
    if (speeds && page->y.low < 0.4 * page->y.high)
        saltus_range_add(&page->y, 0);
    saltus_range_pad(&page->y, 0.07,
                     page->locus ? 1e-3 * (o->high[1] - o->low[1])
                                 : 1e-3 * fmax(fabs(page->y.high), fabs(page->y.low)));
    if (speeds && page->y.low < 0)
        page->y.low = -0.02 * page->y.high;
}

static saltus_status check_points(const saltus_plot_page *page, saltus_message *message) {
    const saltus_branch_options *o = &page->files[0].options;
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k < page->files[i].point_count; k++)
            if (saltus_plot_shown(page, &page->files[i].points[k]))
                return SALTUS_OK;
    if (page->locus)
        return saltus_fail(message, SALTUS_BAD_INPUT, "there is no point from %s = %g to %g, %s = %g to %g",
                           o->key[0], page->x.low, page->x.high, o->key[1], page->y.low, page->y.high);
    return saltus_fail(message, SALTUS_BAD_INPUT, "there is no point from %s = %g to %g", o->key[0],
                       page->x.low, page->x.high);
}

static saltus_status draw(const saltus_branch_file *files, int count, const saltus_plot_options *options,
                          const char *figure, saltus_message *message) {
    saltus_system *system = NULL;
    saltus_status status = saltus_system_new(&files[0].spec, &system, message);
    if (status != SALTUS_OK)
        return status;
    saltus_plot_page page = {.files = files,
                             .count = count,
                             .system = system,
                             .options = options,
                             .locus = files[0].options.locus != SALTUS_POINT_REGULAR};
    page.show = choose_measure(&page, options->show);
    find_ranges(&page);
    status = check_points(&page, message);
    if (status == SALTUS_OK)
        status = saltus_gnuplot_open(&page.file, message);
    if (status == SALTUS_OK) {
        write_script(&page, figure);
        status = saltus_gnuplot_draw(page.file, figure, message);
    }
    saltus_system_free(system);
    return status;
}

saltus_plot_options saltus_plot_defaults(void) {
    return (saltus_plot_options){.show = SALTUS_SHOW_AUTOMATIC};
}

static bool is_axis(const saltus_branch_options *o, const char *key) {
    return strcmp(key, o->key[0]) == 0 || (o->key[1][0] && strcmp(key, o->key[1]) == 0);
}

/* Exchange the two parameters of a curve of special points. */
static void turn_axes(saltus_branch_file *file) {
    saltus_branch_options *o = &file->options;
    char key[SALTUS_KEY_MAX];
    double low = o->low[0], high = o->high[0];
    memcpy(key, o->key[0], sizeof key);
    memcpy(o->key[0], o->key[1], sizeof key);
    memcpy(o->key[1], key, sizeof key);
    o->low[0] = o->low[1];
    o->high[0] = o->high[1];
    o->low[1] = low;
    o->high[1] = high;
    for (int k = 0; k < file->point_count; k++) {
        double *value = file->points[k].value, first = value[0];
        value[0] = value[1];
        value[1] = first;
    }
}

/* Diagrams over each other need the same axes. */
static saltus_status match_axes(const saltus_branch_file *a, saltus_branch_file *b, const char *path,
                                saltus_message *message) {
    const saltus_branch_options *o = &a->options, *p = &b->options;
    bool locus = o->locus != SALTUS_POINT_REGULAR, same = is_axis(o, p->key[0]);
    if (!saltus_model_same(a->spec.model, b->spec.model) || a->dimension != b->dimension ||
        a->spec.stop_count != b->spec.stop_count)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: is of another structure than the first file (model, N or stops differ)",
                           path);
    if (locus != (p->locus != SALTUS_POINT_REGULAR) || !same || (locus && !is_axis(o, p->key[1])))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: has the axes %s%s%s, the first file %s%s%s",
                           path, p->key[0], *p->key[1] ? " and " : "", p->key[1], o->key[0],
                           *o->key[1] ? " and " : "", o->key[1]);
    if (strcmp(o->key[0], p->key[0]) != 0)
        turn_axes(b);
    return SALTUS_OK;
}

/* Whether what the options say of parameters is of parameters that the figure shows. */
static saltus_status check_options(const saltus_branch_file *file, const saltus_plot_options *options,
                                   saltus_message *message) {
    const saltus_branch_options *o = &file->options;
    for (int k = 0; k < options->part_count; k++)
        if (!is_axis(o, options->parts[k].key))
            return saltus_fail(message, SALTUS_BAD_INPUT, "%s=%g:%g: the figure shows %s%s%s",
                               options->parts[k].key, options->parts[k].low, options->parts[k].high,
                               o->key[0], *o->key[1] ? " and " : "", o->key[1]);
    for (int k = 0; k < options->label_count; k++) {
        const saltus_plot_label *label = &options->labels[k];
        if (!is_axis(o, label->key[0]) || !is_axis(o, label->key[1]) ||
            strcmp(label->key[0], label->key[1]) == 0)
            return saltus_fail(
                message, SALTUS_BAD_INPUT,
                "label %.60s: its place must be in two parameters that the figure shows; it shows "
                "%s%s%s",
                label->text, o->key[0], *o->key[1] ? " and " : "", o->key[1]);
    }
    return SALTUS_OK;
}

/* Whether a file is of a sweep; what else is wrong with it is left to its reader. */
static bool is_sweep(const char *path) {
    saltus_h5_reader reader = {.path = path};
    char kind[32] = "";
    bool known = saltus_h5_reader_open(&reader) == SALTUS_OK &&
                 saltus_h5_get_text(reader.file, "kind", kind, sizeof kind);
    saltus_h5_reader_close(&reader);
    return known && (strcmp(kind, "sweep") == 0 || strcmp(kind, "basins") == 0);
}

/* Draw a sweep where the first file is one; *drawn tells. */
static saltus_status draw_sweep(const char *const *paths, int count, const saltus_plot_options *options,
                                const char *figure, bool *drawn, saltus_message *message) {
    saltus_sweep_view view = {.parts = options->parts, .part_count = options->part_count};
    *drawn = is_sweep(paths[0]);
    if (!*drawn)
        return SALTUS_OK;
    if (count > 1)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: is a sweep, which is drawn alone or with branches", paths[0]);
    if (options->show != SALTUS_SHOW_AUTOMATIC || options->label_count)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: is a sweep; what is shown of it is chosen as a view", paths[0]);
    return saltus_plot_sweep(paths[0], &view, figure, message);
}

saltus_status saltus_plot(const char *const *paths, int count, const saltus_plot_options *options,
                          const char *figure, saltus_message *message) {
    saltus_status status = SALTUS_OK;
    int read = 0;
    if (!saltus_gnuplot_terminal(figure))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .png, .pdf or .svg", figure);
    if (count < 1)
        return saltus_fail(message, SALTUS_BAD_INPUT, "there is no file to draw");
    bool sweep;
    status = draw_sweep(paths, count, options, figure, &sweep, message);
    if (sweep)
        return status;
    saltus_branch_file *files = calloc((size_t)count, sizeof *files);
    if (!files)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for %d branch files", count);
    for (; read < count && status == SALTUS_OK; read++) {
        status = saltus_branch_file_read(paths[read], &files[read], message);
        if (status == SALTUS_OK)
            status = match_axes(&files[0], &files[read], paths[read], message);
    }
    if (status == SALTUS_OK)
        status = check_options(&files[0], options, message);
    if (status == SALTUS_OK)
        status = draw(files, count, options, figure, message);
    for (int k = 0; k < read; k++)
        saltus_branch_file_clear(&files[k]);
    free(files);
    return status;
}
