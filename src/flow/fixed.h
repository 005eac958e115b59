/* Private: the kernel compiled anew for one system from text, its tape and sizes being constants. It is the
 * same C text as that of the kernel which reads the tape, so the arithmetic and the bits are the same: a flow
 * may change from one to the other at any step.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_FLOW_FIXED_H
#define SALTUS_FLOW_FIXED_H

#include "flow/kernel.h"
#include "system/compile.h"

/* src/flow/kernel.c for tapes with all it includes; made by the build. */
extern const char saltus_kernel_text[];

/* Expansions of all lanes: the kernel's `expand`, or what has been compiled of it by now. */
typedef struct saltus_fixed {
    saltus_compiled *compiled; /* NULL: nothing is compiled */
    saltus_compiled_function *function;
    int steps; /* since it was asked for */
} saltus_fixed;

/* For the Taylor flow of a system; to be closed. */
saltus_fixed saltus_fixed_open(const saltus_kernel *kernel, const saltus_system *system,
                               const saltus_work *work);
void saltus_fixed_close(saltus_fixed *fixed);
/* Ask for the function now, as expanding does every now and then; false: it is not there yet. */
bool saltus_fixed_ask(saltus_fixed *fixed, const saltus_system *system);
/* Orders `from` to `to` of the series, as a kernel's `expand`. */
void saltus_fixed_expand(saltus_fixed *fixed, const saltus_kernel *kernel, const saltus_system *system,
                         saltus_work *work, int from, int to);

/* How a system's equations are run, in words (saltus_compile_tell); false: they are no text's, or stiff ones,
 * which nothing is compiled for. */
bool saltus_fixed_tell(const saltus_system *system, char *text, size_t size);

#endif
