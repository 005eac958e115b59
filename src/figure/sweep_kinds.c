/* Maps of what is counted rather than measured: classes, numbers of attractors, basins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What a point of a figure of basins is that belongs to no attractor; these kinds follow those of the
 * attractors. */
typedef enum plain_kind { plain_undecided, plain_failed, plain_pending, plain_kinds } plain_kind;

static bool open_kinds(saltus_map *map, int count) {
    map->kind_count = count;
    map->kinds = calloc((size_t)count, sizeof *map->kinds);
    map->kind = calloc((size_t)map->page->sweep->points, sizeof *map->kind);
    return map->kinds && map->kind;
}

static void name_kind(saltus_map_kind *kind, const char *label, uint32_t colour) {
    snprintf(kind->label, sizeof kind->label, "%s", label);
    kind->colour = colour;
}

/* Count the points of each kind and put the shares into the legend. */
static void add_shares(saltus_map *map) {
    long long points = map->page->sweep->points;
    for (long long p = 0; p < points; p++)
        map->kinds[map->kind[p]].count++;
    for (int k = 0; k < map->kind_count; k++) {
        double share = 100 * (double)map->kinds[k].count / (double)points;
        size_t used = strlen(map->kinds[k].figures);
        snprintf(map->kinds[k].figures + used, sizeof map->kinds[k].figures - used, "%s%.*f %%",
                 used ? ",  " : "", share < 9.95 ? 1 : 0, share);
    }
}

/* Words for a class in the legend. */
static void word_class(const saltus_sweep_file *sweep, const saltus_sweep_class *c, char label[64]) {
    bool measured = (sweep->options.keep & SALTUS_KEEP_LYAPUNOV) && sweep->options.measure > 0;
    if (c->verdict == SALTUS_UNDECIDED && !measured)
        snprintf(label, 64, "no period up to %d", sweep->options.longest);
    else if (c->verdict == SALTUS_LONG_PERIOD)
        snprintf(label, 64, "long period, or slow");
    else if (c->verdict == SALTUS_HELD)
        snprintf(label, 64, "held by the stop");
    else if (c->verdict == SALTUS_EQUILIBRIUM)
        snprintf(label, 64, "at rest, no contact");
    else if (c->verdict == SALTUS_PENDING)
        snprintf(label, 64, "not computed yet");
    else if (c->verdict == SALTUS_FAILED)
        snprintf(label, 64, "failed");
    else if (c->verdict == SALTUS_PERIODIC && c->impacts == 0)
        snprintf(label, 64, "%.31s  no impact", c->label);
    else
        snprintf(label, 64, "%.31s", c->label);
}

/* Names for what is lumped together: the other classes of each family. */
static void name_rest(saltus_map_kind *kinds, const int *others) {
    for (int f = 0; f < SALTUS_FAMILIES; f++) {
        char periods[32] = "{/:Italic p}";
        if (f > 0 && f < SALTUS_FAMILY_CHATTER)
            snprintf(periods, sizeof periods, "%d", f);
        snprintf(kinds[f].label, sizeof kinds[f].label,
                 f == SALTUS_FAMILY_CHATTER ? "%d other chatter" : "%d other {/:Italic n}/%s", others[f],
                 periods);
    }
}

/* Classes; those without an entry of their own are lumped together by families, in the last kinds. */
bool saltus_map_classes(saltus_map *map) {
    const saltus_sweep_page *page = map->page;
    const saltus_sweep_file *sweep = page->sweep;
    int others[SALTUS_FAMILIES] = {0}, rest = page->classes.count;
    int *target = calloc((size_t)rest, sizeof *target);
    map->several = calloc((size_t)sweep->points, 1);
    if (!target || !map->several || !open_kinds(map, rest + SALTUS_FAMILIES)) {
        free(target);
        return false;
    }
    for (int k = 0; k < rest; k++) {
        const saltus_sweep_class *c = &page->classes.list[k];
        target[k] = c->shown ? k : rest + saltus_class_family(c);
        map->kinds[target[k]].colour = c->colour;
        if (!c->shown) {
            others[saltus_class_family(c)]++;
            continue;
        }
        word_class(sweep, c, map->kinds[k].label);
        if (c->verdict == SALTUS_PERIODIC || c->verdict == SALTUS_CHAOTIC ||
            c->verdict == SALTUS_QUASIPERIODIC)
            snprintf(map->kinds[k].name, sizeof map->kinds[k].name, "%s", c->label);
    }
    name_rest(map->kinds + rest, others);
    for (long long p = 0; p < sweep->points; p++) {
        bool several;
        map->kind[p] = target[saltus_sweep_class_at(page, p, &several)];
        map->several[p] = several;
    }
    free(target);
    add_shares(map);
    return true;
}

/* How many attractors were met from a point: those told apart in one pass, or classes in several passes,
 * whichever is more. */
static int count_attractors(const saltus_sweep_page *page, long long point) {
    const saltus_sweep_file *sweep = page->sweep;
    int visits = saltus_sweep_visits(sweep), most = 0, distinct = 0;
    for (int k = 0; k < visits; k++) {
        long long row = saltus_sweep_visit(sweep, point, k);
        bool met = false;
        if (sweep->rows[row].attractor < 0 || sweep->rows[row].verdict == SALTUS_PENDING)
            continue;
        most = sweep->rows[row].attractor + 1 > most ? sweep->rows[row].attractor + 1 : most;
        for (int j = 0; j < k; j++)
            met =
                met || page->classes.of_row[saltus_sweep_visit(sweep, point, j)] == page->classes.of_row[row];
        distinct += !met;
    }
    return most > distinct ? most : distinct;
}

bool saltus_map_counts(saltus_map *map) {
    enum { most = 6 };
    static const uint32_t colours[most + 1] = {0xffffff, 0xe9edf1, 0xf2c14e, 0xe07b39,
                                               0xb23a48, 0x6d2e6b, 0x2b1b3d};
    if (!open_kinds(map, most + 1))
        return false;
    for (int k = 0; k <= most; k++) {
        char label[32];
        snprintf(label, sizeof label, "%d%s attractor%s", k, k == most ? " or more" : "", k == 1 ? "" : "s");
        name_kind(&map->kinds[k], k ? label : "none found", colours[k]);
    }
    for (long long p = 0; p < map->page->sweep->points; p++) {
        int count = count_attractors(map->page, p);
        map->kind[p] = count < most ? count : most;
    }
    add_shares(map);
    return true;
}

static uint32_t basin_colour(int attractor) {
    static const double hues[] = {250, 60, 160, 305, 95, 20, 205, 345, 130};
    enum { own = sizeof hues / sizeof hues[0] };
    return saltus_colour(attractor % 2 ? 0.66 : 0.56, attractor < own ? 0.12 : 0.06, hues[attractor % own]);
}

/* How pale a settled point is: the longer it took, the darker. */
static void shade_basins(saltus_map *map) {
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

bool saltus_map_basins(saltus_map *map) {
    const saltus_sweep_file *sweep = map->page->sweep;
    int n = sweep->attractor_count;
    map->number = calloc((size_t)sweep->points, sizeof *map->number);
    if (!map->number || !open_kinds(map, n + plain_kinds))
        return false;
    for (int k = 0; k < n; k++) {
        name_kind(&map->kinds[k], sweep->attractor_label[k], basin_colour(k));
        if (isfinite(sweep->attractor_multiplier[k]))
            snprintf(map->kinds[k].figures, sizeof map->kinds[k].figures, "|{/:Italic μ}| = %.3g",
                     sweep->attractor_multiplier[k]);
    }
    name_kind(&map->kinds[n + plain_undecided], "undecided", 0xc6c6c6);
    name_kind(&map->kinds[n + plain_failed], "beyond a stop, or failed", 0xffffff);
    name_kind(&map->kinds[n + plain_pending], "not computed yet", 0xffffff);
    for (long long p = 0; p < sweep->points; p++) {
        const saltus_sweep_row *row = &sweep->rows[saltus_sweep_visit(sweep, p, 0)];
        map->kind[p] = row->attractor >= 0              ? row->attractor
                       : row->verdict == SALTUS_FAILED  ? n + (int)plain_failed
                       : row->verdict == SALTUS_PENDING ? n + (int)plain_pending
                                                        : n + (int)plain_undecided;
    }
    shade_basins(map);
    add_shares(map);
    return true;
}

/* Which entry of a state a key names: q1, v1, z1, ...; negative or beyond the last one: none. */
static int entry_of(const saltus_map *map, const char *key) {
    int k = atoi(key + 1) - 1, dof = saltus_system_dof(map->page->system);
    return key[0] == 'z' ? k + 2 * dof : key[0] == 'v' ? k + dof : k;
}

void saltus_map_put_orbits(const saltus_map *map) {
    const saltus_sweep_file *sweep = map->page->sweep;
    int across = entry_of(map, sweep->axes[0].key), up = entry_of(map, sweep->axes[1].key);
    for (int k = 0; k < sweep->attractor_count; k++) {
        fprintf(map->page->file, "$orbit_%d << EOD\n# stroboscopic points of an attractor\nNaN NaN\n", k);
        for (long long p = 0; p < sweep->attractor_points[k]; p++) {
            const double *state =
                sweep->attractor_states + (sweep->attractor_first[k] + p) * sweep->dimension;
            if (across >= 0 && across < sweep->dimension && up >= 0 && up < sweep->dimension)
                fprintf(map->page->file, "%.9g %.9g\n", state[across], state[up]);
        }
        fputs("EOD\n", map->page->file);
    }
}

void saltus_map_put_orbit_elements(const saltus_map *map) {
    for (int k = 0; k < map->page->sweep->attractor_count; k++)
        fprintf(map->page->file,
                ", \\\n     $orbit_%d using 1:2 with points pt 7 ps 1.7 lc rgb '#ffffff' notitle"
                ", \\\n     $orbit_%d using 1:2 with points pt 7 ps 1.2 lc rgb '#%06x' notitle",
                k, k, (unsigned)map->kinds[k].colour);
}
