/* A result as one block of bytes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/sweep.h"

#include <string.h>

/* What stands at the block's begin; rows, states, counts and clouds follow, all of them aligned to 8 bytes.
 */
typedef struct head {
    long long place, seeds, dimension, turning, impacts, strobes;
} head;

static head head_of(const saltus_sweep *sweep, const saltus_sweep_result *result) {
    head h = {.place = result->place, .seeds = sweep->options.seeds, .dimension = sweep->dimension};
    for (int s = 0; s < sweep->options.seeds; s++) {
        h.turning += result->turning_counts[s];
        h.impacts += result->impact_counts[s];
        h.strobes += result->strobe_counts[s];
    }
    return h;
}

enum { parts = 8 };

/* Sizes of the parts in their order. */
static void sizes_of(const head *h, size_t size[parts]) {
    size_t seeds = (size_t)h->seeds, n = (size_t)h->dimension;
    size[0] = sizeof *h;
    size[1] = seeds * sizeof(saltus_sweep_row);
    size[2] = seeds * n * sizeof(double);
    size[3] = 3 * seeds * sizeof(long long);
    size[4] = (size_t)h->turning * sizeof(double);
    size[5] = (size_t)h->impacts * sizeof(saltus_sweep_impact);
    size[6] = (size_t)h->strobes * n * sizeof(double);
    size[7] = 0;
}

size_t saltus_sweep_packed_size(const saltus_sweep *sweep, const saltus_sweep_result *result) {
    head h = head_of(sweep, result);
    size_t size[parts], sum = 0;
    sizes_of(&h, size);
    for (int k = 0; k < parts; k++)
        sum += size[k];
    return sum;
}

static unsigned char *put(unsigned char *to, const void *from, size_t bytes) {
    if (bytes)
        memcpy(to, from, bytes);
    return to + bytes;
}

/* Member by member, so that no byte of padding is left to chance. */
static unsigned char *put_row(unsigned char *to, const saltus_sweep_row *r) {
    saltus_sweep_row clean;
    memset(&clean, 0, sizeof clean);
    clean.verdict = r->verdict;
    clean.impacts = r->impacts;
    clean.periods = r->periods;
    clean.sticking = r->sticking;
    clean.attractor = r->attractor;
    clean.settled = r->settled;
    clean.settled_impacts = r->settled_impacts;
    clean.recorded = r->recorded;
    clean.largest = r->largest;
    clean.smallest = r->smallest;
    clean.impact_rate = r->impact_rate;
    clean.largest_speed = r->largest_speed;
    clean.contact_fraction = r->contact_fraction;
    clean.lyapunov = r->lyapunov;
    clean.lyapunov_error = r->lyapunov_error;
    return put(to, &clean, sizeof clean);
}

static unsigned char *put_impact(unsigned char *to, const saltus_sweep_impact *i) {
    saltus_sweep_impact clean;
    memset(&clean, 0, sizeof clean);
    clean.phase = i->phase;
    clean.speed = i->speed;
    clean.face = i->face;
    return put(to, &clean, sizeof clean);
}

void saltus_sweep_pack(const saltus_sweep *sweep, const saltus_sweep_result *result, void *bytes) {
    head h = head_of(sweep, result);
    size_t size[parts], counts = (size_t)h.seeds * sizeof(long long);
    sizes_of(&h, size);
    unsigned char *to = put(bytes, &h, size[0]);
    for (long long s = 0; s < h.seeds; s++)
        to = put_row(to, &result->rows[s]);
    to = put(to, result->states, size[2]);
    to = put(to, result->turning_counts, counts);
    to = put(to, result->impact_counts, counts);
    to = put(to, result->strobe_counts, counts);
    to = put(to, result->turning, size[4]);
    for (long long k = 0; k < h.impacts; k++)
        to = put_impact(to, &result->impacts[k]);
    put(to, result->strobes, size[6]);
}

/* Whether the counts of the seeds are sound and add up to those of the head. */
static bool counts_agree(const head *h, const long long *counts) {
    const long long whole[3] = {h->turning, h->impacts, h->strobes};
    for (int k = 0; k < 3; k++) {
        long long sum = 0;
        for (long long s = 0; s < h->seeds; s++) {
            long long count = counts[k * h->seeds + s];
            if (count < 0 || count > whole[k] - sum)
                return false;
            sum += count;
        }
        if (sum != whole[k])
            return false;
    }
    return true;
}

static bool rows_sound(const saltus_sweep_row *rows, long long seeds, int longest) {
    for (long long s = 0; s < seeds; s++)
        if (rows[s].verdict < 0 || rows[s].verdict >= SALTUS_VERDICTS || rows[s].periods < 0 ||
            rows[s].periods > longest)
            return false;
    return true;
}

bool saltus_sweep_unpack(const saltus_sweep *sweep, const void *bytes, size_t size,
                         saltus_sweep_result *result) {
    const unsigned char *from = bytes;
    head h;
    if (size < sizeof h)
        return false;
    memcpy(&h, bytes, sizeof h);
    const long long most = (long long)(size / sizeof(double)) + 1;
    bool fits = h.place >= 0 && h.place < sweep->pass_count * sweep->points &&
                h.seeds == sweep->options.seeds && h.dimension == sweep->dimension && h.turning >= 0 &&
                h.impacts >= 0 && h.strobes >= 0 && h.turning < most && h.impacts < most && h.strobes < most;
    size_t part[parts], offset[parts] = {0};
    if (!fits)
        return false;
    sizes_of(&h, part);
    for (int k = 1; k < parts; k++)
        offset[k] = offset[k - 1] + part[k - 1];
    if (offset[parts - 1] != size)
        return false;
    const long long *counts = (const long long *)(const void *)(from + offset[3]);
    *result = (saltus_sweep_result){.place = h.place,
                                    .rows = (const saltus_sweep_row *)(const void *)(from + offset[1]),
                                    .states = (const double *)(const void *)(from + offset[2]),
                                    .turning_counts = counts,
                                    .impact_counts = counts + h.seeds,
                                    .strobe_counts = counts + 2 * h.seeds,
                                    .turning = (const double *)(const void *)(from + offset[4]),
                                    .impacts = (const saltus_sweep_impact *)(const void *)(from + offset[5]),
                                    .strobes = (const double *)(const void *)(from + offset[6])};
    return counts_agree(&h, counts) && rows_sound(result->rows, h.seeds, sweep->options.longest);
}
