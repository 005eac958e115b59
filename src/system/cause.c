/* What makes a system ask for too much.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "system/cause.h"

#include "system/system.h"

#include <math.h>
#include <stdio.h>

/* The scale of the motion of a stop's coordinate. */
static double length_at(const saltus_system *system, int stop) {
    const double *scale = saltus_system_scale(system), *normal = saltus_system_stop_normal(system, stop);
    double sum = 0;
    for (int i = 0; i < saltus_system_dof(system); i++)
        sum += fabs(normal[i]) * scale[i];
    return sum;
}

const char *saltus_system_cause(const saltus_system *system, char cause[SALTUS_CAUSE_MAX]) {
    static const double far = 10, narrow = 1e-4; /* a clearance has no default */
    char number[16] = "";
    const saltus_spec *spec = saltus_system_spec(system);
    int count, farthest = -1, many = -1;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    double most = log(far);
    for (int k = 0; k < count; k++) {
        const double value = spec->parameters[k], usual = p[k].fallback;
        /* A parameter whose default is 0 can only be too great. */
        const double away = usual == 0 ? log(fabs(value)) : fabs(log(fabs(value / usual)));
        if (p[k].integer && value > 2 * usual)
            many = k;
        if (!p[k].integer && value != 0 && away > most) {
            farthest = k;
            most = away;
        }
    }
    int pressed = -1;
    for (int k = 0; k < spec->stop_count; k++) {
        const double d = spec->stops[k].d, away = d < 0                 ? log(-d / length_at(system, k))
                                                  : d > 0 && d < narrow ? -log(d)
                                                                        : 0;
        if (away > most) {
            pressed = k;
            most = away;
        }
    }
    if (pressed >= 0 && spec->stop_count > 1)
        snprintf(number, sizeof number, "%d", pressed + 1);
    if (pressed >= 0)
        snprintf(cause, SALTUS_CAUSE_MAX, "d%s = %.6g is too %s", number, spec->stops[pressed].d,
                 spec->stops[pressed].d < 0 ? "great a pre-load" : "small a clearance");
    else if (farthest >= 0)
        snprintf(cause, SALTUS_CAUSE_MAX, "%s = %.6g is too %s", p[farthest].name, spec->parameters[farthest],
                 fabs(spec->parameters[farthest]) < fabs(p[farthest].fallback) ? "small" : "great");
    else if (many >= 0)
        snprintf(cause, SALTUS_CAUSE_MAX, "%s = %.6g is too great", p[many].name, spec->parameters[many]);
    else
        snprintf(cause, SALTUS_CAUSE_MAX, "%s",
                 spec->model->forcing >= 0 ? "a load is too great, or the forcing too slow"
                                           : "a load is too great, or the unit of time too long");
    return cause;
}
