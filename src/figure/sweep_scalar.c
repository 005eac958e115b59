/* Measured numbers of a sweep over two axes as colours, with a colour bar.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep_map.h"

#include <gsl/gsl_sort_float.h>
#include <math.h>
#include <stdlib.h>

bool saltus_sweep_map_numbers(saltus_sweep_map *map) {
    const double rare = 0.005, far = 0.5, decades = 20;
    saltus_sweep_page *page = map->page;
    const saltus_sweep_file *sweep = page->sweep;
    const bool settling = page->view == SALTUS_VIEW_SETTLED;
    size_t points = (size_t)sweep->points, count = 0, first = 0;
    float *sorted = calloc(points, sizeof *sorted);
    map->number = calloc(points, sizeof *map->number);
    for (long long p = 0; p < sweep->points && sorted && map->number; p++) {
        map->number[p] =
            (float)saltus_sweep_measure(page->view, &sweep->rows[saltus_sweep_visit(sweep, p, 0)]);
        if (isfinite(map->number[p]))
            sorted[count++] = map->number[p];
    }
    bool sound = sorted && map->number;
    map->range = (saltus_range){0, 1};
    if (sound && count) {
        gsl_sort_float(sorted, 1, count);
        /* Values that are not positive get the colour of the smallest positive one. */
        while (page->logarithmic && first + 1 < count && sorted[first] <= 0)
            first++;
        /* The range of the colours: all values, but cut off at the quantiles `rare` and 1 - `rare` if only
         * few values lie far outside. */
        const double last = (double)(count - first - 1), low = sorted[first], high = sorted[count - 1],
                     inner_low = sorted[first + (size_t)(rare * last)],
                     inner_high = sorted[first + (size_t)((1 - rare) * last)], width = inner_high - inner_low;
        map->logarithmic =
            low > 0 && (page->logarithmic || (settling && inner_high > decades * fmax(inner_low, 1)));
        map->range = (saltus_range){low, high};
        if (!map->logarithmic && low < inner_low - far * width)
            map->range.low = inner_low;
        if (!map->logarithmic && high > inner_high + far * width)
            map->range.high = inner_high;
        if (map->logarithmic)
            saltus_range_floor(&map->range);
        bool counted = map->logarithmic && settling;
        if (counted)
            map->range.low = fmax(low, 1);
        map->clipped = map->range.low > low + (counted ? 1 : 0) || map->range.high < high;
        /* One number throughout is shown amid a range of its size; nothing at all begins a range from 0. */
        if (!(map->range.high > map->range.low) && high == 0)
            map->range.high = 1;
        if (!(map->range.high > map->range.low))
            saltus_range_pad(&map->range, 0, fabs(high) * 0.1);
    }
    if (page->asked) {
        map->range = page->up;
        map->clipped = count && (sorted[0] < page->up.low || sorted[count - 1] > page->up.high);
        map->logarithmic = map->logarithmic && page->up.low > 0;
    }
    free(sorted);
    return sound;
}

uint32_t saltus_sweep_map_colour(const saltus_sweep_map *map, double number) {
    double low = map->range.low, high = map->range.high;
    if (isinf(number))
        return 0x000000;
    if (map->logarithmic)
        return saltus_colour_ramp((log(fmax(number, low)) - log(low)) / (log(high) - log(low)));
    if (map->page->view != SALTUS_VIEW_LYAPUNOV)
        return saltus_colour_ramp((number - low) / (high - low));
    /* Attraction and repulsion: each side of zero is scaled to its own end. */
    return saltus_colour_sides(number < 0 ? 0.5 - 0.5 * number / fmin(low, -1e-300)
                                          : 0.5 + 0.5 * number / fmax(high, 1e-300));
}

enum { apart = 22, wide = 22 }; /* the colour bar: from the map, and its width */

static void name_bar(const saltus_sweep_map *map, saltus_line *name) {
    saltus_sweep_name_measure(map->page, name);
    if (map->clipped)
        saltus_line_add(name, "  (colours end at %s)",
                        map->page->asked ? "the range" : "the 0.5 and 99.5 percentiles");
}

double saltus_sweep_map_bar_room(const saltus_sweep_map *map) {
    const saltus_page *paper = &map->page->paper;
    const bool narrow = saltus_page_narrow(paper);
    saltus_line name = {.length = 0};
    name_bar(map, &name);
    /* On a narrow page a long name has two lines. */
    const double letter = 9.8, second = saltus_page_width(name.text, 11) > 0.5 * paper->width ? 44 : 0,
                 beside = apart + wide + (narrow ? 46 + second : 66);
    const size_t longest =
        map->logarithmic ? 4 : saltus_page_tic_letters(map->range, saltus_page_tic_step(map->range, 5));
    return fmax(narrow ? 160 : 180, beside + letter * (double)longest);
}

bool saltus_sweep_map_put_bar(const saltus_sweep_map *map) {
    enum { steps = 512, columns = 2 };
    const saltus_sweep_page *page = map->page;
    saltus_raster raster;
    saltus_line name = {.length = 0};
    if (!saltus_raster_open(&raster, columns, steps))
        return false;
    for (int k = 0; k < steps; k++) {
        double part = (k + 0.5) / steps;
        double number = saltus_range_value(map->range, map->logarithmic, part);
        for (int x = 0; x < columns; x++)
            saltus_raster_set(&raster, x, k, saltus_sweep_map_colour(map, number), 1);
    }
    name_bar(map, &name);
    saltus_page_frame(&page->paper,
                      (saltus_frame){page->frame.right + apart, page->frame.right + apart + wide,
                                     page->frame.bottom, page->frame.top},
                      SALTUS_PANEL_LEAST);
    fprintf(page->paper.file,
            "unset logscale\nunset xtics\nunset ytics\nunset xlabel\nunset ylabel\nset xrange [0:%d]\n"
            "set yrange [0:%d]\nset y2tics out nomirror scale 0.5 offset -0.4,0\n",
            columns, steps);
    saltus_page_axis(&page->paper, "y2", page->frame, map->logarithmic, name.text, map->range);
    fputs("plot ", page->paper.file);
    saltus_raster_element(page->paper.file, &raster, "x1y1");
    fputs(", NaN notitle axes x1y2\n", page->paper.file);
    saltus_raster_bytes(page->paper.file, &raster);
    saltus_raster_close(&raster);
    return true;
}
