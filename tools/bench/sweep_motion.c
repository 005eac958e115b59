/* Records of motions and their comparison.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep.h"

#include <gsl/gsl_sort.h>
#include <limits.h>
#include <math.h>
#include <string.h>

/* With a multiplier near a root of unity, a motion slowly approaching an orbit of one period nearly repeats
 * after several periods much earlier. It is still closing if its error after one period exceeds that after
 * several by less than this factor. */
static const double still_closing = 100;

void motion_clear(motion *m) {
    m->count = 0;
    m->sticks = 0;
    m->orbit_impacts = m->orbit_periods = 0;
    m->failed = false;
}

void motion_free(motion *m) {
    free(m->impacts);
    free(m->strobe);
    *m = (motion){0};
}

void motion_add_impact(motion *m, double time) {
    if (m->count == m->room) {
        int room = m->room ? 2 * m->room : 256;
        double *impacts = realloc(m->impacts, (size_t)room * sizeof *impacts);
        if (!impacts) {
            m->failed = true;
            return;
        }
        m->impacts = impacts;
        m->room = room;
    }
    m->impacts[m->count++] = time;
}

static bool recurs(const motion *m, const double *scale, int period, double tolerance) {
    bool same = true;
    for (int k = 0; k + period <= recorded_periods && same; k++)
        for (int i = 0; i < motion_dimension && same; i++)
            same = fabs(m->strobe[k][i] - m->strobe[k + period][i]) / scale[i] <= tolerance;
    return same;
}

int motion_period(const motion *m, const double *scale, double tolerance) {
    int period = 1, part = 1;
    while (2 * period <= recorded_periods && !recurs(m, scale, period, tolerance))
        period++;
    if (2 * period > recorded_periods)
        return 0;
    while (period % part != 0 || (part < period && !recurs(m, scale, part, still_closing * tolerance)))
        part++;
    return part;
}

/* The phase farthest from any impact; windows of whole periods that begin there do not depend on rounding. */
static double quiet_phase(const motion *m, double from) {
    double *phase = must_allocate((size_t)m->count + 1, sizeof *phase), quiet = 0;
    int count = 0;
    for (int k = 0; k < m->count; k++)
        if (m->impacts[k] >= from)
            phase[count++] = m->impacts[k] - floor(m->impacts[k]);
    gsl_sort(phase, 1, (size_t)count);
    double widest = 0;
    for (int k = 0; k < count; k++) {
        double next = k + 1 < count ? phase[k + 1] : phase[0] + 1;
        if (next - phase[k] > widest) {
            widest = next - phase[k];
            quiet = 0.5 * (next + phase[k]);
        }
    }
    free(phase);
    return quiet - floor(quiet);
}

/* The number of impacts in [begin, end), and the index of the first. */
static int window(const motion *m, double begin, double end, int *first) {
    int k = 0;
    while (k < m->count && m->impacts[k] < begin)
        k++;
    *first = k;
    while (k < m->count && m->impacts[k] < end)
        k++;
    return k - *first;
}

/* The number of impacts in the last period of a periodic motion, and the index of the first. */
static int last_period(const motion *m, int period, int *first) {
    const double end = recorded_periods - 1 + quiet_phase(m, recorded_periods - period);
    return window(m, end - period, end, first);
}

int motion_orbit_impacts(const motion *m, int period) {
    int first;
    return m->sticks > 0 ? orbit_chatters : last_period(m, period, &first);
}

/* Whether the recorded periods have `count` impacts, from whichever forcing period of the motion they
 * begin. */
static bool counts_in_all(const motion *m, int period, int count) {
    int all = 0, per_cycle[recorded_periods] = {0}, low = INT_MAX, high = 0;
    for (int k = 0; k < m->count; k++) {
        const int cycle = (int)m->impacts[k] - (recorded_periods - period);
        if (m->impacts[k] >= recorded_periods - period && cycle < period) {
            per_cycle[cycle]++;
            all++;
        }
    }
    for (int begin = 0; begin < period; begin++) {
        int total = recorded_periods / period * all;
        for (int k = 0; k < recorded_periods % period; k++)
            total += per_cycle[(begin + k) % period];
        low = total < low ? total : low;
        high = total > high ? total : high;
    }
    return count >= low && count <= high;
}

/* Largest difference between two sequences of impacts, minimised over order and shift: of their times, within
 * one period, or with period 0 of their phases. */
static double sequence_error(const double *a, const double *b, int count, int period) {
    double least = INFINITY;
    for (int turn = 0; turn < count; turn++) {
        const double shift = rint(b[turn] - a[0]);
        double worst = 0;
        for (int k = 0; k < count && worst < least; k++) {
            const int other = turn + k;
            const double time = other < count ? b[other] : b[other - count] + period,
                         difference = time - a[k];
            worst = fmax(worst, fabs(difference - (period ? shift : rint(difference))));
        }
        least = fmin(least, worst);
    }
    return count ? least : NAN;
}

bool motion_agrees(const motion *reference, int period, const motion *m, bool in_phase, double *error) {
    const int windows = (recorded_periods - 1) / period;
    const double end = recorded_periods - 1 + quiet_phase(reference, recorded_periods - period);
    int first, first_last, other_last;
    *error = NAN;
    if (m->failed || (reference->sticks > 0) != (m->sticks > 0))
        return false;
    if (reference->sticks > 0)
        return abs(reference->sticks - m->sticks) <= period;
    const int count = last_period(reference, period, &first_last);
    if (in_phase) {
        if (m->count < count || !counts_in_all(reference, period, m->count))
            return false;
        other_last = m->count - count;
    } else if (window(reference, end - windows * period, end, &first) !=
                   window(m, end - windows * period, end, &first) ||
               window(m, end - period, end, &other_last) != count)
        return false;
    *error = sequence_error(reference->impacts + first_last, m->impacts + other_last, count,
                            in_phase ? 0 : period);
    return true;
}
