/* What a figure shows of a sweep: axes as cells, rows as classes or as numbers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep.h"

#include <math.h>
#include <stdlib.h>

static double place_of(const saltus_cells *cells, double value) {
    return cells->logarithmic ? log(value) : value;
}

/* A value with its index, to be sorted. */
typedef struct ranked {
    double value;
    int index;
} ranked;

static int by_value(const void *a, const void *b) {
    const ranked *p = a, *q = b;
    return p->value != q->value ? (p->value > q->value) - (p->value < q->value)
                                : (p->index > q->index) - (p->index < q->index);
}

/* Edges half way between neighbours; the outer cells are as wide outwards as inwards. */
static void set_edges(saltus_cells *cells, const ranked *values) {
    int n = cells->count;
    for (int k = 1; k < n; k++)
        cells->edge[k] = 0.5 * (place_of(cells, values[k - 1].value) + place_of(cells, values[k].value));
    double first = place_of(cells, values[0].value), last = place_of(cells, values[n - 1].value);
    double lone = 0.05 * fmax(fabs(first), 1e-3);
    cells->edge[0] = n > 1 ? 2 * first - cells->edge[1] : first - lone;
    cells->edge[n] = n > 1 ? 2 * last - cells->edge[n - 1] : last + lone;
    cells->range = (saltus_range){cells->edge[0], cells->edge[n]};
    if (cells->logarithmic)
        cells->range = (saltus_range){exp(cells->range.low), exp(cells->range.high)};
}

bool saltus_cells_open(saltus_cells *cells, const saltus_axis *axis) {
    size_t n = (size_t)axis->count;
    *cells = (saltus_cells){.key = axis->key, .count = axis->count};
    cells->logarithmic = axis->spacing == SALTUS_LOGARITHMIC;
    cells->order = calloc(n, sizeof *cells->order);
    cells->edge = calloc(n + 1, sizeof *cells->edge);
    ranked *values = calloc(n, sizeof *values);
    bool sound = cells->order && cells->edge && values;
    for (size_t k = 0; k < n && sound; k++) {
        values[k] = (ranked){axis->list[k], (int)k};
        cells->logarithmic = cells->logarithmic && axis->list[k] > 0;
    }
    if (sound) {
        qsort(values, n, sizeof *values, by_value);
        for (size_t k = 0; k < n; k++)
            cells->order[k] = values[k].index;
        set_edges(cells, values);
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

/* What tells classes apart, as one number. */
static uint64_t key_of(const saltus_sweep_row *row) {
    bool periodic = row->verdict == SALTUS_PERIODIC;
    return (uint64_t)(unsigned)row->verdict << 56 | (periodic ? (uint64_t)(unsigned)row->periods << 36 : 0) |
           (periodic ? (uint64_t)(unsigned)(row->impacts + 1) : 0);
}

static int by_key(const void *a, const void *b) {
    const uint64_t *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

static int by_share(const void *a, const void *b) {
    const saltus_sweep_class *p = a, *q = b;
    if (p->share != q->share)
        return (p->share < q->share) - (p->share > q->share);
    if (p->verdict != q->verdict)
        return p->verdict - q->verdict;
    return p->periods != q->periods ? p->periods - q->periods : p->impacts - q->impacts;
}

/* Keep one of each of the sorted keys, in place; their number. */
static int unify(uint64_t *keys, long long count) {
    int distinct = 0;
    for (long long k = 0; k < count; k++)
        if (distinct == 0 || keys[k] != keys[distinct - 1])
            keys[distinct++] = keys[k];
    return distinct;
}

static int index_of(const uint64_t *keys, int count, uint64_t key) {
    return (int)((const uint64_t *)bsearch(&key, keys, (size_t)count, sizeof key, by_key) - keys);
}

/* Whether a class comes before another of the same period in the order of shades: fewer impacts. */
static bool paler(const saltus_sweep_class *a, const saltus_sweep_class *b) {
    return a->verdict == SALTUS_PERIODIC && a->shown && (a->impacts < 0) == (b->impacts < 0) &&
           (a->impacts < 0 ? a->periods < b->periods
                           : a->periods == b->periods && a->impacts > 0 && a->impacts < b->impacts);
}

/* Classes of one period that hardly occur take less of the range of shades than the others. */
static double step_of(const saltus_sweep_class *c, double most) {
    const double rare = 0.03, part = 0.3;
    return c->share < rare * most ? part : 1;
}

/* Where a class stands among the shades of its period, from 0 (few impacts) to 1. */
static double shade_of(const saltus_classes *classes, const saltus_sweep_class *c) {
    double most = c->share, before = 0, after = 0;
    for (int k = 0; k < classes->count; k++)
        if (paler(&classes->list[k], c) || paler(c, &classes->list[k]))
            most = fmax(most, classes->list[k].share);
    for (int k = 0; k < classes->count; k++) {
        const saltus_sweep_class *other = &classes->list[k];
        before += paler(other, c) ? step_of(other, most) : 0;
        after += other->shown && paler(c, other) ? step_of(other, most) : 0;
    }
    double own = step_of(c, most);
    return (before + 0.5 * own) / (before + own + after);
}

/* Hues of the families: periods 1 to 8, chatter. */
static const double family_hues[SALTUS_FAMILIES] = {0, 255, 55, 155, 300, 100, 25, 205, 128, 350};

int saltus_class_family(const saltus_sweep_class *c) {
    return c->impacts < 0 ? (int)SALTUS_FAMILY_CHATTER : c->periods < SALTUS_FAMILY_CHATTER ? c->periods : 0;
}

/* Hue tells the period and lightness the number of impacts, from few to many in equal steps; motions with
 * complete chatter have a hue of their own. */
static uint32_t shade(const saltus_classes *classes, const saltus_sweep_class *c) {
    int family = saltus_class_family(c);
    double hue = family ? family_hues[family] : fmod(137.5 * c->periods, 360);
    double chroma = family == SALTUS_FAMILY_CHATTER ? 0.17 : family ? 0.135 : 0.07;
    if (c->impacts == 0)
        return saltus_colour(0.945, 0.03, hue);
    double place = shade_of(classes, c);
    return saltus_colour(0.88 - 0.54 * place, chroma, hue + 24 * (place - 0.5));
}

/* Every class with a colour of its own, the most frequent n/p among them; the others share one with those of
 * their family. */
static void set_colours(saltus_classes *classes) {
    static const uint32_t plain[SALTUS_VERDICTS] = {
        [SALTUS_PENDING] = 0xffffff,     [SALTUS_PERIODIC] = 0xa08f78,      [SALTUS_EQUILIBRIUM] = 0x5d7f8c,
        [SALTUS_HELD] = 0x4b5963,        [SALTUS_QUASIPERIODIC] = 0xb4e3d6, [SALTUS_CHAOTIC] = 0x17171a,
        [SALTUS_LONG_PERIOD] = 0x97939c, [SALTUS_UNDECIDED] = 0xc6c6c6,     [SALTUS_FAILED] = 0xff2d78,
        [SALTUS_TRANSIENT] = 0x6b6870};
    int shown = 0;
    for (int k = 0; k < classes->count; k++) {
        saltus_sweep_class *c = &classes->list[k];
        c->colour = plain[c->verdict];
        int family = c->verdict == SALTUS_PERIODIC ? saltus_class_family(c) : 0;
        if (family)
            c->colour = saltus_colour(0.5, 0.055, family_hues[family]);
        c->shown = c->verdict != SALTUS_PERIODIC || shown < SALTUS_CLASSES_SHOWN;
        shown += c->verdict == SALTUS_PERIODIC;
    }
    for (int k = 0; k < classes->count; k++)
        if (classes->list[k].verdict == SALTUS_PERIODIC && classes->list[k].shown)
            classes->list[k].colour = shade(classes, &classes->list[k]);
}

/* Fill the list of classes, the most frequent first, and note the class of each row. */
static bool fill(saltus_classes *classes, const saltus_sweep_file *sweep, const uint64_t *keys) {
    int n = classes->count, *moved = calloc((size_t)n, sizeof *moved);
    for (long long row = 0; row < sweep->row_count && moved; row++) {
        int k = index_of(keys, n, key_of(&sweep->rows[row]));
        saltus_sweep_class *c = &classes->list[k];
        classes->of_row[row] = k;
        if (c->share == 0) {
            saltus_sweep_label(&sweep->rows[row], c->label);
            c->verdict = sweep->rows[row].verdict;
            c->impacts = c->verdict == SALTUS_PERIODIC ? sweep->rows[row].impacts : 0;
            c->periods = c->verdict == SALTUS_PERIODIC ? sweep->rows[row].periods : 0;
        }
        c->share += 1.0 / (double)sweep->row_count;
    }
    if (moved) {
        qsort(classes->list, (size_t)n, sizeof *classes->list, by_share);
        for (int k = 0; k < n; k++) {
            const saltus_sweep_class *c = &classes->list[k];
            const saltus_sweep_row row = {
                .verdict = c->verdict, .impacts = c->impacts, .periods = c->periods};
            moved[index_of(keys, n, key_of(&row))] = k;
        }
        for (long long row = 0; row < sweep->row_count; row++)
            classes->of_row[row] = moved[classes->of_row[row]];
        set_colours(classes);
    }
    free(moved);
    return moved != NULL;
}

bool saltus_classes_open(saltus_classes *classes, const saltus_sweep_file *sweep) {
    *classes = (saltus_classes){0};
    uint64_t *keys = calloc((size_t)sweep->row_count, sizeof *keys);
    classes->of_row = calloc((size_t)sweep->row_count, sizeof *classes->of_row);
    bool sound = keys && classes->of_row;
    for (long long row = 0; row < sweep->row_count && sound; row++)
        keys[row] = key_of(&sweep->rows[row]);
    if (sound) {
        qsort(keys, (size_t)sweep->row_count, sizeof *keys, by_key);
        classes->count = unify(keys, sweep->row_count);
        classes->list = calloc((size_t)classes->count, sizeof *classes->list);
        sound = classes->list && fill(classes, sweep, keys);
    }
    free(keys);
    return sound;
}

void saltus_classes_close(saltus_classes *classes) {
    free(classes->list);
    free(classes->of_row);
    *classes = (saltus_classes){0};
}

const char *saltus_view_word(saltus_view view) {
    static const char *const words[] = {"automatic", "turning",    "impacts",  "stroboscopic",
                                        "class",     "attractors", "largest",  "speed",
                                        "rate",      "contact",    "lyapunov", "settled"};
    return words[view];
}

bool saltus_view_is_cloud(saltus_view view) {
    return view == SALTUS_VIEW_TURNING || view == SALTUS_VIEW_IMPACTS || view == SALTUS_VIEW_STROBOSCOPIC;
}

double saltus_sweep_measure(saltus_view view, const saltus_sweep_row *row) {
    if (row->verdict == SALTUS_PENDING || row->verdict == SALTUS_FAILED)
        return NAN;
    switch (view) {
    case SALTUS_VIEW_CLASS:
        return row->verdict == SALTUS_PERIODIC ? row->periods : NAN;
    case SALTUS_VIEW_LARGEST:
        return row->largest;
    case SALTUS_VIEW_SPEED:
        return row->largest_speed;
    case SALTUS_VIEW_RATE:
        return row->impact_rate;
    case SALTUS_VIEW_CONTACT:
        return row->contact_fraction;
    case SALTUS_VIEW_LYAPUNOV:
        return row->lyapunov;
    case SALTUS_VIEW_SETTLED:
        return saltus_verdict_settled(row->verdict) ? (double)row->settled : NAN;
    default:
        return NAN;
    }
}

int saltus_sweep_visits(const saltus_sweep_file *sweep) {
    return sweep->pass_count * sweep->options.seeds;
}

long long saltus_sweep_visit(const saltus_sweep_file *sweep, long long point, int k) {
    int seeds = sweep->options.seeds;
    return ((k / seeds) * sweep->points + point) * seeds + k % seeds;
}

int saltus_sweep_class_at(const saltus_sweep_page *page, long long point, bool *several) {
    int visits = saltus_sweep_visits(page->sweep), most = 0, winner = -1, first = -1;
    *several = false;
    for (int k = 0; k < visits; k++) {
        long long row = saltus_sweep_visit(page->sweep, point, k);
        int own = page->classes.of_row[row], same = 0;
        if (page->sweep->rows[row].verdict == SALTUS_PENDING)
            continue;
        first = first < 0 ? own : first;
        for (int j = 0; j < visits; j++)
            same += page->classes.of_row[saltus_sweep_visit(page->sweep, point, j)] == own;
        *several |= (!page->sweep->basins && page->sweep->rows[row].attractor > 0) || own != first;
        if (same <= most)
            continue;
        most = same;
        winner = own;
    }
    return winner >= 0 ? winner : page->classes.of_row[saltus_sweep_visit(page->sweep, point, 0)];
}
