/* The data of a sweep as a figure shows it: axes as cells, rows as classes or numbers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep.h"

#include <math.h>
#include <stdlib.h>

static double place_of(const saltus_cells *cells, double value) {
    return cells->logarithmic ? log(value) : value;
}

/* A value with its index, for sorting. */
typedef struct ranked {
    double value;
    int index;
} ranked;

static int by_value(const void *a, const void *b) {
    const ranked *p = a, *q = b;
    return p->value != q->value ? (p->value > q->value) - (p->value < q->value)
                                : (p->index > q->index) - (p->index < q->index);
}

bool saltus_cells_open(saltus_cells *cells, const saltus_axis *axis, bool logarithmic) {
    const int n = axis->count;
    *cells = (saltus_cells){.key = axis->key, .count = n};
    cells->logarithmic = axis->spacing == SALTUS_LOGARITHMIC || logarithmic;
    cells->order = calloc((size_t)n, sizeof *cells->order);
    cells->edge = calloc((size_t)n + 1, sizeof *cells->edge);
    ranked *values = calloc((size_t)n, sizeof *values);
    bool sound = cells->order && cells->edge && values;
    for (int k = 0; k < n && sound; k++) {
        values[k] = (ranked){axis->list[k], k};
        cells->logarithmic = cells->logarithmic && axis->list[k] > 0;
    }
    if (sound) {
        /* Edges are halfway between neighbours; the outer cells are symmetric. */
        qsort(values, (size_t)n, sizeof *values, by_value);
        for (int k = 0; k < n; k++) {
            cells->order[k] = values[k].index;
            values[k].value = place_of(cells, values[k].value);
        }
        for (int k = 1; k < n; k++)
            cells->edge[k] = 0.5 * (values[k - 1].value + values[k].value);
        double first = values[0].value, last = values[n - 1].value, lone = 0.05 * fmax(fabs(first), 1e-3);
        cells->edge[0] = n > 1 ? 2 * first - cells->edge[1] : first - lone;
        cells->edge[n] = n > 1 ? 2 * last - cells->edge[n - 1] : last + lone;
        cells->range = (saltus_range){cells->edge[0], cells->edge[n]};
        if (cells->logarithmic)
            cells->range = (saltus_range){exp(cells->range.low), exp(cells->range.high)};
    }
    free(values);
    return sound;
}

void saltus_cells_close(saltus_cells *cells) {
    free(cells->order);
    free(cells->edge);
    *cells = (saltus_cells){0};
}

double saltus_cells_part(const saltus_cells *cells, double value) {
    double low = place_of(cells, cells->range.low), high = place_of(cells, cells->range.high);
    return (place_of(cells, value) - low) / (high - low);
}

double saltus_cells_value(const saltus_cells *cells, double part) {
    double low = place_of(cells, cells->range.low), high = place_of(cells, cells->range.high);
    double place = low + part * (high - low);
    return cells->logarithmic ? exp(place) : place;
}

double saltus_cells_edge(const saltus_cells *cells, int k) {
    return saltus_cells_part(cells, cells->logarithmic ? exp(cells->edge[k]) : cells->edge[k]);
}

/* The fraction of cell k in the range shown, from 0 to 1; 0 for slivers too thin to be visible. */
static double part_shown(const saltus_cells *cells, int k) {
    const double sliver = 5e-4; /* of the range */
    double low = saltus_cells_edge(cells, k), high = saltus_cells_edge(cells, k + 1),
           shown = fmin(high, 1) - fmax(low, 0), part = shown / (high - low);
    return part > 1 - 1e-6 ? 1 : shown > sliver ? part : 0;
}

/* The last cell that begins at or before a place. */
static int cell_before(const saltus_cells *cells, double place) {
    int low = 0, high = cells->count - 1;
    while (low < high) {
        int middle = (low + high + 1) / 2;
        if (cells->edge[middle] <= place)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

bool saltus_cells_at(const saltus_cells *cells, int pixels, int pixel, int *first, int *last) {
    double left = place_of(cells, saltus_cells_value(cells, (double)pixel / pixels)),
           right = place_of(cells, saltus_cells_value(cells, (pixel + 1.0) / pixels)),
           middle = 0.5 * (left + right);
    if (middle < cells->edge[0] || middle > cells->edge[cells->count])
        return false;
    *first = cell_before(cells, left);
    *last = cell_before(cells, right);
    while (*first < *last && 0.5 * (cells->edge[*first] + cells->edge[*first + 1]) < left)
        ++*first;
    while (*last > *first && 0.5 * (cells->edge[*last] + cells->edge[*last + 1]) >= right)
        --*last;
    double own = 0.5 * (cells->edge[*first] + cells->edge[*first + 1]);
    if (*first == *last && (own < left || own >= right))
        *first = *last = cell_before(cells, middle);
    return true;
}

static int by_share(const void *a, const void *b) {
    const saltus_sweep_class *p = a, *q = b;
    if (p->share != q->share)
        return (p->share < q->share) - (p->share > q->share);
    if (p->verdict != q->verdict)
        return p->verdict - q->verdict;
    return p->periods != q->periods ? p->periods - q->periods : p->impacts - q->impacts;
}

/* Each period has a hue, with a texture where hues look alike without red. Lightness counts impacts from one
 * to six; larger numbers start again with other textures. */
saltus_paint saltus_class_paint(int verdict, int impacts, int periods) {
    static const uint32_t plain[SALTUS_VERDICTS] = {
        [SALTUS_PENDING] = 0xffffff,       [SALTUS_EQUILIBRIUM] = 0x5d7f8c, [SALTUS_HELD] = 0x4b5963,
        [SALTUS_QUASIPERIODIC] = 0xb4e3d6, [SALTUS_CHAOTIC] = 0x17171a,     [SALTUS_LONG_PERIOD] = 0x97939c,
        [SALTUS_UNDECIDED] = 0xc6c6c6,     [SALTUS_FAILED] = 0xff2d78,      [SALTUS_TRANSIENT] = 0x6b6870,
        [SALTUS_IRREGULAR] = 0xa9b1be,     [SALTUS_BEYOND] = 0xf4f4f4};
    static const struct {
        double hue, lightness; /* for one impact */
        unsigned texture;
    } family[] = {{0, 0.84, SALTUS_BARS | SALTUS_POSTS}, /* chatter */
                  {255, 0.84, 0},
                  {80, 0.84, 0},
                  {300, 0.84, SALTUS_DOTS},
                  {165, 0.795, 0},
                  {45, 0.84, SALTUS_BARS},
                  {80, 0.795, SALTUS_DOTS},
                  {205, 0.795, SALTUS_BARS},
                  {120, 0.84, SALTUS_DOTS | SALTUS_BARS}};
    static const unsigned again[] = {0, SALTUS_POSTS, SALTUS_POSTS | SALTUS_BARS, SALTUS_POSTS | SALTUS_DOTS,
                                     SALTUS_POSTS | SALTUS_BARS | SALTUS_DOTS};
    enum { families = sizeof family / sizeof family[0], steps = 6, rounds = sizeof again / sizeof again[0] };
    if (verdict != SALTUS_PERIODIC)
        return (saltus_paint){plain[verdict], verdict == SALTUS_BEYOND   ? SALTUS_POSTS
                                              : verdict == SALTUS_FAILED ? SALTUS_DOTS
                                                                         : 0};
    bool own = impacts >= 0 && periods < families;
    int f = impacts < 0 ? 0 : own ? periods : families - 1, count = impacts < 0 ? periods : impacts;
    double hue = own || impacts < 0 ? family[f].hue : fmod(137.5 * periods, 360), chroma = own ? 0.12 : 0.06;
    if (count == 0)
        return (saltus_paint){saltus_colour(0.94, own ? 0.06 : 0.03, hue), family[f].texture};
    double lightness = family[f].lightness - 0.09 * ((count - 1) % steps);
    return (saltus_paint){saltus_colour(lightness, chroma, hue),
                          family[f].texture ^ again[(count - 1) / steps % rounds]};
}

uint32_t saltus_paint_at(saltus_paint paint, int x, int y) {
    enum { apart = 9 };
    const double ink = 0.22;
    int row = y / apart, shift = row % 2 * (apart / 2);
    bool marked = ((paint.texture & SALTUS_DOTS) && y % apart < 2 && (x + shift) % apart < 2) ||
                  ((paint.texture & SALTUS_BARS) && (y + 4) % apart == 0) ||
                  ((paint.texture & SALTUS_POSTS) && (x + 4) % apart == 0);
    return marked
               ? saltus_colour_mix(paint.colour, saltus_colour_light(paint.colour) ? 0x000000 : 0xffffff, ink)
               : paint.colour;
}

static bool is_of(const saltus_sweep_row *row, const saltus_sweep_class *c) {
    return row->verdict == c->verdict &&
           (row->verdict != SALTUS_PERIODIC || (row->impacts == c->impacts && row->periods == c->periods));
}

bool saltus_classes_open(saltus_classes *classes, const saltus_sweep_file *sweep) {
    const size_t rows = (size_t)sweep->row_count;
    size_t room = 64;
    *classes = (saltus_classes){.list = calloc(room, sizeof *classes->list),
                                .of_row = calloc(rows, sizeof *classes->of_row)};
    bool sound = classes->list && classes->of_row;
    for (size_t row = 0, k = 0; row < rows && sound; row++) {
        const saltus_sweep_row *own = &sweep->rows[row];
        /* Neighbours are mostly of one class. */
        if (!is_of(own, &classes->list[k]))
            for (k = 0; k < (size_t)classes->count && !is_of(own, &classes->list[k]);)
                k++;
        if (k + 1 == room) {
            saltus_sweep_class *longer = realloc(classes->list, 2 * room * sizeof *longer);
            if (!(sound = longer != NULL))
                break;
            classes->list = longer;
            room *= 2;
        }
        saltus_sweep_class *c = &classes->list[k];
        if (k == (size_t)classes->count) {
            const bool periodic = own->verdict == SALTUS_PERIODIC;
            *c = (saltus_sweep_class){.verdict = own->verdict,
                                      .impacts = periodic ? own->impacts : 0,
                                      .periods = periodic ? own->periods : 0,
                                      .first = classes->count++};
            c->paint = saltus_class_paint(c->verdict, c->impacts, c->periods);
            saltus_sweep_label(own, c->label);
        }
        classes->of_row[row] = (int)k;
        c->share += 1.0 / (double)rows;
    }
    int *moved = sound ? calloc((size_t)classes->count + 1, sizeof *moved) : NULL;
    if (moved)
        qsort(classes->list, (size_t)classes->count, sizeof *classes->list, by_share);
    for (int k = 0; k < classes->count && moved; k++)
        moved[classes->list[k].first] = k;
    for (size_t row = 0; row < rows && moved; row++)
        classes->of_row[row] = moved[classes->of_row[row]];
    free(moved);
    return moved != NULL;
}

void saltus_classes_close(saltus_classes *classes) {
    free(classes->list);
    free(classes->of_row);
    *classes = (saltus_classes){0};
}

const char *saltus_view_word(saltus_view view) {
    static const char *const words[] = {"automatic",  "turning",  "impacts", "stroboscopic", "class",
                                        "attractors", "largest",  "rms",     "speed",        "rate",
                                        "contact",    "lyapunov", "settled"};
    return words[view];
}

bool saltus_view_is_cloud(saltus_view view) {
    return view == SALTUS_VIEW_TURNING || view == SALTUS_VIEW_IMPACTS || view == SALTUS_VIEW_STROBOSCOPIC;
}

double saltus_sweep_measure(saltus_view view, const saltus_sweep_row *row) {
    const double numbers[] = {
        [SALTUS_VIEW_CLASS] = row->periods,     [SALTUS_VIEW_LARGEST] = row->largest,
        [SALTUS_VIEW_RMS] = row->rms,           [SALTUS_VIEW_SPEED] = row->largest_speed,
        [SALTUS_VIEW_RATE] = row->impact_rate,  [SALTUS_VIEW_CONTACT] = row->contact_fraction,
        [SALTUS_VIEW_LYAPUNOV] = row->lyapunov, [SALTUS_VIEW_SETTLED] = (double)row->settled};
    if (saltus_verdict_nothing((saltus_verdict)row->verdict) ||
        (view == SALTUS_VIEW_CLASS && row->verdict != SALTUS_PERIODIC) ||
        (view == SALTUS_VIEW_SETTLED && !saltus_verdict_settled(row->verdict)))
        return NAN;
    return numbers[view];
}

bool saltus_sweep_any_lost(const saltus_sweep_page *page) {
    bool lost = false;
    for (long long k = 0; k < page->sweep->row_count; k++)
        lost |= saltus_sweep_measure(SALTUS_VIEW_LYAPUNOV, &page->sweep->rows[k]) == -INFINITY;
    return lost;
}

long long saltus_sweep_point(const saltus_sweep_page *page, int column, int row) {
    long long across = page->x.order[column], up = page->y.order[row];
    return page->wish->look.swap ? up + across * page->y.count : across + up * page->x.count;
}

double saltus_sweep_shown(const saltus_sweep_page *page, int column, int row) {
    return part_shown(&page->x, column) * part_shown(&page->y, row);
}

int saltus_sweep_visits(const saltus_sweep_file *sweep) {
    return sweep->pass_count * sweep->options.seeds;
}

long long saltus_sweep_visit(const saltus_sweep_file *sweep, long long point, int k) {
    int seeds = sweep->options.seeds;
    return ((k / seeds) * sweep->points + point) * seeds + k % seeds;
}
