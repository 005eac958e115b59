/* Private: the options of a flow, declared once for all structs that hold them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_OPTIONS_H
#define SALTUS_FLOW_OPTIONS_H

#include "base/field.h"
#include "saltus/flow.h"
#include "system/system.h"

extern const saltus_word saltus_integrator_words[];

/* Entries of an option table for `struct_type` whose member `path` holds the flow's options ("flow." with its
 * dot, or nothing), with default tolerances. */
#define SALTUS_FLOW_CHOICES(struct_type, path, usual_rtol, usual_atol)                                       \
    {.field =                                                                                                \
         SALTUS_MEMBER(struct_type, path rtol, "rtol", "1", "relative tolerance of the flow", SALTUS_REAL),  \
     .fallback = usual_rtol,                                                                                 \
     .low = 1e-15,                                                                                           \
     .high = 1e-3,                                                                                           \
     .flag = "--rtol",                                                                                       \
     .argument = "x"},                                                                                       \
        {.field = SALTUS_MEMBER(struct_type, path atol, "atol", "1",                                         \
                                "absolute tolerance of the flow, in displacements", SALTUS_REAL),            \
         .fallback = usual_atol,                                                                             \
         .high = 1,                                                                                          \
         .flag = "--atol",                                                                                   \
         .argument = "x"},                                                                                   \
        {.field = SALTUS_MEMBER(struct_type, path integrator, "integrator", "1", "integrator of the flow",   \
                                SALTUS_CHOICE, .words = saltus_integrator_words),                            \
         .fallback = SALTUS_AUTOMATIC,                                                                       \
         .flag = "--integrator",                                                                             \
         .argument = "name"},                                                                                \
    {                                                                                                        \
        .field = SALTUS_MEMBER(struct_type, path order, "order", "1",                                        \
                               "order of the Taylor series; 0: chosen from rtol and stability", SALTUS_INT), \
        .low = SALTUS_ORDER_MIN, .high = SALTUS_ORDER_MAX, .automatic = true                                 \
    }

/* The table of saltus_flow_options itself, without columns and directions, which each method sets. */
extern const saltus_option_table saltus_flow_table;

#endif
