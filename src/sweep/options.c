/* Options of a sweep.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "sweep/options.h"

#include "flow/options.h"

#include <math.h>

static const saltus_word keep_words[] = {{"turning", SALTUS_KEEP_TURNING},
                                         {"impacts", SALTUS_KEEP_IMPACTS},
                                         {"stroboscopic", SALTUS_KEEP_STROBOSCOPIC},
                                         {"lyapunov", SALTUS_KEEP_LYAPUNOV},
                                         {NULL, 0}};
const saltus_word saltus_pass_words[] = {{"reset", 1 << SALTUS_PASS_RESET},
                                         {"up", 1 << SALTUS_PASS_UP},
                                         {"down", 1 << SALTUS_PASS_DOWN},
                                         {NULL, 0}};
const saltus_word saltus_spacing_words[] = {
    {"linear", SALTUS_LINEAR}, {"logarithmic", SALTUS_LOGARITHMIC}, {"list", SALTUS_LIST}, {NULL, 0}};

#define MEMBER(member, name, unit, meaning, ...)                                                             \
    .field = SALTUS_MEMBER(saltus_sweep_options, member, name, unit, meaning, __VA_ARGS__)

static const saltus_option choices[] = {
    {MEMBER(passes, "passes", "1",
            "how trajectories start: each point anew, along the first axis, against it", SALTUS_SET,
            .words = saltus_pass_words),
     .fallback = 1 << SALTUS_PASS_RESET},
    {MEMBER(seeds, "seeds", "1", "initial states at each point", SALTUS_INT), .fallback = 1, .low = 1,
     .high = 10000, .flag = "--seeds", .argument = "k"},
    {MEMBER(seed, "seed", "1", "seed of the random initial states", SALTUS_NATURAL), .fallback = 1,
     .high = INFINITY, .flag = "--seed", .argument = "s"},
    {MEMBER(keep, "keep", "1", "kept beside the rows", SALTUS_SET, .words = keep_words), .flag = "--what",
     .argument = "list"},
    {MEMBER(adaptive, "adaptive", "1", "recorded as soon as the least period is certain", SALTUS_FLAG),
     .fallback = true},
    {MEMBER(transient, "transient", "T", "periods to wait at most until the least period is certain",
            SALTUS_LONG),
     .fallback = 2000, .high = 1e9, .flag = "--at-most", .argument = "n"},
    {MEMBER(record, "record", "T", "periods recorded of a motion without a period", SALTUS_LONG),
     .fallback = 100, .low = 1, .high = 1e9, .flag = "--record", .argument = "k"},
    {MEMBER(measure, "measure", "T",
            "with --what lyapunov: periods at most to measure a motion without a period; fewer than three "
            "lifetimes are cheap, and leave chaos irregular",
            SALTUS_LONG),
     .fallback = 32000, .high = 1e9, .flag = "--measure", .argument = "n"},
    {MEMBER(
         lifetime, "lifetime", "T",
         "chaos is asserted where its mean lifetime is at least so many periods (95 %); it takes three times "
         "as many to watch",
         SALTUS_LONG),
     .fallback = 10000, .high = 1e11, .flag = "--lifetime", .argument = "n"},
    {MEMBER(longest, "longest", "T", "longest period looked for", SALTUS_INT), .fallback = 20, .low = 1,
     .high = 256, .flag = "--longest", .argument = "p"},
    SALTUS_FLOW_CHOICES(saltus_sweep_options, flow., 1e-10, 1e-14),
    {MEMBER(lanes, "lanes", "1",
            "trajectories side by side on a core, at most; 0: as many as it has room for", SALTUS_INT),
     .high = 4096, .flag = "--lanes", .argument = "k", .apart = true},
    {MEMBER(threads, "threads", "1", "threads at most; 0: one for each core", SALTUS_INT), .high = 4096,
     .flag = "--threads", .argument = "k", .apart = true},
};
const saltus_option_table saltus_sweep_table = SALTUS_TABLE(choices);

saltus_sweep_options saltus_sweep_defaults(void) {
    saltus_sweep_options options = {.keep = 0};
    saltus_options_fill(&saltus_sweep_table, &options);
    return options;
}

saltus_status saltus_sweep_check(const saltus_sweep_options *o, saltus_message *message) {
    if (o->passes == 0)
        return saltus_fail(message, SALTUS_BAD_INPUT, "passes: there must be one");
    if (o->adaptive && o->transient == 0)
        return saltus_fail(message, SALTUS_BAD_INPUT, "transient = 0: must be at least 1 (adaptive)");
    return saltus_options_check(&saltus_sweep_table, o, message);
}
