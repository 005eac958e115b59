/* Options of a continuation.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/options.h"

#include "branch/solution.h"
#include "orbit/options.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const saltus_word locus_words[] = {
    {"none", SALTUS_POINT_REGULAR}, {"LP", SALTUS_POINT_LP}, {"PD", SALTUS_POINT_PD},
    {"NS", SALTUS_POINT_NS},        {"BP", SALTUS_POINT_BP}, {"GR", SALTUS_POINT_GR},
    {"HB", SALTUS_POINT_HB},        {"BE", SALTUS_POINT_BE}, {NULL, 0}};
static const saltus_word direction_words[] = {{"up", 1}, {"down", -1}, {"both", 0}, {NULL, 0}};

#define MEMBER(member, name, meaning, ...)                                                                   \
    .field = SALTUS_MEMBER(saltus_branch_options, member, name, "1", meaning, __VA_ARGS__)

static const saltus_option choices[] = {
    {MEMBER(key[0], "key1", "the parameter to continue in", SALTUS_TEXT, SALTUS_KEY_MAX)},
    {MEMBER(low[0], "low1", "lower end of its range", SALTUS_REAL), .low = -INFINITY, .high = INFINITY},
    {MEMBER(high[0], "high1", "upper end of its range", SALTUS_REAL), .low = -INFINITY, .high = INFINITY},
    {MEMBER(key[1], "key2", "the second parameter of a locus", SALTUS_TEXT, SALTUS_KEY_MAX)},
    {MEMBER(low[1], "low2", "lower end of its range", SALTUS_REAL), .low = -INFINITY, .high = INFINITY},
    {MEMBER(high[1], "high2", "upper end of its range", SALTUS_REAL), .low = -INFINITY, .high = INFINITY},
    {MEMBER(step, "step", "first step, where the whole range is 1", SALTUS_REAL), .fallback = 0.005,
     .high = 1, .above = true, .flag = "--step", .argument = "s"},
    {MEMBER(step_max, "step_max", "largest step, likewise", SALTUS_REAL), .fallback = 0.02, .high = 1,
     .above = true, .flag = "--step-max", .argument = "s"},
    {MEMBER(points, "points", "points at most, on each branch", SALTUS_INT), .fallback = 2000, .low = 1,
     .high = 1e7, .flag = "--points", .argument = "n"},
    {MEMBER(direction, "direction", "where to go first, or only", SALTUS_CHOICE, .words = direction_words),
     .flag = "--direction", .argument = "way"},
    {MEMBER(switches, "switches", "also follow what branches off, or meets a locus, to this depth",
            SALTUS_INT),
     .high = 1000, .flag = "--switch", .argument = "k"},
    {MEMBER(locus, "locus", "follow the first such point met on the way in two parameters", SALTUS_CHOICE,
            .words = locus_words),
     .flag = "--locus", .argument = "kind"},
    SALTUS_ORBIT_CHOICES(saltus_branch_options, orbit.),
};
const saltus_option_table saltus_branch_table = SALTUS_TABLE(choices);

saltus_branch_options saltus_branch_defaults(void) {
    saltus_branch_options options = {.points = 0};
    saltus_options_fill(&saltus_branch_table, &options);
    return options;
}

/* Check a parameter's key, and that its value at the specification is in its range. */
static saltus_status check_range(const saltus_branch_options *o, int k, const saltus_spec *spec,
                                 saltus_direction *direction, double *value, saltus_message *message) {
    saltus_status status = saltus_spec_direction(spec, o->key[k], direction, value, message);
    if (status != SALTUS_OK)
        return status;
    const bool turned = !(o->low[k] < o->high[k]);
    if (turned || !isfinite(o->high[k] - o->low[k]))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s=%g:%g: the range must %s", o->key[k], o->low[k],
                           o->high[k], turned ? "go from low to high" : "be finite");
    if (!(*value >= o->low[k] && *value <= o->high[k]))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s=%g:%g: the range must hold the start, %s = %.12g",
                           o->key[k], o->low[k], o->high[k], o->key[k], *value);
    return SALTUS_OK;
}

/* Check all options; `direction` and `origin` get the parameters' directions and present values. */
static saltus_status check(const saltus_branch_options *o, const saltus_spec *spec,
                           saltus_direction *direction, double *origin, saltus_message *message) {
    saltus_status status = check_range(o, 0, spec, &direction[0], &origin[0], message);
    if (status == SALTUS_OK)
        status = saltus_options_check(&saltus_branch_table, o, message);
    if (status != SALTUS_OK)
        return status;
    if (o->step > o->step_max)
        return saltus_fail(message, SALTUS_BAD_INPUT, "step = %g, step_max = %g: must be in this order",
                           o->step, o->step_max);
    if (o->value_count < 0 || o->value_count > SALTUS_BRANCH_VALUES_MAX)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%d values asked for: at most %d are possible",
                           o->value_count, SALTUS_BRANCH_VALUES_MAX);
    if (o->locus)
        status = saltus_spec_direction(spec, o->key[1], &direction[1], NULL, message);
    if (status == SALTUS_OK && o->locus && memcmp(&direction[0], &direction[1], sizeof *direction) == 0)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%s and %s: a curve needs two parameters, not one twice", o->key[0], o->key[1]);
    return status == SALTUS_OK && o->locus ? check_range(o, 1, spec, &direction[1], &origin[1], message)
                                           : status;
}

/* Whether there is a scene this far along both parameters' directions. */
static bool exists(const saltus_spec *spec, const saltus_direction *direction, const double *amount,
                   bool *starved, saltus_message *why) {
    const saltus_spec first = saltus_spec_shifted(spec, &direction[0], amount[0]),
                      there = saltus_spec_shifted(&first, &direction[1], amount[1]);
    saltus_system *system = NULL;
    const saltus_status status = saltus_system_new(&there, &system, why);
    saltus_system_free(system);
    *starved |= status == SALTUS_NO_MEMORY;
    return status == SALTUS_OK;
}

/* Along parameter k, the last value before `end` at which there is a scene. */
static double domain_end(const saltus_spec *spec, const saltus_direction *direction, int k, double origin,
                         double end, double unit, bool *starved) {
    enum { halvings = 100, decimals = 15 };
    double amount[2] = {0}, inside = 0, outside = end - origin, power = 1;
    for (int j = 0; j < halvings && !*starved; j++) {
        amount[k] = 0.5 * (inside + outside);
        *(exists(spec, direction, amount, starved, NULL) ? &inside : &outside) = amount[k];
    }
    const double last = origin + inside, rounding = 4 * DBL_EPSILON * (fabs(origin) + unit);
    for (int j = 0; j <= decimals && !*starved; j++, power *= 10) {
        const double decimal = round(last * power) / power + 0.0;
        amount[k] = decimal - origin;
        if (fabs(decimal - last) <= rounding && exists(spec, direction, amount, starved, NULL))
            return decimal;
    }
    return last;
}

saltus_status saltus_branch_fit(saltus_branch_options *o, const saltus_spec *spec,
                                char ends[2][2][SALTUS_REASON_MAX], saltus_message *message) {
    const saltus_branch_options given = *o;
    const int count = o->locus ? 2 : 1;
    saltus_direction direction[2] = {{.clock = 0}, {.clock = 0}};
    double origin[2] = {0};
    bool starved = false;
    saltus_status status = check(o, spec, direction, origin, message);
    if (status != SALTUS_OK)
        return status;
    for (int k = 0; k < count; k++)
        for (int side = 0; side < 2; side++) {
            const double *border = side ? given.high : given.low;
            double amount[2] = {0};
            saltus_message why = {.text = ""};
            bool outside = true;
            amount[k] = border[k] - origin[k];
            for (int j = 0; j < 2 * count - 1 && outside; j++) {
                amount[1 - k] = j == 0 ? 0 : (j == 1 ? given.low : given.high)[1 - k] - origin[1 - k];
                outside = !exists(spec, direction, amount, &starved, &why);
            }
            snprintf(ends[k][side], SALTUS_REASON_MAX, "end of the parameter%s range",
                     o->locus ? "s'" : "'s");
            if (!outside)
                continue;
            (side ? o->high : o->low)[k] =
                domain_end(spec, direction, k, origin[k], border[k], given.high[k] - given.low[k], &starved);
            snprintf(ends[k][side], SALTUS_REASON_MAX, "end of the parameter's domain: %.120s", why.text);
        }
    return starved ? saltus_branch_no_memory(message) : SALTUS_OK;
}

saltus_status saltus_branch_family(const saltus_spec *spec, const saltus_branch_options *o, int parameters,
                                   saltus_family *family, double *origin, double border[][2],
                                   saltus_message *message) {
    *family = (saltus_family){.spec = *spec, .parameters = parameters};
    for (int d = 0; d < parameters; d++) {
        family->unit[d] = o->high[d] - o->low[d];
        saltus_status status =
            saltus_spec_direction(spec, o->key[d], &family->direction[d], &origin[d], message);
        if (status != SALTUS_OK)
            return status;
        border[d][0] = saltus_orbits_border(origin[d], family->unit[d], o->low[d], 0);
        border[d][1] = saltus_orbits_border(origin[d], family->unit[d], o->high[d], 1);
    }
    return SALTUS_OK;
}
