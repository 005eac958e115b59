/* Private: a C text compiled while a run goes on, and the function that it defines.
 *
 * What has been compiled is kept in a folder that only the user can write to, $XDG_CACHE_HOME/saltus or
 * ~/.cache/saltus, under a name made from the text, the compiler and its options. A process of its own runs
 * the compiler and puts the file into its place: it ends by itself whatever becomes of the run. Before one
 * begins, functions that have not been used for long are removed (kept.h). Where
 * anything is missing, there is no function, and the caller goes on without.
 *
 * The environment variable SALTUS_COMPILE names the compiler (default: cc), 0: none.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_COMPILE_H
#define SALTUS_SYSTEM_COMPILE_H

#include <stdbool.h>
#include <stddef.h>

/* What texts of one system are told apart by. */
typedef struct saltus_compile_shape {
    const char *flags; /* of the compiler, for the instruction set; lives on */
    int wide, order, columns, directions;
    int delay; /* ms: shorter runs do without a compiler; not told apart by it */
} saltus_compile_shape;

/* The text, allocated, of a function with this name; NULL: no memory. */
typedef char *saltus_compile_source(const void *from, const saltus_compile_shape *shape);
typedef void saltus_compiled_function(void *work, int from, int to);
#define SALTUS_COMPILED_NAME "saltus_compiled_function"

/* One function, that may be under way; and all of a system. Any thread may use them. */
typedef struct saltus_compiled saltus_compiled;
typedef struct saltus_compiled_list saltus_compiled_list;

/* NULL: no memory, and nothing is compiled. */
saltus_compiled_list *saltus_compiled_list_new(void);
/* NULL is accepted. Functions that others hold stay. */
void saltus_compiled_list_free(saltus_compiled_list *list);

/* The function of a shape, to be released; NULL: there will be none. */
saltus_compiled *saltus_compiled_hold(saltus_compiled_list *list, const saltus_compile_shape *shape);
/* NULL is accepted. */
void saltus_compiled_release(saltus_compiled *compiled);
/* The function, once it is there; until then NULL. */
saltus_compiled_function *saltus_compiled_get(saltus_compiled *compiled);
/* The same, asked now and then while a run goes on, which moves things forward: a kept function is looked for
 * at once, the compiler begins when the asking has gone on for some time. */
saltus_compiled_function *saltus_compiled_ask(saltus_compiled *compiled, saltus_compile_source *source,
                                              const void *from);

/* How things stand, without a run: "interpreted: ..", or who compiles, and how many functions of the system
 * are kept where. */
void saltus_compile_tell(const saltus_compile_shape *shape, saltus_compile_source *source, const void *from,
                         char *text, size_t size);

#endif
