/* Options of classifications, of Lyapunov exponents and of spectra.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "motion/options.h"

#include "flow/options.h"
#include "motion/ensemble.h"

#include <math.h>

#define MEMBER(kind, member, unit, meaning, ...)                                                             \
    .field = SALTUS_MEMBER(saltus_##kind##_options, member, #member, unit, meaning, __VA_ARGS__)

static const saltus_option classify_choices[] = {
    {MEMBER(classify, transient, "T", "periods to wait at most for the motion to settle", SALTUS_LONG),
     .fallback = 20000, .low = 1, .high = 1e12, .flag = "--transient", .argument = "n"},
    {MEMBER(classify, measure, "T",
            "without a period: periods at most to measure an exponent over, dear ones counting more than "
            "once; 0: irregular",
            SALTUS_LONG),
     .fallback = 256000, .high = 1e12, .flag = "--measure", .argument = "n"},
    {MEMBER(
         classify, lifetime, "T",
         "chaos is asserted where its mean lifetime is at least so many periods (95 %); it takes three times "
         "as many to watch",
         SALTUS_LONG),
     .fallback = 10000, .high = 1e11, .flag = "--lifetime", .argument = "n"},
    {MEMBER(classify, longest, "T",
            "longest period tried, in forcing periods, without forcing in returns to the section",
            SALTUS_INT),
     .fallback = 64, .low = 1, .high = SALTUS_LONGEST_PERIOD, .flag = "--longest", .argument = "p"},
    SALTUS_FLOW_CHOICES(saltus_classify_options, flow., 1e-13, 1e-16),
};
const saltus_option_table saltus_classify_table = SALTUS_TABLE(classify_choices);

static const saltus_option lyapunov_choices[] = {
    {MEMBER(lyapunov, transient, "T", "periods before measuring", SALTUS_LONG), .fallback = 1000,
     .high = 1e12, .flag = "--transient", .argument = "n"},
    {MEMBER(lyapunov, periods, "T",
            "periods measured at most, all together, dear ones counting more than once", SALTUS_LONG),
     .fallback = 1e6, .low = 1, .high = 1e15, .flag = "--periods", .argument = "n"},
    {MEMBER(lyapunov, members, "1", "trajectories that share the work", SALTUS_INT), .fallback = 8, .low = 1,
     .high = SALTUS_MEMBERS_MAX, .flag = "--members", .argument = "m"},
    {MEMBER(lyapunov, seed, "1", "seed of the first directions; other than 0 the start is disturbed, too",
            SALTUS_NATURAL),
     .high = INFINITY, .flag = "--seed", .argument = "s"},
    {MEMBER(lyapunov, precision, "1", "stop when the largest exponent's relative error is below x",
            SALTUS_REAL),
     .fallback = 0.01, .high = 1e6, .above = true, .flag = "--precision", .argument = "x"},
    {MEMBER(lyapunov, interval, "T", "periods between orthonormalisations; 0: chosen from the growth",
            SALTUS_REAL),
     .high = 1000000, .flag = "--interval", .argument = "x"},
    SALTUS_FLOW_CHOICES(saltus_lyapunov_options, flow., 1e-10, 1e-14),
    {MEMBER(lyapunov, exponents, "1", "how many, the largest ones; 0: all", SALTUS_INT), .fallback = 1,
     .high = 1000, .flag = "--exponents", .argument = "k"},
};
const saltus_option_table saltus_lyapunov_table = SALTUS_TABLE(lyapunov_choices);

static const saltus_option spectrum_choices[] = {
    {MEMBER(spectrum, per_period, "1", "samples per period, a multiple of 4; 0: chosen by what aliases",
            SALTUS_INT),
     .low = 16, .high = 65536, .automatic = true, .flag = "--samples", .argument = "k"},
    {MEMBER(spectrum, reach, "1", "frequency over omega up to which spectra are wanted; 0: chosen",
            SALTUS_REAL),
     .high = INFINITY},
    {MEMBER(spectrum, periods, "T", "periods to analyse; 0: 8 orbits, or 2048 periods without one",
            SALTUS_LONG),
     .high = 1e6, .flag = "--periods", .argument = "n"},
    {MEMBER(spectrum, segment, "T",
            "periods in a segment of Welch's method, then for periodic motion too; 0: chosen", SALTUS_LONG),
     .high = 1e6, .flag = "--segment", .argument = "m"},
    {MEMBER(spectrum, confidence, "1", "of the band about a density", SALTUS_REAL), .fallback = 0.95,
     .high = 1, .above = true, .below = true},
    SALTUS_FLOW_CHOICES(saltus_spectrum_options, flow., 1e-13, 1e-16),
};
const saltus_option_table saltus_spectrum_table = SALTUS_TABLE(spectrum_choices);

saltus_classify_options saltus_classify_defaults(void) {
    saltus_classify_options options = {.longest = 0};
    saltus_options_fill(&saltus_classify_table, &options);
    return options;
}

saltus_lyapunov_options saltus_lyapunov_defaults(void) {
    saltus_lyapunov_options options = {.members = 0};
    saltus_options_fill(&saltus_lyapunov_table, &options);
    return options;
}

saltus_spectrum_options saltus_spectrum_defaults(void) {
    saltus_spectrum_options options = {.quantities = {{0, false}, {0, true}}, .quantity_count = 2};
    saltus_options_fill(&saltus_spectrum_table, &options);
    return options;
}
