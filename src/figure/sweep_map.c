/* Maps of sweeps over two axes: classes, numbers of attractors, basins, and measured numbers in colours.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Step between the cells sampled for a pixel along one axis: about `looks` samples. */
static int stride(saltus_pixel_cells span) {
    enum { looks = 6 };
    return 1 + (span.last - span.first) / looks;
}

/* The most frequent kind among a pixel's cells, -1 if there are none; *point: a point of that kind. */
static int kind_at(const saltus_sweep_map *map, saltus_pixel_cells column, saltus_pixel_cells row,
                   long long *point) {
    enum { most_looks = 64 };
    int seen[most_looks], counts[most_looks], distinct = 0, best = 0;
    long long points[most_looks];
    if (column.first < 0 || row.first < 0)
        return -1;
    for (int j = row.first; j <= row.last; j += stride(row))
        for (int i = column.first; i <= column.last; i += stride(column)) {
            long long own = saltus_sweep_point(map->page, i, j);
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

/* Paint a pixel with its kind, hatched if the point has more than one attractor. */
static void paint_kind(saltus_sweep_map *map, int x, int y, int fineness) {
    enum { hatch = 10 };
    const double ink = 0.3;
    long long point = -1;
    int kind = kind_at(map, map->columns[x], map->rows[y], &point);
    if (kind < 0)
        return;
    uint32_t colour = saltus_paint_at(map->kinds[kind].paint, x / fineness, y / fineness);
    if (map->number)
        colour = saltus_colour_mix(colour, 0xffffff, map->number[point]);
    if (map->several && map->several[point] && (x + y) / fineness % hatch == 0)
        colour = saltus_colour_mix(colour, saltus_colour_light(colour) ? 0x000000 : 0xffffff, ink);
    saltus_raster_set(&map->raster, x, y, colour, 1);
}

/* Why a point has no number: not computed, failed, beyond a stop, or otherwise undecided. */
static int without_number(const saltus_sweep_map *map, long long point) {
    const saltus_sweep_file *sweep = map->page->sweep;
    const int verdict = sweep->rows[saltus_sweep_visit(sweep, point, 0)].verdict;
    return saltus_verdict_nothing((saltus_verdict)verdict) ? verdict : SALTUS_UNDECIDED;
}

/* The colour of a number. */
static uint32_t colour_of(const saltus_sweep_map *map, double number) {
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

/* Paint a pixel with the mean of the numbers in its cells or, where they have none, with the reason. */
static void paint_number(saltus_sweep_map *map, int x, int y, int fineness) {
    const saltus_pixel_cells column = map->columns[x], row = map->rows[y];
    long long point = -1;
    double sum = 0;
    int count = 0;
    for (int j = row.first; column.first >= 0 && row.first >= 0 && j <= row.last; j += stride(row))
        for (int i = column.first; i <= column.last; i += stride(column)) {
            point = saltus_sweep_point(map->page, i, j);
            if (isnan(map->number[point]))
                continue;
            sum += map->number[point];
            count++;
        }
    if (point >= 0)
        saltus_raster_set(&map->raster, x, y,
                          count ? colour_of(map, sum / count)
                                : saltus_paint_at(saltus_class_paint(without_number(map, point), 0, 0),
                                                  x / fineness, y / fineness),
                          1);
}

static bool paint(saltus_sweep_map *map) {
    const saltus_sweep_page *page = map->page;
    int fineness = saltus_sweep_fineness(page),
        width = (int)fmax(1, fineness * (page->frame.right - page->frame.left)),
        height = (int)fmax(1, fineness * (page->frame.top - page->frame.bottom));
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
                paint_number(map, x, y, fineness);
        }
    return true;
}

/* Names in the regions: one per region, where it has most room. */

enum { step = 4 }; /* pixels between grid places for names */

/* Height over width of a letter: names need more room horizontally than vertically. */
static const float squat = 1.9f;

/* Distance of each place to the nearest place of another kind, in columns; one row counts as `squat`
 * columns. */
static void find_room(const int *kind, int columns, int rows, float *room) {
    for (int sweep = 0; sweep < 2; sweep++)
        for (int n = 0; n < columns * rows; n++) {
            int k = sweep ? columns * rows - 1 - n : n, x = k % columns, y = k / columns;
            float least = sweep ? room[k] : (float)columns;
            for (int dy = -1; dy <= 1; dy++)
                for (int dx = -1; dx <= 1; dx++) {
                    int j = (y + dy) * columns + x + dx;
                    bool inside = x + dx >= 0 && x + dx < columns && y + dy >= 0 && y + dy < rows,
                         done = sweep ? j > k : j < k;
                    float step = dy ? squat : 1;
                    if ((!dx && !dy) || (inside && !done && kind[j] == kind[k]))
                        continue;
                    least = fminf(least, inside && kind[j] == kind[k] ? room[j] + step : step);
                }
            room[k] = least;
        }
}

/* Mark the connected region of one kind around `start` in `seen` and list its places in `queue`. Returns,
 * among the places with about the most room, the one nearest to the region's centre. */
static int fill_region(const int *kind, int columns, int rows, const float *room, unsigned char *seen,
                       int *queue, int start) {
    int count = 0, best = start;
    double across = 0, up = 0, nearest = INFINITY;
    float most = 0;
    queue[count++] = start;
    seen[start] = 1;
    for (int n = 0; n < count; n++) {
        int k = queue[n], x = k % columns, y = k / columns;
        const int near[4] = {x > 0 ? k - 1 : k, x + 1 < columns ? k + 1 : k, y > 0 ? k - columns : k,
                             y + 1 < rows ? k + columns : k};
        most = fmaxf(most, room[k]);
        across += x;
        up += y;
        for (int i = 0; i < 4; i++) {
            int j = near[i];
            if (seen[j] || kind[j] != kind[start])
                continue;
            seen[j] = 1;
            queue[count++] = j;
        }
    }
    for (int n = 0; n < count; n++) {
        int k = queue[n];
        double away = hypot(k % columns - across / count, squat * (k / columns - up / count));
        if (room[k] < 0.9f * most || away >= nearest)
            continue;
        nearest = away;
        best = k;
    }
    return best;
}

/* Write names into the regions of a map, each as large as its region allows, unless it would be illegible.
 * `kind` has columns x rows entries, lowest row first, -1 where nothing may be written. False if out of
 * memory. */
static bool name_regions(const saltus_sweep_page *page, const saltus_map_kind *kinds, const int *kind,
                         int columns, int rows) {
    const double letter = 0.80, least = 10, most = 17; /* letter width in pixels per point of type; sizes in
                                                          points */
    size_t size = (size_t)columns * (size_t)rows;
    float *room = calloc(size, sizeof *room);
    unsigned char *seen = calloc(size, 1);
    int *queue = calloc(size, sizeof *queue);
    bool sound = room && seen && queue;
    if (sound)
        find_room(kind, columns, rows, room);
    for (size_t k = 0; k < size && sound; k++) {
        const saltus_map_kind *own = kind[k] < 0 ? NULL : &kinds[kind[k]];
        if (seen[k] || !own || !*own->name)
            continue;
        const int place = fill_region(kind, columns, rows, room, seen, queue, (int)k);
        const double wide = 2 * ((double)step * room[place]) / (letter * ((double)strlen(own->name) + 0.6));
        saltus_line name = {.length = 0};
        if (wide < least)
            continue;
        saltus_line_plain(&name, own->name);
        saltus_page_graph_label(&page->paper, &name, (place % columns + 0.5) / columns,
                                ((double)(place / columns) + 0.5) / rows, 5,
                                "center front font ':Bold,%.3g' tc rgb '%s'", fmin(most, wide),
                                saltus_colour_light(own->paint.colour) ? "#101010" : "#ffffff");
    }
    free(room);
    free(seen);
    free(queue);
    return sound;
}

/* The grid of places for names, with the kind at each. */
typedef struct lookout {
    int *kind, columns, rows;
} lookout;

/* Reserve a frame taken by something else. */
static void block(void *context, saltus_frame taken) {
    const lookout *at = context;
    int left = (int)fmax(taken.left / step, 0), bottom = (int)fmax(taken.bottom / step, 0);
    for (int y = bottom; y < at->rows && y * step < taken.top; y++)
        for (int x = left; x < at->columns && x * step < taken.right; x++)
            at->kind[y * at->columns + x] = -1;
}

/* The names of regions, and those of the curves drawn over them. */
static bool put_names(const saltus_sweep_map *map) {
    int fineness = saltus_sweep_fineness(map->page), columns = map->raster.width / (step * fineness),
        rows = map->raster.height / (step * fineness);
    const bool named = map->page->view == SALTUS_VIEW_CLASS;
    lookout at = {named ? calloc((size_t)columns * (size_t)rows, sizeof *at.kind) : NULL, columns, rows};
    for (int y = 0; y < rows && at.kind; y++)
        for (int x = 0; x < columns; x++) {
            long long point;
            int column = (2 * x + 1) * step * fineness / 2, row = (2 * y + 1) * step * fineness / 2;
            at.kind[y * columns + x] = kind_at(map, map->columns[column], map->rows[row], &point);
        }
    saltus_plot_labels(&map->page->over, at.kind ? block : NULL, &at);
    bool sound = !named || (at.kind && name_regions(map->page, map->kinds, at.kind, columns, rows));
    free(at.kind);
    return sound;
}

/* Assign places in a legend of `most` entries, the most frequent kinds first; returns how many have one. If
 * there are too few, rare periodic motions are left out; other kinds keep their entries. */
static int find_places(saltus_sweep_map *map, int most) {
    enum { none = -1, open = -2 };
    int others = 0, periodic = 0, places = 0, best;
    for (int k = 0; k < map->kind_count; k++) {
        map->kinds[k].place = map->kinds[k].count > 0 ? open : none;
        others += map->kinds[k].count > 0 && !saltus_sweep_map_periodic(map, k);
    }
    do {
        best = -1;
        for (int k = 0; k < map->kind_count; k++)
            if (map->kinds[k].place == open && (best < 0 || map->kinds[k].count > map->kinds[best].count))
                best = k;
        if (best >= 0)
            map->kinds[best].place =
                saltus_sweep_map_periodic(map, best) && periodic++ >= most - others ? none : places++;
    } while (best >= 0);
    return places;
}

/* The height of a line of notes below a legend. */
static const double note_height = 26;

static void put_note(const saltus_sweep_map *map, double x, double y, const char *text) {
    const saltus_page *paper = &map->page->paper;
    saltus_page_label(paper, text, x, y, "left front font ',%.4g' tc rgb '#606060'",
                      saltus_page_type(paper, 11));
}

/* What the signs in the map mean, in up to two notes; returns their number. */
static int find_notes(const saltus_sweep_map *map, const char *notes[2]) {
    const saltus_sweep_page *page = map->page;
    int count = 0;
    if (page->view == SALTUS_VIEW_CLASS)
        notes[count++] =
            saltus_system_forced(page->system)
                ? "{/:Italic n}/{/:Italic p}: {/:Italic n} impacts in {/:Italic p} periods {/:Italic T}"
                : "{/:Italic n}/{/:Italic p}: {/:Italic n} impacts in {/:Italic p} returns to the section";
    else if (page->sweep->basins && page->sweep->attractor_count) {
        notes[count++] = page->sweep->dimension > 2 ? "dots: the orbits at phase 0, projected"
                                                    : "dots: the orbits at phase 0";
        if (map->shaded)
            notes[count++] = "pale: soon settled";
    }
    return count;
}

/* The legend, most frequent kinds first, beside the map or on a narrow page in three columns below it;
 * omitted kinds are counted in one entry. */
static void put_legend(saltus_sweep_map *map) {
    const double row = 32, side = 28, bottom = 60;
    const saltus_sweep_page *page = map->page;
    const char *notes[2];
    const int note_count = find_notes(map, notes), columns = map->legend_rows > 0 ? 3 : 1;
    const bool below = columns > 1;
    const double x = below ? 12 : page->frame.right + side, width = (page->paper.width - 12) / 3,
                 top = below ? (map->legend_rows - 0.6) * row + (note_count ? note_height : 0)
                             : page->frame.top - 18;
    int most = below ? columns * map->legend_rows : (int)((top - bottom) / row), rest = 0,
        entries = map->any_several;
    for (int k = 0; k < map->kind_count; k++)
        entries += map->kinds[k].count > 0;
    int places = find_places(map, most - map->any_several - (entries > most));
    double shown = 0, left_out = 0;
    for (int k = 0; k < map->kind_count; k++) {
        const saltus_map_kind *kind = &map->kinds[k];
        shown += kind->count;
        if (kind->place >= 0)
            saltus_sweep_put_entry(page, x + kind->place % columns * width, top - kind->place / columns * row,
                                   kind->paint, false, kind->label, below ? "" : kind->figures);
        else if (kind->count > 0) {
            rest++;
            left_out += kind->count;
        }
    }
    /* The notes stand one above the other over the legend, or below it in one line. */
    saltus_line together = {.length = 0};
    for (int k = 0; k < note_count; k++) {
        if (!below)
            put_note(map, x, top + 46 + 24 * (note_count - 1 - k), notes[k]);
        saltus_line_add(&together, "%s%s", k ? ";  " : "", notes[k]);
    }
    if (below)
        put_note(map, x, 0.6 * note_height, together.text);
    if (map->any_several) {
        saltus_sweep_put_entry(
            page, x + places % columns * width, top - places / columns * row - (below ? 0 : row / 4),
            (saltus_paint){0xffffff, 0}, true, below ? "2+ attractors" : "more than one attractor", "");
        places++;
    }
    if (rest) {
        char text[64];
        const double share = left_out * (100 / shown);
        snprintf(text, sizeof text, "%d more%s, %.*f %%", rest, below ? "" : " motions", share < 9.95 ? 1 : 0,
                 share);
        put_note(map, x + places % columns * width, top - places / columns * row + (below ? 9 : 0), text);
    }
}

/* The orbits of basins as points in the plane. */
static void put_orbits(const saltus_sweep_map *map) {
    const saltus_sweep_page *page = map->page;
    const saltus_sweep_file *sweep = page->sweep;
    FILE *file = page->paper.file;
    const int across = saltus_system_state_index(page->system, page->x.key),
              up = saltus_system_state_index(page->system, page->y.key);
    for (int k = 0; k < sweep->attractor_count; k++) {
        fprintf(file, "$orbit_%d << EOD\n# stroboscopic points of an attractor\nNaN NaN\n", k);
        for (long long p = 0; p < sweep->attractor_points[k]; p++) {
            const double *state =
                sweep->attractor_states + (sweep->attractor_first[k] + p) * sweep->dimension;
            if (across >= 0 && up >= 0)
                fprintf(file, "%.9g %.9g\n", state[across], state[up]);
        }
        fputs("EOD\n", file);
    }
}

/* Names, marks, the map itself, its axes and anything drawn over it. */
static bool put_panel(saltus_sweep_map *map) {
    const saltus_sweep_page *page = map->page;
    FILE *file = page->paper.file;
    saltus_page_frame(&page->paper, page->frame, SALTUS_PANEL_LEAST);
    saltus_sweep_put_axis(page, "x", &page->x);
    saltus_sweep_put_axis(page, "y", &page->y);
    saltus_sweep_put_raster_ranges(file, map->raster.width, map->raster.height);
    if (map->kind)
        put_legend(map);
    else {
        /* Explain, above the map, those colours for points without a number that occur. */
        bool measured = page->view == SALTUS_VIEW_LYAPUNOV;
        const char *const words[] = {"not computed yet", "failed", "beyond a stop",
                                     measured ? "not measured" : "no period found"};
        static const int verdicts[] = {SALTUS_PENDING, SALTUS_FAILED, SALTUS_BEYOND, SALTUS_UNDECIDED};
        bool narrow = saltus_page_narrow(&page->paper);
        double x = narrow ? 12 : 48, y = page->paper.top - 8;
        for (int k = 0; k < 4; k++) {
            bool occurs = false;
            for (int row = 0; row < page->y.count && !occurs; row++)
                for (int column = 0; column < page->x.count && !occurs; column++) {
                    long long point = saltus_sweep_point(page, column, row);
                    occurs = isnan(map->number[point]) && saltus_sweep_shown(page, column, row) > 0 &&
                             without_number(map, point) == verdicts[k];
                }
            if (!occurs)
                continue;
            saltus_sweep_put_entry(page, x, y, saltus_class_paint(verdicts[k], 0, 0), false, words[k], "");
            x += narrow ? 165 : 240;
        }
    }
    bool sound = put_names(map);
    fputs("unset grid\nset border 15\nplot ", file);
    saltus_raster_element(file, &map->raster, "x2y2");
    const bool basins = page->view == SALTUS_VIEW_ATTRACTORS && page->sweep->basins;
    for (int k = 0; k < page->sweep->attractor_count && basins; k++)
        fprintf(file,
                ", \\\n     $orbit_%d using 1:2 with points pt 7 ps 1.7 lc rgb '#%s' notitle"
                ", \\\n     $orbit_%d using 1:2 with points pt 7 ps 1.2 lc rgb '#%06x' notitle",
                k, saltus_colour_light(map->kinds[k].paint.colour) ? "101010" : "ffffff", k,
                (unsigned)map->kinds[k].paint.colour);
    if (page->over.count) {
        fputs(", \\\n", file);
        saltus_plot_elements(&page->over);
    } else
        fputs(", NaN notitle\n", file);
    saltus_raster_bytes(file, &map->raster);
    saltus_page_template(&page->paper, "close");
    return sound;
}

enum { bar_apart = 22, bar_wide = 22 }; /* the colour bar: from the map, and its width */

static void name_bar(const saltus_sweep_map *map, saltus_line *name) {
    saltus_sweep_name_measure(map->page, name);
    if (map->clipped)
        saltus_line_add(name, "  (colours end at %s)",
                        map->page->asked ? "the range" : "the 0.5 and 99.5 percentiles");
}

/* The width that the colour bar needs beside the map, with its numbers and its name. */
static double bar_room(const saltus_sweep_map *map) {
    const saltus_page *paper = &map->page->paper;
    const bool narrow = saltus_page_narrow(paper);
    saltus_line name = {.length = 0};
    name_bar(map, &name);
    /* On a narrow page a long name has two lines. */
    const double letter = 9.8, second = saltus_page_width(name.text, 11) > 0.5 * paper->width ? 44 : 0,
                 beside = bar_apart + bar_wide + (narrow ? 46 + second : 66);
    const size_t longest =
        map->logarithmic ? 4 : saltus_page_tic_letters(map->range, saltus_page_tic_step(map->range, 5));
    return fmax(narrow ? 160 : 180, beside + letter * (double)longest);
}

static bool put_bar(const saltus_sweep_map *map) {
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
            saltus_raster_set(&raster, x, k, colour_of(map, number), 1);
    }
    name_bar(map, &name);
    saltus_page_frame(&page->paper,
                      (saltus_frame){page->frame.right + bar_apart, page->frame.right + bar_apart + bar_wide,
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

saltus_status saltus_sweep_put_map(saltus_sweep_page *page, saltus_message *message) {
    saltus_sweep_map map = {.page = page};
    saltus_page *paper = &page->paper;
    const bool basins = page->view == SALTUS_VIEW_ATTRACTORS && page->sweep->basins,
               narrow = saltus_page_narrow(paper);
    bool sound = saltus_sweep_map_open(&map);
    for (int k = 0, entries = sound && map.any_several; sound && narrow && map.kind && k < map.kind_count;
         k++) {
        entries += map.kinds[k].count > 0;
        map.legend_rows = (entries < 18 ? entries + 2 : 18) / 3;
    }
    const char *notes[2];
    const double below =
        32 * map.legend_rows + (map.legend_rows && find_notes(&map, notes) ? note_height : 0);
    const double left = narrow ? 124 : 150, right = paper->width - (!map.kind ? bar_room(&map)
                                                                    : narrow  ? 24
                                                                              : 410);
    if (paper->free_height) {
        paper->height += below;
        if (page->over.count)
            paper->height += saltus_plot_legend(&page->over, right - left, false);
    }
    saltus_sweep_caption(page);
    saltus_page_begin(paper);
    if (sound && basins)
        put_orbits(&map);
    fputs("set multiplot\n", page->paper.file);
    saltus_page_caption(paper);
    page->frame = saltus_page_rest(paper, map.kind ? 26.4 : 38.4);
    page->frame.left = left;
    page->frame.right = right;
    page->frame.bottom += narrow ? below : 2.4;
    if (page->over.count)
        page->frame.top -= saltus_plot_legend(&page->over, right - left, true);
    page->over.frame = page->frame;
    if (page->over.count)
        sound = saltus_plot_data(&page->over) && sound;
    sound = sound && paint(&map) && put_panel(&map) && (map.kind || put_bar(&map));
    fputs("unset multiplot\n", page->paper.file);
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
