/* The strip of classes under a diagram: what the motion is along the axis.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Shares of the classes among the rows of one pass that a pixel shows. */
static void count_classes(const saltus_sweep_page *page, int pass, int first, int last, int *counts) {
    const saltus_sweep_file *sweep = page->sweep;
    int seeds = sweep->options.seeds;
    memset(counts, 0, (size_t)page->classes.count * sizeof *counts);
    for (int cell = first; cell <= last; cell++) {
        long long row = (pass * sweep->points + page->x.order[cell]) * seeds;
        for (int seed = 0; seed < seeds; seed++)
            counts[page->classes.of_row[row + seed]]++;
    }
}

/* A column of a pass's band: the classes one above the other, each as high as its share. The class with more
 * than half of it, or -1. */
static int paint_column(const saltus_sweep_page *page, const int *counts, int total, saltus_raster *raster,
                        int x, int bottom, int height) {
    int winner = -1, passed = 0;
    for (int k = 0; k < page->classes.count; k++) {
        int from = height * passed / total;
        passed += counts[k];
        if (2 * counts[k] > total)
            winner = k;
        for (int y = from; y < height * passed / total; y++)
            saltus_raster_set(raster, x, bottom + y, page->classes.list[k].colour, 1);
    }
    return winner;
}

/* A name on a stretch of the band that is wide enough for it. */
static void put_name(const saltus_sweep_page *page, const saltus_sweep_class *c, double from, double to,
                     double middle) {
    const double letter = 9.2, room = 8;
    int width = page->frame.right - page->frame.left;
    double own = letter * (double)strlen(c->label) + room;
    bool worth = c->shown && c->verdict != SALTUS_PENDING;
    if (!worth || (to - from) * width < own)
        return;
    saltus_line name = {.length = 0};
    saltus_line_plain(&name, c->label);
    fprintf(page->file, "set label '%s' at graph %.6f,%.6f center front font ',10.5' tc rgb '%s'\n",
            name.text, 0.5 * (from + to), middle, saltus_colour_light(c->colour) ? "#101010" : "#ffffff");
}

/* Names of the stretches along which one class prevails. */
static void put_names(const saltus_sweep_page *page, const int *winners, int width, double middle) {
    for (int x = 0, end; x < width; x = end) {
        for (end = x + 1; end < width && winners[end] == winners[x];)
            end++;
        if (winners[x] >= 0)
            put_name(page, &page->classes.list[winners[x]], (double)x / width, (double)end / width, middle);
    }
}

/* All bands, the first pass uppermost. */
static bool paint(const saltus_sweep_page *page, saltus_raster *raster) {
    int passes = page->sweep->pass_count, height = raster->height / passes;
    int *counts = calloc((size_t)page->classes.count, sizeof *counts),
        *winners = calloc((size_t)raster->width, sizeof *winners);
    for (int pass = 0; pass < passes && counts && winners; pass++) {
        int bottom = (passes - 1 - pass) * height;
        for (int x = 0; x < raster->width; x++) {
            int first, last;
            winners[x] = -1;
            if (!saltus_cells_at(&page->x, raster->width, x, &first, &last))
                continue;
            count_classes(page, pass, first, last, counts);
            winners[x] = paint_column(page, counts, (last - first + 1) * page->sweep->options.seeds, raster,
                                      x, bottom, height - (passes > 1));
        }
        put_names(page, winners, raster->width, (bottom + 0.5 * height) / raster->height);
    }
    bool sound = counts && winners;
    free(counts);
    free(winners);
    return sound;
}

bool saltus_sweep_put_strip(const saltus_sweep_page *page, saltus_frame frame) {
    FILE *file = page->file;
    saltus_raster raster;
    int fineness = saltus_sweep_fineness(page), passes = page->sweep->pass_count;
    if (!saltus_raster_open(&raster, fineness * (frame.right - frame.left),
                            fineness * (frame.top - frame.bottom)))
        return false;
    saltus_sweep_put_frame(file, frame);
    saltus_sweep_put_axis(page, 'x', &page->x);
    saltus_sweep_put_raster_ranges(file, raster.width, raster.height);
    fputs("set format x '% h'\nunset ylabel\nset yrange [0:1]\nunset ytics\nunset grid\n", file);
    bool sound = paint(page, &raster);
    for (int pass = 0; pass < passes; pass++)
        fprintf(file, "set label '%s' at graph -0.008,%.6f right front font ',10.5' tc rgb '#404040'\n",
                passes > 1 ? saltus_pass_word(page->sweep->passes[pass]) : "{/:Italic n}/{/:Italic p}",
                (passes - 1 - pass + 0.5) / passes);
    fputs("set border 1\nplot ", file);
    saltus_raster_element(file, &raster, "x2y2");
    fputs(", NaN notitle\n", file);
    saltus_raster_bytes(file, &raster);
    saltus_raster_close(&raster);
    return sound;
}
