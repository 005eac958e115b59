/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "flow/effort.h"

#include "system/cause.h"

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
                       saltus_system_cause(system, cause));
}
