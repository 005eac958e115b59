/* Private: models from text. Equations with names (shared/text in the manual: saltus-text) become a model
 * that the rest of the library cannot tell from a built-in one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SALTUS_SYSTEM_TEXT_H
#define SALTUS_SYSTEM_TEXT_H

#include "base/memory.h"
#include "saltus/system.h"

/* Names in texts are at most one byte shorter. */
enum { SALTUS_NAME_MAX = 32 };

/* A name with what it is: the left and the right side of an equation. `line` is where it stands, for
 * messages; 0: unknown. */
typedef struct saltus_equation {
    const char *name, *text;
    int line;
} saltus_equation;

typedef struct saltus_equation_list {
    const saltus_equation *items;
    int count;
} saltus_equation_list;

typedef struct saltus_text_parameter {
    const char *name, *meaning; /* NULL: no meaning was given */
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

/* Where a stop acts. The texts of d and r are NULL where numbers do, those of saltus_stop. */
typedef struct saltus_text_stop {
    saltus_equation coordinate, d, r;
} saltus_text_stop;

/* All that a text says of a system; everything is the caller's and copied. Left sides: "x", "x[i]" and "x[1]"
 * of a family; of masses "x1" or, for an entry of a matrix, "x1,x2". */
typedef struct saltus_text {
    const char *origin; /* the file, for messages */
    const char *scene;  /* the one that stops and initial stand in; NULL: the same */
    const char *source; /* what the model is known by in files: see saltus_model_text */
    const saltus_text_parameter *parameters;
    int parameter_count;
    const saltus_text_constant *constants;
    int constant_count;
    const saltus_text_stop *stops;
    int stop_count;
    saltus_equation_list families, let, motion, mass, states, observe, scale, initial;
    /* What `section` says: the text of `zero` is an expression, or NULL; stops count from 0. */
    saltus_poincare poincare;
    saltus_equation zero;
    saltus_equation forcing; /* its text is the parameter's name; NULL: autonomous */
} saltus_text;

/* Zeroed memory that lives as long as the list; NULL: there is none. */
void *saltus_text_keep(saltus_list *owned, size_t count, size_t size);
/* Free all of it; the list is empty then. */
void saltus_text_release(saltus_list *owned);

/* Make a model; all names and expressions are checked with the parameters' defaults. Errors: SALTUS_BAD_INPUT
 * with a sentence that tells the line, SALTUS_NO_MEMORY. It is to be released once. */
saltus_status saltus_text_model_new(const saltus_text *text, const saltus_model **model,
                                    saltus_message *message);
/* The value of an expression of numbers and pi. Errors: SALTUS_BAD_INPUT with a sentence, SALTUS_NO_MEMORY.
 */
saltus_status saltus_constant_value(const char *text, double *value, saltus_message *message);

#endif
