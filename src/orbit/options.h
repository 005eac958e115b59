/* Private: option tables of shooting, declared once for all structs that contain them, and of harvests.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_ORBIT_OPTIONS_H
#define SALTUS_ORBIT_OPTIONS_H

#include "flow/options.h"
#include "saltus/harvest.h"
#include "saltus/orbit.h"

/* Table entries for `struct_type`, which contains the options at `path`, like SALTUS_FLOW_CHOICES. */
#define SALTUS_ORBIT_CHOICES(struct_type, path)                                                              \
    SALTUS_FLOW_CHOICES(struct_type, path flow., 1e-13, 1e-16),                                              \
        {.field = SALTUS_MEMBER(struct_type, path phase, "section_phase", "T", "phase of the section",       \
                                SALTUS_REAL),                                                                \
         .high = 1,                                                                                          \
         .below = true},                                                                                     \
        {.field = SALTUS_MEMBER(struct_type, path iterations, "iterations", "1", "Newton steps at most",     \
                                SALTUS_INT),                                                                 \
         .fallback = 20,                                                                                     \
         .high = INFINITY},                                                                                  \
        {.field = SALTUS_MEMBER(struct_type, path tolerance, "tolerance", "1",                               \
                                "residual, in scales of the state, at which Newton's method has converged",  \
                                SALTUS_REAL),                                                                \
         .fallback = 1e-12,                                                                                  \
         .high = INFINITY},                                                                                  \
    {                                                                                                        \
        .field = SALTUS_MEMBER(struct_type, path segments, "segments", "1", "shooting segments; 0: chosen",  \
                               SALTUS_INT),                                                                  \
        .high = 100000, .flag = "--segments", .argument = "k"                                                \
    }

/* Tables of saltus_orbit_options and saltus_harvest_options. */
extern const saltus_option_table saltus_orbit_table, saltus_harvest_table;

#endif
