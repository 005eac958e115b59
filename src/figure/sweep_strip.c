/* The strip of classes below a diagram, or left of it, which shows the kind of motion along the axis.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Count the classes among the rows of one pass shown by a pixel; returns the number of rows. *winner: the
 * class of more than half of them, or -1. */
static int count_classes(const saltus_sweep_page *page, int pass, int width, int pixel, int *counts,
                         int *winner) {
    const saltus_sweep_file *sweep = page->sweep;
    int seeds = sweep->options.seeds, first, last;
    *winner = -1;
    memset(counts, 0, (size_t)page->classes.count * sizeof *counts);
    if (!saltus_cells_at(&page->x, width, pixel, &first, &last))
        return 0;
    for (int cell = first; cell <= last; cell++) {
        long long row = (pass * sweep->points + page->x.order[cell]) * seeds;
        for (int seed = 0; seed < seeds; seed++)
            counts[page->classes.of_row[row + seed]]++;
    }
    int total = (last - first + 1) * seeds;
    for (int k = 0; k < page->classes.count; k++)
        *winner = 2 * counts[k] > total ? k : *winner;
    return total;
}

/* Pixels along a strip. */
static int pixels_along(const saltus_sweep_page *page, saltus_frame strip) {
    const double length = page->swap ? strip.top - strip.bottom : strip.right - strip.left;
    return (int)fmax(1, saltus_sweep_fineness(page) * length);
}

/* A stretch of one class along a strip, from pixel `first` to before `end`. */
typedef struct stretch {
    const saltus_sweep_class *c;
    int first, end;
} stretch;

/* The next stretch from a pixel on that is wide enough for the name of its class; class NULL: there is none.
 * Slivers of other classes end a stretch only if the name has room beside them. */
static stretch next_wide(const saltus_sweep_page *page, const int *winners, int width, int from) {
    const double letter = 9.2, room = 8;
    const int fineness = saltus_sweep_fineness(page), sliver = 2 * fineness;
    while (from < width) {
        const int own = winners[from];
        const saltus_sweep_class *c = own >= 0 ? &page->classes.list[own] : NULL;
        const double least = c ? fineness * (letter * (double)strlen(c->label) + room) : 0;
        int end = from;
        while (end < width && winners[end] == own)
            end++;
        const int whole = end;
        for (int x = end; x < width && x <= end + sliver && end - from < least; x++)
            if (winners[x] == own)
                end = x + 1;
        if (c && c->verdict != SALTUS_PENDING && end - from >= least)
            return (stretch){c, from, end};
        from = whole;
    }
    return (stretch){NULL, width, width};
}

/* The next stretch to be named; *from is where the search begins and goes on. Of neighbours of one class with
 * less than the width of a letter or two between them only the widest has the name. */
static stretch next_named(const saltus_sweep_page *page, const int *winners, int width, int *from) {
    const int near = 16 * saltus_sweep_fineness(page);
    stretch found = next_wide(page, winners, width, *from), last = found;
    while (found.c) {
        const stretch next = next_wide(page, winners, width, last.end);
        if (next.c != found.c || next.first - last.end >= near)
            break;
        found = next.end - next.first > found.end - found.first ? next : found;
        last = next;
    }
    *from = last.end;
    return found;
}

/* All bands; the first pass is on top, or leftmost. */
static bool paint(const saltus_sweep_page *page, saltus_raster *raster) {
    const bool swap = page->swap;
    const int length = swap ? raster->height : raster->width, across = swap ? raster->width : raster->height;
    int passes = page->sweep->pass_count, height = across / passes, fineness = saltus_sweep_fineness(page);
    int *counts = calloc((size_t)page->classes.count, sizeof *counts),
        *winners = calloc((size_t)length, sizeof *winners);
    for (int pass = 0; pass < passes && counts && winners; pass++) {
        int bottom = (swap ? pass : passes - 1 - pass) * height;
        for (int x = 0; x < length; x++) {
            int total = count_classes(page, pass, length, x, counts, &winners[x]);
            /* Stack the classes, each with a height proportional to its share. */
            for (int k = 0, y = 0, passed = 0, high = height - (passes > 1); k < page->classes.count && total;
                 k++)
                for (passed += counts[k]; y < high * passed / total; y++) {
                    const int right = swap ? bottom + y : x, up = swap ? x : bottom + y;
                    saltus_raster_set(
                        raster, right, up,
                        saltus_paint_at(page->classes.list[k].paint, right / fineness, up / fineness), 1);
                }
        }
        /* Names of the stretches along which one class prevails. */
        stretch s;
        for (int from = 0; (s = next_named(page, winners, length, &from)).c != NULL;) {
            const double at = 0.5 * (s.first + s.end) / length, up = (bottom + 0.5 * height) / across;
            saltus_line name = {.length = 0};
            saltus_line_plain(&name, s.c->label);
            saltus_page_graph_label(&page->paper, &name, swap ? up : at, swap ? at : up, 6,
                                    "center %sfront font ',%.4g' tc rgb '%s'", swap ? "rotate by 90 " : "",
                                    saltus_page_type(&page->paper, 10.5),
                                    saltus_colour_light(s.c->paint.colour) ? "#101010" : "#ffffff");
        }
    }
    bool sound = counts && winners;
    free(counts);
    free(winners);
    return sound;
}

/* Of each class the rows in the visible part, and whether it has a name in a strip of this width. */
static bool survey(const saltus_sweep_page *page, int width, long long *shown, bool *named) {
    const saltus_sweep_file *sweep = page->sweep;
    int begin = page->x.count, end = -1;
    int *counts = calloc((size_t)page->classes.count, sizeof *counts),
        *winners = calloc((size_t)width, sizeof *winners);
    const bool sound = counts && winners;
    for (int pass = 0; pass < sweep->pass_count && sound; pass++) {
        stretch s;
        for (int x = 0; x < width; x++)
            count_classes(page, pass, width, x, counts, &winners[x]);
        for (int from = 0; (s = next_named(page, winners, width, &from)).c != NULL;)
            named[s.c - page->classes.list] = true;
    }
    for (int pixel = 0, first, last; pixel < width; pixel++)
        if (saltus_cells_at(&page->x, width, pixel, &first, &last)) {
            begin = first < begin ? first : begin;
            end = last > end ? last : end;
        }
    for (int k = 0; k < saltus_sweep_visits(sweep); k++)
        for (int cell = begin; cell <= end; cell++)
            shown[page->classes.of_row[saltus_sweep_visit(sweep, page->x.order[cell], k)]]++;
    free(counts);
    free(winners);
    return sound;
}

/* The most frequent classes, in a few rows: on a column of a journal fewer, or the legend would take as much
 * of the page as the diagram. */
double saltus_sweep_put_strip_legend(const saltus_sweep_page *page, saltus_frame frame, double top,
                                     bool drawn) {
    const int rows_most = saltus_page_narrow(&page->paper) ? 5 : 8;
    const double row = 25, apart = 30, letter = 9.6;
    size_t count = (size_t)page->classes.count + 1;
    const int width = pixels_along(page, frame);
    long long *shown = calloc(count, sizeof *shown), most = 0, rows = 0;
    bool *named = calloc(count, sizeof *named), sound = shown && named && survey(page, width, shown, named);
    double x = frame.left, height = 0;
    int left_out = 0;
    for (int k = 0; k < page->classes.count && sound; k++) {
        const saltus_sweep_class *c = &page->classes.list[k];
        char label[64];
        rows += shown[k];
        if (!shown[k] || named[k])
            continue;
        saltus_sweep_word_class(c, label);
        double own = apart + letter * (double)strlen(label) + 14;
        if (x + own > frame.right && x > frame.left)
            x = frame.left;
        if (left_out || (x == frame.left && height == rows_most * row)) {
            left_out++;
            most = shown[k] > most ? shown[k] : most;
            continue;
        }
        if (x == frame.left)
            height += row;
        if (drawn)
            saltus_sweep_put_entry(page, x, top - height, c->paint, false, label, "");
        x += own;
    }
    if (left_out)
        height += row;
    if (left_out && drawn) { /* how many there are, and the largest share of one of them */
        saltus_line words = {.length = 0};
        saltus_line_add(&words, "and %d more, %s", left_out, left_out > 1 ? "none above " : "");
        saltus_line_number(&words, "%.2g %%", 100 * ((double)most / (double)rows));
        saltus_page_label(&page->paper, words.text, frame.left, top - height + 9,
                          "left front font ',%.4g' tc rgb '#404040'", saltus_page_type(&page->paper, 10.5));
    }
    free(shown);
    free(named);
    return sound ? height : -1;
}

bool saltus_sweep_put_strip(const saltus_sweep_page *page, saltus_frame frame) {
    FILE *file = page->paper.file;
    saltus_raster raster;
    const int passes = page->sweep->pass_count, fineness = saltus_sweep_fineness(page);
    const double across = page->swap ? frame.right - frame.left : frame.top - frame.bottom;
    const int along = pixels_along(page, frame), wide = (int)(fineness * across);
    if (!saltus_raster_open(&raster, page->swap ? wide : along, page->swap ? along : wide))
        return false;
    saltus_page_frame(&page->paper, frame, 0);
    saltus_sweep_put_axis(page, page->swap ? "y" : "x", &page->x);
    saltus_sweep_put_raster_ranges(file, raster.width, raster.height);
    fputs(page->swap ? "set format y '% h'\nunset xlabel\nset xrange [0:1]\nunset xtics\nunset grid\n"
                     : "set format x '% h'\nunset ylabel\nset yrange [0:1]\nunset ytics\nunset grid\n",
          file);
    bool sound = paint(page, &raster);
    for (int pass = 0; pass < passes; pass++) {
        const double place = (pass + 0.5) / passes;
        fprintf(file, "set label '%s' at graph ",
                passes > 1 ? saltus_pass_word(page->sweep->passes[pass]) : "{/:Italic n}/{/:Italic p}");
        if (page->swap)
            fprintf(file, "%.6f,1 %s", place,
                    passes > 1 ? "left rotate by 90 offset 0,0.4" : "center offset 0,0.6");
        else
            fprintf(file, "-0.008,%.6f right", 1 - place);
        fprintf(file, " front font ',%.4g' tc rgb '#404040'\n", saltus_page_type(&page->paper, 10.5));
    }
    fprintf(file, "set border %d\nplot ", page->swap ? 2 : 1);
    saltus_raster_element(file, &raster, "x2y2");
    fputs(", NaN notitle\n", file);
    saltus_raster_bytes(file, &raster);
    saltus_raster_close(&raster);
    return sound;
}
