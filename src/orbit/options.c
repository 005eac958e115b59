/* Options of shooting and of harvests.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "orbit/options.h"

#include <math.h>

static const saltus_option choices[] = {SALTUS_ORBIT_CHOICES(saltus_orbit_options, )};
const saltus_option_table saltus_orbit_table = SALTUS_TABLE(choices);

saltus_orbit_options saltus_orbit_defaults(void) {
    saltus_orbit_options options = {0};
    saltus_options_fill(&saltus_orbit_table, &options);
    return options;
}

#define MEMBER(member, unit, meaning, ...)                                                                   \
    .field = SALTUS_MEMBER(saltus_harvest_options, member, #member, unit, meaning, __VA_ARGS__)

static const saltus_option harvest_choices[] = {
    {MEMBER(longest, "T", "longest period sought", SALTUS_INT), .fallback = 8, .low = 1, .high = 256,
     .flag = "--periods", .argument = "p"},
    {MEMBER(transient, "T", "periods left out at the beginning", SALTUS_LONG), .fallback = 100, .high = 1e12,
     .flag = "--transient", .argument = "n"},
    {MEMBER(periods, "T", "periods searched for close returns", SALTUS_LONG), .fallback = 5000, .low = 1,
     .high = 1e9, .flag = "--search", .argument = "n"},
    {MEMBER(recurrence, "1", "returns closer than this, in scales of the system, are candidates",
            SALTUS_REAL),
     .fallback = 0.1, .high = INFINITY, .above = true},
    {MEMBER(tries, "1", "candidates kept for each period, the closest ones", SALTUS_INT), .fallback = 40,
     .low = 1, .high = 10000},
    {MEMBER(most, "1", "orbits at most", SALTUS_INT), .fallback = 1000, .low = 1, .high = 1e6,
     .flag = "--most", .argument = "m"},
    {MEMBER(tolerance, "1", "residual, in scales of the state, that an orbit may have", SALTUS_REAL),
     .fallback = 1e-11, .high = INFINITY, .above = true},
    {MEMBER(seed, "1", "seed of the random initial state", SALTUS_NATURAL), .fallback = 1, .high = INFINITY},
    SALTUS_FLOW_CHOICES(saltus_harvest_options, flow., 1e-13, 1e-16),
};
const saltus_option_table saltus_harvest_table = SALTUS_TABLE(harvest_choices);

saltus_harvest_options saltus_harvest_defaults(void) {
    saltus_harvest_options options = {.longest = 0};
    saltus_options_fill(&saltus_harvest_table, &options);
    return options;
}
