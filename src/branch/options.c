/* Options of a continuation.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "branch/options.h"

#include <math.h>
#include <string.h>

saltus_branch_options saltus_branch_defaults(void) {
    return (saltus_branch_options){
        .orbit = saltus_orbit_defaults(), .step = 0.005, .step_max = 0.02, .points = 2000};
}

static saltus_status check_range(const saltus_branch_options *o, int k, double value,
                                 saltus_message *message) {
    if (!(o->low[k] < o->high[k]))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s=%g:%g: the range must go from low to high",
                           o->key[k], o->low[k], o->high[k]);
    if (!isfinite(o->high[k] - o->low[k]))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s=%g:%g: the range must be finite", o->key[k],
                           o->low[k], o->high[k]);
    if (!(value >= o->low[k] && value <= o->high[k]))
        return saltus_fail(message, SALTUS_BAD_INPUT, "%s=%g:%g: the range must hold the start, %s = %.12g",
                           o->key[k], o->low[k], o->high[k], o->key[k], value);
    return SALTUS_OK;
}

/* What a locus needs beside the first parameter. */
static saltus_status check_locus(const saltus_branch_options *o, const saltus_spec *spec,
                                 saltus_message *message) {
    bool known = o->locus == SALTUS_POINT_LP || o->locus == SALTUS_POINT_PD || o->locus == SALTUS_POINT_NS ||
                 o->locus == SALTUS_POINT_BP || o->locus == SALTUS_POINT_GR;
    saltus_direction first, second;
    double origin;
    if (!known)
        return saltus_fail(message, SALTUS_BAD_INPUT, "locus %s: must be LP, PD, NS, BP or GR",
                           saltus_point_word(o->locus));
    saltus_status status = saltus_spec_direction(spec, o->key[0], &first, NULL, message);
    if (status == SALTUS_OK)
        status = saltus_spec_direction(spec, o->key[1], &second, &origin, message);
    if (status != SALTUS_OK)
        return status;
    if (memcmp(&first, &second, sizeof first) == 0)
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "%s and %s: a curve needs two parameters, not one twice", o->key[0], o->key[1]);
    return check_range(o, 1, origin, message);
}

saltus_status saltus_branch_check(const saltus_branch_options *o, const saltus_spec *spec,
                                  saltus_message *message) {
    saltus_direction direction;
    double origin;
    saltus_status status = saltus_spec_direction(spec, o->key[0], &direction, &origin, message);
    if (status == SALTUS_OK)
        status = check_range(o, 0, origin, message);
    if (status != SALTUS_OK)
        return status;
    if (!(o->step > 0 && o->step <= o->step_max && o->step_max <= 1))
        return saltus_fail(message, SALTUS_BAD_INPUT,
                           "step = %g, step_max = %g: must be greater than 0, at most 1, and in this order",
                           o->step, o->step_max);
    if (o->points < 1)
        return saltus_fail(message, SALTUS_BAD_INPUT, "points = %d: must be at least 1", o->points);
    if (o->value_count < 0 || o->value_count > SALTUS_BRANCH_VALUES_MAX)
        return saltus_fail(message, SALTUS_BAD_INPUT, "%d values asked for: at most %d are possible",
                           o->value_count, SALTUS_BRANCH_VALUES_MAX);
    return o->locus ? check_locus(o, spec, message) : SALTUS_OK;
}
