/* Bifurcation diagrams: branches of orbits, or loci of special points, drawn by gnuplot from a script that
 * contains the data.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/branch.h"

#include "record/describe.h"
#include "record/output.h"
#include "saltus/record.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What a diagram may show: the word in options, and the title of the axis, where the observed quantity may
 * stand first. Orbits with their own periods have another title. */
static const struct {
    const char *word, *title, *own;
    bool observed;
} shown[] = {
    [SALTUS_SHOW_SPEED] = {"speed", .title = "largest impact speed  |{/:Bold n·q′}|"},
    [SALTUS_SHOW_IMPACTS] = {"impacts", .title = "speed of every impact  |{/:Bold n·q′}|"},
    [SALTUS_SHOW_DISPLACEMENT] = {"displacement", "  at phase 0", "  at its maximum", .observed = true},
    [SALTUS_SHOW_VELOCITY] = {"velocity", "  at phase 0", "  at its maximum", .observed = true},
    [SALTUS_SHOW_PERIOD] = {"period", "period in {/:Italic T}", .own = "period"},
    [SALTUS_SHOW_AMPLITUDE] = {"amplitude", .title = "  largest and smallest of an orbit", .observed = true}};

/* The heading, and the parameters common to all files; parameters that differ have the values of the first
 * file. */
static void put_caption(const saltus_plot_page *page, saltus_page *paper) {
    const saltus_branch_options *o = &page->files[0].options;
    saltus_line *head = saltus_page_heading(paper), *parameters = saltus_page_words(paper, "#202020");
    char first[SALTUS_KEY_MAX], second[SALTUS_KEY_MAX];
    saltus_line_plain(head, page->files[0].scene);
    saltus_line_add(head, ":  %s in ",
                    page->locus    ? "special points"
                    : !page->rests ? "periodic orbits"
                    : page->orbits ? "equilibria and periodic orbits"
                                   : "equilibria");
    saltus_line_symbol(head, o->key[0]);
    if (page->locus) {
        saltus_line_add(head, " and ");
        saltus_line_symbol(head, o->key[1]);
    }
    bool complete = true;
    for (int i = 0; i < page->count; i++)
        complete = complete && page->files[i].complete;
    if (!complete)
        saltus_line_add(head, "  (interrupted)");
    saltus_plot_difference(page, 0, first);
    saltus_plot_difference(page, 1, second);
    const char *const varied[2] = {o->key[0], page->locus ? o->key[1] : *first ? first : NULL};
    saltus_line_parameters(parameters, page->system, varied);
    if (page->locus ? *first : *second || strncmp(first, "sides", strlen("sides")) == 0)
        saltus_line_add(parameters, ", where nothing else is said");
}

static bool write_script(saltus_plot_page *page, saltus_page *paper) {
    page->paper = paper;
    page->frame = saltus_page_rest(paper, 20);
    const double wide = page->frame.right - page->frame.left;
    if (paper->free_height)
        paper->height += saltus_plot_legend(page, wide, false);
    put_caption(page, paper);
    saltus_page_begin(paper);
    saltus_page_caption(paper);
    page->frame = saltus_page_rest(paper, 20 + saltus_plot_legend(page, wide, true));
    bool sound = saltus_plot_data(page);
    saltus_page_frame(paper, page->frame, SALTUS_PANEL_LEAST);
    const saltus_branch_options *o = &page->files[0].options;
    const saltus_spec *spec = &page->files[0].spec;
    saltus_line name[2] = {{.length = 0}, {.length = 0}};
    saltus_line_parameter(&name[page->swap], spec, o->key[0]);
    if (page->locus)
        saltus_line_parameter(&name[1], spec, o->key[1]);
    else {
        saltus_line *line = &name[!page->swap];
        const char *own = page->cycles ? shown[page->show].own : NULL;
        if (shown[page->show].observed)
            saltus_line_observed(line, page->system, page->show == SALTUS_SHOW_VELOCITY);
        if (page->show != SALTUS_SHOW_AMPLITUDE || page->orbits)
            saltus_line_add(line, "%s", own ? own : shown[page->show].title);
    }
    for (int axis = 0; axis < 2; axis++)
        saltus_page_axis(page->paper, axis ? "y" : "x", page->frame, page->logarithmic[axis], name[axis].text,
                         axis ? page->y : page->x);
    saltus_plot_labels(page, NULL, NULL);
    fputs("plot \\\n", page->paper->file);
    saltus_plot_elements(page);
    return sound;
}

/* Find what the files contain, and choose the vertical axis if the caller did not: amplitudes for orbits with
 * their own periods, impact speeds if there are impacts, otherwise displacements. */
static void choose_measure(saltus_plot_page *page) {
    bool hits = false;
    for (int i = 0; i < page->count; i++)
        for (int k = 0; k < page->files[i].point_count; k++) {
            const saltus_branch_point *point = &page->files[i].points[k];
            *(point->periods ? &page->orbits : &page->rests) = true;
            hits = hits || point->event_count > 0;
        }
    const saltus_branch_file *first = &page->files[0];
    page->cycles = first->point_count > 0 && (first->points[0].trivial_multiplier != 0 || page->rests);
    page->show = page->options->show;
    if (page->show == SALTUS_SHOW_AUTOMATIC)
        page->show = page->cycles ? SALTUS_SHOW_AMPLITUDE
                     : hits       ? SALTUS_SHOW_SPEED
                                  : SALTUS_SHOW_DISPLACEMENT;
    page->turning = !page->locus && page->show == SALTUS_SHOW_AMPLITUDE;
}

/* Add margins around the values of an axis. */
static void pad(saltus_range *range, bool logarithmic, double part, double scale) {
    if (!logarithmic) {
        saltus_range_pad(range, part, scale);
        return;
    }
    double factor = pow(fmax(range->high / range->low, 1.1), part);
    *range = (saltus_range){range->low / factor, range->high * factor};
}

/* The ranges of the axes, in which there must be points; a logarithmic axis needs positive values. */
static saltus_status find_ranges(saltus_plot_page *page, saltus_message *message) {
    const saltus_branch_options *o = &page->files[0].options;
    const saltus_plot_options *wish = page->options;
    const bool speeds =
                   !page->locus && (page->show == SALTUS_SHOW_SPEED || page->show == SALTUS_SHOW_IMPACTS),
               log_measure = page->logarithmic[!page->swap];
    saltus_range *first = page->swap ? &page->y : &page->x, *measure = page->swap ? &page->x : &page->y;
    page->x = page->y = (saltus_range){-INFINITY, INFINITY};
    const saltus_plot_part *along = saltus_plot_part_of(wish->parts, wish->part_count, o->key[0]),
                           *up = page->locus ? saltus_plot_part_of(wish->parts, wish->part_count, o->key[1])
                                             : NULL;
    if (along)
        *first = (saltus_range){along->low, along->high};
    if (up)
        *measure = (saltus_range){up->low, up->high};
    if (!along) {
        *first = saltus_plot_range(page, false);
        pad(first, page->logarithmic[page->swap], 0.03, 1e-3 * (o->high[0] - o->low[0]));
    }
    if (!up) {
        *measure = saltus_plot_range(page, true);
        if (log_measure && !page->locus)
            saltus_range_floor(measure);
        if (speeds && !log_measure && measure->low < 0.4 * measure->high)
            saltus_range_add(measure, 0);
        pad(measure, log_measure, 0.07,
            page->locus ? 1e-3 * (o->high[1] - o->low[1])
                        : 1e-3 * fmax(fabs(measure->high), fabs(measure->low)));
        if (speeds && measure->low < 0)
            measure->low = -0.02 * measure->high;
    }
    bool any = false;
    for (int k = 0; k < page->row_count; k++)
        any = any || saltus_plot_shown(page, &page->rows[k]);
    if (!any && page->locus)
        return saltus_fail(message, SALTUS_BAD_INPUT, "there is no point from %s = %g to %g, %s = %g to %g",
                           o->key[0], page->x.low, page->x.high, o->key[1], page->y.low, page->y.high);
    if (!any)
        return saltus_fail(message, SALTUS_BAD_INPUT, "there is no point from %s = %g to %g", o->key[0],
                           first->low, first->high);
    const saltus_range ranges[2] = {page->x, page->y};
    for (int axis = 0; axis < 2; axis++)
        if (page->logarithmic[axis] &&
            !(ranges[axis].low > 0 && ranges[axis].low < ranges[axis].high && ranges[axis].high < INFINITY))
            return saltus_fail(message, SALTUS_BAD_INPUT, "a logarithmic axis needs positive values");
    return SALTUS_OK;
}

/* What the axes show, and which are logarithmic. */
static saltus_status choose_axes(saltus_plot_page *page, saltus_message *message) {
    const saltus_branch_options *o = &page->files[0].options;
    const saltus_figure_options *look = &page->options->look;
    const char *const keys[2] = {o->key[0], page->locus ? o->key[1] : shown[page->show].word};
    for (int k = 0; k < 2; k++) {
        page->keys[k != page->swap] = keys[k];
        page->logarithmic[k != page->swap] = saltus_plot_logarithmic(look, keys[k]);
    }
    for (int k = 0; k < look->logarithmic_count; k++)
        if (strcmp(look->logarithmic[k], keys[0]) != 0 && strcmp(look->logarithmic[k], keys[1]) != 0)
            return saltus_fail(message, SALTUS_BAD_INPUT,
                               "logarithmic axis %.40s: the figure shows %s and %s", look->logarithmic[k],
                               keys[0], keys[1]);
    return saltus_plot_check_labels(page, message);
}

static saltus_status draw(const saltus_branch_file *files, int count, const saltus_plot_options *options,
                          const char *figure, saltus_message *message) {
    saltus_system *system = NULL;
    saltus_page paper;
    saltus_status status = saltus_system_new(&files[0].spec, &system, message);
    if (status != SALTUS_OK)
        return status;
    bool locus = files[0].options.locus != SALTUS_POINT_REGULAR;
    saltus_plot_page page = {.files = files,
                             .count = count,
                             .system = system,
                             .options = options,
                             .labels = options->labels,
                             .label_count = options->label_count,
                             .swap = options->look.swap && !locus,
                             .locus = locus};
    choose_measure(&page);
    status = choose_axes(&page, message);
    if (status == SALTUS_OK)
        status = saltus_plot_open(&page, message);
    if (status == SALTUS_OK)
        status = find_ranges(&page, message);
    if (status == SALTUS_OK)
        status = saltus_page_open(&paper, figure, &options->look, message);
    if (status == SALTUS_OK) {
        if (!write_script(&page, &paper))
            status = saltus_fail(message, SALTUS_NO_MEMORY, "no memory for the curves of %d files", count);
        status = saltus_page_close(&paper, status, message);
    }
    saltus_plot_close(&page);
    saltus_system_free(system);
    return status;
}

saltus_plot_options saltus_plot_defaults(void) {
    return (saltus_plot_options){.show = SALTUS_SHOW_AUTOMATIC};
}

static bool is_axis(const saltus_branch_options *o, const char *key) {
    return strcmp(key, o->key[0]) == 0 || (o->key[1][0] && strcmp(key, o->key[1]) == 0);
}

/* Files drawn over each other must have the same axes. */
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
        saltus_plot_turn(b);
    return SALTUS_OK;
}

static saltus_status draw_sweep(const char *const *paths, int count, const saltus_plot_options *options,
                                const char *figure, saltus_message *message) {
    const saltus_sweep_view view = {.parts = options->parts,
                                    .part_count = options->part_count,
                                    .labels = options->labels,
                                    .label_count = options->label_count,
                                    .look = options->look};
    if (count > 1)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: is a sweep, which is drawn alone or with branches", paths[0]);
    if (options->show != SALTUS_SHOW_AUTOMATIC)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%.200s: is a sweep; what is shown of it is chosen as a view", paths[0]);
    return saltus_plot_sweep(figure, paths[0], &view, message);
}

saltus_status saltus_plot(const char *figure, const char *const *paths, int count,
                          const saltus_plot_options *options, saltus_message *message) {
    int read = 0;
    saltus_status status = saltus_figure_check(figure, &options->look, message);
    if (status != SALTUS_OK)
        return status;
    if (count < 1)
        return saltus_fail(message, SALTUS_BAD_INPUT, "there is no file to draw");
    const saltus_file_facts facts = saltus_file_identify(paths[0]);
    if (strcmp(facts.kind, "sweep") == 0 || strcmp(facts.kind, "basins") == 0)
        return draw_sweep(paths, count, options, figure, message);
    saltus_branch_file *files = calloc((size_t)count, sizeof *files);
    if (!files)
        return saltus_fail(message, SALTUS_NO_MEMORY, "no memory for %d branch files", count);
    for (; read < count && status == SALTUS_OK; read++) {
        status = saltus_branch_file_read(paths[read], &files[read], message);
        if (status == SALTUS_OK && read == 0 && options->look.swap && *files[0].options.key[1])
            saltus_plot_turn(&files[0]);
        if (status == SALTUS_OK)
            status = match_axes(&files[0], &files[read], paths[read], message);
    }
    /* What is asked for must be of parameters that the figure shows. */
    const saltus_branch_options *o = &files[0].options;
    if (status == SALTUS_OK && o->locus != SALTUS_POINT_REGULAR && options->show != SALTUS_SHOW_AUTOMATIC)
        status =
            saltus_fail(message, SALTUS_BAD_INPUT,
                        "the figure shows curves of special points in %s and %s; what is shown of orbits "
                        "is chosen for branches over one parameter",
                        o->key[0], o->key[1]);
    for (int k = 0; k < options->part_count && status == SALTUS_OK; k++)
        if (!is_axis(o, options->parts[k].key))
            status = saltus_fail(message, SALTUS_BAD_INPUT, "%s=%g:%g: the figure shows %s%s%s",
                                 options->parts[k].key, options->parts[k].low, options->parts[k].high,
                                 o->key[0], *o->key[1] ? " and " : "", o->key[1]);
    if (status == SALTUS_OK)
        status = draw(files, count, options, figure, message);
    for (int k = 0; k < read; k++)
        saltus_branch_file_clear(&files[k]);
    free(files);
    return status;
}
