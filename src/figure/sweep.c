/* Figures of sweeps: diagrams over one axis, maps over two, basins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep.h"

#include "figure/gnuplot.h"
#include "record/describe.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Whether a file holds the cloud of a view. */
static bool holds(const saltus_sweep_file *sweep, saltus_view view) {
    switch (view) {
    case SALTUS_VIEW_TURNING:
        return (sweep->options.keep & SALTUS_KEEP_TURNING) && sweep->turning_count;
    case SALTUS_VIEW_IMPACTS:
        return (sweep->options.keep & SALTUS_KEEP_IMPACTS) && sweep->impact_count;
    case SALTUS_VIEW_STROBOSCOPIC:
        return (sweep->options.keep & SALTUS_KEEP_STROBOSCOPIC) && sweep->strobe_count;
    default:
        return view != SALTUS_VIEW_LYAPUNOV || (sweep->options.keep & SALTUS_KEEP_LYAPUNOV);
    }
}

static saltus_view choose_view(const saltus_sweep_file *sweep, saltus_view wanted) {
    if (wanted != SALTUS_VIEW_AUTOMATIC)
        return wanted;
    if (sweep->axis_count > 1)
        return sweep->basins && sweep->complete ? SALTUS_VIEW_ATTRACTORS : SALTUS_VIEW_CLASS;
    saltus_view view = SALTUS_VIEW_TURNING;
    while (saltus_view_is_cloud(view) && !holds(sweep, view))
        view++;
    return saltus_view_is_cloud(view) ? view : SALTUS_VIEW_LARGEST;
}

/* Whether the file holds what the view needs. */
static saltus_status check_view(const saltus_sweep_page *page, saltus_message *message) {
    const saltus_sweep_file *sweep = page->sweep;
    const char *word = saltus_view_word(page->view);
    if (saltus_view_is_cloud(page->view) && sweep->axis_count > 1)
        return saltus_fail(
            message, SALTUS_BAD_INPUT,
            "%.200s: view %s is over one axis, the file has two (%s and %s): class, attractors, "
            "largest, speed, rate, contact, lyapunov and settled are maps",
            page->path, word, sweep->axes[0].key, sweep->axes[1].key);
    if (!holds(sweep, page->view))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: holds no data for view %s: the sweep was run "
                           "without --what %s",
                           page->path, word, word);
    if (page->view == SALTUS_VIEW_ATTRACTORS && sweep->basins && !sweep->complete)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: is not complete, and attractors are told apart at the end: view class "
                           "shows what there is",
                           page->path);
    return SALTUS_OK;
}

/* What was asked for of a key's range; NULL where nothing was. */
static const saltus_plot_part *part_of(const saltus_sweep_page *page, const char *key) {
    for (int k = 0; k < page->wish->part_count; k++)
        if (strcmp(page->wish->parts[k].key, key) == 0)
            return &page->wish->parts[k];
    return NULL;
}

static saltus_status check_parts(const saltus_sweep_page *page, saltus_message *message) {
    const saltus_axis *axes = page->sweep->axes;
    bool two = page->sweep->axis_count > 1;
    for (int k = 0; k < page->wish->part_count; k++) {
        const char *key = page->wish->parts[k].key;
        if (strcmp(key, axes[0].key) != 0 && !(two && strcmp(key, axes[1].key) == 0) &&
            strcmp(key, saltus_view_word(page->view)) != 0)
            return saltus_fail(
                message, SALTUS_BAD_INPUT, "%.200s: range of %s: the figure shows %s%s%s and %s", page->path,
                key, axes[0].key, two ? ", " : "", two ? axes[1].key : "", saltus_view_word(page->view));
    }
    return SALTUS_OK;
}

/* Restrict an axis to what was asked for. */
static saltus_status cut_axis(const saltus_sweep_page *page, saltus_cells *cells, saltus_message *message) {
    const saltus_plot_part *part = part_of(page, cells->key);
    double low = cells->range.low, high = cells->range.high;
    int axis = cells == &page->y;
    const double *list = page->sweep->axes[axis].list;
    if (part && (part->low >= high || part->high <= low))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: there is nothing from %s = %g to %g: the sweep "
                           "goes from %.6g to %.6g",
                           page->path, cells->key, part->low, part->high, list[cells->order[0]],
                           list[cells->order[cells->count - 1]]);
    if (part && cells->logarithmic && part->low <= 0)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: range of %s: the axis is logarithmic, its range must be positive",
                           page->path, cells->key);
    if (part)
        cells->range = (saltus_range){part->low, part->high};
    return SALTUS_OK;
}

static saltus_status open_axes(saltus_sweep_page *page, saltus_message *message) {
    const saltus_axis *axes = page->sweep->axes;
    if (!saltus_cells_open(&page->x, &axes[0]) ||
        (page->sweep->axis_count > 1 && !saltus_cells_open(&page->y, &axes[1])) ||
        !saltus_classes_open(&page->classes, page->sweep))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for drawing %.200s", page->path);
    saltus_status status = cut_axis(page, &page->x, message);
    if (status == SALTUS_OK && page->sweep->axis_count > 1)
        status = cut_axis(page, &page->y, message);
    const saltus_plot_part *part = part_of(page, saltus_view_word(page->view));
    page->asked = part != NULL;
    if (part)
        page->up = (saltus_range){part->low, part->high};
    return status;
}

/* The displacement that is observed, which depends on the place of the stop. */
static saltus_status open_observers(saltus_sweep_page *page, saltus_message *message) {
    const saltus_axis *axis = &page->sweep->axes[0];
    bool moves = strncmp(axis->key, "xi", 2) == 0;
    int n = saltus_system_dof(page->system), count = moves ? axis->count : 1;
    saltus_direction direction;
    double value = 0;
    saltus_status status = SALTUS_OK;
    page->observers = calloc((size_t)count * (size_t)n, sizeof *page->observers);
    page->observer_count = count;
    if (!page->observers)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for drawing %.200s", page->path);
    if (moves)
        status = saltus_spec_direction(&page->sweep->spec, axis->key, &direction, &value, message);
    for (int k = 0; k < count && status == SALTUS_OK; k++) {
        saltus_spec spec = page->sweep->spec;
        saltus_system *system = NULL;
        if (moves)
            spec = saltus_spec_shifted(&spec, &direction, axis->list[k] - value);
        status = saltus_system_new(&spec, &system, message);
        if (status == SALTUS_OK)
            memcpy(page->observers + k * n, saltus_system_observer(system), (size_t)n * sizeof(double));
        saltus_system_free(system);
    }
    return status;
}

/* Write the script and have it drawn. */
static saltus_status draw_page(saltus_sweep_page *page, saltus_message *message) {
    saltus_status status = saltus_gnuplot_open(&page->file, message);
    if (status != SALTUS_OK)
        return status;
    fprintf(page->file, "set terminal %s\n", saltus_gnuplot_terminal(page->figure));
    saltus_put_style(page->file, "eeeeee");
    fputs("set style textbox opaque noborder fillcolor '#ffffff' margins 0.4,0.2\n", page->file);
    status = page->sweep->axis_count > 1 ? saltus_sweep_put_map(page, message)
                                         : saltus_sweep_put_diagram(page, message);
    if (status == SALTUS_OK)
        return saltus_gnuplot_draw(page->file, page->figure, message);
    fclose(page->file);
    return status;
}

/* What the curves of branches show so that they fit the view of the sweep. */
static saltus_status find_measure(const saltus_sweep_page *page, saltus_show *show, saltus_message *message) {
    if (page->sweep->axis_count > 1)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: branches are drawn over one axis, the file has two", page->path);
    if (page->view == SALTUS_VIEW_IMPACTS)
        *show = SALTUS_SHOW_IMPACTS;
    else if (page->view == SALTUS_VIEW_SPEED)
        *show = SALTUS_SHOW_SPEED;
    else if (page->view == SALTUS_VIEW_STROBOSCOPIC)
        *show = SALTUS_SHOW_DISPLACEMENT;
    else
        return saltus_fail(
            message, SALTUS_BAD_INPUT,
            "%.200s: branches can be drawn over the views impacts, speed and stroboscopic, not %s",
            page->path, saltus_view_word(page->view));
    return SALTUS_OK;
}

/* Whether two numbers are the same but for rounding. */
static bool same(double a, double b) {
    return fabs(a - b) <= 1e-9 * fmax(fabs(a), fabs(b));
}

/* The first parameter other than the key in which two systems of one structure differ; NULL: none. */
static const char *difference(const saltus_spec *a, const saltus_spec *b, const char *key) {
    int count;
    const saltus_parameter *p = saltus_model_parameters(a->model, &count);
    for (int k = 0; k < count; k++)
        if (strcmp(p[k].name, key) != 0 && !same(a->parameters[k], b->parameters[k]))
            return p[k].name;
    for (int s = 0; s < a->stop_count; s++) {
        const saltus_stop *stop = &a->stops[s], *other = &b->stops[s];
        if (!saltus_key_means(key, "d", s) && !same(stop->d, other->d))
            return "d";
        if (!saltus_key_means(key, "r", s) && !same(stop->r, other->r))
            return "r";
        if (!saltus_key_means(key, "xi", s) && !same(stop->xi, other->xi))
            return "xi";
        if (stop->sides != other->sides)
            return "sides";
    }
    return NULL;
}

/* Whether a branch is of periodic orbits over that key, of a system that differs in nothing else. */
static saltus_status check_branch(const saltus_branch_file *file, const saltus_spec *spec, const char *key,
                                  const char *path, saltus_message *message) {
    if (file->options.locus != SALTUS_POINT_REGULAR || strcmp(file->options.key[0], key) != 0)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: %s in %s, the sweep is over %s", path,
                           file->options.locus != SALTUS_POINT_REGULAR ? "are special points"
                                                                       : "are periodic orbits",
                           file->options.key[0], key);
    if (!saltus_model_same(file->spec.model, spec->model) || file->spec.stop_count != spec->stop_count)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: is of another structure than the sweep (model or stops differ)", path);
    const char *name = difference(&file->spec, spec, key);
    if (name)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: has another %s than the sweep", path, name);
    return SALTUS_OK;
}

/* Read the branches and draw them with the sweep. */
static saltus_status draw_over(saltus_sweep_page *page, saltus_message *message) {
    const saltus_plot_options no_labels = {.label_count = 0};
    saltus_plot_page curves = {.system = page->system, .options = &no_labels};
    int count = page->wish->branch_count, read = 0;
    saltus_status status = find_measure(page, &curves.show, message);
    saltus_branch_file *files = status == SALTUS_OK ? calloc((size_t)count, sizeof *files) : NULL;
    if (status == SALTUS_OK && !files)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for %d branch files", count);
    for (; read < count && status == SALTUS_OK; read++) {
        status = saltus_branch_file_read(page->wish->branches[read], &files[read], message);
        if (status == SALTUS_OK)
            status = check_branch(&files[read], &page->sweep->spec, page->sweep->axes[0].key,
                                  page->wish->branches[read], message);
    }
    if (status == SALTUS_OK) {
        curves.files = files;
        curves.count = count;
        curves.x = page->x.range;
        page->branches = &curves;
        status = draw_page(page, message);
    }
    for (int k = 0; k < read; k++)
        saltus_branch_file_clear(&files[k]);
    free(files);
    return status;
}

/* Draw a sweep that has been read. `path` names it in messages. */
static saltus_status draw_sweep(const saltus_sweep_file *sweep, const char *path,
                                const saltus_sweep_view *view, const char *figure, saltus_message *message) {
    saltus_system *system = NULL;
    saltus_status status = saltus_system_new(&sweep->spec, &system, message);
    if (status == SALTUS_OK && saltus_system_dimension(system) != sweep->dimension)
        status = saltus_fail(message, SALTUS_BAD_INPUT,
                             "%.300s: is not a sound sweep file: its states have %d entries, its scene makes "
                             "it %d",
                             path, sweep->dimension, saltus_system_dimension(system));
    saltus_sweep_page page = {.sweep = sweep,
                              .wish = view,
                              .path = path,
                              .figure = figure,
                              .view = choose_view(sweep, view->view),
                              .system = system};
    if (status == SALTUS_OK)
        status = check_view(&page, message);
    if (status == SALTUS_OK)
        status = check_parts(&page, message);
    if (status == SALTUS_OK)
        status = open_axes(&page, message);
    if (status == SALTUS_OK)
        status = open_observers(&page, message);
    if (status == SALTUS_OK)
        status = view->branch_count ? draw_over(&page, message) : draw_page(&page, message);
    saltus_cells_close(&page.x);
    saltus_cells_close(&page.y);
    saltus_classes_close(&page.classes);
    free(page.observers);
    saltus_system_free(system);
    return status;
}

saltus_status saltus_plot_sweep(const char *path, const saltus_sweep_view *view, const char *figure,
                                saltus_message *message) {
    saltus_sweep_file sweep;
    if (!saltus_gnuplot_terminal(figure))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s: the ending must be .png, .pdf or .svg", figure);
    saltus_status status = saltus_sweep_file_read(path, &sweep, message);
    if (status != SALTUS_OK)
        return status;
    status = draw_sweep(&sweep, path, view, figure, message);
    saltus_sweep_file_clear(&sweep);
    return status;
}
