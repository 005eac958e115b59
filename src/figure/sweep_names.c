/* Names in the regions of a map: each region's own, where there is most room for it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "figure/sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Height of a letter over its width: how much more room a name takes across the page than up it. */
static const float squat = 1.9f;

/* Distances to the nearest place of another kind, in columns; going up a row counts as `squat` columns. */
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

/* Mark the connected region of one kind around `start`, and leave its places in `queue`. Returned is, of the
 * places with about the most room, the one nearest to the middle of the region. */
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

/* A name as large as its region allows, if it can be read at all. */
static void put_name(const saltus_sweep_page *page, const saltus_map_kind *kind, int columns, int rows,
                     int place, double room) {
    const double letter = 0.80, least = 10, most = 17; /* of a point of type, in pixels; sizes in points */
    double size = fmin(most, 2 * room / (letter * ((double)strlen(kind->name) + 0.6)));
    saltus_line name = {.length = 0};
    if (size < least)
        return;
    saltus_line_plain(&name, kind->name);
    fprintf(page->file, "set label '%s' at graph %.5f,%.5f center front font ':Bold,%.3g' tc rgb '%s'\n",
            name.text, (place % columns + 0.5) / columns, ((double)(place / columns) + 0.5) / rows, size,
            saltus_colour_light(kind->paint.colour) ? "#101010" : "#ffffff");
}

bool saltus_sweep_name_regions(const saltus_sweep_page *page, const saltus_map_kind *kinds, const int *kind,
                               int columns, int rows, int step) {
    size_t size = (size_t)columns * (size_t)rows;
    float *room = calloc(size, sizeof *room);
    unsigned char *seen = calloc(size, 1);
    int *queue = calloc(size, sizeof *queue);
    bool sound = room && seen && queue;
    if (sound)
        find_room(kind, columns, rows, room);
    for (size_t k = 0; k < size && sound; k++) {
        if (seen[k] || kind[k] < 0 || !*kinds[kind[k]].name)
            continue;
        int best = fill_region(kind, columns, rows, room, seen, queue, (int)k);
        put_name(page, &kinds[kind[k]], columns, rows, best, (double)step * room[best]);
    }
    free(room);
    free(seen);
    free(queue);
    return sound;
}
