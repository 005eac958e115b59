/* The strip of classes below a diagram, which shows the kind of motion along the axis.
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

/* Pixels across a strip. */
static int pixels_across(const saltus_sweep_page *page, saltus_frame strip) {
    return (int)(saltus_sweep_fineness(page) * (strip.right - strip.left));
}

/* The class of the next stretch that is wide enough for the name of its class, from *first to before *end;
 * NULL: there is none. Slivers of other classes end a stretch only if the name has room beside them. *end is
 * where the search begins, 0 at first. */
static const saltus_sweep_class *next_named(const saltus_sweep_page *page, const int *winners, int width,
                                            int *first, int *end) {
    const double letter = 9.2, room = 8;
    const int fineness = saltus_sweep_fineness(page), sliver = 2 * fineness;
    while (*end < width) {
        const int own = winners[*end];
        const saltus_sweep_class *c = own >= 0 ? &page->classes.list[own] : NULL;
        const double least = c ? fineness * (letter * (double)strlen(c->label) + room) : 0;
        *first = *end;
        while (*end < width && winners[*end] == own)
            ++*end;
        const int whole = *end;
        for (int x = *end; x < width && x <= *end + sliver && *end - *first < least; x++)
            if (winners[x] == own)
                *end = x + 1;
        if (c && c->verdict != SALTUS_PENDING && *end - *first >= least)
            return c;
        *end = whole;
    }
    return NULL;
}

/* All bands; the first pass is on top. */
static bool paint(const saltus_sweep_page *page, saltus_raster *raster) {
    int passes = page->sweep->pass_count, height = raster->height / passes,
        fineness = saltus_sweep_fineness(page);
    int *counts = calloc((size_t)page->classes.count, sizeof *counts),
        *winners = calloc((size_t)raster->width, sizeof *winners);
    for (int pass = 0; pass < passes && counts && winners; pass++) {
        int bottom = (passes - 1 - pass) * height;
        for (int x = 0; x < raster->width; x++) {
            int total = count_classes(page, pass, raster->width, x, counts, &winners[x]);
            /* Stack the classes, each with a height proportional to its share. */
            for (int k = 0, y = 0, passed = 0, high = height - (passes > 1); k < page->classes.count && total;
                 k++)
                for (passed += counts[k]; y < high * passed / total; y++)
                    saltus_raster_set(
                        raster, x, bottom + y,
                        saltus_paint_at(page->classes.list[k].paint, x / fineness, (bottom + y) / fineness),
                        1);
        }
        /* Names of the stretches along which one class prevails. */
        const saltus_sweep_class *c;
        for (int first, end = 0; (c = next_named(page, winners, raster->width, &first, &end)) != NULL;) {
            saltus_line name = {.length = 0};
            saltus_line_plain(&name, c->label);
            fputs("set label ", page->paper.file);
            saltus_put_quoted(page->paper.file, name.text, name.length);
            fprintf(page->paper.file, " at graph %.6f,%.6f center front font ',%.4g' tc rgb '%s'\n",
                    0.5 * (first + end) / raster->width, (bottom + 0.5 * height) / raster->height,
                    saltus_page_type(&page->paper, 10.5),
                    saltus_colour_light(c->paint.colour) ? "#101010" : "#ffffff");
        }
    }
    bool sound = counts && winners;
    free(counts);
    free(winners);
    return sound;
}

/* Find the classes that occur in the visible part, and whether each has a name in the strip. */
static bool find_named(const saltus_sweep_page *page, int width, bool *occurs, bool *named) {
    int *counts = calloc((size_t)page->classes.count, sizeof *counts),
        *winners = calloc((size_t)width, sizeof *winners);
    const bool sound = counts && winners;
    for (int pass = 0; pass < page->sweep->pass_count && sound; pass++) {
        for (int x = 0; x < width; x++)
            if (count_classes(page, pass, width, x, counts, &winners[x]))
                for (int k = 0; k < page->classes.count; k++)
                    occurs[k] = occurs[k] || counts[k] > 0;
        const saltus_sweep_class *c;
        for (int first, end = 0; (c = next_named(page, winners, width, &first, &end)) != NULL;)
            named[c - page->classes.list] = true;
    }
    free(counts);
    free(winners);
    return sound;
}

bool saltus_sweep_put_strip_legend(const saltus_sweep_page *page, saltus_frame strip, double top, bool drawn,
                                   double *height) {
    const double row = 25, apart = 30, letter = 9.6;
    size_t count = (size_t)page->classes.count + 1;
    bool *occurs = calloc(count, sizeof *occurs), *named = calloc(count, sizeof *named);
    bool sound = occurs && named && find_named(page, pixels_across(page, strip), occurs, named);
    double x = strip.left;
    *height = 0;
    for (int k = 0; k < page->classes.count && sound; k++) {
        const saltus_sweep_class *c = &page->classes.list[k];
        char label[64];
        if (!occurs[k] || named[k])
            continue;
        saltus_sweep_word_class(page->sweep, c, label);
        double own = apart + letter * (double)strlen(label) + 14;
        if (x + own > strip.right && x > strip.left)
            x = strip.left;
        if (x == strip.left)
            *height += row;
        if (drawn)
            saltus_sweep_put_entry(page, x, top - *height, c->paint, false, label, "");
        x += own;
    }
    free(occurs);
    free(named);
    return sound;
}

bool saltus_sweep_put_strip(const saltus_sweep_page *page, saltus_frame frame) {
    FILE *file = page->paper.file;
    saltus_raster raster;
    const int passes = page->sweep->pass_count;
    if (!saltus_raster_open(&raster, pixels_across(page, frame),
                            (int)(saltus_sweep_fineness(page) * (frame.top - frame.bottom))))
        return false;
    saltus_page_frame(&page->paper, frame, 0);
    saltus_sweep_put_axis(page, "x", &page->x);
    saltus_sweep_put_raster_ranges(file, raster.width, raster.height);
    fputs("set format x '% h'\nunset ylabel\nset yrange [0:1]\nunset ytics\nunset grid\n", file);
    bool sound = paint(page, &raster);
    for (int pass = 0; pass < passes; pass++)
        fprintf(file, "set label '%s' at graph -0.008,%.6f right front font ',%.4g' tc rgb '#404040'\n",
                passes > 1 ? saltus_pass_word(page->sweep->passes[pass]) : "{/:Italic n}/{/:Italic p}",
                (passes - 1 - pass + 0.5) / passes, saltus_page_type(&page->paper, 10.5));
    fputs("set border 1\nplot ", file);
    saltus_raster_element(file, &raster, "x2y2");
    fputs(", NaN notitle\n", file);
    saltus_raster_bytes(file, &raster);
    saltus_raster_close(&raster);
    return sound;
}
