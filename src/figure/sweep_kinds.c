/* What a map shows at each point of its grid: classes, numbers of attractors, basins, or measured numbers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep_map.h"

#include <gsl/gsl_sort_float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool open_kinds(saltus_sweep_map *map, int count) {
    map->kind_count = count;
    map->kinds = calloc((size_t)count, sizeof *map->kinds);
    map->kind = calloc((size_t)map->page->sweep->points, sizeof *map->kind);
    return map->kinds && map->kind;
}

static void name_kind(saltus_map_kind *kind, const char *label, saltus_paint paint) {
    snprintf(kind->label, sizeof kind->label, "%s", label);
    kind->paint = paint;
}

/* Count the visible points of each kind and write their shares into the legend. */
static void add_shares(saltus_sweep_map *map) {
    double all = 0;
    for (int row = 0; row < map->page->y.count; row++)
        for (int column = 0; column < map->page->x.count; column++) {
            long long point = saltus_sweep_point(map->page, column, row);
            double shown = saltus_sweep_shown(map->page, column, row);
            map->kinds[map->kind[point]].count += shown;
            map->any_several |= map->several && map->several[point] && shown > 0;
            all += shown;
        }
    for (int k = 0; k < map->kind_count; k++) {
        double share = all > 0 ? 100 * map->kinds[k].count / all : 0;
        size_t used = strlen(map->kinds[k].figures);
        const bool tiny = share < 0.05 && share > 0;
        snprintf(map->kinds[k].figures + used, sizeof map->kinds[k].figures - used, "%s%s%.*f %%",
                 used ? ",  " : "", tiny ? "< " : "", share < 9.95 ? 1 : 0, tiny ? 0.1 : share);
    }
}

void saltus_sweep_word_class(const saltus_sweep_class *c, char label[64]) {
    static const char *const words[SALTUS_VERDICTS] = {[SALTUS_LONG_PERIOD] = "long period, or slow",
                                                       [SALTUS_HELD] = "held by the stop",
                                                       [SALTUS_EQUILIBRIUM] = "at rest, no contact",
                                                       [SALTUS_PENDING] = "not computed yet"};
    if (words[c->verdict])
        snprintf(label, 64, "%s", words[c->verdict]);
    else
        snprintf(label, 64, "%.31s%s", c->label,
                 c->verdict == SALTUS_PERIODIC && c->impacts == 0 ? "  no impact" : "");
}

bool saltus_sweep_map_periodic(const saltus_sweep_map *map, int kind) {
    return map->page->view == SALTUS_VIEW_CLASS && map->page->classes.list[kind].verdict == SALTUS_PERIODIC;
}

/* The most frequent class among a point's rows that tell of a motion or, without any, the first that is not
 * pending; *several: the point has more than one attractor. */
static int class_at(const saltus_sweep_page *page, long long point, bool *several) {
    int visits = saltus_sweep_visits(page->sweep), most = 0, winner = -1, first = -1, nothing = -1;
    *several = false;
    for (int k = 0; k < visits; k++) {
        long long row = saltus_sweep_visit(page->sweep, point, k);
        const saltus_verdict verdict = (saltus_verdict)page->sweep->rows[row].verdict;
        int own = page->classes.of_row[row], same = 0;
        if (saltus_verdict_nothing(verdict)) {
            nothing = nothing < 0 && verdict != SALTUS_PENDING ? own : nothing;
            continue;
        }
        first = first < 0 ? own : first;
        for (int j = 0; j < visits; j++)
            same += page->classes.of_row[saltus_sweep_visit(page->sweep, point, j)] == own;
        *several |= (!page->sweep->basins && page->sweep->rows[row].attractor > 0) || own != first;
        if (same <= most)
            continue;
        most = same;
        winner = own;
    }
    return winner >= 0    ? winner
           : nothing >= 0 ? nothing
                          : page->classes.of_row[saltus_sweep_visit(page->sweep, point, 0)];
}

static bool find_classes(saltus_sweep_map *map) {
    const saltus_sweep_page *page = map->page;
    const saltus_sweep_file *sweep = page->sweep;
    map->several = calloc((size_t)sweep->points, 1);
    if (!map->several || !open_kinds(map, page->classes.count))
        return false;
    for (int k = 0; k < page->classes.count; k++) {
        const saltus_sweep_class *c = &page->classes.list[k];
        map->kinds[k].paint = c->paint;
        saltus_sweep_word_class(c, map->kinds[k].label);
        if (c->verdict == SALTUS_PERIODIC || c->verdict == SALTUS_CHAOTIC ||
            c->verdict == SALTUS_QUASIPERIODIC)
            snprintf(map->kinds[k].name, sizeof map->kinds[k].name, "%s", c->label);
    }
    for (long long p = 0; p < sweep->points; p++) {
        bool several;
        map->kind[p] = class_at(page, p, &several);
        map->several[p] = several;
    }
    add_shares(map);
    return true;
}

/* The number of attractors met at each point: the larger of those distinguished within one pass and the
 * classes over all passes. */
static bool find_counts(saltus_sweep_map *map) {
    enum { most = 6 };
    static const uint32_t colours[most + 1] = {0xffffff, 0xe9edf1, 0xf2c14e, 0xe07b39,
                                               0xb23a48, 0x6d2e6b, 0x2b1b3d};
    const saltus_sweep_file *sweep = map->page->sweep;
    const int *of_row = map->page->classes.of_row;
    if (!open_kinds(map, most + 1))
        return false;
    for (int k = 0; k <= most; k++) {
        char label[32];
        snprintf(label, sizeof label, "%d%s attractor%s", k, k == most ? " or more" : "", k == 1 ? "" : "s");
        name_kind(&map->kinds[k], k ? label : "none found", (saltus_paint){colours[k], 0});
    }
    for (long long p = 0; p < sweep->points; p++) {
        int within = 0, distinct = 0;
        for (int k = 0; k < saltus_sweep_visits(sweep); k++) {
            const long long row = saltus_sweep_visit(sweep, p, k);
            const saltus_sweep_row *told = &sweep->rows[row];
            bool met = false;
            if (told->attractor < 0 || told->verdict == SALTUS_PENDING)
                continue;
            within = told->attractor + 1 > within ? told->attractor + 1 : within;
            for (int j = 0; j < k; j++)
                met = met || of_row[saltus_sweep_visit(sweep, p, j)] == of_row[row];
            distinct += !met;
        }
        const int count = within > distinct ? within : distinct;
        map->kind[p] = count < most ? count : most;
    }
    add_shares(map);
    return true;
}

/* The class of an attractor's motion; NULL if no point leads to it. */
static const saltus_sweep_class *class_of(const saltus_sweep_map *map, int attractor) {
    const saltus_sweep_file *sweep = map->page->sweep;
    for (long long p = 0; p < sweep->points; p++) {
        long long row = saltus_sweep_visit(sweep, p, 0);
        if (sweep->rows[row].attractor == attractor)
            return &map->page->classes.list[map->page->classes.of_row[row]];
    }
    return NULL;
}

/* The paint of an attractor's basin: that of its motion; further attractors with the same label are darker
 * and have other textures. */
static saltus_paint basin_paint(const saltus_sweep_map *map, int attractor) {
    const saltus_sweep_file *sweep = map->page->sweep;
    const saltus_sweep_class *own = class_of(map, attractor);
    int twins = 0;
    saltus_paint paint = own ? own->paint : saltus_class_paint(SALTUS_UNDECIDED, 0, 0);
    for (int k = 0; k < attractor; k++)
        twins += strcmp(sweep->attractor_label[k], sweep->attractor_label[attractor]) == 0;
    paint.colour = saltus_colour_mix(paint.colour, 0x000000, twins / (twins + 1.5));
    paint.texture ^= twins % 2 ? SALTUS_POSTS : twins ? SALTUS_BARS : 0;
    return paint;
}

/* Shade the basins: the longer a point took to settle, the darker. */
static void shade_basins(saltus_sweep_map *map) {
    const double palest = 0.42;
    const saltus_sweep_file *sweep = map->page->sweep;
    double low = INFINITY, high = 0;
    for (long long p = 0; p < sweep->points; p++) {
        const saltus_sweep_row *row = &sweep->rows[saltus_sweep_visit(sweep, p, 0)];
        double taken = log((double)(row->settled > 1 ? row->settled : 1));
        map->number[p] = row->attractor >= 0 ? (float)taken : 0;
        low = row->attractor >= 0 ? fmin(low, taken) : low;
        high = row->attractor >= 0 ? fmax(high, taken) : high;
    }
    for (long long p = 0; p < sweep->points; p++)
        if (sweep->rows[saltus_sweep_visit(sweep, p, 0)].attractor >= 0)
            map->number[p] = high > low ? (float)(palest * (high - map->number[p]) / (high - low)) : 0;
}

static bool find_basins(saltus_sweep_map *map) {
    /* Kinds of points without an attractor, listed after the attractors. Other verdicts, of motions whose
     * attractor is not known, count as the first one. */
    static const struct {
        const char *label;
        int verdict;
    } plain[] = {{"undecided", SALTUS_UNDECIDED},
                 {"irregular", SALTUS_IRREGULAR},
                 {"failed", SALTUS_FAILED},
                 {"beyond a stop", SALTUS_BEYOND},
                 {"not computed yet", SALTUS_PENDING}};
    enum { plain_kinds = sizeof plain / sizeof plain[0] };
    const saltus_sweep_file *sweep = map->page->sweep;
    int n = sweep->attractor_count;
    map->number = calloc((size_t)sweep->points, sizeof *map->number);
    if (!map->number || !open_kinds(map, n + plain_kinds))
        return false;
    for (int k = 0; k < n; k++) {
        name_kind(&map->kinds[k], sweep->attractor_label[k], basin_paint(map, k));
        if (isfinite(sweep->attractor_multiplier[k])) {
            saltus_line figures = {.length = 0};
            saltus_line_number(&figures, "|{/:Italic μ}| = %.3g", sweep->attractor_multiplier[k]);
            memcpy(map->kinds[k].figures, figures.text, figures.length + 1);
        }
    }
    for (int k = 0; k < plain_kinds; k++)
        name_kind(&map->kinds[n + k], plain[k].label, saltus_class_paint(plain[k].verdict, 0, 0));
    for (long long p = 0; p < sweep->points; p++) {
        const long long row = saltus_sweep_visit(sweep, p, 0);
        const int verdict = sweep->rows[row].verdict;
        int k = plain_kinds - 1;
        while (k > 0 && plain[k].verdict != verdict)
            k--;
        map->kind[p] = sweep->rows[row].attractor >= 0 ? sweep->rows[row].attractor : n + k;
    }
    /* No shading if two attractors have the same period: their similar colours could not be distinguished. */
    map->shaded = true;
    for (int k = 0; k < n; k++)
        for (int j = 0; j < k; j++) {
            const saltus_sweep_class *a = class_of(map, k), *b = class_of(map, j);
            map->shaded = map->shaded && !(a && b && a->verdict == b->verdict && a->periods == b->periods);
        }
    if (map->shaded)
        shade_basins(map);
    add_shares(map);
    return true;
}

static bool find_numbers(saltus_sweep_map *map) {
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
        page->below = (long long)first;
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

bool saltus_sweep_map_open(saltus_sweep_map *map) {
    const saltus_view view = map->page->view;
    return (view == SALTUS_VIEW_CLASS        ? find_classes
            : view != SALTUS_VIEW_ATTRACTORS ? find_numbers
            : map->page->sweep->basins       ? find_basins
                                             : find_counts)(map);
}
