/* Private: models from text. Named equations (manual: saltus-text) become a model that the rest of the
 * library treats like a built-in one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_TEXT_H
#define SALTUS_SYSTEM_TEXT_H

#include "base/memory.h"
#include "saltus/system.h"

/* Bytes of a name in a text, including the NUL. */
enum { SALTUS_NAME_MAX = 32 };

/* The left and right side of an equation, and its line for messages (0: unknown). */
typedef struct saltus_equation {
    const char *name, *text;
    int line;
} saltus_equation;

typedef struct saltus_equation_list {
    const saltus_equation *items;
    int count;
} saltus_equation_list;

typedef struct saltus_text_parameter {
    const char *name, *meaning; /* meaning NULL: none given */
    double fallback, min, max;
    bool integer;
    int line;
} saltus_text_parameter;

/* A number (rows = columns = 0), a vector (columns = 0) or a matrix, row by row. */
typedef struct saltus_text_constant {
    const char *name;
    int rows, columns;
    const double *values;
    int line;
} saltus_text_constant;

/* A stop's coordinate, d and r. The texts of d and r are NULL for numbers, which saltus_stop holds. */
typedef struct saltus_text_stop {
    saltus_equation coordinate, d, r;
} saltus_text_stop;

/* The contents of a text, owned by the caller and copied. Left sides: "x"; "x[i]" and "x[1]" for families;
 * for masses "x1" or, for a matrix entry, "x1,x2". */
typedef struct saltus_text {
    const char *origin; /* file name for messages */
    const char *scene;  /* file with the stops and the initial state; NULL: the same */
    const char *source; /* what represents the model in files: see saltus_model_text */
    const saltus_text_parameter *parameters;
    int parameter_count;
    const saltus_text_constant *constants;
    int constant_count;
    const saltus_text_stop *stops;
    int stop_count;
    saltus_equation_list families, let, motion, mass, states, observe, scale, initial;
    /* The section; the text of `zero` is its expression, or NULL. Stops count from 0. */
    saltus_poincare poincare;
    saltus_equation zero;
    saltus_equation forcing; /* its text is the parameter's name; NULL: no forcing */
} saltus_text;

/* Allocate zeroed memory that lives as long as the list; NULL: no memory. */
void *saltus_text_keep(saltus_list *owned, size_t count, size_t size);
/* Free all memory of the list, which is empty afterwards. */
void saltus_text_release(saltus_list *owned);

/* Make a model, to be released once. All names and expressions are checked with the default parameters.
 * Errors: SALTUS_BAD_INPUT, with the line, and SALTUS_NO_MEMORY. */
saltus_status saltus_text_model_new(const saltus_text *text, const saltus_model **model,
                                    saltus_message *message);
/* The value of an expression of numbers and pi. Errors: SALTUS_BAD_INPUT, SALTUS_NO_MEMORY. */
saltus_status saltus_constant_value(const char *text, double *value, saltus_message *message);

#endif
