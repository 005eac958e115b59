/* Returns of an unforced motion to its section, and orbits found from the closest of them.
 *
 * A chaotic transient passes near the orbit that it ends on long before it ends. Close returns lead Newton's
 * method there. Other close returns lead to unstable orbits, the more of them the longer the period, so only
 * a few are tried for each period.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/motion.h"

#include "flow/effort.h"
#include "orbit/poincare.h"
#include "orbit/returns.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { longest = 16, tries = 4, tries_of_one = 16 };
static const double beside = 3;        /* times the distance of a return: farther orbits are not its own */
static const double same_return = 0.3; /* of their distance: returns this near lead to the same orbit */

saltus_status saltus_motion_section_points(const saltus_system *system, const saltus_flow_options *options,
                                           const double *start, long long periods, long long room,
                                           double *points, double *times, long long *count,
                                           saltus_message *message) {
    const int n = saltus_system_dimension(system);
    const saltus_time until = {periods, 0};
    saltus_crossings crossings = {0};
    saltus_event event = {.kind = SALTUS_STEP};
    saltus_flow *flow = NULL;
    saltus_time time;
    double state[SALTUS_STATE_MAX];
    *count = 0;
    saltus_status status = saltus_flow_single(system, 0, options, &flow, message);
    if (status == SALTUS_OK)
        status = saltus_flow_start(flow, 0, (saltus_time){0, 0}, start, message);
    while (status == SALTUS_OK && event.kind != SALTUS_REACHED && *count < room) {
        status = saltus_flow_advance(flow, until, saltus_crossings_watch(system), &event, message);
        if (status != SALTUS_OK)
            break;
        saltus_flow_state(flow, 0, state);
        saltus_crossings_take(&crossings, flow, 0, &event, state);
        while (*count < room && saltus_crossings_count(&crossings, flow, 0, state, &time)) {
            memcpy(points + *count * n, state, (size_t)n * sizeof *state);
            times[(*count)++] = saltus_time_periods(time);
        }
    }
    saltus_flow_free(flow);
    return status;
}

/* The closest returns among section points after `shortest` to `last` returns, `most` of each at most. */
static saltus_status close_returns(const saltus_system *system, const double *points, long long count,
                                   int shortest, int last, int most, saltus_returns **returns,
                                   saltus_message *message) {
    const int n = saltus_system_dimension(system);
    const saltus_returns_wanted wanted = {shortest, last, most, INFINITY, same_return, INFINITY};
    saltus_status status = saltus_returns_new(system, &wanted, returns, message);
    for (long long k = 0; k < count && status == SALTUS_OK; k++)
        saltus_returns_add(*returns, points + k * n, 0);
    return status;
}

saltus_status saltus_stable_cycle_among(const saltus_system *system, const saltus_flow_options *flow,
                                        const saltus_track *track, saltus_motion *motion,
                                        saltus_message *message) {
    const double *times = track->numbers;
    saltus_classify_options options = saltus_classify_defaults();
    saltus_returns *returns = NULL;
    saltus_return closest;
    bool found = false;
    options.flow = *flow;
    *motion = (saltus_motion){0};
    saltus_status status =
        close_returns(system, track->points, track->count, 1, longest, tries, &returns, message);
    for (int p = 1; p <= longest && status == SALTUS_OK && !found; p++)
        while (status == SALTUS_OK && !found && saltus_returns_next(returns, p, &closest)) {
            saltus_status own =
                saltus_motion_cycle_after(system, times[closest.place + p] - times[closest.place],
                                          closest.state, &options, motion, NULL);
            if (own == SALTUS_NO_MEMORY)
                status = saltus_fail(message, own, "no memory for an orbit");
            found = own == SALTUS_OK && motion->stable &&
                    saltus_orbit_passes(system, motion->section_states, motion->periods, closest.state,
                                        beside * closest.distance);
            if (!found)
                saltus_motion_clear(motion);
        }
    saltus_returns_free(returns);
    return status;
}

saltus_status saltus_motion_returning(const saltus_system *system, const double *state, int periods,
                                      const saltus_classify_options *options, saltus_motion *motion,
                                      saltus_message *message) {
    enum { numbers_most = 1 << 24 }; /* doubles in `points`, unless four orbits need more */
    const int n = saltus_system_dimension(system);
    const long long wanted = 2000 + 100LL * periods,
                    fit = numbers_most / n > 4LL * periods ? numbers_most / n : 4LL * periods,
                    room = wanted < fit ? wanted : fit;
    double *points = malloc((size_t)room * (size_t)n * sizeof *points),
           *times = malloc((size_t)room * sizeof *times);
    saltus_returns *returns = NULL;
    saltus_return closest;
    saltus_message why = {.text = "the trajectory does not return"};
    long long count = 0;
    int tried = 0;
    bool found = false;
    saltus_classify_options how = *options;
    saltus_effort effort;
    how.flow = saltus_effort_begin(&options->flow, system, &effort);
    *motion = (saltus_motion){0};
    saltus_status status = points && times
                               ? saltus_motion_section_points(system, &how.flow, state, options->transient,
                                                              room, points, times, &count, message)
                               : saltus_fail(message, SALTUS_NO_MEMORY, "no memory for returns");
    if (status == SALTUS_OK)
        status = close_returns(system, points, count, periods, periods, tries_of_one, &returns, message);
    for (; status == SALTUS_OK && !found && saltus_returns_next(returns, periods, &closest); tried++) {
        saltus_status own = saltus_motion_cycle_after(
            system, times[closest.place + periods] - times[closest.place], closest.state, &how, motion, &why);
        found = own == SALTUS_OK && motion->periods == periods;
        if (own == SALTUS_NO_MEMORY || own == SALTUS_INTERRUPTED)
            status = saltus_fail(message, own, "%s", why.text);
        if (!found)
            saltus_motion_clear(motion);
    }
    saltus_returns_free(returns);
    if (status == SALTUS_OK && !found)
        status = saltus_fail(message, SALTUS_NO_CONVERGENCE,
                             "no orbit of %d returns is found from the %d closest returns of %lld (%.200s)",
                             periods, tried, count, why.text);
    free(points);
    free(times);
    return status;
}
