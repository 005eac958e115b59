/* A result as one block of bytes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <stddef.h>
#include <string.h>

/* The head of the block; rows, states, counts and clouds follow, all aligned to 8 bytes. */
typedef struct head {
    long long place, seeds, dimension, entries[SALTUS_CLOUDS];
} head;

enum { part_head, part_rows, part_states, part_counts, part_clouds, parts = part_clouds + SALTUS_CLOUDS };

static head head_of(const saltus_sweep *sweep, const saltus_sweep_result *result) {
    head h = {.place = result->place, .seeds = sweep->options.seeds, .dimension = sweep->dimension};
    for (int s = 0; s < sweep->options.seeds; s++) {
        h.entries[SALTUS_CLOUD_TURNING] += result->turning_counts[s];
        h.entries[SALTUS_CLOUD_IMPACTS] += result->impact_counts[s];
        h.entries[SALTUS_CLOUD_STROBES] += result->strobe_counts[s];
    }
    return h;
}

/* Offsets of the parts, and the total size as the last one. */
static void place_parts(const head *h, size_t offset[parts + 1]) {
    size_t seeds = (size_t)h->seeds,
           size[parts] = {[part_head] = sizeof *h,
                          [part_rows] = seeds * sizeof(saltus_sweep_row),
                          [part_states] = seeds * (size_t)h->dimension * sizeof(double),
                          [part_counts] = SALTUS_CLOUDS * seeds * sizeof(long long)};
    for (int k = 0; k < SALTUS_CLOUDS; k++)
        size[part_clouds + k] = (size_t)h->entries[k] * saltus_cloud_entry(k, (int)h->dimension);
    offset[0] = 0;
    for (int k = 0; k < parts; k++)
        offset[k + 1] = offset[k] + size[k];
}

size_t saltus_sweep_packed_size(const saltus_sweep *sweep, const saltus_sweep_result *result) {
    head h = head_of(sweep, result);
    size_t offset[parts + 1];
    place_parts(&h, offset);
    return offset[parts];
}

static unsigned char *put(unsigned char *to, const void *from, size_t bytes) {
    if (bytes)
        memcpy(to, from, bytes);
    return to + bytes;
}

/* Padding of rows and impacts, after their last int, is zeroed: equal results give equal blocks. */
void saltus_sweep_pack(const saltus_sweep *sweep, const saltus_sweep_result *result, void *bytes) {
    enum {
        integers = offsetof(saltus_sweep_row, attractor) + sizeof(int),
        rest = offsetof(saltus_sweep_row, settled),
        impact = offsetof(saltus_sweep_impact, face) + sizeof(int)
    };
    head h = head_of(sweep, result);
    size_t n = (size_t)h.dimension, counts = (size_t)h.seeds * sizeof(long long);
    unsigned char *to = put(bytes, &h, sizeof h);
    for (long long s = 0; s < h.seeds; s++) {
        const unsigned char *row = (const unsigned char *)&result->rows[s];
        memset(put(to, row, integers), 0, rest - integers);
        to = put(to + rest, row + rest, sizeof *result->rows - rest);
    }
    to = put(to, result->states, (size_t)h.seeds * n * sizeof(double));
    to = put(to, result->turning_counts, counts);
    to = put(to, result->impact_counts, counts);
    to = put(to, result->strobe_counts, counts);
    to = put(to, result->turning, (size_t)h.entries[SALTUS_CLOUD_TURNING] * sizeof(double));
    for (long long k = 0; k < h.entries[SALTUS_CLOUD_IMPACTS]; k++) {
        memset(put(to, &result->impacts[k], impact), 0, sizeof *result->impacts - impact);
        to += sizeof *result->impacts;
    }
    put(to, result->strobes, (size_t)h.entries[SALTUS_CLOUD_STROBES] * n * sizeof(double));
}

/* Whether verdicts and periods are valid, and the seeds' counts add up to those of the head. */
static bool is_sound(const head *h, const saltus_sweep_row *rows, const long long *counts, int longest) {
    bool sound = true;
    for (long long s = 0; s < h->seeds; s++)
        sound &= rows[s].verdict >= 0 && rows[s].verdict < SALTUS_VERDICTS && rows[s].periods >= 0 &&
                 rows[s].periods <= longest;
    for (int k = 0; k < SALTUS_CLOUDS; k++) {
        long long left = h->entries[k];
        for (long long s = 0; s < h->seeds && sound; s++) {
            long long count = counts[k * h->seeds + s];
            sound = count >= 0 && count <= left;
            left -= sound ? count : 0;
        }
        sound &= left == 0;
    }
    return sound;
}

bool saltus_sweep_unpack(const saltus_sweep *sweep, const void *bytes, size_t size,
                         saltus_sweep_result *result) {
    const unsigned char *from = bytes;
    head h;
    if (size < sizeof h)
        return false;
    memcpy(&h, bytes, sizeof h);
    /* Refuse counts that cannot fit the block before computing sizes with them, which might overflow. */
    const long long most = (long long)(size / sizeof(double)) + 1;
    bool fits = h.place >= 0 && h.place < sweep->pass_count * sweep->points &&
                h.seeds == sweep->options.seeds && h.dimension == sweep->dimension;
    for (int k = 0; k < SALTUS_CLOUDS; k++)
        fits = fits && h.entries[k] >= 0 && h.entries[k] < most;
    size_t offset[parts + 1];
    if (!fits)
        return false;
    place_parts(&h, offset);
    if (offset[parts] != size)
        return false;
    const void *part[parts];
    for (int k = 0; k < parts; k++)
        part[k] = from + offset[k];
    const long long *counts = part[part_counts];
    *result = (saltus_sweep_result){.place = h.place,
                                    .rows = part[part_rows],
                                    .states = part[part_states],
                                    .turning_counts = counts + SALTUS_CLOUD_TURNING * h.seeds,
                                    .impact_counts = counts + SALTUS_CLOUD_IMPACTS * h.seeds,
                                    .strobe_counts = counts + SALTUS_CLOUD_STROBES * h.seeds,
                                    .turning = part[part_clouds + SALTUS_CLOUD_TURNING],
                                    .impacts = part[part_clouds + SALTUS_CLOUD_IMPACTS],
                                    .strobes = part[part_clouds + SALTUS_CLOUD_STROBES]};
    return is_sound(&h, result->rows, counts, sweep->options.longest);
}
