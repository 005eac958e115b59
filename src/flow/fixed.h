/* Private: the kernel compiled anew for one system from text, with its tape and sizes as constants. The C
 * text is that of the interpreting kernel, so the bits are the same and a flow may switch at any step.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_FIXED_H
#define SALTUS_FLOW_FIXED_H

#include "flow/kernel.h"
#include "system/compile.h"

/* src/flow/kernel.c for tapes, with all that it includes; made by the build (embed.cmake). */
extern const char saltus_kernel_text[];

/* Expands the series of all lanes, by the kernel's `expand` or by the compiled function once there is one. */
typedef struct saltus_fixed {
    saltus_compiled *compiled; /* NULL: nothing is compiled */
    saltus_compiled_function *function;
    int steps; /* since the function was last asked for */
} saltus_fixed;

/* For the Taylor flow of a system; must be closed. */
saltus_fixed saltus_fixed_open(const saltus_kernel *kernel, const saltus_system *system,
                               const saltus_work *work);
void saltus_fixed_close(saltus_fixed *fixed);
/* Ask for the compiled function, as saltus_fixed_expand does now and then; false: it is not there yet. */
bool saltus_fixed_ask(saltus_fixed *fixed, const saltus_system *system);
/* Expand orders `from` to `to`, as a kernel's `expand`. */
void saltus_fixed_expand(saltus_fixed *fixed, const saltus_kernel *kernel, const saltus_system *system,
                         saltus_work *work, int from, int to);

/* Describe how a system's equations are run (saltus_compile_tell); false if they are not from text, or stiff,
 * for which nothing is compiled. */
bool saltus_fixed_tell(const saltus_system *system, char *text, size_t size);

#endif
