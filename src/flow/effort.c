/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/effort.h"

#include "system/system.h"

#include <math.h>
#include <stdio.h>

saltus_flow_options saltus_effort_begin(const saltus_flow_options *options, const saltus_system *system,
                                        saltus_effort *own) {
    saltus_flow_options made = *options;
    *own = (saltus_effort){.period = saltus_system_period(system)};
    if (!made.effort)
        made.effort = own;
    return made;
}

saltus_status saltus_effort_check(const saltus_effort *effort, const saltus_system *system,
                                  saltus_message *message) {
    char cause[SALTUS_CAUSE_MAX];
    if (!effort || effort->spent <= SALTUS_EFFORT_MOST)
        return SALTUS_OK;
    return saltus_fail(message, SALTUS_STALLED,
                       "given up: %.0e steps more than the %d that a period, T = %.6g, may take: %s",
                       effort->spent, SALTUS_EFFORT_USUAL,
                       saltus_effort_period(effort, saltus_system_period(system)),
                       saltus_effort_cause(system, cause));
}

/* The scale of the motion of a stop's coordinate. */
static double length_at(const saltus_system *system, int stop) {
    const double *scale = saltus_system_scale(system), *normal = saltus_system_stop_normal(system, stop);
    double sum = 0;
    for (int i = 0; i < saltus_system_dof(system); i++)
        sum += fabs(normal[i]) * scale[i];
    return sum;
}

const char *saltus_effort_cause(const saltus_system *system, char cause[SALTUS_CAUSE_MAX]) {
    static const double far = 10;
    char number[16] = "";
    const saltus_spec *spec = saltus_system_spec(system);
    int count, farthest = -1;
    const saltus_parameter *p = saltus_model_parameters(spec->model, &count);
    double most = log(far);
    for (int k = 0; k < count; k++) {
        const double value = spec->parameters[k], usual = p[k].fallback;
        /* A parameter whose default is 0 can only be too great. */
        const double away = usual == 0 ? log(fabs(value)) : fabs(log(fabs(value / usual)));
        if (!p[k].integer && value != 0 && away > most) {
            farthest = k;
            most = away;
        }
    }
    int pressed = -1;
    for (int k = 0; k < spec->stop_count; k++) {
        const double away = log(-spec->stops[k].d / length_at(system, k));
        if (away > most) {
            pressed = k;
            most = away;
        }
    }
    if (pressed >= 0 && spec->stop_count > 1)
        snprintf(number, sizeof number, "%d", pressed + 1);
    if (pressed >= 0)
        snprintf(cause, SALTUS_CAUSE_MAX, "d%s = %.6g is too great a pre-load", number,
                 spec->stops[pressed].d);
    else if (farthest >= 0)
        snprintf(cause, SALTUS_CAUSE_MAX, "%s = %.6g is too %s", p[farthest].name, spec->parameters[farthest],
                 fabs(spec->parameters[farthest]) < fabs(p[farthest].fallback) ? "small" : "great");
    else
        snprintf(cause, SALTUS_CAUSE_MAX, "%s",
                 spec->model->forcing >= 0 ? "a load is too great, or the forcing too slow"
                                           : "a load is too great, or the unit of time too long");
    return cause;
}
