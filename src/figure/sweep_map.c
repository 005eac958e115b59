/* Maps of sweeps over two axes: classes, numbers of attractors, basins, and measures in colours.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Point of the grid at a cell of each axis. */
static long long point_of(const saltus_map *map, int column, int row) {
    return map->page->x.order[column] + (long long)map->page->y.order[row] * map->page->x.count;
}

/* Step between the cells that are looked at for a pixel along one axis: about `looks` of them. */
static int stride(saltus_span span) {
    enum { looks = 6 };
    return 1 + (span.last - span.first) / looks;
}

/* The kind that most cells of a pixel have, -1 where there are none; *point: one of these cells' points. */
static int kind_at(const saltus_map *map, saltus_span column, saltus_span row, long long *point) {
    enum { most_looks = 64 };
    int seen[most_looks], counts[most_looks], distinct = 0, best = 0;
    long long points[most_looks];
    if (column.first < 0 || row.first < 0)
        return -1;
    for (int j = row.first; j <= row.last; j += stride(row))
        for (int i = column.first; i <= column.last; i += stride(column)) {
            long long own = point_of(map, i, j);
            int k = 0;
            while (k < distinct && seen[k] != map->kind[own])
                k++;
            if (k == distinct && distinct < most_looks) {
                seen[k] = map->kind[own];
                counts[k] = 0;
                points[k] = own;
                distinct++;
            }
            if (k < distinct && ++counts[k] > counts[best])
                best = k;
        }
    *point = points[best];
    return seen[best];
}

/* The mean of the numbers of a pixel's cells; NAN where there are none. *point: one of these. */
static double number_at(const saltus_map *map, saltus_span column, saltus_span row, long long *point) {
    double sum = 0;
    int count = 0;
    *point = -1;
    for (int j = row.first; column.first >= 0 && row.first >= 0 && j <= row.last; j += stride(row))
        for (int i = column.first; i <= column.last; i += stride(column)) {
            double number = map->number[ *point = point_of(map, i, j)];
            if (isnan(number))
                continue;
            sum += number;
            count++;
        }
    return count ? sum / count : NAN;
}

static uint32_t mix(uint32_t a, uint32_t b, double part) {
    uint32_t mixed = 0;
    for (int k = 16; k >= 0; k -= 8)
        mixed = mixed << 8 | (uint32_t)lround((1 - part) * (a >> k & 0xff) + part * (b >> k & 0xff));
    return mixed;
}

/* A pixel of one kind; lines across it where there is more than one attractor. */
static void paint_kind(saltus_map *map, int x, int y, int fineness) {
    enum { hatch = 10 };
    const double ink = 0.3;
    long long point = -1;
    int kind = kind_at(map, map->columns[x], map->rows[y], &point);
    if (kind < 0)
        return;
    uint32_t colour = map->kinds[kind].colour;
    if (map->number)
        colour = mix(colour, 0xffffff, map->number[point]);
    if (map->several && map->several[point] && (x + y) / fineness % hatch == 0)
        colour = mix(colour, saltus_colour_light(colour) ? 0x000000 : 0xffffff, ink);
    saltus_raster_set(&map->raster, x, y, colour, 1);
}

/* Colour of a point that has no number: not computed, failed, or nothing to tell. */
static uint32_t without_number(const saltus_map *map, long long point) {
    const saltus_sweep_file *sweep = map->page->sweep;
    int verdict = sweep->rows[saltus_sweep_visit(sweep, point, 0)].verdict;
    return verdict == SALTUS_PENDING ? 0xffffff : verdict == SALTUS_FAILED ? 0xff2d78 : 0xc6c6c6;
}

static void paint_number(saltus_map *map, int x, int y) {
    long long point;
    double number = number_at(map, map->columns[x], map->rows[y], &point);
    if (point >= 0)
        saltus_raster_set(&map->raster, x, y,
                          isnan(number) ? without_number(map, point) : saltus_map_colour(map, number), 1);
}

static bool paint(saltus_map *map) {
    const saltus_sweep_page *page = map->page;
    int fineness = saltus_sweep_fineness(page), width = fineness * (page->frame.right - page->frame.left),
        height = fineness * (page->frame.top - page->frame.bottom);
    map->columns = calloc((size_t)width, sizeof *map->columns);
    map->rows = calloc((size_t)height, sizeof *map->rows);
    if (!map->columns || !map->rows || !saltus_raster_open(&map->raster, width, height))
        return false;
    for (int x = 0; x < width; x++)
        if (!saltus_cells_at(&page->x, width, x, &map->columns[x].first, &map->columns[x].last))
            map->columns[x].first = -1;
    for (int y = 0; y < height; y++)
        if (!saltus_cells_at(&page->y, height, y, &map->rows[y].first, &map->rows[y].last))
            map->rows[y].first = -1;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            if (map->kind)
                paint_kind(map, x, y, fineness);
            else
                paint_number(map, x, y);
        }
    return true;
}

/* The names of regions, looked for at a few pixels' distance. */
static bool put_names(const saltus_map *map) {
    enum { step = 4 };
    int fineness = saltus_sweep_fineness(map->page), columns = map->raster.width / (step * fineness),
        rows = map->raster.height / (step * fineness);
    int *kind = calloc((size_t)columns * (size_t)rows, sizeof *kind);
    for (int y = 0; y < rows && kind; y++)
        for (int x = 0; x < columns; x++) {
            long long point;
            int column = (2 * x + 1) * step * fineness / 2, row = (2 * y + 1) * step * fineness / 2;
            kind[y * columns + x] = kind_at(map, map->columns[column], map->rows[row], &point);
        }
    bool sound = kind && saltus_sweep_name_regions(map->page, map->kinds, kind, columns, rows, step);
    free(kind);
    return sound;
}

/* Whether any point shown has more than one attractor. */
static bool any_several(const saltus_map *map) {
    return map->several && memchr(map->several, 1, (size_t)map->page->sweep->points);
}

/* How many kinds come before one in the legend: those of more points. */
static int rank_of(const saltus_map *map, int k) {
    int before = 0;
    for (int j = 0; j < map->kind_count; j++)
        before += map->kinds[j].count > map->kinds[k].count ||
                  (map->kinds[j].count == map->kinds[k].count && j < k);
    return before;
}

static void put_note(const saltus_map *map, int x, int y, const char *text) {
    fprintf(map->page->file, "set label '%s' at screen %.6f,%.6f left front font ',11' tc rgb '#606060'\n",
            text, (double)x / SALTUS_PAGE_WIDTH, (double)y / SALTUS_PAGE_HEIGHT);
}

/* What the signs in the map mean, above the legend. */
static void put_heading(const saltus_map *map, int x, int y) {
    enum { line_height = 24 };
    const saltus_sweep_page *page = map->page;
    if (page->view == SALTUS_VIEW_CLASS)
        put_note(map, x, y,
                 "{/:Italic n}/{/:Italic p}: {/:Italic n} impacts in {/:Italic p} periods {/:Italic T}");
    else if (page->sweep->basins) {
        put_note(map, x, y + line_height,
                 page->sweep->dimension > 2 ? "dots: the orbits at phase 0, projected"
                                            : "dots: the orbits at phase 0");
        put_note(map, x, y, "pale: soon settled");
    }
}

/* The legend beside the map, most frequent first. */
static void put_legend(const saltus_map *map) {
    enum { row_height = 32, side = 28, most = 26 };
    const saltus_sweep_page *page = map->page;
    int x = page->frame.right + side, top = page->frame.top - 18, rows = 0;
    for (int k = 0; k < map->kind_count; k++) {
        int rank = rank_of(map, k);
        if (map->kinds[k].count == 0 || rank >= most)
            continue;
        saltus_sweep_put_entry(page->file, x, top - rank * row_height, map->kinds[k].colour, false,
                               map->kinds[k].label, map->kinds[k].figures);
        rows = rank + 1 > rows ? rank + 1 : rows;
    }
    put_heading(map, x, top + 46);
    if (any_several(map))
        saltus_sweep_put_entry(page->file, x, top - rows * row_height - row_height / 4, 0xffffff, true,
                               "more than one attractor", "");
}

/* What the colours without number mean, above the map, as far as they occur. */
static void put_exceptions(const saltus_map *map) {
    enum { apart = 240 };
    bool measured = map->page->view == SALTUS_VIEW_LYAPUNOV;
    const char *const words[] = {"not computed yet", "failed", measured ? "not measured" : "no period found"};
    static const uint32_t colours[] = {0xffffff, 0xff2d78, 0xc6c6c6};
    int x = 48, y = (int)(map->page->caption * SALTUS_PAGE_HEIGHT) - 8;
    for (int k = 0; k < 3; k++) {
        bool occurs = false;
        for (long long p = 0; p < map->page->sweep->points && !occurs; p++)
            occurs = isnan(map->number[p]) && without_number(map, p) == colours[k];
        if (!occurs)
            continue;
        saltus_sweep_put_entry(map->page->file, x, y, colours[k], false, words[k], "");
        x += apart;
    }
}

/* Names, marks, the map itself and its axes. */
static bool put_panel(const saltus_map *map) {
    const saltus_sweep_page *page = map->page;
    FILE *file = page->file;
    saltus_sweep_put_frame(file, page->frame);
    saltus_sweep_put_axis(page, 'x', &page->x);
    saltus_sweep_put_axis(page, 'y', &page->y);
    saltus_sweep_put_raster_ranges(file, map->raster.width, map->raster.height);
    if (map->kind)
        put_legend(map);
    else
        put_exceptions(map);
    bool sound = page->view != SALTUS_VIEW_CLASS || put_names(map);
    fputs("unset grid\nset border 15\nplot ", file);
    saltus_raster_element(file, &map->raster, "x2y2");
    if (page->view == SALTUS_VIEW_ATTRACTORS && page->sweep->basins)
        saltus_map_put_orbit_elements(map);
    fputs(", NaN notitle\n", file);
    saltus_raster_bytes(file, &map->raster);
    fputs("unset label\nunset object\nunset arrow\n", file);
    return sound;
}

static bool fill(saltus_map *map) {
    if (map->page->view == SALTUS_VIEW_CLASS)
        return saltus_map_classes(map);
    if (map->page->view == SALTUS_VIEW_ATTRACTORS)
        return map->page->sweep->basins ? saltus_map_basins(map) : saltus_map_counts(map);
    return saltus_map_numbers(map);
}

saltus_status saltus_sweep_put_map(saltus_sweep_page *page, saltus_message *message) {
    enum { left = 150, bottom = 96, legend = 1190, bar = 1420 };
    saltus_map map = {.page = page};
    bool sound = fill(&map), basins = page->view == SALTUS_VIEW_ATTRACTORS && page->sweep->basins;
    if (sound && basins)
        saltus_map_put_orbits(&map);
    fputs("set multiplot\n", page->file);
    saltus_sweep_caption(page);
    page->frame = (saltus_frame){left, map.kind ? legend : bar, bottom,
                                 (int)((page->caption - 0.022) * SALTUS_PAGE_HEIGHT) - (map.kind ? 0 : 12)};
    sound = sound && paint(&map) && put_panel(&map) && (map.kind || saltus_map_put_bar(&map));
    fputs("unset multiplot\n", page->file);
    saltus_raster_close(&map.raster);
    free(map.columns);
    free(map.rows);
    free(map.kind);
    free(map.number);
    free(map.several);
    free(map.kinds);
    return sound ? SALTUS_OK
                 : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for drawing %.200s", page->path);
}
