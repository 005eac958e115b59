/* Figures of sweeps: diagrams over one axis, maps over two, basins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep.h"

#include "record/describe.h"
#include "record/fields.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Whether the file holds the data of a view. */
static bool holds(const saltus_sweep_file *sweep, saltus_view view) {
    if (!saltus_view_is_cloud(view))
        return view != SALTUS_VIEW_LYAPUNOV || (sweep->options.keep & SALTUS_KEEP_LYAPUNOV);
    const int cloud = (int)(view - SALTUS_VIEW_TURNING);
    return (sweep->options.keep & saltus_clouds[cloud].keep) && saltus_sweep_entries_of(sweep, cloud).count;
}

static saltus_view choose_view(const saltus_sweep_file *sweep, saltus_view wanted) {
    if (wanted != SALTUS_VIEW_AUTOMATIC)
        return wanted;
    if (sweep->axis_count > 1)
        return sweep->basins && sweep->complete ? SALTUS_VIEW_ATTRACTORS : SALTUS_VIEW_CLASS;
    saltus_view view = SALTUS_VIEW_TURNING;
    while (saltus_view_is_cloud(view) && !holds(sweep, view))
        view++;
    return saltus_view_is_cloud(view)                   ? view
           : sweep->options.keep & SALTUS_KEEP_LYAPUNOV ? SALTUS_VIEW_LYAPUNOV
                                                        : SALTUS_VIEW_LARGEST;
}

/* Check that the file holds the view's data, and that ranges are for axes that the view shows. */
static saltus_status check_view(const saltus_sweep_page *page, saltus_message *message) {
    const saltus_sweep_file *sweep = page->sweep;
    const char *word = saltus_view_word(page->view);
    const bool two = sweep->axis_count > 1;
    if (saltus_view_is_cloud(page->view) && two)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: view %s is over one axis, the file has two (%s and %s): class, "
                           "attractors, largest, rms, speed, rate, contact, lyapunov and settled are maps",
                           page->path, word, sweep->axes[0].key, sweep->axes[1].key);
    if (!holds(sweep, page->view))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: holds no data for view %s: the sweep was run without --what %s",
                           page->path, word, word);
    if (page->view == SALTUS_VIEW_ATTRACTORS && sweep->basins && !sweep->complete)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: is not complete, and attractors are told apart at the end: view class "
                           "shows what there is",
                           page->path);
    for (int k = 0; k < page->wish->part_count; k++) {
        const char *key = page->wish->parts[k].key;
        if (strcmp(key, sweep->axes[0].key) != 0 && !(two && strcmp(key, sweep->axes[1].key) == 0) &&
            strcmp(key, word) != 0)
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "%.200s: range of %s: the figure shows %s%s%s and %s", page->path, key,
                               sweep->axes[0].key, two ? ", " : "", two ? sweep->axes[1].key : "", word);
    }
    return SALTUS_OK;
}

/* Restrict an axis to the requested range. */
static saltus_status cut_axis(const saltus_sweep_page *page, saltus_cells *cells, saltus_message *message) {
    const saltus_plot_part *part = saltus_plot_part_of(page->wish->parts, page->wish->part_count, cells->key);
    double low = cells->range.low, high = cells->range.high;
    int axis = strcmp(cells->key, page->sweep->axes[0].key) != 0;
    const double *list = page->sweep->axes[axis].list;
    if (part && (part->low >= high || part->high <= low))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: there is nothing from %s = %g to %g: the sweep goes from %.6g to %.6g",
                           page->path, cells->key, part->low, part->high, list[cells->order[0]],
                           list[cells->order[cells->count - 1]]);
    if (part && cells->logarithmic && part->low <= 0)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: range of %s: the axis is logarithmic, its range must be positive",
                           page->path, cells->key);
    if (part)
        cells->range = (saltus_range){part->low, part->high};
    for (int k = 0; k < cells->count; k++) {
        const double middle = saltus_cells_part(cells, list[cells->order[k]]);
        cells->first += middle < 0;
        cells->end += middle <= 1;
    }
    return SALTUS_OK;
}

/* The axes and the range of what is shown, cut and logarithmic as requested. */
static saltus_status open_axes(saltus_sweep_page *page, saltus_message *message) {
    const saltus_axis *axes = page->sweep->axes;
    const saltus_figure_options *look = &page->wish->look;
    const char *view = saltus_view_word(page->view);
    bool two = page->sweep->axis_count > 1, swap = two && look->swap;
    saltus_cells *first = swap ? &page->y : &page->x, *second = swap ? &page->x : &page->y;
    if (!saltus_cells_open(first, &axes[0], saltus_plot_logarithmic(look, axes[0].key)) ||
        (two && !saltus_cells_open(second, &axes[1], saltus_plot_logarithmic(look, axes[1].key))) ||
        !saltus_classes_open(&page->classes, page->sweep))
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for drawing %.200s", page->path);
    saltus_status status = cut_axis(page, &page->x, message);
    if (status == SALTUS_OK && two)
        status = cut_axis(page, &page->y, message);
    const saltus_plot_part *part = saltus_plot_part_of(page->wish->parts, page->wish->part_count, view);
    page->asked = part != NULL;
    if (part)
        page->up = (saltus_range){part->low, part->high};
    page->logarithmic = saltus_plot_logarithmic(look, view);
    for (int k = 0; k < look->logarithmic_count && status == SALTUS_OK; k++) {
        const char *key = look->logarithmic[k];
        const saltus_cells *cells = strcmp(key, page->x.key) == 0          ? &page->x
                                    : two && strcmp(key, page->y.key) == 0 ? &page->y
                                                                           : NULL;
        if (!cells && strcmp(key, view) != 0)
            status = saltus_fail(message, SALTUS_BAD_INPUT,
                                 "%.200s: logarithmic axis %.40s: the figure shows %s%s%s and %s", page->path,
                                 key, page->x.key, two ? ", " : "", two ? page->y.key : "", view);
        else if (cells && !cells->logarithmic)
            status = saltus_fail(message, SALTUS_BAD_INPUT,
                                 "%.200s: logarithmic axis %s: its values must be positive", page->path, key);
        else if (!cells &&
                 (page->view == SALTUS_VIEW_LYAPUNOV || (two && page->view <= SALTUS_VIEW_ATTRACTORS)))
            status = saltus_fail(message, SALTUS_BAD_INPUT,
                                 "%.200s: logarithmic axis %.40s: what is shown has no logarithm", page->path,
                                 key);
    }
    return status;
}

/* The rows that give the observed displacement; they vary along an axis that moves the stop. */
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

/* Check that a branch file fits the sweep: periodic orbits over the one axis, or a locus over both axes (in
 * either order, exchanged if needed), of a system that is otherwise equal. */
static saltus_status check_branch(const saltus_sweep_page *page, saltus_branch_file *file, const char *path,
                                  saltus_message *message) {
    const saltus_spec *spec = &page->sweep->spec;
    const double rounding = 1e-9;
    bool two = page->sweep->axis_count > 1, locus = file->options.locus != SALTUS_POINT_REGULAR;
    const char *const keys[2] = {page->x.key, two ? page->y.key : ""};
    if (two && locus && strcmp(file->options.key[0], keys[0]) != 0)
        saltus_plot_turn(file);
    if (locus != two || strcmp(file->options.key[0], keys[0]) != 0 ||
        (two && strcmp(file->options.key[1], keys[1]) != 0))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: %s in %s%s%s, the sweep is over %s%s%s", path,
                           locus ? "are special points" : "are periodic orbits", file->options.key[0],
                           locus ? " and " : "", locus ? file->options.key[1] : "", keys[0],
                           two ? " and " : "", keys[1]);
    if (!saltus_model_same(file->spec.model, spec->model) || file->spec.stop_count != spec->stop_count)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: is of another structure than the sweep (model or stops differ)", path);
    saltus_plot_value own, its;
    for (int k = 0;
         saltus_plot_value_of(&file->spec, k, keys, &own) && saltus_plot_value_of(spec, k, keys, &its); k++)
        if (!own.on_axis &&
            !(fabs(own.value - its.value) <= rounding * fmax(fabs(own.value), fabs(its.value))))
            return saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: has another %s than the sweep", path,
                               own.sides ? "sides" : own.key);
    return SALTUS_OK;
}

/* What is drawn over the sweep: labels and, from their files, branches, whose vertical coordinate follows the
 * view. `files` receives the files read, *read their number. */
static saltus_status open_over(saltus_sweep_page *page, saltus_branch_file *files, int *read,
                               saltus_message *message) {
    static const saltus_show shows[SALTUS_VIEW_SETTLED + 1] = {[SALTUS_VIEW_IMPACTS] = SALTUS_SHOW_IMPACTS,
                                                               [SALTUS_VIEW_SPEED] = SALTUS_SHOW_SPEED,
                                                               [SALTUS_VIEW_STROBOSCOPIC] =
                                                                   SALTUS_SHOW_DISPLACEMENT};
    const saltus_range any = {-INFINITY, INFINITY};
    const saltus_sweep_view *wish = page->wish;
    const bool two = page->sweep->axis_count > 1;
    const char *const measure = two ? page->y.key : saltus_view_word(page->view);
    saltus_plot_page *over = &page->over;
    *over = (saltus_plot_page){.paper = &page->paper,
                               .system = page->system,
                               .files = files,
                               .count = wish->branch_count,
                               .labels = wish->labels,
                               .label_count = wish->label_count,
                               .locus = two,
                               .over_sweep = true,
                               .show = shows[page->view],
                               .turning = page->view == SALTUS_VIEW_TURNING,
                               .swap = page->swap,
                               .x = any,
                               .y = two ? page->y.range : any};
    *(page->swap ? &over->y : &over->x) = page->x.range;
    over->keys[page->swap] = page->x.key;
    over->keys[!page->swap] = measure;
    over->logarithmic[page->swap] = page->x.logarithmic;
    over->logarithmic[!page->swap] = two ? page->y.logarithmic : page->logarithmic;
    saltus_status status = saltus_plot_check_labels(over, message);
    if (status != SALTUS_OK || !over->count)
        return status;
    if (page->sweep->basins)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%.200s: nothing is drawn over basins of attraction",
                           page->path);
    if (!two && !over->turning && over->show == SALTUS_SHOW_AUTOMATIC)
        return saltus_fail(
            message, SALTUS_BAD_INPUT,
            "%.200s: branches can be drawn over the views turning, impacts, speed and stroboscopic, not %s",
            page->path, measure);
    for (; *read < over->count && status == SALTUS_OK; ++*read) {
        status = saltus_branch_file_read(wish->branches[*read], &files[*read], message);
        if (status == SALTUS_OK)
            status = check_branch(page, &files[*read], wish->branches[*read], message);
    }
    return status == SALTUS_OK ? saltus_plot_open(over, message) : status;
}

saltus_status saltus_plot_sweep(const char *figure, const char *path, const saltus_sweep_view *view,
                                saltus_message *message) {
    saltus_sweep_file sweep;
    saltus_status status = saltus_figure_check(figure, &view->look, message);
    if (status != SALTUS_OK)
        return status;
    status = saltus_sweep_file_read(path, &sweep, message);
    if (status != SALTUS_OK)
        return status;
    saltus_system *system = NULL;
    status = saltus_system_new(&sweep.spec, &system, message);
    if (status == SALTUS_OK && saltus_system_dimension(system) != sweep.dimension)
        status = saltus_fail(
            message, SALTUS_BAD_INPUT,
            "%.300s: is not a sound sweep file: its states have %d entries, its scene makes it %d", path,
            sweep.dimension, saltus_system_dimension(system));
    saltus_sweep_page page = {.sweep = &sweep,
                              .wish = view,
                              .path = path,
                              .view = choose_view(&sweep, view->view),
                              .swap = view->look.swap && sweep.axis_count == 1,
                              .system = system};
    if (status == SALTUS_OK)
        status = check_view(&page, message);
    if (status == SALTUS_OK)
        status = open_axes(&page, message);
    if (status == SALTUS_OK)
        status = open_observers(&page, message);
    saltus_branch_file *files = calloc((size_t)view->branch_count + 1, sizeof *files);
    int read = 0;
    if (!files && status == SALTUS_OK)
        status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for %d branch files", view->branch_count);
    if (status == SALTUS_OK)
        status = open_over(&page, files, &read, message);
    if (status == SALTUS_OK)
        status = saltus_page_open(&page.paper, figure, &view->look, message);
    if (status == SALTUS_OK) {
        status = (sweep.axis_count > 1 ? saltus_sweep_put_map : saltus_sweep_put_diagram)(&page, message);
        status = saltus_page_close(&page.paper, status, message);
    }
    saltus_plot_close(&page.over);
    for (int k = 0; k < read; k++)
        saltus_branch_file_clear(&files[k]);
    free(files);
    saltus_cells_close(&page.x);
    saltus_cells_close(&page.y);
    saltus_classes_close(&page.classes);
    free(page.observers);
    saltus_system_free(system);
    saltus_sweep_file_clear(&sweep);
    return status;
}
