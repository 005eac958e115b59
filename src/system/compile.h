/* Private: C source compiled while a run goes on, and the function that it defines.
 *
 * Compiled functions are kept in a folder that only the user can write to, $XDG_CACHE_HOME/saltus or
 * ~/.cache/saltus, named by the source, the compiler and its options. A separate process runs the compiler
 * and moves the file into place; it ends by itself whatever becomes of the run. No more compilers are at work
 * at once than there are processors: others wait for their turn, while the run goes on. Functions not used
 * for long are removed before (kept.h). If anything is missing, there is no function and the caller can do
 * without.
 *
 * The environment variable SALTUS_COMPILE names the compiler (default: cc); 0 switches compiling off.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_COMPILE_H
#define SALTUS_SYSTEM_COMPILE_H

#include <stdbool.h>
#include <stddef.h>

/* What distinguishes the functions of one system. */
typedef struct saltus_compile_shape {
    const char *flags; /* compiler flags for the instruction set; must outlive the function */
    int wide, order, columns, directions;
    int delay; /* ms before the compiler starts: shorter runs do without; does not distinguish functions */
} saltus_compile_shape;

/* Returns the allocated source of a function named SALTUS_COMPILED_NAME; NULL: no memory. */
typedef char *saltus_compile_source(const void *from, const saltus_compile_shape *shape);
typedef void saltus_compiled_function(void *work, int from, int to);
#define SALTUS_COMPILED_NAME "saltus_compiled_function"

/* One function, possibly still being compiled, and a system's list of functions. Both are thread-safe. */
typedef struct saltus_compiled saltus_compiled;
typedef struct saltus_compiled_list saltus_compiled_list;

/* NULL: no memory; then nothing is compiled. */
saltus_compiled_list *saltus_compiled_list_new(void);
/* NULL is accepted. Functions that others still hold live on. */
void saltus_compiled_list_free(saltus_compiled_list *list);

/* The function of a shape, to be released by the caller; NULL: there will be none. */
saltus_compiled *saltus_compiled_hold(saltus_compiled_list *list, const saltus_compile_shape *shape);
/* NULL is accepted. */
void saltus_compiled_release(saltus_compiled *compiled);
/* The function if it is ready, else NULL. */
saltus_compiled_function *saltus_compiled_get(saltus_compiled *compiled);
/* The same, to be called from time to time during a run; it makes progress with each call. The cache is
 * searched at once, the compiler starts when the calls have gone on for the shape's delay. */
saltus_compiled_function *saltus_compiled_ask(saltus_compiled *compiled, saltus_compile_source *source,
                                              const void *from);

/* Describe the state without a run: "interpreted: ..." with the reason, or which compiler is used, and how
 * many functions of the system are kept in which folder. */
void saltus_compile_tell(const saltus_compile_shape *shape, saltus_compile_source *source, const void *from,
                         char *text, size_t size);

#endif
