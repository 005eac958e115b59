/* What makes a system ask for too much.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/cause.h"

#include "system/system.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

/* The scale of the motion of a stop's coordinate. */
static double length_at(const saltus_system *system, int stop) {
    const double *scale = saltus_system_scale(system), *normal = saltus_system_stop_normal(system, stop);
    double sum = 0;
    for (int i = 0; i < saltus_system_dof(system); i++)
        sum += fabs(normal[i]) * scale[i];
    return sum;
}

/* What may be too much, and the logarithm of how far it is from the usual. */
typedef struct suspect {
    char text[SALTUS_CAUSE_MAX / 2];
    double away;
} suspect;

/* Keep the two that are farthest away. */
__attribute__((format(printf, 3, 4))) static void accuse(suspect two[2], double away, const char *format,
                                                         ...) {
    if (!(away > two[1].away))
        return;
    const bool first = away > two[0].away;
    if (first)
        two[1] = two[0];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(two[!first].text, sizeof two->text, format, arguments);
    va_end(arguments);
    two[!first].away = away;
}

const char *saltus_system_cause(const saltus_system *system, char cause[SALTUS_CAUSE_MAX]) {
    static const double far = 10, as_well = 30, narrow = 1e-4; /* a clearance has no default */
    const saltus_spec *spec = saltus_system_spec(system);
    suspect two[2] = {{"", log(far)}, {"", log(far)}};
    int count, many = -1;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    for (int k = 0; k < count; k++) {
        const double value = spec->parameters[k], usual = p[k].fallback;
        /* A parameter whose default is 0 can only be too great. */
        const double away = usual == 0 ? log(fabs(value)) : fabs(log(fabs(value / usual)));
        if (p[k].integer && value > 2 * usual)
            many = k;
        if (!p[k].integer && value != 0 && saltus_spec_matters(spec, k))
            accuse(two, away, "%s = %.6g is too %s", p[k].name, value,
                   fabs(value) < fabs(usual) ? "small" : "great");
    }
    for (int k = 0; k < spec->stop_count; k++) {
        const double d = spec->stops[k].d;
        char number[16] = "";
        if (spec->stop_count > 1)
            snprintf(number, sizeof number, "%d", k + 1);
        if (d < 0)
            accuse(two, log(-d / length_at(system, k)), "d%s = %.6g is too great a pre-load", number, d);
        else if (d > 0 && d < narrow)
            accuse(two, -log(d), "d%s = %.6g is too small a clearance", number, d);
    }
    if (two[1].text[0] && two[1].away > log(as_well))
        snprintf(cause, SALTUS_CAUSE_MAX, "%s, or %s", two[0].text, two[1].text);
    else if (two[0].text[0])
        snprintf(cause, SALTUS_CAUSE_MAX, "%s", two[0].text);
    else if (many >= 0)
        snprintf(cause, SALTUS_CAUSE_MAX, "%s = %.6g is too great", p[many].name, spec->parameters[many]);
    else
        snprintf(cause, SALTUS_CAUSE_MAX, "%s",
                 spec->model->forcing >= 0 ? "a load is too great, or the forcing too slow"
                                           : "a load is too great, or the unit of time too long");
    return cause;
}
