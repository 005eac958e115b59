/* Texts, frames and legends of the figures of sweeps.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep.h"
#include "record/describe.h"
#include "record/output.h"

#include <math.h>
#include <string.h>

/* For each view its name and the quantity shown. For a displacement, its name stands between `before` and
 * `after`. Without forcing `returns` replaces `called`, and `unforced` replaces `after` or `before`. */
static const struct {
    const char *called, *returns, *before, *after, *unforced;
    bool displacement;
} words[] = {
    [SALTUS_VIEW_TURNING] = {"displacement diagram", .after = "  where it turns", .displacement = true},
    [SALTUS_VIEW_STROBOSCOPIC] = {"stroboscopic diagram", "diagram of returns", .after = "  at phase 0",
                                  .unforced = "  at returns to the section", .displacement = true},
    [SALTUS_VIEW_IMPACTS] = {"velocity diagram", .before = "speed of every impact  |{/:Bold n·q′}|"},
    [SALTUS_VIEW_LARGEST] = {"largest displacement", .before = "largest ", .displacement = true},
    [SALTUS_VIEW_RMS] = {"root mean square", .before = "root mean square of the ", .displacement = true},
    [SALTUS_VIEW_SPEED] = {"largest impact speed", .before = "largest impact speed  |{/:Bold n·q′}|"},
    [SALTUS_VIEW_RATE] = {"impacts per period", "impacts per return", "impacts per forcing period",
                          .unforced = "impacts per return to the section"},
    [SALTUS_VIEW_CONTACT] = {"time in contact", .before = "part of the time in contact"},
    [SALTUS_VIEW_LYAPUNOV] = {"largest Lyapunov exponent",
                              .before = "largest Lyapunov exponent  per unit of time"},
    [SALTUS_VIEW_CLASS] = {"{/:Italic n}/{/:Italic p} motions", .before = "period in {/:Italic T}",
                           .unforced = "period in returns to the section"},
    [SALTUS_VIEW_ATTRACTORS] = {"number of attractors", .before = "number of attractors"},
    [SALTUS_VIEW_SETTLED] = {"periods until settled", "time until settled", "periods until settled",
                             .unforced = "time until settled"}};

void saltus_sweep_name_measure(const saltus_sweep_page *page, saltus_line *line) {
    const bool displacement = words[page->view].displacement;
    const char *before = words[page->view].before, *after = words[page->view].after;
    if (page->view == SALTUS_VIEW_IMPACTS && page->sides)
        before = "velocity at impact  {/:Bold n·q′}";
    if (words[page->view].unforced && !saltus_system_forced(page->system))
        *(displacement ? &after : &before) = words[page->view].unforced;
    saltus_line_add(line, "%s", before ? before : "");
    if (displacement && strncmp(page->x.key, "xi", 2) == 0 && !page->sweep->spec.observe[0])
        saltus_line_add(line, "displacement {/:Italic η}({/:Italic ξ}, {/:Italic τ})");
    else if (displacement)
        saltus_line_observed(line, page->system, false);
    saltus_line_add(line, "%s", after ? after : "");
}

/* The symbol of a key: for built-in models q1 and v1 become indexed letters; names from a text model stay as
 * they are. */
static void add_symbol(const saltus_system *system, const char *key, saltus_line *line) {
    const int entry = saltus_system_state_index(system, key);
    if (entry >= 0 && saltus_model_text(saltus_system_spec(system)->model))
        saltus_line_state(line, system, entry);
    else if (entry >= 0)
        saltus_line_add(line, "{/:Italic %c}%s_{%.8s}", key[0] == 'z' ? 'z' : 'q', key[0] == 'v' ? "′" : "",
                        key + 1);
    else
        saltus_line_symbol(line, key);
}

/* Number of values, how the trajectories start, and how long they may take to settle. */
static void add_method(const saltus_sweep_page *page, saltus_line *line) {
    const saltus_sweep_file *sweep = page->sweep;
    const saltus_sweep_options *o = &sweep->options;
    static const char *const starts[] = {"each from the initial state", "carried up", "carried down"};
    for (int k = 0; k < sweep->axis_count; k++) {
        const saltus_cells *cells = strcmp(page->x.key, sweep->axes[k].key) == 0 ? &page->x : &page->y;
        const int shown = cells->end - cells->first; /* of a part of the range */
        saltus_line_add(line, k ? " × %d" : "%d", shown);
        if (shown < sweep->axes[k].count)
            saltus_line_add(line, " of %d", sweep->axes[k].count);
        saltus_line_add(line, k && shown == sweep->axes[k].count ? " of " : " values of ");
        add_symbol(page->system, sweep->axes[k].key, line);
    }
    const bool start = saltus_system_state_index(page->system, sweep->axes[0].key) >= 0;
    for (int k = 0; k < sweep->pass_count && !start; k++)
        saltus_line_add(line, "%s%s", k ? " and " : ", ",
                        sweep->passes[k] == SALTUS_PASS_RESET && o->seeds > 1 ? "each"
                        : k && sweep->passes[k] == SALTUS_PASS_DOWN && sweep->passes[k - 1] == SALTUS_PASS_UP
                            ? "down"
                            : starts[sweep->passes[k]]);
    if (o->seeds > 1)
        saltus_line_add(line, " from %d initial states", o->seeds);
    if (sweep->basins)
        saltus_line_add(line, ";  at most %lld periods until settled", o->transient);
    else if (o->adaptive)
        saltus_line_add(line, ";  recorded: one orbit, or %lld period%s where no period is found after %lld",
                        o->record, saltus_plural(o->record), o->transient);
    else
        saltus_line_add(line, ";  recorded: %lld period%s after %lld", o->record, saltus_plural(o->record),
                        o->transient);
    /* How the exponents shown were measured. */
    if (page->view == SALTUS_VIEW_LYAPUNOV && o->measure > 0)
        saltus_line_add(line, ";  without a period: measured over up to %lld periods%s", o->measure,
                        sweep->axis_count == 1 ? ", bars ± one standard error" : "");
    if (page->view == SALTUS_VIEW_LYAPUNOV && saltus_sweep_any_lost(page))
        saltus_line_add(line, ";  %s: all directions lost", sweep->axis_count > 1 ? "black" : "▼");
    for (int k = 0; k < page->classes.count && !sweep->basins; k++)
        if (page->classes.list[k].verdict == SALTUS_IRREGULAR &&
            !(sweep->axis_count > 1 && page->view != SALTUS_VIEW_CLASS))
            saltus_line_add(line, ";  irregular: no period up to %d", o->longest);
    if (page->below)
        saltus_line_add(line, ";  at or below 0, so %s: %lld",
                        sweep->axis_count > 1 ? "in the lowest colour" : "not shown", page->below);
    bool numbers = page->view >= SALTUS_VIEW_LARGEST && saltus_sweep_visits(sweep) > 1;
    if (numbers && sweep->axis_count > 1)
        saltus_line_add(line, ";  shown: the first");
}

void saltus_sweep_caption(saltus_sweep_page *page) {
    const saltus_sweep_file *sweep = page->sweep;
    const char *const varied[2] = {sweep->axes[0].key, sweep->axis_count > 1 ? sweep->axes[1].key : NULL};
    const bool forced = saltus_system_forced(page->system), counts = page->view == SALTUS_VIEW_ATTRACTORS;
    const char *called = page->view == SALTUS_VIEW_CLASS && !varied[1] ? "period"
                         : words[page->view].returns && !forced        ? words[page->view].returns
                         : counts && sweep->basins                     ? "basins of attraction"
                                                                       : words[page->view].called;
    saltus_line *head = saltus_page_heading(&page->paper);
    saltus_line_plain(head, sweep->scene);
    saltus_line_add(head, ":  %s in ", called);
    add_symbol(page->system, varied[0], head);
    if (varied[1]) {
        saltus_line_add(head, " and ");
        add_symbol(page->system, varied[1], head);
    }
    if (!sweep->complete) {
        long long done = 0;
        for (long long k = 0; k < sweep->row_count; k++)
            done += sweep->rows[k].verdict != SALTUS_PENDING;
        double part = (double)done / (double)sweep->row_count;
        saltus_line_add(head, "  (interrupted: %.*f %% done)", part > 0.99 ? 1 : 0, floor(1000 * part) / 10);
    }
    saltus_line_parameters(saltus_page_words(&page->paper, "#202020"), page->system, varied);
    add_method(page, saltus_page_words(&page->paper, "#606060"));
}

void saltus_sweep_put_raster_ranges(FILE *file, int width, int height) {
    fprintf(file, "set x2range [0:%d]\nset y2range [0:%d]\n", width, height);
}

void saltus_sweep_put_axis(const saltus_sweep_page *page, const char *axis, const saltus_cells *cells) {
    saltus_line name = {.length = 0};
    const char *key = cells->key;
    const int entry = saltus_system_state_index(page->system, key), dof = saltus_system_dof(page->system);
    if (entry >= 0) {
        bool text = saltus_model_text(saltus_system_spec(page->system)->model) != NULL;
        saltus_line_add(&name, "initial %s  ",
                        entry < dof       ? "displacement"
                        : entry < 2 * dof ? "velocity"
                        : text            ? "state"
                                          : "force");
        add_symbol(page->system, key, &name);
    } else
        saltus_line_parameter(&name, &page->sweep->spec, key);
    saltus_page_axis(&page->paper, axis, page->frame, cells->logarithmic, name.text, cells->range);
}

void saltus_sweep_put_entry(const saltus_sweep_page *page, double x, double y, saltus_paint paint,
                            bool hatched, const char *text, const char *figures) {
    const double size = 18, reach = 344, w = page->paper.width, h = page->paper.height;
    fprintf(page->paper.file,
            "set object rectangle from screen %.6f,%.6f to screen %.6f,%.6f front fc rgb '#%06x' fs solid "
            "border lc rgb '#909090' lw 0.6\n",
            x / w, y / h, (x + size) / w, (y + size) / h, (unsigned)paint.colour);
    saltus_line plain = {.length = 0};
    saltus_line_plain(&plain, text);
    const bool narrow = saltus_page_narrow(&page->paper);
    saltus_page_label(&page->paper, plain.text, x + size + (narrow ? 8 : 12), y + 0.5 * size,
                      "left front font ',%.4g' tc rgb '#202020'",
                      saltus_page_type(&page->paper, narrow ? 10.5 : 12));
    for (int k = 0; k < 7; k++) {
        double a = fmax(0, 2 * k - 6) * size / 6, b = fmin(6, 2 * k) * size / 6, c = (k + 0.5) * size / 3;
        unsigned texture = k < 3 ? paint.texture : 0;
        const double lines[3][4] = {{a, b, b, a}, {0, c, size, c}, {c, 0, c, size}};
        const bool drawn[3] = {hatched && k > 0 && k < 6, texture & SALTUS_BARS, texture & SALTUS_POSTS};
        for (int n = 0; n < 3; n++)
            if (drawn[n])
                fprintf(page->paper.file,
                        "set arrow from screen %.6f,%.6f to screen %.6f,%.6f nohead front lc rgb '#404040' "
                        "lw 0.8\n",
                        (x + lines[n][0]) / w, (y + lines[n][1]) / h, (x + lines[n][2]) / w,
                        (y + lines[n][3]) / h);
        for (int n = 0; n < 2 && (texture & SALTUS_DOTS); n++)
            fprintf(page->paper.file,
                    "set label '' at screen %.6f,%.6f point pt 7 ps 0.2 lc rgb '#404040' front\n",
                    (x + c) / w, (y + (0.5 * n + 0.2 + 0.25 * (k % 2)) * size * 0.9) / h);
    }
    if (*figures)
        saltus_page_label(&page->paper, figures, x + reach, y + 0.5 * size,
                          "right front font ',12' tc rgb '#606060'");
}

/* One pixel per unit on screens; two in files that may be enlarged. */
int saltus_sweep_fineness(const saltus_sweep_page *page) {
    return saltus_path_ends(page->paper.path, ".png") && page->paper.look.width == 0 ? 1 : 2;
}
